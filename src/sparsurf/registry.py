"""Registry of what can be chosen by name: samplers, descriptors, definitions of roughness, fields, readings, surface formats.

`TABLE` is the only list of these names. The config, the help of commands, the pages, the figures and the documentation read
it. It names each function as "module:function", which is imported when the function is first used, so that planning a study
and `sparsurf --help` import no numpy. `register` and the entry points of installed packages add further names. To add one to
the library, write the function and one entry here.
"""

from __future__ import annotations

import inspect
import re
import textwrap
from collections.abc import Callable
from functools import cache, partial
from importlib import import_module
from typing import Any, Final, NamedTuple

from sparsurf.arguments import F, did_you_mean, public
from sparsurf.errors import InputError, argument

ENTRY_POINTS = "sparsurf"  # group of entry points; each is called kind.name
# The line of a docstring in whose place `with_choices` writes the names of a kind
CHOICES = re.compile(r"^(?P<indent> *)\{choices of (?P<kind>\w+)\}$", re.MULTILINE)
# the samplers that "auto" stands for
FARTHEST: Final = "farthest"
COVER: Final = "cover"
CHOICE_NAME = re.compile(r"[A-Za-z][A-Za-z0-9_]*")  # a name stands in configs, columns and names of files


class Choice(NamedTuple):
    """One thing that can be chosen.

    Attributes
    ----------
    source : "module:function", or the function itself; empty for a format from which no dots are read
    label : str, its name in figures and on pages
    meaning : str, one sentence
    unit : str, of its values; empty without one
    applies : what it can be computed on: "dots" with normals, the vertices of a "mesh", surfaces with "atoms"
    package : str, the installed package that adds it, with its version; empty for those of the library
    name : str, filled in when it is looked up
    nested : of a sampler, whether smaller subsets are the beginnings of larger ones (from the same random stream)
    takes_combinations : of a sampler, whether it draws by alpha, beta, gamma and delta and also takes the paper's `choices`
    in_browser : of a sampler, whether the page of a surface draws subsets by it, in sampling.js
    condition : of a reading, which dots of a patch it removes, as the end of a sentence
    line : of a sampler, colour, line width and marker in figures; other samplers get spare ones
    takes_dots : of a field, whether its function takes the dots in place of (molecule, points)
    carries : of a format, what its files can hold: "dots", "triangles", their "fields", "colours" and "atoms"; "spheres" with
        radii; tables of "points", of "residues", and of residues in "frames"; or a "page", or a "script" that opens other files
    is_read, is_written : of a format, whether files are read, and written
    sniff : of a registered format, the function of the first bytes of a file that recognises it
    """

    source: str | Callable[..., Any]
    label: str
    meaning: str = ""
    unit: str = ""
    applies: tuple[str, ...] = ("dots", "mesh")
    package: str = ""
    name: str = ""
    nested: bool = False
    takes_combinations: bool = False
    in_browser: bool = False
    condition: str = ""
    line: tuple[str, float, str] | None = None
    takes_dots: bool = False
    carries: tuple[str, ...] = ()
    is_read: bool = False
    is_written: bool = False
    sniff: Callable[[bytes], bool] | None = None

    @property
    def is_built_in(self) -> bool:
        """Whether the library itself has it: its results need no check."""
        return isinstance(self.source, str) and not self.package

    @property
    def address(self) -> str:
        """The function as module:function."""
        return self.source if isinstance(self.source, str) else _address(self.source)

    @property
    def origin(self) -> str:
        """Where it comes from, for a sentence."""
        if self.package:
            return f"of {self.package}"
        return "built in" if self.is_built_in else f"from {self.address}"


def _of_format(label: str, meaning: str, carries: str, mode: str, source: str = "") -> Choice:
    """Return the entry of a format: what it carries, whether it is read (r) and written (w), and what reads dots from it."""
    parts = tuple(carries.split())
    return Choice(source, label, meaning, carries=parts, is_read="r" in mode, is_written="w" in mode)


