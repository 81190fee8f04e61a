"""Describe sites: some dots of a surface with descriptors of the shape and the fields around them.

Patches are cut from the kept dots alone, so that a subset of a surface with its fields is sufficient.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from scipy.spatial import cKDTree

from sparsurf import InputError
from sparsurf.dot_fields.registry import compute_fields
from sparsurf.files import read_archive, read_bytes
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.descriptors import PATCHES_PER_CALL, describe, describe_fields
from sparsurf.patches.index import D_LINK, build_grid
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.recovery.recovering import dot_spacing
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.surfaces.surface import MAX_COORDINATE, ROUNDING_OF_NORMALS, Surface

FIELDS = ("hydropathy", "volume", "aromaticity", "charge", "potential")
PERCENT = 10  # of the dots are kept and described
RADIUS = 10.0  # Å, of the patches; the first hit is correct in 80 of 100 cases, with 6 Å in 72
ORDER = 10  # highest order n of the moments; finer detail differs between two forms of a protein
SHAPE = "shape"  # the channel next to the fields: r of the rotation-robust descriptor
MIN_DOTS_IN_PATCH = 12  # patches with fewer dots are not described
PLACES_AT_ONCE = 8 * PATCHES_PER_CALL  # described at a time; their float64 moments need 24 MB with all fields
VERSION = 2  # of saved Sites
LABELS = ("chain", "residue", "residue_name")
# Scalars of a file, and their kinds in numpy
SCALARS = {"sparsurf_sites": "U", "version": "iu", "order": "iu", "percent": "iuf", "radius": "iuf"}


@dataclass(frozen=True, eq=False)
class Sites:
    """Described places of one surface.

    Attributes
    ----------
    name : str
    points, normals : (P, 3) float32, Å and unit vectors
    labels : DataFrame of P rows: chain, residue, residue_name, str; empty if unknown
    numbers : (P, C, K) float16, moments ``|c_nm|`` up to ORDER for each channel: the shape, then the fields
    settings : dict: fields, percent, radius, order, version
    """

    name: str
    points: np.ndarray
    normals: np.ndarray
    labels: pd.DataFrame
    numbers: np.ndarray
    settings: dict[str, Any]

    def __repr__(self) -> str:
        return f"Sites of {len(self):,} places on {self.name}, described by shape, {', '.join(self.fields)}"

    def __len__(self) -> int:
        return len(self.points)

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the described fields."""
        return tuple(self.settings["fields"])

    def take(self, indices: np.ndarray) -> Sites:
        """Return some of the places, by a mask or by indices."""
        return Sites(
            self.name, self.points[indices], self.normals[indices], self.labels.iloc[indices].reset_index(drop=True),
            self.numbers[indices], self.settings,
        )  # fmt: skip

    def save(self, path: Path | str) -> None:
        """Write the Sites to a file of numpy arrays, about 500 bytes per place."""
        arrays: dict[str, Any] = {f"label_{key}": self.labels[key].to_numpy(str) for key in LABELS}
        arrays |= {key: np.array(value) for key, value in self.settings.items()}
        with open(path, "wb") as stream:
            np.savez(
                stream, sparsurf_sites=np.array(self.name), points=self.points, normals=self.normals,
                numbers=self.numbers, **arrays,
            )  # fmt: skip


def load_sites(path: Path | str) -> Sites:
    """Read a file that `Sites.save` wrote.

    Parameters
    ----------
    path : Path or str

    Returns
    -------
    Sites

    Raises
    ------
    InputError : the file does not contain Sites, or Sites of another version
    """
    problem = "holds no Sites, or is damaged: write it with Sites.save"
    arrays = read_archive(read_bytes(path), path, problem)
    version = arrays.get("version")
    if version is not None and version.shape == () and version.dtype.kind in "iu" and version != VERSION:
        raise InputError(f"{path} holds Sites of version {version}, not {VERSION}: describe them again.")
    try:
        _check_arrays(arrays)
    except (KeyError, ValueError):
        raise InputError(f"{path} {problem}.") from None
    labels = pd.DataFrame({key: arrays[f"label_{key}"] for key in LABELS})
    fields = [str(field) for field in arrays["fields"]]
    settings = _settings(fields, float(arrays["percent"]), float(arrays["radius"]))
    settings["order"] = int(arrays["order"])
    name = str(arrays["sparsurf_sites"])
    return Sites(name, arrays["points"], arrays["normals"], labels, arrays["numbers"], settings)


