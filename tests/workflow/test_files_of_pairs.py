"""The files of pairs: of two proteins of the run, of two files, of one complex."""

from types import SimpleNamespace

import pytest
from snakemake.iocontainers import Wildcards

from sparsurf.workflow import files_of_pairs
from sparsurf.workflow.files_of_pairs import FilesOfPairs

FILES = SimpleNamespace(
    run="results/r", surfaces=["ready"], conformations={"one": ["f3", "f9"], "ready": ["c1"]}.get
)
PAIRS = {
    "both": {"proteins": ["one", "one"]},
    "half": {"proteins": ["one", "ready"]},
    "files": {"files": ["a.pdb", "b.pdb"]},
    "complex": {"complex": "ab.pdb", "chains": [["A"], ["B"]]},
}


def pairs(thinning=False, **listed):
    return FilesOfPairs({"pairs": listed, "complementarity": {"thinning": {"run": thinning}}}, FILES)


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


def test_a_pair_ends_with_its_pages_and_with_residues_where_it_has_atoms():
    own = pairs(thinning=True, **PAIRS)
    names = ["pair.md", "book.png", "view_1.html", "view_2.html", "thinning.png"]
    assert own.of_pair(of("half")) == [f"results/r/pairs/half/{name}" for name in names]
    assert own.of_pair(of("both")) == [f"results/r/pairs/both/{name}" for name in [*names, "residues.csv"]]
    assert own.of_pair(of("files"))[-1] == "results/r/pairs/files/residues.csv"
    assert "thinning.png" not in " ".join(pairs(**PAIRS).of_pair(of("both")))


def test_pairs_end_with_a_summary_and_none_with_nothing():
    own = pairs(one=PAIRS["files"], two=PAIRS["complex"])
    folder = "results/r/pairs"
    marks = [f"{folder}/one/.complete", f"{folder}/two/.complete"]
    files = own.of_pair(of("one")) + own.of_pair(of("two"))
    assert len(files) == 10 and own.of_pairs() == [*marks, *files, f"{folder}/pairs.md"]
    pages = ("book.png", "view_1.html", "view_2.html")
    assert own.pictures == [f"{folder}/{name}/{page}" for name in ("one", "two") for page in pages]
    assert own.texts == [f"{folder}/{name}/pair.md" for name in ("one", "two")]
    assert own.summary == [f"{folder}/pairs.md"]
    assert pairs().of_pairs() == pairs().pictures == pairs().texts == pairs().summary == []
