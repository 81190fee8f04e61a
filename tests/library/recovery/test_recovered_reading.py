"""The reading `recovered`: a subset that is made a surface again and described as one."""

from types import SimpleNamespace

import numpy as np
import pytest

from sparsurf import registry
from sparsurf.evaluation.minimal_subset import recovered_z
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.recovery import readings
from sparsurf.recovery.interpolated_surface import interpolate_surface
from sparsurf.recovery.readings import comparable_density
from sparsurf.recovery.reconstructing import reconstruct_twice
from sparsurf.sampling import published
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis import grid


@pytest.fixture(scope="module")
def prepared(blob):
    whole = interpolate_surface(*(x[::6] for x in blob), density=8.0)
    return PreparedSurface(SimpleNamespace(points=whole[0], normals=whole[1]), streams=Streams(1))


def test_it_is_the_description_of_the_recovered_surface(prepared):
    tests = prepared.draw_tests(20)
    z_tot, _ = prepared.describe(tests)
    kept = farthest(prepared, 500, np.random.default_rng(1))
    z, _ = prepared.distances([kept], tests, z_tot, "recovered")
    index = build_index(*interpolate_surface(prepared.points[kept], prepared.normals[kept], prepared.density))
    few = Surface(prepared.points[kept], prepared.normals[kept])
    comparable = reconstruct_twice(few, prepared.density, "interpolant").comparable
    by_descriptor = recovered_z(prepared, comparable, tests)
    for name in registry.TABLE["descriptor"]:  # each beside the full surface in its own descriptor
        whole, alone = (
            descriptors.describe_patches(dots, prepared.points[tests], descriptor=name)[0]
            for dots in (prepared.index, index)
        )
        distance = np.linalg.norm(alone - whole, axis=1).mean()
        assert by_descriptor.pop(f"Z_{name}") == pytest.approx(distance, rel=1e-9)
    assert not by_descriptor
    patches = prepared.patches.model_copy(update={"r_zernike": 4.0, "d_link": 0.7})
    narrow = PreparedSurface(prepared.surface, Settings(patches=patches), streams=Streams(1))
    of_narrow, _ = narrow.distances([kept], tests, narrow.describe(tests)[0], "recovered")
    assert recovered_z(narrow, comparable, tests)["Z_published"] == pytest.approx(of_narrow.mean())
    alone, _ = descriptors.describe_patches(index, prepared.points[tests])
    assert z[0] == pytest.approx(np.linalg.norm(alone - z_tot, axis=1), rel=1e-9)
    as_it_is, _ = prepared.distances([kept], tests, z_tot, "full")
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
    assert comparable_density(density, d_link) == wanted


def test_more_dots_on_the_full_surface_give_more_on_the_recovered_one(blob):
    points, normals = (x[::6] for x in blob)
    dense = PreparedSurface(
        SimpleNamespace(
            **dict(zip(("points", "normals"), interpolate_surface(points, normals, 16.0), strict=True))
        )
    )
    found = [
        len(readings.recovered_index(points, normals, 0.5, dense.area, density).dot) / dense.area
        for density in (dense.density, 2 * dense.density)
    ]
    assert found[0] == pytest.approx(dense.density, rel=0.2)  # what thinning leaves is no exact number
    assert found[1] == pytest.approx(2 * found[0], rel=0.1)
    linked = readings.recovered_index(points, normals, 1.1, dense.area, 8.0)
    assert np.array_equal(linked.link, build_index(*interpolate_surface(points, normals, 8.0), 1.1).link)


