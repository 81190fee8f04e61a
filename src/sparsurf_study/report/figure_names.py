"""The figures of a surface with a grid: planning a study imports this, so it needs no numpy.

Each name is a module of `figures`, an output of the rule `draw_figures` and a caption in `captions`; `draw_roughness` draws
`roughness`, which needs no grid, and only a study of the paper has `number_of_dots`.
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


def figures_with_svg(is_of_paper: bool) -> list[str]:
    """Return the figures that `draw_figures` also stores as SVG."""
    left_out = ("roughness",) if is_of_paper else ("roughness", "number_of_dots")
    return [name for name in PAPER_FIGURES if name not in left_out]
