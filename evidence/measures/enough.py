"""How many dots are enough: by an error in Å, and by noise floors of both descriptors, whose factor decides."""

from collections.abc import Callable

import numpy as np
import pandas as pd

from sparsurf.evaluation.crossing import fitted_crossing
from sparsurf.evaluation.floors import FRESH, measure_floors
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.required_dots import (
    DRAWS,
    Required,
    Trials,
    required_for_error,
    required_to_recover,
    sizes_around,
)
from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.recovery.errors import (
    DENSITY_FOR_ERRORS,
    EVERYWHERE,
    curvature,
    distance_to_recovered,
    error_table,
)
from sparsurf.surfaces.surface import Surface

SAMPLER = "farthest"
ROBUST = "rotation_robust"
FACTORS = {PUBLISHED: (1.1, 1.2, 1.5), ROBUST: (1.2,)}  # of the floor of fresh dots


def enough_table(
    prepared: PreparedSurface,
    generator: Callable[[np.ndarray], Surface],
    xyz: np.ndarray,
    n_tests: int,
    error: float,
) -> pd.DataFrame:
    """Find n_S by each rule, and the error of the surface recovered from so many dots.

    Returns DataFrame: rule (error or descriptor), limit (Å or factor of the floor), n_S_percent with its 95 % interval, density
    (dots per Å^2), and mean, high_99 and largest distance in Å.
    """
    trials, rows = Trials(prepared, SAMPLER, n_tests), []

    def add(rule: str, limit: float, required: Required) -> None:
        kept = trials.draw(required.n_s)
        few = prepared.surface.take(kept)
        distance = distance_to_recovered(
            prepared.points, few.points, few.normals, prepared.threads, DENSITY_FOR_ERRORS
        )
        table = error_table(distance, curvature(prepared.index), kept).set_index("where").loc[EVERYWHERE]
        percents = 100 * np.array(required[:3]) / len(prepared)
        row = {
            "rule": rule,
            "limit": limit,
            **dict(zip(("n_S_percent", "low", "high"), percents, strict=True)),
        }
        row["density"] = required.n_s / prepared.area
        rows.append(row | table[["mean", "high_99", "largest"]].to_dict())

    add("error", error, required_for_error(trials, error))
    for descriptor, factors in FACTORS.items():
        view = prepared.changed(patches=prepared.patches.model_copy(update={"descriptor": descriptor}))
        of_view = Trials(view, SAMPLER, n_tests)
        floor = measure_floors(view, len(of_view.tests), generator, xyz, moved=())[FRESH]
        for factor in factors:
            add(descriptor, factor, required_to_recover(of_view, floor, factor))
    return pd.DataFrame(rows)


def coverage_of_error(trials: Trials, error: float, draws: int, replicates: int) -> dict[str, float]:
    """Measure how often the interval of the n_S for an error holds the n_S of many draws, from replicates of `DRAWS` of them."""
    sizes = sizes_around(trials, error)
    pool = np.array([_errors(trials, int(n), draws) for n in sizes])
    rng, target = trials.prepared.stream("coverage of the error"), np.full((1, 1), error)

    def crossing(errors: np.ndarray) -> tuple[float, float, float]:
        return fitted_crossing(sizes.astype(float), errors[..., None], target, 1.0, trials.n_dots, rng)

    truth, inside, widths = crossing(pool)[0], [], []
    for _ in range(replicates):
        n, low, high = crossing(
            np.take_along_axis(pool, rng.integers(draws, size=(len(sizes), DRAWS)), axis=1)
        )
        inside.append(low <= truth <= high)
        widths.append((high - low) / n)
    known = {"n_S_percent": 100 * truth / trials.n_dots, "draws": draws, "replicates": replicates}
    return known | {"coverage": float(np.mean(inside)), "width_percent": 100 * float(np.mean(widths))}


def _errors(trials: Trials, n: int, draws: int) -> list[float]:
    """Return the mean errors of many draws of n dots."""
    prepared = trials.prepared
    out = []
    for k in range(draws):
        kept = trials._sampler(prepared, n, prepared.stream("pool of errors", n, k))
        few = prepared.surface.take(kept)
        distance = distance_to_recovered(
            prepared.points, few.points, few.normals, prepared.threads, DENSITY_FOR_ERRORS
        )
        out.append(float(np.delete(distance, kept).mean()))
    return out
