"""Compare two forms of a protein by residue: find where surface and fields change significantly.

The forms need not be superposed, as the moments that describe a residue are invariant under rotation. Changes are compared
with floors: distances between a form and itself with other dots, or with randomly displaced atoms.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Collection, Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf import progress
from sparsurf.errors import InputError
from sparsurf.evaluation.floors import random_rotation, rotate
from sparsurf.molecules.conformations import BACKBONE, determines_rotation, superpose
from sparsurf.molecules.molecule import Molecule
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface
from sparsurf_study.pairs.residue_moments import (
    MOMENT_CHANNELS,
    MOMENT_FIELDS,
    ResidueMoments,
    describe_residues,
    distances,
)
from sparsurf_study.structures import read_study_structure

log = logging.getLogger("sparsurf")

TOTAL = "total"
N_FRESH_DRAWS = 5  # sets of fresh dots of each form
RMS_DISPLACEMENT = 0.3  # Å, of the atoms: a fair crystal structure
N_MOVED_DRAWS = 3  # sets of displaced atoms of each form
SHARE_ABOVE_FLOOR = 0.05  # share of a form's residues that exceed a floor by chance
MIN_COMMON_RESIDUES = 3  # Two forms must share so many residues.


class Form(NamedTuple):
    """One form of a protein."""

    name: str
    surface: Surface  # its `atom` refers to the atoms of the molecule
    molecule: Molecule  # of one frame
    generate_surface: Callable[[np.ndarray], Surface]  # of coordinates (A, 3), Å, of its atoms


def read_forms(
    name: str, files: Mapping[str, Sequence[str]], rules: SurfaceSettings, d_link: float
) -> tuple[Form, Form]:
    """Read the surfaces and structures of the two forms of a comparison, by their names; the second is numbered as the first."""
    paths = [structure for _, structure in files.values()]
    if paths[0] == paths[1]:
        raise InputError(f"changes.{name}: both names mean one conformation; name another.")
    reference = read_study_structure(paths[0])
    forms: list[Form] = []
    for form, (surface, structure) in files.items():
        molecule = numbered_alike(read_study_structure(structure), reference) if forms else reference
        generate, _ = surface_generator(molecule.xyz[0], radii(molecule, rules.radii), rules, d_link, form)
        forms.append(Form(form, read_npz(surface), molecule, generate))
    return forms[0], forms[1]


def noise(
    form: Form,
    residues: ResidueMoments,
    rng: np.random.Generator,
    moved: float = 0.0,
    draws: int = N_FRESH_DRAWS,
    threads: int = 1,
) -> np.ndarray:
    """Compute distances (draws, R, C + 1) of a form's residues from the same with fresh dots, or atoms `moved` by that rms, Å."""
    drawn, centre = [], form.molecule.xyz[0].mean(axis=0)
    for _ in progress.progress_bar(range(draws), f"floors of {form.name}"):
        rotation, atoms = random_rotation(rng), form.molecule.xyz[0]
        if moved:
            atoms = atoms + moved / np.sqrt(3) * rng.normal(size=atoms.shape)
        rotated = form.generate_surface(rotate(atoms - centre, rotation.T))
        points, normals = rotate(rotated.points, rotation) + centre, rotate(rotated.normals, rotation)
        dots = replace(rotated, points=points, normals=normals)
        other = describe_residues(dots, replace(form.molecule, xyz=atoms[None]), form.name, threads)
        drawn.append(distances(residues.moments, other.moments))
    return np.array(drawn)


