"""The tables that a study has written for each of its proteins."""

from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import pandas as pd

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.analysis.summary import SurfaceResult, read_result

READING_OF_MEASURE = {"Z full": "full", "Z recovered": "recovered"}  # of compare.csv


class Measured(NamedTuple):
    """One protein of a study, its first conformation.

    result : sparsurf_study.analysis.summary.Result
    floors : DataFrame, floors.csv
    by_n_s : DataFrame: sampler, percent (requested), n_S, n_S_percent, reading, Z
    """

    result: SurfaceResult
    floors: pd.DataFrame
    by_n_s: pd.DataFrame


def read_study(run: str | Path, proteins: list[str], reading: str | None = None) -> list[Measured]:
    """Read the results of each protein of a run, `run`/<protein>/c1, in the order of their numbers of dots.

    With a `reading`, only the ranges of n_S of this reading.
    """
    measured = [_read_conformation(Path(run, protein, "c1")) for protein in proteins]
    if reading:
        measured = [protein._replace(result=_only(protein.result, reading)) for protein in measured]
    return sorted(measured, key=lambda protein: (protein.result.n_dots, protein.result.protein))


def _only(result: SurfaceResult, reading: str) -> SurfaceResult:
    """Return a result with the ranges of one reading."""
    return replace(result, ranges=result.ranges[result.ranges["reading"] == reading])


def _read_conformation(folder: Path) -> Measured:
    """Read the results of one conformation."""
    compared = folder / "compare.csv"
    curves = by_n_s(pd.read_csv(compared)) if compared.is_file() else pd.DataFrame()
    return Measured(read_result(folder), pd.read_csv(folder / "floors.csv"), curves)


def by_n_s(compared: pd.DataFrame) -> pd.DataFrame:
    """Return Z of every sampler and n_S of a compare.csv, for the dots as they are and for the recovered surface."""
    rows = compared[compared["measure"].isin(READING_OF_MEASURE)]
    table = rows[["sampler", "percent", "n_S", "n_S_percent"]]
    reading = rows["measure"].map(READING_OF_MEASURE)
    return table.assign(reading=reading, Z=rows["value"]).reset_index(drop=True)


def sizes(run: str | Path, proteins: list[str]) -> pd.DataFrame:
    """Return atoms and residues of each protein: protein, n_atoms, n_residues."""
    rows = []
    for protein in proteins:
        molecule = read_molecule(Path(run, protein, "c1", "structure.pdb"), selection="all", whole=False)
        rows.append((protein, int(molecule.n_atoms), int(molecule.n_residues)))
    return pd.DataFrame(rows, columns=["protein", "n_atoms", "n_residues"])
