"""Values of the page on the paper: whether each claim holds under each reading, and the numbers."""

from __future__ import annotations

import math
from collections.abc import Hashable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf.patches.readings import FULL_READING, GRID_READINGS, KEPT_READING, SCALED_READING
from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_ROWS,
    TABLE_1,
    Combination,
    combination_labels,
    split_combinations,
)
from sparsurf_study.analysis.rough_and_flat import MIN_TEST_DOTS
from sparsurf_study.paper import replication
from sparsurf_study.paper.verdict import (
    MEASURES,
    MIN_RUNS,
    count_inside,
    is_one_more_run,
    said_of_grid,
    why_undecided,
)
from sparsurf_study.report.numbers import is_fragmented

if TYPE_CHECKING:
    from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.evaluation.prepared_surface import PreparedSurface

PAPER_TEMPLATE = "paper.html.j2"
YES, NO, TOO_FEW, NOT_TESTED = "yes", "no", "too few runs", "not tested"
AS_PRINTED = "as printed yes, in the code no"
COMPLETE_SET = "the complete set yes, up to order 20 no"
PUBLISHED_BEST = (1, 0, 6, 0)  # The published best combination at alpha = 1.
ROW_OF_BEST = 5  # The row of Table I that holds it.
# Of Eq. 2, by the values of the parameters that are set to 0 or 1
LIMIT_CASES: dict[str, dict[str, float]] = {
    "A, p does not depend on R: β = γ = 0": {"beta": 0, "gamma": 0},
    "B, p does not depend on the distance: γ = δ = 0": {"gamma": 0, "delta": 0},
    "C, p is steepest in R: α = β = 1": {"alpha": 1, "beta": 1},
}
SPAN_TOLERANCE = 0.2  # points of %, by which an end of the range of n_S may differ from the published one
OF_ROWS = (KEPT_READING, SCALED_READING, FULL_READING)
NEARLY_EQUAL = 0.1  # of Z of the random subset, by which that of the sampling may differ
MAX_LINK_COLUMNS = 6
CURVE_SIZE = (440, 330)  # px
OF_WHOLE_GRID = (
    "winners",
    "best",
    "span",
)  # claims on what is best or lowest among all of the paper's combinations
HALVES = ("rougher half", "flatter half")
DISTANCES_UNMOVED = "distances from the dot itself"
COEFFICIENTS = (121, 231)  # moduli of order 20 at most, and the real numbers in their complex coefficients
CHAPTERS_OF_FIGURES = {  # figures 1 to 5 of the paper: chapters with their numbers
    "roughness": ("range_of_roughness",),
    "number_of_dots": ("span", "uniform"),
    "d_over_grid": ("best",),
    "rough_and_flat": ("rough", "flat", "fewer"),
    "subsets": ("gather",),
}


def paper_page(data: dict[str, Any]) -> dict[str, Any]:
    """Collect the values of the page.

    `data` holds `grid`, `ranges`, `best` and `recovered` of the surface; `rows`, `links`, `defects`, `family` and
    `gathering` of `paper.replication`; `places`, `tests` and `bias` of `paper.published_runs`; `bins` of
    `rough_and_flat.bins_table` with a column `around`; `uniform`, the median number of patches of a dot; and `surface`, see
    `surface_of`.
    """
    grid, references = data["grid"], data["best"]["references"]
    reduced = said_of_grid(grid)
    rough, flat = rough_and_flat(data["bins"])
    gathered, fewer = gather(data["gathering"])
    low, high = data["surface"]["roughness"]
    of_best = data["links"][data["links"]["row"] == ROW_OF_BEST].sort_values("d_link")
    ends = of_best[["d_link", "d"]].iloc[[0, int(of_best["d"].argmin())]].to_numpy().tolist()
    chapters = {
        "table1": table1(data["places"], data["tests"], data["rows"], data["bias"], reduced),
        "winners": describe_winners(data["ranges"], data["places"]),
        "best": best_at_one(data["best"], grid, data["places"]),
        "positive": positive(grid, data["rows"], data["family"]),
        "describe": describe_grid(grid, data["rows"], references["Z_mean_descriptor"]),
        "rough": rough,
        "flat": flat,
        "fewer": fewer,
        "gather": gathered,
        "span": span_of(grid),
        "uniform": describe_uniform(grid, data["uniform"]["median"]),
        "range_of_roughness": {"holds": both(low >= 0 and high <= 1), "measured": (low, high)},
        "probability": probability(data["surface"], data["defects"]),
        "orientation": orientation(references, data["turned"]),
        "parameter_free": {"holds": both(False), "links": ends},
        "univocal": {"holds": dict.fromkeys(GRID_READINGS, COMPLETE_SET), "numbers": COEFFICIENTS},
    }
    for name in OF_WHOLE_GRID if reduced else ():
        chapters[name]["holds"] = dict.fromkeys(GRID_READINGS, NOT_TESTED)
    figures = [
        (n, name, [(k, chapters[k]["holds"]) for k in names])
        for n, (name, names) in enumerate(CHAPTERS_OF_FIGURES.items(), start=1)
    ]
    return chapters | {
        "claims": [(name, chapter["holds"]) for name, chapter in chapters.items()],
        "readings": GRID_READINGS,
        "reduced": reduced,
        "surface": data["surface"],
        "links": links(data["links"], grid),
        "curve": curve(data["links"]),
        "defects": defects(data["defects"]),
        "outlook": data["recovered"].iloc[0].to_dict(),
        "figures": figures,
    }


