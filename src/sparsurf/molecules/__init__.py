"""Atoms in Å from any file. Nothing here knows a surface."""
