"""First page of a run in batches: counts, distributions, the most unusual surfaces, failures by reason."""

from __future__ import annotations

from typing import Any

import pandas as pd

from sparsurf.report.first_page import Rows
from sparsurf.report.numbers import number, share, span

TEMPLATE = "batches.html.j2"
MAX_ROWS = 100  # surfaces in the table of the page
MAX_NAMES = 20  # of failures alike


def batches_page(
    run: str,
    surfaces: pd.DataFrame,
    unusual: pd.DataFrame,
    failures: list[tuple[str, list[str]]],
    warnings: list[tuple[list[str], str]],
    n_batches: int,
    studied: Rows,
) -> dict[str, Any]:
    """Collect the values of the page of the run.

    `unusual` is from `batches.summary.most_unusual`, `failures` lists (reason, names), `warnings` (names, sentence), and
    `studied` the rows of the structures with pages of their own, see `first_page.rows_of`.
    """
    n_failed = sum(len(names) for _, names in failures)
    known: dict[str, Any] = {
        "run": run,
        "n": len(surfaces),
        "n_failed": n_failed,
        "n_batches": n_batches,
        "failures": [(reason, names[:MAX_NAMES], len(names)) for reason, names in failures],
        "warnings": warnings,
        "masked": _masked(surfaces),
        "rows": [],
        "studied": studied,
    }
    if surfaces.empty:
        return known
    return known | {
        "dots": f"{surfaces['N'].sum():,}",
        "kept": share(100 * surfaces["minimal_n_S"].sum() / surfaces["N"].sum()),
        "roughness": number(surfaces["mean_roughness"].median()),
        "roughness_span": span(surfaces["mean_roughness"]),
        "atoms_span": span(surfaces["atoms"], "{:,.0f}".format),
        "rows": [_row(dict(row)) for _, row in unusual.iterrows()],
    }


def _masked(surfaces: pd.DataFrame) -> dict[str, str] | None:
    """Count the residues that their pLDDT left out, and all residues, of predicted models; None if there is no such model."""
    models = surfaces[surfaces["masked_residues"].notna()]
    if models.empty:
        return None
    masked = int(models["masked_residues"].sum())
    numbers = {"models": len(models), "masked": masked, "residues": masked + int(models["residues"].sum())}
    return {key: f"{value:,}" for key, value in numbers.items()}


def _row(surface: dict[Any, Any]) -> tuple[str, list[tuple[str, str]]]:
    """Format a surface: its name, and (number to sort by, text) of each cell."""
    cells = [
        (surface["deviation"], number(surface["deviation"], 1)),
        (surface["unusual"], surface["unusual"]),
        (surface["atoms"], f"{surface['atoms']:,}"),
        (surface["area"], number(surface["area"], 0)),
        (surface["volume"], number(surface["volume"], 0)),
        (surface["mean_roughness"], number(surface["mean_roughness"])),
        (surface["components"], f"{surface['components']:,}"),
        (surface["cavities"], f"{surface['cavities']:,}"),
    ]
    return surface["protein"], [(str(key), text) for key, text in cells]
