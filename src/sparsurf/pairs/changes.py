"""Two forms of a protein residue by residue: where its surface and fields differ by more than dots and coordinates do.

Each residue has the mean numbers of its places. No form is laid on the other: the numbers are those of `sites`, which no turn
changes. The floors are the same distances between a form and itself, with other dots or with its atoms moved.
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf import InputError, progress
from sparsurf.dot_fields.registry import values
from sparsurf.molecules.molecule import Molecule
from sparsurf.pairs.complexes import laid_on
from sparsurf.sites.describing import FIELDS, PERCENT, SHAPE, few_of, numbered_residues, sites_of
from sparsurf.sites.weighing import weights
from sparsurf.study.floors import random_rotation
from sparsurf.surfaces.surface import Surface

CHANNELS = (SHAPE, *FIELDS)
TOTAL = "total"
DRAWS = 5  # sets of fresh dots of each form
MOVED = 0.3  # Å, rms displacement of the atoms: a fair crystal structure
FEW_DRAWS = 3  # of moved atoms
RARE = 0.05  # share of residues of the same form that lie above a floor
COMMON = 3  # residues that two forms must share


class Form(NamedTuple):
    """One form of a protein.

    name : str
    surface : Surface, its `atom` counts the atoms of the molecule
    molecule : Molecule of one frame
    lay : function of places of its atoms (A, 3), Å, that gives their Surface
    """

    name: str
    surface: Surface
    molecule: Molecule
    lay: object


class Residues(NamedTuple):
    """Numbers of the residues of a form, NaN for those without places.

    numbers : (R, C, K) float64, mean moments of CHANNELS
    fields : (R, F) float64, mean of FIELDS
    places : (R,) int
    """

    numbers: np.ndarray
    fields: np.ndarray
    places: np.ndarray


def residues_of(dots, molecule, name, threads=1):
    """Residues of a molecule from the dots of its surface.

    The moment of n = 0 is the mean of a field; unlike in Sites it keeps its sign, so that a charge that turns round counts.
    """
    kept = few_of(dots, PERCENT)
    table = values(FIELDS, molecule, kept.points)
    # Lifted so far, a mean and its modulus are the same
    lift = np.ceil(np.nanmax(np.abs(table.to_numpy()), axis=0))
    kept = replace(kept, fields=dict(table + lift))
    sites = sites_of(kept, molecule.labels(kept.atom), name, PERCENT, threads=threads)
    numbers = sites.numbers.astype(float)
    numbers[:, 1:, 0] -= lift
    residues = molecule.residues
    return Residues(
        _means(
            numbers.reshape(len(numbers), -1), numbered_residues(sites.labels, residues), len(residues)
        ).reshape(len(residues), *numbers.shape[1:]),
        _means(table.to_numpy(), molecule.residue_index[kept.atom], len(residues)),
        np.bincount(molecule.residue_index[kept.atom], minlength=len(residues)),
    )


def _means(values, group, n):
    """Means (n, M) of rows by their group."""
    table = pd.DataFrame(values).groupby(group).mean()
    return table.reindex(range(n)).to_numpy()


def distances(first, second):
    """Distances (R, C + 1) between the numbers of residues: of each channel, and of all of them.

    In standard deviations of each moment over places of many proteins, the root mean square over the moments.
    """
    known = weights()
    order = [list(known["channels"]).index(channel) for channel in CHANNELS]
    scale = np.sqrt(np.diag(known["total"])).reshape(known["mean"].shape)[order]
    square = (((first - second) / scale) ** 2).mean(axis=2)
    return np.sqrt(np.column_stack([square, square.mean(axis=1)]))


def noise(form, own, rng, moved=0.0, draws=DRAWS, threads=1):
    """Distances (draws, R, C + 1) of a form's residues to its own on fresh dots, with its atoms moved by `moved` Å rms."""
    found, around = [], form.molecule.xyz[0].mean(axis=0)
    for _ in progress.each(range(draws), f"floors of {form.name}"):
        turn, atoms = random_rotation(rng), form.molecule.xyz[0]
        if moved:
            atoms = atoms + moved / np.sqrt(3) * rng.normal(size=atoms.shape)
        laid = form.lay((atoms - around) @ turn.T)
        dots = replace(laid, points=laid.points @ turn + around, normals=laid.normals @ turn)
        other = residues_of(dots, replace(form.molecule, xyz=atoms[None]), form.name, threads)
        found.append(distances(own.numbers, other.numbers))
    return np.array(found)


