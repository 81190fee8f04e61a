"""Table I on a surface of one of the paper's fragments: its ten combinations, and the repeated choice of each range."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd

from sparsurf_study.workflow.jobs import Job, reporter
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.statistics import cross_validated, estimate
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.readings import FULL_READING, GRID_READINGS, KEPT_READING
from sparsurf.sampling import published
from sparsurf.sampling.combination import PUBLISHED_ROWS, TABLE_1, Combination
from sparsurf.settings import Settings
from sparsurf.settings import SurfaceSettings as SurfaceSettings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import roll_frame
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.analysis import tables
from sparsurf_study.analysis.best_set import best_set
from sparsurf_study.analysis.grid import Grid, evaluate_grid
from sparsurf_study.paper.replication import gathering_by_roughness
from sparsurf_study.report.figures.table1 import table1_figure

FROM_FILE = "file"  # the dots are those of the file
PUBLISHED_BEST = 5  # row of Table I with the highest d, (1, 0, 6, 0)
OF_SURFACE = ["dots", "centres", "mean_roughness", "lowest_roughness", "highest_roughness"]
ALL = "all"  # surfaces together
OF_STUDY = "A1_dms, other test dots"  # the surface of `make paper`
ROW = ["row", "combination", "d_published", "Z_published"]


def prepare(path: str, params: Any, name: str, threads: int) -> PreparedSurface:
    """Prepare the dots of a structure or a file by the params of a rule: dots, surface, patches, seed."""
    surface = dots_of(path, params.dots, params.surface)
    return PreparedSurface(
        surface, Settings(patches=params.patches), None, Streams(params.seed, name), threads
    )


def table_over_links(job: Job, measure: Callable[..., pd.DataFrame]) -> pd.DataFrame:
    """Measure a table over the linking distances of a rule, on the surface of its job, which the first column names."""
    name, params = job.wildcards.protein, job.params
    prepared = prepare(job.input.structure, params, f"links {name}", job.threads)
    table = measure(prepared, params.links, params.test_dots, params.draws)
    table.insert(0, "surface", name)
    return table


def dots_of(path: str, dots: str, settings: dict) -> Surface:
    """Read the dots of a file, or place dots on the structure in it ('dms' or 'exact', see `surface.reentrant`)."""
    if dots == FROM_FILE:
        return read_surface(path)
    molecule, rules = read_molecule(path), SurfaceSettings(**settings | {"reentrant": dots})
    assert rules.density != "auto"
    return roll_frame(molecule.xyz[0], radii(molecule, "dms"), rules).surface(rules.density)


def rows_table(grid: Grid) -> pd.DataFrame:
    """Compare d and Z of the published combinations with the published values.

    Parameters
    ----------
    grid : Grid of the published combinations, in the order of Table I

    Returns
    -------
    DataFrame, one row per reading and row of Table I: reading, row, combination, n_S_percent, d_published, Z_published, d and
    Z with 95 % intervals, d_inside and Z_inside (whether the published value lies inside, 0 or 1)
    """
    rows = []
    for r, reading in enumerate(grid.readings):
        d, z = estimate(tables.d_values(grid, r)), estimate(grid.z_ts[r])
        for k, combination in enumerate(PUBLISHED_ROWS):
            row = {"reading": reading, "row": k + 1, "combination": str(Combination(*combination))}
            row["n_S_percent"] = 100 * grid.n_s[k].mean() / grid.n_dots
            for name, of_name, key in (("d", d, "d"), ("Z", z, "Z_tS")):
                value = TABLE_1[key][k]
                row |= {
                    f"{name}_published": value,
                    name: of_name.mean[k],
                    f"{name}_low": of_name.low[k],
                    f"{name}_high": of_name.high[k],
                    f"{name}_inside": int(of_name.low[k] <= value <= of_name.high[k]),
                }
            rows.append(row)
    return pd.DataFrame(rows)


def choices_table(grid: Grid) -> pd.DataFrame:
    """Ask what choosing again on this surface gains over the combination of Table I.

    Each published combination is compared with all combinations of the range of n_S into which it falls here.

    Returns
    -------
    DataFrame, one row per reading and row of Table I: reading, row, n_S_percent, range (from 1, the one into which it falls),
    n_S_lowest_percent and n_S_highest_percent of the grid, d, gain with its 95 % interval (d of the combination chosen here minus
    d of the published one, cross-validated), may_be_best (0 or 1: it is in the confidence set of the best), rank in its range
    """
    percent = 100 * grid.n_s.mean(axis=1) / grid.n_dots
    limits = tables.range_limits(percent, len(PUBLISHED_ROWS))
    member, rows = tables.range_index(percent, limits), []
    for r, reading in enumerate(grid.readings):
        d = tables.d_values(grid, r)
        means = d.mean(axis=(1, 2))
        for k, combination in enumerate(PUBLISHED_ROWS):
            found = np.flatnonzero(np.isclose(grid.combinations, combination).all(axis=1))
            if not len(found):  # a grid of few combinations
                continue
            own = found[0]
            inside = np.flatnonzero(member == member[own])
            gain = cross_validated(d[inside] - d[own])
            rows.append(
                {
                    "reading": reading,
                    "row": k + 1,
                    "n_S_percent": percent[own],
                    "range": member[own] + 1,
                    "n_S_lowest_percent": percent.min(),
                    "n_S_highest_percent": percent.max(),
                    "d": means[own],
                    "gain": float(gain.mean),
                    "gain_low": float(gain.low),
                    "gain_high": float(gain.high),
                    "may_be_best": int(best_set(d[inside])[np.flatnonzero(inside == own)[0]]),
                    "rank": int((means[inside] > means[own]).sum()) + 1,
                    "n_combinations": len(inside),
                }
            )
    return pd.DataFrame(rows)


def surface_row(prepared: PreparedSurface) -> dict[str, float]:
    """Return dots, centres and roughness of a surface."""
    rough = prepared.roughness
    return {
        "dots": len(prepared.points),
        "centres": len(prepared.cover.centre),
        "mean_roughness": rough.mean(),
        "lowest_roughness": rough.min(),
        "highest_roughness": rough.max(),
    }


def published_grid(sampling: dict[str, list[float]]) -> np.ndarray:
    """Return the grid of combinations of the paper, (K, 4)."""
    return published.parameter_grid(**sampling)


def table1_of(rows: pd.DataFrame) -> pd.DataFrame:
    """Return Table I among the kept dots with a column of d and Z for each surface: d_A1_file, d_A1_file_low, ..."""
    coded = rows[rows["reading"] == KEPT_READING]
    table = coded.drop_duplicates("row")[ROW].set_index("row")
    for surface, of_surface in coded.groupby("surface", sort=False):
        values = of_surface.set_index("row")
        table[f"n_S_percent_{surface}"] = values["n_S_percent"]
        for name in ("d", "Z"):
            for end in ("", "_low", "_high"):
                table[f"{name}_{surface}{end}"] = values[f"{name}{end}"]
    return table.reset_index()


def inside_of(rows: pd.DataFrame) -> pd.DataFrame:
    """Return the number of published values of d and Z inside of the intervals, per surface and reading, and the sign of d."""
    groups = rows.groupby(["surface", "reading"], sort=False)
    above, below = (
        rows.assign(there=there.astype(int)).groupby(["surface", "reading"], sort=False)["there"].sum()
        for there in (rows["d_low"] > 0, rows["d_high"] < 0)
    )
    table = groups.agg(rows=("row", "size"), d_inside=("d_inside", "sum"), Z_inside=("Z_inside", "sum"))
    return table.assign(d_above_0=above, d_below_0=below).reset_index()


def rows_of_study(paper_rows: pd.DataFrame) -> pd.DataFrame:
    """Return the rows of the paper's study, with test dots of its own, in the form of `fragments.rows_table`."""
    tables = []
    for reading in GRID_READINGS:
        table = pd.DataFrame({"surface": OF_STUDY, "reading": reading, "row": range(1, len(paper_rows) + 1)})
        for name, key in (("d", "d"), ("Z", "Z_tS")):
            low, high = paper_rows[f"{key}_low_{reading}"], paper_rows[f"{key}_high_{reading}"]
            table[f"{name}_low"], table[f"{name}_high"] = low, high
            table[f"{name}_inside"] = paper_rows[f"{key}_published"].between(low, high).astype(int)
        tables.append(table)
    return pd.concat(tables, ignore_index=True)


