"""Pairs: what the config may say of them, tables and folders of them, and every script of a pair on two small peptides."""

import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
import yaml
from matplotlib.image import imread
from noted import noted
from sparsurf.workflow.partner_files import partners, requested_centres

from conftest import ROOT
from peptides import peptide, write
from small_study import SMALL, output, snakemake
from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs import matching
from sparsurf.pairs.thinning import thinning
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import surface_for_d_link
from sparsurf.surfaces.radii import radii
from sparsurf.workflow import listing
from sparsurf.workflow.config import check_config

sys.path.append(str(ROOT / "scripts"))
import make_partners

import draw_pair
import match_partners
import summarise_pairs
import tabulate_pair_residues
import thin_pair

SEQUENCE = ("ALA", "LEU", "LYS", "GLY")


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A complex of two short peptides, as one file and as two."""
    folder = tmp_path_factory.mktemp("pairs")
    first, second = peptide(SEQUENCE, "A"), peptide(SEQUENCE, "B", origin=(0, 9.0, 0))
    write(folder / "both.pdb", first + "TER\n" + second + "END\n")
    write(folder / "both_r.pdb", first + "END\n")
    write(folder / "both_l.pdb", second + "END\n")
    write(folder / "far.pdb", peptide(SEQUENCE, "B", origin=(0, 90.0, 0)) + "END\n")
    return folder


def config(**pairs):
    return check_config({"run": "x", "pairs": pairs})


def test_a_config_of_pairs_needs_no_proteins(folder):
    pair = {"complex": str(folder / "both.pdb"), "chains": [["A"], ["B"]]}
    found = config(mine=pair)
    assert found["proteins"] == {}
    assert found["pairs"] == {"mine": pair}
    assert found["complementarity"]["centres"] == "all"
    assert found["complementarity"]["nearest"] == 10


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ({"complex": "no.pdb", "chains": [["A"], ["B"]]}, "pairs.p: there is no file 'no.pdb'"),
        ({"complex": "both.pdb"}, "pairs.p"),
        ({"complex": "both.pdb", "chains": [["A"], ["A", "B"]]}, "chain A stands on both sides"),
        ({"complex": "both.pdb", "chains": [["A"]]}, "needs at least 2 values"),
        ({"files": ["both.pdb", "both.pdb"]}, "'both.pdb' stands on both sides; name two partners"),
        ({"proteins": ["a", "b"]}, "'a' is none of the proteins; these are none"),
        (
            {"files": ["both_r.pdb", "both_l.pdb"], "proteins": ["a", "b"]},
            "exactly one of 'proteins', 'files'",
        ),
        ({"file": "both.pdb"}, "did you mean 'files'"),
    ],
)
def test_a_mistake_in_a_pair_is_answered_with_a_sentence(folder, monkeypatch, pair, words):
    monkeypatch.chdir(folder)
    with pytest.raises(InputError) as error:
        config(p=pair)
    assert words in str(error.value)


def test_pairs_come_from_a_table_or_a_folder(folder):
    table = write(
        folder / "pairs.csv",
        "name,first,second,complex,chains_1,chains_2\none,both_r.pdb,both_l.pdb,,,\ntwo,,,both.pdb,A,B\n",
    )
    found = listing.pairs_from_table(str(table))
    assert found["one"] == {"files": [str(folder / "both_r.pdb"), str(folder / "both_l.pdb")]}
    assert found["two"] == {"complex": str(folder / "both.pdb"), "chains": [["A"], ["B"]]}
    assert listing.pairs_from_folder(str(folder)) == {"both": found["one"]}
    assert set(check_config({"pairs": str(table)})["pairs"]) == {"one", "two"}
    assert set(check_config({"pairs": {"folder": str(folder)}})["pairs"]) == {"both"}


@pytest.mark.parametrize("key", ["pairs", "proteins"])
def test_a_folder_stands_alone(folder, key):
    with pytest.raises(InputError, match=f"{key}.folder cannot stand next to other keys .mine."):
        check_config({key: {"folder": str(folder), "mine": {"files": ["a.pdb", "b.pdb"]}}})


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name,first\na,b\n", "line 2 of"),
        ("first,second\na,b\n", "needs a header with name and either first"),
        ("name,first,second\n", "at least one row"),
    ],
)
def test_a_wrong_table_of_pairs_is_refused(tmp_path, text, words):
    with pytest.raises(InputError, match=words):
        listing.pairs_from_table(str(write(tmp_path / "t.csv", text)))
    with pytest.raises(InputError, match="holds no two structures"):
        listing.pairs_from_folder(str(tmp_path))


@pytest.fixture(scope="module")
def settings(folder):
    checked = config(p={"files": [str(folder / "both_r.pdb"), str(folder / "both_l.pdb")]})
    rules = checked["complementarity"] | {"centres": {"sampler": "farthest", "n_S_percent": 20}, "nearest": 3}
    rules |= {"smoothing": 5.0, "interface": 3.5}
    rules["thinning"] = {
        "run": True,
        "percents": [10],
        "samplers": ["farthest"],
        "recovered": False,
        "draws": 1,
    }
    keys = ("surface", "patches", "sampling", "seed")
    return {key: checked[key] for key in keys} | {"complementarity": rules}


def made(folder, settings, pair, name, **inputs):
    """Every output of a pair, in a folder of its name."""
    out = folder / name
    out.mkdir()
    sides = {f"{what}_{side}": str(out / f"{what}_{side}.{end}")
             for what, end in (("surface", "npz"), ("structure", "pdb")) for side in (1, 2)}  # fmt: skip
    make_partners.main(inputs, sides, pair, settings, name)
    names = {"dots": "propensity.csv", "best": "best_pairs.csv", "agreement": "agreement.csv"}
    names |= {"contacts": "contacts.csv", "page": "pair.html", "ply_1": "1.ply", "ply_2": "2.ply"}
    files = {key: str(out / file) for key, file in names.items()}
    match_partners.main(sides, files, settings, pair, name, 1)
    return out, sides, files


def test_partners_are_made_by_the_rules_of_the_config(folder, settings, tmp_path):
    rules = settings["surface"] | {"radii": "bondi", "probe_radius": 1.2}
    sides = {
        f"{what}_{side}": tmp_path / f"{what}_{side}" for what in ("surface", "structure") for side in (1, 2)
    }
    pair = {"complex": "", "chains": [["B"], ["A"]]}
    both = {"complex": str(folder / "both.pdb")}
    make_partners.main(both, sides, pair, settings | {"surface": rules}, "x")
    for side, chain in ((1, "B"), (2, "A")):
        molecule = read_molecule(folder / "both.pdb", chains=[chain])
        wanted, _ = surface_for_d_link(molecule, 0, radii(molecule, "bondi"), rules, 0.5, "x")
        assert np.array_equal(read_npz(sides[f"surface_{side}"]).points, wanted.points)


@pytest.fixture(scope="module")
def touching(folder, settings):
    pair = {"complex": "", "chains": [["A"], ["B"]]}
    return made(folder, settings, pair, "touching", complex=str(folder / "both.pdb"))


def told(page):
    """The values of AUC in the sentences of a page, without those of its tables."""
    words = re.sub("<[^>]+>", "", Path(page).read_text(encoding="utf-8"))
    return re.findall(r"AUC (?:of )?(\d\.\d+)", words)


def test_a_pair_of_one_complex_gets_all_its_outputs(touching, settings):
    out, sides, files = touching
    dots = pd.read_csv(files["dots"])
    centres = dots["propensity"].notna().groupby(dots["partner"]).mean()
    assert np.allclose(centres, 0.2, atol=0.01)
    assert set(dots["chain"]) == {"A", "B"}
    agreement = pd.read_csv(files["agreement"])
    own = agreement[agreement["score"] == "propensity_smoothed"]
    assert own["partner"].tolist() == [1, 2]
    assert told(files["page"]) == [f"{auc:.2f}" for auc in own["auc"]]
    assert 'href="residues.csv"' in Path(files["page"]).read_text(encoding="utf-8")

    both = partners(sides, settings, "touching")
    found = matching.match(*both, [requested_centres(each, settings) for each in both], 3)
    for side in (0, 1):
        own = dots[dots["partner"] == side + 1].reset_index(drop=True)
        maps = matching.maps(found, side, 5.0)
        for column in ("propensity_smoothed", "propensity_k_smoothed"):
            assert np.allclose(own[column], maps[column], rtol=1e-5)
        assert np.array_equal(own["interface"] == 1, own["gap"] < 3.5)
    contacts = matching.contacts(*both, 3.5, seed=settings["seed"])
    assert np.allclose(pd.read_csv(files["contacts"])[["auc", "pairs"]], contacts[["auc", "pairs"]])

    outputs = {
        "residues": str(out / "residues.csv"),
        "pdb_1": str(out / "1.pdb"),
        "pdb_2": str(out / "2.pdb"),
        "pml": str(out / "open.pml"),
        "cxc": str(out / "open.cxc"),
    }
    tabulate_pair_residues.main(sides | {"dots": files["dots"]}, outputs)
    residues = pd.read_csv(outputs["residues"])
    assert residues["residue_name"].tolist() == 2 * list(SEQUENCE)
    written = [line for line in Path(outputs["pdb_2"]).read_text().split("\n") if line.startswith("ATOM")]
    shown = {line[22:26].strip(): float(line[60:66]) for line in written}
    expected = residues[residues["partner"] == 2].set_index("residue")["propensity_smoothed"]
    assert {int(key): value for key, value in shown.items()} == pytest.approx(expected.to_dict(), abs=0.005)
    low, high = (f"{residues['propensity_smoothed'].quantile(share):.3f}" for share in (0.05, 0.95))
    commands = [line.split() for line in Path(outputs["cxc"]).read_text().splitlines() if line[0] != "#"]
    # https://www.rbvi.ucsf.edu/chimerax/docs/user/commands/color.html: color byattribute [level:]name spec options
    coloured = [
        "byattribute",
        "a:bfactor",
        "#1,2",
        "target",
        "s",
        "palette",
        "viridis",
        "range",
        f"{low},{high}",
    ]
    assert coloured in [words[1:] for words in commands if words[0] == "color"]
    assert [words[1] for words in commands if words[0] == "open"] == ["partner_1.pdb", "partner_2.pdb"]
    assert {words[0] for words in commands} == {"open", "cartoon", "surface", "color", "set", "view"}
    assert f"partner_1 or partner_2, {low}, {high}" in Path(outputs["pml"]).read_text()
    buried = dots[(dots["partner"] == 1) | (dots["residue"] != 3)]  # as if the lysine had no dots
    buried.replace({"residue_name": {"GLY": "NA"}}).to_csv(out / "buried.csv", index=False)  # as of sodium
    tabulate_pair_residues.main(sides | {"dots": str(out / "buried.csv")}, outputs)
    written = [line for line in Path(outputs["pdb_2"]).read_text().split("\n") if line[17:20] == "LYS"]
    assert len(written) > 0 and {line[60:66] for line in written} == {" -1.00"}
    names = pd.read_csv(outputs["residues"], keep_default_na=False)["residue_name"]
    assert names.tolist() == ["ALA", "LEU", "LYS", "NA", "ALA", "LEU", "NA"]

    drawn = {"png": str(out / "book.png")} | {f"view_{k}": str(out / f"view_{k}.html") for k in (1, 2)}
    draw_pair.main(sides | {"dots": files["dots"]}, drawn, settings, "touching")
    picture = imread(out / "book.png")[..., :3]
    assert ((picture[..., 0] > 0.55) & (picture[..., 2] < 0.15)).mean() > 0.003  # the interface in vermillion

    thin = {"table": str(out / "thinning.csv"), "png": str(out / "thinning.png")}
    thin_pair.main(sides, thin, settings, "touching")
    table = pd.read_csv(thin["table"])
    assert table["sampler"].tolist() == ["all", "all", "farthest", "farthest"]
    wanted = thinning(*both, (10,), ("farthest",), smoothing=5.0, within=3.5, seed=settings["seed"])
    assert np.allclose(table[["correlation", "auc"]], wanted[["correlation", "auc"]], rtol=1e-5)
    assert (out / "thinning.svg").is_file()


def test_partners_that_do_not_touch_get_maps_and_a_sentence(folder, settings, touching, monkeypatch):
    pair = {"files": ["both_r.pdb", "far.pdb"]}
    first, second = str(folder / "both_r.pdb"), str(folder / "far.pdb")
    judged = noted(monkeypatch, matching, "agreement")
    out, sides, files = made(folder, settings, pair, "apart", first=first, second=second)
    assert [call[3:] for call in judged] == [(3.5, settings["seed"], 1)] * 2
    assert told(files["page"]) == []
    assert 'href="residues.csv"' in Path(files["page"]).read_text(encoding="utf-8")
    assert len(pd.read_csv(files["agreement"])) == len(pd.read_csv(files["contacts"])) == 0
    assert pd.read_csv(files["dots"])["propensity_smoothed"].notna().all()
    drawn = {"png": str(out / "book.png")} | {f"view_{k}": str(out / f"view_{k}.html") for k in (1, 2)}
    draw_pair.main(sides | {"dots": files["dots"]}, drawn, settings, "apart")

    # a ready surface: the same without atoms
    bare = {key: path for key, path in sides.items() if key.startswith("surface")}
    match_partners.main(bare, files, settings, pair, "apart", 1)
    assert "residue" not in pd.read_csv(files["dots"]).columns
    assert 'href="residues.csv"' not in Path(files["page"]).read_text(encoding="utf-8")

    summary = {key: str(out / f"{key}.csv") for key in ("table", "means", "page")} | {
        "png": str(out / "pairs.png")
    }
    drawn = noted(monkeypatch, summarise_pairs, "over_pairs")
    summarise_pairs.main({"tables": [touching[2]["agreement"], files["agreement"]]}, summary)
    run = folder.parent.name  # as if it were results/<run>/pairs/<pair>
    assert drawn[0][0] == run and f"All pairs: {run}<" in Path(summary["page"]).read_text(encoding="utf-8")
    means = pd.read_csv(summary["means"]).set_index("score")["mean"]
    assert means["propensity_smoothed"] > 0 and len(told(summary["page"])) == 1
    assert "1 of 2 pairs" in Path(summary["page"]).read_text(encoding="utf-8")
    summarise_pairs.main({"tables": [files["agreement"]]}, summary)
    assert told(summary["page"]) == [] and len(pd.read_csv(summary["means"])) == 0


def test_a_partner_of_several_models_is_refused(folder, settings, tmp_path):
    model = f"MODEL 1\n{peptide(SEQUENCE)}ENDMDL\n"
    two = write(tmp_path / "models.pdb", model + model.replace("MODEL 1", "MODEL 2") + "END\n")
    with pytest.raises(InputError, match=r"^x: partner 1 has 2 models"):
        make_partners.main(
            {"first": two, "second": str(folder / "far.pdb")}, {}, {"files": []}, settings, "x"
        )


def test_chains_that_are_not_there_are_named(folder, settings):
    with pytest.raises(InputError, match="no chain X: its chains are A, B"):
        make_partners.main(
            {"complex": str(folder / "both.pdb")},
            {},
            {"complex": "", "chains": [["A"], ["X"]]},
            settings,
            "x",
        )


OF_PAIR = [
    "pair.html",
    "book.png",
    "book.svg",
    "view_1.html",
    "view_2.html",
    "residues.csv",
    "open.pml",
    "open.cxc",
    "partner_1.pdb",
    "partner_2.pdb",
    "partner_1.ply",
]
OF_PAIR += [
    "propensity.csv",
    "best_pairs.csv",
    "agreement.csv",
    "contacts.csv",
    "thinning.csv",
    "thinning.png",
    ".complete",
]
FEW = {"sampler": "farthest", "n_S": 60}


def test_the_study_of_complexes_on_a_folder_of_ones_own(folder, tmp_path):
    """From beginning to end; the run's first page tells of the pairs."""
    study = yaml.safe_load((ROOT / "studies" / "complexes.yaml").read_text(encoding="utf-8"))
    thinning = {"run": True, "percents": [10], "samplers": ["farthest"], "recovered": False, "draws": 1}
    process = snakemake(
        tmp_path / "x",
        study | {"pairs": {"folder": str(folder)}, "complementarity": {"centres": FEW, "thinning": thinning}},
    )
    assert process.returncode == 0, output(process)
    run = tmp_path / "x" / "results" / "complexes"
    assert {path.name for path in (run / "pairs" / "both").iterdir()} >= set(OF_PAIR)
    first = (run / "index.html").read_text(encoding="utf-8")
    means = pd.read_csv(run / "pairs" / "means.csv").set_index("score")["mean"]
    assert f"AUC {means['propensity_smoothed']:.2f}<" in first
    part = (run / ".front_page.html").read_text(encoding="utf-8")
    assert 'src="pairs/both/book.png"' in first
    for page in ("book.png", "view_1.html", "view_2.html", "thinning.png"):
        assert f'href="pairs/both/{page}"' in first
        assert f"showResultInfo('results/complexes/pairs/both/{page}')" in part
    assert 'href="pairs/both/pair.html"' in first and 'href="pairs/both/pair.html"' in part


