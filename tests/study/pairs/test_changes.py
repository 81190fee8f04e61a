"""Two forms residue by residue: distances as written, floors that 5 % exceed, changes where something changed."""

import warnings
from dataclasses import replace

import gemmi
import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from peptides import peptide, write
from sparsurf.dot_fields.named_fields import compute_fields
from sparsurf.errors import InputError
from sparsurf.evaluation.floors import random_rotation
from sparsurf.patches.descriptors import describe_fields_of_patches, describe_patches
from sparsurf.patches.index import build_grid
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.recovery.interpolated_surface import dot_spacing
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.settings import Settings
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf_study.pairs import changes as module
from sparsurf_study.pairs import residue_moments
from sparsurf_study.pairs.changes import (
    Form,
    changes,
    common_residues,
    floor_of,
    noise,
    numbered_alike,
    residue_ranges,
    unmatched_residues,
)
from sparsurf_study.pairs.residue_moments import (
    MOMENT_CHANNELS,
    MOMENT_FIELDS,
    ORDER,
    PATCH_RADIUS,
    PERCENT_OF_DOTS,
    _fields,
    describe_residues,
    distances,
    spread_of_moments,
)

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"
LYSINE = 15  # LYS 224
CHARGE = MOMENT_CHANNELS.index("charge")


def form_of(molecule, name="one"):
    def lay(xyz):
        return sparsurf.surface(replace(molecule, xyz=xyz[None]))

    return Form(name, sparsurf.surface(molecule), molecule, lay)


@pytest.fixture(scope="module")
def form():
    return form_of(sparsurf.read_molecule(TOPOLOGY, residues="209-238"))


@pytest.fixture(scope="module")
def own(form):
    return describe_residues(form.surface, form.molecule, "one")


@pytest.fixture(scope="module")
def found(form, own):
    """Distances of the form to itself on fresh dots."""
    return noise(form, own, np.random.default_rng(1))


def test_residues_have_the_means_of_their_places(form, own):
    """A residue has the mean over its dots among the tenth that lie farthest apart; each by itself, through the library."""
    n = round(PERCENT_OF_DOTS / 100 * len(form.surface))
    kept = form.surface.take(
        farthest_point_sampling(build_grid(form.surface.points), n, np.random.default_rng(0))
    )
    assert own.places.sum() == n
    spacing = dot_spacing(kept.points, kept.normals)
    index = linked_by_spacing(kept.points, kept.normals, 0.5, float((spacing**2).sum()))
    low = [k for k, (order, _) in enumerate(indices()) if order <= ORDER]
    alone = np.flatnonzero(form.molecule.residue_index[kept.atom] == LYSINE)
    assert own.places[LYSINE] == len(alone)
    z = describe_patches(index, kept.points[alone], PATCH_RADIUS, descriptor="rotation_robust")[0][:, low]
    np.testing.assert_allclose(own.moments[LYSINE, 0], z.mean(axis=0), rtol=1e-3)  # float16
    potential = compute_fields(["potential"], form.molecule, kept.points)["potential"]
    of_field = describe_fields_of_patches(index, kept.points[alone], potential[None], PATCH_RADIUS)[
        :, 0, low
    ].mean(axis=0)
    np.testing.assert_allclose(own.moments[LYSINE, -1, 1:], of_field[1:], atol=0.02)
    assert own.fields[LYSINE, -1] == pytest.approx(potential[alone].mean())
    # n = 0 is the mean of a field over the patch and keeps its sign; the field's own mean is over the residue's dots
    first = own.moments[:, 1 + MOMENT_FIELDS.index("charge"), 0]
    assert first[LYSINE] > 0 > first.min()
    assert np.corrcoef(first, own.fields[:, MOMENT_FIELDS.index("charge")])[0, 1] > 0.7


# Zamyatnin 1972, typed from the paper, in the order of the letters
SEQUENCE = "ARNDCQEGHILKMFPSTWYV"
SCALES = {
    "volume": "88.6 173.4 114.1 111.1 108.5 143.8 138.4 60.1 153.2 166.7 166.7 168.6 162.9 189.9 112.7 89 116.1 227.8 193.6 140",
    "aromaticity": "0 0 0 0 0 0 0 0 .6 0 0 0 0 1 0 0 0 1 1 0",
    "charge": "0 1 0 -1 0 0 -1 0 0 0 0 1 0 0 0 0 0 0 0 0",
}


