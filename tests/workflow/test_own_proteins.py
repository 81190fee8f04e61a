"""Proteins of a user's own, through the whole workflow: as the README says, with mistakes, beside a bad one."""

import os
import re
import shutil

import pytest
import yaml

from conftest import ROOT
from small_study import SMALL, output, snakemake


def test_your_own_protein_as_the_readme_says(shared, tmp_path):
    """The config of the README, letter by letter, with a file where it says, in a folder with blanks and accents."""
    text = re.search(r"```yaml\n(# my_study\.yaml.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    folder = tmp_path / "mein Ordner é"
    (folder / "path" / "to").mkdir(parents=True)
    shutil.copy(
        shared / "data" / "structures" / "A6PA6_13res_nochain.pdb", folder / "path" / "to" / "protein.pdb"
    )
    os.chmod(folder / "path" / "to", 0o555)
    fewer = {"evaluation": {"test_dots": 20, "draws": 2}}  # the whole grid, in seconds
    process = snakemake(folder, yaml.safe_load(text) | fewer)
    assert process.returncode == 0, output(process)
    protein = folder / "results" / "my_study" / "my_protein"
    assert len((protein / "c1" / "grid.csv").read_text().splitlines()) == 1297
    assert (protein / "c1" / "minimal.csv").is_file()


@pytest.mark.parametrize(
    "change, sentences",
    [
        (
            {"sampling": {"alpha": [2.0]}, "evaluaton": {}},
            [
                "sampling.alpha.0 is 2.0, but must be 1 or less",
                "unknown key 'evaluaton' in the config; did you mean 'evaluation'?",
            ],
        ),
        ({"proteins": {"a": {"structure": "missing.pdb"}}}, ["there is no file 'missing.pdb'"]),
    ],
)
def test_a_mistake_in_the_config_is_a_sentence(tmp_path, change, sentences):
    process = snakemake(tmp_path / "x", SMALL | change)
    assert process.returncode != 0
    assert all(sentence in output(process) for sentence in sentences)
    assert "Traceback" not in output(process)


def test_a_bad_protein_does_not_stop_the_others(tmp_path):
    bad = tmp_path / "bad.pdb"
    bad.write_text("REMARK nothing here\n")
    good = {key: SMALL["proteins"]["tdp43"][key] for key in ("structure", "residues")}
    config = {key: value for key, value in SMALL.items() if key != "frames"} | {
        "proteins": {"tdp43": good, "broken": {"structure": str(bad)}},
        "paper": "tdp43",
        "sampling": {"alpha": [1.0], "beta": [0], "gamma": [0], "delta": [0, 6]},
    }
    process = snakemake(tmp_path / "x", config)
    assert process.returncode != 0
    assert "bad.pdb holds no atoms" in output(process)
    assert "Traceback (most" not in output(process)
    assert list((tmp_path / "x" / "results" / "small" / "tdp43").glob("*/ranges.csv"))
    verdict = (tmp_path / "x" / "results" / "small" / "verdict.md").read_text()
    assert verdict.startswith("# The paper's claims") and "2 combinations" in verdict
