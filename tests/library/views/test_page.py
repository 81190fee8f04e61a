"""The page that links a surface, the list and the profile of its residues: what it stores, and what a real browser does."""

import hashlib
import re
from dataclasses import replace
from pathlib import Path

import mdtraj
import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from accessibility import inaccessible
from conftest import ROOT
from parsed_pages import Page, origin_of
from peptides import atom_line, drifting, peptide
from small_study import unpacked
from sparsurf.api import frame_pages
from sparsurf.api.surroundings import with_surroundings
from sparsurf.cli import command
from sparsurf.views.page import page
from sparsurf.views.viewer import library, packing, scene, shapes

TDP43 = ROOT / "data" / "tdp43" / "topology.pdb"
CHOSEN = """
const option = document.querySelector("#list [aria-selected=true]"), mark = document.querySelector(".profile .chosen");
return {
  list: option && option.firstChild.textContent,
  profile: mark && mark.querySelector("title").textContent.split(":")[0],
  words: document.getElementById("chosen").textContent.split(":")[0],
};
"""


@pytest.fixture(scope="module")
def dots():
    """The surface of a fragment of 61 residues."""
    return sparsurf.surface(TDP43)


@pytest.fixture(scope="module")
def html(dots):
    """Its page."""
    return sparsurf.show(dots, open_browser=False).html


@pytest.fixture
def opened(browser, html):
    """The page, freshly loaded."""
    browser.view(html)
    return browser


def corners_of(header, columns, frame=0):
    """The corners (Å) and the triangles of a frame, as the page reads them."""
    points = np.column_stack([columns[f"{axis}{frame}"] for axis in "xyz"]) * header["step"]
    codes = columns[f"triangles{frame}"]
    new = codes == 0
    return points, (np.cumsum(new) - new - codes).reshape(-1, 3)


def is_closed(triangles):
    """Assert that two triangles meet at every edge."""
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert (np.unique(edges, axis=0, return_counts=True)[1] == 2).all()


def decoded_normals(u, v):
    """The unit vectors of places on the unfolded octahedron."""
    x, y = u / packing.OCTAHEDRON, v / packing.OCTAHEDRON
    z = 1 - abs(x) - abs(y)
    fold = z < 0
    x, y = (
        np.where(fold, (1 - abs(y)) * np.where(x < 0, -1, 1), x),
        np.where(fold, (1 - abs(x)) * np.where(y < 0, -1, 1), y),
    )
    both = np.column_stack([x, y, z])
    return both / np.linalg.norm(both, axis=1, keepdims=True)


