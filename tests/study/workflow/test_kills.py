"""SIGKILL within the writes of a study: the next run ends in the bytes of an undisturbed one.

evidence/kill_studies.py has more kills.
"""

import shutil

import pytest

import kills
from kills import Kill

RESULTS = ("results/one/one/c1/surface.npz", "results/one/one/c1/roughness.csv")


@pytest.fixture(scope="module")
def undisturbed(tmp_path_factory):
    """A checkout whose study has run up to the roughness of its surface, under an account without a home."""
    folder = kills.checkout(tmp_path_factory.mktemp("kills") / "undisturbed")
    process = kills.run(kills.study("one", *RESULTS), folder, HOME="~", XDG_CACHE_HOME="")
    assert process.returncode == 0, process
    return folder


@pytest.mark.parametrize(
    ("kill", "meets"),
    [
        (Kill(r"/surface\.npz$"), None),
        (Kill(r"/roughness\.csv$", "job"), None),
        # the job of a killed Snakemake writes on while the next run computes the same
        (
            Kill(r"/components\.csv$", "snakemake", seconds=4.0),
            Kill(r"one/c1/surface\.npz$", "nobody", seconds=5.0),
        ),
    ],
)
def test_a_run_after_a_kill_ends_in_the_bytes_of_an_undisturbed_one(undisturbed, tmp_path, kill, meets):
    folder, command = tmp_path / "killed", kills.study("one", *RESULTS)
    shutil.copytree(undisturbed, folder, symlinks=True)
    for result in RESULTS:
        (folder / result).unlink()
    process = kills.run(command, folder, kill, undisturbed)
    assert process.returncode != 0, process
    process = kills.run(command, folder, meets)
    assert process.returncode == 0, process
    known, found = (kills.content(root / "results" / "one" / "one") for root in (undisturbed, folder))
    assert found == known
