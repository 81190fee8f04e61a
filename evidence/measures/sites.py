"""Places of a protein's bound form searched on its unbound form: their description, and how often they are found."""

import logging
import tempfile
import time
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree
from scipy.spatial.transform import Rotation

import sparsurf
from measures.alignments import ALIGNMENTS, aligned_residues, alignments, alpha
from measures.fpfh import fpfh
from sparsurf.dot_fields.registry import HYDROPATHY
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.residues import standard_name
from sparsurf.pairs.complexes import superpose_onto
from sparsurf.sites.describing import FIELDS, RADIUS, SHAPE, Sites, load_sites
from sparsurf.sites.finding import find_site
from sparsurf.sites.metric import learn_weights, to_metric_space
from sparsurf.sites.pose_search import Pose, rigid_fit
from sparsurf.surfaces.surface import Surface

log = logging.getLogger("sparsurf")

CHANNELS = {
    "shape": (),
    "shape, hydropathy, potential": ("hydropathy", "potential"),
    "shape, all fields": FIELDS,
}
COMPOSITION, PUBLISHED, FPFH = "residue composition", "published descriptor", "FPFH"
MAIN = 10  # % of the dots: at which weights are chosen; candidates where patches are cut from all dots
MOST = 20  # maximal share of the dots that are candidates, %
AROUND = 6.0  # Å; the atoms within this distance define how a place moved
SAME = 3.0  # Å; a hit within this distance of the true place is right
MOVED = (0.0, 0.5, 1.0, 2.0, np.inf)  # Å, ranges of how far the atoms around a place moved
THERE = 1.0  # Å; a place exists on the other form if a dot lies within this distance
ALIGNED, FITS = 4.0, 10  # Å between C-alpha atoms of aligned residues; fits to those that lie so near
FEW = 50  # places for weights; not used for relatives, which take the weights of the library
RESIDUES = sorted(HYDROPATHY.keys() - {"MSE"})


def forms(
    bound: Molecule,
    dots: Surface,
    interface: np.ndarray,
    unbound: Molecule,
    percents: Sequence[float],
    n: int,
    n_learned: int,
    rng: np.random.Generator,
    everywhere: bool = False,
) -> tuple[dict[str, np.ndarray], list[tuple], Sites, Sites | None]:
    """Describe places on both forms of one protein; the unbound one is rotated at random.

    Parameters
    ----------
    bound, unbound : Molecule
    dots : Surface of the bound form
    interface : (N,) bool, of its dots
    percents : sequence of float, MAIN among them: share of the dots that are kept on both forms
    n, n_learned : int, places of the interface, as of the rest, that are sought; those from which weights are learned
    rng : numpy Generator, of the rotation and the places
    everywhere : bool
        Seek all places, also those that the other form lacks, and add the alignments of `alignments` to the opponents.

    Returns
    -------
    arrays : dict. Of the sought places `interface` (Q,) bool, `moved` (Q,) Å, and `true` (Q, 3), where they are on the other
        form; for each percent the numbers `query` and `target` and the targets' `place` (P, 3); the same of the opponents
    costs : list of (percent, dots, places, bytes, CPU seconds) of describing the places of the unbound form
    target, site : Sites at MAIN, of the unbound form and of the bound interface; None for an interface of a few dots
    """
    turn = Rotation.random(random_state=rng).as_matrix()
    superposed = superpose_onto(unbound, bound)
    turned = replace(superposed, xyz=superposed.xyz @ turn)
    other = sparsurf.surface(turned)
    shift, moved = displacements(dots.points, bound, superposed)
    true = (dots.points + shift) @ turn
    there = cKDTree(other.points).query(np.nan_to_num(true, nan=1e6))[0] < THERE
    may = there | everywhere
    sought = [rng.permutation(np.flatnonzero(may & own))[:n] for own in (interface, ~interface)]
    sought = np.concatenate(sought)
    out = {"interface": interface[sought], "moved": moved[sought], "true": true[sought]}
    out["share_there"] = np.array(
        [there[own].mean() if own.any() else np.nan for own in (interface, ~interface)]
    )
    learned = rng.permutation(np.flatnonzero(there))[:n_learned]
    both = [
        replace(each, fields=sparsurf.fields(molecule, each, FIELDS))
        for molecule, each in ((bound, dots), (turned, other))
    ]
    kept = [sparsurf.sample(each, percent=MOST) for each in both]
    n_kept = {p: [round(p / 100 * len(each)) for each in both] for p in percents}
    costs, target, site = [], None, None
    for percent in percents:
        few = both
        if percent < 100:
            few = [one.take(order[:k]) for one, order, k in zip(both, kept, n_kept[percent], strict=True)]
        out[f"query {percent:g}"] = numbers_at(few[0], dots.points[sought])
        at = other.points[kept[1][: n_kept[MAIN][1]]] if percent == 100 else None
        begin = time.process_time()
        sites = sparsurf.describe_sites(few[1], percent=100, fields=FIELDS, at=at)
        seconds = time.process_time() - begin
        out[f"target {percent:g}"], out[f"place {percent:g}"] = sites.numbers, sites.points
        costs.append((percent, len(few[1]), len(sites), saved_bytes(sites), seconds))
        if percent == MAIN:
            pairs = numbers_at(few[0], dots.points[learned]), numbers_at(few[1], true[learned])
            out["learned"], target = np.stack(pairs), sites
            own = kept[0][: n_kept[MAIN][0]]
            own = own[interface[own] & may[own]]
            if len(own) >= 3:
                site = sparsurf.describe_sites(few[0], percent=100, fields=FIELDS, at=dots.points[own])
                out["true_site"] = true[own]
    for name, describe in OPPONENTS.items():
        out[f"query {name}"] = describe(bound, dots, dots.points[sought])
        out[f"target {name}"] = describe(turned, other, other.points[kept[1]])
    out["place of all"] = other.points[kept[1]]
    for name, move in alignments().items() if everywhere else ():
        out[f"query {name}"], out[f"target {name}"] = (
            move(bound, turned, dots.points[sought]),
            out["place of all"],
        )
    return out, costs, target, site


