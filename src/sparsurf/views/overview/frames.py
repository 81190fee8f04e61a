"""Render the page of a trajectory: the template holds the sentences, and these functions supply the numbers."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import pandas as pd

from sparsurf.molecules.molecule import Molecule
from sparsurf.surfaces.formats.ply import ROUGHNESS_LIMITS
from sparsurf.views.explorer.page import ResidueValues, ShownFrames, around_molecule
from sparsurf.views.explorer.shapes import Shape
from sparsurf.views.overview.page import N_OPEN, render_template
from sparsurf.views.overview.profile import labels_of, panels

N_CHANGING = 10  # residues of the table
TEMPLATE = "frames.html.j2"


def overview_of_frames(
    name: str,
    trajectory: str,
    molecule: Molecule,
    shapes: Sequence[Shape],
    area: np.ndarray,
    roughness: np.ndarray,
    labels: Sequence[str],
    notes: Sequence[str] = (),
    left_out: Sequence[str] | None = None,
    origin: Sequence[tuple[str, str]] = (),
) -> str:
    """Render the page of the frames of a molecule, in one file.

    `shapes` are the surfaces of the shown frames, `area` (F, R), Å^2, and `roughness` (F, R) those of their residues, and
    `labels` their names. `notes` and `left_out` are what reading the molecule said, and `origin` says where the page is from.
    """
    residues = change_table(molecule, area, roughness)
    changing = residues.nlargest(N_CHANGING, "sd_area")
    whole = area.sum(axis=1)
    rows = [
        row | {"label": label, "residue": position}
        for label, position, row in zip(
            labels_of(changing), changing.index, changing.to_dict("records"), strict=True
        )
    ]
    context: dict[str, Any] = {
        "title": f"The surface of {name} in {len(shapes)} frames",
        "trajectory": trajectory,
        "n_frames": len(shapes), "n_all": molecule.n_frames, "n_residues": molecule.n_residues,
        "every": -(-molecule.n_frames // len(shapes)),
        "smallest": (whole.min(), labels[int(whole.argmin())]), "largest": (whole.max(), labels[int(whole.argmax())]),
        "most": rows, "panels": panels(residues, "sd_area", largest=True),
        "notes": notes, "left_out": None if left_out is None else ", ".join(left_out), "origin": origin,
        "linked": True, "orders": "the most changing", "n_open": N_OPEN,
    }  # fmt: skip

    def fill(data: str) -> str:
        """Return the page around the packed frames."""
        return render_template(TEMPLATE, data=data, **context)

    frames = ShownFrames(tuple(labels), tuple(whole.tolist()))
    return around_molecule(
        fill, molecule, shapes, [*changing_numbers(residues, area, roughness)], frames=frames
    )


def change_table(molecule: Molecule, area: np.ndarray, roughness: np.ndarray) -> pd.DataFrame:
    """Tabulate how area (F, R), Å^2, and roughness (F, R) of each residue change over the frames."""
    rough = pd.DataFrame(roughness)
    return molecule.residues.assign(
        sd_area=area.std(axis=0, ddof=1),
        mean_area=area.mean(axis=0),
        smallest_area=area.min(axis=0),
        largest_area=area.max(axis=0),
        mean_roughness=rough.mean().to_numpy(),
        sd_roughness=rough.std().to_numpy(),
    )


def changing_numbers(
    residues: pd.DataFrame, area: np.ndarray, roughness: np.ndarray
) -> Iterator[ResidueValues]:
    """Yield the numbers of the residues that the page shows, of all frames together and of each."""
    sd = residues["sd_area"].to_numpy(float)[None]
    yield ResidueValues(
        "standard deviation of the area", "Å²", sd, 1, "steady", "changing", colours=True, orders=-1
    )
    yield ResidueValues("area", "Å²", area, 0, "small", "large", colours=True)
    yield ResidueValues("mean roughness", "", roughness, 2, "rough", "flat", ROUGHNESS_LIMITS, colours=True)
