"""One molecule in every format: the same atoms, names, residues, chains, elements, positions, fields and dots."""

from dataclasses import replace
from functools import partial

import gemmi
import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st
from scipy.io import netcdf_file

import formats
import sparsurf
from conftest import ROOT
from sparsurf.errors import InputError
from sparsurf.molecules.atom_table import box_vectors
from sparsurf.molecules.names import usual_names
from sparsurf.molecules.read_molecule import MOLECULE_READERS, read_molecule
from sparsurf.molecules.source import open_source
from sparsurf.molecules.text_frames import frames_of_text
from sparsurf.surfaces.radii import RADII
from sparsurf.surfaces.spheres import read_spheres

FIELDS = ("hydropathy", "potential", "hbond")
NAMES = ("name", "residue_name", "element", "residue_index", "kind")


@pytest.fixture(scope="module")
def example():
    """Two frames of 14 residues, in the names of CHARMM, with positions that every format holds without rounding."""
    whole = read_molecule(
        ROOT / "data" / "tdp43" / "topology.pdb", ROOT / "data" / "tdp43" / "trajectory.xtc",
        residues="209-222", stride=1000,
    )  # fmt: skip
    return replace(whole, xyz=whole.xyz[:2].round(2), chain=np.full(whole.n_atoms, "A"))


def write_all(folder, molecule):
    """Write the molecule in all formats: name -> files, whether they have the chain, all labels, and both frames."""
    plain = folder / "plain.pdb"
    molecule.write_pdb(plain)
    files = {"PDB": ([plain], True, True, 1)}
    document = gemmi.read_structure(str(plain))
    document.setup_entities()
    document.make_mmcif_document().write_file(str(folder / "a.cif"))
    files["mmCIF"] = [folder / "a.cif"], True, True, 1
    for name, write in (
        ("gro", formats.gro),
        ("xyz", formats.xyz),
        ("mdcrd", formats.mdcrd),
        ("data", formats.lammps_data),
    ):
        write(folder / f"a.{name}", molecule)
    formats.card(folder / "a.crd", molecule)
    formats.card(folder / "extended.crd", molecule, extended=True)
    formats.psf(folder / "a.psf", molecule)
    formats.psf(folder / "short.psf", molecule, extended=False)
    formats.parm7(folder / "a.parm7", molecule)
    formats.parm7(folder / "bare.parm7", molecule, labels=False)
    formats.restart(folder / "a.rst7", molecule)
    formats.restart(folder / "inpcrd.crd", molecule, velocities=False)
    formats.mdcrd(folder / "box.crd", molecule, box=True)
    formats.lammps_dump(folder / "a.lammpstrj", molecule)
    formats.lammps_dump(folder / "scaled.dump", molecule, scaled=True)
    for name in ("xtc", "trr", "dcd", "nc", "h5"):
        formats.of_mdtraj(folder / f"a.{name}", molecule)
    formats.of_mdtraj(folder / "a.ncrst", molecule.frame(0))
    files["GRO"] = [folder / "a.gro"], False, False, 2
    files["HDF5"] = [folder / "a.h5"], True, False, 2
    files["CARD"] = [folder / "a.crd"], True, True, 1
    files["CARD, extended"] = [folder / "extended.crd"], True, True, 1
    files["PSF, PDB"] = [folder / "a.psf", plain], True, True, 1
    files["parm7 without labels, NetCDF"] = [folder / "bare.parm7", folder / "a.nc"], False, False, 2
    for topology, frames in (
        ("a.psf", "a.dcd"), ("short.psf", "a.xtc"), ("a.parm7", "a.nc"), ("a.parm7", "a.trr"),
    ):  # fmt: skip
        files[f"{topology}, {frames}"] = [folder / topology, folder / frames], True, True, 2
    for frames, n in (
        ("a.mdcrd", 2), ("box.crd", 2), ("a.rst7", 1), ("inpcrd.crd", 1), ("a.ncrst", 1), ("a.xyz", 2), ("a.lammpstrj", 2),
        ("scaled.dump", 2), ("a.data", 1), ("a.gro", 2), ("a.crd", 1),
    ):  # fmt: skip
        files[f"PDB, {frames}"] = [plain, folder / frames], True, True, n
    return files


