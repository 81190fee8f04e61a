"""The surface of each frame of a trajectory: of the ensembles of a study, and of the function and the command `frames`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.residues import mean_roughness_by_residue
from sparsurf.molecules.molecule import Molecule
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.components import on_cavities
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_frame
from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True)
class FrameSurface:
    """The surface of one frame.

    Attributes
    ----------
    molecule : Molecule of all frames
    position : of the frame among those of the molecule, from 0
    rolled : RolledFrame, from which the dots were placed
    prepared : PreparedSurface, with the roughness of the dots
    """

    molecule: Molecule
    position: int
    rolled: RolledFrame
    prepared: PreparedSurface

    @property
    def surface(self) -> Surface:
        """All dots of the frame."""
        surface: Surface = self.prepared.surface
        return surface

    @cached_property
    def component(self) -> np.ndarray:
        """Component of each dot, (N,) int, 0 the largest."""
        return self.rolled.components(self.surface)

    @cached_property
    def cavity(self) -> np.ndarray:
        """Whether each dot lies on the wall of a cavity, (N,) bool."""
        return on_cavities(self.surface, self.component)

    @cached_property
    def areas_by_kind(self) -> np.ndarray | None:
        """Exact areas of the atoms by kind, (A, 3), Å^2; None for dots that are placed as DMS places them."""
        return self.rolled.areas_by_kind(self.molecule.n_atoms) if self.rolled.exact else None

    @property
    def columns(self) -> dict[str, float]:
        """The columns that the tables of frames begin with."""
        return {
            "frame": int(self.molecule.frame_number[self.position]),
            "time_ps": float(self.molecule.time_ps[self.position]),
            "N": len(self.surface),
            "area": float(
                self.surface.area.sum() if self.areas_by_kind is None else self.areas_by_kind.sum()
            ),
            "mean_roughness": float(self.prepared.roughness.mean()),
        }

    def roughness_by_residue(self) -> np.ndarray:
        """Return the mean R_i of each residue, (n,); NaN for one without dots outside of cavities."""
        outside = np.where(self.cavity, np.nan, self.prepared.roughness)
        residue = self.molecule.residue_index[self.surface.atom]
        return mean_roughness_by_residue(outside, residue, self.molecule.n_residues)


@contextmanager
def naming_frame(where: str) -> Iterator[None]:
    """Name the frame in an error."""
    try:
        yield
    except InputError as error:
        raise InputError(f"{where}: {error.args[0]}") from None  # str(error) has the names of a call


def surface_of_frame(
    molecule: Molecule,
    position: int,
    atom_radii: np.ndarray,
    settings: Settings,
    streams: Streams,
    threads: int = 1,
) -> FrameSurface:
    """Place dots on one frame, by the sections `surface` and `patches` of the settings; an error names the frame."""
    number = int(molecule.frame_number[position])
    where = f"{streams.name}, frame {number}"
    with naming_frame(where):
        rolled = roll_frame(molecule.xyz[position], atom_radii, settings.surface)
        density, d_link = settings.surface.density, settings.patches.d_link
        surface, _ = rolled.surface_for_d_link(density, d_link, where)
    of_frame = replace(streams, name=f"{streams.name}/f{number}")
    return FrameSurface(
        molecule, position, rolled, PreparedSurface(surface, settings, None, of_frame, threads)
    )
