"""Inputs with wrong lengths, directions, chains or archives: each is refused or told in one sentence, and good ones pass."""

import io
import logging
import signal
import time
import zipfile

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from peptides import atom_line, peptide
from sparsurf.api.inputs import as_dots
from sparsurf.cli.command import main
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface

STRUCTURE = ROOT / "data" / "tdp43" / "topology.pdb"
SECONDS = 20  # an answer that takes longer is none


@pytest.fixture(scope="module")
def molecule():
    """Fourteen residues without hydrogens."""
    return read_molecule(STRUCTURE, residues="209-222", hydrogens="remove")


@pytest.fixture(scope="module")
def dots(molecule):
    return molecular_surface(molecule.xyz[0], radii(molecule))


def answer(call, caplog, *arguments, **keys):
    """What a call says: its sentence if it refuses, else its warnings."""
    caplog.clear()
    with caplog.at_level(logging.WARNING, "sparsurf"):
        try:
            call(*arguments, **keys)
        except InputError as error:
            return f"refused: {error}"
    return caplog.text


# ---- dots


def written(path, points, normals, header="x,y,z,nx,ny,nz"):
    np.savetxt(path, np.column_stack([points, normals]), "%.4f", ",", header=header, comments="")
    return path


def flipped(share):
    def change(points, normals):
        wrong = np.random.default_rng(1).random(len(points)) < share
        return points, np.where(wrong[:, None], -normals, normals)

    return change


def random_normals(points, normals):
    rng = np.random.default_rng(2)
    other = rng.normal(size=normals.shape)
    other /= np.linalg.norm(other, axis=1)[:, None]
    return points, np.where(rng.random(len(points))[:, None] < 0.2, other, normals)


def last(share, points_times=1.0, normals_times=1.0):
    def change(points, normals):
        end = (np.arange(len(points)) >= (1 - share) * len(points))[:, None]
        return np.where(end, points_times * points, points), np.where(end, normals_times * normals, normals)

    return change


UPRIGHT, OPPOSE, LENGTHS = "do not stand upright", "oppose each other", "are lengths in Å"
CHANGES = {  # of points and normals, and what is said
    "nothing": (lambda p, n: (p, n), None),
    "turned": (lambda p, n: (p[:, [2, 0, 1]] + 30, n[:, [2, 0, 1]]), None),
    "columns of normals exchanged": (lambda p, n: (p, n[:, [1, 0, 2]]), UPRIGHT),
    "columns of points exchanged": (lambda p, n: (p[:, [1, 0, 2]], n), UPRIGHT),
    "columns in another order": (lambda p, n: (p, n[:, [2, 1, 0]]), UPRIGHT),
    "one axis mirrored": (lambda p, n: (p, n * [1, 1, -1]), UPRIGHT),
    "one axis in nm": (lambda p, n: (p * [0.1, 1, 1], n), UPRIGHT),
    "points inexact": (lambda p, n: (p + np.random.default_rng(0).normal(0, 0.5, p.shape), n), UPRIGHT),
    "normals of the next row": (lambda p, n: (p, np.roll(n, -1, axis=0)), "fit the dots 1 row further down"),
    "normals of the row before": (lambda p, n: (p, np.roll(n, 1, axis=0)), "fit the dots 1 row further up"),
    "normals two rows before": (lambda p, n: (p, np.roll(n, 2, axis=0)), "fit the dots 2 rows further up"),
    "one axis stretched": (lambda p, n: (p * [1, 1.5, 1], n), "times as far apart along one direction"),
    "one axis shrunk": (lambda p, n: (p * [1, 1, 0.6], n), "times as far apart along one direction"),
    "normals of another row": (lambda p, n: (p, np.roll(n, 7, axis=0)), OPPOSE),
    "every 20th flipped": (flipped(0.05), OPPOSE),
    "every 10th flipped": (flipped(0.1), "give outward normals"),
    "every 5th random": (random_normals, OPPOSE),
    "the last inward": (last(0.05, normals_times=-1), "some dots around"),
    "all inward": (lambda p, n: (p, -n), "normals point inwards"),
    "the last in nm": (last(0.1, points_times=0.1), "times as close as the others"),
    "half as long": (lambda p, n: (p / 2, n), LENGTHS),
    "twice as long": (lambda p, n: (2 * p, n), LENGTHS),
    "three times as long": (lambda p, n: (3 * p, n), LENGTHS),
    "five times as long": (lambda p, n: (5 * p, n), LENGTHS),
    "in Bohr": (lambda p, n: (1.8897 * p, n), LENGTHS),
    "in pm": (lambda p, n: (100 * p, n), LENGTHS),
    "in nm": (lambda p, n: (p / 10, n), "lengths seem to be nm"),
}


