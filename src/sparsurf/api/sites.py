"""Sites: places of a surface that are described by numbers and searched for on other surfaces."""

from __future__ import annotations

import logging
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np

from sparsurf import InputError
from sparsurf.api.inputs import (
    PERCENT,
    Limits,
    SurfaceLike,
    as_dots,
    as_molecule,
    field_names,
    has_atoms,
    is_structure,
)
from sparsurf.api.surfaces import surface as surface_of
from sparsurf.batches.search import has_places, similar_structures
from sparsurf.files import shorten
from sparsurf.molecules.formats import suffix
from sparsurf.molecules.molecule import Molecule
from sparsurf.sites.describing import FIELDS, Sites, describe_surface, load_sites, places_of_residues
from sparsurf.sites.describing import PERCENT as DEFAULT_PERCENT
from sparsurf.sites.finding import find_places, find_site
from sparsurf.sites.pose_search import Pose
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.spacing import spacing
from sparsurf.surfaces.surface import Surface
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

SitesLike: TypeAlias = "Sites | SurfaceLike"

log = logging.getLogger("sparsurf")

MAX_SPACING_OF_SURFACE = 0.9  # Å between neighbouring dots: of a whole surface .4, of a tenth of its dots 1.4
MAX_DISTANCE = 5.0  # Å, between a requested point and the nearest place of Sites
HITS = Limits(1, 10_000, whole=True, open_low=False)


def describe_sites(
    surface: SurfaceLike,
    *,
    percent: float = DEFAULT_PERCENT,
    fields: str | Sequence[str] = FIELDS,
    at: ArrayLike | None = None,
    name: str | None = None,
) -> Sites:
    """Describe places on a surface by the numbers that `find` compares.

    Parameters
    ----------
    surface : molecule as in `surface`, or dots with fields: a Surface or the path of a file of dots
    percent : float
        Share of the dots that farthest-point sampling keeps for description; 100 for a subset, such as the dots of
        `sparsurf minimal`.
    fields : sequence of str
        What is compared besides the shape: hydropathy, volume, aromaticity, charge, potential.
    at : (T, 3) float, optional
        Points in Å to describe instead of the kept dots; points with too few dots around them are left out.
    name : str, optional
        Name in the table of hits; by default that of the file.

    Returns
    -------
    Sites
        With `points` (P, 3), `labels`, `numbers`; `save(path)` writes them, and `find` takes the file.

    Raises
    ------
    InputError
        One sentence on what is wrong.

    Examples
    --------
    >>> import sparsurf
    >>> peptide = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-216")
    >>> sites = sparsurf.describe_sites(peptide, name="peptide")
    >>> len(sites), sites.fields[0]
    (393, 'hydropathy')
    """
    percent, names = PERCENT.check(percent, "percent"), ordered_fields(fields)
    points = None if at is None else _points(at)
    dots, molecule = _dots_and_molecule(surface)
    if name is not None and not (isinstance(name, str) and name.isprintable()):
        raise InputError(f"name is {name!r}; it must be a string of printable characters.")
    if not name:
        name = _stem(surface) if isinstance(surface, str | Path) else "surface"
    if empty := [key for key in names if not np.isfinite(dots.fields.get(key, 0)).any()]:
        raise InputError(f"{name}: the field {empty[0]} has no numbers; leave it out of the fields.")
    with np.errstate(over="ignore"):  # an error follows below
        sites = describe_surface(dots, molecule, name, percent, names, points, available_cores())
    if not np.isfinite(sites.numbers).all():
        raise InputError(f"{name}: a field has numbers of 10,000 and more; write it in another unit.")
    if points is not None and len(sites) < len(points):
        message = "%s: %d of %d points are left out: too few dots are around them"
        log.warning(message, name, len(points) - len(sites), len(points))
    return sites


