"""d of the published combinations by linking distance and reading, and what single rules of the authors' code change."""

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.figure import Figure
from scipy.spatial import cKDTree

from sparsurf_study.workflow.jobs import Job
from measures import fragments
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import FULL_READING, KEPT_READING, SCALED_LINK, SCALED_READING
from sparsurf.sampling.combination import PUBLISHED_ROWS, Combination
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf_study.analysis import grid, tables
from sparsurf_study.paper import replication

COLUMNS = ["reading", "d_link", "row", "n_S_percent", "d", "d_low", "d_high"]
N_SHOWN = 5  # rows of Table I in the figure, every second one
BEYOND = {SCALED_READING: 1.3, FULL_READING: 1.48}  # where other readings stand on the axis of d_link


def links_table(prepared: PreparedSurface, links: list[float], n_tests: int, draws: int) -> pd.DataFrame:
    """Measure d of the published combinations under `kept` for every linking distance, and under the two other readings."""
    swept = replication.sweep_links(prepared, links, n_tests, draws).assign(reading=KEPT_READING)
    rows = replication.published_rows(prepared, n_tests, draws)
    spacing = np.sqrt(prepared.area / rows["n_S"])
    distances = {
        SCALED_READING: np.maximum(prepared.patches.d_link, SCALED_LINK * spacing),
        FULL_READING: prepared.patches.d_link,
    }
    others = [
        pd.DataFrame({"reading": reading, "d_link": link, "row": np.arange(1, len(rows) + 1)}).assign(
            n_S_percent=rows["n_S_percent"], **{key: rows[f"{key}_{reading}"] for key in COLUMNS[-3:]}
        )
        for reading, link in distances.items()
    ]
    return pd.concat([swept, *others], ignore_index=True)[COLUMNS]


def readings_table(table: pd.DataFrame) -> pd.DataFrame:
    """Put d of the three readings next to one another, a row for each surface and row of Table I, with d_link as published."""
    kept = table["reading"] == KEPT_READING
    first = table[~kept | (table["d_link"] == table.loc[kept, "d_link"].min())]
    out = first.drop_duplicates(["surface", "row"])[["surface", "row", "n_S_percent"]]
    for reading, rows in first.groupby("reading", sort=False):
        names = {key: f"{key}_{reading}" for key in COLUMNS[-3:]}
        out = out.merge(rows[["surface", "row", *names]].rename(columns=names), on=["surface", "row"])
    out["combination"] = [str(Combination(*PUBLISHED_ROWS[row - 1])) for row in out["row"]]
    return out


def rules_table(
    surface: Surface, prepared: PreparedSurface, orders: int, n_tests: int, draws: int
) -> pd.DataFrame:
    """Measure what rules of the authors' code that the text lacks change: DataFrame of rule, quantity and value."""
    rows: list[tuple[str, str, float]] = []
    tree = cKDTree(prepared.points)
    near = tree.query_ball_point(prepared.points, prepared.patches.r_patch)
    whole = np.array([np.linalg.norm(prepared.normals[ball].mean(axis=0)) for ball in near])
    differ = np.abs(whole - prepared.roughness)
    rows += [("islands in R_i", "share of dots whose R_i differs, %", 100 * (differ > 1e-6).mean())]
    rows += [("islands in R_i", "largest difference", differ.max())]
    rows += [("moved centre", "largest r / r_patch", np.exp(-prepared.cover.log_ratio.min()))]
    n_chances = np.bincount(prepared.cover.dot, minlength=len(prepared))
    rows += [("a chance in every patch", "patches of a dot, median", np.median(n_chances))]
    corrected = replication.compare_defects(prepared, n_tests, draws)
    for name, of_rule in corrected.groupby("sampling", sort=False):
        for row in of_rule.to_dict("records"):
            rows += [(str(name), f"{key} of row {row['row']}", row[column])
                     for key, column in (("n_S / %", "n_S_percent"), ("d", f"d_{KEPT_READING}"))]  # fmt: skip
    first = tables.grid_table(grid.evaluate_grid(prepared, PUBLISHED_ROWS, n_tests, draws, (KEPT_READING,)))
    changes = []
    for k in range(orders):
        order = prepared.stream("order of the dots", k).permutation(len(prepared))
        streams, settings = Streams(prepared.stream.seed, f"order {k}"), Settings(patches=prepared.patches)
        other = PreparedSurface(surface[order], settings, None, streams, prepared.threads)
        table = tables.grid_table(grid.evaluate_grid(other, PUBLISHED_ROWS, n_tests, draws, (KEPT_READING,)))
        percent = 100 * (table["n_S_expected"] - first["n_S_expected"]) / len(prepared)
        changes.append(np.c_[percent, table[f"d_{KEPT_READING}"] - first[f"d_{KEPT_READING}"]])
    mean = np.mean(changes, axis=0)
    for column, name in enumerate(("n_S, points", "d")):
        rows += [("order of the dots", f"lowest mean change of {name}", mean[:, column].min())]
        rows += [("order of the dots", f"highest mean change of {name}", mean[:, column].max())]
    return pd.DataFrame(rows, columns=["rule", "quantity", "value"])


@styled
def draw(table: pd.DataFrame) -> Figure:
    """Draw d against d_link: a panel for each surface, a line for every second row of Table I; other readings at the right."""
    surfaces = list(dict.fromkeys(table["surface"]))
    figure = layout.constrained(layout.PAGE_WIDTH, 112)
    panels = figure.subplots(2, -(-len(surfaces) // 2), sharex=True, sharey=True, squeeze=False).ravel()
    colours = colormaps["viridis"](np.linspace(0, 0.9, N_SHOWN))
    for ax, surface in zip(panels, surfaces, strict=False):
        own = table[(table["surface"] == surface) & (table["row"] % 2 == 1)]
        for (row, of_row), colour in zip(own.groupby("row"), colours, strict=True):
            kept = of_row[of_row["reading"] == KEPT_READING].sort_values("d_link")
            label = f"row {row}: {kept['n_S_percent'].iloc[0]:.0f} % on {surfaces[0]}"
            ax.errorbar(kept["d_link"], kept["d"], _error(kept), color=colour, linewidth=1, label=label)
            for reading, x in BEYOND.items():
                other = of_row[of_row["reading"] == reading]
                ax.errorbar(x, other["d"], _error(other), color=colour, marker="o", markersize=3)
        ax.axhline(0, color="black", linewidth=0.5)
        ax.axvline(1.25, color="black", linewidth=0.3)
        ax.set_title(surface)
        ax.set_xticks([0.5, 0.8, 1.1, *BEYOND.values()], ["0.5", "0.8", "1.1", "scaled", "full"])
    for ax in panels[-(-len(surfaces) // 2) :]:
        ax.set_xlabel("link (Å)")
    panels[0].set_ylabel("d")
    figure.legend(handles=panels[0].get_legend_handles_labels()[0], loc="outside upper left", ncols=N_SHOWN)
    return layout.fix_layout(figure)


def _error(rows: pd.DataFrame) -> np.ndarray:
    """Return the lengths of the error bars."""
    return np.array([rows["d"] - rows["d_low"], rows["d_high"] - rows["d"]])


def measure_links(job: Job) -> None:
    """Measure d of the published combinations on one surface by linking distance and reading."""
    fragments.table_over_links(job, links_table).to_csv(job.output.links, index=False)


def tabulate_links(job: Job) -> None:
    """Tabulate and draw d of the published combinations by linking distance and reading, over several surfaces."""
    table = read_tables(job.input.links)
    write_tables({job.output.table: table, job.output.readings: readings_table(table)})
    layout.save(draw(table), job.output.figure)
