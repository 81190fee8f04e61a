"""The simulated system: a protein checked, given hydrogens, put into a box of water, neutralised."""

import logging
import re
from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.residues import PEPTIDE, count_heavy_atoms
from sparsurf.simulation import gromacs
from sparsurf.simulation.protocol import CHOICE, parameters, velocity_seed

log = logging.getLogger("sparsurf")

NAMED = 8  # residues that a sentence names; further ones are counted


def chosen_protein(path, protein):
    """The protein residues that a config's entry chooses from a structure, in its first model; no hydrogens.

    Raises
    ------
    InputError : see `molecules.read_molecule.read_molecule`
    """
    keys = {key: protein[key] for key in CHOICE if key in protein}
    molecule = read_molecule(path, hydrogens="remove", **keys)
    if molecule.n_frames > 1:
        log.warning(
            "%s has %d models: the first is simulated; `model` chooses another", path, molecule.n_frames
        )
    molecule = molecule.frame(0)
    return molecule.take(molecule.kind == "protein")


def prepare(molecule, path, settings, seed, folder):
    """Build the system in `folder`: topology (topol.top with what it includes), coordinates (system.gro).

    Hydrogens are built anew by the force field, chain ends are charged, disulphide bonds follow from distances.

    Parameters
    ----------
    molecule : molecules.molecule.Molecule of one frame, protein atoms only
    path : named in messages
    settings : dict, keys of protocol.DEFAULTS
    seed : int
    folder : Path, exists

    Returns
    -------
    dict of what was built: protein_atoms, waters, ions, atoms (int) and gromacs (str)

    Raises
    ------
    InputError : gaps, missing atoms, residues that the force field does not know, or GROMACS's own reason
    """
    version = gromacs.version()
    force_field = settings["force_field"]
    refuse_unknown(molecule, path, known_residues(gromacs.force_field_folder(force_field)), force_field)
    refuse_incomplete(molecule, path)
    molecule.write_pdb(Path(folder, "protein.pdb"))
    topology = ["-p", "topol.top"]
    gromacs.run("pdb2gmx", "-f", "protein.pdb", "-o", "hydrogens.gro", *topology, "-ff", force_field,
                "-water", settings["water"], "-ignh", folder=folder)  # fmt: skip
    with_chains(Path(folder, "hydrogens.gro"), molecule).write_pdb(Path(folder, "hydrogens.pdb"))
    gromacs.run("editconf", "-f", "hydrogens.gro", "-o", "box.gro", "-bt", "dodecahedron", "-c",
                "-d", settings["margin"] / 10, folder=folder)  # fmt: skip
    gromacs.run("solvate", "-cp", "box.gro", "-cs", "spc216", "-o", "water.gro", *topology, folder=folder)
    Path(folder, "ions.mdp").write_text(parameters("minimise", settings, seed), encoding="ascii")
    gromacs.run("grompp", "-f", "ions.mdp", "-c", "water.gro", *topology, "-o", "ions.tpr", "-maxwarn", 1,
                folder=folder)  # fmt: skip  # the one warning: a charge, which the ions are about to cure
    gromacs.run("genion", "-s", "ions.tpr", "-o", "system.gro", *topology, "-neutral", "-pname", "NA",
                "-nname", "CL", "-seed", velocity_seed(seed), folder=folder, given="SOL\n")  # fmt: skip
    for name in ("hydrogens.gro", "box.gro", "water.gro", "ions.tpr", "ions.mdp", "mdout.mdp"):
        Path(folder, name).unlink(missing_ok=True)
    return contents(folder) | {"gromacs": version}


def with_chains(path_to_gro, molecule):
    """The protein as GROMACS wrote it, residue by residue with the chains and labels of `molecule`.

    GRO files know no chains; PDB files, which do, would round the coordinates, and with them the number of waters.
    """
    built = read_molecule(path_to_gro, selection="all", whole=False)
    first = _first_atoms(molecule)
    if built.n_residues != len(first):
        raise InputError(
            f"GROMACS made {built.n_residues} residues of the {len(first)} given; choose protein residues only."
        )
    labels = {name: getattr(molecule, name)[first][built.residue_index] for name in ("chain", "residue")}
    return replace(built, **labels)


