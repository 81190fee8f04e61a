"""What a study has measured on each of its proteins: its tables, read again."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.study.summary import Result, read_result

CURVES = {"Z as_written": "as_written", "Z recovered": "recovered"}  # measures of compare.csv: the readings


class Measured(NamedTuple):
    """One protein of a study, its first conformation.

    result : sparsurf.study.summary.Result
    floors : DataFrame, floors.csv
    by_n_s : DataFrame: sampler, percent (requested), n_S, n_S_percent, reading, Z
    """

    result: Result
    floors: pd.DataFrame
    by_n_s: pd.DataFrame


def measured(run, names, reading=None):
    """`Measured` of each protein of a run, by the number of dots; results/<run>/<name>/c1.

    With a `reading`, the ranges of n_S of that one alone.
    """
    found = [_measured(Path(run, name, "c1")) for name in names]
    if reading:
        found = [each._replace(result=_under(each.result, reading)) for each in found]
    return sorted(found, key=lambda each: (each.result.n_dots, each.result.protein))


def _under(result, reading):
    return replace(result, ranges=result.ranges[result.ranges["reading"] == reading])


def _measured(folder):
    compared = folder / "compare.csv"
    curves = by_n_s(pd.read_csv(compared)) if compared.is_file() else pd.DataFrame()
    return Measured(read_result(folder), pd.read_csv(folder / "floors.csv"), curves)


def by_n_s(compared):
    """Z of every sampler and n_S of a compare.csv, as the dots are and recovered."""
    own = compared[compared["measure"].isin(CURVES)]
    table = own[["sampler", "percent", "n_S", "n_S_percent"]]
    return table.assign(reading=own["measure"].map(CURVES), Z=own["value"]).reset_index(drop=True)


def sizes(run, names):
    """Atoms and residues of each protein: protein, n_atoms, n_residues."""
    rows = []
    for name in names:
        molecule = read_molecule(Path(run, name, "c1", "structure.pdb"), selection="all", whole=False)
        rows.append((name, int(molecule.n_atoms), int(molecule.n_residues)))
    return pd.DataFrame(rows, columns=["protein", "n_atoms", "n_residues"])
