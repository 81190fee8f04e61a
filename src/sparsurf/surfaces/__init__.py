"""Molecular surfaces as dots with normals: computed, read and written. This package does not know patches."""
