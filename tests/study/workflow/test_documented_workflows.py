"""The examples of docs/cluster.md, run as they are written there."""

import json
import os
import re
import shutil
import subprocess
import sys

import pandas as pd
import pytest

import kills
import warm_python
from conftest import ROOT
from peptides import peptide, write
from small_study import output
from sparsurf_study import manifest

pytestmark = pytest.mark.slow

TEXT = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
# In their order: the whole study, with a prefix, one of its files, and with a rule replaced
NAMES = ("whole", "prefix", "roughness", "overridden")
WORKFLOWS = dict(zip(NAMES, re.findall(r"```python\n(configfile.*?)```", TEXT, re.S), strict=True))
STUDY = """\
run: my_study
sampling: false
proteins: {my_protein: {structure: protein.pdb}}
minimal: {percent: 20}
"""
SUBMIT = '#!/bin/sh\necho $$ >> submitted; nohup sh "$1" > job.out 2>&1 &\necho $!\n'


def checkout(folder):
    """Make a checkout that is set up: its Python is that of the tests."""
    kills.checkout(folder)
    for name in ("Makefile", "pyproject.toml"):
        (folder / name).symlink_to(ROOT / name)
    python = folder / ".venv" / "bin" / "python"
    python.parent.mkdir(parents=True)
    python.write_text(f'#!/bin/sh\nexec "{sys.executable}" "$@"\n')
    python.chmod(0o755)
    return folder


@pytest.fixture
def folder(tmp_path):
    """A folder with a structure and the config of a study of it."""
    write(tmp_path / "protein.pdb", peptide(("ALA", "LYS", "SER", "VAL")) + "END\n")
    (tmp_path / "my_study.yaml").write_text(STUDY)
    return tmp_path


def run(folder, *options):
    """Run Snakemake in a folder as the documentation says; return what lies in its results, by path."""
    call = [warm_python.interpreter(), "-m", "snakemake", "--cores", "2", *options]
    process = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    assert process.returncode == 0, output(process)
    paths = [path for path in folder.rglob("results/**/*") if path.is_file()]
    return {path.relative_to(folder).as_posix(): path for path in paths}


def write_workflow(folder, name):
    """Write a workflow of the documentation into a folder."""
    text = WORKFLOWS[name].replace("path/to/sparsurf", str(ROOT))
    (folder / "Snakefile").write_text(text)


@pytest.fixture(scope="module")
def whole(tmp_path_factory):
    """Files of a study that another workflow imports."""
    folder = tmp_path_factory.mktemp("whole")
    write(folder / "protein.pdb", peptide(("ALA", "LYS", "SER", "VAL")) + "END\n")
    (folder / "my_study.yaml").write_text(STUDY)
    write_workflow(folder, "whole")
    return {name: path.read_bytes() for name, path in run(folder).items() if "/logs/" not in name}


def test_another_workflow_imports_the_study(whole):
    assert "results/my_study/index.html" in whole and "results/my_study/my_protein/c1/minimal.csv" in whole


def test_a_prefix_is_put_before_results_and_not_before_input_files(folder, whole):
    write_workflow(folder, "prefix")
    files = run(folder)
    assert {name.partition("/")[0] for name in files} == {"surfaces"}
    differing = ("index.html", "ro-crate-metadata.json", "warnings.csv")
    same = {name for name in whole if not name.endswith((*differing, manifest.NAME))}
    assert len(same) > 15
    for name in same:
        assert files[f"surfaces/{name}"].read_bytes() == whole[name], name
    warnings = files["surfaces/results/my_study/warnings.csv"].read_text()  # which name the file
    assert warnings.replace(f"{folder}/", "").encode() == whole["results/my_study/warnings.csv"]
    run_folder = folder / "surfaces" / "results" / "my_study"
    listed = re.findall(r"  (.+)$", whole[f"results/my_study/{manifest.NAME}"].decode(), re.M)
    assert [*manifest.read_sums(run_folder)] == listed and not [*manifest.differing(run_folder)]
    crate = json.loads(files["surfaces/results/my_study/ro-crate-metadata.json"].read_text())
    assert "my_protein/c1/minimal.csv" in {part["@id"] for part in crate["@graph"]}


