"""What a page draws beside a molecule: the ligands, ions and nucleic acids of its file, and what touches what."""

from __future__ import annotations

import logging
from dataclasses import fields, replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.areas import (
    contacts_over_frames,
    maximal_areas,
    refuse_overlapping_partners,
    sums_of_contacts,
)
from sparsurf.arguments import TOUCHED_AREA
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.messages import no_warnings
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.residues import first_atoms
from sparsurf.molecules.selection import POLYMERS, Partners, partners_of_atoms
from sparsurf.surfaces.areas import areas_of_rolled, areas_of_spheres, contacts_of_rolled
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.grid import pairs_within
from sparsurf.surfaces.radii import radii

if TYPE_CHECKING:
    from collections.abc import Iterable

    import pandas as pd

    from sparsurf.surfaces.surface import Rules

log = logging.getLogger("sparsurf")

NEAR_MOLECULE = 6.0  # Å, from a ligand that is drawn to the molecule
SAME_POSITION = 0.01  # Å
MAX_NAMED = 6  # A sentence names at most so many residues.
MOST_BURIED, LIGANDS_NAMED = 3, 3  # residues of each ligand, and ligands, that a page begins with


def with_surroundings(molecule: Molecule) -> Molecule:
    """Return a molecule, followed by the ligands, ions and nucleic acids of its file that lie close to it and are no part of it.

    None follow where the molecule was moved since it was read, or has other frames than its file.
    """
    if not molecule.files or molecule.masked_residues:
        return molecule
    for assembly in (False, True):  # the chains of an assembly are not those of its file
        try:
            with no_warnings():
                whole = read_molecule(*molecule.files[:2], selection="all", assembly=assembly)
        except (InputError, OSError, TypeError):
            return molecule
        place = {key: k for k, key in enumerate(_keys(whole))}
        placed = np.array([place.get(key, -1) for key in _keys(molecule)])
        if (placed >= 0).all():
            break
    else:
        return molecule
    if molecule.n_frames not in (1, whole.n_frames):
        return molecule
    off = np.abs(whole.xyz[:, placed] - molecule.xyz).max(axis=(1, 2))
    if molecule.n_frames == 1:  # of a file of several models, it may be any
        whole, off = whole.frame(int(off.argmin())), off.min()
    if np.any(off > SAME_POSITION):
        return molecule
    strangers = np.setdiff1d(np.flatnonzero(~np.isin(whole.kind, ("protein", "water"))), placed)
    near = strangers[pairs_within(molecule.xyz[0], whole.xyz[0, strangers], NEAR_MOLECULE)[0]]
    is_nucleic = whole.kind == "nucleic"
    strands = whole.chain[near[is_nucleic[near]]]
    chosen = np.isin(whole.residue_index, whole.residue_index[near]) | (
        is_nucleic & np.isin(whole.chain, strands)
    )
    chosen[placed] = False
    around = whole.take(chosen)
    names = [attribute.name for attribute in fields(molecule)][3:-3]  # of the columns of atoms
    columns: dict[str, Any] = {
        name: np.concatenate([getattr(molecule, name), getattr(around, name)]) for name in names
    }
    columns["residue_index"][molecule.n_atoms :] += molecule.n_residues
    return replace(molecule, xyz=np.concatenate([molecule.xyz, around.xyz], axis=1), **columns)


def _keys(molecule: Molecule) -> list[tuple[str, ...]]:
    """Return what identifies each atom."""
    columns = (molecule.chain, molecule.residue, molecule.residue_name, molecule.name)
    return [*zip(*(column.tolist() for column in columns), strict=True)]


def drawn_without_surface(drawn: Molecule, n_atoms: int) -> list[str]:
    """Return the sentence on what a page draws beside the first atoms of a molecule; none where there is nothing."""
    labels = [*dict.fromkeys(drawn.residue_label(atom) for atom in range(n_atoms, drawn.n_atoms))]
    if not labels:
        return []
    unnamed = f" and {len(labels) - MAX_NAMED} more" if len(labels) > MAX_NAMED else ""
    first = ", ".join(labels[:MAX_NAMED]) + unnamed
    verb, them = ("is", "it") if len(labels) == 1 else ("are", "them")
    return [f"{first} {verb} drawn, and the surface leaves {them} out."]


