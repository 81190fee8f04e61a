"""A page on one surface: the viewer, its roughness, its residues, and what was left out of the molecule."""
