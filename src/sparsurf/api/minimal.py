"""The minimal subset of a surface, the noise floor that measures it, and the surface reconstructed from it."""

from __future__ import annotations

import logging
from dataclasses import replace
from typing import TYPE_CHECKING, Any

from sparsurf.api.inputs import DotsLike, SurfaceLike, as_dots
from sparsurf.api.subsets import prepare, warn_of_gaps
from sparsurf.api.surface_atoms import surface_of_atoms
from sparsurf.api.surfaces import as_surface
from sparsurf.arguments import (
    DEFAULT_TEST_DOTS,
    Model,
    public,
)
from sparsurf.errors import InputError, argument
from sparsurf.evaluation.floors import floors_table, fresh_dots
from sparsurf.evaluation.minimal_subset import Subset, represent
from sparsurf.evaluation.prepared_surface import number_of_tests
from sparsurf.patches.index import D_LINK
from sparsurf.recovery.interpolated_surface import NEWTON_STEPS, REACH
from sparsurf.recovery.reconstructing import AUTO, reconstruct, surface_with_fields
from sparsurf.sampling.samplers import SamplerLike, get_samplers
from sparsurf.settings import Minimal, PatchesSettings, Settings
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.surfaces.spacing import DENSITY, refuse_sparse
from sparsurf.surfaces.surface import Recovered, Surface
from sparsurf.surfaces.surface_atoms import SurfaceAtoms
from sparsurf.threads import available_cores

if TYPE_CHECKING:
    import pandas as pd

log = logging.getLogger("sparsurf")


@public(of_dots=True, renamed={"model": "reconstruction"})
def minimal(
    surface: SurfaceLike,
    *,
    percent: float | None = None,
    n_dots: int | None = None,
    density: float | None = None,
    error: float | None = None,
    max_z: float | None = None,
    sampler: SamplerLike = AUTO,
    reconstruction: Model = AUTO,
    error_99: float | None = None,
    d_link: float = D_LINK,
    seed: int = DEFAULT_SEED,
) -> Subset:
    """Choose few dots that represent a surface, by default with a mean error of 0.02 Å.

    Parameters
    ----------
    surface : path, Molecule, atoms of another library, Surface, or pair (points, normals)
        A molecule, whose dots are placed with the defaults of `surface`, or dots, such as `surface(path, probe_radius=2.0)`.
    percent, n_dots, density, error, max_z : float, optional
        At most one of them: the share of all dots, %; their number; their number per Å^2; the mean distance of the true surface
        from the reconstructed one, Å (0.02 without any of the five); the largest Z (see `compare`) of the dots as they are.
    sampler : str or callable
        How dots are chosen, as in `sample`; 'auto' (default) is 'cover' for an error of at most 0.12 Å of all that `surface`
        placed, unless `reconstruction` is 'interpolant', else 'farthest'. Dots of 'cover' are for spheres: by the interpolant
        they err 20 to 40 % more than evenly spread ones; without a random tenth the mean error is 0.06 to 0.1 Å, not 0.002.
    reconstruction : {'auto', 'interpolant', 'spheres'}
        How the surface is reconstructed for its error, as in `recover`; 'auto' (default) is 'spheres' with 'cover', and where
        the sampler 'auto' keeps dots on atoms for an error, else 'interpolant'.
    error_99 : float, optional
        Distance within which 99 % of the true surface lies from the reconstructed one, Å. With 'cover' it holds in both
        directions and is 5 times `error` by default; `math.inf` bounds the mean error alone, which is then predicted and not
        measured. Other samplers bound only the mean by default, and 99 % is then about 5 to 7 times the mean.
    d_link, seed : float, int
        As in `prepare`, with the same defaults. A study and `sparsurf minimal` choose the same dots with the same seed.

    Returns
    -------
    Subset
        `dots` (n,) int, the indices of the kept dots; `weight` (n,) int, how many dots each one represents; `points` and
        `normals` (n, 3) in Å; `surface`, a Surface of the kept dots; `table`, a DataFrame; `help(few)` explains the rest.

    Raises
    ------
    InputError
        More than one size is given, or the size cannot be had from this surface.

    Examples
    --------
    >>> import sparsurf
    >>> few = sparsurf.minimal("data/tdp43/topology.pdb", percent=10)
    >>> few, few.points.shape, list(few.table)[:4]
    (Subset of 2,460 dots of 24,600, (2460, 3), ['dot', 'x', 'y', 'z'])
    """
    sizes = {"percent": percent, "n_dots": n_dots, "density": density, "error": error, "max_z": max_z}
    request: dict[str, Any] = {key: value for key, value in sizes.items() if value is not None}
    if len(request) > 1:
        raise InputError("minimal: give only one of percent, n_dots, density, error and max_z.")
    dots = _linked_dots(surface, d_link)
    if request.get("n_dots", 0) > len(dots):
        raise InputError(
            f"minimal: {argument('n_dots')} is {request['n_dots']}, more than the {len(dots)} dots of the surface; request fewer."
        )
    if not (isinstance(sampler, str) and sampler == AUTO):
        get_samplers([sampler], "minimal.sampler")  # names an unknown one
    if error_99 is not None and request and "error" not in request:
        raise InputError(
            f"minimal: {argument('error_99')} belongs to an error; leave out {argument(next(iter(request)))} or "
            f"{argument('error_99')}."
        )
    ways = {"sampler": sampler, "reconstruction": reconstruction, "error_99": error_99}
    wanted = Minimal(**request).model_copy(update=ways)
    settings = Settings(patches=PatchesSettings(d_link=d_link)).model_copy(update={"minimal": wanted})
    molecule = dots.molecule if dots.placed else None
    result = represent(dots, settings, Streams(seed), molecule, threads=available_cores())
    if not result.determines_atoms:
        warn_of_gaps("minimal", result.trials.prepared, result.subset.dots)
    few = result.subset
    if (percent, n_dots, density) == (None, None, None) and len(few) == few.weight.sum():
        log.warning("minimal: no smaller subset meets the limit, and all %d dots are kept", len(few))
    return few


