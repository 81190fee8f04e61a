"""`sparsurf find`: the same site on other surfaces."""

import argparse
import logging
import math
from dataclasses import replace
from pathlib import Path

import pandas as pd

from sparsurf import InputError, progress
from sparsurf.api import writing
from sparsurf.api.inputs import PERCENT, is_structure
from sparsurf.api.sites import (
    HITS,
    SitesLike,
    as_sites,
    find_with_poses,
    is_run,
    ordered_fields,
    refuse_other_settings,
)
from sparsurf.cli import options, outputs
from sparsurf.dot_fields.registry import FIELDS as FIELDS_OF_DOTS
from sparsurf.files import pluralise, shorten
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, suffix
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.report.numbers import p_value
from sparsurf.sites.describing import FIELDS, Sites, places_of_residues
from sparsurf.sites.pose_search import Pose
from sparsurf.surfaces.read_surface import FORMATS

log = logging.getLogger("sparsurf")

DEFAULT_HITS = 10
EXAMPLES = """\
QUERY and TARGET are structures, dots with fields, or Sites (.sites). A TARGET can be a folder of structures and Sites; other
dots in it, and what cannot be read, are named and left out. Or it is the folder of a run with `batch` and `places`, all of
whose structures are searched. Of several models the first is taken. Without --residues, the
Sites of QUERY are written to OUT (.sites), so that they need not be described again. With --residues, OUT is a table of
hits: target, the residue in the middle of the hit, x,y,z, score, p, and how many places agree. p is how often an unrelated
protein scores as high; it is known for the default --percent and --fields.

examples:
  sparsurf find bound.pdb --residues A:10-25 unbound.pdb -o hits.csv
  sparsurf find bound.pdb --residues A:57,102 structures/ -o hits.csv
  sparsurf find bound.pdb --residues A:57,102 results/many -o hits.csv
  sparsurf find protein.pdb -o protein.sites
"""


def arguments(parser: argparse.ArgumentParser) -> None:
    """Add the options of the command."""
    parser.add_argument("file", metavar="QUERY", help="structure, dots with fields, or Sites")
    parser.add_argument(
        "targets", metavar="TARGET", nargs="*", help="where to look: the same, folders, or runs"
    )
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help="hits (.csv), or Sites (.sites)")
    parser.add_argument("--residues", help="the site, such as A:10-25,40")
    parser.add_argument(
        "--hits", type=options.number(HITS), help=f"largest number of hits (default {DEFAULT_HITS})"
    )
    parser.add_argument(
        "--percent", type=options.number(PERCENT), default=10, help="of the dots to keep (default 10)"
    )
    parser.add_argument(
        "--fields",
        default=",".join(FIELDS),
        help=f"what is compared besides the shape (default {','.join(FIELDS)})",
    )
    parser.add_argument(
        "--superpose", metavar="FOLDER", help="write QUERY superposed onto each hit there (PDB)"
    )
    parser.set_defaults(format=None)


def run(args: argparse.Namespace) -> None:
    """Write the hits, or the Sites of QUERY."""
    fields = ordered_fields([name.strip() for name in args.fields.split(",") if name.strip()])
    if never := sorted(FIELDS_OF_DOTS.keys() & set(fields) - set(FIELDS)):
        raise InputError(f"--fields: sites are not compared by {never[0]}; name some of {', '.join(FIELDS)}.")
    if not args.targets:
        _write_sites(args, fields)
        return
    outputs.check(args, writing.TABLES)
    if not args.residues:
        raise InputError("--residues is missing; name the residues of the site, such as A:10-25.")
    if args.superpose:
        _check_folder(args)
    query = as_sites(args.file, args.percent, fields)
    refuse_other_settings(query, args.percent, fields)
    places_of_residues(query, args.residues)  # raises an error before the targets take their time
    targets: list[SitesLike] = []
    for target in args.targets:
        targets += [target] if is_run(target) else _sites_of(target, query)
    table, poses = find_with_poses(query, targets, None, args.residues, args.hits or DEFAULT_HITS)
    writing.write_table(args.output, args.format, table)
    p = table["p"].min()
    words = pluralise(len(table), "target") + " ranked"
    outputs.report(args, args.output, words if math.isnan(p) else f"{words}, smallest p {p_value(p)}")
    if args.superpose:
        _superpose(args, table, poses or [])


