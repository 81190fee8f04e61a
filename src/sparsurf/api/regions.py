"""Regions of a surface: connected dots at which a field lies past a threshold."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.fields import columns_of_fields, labelled
from sparsurf.api.inputs import SurfaceLike, as_dots, has_atoms
from sparsurf.api.surfaces import surface as surface_of
from sparsurf.arguments import public
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.residues import mean_by_group, sum_by_group
from sparsurf.molecules.unwrapping import pieces
from sparsurf.patches.index import D_LINK
from sparsurf.surfaces.grid import pairs_within
from sparsurf.surfaces.spacing import refuse_sparse

if TYPE_CHECKING:
    from pathlib import Path

    import pandas as pd

    from sparsurf.dot_fields.named_fields import FieldLike
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.surface import Surface


@public(of_dots=True)
def regions(
    dots: SurfaceLike | Mesh,
    field: FieldLike,
    *,
    above: float | None = None,
    below: float | None = None,
    min_area: float = 20.0,
    table: str | Path | None = None,
    smooth: float | None = None,
    charges: str | Path = "table",
) -> pd.DataFrame:
    """List the regions of a surface in which a field is above or below a threshold, such as its hydrophobic patches.

    A region is a connected set of dots past the threshold, in which two dots are linked when closer than the d_link that the dots
    were placed for (0.5 Å by default). Two states are compared by two calls with the same threshold. With the field 'enclosure',
    regions are enclosed surface; they are not ranked as binding sites.

    Parameters
    ----------
    dots : Surface, Mesh, path, pair (points, normals), or molecule
        All dots of a surface, or a molecule, whose dots are placed with the defaults and without the walls of closed cavities.
        Dots have the cavities that they were placed with.
    field : str or callable
        A field that the dots have, or any that `fields` accepts, such as 'hydropathy'.
    above, below : float
        The threshold, one of both, in the unit of the field. A dot is past it if its value is higher, or lower; a dot without a
        value never is.
    min_area : float
        Area of the smallest region that is listed, Å^2 (default 20).
    table, smooth, charges : as in `fields`, optional
        Values of atoms, how widely they are averaged, and the charges of the potential, of a field that is computed here.

    Returns
    -------
    DataFrame, one row per region, the largest first
        region (from 1), area (Å^2), dots (their number), mean and peak (the highest value, or the lowest one `below`), residues
        (their labels; blank where they are not known), and x, y, z of its centre (Å), the mean of its dots. There are no rows if
        all regions are smaller than `min_area`.

    Raises
    ------
    InputError
        No dot is past the threshold, the dots lack the field or their areas, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.regions("data/tdp43/topology.pdb", "hydropathy", above=1)
    >>> list(table)
    ['region', 'area', 'dots', 'mean', 'peak', 'residues', 'x', 'y', 'z']
    >>> bool((table["peak"] > 1).all())
    True
    """
    import pandas as pd  # here: it takes long to load

    return pd.DataFrame(columns_of_regions(dots, field, above, below, min_area, table, smooth, charges))


def columns_of_regions(
    dots: SurfaceLike | Mesh,
    field: FieldLike,
    above: float | None = None,
    below: float | None = None,
    min_area: float = 20.0,
    table: str | Path | None = None,
    smooth: float | None = None,
    charges: str | Path = "table",
) -> dict[str, np.ndarray]:
    """Return the columns of `regions` by name."""
    if (above is None) == (below is None):
        raise InputError(f"regions: give a threshold, either {argument('above')} or {argument('below')}.")
    limit: Any = above if below is None else below
    is_past, peak, end = (np.greater, np.fmax, "highest") if below is None else (np.less, np.fmin, "lowest")
    surface = surface_of(dots, cavities="remove") if has_atoms(dots) else as_dots(labelled(dots))
    surface = _with_field(surface, field, table, smooth, charges)
    (values,) = surface.fields.values()
    past = is_past(values, limit)
    if not past.any():
        raise InputError(f"No dot is past {limit:g}; the {end} is {peak.reduce(values):.4g}.")
    d_link, molecule = surface.origin.d_link if surface.origin else D_LINK, surface.molecule
    refuse_sparse(surface.points, d_link, "regions", "give all dots of a surface")
    few, values = surface.take(past), values[past]
    if np.isnan(few.area).any():
        raise InputError("regions: these dots have no areas; add a column area, or give the structure.")
    links = np.column_stack(pairs_within(few.points, few.points, d_link))
    group = pieces(links, len(few))
    n = int(group.max()) + 1
    area, extreme = sum_by_group(few.area, group, n), np.full(n, np.nan)
    peak.at(extreme, group, values)
    means = {axis: mean_by_group(few.points[:, k], group, n) for k, axis in enumerate("xyz")}
    order = np.argsort(-area, kind="stable")
    order = order[area[order] >= min_area]
    columns = {"area": area, "dots": np.bincount(group), "mean": mean_by_group(values, group, n)}
    columns |= {"peak": extreme, "residues": _residues_of_groups(molecule, few.atom, group, n)} | means
    return {"region": np.arange(1, len(order) + 1)} | {
        name: column[order] for name, column in columns.items()
    }


def _residues_of_groups(molecule: Molecule | None, atom: np.ndarray, group: np.ndarray, n: int) -> np.ndarray:
    """Return the labels of the residues of the dots of each of n groups, (n,) str."""
    labels: list[dict[str, None]] = [{} for _ in range(n)]
    if molecule is not None:
        for k, of_dot in np.unique(np.column_stack([group, atom]), axis=0).tolist():
            labels[k][molecule.residue_label(of_dot)] = None
    return np.array(["; ".join(of_group) for of_group in labels], object)


def _with_field(
    dots: Surface, field: FieldLike, table: str | Path | None, smooth: float | None, charges: str | Path
) -> Surface:
    """Return dots with one field alone, which they have, or which is computed for them."""
    stored = dots.fields if table is smooth is None and charges == "table" else {}
    if (name := str(field)) in stored:
        return replace(dots, fields={name: stored[name]})
    if dots.molecule is None:
        listed = ", ".join(stored) or "none"
        raise InputError(f"regions: these dots carry no molecule, and no field {name!r}; theirs: {listed}.")
    values = columns_of_fields(dots, names=[field], table=table, smooth=smooth, charges=charges)
    return replace(dots, fields=values)
