"""Errors of the surfaces reconstructed from few dots by the interpolant and by the spheres of the dots, on independent dots."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy.sparse import coo_matrix
from scipy.sparse.csgraph import connected_components

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.law import fitted
from measures.molecules import first_model
from measures.tables import write_tables
from sparsurf.evaluation.minimal_subset import represent
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.evaluation.trials import Trials
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, TAIL_QUANTILE, distance_to_surface
from sparsurf.recovery.reconstructing import AUTO, DENSITY_FOR_SPHERES, INTERPOLANT, SPHERES, reconstruct
from sparsurf.settings import TAIL_PER_ERROR, Minimal, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.grid_mesh import mesh_of_dense
from sparsurf.surfaces.molecular_surface import RolledFrame
from sparsurf.surfaces.surface import CONTACT, Surface

FARTHEST, COVER = "farthest", "cover"
MODELS = (INTERPOLANT, SPHERES)
ATOMS = "atoms"  # in the columns sampler and model: what is stored in place of dots
PDB_DECIMALS = 3
ERRORS = ("mean", "high_99", "largest", "back_99", "back_largest")
SHAPES = ("area_change", "volume_change", "parts", "parts_true", "handles", "handles_true")
STEP = 0.4  # Å, of the grid of the meshes from which `SHAPES` are counted
KEYS = ["group", "sampler", "model", "requested"]
AN_ERROR = "error "  # how `requested` begins where dots are kept for a mean error


def errors_of(
    surface: Surface,
    densities: Sequence[float],
    of_cover: Sequence[float],
    requested_errors: Sequence[float],
    streams: Streams,
    more: bool = False,
) -> Iterator[dict]:
    """Measure the errors of one surface: rows with sampler, model, requested (dots per Å^2, or 'error'), density and `ERRORS`.

    The errors are distances (Å) of independent dots of the whole surface to the reconstructed one: mean, 99 % and largest; and
    exact distances of the dots of the reconstructed surface from the true one (back). `SHAPES` are compared for chosen dots by
    the spheres. `more` adds those of all other rows and the errors of the atoms.
    """
    prepared = PreparedSurface(surface, Settings(), None, streams)
    trials = {
        sampler: Trials(prepared, sampler, 2, model=AUTO, atoms=surface.origin)
        for sampler in (FARTHEST, COVER)
    }
    test, true = trials[FARTHEST].test_surface, trials[FARTHEST].rolled
    assert test is not None and true is not None
    dense = true.surface(DENSITY_FOR_SPHERES)
    true_shape = shape_of(dense.points, dense.normals)

    def rows(sampler: str, requested: float | str, dots: np.ndarray, models: Sequence[str]) -> Iterator[dict]:
        few = trials[sampler].few(dots)
        for model in models:
            density = DENSITY_FOR_ERRORS if model == INTERPOLANT else DENSITY_FOR_SPHERES
            found = reconstruct(few, density, model if model == INTERPOLANT else AUTO)
            row = {"sampler": sampler, "model": model, "requested": requested}
            row |= {"density": len(dots) / prepared.area, "share": found.share}
            if more or (sampler, model) == (COVER, SPHERES):
                row |= compared(shape_of(found.points, found.normals), true_shape)
            yield row | errors_both_ways((test.points, test.normals), found.points, found.normals, true)

    for density in densities:
        dots = trials[FARTHEST].draw(round(density * prepared.area))
        yield from rows(FARTHEST, density, dots, MODELS)
    for density in of_cover:
        yield from rows(COVER, density, trials[COVER].draw(round(density * prepared.area)), MODELS)
    for error in requested_errors:
        settings = Settings(minimal=Minimal(error=error))
        few = represent(surface, settings, streams, surface.molecule).subset
        yield from rows(few.sampler, f"{AN_ERROR}{error:g}", few.dots, [few.reconstruction])
    if more:
        yield errors_of_atoms(surface, test, true)


def errors_of_atoms(surface: Surface, test: Surface, true: RolledFrame) -> dict:
    """Measure the surface of all atoms as a PDB file stores them, a row like those of `errors_of`: what the measurement adds.

    The probe rolls over all atoms; the density is that of the exposed ones.
    """
    origin = surface.origin
    assert origin is not None
    exposed = np.unique(surface.atom[surface.kind == CONTACT])
    of_atoms = sparsurf.surface((origin.xyz.round(PDB_DECIMALS), origin.radii), density=DENSITY_FOR_SPHERES)
    row = {"sampler": ATOMS, "model": ATOMS, "requested": ATOMS, "density": len(exposed) / surface.area.sum()}
    return row | errors_both_ways((test.points, test.normals), of_atoms.points, of_atoms.normals, true)


class Shape(NamedTuple):
    """Area (Å^2), volume (Å^3), connected parts and handles of a closed mesh."""

    area: float
    volume: float
    parts: int
    handles: int


def shape_of(points: np.ndarray, normals: np.ndarray) -> Shape:
    """Count the parts and handles of the mesh through dense dots."""
    mesh = mesh_of_dense(points, normals, STEP)
    n, sides = len(mesh.vertices), mesh.triangles[:, [0, 1, 1, 2]].reshape(-1, 2)
    links = coo_matrix((np.ones(len(sides)), sides.T), shape=(n, n))
    parts = connected_components(links, directed=False)[0]
    # Euler's number is two for each part, less two for each handle; a triangle has half of three edges
    return Shape(mesh.area, mesh.volume, parts, parts - (n - len(mesh.triangles) // 2) // 2)


def compared(found: Shape, true: Shape) -> dict[str, float]:
    """Compare the shape of a reconstructed surface with the true one: `SHAPES`, changes in %."""
    changes = (100 * (found.area / true.area - 1), 100 * (found.volume / true.volume - 1))
    return dict(zip(SHAPES, (*changes, found.parts, true.parts, found.handles, true.handles), strict=True))


def errors_both_ways(
    test: tuple[np.ndarray, np.ndarray],
    points: np.ndarray,
    normals: np.ndarray,
    true: RolledFrame | None = None,
) -> dict[str, float]:
    """Measure the distances (Å) of independent dots from a surface, and of the surface from that of these dots: `ERRORS`.

    They are exact if the spheres below the independent dots are known, `true`; else from planes of the nearest dots.
    """
    there = distance_to_surface(test[0], points, normals, true=true)
    exact = true is not None and true.exact
    back = np.abs(exact_distance(points, true)) if exact else distance_to_surface(points, *test)
    errors = [there.mean(), np.quantile(there, TAIL_QUANTILE), there.max()]
    errors += [np.quantile(back, TAIL_QUANTILE), back.max()]
    return dict(zip(ERRORS, map(float, errors), strict=True))


def surfaces(params: Any, title: str) -> Iterator[tuple[str, Surface, Streams]]:
    """Yield the name of each structure that can be read, its surface and its random streams; report the progress."""
    progress = reporter(title, "surfaces")
    for k, (name, path) in enumerate(params.structures.items()):
        molecule = first_model(name, path, params.hydrogens)
        if molecule is not None:
            yield name, sparsurf.surface(molecule), Streams(params.seed, f"spheres {name}")
            progress(k + 1, len(params.structures))


def measure_spheres(job: Job) -> None:
    """Measure the errors of several structures of one group."""
    params, found = job.params, []
    for name, surface, streams in surfaces(params, "Spheres"):
        known = {"group": params.group, "structure": name, "atoms": surface.molecule.n_atoms}
        known["area"] = surface.area.sum()
        more = name in params.measured_more
        densities = sorted([*params.densities, *(params.more_densities if more else [])])
        requested = params.of_cover, params.requested_errors
        rows = errors_of(surface, densities, *requested, streams, more)
        found += [known | row for row in rows]
        pd.DataFrame(found).to_csv(job.output.errors, index=False)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the errors over the structures of a group.

    Returns
    -------
    DataFrame: group, sampler, model, requested, n (structures), fewest_atoms and most_atoms, density; of each error in Å, and of
    each of `SHAPES` its mean over structures, the 95 % interval of that (_low, _high), and its highest (_highest); where dots
    were kept for an error, n_beyond, the structures on which 99 % either way exceeds its limit, and beyond, the most, % of it
    """
    out = []
    for keys, part in table.groupby(KEYS, sort=False):
        row = dict(zip(KEYS, keys, strict=True)) | {"n": len(part)}
        row |= {"fewest_atoms": part["atoms"].min(), "most_atoms": part["atoms"].max()}
        row["density"] = part["density"].mean()
        for name in (name for name in (*ERRORS, *SHAPES) if name in table):
            known = part[name].dropna()
            if known.empty:
                continue
            of_structures = estimate(known.to_numpy()[None])
            row |= {
                name: of_structures.mean,
                f"{name}_low": of_structures.low,
                f"{name}_high": of_structures.high,
            }
            row[f"{name}_highest"] = part[name].max()
        if str(row["requested"]).startswith(AN_ERROR):
            limit = TAIL_PER_ERROR * float(row["requested"].removeprefix(AN_ERROR))
            beyond = 100 * (part[["high_99", "back_99"]].max(axis=1) / limit - 1)
            row |= {"n_beyond": int((beyond > 0).sum()), "beyond": max(0.0, beyond.max())}
        out.append(row)
    return pd.DataFrame(out)