@public(of_dots=True)
def floors(surface: SurfaceLike, *, d_link: float = D_LINK, seed: int = DEFAULT_SEED) -> pd.DataFrame:
    """Measure the noise floor of Z: the distance between the descriptors of two sets of dots of one surface.

    A Z below this floor cannot be distinguished from that of the whole surface with other dots.

    Parameters
    ----------
    surface : path, Molecule, atoms of another library, or Surface from `surface`
        The molecule whose dots are placed anew; dots from `surface` carry it.
    d_link : float
        Distance below which two dots of a patch are linked, Å (default 0.5).
    seed : int
        Seed for the choice of the test dots (default 20261120).

    Returns
    -------
    DataFrame
        One row: floor ('fresh dots', other dots of the same surface), Z, se, low and high (95 % interval), draws,
        test_dots.

    Raises
    ------
    InputError
        The dots carry no molecule, or an argument is outside of its limits.

    Examples
    --------
    >>> import sparsurf
    >>> table = sparsurf.floors("protein.pdb")  # doctest: +SKIP
    """
    dots = _linked_dots(surface, d_link)
    prepared = prepare(dots, d_link=d_link, seed=seed)
    return floors_table(fresh_dots(prepared, number_of_tests(DEFAULT_TEST_DOTS, len(dots)), *dots.generator))


@public(renamed={"model": "reconstruction"})
def recover(
    few: DotsLike | SurfaceAtoms,
    *,
    density: float = DENSITY,
    reach: float = REACH,
    steps: int = NEWTON_STEPS,
    reconstruction: Model = AUTO,
) -> Surface:
    """Reconstruct a dense surface from a few dots with normals; nothing else of the molecule is needed.

    The atoms that the dots lie on are inferred from them (see `infer_atoms`). The surface is the one that a probe rolls over
    these atoms, kept out by the dots that no atom explains; where dots do not lie on atoms, it is interpolated.

    Parameters
    ----------
    few : Subset, Points, Surface, path, pair (points, normals), or SurfaceAtoms
        The few dots, such as those from `minimal` or `points`, a file of them, or (n, 3) arrays in Å. Atoms from `surface_atoms`
        determine the surface exactly, and dots are placed on them as by `surface`; `reach`, `steps` and `reconstruction` are
        about dots.
    density : float
        Dots per Å^2 of the reconstructed surface (default 5.35). Where it is interpolated, it has up to a third more.
    reach : float
        How far an interpolated surface extends around a dot, in units of the local spacing of the dots (default 1). A reach of
        2 closes holes between unevenly spread dots; larger values place dots where there is no surface.
    steps : int
        Largest number of Newton steps that move a new dot onto the surface (default 4).
    reconstruction : {'auto', 'interpolant', 'spheres'}
        'auto' (default) uses the inferred atoms if they explain the dots, and the interpolant elsewhere, or as a file of dots
        says; it is the interpolant alone for fewer than 100 dots, dots with noise, and surfaces of another kind. 'interpolant'
        never infers atoms. 'spheres' refuses dots of which fewer than half lie on the inferred atoms.

    Returns
    -------
    Surface
        The few dots, unchanged, followed by the new dots between them, with normals, areas (estimated where the surface is
        interpolated) and interpolated fields. `recovered` has the number of the few dots, and the share of
        them that lies on inferred atoms.

    Raises
    ------
    InputError
        The dots cannot be used, an argument is outside of its limits, or the dots do not lie on spheres, which were asked for.

    Examples
    --------
    >>> import sparsurf
    >>> dots = sparsurf.surface("data/tdp43/topology.pdb")
    >>> len(sparsurf.recover(dots[sparsurf.sample(dots, percent=10)]))
    23561
    """
    if isinstance(few, SurfaceAtoms):
        if (reach, steps, reconstruction) != (REACH, NEWTON_STEPS, AUTO):
            raise InputError(
                "recover: reach, steps and reconstruction are about dots; leave them out for atoms."
            )
        return surface_of_atoms(few, replace(few.rules, density=density))
    kept = as_dots(few)
    rebuilt = reconstruct(kept, density, reconstruction, reach, steps, available_cores())
    log.info("recover: %.0f %% of the dots lie on spheres of inferred atoms", 100 * rebuilt.share)
    return replace(surface_with_fields(kept, rebuilt), recovered=Recovered(len(kept), rebuilt.share))


def _linked_dots(source: SurfaceLike, d_link: float) -> Surface:
    """Return the dots of all that `as_surface` takes, dense enough for `d_link`, Å."""
    dots = as_surface(source, d_link)
    refuse_sparse(dots.points, d_link, "surface")
    return dots
