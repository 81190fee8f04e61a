"""The reading `recovered`: a subset that is made a surface again and described as one."""

from types import SimpleNamespace

import numpy as np
import pytest

from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery import readings
from sparsurf.recovery.readings import fair_density, readings_in
from sparsurf.recovery.recovering import recover
from sparsurf.sampling import law
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study import grid
from sparsurf.study.evaluator import Evaluator
from sparsurf.surfaces.spacing import DENSITY


@pytest.fixture(scope="module")
def evaluator(blob):
    whole = recover(*(x[::6] for x in blob), density=8.0)
    return Evaluator(SimpleNamespace(points=whole[0], normals=whole[1]), seed=1)


def test_it_is_the_description_of_the_recovered_surface(evaluator):
    tests = evaluator.draw_tests(20)
    z_tot, _ = evaluator.describe(tests)
    kept = SAMPLERS["farthest"](evaluator, 500, np.random.default_rng(1))
    z, _ = evaluator.distances([kept], tests, z_tot, "recovered")
    index = build_index(*recover(evaluator.points[kept], evaluator.normals[kept], evaluator.density))
    alone, _ = descriptors.describe(index, evaluator.points[tests])
    assert z[0] == pytest.approx(np.linalg.norm(alone - z_tot, axis=1), rel=1e-9)
    as_it_is, _ = evaluator.distances([kept], tests, z_tot, "as_written")
    assert z.mean() < 0.75 * as_it_is.mean()


@pytest.mark.parametrize(
    ("density", "d_link", "wanted"),
    [
        (1.02 * DENSITY, 0.5, DENSITY),  # laid at DENSITY: the tables of the default study do not change
        (1.10 * DENSITY, 0.5, 1.10 * DENSITY),
        (20.0, 0.5, 20.0),
        (0.3 * DENSITY, 0.5, DENSITY),
        (0.3 * DENSITY, 1.0, DENSITY),
        (DENSITY, 0.25, 4 * DENSITY),  # as dense as the links need
        (float("nan"), 0.5, DENSITY),  # of a single dot
    ],
)
def test_it_is_as_dense_as_the_surface_it_is_compared_with(density, d_link, wanted):
    assert fair_density(density, d_link) == wanted


def test_more_dots_on_the_full_surface_give_more_on_the_recovered_one(blob):
    points, normals = (x[::6] for x in blob)
    dense = Evaluator(
        SimpleNamespace(**dict(zip(("points", "normals"), recover(points, normals, 16.0), strict=True)))
    )
    found = [
        len(readings.recovered(points, normals, 0.5, dense.area, density).dot) / dense.area
        for density in (dense.density, 2 * dense.density)
    ]
    assert found[0] == pytest.approx(dense.density, rel=0.2)  # what thinning leaves is no exact number
    assert found[1] == pytest.approx(2 * found[0], rel=0.1)


def test_the_grid_takes_it_beside_the_others(evaluator):
    combinations = law.grid([0.3, 1.0], [0.0], [2.0], [0.0])
    both = grid.run(evaluator, combinations, 12, 2, ("as_written", "recovered"))
    plain = grid.run(evaluator, combinations, 12, 2, ("as_written",))
    alone = grid.run(evaluator, combinations, 12, 2, ("recovered",))
    assert np.array_equal(both.z_ts[0], plain.z_ts[0])
    assert np.allclose(both.z_ts[1], alone.z_ts[0], rtol=1e-5)
    sampled, random = evaluator.pair(combinations[1], 1)
    z, _ = evaluator.distances([sampled, random], both.tests, both.z_tot, "recovered")
    more = grid.run(evaluator.changed(threads=2), combinations, 12, 2, ("as_written", "recovered"))
    assert np.array_equal(both.z_ts, more.z_ts) and np.array_equal(both.z_tr, more.z_tr)
    assert np.array_equal(both.fragment, more.fragment)
    assert both.z_ts[1, 1, 1] == pytest.approx(z[0], rel=1e-5)
    assert both.z_tr[1, 1, 1] == pytest.approx(z[1], rel=1e-5)


def test_a_table_has_the_readings_that_its_columns_are_called_after():
    columns = ["d_recovered", "as_coded", "d_as_coded", "best_as_written", "d_scaled_low"]
    assert readings_in(columns, "d_") == ["as_coded", "recovered"]
    assert readings_in(columns) == ["as_coded"]