def rows_to_draw(rows: pd.DataFrame, surface: str) -> pd.DataFrame:
    """Return the rows of Table I on one surface for its figure: ranges, combinations, and d and Z_tS under `full`."""
    table = pd.DataFrame(TABLE_1)
    own = rows[(rows["surface"] == surface) & (rows["reading"] == FULL_READING)].sort_values("row")
    measured = {f"d_{FULL_READING}": own["d"].to_numpy(), f"Z_tS_{FULL_READING}": own["Z"].to_numpy()}
    return table.assign(**measured)


def verdict_of(places: pd.DataFrame) -> pd.DataFrame:
    """Count the published values that agree with the runs made as published: one row.

    d_inside and Z_inside count values within 95 % of the runs, in_span those between the lowest and the highest run, n_won the
    rows whose published combination won at least one run.
    """
    spans = [
        places[f"{name}_published"].between(places[f"{name}_lowest"], places[f"{name}_highest"]).sum()
        for name in ("d", "Z_tS")
    ]
    row = {"rows": len(places), "values": 2 * len(places), "runs": places["n_runs"].max()}
    row |= {"d_inside": places["d_inside"].sum(), "Z_inside": places["Z_tS_inside"].sum()}
    return pd.DataFrame([row | {"in_span": sum(spans), "n_won": (places["n_won"] > 0).sum()}])


