"""Where compiled kernels are stored: a folder named after their sources, the first that can be written."""

import gc
import hashlib
import os
import re
import subprocess
import sys
from pathlib import Path

import numba
import pytest

from conftest import ROOT
from sparsurf import kernel_cache


@pytest.fixture(autouse=True)
def fresh(monkeypatch):
    """No folder is set by the environment, and none is remembered."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", "")
    kernel_cache.cache_folder.cache_clear()
    yield
    kernel_cache.cache_folder.cache_clear()


def test_the_checkout_comes_before_the_cache_of_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert kernel_cache._parent_folders() == [ROOT / ".cache" / "numba", tmp_path / "sparsurf" / "numba"]
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert kernel_cache._parent_folders()[1] == tmp_path / "home" / ".cache" / "sparsurf" / "numba"
    monkeypatch.setattr(kernel_cache, "LIBRARY", tmp_path / "site-packages" / "sparsurf")  # installed
    assert kernel_cache._parent_folders() == [tmp_path / "home" / ".cache" / "sparsurf" / "numba"]


def test_the_folder_of_the_environment_is_the_only_one(monkeypatch, tmp_path):
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    assert kernel_cache._parent_folders() == [tmp_path]


def test_the_folder_is_named_after_the_sources(monkeypatch, tmp_path):
    # not in tests/mutation, whose copy has one folder for all
    sources = kernel_cache.kernel_sources()
    folders = [tmp_path / "file" / "x", tmp_path / "b", tmp_path / "c"]
    monkeypatch.setattr(kernel_cache, "_parent_folders", lambda: folders)
    (tmp_path / "file").write_text("")  # no folder can be made in it
    expected = tmp_path / "b" / f"sources-{hashlib.sha256(sources).hexdigest()[:16]}"
    assert Path(kernel_cache.cache_folder()) == expected and expected.is_dir()
    assert not (tmp_path / "c").exists()
    monkeypatch.setattr(kernel_cache, "kernel_sources", lambda: sources + b"# an edit")
    kernel_cache.cache_folder.cache_clear()
    assert Path(kernel_cache.cache_folder()).parent == tmp_path / "b"
    assert Path(kernel_cache.cache_folder()) != expected


def test_sources_are_those_of_kernels_and_of_what_they_import(monkeypatch, tmp_path):
    texts = {
        "kernel.py": "from sparsurf.deep.constants import A\nfrom sparsurf import plain\n@njit(cache=True)\n",
        "deep/constants.py": "A = 1\n",
        "plain.py": "B = 2\n",
        "unrelated.py": "C = 3\n",
        "deep/unrelated.py": "D = 4\n",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(kernel_cache, "LIBRARY", tmp_path)
    assert kernel_cache.kernel_sources().decode() == "".join(
        texts[name] for name in ("deep/constants.py", "kernel.py", "plain.py")
    )


def test_constants_compiled_into_kernels_are_among_their_sources():
    # zernike.py has no kernel, but its number of pixels is part of those in images.py
    assert b"PIXELS = 25" in kernel_cache.kernel_sources()
    assert b"import mdtraj" not in kernel_cache.kernel_sources()


def files_in(folder):
    return sum(len(files) for *_, files in os.walk(folder))


def run_kernel(base):
    """Run a kernel of the package and one of a user in a fresh process; the folder of the former."""
    (base.parent / "users.py").write_text(
        "from numba import njit\n@njit(cache=True)\ndef double(x):\n    return 2 * x\n"
    )
    code = """
import os, numba
before = dict(os.environ)
import sparsurf
assert "sparsurf.kernel_cache" not in __import__("sys").modules
from sparsurf.dot_fields.smoothing import gaussian_mean
import numpy as np, users
from sparsurf.kernel_cache import cache_folder
points = np.zeros((2, 3))
assert gaussian_mean(np.ones(2), points, points).tolist() == [1, 1] and users.double(2) == 4
assert os.environ == before and numba.config.CACHE_DIR == before["NUMBA_CACHE_DIR"]
print(cache_folder())
"""
    path = os.pathsep.join([str(ROOT / "src"), str(base.parent)])
    environment = os.environ | {"NUMBA_CACHE_DIR": str(base), "PYTHONPATH": path}
    run = subprocess.run(
        [sys.executable, "-c", code], env=environment, capture_output=True, text=True, check=False
    )
    assert run.returncode == 0, run.stderr
    return run.stdout.strip()


def test_stored_kernels_load_without_what_compiles(tmp_path):
    """numba loads its compiler for the first kernel of a process, stored or not; a stored one needs no compiler."""
    code = """
import sys
import numpy as np
from sparsurf.dot_fields.smoothing import gaussian_mean
points = np.zeros((2, 3))
assert gaussian_mean(np.ones(2), points, points).tolist() == [1, 1]
print("numba.typed.typeddict" in sys.modules, "scipy.linalg" in sys.modules)
import numba
assert numba.njit(lambda x: sum([x, x]))(2) == 4  # the compiler is there for whom needs it
"""
    environment = os.environ | {"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT / "src")}
    call = [sys.executable, "-c", code]
    told = [
        subprocess.run(call, env=environment, capture_output=True, text=True, check=True).stdout
        for _ in range(2)
    ]
    assert told == ["True True\n", "False False\n"]


def test_only_the_kernels_of_the_package_are_stored_in_the_folder_of_their_sources(tmp_path):
    base = tmp_path / "kernels"
    base.mkdir()
    folder = run_kernel(base)
    assert folder.startswith(str(base / "sources-")) and files_in(folder) > 0
    assert files_in(base) > files_in(folder)  # the user's own kernel, where numba puts it


def test_kernels_are_compiled_and_not_stored_if_no_folder_can_be_written(monkeypatch):
    monkeypatch.setattr(kernel_cache, "_parent_folders", lambda: [])
    assert kernel_cache.cache_folder() == ""
    double = kernel_cache.njit(cache=True)(lambda x: 2 * x)
    assert double(2) == 4 and double.stats.cache_path is None


@pytest.mark.parametrize("collecting", [True, False])
def test_garbage_is_collected_again_after_a_kernel_is_compiled(collecting):
    def fail(signature):
        assert not gc.isenabled()
        raise ValueError(signature)

    double = kernel_cache.njit()(lambda x: 2 * x)
    (gc.enable if collecting else gc.disable)()
    try:
        assert double(2) == 4 and gc.isenabled() == collecting
        with pytest.raises(ValueError, match="int64"):
            kernel_cache.without_collecting(fail)("int64")
        assert gc.isenabled() == collecting
    finally:
        gc.enable()


def test_no_kernel_lets_the_compiler_change_a_result():
    """Reordered sums, fused products and products with an inverse differ from one compilation and processor to the next."""
    for path in (ROOT / "src").rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"fastmath=True|\"(reassoc|contract|arcp|afn|fast)\"", text), path.name
