"""The surface of every frame of a trajectory as tables: of residues in frames, of frames, ranked residues and contacts."""

from __future__ import annotations

import dataclasses
import logging
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple, overload

import numpy as np

from sparsurf.api.areas import (
    contacts_over_frames,
    maximal_areas,
    sums_of_contacts,
)
from sparsurf.api.checkpoints import FORMATS, digest_of_arguments, in_parts, store_beside, table_writers
from sparsurf.api.field_values import EXACT_AREAS, RESIDUE_COLUMNS, check_ranked_fields
from sparsurf.api.inputs import MoleculeLike, as_molecule, opened_source
from sparsurf.api.replacing import (
    COLUMNS_OF_CONTACTS,
    COLUMNS_OF_RANKING,
    FRAME_COLUMNS,
    beside_frames,
    path_of_frames,
    refuse_replacing,
)
from sparsurf.api.surfaces import placement
from sparsurf.api.writing import parse_output, write_file
from sparsurf.arguments import (
    RANK,
    RANK_BY,
    Cavities,
    RadiiLike,
    Ranking,
    frames_between,
    public,
)
from sparsurf.dot_fields.depth import depth_below, depth_of_residues
from sparsurf.dot_fields.named_fields import FieldLike, compute_fields, names_of_fields
from sparsurf.errors import InputError, naming_file
from sparsurf.evaluation.frames import FrameSurface, naming_frame, surface_of_frame
from sparsurf.evaluation.ranking import rank_residues, why_none_is_ranked
from sparsurf.evaluation.residues import residue_table
from sparsurf.files import import_pyarrow
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.overlaps import refuse_overlapping_partners
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.molecules.selection import Groups, Partners, groups_of_atoms, partners_of_atoms
from sparsurf.molecules.source import Source
from sparsurf.molecules.trajectory import EVERY_FRAME, check_frames
from sparsurf.patches.index import D_LINK
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.areas import areas_of_rolled, contacts_of_rolled
from sparsurf.surfaces.components import columns_of_components, summarize_components, without_cavities
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_frame
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.radii import radii as atomic_radii
from sparsurf.surfaces.spacing import DENSITY
from sparsurf.surfaces.surface import Placement, Surface, SurfaceOrigin
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger("sparsurf")

# So many frames are stored together, and at most so many are computed again after a stop.
FRAMES_PER_PART = 10
SUMMED_AREAS = ("accessible", "buried")  # of residues over a frame
OF_FRAMES = ("xyz", "time_ps", "frame_number")  # arrays of a molecule with a row for each frame


class FrameTables(NamedTuple):
    """The tables of `frames`, with the numbers of `residues(surface(molecule, frame=...))` and `areas(molecule, frame=...)`.

    Beside the file run.csv of `residues`, the others are called run_frames.csv, run_ranking.csv and run_contacts.csv.

    Attributes
    ----------
    residues : DataFrame, a row for each residue in each frame: frame (from 0), time_ps, chain, residue, residue_name, area (Å^2),
        mean_roughness (1 is flat, 0 is rough; NaN if buried), depth (Å), accessible (Å^2), relative, buried (Å^2) and fields
    frames : DataFrame, a row for each frame: areas (Å^2), volume (Å^3), components, cavities, dots and mean_roughness
    ranking : DataFrame, a row for each residue, the one that changes most first: rank, quantity, mean, sd, lowest, highest,
        range, the number of `frames` with a value and mean_area (Å^2). Means over dots count in frames in which the residue has
        at least 20 Å^2, and areas of residues with as much in the mean. Residues with a value in fewer than half of the frames,
        or without a change, come last, without a rank
    contacts : DataFrame, a row for each residue and each partner that buries some of it: occupancy (share of the frames with at
        least 1 Å^2), mean and highest buried area (Å^2)
    """

    residues: pd.DataFrame
    frames: pd.DataFrame
    ranking: pd.DataFrame
    contacts: pd.DataFrame


class Written(NamedTuple):
    """What `frames` has written to a `path`.

    Attributes
    ----------
    n_frames : int, number of frames that were measured
    n_before : int, number of them that a call that was stopped had finished
    ranking : DataFrame, the table of ranked residues
    """

    n_frames: int
    n_before: int
    ranking: pd.DataFrame


