"""Samplers compared at equal n_S: the methods, the measurements, and their evaluation."""
