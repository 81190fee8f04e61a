"""Dots on a screen: a table of them, a picture by matplotlib, and a view to turn where PyVista or py3Dmol is installed."""

import numpy as np

from sparsurf import InputError
from sparsurf.surfaces.components import FIELD
from sparsurf.surfaces.formats.ply import KIND_COLOURS, triangles, viridis

BALL = 0.25  # Å, radius of a dot in py3Dmol


def to_frame(surface, molecule=None, **columns):
    """DataFrame with x, y, z (Å), nx, ny, nz, area (Å^2), kind and fields of every dot.

    Of what `sparsurf.surface` gave for a molecule it has the columns of the command's CSV.

    Parameters
    ----------
    surface : Surface
    molecule : Molecule, optional
        Whose atoms the dots belong to: adds chain, residue, residue_name, atom_name and atom. That of the dots without.
    columns : further columns, (N,) each
    """
    import pandas as pd

    place = dict(zip(("x", "y", "z", "nx", "ny", "nz"), [*surface.points.T, *surface.normals.T], strict=True))
    table = pd.DataFrame(place | {"area": surface.area, "kind": surface.kind})
    if surface.placed:
        table[FIELD] = surface.origin.components(surface)
    table = table.assign(**columns)
    molecule = surface.origin.molecule if molecule is None and surface.origin else molecule
    table = table if molecule is None else table.join(molecule.labels(surface.atom))
    return table.assign(**{name: values for name, values in surface.fields.items() if name not in table})


def plot(surface, values=None, ax=None):
    """Draw the dots with matplotlib, coloured by values (N,) or by kind; returns the Axes.

    Raises
    ------
    InputError : matplotlib is not installed
    """
    try:
        import matplotlib.pyplot as plt
    except ImportError:
        raise InputError("plot() needs matplotlib: run pip install matplotlib.") from None
    if ax is None:
        ax = plt.figure().add_subplot(projection="3d")
    colours = KIND_COLOURS[surface.kind] / 255 if values is None else values
    drawn = ax.scatter(*surface.points.T, c=colours, s=2, linewidths=0, depthshade=values is None)
    if values is not None:
        ax.figure.colorbar(drawn, shrink=0.6)
    ax.set_box_aspect(np.ptp(surface.points, axis=0) + 1e-9)
    ax.set(xlabel="x (Å)", ylabel="y (Å)", zlabel="z (Å)")
    return ax


def show(surface, values=None):
    """A view to turn: the plotter of PyVista, else the view of py3Dmol; colours as of `plot`.

    Raises
    ------
    InputError : neither is installed
    """
    colours = KIND_COLOURS[surface.kind] if values is None else viridis(values)
    try:
        import pyvista
    except ImportError:
        return _in_py3dmol(surface, colours)
    faces = triangles(surface)
    mesh = pyvista.PolyData(surface.points, np.insert(faces, 0, 3, axis=1).ravel())
    plotter = pyvista.Plotter()
    if values is None:
        plotter.add_mesh(mesh, scalars=colours, rgb=True)
    else:
        plotter.add_mesh(mesh, scalars=np.asarray(values, float), cmap="viridis")
    plotter.show()
    return plotter


def _in_py3dmol(surface, colours):
    try:
        import py3Dmol
    except ImportError:
        raise InputError("show() needs PyVista or py3Dmol: run pip install pyvista, or use plot().") from None
    view = py3Dmol.view()
    for (x, y, z), (red, green, blue) in zip(surface.points.tolist(), colours.tolist(), strict=True):
        place = {"x": x, "y": y, "z": z}
        view.addSphere({"center": place, "radius": BALL, "color": f"rgb({red},{green},{blue})"})
    view.zoomTo()
    return view
