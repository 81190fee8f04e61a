"""Draw the rules of the Snakefile for the README: `python scripts/draw_rules.py` writes docs/rules.svg."""

from pathlib import Path

from sparsurf.report.figures import layout, rules

PATH = Path(__file__).resolve().parents[1] / "docs" / "rules.svg"


def main(path_to_figure=PATH):
    """Write the picture."""
    layout.save_svg(rules.draw(), path_to_figure)


if __name__ == "__main__":
    main()
