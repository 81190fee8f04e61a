"""The page of verdicts: claim by claim of the paper, what came out, with the number and its file.

Every sentence is made from numbers: it changes when they do.
"""

from pathlib import Path

import numpy as np

from sparsurf.patches.readings import OF_GRID, TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report import pages, table_1
from sparsurf.report.rough_and_flat import claims
from sparsurf.sampling.combination import PARAMETERS, Combination, split
from sparsurf.sampling.published import TABLE_1
from sparsurf.study import two_readings


def verdict(data, files):
    """The page as Markdown.

    Parameters
    ----------
    data : dict
        DataFrames: `grid` and `ranges` of the surface, `rows` (`replication.published_rows`), `places` and `bias`
        (`published_runs`), `links` and `signs` (`replication.sweep_links`, `sign_changes`), `defects`, `bins`
        (`rough_and_flat.bins_table`, with a column `around`), `family` (`tuned.best_of_family`), `enough`
        (`minimal_by_floor.enough_dots`). `best` (dict), `uniform`
        (dict: median number of patches of a dot), `surface` (a sentence on the dots).
    files : dict
        Name of the file behind each of them.

    Returns
    -------
    str
    """
    sticks = data["best"]["yardsticks"]
    grid = data["grid"]
    grid.attrs["null_model"] = sticks["null_model"]
    claims_of_paper = [
        ("n_S ranges from 2.63 % to 99.73 %", _span(grid), "grid"),
        ("Table I: d and Z_tS of the ten rows", table_1.against_runs(data["places"], data["bias"]), "places"),
        (
            "Table I: the best combination of each range",
            table_1.winners(data["ranges"], data["places"]),
            "ranges",
        ),
        ("The best combination at alpha = 1 is (1, 0, 6, 0), d = 2.69", _best(data["best"], grid), "best"),
        ("d > 0: the sampling beats a uniform draw", _positive(grid) + _family(data["family"]), "family"),
        ("The subsets describe the surface", table_1.null_model(grid, data["rows"]), "rows"),
        ("Rough patches gain, plane ones are reconstructed nearly equally", claims(data["bins"]), "bins"),
        (
            "beta = gamma = delta = 0 is a uniform draw of a share alpha",
            _uniform(grid, data["uniform"]),
            "grid",
        ),
    ]
    parts = [
        "# The paper's claims and what came out\n",
        *[f"- {sentence}" for sentence in _answer(data)],
        "",
        data["surface"] + "\n",
        pages.readings_explained(OF_GRID),
        pages.yardsticks_markdown(sticks),
    ]
    for title, sentences, source in claims_of_paper:
        parts.append(f"## {title}\n")
        parts += [f"- {sentence}" for sentence in sentences]
        parts.append(f"\nFrom `{files[source]}`.\n")
    parts.append("## What d rests on\n")
    parts += [f"- {sentence}" for sentence in _two_readings(grid) + _links(data["signs"])]
    parts.append("\n" + links_markdown(data["links"]))
    parts.append(f"From `{files['grid']}` and `{files['links']}`.\n")
    parts.append("## What the two defects of the published sampling change\n")
    parts += [f"- {sentence}" for sentence in _defects(data["defects"])]
    parts.append(f"\nFrom `{files['defects']}`.\n")
    parts.append("## Outlook: the surface recovered from a subset\n")
    parts += [f"- {sentence}" for sentence in _outlook(data["enough"])]
    parts.append(f"\nFrom `{files['enough']}` and `{files['floors']}`.\n")
    parts.append(table_1.places_markdown(data["places"], data["rows"]))
    parts.append(f"From `{files['places']}` and `{files['rows']}`.\n")
    return "\n".join(parts)