def _check_arrays(arrays: dict[str, np.ndarray]) -> None:
    """Raise ValueError or KeyError if the arrays of a file are not those of Sites."""
    for key, kinds in SCALARS.items():
        if arrays[key].shape != () or arrays[key].dtype.kind not in kinds:
            raise ValueError(f"{key} is not one value")
    if not str(arrays["sparsurf_sites"]).isprintable():
        raise ValueError("the name has characters that cannot be printed")
    if not (0 < arrays["percent"] <= 100 and 0 < arrays["radius"] < np.inf):
        raise ValueError("a setting is impossible")
    if arrays["fields"].ndim != 1 or (len(arrays["fields"]) and arrays["fields"].dtype.kind != "U"):
        raise ValueError("the fields are not names")
    n, n_moments = len(arrays["points"]), sum(order <= arrays["order"] for order, _ in indices())
    shapes = {"points": (n, 3), "normals": (n, 3), "numbers": (n, 1 + len(arrays["fields"]), n_moments)}
    shapes |= {f"label_{key}": (n,) for key in LABELS}
    if n == 0 or n_moments == 0 or any(arrays[key].shape != shape for key, shape in shapes.items()):
        raise ValueError("the arrays do not fit together")
    floats = [arrays[key] for key in ("points", "normals", "numbers")]
    if not all(array.dtype.kind == "f" and np.isfinite(array).all() for array in floats):
        raise ValueError("an array holds something else than finite numbers")
    if not all(arrays[f"label_{key}"].dtype.kind == "U" for key in LABELS):
        raise ValueError("labels are not strings")
    length = np.linalg.norm(arrays["normals"].astype(float), axis=1)
    if np.abs(arrays["points"]).max() >= MAX_COORDINATE or np.abs(length - 1).max() > ROUNDING_OF_NORMALS:
        raise ValueError("places or normals are impossible")


def _settings(fields: Iterable[str], percent: float, radius: float) -> dict[str, Any]:
    """Return the settings that Sites keep."""
    return {"fields": list(fields), "percent": percent, "radius": radius, "order": ORDER, "version": VERSION}


def default_settings() -> dict[str, Any]:
    """Return the settings of Sites that are described with the default options."""
    return _settings(FIELDS, float(PERCENT), RADIUS)


def describe_surface(
    dots: Surface,
    molecule: Molecule | None,
    name: str,
    percent: float = PERCENT,
    fields: Sequence[str] = FIELDS,
    at: np.ndarray | None = None,
    threads: int = 1,
) -> Sites:
    """Describe the places of a surface, using a farthest-point subset of its dots.

    Parameters
    ----------
    dots : Surface; without a molecule it must have the fields
    molecule : Molecule or None, to whose atoms `dots.atom` refers
    name : str
    percent : float, share of the dots that are kept
    fields : sequence of str
    at, threads : see `sites_of`

    Returns
    -------
    Sites

    Raises
    ------
    InputError : the dots lack a field, or no patch has enough dots
    """
    kept = farthest_subset(dots, percent)
    if molecule is not None:
        kept = replace(kept, fields={})
        if fields:
            table = compute_fields(fields, molecule, kept.points)
            kept = replace(kept, fields={str(key): table[key].to_numpy() for key in table})
    lacking = [key for key in fields if key not in kept.fields]
    if lacking:
        raise InputError(
            f"{name}: its dots have no {', '.join(lacking)}; use a structure, or dots with these columns."
        )
    kept = replace(kept, fields={key: kept.fields[key] for key in fields})
    labels = molecule.labels(kept.atom) if molecule is not None else _empty_labels(len(kept))
    return sites_of(kept, labels, name, percent, at, threads=threads)


def farthest_subset(dots: Surface, percent: float) -> Surface:
    """Choose a share of the dots by farthest-point sampling.

    Parameters
    ----------
    dots : Surface
    percent : float, share of the dots, above 0 to 100

    Returns
    -------
    Surface of at least one dot; the same for every call
    """
    if percent == 100:
        return dots
    n = max(1, round(percent / 100 * len(dots)))
    return dots.take(farthest_point_sampling(build_grid(dots.points), n, np.random.default_rng(0)))


def _empty_labels(n: int) -> pd.DataFrame:
    """Return labels of n dots whose residues are unknown."""
    return pd.DataFrame({key: np.full(n, "") for key in LABELS})


