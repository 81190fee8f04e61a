"""Paired differences, intervals of times fewer, and subsets that stand alone."""

from functools import partial

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sampling import samplers
from sparsurf.study.comparison.equal_error import Z_MEASURES, factor_intervals, paired_differences
from sparsurf.study.comparison.measuring import stand_alone
from sparsurf.study.comparison.methods import dotted_surface
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.statistics import estimate
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii

PERCENTS = (5.0, 10.0, 20.0, 40.0)


def curves(rng, factor, noise=0.05):
    """Z = factor / sqrt(n_S) with a scatter of test dots that all samplers share; (4, 6, 80)."""
    own = noise * rng.normal(size=(4, 6, 80))
    return factor / np.sqrt(np.array(PERCENTS))[:, None, None] + own


@pytest.fixture(scope="module")
def raw():
    rng = np.random.default_rng(0)
    shared = 0.3 * rng.normal(size=(1, 1, 80))
    names = {"uniform": 4.0, "farthest": 3.0, "paper": 8.0}
    return {
        (name, m): curves(rng, f) + shared for m in ("Z as_written", "Z centres") for name, f in names.items()
    }


def table_of(raw):
    rows = [
        {"sampler": name, "measure": measure, "percent": p, "n_S_percent": p, "value": x[k].mean()}
        for (name, measure), x in raw.items()
        for k, p in enumerate(PERCENTS)
    ]
    return pd.DataFrame(rows)


def test_a_difference_is_paired_by_test_dot(raw):
    found = paired_differences(raw, PERCENTS, ("Z as_written",)).set_index(["than", "sampler", "percent"])
    row = found.loc["uniform", "farthest", 10.0]
    wanted = estimate(raw["farthest", "Z as_written"][1] - raw["uniform", "Z as_written"][1])
    assert row["difference"] == pytest.approx(wanted.mean) and row["high"] == pytest.approx(wanted.high)
    assert row["high"] - row["low"] < 0.05  # what test dots share, 0.3 / sqrt(80) each, has gone
    alone = estimate(raw["uniform", "Z as_written"][1])
    assert alone.high - alone.low > 0.1


def test_times_fewer_of_exact_curves(raw):
    # Z = f / sqrt(n): (4 / 3)^2 = 1.78 times fewer than uniform; the interval holds it
    found = factor_intervals(raw, table_of(raw), np.random.default_rng(1), resampled=200)
    row = found[
        (found["measure"] == "Z as_written") & (found["than"] == "uniform") & (found["sampler"] == "farthest")
    ]
    row = row.set_index("percent").loc[20.0]
    assert row["factor"] == pytest.approx(16 / 9, rel=0.05) and row["low"] < row["factor"] < row["high"]
    assert row["high"] / row["low"] < 1.3 and row["bound"] == ""
    beyond = found[(found["than"] == "paper") & (found["sampler"] == "farthest") & (found["percent"] == 5.0)]
    assert (beyond["factor"] == 1.0).all()  # fewer than were measured: the smallest counts
    assert (beyond["bound"] == "more than ").all()
    assert beyond[["low", "high"]].isna().all(axis=None)  # in all samples
    assert found.loc[found["bound"] == "", ["low", "high"]].notna().all(axis=None)
    more = found[(found["than"] == "uniform") & (found["sampler"] == "paper") & (found["percent"] == 40.0)]
    assert (more["factor"] == 1.0).all() and (more["bound"] == "less than ").all()


def test_a_measure_that_was_not_taken_has_no_times_fewer(raw):
    alone = {keys: values for keys, values in raw.items() if keys[1] == "Z centres"}
    found = factor_intervals(alone, table_of(alone), np.random.default_rng(1), resampled=20)
    assert found["measure"].unique().tolist() == ["Z centres"]
    # two others than each of the two references, at every n_S
    assert len(found) == 2 * 2 * len(PERCENTS)
    nothing = factor_intervals({}, table_of(raw), np.random.default_rng(1))
    assert nothing.empty and list(nothing.columns) == list(found.columns)


def test_the_interval_of_times_fewer_holds_95_percent():
    # three test dots of 2, 2 and 5 (over sqrt(n_S)): all three picks fall on the last with 1/27 = 3.7 %, which lies
    # inside of a 95 % interval and outside of a 90 % one; uniform is 4: 16 / 4, 16 / 9 and 16 / 25 times fewer
    percents = (1.0, 10.0, 100.0)
    dots = {"uniform": [4.0, 4, 4], "farthest": [2.0, 2, 5]}
    raw = {
        (name, measure): np.array(f)[None, None] / np.sqrt(percents)[:, None, None]
        for name, f in dots.items()
        for measure in Z_MEASURES
    }
    rows = [(measure, name, p, p) for name, measure in raw for p in percents]
    table = pd.DataFrame(rows, columns=["measure", "sampler", "percent", "n_S_percent"])
    found = factor_intervals(raw, table, np.random.default_rng(2), ("uniform",), 3000)
    row = found[found["measure"] == "Z as_written"].set_index(["sampler", "percent"]).loc["farthest", 10.0]
    assert (row["factor"], row["low"], row["high"]) == pytest.approx((16 / 9, 16 / 25, 4.0))


def test_a_surface_is_dotted_with_the_requested_number():
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-214")
    xyz, r = molecule.xyz[0], radii(molecule)
    points, normals = dotted_surface(xyz, r, 150, np.random.default_rng(0))
    assert abs(len(points) - 150) <= 12
    gap = np.linalg.norm(points[:, None] - xyz, axis=2) - r
    assert (np.abs(gap).min(axis=1) < 1.5).all()  # turned back: on the molecule again
    assert np.allclose(np.linalg.norm(normals, axis=1), 1)


def test_subsets_that_stand_alone():
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-214")
    xyz, r = molecule.xyz[0], radii(molecule)
    prepared = PreparedSurface(molecular_surface(xyz, r), seed=1, name="piece")
    drawers = {"uniform": lambda n, rng: samplers.uniform(prepared, n, rng)}
    table = stand_alone(prepared, drawers, partial(dotted_surface, xyz, r), (10.0, 40.0), 30, 2, (1.2, 1.6))
    assert table["sampler"].unique().tolist() == ["uniform", "dotted"] and len(table) == 8
    share = table[table["sampler"] == "uniform"].groupby("percent")["n_S_percent"].first()
    assert share.to_dict() == pytest.approx({10.0: 10.0, 40.0: 40.0}, rel=0.02)
    z = table[table["scale"] == 1.6].pivot(index="sampler", columns="percent", values="Z")
    assert (z[40.0] < z[10.0]).all() and (table["low"] < table["Z"]).all()
    # by hand, one draw: the reading `scaled` of the same subset
    kept = [
        np.sort(drawers["uniform"](n, prepared.stream("stand alone", "uniform", n, 0)))
        for n in [round(0.4 * len(prepared.points))]
    ]
    tests = prepared.draw_tests(30)
    wanted = prepared.distances(kept, tests, prepared.describe(tests)[0], "scaled")[0]
    one = stand_alone(prepared, drawers, None, (40.0,), 30, 1, (1.2, 1.6))
    assert one.set_index("scale").loc[1.6, "Z"] == pytest.approx(wanted.mean())
