"""The workflow as a user runs it: one core, another workflow, kills, bad proteins, mistakes."""

import html
import os
import re
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
import yaml

import warm_python
from conftest import ROOT
from peptides import peptide, write
from small_study import (
    EMBEDDED,
    SEQUENCE,
    SETTINGS,
    command,
    copy_of,
    output,
    planned_jobs,
    planned_rules,
    snakemake,
    write_study,
)
from sparsurf_study import catalogue

pytestmark = pytest.mark.slow

IMPORTING = """
configfile: "config.yaml"

module study:
    snakefile: {snakefile!r}
    config: config

use rule * from study as study_*
"""
FIRST = "results/small/moving/f0000"


def study_of_one(folder, protein):
    """Write the input files of the small study; return its config with the first conformation of one protein alone."""
    config = write_study(folder)
    kept = {key: config[key] for key in (*SETTINGS, "fields")}
    return kept | {"frames": {"selection": [0]}, "proteins": {protein: config["proteins"][protein]}}


def files_of(folder, ends):
    """Bytes of the files of a conformation with some ends, by path."""
    paths = sorted(path for path in folder.rglob("*") if path.name.endswith(ends))
    return {str(path.relative_to(folder)): path.read_bytes() for path in paths}


def test_on_one_core_and_imported_by_another_workflow_it_gives_the_same_bytes(study, tmp_path):
    """Scripts and captions are found from the Snakefile, results lie where the other workflow runs."""
    folder, place = tmp_path / "one", "results/small/still/f0"
    config = study_of_one(folder, "still")
    (folder / "Snakefile").write_text(IMPORTING.format(snakefile=str(ROOT / "Snakefile")))
    process = snakemake(folder, config, "--cores", "1", root=folder)
    assert process.returncode == 0, output(process)
    files = files_of(folder / place, ("csv", "npz", "json", "ply", "pdb", "dms", "png", "svg", "md"))
    assert len(files) > 25 and files == {path: (study / place / path).read_bytes() for path in files}
    warnings, of_study = (pd.read_csv(run / "results/small/warnings.csv") for run in (folder, study))
    of_study = of_study[of_study["protein"] == "still"]
    of_study = of_study[~of_study["job"].str.contains("compare_samplers|follow_frames")]
    assert set(warnings["sentence"]) == set(of_study["sentence"]) != set()
    process = snakemake(folder, config, "--report", "report.html", root=folder)
    assert process.returncode == 0, output(process)
    caption = catalogue.outputs()["<protein>/<conformation>/figures/roughness.png"].caption
    assert caption and caption in (folder / "report.html").read_text(encoding="utf-8")


def test_a_study_with_simulations_is_planned_by_another_workflow(tmp_path):
    proteins = {"tdp43": EMBEDDED, "water": {"structure": EMBEDDED["structure"], "simulate": {"ns": 1}}}
    config = SETTINGS | {"proteins": proteins, "pairs": {"two": {"proteins": ["tdp43", "water"]}}}
    config |= {key: {"run": True} for key in ("ensemble", "compare")}
    (tmp_path / "Snakefile").write_text(IMPORTING.format(snakefile=str(ROOT / "workflow" / "Snakefile")))
    process = snakemake(tmp_path, config, "--dry-run", root=tmp_path)
    assert process.returncode == 0, output(process)
    for rule in ("prepare_system", "simulate_stage", "choose_frames", "follow_frames", "judge_simulation"):
        assert f"study_{rule} " in output(process)
    assert not (tmp_path / "results").exists()


def test_a_config_of_one_section_and_no_proteins_changes_the_default_study(tmp_path):
    (tmp_path / "config.yaml").write_text("of: another workflow\n")
    jobs = planned_jobs(tmp_path, {"run": "few", "minimal": {"percent": 10}})
    (chosen,) = (job for job in jobs if job["rule"] == "choose_frames")
    assert chosen["wildcards"] == ["few", "tdp43"]