def test_one_file_is_computed_with_what_it_follows_from(folder, whole):
    write_workflow(folder, "roughness")
    files = run(folder)
    own = "results/my_study/my_protein/c1/roughness.csv"
    assert files[own].read_bytes() == whole[own] and not any("minimal" in name for name in files)
    values = pd.read_csv(folder / "roughest.csv", header=None, names=["R"])["R"]
    assert sorted(map(float, values[values != "roughness"])) == sorted(pd.read_csv(files[own])["roughness"])


def test_a_rule_is_overridden(folder):
    write_workflow(folder, "overridden")
    files = run(folder)
    assert set(pd.read_csv(files["results/my_study/my_protein/c1/roughness.csv"])["roughness"]) == {0.5}
    assert "results/my_study/my_protein/c1/view.html" in files
    times = pd.read_csv(folder / "benchmarks" / "my_study" / "my_protein" / "c1.tsv", sep="\t")
    assert times["s"][0] > 0


def test_snakemake_alone_plans_what_make_run_plans(tmp_path):
    """In a checkout that is set up, without a config: the default study."""
    place = checkout(tmp_path / "checkout")
    python = place / ".venv" / "bin" / "python"
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    command = re.search(r"`\.venv/bin/snakemake (-c2) --configfile my_study\.yaml`", readme)[1].split()
    calls = (
        [python, "-m", "snakemake", *command, "-n"],
        [python, "-m", "sparsurf_study", "run", "config.yaml", *command, "-n"],
    )
    counts = []
    for call in calls:
        process = subprocess.run(call, cwd=place, capture_output=True, text=True, check=False)
        assert process.returncode == 0, output(process)
        counts.append(re.findall(r"^(\w+) +(\d+)$", process.stdout, re.M))
    assert counts[0] == counts[1] and ("choose_frames", "1") in counts[0]


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_a_profile_of_the_user_sends_the_jobs_to_its_executor(folder, whole):
    """A script that starts each job in the background plays the cluster."""
    pytest.importorskip("snakemake_executor_plugin_cluster_generic", reason="the plugin is not installed")
    place = checkout(folder / "checkout")
    profile = re.search(r"```yaml\n# my_profile/config.yaml\n(.*?)```", TEXT, re.S)[1]
    (place / "my_profile").mkdir()
    (place / "my_profile" / "config.yaml").write_text(profile.replace("latency-wait: 60", "latency-wait: 5"))
    (place / "submit.sh").write_text(SUBMIT)
    (place / "submit.sh").chmod(0o755)
    for name in ("my_study.yaml", "protein.pdb"):
        shutil.copy(folder / name, place)
    command = re.search(r"^make run .* PROFILE=.*$", TEXT, re.M)[0].split()
    done = subprocess.run(
        [command[0], "-o", "setup", *command[1:]], cwd=place, capture_output=True, text=True, check=False,
        env=os.environ | {"SLURM_CONF": "/dev/null"},
    )  # fmt: skip
    assert done.returncode == 0, output(done)
    assert "Look at   results/my_study/index.html" in done.stdout
    assert (
        len((place / "submitted").read_text().split()) >= 4
    )  # surface, roughness, floors and the subset at least
    for name in ("roughness.csv", "minimal.csv", "residues.csv"):
        path = f"results/my_study/my_protein/c1/{name}"
        assert (place / path).read_bytes() == whole[path]


@pytest.mark.skipif(shutil.which("make") is None, reason="make is not installed")
def test_a_profile_that_is_not_there_is_one_sentence(folder):
    place = checkout(folder / "checkout")
    call = ["make", "-o", "setup", "run", "PROFILE=nowhere"]
    outside = {name: value for name, value in os.environ.items() if not name.startswith("MAKE")}
    done = subprocess.run(call, cwd=place, env=outside, capture_output=True, text=True, check=False)
    assert done.returncode == 2 and not done.stdout, output(done)
    assert "nowhere is not a folder with the config.yaml of a Snakemake profile.\n" in done.stderr
    call = ["make", "run", "CLUSTER=slurm", "PROFILE=x"]
    both = subprocess.run(call, cwd=place, capture_output=True, text=True, check=False)
    assert both.returncode == 2 and "give only one of the two" in both.stderr