@pytest.mark.parametrize("name", CHANGES)
@pytest.mark.parametrize("form", ["file", "arrays"])
def test_dots_that_cannot_be_a_molecular_surface_are_reported(dots, caplog, tmp_path, name, form):
    change, words = CHANGES[name]
    points, normals = change(dots.points, dots.normals)
    if form == "file":
        said = answer(read_surface, caplog, written(tmp_path / "a.csv", points, normals))
    else:
        said = answer(as_dots, caplog, (points, normals))
    assert words in said if words else said == "", said


@pytest.mark.parametrize("share", [0.5, 0.3, 0.1, 0.05, 0.03])
def test_few_dots_are_judged_too(dots, caplog, tmp_path, share):
    few = np.random.default_rng(3).choice(len(dots), int(share * len(dots)), replace=False)
    points, normals = dots.points[few], dots.normals[few]
    for k, (times, words) in enumerate(
        [((1, 1, 1), ""), ((-1, -1, -1), "point inwards"), ((-1, 1, 1), UPRIGHT)]
    ):
        said = answer(read_surface, caplog, written(tmp_path / f"{k}.csv", points, normals * times))
        if share > 0.05 or words != UPRIGHT:
            assert words in said if words else said == "", said


@pytest.mark.parametrize(("density", "probe"), [(1.0, 1.4), (20.0, 1.4), (3.0, 0.8), (3.0, 3.0)])
def test_true_surfaces_of_every_kind_pass(molecule, caplog, tmp_path, density, probe):
    found = molecular_surface(molecule.xyz[0], radii(molecule), probe=probe, density=density)
    assert answer(read_surface, caplog, written(tmp_path / "a.csv", found.points, found.normals)) == ""


@pytest.mark.parametrize("n", [2, 49, 50, 3000])
def test_dots_in_one_place_are_refused_at_once(caplog, tmp_path, n):
    begin = time.monotonic()
    points, normals = np.tile([1.0, 2.0, 3.0], (n, 1)), np.random.default_rng(0).normal(size=(n, 3))
    normals /= np.linalg.norm(normals, axis=1)[:, None]
    assert "lie in one place" in answer(read_surface, caplog, written(tmp_path / "a.csv", points, normals))
    for call in (sparsurf.roughness, sparsurf.sample, sparsurf.minimal):
        assert "lie in one place" in answer(call, caplog, (points, normals))
    assert time.monotonic() - begin < SECONDS


def test_a_heap_of_dots_in_one_place_is_refused(dots, caplog):
    heap = np.arange(len(dots)) < 0.3 * len(dots)
    points = np.where(heap[:, None], dots.points[0], dots.points)
    assert "lie in one place" in answer(sparsurf.roughness, caplog, (points, dots.normals))


def test_a_file_that_repeats_each_dot_is_read_once(dots, caplog, tmp_path):
    path = written(tmp_path / "a.csv", *(np.repeat(each, 2, axis=0) for each in (dots.points, dots.normals)))
    said = answer(read_surface, caplog, path)
    assert "dots that occur twice are removed" in said and said.count("WARNING") == 1


