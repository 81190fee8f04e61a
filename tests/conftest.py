"""Fixtures that several test files share."""

import fcntl
import gc
import os
import sys
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, settings

from browser import Browser
from browser import program as browser_program
from sparsurf import progress

# the same examples on every machine, however slow it is; HYPOTHESIS_PROFILE=default looks for new ones
settings.register_profile(
    "repeatable", derandomize=True, deadline=None, suppress_health_check=[HealthCheck.too_slow]
)
settings.load_profile(os.environ.get("HYPOTHESIS_PROFILE", "repeatable"))

progress.SECONDS_PER_LINE = 1e6  # no line tells that a busy machine is still working

# bytecode is kept, as in the Makefile: tests start dozens of processes
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
sys.dont_write_bytecode = False

ROOT = Path(__file__).resolve().parents[1]
SLOW_FIXTURES = {"study", "many", "browser"}  # whole studies, and a browser: their tests are marked slow


@pytest.fixture(scope="session")
def shared():
    """The folder of reference data beside the checkout; tests that need it skip where it is absent."""
    path = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared"))
    if not (path / "data" / "MANIFEST.tsv").is_file():
        pytest.skip(
            f"reference data not found (a folder {path.name}/ beside the checkout, or $SPARSURF_SHARED)"
        )
    return path


@pytest.fixture(scope="session")
def a1(shared):
    """The DMS surface of A1, the paper's example: 20045 dots."""
    from sparsurf.surfaces.read_surface import read_surface

    return read_surface(shared / "data" / "tdp43" / "A1.dms.gz")


@pytest.fixture(scope="session")
def blob():
    """A bumpy closed surface of 3000 dots with a satellite that patches must drop: points and unit normals."""
    return make_blob(3000)


@pytest.fixture(scope="session")
def study(tmp_path_factory):
    """Folder of the small study of small_study.py, finished; one for all workers of pytest-xdist, so nobody changes it."""
    import warm_python
    from small_study import output, run_study

    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    with open(base / "study.lock", "w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        if not (base / "study.log").is_file():
            process = run_study(base / "study", warm_python.interpreter())
            (base / "study.log").write_text(f"exit code {process.returncode}\n{output(process)}")
    log = (base / "study.log").read_text()
    assert log.startswith("exit code 0\n"), log[-3000:]
    return base / "study"


@pytest.fixture(scope="session")
def chromium(tmp_path_factory):
    """One browser for all tests of a worker."""
    if browser_program() is None:
        pytest.skip("Chromium is not installed (sh tests/install_extras.sh): no page was tried in a browser")
    made = Browser(tmp_path_factory.mktemp("browser"))
    yield made
    made.close()


@pytest.fixture
def browser(chromium):
    """The browser with a window of 1280 by 900 pixels; what the console says of a page is an error."""
    chromium.screen(1280, 900, telephone=False)
    chromium.media()
    yield chromium
    complaints = chromium.complaints()
    chromium.load("about:blank")
    assert complaints == []


def sphere(n):
    """Unit vectors spread evenly, (n, 3), with their angles."""
    k = np.arange(n) + 0.5
    polar, azimuth = np.arccos(1 - 2 * k / n), np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)
    return unit, polar, azimuth


def ball(n, radius=1.0):
    """Points and normals of an evenly covered sphere."""
    unit = sphere(n)[0]
    return radius * unit, unit


def make_blob(n, seed=5):
    """Dots spread over r = 8 + bumps (Å) with approximate normals, and a small sphere beside it."""
    rng = np.random.default_rng(seed)
    unit, polar, azimuth = sphere(n - 60)
    radius = 8 + 0.8 * np.sin(3 * azimuth) * np.sin(polar) ** 3 + 0.5 * np.cos(5 * polar)
    small = rng.normal(size=(60, 3))
    small /= np.linalg.norm(small, axis=1)[:, None]
    points = np.concatenate([unit * radius[:, None], small * 0.8 + [11.5, 0, 0]])
    normals = np.concatenate([unit + 0.2 * rng.normal(size=unit.shape), small])
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    order = rng.permutation(n)
    return points[order], normals[order]


# The files whose tests run whole studies or build packages, by the worker of the three of `make test` that begins with them
LONG = (
    ("test_slurm.py", "test_runs.py"),
    ("test_extending.py", "test_every_rule.py"),
    ("test_package.py", "test_documented_workflows.py", "test_simulation.py"),
)


@pytest.hookimpl(tryfirst=True)  # before -m selects
def pytest_collection_modifyitems(items):
    """Each worker begins with long tests; what reads the finished small study comes last.

    `--dist worksteal` gives a third of the list to each worker, and who has finished takes tests from the end of another third.
    So the others fill the time that the long ones take, and no two workers share a fixture that takes minutes.
    """
    long = [[item for name in names for item in items if item.path.name == name] for names in LONG]
    named = {name for names in LONG for name in names}
    others = sorted(
        (item for item in items if item.path.name not in named), key=lambda item: "study" in item.fixturenames
    )
    ordered, size = [], -(-len(items) // len(LONG))
    for part in long:
        n = max(0, size - len(part))
        ordered, others = [*ordered, *part, *others[:n]], others[n:]
    items[:] = ordered + others
    for item in items:
        if not SLOW_FIXTURES.isdisjoint(item.fixturenames):
            item.add_marker(pytest.mark.slow)


def pytest_collection_finish():
    """Keep what every test shares out of each search of the garbage collector."""
    gc.collect()
    gc.freeze()


def pytest_unconfigure(config):
    """Say on the very last line which tests were skipped, and why."""
    reporter = config.pluginmanager.get_plugin("terminalreporter")
    skipped = reporter.stats.get("skipped", []) if reporter else []
    reasons = Counter(str(report.longrepr[2]).removeprefix("Skipped: ") for report in skipped)
    if reasons:
        told = "; ".join(f"{count}: {reason}" for reason, count in reasons.most_common())
        reporter.write_line(f"\nSkipped {told}.")
