"""Reconstruct a surface from few dots by spheres or the interpolant, as asked for, and measure its distance from other dots."""

from __future__ import annotations

import logging
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from sparsurf.arguments import AUTO, INTERPOLANT, SPHERES, Model
from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf.recovery.errors import DENSITY_FOR_ERRORS, distance_to_surface
from sparsurf.recovery.fields import interpolate_fields
from sparsurf.recovery.interpolated_surface import MIN_INTERPOLATED, NEWTON_STEPS, REACH, interpolate_surface
from sparsurf.recovery.spheres.rebuilding import KeptDots, Rebuilt
from sparsurf.recovery.spheres.votes import MIN_DOTS, model_of
from sparsurf.surfaces.components import fields_without_component
from sparsurf.surfaces.molecular_surface import RolledFrame
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Surface

log = logging.getLogger("sparsurf")

# Where spheres are asked for, this share of the dots must lie on spheres of inferred atoms.
MIN_SHARE = 0.5
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
    return reconstruction_of(few, model, reach, steps, threads)(density)


def surface_with_fields(few: Surface, rebuilt: Rebuilt) -> Surface:
    """Return the reconstructed surface of few dots, on which their fields are interpolated."""
    fields = fields_without_component(few)
    between = interpolate_fields(few.points, fields, rebuilt.points[len(few) :])
    fields = {name: np.concatenate([fields[name], values]) for name, values in between.items()}
    return Surface(rebuilt.points, rebuilt.normals, rebuilt.area, fields=fields)


def reconstruction_of(
    few: Surface,
    model: Model,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    threads: int = 1,
) -> Callable[[float], Rebuilt]:
    """Return a function that reconstructs the surface of few dots, as `reconstruct` does, at any density."""
    origin = few.reconstruction
    if len(few) < MIN_INTERPOLATED:
        log.warning(
            "recover: a surface is reconstructed from at least %d dots; %s given, and the result has no others",
            MIN_INTERPOLATED, pluralise(len(few), "dot", "is"),
        )  # fmt: skip
    if model == INTERPOLANT or (model == AUTO and origin is not None and origin.model == INTERPOLANT):
        dots = few.points, few.normals
        return lambda density: Rebuilt(*interpolate_surface(*dots, density, reach, steps, threads))
    probe_radius, radii = (None, None) if origin is None else (origin.probe_radius, origin.radii)
    kept = KeptDots(few.points, few.normals, model_of(few.points, few.normals, probe_radius, radii), threads)
    share = kept.share if kept.lie_on_spheres else 0.0
    chosen = origin is not None and origin.model == SPHERES
    if model == SPHERES and share < MIN_SHARE:
        reason = f"{100 * share:.0f} % of them lie on spheres of atoms that follow from them, and half of them must"
        if len(few) < MIN_DOTS:
            reason = f"there are {len(few)}, and atoms follow from at least {MIN_DOTS}"
        raise InputError(
            f"recover: the reconstruction 'spheres' does not suit these dots: {reason}; leave it out, or give 'interpolant'."
        )
    if origin is not None and chosen and share < MIN_SHARE:
        log.warning(
            "recover: only %.0f %% of the dots lie on spheres of atoms that follow from them with their probe of %g Å and "
            "their radii '%s'; the rest is interpolated, with a larger error. If their file names these wrongly, "
            "remove its columns probe_radius, radii and reconstruction, so that both are inferred.",
            100 * share, origin.probe_radius, origin.radii,
        )  # fmt: skip
    return lambda density: kept.rebuilt(density, reach, steps, chosen)


@dataclass(frozen=True, eq=False)
class Reconstructed:
    """The surface of few dots at two densities; `reconstruct_twice` makes it."""

    dense: Surface  # from whose dots errors are measured
    share: float  # of the dots that lie on inferred atoms; 0 where the interpolant is used everywhere
    _place_comparable: Callable[[], Rebuilt] = field(repr=False)

    @cached_property
    def comparable(self) -> Surface:
        """The surface as dense as the whole one, for patches and pictures, reconstructed when it is first read."""
        return Surface(*self._place_comparable()[:2])

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
    model: Model,
    threads: int = 1,
    of_spheres: float = DENSITY_FOR_SPHERES,
) -> Reconstructed:
    """Reconstruct the surface of few dots for its errors, and at `density` dots per Å^2; 'spheres' refuses no dots here.

    Errors are measured from dots of the density `of_spheres` where these lie on spheres.
    """
    dense, of_density = _densely(few, model, threads, of_spheres)
    return Reconstructed(Surface(*dense[:2]), dense.share, partial(of_density, density))


def _densely(
    few: Surface, model: Model, threads: int, of_spheres: float = DENSITY_FOR_SPHERES
) -> tuple[Rebuilt, Callable[[float], Rebuilt]]:
    """Reconstruct the surface of few dots densely enough to measure errors from its dots.

    Also return the function that reconstructs it at another density. The model 'spheres' refuses no dots.
    """
    if model == INTERPOLANT:
        of_density = reconstruction_of(few, INTERPOLANT, threads=threads)
        return of_density(DENSITY_FOR_ERRORS), of_density
    of_density = reconstruction_of(few, AUTO, threads=threads)
    dense = of_density(of_spheres)
    if dense.share == 0:
        dense = reconstruct(few, DENSITY_FOR_ERRORS, INTERPOLANT, threads=threads)
    return dense, of_density


def distance_to_reconstructed(points: np.ndarray, few: Surface, model: Model, threads: int = 1) -> np.ndarray:
    """Compute the distance (M,), Å, of points from the surface of few dots; 'spheres' refuses no dots here."""
    return distance_to_surface(points, *_densely(few, model, threads)[0][:2], threads)
