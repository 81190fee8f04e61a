"""Prepare the simulated system: check a protein, add hydrogens, put it into a box of water, and neutralise it."""

from __future__ import annotations

import logging
import os
import re
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.residues import PEPTIDE, atoms_of_residues, count_heavy_atoms
from sparsurf_study.simulation import gromacs
from sparsurf_study.simulation.protocol import SELECTION_KEYS, parameters, velocity_seed

if TYPE_CHECKING:
    from collections.abc import Sequence

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

MAX_NAMED_RESIDUES = 8  # residues named in a message; the others are only counted


def select_protein(path: str | os.PathLike[str], protein: dict[str, Any]) -> Molecule:
    """Read the protein residues that a config's entry selects from the first model of a structure, without hydrogens."""
    keys = {key: protein[key] for key in SELECTION_KEYS if key in protein}
    molecule = read_molecule(path, hydrogens="remove", **keys)
    if molecule.n_frames > 1:
        log.warning(
            "%s has %d models; the first is simulated. Select another one with `model`.",
            path,
            molecule.n_frames,
        )
    molecule = molecule.frame(0)
    return molecule.take(molecule.kind == "protein")


def prepare_system(
    molecule: Molecule,
    path: str | os.PathLike[str],
    settings: dict[str, Any],
    seed: int,
    folder: str | os.PathLike[str],
) -> dict[str, int | str]:
    """Build the system of one frame of protein atoms in `folder`: topology (topol.top with its files) and system.gro.

    All hydrogens are built by the force field, chain ends are charged, and disulphide bonds are found by distance. Refused are
    gaps in a chain, missing atoms, and unknown residues. Returns protein_atoms, waters, ions, atoms and the version of gromacs.
    """
    version = gromacs.version()
    force_field = settings["force_field"]
    refuse_unknown(molecule, path, known_residues(gromacs.force_field_folder(force_field)), force_field)
    refuse_incomplete(molecule, path)
    molecule.write_pdb(Path(folder, "protein.pdb"))
    topology = ["-p", "topol.top"]
    gromacs.run_gromacs("pdb2gmx", "-f", "protein.pdb", "-o", "hydrogens.gro", *topology, "-ff", force_field,
                "-water", settings["water"], "-ignh", folder=folder)  # fmt: skip
    with_chains(Path(folder, "hydrogens.gro"), molecule).write_pdb(Path(folder, "hydrogens.pdb"))
    gromacs.run_gromacs("editconf", "-f", "hydrogens.gro", "-o", "box.gro", "-bt", "dodecahedron", "-c",
                "-d", settings["margin"] / 10, folder=folder)  # fmt: skip
    gromacs.run_gromacs(
        "solvate", "-cp", "box.gro", "-cs", "spc216", "-o", "water.gro", *topology, folder=folder
    )
    Path(folder, "ions.mdp").write_text(parameters("minimise", settings, seed), encoding="ascii")
    gromacs.run_gromacs("grompp", "-f", "ions.mdp", "-c", "water.gro", *topology, "-o", "ions.tpr", "-maxwarn", 1,
                folder=folder)  # fmt: skip  # the one warning is about the charge, which the ions neutralise
    gromacs.run_gromacs("genion", "-s", "ions.tpr", "-o", "system.gro", *topology, "-neutral", "-pname", "NA",
                "-nname", "CL", "-seed", velocity_seed(seed), folder=folder, stdin="SOL\n")  # fmt: skip
    for name in ("hydrogens.gro", "box.gro", "water.gro", "ions.tpr", "ions.mdp", "mdout.mdp"):
        Path(folder, name).unlink(missing_ok=True)
    return count_molecules(folder) | {"gromacs": version}


def with_chains(path_to_gro: str | os.PathLike[str], molecule: Molecule) -> Molecule:
    """Read the protein that GROMACS wrote as GRO, which has no chains, with the chains and numbers of `molecule`."""
    built = read_molecule(path_to_gro, selection="all", whole=False)
    first = _first_atoms(molecule)
    if built.n_residues != len(first):
        raise InputError(
            f"GROMACS built {built.n_residues} residues from {len(first)}; select protein residues only."
        )
    labels = {name: getattr(molecule, name)[first][built.residue_index] for name in ("chain", "residue")}
    return replace(built, **labels)


