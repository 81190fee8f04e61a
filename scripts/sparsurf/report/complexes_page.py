"""The page on many complexes: what the propensity can and cannot do, from the stored tables."""

from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.patches.index import R_ZERNIKE
from sparsurf.report.pages import markdown

TABLES = (
    "complexes",
    "complexes_means",
    "complexes_variants",
    "complexes_contacts",
    "complexes_control",
    "complexes_thinning",
)
SCORES = {
    "complementarity": "complementarity",
    "similarity": "similarity (both 'up')",
    "another protein": "complementarity to another complex's partner",
    "flatness": "flatness (R_i)",
    "planarity": "planarity over 10 Å",
    "protrusion": "protrusion (few heavy atoms within 10 Å)",
    "hydropathy": "hydropathy over 10 Å",
    "centroid": "distance from the centroid",
}
GROUPS = {"bound": "bound", "tutorial": "1a1u", "bound six": "six, bound", "unbound six": "six, unbound"}
YARDSTICKS = ("flatness", "planarity", "protrusion", "hydropathy", "centroid")
BEST = 8  # variants shown
FIGURE = "complexes_thinning.png"


def complexes_markdown(tables):
    """The page.

    Parameters
    ----------
    tables : dict, name of `TABLES` -> DataFrame as stored in docs/tables/

    Returns
    -------
    str
    """
    means = tables["complexes_means"]
    parts = [
        "# Complementarity over many complexes\n",
        _answer(means, tables["complexes"]),
        "## How well each score finds the interface\n",
        "Mean AUC over complexes with its 95 % interval; the two partners of a complex are averaged first. .5 is a coin. "
        "Interface: dots within 3 Å of the partner; unbound forms take the labels of the bound form they are laid on. Where "
        "`complexes` is smaller, only the first of them by name were measured.\n",
        markdown(_side_by_side(means)),
        "## Whether the partner matters\n",
        _partner(tables["complexes_control"], tables["complexes_contacts"], means),
        "## What follows from the numbers, tried\n",
        _variants(tables["complexes_variants"]),
        "## What few centres are worth\n",
        _thinning(tables["complexes_thinning"]),
        "## Where it comes from\n",
        "Bound and unbound structures of docking benchmark 5 as cleaned by HADDOCK's authors (haddocking/BM5-clean, Apache-2.0; "
        "every fifth complex) and 1a1u, the example of the authors' tutorial. "
        f"{int(tables['complexes']['patches'].max())} farthest-point patches per surface, our own analytic dots. Tables: "
        "`docs/tables/complexes*.csv`; per surface with intervals by blocks of residues: `complexes.csv`.\n\n"
        "```\npython scripts/study_complexes.py data results/complexes            # also with a third word: a descriptor\n"
        "python scripts/thin_complexes.py data docs\npython scripts/write_complexes.py results/complexes docs\n```\n"
        "One's own complexes: `studies/complexes.yaml`.\n",
    ]
    return "\n".join(parts)


def _row(means, group, score, map_="-", descriptor=None):
    """One mean, or None."""
    rows = means[(means["group"] == group) & (means["score"] == score) & (means["map"] == map_)]
    rows = rows if descriptor is None else rows[rows["descriptor"].str.startswith(descriptor)]
    return rows.iloc[0] if len(rows) else None


def _with_interval(row):
    return f"{row['mean']:.3f} (95 %: {row['low']:.3f} to {row['high']:.3f})"


