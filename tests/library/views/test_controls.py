"""Each control of a page does what it says, in a real browser: one list of controls, tried on every page that has them."""

import io
import re

import matplotlib.image
import mdtraj
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT
from parsed_pages import Page
from peptides import atom_line, drifting, peptide, write
from small_study import unpacked
from sparsurf.api.pages import page_of_dots
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface
from sparsurf.views.viewer.dots import ShownDots
from sparsurf.views.viewer.scene import DotValues

# The parts of a page that a control may change, and how each is read
PARTS = {
    "picture": "viewer.pngURI()",
    "view": "viewer.getView().map((value) => value.toFixed(3))",
    "chosen": "[view.chosen, element('chosen').textContent]",
    "frame": "element('frame-text')?.textContent",
    "curves": "element('curves')?.innerHTML",
    "key": "element('legend').textContent",
    "list": "rows().map((row) => [row.hidden, row.textContent])",
    "dots": "[element('shown').textContent, ...view.shown]",
    "table": "element('nearest').textContent",
    "saved": "window.saved",
}
SAMPLER = "element('sampler').value = '{}'; chooseDots(); paint()"
PAPER = SAMPLER.format("paper")
# Of each control: from which state it is moved, how, and the parts that change then, and no others
CONTROLS = {
    "colour": ("", "pick", "picture key"),
    "opacity": ("", "slide", "picture"),
    "inside": ("setOpacity(20); paint()", "pick", "picture"),
    "which": ("", "pick", "list"),
    "search": ("", "2", "list"),
    "none": ("choose(1)", "click", "picture chosen key curves"),
    "reset": ("viewer.rotate(40, 'vy')", "click", "picture view"),
    "save": ("", "click", "saved"),
    "frame": ("choose(4)", "slide", "picture chosen frame curves"),
    "play": ("choose(4)", "click", "picture chosen frame curves"),
    "sampler": ("", "pick", "picture dots"),
    "percent": (SAMPLER.format("farthest"), "slide", "picture dots"),
    "size": ("", "slide", "picture"),
    **{name: (PAPER, "slide", "picture dots") for name in ("alpha", "beta", "gamma", "delta")},
    "presets": (f"element('alpha').value = 0.3; {PAPER}", "pick", "picture dots"),
    "again": (SAMPLER.format("uniform"), "click", "picture dots"),
}
UNTIL = {"save": "window.saved", "play": "view.frame === 1 && !element('play').click()"}
EVERY = "colour opacity inside which search none reset save"
ON_PAGE = {
    "complex": EVERY,
    "frames": f"{EVERY} frame play",
    "dots": "colour opacity reset save sampler percent size alpha beta gamma delta presets again",
}


@pytest.fixture(scope="module")
def complexes(tmp_path_factory):
    """A file of two chains and a ligand that touches both, with B factors."""
    names = ["ALA", "LEU", "LYS", "ALA", "GLY", "ASP"]
    chains = [peptide(names, chain, 10, origin=(0, y, 0)) + "TER\n" for chain, y in (("A", 0), ("B", 7.5))]
    ligand = atom_line("C1", "LIG", "C", "90", (7, 4.6, 3.2), record="HETATM", element="C")
    lines = "".join([*chains, ligand]).splitlines()
    lines = [
        line if line == "TER" else f"{line[:60]}{7.0 + k % 23:6.2f}{line[66:]}"
        for k, line in enumerate(lines)
    ]
    return write(tmp_path_factory.mktemp("complex") / "two.pdb", "\n".join([*lines, "END", ""]))


@pytest.fixture(scope="module")
def buried(tmp_path_factory):
    """A file of a protein and of an atom of another residue that lies within it."""
    lines = [
        line for line in (ROOT / "data/tdp43/topology.pdb").read_text().splitlines() if line[:4] == "ATOM"
    ]
    place = [float(lines[100][k : k + 8]) + 0.3 for k in (30, 38, 46)]
    lines += [atom_line("CA", "GLY", lines[0][21], "270", place), "END", ""]
    return write(tmp_path_factory.mktemp("buried") / "buried.pdb", "\n".join(lines))


