"""Tables of many structures: reading and writing."""

from collections.abc import Iterable

import pandas as pd

GZIP = {"method": "gzip", "mtime": 0}  # the same bytes for the same table


def read_tables(paths: Iterable[str]) -> pd.DataFrame:
    """Read several tables and put one below the other; names such as 1E96 stay strings."""
    names = dict.fromkeys(["complex", "protein"], str)
    return pd.concat([pd.read_csv(path, dtype=names) for path in paths], ignore_index=True)


def write_tables(tables: dict[str, pd.DataFrame], float_format: str = "%.5g") -> None:
    """Write tables by their paths."""
    for path, table in tables.items():
        compression = GZIP if path.endswith(".gz") else None
        table.to_csv(path, index=False, float_format=float_format, compression=compression)
