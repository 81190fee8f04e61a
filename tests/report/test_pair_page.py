"""Pages of pairs, from tables small enough to say by hand what each must read."""

import pandas as pd

from sparsurf.report.front_page import links_to_pairs
from sparsurf.report.pair_page import pair_markdown, pairs_markdown
from sparsurf.workflow.partner_files import names_of

SETTINGS = {"complementarity": {"interface": 3.0}}


def agreement(propensity):
    rows = [("propensity_smoothed", propensity), ("similarity", 0.99), ("flatness", 0.6), ("hydropathy", 0.7)]
    rows = [(side, score, auc, auc - 0.1, auc + 0.1) for side in (1, 2) for score, auc in rows]
    return pd.DataFrame(rows, columns=["partner", "score", "auc", "low", "high"])


def best(n):
    return pd.DataFrame({"rank": range(1, n + 1), "gap": 2.5})


CONTACTS = pd.DataFrame({"against": ["any pair", "exchanged"], "auc": [0.75, 0.5], "pairs": [9, 9]})


def test_a_pair_begins_with_what_its_propensity_is_worth():
    page = pair_markdown("one", agreement(0.65), CONTACTS, best(12), SETTINGS, ("a.pdb", "b.pdb"))
    for side in (1, 2):
        assert (
            f"Partner {side}: the smoothed propensity finds the interface with AUC 0.65, below the best simple property "
            "(hydropathy over 10 Å (Kyte-Doolittle): 0.70)." in page
        )
    assert "AUC 0.75, above the best" in pair_markdown(
        "one", agreement(0.75), CONTACTS, best(3), SETTINGS, ("a.pdb", "b.pdb")
    )
    assert "| its first patch with a random one | 0.75 | 9 |" in page
    assert "| the same patches paired at random | 0.50 | 9 |" in page
    assert (
        "The first 10 of best_pairs.csv" in page and "| 10 | 2.50 |" in page and "| 11 | 2.50 |" not in page
    )
    assert "The first 3 of" in pair_markdown(
        "one", agreement(0.75), CONTACTS, best(3), SETTINGS, ("a.pdb", "b.pdb")
    )
    assert "| 1 | flatness: roughness R_i | 0.60 | 0.50 | 0.70 |" in page
    assert "\n\nPartner 1: a.pdb. Partner 2: b.pdb.\n\nAUC: " in page


def test_a_pair_that_does_not_touch():
    page = pair_markdown(
        "one", agreement(0.5).head(0), CONTACTS.head(0), best(2), SETTINGS, ("a.pdb", "b.pdb")
    )
    assert "The partners do not touch (or touch everywhere): dots nearer than 3 Å" in page
    assert "Pairs of patches that lie on each other" not in page


def test_partners_without_atoms_are_told():
    known = ("one", agreement(0.5), CONTACTS, best(2), SETTINGS, ("x", "y"))
    assert "Partner 2: y. Partner 2 is a ready surface without atoms: " in pair_markdown(*known, ["2"])
    assert "Partner 2: y. Both are ready surfaces without atoms: " in pair_markdown(*known, ["1", "2"])
    assert "residues.csv is not made" in pair_markdown(*known, ["1"])


def test_partners_are_named_as_the_config_does():
    assert names_of({"proteins": ["a", "b"]}) == ("a", "b")
    assert names_of({"files": ["x/1.pdb", "y/2.cif.gz"]}) == ("1.pdb", "2.cif.gz")
    pair = {"complex": "x/1.pdb", "chains": [["H", "L"], ["A"]]}
    assert names_of(pair) == ("chains H L of 1.pdb", "chain A of 1.pdb")


def test_many_pairs():
    means = pd.DataFrame({"score": ["flatness", "propensity_smoothed"], "mean": [0.6, 0.55], "low": [0.5, 0.5],
                          "high": [0.7, 0.61]})  # fmt: skip
    assert "Over 2 of 3 pairs" in pairs_markdown(means, 3, 2)
    simple = "the best simple property, flatness: roughness R_i, with 0.600.\n"
    assert f"AUC of 0.550 (95 %: 0.500 to 0.610); {simple}" in pairs_markdown(means, 3, 2)
    told = pairs_markdown(means.assign(low=0.49), 3, 2)
    assert "(95 %: 0.490 to 0.610, not to be told from a coin)" in told
    assert f"AUC of 0.550; {simple}" in pairs_markdown(means, 3, 1)
    assert "None of the 4 pairs has an interface" in pairs_markdown(means.head(0), 4, 0)


def test_pairs_alone_lead_to_what_there_is_of_them():
    pages = [
        "pairs/b/view_1.html",
        "pairs/pairs.md",
        "pairs/b/book.png",
        "pairs/a/book.png",
        "tdp43/c1/view.html",
    ]
    links = links_to_pairs(pages)
    assert [heading for heading, _ in links] == ["b", "a"]
    means = pd.DataFrame(
        {"score": ["flatness", "propensity_smoothed"], "mean": [0.6, 0.5], "low": 0.4, "high": 0.7}
    )
    for page in (
        pairs_markdown(means, 2, 2, "Results", links),
        pairs_markdown(means.head(0), 2, 0, "Results", links),
    ):
        assert page.startswith("# Results\n")
        assert (
            "- b: [opened like a book](pairs/b/book.png), [partner 1 to turn](pairs/b/view_1.html)\n- a: ["
            in page
        )
    assert "Where to look" not in pairs_markdown(means, 2, 2)
    assert len(links_to_pairs(["pairs/pairs.md", *(f"pairs/{k}/book.png" for k in range(46))])) == 20
