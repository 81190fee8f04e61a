"""What the evidence is planned by: structures with checksums, complexes, and marks that follow code and settings."""

import gzip
import hashlib
from pathlib import Path

import mdtraj
import pytest

import plan
import read_structures
from conftest import ROOT
from sparsurf import InputError
from sparsurf.workflow import code_digests, definitions

CONFIG = {"tables": "tables", "figures": "figures"}


def structure(tmp_path, content=b"ATOM", name="a.pdb", url=""):
    (tmp_path / name).write_bytes(content)
    return plan.Structure("a", name, url, hashlib.sha256(b"ATOM").hexdigest(), ("recover",))


def test_a_structure_of_the_folder_is_what_was_measured(tmp_path):
    assert structure(tmp_path).local(tmp_path) == tmp_path / "a.pdb"
    assert structure(tmp_path, gzip.compress(b"ATOM"), "a.pdb.gz").local(tmp_path) == tmp_path / "a.pdb.gz"
    assert structure(tmp_path).local(None) is None
    with pytest.raises(InputError, match=r"a\.pdb differs"):
        structure(tmp_path, b"ATOMS").local(tmp_path)


def test_what_the_folder_lacks_is_fetched_with_its_checksum(tmp_path):
    source = plan.Source("evidence/structures.csv", str(tmp_path), "fetched")
    assert source.path("1A2K_r") == "fetched/1A2K_r_b-matched.pdb"
    assert source.downloads["1A2K_r_b-matched.pdb"].name == "1A2K_r"
    entry = source.protein("1A2K_r", model=1)
    assert set(entry) == {"url", "sha256", "model"} and entry["sha256"] == source.known["1A2K_r"].sha256
    assert source.protein("tdp43_c1") == {"structure": str(ROOT / "data" / "tdp43" / "topology.pdb")}


@pytest.mark.parametrize("table", ["evidence/structures.csv", "evidence/quick/structures.csv"])
def test_every_chain_has_its_structures(table):
    sets = plan.Source(table, None, "").sets
    kinds = (
        "recover",
        "exponents",
        "proteins",
        "recovered",
        "whole",
        "varied",
        "hydrogens",
        "descriptors",
        "coverage",
    )
    assert all(sets[kind] for kind in kinds)
    assert set(sets["coverage"]) | set(sets["whole"]) | set(sets["varied"]) <= set(sets["proteins"])
    if table == "evidence/structures.csv":
        assert len(sets["proteins"]) == 65 and len(sets["descriptors"]) >= 5 and len(sets["coverage"]) >= 5


def test_complexes_stand_in_their_order_and_unbound_forms_behind_their_bound_ones():
    found = list(plan.pairs(plan.structures("evidence/structures.csv")).items())
    assert found[0] == ("1a1u", ("1a1u_A", "1a1u_C")) and len(found) == 1 + 46 + 2 * 6
    assert found[-2:] == [("2OOB", ("2OOB_r", "2OOB_l")), ("2OOB_u", ("2OOB_r_u", "2OOB_l_u"))]


def test_a_mark_follows_the_settings_and_what_it_draws():
    chains = plan.Chains(CONFIG)
    first = chains.add("a", {"n": 1}, ["tabulate_power.py"], tables=["power"])
    assert first.tables == {"power": "tables/power.csv"} and first.mark.startswith("tables/made/a-")
    other = plan.Chains(CONFIG).add("a", {"n": 2}, ["tabulate_power.py"])
    assert other.mark != first.mark
    drawn = [
        plan.Chains(CONFIG).add("b", {}, ["tabulate_power.py"], of=[one]).mark
        for one in (first, other, first)
    ]
    assert drawn[0] == drawn[2] != drawn[1]


