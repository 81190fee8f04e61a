"""Reconstruct a surface from few dots by spheres or the interpolant, as asked for, and measure its distance from other dots."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from sparsurf.arguments import AUTO, INTERPOLANT, SPHERES, Model
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_surface
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.interpolated_surface import MIN_INTERPOLATED, NEWTON_STEPS, REACH, interpolate_surface
from sparsurf.recovery.spheres.rebuilding import Rebuilt, rebuild_at
from sparsurf.recovery.spheres.votes import MIN_DOTS
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.molecular_surface import RolledFrame
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface

log = logging.getLogger("sparsurf")

MIN_SHARE = 0.5  # of the dots on spheres of inferred atoms, where the spheres are asked for
# Dots per Å^2 of the surface from which the errors of spheres are measured, which are smaller than those of the interpolant
DENSITY_FOR_SPHERES = 40.0
# The same where the distance of each dot from the true surface is exact: six times as many change the errors by 2 %
DENSITY_FOR_EXACT_ERRORS = 10.0


def reconstruct(
    few: Surface,
    density: float = DENSITY,
    model: Model = AUTO,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
) -> Rebuilt:
    """Reconstruct the surface of few dots, with the dots first.

    The model 'auto' is the one that the dots say, or else the spheres where the dots lie on them. Other arguments are those of
    `interpolate_surface`.
    """
    return reconstruct_at(few, (density,), model, reach, steps, threads)[0]


def surface_with_fields(few: Surface, rebuilt: Rebuilt) -> Surface:
    """Return the reconstructed surface of few dots, on which their fields are interpolated."""
    fields = fields_without_component(few)
    between = interpolate_fields(few.points, fields, rebuilt.points[len(few) :])
    fields = {name: np.concatenate([fields[name], values]) for name, values in between.items()}
    return Surface(rebuilt.points, rebuilt.normals, rebuilt.area, fields=fields)


def reconstruct_at(
    few: Surface,
    densities: Sequence[float],
    model: Model = AUTO,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
) -> list[Rebuilt]:
    """Reconstruct the surface of few dots as `reconstruct` does, at each of several densities."""
    origin = few.reconstruction
    if len(few) < MIN_INTERPOLATED:
        log.warning(
            "recover: a surface is reconstructed from at least %d dots; %s given, and the result has no others",
            MIN_INTERPOLATED, pluralise(len(few), "dot", "is"),
        )  # fmt: skip
    if model == INTERPOLANT or (model == AUTO and origin is not None and origin.model == INTERPOLANT):
        dots = few.points, few.normals
        return [Rebuilt(*interpolate_surface(*dots, density, reach, steps, threads)) for density in densities]
    probe_radius, radii = (None, None) if origin is None else (origin.probe_radius, origin.radii)
    rebuilt = rebuild_at(
        few.points,
        few.normals,
        densities,
        reach,
        steps,
        threads,
        probe_radius,
        radii,
        chosen=origin is not None and origin.model == SPHERES,
    )
    found = rebuilt[0]
    if model == SPHERES and found.share < MIN_SHARE:
        reason = f"{100 * found.share:.0f} % of them lie on spheres of atoms that follow from them, and half of them must"
        if len(few) < MIN_DOTS:
            reason = f"there are {len(few)}, and atoms follow from at least {MIN_DOTS}"
        raise InputError(
            f"recover: the reconstruction 'spheres' does not suit these dots: {reason}; leave it out, or give 'interpolant'."
        )
    if origin is not None and origin.model == SPHERES and found.share < MIN_SHARE:
        log.warning(
            "recover: only %.0f %% of the dots lie on spheres of atoms that follow from them with their probe of %g Å and "
            "their radii '%s'; the rest is interpolated, with a larger error. If their file names these wrongly, "
            "remove its columns probe_radius, radii and reconstruction, so that both are inferred.",
            100 * found.share, origin.probe_radius, origin.radii,
        )  # fmt: skip
    return rebuilt


class Reconstructed(NamedTuple):
    """The surface of few dots at two densities; `reconstruct_twice` makes it."""

    dense: Surface  # from whose dots errors are measured
    comparable: Surface  # as dense as the whole surface, for patches and pictures
    share: float  # of the dots that lie on inferred atoms; 0 where the interpolant is used everywhere

    @property
    def model(self) -> str:
        """'spheres' if some of the dots lie on inferred atoms, else 'interpolant'."""
        return SPHERES if self.share > 0 else INTERPOLANT

    def distances(self, points: np.ndarray, threads: int = 1, true: RolledFrame | None = None) -> np.ndarray:
        """Compute the distance (M,), Å, of points from the reconstructed surface; `true` as in `distance_to_surface`."""
        return distance_to_surface(points, self.dense.points, self.dense.normals, threads, true)


def reconstruct_twice(
    few: Surface,
    density: float,
    model: Model = AUTO,
    threads: int = 1,
    of_spheres: float = DENSITY_FOR_SPHERES,
) -> Reconstructed:
    """Reconstruct the surface of few dots for its errors, and at `density` dots per Å^2; 'spheres' refuses no dots here.

    Errors are measured from dots of the density `of_spheres` where these lie on spheres.
    """
    densely, comparable = _densely(few, model, threads, density, of_spheres=of_spheres)
    return Reconstructed(Surface(*densely[:2]), Surface(*comparable[:2]), densely.share)


def _densely(
    few: Surface, model: Model, threads: int, *densities: float, of_spheres: float = DENSITY_FOR_SPHERES
) -> list[Rebuilt]:
    """Reconstruct the surface of few dots so densely that errors are measured from its dots, and at further densities.

    Returned is of each what `reconstruct` returns; the model 'spheres' refuses no dots.
    """
    if model == INTERPOLANT:
        densities = (DENSITY_FOR_ERRORS, *densities)
        return reconstruct_at(few, densities, INTERPOLANT, threads=threads)
    dense, *further = reconstruct_at(few, (of_spheres, *densities), AUTO, threads=threads)
    if dense.share == 0:
        dense = reconstruct(few, DENSITY_FOR_ERRORS, INTERPOLANT, threads=threads)
    return [dense, *further]


def distance_to_reconstructed(
    points: np.ndarray, few: Surface, model: Model = AUTO, threads: int = 1
) -> np.ndarray:
    """Compute the distance (M,), Å, of points from the surface of few dots; 'spheres' refuses no dots here."""
    return distance_to_surface(points, *_densely(few, model, threads)[0][:2], threads)
