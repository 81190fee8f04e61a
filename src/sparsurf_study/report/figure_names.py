"""The figures of a surface with a grid: planning a study imports this, so it needs no numpy.

Each name is a module of `figures`, an output of the rule `draw_figures` and a caption in `captions`; `draw_roughness` draws
`roughness`, which needs no grid, and only a study of the paper has `number_of_dots`.
"""

from typing import NamedTuple

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


class Picture(NamedTuple):
    """A rendered picture inside a figure: the figure, the height of its sheet below the head, and where it lies there, mm."""

    figure: str
    sheet: float
    left: float
    top: float
    width: float
    height: float


# Pictures that the first page shows alone, without their scale bars, by what they show
PICTURES = {
    "roughness": Picture("roughness", 105.0, 4.0, 3.0, 68.0, 54.0),
    "sampled": Picture("subsets", 121.0, 63.0, 10.5, 58.0, 45.0),
    "minimal": Picture("subsets", 121.0, 2.0, 70.5, 58.0, 45.0),
}
