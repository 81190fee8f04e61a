"""The page on a molecule or a surface: its numbers are those of the functions, and it opens only where somebody sees it."""

import base64
import hashlib
import importlib.util
import json
import logging
import re
import webbrowser
import zlib
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT, ball
from parsed_pages import Page, origin_of
from peptides import atom_line, peptide, two_models, write
from sparsurf.api import show, shown_surface
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.surfaces.spacing import spacing
from sparsurf.views import pictures
from sparsurf.views.page import profile

TDP43 = ROOT / "data" / "tdp43" / "topology.pdb"
PNG = b"\x89PNG\r\n\x1a\n"


@pytest.fixture(autouse=True)
def opened(monkeypatch):
    """Links that the browser was asked to open; there is no display unless a test sets one."""
    links = []
    monkeypatch.setattr(webbrowser, "open", lambda link: links.append(link) or True)
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    monkeypatch.setattr(show.sys, "platform", "linux")
    return links


@pytest.fixture(scope="module")
def molecule():
    """The page of a fragment of 61 residues, and the table of its residues."""
    dots = sparsurf.surface(TDP43)
    table = sparsurf.residues(dots)
    return dots, table, sparsurf.show(TDP43, open_browser=False).html


def header_of(html):
    """The header of the packed dots of a page."""
    content = zlib.decompress(base64.b64decode(re.search(r'PACKED = "([^"]*)"', html)[1]))
    return json.loads(content[4 : 4 + int.from_bytes(content[:4], "little")])


def ended(*arguments):
    """Exit code of a command."""
    try:
        return command.main(list(map(str, arguments)))
    except SystemExit as end:
        return end.code


def test_the_picture_of_a_large_surface_has_fewer_dots_and_its_residues_the_same_numbers(
    molecule, monkeypatch
):
    dots, _, html = molecule
    monkeypatch.setattr(shown_surface, "MAX_DOTS_OF_PICTURE", 10_000)
    monkeypatch.setattr(shown_surface, "FEWER_DOTS", 4_000)
    large, whole = Page(sparsurf.show(TDP43, open_browser=False).html), Page(html)
    shown = int(re.search(rf"those of ([\d,]+) of {len(dots):,} dots", large.text)[1].replace(",", ""))
    assert 3_000 < shown < 5_000
    (rows, of_whole) = (
        next(rows for rows in page.tables if rows[0][0] == "residue") for page in (large, whole)
    )
    assert [row[:4] for row in rows] == [row[:4] for row in of_whole]
    assert large.find("svg")[0].text == whole.find("svg")[0].text
    assert sorted(large.alternatives) == sorted(whole.alternatives)
    area = f"The surface of 61 residues in 1 chain has an area of {dots.total_area:,.0f}"
    assert area in large.text.replace("\xa0", " ") and area in whole.text.replace("\xa0", " ")
    few, full = (
        [float(row[k].replace("−", "-")) for row in each[1:] for k in range(4, len(row))]
        for each in (rows, of_whole)
    )
    assert few != full  # fields of the dots in the picture
    assert few == pytest.approx(full, abs=2.0)


def test_the_ten_roughest_residues_are_those_of_the_table(molecule):
    dots, table, html = molecule
    page = Page(html)
    wanted = table[table["area"] >= 20].sort_values("mean_roughness").head(10)
    head, *rows = next(rows for rows in page.tables if rows[0][0] == "residue")
    names = [f"{row.residue_name} {row.residue} {row.chain}".strip() for row in wanted.itertuples()]
    assert [row[0] for row in rows] == names
    assert [row[1] for row in rows] == [f"{value:.2f}" for value in wanted["mean_roughness"]]
    assert [row[2] for row in rows] == [f"{value:.0f}" for value in wanted["area"]]
    assert [row[3] for row in rows] == [str(value) for value in wanted["dots"]]
    means = sparsurf.residues(replace(dots, fields=sparsurf.fields(dots).to_dict("series"))).loc[wanted.index]
    for k, name in ((4, "hydropathy"), (5, "potential")):
        found = [float(row[k].replace("−", "-")) for row in rows]
        assert name in head[k] and found == pytest.approx(means[f"mean_{name}"].tolist(), abs=0.0051)
    buttons = [each for each in page.find("button") if each.attributes.get("class") == "residue"]
    chosen = [(each.text, int(each.attributes["data-residue"])) for each in buttons]
    assert {*chosen} == {*zip(names, wanted.index, strict=True)}
    assert (
        f"The roughest residue is {names[0]}, with a mean of {wanted['mean_roughness'].iloc[0]:.2f} over "
        in page.text
    )
    low, high = (table["mean_roughness"].agg(end) for end in ("min", "max"))
    said = page.find("svg")[0].attributes["aria-label"]
    assert f"from {low:.2f} ({names[0]}) to {high:.2f} (" in said


