"""Fields at points and at vertices: the roughness of the dense surface there, and the fields of the atoms."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf import registry
from sparsurf.api.inputs import field_names
from sparsurf.arguments import RANK, did_you_mean
from sparsurf.dot_fields.maps import is_map
from sparsurf.errors import InputError, argument
from sparsurf.patches.index import D_LINK, R_PATCH, build_index
from sparsurf.surfaces.spacing import refuse_sparse

if TYPE_CHECKING:
    from sparsurf.dot_fields.named_fields import FieldLike
    from sparsurf.surfaces.surface import Surface

ROUGHNESS = "roughness"
EXACT_AREAS = ("accessible", "relative", "buried")
# of each residue in each frame, by which residues are ranked without a field
RESIDUE_COLUMNS = ("area", "mean_roughness", "depth", *EXACT_AREAS)
RANKED_QUANTITIES = tuple(name.removeprefix("mean_") for name in RESIDUE_COLUMNS)


def check_fields(
    fields: FieldLike | Sequence[FieldLike], function: str, of_residues: bool = False, has_table: bool = False
) -> tuple[FieldLike, ...]:
    """Return fields that points and vertices can have; raise InputError, in the name of a function, for others.

    In a table `of_residues`, roughness is always a column and not a field. If the user `has_table`, other names are its columns.
    """
    chosen = field_names(fields, "fields")
    added = () if of_residues else (ROUGHNESS,)
    for field in chosen:
        is_known = callable(field) or field in added or is_map(field) or registry.has("field", field)
        if not is_known and not has_table:
            listed = (*added, *registry.names("field"))
            if of_residues and ROUGHNESS in did_you_mean(field, (ROUGHNESS, *listed)):
                raise InputError(
                    f"{function}: there is no field {field!r}, and the table always has the column mean_roughness; "
                    f"leave {field!r} out."
                )
            hint = did_you_mean(field, listed) or f"; the fields are {', '.join(listed)}."
            raise InputError(f"{function}: there is no field {field!r}{hint}")
        if callable(field) and registry.name_of("field", field, "fields") == ROUGHNESS:
            raise InputError(f"{function}: {ROUGHNESS} is a field already; rename your function.")
    return chosen


def refuse_maps(fields: Sequence[FieldLike], function: str) -> None:
    """Raise InputError for a map where a function, called by its name, measures more than one structure or frame."""
    for field in filter(is_map, fields):
        raise InputError(
            f"{function}: {field} is a map, which belongs to one frame of one structure; leave it out."
        )


def check_ranked_fields(
    fields: FieldLike | Sequence[FieldLike], rank: FieldLike | None, function: str, only_areas: bool = False
) -> tuple[tuple[FieldLike, ...], str]:
    """Return the fields of every frame, with the one that ranks residues, and the name of what ranks these.

    Without a `rank`, this is their roughness, or their accessible area where there are no dots. Raise InputError, in the name of
    a function, for what is no field of frames.
    """
    rank = RANK if rank is None else rank
    chosen = check_fields(fields, function, of_residues=True)
    if only_areas:
        rank = EXACT_AREAS[0] if rank == RANK else rank
        if chosen or rank not in EXACT_AREAS:
            wrong = (
                f"{argument('fields')} ask for dots"
                if chosen
                else f"{argument('rank')} is {rank!r}, which needs dots"
            )
            raise InputError(
                f"{wrong}, and {argument('only_areas')} leaves these out: leave out one of both, or rank by "
                f"{', '.join(EXACT_AREAS)}."
            )
    refuse_maps(chosen, function)
    if not isinstance(rank, str) or rank not in RANKED_QUANTITIES:
        if not callable(rank) and not registry.has("field", rank):
            listed = (*RANKED_QUANTITIES, *registry.names("field"))
            hint = did_you_mean(str(rank), listed) or f"; give one of {', '.join(listed)}."
            raise InputError(f"{argument('rank')} is {rank!r}, which is neither a column nor a field{hint}")
        name = registry.name_of("field", rank, "rank")
        given = [registry.name_of("field", field, "fields") for field in chosen]
        chosen = chosen if name in given else (*chosen, *check_fields(rank, function, True))
        rank = name
    for field in chosen:
        registry.load("field", field, "fields")
    return chosen, rank


def with_fields(
    surface: Surface,
    fields: Sequence[FieldLike],
    dense: Callable[[], Surface],
    function: str,
    threads: int,
    values_of_atoms: Mapping[str, Any] = MappingProxyType({}),
) -> Surface:
    """Return a surface with fields of the molecule that it carries.

    `dense` places the dots whose roughness counts: a point has that of the nearest of them. `values_of_atoms` are the arguments
    `table` and `smooth` of `compute_fields`.
    """
    if not fields:
        return surface
    from sparsurf.dot_fields.named_fields import compute_fields, takes_dots  # here: few ask for fields

    values: dict[str, np.ndarray] = {}
    origin = surface.origin
    molecule = None if origin is None or origin.molecule is None else origin.molecule.frame(origin.frame)
    for field in fields:
        if molecule is None and not (field == ROUGHNESS or is_map(field) or takes_dots(field)):
            raise InputError(
                f"{function}: the field {registry.name_of('field', field, 'fields')} follows from residues and charges, which "
                "are unknown here; give a structure or a molecule."
            )
    of_atoms = [field for field in fields if field != ROUGHNESS]
    if of_atoms:
        values = compute_fields(of_atoms, molecule, surface.points, dots=surface, **values_of_atoms)
    if ROUGHNESS in fields:
        from scipy.spatial import cKDTree  # here: it takes a quarter of a second to load

        from sparsurf.patches.roughness import roughness_of_patches

        dots = dense()
        refuse_sparse(dots.points, D_LINK, function)
        of_dots = roughness_of_patches(build_index(dots.points, dots.normals, D_LINK), R_PATCH, threads)
        roughness = of_dots[np.asarray(cKDTree(dots.points).query(surface.points)[1])]
        names = [*values]
        names.insert(list(fields).index(ROUGHNESS), ROUGHNESS)
        values = {name: values.get(name, roughness) for name in names}
    return replace(surface, fields=surface.fields | values)
