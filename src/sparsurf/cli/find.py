"""`describe_sites` and `find`: the same site on other surfaces, as functions and as `sparsurf find`."""

import logging
from dataclasses import replace
from pathlib import Path

import numpy as np

from sparsurf import InputError, progress
from sparsurf.cli import outputs
from sparsurf.cli.inputs import PERCENT, Limits, as_molecule, is_structure, names_of_fields
from sparsurf.cli.making import surface as surface_of
from sparsurf.dot_fields.registry import FIELDS as OF_DOTS
from sparsurf.files import pluralise, shorten
from sparsurf.molecules.formats import SELF_CONTAINED, STRUCTURES, suffix
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.sites.describing import FIELDS, Sites, describe_surface, load_sites, places_of_residues
from sparsurf.sites.describing import PERCENT as PERCENT_KEPT
from sparsurf.sites.finding import find_places, find_site
from sparsurf.surfaces.read_surface import FORMATS, read_surface
from sparsurf.surfaces.spacing import spacing
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

log = logging.getLogger("sparsurf")

FEW = 0.9  # Å between neighbouring dots: of a whole surface .4, of a tenth of its dots 1.4
FARTHEST = 5.0  # Å, between a place that is sought and the nearest place of Sites
HITS = Limits(1, 10_000, whole=True, open_low=False)
HITS_SHOWN = 10
EXAMPLES = """\
QUERY and TARGET are structures, dots with fields, or Sites (.sites). A TARGET can be a folder of structures and Sites; other
dots in it, and what cannot be read, are named and left out. Of several models the first is taken. Without --residues, the
Sites of QUERY are written to OUT (.sites), so that they need not be described again. With --residues, OUT is a table of
hits: target, the residue in the middle of the hit, x,y,z, score, p, and how many places agree. p is how often an unrelated
protein scores as high; it is known for the default --percent and --fields.

examples:
  sparsurf find bound.pdb --residues A:10-25 unbound.pdb -o hits.csv
  sparsurf find bound.pdb --residues A:57,102,195 structures/ -o hits.csv --superpose laid
  sparsurf find protein.pdb -o protein.sites
"""


def describe_sites(surface, *, percent=10, fields=FIELDS, at=None, name=None):
    """Places on a surface, each with the numbers by which `find` compares it.

    Parameters
    ----------
    surface : path of a structure, what `read_molecule` gave, or dots with fields: a Surface or the path of a file of dots
    percent : float
        Share of the dots that are kept and described, farthest-point; of dots that are few already, such as those of
        `sparsurf minimal`, give 100.
    fields : sequence of str
        What is compared besides the shape: hydropathy, volume, aromaticity, charge, potential.
    at : (T, 3) float, optional
        Places in Å instead of the kept dots; those with hardly a dot around them are left out.
    name : str, optional
        What the hits call it; the name of the file without.

    Returns
    -------
    Sites
        With `points` (P, 3), `labels`, `numbers`; `save(path)` writes them, and `find` takes the file.

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> peptide = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-216")
    >>> sites = sparsurf.describe_sites(peptide, name="peptide")
    >>> len(sites), sites.fields[0]
    (393, 'hydropathy')
    """
    percent, fields = PERCENT.check(percent, "percent"), _in_order(fields)
    at = None if at is None else _places(at)
    if name is not None and not (isinstance(name, str) and name.isprintable()):
        raise InputError(f"name is {name!r}; it must be a string of printable characters.")
    dots, molecule = _dots_of(surface)
    name = name or (
        Path(Path(surface).name.removesuffix(".gz")).stem if isinstance(surface, str | Path) else "surface"
    )
    if empty := [key for key in fields if not np.isfinite(dots.fields.get(key, 0)).any()]:
        raise InputError(f"{name}: the field {empty[0]} has no numbers; leave it out of the fields.")
    with np.errstate(over="ignore"):  # told below
        sites = describe_surface(dots, molecule, name, percent, fields, at, available_cores())
    if not np.isfinite(sites.numbers).all():
        raise InputError(f"{name}: a field has numbers of 10,000 and more; write it in another unit.")
    if at is not None and len(sites) < len(at):
        log.warning(
            "%s: %d of %d places are left out: they have hardly a dot around them",
            name,
            len(at) - len(sites),
            len(at),
        )
    return sites


