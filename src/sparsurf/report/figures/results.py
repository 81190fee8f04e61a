"""Results that a figure of one conformation may show."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True)
class Results:
    """Input of `draw(results)` of every figure; a figure needs only what it uses.

    Attributes
    ----------
    name : str, protein/conformation
    surface : Surface
    roughness : (N,) float64, R_i
    grid, curves, floors, required_dots : pandas.DataFrame, the tables of these names
    best : dict, as in best.json
    floor : str, the noise floor that defines how many dots are enough
    subsets : list of (title, Surface, colour), for `subsets`
    recovered : (title, Surface, distance), for the last picture of `subsets`
    rough_and_flat : dict, arguments of `rough_and_flat.figure`
    """

    name: str
    surface: Surface
    roughness: Any = None
    grid: Any = None
    curves: Any = None
    floors: Any = None
    required_dots: Any = None
    best: dict[str, Any] = field(default_factory=dict)
    floor: str = "fresh dots"
    subsets: list[tuple[str, Surface, str]] = field(default_factory=list)
    recovered: Any = ()
    rough_and_flat: dict[str, Any] = field(default_factory=dict)
