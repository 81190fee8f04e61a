"""Show a surface: as a picture like those of the reports, and as an interactive page in a notebook or the browser."""

from __future__ import annotations

import base64
import io
import logging
import sys
import tempfile
import webbrowser
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.pages import patches_for
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.samplers import farthest
from sparsurf.settings import Settings
from sparsurf.surfaces.formats.ply import KIND_COLOURS, viridis
from sparsurf.surfaces.surface import Surface, real_numbers
from sparsurf.threads import available_cores
from sparsurf.views.viewer.page import MAX_DOTS, DotValues, page

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

log = logging.getLogger("sparsurf")

MAX_DOTS_IN_NOTEBOOK = 50_000  # 0.7 MB; of larger surfaces a notebook holds a picture
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
        """Write the page."""
        Path(path).write_text(self.html, encoding="utf-8")


def plot(surface: Surface, values: ArrayLike | None = None, ax: Any = None) -> Axes:
    """Draw a surface, in Å, as the reports do: lit discs, seen along its smallest axis, with a scale bar; see `Surface.plot`."""
    try:
        import matplotlib.pyplot as plt

        from sparsurf.views import layout, render
    except ImportError:
        raise InputError("plot() needs matplotlib: run pip install matplotlib.") from None
    numbers = _values_of_dots(surface, values)
    ax = plt.figure(layout="constrained").add_subplot() if ax is None else ax
    if ax.name == "3d":
        raise InputError("plot: these axes are 3D, and the picture is flat; give axes without a projection.")
    box = ax.get_window_extent()
    shape = tuple(round(size * layout.DPI / ax.figure.dpi) for size in (box.height, box.width))
    camera = render.aim(surface.points, render.along_smallest_axis(surface.points), shape)
    colours = KIND_COLOURS[surface.kind] if numbers is None else viridis(numbers)
    scene = render.draw_surface(surface.points, surface.normals, colours / 255, camera)
    layout.draw_picture(ax, render.picture(scene), camera)
    ax.set_aspect("equal")
    if numbers is not None and np.isfinite(numbers).any():
        scale = layout.scale(np.nanmin(numbers), np.nanmax(numbers))
        ax.figure.colorbar(scale, ax=ax, shrink=0.6)
    return ax


def show_in_notebook(surface: Surface, values: ArrayLike | None = None) -> View:
    """Show a surface on an interactive page, in the browser if there is no notebook; see `Surface.show`."""
    view = View(_page(surface, _values_of_dots(surface, values)))
    if not in_notebook():
        with tempfile.NamedTemporaryFile("w", suffix=".html", delete=False, encoding="utf-8") as file:
            file.write(view.html)
        if not webbrowser.open(Path(file.name).as_uri()):
            log.warning("show: there is no browser; open %s in one", file.name)
    return view


def notebook_html(surface: Surface) -> str:
    """Return what a notebook shows of a surface: its view, or a picture if it has many dots."""
    if len(surface) <= MAX_DOTS_IN_NOTEBOOK:
        return View(_page(surface, None))._repr_html_()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure, png = Figure(PICTURE_INCHES, PICTURE_DPI, layout="constrained"), io.BytesIO()
    FigureCanvasAgg(figure)
    plot(surface, ax=figure.add_subplot())
    figure.savefig(png, format="png")
    text = base64.b64encode(png.getvalue()).decode("ascii")
    return f'<p>{escape(repr(surface))}</p><img alt="{escape(repr(surface))}" src="data:image/png;base64,{text}">'


def _page(surface: Surface, values: np.ndarray | None) -> str:
    """Return the page of a surface; dots that are far apart are linked by their own spacing."""
    prepared = PreparedSurface(surface, Settings(patches=patches_for(surface)), threads=available_cores())
    order = farthest(prepared, min(len(surface), MAX_DOTS), prepared.stream("view"))
    shown = [] if values is None else [DotValues("values", "value", "", values)]
    shown += [DotValues(name, name, "", numbers) for name, numbers in surface.fields.items()]
    has_kinds = (surface.kind >= 0).any()
    molecule = surface.molecule
    residues = [molecule.residue_label(atom) for atom in range(molecule.n_atoms)] if molecule else []
    return page(
        repr(surface), prepared, {"farthest": order}, residues=residues, values=shown, up="",
        opens=("all", 1 if values is not None else "kind" if has_kinds else 0),
    )  # fmt: skip


def _values_of_dots(surface: Surface, values: ArrayLike | None) -> np.ndarray | None:
    """Return one number for each dot; raise InputError for anything else."""
    if values is None:
        return None
    numbers = real_numbers(values, "values").astype(float)
    if numbers.shape != (len(surface),):
        raise InputError(f"{argument('values')} has the shape {numbers.shape}; the dots are {len(surface)}.")
    return numbers


def in_notebook() -> bool:
    """Return whether a kernel of Jupyter runs this."""
    shell = getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)()
    return shell is not None and hasattr(shell, "kernel")