def find(query, targets, *, at=None, residues=None, n=10, percent=10, fields=FIELDS):
    """Where places of one surface are found again on others.

    Parameters
    ----------
    query : Sites, the path of a file of them, or what `describe_sites` takes
    targets : one of these, or a list; described as the query is
    at : (Q,) int places of the query, or (Q, 3) float places in Å; every place is sought by itself
    residues : str, instead: ranges such as 'A:10-25,40', sought as a whole in one arrangement
    n : int
        Hits of each place, or of the site.
    percent, fields : as for `describe_sites`, of what is not described yet

    Returns
    -------
    DataFrame
        query (index into `at`), rank from 1, target, chain, residue, residue_name, x, y, z (Å), score; of a site also p,
        how often an unrelated protein scores as high (NaN where `percent` or `fields` are not the default), and `places`, how
        many agree. A higher score is a better hit.

    Raises
    ------
    InputError : one sentence on what is wrong

    Examples
    --------
    >>> import sparsurf
    >>> peptide = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-216")
    >>> sites = sparsurf.describe_sites(peptide, name="peptide")
    >>> table = sparsurf.find(sites, sites, at=[3, 50], n=2)
    >>> table.loc[table["rank"] == 1, ["query", "target", "residue_name"]].values.tolist()
    [[0, 'peptide', 'PHE'], [1, 'peptide', 'TYR']]
    """
    return found(query, targets, at, residues, HITS.check(n, "n"), percent, fields)[0]


def found(query, targets, at=None, residues=None, n=10, percent=10, fields=FIELDS):
    """The table of `find`, and the poses of its rows where a site is sought as a whole."""
    if (at is None) == (residues is None):
        raise InputError("find: give either `at`, places, or `residues`, a site.")
    whole = as_sites(query, percent, fields)
    _refuse_other_settings(whole, percent, fields)
    many = targets if isinstance(targets, list | tuple) else [targets]
    percent, fields = whole.settings["percent"], whole.fields
    others = _told_apart([as_sites(each, percent, fields) for each in many])
    if residues is not None:
        hits = find_site(whole.take(places_of_residues(whole, residues)), others, n)
        fits = hits.table["places"].to_numpy() > 0
        if not fits.all():
            without = ", ".join(dict.fromkeys(hits.table.loc[~fits, "target"]))
            log.warning("nothing of the site fits on %s", shorten(without))
        return hits.table[fits], [pose for pose, fit in zip(hits.poses, fits, strict=True) if fit]
    return find_places(_at(query, whole, at), others, n, available_cores()), None


def as_sites(given, percent=10, fields=FIELDS):
    """Sites from themselves, the path of a file of them, or what `describe_sites` takes."""
    if isinstance(given, Sites):
        return given
    if _is_sites(given):
        return load_sites(given)
    if PERCENT.check(percent, "percent") < 100 and isinstance(given, str | Path) and not is_structure(given):
        gap = spacing(read_surface(given).points)
        if gap > FEW:
            log.warning(
                "%s: its dots lie %.1f Å apart, as in a subset; of these %g %% are kept, so that scores fall: "
                "search what `sparsurf recover` makes of it",
                given, gap, percent,
            )  # fmt: skip
    return describe_sites(given, percent=percent, fields=fields)


def _refuse_other_settings(sites, percent, fields):
    """Refuse settings that are asked for, not by default, and that Sites were not described by."""
    for key, asked, default in (
        ("percent", percent, PERCENT_KEPT),
        ("fields", _in_order(fields), FIELDS),
    ):
        own = tuple(sites.fields) if key == "fields" else sites.settings[key]
        if asked not in (default, own):
            shown = ", ".join(own) if key == "fields" else f"{own:g}"
            raise InputError(
                f"{key}: {sites.name} was described with {shown}; leave the option out, or give the structure."
            )


