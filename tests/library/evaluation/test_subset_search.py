"""The fewest dots for an error: by made-up errors whose answer can be read off, and on a real surface."""

from types import SimpleNamespace

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.evaluation.subset_search import (
    draw_subset,
    find_subset,
    smallest_subset_of_error,
    warn_if_number_differs,
)
from sparsurf.evaluation.trials import MeasuredError, Trials
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_recovered
from sparsurf.sampling.combination import Choices
from sparsurf.sampling.samplers import get_sampler
from sparsurf.settings import Settings
from sparsurf.streams import Streams


class MadeUp(Trials):
    """A surface of 1000 dots on 160 Å^2, recovered with an error of (scale / n) ** power Å.

    The standard error of its logarithm is 3 / sqrt(n).
    """

    def __init__(self, scale=2.0, power=1.0):
        self.prepared = SimpleNamespace(name="made up", area=160.0)
        self.sampler, self.n_dots, self.scale, self.power = "farthest", 1000, scale, power
        self.tried = []

    def draw(self, n):
        return np.arange(n)

    def error(self, n):
        self.tried.append(n)
        if n == self.n_dots:
            return MeasuredError(0.0, 0.0)
        return MeasuredError((self.scale / n) ** self.power, 3 / np.sqrt(n))


@pytest.mark.parametrize(("scale", "power"), [(2.0, 1.0), (2.6, 1.0), (1.2, 1.0), (4.0, 1.3), (0.9, 0.8)])
@pytest.mark.parametrize("error", [0.01, 0.02, 0.05])
def test_the_fewest_dots_of_an_error_are_found_with_few_measurements(scale, power, error):
    trials, answer = MadeUp(scale, power), scale / error ** (1 / power)
    if not 12 < answer < 1000:
        pytest.skip("not between the fewest dots and all")
    dots, interval, _ = smallest_subset_of_error(trials, error, hydrogens=False)
    assert len(dots) == pytest.approx(answer, rel=0.006, abs=1)
    assert len(trials.tried) <= 5 and len(set(trials.tried)) == len(trials.tried)
    slope = power if len(trials.tried) > 1 else 1  # that of the law, where one measurement is enough
    ends = np.clip(answer * np.exp(np.array([-1.96, 1.96]) * 3 / np.sqrt(answer) / slope), 12, 1000)
    assert np.log(interval) == pytest.approx(np.log(ends), abs=0.06)


def test_what_was_found_is_told_in_numbers(caplog):
    """The error is 2 / n Å, the standard error of its logarithm 0.3; 1.96 of them are 0.588."""
    with caplog.at_level("INFO", "sparsurf"):
        _, (low, high), _ = smallest_subset_of_error(MadeUp(), 0.02, hydrogens=False)
        smallest_subset_of_error(MadeUp(), 1.0, hydrogens=False)
    assert caplog.messages == [
        f"made up: reconstructed from 100 of 1000 dots by farthest (95 %: {low:.0f} to {high:.0f}), "
        "the surface deviates by 0.02 Å on average",
        "made up: reconstructed from 12 of 1000 dots by farthest, the surface deviates by 1 Å on average",
    ]
    assert (low, high) == pytest.approx((100 * np.exp(-0.588), 100 * np.exp(0.588)), rel=1e-3)


def test_the_z_that_was_reached_is_told_with_its_interval(blob, caplog):
    prepared = PreparedSurface(sparsurf.Surface(*blob), streams=Streams(1, "blob"))
    with caplog.at_level("INFO", "sparsurf"):
        dots = find_subset(prepared, "uniform", z=1.5, n_tests=30)
    tests = prepared.draw_tests(30)
    z = estimate(prepared.distances([dots], tests, prepared.describe(tests)[0], "full")[0])
    mean, low, high = map(float, (z.mean, z.low, z.high))
    ends = f"{mean:.3f} (95 %: {low:.3f} to {high:.3f})"
    assert caplog.messages == [f"blob: uniform reaches Z = {ends} with {len(dots)} of 3000 dots"]
    assert 1.4 < mean <= 1.5


@pytest.mark.parametrize(("n", "warns"), [(110, False), (111, True), (90, False), (89, True)])
def test_a_tenth_more_or_fewer_dots_than_requested_are_no_warning(n, warns, caplog):
    warn_if_number_differs("paper", 100, n)
    words = (
        f"paper keeps {n} dots instead of 100: its number of dots is random, and limited by its combinations"
    )
    assert caplog.messages == [words] * warns


