"""The reading `recovered`: a subset that is made a surface again and described as one."""

from types import SimpleNamespace

import numpy as np
import pytest

from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery.readings import readings_in
from sparsurf.recovery.recovering import recover
from sparsurf.sampling import law
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.study import grid
from sparsurf.study.evaluator import Evaluator


@pytest.fixture(scope="module")
def evaluator(blob):
    whole = recover(*(x[::6] for x in blob), density=8.0)
    return Evaluator(SimpleNamespace(points=whole[0], normals=whole[1]), seed=1)


def test_it_is_the_description_of_the_recovered_surface(evaluator):
    tests = evaluator.draw_tests(20)
    z_tot, _ = evaluator.describe(tests)
    kept = SAMPLERS["farthest"](evaluator, 500, np.random.default_rng(1))
    z, _ = evaluator.distances([kept], tests, z_tot, "recovered")
    index = build_index(*recover(evaluator.points[kept], evaluator.normals[kept]))
    alone, _ = descriptors.describe(index, evaluator.points[tests])
    assert z[0] == pytest.approx(np.linalg.norm(alone - z_tot, axis=1), rel=1e-9)
    as_it_is, _ = evaluator.distances([kept], tests, z_tot, "surface")
    assert z.mean() < 0.75 * as_it_is.mean()


def test_the_grid_takes_it_beside_the_others(evaluator):
    combinations = law.grid([0.3, 1.0], [0.0], [2.0], [0.0])
    both = grid.run(evaluator, combinations, 12, 2, ("surface", "recovered"))
    plain = grid.run(evaluator, combinations, 12, 2, ("surface",))
    alone = grid.run(evaluator, combinations, 12, 2, ("recovered",))
    assert np.array_equal(both.z_ts[0], plain.z_ts[0])
    assert np.allclose(both.z_ts[1], alone.z_ts[0], rtol=1e-5)
    sampled, random = evaluator.pair(combinations[1], 1)
    z, _ = evaluator.distances([sampled, random], both.tests, both.z_tot, "recovered")
    more = grid.run(evaluator.changed(threads=2), combinations, 12, 2, ("surface", "recovered"))
    assert np.array_equal(both.z_ts, more.z_ts) and np.array_equal(both.z_tr, more.z_tr)
    assert np.array_equal(both.fragment, more.fragment)
    assert both.z_ts[1, 1, 1] == pytest.approx(z[0], rel=1e-5)
    assert both.z_tr[1, 1, 1] == pytest.approx(z[1], rel=1e-5)


def test_a_table_has_the_readings_that_its_columns_are_called_after():
    columns = ["d_recovered", "kept", "d_kept", "best_surface", "d_scaled_low"]
    assert readings_in(columns, "d_") == ["kept", "recovered"]
    assert readings_in(columns) == ["kept"]
