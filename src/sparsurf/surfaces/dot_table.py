"""The dots of a surface as a table, with the atoms that they belong to."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from sparsurf.errors import InputError

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Surface

COMPONENT_FIELD = "component"  # field of a Surface: component of each dot
# Å, median distance from dots to the centres of their atoms: at most the largest radius and that of a large probe
MAX_DISTANCE_OF_ATOM = 6.0


def to_frame(surface: Surface, molecule: Molecule | None = None, **columns: np.ndarray) -> pd.DataFrame:
    """Tabulate position, normal, area, kind, fields and `columns` of the dots, with labels of the atoms, if known."""
    import pandas as pd

    if molecule is not None:
        _refuse_other_molecule(surface, molecule)

    axes = dict(zip(("x", "y", "z", "nx", "ny", "nz"), [*surface.points.T, *surface.normals.T], strict=True))
    table = pd.DataFrame(axes | {"area": surface.area, "kind": surface.kind})
    if surface.placed:
        table[COMPONENT_FIELD] = surface.placed.components(surface)
    table = table.assign(**columns)
    molecule = surface.molecule if molecule is None else molecule
    table = table if molecule is None else table.join(molecule.labels(surface.atom))
    return table.assign(**{name: values for name, values in surface.fields.items() if name not in table})


def _refuse_other_molecule(surface: Surface, molecule: Molecule) -> None:
    """Raise InputError if the atoms of the dots are not those of a molecule."""
    atom = surface.atom
    if not (hasattr(molecule, "labels") and hasattr(molecule, "n_atoms")):
        raise InputError("to_frame: the molecule must come from read_molecule; give one, or leave it out.")
    if atom.min() < 0:
        raise InputError("to_frame: the atoms of the dots are unknown; leave out the molecule.")
    far = atom.max() >= molecule.n_atoms or not any(
        np.median(np.linalg.norm(surface.points - xyz[atom], axis=1)) < MAX_DISTANCE_OF_ATOM
        for xyz in molecule.xyz
    )
    described = surface.molecule or molecule
    alike = described.n_atoms == molecule.n_atoms and np.array_equal(
        described.residue_name, molecule.residue_name
    )
    if far or not alike:
        raise InputError("to_frame: the dots were placed on other atoms; give their molecule, or none.")
