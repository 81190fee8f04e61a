"""Sites of a surface: some of its dots, each with numbers for the shape and the fields around it.

Patches are cut from the kept dots alone, so that a subset of a surface, with its fields, is all that is needed.
"""

from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.dot_fields.registry import values
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.descriptors import describe, describe_fields
from sparsurf.patches.index import D_LINK, build_grid
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.texts import read_bytes

FIELDS = ("hydropathy", "volume", "aromaticity", "charge", "potential")
PERCENT = 10  # of the dots that are kept and described
RADIUS = 10.0  # Å, of the patches; with 6 Å the first hit is right in 72 of 100, with 10 Å in 80
ORDER = 10  # highest order n of the moments; finer detail differs between two forms of a protein
SHAPE = "shape"  # the channel besides the fields: r of the steady descriptor
FEWEST = 12  # dots of a patch that has numbers
VERSION = 2  # of saved Sites


@dataclass(frozen=True, eq=False)
class Sites:
    """Places of one surface.

    Attributes
    ----------
    name : str
    points, normals : (P, 3) float32, Å and unit vectors
    labels : DataFrame of P rows: chain, residue, residue_name, str; empty where unknown
    numbers : (P, C, K) float16, moments ``|c_nm|`` up to ORDER of each channel, the shape first, then the fields
    settings : dict: fields, percent, radius, order, version
    """

    name: str
    points: np.ndarray
    normals: np.ndarray
    labels: pd.DataFrame
    numbers: np.ndarray
    settings: dict

    def __len__(self):
        return len(self.points)

    @property
    def fields(self):
        return tuple(self.settings["fields"])

    def take(self, places):
        """Only `places`, a mask or indices."""
        return Sites(
            self.name, self.points[places], self.normals[places], self.labels.iloc[places].reset_index(drop=True),
            self.numbers[places], self.settings,
        )  # fmt: skip

    def save(self, path):
        """Write the Sites as a file of numpy arrays, about 500 bytes a place."""
        text = {f"label_{key}": self.labels[key].to_numpy(str) for key in LABELS}
        fixed = {key: np.array(value) for key, value in self.settings.items()}
        with open(path, "wb") as stream:
            np.savez(
                stream, sparsurf_sites=np.array(self.name), points=self.points, normals=self.normals,
                numbers=self.numbers, **text, **fixed,
            )  # fmt: skip


LABELS = ("chain", "residue", "residue_name")


def load_sites(path):
    """Sites of a file that `Sites.save` wrote.

    Raises
    ------
    InputError : another file, or Sites of another version
    """
    import io
    import zipfile

    content = read_bytes(path)
    try:
        with np.load(io.BytesIO(content), allow_pickle=False) as file:
            held = {key: file[key] for key in file.files}
        version = int(held["version"])
        n, wide = len(held["points"]), 1 + len(held["fields"])
        shapes = {"points": (n, 3), "normals": (n, 3), "numbers": (n, wide, *held["numbers"].shape[2:])}
        shapes |= {f"label_{key}": (n,) for key in LABELS}
        if (
            any(held[key].shape != shape for key, shape in shapes.items())
            or held["numbers"].ndim != 3
            or not n
        ):
            raise ValueError
        floats = [held[key] for key in ("points", "normals", "numbers")]
        if not all(each.dtype.kind == "f" and np.isfinite(each).all() for each in floats):
            raise ValueError
    except (KeyError, ValueError, TypeError, OSError, EOFError, zipfile.BadZipFile):
        raise InputError(f"{path} holds no Sites, or is damaged: write it with Sites.save.") from None
    if version != VERSION:
        raise InputError(f"{path} holds Sites of version {version}, not {VERSION}: describe them again.")
    labels = pd.DataFrame({key: held[f"label_{key}"] for key in LABELS})
    settings = _settings(
        [str(each) for each in held["fields"]], float(held["percent"]), float(held["radius"])
    )
    settings["order"] = int(held["order"])
    return Sites(
        str(held["sparsurf_sites"]), held["points"], held["normals"], labels, held["numbers"], settings
    )


def _settings(fields, percent, radius):
    return {"fields": list(fields), "percent": percent, "radius": radius, "order": ORDER, "version": VERSION}


def describe_surface(dots, molecule, name, percent=PERCENT, fields=FIELDS, at=None, threads=1):
    """Sites of a surface: of its dots some are kept, each the farthest from those before.

    Parameters
    ----------
    dots : Surface, without a molecule with the fields to describe
    molecule : molecules.Molecule or None, which `dots.atom` counts
    name : str
    percent : float
    fields : sequence of str
    at, threads : as for `sites_of`

    Returns
    -------
    Sites

    Raises
    ------
    InputError : dots without these fields, or of no place with numbers
    """
    kept = few_of(dots, percent)
    if molecule is not None:
        table = values(fields, molecule, kept.points) if fields else {}
        kept = replace(kept, fields={key: np.asarray(table[key]) for key in table})
    lacking = [key for key in fields if key not in kept.fields]
    if lacking:
        raise InputError(
            f"{name}: its dots have no {', '.join(lacking)}; take a structure, or dots with such columns."
        )
    kept = replace(kept, fields={key: kept.fields[key] for key in fields})
    labels = molecule.labels(kept.atom) if molecule is not None else _no_labels(len(kept))
    return sites_of(kept, labels, name, percent, at, threads=threads)


