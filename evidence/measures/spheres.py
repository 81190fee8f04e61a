"""Errors of the surfaces reconstructed from few dots by the interpolant and by the spheres of the dots, on independent dots."""

from collections.abc import Iterator, Sequence
from itertools import pairwise

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
from sparsurf.surfaces.surface import Surface

FARTHEST, COVER = "farthest", "cover"
MODELS = (INTERPOLANT, SPHERES)
ERRORS = ("mean", "high_99", "largest", "back_99", "back_largest")
KEYS = ["group", "sampler", "model", "requested"]


def errors_of(
    surface: Surface,
    densities: Sequence[float],
    of_cover: Sequence[float],
    requested_errors: Sequence[float],
    streams: Streams,
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
            there = distance_to_surface(test.points, points, normals)
            back = distance_to_surface(points, test.points, test.normals)
            row = {"sampler": sampler, "model": model, "requested": requested}
            row |= {"density": len(dots) / prepared.area, "share": share, "mean": there.mean()}
            row |= {"high_99": np.quantile(there, TAIL_QUANTILE), "largest": there.max()}
            yield row | {"back_99": np.quantile(back, TAIL_QUANTILE), "back_largest": back.max()}

    for density in densities:
        dots = trials[FARTHEST].draw(round(density * prepared.area))
        yield from rows(FARTHEST, density, dots, MODELS)
    for density in of_cover:
        yield from rows(COVER, density, trials[COVER].draw(round(density * prepared.area)), MODELS)
    for error in requested_errors:
        settings = Settings(minimal=Minimal(error=error))
        few = represent(surface, settings, streams, surface.molecule).subset
        yield from rows(few.sampler, f"error {error:g}", few.dots, [few.model])


def measure_spheres(job: Job) -> None:
    """Measure the errors of several structures of one group."""
    params, found, progress = job.params, [], reporter("Spheres", "surfaces")
    for k, (name, path) in enumerate(params.structures.items()):
        molecule = first_model(name, path, params.hydrogens)
        if molecule is None:
            continue
        streams = Streams(params.seed, f"spheres {name}")
        known = {"group": params.group, "structure": name, "atoms": molecule.n_atoms}
        surface = sparsurf.surface(molecule)
        known["area"] = surface.area.sum()
        rows = errors_of(surface, params.densities, params.of_cover, params.requested_errors, streams)
        found += [known | row for row in rows]
        progress(k + 1, len(params.structures))
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
