"""How many dots are enough: error Z against the share of dots kept, of subsets, recovered surfaces and noise floors."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from sparsurf.evaluation.floors import FRESH
from sparsurf.patches.readings import FULL_READING, KEPT_READING
from sparsurf.recovery.readings import READINGS, RECOVERED
from sparsurf.sampling.samplers import sampler_label
from sparsurf.views import layout
from sparsurf.views.layout import styled
from sparsurf.views.numbers import share
from sparsurf_study.analysis.tables import read_table
from sparsurf_study.report.numbers import better_than_uniform, enough_dots, short_names

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from sparsurf_study.report.figures.results import Results

# Of the others their keys
FLOORS = {FRESH: "fresh dots of\nthe same surface", "turned": "the molecule rotated"}
# Kinds of noise floors drawn beside the one that defines what is enough, each at one end; floors.csv has all
SHOWN = {"frames": "idxmin", "atoms": "idxmax"}
MEAN_PATCH = "Z_mean_descriptor"  # of best.json
CLOUD, UNIFORM, AS_THEY_ARE, BACK, GREY = "#D55E00", "#000000", "#56B4E9", "#0072B2", "#777777"
TICKS = (1, 2, 5, 10, 20, 50, 100)  # % of the dots
MULTIPLES = 6  # surfaces with a panel each; more share one panel
ALONG = np.geomspace(1.1, 88, 24)  # % of the dots, where curves of many surfaces are compared
BAND = 0.1, 0.9  # quantiles over surfaces
MAX_COMBINATIONS = 4000  # that are drawn of all surfaces
DASHES = {"frames": (4, 3), "atoms": (1, 2)}  # of the noise floors by kind
DASHES_OF_MAIN = (6, 2, 1, 2)
MINIMAL_STYLE: dict[str, Any] = {"color": BACK, "linewidth": 0.8, "dashes": (2, 2)}
MEAN_PATCH_STYLE: dict[str, Any] = {"color": "#CC79A7", "linewidth": 0.8, "dashes": (9, 2)}


class Tables(NamedTuple):
    """Tables of one surface."""

    name: str  # of the surface
    curves: pd.DataFrame
    floors: pd.DataFrame
    required_dots: pd.DataFrame
    grid: pd.DataFrame | None = None  # if it exists
    mean_patch: float = np.nan  # Z of the mean patch in place of every patch, if known
    minimal: float = np.nan  # % of the dots, of the minimal subset


class Coded(NamedTuple):
    """All combinations under `kept`: n_S in %, Z of the sampling and of the uniform subset, the mean patch, and the head."""

    n: np.ndarray
    sampled: np.ndarray
    uniform: np.ndarray
    mean_patch: float
    head: str


class Panel(NamedTuple):
    """Content of one panel; n is n_S in % of the dots."""

    cloud: tuple[np.ndarray, np.ndarray]  # (n, Z) of all combinations; empty without a grid
    lines: dict[tuple[str, str], tuple[np.ndarray, ...]]  # (sampler, reading): (n, Z), or (n, Z, low, high)
    floors: dict[str, float]  # Z by name
    answer: tuple[float, float]  # (n, Z), the fewest dots that are enough
    bound: str = ""  # "at most" if the fewest measured are enough, "more" if only all dots are
    interval: tuple[float, float] = (np.nan, np.nan)  # 95 %, of the answer's n; NaN where it has none
    minimal: float = np.nan  # % of the dots, of the minimal subset


def read(folder: Path, sampled: bool = True) -> Tables:
    """Read the tables of a surface from its folder, `<protein>/<conformation>`; with its grid if it was `sampled`."""
    curves, floors, required_dots = (read_table(folder / f"{name}.csv") for name in Tables._fields[1:4])
    grid = read_table(folder / "grid.csv") if sampled else None
    minimal = read_table(folder / "recovered.csv")["n_S_percent"].iloc[0]
    return Tables(f"{folder.parent.name}/{folder.name}", curves, floors, required_dots, grid, minimal=minimal)


def draw(results: Results) -> Figure:
    """Draw the figure of one surface."""
    mean_patch = results.best.get("references", {}).get(MEAN_PATCH, np.nan)
    tables = (results.name, results.curves, results.floors, results.required_dots, results.grid)
    minimal = results.recovered_errors["n_S_percent"].iloc[0]
    return figure([Tables(*tables, mean_patch, minimal)], results.floor)


@styled
def figure(surfaces: Sequence[Tables], floor: str = FRESH, reading: str = FULL_READING) -> Figure:
    """Draw Z against n_S: of one surface, of a few side by side, of many the median with a band; `floor` sets what is enough."""
    panels = {tables.name: panel_of(tables, floor, reading) for tables in surfaces}
    if len(panels) > 1:
        shown = short_names(name.split("/") for name in panels)
        panels = {shown[name]: panel for name, panel in panels.items()}
    if len(panels) > MULTIPLES:
        panels = {f"{len(panels)} surfaces: median, and a band around 80 % of them": median_panel(panels)}
    single = len(panels) == 1
    coded = _coded_cloud(surfaces) if single and reading == FULL_READING else None
    most = 2 if len(panels) == 4 else 3
    columns, rows = 1 + (coded is not None) if single else min(most, len(panels)), -(-len(panels) // most)
    width, height = (134 if coded is None else layout.PAGE, 84) if single else (layout.PAGE, 24 + 56 * rows)
    drawing = layout.constrained(width, height, next(iter(panels)) if single else "")
    for k, (name, panel) in enumerate(panels.items()):
        ax = drawing.add_subplot(rows, columns, k + 1)
        _draw(ax, panel, floor, _floors_of(panels, floor))
        title = enough_dots(panel.answer[0], *panel.interval, panel.bound)
        ax.set_title(title if single else f"{name}\n{title}")
        if single:
            ax.title.set(color=BACK, fontweight="bold", fontsize=8)
        ax.set_ylabel(ax.get_ylabel() if k % columns == 0 else "")
        ax.tick_params(labelleft=k % columns == 0)
    top = max(ax.get_ylim()[1] for ax in drawing.axes)
    for ax in drawing.axes:
        ax.set_ylim(0, top)
    if coded is not None and surfaces[0].grid is not None:
        first = drawing.axes[0]
        first.set_ylabel("error Z of the descriptors, on the full surface")
        words = f"on the full surface:\n{_count(surfaces[0].grid, reading)}"
        style: dict[str, Any] = {"ha": "right", "va": "top", "color": CLOUD, "path_effects": layout.HALO}
        first.text(0.98, 0.98, words, transform=first.transAxes, **style)
        ax = drawing.add_subplot(rows, columns, 2)
        _draw_coded(ax, coded, next(iter(panels.values())), floor)
        if np.isfinite(coded.mean_patch):
            for panel_ax in drawing.axes:
                panel_ax.axhline(coded.mean_patch, zorder=0, **MEAN_PATCH_STYLE)
        ticks = first.get_xticks()
        ax.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        ax.set_xlim(first.get_xlim())
    handles = _legend_handles(panels, floor, READINGS[reading].words, coded)
    if single:
        drawing.legend(handles=handles, loc="outside right upper", labelspacing=0.9, handlelength=2.2)
    else:
        drawing.legend(handles=handles, loc="outside lower left", ncols=4, handlelength=2.2)
    return layout.fix_layout(drawing)


def panel_of(tables: Tables, floor: str = FRESH, reading: str = FULL_READING) -> Panel:
    """Collect the panel of one surface."""
    grid, curves, required_dots = tables.grid, tables.curves, tables.required_dots
    lines: dict[Any, tuple[np.ndarray, ...]] = {
        key: (rows["n_S_percent"].to_numpy(), rows["Z"].to_numpy())
        for key, rows in curves.groupby(["sampler", "reading"], sort=False)
    }
    of_floor = required_dots[required_dots["floor"] == floor]
    answer = of_floor[of_floor["reading"] == RECOVERED].iloc[0]
    floors: dict[Any, float] = tables.floors.set_index("floor")["Z"].to_dict()
    cloud = (np.empty(0), np.empty(0))
    if grid is not None and f"Z_tS_{reading}" in grid:
        cloud = grid["n_S_percent"].to_numpy(), grid[f"Z_tS_{reading}"].to_numpy()
    ends = (answer.get("n_S_percent_low", np.nan), answer.get("n_S_percent_high", np.nan))
    return Panel(
        cloud, lines, floors, (answer["n_S_percent"], answer["Z"]), answer["bound"], ends, tables.minimal
    )


def _coded_cloud(surfaces: Sequence[Tables]) -> Coded | None:
    """Collect all combinations under `kept`; None unless one surface has them under both readings."""
    grid = surfaces[0].grid
    columns = {f"Z_tS_{reading}" for reading in (KEPT_READING, FULL_READING)}
    if len(surfaces) > 1 or grid is None or not columns <= set(grid):
        return None
    sampled, uniform = (grid[f"{name}_{KEPT_READING}"].to_numpy() for name in ("Z_tS", "Z_tR"))
    n, mean_patch = grid["n_S_percent"].to_numpy(), surfaces[0].mean_patch
    head = f"among the kept dots (another scale)\n{_count(grid, KEPT_READING)}"
    better = n[np.minimum(sampled, uniform) < mean_patch]
    if np.isfinite(mean_patch) and not len(better):
        head += "\nall are worse than the mean patch"
    elif len(better) and better.min() > n.min():
        head += f"\nworse than the mean patch below {share(better.min())} %"
    return Coded(n, sampled, uniform, mean_patch, head)


def _count(grid: pd.DataFrame, reading: str) -> str:
    """Count the combinations that are better than a uniform subset under a reading."""
    better, total = better_than_uniform(grid, reading)
    return f"{better:,} of {total:,} beat uniform dots"


def _draw_coded(ax: Axes, coded: Coded, panel: Panel, floor: str) -> None:
    """Draw all combinations under `kept` and their uniform subsets, on their own scale: there a Z is several times larger."""
    ax.scatter(coded.n, coded.uniform, s=2.5, color=UNIFORM, alpha=0.35, linewidths=0)
    _draw(ax, Panel((coded.n, coded.sampled), {}, panel.floors, (np.nan, np.nan)), floor, [floor])
    ax.set_title(coded.head)
    ax.set_ylim(0, 1.04 * np.nanmax([coded.sampled, coded.uniform]))
    ax.set_ylabel("error Z of the descriptors, among the kept dots")


def median_panel(by_name: dict[str, Panel]) -> Panel:
    """Combine many panels: medians of curves, floors and answers, and a band that holds 80 % of the surfaces."""
    panels, lines = list(by_name.values()), {}
    for key in dict.fromkeys(key for panel in panels for key in panel.lines):
        curves = [panel.lines[key] for panel in panels if key in panel.lines]
        z = np.array([np.interp(np.log(ALONG), np.log(n), z, np.nan, np.nan) for n, z in curves])
        known = np.isfinite(z).mean(axis=0) >= 0.5
        lines[key] = ALONG[known], *np.nanquantile(z[:, known], [0.5, *BAND], axis=0)
    table = pd.DataFrame([panel.floors for panel in panels])
    floors: dict[Any, float] = table.loc[:, table.notna().mean() >= 0.5].median().to_dict()
    n, z = (np.concatenate([panel.cloud[k] for panel in panels]) for k in (0, 1))
    step = 1 + len(n) // MAX_COMBINATIONS
    n_answer, z_answer = np.median([panel.answer for panel in panels], axis=0)
    bound, *others = {panel.bound for panel in panels}
    minimal = float(np.median([panel.minimal for panel in panels]))
    bound = "" if others else bound
    return Panel((n[::step], z[::step]), lines, floors, (n_answer, z_answer), bound, minimal=minimal)


def _look(sampler: str, reading: str) -> tuple[dict[str, Any], str]:
    """Return the style and the name of a curve."""
    style = {"linewidth": 1.5, "markersize": 2.5}
    if reading == RECOVERED:
        return style | {"color": BACK, "marker": "o"}, "the surface recovered\nfrom the same dots"
    if sampler == "uniform":
        return style | {"color": UNIFORM}, "uniform subset"
    return style | {"color": AS_THEY_ARE}, f"{sampler_label(sampler).split(' (')[0]} dots\nas they are"


def _draw(ax: Axes, panel: Panel, floor: str, floors: list[str]) -> None:
    """Draw cloud, curves, floors and the answer."""
    n, z = panel.cloud
    ax.scatter(n, z, s=2.5, color=CLOUD, alpha=0.35, linewidths=0)
    lowest, highest = min(n, default=np.inf), np.nanmax([0, *z])
    for key, (x, y, *band) in panel.lines.items():
        style = _look(*key)[0]
        if band:
            ax.fill_between(x, band[0], band[1], color=style["color"], alpha=0.15, linewidth=0)
        ax.plot(x, y, **style)
        lowest, highest = min(lowest, x.min()), max(highest, np.nanmax(y))
    for name in floors:
        if name in panel.floors:
            ax.axhline(panel.floors[name], zorder=0, **_floor_style(name, floor))
    if np.isfinite(panel.minimal):
        ax.axvline(panel.minimal, zorder=0, **MINIMAL_STYLE)
    n_answer, z_answer = panel.answer
    if np.isfinite(panel.interval[0]):
        ax.hlines(z_answer, *panel.interval, color=BACK, linewidth=3, alpha=0.4)
    ax.plot(n_answer, z_answer, "o", color="white", markeredgecolor=BACK, markeredgewidth=1, markersize=5)
    ax.set(xscale="log", xlim=(0.9 * lowest, 103), ylim=(0, 1.08 * highest))
    ax.xaxis.set_minor_locator(NullLocator())
    shown = [tick for tick in TICKS if tick >= 0.9 * lowest]
    ax.set_xticks(shown, [f"{tick}" for tick in shown])
    ax.set(xlabel="dots kept (% of the surface)", ylabel="error Z of the descriptors (0: none)")


def _legend_handles(
    panels: dict[str, Panel], floor: str, reading: str, coded: Coded | None = None
) -> list[Line2D]:
    """Return the entries of the legend: all combinations, every curve, every noise floor with its Z if there is one panel."""
    handles = []
    if any(len(panel.cloud[0]) for panel in panels.values()):
        words = "paper's sampling,\nall combinations" + (f",\n{reading}" if coded is None else "")
        handles.append(Line2D([], [], color=CLOUD, marker="o", markersize=3, linestyle="", label=words))
    for key in dict.fromkeys(key for panel in panels.values() for key in panel.lines):
        style, words = _look(*key)
        handles.append(Line2D([], [], label=words, **style))
    bar = any(np.isfinite(panel.interval[0]) for panel in panels.values())
    words = "near the floor, bar: 95 % interval" if bar else "near the floor"
    ring: dict[str, Any] = {"color": BACK, "marker": "o", "mfc": "white", "markersize": 5, "linestyle": ""}
    handles.append(Line2D([], [], label=words, **ring))
    if any(np.isfinite(panel.minimal) for panel in panels.values()):
        handles.append(Line2D([], [], label="the minimal subset", **MINIMAL_STYLE))
    for name in _floors_of(panels, floor):
        z = next(iter(panels.values())).floors.get(name, np.nan)
        words = FLOORS.get(name, name) + (f": {z:.2f}" if len(panels) == 1 else "")
        handles.append(Line2D([], [], **_floor_style(name, floor), label=words))
    if coded is not None and np.isfinite(coded.mean_patch):
        words = f"the mean patch in place\nof every patch: {coded.mean_patch:.2f}"
        handles.append(Line2D([], [], **MEAN_PATCH_STYLE, label=words))
    return handles


def _floors_of(panels: dict[str, Panel], floor: str) -> list[str]:
    """Name the floors that are drawn, the highest first: `floor`, frames as close and atoms moved as far as was measured."""
    z = pd.DataFrame([panel.floors for panel in panels.values()]).mean()
    by_kind = {kind: z[z.index.str.startswith(f"{kind} ")] for kind in SHOWN}
    ends = [str(by_kind[kind].agg(end)) for kind, end in SHOWN.items() if len(by_kind[kind])]
    return sorted({*ends, floor}, key=lambda name: -z.get(name, 0.0))


def _floor_style(name: str, floor: str) -> dict[str, Any]:
    """Return the line style of a noise floor; the one that defines what is enough is bold."""
    if name == floor:
        return {"color": "black", "linewidth": 0.8, "dashes": DASHES_OF_MAIN}
    return {"color": GREY, "linewidth": 0.6, "dashes": DASHES[name.split()[0]]}