def _in_order(fields):
    """Names of fields in the order of all that are known, which is that of the numbers in Sites."""
    names = names_of_fields(fields, "fields")
    return tuple(sorted(names, key=lambda name: FIELDS.index(name) if name in FIELDS else len(FIELDS)))


def _told_apart(targets):
    """Targets of one name with numbers behind it, in their order."""
    numbers, out = {}, []
    for each in targets:
        k = numbers[each.name] = numbers.get(each.name, 0) + 1
        out.append(replace(each, name=f"{each.name} ({k})") if k > 1 else each)
    for name, k in numbers.items():
        if k > 1:
            log.warning("%d targets are called %s: their numbers follow the order given", k, name)
    return out


def _is_sites(given):
    """Whether something is the path of a file of Sites."""
    return isinstance(given, str | Path) and suffix(given) == ".sites"


def _dots_of(given):
    """Dots of a structure with its molecule; of anything else without."""
    if isinstance(given, Surface):
        return given, None
    if isinstance(given, str | Path) and not is_structure(given):
        return read_surface(given), None
    molecule = as_molecule(given)
    if molecule.n_frames > 1:
        log.warning("%s has %d models: the first is taken", given, molecule.n_frames)
    molecule = molecule.frame(0)
    return surface_of(molecule), molecule


def _places(at):
    """Places (Q, 3) float64, Å."""
    at = _array(at)
    if at.ndim != 2 or at.shape[1] != 3 or at.dtype.kind not in "iuf" or not len(at):
        raise InputError(f"at: give (Q,) numbers of places or (Q, 3) places in Å, not {_short(at)}.")
    if not np.isfinite(at).all():
        raise InputError(
            f"at: place {np.argmin(np.isfinite(at).all(axis=1))} is no place: it has NaN or infinity."
        )
    return at.astype(float)


def _array(at):
    """What is given as an array; rows of unlike length are none of numbers."""
    try:
        return np.asarray(at)
    except ValueError:
        return np.empty(0, object)


def _short(at):
    """What an array of no places is."""
    return f"shape {at.shape}" if at.dtype.kind in "iuf" else "something else"


def _at(query, whole, at):
    """The places of a query that are sought."""
    at = _array(at)
    if at.ndim == 1 and at.dtype.kind in "iu":
        if len(at) == 0 or at.min() < 0 or at.max() >= len(whole):
            raise InputError(f"at: the query has the places 0 to {len(whole) - 1}.")
        return whole.take(at)
    at = _places(at)
    if isinstance(query, Sites) or _is_sites(query):
        from scipy.spatial import cKDTree

        gap, nearest = cKDTree(whole.points).query(at)
        if gap.max() > FARTHEST:
            raise InputError(
                f"at: place {gap.argmax()} is {gap.max():.0f} Å away from {whole.name}; give places on it."
            )
        return whole.take(nearest)
    found = describe_sites(query, percent=whole.settings["percent"], fields=whole.fields, at=at)
    if len(found) < len(at):
        raise InputError(
            f"at: {len(at) - len(found)} places have hardly a dot around them; give places on the surface."
        )
    return found


def arguments(parser):
    """Options of the command."""
    parser.add_argument("file", metavar="QUERY", help="structure, dots with fields, or Sites")
    parser.add_argument("targets", metavar="TARGET", nargs="*", help="where to look: the same, or folders")
    parser.add_argument("-o", "--output", required=True, metavar="OUT", help="hits (.csv), or Sites (.sites)")
    parser.add_argument("--residues", help="the site, such as A:10-25,40")
    parser.add_argument("--hits", type=HITS.parse, help="most hits (default 10)")
    parser.add_argument("--percent", type=PERCENT.parse, default=10, help="of the dots to keep (default 10)")
    parser.add_argument(
        "--fields",
        default=",".join(FIELDS),
        help=f"what is compared besides the shape (default {','.join(FIELDS)})",
    )
    parser.add_argument("--superpose", metavar="FOLDER", help="write QUERY laid on each hit there (PDB)")
    parser.set_defaults(format=None)


