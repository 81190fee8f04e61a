"""Structures of a study: its conformations, chosen from what a config names, and the files that it wrote of them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from sparsurf.files import StrPath
from sparsurf.messages import no_warnings
from sparsurf.molecules.conformations import FrameChoice, choose_frames
from sparsurf.molecules.molecule import Molecule
from sparsurf.molecules.read_molecule import read_molecule

EVERY_FRAME = {"stride": 1, "start": 0, "stop": None}


def read_study_structure(path: StrPath) -> Molecule:
    """Read a structure that a study wrote, without warnings: they were given for the file that it came from."""
    with no_warnings():
        return read_molecule(path, selection="all", whole=False)


def choose_conformations(
    structure: str,
    trajectory: str | None,
    options: Mapping[str, Any],
    rng: np.random.Generator,
    *,
    stride: int,
    start: int = 0,
    stop: int | None = None,
    selection: str | Sequence[int],
    clusters: str | int,
) -> tuple[Molecule, FrameChoice]:
    """Read a molecule and choose its conformations, as the section `frames` of a config asks.

    A single structure is one conformation, since `frames` is about the trajectories of the same study. `options` are those of
    `read_molecule`.
    """
    span: dict[str, Any] = {"stride": stride, "start": start, "stop": stop}
    if trajectory is None and span != EVERY_FRAME:
        with no_warnings():  # which the other reading tells
            span = EVERY_FRAME if read_molecule(structure, **options).n_frames == 1 else span
    molecule = read_molecule(structure, trajectory, **span, **options)
    frames = None if selection == "clusters" else selection
    if trajectory is None and molecule.n_frames == 1 and span == EVERY_FRAME:
        clusters, frames = "auto", frames and "all"
    return molecule, choose_frames(molecule, clusters=clusters, frames=frames, rng=rng)


def residue_labels(path: StrPath | None) -> list[str]:
    """Return the residue of each atom of a study's structure, as 'LEU 212 A'; empty without a path."""
    if not path:
        return []
    molecule = read_study_structure(path)
    return [molecule.residue_label(atom) for atom in range(molecule.n_atoms)]
