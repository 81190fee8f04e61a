"""Two surfaces: how the patches of one match those of the other."""
