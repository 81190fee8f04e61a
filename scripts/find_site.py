"""Where a site of one conformation lies on others."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
from sparsurf.workflow.files_of_sites import refuse_absent

from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_own
from sparsurf.report.page import write
from sparsurf.report.site_page import TEMPLATE, laid_file, site_page
from sparsurf.sites.describing import load_sites, places_of_residues
from sparsurf.sites.finding import find_site, matched
from sparsurf.workflow.jobs import run

MOST = 10  # hits that the query is laid on
POSE = [f"{name}_{k}" for name in ("turn_1", "turn_2", "turn_3", "shift") for k in "xyz"]


def main(inputs, outputs, site, name):
    """Write a row for each target, which places meet, the poses, the page, and the query laid on the best hits."""
    refuse_absent(inputs, "query", name)
    query = load_sites(inputs["query"])
    targets = [load_sites(path) for path in inputs.get("targets", [])]
    if not targets or query.name in {target.name for target in targets}:
        raise InputError(f"sites.{name}: {query.name} is all that would be searched; name other targets.")
    found = find_site(query.take(places_of_residues(query, site["residues"])), targets, len(targets))
    found.table.to_csv(outputs["hits"], index=False)
    pairs = matched(found, targets)
    pairs.to_csv(outputs["matches"], index=False, float_format="%.3f")
    poses = [[*pose.turn.ravel(), *pose.shift] for pose in found.poses]
    poses = pd.concat([found.table[["rank", "target"]], pd.DataFrame(poses, columns=POSE)], axis=1)
    poses.to_csv(outputs["poses"], index=False, float_format="%.6f")
    Path(outputs["superposed"]).mkdir()
    molecule = read_own(inputs["structure"])
    for row, pose in zip(found.table.head(MOST).itertuples(), found.poses, strict=False):
        if not row.places:  # nothing agrees, so that nothing is laid
            continue
        laid = replace(molecule, xyz=molecule.xyz @ pose.turn + pose.shift)
        laid.write_pdb(Path(outputs["superposed"], laid_file(row.rank, row.target)))
    page = site_page(name, site, query.name, found.table, pairs, len(found.places))
    write(outputs["page"], TEMPLATE, **page)


if __name__ == "__main__":
    run(main, snakemake)