def numbered_as(molecule: Molecule, reference: Molecule) -> tuple[Molecule, float]:
    """Renumber the residues of a relative as in the reference, by an alignment where the superposed backbones agree.

    Returns
    -------
    Molecule; residues without a counterpart take numbers of their own; and the share of the others that are of one type
    """
    both, rows = (molecule, reference), aligned_residues(molecule, reference)
    names = [[standard_name(str(name)) for name in each.residues["residue_name"]] for each in both]
    at = [each.xyz[0][alpha(each)][own] for each, own in zip(both, rows, strict=True)]
    near = np.ones(len(at[0]), bool)
    for _ in range(FITS):
        rotation, shift = rigid_fit(*(each[near] for each in at), np.ones(near.sum()))
        gap = np.linalg.norm(at[0] @ rotation + shift - at[1], axis=1)
        near = gap < max(ALIGNED, np.median(gap))
    rows = [own[gap < ALIGNED] for own in rows]
    number = np.array([f"own {k}" for k in range(len(names[0]))], object)
    number[rows[0]] = reference.residues["residue"].to_numpy()[rows[1]]
    chain = np.full(molecule.n_atoms, reference.chain[0])
    alike = np.mean([names[0][i] == names[1][j] for i, j in zip(*rows, strict=True)])
    return replace(molecule, residue=number[molecule.residue_index], chain=chain), alike


def displacements(places: np.ndarray, bound: Molecule, superposed: Molecule) -> tuple[np.ndarray, np.ndarray]:
    """Compute how atoms within AROUND of places (P, 3) move from one form to the other: mean (P, 3) and rms (P,), Å.

    NaN where no atom that both forms have lies near.
    """
    numbers = [
        {key: i for i, key in enumerate(zip(m.chain, m.residue, m.name, strict=True))}
        for m in (bound, superposed)
    ]
    common = [key for key in numbers[0] if key in numbers[1]]
    atoms_bound, atoms_superposed = ([each[key] for key in common] for each in numbers)
    move = superposed.xyz[0][atoms_superposed] - bound.xyz[0][atoms_bound]
    near = cKDTree(bound.xyz[0][atoms_bound]).query_ball_point(places, AROUND)
    count = np.array([len(each) for each in near])
    owner, atom = np.repeat(np.arange(len(near)), count), np.concatenate([*near, []]).astype(int)
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = (
            np.stack([np.bincount(owner, move[atom, k], len(near)) for k in range(3)], axis=1)
            / count[:, None]
        )
        rms = np.sqrt(np.bincount(owner, (move[atom] ** 2).sum(axis=1), len(near)) / count)
    return mean, rms


def numbers_at(dots: Surface, places: np.ndarray) -> np.ndarray:
    """Return numbers (P, C, K) at places; zeros where a patch has too few dots."""
    sites = sparsurf.describe_sites(dots, percent=100, fields=FIELDS, at=places)
    out = np.zeros((len(places), *sites.numbers.shape[1:]), np.float16)
    out[cKDTree(places).query(sites.points)[1]] = sites.numbers
    return out


