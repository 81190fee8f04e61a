"""Pages of pairs, from tables small enough to say by hand what each must read."""

import pandas as pd

from sparsurf.report.pair_page import pair_markdown, pairs_markdown

SETTINGS = {"complementarity": {"interface": 3.0}}


def agreement(propensity):
    rows = [("propensity_smoothed", propensity), ("similarity", 0.99), ("flatness", 0.6), ("hydropathy", 0.7)]
    rows = [(side, score, auc, auc - 0.1, auc + 0.1) for side in (1, 2) for score, auc in rows]
    return pd.DataFrame(rows, columns=["partner", "score", "auc", "low", "high"])


def best(n):
    return pd.DataFrame({"rank": range(1, n + 1), "gap": 2.5})


CONTACTS = pd.DataFrame({"against": ["any pair", "exchanged"], "auc": [0.75, 0.5], "pairs": [9, 9]})


def test_a_pair_begins_with_what_its_propensity_is_worth():
    page = pair_markdown("one", agreement(0.65), CONTACTS, best(12), SETTINGS)
    for side in (1, 2):
        assert (
            f"Partner {side}: the smoothed propensity finds the interface with AUC 0.65, below the best simple property "
            "(hydropathy over 10 Å (Kyte-Doolittle): 0.70)." in page
        )
    assert "AUC 0.75, above the best" in pair_markdown("one", agreement(0.75), CONTACTS, best(3), SETTINGS)
    assert "| its first patch with a random one | 0.75 | 9 |" in page
    assert "| the same patches paired at random | 0.50 | 9 |" in page
    assert (
        "The first 10 of best_pairs.csv" in page and "| 10 | 2.50 |" in page and "| 11 | 2.50 |" not in page
    )
    assert "The first 3 of" in pair_markdown("one", agreement(0.75), CONTACTS, best(3), SETTINGS)
    assert "| 1 | flatness: roughness R_i | 0.60 | 0.50 | 0.70 |" in page


def test_a_pair_that_does_not_touch():
    page = pair_markdown("one", agreement(0.5).head(0), CONTACTS.head(0), best(2), SETTINGS)
    assert "The partners do not touch (or touch everywhere): dots nearer than 3 Å" in page
    assert "Pairs of patches that lie on each other" not in page


def test_many_pairs():
    means = pd.DataFrame({"score": ["flatness", "propensity_smoothed"], "mean": [0.6, 0.55], "low": [0.5, 0.5],
                          "high": [0.7, 0.61]})  # fmt: skip
    assert "Over 2 of 3 pairs" in pairs_markdown(means, 3, 2)
    assert "AUC of 0.550 (95 %: 0.500 to 0.610)." in pairs_markdown(means, 3, 2)
    assert "AUC of 0.550.\n" in pairs_markdown(means, 3, 1)
    assert "None of the 4 pairs has an interface" in pairs_markdown(means.head(0), 4, 0)
