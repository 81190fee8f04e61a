"""Kept dots as centres of patches: how far the patch of a dot is from that of the nearest centre."""

from collections.abc import Sequence

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job
from measures.proteins import table_of_proteins
from measures.tables import write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate, reference_values
from sparsurf.sampling.samplers import get_samplers, nearest_kept
from sparsurf_study.analysis.relation import with_interval

UNIFORM = "uniform"


def centres_table(
    prepared: PreparedSurface, samplers: Sequence[str], percents: Sequence[float], n_tests: int, draws: int
) -> pd.DataFrame:
    """Measure the distance of the patch of a test dot to that of the nearest kept dot, both cut from the full surface.

    Returns
    -------
    DataFrame: sampler, percent (requested), n_S_percent, Z_centres and Z_centres_se, its standard error over draws and test
    dots, Z_two_patches (mean distance of two test dots' patches) and ratio, Z_centres over Z_two_patches
    """
    tests = prepared.draw_tests(n_tests)
    z_tot = prepared.describe(tests)[0]
    two_patches = reference_values(z_tot)["Z_two_patches"]
    rows = []
    for name, method in get_samplers(samplers, "samplers").items():
        for percent in percents:
            n, sizes, nearest = round(percent / 100 * len(prepared)), [], []
            for draw in range(draws):
                subset = method(prepared, n, prepared.stream("centres", name, n, draw))
                sizes.append(len(subset))
                nearest.append(subset[nearest_kept(prepared.points, subset)[0][tests]])
            centres, place = np.unique(nearest, return_inverse=True)
            of_centres = prepared.describe(centres)[0][place.reshape(draws, -1)]
            found = estimate(np.linalg.norm(of_centres - z_tot, axis=-1))
            row = {
                "sampler": name,
                "percent": percent,
                "n_S_percent": 100 * np.mean(sizes) / len(prepared),
                "Z_centres": float(found.mean),
                "Z_centres_se": float(found.error),
                "Z_two_patches": two_patches,
            }
            rows.append(row | {"ratio": row["Z_centres"] / two_patches})
    return pd.DataFrame(rows)


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the ratio of each sampler over proteins.

    Returns
    -------
    DataFrame: percent, sampler, n (proteins), n_S_percent, ratio with its 95 % interval over proteins, its lowest and highest,
    more_than_uniform (ratio less that of the random subset) with its 95 % interval, n_below and n_above (proteins whose ratio
    is below and above that of the random subset)
    """
    keys, rows = ["protein", "percent"], []
    uniform = table[table["sampler"] == UNIFORM].set_index(keys)["ratio"]
    for (percent, sampler), part in table.groupby(["percent", "sampler"], sort=False):
        more = part["ratio"].to_numpy() - uniform.loc[pd.MultiIndex.from_frame(part[keys])].to_numpy()
        row = {
            "percent": percent,
            "sampler": sampler,
            "n": len(part),
            "n_S_percent": part["n_S_percent"].mean(),
        }
        row |= with_interval("ratio", part["ratio"])
        row |= {"ratio_lowest": part["ratio"].min(), "ratio_highest": part["ratio"].max()}
        row |= with_interval("more_than_uniform", more)
        rows.append(row | {"n_below": int((more < 0).sum()), "n_above": int((more > 0).sum())})
    return pd.DataFrame(rows)


def measure_centres(job: Job) -> None:
    """Tabulate kept dots as centres of patches, over proteins."""
    params, out = job.params, job.output
    design = params.samplers, params.percents, params.test_dots, params.draws
    table = table_of_proteins(job, "centres", lambda prepared: centres_table(prepared, *design), "protein")
    write_tables({out.table: table, out.means: means(table)})
