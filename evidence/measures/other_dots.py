"""Whether the spheres harm dots that do not lie on them, or not exactly: noise, other programs, probes, radii and surfaces."""

from collections.abc import Callable, Iterator

import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.molecules import first_model
from measures.points import msms, msms_program
from measures.spheres import ERRORS, errors_both_ways
from measures.tables import write_tables
from sparsurf.patches.index import build_grid
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.recovery.reconstructing import DENSITY_FOR_SPHERES
from sparsurf.recovery.spheres.rebuilding import rebuild
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.surfaces.molecular_surface import RolledFrame, rolled_atoms
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.surface import Surface

Dots = tuple[np.ndarray, np.ndarray]  # points (Å) and normals, (n, 3)
DENSITY_OF_MSMS = 5.0  # vertices per Å^2
TEST_DENSITY = 8.0  # dots per Å^2 on which errors are measured
DECIMALS = 4  # of a file
WAVE, PERIOD = 0.3, 2.5  # Å, by which a wavy surface leaves the molecular one, and radian^-1 Å of its waves
DECAY, SQUARED_RADIUS, ATOMS_OF_LEVEL = (
    2.35,
    3.2,
    40,
)  # of Gaussian functions at the atoms, whose sum is 1 on the surface
LEVEL_STEPS, LONGEST_STEP, OFF_LEVEL = 12, 0.2, 1e-3


def wavy(surface: Surface) -> Dots:
    """Move dots along their normals by a smooth wave, and tilt the normals as its gradient says."""
    phase, normals = surface.points / PERIOD, surface.normals
    height = WAVE * np.sin(phase).prod(axis=1)
    slope = [np.cos(phase[:, k]) * np.delete(np.sin(phase), k, axis=1).prod(axis=1) for k in range(3)]
    gradient = WAVE / PERIOD * np.stack(slope, axis=1)
    gradient -= np.einsum("ij,ij->i", gradient, normals)[:, None] * normals
    outward = normals - gradient
    return surface.points + height[:, None] * normals, outward / np.linalg.norm(outward, axis=1)[:, None]


def gaussian(surface: Surface) -> Dots:
    """Move dots onto the level of a sum of Gaussian functions at the atoms; those that do not reach it are left out."""
    from scipy.spatial import cKDTree

    atoms, place = surface.origin.xyz, surface.points.copy()
    tree = cKDTree(atoms)
    for _ in range(LEVEL_STEPS):
        distance, near = tree.query(place, k=min(ATOMS_OF_LEVEL, len(atoms)))
        weight = np.exp(-DECAY * (distance**2 / SQUARED_RADIUS - 1))
        value = weight.sum(axis=1)
        gradient = (
            -2 * DECAY / SQUARED_RADIUS * (weight[:, :, None] * (place[:, None] - atoms[near])).sum(axis=1)
        )
        size = np.linalg.norm(gradient, axis=1, keepdims=True)
        on_level = np.abs(value - 1) < OFF_LEVEL
        place = place - np.clip((value - 1)[:, None] / size**2 * gradient, -LONGEST_STEP, LONGEST_STEP)
    return place[on_level], (-gradient / size)[on_level]


def noisy(angstrom: float = 0.0, degrees: float = 0.0) -> Callable[[Dots, np.random.Generator], Dots]:
    """Return a function that adds noise to positions (Å) and normals (degrees)."""

    def change(dots: Dots, rng: np.random.Generator) -> Dots:
        points, normals = dots
        points = points + rng.normal(0, angstrom, points.shape)
        normals = normals + rng.normal(0, np.radians(degrees), normals.shape)
        return points, normals / np.linalg.norm(normals, axis=1)[:, None]

    return change