def run(asked):
    """Write the hits, or the Sites of QUERY."""
    fields = _in_order([name.strip() for name in asked.fields.split(",") if name.strip()])
    if never := sorted(OF_DOTS.keys() & set(fields) - set(FIELDS)):
        raise InputError(f"--fields: {never[0]} is not searched by; name some of {', '.join(FIELDS)}.")
    if not asked.targets:
        if asked.residues or suffix(asked.output) != ".sites":
            raise InputError("name at least one TARGET, or write the Sites of QUERY to a file named .sites.")
        if asked.superpose or asked.hits:
            raise InputError("--superpose and --hits are about hits; name a TARGET to search, too.")
        outputs.check(asked, (".sites",))
        sites = as_sites(asked.file, asked.percent, fields)
        _refuse_other_settings(sites, asked.percent, fields)
        outputs.write(asked.output, None, (".sites",), {".sites": sites.save})
        outputs.wrote(asked, asked.output, f"{len(sites):,} places")
        return
    outputs.check(asked, outputs.TABLES)
    if not asked.residues:
        raise InputError("--residues says which site is sought; give it, such as A:10-25.")
    if asked.superpose and Path(asked.superpose).is_file():
        raise InputError(f"--superpose: {asked.superpose} is a file; name a folder.")
    if asked.superpose and not is_structure(asked.file):
        raise InputError(f"--superpose: {asked.file} is no structure; give one as QUERY.")
    for read in (asked.file, *asked.targets) if asked.superpose and Path(asked.superpose).is_dir() else ():
        folder = Path(read) if Path(read).is_dir() else Path(read).parent
        if folder.is_dir() and folder.samefile(asked.superpose):
            raise InputError(f"--superpose: {asked.superpose} is where {read} lies; name another folder.")
    query = as_sites(asked.file, asked.percent, fields)
    _refuse_other_settings(query, asked.percent, fields)
    places_of_residues(query, asked.residues)  # a mistake there is told before the targets take their time
    others = [each for target in asked.targets for each in _sites_of(target, query)]
    table, poses = found(query, others, None, asked.residues, asked.hits or HITS_SHOWN)
    outputs.write_table(asked.output, asked.format, table)
    outputs.wrote(asked, asked.output, pluralise(len(table), "hit"))
    if asked.superpose:
        _superpose(asked, table, poses)


def _sites_of(target, query):
    """Sites of a target, or of all structures and Sites of a folder but for those that cannot be read, which are told."""
    path, how = Path(target), (query.settings["percent"], query.fields)
    if not path.is_dir():
        return [as_sites(path, *how)]
    known = (*STRUCTURES, *SELF_CONTAINED, ".sites")
    there = sorted(file for file in path.iterdir() if file.is_file() and file.name[:1] != ".")
    files, described = [file for file in there if suffix(file) in known], []
    dots = [file.name for file in there if suffix(file) in {end for each in FORMATS for end in each.suffixes}]
    if dots:
        log.warning(
            "%s of dots in %s left out (%s); name a file of dots itself as TARGET",
            pluralise(len(dots), "file"), target, shorten(", ".join(dots)),
        )  # fmt: skip
    for file in progress.progress_bar(files, f"targets in {target}"):
        try:
            found = as_sites(file, *how)
            if found.settings["percent"] != how[0] or [*found.fields] != [*how[1]]:
                raise InputError(f"{file} was described with other settings than QUERY; describe it again.")
            described.append(found)
        except InputError as error:
            log.warning("left out: %s", error)
    if not described:
        raise InputError(f"{target} holds no structure and no Sites; name another folder.")
    return described


def _superpose(asked, table, poses):
    folder = Path(asked.superpose)
    folder.mkdir(parents=True, exist_ok=True)
    names = [f"{row.rank:02d}_{row.target.replace('/', '_')}.pdb" for row in table.itertuples()]
    if older := sorted({path.name for path in folder.glob("*.pdb")} - {*names}):
        log.warning("%s holds other files, too, such as %s", folder, older[0])
    molecule = read_molecule(asked.file).frame(0)
    for name, pose in zip(names, poses, strict=True):
        replace(molecule, xyz=molecule.xyz @ pose.turn + pose.shift).write_pdb(folder / name)
