"""How many dots are enough for an error in Å, and how often the interval of that number holds it."""

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures import fragments
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.subset_search import smallest_subset_of_error
from sparsurf.evaluation.trials import Trials
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.errors import (
    DENSITY_FOR_ERRORS,
    distance_to_recovered,
    error_table,
)
from sparsurf.streams import Streams

SAMPLER = "farthest"


def enough_table(prepared: PreparedSurface, error: float, hydrogens: bool) -> pd.DataFrame:
    """Find n_S for an error, and the errors of the surface recovered from so many dots.

    Returns DataFrame: limit (Å), n_S_percent with its 95 % interval, density (dots per Å^2), and mean, high_99 and largest
    distance in Å.
    """
    kept, interval, _ = smallest_subset_of_error(Trials(prepared, SAMPLER, 2), error, hydrogens)
    few = prepared.surface.take(kept)
    distance = distance_to_recovered(
        prepared.points, few.points, few.normals, prepared.threads, DENSITY_FOR_ERRORS
    )
    table = error_table(distance, None, kept).iloc[0]
    numbers = 100 * np.array([len(kept), *(interval or (np.nan, np.nan))]) / len(prepared)
    row = {"limit": error, **dict(zip(("n_S_percent", "low", "high"), numbers, strict=True))}
    row["density"] = len(kept) / prepared.area
    return pd.DataFrame([row | table[["mean", "high_99", "largest"]].to_dict()])


def coverage_of_error(
    prepared: PreparedSurface, error: float, hydrogens: bool, seeds: int
) -> dict[str, float]:
    """Measure how often the interval of the n_S for an error holds the mean over seeds, each with its own order of choice."""
    found = []
    for seed in range(seeds):
        of_seed = prepared.with_streams(Streams(seed, prepared.name))
        kept, interval, _ = smallest_subset_of_error(Trials(of_seed, SAMPLER, 2), error, hydrogens)
        found.append((len(kept), *(interval or (np.nan, np.nan))))
    n, low, high = np.array(found).T
    truth, n_dots = float(n.mean()), len(prepared)
    return {
        "n_S_percent": 100 * truth / n_dots,
        "seeds": seeds,
        "coverage": float(np.mean((low <= truth) & (truth <= high))),
        "width_percent": 100 * float(np.mean((high - low) / n)),
    }


def measure_enough(job: Job) -> None:
    """Measure how many dots of one surface are enough for an error in Å, and the coverage of the interval of that number."""
    name, params = job.wildcards.protein, job.params
    prepared = fragments.prepare(job.input.structure, params, f"enough {name}", job.threads)
    hydrogens = not read_molecule(job.input.structure).heavy.all()
    table = enough_table(prepared, params.error, hydrogens)
    covered = coverage_of_error(prepared, params.error, hydrogens, params.seeds)
    table.insert(0, "surface", name)
    table.to_csv(job.output.table, index=False)
    pd.DataFrame([{"surface": name} | covered]).to_csv(job.output.coverage, index=False)


def tabulate_enough(job: Job) -> None:
    """Tabulate how many dots are enough on several surfaces, and the coverage of the interval."""
    write_tables(
        {
            job.output.table: read_tables(job.input.tables),
            job.output.coverage: read_tables(job.input.coverage),
        }
    )
