"""Tables of a run in batches: Parquet files in one folder for each kind of table, one file for each batch."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.errors import InputError
from sparsurf.files import import_pyarrow
from sparsurf_study import columns

# By the types of columns in catalogue.yaml.
PARQUET_TYPES = {"int": "int32", "float": "float32", "text": "string"}
DOUBLE = "float64"  # The floats of the table of surfaces, which are few, keep this type.
STORED_STEPS_PER_ANGSTROM = 32  # steps of the places of dots
DEGREES = 2  # steps of the angles of normals
# Numbers are rounded to fractions that a float32 holds exactly, whose last bytes are zeros and take no space
RESIDUE_STEP = 1 / 1024  # Å^2 of areas, 1 of roughness
ROUNDING_STEPS = {
    "residues": dict.fromkeys(
        ("area", "area_contact", "area_saddle", "area_concave", "mean_roughness", "most_rough"), RESIDUE_STEP
    ),
}
# The encoding of Parquet that makes each column smallest; the others repeat values and have a dictionary
ENCODINGS = {
    "dots": dict.fromkeys(("dot", "x32", "y32", "z32", "atom"), "DELTA_BINARY_PACKED"),
    "residues": dict.fromkeys(("dots", "cavity_dots", "kept", "weight"), "DELTA_BINARY_PACKED")
    | dict.fromkeys(ROUNDING_STEPS["residues"], "BYTE_STREAM_SPLIT")
    | {"residue": "PLAIN"},
}
ZSTD_LEVEL = 19


def columns_of_batch(table: str, fields: Sequence[str] = ()) -> dict[str, str]:
    """Return the columns of a table with their types, from catalogue.yaml; `fields` are those of the config."""
    types = PARQUET_TYPES | ({"float": DOUBLE} if table == "surfaces" else {})
    listed = columns.tables()[f"{table}/<batch>.parquet"].columns
    of_fields = {"residues": [f"mean_{name}" for name in fields], "dots": fields}.get(table, ())
    described = {column.name: types[column.type] for column in listed if "<" not in column.name}
    return described | dict.fromkeys(of_fields, types["float"])


def pack_dots(points: np.ndarray, normals: np.ndarray) -> pd.DataFrame:
    """Round places to 1/32 Å and normals to ° (to z, and around z from x): a third of the bytes; see `unpack_dots`."""
    table = pd.DataFrame(
        np.rint(points * STORED_STEPS_PER_ANGSTROM).astype(np.int32), columns=["x32", "y32", "z32"]
    )
    polar = np.degrees(np.arccos(np.clip(normals[:, 2], -1, 1)))
    azimuth = np.degrees(np.arctan2(normals[:, 1], normals[:, 0]))
    table["polar"] = (np.rint(polar / DEGREES) * DEGREES).astype(np.int32)
    table["azimuth"] = (np.rint(azimuth / DEGREES) * DEGREES % 360).astype(np.int32)
    return table


def unpack_dots(table: pd.DataFrame) -> tuple[np.ndarray, np.ndarray]:
    """Return the points (N, 3) in Å and the normals (N, 3) of a table of dots, see `pack_dots`."""
    polar, azimuth = np.radians(table[["polar", "azimuth"]].to_numpy(float)).T
    around = np.sin(polar)
    normals = np.column_stack([around * np.cos(azimuth), around * np.sin(azimuth), np.cos(polar)])
    return table[["x32", "y32", "z32"]].to_numpy(float) / STORED_STEPS_PER_ANGSTROM, normals


def write_parquet(path: str | Path, table: str, rows: pd.DataFrame, fields: Sequence[str] = ()) -> None:
    """Write the rows of one batch, rounded to `ROUNDING_STEPS`; a table without rows also has all columns."""
    pyarrow = import_pyarrow()
    types = columns_of_batch(table, fields)
    schema = pyarrow.schema([(name, pyarrow.type_for_alias(kind)) for name, kind in types.items()])
    encodings = ENCODINGS.get(table, {})
    steps = ROUNDING_STEPS.get(table, {}) if len(rows) else {}
    rows = rows.assign(**{name: (rows[name] / step).round() * step for name, step in steps.items()})
    content = schema.empty_table()
    if len(rows):
        content = pyarrow.Table.from_pandas(rows.reindex(columns=list(types)), schema, preserve_index=False)
    content = content.replace_schema_metadata(None)
    pyarrow.parquet.write_table(
        content,
        path,
        compression="zstd",
        compression_level=ZSTD_LEVEL,
        use_dictionary=[name for name in types if name not in encodings],
        column_encoding=encodings or None,
    )


def read_parquet(run: str | Path, table: str, protein: str | None = None) -> pd.DataFrame:
    """Read one of `assignment.BATCH_FOLDERS` of a run (results/<run>), of all batches or of one protein."""
    import_pyarrow()
    folder = Path(run, table)
    if not any(folder.glob("*.parquet")):
        raise InputError(f"{run} holds no {table}/*.parquet: name the results of a study in batches.")
    filters = None if protein is None else [("protein", "==", protein)]
    try:
        return pd.read_parquet(folder, filters=filters)
    except (OSError, ValueError) as error:
        reason = str(error).partition("\n")[0][:200]
        raise InputError(f"{folder} is damaged ({reason}): run the study again.") from None


def locate_structure(run: str | Path, path: str) -> Path:
    """Find the file of a structure of a study; its path starts at the folder of the study or at the current one."""
    candidates = [Path(path), Path(run).resolve().parents[1] / path]
    file = next((file for file in candidates if file.is_file()), None)
    if file is None:
        raise InputError(
            f"{path} does not exist any more: put the structure back, or run this from the folder of the study."
        )
    return file