@given(first=st.integers(-20, 9980), chain=st.sampled_from("ABx7"), code=st.booleans())
@settings(max_examples=2, suppress_health_check=[HealthCheck.function_scoped_fixture])
@pytest.mark.filterwarnings("ignore")
def test_every_format_has_the_same_molecule(example, tmp_path_factory, first, chain, code):
    numbers = [str(first + k) for k in range(example.n_residues)]
    if code:
        numbers[3:5] = [f"{numbers[2]}A", f"{numbers[2]}B"]
    molecule = replace(
        example, residue=np.array(numbers)[example.residue_index], chain=np.full(example.n_atoms, chain)
    )
    for name, (paths, has_chain, has_labels, n_frames) in write_all(
        tmp_path_factory.mktemp("a"), molecule
    ).items():
        found = read_molecule(*paths)
        assert found.n_frames == n_frames, name
        for column in NAMES:
            assert np.array_equal(getattr(found, column), getattr(molecule, column)), (name, column)
        if has_chain:
            assert set(found.chain) == {chain}, name
        if has_labels:
            assert np.array_equal(found.residue, molecule.residue), name
        np.testing.assert_allclose(found.xyz, molecule.xyz[:n_frames], atol=2e-5, err_msg=name)


@pytest.mark.filterwarnings("ignore")
def test_every_format_has_the_same_dots_and_fields(example, tmp_path):
    files = write_all(tmp_path, example)
    expected = sparsurf.surface(files["PDB"][0][0], density=1.0)
    fields = sparsurf.fields(expected, FIELDS)
    for name in ("mmCIF", "GRO", "HDF5", "CARD", "a.psf, a.dcd", "a.parm7, a.nc", "PDB, scaled.dump"):
        dots = sparsurf.surface(read_molecule(*files[name][0]), density=1.0)
        assert np.array_equal(dots.points, expected.points), name
        np.testing.assert_allclose(sparsurf.fields(dots, FIELDS), fields, atol=1e-3, err_msg=name)


@pytest.mark.parametrize("kind", ["gro", "crd", "xyz", "dcd", "xtc", "trr", "nc", "pdb"])
@pytest.mark.filterwarnings("ignore")
def test_files_that_mdanalysis_writes_are_read(example, tmp_path, kind):
    mda = pytest.importorskip("MDAnalysis", reason="MDAnalysis is installed by the extra `interop`")
    plain, path = tmp_path / "plain.pdb", tmp_path / f"a.{kind}"
    example.write_pdb(plain)
    mda.Universe(str(plain)).atoms.write(str(path))
    is_whole = kind in ("gro", "crd", "pdb")
    found = read_molecule(path) if is_whole else read_molecule(plain, path)
    for column in (*NAMES, "residue"):
        assert np.array_equal(getattr(found, column), getattr(example, column)), column
    np.testing.assert_allclose(found.xyz, example.xyz[:1], atol=2e-5)


@pytest.mark.parametrize("kind", ["gro", "rst7", "ncrst", "cif", "pdb", "mdcrd"])
@pytest.mark.filterwarnings("ignore")
def test_files_that_parmed_writes_are_read(example, tmp_path, kind):
    parmed = pytest.importorskip("parmed", reason="ParmEd is installed by the extra `writers`")
    plain, path = tmp_path / "plain.pdb", tmp_path / f"a.{kind}"
    example.write_pdb(plain)
    structure = parmed.load_file(str(plain))
    if kind == "mdcrd":
        frames = parmed.amber.AmberMdcrd(str(path), example.n_atoms, hasbox=False, mode="w")
        frames.add_coordinates(structure.coordinates)
        frames.close()
    else:
        structure.save(str(path))
    is_whole = kind in ("gro", "cif", "pdb")
    found = read_molecule(path) if is_whole else read_molecule(plain, path)
    for column in NAMES:  # ParmEd numbers the residues anew
        assert np.array_equal(getattr(found, column), getattr(example, column)), column
    np.testing.assert_allclose(found.xyz, example.xyz[:1], atol=1e-3)