# ---- arrays


@pytest.mark.parametrize(
    ("given", "words"),
    [
        ({"points": None}, "points has the shape"),
        ({"points": "dots.csv"}, "points holds something else than real numbers"),
        ({"points": 3}, "points holds something else"),
        ({"points": [[1, 2, 3], [1, 2]]}, "points holds something else"),
        ({"points": np.eye(3) * 1j}, "points holds something else than real numbers"),
        ({"normals": np.eye(3) + 0j}, "normals holds something else than real numbers"),
        ({"area": "large"}, "area holds something else"),
        ({"area": [None, 1, 1]}, "area that is NaN"),
        ({"kind": np.array(["SC"] * 3)}, "kind holds something else"),
        ({"atom": [0, 1, 2**31]}, "dot 3 has an atom that is no index"),
        ({"atom": [0, 1, 2e40]}, "dot 3 has an atom that is no index"),
        ({"fields": 3}, "fields must be a dictionary"),
        ({"fields": {1: [1, 2, 3]}}, "fields must be a dictionary of names"),
        *(
            ({"fields": {name: [1, 2, 3]}}, "a field cannot be called")
            for name in (
                "",
                "a b",
                "1a",
                "é",
                "q\n",
                "area",
                "Weight",
                "points",
                "self",
                "file",
                "allow_pickle",
            )
        ),
        ({"fields": {"a": "b"}}, "the field a holds something else"),
        ({"fields": {"a": np.ones(3) * 1j}}, "the field a holds something else than real numbers"),
        ({"area": np.ma.masked_array([1.0, 2, 3], [0, 1, 0])}, "area has masked values"),
        ({"points": np.eye(3) > 0}, "points holds True and False: give numbers"),
        ({"points": np.eye(3).astype("m8[s]")}, "points holds something else than real numbers"),
        ({"normals": np.eye(3, dtype=bool)}, "normals holds True and False"),
        ({"kind": [True, False, True]}, "kind holds True and False"),
    ],
)
def test_something_else_than_arrays_of_numbers_is_a_sentence(given, words):
    with pytest.raises(InputError, match=words):
        Surface(**({"points": np.eye(3), "normals": np.eye(3)} | given))
    if given.keys() <= {"points", "normals"}:
        with pytest.raises(InputError, match=words):
            as_dots((given.get("points", np.eye(3)), given.get("normals", np.eye(3))))


@pytest.mark.parametrize(
    "key", ["altloc", "hydrogens", "ligands", "chains", "residues", "selection", "model", "stride"]
)
@pytest.mark.parametrize("value", [np.zeros(3), 2.5, b"x", {"a": 1}])
def test_a_key_of_a_wrong_type_is_a_sentence(key, value):
    with pytest.raises(InputError):
        read_molecule(STRUCTURE, **{key: value})


def test_a_table_is_refused_with_another_molecule(molecule, dots):
    few = molecule.take(np.arange(20))
    moved = type(molecule)(**{**vars(molecule), "xyz": molecule.xyz + 50})
    placed = sparsurf.surface(molecule)
    assert len(placed.to_frame(molecule)) == len(placed) and len(dots.to_frame(molecule)) == len(dots)
    for surface in (placed, dots):
        for other in (few, moved):
            with pytest.raises(InputError, match="placed on other atoms"):
                surface.to_frame(other)
    with pytest.raises(InputError, match="atoms of the dots are unknown"):
        Surface(dots.points, dots.normals).to_frame(molecule)


# ---- molecules


def read(tmp_path, text, name="a.pdb", **keys):
    (tmp_path / name).write_text(text, encoding="latin-1")
    return read_molecule(tmp_path / name, **keys)


