"""Where compiled kernels are kept: a folder named after their sources, the first that can be written."""

import gc
import hashlib
import os
from pathlib import Path
from types import SimpleNamespace

import pytest

import compile_kernels
from conftest import ROOT
from sparsurf import kernel_cache


@pytest.fixture(autouse=True)
def nothing_told(monkeypatch):
    """No folder is told; what `use` sets is taken back afterwards."""
    monkeypatch.setenv("NUMBA_CACHE_DIR", "")


def test_the_checkout_comes_before_the_cache_of_the_user(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert kernel_cache._places() == [ROOT / ".cache" / "numba", tmp_path / "sparsurf" / "numba"]
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert kernel_cache._places()[1] == tmp_path / "home" / ".cache" / "sparsurf" / "numba"
    monkeypatch.setattr(kernel_cache, "LIBRARY", tmp_path / "site-packages" / "sparsurf")  # installed
    assert kernel_cache._places() == [tmp_path / "home" / ".cache" / "sparsurf" / "numba"]


def test_a_folder_that_is_told_is_the_only_one(monkeypatch, tmp_path):
    for told in (tmp_path, tmp_path / "sources-of-a-parent"):
        monkeypatch.setenv("NUMBA_CACHE_DIR", str(told))
        assert kernel_cache._places() == [tmp_path]


def test_the_folder_is_named_after_the_sources(monkeypatch, tmp_path):
    # not in tests/mutation, whose copy has one folder for all
    sources = kernel_cache.kernel_sources()
    monkeypatch.setattr(
        kernel_cache, "_places", lambda: [tmp_path / "file" / "x", tmp_path / "b", tmp_path / "c"]
    )
    (tmp_path / "file").write_text("")  # no folder can be made in it
    kernel_cache.use()
    wanted = tmp_path / "b" / f"sources-{hashlib.sha256(sources).hexdigest()[:16]}"
    assert Path(os.environ["NUMBA_CACHE_DIR"]) == wanted and wanted.is_dir() and not (tmp_path / "c").exists()
    monkeypatch.setattr(kernel_cache, "kernel_sources", lambda: sources + b"# an edit")
    kernel_cache.use()
    assert Path(os.environ["NUMBA_CACHE_DIR"]) != wanted


def test_sources_are_those_of_kernels_and_of_what_they_import(monkeypatch, tmp_path):
    texts = {
        "kernel.py": "from numba import njit\nfrom sparsurf.deep.constants import A\nfrom sparsurf import plain\n",
        "deep/constants.py": "A = 1\n",
        "plain.py": "B = 2\n",
        "apart.py": "C = 3\n",
        "deep/apart.py": "D = 4\n",
    }
    for name, text in texts.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(kernel_cache, "LIBRARY", tmp_path)
    assert kernel_cache.kernel_sources().decode() == "".join(
        texts[name] for name in ("deep/constants.py", "kernel.py", "plain.py")
    )


def test_kernels_that_were_compiled_are_not_run_again(monkeypatch, tmp_path):
    """A mark of each part, descriptor, numba and machine beside the kernels; the rule's own output comes either way."""
    ran, out = [], {"mark": tmp_path / "out"}
    for name in ("_surfaces_and_pictures", "_recovery", "_patches", "_choices"):
        monkeypatch.setattr(compile_kernels, name, lambda *given, name=name: ran.append((name, *given)))
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    surfaces = [("_surfaces_and_pictures",), ("_recovery",)]
    for part, descriptor, expected in (
        ("surfaces", "published", surfaces),
        ("surfaces", "published", []),
        ("patches", "published", [("_patches", "published"), ("_choices",)]),
        ("patches", "steady", [("_patches", "steady"), ("_choices",)]),
        ("patches", "published", []),
    ):
        compile_kernels.main(out, part, descriptor)
        assert ran == expected and out["mark"].read_text() == "kernels compiled\n"
        ran.clear()
        out["mark"].unlink()
    monkeypatch.setattr("importlib.metadata.version", lambda name: "0.0")
    compile_kernels.main(out, "surfaces", "published")
    assert ran == surfaces
    monkeypatch.setattr("os.uname", lambda: SimpleNamespace(nodename="another"))
    compile_kernels.main(out, "surfaces", "published")
    assert ran == 2 * surfaces


def test_what_fails_to_compile_is_tried_again(monkeypatch, tmp_path):
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    monkeypatch.setattr(compile_kernels, "_surfaces_and_pictures", lambda: 1 / 0)
    for _ in range(2):
        with pytest.raises(ZeroDivisionError):
            compile_kernels.main({"mark": tmp_path / "out"}, "surfaces", "published")
    assert gc.isenabled()  # it is off only while kernels are compiled
