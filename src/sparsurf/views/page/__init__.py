"""The interactive page of a molecule, its surface and its dots, which 3Dmol.js draws."""