def _answer(means, surfaces):
    """The answer: the propensity, a coin, the yardsticks, and why 1a1u flatters."""
    own = _row(means, "bound", "complementarity", "smoothed", PUBLISHED)
    beside = {name: _row(means, "bound", name) for name in YARDSTICKS}
    better = [name for name, row in beside.items() if row["mean"] > own["mean"]]
    if own["low"] > 0.5:
        verdict = "above a coin, by little" if own["mean"] < 0.6 else "above a coin"
    else:
        verdict = "not to be told from a coin" if own["high"] >= 0.5 else "below a coin"
    listed = ", ".join(f"{SCORES[name]} {beside[name]['mean']:.3f}" for name in better)
    tutorial = _row(means, "tutorial", "complementarity", "smoothed", PUBLISHED)
    share = surfaces.assign(share=100 * surfaces["interface"] / surfaces["patches"])
    share = share.drop_duplicates(["complex", "form", "side"]).set_index("complex")["share"]
    text = (
        f"Over {int(own['complexes'])} bound complexes the smoothed binding propensity finds the interface with a mean AUC of "
        f"{_with_interval(own)}: {verdict}. "
    )
    text += (
        f"{len(better)} of {len(YARDSTICKS)} simple properties do better: {listed}. "
        if better
        else "None of the simple properties does better. "
    )
    steady, other = (
        _row(means, "bound", score, "smoothed", "steady") for score in ("complementarity", "another protein")
    )
    if steady is not None:
        text += (
            f"With the steady descriptor it is {_with_interval(steady)}, and {_with_interval(other)} against the partner of "
            "another complex. "
        )
    return text + (
        f"On 1a1u, the example of the tutorial, it is {tutorial['mean']:.3f}; 1a1u flatters, as a single complex can: "
        f"{share['1a1u'].mean():.0f} % of its patches are interface (median of the others: "
        f"{share.drop('1a1u').median():.0f} %). So a low propensity should not be read as a "
        "predicted interface. What the maps do allow is thinning: see below.\n"
    )


def _side_by_side(means):
    """Groups as columns; the number of complexes is that of the first."""
    keys = ["descriptor", "score", "map"]
    table = means[means["map"].isin(["raw", "smoothed"]) | means["score"].isin(YARDSTICKS)]
    out = table[keys].drop_duplicates().reset_index(drop=True)
    places = list(out.itertuples(index=False, name=None))
    for group, words in GROUPS.items():
        rows = table[table["group"] == group].set_index(keys)
        out[words] = [_cell(rows.loc[key]) if key in rows.index else "" for key in places]
        if group == "bound":
            out["complexes"] = [rows.loc[key]["complexes"] if key in rows.index else "" for key in places]
    out["score"] = out["score"].map(SCORES)
    return out


def _cell(row):
    mean = f"{row['mean']:.3f}"
    return mean if row["complexes"] < 2 else f"{mean} ({row['low']:.3f} to {row['high']:.3f})"


def _partner(control, contacts, means):
    """The control with another complex's partner, and native pairs against random ones."""
    lines = []
    for _, row in control.iterrows():
        own, other = (
            _row(means, "bound", score, "smoothed", row["descriptor"])
            for score in ("complementarity", "another protein")
        )
        lines.append(
            f"With the {row['descriptor']} descriptor the map against the partner of another complex correlates at "
            f"{row['mean']:.2f} (95 %: {row['low']:.2f} to {row['high']:.2f}; {row['complexes']} complexes) with the map "
            f"against the true partner, and over {other['complexes']:.0f} finds the interface with an AUC of "
            f"{other['mean']:.3f} (true partner: {own['mean']:.3f})."
        )
    shown = contacts[contacts["group"] == "bound"]
    words = {"any pair": "its first patch and a random one", "exchanged": "the same patches paired at random"}
    table = shown[["descriptor", "against", "mean", "low", "high", "complexes"]]
    return (
        "\n\n".join(lines)
        + "\n\nChance that the descriptors of two patches that lie on each other in the complex are nearer than those of:\n\n"
        + markdown(table.assign(against=table["against"].map(words)), 3)
    )


