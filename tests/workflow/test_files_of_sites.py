"""Sites of a study: what the config may say of them, the files that they come from, and a study that seeks one."""

import base64
import re
import zlib
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from snakemake.iocontainers import Wildcards

import sparsurf
from peptides import peptide, write
from small_study import output, snakemake
from sparsurf import InputError
from sparsurf.dot_fields.smoothing import gaussian_mean
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.config import check
from sparsurf.workflow.files_of_sites import FilesOfSites

SEQUENCE = ("ALA", "LEU", "LYS", "GLY", "SER", "VAL")
SITE = {"query": "one", "residues": "2-4"}
SCORES = (0.0, 3.0, 3.0, 7.0, 1.0, 2.0)  # of residues 1 to 6
TABLE = ["rank", "target", "chain", "residue", "residue_name", "x", "y", "z", "score", "p", "places"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Two peptides, the second turned."""
    folder = tmp_path_factory.mktemp("sites")
    write(folder / "one.pdb", peptide(SEQUENCE) + "END\n")
    molecule = sparsurf.read_molecule(folder / "one.pdb")
    molecule.xyz[0] = molecule.xyz[0][:, [1, 2, 0]] + [3.0, -2.0, 7.0]
    molecule.write_pdb(folder / "two.pdb")
    pd.DataFrame({"residue": range(1, 7), "score": SCORES}).to_csv(folder / "scores.csv", index=False)
    write(folder / "dots.csv", "Res,x,y,z,Nx,Ny,Nz\nX,0,0,0,0,0,1\n")
    return folder


def proteins(folder):
    return {name: {"structure": str(folder / f"{name}.pdb")} for name in ("one", "two")}


@pytest.mark.parametrize(
    ("sites", "said"),
    [
        (
            {"s": SITE | {"query": "three"}},
            "sites.s: 'three' is none of the proteins; these are one, two, dots",
        ),
        ({"s": SITE | {"targets": ["two", "Two"]}}, "'Two' is none of the proteins"),
        ({"s": SITE | {"targets": ["one"]}}, "'one' stands on both sides"),
        ({"s": SITE | {"query": "dots"}}, "'dots' is a ready surface without residues"),
        ({"s": SITE | {"query": "one/7"}}, "sites.s.query is 'one/7', but must be of the form my_protein"),
        ({"s": {"query": "one"}}, "sites.s needs either 'query' and 'residues'"),
        ({"s": {}}, "sites.s needs either 'query' and 'residues'"),
        ({"s": SITE | {"changes": ["one", "two"]}}, "sites.s needs either 'query' and 'residues'"),
        (
            {"s": {"changes": ["one", "two"], "targets": ["two"]}},
            "sites.s needs either 'query' and 'residues'",
        ),
        ({"s": {"changes": ["one"]}}, "sites.s.changes is ['one'], but needs at least 2 values"),
        ({"s": {"changes": ["one", "one"]}}, "'one' stands on both sides"),
        ({"s": {"changes": ["one", "dots"]}}, "'dots' is a ready surface without residues"),
        ({"s": SITE | {"target": ["two"]}}, "did you mean 'targets'"),
        (
            {"s": SITE | {"residues": "57;60"}},
            "sites.s.residues is '57;60', but must be of the form A:10-52A,60",
        ),
        ({"s": SITE | {"targets": "two"}}, "or a list of proteins and conformations"),
        ({"s": SITE | {"targets": []}}, "needs at least 1 value"),
        ({"s": SITE, "S": SITE}, "differ in upper and lower case only"),
        ({"a/b": SITE}, "cannot name a folder"),
        ({"x.csv": SITE}, "a file or folder of its own"),
        ({"s": {"query": "one", "residues": "A:57", 102: None}}, "put a value with commas in quotes"),
    ],
)
def test_a_mistake_in_a_site_is_answered_with_a_sentence(folder, sites, said):
    own = proteins(folder) | {"dots": {"surface": str(folder / "dots.csv")}}
    with pytest.raises(InputError) as error:
        check({"proteins": own, "sites": sites})
    assert said in str(error.value)


def files_of(without=(), **sites):
    conformations = {"one": ["f0"], "two": ["c1", "c2"], "dots": ["c1"]}
    files = SimpleNamespace(
        run="r",
        molecules=["one", "two"],
        proteins=conformations,
        conformations=conformations.get,
        first=lambda name: conformations[name][0],
        goes_without=lambda *place: "/".join(place) == "two/c2/describe_places",
    )
    return FilesOfSites({"sites": sites, "without": dict.fromkeys(without, "why")}, files)


def test_a_site_needs_the_places_of_the_conformations_that_it_names():
    own = files_of(few=SITE | {"targets": ["two/c02", "dots"]}, every=SITE | {"query": "two"})
    few, every = (own.places(Wildcards(fromdict={"site": name})) for name in ("few", "every"))
    assert few["query"] == "r/one/f0/places.sites" and few["structure"] == "r/one/f0/structure.pdb"
    assert few["targets"] == ["r/two/c2/places.sites", "r/dots/c1/places.sites"]
    assert every["targets"] == ["r/one/f0/places.sites"]  # the dots have no atoms, and two/c2 failed
    drawn = own.surfaces(Wildcards(fromdict={"site": "few"}))
    assert drawn["surfaces"] == [f"r/{each}/surface.npz" for each in ("one/f0", "two/c2", "dots/c1")]
    assert drawn["structures"] == [f"r/{each}/structure.pdb" for each in ("one/f0", "two/c2")]
    forms = files_of(both={"changes": ["two/c2", "one"]}, late={"changes": ["one", "two/c7"]})
    assert forms.forms(Wildcards(fromdict={"site": "both"})) == {
        f"{what}_{side}": f"r/{place}/{what}.{end}"
        for what, end in (("surface", "npz"), ("structure", "pdb"))
        for side, place in ((1, "two/c2"), (2, "one/f0"))
    }
    assert forms.forms(Wildcards(fromdict={"site": "late"})) == {} and forms.compared == ["both", "late"]
    assert forms.sought == forms.proteins == []
    assert own.proteins == ["one", "two", "dots"]
    assert files_of(few=SITE | {"targets": ["two/c2"]}).proteins == ["one", "two"]
    assert files_of(few=SITE, without=["sites/few"]).names == []
    twice = files_of(few=SITE | {"targets": ["two/c2", "two/c02"]}).places(
        Wildcards(fromdict={"site": "few"})
    )
    assert twice["targets"] == ["r/two/c2/places.sites"]
    absent = files_of(few=SITE | {"targets": ["two/c3"]})
    assert absent.places(Wildcards(fromdict={"site": "few"})) == {}


@pytest.fixture(scope="module")
def study(folder, tmp_path_factory):
    """A study that seeks one site, with a field of its own on one protein, and what it said."""
    place = tmp_path_factory.mktemp("study") / "x"
    sites = {"loop": SITE, "gone": SITE | {"residues": "90"}, "late": SITE | {"targets": ["two/f5"]}}
    sites |= {"bend": {"changes": ["one", "two"]}, "lost": {"changes": ["one", "two/f7"]}}
    sites["same"] = {"changes": ["one", "one/f0"]}
    config = {"run": "s", "sampling": False, "frames": {"use": "all"}, "evaluation": {"test_dots": 20}}
    config |= {"fields": ["score", "charge"], "proteins": proteins(folder), "sites": sites}
    config["proteins"]["one"]["table"] = str(folder / "scores.csv")
    process = snakemake(place, config, "--keep-going")
    return place / "results" / "s", output(process)


def test_a_study_finds_what_find_finds(study):
    run, said = study
    hits = pd.read_csv(run / "sites/loop/hits.csv")
    structures = [run / name / "f0" / "structure.pdb" for name in ("one", "two")]
    wanted = sparsurf.find(structures[0], structures[1], residues="2-4").assign(target="two/f0")
    assert hits["target"].tolist() == ["two/f0"] and hits["places"][0] > 20, said
    np.testing.assert_array_equal(hits[["x", "y", "z", "score", "p"]], wanted[["x", "y", "z", "score", "p"]])
    laid = sparsurf.read_molecule(run / "sites/loop/superposed/01_two_f0.pdb").xyz
    two = sparsurf.read_molecule(structures[1]).xyz
    assert np.sqrt(((laid - two) ** 2).sum(axis=2).mean()) < 1.0  # as of the turned molecule in test_sites.py
    pose = pd.read_csv(run / "sites/loop/poses.csv").iloc[0, 2:].to_numpy(float)
    one = sparsurf.read_molecule(structures[0]).xyz
    np.testing.assert_allclose(
        one @ pose[:9].reshape(3, 3) + pose[9:], laid, atol=2e-3
    )  # Å, a PDB's decimals
    pairs = pd.read_csv(run / "sites/loop/matches.csv")
    assert len(pairs) == hits["places"][0] and set(pairs["residue"]) == {2, 3, 4}
    page = (run / "sites/loop/site.html").read_text()
    assert "is found on 1 of 1" in page and 'href="superposed/01_two_f0.pdb"' in page


def test_a_column_of_a_proteins_table_is_a_field_of_that_protein(folder, study):
    one, two = (study[0] / name / "f0" for name in ("one", "two"))
    molecule = sparsurf.read_molecule(one / "structure.pdb", selection="all", whole=False)
    dots = read_npz(one / "surface.npz")
    score = gaussian_mean(np.array(SCORES)[molecule.residue_index], molecule.xyz[0], dots.points)
    assert np.ptp(score) > 4
    np.testing.assert_array_equal(np.load(one / "fields.npz")["score"], score)
    whole, minimal = read_surface(one / "surface.ply"), pd.read_csv(one / "minimal.csv")
    np.testing.assert_allclose(whole.fields["score"], score, rtol=1e-5, atol=1e-5)
    np.testing.assert_allclose(minimal["score"], score[minimal["dot"]], atol=1e-4)
    mean = pd.Series(score).groupby(molecule.residue_index[dots.atom]).mean()
    np.testing.assert_allclose(pd.read_csv(one / "residues.csv")["mean_score"], mean, rtol=1e-12)
    held = max(re.findall(r"[A-Za-z0-9+/=]+", (one / "view.html").read_text()), key=len)
    assert b'"score"' in zlib.decompress(base64.b64decode(held))
    assert set(pd.read_csv(one / "fields.csv")["field"]) == {"score", "charge"}
    assert set(pd.read_csv(two / "fields.csv")["field"]) == {"charge"}  # it has no table


def test_what_a_study_cannot_find_is_a_sentence(study):
    said = study[1]
    assert "residues: '90' is not in one/f0" in said
    for name in ("late", "lost"):
        assert f"sites.{name} names a conformation that this study has not" in said
    assert "sites.same: both names mean one conformation; name another" in said
    assert "Traceback" not in said and not (study[0] / "sites/gone/hits.csv").exists()


def test_a_study_compares_two_forms(study):
    """The second is the first, turned."""
    folder, said = study[0] / "sites/bend", study[1]
    table = pd.read_csv(folder / "changes.csv", dtype={"residue": str})
    assert table["residue"].tolist() == [*"123456"], said
    assert (table["total"] > 0).all() and table["above"].sum() <= 2  # 0.3 by chance, and neighbours are alike
    assert (table["above"] == (table["total"] > table["total_floor"])).all()
    one, laid = (sparsurf.read_molecule(folder / f"changed_{side}.pdb") for side in (1, 2))
    np.testing.assert_allclose(laid.xyz, one.xyz, atol=0.002)  # Å, a PDB's decimals
    for molecule in (one, laid):
        shown = dict(zip(molecule.residue.tolist(), molecule.b_factor.tolist(), strict=True))
        assert shown == pytest.approx(dict(zip(table["residue"], table["total"], strict=True)), abs=0.005)
    page = (folder / "changes.html").read_text()
    assert f"{table['above'].sum()} of 6 residues change" in page
    assert all((folder / name).is_file() for name in ("changes.svg", "view_1.html", "view_2.html"))
