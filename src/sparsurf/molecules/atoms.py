"""The labels of atoms as a protocol: functions of them take it in place of `Molecule`, which imports these functions."""

from __future__ import annotations

from typing import TYPE_CHECKING, Protocol

import numpy as np

if TYPE_CHECKING:
    import mdtraj


class AtomsLike(Protocol):
    """Labels of the atoms of a molecule, (A,) each, as in `Molecule`."""

    @property
    def name(self) -> np.ndarray: ...
    @property
    def residue_name(self) -> np.ndarray: ...
    @property
    def chain(self) -> np.ndarray: ...
    @property
    def element(self) -> np.ndarray: ...
    @property
    def residue(self) -> np.ndarray: ...
    @property
    def residue_index(self) -> np.ndarray: ...
    @property
    def kind(self) -> np.ndarray: ...
    @property
    def heavy(self) -> np.ndarray: ...
    @property
    def topology(self) -> mdtraj.Topology: ...
