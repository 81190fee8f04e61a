"""d of the published combinations over the link in spacings of the kept dots, and how much of a patch its island holds."""

from collections.abc import Sequence
from itertools import pairwise

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from sparsurf_study.workflow.jobs import Job
from measures import fragments
from measures.tables import read_tables, write_tables
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.combination import PUBLISHED_ROWS
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf_study.paper.replication import sweep_links
from sparsurf_study.report.numbers import FRAGMENTED_BELOW

# Filling factor at which discs placed at random in the plane percolate: Quintanilla and Ziff, Phys. Rev. E 76, 051115 (2007).
# Discs of radius r touch within 2 r, so that n pi r^2 per area becomes a distance in units of 1 / sqrt(n).
FILLING = 1.12808737
PERCOLATION = float(np.sqrt(4 * FILLING / np.pi))  # 1.198 spacings
PUBLISHED_LINK = 0.5  # Å
FIRST_ROWS = 8  # rows 9 and 10 of Table I have no gain at any link
HALF = 100 * FRAGMENTED_BELOW  # % of the kept dots of a patch
WHOLE = 90.0  # % from which a patch counts as nearly whole
ZERO = "link / spacing where d falls below 0"
BEND = 1.5  # link / spacing up to which the curve bends, also of rows with few dots
SHARES = np.linspace(0, 100, 11)  # %, limits of the groups of shares
OTHER_ROWS = "#DDDDDD"
SHOWN = 2.6  # link / spacing up to which curves are drawn: beyond, they are flat


def curve_table(prepared: PreparedSurface, links: Sequence[float], n_tests: int, draws: int) -> pd.DataFrame:
    """Measure d, Z and the share of a patch in its island under `kept`, for every row of Table I and link.

    Returns
    -------
    DataFrame: d_link (Å), row, n_S_percent, spacing (Å), ratio (link over spacing), d with its 95 % interval, Z_tS and Z_tR, and
    share_tS_percent and share_tR_percent, the medians over draws and test dots of the share of a patch's kept dots that its
    island holds
    """
    table = sweep_links(prepared, links, n_tests, draws).rename(columns={"link_over_spacing": "ratio"})
    return pd.DataFrame(
        {
            **table[["d_link", "row", "n_S_percent"]],
            "spacing": table["d_link"] / table["ratio"],
            "ratio": table["ratio"],
            "Z_tS": table["Z_tS"],
            "share_tS_percent": 100 * table["share_in_island"],
            "Z_tR": table["Z_tR"],
            "share_tR_percent": 100 * table["share_in_island_uniform"],
            **table[["d", "d_low", "d_high"]],
        }
    )


def crossing(x: np.ndarray, y: np.ndarray, level: float = 0.0) -> float:
    """Return the x at which y, over ascending x, last passes from one side of a level to the other; NaN if it never does."""
    side = np.asarray(y) > level
    at = np.flatnonzero(side[1:] != side[:-1])
    if not len(at):
        return float("nan")
    a = at[-1]
    return float(x[a] + (x[a + 1] - x[a]) * (level - y[a]) / (y[a + 1] - y[a]))


def residual(x: np.ndarray, y: np.ndarray, n_groups: int) -> float:
    """Return the standard deviation of y about its means in groups of neighbouring x, about equally many; equal x together."""
    order = np.argsort(x, kind="stable")
    group = np.empty(len(x), int)
    group[order] = np.arange(len(x)) * n_groups // len(x)
    _, same = np.unique(x, return_inverse=True)
    group = pd.Series(group).groupby(same).transform("min").to_numpy()
    rest = y - pd.Series(y).groupby(group).transform("mean").to_numpy()
    return float(np.sqrt((rest**2).sum() / (len(y) - len(np.unique(group)))))


def residual_in_rows(table: pd.DataFrame) -> float:
    """Return the standard deviation of d about a curve for each row of Table I, in groups of as many points as surfaces.

    It is NaN for a single surface, each of whose groups has one point.
    """
    if table["surface"].nunique() == 1:
        return np.nan
    squares, freedom = 0.0, 0
    for _, part in table.groupby("row"):
        n_groups = len(part) // part["surface"].nunique()
        of_row = residual(part["ratio"].to_numpy(), part["d"].to_numpy(), n_groups)
        squares, freedom = squares + of_row**2 * (len(part) - n_groups), freedom + len(part) - n_groups
    return float(np.sqrt(squares / freedom))


