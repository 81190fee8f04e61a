"""The tables over many proteins take each number from its place: made-up proteins whose numbers all differ."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from test_over_proteins import curve, floor
from test_summary import result, run_of

from measures import over_proteins, protein_tables, protein_variants
from measures.studies import Measured
from sparsurf.sampling import published

MANY = published.parameter_grid(np.linspace(0.1, 1, 10), [0], [0, 2, 4], [0])
NAMES = ["a", "b", "c", "d"]
RHO_NEEDED = {"n": 4, "rho": 0.9}


def measured_of(s):
    """One protein: its curves need s + 1 times as many dots as a uniform draw's, and its floors grow with s."""
    name = NAMES[s]
    factors = {("uniform", "as_written"): 1.0, ("farthest", "as_written"): 0.8, ("uniform", "recovered"): 0.7}
    factors[("farthest", "recovered")] = 0.2 + 0.1 * s
    curves = pd.concat([curve(name, *keys, factor) for keys, factor in factors.items()], ignore_index=True)
    floors = floor(name, **{"fresh dots": 0.5 + 0.1 * s, "turned": 0.8 + 0.1 * s, "atoms moved 0.1 Å": 0.6})
    floors = pd.concat([floors, floor(name, **{"atoms moved 0.3 Å": 0.9 + 0.05 * s})], ignore_index=True)
    own = result(f"{name}/c1", 0.5 + 0.03 * s, s % 3, s, combinations=MANY)
    empty = (own.ranges["reading"] == "as_written") & (own.ranges.groupby("reading").cumcount() == 1)
    own = replace(
        own, ranges=own.ranges.assign(best_set=own.ranges["best_set"].mask(empty))
    )  # as a file has ""
    return Measured(own, floors.drop(columns="protein"), curves.drop(columns="protein"))


@pytest.fixture(scope="module")
def measured():
    return [measured_of(s) for s in range(4)]


@pytest.fixture
def found(measured, monkeypatch):
    monkeypatch.setattr(over_proteins, "power", lambda n, rng: RHO_NEEDED | {"n": n})
    monkeypatch.setattr(over_proteins, "coverage_of_mean", lambda values, rng: values.sum())
    monkeypatch.setattr(
        over_proteins, "coverage_of_set", lambda results, reading, k, n, rng: (k, n, reading, len(results))
    )
    return protein_tables.tables_of(measured, *run_of([each.result for each in measured]).values())


@pytest.fixture(scope="module")
def summary(measured):
    return run_of([each.result for each in measured])["summary"]


def test_every_table_is_there_and_of_these_proteins(found):
    assert {"d", "plateaus", "needed_means", "coverage"} < set(found)
    assert "recovered" not in found
    assert found["power"]["n"].tolist() == [4]
    assert found["d"].query("range == 0")["n"].tolist() == [4, 4]
    own = found["by_n_s"].set_index(["sampler", "reading", "percent"])
    # Z = sqrt(10 factor / percent), over floors of 0.5 to 0.8
    z = np.sqrt(np.array([0.2, 0.3, 0.4, 0.5]))
    assert own.loc[("farthest", "recovered", 10.0), "Z"] == pytest.approx(z.mean())
    assert own.loc[("farthest", "recovered", 10.0), "over_floor"] == pytest.approx(
        (z / [0.5, 0.6, 0.7, 0.8]).mean()
    )


def test_quantities_are_those_of_farthest_point_dots_recovered(found, summary):
    needed = over_proteins.needed(pd.concat([measured_of(s)[2].assign(protein=NAMES[s]) for s in range(4)]))
    quantities = protein_tables.quantities_of(summary, needed)
    assert list(quantities) == [
        "cross-validated d, `as_coded`", "cross-validated d, `as_written`", "times fewer than 25 % uniform",
        "times fewer than 40 % uniform",
    ]  # fmt: skip
    held = summary.query("reading == 'as_coded' and n_combinations > 0 and protein == 'b'")["d_cv"].mean()
    assert quantities["cross-validated d, `as_coded`"]["b"] == pytest.approx(held)
    assert (
        quantities["cross-validated d, `as_written`"].max()
        < 0
        < quantities["cross-validated d, `as_coded`"].min()
    )
    for s, name in enumerate(NAMES):
        assert quantities["times fewer than 25 % uniform"][name] == pytest.approx(1 / (0.2 + 0.1 * s))


