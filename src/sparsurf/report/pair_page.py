"""The pages of pairs: one matched, and many summed up."""

from sparsurf.report.numbers import against_zero, interval, number

TEMPLATE, OF_ALL = "pair.html.j2", "pairs.html.j2"
MAP = "propensity_smoothed"  # the score that the answer speaks of
OWN = ("propensity", "similarity")  # begin the scores that compare patches; the others are baselines
SCORES = {
    "propensity": "complementarity, nearest patch",
    "propensity_smoothed": "complementarity, smoothed",
    "propensity_k": "complementarity, mean of the nearest",
    "propensity_k_smoothed": "complementarity, mean smoothed",
    "similarity": "similarity, nearest patch",
    "similarity_smoothed": "similarity, smoothed",
    "flatness": "roughness of the patch",
    "planarity": "planarity over 10 Å",
    "centroid": "distance from the centroid",
    "protrusion": "protrusion: few heavy atoms within 10 Å",
    "hydropathy": "hydropathy over 10 Å (Kyte-Doolittle)",
}
SHOWN = 10  # best-matching pairs of patches, or pairs by name


def called(score):
    """What a score is called on pages and in figures."""
    return SCORES.get(score, score)


def pair_page(name, agreement, contacts, best, settings, partners, bare=()):
    """What the template of one pair asks for.

    Parameters
    ----------
    name : str
    agreement, contacts, best : DataFrames of agreement.csv, contacts.csv and best_pairs.csv
    settings : dict, the config's `patches` and `complementarity`
    partners : two str, what they are
    bare : sequence of '1', '2', the partners that came without atoms
    """
    places = ["dot_1", "dot_2"]
    return {
        "name": name,
        "within": f"{settings['complementarity']['interface']:g}",
        "partners": partners,
        "bare": list(bare),
        "sides": [side_of(side, own) for side, own in agreement.groupby("partner")],
        "scores": score_rows(agreement),
        "contacts": [interval(*row) for row in contacts[["auc", "low", "high"]].to_numpy()],
        "best_columns": [column for column in best.columns if column not in places][:7],
        "best": [
            list(map(_cell, row))
            for row in best.head(SHOWN).drop(columns=places, errors="ignore").iloc[:, :7].to_numpy()
        ],
        "n_best": len(best),
    }


def _cell(value):
    return number(value) if isinstance(value, float) else str(value)


def side_of(side, own):
    """One partner: the AUC of the map, and the best baseline."""
    own = own.set_index("score")
    simple = own[~own.index.str.startswith(OWN)]["auc"]
    return {
        "side": side,
        "auc": number(own.loc[MAP, "auc"]),
        "place": against_zero(own.loc[MAP, "low"] - 0.5, own.loc[MAP, "high"] - 0.5),
        "baseline": called(simple.idxmax()),
        "baseline_auc": number(simple.max()),
    }


def score_rows(agreement):
    """One score a row: its name, AUC with interval of partner 1 and of partner 2."""
    found = {}
    for _, row in agreement.iterrows():
        found.setdefault(row["score"], {})[int(row["partner"])] = interval(
            row["auc"], row["low"], row["high"]
        )
    return [(called(score), [own.get(side, "") for side in (1, 2)]) for score, own in found.items()]


def pairs_page(run, means, n_pairs, n_touching, table):
    """What the template of all pairs asks for.

    Parameters
    ----------
    run : str
    means : DataFrame
        means.csv: the mean AUC of each score over the pairs.
    n_pairs, n_touching : int
        Pairs, and those of them with an interface.
    table : DataFrame
        pairs.csv: the AUC of each pair, partner and score.
    """
    by = means.set_index("score")
    simple = by[~by.index.str.startswith(OWN)]["mean"] if len(by) else by
    known = {"auc": None}
    if len(by):
        by[["low", "high"]] = by[["low", "high"]].clip(0, 1)  # few pairs: Student's t knows no such bounds
        low, high = by.loc[MAP, ["low", "high"]]
        known = {
            "auc": interval(by.loc[MAP, "mean"], low, high, 3),
            "place": against_zero(low - 0.5, high - 0.5),
            "baseline": called(simple.idxmax()),
            "baseline_auc": number(simple.max(), 3),
        }
    own = table[table["score"] == MAP].groupby("complex", sort=False)["auc"].mean()
    return known | {
        "run": run,
        "n_pairs": n_pairs,
        "n_touching": n_touching,
        "scores": [
            (called(score), interval(row["mean"], row["low"], row["high"], 3)) for score, row in by.iterrows()
        ],
        "pairs": [(name, number(auc)) for name, auc in own.items()],
    }