def test_scales_of_residues_are_those_of_their_sources(form):
    """A molecule of one kind of residue has its value at every dot."""
    names = gemmi.expand_one_letter_sequence(SEQUENCE, gemmi.ResidueKind.AA)
    for k, residue in enumerate(names):
        alike = replace(form.molecule, residue_name=np.full_like(form.molecule.residue_name, residue))
        table = _fields(alike, form.surface.points[:3])
        for name, values in SCALES.items():
            assert table[name].to_numpy() == pytest.approx([float(values.split()[k])] * 3), (name, residue)


def test_a_surface_too_small_for_a_patch_is_a_sentence(form):
    few = form.surface.take(np.arange(0, len(form.surface), 50))
    with pytest.raises(InputError, match="one: no patch of 10 Å has 12 dots; use a larger surface"):
        describe_residues(few, form.molecule, "one")


def test_distances_are_standard_deviations_over_many_places():
    sd = spread_of_moments()
    assert sd.shape == (len(MOMENT_CHANNELS), 36) and sd.min() > 0
    first, second = np.random.default_rng(0).normal(size=(2, 4, *sd.shape))
    got = distances(first, second)
    for k in range(len(MOMENT_CHANNELS)):
        each = [((a - b) / s) ** 2 for a, b, s in zip(first[2, k], second[2, k], sd[k], strict=True)]
        assert got[2, k] == pytest.approx(np.sqrt(np.mean(each)))
    np.testing.assert_allclose(got[:, -1], np.sqrt((got[:, :-1] ** 2).mean(axis=1)))


def test_a_floor_is_exceeded_by_one_draw_in_twenty():
    """Residues that scatter unlike, with as many draws as a study has; some without places in some draws."""
    rng = np.random.default_rng(2)
    scale = rng.uniform(0.05, 0.5, 400)[:, None]
    draws = scale * np.sqrt(rng.chisquare(20, (11, 400, 7)) / 20)
    draws[:3, :40] = np.nan
    floor = floor_of(draws[1:])
    above = draws[0, 40:] > floor[40:]
    assert (
        0.04 < above.mean() < 0.07
    )  # 2,520 draws: 0.05 +- 0.009 (2 sd), a little more for a scale from ten draws
    assert np.isfinite(floor).all() and np.isnan(floor_of(np.full((5, 3, 7), np.nan))).all()
    draws[..., 2] = np.nan  # a field that no residue has
    with warnings.catch_warnings(action="error"):
        without = floor_of(draws[1:])
    assert np.isnan(without[:, 2]).all() and np.array_equal(np.delete(without, 2, 1), np.delete(floor, 2, 1))


def test_a_form_turned_stays_below_its_floor(form, own, found):
    turn = random_rotation(np.random.default_rng(9))
    molecule = replace(form.molecule, xyz=form.molecule.xyz @ turn + 20.0)
    other = describe_residues(form_of(molecule).surface, molecule, "turned")
    above = distances(own.moments, other.moments) > floor_of(found)
    # 30 residues x 7: 10.5 by chance, and neighbours are alike
    assert above.sum() <= 30 and above[:, -1].sum() <= 5
    assert (distances(own.moments, own.moments) == 0).all()


def test_atoms_are_moved_by_the_root_mean_square_displacement(form, own):
    """In all directions alike, and turned about their centre before dots are placed."""
    given = []

    def keep(xyz):
        given.append(xyz)
        return form.generate_surface(xyz)

    noise(form._replace(generate_surface=keep), own, np.random.default_rng(4), moved=0.3, draws=1)
    atoms = form.molecule.xyz[0]
    moved = given[0] @ random_rotation(np.random.default_rng(4)) + atoms.mean(axis=0) - atoms
    assert np.sqrt((moved**2).sum(axis=1).mean()) == pytest.approx(0.3, rel=0.05)
    np.testing.assert_allclose(np.sqrt((moved**2).mean(axis=0)), 0.3 / np.sqrt(3), rtol=0.12)


def test_a_mutation_shows_where_it_is(form, own, found):
    molecule, floor = form.molecule, floor_of(found)
    names = np.where(molecule.residue_index == LYSINE, "GLU", molecule.residue_name)
    mutant = describe_residues(form.surface, replace(molecule, residue_name=names), "mutant")
    change = distances(own.moments, mutant.moments)
    assert (change[:, 0] == 0).all()  # the same dots: only fields can change
    assert change[LYSINE, CHARGE] > 3 * floor[LYSINE, CHARGE] and change[LYSINE, -1] > floor[LYSINE, -1]
    assert (
        mutant.fields[LYSINE, MOMENT_FIELDS.index("charge")]
        < own.fields[LYSINE, MOMENT_FIELDS.index("charge")] - 0.5
    )
    atoms = [molecule.xyz[0][molecule.residue_index == k] for k in range(30)]
    gap = np.array([np.linalg.norm(each[:, None] - atoms[LYSINE], axis=2).min() for each in atoms])
    far = gap > 16  # Å: patches of 10 Å, and a field that is smooth over some Å
    assert far.sum() >= 5 and (change[far] < floor[far]).all()


