"""Partners of complexes, prepared for their maps."""

from collections.abc import Sequence

import numpy as np

from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.pairs.complexes import carried_labels, superpose_onto
from sparsurf.pairs.interface import interface
from sparsurf.pairs.partners import Partner, partner_of
from sparsurf.surfaces.molecular_surface import surface_for_d_link
from sparsurf.surfaces.radii import radii

SETTINGS = {"method": "analytic", "density": "auto", "probe_radius": 1.4, "reentrant": "exact"}
D_LINK = 0.5  # Å


def ready(molecule: Molecule, name: str) -> Partner:
    """Prepare the surface of a molecule for its maps."""
    surface, _ = surface_for_d_link(molecule, 0, radii(molecule, "dms"), SETTINGS, D_LINK, name)
    return partner_of(surface, molecule, name)


def pair_of(paths: Sequence[str], name: str) -> list[Partner]:
    """Prepare both partners of a bound complex."""
    return [ready(read_molecule(path), f"{name} {side}") for side, path in enumerate(paths, 1)]


def unbound_pair(
    paths: Sequence[str], bound: Sequence[str], name: str
) -> tuple[list[Partner], list[np.ndarray]]:
    """Prepare both partners of an unbound form, superposed onto the bound one, and transfer its interface to them.

    Returns
    -------
    two Partner, two (N,) bool
    """
    references = [read_molecule(path) for path in bound]
    dots = [partner.surface.points for partner in pair_of(bound, name)]
    known = [(a, interface(a, b)) for a, b in (dots, dots[::-1])]
    molecules = [superpose_onto(read_molecule(p), one) for p, one in zip(paths, references, strict=True)]
    pair = [ready(molecule, f"{name} unbound {side}") for side, molecule in enumerate(molecules, 1)]
    return pair, [
        carried_labels(one.surface.points, *labels) for one, labels in zip(pair, known, strict=True)
    ]
