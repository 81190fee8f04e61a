"""The published combinations of Table I evaluated on one prepared surface, and what their d depends on."""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.evaluation.floors import random_rotation, rotate
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches.readings import FULL_READING, GRID_READINGS, KEPT_READING, SCALED_READING
from sparsurf.progress import Report
from sparsurf.sampling import published
from sparsurf.sampling.combination import PARAMETERS, PUBLISHED_ROWS, TABLE_1, Combination
from sparsurf.sampling.samplers import tune_alpha
from sparsurf.settings import Settings
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis import grid, tables
from sparsurf_study.analysis.islands import compare_islands, link_over_spacing, measure_islands
from sparsurf_study.paper import published_runs

TUNED_PERCENTS = (5.0, 10.0, 20.0, 40.0)  # n_S to which alpha is tuned, % of the dots
TURNS = 5  # orientations in which the same dots are described
LINK_DISTANCES = (0.5, 0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4, 1.5)  # Å, linking distances of the sweep

GATHERED = ((1, 0, 6, 0), (1, 1, 10, 0))  # combinations that the paper's Fig. 5 shows
TENTHS = 10  # All dots are divided into tenths by their roughness.
TESTS_OF_TENTH = 200  # dots of a tenth around which patches are counted, at most
STEPS_BESIDES_RUNS = 12  # The other tables take as long as so many runs of the grid, for the progress.


