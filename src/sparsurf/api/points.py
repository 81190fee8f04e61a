"""A few points with normals on the surface of a molecule, or of every structure of a folder, for whoever learns on surfaces."""

from __future__ import annotations

import json
import logging
import os
import pickle
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, cast

import numpy as np

from sparsurf.api.field_values import check_fields, refuse_maps, with_fields
from sparsurf.api.inputs import MoleculeLike, as_spheres, first_group
from sparsurf.api.parts import digest_of_arguments, forget_other_parts, part_file, write_part
from sparsurf.api.surfaces import placement
from sparsurf.arguments import DENSITY_LIMITS, NUMBER_OF_DOTS, PROBE, SEED, Cavities, Limits, RadiiLike
from sparsurf.errors import InputError
from sparsurf.files import as_path, checksum_of_file, import_pyarrow, pluralise, shorten
from sparsurf.messages import kind_of_warning, listening
from sparsurf.molecules.formats import STRUCTURES, stem, suffix, title
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.selection import Groups
from sparsurf.patches.index import D_LINK, build_grid
from sparsurf.progress import Progress, progress_bar
from sparsurf.sampling.farthest_point import farthest_points
from sparsurf.streams import DEFAULT_SEED, stream
from sparsurf.suggestions import public
from sparsurf.surfaces.chosen_points import NamedPoints, Points, on_steps
from sparsurf.surfaces.molecular_surface import MAX_DENSITY, RolledFrame, roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.spacing import DENSITY as PUBLISHED_DENSITY
from sparsurf.surfaces.surface import MAX_AREA, Rules, Surface, SurfaceOrigin
from sparsurf.threads import available_cores, in_processes

if TYPE_CHECKING:
    import pandas as pd
    from numpy.typing import ArrayLike

    from sparsurf.dot_fields.registry import FieldLike

log = logging.getLogger("sparsurf")

N_POINTS = 1024
DOTS_PER_POINT = 2.0  # placed for each point that is chosen, at least
JOBS = Limits(1, 1024, whole=True, open_low=False)
STRUCTURES_PER_JOB = 4  # that wait for their turn
TABLE_FORMAT = ".parquet"
ROWS_PER_GROUP = 100_000  # of a Parquet file
# In a stored table: the beginning of the names of its columns, and the name of its warnings
COLUMN_OF_PART, WARNINGS_OF_PART = "column ", "warnings"


class PointsRequest(NamedTuple):
    """What is requested of every structure, checked."""

    n_dots: int | None
    density: float | None
    seed: int
    rules: Rules
    fields: tuple[FieldLike, ...]


@public()
def points(
    molecule: MoleculeLike | tuple[ArrayLike, ArrayLike],
    n_dots: int | None = None,
    *,
    density: float | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    seed: int = DEFAULT_SEED,
    frame: int = 0,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "remove",
    groups: Groups | None = None,
) -> Points:
    """Choose points with normals on the solvent-excluded surface of a molecule, as far from one another as possible.

    The points lie exactly on the surface, and their normals are analytic. The same molecule gives the same bytes on every
    machine.

    Parameters
    ----------
    molecule : path, Molecule, atoms of another library, or pair (xyz, radii)
        The molecule, as for `surface`.
    n_dots : int, optional
        Number of points (default 1024, unless `density` is given).
    density : float, optional
        Instead of `n_dots`, the number of points per Å^2.
    fields : str, callable, or sequence of these
        Values at the points (default none): 'roughness', that of the dense surface at the same place, and any name that
        `fields` accepts, such as 'hydropathy'.
    seed : int
        Seed for the choice of the first point, from which all others follow (default 20261120).
    frame : int
        Position of the frame of the molecule, from 0 (default 0).
    probe_radius : float
        Radius of the probe, Å (default 1.4).
    radii : {'dms', 'bondi'}, dict, or path
        Atomic radii, as for `surface` (default 'dms').
    cavities : {'remove', 'keep'}
        Whether closed cavities inside the molecule are left without points (default 'remove').
    groups : str or sequence, optional
        Groups of partners, as in `areas`: the points lie on the surface of the first group alone, and the field 'burial' says
        how deep they lie below the surface of all groups (default None, all atoms).

    Returns
    -------
    Points
        The pair of `points` and `normals`, (n_dots, 3) float32 each, Å, which can be unpacked. Its length is that of a pair, 2,
        and its attribute `n_dots` is the number of points. The first m points are
        themselves spread as far as m points can be by this method. It also has `area` (Å^2 that each point stands for),
        `kind`, `atom`, `fields` and `to_frame`, which names the residue and the atom of every point.

    Raises
    ------
    InputError
        The molecule cannot be read, an argument is outside of its limits, or so many points cannot be placed.

    Examples
    --------
    >>> import sparsurf
    >>> points, normals = sparsurf.points("data/tdp43/topology.pdb", n_dots=512)
    >>> points.shape, normals.dtype
    ((512, 3), dtype('float32'))
    >>> len(sparsurf.points("data/tdp43/topology.pdb", density=0.5).atom)
    2241

    With labels, the area that each point stands for, and fields:

    >>> few = sparsurf.points("data/tdp43/topology.pdb", n_dots=512, fields=["roughness", "hydropathy"])
    >>> list(few.to_frame())[6:]
    ['area', 'kind', 'chain', 'residue', 'residue_name', 'atom_name', 'atom', 'roughness', 'hydropathy']
    """
    request = _checked(n_dots, density, fields, seed, probe_radius, radii, cavities)
    return _chosen(molecule, frame, request, available_cores(), groups)