def test_a_moved_side_chain_shows_where_it_is(form, own, found):
    molecule, floor = form.molecule, floor_of(found)
    side = (molecule.residue_index == LYSINE) & ~np.isin(
        molecule.name, ["N", "CA", "C", "O", "H", "HA", "CB"]
    )
    out = molecule.xyz[0][side].mean(axis=0) - molecule.xyz[0].mean(axis=0)
    xyz = molecule.xyz.copy()
    xyz[0][side] += 2.5 * out / np.linalg.norm(out)
    moved = replace(molecule, xyz=xyz)
    change = distances(own.moments, describe_residues(form_of(moved).surface, moved, "moved").moments)
    assert change[LYSINE, 0] > 1.5 * floor[LYSINE, 0] and change[LYSINE, -1] > 1.5 * floor[LYSINE, -1]
    gap = np.linalg.norm(
        [xyz[0][molecule.residue_index == k].mean(axis=0) for k in range(30)] - xyz[0][side].mean(axis=0),
        axis=1,
    )
    assert (gap > 25).sum() >= 3 and (change[gap > 25, -1] > floor[gap > 25, -1]).sum() <= 1


def test_a_table_holds_distances_floors_and_differences(form, own, monkeypatch):
    drawn = []

    def noise(form, own, rng, moved, draws, threads):
        drawn.append((form.name, moved, draws))
        of_residues = form.molecule.residues["residue"].to_numpy(float)[:, None] / 10_000  # 0.021 to 0.024
        return np.full((draws, len(of_residues), 7), of_residues + moved)

    monkeypatch.setattr(module, "noise", noise)
    names = np.where(form.molecule.residue_index == LYSINE, "GLU", form.molecule.residue_name)
    there = form.molecule.residue_index != 4  # so that later residues have another row in each form
    other = form_of(replace(form.molecule, residue_name=names).take(there), "two")
    table = changes(form, other, np.random.default_rng(0))
    numbers, rows = [k for k in range(209, 239) if k != 213], np.delete(np.arange(30), 4)
    assert table["residue"].tolist() == [*map(str, numbers)]
    assert drawn == [(name, *of_floor) for of_floor in ((0.0, 5), (0.3, 3)) for name in ("one", "two")]
    both = own, describe_residues(other.surface, other.molecule, "two")
    wanted, floors = distances(own.moments[rows], both[1].moments), np.array(numbers) / 10_000
    assert table["places_first"].tolist() == own.places[rows].tolist() != table["places_second"].tolist()
    assert table["places_second"].tolist() == both[1].places.tolist()
    np.testing.assert_allclose(table[[*MOMENT_CHANNELS, "total"]], wanted)
    for above, key, floor in (
        ("above", "total_floor", floors),
        ("above_moved", "total_moved", floors + module.RMS_DISPLACEMENT),
    ):
        np.testing.assert_allclose(table[key], floor)
        assert (table[above] == (wanted[:, -1] > floor)).all()
    assert table["above"].sum() > table["above_moved"].sum() > 0
    lysine = table.set_index("residue").loc["224"]
    assert lysine["residue_name_second"] == "GLU" and lysine["residue_name"] == "LYS"
    difference = both[1].fields - both[0].fields[rows]
    np.testing.assert_allclose(table[[f"{field}_difference" for field in MOMENT_FIELDS]], difference)


def test_a_buried_residue_has_no_change_and_is_not_called_missing(form, monkeypatch):
    monkeypatch.setattr(module, "noise", lambda *_: np.full((1, 30, 7), 0.02))
    exposed = form.molecule.residue_index[form.surface.atom] != LYSINE
    buried = form._replace(name="two", surface=form.surface.take(exposed))
    table = changes(form, buried, np.random.default_rng(0))
    assert table["residue"].tolist() == form.molecule.residues["residue"].tolist()
    row = table.iloc[LYSINE]
    assert np.isnan(row["total"]) and row["above"] == 0 and row["places_second"] == 0 < row["places_first"]
    assert table["total"].drop(LYSINE).notna().all() and unmatched_residues(form, buried) == ("", "")


def test_forms_share_residues_by_chain_and_number(form):
    molecule = form.molecule
    other = replace(molecule, chain=np.full_like(molecule.chain, "Z"))
    assert (numbered_alike(other, molecule).chain == molecule.chain).all()
    two = replace(molecule, chain=np.where(molecule.residue_index < 9, "X", "Y"))
    assert (numbered_alike(two, molecule).chain == two.chain).all()
    with pytest.raises(InputError, match="share 0 residues"):
        common_residues(form, form._replace(name="two", molecule=two))


