"""Both partners of a pair, opened like a book, and a page to look at each, with the binding propensity of its dots."""

from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import residue_names
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import book_figure
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES


def main(inputs, outputs, settings, name):
    """Draw and save the picture, and write view_1.html and view_2.html."""
    dots = pd.read_csv(inputs["dots"], low_memory=False)
    surfaces = [read_npz(inputs[f"surface_{side}"]) for side in SIDES]
    tables = [dots[dots["partner"] == int(side)] for side in SIDES]
    layout.save(book_figure(name, surfaces, tables), outputs["png"].removesuffix(".png"))
    for side, surface, own in zip(SIDES, surfaces, tables, strict=True):
        values = [
            Values(
                "binding propensity", "propensity", "",
                own["propensity_smoothed"].to_numpy(), "good match", "poor match",
            ),
            Values("distance to the partner", "gap", " Å", own["gap"].to_numpy(), "touching", "far"),
        ]  # fmt: skip
        title, residues = f"{name}, partner {side}", residue_names(inputs.get(f"structure_{side}"))
        text = coloured_page(title, f"{name}/{side}", surface, settings, values, residues)
        Path(outputs[f"view_{side}"]).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    run(main, snakemake)