class FramesRequest(NamedTuple):
    """What is requested of every frame, checked."""

    rules: Placement
    fields: tuple[FieldLike, ...]
    rank: str = RANK  # name of the quantity by which residues are ranked
    rank_by: Ranking = RANK_BY
    groups: Groups | None = None
    only_areas: bool = False

    @property
    def names(self) -> list[str]:
        """Names of the columns of the fields."""
        return [f"mean_{name}" for name in names_of_fields(self.fields)]

    @property
    def columns(self) -> tuple[str, ...]:
        """Names of the columns of numbers of the table of residues."""
        return EXACT_AREAS if self.only_areas else (*RESIDUE_COLUMNS, *self.names)

    @property
    def frame_columns(self) -> tuple[str, ...]:
        """Names of the columns of numbers of the table of frames."""
        return SUMMED_AREAS if self.only_areas else FRAME_COLUMNS

    @property
    def ranked_column(self) -> str:
        """Name of the column by which residues are ranked."""
        return self.rank if self.rank in RESIDUE_COLUMNS else f"mean_{self.rank}"


class Part(NamedTuple):
    """The numbers of some frames: (n, columns) of frames, (n, residues, columns) of residues, and (m, 3) of contacts."""

    frames: np.ndarray
    residues: np.ndarray
    contacts: np.ndarray  # residue, partner and buried area, frame after frame


@overload
def frames(
    molecule: MoleculeLike,
    trajectory: str | Path | None = ...,
    *,
    path: None = None,
    stride: int = ...,
    start: int = ...,
    stop: int | None = ...,
    fields: FieldLike | Sequence[FieldLike] = ...,
    probe_radius: float = ...,
    radii: RadiiLike = ...,
    cavities: Cavities = ...,
    rank: FieldLike = ...,
    rank_by: Ranking = ...,
    groups: Groups | None = ...,
    only_areas: bool = ...,
    jobs: int = ...,
) -> FrameTables: ...


@overload
def frames(
    molecule: MoleculeLike,
    trajectory: str | Path | None = ...,
    *,
    path: str | Path,
    stride: int = ...,
    start: int = ...,
    stop: int | None = ...,
    fields: FieldLike | Sequence[FieldLike] = ...,
    probe_radius: float = ...,
    radii: RadiiLike = ...,
    cavities: Cavities = ...,
    rank: FieldLike = ...,
    rank_by: Ranking = ...,
    groups: Groups | None = ...,
    only_areas: bool = ...,
    jobs: int = ...,
) -> Written: ...


@public()
def frames(
    molecule: MoleculeLike,
    trajectory: str | Path | None = None,
    *,
    path: str | Path | None = None,
    stride: int = 1,
    start: int = 0,
    stop: int | None = None,
    fields: FieldLike | Sequence[FieldLike] = (),
    probe_radius: float = PROBE_RADIUS,
    radii: RadiiLike = "dms",
    cavities: Cavities = "keep",
    rank: FieldLike = RANK,
    rank_by: Ranking = RANK_BY,
    groups: Groups | None = None,
    only_areas: bool = False,
    jobs: int = 1,
) -> FrameTables | Written:
    """Measure the surface of every frame of a trajectory, and rank its residues by how much they change from frame to frame.

    Parameters
    ----------
    molecule : path, Molecule, or atoms of another library
        The structure of the trajectory, or a molecule that has several frames, such as the models of a file.
    trajectory : path, optional
        Trajectory that belongs to the structure `molecule`.
    path : str or Path, optional
        File in .csv or .parquet (needs pyarrow) for the residues, with the other tables next to it; a stopped call continues.
    stride, start, stop, jobs : int
        Every stride-th frame is measured (default 1, all frames), from position `start` (default 0) up to the one before `stop`
        (default to the end), by `jobs` processes (default 1), on which no result depends.
    fields : str, callable, or sequence of these
        Fields whose mean is taken over the dots of each residue (default none); any name that `fields` accepts.
    probe_radius, radii, cavities : as in `surface`
        How the surface is made, with the same defaults. If cavities are removed, their walls are also no accessible area.
    rank : str or callable
        What the residues are ranked by: 'roughness' (the default), 'area', 'depth', 'accessible', 'relative', 'buried', or any
        field, which is measured as well if `fields` leaves it out.
    rank_by : {'sd', 'range'}
        Whether the standard deviation over the frames counts, or the highest minus the lowest value (default 'sd').
    groups : str or sequence, optional
        Partners that bury each other, as in `areas`; atoms of no group are absent (default: each chain and each ligand).
    only_areas : bool
        Leave out the dots, and with them all columns but accessible, relative and buried, whose sums are the columns of frames;
        residues are then ranked by one of these, by default the first (default False).

    Returns
    -------
    FrameTables, or Written if `path` is given: memory then does not grow with the number of frames
        The tables `residues`, `frames`, `ranking` and `contacts`; `help(tables)`, of the result, lists their columns and units.
        Of what is written, `n_frames`, `n_before` (frames that a stopped call had finished) and `ranking`.

    Raises
    ------
    InputError
        The trajectory or an argument does not fit, a frame has no surface, or a file of another kind would be replaced.

    Examples
    --------
    >>> import sparsurf
    >>> tables = sparsurf.frames("data/tdp43/topology.pdb", "data/tdp43/trajectory.xtc", stride=500)
    >>> tables.ranking[["residue_name", "residue", "frames"]].to_numpy().tolist()[:2]
    [['VAL', '255', 2], ['CYS', '244', 3]]
    """
    span = frames_between(start, stop, stride)
    rules = placement(probe_radius, "auto", radii, cavities)
    request = frames_request("frames", rules, fields, rank, rank_by, only_areas)._replace(groups=groups)
    if path is not None:
        parse_output(path, FORMATS)
        refuse_replacing(path, (molecule, trajectory), beside_frames(path))
    source = opened_source(molecule)
    if trajectory is not None and not isinstance(source, Source):
        raise InputError(
            "frames: a trajectory belongs to the path of a structure; give that as the molecule."
        )
    if isinstance(source, Source):
        atoms = read_molecule(source, trajectory, stride=stride, start=start, stop=stop, groups=groups)
    else:
        atoms = _every(as_molecule(source, groups), span)
    if path is None:
        import pandas as pd  # here: it takes long to load

        parts = [part for _, part in _parts(atoms, request, jobs)]
        tables = _all_tables(atoms, request, lambda: iter(parts)).values()
        return FrameTables(*(pd.concat(table, ignore_index=True) for table in tables))
    return _write_frames(atoms, request, path, jobs)


