"""Fields at points and at vertices: the roughness of the dense surface there, and the fields of the atoms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sparsurf.api.inputs import field_names
from sparsurf.errors import InputError
from sparsurf.patches.index import D_LINK, R_PATCH, build_index
from sparsurf.suggestions import did_you_mean
from sparsurf.surfaces.spacing import refuse_sparse

if TYPE_CHECKING:
    from sparsurf.surfaces.surface import Surface

ROUGHNESS = "roughness"


def check_fields(names: str | Sequence[str], function: str) -> tuple[str, ...]:
    """Return names of fields that points and vertices can have; raise InputError, in the name of a function, for others."""
    from sparsurf.dot_fields.registry import FIELDS  # here: few ask for fields

    chosen, known = field_names(names, "fields"), (ROUGHNESS, *FIELDS)
    for name in chosen:
        if name not in known:
            hint = did_you_mean(name, known) or f"; the fields are {', '.join(known)}."
            raise InputError(f"{function}: there is no field {name!r}{hint}")
    return chosen


def with_fields(
    surface: Surface, names: Sequence[str], dense: Callable[[], Surface], function: str, threads: int
) -> Surface:
    """Return a surface with fields of the molecule that it carries.

    `dense` places the dots whose roughness counts: a point has that of the nearest of them.
    """
    values: dict[str, np.ndarray] = {}
    if not names:
        return surface
    from sparsurf.dot_fields.registry import FIELDS, compute_fields  # here: few ask for fields

    values |= {
        name: FIELDS[name].function(surface) for name in names if name in FIELDS and FIELDS[name].of_dots
    }
    if of_atoms := [name for name in names if name in FIELDS and name not in values]:
        if surface.origin is None or surface.origin.molecule is None:
            raise InputError(
                f"{function}: the field {of_atoms[0]} follows from residues and charges, which are unknown here; give a "
                "structure or a molecule."
            )
        table = compute_fields(of_atoms, surface.origin.molecule.frame(surface.origin.frame), surface.points)
        values |= {str(name): table[name].to_numpy() for name in table}
    if ROUGHNESS in names:
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        from sparsurf.patches.roughness import roughness

        dots = dense()
        refuse_sparse(dots.points, D_LINK, function)
        of_dots = roughness(build_index(dots.points, dots.normals, D_LINK), R_PATCH, threads)
        values[ROUGHNESS] = of_dots[np.asarray(cKDTree(dots.points).query(surface.points)[1])]
    return replace(surface, fields=surface.fields | {name: values[name] for name in names})
