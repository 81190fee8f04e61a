"""How many dots a surface needs: measured errors of reconstructed surfaces by the density of the kept dots.

The errors are means over proteins of the distances of independent dots of the whole surface from the reconstructed one, with a
probe of 1.4 Å and the radii of DMS (`evidence/measures/spheres.py`). Between two measured densities, their logarithms are joined
by a straight line. With the interpolant the mean error is nearly inversely proportional to the density, because a smooth surface
errs at the seams and creases between pieces of spheres and tori (docs/why.md). With the spheres it falls faster, because two or
three dots determine an atom.
"""

import math
from itertools import pairwise
from typing import Literal, NamedTuple, get_args

from sparsurf.arguments import (
    AUTO,
    INTERPOLANT,
    SPHERES,
    Model,
    check_choice,
    check_flag,
    public,
)
from sparsurf.errors import InputError
from sparsurf.registry import COVER, FARTHEST
from sparsurf.settings import TAIL_PER_ERROR

# Å, mean error times dots per Å^2, from which a search for a density starts
START_OF_HEAVY_ATOMS, START_WITH_HYDROGENS = 0.0125, 0.015


class Measured(NamedTuple):
    """Mean and 99 % error, Å, at some densities of the kept dots, dots per Å^2, ascending."""

    density: tuple[float, ...]
    mean: tuple[float, ...]
    high_99: tuple[float, ...]


MEASURED_FROM, MEASURED_TO = 0.15, 2.4  # dots per Å^2, of evenly spread dots
ROUNDING_OF_DENSITY = 1e-9  # relative, of a density from `density_for`
# Å, for which dots that touch every exposed atom were measured: few more than that touch each twice
LARGEST_REQUEST = 0.05
MeasuredSampler = Literal["farthest", "cover"]
# By sampler, reconstruction, and whether the molecules have hydrogens: evidence/tables/spheres_means.csv, in three digits
MEASURED: dict[tuple[str, Model, bool], Measured] = {
    (FARTHEST, INTERPOLANT, False): Measured(
        (0.15, 0.25, 0.3, 0.4, 0.6, 1.2, 2.4),
        (0.0851, 0.0471, 0.0385, 0.028, 0.0178, 0.00818, 0.00388),
        (0.434, 0.226, 0.189, 0.145, 0.0988, 0.0545, 0.0293),
    ),
    (FARTHEST, SPHERES, False): Measured(
        (0.15, 0.25, 0.3, 0.4, 0.6, 1.2, 2.4),
        (0.033, 0.00898, 0.00541, 0.00275, 0.00096, 0.000676, 0.000424),
        (0.354, 0.141, 0.105, 0.0671, 0.0254, 0.00461, 0.000937),
    ),
    (COVER, SPHERES, False): Measured(
        (0.123, 0.133, 0.144, 0.24),
        (0.00751, 0.00244, 0.000585, 0.000141),
        (0.191, 0.0738, 0.0139, 0.00185),
    ),
    (FARTHEST, INTERPOLANT, True): Measured(
        (0.15, 0.25, 0.3, 0.4, 0.6, 1.2, 2.4),
        (0.1, 0.0549, 0.0444, 0.0326, 0.0211, 0.0102, 0.00508),
        (0.474, 0.265, 0.207, 0.16, 0.11, 0.0577, 0.0346),
    ),
    (FARTHEST, SPHERES, True): Measured(
        (0.15, 0.25, 0.3, 0.4, 0.6, 1.2, 2.4),
        (0.0718, 0.0185, 0.0111, 0.00574, 0.00232, 0.000483, 0.000205),
        (0.451, 0.189, 0.137, 0.0918, 0.0515, 0.0127, 0.00317),
    ),
    (COVER, SPHERES, True): Measured(
        (0.193, 0.21, 0.226, 0.31),
        (0.00563, 0.00226, 0.000665, 0.000182),
        (0.142, 0.0706, 0.0198, 0.00331),
    ),
}


def start_density(error: float, hydrogens: bool) -> float:
    """Return the dots per Å^2 at which a search for evenly spread dots with a mean error, Å, starts; any error has one."""
    return (START_WITH_HYDROGENS if hydrogens else START_OF_HEAVY_ATOMS) / error