def frames_request(
    function: str,
    rules: Placement,
    fields: FieldLike | Sequence[FieldLike],
    rank: FieldLike | None,
    rank_by: Ranking | None,
    only_areas: bool = False,
) -> FramesRequest:
    """Return what is requested of every frame, with the ranked field; raise InputError, in the name of a function, if wrong.

    Without a `rank`, residues are ranked by their roughness, and without `rank_by` by its standard deviation.
    """
    chosen, name = check_ranked_fields(fields, rank, function, only_areas)
    rank_by = RANK_BY if rank_by is None else rank_by
    return FramesRequest(rules, chosen, name, rank_by, only_areas=only_areas)


def _all_tables(
    molecule: Molecule, request: FramesRequest, parts: Callable[[], Iterator[Part]]
) -> dict[str, Any]:
    """Return the four tables of all frames, each cut into several, by name; `parts` yields all parts whenever it is called."""

    def tables(column: int) -> Iterator[pd.DataFrame]:
        """Yield the tables of residues, 0, or of frames, 1, of each part."""
        for k, part in enumerate(parts()):
            yield _tables(molecule, request, part, k * FRAMES_PER_PART)[column]

    ranking, contacts = _ranking(molecule, request, parts), _contacts(molecule, request, parts())
    return {"residues": tables(0), "frames": tables(1), "ranking": [ranking], "contacts": [contacts]}


def _ranking(molecule: Molecule, request: FramesRequest, parts: Callable[[], Iterator[Part]]) -> pd.DataFrame:
    """Return the table of ranked residues of all frames, which `parts` yields whenever it is called."""
    of_size = EXACT_AREAS[0] if request.only_areas else "area"
    column, area = (request.columns.index(name) for name in (request.ranked_column, of_size))
    table = rank_residues(
        molecule.residues,
        request.ranked_column,
        request.rank_by,
        lambda: ((part.residues[:, :, column], part.residues[:, :, area]) for part in parts()),
    )
    if reason := why_none_is_ranked(table, molecule.n_frames):
        log.warning("no residue is ranked by its %s: %s", request.rank, reason)
    return table[[*COLUMNS_OF_RANKING]].reset_index(drop=True)


def partners_of_request(molecule: Molecule, request: FramesRequest) -> Partners:
    """Return the partners of which the buried areas are requested."""
    return (
        partners_of_atoms(molecule) if request.groups is None else groups_of_atoms(molecule, request.groups)
    )


