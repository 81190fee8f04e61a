"""Draw both partners of a pair, opened like a book, and a page of each with the rank of every dot by its match."""

from dataclasses import replace
from pathlib import Path

import pandas as pd

from sparsurf.molecules.read_molecule import residue_labels
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import book_figure, opened, ranks
from sparsurf.report.numbers import interval
from sparsurf.report.pair_page import MAIN_SCORE
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.workflow.jobs import job


def main(
    surface_1: str,
    surface_2: str,
    structure_1: str | None,
    structure_2: str | None,
    dots: str,
    agreement: str,
    png: str,
    view_1: str,
    view_2: str,
    patches: dict,
    seed: int,
    name: str,
) -> None:
    """Write the picture and the pages view_1.html and view_2.html.

    Parameters
    ----------
    structure_1, structure_2 : name the residues of the dots; None for a ready surface
    patches : dict, the section `patches` of the config
    name : of the pair
    """
    dot_table = pd.read_csv(dots, low_memory=False)
    surfaces = [read_npz(surface) for surface in (surface_1, surface_2)]
    tables = [dot_table[dot_table["partner"] == side] for side in (1, 2)]
    scores = pd.read_csv(agreement)
    layout.save(book_figure(name, surfaces, tables, scores), png)
    auc = scores[scores["score"] == MAIN_SCORE].set_index("partner")[["auc", "low", "high"]]
    pages = opened(surfaces, [table["interface"].to_numpy() == 1 for table in tables])
    files = (structure_1, view_1), (structure_2, view_2)
    for side, (surface, page, table, (structure, view)) in enumerate(
        zip(surfaces, pages, tables, files, strict=True), 1
    ):
        seen = replace(surface, points=surface.points @ page.T, normals=surface.normals @ page.T)
        rank = ranks(table["propensity_smoothed"])
        values = [
            Values(
                "rank of the distance to the nearest patch", "rank", " %", rank, "good match", "poor match"
            ),
            Values("distance to the partner", "gap", " Å", table["gap"].to_numpy(), "touching", "far"),
        ]
        title = f"{name}, partner {side}"
        says = f"AUC {interval(*auc.loc[side])} for the interface" if side in auc.index else ""
        labels = residue_labels(structure)
        text = coloured_page(title, f"{name}/{side}", seen, patches, seed, values, labels, says)
        Path(view).write_text(text, encoding="utf-8")


if __name__ == "__main__":
    with job(snakemake):
        main(
            surface_1=snakemake.input.surface_1,
            surface_2=snakemake.input.surface_2,
            structure_1=snakemake.input.get("structure_1"),
            structure_2=snakemake.input.get("structure_2"),
            dots=snakemake.input.dots,
            agreement=snakemake.input.agreement,
            png=snakemake.output.png,
            view_1=snakemake.output.view_1,
            view_2=snakemake.output.view_2,
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.pair,
        )