def reproduce(prepared: PreparedSurface, settings: Settings, progress: Report) -> dict[str, pd.DataFrame]:
    """Make the paper's runs again on a surface: the tables of the comparison, by name."""
    sampling, evaluation = settings.sampling, settings.evaluation
    combinations = published.parameter_grid(sampling.alpha, sampling.beta, sampling.gamma, sampling.delta)
    n_tests, draws = number_of_tests(evaluation.test_dots, len(prepared)), evaluation.draws
    total = published_runs.RUNS + STEPS_BESIDES_RUNS

    def of_runs(done: int, _: int) -> None:
        progress(done, total)

    runs = published_runs.runs_as_published(prepared, combinations, progress=of_runs)
    ranks = published_runs.place_published_values(runs)
    n_centres = published_runs.centres_in_random_orders(prepared)
    besides: dict[str, Callable[[], pd.DataFrame]] = {
        "rows": lambda: published_rows(prepared, n_tests, draws),
        "links": lambda: sweep_links(prepared, LINK_DISTANCES, n_tests, draws),
        "defects": lambda: compare_defects(prepared, n_tests, draws),
        "family": lambda: tuned_family(prepared, combinations[:, 1:], n_tests=n_tests, draws=draws),
    }
    made = {"runs": runs, "places": ranks, "tests": published_runs.tests_of_table_1(ranks, n_centres)}
    for k, (name, make) in enumerate(besides.items(), 1):
        made[name] = make()
        progress(published_runs.RUNS + STEPS_BESIDES_RUNS * k // len(besides), total)
    return made


def facts_for_page(
    prepared: PreparedSurface,
    results: Mapping[str, pd.DataFrame],
    table: pd.DataFrame,
    n_tests: int,
    draws: int,
) -> dict[str, Any]:
    """Collect what the page says of the results of `reproduce` and of the table grid.csv."""
    return {
        "bias": published_runs.selection_bias(results["runs"], table),
        "family": best_of_family(results["family"]),
        "gathering": gathering_by_roughness(prepared, draws),
        "turned": turned_z(prepared, n_tests),
        "uniform": {"median": float(np.median(np.bincount(prepared.cover.dot)))},
    }


def turned_z(prepared: PreparedSurface, n_tests: int) -> float:
    """Measure the mean distance between the descriptors of the dots and of the same dots, turned about their mean."""
    tests, rng = prepared.draw_tests(n_tests), prepared.stream("turned")
    z_tot, _ = prepared.describe(tests)
    z = []
    for _ in range(TURNS):
        rotation = random_rotation(rng)
        points, normals = rotate(prepared.points, rotation), rotate(prepared.normals, rotation)
        turned = prepared.with_dots(Surface(points, normals))
        z.append(np.linalg.norm(turned.describe(tests)[0] - z_tot, axis=1).mean())
    return float(np.mean(z))


def published_rows(prepared: PreparedSurface, n_tests: int, draws: int) -> pd.DataFrame:
    """Evaluate the published combinations under three readings, with shared test dots: the rows of paper_rows.csv."""
    published = pd.DataFrame(TABLE_1)[["n_S_low_percent", "n_S_high_percent", "d", "Z_tS"]]
    readings = (*GRID_READINGS, SCALED_READING)
    measured = tables.grid_table(grid.evaluate_grid(prepared, PUBLISHED_ROWS, n_tests, draws, readings))
    published = published.rename(columns={"d": "d_published", "Z_tS": "Z_tS_published"})
    islands = measure_islands(prepared, PUBLISHED_ROWS, n_tests, draws)
    return pd.concat([published, measured, islands], axis=1)


def sweep_links(prepared: PreparedSurface, links: Sequence[float], n_tests: int, draws: int) -> pd.DataFrame:
    """Measure the published combinations for other d_link of the islands, under `kept`: the rows of paper_links.csv."""
    tests = prepared.draw_tests(n_tests)
    pairs = [prepared.pair(row, draw) for row in PUBLISHED_ROWS for draw in range(draws)]
    n_kept = np.array([len(sampled) for sampled, _ in pairs]).reshape(-1, draws).mean(axis=1)
    shape = (len(PUBLISHED_ROWS), draws, len(tests))
    out = []
    for link in links:
        linked = prepared.with_link(link)
        z_tot, _ = linked.describe(tests)
        measured = []
        for subsets in zip(*pairs, strict=True):
            values = compare_islands(linked, subsets, tests, z_tot)
            measured.append([part.reshape(shape) for part in values])
        sampled, uniform = measured
        d = estimate(uniform[0] - sampled[0])
        columns = {"d_link": link, "row": range(1, len(PUBLISHED_ROWS) + 1)}
        columns["n_S_percent"] = 100 * n_kept / len(prepared)
        columns["link_over_spacing"] = link_over_spacing(link, n_kept, prepared.area)
        columns |= {"d": d.mean, "d_low": d.low, "d_high": d.high}
        columns["Z_tS"], columns["Z_tR"] = (z.mean(axis=(1, 2)) for z, _, _ in (sampled, uniform))
        columns["median_patch_size"] = np.median(sampled[1], axis=(1, 2))
        columns["share_in_island"], columns["share_in_island_uniform"] = (
            np.nanmedian(share, axis=(1, 2)) for _, _, share in (sampled, uniform)
        )
        out.append(pd.DataFrame(columns))
    return pd.concat(out, ignore_index=True)


# Arguments of `build_cover`: distance_from_moved_centre, chance_in_every_patch
DEFECTS = {
    "as published": (True, True),
    "distances from the dot itself": (False, True),
    "one draw per dot": (True, False),
    "both changed": (False, False),
}


def compare_defects(prepared: PreparedSurface, n_tests: int, draws: int) -> pd.DataFrame:
    """Measure the published combinations with each defect of the published sampling corrected: the rows of paper_defects.csv."""
    out = []
    for name, rules in DEFECTS.items():
        cover = published.build_cover(prepared.index, prepared.roughness, prepared.patches.r_patch, *rules)
        result = grid.evaluate_grid(prepared.with_cover(cover), PUBLISHED_ROWS, n_tests, draws)
        table = tables.grid_table(result)
        part = pd.DataFrame({"sampling": name, "row": np.arange(1, len(PUBLISHED_ROWS) + 1)})
        part["n_S_percent"] = 100 * result.n_s_expected / result.n_dots
        for reading in result.readings:
            for column in ("d", "d_se", "Z_tS", "median_patch_size"):
                part[f"{column}_{reading}"] = table[f"{column}_{reading}"]
        out.append(part)
    return pd.concat(out, ignore_index=True)


def tuned_family(
    prepared: PreparedSurface,
    exponents: np.ndarray,
    percents: Sequence[float] = TUNED_PERCENTS,
    n_tests: int = 400,
    draws: int = 3,
) -> pd.DataFrame:
    """Compare exponents (K, 3) at equal n_S with random subsets, under `full`: paper_family.csv, where alpha is at most 1."""
    n_dots, requested, rows = len(prepared.points), [], []
    exponents = np.unique(np.asarray(exponents, float), axis=0)
    max_n_s = published.expected_n_s(prepared.cover, np.insert(exponents, 0, 1.0, axis=1))
    for percent in percents:
        n = percent / 100 * n_dots
        for row in exponents[max_n_s >= n]:
            requested.append(percent)
            rows.append(tune_alpha(prepared.cover, (1.0, *row), n))
    result = grid.evaluate_grid(prepared, rows, n_tests, draws, (FULL_READING,))
    d = estimate(result.z_tr[0].astype(np.float64) - result.z_ts[0])
    table = pd.DataFrame(result.combinations, columns=PARAMETERS)
    table.insert(0, "percent", requested)
    table["n_S_percent"] = 100 * result.n_s.mean(axis=1) / n_dots
    table["Z_tS"], table["Z_tR"] = (
        z[0].mean(axis=(1, 2), dtype=np.float64) for z in (result.z_ts, result.z_tr)
    )
    return table.assign(d=d.mean, d_low=d.low, d_high=d.high)


def gathering_by_roughness(prepared: PreparedSurface, draws: int) -> pd.DataFrame:
    """Measure which share of the dots the sampling keeps in each tenth of all dots by roughness, the roughest first.

    Each row also has the median number of dots in the patches of this tenth, of the sampling and of a random subset, by reading.
    """
    order = np.argsort(prepared.roughness, kind="stable")
    rows = []
    for combination in GATHERED:
        pairs = [prepared.pair(combination, draw) for draw in range(draws)]
        kept = np.bincount(np.concatenate([sampled for sampled, _ in pairs]), minlength=len(order)) / draws
        for tenth, dots in enumerate(np.array_split(order, TENTHS), 1):
            row = {"combination": str(Combination(*combination)), "tenth": tenth}
            row |= {"roughness": prepared.roughness[dots].mean(), "kept_percent": 100 * kept[dots].mean()}
            row |= {"uniform_percent": 100 * kept.mean()}
            tests = dots[:: -(-len(dots) // TESTS_OF_TENTH)]
            for key, subsets in zip(("", "uniform_"), zip(*pairs, strict=True), strict=True):
                sizes = prepared.patch_sizes(subsets, tests, GRID_READINGS)
                for reading, of_reading in zip(GRID_READINGS, sizes, strict=True):
                    row[f"median_patch_size_{key}{reading}"] = np.median(of_reading)
            rows.append(row)
    return pd.DataFrame(rows)


def best_of_family(table: pd.DataFrame) -> pd.DataFrame:
    """Count, per requested n_S, combinations and those significantly better than a random subset, and find the lowest Z_tS."""
    rows = []
    for percent, members in table.groupby("percent"):
        best = members.iloc[int(members["Z_tS"].argmin())]
        n_better, n_worse = int((members["d_low"] > 0).sum()), int((members["d_high"] < 0).sum())
        row = {"percent": percent, "members": len(members), "n_better": n_better, "n_worse": n_worse}
        row |= {"largest_d": members["d"].max(), "Z_best": best["Z_tS"]}
        rows.append(row | {"Z_uniform": members["Z_tR"].mean(), **best[PARAMETERS].to_dict()})
    return pd.DataFrame(rows)


def correlation_of_readings(table: pd.DataFrame) -> float:
    """Correlate d under both readings over the grid."""
    return float(np.corrcoef(table[f"d_{KEPT_READING}"], table[f"d_{FULL_READING}"])[0, 1])


def correlation_with_fragments(table: pd.DataFrame) -> float:
    """Correlate d under the published reading with ln of the ratio of patch sizes, sampled to random."""
    sampled, uniform = (table[f"median_patch_size_{key}{KEPT_READING}"] for key in ("", "uniform_"))
    return float(np.corrcoef(table[f"d_{KEPT_READING}"], np.log(sampled / uniform))[0, 1])
