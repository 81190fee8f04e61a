"""The library as a package: built, installed into an empty environment, used from another folder. No network."""

import ctypes
import os
import shutil
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile
from pathlib import Path

import numpy as np
import pytest
import yaml

import sparsurf
from conftest import ROOT

pytestmark = pytest.mark.release

USE = """
import sys, sparsurf
sys.modules |= dict.fromkeys(["jinja2", "matplotlib", "snakemake", "tables", "yaml"])  # of the study
print(sparsurf.__file__, sparsurf.__version__)
assert not {"numpy", "numba", "pandas", "scipy", "mdtraj", "pydantic"} & set(sys.modules), "the import is not cheap"
dots = sparsurf.surface("protein.pdb", density=1.0, d_link=1.5)
sparsurf.write(dots, "dots.ply")
print(len(dots), dots.points.sum(), dots.normals.sum())
"""
USE_KERNEL = """
import numpy as np, sparsurf
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf import progress

compiled = []
progress.before_compiling = lambda: compiled.append(1)
points = np.array([[0.0, 0, 0], [1, 0, 0]])
print(gaussian_mean(np.array([0.0, 1]), points, points)[0], len(compiled))
"""
SPHERES = "ATOM  {:5d}  {:3s} ALA A   1    {:8.3f}{:8.3f}{:8.3f}  1.00  0.00           C  \n"


def run(command, **keys):
    """Standard output of a command that must succeed."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **keys)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def build_wheel(project, folder, **variables):
    """The wheel of a project in a folder, which must hold no other."""
    pytest.importorskip("hatchling", reason="hatchling builds the wheel")
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "wheel", "--quiet", "--no-index"]
    command = [*pip, "--no-deps", "--no-build-isolation", "--wheel-dir", folder, project]
    run(command, cwd=folder, env=os.environ | variables)
    return next(folder.glob("sparsurf-*.whl"))


def environment_with(wheel, folder):
    """Python of an environment that holds the wheel, if there is one, and only sees the packages that it depends on."""
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    if wheel:
        install(python, wheel)
    own = next(folder.glob("lib/python*/site-packages"))
    (own / "dependencies.pth").write_text(sysconfig.get_paths()["purelib"])
    return python


def install(python, wheel, *options):
    """Install a wheel for a Python, as `pip install` does."""
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--disable-pip-version-check",
        "--python",
        python,
        "install",
        "--quiet",
    ]
    run([*pip, "--no-index", "--no-deps", *options, wheel])


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of this checkout for an index, without kernels."""
    return build_wheel(ROOT, tmp_path_factory.mktemp("wheel"), HATCH_BUILD_NO_HOOKS="1")


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """bin/ of an environment that holds the wheel, and only sees the packages that it depends on."""
    return environment_with(wheel, tmp_path_factory.mktemp("environment")).parent


