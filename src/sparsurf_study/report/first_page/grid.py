"""The grid on the first page: the best parameters of each surface, by number of dots, and whether they beat random subsets."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple

import pandas as pd

from sparsurf.patches.readings import FULL_READING
from sparsurf_study.report.first_page.run import MAX_CARDS, MAX_SHOWN, Run
from sparsurf_study.report.numbers import beyond_ranges, combination, is_fragmented

SIGNIFICANCE_LEVEL = 0.05
LINK_COLUMN = "link_over_spacing"  # a column of ranges.csv and summary.csv
AXIS_WIDTH = 220  # px, of the drawing of d in a row
READING_HEIGHT = 10  # px, of a reading in it
AXIS_MARGIN = 8  # px, beyond the ends of its axis
TICK_STEPS = (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0)  # between the numbers of the axis
MAX_STEPS = 5


class Axis(NamedTuple):
    """The axis of d, one for all surfaces of the page."""

    low: float
    high: float
    ticks: list[tuple[float, float]]  # position in px and value

    def place(self, d: float) -> float:
        """Return the position of a value in px."""
        return round(
            AXIS_MARGIN + (AXIS_WIDTH - 2 * AXIS_MARGIN) * (d - self.low) / (self.high - self.low), 1
        )


def of_grid(run: Run) -> dict[str, Any] | None:
    """Collect what the page says of the grid; None where no surface has one."""
    if not run.grids:
        return None
    shown = list(run.grids)[:MAX_SHOWN]
    bests = {place: run.best(place) for place in run.grids}
    axis = axis_of(run.grids[place] for place in shown)
    counts = {reading: [beaten(rows, reading) for rows in run.grids.values()] for reading in run.readings}
    published = run.read("paper_places.csv") if run.has("paper_places.csv") and len(run.grids) == 1 else None
    places = [place_values(run, place, bests[place], axis, published) for place in shown]
    return {
        "readings": run.readings,
        "n_combinations": bests[shown[0]]["combinations"],
        "n_surfaces": len(run.grids),
        "several": len(run.grids) > MAX_CARDS,
        "verdicts": verdicts_of(counts),
        "places": places,
        "n_ranges": len(places[0]["rows"]),
        "n_fragmented": fragmented_of([place for place in places if place["has_links"]]),
        "published": published is not None,
        "axis": axis,
        "width": AXIS_WIDTH,
        "height": READING_HEIGHT,
        "over_all": over_all(run) if len(run.grids) > MAX_CARDS and run.has("relation.csv") else None,
    }


def verdicts_of(counts: Mapping[str, list[tuple[int, int]]]) -> list[dict[str, Any]]:
    """Collect the answer under each reading, from the pairs that `beaten` returns for each surface.

    The answer on the full surface stands first. It is the one that counts beside others: whether a patch keeps its dots
    there follows from the full surface alone, while in a subset it depends on a link that was chosen for the full surface.
    """
    verdicts = []
    for k, (reading, pairs) in enumerate(counts.items()):
        above = [n_above for n_above, _ in pairs]
        verdicts.append(
            {
                "reading": reading,
                "k": k,
                "counts": reading == FULL_READING and len(counts) > 1,
                "above": sum(above),
                "total": sum(total for _, total in pairs),
                "surfaces": sum(n_above > 0 for n_above in above),
            }
        )
    return sorted(verdicts, key=lambda verdict: not verdict["counts"])


def place_values(
    run: Run, place: str, best: dict[str, Any], axis: Axis, published: pd.DataFrame | None
) -> dict[str, Any]:
    """Collect the best parameters of one surface: of all, of each range, and of those below the config's largest n_S."""
    rows = run.grids[place]
    outside = beyond_ranges(run.read(f"{place}/grid.csv")["n_S_percent"])  # as exact as in best.json
    winners = {reading: best[reading]["unrestricted"] for reading in run.readings}
    first = winner_values(winners[run.readings[0]], rows, run.readings[0], axis)
    table = [
        row_values(group, run.readings, winners, axis, published)
        for _, group in rows.groupby("range", sort=True)
    ]
    return {
        "name": run.shown[place],
        "k": run.places.index(place),
        "best": first,
        "rows": table,
        "has_links": LINK_COLUMN in rows,
        "outside": {  # winners that are in no range
            reading: winner_values(winner, rows, reading, axis)
            for reading, winner in winners.items()
            if winner.get("n_S_percent") == outside
        },
        "max_percent": best["max_n_S_percent"],
        "few": {
            reading: winner_values(best[reading]["under_max_n_S"], rows, reading, axis)
            for reading in run.readings
        },
        "none_so_few": best[run.readings[0]]["under_max_n_S"].get("answer"),
        "maps": run.figure(f"{place}/figures/d_over_grid.png"),
        "ranges": f"{place}/ranges.csv" if run.has(f"{place}/ranges.csv") else "",
    }


