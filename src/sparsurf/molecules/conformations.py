"""Which frames of a trajectory stand for it: superposition, principal components, k-means, silhouette.

The paper's way (Methods, clustering): PCA of the C-alpha coordinates, k-means on the first two components, K
by the mean silhouette, the frame nearest to each centroid.
"""

import logging
from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.molecules.selection import atoms_of_expression

log = logging.getLogger("sparsurf")

CLUSTERS = range(2, 12)  # K = 2..11, the paper's
RESTARTS = 20  # of k-means; the best by inertia is kept
# Å; projections closer than this are one conformation (coordinates are stored to 0.001 to 0.01 Å)
SAME = 1e-3
FITTED = 3  # atoms that fix a superposition, at least
CHUNK = 1024  # rows of the distance matrix held at once


@dataclass(frozen=True)
class Choice:
    """The conformations chosen, and what they were chosen from.

    Attributes
    ----------
    table : DataFrame, one row per conformation, the columns of frames.csv: conformation (c1, c2, ... by
        population; f0012 where frames were named), frame (number in the file), time_ps, pc1, pc2 (Å), cluster,
        population (frames), silhouette; nan where a value has no meaning
    index : (n,) int, positions of the conformations among the molecule's frames
    projection : (F, 2) float, Å, all frames on the first two components
    label : (F,) int, cluster of every frame, 1 the most populated; 0 where there was no clustering
    silhouettes : DataFrame with columns K, silhouette (mean), inertia (Å^2); empty without clustering
    explained : (k,) float, share of the variance of each component, descending
    """

    table: pd.DataFrame
    index: np.ndarray
    projection: np.ndarray
    label: np.ndarray
    silhouettes: pd.DataFrame
    explained: np.ndarray


def superpose(xyz, atoms, reference=None):
    """Frames rotated and translated onto a reference with least squares on `atoms` (Kabsch 1976).

    Parameters
    ----------
    xyz : (F, A, 3) float, Å
    atoms : (n,) indices or mask of the atoms to fit, at least 3
    reference : (n, 3) float, Å, their places; default those of the first frame

    Returns
    -------
    (F, A, 3) float64, Å
    """
    mobile = xyz[:, atoms]
    fixed = mobile[0] if reference is None else reference
    centre, target = mobile.mean(axis=1, keepdims=True), fixed.mean(axis=0)
    u, _, vt = np.linalg.svd((mobile - centre).swapaxes(1, 2) @ (fixed - target))
    u[:, :, 2] *= np.sign(np.linalg.det(u) * np.linalg.det(vt))[:, None]  # a rotation, not a reflection
    return (xyz - centre) @ (u @ vt) + target


def principal_components(xyz):
    """PCA of Cartesian coordinates.

    Parameters
    ----------
    xyz : (F, n, 3) float, Å, superposed

    Returns
    -------
    projection : (F, k) float, Å, on unit vectors; k = min(F, 3n); of each vector the largest loading is
        positive, so that the signs are reproducible
    explained : (k,) float, share of the variance, descending; 0 where the frames do not differ
    """
    deviation = (xyz - xyz.mean(axis=0)).reshape(len(xyz), -1)
    u, s, vt = np.linalg.svd(deviation, full_matrices=False)
    largest = np.abs(vt).argmax(axis=1)
    sign = np.where(vt[np.arange(len(vt)), largest] < 0, -1.0, 1.0)
    variance = s**2
    return u * s * sign, variance / max(variance.sum(), np.finfo(float).tiny)


def kmeans(points, n_clusters, rng, restarts=RESTARTS):
    """k-means (Lloyd) from k-means++ starts, the best of several by inertia.

    Parameters
    ----------
    points : (F, d) float
    n_clusters : int, not more than the distinct points
    rng : numpy.random.Generator

    Returns
    -------
    label : (F,) int ; centroid : (n_clusters, d) float ; inertia : float, sum of squared distances
    """
    # Here and below: who only superposes need not wait.
    from scipy.cluster.vq import ClusterError, kmeans2, vq

    best = None
    for _ in range(restarts):
        try:
            centroid, _ = kmeans2(points, n_clusters, iter=100, minit="++", missing="raise", rng=rng)
        except ClusterError:  # a cluster ran empty: this start is lost
            continue
        label, distance = vq(points, centroid)
        inertia = float((distance**2).sum())
        if best is None or inertia < best[2]:
            best = label, centroid, inertia
    if best is None:
        raise InputError(f"k-means finds no {n_clusters} clusters in these frames: ask for fewer.")
    return best