@pytest.mark.parametrize("title", ["Ångström".encode(), "Å".encode("latin-1"), b"\x85 \x0c"])
@pytest.mark.filterwarnings("ignore")
def test_content_is_recognised_behind_a_title_and_a_mark_of_any_encoding(example, tmp_path, title):
    write_all(tmp_path, example)
    path = tmp_path / "unnamed"
    for name in (
        "a.gro",
        "a.crd",
        "extended.crd",
        "a.psf",
        "a.xyz",
        "a.mdcrd",
        "a.rst7",
        "a.lammpstrj",
        "a.data",
    ):
        content = (tmp_path / name).read_bytes()
        for word in (b"title", b"comment"):
            content = content.replace(word, word + b" " + title, 1)
        for changed in (content, b"\xef\xbb\xbf" + content, content.replace(b"\n", b"\r")):
            path.write_bytes(changed)
            source = open_source(path)
            assert source.recognised and source.format == open_source(tmp_path / name).format, name
            if source.format.places:
                pair = [path] if source.format.atoms else [tmp_path / "plain.pdb", path]
                np.testing.assert_allclose(
                    read_molecule(*pair).xyz[0], example.xyz[0], atol=2e-5, err_msg=name
                )


def test_fields_do_not_depend_on_how_a_program_spells_names(example):
    usual = replace(example, name=usual_names(example.residue_name, example.name))
    assert {"HN", "CD"} <= {*example.name} and {"H", "CD1", "HB3"} <= {*usual.name} and "HN" not in usual.name
    last = example.residue_index.max()
    end = np.flatnonzero((example.residue_index == last) & (example.name == "O"))
    charmm = replace(example, name=np.where(np.arange(example.n_atoms) == end, "OT1", example.name))
    dots = [sparsurf.surface(each, density=1.0) for each in (example, usual, charmm)]
    for other in dots[1:]:
        assert sparsurf.fields(dots[0], FIELDS).equals(sparsurf.fields(other, FIELDS))


def test_a_table_may_have_the_usual_names_of_atoms(example, tmp_path):
    (tmp_path / "a.csv").write_text("residue,atom,shift\n210,H,8.5\n210,N,120\n")
    dots = sparsurf.surface(example, density=1.0)
    found = sparsurf.fields(dots, ["shift"], table=tmp_path / "a.csv")["shift"]
    (tmp_path / "a.csv").write_text("residue,atom,shift\n210,HN,8.5\n210,N,120\n")
    assert found.equals(sparsurf.fields(dots, ["shift"], table=tmp_path / "a.csv")["shift"])
    assert found.min() < 100 < found.max()


def test_a_selection_that_matches_nothing_names_the_spelling_of_the_file(example):
    with pytest.raises(InputError, match=r"contains no atoms; .*; it calls H HN\.$"):
        example.select(selection="name H")


def test_a_selection_by_a_prime_names_the_asterisk_of_the_file(example):
    names = np.where(example.name == "CA", "O5*", example.name)
    nucleotides = replace(example, residue_name=np.full(example.n_atoms, "DA"), name=names)
    with pytest.raises(InputError, match=r"contains no atoms; .*; it calls O5' O5\*\.$"):
        nucleotides.select(selection="""name "O5'\"""")


@pytest.mark.parametrize("name", ["a.parm7", "a.psf", "short.psf", "a.crd", "extended.crd"])
def test_insertion_codes_are_those_of_the_file(example, tmp_path, name):
    labels = np.array([f"209{code}" for code in ["", *"ABCDEFGHIJKLM"]])
    coded = replace(example.frame(0), residue=labels[example.residue_index])
    write_all(tmp_path, coded)
    frames = () if name.endswith(".crd") else (tmp_path / "a.nc",)
    assert read_molecule(tmp_path / name, *frames, selection="all").residue.tolist() == coded.residue.tolist()


@pytest.mark.parametrize(("extended", "kinds"), [(True, [11, 47]), (False, [9, 29])])
def test_a_psf_without_segments_and_types_is_read_by_its_columns(example, tmp_path, extended, kinds):
    """Two words are missing, so that the others do not tell which they are."""
    formats.psf(tmp_path / "a.psf", example, extended=extended)
    lines = (tmp_path / "a.psf").read_text().split("\n")
    for k in range(6, 6 + example.n_atoms):
        for first in kinds:
            lines[k] = f"{lines[k][:first]}    {lines[k][first + 4 :]}"
    (tmp_path / "a.psf").write_text("\n".join(lines))
    formats.of_mdtraj(tmp_path / "a.dcd", example)
    found = read_molecule(tmp_path / "a.psf", tmp_path / "a.dcd", selection="all")
    assert {*found.chain} == {""}
    for name in ("name", "residue_name", "residue"):
        assert getattr(found, name).tolist() == getattr(example, name).tolist()


