"""Rules of the repository that no linter knows; which way imports point: `lint-imports`, in pyproject.toml."""

import re
import subprocess
import sys

import pytest
import yaml

from conftest import ROOT
from sparsurf_study.workflow.models import Config

SOURCES = ROOT / "src"


def test_conda_and_pip_name_the_same_versions():
    text = (ROOT / "envs" / "requirements.txt").read_text()
    lock = set(re.findall(r"^([a-z0-9_.-]+==[0-9]+\.[0-9]+(?:\.[0-9]+)?)", text, re.M))
    for line in yaml.safe_load((ROOT / "envs" / "study.yaml").read_text())["dependencies"]:
        name, version = line.split("=", 1)
        if name != "python":
            assert f"{'tables' if name == 'pytables' else name}=={version}" in lock, line


def test_results_are_not_committed_and_no_file_is_huge():
    listed = subprocess.run(["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=False)
    if listed.returncode:
        pytest.skip("no git checkout")
    files = [ROOT / name for name in listed.stdout.splitlines() if (ROOT / name).is_file()]
    assert [f.name for f in files if f.parent.name == "results"] == ["README.md"]
    assert max(f.stat().st_size for f in files) < 5_000_000


def test_every_section_of_the_config_is_in_the_default_config():
    text = (ROOT / "config.yaml").read_text()
    for key in Config.model_fields:
        assert key in text or key == "paper", key


def test_reading_a_config_imports_nothing_heavy():
    """Every start of snakemake pays for what these import; numpy and pandas take longer than all the rest."""
    modules = [
        path.stem
        for path in (SOURCES / "sparsurf_study" / "workflow").glob("*.py")
        if path.stem != "__init__"
    ]
    code = f"import sys, {', '.join(f'sparsurf_study.workflow.{name}' for name in sorted(modules))}; "
    code += "print(*{'numpy', 'pandas', 'scipy', 'matplotlib', 'numba'} & set(sys.modules))"
    run = subprocess.run(
        [sys.executable, "-c", code], cwd=SOURCES, capture_output=True, text=True, check=True
    )
    assert run.stdout == "\n"


def test_no_kernel_lets_the_compiler_change_a_result():
    """Reordered sums, fused products and products with an inverse differ from one compilation and processor to the next."""
    for path in SOURCES.rglob("*.py"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"fastmath=True|\"(reassoc|contract|arcp|afn|fast)\"", text), path
