"""Writers of the formats of molecular dynamics, for tests: one molecule becomes a file of each, with its own names and labels."""

import mdtraj
import numpy as np

from sparsurf.molecules.residues import split_label

NUMBERS = {"H": 1, "C": 6, "N": 7, "O": 8, "S": 16}


def gro(path, molecule):
    """Frames of a GRO file; the format has no chains and no insertion codes."""
    lines = []
    for k, xyz in enumerate(molecule.xyz):
        lines += [f"title t= {10.0 * k:.5f}", f"{molecule.n_atoms:5d}"]
        for i, place in enumerate(xyz / 10):
            number, _ = split_label(molecule.residue[i])
            label = (
                f"{int(number):5d}{molecule.residue_name[i]:<5s}{molecule.name[i]:>5s}{(i + 1) % 100_000:5d}"
            )
            lines.append(label + "".join(f"{x:8.3f}" for x in place))
        lines.append(f"{0:10.5f}{0:10.5f}{0:10.5f}")
    path.write_text("\n".join(lines) + "\n")


def psf(path, molecule, extended=True):
    """A PSF file with the chain as the segment, wrong masses, and the bonds of neighbours within 1.9 Å."""
    lines = [
        "PSF EXT XPLOR" if extended else "PSF",
        "",
        f"{1:8d} !NTITLE",
        "* title",
        "",
        f"{molecule.n_atoms:8d} !NATOM",
    ]
    rows = zip(molecule.chain, molecule.residue, molecule.residue_name, molecule.name, strict=True)
    for i, row in enumerate(rows, 1):
        widths = (8, 8, 8, 8, 6) if extended else (4, 4, 4, 4, 4)
        words = " ".join(f"{word:<{width}s}" for word, width in zip((*row, "X"), widths, strict=True))
        lines.append(f"{i:{10 if extended else 8}d} {words} {0.1:14.6f}{3.024:14.4f}{0:8d}")
    bonds = bonds_of(molecule) + 1
    lines += ["", f"{len(bonds):8d} !NBOND: bonds"]
    flat, width = bonds.ravel().tolist(), 10 if extended else 8
    lines += ["".join(f"{x:{width}d}" for x in flat[k : k + 8]) for k in range(0, len(flat), 8)]
    path.write_text("\n".join([*lines, ""]))


def bonds_of(molecule):
    """Pairs (B, 2) of atoms within 1.9 Å (1.3 of a hydrogen), as bonds."""
    xyz = molecule.xyz[0]
    near = np.linalg.norm(xyz[:, None] - xyz, axis=2)
    light = ~molecule.heavy
    return np.argwhere(np.triu(near < np.where(light[:, None] | light, 1.3, 1.9), 1))


def parm7(path, molecule, labels=True):
    """An AMBER topology; with `labels`, the numbers, chains and insertion codes of the residues besides."""
    first = np.unique(molecule.residue_index, return_index=True)[1]
    parts = [split_label(label) for label in molecule.residue[first]]
    bonds = bonds_of(molecule)
    hydrogen = (~molecule.heavy)[bonds].any(axis=1)
    pointers = np.zeros(31, int)
    pointers[[0, 2, 3, 11]] = molecule.n_atoms, hydrogen.sum(), (~hydrogen).sum(), len(first)
    flags = {
        "TITLE": ("20a4", ["x"]), "POINTERS": ("10I8", pointers), "ATOM_NAME": ("20a4", molecule.name),
        "ATOMIC_NUMBER": ("10I8", [NUMBERS[each] for each in molecule.element]), "MASS": ("5E16.8", [3.024] * molecule.n_atoms),
        "RESIDUE_LABEL": ("20a4", molecule.residue_name[first]), "RESIDUE_POINTER": ("10I8", first + 1),
        "BONDS_INC_HYDROGEN": ("10I8", _of_parm7(bonds[hydrogen])),
        "BONDS_WITHOUT_HYDROGEN": ("10I8", _of_parm7(bonds[~hydrogen])),
    }  # fmt: skip
    if labels:
        flags |= {
            "RESIDUE_NUMBER": ("20I4", [int(number) for number, _ in parts]),
            "RESIDUE_CHAINID": ("20a4", molecule.chain[first]), "RESIDUE_ICODE": ("20a4", [code for _, code in parts]),
        }  # fmt: skip
    lines = ["%VERSION  VERSION_STAMP = V0001.000  DATE = 01/01/26  00:00:00"]
    for flag, (form, values) in flags.items():
        lines += [f"%FLAG {flag}", f"%FORMAT({form})"]
        per_line = int(form[: form.index(next(filter(str.isalpha, form)))])
        kind, width = form[len(str(per_line))], int(form[len(str(per_line)) + 1 :].partition(".")[0])
        words = [
            f"{x:<{width}s}" if kind == "a" else f"{x:{width}d}" if kind == "I" else f"{x:{width}.8E}"
            for x in values
        ]
        lines += ["".join(words[k : k + per_line]) for k in range(0, max(len(words), 1), per_line)]
    path.write_text("\n".join([*lines, ""]))