def test_the_triangles_of_the_page_lie_on_the_surface_and_carry_its_residues_and_values(dots, html):
    header, columns = unpacked(html)
    points, triangles = corners_of(header, columns)
    assert triangles.max() + 1 == len(points) == len({*map(tuple, points.tolist())})
    gap, nearest = cKDTree(dots.points).query(points)
    assert gap.max() < 0.5  # Å, the spacing of the dots
    edges = np.sort(triangles[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1)
    assert np.linalg.norm(np.diff(points[edges], axis=1), axis=2).max() < 4
    across = np.cross(*(points[triangles[:, k]] - points[triangles[:, 0]] for k in (1, 2)))
    assert np.linalg.norm(across, axis=1).sum() / 2 == pytest.approx(dots.area.sum(), rel=0.05)
    is_closed(triangles)
    facing = decoded_normals(columns["u0"], columns["v0"])
    assert (facing * dots.normals[nearest]).sum(axis=1).mean() > 0.98
    assert np.mean((across[:, None] * facing[triangles]).sum(axis=(1, 2)) < 0) < 1e-3  # turned inside out
    table = sparsurf.residues(dots)
    labels = [f"{row.residue_name} {row.residue} {row.chain}".strip() for row in table.itertuples()]
    assert header["residues"] == labels
    same = dots.molecule.residue_index[dots.atom[nearest]] == columns["residue0"]
    assert same.mean() > 0.93  # corners between residues may be nearest to a dot of the other
    scale, rough = header["values"][0], sparsurf.roughness(dots)
    shown = scale["low"] + columns["corner 0"] / 254 * (scale["high"] - scale["low"])
    assert (
        np.quantile(np.abs(shown - rough[nearest]), 0.95) < 0.01
    )  # positions are rounded, so that others are nearer
    for k, column in ((0, "mean_roughness"), (1, "area")):
        described = header["numbers"][k]
        values = described["low"] + described["step"] * columns[f"number {k}"]
        exposed = table["area"] > 0
        assert np.abs(values - table[column])[exposed].max() <= described["step"]
    heavy = dots.molecule.heavy
    atoms = np.column_stack([columns[f"atom {axis}0"] for axis in "xyz"]) * header["step"]
    assert np.allclose(atoms, dots.molecule.xyz[0][heavy], atol=header["step"])
    assert columns["residue of atom"].tolist() == dots.molecule.residue_index[heavy].tolist()


def test_a_page_that_would_be_too_large_has_wider_triangles(dots):
    atoms = shapes.DrawnAtoms(dots.molecule, dots.molecule.n_residues)
    shape = shapes.Shape(sparsurf.mesh(dots, step=0.7), atoms.placed(dots.molecule.xyz[0]))
    shown = scene.PageScene([shape], atoms)
    whole, small = (shown.around(lambda data: f'PACKED = "{data}"', size) for size in (10**7, 60_000))
    assert len(small) <= 60_000 < len(whole)
    points, triangles = corners_of(*unpacked(small))
    assert 200 < len(points) < len(corners_of(*unpacked(whole))[0])
    assert cKDTree(shape.mesh.vertices.points).query(points)[0].max() < 2 * shapes.SHAPE_STEP
    is_closed(triangles)


def test_the_library_is_the_one_that_is_named():
    text = Path(library.__file__).with_name("3Dmol-min.js").read_bytes()
    assert (
        hashlib.sha256(text).hexdigest() == library.SHA256_OF_3DMOL
        and "University of Pittsburgh" in library.notice()
    )


def test_a_residue_chosen_anywhere_is_shown_everywhere(opened, dots):
    """In the picture, in the list, in the profile, by search and in the table of the roughest."""
    table, relative = sparsurf.residues(dots), sparsurf.areas(TDP43).residues["relative"]
    labels = [f"{row.residue_name} {row.residue}" for row in table.itertuples()]
    listed = table[table["area"] >= 20].sort_values("mean_roughness").index

    def shown(residue):
        assert opened.run(CHOSEN) == dict.fromkeys(("list", "profile", "words"), labels[residue])
        words = opened.run("return document.getElementById('chosen').textContent")
        assert f"area {table['area'][residue]:.0f} Å²" in words
        assert f"relative accessible area {relative[residue]:.2f}" in words

    opened.run("document.querySelector('table button.residue').click()")
    shown(listed[0])
    opened.run("choose(-1)")
    assert opened.run(CHOSEN) | {"words": ""} == {"list": None, "profile": None, "words": ""}
    opened.run("element('list').querySelector(`[data-residue='${arguments[0]}']`).click()", int(listed[2]))
    shown(listed[2])
    opened.press("#list", "ArrowDown")  # the arrow key, to the next of the list
    shown(listed[3])
    opened.press("#search", "leu 243")
    shown(labels.index("LEU 243"))
    opened.press("#search", *["Backspace"] * 10, "VAL2")
    assert opened.run("return rows().filter((row) => !row.hidden).length") == sum(
        bool(re.fullmatch(r"VAL 2\d*", label)) for label in labels
    )
    opened.press(".profile .wide", "ArrowRight")
    shown(labels.index("LEU 243") + 1)
    opened.press("#stage", "p")
    shown(labels.index("LEU 243"))


def test_a_click_chooses_the_residue_below_the_mouse(opened, html):
    """At 30 places: that of the nearest corner of the surface in front, by the projection that the library draws with."""
    header, columns = unpacked(html)
    _, triangles = corners_of(header, columns)
    opened.run("element('stage').scrollIntoView()")
    flat, depth, box = opened.run(
        "const { corners } = meshes[0], q = viewer.getView().slice(4, 8), box = element('stage').getBoundingClientRect();"
        "return [viewer.modelToScreen(corners).map(({ x, y }) => [x - scrollX - box.left - box.width / 2, y - scrollY - box.top -"
        " box.height / 2]), corners.map(({ x, y, z }) => turned(q, [x, y, z])[2]), [box.width, box.height]]"
    )
    flat, depth = np.array(flat), np.array(depth)
    key = opened.run("return element('legend').offsetHeight")
    assert flat[:, 1].max() < box[1] / 2 - key  # the key hides nothing
    a, b, c = (flat[triangles[:, k]] for k in range(3))
    facing = (b - a)[:, 0] * (c - a)[:, 1] - (b - a)[:, 1] * (c - a)[:, 0]
    random, right = np.random.default_rng(1), 0
    for place in random.uniform(-0.3, 0.3, (30, 2)) * box:
        place = np.rint(place).astype(int)
        u, v, w = (
            ((q - place)[:, 0] * (r - place)[:, 1] - (q - place)[:, 1] * (r - place)[:, 0]) / facing
            for q, r in ((b, c), (c, a), (a, b))
        )
        inside = (facing < 0) & (u >= 0) & (v >= 0) & (w >= 0)
        height = np.where(inside, (np.stack([u, v, w], axis=1) * depth[triangles]).sum(axis=1), -np.inf)
        wanted = columns["residue0"][triangles[height.argmax()]] if inside.any() else [-1]
        opened.run("choose(-1)")
        opened.point("#stage", place.tolist())
        right += opened.run("return view.chosen") in wanted
    assert right >= 29  # a place may lie on an edge


def test_ligands_and_strands_are_drawn_and_touch_the_chains_that_bury_them(browser, tmp_path):
    """A ligand of one atom between two chains, whose names hold quotes, brackets and scripts."""
    body = (
        peptide(["ALA"] * 4, chain="<")
        + "TER\n"
        + peptide(["ALA"] * 4, chain="B", origin=(0, 7.5, 0))
        + "TER\n"
    )
    ligand = atom_line("C'\"", '<">', "'", "90", (4, 3.6, 3.0), record="HETATM", element="C")
    name = '</script><script>window.bad = 1</script> & "quoted"'
    (tmp_path / "two.pdb").write_text(f"TITLE     {name}\n{body}{ligand}END\n")
    page = sparsurf.show(tmp_path / "two.pdb", tmp_path / "page.html", open_browser=False)
    header, columns = unpacked(page.html)
    assert columns["kinds"].tolist() == [0] * 8 + [2] and "<\"> 90 ' is drawn" in Page(page.html).text
    whole = sparsurf.read_molecule(tmp_path / "two.pdb", selection="all")
    table = sparsurf.areas(whole).contacts
    wanted = table[table["buried"] >= 0.5].groupby(["residue", "chain", "partner"])["buried"].sum()
    found = {
        (
            header["parts"][row[0]][1],
            header["parts"][row[0]][2],
            header["units"][row[1]].removeprefix("chain "),
        ): row[2]
        for row in header["touching"]
    }
    assert found == pytest.approx(dict(wanted), abs=0.06) and len(found) > 8
    browser.view(tmp_path / "page.html")
    assert browser.run("return [window.bad ?? 0, document.querySelector('h1').textContent]") == [0, name]
    browser.run("element('list').firstElementChild.click()")
    assert browser.run("return element('chosen').textContent").startswith("<\"> 90 ': ")
    assert browser.run("return model.selectedAtoms({ chain: 'B', resn: 'ALA' }).length") == 20
    partner = header["residues"][8]
    pairs = page_rows(page.html, "partner")
    assert (
        f"The largest interface is that of {pairs[0][0]} with {pairs[0][1]}, which buries"
        in Page(page.html).text
    )
    browser.press("#search", partner)  # it and the residues that it buries
    shown = browser.run("return rows().filter((row) => !row.hidden).map((row) => +row.dataset.residue)")
    assert shown == [
        row[0] for row in header["touching"] if 8 in (row[0], 8 * (row[1] == header["units"].index(partner)))
    ]
    assert (
        browser.run("return element('found').textContent")
        == f"1 residue found; the list shows {len(shown)} rows."
    )
    browser.run("element('colour').value = 'chain'; element('colour').dispatchEvent(new Event('input'))")
    drawn = browser.run(
        "return model.selectedAtoms({ atom: 'CA' }).map((atom) => atom.style.cartoon.colorfunc(atom))"
    )
    chains = dict(header["chains"])
    assert drawn == [int.from_bytes(bytes(chains[chain])) for chain in "<" * 4 + "B" * 4]


def test_the_ligands_of_an_assembly_and_of_the_model_that_was_read_are_drawn(tmp_path):
    """The copy lies 30 Å along x, with its ligand; in the second model, chain and ligand moved by 0.5 and 1 Å."""
    copies = []
    for copy, shift in ((1, 0.0), (2, 30.0)):
        for row in (1, 2, 3):
            turn = "".join(f"{float(row == column):10.6f}" for column in (1, 2, 3))
            copies.append(f"REMARK 350   BIOMT{row}   {copy}{turn}{shift * (row == 1):15.5f}")
    head = ["REMARK 350 BIOMOLECULE: 1", "REMARK 350 APPLY THE FOLLOWING TO CHAINS: A", *copies]
    chain = peptide(["ALA"] * 4, chain="A")
    ligand = [
        atom_line("C1", "LIG", "A", "90", (4, x, 3.0), record="HETATM", element="C") for x in (3.6, 4.6)
    ]
    (tmp_path / "one.pdb").write_text("\n".join([*head, f"{chain}TER\n{ligand[0]}END\n"]))
    chains = [chain, peptide(["ALA"] * 4, chain="A", origin=(0, 0.5, 0))]
    models = [f"MODEL        {k + 1}\n{chains[k]}TER\n{ligand[k]}ENDMDL\n" for k in (0, 1)]
    (tmp_path / "two.pdb").write_text("".join([*models, "END\n"]))
    dimer = with_surroundings(sparsurf.read_molecule(tmp_path / "one.pdb", assembly=True))
    assert np.sort(dimer.xyz[0, dimer.residue_name == "LIG", 0]).tolist() == [4, 34]
    for model, y in ((1, 3.6), (2, 4.6)):
        drawn = with_surroundings(sparsurf.read_molecule(tmp_path / "two.pdb", model=model))
        assert drawn.xyz[:, drawn.residue_name == "LIG", 1].tolist() == [[y]]
    first = sparsurf.read_molecule(tmp_path / "two.pdb", model=1)
    assert "LIG" not in with_surroundings(replace(first, xyz=first.xyz + 1)).residue_name


def test_the_page_of_regions_lists_their_residues_in_the_colours_of_the_field(browser, tmp_path):
    path = tmp_path / "page.html"
    call = ["regions", str(TDP43), "--field", "mean_curvature", "--above", "0.2", "--min-area", "5", "-q"]
    assert command.main([*call, "-o", str(path)]) == 0
    table = sparsurf.regions(TDP43, "mean_curvature", above=0.2, min_area=5)
    header, _ = unpacked(path.read_text(encoding="utf-8"))
    assert header["values"][int(header["colour"].removeprefix("value "))]["symbol"] == "mean_curvature"
    browser.view(path)
    listed = browser.run("return rows().map((row) => [...row.children].map((part) => part.textContent))")
    assert listed == [
        [f"region {row.region}", row.residues.replace(";", ","), f"{row.area:.1f} Å²; {row.mean:.2f}"]
        for row in table.itertuples()
    ]
    assert len(table) > 2
    said = f"{len(table)} regions have a mean_curvature above 0.2, {table['area'].sum():.0f} Å² in total"
    assert said in Page(path.read_text(encoding="utf-8")).text
    largest = int(table["residues"].str.count(";").idxmax())
    names, labels = table["residues"][largest].split("; "), header["residues"]
    browser.run("rows()[arguments[0]].click()", largest)
    shown = browser.run(
        "return [element('chosen').textContent, [...view.members], coloursOfSurface().map((c) => c.r)]"
    )
    assert len(names) > 1 and ", ".join(names) in shown[0] and [labels[k] for k in shown[1]] == names
    _, columns = unpacked(path.read_text(encoding="utf-8"))
    on = np.isin(columns["residue0"], shown[1])
    assert np.ptp(np.array(shown[2])[on]) == 0 and on.any()
    browser.run("element('search').value = 'region 3'; search(false)")
    assert browser.run("return rows().findIndex((row) => !row.hidden)") == 2


def test_a_page_begins_with_the_residues_that_a_read_ligand_touches(browser, tmp_path):
    """Against the contacts of `areas`, from 1 Å^2; the surface around the ligand is pale, that of the chains alone is not."""
    chains = [
        peptide(["ALA", "LEU", "LYS", "GLY"], chain, 10, origin=(0, y, 0)) + "TER\n"
        for chain, y in (("A", 0), ("B", 7.5))
    ]
    ligand = atom_line("C1", "LIG", "A", "90", (5, 4.6, 3.2), record="HETATM", element="C")
    path = tmp_path / "two.pdb"
    path.write_text("".join([*chains, ligand]))
    for ligands in ((), ("--ligands", "LIG")):
        assert (
            command.main(["show", str(path), *ligands, "--no-open", "-q", "-o", str(tmp_path / "p.html")])
            == 0
        )
        text = (tmp_path / "p.html").read_text(encoding="utf-8")
        header, _ = unpacked(text)
        assert header["colour"] == "chain"
        browser.view(tmp_path / "p.html")
        assert (browser.run("return opacity()") < 1) == bool(ligands)
        rows = browser.run("return rows().map((row) => row.textContent)")
    contacts = sparsurf.areas(sparsurf.read_molecule(path, ligands=["LIG"])).contacts
    touched = contacts[contacts["partner"].str.startswith("LIG") & (contacts["buried"] >= 1)]
    most = touched.sort_values("buried", ascending=False).iloc[0]
    said = f"LIG 90 A touches {len(touched)} residues, the most buried first: {most.residue_name} {most.residue} {most.chain} "
    assert len(touched) > 2 and said in Page(text).text
    assert ["LIG" in row.split("with")[1] for row in rows[: len(touched)]] == [True] * len(touched)


def test_a_prediction_is_coloured_by_the_bands_of_its_confidence(tmp_path, browser):
    lines = peptide(["ALA"] * 4).splitlines()
    given = [line[:60] + f"{(30, 60, 80, 95)[int(line[22:26]) - 1]:6.2f}" + line[66:] for line in lines]
    (tmp_path / "af.pdb").write_text(
        "\n".join(["TITLE     ALPHAFOLD MONOMER V2.0 PREDICTION", *given, "END", ""])
    )
    sparsurf.show(tmp_path / "af.pdb", tmp_path / "page.html", open_browser=False)
    browser.view(tmp_path / "page.html")
    browser.run("element('colour').value = 'b'; paint()")
    shown = browser.run(
        "const made = coloursOfSurface(); return meshes[0].residues.reduce((all, r, i) => (all[r] ??= made[i], all), {})"
    )
    assert [round(255 * shown[str(k)]["r"]) for k in range(4)] == [
        255,
        255,
        101,
        0,
    ]  # as in the AlphaFold database
    assert browser.run("return element('legend').textContent").startswith("pLDDTvery low")


def test_without_webgl_the_page_says_so_and_keeps_its_lists(browser, html):
    off = "<script>HTMLCanvasElement.prototype.getContext = () => null</script><body>"
    browser.open(html.replace("<body>", off, 1), "document.body.dataset.failed")
    assert "offers no WebGL" in browser.run("return element('chosen').textContent")
    browser.run("element('list').firstElementChild.click()")
    assert browser.run(CHOSEN)["list"] == browser.run(CHOSEN)["words"]
    assert len(browser.complaints()) == 1  # the console names the reason


def test_the_profile_of_a_long_chain_fits_on_the_page(browser, tmp_path):
    """In rows of 100 residues, whose places are one below the other."""
    names = ["ALA"] * 230
    (tmp_path / "long.pdb").write_text(peptide(names) + "END\n")
    sparsurf.show(tmp_path / "long.pdb", tmp_path / "page.html", open_browser=False)
    browser.view(tmp_path / "page.html")
    rows = browser.run(
        "return [...document.querySelectorAll('.profile svg')].map((s) => [s.getBoundingClientRect().right, "
        "[...s.querySelectorAll('[data-residue]')].map((c) => [+c.dataset.residue, +c.getAttribute('cx')])])"
    )
    assert [len(marks) for _, marks in rows] == [100, 100, 30] and max(right for right, _ in rows) < 1265
    assert [residue for _, marks in rows for residue, _ in marks] == [*range(230)]
    assert rows[2][1][5][1] == rows[0][1][5][1]


def test_a_page_says_how_many_residues_of_a_large_molecule_have_no_profile(tmp_path, monkeypatch):
    monkeypatch.setattr(page, "MAX_PROFILED", 3)
    (tmp_path / "five.pdb").write_text(peptide(["ALA"] * 5) + "END\n")
    html = sparsurf.show(tmp_path / "five.pdb", tmp_path / "page.html", open_browser=False).html
    assert "last 2 residues" in Page(html).text
    assert sorted({*re.findall(r'<circle[^>]* data-residue="(\d+)"', html)}) == ["0", "1", "2"]


def page_rows(html, first):
    """The rows of the table whose first column has this name."""
    return next(rows for rows in Page(html).tables if rows[0][0] == first)[1:]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A structure and its trajectory of five frames."""
    folder = tmp_path_factory.mktemp("frames")
    (folder / "top.pdb").write_text(drifting(1))
    (folder / "run.pdb").write_text(drifting())
    moving = mdtraj.load(str(folder / "run.pdb"))
    moving.time = 7500.0 * np.arange(5)  # ps
    moving.save(str(folder / "run.xtc"))
    return folder


@pytest.fixture(scope="module")
def frames_html(folder):
    """The page of its frames."""
    return sparsurf.show(folder / "top.pdb", trajectory=folder / "run.xtc", open_browser=False).html


def test_the_page_of_a_trajectory_has_the_areas_and_the_places_of_every_frame(folder, frames_html):
    header, columns = unpacked(frames_html)
    molecule = sparsurf.read_molecule(folder / "top.pdb", folder / "run.xtc")
    dots = [sparsurf.surface(molecule, frame=k) for k in range(5)]
    tables = [sparsurf.residues(each) for each in dots]
    times = ("0 ps", "7500 ps", "15 ns", "22.5 ns", "30 ns")
    assert header["frames"] == [f"frame {k}, {time}" for k, time in enumerate(times)]
    assert header["areas"] == pytest.approx([each.total_area for each in dots], abs=0.06)  # in tenths
    area, rough = (np.array([table[name] for table in tables]) for name in ("area", "mean_roughness"))
    sd, moved_by, *shown = (  # of the roughness, fluctuation, area, roughness
        (described["low"] + described["step"] * columns[f"number {k}"]).reshape(-1, 6)
        for k, described in enumerate(header["numbers"])
    )
    assert np.abs(shown[0] - area).max() < 2 and np.abs(shown[1] - rough).max() < 0.05
    assert np.allclose(sd, shown[1].std(axis=0, ddof=1), atol=0.001)
    positions = []
    for k in range(5):
        steps_ = np.column_stack([columns[f"atom {axis}{k}"] for axis in "xyz"])
        positions.append(steps_ if not k else positions[-1] + steps_)
        points, triangles = corners_of(header, columns, k)
        gap = cKDTree(points).query(positions[-1] * header["step"])[0]
        assert len(triangles) > 200 and gap.max() < 4 and gap.min() > 1  # around its atoms
    xyz = np.array(positions) * header["step"]
    spread = ((xyz - xyz.mean(axis=0)) ** 2).sum(axis=2).mean(axis=0)
    assert np.allclose(
        moved_by[0] ** 2, [spread[columns["residue of atom"] == k].mean() for k in range(6)], atol=0.05
    )
    drift = np.linalg.norm((positions[1] - positions[0])[:20] * header["step"], axis=1)
    assert drift.max() < 0.6  # superposed, though it drifts by 3 Å
    page = Page(frames_html)
    moving = labels_of(tables[0])[moved_by.argmax()]
    assert f"{moving} moves most: its atoms lie {moved_by.max():.1f} Å" in page.text.replace("\xa0", " ")
    most = labels_of(tables[0])[rough.std(axis=0, ddof=1).argmax()]
    assert "run.xtc has 5 frames of 6 residues." in page.text
    assert "molecule: 1 HOH." in page.text and "peptide bond" in page.text
    ends = [header["frames"][int(choose(header["areas"]))] for choose in (np.argmin, np.argmax)]
    said = r"ranges from ([\d,]+)\s+Å² \({}\) to ([\d,]+)\s+Å² \({}\)\.".format(*ends)
    found = [float(number.replace(",", "")) for number in re.search(said, page.text).groups()]
    assert found == pytest.approx([min(header["areas"]), max(header["areas"])], abs=0.6)
    assert f"The mean roughness of {most} changes most" in page.text
    rows = page_rows(frames_html, "residue")
    assert rows[0][0] == most and rows[0][1] == f"{sd.max():.3f}"
    assert (np.diff(sd[0][header["order"]]) <= 0).all()  # in the list
    for row in rows:
        area, rough = (values[:, labels_of(tables[0]).index(row[0])] for values in shown)
        wanted = rough.std(ddof=1), np.ptp(rough), rough.mean(), rough.min(), rough.max()
        assert [float(text) for text in row[1:6]] == pytest.approx(wanted, abs=0.002)
        assert row[6] == "5 of 5"
        assert float(row[7]) == pytest.approx(area.mean(), abs=0.6)
        assert float(row[8]) == pytest.approx(area.std(ddof=1), abs=0.2)
    by_area = sparsurf.show(
        folder / "top.pdb", trajectory=folder / "run.xtc", rank="area", rank_by="range", open_browser=False
    )
    ranges = np.ptp(shown[0], axis=0)  # of the areas that the page has
    largest = labels_of(tables[0])[ranges.argmax()]
    said = re.search(
        rf"The area of {largest} changes most, with a range of ([\d.]+)", Page(by_area.html).text
    )
    assert float(said[1]) == pytest.approx(ranges.max(), abs=0.2)
    assert (
        ranges.max() > 1.5 * shown[0].std(axis=0, ddof=1).max()
    )  # so that the deviation is not taken for it


def test_a_page_of_a_trajectory_names_its_files_and_the_frames_that_it_shows(folder, frames_html, tmp_path):
    files = {
        kind: f"{name}, SHA-256 {hashlib.sha256((folder / name).read_bytes()).hexdigest()}"
        for kind, name in (("file", "top.pdb"), ("trajectory", "run.xtc"))
    }
    one = sparsurf.show(folder / "top.pdb", trajectory=folder / "run.xtc", frame=3, open_browser=False).html
    for html, shown in ((frames_html, {"frames": "0 to 4"}), (one, {"frame": "3 of 0 to 4, 22,500 ps"})):
        (tmp_path / "page.html").write_text(html, encoding="utf-8")
        rows = origin_of(tmp_path / "page.html")
        assert rows.items() >= (files | shown | {"atoms": "30 atoms of 6 residues"}).items()


@pytest.mark.parametrize("frames", [1, 2])
def test_a_page_says_why_it_lists_no_contacts(tmp_path, caplog, frames):
    """Of two chains in the same place: which buries which cannot be said."""
    chain, path = peptide(["ALA", "GLY", "SER"]), tmp_path / "twice.pdb"
    twice = f"{chain}TER\n{peptide(['ALA', 'GLY', 'SER'], chain='B')}TER\n"
    path.write_text("".join(f"MODEL     {k:4d}\n{twice}ENDMDL\n" for k in range(1, frames + 1)) + "END\n")
    trajectory = None
    if frames > 1:
        trajectory = path.with_suffix(".xtc")
        mdtraj.load(str(path)).save(str(trajectory))
    html = sparsurf.show(path, trajectory=trajectory, open_browser=False).html
    assert not unpacked(html)[0]["touching"]
    said = [line for line in caplog.messages if "lie at the position" in line]
    assert len(said) == 1 and said[0][1:] in html


def test_contacts_over_frames_have_the_share_of_the_frames_in_which_they_last(tmp_path):
    """Of a chain that leaves the other one in the last of three frames."""
    chains = [
        f"{peptide(['ALA'] * 3)}TER\n{peptide(['ALA'] * 3, chain='B', origin=(0, 5.5 + shift, 0))}TER\n"
        for shift in (0, 0.5, 20.0)
    ]
    models = (f"MODEL     {k:4d}\n{text}ENDMDL\n" for k, text in enumerate(chains, 1))
    (tmp_path / "run.pdb").write_text("".join(models) + "END\n")
    (tmp_path / "top.pdb").write_text(f"{chains[0]}END\n")
    mdtraj.load(str(tmp_path / "run.pdb")).save(str(tmp_path / "run.xtc"))
    paths = tmp_path / "top.pdb", tmp_path / "run.xtc"
    html = sparsurf.show(paths[0], trajectory=paths[1], open_browser=False).html
    header, table = unpacked(html)[0], sparsurf.frames(*paths).contacts
    found = {
        (tuple(header["parts"][r][1:]), header["units"][unit]): (area, share)
        for r, unit, area, share in header["touching"]
    }
    wanted = {
        ((row.residue, row.chain), f"chain {row.partner}"): (row.mean, 100 * row.occupancy)
        for row in table.itertuples()
        if row.mean >= 0.5
    }
    assert found.keys() == wanted.keys() and len(found) == 6 and 67 in {share for _, share in found.values()}
    for key, numbers in found.items():
        assert numbers == pytest.approx(wanted[key], abs=0.6)
    rows = page_rows(html, "partner")
    assert [row[:2] for row in rows] in (
        [["chain A", "chain B"], ["chain B", "chain A"]],
        [["chain B", "chain A"], ["chain A", "chain B"]],
    )
    assert float(rows[0][2]) == pytest.approx(
        max(sum(area for ((_, own), _), (area, _) in found.items() if own == c) for c in "AB"), abs=0.3
    )


def labels_of(table):
    """Labels of residues."""
    return [f"{row.residue_name} {row.residue} {row.chain}".strip() for row in table.itertuples()]


def test_the_slider_the_keys_and_the_curves_choose_a_frame(browser, frames_html):
    browser.view(frames_html)
    header, columns = unpacked(frames_html)
    shown = "return [view.frame, element('frame-text').textContent, +element('frame').value]"

    def is_shown(frame):
        assert browser.run(shown) == [frame, header["frames"][frame], frame]
        number = f"{header['areas'][frame]:.0f} in the shown frame"
        assert number in browser.run(
            "return document.querySelector('.over-time svg').getAttribute('aria-label')"
        )

    is_shown(0)
    label = browser.run(
        "document.querySelector('table button.residue').click(); return head.residues[view.chosen]"
    )
    assert label == Page(frames_html).find("button")[0].text
    assert browser.run("return element('list').firstElementChild.firstElementChild.textContent") == label
    assert (
        browser.run("return document.querySelectorAll('.over-time').length") == 3
    )  # of all, and two of the residue
    for k, described in enumerate(header["numbers"][2:], 2):
        of_frames = columns[f"number {k}"].reshape(5, 6)[:, header["residues"].index(label)]
        values = described["low"] + described["step"] * of_frames
        said = [f"{value:.{described['digits']}f}" for value in (values.min(), values.max(), values[0])]
        curve = browser.run(
            f"return document.querySelectorAll('.over-time svg')[{k - 1}].getAttribute('aria-label')"
        )
        assert curve.endswith("from {} to {}; {} in the shown frame".format(*said)) and said[0] != said[1]
    words = browser.run("return element('chosen').textContent")
    browser.press("#frame", "ArrowRight")
    is_shown(1)
    assert browser.run("return element('chosen').textContent") != words
    assert inaccessible(browser) == []
    browser.screen(400, 800)
    assert browser.run("return document.documentElement.scrollWidth") <= 400
    assert browser.run("return element('frame').getBoundingClientRect().right") <= 400


def test_a_page_shows_at_most_a_hundred_frames_evenly(folder, frames_html, monkeypatch):
    for n, every in ((1, 1), (100, 1), (101, 2), (10_000, 100), (9_999, 100)):
        positions = frame_pages.shown_positions(n)
        assert (
            len(positions) <= 100
            and positions[0] == 0
            and {*np.diff(positions)} <= {every}
            and n - positions[-1] <= every
        )
    monkeypatch.setattr(scene, "MAX_FRAMES", 3)
    html = sparsurf.show(folder / "top.pdb", trajectory=folder / "run.xtc", open_browser=False).html
    assert "has 5 frames of 6 residues, of which this page shows every 2nd." in Page(html).text
    assert unpacked(html)[0]["frames"] == ["frame 0, 0 ps", "frame 2, 15 ns", "frame 4, 30 ns"]
    areas, of_all = (
        header["numbers"][2]["low"] + header["numbers"][2]["step"] * columns["number 2"].reshape(-1, 6)
        for header, columns in map(unpacked, (html, frames_html))
    )
    np.testing.assert_allclose(areas, of_all[::2], atol=0.2)
    assert np.abs(areas - of_all[:3]).max() > 2  # those of the first frames are others


def test_the_command_says_first_how_many_frames_there_are_and_names_the_page_after_them(
    folder, monkeypatch, capsys
):
    monkeypatch.chdir(folder)
    (folder / "one.pdb").write_text(drifting(1))
    for options, name, said in (
        (["--trajectory", "run.xtc"], "top_frames.html", "5 frames of 6 residues; about"),
        (["--trajectory", "run.xtc", "--frame", "2"], "top_frame2.html", ""),
        (["--trajectory", "one.pdb"], "top_frames.html", ""),  # one frame has no slider
    ):
        assert command.main(["show", "top.pdb", "--no-open", *options]) == 0
        told = capsys.readouterr().err
        assert said in told and f"wrote {name}" in told
    assert 'id="frame"' not in (folder / "top_frames.html").read_text(encoding="utf-8")
    (folder / "other.pdb").write_text(peptide(["ALA"] * 5) + "END\n")
    assert command.main(["show", "top.pdb", "--no-open", "--trajectory", "other.pdb"]) == 1
    assert "atoms" in capsys.readouterr().err
