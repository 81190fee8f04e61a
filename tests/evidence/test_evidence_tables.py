"""Every committed table and figure of the evidence is requested and written by a rule, and the reverse."""

import re
import subprocess
import sys
from importlib import import_module
from pathlib import Path

import pandas as pd
import pytest

from conftest import ROOT

NOT_BY_RULES = {"bench.csv", "growth.csv"}  # of evidence/bench.py
MSMS_SECONDS = 0.094  # of MSMS for the embedded structure, on the host for which bench.py promises times
UNEVEN = 1.25  # CPU times of the same work on a shared host, of one run and of the next
COMMITTED = {"tables": "evidence/tables", "figures": "docs"}


@pytest.fixture(scope="module")
def requested() -> set[str]:
    """Paths of what `make evidence QUICK=1` makes in the end, without its own folder."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", "evidence/Snakefile"]
    command += ["--configfile", "evidence/quick.yaml", "--nolock", "--summary"]
    shown = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    paths = [Path(line.split("\t")[0]) for line in shown.stdout.splitlines()[1:]]
    home = Path("results/quick_evidence")
    relative = [path.relative_to(home) for path in paths if path.is_relative_to(home)]
    return {path.as_posix() for path in relative if path.parts[0] in COMMITTED}


def test_every_committed_table_is_requested(requested: set[str]):
    tables = {path.name for path in (ROOT / "evidence/tables").glob("*.csv*")}
    made = {Path(path).name for path in requested if path.startswith("tables/")}
    assert tables - NOT_BY_RULES == made


def test_every_requested_figure_is_committed(requested: set[str]):
    others = [path for path in requested if not path.startswith("tables/")]
    assert len(others) >= 8
    for path in others:
        folder, _, name = path.partition("/")
        assert (ROOT / COMMITTED[folder] / name).is_file(), path


def test_no_figure_exceeds_what_is_promised():
    """Memory never; times on a slower host by as much as MSMS is slower there, and by what a shared host is uneven."""
    bench = pd.read_csv(ROOT / "evidence/tables/bench.csv").set_index("what")
    slower = max(
        1, bench.loc["peer: surface of the embedded structure by MSMS, a process", "value"] / MSMS_SECONDS
    )
    promised = bench.dropna(subset="at_most")
    slack = (
        promised["unit"].map({"times": UNEVEN, **dict.fromkeys(("s", "ms", "µs"), UNEVEN * slower)}).fillna(1)
    )
    assert len(promised) > 30
    assert not [*promised.index[promised["value"] > promised["at_most"] * slack]]


def test_every_rule_has_its_function():
    """A rule of the evidence finds its measurement by its own name."""
    rules = [
        text
        for path in (ROOT / "evidence" / "rules").glob("*.smk")
        for text in re.split(r"^rule ", path.read_text(encoding="utf-8"), flags=re.M)[1:]
    ]
    names = [text.split(":")[0] for text in rules if '"../measure.py"' in text]
    assert len(names) == len(rules) > 30
    for name in names:
        assert callable(getattr(import_module(f"measures.{name.split('_', 1)[1]}"), name))
