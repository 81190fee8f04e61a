"""Samplers compared at equal n_S: who takes part, what is measured, and what follows from it."""
