"""A few points of a surface in float32 that carry their atoms, labels and fields."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from sparsurf.display import Shown
from sparsurf.surfaces.surface import Surface

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.molecules.molecule import Molecule


# of the positions that are compared: farther apart than rounding, far closer than dots
STEPS_PER_ANGSTROM = 2**16


def on_steps(points: np.ndarray) -> np.ndarray:
    """Round positions, Å, so that those that differ by rounding alone, on another machine, are equally near to others."""
    return np.rint(points * STEPS_PER_ANGSTROM) / STEPS_PER_ANGSTROM


class Points(Shown, tuple):
    """Points with normals on the surface of a molecule: the pair (points, normals), with all that is known of them.

    As a pair it unpacks: ``points, normals = sparsurf.points(...)``. So its length is 2, and `n_dots` is the number of
    points: loops, `zip` and loaders of batches rely on a length that is the number of items. Functions that take dots take it
    too, such as `fields`, `residues`, `recover` and `write`.

    Attributes
    ----------
    points : (n, 3) float32, Å, in the order of choice
    normals : (n, 3) float32, unit vectors, outward
    area : (n,) float32, Å^2, the area of the surface that is nearer to this point than to the others; the sum is that of
        the surface
    kind : (n,) int8, 0 contact, 1 saddle, 2 concave
    atom : (n,) int32, index of the atom that each point belongs to
    fields : dict, name -> (n,) float32, the fields that were requested
    surface : Surface, the same as float64
    molecule : Molecule, or None for spheres
    """

    surface: Surface

    def __new__(cls, surface: Surface, *head: str) -> Points:
        """Make points of a Surface whose positions are those of float32; `head` comes before the pair."""
        pair = (surface.points.astype(np.float32), surface.normals.astype(np.float32))
        made = super().__new__(cls, (*head, *pair))
        made.surface = surface
        return made

    def __getnewargs__(self) -> tuple[Surface, ...]:
        return (self.surface,)

    def __repr__(self) -> str:
        return f"Points: {len(self.surface):,} with normals"

    @property
    def points(self) -> NDArray[np.float32]:
        """Positions, (n, 3) float32, Å."""
        return self[-2]

    @property
    def normals(self) -> NDArray[np.float32]:
        """Outward unit normals, (n, 3) float32."""
        return self[-1]

    @property
    def n_dots(self) -> int:
        """Number of points; the length of the pair is 2."""
        return len(self.surface)

    @property
    def area(self) -> NDArray[np.float32]:
        """Area that each point stands for, (n,) float32, Å^2."""
        return self.surface.area.astype(np.float32)

    @property
    def kind(self) -> np.ndarray:
        """Kind of each point, (n,) int8: 0 contact, 1 saddle, 2 concave."""
        return self.surface.kind

    @property
    def atom(self) -> np.ndarray:
        """Index of the atom that each point belongs to, (n,) int32."""
        return self.surface.atom

    @property
    def fields(self) -> dict[str, np.ndarray]:
        """Fields by name, (n,) float32 each."""
        return {name: values.astype(np.float32) for name, values in self.surface.fields.items()}

    @property
    def molecule(self) -> Molecule | None:
        """The molecule that the points lie on; None for spheres."""
        return self.surface.molecule

    def to_frame(self) -> pd.DataFrame:
        """Tabulate the points, one row each.

        Returns
        -------
        DataFrame
            x, y, z, nx, ny, nz, area (float32), kind, chain, residue, residue_name, atom_name, atom, and the fields
            (float32). Spheres have no labels but `atom`.
        """
        import pandas as pd  # here: it takes long to load

        return pd.DataFrame(self.columns())

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of `to_frame` by name."""
        table = {name: np.asarray(values) for name, values in self.surface.columns().items()}
        if "atom" not in table:
            following = [*table][[*table].index("kind") + 1 :]
            table["atom"] = self.surface.atom
            table |= {name: table.pop(name) for name in following}
        table = {
            name: column.astype(np.float32) if column.dtype.kind == "f" else column
            for name, column in table.items()
        }
        return table | {"atom": table["atom"].astype(np.int32)}


class NamedPoints(Points):
    """Points of one structure of a folder: the triple (name, points, normals), with the attributes of `Points`."""

    @classmethod
    def of_points(cls, name: str, points: Points) -> NamedPoints:
        """Put the name of a structure before its points."""
        return cls(points.surface, name)

    def __getnewargs__(self) -> tuple[Surface, str]:  # type: ignore[override]
        return self.surface, self.name

    @property
    def name(self) -> str:
        """Name of the structure, as `points_of` says."""
        return self[0]