def test_residues_of_little_surface_are_drawn_but_neither_named_nor_marked_as_the_roughest(tmp_path):
    """The roughest two have 19.9 and 7 Å^2; where all have as little, none is ranked."""
    table = pd.DataFrame({"chain": "A", "residue": ["7", "8", "9", "10"], "residue_name": "ALA", "dots": 9})
    table = table.assign(mean_roughness=[0.2, 0.5, 0.3, 0.4])
    for area, ranked in (([19.9, 20, 7, 60], ["ALA 10 A", "ALA 8 A"]), (19.9, []), (np.nan, [])):
        sparsurf.write(table.assign(area=area), tmp_path / "x.html")
        page = Page((tmp_path / "x.html").read_text(encoding="utf-8"))
        rows = [row[0] for rows in page.tables for row in rows if rows[0][0] == "residue"]
        assert rows[1:] == ranked
        marks = page.find("circle")
        assert len(marks) == 4
        assert sum(mark.attributes.get("class") == "rough" for mark in marks) == len(ranked)
        words = "is known to have at least 20 Å² of surface, so none is ranked"
        assert (words in page.text.replace("\xa0", " ")) == (not ranked)
        figure = pictures.profile_picture(table.assign(area=area), "x").axes[0]
        assert {text.get_text() for text in figure.texts} == {*ranked}
        assert ("are marked" in figure.get_xlabel()) == bool(ranked)


def test_the_numbers_of_the_page_are_those_of_the_surface_and_its_fields(molecule):
    dots, _, html = molecule
    page, fields = Page(html), sparsurf.fields(dots)
    values = {"roughness": sparsurf.roughness(dots), "Kyte-Doolittle hydropathy": fields["hydropathy"]}
    values["electrostatic potential (kT/e)"] = fields["potential"]
    rows = {row[0]: row[1:4] for row in next(rows for rows in page.tables if rows[0][0] == "value")[1:]}
    for name, numbers in values.items():
        wanted = [f"{x:z.2f}".replace("-", "−") for x in (numbers.min(), numbers.mean(), numbers.max())]
        assert rows.pop(name) == wanted
    assert not rows  # the number of a component is no amount
    assert f"an area of {dots.total_area:,.0f} Å²" in page.text
    header = header_of(html)
    assert [scale["symbol"] for scale in header["values"]] == ["R_i", "hydropathy", "potential", "component"]
    assert not page.sources and not [
        link for link in page.links if not link.startswith("#")
    ]  # one file alone


def test_the_profile_has_a_point_for_each_residue_and_a_gap_where_one_is_buried_or_missing():
    rough = [0.35, 0.5, np.nan, 0.62, 0.7, 0.4]
    table = pd.DataFrame(
        {
            "chain": "A",
            "residue": ["7", "8", "9", "10", "20", "21"],
            "residue_name": "ALA",
            "mean_roughness": rough,
            "area": 30.0,
        }
    )
    ((panel,),) = (chain.rows for chain in profile.panels(table))
    assert [len(curve.split()) for curve in panel.curves] == [2, 1, 2]  # 9 is buried, 11 to 19 are missing
    inner = profile.PROFILE_HEIGHT - profile.TOP - profile.BOTTOM
    known = [value for value in rough if value == value]
    for mark, value in zip(panel.marks, known, strict=True):  # the axis goes from 0.3 to 0.8
        assert mark.value == value and mark.y == pytest.approx(
            profile.TOP + inner * (0.8 - value) / 0.5, abs=0.05
        )
    level = {float(text): y for y, text in panel.levels}
    assert [mark.y for mark in panel.marks] == pytest.approx([np.interp(v, sorted(level), [level[k] for k in sorted(level)])
                                                              for v in known], abs=0.1)  # fmt: skip
    across = {mark.label.split()[1]: mark.x for mark in panel.marks}
    assert panel.ticks and {text for _, text in panel.ticks} <= {*table["residue"]}
    assert all(across.get(text, x) == x for x, text in panel.ticks)
    assert panel.lowest.label == "ALA 7 A" and panel.highest.label == "ALA 20 A"
    assert {text for _, text in panel.levels} == {"0.3", "0.4", "0.5", "0.6", "0.7", "0.8"}
    coded = table.assign(residue=["7", "7A", "7B", "8", "10", "11"], mean_roughness=0.5)
    assert [len(curve.split()) for curve in profile.panels(coded)[0].rows[0].curves] == [4, 2]  # 9 is missing
    many = pd.concat(
        [table.assign(chain=name, mean_roughness=0.5 + 0.01 * k) for k, name in enumerate("ABC")]
    )
    many = many.reset_index(drop=True)
    for marked, expected in ((None, [6, 4, 0]), (many.index[-10:], [0, 4, 6])):  # ten of all chains
        shown = profile.panels(many, marked=marked)
        assert [sum(mark.rough for mark in panel.rows[0].marks) for panel in shown] == expected


