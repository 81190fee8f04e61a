"""Tables of many structures: reading, writing, and CPU time from logs."""

import re
from collections.abc import Iterable
from pathlib import Path

import pandas as pd

USED = re.compile(r"^USED (\d+) MB ([\d.]+) s", re.M)  # the last line of a job's log


def read_tables(paths: Iterable[str]) -> pd.DataFrame:
    """Read several tables and put one below the other; names such as 1E96 stay strings."""
    names = dict.fromkeys(["complex", "protein"], str)
    return pd.concat([pd.read_csv(path, dtype=names) for path in paths], ignore_index=True)


def write_tables(tables: dict[str, pd.DataFrame], float_format: str = "%.5g") -> None:
    """Write tables by their paths."""
    for path, table in tables.items():
        table.to_csv(path, index=False, float_format=float_format)


def cpu_table(*folders: str) -> pd.DataFrame:
    """Return resources that the jobs used according to the logs in folders: rule, jobs, cpu_hours, most_mb of one job."""
    rows = []
    for log in (log for folder in folders for log in Path(folder).rglob("*.log")):
        for megabytes, seconds in USED.findall(log.read_text(encoding="utf-8"))[-1:]:
            rows.append((log.stem, float(seconds) / 3600, float(megabytes)))
    table = pd.DataFrame(rows, columns=["rule", "cpu_hours", "mb"]).groupby("rule")
    return table.agg(jobs=("mb", "size"), cpu_hours=("cpu_hours", "sum"), most_mb=("mb", "max")).reset_index()
