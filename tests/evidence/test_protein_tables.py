"""The tables over many proteins take each number from its place: made-up proteins whose numbers all differ."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from test_over_proteins import curve, floor
from test_summary import result, run_of

from measures import over_proteins, protein_tables
from measures.studies import Measured
from sparsurf.sampling import published

MANY = published.parameter_grid(np.linspace(0.1, 1, 10), [0], [0, 2, 4], [0])
NAMES = ["a", "b", "c", "d"]
RHO_NEEDED = {"n": 4, "rho": 0.9}


def measured_of(s):
    """One protein: its curves need s + 1 times as many dots as a uniform draw's, and its floors grow with s."""
    name = NAMES[s]
    factors = {("uniform", "full"): 1.0, ("farthest", "full"): 0.8, ("uniform", "recovered"): 0.7}
    factors[("farthest", "recovered")] = 0.2 + 0.1 * s
    curves = pd.concat([curve(name, *keys, factor) for keys, factor in factors.items()], ignore_index=True)
    floors = floor(name, **{"fresh dots": 0.5 + 0.1 * s, "turned": 0.8 + 0.1 * s, "atoms moved 0.1 Å": 0.6})
    floors = pd.concat([floors, floor(name, **{"atoms moved 0.3 Å": 0.9 + 0.05 * s})], ignore_index=True)
    own = result(f"{name}/c1", 0.5 + 0.03 * s, s % 3, s, combinations=MANY)
    empty = (own.ranges["reading"] == "full") & (own.ranges.groupby("reading").cumcount() == 1)
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
    return protein_tables.tables_of(measured, *run_of([each.result for each in measured]).values())


@pytest.fixture(scope="module")
def summary(measured):
    return run_of([each.result for each in measured])["summary"]


def test_every_table_is_there_and_of_these_proteins(found):
    assert {"d", "plateaus", "needed_means"} < set(found)
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
        "cross-validated d, `kept`", "cross-validated d, `full`", "times fewer than 25 % uniform",
        "times fewer than 40 % uniform",
    ]  # fmt: skip
    held = summary.query("reading == 'kept' and n_combinations > 0 and protein == 'b'")["d_cv"].mean()
    assert quantities["cross-validated d, `kept`"]["b"] == pytest.approx(held)
    assert quantities["cross-validated d, `full`"].max() < 0 < quantities["cross-validated d, `kept`"].min()
    for s, name in enumerate(NAMES):
        assert quantities["times fewer than 25 % uniform"][name] == pytest.approx(1 / (0.2 + 0.1 * s))
