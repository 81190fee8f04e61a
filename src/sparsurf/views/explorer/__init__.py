"""The part of a page that links a surface of triangles with the list and the profile of its residues, for one frame or many."""