def test_another_workflow_keeps_its_first_rule_as_the_default(tmp_path):
    own = 'rule own:\n    output: "own.txt"\n    shell: "touch {output}"\n'
    (tmp_path / "Snakefile").write_text(own + IMPORTING.format(snakefile=str(ROOT / "Snakefile")))
    process = snakemake(tmp_path, SETTINGS | {"proteins": {"tdp43": EMBEDDED}}, root=tmp_path)
    assert process.returncode == 0, output(process)
    assert (tmp_path / "own.txt").exists() and not (tmp_path / "results").exists()


def test_one_study_at_a_time_in_a_folder(tmp_path):
    """Whether `make run` or Snakemake itself starts it; a plan may be made meanwhile."""
    config, target = study_of_one(tmp_path, "moving"), f"{FIRST}/surface.npz"
    hold = (
        "from sparsurf_study.workflow.folders import hold_folder; print(hold_folder(), flush=True); input()"
    )
    ends = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
    with subprocess.Popen([sys.executable, "-c", hold], cwd=tmp_path, **ends) as other:
        assert other.stdout.readline() == "True\n"
        for nolock in ([], ["--nolock"]):  # make run gives this option
            process = snakemake(tmp_path, config, target, *nolock)
            assert process.returncode == 1 and not (tmp_path / target).exists()
            assert "\nAnother study runs in this folder; wait for it to end.\n" in process.stderr
            assert "Traceback" not in output(process)
        assert snakemake(tmp_path, config, target, "--dry-run").returncode == 0
        other.communicate("\n")
    process = snakemake(tmp_path, config, target)
    assert process.returncode == 0 and (tmp_path / target).exists(), output(process)


def test_the_library_of_the_checkout_wins_over_an_installed_one(tmp_path):
    for package in ("sparsurf", "sparsurf_study"):
        shutil.copytree(
            ROOT / "src" / package, tmp_path / package, ignore=shutil.ignore_patterns("__pycache__")
        )
    (tmp_path / "sparsurf_study" / "batches" / "assignment.py").write_text("")  # an older one
    (tmp_path / "sparsurf" / "settings.py").write_text("")
    call = command(tmp_path / "w", SETTINGS | {"proteins": {"tdp43": EMBEDDED}}, "--dry-run")
    imported = "import sys, runpy; sys.path.insert(0, sys.argv.pop(1))"
    imported += "; import sparsurf_study.batches.assignment, sparsurf.settings"
    start = f"{imported}; runpy.run_module('snakemake', alter_sys=True)"
    process = subprocess.run(
        [call[0], "-c", start, tmp_path, *call[3:]], capture_output=True, text=True, check=False
    )
    assert process.returncode == 0, output(process)


def test_a_protein_is_sampled_or_not_by_its_own_key_or_by_that_of_all(tmp_path):
    folder = tmp_path / "mixed"
    small = write_study(folder)
    proteins = {name: small["proteins"][name] for name in ("ready", "still")}
    config = SETTINGS | {"proteins": proteins, "frames": {}, "fields": small["fields"]}
    none = {name: protein | {"sampling": False} for name, protein in proteins.items()}
    planned = [planned_rules(folder, config | keys) for keys in ({"sampling": False}, {"proteins": none})]
    assert planned[0] == planned[1] and "evaluate_grid" not in planned[0]
    still = {"still": proteins["still"] | {"sampling": True}}
    only_one = {"sampling": config["sampling"] | {"run": False}, "proteins": proteins | still}
    of_all = {"proteins": none | {"still": proteins["still"]}}
    planned = [planned_rules(folder, config | keys) for keys in (only_one, of_all)]
    assert planned[0] == planned[1] >= {"evaluate_grid", "draw_figures", "summarise_best", "draw_view"}


def test_the_comparison_with_the_paper_is_left_out_with_its_protein(tmp_path):
    config = write_study(folder := tmp_path / "own")
    rules = planned_rules(folder, config | {"exclude": {"ready": "by hand", "pairs/half": "by hand"}})
    assert "close_run" in rules and not {"read_surface", "reproduce_paper"} & rules


