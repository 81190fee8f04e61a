"""Tables of many structures: joined, summed up and stored."""

import re
from pathlib import Path

import pandas as pd

USED = re.compile(r"^USED (\d+) MB ([\d.]+) s for ([\d.]+) MB$", re.M)


def joined(paths):
    """The tables of several files, one below the other; 1E96 is a complex, no number."""
    names = dict.fromkeys(["complex", "protein"], str)
    return pd.concat([pd.read_csv(path, dtype=names) for path in paths], ignore_index=True)


def store(tables, outputs, decimals="%.5g"):
    """Write tables to the outputs of a rule, by their names."""
    for name, table in tables.items():
        table.to_csv(outputs[name], index=False, float_format=decimals)


def of_logs(*folders):
    """What the jobs of a chain took, from their logs: rule, jobs, cpu_hours, most_mb of one."""
    rows = []
    for log in (log for folder in folders for log in Path(folder).rglob("*.log")):
        for megabytes, seconds, _ in USED.findall(log.read_text(encoding="utf-8"))[-1:]:
            rows.append((log.stem, float(seconds) / 3600, float(megabytes)))
    table = pd.DataFrame(rows, columns=["rule", "cpu_hours", "mb"]).groupby("rule")
    return table.agg(jobs=("mb", "size"), cpu_hours=("cpu_hours", "sum"), most_mb=("mb", "max")).reset_index()
