"""Two forms and two partners on the first page: what changes, and whether matching shapes show the interface."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pandas as pd

from sparsurf.views.numbers import number, signed
from sparsurf_study import catalogue
from sparsurf_study.pairs.ranking import BASELINE, MAIN_SCORE, means_over_pairs
from sparsurf_study.report.first_page.run import MAX_ROWS, MAX_SHOWN, Figure, Run, TableLink
from sparsurf_study.report.numbers import auc_of, most_of

LISTED_RESIDUES = 10  # The residues that change most are listed.
CHANCE = 0.5  # AUC of a score that says nothing
SCORE_NAMES = {MAIN_SCORE: "complementarity", BASELINE: "protrusion"}


def of_changes(run: Run) -> list[dict[str, Any]]:
    """Collect each two forms that are compared."""
    return [comparison(run, folder) for folder in run.ending("changes.csv")[:MAX_SHOWN]]


def comparison(run: Run, folder: str) -> dict[str, Any]:
    """Collect what changes from one form to the other, residue by residue."""
    from sparsurf_study.pairs.changes import SHARE_ABOVE_FLOOR, over_floor  # here: it loads every kernel

    table = run.read(f"{folder}/changes.csv")
    measured = table.dropna(subset=["total"])
    ratio = over_floor(measured)
    order = ratio.sort_values(ascending=False).index[:LISTED_RESIDUES]
    rows: list[list[Any]] = []
    for index, row in zip(order, table.loc[order].to_dict("records"), strict=True):
        line = [number(row[name]) for name in ("total", "total_floor", "total_moved")]
        fields = [signed(row[f"{name}_difference"], 1) for name in ("potential", "hydropathy")]
        rows.append([residue_name(row), number(ratio[index], 1), *line, above_floor(row), *fields])
    columns = ["residue", "change over the larger floor", "change", "floor: other dots", "floor: moved atoms"]
    columns += ["most in", "potential (kT/e)", "hydropathy"]
    moved, name = int(table["above_moved"].sum()), folder.split("/")[-1]
    return {
        "name": name,
        "n_moved": moved,
        "n_known": len(measured),
        "by_chance": round(SHARE_ABOVE_FLOOR * len(measured)),
        "most": most_of(moved, len(measured)),
        "top": [row[0] for row in rows[:3]],
        "n_buried": len(table) - len(measured),
        "n_mutated": int((table["residue_name"] != table["residue_name_second"]).sum()),
        "figure": run.figure(f"{folder}/changes.png"),
        "table": TableLink(columns, rows),
        "links": run.links(folder, "changes"),
    }


def residue_name(row: Mapping[Any, Any]) -> str:
    """Name the residue of a row, such as A:SER195, with its other name on a mutant."""
    name = (f"{row['chain']}:" if row["chain"] else "") + f"{row['residue_name']}{row['residue']}"
    other = row["residue_name_second"]
    return name if row["residue_name"] == other else f"{name} → {other}"


def above_floor(row: Mapping[Any, Any]) -> str:
    """Name the two channels of a residue that are farthest above their floors; fewer if others are below."""
    names = [key.removesuffix("_floor") for key in [*row][::-1] if key.endswith("_floor")]
    channels = [name for name in names if name != "total"]
    ordered = sorted(channels, key=lambda name: -row[name] / row[f"{name}_floor"])
    return ", ".join(name for name in ordered[:2] if row[name] > row[f"{name}_floor"])


def of_pairs(run: Run) -> dict[str, Any] | None:
    """Collect how well matching shapes show the interface of each pair, next to protrusion."""
    if not run.has("pairs/pairs.csv"):
        return None
    table = run.read("pairs/pairs.csv")
    names = [folder.split("/")[1] for folder in run.ending("book.png")]
    rows: list[list[Any]] = []
    for name in names[:MAX_ROWS]:
        files = run.file_cells(f"pairs/{name}", "pairs")
        sides = list(table[table["complex"] == name].groupby("partner"))
        for k, (side, scores) in enumerate(sides):
            aucs = [auc_of(scores.set_index("score"), score, "auc") for score in SCORE_NAMES]
            rows.append([name if k == 0 else "", str(side), *aucs, files if k == 0 else ""])
        if not sides:
            rows.append([name, "", "no interface", "", files])
    several = len(names) > 1
    figures = []
    for name in names[:MAX_SHOWN]:
        caption = name if several else catalogue.outputs()["pairs/<pair>/book.png"].caption
        view = f"pairs/{name}/view.html"
        figures.append(Figure(f"pairs/{name}/book.png", caption, view if run.has(view) else ""))
    n = int(table["complex"].nunique())
    return {
        "n_listed": len(names),
        "n_touching": n,
        "scores": [score_values(table, score, label) for score, label in SCORE_NAMES.items()] if n else [],
        "figure": run.figure("pairs/pairs.png") if n > 1 else None,
        "figures": figures,
        "table": TableLink(
            ["pair", "partner", *(f"{label}: AUC (95 %)" for label in SCORE_NAMES.values()), "files"], rows
        ),
    }


def score_values(table: pd.DataFrame, score: str, label: str) -> dict[str, Any]:
    """Collect the AUC of a score: the mean over pairs, or those of the two partners of a single pair."""
    if table["complex"].nunique() > 1:
        means = means_over_pairs(table)
        values = means.loc[means["score"] == score, ["mean", "low", "high"]].to_numpy().tolist()
    else:
        values = table.loc[table["score"] == score, ["auc", "low", "high"]].to_numpy().tolist()
    return {"name": label, "values": values, "verdict": verdict_of(values)}


def verdict_of(values: list[list[float]]) -> str:
    """Compare the AUC of each value with chance by its 95 % interval; the values of a single pair are those of its partners."""
    above = [k for k, (_, low, _) in enumerate(values, 1) if low > CHANCE]
    below = [k for k, (*_, high) in enumerate(values, 1) if high < CHANCE]
    if above and len(above) < len(values):
        return f"Better than chance on partner {above[0]} only"
    if above:
        return "Better than chance"
    return "Worse than chance" if below and len(below) == len(values) else "No better than chance"
