"""How many dots are enough: error Z against the share of dots kept, with everything in it that was measured."""

from typing import NamedTuple

import numpy as np
import pandas as pd
from matplotlib.lines import Line2D
from matplotlib.ticker import NullLocator

from sparsurf.patches.readings import WRITTEN_READING
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.figures import layout
from sparsurf.report.figures.layout import styled
from sparsurf.report.numbers import share
from sparsurf.sampling.samplers import lookup_sampler
from sparsurf.study.required_dots import AT_MOST, MORE
from sparsurf.study.tables import read_table

FRESH = "fresh dots"
FLOORS = {
    FRESH: "fresh dots of\nthe same surface",
    "turned": "the molecule turned",
}  # others by their own names
CLOUD, UNIFORM, AS_THEY_ARE, BACK, GREY = "#D55E00", "#000000", "#56B4E9", "#0072B2", "#777777"
INK = {AS_THEY_ARE: "#2F86BD"}  # of words, where the colour of the line is too pale to read
TICKS = (1, 2, 5, 10, 20, 50, 100)  # % of the dots
ABOVE = [1, 1], [0, 1], [1, 0]
SIDES = {
    UNIFORM: ABOVE,
    AS_THEY_ARE: ([-1, -1], [0, -1], [-1, 0]),
    BACK: ([1, -1], [0, -1], [-1, -1], *ABOVE),
}  # for names
APART = 40.0  # pixels between names
CLEAR = 60.0  # pixels from a named point of a line to other lines
MULTIPLES = 6  # surfaces that get a panel each; more share one
ALONG = np.geomspace(1.1, 88, 24)  # % of the dots, where curves of many surfaces are compared
BAND = 0.1, 0.9  # quantiles over surfaces
MOST_SHOWN = 4000  # combinations of all surfaces


class Tables(NamedTuple):
    """What is known of one surface: its name, curves.csv, floors.csv, enough.csv, and grid.csv where there is one."""

    name: str
    curves: pd.DataFrame
    floors: pd.DataFrame
    enough: pd.DataFrame
    grid: pd.DataFrame | None = None


class Panel(NamedTuple):
    """What one panel shows; n is n_S in % of the dots.

    cloud : (n, Z) of all combinations; empty without a grid
    lines : dict of (sampler, reading) to (n, Z), or to (n, Z, low, high)
    floors : dict of name to Z
    answer : (n, Z), the fewest dots that are enough
    bound : "at most" where the fewest that were measured are enough, "more" where none but all dots are
    """

    cloud: tuple
    lines: dict
    floors: dict
    answer: tuple
    bound: str = ""


def read(folder, sampled=True):
    """Tables of the surface whose results are in a folder, `<protein>/<conformation>`; with its grid where it was `sampled`."""
    tables = (read_table(folder / f"{name}.csv") for name in Tables._fields[1 : 4 + sampled])
    return Tables(f"{folder.parent.name}/{folder.name}", *tables)


def draw(results):
    """The figure of one surface."""
    tables = Tables(results.name, results.curves, results.floors, results.enough, results.grid)
    return figure([tables], results.floor)


@styled
def figure(surfaces, floor=FRESH, reading=WRITTEN_READING):
    """Z against n_S: of one surface, of a few side by side, of many the median and where most of them lie.

    Parameters
    ----------
    surfaces : sequence of Tables
    floor : str, the row of floors.csv that says what is enough
    reading : str, under which all combinations are shown, where they were evaluated so

    Returns
    -------
    matplotlib.figure.Figure
    """
    panels = {each.name: panel_of(each, floor, reading) for each in surfaces}
    if 1 < len(panels) <= MULTIPLES:
        return _multiples(panels, floor)
    name, panel = (
        next(iter(panels.items()))
        if len(panels) == 1
        else (
            f"{len(panels)} surfaces: median, and a band around 80 % of them",
            over(panels),
        )
    )
    sheet = layout.sheet(134, 78, name)
    ax = layout.axes(sheet, 12, 1, 88, 66)
    _draw(ax, panel, floor)
    _name_floors(ax, panel.floors, floor)
    _name_all(ax, panel, f"{len(panel.cloud[0]):,} combinations" if len(panels) == 1 else "all combinations")
    return sheet


def panel_of(tables, floor=FRESH, reading=WRITTEN_READING):
    """The panel of one surface."""
    grid, curves, enough = tables.grid, tables.curves, tables.enough
    lines = {
        key: (rows["n_S_percent"].to_numpy(), rows["Z"].to_numpy())
        for key, rows in curves.groupby(["sampler", "reading"], sort=False)
    }
    own = enough[(enough["floor"] == floor) & (enough["reading"] == RECOVERED)].iloc[0]
    floors = tables.floors.set_index("floor")["Z"].to_dict()
    cloud = (np.empty(0), np.empty(0))
    if grid is not None and f"Z_tS_{reading}" in grid:
        cloud = grid["n_S_percent"].to_numpy(), grid[f"Z_tS_{reading}"].to_numpy()
    return Panel(cloud, lines, floors, (own["n_S_percent"], own["Z"]), own["bound"])


