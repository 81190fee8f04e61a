"""n_S, roughness and d of one combination over time, and the roughness of the residues."""

import pandas as pd

from sparsurf.report.ensemble_page import TEMPLATE, ensemble_page
from sparsurf.report.figures import layout, residues_over_time, summary_figures
from sparsurf.report.page import write
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name):
    """Draw and save the two figures, and write their page."""
    table, combination = pd.read_csv(inputs["table"]), settings["ensemble"]["combination"]
    layout.save(summary_figures.ensemble_figure(table, combination), outputs["png"].removesuffix(".png"))
    over_time, residues = (
        pd.read_csv(inputs[key], dtype={"residue": str}) for key in ("over_time", "residues")
    )
    layout.save(residues_over_time.draw(over_time, residues), outputs["residues"].removesuffix(".png"))
    write(outputs["page"], TEMPLATE, **ensemble_page(name, table, combination))


if __name__ == "__main__":
    run(main, snakemake)
