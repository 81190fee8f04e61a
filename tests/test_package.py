"""The library as a package: built, installed into an empty environment, used from another folder. No network."""

import os
import subprocess
import sys
import sysconfig
import tomllib
import venv
import zipfile

import numpy as np
import pytest
import yaml

import sparsurf
from conftest import ROOT

USE = """
import sys, sparsurf
sys.modules |= dict.fromkeys(["jinja2", "matplotlib", "snakemake", "tables", "yaml"])  # of the study
print(sparsurf.__file__, sparsurf.__version__)
assert not {"numpy", "numba", "pandas", "scipy", "mdtraj", "pydantic"} & set(sys.modules), "the import is not cheap"
dots = sparsurf.surface("protein.pdb", density=1.0, d_link=1.5)
sparsurf.write(dots, "dots.ply")
print(len(dots), dots.points.sum(), dots.normals.sum())
"""
KERNELS = """
from pathlib import Path
import numpy as np, users
from sparsurf.compile_kernels import remove_kernels
from sparsurf.dot_fields.smoothing import gaussian_mean

points = np.zeros((2, 3))
assert gaussian_mean(np.ones(2), points, points).tolist() == [1, 1] and users.double(2) == 4
print(*(len(list(Path("cache").rglob(f"{name}*.nbc"))) for name in ("smoothing", "users")))
remove_kernels()
print(*(len(list(Path("cache").rglob(f"{name}*.nb?"))) for name in ("smoothing", "users")))
"""
SPHERES = "ATOM  {:5d}  {:3s} ALA A   1    {:8.3f}{:8.3f}{:8.3f}  1.00  0.00           C  \n"


def run(command, **keys):
    """Standard output of a command that must succeed."""
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True, check=False, **keys)
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


@pytest.fixture(scope="module")
def wheel(tmp_path_factory):
    """The wheel of this checkout."""
    pytest.importorskip("hatchling", reason="hatchling builds the wheel")
    folder = tmp_path_factory.mktemp("wheel")
    pip = [
        sys.executable,
        "-m",
        "pip",
        "--disable-pip-version-check",
        "wheel",
        "--quiet",
        "--no-index",
        "--no-deps",
    ]
    run([*pip, "--no-build-isolation", "--wheel-dir", folder, ROOT], cwd=folder)
    return next(folder.glob("sparsurf-*.whl"))


@pytest.fixture(scope="module")
def installed(wheel, tmp_path_factory):
    """bin/ of an environment that holds the wheel, and only sees the packages that it depends on."""
    folder = tmp_path_factory.mktemp("environment")
    venv.create(folder, with_pip=False)
    python = folder / "bin" / "python"
    pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "--python", python]
    run([*pip, "install", "--quiet", "--no-index", "--no-deps", wheel])
    own = next(folder.glob("lib/python*/site-packages"))
    (own / "dependencies.pth").write_text(sysconfig.get_paths()["purelib"])
    return python.parent


def test_the_wheel_holds_the_library_and_its_data(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    library = ROOT / "src" / "sparsurf"
    files = {path for path in library.rglob("*") if path.is_file() and "__pycache__" not in path.parts}
    assert {str(path.relative_to(library.parent)) for path in files} <= names
    assert {name.partition("/")[0] for name in names} == {
        "sparsurf",
        f"sparsurf-{sparsurf.__version__}.dist-info",
    }
    assert wheel.stat().st_size < 1_000_000
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


def test_compiled_kernels_of_the_package_can_be_removed(tmp_path):
    (tmp_path / "users.py").write_text("from numba import njit\ndouble = njit(cache=True)(lambda x: 2 * x)\n")
    path = os.pathsep.join([str(ROOT / "src"), str(tmp_path)])
    environment = os.environ | {"NUMBA_CACHE_DIR": "cache", "PYTHONPATH": path}
    assert run([sys.executable, "-c", KERNELS], cwd=tmp_path, env=environment) == "1 1\n0 2\n"


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
