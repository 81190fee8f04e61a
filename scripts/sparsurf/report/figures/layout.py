"""One style and one wording for all figures, and a layout in millimetres.

Positions are millimetres from the upper left corner of the figure, so that every panel and
every text has a place of its own and no engine moves them afterwards.
"""

import math
import textwrap
from functools import wraps

from matplotlib import style
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

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


def sheet(width, height):
    """Empty figure of width by height mm."""
    figure = Figure(figsize=(width * MM, height * MM))
    FigureCanvasAgg(figure)
    return figure


def axes(figure, x, y, width, height):
    """Axes of width by height mm whose upper left corner is at x, y."""
    w, h = figure.get_size_inches() / MM
    return figure.add_axes((x / w, 1 - (y + height) / h, width / w, height / h))


def text(figure, x, y, words, **kwargs):
    """Text whose upper left corner is at x, y (unless `ha`, `va` say otherwise)."""
    w, h = figure.get_size_inches() / MM
    return figure.text(x / w, 1 - y / h, words, **({"va": "top", "ha": "left"} | kwargs))


def letter(figure, x, y, name):
    """Letter of a panel, with its upper left corner at x, y."""
    return text(figure, x, y, name, fontsize=8, fontweight="bold")


def legend(figure, x, y, handles, **kwargs):
    """Legend whose upper left corner is at x, y."""
    w, h = figure.get_size_inches() / MM
    place = {"loc": "upper left", "bbox_to_anchor": (x / w, 1 - y / h), "borderpad": 0, "borderaxespad": 0}
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


def label_width(values):
    """Room in mm that the widest of some tick labels needs beside others."""
    return 1.6 * max(len(f"{v:g}") for v in values) + 1.0


def folded(words, room):
    """Words in as many lines as they need where one has `room` mm."""
    return textwrap.fill(words, int(room / LETTER))


def ticks(axis, values, room):
    """Ticks at `values`, or at every second, third ... where their labels would not fit into `room` mm."""
    one = label_width(values) if axis.axis_name == "x" else 4.0
    step = max(1, math.ceil((len(values) - 1) * one / room))
    axis.set_ticks(values[::step], [f"{v:g}" for v in values[::step]])