@pytest.fixture(scope="module")
def pages(complexes, buried, blob, tmp_path_factory):
    """The text of each page."""
    folder = tmp_path_factory.mktemp("pages")
    write(folder / "top.pdb", drifting(1))
    mdtraj.load(str(write(folder / "run.pdb", drifting()))).save(str(folder / "run.xtc"))
    surface = Surface(blob[0].round(3), blob[1], kind=np.arange(len(blob[0])) % 3)
    prepared = PreparedSurface(surface, Settings(patches={"d_link": 1.5}), streams=Streams(0, "blob"))
    shown = ShownDots(
        prepared, farthest(prepared, 3000, prepared.stream("test")), [5, 70, 2999], samples=True
    )
    values = [
        DotValues("height", "z", " Å", np.where(np.arange(3000) % 7, blob[0][:, 2], np.nan), "low", "high")
    ]
    return {
        "complex": sparsurf.show(complexes, open_browser=False).html,
        "frames": sparsurf.show(folder / "top.pdb", trajectory=folder / "run.xtc", open_browser=False).html,
        "dots": page_of_dots("blob", shown, values),
        "buried": sparsurf.show(buried, open_browser=False).html,
    }


@pytest.fixture
def shown(browser, pages):
    """Function that opens one of the pages in a window that is drawn fast, and returns the browser."""
    browser.screen(500, 400, telephone=False)

    def opened(page):
        browser.view(pages.get(page, page))
        return browser

    return opened


def state(browser):
    """What each part of the page shows."""
    return browser.run(
        f"viewer.render(); return {{{', '.join(f'{k}: JSON.stringify({v})' for k, v in PARTS.items())}}}"
    )


def changed(browser, before):
    """The parts that another state has."""
    return {part for part, now in state(browser).items() if now != before[part]}


def moves(browser, name, how):
    """Functions that move a control, one after the other."""
    give = "const e = element(arguments[0]); e.value = arguments[1]; e.dispatchEvent(new Event('input', {bubbles: true}))"
    if how == "click":
        return [lambda: browser.click(f"#{name}")]
    if how not in ("pick", "slide"):
        return [lambda: browser.press(f"#{name}", how)]
    values = "[...e.options].map((each) => each.value)" if how == "pick" else "[e.min, e.max]"
    values, now = browser.run(f"const e = element(arguments[0]); return [{values}, e.value]", name)
    return [lambda value=value: browser.run(give, name, value) for value in values if value not in (now, "")]


@pytest.mark.parametrize("page", ON_PAGE)
def test_each_control_changes_what_it_says_and_nothing_else(shown, page):
    browser = shown(page)
    click = "HTMLAnchorElement.prototype.click = function () { window.saved = this.href }"
    browser.run(
        f"{click}; window.begin = [...document.querySelectorAll('input, select')].map((e) => [e, e.value])"
    )
    restore = "choose(-1); for (const [e, value] of begin) e.value = value; toFrame(0); window.saved = null; fillList();"
    restore += "if (dots) { chooseDots(); pickDot(-1); } view.touched = false; setOpacity(100); style();"
    restore += "viewer.setView(home); paint();"
    tried, wrong, wanted = set(), {}, PARTS.keys() - (set() if page == "frames" else {"curves", "frame"})
    for name, (begin, how, parts) in CONTROLS.items():
        if not browser.run("return Boolean(element(arguments[0]))", name):
            continue
        browser.run(restore + begin)
        if not browser.run("return element(arguments[0]).checkVisibility()", name):
            continue
        tried.add(name)
        before = state(browser)
        for k, move in enumerate(moves(browser, name, how)):
            move()
            if how == "click" and name in UNTIL:
                browser.wait_for(UNTIL[name])
            found = changed(browser, before)
            if found != wanted & set(parts.split()):
                wrong[name, k] = found
            if how == "click":
                continue
            browser.run(restore + begin)
            assert not changed(browser, before), name
    assert wrong == {} and tried == set(ON_PAGE[page].split())
    here = "return [...document.querySelectorAll('main input, main select, main button:not(.residue)')].map((e) => e.id)"
    assert {*browser.run(here)} <= CONTROLS.keys()


