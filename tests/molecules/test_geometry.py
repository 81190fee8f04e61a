"""Coordinates that no molecule can have are refused with the frame and the atoms; what real files hold passes."""

import logging
from dataclasses import replace

import mdtraj
import numpy as np
import pytest

from conftest import ROOT
from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules import geometry
from sparsurf.molecules.libraries import from_mdtraj
from sparsurf.molecules.read_molecule import read_molecule, read_study_structure

TOPOLOGY = ROOT / "data" / "tdp43" / "topology.pdb"
USED = ("N", "CA", "C", "CB")  # whose places make a residue L or D


@pytest.fixture(scope="module")
def molecule():
    """Fourteen residues in six frames, more than are looked at together (see `few_at_once`)."""
    read = read_molecule(TOPOLOGY, ROOT / "data" / "tdp43" / "trajectory.xtc", residues="209-222", stride=180)
    assert read.frame_number.tolist() == [0, 180, 360, 540, 720, 900]
    return replace(read, frame_number=np.arange(6))


@pytest.fixture(autouse=True)
def few_at_once(monkeypatch):
    monkeypatch.setattr(geometry, "FRAMES_AT_ONCE", 2)


def moved(molecule, frame, atoms, by):
    xyz = molecule.xyz.copy()
    xyz[frame, atoms] += by
    return replace(molecule, xyz=xyz)


def measured(checks, molecule, path="a.pdb"):
    """Run some of the checks."""
    geometry._run([*checks], molecule, path)


def refused(molecule, words, **keys):
    with pytest.raises(InputError, match=words):
        geometry.refuse_impossible(molecule, "run.xtc", **keys)


def test_a_sound_molecule_passes_and_turns_with_the_box(molecule):
    geometry.refuse_impossible(molecule, "run.xtc")
    turned = replace(molecule, xyz=molecule.xyz[:, :, [1, 2, 0]] + [900.0, -900, 0])
    geometry.refuse_impossible(turned, "run.xtc")


def test_a_residue_that_is_too_wide_is_named_with_its_frame_and_atom(molecule):
    atom = np.flatnonzero((molecule.residue == "213") & (molecule.name == "CG"))[0]
    refused(moved(molecule, 4, atom, 30.0), "GLN 213 .* in frame 4 .atom CG is farthest out")
    off = replace(molecule, xyz=np.add(molecule.xyz, [900, -900, 0]))
    refused(moved(off, 4, atom, [-30.0, 0, 0]), "GLN 213 .* in frame 4 .atom CG is farthest out")
    refused(replace(molecule, xyz=10 * molecule.xyz), "GLU 209 .* in frame 0 .* give lengths in nm")
    refused(replace(molecule, xyz=10 * molecule.xyz), "in the order of top.pdb", topology="top.pdb")
    own = molecule.residue == "213"
    for wide in (19.9, 20.1):  # whatever is bonded in the first frame, one atom is too far
        shift = np.array([wide, 0, 0]) * 1.2
        for _ in range(50):
            first = moved(molecule, 0, atom, shift)
            shift *= wide / np.linalg.norm(np.ptp(first.xyz[0, own], axis=0))
        if wide > 20:
            refused(first, "GLN 213 is 20 Å wide in frame 0 .atom CG is farthest out. instead of below 20 Å")
        else:
            geometry.refuse_impossible(first, "run.xtc")


