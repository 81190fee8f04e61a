"""One attempt to beat residue composition across folds: atoms by what they can bind, with a learned metric.

Atoms around a point are counted in shells by channel. Fisher's linear discriminant is learned from places of relatives and
from sites of cofactors of some folds, and tried on the cofactors of the other folds.
"""

from collections.abc import Sequence

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from measures.alignments import by_sequence
from measures.cofactors import OTHER_FOLD, REACH, RIGHT, SEED
from measures.sites import COMPOSITION, residues_around
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.sites.metric import discriminant, learn_weights

SHELLS, WIDTH = (3.0, 5.0, 7.0, 9.0), 1.2  # Å, middles of the shells and their standard deviation
CHANNELS = ("donor", "acceptor", "aromatic", "aliphatic", "positive", "negative")
DONORS = (
    "N LYS:NZ ARG:NE ARG:NH1 ARG:NH2 ASN:ND2 GLN:NE2 HIS:ND1 HIS:NE2 TRP:NE1 SER:OG THR:OG1 TYR:OH CYS:SG"
)
ACCEPTORS = "O ASP:OD1 ASP:OD2 GLU:OE1 GLU:OE2 ASN:OD1 GLN:OE1 HIS:ND1 HIS:NE2 SER:OG THR:OG1 TYR:OH MET:SD"
AROMATIC = {
    "PHE": "CG CD1 CD2 CE1 CE2 CZ", "TYR": "CG CD1 CD2 CE1 CE2 CZ", "HIS": "CG ND1 CD2 CE1 NE2",
    "TRP": "CG CD1 CD2 NE1 CE2 CE3 CZ2 CZ3 CH2",
}  # fmt: skip
POSITIVE, NEGATIVE = "LYS:NZ ARG:NE ARG:NH1 ARG:NH2", "ASP:OD1 ASP:OD2 GLU:OE1 GLU:OE2"
CHANNELS_LEARNED = "atoms by channel, learned"
PLACES = 200  # on each relative
RESAMPLED = 4000


def channels(molecule: Molecule) -> np.ndarray:
    """Return whether each atom belongs to each of CHANNELS, (A, 6) float."""
    residues = [standard_name(str(name)) for name in molecule.residues["residue_name"]]
    names = [(residues[k], str(name)) for k, name in zip(molecule.residue_index, molecule.name, strict=True)]
    lists = [set(text.split()) for text in (DONORS, ACCEPTORS, POSITIVE, NEGATIVE)]
    donor, acceptor, positive, negative = (
        np.array([name in own or f"{residue}:{name}" in own for residue, name in names]) for own in lists
    )
    ring = np.array([name in AROMATIC.get(residue, "").split() for residue, name in names])
    carbon = np.array([name.startswith("C") for _, name in names])
    return np.stack([donor, acceptor, ring, carbon & ~ring, positive, negative], axis=1).astype(float)


def around(molecule: Molecule, points: np.ndarray) -> np.ndarray:
    """Return the numbers of points: square roots of soft counts of atoms, (P, 6, 4) by channel and shell."""
    kinds, out = channels(molecule), np.zeros((len(points), len(CHANNELS), len(SHELLS)))
    for row, point, near in zip(
        out, points, cKDTree(molecule.xyz[0]).query_ball_point(points, REACH), strict=True
    ):
        far = np.linalg.norm(molecule.xyz[0][near] - point, axis=1)
        weight = np.exp(-(((far[:, None] - np.array(SHELLS)) / WIDTH) ** 2) / 2)
        row[:] = np.sqrt(kinds[near].T @ weight)
    return out


def relatives(pairs: Sequence[tuple[Molecule, Molecule]], points: Sequence[np.ndarray]) -> np.ndarray:
    """Return the numbers of points of proteins and of where an alignment moves them on relatives: (2, P, 6, 4)."""
    both = [
        (around(query, own), around(relative, by_sequence(query, relative, own)))
        for (query, relative), own in zip(pairs, points, strict=True)
    ]
    return np.stack([np.concatenate(side) for side in zip(*both, strict=True)])


