"""Z of the patches of surfaces reconstructed from few dots by the interpolant and by the spheres of the dots."""

from collections.abc import Iterator, Sequence

import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job
from measures.spheres import COVER, FARTHEST, KEYS, MODELS, surfaces
from measures.tables import write_tables
from sparsurf.evaluation.floors import FRESH, fresh_dots
from sparsurf.evaluation.minimal_subset import DESCRIPTORS_OF_ERRORS, recovered_z, represent
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.evaluation.trials import Trials
from sparsurf.patches.index import build_grid
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.reconstructing import AUTO, INTERPOLANT, reconstruct
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.settings import Minimal, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface


def z_of_descriptors(
    surface: Surface,
    densities: Sequence[float],
    of_cover: Sequence[float],
    requested_errors: Sequence[float],
    n_tests: int,
    draws: int,
    streams: Streams,
) -> Iterator[dict]:
    """Measure Z of reconstructed surfaces: rows with sampler, model, requested, density, compared and Z_<descriptor>.

    The first row is the noise floor: Z of other dots of the same surface, a mean over `draws` of them. Z depends on the number of
    dots, so that reconstructed ones are thinned evenly to the number of the full surface.
    """
    prepared = PreparedSurface(surface, Settings(), None, streams)
    tests, origin = prepared.draw_tests(n_tests), surface.origin
    assert origin is not None
    floor = {
        f"Z_{name}": fresh_dots(
            prepared.with_descriptor(name),
            n_tests,
            lambda xyz: sparsurf.surface((xyz, origin.radii)),
            origin.xyz,
            draws,
        ).mean()
        for name in DESCRIPTORS_OF_ERRORS
    }
    of_floor = {"sampler": FRESH, "model": FRESH, "requested": FRESH}
    yield of_floor | {"density": prepared.density, "compared": prepared.density} | floor
    density = comparable_density(prepared.density)

    def row(sampler: str, model: str, requested: float | str, few: Surface) -> dict:
        found = reconstruct(few, density, model if model == INTERPOLANT else AUTO)
        rng = prepared.stream("spheres", "thinned")
        kept = farthest_point_sampling(build_grid(found.points), min(len(found.points), len(surface)), rng)
        z = recovered_z(prepared, Surface(found.points[kept], found.normals[kept]), tests)
        known = {"sampler": sampler, "model": model, "requested": requested}
        of_kept = {"density": len(few) / prepared.area, "compared": len(kept) / prepared.area}
        return known | of_kept | z

    for sampler, requested in ((FARTHEST, densities), (COVER, of_cover)):
        trials = Trials(prepared, sampler, 2, model=AUTO, atoms=origin)
        for of_dots in requested:
            few = trials.few(trials.draw(round(of_dots * prepared.area)))
            for model in MODELS:
                yield row(sampler, model, of_dots, few)
    for error in requested_errors:
        subset = represent(surface, Settings(minimal=Minimal(error=error)), streams, surface.molecule).subset
        yield row(subset.sampler, subset.reconstruction, f"error {error:g}", subset.surface)


def measure_spheres_z(job: Job) -> None:
    """Tabulate Z of reconstructed surfaces for several structures, and its means; both over the noise floor, too."""
    params, found = job.params, []
    for name, surface, streams in surfaces(params, "Z of spheres"):
        requested = params.densities, params.of_cover, params.requested_errors
        rows = z_of_descriptors(surface, *requested, params.test_dots, params.draws, streams)
        found += [{"structure": name} | row for row in rows]
    table = pd.DataFrame(found)
    columns = [f"Z_{name}" for name in DESCRIPTORS_OF_ERRORS]
    floor = table[table["sampler"] == FRESH].set_index("structure")[columns]
    for column in columns:
        table[column.replace("Z", "over_floor")] = table[column] / table["structure"].map(floor[column])
    write_tables({job.output.table: table, job.output.means: z_means(table)})


def z_means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe Z and Z over the noise floor over the structures.

    Returns
    -------
    DataFrame: sampler, model, requested, n (structures), density, compared (dots per Å^2 whose Z it is); of each Z its mean, of
    each over_floor the mean and its 95 % interval (_low, _high)
    """
    out, keys = [], KEYS[1:]
    for values, part in table.groupby(keys, sort=False):
        row = dict(zip(keys, values, strict=True)) | {"n": len(part)}
        row |= {name: part[name].mean() for name in ("density", "compared")}
        for name in DESCRIPTORS_OF_ERRORS:
            ratio = estimate(part[f"over_floor_{name}"].to_numpy()[None])
            row |= {f"Z_{name}": part[f"Z_{name}"].mean(), f"over_floor_{name}": ratio.mean}
            row |= {f"over_floor_{name}_low": ratio.low, f"over_floor_{name}_high": ratio.high}
        out.append(row)
    return pd.DataFrame(out)
