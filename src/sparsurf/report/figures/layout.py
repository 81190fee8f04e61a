"""One style and one wording for all figures, and a layout in millimetres.

Positions are millimetres from the upper left corner of the figure, so that every panel and
every text has a place of its own and no engine moves them afterwards.
"""

import math
import textwrap
from functools import wraps

import numpy as np
from matplotlib import colormaps, colors, patheffects, style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.cm import ScalarMappable
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

COLUMN, PAGE = 89.0, 183.0  # mm, one and two columns of a journal
MM = 1 / 25.4  # inch
LETTER = 1.36  # mm, mean width of the letters of a text
DPI = 300
SVG_DPI = 220  # of the pictures inside an svg, which stay small that way
PACKED = {"compress_level": 4, "compress_type": 0}  # of a png: smaller than by default, and faster
# Okabe and Ito, Color Universal Design (2008), without black; then four of P. Tol's
PALETTE = ["#0072B2", "#E69F00", "#009E73", "#CC79A7", "#56B4E9", "#D55E00", "#F0E442"]
PALETTE += ["#332288", "#882255", "#999933", "#888888"]
SAMPLED, RANDOM, WHOLE = "#D55E00", "#0072B2", "#4D4D4D"  # vermillion and blue of Okabe and Ito; grey
DARK, PALE = PALETTE[0], "#B9D3E6"  # blue, and the same lighter
GREY = "#4D4D4D"
# Samplers: colour, width and marker; the three of the ranking are drawn boldly
LINES = {
    "farthest": ("#0072B2", 1.6, "o"),
    "uniform": ("#000000", 1.6, "s"),
    "paper": ("#D55E00", 1.6, "D"),
    "paper_in_hindsight": ("#E69F00", 0.8, "d"),
    "paper_corrected": ("#CC79A7", 0.8, "^"),
    "roughness": ("#882255", 0.8, "v"),
    "stride": ("#999933", 0.8, "<"),
    "voxel": ("#009E73", 0.8, ">"),
    "poisson": ("#56B4E9", 0.8, "P"),
}
SPARE = ["#332288", "#888888", "#F0E442"]  # of samplers that have no line of their own yet
HALO = [patheffects.withStroke(linewidth=2, foreground="white")]  # of words that a line may cross
STYLE = {
    "figure.dpi": DPI,
    "savefig.dpi": DPI,
    "font.family": "DejaVu Sans",  # comes with matplotlib: the same figure on every machine
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
}


def styled(function):
    """Make a function draw in this style, whatever the user's matplotlibrc says."""

    @wraps(function)
    def with_style(*args, **kwargs):
        with style.context(STYLE, after_reset=True):
            return function(*args, **kwargs)

    return with_style


@styled
def save(figure, path):
    """Write `path`.svg and `path`.png; the same figure gives the same bytes."""
    save_svg(figure, f"{path}.svg")
    figure.savefig(f"{path}.png", metadata={"Software": None}, pil_kwargs=PACKED)


@styled
def save_svg(figure, path):
    """Write `path`; the same figure gives the same bytes."""
    figure.savefig(path, metadata={"Date": None, "Creator": None}, dpi=SVG_DPI)


class Sheet(Figure):
    """Figure of millimetres; positions count from below the line that says whose figure it is."""

    head = 0.0  # mm of that line

    def place(self, x, y):
        """Share of the figure, from its lower left corner, of a place in mm."""
        w, h = self.get_size_inches() / MM
        return x / w, 1 - (y + self.head) / h


def sheet(width, height, name=""):
    """Empty figure of width by height mm, and a line above with the name of what it shows."""
    head = 6.0 if name else 0.0
    figure = Sheet(figsize=(width * MM, (height + head) * MM))
    FigureCanvasAgg(figure)
    if name:
        text(figure, 1, 1.3, name, fontsize=8, fontweight="bold")
        figure.head = head
    return figure


def axes(figure, x, y, width, height):
    """Axes of width by height mm whose upper left corner is at x, y."""
    left, bottom = figure.place(x, y + height)
    right, top = figure.place(x + width, y)
    return figure.add_axes((left, bottom, right - left, top - bottom))


def text(figure, x, y, words, **kwargs):
    """Text whose upper left corner is at x, y (unless `ha`, `va` say otherwise)."""
    return figure.text(*figure.place(x, y), words, **({"va": "top", "ha": "left"} | kwargs))