def test_the_wheel_holds_library_study_and_their_data(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    sources = ROOT / "src"
    files = {path for path in sources.rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {str(path.relative_to(sources)) for path in files} <= names
    packages = {"snakemake_logger_plugin_sparsurf", "sparsurf", "sparsurf_study"}
    assert {name.partition("/")[0] for name in names} == packages | {
        f"sparsurf-{sparsurf.__version__}.dist-info"
    }
    assert wheel.stat().st_size < 5_000_000  # of which the trajectory of the default study takes 3.6 MB
    assert wheel.name == f"sparsurf-{sparsurf.__version__}-py3-none-any.whl"


def test_installed_it_is_used_from_another_folder(installed, tmp_path):
    """Uncompiled here, which gives the same numbers."""
    xyz = np.array([[0, 0, 0], [3, 0, 0.5], [1, 2.5, 0]], dtype=float)
    lines = [
        SPHERES.format(k + 1, name, *place)
        for k, (name, place) in enumerate(zip(("CA", "CB", "C"), xyz, strict=True))
    ]
    (tmp_path / "protein.pdb").write_text("".join(lines))
    environment = {name: os.environ[name] for name in ("PATH", "LANG") if name in os.environ}
    environment |= {"NUMBA_DISABLE_JIT": "1"}
    first, second = run([installed / "python", "-c", USE], cwd=tmp_path, env=environment).splitlines()
    assert first.startswith(str(installed.parent)) and first.endswith(sparsurf.__version__)
    dots = sparsurf.surface((xyz, np.full(3, 1.9)), density=1.0, d_link=1.5)
    count, points, normals = second.split()
    assert int(count) == len(dots)
    assert np.allclose([float(points), float(normals)], [dots.points.sum(), dots.normals.sum()], atol=1e-8)
    command = [installed / "sparsurf", "surface", "protein.pdb", "--density", "1", "-o", "-"]
    table = run(command, cwd=tmp_path, env=environment).splitlines()
    assert len(table) == len(dots) + 1


@pytest.fixture
def project(tmp_path):
    """A copy of what a wheel is built from, in which `compile_kernels` compiles one small kernel alone."""
    folder = tmp_path / "project"
    ignored = shutil.ignore_patterns("__pycache__")
    shutil.copytree(ROOT / "src", folder / "src", ignore=ignored)
    for name in ("config", "data", "studies"):
        (folder / name).symlink_to(ROOT / name)
    for name in ("pyproject.toml", "hatch_build.py", "README.md", "LICENSE"):
        shutil.copy(ROOT / name, folder)
    (folder / "src" / "sparsurf" / "compile_kernels.py").write_text(USE_KERNEL)
    return folder


def use_kernel(python, folder, **variables):
    """What the kernel of the smoothing gives in an environment, and whether it was compiled."""
    environment = {"PATH": os.environ["PATH"], "HOME": str(folder)} | variables
    value, compiled = run([python, "-c", USE_KERNEL], cwd=folder, env=environment).split()
    return float(value), compiled != "0"


def test_an_upgrade_does_not_run_the_kernels_of_the_older_version(project, tmp_path):
    """pip leaves the kernels that were stored beside the modules, and only another file of their source has changed."""
    for name in ("older", "newer"):
        (tmp_path / name).mkdir()
    older = build_wheel(project, tmp_path / "older", HATCH_BUILD_NO_HOOKS="1")
    python = environment_with(older, tmp_path / "environment")
    first = use_kernel(python, tmp_path)
    assert first == (pytest.approx(use_kernel(python, tmp_path)[0]), True)
    assert use_kernel(python, tmp_path) == (first[0], False)
    vectors = project / "src" / "sparsurf" / "surfaces" / "vectors.py"
    source = vectors.read_text()
    vectors.write_text(source.replace("return (a[0] - b[0]) ** 2 +", "return 2 * (a[0] - b[0]) ** 2 +"))
    assert vectors.read_text() != source
    install(python, build_wheel(project, tmp_path / "newer", HATCH_BUILD_NO_HOOKS="1"), "--force-reinstall")
    stored = [*(tmp_path / "environment").rglob("smoothing*.nbc")]
    plain, _ = use_kernel(python, tmp_path, NUMBA_DISABLE_JIT="1")
    assert stored and plain != pytest.approx(first[0])
    assert use_kernel(python, tmp_path) == (pytest.approx(plain), True)


def test_a_wheel_that_pip_builds_brings_its_kernels(project, tmp_path):
    """They are loaded wherever numba stores others, and not by another processor; a plain wheel where compiling fails."""
    (tmp_path / "compiled").mkdir()
    wheel = build_wheel(project, tmp_path / "compiled")
    version = f"cp{sys.version_info.major}{sys.version_info.minor}"
    assert f"-{version}-{version}-" in wheel.name
    python = environment_with(wheel, tmp_path / "environment")
    value, compiled = use_kernel(python, tmp_path)
    assert not compiled
    brought = [*(tmp_path / "environment").rglob("*.nbc")]
    assert use_kernel(python, tmp_path, NUMBA_CACHE_DIR=str(tmp_path / "cache")) == (value, False)
    other = {"NUMBA_CPU_NAME": "generic", "NUMBA_CPU_FEATURES": ""}
    assert use_kernel(python, tmp_path, **other) == (pytest.approx(value), True)
    run([sys.executable, "-m", "pip", "--python", python, "uninstall", "--yes", "--quiet", "sparsurf"])
    assert brought and not any(path.exists() for path in brought)
    (tmp_path / "plain").mkdir()
    (project / "src" / "sparsurf" / "compile_kernels.py").write_text("raise SystemExit(1)\n")
    assert build_wheel(project, tmp_path / "plain").name.endswith("-py3-none-any.whl")


def test_make_can_install_the_checkout_itself(tmp_path):
    """`pip install --editable`, as the Makefile does, with the packages of the lock alone."""
    build = pytest.importorskip("hatchling.build", reason="hatchling builds the package")
    run([sys.executable, "-c", f"import hatchling.build as b; b.build_editable({str(tmp_path)!r})"], cwd=ROOT)
    with zipfile.ZipFile(next(tmp_path.glob("*.whl"))) as archive:
        paths = {name: archive.read(name).decode() for name in archive.namelist() if name.endswith(".pth")}
    assert (
        paths == {"_sparsurf.pth": str(ROOT / "src")} and build
    )  # which the Makefile replaces by a relative path
    assert "/_sparsurf.pth; do echo ../../../../src" in (ROOT / "Makefile").read_text()


WORKFLOWS = sorted(ROOT.glob(".github/workflows/*.yml"))


@pytest.mark.parametrize("name", ["book", "release"])
def test_nothing_is_published_before_the_repository_says_so(name):
    jobs = yaml.safe_load((ROOT / ".github" / "workflows" / f"{name}.yml").read_text(encoding="utf-8"))[
        "jobs"
    ]
    assert {job["if"] for job in jobs.values()} == {"vars.PUBLISH == 'true'"}
    tokens = [job for job in jobs.values() if "id-token" in job.get("permissions", {})]
    assert len(tokens) == 1 and "build" in tokens[0]["needs"] and "run" not in str(tokens[0]["steps"])


@pytest.mark.skipif(not shutil.which("actionlint"), reason="actionlint is not installed")
def test_actionlint_finds_no_fault_in_the_workflows():
    done = subprocess.run(["actionlint", *WORKFLOWS], capture_output=True, text=True, check=False)
    assert WORKFLOWS and done.returncode == 0, done.stdout + done.stderr


def test_conda_and_pip_ask_for_the_same():
    """The recipe for conda packages has the version, the entry point and the requirements of pyproject.toml."""
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    recipe = yaml.safe_load((ROOT / "envs" / "recipe.yaml").read_text(encoding="utf-8"))
    asked = [f"python {project['requires-python']}", *project["dependencies"]]
    assert [line.replace(" ", "") for line in recipe["requirements"]["run"]] == [
        a.replace(" ", "") for a in asked
    ]
    assert recipe["context"]["version"] == sparsurf.__version__
    assert recipe["build"]["python"]["entry_points"] == [f"{k} = {v}" for k, v in project["scripts"].items()]
    assert recipe["about"]["summary"] == project["description"]


@pytest.fixture
def read_only(tmp_path):
    """Run Python with a package and a home that are read-only: the temporary directory, and a function."""
    folder = tmp_path / "read-only"
    shutil.copytree(
        ROOT / "src" / "sparsurf", folder / "sparsurf", ignore=shutil.ignore_patterns("__pycache__")
    )
    for path in [folder, *folder.rglob("*")]:
        path.chmod(0o555 if path.is_dir() else 0o444)
    (temporary := tmp_path / "temporary").mkdir()
    prctl, drop, override = ctypes.CDLL(None).prctl, 24, 1  # root would write anywhere

    def run_code(code, **variables):
        environment = {
            "PATH": os.environ["PATH"],
            "PYTHONPATH": str(folder),
            "HOME": str(folder),
            "TMPDIR": str(temporary),
        }
        return subprocess.run(
            [sys.executable, "-B", "-c", code], env=environment | variables, cwd="/", capture_output=True, text=True,
            preexec_fn=lambda: prctl(drop, override, 0, 0, 0),
        )  # fmt: skip

    yield temporary, run_code
    for path in [folder, *folder.rglob("*")]:
        if path.is_dir():
            path.chmod(0o755)


CACHE_OF_KERNEL = """
import sparsurf
from sparsurf.dot_fields import smoothing
from numba.core.dispatcher import Dispatcher
print(next(each.stats.cache_path for each in vars(smoothing).values() if isinstance(each, Dispatcher)))
"""


def test_kernels_of_a_read_only_package_lie_in_the_temporary_directory(read_only):
    """As in a container under a service user: numba itself ends with "no locator available"."""
    temporary, run_code = read_only
    done = run_code(CACHE_OF_KERNEL)
    assert done.returncode == 0, done.stderr[-600:]
    [folder] = temporary.glob("sparsurf-kernels-*")
    assert done.stdout.startswith(str(folder)) and folder.stat().st_mode & 0o077 == 0
    assert run_code(CACHE_OF_KERNEL).stdout == done.stdout  # the next process finds them
    (own := temporary / "own").mkdir()
    assert run_code(CACHE_OF_KERNEL, NUMBA_CACHE_DIR=str(own)).stdout.startswith(str(own))
    assert run_code(CACHE_OF_KERNEL, XDG_CACHE_HOME=str(own)).stdout.startswith(str(own / "numba"))


@pytest.mark.parametrize("variables", [{}, {"MPLCONFIGDIR": "/proc/1/matplotlib"}, {"HOME": "~"}])
def test_figures_are_drawn_without_a_warning_where_matplotlib_may_write_nowhere(read_only, variables):
    """Read-only, or an account without a home, whose working folder can be written."""
    temporary, run_code = read_only
    code = "import sparsurf, matplotlib.font_manager; print(matplotlib.get_cachedir())"
    done = run_code(code, **variables)
    assert done.returncode == 0 and "temporary cache" not in done.stderr, done.stderr
    assert done.stdout.startswith(f"{temporary}/sparsurf-kernels-")
    (own := temporary / "own").mkdir()
    assert run_code(code, MPLCONFIGDIR=str(own)).stdout == f"{own}\n"


def test_a_folder_of_kernels_that_others_may_write_is_not_used(read_only):
    temporary, run_code = read_only
    (planted := temporary / f"sparsurf-kernels-{os.getuid()}").mkdir()
    planted.chmod(0o777)
    used = Path(run_code(CACHE_OF_KERNEL).stdout.strip())
    assert used.match(f"{temporary}/sparsurf-kernels-*/*") and planted not in used.parents


def test_where_no_kernel_can_be_stored_a_sentence_names_the_variable(read_only):
    _, run_code = read_only
    nowhere = "import sys, tempfile\ntempfile.tempdir = '/proc/1'\n"
    done = run_code(
        nowhere + "from sparsurf.cli.command import main\nsys.exit(main(['surface', 'a.pdb', '-o', 'a.csv']))"
    )
    assert done.returncode == 1 and done.stderr.count("\n") == 1
    assert done.stderr.startswith("sparsurf surface: no")
    assert done.stderr.endswith("set NUMBA_CACHE_DIR to one that can.\n")
    use = (
        "import sparsurf\nsparsurf.read_molecule\ntry: sparsurf.surface\nexcept sparsurf.InputError: print(1)"
    )
    done = run_code(nowhere + use)
    assert done.stdout == "1\n", done.stderr


@pytest.mark.parametrize("backend", ["module://matplotlib_inline.backend_inline", "qt4agg"])
def test_commands_and_jobs_draw_whatever_backend_is_set(tmp_path, backend):
    environment = os.environ | {"MPLBACKEND": backend}
    code = "import sparsurf_study.report.figures.table1, matplotlib.pyplot as p; print(p.get_backend())"
    assert run([sys.executable, "-c", code], cwd=tmp_path, env=environment).lower() == "agg\n"
    assert "usage" in run(
        [sys.executable, "-m", "sparsurf", "points", "--help"], cwd=tmp_path, env=environment
    )