class Kind(NamedTuple):
    """A kind of choices: its name in sentences, and the arguments of its functions."""

    word: str
    plural: str
    arguments: tuple[str, ...]


KINDS = {
    "sampler": Kind("sampler", "samplers", ("prepared", "n", "rng")),
    "descriptor": Kind("descriptor", "descriptors", ("patches",)),
    "roughness": Kind("roughness", "definitions of roughness", ("index", "radius", "threads")),
    "field": Kind("field", "fields", ("molecule", "points")),
    "reading": Kind("reading", "readings", ("points", "normals", "d_link", "area", "density")),
    "format": Kind("surface format", "surface formats", ("content", "path")),
}
ATOMS, ORIGIN = ("dots", "mesh", "atoms"), ("dots", "atoms")
# The order is that of help, figures and tables. Of formats, the first that recognises the start of a file reads it.
TABLE: dict[str, dict[str, Choice]] = {
    "sampler": {
        "paper": Choice(
            "sparsurf.sampling.samplers:paper", "paper's sampling",
            "The paper's sampling, which keeps more dots where the surface is rough.",
            takes_combinations=True, in_browser=True, line=("#D55E00", 1.6, "D")),
        "paper_corrected": Choice(
            "sparsurf.sampling.samplers:paper_corrected", "paper's, corrected",
            "The paper's sampling with distances from the dot itself and one chance for each dot.",
            takes_combinations=True, line=("#CC79A7", 0.8, "^")),
        "uniform": Choice(
            "sparsurf.sampling.samplers:uniform", "random subset", "Dots drawn at random, each with the same chance.",
            nested=True, in_browser=True, line=("#000000", 1.6, "s")),
        "poisson": Choice(
            "sparsurf.sampling.samplers:poisson", "Poisson disk", "Dots drawn at random, but no closer than a certain distance.",
            line=("#009E73", 0.8, "P")),
        "farthest": Choice(
            "sparsurf.sampling.samplers:farthest", "farthest point", "Dots that are as far from one another as possible.",
            nested=True, in_browser=True, line=("#0072B2", 1.6, "o")),
        "cover": Choice(
            "sparsurf.sampling.cover:cover", "determining the atoms",
            "Dots from which the exposed atoms follow, and more where the surface of the atoms that follow would err.",
            applies=ORIGIN),
    },
    "descriptor": {
        "published": Choice(
            "sparsurf.patches.zernike.published:DESCRIPTOR", "published", "The 121 Zernike invariants of the paper."),
        "rotation_robust": Choice(
            "sparsurf.patches.zernike.rotation_robust:DESCRIPTOR", "rotation-robust",
            "Zernike invariants that change very little when the molecule is rotated."),
    },
    "roughness": {
        "published": Choice(
            "sparsurf.patches.roughness:published", "published",
            "The mean cosine between the normals of a patch and their mean, as in the paper."),
    },
    "field": {
        "hydropathy": Choice(
            "sparsurf.dot_fields.named_fields:hydropathy", "Kyte-Doolittle hydropathy",
            "Kyte and Doolittle's hydropathy of nearby amino acids.", "", ATOMS),
        "potential": Choice(
            "sparsurf.dot_fields.named_fields:potential", "electrostatic potential",
            "The screened Coulomb potential.", "kT/e", ATOMS),
        "bfactor": Choice(
            "sparsurf.dot_fields.named_fields:bfactor", "B factor",
            "The B factor of the atom that a dot belongs to.", "Å^2", ATOMS),
        "mean_curvature": Choice(
            "sparsurf.dot_fields.named_fields:mean_curvature", "mean curvature",
            "The mean of the two principal curvatures, positive where the surface is convex.", "1/Å", ORIGIN, takes_dots=True),
        "gaussian_curvature": Choice(
            "sparsurf.dot_fields.named_fields:gaussian_curvature", "Gaussian curvature",
            "The product of the two principal curvatures, negative on saddles.", "1/Å^2", ORIGIN, takes_dots=True),
        "shape_index": Choice(
            "sparsurf.dot_fields.named_fields:shape_index", "shape index",
            "The shape index: 1 on a convex sphere, 0 on an even saddle, -1 on a concave sphere.", "", ORIGIN, takes_dots=True),
        "depth": Choice(
            "sparsurf.dot_fields.named_fields:depth_of_dots", "depth of the residue",
            "The mean distance of the atoms of a dot's residue from the surface.", "Å", ORIGIN, takes_dots=True),
        "burial": Choice(
            "sparsurf.dot_fields.burial:burial", "depth below the surface of all groups",
            "How deep a dot of the first group lies below the surface of all groups together, 0 where it stays on it.", "Å",
            ORIGIN, takes_dots=True),
        "enclosure": Choice(
            "sparsurf.dot_fields.burial:enclosure", "depth below a probe of 5 Å",
            "How deep a dot lies below the surface that a probe of 5 Å touches, 0 where this probe touches the dot.", "Å",
            ORIGIN, takes_dots=True),
        "hbond": Choice(
            "sparsurf.dot_fields.named_fields:hbond", "hydrogen-bond donor (1) or acceptor (−1)",
            "Whether the atom of a dot donates hydrogen bonds (1), accepts them (-1), or neither (0).", "", ATOMS,
            takes_dots=True),
    },
    "reading": {
        "kept": Choice(
            "sparsurf.patches.readings:AMONG_KEPT", "among the kept dots",
            "All but the largest island of a patch are removed among the kept dots, as in the authors' code.",
            condition="only the largest island is kept in each subset, as in the authors' code"),
        "kept_scaled": Choice(
            "sparsurf.patches.readings:SCALED", "among the kept dots, scaled link",
            "The same, with a link that grows with the spacing of the kept dots.",
            condition="only the largest island is kept, with a link that grows with the spacing"),
        "full": Choice(
            "sparsurf.patches.readings:ON_FULL", "on the full surface",
            "All but the largest island of a patch are removed once, on the full surface.",
            condition="only the largest island is kept once, on the full surface"),
        "recovered": Choice(
            "sparsurf.recovery.readings:ON_RECOVERED", "recovered",
            "The patches are those of the surface that is reconstructed from the kept dots.",
            condition="a dense surface is reconstructed from each subset"),
    },
    "format": {
        "parquet": _of_format(
            "Parquet", "A table of the points of many structures, or of the residues in many frames.", "points frames", "w"),
        "csv": _of_format(
            "CSV",
            "A row with x, y, z, nx, ny and nz for each dot, and a column for each field.",
            "dots fields atoms residues frames", "rw",
            "sparsurf.surfaces.formats.csv:FORMAT"),
        "npz": _of_format(
            "NumPy archive",
            "Arrays of the dots, their fields, and triangles if there are any.",
            "dots triangles fields atoms points residues", "rw",
            "sparsurf.surfaces.formats.npz:FORMAT"),
        "dms": _of_format(
            "DMS", "The format of the program DMS, which names the atom of every dot.", "dots atoms", "rw",
            "sparsurf.surfaces.formats.dms:FORMAT"),
        "ply": _of_format(
            "PLY",
            "The dots, or the vertices and triangles of a mesh, with fields and colours.",
            "dots triangles fields colours points", "rw",
            "sparsurf.surfaces.formats.ply:FORMAT"),
        "vert": _of_format(
            "MSMS",
            "The vertices of the program MSMS, with their triangles in a .face next to it.", "dots triangles atoms", "rw",
            "sparsurf.surfaces.formats.msms:FORMAT"),
        "vtp": _of_format(
            "VTK PolyData", "The dots or a mesh with all numbers, for ParaView and PyVista.", "dots triangles fields atoms", "w"),
        "obj": _of_format("OBJ", "A mesh, by trimesh.", "triangles colours", "w"),
        "glb": _of_format("glTF", "A mesh, by trimesh.", "triangles colours", "w"),
        "stl": _of_format("STL", "A mesh, by trimesh.", "triangles", "w"),
        "pml": _of_format("PyMOL script", "The dots on their molecule, for PyMOL.", "dots triangles colours", "w"),
        "pdb": _of_format("PDB", "The dots as atoms, with the shown values as B factors.", "dots triangles colours", "w"),
        "bild": _of_format("BILD", "The dots as spheres, for ChimeraX.", "dots triangles colours", "w"),
        "cxc": _of_format(
            "ChimeraX script",
            "A script NAME.cxc that opens NAME_dots.bild and NAME_molecule.pdb next to it, which are written with it.",
            "script", "w"),
        "html": _of_format("page", "An interactive page of dots, a mesh or the roughness along each chain.", "page", "w"),
        "png": _of_format("picture", "A picture of the same, for which matplotlib must be installed.", "page", "w"),
        "xyzr": _of_format("XYZR", "Position and radius of a sphere in each line, as for the program MSMS.", "spheres", "rw"),
        "xyzrn": _of_format("XYZRN", "The same, with a number and the name of the sphere.", "spheres", "rw"),
        "pqr": _of_format("PQR", "Atoms with charges and radii, of which the radii are read.", "spheres", "rw"),
        "sdf": _of_format("SDF", "A small molecule, whose elements get radii of Bondi.", "spheres", "r"),
        "mol": _of_format("MOL", "A small molecule, whose elements get radii of Bondi.", "spheres", "r"),
        "mol2": _of_format("MOL2", "A small molecule, whose elements get radii of Bondi.", "spheres", "r"),
    },
}  # fmt: skip
# State of the process. What a user registers is a function of this process, often of a notebook, so that no other place can hold
# it: a command or a study, which runs in other processes, never depends on it and takes functions of installed packages instead.
_registered: dict[str, dict[str, Choice]] = {kind: {} for kind in TABLE}
# What was looked up by name. The check of a config looks up every name in it, and `versions_of_code` then reads here which
# packages the study uses: a package that no name of the config belongs to must not make jobs run again.
_plugins_in_use: dict[tuple[str, str], Choice] = {}
_told: set[str] = set()  # warnings that were given: a page looks up the same name many times


