"""Which residues lie in an interface, told from points on the surface of a single partner; by the density of the points.

A residue gets the mean of local descriptors at its points: heights and normals of the points around, and the residues that
they belong to. A fixed classifier learns from some complexes and scores the residues of the others.
"""

from collections.abc import Sequence
from importlib.util import find_spec

import numpy as np
import pandas as pd
from scipy.sparse import csr_array
from scipy.spatial import cKDTree
from threadpoolctl import threadpool_limits

import sparsurf
from sparsurf_study.workflow.jobs import Job
from sparsurf.dot_fields.named_fields import HYDROPATHY
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.radii import radii
from sparsurf_study.analysis.relation import with_interval
from sparsurf_study.pairs.ranking import auc

CONTACT = 5.0  # Å between heavy atoms of an interface
AROUND = (6.0, 10.0)  # Å, of the points that a descriptor sees
NEAREST_ATOMS = 8  # among which is the one that a point belongs to
POINTS_OF_RESIDUE = 4  # at most, whose descriptors are averaged
MIN_AREA = 5.0  # Å^2 of a residue that can be seen
FOLDS = 5
MEASURES = ["auc", "auc_low", "auc_high", "change", "change_low", "change_high"]
MEASURES += ["points", "residues", "complexes"]
AMINO_ACIDS = list(HYDROPATHY)


def residues_of(molecule: Molecule, partner: Molecule, densities: Sequence[float], seed: int) -> pd.DataFrame:
    """Return a row for each exposed residue and density: density, points, interface, and descriptors.

    Points of a lower density are the first ones of the highest: they were chosen farthest from one another.
    """
    xyz, sizes = molecule.xyz[0], radii(molecule, "dms")
    points, normals = (
        part.astype(float) for part in sparsurf.points((xyz, sizes), density=max(densities), seed=seed)
    )
    gap, atoms = cKDTree(xyz).query(points, min(NEAREST_ATOMS, len(xyz)))
    atom = np.take_along_axis(atoms, np.argmin(gap - sizes[atoms], axis=1)[:, None], axis=1)[:, 0]
    residue = molecule.residue_index[atom]
    kinds = (molecule.residue_name[atom][:, None] == np.array(AMINO_ACIDS)).astype(float)
    touching = cKDTree(partner.xyz[0][partner.heavy]).query(xyz)[0] < CONTACT
    interface = np.unique(molecule.residue_index[touching & molecule.heavy])
    exposed = np.flatnonzero(np.bincount(residue) >= MIN_AREA * max(densities))
    centre = np.array([xyz[molecule.residue_index == r].mean(axis=0) for r in exposed])
    tables = []
    for density in densities:
        n = round(len(points) * density / max(densities))
        at = [np.flatnonzero(residue[:n] == r)[:POINTS_OF_RESIDUE] for r in exposed]
        nearest = cKDTree(points[:n]).query(centre)[1]
        at = [own if len(own) else nearest[[k]] for k, own in enumerate(at)]
        row = np.repeat(np.arange(len(at)), [len(own) for own in at])
        values = describe(points[:n], normals[:n], kinds[:n], np.concatenate(at), density)
        rows = pd.DataFrame(values).groupby(row).mean().round(6)  # so that no split rests on rounding
        tables.append(rows.assign(density=density, points=n, interface=np.isin(exposed, interface)))
    return pd.concat(tables, ignore_index=True)


def describe(
    points: np.ndarray, normals: np.ndarray, kinds: np.ndarray, centres: np.ndarray, density: float
) -> np.ndarray:
    """Return descriptors of the points `centres`, (C, D), from the points around: positions, normals, and kinds (N, K)."""
    n, parts, points = len(points), [], points - points.mean(axis=0)
    x, own = points[centres], normals[centres]
    outer = [(part[:, :, None] * part[:, None]).reshape(n, 9) for part in (points, normals)]
    along = (points * normals).sum(axis=1, keepdims=True)
    values = np.hstack([np.ones((n, 1)), points, normals, along, *outer, kinds])
    at = (x * own).sum(axis=1)
    for radius in AROUND:
        pairs = cKDTree(x).sparse_distance_matrix(cKDTree(points), radius, output_type="ndarray")
        sums = csr_array((np.ones(len(pairs)), (pairs["i"], pairs["j"])), (len(x), n)) @ values
        point, normal, dot, pp, nn, share = np.split(sums[:, 1:] / sums[:, :1], [3, 6, 7, 16, 25], axis=1)
        height = (own * point).sum(axis=1) - at
        squared = [np.einsum("ca,cab,cb->c", own, part.reshape(-1, 3, 3), own) for part in (pp, nn)]
        shape = [
            height,
            squared[0] - at**2 - 2 * at * height,  # mean square of the heights
            dot[:, 0] - (x * normal).sum(axis=1),  # how far normals point away from the centre
            (own * normal).sum(axis=1),
            squared[1],
            pp[:, ::4].sum(axis=1) - 2 * (x * point).sum(axis=1) + (x**2).sum(axis=1),  # of the distances
        ]
        parts += [sums[:, :1] / density, np.stack(shape, axis=1), share]
    return np.hstack(parts)


def areas(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the AUC of each density, held out by complex, with intervals over complexes; and its change from the densest.

    Parameters
    ----------
    rows : DataFrame of `residues_of` with the column `complex`
    """
    from sklearn.ensemble import HistGradientBoostingClassifier  # here: only this measurement needs it
    from sklearn.model_selection import GroupKFold, cross_val_predict

    by_complex = {}
    for density, part in rows.groupby("density"):
        values = part[[name for name in part.columns if isinstance(name, int)]].to_numpy()
        inside = part["interface"].to_numpy(bool)
        folds = GroupKFold(min(FOLDS, part["complex"].nunique()))
        score = cross_val_predict(
            HistGradientBoostingClassifier(random_state=0),
            values,
            inside,
            groups=part["complex"],
            cv=folds,
            method="predict_proba",
        )[:, 1]
        groups = part.groupby("complex").indices.items()
        by_complex[density] = pd.Series({name: auc(score[at], inside[at]) for name, at in groups})
    table = pd.DataFrame(by_complex).dropna()
    found = rows.drop_duplicates(["density", "complex", "partner"]).groupby("density")["points"].mean()
    result = []
    for density, values in table.items():
        row = {"density": density} | with_interval("auc", values)
        row |= with_interval("change", values - table.iloc[:, -1])
        row |= {"points": found[density], "residues": int((rows["density"] == density).sum())}
        result.append(row | {"complexes": len(table)})
    return pd.DataFrame(result)


@threadpool_limits.wrap(limits=1)
def measure_interfaces(job: Job) -> None:
    """Measure the AUC of interface residues from points of several densities, over many complexes; needs scikit-learn."""
    seed, tables, table = job.params.seed, [], pd.DataFrame(columns=["density", *MEASURES])
    if find_spec("sklearn") is None:
        print("scikit-learn is not installed: nothing is measured (pip install scikit-learn).")
    else:
        for name, paths in job.params.complexes.items():
            pair = [read_molecule(path) for path in paths]
            for side in (0, 1):
                rows = residues_of(pair[side], pair[1 - side], job.params.densities, seed)
                tables.append(rows.assign(complex=name, partner=side))
        table = areas(pd.concat(tables, ignore_index=True))
    table.to_csv(job.output.table, index=False, float_format="%.4f")
