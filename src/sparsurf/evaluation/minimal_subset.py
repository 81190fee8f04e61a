"""Choose the minimal subset of a surface and measure its errors, for the study, its batches, functions and commands."""

from __future__ import annotations

import logging
import warnings
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import DTypeLike, NDArray

from sparsurf import registry
from sparsurf.arguments import Model
from sparsurf.display import Shown
from sparsurf.dot_fields.named_fields import compute_fields, takes_dots
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.prepared_surface import PreparedSurface, number_of_tests
from sparsurf.evaluation.residues import residue_table
from sparsurf.evaluation.statistics import reference_values
from sparsurf.evaluation.subset_search import Found, find_subset, smallest_cover, smallest_subset_of_error
from sparsurf.evaluation.trials import Trials
from sparsurf.molecules.molecule import Molecule
from sparsurf.patches.index import build_grid, build_index
from sparsurf.recovery.errors import TAIL_QUANTILE, curvature, error_table
from sparsurf.recovery.fields import recovery_table
from sparsurf.recovery.interpolated_surface import REACH, dot_spacing
from sparsurf.recovery.reconstructing import (
    AUTO,
    INTERPOLANT,
    SPHERES,
    Reconstructed,
    reconstruction_of,
)
from sparsurf.recovery.spheres.votes import MIN_DOTS
from sparsurf.registry import COVER, FARTHEST
from sparsurf.sampling.combination import PUBLISHED_CHOICES, Choices
from sparsurf.sampling.samplers import farthest, weights_and_areas
from sparsurf.settings import DECISIONS, TAIL_PER_ERROR, Minimal, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.surface import Surface, SurfaceOrigin, largest_area

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger("sparsurf")

DESCRIPTORS_OF_ERRORS = ("published", "rotation_robust")  # Their Z stand in columns of recovered.csv.
# Å, above which fewer evenly spread dots than dots that determine atoms have a mean error
MAX_ERROR_OF_COVER = 0.12
INDEPENDENT, NOT_KEPT = "independent dots", "dots not kept"  # The dots on which errors are measured.


@dataclass(frozen=True, eq=False)
class Subset(Shown):
    """Dots that represent a surface; its length is their number.

    Attributes
    ----------
    dots : (n,) int64, their indices, in the order of choice
    weight : (n,) int64, number of dots of the surface that each represents
    surface : Surface of the kept dots alone; the area of each is that of the surface that is nearer to it than to the others,
        so that their sum is the area of the whole surface
    molecule : Molecule that the dots lie on, or None
    interval : 95 % interval of the number of dots, if they are the fewest from which the surface can be recovered, and were not
        chosen by the sampler cover, whose number follows from the dots themselves
    sampler : str, how the dots were chosen
    reconstruction : str, 'spheres' or 'interpolant', how the surface is reconstructed from them where their errors are measured
    decided_by : str, which error is nearest to its limit where an error was requested: 'mean', '99 % forth' or '99 % back'; or
        'fewest' (a surface is not reconstructed from fewer) or 'all'; empty for other requests
    determines_atoms : whether the atoms of the surface follow from the dots, which the sampler cover chose for an error
    measure_errors : function without arguments that measures how far the surface deviates from the reconstructed one
    """

    dots: NDArray[np.int64]
    weight: NDArray[np.float64]
    surface: Surface
    molecule: Molecule | None = None
    interval: tuple[float, float] | None = None
    sampler: str = "farthest"
    reconstruction: Model = INTERPOLANT
    decided_by: str = ""
    determines_atoms: bool = False
    measure_errors: Callable[..., pd.DataFrame] | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        return f"Subset of {len(self):,} dots of {self.weight.sum():,}"

    def __len__(self) -> int:
        return len(self.dots)

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> np.ndarray:
        """Return the points, (n, 3), for `numpy.asarray`."""
        return self.surface.__array__(dtype, copy)

    @cached_property
    def table(self) -> pd.DataFrame:
        """Rows of minimal.csv: dot, x, y, z (Å), nx, ny, nz, weight, area (Å^2), spacing (Å), reach; with atoms their labels."""
        import pandas as pd  # here: it takes long to load

        return pd.DataFrame(self.columns())

    def columns(self) -> dict[str, np.ndarray]:
        """Return the columns of `table` by name."""
        return subset_columns(self.dots, self.weight, self.surface, self.molecule)

    @property
    def points(self) -> np.ndarray:
        """Positions of the kept dots, (n, 3) float64, Å."""
        return self.surface.points

    @property
    def normals(self) -> np.ndarray:
        """Outward normals of the kept dots, (n, 3) float64."""
        return self.surface.normals

    @property
    def density(self) -> float:
        """Kept dots per Å^2 of the surface; NaN where its area is not known."""
        return len(self) / float(self.surface.area.sum())

    @property
    def decision(self) -> tuple[str, ...]:
        """The sentence on what decided the number of dots; none where no error was requested."""
        return (DECISIONS[self.decided_by],) if self.decided_by else ()

    @cached_property
    def error(self) -> float:
        """Mean distance of the surface from the one that is reconstructed from the dots, Å, measured when it is first read."""
        if self.measure_errors is None:
            raise InputError("error: this subset has lost its surface; choose it with minimal().")
        return float(self.measure_errors(everywhere=True)["mean"].iloc[0])

    @property
    def model(self) -> str:
        """The old name of `reconstruction`."""
        warnings.warn(
            "Subset.model: write .reconstruction in its place, since version 8 will not have it.",
            DeprecationWarning,
            stacklevel=2,
        )
        return self.reconstruction

    def to_frame(self) -> pd.DataFrame:
        """Return `table`, like `to_frame` of a Surface."""
        return self.table