def test_a_bond_that_breaks_in_a_later_frame_is_named(molecule):
    tail = molecule.residue_index >= 7  # shifted as a whole: only the bond to residue 6 tells
    refused(moved(molecule, 5, tail, 6.0), "the bond C-N of .* in frame 5")
    refused(moved(molecule, 4, tail, 900.0), r"lies [89]\d\d Å from the other atoms in frame 4; give")
    ring = np.flatnonzero((molecule.residue == "214") & (molecule.name == "OH"))[0]
    refused(moved(molecule, 3, ring, [0, 0, 5.0]), "the bond CZ-OH of TYR 214 .* in frame 3")
    end = molecule.xyz[3, np.flatnonzero((molecule.residue == "214") & (molecule.name == "CZ"))[0]]
    bond = molecule.xyz[3, ring] - end
    stretched = [end + long / np.linalg.norm(bond) * bond - molecule.xyz[3, ring] for long in (2.95, 3.05)]
    geometry.refuse_impossible(moved(molecule, 3, ring, stretched[0]), "run.xtc")
    refused(moved(molecule, 3, ring, stretched[1]), "the bond CZ-OH of TYR 214 is 3.[01] Å long in frame 3")
    geometry.refuse_impossible(moved(molecule, 3, ring, [0, 0, 5.0]), "run.xtc", whole=False)
    refused(moved(molecule, 1, ring, [0, 0, 5.0]), "the bond CZ-OH of TYR 214 .* in frame 1")


def test_another_order_of_the_atoms_is_refused(molecule):
    rng = np.random.default_rng(5)
    inside = np.concatenate(
        [rng.permutation(np.flatnonzero(molecule.residue_index == k)) for k in range(molecule.n_residues)]
    )  # no residue is wider than before
    refused(replace(molecule, xyz=molecule.xyz[:, inside]), "of the bonds that its names imply")


def test_equal_residues_in_another_order_are_refused(tmp_path, caplog):
    lines = peptide(["ALA"] * 20).splitlines(keepends=True)

    def mixed(order):
        atoms = np.arange(100).reshape(20, 5)[order].ravel()
        text = "".join(line[:30] + lines[atom][30:] for line, atom in zip(lines, atoms, strict=True))
        return read_molecule(write(tmp_path / "a.pdb", text + "END\n"))

    swapped = [1, 0, 2, 4, 3, 5, 7, 6, 8, 10, 9]  # three bonds of each swap are gone, two of the first
    for order, share in (
        (np.random.default_rng(5).permutation(20), r"\d"),
        ([*swapped, *range(11, 20)], "42"),
    ):
        words = f"only {share}% of the bonds that its names imply exist in frame 0; copy it"
        with pytest.raises(InputError, match=words):
            mixed(order)
    assert (
        mixed([*swapped[:5], *range(5, 20)]).n_residues == 20 and "5 peptide bonds are missing" in caplog.text
    )


def test_a_part_far_away_is_refused_and_two_chains_of_a_crystal_are_not(tmp_path):
    near = peptide() + peptide(chain="B", origin=(0, 300, 0)) + "END\n"
    assert read_molecule(write(tmp_path / "near.pdb", near)).n_residues == 8
    far = peptide(["ALA"] * 9) + peptide(chain="B", origin=(0, 600, 0)) + "END\n"
    with pytest.raises(InputError, match=r"of ALA 1 B lies 58\d Å from the other atoms in frame 0"):
        read_molecule(write(tmp_path / "far.pdb", far))


@pytest.mark.parametrize(
    ("places", "gap"),
    [
        ([[0, 0, 0]], (0, 0)), ([[0, 0, 0], [0, 7, 0]], (7, 1)), ([[0, 1, 1], [0, 0, 1], [0, 9, 1]], (8, 2)),
        ([[0, 0, 9], [0, 0, 10], [0, 0, 0]], (9, 2)),
    ],
)  # fmt: skip
def test_the_widest_gap_and_a_place_on_its_emptier_side(places, gap):
    assert geometry.widest_gap(np.array(places, float)) == gap


@pytest.mark.parametrize(
    ("far", "words"),
    [
        (9.9e4, ""),
        (1.1e5, "not numbers or beyond 1e.05 Å in frame 1:"),
        (np.nan, "in frame 1:"),
        (3, "all atoms at one position"),
    ],
)
def test_numbers_that_no_atom_has_are_refused(far, words):
    xyz = np.array([[[1, 2, 3], [2, 2, 3]], [[1, 2, 3], [1, 2, far]], [[1, 2, 3], [1, 2, 4.0]]])
    if not words:
        return geometry.refuse_invalid_coordinates(xyz, "a.xtc")
    with pytest.raises(InputError, match=words):
        geometry.refuse_invalid_coordinates(xyz, "a.xtc")


