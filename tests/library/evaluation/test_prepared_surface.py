"""Everything that is computed of a prepared surface follows its settings, its roughness and its seed."""

from dataclasses import FrozenInstanceError

import numpy as np
import pytest

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.recovery.readings import recovered_index
from sparsurf.sampling import published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface

PATCHES = {"r_patch": 3.0, "r_zernike": 5.0, "d_link": 0.9, "descriptor": "rotation_robust"}
KEYS = {"radius": 5.0, "descriptor": "rotation_robust"}
AREA = 375.0  # so that there are 8 dots per Å^2, more than a surface has by default


@pytest.fixture(scope="module")
def surface(blob):
    return Surface(*blob, np.full(len(blob[0]), AREA / len(blob[0])))


@pytest.fixture(scope="module")
def prepared(surface):
    return PreparedSurface(surface, Settings(patches=PATCHES), streams=Streams(5, "p/c"))


@pytest.fixture(scope="module")
def index(blob):
    return build_index(*blob, 0.9)


def same(one, other):
    """Whether two covers are equal."""
    return all(map(np.array_equal, one, other))


def test_roughness_and_covers_are_those_of_the_radius_and_the_rules(prepared, surface, index):
    rough = roughness_of_patches(index, 3.0)
    assert np.array_equal(prepared.roughness, rough) and len(prepared) == 3000
    assert same(prepared.cover, published.build_cover(index, rough, 3.0))
    assert same(prepared.corrected_cover, published.build_cover(index, rough, 3.0, False, False))
    for moved, every in ((False, True), (True, False)):
        rules = {"distance_from_moved_centre": moved, "chance_in_every_patch": every}
        other = PreparedSurface(surface, Settings(patches=PATCHES, sampling=rules))
        assert same(other.cover, published.build_cover(index, rough, 3.0, moved, every))
        assert same(other.corrected_cover, prepared.corrected_cover)
    given = PreparedSurface(surface, Settings(patches=PATCHES), rough / 2)
    assert np.array_equal(given.roughness, rough / 2) and np.array_equal(
        given.cover.roughness, prepared.cover.roughness / 2
    )
    assert (prepared.area, prepared.density, prepared.name) == (
        pytest.approx(AREA),
        pytest.approx(8.0),
        "p/c",
    )
    assert repr(prepared) == "PreparedSurface of 3,000 dots"
    bare = PreparedSurface(Surface(surface.points, surface.normals))  # whose area is estimated
    assert bare.density == pytest.approx(3000 / bare.area) and bare.area == pytest.approx(
        4 * np.pi * 8**2, rel=0.5
    )


@pytest.mark.parametrize("up", [True, False])
def test_the_whole_surface_is_described_as_set(prepared, index, up):
    tests = prepared.draw_tests(12)
    assert (
        len(tests) == 12
        and np.array_equal(tests, np.unique(tests))
        and len(prepared.draw_tests(9999)) == 3000
    )
    assert not np.array_equal(tests, prepared.draw_tests(12, 7))
    z, sizes = descriptors.describe_patches(index, prepared.points[tests], up=up, **KEYS)
    for found, wanted in zip(prepared.describe(tests, up), (z, sizes), strict=True):
        assert np.array_equal(found, wanted)


def test_subsets_are_compared_under_every_reading_as_set(prepared, index, surface):
    tests, subsets = prepared.draw_tests(6), [prepared.uniform(n, 1) for n in (400, 1200)]
    whole, _ = descriptors.describe_patches(index, prepared.points[tests], **KEYS)
    readings = ("kept_scaled", "full", "recovered", "kept")
    z_tot, found, sizes = prepared.compare(subsets, tests, readings)
    assert np.allclose(z_tot, whole, atol=1e-12) and found.shape == sizes.shape == (4, 2, 6)
    words = descriptors.pack_subsets(index, subsets)
    for r, reading in ((1, "full"), (3, "kept")):
        keys = KEYS | {"z_tot": whole}
        _, z, n = descriptors.compare_descriptors(index, prepared.points[tests], words, 2, (reading,), **keys)
        assert np.allclose(found[r], z.T, atol=1e-9) and np.array_equal(sizes[r], n.T)
        alone, _ = prepared.compare_words(words[None], 2, tests, (reading,), whole)
        assert np.allclose(alone[0], z.T, atol=1e-9)
        nested, _ = prepared.compare_uniform(1, np.array([400, 1200]), tests, (reading,), whole)
        assert np.allclose(nested[0], z.T, atol=1e-9)
        many = np.array([400, *range(500, 515), 1200])  # so many take another way
        nested, _ = prepared.compare_uniform(1, many, tests, (reading,), whole)
        assert np.allclose(nested[0][[0, -1]], z.T, atol=1e-9)
    for b, dots in enumerate(subsets):
        few = surface.points[dots], surface.normals[dots], 0.9, AREA, 8.0
        for r, own in ((0, linked_by_spacing(*few)), (2, recovered_index(*few))):
            z, n = descriptors.describe_patches(own, prepared.points[tests], **KEYS)
            assert np.allclose(found[r, b], np.linalg.norm(z - whole, axis=1), atol=1e-9)
            assert np.array_equal(sizes[r, b], n)
            of_index = prepared.distances_to_index(own, tests, whole)
            assert np.allclose(of_index[0], found[r, b], atol=1e-9) and np.array_equal(of_index[1], n)
    of_whole, alone, _ = prepared.compare(subsets, tests, ("recovered",))  # no other needs the whole surface
    assert np.allclose(of_whole, whole, atol=1e-12) and np.allclose(alone[0], found[2], atol=1e-9)
    one, of_one = prepared.distances(subsets, tests, whole, "kept")
    assert np.allclose(one, found[3], atol=1e-9) and np.array_equal(of_one, sizes[3])
    quick = recovered_index(
        surface.points[subsets[1]], surface.normals[subsets[1]], 0.9, AREA, 8.0, close=2.0
    )
    wanted = prepared.distances_to_index(quick, tests, whole)[0]
    assert np.allclose(prepared.distances(subsets, tests, whole, "recovered", approximate=True)[0][1], wanted)


