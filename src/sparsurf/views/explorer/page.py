"""Pack the surface, the residues and the frames of a molecule for the page that links them."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.formats.ply import viridis
from sparsurf.views.explorer.shapes import (
    SHAPE_STEP,
    Shape,
    atoms_to_draw,
    shape_columns,
    sparser,
)
from sparsurf.views.render import along_smallest_axis
from sparsurf.views.viewer import page as viewer
from sparsurf.views.viewer.packing import OCTAHEDRON, in_steps, pack

MAX_EXPLORER_BYTES = 10_000_000  # of a page
MAX_FRAMES = 100  # of a page
SHARED_SCRIPTS = ("unpack.js", "gl.js", "drawing.js")  # of the viewer of dots
OWN_SCRIPTS = ("chain.js", "meshes.js", "explorer.js")
STYLES = ("explorer.css",)
UNKNOWN_NUMBER = -1  # in place of a number that a residue does not have


@dataclass(frozen=True)
class ResidueValues:
    """Numbers of the residues, for each frame of a page or for all frames together.

    Attributes
    ----------
    name, unit : for people; the unit may be empty
    values : (F, R) or (1, R) float, NaN where a residue has none
    digits : decimals with which it is written
    low_is, high_is : meaning of the ends where the surface is coloured by it
    limits : values at the ends of the colours; by default the lowest and the highest
    colours : whether the surface can be coloured by it
    """

    name: str
    unit: str
    values: np.ndarray
    digits: int = 2
    low_is: str = "low"
    high_is: str = "high"
    limits: tuple[float, float] | None = None
    colours: bool = False


@dataclass(frozen=True)
class ShownFrames:
    """The frames of a page: what each is called, and the area of its whole surface, Å²; empty for one frame alone."""

    labels: tuple[str, ...] = ()
    area: tuple[float, ...] = ()


@dataclass(frozen=True)
class DotsBelow:
    """The dots of a surface that is drawn as triangles.

    Attributes
    ----------
    values : of the dots, in whose colours the surface can be shown
    kind : (N,) int, of each dot, -1 where it is not known
    points : (N, 3) Å
    opens : the colours that are shown first, 'corner 0' for those of the first values, or 'kind'
    """

    values: Sequence[viewer.DotValues]
    kind: np.ndarray
    points: np.ndarray
    opens: str = "corner 0"

    def columns(self, corners: np.ndarray, scales: Sequence[dict[str, Any]]) -> dict[str, np.ndarray]:
        """Return the columns of corners (V, 3), which have the values of the nearest dots, for the scale of each."""
        near = np.asarray(cKDTree(self.points).query(corners)[1])
        columns = {
            f"corner {k}": in_steps(values.values[near], scale["low"], scale["high"])
            for k, (values, scale) in enumerate(zip(self.values, scales, strict=True))
        }
        return columns | {"kind": self.kind[near]}


def explorer_style() -> str:
    """Return the style sheet of the explorer, on top of that of the viewer of dots."""
    return viewer.style() + "".join(_own(name) for name in STYLES)


def explorer_script() -> str:
    """Return the JavaScript of the explorer, which reads the packed molecule from the constant `PACKED`."""
    shared = (Path(viewer.__file__).with_name(name).read_text(encoding="utf-8") for name in SHARED_SCRIPTS)
    return "".join([*shared, *map(_own, OWN_SCRIPTS)])


def around_molecule(
    fill: Callable[[str], str],
    molecule: Molecule,
    shapes: Sequence[Shape],
    numbers: Sequence[ResidueValues],
    order: Sequence[int],
    dots: DotsBelow | None = None,
    frames: ShownFrames = ShownFrames(),
    max_bytes: int = MAX_EXPLORER_BYTES,
) -> str:
    """Return the page that `fill` makes around a packed molecule, of at most `max_bytes`.

    `shapes` are those of all frames, and `dots` are those of the only one, whose values colour the surface; else numbers of
    residues do. The list of residues shows the first of the `numbers`, in the `order` of their positions. A mesh that would
    make the page too large is thinned until it fits.
    """
    atoms, trace, farthest = atoms_to_draw(molecule)
    elements, element = np.unique(molecule.element[atoms], return_inverse=True)
    first = np.unique(molecule.residue_index, return_index=True)[1]
    chains = np.unique(molecule.chain[first], return_inverse=True)[1]
    header = {
        "residues": [molecule.residue_label(atom) for atom in first],
        "elements": elements.tolist(),
        "step": SHAPE_STEP,
        "octahedron": OCTAHEDRON,
        "turn": np.round(along_smallest_axis(shapes[0].mesh.vertices.points), 6).ravel().tolist(),
        "stops": viridis(np.linspace(0, 1, viewer.N_COLOUR_STOPS)).tolist(),
        "frames": list(frames.labels),
        "areas": [round(area, 1) for area in frames.area],
        "corners": [viewer.scale_of(values) for values in dots.values] if dots else [],
        "kinds": viewer.named_kinds() if dots and (dots.kind >= 0).any() else [],
        "colour": dots.opens if dots else "",
        "numbers": [_described(values) for values in numbers],
        "order": [int(position) for position in order],
    }
    columns = {"element": element, "residue of atom": molecule.residue_index[atoms], "trace": trace}
    columns |= {"chain": chains, "farthest": farthest}
    columns |= {f"number {k}": _whole(values) for k, values in enumerate(numbers)}
    while True:
        placed = [shape.in_order() for shape in shapes]
        at_corners = dots.columns(placed[0].mesh.vertices.points, header["corners"]) if dots else {}
        of_shapes = shape_columns(placed, molecule.residue_index)
        text = fill(pack(header, columns | at_corners | of_shapes))
        if len(text.encode()) <= max_bytes:
            return text
        shapes = [sparser(shape) for shape in shapes]


def _described(values: ResidueValues) -> dict[str, Any]:
    """Return the name, the ends and the precision of some numbers."""
    finite = values.values[np.isfinite(values.values)]
    low, high = (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)
    dark, bright = values.limits or (low, high)
    return {
        "name": values.name, "unit": values.unit, "digits": values.digits, "low": low, "step": _step(values),
        "low is": values.low_is, "high is": values.high_is, "unknown is": "no value", "dark": dark, "bright": bright,
        "frames": len(values.values), "colours": values.colours,
    }  # fmt: skip


def _step(values: ResidueValues) -> float:
    """Return the precision of numbers on a page: a tenth of their last decimal."""
    return float(10.0 ** -(values.digits + 1))


def _whole(values: ResidueValues) -> np.ndarray:
    """Encode numbers as steps above the lowest one, one frame after another."""
    low = _described(values)["low"]
    finite = np.isfinite(values.values)
    steps = np.rint((np.where(finite, values.values, low) - low) / _step(values)).astype(int)
    return np.where(finite, steps, UNKNOWN_NUMBER).ravel()


def _own(name: str) -> str:
    """Read a file of this folder."""
    return Path(__file__).with_name(name).read_text(encoding="utf-8")
