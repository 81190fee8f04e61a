"""Page on one combination over all frames of a trajectory."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pandas as pd

from sparsurf.recovery.readings import readings_of_columns
from sparsurf.report.numbers import number
from sparsurf.sampling.combination import Combination

TEMPLATE = "ensemble.html.j2"
MEASURED = {"N": 0, "area": 0, "mean_roughness": 3, "n_S_percent": 1}  # columns of ensemble.csv, decimals


def ensemble_page(name: str, table: pd.DataFrame, combination: Sequence[float]) -> dict[str, Any]:
    """Collect the values of the page of ensemble.csv."""
    readings = readings_of_columns(table, "d_")
    columns = MEASURED | {f"d_{reading}": 2 for reading in readings}
    return {
        "name": name,
        "frames": len(table),
        "combination": str(Combination(*map(float, combination))),
        "d": {
            reading: [number(x) for x in table[f"d_{reading}"].agg(["mean", "std"])] for reading in readings
        },
        "n_S": [number(x, 1) for x in table["n_S_percent"].agg(["mean", "std"])],
        "rows": [
            (column, [number(x, digits) for x in table[column].agg(["mean", "std", "min", "max"])])
            for column, digits in columns.items()
        ],
    }
