"""The tables over many proteins take each number from its place: made-up proteins whose numbers all differ."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from test_over_proteins import curve, floor
from test_summary import result

from sparsurf.sampling import law
from sparsurf.study import over_proteins, protein_tables, protein_variants

MANY = law.grid(np.linspace(0.1, 1, 10), [0], [0, 2, 4], [0])
NAMES = ["a", "b", "c", "d"]
RHO_NEEDED = {"n": 4, "rho": 0.9}


def measured_of(s):
    """One protein: its curves need s + 1 times as many dots as a uniform draw's, and its floors grow with s."""
    name = NAMES[s]
    factors = {("uniform", "surface"): 1.0, ("farthest", "surface"): 0.8, ("uniform", "recovered"): 0.7}
    factors[("farthest", "recovered")] = 0.2 + 0.1 * s
    curves = pd.concat([curve(name, *keys, factor) for keys, factor in factors.items()], ignore_index=True)
    floors = floor(name, **{"fresh dots": 0.5 + 0.1 * s, "turned": 0.8 + 0.1 * s, "atoms moved 0.1 Å": 0.6})
    floors = pd.concat([floors, floor(name, **{"atoms moved 0.3 Å": 0.9 + 0.05 * s})], ignore_index=True)
    own = result(f"{name}/c1", 0.5 + 0.03 * s, s % 3, s, combinations=MANY)
    empty = (own.ranges["islands"] == "surface") & (own.ranges.groupby("islands").cumcount() == 1)
    own = replace(
        own, ranges=own.ranges.assign(best_set=own.ranges["best_set"].mask(empty))
    )  # as a file has ""
    return (
        own,
        floors.drop(columns="protein"),
        curves.drop(columns="protein"),
        {"n_atoms": 100 + s, "n_residues": 10 + s},
    )


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
    return protein_tables.tables_of(measured, {})


def test_every_table_is_there_and_of_these_proteins(found):
    assert {
        "summary",
        "relation",
        "surfaces",
        "d",
        "plateaus",
        "enough",
        "enough_means",
        "needed_means",
    } < set(found)
    assert "variants" not in found and set(protein_tables.OF_RECOMMENDATION) < set(found)
    surfaces = found["surfaces"].set_index("protein")
    assert list(surfaces.index) == NAMES
    assert list(surfaces["n_atoms"]) == [100, 101, 102, 103] and list(surfaces["n_residues"]) == [
        10,
        11,
        12,
        13,
    ]
    assert (surfaces["R_patch"] == 4).all() and (surfaces["D_link"] == 0.5).all()
    assert found["summary"]["best_set"].notna().all()
    assert found["power"]["n"].tolist() == [4]
    assert found["d"].query("range == 0")["n"].tolist() == [4, 4]
    own = found["by_n_s"].set_index(["sampler", "islands", "percent"])
    # Z = sqrt(10 factor / percent), over floors of 0.5 to 0.8
    z = np.sqrt(np.array([0.2, 0.3, 0.4, 0.5]))
    assert own.loc[("farthest", "recovered", 10.0), "Z"] == pytest.approx(z.mean())
    assert own.loc[("farthest", "recovered", 10.0), "over_floor"] == pytest.approx(
        (z / [0.5, 0.6, 0.7, 0.8]).mean()
    )


def test_quantities_are_those_of_farthest_point_dots_recovered(found):
    enough = found["enough"]
    needed = over_proteins.needed(pd.concat([measured_of(s)[2].assign(protein=NAMES[s]) for s in range(4)]))
    quantities = protein_tables.quantities_of(found["summary"], enough, needed)
    assert list(quantities) == [
        "d held out, `kept`", "d held out, `surface`", "n_S enough, fresh dots", "n_S enough, turned",
        "n_S enough, atoms moved 0.1 Å", "n_S enough, atoms moved 0.3 Å", "times fewer than 25 % uniform",
        "times fewer than 40 % uniform",
    ]  # fmt: skip
    held = (
        found["summary"]
        .query("islands == 'kept' and n_combinations > 0 and protein == 'b'")["d_held_out"]
        .mean()
    )
    assert quantities["d held out, `kept`"]["b"] == pytest.approx(held)
    assert quantities["d held out, `surface`"].max() < 0 < quantities["d held out, `kept`"].min()
    for s, name in enumerate(NAMES):
        # Z^2 = 10 factor / n within a tenth of the yardstick
        wanted = 10 * (0.2 + 0.1 * s) / (1.1 * (0.8 + 0.1 * s)) ** 2
        assert quantities["n_S enough, turned"][name] == pytest.approx(wanted)
        assert quantities["times fewer than 25 % uniform"][name] == pytest.approx(1 / (0.2 + 0.1 * s))


def test_coverage_is_asked_of_the_numbers_that_have_intervals(found):
    table = found["coverage"]
    means = table[table["interval"] == "mean"].set_index("quantity")["coverage"]
    factor = 1 / np.array([0.2, 0.3, 0.4, 0.5])
    assert means["ln of times fewer than 25 % uniform"] == pytest.approx(np.log(factor).sum())
    for percent, words in ((2.5, "2.5"), (10, "10")):
        wanted = np.sqrt(10 / factor / percent) / [0.5, 0.6, 0.7, 0.8]
        assert means[f"Z recovered from {words} %, over fresh dots"] == pytest.approx(wanted.sum())
    assert "d held out, `kept`" in means and not any("n_S" in words for words in means.index)
    sets = table[table["interval"] == "confidence set"]
    assert sets["coverage"].tolist() == [
        (k, 10, reading, 4) for reading in ("kept", "surface") for k in (2, 5)
    ]
    assert sets["quantity"].tolist()[:2] == ["the best of range 2, `kept`", "the best of range 5, `kept`"]
    assert (table["n"] == 4).all()


def test_variants_are_a_table_where_they_were_measured(measured, monkeypatch):
    monkeypatch.setattr(protein_tables, "coverage", lambda *_: pd.DataFrame())
    monkeypatch.setattr(over_proteins, "power", lambda n, rng: RHO_NEEDED)
    varied = {protein_variants.DEFAULT: measured}
    table = protein_tables.tables_of(measured, varied)["variants"].set_index("claim")
    assert table.loc["factor", "value"] == pytest.approx((1 / np.array([0.2, 0.3, 0.4, 0.5])).mean())
    assert (table["change"] == 0).all()