def test_every_chain_of_many_has_its_profile(tmp_path):
    """In the order of the structure; those after the eighth are folded."""
    table = pd.DataFrame(
        {"chain": list("KABCDEFGHI"), "residue": "7", "residue_name": "ALA", "area": 25.0, "dots": 9}
    )
    sparsurf.write(table.assign(mean_roughness=np.linspace(0.3, 0.7, 10)), tmp_path / "x.html")
    page = Page((tmp_path / "x.html").read_text(encoding="utf-8"))
    assert "2 more chains" in [summary.text for summary in page.find("summary")]
    heads = [head for head in page.find("h3") if head.text.startswith("Chain ")]
    drawings = [
        drawing for drawing in page.find("svg") if "mean roughness" in drawing.attributes["aria-label"]
    ]
    for name, head, drawing in zip("KABCDEFGHI", heads, drawings, strict=True):
        assert head.text == f"Chain {name}" and f"(ALA 7 {name})" in drawing.attributes["aria-label"]
        for each in (head, drawing):
            assert any(around.is_of("details") for around in each.around) == (name in "HI")


def test_of_rough_residues_side_by_side_the_roughest_is_named():
    rough = np.full(200, 0.7)
    rough[100:102] = 0.4, 0.3
    table = pd.DataFrame(
        {"chain": "A", "residue": np.arange(1, 201).astype(str), "residue_name": "ALA", "area": 50}
    )
    ax = pictures.profile_picture(table.assign(mean_roughness=rough), "x").axes[0]
    named = {text.get_text() for text in ax.texts}
    assert "ALA 102 A" in named and "ALA 101 A" not in named


def test_what_was_left_out_stands_on_the_page_and_warnings_are_shown_once(tmp_path, caplog):
    water = [
        atom_line("O", "HOH", "A", str(k), (30, 3 * k, 0), record="HETATM", element="O") for k in (90, 91)
    ]
    heme = "".join(
        atom_line(name, "HEM", "A", "80", (20, k, 0), record="HETATM", element="C")
        for k, name in enumerate(["CA1", "CB1"])
    )
    (tmp_path / "holo.pdb").write_text(peptide() + heme + "".join(water) + "END\n")
    with caplog.at_level(logging.WARNING):
        page = Page(sparsurf.show(tmp_path / "holo.pdb", open_browser=False).html)
    assert "These residues of the file were left out of the molecule: 1 HEM, 2 HOH." in page.text
    assert "The surface is that of 4 residues in 1 chain, of 20 atoms." in page.text
    left_out = [record.getMessage() for record in caplog.records if "left out" in record.getMessage()]
    assert len(left_out) == 1 and "HEM" in left_out[0]  # water is a note, which the page alone has
    (tmp_path / "cut.pdb").write_text("NUMMDL    3\n" + peptide() + "END\n")
    page = Page(sparsurf.show(tmp_path / "cut.pdb", open_browser=False).html)
    told = "cut.pdb announces 3 models and holds 1: is it cut short?"  # its folder is nobody's business
    assert told in [item.text for item in page.find("li")]
    parts = [peptide(chain=chain, first=1 + 4 * k, origin=(0, 9.0 * k, 0)) for k, chain in enumerate("ABA")]
    write(tmp_path / "three.pdb", "TER\n".join(parts) + "END\n")
    text = Page(sparsurf.show(tmp_path / "three.pdb", open_browser=False).html).text
    assert "The surface is that of 12 residues in 2 chains, of 60 atoms." in text
    (tmp_path / "unknown.pdb").write_text(peptide(["UNK", "UNK"]) + "END\n")
    text = Page(sparsurf.show(tmp_path / "unknown.pdb", open_browser=False).html).text
    assert "hydropathy has no value on this molecule" in text and "potential has no value" not in text
    assert "UNK have no charges in the table and count as neutral." in text  # of the fields
    (tmp_path / "apo.pdb").write_text(peptide() + "END\n")
    page = Page(sparsurf.show(tmp_path / "apo.pdb", open_browser=False).html)
    assert "left out" in page.text


def test_dots_and_meshes_have_a_page_without_residues(tmp_path, blob):
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    dots = sparsurf.surface(tmp_path / "ala.pdb")
    mesh = sparsurf.mesh(dots)
    sparsurf.write(mesh, tmp_path / "mesh.ply")
    pd.DataFrame(np.hstack(blob), columns=["x", "y", "z", "nx", "ny", "nz"]).to_csv(tmp_path / "blob.csv")
    n_mesh, n_blob = len(mesh.vertices), len(blob[0])
    sources = [
        (tmp_path / "mesh.ply", n_mesh),
        (tmp_path / "blob.csv", n_blob),
        (blob, n_blob),
    ]
    assert (
        "roughest residues" in Page(sparsurf.show(mesh, open_browser=False).html).text
    )  # it knows its atoms
    for source, n in sources:
        html = sparsurf.show(source, open_browser=False).html
        page, header = Page(html), header_of(html)
        assert (
            "this page has no residues" in page.text
            and (header["dots"]["minimal"] or header["dots"]["total"]) == n
        )


def mean_roughness(html):
    """The mean roughness that a page states first."""
    return float(re.search(r"a mean roughness of (\d\.\d+)", sentence(html))[1])


