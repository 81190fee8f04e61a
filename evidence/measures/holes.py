"""What Z on the full surface depends on: the holes of a subset, or the number of its dots."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures.proteins import table_of_proteins
from measures.tables import write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches.readings import FULL_READING
from sparsurf.sampling.samplers import get_samplers, nearest_kept

from .clumps import clumps

CLUMPS = "clumps"  # subsets with the largest holes
CLUMP_RADIUS = 2.0  # Å
ALL = "all"
HOLES = {  # of the distances from every dot of the surface to the nearest kept one, Å
    "mean": np.mean,
    "percentile_75": lambda distance: np.percentile(distance, 75),
    "percentile_95": lambda distance: np.percentile(distance, 95),
    "largest": np.max,
}
MEASURES = ["n_S_percent", "dots_per_A2", *HOLES]


def holes_table(
    prepared: PreparedSurface, samplers: Sequence[str], percents: Sequence[float], n_tests: int, draws: int
) -> pd.DataFrame:
    """Measure Z on the full surface and the holes of subsets by several samplers and of several sizes.

    Returns
    -------
    DataFrame: sampler, percent (requested), n_S_percent, dots_per_A2, mean, percentile_75, percentile_95 and largest (Å, of the
    distance of a dot to the nearest kept one, means over draws), Z and Z_se, its standard error over draws and test dots
    """
    methods = {
        name: chosen.__call__
        for name, chosen in get_samplers([s for s in samplers if s != CLUMPS], "samplers").items()
    }
    if CLUMPS in samplers:
        methods[CLUMPS] = lambda of, n, rng: clumps(of.points, n, CLUMP_RADIUS, rng)
    cases, subsets = [(name, percent) for name in methods for percent in percents], []
    for name, percent in cases:
        n = round(percent / 100 * len(prepared))
        for draw in range(draws):
            dots = methods[name](prepared, n, prepared.stream("holes", name, n, draw))
            subsets.append(np.sort(dots))
    tests = prepared.draw_tests(n_tests)
    _, z, _ = prepared.compare(subsets, tests, (FULL_READING,))
    found = estimate(z[0].reshape(len(cases), draws, -1))
    rows = []
    for k, (name, percent) in enumerate(cases):
        of_case = subsets[k * draws : (k + 1) * draws]
        n_s = np.mean([len(subset) for subset in of_case])
        row = {"sampler": name, "percent": percent, "n_S_percent": 100 * n_s / len(prepared)}
        row["dots_per_A2"] = n_s / prepared.area
        distances = [nearest_kept(prepared.points, subset)[1] for subset in of_case]
        row |= {measure: np.mean([of(d) for d in distances]) for measure, of in HOLES.items()}
        rows.append(row | {"Z": found.mean[k], "Z_se": found.error[k]})
    return pd.DataFrame(rows)


def line(measure: np.ndarray, z: np.ndarray) -> tuple[float, float]:
    """Fit log Z by a line over the log of a measure; return its slope and the residual, % (standard deviation of log Z)."""
    x, y = np.log(measure), np.log(z)
    slope, intercept = np.polyfit(x, y, 1)
    rest = y - slope * x - intercept
    return float(slope), float(100 * np.sqrt((rest**2).sum() / (len(x) - 2)))


def fits(table: pd.DataFrame) -> pd.DataFrame:
    """Compare how well each measure of a subset explains its Z, with and without clumps.

    Returns
    -------
    DataFrame: samplers ('all' or 'without clumps'), measure, n_surfaces, n (subsets), slope and residual_percent of one line for
    all surfaces, residual_lowest and residual_highest of the lines of single surfaces, Z_se_percent (root mean square of the
    relative standard errors of Z)
    """
    rows = []
    for samplers, part in ((ALL, table), (f"without {CLUMPS}", table[table["sampler"] != CLUMPS])):
        for measure in MEASURES:
            slope, residual = line(part[measure].to_numpy(), part["Z"].to_numpy())
            single = [line(p[measure].to_numpy(), p["Z"].to_numpy())[1] for _, p in part.groupby("surface")]
            row = {"samplers": samplers, "measure": measure, "n_surfaces": len(single), "n": len(part)}
            row |= {"slope": slope, "residual_percent": residual}
            row |= {"residual_lowest": min(single), "residual_highest": max(single)}
            rows.append(row | {"Z_se_percent": 100 * np.sqrt(((part["Z_se"] / part["Z"]) ** 2).mean())})
    return pd.DataFrame(rows)


def measure_holes(job: Job) -> None:
    """Tabulate Z on the full surface against the holes and the number of dots of a subset, on several surfaces."""
    params, out = job.params, job.output
    design = params.samplers, params.percents, params.test_dots, params.draws
    table = table_of_proteins(job, "holes", lambda prepared: holes_table(prepared, *design), "surface")
    write_tables({out.table: table, out.fits: fits(table)})
