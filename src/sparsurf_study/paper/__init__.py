"""Comparison with the paper: its published runs repeated, and its claims in numbers."""
