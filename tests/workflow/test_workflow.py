"""The workflow as a user runs it, on a small study: order, cores, kills, edits, mistakes."""

import errno
import hashlib
import os
import re
import shutil
import signal
import subprocess
import time
from pathlib import Path
from urllib.parse import unquote

import pandas as pd
import pytest

from conftest import ROOT, RULES, WORKFLOW
from small_study import ONE, SMALL, command, output, snakemake
from sparsurf import InputError
from sparsurf.workflow import code_digests, jobs

FIGURES = ("roughness", "number_of_dots", "d_over_grid", "rough_and_flat", "subsets")
TABLES = (
    "frames.csv",
    "*/roughness.csv",
    "*/grid.csv",
    "*/ranges.*",
    "*/best.*",
    "*/minimal.csv",
    "*/surface.*",
)
DRAWN = ("*/figures/*.*", "*/*.html")


def digests(folder, patterns=TABLES):
    """Digest of every table of the run."""
    protein = folder / "results" / "small" / "tdp43"
    files = sorted(path for pattern in patterns for path in protein.glob(pattern))
    return {str(path.relative_to(protein)): hashlib.sha256(path.read_bytes()).hexdigest() for path in files}


IMPORTING = """
configfile: "config.yaml"

module surfaces:
    snakefile: {snakefile!r}
    config: config

use rule * from surfaces as surfaces_*
"""


def of_one(folder, patterns=TABLES):
    """The same of the first conformation alone."""
    return {path: digest for path, digest in digests(folder, patterns).items() if path.startswith("f0000/")}


@pytest.fixture(scope="module")
def finished(tmp_path_factory):
    """The small study, run with two cores."""
    folder = tmp_path_factory.mktemp("two")
    process = snakemake(folder, SMALL)
    assert process.returncode == 0, output(process)
    return folder


def test_every_promised_file_is_there(finished):
    protein = finished / "results" / "small" / "tdp43"
    for name in ("frames.csv", "figures/frames.png", "figures/frames.svg"):
        assert (protein / name).stat().st_size > 0, name
    for conformation in ("f0000", "f0700"):
        for name in [
            "structure.pdb",
            "surface.npz",
            "surface.ply",
            "roughness.csv",
            "grid.csv",
            "distances.npz",
            "ranges.csv",
            "ranges.md",
            "best.json",
            "best.md",
            "minimal.csv",
            "minimal.ply",
        ] + [f"figures/{name}.{end}" for name in FIGURES for end in ("png", "svg")]:
            assert (protein / conformation / name).stat().st_size > 0, name
    assert not list(protein.rglob(".part-*"))
    bins = pd.read_csv(protein / "f0000" / "rough_and_flat.csv")
    drawn = bins[~bins["bin"].str.endswith("half")].groupby("around")["n"].sum()
    assert drawn.to_list() == [40 * SMALL["evaluation"]["test_dots"]] * 2


def test_a_second_run_has_nothing_to_do(finished):
    process = snakemake(finished, SMALL)
    assert process.returncode == 0
    assert "Nothing to be done" in output(process)


def test_a_file_that_was_deleted_is_made_again(finished):
    """What the run is for; not what was only needed on the way."""
    conformation = finished / "results" / "small" / "tdp43" / "f0700"
    frames = ((f"../{name}", "choose_frames") for name in ("structures", "explained.csv", "frames.csv"))
    for name, rule in (("figures/roughness.svg", "draw_figures"), ("floors.csv", "measure_floors"), *frames):
        path, away = conformation / name, finished / "away"
        path.rename(away)
        process = snakemake(finished, SMALL, "--dry-run")
        away.rename(path)
        assert process.returncode == 0 and re.search(rf"^{rule} +1$", output(process), re.M), output(process)
    path = conformation / "distances.npz"
    path.rename(away)
    process = snakemake(finished, SMALL, "--dry-run")
    away.rename(path)
    assert "Nothing to be done" in output(process)


