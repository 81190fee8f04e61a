"""Pack what a page draws: the surface of each frame, the molecule, the dots, and the numbers of the residues."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.surfaces.formats.colours import (
    KIND_COLOURS,
    KIND_NAMES,
    PLDDT_BANDS,
    ROUGHNESS_LIMITS,
    ends_of,
    scale_of,
)
from sparsurf.surfaces.grid import nearest_of
from sparsurf.views.render import along_smallest_axis
from sparsurf.views.viewer.packing import OCTAHEDRON, in_steps, pack
from sparsurf.views.viewer.shapes import SHAPE_STEP, DrawnAtoms, Shape, shape_columns

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.surfaces.surface import Surface
    from sparsurf.views.viewer.dots import ShownDots

MAX_BYTES = 6_000_000  # of a page, MAX_LARGE_BYTES of that of a large surface, which stays smooth to turn
MAX_LARGE_BYTES = 4_000_000
MAX_BYTES_IN_REPORT = 1_500_000  # browsers show no page above 1.57 MB in the frame of a report
MAX_FRAMES = 100
SCRIPTS_OF_PAGE = ("unpack.js", "sampling.js", "molecule.js", "colours.js", "law.js", "controls.js")
UNKNOWN_NUMBER = -1  # It stands in place of a number that a residue does not have.
N_COLOUR_STOPS = 16  # Viridis is shown with so many; its brightness is even, so that it reads in grey too.


@dataclass(frozen=True)
class DotValues:
    """Values of every dot, shown as colours."""

    name: str
    symbol: str
    unit: str
    values: np.ndarray  # (N,) float64, NaN where unknown
    low_is: str = ""  # meaning of the ends
    high_is: str = ""
    unknown_is: str = "unknown"  # meaning of NaN, which is grey
    # At the ends of the colours; by default those of `scale_of` the symbol
    limits: tuple[float, float] | None = None


@dataclass(frozen=True)
class ResidueValues:
    """Numbers of the residues, for each frame of a page or for all frames together.

    Attributes
    ----------
    name, unit : for people; the unit may be empty
    values : (F, R) or (1, R) float, NaN where a residue has none
    digits : decimals with which it is written
    low_is, high_is : meaning of the ends where the surface is coloured by it
    column : of a table, which determines the colours
    colours : whether the surface can be coloured by it
    """

    name: str
    unit: str
    values: np.ndarray
    digits: int = 2
    low_is: str = "low"
    high_is: str = "high"
    column: str = ""
    colours: bool = False


@dataclass(frozen=True)
class PageScene:
    """What a page draws and lists.

    Attributes
    ----------
    shapes : surface and atoms of each frame
    atoms : whose residues the page lists; None where dots come without a molecule
    surface, values : the dots whose values colour the surface, and these values; none for several frames
    labels : names of the residues of dots without a molecule, by the number of the atom of each dot
    numbers : of the residues
    dots : that are shown as discs
    contacts : the table of `api.surroundings.contacts_on_page`
    frames, areas : what each frame is called, and the area of its surface, Å^2; empty for one frame alone
    colour : what is shown first: 'value 0', 'kind', or 'number 0'
    order, n_ranked : positions of the residues in the order of their list, which shows the first of the numbers, and how many of
        them are ranked
    orders : which residues that list begins with
    regions : area, Å^2, of each region of a field, its mean there, and the names of its residues, with semicolons between
    is_prediction : whether B factors are the confidence of a prediction
    turn : (3, 3), whose rows point right, up and to the viewer; by default the molecule lies flat
    """

    shapes: Sequence[Shape]
    atoms: DrawnAtoms | None = None
    surface: Surface | None = None
    values: Sequence[DotValues] = ()
    labels: Sequence[str] = ()
    numbers: Sequence[ResidueValues] = ()
    dots: ShownDots | None = None
    contacts: pd.DataFrame | None = None
    frames: Sequence[str] = ()
    areas: Sequence[float] = ()
    colour: str = ""
    order: Sequence[int] = ()
    n_ranked: int = 0
    orders: str = "roughest"
    regions: Sequence[list[Any]] = ()
    is_prediction: bool = False
    turn: np.ndarray | None = None

    def around(self, fill: Callable[[str], str], max_bytes: int = MAX_BYTES) -> str:
        """Return the page that `fill` makes around the scene, of at most `max_bytes`, with a coarser mesh or fewer dots."""
        from sparsurf.views.viewer.dots import MAX_DOTS

        shapes, max_dots = list(self.shapes), MAX_DOTS
        while True:
            text = fill(self._packed([shape.in_order() for shape in shapes], max_dots))
            if (n_bytes := len(text.encode())) <= max_bytes:
                return text
            sparser = [shape.sparser() for shape in shapes]
            if self.dots is not None:
                # a little less than in proportion, so that the next attempt mostly fits
                max_dots = int(0.95 * min(max_dots, len(self.dots.order)) * max_bytes / n_bytes)
            elif all(new is old for new, old in zip(sparser, shapes, strict=True)):
                return text  # nothing is left that could go
            shapes = sparser

    def _packed(self, shapes: Sequence[Shape], max_dots: int) -> str:
        """Pack the scene with at most so many dots."""
        names = list(dict.fromkeys(self.labels))
        entries = {"residues": names, "parts": [], "chains": [], "types": [], "surfaced": len(names)}
        entries, columns = self.atoms.header() if self.atoms else (entries, {})
        corners = shapes[0].corners
        placed = corners if len(corners) else self.surface.points if self.surface else shapes[0].atoms
        turn = along_smallest_axis(placed) if self.turn is None else self.turn
        header: dict[str, Any] = entries | {
            "step": SHAPE_STEP, "octahedron": OCTAHEDRON, "turn": np.round(turn, 6).ravel().tolist(),
            "stops": scale_of("", (0, 1)).stops(N_COLOUR_STOPS), "frames": list(self.frames),
            "areas": [round(area, 1) for area in self.areas], "values": [self._described(values) for values in self.values],
            "kinds": named_kinds() if self.surface is not None and (self.surface.kind >= 0).any() else [],
            "numbers": [_described(numbers) for numbers in self.numbers], "colour": self.colour, "orders": self.orders,
            "order": [int(residue) for residue in self.order], "ranked": self.n_ranked,
            "regions": self.regions,
            "plddt": PLDDT_BANDS if self.is_prediction else [],
        }  # fmt: skip
        header |= self._contacts()
        columns |= {f"number {k}": _whole(numbers) for k, numbers in enumerate(self.numbers)}
        residues = [self._residues(shape.atom_of_corners) for shape in shapes]
        columns |= shape_columns(shapes, residues)
        if self.surface is not None and len(corners):
            near = nearest_of(self.surface.points, corners)[0]
            columns |= self._values(header, near, "corner")
            columns |= {"corner kind": self.surface.kind[near]} if header["kinds"] else {}
        if self.dots is not None:
            dots, header["dots"], of_dots = self.dots.packed(max_dots)
            columns |= of_dots | self._values(header, dots, "value")
            columns["residue"] = self._residues(self.dots.prepared.surface.atom[dots])
        return pack(header, columns)

    def _values(self, header: dict[str, Any], dots: np.ndarray, prefix: str) -> dict[str, np.ndarray]:
        """Return the columns of the values of some dots."""
        columns = {}
        for k, (of_dots, scale) in enumerate(zip(self.values, header["values"], strict=True)):
            values = of_dots.values[dots]
            if scale["boxes"]:  # the middle between whole numbers, which no rounding moves into another band
                unit = scale["stops"][-1][0] / 100
                values = (np.floor(values / unit) + 0.5) * unit
            columns[f"{prefix} {k}"] = in_steps(values, scale["low"], scale["high"])
        return columns

    def _described(self, values: DotValues) -> dict[str, Any]:
        """Return the names, the ends and the colours of some values."""
        low, high = ends_of(values.values)
        scale = scale_of(values.symbol, values.values, values.limits, self.is_prediction)
        return {
            "name": "pLDDT" if scale.bands else values.name, "symbol": values.symbol, "unit": values.unit,
            "low": low, "high": high, "low is": values.low_is, "high is": values.high_is, "unknown is": values.unknown_is,
            "stops": scale.stops(N_COLOUR_STOPS), "boxes": scale.bands,
        }  # fmt: skip

    def _contacts(self) -> dict[str, Any]:
        """Return the names of the partners, and the rows of contacts: residue, partner, buried area, and share of the frames."""
        if self.contacts is None:
            return {"units": [], "touching": []}
        number, partner, mean, occupancy = (
            self.contacts[name].tolist() for name in ("number", "partner", "mean", "occupancy")
        )
        units = list(dict.fromkeys(partner))
        rows = [
            [residue, units.index(name), round(area, 1), round(100 * share)]
            for residue, name, area, share in zip(number, partner, mean, occupancy, strict=True)
        ]
        return {"units": units, "touching": rows}

    def _residues(self, atom: np.ndarray) -> np.ndarray:
        """Return the residue of some atoms, -1 where none is known."""
        if self.atoms is not None:
            of_atom = self.atoms.molecule.residue_index
        else:
            names = {name: k for k, name in enumerate(dict.fromkeys(self.labels))}
            of_atom = np.array([names[name] for name in self.labels], int)
        return np.append(of_atom, -1)[np.where(atom < len(of_atom), atom, -1)]


def named_kinds() -> list[tuple[str, list[int]]]:
    """Return the name and the colour of each kind of dots, and of dots whose kind is not known."""
    return [(name, rgb.tolist()) for name, rgb in zip(KIND_NAMES, KIND_COLOURS, strict=True)]


def _described(values: ResidueValues) -> dict[str, Any]:
    """Return the name, the ends and the precision of some numbers."""
    return {
        "name": values.name, "unit": values.unit, "digits": values.digits,
        "low": ends_of(values.values)[0], "step": _step(values), "low is": values.low_is, "high is": values.high_is,
        "unknown is": "no value",
        "stops": scale_of(values.column, values.values).stops(N_COLOUR_STOPS), "boxes": [],
        "frames": len(values.values), "count": values.values.shape[1], "colours": values.colours,
    }  # fmt: skip


def _step(values: ResidueValues) -> float:
    """Return the precision of numbers on a page: a tenth of their last decimal."""
    return float(10.0 ** -(values.digits + 1))


def _whole(values: ResidueValues) -> np.ndarray:
    """Encode numbers as steps above the lowest one, one frame after another."""
    low = ends_of(values.values)[0]
    finite = np.isfinite(values.values)
    steps = np.rint((np.where(finite, values.values, low) - low) / _step(values)).astype(int)
    return np.where(finite, steps, UNKNOWN_NUMBER).ravel()


def roughness_values(roughness: np.ndarray, name: str = "roughness") -> DotValues:
    """Return the roughness of dots as their values."""
    return DotValues(name, "R_i", "", roughness, "rough", "flat", limits=ROUGHNESS_LIMITS)


@cache
def script_of_page() -> str:
    """Return the JavaScript of a page, which reads the packed scene from the constant `PACKED` and 3Dmol.js from `LIBRARY`."""
    return "".join(Path(__file__).with_name(name).read_text(encoding="utf-8") for name in SCRIPTS_OF_PAGE)