MIDDLE = "viewer.modelToScreen(meshes[view.frame].corners[window.front]).x"
SIZE = "viewer.modelToScreen(meshes[0].corners).reduce((all, { x }) => Math.max(all, x), 0)"
# A page, a state, where which key is pressed, what is read, and whether that becomes less, more or which value
KEYS = [
    ("complex", "choose(2)", "#stage", "n", "view.chosen", 3),
    ("complex", "choose(2)", "#stage", "p", "view.chosen", 1),
    ("complex", "choose(2)", "#stage", "Escape", "view.chosen", -1),
    ("complex", "choose(2)", ".profile .wide", "ArrowRight", "view.chosen", 3),
    ("complex", "choose(2)", ".profile .wide", "ArrowLeft", "view.chosen", 1),
    ("complex", "choose(2)", ".profile .wide", "Escape", "view.chosen", -1),
    (
        "complex",
        "element('which').value = 'order'; fillList(); choose(2)",
        "#list",
        "ArrowDown",
        "view.chosen",
        3,
    ),
    (
        "complex",
        "element('which').value = 'order'; fillList(); choose(2)",
        "#list",
        "ArrowUp",
        "view.chosen",
        1,
    ),
    ("complex", "element('which').value = 'order'; fillList(); choose(2)", "#list", "End", "view.chosen", 12),
    ("complex", "element('which').value = 'order'; fillList(); choose(2)", "#list", "Home", "view.chosen", 0),
    (
        "complex",
        "element('which').value = 'order'; fillList(); choose(2)",
        "#list",
        "PageDown",
        "view.chosen",
        12,
    ),
    (
        "complex",
        "element('which').value = 'order'; fillList(); choose(11)",
        "#list",
        "PageUp",
        "view.chosen",
        1,
    ),
    (
        "complex",
        "element('which').value = 'order'; fillList(); choose(2)",
        "#list",
        "Escape",
        "view.chosen",
        -1,
    ),
    ("complex", "choose(-1); element('search').value = 'b 1'", "#search", "Enter", "view.chosen", 6),
    ("complex", "", "#stage", "+", SIZE, "more"),
    ("complex", "", "#stage", "-", SIZE, "less"),
    ("complex", "", "#stage", "ArrowLeft", MIDDLE, "less"),
    ("complex", "", "#stage", "ArrowRight", MIDDLE, "more"),
    ("complex", "", "#stage", "ArrowUp", MIDDLE.replace(".x", ".y"), "less"),
    ("complex", "", "#stage", "ArrowDown", MIDDLE.replace(".x", ".y"), "more"),
    ("frames", "toFrame(2)", "#stage", ".", "view.frame", 3),
    ("frames", "toFrame(2)", "#stage", ",", "view.frame", 1),
]


@pytest.mark.parametrize("page", ["complex", "frames"])
def test_each_key_does_what_the_page_says(shown, page):
    browser = shown(page)
    browser.run(
        "window.front = meshes[0].corners.map(({ x, y, z }) => turned(viewer.getView().slice(4), [x, y, z])[2])"
        ".reduce((best, depth, k, all) => (depth > all[best] ? k : best), 0)"
    )
    for _, begin, where, key, read, wanted in (row for row in KEYS if row[0] == page):
        before = browser.run(f"viewer.setView(home); {begin}; return {read}")
        browser.press(where, key)
        found = browser.run(f"return {read}")
        assert {"more": found > before + 1, "less": found < before - 1}.get(wanted, found == wanted), (
            where,
            key,
            before,
            found,
        )


def shown_rows(browser):
    """The residue and the texts of each row of the list that is shown."""
    return browser.run(
        "const texts = (row) => [...row.children].map((part) => part.textContent);"
        "return rows().filter((row) => !row.hidden).map((row) => [+row.dataset.residue, ...texts(row)])"
    )


@pytest.mark.parametrize("page", ["complex", "frames"])
def test_a_list_is_in_the_order_of_its_numbers(shown, pages, page):
    """The largest first, or of the roughness that of the roughest residue."""
    browser = shown(page)
    header, columns = unpacked(pages[page])
    for option in browser.run("return [...element('which').options].map((option) => option.value)"):
        browser.run("element('which').value = arguments[0]; fillList()", option)
        rows = shown_rows(browser)
        if option == "order":
            assert [row[0] for row in rows] == [*range(len(header["residues"]))]
            continue
        numbers = [
            float(row[3].split(";")[-1].split()[0].replace("−", "-"))
            for row in rows
            if row[2] != "not ranked"
        ]
        assert (
            numbers == sorted(numbers, reverse=page == "frames" or option != "ranked")
            and numbers[0] != numbers[-1]
        ), option
        if option.startswith("number"):
            table, column = header["numbers"][int(option.split()[1])], columns[option]
            wanted = {k: table["low"] + table["step"] * step for k, step in enumerate(column) if step >= 0}
            assert {row[0]: float(row[3].split()[0].replace("−", "-")) for row in rows} == pytest.approx(
                wanted, abs=0.6 * 10 ** -table["digits"]
            )