def surface_of(
    prepared: PreparedSurface, rules: SurfaceSettings, path_to_surface: str | None = None
) -> dict[str, Any]:
    """Describe the dots: how they were generated, and their numbers."""
    source = "file" if path_to_surface else rules.reentrant
    return {
        "source": source,
        "n_dots": len(prepared.points),
        "n_centres": len(prepared.cover.centre),
        "mean_roughness": float(prepared.roughness.mean()),
        "roughness": (float(prepared.roughness.min()), float(prepared.roughness.max())),
        "largest_r": float(np.exp(-prepared.cover.log_ratio.min())),
    }


def answer(holds: bool) -> str:
    """Return yes or no."""
    return YES if holds else NO


def both(holds: bool) -> dict[str, str]:
    """Return the same answer for both readings."""
    return dict.fromkeys(GRID_READINGS, answer(holds))


def of_rows(holds: pd.Series) -> str:
    """Count the rows that hold."""
    return f"{int(holds.sum())} of {len(holds)}"


def span_of(grid: pd.DataFrame) -> dict[str, Any]:
    """Compare the range of n_S of the grid with the published one."""
    measured = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    published = TABLE_1["n_S_low_percent"][0], TABLE_1["n_S_high_percent"][-1]
    holds = both(np.abs(np.subtract(measured, published)).max() < SPAN_TOLERANCE)
    return {"holds": holds, "measured": measured, "tolerance": SPAN_TOLERANCE}


def table1(
    places: pd.DataFrame, tests: pd.DataFrame, rows: pd.DataFrame, bias: pd.DataFrame, reduced: str
) -> dict[str, Any]:
    """Compare Table I with runs made as published, and with means of its combinations under each reading.

    Under a reading other than that of the authors' code it holds if no published d has the other sign than the mean.
    """

    def between(table: pd.DataFrame, name: str, low: str, high: str) -> int:
        return int(table[f"{name}_published"].between(table[f"{name}_{low}"], table[f"{name}_{high}"]).sum())

    inside, n, undecided = count_inside(places), len(places), why_undecided(places, reduced)
    of_runs = f"d {inside['d']}, Z {inside['Z_tS']} of {inside['n']}"
    if undecided:
        of_runs = NOT_TESTED if reduced else TOO_FEW
    published, low, high = rows["d_published"], rows[f"d_low_{FULL_READING}"], rows[f"d_high_{FULL_READING}"]
    opposite = ((published > 0) & (high < 0)) | ((published < 0) & (low > 0))
    of_means = f"low_{KEPT_READING}", f"high_{KEPT_READING}"
    return {
        "holds": {
            KEPT_READING: of_runs,
            FULL_READING: answer(not opposite.any()),
        },
        "same": is_one_more_run(tests),
        "undecided": undecided,
        "inside": inside,
        "compared": len(MEASURES) * int((places["n_runs"] > 1).sum()),
        "in_span": sum(between(places, name, "lowest", "highest") for name in MEASURES),
        "n": n,
        "won": int((places["n_won"] > 0).sum()),
        "runs": int(places["n_runs"].max()),
        "tests": tests.to_dict("records"),
        "fragmented": sum(map(is_fragmented, rows.to_dict("records"))),
        "above": {reading: int((rows[f"d_low_{reading}"] > 0).sum()) for reading in OF_ROWS},
        "below": {reading: int((rows[f"d_high_{reading}"] < 0).sum()) for reading in OF_ROWS},
        "bias": bias["d_bias"].mean(),
        "means": {name: between(rows, name, *of_means) for name in MEASURES},
        "rows": [
            a | b | {"inside": said_inside(b)}
            for a, b in zip(rows.to_dict("records"), places.to_dict("records"), strict=True)
        ],
        "outside": [
            f"{name.removesuffix('_tS')} of row {row}"
            for name in MEASURES
            for row in places.loc[places[f"{name}_inside"] == 0, "range"]
        ],
    }