@pytest.mark.parametrize(
    ("first", "second", "usual"),
    [("N", "CA", 1.46), ("CA", "C", 1.525), ("C", "O", 1.23), ("C4'", "C3'", 1.52), ("P", "O5'", 1.59)],
)
@pytest.mark.parametrize("frame", [0, 3])
def test_ten_bonds_of_a_backbone_tell_its_unit(molecule, caplog, first, second, usual, frame):
    def given(share, count):
        """As many residues and one atom more, in four frames; one of them has bonds of other lengths."""
        xyz = np.tile(np.random.default_rng(1).normal(size=(count + 1, 1, 3)), (4, 1, 2, 1)) * 30
        xyz[:, :, 1, 2] += usual
        xyz[frame, :, 1, 2] += (share - 1) * usual
        names = np.array([first, second] * (count + 1))[:-1]
        index = np.repeat(np.arange(count + 1), 2)[:-1]
        return replace(molecule, xyz=xyz.reshape(4, -1, 3)[:, :-1], name=names, residue_index=index)

    measured(geometry._checks_of_lengths(sound := given(1.0, 10), ""), sound)
    measured(geometry._checks_of_lengths(few := given(1.5, 9), ""), few)
    assert not caplog.messages
    measured(geometry._checks_of_lengths(odd := given(1.1, 10), ""), odd)
    told = f"a.pdb: half of the bonds of the backbone differ by 10 % from their usual length in frame {frame}"
    assert caplog.messages == [told]
    with pytest.raises(
        InputError, match=f"are 1.20 times as long as usual in frame {frame}, and half .* by 20%"
    ):
        measured(geometry._checks_of_lengths(wrong := given(1.2, 10), ""), wrong)


@pytest.mark.parametrize(("count", "refused"), [(9, False), (10, True)])
def test_ten_atoms_without_bonds_are_no_molecule(tmp_path, count, refused):
    lines = peptide(["ALA"] * 2).splitlines(keepends=True)[:count]
    apart = [f"{line[:30]}{3.0 * k:8.3f}{k % 3:8.3f}{k % 4:8.3f}{line[54:]}" for k, line in enumerate(lines)]
    path = write(tmp_path / "a.pdb", "".join(apart))
    if not refused:
        assert read_molecule(path).n_atoms == count
    else:
        with pytest.raises(InputError, match="only 0% of the bonds that its names imply"):
            read_molecule(path)


@pytest.mark.parametrize("kind", ["xtc", "dcd", "trr", "nc"])
def test_zeroed_coordinates_of_a_trajectory_are_refused(tmp_path, kind):
    every = mdtraj.load(str(TOPOLOGY))
    frames = mdtraj.join([every] * 3)
    frames.xyz[2, 100:300] = 0.0
    frames.save(str(tmp_path / f"a.{kind}"))
    with pytest.raises(InputError, match=rf"a\.{kind}.* in frame 2"):
        read_molecule(TOPOLOGY, tmp_path / f"a.{kind}")
    with pytest.raises(InputError, match="in frame 2"):
        from_mdtraj(frames)


# --- what is said where a file or a key holds more or less than it announces ----------------------------


def warned(caplog, *arguments, **keys):
    caplog.clear()
    with caplog.at_level(logging.WARNING, "sparsurf"):
        read_molecule(*arguments, **keys)
    return caplog.text


def test_residues_that_are_not_there_are_reported(caplog):
    assert "has no residue 1 of '1-222'" in warned(caplog, TOPOLOGY, residues="1-222")
    assert "has no residue 200 and 300 of '200-300'" in warned(caplog, TOPOLOGY, residues="200-300")
    assert "has no residue" not in warned(caplog, TOPOLOGY, residues="209-222,240")


def test_alternate_locations_that_are_not_there_are_reported(caplog):
    assert "altloc Q changes nothing" in warned(caplog, TOPOLOGY, altloc="Q")
    assert "altloc" not in warned(caplog, TOPOLOGY, altloc="highest")


