"""What memory and CPU time each rule takes, from the logs of runs: `python evidence/measure_needs.py results/<run> ...`.

Writes src/sparsurf/workflow/needs.csv: per rule a straight line over the size of the input that no job of the runs
lies above. Give runs of small and of large proteins, with the grid of the default study and every frame; rules that
they do not have keep their line, and those with jobs of one size their slope.
"""

import csv
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd

from measures.tables import USED
from sparsurf import InputError
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.needs import TABLE

APART = 2
OF_PROTEIN = ("choose_frames", "follow_frames")


def main(folders, path_to_table=TABLE):
    """Write the table."""
    jobs = pd.DataFrame([job for folder in folders for job in jobs_of(Path(folder))])
    if jobs.empty:
        where = " or ".join(map(str, folders)) or "(no folder given)"
        raise InputError(f"No log of a finished job is in {where}: give results/<run> ...")
    with open(path_to_table, encoding="utf-8", newline="") as stream:
        rows = {row["rule"]: {"jobs": 0} | row for row in csv.DictReader(stream)}
    for rule, found in jobs.groupby("rule"):
        if rule not in rows:
            continue  # runs where Snakemake runs
        row = {"rule": rule, "unit": found["unit"].iloc[0], "jobs": len(found)}
        for name in ("mb", "seconds"):
            known = float(rows[rule][f"{name}_per_unit"])
            base, slope = line_above(found["size"].to_numpy(), found[name].to_numpy(), known)
            row |= {name: f"{base:.3g}", f"{name}_per_unit": f"{slope:.3g}"}
        rows[rule] = row
    columns = ["rule", "unit", "jobs", "mb", "mb_per_unit", "seconds", "seconds_per_unit"]
    pd.DataFrame(rows.values(), columns=columns).to_csv(path_to_table, index=False, lineterminator="\n")
    print(Path(path_to_table).read_text(encoding="utf-8"))


def jobs_of(folder):
    """Rule, size and needs of every job of a run that says what it used."""
    for log in sorted((folder / "logs").rglob("*.log")):
        found = USED.findall(log.read_text(encoding="utf-8"))
        rule, _, parts = re.fullmatch(r"(.*?)(_\d+of(\d+))?", log.stem).groups(default="1")
        place = log.relative_to(folder / "logs").parts[:-1]
        surface = folder.joinpath(*place, "surface.npz")
        if not found or not (rule in OF_PROTEIN or surface.is_file()):
            continue  # of a killed job, or of a rule that asks for nothing
        megabytes, seconds, given = map(float, found[-1])
        if rule in OF_PROTEIN:
            size, unit = given, "MB of input"
        else:
            size, unit = len(read_surface(surface)) / 1000, "thousand dots"
        yield {"rule": rule, "unit": unit, "size": size, "mb": megabytes, "seconds": seconds * int(parts)}


def line_above(x, y, known):
    """Base and slope of a line that lies above all points, both at least 0.

    The slope is that of a fit; sizes `x` within a factor of `APART` tell none, and the `known` one stays.
    """
    slope = max(0.0, np.polyfit(x, y, 1)[0]) if x.max() >= APART * x.min() else known
    return max(0.0, float((y - slope * x).max())), float(slope)


if __name__ == "__main__":
    try:
        main(sys.argv[1:])
    except InputError as error:
        sys.exit(str(error))