def numbers(table: pd.DataFrame) -> pd.DataFrame:
    """Return what the curve shows: DataFrame of quantity, rows (of Table I), n, value, sd, lowest and highest.

    n counts points (a surface, a row and a link) or crossings (a surface and a row); value is a mean unless the quantity says
    otherwise; lowest and highest are those of the points or crossings, sd is their standard deviation.
    """
    rows: list[dict] = []
    n_links, first = table["d_link"].nunique(), table[table["row"] <= FIRST_ROWS]
    bend = first[first["ratio"] < BEND]
    for of, part in (("1 to 8", first), (f"1 to 8, link / spacing below {BEND:g}", bend), ("1 to 10", table)):
        values = {
            "d, standard deviation": part["d"].std(),
            "d, residual over the link": residual(part["d_link"].to_numpy(), part["d"].to_numpy(), n_links),
            "d, residual over link / spacing": residual(
                part["ratio"].to_numpy(), part["d"].to_numpy(), n_links
            ),
            "d, residual over link / spacing in each row": residual_in_rows(part),
        }
        rows += [
            {"quantity": key, "rows": of, "n": len(part), "value": value} for key, value in values.items()
        ]
    curves = [curve.sort_values("ratio") for _, curve in first.groupby(["surface", "row"], sort=False)]

    def crossings(column: str, level: float) -> list[float]:
        return [crossing(c["ratio"].to_numpy(), c[column].to_numpy(), level) for c in curves]

    found = {
        ZERO: crossings("d", 0.0),
        "link / spacing where an island holds half of a random patch": crossings("share_tR_percent", HALF),
        "link / spacing where an island holds half of a sampled patch": crossings("share_tS_percent", HALF),
        "largest d of a curve": [c["d"].max() for c in curves],
        "link / spacing of the largest d": [c["ratio"].iloc[int(c["d"].argmax())] for c in curves],
        "lowest d of a curve": [c["d"].min() for c in curves],
        "d at the longest link": [c["d"].iloc[-1] for c in curves],
    }
    for key, values_of_curves in found.items():
        known = pd.Series(values_of_curves, dtype=float).dropna()
        row = {"quantity": key, "rows": "1 to 8", "n": len(known), "value": known.mean(), "sd": known.std()}
        rows.append(row | {"lowest": known.min(), "highest": known.max()})
    of_row = pd.Series([curve["row"].iloc[0] for curve in curves])
    at_zero = pd.Series(found[ZERO]).groupby(of_row)
    for row, zeros in at_zero:
        known = {"quantity": ZERO, "rows": str(row), "n": int(zeros.count()), "value": zeros.mean()}
        rows.append(known | {"sd": zeros.std(), "lowest": zeros.min(), "highest": zeros.max()})
    of_rows = {f"{ZERO}, mean of a row": at_zero.mean(), f"{ZERO}, sd in a row": at_zero.std()}
    for key, values_of_rows in of_rows.items():
        row = {"quantity": key, "rows": "1 to 8", "n": len(values_of_rows), "value": values_of_rows.mean()}
        rows.append(row | {"lowest": values_of_rows.min(), "highest": values_of_rows.max()})
    return pd.DataFrame(rows)


def signs(table: pd.DataFrame) -> pd.DataFrame:
    """Count the signs of d by the share of a random patch that its island holds.

    Returns
    -------
    DataFrame: links ('published' or 'all'), share (of a random patch: 'below half', 'half to 90 %' or '90 % or more'), n
    (points: a surface, a row and a link), n_above and n_below, those whose 95 % interval of d lies above and below 0
    """
    rows = []
    published = table[np.isclose(table["d_link"], PUBLISHED_LINK)]
    for links, part in (("published", published), ("all", table)):
        share = part["share_tR_percent"]
        groups = {"below half": share < HALF, "half to 90 %": share.between(HALF, WHOLE, inclusive="left")}
        for name, inside in (groups | {"90 % or more": share >= WHOLE}).items():
            row = {"links": links, "share": name, "n": int(inside.sum())}
            row["n_above"] = int((part.loc[inside, "d_low"] > 0).sum())
            rows.append(row | {"n_below": int((part.loc[inside, "d_high"] < 0).sum())})
    return pd.DataFrame(rows)