def test_a_chain_without_its_mark_is_old_and_old_marks_are_forgotten(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    chains = plan.Chains(CONFIG)
    chain = chains.add("a", {"n": 1}, ["tabulate_power.py"], tables=["power"])
    for path in ("tables/power.csv", "tables/made/a-0123"):
        Path(path).parent.mkdir(parents=True, exist_ok=True)
        Path(path).touch()
    assert chains.old() == ["a"]
    Path(chain.mark).touch()
    assert chains.old() == []
    chains.forget_old()
    assert [path.name for path in Path("tables/made").iterdir()] == [Path(chain.mark).name]


def test_what_a_chain_writes_into_the_library_makes_it_no_older():
    scripts = "score_sites.py", "calibrate_sites.py"
    written = {"weights": "src/sparsurf/sites/weights.npz", "unrelated": "src/sparsurf/sites/null.csv"}
    assert {"weights.npz", "null.csv"} <= {
        path.name for path in definitions.reached(ROOT / "evidence" / scripts[1])
    }
    assert plan.Chains(CONFIG | written).code(*scripts) != plan.Chains(CONFIG).code(*scripts)
    other = {key: f"elsewhere/{Path(path).name}" for key, path in written.items()}
    assert plan.Chains(CONFIG | other).code(*scripts) == plan.Chains(CONFIG | written).code(*scripts)


def test_code_that_reads_ages_the_other_chains_only_once_it_reads_something_else(tmp_path, monkeypatch):
    reached, codes = definitions.reached, {}
    for edited in (
        "nothing",
        "/molecules/pdb.py",
        "/surfaces/formats/ply.py",
        "/surfaces/dot_placement.py",
        "/summary.html.j2",
    ):
        monkeypatch.setattr(
            definitions,
            "reached",
            lambda script, but, edited=edited: {
                path: ["edited"] if str(path).endswith(edited) else own
                for path, own in reached(script, but).items()
            },
        )
        code_digests.digest.cache_clear()
        chains = plan.Chains(CONFIG, tmp_path / "none.csv")
        reads = chains.add("structures", {}, ["read_structures.py"], reads=True)
        study = chains.add("study", {}, ["../scripts/summarise_run.py"])
        drawn = chains.add("drawn", {}, ["../scripts/summarise_run.py"], figures=["a"])
        codes[edited] = chains.code("measure_power.py"), reads.code, study.code, drawn.code
    code_digests.digest.cache_clear()
    code, code_of_reading, study, drawn = codes.pop("nothing")
    assert codes["/molecules/pdb.py"][0] == codes["/surfaces/formats/ply.py"][0] == code
    assert codes["/surfaces/dot_placement.py"][0] != code
    assert codes["/molecules/pdb.py"][1] != code_of_reading
    assert codes["/summary.html.j2"][2] == study and codes["/summary.html.j2"][3] != drawn
    assert study != drawn
    assert all((ROOT / "src" / "sparsurf" / path[1:]).is_file() for path in plan.READING)


@pytest.mark.parametrize(("rows", "revisions"), [("a,1,00,0\n", 0), ("a,1,00,0\nb,1,00,2\nc,1,00,1\n", 3)])
def test_what_was_read_as_something_else_counts(tmp_path, monkeypatch, rows, revisions):
    monkeypatch.setattr(definitions, "reached", lambda script, but: {})
    table = tmp_path / "read.csv"
    table.write_text("name,atoms,sha256,revision\n" + rows)
    code_digests.digest.cache_clear()
    assert plan.Chains(CONFIG, table).code("measure_power.py").endswith(f"-{revisions}")
    code_digests.digest.cache_clear()


def test_a_structure_that_is_read_as_something_else_gets_a_revision(tmp_path):
    lines = (ROOT / "data" / "tdp43" / "topology.pdb").read_text().splitlines(keepends=True)[:40]
    paths = [tmp_path / name for name in ("a.pdb", "b.pdb")]
    for path in paths:
        path.write_text("".join(lines) + "END\n")
    mdtraj.load(paths[0]).save_xtc(tmp_path / "t.xtc")
    inputs = {"structures": paths, "topology": paths[0], "trajectory": tmp_path / "t.xtc"}
    inputs["chooses"] = ROOT / "scripts" / "choose_frames.py"
    table = tmp_path / "read.csv"

    def read():
        read_structures.main(inputs, {"structures_read": table}, ["a", "b"], ["b"])
        rows = [line.split(",") for line in table.read_text().splitlines()[1:]]
        return {name: (atoms, sha, int(revision)) for name, atoms, sha, revision in rows}

    first = read()
    assert first["a"][1] != first["b"][1] and [own[2] for own in first.values()] == 4 * [0]
    moved = next(k for k, line in enumerate(lines) if line.startswith("ATOM"))
    lines[moved] = lines[moved][:30] + f"{float(lines[moved][30:38]) + 0.001:8.3f}" + lines[moved][38:]
    paths[1].write_text("".join(lines) + "END\n")
    second = read()
    assert second["a"] == first["a"] and second["b"][1] != first["b"][1] and second["b"][2] == 1
    atoms = sum(line.startswith("ATOM") for line in lines)  # of b, and of the one frame
    assert second["conformations"] == (str(2 * atoms), second["conformations"][1], 1)
    assert read() == second