def test_a_residue_with_little_surface_has_no_rank(shown, buried):
    rows = shown_rows(shown("buried"))
    areas = sparsurf.residues(sparsurf.surface(buried))["area"]
    words = {k: "" if area >= 20 else "not ranked" for k, area in areas.items()}
    assert {row[0]: row[2] for row in rows} == words
    assert len({*words.values()}) == 2


def test_find_shows_what_begins_with_each_word(shown, pages):
    browser = shown("complex")
    labels = unpacked(pages["complex"])[0]["residues"]
    listed = browser.run("return listed().map(([residue, words]) => [residue, words])")
    for words in ("2", "1", "A", "LA", "ala", "ALA 1", "10 b", "asp15", "chain a", "lig", "x"):
        browser.run("element('search').value = ''")
        browser.press("#search", words)
        asked = re.sub(r"([A-Z]{3})(\d)", r"\1 \2", words.upper()).split()
        fits = [
            all(any(part.startswith(word) for part in re.split(r"[\s,]+", text.upper())) for word in asked)
            for text in (*labels, *(partner for _, partner in listed))
        ]
        of_labels, of_partners = fits[: len(labels)], fits[len(labels) :]
        wanted = [
            r for (r, _), is_partner in zip(listed, of_partners, strict=True) if of_labels[r] or is_partner
        ]
        assert [row[0] for row in shown_rows(browser)] == wanted, words
        found = sum(of_labels)
        said = browser.run("return element('found').textContent")
        assert said.startswith(f"{found} residue{'s' * (found != 1)} found;")


def test_the_surface_is_pale_only_where_it_hides_the_chosen_residue(shown):
    """Hidden: in front of the middle of its corners there is a triangle of another residue, by every triangle of the surface."""
    page = sparsurf.show(ROOT / "data" / "tdp43" / "topology.pdb", open_browser=False).html
    browser = shown(page)
    header, columns = unpacked(page)
    codes, owner, pale = columns["triangles0"], columns["residue0"], []
    triangles = (np.cumsum(codes == 0) - (codes == 0) - codes).reshape(-1, 3)
    corners = np.column_stack([columns[f"{axis}0"] for axis in "xyz"]) * header["step"]
    for residue in range(0, len(header["residues"]), 3):
        if not (owner == residue).any():
            continue
        opacity, turn = browser.run(
            "viewer.setView(home); choose(arguments[0]); return [opacity(), viewer.getView().slice(4)]",
            residue,
        )
        seen = Rotation.from_quat(turn).apply(corners)
        place = seen[owner == residue].mean(axis=0)
        a, b, c = (seen[triangles[:, k]] - place for k in range(3))
        u, v, w = (p[:, 0] * q[:, 1] - p[:, 1] * q[:, 0] for p, q in ((b, c), (c, a), (a, b)))
        over = (u > 0) & (v > 0) & (w > 0)  # triangles that face the viewer
        depth = (u * a[:, 2] + v * b[:, 2] + w * c[:, 2])[over] / (u + v + w)[over]
        front, shares = triangles[over][depth.argmax()], np.stack([u, v, w])[:, over][:, depth.argmax()]
        pale.append(opacity < 1)
        assert pale[-1] == (owner[front[shares.argmax()]] != residue), header["residues"][residue]
    assert 0 < sum(pale) < len(pale)


def test_the_caption_and_the_name_of_a_saved_picture_have_the_frame(shown, pages):
    browser = shown("frames")
    header, _ = unpacked(pages["frames"])
    browser.run("HTMLAnchorElement.prototype.click = function () { window.saved = this.download }")
    for frame in (0, 3):
        browser.run("window.saved = null; toFrame(arguments[0]); save()", frame)
        browser.wait_for("window.saved")
        title, caption, name = browser.run("return [document.title, caption()[0], saved]")
        assert caption == f"{title}, {header['frames'][frame]}"
        assert re.search(rf"_frame_{frame}_\d", name) and name.endswith(".png")


