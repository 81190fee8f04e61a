"""Writers of the formats of molecular dynamics, for tests: one molecule becomes a file of each, with its own names and labels."""

import mdtraj
import numpy as np

from sparsurf.molecules.residues import split_label

NUMBERS = {"H": 1, "C": 6, "N": 7, "O": 8, "S": 16}


def gro(path, molecule, cells=None):
    """Frames of a GRO file, with cells of zeros without others; the format has no chains and no insertion codes."""
    lines = []
    for k, xyz in enumerate(molecule.xyz):
        lines += [f"title t= {10.0 * k:.5f}", f"{molecule.n_atoms:5d}"]
        for i, place in enumerate(xyz / 10):
            number, _ = split_label(molecule.residue[i])
            label = (
                f"{int(number):5d}{molecule.residue_name[i]:<5s}{molecule.name[i]:>5s}{(i + 1) % 100_000:5d}"
            )
            lines.append(label + "".join(f"{x:8.3f}" for x in place))
        cell = np.zeros((3, 3)) if cells is None else cells[k] / 10
        numbers = [*np.diag(cell), *cell[[0, 0, 1, 1, 2, 2], [1, 2, 0, 2, 0, 1]]]
        lines.append("".join(f"{x:12.7f}" for x in numbers))
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


def models(path, molecule, cells, behind=False):
    """Models of a PDB file, each before or behind its cell."""
    parts = []
    for k, cell in enumerate(cells):
        a, b, c, alpha, beta, gamma = lengths_and_angles(cell)
        record = f"CRYST1{a:9.3f}{b:9.3f}{c:9.3f}{alpha:7.2f}{beta:7.2f}{gamma:7.2f} P 1           1\n"
        molecule.write_pdb(path, frame=k)
        model = f"MODEL {k + 1:8d}\n{path.read_text().removesuffix('END' + chr(10))}ENDMDL\n"
        parts += [model, record] if behind else [record, model]
    path.write_text("".join([*parts, "END\n"]))


def lengths_and_angles(cell):
    """The lengths of three vectors, Å, and the angles between them, degrees."""
    lengths = np.linalg.norm(cell, axis=1)
    cosines = [cell[i] @ cell[j] / (lengths[i] * lengths[j]) for i, j in ((1, 2), (0, 2), (0, 1))]
    return [*lengths, *np.degrees(np.arccos(cosines))]


def extended_xyz(path, molecule, cells, order=None):
    """Frames of extended XYZ: a charge precedes the positions; with an order of the atoms, an id precedes the species."""
    frames = []
    rows = np.arange(molecule.n_atoms) if order is None else order
    for places, cell in zip(molecule.xyz, cells, strict=True):
        lattice = " ".join(f"{x:.7f}" for x in cell.ravel())
        properties = f"{'' if order is None else 'id:I:1:'}species:S:1:force:R:3:charge:R:1:pos:R:3:mass:R:1"
        lines = [f'Lattice="{lattice}" Properties={properties} pbc="T T T" energy=-1.5']
        for row in rows:
            x, y, z = places[row]
            front = "" if order is None else f"{row + 1} "
            lines.append(f"{front}{molecule.element[row]} 9 8 7 0.25 {x:.7f} {y:.7f} {z:.7f} 12.0")
        frames.append("\n".join([str(molecule.n_atoms), *lines]))
    path.write_text("\n".join([*frames, ""]))


def mdcrd(path, molecule, box=False, cells=None, replica=False):
    """Frames of an mdcrd file, with a box in each or without, and with lines of replica exchange."""
    lines = ["title"]
    for k, places in enumerate(molecule.xyz):
        lines += [f"REMD  {k:8d}  {k:8d}   300.00"] if replica else []
        words = [f"{x:8.3f}" for x in places.ravel()]
        lines += ["".join(words[k : k + 10]) for k in range(0, len(words), 10)]
        sides = [900] * 3 if cells is None else np.diag(cells[k])
        lines += ["".join(f"{side:8.3f}" for side in sides)] if box else []
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


ORIGIN = np.array([-400.0, -300, -200])  # of the cells of LAMMPS


def lammps_dump(path, molecule, scaled=False, cells=None, general=False):
    """Frames of a LAMMPS dump, with the atoms in reverse order of their ids, and cells of 1,000 Å without others."""
    lines = []
    for k, places in enumerate(molecule.xyz):
        cell = 1000 * np.eye(3) if cells is None else cells[k]
        lines += [
            "ITEM: TIMESTEP",
            str(k),
            "ITEM: NUMBER OF ATOMS",
            str(molecule.n_atoms),
            *_bounds(cell, general),
        ]
        lines.append(f"ITEM: ATOMS id type q {'xs ys zs' if scaled else 'x y z'}")
        shown = (places - ORIGIN) @ np.linalg.inv(cell) if scaled else places
        lines += [
            f"{i + 1} 1 0.5 " + " ".join(f"{x:.9f}" for x in shown[i])
            for i in reversed(range(molecule.n_atoms))
        ]
    path.write_text("\n".join([*lines, ""]))