@pytest.mark.parametrize(("table", "reader"), [("grid.csv", "ranges.csv"), ("roughness.csv", "floors.csv")])
def test_a_truncated_table_is_refused_by_the_rule_that_reads_it(study, tmp_path, table, reader):
    folder = copy_of(study, tmp_path / "own")
    config = yaml.safe_load((study / "config.yaml").read_text())
    content = (folder / FIRST / table).read_bytes()
    (folder / FIRST / table).unlink()
    (folder / FIRST / table).write_bytes(b"".join(content.splitlines(keepends=True)[:-3]))
    process = snakemake(folder, config, f"{FIRST}/{reader}")
    assert process.returncode != 0
    log = {"ranges.csv": "tabulate_best.log", "floors.csv": "measure_floors.log"}[reader]
    assert table in (folder / "results/small/logs/moving/f0000" / log).read_text().split("ERROR ")[1]
    assert "A defect of this program" not in output(process)


def linked_checkout(root):
    """Make a checkout whose studies lie in a folder of its own; return the folder."""
    root.mkdir()
    for name in ("src", "rules", "envs", "data", "profiles", "Snakefile", "config.yaml", "studies", ".cache"):
        (root / name).symlink_to(ROOT / name)
    shutil.copytree(ROOT / "scripts", root / "scripts", ignore=shutil.ignore_patterns("__pycache__"))
    return root


@pytest.fixture(scope="module")
def checkout(tmp_path_factory):
    """A checkout with a study of three files of structures, of which one cannot be read; what `make run` printed twice.

    The file that cannot be read has models, so that its conformations are known to no other job.
    """
    root = linked_checkout(tmp_path_factory.mktemp("mein Ordner é") / "checkout")
    (root / "my" / "structures").mkdir(parents=True)
    model = peptide(SEQUENCE, origin=(0, 0, 0))
    moved = peptide(SEQUENCE, origin=(0, 1, 0))
    write(root / "my/structures/still.pdb", model + "END\n")
    write(
        root / "my/structures/two.pdb", f"MODEL        1\n{model}ENDMDL\nMODEL        2\n{moved}ENDMDL\nEND\n"
    )
    write(root / "my/structures/bad.pdb", "MODEL        1\nENDMDL\nMODEL        2\nENDMDL\n")
    (root / "my" / "structures").chmod(0o555)
    config = SETTINGS | {"run": "mine", "sampling": False, "proteins": {"folder": "my/structures"}}
    config |= {"frames": {"selection": "all"}, "pairs": {"good": {"proteins": ["still", "two"]}}}
    config["pairs"]["lost"] = {"proteins": ["still", "bad"]}
    (root / "mine.yaml").write_text(yaml.safe_dump(config))
    processes = [make_run(root) for _ in range(2)]
    return root, *processes


def make_run(root, *options):
    """Run a study as `make run` does."""
    command = [
        warm_python.interpreter(),
        "-m",
        "sparsurf_study",
        "run",
        "mine.yaml",
        "--cores",
        "2",
        *options,
    ]
    environment = os.environ | {"PYTHONPATH": str(root / "src")}
    return subprocess.run(command, cwd=root, env=environment, capture_output=True, text=True, check=False)


def test_a_protein_that_fails_does_not_stop_the_others(checkout):
    root, process, again = checkout
    run = root / "results" / "mine"
    assert process.returncode == again.returncode == 1
    assert "bad.pdb holds" in process.stderr and "Traceback" not in output(process)
    assert "- bad/choose_frames:" in process.stderr and "Look at   results/mine/index.html" in process.stdout
    surfaces = pd.read_csv(run / "surfaces.csv", dtype={"protein": str})
    places = [["still", "f0"], ["two", "f0"], ["two", "f1"]]
    assert surfaces[["protein", "conformation"]].to_numpy().tolist() == places
    for row in surfaces.itertuples():
        folder = run / row.protein / row.conformation
        recovered = pd.read_csv(folder / "recovered.csv").iloc[0]
        assert len(pd.read_csv(folder / "minimal.csv")) == row.minimal_n_S
        assert row.recovered_mean == recovered["mean"] == pytest.approx(0.02, rel=0.2)
        assert row.minimal_n_S_percent_low == recovered["n_S_percent_low"]
        assert (folder / "view.png").stat().st_size > 1000 and not (folder / "grid.csv").exists()
    failures = (run / "failures.csv").read_text().splitlines()
    assert re.fullmatch(r"bad,choose_frames: .*bad\.pdb holds no atoms.*", failures[1])
    assert failures[2:] == ["pairs/lost,bad could not be finished."]
    assert (run / "pairs/good/agreement.csv").exists() and (run / "pairs/pairs.csv").exists()
    page = (run / "index.html").read_text()
    assert page.count('class="thumb"') == 3 and "bad.pdb holds" in page
    assert "Computed with numpy" in page