def few_of(dots, percent):
    """The dots that stand for a surface: the given share of them, each the farthest from those before."""
    if percent == 100:
        return dots
    n = max(1, round(percent / 100 * len(dots)))
    return dots.take(farthest_point_sampling(build_grid(dots.points), n, np.random.default_rng(0)))


def _no_labels(n):
    return pd.DataFrame({key: np.full(n, "") for key in LABELS})


def places_of_residues(sites, residues):
    """Places (n,) int of Sites that belong to residues such as 'A:10-25,40'.

    Raises
    ------
    InputError : residues that are not there or have no places, or dots without residues
    """
    labels = sites.labels
    if not (labels["residue"] != "").any():
        raise InputError(f"{sites.name}: its dots have no residues; describe the sites of a structure.")
    return np.flatnonzero(numbered_residues(labels, _residues_of(labels, sites.name, residues)) >= 0)


def _residues_of(labels, name, residues):
    """Those of the residues of labels that are asked for, DataFrame with LABELS."""
    first = labels.drop_duplicates(list(LABELS)).reset_index(drop=True)
    n = len(first)
    columns = {"name": np.full(n, "CA"), "element": np.full(n, "C"), "kind": np.full(n, "protein")}
    columns |= {key: first[key].to_numpy(str) for key in LABELS}
    shown = Molecule(
        np.zeros((1, n, 3)),
        np.zeros(1),
        np.zeros(1, int),
        residue_index=np.arange(n),
        b_factor=np.zeros(n),
        **columns,
    )
    return shown.select(name, selection="all", residues=residues).residues


def numbered_residues(labels, residues):
    """Which of some residues each row of labels is of, (N,) int; -1 for none. Both are DataFrames with LABELS."""
    number = {row: k for k, row in enumerate(residues[list(LABELS)].itertuples(index=False, name=None))}
    rows = labels[list(LABELS)].itertuples(index=False, name=None)
    return np.array([number.get(row, -1) for row in rows], int)


def sites_of(kept, labels, name, percent, at=None, radius=RADIUS, threads=1):
    """Sites of the kept dots of a surface.

    Parameters
    ----------
    kept : Surface with the fields to describe
    labels : DataFrame, chain, residue, residue_name of its dots
    name : str
    percent : float, share of the surface's dots that were kept
    at : (T, 3) float64, Å, optional; places other than the dots, labelled as the nearest dot
    radius : float, Å
    threads : int

    Returns
    -------
    Sites, of the places whose patch holds at least FEWEST dots

    Raises
    ------
    InputError : no such place
    """
    from scipy.spatial import cKDTree

    nearest = np.arange(len(kept)) if at is None else cKDTree(kept.points).query(at)[1]
    places = kept.points if at is None else np.ascontiguousarray(at, np.float64)
    area = _area(kept)
    index = linked_by_spacing(kept.points, kept.normals, D_LINK, area)
    z, sizes = describe(index, places, radius, True, threads, "steady")
    fine = sizes >= FEWEST
    if not fine.any():
        raise InputError(
            f"{name}: no patch has {FEWEST} dots; keep more of the dots, or take a larger surface."
        )
    low = np.array([n <= ORDER for n, _ in indices()])
    numbers = np.empty((len(places), 1 + len(kept.fields), low.sum()), np.float16)
    numbers[:, 0] = z[:, low]
    if kept.fields:
        values = np.array([_filled(value) for value in kept.fields.values()])
        numbers[:, 1:] = describe_fields(index, places, values, radius, threads)[:, :, low]
    points, normals = places.astype(np.float32), kept.normals[nearest].astype(np.float32)
    rows = labels.iloc[nearest][list(LABELS)].reset_index(drop=True)
    settings = _settings(kept.fields, float(percent), float(radius))
    return Sites(name, points, normals, rows, numbers, settings).take(np.flatnonzero(fine))


def _area(kept):
    """Area of the surface that dots stand for, Å^2, by the distances between them."""
    from sparsurf.recovery.recovering import dot_spacing

    return float((dot_spacing(kept.points, kept.normals) ** 2).sum())


def _filled(values):
    """Values with the mean in place of unknown ones: an unknown dot says nothing."""
    return np.where(np.isfinite(values), values, np.nanmean(values))
