"""Errors of the surfaces reconstructed from few dots by the interpolant and by the spheres of the dots, on independent dots."""

from collections.abc import Iterator, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

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
from sparsurf.settings import Minimal, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import CONTACT, Surface

FARTHEST, COVER = "farthest", "cover"
MODELS = (INTERPOLANT, SPHERES)
ATOMS = "atoms"  # in the columns sampler and model: what is stored in place of dots
PDB_DECIMALS = 3
ERRORS = ("mean", "high_99", "largest", "back_99", "back_largest")
KEYS = ["group", "sampler", "model", "requested"]


def errors_of(
    surface: Surface,
    densities: Sequence[float],
    of_cover: Sequence[float],
    requested_errors: Sequence[float],
    streams: Streams,
    with_atoms: bool = False,
) -> Iterator[dict]:
    """Measure the errors of one surface: rows with sampler, model, requested (dots per Å^2, or 'error'), density and `ERRORS`.

    The errors are distances (Å) of independent dots of the whole surface to the reconstructed one: mean, 99 % and largest; and of
    the reconstructed surface to these dots (back).
    """
    prepared = PreparedSurface(surface, Settings(), None, streams)
    trials = {
        sampler: Trials(prepared, sampler, 2, model=AUTO, atoms=surface.origin)
        for sampler in (FARTHEST, COVER)
    }
    test = trials[FARTHEST].test_surface

    def rows(sampler: str, requested: float | str, dots: np.ndarray, models: Sequence[str]) -> Iterator[dict]:
        few = trials[sampler].few(dots)
        for model in models:
            density = DENSITY_FOR_ERRORS if model == INTERPOLANT else DENSITY_FOR_SPHERES
            points, normals, share = reconstruct(few, density, model if model == INTERPOLANT else AUTO)
            row = {"sampler": sampler, "model": model, "requested": requested}
            row |= {"density": len(dots) / prepared.area, "share": share}
            yield row | errors_both_ways((test.points, test.normals), points, normals)

    for density in densities:
        dots = trials[FARTHEST].draw(round(density * prepared.area))
        yield from rows(FARTHEST, density, dots, MODELS)
    for density in of_cover:
        yield from rows(COVER, density, trials[COVER].draw(round(density * prepared.area)), MODELS)
    for error in requested_errors:
        settings = Settings(minimal=Minimal(error=error))
        few = represent(surface, settings, streams, surface.molecule).subset
        yield from rows(few.sampler, f"error {error:g}", few.dots, [few.model])
    if with_atoms:
        yield errors_of_atoms(surface, test)


def errors_of_atoms(surface: Surface, test: Surface) -> dict:
    """Measure the surface of the atoms as a PDB file stores them, a row like those of `errors_of`: what the measurement adds."""
    origin = surface.origin
    assert origin is not None
    exposed = np.unique(surface.atom[surface.kind == CONTACT])
    of_atoms = sparsurf.surface((origin.xyz.round(PDB_DECIMALS), origin.radii), density=DENSITY_FOR_SPHERES)
    row = {"sampler": ATOMS, "model": ATOMS, "requested": ATOMS, "density": len(exposed) / surface.area.sum()}
    return row | errors_both_ways((test.points, test.normals), of_atoms.points, of_atoms.normals)


def errors_both_ways(
    test: tuple[np.ndarray, np.ndarray], points: np.ndarray, normals: np.ndarray
) -> dict[str, float]:
    """Measure the distances (Å) of independent dots from a surface, and of the surface from these: `ERRORS`."""
    there = distance_to_surface(test[0], points, normals)
    back = distance_to_surface(points, *test)
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
        rows = errors_of(surface, densities, params.of_cover, params.requested_errors, streams, more)
        found += [known | row for row in rows]
        pd.DataFrame(found).to_csv(job.output.errors, index=False)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the errors over the structures of a group.

    Returns
    -------
    DataFrame: group, sampler, model, requested, n (structures), density; of each error in Å its mean over structures, the 95 %
    interval of that (_low, _high), and its highest (_highest)
    """
    out = []
    for keys, part in table.groupby(KEYS, sort=False):
        row = dict(zip(KEYS, keys, strict=True)) | {"n": len(part), "density": part["density"].mean()}
        for name in ERRORS:
            of_structures = estimate(part[name].to_numpy()[None])
            row |= {
                name: of_structures.mean,
                f"{name}_low": of_structures.low,
                f"{name}_high": of_structures.high,
            }
            row[f"{name}_highest"] = part[name].max()
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
