"""Style and layout of all figures.

New figures use `constrained`, matplotlib's own layout. Figures of rendered pictures, whose size in pixels must be known, use
`sheet`, where positions are millimetres from the upper left corner.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Callable, Sequence
from functools import wraps
from pathlib import Path
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar

import numpy as np
from matplotlib import colors, patheffects, style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.axis import Axis
    from matplotlib.legend import Legend
    from matplotlib.text import Text

    from sparsurf.surfaces.formats.colours import Scale
    from sparsurf.views.render import Camera

COLUMN, COLUMN_AND_A_HALF, PAGE_WIDTH = 89.0, 120.0, 183.0  # mm, of a journal
MM = 1 / 25.4  # inch
LETTER_WIDTH = 1.36  # mm, mean width of a letter
BOLD_LETTER_WIDTH = 1.72  # mm, of a letter of the head
HEAD_LINE = 3.6  # mm, from line to line of the head
DPI = 300  # The resolution of a png, as journals ask, and of the pictures inside an svg.
PACKED: dict[str, Any] = {"compress_level": 4, "compress_type": 0}  # png: smaller and faster
# Okabe and Ito, Color Universal Design (2008), without black; then four of P. Tol's
PALETTE = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442"]
PALETTE += ["#332288", "#882255", "#999933", "#888888"]
SAMPLED, RANDOM, WHOLE = "#D55E00", "#000000", "#4D4D4D"  # vermillion of Okabe and Ito, black, grey
DARK, PALE = PALETTE[0], "#B9D3E6"  # blue, and the same lighter
RECONSTRUCTED_COLOUR = "#08306B"  # dark blue, a surface that was reconstructed
GREY = "#4D4D4D"
SPARE = ["#332288", "#888888", "#F0E442"]  # colours of other samplers
HALO = [patheffects.withStroke(linewidth=2, foreground="white")]  # The edge of words that a line may cross.
STYLE: dict[str, Any] = {
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "font.family": "DejaVu Sans",  # comes with matplotlib, so that figures are the same on every machine
    "font.size": 7,
    "axes.titlesize": 7,
    "axes.labelsize": 7,
    "xtick.labelsize": 7,
    "ytick.labelsize": 7,
    "legend.fontsize": 7,
    "legend.frameon": False,
    "axes.titlepad": 3,
    "axes.labelpad": 2.5,
    "axes.linewidth": 0.5,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "lines.linewidth": 0.8,
    "lines.markersize": 3,
    "patch.linewidth": 0.5,
    "xtick.major.width": 0.5,
    "ytick.major.width": 0.5,
    "xtick.major.size": 2.5,
    "ytick.major.size": 2.5,
    "xtick.major.pad": 2,
    "ytick.major.pad": 2,
    "svg.hashsalt": "sparsurf",
    "svg.fonttype": "none",  # text stays text, to be searched and edited
}


P = ParamSpec("P")
Returned = TypeVar("Returned")


def styled(function: Callable[P, Returned]) -> Callable[P, Returned]:
    """Decorate a function to draw in this style, whatever the user's matplotlibrc says."""

    @wraps(function)
    def with_style(*args: P.args, **kwargs: P.kwargs) -> Returned:
        """Call the function in this style."""
        with style.context(STYLE, after_reset=True):
            return function(*args, **kwargs)

    return with_style


@styled
def save(figure: Figure, path: Path | str) -> None:
    """Write a figure as PNG or SVG, by the suffix of `path`; the same figure gives the same bytes."""
    if Path(path).suffix == ".svg":
        figure.savefig(path, metadata={"Date": None, "Creator": None})
    else:
        figure.savefig(path, metadata={"Software": None}, pil_kwargs=PACKED)


def constrained(width: float, height: float, name: str = "") -> Figure:
    """Return an empty figure of width by height mm in matplotlib's constrained layout, with the name of what it shows."""
    figure = Figure(figsize=(width * MM, height * MM), layout="constrained")
    FigureCanvasAgg(figure)
    if name:
        figure.suptitle(name, x=0.005, ha="left", fontsize=8, fontweight="bold")
    return figure


def headed(name: str, message: str) -> str:
    """Return the name of what a figure shows with its message; either may be empty."""
    return ": ".join(filter(None, (name, message)))


def fix_layout(figure: Figure) -> Figure:
    """Run the constrained layout once and keep its result, so that every later drawing is the same."""
    figure.draw_without_rendering()
    figure.set_layout_engine(
        None
    )  # with "none", which is a layout as well, every saving would draw the figure twice
    return figure


def panel_title(ax: Axes, name: str, title: str) -> None:
    """Write the bold letter of a panel and its title above axes."""
    ax.set_title(rf"$\mathbf{{{name}}}$  {title}", loc="left")


