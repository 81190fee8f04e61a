"""Handles and volumes of whole surfaces: exact, by grids between dots, by the triangles of MSMS, and by sums over dots."""

import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.meshes import MSMS, by_msms, exact_surface, is_closed, number_of_parts
from measures.points import msms_program
from measures.tables import write_tables
from sparsurf.errors import InputError
from sparsurf.surfaces.grid_mesh import mesh_of_dense
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spheres import write_spheres

EXACT = "exact"


def handles_of(triangles: np.ndarray) -> float:
    """Return the number of handles of a mesh; NaN where it is not closed."""
    if not is_closed(triangles):
        return np.nan
    n = len(np.unique(triangles))
    return number_of_parts(triangles) - (n - len(triangles) / 2) / 2


def of_structure(molecule: sparsurf.Molecule, steps: list[float], density: float) -> dict[str, float]:
    """Count the handles of one structure, and compare its volumes.

    Returns
    -------
    dict: exact, grid_STEP for each step of a grid, Å, and MSMS (numbers of handles; NaN where a mesh is not closed, or where MSMS
    fails), volume (exact, Å^3), and dots_percent (by how much the volume by a sum over dots is larger)
    """
    xyz, sizes = molecule.xyz[0].round(3), radii(molecule)
    exact = exact_surface(xyz, sizes)
    dots = sparsurf.surface((xyz, sizes), cavities="keep")
    by_dots = dots.area @ ((dots.points - xyz.mean(axis=0)) * dots.normals).sum(axis=1) / 3
    row = {EXACT: exact.handles, "volume": exact.volume, "dots_percent": 100 * (by_dots / exact.volume - 1)}
    for step in steps:
        row[f"grid_{step}"] = handles_of(mesh_of_dense(dots.points, dots.normals, step).triangles)
    if msms_program():
        with tempfile.TemporaryDirectory() as folder:
            write_spheres(Path(folder, "atoms.xyzr"), xyz, sizes)
            try:
                row[MSMS] = handles_of(by_msms(folder, density)[0][1])
            except (subprocess.SubprocessError, OSError, ValueError):
                row[MSMS] = np.nan
    return row


def measure_handles(job: Job) -> None:
    """Count the handles of many structures."""
    params, rows = job.params, []
    progress = reporter("Handles", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        try:
            molecule = sparsurf.read_molecule(path, model=1, hydrogens="remove")
        except InputError as error:
            print(f"{name} is left out: {error}")
            continue
        row = of_structure(molecule, params.steps, params.density)
        rows.append({"structure": name, "atoms": molecule.n_atoms} | row)
        progress(k, len(params.structures))
    table = pd.DataFrame(rows)
    write_tables({job.output.table: table, job.output.means: means(table)})


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Compare the ways to count over the structures.

    Returns
    -------
    DataFrame: way, n (structures with a closed mesh), right (of them, those with the exact number), fewer and more (than the
    exact number), largest (difference), handles (in all); and a row `dots` with the mean (mean_percent), lowest and highest
    excess of the volume by dots, %
    """
    rows: list[dict[str, object]] = []
    for way in [name for name in table if name.startswith("grid_") or name in (EXACT, MSMS)]:
        counted = table[way].dropna()
        excess = counted - table[EXACT][counted.index]
        rows.append(
            {
                "way": way, "n": len(counted), "right": int((excess == 0).sum()), "fewer": int((excess < 0).sum()),
                "more": int((excess > 0).sum()), "largest": excess.abs().max(), "handles": counted.sum(),
            }
        )  # fmt: skip
    percent = table["dots_percent"]
    ends = {"mean_percent": percent.mean(), "lowest": percent.min(), "highest": percent.max()}
    return pd.DataFrame([*rows, {"way": "dots", "n": len(percent)} | ends])
