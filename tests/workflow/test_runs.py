"""The workflow as a user runs it, on a small study: order, cores, kills, edits, mistakes."""

import hashlib
import os
import re
import shutil
import signal
import subprocess
import time
from urllib.parse import unquote

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from small_study import ONE, SMALL, command, output, snakemake
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.read_surface import read_surface

FIGURES = (
    "enough",
    "roughness",
    "number_of_dots",
    "number_of_dots_panels",
    "d_over_grid",
    "rough_and_flat",
    "subsets",
)
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
            "ranges.html",
            "minimal.csv",
            "minimal.ply",
        ] + [f"figures/{name}.{end}" for name in FIGURES for end in ("png", "svg")]:
            assert (protein / conformation / name).stat().st_size > 0, name
    assert "All surfaces: small<" in (protein.parent / "summary.html").read_text()
    bins = pd.read_csv(protein / "f0000" / "rough_and_flat.csv")
    drawn = bins[~bins["bin"].str.endswith("half")].groupby("around")["n"].sum()
    assert drawn.to_list() == [10 * SMALL["evaluation"]["test_dots"]] * 2


def test_a_field_is_in_every_result_and_changes_no_other(finished):
    folder = finished / "results" / "small" / "tdp43" / "f0000"
    table = pd.read_csv(folder / "fields.csv")
    assert table["field"].eq("hydropathy").all() and table["subset"].to_list() == [
        "minimal",
        *["farthest"] * 4,
    ]
    assert table["n_S_percent"].round(1).to_list()[1:] == [2.5, 5, 10, 20] and table["r"].iloc[-1] > 0.999
    minimal, residues = pd.read_csv(folder / "minimal.csv"), pd.read_csv(folder / "residues.csv")
    of_dots = read_npz(folder / "surface.npz"), np.load(folder / "fields.npz")["hydropathy"]
    np.testing.assert_allclose(minimal["hydropathy"], of_dots[1][minimal["dot"]], atol=1e-4)
    owner = read_molecule(folder / "structure.pdb", selection="all", whole=False).residue_index[
        of_dots[0].atom
    ]
    assert residues["mean_hydropathy"][3] == pytest.approx(of_dots[1][owner == 3].mean())
    for name in ("surface.ply", "minimal.ply"):
        np.testing.assert_allclose(read_surface(folder / name).fields["hydropathy"][:5], [
            *(of_dots[1][:5] if name == "surface.ply" else minimal["hydropathy"][:5])
        ], rtol=1e-4)  # fmt: skip
    assert "hydropathy" in (finished / "results" / "small" / "index.html").read_text()
    planned = output(snakemake(finished, SMALL | {"fields": ["charge"]}, "--dry-run", "--quiet", "host"))
    again = {*re.findall(r"^(\w+) +\d+$", planned, re.M)} - {"total", "all"}
    assert again == {
        *("take_minimal", "tabulate_residues", "draw_view", "draw_figures"),
        *("summarise_run", "collect_warnings", "complete_protein", "write_front_page"),
    }


def test_a_second_run_has_nothing_to_do(finished):
    process = snakemake(finished, SMALL)
    assert process.returncode == 0
    assert "Nothing to be done" in output(process)


def test_a_file_that_was_deleted_is_made_again(finished):
    conformation = finished / "results" / "small" / "tdp43" / "f0700"
    frames = ((f"../{name}", "choose_frames") for name in ("structures", "explained.csv", "frames.csv"))
    for name, rule in (
        ("figures/roughness.svg", "draw_figures"),
        ("floors.csv", "measure_floors"),
        ("distances.npz", "evaluate_grid"),
        *frames,
    ):
        path, away = conformation / name, finished / "away"
        path.rename(away)
        process = snakemake(finished, SMALL, "--dry-run")
        away.rename(path)
        assert process.returncode == 0 and re.search(rf"^{rule} +1$", output(process), re.M), output(process)


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
    caption = (ROOT / "src" / "sparsurf" / "report" / "captions" / "roughness.rst").read_text(
        encoding="utf-8"
    )
    assert caption.strip() in (folder / "report.html").read_text(encoding="utf-8")


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
    requested = [
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
            command(folder, ONE, "--nolock", *requested),
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
    again = snakemake(folder, ONE, "--nolock", *requested)
    assert again.returncode == 0, output(again)
    assert of_one(folder) == of_one(finished)


def test_the_first_page_leads_to_every_page_and_figure(finished):
    run = finished / "results" / "small"
    first = run / "index.html"
    led = {unquote(path) for path in re.findall(r'href="([^"]+)"', first.read_text())}
    found = {str(path.relative_to(run)) for end in ("html", "png") for path in run.rglob(f"[!.]*.{end}")}
    elsewhere = ("summary.png", "view.png", "number_of_dots_panels.png")  # on other pages and in the report
    shown = {path for path in found if path.endswith(elsewhere)}
    assert found - {"index.html"} - shown <= led and len(found) > 12
    assert not [path for path in led if path != "#words" and not (run / path).is_file()]


def test_the_report_is_made_offline(finished):
    process = snakemake(finished, SMALL, "--report", str(finished / "report.html"))
    assert process.returncode == 0, output(process)
    text = (finished / "report.html").read_text()
    assert "tdp43" in text and len(text) > 500_000
    part = (finished / "results" / "small" / ".front_page.html").read_text()
    led = re.findall(r"showResultInfo\('([^']+)'\)", part)
    assert len(led) >= 2 * (len(FIGURES) + 1) + 1 and not [
        path for path in led if f'"{path}"' not in text
    ]  # each is in the report


def test_editing_a_module_reruns_the_step_that_uses_it(finished, tmp_path):
    copy = copied(tmp_path)
    process = snakemake(finished, SMALL, "--dry-run", "--nolock", root=copy)
    assert "Nothing to be done" in output(process)
    edit(copy, "molecules/conformations")
    process = snakemake(finished, SMALL, "--dry-run", "--nolock", root=copy)
    assert re.search(r"params have changed since last execution:\s+choose_frames\n", output(process)), output(
        process
    )


def copied(tmp_path):
    """A copy of what the rules are made of."""
    copy = tmp_path / "copy"
    for name in ("scripts", "src", "rules", "profiles", "envs"):
        shutil.copytree(ROOT / name, copy / name, ignore=shutil.ignore_patterns("__pycache__"))
    for path in (ROOT / "Snakefile", ROOT / "config.yaml"):
        shutil.copy(path, copy / path.name)
    return copy


def edit(copy, module):
    path = copy / "src" / "sparsurf" / f"{module}.py"
    path.write_text(path.read_text(encoding="utf-8") + "\nprint()\n", encoding="utf-8")