def old_parm7(path, molecule):
    """An AMBER topology from before AMBER 7: sections without flags in a fixed order, each on a line at least."""
    first = np.unique(molecule.residue_index, return_index=True)[1]
    bonds, n_atoms = bonds_of(molecule), molecule.n_atoms
    hydrogen = (~molecule.heavy)[bonds].any(axis=1)
    # two types of atoms, 3 of bonds, 4 of angles, 6 of torsions, and 7 of SOLTY: every section has a length of its own
    pointers = np.zeros(30, int)
    pointers[[0, 1, 2, 11, 12, 15, 16, 17, 18]] = (
        n_atoms,
        2,
        hydrogen.sum(),
        len(first),
        (~hydrogen).sum(),
        3,
        4,
        6,
        7,
    )
    lines = ["the title"]

    def section(per_line, words):
        words = list(words)
        lines.extend("".join(words[k : k + per_line]) for k in range(0, max(len(words), 1), per_line))

    def integers(values):
        section(12, (f"{x:6d}" for x in values))

    def reals(number):
        section(5, number * [f"{0.5:16.8E}"])

    integers(pointers)
    section(20, (f"{name:<4s}" for name in molecule.name))
    reals(n_atoms)
    reals(n_atoms)
    integers([1] * n_atoms)
    integers([0] * n_atoms)
    integers([1] * 4)
    section(20, (f"{name:<4s}" for name in molecule.residue_name[first]))
    integers(first + 1)
    for number in (3, 3, 4, 4, 6, 6, 6, 7, 3, 3):
        reals(number)
    integers(_of_parm7(bonds[hydrogen]))
    integers(_of_parm7(bonds[~hydrogen]))
    path.write_text("\n".join([*lines, "     1     2", ""]))


def _of_parm7(bonds):
    """Bonds as a parm7 file has them: numbers of atoms times 3, and a type."""
    return np.column_stack([3 * bonds, np.ones(len(bonds), int)]).ravel()


def card(path, molecule, extended=False):
    """A coordinate file of CHARMM with the labels of the residues."""
    lines = ["* title", "*", f"{molecule.n_atoms:10d}  EXT" if extended else f"{molecule.n_atoms:5d}"]
    for i, (x, y, z) in enumerate(molecule.xyz[0]):
        residue = int(molecule.residue_index[i]) + 1
        names = molecule.residue_name[i], molecule.name[i]
        ends = molecule.chain[i], molecule.residue[i]
        if extended:
            line = f"{i + 1:10d}{residue:10d}  {names[0]:<8s}  {names[1]:<8s}{x:20.10f}{y:20.10f}{z:20.10f}"
            lines.append(f"{line}  {ends[0]:<8s}  {ends[1]:<8s}{0:20.10f}")
        else:
            line = f"{i + 1:5d}{residue:5d} {names[0]:<4s} {names[1]:<4s}{x:10.5f}{y:10.5f}{z:10.5f}"
            lines.append(f"{line} {ends[0]:<4s} {ends[1]:<4s}{0:10.5f}")
    path.write_text("\n".join([*lines, ""]))


