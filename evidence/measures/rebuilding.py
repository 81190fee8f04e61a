"""Surfaces by others from dots with normals, by the package pymeshlab; each in its best form on the surface of 1fas.

Sources: APSS, Guennebaud & Gross, ACM Trans. Graph. 26:23, 2007; RIMLS, Öztireli, Guennebaud & Gross, Comput. Graph. Forum
28:493, 2009; screened Poisson, Kazhdan & Hoppe, ACM Trans. Graph. 32:29, 2013; decimation by quadric error, Garland &
Heckbert, SIGGRAPH 1997.
"""

from collections.abc import Callable
from functools import partial
from importlib.util import find_spec

import numpy as np

CELL = 0.3  # Å, of marching cubes: their own error is about .01 Å
MARGIN = 1.1  # of the box of marching cubes
# of the kernels of APSS and RIMLS, in spacings; narrower ones leave holes, wider ones smooth
WIDTHS = 1.25, 1.5
# of screened Poisson; deeper trees give the same, the default weight of 4 a larger error
DEPTH, POINT_WEIGHT = 8, 100.0
POISSON = "screened Poisson"
# (vertices, triangles, number of triangles) -> vertices and triangles of a mesh with fewer of them
Simplifier = Callable[[np.ndarray, np.ndarray, int], tuple[np.ndarray, np.ndarray]]
# (points, normals) -> vertices and triangles of the surface through them
Rebuilder = Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


def installed() -> bool:
    """Return whether pymeshlab is installed; say so if not."""
    there = find_spec("pymeshlab") is not None
    if not there:
        print(
            "pymeshlab is not installed: no mesh, APSS, RIMLS or screened Poisson takes part (pip install pymeshlab)."
        )
    return there


def rebuilders() -> dict[str, Rebuilder]:
    """Return ways to rebuild a surface from dots with normals, by name."""
    ways: dict[str, Rebuilder] = {POISSON: screened_poisson}
    for name in ("APSS", "RIMLS"):
        ways |= {f"{name}, width {width:g}": partial(moving_least_squares, name, width) for width in WIDTHS}
    return ways


def moving_least_squares(
    name: str, width: float, points: np.ndarray, normals: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of the surface of moving least squares 'APSS' or 'RIMLS', by marching cubes of side `CELL`."""
    resolution = int(np.ceil(MARGIN * np.ptp(points, axis=0).max() / CELL))
    return _filtered(
        f"generate_marching_cubes_{name.lower()}", points, normals, filterscale=width, resolution=resolution
    )


def screened_poisson(points: np.ndarray, normals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the triangles of the screened Poisson surface."""
    return _filtered(
        "generate_surface_reconstruction_screened_poisson",
        points,
        normals,
        depth=DEPTH,
        pointweight=POINT_WEIGHT,
        samplespernode=1.0,
        threads=1,
    )


def _filtered(
    name: str, points: np.ndarray, normals: np.ndarray, **settings: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices and triangles that a filter of pymeshlab makes of dots."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertex_matrix=points, v_normals_matrix=normals))
    meshes.apply_filter(name, **settings)
    corners, triangles = meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
    finite = np.isfinite(corners).all(axis=1)  # where moving least squares have no neighbours they are not
    return corners, triangles[finite[triangles].all(axis=1)]


def simplify(vertices: np.ndarray, triangles: np.ndarray, n: int) -> tuple[np.ndarray, np.ndarray]:
    """Decimate a mesh to n triangles by quadric error."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles))
    meshes.meshing_decimation_quadric_edge_collapse(targetfacenum=n)
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()


def remesh(vertices: np.ndarray, triangles: np.ndarray, side: float) -> tuple[np.ndarray, np.ndarray]:
    """Replace the triangles of a mesh by even ones of a side, Å, whose vertices are put back on it."""
    import pymeshlab

    meshes = pymeshlab.MeshSet()
    meshes.add_mesh(pymeshlab.Mesh(vertices, triangles))
    meshes.meshing_isotropic_explicit_remeshing(targetlen=pymeshlab.PureValue(side))
    return meshes.current_mesh().vertex_matrix(), meshes.current_mesh().face_matrix()