def _answer(data):
    """The page in short: Table I again or not, and what the subsets are worth, under each reading."""
    grid, rows, null = data["grid"], data["rows"], data["best"]["yardsticks"]["null_model"]
    found = table_1.all_agree(data["places"])
    out = [
        f"Table I made again as published: the published values of {_listed(found[True])} could come from one more run; "
        f"those of {_listed(found[False])} could not."
    ]
    for reading in OF_GRID:
        d, z = rows[f"d_{reading}"], grid[f"Z_tS_{reading}"]
        out.append(
            f"`{reading}`: d of the ten published rows is {d.min():.2f} to {d.max():.2f}; the sampling beats a uniform draw for "
            f"certain in {100 * (grid[f'd_low_{reading}'] > 0).mean():.0f} % of the combinations and loses to it in "
            f"{100 * (grid[f'd_high_{reading}'] < 0).mean():.0f} %; in {100 * (z > null).mean():.0f} % its subset describes a "
            "patch worse than the mean of all patches does."
        )
    return out


def _listed(names):
    return " and ".join(names) if names else "none"


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


def _best(best, grid):
    out = []
    one = grid[np.isclose(grid[PARAMETERS], [1, 0, 6, 0]).all(axis=1)]
    for reading in OF_GRID:
        row = best[reading]["unrestricted"]
        sentence = (
            f"`{reading}`: the best is {Combination.of(row)}, d held out = {row['d_held_out']:.2f} ({pages.interval(row)}), "
            f"{row['d']:.2f} as selected; {pages.may_be_best(row)}"
        )
        if len(one):
            d, low, high = (one[f"{key}_{reading}"].iloc[0] for key in ("d", "d_low", "d_high"))
            among = "(1, 0, 6, 0)" in split(row["best_set"])
            sentence += f"; (1, 0, 6, 0) gives d = {d:.2f} ({low:.2f} .. {high:.2f}) and lies {'in' if among else 'not in'} it"
        out.append(sentence + ".")
    return out


def _positive(grid):
    out = []
    for reading in OF_GRID:
        d, low, high = (grid[f"{key}_{reading}"] for key in ("d", "d_low", "d_high"))
        out.append(
            f"`{reading}`: d is positive in {int((d > 0).sum())} of {len(d)} combinations, above zero with its whole 95 % "
            f"interval in {int((low > 0).sum())} and below in {int((high < 0).sum())}; "
            f"mean {d.mean():.2f}, largest {d.max():.2f}."
        )
    return out


def _family(family):
    """Every (beta, gamma, delta) with alpha tuned to a wished n_S, against a uniform draw."""
    better, members = int(family["n_better"].sum()), int(family["members"].sum())
    cases = [
        f"{row['percent']:g} %: {row['Z_best']:.2f} against {row['Z_uniform']:.2f}"
        for _, row in family.iterrows()
    ]
    none = "none of them" if better == 0 else f"{better} of them"
    return [
        f"`surface`, alpha tuned for every (beta, gamma, delta) that can keep so many dots ({members} cases): {none} "
        f"above zero with the whole interval. The lowest Z_tS of the family against a uniform draw: {'; '.join(cases)}."
    ]


def _uniform(grid, uniform):
    rows = grid[(grid[["beta", "gamma", "delta"]] == 0).all(axis=1)]
    share = ", ".join(
        f"alpha {a:g} keeps {p:.1f} %" for a, p in zip(rows["alpha"], rows["n_S_percent"], strict=True)
    )
    out = [f"{share}."] if len(rows) else ["The grid has no such combination."]
    return [*out, f"A dot lies in {uniform['median']:g} patches (median) and has a chance in each."]


def _two_readings(grid):
    tenths = two_readings.correlation_by_tenths(grid)
    return [
        f"Over the {len(grid)} combinations the correlation of d under `kept` with d under `surface` is "
        f"{two_readings.correlation(grid):.2f}; it does not come from n_S: within tenths of the combinations by n_S it is "
        f"{tenths.min():.2f} to {tenths.max():.2f}.",
        f"Under `kept` the median evaluated patch holds less than {100 * two_readings.SHATTERED:.0f} % of the patch's kept "
        f"dots in {100 * two_readings.shattered(grid):.0f} % of the combinations; d follows how much larger the patches of "
        f"the sampling stay than those of the uniform subset (correlation with the logarithm of the ratio of their median "
        f"sizes, {two_readings.follows_fragments(grid):.2f}).",
    ]


