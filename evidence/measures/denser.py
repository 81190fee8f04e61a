"""Evenly spread dots that are denser where the surface is rough: the error of the surface reconstructed from them."""

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

import sparsurf
from sparsurf_study.workflow.jobs import Job
from measures.spheres import ERRORS, errors_both_ways
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.trials import TEST_DENSITY
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import rolled_atoms
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis.relation import with_interval

EVEN = 0.0  # power of 1 - R of a density that is even


def farthest_by_weight(points: np.ndarray, weights: np.ndarray, first: int, n: int) -> np.ndarray:
    """Choose dots, in order: the first, then the one whose distance to the nearest chosen dot, times its weight, is largest."""
    tree, squared = cKDTree(points), np.square(weights)
    gap = np.sum((points - points[first]) ** 2, axis=1)  # squared distance to the nearest chosen dot
    chosen = np.empty(n, np.int64)
    chosen[0] = first
    for k in range(1, n):
        chosen[k] = new = int(np.argmax(gap * squared))
        # the new dot is the nearest one of none that lies farther from it than the largest gap
        near = np.array(tree.query_ball_point(points[new], 1.000001 * np.sqrt(gap.max())))
        gap[near] = np.minimum(gap[near], np.sum((points[near] - points[new]) ** 2, axis=1))
    return chosen


def errors_by_power(
    surface: Surface, powers: Sequence[float], densities: Sequence[float], streams: Streams
) -> Iterator[dict]:
    """Measure the errors of the interpolant from dots whose number per Å^2 follows (1 - R)^power.

    Yields rows with power, requested and density (kept dots per Å^2) and `ERRORS`, distances (Å) of independent dots of the whole
    surface to the reconstructed one, and back. Each next dot is the one whose distance to the nearest kept dot, times
    (1 - R)^(power / 2) of its patch, is largest, so that the square of the spacing follows 1 / (1 - R)^power. The first dot is
    the same for all powers.
    """
    prepared = PreparedSurface(surface, Settings(), None, streams)
    assert surface.origin is not None
    true = rolled_atoms(surface.origin)
    test = true.surface(TEST_DENSITY)
    first = int(prepared.stream("denser").integers(len(prepared)))
    for power in powers:
        weights = (1.0 - prepared.roughness) ** (power / 2)
        order = farthest_by_weight(prepared.points, weights, first, round(max(densities) * prepared.area))
        for density in densities:
            kept = order[: round(density * prepared.area)]
            few = prepared.points[kept], prepared.normals[kept]
            found = interpolate_surface(*few, DENSITY_FOR_ERRORS)
            row = {"power": power, "requested": density, "density": len(kept) / prepared.area}
            yield row | errors_both_ways((test.points, test.normals), *found, true)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the errors of each power over proteins.

    Returns
    -------
    DataFrame: requested, power, n (proteins); of each error its mean over proteins (Å), and its change against evenly spread dots
    in % with its 95 % interval over proteins (change_ERROR, _low, _high), n_above_ERROR and n_below_ERROR, the proteins on which
    it is larger and smaller than with these
    """
    even = table[table["power"] == EVEN].set_index(["protein", "requested"])[[*ERRORS]]
    rows = []
    for (requested, power), part in table.groupby(["requested", "power"], sort=False):
        row = {"requested": requested, "power": power, "n": len(part)}
        reference = even.loc[pd.MultiIndex.from_frame(part[["protein", "requested"]])]
        for error in ERRORS:
            change = 100 * (part[error].to_numpy() / reference[error].to_numpy() - 1)
            row |= {error: part[error].mean()} | with_interval(f"change_{error}", change)
            row |= {f"n_above_{error}": int((change > 0).sum()), f"n_below_{error}": int((change < 0).sum())}
        rows.append(row)
    return pd.DataFrame(rows)


def measure_denser(job: Job) -> None:
    """Measure the errors of one protein by the power of 1 - R and the density of the kept dots."""
    name, params = job.wildcards.protein, job.params
    molecule = read_molecule(job.input.structure, model=1, hydrogens=params.hydrogens)
    streams = Streams(params.seed, f"denser {name}")
    rows = errors_by_power(sparsurf.surface(molecule), params.powers, params.densities, streams)
    pd.DataFrame([{"protein": name} | row for row in rows]).to_csv(job.output.table, index=False)


def tabulate_denser(job: Job) -> None:
    """Tabulate the errors of dots that are denser where the surface is rough, over proteins."""
    table = read_tables(job.input.tables)
    write_tables({job.output.table: table, job.output.means: means(table)})