def test_coverage_is_asked_of_the_numbers_that_have_intervals(found):
    table = found["coverage"]
    means = table[table["interval"] == "mean"].set_index("quantity")["coverage"]
    factor = 1 / np.array([0.2, 0.3, 0.4, 0.5])
    assert means["ln of times fewer than 25 % uniform"] == pytest.approx(np.log(factor).sum())
    for percent, words in ((2.5, "2.5"), (10, "10")):
        wanted = np.sqrt(10 / factor / percent) / [0.5, 0.6, 0.7, 0.8]
        assert means[f"Z recovered from {words} %, over fresh dots"] == pytest.approx(wanted.sum())
    assert "cross-validated d, `as_coded`" in means and not any("n_S" in words for words in means.index)
    sets = table[table["interval"] == "confidence set"]
    assert sets["coverage"].tolist() == [
        (k, 10, reading, 4) for reading in ("as_coded", "as_written") for k in (2, 5)
    ]
    assert sets["quantity"].tolist()[:2] == [
        "the best of range 2, `as_coded`",
        "the best of range 5, `as_coded`",
    ]
    assert (table["n"] == 4).all()


def test_claims_of_variants_are_set_against_the_unvaried_rules(measured):
    worse = [
        each._replace(
            by_n_s=each.by_n_s.assign(Z=each.by_n_s["Z"] * (1 + (each.by_n_s["reading"] == "recovered")))
        )
        for each in measured[:2]
    ]
    new = measured[3]._replace(
        result=replace(measured[3].result, protein="new")
    )  # not measured by the unvaried rules
    found = protein_variants.table({protein_variants.DEFAULT: measured, "other": [*worse, new]})
    found = found.set_index(["variant", "claim"])
    assert found.loc["other", "n"].eq(2).all() and found.loc[("other", "d_as_coded"), "change"] == 0
    z = np.sqrt([0.2, 0.3]) / [0.5, 0.6]
    row = found.loc[("other", "over_floor")]
    assert row["value"] == pytest.approx(2 * z.mean()) and row["change"] == pytest.approx(z.mean())
    factors = 1 / np.array([0.2, 0.3, 0.4, 0.5])
    assert found.loc[(protein_variants.DEFAULT, "factor"), "value"] == pytest.approx(factors.mean())
    assert found.loc[(protein_variants.DEFAULT, "held"), "value"] == 1


def test_a_share_of_ranges_lies_between_none_and_all(measured):
    none = measured[0].result.ranges.assign(best_set="")
    three = [measured[0]._replace(result=replace(measured[0].result, protein=name)) for name in "pqr"]
    mixed = [*three[:2], three[2]._replace(result=replace(three[2].result, ranges=none))]
    found = protein_variants.table({protein_variants.DEFAULT: three, "other": mixed})
    row = found.set_index(["variant", "claim"]).loc[("other", "held")]
    assert row[["value", "value_low", "value_high"]].tolist() == pytest.approx([2 / 3, 0, 1])


def test_the_whole_recovered_grid_is_set_beside_its_quarter_on_the_same_proteins(measured):
    def on(protein, d, n_s):
        """A result with cross-validated d d + k and n_S n_s + k in range k, under one reading."""
        own = measured[0].result
        ranges = own.ranges[own.ranges["reading"] == "as_coded"]
        empty = ranges["n_combinations"].to_numpy() == 0
        k = np.where(empty, np.nan, np.cumsum(~empty))
        return replace(own, protein=protein, ranges=ranges.assign(d_cv=d + k, n_S_percent=n_s + k))

    whole = [on("a", 1.0, 10), on("b", 2.0, 20), on("c", 6.0, 60), on("alone", 99.0, 90)]
    quarter = [on("c", 2.0, 30), on("other", 50.0, 1), on("b", 1.0, 20), on("a", 0.5, 13)]
    found, _ = protein_tables.of_whole_grid(whole, quarter)
    gains = np.array([0.5, 1.0, 4.0])
    assert (found["n"] == 3).all() and found["gain"].to_list() == pytest.approx([gains.mean()] * len(found))
    assert (found["gain_low"] < gains.mean()).all() and (found["gain_high"] > gains.mean()).all()
    first = found.set_index("range").iloc[1]
    assert first[["whole", "quarter"]].to_list() == pytest.approx([4.0, 1 + 3.5 / 3])
    assert first[["n_S_percent", "n_S_percent_quarter"]].to_list() == pytest.approx([31.0, 22.0])