def over(panels):
    """One panel for many: medians of curves, floors and answers, a band that holds 80 % of the surfaces."""
    panels, lines = list(panels.values()), {}
    for key in dict.fromkeys(key for panel in panels for key in panel.lines):
        own = [panel.lines[key] for panel in panels if key in panel.lines]
        z = np.array([np.interp(np.log(ALONG), np.log(n), z, np.nan, np.nan) for n, z in own])
        known = np.isfinite(z).mean(axis=0) >= 0.5
        lines[key] = ALONG[known], *np.nanquantile(z[:, known], [0.5, *BAND], axis=0)
    table = pd.DataFrame([panel.floors for panel in panels])
    floors = table.loc[:, table.notna().mean() >= 0.5].median().to_dict()
    n, z = (np.concatenate([panel.cloud[k] for panel in panels]) for k in (0, 1))
    step = 1 + len(n) // MOST_SHOWN
    answer = tuple(np.median([panel.answer for panel in panels], axis=0))
    bounds = {panel.bound for panel in panels}
    return Panel((n[::step], z[::step]), lines, floors, answer, bounds.pop() if len(bounds) == 1 else "")


def _told(panel):
    """How many dots are enough, in words."""
    if panel.bound == MORE:
        return "all dots are needed"
    return f"{'≤ ' if panel.bound == AT_MOST else ''}{share(panel.answer[0])} % of the dots are enough"


def _look(sampler, reading):
    """Colour and words of a curve."""
    if reading == RECOVERED:
        return BACK, "the surface recovered\nfrom the same dots"
    if sampler == "uniform":
        return UNIFORM, "uniform subset"
    return AS_THEY_ARE, f"{lookup_sampler(sampler).words.split(' (')[0]} dots\nas they are"


def _draw(ax, panel, floor):
    """Cloud, curves, floors and the answer, without words."""
    n, z = panel.cloud
    ax.scatter(n, z, s=2.5, color=CLOUD, alpha=0.35, linewidths=0, rasterized=True)
    lowest, highest = min(n, default=np.inf), np.nanmax([0, *z])
    for key, (x, y, *band) in panel.lines.items():
        colour = _look(*key)[0]
        if band:
            ax.fill_between(x, *band, color=colour, alpha=0.15, linewidth=0)
        ax.plot(x, y, color=colour, linewidth=1.5, marker="o" if colour == BACK else "", markersize=2.5)
        lowest, highest = min(lowest, x.min()), max(highest, np.nanmax(y))
    for name, value in panel.floors.items():
        dark = name == floor
        ax.axhline(
            value,
            color=GREY,
            linewidth=0.8 if dark else 0.5,
            alpha=1 if dark else 0.6,
            dashes=(4, 3),
            zorder=0,
        )
    ax.set(xscale="log", xlim=(0.9 * lowest, 103), ylim=(0, 1.08 * highest))
    ax.xaxis.set_minor_locator(NullLocator())
    shown = [tick for tick in TICKS if tick >= 0.9 * lowest]
    ax.set_xticks(shown, [f"{tick}" for tick in shown])
    ax.set(xlabel="dots kept (% of the surface)", ylabel="error Z of the descriptors (0: none)")


def _name_floors(ax, floors, floor):
    """Names of the floors at their right ends, moved apart where they would touch."""
    names = sorted(floors, key=floors.get)
    words = [FLOORS.get(name, name) for name in names]
    height, tall = ax.get_ylim()[1], ax.get_window_extent().height / layout.DPI / layout.MM
    room = np.array([3.2 * (1 + text.count("\n")) for text in words]) * height / tall
    for name, text, place in zip(
        names, words, layout.apart([floors[n] for n in names], room, height), strict=True
    ):
        ax.annotate(
            text, (1, floors[name]), (1.035, place / height), ax.get_yaxis_transform(), "axes fraction", va="center",
            color="black" if name == floor else GREY, annotation_clip=False,
            arrowprops={"arrowstyle": "-", "linewidth": 0.4, "color": GREY, "shrinkA": 0, "shrinkB": 0},
        )  # fmt: skip


