"""The electrostatic potential at dots: Coulomb's law, screened by the solvent.

phi(x) = GAIN k sum_j q_j exp(-r_j / DEBYE) / (eps(r_j) r_j), in kT/e. The dielectric constant eps rises with the distance
in a sigmoid, as in Mehler & Solmajer (Protein Eng. 4:903, 1991): the molecule screens charges nearby, the water those
farther away. Dots lie on the boundary of the two, so that eps rises at shorter distances than inside a protein. The
constants were fitted to solutions of the Poisson-Boltzmann equation by APBS on four proteins, GAIN on 43.
"""

from __future__ import annotations

import math

import numpy as np

from sparsurf.kernels import njit

COULOMB = 560.4  # kT Å / e^2 at 298 K: e^2 / (4 pi eps_0 k T)
DEBYE = 7.9  # Å, screening length of 0.15 M of a salt of single charges
# eps = EPS_MIN + EPS_RISE / (1 + exp((EPS_MIDPOINT - r) / EPS_WIDTH)); the last two in Å
EPS_MIN, EPS_RISE, EPS_MIDPOINT, EPS_WIDTH = 2.0, 160.0, 3.3, 1.2
GAIN = 5.0  # effect of the molecule's low dielectric: ratio of APBS's potential to that of the sum, mean of 43 proteins
# Å; r^2 becomes r^2 + SOFTENING^2. Dots lie 0.6 Å from hydrogens, which the surface does not include. Without softening,
# these hydrogens dominate the field, and a tenth of the dots reconstructs it with r = 0.957 instead of 0.986. With 1 Å it
# would be 0.995, but the correlation with APBS falls by 0.06.
SOFTENING = 0.6
POTENTIAL_CUTOFF = 40.0  # Å; a charge beyond it adds less than 5e-3 kT/e
TABLE_STEP = 0.02  # Å, of the table of the sum's terms
POINTS_PER_RUN = 64  # from which charges far away are left out together


def potential_of_charges(positions: np.ndarray, charges: np.ndarray, points: np.ndarray) -> np.ndarray:
    """Compute the potential at dots, (N,) kT/e at 298 K and 0.15 M salt, from charges in e; positions are in Å."""
    table = potential_of_unit_charge(np.arange(0, POTENTIAL_CUTOFF + 2 * TABLE_STEP, TABLE_STEP))
    return _sum_terms(
        np.ascontiguousarray(positions, np.float64),
        np.asarray(charges, np.float64),
        np.ascontiguousarray(points, np.float64),
        table,
    )


def potential_of_unit_charge(r: np.ndarray) -> np.ndarray:
    """Compute the potential, kT/e, of one elementary charge at distances `r`, Å."""
    r = np.hypot(r, SOFTENING)
    eps = EPS_MIN + EPS_RISE / (1 + np.exp((EPS_MIDPOINT - r) / EPS_WIDTH))
    return GAIN * COULOMB * np.exp(-r / DEBYE) / (eps * r)


@njit()
def _sum_terms(
    positions: np.ndarray, charges: np.ndarray, points: np.ndarray, table: np.ndarray
) -> np.ndarray:
    """Sum the terms of all charges within CUTOFF of each point, interpolated linearly in a table.

    Dots follow each other along the molecule, so that most charges of a large one are too far from a whole run of points.
    """
    out, near = np.zeros(len(points)), np.empty(len(positions), np.int64)
    low, high = np.empty(3), np.empty(3)
    for first in range(0, len(points), POINTS_PER_RUN):
        last, n_near = min(first + POINTS_PER_RUN, len(points)), 0
        for c in range(3):
            low[c], high[c] = np.inf, -np.inf
            for i in range(first, last):
                low[c], high[c] = min(low[c], points[i, c]), max(high[c], points[i, c])
        for j in range(len(positions)):
            gap2 = 0.0  # from the box around the run
            for c in range(3):
                gap = max(low[c] - positions[j, c], positions[j, c] - high[c], 0.0)
                gap2 += gap * gap
            if gap2 < POTENTIAL_CUTOFF * POTENTIAL_CUTOFF:
                near[n_near] = j
                n_near += 1
        for i in range(first, last):
            total = 0.0
            for n in range(n_near):
                j = near[n]
                x = positions[j, 0] - points[i, 0]
                y = positions[j, 1] - points[i, 1]
                z = positions[j, 2] - points[i, 2]
                r2 = x * x + y * y + z * z
                if r2 < POTENTIAL_CUTOFF * POTENTIAL_CUTOFF:
                    r = math.sqrt(r2) / TABLE_STEP
                    k = int(r)
                    total += charges[j] * (table[k] + (r - k) * (table[k + 1] - table[k]))
            out[i] = total
    return out