def test_warnings_are_in_a_table_and_on_the_first_page_and_their_number_is_on_the_terminal(checkout):
    root, process, _ = checkout
    table = pd.read_csv(root / "results/mine/warnings.csv")
    assert {"still", "two"} <= set(table["protein"])
    page = html.unescape((root / "results/mine/index.html").read_text())
    for sentence in table["sentence"]:
        assert sentence.partition(": ")[2] in page  # once for all files that have it
    assert f"Warnings  {len(table)} in results/mine/warnings.csv" in process.stdout


def test_without_the_grid_the_same_rules_give_the_same_bytes(checkout, study):
    """`moving` and `still` have a field more in the small study."""
    ours, theirs = checkout[0] / "results/mine/still/f0", study / "results/small/still/f0"
    for name in ("surface.npz", "components.csv", "roughness.csv", "floors.csv", "recovered.csv"):
        assert (ours / name).read_bytes() == (theirs / name).read_bytes(), name
    dots = [pd.read_csv(folder / "minimal.csv")["dot"] for folder in (ours, theirs)]
    assert np.array_equal(*dots)


def test_what_does_not_need_what_failed_has_all_of_its_files(checkout, study):
    """Those of the small study but for the grid, which the config does not ask for."""
    ours, theirs = checkout[0] / "results/mine", study / "results/small"
    names = {
        folder: {str(path.relative_to(folder)) for path in folder.rglob("[!.]*") if path.is_file()}
        for folder in (ours / "still/f0", theirs / "still/f0", ours / "pairs/good", theirs / "pairs/both")
    }
    still, of_small, good, both = names.values()
    of_grid = "best.json compare.csv distances.npz grid.csv ranges.csv rough_and_flat.csv"
    of_grid += " pictures/minimal.png pictures/sampled.png winners.npz"
    assert good == both and still <= of_small
    assert {name for name in of_small - still if not name.startswith("figures/")} == {*of_grid.split()}
    assert {"figures/roughness.png", "figures/roughness.svg"} <= still


def test_the_next_run_does_only_what_failed(checkout):
    """And what needs it, which the run was closed without."""
    root, _, again = checkout
    places = [line for line in again.stdout.splitlines() if "of two" in line or "of still" in line]
    assert not places, places
    planned = make_run(root, "--dry-run")
    assert planned.returncode == 0 and "bad" in planned.stdout
    (root / "my/structures").chmod(0o755)
    (root / "my/structures/bad.pdb").unlink()
    config = yaml.safe_load((root / "mine.yaml").read_text())
    config["pairs"].pop("lost")
    (root / "mine.yaml").write_text(yaml.safe_dump(config))
    planned = make_run(root, "--dry-run")
    assert "surfaces side" in planned.stdout and "First page" in planned.stdout


def test_the_config_of_the_readme_is_a_study(tmp_path):
    """Letter by letter, with a file where it says."""
    text = re.search(r"```yaml\n(# my_study\.yaml.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    (tmp_path / "path" / "to").mkdir(parents=True)
    write(tmp_path / "path" / "to" / "protein.pdb", peptide(SEQUENCE) + "END\n")
    process = snakemake(tmp_path, yaml.safe_load(text), "--dry-run")
    assert process.returncode == 0 and "my_protein" in output(process), output(process)
