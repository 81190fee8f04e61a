"""The page of a site that was sought on other surfaces."""

from sparsurf.report.numbers import number

TEMPLATE = "site.html.j2"
SHOWN = 10  # hits
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
    best = hits.iloc[0]
    own = pairs[pairs["rank"] == 1]
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
                row["rank"], row["target"], where(row), number(row["score"]), p_value(row["p"]), row["places"],
                f"superposed/{row['rank']:02d}_{row['target'].replace('/', '_')}.pdb",
            )
            for row in hits.head(SHOWN).to_dict("records")
        ],
        "met": met(own),
    }  # fmt: skip


def found_on(hits):
    """On how many targets a site is found: p times their number is rare."""
    return int((hits["p"] * len(hits) < RARE).sum())


def where(row):
    """A residue as people write it, A:SER195; empty without."""
    return residue_text(row["chain"], row["residue_name"], row["residue"])


def residue_text(chain, name, number):
    """Chain, name and number of a residue; '' where they are unknown."""
    return f"{chain}:{name}{number}" if name else ""


def p_value(p):
    """p with one digit that counts."""
    return "below 0.0001" if p < 1e-4 else f"{p:.1g}"


def met(pairs):
    """Of each residue of the site, the residues that its places meet: list of (residue, residues)."""
    found = {}
    for row in pairs.itertuples():
        there = residue_text(row.chain_there, row.residue_name_there, row.residue_there)
        found.setdefault(residue_text(row.chain, row.residue_name, row.residue), []).append(there)
    return [(own, ", ".join(dict.fromkeys(filter(None, others)))) for own, others in found.items()]