def _links(signs):
    """Where d of the published rows peaks and changes its sign for certain."""
    turned, best = signs.dropna(subset="negative_from"), signs["D_link_best"]
    sentences = [
        "With another linking distance in the evaluation, the samplings being the same, d of the published rows peaks at a "
        f"D_link between {best.min():.1f} and {best.max():.1f} Å, the shorter the more dots are kept, and falls beyond it.",
    ]
    if len(turned):
        cases = [f"{n:g} Å: {', '.join(map(str, own['row']))}" for n, own in turned.groupby("negative_from")]
        sentences.append(
            f"Rows below zero with their whole interval from a D_link on, of {len(signs)}: {'; '.join(cases)}."
        )
    return sentences


def links_markdown(links):
    """d of all published rows for every linking distance, with its interval."""
    text = [f"{d:.2f} ({a:.2f} .. {b:.2f})" for d, a, b in links[["d", "d_low", "d_high"]].to_numpy()]
    table = links.assign(text=text).pivot(index="row", columns="D_link", values="text")
    table = table.rename(columns=lambda link: f"{link:g} Å").reset_index()
    return (
        pages.markdown(table)
        + "\nd of each row of Table I by linking distance, 95 % intervals in brackets.\n"
    )


def _defects(defects):
    out = []
    reference = defects[defects["sampling"] == "as published"].set_index("row")
    for name, part in defects.groupby("sampling", sort=False):
        if name == "as published":
            continue
        part = part.set_index("row")
        change = (part["n_S_percent"] - reference["n_S_percent"]).mean()
        d = {r: (part[f"d_{r}"] - reference[f"d_{r}"]).mean() for r in OF_GRID}
        out.append(
            f"{name}: n_S of the ten rows changes by {change:+.1f} points on average, d by {d['kept']:+.2f} under `kept` "
            f"and {d['surface']:+.2f} under `surface`."
        )
    return out


def _outlook(enough):
    """What a subset with its normals gives once the surface is recovered from it, beside the dots as they are."""
    by = enough.set_index(["floor", "islands"])

    def shares(floor):
        back, alone = by.loc[(floor, RECOVERED)], by.loc[(floor, TEXT)]
        return (
            back,
            f"{back['n_S_percent']:.3g} % of the dots suffice instead of {alone['n_S_percent']:.3g} % as they are",
        )

    fresh, needed = shares("fresh dots")
    _, needed_turned = shares("turned")
    return [
        f"The surface recovered from {fresh['sampler']} dots and their normals alone has a Z of {fresh['Z']:.2f} where other "
        f"dots of the same surface, all kept, have {fresh['Z_floor']:.2f}; to come within a tenth of that, {needed}.",
        f"To come within a tenth of {by.loc[('turned', RECOVERED), 'Z_floor']:.2f}, what turning the molecule and laying its "
        f"dots anew costs, {needed_turned}.",
    ]


def surface_sentence(evaluator, rules, path_to_surface=None):
    """Which dots the page is about, and how they came about: from a ready surface, or by the config's `surface`."""
    made = f"our own analytic dots, re-entrant part `{rules['reentrant']}`, density {rules['density']} (dots per Å^2)"
    if path_to_surface:
        made = f"the dots of {Path(path_to_surface).name}, as they are"
    elif rules["method"] == "dms":
        made = "dots of the program DMS"
    n = len(evaluator.points)
    rough = evaluator.roughness
    return (
        f"Surface: {made}; N = {n} dots (the paper's A1: 20045), {len(evaluator.cover.centre)} centres (181), mean "
        f"roughness {rough.mean():.4f} (0.6263; 1 is flat, 0 is rough)."
    )
