"""`sparsurf frames`: area, roughness and fields of the residues in every frame of a trajectory."""

import argparse

from sparsurf import kinds
from sparsurf.api.points import JOBS
from sparsurf.api.replacing import beside_frames, path_of_frames
from sparsurf.arguments import STRIDE
from sparsurf.cli import options, outputs
from sparsurf.files import pluralise
from sparsurf.molecules.formats import TOPOLOGY_LABELS

FORMATS = kinds.suffixes("frames")
EXAMPLES = """\
FILE is the structure of the trajectory, or a file with several models. The
table has a row for each residue in each frame: frame (its position in the
file, from 0), time_ps, chain, residue, residue_name, area (Å^2),
mean_roughness (1 is flat, 0 is rough; blank for a buried residue), depth (Å)
and the mean of each field. A second table, run_frames.csv next to run.csv,
has a row for each frame: area (Å^2), volume (Å^3), components, cavities, dots
and mean_roughness. It replaces only such a table.

A run that was stopped continues when the same command is given again, and
writes the same bytes. Memory does not grow with the number of frames. Parquet
needs pyarrow.

examples:
  sparsurf frames protein.pdb --trajectory run.xtc -o run.csv
  sparsurf frames protein.pdb --trajectory run.xtc --jobs 4 -o run.parquet
  sparsurf frames models.pdb --fields hydropathy -o models.csv
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument(
        "file",
        metavar="FILE",
        help=f"structure of the trajectory (also {TOPOLOGY_LABELS}), or a file with several models",
    )
    text = f"file to write ({' '.join(FORMATS)}); the table of frames is written next to it, with _frames in its name"
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help=text)
    text = "measure every n-th frame (default 1, all frames)"
    parser.add_argument("--stride", type=options.number_within(STRIDE), default=1, metavar="N", help=text)
    options.add_fields(parser)
    options.add_molecule(parser, with_frame=False)
    options.add_placement(parser)
    text = "number of processes (default 1)"
    parser.add_argument("--jobs", type=options.number_within(JOBS), default=1, help=text)


def run(args: argparse.Namespace) -> None:
    """Write the tables."""
    outputs.check(args, FORMATS, beside_frames(args.output))
    from sparsurf.api.field_values import check_fields  # here: wrong arguments need no numba
    from sparsurf.api.frames import FramesRequest, write_frames
    from sparsurf.api.surfaces import placement

    names = check_fields(options.names_of_requested_fields(args), "frames", of_residues=True)
    molecule = options.read_atoms(args, args.stride)
    rules = placement(density="auto", **options.placement_options(args))
    n_frames, n_before = write_frames(molecule, FramesRequest(rules, names), args.output, args.jobs)
    text = f"{pluralise(molecule.n_residues, 'residue')} in {pluralise(n_frames, 'frame')}"
    text += f", of which {n_before} were finished before" if n_before else ""
    outputs.report(args, f"{text}; {path_of_frames(args.output)} has a row for each frame")