def _checked(
    n_dots: int | None,
    density: float | None,
    fields: FieldLike | Sequence[FieldLike],
    seed: int,
    probe_radius: float,
    radii: RadiiLike,
    cavities: Cavities,
) -> PointsRequest:
    """Check the arguments of `points` and `points_of`."""
    if n_dots is not None and density is not None:
        raise InputError("points: give either n_dots or density, not both.")
    if density is not None:
        density = DENSITY_LIMITS.check(density, "density")
    else:
        n_dots = NUMBER_OF_DOTS.check(N_POINTS if n_dots is None else n_dots, "n_dots")
    rules = placement(PROBE.check(probe_radius, "probe_radius"), "auto", radii, cavities)
    return PointsRequest(n_dots, density, SEED.check(seed, "seed"), rules, check_fields(fields, "points"))


def _chosen(
    molecule: Any, frame: int, request: PointsRequest, threads: int, groups: Groups | None = None
) -> Points:
    """Choose points of one molecule, or of the first of some groups."""
    rules, partner = request.rules, None
    if groups is not None:
        molecule, partner = first_group(molecule, frame, groups, rules.radii)
    atoms, frame, atom_radii = as_spheres(molecule, frame, rules.radii)
    xyz = atoms.xyz[frame].round(3)
    rolled = roll_spheres(xyz, atom_radii, rules.probe_radius, cavities=rules.cavities)
    dots, n, placed = _dense_dots(rolled, request.n_dots, request.density)
    chosen, nearest = farthest_points(build_grid(on_steps(dots.points)), n, stream(request.seed, "points"))
    area = np.bincount(nearest, dots.area, n)
    origin = SurfaceOrigin.of_atoms(
        atoms if isinstance(atoms, Molecule) else None, frame, xyz, rules, D_LINK, atom_radii
    )
    origin = replace(origin, partner=partner)
    few = Surface(
        dots.points[chosen].astype(np.float32),
        dots.normals[chosen].astype(np.float32),
        area if area.max() < MAX_AREA else None,
        dots.kind[chosen],
        dots.atom[chosen],
        origin=origin,
    )

    def dense() -> Surface:
        published = dots if placed == PUBLISHED_DENSITY else None
        return rolled.surface_for_d_link("auto", D_LINK, "points", published)[0]

    return Points(with_fields(few, request.fields, dense, "points", threads))