def xyz(path, molecule):
    """Frames of an XYZ file, with empty lines at its end."""
    frames = []
    for places in molecule.xyz:
        rows = [
            f"{each} {x:.4f} {y:.4f} {z:.4f}"
            for each, (x, y, z) in zip(molecule.element, places, strict=True)
        ]
        frames.append("\n".join([str(molecule.n_atoms), "comment", *rows]))
    path.write_text("\n".join(frames) + "\n\n\n")


def mdcrd(path, molecule, box=False):
    """Frames of an mdcrd file, with a box in each or without."""
    lines = ["title"]
    for places in molecule.xyz:
        words = [f"{x:8.3f}" for x in places.ravel()]
        lines += ["".join(words[k : k + 10]) for k in range(0, len(words), 10)]
        lines += [3 * f"{900:8.3f}"] if box else []
    path.write_text("\n".join([*lines, ""]))


def restart(path, molecule, velocities=True):
    """A restart file of AMBER, with velocities and a box, or without."""
    parts = [
        molecule.xyz[0],
        *([np.ones_like(molecule.xyz[0]), np.array([900, 900, 900, 90, 90, 90])] if velocities else []),
    ]
    lines = ["title", f"{molecule.n_atoms:5d}  0.1000000E+02"]
    for part in parts:
        words = [f"{x:12.7f}" for x in part.ravel()]
        lines += ["".join(words[k : k + 6]) for k in range(0, len(words), 6)]
    path.write_text("\n".join([*lines, ""]))


def lammps_dump(path, molecule, scaled=False):
    """Frames of a LAMMPS dump, with the atoms in reverse order of their ids."""
    lines = []
    for k, places in enumerate(molecule.xyz):
        lines += [
            "ITEM: TIMESTEP",
            str(k),
            "ITEM: NUMBER OF ATOMS",
            str(molecule.n_atoms),
            "ITEM: BOX BOUNDS pp pp pp",
        ]
        lines += 3 * ["-400.0 600.0"]
        lines.append(f"ITEM: ATOMS id type {'xs ys zs' if scaled else 'x y z'}")
        shown = (places + 400) / 1000 if scaled else places
        lines += [
            f"{i + 1} 1 " + " ".join(f"{x:.9f}" for x in shown[i]) for i in reversed(range(molecule.n_atoms))
        ]
    path.write_text("\n".join([*lines, ""]))


def lammps_data(path, molecule):
    """A LAMMPS data file of the style full."""
    lines = [
        "LAMMPS data file",
        "",
        f"{molecule.n_atoms} atoms",
        "1 atom types",
        "",
        "-400 600 xlo xhi",
        "-400 600 ylo yhi",
    ]
    lines += ["-400 600 zlo zhi", "", "Masses", "", "1 12.0", "", "Atoms # full", ""]
    lines += [
        f"{i + 1} 1 1 0.5 {x:.4f} {y:.4f} {z:.4f} 0 0 0"
        for i, (x, y, z) in reversed([*enumerate(molecule.xyz[0])])
    ]
    path.write_text("\n".join([*lines, ""]))


def of_mdtraj(path, molecule):
    """Frames in the format of the extension, as mdtraj writes it; atoms and residues have their names in HDF5."""
    trajectory = mdtraj.Trajectory(
        molecule.xyz / 10, molecule.topology, time=10.0 * np.arange(molecule.n_frames),
        unitcell_lengths=np.full((molecule.n_frames, 3), 90.0), unitcell_angles=np.full((molecule.n_frames, 3), 90.0),
    )  # fmt: skip
    trajectory.save(str(path))
