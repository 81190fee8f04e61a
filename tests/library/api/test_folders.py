"""One table of a folder or of many files: rows of single files under names by path, whole after any stop."""

import bz2
import gzip
import signal

import numpy as np
import pandas as pd
import pytest

import kills
import sparsurf
from peptides import peptide, write
from sparsurf.api import folders
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.molecules.listing import structures_in

SEQUENCES = [("ALA", "SER", "LYS"), ("VAL", "GLY"), ("ALA", "ALA", "SER", "LEU")]
COMMANDS = {"areas": [], "residues": ["--fields", "hydropathy"], "points": ["-n", "20"]}


def ended(name, *words, code=0):
    assert command.main([name, *map(str, words)]) == code


@pytest.fixture
def predictions(tmp_path):
    """Folders as AlphaFold 3, Boltz and ColabFold write them: files of one name, of several depths, among others."""
    place = tmp_path / "predictions"
    names = (
        "job1/seed-1_sample-0/model",
        "job1/seed-1_sample-1/model",
        "boltz/predictions/x/x_model_0",
        "top_rank_001",
    )
    for k, name in enumerate(names):
        (place / name).parent.mkdir(parents=True, exist_ok=True)
        write(place / f"{name}.pdb", peptide(SEQUENCES[k % 3], "AB"[k % 2]) + "END\n")
        (place / name).with_suffix(".json").write_text("{}")
    (place / ".git").mkdir()
    (place / ".git/old.pdb").write_text("nothing")
    (place / "job1/again").symlink_to(place)
    return place, sorted(names)


@pytest.mark.parametrize("name", COMMANDS)
@pytest.mark.parametrize("jobs", [1, 2])
def test_rows_are_those_of_single_files_under_the_names_of_their_paths(
    predictions, name, jobs, tmp_path, capfd
):
    place, names = predictions
    ending = "parquet" if name == "points" else "csv"
    read = pd.read_parquet if name == "points" else pd.read_csv
    out = tmp_path / f"all.{ending}"
    ended(name, place, *COMMANDS[name], "--jobs", jobs, "-o", out)
    table = read(out)
    assert [*dict.fromkeys(table["name"])] == names and table.columns[0] == "name"
    assert f"4 structures in 4 folders, {len(table)} rows\n" in capfd.readouterr().err
    for each, rows in table.groupby("name"):
        ended(name, place / f"{each}.pdb", *COMMANDS[name], "-o", tmp_path / f"one.{ending}")
        alone = read(tmp_path / f"one.{ending}").drop(columns="name", errors="ignore")
        pd.testing.assert_frame_equal(
            rows.drop(columns="name").reset_index(drop=True), alone, check_dtype=False
        )


def test_names_of_a_list_are_the_shortest_ends_that_differ(predictions, tmp_path, caplog):
    place, names = predictions
    files = [place / f"{name}.pdb" for name in names]
    expected = ["x_model_0", "seed-1_sample-0/model", "seed-1_sample-1/model", "top_rank_001"]
    assert [*structures_in(files)] == expected == [*structures_in([place / "boltz", *files[1:]])]
    assert [*structures_in(place)] == names and not caplog.text
    (place / "top_rank_001.cif.gz").write_text("nothing")
    assert [*structures_in(place)][-2:] == ["top_rank_001.cif.gz", "top_rank_001.pdb"]
    assert "suffix alone" in caplog.text


def test_assemblies_of_the_pdb_are_read_and_structures_of_another_name_are_told(
    predictions, tmp_path, caplog
):
    text = (predictions[0] / f"{predictions[1][0]}.pdb").read_text()
    (place := tmp_path / "mine").mkdir()
    for name in ("1abc.pdb1", "1abc.pdb12", "old.brk", "1abc.pdb1.gz", "model.txt", "note.md"):
        content = "a note" if name == "note.md" else text
        packed = gzip.compress(content.encode()) if name.endswith(".gz") else content.encode()
        (place / name).write_bytes(packed)
    assert {*structures_in(place).values()} == {
        place / name for name in ("1abc.pdb1", "1abc.pdb12", "old.brk", "1abc.pdb1.gz")
    }
    assert "left out 1 file" in caplog.text and "model.txt" in caplog.text and "note.md" not in caplog.text
    assert "1abc.pdb1" in caplog.text and "old.brk and another" not in caplog.text  # differ in their suffixes


