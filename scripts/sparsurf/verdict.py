"""The page of verdicts: claim by claim of the paper, what came out, with the number and its file.

Every sentence is made from numbers: it changes when they do.
"""

import numpy as np
from markdown_it import MarkdownIt

from sparsurf import tables
from sparsurf.evaluation import PUBLISHED_ROWS, TABLE_1
from sparsurf.tables import Z95

STYLE = "body{font:16px sans-serif;max-width:70em;margin:2em auto}td,th{padding:2px 8px;text-align:right}"


def verdict(data, files):
    """The page as Markdown.

    Parameters
    ----------
    data : dict
        `grid`, `ranges`, `rows`, `links`, `defects`, `selected` (DataFrames), `best` (dict), `bins` (DataFrame of
        Z by roughness, see `rough_and_flat`), `surface` (one sentence on the dots).
    files : dict
        Name of the file behind each of them.

    Returns
    -------
    str
    """
    claims = [
        ("n_S ranges from 2.63 % to 99.73 %", _span(data["grid"]), "grid"),
        ("Table I: n_S, d and Z_tS of the ten rows", _rows(data["rows"]), "rows"),
        ("Table I: the best combination of each range", _winners(data["selected"], data["ranges"]), "ranges"),
        (
            "The best combination at alpha = 1 is (1, 0, 6, 0), d = 2.69",
            _best(data["best"], data["grid"]),
            "best",
        ),
        ("d > 0: the sampling beats a uniform draw", _positive(data["grid"]), "grid"),
        ("Rough patches gain most", _rough(data["bins"]), "bins"),
        (
            "beta = gamma = delta = 0 is a uniform draw of a share alpha",
            _uniform(data["grid"], data["uniform"]),
            "grid",
        ),
    ]
    sticks = data["best"]["yardsticks"]
    parts = [
        "# The paper's claims and what came out\n",
        data["surface"] + "\n",
        tables.READINGS_EXPLAINED,
        tables.yardsticks_markdown(sticks),
    ]
    for title, sentences, source in claims:
        parts.append(f"## {title}\n")
        parts += [f"- {sentence}" for sentence in sentences]
        parts.append(f"\nFrom `{files[source]}`.\n")
    parts.append("## What d rests on\n")
    parts += [f"- {sentence}" for sentence in _two_readings(data["grid"]) + _links(data["links"])]
    parts.append(f"\nFrom `{files['grid']}` and `{files['links']}`.\n")
    parts.append("## What the two defects of the published sampling change\n")
    parts += [f"- {sentence}" for sentence in _defects(data["defects"])]
    parts.append(f"\nFrom `{files['defects']}`.\n")
    return "\n".join(parts)


def as_html(page):
    """The page for a browser."""
    body = MarkdownIt("commonmark").enable("table").render(page)
    return f"<!doctype html><meta charset='utf-8'><title>Verdict</title><style>{STYLE}</style>{body}"


def _agree(yes):
    return "agrees" if yes else "does not agree"


def _span(grid):
    low, high = grid["n_S_percent"].min(), grid["n_S_percent"].max()
    near = (
        abs(low - TABLE_1["n_S_low_percent"][0]) < 0.2 and abs(high - TABLE_1["n_S_high_percent"][-1]) < 0.2
    )
    closed = 100 * grid["n_S_expected"] / (grid["n_S"] / grid["n_S_percent"] * 100)
    return [
        f"Here {low:.2f} % to {high:.2f} %, the mean of the draws (closed form: {closed.min():.2f} % to "
        f"{closed.max():.2f} %): {_agree(near)} within 0.2 points."
    ]


