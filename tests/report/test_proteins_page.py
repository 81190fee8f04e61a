"""The page on many proteins is what its tables say, and the README repeats it."""

import numpy as np
import pandas as pd
import pytest

import write_proteins
from conftest import ROOT
from sparsurf.report.figures import protein_figures
from sparsurf.report.proteins_answer import answer, counted, of_parameters, of_sign, predicts, readme, share
from sparsurf.report.proteins_page import HYDROGENS, STORED, lost_claims, of_hydrogens, outliers, page
from sparsurf.report.recommendation import FEWEST
from sparsurf.study import protein_variants

DOCS = ROOT / "docs"


@pytest.fixture(scope="module")
def stored():
    return write_proteins.read_stored()


def test_the_stored_page_follows_from_the_stored_tables(stored):
    assert page(stored) == (DOCS / "proteins.md").read_text(encoding="utf-8")
    assert len(answer(stored).strip().split("\n\n")) == 3


def test_the_readme_repeats_the_page(stored):
    text = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert readme(stored) in text


def test_every_protein_counts_once_and_there_are_enough(stored):
    proteins = stored["surfaces"]["protein"]
    assert proteins.is_unique and len(proteins) >= 2 * FEWEST
    assert set(stored["summary"]["protein"]) == set(proteins) == set(stored["enough"]["protein"])
    assert stored["needed_means"]["n"].eq(len(proteins)).all()
    assert (stored["surfaces"]["hydrogens"] == "remove").all()


def test_intervals_over_proteins_hold_what_they_should(stored):
    found = stored["coverage"].set_index("quantity")["coverage"]
    assert len(found) >= 8 and found.min() > 0.9


def test_another_number_changes_the_sentences(stored):
    d = stored["d"].assign(n_above=stored["d"]["n"] - 1)
    d[["own", "own_low", "own_high"]] += 1
    changed = of_sign(stored | {"d": d})
    n = len(stored["surfaces"])
    assert f"interval on {n - 1} or more of them" in changed and f"above 0 on {n - 1} at most" in changed
    own = d[(d["islands"] == "kept") & (d["range"] > 0) & (d["n_S_percent"] < 50)]["own"]
    assert f"held out, d = {own.min():+.2f} to {own.max():+.2f} under `kept`" in changed
    every = of_sign(stored | {"d": d.assign(n_above=d["n"])})
    assert "interval on every one;" in every  # as no range lies below 0 in this table
    assert "above 0 on none (" in of_sign(stored | {"d": d.assign(n_above=0)})
    rows = d["range"].isin([0, 2, 8, 9]) & (d["islands"] == "kept")
    low = d.assign(own_high=np.where(rows, -0.01, 0.01)).assign(
        own=np.where(d["range"] == 9, -0.4, np.where(d["range"] == 5, -0.9, -0.2))
    )
    low["n_S_percent"] = np.where(d["range"] == 9, 87.7, np.where(d["range"] == 8, 74.9, 20.0))
    assert "of them (below 0, −0.40 to −0.20, at n_S = 20, 75 and 88 %); under" in of_sign(
        stored | {"d": low}
    )
    one = low.assign(own_high=np.where(rows & (d["range"] == 9), -0.01, 0.01))
    assert "of them (below 0, −0.40, at n_S = 88 %); under" in of_sign(stored | {"d": one})


