"""Which structures of a run in batches can have a site: they are described again, and searched like any other target.

The stored places tell how similar the nearest place of each structure is to each place of the site. The site is superposed
onto the stored places of the structures with the highest sums, and those with the best poses are returned. All of this reads
one structure after the other, so that memory does not grow with the run.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from sparsurf import InputError
from sparsurf.batches.analysis import Structure, place_dots
from sparsurf.batches.tables import damaged, import_pyarrow, locate_structure, read_parquet, unpack_dots
from sparsurf.files import no_warnings
from sparsurf.progress import progress_bar
from sparsurf.sites.describing import Sites, describe_surface
from sparsurf.sites.finding import (
    MIN_DISTANCE,
    background,
    background_stride,
    check_alike,
    likelihoods,
    superposed_places,
)
from sparsurf.sites.metric import N_COMPONENTS, STEPS_PER_UNIT, fingerprint, to_metric_space
from sparsurf.sites.pose_search import DECIMALS, best_pose
from sparsurf.threads import available_cores, parallel_map

N_SUPERPOSED = 300  # structures, those with the most similar places, onto which the site is superposed
N_EXTRA = 5  # structures that are described again beyond the requested hits
DOT_COLUMNS = ["x32", "y32", "z32", "polar", "azimuth"]


class Group(NamedTuple):
    """The stored places of one structure: a row group of a Parquet file.

    path : file
    number : of the row group
    protein : name of the structure
    n_places : int
    begin : int, number of the first place among all of the run
    """

    path: Path
    number: int
    protein: str
    n_places: int
    begin: int


def has_places(folder: Path) -> bool:
    """Return whether a folder holds the tables of a run in batches.

    Raises
    ------
    InputError : it is one, but without places
    """
    if not any(folder.glob("surfaces/*.parquet")):
        return False
    if not any(folder.glob("places/*.parquet")):
        raise InputError(f"{folder} has no places: set `places: true` in the study and run again.")
    return True


def similar_structures(run: Path, site: Sites, n: int) -> list[Sites]:
    """Find the structures of a run on which a site can lie, and describe them again.

    Parameters
    ----------
    run : folder of the results of a study with `batch` and `places`
    site : Sites, the places of the site
    n : int, hits that are requested

    Returns
    -------
    list of Sites, of at most n + N_EXTRA structures, the most promising first

    Raises
    ------
    InputError : a table is damaged, the site was described otherwise, or a structure is missing or has changed
    """
    groups, settings = list_groups(run)
    check_alike(site, [_without_places(run, settings)])
    chosen = rank_structures(groups, site, n + N_EXTRA)
    return [describe_again(run, name, settings) for name in progress_bar(chosen, "structures to compare")]


def rank_structures(groups: Sequence[Group], site: Sites, n: int) -> list[str]:
    """Name the n structures on which a site fits best by the stored places, the best first.

    Parameters
    ----------
    groups : sequence of Group, of all structures
    site : Sites, the places of the site
    n : int
    """
    query = superposed_places(site)
    q = to_metric_space(query.numbers, query.fields)
    nearest, middle, scale = nearest_of_each(q, groups)
    similarity = likelihoods(nearest, middle, scale).sum(axis=0)
    superposed = [groups[k] for k in _best(similarity, N_SUPERPOSED)]
    scores = pose_scores(query, q, superposed, middle, scale)
    return [superposed[k].protein for k in _best(scores, n)]


def _best(scores: np.ndarray, n: int) -> np.ndarray:
    """Return indices of the n highest scores, the highest first; of equal ones the first."""
    return np.argsort(-scores.round(DECIMALS), kind="stable")[:n]


def _without_places(run: Path, settings: dict[str, Any]) -> Sites:
    """Return Sites that have the settings of a run and no places."""
    nothing = np.empty((0, 3), np.float32)
    return Sites(str(run), nothing, nothing, read_parquet(run, "surfaces").iloc[:0], nothing, settings)


def list_groups(run: Path) -> tuple[list[Group], dict[str, Any]]:
    """List the stored places of all structures.

    Returns
    -------
    groups : list of Group
    settings : dict, see `places.settings_of_places`

    Raises
    ------
    InputError : a file is damaged, or its places are of other settings or another version
    """
    groups: list[Group] = []
    found: dict[str, Any] = {}
    begin = 0
    for path in sorted((run / "places").glob("*.parquet")):
        with _open(path) as file:
            settings = json.loads(file.schema_arrow.metadata[b"sparsurf"])
            for number in range(file.metadata.num_row_groups):
                group = file.metadata.row_group(number)
                groups.append(Group(path, number, group.column(0).statistics.min, group.num_rows, begin))
                begin += group.num_rows
        if settings["metric"] != fingerprint() or (found and settings != found):
            raise InputError(
                f"{path} holds places of other settings or another version: run the study again."
            )
        found = settings
    if not groups:
        raise InputError(f"{run} has no structure with places; failures/ has the reasons.")
    return groups, found


@contextmanager
def _open(path: Path) -> Iterator[Any]:
    """Open a Parquet file; raise InputError where it is damaged."""
    pyarrow = import_pyarrow()
    try:
        with pyarrow.parquet.ParquetFile(path) as file:
            yield file
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise damaged(path, error) from None


def nearest_of_each(q: np.ndarray, groups: Sequence[Group]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Find the nearest stored place of each structure.

    Parameters
    ----------
    q : (Q, M) float64, places of the site in the metric space
    groups : sequence of G Group, of all structures

    Returns
    -------
    nearest : (Q, G) float, logarithm of the distance
    middle, scale : (Q,) float64, the `background` of the run
    """
    stride = background_stride(sum(group.n_places for group in groups))

    def of_group(file: Any, group: Group) -> tuple[np.ndarray, np.ndarray]:
        square = _squares(q, _components(file, group))
        return square.min(axis=1, keepdims=True), square[:, -group.begin % stride :: stride].copy()

    nearest, sample = zip(*_for_each(groups, of_group), strict=True)
    return _logarithm(np.hstack(nearest)), *background(_logarithm(np.hstack(sample)))


