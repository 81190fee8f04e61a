"""The crate of a run: it lists each file, and tells which were changed later."""

import json
import os
import shutil
import subprocess
import sys
from dataclasses import astuple

import check_run
import sparsurf
from conftest import ROOT
from sparsurf_study.report import closing
from sparsurf_study.workflow.checksums import Checksums
from sparsurf_study.workflow.ledger import Record
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
    for n in (50, 51):
        many = {"proteins": {str(k): {"structure": f"{k}.pdb"} for k in range(n)}, "pairs": {}}
        _, listed, number, _ = astuple(origin_of(many, []))
        assert (len(listed), number) == ({50: 50, 51: 0}[n], n)


def test_check_names_files_that_were_changed_with_their_time_kept_or_are_missing(
    tmp_path, monkeypatch, capsys
):
    monkeypatch.setattr(check_run, "RESULTS", tmp_path / "results")
    folder, config = tmp_path / "results" / "mine", tmp_path / "mine.yaml"
    config.write_text("run: mine\n")
    assert check_run.main(config) == 2 and "There is no " in capsys.readouterr().err
    config.write_text("seed: 1\n")
    assert check_run.name_of_run(config) == "mine"
    config.write_text("run: mine\n")
    folder.mkdir(parents=True)
    files = [folder / name for name in ("a b.csv", "grid.csv", "roughness.csv", "view.html")]
    for path in files:
        path.write_text("x\n1\n2\n")
    closing.write_crate(list(map(str, files)), str(folder / closing.CRATE), [])
    assert check_run.main(config) == 0
    lines = capsys.readouterr().out.splitlines()
    assert "no records of its jobs" in lines[0] and lines[1].startswith("4 of 4 files in results/mine/")
    path = tmp_path / "in.pdb"
    path.write_text("1")
    results = ["results/mine/roughness.csv", "results/mine/grid.csv"]
    made = {name: Checksums().of(tmp_path / name) for name in results}
    of_first, of_second = {"in.pdb": Checksums().of(path)}, {results[0]: made[results[0]]}
    for rule, read, name in (("second", of_second, results[1]), ("first", of_first, results[0])):
        Record(rule, {name: made[name]}, read).write(folder / ".ledger" / f"{rule}.json")
    assert check_run.main(config) == 0
    assert capsys.readouterr().out.startswith(
        "The 2 jobs of results/mine/ agree with their inputs, code and results.\n"
    )
    path.write_text("2")  # the files are as the run wrote them, but follow from another input
    assert check_run.main(config) == 1 and "in.pdb is not the file" in capsys.readouterr().out
    path.write_text("1")
    for path, text in ((files[1], "x\n1\n3\n"), (files[2], "x\n1")):
        times = path.stat().st_atime_ns, path.stat().st_mtime_ns
        path.write_text(text)
        os.utime(path, ns=times)
    files[3].unlink()
    assert check_run.main(config) == 1
    first, *lines = capsys.readouterr().out.splitlines()
    assert first.startswith("The first link that differs: roughness.csv was changed after first had made it.")
    assert [line.partition(": `")[0] for line in lines[:3]] == [
        "results/mine/grid.csv differs from what the run wrote",
        "results/mine/roughness.csv differs from what the run wrote",
        "results/mine/view.html is missing",
    ]
    assert len(lines) == 4
    assert lines[2].endswith("is missing: `make run` writes it again.") and "elete" not in lines[2]
    (folder / closing.CRATE).write_text("{")
    assert check_run.main(config) == 2 and "is damaged" in capsys.readouterr().err
    for name in ("../../x", "", 3, "a/b"):
        config.write_text(f"run: {json.dumps(name)}\n")
        assert check_run.main(config) == 2
        assert f"run is {name!r}; it must be a name of letters" in capsys.readouterr().err


def test_check_writes_into_a_pipe_that_closes(tmp_path):
    """`make check | head -1`: more lines than a pipe holds, of which one is read."""
    shutil.copytree(ROOT / "scripts", tmp_path / "scripts")
    folder = tmp_path / "results" / "mine"
    folder.mkdir(parents=True)
    graph = [{"@id": f"{k}.csv", "@type": "File", "sha256": "0"} for k in range(20_000)]
    (folder / closing.CRATE).write_text(json.dumps({"@graph": graph}))
    (tmp_path / "mine.yaml").write_text("run: mine\n")
    command = f"{sys.executable} scripts/check_run.py mine.yaml | head -1"
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    done = subprocess.run(
        command, shell=True, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False
    )
    assert done.stdout.startswith("results/mine/ has no records") and not done.stderr
