"""Values of the pages of sites: one found on other surfaces, and two forms compared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import pandas as pd

if TYPE_CHECKING:
    from sparsurf.report.numbers import Row

TEMPLATE, OF_FORMS = "site.html.j2", "changes.html.j2"
N_SHOWN = 10  # hits, or residues
MAX_EXPECTED = 0.05  # a hit counts if p times the number of targets is smaller
MIN_PLACES_FOR_P = 8  # number of places of the smallest sites on which p was fitted


def site_page(
    name: str, site: dict[str, Any], query: str, hits: pd.DataFrame, pairs: pd.DataFrame, n_places: int
) -> dict[str, Any]:
    """Collect the values of the page of one site.

    Parameters
    ----------
    name : str
    site : dict, its entry of the config
    query : str, the conformation that has the site
    hits, pairs : DataFrames of hits.csv and matches.csv
    n_places : int, places of the site that were superposed onto the targets
    """
    best = by_rarity(hits).iloc[0].to_dict()
    rows = hits.head(N_SHOWN).to_dict("records")
    return {
        "name": name,
        "query": query,
        "residues": site["residues"],
        "n_places": n_places,
        "few": n_places < MIN_PLACES_FOR_P,
        "n_targets": len(hits),
        "best": best | {"where": where(best)},
        "n_found": found_on(hits),
        "rows": [
            row | {"where": where(row), "file": f"superposed/{superposed_file(row['rank'], row['target'])}"}
            for row in rows
        ],
        "met": met(pairs[pairs["rank"] == best["rank"]]),
    }


def superposed_file(rank: int, target: str) -> str:
    """Name the file of the query superposed onto a hit."""
    return f"{rank:02d}_{target.replace('/', '_')}.pdb"


def by_rarity(hits: pd.DataFrame) -> pd.DataFrame:
    """Sort the rows of a hits.csv by p, since larger targets score higher by chance."""
    return hits.sort_values("p", kind="stable")


def found_on(hits: pd.DataFrame) -> int:
    """Count the targets on which a site is found."""
    return int(is_found(hits).sum())


def is_found(hits: pd.DataFrame) -> pd.Series:
    """Select the rows of a hits.csv whose p times the number of targets is small, bool."""
    return hits["p"] * len(hits) < MAX_EXPECTED


def where(row: Row) -> str:
    """Name the residue of a row, such as A:SER195; empty if unknown."""
    return residue_text(row["chain"], row["residue_name"], row["residue"])


def residue_text(chain: str, name: str, number: str) -> str:
    """Join chain, name and number of a residue as far as they are known."""
    return (f"{chain}:" if chain else "") + f"{name}{number}" if name else ""


def met(pairs: pd.DataFrame) -> list[tuple[str, str]]:
    """List, for each residue of the site, the residues that its places match, with the number of places: (residue, residues)."""
    number_of = pairs["residue"].str.extract(r"(-?\d+)", expand=False).astype(float)
    ordered = pairs.assign(number_of=number_of).sort_values(["chain", "number_of"], kind="stable")
    partners: dict[str, list[str]] = {}
    for row in ordered.to_dict("records"):
        there = residue_text(row["chain_there"], row["residue_name_there"], row["residue_there"])
        partners.setdefault(where(row), []).append(there)
    counted = {residue: Counter(filter(None, names)).most_common() for residue, names in partners.items()}
    return [(residue, ", ".join(f"{name} ({n})" for name, n in names)) for residue, names in counted.items()]


def read_residues(path: Path | str) -> pd.DataFrame:
    """Read a table of residues; "" for a chain without name, while a chain or an ion may be called NA."""
    names = dict.fromkeys(["chain", "residue"], str)
    return pd.read_csv(path, dtype=names, keep_default_na=False, na_values=[""]).fillna({"chain": ""})


def over_floor(table: pd.DataFrame) -> pd.Series:
    """Divide the change of each residue of changes.csv by the larger of its two floors; NaN if it is buried."""
    return table["total"] / table[["total_floor", "total_moved"]].max(axis=1)


def changes_page(
    name: str, forms: Sequence[str], table: pd.DataFrame, rare: float, unmatched: Sequence[str] = ("", "")
) -> dict[str, Any]:
    """Collect the values of the page of two forms.

    Parameters
    ----------
    name : str
    forms : two str, the conformations
    table : DataFrame of changes.csv
    rare : float, share of the residues of one form above a floor by chance
    unmatched : two str, residues of each form that the other lacks
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
