"""The figures of a surface with a grid: planning a study imports this, so it needs no numpy.

Each name is a module of `figures`, an output of the rule `draw_figures` and a caption in `captions`.
"""

FIGURES = ("required_dots", "roughness", "number_of_dots", "d_over_grid", "rough_and_flat", "subsets")
PAPER_FIGURES = FIGURES[1:]  # figures 1 to 5 of the paper
# Small figures of the first page in their order, also those of a protein and of `make compare`
GALLERY = ("subsets", "roughness", "rough_and_flat", "compare", "frames", "simulation")