def test_options_hold_for_each_structure(predictions, tmp_path):
    place, names = predictions
    ended("areas", place, "--chains", "A", "--of", "chains", "-o", tmp_path / "a.csv")  # two have none
    table = pd.read_csv(tmp_path / "a.csv")
    assert table["chain"].eq("A").all() and table["name"].tolist() == [names[1], names[0]][::-1]
    one = sparsurf.areas(sparsurf.read_molecule(place / f"{names[0]}.pdb", chains="A")).chains
    assert table["accessible"][0] == pytest.approx(one["accessible"][0])


def test_what_is_broken_is_named_and_the_rest_is_in_the_table(predictions, tmp_path, capfd):
    place, names = predictions
    whole = (place / f"{names[0]}.pdb").read_bytes()
    (place / "two.pdb.bz2").write_bytes(bz2.compress(whole))
    (place / "packed.pdb.zst").write_bytes(b"\x28\xb5\x2f\xfd" + whole)
    (place / "job1/empty.pdb").write_text("")
    (place / "job1/link.pdb").symlink_to(place / "nothing")
    ended("areas", place, "-o", tmp_path / "all.csv")
    said = capfd.readouterr().err
    assert "; left out: job1/empty, job1/link, packed.pdb\n" in said and ": 5 structures in " in said
    assert "3 of 8 structures are left out: job1/empty: " in said and "compressed with zstd" in said
    assert [*dict.fromkeys(pd.read_csv(tmp_path / "all.csv")["name"])] == [*names, "two"]


def test_bad_input_is_one_sentence(predictions, tmp_path, capfd):
    place, names = predictions
    (tmp_path / "empty/below").mkdir(parents=True)
    (tmp_path / "broken").mkdir()
    (tmp_path / "broken/a.pdb").write_text("nothing")
    write(tmp_path / "one.xyzr", "0 0 0 1.5\n3 0 0 1.5\n")
    file = place / f"{names[-1]}.pdb"
    for words, sentence in (
        (["areas", tmp_path / "empty"], "empty holds no structure at any depth (.pdb, .ent,"),
        (["areas", tmp_path / "broken"], "all structures failed; the warnings give the reasons"),
        (["areas", file, tmp_path / "no.pdb"], "there is no file "),
        (["areas", place, "--trajectory", file], "--trajectory has no meaning for"),
        (["residues", place, "--column", "area"], "--column has no meaning for"),
        (["residues", place, "--fields", "apbs.dx"], "apbs.dx is a map"),
        (["residues", place, "--fields", "hydropaty"], "did you mean 'hydropathy'"),
        (["areas", place, "--of", "pairs", "--residues", "3"], "has no rows of residues"),
    ):
        ended(*words, "-o", tmp_path / "x.csv", code=1)
        said = capfd.readouterr().err
        assert sentence in said and "Traceback" not in said and not (tmp_path / "x.csv").exists()
    ended("areas", place, "-o", tmp_path / "x.npz", code=1)
    assert ".parquet, .csv" in capfd.readouterr().err
    ended("areas", file, tmp_path / "one.xyzr", "--of", "atoms", "-o", tmp_path / "x.csv")
    assert "structures before" in capfd.readouterr().err
    with pytest.raises(InputError, match="another file"):
        structures_in([file, place / "job1" / ".." / file.name])
    assert not [*tmp_path.glob(".x*")]