def floor_of(drawn: np.ndarray) -> np.ndarray:
    """Estimate the distance of each residue that SHARE_ABOVE_FLOOR of its draws exceed, (R, C + 1).

    A residue has too few draws for a quantile: the root mean square of its draws is multiplied by a common factor, the quantile
    over all residues of the ratio of one draw to the others.
    """
    measured = ~np.isnan(drawn)
    if not measured.any():
        return np.full(drawn.shape[1:], np.nan)
    n, square = measured.sum(axis=0), np.nansum(drawn**2, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        other_rms = np.sqrt((square - np.where(measured, drawn, 0) ** 2) / (n - 1))
        ratio = np.where(measured & (n > 1), drawn / other_rms, np.nan)
        factor = np.full(
            ratio.shape[2:], np.nan
        )  # of a channel that no residue has, which numpy would warn of
        has_draws = ~np.isnan(ratio).all(axis=(0, 1))
        factor[has_draws] = np.nanquantile(ratio[..., has_draws], 1 - SHARE_ABOVE_FLOOR, axis=(0, 1))
        return factor * np.sqrt(square / n)


def changes(first: Form, second: Form, rng: np.random.Generator, threads: int = 1) -> pd.DataFrame:
    """Compare two forms, numbered alike (`numbered_alike`), by common residue: the rows of changes.csv."""
    forms = first, second
    described = [describe_residues(form.surface, form.molecule, form.name, threads) for form in forms]
    rows = common_residues(first, second)
    common = [
        ResidueMoments(residues.moments[row], residues.fields[row], residues.places[row])
        for residues, row in zip(described, rows, strict=True)
    ]

    def floor_with(displacement: float, draws: int) -> np.ndarray:
        drawn = []
        for form, residues, row in zip(forms, described, rows, strict=True):
            drawn.append(noise(form, residues, rng, displacement, draws, threads)[:, row])
        return floor_of(np.concatenate(drawn))

    fresh, moved = floor_with(0.0, N_FRESH_DRAWS), floor_with(RMS_DISPLACEMENT, N_MOVED_DRAWS)
    table = first.molecule.residues.iloc[rows[0]].reset_index(drop=True)
    table["residue_name_second"] = second.molecule.residues["residue_name"].to_numpy()[rows[1]]
    for side, residues in zip(("first", "second"), common, strict=True):
        table[f"places_{side}"] = residues.places
    change = distances(common[0].moments, common[1].moments)
    for k, name in reversed([*enumerate((*MOMENT_CHANNELS, TOTAL))]):  # the total stands first
        table[name], table[f"{name}_floor"] = change[:, k], fresh[:, k]
    table[f"{TOTAL}_moved"] = moved[:, -1]
    for name, floor in (("above", f"{TOTAL}_floor"), ("above_moved", f"{TOTAL}_moved")):
        table[name] = (table[TOTAL] > table[floor]).astype(int)
    for k, name in enumerate(MOMENT_FIELDS):
        table[f"{name}_difference"] = common[1].fields[:, k] - common[0].fields[:, k]
    return table


def unmatched_residues(first: Form, second: Form) -> tuple[str, str]:
    """Name the residues of each form that the other lacks, as ranges such as 'A:1-5,90'; empty if there are none."""
    tables = [form.molecule.residues for form in (first, second)]
    absent = [np.ones(len(table), bool) for table in tables]
    for mask, rows in zip(absent, common_residues(first, second), strict=True):
        mask[rows] = False
    return residue_ranges(tables[0], absent[0]), residue_ranges(tables[1], absent[1])


def warn_of_unmatched(first: Form, second: Form) -> tuple[str, str]:
    """Return the residues that the other form lacks, see `unmatched_residues`, and warn of them."""
    unmatched = unmatched_residues(first, second)
    for form, other, residues in zip((first, second), (second, first), unmatched, strict=True):
        if residues:
            message = (
                "%s lacks residues %s of %s, so changes next to them may come from that: "
                "restrict both forms to the same residues by `residues`"
            )
            log.warning(message, other.name, residues, form.name)
    return unmatched


def residue_ranges(residues: pd.DataFrame, selected: np.ndarray) -> str:
    """Write the selected residues as ranges of the key `residues`, such as 'A:1-5,90,B:7'."""
    parts, chain = [], None
    new_run = np.diff(selected, prepend=False) | (residues["chain"] != residues["chain"].shift()).to_numpy()
    for _, run in residues[selected].groupby(np.cumsum(new_run)[selected]):
        first, last = run["residue"].iloc[[0, -1]]
        prefix = f"{run['chain'].iloc[0]}:" if run["chain"].iloc[0] not in ("", chain) else ""
        chain = run["chain"].iloc[0]
        parts.append(prefix + (first if first == last else f"{first}-{last}"))
    return ",".join(parts)


def common_residues(first: Form, second: Form) -> tuple[np.ndarray, np.ndarray]:
    """Find the residues that two forms share by chain and number, at least `MIN_COMMON_RESIDUES`: two (R,) rows of each form."""
    row_of = []
    for form in (first, second):
        residues = form.molecule.residues
        labels = zip(residues["chain"], residues["residue"], strict=True)
        row_of.append({label: row for row, label in enumerate(labels)})
    common = [residue for residue in row_of[0] if residue in row_of[1]]
    if len(common) < MIN_COMMON_RESIDUES:
        raise InputError(
            f"{first.name} and {second.name} share {len(common)} residues by chain and number: number them alike."
        )
    rows = [np.array([row[residue] for residue in common]) for row in row_of]
    return rows[0], rows[1]


def numbered_alike(molecule: Molecule, reference: Molecule) -> Molecule:
    """Rename the chain of a molecule to that of the reference if both have a single chain."""
    chains = [np.unique(form.chain) for form in (molecule, reference)]
    if len(chains[0]) == len(chains[1]) == 1:
        return replace(molecule, chain=np.full_like(reference.chain, chains[1][0], shape=len(molecule.chain)))
    return molecule


def superpose_forms(second: Molecule, first: Molecule) -> Molecule:
    """Superpose the second form onto the first by shared C-alpha atoms; if on a line, by the backbone's, then by all atoms."""
    choices = [_common_atoms(second, first, names) for names in (("CA",), BACKBONE, None)]
    if len(common := choices[0][0]) < MIN_COMMON_RESIDUES:
        raise InputError(
            f"the two forms share {len(common)} residues by chain and number, but need {MIN_COMMON_RESIDUES} to be "
            "superposed: use the same residue numbers in both."
        )
    moved = second.frame(0)
    for moving, fixed in choices:
        if determines_rotation(moved.xyz, moving, first.xyz[0][fixed]):
            return replace(moved, xyz=superpose(moved.xyz, moving, first.xyz[0][fixed]))
    raise InputError(
        "the atoms that the two forms share lie on a line, or one form is a mirror image, so that several "
        "superpositions fit equally well: use forms with more atoms in common."
    )


def _common_atoms(
    molecule: Molecule, reference: Molecule, names: Collection[str] | None
) -> tuple[np.ndarray, np.ndarray]:
    """Return indices of the atoms that both molecules have, of some names or of all."""
    atoms = []
    for form in (molecule, reference):
        named = range(form.n_atoms) if names is None else np.flatnonzero(np.isin(form.name, list(names)))
        atoms.append({(form.chain[i], form.residue[i], form.name[i]): i for i in named})
    common = [key for key in atoms[0] if key in atoms[1]]
    moving, fixed = (np.array([atom_of[key] for key in common], int) for atom_of in atoms)
    return moving, fixed


def over_floor(table: pd.DataFrame) -> pd.Series:
    """Divide the change of each residue of changes.csv by the larger of its two floors; NaN if it is buried."""
    return table["total"] / table[["total_floor", "total_moved"]].max(axis=1)