def letter(figure, x, y, name):
    """Letter of a panel, with its upper left corner at x, y."""
    return text(figure, x, y, name, fontsize=8, fontweight="bold")


def legend(figure, x, y, handles, **kwargs):
    """Legend whose upper left corner is at x, y."""
    place = {"loc": "upper left", "bbox_to_anchor": figure.place(x, y), "borderpad": 0, "borderaxespad": 0}
    return figure.legend(handles=handles, **place, **kwargs)


def pixels(width, height):
    """Rows and columns of a picture that fills width by height mm."""
    return round(height * MM * DPI), round(width * MM * DPI)


def show(ax, picture, camera, scale_bar=True):
    """Put a rendered picture on axes that count Å; the scale bar needs 4 mm below them."""
    left, right, bottom, top = camera.extent
    ax.imshow(picture, extent=camera.extent, aspect="auto")
    ax.set_axis_off()
    ax.set(xlim=(left, right), ylim=(bottom, top))
    if scale_bar:
        length = max([n for n in (1, 2, 5, 10) if n <= 0.4 * (right - left)], default=1)
        ax.plot([left, left + length], [bottom] * 2, "k", linewidth=1.5, solid_capstyle="butt", clip_on=False)
        middle = (left + length / 2, bottom)
        ax.annotate(f"{length} Å", middle, (0, -3), textcoords="offset points", ha="center", va="top")


def scale(low, high):
    """Colours from dark at `low` to bright at `high`, the ends for what lies beyond."""
    return ScalarMappable(colors.Normalize(low, high, clip=True), colormaps["viridis"])


def colours(scale, values):
    """(N, 3) float64, red, green and blue of values on a scale."""
    return scale.to_rgba(np.asarray(values))[:, :3]


def histogram(ax, values, scale, label, mean, bins=50):
    """How often values occur, in the colours of their scale, with a line at the mean under the words `mean`."""
    count, edges = np.histogram(values, bins)
    ax.bar(edges[:-1], count, np.diff(edges), align="edge", color=scale.to_rgba((edges[:-1] + edges[1:]) / 2))
    middle = float(np.mean(values))
    ax.axvline(middle, color="black", linestyle="--")
    ax.text(middle, 1.02, mean, transform=ax.get_xaxis_transform(), ha="center", va="bottom")
    ax.set(xlabel=label, ylabel="number of dots", xlim=(edges[0], edges[-1]))
    ax.yaxis.set_major_locator(MaxNLocator(4, integer=True))


class Tiles:
    """Panels of one kind in one pair of axes, which draws ten times faster than a pair of axes for each.

    Parameters
    ----------
    figure : Sheet
    x, y : float, mm, upper left corner of the first panel
    shape : rows and columns
    size : width and height of a panel, mm
    gap : mm between columns and between rows
    xlim, ylim : of every panel
    """

    def __init__(self, figure, x, y, shape, size, gap, xlim, ylim):
        rows, columns = shape
        self.shape, self.size, self.gap, self.xlim, self.ylim = shape, size, gap, xlim, ylim
        width, height = (n * one + (n - 1) * g for n, one, g in zip((columns, rows), size, gap, strict=True))
        self.ax = axes(figure, x, y, width, height)
        self.width, self.height = (0, width), (height, 0)
        self.ax.set(xlim=self.width, ylim=self.height)
        self.ax.spines[:].set_visible(False)
        self.ax.tick_params(length=0)
        self.ax.set(xticks=[], yticks=[])

    def corner(self, row, column):
        """Upper left corner of a panel, mm."""
        return column * (self.size[0] + self.gap[0]), row * (self.size[1] + self.gap[1])

    def places(self, row, column, x, y):
        """(n, 2) float64, places in the axes of what lies at x, y in a panel."""
        left, top = self.corner(row, column)
        across = (np.asarray(x, float) - self.xlim[0]) / (self.xlim[1] - self.xlim[0])
        up = (np.asarray(y, float) - self.ylim[0]) / (self.ylim[1] - self.ylim[0])
        return np.column_stack([left + self.size[0] * across, top + self.size[1] * (1 - up)])

    def extent(self, row, column):
        """Left, right, bottom and top of a panel, as `imshow` takes them."""
        left, top = self.corner(row, column)
        return left, left + self.size[0], top + self.size[1], top

    def frame(self, box):
        """Lines left and below every panel, or (`box`) all around."""
        (w, h), lines = self.size, []
        for row, column in np.ndindex(self.shape):
            corner = np.array(self.corner(row, column))
            lines.append(
                corner + ([[0, 0], [w, 0], [w, h], [0, h], [0, 0]] if box else [[0, 0], [0, h], [w, h]])
            )
        self.ax.add_collection(LineCollection(lines, colors="black", linewidths=0.5, clip_on=False))

    def ticks(self, x, y):
        """Tick labels below the last row and left of the first column, as many as have room."""
        rows, columns = self.shape
        x, y = thinned(x, label_width(x), self.size[0]), thinned(y, 4.0, self.size[1])
        below = [self.places(rows - 1, k, x, np.full(len(x), self.ylim[0])) for k in range(columns)]
        left = [self.places(k, 0, np.full(len(y), self.xlim[0]), y) for k in range(rows)]
        for place, value in zip(np.concatenate(below), np.tile(x, columns), strict=True):
            self.ax.text(place[0], place[1] + 1.5, f"{value:g}", ha="center", va="top")
        for place, value in zip(np.concatenate(left), np.tile(y, rows), strict=True):
            self.ax.text(place[0] - 0.8, place[1], f"{value:g}", ha="right", va="center")