def test_a_form_is_read_with_the_chain_of_the_first_and_named_where_residues_lack(tmp_path, caplog):
    """The second file has another chain, and begins with another residue."""
    files = {}
    for name, chain, first in (("open", "A", 2), ("closed", "B", 1)):
        path = write(
            tmp_path / f"{name}.pdb", peptide(("ALA", "LYS", "SER", "VAL", "GLY"), chain, first) + "END\n"
        )
        write_npz(tmp_path / f"{name}.npz", sparsurf.surface(path))
        files[name] = (tmp_path / f"{name}.npz", path)
    forms = module.read_forms("x", files, Settings().surface, 0.5)
    assert [form.name for form in forms] == ["open", "closed"]
    assert [{*form.molecule.chain} for form in forms] == [{"A"}] * 2
    for form, (surface, _) in zip(forms, files.values(), strict=True):
        for dots in (form.surface, form.generate_surface(form.molecule.xyz[0])):
            assert np.array_equal(dots.points, sparsurf.read_surface(surface).points)
    assert module.warn_of_unmatched(*forms) == ("A:6", "A:1")
    said = [record.getMessage() for record in caplog.records if "lacks" in record.getMessage()]
    assert [text.partition(",")[0] for text in said] == [
        "closed lacks residues A:6 of open",
        "open lacks residues A:1 of closed",
    ]
    with pytest.raises(InputError, match=r"changes\.x: both names"):
        module.read_forms("x", {"a": files["open"], "b": files["open"]}, Settings().surface, 0.5)


@pytest.mark.parametrize("straight", [False, True])
def test_forms_are_superposed_by_the_atoms_that_they_share(form, tmp_path, straight):
    """The second is turned, lacks a residue and an atom, and has its atoms in another order; C-alpha atoms may lie on a line."""
    text = peptide(("ALA", "LYS", "SER", "VAL", "GLY")) + "END\n"
    first = sparsurf.read_molecule(write(tmp_path / "a.pdb", text)) if straight else form.molecule
    there = (first.residue_index != 1) & ~((first.residue_index == 2) & (first.name == "CB"))
    order = np.lexsort((first.name, first.residue_index))
    order = order[there[order]]
    turned = first.xyz @ random_rotation(np.random.default_rng(3)) + 30.0
    second = replace(replace(first, xyz=turned).take(order), frame_number=np.zeros(1, int))
    if not straight:  # what one C-alpha atom does, the others outweigh; side chains do not count
        second.xyz[0][second.name == "CB"] += 5.0
    back = module.superpose_forms(second, first).xyz[0]
    same = second.name != "CB" if not straight else np.ones(len(order), bool)
    np.testing.assert_allclose(back[same], first.xyz[0][order][same], atol=1e-6)
    with pytest.raises(InputError, match="share 2 residues by chain and number, but need 3"):
        module.superpose_forms(second.take(second.residue_index < 2), first)
    if straight:
        alpha = second.take(second.name == "CA")
        with pytest.raises(InputError, match="lie on a line"):
            module.superpose_forms(alpha, first)


def test_residues_are_described_part_by_part_as_at_once(form, own, monkeypatch):
    monkeypatch.setattr(residue_moments, "PLACES_AT_ONCE", 70)
    parts = describe_residues(form.surface, form.molecule, "one", threads=2)
    assert own.places.sum() % 70 and own.places.sum() > 140
    for whole, of_parts in zip(own, parts, strict=True):
        np.testing.assert_array_equal(whole, of_parts)


def test_residues_of_one_form_only_are_ranges_that_select_them(form):
    # Form one has residues 209 to 238.
    trimmed = sparsurf.read_molecule(TOPOLOGY, residues="210-211,214,216-230,239-241")
    assert unmatched_residues(form, form_of(trimmed, "two")) == ("209,212-213,215,231-238", "239-241")
    assert unmatched_residues(form, form) == ("", "")
    residues = pd.DataFrame({"chain": list("AAABB"), "residue": ["1", "2", "5A", "6", "7"]})
    assert residue_ranges(residues, np.array([1, 1, 0, 1, 1], bool)) == "A:1-2,B:6-7"
    assert residue_ranges(residues, np.array([0, 1, 1, 1, 0], bool)) == "A:2-5A,B:6"
    assert residue_ranges(residues.assign(chain=""), np.array([1, 0, 0, 0, 1], bool)) == "1,7"
