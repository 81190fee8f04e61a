"""The pages of sites: one that was sought on other surfaces, and two forms compared."""

import math

import pandas as pd

from sparsurf.report.numbers import number

TEMPLATE, OF_FORMS = "site.html.j2", "changes.html.j2"
SHOWN = 10  # hits, or residues
RARE = 0.05  # p times targets below which a hit counts
FITTED = 12  # places of the smallest sites that p was fitted on


def site_page(name, site, query, hits, pairs, n_places):
    """What the template asks for.

    Parameters
    ----------
    name : str
    site : dict, its entry of the config
    query : str, the conformation that has the site
    hits, pairs : DataFrames of hits.csv and matches.csv
    n_places : int, places of the site that were laid on the targets
    """
    best = by_rarity(hits).iloc[0]
    own = pairs[pairs["rank"] == best["rank"]]
    return {
        "name": name,
        "query": query,
        "residues": site["residues"],
        "n_places": n_places,
        "few": n_places < FITTED,
        "n_targets": len(hits),
        "best": {"target": best["target"], "where": where(best), "p": p_value(best["p"])},
        "agree": f"{best['places']:.0f} of {n_places}",
        "n_found": found_on(hits),
        "rows": [
            (
                row["rank"], row["target"], where(row) if row["places"] else "", number(row["score"]),
                p_value(row["p"]), row["places"],
                f"superposed/{laid_file(row['rank'], row['target'])}" if row["places"] else "",
            )
            for row in hits.head(SHOWN).to_dict("records")
        ],
        "met": met(own),
    }  # fmt: skip


def laid_file(rank, target):
    """Name of the file of the query laid on a hit."""
    return f"{rank:02d}_{target.replace('/', '_')}.pdb"


def by_rarity(hits):
    """The rows of a hits.csv, the smallest p first: larger targets score higher by chance."""
    return hits.sort_values("p", kind="stable")


def found_on(hits):
    """On how many targets a site is found: p times their number is rare."""
    return int(is_found(hits).sum())


def is_found(hits):
    """Which rows of a hits.csv count, bool."""
    return hits["p"] * len(hits) < RARE


def where(row):
    """A residue as people write it, A:SER195; empty without."""
    return residue_text(row["chain"], row["residue_name"], row["residue"])


def residue_text(chain, name, number):
    """Name and number of a residue behind its chain, as far as they are known."""
    return (f"{chain}:" if chain else "") + f"{name}{number}" if name else ""


def p_value(p):
    """p with one digit that counts."""
    return "below 0.0001" if p < 1e-4 else f"{p:.1g}"


def met(pairs):
    """Of each residue of the site, the residues that its places meet: list of (residue, residues)."""
    number_of = pairs["residue"].str.extract(r"(-?\d+)", expand=False).astype(float)
    found = {}
    for row in (
        pairs.assign(number_of=number_of).sort_values(["chain", "number_of"], kind="stable").itertuples()
    ):
        there = residue_text(row.chain_there, row.residue_name_there, row.residue_there)
        found.setdefault(residue_text(row.chain, row.residue_name, row.residue), []).append(there)
    return [(own, ", ".join(dict.fromkeys(filter(None, others)))) for own, others in found.items()]


def read_residues(path):
    """A table of residues, "" where a chain has no name; a chain or an ion may be called NA."""
    names = dict.fromkeys(["chain", "residue"], str)
    return pd.read_csv(path, dtype=names, keep_default_na=False, na_values=[""]).fillna({"chain": ""})


def changes_page(name, forms, table, rare):
    """What the template of two forms asks for.

    Parameters
    ----------
    name : str
    forms : two str, the conformations
    table : DataFrame of changes.csv
    rare : float, share of the residues of one form that lie above a floor by chance
    """
    known = table.dropna(subset=["total"])
    order = (known["total"] / known[["total_floor", "total_moved"]].max(axis=1)).sort_values(ascending=False)
    return {
        "name": name,
        "forms": list(forms),
        "n": len(known),
        "n_buried": len(table) - len(known),
        "n_above": int(known["above"].sum()),
        "n_moved": int(known["above_moved"].sum()),
        "n_chance": f"{rare * len(known):.0f}",
        "n_mutated": int((table["residue_name"] != table["residue_name_second"]).sum()),
        "most": [change_row(table.loc[k]) for k in order.index[:SHOWN]],
    }


def change_row(row):
    """Cells of one residue: its name, change and floors, the two channels farthest above theirs, differences of two fields."""
    named = residue_text(row["chain"], row["residue_name"], row["residue"])
    changed = row["residue_name_second"] != row["residue_name"]
    channels = [key.removesuffix("_floor") for key in row.index[::-1] if key.endswith("_floor")]
    over = sorted(channels, key=lambda each: -row[each] / row[f"{each}_floor"])
    over.remove("total")
    own = [each for each in over[:2] if row[each] > row[f"{each}_floor"]]
    return [
        f"{named} → {row['residue_name_second']}" if changed else named,
        *(number(row[key]) for key in ("total", "total_floor", "total_moved")),
        ", ".join(own),
        signed(row["potential_difference"], 1),
        signed(row["hydropathy_difference"], 1),
    ]


def signed(x, digits):
    """A number with its sign."""
    text = number(x, digits)
    return text if math.isnan(x) or x <= 0 or not text.strip("0.") else f"+{text}"