def _rows(rows):
    out = [f"n_S lies in the published range in {int(rows['n_S_agrees'].sum())} of {len(rows)} rows."]
    for name in ("Z_tS", "d"):
        agrees = rows[f"{name}_agrees"]
        sentence = (
            f"{name}: {int(agrees.sum())} of {len(rows)} published values lie within 1.96 standard deviations of one "
            f"as-published replicate of our mean, the selection bias of the range allowed for"
        )
        out.append(sentence + ("." if agrees.all() else ", all but " + _outside(rows[~agrees], name) + "."))
    bias = rows["d_bias"]
    out.append(
        f"The selection bias of d, how far the best of a range lies above what the same combination gives on many test "
        f"dots, is {bias.mean():.2f} on average and {bias.max():.2f} at most."
    )
    surface = rows["d_shared_surface"]
    out.append(
        f"Under `surface` d of the ten rows runs from {surface.min():.2f} to {surface.max():.2f}; "
        f"{int((surface > 0).sum())} of them are positive."
    )
    return out


def _outside(rows, name):
    return ", ".join(
        f"row {k + 1} (published {row[f'{name}_published']:.2f}, here {row[f'{name}_low']:.2f} .. {row[f'{name}_high']:.2f})"
        for k, row in rows.iterrows()
    )


def _winners(selected, ranges):
    published = [
        tables.combination_text(dict(zip(tables.PARAMETERS, row, strict=True))) for row in PUBLISHED_ROWS
    ]
    kept = ranges[ranges["islands"] == "kept"]
    same = sum(a == b for a, b in zip(_texts(kept), published, strict=False))
    on_plateau = sum(
        text in str(each).split("; ") for each, text in zip(kept["plateau"], published, strict=False)
    )
    again = [sum(a == b for a, b in zip(_texts(one), published, strict=False)) for one in selected]
    distinct = [len(set(texts)) for texts in zip(*map(_texts, selected), strict=True)]
    return [
        f"With shared test dots the winner is the published one in {same} of {len(kept)} ranges; the published one is "
        f"among those that cannot be told from the winner in {on_plateau}.",
        f"Chosen the paper's way {len(selected)} times, the winner is the published one in {min(again)} to {max(again)} "
        f"ranges; a range has {min(distinct)} to {max(distinct)} different winners in {len(selected)} runs.",
    ]


def _texts(ranges):
    return [tables.combination_text(row) for _, row in ranges.iterrows()]


def _best(best, grid):
    out = []
    one = grid[np.isclose(grid[tables.PARAMETERS], [1, 0, 6, 0]).all(axis=1)]
    for reading in ("kept", "surface"):
        row = best[reading]["unrestricted"]
        sentence = (
            f"`{reading}`: the best is {tables.combination_text(row)}, d = {row['d']:.2f} ({tables.interval(row)}), held "
            f"out {row['d_held_out']:.2f}; {tables.as_good(row)}"
        )
        if len(one):
            d, se = one[f"d_{reading}"].iloc[0], one[f"d_se_{reading}"].iloc[0]
            among = "(1, 0, 6, 0)" in row["plateau"].split("; ")
            sentence += (
                f"; (1, 0, 6, 0) gives d = {d:.2f} ({d - Z95 * se:.2f} .. {d + Z95 * se:.2f}) and is "
                f"{'one of them' if among else 'not one of them'}"
            )
        out.append(sentence + ".")
    return out


def _positive(grid):
    out = []
    for reading in ("kept", "surface"):
        d, se = grid[f"d_{reading}"], grid[f"d_se_{reading}"]
        out.append(
            f"`{reading}`: d is positive in {int((d > 0).sum())} of {len(d)} combinations, above zero by 1.96 standard "
            f"errors in {int((d > Z95 * se).sum())} and below by as much in {int((d < -Z95 * se).sum())}; mean "
            f"{d.mean():.2f}, largest {d.max():.2f}."
        )
    return out


