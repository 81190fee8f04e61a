"""Why the error is inversely proportional to the density of the dots: pieces of spheres and tori, seams and creases."""

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from sparsurf_study.workflow.jobs import Job, reporter
from measures.molecules import first_model
from measures.tables import write_tables
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.surface import CONTACT

DENSITY = 8.0  # dots per Å^2, from which shares are measured
CONCAVE = 2  # kind of the dots where the probe touches three atoms
CREASE, MAX_COSINE = (
    0.7,
    0.5,
)  # Å and cosine: a dot lies at a crease if the normal turns by more than 60° so near
SHARES = ["concave_share", "crease_share"]
PROBE_RADIUS = 1.4  # Å


def reasons_of(xyz: np.ndarray, radii: np.ndarray) -> dict[str, float]:
    """Measure the surface of atoms (A, 3), Å.

    Returns
    -------
    dict: pieces_per_area, spheres and tori that the surface consists of, per Å^2; concave_share, of its area, where the probe
    touches three atoms; crease_share, of its dots, from which the normal turns by more than 60° within 0.7 Å
    """
    frame = roll_spheres(xyz, radii, PROBE_RADIUS)
    surface = frame.surface(DENSITY)
    rolling = frame.rolling
    exposed = len(np.unique(surface.atom[surface.kind == CONTACT]))
    pairs = cKDTree(surface.points).query_pairs(CREASE, output_type="ndarray")
    turns = np.einsum("ij,ij->i", surface.normals[pairs[:, 0]], surface.normals[pairs[:, 1]]) < MAX_COSINE
    at_crease = np.unique(pairs[turns])
    area = surface.area.sum()
    return {
        "pieces_per_area": (exposed + len(rolling.arcs) + len(rolling.probes)) / area,
        "concave_share": surface.area[surface.kind == CONCAVE].sum() / area,
        "crease_share": len(at_crease) / len(surface),
    }


def measure_reasons(job: Job) -> None:
    """Measure the pieces, seams and creases of chains whose errors were measured, and fit the constant of the law to them."""
    params, found, progress = job.params, [], reporter("Reasons of the law", "chains")
    errors = pd.read_csv(job.input.errors).query("group == 'chains' and requested == @params.density")
    constants = (errors["mean"] * errors["density"]).set_axis(errors["structure"])
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = first_model(name, path) if name in constants else None
        if molecule is not None:
            of_surface = reasons_of(molecule.xyz[0], np.asarray(radii_of(molecule, "dms")))
            found.append({"structure": name, "C": constants[name], **of_surface})
        progress(k, len(params.structures))
    table = pd.DataFrame(found)
    write_tables({job.output.table: table, job.output.fit: fit(table)})


def fit(table: pd.DataFrame) -> pd.DataFrame:
    """Fit C to the shares by least squares, and to a constant, and predict each chain from the others.

    Returns
    -------
    DataFrame: predictors, n, constant, a column for the slope of each share, r_squared, residual_percent (standard deviation of
    the chains that were left out, over the mean of C), pieces_per_area (mean)
    """
    measured, rows = table["C"].to_numpy(), []
    for names in ([], SHARES):
        columns = np.column_stack([np.ones(len(table)), *(table[name] for name in names)])
        weights, *_ = np.linalg.lstsq(columns, measured, rcond=None)
        hat = np.einsum("ij,ij->i", columns @ np.linalg.pinv(columns.T @ columns), columns)
        residual = measured - columns @ weights
        row = {"predictors": " and ".join(names) or "none", "n": len(table), "constant": weights[0]}
        row |= dict.fromkeys(SHARES, np.nan) | dict(zip(names, weights[1:], strict=True))
        row["r_squared"] = 1 - (residual**2).sum() / ((measured - measured.mean()) ** 2).sum()
        row["residual_percent"] = 100 * (residual / (1 - hat)).std() / measured.mean()
        rows.append(row | {"pieces_per_area": table["pieces_per_area"].mean()})
    return pd.DataFrame(rows)