@public(renamed={"model": "reconstruction"})
def density_for(
    error: float,
    *,
    hydrogens: bool = False,
    sampler: MeasuredSampler = FARTHEST,
    reconstruction: Model = AUTO,
) -> float:
    """Return the density of kept dots from which a surface is reconstructed with a given mean error.

    Parameters
    ----------
    error : float
        Mean distance of the true surface from the reconstructed one, Å. With the sampler 'cover', 99 % of the true surface also
        lies within 5 times this distance from the reconstructed one.
    hydrogens : bool
        Whether the molecule has explicit hydrogens (default False). They need more dots.
    sampler : {'farthest', 'cover'}
        How the dots are chosen, as in `minimal` (default 'farthest', evenly spread dots).
    reconstruction : {'auto', 'interpolant', 'spheres'}
        How the surface is reconstructed; 'auto' (default) is 'spheres' with the sampler 'cover', and 'interpolant' with
        'farthest', as in `minimal`. 'spheres' is what `recover` does by default.

    Returns
    -------
    float
        Dots per Å^2.

    Raises
    ------
    InputError
        The error lies outside of the measured range, which the message says, or nobody measured it for this
        sampler and reconstruction.

    Notes
    -----
    Single proteins deviate from these means of many: `minimal` measures the error of each surface.

    Examples
    --------
    >>> import sparsurf
    >>> ways = {}, {"reconstruction": "spheres"}, {"sampler": "cover"}
    >>> [round(sparsurf.density_for(0.02, **way), 2) for way in ways]
    [0.54, 0.18, 0.13]
    """
    law = _law(hydrogens, sampler, reconstruction)
    largest, smallest = law.mean[0], law.mean[-1]
    if sampler == COVER:
        largest, smallest = (max(pair[0], pair[1] / TAIL_PER_ERROR) for pair in zip(*_ends(law), strict=True))
        largest = max(largest, LARGEST_REQUEST)
    if not smallest <= error <= largest:
        raise InputError(
            f"error is {error:g}; the densities for errors of {smallest:.2g} to {largest:.2g} Å were "
            f"measured{_of(sampler, reconstruction)}. `minimal` measures other errors on a surface."
        )
    density = _at(law.mean, law.density, error)
    return (
        max(density, _at(law.high_99, law.density, TAIL_PER_ERROR * error)) if sampler == COVER else density
    )


@public(renamed={"model": "reconstruction"})
def error_at(
    density: float,
    *,
    hydrogens: bool = False,
    sampler: MeasuredSampler = FARTHEST,
    reconstruction: Model = AUTO,
) -> tuple[float, float]:
    """Return the error of a surface that is reconstructed from kept dots of a given density.

    Parameters
    ----------
    density : float
        Kept dots per Å^2.
    hydrogens : bool
        Whether the molecule has explicit hydrogens (default False).
    sampler, reconstruction : str
        As in `density_for`.

    Returns
    -------
    mean : float
        Mean distance of the true surface from the reconstructed one, Å.
    high_99 : float
        Distance within which 99 % of the true surface lies, Å.

    Raises
    ------
    InputError
        The density lies outside of the measured range, which the message says, or nobody measured it for this
        sampler and reconstruction.

    Notes
    -----
    This is the inverse of `density_for`, from the same measurements.

    Examples
    --------
    >>> import sparsurf
    >>> mean, high_99 = sparsurf.error_at(sparsurf.density_for(0.02))
    >>> round(mean, 4)
    0.02
    """
    law = _law(hydrogens, sampler, reconstruction)
    if (
        not law.density[0] * (1 - ROUNDING_OF_DENSITY)
        <= density
        <= law.density[-1] * (1 + ROUNDING_OF_DENSITY)
    ):
        raise InputError(
            f"density is {density:g}; errors were measured at {law.density[0]:.2g} to {law.density[-1]:.2g} dots per Å^2"
            f"{_of(sampler, reconstruction)}. `minimal` measures the error of other subsets."
        )
    return _at(law.density, law.mean, density), _at(law.density, law.high_99, density)


def _law(hydrogens: bool, sampler: str, reconstruction: Model) -> Measured:
    """Return the measurements of a sampler and a reconstruction; raise InputError if there are none."""
    check_flag(hydrogens, "hydrogens")
    check_choice(sampler, get_args(MeasuredSampler), "sampler")
    if reconstruction == AUTO:
        reconstruction = SPHERES if sampler == COVER else INTERPOLANT
    if (sampler, reconstruction, bool(hydrogens)) not in MEASURED:
        raise InputError(
            f"the sampler {sampler!r} chooses dots for the reconstruction 'spheres', not for {reconstruction!r}; leave it out."
        )
    return MEASURED[sampler, reconstruction, bool(hydrogens)]


def _ends(law: Measured) -> tuple[tuple[float, float], tuple[float, float]]:
    """Return mean and 99 % error at the lowest and the highest density."""
    return (law.mean[0], law.mean[-1]), (law.high_99[0], law.high_99[-1])


def _of(sampler: str, reconstruction: Model) -> str:
    """Return for which dots something was measured, unless these are the default."""
    is_default = (sampler, reconstruction) == (FARTHEST, AUTO)
    return "" if is_default else f" with sampler={sampler!r} and reconstruction={reconstruction!r}"


def _at(x: tuple[float, ...], y: tuple[float, ...], value: float) -> float:
    """Interpolate y at a value of x between the logarithms of both; beyond the ends it is the value at the end."""
    pairs = sorted(zip(map(math.log, x), map(math.log, y), strict=True))
    log_value = math.log(value)
    if log_value <= pairs[0][0]:
        return math.exp(pairs[0][1])
    for (x0, y0), (x1, y1) in pairwise(pairs):
        if log_value <= x1:
            return math.exp(y0 + (y1 - y0) * (log_value - x0) / (x1 - x0))
    return math.exp(pairs[-1][1])
