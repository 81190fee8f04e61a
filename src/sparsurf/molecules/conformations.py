"""Representative frames of a trajectory: superposition, principal components, k-means, silhouette.

As in the paper, the frames are clustered by their principal components. The authors' scripts use k-means on the first two
components, print the mean silhouette of 2 to 11 clusters, and take the frame nearest to each centroid.
"""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError
from sparsurf.molecules.plausibility import FRAMES_AT_ONCE, parts_of
from sparsurf.orientation import EQUAL, MIN_DISTANCE_FROM_LINE, best_rotations, canonical_axes

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule

log = logging.getLogger("sparsurf")

CLUSTERS = range(2, 12)  # numbers of clusters that are tried, as in the paper
RESTARTS = 20  # K-means starts so often, and the best result by inertia is kept.
# Å; projections closer than this are the same conformation (coordinates are stored to 0.001 to 0.01 Å)
MIN_DISTANCE_OF_CONFORMATIONS = 1e-3
MIN_ATOMS_TO_SUPERPOSE = 3
BACKBONE = ("N", "CA", "C", "O")  # These superpose frames and forms whose C-alphas lie on a line.
ROWS_AT_ONCE = 1024  # So many rows of the distance matrix are held at once.


@dataclass(frozen=True)
class FrameChoice:
    """The chosen conformations, and the frames and clusters that they were chosen from.

    `table` has a row for each conformation and the columns of frames.csv: conformation (c1, c2, ... by population; f0012 where
    frames were named), frame (number in the file), time_ps, pc1, pc2 (Å), cluster, population (frames), silhouette; nan where
    a value is undefined. `silhouettes` has K, silhouette (mean) and inertia (Å^2); it is empty without clustering.
    """

    table: pd.DataFrame
    index: np.ndarray  # (n,) int, positions of the conformations among the molecule's frames
    projection: np.ndarray  # (F, 2) float, Å, all frames on the first two components
    # (F,) int, cluster of every frame, 1 the most populated; 0 where there was no clustering
    label: np.ndarray
    silhouettes: pd.DataFrame
    explained: np.ndarray  # (k,) float, share of the variance of each component, descending

    def tables(self, frame_number: np.ndarray) -> dict[str, pd.DataFrame]:
        """Return the tables frames, silhouette, projection and explained; `frame_number` is that of each frame."""
        import pandas as pd  # here: it takes long to load

        projection = pd.DataFrame(self.projection, columns=["pc1", "pc2"])
        projection.insert(0, "frame", frame_number)
        projection["cluster"] = self.label
        explained = pd.DataFrame({"explained": self.explained})
        return dict(
            frames=self.table, silhouette=self.silhouettes, projection=projection, explained=explained
        )


def superpose(
    xyz: np.ndarray,
    atoms: np.ndarray | slice,
    reference: np.ndarray | None = None,
    *,
    any_rotation: bool = False,
) -> np.ndarray:
    """Rotate and translate frames (F, A, 3), Å, onto a reference (n, 3), or the first, by least squares on `atoms` (Kabsch 1976).

    Atoms on a line are refused, but with `any_rotation`: then their deviation is right, but not the position of other atoms.
    """
    centre, rotations, target, distance = _superposition(xyz[:, atoms], reference)
    undetermined = distance < MIN_DISTANCE_FROM_LINE
    if undetermined.any() and not any_rotation:
        raise InputError(
            f"the atoms to superpose lie on a line, or are a mirror image, in frame {undetermined.argmax()}, so that "
            "several rotations fit equally well: take more atoms."
        )
    return (xyz - centre) @ rotations + target


def determines_rotation(
    xyz: np.ndarray, atoms: np.ndarray | slice, reference: np.ndarray | None = None
) -> bool:
    """Return whether some atoms determine the superposition of all frames; parameters as for `superpose`."""
    return bool((_superposition(positions_of(xyz, atoms), reference)[3] >= MIN_DISTANCE_FROM_LINE).all())


def _superposition(mobile: np.ndarray, reference: np.ndarray | None) -> tuple[np.ndarray, ...]:
    """Return centre, rotation and target of each frame, and its distance from an undetermined rotation, see `best_rotations`."""
    fixed = mobile[0] if reference is None else reference
    centre, target = mobile.mean(axis=1, keepdims=True), fixed.mean(axis=0)
    rotations, distance = best_rotations((mobile - centre).swapaxes(1, 2) @ (fixed - target), len(fixed))
    return centre, rotations, target, distance


def positions_of(xyz: np.ndarray, atoms: np.ndarray | slice) -> np.ndarray:
    """Return the positions of some atoms in all frames, (F, n, 3), without loading the others at once."""
    if not isinstance(xyz, np.memmap):
        return xyz[:, atoms]
    return np.concatenate([part[:, atoms] for _, part in parts_of(xyz, FRAMES_AT_ONCE)])