@pytest.fixture(scope="module")
def written(molecule, tmp_path_factory):
    """A folder with the dots that touch every atom, in every format that is read again, and the subset."""
    folder, few = tmp_path_factory.mktemp("few"), sparsurf.minimal(molecule[0], error=0.05)
    for suffix in ("csv", "npz", "ply", "csv.gz"):
        few.write(folder / f"few.{suffix}")
    few.surface.write(folder / "few.dms")
    return folder, few


@pytest.mark.parametrize("suffix", ["csv", "npz", "ply", "csv.gz", "dms"])
def test_the_page_of_a_file_of_few_dots_has_the_roughness_of_their_surface(
    molecule, written, suffix, capsys, caplog
):
    """Patches of these dots alone would have a mean of 0.99, or of 0.86 with a link that suits their distances."""
    true, (folder, few) = sparsurf.roughness(molecule[0]), written
    path = folder / f"few.{suffix}"
    html = sparsurf.show(path, open_browser=False).html
    assert mean_roughness(html) == pytest.approx(true.mean(), abs=0.02)
    assert header_of(html)["dots"]["minimal"] == len(few) < header_of(html)["dots"]["total"] / 5
    assert "reconstructed from them" in sentence(html) and "reconstructed from them" in caplog.text
    assert f"reconstructed from the {len(few):,} dots alone" in Page(html).text
    row = next(row for row in Page(html).rows if row[0] == "roughness")
    assert float(row[2]) == pytest.approx(true.mean(), abs=0.02)
    caplog.clear()
    values = sparsurf.roughness(path)
    of_file = true[few.dots][
        cKDTree(few.points).query(sparsurf.read_surface(path).points)[1]
    ]  # DMS sorts dots by atom
    assert np.abs(values - of_file).mean() < 0.03 and "reconstructed from them" in caplog.text
    assert np.corrcoef(values, of_file)[0, 1] > 0.9
    out = folder / "out.csv"
    assert ended("roughness", path, "-o", out) == 0 and "reconstructed from them" in capsys.readouterr().err
    assert pd.read_csv(out)["roughness"].to_numpy() == pytest.approx(values, abs=1e-3)


def test_every_page_and_table_of_a_subset_has_the_roughness_of_the_whole_surface(molecule, written, tmp_path):
    (dots, table, _), (folder, few) = molecule, written
    true = sparsurf.roughness(dots)
    few.write(tmp_path / "few.html")
    pages = [few.show(tmp_path / "x.html").html, (tmp_path / "few.html").read_text()]
    pages += [sparsurf.show(few.surface, open_browser=False).html]
    assert [mean_roughness(html) for html in pages] == pytest.approx(3 * [true.mean()], abs=0.006)
    assert few.decision and all(few.decision[0] in Page(html).text for html in pages[:2])
    assert (sparsurf.roughness(few) == true[few.dots]).all()
    for of_few, least in (
        (sparsurf.residues(few), 1),
        (sparsurf.residues(TDP43, folder / "few.npz"), 0.85),  # reconstructed
    ):
        known = of_few["mean_roughness"].notna() & table["mean_roughness"].notna()
        pair = of_few["mean_roughness"][known], table["mean_roughness"][known]
        assert known.sum() > 50 and np.corrcoef(*pair)[0, 1] > least - 1e-9
        assert (pair[0] - pair[1]).abs().mean() < 0.03


