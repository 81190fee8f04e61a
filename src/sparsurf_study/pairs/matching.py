"""Match two partners: distance maps, their agreement with the interface, tables by dot, residue and pair of patches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.descriptors import describe_patches
from sparsurf.settings import PatchesSettings
from sparsurf.streams import stream
from sparsurf_study.pairs.nearest import Nearest, nearest
from sparsurf_study.pairs.neighbourhoods import SMOOTHING, protrusion, smooth
from sparsurf_study.pairs.partners import INTERFACE, Partner, gaps, interface, native_pairs
from sparsurf_study.pairs.ranking import blocks_of_residues, bootstrap_auc

AREAS = ["partner", "score", "auc", "low", "high", "dots", "interface", "blocks"]  # columns of `agreement`
CONTACTS = ["against", "auc", "low", "high", "pairs"]  # columns of `contacts`
NEAREST = 10  # patches whose mean distance is the second map of a study, as in the authors' code
MAX_BEST_PAIRS = 100  # rows of the table of best-matching patches
MIN_PAIR_DISTANCE = 6.0  # Å, between two rows of that table, on at least one side
MAX_CONTACTS = 500  # native pairs that are evaluated
PUBLISHED_PATCHES = PatchesSettings()  # how patches are described


@dataclass(frozen=True, eq=False)
class Match:
    """Nearest patches of two partners at their centres."""

    partners: tuple[Partner, Partner]
    centres: tuple[np.ndarray, np.ndarray]  # (n,) int each, dots with descriptors
    complementary: tuple[Nearest, Nearest]  # the first seen 'up', the second 'down'
    similar: tuple[Nearest, Nearest]  # both seen 'up'


def descriptors_at(
    partner: Partner,
    centres: np.ndarray,
    up: bool,
    patches: PatchesSettings,
    threads: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Describe the patches around some positions, (n, 3) Å: descriptors, (n, M), and the number of dots in each patch, (n,)."""
    return describe_patches(partner.index, centres, patches.r_zernike, up, threads, patches.descriptor)


def match(
    first: Partner,
    second: Partner,
    centres: Sequence[np.ndarray | None] = (None, None),
    k: int = 1,
    patches: PatchesSettings = PUBLISHED_PATCHES,
    threads: int = 1,
) -> Match:
    """Compare all patches of two partners: the first seen 'up' with the second seen 'down', and both 'up'.

    Without `centres`, all dots are centres; centres whose patch has a single dot are excluded. Each keeps its `k` nearest ones.
    """
    kept, up = [], []
    for partner, dots in zip((first, second), centres, strict=True):
        dots = np.arange(len(partner.surface)) if dots is None else np.sort(dots)
        z, sizes = descriptors_at(partner, partner.surface.points[dots], True, patches, threads)
        kept.append(dots[sizes > 1])
        up.append(z[sizes > 1])
    down, _ = descriptors_at(second, second.surface.points[kept[1]], False, patches, threads)
    complementary, similar = nearest(up[0], down, k, threads), nearest(up[0], up[1], k, threads)
    return Match((first, second), (kept[0], kept[1]), complementary, similar)


def maps(match_: Match, side: int, smoothing: float = SMOOTHING, threads: int = 1) -> pd.DataFrame:
    """Compute the distance maps of one partner (0 or 1) on all its dots.

    `propensity` and `similarity` are the distance to the nearest patch of the partner, and `propensity_k` is the mean of the k
    nearest (NaN where no patch is evaluated); `match` is the partner's dot with the nearest patch (-1 for none).
    """
    points, centres = match_.partners[side].surface.points, match_.centres[side]
    near = match_.complementary[side]
    at_centres = {"propensity": near.distance[:, 0], "propensity_k": near.mean()}
    at_centres["similarity"] = match_.similar[side].distance[:, 0]
    table = pd.DataFrame(index=np.arange(len(points)))
    for name, values in at_centres.items():
        table[name] = _scatter(centres, values, len(points), np.nan)
        table[f"{name}_smoothed"] = smooth(points, centres, values, smoothing, threads)
    table["match"] = _scatter(centres, match_.centres[1 - side][near.partner[:, 0]], len(points), -1)
    return table


