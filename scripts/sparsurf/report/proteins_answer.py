"""What many proteins say, in three sentences, from the tables that `scripts/write_proteins.py` writes."""

import pandas as pd

from sparsurf.patches.readings import PUBLISHED, TEXT
from sparsurf.recovery.reading import RECOVERED
from sparsurf.report.recommendation import SIGNIFICANT

FRESH, TURNED, FAIR = "fresh dots", "turned", "atoms moved 0.3 Å"
TARGET = 25.0  # % of uniform dots, whose Z the others are to reach


def answer(stored):
    """What came out, in three sentences."""
    return "\n\n".join((of_sign(stored), of_parameters(stored), of_dots(stored))) + "\n"


def of_sign(stored):
    """Whether d > 0 depends on the protein."""
    d, n = stored["d"], stored["surfaces"]["protein"].nunique()
    kept, surface = (d[(d["islands"] == reading)] for reading in (PUBLISHED, TEXT))
    a, b = (part[part["range"] == 0].iloc[0] for part in (kept, surface))
    few = below_half(kept)
    return (
        f"**The sign of d rests on the reading, not on the protein.** Over {n} proteins, the best combinations have, held out, "
        f"d = {between(few, 'own')} under `kept` in the ranges below half of the dots, each above 0 by its own interval on "
        f"{few['n_above'].min():.0f} proteins or more; under `surface` d = "
        f"{between(surface[surface['range'] > 0], 'own')}, and "
        f"{above(surface)} (means over all ranges {interval(a, 'own')} and {interval(b, 'own')})."
    )


def above(rows):
    """On how many proteins any range but the last, which keeps all dots, is above 0."""
    rows = rows[(rows["range"] > 0) & (rows["range"] < rows["range"].max())]
    most = rows["n_above"].max()
    if most == 0:
        return "no range but the last, which keeps every dot, is above 0 on any protein"
    return f"no range but the last, which keeps every dot, is above 0 on more than {most:.0f} of them"


def below_half(rows):
    """The ranges whose n_S lies below half of the dots."""
    return rows[(rows["range"] > 0) & (rows["n_S_percent"] < 50)]


def between(rows, name):
    """The smallest and the largest mean of some ranges, as text."""
    return f"{signed(rows[name].min())} to {signed(rows[name].max())}"


def of_parameters(stored):
    """Whether mean roughness, or the protein at all, has to be known."""
    d, relation, power = stored["d"], stored["relation"], stored["power"]
    some = d[(d["range"] == 0) & (d["islands"] == PUBLISHED)].iloc[0]
    known, found, supported = supported_ranges(relation)
    said = (
        "Mean roughness does not predict"
        if not supported
        else f"In {supported} ranges of n_S mean roughness predicts"
    )
    return (
        f"**{said} the best parameters.** Of {known} ranges and readings whose winners vary, p < {SIGNIFICANT:g} in "
        f"{found} (chance "
        f"gives {SIGNIFICANT * known:.0f}), and in {supported} of these a choice by it pays; a rank correlation of "
        f"{power['rho'].min():.2f} would be found in 80 % of studies of {power['n'].max()} proteins. One combination "
        "per range, "
        f"chosen on the other proteins, gives {signed(-some['lost'])} ({signed(-some['lost_high'])} to "
        f"{signed(-some['lost_low'])}) "
        "more d under `kept` than a protein's own best, held out: the protein need not be known."
    )


def supported_ranges(relation):
    """How many ranges have winners that vary, how many of these go with roughness, and in how many of these it pays."""
    known = relation[relation["p"].notna()]
    found = known[known["p"] < SIGNIFICANT]
    return len(known), len(found), int((found["gain_low"] > 0).sum())


