"""Names that a config may hold, written out so that planning a study imports no numpy; a test compares them with the library."""

from typing import Literal, get_args

from sparsurf_study.simulation.protocol import SELECTION_KEYS

Field = Literal[
    "hydropathy", "potential", "bfactor", "mean_curvature", "gaussian_curvature", "shape_index", "hbond"
]
FIELDS = get_args(Field)
SURFACE_SUFFIXES = (".csv", ".dms", ".npz", ".ply")  # of files that hold a ready surface

# Keys of a protein by their purpose.
FILE_KEYS = ("structure", "trajectory", "surface", "table")
SOURCE_KEYS = ("structure", "url", "pdb", "surface")  # a protein has exactly one of them
MOLECULE_KEYS = (*SELECTION_KEYS, "hydrogens", "ligands", "plddt")