def test_imported_by_another_workflow_on_one_core_it_gives_the_same_bytes(finished, tmp_path):
    """Scripts, schema, captions and the embedded example are found from the Snakefile, results lie where it is asked for."""
    folder = tmp_path / "one"
    folder.mkdir()
    snakefile = folder / "Snakefile"
    snakefile.write_text(IMPORTING.format(snakefile=str(ROOT / "Snakefile")))
    embedded = {
        key: f"data/tdp43/{SMALL['proteins']['tdp43'][key].split('/')[-1]}"
        for key in ("structure", "trajectory")
    }
    config = ONE | {"proteins": {"tdp43": SMALL["proteins"]["tdp43"] | embedded}}
    process = snakemake(folder, config, "--cores", "1", root=folder)
    assert process.returncode == 0, output(process)
    assert of_one(folder) == of_one(finished)
    assert len(of_one(finished)) > 6 and len(digests(finished)) > 12
    assert of_one(folder, DRAWN) == of_one(finished, DRAWN) and len(of_one(finished, DRAWN)) > 10
    process = snakemake(folder, config, "--report", str(folder / "report.html"), root=folder)
    assert process.returncode == 0, output(process)
    assert "how R_i is distributed over the dots" in (folder / "report.html").read_text()  # a caption


def test_imported_by_another_workflow_a_study_of_everything_is_planned(tmp_path):
    water = {"structure": SMALL["proteins"]["tdp43"]["structure"], "simulate": {"ns": 1}}
    everything = {key: {"run": True} for key in ("ensemble", "compare")}
    everything["proteins"] = SMALL["proteins"] | {"water": water}
    everything["pairs"] = {"two": {"proteins": ["tdp43", "water"]}}
    (tmp_path / "Snakefile").write_text(IMPORTING.format(snakefile=str(ROOT / "Snakefile")))
    process = snakemake(tmp_path, SMALL | everything, "--dry-run", root=tmp_path)
    assert process.returncode == 0, output(process)
    for rule in ("simulate_stage", "follow_frames", "summarise_comparison", "match_partners"):
        assert f"surfaces_{rule} " in output(process)


def test_a_run_killed_at_every_stage_continues_to_the_same_tables(finished, tmp_path):
    folder, protein = tmp_path / "killed", "results/small/tdp43"
    wished = [
        f"{protein}/f0000/{table}" for table in ("ranges.csv", "minimal.csv")
    ]  # and so all tables before them
    for stage in (
        "frames.csv",
        "*/surface.npz",
        "*/roughness.csv",
        "*/grid.csv",
        "*/ranges.csv",
        "*/minimal.csv",
    ):
        process = subprocess.Popen(
            command(folder, ONE, "--nolock", *wished),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            start_new_session=True,
        )
        deadline = time.monotonic() + 120
        while not list(folder.glob(f"{protein}/{stage}")) and time.monotonic() < deadline:
            if process.poll() is not None:
                break
            time.sleep(0.02)
        if process.poll() is None:
            os.killpg(process.pid, signal.SIGKILL)
        process.wait()
    again = snakemake(folder, ONE, "--nolock", *wished)
    assert again.returncode == 0, output(again)
    assert of_one(folder) == of_one(finished)


def test_the_first_page_leads_to_every_page_and_figure(finished):
    run = finished / "results" / "small"
    first = run / "index.html"
    led = {unquote(path) for path in re.findall(r'href="([^"]+)"', first.read_text())}
    found = {
        str(path.relative_to(run)) for end in ("html", "md", "png") for path in run.rglob(f"[!.]*.{end}")
    }
    assert found - {"index.html", "index.md"} <= led and len(found) > 20
    assert {path for path in led if not (run / path).is_file()} == {"report.html"}  # which is made from it
    assert first.read_text().index("The answer") < first.read_text().index("href=")


def test_the_report_is_made_offline(finished):
    process = snakemake(finished, SMALL, "--report", str(finished / "report.html"))
    assert process.returncode == 0, output(process)
    text = (finished / "report.html").read_text()
    assert "tdp43" in text and len(text) > 500_000
    part = (finished / "results" / "small" / ".front_page.html").read_text()
    led = re.findall(r"showResultInfo\('([^']+)'\)", part)
    assert len(led) > 15 and not [path for path in led if f'"{path}"' not in text]  # each is in the report