def _write_sites(args: argparse.Namespace, fields: tuple[str, ...]) -> None:
    """Write the Sites of QUERY."""
    if args.residues or suffix(args.output) != ".sites":
        raise InputError("name at least one TARGET, or write the Sites of QUERY to a file named .sites.")
    if args.superpose or args.hits:
        raise InputError("--superpose and --hits are about hits; name a TARGET to search, too.")
    outputs.check(args, (".sites",))
    sites = as_sites(args.file, args.percent, fields)
    refuse_other_settings(sites, args.percent, fields)
    writing.write_file(args.output, None, (".sites",), {".sites": sites.save})
    outputs.report(args, args.output, f"{len(sites):,} places")


def _check_folder(args: argparse.Namespace) -> None:
    """Raise InputError if superposed structures cannot be written to the folder."""
    folder = Path(args.superpose)
    if folder.is_file():
        raise InputError(f"--superpose: {folder} is a file; name a folder.")
    if not is_structure(args.file):
        raise InputError(f"--superpose: {args.file} is not a structure; give one as QUERY.")
    for file in (args.file, *args.targets) if folder.is_dir() else ():
        parent = Path(file) if Path(file).is_dir() else Path(file).parent
        if parent.is_dir() and parent.samefile(folder):
            raise InputError(f"--superpose: {folder} is where {file} lies; name another folder.")


def _sites_of(target: str, query: Sites) -> list[Sites]:
    """Return the Sites of a target, or of all structures and Sites in a folder; name those that cannot be read."""
    path, percent, fields = Path(target), query.settings["percent"], query.fields
    if not path.is_dir():
        return [as_sites(path, percent, fields)]
    known = (*STRUCTURES, *SELF_CONTAINED, ".sites")
    present = sorted(file for file in path.iterdir() if file.is_file() and file.name[:1] != ".")
    dot_suffixes = {end for file_format in FORMATS for end in file_format.suffixes}
    dots = [file.name for file in present if suffix(file) in dot_suffixes]
    if dots:
        log.warning(
            "%s of dots in %s left out (%s); name a file of dots itself as TARGET",
            pluralise(len(dots), "file"), target, shorten(", ".join(dots)),
        )  # fmt: skip
    described = []
    files = [file for file in present if suffix(file) in known]
    for file in progress.progress_bar(files, f"targets in {target}"):
        try:
            sites = as_sites(file, percent, fields)
            if sites.settings["percent"] != percent or [*sites.fields] != [*fields]:
                raise InputError(f"{file} was described with other settings than QUERY; describe it again.")
            described.append(sites)
        except InputError as error:
            log.warning("left out: %s", error)
    if not described:
        raise InputError(f"{target} holds no structure and no Sites; name another folder.")
    return described


def _superpose(args: argparse.Namespace, table: pd.DataFrame, poses: list[Pose]) -> None:
    """Write QUERY superposed onto each hit."""
    folder = Path(args.superpose)
    folder.mkdir(parents=True, exist_ok=True)
    pairs = zip(table["rank"], table["target"], strict=True)
    names = [f"{rank:02d}_{target.replace('/', '_')}.pdb" for rank, target in pairs]
    if older := sorted({path.name for path in folder.glob("*.pdb")} - {*names}):
        log.warning("%s holds other files, too, such as %s", folder, older[0])
    molecule = read_molecule(args.file).frame(0)
    for name, pose in zip(names, poses, strict=True):
        replace(molecule, xyz=molecule.xyz @ pose.rotation + pose.shift).write_pdb(folder / name)
