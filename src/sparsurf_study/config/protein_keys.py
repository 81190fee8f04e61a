"""Keys of a protein in a config, by their purpose."""

from sparsurf_study.simulation.protocol import SELECTION_KEYS

FILE_KEYS = ("structure", "trajectory", "surface", "table")
SOURCE_KEYS = ("structure", "url", "pdb", "surface")  # a protein has exactly one of them
MOLECULE_KEYS = (*SELECTION_KEYS, "hydrogens", "ligands", "plddt")
