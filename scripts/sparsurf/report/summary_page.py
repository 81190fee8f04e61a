"""The page on all surfaces of a run: the surfaces, and the best parameters against their mean roughness."""

import pandas as pd

from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED, readings_in
from sparsurf.report.front_page import best_sentence
from sparsurf.report.pages import held_out, markdown
from sparsurf.sampling.combination import PARAMETERS, texts_of
from sparsurf.study.enough import PREFIX


def enough_markdown(surfaces):
    """How many dots are enough by each noise floor, over the surfaces; nothing where that is not known."""
    names = [
        name.removesuffix(f"_{TEXT}")
        for name in surfaces
        if name.startswith(PREFIX) and name.endswith(f"_{TEXT}")
    ]
    rows = [
        {"floor": name.removeprefix(PREFIX).replace("_", " ")}
        | {
            words: "{:.3g} ({:.3g} to {:.3g})".format(*own.agg(["median", "min", "max"]).round(2))
            for words, own in (
                ("as they are", surfaces[f"{name}_{TEXT}"].dropna()),
                ("recovered", surfaces[f"{name}_{RECOVERED}"].dropna()),
            )
        }
        for name in names
    ]
    if not rows:
        return []
    words = (
        "Smallest n_S, % of the dots, whose Z comes within a tenth of each noise floor: median of the surfaces (smallest "
        "to largest). As they are: the kept dots alone; recovered: the surface that they give back.\n"
    )
    return ["# How many dots are enough\n", words, markdown(pd.DataFrame(rows))]


def summary_markdown(surfaces, relations, draws=None):
    """The summary as a page: the surfaces, then the relation with mean roughness, range by range.

    Parameters
    ----------
    surfaces, relations : DataFrame
        See `summary.surfaces_table` and `summary.relation_table`.
    draws : int, optional
        Of each combination; several without.
    """
    short = surfaces[["protein", "conformation", "N", "area", "mean_roughness"]].copy()
    short["area"] = short["area"].map("{:.0f} Å^2".format)
    found = readings_in(surfaces, "d_")
    for name in found:
        short[f"best, {name}"] = surfaces[f"best_{name}"]
        short[f"d held out, {name}"] = surfaces[f"d_held_out_{name}"]
    answer = best_sentence(surfaces) + "\n"
    parts = [
        "# The surfaces of this run\n",
        answer,
        markdown(short, 3),
        f"d held out: {held_out(draws)}.\n",
        *enough_markdown(surfaces),
        "# Best parameters against mean roughness\n",
    ]
    for name in found:
        rows = relations[relations["islands"] == name]
        table = pd.DataFrame(
            {
                "n_S / %": [
                    f"{a:.1f} - {b:.1f}" for a, b in rows[["n_S_low_percent", "n_S_high_percent"]].to_numpy()
                ],
                "best on average": [
                    text if known else ""
                    for text, known in zip(texts_of(rows), rows["d"].notna(), strict=True)
                ],
                "its d": rows["d"],
                "sd": rows["d_sd"],
                "different winners": [f"{a} of {b}" for a, b in rows[["n_winners", "n_surfaces"]].to_numpy()],
                "in one set": rows["n_shared"],
                **{f"rho {p}": rows[f"rho_{p}"] for p in PARAMETERS},
                "proteins": rows["n_proteins"],
                "p": rows["p"],
                "near - far": rows["gain"],
                "95 %": [
                    f"{a:.2f} .. {b:.2f}" if a == a else ""
                    for a, b in rows[["gain_low", "gain_high"]].to_numpy()
                ],
            }
        )
        parts += [f"## islands: {name}\n", markdown(table)]
    parts.append(
        "best on average: in ranges of n_S averaged over the surfaces, so that it can lie outside of a surface's own range, by "
        "which winners and sets go; its d is as selected, too high. in one set: on how many surfaces one and the same "
        "combination lies in the 95 % confidence set of the best. "
        "rho: Spearman's rank correlation of the winner's parameter with mean roughness over the proteins, each counting "
        "once; p: probability of so large a rho of any parameter by chance (of twenty rows one is expected to fall below "
        "0.05). A relation needs at least 10 proteins: with 5 a real one is found in 1 to 3 % of runs. near - far: d of a "
        "surface with the combination chosen on the surfaces nearest in mean roughness, minus that chosen on the "
        "farthest.\n"
    )
    return "\n".join(parts)
