"""Show a molecule or a surface: make its interactive page, and open it in the browser or a notebook."""

from __future__ import annotations

import logging
import os
import sys
import webbrowser
from numbers import Integral
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf.api.fields import labelled
from sparsurf.api.frame_pages import page_of_frames, ranked_frames
from sparsurf.api.inputs import SurfaceLike, as_molecule, has_atoms, is_subset, opened_source
from sparsurf.api.page_metadata import About, Heard, heard
from sparsurf.api.pages import page_of_surface
from sparsurf.api.plot import (
    View,
    in_notebook,
    picture_html,
    surface_of_result,
    temporary_page,
    values_of_dots,
)
from sparsurf.api.replacing import refuse_replacing
from sparsurf.api.surfaces import as_surface, surface
from sparsurf.api.whole_surface import placed_again
from sparsurf.api.writing import PAGE_ENDINGS, parse_output, write_page
from sparsurf.arguments import ColourLimits, Ranking, public
from sparsurf.errors import InputError
from sparsurf.molecules.formats import title
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.source import Source
from sparsurf.surfaces.formats.colours import check_limits

if TYPE_CHECKING:
    from sparsurf.api.frames import FramesRequest
    from sparsurf.dot_fields.named_fields import FieldLike
    from sparsurf.surfaces.mesh import Mesh

log = logging.getLogger("sparsurf")

MAX_DOTS_IN_NOTEBOOK = 50_000  # A notebook holds a picture of a larger surface.


@public(of_dots=True)
def show(
    source: SurfaceLike | Mesh,
    path: str | Path | None = None,
    *,
    trajectory: str | Path | None = None,
    frame: int | None = None,
    rank: FieldLike | None = None,
    rank_by: Ranking | None = None,
    limits: ColourLimits = None,
    open_browser: bool = True,
) -> View:
    """Show a molecule or a surface as one page, and open it in the browser where there is one.

    The page, one file that needs no network, shows the surface, coloured by roughness or fields, above the cartoon of the
    molecule and its ligands, which 3Dmol.js draws (Rego and Koes, Bioinformatics 31:1322, 2015); which residues touch which chain
    or ligand; the roughness along each chain; the ten roughest residues; and the parts of the structure that were left out. Where
    patches of the dots would be fragmented, it shows the surface that `recover` reconstructs from them, and says so.

    Parameters
    ----------
    source : path, Molecule, atoms of another library, Surface, Subset, Mesh, or the pair (points, normals)
        A path is that of a structure, of dots or of a PLY mesh. Dots without a molecule have no residues and no fields of atoms.
    path : str or Path, optional
        File in .html for the page. By default a temporary file, unless the page is not opened.
    trajectory : path, optional
        Trajectory of the structure `source`. A slider chooses one of at most 100 frames, and curves show numbers over time.
    frame : int, optional
        Position of the one frame or model that is shown, from 0 (default all of a trajectory, and the first of anything else).
    rank, rank_by : as in `frames`, optional
        How the residues of a trajectory are ranked, with the same defaults.
    limits : pair of float, optional
        Values at the ends of the first colours, as in `write`: of the first field, or of the roughness; frames have none.
    open_browser : bool
        Whether the page is opened (default True), but never in a notebook, which shows it, or where there is no display.

    Returns
    -------
    View
        The page as `html`; its method `save` writes it, and a notebook shows it.

    Raises
    ------
    InputError
        One sentence on what is wrong with the file, the frame or the path.

    Examples
    --------
    >>> import sparsurf
    >>> page = sparsurf.show("data/tdp43/topology.pdb", "/tmp/tdp43.html", open_browser=False)
    >>> "The 10 roughest residues" in page.html
    True
    """
    if path is not None:
        parse_output(path, PAGE_ENDINGS)
        refuse_replacing(path, (source, trajectory))
    limits, shows_frames = check_limits(limits), trajectory is not None and frame is None
    request = ranked_frames(rank, rank_by, shows_frames, limits=limits)
    view = View(_page_to_show(source, trajectory, frame, request, limits))
    if path is not None:
        write_page(path, view.html)
    if open_browser and not in_notebook() and has_display():
        open_page(path or temporary_page(view.html))
    return view