def _bounds(cell, general):
    """The section BOX BOUNDS of a cell: at right angles, tilted, or general."""
    if general:
        rows = np.column_stack([cell, ORIGIN])
        return ["ITEM: BOX BOUNDS abc origin pp pp pp", *(" ".join(f"{x:.9f}" for x in row) for row in rows)]
    xy, xz, yz = cell[1, 0], cell[2, 0], cell[2, 1]
    low, high = ORIGIN, ORIGIN + np.diag(cell)
    if not xy == xz == yz == 0:
        low = low + np.array([min(0, xy, xz, xy + xz), min(0, yz), 0])
        high = high + np.array([max(0, xy, xz, xy + xz), max(0, yz), 0])
        rows = zip(low, high, (xy, xz, yz), strict=True)
        return ["ITEM: BOX BOUNDS xy xz yz pp pp pp", *(" ".join(f"{x:.9f}" for x in row) for row in rows)]
    return ["ITEM: BOX BOUNDS pp pp pp", *(f"{a:.9f} {b:.9f}" for a, b in zip(low, high, strict=True))]


def lammps_data(path, molecule, cell=None, images=None, general=False):
    """A LAMMPS data file of the style full, with a cell of 1,000 Å without another, and counts of images (A, 3) or zeros."""
    cell = 1000 * np.eye(3) if cell is None else cell
    lines = ["LAMMPS data file", "", f"{molecule.n_atoms} atoms", "1 atom types", ""]
    if general:
        lines += [
            " ".join(f"{x:.9f}" for x in row) + f" {name}vec" for row, name in zip(cell, "abc", strict=True)
        ]
        lines.append(" ".join(map(str, ORIGIN)) + " abc origin")
    else:
        lines += [
            f"{x} {x + side:.9f} {a}lo {a}hi" for x, side, a in zip(ORIGIN, np.diag(cell), "xyz", strict=True)
        ]
        lines.append(f"{cell[1, 0]:.9f} {cell[2, 0]:.9f} {cell[2, 1]:.9f} xy xz yz")
    lines += ["", "Masses", "", "1 12.0", "", "Atoms # full", ""]
    images = np.zeros(molecule.xyz[0].shape, int) if images is None else images
    lines += [
        f"{i + 1} 1 1 0.5 {x:.7f} {y:.7f} {z:.7f} " + " ".join(map(str, images[i]))
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


# ---- spheres and small molecules: positions (A, 3) and radii (A,), Å; names and elements (A,)


def xyzr(path, xyz, radii, names=None):
    """Spheres, with names in a .xyzrn."""
    rows = zip(xyz, radii, names if names is not None else [""] * len(xyz), strict=True)
    path.write_text(
        "".join(f"{x:.4f} {y:.4f} {z:.4f} {r:.4f}{name and ' 1 ' + name}\n" for (x, y, z), r, name in rows)
    )


def pqr(path, xyz, radii, names, columns=True, elements=None, chain="A", n_models=1):
    """A PQR file in columns or words, with an element behind the radius or not, and further models that are moved."""
    models = []
    for model in range(n_models):
        lines = []
        for k, (place, radius) in enumerate(zip(xyz + 30.0 * model, radii, strict=True)):
            charge = 0.3 * (-1) ** k
            end = "" if elements is None else f"  {elements[k]}"
            if columns:
                numbers = "".join(f"{x:8.3f}" for x in place) + f"{charge:8.4f}{radius:7.4f}"
                lines.append(f"ATOM  {k + 1:5d} {names[k]:>4s} LIG {chain or ' '}{1:4d}    {numbers}{end}\n")
            else:
                numbers = " ".join(f"{x:.4f}" for x in (*place, charge, radius))
                lines.append(f"ATOM {k + 1} {names[k]} LIG {chain and chain + ' '}1 {numbers}{end}\n")
        models.append(f"MODEL {model + 1}\n{''.join(lines)}ENDMDL\n" if n_models > 1 else "".join(lines))
    path.write_text("REMARK\n" + "".join(models) + "END\n")


def mol2(path, xyz, elements, names, types, dummies=(), continued=False):
    """A MOL2 file with types of atoms, with dummy atoms behind them, and lines that are continued or not."""
    rows = [
        *zip(names, xyz, types, strict=True),
        *((f"X{k}", place, kind) for k, (place, kind) in enumerate(dummies)),
    ]
    lines = [
        f"{k:7d} {name:<8s} {x:.4f} {y:.4f} {z:.4f} " + ("\\\n" if continued else "") + f"{kind} 1 LIG 0.5\n"
        for k, (name, (x, y, z), kind) in enumerate(rows, 1)
    ]
    head = f"@<TRIPOS>MOLECULE\nname\n{len(rows)} 0 1 0 0\nSMALL\nNO_CHARGES\n\n@<TRIPOS>ATOM\n"
    path.write_text(head + "".join(lines) + "@<TRIPOS>BOND\n")


def sdf(path, xyz, elements, version="V2000", continued=False):
    """An SDF file of one molecule."""
    n = len(xyz)
    if version == "V2000":
        lines = [
            f"{x:10.4f}{y:10.4f}{z:10.4f} {each:<3s} 0  0\n"
            for (x, y, z), each in zip(xyz, elements, strict=True)
        ]
        text = f"name\n  program\n\n{n:3d}  0  0  0  0  0  0  0  0  0999 V2000\n" + "".join(lines)
    else:
        gap = "-\nM  V30 " if continued else ""
        lines = [
            f"M  V30 {k} {each} {gap}{x:.4f} {y:.4f} {z:.4f} 0\n"
            for k, ((x, y, z), each) in enumerate(zip(xyz, elements, strict=True), 1)
        ]
        text = f"name\n\n\n  0  0  0     0  0            999 V3000\nM  V30 BEGIN CTAB\nM  V30 COUNTS {n} 0 0 0 0\n"
        text += "M  V30 BEGIN ATOM\n" + "".join(lines) + "M  V30 END ATOM\nM  V30 END CTAB\n"
    path.write_text(text + "M  END\n$$$$\n")