@public()
def register(
    kind: str,
    name: str,
    function: Callable[..., Any],
    *,
    label: str | None = None,
    unit: str = "",
    meaning: str = "",
    nested: bool = False,
    takes_dots: bool = False,
    sniff: Callable[[bytes], bool] | None = None,
) -> None:
    """Add a sampler, descriptor, roughness, field, reading or surface format of your own under a name.

    The functions of the library then take the name. They also take the function itself, unless it is a lambda. A study and the
    commands, which run in processes of their own, take names that an installed package adds by an entry point.

    Parameters
    ----------
    kind : {'sampler', 'descriptor', 'roughness', 'field', 'reading', 'format'}
        What the function is.
    name : str
        Letters, digits and underscores, beginning with a letter. The name of a format is the suffix of its files.
    function : callable
        A sampler takes (prepared, n, rng), a PreparedSurface, the number of dots and a numpy Generator, and returns the indices
        (n,) of dots. A descriptor takes (patches), the `Patches` of `sparsurf.patches.zernike.images`, and returns numbers (P,
        width), of the same width for any patches. A roughness takes (index, radius, threads), a PatchIndex, Å and a number, and
        returns (N,) numbers from 0 (rough) to 1 (flat). A field takes (molecule, points), the Molecule and positions (N, 3), Å,
        and returns (N,) numbers. A reading takes (points, normals, d_link, area, density) of the kept dots and returns the
        PatchIndex of their surface. A format takes (content, path), the bytes of a file and its path, and returns a Surface.
    label, unit, meaning : str, optional
        The name in figures and on pages (default the name, with spaces for underscores), the unit of the values of a field, and
        one sentence that explains the function (default "").
    nested, takes_dots : bool
        Whether the first m of n dots of a sampler are its subset of m dots; whether a field takes only the Surface of the dots,
        with the atom of each, in place of (molecule, points) (default False).
    sniff : callable, optional
        Of a format: a function of the first bytes of a file that returns whether it has this format.

    Raises
    ------
    InputError
        There is no such kind, the name is taken other than by an earlier version of the function, or its arguments do not fit.

    Examples
    --------
    >>> import sparsurf
    >>> def highest(prepared, n, rng):
    ...     return (-prepared.points[:, 2]).argsort(kind="stable")[:n]
    >>> sparsurf.register("sampler", "highest", highest, label="highest dots", nested=True)
    >>> len(sparsurf.sample("data/tdp43/topology.pdb", n_dots=100, sampler="highest"))
    100
    """
    if not isinstance(kind, str) or kind not in TABLE:
        raise InputError(f"register: there is no kind {kind!r}; the kinds are {', '.join(TABLE)}.")
    word = KINDS[kind].word
    if not isinstance(name, str) or not CHOICE_NAME.fullmatch(name):
        raise InputError(
            f"register: {name!r} cannot name a {word}; use letters, digits and underscores, and begin with a letter."
        )
    if not callable(function):
        raise InputError(f"register: give the function of the {word} {name!r}, not {function!r}.")
    if kind == "format" and sniff is None:
        raise InputError(
            f"register: the surface format {name!r} needs sniff, a function that recognises its files by their first bytes."
        )
    package = _refuse_taken(kind, name, function, "register", "choose another name")
    _check_signature(kind, name, function, takes_dots)
    _registered[kind][name] = Choice(
        function, label or name.replace("_", " "), meaning, unit, package=package, name=name, nested=nested,
        takes_dots=takes_dots, carries=("dots",) * (kind == "format"), is_read=kind == "format", sniff=sniff,
    )  # fmt: skip


