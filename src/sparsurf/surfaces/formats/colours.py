"""From which to which value something is coloured, and by which colours: the same in every file, picture and page."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf.arguments import ColourLimits
from sparsurf.errors import InputError, argument

if TYPE_CHECKING:
    from numpy.typing import ArrayLike

KIND_NAMES = ("contact", "saddle", "concave", "unknown kind")
KIND_COLOURS = np.array([[86, 180, 233], [230, 159, 0], [0, 158, 115], [160, 160, 160]], np.uint8)
VERTEX_GREY = KIND_COLOURS[3]  # where there is no value
VIRIDIS = np.load(Path(__file__).with_name("viridis.npy"))  # (256, 3) uint8, so that matplotlib is not needed
# Of R at the ends of the colours, the same on all surfaces, so that they can be compared
ROUGHNESS_LIMITS = 0.2, 0.9
# Highest value of either sign of fields whose colours meet at 0, and the colours of both ends
RED_AND_BLUE = (178, 24, 43), (33, 102, 172)
AROUND_ZERO = {
    "potential": (5.0, RED_AND_BLUE), "hydropathy": (4.5, ((1, 133, 113), (166, 97, 26))),
    "shape_index": (1.0, RED_AND_BLUE), "hbond": (1.0, RED_AND_BLUE),
}  # fmt: skip
N_COLOURS = 255  # A scale around 0 has an odd number of colours, and the one in the middle is white.
# Bands of the confidence of predictions in the AlphaFold Protein Structure Database, and the values at their ends
PLDDT_BANDS = [
    ("very low (below 50)", (255, 125, 69)), ("low (50 to 70)", (255, 219, 19)),
    ("confident (70 to 90)", (101, 203, 243)), ("very high (above 90)", (0, 83, 214)),
]  # fmt: skip
PLDDT_ENDS = 0, 50, 70, 90, 100


class Scale(NamedTuple):
    """Values, and the colours that they have.

    Attributes
    ----------
    name : of the values
    values : (N,) float, NaN where unknown
    places : values at even steps along the colours, ascending; one alone is that of all dots
    table : (C, 3) uint8, the colours; of bands, one fewer than the places
    is_own : whether no value lies beyond the limits, which are its lowest and its highest one unless there are bands
    """

    name: str
    values: np.ndarray
    places: tuple[float, ...]
    table: np.ndarray = VIRIDIS
    is_own: bool = False

    @property
    def limits(self) -> tuple[float, float]:
        """The values at the ends."""
        return self.places[0], self.places[-1]

    @property
    def bands(self) -> list[tuple[str, Sequence[int]]]:
        """The name and the colour of each band; none where the colours are continuous."""
        return [*PLDDT_BANDS] if len(self.table) < len(self.places) else []

    @property
    def colours(self) -> np.ndarray:
        """The colours (N, 3) uint8 of the values: those of the ends beyond them, grey for NaN and infinity."""
        return self.of(self.values)

    def of(self, values: np.ndarray) -> np.ndarray:
        """Return the colours of other values (N,)."""
        n, has_value = len(self.places), np.isfinite(values)
        steps = np.linspace(0, 1, n) if n > 1 else [0.5]
        share = np.interp(np.where(has_value, values, 0), self.places, steps)
        colours = self.table[np.minimum(share * len(self.table), len(self.table) - 1).astype(int)]
        return np.where(has_value[:, None], colours, VERTEX_GREY)

    def stops(self, n: int = 5) -> list[tuple[float, list[int]]]:
        """Return values with their colours, between which a key interpolates; of viridis `n`."""
        places = np.linspace(*self.limits, n) if len(self.places) == 2 else np.array(self.places)
        colours = self.of(places)
        if self.bands:
            places, colours = np.repeat(places, 2)[1:-1], np.repeat(self.table, 2, axis=0)
        return [*zip(places.tolist(), colours.tolist(), strict=True)]

    @property
    def words(self) -> str:
        """A sentence on the values at the ends."""
        low, high = (f"{value:.4g}" for value in self.limits)
        between = f" from {low} to {high}"
        if self.bands:
            between = " in the bands of AlphaFold DB, with bounds at 50, 70 and 90"
        elif len(self.places) == 1:
            between = f", which is {low} at every dot, so that all have one colour"
        elif self.is_own:
            between += ", its lowest and highest value; `--limits` fixes them"
        else:
            values = self.values[np.isfinite(self.values)]
            if len(values) and (values.max() < self.limits[0] or values.min() > self.limits[1]):
                between += f"; all values, {values.min():.4g} to {values.max():.4g}, lie beyond these limits"
        unknown = (~np.isfinite(self.values)).sum()
        grey = f"; {unknown:,} of {len(self.values):,} dots have no value and are grey" if unknown else ""
        return f"coloured by {self.name}{between}{grey}"

    @property
    def comment(self) -> str:
        """A line for files that have no other room for a key."""
        key = (f"{value:.4g} #{bytes(rgb).hex()}" for value, rgb in self.stops())
        return f"comment {self.name}: {', '.join(key)}"


def scale_of(name: str, values: ArrayLike, limits: ColourLimits = None, is_prediction: bool = False) -> Scale:
    """Return the scale of a field or column: by default that of its name, else from the lowest to the highest value.

    `is_prediction` says that B factors are the confidence of a prediction, of 0 to 100 or 0 to 1.
    """
    values, field = np.asarray(values, float), name.removeprefix("mean_")
    ends = ends_of(values)
    if is_prediction and limits is None and field.startswith("bfactor"):
        unit, table = 1 if ends[1] > 1 else 0.01, np.array([rgb for _, rgb in PLDDT_BANDS], np.uint8)
        return Scale(name, values, tuple(unit * end for end in PLDDT_ENDS), table, True)
    if field in AROUND_ZERO:
        highest, (negative, positive) = AROUND_ZERO[field]
        low, high = limits or (-highest, highest)
        share = np.linspace(-int(low < 0), int(high > 0), N_COLOURS)
        channels = zip(negative, (255, 255, 255), positive, strict=True)
        table = np.rint([np.interp(share, (-1, 0, 1), channel) for channel in channels]).T
        return Scale(name, values, (low, 0, high) if low < 0 < high else (low, high), table.astype(np.uint8))
    limits = limits or (ROUGHNESS_LIMITS if field == "roughness" else None)
    return Scale(name, values, tuple(dict.fromkeys(limits or ends)), is_own=limits is None)


def ends_of(values: np.ndarray) -> tuple[float, float]:
    """Return the lowest and the highest value; 0 and 1 where there is none."""
    finite = values[np.isfinite(values)]
    return (float(finite.min()), float(finite.max())) if len(finite) else (0.0, 1.0)


def check_limits(limits: Any) -> ColourLimits:
    """Return the limits of colours that the user gave, as two numbers or as text with a comma; raise InputError for others."""
    if limits is None:
        return None
    try:
        low, high = map(float, limits.split(",") if isinstance(limits, str) else limits)
    except (TypeError, ValueError):
        low = high = math.nan
    if not 0 < high - low < math.inf:
        raise InputError(
            f"{argument('limits')} is {limits!r}; it must be two numbers, the lower one first, such as -5,5."
        )
    return low, high