def said_inside(row: dict[Hashable, Any]) -> str:
    """Say whether the published d and Z of a row lie in the central 95 % of its runs."""
    if row["n_runs"] < MIN_RUNS:
        return TOO_FEW
    return ", ".join(answer(row[f"{name}_inside"] == 1) for name in MEASURES)


def describe_winners(ranges: pd.DataFrame, places: pd.DataFrame) -> dict[str, Any]:
    """Compare our winner of each range with the published one, and count how often that won the runs."""
    table = places[["range", "n_won", "n_runs"]].reset_index(drop=True)
    table["published"] = [str(Combination(*row)) for row in PUBLISHED_ROWS]
    n_same, among = {}, {}
    for reading in GRID_READINGS:
        rows = ranges[ranges["reading"] == reading].reset_index(drop=True)
        table[reading] = pd.Series(combination_labels(rows))
        if reading == KEPT_READING:
            ends = ["", "_low", "_high"]
            table[[f"d_cv{end}" for end in ends]] = rows[[f"d_cv{end}" for end in ends]]
            scaled = [f"d{end}_{SCALED_READING}" for end in ends]
            table[scaled] = rows.reindex(columns=scaled)
        n_same[reading] = int((table[reading] == table["published"]).sum())
        sets = rows["best_set"].map(split_combinations)
        among[reading] = pd.Series(
            [name in best for name, best in zip(table["published"], sets, strict=False)]
        )
    return {
        "holds": {reading: of_rows(among[reading]) for reading in GRID_READINGS},
        "same": n_same,
        "among": {reading: int(inside.sum()) for reading, inside in among.items()},
        "rows": table.dropna(subset=list(GRID_READINGS)).to_dict("records"),
    }


def best_at_one(best: dict[str, Any], grid: pd.DataFrame, places: pd.DataFrame) -> dict[str, Any]:
    """Compare the best combination at the largest alpha with the published one, which must not be significantly worse."""
    published = grid[np.isclose(grid[PARAMETERS], PUBLISHED_BEST).all(axis=1)]
    ours = {reading: best[reading]["unrestricted"] for reading in GRID_READINGS}
    name = str(Combination(*PUBLISHED_BEST))
    run = places[places["range"] == ROW_OF_BEST].iloc[0]
    sets = {key: split_combinations(row["best_set"]) for key, row in ours.items()}
    return {
        "holds": {
            key: f"one of {len(best_set)}"
            if name in best_set and len(best_set) > 1
            else answer(name in best_set)
            for key, best_set in sets.items()
        },
        "among": {key: name in best_set for key, best_set in sets.items()},
        "is_ours": str(Combination.from_row(ours[KEPT_READING])) == name,
        "ours": ours,
        "run": run.to_dict(),
        "limits": [{"name": name} | limit_case(grid, fixed) for name, fixed in LIMIT_CASES.items()],
        "published": published.iloc[0] if len(published) else None,
    }


def limit_case(grid: pd.DataFrame, fixed: Mapping[str, float]) -> dict[str, Any]:
    """Return by reading the combination with the highest d among those with these values of parameters; None if there is none."""
    rows = grid[np.isclose(grid[[*fixed]], [*fixed.values()]).all(axis=1)]
    return {
        reading: rows.iloc[int(rows[f"d_{reading}"].to_numpy().argmax())].to_dict() if len(rows) else None
        for reading in GRID_READINGS
    }


def positive(grid: pd.DataFrame, rows: pd.DataFrame, family: pd.DataFrame) -> dict[str, Any]:
    """Count the rows of Table I and the combinations that beat a random subset, also with alpha tuned to equal n_S."""
    counts: dict[str, dict[str, float]] = {}
    for reading in GRID_READINGS:
        d, low, high = (grid[f"{key}_{reading}"] for key in ("d", "d_low", "d_high"))
        above_0, above, below = (int(holds.sum()) for holds in (d > 0, low > 0, high < 0))
        counts[reading] = {"above_0": above_0, "above": above, "below": below}
        counts[reading] |= {"mean": d.mean(), "largest": d.max()}
    return {
        "holds": {reading: of_rows(rows[f"d_low_{reading}"] > 0) for reading in GRID_READINGS},
        "published": int((rows["d_published"] > 0).sum()),
        "open": rows_around(rows, "d", KEPT_READING, 0),
        "n": len(grid),
        "counts": counts,
        "members": int(family["members"].sum()),
        "better": int(family["n_better"].sum()),
        "family": family.to_dict("records"),
    }


