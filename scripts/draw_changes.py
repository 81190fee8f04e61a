"""Draw two forms of a protein in the colours of their change, and the change along the residues."""

from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf.molecules.read_molecule import read_study_structure, residue_labels
from sparsurf.pairs.changes import numbered_alike, over_floor
from sparsurf.pairs.matching import on_atoms
from sparsurf.report.figures import layout
from sparsurf.report.figures.changes import changes_figure, highest_shown, seen_alike
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.settings import Patches, Settings
from sparsurf.streams import Streams
from sparsurf.study.tables import read_residues
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(
    surface_1: str,
    surface_2: str,
    structure_1: str,
    structure_2: str,
    changes: str,
    png: str,
    view_1: str,
    view_2: str,
    forms: list[str],
    patches: dict,
    seed: int,
    name: str,
) -> None:
    """Write the picture and a page of each form.

    Parameters
    ----------
    forms : both conformations as the config names them
    patches : dict, the section `patches` of the config
    name : of the comparison
    """
    table, settings = read_residues(changes), Settings(patches=Patches(**patches))
    table["over_floor"] = over_floor(table)
    reference = read_study_structure(structure_1)
    files = (surface_1, structure_1, view_1), (surface_2, structure_2, view_2)
    drawn = []
    for form, (surface, structure, _) in zip(forms, files, strict=True):
        dots, molecule = read_npz(surface), numbered_alike(read_study_structure(structure), reference)
        drawn.append((form, dots, molecule, on_atoms(molecule, table, "over_floor")[dots.atom]))
    highest = highest_shown([change for *_, change in drawn])
    for side, ((form, dots, _, change), (points, normals), (_, structure, view)) in enumerate(
        zip(drawn, seen_alike(drawn), files, strict=True), 1
    ):
        shown = np.where(change < 1, np.nan, np.minimum(change, highest))
        values = [
            Values(
                "change over its floor", "change", "", shown, "at its floor", "changed", "below it, or buried"
            )
        ]
        page = coloured_page(
            f"{name}, {form}", replace(dots, points=points, normals=normals), settings, Streams(seed, f"{name}/{side}"),
            values, residue_labels(structure),
        )  # fmt: skip
        Path(view).write_text(page, encoding="utf-8")
    layout.save(changes_figure(name, drawn, table), png)


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface_1=snakemake.input.surface_1,
            surface_2=snakemake.input.surface_2,
            structure_1=snakemake.input.structure_1,
            structure_2=snakemake.input.structure_2,
            changes=snakemake.input.changes,
            png=snakemake.output.png,
            view_1=snakemake.output.view_1,
            view_2=snakemake.output.view_2,
            forms=snakemake.params.forms,
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.comparison,
        )