def test_random_dots_are_few_where_their_patches_fall_apart_though_their_neighbours_are_near(tmp_path):
    """Half of the dots have a neighbour within 0.3 Å, and by patches of these dots alone the mean is 0.8."""
    path = tmp_path / "part.pdb"
    sparsurf.read_molecule(TDP43, residues="217-230").write_pdb(path)
    dense = sparsurf.surface(path, density=40)
    alone = sparsurf.Surface(dense.points, dense.normals)
    true = sparsurf.roughness(alone).mean()
    few = alone[np.sort(np.random.default_rng(0).choice(len(dense), len(dense) // 10, replace=False))]
    assert 1.3 * spacing(few.points) < 0.5
    assert sparsurf.roughness(few).mean() == pytest.approx(true, abs=0.02)
    assert mean_roughness(sparsurf.show(few, open_browser=False).html) == pytest.approx(true, abs=0.02)


def test_dots_placed_sparsely_have_the_roughness_of_the_surface_of_their_atoms():
    sparse = sparsurf.surface(TDP43, density=1)
    true = sparsurf.roughness(TDP43)
    assert mean_roughness(sparsurf.show(sparse, open_browser=False).html) == pytest.approx(
        true.mean(), abs=0.006
    )
    near = sparsurf.residues(sparse)["mean_roughness"], sparsurf.residues(TDP43)["mean_roughness"]
    assert near[0].notna().sum() > 50 and np.nanmax(np.abs(near[0] - near[1])) < 1e-9
    assert np.abs(sparsurf.roughness(sparse).mean() - true.mean()) < 0.03


@pytest.mark.parametrize(("n", "reason"), [(2, "least 12 dots"), (11, "least 12 dots"), (60, "too few")])
def test_dots_that_are_too_few_have_a_page_without_roughness(molecule, tmp_path, capsys, n, reason):
    alone = sparsurf.minimal((molecule[0].points, molecule[0].normals), n_dots=n)
    alone.write(tmp_path / "few.csv")
    assert ended("show", tmp_path / "few.csv", "--no-open", "-o", tmp_path / "few.html") == 0
    said = capsys.readouterr().err
    html = (tmp_path / "few.html").read_text()
    header = header_of(html)
    assert header["dots"]["total"] == n and [scale["symbol"] for scale in header["values"]] == []
    assert "paper" not in header["dots"]["samplers"] and "nan" not in html.split("PACKED")[0]
    assert "mean roughness" not in Page(html).text and reason in sentence(html) and reason in said
    with pytest.raises(InputError, match=reason):
        sparsurf.roughness(tmp_path / "few.csv")
    values = np.arange(n)
    shown = header_of(alone.surface.show(values, path=tmp_path / "x.html").html)
    assert [scale["symbol"] for scale in shown["values"]] == ["value"] and shown["colour"] == "value 0"


def test_a_table_of_frames_is_told_what_it_is(tmp_path, capsys):
    (tmp_path / "two.pdb").write_text(two_models())
    assert ended("frames", tmp_path / "two.pdb", "-o", tmp_path / "run.csv") == 0
    for name, what in (("run.csv", "residues in each frame"), ("run_frames.csv", "frames")):
        capsys.readouterr()
        assert ended("show", tmp_path / name, "--no-open", "-o", tmp_path / "x.html") == 1
        said = capsys.readouterr().err
        assert f"a table of the {what} of a trajectory" in said and "--trajectory" in said


def test_a_page_says_the_probe_and_the_parts_of_its_surface(tmp_path):
    (tmp_path / "far.pdb").write_text(peptide() + "TER\n" + peptide(chain="B", origin=(0, 40.0, 0)) + "END\n")
    dots = sparsurf.surface(tmp_path / "far.pdb", probe_radius=1.7)
    height = np.where(np.arange(len(dots)) % 5 == 0, np.nan, dots.points[:, 2])
    dots = replace(dots, fields={"height": height})
    html = sparsurf.show(dots, open_browser=False).html
    text = Page(html).text.replace("\xa0", " ")
    row = next(row for row in Page(html).rows if row[0] == "height")
    known = [f"{of(height):.2f}".replace("-", "−") for of in (np.nanmin, np.nanmean, np.nanmax)]
    assert row[1:] == known  # of the dots that have one
    fields = {"height": height} | sparsurf.fields(dots).to_dict("series")
    table = sparsurf.residues(replace(dots, fields=fields)).set_index(["residue_name", "residue", "chain"])
    heads, *rows = next(rows for rows in Page(html).tables if rows[0][0] == "residue")
    assert heads[4:] == [
        "mean height",
        "mean Kyte-Doolittle hydropathy",
        "mean electrostatic potential (kT/e)",
    ]
    for name, *numbers in rows:
        means = table.loc[tuple(name.split()), [f"mean_{field}" for field in fields]]
        assert numbers[3:] == [f"{value:z.2f}".replace("-", "−") for value in means]
    assert "1.7 Å." in text
    assert "of 8 residues in 2 chains, of 40 atoms." in text and "Roughness along" in text
    assert "Chain A" in text and "Chain B" in text
    header = header_of(html)
    scale = next(one for one in header["values"] if one["symbol"] == "height")
    assert (scale["low"], scale["high"]) == pytest.approx((np.nanmin(height), np.nanmax(height)))
    component = next(one for one in header["values"] if one["symbol"] == "component")
    assert (component["low"], component["high"], component["low is"]) == (0, 1, "largest")


def test_the_page_of_a_model_has_its_own_fields_and_residues(tmp_path):
    """A field that the dots bring along is shown instead of the one of its name."""
    path = write(tmp_path / "two.pdb", two_models())
    dots = sparsurf.surface(path, frame=1)
    own = replace(dots, fields={"hydropathy": np.arange(len(dots)) / 7})
    for html, hydropathy in (
        (sparsurf.show(path, frame=1, open_browser=False).html, sparsurf.fields(dots, "hydropathy")),
        (sparsurf.show(own, open_browser=False).html, own.fields["hydropathy"]),
    ):
        values = {scale["symbol"]: (scale["low"], scale["high"]) for scale in header_of(html)["values"]}
        for name, of in (("hydropathy", hydropathy), ("potential", sparsurf.fields(dots, "potential"))):
            assert values[name] == pytest.approx((np.min(of), np.max(of)))
        rows = next(rows for rows in Page(html).tables if rows[0][0] == "residue")[1:]
        area = sparsurf.residues(dots).set_index(["residue_name", "residue", "chain"])["area"]
        assert {row[0]: row[2] for row in rows} == {
            " ".join(key): f"{of:.0f}" for key, of in area.items() if of > 0
        }


def test_a_subset_is_shown_on_its_surface(tmp_path):
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    dots = sparsurf.surface(tmp_path / "ala.pdb")
    few = sparsurf.minimal(dots, percent=10)
    sparsurf.write(few, tmp_path / "few.html")
    html = (tmp_path / "few.html").read_text(encoding="utf-8")
    header = header_of(html)
    shown = [header["dots"][name] for name in ("total", "minimal", "sampler")]
    assert shown == [len(dots), len(few), "minimal"]
    page = Page(html)
    assert f"{len(few):,} of {len(dots):,} dots are kept." in page.text
    assert (
        page.tables == Page(sparsurf.show(dots, open_browser=False).html).tables
    )  # residues and values of all dots


def test_a_title_is_text_and_no_html(tmp_path):
    path = tmp_path / "<b>&.pdb"
    path.write_text(peptide() + "END\n")
    page = Page(sparsurf.show(path, open_browser=False).html)
    assert page.find("title")[0].text == "<b>&, chain A" and not page.find("b")


def test_the_browser_opens_only_where_there_is_a_display(tmp_path, monkeypatch, opened, capsys):
    path = tmp_path / "ala.pdb"
    path.write_text(peptide() + "END\n")
    monkeypatch.chdir(tmp_path)
    sparsurf.show(path, tmp_path / "first.html")
    assert ended("show", path) == 0 and not opened
    assert "wrote ala.html: " in (told := capsys.readouterr().err) and "open this page in a browser" in told
    monkeypatch.setenv("DISPLAY", ":0")
    assert ended("show", path, "--no-open") == 0 and not opened
    assert ended("show", path, "-o", "second.html") == 0
    assert opened == [(tmp_path / "second.html").as_uri()]
    view = sparsurf.show(path, tmp_path / "first.html")
    assert opened[1:] == [(tmp_path / "first.html").as_uri()]
    assert view.html == (tmp_path / "first.html").read_text(encoding="utf-8")
    of_command = (tmp_path / "second.html").read_text(
        encoding="utf-8"
    )  # which names its own command as its origin
    assert view.html.partition("<dt>command")[0] == of_command.partition("<dt>command")[0]
    sparsurf.show(path)
    assert len(opened) == 3 and opened[2].startswith("file:///") and opened[2].endswith(".html")


@pytest.mark.parametrize("name", ["show", "surface", "roughness", "residues", "minimal"])
def test_a_page_says_where_it_is_from(tmp_path, monkeypatch, name):
    """The second of two models, of which the function shows the same atoms."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "86400")
    write(tmp_path / "two.pdb", two_models())
    words = [name, "two.pdb", "--frame", "1", "--radii", "bondi", "--cavities", "remove"]
    words += ["--percent", "20"] if name == "minimal" else []
    words += ["--no-open"] if name == "show" else []
    words += ["-o", "x y.html"]
    assert ended(*words) == 0
    sum_of_file = hashlib.sha256((tmp_path / "two.pdb").read_bytes()).hexdigest()
    molecule = sparsurf.read_molecule("two.pdb")
    expected = {
        "file": f"two.pdb, SHA-256 {sum_of_file}", "chains": ", ".join(dict.fromkeys(molecule.chain)),
        "atoms": f"{molecule.n_atoms} atoms of {molecule.n_residues} residues", "frame": "1 of 0 to 1",
        "surface": "probe radius 1.4 Å, atomic radii bondi, walls of cavities removed", "date": "1970-01-02",
        "version": f"sparsurf {sparsurf.__version__}", "command": f"sparsurf {' '.join(words[:-1])} 'x y.html'",
    }  # fmt: skip
    assert origin_of(tmp_path / "x y.html") == expected
    if name != "show":
        return
    sparsurf.show("two.pdb", "f.html", frame=1, open_browser=False)
    expected |= {"command": "sparsurf.show('two.pdb', frame=1)"}
    expected |= {"surface": "probe radius 1.4 Å, atomic radii dms, walls of cavities kept"}
    assert origin_of(tmp_path / "f.html") == expected


def test_the_default_name_and_the_heading_of_a_page_hold_the_model_and_the_frame(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write(tmp_path / "two.pdb", two_models())
    for words, name, part in (
        ([], "two.html", ", frame 0"),
        (["--frame", 1], "two_frame1.html", ", frame 1"),
        (["--model", 2], "two_model2.html", ", model 2"),
    ):
        assert ended("show", "two.pdb", *words, "--no-open") == 0
        assert Page((tmp_path / name).read_text()).find("h1")[0].text == f"two, chains A, B{part}"


def test_a_file_that_is_no_page_of_ours_is_not_replaced_without_a_name(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    (tmp_path / "ala.html").write_text("<p>notes on sparsurf</p>")
    assert ended("show", "ala.pdb") == 1
    assert "ala.html exists" in capsys.readouterr().err
    assert (tmp_path / "ala.html").read_text() == "<p>notes on sparsurf</p>"
    for name in (["-o", "ala.html"], []):  # named, and then as a page of this program
        assert ended("show", "ala.pdb", *name) == 0
    assert "<h1>ala, chain A</h1>" in (tmp_path / "ala.html").read_text(encoding="utf-8")


def test_what_cannot_be_shown_is_reported(tmp_path, blob):
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    for values, words in (
        ((tmp_path / "no.pdb",), "no.pdb does not exist"),
        ((tmp_path / "ala.pdb", tmp_path / "x.csv"), "name a file that ends in .html"),
        ((3,), "an int is not a surface"),
    ):
        with pytest.raises(InputError, match=words):
            sparsurf.show(*values)
    with pytest.raises(InputError, match="trajectory belongs"):
        sparsurf.show(blob, trajectory="run.xtc")
    sparsurf.write(sparsurf.Surface(*ball(1000, 5.0)), tmp_path / "dots.csv")
    with pytest.raises(InputError, match="trajectory belongs"):
        sparsurf.show(tmp_path / "dots.csv", trajectory="run.xtc")
    with pytest.raises(InputError, match="a frame is that of a molecule"):
        sparsurf.show(blob, frame=1)
    with pytest.raises(InputError, match="has one frame, 0: there is no frame 1"):
        sparsurf.show(tmp_path / "ala.pdb", frame=1)
    with pytest.raises(InputError, match="you mean 'open_browser'"):
        sparsurf.show(tmp_path / "ala.pdb", open_brower=False)
    with pytest.raises(InputError, match="no column 'chain'"):
        sparsurf.write(pd.DataFrame({"a": [1]}), tmp_path / "table.png")


@pytest.mark.parametrize("name", ["surface", "roughness", "residues", "minimal"])
def test_results_are_also_pages_and_pictures(tmp_path, monkeypatch, capsys, name):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ala.pdb").write_text(peptide(["ALA", "GLY", "LYS", "ALA"]) + "END\n")
    options = ["--percent", 20] if name == "minimal" else ["--residues", "2-3"]
    for end in ("html", "png"):
        assert ended(name, "ala.pdb", *options, "-o", f"x.{end}") == 0
    assert (tmp_path / "x.png").read_bytes().startswith(PNG)
    html = (tmp_path / "x.html").read_text(encoding="utf-8")
    dots = sparsurf.surface("ala.pdb")
    whole = sparsurf.residues(dots).set_index("residue")["mean_roughness"]
    rows = next(rows for rows in Page(html).tables if rows[0][0] == "residue")[1:]
    shown = {row[0].split()[1]: row[1] for row in rows}
    wanted = whole if name == "minimal" else whole.loc[["2", "3"]]  # patches reach beyond these residues
    assert shown == {number: f"{value:.2f}" for number, value in wanted.items()}
    if name == "minimal":
        header = header_of(html)
        assert (header["colour"], header["dots"]["sampler"]) == ("value 0", "minimal")
    elif name != "residues":
        assert header_of(html)["colour"] == {"surface": "kind", "roughness": "value 0"}[name]
    found = importlib.util.find_spec
    monkeypatch.setattr(
        importlib.util, "find_spec", lambda each: None if each == "matplotlib" else found(each)
    )
    capsys.readouterr()
    assert ended(name, "no.pdb", "-o", "y.png") == 1
    assert "y.png: a picture" in capsys.readouterr().err


def test_the_roughness_of_the_page_follows_the_options(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ala.pdb").write_text(peptide() + "END\n")
    assert ended("roughness", "ala.pdb", "--r-patch", 6, "-o", "x.html") == 0
    page = Page((tmp_path / "x.html").read_text(encoding="utf-8"))
    mean = sparsurf.roughness(sparsurf.surface("ala.pdb"), r_patch=6).mean()
    assert f"a mean roughness of {mean:.2f}" in page.text and "within 6 Å" in page.text


def test_a_browser_draws_the_page_on_a_telephone_and_on_paper(molecule, browser):
    browser.screen(400, 800)
    browser.view(molecule[2])
    assert browser.run("return document.documentElement.scrollWidth") == 400  # nothing is cut off at the side
    browser.run("dispatchEvent(new Event('beforeprint'))")
    browser.wait_for("document.getElementById('printed').naturalWidth > 100")
    drawn = browser.run(
        "const c = document.createElement('canvas'), i = document.getElementById('printed'); [c.width, c.height] = "
        "[i.naturalWidth, i.naturalHeight]; const p = c.getContext('2d'); p.drawImage(i, 0, 0); "
        "return p.getImageData(0, 0, c.width, c.height).data.filter((v, k) => k % 4 == 0 && v < 250).length"
    )
    assert drawn > 10_000  # the surface, and not an empty canvas


def sentence(html):
    """The first sentence of a page: how large the surface is, and its roughest residue."""
    found = re.search(r'<p class="lede">(.*?)</p>', html, re.DOTALL)[1]
    return re.sub(r"\s+", " ", found.replace("&nbsp;", " "))


@pytest.fixture(scope="module")
def subset(molecule):
    return sparsurf.minimal(molecule[0], percent=5)


def test_a_subset_owns_the_area_of_the_surface_nearest_to_each_kept_dot(molecule, subset):
    dots = molecule[0]
    steps = np.rint(65536 * dots.points).astype(
        int
    )  # whole numbers, whose squares are exact; the first of equal ones counts
    of_kept = np.zeros(len(subset))
    for place, area in zip(steps, dots.area, strict=True):
        of_kept[((steps[subset.dots] - place) ** 2).sum(axis=1).argmin()] += area
    assert np.allclose(subset.surface.area, of_kept, rtol=1e-12)
    assert (dots.take(subset.dots).area == dots.area[subset.dots]).all()


def test_every_way_to_a_page_tells_the_same_area_and_the_same_roughest_residue(tmp_path):
    """14 residues, with a cavity of 40 Å^2: dots, subsets, points and meshes, as objects, in files, and by commands."""
    path = tmp_path / "part.pdb"
    sparsurf.read_molecule(TDP43, residues="217-230").write_pdb(path)
    dots = sparsurf.surface(path)
    table, subset = sparsurf.residues(dots), sparsurf.minimal(dots, percent=5)
    exposed = table[table["mean_roughness"].notna()]
    rough = " ".join(exposed.sort_values("mean_roughness").iloc[0][["residue_name", "residue"]])
    outside = sparsurf.surface(path, cavities="remove").total_area
    area, walls = f"{dots.total_area:,.0f} Å²", f"{dots.total_area - outside:,.0f} Å² are walls of cavities"
    show = lambda source: sentence(sparsurf.show(source, open_browser=False).html)  # noqa: E731

    def written(result, suffix):
        sparsurf.write(result, tmp_path / f"r{suffix}")
        return tmp_path / f"r{suffix}"

    def of_command(*words, name="c.html"):
        assert command.main([*words, "-o", str(tmp_path / name), "-q"]) == 0
        return tmp_path / name

    text = lambda page: sentence(page.read_text())  # noqa: E731
    mesh = sparsurf.mesh(path, n_vertices=300, cavities="keep")
    whole = [show(path), show(dots), show(subset), show(mesh), show(mesh.vertices)]
    whole += [show(sparsurf.points(path, 150, cavities="keep")), text(written(mesh, ".html"))]
    whole += [text(written(result, ".html")) for result in (dots, subset)]
    whole += [text(of_command("minimal", str(path), "--percent", "5"))]
    whole += [text(of_command("surface", str(path))), text(of_command("roughness", str(path)))]
    whole += [text(of_command("show", str(path), "--no-open"))]
    for found in whole:
        assert f" has an area of {area}" in found and walls in found and rough in found, found
    for found in (show(sparsurf.mesh(path)), show(sparsurf.points(path, 150))):
        assert f"{outside:,.0f} Å² without the walls of cavities" in found and rough in found, found
    suffixes = (".npz", ".csv", ".ply", ".csv.gz")
    files = [written(result, suffix) for result in (dots, subset) for suffix in suffixes]
    for file in files:
        of_file = show(file)
        assert f"dots stand for an area of {dots.area.sum():,.0f} Å²" in of_file, of_file
    for found in (show(dots[subset.dots]), text(written(dots[subset.dots], ".html"))):
        assert f"a selection of {len(subset):,} of {len(dots):,} dots" in found, found
        assert "area" not in found and "roughest" not in found  # less than 20 Å^2 of each residue is selected


def test_all_tables_of_residues_name_the_same_roughest(molecule, subset):
    dots, table, _ = molecule
    rough = table["mean_roughness"]
    half = dots[dots.points[:, 0] > dots.points[:, 0].mean()]
    for part in (subset, half, sparsurf.mesh(dots, fields="roughness")):
        of_part = sparsurf.residues(part)["mean_roughness"]
        assert of_part.notna().sum() > 20 and np.array_equal(of_part[of_part.notna()], rough[of_part.notna()])
    assert sparsurf.residues(subset)["area"].sum() == pytest.approx(dots.area.sum())
    few = sparsurf.residues(sparsurf.mesh(dots, n_vertices=300).vertices)
    known = few["mean_roughness"].notna()
    assert known.sum() > 40 and (few["mean_roughness"][known] == rough[known]).all()
    assert few["area"].sum() > 3000


def test_areas_of_an_older_file_of_a_subset_are_left_out(molecule, subset, tmp_path, caplog):
    """Each kept dot had the area of one dense dot."""
    old = replace(subset, surface=molecule[0].take(subset.dots))
    sparsurf.write(old, tmp_path / "old.npz")
    with caplog.at_level(logging.WARNING):
        assert np.isnan(sparsurf.read_surface(tmp_path / "old.npz").area).all()
    assert "left out" in caplog.text
