"""Analyse the structures of a batch: surface, roughness, minimal subset and residues of each."""

from __future__ import annotations

import json
import logging
import traceback
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from sparsurf.errors import InputError
from sparsurf.evaluation.minimal_subset import represent
from sparsurf.messages import listening
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.progress import Report, unreported
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.components import summarize_components, table_of_components
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.surfaces.spacing import refuse_sparse, spacing
from sparsurf_study.batches.assignment import BATCH_FOLDERS
from sparsurf_study.batches.tables import pack_dots
from sparsurf_study.settings import name_in_config

log = logging.getLogger("sparsurf")


@dataclass(frozen=True)
class Structure:
    """A structure of a batch."""

    name: str  # protein as the config names it
    path: str  # of its file
    table: str | None = None  # file with fields of its own
    options: Mapping[str, Any] = field(default_factory=dict)  # keyword arguments of `read_molecule`


def analyse_structure(structure: Structure, settings: Settings, seed: int) -> dict[str, pd.DataFrame]:
    """Place dots on a structure, select its minimal subset and tabulate its residues: the tables of a batch, by name."""
    name, d_link = structure.name, settings.patches.d_link
    molecule = read_molecule(structure.path, **structure.options)
    if molecule.n_frames > 1:
        log.warning("%s: %d models; the first is taken", name, molecule.n_frames)
        molecule = molecule.frame(0)
    dots = surface_of_molecule(molecule, settings.surface, d_link, name)
    if settings.surface.density != "auto":
        refuse_sparse(dots.points, d_link, name)
    component = dots.known_components(name)
    found = represent(dots, settings, Streams(seed, name), molecule, table=structure.table)
    few = found.subset
    row = {
        "structure": structure.path,
        "options": json.dumps(dict(structure.options), sort_keys=True),
        "atoms": molecule.n_atoms,
        "residues": molecule.n_residues,
        "masked_residues": molecule.masked_residues,
        "N": len(dots),
        "area": dots.total_area,
        **summarize_components(table_of_components(dots)),
        "spacing": spacing(dots.points),
        "mean_roughness": float(found.roughness.mean()),
        "minimal_n_S": len(few),
        "minimal_n_S_percent": 100 * len(few) / len(dots),
    }
    kept = pack_dots(few.points, few.normals).assign(
        dot=few.dots, weight=few.weight, atom=few.surface.atom, **few.surface.fields
    )
    kept = kept.sort_values("dot", ignore_index=True)  # neighbours in space follow one another: smaller files
    tables = {"surfaces": pd.DataFrame([row]), "residues": found.residues(component), "dots": kept}
    return {key: table.assign(protein=name) for key, table in tables.items()}


def analyse_batch(
    structures: list[Structure],
    settings: Settings,
    seed: int,
    report: Report = unreported,
) -> dict[str, pd.DataFrame]:
    """Analyse the structures of a batch: tables by the names of `assignment.BATCH_FOLDERS`; a failure is a row of 'failures'."""
    tables: dict[str, list[pd.DataFrame]] = {name: [] for name in BATCH_FOLDERS}
    for done, structure in enumerate(structures, 1):
        heard: list[logging.LogRecord] = []
        with listening(heard.append):
            try:
                for name, table in analyse_structure(structure, settings, seed).items():
                    tables[name].append(table)
            except Exception as error:
                row = {"protein": structure.name, "reason": _reason(error, structure)}
                tables["failures"].append(pd.DataFrame([row]))
        sentences = dict.fromkeys(record.getMessage() for record in heard)
        rows = [{"protein": structure.name, "sentence": sentence} for sentence in sentences]
        tables["warnings"].append(pd.DataFrame(rows, columns=["protein", "sentence"]))
        report(done, len(structures))
    return {
        name: pd.concat(parts, ignore_index=True) if parts else pd.DataFrame()
        for name, parts in tables.items()
    }


def _reason(error: Exception, structure: Structure) -> str:
    """Return why a structure failed, in one sentence; the log has the traceback of a defect."""
    if isinstance(error, InputError):
        return error.worded(name_in_config)
    if isinstance(error, MemoryError):
        return f"{structure.path} needs more memory than there is: run it alone, on a larger machine."
    traceback.print_exc()
    return (
        f"A defect of this program ({type(error).__name__}: {error}). Please report it with {structure.path}."
    )