def count_molecules(folder: str | os.PathLike[str]) -> dict[str, int]:
    """Count atoms, waters and ions of a prepared system."""
    atoms = int(Path(folder, "system.gro").read_text(encoding="ascii").splitlines()[1])
    molecules = Path(folder, "topol.top").read_text(encoding="latin-1").partition("[ molecules ]")[2]
    counts: dict[str, int] = {}
    for name, number in re.findall(r"^(\w\S*)\s+(\d+)\s*$", molecules, re.M):
        counts[name] = counts.get(name, 0) + int(number)
    waters, ions = counts.get("SOL", 0), counts.get("NA", 0) + counts.get("CL", 0)
    water_atoms = len(
        re.findall(r"^\s*\d+SOL ", Path(folder, "system.gro").read_text(encoding="ascii"), re.M)
    )
    return {"atoms": atoms, "protein_atoms": atoms - water_atoms - ions, "waters": waters, "ions": ions}


def known_residues(folder: str | os.PathLike[str]) -> set[str]:
    """Return the residue names that a force field knows, from its building blocks and its table of names."""
    names = set()
    for path in Path(folder).glob("*.rtp"):
        names |= set(re.findall(r"^\[ *(\S+) *\]", path.read_text(encoding="latin-1"), re.M))
    for path in Path(folder).glob("*.r2b"):
        lines = path.read_text(encoding="latin-1").splitlines()
        names |= {line.split()[0] for line in lines if line.strip() and not line.startswith(";")}
    return names | {"HIS"}  # pdb2gmx chooses its protonation by hydrogen bonds


def refuse_unknown(
    molecule: Molecule, path: str | os.PathLike[str], residue_names: set[str], force_field: str
) -> None:
    """Raise InputError if residues are not among `residue_names`, those of a force field."""
    first = _first_atoms(molecule)
    unknown = [i for i in first if molecule.residue_name[i] not in residue_names]
    if unknown:
        raise InputError(
            f"{path}: the force field {force_field} does not know {_names(molecule, unknown)}; replace or leave out "
            "these residues (`residues:`), or give a trajectory instead."
        )


def refuse_incomplete(molecule: Molecule, path: str | os.PathLike[str]) -> None:
    """Raise InputError if heavy atoms are missing or a chain has a gap, which GROMACS would not notice."""
    first = _first_atoms(molecule)
    present, expected = count_heavy_atoms(molecule.residue_name, molecule.residue_index, molecule.element)
    counts = zip(first, present, expected, strict=True)
    incomplete = [atom for atom, n_present, n_expected in counts if n_present < n_expected]
    if incomplete:
        raise InputError(
            f"{path}: atoms are missing in {_names(molecule, incomplete)}; build them with a modelling program, or "
            "leave the residues out (`residues:`)."
        )
    gaps = [f"{molecule.residue_label(i)} and {molecule.residue_label(j)}" for i, j in _gaps(molecule, first)]
    if gaps:
        remainder = (
            f" and {len(gaps) - MAX_NAMED_RESIDUES} more places" if len(gaps) > MAX_NAMED_RESIDUES else ""
        )
        raise InputError(
            f"{path}: the chain is broken between {'; '.join(gaps[:MAX_NAMED_RESIDUES])}{remainder}; model the missing "
            "residues, or select a part without gaps (`residues:`)."
        )


def _gaps(molecule: Molecule, first: np.ndarray) -> list[tuple[int, int]]:
    """Find consecutive residues of a chain that are not bonded, as pairs of their first atoms."""
    last, start = (
        atoms_of_residues(molecule.residue_index, molecule.name == name, len(first))
        for name in (PEPTIDE.last, PEPTIDE.first)
    )
    length = np.linalg.norm(molecule.xyz[0][last[:-1]] - molecule.xyz[0][start[1:]], axis=1)
    bonded = (last[:-1] >= 0) & (start[1:] >= 0) & (length < PEPTIDE.max_length)
    pairs = zip(first[:-1].tolist(), first[1:].tolist(), bonded, strict=True)
    return [(i, j) for i, j, bond in pairs if molecule.chain[i] == molecule.chain[j] and not bond]


def _first_atoms(molecule: Molecule) -> np.ndarray:
    """Return the first atom of each residue."""
    return np.unique(molecule.residue_index, return_index=True)[1]


def _names(molecule: Molecule, atoms: Sequence[int]) -> str:
    """Return the labels of the first residues, and the number of the others."""
    remainder = f" and {len(atoms) - MAX_NAMED_RESIDUES} more" if len(atoms) > MAX_NAMED_RESIDUES else ""
    return ", ".join(molecule.residue_label(i) for i in atoms[:MAX_NAMED_RESIDUES]) + remainder
