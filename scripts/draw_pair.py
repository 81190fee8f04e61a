"""Draw both partners of a pair, opened like a book: a picture, and a page with the rank of every dot by its match."""

from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import job
from sparsurf.api.pages import page_of_values
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.views import layout
from sparsurf.views.viewer.scene import DotValues
from sparsurf_study.report.figures.pair_figures import book_figure, partners_opened, ranks, side_by_side
from sparsurf_study.report.page_origin import origin_of_page, with_atoms
from sparsurf_study.structures import residue_labels

with job(snakemake) as s:
    name, dots = s.wildcards.pair, pd.read_csv(s.input.dots, low_memory=False)
    surfaces = [read_npz(s.input[f"surface_{side}"]) for side in (1, 2)]
    tables = [dots[dots["partner"] == side] for side in (1, 2)]
    layout.save(book_figure(name, surfaces, tables, pd.read_csv(s.input.agreement)), s.output.png)
    labels = [residue_labels(s.input.get(f"structure_{side}")) for side in (1, 2)]
    rank = np.concatenate([ranks(table["propensity_smoothed"]) for table in tables])
    values = [
        DotValues(
            "rank of the distance to the nearest patch", "rank", " %", rank, "good match", "poor match"
        ),
        DotValues("distance to the partner", "gap", " Å", dots["gap"].to_numpy(), "touching", "far"),
    ]
    pages = partners_opened(surfaces, [table["interface"].to_numpy() == 1 for table in tables])
    surface = side_by_side(surfaces, pages, [len(names) for names in labels])
    atom_labels = [f"{label}, partner {side}" for side, names in enumerate(labels, 1) for label in names]
    settings, origin = s.settings, []
    for side, dots_of_side in enumerate(surfaces, 1):
        structure = s.input.get(f"structure_{side}")
        rows = origin_of_page(
            with_atoms(dots_of_side, structure, settings), structure or s.input[f"surface_{side}"]
        )
        # The last row is the version, which both share
        origin += [(f"{label} of partner {side}", value) for label, value in rows[:-1]]
    origin.append(rows[-1])
    text = page_of_values(name, surface, settings, s.streams(name), values, atom_labels, origin)
    Path(s.output.view).write_text(text, encoding="utf-8")