def test_editing_a_module_reruns_the_step_that_uses_it(finished, tmp_path):
    copy = copied(tmp_path)
    process = snakemake(finished, SMALL, "--dry-run", "--nolock", root=copy)
    assert "Nothing to be done" in output(process)
    edit(copy, "molecules/conformations")
    process = snakemake(finished, SMALL, "--dry-run", "--nolock", root=copy)
    assert re.search(r"params have changed since last execution:\s+choose_frames\n", output(process)), output(
        process
    )


@pytest.mark.parametrize(
    "module, scripts",
    [
        ("molecules/conformations", {"choose_frames.py"}),
        ("report/figures/layout", {"draw_frames.py", "draw_figures.py"}),
        ("surfaces/laying_dots", {"compile_kernels.py", "make_surface.py"}),
        ("study/tables", {"evaluate_grid.py", "tabulate_best.py", "reproduce_paper.py"}),
    ],
)
def test_a_module_counts_for_the_scripts_that_import_it(tmp_path, monkeypatch, module, scripts):
    copy = copied(tmp_path)
    monkeypatch.setattr(code_digests, "SCRIPTS", copy / "scripts")
    rules = re.findall(r'made_by\(\s*"(\w+\.py)"', WORKFLOW)
    before = {script: code_digests.digest.__wrapped__(script) for script in rules}
    edit(copy, module)
    changed = {script for script in rules if code_digests.digest.__wrapped__(script) != before[script]}
    assert scripts <= changed
    assert not changed & ({"choose_frames.py", "make_surface.py", "measure_roughness.py"} - scripts)


def copied(tmp_path):
    """A copy of what the rules are made of."""
    copy = tmp_path / "copy"
    for name in ("scripts", "profiles", "envs"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (*RULES, ROOT / "config.yaml"):
        shutil.copy(path, copy / path.name)
    return copy


def edit(copy, module):
    path = copy / "scripts" / "sparsurf" / f"{module}.py"
    path.write_text(path.read_text(encoding="utf-8") + "\n# a change\n", encoding="utf-8")


class Job:
    """What a script sees of Snakemake, for `workflow.job`."""

    def __init__(self, folder):
        self.rule, self.log, self.input, self.wildcards = "rule", [str(folder / "log")], [], {}
        self.output = {
            "one": str(folder / "a" / "one.csv"),
            "two": [str(folder / "a" / "x.png"), str(folder / "a" / "x.svg")],
        }


def test_outputs_appear_when_all_are_complete(tmp_path):
    with jobs.job(Job(tmp_path)) as output:
        Path(output["one"]).write_text("1")
        for path in output["two"]:
            Path(path).write_text("2")
        assert not (tmp_path / "a" / "one.csv").exists()
        print("said")
    assert sorted(path.name for path in (tmp_path / "a").iterdir()) == ["one.csv", "x.png", "x.svg"]
    assert re.fullmatch(r"said\nUSED [1-9]\d+ MB [\d.]+ s for 0.00 MB\n", (tmp_path / "log").read_text())


@pytest.mark.parametrize(
    "error, sentence",
    [
        (InputError("the file is wrong."), "ERROR the file is wrong."),
        (
            OSError(errno.ENOSPC, "No space left on device", "out.csv"),
            "ERROR out.csv: No space left on device; mend that",
        ),
        (KeyError("n_S"), "ERROR a defect of this program (KeyError: 'n_S'): please report it with "),
    ],
)
def test_a_failing_job_leaves_a_sentence_and_no_file(tmp_path, error, sentence):
    with pytest.raises(SystemExit), jobs.job(Job(tmp_path)) as output:
        Path(output["one"]).write_text("half")
        raise error
    assert list((tmp_path / "a").iterdir()) == []
    assert sentence in (tmp_path / "log").read_text()