@pytest.mark.parametrize(
    ("again", "words"),
    [((4,), "1 atom is repeated in its residue"), ((3, 4), "2 atoms are repeated in their")],
)
def test_atoms_that_stand_twice_are_counted(tmp_path, caplog, again, words):
    lines = peptide().splitlines(keepends=True)
    text = "".join([*lines[:5], *(lines[k] for k in again), *lines[5:], "END\n"])
    assert f"a.pdb: {words}" in warned(caplog, write(tmp_path / "a.pdb", text))


def test_models_that_are_announced_and_missing_are_reported(tmp_path, caplog):
    models = "".join(f"MODEL        {k}\n{peptide()}ENDMDL\n" for k in (1, 2)) + "END\n"
    path = write(tmp_path / "a.pdb", f"NUMMDL    3\n{models}")
    assert "a.pdb announces 3 models and holds 2" in warned(caplog, path)
    assert "announces" not in warned(caplog, write(tmp_path / "b.pdb", f"NUMMDL    2\n{models}"))


@pytest.mark.parametrize("kind", ["nc", "xtc", "trr", "dcd", "xyz"])
def test_a_trajectory_that_is_written_twice_is_reported(tmp_path, caplog, kind):
    every = mdtraj.load(str(TOPOLOGY))
    once = mdtraj.join([every] * 3)
    once.xyz = once.xyz + 0.01 * np.arange(3)[:, None, None]
    once.time = np.arange(3.0)
    once.save(str(tmp_path / f"once.{kind}"))
    assert "repeats" not in warned(caplog, TOPOLOGY, tmp_path / f"once.{kind}")
    twice = mdtraj.join([once, once])
    twice.save(str(tmp_path / f"twice.{kind}"))
    assert "its second half repeats the first" in warned(caplog, TOPOLOGY, tmp_path / f"twice.{kind}")
    odd = mdtraj.join([twice, once[1]])  # and one frame more
    odd.save(str(tmp_path / f"odd.{kind}"))
    assert "its second half repeats the first" in warned(caplog, TOPOLOGY, tmp_path / f"odd.{kind}")


def test_time_that_goes_back_is_reported(tmp_path, caplog):
    frames = mdtraj.join([mdtraj.load(str(TOPOLOGY))] * 4)
    frames.xyz = frames.xyz + 0.01 * np.arange(4)[:, None, None]
    frames.time = np.array([0.0, 1, 0, 1])
    frames.save(str(tmp_path / "a.xtc"))
    assert "time goes back to 0 ps at frame 2" in warned(caplog, TOPOLOGY, tmp_path / "a.xtc")
    frames.time = np.array([0.0, 1, 1, 2])
    frames.save(str(tmp_path / "b.xtc"))
    assert "goes back" not in warned(caplog, TOPOLOGY, tmp_path / "b.xtc")
    assert np.isnan(read_molecule(TOPOLOGY, tmp_path / "b.xtc").time_ps).all()  # no time of any frame is sure


def test_a_lactam_bridge_is_no_missing_atom(tmp_path, caplog):
    """The atom that leaves when side chains of a polymer join is not missing; a bond to a metal excuses none."""
    whole = peptide(["ALA", "ALA", "ALA", "ALA", "ALA"])
    lacking = "".join(line for k, line in enumerate(whole.splitlines(keepends=True)) if k != 14)  # CB of 3
    bridge = "LINK         CG  ALA A   3                 NZ  ALA A   5     1555   1555  1.33\n"
    metal = bridge.replace(" NZ  ALA A   5", "ZN    ZN A   9")
    assert "1 residue lacks heavy atoms, the first is ALA A 3" in warned(
        caplog, write(tmp_path / "a.pdb", lacking)
    )
    caplog.clear()  # of a file that a study wrote itself, it was said before
    assert read_study_structure(tmp_path / "a.pdb").n_atoms == 24 and not caplog.text
    assert "lack" not in warned(caplog, write(tmp_path / "b.pdb", bridge + lacking))
    assert "lack" not in warned(
        caplog, write(tmp_path / "two.pdb", bridge + bridge.replace("3  ", "1  ", 1) + lacking)
    )
    assert "1 residue lacks" in warned(caplog, write(tmp_path / "c.pdb", metal + lacking))
    short = "".join(
        line
        for line in lacking.splitlines(keepends=True)
        if line[12:16] != " O  " or "   3" not in line[22:26]
    )
    assert "1 residue lacks" in warned(caplog, write(tmp_path / "d.pdb", bridge + short))


