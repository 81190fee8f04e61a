"""Values of the page of two forms that are compared."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import pandas as pd

if TYPE_CHECKING:
    from sparsurf.report.numbers import Row

TEMPLATE = "changes.html.j2"
N_SHOWN = 10  # residues


def where(row: Row) -> str:
    """Name the residue of a row, such as A:SER195."""
    return (f"{row['chain']}:" if row["chain"] else "") + f"{row['residue_name']}{row['residue']}"


def over_floor(table: pd.DataFrame) -> pd.Series:
    """Divide the change of each residue of changes.csv by the larger of its two floors; NaN if it is buried."""
    return table["total"] / table[["total_floor", "total_moved"]].max(axis=1)


def changes_page(
    name: str, forms: Sequence[str], table: pd.DataFrame, rare: float, unmatched: Sequence[str] = ("", "")
) -> dict[str, Any]:
    """Collect the values of the page of two forms.

    `rare` is the share of the residues of one form above a floor by chance, and `unmatched` names the residues of each form
    that the other lacks.
    """
    known = table.dropna(subset=["total"])
    order = over_floor(known).sort_values(ascending=False)
    most = table.loc[order.index[:N_SHOWN]].to_dict("records")
    return {
        "name": name,
        "forms": list(forms),
        "n": len(known),
        "n_buried": len(table) - len(known),
        "n_above": int(known["above"].sum()),
        "n_moved": int(known["above_moved"].sum()),
        "n_chance": rare * len(known),
        "unmatched": [(form, residues) for form, residues in zip(forms, unmatched, strict=True) if residues],
        "n_mutated": int((table["residue_name"] != table["residue_name_second"]).sum()),
        "most": [row | {"where": where(row), "above": above_floor(row)} for row in most],
    }


def above_floor(row: Row) -> list[str]:
    """Name the two channels of a residue that are farthest above their floors; fewer if others are below."""
    channels = [
        key.removesuffix("_floor") for key in [*row][::-1] if key.endswith("_floor") and key != "total_floor"
    ]
    ordered = sorted(channels, key=lambda channel: -row[channel] / row[f"{channel}_floor"])
    return [channel for channel in ordered[:2] if row[channel] > row[f"{channel}_floor"]]
