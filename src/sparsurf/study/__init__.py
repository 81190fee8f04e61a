"""Evaluation of subsets, as arrays and tables."""
