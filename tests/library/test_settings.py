"""Settings of the library: each key has limits of its own, and what follows from what was given."""

import pickle

import pytest
from pydantic import ValidationError

from sparsurf.settings import (
    Evaluation,
    Minimal,
    PatchesSettings,
    SamplingSettings,
    Settings,
    SurfaceSettings,
)

DENSITIES = ((SurfaceSettings, "density"), (Minimal, "density"))
LENGTHS = [(PatchesSettings, name) for name in ("r_patch", "r_zernike", "d_link")]
LIMITS = [
    *((*each, [1e-3, 100], [0, 100.1]) for each in (*LENGTHS, *DENSITIES, (Minimal, "percent"))),
    (SurfaceSettings, "probe_radius", [1e-3, 10], [0, 10.1]),
    (Minimal, "error", [1e-3, 10], [0, 10.1]),
    (Minimal, "max_z", [0, 1000], [-0.1, float("inf"), float("nan")]),
    (Minimal, "n_dots", [1, 10**9, 7.0], [0, 10**9 + 1, 7.5]),
    (Minimal, "combination", [[1e-3, 0, 1000, 9]], [[0, 0, 0, 0], [1.1, 0, 0, 0], [1, 0, 1001, 0], [1, 0, 0]]),
    (SamplingSettings, "alpha", [[1e-3, 1]], [[0], [1.1], [], [0.5, 0.5]]),
    *((SamplingSettings, name, [[0, 1000]], [[-1], [1001], [], [2, 2]]) for name in ("beta", "gamma", "delta")),
    (Evaluation, "test_dots", [2, 10**6, "published"], [1, 10**6 + 1, "all"]),
    (Evaluation, "draws", [1, 10_000], [0, 10_001, 2.5]),
    (Evaluation, "readings", [["full", "kept"]], [[], ["full", "full"], ["other"]]),
]  # fmt: skip


@pytest.mark.parametrize(("section", "key", "allowed", "refused"), LIMITS)
def test_each_key_has_its_limits(section, key, allowed, refused):
    for value in allowed:
        assert getattr(section(**{key: value}), key) == value
    for value in refused:
        with pytest.raises(ValidationError):
            section(**{key: value})


def test_a_minimal_subset_has_one_request():
    """An error unless something else is requested; a combination is one of the paper's sampling unless it is the corrected."""
    assert (Minimal().error, Minimal().sampler) == (0.02, "auto")
    assert Minimal(percent=5).error is None and Minimal(error=0.05).error == 0.05
    combination = [0.5, 0, 2, 0]
    for given, sampler in (({}, "paper"), ({"sampler": "paper_corrected"}, "paper_corrected")):
        found = Minimal(combination=combination, **given)
        assert (found.combination, found.sampler, found.error) == (combination, sampler, None)
    with pytest.raises(ValidationError, match=r"takes only one of .*, but has percent, max_z; keep one"):
        Minimal(percent=5, max_z=1)


def test_a_default_that_is_written_out_is_the_default():
    """4 is the 4.0 of r_patch, while other integers stay what they are."""
    for written in (4, 4.0):
        assert repr(PatchesSettings(r_patch=written)) == repr(PatchesSettings())
    assert repr(PatchesSettings(r_patch=5).r_patch) == "5"


def test_what_a_rule_does_not_pass_cannot_be_read():
    """Neither a section nor a key of a section gets its default; keys that a config may lack are None."""
    passed = {"patches": {"d_link": 0.8, "descriptor": "published"}, "minimal": {"percent": 5}, "threads": 2}
    found = Settings.of(passed)
    assert (found.patches.d_link, found.patches.descriptor) == (0.8, "published")
    assert (found.minimal.percent, found.minimal.error, found.minimal.combination) == (5, None, None)
    for read in (
        lambda: found.patches.r_zernike,
        lambda: found.patches.model_copy(update={"d_link": 0.9}).r_zernike,
        lambda: pickle.loads(pickle.dumps(found)).patches.r_zernike,
    ):
        with pytest.raises(
            AttributeError, match=r"patches\.r_zernike was read, but the rule .* does not pass it"
        ):
            read()
    for name in ("surface", "sampling", "evaluation", "fields"):
        with pytest.raises(AttributeError, match=f"^{name} was read"):
            getattr(found, name)
    with pytest.raises(AttributeError, match="sampler was read"):
        _ = found.minimal.sampler
    with pytest.raises(AttributeError, match="attribute 'r_zernicke'"):
        _ = found.patches.r_zernicke
    whole = Settings().model_dump(exclude_none=True)
    assert Settings.of(whole) == Settings(**whole)


def test_a_scaled_link_is_no_reading_of_the_grid():
    readings = ["recovered", "kept_scaled", "full"]
    assert Evaluation(readings=readings).grid_readings == ("recovered", "full")
    assert Evaluation().grid_readings == ("kept", "full")
