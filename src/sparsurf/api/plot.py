"""Draw a result as a picture like those of the reports, and display it in a notebook."""

from __future__ import annotations

import base64
import io
import sys
import tempfile
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.writing import write_page
from sparsurf.arguments import ColourLimits
from sparsurf.dot_fields.named_fields import label_with_unit
from sparsurf.errors import InputError, argument
from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.formats.colours import KIND_COLOURS, check_limits, scale_of
from sparsurf.surfaces.surface import Surface, real_numbers

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

NOTEBOOK_HEIGHT = 480  # pixels, of the page in a notebook
PICTURE_INCHES, PICTURE_DPI = (6.0, 4.0), 150


@dataclass(frozen=True)
class View:
    """Page of a surface that can be turned, in one file; a notebook shows it.

    Attributes
    ----------
    html : str
    """

    html: str

    def __repr__(self) -> str:
        return f"View of {len(self.html) / 1e6:.1f} MB; save() writes it as a page"

    def _repr_html_(self) -> str:
        """Return what a notebook shows."""
        style = "width:100%;border:1px solid #bbb"
        return f'<iframe srcdoc="{escape(self.html)}" height="{NOTEBOOK_HEIGHT}" style="{style}"></iframe>'

    def save(self, path: str | Path) -> None:
        """Write the page into a file in .html."""
        write_page(path, self.html)


def plot(
    result: Any,
    values: ArrayLike | None = None,
    ax: Any = None,
    name: str = "",
    limits: ColourLimits = None,
) -> Axes:
    """Draw a result, in Å, as the reports do: lit discs, seen along its smallest axis, with a scale bar; see `Shown.plot`."""
    try:
        import matplotlib.pyplot as plt

        from sparsurf.views import layout, render
    except ImportError:
        raise InputError("plot() needs matplotlib: run pip install matplotlib.") from None
    surface = surface_of_result(result)
    numbers, limits = values_of_dots(len(surface), values), check_limits(limits)
    if limits is not None and numbers is None:
        raise InputError("plot: limits are those of values; give values, or leave limits out.")
    ax = plt.figure(layout="constrained").add_subplot() if ax is None else ax
    if ax.name == "3d":
        raise InputError("plot: these axes are 3D, and the picture is flat; give axes without a projection.")
    box = ax.get_window_extent()
    shape = tuple(round(size * layout.DPI / ax.figure.dpi) for size in (box.height, box.width))
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), shape)
    scale = None if numbers is None else scale_of(name, numbers, limits)
    colours = KIND_COLOURS[surface.kind] if scale is None else scale.colours
    scene = render.draw_surface(surface.points, surface.normals, colours / 255, camera)
    layout.draw_picture(ax, render.picture(scene), camera)
    ax.set_aspect("equal")
    if scale is not None and np.isfinite(scale.values).any():
        layout.colour_bar(ax.figure, scale, label_with_unit(name), ax=ax, shrink=0.6)
    return ax


def temporary_page(html: str) -> str:
    """Write a page into a temporary file, which stays for the browser, and return its path."""
    with tempfile.NamedTemporaryFile("w", suffix=".html", delete=False, encoding="utf-8") as file:
        file.write(html)
    return file.name


def surface_of_result(result: Any) -> Surface:
    """Return the dots of a result: those of a Surface, a Subset, points or a mesh, or those that are placed on a molecule."""
    if isinstance(result, Molecule):
        from sparsurf.api.surfaces import surface as place_dots  # here: dots need no molecule

        return place_dots(result)
    if hasattr(result, "is_exact"):  # SurfaceAtoms
        from sparsurf.api.surface_atoms import surface_of_atoms

        return surface_of_atoms(result)
    dots = getattr(result, "vertices", None) or getattr(result, "surface", None)
    return dots if isinstance(dots, Surface) else result


def picture_html(result: Any) -> str:
    """Return the picture of a result, for a notebook."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure, png = Figure(PICTURE_INCHES, PICTURE_DPI, layout="constrained"), io.BytesIO()
    FigureCanvasAgg(figure)
    plot(surface_of_result(result), ax=figure.add_subplot())
    figure.savefig(png, format="png")
    text = base64.b64encode(png.getvalue()).decode("ascii")
    return (
        f'<p>{escape(repr(result))}</p><img alt="{escape(repr(result))}" src="data:image/png;base64,{text}">'
    )


def values_of_dots(n_dots: int, values: ArrayLike | None) -> np.ndarray | None:
    """Return one number for each dot; raise InputError for anything else."""
    if values is None:
        return None
    numbers = real_numbers(values, "values").astype(float)
    if numbers.shape != (n_dots,):
        raise InputError(f"{argument('values')} has the shape {numbers.shape}; the dots are {n_dots}.")
    return numbers


def in_notebook() -> bool:
    """Return whether a kernel of Jupyter runs this."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and hasattr(shell, "kernel")