def _contacts(molecule: Molecule, request: FramesRequest, parts: Iterator[Part]) -> pd.DataFrame:
    """Return the table of contacts of all frames."""
    partners = partners_of_request(molecule, request)
    found = contacts_over_frames(molecule, partners, (part.contacts for part in parts), molecule.n_frames)
    return found[[*COLUMNS_OF_CONTACTS]].reset_index(drop=True)


def _write_frames(molecule: Molecule, request: FramesRequest, path: str | Path, jobs: int) -> Written:
    """Write the tables of all frames.

    The numbers of some frames at a time are stored in a hidden folder next to the tables, which is deleted at the end.
    """
    suffix = parse_output(path, FORMATS)[0]
    if suffix == ".parquet":
        import_pyarrow()
    with store_beside(path, "frames") as store:
        files, computed = [], 0
        for file, part in _parts(molecule, request, jobs, store):
            files.append(file)
            computed += 0 if part is None else len(part.frames)
        tables = _all_tables(molecule, request, lambda: map(_read_part, files))
        for name, table in tables.items():
            output = path if name == "residues" else path_of_frames(path, name)
            write_file(output, table_writers(table))
    ranking = tables["ranking"][0]
    return Written(molecule.n_frames, molecule.n_frames - computed, ranking)


def _every(molecule: Molecule, span: slice) -> Molecule:
    """Return some frames of a molecule."""
    if span == EVERY_FRAME.span:
        return molecule
    with naming_file("the molecule"):
        check_frames(molecule.n_frames, span)
    chosen = {name: getattr(molecule, name)[span] for name in OF_FRAMES}
    return replace(molecule, **chosen)


def part_of_frames(molecule: Molecule, request: FramesRequest, first: int, last: int) -> Part:
    """Measure the frames from position `first` up to `last`."""
    atom_radii = atomic_radii(molecule, request.rules.radii)
    settings = Settings().model_copy(update={"surface": request.rules})
    rows, tables, contacts = [], [], [np.zeros((0, 3))]
    partners = partners_of_request(molecule, request)
    for position in range(first, last):
        if request.only_areas:
            with naming_frame(f"frames, frame {molecule.frame_number[position]}"):
                rolled = roll_frame(molecule.xyz[position], atom_radii, request.rules)
            areas = _exact_areas(molecule, position, rolled, partners)
            tables.append(np.stack([areas[name] for name in EXACT_AREAS], axis=1))
            rows.append([areas[name].sum() for name in SUMMED_AREAS])
            contacts.append(_contacts_of_rolled(molecule, rolled, partners))
            continue
        frame = surface_of_frame(
            molecule, position, atom_radii, settings, Streams(name="frames"), available_cores()
        )
        table = residues_of_frame(frame, request, atom_radii, request.columns, partners)
        contacts.append(_contacts_of_rolled(molecule, frame.rolled, partners))
        parts = summarize_components(columns_of_components(frame.surface, frame.rolled))
        sums = {name: table[name].sum() for name in SUMMED_AREAS}
        columns = frame.columns | parts | sums | {"dots": len(frame.surface)}
        rows.append([columns[name] for name in request.frame_columns])
        tables.append(table.to_numpy(float))
    return Part(np.array(rows, float), np.array(tables), np.concatenate(contacts))


def _contacts_of_rolled(molecule: Molecule, rolled: RolledFrame, partners: Partners) -> np.ndarray:
    """Return residue, partner and the area that the partner buries of it, (m, 3), in one frame."""
    if len(partners.names) == 1:
        return np.zeros((0, 3))
    atom, partner, buried = contacts_of_rolled(rolled, partners.number)
    return sums_of_contacts(molecule.residue_index[atom], partner, buried)


def _exact_areas(
    molecule: Molecule, position: int, rolled: RolledFrame, partners: Partners
) -> dict[str, np.ndarray]:
    """Return the exact areas of each residue in one frame by name, (R,), Å^2, and the relative one."""
    if len(rolled.atom) < molecule.n_atoms:  # the probe rolls over one of several atoms in one place
        refuse_overlapping_partners(molecule, partners, molecule.xyz[position].round(3))
    areas, n = areas_of_rolled(rolled, partners.number), molecule.n_residues
    sums = {name: np.bincount(molecule.residue_index, getattr(areas, name), n) for name in SUMMED_AREAS}
    maxima = maximal_areas(molecule.residue_columns()["residue_name"].astype(str))
    return sums | {"relative": sums["accessible"] / maxima}


