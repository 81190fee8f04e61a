"""What roughness contributes to d of Table I: R_i, and other values in its place, with the same random numbers."""

from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure

from sparsurf_study.workflow.jobs import Job
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import estimate
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.readings import KEPT_READING
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.settings import Settings
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import surface_of_molecule
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf_study.analysis import tables
from sparsurf_study.analysis.grid import evaluate_grid
from sparsurf_study.analysis.relation import with_interval

OWN, MEAN = "R", "mean of R"
IN_PLACE: dict[str, Callable[[np.ndarray, np.random.Generator], np.ndarray]] = {
    OWN: lambda rough, rng: rough,
    MEAN: lambda rough, rng: np.full_like(rough, rough.mean()),
    "R permuted": lambda rough, rng: rng.permutation(rough),
    "lowest + highest - R": lambda rough, rng: rough.min() + rough.max() - rough,
}
SURFACES = ["surfaces", "reading", "values"]
GAINING = 7  # rows of Table I that gain significantly on A1


def differences(
    surface: Surface,
    settings: Settings,
    streams: Streams,
    readings: Sequence[str],
    n_tests: int,
    draws: int,
    threads: int,
    combinations: np.ndarray = PUBLISHED_ROWS,
    in_place: Sequence[str] = tuple(IN_PLACE),
) -> pd.DataFrame:
    """Measure d of combinations, those of Table I by default, with R_i and with other values in its place.

    Test dots, the random numbers of all pairs (centre, dot) and the random orders of the random subsets are the same, so that
    the values differ by what stands in the place of R_i only.

    Returns
    -------
    DataFrame: reading, row, values (what stands in the place of R_i), n_S_percent, d, change (d with R_i less d with these
    values, paired by draw and test dot) and change_se, its standard error
    """
    first = PreparedSurface(surface, settings, None, streams, threads)
    rng, found = first.stream("values in the place of R"), {}
    for name in in_place:
        values = IN_PLACE[name](first.roughness, rng)
        prepared = PreparedSurface(surface, settings, values, streams, threads)
        found[name] = evaluate_grid(prepared, combinations, n_tests, draws, tuple(readings))
    rows = []
    for r, reading in enumerate(readings):
        own = tables.d_values(found[OWN], r)
        for name, result in found.items():
            d = tables.d_values(result, r)
            change, mean = estimate(own - d), d.mean(axis=(1, 2))
            percent = 100 * result.n_s.mean(axis=1) / result.n_dots
            for k in range(len(combinations)):
                row = {
                    "reading": reading,
                    "row": k + 1,
                    "values": name,
                    "n_S_percent": percent[k],
                    "d": mean[k],
                }
                rows.append(row | {"change": change.mean[k], "change_se": change.error[k]})
    return pd.DataFrame(rows)


def means(table: pd.DataFrame, paper: str) -> pd.DataFrame:
    """Describe the changes of d on the paper's surface and over the other proteins, by row and over the rows that gain.

    Returns
    -------
    DataFrame: surfaces ('paper' or 'proteins'), reading, values, rows (one; '1 to 7', whose mean of each protein counts once; or
    'largest', the one row whose mean change is the largest in size), n (proteins), d (with R_i), change with its 95 % interval
    over proteins, change_sd, change_lowest and change_highest, change_se (root mean square of the standard errors of single
    proteins), n_S_change (n_S with these values less n_S with R_i, in points of %); and of 'largest' row (which one it is),
    any_lowest and any_highest (of the changes of all rows and proteins)
    """
    keys = ["protein", "reading", "row"]
    own = table.loc[table["values"] == OWN, [*keys, "d", "n_S_percent"]]
    joined = table[table["values"] != OWN].merge(own, on=keys, suffixes=("", "_own"))
    joined["n_S_change"] = joined["n_S_percent"] - joined["n_S_percent_own"]
    gaining = joined[joined["row"] <= GAINING]
    keys = ["protein", "reading", "values"]
    pooled = gaining.groupby(keys, sort=False).mean(numeric_only=True).reset_index()
    pooled = pooled.assign(rows=f"1 to {GAINING}", change_se=np.nan)
    every = pd.concat([joined.assign(rows=joined["row"].astype(str)), pooled], ignore_index=True)
    out = []
    for surfaces, is_paper in (("paper", True), ("proteins", False)):
        part = every[(every["protein"] == paper) == is_paper]
        for (reading, values, rows), group in part.groupby(["reading", "values", "rows"], sort=False):
            change = group["change"]
            row = {"surfaces": surfaces, "reading": reading, "values": values, "rows": rows, "n": len(group)}
            row |= {"d": group["d_own"].mean()} | with_interval("change", change)
            row |= {"change_sd": change.std(), "change_lowest": change.min(), "change_highest": change.max()}
            row["change_se"] = np.sqrt((group["change_se"] ** 2).mean())
            out.append(row | {"n_S_change": group["n_S_change"].mean()})
    found = pd.DataFrame(out)
    single = found[found["rows"].str.isdigit()]
    at = single["change"].abs().groupby([single[key] for key in SURFACES], sort=False).idxmax()
    largest = single.loc[at].assign(row=single.loc[at, "rows"].astype(int), rows="largest")
    ends = single.groupby(SURFACES, sort=False).agg(
        any_lowest=("change_lowest", "min"), any_highest=("change_highest", "max")
    )
    largest = largest.merge(ends.reset_index(), on=SURFACES)
    return pd.concat([found, largest], ignore_index=True)


