"""n_S, roughness and d of one combination over time, and the roughness of the residues."""

import pandas as pd

from sparsurf.report.ensemble_page import TEMPLATE, ensemble_page
from sparsurf.report.figures import layout, over_time
from sparsurf.report.page import write
from sparsurf.report.site_page import read_residues
from sparsurf.workflow.jobs import run


def main(inputs, outputs, settings, name):
    """Draw and save the two figures, and write their page."""
    table, combination = pd.read_csv(inputs["table"]), settings["ensemble"]["combination"]
    layout.save(over_time.ensemble_figure(table, combination, name), outputs["png"].removesuffix(".png"))
    rows, residues = (read_residues(inputs[key]) for key in ("over_time", "residues"))
    layout.save(over_time.residues_figure(rows, residues, name), outputs["residues"].removesuffix(".png"))
    write(outputs["page"], TEMPLATE, **ensemble_page(name, table, combination))


if __name__ == "__main__":
    run(main, snakemake)
