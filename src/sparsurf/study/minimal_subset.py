"""Select the minimal subset that a config, a command or a call requests."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import DTypeLike

from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.descriptors import DESCRIPTORS
from sparsurf.recovery.readings import RECOVERED
from sparsurf.recovery.recovering import REACH, dot_spacing
from sparsurf.sampling.samplers import subset_weights
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.study.required_dots import Trials
from sparsurf.study.subset_search import find_subset, smallest_recovered_subset, smallest_subset_of_error
from sparsurf.surfaces.surface import Surface


@dataclass(frozen=True, eq=False)
class Subset:
    """Dots that represent a surface; its length is their number.

    Attributes
    ----------
    dots : (n,) int64, their indices, in the order of choice
    weight : (n,) int64, number of dots of the surface that each represents
    surface : Surface of the kept dots alone
    table : DataFrame, the rows of minimal.csv: dot, x, y, z (Å), nx, ny, nz, weight, spacing (Å), reach; with atoms their labels
    interval : 95 % interval of the number of dots, if they are the fewest from which the surface can be recovered
    """

    dots: np.ndarray
    weight: np.ndarray
    surface: Surface
    table: pd.DataFrame
    interval: tuple[float, float] | None = None

    def __repr__(self) -> str:
        return f"Subset of {len(self):,} dots of {self.weight.sum():,}"

    def __len__(self) -> int:
        return len(self.dots)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        """Return the points, (n, 3), for `numpy.asarray`."""
        return self.surface.__array__(dtype, copy)

    @property
    def points(self) -> np.ndarray:
        """Positions of the kept dots, (n, 3) float64, Å."""
        return self.surface.points

    @property
    def normals(self) -> np.ndarray:
        """Outward normals of the kept dots, (n, 3) float64."""
        return self.surface.normals

    def to_frame(self) -> pd.DataFrame:
        """Return `table`, like `to_frame` of a Surface."""
        return self.table


def select_minimal_subset(
    trials: Trials,
    request: Mapping[str, Any],
    floors: Mapping[str, np.ndarray] | None = None,
    molecule: Molecule | None = None,
) -> Subset:
    """Select the subset that `request`, the config's `minimal`, asks for: by error, floor, n_S, n_S_percent, Z or combination.

    `trials` are those of a `with_shared_streams` PreparedSurface, so that the subset does not depend on the name of the
    surface; the sampler is theirs. `floors` are from `floors.measure_floors`, if a floor is requested. The dots
    belong to the atoms of `molecule`.
    """
    prepared, interval = trials.prepared, None
    if "error" in request:
        dots, interval = smallest_subset_of_error(trials, request["error"])
        weight = subset_weights(prepared.points, dots)
    elif "floor" in request:
        if floors is None:
            raise ValueError("a floor is requested: give its distances")
        dots, interval = smallest_recovered_subset(trials, floors, request["floor"])
        weight = subset_weights(prepared.points, dots)
    else:
        dots, weight = find_subset(
            prepared,
            trials.sampler,
            n_s=_n_s(request, len(prepared.points)),
            z=request.get("Z"),
            combination=request.get("combination"),
            n_tests=len(trials.tests),
            choices=trials.choices,
        )
    kept = prepared.surface.take(dots)
    return Subset(dots, weight, kept, subset_table(dots, weight, kept, molecule), interval)


def recovered_z(prepared: PreparedSurface, dots: np.ndarray, tests: np.ndarray) -> dict[str, float]:
    """Compute Z of the surface recovered from some dots, at test dots, by each descriptor: the columns Z_<descriptor>."""
    out = {}
    for name in DESCRIPTORS:
        view = prepared.changed(descriptor=name)
        z = view.distances([dots], tests, view.describe(tests)[0], RECOVERED)[0]
        out[f"Z_{name}"] = float(z.mean())
    return out


def _n_s(request: Mapping[str, Any], n_dots: int) -> int | None:
    """Return n_S from the config's n_S or n_S_percent; None if neither is given."""
    if "n_S_percent" in request:
        return max(1, round(request["n_S_percent"] / 100 * n_dots))
    return request.get("n_S")


def subset_table(
    dots: np.ndarray, weight: np.ndarray, kept: Surface, molecule: Molecule | None = None
) -> pd.DataFrame:
    """Return the rows of minimal.csv, with residues if the molecule is known; other arguments are parts of a `Subset`."""
    table = pd.DataFrame({"dot": dots})
    table[["x", "y", "z"]], table[["nx", "ny", "nz"]] = kept.points, kept.normals
    table["weight"], table["spacing"] = weight, dot_spacing(kept.points, kept.normals)
    table["reach"] = REACH
    return table if molecule is None else table.join(molecule.labels(kept.atom))
