"""The surface that is reconstructed from the minimal subset: computed with its errors, and read for figures and pages."""

from pathlib import Path

import numpy as np

from sparsurf.errors import InputError, naming_file
from sparsurf.files import read_archive, read_bytes
from sparsurf.surfaces.surface import Surface


def write_reconstructed(path: Path | str, surface: Surface, distance: np.ndarray) -> None:
    """Store the dots of a reconstructed surface, and the distance (N,), Å, of each dot of the whole surface from it."""
    with open(path, "wb") as stream:
        np.savez(stream, points=surface.points, normals=surface.normals, distance=distance)


def read_reconstructed(path: Path | str, n_dots: int) -> tuple[Surface, np.ndarray]:
    """Read what `write_reconstructed` stored of a surface of `n_dots` dots: the reconstructed surface and the distances."""
    problem = "is damaged: delete it and run the study again"
    with naming_file(path):
        arrays = read_archive(read_bytes(path), problem)
    if not {"points", "normals", "distance"} <= arrays.keys() or arrays["distance"].shape != (n_dots,):
        raise InputError(f"{path} {problem}.")
    return Surface(arrays["points"], arrays["normals"]), arrays["distance"]