def residues_of_frame(
    frame: FrameSurface,
    request: FramesRequest,
    atom_radii: np.ndarray,
    columns: Sequence[str],
    partners: Partners | None = None,
) -> pd.DataFrame:
    """Return some of the columns of the table of residues of one frame."""
    molecule, position, surface = frame.molecule, frame.position, frame.surface
    xyz, values = molecule.xyz[position].round(3), {}
    if request.fields:
        origin = SurfaceOrigin.of_atoms(molecule, position, xyz, request.rules, D_LINK, atom_radii)
        placed = replace(surface, origin=origin)
        values = compute_fields(request.fields, molecule.frame(position), surface.points, dots=placed)
    table = residue_table(
        replace(surface, fields=values),
        frame.prepared.roughness,
        molecule,
        cavity=frame.cavity,
        areas=frame.areas_by_kind,
    )
    if "depth" in columns:
        table["depth"] = _depth(frame.rolled.surface(DENSITY), frame.rolled, molecule, xyz)
    if not {*EXACT_AREAS}.isdisjoint(columns):
        partners = partners_of_request(molecule, request) if partners is None else partners
        for name, values_of_residues in _exact_areas(molecule, position, frame.rolled, partners).items():
            table[name] = values_of_residues
    return table[[*columns]]


def _depth(dots: Surface, rolled: RolledFrame, molecule: Molecule, xyz: np.ndarray) -> np.ndarray:
    """Return the depth of each residue below dots of the density of `depth`, (n,), Å, on a probe that is rolled already."""
    outside = without_cavities(dots, rolled.components(dots))
    return depth_of_residues(molecule, depth_below(outside, xyz))


def _parts(
    molecule: Molecule, request: FramesRequest, jobs: int, store: Path | None = None
) -> Iterator[tuple[Any, Any]]:
    """Yield the file of each part in order, and the part, as `in_parts` does."""
    n = molecule.n_frames
    bounds = [(k, min(k + FRAMES_PER_PART, n)) for k in range(0, n, FRAMES_PER_PART)]
    return in_parts(
        bounds,
        lambda ends: part_of_frames(molecule, request, *ends),
        jobs,
        "frames",
        store,
        _digests(molecule, request, bounds),
        Part._asdict,
        lambda ends: ends[1] - ends[0],
    )


def _read_part(file: Path) -> Part:
    """Read the numbers of a part."""
    with np.load(file, allow_pickle=False) as arrays:
        return Part(**arrays)


def _digests(molecule: Molecule, request: FramesRequest, bounds: list[tuple[int, int]]) -> Iterator[Any]:
    """Yield for each part a hash of all that its numbers follow from."""
    of_all = digest_of_arguments(
        request.rules, request.columns, request.frame_columns, request.groups, fields=request.fields
    )
    for name in (field.name for field in dataclasses.fields(molecule)):
        if name not in (*OF_FRAMES, "files"):
            of_all.update(f"{name} {np.asarray(getattr(molecule, name)).tolist()}".encode())
    for first, last in bounds:
        digest = of_all.copy()
        digest.update(f"{first} {last}".encode())
        digest.update(molecule.xyz[first:last].tobytes())
        yield digest


def _tables(
    molecule: Molecule, request: FramesRequest, part: Part, first: int
) -> tuple[pd.DataFrame, pd.DataFrame]:
    """Return the tables of residues and of frames of a part whose first frame is at position `first`."""
    import pandas as pd

    n, n_residues = part.residues.shape[:2]
    here = slice(first, first + n)
    head = {"frame": molecule.frame_number[here].astype(np.int64), "time_ps": molecule.time_ps[here]}
    labels = molecule.residues
    of_residues: dict[str, Any] = {name: np.repeat(values, n_residues) for name, values in head.items()}
    of_residues |= {str(name): np.tile(labels[name].to_numpy(str), n) for name in labels}
    names = request.columns
    of_residues |= dict(zip(names, part.residues.reshape(-1, len(names)).T, strict=True))
    of_frames: dict[str, Any] = head | dict(zip(request.frame_columns, part.frames.T, strict=True))
    counts = {"components", "cavities", "dots"} & of_frames.keys()
    of_frames |= {name: of_frames[name].astype(np.int64) for name in counts}
    return pd.DataFrame(of_residues), pd.DataFrame(of_frames)
