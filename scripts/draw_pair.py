"""Both partners of a pair, opened like a book."""

import pandas as pd

from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import book_figure
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES


def main(inputs, outputs, name):
    """Draw and save the picture."""
    dots = pd.read_csv(inputs["dots"], low_memory=False)
    surfaces = [read_npz(inputs[f"surface_{side}"]) for side in SIDES]
    tables = [dots[dots["partner"] == int(side)] for side in SIDES]
    layout.save(book_figure(name, surfaces, tables), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