def test_a_click_on_a_curve_goes_to_the_frame_below_it(shown):
    """A curve has a corner for each frame."""
    browser = shown("frames")
    browser.run("choose(4)")
    for curve in range(3):
        for frame in (0, 4, 1, 3, 2):
            browser.run("element('curves').scrollIntoView()")
            x, y = browser.run(
                "const svg = document.querySelectorAll('#curves svg')[arguments[0]], box = svg.getBoundingClientRect();"
                "const [x, y] = svg.querySelector('polyline').getAttribute('points').split(' ')[arguments[1]].split(',');"
                "const share = box.width / svg.viewBox.baseVal.width, at = (place, size) => place * share - size / 2;"
                "return [at(x, box.width), at(y, box.height)]",
                curve,
                frame,
            )
            browser.run(
                "document.querySelectorAll('#curves svg').forEach((svg, k) => (svg.id = `curve-${k}`))"
            )
            browser.point(f"#curve-{curve}", (x, y))
            assert browser.run("return view.frame") == frame


def test_what_all_partners_bury_is_the_area_that_a_chain_loses(complexes):
    """A second way: the accessible area of the chain alone less that in the complex."""
    page = Page(sparsurf.show(complexes, open_browser=False).html)
    rows = {tuple(row[:2]): row[2:] for row in page.rows if len(row) == 4}
    whole = sparsurf.read_molecule(complexes, selection="all")
    together = sparsurf.areas(whole).atoms
    for chain in "AB":
        alone = sparsurf.areas(sparsurf.read_molecule(complexes, chains=chain)).atoms
        lost = alone["accessible"].sum() - together[together["chain"] == chain]["accessible"].sum()
        assert float(rows[f"chain {chain}", "all partners"][0]) == pytest.approx(lost, abs=1.5)
        parts = [
            float(row[0])
            for (own, partner), row in rows.items()
            if own == f"chain {chain}" and partner != "all partners"
        ]
        assert len(parts) == 2 and max(parts) < lost < sum(parts)


@pytest.mark.parametrize("page", ["complex", "frames", "dots"])
def test_the_left_end_of_the_key_is_that_of_the_lowest_value(shown, pages, page):
    """In the colour that is drawn on the screen, and in its words."""
    browser = shown(page)
    header, columns = unpacked(pages[page])
    prefix, all_dots = ("corner", "") if page != "dots" else ("value", SAMPLER.format("all"))
    painted = "return coloursOfSurface().map(({ r, g, b }) => [255 * r, 255 * g, 255 * b])"
    painted = painted if page != "dots" else "const made = coloursOfDots(); return view.shown.map(made)"
    place = "const box = document.querySelector('#legend .bar')?.getBoundingClientRect();"
    place += "return box && [box.left, box.right, box.top]"
    options, tried = browser.run("return [...element('colour').options].map((option) => option.value)"), 0
    for what, k in (option.split() for option in options if " " in option):
        browser.run(f"{all_dots}; element('colour').value = arguments[0]; style(); paint()", f"{what} {k}")
        browser.run("element('legend').scrollIntoView()")
        if (box := browser.run(place)) is None:
            continue  # one number alone
        scale = header[f"{what}s"][int(k)]
        if what == "value":
            steps = columns[f"{prefix} {k}"]
            values = np.where(steps == 255, np.nan, steps)
        else:
            numbers = columns[f"number {k}"][: scale["count"]].astype(float)
            of_residues = np.append(np.where(numbers < 0, np.nan, numbers), np.nan)
            values = of_residues[np.minimum(columns["residue0"], scale["count"])]
        window = 255 * matplotlib.image.imread(io.BytesIO(browser.screenshot()))[..., :3]
        bar = window[int(box[2]) + 3, int(box[0]) + 1 : int(box[1]) - 1]
        colours = np.array(browser.run(painted))[[np.nanargmin(values), np.nanargmax(values)]]
        gaps = np.linalg.norm(bar - colours[:, None], axis=2)
        assert gaps.min(axis=1).max() < 12 and gaps[0].argmin() < gaps[1].argmin(), (what, k)
        said = browser.run(
            "return [...document.querySelectorAll('#legend .ends span')].map((end) => end.textContent)"
        )
        low, high = (float(text.split()[0].replace("−", "-")) for text in said)
        assert low < high
        tried += 1
    assert tried > 1
