"""The electrostatic potential at dots: Coulomb's law, screened by the solvent.

phi(x) = GAIN k sum_j q_j exp(-r_j / DEBYE) / (eps(r_j) r_j), in kT/e. The dielectric follows the distance in a sigmoid, as
in Mehler & Solmajer (Protein Eng. 4:903, 1991): near a charge the molecule screens, farther away the water. Dots lie on
the boundary of the two, so that eps rises earlier than inside a protein. Its constants were fitted to solutions of the
Poisson-Boltzmann equation by APBS on four proteins, GAIN on 43 (docs/finding_sites.md).
"""

import math

import numpy as np
from numba import njit

COULOMB = 560.4  # kT Å / e^2 at 298 K: e^2 / (4 pi eps_0 k T)
DEBYE = 7.9  # Å, screening length of 0.15 M of a salt of single charges
INSIDE, RISE, MIDDLE, WIDTH = 2.0, 160.0, 3.3, 1.2  # eps = INSIDE + RISE / (1 + exp((MIDDLE - r) / WIDTH)); Å
GAIN = 5.0  # what the body of low dielectric adds: APBS's potential over that of the sum alone, mean of 43 proteins
# Å; r^2 becomes r^2 + SOFT^2. Dots lie .6 Å from hydrogens that the surface knows nothing of; without it, these set the
# whole field, and a tenth of the dots gives it back at r = .957 instead of .986 (with 1 Å at .995, but r with APBS falls
# by .06).
SOFT = 0.6
REACH = 40.0  # Å; beyond, a charge adds less than 5e-3 kT/e
STEP = 0.02  # Å, of the table of the sum's terms


def potential_of_charges(places, charges, points):
    """The potential at dots.

    Parameters
    ----------
    places : (Q, 3) float64, Å
    charges : (Q,) float64, elementary charges
    points : (N, 3) float64, Å

    Returns
    -------
    (N,) float64, kT/e at 298 K and 0.15 M salt
    """
    places, points = (np.ascontiguousarray(each, np.float64) for each in (places, points))
    return _sum(places, np.asarray(charges, np.float64), points, term(np.arange(0, REACH + 2 * STEP, STEP)))


def term(r):
    """Potential of one elementary charge at distances r, Å, in kT/e."""
    r = np.hypot(r, SOFT)
    eps = INSIDE + RISE / (1 + np.exp((MIDDLE - r) / WIDTH))
    return GAIN * COULOMB * np.exp(-r / DEBYE) / (eps * r)


@njit(cache=True, nogil=True, fastmath={"contract", "reassoc", "nsz"})
def _sum(places, charges, points, table):
    """Sum of the terms of all charges within REACH of each point, the terms taken linearly from a table."""
    out = np.zeros(len(points))
    for i in range(len(points)):
        total = 0.0
        for j in range(len(places)):
            x, y, z = places[j, 0] - points[i, 0], places[j, 1] - points[i, 1], places[j, 2] - points[i, 2]
            r2 = x * x + y * y + z * z
            if r2 < REACH * REACH:
                r = math.sqrt(r2) / STEP
                k = int(r)
                total += charges[j] * (table[k] + (r - k) * (table[k + 1] - table[k]))
        out[i] = total
    return out
