"""The structures of the evidence: files with checksums, downloads, and the sets that each study takes."""

import gzip
import hashlib
import subprocess
import sys

import pytest

from conftest import ROOT
from small_study import served
from sparsurf.errors import InputError
from structures import (
    Structure,
    complexes,
    downloads,
    local_file,
    names_in_set,
    protein_entry,
    read_structures,
)

TABLE = "evidence/structures.csv"
QUICK_TABLE = ROOT / "evidence/quick/structures.csv"


def structure(tmp_path, content=b"ATOM", name="a.pdb"):
    (tmp_path / name).write_bytes(content)
    return Structure("a", name, "", hashlib.sha256(b"ATOM").hexdigest(), ("proteins",))


def test_a_local_structure_must_have_the_checksum_of_the_table(tmp_path):
    assert local_file(structure(tmp_path), tmp_path) == str(tmp_path / "a.pdb")
    compressed = structure(tmp_path, gzip.compress(b"ATOM"), "a.pdb.gz")
    assert local_file(compressed, tmp_path) == str(tmp_path / "a.pdb.gz")
    assert local_file(structure(tmp_path), None) is None
    with pytest.raises(InputError, match=r"a\.pdb differs"):
        local_file(structure(tmp_path, b"ATOMS"), tmp_path)


def test_a_structure_that_is_not_local_is_downloaded_with_its_checksum(tmp_path):
    structures = read_structures(TABLE)
    assert downloads(structures)["1A2K_r_b-matched.pdb"].name == "1A2K_r"
    entry = protein_entry(structures["1A2K_r"], str(tmp_path), model=1)
    assert set(entry) == {"url", "sha256", "model"} and entry["sha256"] == structures["1A2K_r"].sha256
    topology = str(ROOT / "data" / "tdp43" / "topology.pdb")
    assert protein_entry(structures["tdp43_c1"], str(tmp_path)) == {"structure": topology}


def test_a_structure_is_fetched_from_its_url(tmp_path):
    (tmp_path / "served").mkdir()
    content = (ROOT / "evidence/quick/piece_1.pdb").read_bytes()
    (tmp_path / "served" / "far.pdb").write_bytes(content)
    with served(tmp_path / "served") as url:
        row = f"far,far.pdb,{url}/far.pdb,{hashlib.sha256(content).hexdigest()},"
        (tmp_path / "structures.csv").write_text(QUICK_TABLE.read_text() + row + "\n")
        call = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "evidence/Snakefile"]
        call += ["--directory", tmp_path, "--configfile", ROOT / "evidence/quick.yaml", "--cores", "1"]
        call += [
            "--config",
            f"structures={tmp_path}/structures.csv",
            "results=out",
            "--",
            "out/structures/far.pdb",
        ]
        run = subprocess.run(call, capture_output=True, text=True, check=False)
    assert run.returncode == 0, run.stdout + run.stderr
    assert (tmp_path / "out/structures/far.pdb").read_bytes() == content


@pytest.mark.parametrize("table", [TABLE, "evidence/quick/structures.csv"])
def test_every_study_has_its_structures(table):
    structures = read_structures(table)
    sets = {
        name: names_in_set(structures, name) for name in ["proteins", "descriptors", "coverage", "opponents"]
    }
    assert all(sets.values())
    assert set(sets["coverage"]) <= set(sets["proteins"])
    if table == TABLE:
        assert len(sets["proteins"]) == 65 and len(sets["descriptors"]) >= 5 and len(sets["coverage"]) >= 5
        pairs = complexes(structures)
        assert len(pairs) == 46 and {name for pair in pairs.values() for name in pair} <= structures.keys()