@pytest.mark.parametrize("name", COMMANDS)
def test_a_stopped_table_continues_to_the_same_bytes(name, tmp_path, monkeypatch, capfd):
    """What is finished is not computed again, unless its file or the arguments differ; files of equal content share a part."""
    place = tmp_path / "place"
    place.mkdir()
    for k, each in enumerate("abde"):
        text = peptide(SEQUENCES[min(k, 2)])
        text = text.replace(text.splitlines(True)[4], "") if each == "a" else text  # its CB
        write(place / f"{each}.pdb", f"{text}END\n")
    (place / "c.pdb").write_text("nothing")
    taken, outcome = [], folders.ResultsOfFolder._outcome

    def noted(self, path):
        taken.append(path.stem)
        if path.stem == "d" and len(taken) in (4, 8):
            raise KeyboardInterrupt
        return outcome(self, path)

    monkeypatch.setattr(folders.ResultsOfFolder, "_outcome", noted)
    out, own = tmp_path / "x.csv", tmp_path / "radii.csv"
    words = [place, *COMMANDS[name], "--radii", own, "-o"]
    for radius in (1.8, 1.7):  # the second call takes nothing of the first
        own.write_text(f"element,radius\nC,{radius}\nN,1.6\nO,1.5\n")
        ended(name, *words, out, code=command.INTERRUPTED)
    assert taken == 2 * [*"abcd"] and not out.exists()
    (store,) = tmp_path.glob(".x.csv.*")
    with (place / "b.pdb").open("a") as file:
        file.write("REMARK another file\n")
    capfd.readouterr()
    ended(name, *words, out)
    said = capfd.readouterr().err
    assert taken[8:] == [*"bcde"] and not store.exists()
    assert ": parts of a stopped call followed from other input" in said
    assert "4 structures in 1 folder" in said and ", 1 finished before; left out: c\n" in said
    ended(name, *words, tmp_path / "whole.csv")
    assert (tmp_path / "whole.csv").read_bytes() == out.read_bytes()
    warned = [line for line in said.splitlines() if "heavy atoms" in line]  # also of what was finished
    assert len(warned) == 1 and warned[0] in capfd.readouterr().err.splitlines()


def test_a_table_killed_at_half_continues_with_the_other_half(tmp_path):
    place = tmp_path / "place"
    place.mkdir()
    for k in range(12):
        write(place / f"{k:02}.pdb", peptide(SEQUENCES[k % 3], first=k + 1) + "END\n")
    call = ["-m", "sparsurf", "areas", "place", "-o", "areas.csv"]
    kill = kills.Kill(r"\.npz$", "job", "rename", 7)
    assert kills.run(call, tmp_path, kill).returncode == -signal.SIGKILL
    (store,) = tmp_path.glob(".areas.csv.*")
    assert len([*store.glob("*.npz")]) == 6 and not (tmp_path / "areas.csv").exists()
    assert ", 6 finished before\n" in kills.run(call, tmp_path).stderr
    again = (tmp_path / "areas.csv").read_bytes()
    assert kills.run(call, tmp_path).returncode == 0 and (tmp_path / "areas.csv").read_bytes() == again
    assert [path.name for path in tmp_path.iterdir() if path.name.startswith(".areas")] == []


def test_standard_output_keeps_no_parts(predictions, capfdbinary, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    ended("areas", "predictions", "-o", "-")
    assert capfdbinary.readouterr().out.startswith(b"name,chain,residue,")
    assert {path.name for path in tmp_path.iterdir()} == {"predictions"}


def test_a_field_within_a_function_is_shared_by_processes(predictions):
    place, names = predictions

    def lowest(molecule, points):
        return points.min(axis=1)

    found = {few.name: few.fields["lowest"] for few in sparsurf.points_of(place, 20, fields=lowest, jobs=2)}
    assert [*found] == names
    alone = sparsurf.points(place / f"{names[0]}.pdb", 20, fields=lowest)
    assert np.array_equal(found[names[0]], alone.fields["lowest"])
