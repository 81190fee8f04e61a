"""A surface as triangles, linked with the list and the profile of its residues, for one frame or many."""