def saved_bytes(sites: Sites) -> int:
    """Return the size of the file that holds them."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "a.sites")
        sites.save(path)
        return path.stat().st_size


def _composition(molecule: Molecule, _dots: Surface, places: np.ndarray) -> np.ndarray:
    return residues_around(molecule, places, AROUND)


def residues_around(molecule: Molecule, places: np.ndarray, radius: float) -> np.ndarray:
    """Compute how many residues of each of the 20 types have an atom within `radius` (Å) of places: (P, 20) float32."""
    residues = molecule.residues
    kind = np.array(
        [RESIDUES.index(n) if n in RESIDUES else -1 for n in map(standard_name, residues["residue_name"])]
    )
    out = np.zeros((len(places), len(RESIDUES)), np.float32)
    for row, near in zip(out, cKDTree(molecule.xyz[0]).query_ball_point(places, radius), strict=True):
        kinds = kind[np.unique(molecule.residue_index[near])]
        row += np.bincount(kinds[kinds >= 0], minlength=len(RESIDUES))
    return out


def _published(_molecule: Molecule, dots: Surface, places: np.ndarray) -> np.ndarray:
    return sparsurf.descriptors(dots, places).astype(np.float32)


def _fpfh(_molecule: Molecule, dots: Surface, places: np.ndarray) -> np.ndarray:
    """Return fast point feature histograms within RADIUS, of MOST of the dots: (P, 33)."""
    at = cKDTree(dots.points).query(places)[1]
    own = np.union1d(at, sparsurf.sample(dots, percent=MOST))
    return fpfh(dots.points[own], dots.normals[own], RADIUS)[np.searchsorted(own, at)].astype(np.float32)


OPPONENTS = {
    COMPOSITION: _composition,
    PUBLISHED: _published,
    FPFH: _fpfh,
}  # (molecule, dots, places) -> (P, M) float32


def described(
    arrays: dict[str, np.ndarray], percent: float, channels: str, learned: dict
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return the numbers of the sought places and of the candidates (Q, M) and (P, M), and where the candidates are."""
    if channels in CHANNELS:
        taken = [0] + [1 + FIELDS.index(name) for name in CHANNELS[channels]]
        both = (
            to_metric_space(arrays[f"{side} {percent:g}"][:, taken], CHANNELS[channels], learned)
            for side in ("query", "target")
        )
        return *both, arrays[f"place {percent:g}"]
    n = len(arrays[f"place {MAIN if percent == 100 else percent:g}"])
    return arrays[f"query {channels}"], arrays[f"target {channels}"][:n], arrays["place of all"][:n]


def apart(query: np.ndarray, target: np.ndarray) -> np.ndarray:
    """Return distances (Q, P) between rows."""
    square = (query**2).sum(axis=1)[:, None] + (target**2).sum(axis=1) - 2 * query @ target.T
    return np.sqrt(np.maximum(square, 0))


