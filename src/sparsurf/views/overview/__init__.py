"""The page of `show`: the explorer, or the viewer for dots alone, with the residues and what was left out of the molecule."""
