"""Z of subsets that clump for no reason, beside those of the paper's sampling, of random dots and of farthest points."""

from collections.abc import Callable, Sequence

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from sparsurf_study.workflow.jobs import Job
from measures.proteins import table_of_proteins
from measures.tables import write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.sampling.samplers import get_sampler
from sparsurf_study.analysis.relation import with_interval

PAPER, UNIFORM, FARTHEST = "paper", "uniform", "farthest"


def clumps(points: np.ndarray, n: int, radius: float, rng: np.random.Generator) -> np.ndarray:
    """Keep all dots within `radius` Å of dots drawn at random until there are n; of the last clump the nearest ones."""
    tree, kept = cKDTree(points), np.zeros(len(points), bool)
    left = n
    for centre in rng.permutation(len(points)):
        if not left:
            break
        near = np.array(tree.query_ball_point(points[centre], radius))
        near = near[~kept[near]]
        order = np.argsort(np.linalg.norm(points[near] - points[centre], axis=1), kind="stable")
        kept[near[order[:left]]] = True
        left = n - int(kept.sum())
    return np.flatnonzero(kept)


def clumps_table(
    prepared: PreparedSurface, rows: Sequence[int], radii: Sequence[float], n_tests: int, draws: int
) -> pd.DataFrame:
    """Measure Z under `kept` and `full` of random clumps and of other subsets with as many dots as the paper's sampling.

    Test dots are the same for all subsets, and in each draw all subsets have the number of dots of the paper's.

    Returns
    -------
    DataFrame: row (of Table I, of the paper's sampling), n_S_percent, subset, reading, Z and Z_se, its standard error over
    draws and test dots, and d (Z of the random subset less Z, paired by draw and test dot) with its 95 % interval
    """
    methods: dict[str, Callable[[int, np.random.Generator], np.ndarray]] = {
        FARTHEST: lambda n, rng: get_sampler(FARTHEST)(prepared, n, rng)
    }
    for radius in radii:
        methods[f"clumps of {radius:g} Å"] = lambda n, rng, radius=radius: clumps(
            prepared.points, n, radius, rng
        )
    tests, names, out = prepared.draw_tests(n_tests), [PAPER, UNIFORM, *methods], []
    for row in rows:
        subsets: list[np.ndarray] = []
        for draw in range(draws):
            paper, uniform = prepared.pair(PUBLISHED_ROWS[row - 1], draw)
            subsets += [paper, uniform]
            for name, method in methods.items():
                dots = method(len(paper), prepared.stream("clumps", name, row, draw))
                subsets.append(np.sort(dots))
        percent = 100 * np.mean([len(subset) for subset in subsets]) / len(prepared)
        _, z, _ = prepared.compare(subsets, tests, GRID_READINGS)
        for reading, of_reading in zip(GRID_READINGS, z, strict=True):
            by_name = np.swapaxes(of_reading.reshape(draws, len(names), -1), 0, 1)
            mean, d = estimate(by_name), estimate(by_name[names.index(UNIFORM)] - by_name)
            for k, name in enumerate(names):
                found = {"row": row, "n_S_percent": percent, "subset": name, "reading": reading}
                found |= {"Z": mean.mean[k], "Z_se": mean.error[k]}
                out.append(found | {"d": d.mean[k], "d_low": d.low[k], "d_high": d.high[k]})
    return pd.DataFrame(out)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe Z of each subset over surfaces.

    Returns
    -------
    DataFrame: row, reading, subset, n (surfaces), n_S_percent, Z and d with their 95 % intervals over surfaces, Z_lowest and
    Z_highest, Z_se (root mean square of the standard errors of single surfaces), n_above and n_below (surfaces where d lies
    significantly above and below 0), and n_below_paper (surfaces where Z is lower than that of the paper's sampling)
    """
    keys, out = ["surface", "row", "reading"], []
    of_paper = table[table["subset"] == PAPER].set_index(keys)["Z"]
    for (row, reading, subset), part in table.groupby(["row", "reading", "subset"], sort=False):
        found = {"row": row, "reading": reading, "subset": subset, "n": len(part)}
        found |= {"n_S_percent": part["n_S_percent"].mean()} | with_interval("Z", part["Z"])
        found |= {"Z_lowest": part["Z"].min(), "Z_highest": part["Z"].max()}
        found["Z_se"] = np.sqrt((part["Z_se"] ** 2).mean())
        found |= with_interval("d", part["d"])
        found |= {"n_above": int((part["d_low"] > 0).sum()), "n_below": int((part["d_high"] < 0).sum())}
        z_of_paper = of_paper.loc[pd.MultiIndex.from_frame(part[keys])].to_numpy()
        out.append(found | {"n_below_paper": int((part["Z"].to_numpy() < z_of_paper).sum())})
    return pd.DataFrame(out)


def measure_clumps(job: Job) -> None:
    """Tabulate Z of random clumps and of other subsets of the same size, on several surfaces."""
    params, out = job.params, job.output
    design = params.rows, params.radii, params.test_dots, params.draws
    table = table_of_proteins(job, "clumps", lambda prepared: clumps_table(prepared, *design), "surface")
    write_tables({out.table: table, out.means: means(table)})