def rows_around(rows: pd.DataFrame, name: str, reading: str, limit: float) -> list[int]:
    """Return the rows of Table I, from 1, whose 95 % interval contains a limit."""
    low, high = (rows[f"{name}_{end}_{reading}"].to_numpy() for end in ("low", "high"))
    return (1 + np.flatnonzero((low <= limit) & (limit <= high))).tolist()


def describe_grid(grid: pd.DataFrame, rows: pd.DataFrame, null: float) -> dict[str, Any]:
    """Count the rows of Table I and the combinations that describe a patch better than the mean patch does."""
    tables = (grid, rows)
    holds, worse, open_rows = {}, {}, {}
    for reading in GRID_READINGS:
        better = [table[f"Z_tS_{reading}"] < null for table in tables]
        holds[reading] = of_rows(better[1])
        open_rows[reading] = rows_around(rows, "Z_tS", reading, null)
        worse[reading] = [int((~is_better).sum()) for is_better in better]
    return {
        "holds": holds,
        "null": null,
        "counts": worse,
        "open": open_rows,
        "n": (len(grid), len(rows)),
    }


def rough_and_flat(bins: pd.DataFrame) -> tuple[dict[str, Any], dict[str, Any]]:
    """Compare d in rough and flat patches, around kept dots (as in the paper) and around any dots: two chapters.

    Rough patches gain if the interval of d of the rougher half lies above 0 and above that of the flatter half; flat ones
    are nearly equal if d of the flattest bin does not exceed NEARLY_EQUAL significantly.
    """
    gains: dict[str, list[bool]] = {reading: [] for reading in GRID_READINGS}
    equal: dict[str, list[bool]] = {reading: [] for reading in GRID_READINGS}
    table = {}
    for around, rows in bins.groupby("around", sort=False):
        flattest = rows[~rows["bin"].isin(HALVES) & (rows["n"] >= MIN_TEST_DOTS)].iloc[-1]
        rough, flat = (rows[rows["bin"] == name].iloc[0] for name in HALVES)
        table[str(around)] = [rough, flat, flattest]
        for reading in GRID_READINGS:
            gains[reading].append(bool(rough[f"d_low_{reading}"] > max(0, flat[f"d_high_{reading}"])))
            beyond = max(flattest[f"d_low_{reading}"], -flattest[f"d_high_{reading}"])
            equal[reading].append(not beyond > NEARLY_EQUAL * flattest[f"Z_tR_{reading}"])
    return (
        {"holds": {reading: answer(all(cases)) for reading, cases in gains.items()}, "table": table},
        {"holds": {reading: answer(all(cases)) for reading, cases in equal.items()}},
    )


def describe_uniform(grid: pd.DataFrame, patches: float) -> dict[str, Any]:
    """Check that beta = gamma = delta = 0 keeps more dots with each larger alpha."""
    rows = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)].sort_values("alpha")
    holds = (
        both(bool((rows["n_S_percent"].diff()[1:] > 0).all()))
        if len(rows) > 1
        else dict.fromkeys(GRID_READINGS, NOT_TESTED)
    )
    return {"holds": holds, "patches": patches, "rows": rows.to_dict("records")}


def gather(gathering: pd.DataFrame) -> tuple[dict[str, Any], dict[str, Any]]:
    """Compare the shares kept of the roughest and the flattest dots, and the dots of flat patches: two chapters."""
    groups = gathering.groupby("combination", sort=False)
    rows = groups["kept_percent"].agg(roughest="first", flattest="last")
    rows["all"], flattest = groups["uniform_percent"].first(), groups.last()
    fewer = {}
    for reading in GRID_READINGS:
        sampled, uniform = (flattest[f"median_patch_size_{key}{reading}"] for key in ("", "uniform_"))
        fewer[reading] = answer(bool((sampled < uniform).all()))
    return (
        {
            "holds": both(bool((rows["roughest"] > rows["flattest"]).all())),
            "rows": rows.reset_index().to_dict("records"),
        },
        {"holds": fewer, "rows": flattest.reset_index().to_dict("records")},
    )