def find(
    query: SitesLike,
    targets: SitesLike | Sequence[SitesLike],
    *,
    at: ArrayLike | None = None,
    residues: str | None = None,
    n: int = 10,
    percent: float = DEFAULT_PERCENT,
    fields: str | Sequence[str] = FIELDS,
) -> pd.DataFrame:
    """Find places on other surfaces that resemble those of a query.

    Parameters
    ----------
    query : Sites, the path of a file of them, or what `describe_sites` takes
    targets : one of these, or a list; described with the settings of the query
        Or the folder of a run with `batch` and `places`, such as results/many, to find a site on any of its structures.
    at : (Q,) int places of the query, or (Q, 3) float points in Å
        Each place is searched for separately.
    residues : str, instead of `at`
        Ranges such as 'A:10-25,40': the site, searched for as a whole.
    n : int
        Number of hits of each place, or of the site.
    percent, fields : as for `describe_sites`; used for surfaces that are not described yet

    Returns
    -------
    DataFrame
        query (its name; without a site, the index into `at`), rank from 1, target, chain, residue, residue_name, x, y, z (Å),
        score; of a site also p, how often an unrelated protein scores as high (NaN where `percent` or `fields` are not the
        default), and `places`, how many agree. A higher score is a better hit.

    Raises
    ------
    InputError
        One sentence on what is wrong.

    Examples
    --------
    >>> import sparsurf
    >>> peptide = sparsurf.read_molecule("data/tdp43/topology.pdb", residues="209-216")
    >>> sites = sparsurf.describe_sites(peptide, name="peptide")
    >>> table = sparsurf.find(sites, sites, at=[3, 50], n=2)
    >>> table.loc[table["rank"] == 1, ["query", "target", "residue_name"]].values.tolist()
    [[0, 'peptide', 'PHE'], [1, 'peptide', 'TYR']]
    """
    return find_with_poses(query, targets, at, residues, n, percent, fields)[0]


def find_with_poses(
    query: SitesLike,
    targets: SitesLike | Sequence[SitesLike],
    at: ArrayLike | None = None,
    residues: str | None = None,
    n: int = 10,
    percent: float = DEFAULT_PERCENT,
    fields: str | Sequence[str] = FIELDS,
) -> tuple[pd.DataFrame, list[Pose] | None]:
    """Return the table of `find`, and the poses of its rows if a site is sought as a whole."""
    n = HITS.check(n, "n")
    if (at is None) == (residues is None):
        raise InputError("find: give either `at`, places, or `residues`, a site.")
    whole = as_sites(query, percent, fields)
    refuse_other_settings(whole, percent, fields)
    several: Any = targets if isinstance(targets, list | tuple) and not _is_pair(targets) else [targets]
    percent, fields = whole.settings["percent"], whole.fields
    if residues is None:
        if run := next(filter(is_run, several), None):
            raise InputError(f"{run} is searched for whole sites: give `residues` instead of `at`.")
        others = _with_unique_names([as_sites(target, percent, fields) for target in several])
        return find_places(_sought_places(query, whole, at), others, n, available_cores()), None
    site, others = whole.take(places_of_residues(whole, residues)), []
    for target in several:
        others += (
            similar_structures(Path(target), site, n)
            if is_run(target)
            else [as_sites(target, percent, fields)]
        )
    hits = find_site(site, _with_unique_names(others), n)
    fits = hits.table["places"].to_numpy() > 0
    if not fits.all():
        without = ", ".join(dict.fromkeys(hits.table.loc[~fits, "target"]))
        log.warning("no part of the site fits on %s", shorten(without))
    return hits.table[fits], [pose for pose, fit in zip(hits.poses, fits, strict=True) if fit]


def is_run(target: Any) -> bool:
    """Return whether a target is the folder of a run in batches; raise InputError if it has no places."""
    return isinstance(target, str | Path) and has_places(Path(target))


def as_sites(
    source: SitesLike, percent: float = DEFAULT_PERCENT, fields: str | Sequence[str] = FIELDS
) -> Sites:
    """Return Sites from themselves, the path of a file of them, or what `describe_sites` takes."""
    if isinstance(source, Sites):
        return source
    if isinstance(source, str | Path):
        if suffix(source) == ".sites":
            return load_sites(source)
        if PERCENT.check(percent, "percent") < 100 and not is_structure(source):
            distance = spacing(read_surface(source).points)
            if distance > MAX_SPACING_OF_SURFACE:
                log.warning(
                    "%s: its dots lie %.1f Å apart, as in a subset; %g %% of these are kept, which lowers scores: "
                    "recover the surface with `sparsurf recover` first",
                    source, distance, percent,
                )  # fmt: skip
    return describe_sites(source, percent=percent, fields=fields)