def places_of_residues(sites: Sites, residues: str) -> np.ndarray:
    """Select the places of some residues.

    Parameters
    ----------
    sites : Sites
    residues : str, such as 'A:10-25,40'

    Returns
    -------
    (n,) int, indices of places

    Raises
    ------
    InputError : the residues do not exist or have no places, or the dots have no residues
    """
    labels = sites.labels
    if not (labels["residue"] != "").any():
        raise InputError(f"{sites.name}: its dots have no residues; use a structure.")
    return np.flatnonzero(numbered_residues(labels, _select_residues(labels, sites.name, residues)) >= 0)


def _select_residues(labels: pd.DataFrame, name: str, residues: str) -> pd.DataFrame:
    """Select residues of labels like `Molecule.select`; return a DataFrame with LABELS."""
    first = labels.drop_duplicates(list(LABELS)).reset_index(drop=True)
    n = len(first)
    columns = {"name": np.full(n, "CA"), "element": np.full(n, "C"), "kind": np.full(n, "protein")}
    columns |= {key: first[key].to_numpy(str) for key in LABELS}
    one_atom_each = Molecule(
        np.zeros((1, n, 3)),
        np.zeros(1),
        np.zeros(1, int),
        residue_index=np.arange(n),
        b_factor=np.zeros(n),
        masked_residues=None,
        **columns,
    )
    return one_atom_each.select(name, selection="all", residues=residues).residues


def numbered_residues(labels: pd.DataFrame, residues: pd.DataFrame) -> np.ndarray:
    """Find the row of `residues` for each row of labels.

    Parameters
    ----------
    labels, residues : DataFrames with LABELS, of N and R rows

    Returns
    -------
    (N,) int, row of `residues`; -1 for none
    """
    number = {row: k for k, row in enumerate(residues[list(LABELS)].itertuples(index=False, name=None))}
    rows = labels[list(LABELS)].itertuples(index=False, name=None)
    return np.array([number.get(row, -1) for row in rows], int)


def sites_of(
    kept: Surface,
    labels: pd.DataFrame,
    name: str,
    percent: float,
    at: np.ndarray | None = None,
    radius: float = RADIUS,
    threads: int = 1,
) -> Sites:
    """Describe the kept dots of a surface.

    Parameters
    ----------
    kept : Surface with the fields to describe
    labels : DataFrame, chain, residue, residue_name of its dots
    name : str
    percent : float, share of the surface's dots that were kept
    at : (T, 3) float64, Å, optional; other places than the dots, with the labels of the nearest dot
    radius : float, Å
    threads : int

    Returns
    -------
    Sites, of the places whose patch holds at least MIN_DOTS_IN_PATCH dots

    Raises
    ------
    InputError : no patch has enough dots
    """
    nearest = np.arange(len(kept)) if at is None else cKDTree(kept.points).query(at)[1]
    places = kept.points if at is None else np.ascontiguousarray(at, np.float64)
    index = linked_by_spacing(kept.points, kept.normals, D_LINK, _area(kept))
    filled = np.array([_fill_unknown(value) for value in kept.fields.values()])
    low = np.array([n <= ORDER for n, _ in indices()])
    numbers = np.empty((len(places), 1 + len(kept.fields), low.sum()), np.float16)
    sizes = np.empty(len(places), np.int32)
    for begin in range(0, len(places), PLACES_AT_ONCE):
        block = slice(begin, begin + PLACES_AT_ONCE)
        z, sizes[block] = describe(index, places[block], radius, True, threads, "rotation_robust")
        numbers[block, 0] = z[:, low]
        if len(filled):
            numbers[block, 1:] = describe_fields(index, places[block], filled, radius, threads)[:, :, low]
    described = sizes >= MIN_DOTS_IN_PATCH
    if not described.any():
        raise InputError(
            f"{name}: no patch has {MIN_DOTS_IN_PATCH} dots; keep more of the dots, or use a larger surface."
        )
    points, normals = places.astype(np.float32), kept.normals[nearest].astype(np.float32)
    rows = labels[list(LABELS)].take(np.atleast_1d(nearest)).reset_index(drop=True)
    settings = _settings(kept.fields, float(percent), float(radius))
    return Sites(name, points, normals, rows, numbers, settings).take(np.flatnonzero(described))


def _area(kept: Surface) -> float:
    """Estimate the area of a surface in Å^2 from the distances between its dots."""
    return float((dot_spacing(kept.points, kept.normals) ** 2).sum())


def _fill_unknown(field: np.ndarray) -> np.ndarray:
    """Replace unknown values by the mean."""
    return np.where(np.isfinite(field), field, np.nanmean(field))