def test_the_recovered_grid_is_told_where_it_was_measured(stored):
    values = {"range": [0, 1, 2, 3], "n": 7, "n_S_percent": [9.0, 2.5, 20, 30], "n_above": [np.nan, 3, 1, 2]}
    values |= {
        "own": [0.1, 0.5, -0.2, 0.3],
        "own_low": [0, 0.4, -0.3, 0.2],
        "own_high": [0.2, 0.6, -0.1, 0.4],
    }
    said = of_sign(stored | {"recovered": pd.DataFrame(values)})
    assert said.endswith(
        "(`recovered`; 7 small proteins, a quarter of the grid), d = +0.50 (+0.40 to +0.60) on average at the fewest dots "
        "(n_S = 2.5 %) and −0.20 to +0.30 beyond (mean +0.10 (+0.00 to +0.20))."
    )
    on_all = of_sign(stored | {"recovered": pd.DataFrame(values | {"n": stored["d"]["n"].max()})})
    assert "(`recovered`; a quarter of the grid), d = +0.50" in on_all
    few = stored["recovered"].assign(n=stored["d"]["n"].max() - 1)
    assert f"On the {few['n'].max()} smallest proteins, a quarter" in page(stored | {"recovered": few})
    assert "On all of them, a quarter" in page(stored | {"recovered": few.assign(n=few["n"] + 1)})
    without = {name: table for name, table in stored.items() if name != "recovered"}
    assert "`recovered`" not in of_sign(without) and "### islands: recovered" not in page(without)


def test_the_whole_recovered_grid_is_told_beside_its_quarter(stored):
    values = {
        "range": [0, 1, 4],
        "n": 5,
        "n_S_percent": [1.0, 2.25, 30.0],
        "n_S_percent_quarter": [9.0, 3.0, 29.04],
    }
    for name, d in {"whole": 0.5, "quarter": 0.1, "gain": 0.4}.items():
        values |= {
            name: [d, d + 1, d + 2],
            f"{name}_low": [d - 0.05, d, d],
            f"{name}_high": [d + 0.05, d + 3, d + 4],
        }
    told = page(stored | {"recovered_whole": pd.DataFrame(values)})
    assert (
        "change that by +0.40 (+0.35 to +0.45): on the 5 smallest proteins the whole grid was recovered as well (2 draws), "
        "with a mean d of +0.50 (+0.45 to +0.55), a quarter of it there having +0.10 (+0.05 to +0.15)."
    ) in told
    rows = [line for line in told.splitlines() if line.endswith("| +2.40 (+0.40 to +4.40) |")]
    assert rows == [
        "| 4 | 30.0 | 29.0 | +2.50 (+0.50 to +4.50) | +2.10 (+0.10 to +4.10) | +2.40 (+0.40 to +4.40) |"
    ]
    assert "whole grid was recovered" not in page({k: v for k, v in stored.items() if k != "recovered_whole"})


def test_mean_roughness_predicts_only_what_stays_after_correction(stored):
    one = stored["relation"].iloc[:1]
    many = pd.concat([one] * 20, ignore_index=True).assign(p=0.5, gain_low=-1.0, over_all_low=-1.0)
    assert counted(many) == (20, 0, 0, 0)
    many.loc[:2, "p"] = [0.0024, 0.0026, 0.04]  # 0.05 / 20 = 0.0025
    assert counted(many) == (20, 3, 1, 0)
    for other in ("gain_low", "over_all_low"):  # neither alone is enough
        assert counted(many.assign(**{other: 0.1})) == (20, 3, 1, 0)
    many.loc[:1, ["gain_low", "over_all_low"]] = 0.1
    assert counted(many) == (20, 3, 1, 1)
    assert of_parameters(stored | {"relation": many}).startswith(
        "**Mean roughness predicts the best parameters in 1 of 20 ranges and readings.**"
    )
    assert counted(many.assign(p=float("nan")))[0] == 0
    many["gain_low"] = -1.0
    assert of_parameters(stored | {"relation": many}).startswith("**Mean roughness does not predict")
    assert "Its mean roughness does not predict" in readme(stored | {"relation": many})
    # of 20 tests in which roughness plays no part, at most 3 have p < 0.05 in 98 of 100 cases
    many["p"] = [0.04] * 4 + [0.5] * 16
    assert predicts(many) == "mean roughness tells too little of the best parameters to choose by it"
    assert predicts(many.assign(p=[0.04] * 3 + [0.5] * 17)).startswith("mean roughness does not predict")