def names(kind: str) -> list[str]:
    """Return all names of a kind: those of the library, then registered ones, then those of installed packages."""
    return [*dict.fromkeys([*TABLE[kind], *_registered[kind], *plugins()[kind]])]


def has(kind: str, name: Any) -> bool:
    """Return whether there is a choice of this name; installed packages are asked only if the library has none."""
    return isinstance(name, str) and _known(kind, name) is not None


def find(kind: str, value: Any, key: str) -> Choice:
    """Return the choice that a user gave as `key`, by its name or as a function; raise InputError for anything else."""
    if not callable(value):
        choice = _known(kind, value) if isinstance(value, str) else None
        if choice is None:
            listed, word = names(kind), KINDS[kind]
            hint = did_you_mean(str(value), listed) or "."
            raise InputError(
                f"{argument(key)}: there is no {word.word} {value!r}; the {word.plural} are {', '.join(listed)}{hint}"
            )
        return choice
    for name, choice in (TABLE[kind] | _registered[kind]).items():
        if choice.source is value or choice.source == _address(value):
            return choice._replace(name=name)
    name = getattr(value, "__name__", "")
    if not CHOICE_NAME.fullmatch(name):
        raise InputError(
            f"{argument(key)}: {value!r} has no name; write a function with def, or call "
            f"sparsurf.register({kind!r}, name, function)."
        )
    _refuse_taken(kind, name, value, argument(key), "rename your function")
    former = _known(kind, name) or Choice(value, name.replace("_", " "), name=name)
    _check_signature(kind, name, value, former.takes_dots)
    return former._replace(source=value)


