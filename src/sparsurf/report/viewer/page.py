"""The page of one surface: dots to turn and to pick, the paper's sampling live, d and Z of the grid beside it."""

from dataclasses import dataclass
from html import escape
from pathlib import Path

import numpy as np
import pandas as pd

from sparsurf.recovery.readings import READINGS, readings_of_columns
from sparsurf.report.viewer.packing import OCTAHEDRON, flat_normals, in_steps, pack
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.sampling.samplers import farthest, lookup_sampler
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.formats.ply import GREY, KIND_COLOURS, viridis
from sparsurf.surfaces.spacing import spacing

MOST_DOTS = 100_000
MOST_BYTES = 1_500_000  # of the page: browsers show none in the frame of a report beyond 1.57 MB
STEP = 0.001  # Å, the decimals of a DMS file
CENTRE_STEPS = 1e7  # of the R_i of a centre, which decides about p
SCRIPTS = ["unpack.js", "law.js", "scene.js", "page.js"]
KINDS = ["contact", "saddle", "concave", "unknown kind"]
STOPS = 16  # of the colours, viridis: evenly bright, so that they read as light and dark as well
SAMPLERS = ("farthest", "uniform", "roughness", "stride", "paper")  # that law.js draws


@dataclass(frozen=True)
class Values:
    """One number of every dot, to be shown as a colour.

    name, symbol, unit : str
    values : (N,) float64, NaN where unknown
    low_is, high_is : str, what the ends mean
    """

    name: str
    symbol: str
    unit: str
    values: np.ndarray
    low_is: str = ""
    high_is: str = ""


def page(
    title,
    surface,
    rough,
    cover,
    radius,
    orders,
    grid=None,
    best=None,
    residues=(),
    values=(),
    minimal=(),
    opens=None,
):
    """The page, complete in itself.

    Parameters
    ----------
    title : str
    surface : surfaces.surface.Surface
    rough : (N,) float64, R_i
    cover : sampling.law.Cover
    radius : float, R_patch in Å
    orders : dict of name to (n,) int
        Dots in the order in which nested samplers choose them; a surface too large for a page is shown by the
        first dots of the first of them.
    grid : DataFrame, optional
        See `study.tables.grid_table`; without it the page tells no d and Z.
    best : dict, optional
        See `study.tables.best`.
    residues : sequence of str
        Name of the residue of each atom of the structure; empty where it is not known.
    values : sequence of Values
        More to colour by.
    minimal : sequence of int
        Dots of the subset that is handed out.
    opens : (str, int), optional
        The sampler that is shown first, and in which colour: 0 for R_i, then those of `values`.

    Returns
    -------
    str, HTML of at most MOST_BYTES
    """
    grid, best = pd.DataFrame(columns=[*PARAMETERS, "n_S_percent"]) if grid is None else grid, best or {}
    values = [Values("roughness R_i", "R_i", "", rough, "rough", "flat"), *values]
    parts = {
        "%TITLE%": escape(title),
        "%ANSWER%": f"{len(surface):,} dots, mean roughness {rough.mean():.2f}.",
        "%STYLE%": _read("page.css"),
        "%SCRIPT%": "".join(_read(name) for name in SCRIPTS),
    }
    most = MOST_DOTS
    while True:
        dots = np.sort(next(iter(orders.values()))[:most])
        whole = {name: order for name, order in orders.items() if np.isin(dots, order).all()}
        header = _header(surface, dots, radius, whole, grid, best, values, minimal)
        header["sampler"], header["colour"] = opens or (next(iter(header["samplers"])), 0)
        columns = dot_columns(surface, dots, whole, residues, values, header)
        if len(minimal):
            columns["minimal"] = np.isin(dots, minimal).astype(int)
        text = _read("page.html")
        for mark, part in (
            parts | {"%DATA%": pack(header, columns | cover_columns(surface, dots, cover))}
        ).items():
            text = text.replace(mark, part)
        if len(text.encode()) <= MOST_BYTES:
            return text
        most = int(0.95 * len(dots) * MOST_BYTES / len(text))


def coloured_page(title, name, surface, settings, values, residues=()):
    """The page of a surface without a grid, which opens with all dots in the colours of the first of some values.

    Parameters
    ----------
    title : str
    name : str, of the surface, which its order of dots follows from
    surface, values, residues : as for `page`
    settings : dict, see `Evaluator.from_settings`
    """
    evaluator = PreparedSurface.from_settings(surface, settings, None, name, 1)
    order = farthest(evaluator, min(len(surface), MOST_DOTS), evaluator.stream("view"))
    return page(
        title, surface, evaluator.roughness, evaluator.cover, evaluator.r_patch, {"farthest": order},
        residues=residues, values=values, opens=("all", 1),
    )  # fmt: skip


