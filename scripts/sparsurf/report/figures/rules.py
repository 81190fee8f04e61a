"""The rules of the Snakefile as a picture: stages from left to right, each with its rules."""

from matplotlib.patches import FancyArrowPatch, FancyBboxPatch

from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import DARK, PAGE, PALE, styled

# title -> column, row from the top, rules
STAGES = {
    "a structure": (0, 0, ["fetch_structure"]),
    "a simulation": (0, 1, ["prepare_system", "simulate_stage", "judge_simulation"]),
    "conformations": (1, 0, ["choose_frames", "draw_frames"]),
    "all frames": (1, 1, ["follow_ensemble", "follow_frames", "draw_ensemble"]),
    "dots": (2, 0, ["make_surface", "take_surface", "compile_kernels"]),
    "two partners": (
        2,
        1,
        [
            "make_partners",
            "match_partners",
            "tabulate_pair_residues",
            "draw_pair",
            "draw_pair_views",
            "thin_pair",
        ],
    ),
    "roughness": (3, 0, ["measure_roughness", "measure_floors"]),
    "sampling": (3, 1, ["evaluate_grid", "tabulate_best", "compare_samplers", "take_minimal"]),
    "to look at": (4, 0, ["draw_figures", "draw_view", "tabulate_residues"]),
    "the answer": (
        4,
        1,
        ["summarise_run", "summarise_comparison", "summarise_pairs", "reproduce_paper", "write_front_page"],
    ),
}
ARROWS = [
    ("a structure", "a simulation"),
    ("a structure", "conformations"),
    ("a simulation", "conformations"),
    ("conformations", "dots"),
    ("conformations", "all frames"),
    ("dots", "roughness"),
    ("dots", "two partners"),
    ("roughness", "sampling"),
    ("roughness", "to look at"),
    ("sampling", "to look at"),
    ("sampling", "the answer"),
]
WIDE, HIGH, ACROSS, DOWN = 31.0, 22.0, 37.5, 31.0  # mm: of a box, and from one to the next


@styled
def draw():
    """The picture, two columns of a journal wide."""
    figure = layout.sheet(PAGE, 56)
    page = layout.axes(figure, 0, 0, PAGE, 56)
    page.set(xlim=(0, PAGE), ylim=(56, 0))
    page.set_axis_off()
    for title, (column, row, rules) in STAGES.items():
        x, y = _corner(column, row)
        box = FancyBboxPatch(
            (x, y), WIDE, HIGH, "round,pad=0,rounding_size=1.5", facecolor=PALE, edgecolor=DARK
        )
        page.add_patch(box)
        page.text(x + WIDE / 2, y + 3.4, title, ha="center", va="center", fontweight="bold")
        page.text(
            x + WIDE / 2, y + 6.2, "\n".join(rules), ha="center", va="top", fontsize=5.5, linespacing=1.25
        )
    for start, end in ARROWS:
        a, b = _ends(STAGES[start][:2], STAGES[end][:2])
        page.add_patch(
            FancyArrowPatch(a, b, arrowstyle="-|>", mutation_scale=6, linewidth=0.8, color="black")
        )
    return figure


def _corner(column, row):
    return 1.0 + ACROSS * column, 1.0 + DOWN * row


def _ends(start, end):
    """Where an arrow leaves one box and meets another: sides that face each other, corners where both differ."""
    (x, y), (u, v) = _corner(*start), _corner(*end)
    if start[0] == end[0]:
        return (x + WIDE / 2, y + (HIGH if v > y else 0)), (u + WIDE / 2, v + (0 if v > y else HIGH))
    lift = 0 if start[1] == end[1] else (0.3 if v > y else -0.3) * HIGH
    return (x + WIDE, y + HIGH / 2 + lift), (u, v + HIGH / 2 - lift)
