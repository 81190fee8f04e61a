"""Pairs of surfaces: how well the patches of one match those of the other."""
