"""Sites of bound cofactors sought on proteins that bind one, of another fold as well: is the cofactor placed where it lies?

Every method says where the middle of the target's cofactor is. It is right within `RIGHT` of the true one.
"""

from collections.abc import Iterable, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

import sparsurf
from measures.alignments import tm_align
from measures.sites import COMPOSITION, residues_around
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sites.describing import Sites
from sparsurf.sites.finding import find_site
from sparsurf.surfaces.surface import Surface

RIGHT = 6.0  # Å between the middle of a placed cofactor and that of the target's
OTHER_FOLD = 0.5  # TM-score below which two proteins do not share a fold
REACH = 10.0  # Å, of the atoms that count for composition and for the depth of a pocket
ABOVE = 3.0  # Å above a dot, where the middle of something bound could be
RESAMPLED, SEED = 4000, 0  # draws of queries for an interval: shares near 0 have none by Student's t
FIND, TM, POCKET, CHANCE = "find", "TM-align", "deepest pocket", "any place of the surface"
METHODS = (FIND, COMPOSITION, POCKET, TM, CHANCE)


def measure(
    names: list[str],
    classes: list[str],
    residues: list[list[str]],
    molecules: list[Molecule],
    ligands: list[np.ndarray],
) -> pd.DataFrame:
    """Seek each site on each other protein.

    Parameters
    ----------
    names, classes : of the sites and of their cofactors
    residues : of each site, such as A:10
    molecules : proteins without their cofactors
    ligands : (L, 3), Å, atoms of each cofactor

    Returns
    -------
    DataFrame: query, target, class, same_class, tm (score), method, off (Å), right (for CHANCE a share)
    """
    sites = [
        sparsurf.describe_sites(molecule, name=name) for name, molecule in zip(names, molecules, strict=True)
    ]
    middles = [ligand.mean(axis=0) for ligand in ligands]
    above = [_above(site, molecule) for site, molecule in zip(sites, molecules, strict=True)]
    around = [residues_around(molecule, at, REACH) for molecule, at in zip(molecules, above, strict=True)]
    pockets = [_deepest(molecule, at) for molecule, at in zip(molecules, above, strict=True)]
    rows = []
    for i, query in enumerate(names):
        others = [k for k in range(len(names)) if k != i]
        placed = _placed_by_find(sites[i], residues[i], [sites[k] for k in others], middles[i])
        own = residues_around(molecules[i], middles[i][None], REACH)
        for k in others:
            rotation, shift, tm = tm_align(molecules[i], molecules[k])
            alike = np.linalg.norm(around[k] - own, axis=1).argmin()
            answers = {FIND: placed[names[k]], COMPOSITION: above[k][alike], POCKET: pockets[k]}
            answers[TM] = middles[i] @ rotation + shift
            row = {
                "query": query,
                "target": names[k],
                "class": classes[i],
                "same_class": classes[i] == classes[k],
            }
            off = {name: np.linalg.norm(at - middles[k]) for name, at in answers.items()}
            rows += [
                row | {"tm": tm, "method": name, "off": far, "right": far <= RIGHT}
                for name, far in off.items()
            ]
            near = np.linalg.norm(above[k] - middles[k], axis=1) <= RIGHT
            rows.append(row | {"tm": tm, "method": CHANCE, "off": np.nan, "right": near.mean()})
    return pd.DataFrame(rows)


def read_sites(path: str) -> tuple[pd.DataFrame, list[Molecule], list[np.ndarray]]:
    """Read the table of sites of cofactors, their molecules, and the atoms (L, 3) in Å of their ligands, from its folder."""
    entries, folder = pd.read_csv(path), Path(path).parent
    molecules = [read_molecule(folder / f"{name}.pdb.gz") for name in entries["name"]]
    return entries, molecules, [np.loadtxt(folder / f"{name}.lig.gz", ndmin=2) for name in entries["name"]]


def _placed_by_find(
    site: Sites, residues: Sequence[str], targets: list[Sites], middle: np.ndarray
) -> dict[str, np.ndarray]:
    """Return where `find` places the middle of the query's cofactor on each target."""
    own = (site.labels["chain"] + ":" + site.labels["residue"]).isin(residues).to_numpy()
    hits = find_site(site.take(own), targets, len(targets))
    return {
        name: middle @ pose.rotation + pose.shift
        for name, pose in zip(hits.table["target"], hits.poses, strict=True)
    }


def points_above(molecule: Molecule) -> np.ndarray:
    """Return points above a tenth of the dots of a protein, as `_above` of its places: (P, 3)."""
    dots = sparsurf.surface(molecule)
    kept = dots.take(sparsurf.sample(dots, percent=10))
    return _above(kept, molecule)


def _above(site: Sites | Surface, molecule: Molecule) -> np.ndarray:
    """Return points `ABOVE` the places of a surface where there is room: no atom of the protein is nearer than that."""
    above = site.points + ABOVE * site.normals
    room = cKDTree(molecule.xyz[0]).query(above)[0] >= ABOVE
    return above[room] if room.any() else above


def _deepest(molecule: Molecule, above: np.ndarray) -> np.ndarray:
    """Return the point above the surface with most atoms around it, (3,)."""
    near = cKDTree(molecule.xyz[0]).query_ball_point(above, REACH, return_length=True)
    return above[near.argmax()]


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Return the share of right answers by method on proteins of another fold, with 95 % intervals by resampling queries.

    Returns
    -------
    DataFrame: cofactor ('the same', 'another', or of the same class only one class, and all without heme), method, pairs,
    queries, right with _low and _high
    """
    rows = []
    for label, part in _groups(table[table["tm"] < OTHER_FOLD]):
        for method in METHODS:
            chosen = part[part["method"] == method]
            by_query = chosen.groupby("query")["right"].apply(lambda right: right.astype(float).mean())
            row = {"cofactor": label, "method": method, "pairs": len(chosen), "queries": len(by_query)}
            drawn = np.random.default_rng(SEED).choice(by_query, (RESAMPLED, len(by_query))).mean(axis=1)
            low, high = np.quantile(drawn, (0.025, 0.975))
            rows.append(row | {"right": by_query.mean(), "right_low": low, "right_high": high})
    return pd.DataFrame(rows)


def _groups(table: pd.DataFrame) -> Iterable[tuple[str, pd.DataFrame]]:
    """Return the same class of cofactor, another one, heme alone and all but heme."""
    same = table[table["same_class"]]
    yield "the same", same
    yield "the same, heme", same[same["class"] == "HEM"]
    yield "the same, not heme", same[same["class"] != "HEM"]
    yield "another", table[~table["same_class"]]