def rough_and_flat(roughness, distances, bins=10):
    """Mean d of a combination by roughness of the test dot.

    Parameters
    ----------
    roughness : (T,) float64
    distances : dict of reading to (Z_tS(j), Z_tR(j)), each (T,)
    bins : int
        Equal widths between the smallest and the largest roughness, as in Fig. 4.

    Returns
    -------
    DataFrame: roughness_low, roughness_high, n, and d_<reading> with d_se_<reading>
    """
    import pandas as pd

    edges = np.linspace(roughness.min(), roughness.max(), bins + 1)
    place = np.clip(np.searchsorted(edges, roughness, side="right") - 1, 0, bins - 1)
    out = pd.DataFrame(
        {"roughness_low": edges[:-1], "roughness_high": edges[1:], "n": np.bincount(place, minlength=bins)}
    )
    for reading, (z_ts, z_tr) in distances.items():
        d = [z_tr[place == k] - z_ts[place == k] for k in range(bins)]
        out[f"d_{reading}"] = [x.mean() if len(x) else np.nan for x in d]
        out[f"d_se_{reading}"] = [x.std(ddof=1) / np.sqrt(len(x)) if len(x) > 1 else np.nan for x in d]
    return out


def _rough(bins):
    filled = bins[bins["n"] >= 10]
    half = len(filled) // 2
    out = []
    for reading in ("kept", "surface"):
        d = filled[f"d_{reading}"].to_numpy()
        rough, flat = (
            np.average(d[:half], weights=filled["n"][:half]),
            np.average(d[half:], weights=filled["n"][half:]),
        )
        more = (
            "rough patches gain more than flat ones"
            if rough > flat
            else "rough patches gain less than flat ones"
        )
        if max(rough, flat) < 0:
            more = "both lose, rough patches " + ("less" if rough > flat else "more")
        out.append(
            f"`{reading}`: mean d is {rough:.2f} in the rougher half of the bins of Fig. 4 and {flat:.2f} in the flatter "
            f"half: {more}."
        )
    return out


def _uniform(grid, uniform):
    rows = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)]
    share = ", ".join(
        f"alpha {a:g} keeps {p:.1f} %" for a, p in zip(rows["alpha"], rows["n_S_percent"], strict=True)
    )
    out = [f"{share}."] if len(rows) else ["The grid has no such combination."]
    return [*out, f"A dot lies in {uniform['median']:g} patches (median) and has a chance in each."]


def _two_readings(grid):
    d = grid[["d_kept", "d_surface"]].corr().iloc[0, 1]
    larger = np.log(grid["fragment_kept"] / grid["fragment_uniform_kept"])
    follows = np.corrcoef(grid["d_kept"], larger)[0, 1]
    ratio = (grid["fragment_kept"] < 0.3 * grid["fragment_surface"]).mean()
    return [
        f"Over the {len(grid)} combinations the correlation of d under `kept` with d under `surface` is {d:.2f}.",
        f"Under `kept` the median evaluated patch holds less than 30 % of the patch's kept dots in {100 * ratio:.0f} % of "
        f"the combinations; d follows how much larger the patches of the sampling stay than those of the uniform subset "
        f"(correlation with the logarithm of the ratio of their median sizes, {follows:.2f}).",
    ]


def _links(links):
    table = links.pivot(index="D_link", columns="row", values="d")
    out = []
    for row in (1, 5):
        crossing = table.index[table[row] < 0]
        turn = f"negative from D_link = {crossing[0]:.1f} Å on" if len(crossing) else "positive throughout"
        out.append(
            f"Row {row} of Table I: d = {table[row].iloc[0]:.2f} at D_link = {table.index[0]:.1f} Å, "
            f"{table[row].iloc[-1]:.2f} at {table.index[-1]:.1f} Å, {turn} (the samplings are the same; only the islands "
            f"of the evaluation change)."
        )
    return out


def _defects(defects):
    out = []
    reference = defects[defects["sampling"] == "as published"].set_index("row")
    for name, part in defects.groupby("sampling", sort=False):
        if name == "as published":
            continue
        part = part.set_index("row")
        change = (part["n_S_percent"] - reference["n_S_percent"]).mean()
        d = {r: (part[f"d_{r}"] - reference[f"d_{r}"]).mean() for r in ("kept", "surface")}
        out.append(
            f"{name}: n_S of the ten rows changes by {change:+.1f} points on average, d by {d['kept']:+.2f} under `kept` "
            f"and {d['surface']:+.2f} under `surface`."
        )
    return out
