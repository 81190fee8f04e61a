"""The figures, one style for all."""
