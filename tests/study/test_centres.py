"""The control of the paper's sampling: its centres filled up uniformly."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from sparsurf.sampling import published
from sparsurf.study import grid as grids
from sparsurf.study import tables
from sparsurf.study.centres import _interpolate, centres_table, control_curve
from sparsurf.study.prepared_surface import PreparedSurface

READINGS = ("as_coded", "as_written")


@pytest.fixture(scope="module")
def prepared(blob):
    return PreparedSurface(SimpleNamespace(points=blob[0], normals=blob[1]), d_link=0.8, seed=2, name="blob")


def test_the_control_is_what_its_subsets_measure(prepared):
    n_s, tests = np.array([200, 900, 3000]), prepared.draw_tests(15)
    found = control_curve(prepared, n_s, READINGS, 15, 2)
    z_tot, _ = prepared.describe(tests)
    always = np.unique(prepared.cover.centre)
    for reading in READINGS:
        assert found[reading].shape == (3, 2, 15)
        assert np.abs(found[reading][2]).max() < 1e-9  # all dots are all dots
    kept = []

    def distances_under(readings, subsets, tests):
        kept.append(subsets)
        return prepared.distances_under(readings, subsets, tests)

    watched = prepared.changed(distances_under=distances_under)
    control_curve(watched, n_s, ("as_written",), 15, 2)
    (subsets,) = kept
    assert [len(subset) for subset in subsets] == 4 * [200, 900, 3000]
    assert all(np.isin(always, subset).all() for subset in subsets[6:])
    assert not any(np.isin(always, subset).all() for subset in subsets[:2])
    z = prepared.distances([subsets[1], subsets[7]], tests, z_tot, "as_written")[0]
    assert found["as_written"][1, 0] == pytest.approx(z[0] - z[1], abs=1e-9)


def test_between_two_n_s_the_control_is_a_line_over_the_logarithm():
    curve = np.array([0.0, 2.0, 3.0])[:, None, None]
    found = _interpolate(curve, np.array([10, 100, 1000]), np.array([10, 10**1.5, 100, 10**2.25, 1000]))
    assert found[:, 0, 0] == pytest.approx([0, 1, 2, 2.25, 3])
    assert _interpolate(curve[:1], np.array([10]), np.array([10.0])).tolist() == [[[0.0]]]


def test_a_sampling_without_roughness_is_explained_by_its_centres(prepared):
    """(alpha, 0, 0, 0) keeps the centres and, with one draw per dot, every other one with the chance alpha: the control."""
    prepared = PreparedSurface(
        prepared.surface,
        d_link=0.8,
        seed=2,
        name="blob",
        distance_from_moved_centre=False,
        chance_in_every_patch=False,
    )
    combinations = [(alpha, 0, 0, 0) for alpha in (0.02, 0.05, 0.1, 0.2, 0.4)]
    result = grids.evaluate_grid(prepared, combinations, 200, 6, READINGS)
    table = tables.grid_table(result)
    ranges = tables.ranges_table(table, result, 2)
    found = centres_table(prepared, table, ranges, 200, 6)
    assert found["reading"].tolist() == ["as_coded"] * 2 + ["as_written"] * 2
    assert found["range"].tolist() == [1, 2, 1, 2] and found["n_combinations"].sum() == 10
    assert (found["n_above"] + found["n_below"]).sum() <= 1  # of ten, by chance
    gap = (found["d_mean"] - found["d_centres_mean"]).abs().groupby(found["reading"]).max()
    assert (
        gap["as_written"] < 0.1 and gap["as_coded"] < 0.6
    )  # where patches break up, d of six draws scatters by 0.3
    told = found[found["d_low"] > 0]
    assert told["explained"].to_numpy() == pytest.approx((told["d_centres"] / told["d"]).to_numpy())
    assert found.loc[~(found["d_low"] > 0), "explained"].isna().all()


def test_a_combination_far_above_the_control_is_counted(prepared):
    result = grids.evaluate_grid(
        prepared, published.parameter_grid([0.3, 0.9], [0.0], [0.0], [0.0]), 30, 3, READINGS
    )
    table = tables.grid_table(result)
    ranges = tables.ranges_table(table, result, 1)
    for shift, counted in ((50, "n_above"), (-50, "n_below")):
        moved = [f"{name}_{reading}" for name in ("d", "d_low", "d_high") for reading in READINGS]
        shifted = table.assign(**{name: table[name] + shift for name in moved})
        found = centres_table(prepared, shifted, ranges, 30, 3, 4)
        assert (found[counted] == 2).all()
        assert pd.Series(found["n_above"] + found["n_below"]).tolist() == [2, 2]