def test_the_grid_takes_it_beside_the_others(prepared):
    combinations = published.parameter_grid([0.3, 1.0], [0.0], [2.0], [0.0])
    both = grid.evaluate_grid(prepared, combinations, 12, 2, ("recovered", "full"))
    plain = grid.evaluate_grid(prepared, combinations, 12, 2, ("full",))
    alone = grid.evaluate_grid(prepared, combinations, 12, 2, ("recovered",))
    for name in ("z_ts", "z_tr", "median_patch_size"):
        found = getattr(both, name)
        assert np.allclose(found[0], getattr(alone, name)[0], rtol=1e-5), name
        assert np.array_equal(found[1], getattr(plain, name)[0]), name
    sampled, random = prepared.pair(combinations[1], 1)
    z, _ = prepared.distances([sampled, random], both.tests, both.z_tot, "recovered", approximate=True)
    more = grid.evaluate_grid(prepared.with_threads(2), combinations, 12, 2, ("recovered", "full"))
    assert np.array_equal(both.z_ts, more.z_ts) and np.array_equal(both.z_tr, more.z_tr)
    assert np.array_equal(both.median_patch_size, more.median_patch_size)
    assert both.z_ts[0, 1, 1] == pytest.approx(z[0], rel=1e-5)
    assert both.z_tr[0, 1, 1] == pytest.approx(z[1], rel=1e-5)


def test_many_subsets_are_recovered_nearly_as_one_is(prepared):
    tests = prepared.draw_tests(60)
    z_tot, _ = prepared.describe(tests)
    subsets = [
        published.uniform_subset(len(prepared.points), n, prepared.stream(n)) for n in (400, 2000, 4000)
    ]
    one, many = (
        prepared.distances(subsets, tests, z_tot, "recovered", approximate=m)[0] for m in (False, True)
    )
    assert one[0] == pytest.approx(many[0], abs=1e-9)  # dots that lie far apart
    assert not np.array_equal(one, many)
    assert many.mean(axis=1) == pytest.approx(one.mean(axis=1), abs=0.03)  # .004 where normals have no noise


@pytest.fixture(scope="module")
def along_a_curve(prepared):
    combinations = published.parameter_grid([0.1, 0.4, 0.7], [0.0, 0.4], [0.0, 8.0], [0.0])
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(grid, "N_CURVE_SIZES", 10)  # fewer than the 12 combinations
        return grid.evaluate_grid(prepared, combinations, 20, 2, ("full", "recovered"))


def test_uniform_subsets_of_many_combinations_come_from_a_curve_of_each_draw(prepared, along_a_curve):
    g = along_a_curve
    ends = np.log([g.n_s.min(), g.n_s.max()])
    sizes = sorted({round(float(np.exp(x))) for x in np.linspace(*ends, 10)})
    for draw in (0, 1):
        subsets = [prepared.uniform(n, draw) for n in sizes]
        z, dots = prepared.distances(subsets, g.tests, g.z_tot, "recovered", approximate=True)
        for k in (0, 7, 11):
            wanted = [np.interp(np.log(g.n_s[k, draw]), np.log(sizes), z[:, t]) for t in range(len(g.tests))]
            assert g.z_tr[1, k, draw] == pytest.approx(wanted, rel=1e-5)
    assert dots.min() < g.median_patch_size[1, 1].min() <= g.median_patch_size[1, 1].max() < dots.max()
    k, draw = 6, 1  # the samplings themselves are measured, each at its own dots
    sampled = prepared.pair(g.combinations[k], draw)[0]
    z, _ = prepared.distances([sampled], g.tests, g.z_tot, "recovered", approximate=True)
    assert g.z_ts[1, k, draw] == pytest.approx(z[0], rel=1e-5)


def test_a_curve_gives_what_subsets_of_each_combination_give(prepared, along_a_curve):
    g = along_a_curve
    some = np.argsort(g.n_s_expected)[2::4]
    subsets = [prepared.pair(g.combinations[k], draw)[1] for k in some for draw in range(2)]
    z, _ = prepared.distances(subsets, g.tests, g.z_tot, "recovered", approximate=True)
    own, curve = (estimate(x) for x in (z.reshape(len(some), 2, -1), g.z_tr[1][some]))
    assert (abs(own.mean - curve.mean) < np.hypot(own.half, curve.half)).all()
    assert abs((own.mean - curve.mean).mean()) < 0.04  # half of the step to the next n_S but one