# ---- damaged files of each format: right, or one sentence


WRITERS = {
    "gro": formats.gro, "psf": formats.psf, "parm7": formats.parm7, "crd": formats.card, "xyz": formats.xyz,
    "mdcrd": formats.mdcrd, "rst7": formats.restart, "lammpstrj": formats.lammps_dump, "data": formats.lammps_data,
    "xtc": formats.of_mdtraj, "trr": formats.of_mdtraj, "dcd": formats.of_mdtraj, "nc": formats.of_mdtraj,
}  # fmt: skip
TEXTS = [name for name in WRITERS if name not in ("xtc", "trr", "dcd", "nc")]


def paths_of(folder, molecule, kind):
    """The file of a format, and the files that make a molecule with it."""
    path = folder / f"a.{kind}"
    WRITERS[kind](path, molecule)
    if kind in ("gro", "crd"):
        return path, [path]
    other = folder / ("b.dcd" if kind in ("psf", "parm7") else "b.psf")
    (formats.of_mdtraj if other.suffix == ".dcd" else formats.psf)(other, molecule)
    return path, [path, other] if other.suffix == ".dcd" else [other, path]


@pytest.mark.parametrize("kind", WRITERS)
@pytest.mark.filterwarnings("ignore")
def test_a_file_that_is_cut_is_read_up_to_there_or_refused(example, tmp_path, caplog, kind):
    path, paths = paths_of(tmp_path, example, kind)
    content, whole = path.read_bytes(), read_molecule(*paths)
    for share in np.linspace(0, 0.97, 10):
        path.write_bytes(content[: int(share * len(content))])
        caplog.clear()
        try:
            found = read_molecule(*paths)
        except InputError as error:
            assert str(error).endswith(".") and path.name in str(error) and "\n" not in str(error)
            continue
        assert found.n_atoms == whole.n_atoms and np.array_equal(found.name, whole.name)
        assert np.array_equal(found.xyz, whole.xyz[: found.n_frames])
        assert found.n_frames == whole.n_frames or "cut short" in caplog.text, share


@pytest.mark.parametrize("kind", TEXTS)
@pytest.mark.filterwarnings("ignore")
def test_line_ends_titles_and_upper_case_names_do_not_matter(example, tmp_path, kind):
    path, paths = paths_of(tmp_path, example, kind)
    content, whole = path.read_bytes(), read_molecule(*paths)
    title = "LAMMPS data file" if kind == "data" else "title"
    changes = {
        "CRLF": content.replace(b"\n", b"\r\n"), "empty lines": content + b"\n\n",
        "Latin-1": content.replace(title.encode(), f"{title} é".encode("latin-1"), 1),
        "UTF-8": content.replace(title.encode(), f"{title} é".encode(), 1), "no line feed": content.rstrip(),
    }  # fmt: skip
    upper = tmp_path / path.name.upper()
    for name, changed in changes.items():
        upper.write_bytes(changed)
        found = read_molecule(*(upper if each == path else each for each in paths))
        assert np.array_equal(found.xyz, whole.xyz) and np.array_equal(found.name, whole.name), name


@pytest.mark.parametrize("kind", ["gro", "psf", "parm7", "crd", "xyz", "rst7", "lammpstrj", "data"])
@pytest.mark.filterwarnings("ignore")
def test_a_wrong_number_of_atoms_is_one_sentence(example, tmp_path, kind):
    path, paths = paths_of(tmp_path, example, kind)
    text, n = path.read_text(), example.n_atoms
    for wrong in (n + 1, n - 1, 10 * n, 0, "x"):
        path.write_text(text.replace(f"{n:>3d}", f"{wrong!s:>3s}"))
        with pytest.raises(InputError) as error:
            read_molecule(*paths)
        assert path.name in str(error.value) and "\n" not in str(error.value), wrong


