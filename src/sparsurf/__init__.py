"""Minimal representations of a molecular surface, after Grassmann et al.

From a molecule to a subset of its surface and its worth, arrays in and arrays out (`help` shows each with examples):

    dots = sparsurf.surface("protein.pdb")         # dots.points, dots.normals: (N, 3), Å
    R = sparsurf.roughness(dots)                   # (N,), 1 is flat
    z = sparsurf.descriptors(dots, [0, 1, 2])      # (3, 121)
    kept = sparsurf.sample(dots, percent=10)       # a tenth of the dots
    sparsurf.compare(dots, kept)                   # Z and d, next to a random subset
    sparsurf.fields(dots)                          # hydropathy and potential at every dot
    sparsurf.areas("protein.pdb").residues         # accessible, excluded and buried areas, exactly
    few = sparsurf.surface_atoms("protein.pdb")    # the atoms that determine the surface exactly
    few = sparsurf.minimal(dots)                   # few dots for a mean error of 0.02 Å
    sparsurf.recover(few)                          # the dense surface from them alone; sparsurf.mesh(few) its triangles

`read_molecule` reads structures and trajectories, `read_surface` dots of other programs, `prepare` saves time where one
surface is sampled and compared many times, and `register` adds a sampler, descriptor, roughness or field of your own. A molecule
is a path, a `Molecule`, or atoms of mdtraj, biotite, MDAnalysis, gemmi, Biopython, ProDy, OpenMM, ParmEd or RDKit. A wrong
input raises `InputError` with one sentence.

Glossary (the paper's symbols and the field's words; lengths in Å everywhere)

dot            one point of the molecular surface, with its outward unit normal
N              number of dots of the full surface
patch          dots within r_patch (roughness, sampling) or r_zernike (descriptors) of a
               dot, cut down to the largest island
island         connected component of a patch, two dots being linked when closer than d_link
centre         dot around which the sampling cuts a patch; always kept
cover          the centres and their patches; every dot lies in at least one
R, R_i         roughness of the patch of dot i: 1 is flat, 0 is rough
n_S            number of dots that a sampling keeps
random subset  dots drawn at random, each with the same chance
accessible     of an area: where the centre of a probe that touches the atom can be
excluded       of an area or a surface: the boundary of the space that the probe cannot enter
surface atoms  the atoms that the probe touches, and inner ones (plugs) that keep it out of the molecule
minimal subset  few dots from which the surface is reconstructed with a mean error of 0.02 Å, or a requested number
combination    one choice of (alpha, beta, gamma, delta)
draw           one random realisation of a combination, or of a random subset
test dot       dot at which the descriptors of two surfaces are compared
z              vector of the 121 Zernike invariants |c_nm| of a patch
Z_tS, Z_tR     mean |z_tot - z_S|, mean |z_tot - z_R| over the test dots
d              Z_tR - Z_tS: positive where the sampling beats the random subset
reading        how 'the points not connected are removed' is understood:
               'kept' among the kept dots, 'full' on the full surface, 'recovered' on
               the surface that is reconstructed from the kept dots
range          one of ten equal intervals of n_S
partners       the two surfaces of a pair; complementarity compares the first's patches 'up' with the second's 'down'
propensity     distance of a dot's patch to the nearest patch of the partner: low is likely interface
similarity     the same with both 'up'
interface      dots within 3 Å of the partner's surface
baseline       a simple property of a dot, with whose AUC the propensity's is compared
field          a number at every dot that follows from the atoms, such as hydropathy
noise floor    Z of other dots of the same surface
conformation   one frame, structure or surface that enters the study
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

from sparsurf import display, progress
from sparsurf.errors import InputError
from sparsurf.kernel_cache import choose_kernel_cache, choose_matplotlib_folder, require_kernel_cache
from sparsurf.version import __version__

if TYPE_CHECKING:  # editors and type checkers see what `__getattr__` loads
    from sparsurf.api.areas import Areas, areas
    from sparsurf.api.depth import depth
    from sparsurf.api.fields import fields, residues
    from sparsurf.api.frames import frames
    from sparsurf.api.infer_atoms import infer_atoms
    from sparsurf.api.minimal import floors, minimal, recover
    from sparsurf.api.patches import descriptors, roughness
    from sparsurf.api.points import points, points_of
    from sparsurf.api.regions import regions
    from sparsurf.api.show import show
    from sparsurf.api.subsets import compare, prepare, sample
    from sparsurf.api.surface_atoms import surface_atoms
    from sparsurf.api.surfaces import components, mesh, surface
    from sparsurf.api.writing import write
    from sparsurf.evaluation.minimal_subset import Subset
    from sparsurf.evaluation.prepared_surface import PreparedSurface
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.molecules.read_molecule import read_molecule
    from sparsurf.recovery.law import density_for, error_at
    from sparsurf.recovery.spheres.atoms import Atoms
    from sparsurf.registry import register
    from sparsurf.surfaces.chosen_points import Points
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.surfaces.read_surface import read_surface
    from sparsurf.surfaces.surface import Surface
    from sparsurf.surfaces.surface_atoms import SurfaceAtoms

# Module of each function and class for users; loaded when first used, so that the import costs nothing.
FUNCTIONS = {
    "read_molecule": "molecules.read_molecule",
    "read_surface": "surfaces.read_surface",
    "surface": "api.surfaces",
    "mesh": "api.surfaces",
    "components": "api.surfaces",
    "points": "api.points",
    "points_of": "api.points",
    "roughness": "api.patches",
    "descriptors": "api.patches",
    "prepare": "api.subsets",
    "sample": "api.subsets",
    "compare": "api.subsets",
    "minimal": "api.minimal",
    "density_for": "recovery.law",
    "error_at": "recovery.law",
    "floors": "api.minimal",
    "infer_atoms": "api.infer_atoms",
    "surface_atoms": "api.surface_atoms",
    "recover": "api.minimal",
    "fields": "api.fields",
    "residues": "api.fields",
    "regions": "api.regions",
    "depth": "api.depth",
    "areas": "api.areas",
    "frames": "api.frames",
    "write": "api.writing",
    "show": "api.show",
    "register": "registry",
}
CLASSES = {
    "Areas": "api.areas",
    "Atoms": "recovery.spheres.atoms",
    "Molecule": "molecules.molecule",
    "Surface": "surfaces.surface",
    "SurfaceAtoms": "surfaces.surface_atoms",
    "Points": "surfaces.chosen_points",
    "Mesh": "surfaces.mesh",
    "Subset": "evaluation.minimal_subset",
    "PreparedSurface": "evaluation.prepared_surface",
}
__all__ = [
    "Areas",
    "Atoms",
    "InputError",
    "Mesh",
    "Molecule",
    "Points",
    "PreparedSurface",
    "Subset",
    "Surface",
    "SurfaceAtoms",
    "__version__",
    "areas",
    "compare",
    "components",
    "density_for",
    "depth",
    "descriptors",
    "error_at",
    "fields",
    "floors",
    "frames",
    "infer_atoms",
    "mesh",
    "minimal",
    "points",
    "points_of",
    "prepare",
    "read_molecule",
    "read_surface",
    "recover",
    "regions",
    "register",
    "residues",
    "roughness",
    "sample",
    "show",
    "surface",
    "surface_atoms",
    "write",
]


def __getattr__(name: str) -> Any:
    """Load a function or class for users from its module."""
    module = FUNCTIONS.get(name) or CLASSES.get(name)
    if module is None:
        raise AttributeError(f"module 'sparsurf' has no attribute {name!r}")
    if progress.enabled is None:
        progress.enabled = True
    if not module.startswith("molecules"):  # which have no kernels
        require_kernel_cache()
    return getattr(import_module(f"sparsurf.{module}"), name)


display.find_functions_by(lambda module: import_module(f"sparsurf.api.{module}"))
choose_kernel_cache()
choose_matplotlib_folder()


def __dir__() -> list[str]:
    """List the public names, those that are not loaded yet included."""
    return sorted(__all__)