def test_the_papers_sampler_looks_for_a_z_among_its_choices(blob):
    """Of which this one, even with alpha = 1, keeps few dots; others keep all that it may."""
    settings = Settings(patches={"d_link": 0.8})
    prepared = PreparedSurface(sparsurf.Surface(*blob), settings, streams=Streams(1, "blob"))
    few = Choices(np.zeros(1), np.array([[1.0, 1.0, 10.0, 10.0]]))
    with pytest.raises(InputError, match=r"max_z is 0.5, but paper reaches only [1-9]"):
        find_subset(prepared, "paper", z=0.5, n_tests=10, choices=few)
    assert Trials(prepared, "paper", 10).z(3000) < 0.5


def test_a_subset_that_differs_from_the_request_is_reported(blob, caplog):
    settings, few = Settings(patches={"d_link": 0.8}), Choices(np.zeros(1), np.array([[1.0, 1, 10, 10]]))
    prepared = PreparedSurface(sparsurf.Surface(*blob), settings, streams=Streams(1, "blob"))
    dots = find_subset(prepared, "paper", 2000, choices=few)
    assert [message.split(":")[0] for message in caplog.messages] == [
        f"paper keeps {len(dots)} dots instead of 2000"
    ]
    find_subset(prepared, "farthest", 20)
    assert len(caplog.messages) == 1


def test_the_stream_of_a_subset_is_that_of_its_sampler(blob):
    prepared = PreparedSurface(sparsurf.Surface(*blob), streams=Streams(7, "blob"))
    for name in ("uniform", "farthest", "poisson"):
        wanted = get_sampler(name)(prepared, 90, prepared.stream("minimal", name))
        trials = Trials(prepared, name, 9)
        assert np.array_equal(draw_subset(prepared, name, 90), wanted)
        assert np.array_equal(trials.draw(90), wanted) and len(trials.tests) == 9
        assert trials.error(3000) == (0, 0, 0, 0)


def test_the_search_starts_where_the_law_says():
    for hydrogens, n in ((False, 100), (True, 120)):  # 160 Å^2 x 0.0125 or 0.015 Å / 0.02 Å
        trials = MadeUp()
        smallest_subset_of_error(trials, 0.02, hydrogens)
        assert trials.tried[0] == n


def test_all_dots_of_a_tiny_surface_are_needed():
    trials = MadeUp()
    trials.n_dots = 5
    dots, interval, _ = smallest_subset_of_error(trials, 0.5, hydrogens=False)
    assert len(dots) == 5 and interval is None


def test_beyond_the_dots_of_the_surface_there_is_no_interval():
    for error, n, reason in ((1.0, 12, "fewest"), (0.0001, 1000, "all")):
        dots, interval, decided_by = smallest_subset_of_error(MadeUp(), error, hydrogens=False)
        assert len(dots) == n and interval is None and decided_by == reason


@pytest.mark.parametrize(("error", "sampler"), [(0.05, "farthest"), (0.03, "uniform"), (0.04, "poisson")])
def test_the_surface_is_as_far_off_as_was_asked_for(error, sampler):
    surface = sparsurf.surface(ROOT / "data" / "tdp43" / "topology.pdb")
    few = sparsurf.minimal(surface, error=error, sampler=sampler)
    fresh = sparsurf.surface(surface.molecule, density=8.0)
    reached = distance_to_recovered(fresh.points, few.points, few.normals, 1, DENSITY_FOR_ERRORS).mean()
    if sampler == "farthest":
        assert reached == pytest.approx(error, rel=0.02)
        assert few.interval[0] < len(few) < few.interval[1] < 1.1 * few.interval[0]
    else:
        assert reached == pytest.approx(error, rel=0.15)


def test_the_error_of_the_error_is_that_of_the_cells_of_the_kept_dots():
    """Half of the kept dots, which lie on the surface, see 1 Å all around, the other half 3 Å: 8 cells, sd 1, mean 2."""
    points = np.array([[10.0 * k + x, 0, 0] for k in range(8) for x in (0.0, 1.0, -1.0, 2.0)])
    surface = sparsurf.Surface(points, np.tile([0, 0, 1.0], (len(points), 1)), np.ones(len(points)))
    trials = Trials(PreparedSurface(surface), "farthest", 2)
    distance = np.repeat([1.0, 3.0] * 4, 4)
    distance[::4] = 0.0
    with pytest.MonkeyPatch.context() as patch:
        others = np.delete(distance, np.arange(0, 32, 4))
        patch.setattr("sparsurf.evaluation.trials.distance_to_reconstructed", lambda *_: others)
        measured = trials._measure_error(np.arange(0, 32, 4))
    assert measured == pytest.approx((2.0, 1 / np.sqrt(8) / 2, 3.0, 0.0))


def test_dots_per_area():
    surface = sparsurf.surface(ROOT / "data" / "tdp43" / "topology.pdb")
    few = sparsurf.minimal(surface, density=0.6)
    assert len(few) == round(0.6 * surface.area.sum())
    with pytest.raises(InputError, match=r"density is 50, but .* has 5.* dots per Å\^2"):
        sparsurf.minimal(surface, density=50)
