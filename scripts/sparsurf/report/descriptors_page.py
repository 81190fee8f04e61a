"""docs/descriptors.md: the published descriptor and the steady one side by side, from the stored tables."""

import numpy as np
import pandas as pd

from sparsurf.patches.index import D_LINK
from sparsurf.report.figures.descriptors_figures import floor_of
from sparsurf.report.pages import markdown

TABLES = ("changes", "linked", "orders", "rows", "samplers", "grid")
LONGER = 0.6  # Å, the D_link that suits the steady descriptor
SIGNAL = 0.1  # an order carries signal where position and dots give less than this share of its variance


def descriptors_markdown(tables):
    """The page.

    Parameters
    ----------
    tables : dict, name of `TABLES` -> DataFrame as stored in docs/tables/descriptors_*.csv

    Returns
    -------
    str
    """
    parts = [
        "# Two descriptors: published and steady\n",
        _answer(tables),
        "`patches: {descriptor: steady}` in the config chooses it; `published` is the default and gives the authors' numbers.\n",
        "![How far position and dots move each descriptor](descriptors_steadiness.png)\n",
        "## How far a descriptor moves when the surface does not\n",
        "Mean distance Z of the descriptors of one patch before and after, and its ratio to the distance of two different "
        "patches. *Turned*: the same dots in five random positions. *Fresh dots*: those laid after a turn, turned back.\n",
        markdown(_changes(tables["changes"]), 3),
        _linked(tables["linked"]),
        "## Which orders carry signal\n",
        _orders(tables["orders"]),
        "## What changes in the paper's tables\n",
        "The ten combinations of Table I, Z_tS and d = Z_tR - Z_tS, means of three draws; ± one standard error over the test "
        "dots:\n",
        markdown(_rows(tables["rows"])),
        "All 1296 combinations, one draw: how many have d > 0, the best, and the correlation of d with that by the published "
        "descriptor under the same reading.\n",
        markdown(_grid(tables["grid"])),
        _single_dots(tables["rows"]),
        "## Samplers, and how many dots are enough\n",
        _enough_sentence(tables),
        "![Samplers under each descriptor](descriptors_samplers.png)\n",
        markdown(_samplers(tables)),
        "## What the steady descriptor does differently\n",
        WHY,
        "## Where the numbers come from\n",
        "`docs/tables/descriptors_*.csv`, written with this page by\n\n```\npython scripts/measure_descriptors.py docs "
        "A1=A1.pdb c1=results/default/tdp43/structures/c1.pdb\n```\n\nfrom our own analytic dots; A1 is the paper's first "
        "configuration, c1 that of the default study. What a descriptor costs: `make bench`.\n",
    ]
    return "\n".join(parts)


WHY = """\
| published | steady | reason |
| --- | --- | --- |
| disc around the mean of the dots, out to the outermost | the ball of R_zernike around the dot | no dot sets it |
| apex of the cone as one dot lets it | sqrt(2) R_zernike below the middle, where the cone holds the ball | no dot sets it |
| all dots count alike | weights fade at the rim and go with the normal's cosine to z | none enters at once, walls count little |
| mean distance per pixel, gaps filled in scan order | round bumps, wider ones where dots are few | the same from every side |
| sum over pixels | exact integral of the interpolated field | no staircase at the edge of the disc |

A patch of one dot is a plane through it, not the zero vector; a patch without dots is the zero vector. Few dots give a
smooth patch, not an empty one.
"""


def _with(table, **values):
    for key, value in values.items():
        table = table[table[key] == value]
    return table


def _lowest(changes):
    return changes[changes["density"] == changes["density"].min()]


def _span(values, decimals=2):
    """Smallest and largest value in words."""
    low, high = (f"{f(values):.{decimals}f}" for f in (min, max))
    return low if low == high else f"{low} to {high}"


def _answer(tables):
    changes = _lowest(tables["changes"])

    def ratios(descriptor, change):
        return _span(
            _with(changes, descriptor=descriptor, change=change)["ratio"], 3 if descriptor == "steady" else 2
        )

    longer = _with(tables["linked"], descriptor="steady", change="fresh dots", D_link=LONGER)
    return (
        f"Turning the molecule moves the published descriptor by {ratios('published', 'turned')} of what two different patches "
        f"differ by, the steady one by {ratios('steady', 'turned')}; fresh dots of the same surface by "
        f"{ratios('published', 'fresh dots')} and {ratios('steady', 'fresh dots')}; both together by "
        f"{ratios('published', 'turned, fresh dots')} and {ratios('steady', 'turned, fresh dots')}. With dots linked over "
        f"{LONGER:g} Å fresh dots move the steady one by {_span(longer['ratio'], 3)}.\n"
    )


def _changes(changes):
    keys = ["surface", "density", "change"]
    out = changes[keys].drop_duplicates().reset_index(drop=True)
    for name in ("published", "steady"):
        own = (
            _with(changes, descriptor=name).set_index(keys).loc[list(out.itertuples(index=False, name=None))]
        )
        out[f"Z {name}"] = own["Z"].to_numpy()
        out[f"two patches, {name}"] = own["two_patches"].to_numpy()
        out[f"ratio, {name}"] = own["ratio"].to_numpy()
    out["density"] = [f"{value:g}" for value in out["density"]]
    return out.rename(columns={"density": "dots per Å^2"})


