"""Draw two forms of a protein in the colours of their change, and the change along the residues."""

from pathlib import Path

import numpy as np

from sparsurf_study.workflow.jobs import job
from sparsurf.api.pages import page_of_values
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.views import layout
from sparsurf.views.viewer.scene import DotValues
from sparsurf_study.analysis.tables import read_residues
from sparsurf_study.pairs.changes import numbered_alike, over_floor
from sparsurf_study.pairs.matching import on_atoms
from sparsurf_study.report.figures.changes import changes_figure, highest_shown, seen_alike
from sparsurf_study.report.page_origin import origin_of_page, with_atoms
from sparsurf_study.structures import read_study_structure, residue_labels

MEANING = "at its floor", "changed", "below it, or buried"

with job(snakemake) as s:
    name, table = s.wildcards.comparison, read_residues(s.input.changes)
    settings = s.settings
    table["over_floor"] = over_floor(table)
    structures = [s.input.structure_1, s.input.structure_2]
    reference, drawn = read_study_structure(structures[0]), []
    for side, form in enumerate(s.params.forms, 1):
        dots = read_npz(s.input[f"surface_{side}"])
        molecule = numbered_alike(read_study_structure(structures[side - 1]), reference)
        drawn.append((form, dots, molecule, on_atoms(molecule, table, "over_floor")[dots.atom]))
    highest = highest_shown([change for *_, change in drawn])
    for side, ((form, dots, _, change), seen) in enumerate(zip(drawn, seen_alike(drawn), strict=True), 1):
        shown = np.where(change < 1, np.nan, np.minimum(change, highest))
        text = page_of_values(
            f"{name}, {form}",
            dots,
            settings,
            s.streams(f"{name}/{side}"),
            [DotValues("change over its floor", "change", "", shown, *MEANING)],
            residue_labels(structures[side - 1]),
            origin_of_page(with_atoms(dots, structures[side - 1], settings), structures[side - 1]),
            turn=seen[-1],
        )
        Path(s.output[f"view_{side}"]).write_text(text, encoding="utf-8")
    layout.save(changes_figure(name, drawn, table), s.output.png)