def test_lengths_that_are_not_those_of_bonds_are_refused(molecule):
    """Coordinates stretched or shrunk, a column of zeros, whole numbers: each atom still has a neighbour."""
    xyz = molecule.xyz - molecule.xyz.mean(axis=1, keepdims=True)
    for change, times in (
        (1.25 * xyz, "1.25"),
        (0.8 * xyz, "0.80"),
        (xyz.round(), ""),
    ):
        refused(replace(molecule, xyz=change), rf"backbone are {times}\S* times as long as usual in frame 0")
    flat = xyz.copy()
    flat[3, :, 1] = 0.0
    refused(replace(molecule, xyz=flat), "one plane in frame 3")
    late = np.concatenate([xyz[:5], 1.25 * xyz[5:]])
    refused(replace(molecule, xyz=late), "as usual in frame 5")
    few = molecule.take(molecule.residue_index < 1)
    geometry.refuse_impossible(replace(few, xyz=1.25 * few.xyz), "few.pdb")


def test_elements_that_are_not_those_of_the_names_are_refused(molecule):
    refused(replace(molecule, element=np.full(molecule.n_atoms, "C")), "N of GLU 209 has the element C")
    one = molecule.element.copy()
    one[3] = "O"
    geometry.refuse_impossible(replace(molecule, element=one), "run.xtc")
    for other, every in (("SE", 5), ("D", 1)):  # selenium may be in place of sulfur; deuterium is hydrogen
        at = (np.arange(molecule.n_atoms) % every == 0) & ((other == "SE") | (molecule.element == "H"))
        assert at.any()
        elements = np.where(at, other, molecule.element)
        names = np.where(at & (other == "D"), "D", molecule.name)
        geometry.refuse_impossible(replace(molecule, element=elements, name=names), "run.xtc")


@pytest.mark.parametrize(
    ("atoms", "wrong", "words"), [(20, 2, ""), (20, 3, "CA of ALA 1 A"), (10, 2, "CA of ALA 1 A"), (9, 2, "")]
)
def test_more_than_a_tenth_of_ten_elements_or_more_is_refused(molecule, atoms, wrong, words):
    names = np.array(["N", "CA", "C", "O", "CB"] * 4)[:atoms]
    elements = np.array([name[0] for name in names])
    elements[[1, 6, 11][:wrong]] = "O"
    same = {
        key: np.full(atoms, each) for key, each in (("residue_name", "ALA"), ("residue", "1"), ("chain", "A"))
    }
    given = replace(molecule, name=names, element=elements, **same)
    if not words:
        return geometry._check_elements(given, "a.pdb")
    with pytest.raises(
        InputError, match=f"a.pdb: {words} has the element O; {wrong} atoms have an element that contradicts"
    ):
        geometry._check_elements(given, "a.pdb")


def test_one_bond_of_another_length_is_reported_with_its_frame(molecule, caplog):
    ca = int(np.flatnonzero((molecule.name == "CA") & (molecule.residue == "214"))[0])
    n = int(np.flatnonzero((molecule.name == "N") & (molecule.residue == "214"))[0])
    along = molecule.xyz[4, ca] - molecule.xyz[4, n]
    length = np.linalg.norm(along)
    for wanted, words in ((1.46 * 1.3, "1.9 Å"), (1.46 * 0.7, "1.0 Å"), (1.46 * 1.2, "")):
        caplog.clear()
        other = moved(molecule, 4, ca, along / length * (wanted - length))
        measured([*geometry._checks_of_bonds(other)][:1], other, "a.xtc")
        bond = f"a.xtc: the bond N-CA of TYR 214 is {words} long instead of 1.5 Å in frame 4"
        assert [text.partition(";")[0] for text in caplog.messages] == [bond] * bool(words)