def principal_components(xyz: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the projection (F, k) of superposed frames (F, n, 3), Å, on their components, and each share of the variance (k,).

    The largest loading of each component is positive. Among components of equal variance, see `canonical_axes`.
    """
    deviation = (xyz - xyz.mean(axis=0)).reshape(len(xyz), -1)
    u, s, vt = np.linalg.svd(deviation, full_matrices=False)
    variance = s**2
    settled = canonical_axes(variance, u)
    vt = np.where((settled == u).all(axis=0)[:, None], vt, settled.T @ deviation)
    size = np.abs(vt)
    largest = (size > (1 - EQUAL) * size.max(axis=1, keepdims=True)).argmax(axis=1)
    sign = np.where(vt[np.arange(len(vt)), largest] < 0, -1.0, 1.0)
    return settled * s * sign, variance / max(variance.sum(), np.finfo(float).tiny)


def kmeans(
    points: np.ndarray, n_clusters: int, rng: np.random.Generator, restarts: int = RESTARTS
) -> tuple[np.ndarray, np.ndarray, float]:
    """Cluster points (F, d) by k-means (Lloyd) from k-means++ starts: labels (F,), centroids (K, d), inertia.

    Raise InputError if a cluster is empty in every run.
    """
    # scipy.cluster and scipy.spatial are imported where needed: superposition alone does not need them.
    from scipy.cluster.vq import ClusterError, kmeans2, vq

    best = None
    for _ in range(restarts):
        try:
            centroid, _ = kmeans2(points, n_clusters, iter=100, minit="++", missing="raise", rng=rng)
        except ClusterError:  # a cluster is empty: this run is lost
            continue
        label, distance = vq(points, centroid)
        inertia = float((distance**2).sum())
        if best is None or inertia < best[2]:
            best = label, centroid, inertia
    if best is None:
        raise InputError(
            f"k-means cannot form {n_clusters} clusters from these {len(points)} frames: set `frames.clusters` to fewer."
        )
    return best


def silhouettes(points: np.ndarray, labels: Sequence[np.ndarray]) -> np.ndarray:
    """Compute the silhouette (Rousseeuw 1987) of points (F, d) for each clustering, 0 .. K-1 for each point."""
    from scipy.spatial.distance import cdist

    members = [np.equal.outer(label, np.arange(label.max() + 1)).astype(float) for label in labels]
    result = np.zeros((len(labels), len(points)))
    for start in range(0, len(points), ROWS_AT_ONCE):
        rows = slice(start, start + ROWS_AT_ONCE)
        distance = cdist(points[rows], points)
        for out, label, member in zip(result, labels, members, strict=True):
            out[rows] = _silhouette(distance @ member, member.sum(axis=0), label[rows])
    return result


def _silhouette(total: np.ndarray, size: np.ndarray, label: np.ndarray) -> np.ndarray:
    """Compute silhouettes of points whose summed distances to each cluster are `total` (rows, K)."""
    same_cluster = np.arange(len(label)), label
    within = total[same_cluster] / np.maximum(size[label] - 1, 1)
    mean_distance = total / size
    mean_distance[same_cluster] = np.inf
    nearest = mean_distance.min(axis=1)
    with np.errstate(invalid="ignore"):
        value = (nearest - within) / np.maximum(within, nearest)
    return np.where(size[label] > 1, np.nan_to_num(value), 0.0)


def choose_clusters(
    points: np.ndarray, candidates: Sequence[int], rng: np.random.Generator
) -> tuple[pd.DataFrame, dict[int, tuple[np.ndarray, np.ndarray, np.ndarray]]]:
    """Run k-means for each candidate K, with its own stream of numbers.

    Return the table of K, mean silhouette (nan for K = 1) and inertia, and by K labels, centroids and silhouettes.
    """
    import pandas as pd

    streams = rng.spawn(max(candidates) + 1)
    runs = {k: kmeans(points, k, streams[k]) for k in candidates}
    several = [k for k in candidates if k > 1]
    values = dict(zip(several, silhouettes(points, [runs[k][0] for k in several]), strict=True))
    undefined = np.full(len(points), np.nan)
    rows = [(k, values.get(k, undefined).mean(), runs[k][2]) for k in candidates]
    clusterings = {k: (runs[k][0], runs[k][1], values.get(k, undefined)) for k in candidates}
    return pd.DataFrame(rows, columns=["K", "silhouette", "inertia"]), clusterings


def choose_frames(
    molecule: Molecule,
    *,
    clusters: str | int = "auto",
    frames: str | Sequence[int] | None = None,
    rng: np.random.Generator,
) -> FrameChoice:
    """Choose the frames that represent the conformations of a molecule; raise InputError if it lacks frames, clusters or atoms.

    They are superposed by C-alpha, or by the backbone, or by all heavy atoms, if there are fewer than 3 or they lie on a line.
    `clusters` is a K, or 'auto' for that of the best mean silhouette among 2..11: the frames nearest to the centroids are
    chosen. Frames that do not differ are one conformation. `frames` are instead 'all', or a list of frame numbers.
    """
    import pandas as pd

    projection, explained = _projection(molecule, _atoms_to_analyse(molecule))
    if frames is None:
        table, (label, index, silhouette) = _cluster(projection, clusters, rng)
        names = [f"c{rank}" for rank in range(1, len(index) + 1)]
        cluster, population = label[index], np.bincount(label)[1:]
    else:
        index = _selected_frames(molecule, frames)
        width = len(str(molecule.frame_number.max()))
        names = [f"f{number:0{width}d}" for number in molecule.frame_number[index]]
        label, silhouette = np.zeros(molecule.n_frames, int), np.full(molecule.n_frames, np.nan)
        cluster, population = np.zeros(len(index), int), np.ones(len(index), int)
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
    return FrameChoice(chosen, index, projection, label, table, explained)


def _atoms_to_analyse(molecule: Molecule) -> np.ndarray:
    """Return the mask (A,) of the atoms to superpose and analyse."""
    protein, heavy = molecule.kind == "protein", molecule.heavy
    c_alpha, backbone = protein & (molecule.name == "CA"), protein & np.isin(molecule.name, BACKBONE)
    choices = [c_alpha, backbone, heavy] if c_alpha.sum() >= MIN_ATOMS_TO_SUPERPOSE else [heavy]
    if molecule.n_frames == 1 or choices[0].sum() < MIN_ATOMS_TO_SUPERPOSE:
        return choices[0]
    for choice in choices:
        if determines_rotation(molecule.xyz, choice):
            return choice
    raise InputError(
        "frames: the atoms of the molecule lie on a line, so that several superpositions of the frames fit equally "
        "well: leave out `frames`, or give a molecule of more atoms."
    )


def _projection(molecule: Molecule, atoms: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Project the frames on two components, (F, 2), Å; also return the shares of the variance. Missing components are 0."""
    if molecule.n_frames == 1:
        return np.zeros((1, 2)), np.zeros(1)
    # The rotation of one or two atoms is not determined, but it does not move them.
    fitted = superpose(
        positions_of(molecule.xyz, atoms), slice(None), any_rotation=int(atoms.sum()) < MIN_ATOMS_TO_SUPERPOSE
    )
    projection, explained = principal_components(fitted)
    plane = np.zeros((molecule.n_frames, 2))
    plane[:, : projection.shape[1]] = projection[:, :2]
    return np.round(plane, 6) + 0.0, explained  # removes rounding errors, which depend on the machine


def _selected_frames(molecule: Molecule, frames: str | Sequence[int]) -> np.ndarray:
    """Return positions of the frames that the user selects."""
    if frames == "all":
        return np.arange(molecule.n_frames)
    position = {number: index for index, number in enumerate(molecule.frame_number.tolist())}
    selected = list(frames)
    absent = [number for number in selected if number not in position]
    if absent or not selected:
        numbers = list(position)
        step = numbers[1] - numbers[0] if len(numbers) > 1 else 1
        steps = f" in steps of {step} (frames.stride)" if step > 1 else ""
        raise InputError(
            f"frames.selection: {absent} are not among the frames read, {numbers[0]} to {numbers[-1]}{steps}."
        )
    return np.array([position[number] for number in dict.fromkeys(selected)])


def _cluster(
    points: np.ndarray, clusters: str | int, rng: np.random.Generator
) -> tuple[pd.DataFrame, tuple[np.ndarray, np.ndarray, np.ndarray]]:
    """Return the silhouette table, and labels (1 the most populated), representatives and silhouettes of the frames."""
    from scipy.spatial.distance import cdist

    distinct = len(np.unique(np.round(points / MIN_DISTANCE_OF_CONFORMATIONS), axis=0))
    max_clusters = max(1, min(distinct, len(points) - 1))  # the silhouette needs fewer clusters than frames
    if clusters == "auto":
        candidates = [k for k in CLUSTERS if k <= max_clusters] or [1]
    elif isinstance(clusters, int) and 1 <= clusters <= max_clusters:
        candidates = [clusters]
    else:
        raise InputError(
            f"frames.clusters: {clusters} is neither auto nor 1 to {max_clusters}, which these frames allow."
        )
    if distinct == 1 and len(points) > 1:
        log.info("all %d frames are the same: they are one conformation", len(points))
    table, clusterings = choose_clusters(points, candidates, rng)
    label, centroid, silhouette = clusterings[int(table.K[table.silhouette.fillna(0).argmax()])]
    nearest = cdist(centroid, points).round(6).argmin(axis=1)  # the earlier of two equally near frames
    order = np.lexsort([nearest, -np.bincount(label)])
    rank = np.argsort(order) + 1
    return table, (rank[label], nearest[order], silhouette)
