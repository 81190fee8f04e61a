"""The page of a trajectory: the surface of its frames, and how its residues change from frame to frame."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from sparsurf.api.frames import FramesRequest, frames_request, residues_of_frame
from sparsurf.api.origin import rows_of_origin
from sparsurf.api.page_metadata import About, heard
from sparsurf.api.pages import heading_of, stated_in
from sparsurf.api.surfaces import placement
from sparsurf.api.surroundings import contacts_on_page, drawn_without_surface, with_surroundings
from sparsurf.arguments import D_LINK, Ranking
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.frames import naming_frame, surface_of_frame
from sparsurf.molecules.conformations import superpose
from sparsurf.orientation import best_rotations
from sparsurf.progress import Progress, duration
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import density_for_d_link, roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf.threads import available_cores, parallel_map

if TYPE_CHECKING:
    import pandas as pd

    from sparsurf.dot_fields.named_fields import FieldLike
    from sparsurf.molecules.molecule import Molecule
    from sparsurf.surfaces.mesh import Mesh
    from sparsurf.views.viewer.shapes import DrawnAtoms, Shape

NAME_IN_ERRORS = "show"
FRAMES_PER_CORE = 2  # A batch, after which progress is counted, has so many frames for each core.
PS_PER_NS = 1000
DENSITY_OF_FRAMES = 0.85  # corners per Å^2


class ShownFrame(NamedTuple):
    """What a page shows of a frame."""

    shape: Shape
    residues: pd.DataFrame  # numbers of its residues, NaN where one has none


def shown_positions(n_frames: int) -> np.ndarray:
    """Return the positions of the frames that a page shows: every n-th, so that they are at most `MAX_FRAMES`."""
    from sparsurf.views.viewer.scene import MAX_FRAMES

    return np.arange(0, n_frames, math.ceil(n_frames / MAX_FRAMES))


def ranked_frames(
    rank: FieldLike | None,
    rank_by: Ranking | None,
    shows_frames: bool,
    rules: Mapping[str, Any] = MappingProxyType({}),
    **of_one: Any,
) -> FramesRequest:
    """Return what a page requests of frames; raise InputError for a wrong ranking, or one of a page without frames.

    `rules` are arguments of `placement`, and `of_one` arguments about the page of one surface, by name.
    """
    for name, given in of_one.items():
        if given is not None and shows_frames:
            raise InputError(f"{argument(name)} is about one surface; give a frame as well, or leave it out.")
    for name, given in (("rank", rank), ("rank_by", rank_by)):
        if given is not None and not shows_frames:
            raise InputError(
                f"{argument(name)} ranks residues by how much they change over the frames of a trajectory; give a trajectory "
                f"without a frame, or leave {argument(name)} out."
            )
    return frames_request(NAME_IN_ERRORS, placement(**rules), (), rank, rank_by)


def page_of_frames(
    molecule: Molecule,
    about: About,
    trajectory: str,
    request: FramesRequest,
    say: Callable[[str], None] = lambda text: None,
) -> str:
    """Return the page of a molecule with several frames; `say` takes what is said of them before the work.

    Parameters
    ----------
    molecule : Molecule with at least two frames
    about : what the page says besides the frames
    trajectory : name of the file of the frames
    request : what is requested of the frames, for the ranking of residues
    say : called with a sentence on the frames and the time that they take
    """
    from sparsurf.views.page.frames import render_page_of_frames
    from sparsurf.views.viewer.shapes import DrawnAtoms, is_trace

    positions, shown = shown_positions(molecule.n_frames), with_surroundings(molecule)
    atoms, trace = DrawnAtoms(shown, molecule.n_residues), np.flatnonzero(is_trace(molecule))
    drawn = superposed(shown.xyz[positions], trace if len(trace) > 2 else np.flatnonzero(molecule.heavy))
    atom_radii, rules = radii(molecule, request.rules.radii), request.rules
    density = density_for_d_link(molecule.xyz[0], atom_radii, rules, D_LINK, NAME_IN_ERRORS)
    rules = replace(rules, density=density)  # of all frames
    request = request._replace(rules=rules)

    def frame_at(k: int) -> ShownFrame:
        """Compute the surface of a frame, and reduce it to what the page shows."""
        return shown_frame(molecule, int(positions[k]), drawn[k], atoms, atom_radii, request)

    begin = time.monotonic()
    frames = [frame_at(0)]
    cores = available_cores()
    say(_announced(molecule, len(positions), (time.monotonic() - begin) * (len(positions) - 1) / cores))
    batch = FRAMES_PER_CORE * cores
    progress = Progress("frames", len(positions), len(frames))
    for first in range(1, len(positions), batch):
        size = min(batch, len(positions) - first)
        frames += parallel_map(lambda k, _, first=first: frame_at(first + k), size, cores, 1)  # type: ignore[misc]
        progress.advance(size)
    progress.close()
    with heard("contacts") as of_contacts:
        contacts = contacts_on_page(shown, drawn, rules)
    sentences = [*(about.heard.sentences if about.heard else ()), *of_contacts.sentences]
    sentences += drawn_without_surface(shown, molecule.n_atoms)
    return render_page_of_frames(
        _title(about, molecule, len(frames), trajectory),
        trajectory,
        atoms,
        [frame.shape for frame in frames],
        {str(name): np.array([frame.residues[name] for frame in frames]) for name in frames[0].residues},
        (request.ranked_column, request.rank_by),
        [label_of_frame(molecule, int(k)) for k in positions],
        contacts,
        sentences,
        about.heard.left_out if about.heard else None,
        rows_of_origin(about, molecule, rules=rules),
    )


def _title(about: About, molecule: Molecule, n_shown: int, trajectory: str) -> str:
    """Return the heading of the page; the title that a structure states is quoted, as it speaks of the structure alone."""
    stated = stated_in(molecule)
    return (
        f"“{stated}”, {n_shown} frames of {trajectory}"
        if stated
        else f"{heading_of(about, molecule)} in {n_shown} frames"
    )


def _announced(molecule: Molecule, n_shown: int, seconds: float) -> str:
    """Say how many frames a page shows, and about how long they take."""
    every = "" if n_shown == molecule.n_frames else f", of which the page shows {n_shown}"
    return (
        f"{molecule.n_frames:,} frames of {molecule.counted_residues}{every}; about {duration(seconds)} left"
    )


def superposed(xyz: np.ndarray, atoms: np.ndarray) -> np.ndarray:
    """Return frames (F, A, 3), Å, superposed on the first by some atoms, or moved onto it where several rotations fit."""
    try:
        return superpose(xyz, atoms)
    except InputError:
        return xyz - xyz[:, atoms].mean(axis=1, keepdims=True) + xyz[0, atoms].mean(axis=0)


def shown_frame(
    molecule: Molecule,
    position: int,
    drawn: np.ndarray,
    atoms: DrawnAtoms,
    atom_radii: np.ndarray,
    request: FramesRequest,
) -> ShownFrame:
    """Compute what a page shows of a frame, at the positions `drawn`, (A, 3): its surface and its residues."""
    from sparsurf.surfaces.thinning import PICTURED, coarsened
    from sparsurf.surfaces.triangulation import mesh_of_rolled
    from sparsurf.views.viewer.shapes import Shape

    rules, xyz = request.rules, molecule.xyz[position]
    settings = Settings().model_copy(update={"surface": rules})
    frame = surface_of_frame(molecule, position, atom_radii, settings, Streams(name=NAME_IN_ERRORS))
    with naming_frame(f"{NAME_IN_ERRORS}, frame {int(molecule.frame_number[position])}"):
        rolled = frame.rolled
        if not rolled.exact:
            rolled = roll_frame(xyz, atom_radii, replace(rules, reentrant="exact"))
        mesh = coarsened(mesh_of_rolled(rolled, PICTURED), DENSITY_OF_FRAMES)
    columns = dict.fromkeys(("area", "mean_roughness", request.ranked_column))
    residues = residues_of_frame(frame, request, atom_radii, [*columns])
    moved = _moved(mesh, xyz.astype(float), drawn[: molecule.n_atoms])
    return ShownFrame(Shape(moved, atoms.placed(drawn)), residues)


def _moved(mesh: Mesh, xyz: np.ndarray, drawn: np.ndarray) -> Mesh:
    """Return the mesh of atoms at `xyz` (A, 3), Å, as it lies where these are drawn."""
    middle, target = xyz.mean(axis=0), drawn.mean(axis=0)
    rotation, _ = best_rotations((xyz - middle).T @ (drawn - target))
    points, normals = mesh.vertices.points, mesh.vertices.normals
    moved = replace(mesh.vertices, points=(points - middle) @ rotation + target, normals=normals @ rotation)
    return replace(mesh, vertices=moved)


def label_of_frame(molecule: Molecule, position: int) -> str:
    """Return the number of a frame in its file, and its time where the file has times."""
    label, ps = f"frame {int(molecule.frame_number[position])}", float(molecule.time_ps[position])
    if math.isnan(ps):
        return label
    return f"{label}, {ps / PS_PER_NS:g} ns" if ps >= 10 * PS_PER_NS else f"{label}, {ps:g} ps"
