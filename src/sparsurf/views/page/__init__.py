"""The pages of `show` and of a study: what stands around the picture of a molecule, and what was left out of it."""
