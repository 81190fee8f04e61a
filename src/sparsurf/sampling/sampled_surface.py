"""What a sampler needs to know about a surface."""

from typing import Protocol

import numpy as np

from sparsurf.patches.index import Index
from sparsurf.sampling.published import Cover


class SampledSurface(Protocol):
    """A surface from which dots are chosen; `study.prepared_surface.PreparedSurface` is one.

    Attributes
    ----------
    points, normals : (N, 3) float64, Å and unit vectors
    index : Index
    roughness : (N,) float64, R_i of every dot
    cover, corrected_cover : Cover
        Patches of the published sampling, and those without its two defects.
    area : float, Å^2
    """

    points: np.ndarray
    normals: np.ndarray
    index: Index
    roughness: np.ndarray
    cover: Cover

    @property
    def corrected_cover(self) -> Cover:
        """Patches of the sampling without the two defects of the published one."""

    @property
    def area(self) -> float:
        """Area of the surface in Å^2."""
