"""`sparsurf surface`: the dots of a molecule."""

from __future__ import annotations

import argparse
import os
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import sparsurf
from sparsurf.api import writing
from sparsurf.api.inputs import is_file_of_spheres
from sparsurf.api.page_metadata import heard
from sparsurf.api.replacing import beside_mesh
from sparsurf.arguments import BOUNDARIES
from sparsurf.cli import options, outputs
from sparsurf.errors import InputError
from sparsurf.files import pluralise

if TYPE_CHECKING:
    import numpy as np

COMPONENT = "component"  # column of the dots
FORMATS = writing.OUTPUTS_OF_DOTS
ACCESSIBLE = BOUNDARIES[1]
OF_DOTS = ("reentrant", "d_link", "groups")  # options that triangles have not
EXAMPLES = """\
The columns of a CSV are x,y,z,nx,ny,nz, area (Å^2), kind (0 contact, 1 saddle, 2 concave), component (0 is the largest), chain,
residue, residue_name, atom_name and atom (its index among the atoms that are read, from 0). A PLY of dots is a point cloud,
coloured by the first field, or by kind.
--residues writes the dots of some residues on the surface of the whole molecule. To compute the surface of a part of the molecule
alone, use --selection.
--mesh writes a closed mesh of triangles instead of dots. Its vertices lie on the surface, and two triangles share every edge.
For a NAME.vert, the triangles stand in a NAME.face next to it, which replaces only triangles of a NAME.vert.
A .html file is the page of `sparsurf show`, and a .png file is a picture; both show the first field, or the kinds of dots.
With --groups, the dots lie on the surface of the first group alone, and the field burial is their depth (Å) below the surface of
all groups together.
--boundary accessible places dots or triangles on the solvent-accessible surface, a probe radius outside of the atoms. They have
no component.
A cavity is an enclosed part of the surface that a probe can neither enter nor leave.

FILE may also hold radii (.xyzr .xyzrn .pqr) or the elements of a small molecule (.sdf .mol .mol2), which get radii of Bondi.

examples:
  sparsurf surface protein.pdb -o dots.ply
  sparsurf surface protein.pdb -o surface.png
  sparsurf surface protein.pdb --mesh -o mesh.ply
  sparsurf surface protein.pdb --cavities remove -o outside.ply
  sparsurf surface protein.pdb --fields hydropathy,potential -o dots.csv
  sparsurf surface protein.pdb --residues 209-214 -o site.csv
  sparsurf surface protein.pdb --selection 'residue 209 to 214' -o fragment.csv
  sparsurf surface protein.pdb --trajectory run.xtc --frame 20 -o dots.dms
  sparsurf surface models.pdb --frame 2 -o dots.ply
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="FILE", help="structure, or a file with radii or elements")
    options.add_output(parser, FORMATS)
    parser.add_argument(
        "--mesh", action="store_true", help="write a closed mesh of triangles instead of dots"
    )
    options.add_colours(parser)
    options.add_limits(parser)
    options.add_molecule(parser)
    options.add_groups(parser)
    options.add_residues(parser)
    rule_for_cavities = ": keep for dots, remove for triangles"
    dots = options.add_placement(parser, rule_for_cavities, "reentrant", "boundary", "d_link")
    help_text = "dots per Å^2 (default: 5.35, or more if patches would otherwise be fragmented); with --mesh, vertices per Å^2"
    options.add(dots, "density", meaning=help_text)
    options.add_size_of_mesh(dots)
    options.add_fields(dots)


def run(args: argparse.Namespace) -> None:
    """Write the dots or triangles."""
    if os.path.isdir(args.file):
        raise InputError(
            f"{args.file} is a folder; give one structure, or use `sparsurf points` for a folder."
        )
    if args.mesh and args.residues is not None:
        raise InputError(
            "--residues selects dots, whereas --mesh writes triangles; leave out one of the two options."
        )
    if args.boundary == ACCESSIBLE:
        if args.output.lower().endswith((".html", ".png")):
            raise InputError(
                "--boundary: pages and pictures show the excluded surface; write dots or a mesh, or leave it out."
            )
        from sparsurf.dot_fields.named_fields import takes_dots  # here: a mistake needs no kernels

        if refused := [*filter(takes_dots, options.names_of_requested_fields(args))]:
            raise InputError(
                f"--fields: {refused[0]} is one of the excluded surface; leave it out, or --boundary."
            )
    options.refuse_size_of_mesh(args)
    if args.mesh and (of_dots := options.given(args, *OF_DOTS)):
        option = next(iter(of_dots)).replace("_", "-")
        raise InputError(
            f"--{option} applies to dots, and --mesh writes triangles; leave out one of the two."
        )
    if args.mesh:
        outputs.check(args, writing.OUTPUTS_OF_MESH, beside_mesh(args.output))
    else:
        outputs.check(args, FORMATS)
    if is_file_of_spheres(args.file):
        outputs.write_output(args, _of_spheres(args))
        return
    if not options.reads_atoms(args):
        options.refuse_file_of_dots(args)
    molecule = options.read_atoms(args)
    options.say(f"surface of {molecule.n_atoms:,} atoms")
    outputs.write_output(args, _triangles(args, molecule) if args.mesh else _dots(args, molecule))


def _of_spheres(args: argparse.Namespace) -> writing.DotsToWrite:
    """Return the dots or triangles of a file with radii, or of a small molecule."""
    options.refuse_structure_options(args, "spheres")
    names = options.names_of_requested_fields(args)
    if args.mesh:
        with heard(args.file) as args.heard:
            return _triangles(args, args.file)
    with heard(args.file) as args.heard:
        dots = sparsurf.surface(args.file, **options.given(args, "density", "d_link"), **_rules(args))
    table, message = _columns_and_message(args, dots)
    table["atom"] = dots.atom
    dots = options.with_fields_of_spheres(dots, names)
    return writing.DotsToWrite(dots, table, message=message, about=options.about(args))


def _dots(args: argparse.Namespace, molecule: sparsurf.Molecule) -> writing.DotsToWrite:
    """Return the dots with their component and their fields."""
    if "roughness" in options.names_of_requested_fields(args):
        raise InputError(
            f"--fields: dots are written without roughness; sparsurf roughness {args.file} writes that of each dot."
        )
    keys = options.given(args, "frame", "density", "d_link", "groups")
    bare = sparsurf.surface(molecule, **keys, **_rules(args))
    molecule = bare.molecule or molecule  # that of the first group
    dots = options.with_requested_fields(args, bare, molecule)
    table, message = _columns_and_message(args, bare)
    table |= molecule.label_columns(dots.atom)
    about = options.about(args)
    if args.residues is not None:
        chosen = options.dots_of_residues(args, dots, molecule)
        dots, table = dots.take(chosen), {name: column[chosen] for name, column in table.items()}
        areas = bare.exact_areas
        area = dots.total_area if areas is None else areas[options.requested_atoms(args, molecule)].sum()
        message = f"{len(dots):,} of {len(bare):,} dots, {area:,.0f} Å^2 of {bare.total_area:,.0f} Å^2"
    return writing.DotsToWrite(dots, table, None, molecule, args.frame or 0, message=message, about=about)


def _triangles(args: argparse.Namespace, molecule: sparsurf.Molecule | str) -> writing.DotsToWrite:
    """Return the vertices of the closed triangles, with their fields."""
    size = options.given(args, "n_vertices", "density", "step", "frame", *options.VALUES_OF_ATOMS)
    made = sparsurf.mesh(molecule, fields=options.names_of_requested_fields(args), **size, **_rules(args))
    return replace(writing.mesh_dots(made), coloured=args.colours, about=options.about(args))


def _rules(args: argparse.Namespace) -> dict[str, Any]:
    """Return how the surface is made; the walls of cavities are kept with dots and removed from triangles by default."""
    return options.placement_options(args, "remove" if args.mesh else "keep")


def _columns_and_message(
    args: argparse.Namespace, dots: sparsurf.Surface
) -> tuple[dict[str, np.ndarray], str]:
    """Return the columns of dots and the message on them, which names no components of the accessible surface."""
    if args.boundary != ACCESSIBLE:
        return _with_components(dots)
    text = f"{len(dots):,} dots, {dots.total_area:,.0f} Å^2 of the accessible surface"
    return {"area": dots.area, "kind": dots.kind}, text


def _with_components(dots: sparsurf.Surface) -> tuple[dict[str, np.ndarray], str]:
    """Return the columns of all dots of a placement, and the message on these dots and the components of their surface."""
    from sparsurf.surfaces.components import columns_of_components, summarize_components, volume_in_words

    component = dots.known_components("components")
    summary = summarize_components(columns_of_components(dots))
    columns = {"area": dots.area, "kind": dots.kind, COMPONENT: component}
    parts = pluralise(int(summary["components"]), "component")
    text = f"{len(dots):,} dots, {dots.total_area:,.0f} Å^2, {volume_in_words(summary)}; {parts}"
    if summary["cavities"]:
        noun = "cavity" if summary["cavities"] == 1 else "cavities"
        text += f", of which {summary['cavities']} {noun} with {summary['cavity_dots']:,} dots"
    return columns, text