def name_of(kind: str, value: Any, key: str) -> str:
    """Return the name of a choice that a user gave as `key`; that of a function is its own."""
    return find(kind, value, key).name


def load(kind: str, value: Any, key: str) -> tuple[Choice, Any]:
    """Return a choice and its function, which is imported now; raise InputError if a package of the user cannot be imported.

    A function from outside of the library raises InputError, from its own error, when it fails.
    """
    choice = find(kind, value, key)
    function: Any = choice.source
    if isinstance(function, str):
        module, _, attribute = function.partition(":")
        try:
            function = import_module(module)
            for part in attribute.split("."):
                function = getattr(function, part)
        except Exception as error:  # whatever a foreign module does when it is imported
            if choice.is_built_in:
                raise
            raise InputError(
                f"{argument(key)}: the {KINDS[kind].word} {choice.name!r} of {choice.package} cannot be imported: "
                f"{_reason(error)} Repair or uninstall that package."
            ) from error
        if choice.is_built_in:
            return choice, function
        choice = _registered[kind].get(choice.name, choice)  # the module may have registered its label
        _check_signature(kind, choice.name, function, choice.takes_dots)
    who = f"the {KINDS[kind].word} {choice.name!r}" + (f" of {choice.package}" if choice.package else "")
    if choice.sniff is not None:
        choice = choice._replace(sniff=partial(_call, who, choice.sniff))
    if kind == "field":  # of which molecule and points are easily exchanged
        who += f", which is called with ({', '.join(_arguments(kind, choice.takes_dots))}),"
    return choice, partial(_call, who, function) if callable(function) else function