def test_coordinates_that_were_changed_a_little_are_reported(molecule, caplog):
    """All bonds 5 % long, and noise of 0.2 Å."""
    shaken = molecule.xyz + np.random.default_rng(0).normal(0, 0.2 / 3**0.5, molecule.xyz.shape)
    for xyz, words in (
        (1.05 * molecule.xyz, "differ by 5 %"),
        (shaken, "half of the bonds"),
        (1.02 * molecule.xyz, ""),
    ):
        caplog.clear()
        geometry.refuse_impossible(replace(molecule, xyz=xyz), "a.pdb")
        assert words in caplog.text and bool(words) == bool(caplog.text)


def test_what_is_hardly_ever_meant_is_reported(molecule, caplog):
    def told(given):
        caplog.clear()
        with caplog.at_level(logging.WARNING):
            geometry.refuse_impossible(given, "a.pdb")
        return caplog.text

    assert told(molecule) == ""
    assert "differ by 10 % from their usual length in frame 0" in told(
        replace(molecule, xyz=1.1 * molecule.xyz)
    )
    mirrored = replace(molecule, xyz=molecule.xyz * [1, 1, -1])
    assert "mirror image" in told(mirrored)
    residues = molecule.residue_index[molecule.name == "CB"]
    for last, words in ((residues[9], "mirror image"), (residues[8], "")):  # ten residues tell it
        few = told(mirrored.take(molecule.residue_index <= last))
        assert words in few and bool(words) == bool(few)
    for each in (molecule, mirrored):  # without C-beta nothing does
        assert told(each.take(np.isin(molecule.name, ["N", "CA", "C", "O"]))) == ""
    for most, words in ((217, "mirror image"), (212, "")):  # D-amino acids up to there: 8 and 4 of 13
        xyz = molecule.xyz.copy()
        for residue in range(209, most + 1):
            own = {
                name: np.flatnonzero((molecule.residue == str(residue)) & (molecule.name == name))
                for name in USED
            }
            if all(map(len, own.values())):
                n, ca, c, cb = (xyz[:, own[name][0]] for name in USED)
                across = np.cross(n - ca, c - ca)
                across /= np.linalg.norm(across, axis=1)[:, None]
                xyz[:, own["CB"][0]] -= 2 * ((cb - ca) * across).sum(axis=1)[:, None] * across
        assert words in told(replace(molecule, xyz=xyz)) and bool(words) == ("mirror" in caplog.text)
    assert "a single atom" in told(molecule.take([4]))
    names = {
        key: np.tile(getattr(molecule, key), 2)
        for key in ("name", "residue_name", "element", "residue", "kind")
    }
    index = np.concatenate([molecule.residue_index, molecule.residue_index + molecule.n_residues])
    chain = np.repeat(["A", "B"], molecule.n_atoms)
    for shift, words in ((1.0, "100 % of its atoms lie inside other residues"), (40.0, "")):
        both = np.concatenate([molecule.xyz, molecule.xyz + shift * np.array([2, 2, 1]) / 3], axis=1)
        twice = replace(
            molecule, xyz=both, residue_index=index, chain=chain, b_factor=np.zeros(len(chain)), **names
        )
        assert words in told(twice) and bool(words) == bool(told(twice))
        few = told(twice.take((index < molecule.n_residues) | (index >= 2 * molecule.n_residues - 2)))
        assert ("of its atoms lie inside other residues" in few) == bool(words)  # a quarter of them
    apart = molecule.xyz + np.where(molecule.residue_index >= 7, 9.0, 0.0)[:, None]
    assert "1 peptide bond is missing, the first between GLY 215" in told(replace(molecule, xyz=apart))
