"""Compile the numba kernels into their cache, in two parts that take equally long: `python -m sparsurf.compile_kernels patches`.

Each part calls every kernel on a tiny surface. The kernels of pairs and of meshes are compiled when they are first called.
numba compiles a kernel again if its file was edited, not if a function or constant of another file was: `remove` removes
the compiled kernels, for `make setup` after an edit.
"""

import sys
from importlib import import_module
from pathlib import Path

import numpy as np
from numba.core.dispatcher import Dispatcher

from sparsurf import kinds

BALL_DOTS = 300


def compile_surfaces() -> None:
    """Compile the kernels that place dots, draw surfaces and recover them."""
    from sparsurf.patches.index import build_index
    from sparsurf.recovery.errors import curvature
    from sparsurf.recovery.recovering import recover
    from sparsurf.surfaces.components import components_of
    from sparsurf.surfaces.molecular_surface import molecular_surface
    from sparsurf.surfaces.spacing import spacing
    from sparsurf.views import render

    xyz, radii = np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7)
    dots = molecular_surface(xyz, radii)
    components_of(dots, xyz, radii)
    spacing(dots.points)
    camera = render.aim(dots.points, np.eye(3), (20, 20))
    render.picture(render.draw_surface(dots.points, dots.normals, (0.5, 0.5, 0.5), camera))
    points, normals = ball()
    recover(points, normals)
    curvature(build_index(points, normals))


def compile_patches() -> None:
    """Compile the kernels of patches, descriptors and samplers."""
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.patches.readings import FULL_READING
    from sparsurf.sampling import samplers
    from sparsurf.surfaces.surface import Surface

    prepared = PreparedSurface(Surface(*ball()))
    tests = prepared.draw_tests(4)
    subsets = list(prepared.pair((0.5, 0.5, 1.0, 1.0), 0))
    prepared.distances(subsets, tests, prepared.describe(tests)[0], FULL_READING)
    for choose in samplers.get_samplers(kinds.TABLE["sampler"], "sampler").values():
        choose(prepared, 20, np.random.default_rng(0))


def remove_kernels() -> None:
    """Remove the compiled kernels of the library, and of the study beside it, wherever numba stores them."""
    library = Path(__file__).parent
    for path in [*library.rglob("*.py"), *library.with_name("sparsurf_study").rglob("*.py")]:
        if "@njit(" in path.read_text(encoding="utf-8"):
            module = import_module(".".join(path.relative_to(library.parent).with_suffix("").parts))
            kernels = (value for value in vars(module).values() if isinstance(value, Dispatcher))
            for folder in {kernel.stats.cache_path for kernel in kernels}:
                for file in Path(folder).glob("*.nb[ic]") if folder else ():
                    file.unlink(missing_ok=True)


def ball() -> tuple[np.ndarray, np.ndarray]:
    """Return points and outward normals of random dots on a sphere of 2 Å."""
    normals = np.random.default_rng(0).normal(size=(BALL_DOTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 2 * normals, normals


PARTS = {"surfaces": compile_surfaces, "patches": compile_patches}

if __name__ == "__main__":
    steps = {"remove": remove_kernels} | PARTS
    for step in sys.argv[1:] or PARTS:
        steps[step]()