def contents(folder):
    """Numbers of atoms, waters and ions of a prepared system."""
    atoms = int(Path(folder, "system.gro").read_text(encoding="ascii").splitlines()[1])
    listed = Path(folder, "topol.top").read_text(encoding="latin-1").partition("[ molecules ]")[2]
    counts = {}
    for name, number in re.findall(r"^(\w\S*)\s+(\d+)\s*$", listed, re.M):
        counts[name] = counts.get(name, 0) + int(number)
    waters, ions = counts.get("SOL", 0), counts.get("NA", 0) + counts.get("CL", 0)
    per_water = len(re.findall(r"^\s*\d+SOL ", Path(folder, "system.gro").read_text(encoding="ascii"), re.M))
    return {"atoms": atoms, "protein_atoms": atoms - per_water - ions, "waters": waters, "ions": ions}


def known_residues(folder):
    """Names of the residues that a force field knows, from its building blocks and its table of names."""
    names = set()
    for path in Path(folder).glob("*.rtp"):
        names |= set(re.findall(r"^\[ *(\S+) *\]", path.read_text(encoding="latin-1"), re.M))
    for path in Path(folder).glob("*.r2b"):
        lines = path.read_text(encoding="latin-1").splitlines()
        names |= {line.split()[0] for line in lines if line.strip() and not line.startswith(";")}
    return names | {"HIS"}  # pdb2gmx gives it the protonation that its hydrogen bonds suggest


def refuse_unknown(molecule, path, known, force_field):
    """Raise InputError where residues are not in `known`, the names of a force field's residues."""
    first = _first_atoms(molecule)
    unknown = [i for i in first if molecule.residue_name[i] not in known]
    if unknown:
        raise InputError(
            f"{path}: the force field {force_field} does not know {_named(molecule, unknown)}; replace or leave out "
            "these residues (`residues:`), or give a trajectory made elsewhere."
        )


def refuse_incomplete(molecule, path):
    """Raise InputError where heavy atoms are missing or a chain has a gap: the simulation would not notice a gap."""
    first = _first_atoms(molecule)
    found, expected = count_heavy_atoms(molecule.residue_name, molecule.residue_index, molecule.element)
    lacking = [i for i, some, all_ in zip(first, found, expected, strict=True) if some < all_]
    if lacking:
        raise InputError(
            f"{path}: atoms are missing in {_named(molecule, lacking)}; build them with a modelling program, or "
            "leave the residues out (`residues:`)."
        )
    gaps = [f"{_label(molecule, i)} and {_label(molecule, j)}" for i, j in _gaps(molecule, first)]
    if gaps:
        rest = f" and {len(gaps) - NAMED} more places" if len(gaps) > NAMED else ""
        raise InputError(
            f"{path}: the chain is broken between {'; '.join(gaps[:NAMED])}{rest}; build what is missing, or choose "
            "a part without gaps (`residues:`)."
        )


def _gaps(molecule, first):
    """Pairs of first atoms of residues that follow each other in a chain without being bonded."""
    _, last, start, longest = PEPTIDE
    places = {name: np.full((len(first), 3), np.nan) for name in (last, start)}
    for name, place in places.items():
        at = molecule.name == name
        place[molecule.residue_index[at]] = molecule.xyz[0][at]
    apart = np.linalg.norm(places[last][:-1] - places[start][1:], axis=1)
    pairs = zip(first[:-1], first[1:], apart, strict=True)
    return [(i, j) for i, j, gap in pairs if molecule.chain[i] == molecule.chain[j] and not gap < longest]


def _first_atoms(molecule):
    return np.unique(molecule.residue_index, return_index=True)[1]


def _label(molecule, atom):
    chain = str(molecule.chain[atom]).strip()
    return f"{molecule.residue_name[atom]} {chain}{':' if chain else ''}{molecule.residue[atom]}"


def _named(molecule, atoms):
    rest = f" and {len(atoms) - NAMED} more" if len(atoms) > NAMED else ""
    return ", ".join(_label(molecule, i) for i in atoms[:NAMED]) + rest