def test_an_alternate_location_drops_nothing_behind_ter(tmp_path):
    """The second molecule has the labels of the first."""
    first = "".join(peptide(["SER"], altloc=letter, first=1) for letter in "AB") + peptide(
        ["ALA"] * 3, first=2
    )
    second = peptide(["GLY"] * 4, origin=(0, 30, 0), altloc="A")
    found = read(tmp_path, f"{first}TER\n{second}TER\nEND\n")
    assert found.n_residues == 8 and found.n_atoms == 40


def lines_of(molecule, tmp_path):
    molecule.write_pdb(tmp_path / "true.pdb")
    return (tmp_path / "true.pdb").read_text().splitlines(keepends=True)


def with_xyz(line, xyz):
    return line[:30] + "".join(f"{value:8.3f}" for value in xyz) + line[54:]


def changed_molecule(molecule, tmp_path, change):
    """The PDB file of a molecule whose positions `change` has changed."""
    lines, xyz, k = lines_of(molecule, tmp_path), change(molecule.xyz[0].copy()), 0
    for number, line in enumerate(lines):
        if line.startswith("ATOM"):
            lines[number], k = with_xyz(line, xyz[k]), k + 1
    return "".join(lines)


def moved_atom(xyz):
    xyz[41] += [8, 0, 0]
    return xyz


def one_place(xyz):
    xyz[6] = xyz[5]
    return xyz


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda xyz: xyz, None),
        (lambda xyz: xyz * [1.12, 1, 1], "1.1"),
        (lambda xyz: xyz * 1.07, "times as long as usual along one direction"),
        (lambda xyz: xyz * [1, 1, 0.85], "times as long as usual along one direction"),
        (moved_atom, "Å from the nearest atom of its residue"),
        (one_place, "lie in one place (1 such pair)"),
    ],
)
def test_a_structure_that_is_stretched_or_damaged_is_reported(molecule, tmp_path, caplog, change, words):
    said = answer(read, caplog, tmp_path, changed_molecule(molecule, tmp_path, change))
    assert words in said if words else said == "", said


@pytest.mark.parametrize("code", ["", "A"])
def test_a_residue_twice_under_two_names_is_reported(molecule, tmp_path, caplog, code):
    lines = lines_of(molecule, tmp_path)
    twin = [
        line
        for line in lines
        if line[17:26].split()[-1:] == ["213"] and line[12:16].strip() in ("N", "CA", "C", "O", "CB")
    ]
    twin = [f"{line[:17]}ALA{line[20:26]}{code or ' '}{line[27:]}" for line in twin]
    after = max(k for k, line in enumerate(lines) if line[17:26].split()[-1:] == ["213"]) + 1
    said = answer(read, caplog, tmp_path, "".join(lines[:after] + twin + lines[after:]))
    assert "GLN 213" in said and f"ALA 213{code}" in said and "lie in one place; keep one of them" in said


def test_wrong_elements_are_reported_from_the_first_on(molecule, tmp_path, caplog):
    lines = lines_of(molecule, tmp_path)
    for k in (1, 20, 33):
        lines[k] = f"{lines[k][:76]} S{lines[k][78:]}"
    said = answer(read, caplog, tmp_path, "".join(lines))
    assert "has the element S; 3 atoms have an element that contradicts the name" in said


def two_chains(molecule):
    """Two copies, 60 Å apart, as chains A and B."""
    n = molecule.n_atoms
    names = {
        key: np.tile(getattr(molecule, key), 2)
        for key in ("name", "residue_name", "element", "residue", "kind")
    }
    index = np.concatenate([molecule.residue_index, molecule.residue_index + molecule.n_residues])
    xyz = np.concatenate([molecule.xyz, molecule.xyz + np.array([60, 0, 0])], axis=1)
    return type(molecule)(
        xyz, molecule.time_ps, molecule.frame_number, residue_index=index, chain=np.repeat(["A", "B"], n),
        b_factor=np.zeros(2 * n), **names,
    )  # fmt: skip