def _variants(variants):
    """The best variants by the few complexes they were chosen on, and the published one."""
    published = (
        (variants["score"] == "complementarity") & (variants["kind"] == "plain") & (variants["k"] == 1)
        & (variants["map"] == "smoothed") & (variants["descriptor"] == f"{PUBLISHED}, {R_ZERNIKE:g} Å")
    )  # fmt: skip
    reference = variants[published].iloc[0]
    shapes = variants[variants["score"].isin(["complementarity", "similarity"])]
    best, best_shape = variants.iloc[0], shapes.iloc[0]
    table = variants[published | (variants.index < BEST) | (variants.index == shapes.index[0])]
    table = table.assign(
        **{"place": table.index + 1, "variant": [_words(row) for _, row in table.iterrows()]}
    )
    columns = ["place", "variant", "chosen_on", "mean", "low", "high", "complexes"]
    return (
        "Larger patches, the mean of the ten nearest instead of the nearest, distances relative to those of patches as flat, and "
        f"ranks averaged with hydropathy and protrusion: {len(variants)} variants and yardsticks, ordered by their mean AUC "
        "on 1a1u and ten complexes, reported on those of the others that were measured (last column).\n\n"
        f"The best variant there is {_words(best)}: {_with_interval(best)} on the others. The best by shape alone is "
        f"{_words(best_shape)}: {_with_interval(best_shape)} on {best_shape['complexes']} of them, against "
        f"{reference['mean']:.3f} on {reference['complexes']} as published. "
        f"{_added(variants)}\n\n"
        + markdown(
            table[columns].rename(
                columns={"chosen_on": "mean on 1a1u and ten", "mean": "mean on the others"}
            ),
            3,
        )
    )


def _added(variants):
    """What the published propensity adds to hydropathy and protrusion."""
    of = variants.set_index("score")
    alone = of.loc["hydropathy + protrusion", "mean"]
    beside = variants[variants["score"] == "propensity + hydropathy + protrusion"]
    beside = beside[beside["descriptor"].str.startswith(PUBLISHED)].iloc[0]["mean"]
    verb = "raises" if beside > alone else "lowers"
    return f"Adding the published propensity to hydropathy and protrusion {verb} their mean from {alone:.3f} to {beside:.3f}."


def _words(row):
    """A variant in words."""
    if row["score"] not in ("complementarity", "similarity", "another protein"):
        name = SCORES.get(row["score"], row["score"])
        return name if row["descriptor"] == "-" else f"{name} ({row['descriptor']})"
    words = [SCORES[row["score"]], row["descriptor"]]
    words += [f"mean of {row['k']} nearest"] if row["k"] > 1 else []
    words += ["relative to flatness"] if row["kind"] == "relative" else []
    return ", ".join([*words, row["map"]])


def _thinning(table):
    """Correlation, AUC and cost of maps from few centres."""
    mean = table.groupby(["sampler", "surface", "percent"], sort=False).mean(numeric_only=True).reset_index()
    whole = mean[mean["sampler"] == "all"].iloc[0]
    mean = mean[mean["sampler"] != "all"].assign(times=lambda rows: whole["seconds"] / rows["seconds"])
    best = mean[(mean["sampler"] == "farthest") & (mean["surface"] == "full")].set_index("percent")
    text = (
        f"Mean of {', '.join(dict.fromkeys(table['complex']))}. 5 % farthest-point centres on both sides give a smoothed map "
        f"that correlates at {best['correlation'][5]:.3f} with the map from all dots (AUC {best['auc'][5]:.3f} instead of "
        f"{whole['auc']:.3f}) in {best['times'][5]:.0f} times less CPU time. The comparison itself takes "
        f"{whole['comparing'] / best['comparing'][5]:.0f} times less; what remains are the descriptors, the choice of the "
        "centres and the smoothing onto all dots. 'recovered': the patches are cut from the surface recovered from the "
        "centres alone.\n\n"
    )
    parts = [f"{text}![AUC and correlation against n_S and cost]({FIGURE})\n"]
    for value, words, decimals in (
        ("correlation", "Correlation with the map of all dots", 3),
        ("auc", f"AUC (all dots: {whole['auc']:.3f})", 3),
        ("times", f"Times less CPU than all dots ({whole['seconds']:.1f} s)", 0),
    ):
        wide = mean.pivot(index=["sampler", "surface"], columns="percent", values=value)
        wide = wide.loc[mean[["sampler", "surface"]].drop_duplicates().itertuples(index=False, name=None)]
        wide.columns = [f"{percent:g} %" for percent in wide.columns]
        parts += [
            f"{words}, by the share of the dots that are centres:\n",
            markdown(wide.reset_index(), decimals),
        ]
    return "\n".join(parts)
