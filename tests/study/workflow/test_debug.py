"""The script of one job in the process of a debugger, as typed: the bytes that Snakemake writes, and where it stops."""

import os
import subprocess
import sys

import pytest
import yaml

import warm_python
from conftest import ROOT
from small_study import snakemake
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf_study import debug

ROUGHNESS = "results/own/p/c1/roughness.csv"


@pytest.fixture(scope="module")
def folder(tmp_path_factory, blob):
    """The folder of a study in which Snakemake measured the roughness of one surface."""
    folder = tmp_path_factory.mktemp("debugged")
    write_npz(folder / "blob.npz", Surface(*blob))
    config = {
        "run": "own",
        "proteins": {"p": {"surface": "blob.npz"}, "q": {"structure": "q.pdb", "trajectory": "q.xtc"}},
        "patches": {"r_patch": 3.0, "d_link": 0.9},
    }
    for name in ("q.pdb", "q.xtc"):
        (folder / name).write_text("of no use here")
    done = snakemake(folder, config, ROUGHNESS, "--quiet", "all")
    assert done.returncode == 0
    (folder / "other.yaml").write_text(yaml.safe_dump(config | {"patches": {"r_patch": 2.0, "d_link": 0.9}}))
    return folder


def call(folder, *words, config="config.yaml"):
    """Type a command in the folder of the study; return its exit code and what it prints."""
    done = subprocess.run(
        [warm_python.interpreter(), "-m", *words, "--configfile", config],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": str(ROOT / "src")},
        capture_output=True,
        text=True,
        check=False,
    )
    return done.returncode, done.stdout + done.stderr


def test_a_debugger_stops_in_the_script_and_the_outputs_are_those_of_the_job(folder):
    by_snakemake = (folder / ROUGHNESS).read_bytes()
    (folder / ROUGHNESS).write_text("old")
    script = ROOT / "scripts" / "measure_roughness.py"
    line = 1 + next(k for k, text in enumerate(script.read_text().splitlines()) if "s.input" in text)
    steps = (f"b {script}:{line}", "c", "p (s.place, s.params.patches['r_patch'], s.log[0])", "c", "q")
    code, said = call(
        folder,
        "pdb",
        *[word for step in steps for word in ("-c", step)],
        "-m",
        "sparsurf_study.debug",
        ROUGHNESS,
    )
    log = "results/own/logs/p/c1/measure_roughness.log"
    assert code == 0 and f"('p/c1', 3.0, '{log}')" in said
    assert (folder / ROUGHNESS).read_bytes() == by_snakemake
    assert (folder / log).read_text().startswith("USED ")
    code, said = call(folder, "sparsurf_study.debug", ROUGHNESS, config="other.yaml")
    assert code == 0 and (folder / ROUGHNESS).read_bytes() not in (by_snakemake, b"old")


@pytest.mark.parametrize(
    ("output", "words"),
    [
        (
            "results/own/p/c2x/grid.csv",
            "study writes results/own/p/c2x/grid.csv",
        ),
        (
            "results/own/p/.complete",
            "script writes",
        ),
        ("results/own/p/c1/minimal.csv", "made from results/own/p/c1/roughness.csv"),
        ("results/own/surfaces.csv", "results/own/q"),  # whose conformations are not chosen yet
    ],
)
def test_an_output_that_cannot_be_made_is_refused_in_a_sentence(folder, output, words):
    (folder / ROUGHNESS).unlink(missing_ok=True)
    code, said = call(folder, "sparsurf_study.debug", output)
    assert code == 1 and words in said and said.strip().count("\n") == 0


@pytest.mark.parametrize(
    ("output", "words"),
    [
        ("results/own/q/f7/roughness.csv", "q has no conformation f7; it has f07, f12"),
        ("results/own/surfaces.csv", "conformations in results/own/q/frames.csv"),
    ],
)
def test_conformations_are_those_of_the_table_of_frames(folder, output, words):
    """A table that would be written again, since other outputs of its job are missing."""
    table = folder / "results/own/q/frames.csv"
    table.parent.mkdir(exist_ok=True)
    table.write_text("conformation,frame\nf07,7\nf12,12\n")
    code, said = call(folder, "sparsurf_study.debug", output)
    table.unlink()
    assert code == 1 and words in said and said.strip().count("\n") == 0


def test_a_defect_is_a_sentence_that_names_the_log_with_its_traceback(folder, monkeypatch, capsys):
    """As where the tables of an earlier version lack a column."""

    def run_job(job):
        raise KeyError("decided_by")

    monkeypatch.chdir(folder)
    monkeypatch.setattr(sys, "argv", ["debug", ROUGHNESS, "--configfile", "config.yaml"])
    monkeypatch.setattr(debug, "run_job", run_job)
    monkeypatch.setattr(sys, "gettrace", lambda: None)  # where coverage is measured, too
    assert debug.main() == 1
    told = capsys.readouterr().err.strip()
    assert (
        "measure_roughness.py failed (KeyError: 'decided_by'). Its traceback is in results/own/logs/p/c1/"
        in told
    )
    assert "\n" not in told