LATER = {  # what happens to the second chain in a later model
    "nothing": (lambda a, b: b + 1.0, None),
    "mirrored": (lambda a, b: b * [1, 1, -1], "B is a mirror image, of D-amino acids, in frame 1"),
    "shrunk": (
        lambda a, b: b.mean(axis=0) + 0.3 * (b - b.mean(axis=0)),
        "times as long as usual in frame 1",
    ),
    "stretched": (lambda a, b: b * [1, 1.15, 1], "B are 1.1"),
    "laid on the other": (lambda a, b: a + 0.05, "Å apart in frame 1"),
}


@pytest.mark.parametrize("name", LATER)
@pytest.mark.parametrize("kind", ["models", "dcd"])
def test_each_frame_is_checked_chain_by_chain(molecule, tmp_path, caplog, name, kind):
    change, words = LATER[name]
    both, n = two_chains(molecule), molecule.n_atoms
    frames = np.repeat(both.xyz, 3, axis=0)
    for frame in (1, 2):
        frames[frame, n:] = change(frames[frame, :n], frames[frame, n:] + 0.01 * frame)
    both.write_pdb(tmp_path / "top.pdb")
    if kind == "dcd":
        mdtraj = pytest.importorskip("mdtraj")
        mdtraj.Trajectory(frames / 10, mdtraj.load(tmp_path / "top.pdb").topology).save(
            str(tmp_path / "a.dcd")
        )
        said = answer(read_molecule, caplog, tmp_path / "top.pdb", tmp_path / "a.dcd")
    else:
        models = [
            changed_molecule(both, tmp_path, lambda _, xyz=xyz: xyz).replace("END\n", "") for xyz in frames
        ]
        text = "".join(f"MODEL {k + 1}\n{model}ENDMDL\n" for k, model in enumerate(models))
        said = answer(read, caplog, tmp_path, text + "END\n")
    assert words in said if words else said == "", said


def test_a_box_that_is_too_small_is_reported(molecule, tmp_path, caplog):
    """The second chain is moved by a vector of the wrong box, next to the first, and meets it."""
    mdtraj = pytest.importorskip("mdtraj")
    both, n = two_chains(molecule), molecule.n_atoms
    both.xyz[0, n:] += [44.0 - 60.0 + 0.2, 0, 0]
    both.write_pdb(tmp_path / "top.pdb")
    for edge, words in ((44.0, "Å apart"), (200.0, "")):
        box = np.full((1, 3), edge / 10)
        whole = mdtraj.Trajectory(
            both.xyz / 10, mdtraj.load(tmp_path / "top.pdb").topology, unitcell_lengths=box, unitcell_angles=np.full((1, 3), 90.0)
        )  # fmt: skip
        whole.save(str(tmp_path / "a.xtc"))
        said = answer(read_molecule, caplog, tmp_path / "top.pdb", tmp_path / "a.xtc")
        assert words in said if words else said == "", said


@pytest.mark.parametrize(
    ("unit", "expected"),
    [("femtosecond", 0.001), ("picosecond", 1.0), ("nanosecond", 1000.0), ("year", None)],
)
def test_times_of_netcdf_are_read_in_their_unit(molecule, tmp_path, unit, expected):
    from scipy.io import netcdf_file

    molecule.write_pdb(tmp_path / "top.pdb")
    with netcdf_file(tmp_path / "a.nc", "w", version=2) as file:
        file.Conventions, file.ConventionVersion = "AMBER", "1.0"
        file.createDimension("frame", 0)
        file.createDimension("spatial", 3)
        file.createDimension("atom", molecule.n_atoms)
        times = file.createVariable("time", "f4", ("frame",))
        times.units = unit
        places = file.createVariable("coordinates", "f4", ("frame", "atom", "spatial"))
        places.units = "angstrom"
        for k in range(3):
            times[k], places[k] = k, molecule.xyz[0] + k
    if expected is None:
        with pytest.raises(InputError, match="its times are in 'year'"):
            read_molecule(tmp_path / "top.pdb", tmp_path / "a.nc")
        return
    found = read_molecule(tmp_path / "top.pdb", tmp_path / "a.nc")
    np.testing.assert_allclose(found.time_ps, expected * np.arange(3))


