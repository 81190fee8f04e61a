"""The files of pairs: of two proteins of the run, of two files, of one complex."""

from types import SimpleNamespace

import pytest
from snakemake.iocontainers import Wildcards

from sparsurf.workflow import files_of_pairs
from sparsurf.workflow.files_of_pairs import FilesOfPairs

FILES = SimpleNamespace(run="results/r", surfaces=["ready"], first={"one": "f3", "ready": "c1"}.get)
PAIRS = {
    "both": {"proteins": ["one", "one"]},
    "half": {"proteins": ["one", "ready"]},
    "files": {"files": ["a.pdb", "b.pdb"]},
    "complex": {"complex": "ab.pdb", "chains": [["A"], ["B"]]},
}


def pairs(without=(), **listed):
    return FilesOfPairs({"pairs": listed, "without": dict.fromkeys(without, "why")}, FILES)


def of(pair):
    return Wildcards(fromdict={"pair": pair})


def test_structures_of_a_pair_are_two_files_or_one(monkeypatch):
    found = pairs(**PAIRS)
    assert found.alone == ["files", "complex"]
    assert found.given(of("files")) == {"first": "a.pdb", "second": "b.pdb"}
    assert found.given(of("complex")) == {"complex": "ab.pdb"}
    monkeypatch.setattr(files_of_pairs, "content", str.upper)
    assert found.contents(of("files")) == ["A.PDB", "B.PDB"] and found.contents(of("complex")) == ["AB.PDB"]


@pytest.mark.parametrize(
    ("pair", "found"),
    [
        (
            "half",
            {
                "surface_1": "results/r/one/f3/surface.npz",
                "structure_1": "results/r/one/f3/structure.pdb",
                "surface_2": "results/r/ready/c1/surface.npz",
            },
        ),
        (
            "files",
            {f"{what}_{side}": f"results/r/pairs/files/{what}_{side}.{end}"
             for side in (1, 2) for what, end in (("surface", "npz"), ("structure", "pdb"))},
        ),
    ],
)  # fmt: skip
def test_partners_are_first_conformations_or_made_for_the_pair(pair, found):
    own = pairs(**PAIRS)
    assert own.partners("surface", "structure")(of(pair)) == found
    surfaces = {key: path for key, path in found.items() if key.startswith("surface")}
    assert own.partners("surface")(of(pair)) == surfaces
    assert own.partners("structure")(of(pair)) == {key: found[key] for key in found.keys() - surfaces.keys()}


def test_pairs_are_told_apart_by_their_atoms_and_some_left_out():
    own = pairs(**PAIRS)
    assert own.names == [*PAIRS] and own.with_atoms == ["both", "files", "complex"]
    assert pairs(without=["pairs/half", "both"], **PAIRS).names == ["both", "files", "complex"]
