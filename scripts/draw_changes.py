"""Two forms of a protein in the colours of their change, and the change along the residues."""

from pathlib import Path

from sparsurf.molecules.read_molecule import read_own, residue_names
from sparsurf.pairs.changes import numbered_alike
from sparsurf.pairs.matching import on_atoms
from sparsurf.report.figures import layout
from sparsurf.report.figures.site_figures import changes_figure
from sparsurf.report.site_page import read_residues
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import run
from sparsurf.workflow.partner_files import SIDES


def main(inputs, outputs, settings, site, name):
    """Draw and save the picture, and a page of each form to look at."""
    table = read_residues(inputs["changes"])
    reference, forms = read_own(inputs["structure_1"]), []
    for side in SIDES:
        path = inputs[f"structure_{side}"]
        surface, molecule = read_npz(inputs[f"surface_{side}"]), numbered_alike(read_own(path), reference)
        change = on_atoms(molecule, table, "total")[surface.atom]
        forms.append((site["changes"][int(side) - 1], surface, molecule, change))
        values = [Values("change from one form to the other", "change", "", change, "alike", "changed")]
        text = coloured_page(
            f"{name}, {forms[-1][0]}", f"{name}/{side}", surface, settings, values, residue_names(path)
        )
        Path(outputs[f"view_{side}"]).write_text(text, encoding="utf-8")
    layout.save(changes_figure(name, forms, table), outputs["png"].removesuffix(".png"))


if __name__ == "__main__":
    run(main, snakemake)
