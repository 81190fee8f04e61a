"""Fields at points and at vertices: the roughness of the dense surface there, and the fields of the atoms."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

import numpy as np

from sparsurf import kinds
from sparsurf.api.inputs import field_names
from sparsurf.errors import InputError
from sparsurf.patches.index import D_LINK, R_PATCH, build_index
from sparsurf.suggestions import did_you_mean
from sparsurf.surfaces.spacing import refuse_sparse

if TYPE_CHECKING:
    from sparsurf.dot_fields.registry import FieldLike
    from sparsurf.surfaces.surface import Surface

ROUGHNESS = "roughness"


def check_fields(
    fields: FieldLike | Sequence[FieldLike], function: str, of_residues: bool = False
) -> tuple[FieldLike, ...]:
    """Return fields that points and vertices can have; raise InputError, in the name of a function, for others.

    In a table `of_residues`, roughness is always a column and not a field.
    """
    chosen = field_names(fields, "fields")
    added = () if of_residues else (ROUGHNESS,)
    for field in chosen:
        if not callable(field) and field not in added and not kinds.has("field", field):
            listed = (*added, *kinds.names("field"))
            if of_residues and ROUGHNESS in did_you_mean(field, (ROUGHNESS, *listed)):
                raise InputError(
                    f"{function}: there is no field {field!r}, and the table always has the column mean_roughness; "
                    f"leave {field!r} out."
                )
            hint = did_you_mean(field, listed) or f"; the fields are {', '.join(listed)}."
            raise InputError(f"{function}: there is no field {field!r}{hint}")
        if callable(field) and kinds.name_of("field", field, "fields") == ROUGHNESS:
            raise InputError(f"{function}: {ROUGHNESS} is a field already; rename your function.")
    return chosen


def with_fields(
    surface: Surface, fields: Sequence[FieldLike], dense: Callable[[], Surface], function: str, threads: int
) -> Surface:
    """Return a surface with fields of the molecule that it carries.

    `dense` places the dots whose roughness counts: a point has that of the nearest of them.
    """
    values: dict[str, np.ndarray] = {}
    if not fields:
        return surface
    from sparsurf.dot_fields.registry import compute_fields, takes_dots  # here: few ask for fields

    names = {
        field if field == ROUGHNESS else kinds.name_of("field", field, "fields"): field for field in fields
    }
    origin = surface.origin
    molecule = None if origin is None or origin.molecule is None else origin.molecule.frame(origin.frame)
    for name, field in names.items():
        if field == ROUGHNESS:
            continue
        if molecule is None and not takes_dots(field):
            raise InputError(
                f"{function}: the field {name} follows from residues and charges, which are unknown here; give a "
                "structure or a molecule."
            )
        values[name] = compute_fields([field], molecule, surface.points, dots=surface)[name].to_numpy()
    if ROUGHNESS in names:
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        from sparsurf.patches.roughness import roughness_of_patches

        dots = dense()
        refuse_sparse(dots.points, D_LINK, function)
        of_dots = roughness_of_patches(build_index(dots.points, dots.normals, D_LINK), R_PATCH, threads)
        values[ROUGHNESS] = of_dots[np.asarray(cKDTree(dots.points).query(surface.points)[1])]
    return replace(surface, fields=surface.fields | {name: values[name] for name in names})