def by_share(table: pd.DataFrame) -> pd.DataFrame:
    """Group Z by the share of a patch in its island.

    Returns
    -------
    DataFrame: share_low_percent and share_high_percent, subset, n (points), Z (mean), its sd, lowest and highest
    """
    rows = []
    for low, high in pairwise(SHARES):
        for name, words in (("tS", "sampled"), ("tR", "random")):
            share = table[f"share_{name}_percent"]
            inside = (share >= low) & ((share < high) | (high == SHARES[-1]))
            z = table.loc[inside, f"Z_{name}"]
            row = {
                "share_low_percent": low,
                "share_high_percent": high,
                "subset": words,
                "n": len(z),
                "Z": z.mean(),
            }
            rows.append(row | {"sd": z.std(), "lowest": z.min(), "highest": z.max()})
    return pd.DataFrame(rows)


@styled
def draw(table: pd.DataFrame, marked: str) -> Figure:
    """Draw d of all surfaces over link / spacing, a panel for each row of Table I, on the curves of the other rows.

    The published link is marked on the surface `marked`.
    """
    figure = layout.constrained(layout.PAGE_WIDTH, 90)
    panels = figure.subplots(2, len(PUBLISHED_ROWS) // 2, sharex=True, sharey=True)
    curves = [curve.sort_values("ratio") for _, curve in table.groupby(["surface", "row"], sort=False)]
    published = table[(table["surface"] == marked) & np.isclose(table["d_link"], PUBLISHED_LINK)]
    for row, ax in enumerate(panels.flat, 1):
        for curve in curves:
            is_own = curve["row"].iloc[0] == row
            style = {"color": layout.DARK, "zorder": 2} if is_own else {"color": OTHER_ROWS, "zorder": 1}
            ax.plot(curve["ratio"], curve["d"], linewidth=0.6, **style)
        at = published[published["row"] == row]
        ax.plot(
            at["ratio"], at["d"], "o", color=layout.SAMPLED, markeredgecolor="black", markersize=4, zorder=3
        )
        ax.axhline(0, color="black", linewidth=0.5, zorder=0)
        ax.axvline(PERCOLATION, color=layout.GREY, linewidth=0.8, linestyle="--", zorder=0)
        ax.set_title(f"row {row}")
        ax.set_xlim(0.25, SHOWN)
    figure.supxlabel("link / spacing of the kept dots", fontsize=7)
    figure.supylabel("d among the kept dots", fontsize=7)
    handles = [
        Line2D([], [], color=layout.DARK, linewidth=0.6, label="this row, each surface"),
        Line2D([], [], color=OTHER_ROWS, linewidth=0.6, label="the other rows"),
        Line2D([], [], color=layout.SAMPLED, marker="o", markeredgecolor="black", linestyle="",
               label=f"{marked} at the published link, {PUBLISHED_LINK:g} Å"),
        Line2D([], [], color=layout.GREY, linestyle="--", label=f"discs placed at random percolate: {PERCOLATION:.3f}"),
    ]  # fmt: skip
    figure.legend(handles=handles, loc="outside upper left", ncols=4)
    return layout.fix_layout(figure)


def measure_curve(job: Job) -> None:
    """Measure d of the published combinations and the share in islands on one surface, by the link in spacings."""
    fragments.table_over_links(job, curve_table).to_csv(job.output.curve, index=False)


def tabulate_curve(job: Job) -> None:
    """Tabulate and draw d over the link in spacings of the kept dots, over several surfaces."""
    table, out = read_tables(job.input.curves), job.output
    write_tables({out.table: table, out.numbers: numbers(table)})
    write_tables({out.shares: by_share(table), out.signs: signs(table)})
    layout.save(draw(table, job.params.marked), out.figure)
