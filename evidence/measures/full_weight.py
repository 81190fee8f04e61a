"""What roughness contributes to d where its weight is full (beta = 1), in place of the small weights of Table I."""

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures.null_result import MEAN, OWN, write_differences
from measures.tables import read_tables, write_tables
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.sampling.combination import PARAMETERS, PUBLISHED_ROWS
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf_study.analysis.relation import with_interval

FULL = 1.0
ALL_ROWS = "all"


def with_full_weight() -> np.ndarray:
    """Return the ten combinations of Table I with beta = 1."""
    rows = PUBLISHED_ROWS.copy()
    rows[:, PARAMETERS.index("beta")] = FULL
    return rows


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe what roughness contributes over proteins, by row and over all rows.

    Returns
    -------
    DataFrame: reading, rows (one, or 'all', whose mean of each protein counts once), n (proteins), n_S_percent, d (with R_i) and
    change (d with R_i less d with its mean) with their 95 % intervals over proteins, share_percent (mean change over mean d),
    n_cases (proteins and rows), n_lower and n_higher (cases in which roughness lowers and raises d, with a 95 % interval of the
    change that excludes 0)
    """
    keys = ["protein", "reading", "row"]
    own = table.loc[table["values"] == OWN, [*keys, "d", "n_S_percent"]]
    changes = table.loc[table["values"] == MEAN, [*keys, "change", "change_se"]]
    joined = own.merge(changes, on=keys)
    joined["sign"] = np.sign(joined["change"]) * (joined["change"].abs() > 1.96 * joined["change_se"])
    rows = []
    for reading, of_reading in joined.groupby("reading", sort=False):
        groups = [(str(row), part) for row, part in of_reading.groupby("row")]
        for name, part in [*groups, (ALL_ROWS, of_reading)]:
            of_proteins = part.groupby("protein", sort=False)[["n_S_percent", "d", "change"]].mean()
            row = {"reading": reading, "rows": name, "n": len(of_proteins)}
            row["n_S_percent"] = of_proteins["n_S_percent"].mean()
            row |= with_interval("d", of_proteins["d"]) | with_interval("change", of_proteins["change"])
            row["share_percent"] = 100 * of_proteins["change"].mean() / of_proteins["d"].mean()
            row |= {"n_cases": len(part), "n_lower": int((part["sign"] < 0).sum())}
            rows.append(row | {"n_higher": int((part["sign"] > 0).sum())})
    return pd.DataFrame(rows)


def measure_full_weight(job: Job) -> None:
    """Measure d of Table I with beta = 1 on one protein, with R and with its mean, at equal draws."""
    write_differences(job, "full weight", GRID_READINGS, with_full_weight(), (OWN, MEAN))


def tabulate_full_weight(job: Job) -> None:
    """Tabulate what roughness contributes at beta = 1 over proteins."""
    table = read_tables(job.input.tables)
    write_tables({job.output.table: table, job.output.means: means(table)})
