"""Residues of predicted models that their pLDDT (confidence, in the column of B factors) calls doubtful.

AlphaFold: Jumper et al., Nature 596:583 (2021). ModelCIF: https://mmcif.wwpdb.org/dictionaries/mmcif_ma.dic.

An input is of one origin: PREDICTED with pLDDT in its B factors, a MODEL that names other scores, an EXPERIMENT, or
unknown (an empty string). Many predictors, and programs that store a file again, say nothing: pLDDT is then recognised by
its values, which are the same for all atoms of a residue.
"""

from __future__ import annotations

import logging
import re

import numpy as np
from gemmi import cif

from sparsurf.errors import FILE, InputError, argument

log = logging.getLogger("sparsurf")

PREDICTED, MODEL, EXPERIMENT = "predicted", "model", "experiment"
PREDICTORS = re.compile(
    r"\b((ALPHA|COLAB|ESM|OPEN|OMEGA|UNI|ROSETTA|HELIX|INTELLI|IG)[- ]?FOLD|BOLTZ|CHAI[- ]?(1|2|LAB|DISCOVERY)|"
    r"PROTENIX|PLDDT)"
)
OTHER_MODELS = re.compile(r"\b(SWISS[- ]?MODEL|MODELLER|I-?TASSER|PHYRE)")
OF_PREDICTION = ("TITLE ", "HEADER", "COMPND", "REMARK", "EXPDTA", "METHOD", "PARENT")
# resolution, refinement, collection of data
OF_EXPERIMENT = re.compile(r"REMARK +([23]\b.*\S|2(00|1[057]|30|4[057])\b)")
THEORY = re.compile("THEORETICAL|MODEL|PREDICT|SILICO|COMPUTATION|SIMULATION")
NO_EXPERIMENT = re.compile(rf"{THEORY.pattern}|NULL|^\W*$")
PREDICTED_CATEGORIES = ("_ma_qa_metric.", "_ma_model_list.", "_ma_data.")
EXPERIMENTAL_CATEGORIES = (
    "_refine.",
    "_reflns.",
    "_em_3d_reconstruction.",
    "_diffrn.",
    "_pdbx_nmr_ensemble.",
)
MAX_PLDDT = 100.0
# Where nothing says that they are pLDDT: share of the residues with one value for all atoms, their number, the largest value
MIN_CONSTANT_SHARE, MIN_RESIDUES, MIN_LARGEST = 0.9, 3, 20.0


def origin_of_pdb(lines: list[str], has_box: bool) -> str:
    """Return the origin of a PDB file from the records beside its atoms."""
    methods = [line[10:80].upper() for line in lines if line.startswith("EXPDTA")]
    measured = any(OF_EXPERIMENT.match(line) for line in lines)
    texts = [
        "PLDDT" if line.startswith("PARENT") else line[6:80].upper()
        for line in lines
        if line.startswith(OF_PREDICTION)
    ]
    return _origin(methods, measured, texts, has_box)


def origin_of_mmcif(block: cif.Block, has_box: bool) -> str:
    """Return the origin of a data block."""
    categories = block.get_mmcif_category_names()
    if any(name in categories for name in PREDICTED_CATEGORIES):
        metrics = [*block.find_values("_ma_qa_metric.name"), *block.find_values("_ma_qa_metric.type")]
        return PREDICTED if any("plddt" in cif.as_string(metric).lower() for metric in metrics) else MODEL
    methods = [cif.as_string(value).upper() for value in block.find_values("_exptl.method")]
    measured = any(name in categories for name in EXPERIMENTAL_CATEGORIES)
    items = ("_struct.title", "_software.name", "_entry.id", "_struct.pdbx_model_details")
    texts = [cif.as_string(value).upper() for item in items for value in block.find_values(item)]
    return _origin(methods, measured, [text.replace("_", " ") for text in texts], has_box)


def _origin(methods: list[str], measured: bool, texts: list[str], has_box: bool) -> str:
    """Return the origin: what was measured wins over the name of a predictor, and this over another program and a box."""
    measured &= not any(map(THEORY.search, methods))
    if measured or any(not NO_EXPERIMENT.search(method) for method in methods):
        return EXPERIMENT
    if any(map(PREDICTORS.search, texts)):
        return PREDICTED
    return MODEL if any(map(OTHER_MODELS.search, texts)) else EXPERIMENT if has_box else ""


def doubtful_residues(
    b_factor: np.ndarray,
    residue_index: np.ndarray,
    origin: str,
    bound: float,
    polymer: np.ndarray | None = None,
) -> np.ndarray | None:
    """Find the atoms (A,) of residues whose mean pLDDT, 0 to 100 or 0 to 1, is below a bound; None if it does not apply.

    Say whether it was applied. A predicted model without pLDDT is refused. `polymer` (A,) marks residues with one pLDDT each.
    """
    if origin == EXPERIMENT:
        log.info("%s: plddt is not applied to an experimental structure", FILE)
        return None
    finite = np.isfinite(b_factor).all() and len(b_factor) > 0
    possible = finite and 0 <= b_factor.min() < b_factor.max() <= MAX_PLDDT
    if origin and not (possible and origin == PREDICTED):
        raise InputError(
            f"{FILE} is a predicted model without pLDDT in its B factors: give the file as it was predicted, "
            f"or remove `{argument('plddt')}`."
        )
    scale = MAX_PLDDT if possible and b_factor.max() <= 1 else 1.0
    atoms = slice(None) if polymer is None else polymer
    if not origin:
        constant = possible and _is_constant(b_factor[atoms], residue_index[atoms])
        flags = possible and np.isin(b_factor, (0, 1)).all()
        if flags or not (constant or (possible and scale > 1)):
            message = "%s: plddt is not applied; the file does not say what its B factors are, and they do not look like pLDDT"
            log.warning(message, FILE)
            return None
        message = "%s does not say what its B factors are; they are read as pLDDT, since %s"
        reason = "all atoms of a residue have the same" if constant else "none is above 1"
        log.warning(message, FILE, reason)
    if scale > 1:
        log.warning("%s: its pLDDT is on a scale of 0 to 1, and is multiplied by 100", FILE)
    mean = np.bincount(residue_index, b_factor * scale) / np.bincount(residue_index)
    return (mean < bound)[residue_index]


def _is_constant(b_factor: np.ndarray, residue_index: np.ndarray) -> bool:
    """Return whether the atoms of most residues have one value, and the residues several."""
    order = np.argsort(residue_index, kind="stable")
    values, index = b_factor[order], residue_index[order]
    start = np.flatnonzero(np.append(True, np.diff(index) != 0))
    constant = np.maximum.reduceat(values, start) == np.minimum.reduceat(values, start)
    several = np.diff([*start, len(values)]) > 1
    has_evidence = several.sum() >= MIN_RESIDUES and (values.max() > MIN_LARGEST or values.max() <= 1)
    return bool(has_evidence and constant[several].mean() >= MIN_CONSTANT_SHARE)