def _name_all(ax, panel, combinations):
    """The answer, then each curve and the cloud by name, where the fewest dots and lines are in the way."""
    to_pixels = ax.transData.transform
    every = {
        key: to_pixels(np.column_stack([_dense(x, np.log), _dense(y)]))
        for key, (x, y, *_) in panel.lines.items()
    }
    cloud = to_pixels(np.column_stack(panel.cloud))
    busy, taken = np.concatenate([cloud, *every.values()]), []  # a floor may be crossed
    answer = _told(panel)
    at = to_pixels(panel.answer)
    below = [at + np.array([x, y]) for y in (-90, -130, -180) for x in (-60, 0, 60, -200, 160)]
    place = _name(ax, answer, BACK, below, busy, taken, fontsize=8, fontweight="bold")
    arrow = {"arrowstyle": "-|>", "color": BACK, "linewidth": 1, "shrinkA": 8, "shrinkB": 4}
    ax.annotate("", panel.answer, ax.transData.inverted().transform(place), arrowprops=arrow)
    for key in sorted(every, key=lambda key: len(panel.lines[key][0])):  # a short curve has the fewest places
        line, (colour, words) = every[key], _look(*key)
        own = _alone(line[::8], [other for name, other in every.items() if name != key])
        middles = _beside(own, layout.size_of(ax.figure, words), SIDES[colour])
        _name(ax, words, colour, middles, busy, taken)
    if not len(cloud):
        return
    words = f"paper's sampling,\n{combinations}"
    upper = cloud[np.argsort(-cloud.sum(axis=1))][:: 1 + len(cloud) // 100]
    _name(ax, words, CLOUD, _beside(upper, layout.size_of(ax.figure, words), ABOVE), busy, taken)


def _dense(values, scale=lambda x: x):
    """Five hundred values from the first to the last, evenly between neighbours on an axis of this scale."""
    back = np.exp if scale is np.log else scale
    k = np.linspace(0, len(values) - 1, 500)
    return back(np.interp(k, np.arange(len(values)), scale(np.asarray(values, float))))


def _alone(line, others):
    """Points of a line that lie `CLEAR` from other lines, so that a name there is that of no other; all, where none does."""
    if not others:
        return line
    gaps = np.linalg.norm(line[:, None] - np.concatenate(others)[None, ::4], axis=2).min(axis=1)
    return line[gaps > CLEAR] if (gaps > CLEAR).any() else line


def _beside(line, size, sides):
    """Middles of boxes of a size on some sides of points."""
    return np.concatenate([line + (size / 2 + far) * side for far in (10, 30, 50) for side in sides])


def _name(ax, words, colour, middles, busy, taken, **style):
    """Write words at the best of some places, which is then taken; returns it."""
    size = layout.size_of(ax.figure, words, **style)
    place, _ = layout.free_place(ax, size, middles, busy, taken)
    place = ax.get_window_extent().max - size / 2 if place is None else place
    taken.append((place, size + APART))
    x, y = ax.transAxes.inverted().transform(place)
    ax.text(
        x,
        y,
        words,
        transform=ax.transAxes,
        color=INK.get(colour, colour),
        ha="center",
        va="center",
        path_effects=layout.HALO,
        **style,
    )
    return place


def _multiples(panels, floor):
    """A panel for each surface, in rows of three, with one key."""
    columns, rows = min(3, len(panels)), -(-len(panels) // 3)
    wide = (layout.PAGE - 12) / columns - 4
    sheet = layout.sheet(layout.PAGE, 14 + 58 * rows)
    top = max(
        np.nanmax(y)
        for panel in panels.values()
        for _, y, *_ in [panel.cloud, *panel.lines.values()]
        if len(y)
    )
    for k, (name, panel) in enumerate(panels.items()):
        ax = layout.axes(sheet, 12 + (wide + 4) * (k % columns), 6 + 58 * (k // columns), wide, 44)
        _draw(ax, panel, floor)
        ax.set(title=f"{name}: {_told(panel).replace(' of the dots', '')}", ylim=(0, 1.08 * top))
        ax.plot(*panel.answer, "o", color="white", markeredgecolor=BACK, markeredgewidth=1, markersize=5)
        ax.tick_params(labelleft=k % columns == 0)
        ax.set_ylabel(ax.get_ylabel() if k % columns == 0 else "")
    _key(sheet, panels, 4 + 58 * rows, floor)
    return sheet


def _key(sheet, panels, y, floor):
    """One legend for all panels."""
    keys = dict.fromkeys(key for panel in panels.values() for key in panel.lines)
    handles = [
        Line2D([], [], color=CLOUD, marker="o", linestyle="", label="paper's sampling,\nall combinations")
    ] * any(len(panel.cloud[0]) for panel in panels.values())
    handles += [
        Line2D([], [], color=colour, linewidth=1.5, label=words)
        for colour, words in (_look(*key) for key in keys)
    ]
    handles.append(Line2D([], [], color=GREY, dashes=(4, 3), label=f"noise floors\n(bold: {floor})"))
    layout.legend(sheet, 12, y, handles, ncols=len(handles), columnspacing=1.2, handlelength=1.5)