def _read(name):
    return Path(__file__).with_name(name).read_text(encoding="utf-8")


def _header(surface, dots, radius, orders, grid, best, values, minimal):
    """What the page needs beside the dots."""
    readings = readings_of_columns(grid, "d_")
    columns = [*PARAMETERS, "n_S_percent"]
    columns += [f"{name}_{reading}" for reading in readings for name in ("Z_tS", "Z_tR", "d")]
    samplers = {"minimal": "the subset minimal.csv"} if len(minimal) else {}
    samplers |= {name: lookup_sampler(name).words for name in (*orders, *SAMPLERS)}
    return {
        "total": len(surface),
        "stored": len(dots),
        "minimal": len(minimal),
        "step": STEP,
        "radius": radius,
        "octahedron": OCTAHEDRON,
        "spacing": spacing(surface.points[dots]) if len(dots) > 1 else 1.0,
        "samplers": samplers | {"all": "all dots"},
        "readings": [READINGS[reading].words for reading in readings],
        "grid": [[_number(value) for value in row] for row in grid[columns].to_numpy(float)],
        "presets": _presets(best),
        "values": [_scale(each) for each in values],
        "kinds": [[name, rgb.tolist()] for name, rgb in zip(KINDS, [*KIND_COLOURS[:3], GREY], strict=True)],
        "stops": viridis(np.linspace(0, 1, STOPS)).tolist(),
    }


def _number(value):
    return float(f"{value:.5g}") if np.isfinite(value) else None


def _presets(best):
    """Combinations worth a look, with their names."""
    out = [("the paper's best", [1.0, 0.0, 6.0, 0.0])]
    for reading in readings_of_columns(best):
        names = {"unrestricted": "best", "under_max_n_S": f"best below {best['max_n_S_percent']:g} %"}
        for key, name in names.items():
            if "d" in best[reading][key]:
                out.append((f"{name}, {READINGS[reading].words}", list(Combination.from_row(best[reading][key]))))
    return out


def _scale(each):
    """Name and ends of some values."""
    known = each.values[np.isfinite(each.values)]
    low, high = (float(known.min()), float(known.max())) if len(known) else (0.0, 1.0)
    return {
        "name": each.name,
        "symbol": each.symbol,
        "unit": each.unit,
        "low": low,
        "high": high,
        "low is": each.low_is,
        "high is": each.high_is,
    }


def dot_columns(surface, dots, orders, residues, values, header):
    """Columns of the shown dots; those of kind and residue only where these are known."""
    points = np.round(surface.points[dots] / STEP).astype(int)
    columns = dict(zip("xyz", points.T, strict=True)) | {"index": dots}
    columns |= dict(zip("uv", flat_normals(surface.normals[dots]).T, strict=True))
    if (surface.kind >= 0).any():
        columns["kind"] = surface.kind[dots]
    if len(residues) and (surface.atom >= 0).any():
        names, number = np.unique(residues, return_inverse=True)
        atom = surface.atom[dots]
        columns["residue"] = np.where(atom >= 0, number[atom], -1)
        header["residues"] = names.tolist()
    for k, (each, scale) in enumerate(zip(values, header["values"], strict=True)):
        columns[f"value {k}"] = in_steps(each.values[dots], scale["low"], scale["high"])
    place = _places(dots, len(surface))
    for name, order in orders.items():
        rank = np.empty(len(dots), int)
        chosen = place[order][place[order] >= 0]
        rank[chosen] = np.arange(len(chosen))
        columns[f"rank {name}"] = rank
    return columns


def cover_columns(surface, dots, cover):
    """Columns of the cover: of each centre its place among the shown dots (-1 for none), R_i, where r_ij is measured
    from and how many pairs it has; of each pair its dot, in ascending order within a patch."""
    place = _places(dots, len(surface))
    owner = np.repeat(np.arange(len(cover.centre)), np.diff(cover.start))
    shown = place[cover.dot] >= 0
    owner, dot = owner[shown], place[cover.dot[shown]]
    origin = np.round(surface.points[cover.origin] / STEP).astype(int)
    return dict(zip(("ox", "oy", "oz"), origin.T, strict=True)) | {
        "centre": place[cover.centre],
        "centreR": np.round(cover.roughness * CENTRE_STEPS).astype(int),
        "size": np.bincount(owner, minlength=len(cover.centre)),
        "pair": dot[np.lexsort((dot, owner))],
    }


def _places(dots, n):
    """Place of each of n dots among the shown ones, -1 for those that are not."""
    place = np.full(n, -1)
    place[dots] = np.arange(len(dots))
    return place
