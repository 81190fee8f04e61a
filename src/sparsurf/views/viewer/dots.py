"""The dots of a page: those of a subset, and of samplers that the page runs, with what a study says about them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd

from sparsurf import registry
from sparsurf.patches.readings import words_of
from sparsurf.recovery.readings import readings_of_columns
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.sampling.samplers import sampler_label
from sparsurf.surfaces.spacing import spacing
from sparsurf.views.viewer.packing import flat_normals

if TYPE_CHECKING:
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.sampling.published import Cover
    from sparsurf.surfaces.surface import Surface

MAX_DOTS = 100_000
COORDINATE_STEP = 0.001  # Å, the precision of a DMS file
CENTRE_STEPS = 1e7  # The R_i of a centre, on which p depends, is stored in so many steps.
# The columns that `cover_columns` returns.
COVER_COLUMNS = ("ox", "oy", "oz", "centre", "centreR", "size", "pair")


@dataclass(frozen=True)
class ShownDots:
    """The dots that a page shows as discs.

    Attributes
    ----------
    prepared : the surface that they are a part of, and its patches
    order : (M,) int, its dots in the order of farthest-point sampling, of which a page holds the first ones
    minimal, minimal_is : the dots of a subset, and its name
    opens : the sampler that is shown first; by default the subset, or all dots
    samples : whether the page runs samplers
    grid, best : rows of a grid.csv and the content of a best.json
    """

    prepared: PreparedSurface
    order: np.ndarray
    minimal: Sequence[int] | np.ndarray = ()
    minimal_is: str = "the subset minimal.csv"
    opens: str = ""
    samples: bool = False
    grid: pd.DataFrame | None = None
    best: dict[str, Any] = field(default_factory=dict)

    def packed(self, max_dots: int) -> tuple[np.ndarray, dict[str, Any], dict[str, np.ndarray]]:
        """Return the dots of a page of at most `max_dots`, and their entries of its header and columns, without their values."""
        surface, rough = self.prepared.surface, np.isfinite(self.prepared.roughness).any()
        dots = np.sort(self.order[:max_dots])
        columns = columns_of_dots(surface, dots) | dict.fromkeys(COVER_COLUMNS, np.empty(0, int))
        samplers = {"minimal": self.minimal_is} if len(self.minimal) else {}
        if len(self.minimal):
            columns["minimal"] = np.isin(dots, self.minimal).astype(int)
        if self.samples:
            samplers |= {"farthest": sampler_label("farthest")}
            # from the most even subsets to the paper's, which is the last of the list since its parameters stand below it
            in_browser = [
                name for name, choice in reversed(registry.TABLE["sampler"].items()) if choice.in_browser
            ]
            samplers |= {name: sampler_label(name) for name in in_browser}
            place = places_of(dots, len(surface))[self.order]
            columns["rank farthest"] = np.empty(len(dots), int)
            columns["rank farthest"][place[place >= 0]] = np.arange(len(dots))
            if rough:
                columns |= cover_columns(surface, dots, self.prepared.cover)
            else:  # the paper's sampling needs the roughness
                for name in registry.samplers_of_combinations():
                    samplers.pop(name, None)
        if self.samples or not len(self.minimal):
            samplers["all"] = "all dots"
        samplers["none"] = "none"
        grid = pd.DataFrame(columns=[*PARAMETERS, "n_S_percent"]) if self.grid is None else self.grid
        readings = readings_of_columns(grid, "d_")
        names = [*PARAMETERS, "n_S_percent"]
        names += [f"{name}_{reading}" for reading in readings for name in ("Z_tS", "Z_tR", "d")]
        numbers = grid[names].to_numpy(float)
        header = {
            "step": COORDINATE_STEP, "total": len(surface), "stored": len(dots), "minimal": len(self.minimal),
            "radius": self.prepared.patches.r_patch, "spacing": spacing(surface.points[dots]) if len(dots) > 1 else 1.0,
            "samplers": samplers, "sampler": self.opens or next(iter(samplers)),
            "readings": [words_of(reading) for reading in readings],
            "grid": [[float(f"{x:.5g}") if np.isfinite(x) else None for x in row] for row in numbers],
            "presets": presets(self.best),
        }  # fmt: skip
        return dots, header, columns


def presets(best: dict[str, Any]) -> list[tuple[str, list[float]]]:
    """List named combinations to start from."""
    found = [("the paper's best", [1.0, 0.0, 6.0, 0.0])]
    for reading in readings_of_columns(best):
        names = {"unrestricted": "best", "under_max_n_S": f"best of at most {best['max_n_S_percent']:g} %"}
        for key, name in names.items():
            if "d" in (winner := best[reading][key]):
                found.append((f"{name}, {words_of(reading)}", list(Combination.from_row(winner))))
    return found


def columns_of_dots(surface: Surface, dots: np.ndarray) -> dict[str, np.ndarray]:
    """Return the positions, normals and numbers of dots, and their kinds if these are known."""
    points = np.round(surface.points[dots] / COORDINATE_STEP).astype(int)
    columns = dict(zip("xyz", points.T, strict=True)) | {"index": dots}
    columns |= dict(zip("uv", flat_normals(surface.normals[dots]).T, strict=True))
    return columns | ({"kind": surface.kind[dots]} if (surface.kind >= 0).any() else {})


def cover_columns(surface: Surface, dots: np.ndarray, cover: Cover) -> dict[str, np.ndarray]:
    """Return columns of the cover, by centre: place among the shown dots or -1, R_i, origin, pairs; and the dot of each pair."""
    position = places_of(dots, len(surface))
    owner = np.repeat(np.arange(len(cover.centre)), np.diff(cover.start))
    shown = position[cover.dot] >= 0
    owner, dot = owner[shown], position[cover.dot[shown]]
    origin = np.round(surface.points[cover.origin] / COORDINATE_STEP).astype(int)
    return dict(zip(("ox", "oy", "oz"), origin.T, strict=True)) | {
        "centre": position[cover.centre],
        "centreR": np.round(cover.roughness * CENTRE_STEPS).astype(int),
        "size": np.bincount(owner, minlength=len(cover.centre)),
        "pair": dot[np.lexsort((dot, owner))],
    }


def places_of(dots: np.ndarray, n: int) -> np.ndarray:
    """Return the index of each of n dots among those shown, -1 if it is not."""
    position = np.full(n, -1)
    position[dots] = np.arange(len(dots))
    return position