def silhouettes(points, labels):
    """Silhouette of every point (Rousseeuw 1987) for several clusterings, with the distances computed once.

    Parameters
    ----------
    points : (F, d) float
    labels : list of (F,) int, each 0 .. K-1 with K > 1 and no cluster empty

    Returns
    -------
    (len(labels), F) float, -1 .. 1; 0 for a point alone in its cluster
    """
    from scipy.spatial.distance import cdist

    members = [np.equal.outer(label, np.arange(label.max() + 1)).astype(float) for label in labels]
    result = np.zeros((len(labels), len(points)))
    for start in range(0, len(points), CHUNK):
        rows = slice(start, start + CHUNK)
        distance = cdist(points[rows], points)
        for out, label, member in zip(result, labels, members, strict=True):
            out[rows] = _silhouette(distance @ member, member.sum(axis=0), label[rows])
    return result


def _silhouette(total, size, label):
    """Silhouettes of the points whose summed distances to each cluster are `total` (rows, K)."""
    own = np.arange(len(label)), label
    inside = total[own] / np.maximum(size[label] - 1, 1)
    others = total / size
    others[own] = np.inf
    outside = others.min(axis=1)
    with np.errstate(invalid="ignore"):
        value = (outside - inside) / np.maximum(inside, outside)
    return np.where(size[label] > 1, np.nan_to_num(value), 0.0)


def choose_clusters(points, candidates, rng):
    """k-means for every candidate K, and the mean silhouette of each.

    Parameters
    ----------
    points : (F, d) float
    candidates : list of int, K to try
    rng : numpy.random.Generator; each K has its own stream, so that its result does not depend on the others

    Returns
    -------
    table : DataFrame with columns K, silhouette (nan for K = 1), inertia
    clusterings : dict, K -> (label (F,), centroid (K, d), silhouette (F,))
    """
    streams = rng.spawn(max(candidates) + 1)
    found = {k: kmeans(points, k, streams[k]) for k in candidates}
    several = [k for k in candidates if k > 1]
    values = dict(zip(several, silhouettes(points, [found[k][0] for k in several]), strict=True))
    alone = np.full(len(points), np.nan)
    rows = [(k, values.get(k, alone).mean(), found[k][2]) for k in candidates]
    clusterings = {k: (*found[k][:2], values.get(k, alone)) for k in candidates}
    return pd.DataFrame(rows, columns=["K", "silhouette", "inertia"]), clusterings


def choose_frames(molecule, *, clusters="auto", frames=None, atoms=None, rng):
    """The conformations of a molecule's frames.

    Parameters
    ----------
    molecule : molecule.Molecule
    clusters : 'auto', the K of the best mean silhouette among 2..11, or a K; the frames nearest to the
        centroids are taken. Frames that do not differ are one conformation.
    frames : instead of clusters, 'all', a list of frame numbers, or {'stride': n}
    atoms : str, mdtraj expression of the atoms to superpose and analyse; default C-alpha, or all heavy atoms
        where there are fewer than 3
    rng : numpy.random.Generator

    Returns
    -------
    Choice

    Raises
    ------
    InputError : frames or clusters that the molecule cannot give, or too few atoms to analyse
    """
    projection, explained = _projection(molecule, _analysed_atoms(molecule, atoms))
    if frames is None:
        table, (label, index, silhouette) = _cluster(projection, clusters, rng)
        names = [f"c{rank}" for rank in range(1, len(index) + 1)]
        cluster, population = label[index], np.bincount(label)[1:]
    else:
        index = _named_frames(molecule, frames)
        width = len(str(molecule.frame_number.max()))
        names = [f"f{number:0{width}d}" for number in molecule.frame_number[index]]
        label, silhouette = np.zeros(molecule.n_frames, int), np.full(molecule.n_frames, np.nan)
        cluster, population = 0, 1
        table = pd.DataFrame(columns=["K", "silhouette", "inertia"])
    chosen = pd.DataFrame(
        {
            "conformation": names,
            "frame": molecule.frame_number[index],
            "time_ps": molecule.time_ps[index],
            "pc1": projection[index, 0],
            "pc2": projection[index, 1],
            "cluster": cluster,
            "population": population,
            "silhouette": silhouette[index],
        }
    )
    return Choice(chosen, index, projection, label, table, explained)


