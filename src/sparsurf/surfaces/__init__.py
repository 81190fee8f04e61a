"""Dots with normals: made, read, written. Nothing here knows a patch."""
