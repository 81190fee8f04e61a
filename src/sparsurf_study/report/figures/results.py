"""Results that a figure of one conformation may show."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True)
class Results:
    """Input of `draw(results)` of every figure; a figure needs only what it uses."""

    name: str  # protein/conformation
    surface: Surface
    roughness: Any = None  # (N,) float64, R_i
    grid: Any = None  # grid.csv
    recovered_errors: Any = None  # recovered.csv
    best: dict[str, Any] = field(default_factory=dict)  # as in best.json
    subsets: list[tuple[str, Surface, str]] = field(default_factory=list)  # title, dots and colour
    recovered: Any = ()  # of `subsets.recovered_from`, for its last picture
    rough_and_flat: dict[str, Any] = field(default_factory=dict)  # arguments of `rough_and_flat.figure`