@dataclass(frozen=True, eq=False)
class Representation:
    """A surface, the roughness of its dots, and the few of them that stand for it; tables follow from these."""

    trials: Trials  # with the prepared surface, its fields included, and the test dots
    subset: Subset
    molecule: Molecule | None = None  # that the dots lie on

    @property
    def surface(self) -> Surface:
        """All dots, with their fields."""
        return self.trials.prepared.surface

    @property
    def determines_atoms(self) -> bool:
        """Whether the subset was chosen for an error by the sampler cover, or holds all its dots that determine the atoms."""
        is_cover = self.subset.sampler == COVER and self.trials.atoms is not None
        few = self.subset
        return is_cover and (bool(few.decided_by) or len(few) >= len(self.trials.cover.dots()))

    @property
    def roughness(self) -> np.ndarray:
        """R_i of all dots, (N,) float64."""
        return self.trials.prepared.roughness

    def residues(self, component: np.ndarray | None = None) -> pd.DataFrame:
        """Return `residue_table`; `component` (N,) of each dot."""
        if self.molecule is None:
            raise ValueError("dots without a molecule have no residues")
        weight = self.subset.weight
        return residue_table(self.surface, self.roughness, self.molecule, self.subset.dots, weight, component)

    def reconstructed(self) -> Reconstructed:
        """Reconstruct the surface from the subset: densely, and at a density at which it is compared with the whole surface."""
        return self.trials.reconstructed(self.subset.dots)

    def errors(self, threads: int = 1, everywhere: bool = False) -> pd.DataFrame:
        """Return the distances of the true surface from the one reconstructed from the subset: the rows of recovered.csv.

        They are measured on independent dots of the whole surface, each with the exact distance of the nearest reconstructed dot
        from the true surface. Where the atoms of the dots are not known, they are distances of the dots that were not kept from
        the planes of the reconstructed dots.

        With `everywhere`, only the first row is measured, without the descriptors that no sentence states, and with the Z of
        the mean patch in place of every patch.
        """
        few, prepared, test = self.subset, self.trials.prepared, self.trials.test_surface
        points, kept = (prepared.points, few.dots) if test is None else (test.points, np.empty(0, int))
        bend, back = None, self.reconstructed()
        if not everywhere:
            index = prepared.index if test is None else build_grid(test.points, test.normals)
            bend = curvature(index, threads=threads)
        errors = error_table(back.distances(points, threads, self.trials.rolled), bend, kept)
        low, high = few.interval or (np.nan, np.nan)
        of_subset = {"n_S_percent": len(few), "n_S_percent_low": low, "n_S_percent_high": high}
        of_subset = {key: 100 * n / len(prepared) for key, n in of_subset.items()}
        of_subset |= {"density": len(few) / prepared.area}
        of_subset["back_99"] = float(np.quantile(self.trials.distances_back(back.dense), TAIL_QUANTILE))
        names = DESCRIPTORS_OF_ERRORS[: 1 if everywhere else None]
        of_subset |= recovered_z(prepared, back.comparable, self.trials.tests, names)
        errors.loc[0, list(of_subset)] = list(of_subset.values())
        about: dict[str, str | float] = {"measured_on": NOT_KEPT if test is None else INDEPENDENT}
        if everywhere:
            about |= {
                "Z_mean_patch": reference_values(prepared.describe(self.trials.tests)[0])["Z_mean_descriptor"]
            }
        about |= {"sampler": few.sampler, "reconstruction": back.model, "decided_by": few.decided_by}
        return errors.assign(**about)

    def errors_of_fields(self) -> pd.DataFrame:
        """Return how well the subset, and others, predict the fields at all other dots: the rows of fields.csv."""
        prepared = self.trials.prepared
        order = farthest(prepared, len(prepared) // 5, prepared.stream("minimal", "farthest"))
        return recovery_table(self.surface, order, self.subset.dots, self.subset.points)


def represent(
    surface: Surface,
    settings: Settings,
    streams: Streams,
    molecule: Molecule | None = None,
    *,
    table: str | Path | None = None,
    roughness: np.ndarray | None = None,
    choices: Choices = PUBLISHED_CHOICES,
    threads: int = 1,
) -> Representation:
    """Analyse one surface: the fields and roughness of its dots, and the minimal subset that the settings request.

    The study, a batch, the functions and the commands all call this. `table` is a CSV with fields of the molecule's own,
    `roughness` (N,) is given if known, and `choices` is for the paper's sampler. The subset does not depend on the name in
    `streams`.
    """
    if molecule is not None and (
        names := [name for name in settings.fields if table or registry.has("field", name)]
    ):
        placed = surface
        if surface.origin is None and any(map(takes_dots, names)):
            placed = on_molecule(surface, molecule, settings)
        fields = compute_fields(names, molecule, surface.points, table=table, dots=placed)
        surface = replace(surface, fields=surface.fields | fields)
    if molecule is not None and surface.origin is None and min(surface.kind.min(), surface.atom.min()) >= 0:
        surface = on_molecule(surface, molecule, settings)
    prepared = PreparedSurface(surface, settings, roughness, replace(streams, shared=True), threads)
    n_tests, request = number_of_tests(settings.evaluation.test_dots, len(surface)), settings.minimal
    atoms = _atoms_of_all(surface, molecule)
    sampler: str = request.sampler
    if sampler == AUTO:
        # The interpolant needs more dots that touch every atom than evenly spread ones
        by_spheres = request.reconstruction != INTERPOLANT and atoms is not None
        sampler = COVER if request.error is not None and by_spheres else FARTHEST
    trials, interval = Trials(prepared, sampler, n_tests, choices, _model(request, sampler), atoms), None
    decided_by = ""
    if request.error is not None:
        hydrogens = molecule is not None and not molecule.heavy.all()
        trials, (dots, interval, decided_by) = _smallest(trials, request, hydrogens, choices)
    else:
        n_s, n_tests = _n_s(request, prepared), len(trials.tests)
        wanted = (n_s, request.max_z, request.combination)
        dots = find_subset(prepared, sampler, *wanted, n_tests, choices)
    weight, area = weights_and_areas(surface.points, surface.area, dots, threads)
    # a sampler of the user may leave nearly all of the surface to one dot
    kept = replace(
        surface.take(dots), area=area if area.max() <= largest_area(area) else np.full(len(dots), np.nan)
    )
    determines_atoms = trials.model != INTERPOLANT and len(dots) >= MIN_DOTS
    if atoms is not None:
        model = SPHERES if trials.model == SPHERES and determines_atoms else request.reconstruction
        kept = replace(kept, reconstruction=atoms.reconstruction(model))
    if request.reconstruction == SPHERES:  # refuse dots that do not lie on spheres
        reconstruction_of(kept, SPHERES, threads=threads)
    model = SPHERES if determines_atoms else INTERPOLANT
    few = Subset(dots, weight, kept, molecule, interval, trials.sampler, model, decided_by)
    first = Representation(trials, few, molecule)
    few = replace(few, determines_atoms=first.determines_atoms, measure_errors=partial(first.errors, threads))
    return replace(first, subset=few)


def _atoms_of_all(surface: Surface, molecule: Molecule | None) -> SurfaceOrigin | None:
    """Return the atoms that all dots of a surface were placed on; None if they are not known, or the dots are some of them."""
    whole = surface.placed is not None or molecule is not None
    has_atoms = whole and surface.kind.min() >= 0 and surface.atom.min() >= 0
    return surface.origin if has_atoms else None


def _model(request: Minimal, sampler: str) -> Model:
    """Return the model by which errors are measured: with the sampler cover the spheres, with others the interpolant."""
    return (
        request.reconstruction
        if request.reconstruction != AUTO
        else SPHERES
        if sampler == COVER
        else INTERPOLANT
    )


def _smallest(trials: Trials, request: Minimal, hydrogens: bool, choices: Choices) -> tuple[Trials, Found]:
    """Return the smallest subset of the requested errors, and the trials of its sampler."""
    assert request.error is not None
    error, error_99 = request.error, request.error_99
    if trials.sampler != COVER or trials.model == INTERPOLANT or trials.atoms is None:
        return trials, smallest_subset_of_error(trials, error, hydrogens, error_99)
    is_auto, name = request.sampler == AUTO, trials.prepared.name or "minimal"
    if not is_auto or error <= MAX_ERROR_OF_COVER:
        found = smallest_cover(trials, error, TAIL_PER_ERROR * error if error_99 is None else error_99)
        if found is not None:
            return trials, found
    if not is_auto:
        log.warning(
            "%s: dots that touch every atom do not determine their spheres here; evenly spread dots were chosen in place of "
            "those of the sampler %s.", name, COVER,
        )  # fmt: skip
    model: Model = INTERPOLANT if request.reconstruction == AUTO else AUTO
    spread = Trials(trials.prepared, FARTHEST, len(trials.tests), choices, model, trials.atoms)
    return spread, smallest_subset_of_error(spread, error, hydrogens, error_99)


def on_molecule(dots: Surface, molecule: Molecule, settings: Settings) -> Surface:
    """Return dots that a study read from a file, with the molecule that it placed them on."""
    rules, xyz = settings.surface, molecule.xyz[0].round(3)
    radii = radii_of(molecule, rules.radii)
    return replace(
        dots, origin=SurfaceOrigin.of_atoms(molecule, 0, xyz, rules, settings.patches.d_link, radii)
    )


def recovered_z(
    prepared: PreparedSurface,
    reconstructed: Surface,
    tests: np.ndarray,
    names: Sequence[str] = DESCRIPTORS_OF_ERRORS,
) -> dict[str, float]:
    """Compute Z of a reconstructed surface, at test dots, by descriptors: the columns Z_<descriptor>."""
    out = {}
    index = build_index(reconstructed.points, reconstructed.normals, prepared.patches.d_link)
    for name in names:
        view = prepared.with_descriptor(name)
        z = view.distances_to_index(index, tests, view.describe(tests)[0])[0]
        out[f"Z_{name}"] = float(z.mean())
    return out


def _n_s(request: Minimal, prepared: PreparedSurface) -> int | None:
    """Return n_S from the config's n_dots, percent or density; None if none of them is given."""
    n_dots = len(prepared)
    if request.percent is not None:
        return max(1, round(request.percent / 100 * n_dots))
    if request.density is not None:
        n_s = max(1, round(request.density * prepared.area))
        if n_s > n_dots:
            raise InputError(
                f"{argument('minimal.density')} is {request.density:g}, but {prepared.name or 'the surface'} has "
                f"{prepared.density:.3g} dots "
                "per Å^2: request fewer, or place more."
            )
        return n_s
    return request.n_dots


def subset_columns(
    dots: np.ndarray, weight: np.ndarray, kept: Surface, molecule: Molecule | None = None
) -> dict[str, np.ndarray]:
    """Return the columns of minimal.csv, with residues if the molecule is known; other arguments are parts of a `Subset`."""
    columns: dict[str, np.ndarray] = {"dot": dots}
    columns |= zip(("x", "y", "z", "nx", "ny", "nz"), [*kept.points.T, *kept.normals.T], strict=True)
    columns["weight"] = weight
    if np.isfinite(kept.area).all():
        columns["area"] = kept.area
    columns["spacing"] = dot_spacing(kept.points, kept.normals)
    columns["reach"] = np.full(len(kept), REACH)
    if kept.reconstruction is not None:
        for name, value in kept.reconstruction.columns.items():
            columns[name] = np.full(len(kept), value, object if isinstance(value, str) else None)
    return columns if molecule is None else columns | molecule.label_columns(kept.atom)
