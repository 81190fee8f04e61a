"""`sparsurf frames`: area, roughness and fields of the residues in every frame of a trajectory."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

import sparsurf
from sparsurf import registry
from sparsurf.api.replacing import beside_frames, path_of_frames
from sparsurf.arguments import ARGUMENTS, RANK_BY
from sparsurf.cli import options, outputs
from sparsurf.files import pluralise
from sparsurf.molecules.formats import TOPOLOGY_LABELS

if TYPE_CHECKING:
    import pandas as pd

FORMATS = registry.suffixes("frames")
N_REPORTED = 5  # residues that change most
EXAMPLES = """\
FILE is the structure of the trajectory, or a file with several models. The
table has a row for each residue in each frame: frame (its position in the
file, from 0), time_ps, chain, residue, residue_name, area (Å^2),
mean_roughness (1 is flat, 0 is rough; blank for a buried residue), depth (Å),
the exact areas of `sparsurf areas` (accessible, relative, buried) and the mean
of each field. Three more tables are written next to run.csv, where
they replace only such tables. run_frames.csv has a row for each frame: area
(Å^2), volume (Å^3), components, cavities, dots, mean_roughness, accessible and
buried (Å^2).
run_ranking.csv has a row for each residue, and the residue whose roughness
changes most over the frames comes first; --rank and --rank-by choose another
column or field, and the range in place of the standard deviation. Roughness
and fields of a residue count in frames in which it has at least 20 Å^2; areas
and depths are ranked if it has as much in the mean. Residues with a value in
fewer than half of the frames come last and have no rank.
run_contacts.csv says what touches what: a row for each residue and each partner
that buries some of it, with the share of the frames in which this is at least
1 Å^2 (occupancy), and the mean and highest buried area (Å^2). Partners are those
of `sparsurf areas`: each chain of polymers and each ligand that --ligands (all, or
names) reads, or --groups. In the rows of a ligand, the column buried is what all
of its partners bury of it in each frame, other ligands included; --groups A,B+LIG
names the protein alone.

--only-areas leaves out the dots: the tables then have the columns accessible,
relative and buried of residues, the sums of frames, the contacts, and a ranking by
one of these columns (accessible, unless --rank says otherwise).

--start 100 --stop 500 uses the frames at the positions 100 to 499, and --stride 10
every tenth of them.

A run that was stopped continues when the same command is given again, and
writes the same bytes. Memory does not grow with the number of frames. Parquet
needs pyarrow.

examples:
  sparsurf frames protein.pdb --trajectory run.xtc -o run.csv
  sparsurf frames protein.pdb --trajectory run.xtc --jobs 4 -o run.parquet
  sparsurf frames protein.pdb --trajectory run.xtc --only-areas -o run.csv
  sparsurf frames protein.pdb --trajectory run.xtc --rank area -o run.csv
  sparsurf frames protein.pdb --trajectory run.xtc --ligands all -o run.csv
  sparsurf frames top.pdb --trajectory run.xtc --start 100 --stop 500 -o run.csv
  sparsurf frames models.pdb --fields hydropathy -o models.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    text = f"structure of the trajectory (also {TOPOLOGY_LABELS}), or a file with several models"
    options.add_file(parser, text)
    text = f"file to write ({' '.join(FORMATS)}); tables are written next to it, with _frames, _ranking and _contacts added"
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help=text)
    for name in ("stride", "start", "stop"):
        options.add(parser, name, has_default=True, metavar="N")
    options.add_groups(parser)
    options.add_fields(parser, has_table=False)
    options.add_ranking(parser)
    options.add_molecule(parser, with_frame=False)
    options.add_placement(parser)
    parser.add_argument("--only-areas", action="store_true", default=None, help=ARGUMENTS["only_areas"].words)
    options.add(parser, "jobs", has_default=True)


def run(args: argparse.Namespace) -> None:
    """Write the tables."""
    outputs.check(args, FORMATS, beside_frames(args.output))
    from sparsurf.api.field_values import check_ranked_fields  # here: a mistake in the output needs no numpy

    fields = options.names_of_requested_fields(args)
    _, rank = check_ranked_fields(
        fields, args.rank, "frames", bool(args.only_areas)
    )  # before a trajectory is read
    molecule = options.read_atoms(args, {name: getattr(args, name) for name in ("stride", "start", "stop")})
    ranking = options.given(args, "rank", "rank_by", "groups", "only_areas", "jobs")
    rules = options.placement_options(args)
    written = sparsurf.frames(molecule, path=args.output, fields=fields, **ranking, **rules)
    text = f"{pluralise(molecule.n_residues, 'residue')} in {pluralise(written.n_frames, 'frame')}"
    text += f", of which {written.n_before} were finished before" if written.n_before else ""
    tables = f"{path_of_frames(args.output)} has a row for each frame, {path_of_frames(args.output, 'ranking')} for each residue"
    outputs.report(
        args, f"{text}; {tables}{_first(written.ranking, written.n_frames, rank, args.rank_by or RANK_BY)}"
    )


def _first(ranking: pd.DataFrame, n_frames: int, quantity: str, rank_by: str) -> str:
    """Say which residues change most; nothing if none is ranked."""
    from sparsurf.views.page.frames import STATISTICS  # here: wrong arguments need no numba
    from sparsurf.views.page.profile import labels_of

    changing = ranking.dropna(subset="rank").head(N_REPORTED)
    if changing.empty:
        return ""
    numbers = zip(labels_of(changing), changing[rank_by], changing["frames"], strict=True)
    named = ", ".join(f"{label} ({value:.2f} in {n} of {n_frames} frames)" for label, value, n in numbers)
    return f". The {quantity} changes most at {named}: {STATISTICS[rank_by]} over these frames"