def of_dots(stored):
    """How few dots suffice."""
    rows = stored["enough_means"].set_index(["sampler", "islands", "yardstick"])
    fresh, turned, fair = (rows.loc[("farthest", RECOVERED, name)] for name in (FRESH, TURNED, FAIR))
    times = (
        stored["needed_means"]
        .set_index(["target", "sampler", "islands"])
        .loc[(TARGET, "farthest", RECOVERED)]
    )
    return (
        "**A few per cent of the dots suffice on every protein.** Recovered from farthest-point dots, the surface "
        "errs as little "
        f"as one whose atoms moved by 0.3 Å from {fair['median']:.1f} % of the dots on (median; {fair['lowest']:.1f} to "
        f"{fair['highest']:.1f} % over the proteins), as the molecule turned from {turned['median']:.1f} % on "
        f"({turned['lowest']:.1f} "
        f"to {turned['highest']:.1f} %) and as fresh dots of the same surface from {fresh['median']:.1f} % on "
        f"({of_middle(fresh)} "
        f"for the middle half of the proteins), each within a tenth; for the Z of {TARGET:g} % uniform dots as they "
        "are it takes "
        f"{times['factor']:.1f} ({times['factor_low']:.1f} to {times['factor_high']:.1f}) times fewer."
    )


def readme(stored):
    """Three sentences for the README."""
    d, n = stored["d"], stored["surfaces"]["protein"].nunique()
    residues = stored["surfaces"]["n_residues"]
    kept, surface = (
        d[(d["islands"] == reading) & (d["range"] == 0)].iloc[0] for reading in (PUBLISHED, TEXT)
    )
    fair = (
        stored["enough_means"]
        .set_index(["sampler", "islands", "yardstick"])
        .loc[("farthest", RECOVERED, FAIR)]
    )
    times = (
        stored["needed_means"]
        .set_index(["target", "sampler", "islands"])
        .loc[(TARGET, "farthest", RECOVERED)]
    )
    _, _, supported = supported_ranges(stored["relation"])
    where = f" in {supported} ranges of n_S" if supported else ""
    predicts = f"predicts the best parameters{where}" if supported else "does not predict the best parameters"
    factor = f"{times['factor']:.1f} ({times['factor_low']:.1f} to {times['factor_high']:.1f})"
    return (
        f"**On every protein.** Over {n} proteins of {residues.min()} to {residues.max()} residues "
        f"([docs/proteins.md](docs/proteins.md)), {fair['median']:.1f} % of the dots, farthest-point ones, recovered, "
        "err as little as "
        f"atoms that moved by 0.3 Å (within a tenth; at most {fair['highest']:.1f} % on any protein), and the Z of "
        f"{TARGET:g} % uniform "
        f"dots as they are takes {factor} times fewer. Sampling by roughness beats a uniform draw under one reading "
        "of the paper "
        f"(d = {interval(kept, 'own')}) and loses under the other ({interval(surface, 'own')}), whatever the protein. Its mean "
        f"roughness {predicts}: one combination per n_S does for all."
    )


def of_middle(row):
    """The quartiles as text."""
    return f"{share(row['quarter'])} to {share(row['three_quarters'])} %"


def interval(row, name, unsigned=False):
    """A mean with its 95 % interval."""
    values = [row[f"{name}{end}"] for end in ("", "_low", "_high")]
    if pd.isna(values[0]):
        return ""
    texts = [f"{x:.2f}" if unsigned else signed(x) for x in values]
    return texts[0] if pd.isna(values[1]) else f"{texts[0]} ({texts[1]} to {texts[2]})"


def rho(row, name):
    """A rank correlation with its interval; empty where nothing varies."""
    return (
        ""
        if pd.isna(row[name])
        else f"{signed(row[name])} ({signed(row[f'{name}_low'])} to {signed(row[f'{name}_high'])})"
    )


def share(percent):
    """A share of the dots in %, or that it lies beyond what was measured."""
    if percent == 0:
        return "< 1"
    return f"{percent:.1f}" if percent < 1e3 else "> 60"


def signed(x):
    """Two decimals with a sign that is a minus."""
    return f"{x:+.2f}".replace("-", "−")
