"""The files of one structure from a run in batches."""

import json
from pathlib import Path

import numpy as np

from sparsurf.errors import InputError
from sparsurf.evaluation.minimal_subset import subset_columns
from sparsurf.messages import no_warnings
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.formats.colours import scale_of
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.surface import Surface
from sparsurf_study.batches.tables import columns_of_batch, locate_structure, read_parquet, unpack_dots
from sparsurf_study.report.scenes import script_text

B_FACTOR_OF_BURIED = -1.0  # B factor of residues without dots


def export_structure(run: str, name: str, folder: str | Path) -> str:
    """Write the files of one structure of a run in batches into a folder; return how much that is, in words.

    They are minimal.csv and minimal.ply (the minimal subset), residues.csv, structure_roughness.pdb (mean roughness of the
    residues as B factors) and open.pml, which opens all of this in PyMOL. The structure is read again, so its file must still
    be there; InputError says so if it is gone or has changed, and why a structure that failed has no files.
    """
    surfaces = read_parquet(run, "surfaces", name)
    if surfaces.empty:
        failed = read_parquet(run, "failures", name)
        raise InputError(
            f"{name} failed: {failed['reason'].iloc[0]}"
            if len(failed)
            else f"{run} has no structure {name!r}; names are in the column protein of surfaces/."
        )
    row = surfaces.iloc[0]
    molecule = read_structure(run, row["structure"], json.loads(row["options"]))
    residues = read_parquet(run, "residues", name).drop(columns="protein")
    dots = read_parquet(run, "dots", name).drop(columns="protein")
    if molecule.n_atoms != row["atoms"] or len(residues) != molecule.n_residues:
        raise InputError(f"{row['structure']} has changed since the study: run the study again.")
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    # Behind the columns that every run has, without protein, stand the fields that this study requested
    fields = [
        str(name) for name in list(dots)[len(columns_of_batch("dots")) - 1 :] if dots[name].notna().any()
    ]
    kept = Surface(
        *unpack_dots(dots),
        atom=dots["atom"].to_numpy(),
        fields={name: dots[name].to_numpy(float) for name in fields},
    )
    table = subset_columns(dots["dot"].to_numpy(), dots["weight"].to_numpy(), kept, molecule) | kept.fields
    write_csv(folder / "minimal.csv", table, fields)
    columns = {key: table[key] for key in ("spacing", "reach")} | kept.fields
    write_ply(folder / "minimal.ply", kept, scale_of("weight", table["weight"]), columns)
    residues.to_csv(folder / "residues.csv", index=False)
    roughness = np.nan_to_num(residues["mean_roughness"].to_numpy(float), nan=B_FACTOR_OF_BURIED)
    molecule.write_pdb(folder / "structure_roughness.pdb", b_factor=roughness[molecule.residue_index])
    (folder / "open.pml").write_text(script_text("open.pml"), encoding="utf-8")
    return f"{len(dots):,} dots and {len(residues):,} residues of {name}"


def read_structure(run: str, path: str, options: dict) -> Molecule:
    """Read the structure of a study again."""
    file = locate_structure(run, path)
    with no_warnings():
        molecule = read_molecule(file, **options)
    return molecule if molecule.n_frames == 1 else molecule.frame(0)
