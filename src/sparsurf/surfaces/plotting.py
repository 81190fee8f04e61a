"""Show dots: as a table, as a plot by matplotlib, and as an interactive view by PyVista or py3Dmol."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.components import COMPONENT_FIELD
from sparsurf.surfaces.formats.ply import KIND_COLOURS, viridis
from sparsurf.surfaces.triangulation import triangulate

if TYPE_CHECKING:
    import pandas as pd
    from matplotlib.axes import Axes
    from numpy.typing import ArrayLike

    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.surface import Surface

DOT_RADIUS = 0.25  # Å, in py3Dmol
# Å, median distance from dots to the centres of their atoms: at most the largest radius and that of a large probe
MAX_DISTANCE_OF_ATOM = 6.0


def to_frame(surface: Surface, molecule: Molecule | None = None, **columns: np.ndarray) -> pd.DataFrame:
    """Return a table with x, y, z (Å), nx, ny, nz, area (Å^2), kind and fields of every dot.

    For a surface that `sparsurf.surface` generated from a molecule, the columns are those of the command's CSV.

    Parameters
    ----------
    surface : Surface
    molecule : Molecule, optional
        The molecule of the dots. It adds chain, residue, residue_name, atom_name and atom. Without it, the molecule that
        the surface was generated from is used, if there is one.
    columns : further columns, (N,) each

    Returns
    -------
    DataFrame, a row per dot

    Raises
    ------
    InputError
        The dots lie on other atoms than those of the molecule, or their atoms are unknown.
    """
    import pandas as pd

    if molecule is not None:
        _refuse_other_molecule(surface, molecule)

    axes = dict(zip(("x", "y", "z", "nx", "ny", "nz"), [*surface.points.T, *surface.normals.T], strict=True))
    table = pd.DataFrame(axes | {"area": surface.area, "kind": surface.kind})
    if surface.placed:
        table[COMPONENT_FIELD] = surface.placed.components(surface)
    table = table.assign(**columns)
    molecule = surface.origin.molecule if molecule is None and surface.origin else molecule
    table = table if molecule is None else table.join(molecule.labels(surface.atom))
    return table.assign(**{name: values for name, values in surface.fields.items() if name not in table})


def _refuse_other_molecule(surface: Surface, molecule: Molecule) -> None:
    """Raise InputError if the atoms of the dots are not those of a molecule."""
    atom = surface.atom
    if not (hasattr(molecule, "labels") and hasattr(molecule, "n_atoms")):
        raise InputError("to_frame: the molecule is none that read_molecule gave; give one, or leave it out.")
    if atom.min() < 0:
        raise InputError("to_frame: the atoms of the dots are unknown; leave out the molecule.")
    far = atom.max() >= molecule.n_atoms or not any(
        np.median(np.linalg.norm(surface.points - xyz[atom], axis=1)) < MAX_DISTANCE_OF_ATOM
        for xyz in molecule.xyz
    )
    own = surface.origin.molecule if surface.origin else molecule
    alike = own.n_atoms == molecule.n_atoms and np.array_equal(own.residue_name, molecule.residue_name)
    if far or not alike:
        raise InputError("to_frame: the dots were placed on other atoms; give their molecule, or none.")


def plot(surface: Surface, values: ArrayLike | None = None, ax: Any = None) -> Axes:
    """Plot the dots with matplotlib.

    Parameters
    ----------
    surface : Surface
    values : (N,), optional
        Colour of each dot; without it, the kinds of dots have colours.
    ax : matplotlib Axes in 3D, optional

    Returns
    -------
    Axes

    Raises
    ------
    InputError
        matplotlib is not installed.
    """
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise InputError("plot() needs matplotlib: run pip install matplotlib.") from None
    if ax is None:
        ax = plt.figure().add_subplot(projection="3d")
    colours = KIND_COLOURS[surface.kind] / 255 if values is None else values
    dots = ax.scatter(*surface.points.T, c=colours, s=2, linewidths=0, depthshade=values is None)
    if values is not None:
        ax.figure.colorbar(dots, shrink=0.6)
    ax.set_box_aspect(np.ptp(surface.points, axis=0) + 1e-9)
    ax.set(xlabel="x (Å)", ylabel="y (Å)", zlabel="z (Å)")
    return ax


def show(surface: Surface, values: ArrayLike | None = None) -> Any:
    """Open an interactive view with PyVista or, where it is not installed, with py3Dmol.

    Parameters
    ----------
    surface : Surface
    values : (N,), optional
        Colours, as for `plot`.

    Returns
    -------
    pyvista.Plotter, or the view of py3Dmol

    Raises
    ------
    InputError
        Neither is installed.
    """
    colours = KIND_COLOURS[surface.kind] if values is None else viridis(values)
    try:
        import pyvista
    except ImportError:
        return _py3dmol_view(surface, colours)
    faces = triangulate(surface)
    mesh = pyvista.PolyData(surface.points, np.insert(faces, 0, 3, axis=1).ravel())
    plotter = pyvista.Plotter()
    if values is None:
        plotter.add_mesh(mesh, scalars=colours, rgb=True)
    else:
        plotter.add_mesh(mesh, scalars=np.asarray(values, float), cmap="viridis")
    plotter.show()
    return plotter


def _py3dmol_view(surface: Surface, colours: np.ndarray) -> Any:
    """Show each dot as a sphere in py3Dmol."""
    try:
        import py3Dmol
    except ImportError:
        raise InputError("show() needs PyVista or py3Dmol: run pip install pyvista, or use plot().") from None
    view = py3Dmol.view()
    for (x, y, z), (red, green, blue) in zip(surface.points.tolist(), colours.tolist(), strict=True):
        centre = {"x": x, "y": y, "z": z}
        view.addSphere({"center": centre, "radius": DOT_RADIUS, "color": f"rgb({red},{green},{blue})"})
    view.zoomTo()
    return view
