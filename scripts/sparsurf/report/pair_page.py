"""Pages of pairs: one matched, and many summed up."""

from sparsurf.report.front_page import unfinished, where_to_look
from sparsurf.report.pages import markdown

WORDS = {
    "propensity": "complementarity, nearest patch",
    "propensity_smoothed": "the same, smoothed",
    "propensity_k": "complementarity, mean of the nearest",
    "propensity_k_smoothed": "the same, smoothed",
    "similarity": "similarity, nearest patch",
    "similarity_smoothed": "the same, smoothed",
    "flatness": "flatness: roughness R_i",
    "planarity": "planarity over 10 Å",
    "centroid": "distance from the centroid",
    "protrusion": "protrusion: few heavy atoms within 10 Å",
    "hydropathy": "hydropathy over 10 Å (Kyte-Doolittle)",
}
EXPLAINED = (
    "AUC: the chance that a dot of the interface scores higher than one outside it; .5 is a coin. Intervals: 95 %, from "
    "drawing blocks of residues about 10 Å across; of a single block there is none."
)
SHOWN = 10  # best-matching pairs on the page


def pair_markdown(name, agreement, contacts, best, settings, partners, bare=()):
    """One pair as a page: its answer first, then the tables.

    Parameters
    ----------
    name : str
    agreement, contacts, best : DataFrames of agreement.csv, contacts.csv and best_pairs.csv
    settings : dict, the config's `patches` and `complementarity`
    partners : two str, what they are
    bare : sequence of '1', '2', the partners that came without atoms
    """
    within = settings["complementarity"]["interface"]
    parts = [f"# {name}\n"]
    if len(agreement) == 0:
        parts.append(
            f"The partners do not touch (or touch everywhere): dots nearer than {within:g} Å to the partner are interface, and "
            "an AUC needs dots inside and outside it. The maps are made all the same.\n"
        )
    else:
        parts += [_answer(agreement), EXPLAINED + "\n", _areas(agreement)]
    parts.insert(2, f"Partner 1: {partners[0]}. Partner 2: {partners[1]}.{_without_atoms(bare)}\n")
    if len(contacts):
        words = "its first patch with a random one", "the same patches paired at random"
        shown = contacts.drop(columns="against")
        shown.insert(0, "a native pair matches better than", words)
        parts += ["## Pairs of patches that lie on each other\n", markdown(shown)]
    parts += [
        "## Best-matching patches\n",
        f"The first {min(SHOWN, len(best))} of best_pairs.csv; `gap` is how far apart (Å) the two dots lie in the files.\n",
        markdown(best.head(SHOWN)),
    ]
    return "\n".join(parts)


def _without_atoms(bare):
    """What is lacking where a partner is a ready surface."""
    if not bare:
        return ""
    who = "Both are ready surfaces" if len(bare) > 1 else f"Partner {bare[0]} is a ready surface"
    return f" {who} without atoms: nothing is known of residues, and residues.csv is not made."


def _answer(agreement):
    """What the smoothed propensity does, beside the best yardstick."""
    sentences = []
    for side, rows in agreement.groupby("partner"):
        own = rows.set_index("score")["auc"]
        yardsticks = own[[name for name in own.index if not name.startswith(("propensity", "similarity"))]]
        best = yardsticks.idxmax()
        verb = "above" if own["propensity_smoothed"] > yardsticks[best] else "below"
        sentences.append(
            f"Partner {side}: the smoothed propensity finds the interface with AUC {own['propensity_smoothed']:.2f}, {verb} "
            f"the best simple property ({WORDS[best]}: {yardsticks[best]:.2f})."
        )
    return " ".join(sentences) + "\n"


def _areas(agreement):
    shown = agreement.assign(score=agreement["score"].map(lambda name: WORDS.get(name, name)))
    return markdown(shown)


def pairs_markdown(means, n_pairs, n_touching, title="Pairs of this run", links=(), without=()):
    """Means over pairs as a page, with links and what it is without as `front_page.front_page` takes them."""
    parts = [f"# {title}\n", *([unfinished(without)] if without else [])]
    look = [where_to_look(links)] if links else []
    none = f"None of the {n_pairs} pairs has" if n_pairs > 1 else "The only pair does not have"
    if len(means) == 0:
        return "\n".join([*parts, f"{none} an interface: there is nothing to measure.\n", *look])
    simple = means[~means["score"].str.startswith(("propensity", "similarity"))].set_index("score")["mean"]
    value = means.set_index("score").loc["propensity_smoothed"]
    coin = ", not to be told from a coin" if value["low"] < 0.5 < value["high"] else ""
    parts.append(
        f"Over {n_touching} of {n_pairs} pair{'s' if n_pairs > 1 else ''} the smoothed propensity finds the interface with "
        "a mean AUC of "
        f"{value['mean']:.3f}"
        + (f" (95 %: {value['low']:.3f} to {value['high']:.3f}{coin})" if n_touching > 1 else "")
        + f"; the best simple property, {WORDS[simple.idxmax()]}, with {simple.max():.3f}.\n"
    )
    shown = means.assign(score=means["score"].map(lambda name: WORDS.get(name, name)))
    shown = shown.rename(columns={"complexes": "pairs"})
    return "\n".join([*parts, EXPLAINED.split(" Intervals")[0] + "\n", *look, markdown(shown, 3)])