def contacts_on_page(drawn: Molecule, frames: Iterable[np.ndarray], rules: Rules) -> pd.DataFrame | None:
    """Return the contacts of a molecule over frames (A, 3), Å, as `frames` does, the largest first.

    None where there are none, or where partners overlap, as a warning then says.

    Columns are the `number` of the residue, its `own` partner, the `partner` that buries it, `occupancy`, `mean`, Å^2, and
    `together`, Å^2, which all partners bury of the residue in the mean.
    """
    number, names = partners_of_atoms(drawn)
    chains = {*drawn.chain[np.isin(drawn.kind, POLYMERS)].tolist()}
    partners = Partners(number, [f"chain {name}".strip() if name in chains else name for name in names])
    if len(partners.names) == 1:
        return None
    sizes = _radii_on_page(drawn, rules)
    found, together = [], np.zeros(drawn.n_residues)
    for xyz in frames:
        try:
            refuse_overlapping_partners(drawn, partners, xyz.round(3))
        except InputError as error:
            log.warning("contacts are left out: %s", str(error).removeprefix("areas: "))
            return None
        rolled = roll_checked(xyz.round(3), sizes, rules.probe_radius, in_order=True)
        atom, partner, buried = contacts_of_rolled(rolled, partners.number)
        found.append(sums_of_contacts(drawn.residue_index[atom], partner, buried))
        together += np.bincount(drawn.residue_index, areas_of_rolled(rolled, partners.number).buried)
    table = contacts_over_frames(drawn, partners, found, len(found)).rename_axis("number").reset_index()
    first = first_atoms(drawn.residue_index)
    table["own"] = partners.labels[first[table["number"]]]
    table["together"] = together[table["number"]] / len(found)
    table = table[table["mean"] >= TOUCHED_AREA]
    return table.sort_values("mean", ascending=False, kind="stable", ignore_index=True)


def ligands_first(contacts: pd.DataFrame | None, molecule: Molecule) -> tuple[pd.DataFrame | None, str]:
    """Return contacts with those of the ligands of a molecule first, and the sentence on the residues that these touch."""
    ligands = np.unique(molecule.residue_index[~np.isin(molecule.kind, POLYMERS)])
    if contacts is None or not len(ligands):
        return contacts, ""
    names = contacts.loc[contacts["number"].isin(ligands), "own"]
    by_ligand = contacts["partner"].isin(names) & ~contacts["number"].isin(ligands)
    sentences = []
    for name, rows in contacts[by_ligand].groupby("partner", sort=False):
        buried = ", ".join(
            f"{row.residue_name} {row.residue} {row.chain} ({row.mean:.1f}\u00a0Å²)".replace("  ", " ")
            for row in rows.head(MOST_BURIED).itertuples()
        )
        sentences.append(
            (len(rows), f"{name} touches {pluralise(len(rows), 'residue')}, the most buried first: {buried}.")
        )
    sentences.sort(key=lambda pair: -pair[0])
    texts = [text for _, text in sentences[:LIGANDS_NAMED]]
    if len(sentences) > LIGANDS_NAMED:
        texts.append(f"The list has those of {pluralise(len(sentences) - LIGANDS_NAMED, 'further ligand')}.")
    order = np.argsort(~by_ligand.to_numpy(), kind="stable")
    return contacts.iloc[order].reset_index(drop=True), " ".join(texts)


def relative_areas(molecule: Molecule, frame: int, rules: Rules) -> np.ndarray:
    """Return the relative accessible area of each residue of a molecule, (R,); NaN where it is not known."""
    xyz, sizes = molecule.xyz[frame].round(3), _radii_on_page(molecule, rules)
    partner = np.zeros(molecule.n_atoms, int)
    accessible = areas_of_spheres(xyz, sizes, rules.probe_radius, partner, with_excluded=False).accessible
    names = molecule.residues["residue_name"].to_numpy(str)
    return np.bincount(molecule.residue_index, accessible) / maximal_areas(names)


def _radii_on_page(molecule: Molecule, rules: Rules) -> np.ndarray:
    """Return the radii that the dots have; those of DMS where the user has none of an atom that is drawn with them."""
    try:
        return radii(molecule, rules.radii)
    except InputError:
        return radii(molecule, "dms")
