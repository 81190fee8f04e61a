"""Molecules: atoms with coordinates in Å, read from any file. Nothing here knows a surface."""