def folds(names: Sequence[str], tm: pd.Series) -> np.ndarray:
    """Assign proteins to folds (N,) int: chains of TM-scores of at least OTHER_FOLD join them."""
    fold = np.arange(len(names))
    for (first, second), score in tm.items():
        if score >= OTHER_FOLD:
            a, b = (fold[list(names).index(name)] for name in (first, second))
            fold[fold == b] = a
    return np.unique(fold, return_inverse=True)[1]


def measure(
    names: Sequence[str],
    classes: Sequence[str],
    molecules: Sequence[Molecule],
    middles: Sequence[np.ndarray],
    above: Sequence[np.ndarray],
    tm: pd.Series,
    of_relatives: np.ndarray,
) -> pd.DataFrame:
    """Seek each site on proteins of another fold that bind the same, with weights from the other half of the folds.

    Parameters
    ----------
    names, classes, molecules, middles : of the sites
    above : (P, 3) of each protein, points in the space above its surface
    tm : Series, TM-score by (query, target)
    of_relatives : (2, P, 6, 4), see `relatives`

    Returns
    -------
    DataFrame: query, target, class, half, method, off (Å), right
    """
    fold = folds(names, tm)
    order = np.argsort(-np.bincount(fold), kind="stable")  # the largest fold is half 1, all others half 2
    half = np.where(fold == order[0], 1, 2)
    sites = [around(each, middle[None])[0] for each, middle in zip(molecules, middles, strict=True)]
    candidates = [around(each, own) for each, own in zip(molecules, above, strict=True)]
    counts = [residues_around(each, own, REACH) for each, own in zip(molecules, above, strict=True)]
    rows = []
    for test in (1, 2):
        known = np.flatnonzero(half != test)
        pairs = [(i, j) for i in known for j in known if i < j and classes[i] == classes[j]]
        matching = np.stack([[sites[i] for i, _ in pairs], [sites[j] for _, j in pairs]])
        # as many sites as relatives: each pair of sites counts as often as it takes
        repeat = max(1, of_relatives.shape[1] // len(pairs))
        learned = learn_weights(
            np.concatenate([of_relatives, np.repeat(matching, repeat, axis=1)], axis=1),
            np.concatenate([candidates[i] for i in known]), ("shape", *CHANNELS[1:]),
        )  # fmt: skip
        mean, rotation = discriminant(("shape", *CHANNELS[1:]), learned)
        for i in np.flatnonzero(half == test):
            own = residues_around(molecules[i], middles[i][None], REACH)
            for j in np.flatnonzero(half == test):
                if i == j or classes[i] != classes[j] or tm[names[i], names[j]] >= OTHER_FOLD:
                    continue
                moved = [
                    (each.reshape(len(each), -1) - mean) @ rotation
                    for each in (candidates[j], sites[i][None])
                ]
                answers = {
                    CHANNELS_LEARNED: np.linalg.norm(moved[0] - moved[1], axis=1).argmin(),
                    COMPOSITION: np.linalg.norm(counts[j] - own, axis=1).argmin(),
                }
                for method, place in answers.items():
                    off = np.linalg.norm(above[j][place] - middles[j])
                    row = {"query": names[i], "target": names[j], "class": classes[i], "half": test}
                    rows.append(row | {"method": method, "off": off, "right": off <= RIGHT})
    return pd.DataFrame(rows)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Return the shares of right answers of both methods and their difference, with 95 % intervals by resampling queries."""
    rows, label = [], "difference"
    for half, part in (("1", table[table["half"] == 1]), ("2", table[table["half"] == 2]), ("both", table)):
        right = part.assign(right=part["right"].astype(float)).pivot_table(
            index="query", columns="method", values="right", aggfunc="mean"
        )
        right[label] = right[CHANNELS_LEARNED] - right[COMPOSITION]
        drawn = np.random.default_rng(SEED).integers(len(right), size=(RESAMPLED, len(right)))
        for method in (CHANNELS_LEARNED, COMPOSITION, label):
            low, high = np.quantile(right[method].to_numpy()[drawn].mean(axis=1), (0.025, 0.975))
            rows.append({
                "half": half, "method": method, "pairs": len(part) // 2, "queries": len(right),
                "right": right[method].mean(), "right_low": low, "right_high": high,
            })  # fmt: skip
    return pd.DataFrame(rows)
