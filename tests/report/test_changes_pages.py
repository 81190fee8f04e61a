"""Pages and figures of two forms: their numbers are those of the tables, dots take the colours that they should."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
from matplotlib import colors
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

import draw_changes
import sparsurf
from conftest import ROOT
from parsed_pages import Page
from sparsurf.pairs.changes import SHARE_ABOVE_FLOOR
from sparsurf.pairs.residue_moments import CHANNELS
from sparsurf.report.changes_page import TEMPLATE, changes_page, over_floor
from sparsurf.report.figures import layout
from sparsurf.report.figures.changes import (
    BELOW,
    REST,
    _name_most,
    _named,
    _positions,
    change_colours,
    changes_figure,
    seen_alike,
)
from sparsurf.report.first_page import changes_galleries, of_changes
from sparsurf.report.numbers import signed
from sparsurf.report.page import render
from sparsurf.study.tables import read_residues
from sparsurf.surfaces.formats.npz import write_npz


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
    rows = Page(render(TEMPLATE, **known)).rows
    assert ["LYS7 → GLU", "0.60", "0.20", "0.30", "potential, charge", "−1.3", "+0.5"] in rows
    assert known["most"][1]["where"] == "GLY9" and known["most"][1]["above"] == ["potential", "charge"]
    assert signed(float("nan"), 1) == ""
    all_over = [
        "differ all over" in render(TEMPLATE, **known | own) for own in ({}, {"n": 4}, {"n_moved": 1})
    ]
    assert all_over == [True, False, False]  # of two residues, more than one above the floor of moved atoms
    gap = "Missing from the other form: A:1-5 of closed/f7."
    longer = changes_page("opening", ["open", "closed/f7"], table, SHARE_ABOVE_FLOOR, ["", "A:1-5"])
    assert gap in render(TEMPLATE, **longer) and "Missing from the other form" not in render(
        TEMPLATE, **known
    )
    page = Page(render(TEMPLATE, **known))
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


def test_forms_have_their_pictures_on_the_first_page():
    files = [
        "changes/b/changes.html",
        "changes/b/changes.csv",
        "changes/b/changes.png",
        "changes/b/view_1.html",
    ]
    pictures = [("changes/b/changes.png",) * 2 + ("changes",), ("changes/b/view_1.html", "", "view_1")]
    assert changes_galleries([*files, "p/changes.html"]) == [
        ("b", [("changes/b/changes.html", "changes")], pictures)
    ]


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
