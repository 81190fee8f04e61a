"""The crate of a run: it lists each file, and tells which were changed later."""

import json
import os
import shutil
import subprocess
from dataclasses import astuple

import sparsurf
from sparsurf_study import check_run, manifest
from sparsurf_study.report import closing
from sparsurf_study.workflow.origin import origin_of


def test_the_crate_describes_files_and_run(study, tmp_path):
    run = study / "results" / "small"
    by = {entry["@id"]: entry for entry in json.loads((run / closing.CRATE).read_text())["@graph"]}
    assert by["moving/f0000/minimal.csv"]["description"].startswith("the minimal subset")
    assert by["moving/f0000/minimal.csv"]["encodingFormat"] == "text/csv"
    assert by["ro-crate-metadata.json"]["about"] == {"@id": "./"} and by["./"]["@type"] == "Dataset"
    assert by["#sparsurf"]["version"] == sparsurf.__version__
    assert by["#sparsurf"]["license"]["@id"].endswith("/MIT") and "/MIT" not in by["./"]["license"]
    (tmp_path / "a b").mkdir()
    shutil.copy(run / "surfaces.csv", tmp_path / "a b" / "ä.csv")
    closing.write_crate([str(tmp_path / "a b")], str(tmp_path / "c.json"), ["So many."])
    by = {entry["@id"]: entry for entry in json.loads((tmp_path / "c.json").read_text())["@graph"]}
    assert "a%20b/%C3%A4.csv" in by  # of a folder each file, as an address
    assert by["./"]["abstract"] == ["So many."]


def test_a_run_is_told_by_its_command_and_input_files(tmp_path, monkeypatch):
    """Each file once, from the working folder where it lies there; of more than 50 files, their number."""
    monkeypatch.chdir(tmp_path)
    proteins = {"a": {"structure": "a.pdb", "trajectory": str(tmp_path / "in" / "a.xtc"), "residues": "1-9"}}
    proteins |= {
        "b": {"surface": "/data/b.npz"},
        "c": {"structure": "a.pdb", "table": "c.csv"},
        "d": {"pdb": "1ubi"},
    }
    pairs = {"p": {"files": ["a.pdb", "p.pdb"]}, "q": {"complex": "q.pdb", "chains": [["A"], ["B"]]}}
    paths = ["a.pdb", "in/a.xtc", "/data/b.npz", "c.csv", "p.pdb", "q.pdb"]
    config = {"proteins": proteins, "pairs": pairs | {"r": {"proteins": ["a", "b"]}}}
    for files, command in (
        ([tmp_path / "mine.yaml", "compare.yaml"], "make run CONFIG=mine.yaml"),
        (["config.yaml"], "make run"),
        ([], "make run"),
        (["/data/config.yaml"], "make run CONFIG=/data/config.yaml"),
    ):
        assert astuple(origin_of(config, files))[:3] == (command, paths, 6)
    deployed = origin_of(config, ["config/config.yaml"], is_clone=False)
    assert deployed.command == "snakemake --cores all --configfile config/config.yaml"
    for n in (50, 51):
        many = {"proteins": {str(k): {"structure": f"{k}.pdb"} for k in range(n)}, "pairs": {}}
        _, listed, number, _ = astuple(origin_of(many, []))
        assert (len(listed), number) == ({50: 50, 51: 0}[n], n)


def test_check_names_files_that_were_changed_with_their_time_kept_or_are_missing(
    tmp_path, monkeypatch, capsys
):
    (tmp_path / "Snakefile").touch()
    monkeypatch.chdir(tmp_path)
    folder, config = tmp_path / "results" / "mine", tmp_path / "mine.yaml"
    config.write_text("seed: 1\n")  # its file names the run
    assert check_run.main(config) == 2 and "There is no " in capsys.readouterr().err
    folder.mkdir(parents=True)
    files = [folder / name for name in ("a b.csv", "grid.csv", "roughness.csv", "view.html")]
    for path in files:
        path.write_text("x\n1\n2\n")
    manifest.write_sums(folder, manifest.sums_of(folder, files))
    assert check_run.main(config) == 0
    assert capsys.readouterr().out.startswith("4 of 4")
    subprocess.run(["sha256sum", "--check", "--quiet", manifest.NAME], cwd=folder, check=True)
    for path, text in ((files[1], "x\n1\n3\n"), (files[2], "x\n1")):
        times = path.stat().st_atime_ns, path.stat().st_mtime_ns
        path.write_text(text)
        os.utime(path, ns=times)
    files[3].unlink()
    assert check_run.main(config) == 1
    assert [line.partition(": ")[0] for line in capsys.readouterr().out.splitlines()] == [
        "results/mine/grid.csv is changed",
        "results/mine/roughness.csv is changed",
        "results/mine/view.html is missing",
        "1 of 4 files in results/mine/ are as the run wrote them.",
    ]