def floor_of(found, rare=RARE):
    """What a share `rare` of such distances exceeds, (R, C + 1), from (draws, R, C + 1): for each residue its own.

    A residue has too few draws for a quantile. Its root mean square is multiplied by the quantile over all residues of how much
    larger one draw is than the others.
    """
    known = ~np.isnan(found)
    if not known.any():
        return np.full(found.shape[1:], np.nan)
    n, square = known.sum(axis=0), np.nansum(found**2, axis=0)
    with np.errstate(invalid="ignore", divide="ignore"):
        others = np.sqrt((square - np.where(known, found, 0) ** 2) / (n - 1))
        factor = np.nanquantile(np.where(known & (n > 1), found / others, np.nan), 1 - rare, axis=(0, 1))
        return factor * np.sqrt(square / n)


def changes(first, second, rng, threads=1):
    """Compare two forms.

    Parameters
    ----------
    first, second : Form, the second numbered as the first, see `numbered_alike`
    rng : numpy.random.Generator
    threads : int

    Returns
    -------
    DataFrame, a row per residue that both have: LABELS, residue_name_second; places_first, places_second; `total` and CHANNELS,
    the distances, NaN where one of both is buried; total_floor and <channel>_floor of fresh dots, total_moved of moved atoms;
    `above` and `above_moved`, 1 where the total is larger; and <field>_difference, second less first, in the field's unit
    """
    both = [residues_of(each.surface, each.molecule, each.name, threads) for each in (first, second)]
    rows = common_residues(first, second)
    taken = [Residues(*(part[own] for part in each)) for each, own in zip(both, rows, strict=True)]
    found = distances(taken[0].numbers, taken[1].numbers)
    floors = []
    for moved, draws in ((0.0, DRAWS), (MOVED, FEW_DRAWS)):
        of_both = (
            noise(form, own, rng, moved, draws, threads)[:, place]
            for form, own, place in zip((first, second), both, rows, strict=True)
        )
        floors.append(floor_of(np.concatenate([*of_both])))
    table = first.molecule.residues.iloc[rows[0]].reset_index(drop=True)
    table["residue_name_second"] = second.molecule.residues["residue_name"].to_numpy()[rows[1]]
    for side, each in zip(("first", "second"), taken, strict=True):
        table[f"places_{side}"] = each.places
    names = (*CHANNELS, TOTAL)
    for name, values_, floor in zip(names[::-1], found.T[::-1], floors[0].T[::-1], strict=True):
        table[name], table[f"{name}_floor"] = values_, floor
    table[f"{TOTAL}_moved"] = floors[1][:, -1]
    for name, floor in (("above", f"{TOTAL}_floor"), ("above_moved", f"{TOTAL}_moved")):
        table[name] = (table[TOTAL] > table[floor]).astype(int)
    for k, name in enumerate(FIELDS):
        table[f"{name}_difference"] = taken[1].fields[:, k] - taken[0].fields[:, k]
    return table


def common_residues(first, second):
    """Rows of the residues that two forms share by chain and number: two (R,) int.

    Raises
    ------
    InputError : hardly any
    """
    numbers = [
        {row: k for k, row in enumerate(zip(table["chain"], table["residue"], strict=True))}
        for table in (first.molecule.residues, second.molecule.residues)
    ]
    common = [row for row in numbers[0] if row in numbers[1]]
    if len(common) < COMMON:
        raise InputError(
            f"{first.name} and {second.name} share {len(common)} residues by chain and number: number them alike."
        )
    return tuple(np.array([each[row] for row in common]) for each in numbers)


def numbered_alike(molecule, reference):
    """A molecule of one chain with the chain's name of the other, where both have one; else as it is."""
    chains = [np.unique(each.chain) for each in (molecule, reference)]
    if len(chains[0]) == len(chains[1]) == 1:
        return replace(molecule, chain=np.full_like(reference.chain, chains[1][0], shape=len(molecule.chain)))
    return molecule


def laid(second, first):
    """The second molecule moved onto the first by what they share, for pictures."""
    return laid_on(second, first, COMMON)