def test_sound_files_of_another_kind_are_refused_in_a_true_sentence(example, tmp_path):
    plain = tmp_path / "plain.pdb"
    example.write_pdb(plain)
    formats.of_mdtraj(tmp_path / "one.xtc", example)
    formats.of_mdtraj(tmp_path / "half.xtc", example.take(np.arange(example.n_atoms // 2)))
    joined = (tmp_path / "one.xtc").read_bytes() + (tmp_path / "half.xtc").read_bytes()
    (tmp_path / "joined.xtc").write_bytes(joined)
    with netcdf_file(tmp_path / "empty.nc", "w") as file:
        file.createDimension("atom", example.n_atoms)
    formats.lammps_dump(tmp_path / "a.dump", example.frame(0))
    rows = (tmp_path / "a.dump").read_text().split("\n")
    rows[10] = f"{rows[9].split()[0]} {rows[10].partition(' ')[2]}"
    (tmp_path / "twice.dump").write_text("\n".join(rows))
    for name, expected in (
        ("joined.xtc", f"has {example.n_atoms // 2} atoms in frame 2 and {example.n_atoms} in the first"),
        ("empty.nc", "is no trajectory of AMBER: it has no variable called coordinates"),
        ("twice.dump", f"line 11 has the id {example.n_atoms} of another atom"),
    ):
        with pytest.raises(InputError, match=expected) as error:
            read_molecule(plain, tmp_path / name)
        assert "damaged" not in str(error.value)
    assert read_molecule(plain, tmp_path / "one.xtc").n_frames == 2
    formats.gro(tmp_path / "a.gro", example)
    (tmp_path / "wide.gro").write_text((tmp_path / "a.gro").read_text(), encoding="utf-16")
    with pytest.raises(InputError, match="stored as UTF-16: store it as UTF-8"):
        read_molecule(tmp_path / "wide.gro")
    formats.card(tmp_path / "a.crd", example, extended=True)
    whole = read_molecule(tmp_path / "a.crd")
    (tmp_path / "a.crd").write_text((tmp_path / "a.crd").read_text().replace("EXT", "ext"))
    assert np.array_equal(read_molecule(tmp_path / "a.crd").xyz, whole.xyz)


# ---- frames with cells: each frame its own


CELLS_AT_RIGHT_ANGLES = np.array(
    [np.diag(sides) for sides in ((40.0, 43, 46), (41.5, 45, 44), (43, 41, 47.5))]
)
TILTED_CELLS = np.array(
    [
        box_vectors(40, 43, 46, 80, 75, 65),
        box_vectors(42, 45, 44, 95, 70, 100),
        box_vectors(44, 41, 48, 70, 82, 60),
    ]
)
FILES_WITH_CELLS = {  # at any angles
    "a.gro": formats.gro, "before.pdb": formats.models, "behind.pdb": partial(formats.models, behind=True),
    "a.xyz": formats.extended_xyz, "a.lammpstrj": formats.lammps_dump,
    "scaled.lammpstrj": partial(formats.lammps_dump, scaled=True),
    "general.lammpstrj": partial(formats.lammps_dump, general=True),
    "general_scaled.lammpstrj": partial(formats.lammps_dump, general=True, scaled=True),
}  # fmt: skip
AT_RIGHT_ANGLES = {
    "a.mdcrd": partial(formats.mdcrd, box=True), "replica.mdcrd": partial(formats.mdcrd, box=True, replica=True),
}  # fmt: skip


def radius_of_gyration(xyz):
    return np.sqrt(((xyz - xyz.mean(axis=1, keepdims=True)) ** 2).sum(axis=2).mean(axis=1))


@pytest.mark.parametrize("tilted", [False, True])
@pytest.mark.filterwarnings("ignore")
def test_every_frame_has_its_own_cell_in_every_format(example, tmp_path, tilted):
    """Three frames that their cells cut, in all text formats with cells: the same positions, cells and radii of gyration."""
    cells = TILTED_CELLS if tilted else CELLS_AT_RIGHT_ANGLES
    first, second = example.xyz - example.xyz[:, :1]
    whole = np.stack([first, second, first[:, [1, 2, 0]]])  # the last one turned
    shift = np.array([[0.02, 0.9, 0.5], [0.95, 0.1, 0.03], [0.5, 0.97, 0.9]])
    places = whole + np.einsum("fa,fab->fb", shift, cells)[:, None]
    images = np.floor(places @ np.linalg.inv(cells)).astype(int)
    wrapped = places - images @ cells
    assert (np.ptp(images, axis=1).max(axis=1) > 0).all()
    molecule = replace(example, xyz=wrapped, time_ps=np.full(3, np.nan), frame_number=np.arange(3))
    example.write_pdb(tmp_path / "plain.pdb")
    writers = FILES_WITH_CELLS | ({} if tilted else AT_RIGHT_ANGLES)
    order = np.random.default_rng(0).permutation(molecule.n_atoms)
    writers |= {"ids.xyz": partial(formats.extended_xyz, order=order)}
    for name, write in writers.items():
        write(tmp_path / name, molecule, cells=cells)
        check_frames(tmp_path / name, whole, wrapped, cells)
        if name.endswith(".pdb"):
            check_frames(tmp_path / name, whole, wrapped, cells, topology=None)
    for k in range(3):
        for counted, general in ((False, False), (True, False), (False, True), (True, True)):
            path, one = tmp_path / f"{k}{counted}{general}.data", slice(k, k + 1)
            formats.lammps_data(path, molecule.frame(k), cells[k], images[k] if counted else None, general)
            check_frames(path, whole[one], places[one] if counted else wrapped[one], cells[one])


def check_frames(path, whole, written, cells, topology="plain.pdb"):
    """Compare frames and their cells with those that were written; `whole` is what is not cut, wherever it lies."""
    source = open_source(path)
    frames = [parse() for parse in frames_of_text(source, whole.shape[1])]
    products = [frame.box @ frame.box.T for frame in frames]  # PDB and GRO have the lengths and angles alone
    np.testing.assert_allclose(products, cells @ cells.transpose(0, 2, 1), rtol=2e-4, err_msg=path.name)
    # GRO holds 0.01 Å
    np.testing.assert_allclose([frame.xyz for frame in frames], written, atol=0.006, err_msg=path.name)
    found = read_molecule(*([path.with_name(topology), path] if topology else [path])).xyz
    np.testing.assert_allclose(found - found[:, :1], whole, atol=0.012, err_msg=path.name)
    np.testing.assert_allclose(
        radius_of_gyration(found), radius_of_gyration(whole), atol=0.006, err_msg=path.name
    )


# ---- spheres


PALETTE = ("C", "N", "O", "H", "S", "P", "F", "Cl", "Br", "I")
TYPES = {  # of SYBYL, and of force fields
    "C": ("C.3 C.ar C.2", "c3 ca CT CG2R61 c"), "N": ("N.3 N.am N.pl3", "n na N3 NG321 nb"), "O": ("O.3 O.co2", "oh os OH OG311"),
    "H": ("H", "hc ha HC HGA3 h1"), "S": ("S.3 S.O2", "ss sh SH"), "P": ("P.3", "p5 P"), "F": ("F", "f FGA3"),
    "Cl": ("Cl", "cl CL CLGA1"), "Br": ("Br", "br BRGR1"), "I": ("I", "i IGR1"),
}  # fmt: skip


@given(data=st.data(), elements=st.lists(st.sampled_from(PALETTE), min_size=2, max_size=14))
@settings(max_examples=12, phases=[Phase.generate], derandomize=True)
def test_every_file_with_radii_has_the_same_spheres(tmp_path_factory, data, elements):
    """A chain of atoms through spheres, PQR, MOL2 and SDF: the same positions, radii, names and area."""
    folder, n = tmp_path_factory.mktemp("a"), len(elements)
    rng = np.random.default_rng(data.draw(st.integers(0, 999)))
    steps = rng.normal(size=(n, 3)) * [1, 1, 0.2] + [0, 0, 1.5]
    places = (
        np.cumsum(1.4 * steps / np.linalg.norm(steps, axis=1)[:, None], axis=0)
        + data.draw(st.sampled_from([0, -150]))
    ).round(3)
    radii = np.array([RADII["bondi"][each.upper()] for each in elements])
    names = [f"{each}{k}" for k, each in enumerate(elements, 1)]
    sybyl, others = (
        [data.draw(st.sampled_from(TYPES[each][k].split())) for each in elements] for k in (0, 1)
    )
    others[0] = {"C": "ca", "N": "na"}.get(elements[0], others[0])
    dummies = [(places[0] + [0, 0, 9], "Du"), (places[0] - [0, 0, 9], "LP")]
    symbols = [data.draw(st.sampled_from(["H", "D", "T"])) if each == "H" else each for each in elements]
    formats.xyzr(folder / "a.xyzr", places, radii)
    formats.xyzr(folder / "a.xyzrn", places, radii, names)
    formats.pqr(folder / "columns.pqr", places, radii, names)
    formats.pqr(folder / "no_chain.pqr", places, radii, names, chain="")
    formats.pqr(folder / "words.pqr", places, radii, names, columns=False)
    formats.pqr(folder / "words_no_chain.pqr", places, radii, names, columns=False, chain="")
    formats.pqr(folder / "elements.pqr", places, radii, names, elements=elements)
    formats.pqr(folder / "words_elements.pqr", places, radii, names, columns=False, elements=elements)
    formats.pqr(folder / "models.pqr", places, radii, names, n_models=2)
    formats.mol2(folder / "sybyl.mol2", places, elements, names, sybyl)
    formats.mol2(folder / "others.mol2", places, elements, names, others)
    formats.mol2(folder / "continued.mol2", places, elements, names, sybyl, continued=True)
    formats.mol2(folder / "dummies.mol2", places, elements, names, sybyl, dummies)
    formats.sdf(folder / "a.sdf", places, symbols)
    formats.sdf(folder / "v3000.sdf", places, symbols, "V3000")
    formats.sdf(folder / "continued.sdf", places, symbols, "V3000", continued=True)
    area = sparsurf.surface((places, radii), density=1.0).area.sum()
    for path in sorted(folder.iterdir()):
        found = read_spheres(path)
        np.testing.assert_array_equal(found.xyz, places, err_msg=path.name)
        np.testing.assert_allclose(found.radii, radii, atol=1e-9, err_msg=path.name)
        expected = {".sdf": symbols, ".xyzr": [""] * n}.get(path.suffix, names)
        assert found.names == expected, path.name
    assert (
        sparsurf.surface(
            folder / data.draw(st.sampled_from(["words.pqr", "others.mol2", "a.sdf"])), density=1.0
        ).area.sum()
        == area
    )


def test_what_is_no_file_of_atoms_says_what_to_do(tmp_path):
    for name, content, words in (
        ("a.cpt", (171_817).to_bytes(4, "big") + bytes(40), "checkpoint of GROMACS.*gmx trjconv"),
        (
            "a.tng",
            bytes(8) + b"\x40" + bytes(31) + b"GENERAL INFO\0" + bytes(20),
            "TNG trajectory.*trjconv",
        ),
        ("a.coor", (5).to_bytes(4, "little") + bytes(120), "binary coordinates of NAMD"),
        (
            "a.g96",
            b"TITLE\nown\nEND\nPOSITION\n    1 ALA   N          1    0.01    0.2   -0.5\nEND\n",
            "GROMOS96.*gmx editconf",
        ),
        (
            "a.tpr",
            b"\0\0\0\x0d\0\0\0\x0cVERSION 2021" + bytes(20),
            r"run input of GROMACS \(TPR\).*gmx editconf",
        ),
        ("a.cms", b"{\n s_m_m2io_version\n :::\n 2.0.0\n}\n", "Desmond or Maestro.*DCD or XTC"),
        ("frame000", b"DESM" + bytes(20), "Desmond or Maestro"),
        ("a.nc", b"CDF\x05" + bytes(20), "CDF-5.*nccopy"),
        ("a.h5", b"\x89HDF\r\n\x1a\n" + bytes(20) + b"h5md", "is an H5MD file"),
    ):
        (tmp_path / name).write_bytes(content)
        with pytest.raises(InputError, match=words) as error:
            open_source(tmp_path / name)
        assert str(error.value).startswith(str(tmp_path / name)) and "damaged" not in str(error.value)
    (tmp_path / "old.prmtop").write_text("title\n" + 2 * (12 * "     1" + "\n") + "     0\nN   \n")
    with pytest.raises(InputError, match=r"AMBER 7 .*ParmEd"):
        MOLECULE_READERS["parm7"](open_source(tmp_path / "old.prmtop"))
    folder = tmp_path / "run_trj"
    folder.mkdir()
    (folder / "clickme.dtr").write_text("")
    for path in (folder, folder / "clickme.dtr"):
        with pytest.raises(InputError, match=r"Desmond.*DCD or XTC"):
            open_source(path)