def pose_scores(
    query: Sites, q: np.ndarray, groups: Sequence[Group], middle: np.ndarray, scale: np.ndarray
) -> np.ndarray:
    """Superpose a site onto the stored places of each structure.

    Parameters
    ----------
    query : Sites
    q : (Q, M) float64, its places in the metric space
    groups : sequence of G Group
    middle, scale : (Q,) float64

    Returns
    -------
    (G,) float64, score of the best pose
    """
    points, normals = query.points.astype(float), query.normals.astype(float)

    def of_group(file: Any, group: Group) -> float:
        likelihood = likelihoods(_logarithm(_squares(q, _components(file, group))), middle, scale)
        there = unpack_dots(file.read_row_group(group.number, columns=DOT_COLUMNS).to_pandas())
        return best_pose(points, normals, *there, likelihood).score

    return np.array(_for_each(groups, of_group))


def _for_each(groups: Sequence[Group], function: Callable[[Any, Group], Any]) -> list[Any]:
    """Call a function with the open file of each group and the group, in threads."""

    def of_group(begin: int, _end: int) -> Any:
        with _open(groups[begin].path) as file:
            return function(file, groups[begin])

    return parallel_map(of_group, len(groups), available_cores(), 1)


def _components(file: Any, group: Group) -> np.ndarray:
    """Read the quantised components (n, M) int8 of a group."""
    column = file.read_row_group(group.number, columns=["numbers"], use_threads=False)["numbers"]
    return np.frombuffer(column.combine_chunks().buffers()[1], np.int8).reshape(-1, N_COMPONENTS)


def _squares(q: np.ndarray, components: np.ndarray) -> np.ndarray:
    """Return squares (Q, n) float32 of the distances to quantised places, in steps."""
    steps, places = (q * STEPS_PER_UNIT).astype(np.float32), components.astype(np.float32)
    square = steps @ places.T
    square *= -2
    square += np.einsum("ij,ij->i", places, places)
    square += np.einsum("ij,ij->i", steps, steps)[:, None]
    return square


def _logarithm(square: np.ndarray) -> np.ndarray:
    """Return the logarithm of distances, of at least MIN_DISTANCE, from their squares in steps."""
    distance = np.sqrt(np.maximum(square, 0).astype(float)) / STEPS_PER_UNIT
    return np.log(np.maximum(distance, MIN_DISTANCE))


def describe_again(run: Path, name: str, settings: dict[str, Any]) -> Sites:
    """Describe the places of a structure of a run from its file.

    Parameters
    ----------
    run : folder of the results
    name : of the structure
    settings : dict, see `places.settings_of_places`

    Returns
    -------
    Sites

    Raises
    ------
    InputError : the file is missing, or has changed
    """
    row = read_parquet(run, "surfaces", name).iloc[0]
    path = locate_structure(run, row["structure"])
    with no_warnings():
        structure = Structure(name, str(path), None, json.loads(row["options"]))
        molecule, dots = place_dots(structure, settings["surface"], settings["D_link"])[:2]
        if (molecule.n_atoms, len(dots)) != (row["atoms"], row["N"]):
            raise InputError(f"{path} has changed since the study: run the study again.")
        return describe_surface(
            dots, molecule, name, settings["percent"], settings["fields"], None, available_cores()
        )
