"""Which surfaces of a run are unusual, and what failed for which reason."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd

MAD_TO_SD = 1.4826  # The ratio of a normal distribution.
# Numbers by which surfaces are compared with the others of the run, and how they are called
BATCH_MEASURES = {
    "atoms": "atoms",
    "area_per_atom": "area per atom",
    "volume_per_atom": "volume per atom",
    "mean_roughness": "mean roughness",
    "cavity_percent": "dots in cavities",
}
MIN_SURFACES = 5  # fewer have no distribution to be unusual in


def measures(surfaces: pd.DataFrame) -> pd.DataFrame:
    """Return the numbers of `MEASURES` for each surface, and area (Å^2) and volume (Å^3) per atom."""
    atoms = surfaces["atoms"]
    return pd.DataFrame(
        {
            "atoms": atoms,
            "area_per_atom": surfaces["area"] / atoms,
            "volume_per_atom": surfaces["volume"] / atoms,
            "mean_roughness": surfaces["mean_roughness"],
            "cavity_percent": 100 * surfaces["cavity_dots"] / surfaces["N"],
        }
    )


def most_unusual(surfaces: pd.DataFrame, n: int) -> pd.DataFrame:
    """Find the n surfaces that lie farthest from the median of the run in any of `MEASURES`, the farthest first; ties by name.

    `deviation` is the distance from the median in robust standard deviations (1.4826 times the median absolute deviation; of
    the number of atoms, of its logarithm), and `unusual` the measure in which it is largest.
    """
    values = measures(surfaces)
    table = surfaces.join(values.drop(columns=["atoms", "mean_roughness"]))
    compared = values.assign(atoms=np.log(values["atoms"]))
    distance = (compared - compared.median()).abs()
    scale = MAD_TO_SD * distance.median()
    deviations = (distance / scale.where(scale > 0)).fillna(0.0)
    if len(surfaces) < MIN_SURFACES:
        deviations[:] = 0.0
    table["deviation"] = deviations.max(axis=1)
    table["unusual"] = deviations.idxmax(axis=1).map(BATCH_MEASURES).where(table["deviation"] > 0, "")
    order = table.sort_values(["deviation", "protein"], ascending=[False, True], kind="stable")
    return order.head(n).reset_index(drop=True)


def grouped_reasons(failures: pd.DataFrame) -> list[tuple[str, list[str]]]:
    """Group failures whose reasons differ only in names of files and in numbers: the first reason and all names, most first."""
    groups: dict[str, tuple[str, list[str]]] = {}
    for name, reason in failures[["protein", "reason"]].itertuples(index=False):
        text = re.sub(r"^\S*/(?=\S+)", "", reason)
        kind = re.sub(rf"^\S+|\b{re.escape(name)}\b|[0-9][0-9.,]*", "", text)
        groups.setdefault(kind, (text, []))[1].append(name)
    return sorted(groups.values(), key=lambda group: -len(group[1]))