def _dense_dots(rolled: RolledFrame, n_dots: int | None, density: float | None) -> tuple[Surface, int, float]:
    """Place dots from which points can be chosen, and return the number of points and the density of the dots, per Å^2."""
    placed = max(PUBLISHED_DENSITY, DOTS_PER_POINT * (density or 0.0))
    while True:
        placed = min(placed, float(MAX_DENSITY))
        dots = rolled.surface(placed)
        n = max(1, round(density * float(dots.area.sum()))) if density else n_dots
        assert n is not None  # one of both is given
        if len(dots) >= DOTS_PER_POINT * n or (placed == MAX_DENSITY and len(dots) >= n):
            return dots, n, placed
        if placed == MAX_DENSITY:
            raise InputError(
                f"points: {n:,} points on {dots.area.sum():,.0f} Å^2 are more than {MAX_DENSITY} per Å^2; ask for fewer."
            )
        placed *= 1.05 * DOTS_PER_POINT * n / len(dots)


class StoredPoints(NamedTuple):
    """The table of the points of a structure, which a call stored that may have been stopped."""

    name: str
    file: Path

    def to_frame(self) -> pd.DataFrame:
        """Return the table as `Points.to_frame` does."""
        import pandas as pd  # here: it takes long to load

        with np.load(self.file, allow_pickle=False) as arrays:
            names = [name for name in arrays.files if name.startswith(COLUMN_OF_PART)]
            return pd.DataFrame({name.removeprefix(COLUMN_OF_PART): arrays[name] for name in names})

    def warnings(self) -> list[tuple[str, str]]:
        """Return the kind and the sentence of each warning that the file of the structure caused."""
        with np.load(self.file, allow_pickle=False) as arrays:
            return [(str(kind), str(sentence)) for kind, sentence in arrays[WARNINGS_OF_PART]]


class PointsOfFolder(Iterator[NamedPoints]):
    """The points of each structure of a folder, one after the other by name.

    Attributes
    ----------
    failures : dict, name -> str, why a structure is left out; complete at the end
    """

    def __init__(self, files: dict[str, Path], request: PointsRequest, jobs: int) -> None:
        self.failures: dict[str, str] = {}
        self.n_before = 0  # structures that were finished by a call that was stopped
        self._files, self._request, self._jobs = files, request, jobs
        self._notes: dict[str, list[tuple[str, str]]] = {}  # by kind of warning: name and sentence
        self._n_structures = len(files)
        outcomes = zip(files, self._outcomes(files), strict=True)
        self._results = self._successes(progress_bar(outcomes, "structures", len(files)))

    def __next__(self) -> NamedPoints:
        return next(self._results)

    def stored(self, store: Path, result: str | Path) -> Iterator[StoredPoints]:
        """Yield the table of each structure, which is stored before; what a stopped call has stored is taken from there.

        `store` is the folder of the parts of the file `result`.
        """
        parts = {name: part_file(store, _digest(path, self._request)) for name, path in self._files.items()}
        forget_other_parts(store, parts.values(), str(result), "structure")
        missing = {name: path for name, path in self._files.items() if not parts[name].exists()}
        self.n_before = len(parts) - len(missing)
        progress = Progress("structures", len(parts), self.n_before)
        outcomes = self._outcomes(missing)
        for name, part in parts.items():
            few = StoredPoints(name, part)
            outcome = next(outcomes) if name in missing else Outcome(None, few.warnings())
            self._note(name, outcome)
            if isinstance(outcome.result, Points):
                columns = {
                    f"{COLUMN_OF_PART}{key}": column for key, column in outcome.result.columns().items()
                }
                write_part(part, columns | {WARNINGS_OF_PART: np.array(outcome.warnings, str).reshape(-1, 2)})
            if name in missing:
                progress.advance()
            if name not in self.failures:
                yield few
        progress.close()
        self._report()

    def _outcomes(self, files: dict[str, Path]) -> Iterator[Outcome]:
        """Yield what becomes of each of some structures, in order."""
        threads = available_cores() if self._jobs == 1 else 1
        choose = partial(_outcome, request=self._request, threads=threads)
        paths = files.values()
        yield from (
            map(choose, paths)
            if self._jobs == 1
            else in_processes(choose, paths, self._jobs, STRUCTURES_PER_JOB)
        )

    def _successes(self, outcomes: Iterable[tuple[str, Outcome]]) -> Iterator[NamedPoints]:
        """Yield the points that there are, and report at the end what was wrong."""
        for name, outcome in outcomes:
            self._note(name, outcome)
            if isinstance(outcome.result, Points):
                yield NamedPoints.of_points(name, outcome.result)
        self._report()

    def _note(self, name: str, outcome: Outcome) -> None:
        """Keep the warnings on a structure, and why it has no points."""
        for kind, sentence in outcome.warnings:
            self._notes.setdefault(kind, []).append((name, sentence))
        if isinstance(outcome.result, str):
            self.failures[name] = outcome.result

    def _report(self) -> None:
        """Log one line for each kind of warning, and one for the structures that are left out."""
        for notes in self._notes.values():
            names = list(dict.fromkeys(name for name, _ in notes))
            if len(names) == 1:
                log.warning("%s: %s", names[0], notes[0][1])
            else:
                log.warning("%d of %d structures, such as %s: %s", len(names), self._n_structures, *notes[0])
        if self.failures:
            reasons = "; ".join(f"{name}: {reason.rstrip('.')}" for name, reason in self.failures.items())
            n = len(self.failures)
            left_out = (
                f"{n} of {pluralise(self._n_structures, 'structure')} {'is' if n == 1 else 'are'} left out"
            )
            log.warning("%s: %s", left_out, reasons)