def _linked(linked):
    """What a longer linking distance gives: fresh dots, by D_link."""
    fresh = linked[linked["change"] == "fresh dots"]
    out = fresh[["surface", "D_link"]].drop_duplicates().reset_index(drop=True)
    for name in ("published", "steady"):
        out[f"ratio of fresh dots, {name}"] = _with(fresh, descriptor=name)["ratio"].to_numpy()
    return (
        f"At the published D_link of {D_LINK:g} Å single dots are islands of their own, here and there, and fall out of the "
        "patch: not the surface, where its dots fell. A longer one holds them "
        f"(`patches: {{descriptor: steady, D_link: {LONGER:g}}}`):\n\n"
        + markdown(out.assign(D_link=[f"{link:g} Å" for link in out["D_link"]]), 3)
    )


def _orders(orders):
    orders = _lowest(orders)
    words = []
    for name in ("published", "steady"):
        worst = _with(orders, descriptor=name).groupby("n")["ratio"].max()
        good = [str(n) for n in worst.index if worst[n] < SIGNAL]
        words.append(
            f"{name}: {', '.join(good)} (at n = 20 the share is {worst[20]:.2f})" if good else f"{name}: none"
        )
    return (
        f"Orders n of which less than {SIGNAL:g} of the variance between patches comes from position and dots, on both surfaces: "
        f"{'; '.join(words)}.\n"
    )


def _rows(rows):
    out = rows[["surface", "row"]].drop_duplicates().reset_index(drop=True)
    first = _with(rows, descriptor="published", islands="kept").set_index(["surface", "row"])
    keys = list(out.itertuples(index=False, name=None))
    out["n_S / %"] = first.loc[keys, "n_S_percent"].to_numpy()
    for islands in ("kept", "surface"):
        for name in ("published", "steady"):
            own = _with(rows, descriptor=name, islands=islands).set_index(["surface", "row"]).loc[keys]
            out[f"Z_tS `{islands}` {name}"] = own["Z_tS"].to_numpy()
            out[f"d `{islands}` {name}"] = [
                f"{d:.2f} ± {e:.2f}" for d, e in zip(own["d"], own["error"], strict=True)
            ]
    return out


def _grid(grid):
    combination = [
        f"({a:g}, {b:g}, {c:g}, {d:g})" for a, b, c, d in grid[["alpha", "beta", "gamma", "delta"]].to_numpy()
    ]
    return pd.DataFrame(
        {
            "surface": grid["surface"],
            "descriptor": grid["descriptor"],
            "islands": grid["islands"],
            "d > 0, %": grid["percent_above_0"],
            "best d": grid["best_d"],
            "of (alpha, beta, gamma, delta)": combination,
            "correlation": grid["correlation"],
        }
    )


def _single_dots(rows):
    largest = {
        name: _with(rows, descriptor=name, islands="kept")["d"].max() for name in ("published", "steady")
    }
    text = _with(rows, descriptor="steady", islands="surface")["d"]
    return (
        f"The largest d of Table I's rows under `kept` is {largest['published']:.2f} by the published descriptor and "
        f"{largest['steady']:.2f} by the steady one, for which a patch broken to one dot is a plane, no empty image. Under "
        f"`surface` d lies between {text.min():.2f} and {text.max():.2f} by the steady one.\n"
    )


def enough(rows, floor):
    """n_S in % from which on Z stays below the floor, between the values measured; None where none does."""
    n, z = rows["n_S_percent"].to_numpy(), rows["Z"].to_numpy()
    above = np.flatnonzero(z > floor)
    if len(above) == 0:
        return n[0]
    last = above[-1]
    if last == len(z) - 1:
        return None
    share = np.log(z[last] / floor) / np.log(z[last] / z[last + 1])
    return float(n[last] * (n[last + 1] / n[last]) ** share)


def _enough_sentence(tables):
    parts = []
    for surface in tables["samplers"]["surface"].unique():
        for name in ("published", "steady"):
            rows = _with(tables["samplers"], surface=surface, descriptor=name)
            floor = floor_of(tables["changes"], surface, name)
            found = {s: enough(_with(rows, sampler=s), floor) for s in ("farthest", "uniform")}
            words = ", ".join(f"{s} {f'{v:.0f} %' if v else 'more than 40 %'}" for s, v in found.items())
            parts.append(f"{surface}, {name} (floor {floor:.2f}): {words}")
    return (
        "Dots from which on a subset describes the surface as well as the same surface turned and with fresh dots (the floor), "
        f"under `surface`: {'; '.join(parts)}.\n"
    )


def _samplers(tables):
    rows = tables["samplers"]
    out = []
    for surface in rows["surface"].unique():
        for sampler in rows["sampler"].unique():
            line = {"surface": surface, "sampler": sampler}
            for name in ("published", "steady"):
                own = _with(rows, surface=surface, sampler=sampler, descriptor=name)
                for percent, z in zip(own["percent"], own["Z"], strict=True):
                    line[f"{name} {percent:g} %"] = z
            out.append(line)
    return pd.DataFrame(out)