def test_many_test_dots_and_sizes_equal_each_size_alone(prepared):
    """So many that they are described in several parts."""
    tests, sizes = np.arange(0, len(prepared), 40), np.arange(300, 320)
    whole = prepared.describe(tests)[0]
    together, _ = prepared.compare_uniform(1, sizes, tests, ("kept",), whole)
    for k in (0, 19):
        alone, _ = prepared.compare_uniform(1, sizes[[k]], tests, ("kept",), whole)
        assert np.allclose(together[0][k], alone[0][0], rtol=0, atol=1e-9)


def test_draws_come_from_streams_of_their_own(prepared):
    combination = (0.5, 0.2, 2.0, 1.0)
    keys = (500_000, 200_000, 2_000_000, 1_000_000)
    rng = prepared.stream("sampled", *keys, 3)
    assert np.array_equal(
        prepared.sampled(combination, 3), published.sample_cover(prepared.cover, combination, rng)
    )
    pairs = prepared.stream("pairs", 3).standard_exponential(len(prepared.cover.dot))
    together = published.sample_together(prepared.cover, [combination], pairs).subset(0)
    sampled, random = prepared.pair(combination, 3)
    assert np.array_equal(sampled, together)
    assert np.array_equal(random, np.sort(prepared.stream("uniform", 3).permutation(3000)[: len(sampled)]))


@pytest.mark.parametrize("beta", [np.zeros(300), np.linspace(0, 1, 300)])
def test_many_alphas_are_told_apart_in_one_group_and_in_many(prepared, beta):
    """A byte holds no 300 levels; the random numbers are those of a call with one combination."""
    combinations = np.column_stack([np.linspace(0.01, 1, 300), beta, np.ones(300), np.ones(300)])
    pairs = np.random.default_rng(3).exponential(size=len(prepared.cover.dot))
    together = published.sample_together(prepared.cover, combinations, pairs)
    alone = [published.sample_together(prepared.cover, [row], pairs).subset(0) for row in combinations[::13]]
    for k, wanted in zip(range(0, 300, 13), alone, strict=True):
        assert np.array_equal(together.subset(k), wanted), k
    assert together.sizes().max() < len(prepared)


def test_a_copy_differs_in_one_thing_and_what_follows_from_it(prepared, surface, index):
    """Other dots have an index, a roughness, a cover and an area of their own; another link changes the islands alone."""
    with pytest.raises(FrozenInstanceError):
        prepared.threads = 2
    threaded, reseeded = prepared.with_threads(3), prepared.with_streams(Streams(6, "p/c"))
    assert (threaded.threads, prepared.threads) == (3, 1) and threaded.index is prepared.index
    assert not np.array_equal(reseeded.uniform(9, 0), prepared.uniform(9, 0))
    half = surface[::2]
    other, fresh = prepared.with_dots(half), PreparedSurface(half, Settings(patches=PATCHES))
    assert (prepared.area, other.area, other.density) == (
        pytest.approx(AREA),
        pytest.approx(AREA / 2),
        fresh.density,
    )
    assert np.array_equal(other.roughness, fresh.roughness) and same(other.cover, fresh.cover)
    tests = prepared.draw_tests(6)
    linked, wanted = prepared.with_link(0.5), build_index(surface.points, surface.normals, 0.5)
    assert np.array_equal(
        linked.describe(tests)[0], descriptors.describe_patches(wanted, surface.points[tests], **KEYS)[0]
    )
    assert not np.array_equal(linked.describe(tests)[0], prepared.describe(tests)[0])
    assert linked.cover is prepared.cover and linked.patches.d_link == 0.5
    published_kind = prepared.with_descriptor("published").describe(tests)[0]
    assert np.array_equal(published_kind, descriptors.describe_patches(index, surface.points[tests], 5.0)[0])
    corrected = linked.with_cover(prepared.corrected_cover)
    assert corrected.cover is prepared.corrected_cover and linked.cover is prepared.cover
    assert corrected.index is linked.index
