"""`sparsurf export`: the files of one structure from a run in batches."""

import argparse
import json
from pathlib import Path

import numpy as np

from sparsurf.batches.tables import columns_of, locate_structure, read_parquet, unpack_dots
from sparsurf.cli import outputs
from sparsurf.errors import InputError
from sparsurf.files import no_warnings
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report import viewer
from sparsurf.study.minimal_subset import subset_table
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.surface import Surface

BURIED = -1.0  # B factor of residues without dots
EXAMPLES = """\
RUN is the folder of the results of a study in batches, and NAME one of its structures. The folder gets minimal.csv and
minimal.ply (the minimal subset), residues.csv, structure_roughness.pdb (mean roughness of the residues as B factors) and
open.pml, which opens all of this in PyMOL. The structure is read again, so its file must still be there.

examples:
  sparsurf export results/many protein -o exported
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("run", metavar="RUN", help="folder of the results, such as results/many")
    parser.add_argument("name", metavar="NAME", help="structure, as the study names it")
    parser.add_argument("-o", "--output", metavar="FOLDER", help="folder for the files (default NAME)")


def run(args: argparse.Namespace) -> None:
    """Write the files of one structure."""
    surfaces = read_parquet(args.run, "surfaces", args.name)
    if surfaces.empty:
        failed = read_parquet(args.run, "failures", args.name)
        raise InputError(
            f"{args.name} failed: {failed['reason'].iloc[0]}"
            if len(failed)
            else f"{args.run} has no structure {args.name!r}; names are in the column protein of surfaces/."
        )
    row = surfaces.iloc[0]
    molecule = read_structure(args.run, row["structure"], json.loads(row["options"]))
    residues = read_parquet(args.run, "residues", args.name).drop(columns="protein")
    dots = read_parquet(args.run, "dots", args.name).drop(columns="protein")
    if molecule.n_atoms != row["atoms"] or len(residues) != molecule.n_residues:
        raise InputError(f"{row['structure']} has changed since the study: run the study again.")
    args.output = args.output or args.name
    folder = Path(args.output)
    folder.mkdir(parents=True, exist_ok=True)
    fields = [str(name) for name in list(dots)[len(columns_of("dots")) - 1 :] if dots[name].notna().any()]
    kept = Surface(
        *unpack_dots(dots),
        atom=dots["atom"].to_numpy(),
        fields={name: dots[name].to_numpy(float) for name in fields},
    )
    table = subset_table(dots["dot"].to_numpy(), dots["weight"].to_numpy(), kept, molecule)
    table = table.assign(**kept.fields)
    write_csv(folder / "minimal.csv", table, fields)
    columns = {key: table[key].to_numpy(float) for key in ("spacing", "reach")} | kept.fields
    write_ply(folder / "minimal.ply", kept, table["weight"].to_numpy(float), "weight", columns)
    residues.to_csv(folder / "residues.csv", index=False)
    roughness = np.nan_to_num(residues["mean_roughness"].to_numpy(float), nan=BURIED)
    molecule.write_pdb(folder / "structure_roughness.pdb", b_factor=roughness[molecule.residue_index])
    script = Path(viewer.__file__).with_name("open.pml").read_text(encoding="utf-8")
    (folder / "open.pml").write_text(script, encoding="utf-8")
    outputs.report(args, f"{len(dots):,} dots and {len(residues):,} residues of {args.name}")


def read_structure(run: str, path: str, options: dict) -> Molecule:
    """Read the structure of a study again."""
    file = locate_structure(run, path)
    with no_warnings():
        molecule = read_molecule(file, **options)
    return molecule if molecule.n_frames == 1 else molecule.frame(0)
