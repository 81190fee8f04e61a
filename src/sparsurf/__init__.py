"""Minimal representations of a molecular surface, after Grassmann et al.

From a molecule to a subset of its surface and its worth, arrays in and arrays out (`help` shows each with examples):

    dots = sparsurf.surface("protein.pdb")         # dots.points, dots.normals: (N, 3), Å
    R = sparsurf.roughness(dots)                   # (N,), 1 is flat
    z = sparsurf.descriptors(dots, [0, 1, 2])      # (3, 121)
    kept = sparsurf.sample(dots, percent=10)       # a tenth of the dots
    sparsurf.compare(dots, kept)                   # Z and d, next to a uniform subset
    sparsurf.fields(dots)                          # hydropathy and potential at every dot
    few = sparsurf.minimal(dots)                   # as few dots as give the surface back
    sparsurf.find("bound.pdb", ["unbound.pdb"], residues="A:10-25")  # the same site on another form
    sparsurf.recover(few)                          # the dense surface from them alone; sparsurf.mesh(few) its triangles

`read_molecule` reads structures and trajectories, `read_surface` dots of other programs, `prepare` saves time where one
surface is sampled and compared many times. What a user gave wrong raises `InputError` with one sentence.

Glossary (the paper's symbols and the field's words; lengths in Å everywhere)

dot            one point of the molecular surface, with its outward unit normal
N              number of dots of the full surface
patch          dots within R_patch (roughness, sampling) or R_zernike (descriptors) of a
               dot, cut down to the largest island
island         connected component of a patch, two dots being linked when closer than D_link
centre         dot around which the sampling cuts a patch; always kept
cover          the centres and their patches; every dot lies in at least one
R, R_i         roughness of the patch of dot i: 1 is flat, 0 is rough
n_S            number of dots that a sampling keeps
uniform subset  dots drawn at random, each with the same chance
minimal subset  as few dots as give the surface back as well as other dots of it; or as few as are asked for
combination    one choice of (alpha, beta, gamma, delta)
draw           one random realisation of a combination, or of a uniform subset
test dot       dot at which the descriptors of two surfaces are compared
z              vector of the 121 Zernike invariants |c_nm| of a patch
Z_tS, Z_tR     mean |z_tot - z_S|, mean |z_tot - z_R| over the test dots
d              Z_tR - Z_tS: positive where the sampling beats the uniform subset
reading        how 'the points not connected are removed' is understood:
               'as_coded' among the kept dots, 'as_written' on the full surface, 'recovered' on
               the surface that the kept dots give back
range          one of ten equal intervals of n_S
partners       the two surfaces of a pair; complementarity compares the first's patches 'up' with the second's 'down'
propensity     distance of a dot's patch to the nearest patch of the partner: low is likely interface
similarity     the same with both 'up'
interface      dots within 3 Å of the partner's surface
baseline       a simple property of a dot, with whose AUC the propensity's is compared
field          a number at every dot that follows from the atoms, such as hydropathy
site           residues whose surface is sought on other surfaces; it is described in places, dots with numbers
noise floor    Z of other dots of the same surface, of the turned molecule or of moved atoms
conformation   one frame, structure or surface that enters the study
"""

from importlib import import_module

from sparsurf import progress

__version__ = "1.0.0"
# Functions for users, by the module that holds them; loaded when first used, so that the import costs nothing.
CALLS = {
    "read_molecule": "molecules.read_molecule.read_molecule",
    "read_surface": "surfaces.read_surface.read_surface",
    "surface": "cli.making.surface",
    "mesh": "cli.making.mesh",
    "components": "cli.making.components",
    "roughness": "cli.roughness.roughness",
    "descriptors": "cli.descriptors.descriptors",
    "prepare": "cli.subsets.prepare",
    "sample": "cli.subsets.sample",
    "compare": "cli.subsets.compare",
    "minimal": "cli.minimal.minimal",
    "floors": "cli.minimal.floors",
    "settle": "cli.minimal.settle",
    "recover": "cli.recover.recover",
    "fields": "cli.field_calls.fields",
    "residues": "cli.field_calls.residues",
    "recommend": "cli.recommend.recommend",
    "write": "cli.outputs.write_result",
    "describe_sites": "cli.find.describe_sites",
    "find": "cli.find.find",
}
__all__ = ["InputError", "__version__", *CALLS]


class InputError(ValueError):
    """Something the user gave is wrong; the message is one sentence for them."""

    def __init__(self, message: object = "") -> None:
        super().__init__(printable(message))


def printable(message: object) -> str:
    """Return a message in which escape codes stand for control characters, which a file may hold to change a terminal."""
    return "".join(
        letter if letter.isprintable() or letter == "\n" else repr(letter)[1:-1] for letter in str(message)
    )


def __getattr__(name):
    """The function of that name, from the module that holds it."""
    if name not in CALLS:
        raise AttributeError(f"module 'sparsurf' has no attribute {name!r}")
    module, _, function = CALLS[name].rpartition(".")
    progress.enabled = True
    return getattr(import_module(f"sparsurf.{module}"), function)


def __dir__():
    return sorted({*globals(), *CALLS})