def _call(who: str, function: Callable[..., Any], *values: Any, **named: Any) -> Any:
    """Call a function of the user; raise InputError, from its own error, if it fails."""
    try:
        return function(*values, **named)
    except (InputError, MemoryError):
        raise
    except Exception as error:  # whatever a foreign function does
        raise InputError(f"{who} fails: {_reason(error)}") from error


def choice_of(kind: str, name: str) -> Choice | None:
    """Return a choice for a page or figure, with the label that its package gives; None if there is none of this name.

    A package that cannot be imported is told once and does not stop the page, which needs no more than the name.
    """
    choice = _known(kind, name)
    try:
        return load(kind, name, kind)[0] if choice and choice.package else choice
    except InputError as error:
        _warn(str(error))
        return choice


def label(kind: str, name: str) -> str:
    """Return what figures and pages call a choice; the name itself if there is none of this name."""
    choice = choice_of(kind, name)
    return choice.label if choice else name


def origin(kind: str, choice: Choice) -> str:
    """Return where a choice comes from, within a sentence: "a built-in field", "a field of my-package 1.0"."""
    word = KINDS[kind].word
    return f"a built-in {word}" if choice.is_built_in else f"a {word} {choice.origin}"


def with_choices(function: F) -> F:
    """Put a list of the library's names in place of lines such as {choices of field} in the documentation of a function."""

    def listed(match: re.Match[str]) -> str:
        entries = []
        for name, choice in TABLE[match["kind"]].items():
            unit = f" ({choice.unit})" if choice.unit else ""
            meaning = f"- '{name}'{unit}: {choice.meaning}"
            entries.append(textwrap.fill(meaning, 120, subsequent_indent="  ", break_on_hyphens=False))
        return textwrap.indent("\n".join(entries), match["indent"])

    function.__doc__ = CHOICES.sub(listed, function.__doc__ or "")
    return function


def samplers_of_combinations() -> tuple[str, ...]:
    """Return the samplers that draw by alpha, beta, gamma and delta."""
    return tuple(name for name, choice in TABLE["sampler"].items() if choice.takes_combinations)


def suffixes(carried: str = "dots", is_read: bool = False) -> tuple[str, ...]:
    """Return the suffixes of the formats of the library that carry something and are read, or else are written."""
    formats = TABLE["format"].items()
    return tuple(
        f".{name}" for name, choice in formats
        if carried in choice.carries and (choice.is_read if is_read else choice.is_written)
    )  # fmt: skip


def formats_read() -> list[str]:
    """Return the names of the formats of files of dots, in the order in which they are tried."""
    return [name for name in names("format") if name not in TABLE["format"] or TABLE["format"][name].source]


def plugins_in_use(kind: str) -> dict[str, Choice]:
    """Return the choices of installed packages that were looked up in this process, by name."""
    return {
        name: choice for (kind_in_use, name), choice in sorted(_plugins_in_use.items()) if kind_in_use == kind
    }


