"""The 3D viewer of a page: a molecule, its surface and its dots, which 3Dmol.js draws."""