def test_a_rule_that_turns_a_claim_is_named():
    claims = {"d_kept": (-0.1, -0.3, 0.1), "d_surface": (-0.1, -0.2, -0.05), "factor": (0.9, 0.5, 1.3)}
    rows = pd.DataFrame(
        {
            ("other", claim): dict(zip(("value", "value_low", "value_high"), values, strict=True))
            for claim, values in claims.items()
        }
    ).T
    said = list(lost_claims("other", rows))
    assert (
        len(said) == 2
        and "no longer above 0 (−0.10 (−0.30 to +0.10))" in said[0]
        and "saves no dots" in said[1]
    )


def test_an_interval_that_reaches_zero_turns_the_claim_of_the_other_reading():
    claims = {"d_kept": (0.3, 0.1, 0.5), "d_surface": (-0.1, -0.25, 0.05), "factor": (2.0, 1.5, 2.5)}
    index = pd.MultiIndex.from_product([["other"], claims])
    rows = pd.DataFrame([*claims.values()], index=index, columns=["value", "value_low", "value_high"])
    assert list(lost_claims("other", rows)) == [
        "With other, d under `surface` is no longer below 0 (−0.10 (−0.25 to +0.05))."
    ]


def test_what_hydrogens_change_is_said_where_it_was_measured(stored):
    rows = stored["variants"].set_index(["variant", "claim"])
    assert f"{100 * rows.loc[(HYDROGENS, 'held'), 'value']:.0f} % of the ranges" in of_hydrogens(rows)
    assert of_hydrogens(rows.drop(index=HYDROGENS, level=0)) == ""
    assert HYDROGENS in protein_variants.VARIANTS


def test_too_few_proteins_turn_no_claim():
    rows = pd.DataFrame(
        {("few", claim): (0.1, float("nan"), float("nan")) for claim in ("d_kept", "d_surface", "factor")}
    ).T
    rows.columns = ["value", "value_low", "value_high"]
    assert not list(lost_claims("few", rows))


def test_a_protein_far_from_all_others_is_named():
    row = {
        "sampler": "paper",
        "islands": "recovered",
        "percent": 2.5,
        "Z": 1.0,
        "highest": 2.1,
        "highest_protein": "x",
    }
    assert "paper, recovered, 2.5 %: x (2.1)" in outliers(pd.DataFrame([row]))
    assert outliers(pd.DataFrame([row | {"highest": 1.9}])).endswith("there: none.\n")


def test_shares_beyond_what_was_measured():
    assert [share(x) for x in (0.0, 2.04, float("inf"))] == ["< 1", "2.0", "> 60"]


def test_page_and_figures_are_made_again_from_the_tables(stored, tmp_path, monkeypatch):
    monkeypatch.setattr(protein_figures, "FIGURES", {"d": protein_figures.FIGURES["d"]})
    tables = tmp_path / "tables"
    tables.mkdir()
    for name in set(STORED) & set(stored):
        stored[name].to_csv(tables / f"proteins_{name}.csv", index=False)
    asked, of_run = [], {name: table for name, table in stored.items() if name not in STORED}
    monkeypatch.setattr(write_proteins, "read_run", lambda folder: asked.append(folder) or of_run)
    write_proteins.main(None, tmp_path, tmp_path / "evidence")
    assert asked == [tmp_path / "evidence"]
    assert (tmp_path / "proteins.md").read_bytes() == (DOCS / "proteins.md").read_bytes()
    assert (tmp_path / "proteins_d.png").stat().st_size > 10_000


@pytest.mark.parametrize("name", list(protein_figures.FIGURES))
def test_figures_show_every_protein(stored, name):
    figure = protein_figures.FIGURES[name](stored)
    n = len(stored["surfaces"])
    sizes = [len(line.get_xdata()) for ax in figure.axes for line in ax.lines]
    assert n in sizes or name in ("needed", "roughness") or max(sizes) > n