def test_pairs_of_proteins_and_of_a_ready_surface(folder, touching, tmp_path):
    """Two structures of the config give the surfaces that a complex does; a ready surface has no residues."""
    dots = pd.read_csv(touching[2]["dots"])
    places = ["x", "y", "z"]
    ready = pd.DataFrame(
        np.hstack([read_npz(touching[1]["surface_2"]).points, read_npz(touching[1]["surface_2"]).normals])
    )
    ready.columns = [*places, "Nx", "Ny", "Nz"]
    ready.insert(0, "Res", "X")
    ready.to_csv(tmp_path / "ready.csv", index=False)
    proteins = {
        "one": {"structure": str(folder / "both_r.pdb")},
        "two": {"structure": str(folder / "both_l.pdb")},
    }
    proteins["ready"] = {"surface": str(tmp_path / "ready.csv")}
    pairs = {"both": {"proteins": ["one", "two"]}, "half": {"proteins": ["one", "ready"]}}
    rules = {"centres": FEW, "interface": 3.5}  # Å, as of `touching`
    requests = {"proteins": proteins, "pairs": pairs, "frames": {}, "complementarity": rules}
    targets = ["both/pair.html", "both/residues.csv", "half/.complete", "pairs.html"]
    targets = [f"results/small/pairs/{target}" for target in targets]
    process = snakemake(tmp_path / "x", SMALL | requests, *targets)
    assert process.returncode == 0, output(process)
    run = tmp_path / "x" / "results" / "small" / "pairs"
    for pair in pairs:
        found = pd.read_csv(run / pair / "propensity.csv")
        assert np.allclose(found[places], dots[places], atol=0.002)
        assert found.groupby("partner")["propensity"].count().tolist() == [60, 60]
        assert np.array_equal(found["interface"], dots["interface"])
    residues = pd.read_csv(run / "both" / "residues.csv")
    assert residues["residue_name"].tolist() == 2 * list(SEQUENCE)
    assert "Partner 1 is one, partner 2 is two." in (run / "both" / "pair.html").read_text(encoding="utf-8")
    page = (run / "half" / "pair.html").read_text(encoding="utf-8")
    assert "Partner 2 is a ready surface without atoms" in page
    assert not (run / "half" / "residues.csv").exists()
    assert "over 2 of 2 pairs" in (run / "pairs.html").read_text(encoding="utf-8")
