"""Residues of predicted models that their pLDDT (confidence of 0 to 100, in the column of B factors) calls doubtful.

AlphaFold: Jumper et al., Nature 596:583 (2021). ModelCIF: https://mmcif.wwpdb.org/dictionaries/mmcif_ma.dic.
"""

from __future__ import annotations

import os
import re

import numpy as np
from gemmi import cif

from sparsurf.errors import InputError

TITLE = re.compile(r"(ALPHAFOLD|ESMFOLD).*PREDICTION")  # of a PDB file; experiments name AlphaFold elsewhere
CATEGORIES = ("_ma_qa_metric.", "_ma_model_list.", "_ma_data.")  # of a predicted model in an mmCIF file
MAX_PLDDT = 100.0


def pdb_has_plddt(lines: list[str]) -> bool | None:
    """Return whether a PDB file is a predicted model, whose B factors are then pLDDT; None if it is none."""
    title = " ".join(line[10:80].strip() for line in lines if line.startswith("TITLE "))
    return True if TITLE.search(title.upper()) else None


def mmcif_has_plddt(block: cif.Block) -> bool | None:
    """Return whether a predicted model says that it has pLDDT; None if the data block is not a predicted model."""
    if not any(block.get_mmcif_category_names().count(name) for name in CATEGORIES):
        return None
    metrics = [*block.find_values("_ma_qa_metric.name"), *block.find_values("_ma_qa_metric.type")]
    return any(cif.as_string(metric).lower() == "plddt" for metric in metrics)


def doubtful_residues(
    b_factor: np.ndarray,
    residue_index: np.ndarray,
    has_plddt: bool,
    bound: float,
    path: str | os.PathLike[str],
) -> np.ndarray:
    """Find the residues of a predicted model whose mean pLDDT is below a bound.

    Parameters
    ----------
    b_factor : (A,) float, of the atoms
    residue_index : (A,) int, residue of each atom, 0, 1, 2, ...
    has_plddt : bool, what the file says
    bound : float, 0 to 100
    path : named in messages

    Returns
    -------
    (A,) bool, atoms of these residues

    Raises
    ------
    InputError
        The file says that it has no pLDDT, or its B factors are none.
    """
    known = has_plddt and np.isfinite(b_factor).all() and b_factor.min() >= 0
    if not known or not 1 < b_factor.max() <= MAX_PLDDT or b_factor.min() == b_factor.max():
        raise InputError(
            f"{path} is a predicted model without pLDDT in its B factors: give the file as it was predicted, "
            "or remove `plddt`."
        )
    mean = np.bincount(residue_index, b_factor) / np.bincount(residue_index)
    return (mean < bound)[residue_index]
