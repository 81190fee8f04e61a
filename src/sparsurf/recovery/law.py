"""How many dots a surface needs: the error of the recovered surface is inversely proportional to the number of dots per Å^2.

The error grows with the square of the spacing of the dots, as it does for any surface of bounded curvature. The constant depends
on the radii of atoms and probe, and hardly differs between proteins. It was measured for farthest-point dots and a probe of
1.4 Å; with a probe of 2 Å the error is up to a tenth smaller.
"""

from sparsurf.arguments import DENSITY, DISTANCE

MEAN_OF_HEAVY_ATOMS = 0.0125  # Å: mean error times dots per Å^2
MEAN_WITH_HYDROGENS = 0.015
HIGH_99_OVER_MEAN = (
    5.2  # 99 % of the surface lies within so many times the mean error: 4.2 to 7.0 on the proteins tried
)


def constant(hydrogens: bool) -> float:
    """Return the mean error times dots per Å^2, Å, of a molecule with or without explicit hydrogens."""
    return MEAN_WITH_HYDROGENS if hydrogens else MEAN_OF_HEAVY_ATOMS


def density_for(error: float, *, hydrogens: bool = False) -> float:
    """Return how many evenly spread dots per Å^2 give a molecular surface back with a mean error.

    Parameters
    ----------
    error : float
        Mean distance of the recovered surface from the true one, Å.
    hydrogens : bool
        Whether the molecule has explicit hydrogens, which take a fifth more dots. By default it has none.

    Returns
    -------
    float
        Dots per Å^2: 0.0125 Å / error, with hydrogens 0.015 Å / error.

    Raises
    ------
    InputError
        If the error is not above 0 and at most 10 Å.

    Notes
    -----
    The law is of dots by farthest-point sampling. `minimal` starts from it and measures.

    Examples
    --------
    >>> import sparsurf
    >>> sparsurf.density_for(0.02)
    0.625
    >>> sparsurf.density_for(0.02, hydrogens=True)
    0.75
    """
    return constant(hydrogens) / DISTANCE.check(error, "error")


def error_at(density: float, *, hydrogens: bool = False) -> tuple[float, float]:
    """Return the mean error of a surface recovered from evenly spread dots, and the distance within which 99 % of it lies.

    Parameters
    ----------
    density : float
        Kept dots per Å^2.
    hydrogens : bool
        Whether the molecule has explicit hydrogens. By default it has none.

    Returns
    -------
    mean, high_99 : float
        Å. `high_99` is 5.2 times the mean.

    Raises
    ------
    InputError
        If the density is not above 0 and at most 100.

    Examples
    --------
    >>> import sparsurf
    >>> mean, high_99 = sparsurf.error_at(0.625)
    >>> round(mean, 3), round(high_99, 2)
    (0.02, 0.1)
    """
    mean = constant(hydrogens) / DENSITY.check(density, "density")
    return mean, HIGH_99_OVER_MEAN * mean
