"""Proteins of a user's own, through the whole workflow: as the README says, beside a bad one, with mistakes."""

import os
import re

import numpy as np
import pandas as pd
import pytest
import yaml

from conftest import ROOT
from peptides import peptide, write
from small_study import SMALL, output, snakemake
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.formats.npz import read_npz


def test_your_own_protein_as_the_readme_says_beside_a_bad_one(tmp_path):
    """The config of the README, letter by letter, with a file where it says, in a folder with blanks and accents.

    A protein that cannot be read is named in a sentence and stops nothing else.
    """
    text = re.search(r"```yaml\n(# my_study\.yaml.*?)```", (ROOT / "README.md").read_text(), re.S).group(1)
    folder = tmp_path / "mein Ordner é"
    (folder / "path" / "to").mkdir(parents=True)
    atoms = (ROOT / "data" / "tdp43" / "topology.pdb").read_text().splitlines()
    part = [line for line in atoms if line.startswith("ATOM") and 209 <= int(line[22:26]) <= 222]
    (folder / "path" / "to" / "protein.pdb").write_text("\n".join([*part, "END"]))
    (folder / "path" / "to" / "bad.pdb").write_text("REMARK nothing here\n")
    os.chmod(folder / "path" / "to", 0o555)
    config = yaml.safe_load(text)
    config |= {"sampling": {"alpha": [1.0], "beta": [0.0, 0.4], "gamma": [0], "delta": [0, 6]}}  # in seconds
    config |= {"evaluation": {"test_dots": 20, "draws": 2}, "paper": "my_protein"}
    config["proteins"]["broken"] = {"structure": "path/to/bad.pdb"}
    process = snakemake(folder, config)
    assert process.returncode != 0
    assert "bad.pdb holds no atoms" in output(process)
    assert "Traceback (most" not in output(process)
    run = folder / "results" / "my_study"
    assert len((run / "my_protein" / "c1" / "grid.csv").read_text().splitlines()) == 5
    assert (run / "my_protein" / ".complete").is_file()
    verdict = (run / "verdict.html").read_text()
    assert re.search(r"\b4 combinations", verdict)
    cover = PreparedSurface(read_npz(run / "my_protein" / "c1" / "surface.npz")).cover
    assert f"A dot lies in {np.median(np.bincount(cover.dot)):g} patches (median)" in verdict
    del config["proteins"]["broken"]
    process = snakemake(folder, config)
    assert process.returncode == 0, output(process)
    assert (run / "my_protein" / "c1" / "minimal.csv").is_file() and (run / "index.html").is_file()


def test_a_folder_without_the_grid_has_a_row_for_each_and_the_reason_of_what_failed(tmp_path):
    """As `studies/minimal.yaml`: one conformation of each file, told apart from an ensemble of two models."""
    folder = tmp_path / "structures"
    folder.mkdir()
    model = peptide(("ALA", "LYS", "GLY"))
    write(folder / "one.pdb", model + "END\n")
    write(folder / "two.pdb", f"MODEL        1\n{model}ENDMDL\nMODEL        2\n{model}ENDMDL\nEND\n")
    write(folder / "bad.pdb", "REMARK nothing here\n")
    config = yaml.safe_load((ROOT / "studies" / "minimal.yaml").read_text()) | {
        "proteins": {"folder": "structures"}
    }
    config |= {"frames": {"use": "all"}, "evaluation": {"test_dots": 20}}
    process = snakemake(tmp_path, config)
    assert process.returncode != 0 and "bad.pdb holds no atoms" in output(process)
    config["without"] = {"bad": "bad.pdb holds no atoms."}
    process = snakemake(tmp_path, config)
    assert process.returncode == 0, output(process)
    run = tmp_path / "results" / "minimal"
    surfaces = pd.read_csv(run / "surfaces.csv", dtype={"protein": str})
    assert surfaces[["protein", "conformation"]].to_numpy().tolist() == [
        ["one", "f0"],
        ["two", "f0"],
        ["two", "f1"],
    ]
    for row in surfaces.itertuples():
        own = run / row.protein / row.conformation
        enough = (
            pd.read_csv(own / "enough.csv").set_index(["floor", "reading"]).loc[("fresh dots", "recovered")]
        )
        assert len(pd.read_csv(own / "minimal.csv")) == row.minimal_n_S == enough["n_S"]
        assert (own / "view.png").stat().st_size > 1000 and (own / "structure_roughness.pdb").is_file()
        assert not (own / "grid.csv").exists() and not (own / "figures").exists()
    assert (run / "failures.csv").read_text() == "place,reason\nbad,bad.pdb holds no atoms.\n"
    page = (run / "index.html").read_text()
    assert page.count('class="thumb"') == 3 and "bad.pdb holds no atoms" in page
    assert "Nothing to be done" in output(snakemake(tmp_path, config, "--dry-run"))


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