def probability(surface: dict[str, Any], table: pd.DataFrame) -> dict[str, Any]:
    """Check that no distance exceeds r_patch, so that p of Eq. 2 cannot exceed 1; d by row with distances from the dot itself."""
    d = table.pivot(index="row", columns="sampling", values=f"d_{KEPT_READING}")
    return {
        "holds": dict.fromkeys(GRID_READINGS, YES if surface["largest_r"] <= 1 else AS_PRINTED),
        "largest_r": surface["largest_r"],
        "rows": d[["as published", DISTANCES_UNMOVED]].to_records().tolist(),
    }


def orientation(references: dict[str, Any], turned: float) -> dict[str, Any]:
    """Compare Z of the same dots, turned, with Z of fresh dots: where it is larger, the descriptor depends on the orientation."""
    fresh = references["floors"]["fresh dots"]
    return {
        "holds": both(turned <= fresh),
        "turned": turned,
        "fresh": fresh,
        "two_patches": references["Z_two_patches"],
    }


def links(table: pd.DataFrame, grid: pd.DataFrame) -> dict[str, Any]:
    """Tabulate d of the published rows by linking distance, and what d depends on."""
    d = table.pivot(index="row", columns="d_link", values="d")
    best = d.idxmax(axis=1)
    d = d.iloc[:, :: -(-d.shape[1] // MAX_LINK_COLUMNS)]
    return {
        "d": d.to_dict("index"),
        "distances": d.columns.tolist(),
        "best": (best.min(), best.max()),
        "tried": (table["d_link"].min(), longest := table["d_link"].max()),
        "below": int((table.loc[table["d_link"] == longest, "d_high"] < 0).sum()),
        "rows": len(best),
        "correlation": replication.correlation_of_readings(grid),
        "fragments": replication.correlation_with_fragments(grid),
    }


def curve(table: pd.DataFrame) -> dict[str, Any]:
    """Lay out d of each published row against link / spacing of its kept dots."""
    ratio = table["link_over_spacing"]
    low, high = (math.floor(min(0.0, table["d"].min())), math.ceil(max(0.0, table["d"].max())))
    last = math.ceil(float(ratio.max()))
    width, height = CURVE_SIZE
    left, bottom, top = 26.0, height - 38.0, 18.0

    def across(value: Any) -> Any:
        return left + (width - left - 8) * value / last

    def down(value: Any) -> Any:
        return bottom - (bottom - top) * (value - low) / max(high - low, 1)

    points = table.assign(x=across(ratio).round(1), y=down(table["d"]).round(1), ratio=ratio)
    points = points.sort_values("d_link")
    lines = [
        (row, " ".join(f"{x},{y}" for x, y in rows[["x", "y"]].to_numpy()))
        for row, rows in points.groupby("row")
    ]
    best = points.iloc[int(points["d"].argmax())]
    crossings = []
    for _, rows in points.groupby("row"):
        k = int((rows["d"] < 0).to_numpy().argmax())  # 0 where d is never below 0
        if k and rows["d"].iloc[0] > 0:
            (before, after), (high_d, low_d) = rows[["ratio", "d"]].iloc[k - 1 : k + 1].to_numpy().T
            crossings.append(before + (after - before) * high_d / (high_d - low_d))
    step = max(1, math.ceil((high - low) / 6))
    return {
        "width": width,
        "height": height,
        "left": left,
        "lines": lines,
        "levels": [(round(down(level), 1), level) for level in range(low, high + 1) if level % step == 0],
        "ticks": [(round(across(k), 1), k) for k in range(0, last + 1, max(1, last // 8))],
        "top": (best["ratio"], best["d"]),
        "crossing": (min(crossings), max(crossings)) if crossings else None,
    }


def defects(table: pd.DataFrame) -> dict[str, dict[Any, float]]:
    """Average over the ten rows how n_S and d change with each defect corrected, with the lowest and the highest change of d."""
    columns = ["n_S_percent", *(f"d_{reading}" for reading in GRID_READINGS)]
    by_sampling = {
        str(name): rows.set_index("row")[columns] for name, rows in table.groupby("sampling", sort=False)
    }
    reference = by_sampling.pop("as published")
    changes = {name: rows - reference for name, rows in by_sampling.items()}
    return {
        name: of_rows.mean().to_dict()
        | {column.replace("d_", "d_low_"): of_rows[column].min() for column in columns[1:]}
        | {column.replace("d_", "d_high_"): of_rows[column].max() for column in columns[1:]}
        for name, of_rows in changes.items()
    }