def _scatter(dots: np.ndarray, values: np.ndarray, n: int, missing: float) -> np.ndarray:
    """Return an array of n with the values of some dots, and `missing` elsewhere."""
    scattered = np.full(n, missing, np.result_type(values, type(missing)))
    scattered[dots] = values
    return scattered


def by_dot(match_: Match, side: int, table: pd.DataFrame, within: float = INTERFACE) -> pd.DataFrame:
    """Tabulate propensity.csv: position, residue, maps, distance to the partner in the files, and whether in the interface."""
    partner, other = match_.partners[side], match_.partners[1 - side]
    out = pd.DataFrame({"dot": np.arange(len(partner.surface))})
    out[["x", "y", "z"]] = partner.surface.points
    if partner.residues is not None and partner.residue is not None:
        rows = partner.residues.iloc[partner.residue].reset_index(drop=True)
        out[list(rows.columns)] = rows
    out = pd.concat([out, table], axis=1)
    out["gap"] = gaps(partner.surface.points, other.surface.points)[0]
    out["interface"] = (out["gap"] < within).astype(int)
    return out


def by_residue(dots: pd.DataFrame) -> pd.DataFrame:
    """Average each map over the dots of a residue of a partner; `interface` is the share of its dots in the interface."""
    keys = ["partner", "chain", "residue", "residue_name"]
    names = ["propensity_smoothed", "propensity_k_smoothed", "similarity_smoothed", "interface"]
    grouped = dots.groupby(keys, sort=False, dropna=False)
    table = grouped[names].mean()
    table.insert(0, "dots", grouped.size())
    return table.reset_index()


def on_atoms(molecule: Molecule, residues: pd.DataFrame, name: str, buried: float = np.nan) -> np.ndarray:
    """Assign a column of `by_residue` to the atoms of a molecule, (A,); residues without a row have the value `buried`."""
    values = dict(zip(zip(residues["chain"], residues["residue"], strict=True), residues[name], strict=True))
    keys = zip(molecule.chain, molecule.residue, strict=True)
    return np.array([values.get(key, buried) for key in keys], np.float64)


def best_pairs(match_: Match, n: int = MAX_BEST_PAIRS) -> pd.DataFrame:
    """List the n best-matching pairs of patches, none within MIN_PAIR_DISTANCE of a better one on both sides."""
    sides = [
        np.column_stack([match_.centres[0], match_.centres[1][match_.complementary[0].partner[:, 0]]]),
        np.column_stack([match_.centres[0][match_.complementary[1].partner[:, 0]], match_.centres[1]]),
    ]
    pairs = np.concatenate(sides)
    distance = np.concatenate([near.distance[:, 0] for near in match_.complementary])
    points = [match_.partners[side].surface.points[pairs[:, side]] for side in (0, 1)]
    kept: list[int] = []
    for i in np.lexsort((pairs[:, 1], pairs[:, 0], distance)):
        near = [np.linalg.norm(x[kept] - x[i], axis=1) < MIN_PAIR_DISTANCE for x in points]
        if not (near[0] & near[1]).any():
            kept.append(int(i))
        if len(kept) == n:
            break
    table = pd.DataFrame({"rank": np.arange(1, len(kept) + 1)})
    for side in (0, 1):
        partner = match_.partners[side]
        table[f"dot_{side + 1}"] = pairs[kept, side]
        if partner.residues is not None and partner.residue is not None:
            rows = partner.residues.iloc[partner.residue[pairs[kept, side]]]
            names = rows["chain"] + ":" + rows["residue_name"] + rows["residue"]
            table[f"residue_{side + 1}"] = names.to_numpy()
    table["distance"] = distance[kept]
    table["gap"] = np.linalg.norm(points[0][kept] - points[1][kept], axis=1)
    return table


