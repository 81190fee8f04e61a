"""Compile the numba kernels into their cache, in two parts that take equally long: `python -m sparsurf.compile_kernels patches`.

Each part runs commands on a peptide of three residues in a temporary folder, and calls what only functions of Python reach.
`make setup` and the build of a wheel (`hatch_build.py`) run both parts, so that no command compiles anything afterwards.
"""

import sys
import tempfile
from collections.abc import Sequence
from contextlib import chdir
from pathlib import Path

import numpy as np

from sparsurf import registry
from sparsurf.errors import InputError

BALL_DOTS = 300
# Å; a residue of an extended chain, and the step to the next one
ALANINE = (
    ("N", (0, 0, 0)),
    ("CA", (1.46, 0, 0)),
    ("C", (2, 1.42, 0)),
    ("O", (1.3, 2.43, 0)),
    ("CB", (2, -0.8, 1.2)),
)
SHIFT = np.array([3.33, 1.42, 0])
SURFACES = (
    "surface peptide.pdb --cavities remove --fields potential,mean_curvature,hbond -o dots.csv",
    "surface peptide.pdb --mesh --density 1 -o mesh.ply",
    "areas peptide.pdb -o areas.csv",
    "points peptide.pdb -n 40 -o points.npz",
    "points peptide.pdb -n 2000 --fields roughness,hydropathy -o points.ply",
    "recover points.npz -o dense.npz",
    "recover points.npz --mesh -o mesh.ply",
)
PATCHES = (
    "show peptide.pdb --no-open -o page.html",
    "minimal peptide.pdb -o minimal.csv",
    "residues peptide.pdb --fields hydropathy,potential -o residues.csv",
    "descriptors peptide.pdb --every 50 -o descriptors.npz",
    "descriptors peptide.pdb --every 50 --descriptor rotation_robust -o robust.npz",
)


def compile_surfaces() -> None:
    """Compile the kernels that place dots, draw surfaces and reconstruct them."""
    from sparsurf.api.surface_atoms import surface_atoms
    from sparsurf.patches.index import build_index
    from sparsurf.recovery.errors import curvature
    from sparsurf.recovery.spheres.explanations import completed
    from sparsurf.recovery.spheres.rebuilding import rebuild
    from sparsurf.recovery.spheres.votes import model_of
    from sparsurf.surfaces.crossing_triangles import crossing_triangles
    from sparsurf.surfaces.dot_placement import roll_probe
    from sparsurf.surfaces.exact_distance import distance_of_dots, exact_distance
    from sparsurf.surfaces.grid import pairs_within
    from sparsurf.surfaces.molecular_surface import molecular_surface, roll_spheres
    from sparsurf.surfaces.pieces import pieces_of, shapes_of
    from sparsurf.surfaces.radii import PROBE_RADIUS
    from sparsurf.surfaces.triangulation import molecular_mesh
    from sparsurf.views import render

    run(SURFACES)
    points, normals = ball_of_dots()
    molecular_surface(points[:3], np.full(3, 1.7), reentrant="dms")
    dots = molecular_surface(*helix())
    rebuild(dots.points, dots.normals)
    # the search for atoms that are missing: the dots of so small a molecule miss none, so that half of its atoms are left out
    probes, model = dots.points + PROBE_RADIUS * dots.normals, model_of(dots.points, dots.normals)
    centres, radii = helix()
    completed(probes, dots.normals, centres[::2].copy(), radii[::2].copy(), model)
    curvature(build_index(points, normals))
    # the probe fits into the shell unless the atom at its centre is kept, or cavities are removed
    shell = np.concatenate([np.zeros((1, 3)), 2 * points]), np.full(BALL_DOTS + 1, 1.7)
    for cavities in ("keep", "remove"):
        surface_atoms(shell, cavities=cavities)
    fewer = roll_probe(centres[:12], radii[:12], PROBE_RADIUS, exact=True)
    roll_probe(centres, radii, PROBE_RADIUS, exact=True, before=fewer)  # as for atoms that are inferred later
    rolled = roll_spheres(*helix(), PROBE_RADIUS)
    exact_distance(points, rolled)
    shapes_of(rolled, pieces_of(rolled))
    distance_of_dots(points, normals, rolled)
    mesh = molecular_mesh(centres, radii)
    # turned over, so that all triangles are tilted
    crossing_triangles(mesh.vertices.points, -mesh.vertices.normals, mesh.triangles)
    pairs_within(points, points[:2], 1.0)
    camera = render.aim(points, np.eye(3), (20, 20))  # as for pictures, which need matplotlib
    render.picture(render.draw_surface(points, normals, (0.5, 0.5, 0.5), camera))


def compile_patches() -> None:
    """Compile the kernels of patches, descriptors and samplers."""
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.evaluation.residues import sum_by_group
    from sparsurf.patches.readings import FULL_READING
    from sparsurf.sampling import samplers
    from sparsurf.surfaces.surface import Surface

    sum_by_group(np.ones(2), np.array([1, 0]), 2)  # in an order that few surfaces have
    prepared = PreparedSurface(Surface(*ball_of_dots()))
    tests = prepared.draw_tests(4)
    subsets = list(prepared.pair((0.5, 0.5, 1.0, 1.0), 0))
    prepared.distances(subsets, tests, prepared.describe(tests)[0], FULL_READING)
    # the kernels of cover, which takes dots on atoms, are those of surfaces and of the spheres
    names = [name for name, choice in registry.TABLE["sampler"].items() if choice.applies != registry.ORIGIN]
    for choose in samplers.get_samplers(names, "sampler").values():
        choose(prepared, 20, np.random.default_rng(0))
    run(PATCHES)


def run(commands: Sequence[str]) -> None:
    """Run commands on a peptide in a folder that is removed afterwards; raise InputError for one that fails."""
    from sparsurf.cli.command import main

    with tempfile.TemporaryDirectory() as folder, chdir(folder):
        Path("peptide.pdb").write_text(peptide(), encoding="utf-8")
        for command in commands:
            if main([*command.split(), "--quiet"]):
                raise InputError(f"the kernels of `sparsurf {command}` could not be compiled.")


def peptide() -> str:
    """Return the PDB lines of three alanines in an extended chain."""
    lines: list[str] = []
    for residue in range(3):
        for name, place in ALANINE:
            x, y, z = place + residue * SHIFT
            atom = f"{len(lines) + 1:5d}  {name:<3s} ALA A{residue + 1:4d}"
            lines.append(f"ATOM  {atom}    {x:8.3f}{y:8.3f}{z:8.3f}  1.00  0.00          {name[0]:>2s}\n")
    return "".join(lines)


def ball_of_dots() -> tuple[np.ndarray, np.ndarray]:
    """Return points and outward normals of random dots on a sphere of 2 Å."""
    normals = np.random.default_rng(0).normal(size=(BALL_DOTS, 3))
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    return 2 * normals, normals


def helix() -> tuple[np.ndarray, np.ndarray]:
    """Return centres and radii of atoms whose surface says by its dots that it lies on spheres."""
    turn = np.arange(16)
    return np.column_stack([3 * np.cos(turn), 3 * np.sin(turn), 1.2 * turn]), np.where(turn % 2, 1.9, 1.5)


PARTS = {"surfaces": compile_surfaces, "patches": compile_patches}

if __name__ == "__main__":
    for part in sys.argv[1:] or PARTS:
        PARTS[part]()