@styled
def draw(table: pd.DataFrame, paper: str) -> Figure:
    """Draw d with R_i against d with its mean, a point for each row of Table I and protein; the paper's surface is outlined."""
    own = table[(table["reading"] == KEPT_READING) & (table["values"] == OWN)].set_index(["protein", "row"])[
        "d"
    ]
    mean = table[(table["reading"] == KEPT_READING) & (table["values"] == MEAN)].set_index(
        ["protein", "row"]
    )["d"]
    figure = layout.constrained(layout.COLUMN_AND_A_HALF, 88)
    ax = figure.subplots()
    colours = colormaps["viridis"](np.linspace(0, 0.92, len(PUBLISHED_ROWS)))
    for row, colour in enumerate(colours, 1):
        here = [key for key in own.index if key[1] == row]
        others = [key for key in here if key[0] != paper]
        ax.scatter(mean[others], own[others], s=6, color=colour, linewidths=0, alpha=0.7, label=f"row {row}")
        if (paper, row) in own.index:
            ax.scatter(
                mean[paper, row],
                own[paper, row],
                s=28,
                color=colour,
                edgecolor="black",
                linewidth=0.8,
                zorder=3,
            )
            place, side = (mean[paper, row], own[paper, row]), 1 if row <= len(PUBLISHED_ROWS) / 2 else -1
            style = {"ha": "left", "va": "top"} if side == 1 else {"ha": "right", "va": "bottom"}
            ax.annotate(str(row), place, (4 * side, -4 * side), textcoords="offset points", **style)
    ends = np.array([min(own.min(), mean.min()), max(own.max(), mean.max())])
    ax.plot(ends, ends, color="black", linewidth=0.5, zorder=0)
    ax.set_aspect("equal")
    ax.set_xlabel("d with the mean of R for every patch")
    ax.set_ylabel("d with R of each patch")
    title = f"rows of Table I; outlined, with its number: {paper}"
    ax.legend(loc="upper left", ncols=2, markerscale=1.6, title=title, title_fontsize=7, alignment="left")
    return layout.fix_layout(figure)


def write_differences(job: Job, study: str, readings: Sequence[str], *options: Any) -> None:
    """Measure `differences` on the protein of a job, with the random streams of a study, and write their table."""
    name, params = job.wildcards.protein, job.params
    molecule = read_molecule(job.input.structure, model=1, hydrogens=params.hydrogens)
    settings = Settings(patches=params.patches)
    surface = surface_of_molecule(
        molecule, SurfaceSettings(**params.surface), settings.patches.d_link, name, 0
    )
    streams, design = Streams(params.seed, f"{study} {name}"), (params.test_dots, params.draws, job.threads)
    table = differences(surface, settings, streams, readings, *design, *options)
    table.insert(0, "protein", name)
    table.to_csv(job.output.table, index=False)


def measure_null_result(job: Job) -> None:
    """Measure d of the published combinations on one protein with R and with other values in its place, at equal draws."""
    write_differences(job, "null result", job.params.readings)


def tabulate_null_result(job: Job) -> None:
    """Tabulate and draw what roughness contributes to d of Table I over proteins."""
    table, out, paper = read_tables(job.input.tables), job.output, job.params.paper
    write_tables({out.table: table, out.means: means(table, paper)})
    layout.save(draw(table, paper), out.figure)