def show_in_notebook(result: Any, values: Any, path: str | Path | None, limits: ColourLimits) -> View:
    """Show a result on an interactive page, in the browser if there is no notebook; see `Shown.show`."""
    if isinstance(values, str | Path) and path is None:
        values, path = None, values
    if path is not None:
        parse_output(path, PAGE_ENDINGS)
        refuse_replacing(path, (result,))
    view = View(_page_of_result(result, values, check_limits(limits)))
    if path is not None:
        write_page(path, view.html)
    if not in_notebook() and (path is None or has_display()):
        open_page(path or temporary_page(view.html))
    return view


def notebook_html(result: Any) -> str:
    """Return what a notebook shows of a result: its page, or a picture if it has many dots."""
    if len(surface_of_result(result)) > MAX_DOTS_IN_NOTEBOOK:
        return picture_html(result)
    return View(_page_of_result(result, None))._repr_html_()


def _page_of_result(result: Any, values: Any, limits: ColourLimits = None) -> str:
    """Return the page of a result, which opens with the values of its dots if they are given."""
    dots, about = surface_to_show(result, None, 0)
    n_given = len(about.kept) or len(dots)
    numbers = values_of_dots(n_given, values)
    if numbers is not None and len(about.kept):
        of_kept, numbers = numbers, np.full(len(dots), np.nan)
        numbers[about.kept] = of_kept
    return page_of_surface(dots, about, next(iter(dots.fields), "roughness"), numbers, limits)


def _page_to_show(
    source: Any,
    trajectory: str | Path | None,
    frame: int | None,
    request: FramesRequest,
    limits: ColourLimits,
) -> str:
    """Return the page of what the user gave; `request` is what is requested of frames."""
    source = opened_source(source)
    if trajectory is not None and frame is None and isinstance(source, Source) and has_atoms(source):
        with heard(source) as messages:
            molecule = read_molecule(source, trajectory)
        if molecule.n_frames > 1:
            about = _about(source, messages, trajectory, None)
            return page_of_frames(molecule, about, Path(trajectory).name, request)
    dots, about = surface_to_show(source, trajectory, 0 if frame is None else frame)
    return page_of_surface(dots, about, next(iter(dots.fields), "roughness"), limits=limits)


def surface_to_show(source: Any, trajectory: str | Path | None, frame: int) -> tuple[Any, About]:
    """Return the surface of what the user gave, and what the page says of it."""
    is_path = isinstance(source, Source)
    if trajectory is not None and not (is_path and has_atoms(source)):
        raise InputError("show: a trajectory belongs to the path of a structure; give that as the source.")
    if has_atoms(source):
        with heard(source) as messages:
            molecule = read_molecule(source, trajectory) if is_path else as_molecule(source)
            dots = surface(molecule, frame=frame)
        return dots, _about(source, messages, trajectory, frame) if is_path else About()
    if not isinstance(frame, Integral) or frame != 0:
        raise InputError("show: a frame is that of a molecule; leave it out for dots.")
    if is_subset(source) and (whole := placed_again(source.surface)) is not None:
        return whole, About(kept=source.dots, notes=source.decision)
    with heard(source) as messages:
        dots = as_surface(labelled(source))
    return dots, _about(source, messages, None, 0) if is_path else About()


def _about(source: Source, messages: Heard, trajectory: str | Path | None, frame: int | None) -> About:
    """Return what the page of a file says besides the dots, with the call that makes it."""
    call = [repr(str(source))]
    call += [] if trajectory is None else [f"trajectory={str(trajectory)!r}"]
    call += [f"frame={frame}"] if frame else []
    command = f"sparsurf.show({', '.join(call)})"
    return About(title(source), messages, files=(source, trajectory), command=command)


def has_display() -> bool:
    """Return whether a browser has a screen to open on."""
    return sys.platform == "darwin" or bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))


def open_page(path: str | Path) -> bool:
    """Open a page in the browser; warn, and return False, if there is none."""
    found = webbrowser.open(Path(path).resolve().as_uri())
    if not found:
        log.warning("show: there is no browser; open %s in one", path)
    return found