def surfaces_of(rows: pd.DataFrame, choices: pd.DataFrame) -> pd.DataFrame:
    """Return a row per surface and reading, and one for `all` surfaces: its dots, and how the choices of Table I do on it.

    A combination that falls into another range of n_S on a surface has other opponents there than in Table I. So only rows count
    that stay in their range, n_same_range: n_may_be_best of them may be the best of it here, for n_worse choosing again gains
    significantly, and gain is their mean. d_best is that of (1, 0, 6, 0) in its range.
    """
    keys = ["surface", "reading"]
    stay = choices[choices["range"] == choices["row"]].assign(worse=lambda t: t["gain_low"] > 0)
    table = (
        pd.concat([stay, stay.assign(surface=ALL)])
        .groupby(keys, sort=False)
        .agg(
            n_S_lowest_percent=("n_S_lowest_percent", "min"),
            n_S_highest_percent=("n_S_highest_percent", "max"),
            n_may_be_best=("may_be_best", "sum"),
            n_worse=("worse", "sum"),
            n_same_range=("row", "size"),
            gain=("gain", "mean"),
            largest_gain=("gain", "max"),
        )
    )
    best = choices[choices["row"] == PUBLISHED_BEST].set_index(keys)
    for column in ("d", "gain", "gain_low", "gain_high", "may_be_best"):
        table[f"{column}_best"] = best[column]
    of_surface = rows.drop_duplicates("surface").set_index("surface")[OF_SURFACE]
    return table.reset_index().merge(of_surface, on="surface", how="left")


def measure_fragments(job: Job) -> None:
    """Measure Table I on one surface: its combinations, the repeated choice of each range, and where the kept dots lie."""
    name, params, output = job.wildcards.surface, job.params, job.output
    prepared = prepare(job.input.structure, params, f"fragment {name}", job.threads)
    of_surface, of_rows, of_grid = (
        surface_row(prepared),
        params.rows_evaluation,
        params.grid_evaluation,
    )
    ten = evaluate_grid(prepared, PUBLISHED_ROWS, of_rows["test_dots"], of_rows["draws"])
    combinations = published_grid(params.sampling)
    grid = evaluate_grid(
        prepared, combinations, of_grid["test_dots"], of_grid["draws"], progress=reporter(name)
    )
    tables: dict[str, pd.DataFrame] = {
        output.rows: rows_table(ten).assign(**of_surface),
        output.choices: choices_table(grid),
        output.gathering: gathering_by_roughness(prepared, of_rows["draws"]),
    }
    for path, table in tables.items():
        table.insert(0, "surface", name)
        table.to_csv(path, index=False)


def tabulate_fragments(job: Job) -> None:
    """Tabulate the published values of Table I next to ours on all surfaces of the paper, and whether its choices carry over."""
    output = job.output
    rows, choices = read_tables(job.input.rows), read_tables(job.input.choices)
    places = pd.read_csv(job.input.places)
    of_study = rows_of_study(pd.read_csv(job.input.paper_rows))  # of `make paper`
    drawn = table1_figure(places, rows_to_draw(rows, job.params.repeated))
    layout.save(drawn, output.figure)
    write_tables(
        {
            output.rows: rows,
            output.table1: table1_of(rows),
            output.inside: inside_of(pd.concat([rows, of_study], ignore_index=True)),
            output.choices: choices,
            output.surfaces: surfaces_of(rows, choices),
            output.gathering: pd.read_csv(job.input.gathering),
        }
    )
