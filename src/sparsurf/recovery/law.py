"""How many dots a surface needs: the error of the reconstructed surface is inversely proportional to the number of dots per Å^2.

The error grows with the square of the spacing of the dots, as it does for any surface of bounded curvature. The constant depends
on the radii of atoms and probe, and differs little between proteins. It was measured for farthest-point dots and a probe of
1.4 Å; with a probe of 2 Å the error is up to a tenth smaller.
"""

from sparsurf.arguments import DENSITY, DISTANCE, check_flag

MEAN_OF_HEAVY_ATOMS = 0.0125  # Å: mean error times dots per Å^2
MEAN_WITH_HYDROGENS = 0.015
HIGH_99_OVER_MEAN = (
    5.2  # 99 % of the surface lies within so many times the mean error: 4.2 to 7.0 on the proteins tried
)


def constant(hydrogens: bool) -> float:
    """Return the mean error times dots per Å^2, Å, of a molecule with or without explicit hydrogens."""
    check_flag(hydrogens, "hydrogens")
    return MEAN_WITH_HYDROGENS if hydrogens else MEAN_OF_HEAVY_ATOMS


def density_for(error: float, *, hydrogens: bool = False) -> float:
    """Return the density of evenly spread dots from which a surface is reconstructed with a given mean error.

    Parameters
    ----------
    error : float
        Mean distance of the reconstructed surface from the true one, Å; more than 0 and at most 10.
    hydrogens : bool
        Whether the molecule has explicit hydrogens (default False). They need a fifth more dots.

    Returns
    -------
    float
        Dots per Å^2: 0.0125 Å / error, or 0.015 Å / error with hydrogens.

    Raises
    ------
    InputError
        The error is not above 0 and at most 10 Å.

    Notes
    -----
    This law was fitted to dots chosen by farthest-point sampling, with a probe of 1.4 Å. `minimal` starts from it and
    measures the error.

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
    """Return the error of a surface that is reconstructed from evenly spread dots of a given density.

    Parameters
    ----------
    density : float
        Kept dots per Å^2; more than 0 and at most 100.
    hydrogens : bool
        Whether the molecule has explicit hydrogens (default False).

    Returns
    -------
    mean : float
        Mean distance of the reconstructed surface from the true one, Å.
    high_99 : float
        Distance within which 99 % of the reconstructed surface lies, Å; 5.2 times the mean.

    Raises
    ------
    InputError
        The density is not above 0 and at most 100.

    Notes
    -----
    This is the inverse of `density_for`, with the same law.

    Examples
    --------
    >>> import sparsurf
    >>> mean, high_99 = sparsurf.error_at(0.625)
    >>> round(mean, 3), round(high_99, 2)
    (0.02, 0.1)
    """
    mean = constant(hydrogens) / DENSITY.check(density, "density")
    return mean, HIGH_99_OVER_MEAN * mean