@cache
def plugins() -> dict[str, dict[str, Choice]]:
    """Return what the entry points of installed packages add, by kind and name; nothing of these packages is imported.

    An entry point without a meaning is told and left out. The list is read once, where a name is not one of the library's.
    """
    from importlib.metadata import entry_points  # here: most processes need none

    found: dict[str, dict[str, Choice]] = {kind: {} for kind in TABLE}
    points = [
        (f"{point.dist.name} {point.dist.version}" if point.dist else "a package", point)
        for point in entry_points(group=ENTRY_POINTS)
    ]
    for package, point in sorted(points, key=lambda pair: (pair[0], pair[1].name)):
        kind, _, name = point.name.partition(".")
        former = TABLE.get(kind, {}).get(name) or found.get(kind, {}).get(name)
        if kind not in TABLE or not CHOICE_NAME.fullmatch(name) or not point.attr:
            example = "sampler.highest = my_package:highest"
            _warn(f"{package}: the entry point {point.name} = {point.value} is left out; write {example}")
        elif former is None:
            source = f"{point.module}:{point.attr}"
            found[kind][name] = Choice(source, name.replace("_", " "), package=package, name=name)
        elif former.source != point.value:  # the same package may be found twice on the path
            _warn(f"{package}: the {kind} {name!r} is left out: {origin(kind, former)} has that name already")
    return found


def _known(kind: str, name: str) -> Choice | None:
    """Return the choice of a name, or None; note that a package is in use."""
    if name in TABLE[kind]:
        return TABLE[kind][name]._replace(name=name)
    choice = _registered[kind].get(name) or plugins()[kind].get(name)
    if choice is not None and choice.package:
        _plugins_in_use[kind, name] = choice
    return choice


def _address(function: Any) -> str:
    """Return module:function."""
    return f"{getattr(function, '__module__', '')}:{getattr(function, '__qualname__', '')}"


def _refuse_taken(kind: str, name: str, function: Any, who: str, remedy: str) -> str:
    """Raise InputError if a name is taken by another function than a former version of this one; return its package.

    That has the same name in the same module, or is the entry point of the same package, which registers its own function.
    """
    former = _registered[kind].get(name) or TABLE[kind].get(name) or plugins()[kind].get(name)
    if former is None:
        return ""
    new, old = _address(function), former.address
    of_package = bool(former.package) and isinstance(former.source, str)
    of_package = of_package and re.split("[.:]", old)[0] == re.split("[.:]", new)[0]
    if former.is_built_in or not (new == old or of_package):
        raise InputError(
            f"{who}: there is a {KINDS[kind].word} {name!r} already ({former.origin}); {remedy}."
        )
    return former.package


def _arguments(kind: str, takes_dots: bool) -> tuple[str, ...]:
    """Return the arguments of the functions of a kind."""
    return ("dots",) if takes_dots else KINDS[kind].arguments


def _check_signature(kind: str, name: str, function: Any, takes_dots: bool) -> None:
    """Raise InputError unless a function can be called with the arguments of its kind."""
    word, hint = KINDS[kind].word, ""
    if not callable(function):
        if not isinstance(function, tuple):  # a descriptor or format with more than one function
            raise InputError(f"the {word} {name!r} is {function!r}; it must be a function.")
        return
    try:
        signature = inspect.signature(function)
    except (TypeError, ValueError):  # a function in C may have none
        return

    def accepts(arguments: tuple[str, ...]) -> bool:
        try:
            return signature.bind(*arguments) is not None
        except TypeError:
            return False

    arguments = _arguments(kind, takes_dots)
    if accepts(arguments):
        return
    if kind == "field" and not takes_dots and accepts(("dots",)):
        hint = ", or the dots alone if it is registered by sparsurf.register(..., takes_dots=True)"
    raise InputError(f"the {word} {name!r} takes {signature}; it must take ({', '.join(arguments)}){hint}.")


def _reason(error: Exception) -> str:
    """Return an error as the end of a sentence."""
    return f"{type(error).__name__}: {error}".rstrip(".: ") + "."


def _warn(message: str) -> None:
    """Log a warning once in a process."""
    if message not in _told:
        _told.add(message)
        import logging  # here: most processes warn of nothing

        logging.getLogger("sparsurf").warning("%s", message)