def refuse_other_settings(sites: Sites, percent: float, fields: str | Sequence[str]) -> None:
    """Raise InputError if settings differ from the default and from those that Sites were described by."""
    for key, requested, default in (
        ("percent", percent, DEFAULT_PERCENT),
        ("fields", ordered_fields(fields), FIELDS),
    ):
        used = tuple(sites.fields) if key == "fields" else sites.settings[key]
        if requested not in (default, used):
            shown = ", ".join(used) if key == "fields" else f"{used:g}"
            raise InputError(
                f"{key}: {sites.name} was described with {shown}; leave the option out, or give the structure."
            )


def ordered_fields(fields: Any) -> tuple[str, ...]:
    """Return names of fields in the order of the numbers in Sites."""
    names = field_names(fields, "fields")
    return tuple(sorted(names, key=lambda name: FIELDS.index(name) if name in FIELDS else len(FIELDS)))


def _stem(path: str | Path) -> str:
    """Return the name of a file without its suffixes."""
    return Path(Path(path).name.removesuffix(".gz")).stem


def _is_pair(targets: Any) -> bool:
    """Return whether targets are the pair (points, normals) of one surface."""
    return isinstance(targets, tuple) and len(targets) == 2 and np.ndim(targets[0]) == 2


def _with_unique_names(targets: Sequence[Sites]) -> list[Sites]:
    """Append a number to the names of targets that share one, in their order."""
    numbers: dict[str, int] = {}
    renamed = []
    for target in targets:
        k = numbers[target.name] = numbers.get(target.name, 0) + 1
        renamed.append(replace(target, name=f"{target.name} ({k})") if k > 1 else target)
    for name, k in numbers.items():
        if k > 1:
            log.warning("%d targets are called %s: their numbers follow the order given", k, name)
    return renamed


def _dots_and_molecule(source: Any) -> tuple[Surface, Molecule | None]:
    """Return the dots of a structure with its molecule; those of anything else without."""
    if not has_atoms(source):
        return as_dots(source), None
    molecule = as_molecule(source)
    if molecule.n_frames > 1:
        log.warning("%s has %d models: the first is taken", source, molecule.n_frames)
    molecule = molecule.frame(0)
    return surface_of(molecule), molecule


def _points(at: Any) -> np.ndarray:
    """Return points (Q, 3) float64, Å."""
    points = _as_array(at)
    if points.ndim != 2 or points.shape[1] != 3 or points.dtype.kind not in "iuf" or not len(points):
        shape = f"shape {points.shape}" if points.dtype.kind in "iuf" else "something else"
        raise InputError(f"at: give (Q,) numbers of places or (Q, 3) points in Å, not {shape}.")
    if not np.isfinite(points).all():
        wrong = np.argmin(np.isfinite(points).all(axis=1))
        raise InputError(f"at: point {wrong} has NaN or infinity; leave it out.")
    return points.astype(float)


def _as_array(at: Any) -> np.ndarray:
    """Return an array; one of no numbers if the rows have unequal lengths."""
    try:
        return np.asarray(at)
    except ValueError:
        return np.empty(0, object)


def _sought_places(query: Any, whole: Sites, at: Any) -> Sites:
    """Return the places of a query that are sought."""
    indices = _as_array(at)
    if indices.ndim == 1 and indices.dtype.kind in "iu":
        if len(indices) == 0 or indices.min() < 0 or indices.max() >= len(whole):
            raise InputError(f"at: the query has the places 0 to {len(whole) - 1}.")
        return whole.take(indices)
    points = _points(at)
    if isinstance(query, Sites) or (isinstance(query, str | Path) and suffix(query) == ".sites"):
        from scipy.spatial import cKDTree

        distance, nearest = map(np.asarray, cKDTree(whole.points).query(points))
        if distance.max() > MAX_DISTANCE:
            raise InputError(
                f"at: point {distance.argmax()} is {distance.max():.0f} Å away from {whole.name}; give points on it."
            )
        return whole.take(nearest)
    described = describe_sites(query, percent=whole.settings["percent"], fields=whole.fields, at=points)
    if len(described) < len(points):
        raise InputError(
            f"at: {len(points) - len(described)} points have too few dots around them; give points on the surface."
        )
    return described