def outcomes(distance: np.ndarray, right: np.ndarray) -> dict[str, np.ndarray]:
    """Compute how each place is found, from distances (Q, P) to the candidates and whether these are right.

    Returns
    -------
    dict of (Q,): `first` and `first_percent`, whether the nearest and one of the nearest 1 % is right; `auc`, the chance that a
    right candidate is nearer than another, NaN where all or none are right; `chance` of a right first hit
    """
    order = np.argsort(distance.astype(np.float32), axis=1)
    hits = np.take_along_axis(right, order, axis=1)  # nearest first
    n = right.sum(axis=1)
    wrong = right.shape[1] - n
    rank = (hits * np.arange(1, right.shape[1] + 1)).sum(axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        auc = 1 - (rank - n * (n + 1) / 2) / (n * wrong)
    few = max(1, right.shape[1] // 100)
    return {
        "first": hits[:, 0],
        "first_percent": hits[:, :few].any(axis=1),
        "auc": auc,
        "chance": right.mean(axis=1),
    }


def halves(
    numbers_paths: list[str], target_paths: list[str], site_paths: list[str], forms: list[str]
) -> tuple[list[str], np.ndarray, list[dict], list[Sites], list[Sites], list[dict]]:
    """Read the descriptions of both partners of complexes, and learn weights from each half of the complexes.

    Parameters
    ----------
    numbers_paths, target_paths, site_paths : a path for each partner
    forms : names of the complexes

    Returns
    -------
    names, half (0 or 1; both partners of a complex are in one), numbers, targets, sites : one of each partner
    learned : weights of the first and of the second half, see `metric.weights`
    """
    names = [f"{form}_{side}" for form in forms for side in "rl"]
    half = np.repeat(np.arange(len(forms)) % 2, 2)
    numbers = [dict(np.load(path)) for path in numbers_paths]
    targets, queries = ([load_sites(path) for path in paths] for paths in (target_paths, site_paths))
    learned = [_learned([arrays for arrays, h in zip(numbers, half, strict=True) if h == k]) for k in (0, 1)]
    return names, half, numbers, targets, queries, learned


def _learned(numbers: list[dict]) -> dict:
    """Return the weights from the places of some proteins on both forms."""
    pairs = np.concatenate([arrays["learned"] for arrays in numbers], axis=1)
    return learn_weights(
        pairs, np.concatenate([arrays[f"target {MAIN}"] for arrays in numbers]), (SHAPE, *FIELDS)
    )


def scores(arrays: dict[str, np.ndarray], weights: dict) -> Iterator[dict]:
    """Yield how often the places of one protein are found, by percent, channels and kind of place."""
    percents = [float(key.split()[1]) for key in arrays if key.startswith("place ") and key != "place of all"]
    for percent in percents:
        for channels in (
            *CHANNELS,
            *(name for name in (*OPPONENTS, *ALIGNMENTS) if f"query {name}" in arrays),
        ):
            query, target, at = described(arrays, percent, channels, weights)
            right = apart(arrays["true"], at) < SAME
            results = outcomes(apart(query, target), right)
            for kind, chosen in (("interface", arrays["interface"]), ("elsewhere", ~arrays["interface"])):
                if chosen.any():
                    row = {
                        "percent": percent,
                        "channels": channels,
                        "places": kind,
                        "n": int(chosen.sum()),
                        "candidates": len(at),
                    }
                    with np.errstate(invalid="ignore"):
                        row |= {key: np.nanmean(values[chosen]) for key, values in results.items()}
                        row["first_moved"] = _mean(results["first"][chosen & (arrays["moved"] >= MOVED[-2])])
                    yield row


def _mean(values: np.ndarray) -> float:
    """Return the mean of values; NaN if there are none."""
    return float(values.mean()) if len(values) else np.nan


def by_place(arrays: dict[str, np.ndarray], weights: dict, every: list[dict]) -> pd.DataFrame:
    """Compute how each place of one protein is found at MAIN by all fields, also among the candidates of `every` protein.

    Returns
    -------
    DataFrame: interface, moved (Å), first, first_percent, first_of_all (right protein and place)
    """
    channels = list(CHANNELS)[-1]
    query, target, at = described(arrays, MAIN, channels, weights)
    distance, right = apart(query, target), apart(arrays["true"], at) < SAME
    results = outcomes(distance, right)
    nearest = distance.min(axis=1)
    for other in every:
        if other is not arrays:
            nearest = np.minimum(
                nearest, apart(query, described(other, MAIN, channels, weights)[1]).min(axis=1)
            )
    table = pd.DataFrame(
        {key: arrays[key] for key in ("interface", "moved")}
        | {key: results[key] for key in ("first", "first_percent")}
    )
    return table.assign(first_of_all=table["first"] & (distance.min(axis=1) <= nearest))


def whole(
    names: list[str],
    half: np.ndarray,
    queries: list[Sites],
    targets: list[Sites],
    true: list[np.ndarray | None],
    weights: list[dict],
) -> pd.DataFrame:
    """Search each interface as a whole on the unbound forms of its half: is the right one first, and in the right pose?

    Returns
    -------
    DataFrame: protein, places, targets, score on the right protein, best_other (on another), right_protein (is first), off (Å,
    median distance of the places from their true positions after superposition onto the right protein) and right (it is
    first, off below SAME)
    """
    rows = []
    for k, name in enumerate(names):
        if true[k] is None or len(true[k]) != len(queries[k]):
            continue
        others = [replace(targets[i], name=names[i]) for i in np.flatnonzero(half == half[k])]
        hits = find_site(queries[k], others, len(others), weights[1 - half[k]])
        rank = hits.table["target"].to_list().index(name)
        off = off_place(queries[k], hits.poses[rank], true[k])
        score = hits.table["score"].to_numpy()
        rows.append({
            "protein": name, "places": len(queries[k]), "targets": len(others), "score": score[rank],
            "best_other": np.delete(score, rank).max(initial=0.0), "right_protein": rank == 0, "off": off,
            "right": rank == 0 and off < SAME,
        })  # fmt: skip
    return pd.DataFrame(rows)


def off_place(site: Sites, pose: Pose, true: np.ndarray) -> float:
    """Return the median distance, Å, of the places of a site, superposed onto a target, from their true positions (Q, 3).

    Places whose true position is unknown (NaN) are left out.
    """
    return np.nanmedian(np.linalg.norm(site.points @ pose.rotation + pose.shift - true, axis=1))