def label_width(values):
    """Room in mm that the widest of some tick labels needs beside others."""
    return 1.6 * max(len(f"{v:g}") for v in values) + 1.0


def folded(words, room):
    """Words in as many lines as they need where one has `room` mm."""
    return textwrap.fill(words, int(room / LETTER))


def thinned(values, one, room):
    """`values`, or every second, third ... of them where labels of `one` mm each do not fit into `room` mm."""
    return np.asarray(values)[:: max(1, math.ceil((len(values) - 1) * one / room))]


def ticks(axis, values, room):
    """Ticks at `values`, as many as have `room` in mm."""
    shown = thinned(values, label_width(values) if axis.axis_name == "x" else 4.0, room)
    axis.set_ticks(shown, [f"{v:g}" for v in shown])


def apart(values, room, height):
    """Places near ascending `values`, between 0 and `height`, so that each has its `room` to itself."""
    before = np.concatenate([[0], np.cumsum(room)])
    low, high = before[:-1] + room / 2, height - (before[-1] - before[:-1]) + room / 2
    places = np.clip(values, low, np.maximum(low, high))
    for _ in range(300):
        for k in range(1, len(places)):
            lack = (room[k] + room[k - 1]) / 2 - (places[k] - places[k - 1])
            if lack > 0:
                places[k - 1 : k + 1] += -lack / 2, lack / 2
        places = np.clip(places, low, np.maximum(low, high))
    return places


def size_of(figure, words, **style):
    """Width and height of a text in pixels."""
    shown = figure.text(0, 0, words, **style)
    box = shown.get_window_extent(figure.canvas.get_renderer())
    shown.remove()
    return np.array([box.width, box.height])


def free_place(ax, size, middles, busy, taken, margin=6.0):
    """Where a box of `size` covers least: of `middles` the one, and what it covers.

    Parameters
    ----------
    ax : Axes, which the box must not leave
    size : (2,) float64, pixels
    middles : (n, 2) float64, pixels, the best first
    busy : (m, 2) float64, pixels, points to be kept free
    taken : list of (middle, size)
        Boxes to be kept free, which count as all points together.
    margin : float, pixels around the box

    Returns
    -------
    (2,) float64 pixels, and a number: 0 where the place is free, inf where none is inside
    """
    inside, reach = ax.get_window_extent(), np.asarray(size) / 2 + margin
    best, least = None, np.inf
    for middle in np.asarray(middles, float):
        if (middle - reach < inside.min).any() or (middle + reach > inside.max).any():
            continue
        cost = (np.abs(busy - middle) < reach).all(axis=1).sum() if len(busy) else 0
        for other, wide in taken:
            cost += (1 + len(busy)) * (np.abs(other - middle) < reach + wide / 2).all()
        if cost < least:
            best, least = middle, cost
    return best, least
