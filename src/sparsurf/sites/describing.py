"""Sites of a surface: some of its dots, each with numbers for the shape and the fields around it.

Patches are cut from the kept dots alone, so that a subset of a surface, with its fields, is all that is needed.
"""

from dataclasses import dataclass

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.patches.descriptors import describe, describe_fields
from sparsurf.patches.index import D_LINK
from sparsurf.patches.readings import linked_by_spacing
from sparsurf.patches.zernike.polynomials import indices
from sparsurf.texts import read_bytes

FIELDS = ("hydropathy", "volume", "aromaticity", "charge", "potential")
RADIUS = 10.0  # Å, of the patches; with 6 Å the first hit is right in 72 of 100, with 10 Å in 80
ORDER = 10  # highest order n of the moments; finer detail differs between two forms of a protein
SHAPE = "shape"  # the channel besides the fields: r of the steady descriptor
FEWEST = 12  # dots of a patch that has numbers
VERSION = 1  # of saved Sites


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

    try:
        with np.load(io.BytesIO(read_bytes(path)), allow_pickle=False) as file:
            held = {key: file[key] for key in file.files}
        version = int(held["version"])
        n, wide = len(held["points"]), 1 + len(held["fields"])
        shapes = {"points": (n, 3), "normals": (n, 3), "numbers": (n, wide, *held["numbers"].shape[2:])}
        shapes |= {f"label_{key}": (n,) for key in LABELS}
        if any(held[key].shape != shape for key, shape in shapes.items()) or held["numbers"].ndim != 3:
            raise ValueError
        if not all(np.isfinite(held[key]).all() for key in ("points", "normals", "numbers")):
            raise ValueError
    except (KeyError, ValueError, OSError, EOFError, zipfile.BadZipFile):
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
    from sparsurf.recovery.recovering import spacing_of

    return float((spacing_of(kept.points, kept.normals) ** 2).sum())


def _filled(values):
    """Values with the mean in place of unknown ones: an unknown dot says nothing."""
    return np.where(np.isfinite(values), values, np.nanmean(values))
