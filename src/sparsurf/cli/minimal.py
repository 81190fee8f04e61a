"""`sparsurf minimal`: the few dots that represent a surface."""

from __future__ import annotations

import argparse
from typing import Any

import sparsurf
from sparsurf.api import writing
from sparsurf.arguments import AUTO, MODELS, SPHERES
from sparsurf.cli import options, outputs
from sparsurf.registry import COVER
from sparsurf.registry import label as label_of
from sparsurf.views.numbers import decimals, number, share

SIZES = ("percent", "n_dots", "density", "error", "max_z")
FORMATS = writing.OUTPUTS_OF_DOTS_ALONE
WIDE = 2.5  # ratio of the ends of an interval, of the number of dots, that calls for a fixed share

EXAMPLES = """\
By default, the command keeps few dots from which the surface is reconstructed with a mean error of 0.02 Å and a 99 %
error of 0.1 Å (see --error and --error-99). The error is the distance of independent dots of the whole surface from the surface
that `sparsurf recover` reconstructs from the kept ones. If a number of dots is requested, it is that of `sparsurf recover
--reconstruction interpolant`, and `sparsurf recover` alone may have a smaller one. For a file of dots, whose atoms are not
known, it is the distance of the dots that are not kept.

Where an error of at most 0.12 Å is requested of a structure, the atoms are inferred from the kept dots (--sampler cover): 0.12 to
0.15 dots per Å^2 are enough for the default, and about 0.2 if the molecule has explicit hydrogens. Such dots serve this
reconstruction alone: do not drop some of them at random. Three errors are bounded: the mean error, the distance within which 99 %
of the true surface lies from the reconstructed one, and that within which 99 % of the reconstructed surface lies from the true
one. The command prints all three, measured on the surface that it reconstructs, and which of them is nearest to its limit: a
larger limit of this one keeps fewer dots. With --error-99 inf, only the mean error is bounded. All other requests keep evenly
spread dots (--sampler farthest), whose number for an error is an estimate that is printed with its 95 % interval. Only the
samplers of the paper use the roughness. Z is the mean distance between the descriptors of a patch on the full surface and on the
kept dots.

The table has a row for each kept dot: `dot` is its number on the surface, from 0; `weight` is the number of dots that it
represents; `area` is the area of the surface that is nearer to it than to the other kept dots, in Å^2; `spacing` is the distance
between the kept dots around it, in Å; and `reach` says how far the surface extends around it, as a multiple of this spacing.
A .pml file opens the dots on their molecule in PyMOL, and a .bild file opens them as spheres in ChimeraX.
A .html file is a page, and a .png file is a picture, of the kept dots on the surface.

examples:
  sparsurf minimal protein.pdb -o minimal.csv
  sparsurf minimal protein.pdb --n-dots 500 --sampler poisson -o minimal.ply
  sparsurf minimal protein.pdb --percent 10 -o protein.npz
  sparsurf minimal protein.pdb --density 0.6 -o minimal.csv
  sparsurf minimal protein.pdb -o minimal.pml
  sparsurf minimal protein.pdb --percent 10 -o minimal.html
  sparsurf minimal protein.pdb --error 0.05 -o minimal.csv
  sparsurf minimal protein.pdb --reconstruction interpolant -o few.csv
  sparsurf minimal dots.csv --max-z 1.0 -o minimal.npz
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    options.add_file(parser, "structure or dots")
    options.add_output(parser, FORMATS)
    size = parser.add_mutually_exclusive_group()
    for name in SIZES:
        options.add(size, name)
    parser.add_argument(
        "--sampler",
        choices=options.Names("sampler", AUTO),
        metavar="SAMPLER",
        default=AUTO,
        help="method that chooses the dots: %(choices)s (default auto: cover for an error of a structure of at most 0.12 Å,"
        " else farthest)",
    )
    options.add(parser, "error_99")
    options.add(parser, "seed", has_default=True)
    options.add_fields(parser)
    options.add_limits(parser)
    options.add(parser, "d_link", has_default=True)
    meaning = (
        f"how the surface is reconstructed where its error is measured: {', '.join(MODELS)} (default auto)"
    )
    options.add_reconstruction(parser, meaning)
    options.add_molecule(parser)
    options.add_placement(parser, " keep", "reentrant")


def run(args: argparse.Namespace) -> None:
    """Write the chosen dots."""
    outputs.check(args, FORMATS)
    surface, molecule = options.read_dots(args)
    options.say(f"choosing among {len(surface):,} dots")
    surface = options.with_requested_fields(args, surface, molecule)
    arguments = *SIZES, "sampler", "reconstruction", "error_99", "d_link", "seed"
    few = sparsurf.minimal(surface, **options.given(args, *arguments))
    message = _message(few) if outputs.is_reported(args) else ""
    about = options.about(args, whole=surface, notes=few.decision)
    shown = next(iter(few.surface.fields)) if args.fields else "weight"
    outputs.write_output(
        args, writing.DotsToWrite(few.surface, few.columns(), shown, message=message, about=about)
    )


def share_kept(kept: int, n: int, interval: tuple[float, float] | None) -> str:
    """Return the share of the dots that are kept, with two digits of the smallest number at least."""
    percent, *ends = (100 * value / n for value in (kept, *(interval or ())))
    if not ends:
        return f"{share(percent) if percent >= 1 else number(percent, decimals(percent, 1))} %"
    text, low, high = (number(value, decimals(min(ends), 1)) for value in (percent, *ends))
    return f"{text} %; 95 % interval {low} to {high} %"


def _message(few: sparsurf.Subset) -> str:
    """Return what is reported of a subset."""
    n, density, errors = int(few.weight.sum()), few.density, None
    if len(few) < n and few.measure_errors is not None:
        options.say(f"errors of the surface of {len(few):,} dots")
        errors = few.measure_errors(everywhere=True).iloc[0]
        density = errors["density"]  # also of dots without areas
    label = label_of("sampler", few.sampler)
    chosen = f"chosen by {label}"
    if few.sampler == COVER:
        chosen = label if few.determines_atoms else "too few to determine the atoms"
    kept = f"{share_kept(len(few), n, few.interval)}; {number(density, decimals(density, 2))} per Å^2"
    message = f"{len(few):,} of {n:,} dots ({kept}), {chosen}"
    if few.interval and few.interval[1] > WIDE * few.interval[0]:
        message += ". The interval is wide: --percent keeps a fixed share"
    return message if errors is None else "\n".join([message, _error(errors), *few.decision])


def _error(errors: Any) -> str:
    """Return the sentences on the errors of the surface that is reconstructed from a subset."""
    is_rebuilt, average = errors["reconstruction"] == SPHERES, errors["Z_mean_patch"]
    surface = (
        "rebuilt on the atoms that these dots determine" if is_rebuilt else "interpolated between these dots"
    )
    worse = " These dots describe a patch worse than the mean patch does: keep more."
    return (
        f"The surface {surface} deviates by {errors['mean']:.4f} Å on average (99 %: "
        f"{errors['high_99']:.4f} Å, largest: {errors['largest']:.2f} Å; measured on {errors['measured_on']}). "
        f"99 % of it lies within {errors['back_99']:.4f} Å of the true surface.\n"
        f"Its Z is {errors['Z_published']:.2f}: "
        f"an identical surface has a Z of 0, and the mean patch in place of every patch has a Z of {average:.2f}."
        + (worse if errors["Z_published"] > average else "")
    )