@public()
def points_of(
    folder: str | Path | Sequence[str | Path],
    n_dots: int | None = None,
    *,
    density: float | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    seed: int = DEFAULT_SEED,
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "remove",
    jobs: int = 1,
) -> PointsOfFolder:
    """Choose points with normals on the surface of every structure of a folder, or of a list of files.

    Parameters
    ----------
    folder : str or Path, or list of these
        Folder whose .pdb, .ent, .cif and .mmcif files are read, also compressed (.gz), or a list of files.
    n_dots : int, optional
        Number of points on each structure, as for `points` (default 1024, unless `density` is given).
    density : float, optional
        Instead of `n_dots`, the number of points per Å^2.
    fields : str, callable, or sequence of these
        Values at the points, as for `points` (default none).
    seed : int
        Seed for the choice of each first point (default 20261120).
    probe_radius : float
        Radius of the probe, Å (default 1.4).
    radii : {'dms', 'bondi'}, dict, or path
        Atomic radii, as for `surface` (default 'dms').
    cavities : {'remove', 'keep'}
        Whether closed cavities are left without points (default 'remove').
    jobs : int
        Number of processes (default 1); the results do not depend on it.

    Yields
    ------
    name : str
        Name of the file without its suffixes; the structures follow one another in the order of their names, and those of a
        list in its order.
    points, normals : (n_dots, 3) float32
        Å and unit vectors. The triple of name, points and normals also has the attributes of `Points`, such as `atom`,
        `fields` and `to_frame`. A structure that fails is left out: the attribute `failures` of the iterator holds its name
        and the reason. At the end, one warning sums up these failures, and one more sums up each kind of warning.

    Raises
    ------
    InputError
        An argument is outside of its limits, a file of the list does not exist, or the folder or the list has no structure or two
        of the same name.

    Examples
    --------
    >>> import sparsurf
    >>> for name, points, normals in sparsurf.points_of("data/tdp43", n_dots=256):
    ...     print(name, points.shape)
    topology (256, 3)

    With labels:

    >>> results = sparsurf.points_of("data/tdp43", n_dots=256, fields="roughness")
    >>> [(few.name, few.atom.shape, few.fields["roughness"].dtype) for few in results]
    [('topology', (256,), dtype('float32'))]
    >>> results.failures
    {}
    """
    request = _checked(n_dots, density, fields, seed, probe_radius, radii, cavities)
    refuse_maps(request.fields, "points_of")
    jobs = JOBS.check(jobs, "jobs")
    if jobs > 1:
        try:
            pickle.dumps(request)
        except (pickle.PicklingError, AttributeError, TypeError):
            raise InputError(
                "points_of: a field is a function inside another one, which cannot be sent to other processes; define it at "
                "the top of a module or notebook, or use jobs=1."
            ) from None
    return PointsOfFolder(structures_in(folder), request, jobs)


