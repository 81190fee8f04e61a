"""Pages and figures of sites: their numbers are those of the tables, dots take the colours that they should."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from matplotlib import colors
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import draw_changes
import sparsurf
import summarise_sites
from conftest import ROOT
from parsed_pages import Page
from sparsurf.pairs.changes import CHANNELS, SHARE_ABOVE_FLOOR
from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import (
    BELOW,
    MAX_DISTANCE,
    REST,
    _name_most,
    _named,
    _positions,
    carried,
    change_colours,
    changes_figure,
    distance_from,
    matrix_figure,
    seen_alike,
    site_figure,
)
from sparsurf.report.first_page import of_changes, of_site, site_galleries
from sparsurf.report.numbers import p_value, signed
from sparsurf.report.page import render
from sparsurf.report.site_page import (
    OF_FORMS,
    TEMPLATE,
    changes_page,
    found_on,
    met,
    over_floor,
    read_residues,
    site_page,
)
from sparsurf.surfaces.formats.npz import write_npz

SITE = {"query": "bound", "residues": "A:57,102,195"}
HITS = pd.DataFrame(
    {
        "rank": [1, 2, 3],
        "target": ["unbound/c1", "other/c1", "dots/c1"],
        "chain": ["A", "B", ""],
        "residue": ["57", "8A", ""],
        "residue_name": ["HIS", "GLY", ""],
        "score": [6.891, 2.0, 0.4],
        "p": [2e-9, 0.016, 0.9],
        "places": [35, 20, 9],
    }
)
THERE = {
    "chain_there": "A",
    "residue_there": ["57", "58", "57", "102"],
    "residue_name_there": ["HIS", "CYS", "HIS", "ASP"],
}
PAIRS = pd.DataFrame(
    {
        "rank": 1,
        "chain": "A",
        "residue": ["57", "57", "57", "102"],
        "residue_name": ["HIS"] * 3 + ["ASP"],
        **THERE,
    }
)


def test_a_site_is_found_where_p_times_targets_is_rare():
    assert found_on(HITS) == 2 and found_on(pd.concat([HITS, HITS.tail(1)])) == 1  # 0.016 x 3 and x 4
    assert of_site(HITS) == {"n": 2, "targets": 3, "best": "unbound/c1", "p": "below 0.0001"}
    assert [p_value(p) for p in (0.0161, 0.9, 2e-9, 1e-4)] == ["0.016", "0.9", "below 0.0001", "0.0001"]


def test_the_page_of_a_site_has_the_numbers_of_its_tables():
    page = Page(render(TEMPLATE, **site_page("active", SITE, "bound/c1", HITS, PAIRS, 40)))
    answer = " ".join(page.text["answer"].split())
    assert answer == (
        "The site A:57,102,195 of bound/c1 is found on 2 of 3 targets. The clearest hit is on unbound/c1, around A:HIS57: "
        "35 of 40 places agree, p below 0.0001."
    )
    assert ["1", "unbound/c1", "A:HIS57", "6.89", "below 0.0001", "35", "PDB"] in page.rows
    assert ["2", "other/c1", "B:GLY8A", "2.00", "0.016", "20", "PDB"] in page.rows
    assert ["3", "dots/c1", "–", "0.40", "0.9", "9", "PDB"] in page.rows
    counted = [("A:HIS57", "A:HIS57 (2), A:CYS58 (1)"), ("A:ASP102", "A:ASP102 (1)")]  # most places first
    assert met(PAIRS[::-1]) == met(PAIRS) == counted
    assert {"superposed/02_other_c1.pdb", "hits.csv", "view_1.html", "view_2.html"} <= {*page.links}
    assert "fitted on sites of" not in render(TEMPLATE, **site_page("a", SITE, "b/c1", HITS, PAIRS, 8))
    few = render(TEMPLATE, **site_page("a", SITE, "b/c1", HITS.assign(p=0.4), PAIRS, 7))
    assert "fitted on sites of 8" in few
    assert "is found on none of 3 targets" in " ".join(Page(few).text["answer"].split())
    assert len(answer.split()) <= 60


@pytest.mark.parametrize("n", [3, 11, 12, 30])
def test_every_residue_of_a_site_has_its_own_colour(blob, n):
    points, normals = blob
    residue = np.arange(len(points)) % (n + 1) - 1
    names = [f"ALA{k}" for k in range(n)]
    figure = site_figure("mine", [("the site", points, normals, residue)], names)
    colours = [text.get_color() for text in figure.texts if text.get_text() == "■"]
    labels = [text for text in figure.texts if text.get_text() in names]
    assert [text.get_text() for text in labels] == names and len({*colours}) == len(colours) == n
    assert {text.get_color() for text in labels} == {"black"}  # yellow words cannot be read


def test_the_key_says_which_residues_of_a_site_cannot_be_seen(blob):
    """The site is seen from above its dots, most of which point up; one residue lies on the far side."""
    points, normals = blob
    up = np.argsort(-normals[:, 2])
    residue = np.full(len(points), -1)
    residue[up[:40]], residue[up[-5:]] = 0, 1
    figure = site_figure("s", [("the site", points, normals, residue)], ["ALA1", "GLY2"])
    words = [text.get_text() for text in figure.texts]
    assert "ALA1" in words and "GLY2 (hidden)" in words


def test_the_residues_that_change_most_are_named_where_there_is_room():
    """Of the five that exceed their floors most; 8 lies beside 7, which changes more, and 60 is below its floor."""
    numbers = ["7", "8", "30", "60", "100"]
    table = pd.DataFrame(
        {"chain": "A", "residue": numbers, "residue_name": ["LYS", "ALA", "GLY", "VAL", "SER"]}
    )
    table = table.assign(total=[0.6, 0.5, 0.4, 0.9, 0.3], over_floor=[3.0, 2.0, 1.5, 0.9, 1.2])
    table = table.assign(total_floor=[0.2, 0.25, 0.7, 1.0, 0.25], total_moved=0.1)
    ax = Figure().subplots()
    _name_most(ax, table, np.array([7, 8, 30, 60, 100]))
    bars = {text.get_text(): text.xy for text in ax.texts}
    assert bars == {"LYS7": (7, 0.6), "GLY30": (30, 0.4), "SER100": (100, 0.3)}
    heights = [text.get_position()[1] for text in ax.texts]
    assert heights == pytest.approx(
        [0.6 + 1 / 30, 0.7 + 1 / 30, 0.3 + 1 / 30]
    )  # that of 30 is above its floor


def test_missing_residues_leave_a_gap_along_the_axis():
    """Of at most 20 residues; an insertion code and a new chain go on by one."""
    residue = ["-3", "-2", "1", "1A", "100", "7", "9"]
    table = pd.DataFrame({"chain": list("AAAAABB"), "residue": residue})
    assert _positions(table).tolist() == [0, 1, 4, 5, 25, 26, 28]


def test_round_residues_are_named_along_the_axis():
    """12 mm of 165 are 11.3 of 155 residues, so every 20th is named; of two chains the first residues too."""
    table = pd.DataFrame({"chain": "A", "residue": [str(k) for k in range(16, 171)]})
    none, both = np.array([], int), np.array([0, 110])
    named = table["residue"].iloc[_named(table, _positions(table), none)]
    assert named.tolist() == ["20", "40", "60", "80", "100", "120", "140", "160"]
    second = pd.DataFrame({"chain": "B", "residue": [str(k) for k in range(1, 46)]})
    table = pd.concat([table[:110], second], ignore_index=True)
    named = table.iloc[_named(table, _positions(table), both)]
    assert (named["chain"] + named["residue"]).tolist() == [
        "A16",
        "A40",
        "A60",
        "A80",
        "A100",
        "B1",
        "B20",
        "B40",
    ]


def test_no_molecule_of_a_site_is_cut_by_the_frame(blob):
    points, normals = blob
    residue = np.where(np.arange(len(points)) < 50, 0, -1)
    far = points + np.array([0, 0, 15.0])  # a hit that reaches beyond the query
    panels = [("site", points, normals, residue), ("hit", far, normals, residue)]
    pictures = [ax.images[0].get_array() for ax in site_figure("s", panels, ["ALA1"]).axes]
    for picture in pictures:
        edges = [picture[0], picture[-1], picture[:, 0], picture[:, -1]]
        assert len(pictures) == 2 and min(edge.min() for edge in edges) > 250  # white all around


def test_the_clearest_hit_has_the_smallest_p_whatever_its_score():
    """A larger target scores higher by chance."""
    hits = HITS.assign(p=[0.03, 0.001, 0.9])
    assert of_site(hits) == {"n": 1, "targets": 3, "best": "other/c1", "p": "0.001"}
    page = site_page("active", SITE, "bound/c1", hits, pd.concat([PAIRS, PAIRS.tail(1).assign(rank=2)]), 40)
    shown = {key: page["best"][key] for key in ("target", "where", "p", "places")}
    assert shown == {"target": "other/c1", "where": "B:GLY8A", "p": 0.001, "places": 20}
    assert page["met"] == [("A:ASP102", "A:ASP102 (1)")] and [row["rank"] for row in page["rows"]] == [
        1,
        2,
        3,
    ]


def test_a_target_on_which_nothing_agrees_has_no_residue_and_no_file():
    hits = HITS.assign(places=[35, 20, 0], residue_name=["HIS", "GLY", "LYS"], residue=["57", "8A", "9"])
    page = Page(render(TEMPLATE, **site_page("active", SITE, "bound/c1", hits, PAIRS, 40)))
    assert ["3", "dots/c1", "–", "0.40", "0.9", "0", "–"] in page.rows
    assert "superposed/03_dots_c1.pdb" not in page.links


def changed():
    """Three residues of two forms; the second is buried on one of them."""
    table = pd.DataFrame({"chain": "", "residue": ["7", "8", "9"], "residue_name": ["LYS", "ALA", "GLY"]})
    table["residue_name_second"] = ["GLU", "ALA", "GLY"]
    table = table.assign(
        total=[0.6, np.nan, 0.3], total_floor=[0.2, np.nan, 0.2], total_moved=[0.3, np.nan, 0.1]
    )
    for k, channel in enumerate(CHANNELS):
        table[channel], table[f"{channel}_floor"] = 0.1 * k, 0.25
    return table.assign(above=[1, 0, 1], above_moved=[1, 0, 1], potential_difference=[-1.26, np.nan, 0.04],
                        hydropathy_difference=[0.5, np.nan, -0.04])  # fmt: skip


def test_chains_and_residues_of_a_table_stay_names(tmp_path):
    names = pd.DataFrame({"chain": ["NA", "", "1"], "residue": ["7", "8A", "9"], "residue_name": ["NA"] * 3})
    names.to_csv(tmp_path / "residues.csv", index=False)
    pd.testing.assert_frame_equal(read_residues(tmp_path / "residues.csv"), names, check_dtype=False)


def test_the_page_of_two_forms_has_the_numbers_of_its_table(tmp_path):
    changed().to_csv(tmp_path / "changes.csv", index=False)
    table = read_residues(tmp_path / "changes.csv")
    known = changes_page("opening", ["open", "closed/f7"], table, SHARE_ABOVE_FLOOR)
    assert (known["n"], known["n_above"], known["n_moved"], known["n_buried"], known["n_mutated"]) == (
        2,
        2,
        2,
        1,
        1,
    )
    # the buried residue has no floor to lie above
    assert changes_page("opening", ["open", "closed/f7"], table, 0.25)["n_chance"] == 0.5
    # by change over the larger floor; of the channels above their floor the two that are most; a rounded 0 has no sign
    rows = Page(render(OF_FORMS, **known)).rows
    assert ["LYS7 → GLU", "0.60", "0.20", "0.30", "potential, charge", "−1.3", "+0.5"] in rows
    assert known["most"][1]["where"] == "GLY9" and known["most"][1]["above"] == ["potential", "charge"]
    assert signed(float("nan"), 1) == ""
    all_over = [
        "differ all over" in render(OF_FORMS, **known | own) for own in ({}, {"n": 4}, {"n_moved": 1})
    ]
    assert all_over == [True, False, False]  # of two residues, more than one above the floor of moved atoms
    gap = "Missing from the other form: A:1-5 of closed/f7."
    longer = changes_page("opening", ["open", "closed/f7"], table, SHARE_ABOVE_FLOOR, ["", "A:1-5"])
    assert gap in render(OF_FORMS, **longer) and "Missing from the other form" not in render(
        OF_FORMS, **known
    )
    page = Page(render(OF_FORMS, **known))
    answer = " ".join(page.text["answer"].split())
    assert answer.startswith(
        "From open to closed/f7, 2 of 2 residues change more than fresh dots explain; 0 would by chance."
    )
    assert (
        len(answer.split()) <= 60
        and ["GLY9", "0.30", "0.20", "0.10", "potential, charge", "0.0", "0.0"] in page.rows
    )
    assert of_changes(table) == {"n": 2, "residues": 2, "chance": 0}
    assert of_changes(pd.concat([table] * 11))["chance"] == 1  # 5 % of 22


def test_sites_and_forms_have_their_pictures_on_the_first_page():
    files = [
        f"sites/{name}"
        for name in ("a/site.html", "a/site.png", "a/view_1.html", "b/changes.html", "b/changes.csv")
    ]
    assert site_galleries([*files, "p/site.html"]) == [
        (
            "a",
            [("sites/a/site.html", "site")],
            [("sites/a/site.png",) * 2 + ("site",), ("sites/a/view_1.html", "", "view_1")],
        ),
        ("b", [("sites/b/changes.html", "changes")], []),
    ]


def test_all_sites_stand_against_all_surfaces(tmp_path):
    outputs = {"matrix": tmp_path / "run/sites/matrix.csv", "png": str(tmp_path / "run/sites/matrix.png")}
    rows = {"a": [("b/c1", 9.0, 0.001, 5), ("c/c1", 2.0, 0.2, 3)], "b": [("a/c1", 7.0, 0.04, 4)]}
    for site, own in rows.items():
        (tmp_path / "run/sites" / site).mkdir(parents=True)
        hits = pd.DataFrame(own, columns=["target", "score", "p", "places"]).assign(residue="A")
        hits.to_csv(tmp_path / "run/sites" / site / "hits.csv", index=False)
    hits = [str(tmp_path / f"run/sites/{site}/hits.csv") for site in rows]
    summarise_sites.main(hits=hits, run="run", **outputs)
    table = pd.read_csv(outputs["matrix"])
    assert table.to_numpy().tolist() == [
        ["a", "b/c1", 9.0, 0.001, 5, 1],
        ["a", "c/c1", 2.0, 0.2, 3, 0],
        ["b", "a/c1", 7.0, 0.04, 4, 1],  # of one target, of two it would not count
    ]
    ax = matrix_figure("run", table).axes[0]
    np.testing.assert_allclose(
        ax.images[0].get_array().filled(np.nan),
        [[np.nan, 3, -np.log10(0.2)], [-np.log10(0.04), np.nan, np.nan]],
    )
    assert ax.lines[0].get_xydata().tolist() == [[1, 0], [0, 1]]
    assert [each.get_text() for each in ax.get_xticklabels()] == ["a/c1", "b/c1", "c/c1"]
    assert [each.get_text() for each in ax.get_yticklabels()] == ["a", "b"]
    assert site_galleries(["sites/matrix.csv", "sites/matrix.png"]) == [
        (
            "all sites",
            [("sites/matrix.csv", "matrix")],
            [("sites/matrix.png", "sites/matrix.png", "matrix")],
        )
    ]


def test_a_hit_takes_the_colour_of_the_nearest_dot_of_the_query():
    """So the site is as large on a hit as on the query: a dot that lies nearer to another residue has no colour."""
    query = np.array([[0.0, 0, 0], [2.0, 0, 0]]), np.array([4, -1])
    hit = SimpleNamespace(points=np.array([[0.9, 0, 0], [1.1, 0, 0], [0, 1.6, 0]]), normals=np.eye(3))
    assert carried(hit, query, (np.eye(3), np.zeros(3)))[2].tolist() == [4, -1, -1]


def test_a_hit_is_seen_as_the_site_and_takes_its_colours():
    rng = np.random.default_rng(0)
    site, residue = rng.uniform(-5, 5, (30, 3)), np.arange(30) % 3
    turn, shift = (
        Rotation.from_euler("xyz", [10, 80, 200], degrees=True).as_matrix(),
        np.array([5.0, -3.0, 9.0]),
    )
    points = np.concatenate([site @ turn + shift, [[100.0, 0, 0]]])
    hit = SimpleNamespace(points=points, normals=np.tile([0.0, 0, 1], (31, 1)))
    back, normals, colour = carried(hit, (site, residue), (turn, shift))
    np.testing.assert_allclose(back[:30], site, atol=1e-9)
    np.testing.assert_allclose(normals[0] @ turn, [0, 0, 1], atol=1e-9)
    assert colour.tolist() == [*residue, -1]
    gap = distance_from(back, colour >= 0)
    assert (gap[:30] == 0).all() and gap[30] == MAX_DISTANCE
    assert np.isnan(distance_from(back, np.zeros(31, bool))).all()


def test_changes_below_their_floor_are_grey_and_unknown_ones_pale():
    table = pd.DataFrame(
        {"total": [1.0, 1.0, np.nan], "total_floor": [0.4, 2.0, 1.0], "total_moved": [0.5, 1.0, 1.0]}
    )
    change = over_floor(table)
    np.testing.assert_allclose(change, [2.0, 0.5, np.nan])
    above, below, unknown = change_colours(change.to_numpy(), layout.scale(1, 2))
    assert below == pytest.approx(BELOW) and unknown == pytest.approx(colors.to_rgb(REST))
    assert above == pytest.approx(layout.colours(layout.scale(1, 2), np.array([2.0]))[0])


@pytest.fixture(scope="module")
def forms():
    """A peptide and its copy turned and moved, the change over its floor of each dot, and the table of the residues."""
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-216")
    turn, shift = Rotation.from_euler("xyz", [40, 100, 250], degrees=True).as_matrix(), [5.0, -20, 30]
    moved = replace(molecule, xyz=molecule.xyz @ turn + shift)
    dots = sparsurf.surface(molecule)
    other = sparsurf.Surface(dots.points @ turn + shift, dots.normals @ turn, atom=dots.atom)
    over = np.array([0.5, 0.2, 4.0, 0.9, np.nan, 0.3, 2.0, 0.4])  # of the residues
    table = molecule.residues.assign(
        total=0.11 * np.arange(1, 9), total_floor=0.3, total_moved=0.2, over_floor=over
    )
    table.loc[5:, "total_moved"] = 0.45
    change = over[molecule.residue_index[dots.atom]]
    return [("first", dots, molecule, change), ("second", other, moved, change)], table


def test_two_forms_are_superposed_and_seen_from_above_what_changes_most(forms):
    (_, dots, _, change), _ = forms[0]
    (points, normals), (other, turned) = seen_alike(forms[0])
    assert np.allclose(other, points, atol=1e-6) and np.allclose(turned, normals, atol=1e-6)
    assert np.allclose(np.linalg.norm(points[:50, None] - points[50:99], axis=2),
                       np.linalg.norm(dots.points[:50, None] - dots.points[50:99], axis=2))  # fmt: skip
    most = normals[change == 4].mean(axis=0)
    assert most[2] > 0.95 * np.linalg.norm(most)
    calm = normals[change == 0.2].mean(axis=0)
    assert calm[2] < 0.8 * np.linalg.norm(calm)


def test_the_figure_of_two_forms_has_a_bar_and_a_floor_for_each_residue(forms):
    figure = changes_figure("opening", *forms)
    words = " ".join(text.get_text() for text in figure.texts)
    said = "2 of 7 residues change more than their floor, about 0 would by chance"
    assert said in " ".join(words.split()) and "first" in words and "second" in words
    along = figure.axes[-1]
    assert [bar.get_height() for bar in along.patches] == pytest.approx(forms[1]["total"].tolist())
    (floors,) = along.collections
    assert [line[0][1] for line in floors.get_segments()] == pytest.approx([0.3] * 5 + [0.45] * 3)
    shown = [colors.to_rgb(bar.get_facecolor()) for bar in along.patches]
    grey = [np.allclose(colour, BELOW, atol=1e-3) for colour in shown]
    assert grey == [True, True, False, True, False, True, False, True]
    assert np.allclose(shown[4], REST, atol=1e-3)
    assert [text.get_text() for text in along.texts] == ["PHE211", "GLY215"]


def test_forms_that_differ_all_over_are_said_to(forms):
    table = forms[1].assign(over_floor=[2.0] * 7 + [0.5])
    words = " ".join(text.get_text() for text in changes_figure("opening", forms[0], table).texts)
    assert "the forms differ all over (7 of 8 residues exceed their floor)" in " ".join(words.split())


def test_the_page_of_a_form_is_grey_below_the_floor(forms, tmp_path, monkeypatch):
    """The total of the residues is 0.11 to 0.88, and their floor 0.3, or 0.45 of the last three."""
    pages, (drawn, table) = [], forms
    paths = {
        f"{kind}_{side}": str(tmp_path / f"{kind}_{side}")
        for kind in ("surface", "structure", "view")
        for side in (1, 2)
    }
    for side, (_, dots, molecule, _) in enumerate(drawn, 1):
        write_npz(paths[f"surface_{side}"], dots)
        paths[f"structure_{side}"] = str(tmp_path / f"{side}.pdb")
        molecule.write_pdb(paths[f"structure_{side}"])
    table.drop(columns="over_floor").to_csv(tmp_path / "changes.csv", index=False)
    monkeypatch.setattr(draw_changes, "coloured_page", lambda *given: pages.append(given) or "page")
    outputs = {"changes": str(tmp_path / "changes.csv"), "png": str(tmp_path / "changes.png")}
    draw_changes.main(**paths, **outputs, forms=["p/f0", "q/f0"], patches={}, seed=1, name="opening")
    assert [given[0] for given in pages] == ["opening, p/f0", "opening, q/f0"]
    residue = drawn[0][2].residue_index[drawn[0][1].atom]
    over = np.append(
        [np.nan, np.nan, 1.1], np.array([0.44, 0.55, 0.66, 0.77, 0.88]) / [0.3, 0.3, 0.45, 0.45, 0.45]
    )
    for given in pages:
        np.testing.assert_allclose(given[5][0].values, over[residue], rtol=1e-4)