NOISE = {
    "exact": noisy(),
    "positions ± 0.01 Å": noisy(angstrom=0.01),
    "positions ± 0.05 Å": noisy(angstrom=0.05),
    "positions ± 0.1 Å": noisy(angstrom=0.1),
    "normals ± 1°": noisy(degrees=1),
    "normals ± 5°": noisy(degrees=5),
}
PLACED = {
    "probe of 1.2 Å": {"probe_radius": 1.2},
    "probe of 1.5 Å": {"probe_radius": 1.5},
    "radii of Bondi": {"radii": "bondi"},
    "placed as DMS does": {"reentrant": "dms"},
}
SHAPES = {"wavy": wavy, "Gaussian": gaussian}


def kinds_of_dots(molecule: sparsurf.Molecule) -> Iterator[tuple[str, Dots, Dots, float, RolledFrame | None]]:
    """Yield each kind of dots: name, dots to choose from, independent dots, area (Å^2), and the spheres that these lie on."""

    def pair(**rules: object) -> tuple[Surface, Surface]:
        return sparsurf.surface(molecule, **rules), sparsurf.surface(molecule, density=TEST_DENSITY, **rules)

    dots, test = pair()
    area, of_test, true = dots.area.sum(), (test.points, test.normals), rolled_atoms(dots.origin)
    for kind in NOISE:
        yield kind, (dots.points, dots.normals), of_test, area, true
    for kind, rules in PLACED.items():
        placed, fresh = pair(**rules)
        of_fresh = fresh.points, fresh.normals
        yield kind, (placed.points, placed.normals), of_fresh, placed.area.sum(), rolled_atoms(placed.origin)
    for kind, function in SHAPES.items():
        yield kind, function(dots), function(test), area, None
    if msms_program():
        points, normals, _, _ = msms(molecule.xyz[0], np.asarray(radii_of(molecule, "dms")), DENSITY_OF_MSMS)
        yield "MSMS", (points, normals), of_test, area, true


def measure_other_dots(job: Job) -> None:
    """Compare what `recover` does with each kind of dots, told nothing about them, with the interpolant."""
    params, found, progress = job.params, [], reporter("Other dots", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = first_model(name, path)
        if molecule is None:
            continue
        for kind, full, test, area, true in kinds_of_dots(molecule):
            for density in params.densities:
                rng = np.random.default_rng(params.seed)
                few = farthest_point_sampling(build_grid(*full), round(density * area), rng)
                points, normals = NOISE.get(kind, noisy())((full[0][few], full[1][few]), rng)
                points, normals = points.round(DECIMALS), normals.round(DECIMALS)
                rebuilt = rebuild(points, normals, DENSITY_FOR_SPHERES)
                row = {"structure": name, "dots": kind, "density": density, "share": rebuilt.share}
                row |= {"probe_radius": rebuilt.model.probe, "radii": rebuilt.model.table}
                guide = interpolate_surface(
                    points, normals, DENSITY_FOR_SPHERES if rebuilt.share == 0 else DENSITY_FOR_ERRORS
                )
                errors = errors_both_ways(test, *guide, true)
                row |= {f"interpolant_{error}": errors[error] for error in ERRORS}
                if rebuilt.share > 0:
                    errors = errors_both_ways(test, rebuilt.points, rebuilt.normals, true)
                found.append(row | errors)
        progress(k, len(params.structures))
    table = pd.DataFrame(found)
    write_tables({job.output.table: table, job.output.means: means(table)})


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the errors of each kind of dots over the structures.

    Returns
    -------
    DataFrame: dots, density, n, share of the dots on inferred spheres, errors of the interpolant (Å), those of `recover`, and how
    much worse it is at most: mean_ratio, high_99_ratio, and largest_difference (Å), over the structures
    """
    out = []
    for (kind, density), part in table.groupby(["dots", "density"], sort=False):
        row = {"dots": kind, "density": density, "n": len(part), "share": part["share"].mean()}
        row |= {name: part[name].mean() for error in ERRORS for name in (f"interpolant_{error}", error)}
        row |= {
            f"{error}_ratio": (part[error] / part[f"interpolant_{error}"]).max()
            for error in ("mean", "high_99")
        }
        row["largest_difference"] = (part["largest"] - part["interpolant_largest"]).max()
        out.append(row)
    return pd.DataFrame(out)