def _analysed_atoms(molecule, atoms):
    if atoms is not None:
        mask = atoms_of_expression(molecule, atoms)
        if not mask.any():
            raise InputError(f"frames.pca_atoms: '{atoms}' selects nothing of the molecule: try name CA.")
        if mask.sum() < FITTED and molecule.n_frames > 1:
            raise InputError(
                f"frames.pca_atoms: '{atoms}' selects {mask.sum()} of the {FITTED} atoms that a superposition needs: try name CA."
            )
        return mask
    c_alpha = (molecule.name == "CA") & (molecule.kind == "protein")
    return c_alpha if c_alpha.sum() >= FITTED else ~np.isin(molecule.element, ["H", "D"])


def _projection(molecule, atoms):
    """(F, 2) float, Å, and the shares of the variance; zeros where there is one component or none."""
    if molecule.n_frames == 1:
        return np.zeros((1, 2)), np.zeros(1)
    projection, explained = principal_components(superpose(molecule.xyz[:, atoms], slice(None)))
    plane = np.zeros((molecule.n_frames, 2))
    plane[:, : projection.shape[1]] = projection[:, :2]
    return np.round(plane, 6) + 0.0, explained  # far below any meaning, above the noise of the arithmetic


def _named_frames(molecule, frames):
    """Positions of the frames that the user names."""
    if frames == "all":
        return np.arange(molecule.n_frames)
    if isinstance(frames, dict):
        stride = frames.get("stride")
        if set(frames) != {"stride"} or not isinstance(stride, int) or stride < 1:
            raise InputError(
                f"frames.use: {frames} is not of the form {{stride: n}} with n above 0: repair it."
            )
        return np.arange(0, molecule.n_frames, stride)
    position = {number: index for index, number in enumerate(molecule.frame_number.tolist())}
    absent = [number for number in frames if number not in position]
    if absent or not frames:
        numbers = list(position)
        step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
        steps = f" in steps of {step} (frames.stride)" if step > 1 else ""
        raise InputError(
            f"frames.use: {absent} not among the frames read, {numbers[0]} to {numbers[-1]}{steps}."
        )
    return np.array([position[number] for number in dict.fromkeys(frames)])


def _cluster(points, clusters, rng):
    """Silhouette table, and (label by population from 1, representatives, silhouette of every frame)."""
    from scipy.spatial.distance import cdist

    distinct = len(np.unique(np.round(points / SAME), axis=0))
    most = max(1, min(distinct, len(points) - 1))  # the silhouette wants fewer clusters than frames
    if clusters == "auto":
        candidates = [k for k in CLUSTERS if k <= most] or [1]
    elif isinstance(clusters, int) and 1 <= clusters <= most:
        candidates = [clusters]
    else:
        raise InputError(
            f"frames.clusters: {clusters} is neither auto nor 1 to {most}, which these frames allow."
        )
    if distinct == 1 and len(points) > 1:
        log.info("all %d frames are the same: they are one conformation", len(points))
    table, clusterings = choose_clusters(points, candidates, rng)
    label, centroid, silhouette = clusterings[int(table.K[table.silhouette.fillna(0).argmax()])]
    nearest = cdist(centroid, points).round(6).argmin(axis=1)  # of two as near, the earlier frame
    order = np.lexsort([nearest, -np.bincount(label)])
    rank = np.argsort(order) + 1
    return table, (rank[label], nearest[order], silhouette)
