"""Distances by roughness: which test dots are asked for, and the rows around kept and any dots."""

import numpy as np
import pytest
from scipy.stats import t as student

from conftest import make_blob
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.sampling import published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface
from sparsurf_study.analysis import rough_and_flat

COMBINATION = (0.8, 0.0, 4.0, 0.0)


@pytest.fixture(scope="module")
def prepared(blob):
    settings = Settings(patches={"d_link": 0.8})
    return PreparedSurface(Surface(*blob), settings, streams=Streams(3, "blob"))


@pytest.mark.parametrize("kept", [True, False])
def test_distances_are_those_of_the_pairs_around_their_test_dots(prepared, kept):
    found = rough_and_flat.by_roughness(prepared, COMBINATION, ["full", "kept"], 40, 3, kept)
    assert np.array_equal(found.roughness, prepared.roughness[found.dots]) and list(found.z) == [
        "full",
        "kept",
    ]
    assert np.array_equal(found.dots, np.sort(found.dots, axis=1)) and found.dots.shape == (3, 40)
    if kept:  # each draw has test dots of its own, also by their places among the kept dots
        kept_dots = [prepared.pair(COMBINATION, draw)[0] for draw in range(3)]
        places = [np.searchsorted(*each).tolist() for each in zip(kept_dots, found.dots, strict=True)]
        streams = [prepared.stream("rough and flat", draw) for draw in range(3)]
        assert places == [
            published.uniform_subset(len(dots), 40, rng).tolist()
            for dots, rng in zip(kept_dots, streams, strict=True)
        ]
    for draw in (0, 2):
        tests, pair = found.dots[draw], prepared.pair(COMBINATION, draw)
        for reading, z in found.z.items():
            wanted, _ = prepared.distances(pair, tests, prepared.describe(tests)[0], reading)
            assert np.allclose(z[:, draw], wanted, rtol=1e-9)


def test_around_kept_dots_every_draw_has_as_many_as_the_smallest_subset(prepared):
    combination = (0.05, 0.4, 8.0, 4.0)
    sizes = [len(prepared.pair(combination, draw)[0]) for draw in range(6)]
    found = rough_and_flat.by_roughness(prepared, combination, ["full"], 3000, 6, True)
    assert found.dots.shape == (6, min(sizes)) and sizes[0] > min(sizes)
    for draw in range(6):
        assert np.isin(found.dots[draw], prepared.pair(combination, draw)[0]).all()


def test_of_a_small_surface_all_dots_are_measured():
    settings = Settings(patches={"d_link": 3.0})
    small = PreparedSurface(Surface(*make_blob(200)), settings, streams=Streams(3, "small"))
    found = rough_and_flat.kept_and_any(small, COMBINATION, ["full"], "published")
    assert found["any dots"].dots.tolist() == [list(range(200))] * 6
    assert found["kept dots"].dots.shape == (6, min(len(small.pair(COMBINATION, k)[0]) for k in range(6)))


@pytest.mark.parametrize(("test_dots", "n"), [(4, 40), (1, 10), (900, 8000), ("published", 8000)])
def test_ten_times_the_test_dots_of_the_grid_are_measured_or_8000(prepared, monkeypatch, test_dots, n):
    asked = []
    monkeypatch.setattr(rough_and_flat, "by_roughness", lambda *given: asked.append(given))
    found = rough_and_flat.kept_and_any(prepared, COMBINATION, ["full"], test_dots)
    assert list(found) == ["kept dots", "any dots"]
    assert asked == [(prepared, COMBINATION, ["full"], n, 6, kept) for kept in (True, False)]


def test_the_rows_around_kept_dots_come_before_those_around_any(prepared):
    measured = rough_and_flat.kept_and_any(prepared, COMBINATION, ["full"], 4)
    table = rough_and_flat.table_of_bins(measured)
    assert table["around"].tolist() == ["kept dots"] * 12 + ["any dots"] * 12
    assert table["bin"].tolist() == [*map(str, range(1, 11)), "rougher half", "flatter half"] * 2
    for k, around in enumerate(("kept dots", "any dots")):
        rough = measured[around].roughness
        rows = table[12 * k : 12 * k + 12]
        assert rows["roughness_low"].min() == rough.min() and rows["roughness_high"].max() == rough.max()
        edges = np.linspace(rough.min(), rough.max(), 11)
        counts = np.mean([np.histogram(of_draw, edges)[0] for of_draw in rough], axis=0)
        assert rows["n"][:10].tolist() == pytest.approx(counts) and rough.shape == (6, 40)
        halves, z = rows[10:], measured[around].z["full"]
        inside = rough >= np.mean([rough.min(), rough.max()])
        flat = [np.mean([row[mask].mean() for row, mask in zip(of, inside, strict=True)]) for of in z]
        assert halves[["Z_tS_full", "Z_tR_full"]].iloc[1].tolist() == pytest.approx(flat)


def test_the_interval_over_draws_with_their_own_test_dots_is_students_of_their_means():
    """By hand: means 2, 4 and 9 over 1, 2 and 3 test dots; crossed draws take the test dots as well."""
    d = np.array([[2.0, 50, 60], [3, 5, 70], [8, 9, 10]])
    inside = np.array([[True, False, False], [True, True, False], [True, True, True]])
    found = rough_and_flat.estimate_inside(d, inside, True)
    half = student.ppf(0.975, 2) * np.std([2, 4, 9], ddof=1) / 3**0.5
    assert (found.mean, found.low, found.high) == pytest.approx((5, 5 - half, 5 + half))
    everywhere = np.ones((3, 3), bool)
    crossed = rough_and_flat.estimate_inside(d, everywhere, False)
    assert crossed.mean == pytest.approx(d.mean()) and crossed.error == pytest.approx(estimate(d).error)
    assert np.isnan(rough_and_flat.estimate_inside(d, inside & [False, True, True], True).mean)
