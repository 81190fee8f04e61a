"""Our potential and that of APBS, as MaSIF computes the channel `charge` of its files, at the vertices of our meshes.

MaSIF (Gainza et al., Nat. Methods 17:184, 2020) runs pdb2pqr with the charges and radii of PARSE, APBS with the input that
pdb2pqr writes, and interpolates between the points of its grid; the channel is a tenth of the potential in kT/e.
"""

import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.ndimage import map_coordinates
from scipy.stats import spearmanr

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.molecules import first_model
from measures.tables import write_tables

DENSITY_OF_MASIF = 1.0  # vertices per Å^2
OF_CHANNEL, LIMIT = (
    10.0,
    3.0,
)  # by which MaSIF divides the potential, and where both of its readers clip the channel
LONGEST_RUN = 1800  # s
COLUMNS = ["vertices", "correlation", "correlation_clipped", "rank_correlation", "beyond", "beyond_apbs"]


def programs() -> tuple[str, str] | None:
    """Return the paths of pdb2pqr and APBS; None if one is not installed."""
    pdb2pqr, apbs = shutil.which("pdb2pqr30") or shutil.which("pdb2pqr"), shutil.which("apbs")
    return (pdb2pqr, apbs) if pdb2pqr and apbs else None


def potential_of_apbs(molecule: sparsurf.Molecule, points: np.ndarray) -> np.ndarray:
    """Compute the potential at points (N, 3), (N,) kT/e, by the calls of MaSIF."""
    pdb2pqr, apbs = programs() or ("pdb2pqr30", "apbs")
    with tempfile.TemporaryDirectory() as folder:
        molecule.write_pdb(Path(folder, "a.pdb"))
        options = {"cwd": folder, "check": True, "capture_output": True, "timeout": LONGEST_RUN}
        words = ["--ff=PARSE", "--whitespace", "--noopt", "--apbs-input=a.in", "a.pdb", "a.pqr"]
        subprocess.run([pdb2pqr, *words], **options)
        subprocess.run([apbs, "a.in"], **options)
        grid = next(Path(folder).glob("*.dx"))
        origin, step, values = read_grid(grid.read_text())
    return map_coordinates(values, ((points - origin) / step).T, order=1)


def read_grid(text: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the origin and the steps (3,), Å, and the values of a grid in OpenDX's format."""
    head, _, rest = text.partition("data follows\n")
    lines = [line.split() for line in head.splitlines() if not line.startswith("#")]
    counts = next([int(word) for word in row[-3:]] for row in lines if "gridpositions" in row)
    origin = next(np.array(row[1:], float) for row in lines if row[0] == "origin")
    step = np.diag([[float(word) for word in row[1:]] for row in lines if row[0] == "delta"])
    values = np.array(rest.partition("attribute")[0].split(), float)
    return origin, step, values.reshape(counts)


def measure_potential(job: Job) -> None:
    """Correlate our potential with that of APBS; without pdb2pqr and APBS, the columns that need them are empty."""
    params, found, progress = job.params, {}, reporter("Potential", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = first_model(name, path)
        if molecule is None:
            continue
        vertices = sparsurf.mesh(molecule, density=DENSITY_OF_MASIF, fields="potential").vertices
        ours = vertices.fields["potential"] / OF_CHANNEL
        found[name] = {"vertices": len(ours), "beyond": (np.abs(ours) > LIMIT).mean()}
        if programs():
            theirs = potential_of_apbs(molecule, vertices.points) / OF_CHANNEL
            clipped = np.clip(ours, -LIMIT, LIMIT), np.clip(theirs, -LIMIT, LIMIT)
            found[name] |= {
                "correlation": np.corrcoef(ours, theirs)[0, 1],
                "correlation_clipped": np.corrcoef(*clipped)[0, 1],
                "rank_correlation": spearmanr(ours, theirs)[0],
                "beyond_apbs": (np.abs(theirs) > LIMIT).mean(),
            }
        progress(k, len(params.structures))
    table = pd.DataFrame.from_dict(found, orient="index").reindex(columns=COLUMNS)
    ends = pd.DataFrame({"smallest": table.min(), "largest": table.max()}).T
    table = pd.concat([table, ends]).rename_axis("structure").reset_index()
    write_tables({job.output.table: table})