# ---- archives


def damaged_member(content):
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w") as archive:
        archive.writestr("points.npy", content)
    return stream.getvalue()


HEADER = b"\x93NUMPY\x01\x00v\x00"
DAMAGED = {
    "no array": b"raw bytes",
    "a huge shape": HEADER
    + b"{'descr': '<f8', 'fortran_order': False, 'shape': (300000000000,), }".ljust(117)
    + b"\n",
    "a deep header": HEADER + (b"(" * 117) + b"\n",
    "no end": HEADER + b"{'descr': ".ljust(118),
    "a negative shape": HEADER
    + b"{'descr': '<f8', 'fortran_order': False, 'shape': (-1,), }".ljust(117)
    + b"\n",
}


@pytest.mark.parametrize("name", DAMAGED)
def test_a_damaged_member_of_an_archive_is_a_sentence(tmp_path, name):
    path = tmp_path / "a.npz"
    path.write_bytes(damaged_member(DAMAGED[name]))
    with pytest.raises(InputError, match="or damaged"):
        read_surface(path)


# ---- the terminal


def test_control_characters_of_a_file_do_not_reach_the_terminal(tmp_path, caplog, capsys):
    text = peptide() + atom_line("C1", "\x1b[3", residue="9", place=(0, 40, 0), record="HETATM") + "END\n"
    assert "residue name is '\\x1b[3'" in answer(read, caplog, tmp_path, text)
    assert main(["surface", str(tmp_path / "a.pdb"), "-o", str(tmp_path / "a.csv")]) == 1
    assert "\x1b" not in capsys.readouterr().err
    assert str(InputError("a\x1b[31mb\0\nc")) == "a\\x1b[31mb\\x00\nc"
    logging.getLogger("sparsurf").warning("%s is odd", "a\x1b[31m.pdb")
    assert "\x1b" not in caplog.text and "\\x1b[31m.pdb is odd" in caplog.text


# ---- files of others that the last release took without a word or answered with a traceback

TOPOLOGIES = {"two_bmir.dcd", "two_bscale.dcd", "two_bstretch.dcd", "wrongbox2.2.xtc"}
SILENT = {  # good, or what no check can notice
    "fs.nc",
}  # fmt: skip


def test_each_doubtful_file_is_refused_or_reported(shared, caplog, molecule, tmp_path):
    folder = shared / "data" / "bad" / "third"
    if not folder.is_dir():
        pytest.skip("no folder bad/third in the reference data")
    molecule.write_pdb(tmp_path / "top.pdb")
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail(f"no answer in {SECONDS} s"))
    silent = set()
    for path in sorted(folder.rglob("*.*")):
        if not path.is_file() or path.name == "top2.pdb":
            continue
        signal.alarm(SECONDS)
        if path.suffix == ".sites":  # of the search for sites, which is gone
            continue
        if path.parent.name == "traj":
            top = path.with_name("top2.pdb") if path.name in TOPOLOGIES else tmp_path / "top.pdb"
            said = answer(read_molecule, caplog, top, path)
        elif path.suffix in (".pdb", ".gro"):
            said = answer(read_molecule, caplog, path)
        else:
            said = answer(read_surface, caplog, path)
        signal.alarm(0)
        assert "\x1b" not in said and (not said or path.name in said)
        silent |= set() if said else {path.name}
    assert silent == SILENT
    assert read_molecule(folder / "struct" / "002_altloc_samelabel_TER.pdb").n_atoms == 238
    assert read_molecule(tmp_path / "top.pdb", folder / "traj" / "fs.nc").time_ps[1] == pytest.approx(0.001)
