"""Small molecules as text, for the tests of the readers."""

import numpy as np

# Å; a residue of an extended chain, and the step to the next one (C-N 1.33 Å)
ALANINE = {
    "N": (0.0, 0.0, 0.0), "CA": (1.46, 0.0, 0.0), "C": (2.0, 1.42, 0.0), "O": (1.3, 2.43, 0.0),
    "CB": (2.0, -0.8, 1.2),
}  # fmt: skip
STEP = np.array([3.33, 1.42, 0.0])


def atom_line(
    name="CA", residue_name="ALA", chain="A", residue="1", place=(0, 0, 0), *, record="ATOM", altloc="",
    element=None, occupancy=1.0, serial=1,
):  # fmt: skip
    """One line of a PDB file in standard columns; `name` with blanks is written as it is."""
    number, code = (residue[:-1], residue[-1]) if residue[-1:].isalpha() else (residue, " ")
    element = name.strip().lstrip("0123456789")[:1] if element is None else element
    name = name if len(name) == 4 else f" {name:<3s}"
    x, y, z = place
    return (
        f"{record:<6s}{serial:5d} {name}{altloc or ' '}{residue_name:>3s}{chain:>{5 - max(3, len(residue_name))}s}"
        f"{number:>4s}{code}   {x:8.3f}{y:8.3f}{z:8.3f}{occupancy:6.2f}  0.00          {element:>2s}\n"
    )


def peptide(residues=("ALA", "ALA", "ALA", "ALA"), chain="A", first=1, origin=(0, 0, 0), **keys):
    """PDB lines of an extended peptide with the atoms of alanine, whatever its residues are called."""
    return "".join(
        atom_line(name, each, chain, str(first + i), np.add(place, origin) + i * STEP, **keys)
        for i, each in enumerate(residues)
        for name, place in ALANINE.items()
    )


def write(path, text):
    path.write_text(text, encoding="utf-8")
    return path


def moved(lines, shift):
    """Lines of atoms with x larger by `shift`."""
    return "".join(
        f"{line[:30]}{float(line[30:38]) + shift:8.3f}{line[38:]}" for line in lines.splitlines(True)
    )


def two_models(shift=0.0):
    """PDB text of two models with two chains, a place with two locations, a hydrogen and a ligand; `shift` moves the second."""
    texts = []
    for k in range(2):
        first = peptide(("ALA", "SER", "LYS", "VAL"), origin=(0, 0.4 * k, 0))
        first += atom_line("CB", "GLY", "A", "5", (13.3, 5.7, 0), altloc="A", occupancy=0.4)
        first += atom_line("CB", "GLY", "A", "5", (13.3, 6.7, 1), altloc="B", occupancy=0.6)
        first += atom_line("CA", "GLY", "A", "5", (13.3, 5.7, 1.5 + k))
        first += atom_line("H", "GLY", "A", "5", (14, 7.4, 2))
        second = peptide(("LEU", "GLY"), "B", origin=(0, 6, 0))
        ligand = atom_line("C1", "LIG", "C", "1", (5, 4.5, 4), record="HETATM")
        ter, parts = "TER\n", (moved(part, k * shift) for part in (first, second, ligand))
        texts.append(f"MODEL     {k + 1:4d}\n{ter.join(parts)}ENDMDL\n")
    return "".join(texts) + "END\n"


def drifting(n=5):
    """PDB text of models that drift by 3 Å, in which the last two residues fold away from the others, and of a water."""
    water = atom_line("O", "HOH", "A", "90", (40, 0, 0), record="HETATM", element="O")
    begin, end = (
        peptide(["ALA"] * k, first=first, origin=at)
        for k, first, at in ((4, 1, (0, 0, 0)), (2, 5, (12.6, 0, 0)))
    )
    models = []
    for k in range(n):
        text = moved(begin, 3.0 * k) + moved(end, 3.0 * k + [0, 0.4, 4.0, 8.0, 8.1][k % 5])
        models.append(f"MODEL     {k + 1:4d}\n{text}TER\n{water}ENDMDL\n")
    return "".join(models) + "END\n"