class Sheet(Figure):
    """Figure whose positions are in mm from below its head line."""

    head = 0.0  # mm, height of the line with the name

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Convert a position in mm to fractions of the figure from its lower left corner."""
        w, h = self.get_size_inches() / MM
        return x / w, 1 - (y + self.head) / h


def sheet(width: float, height: float, name: str = "") -> Sheet:
    """Return an empty figure of width by height mm, below the name of what it shows, on as many lines as it needs."""
    lines = textwrap.wrap(name, int((width - 2) / BOLD_LETTER_WIDTH))
    head = 2.4 + HEAD_LINE * len(lines) if name else 0.0
    figure = Sheet(figsize=(width * MM, (height + head) * MM))
    FigureCanvasAgg(figure)
    if name:
        text(figure, 1, 1.3, "\n".join(lines), fontsize=8, fontweight="bold")
        figure.head = head
    return figure


def axes(figure: Sheet, x: float, y: float, width: float, height: float) -> Axes:
    """Add axes of width by height mm with the upper left corner at x, y."""
    left, bottom = figure.place(x, y + height)
    right, top = figure.place(x + width, y)
    return figure.add_axes((left, bottom, right - left, top - bottom))


def text(figure: Sheet, x: float, y: float, content: str, **kwargs: Any) -> Text:
    """Write text with the upper left corner at x, y, unless `ha` or `va` is given."""
    return figure.text(*figure.place(x, y), content, **({"va": "top", "ha": "left"} | kwargs))


def letter(figure: Sheet, x: float, y: float, name: str) -> Text:
    """Write the letter of a panel with the upper left corner at x, y."""
    return text(figure, x, y, name, fontsize=8, fontweight="bold")


def legend(figure: Sheet, x: float, y: float, handles: Sequence[Any], **kwargs: Any) -> Legend:
    """Add a legend with the upper left corner at x, y."""
    corner = figure.place(x, y)
    return figure.legend(
        handles=handles, loc="upper left", bbox_to_anchor=corner, borderpad=0, borderaxespad=0, **kwargs
    )


def pixels(width: float, height: float) -> tuple[int, int]:
    """Return the rows and columns of a picture that fills width by height mm."""
    return round(height * MM * DPI), round(width * MM * DPI)


def draw_picture(ax: Axes, picture: np.ndarray, camera: Camera, scale_bar: bool = True) -> None:
    """Show a rendered picture on axes in Å; the scale bar needs 4 mm below them."""
    left, right, bottom, top = camera.extent
    ax.imshow(picture, extent=camera.extent, aspect="auto")
    ax.set_axis_off()
    ax.set(xlim=(left, right), ylim=(bottom, top))
    if scale_bar:
        length = max([n for n in (1, 2, 5, 10) if n <= 0.4 * (right - left)], default=1)
        ax.plot([left, left + length], [bottom] * 2, "k", linewidth=1.5, solid_capstyle="butt", clip_on=False)
        middle = (left + length / 2, bottom)
        ax.annotate(f"{length} Å", middle, (0, -3), textcoords="offset points", ha="center", va="top")


def scale(low: float, high: float, colour_map: str | colors.Colormap = "viridis") -> ScalarMappable:
    """Return a colour scale from `low` to `high`, clipped beyond."""
    return ScalarMappable(colors.Normalize(low, high, clip=True), colour_map)


def colour_bar(figure: Figure, scale: Scale, label: str, **place: Any) -> None:
    """Draw the key of a scale as a bar, with its label."""
    low, high = scale.limits
    table = scale.of(np.linspace(low, high, 1000)) / 255
    drawn = ScalarMappable(colors.Normalize(low, high), colors.ListedColormap(table))
    ticks = [*scale.places] if scale.bands else None
    bar = figure.colorbar(drawn, extend="neither" if scale.is_own else "both", ticks=ticks, **place)
    bar.set_label(label)


def colours(scale: ScalarMappable, values: np.ndarray) -> np.ndarray:
    """Return red, green and blue of values on a scale, (N, 3) float64."""
    return scale.to_rgba(np.asarray(values))[:, :3]


def histogram(
    ax: Axes, values: np.ndarray, scale: ScalarMappable, label: str, mean: str, bins: int | np.ndarray = 50
) -> None:
    """Draw a histogram, clipped to given bins, in the colours of a scale, with a line at the mean below the words `mean`."""
    edges = np.histogram_bin_edges(values, bins)
    count, _ = np.histogram(np.clip(values, edges[0], edges[-1]), edges)
    ax.bar(edges[:-1], count, np.diff(edges), align="edge", color=scale.to_rgba((edges[:-1] + edges[1:]) / 2))
    middle = float(np.clip(np.mean(values), edges[0], edges[-1]))
    ax.axvline(middle, color="black", linestyle="--")
    ax.text(middle, 1.02, mean, transform=ax.get_xaxis_transform(), ha="center", va="bottom")
    ax.set(xlabel=label, ylabel="number of dots", xlim=(edges[0], edges[-1]))
    ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))


class Tiles:
    """Panels of one kind within single axes, which draws ten times faster than axes for each panel; lengths are in mm."""

    def __init__(
        self,
        figure: Sheet,
        x: float,  # as y, of the upper left corner of the first panel
        y: float,
        shape: tuple[int, int],  # rows and columns
        size: tuple[float, float],  # width and height of a panel
        gap: tuple[float, float],  # between columns and between rows
        xlim: tuple[float, float],
        ylim: tuple[float, float],
    ) -> None:
        rows, columns = shape
        self.shape, self.size, self.gap, self.xlim, self.ylim = shape, size, gap, xlim, ylim
        width, height = (
            n * side + (n - 1) * g for n, side, g in zip((columns, rows), size, gap, strict=True)
        )
        self.ax = axes(figure, x, y, width, height)
        self.width, self.height = (0, width), (height, 0)
        self.ax.set(xlim=self.width, ylim=self.height)
        self.ax.spines[:].set_visible(False)
        self.ax.tick_params(length=0)
        self.ax.set(xticks=[], yticks=[])

    def corner(self, row: int, column: int) -> tuple[float, float]:
        """Return the upper left corner of a panel, mm."""
        return column * (self.size[0] + self.gap[0]), row * (self.size[1] + self.gap[1])

    def places(self, row: int, column: int, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Convert coordinates x, y of a panel to those of the axes, (n, 2) float64."""
        left, top = self.corner(row, column)
        across = (np.asarray(x, float) - self.xlim[0]) / (self.xlim[1] - self.xlim[0])
        up = (np.asarray(y, float) - self.ylim[0]) / (self.ylim[1] - self.ylim[0])
        return np.column_stack([left + self.size[0] * across, top + self.size[1] * (1 - up)])

    def extent(self, row: int, column: int) -> tuple[float, float, float, float]:
        """Return left, right, bottom and top of a panel, as `imshow` takes them."""
        left, top = self.corner(row, column)
        return left, left + self.size[0], top + self.size[1], top

    def frame(self, box: bool) -> None:
        """Draw lines left of and below every panel, or with `box` all around."""
        (w, h), lines = self.size, []
        for row, column in np.ndindex(self.shape):
            corner = np.array(self.corner(row, column))
            lines.append(
                corner + ([[0, 0], [w, 0], [w, h], [0, h], [0, 0]] if box else [[0, 0], [0, h], [w, h]])
            )
        self.ax.add_collection(LineCollection(lines, colors="black", linewidths=0.5, clip_on=False))

    def ticks(self, x: np.ndarray, y: np.ndarray) -> None:
        """Write tick labels below the last row and left of the first column, without overlap."""
        rows, columns = self.shape
        x, y = thinned(x, label_width(x), self.size[0]), thinned(y, 4.0, self.size[1])
        below = [self.places(rows - 1, k, x, np.full(len(x), self.ylim[0])) for k in range(columns)]
        left = [self.places(k, 0, np.full(len(y), self.xlim[0]), y) for k in range(rows)]
        for point, value in zip(np.concatenate(below), np.tile(x, columns), strict=True):
            self.ax.text(point[0], point[1] + 1.8, f"{value:g}", ha="center", va="top")
        for point, value in zip(np.concatenate(left), np.tile(y, rows), strict=True):
            self.ax.text(point[0] - 1.8, point[1], f"{value:g}", ha="right", va="center")


def label_width(values: np.ndarray) -> float:
    """Estimate the width in mm that the widest of some tick labels needs."""
    return 1.6 * max(len(f"{v:g}") for v in values) + 1.0


def folded(sentence: str, room: float) -> str:
    """Wrap words to lines of `room` mm."""
    return textwrap.fill(sentence, int(room / LETTER_WIDTH))


def thinned(values: np.ndarray, label_size: float, room: float) -> np.ndarray:
    """Return every k-th of `values`, so that labels of `one` mm each fit into `room` mm."""
    return np.asarray(values)[:: max(1, math.ceil((len(values) - 1) * label_size / room))]


def ticks(axis: Axis, values: np.ndarray, room: float) -> None:
    """Set ticks at increasing `values` that span `room` mm, without those whose label would touch the one before."""
    label_size = label_width(values) if axis.axis_name == "x" else 4.0  # type: ignore[attr-defined]
    places = room * (np.asarray(values) - values[0]) / (np.ptp(values) or 1)
    shown = [0]
    for k, place in enumerate(places):
        if place - places[shown[-1]] > label_size - 1e-6:
            shown.append(k)
    axis.set_ticks([values[k] for k in shown], [f"{values[k]:g}" for k in shown])
