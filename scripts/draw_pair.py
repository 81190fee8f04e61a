"""Draw both partners of a pair, opened like a book: a picture, and a page with the rank of every dot by its match."""

from itertools import chain
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.molecules.read_molecule import residue_labels
from sparsurf.report.figures import layout
from sparsurf.report.figures.pair_figures import book_figure, opened, ranks
from sparsurf.report.viewer.page import Values, coloured_page
from sparsurf.settings import Patches, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.formats.npz import read_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.jobs import job

GAP = 5.0  # Å, between both partners on the page


def main(
    surface_1: str,
    surface_2: str,
    structure_1: str | None,
    structure_2: str | None,
    dots: str,
    agreement: str,
    png: str,
    view: str,
    patches: dict,
    seed: int,
    name: str,
) -> None:
    """Write the picture and the page view.html.

    Parameters
    ----------
    structure_1, structure_2 : name the residues of the dots; None for a ready surface
    patches : dict, the section `patches` of the config
    name : of the pair
    """
    dot_table = pd.read_csv(dots, low_memory=False)
    surfaces = [read_npz(surface) for surface in (surface_1, surface_2)]
    tables = [dot_table[dot_table["partner"] == side] for side in (1, 2)]
    layout.save(book_figure(name, surfaces, tables, pd.read_csv(agreement)), png)
    pages = opened(surfaces, [table["interface"].to_numpy() == 1 for table in tables])
    labels = [
        [f"{label}, partner {side}" for label in residue_labels(structure)]
        for side, structure in enumerate((structure_1, structure_2), 1)
    ]
    rank = np.concatenate([ranks(table["propensity_smoothed"]) for table in tables])
    values = [
        Values("rank of the distance to the nearest patch", "rank", " %", rank, "good match", "poor match"),
        Values("distance to the partner", "gap", " Å", dot_table["gap"].to_numpy(), "touching", "far"),
    ]
    both = side_by_side(surfaces, pages, [len(names) for names in labels])
    text = coloured_page(
        name, both, Settings(patches=Patches(**patches)), Streams(seed, name), values, [*chain(*labels)]
    )
    Path(view).write_text(text, encoding="utf-8")


def side_by_side(surfaces: list[Surface], pages: list[np.ndarray], n_atoms: list[int]) -> Surface:
    """Join both partners to one surface, the pages of an open book; `n_atoms` are those with a label, 0 for none."""
    points = [surface.points @ page.T for surface, page in zip(surfaces, pages, strict=True)]
    middles = [(x.min(axis=0) + x.max(axis=0)) / 2 for x in points]
    shift = (np.ptp(points[0][:, 0]) + np.ptp(points[1][:, 0])) / 2 + GAP
    points = [points[0] - middles[0], points[1] - middles[1] + [shift, 0, 0]]
    normals = [surface.normals @ page.T for surface, page in zip(surfaces, pages, strict=True)]
    atoms = [
        np.where((surface.atom < 0) | (n == 0), -1, surface.atom + before)
        for surface, n, before in zip(surfaces, n_atoms, (0, n_atoms[0]), strict=True)
    ]
    kind = np.concatenate([surface.kind for surface in surfaces])
    return Surface(np.concatenate(points), np.concatenate(normals), kind=kind, atom=np.concatenate(atoms))


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
            view=snakemake.output.view,
            patches=snakemake.params.patches,
            seed=snakemake.params.seed,
            name=snakemake.wildcards.pair,
        )