def predictions(table: pd.DataFrame) -> pd.DataFrame:
    """Fit the errors of every second structure at each two neighbouring densities, and predict those of the others.

    Returns
    -------
    DataFrame: group, model, error, low and high (dots per Å^2), exponent, C, n_predicted, and residual_percent, the standard
    deviation of the logarithm of measured over predicted error
    """
    out, spread = [], table[table["sampler"] == FARTHEST]
    spread = spread.assign(requested=pd.to_numeric(spread["requested"], errors="coerce"))
    spread = spread.dropna(subset=["requested"])  # without those of a requested error
    for (group, model), part in spread.groupby(["group", "model"], sort=False):
        half = part["structure"].isin(list(dict.fromkeys(part["structure"]))[::2])
        requested = np.unique(part["requested"])
        for low, high in pairwise(requested):
            here = part["requested"].isin([low, high])
            for error in ("mean", "high_99"):
                known, others = part[half & here], part[~half & here]
                c, exponent = fitted(known["density"].to_numpy(), known[error].to_numpy())
                row = {"group": group, "model": model, "error": error, "low": low, "high": high}
                row |= {"exponent": exponent, "C": c, "n_predicted": others["structure"].nunique()}
                ratio = others[error] * others["density"] ** exponent / c
                out.append(row | {"residual_percent": 100 * np.log(ratio).std()})
    return pd.DataFrame(out)


def tabulate_spheres(job: Job) -> None:
    """Tabulate the errors of both models."""
    table, out = pd.concat([pd.read_csv(path) for path in job.input.errors], ignore_index=True), job.output
    write_tables({out.table: table, out.means: means(table), out.predictions: predictions(table)})