def row_values(
    rows: pd.DataFrame,
    readings: list[str],
    winners: Mapping[str, Mapping[str, Any]],
    axis: Axis,
    published: pd.DataFrame | None,
) -> dict[str, Any]:
    """Collect one range of n_S: the best combination under each reading, and the published one."""
    by_reading = rows.set_index("reading")
    of_first: Any = by_reading.loc[readings[0]]
    row: dict[str, Any] = {
        "low": of_first["n_S_low_percent"],
        "high": of_first["n_S_high_percent"],
        "cells": [
            winner_values(by_reading.loc[reading].to_dict(), rows, reading, axis) for reading in readings
        ],
        "link": of_first.get(LINK_COLUMN, math.nan),
        "fragmented": is_fragmented(of_first),
        "published": None,
    }
    first = row["cells"][0]
    row["is_best"] = bool(first) and first["combination"] == combination(winners[readings[0]])
    if published is not None:
        of_paper: Any = published[published["range"] == rows["range"].iloc[0]].iloc[0]
        row["published"] = {"combination": combination(of_paper), "d": of_paper["d_published"]}
    return row


def winner_values(
    winner: Mapping[Any, Any], rows: pd.DataFrame, reading: str, axis: Axis
) -> dict[str, Any] | None:
    """Collect the numbers of a best combination; None where no combination keeps so few dots.

    The d of the range that it won stands for it everywhere, so that the page shows one value.
    """
    if "answer" in winner or not combination(winner):
        return None
    row = winner_row(winner, rows, reading)
    d, low, high = (row[f"d_cv{end}"] for end in ("", "_low", "_high"))
    has_interval = not math.isnan(low)
    return {
        "reading": reading,
        "combination": combination(winner),
        "percent": winner["n_S_percent"],
        "d": d,
        "low": low,
        "high": high,
        "n_others": max(0, int(winner.get("n_best_set", 1)) - 1),
        "x": None if math.isnan(d) else axis.place(d),
        "bar": (axis.place(low), axis.place(high)) if has_interval else None,
    }


def winner_row(winner: Mapping[Any, Any], rows: pd.DataFrame, reading: str) -> Mapping[Any, Any]:
    """Return the row of the range that a best combination won, so that one value of d stands for it everywhere; else itself."""
    of_reading = rows[rows["reading"] == reading].dropna(subset=["alpha"]).to_dict("records")
    return next((row for row in of_reading if combination(row) == combination(winner)), winner)


def beaten(rows: pd.DataFrame, reading: str) -> tuple[int, int]:
    """Count the ranges in which d of the best combination lies above 0 with its 95 % interval, and all."""
    measured = rows[(rows["reading"] == reading) & rows["d_cv"].notna()]
    return int((measured["d_cv_low"] > 0).sum()), len(measured)


def fragmented_of(places: list[dict[str, Any]]) -> tuple[int, int] | None:
    """Count the ranges in which the sampling beats a random subset, and those of them whose subset is fragmented."""
    if not places:
        return None
    better = []
    for place in places:
        for row in place["rows"]:
            of_first_reading = row["cells"][0]
            if of_first_reading and of_first_reading["low"] > 0:
                better.append(row)
    return sum(row["fragmented"] for row in better), len(better)


def axis_of(tables: Iterable[pd.DataFrame]) -> Axis:
    """Choose the axis of d: round numbers around 0 and all intervals."""
    table = pd.concat(tables)
    values = pd.concat([table[name].dropna() for name in ("d_cv", "d_cv_low", "d_cv_high")])
    low, high = min(0.0, float(values.min())), max(0.0, float(values.max()))
    step = next((step for step in TICK_STEPS if (high - low) / step <= MAX_STEPS), TICK_STEPS[-1])
    first, last = math.floor(low / step), max(math.ceil(high / step), math.floor(low / step) + 1)
    axis = Axis(first * step, last * step, [])
    axis.ticks.extend((axis.place(k * step), k * step) for k in range(first, last + 1))
    return axis


def over_all(run: Run) -> dict[str, Any]:
    """Tabulate the combination that is best on average over the surfaces in each range, and d of each surface's own best."""
    relation, rows = run.read("relation.csv"), pd.concat(run.grids.values())
    tested = relation["p"].dropna()
    of_first = relation[relation["reading"] == run.readings[0]].dropna(subset=["d"])
    best: Any = of_first.iloc[int(of_first["d"].argmax())] if len(of_first) else None
    return {
        "rows": [*_ranges_over_all(run, relation, rows)],
        "related": int((tested < SIGNIFICANCE_LEVEL).sum()),
        "tested": len(tested),
        "best": None
        if best is None
        else {"combination": combination(best), "d": best["d"], "percent": best["n_S_percent"]},
    }


def _ranges_over_all(run: Run, relation: pd.DataFrame, rows: pd.DataFrame) -> Iterator[dict[str, Any]]:
    """Yield each range of n_S with the combinations that are best on average."""
    for k, in_range in relation.groupby("range"):
        by_reading = in_range.set_index("reading")
        cells = []
        for reading in run.readings:
            d = rows[(rows["reading"] == reading) & (rows["range"] == k)]["d_cv"].dropna()
            best: Any = by_reading.loc[reading]
            cells.append((combination(best), d.median(), d.min(), d.max()))
        yield {
            "low": by_reading["n_S_low_percent"].iloc[0],
            "high": by_reading["n_S_high_percent"].iloc[0],
            "cells": cells,
        }
