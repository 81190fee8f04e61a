"""Render the page of a trajectory: the template holds the sentences, and these functions supply the numbers."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from sparsurf.evaluation.ranking import MIN_AREA, rank_residues, why_none_is_ranked
from sparsurf.molecules.molecule import Molecule
from sparsurf.views.page.page import labelled_rows, largest_contacts, named_field, render_template
from sparsurf.views.page.profile import ROUGHNESS_COLUMN, panels
from sparsurf.views.viewer.scene import PageScene, ResidueValues
from sparsurf.views.viewer.shapes import DrawnAtoms, Shape

N_CHANGING = 10  # residues of the table
TEMPLATE = "frames.html.j2"
STATISTICS = {"sd": "standard deviation", "range": "range"}


class Quantity(NamedTuple):
    """How a page names and writes a column of residues; `ends` say what its lowest and its highest values are."""

    name: str
    unit: str
    digits: int
    ends: tuple[str, str] = ("low", "high")


NAMED_COLUMNS = {
    "area": Quantity("area", "Å²", 0, ("small", "large")),
    ROUGHNESS_COLUMN: Quantity("mean roughness", "", 2, ("rough", "flat")),
    "depth": Quantity("depth", "Å", 1, ("outside", "deep")),
    "accessible": Quantity("accessible area", "Å²", 0, ("small", "large")),
    "relative": Quantity("relative accessible area", "", 2, ("buried", "exposed")),
    "buried": Quantity("area buried by other chains", "Å²", 0, ("small", "large")),
}


def render_page_of_frames(
    title: str,
    trajectory: str,
    atoms: DrawnAtoms,
    shapes: Sequence[Shape],
    numbers: Mapping[str, np.ndarray],
    ranked: tuple[str, str],
    labels: Sequence[str],
    touching: pd.DataFrame | None,
    notes: Sequence[str],
    left_out: Sequence[str] | None,
    origin: Sequence[tuple[str, str]],
) -> str:
    """Render the page of the frames of a molecule, in one file.

    `shapes` are the surfaces of the shown frames, `numbers` the columns of their residues, (F, R) each, with `area`, Å^2, and
    `mean_roughness`, and `labels` their names. Residues are `ranked` by a column and by 'sd' or 'range'. `notes` and `left_out`
    are what reading the molecule said, and `origin` says where the page is from.
    """
    molecule = atoms.molecule.take(atoms.molecule.residue_index < atoms.n_surfaced)
    column, rank_by = ranked
    residues = change_table(molecule, numbers, column, rank_by)
    in_rank = residues[residues["rank"].notna()]
    changing, fluctuation = in_rank.head(N_CHANGING), fluctuations(atoms, shapes)
    moving = int(np.nanargmax(fluctuation))
    label = atoms.molecule.residue_label(int(atoms.first_atoms[moving]))
    whole = numbers["area"].sum(axis=1)
    context: dict[str, Any] = {
        "title": title,
        "trajectory": trajectory, "quantity": quantity_of(column), "ranked_by": rank_by, "statistic": STATISTICS[rank_by],
        "n_frames": len(shapes), "n_all": molecule.n_frames, "residues": molecule.counted_residues,
        "every": -(-molecule.n_frames // len(shapes)),
        "smallest": (whole.min(), labels[int(whole.argmin())]), "largest": (whole.max(), labels[int(whole.argmax())]),
        "most": [*labelled_rows(changing)], "panels": panels(residues.sort_index(), rank_by, changing.index),
        "moving": {"label": label, "residue": moving, "fluctuation": fluctuation[moving]},
        "unranked": why_none_is_ranked(residues, len(shapes)), "min_area": MIN_AREA,
        "notes": notes, "left_out": left_out, "origin": origin,
    }  # fmt: skip
    change = residues.sort_index()[rank_by].to_numpy(float)
    shown = [*changing_numbers(numbers, column, rank_by, change, fluctuation)]
    scene = PageScene(
        shapes, atoms, numbers=shown, frames=labels, areas=whole.tolist(), contacts=touching, colour="number 0",
        order=[*residues.index], n_ranked=len(in_rank), orders="most changing",
    )  # fmt: skip
    context |= largest_contacts(scene)
    return scene.around(lambda data: render_template(TEMPLATE, data=data, **context))


def fluctuations(atoms: DrawnAtoms, shapes: Sequence[Shape]) -> np.ndarray:
    """Return the root mean square deviation of the drawn atoms of each residue from their mean positions, (R,), Å."""
    spread = np.array([shape.atoms for shape in shapes]).var(axis=0).sum(axis=1)
    residue, n = atoms.molecule.residue_index[atoms.chosen], len(atoms.first_atoms)
    count = np.bincount(residue, minlength=n)
    return np.sqrt(np.bincount(residue, spread, n) / np.where(count > 0, count, np.nan))


def change_table(
    molecule: Molecule, numbers: Mapping[str, np.ndarray], column: str, rank_by: str
) -> pd.DataFrame:
    """Rank residues by the change of a column, and add the standard deviation of their area."""
    table = rank_residues(molecule.residues, column, rank_by, lambda: [(numbers[column], numbers["area"])])
    return table.assign(sd_area=numbers["area"].std(axis=0, ddof=1)[table.index])


def quantity_of(column: str) -> Quantity:
    """Return what a page calls a column of residues."""
    if column in NAMED_COLUMNS:
        return NAMED_COLUMNS[column]
    field = named_field(column.removeprefix("mean_"))
    return Quantity(f"mean {field['name']}", field["unit"], 2)


def changing_numbers(
    numbers: Mapping[str, np.ndarray], column: str, rank_by: str, change: np.ndarray, fluctuation: np.ndarray
) -> Iterator[ResidueValues]:
    """Yield the numbers of the residues that the page shows: the `change` that ranks them, their `fluctuation`, and columns."""
    ranked = quantity_of(column)
    name = f"{rank_by} of the {ranked.name}"  # short enough for the menu
    yield ResidueValues(
        name, ranked.unit, change[None], ranked.digits + 1, "steady", "changing", colours=True
    )
    name = "root mean square fluctuation"
    yield ResidueValues(name, "Å", fluctuation[None], 2, "steady", "moving", colours=True)
    for of_frames in dict.fromkeys(("area", ROUGHNESS_COLUMN, column)):
        name, unit, digits, ends = quantity_of(of_frames)
        yield ResidueValues(name, unit, numbers[of_frames], digits, *ends, of_frames, colours=True)