def agreement(
    match_: Match, side: int, table: pd.DataFrame, within: float = INTERFACE, seed: int = 0, threads: int = 1
) -> pd.DataFrame | None:
    """Compute the AUC of the maps, and of protrusion if the atoms are known, at one side's centres: the rows of agreement.csv.

    Intervals are by a bootstrap over blocks of residues; None if the partners do not touch, or touch everywhere.
    """
    partner, centres = match_.partners[side], match_.centres[side]
    points = partner.surface.points[centres]
    positive = interface(points, match_.partners[1 - side].surface.points, within)
    if positive.all() or not positive.any():
        return None
    at_centres = table.iloc[centres]
    scores = {name: -at_centres[name].to_numpy() for name in table.columns if name != "match"}
    if partner.heavy_atoms is not None:
        scores["protrusion"] = protrusion(points, partner.heavy_atoms, threads)
    block = blocks_of(partner, centres)
    areas = bootstrap_auc(scores, positive, block, stream(seed, "agreement", partner.name))
    rows = pd.DataFrame([(name, *area) for name, area in areas.items()], columns=AREAS[1:5])
    return rows.assign(dots=len(centres), interface=int(positive.sum()), blocks=int(block.max()) + 1)


def tables_of_partners(
    match_: Match, smoothing: float, within: float, seed: int, threads: int = 1
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Tabulate the maps of both partners by dot, and their agreement with the interface."""
    dots, areas = [], []
    for side in (0, 1):
        table = maps(match_, side, smoothing, threads)
        dots.append(by_dot(match_, side, table, within))
        dots[-1].insert(0, "partner", side + 1)
        of_side = agreement(match_, side, table, within, seed, threads)
        if of_side is not None:
            of_side.insert(0, "partner", side + 1)
            areas.append(of_side)
    return pd.concat(dots), pd.concat(areas) if areas else pd.DataFrame(columns=AREAS)


def blocks_of(partner: Partner, dots: np.ndarray) -> np.ndarray:
    """Group some dots into blocks of residues, or of dots if the residues are unknown; return the block of each."""
    units = np.arange(len(dots)) if partner.residue is None else partner.residue[dots]
    return blocks_of_residues(partner.surface.points[dots], units)


def contacts(
    first: Partner,
    second: Partner,
    within: float = INTERFACE,
    patches: PatchesSettings = PUBLISHED_PATCHES,
    seed: int = 0,
    threads: int = 1,
) -> pd.DataFrame:
    """Test whether patches in contact match better than others: the rows of contacts.csv, none if the partners do not touch.

    Each dot of the first partner's interface has a native partner, the nearest dot of the second surface. It is compared with a
    random dot ('any pair'), and with the native partner of another dot ('exchanged'). Only the latter is unbiased: the nearest
    dot often lies on a protruding patch, whose descriptor is far from all others. auc is the probability that the native pair is
    nearer, with an interval by a bootstrap over blocks of the first partner's residues.
    """
    pairs = native_pairs(first.surface.points, second.surface.points, within)
    if len(pairs) < 2:
        return pd.DataFrame(columns=CONTACTS)
    rng = stream(seed, "contacts", first.name, second.name)
    pairs = pairs[np.sort(rng.permutation(len(pairs))[:MAX_CONTACTS])]
    alternatives = {"any pair": rng.integers(len(second.surface), size=len(pairs))}
    alternatives["exchanged"] = rng.permutation(pairs[:, 1])
    up, _ = descriptors_at(first, first.surface.points[pairs[:, 0]], True, patches, threads)

    def distance_to(dots: np.ndarray) -> np.ndarray:
        """Return the distances of the descriptors to those of some dots of the second partner."""
        down, _ = descriptors_at(second, second.surface.points[dots], False, patches, threads)
        return np.linalg.norm(up - down, axis=1)

    native = distance_to(pairs[:, 1])
    block = blocks_of(first, pairs[:, 0])
    rows = []
    for name, dots in alternatives.items():
        random = distance_to(dots)
        positive = np.repeat([True, False], len(pairs))
        score = {name: -np.concatenate([native, random])}
        area = bootstrap_auc(score, positive, np.tile(block, 2), stream(seed, "contacts", name, first.name))
        rows.append((name, *area[name], len(pairs)))
    return pd.DataFrame(rows, columns=CONTACTS)
