"""The figures of a surface with a grid: planning a study imports this, so it needs no numpy.

Each name is a module of `figures`, an output of the rule `draw_figures` and a caption in `captions`.
"""

PAPER_FIGURES = (
    "roughness",
    "number_of_dots",
    "d_over_grid",
    "rough_and_flat",
    "subsets",
)  # 1 to 5 of the paper
FIGURES = ("required_dots", *PAPER_FIGURES)
# Small figures of the first page in their order, also those of a protein and of `make compare`
GALLERY = ("subsets", "roughness", "rough_and_flat", "compare", "frames", "simulation")