def structures_in(folder: str | Path | Sequence[str | Path]) -> dict[str, Path]:
    """Return the structures of a folder or of a list by name, which is that of the file without its suffixes."""
    if isinstance(folder, list | tuple):
        paths, where, has_folders = [as_path(file) for file in folder], "the list of files", False
        for path in paths:
            if not os.path.isfile(path):  # unlike that of a Path, for names of any length
                reason = "is a folder" if os.path.isdir(path) else "does not exist"
                raise InputError(
                    f"{shorten(path)} {reason}; give one folder, or a list of the files of structures."
                )
    else:
        one_folder = as_path(cast("str | Path", folder))
        if not os.path.isdir(one_folder):
            raise InputError(f"{shorten(folder)} is not a folder; name a folder of structures.")
        by_name = sorted(one_folder.iterdir(), key=lambda path: (stem(path), path.name))
        paths = [path for path in by_name if suffix(path) in STRUCTURES and path.is_file()]
        where, has_folders = str(folder), any(path.is_dir() for path in by_name)
    files: dict[str, Path] = {}
    for path in paths:
        name = title(path)
        if name in files:
            first = files[name]
            pair = (first.name, path.name) if first.parent == path.parent else (first, path)
            raise InputError(
                f"{where} holds {pair[0]} and {pair[1]}, which have the same name; rename one of them."
            )
        files[name] = path
    if not files:
        below = "; it has folders, which are not searched: give one of them" if has_folders else ""
        raise InputError(f"{where} holds no structure ({', '.join(STRUCTURES)}, also compressed){below}.")
    return files


class Outcome(NamedTuple):
    """The points of a structure, or why there are none, and the warnings that its file caused: their kind and sentence.

    The result is None where the points are stored.
    """

    result: Points | str | None
    warnings: list[tuple[str, str]]


def _digest(path: Path, request: PointsRequest) -> Any:
    """Return a hash of all that the points of a structure follow from."""
    arguments = request._replace(fields=())
    return digest_of_arguments(*arguments, checksum_of_file(path), fields=request.fields)


def _outcome(path: Path, request: PointsRequest, threads: int) -> Outcome:
    """Return the points of a structure, or why there are none."""
    heard: list[logging.LogRecord] = []
    with listening(heard.append):
        try:
            result: Points | str = _chosen(path, 0, request, threads)
        except InputError as error:
            result = str(error)
        except MemoryError:
            result = f"{path} needs more memory than there is."
    head = f"{path}: "
    return Outcome(
        result, [(kind_of_warning(record), record.getMessage().removeprefix(head)) for record in heard]
    )


def write_table_of_points(
    path: Path, named: Iterable[NamedPoints | StoredPoints], written: list[int], failures: dict[str, str]
) -> None:
    """Write a Parquet table of all points, a few structures at a time; count the points of each in `written`.

    `failures`, which is complete when all structures were taken, is stored in the metadata.
    """
    import pandas as pd  # here: a file of another format needs no table

    pyarrow = import_pyarrow()
    waiting: list[pd.DataFrame] = []
    writer = None
    try:
        for few in named:
            table = few.to_frame()
            table.insert(0, "name", few.name)
            waiting.append(table)
            written.append(len(table))
            if writer is None:
                schema = _schema(pyarrow, table)
                writer = pyarrow.parquet.ParquetWriter(path, schema, compression="zstd")
            if sum(map(len, waiting)) >= ROWS_PER_GROUP:
                writer.write_table(
                    pyarrow.Table.from_pandas(pd.concat(waiting), schema, preserve_index=False)
                )
                waiting = []
        if writer is None:
            raise InputError("points: all structures failed; the warnings give the reasons.")
        if waiting:
            writer.write_table(pyarrow.Table.from_pandas(pd.concat(waiting), schema, preserve_index=False))
        writer.add_key_value_metadata({"failures": json.dumps(failures, ensure_ascii=False)})
    finally:
        if writer is not None:
            writer.close()


def _schema(pyarrow: Any, table: pd.DataFrame) -> Any:
    """Return the types of the columns: text, and numbers as they are."""
    import pandas as pd

    types = {
        name: pyarrow.string()
        if pd.api.types.is_string_dtype(column)
        else pyarrow.from_numpy_dtype(column.dtype)
        for name, column in table.items()
    }
    return pyarrow.schema(list(types.items()))
