"""What many proteins say, in three sentences, from the tables that `scripts/write_proteins.py` writes."""

import pandas as pd
from scipy.stats import binom

from sparsurf.patches.readings import PUBLISHED, TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.report.recommendation import SIGNIFICANT

FRESH, TURNED, FAIR = "fresh dots", "turned", "atoms moved 0.3 Å"
MOST_BY_CHANCE = 0.95  # quantile of how many p are small where roughness plays no part
TARGET = 25.0  # % of uniform dots, whose Z the others are to reach


def answer(stored):
    """What came out, in three sentences."""
    return "\n\n".join((of_sign(stored), of_parameters(stored), of_dots(stored))) + "\n"


def of_sign(stored):
    """Whether d > 0 depends on the protein."""
    d, n = stored["d"], stored["surfaces"]["protein"].nunique()
    kept, surface = (d[(d["islands"] == reading)] for reading in (PUBLISHED, TEXT))
    a, b = (part[part["range"] == 0].iloc[0] for part in (kept, surface))
    few, not_all = below_half(kept), but_the_last(surface)
    each = few["n_above"].min()
    on = "every one" if each == n else f"{each:.0f} or more of them"
    most = not_all["n_above"].max()
    above = f"{most:.0f} at most" if most else "none"
    return (
        f"**The sign of d rests on the reading, not on the protein.** Over {n} proteins, the best combinations have, "
        f"held out, d = {between(few, 'own')} under `kept` in the ranges below half of the dots, above 0 by the protein's "
        f"own interval on {on}{of_many(kept)}; under `surface` d = {between(not_all, 'own')} in all ranges but the last, "
        f"which keeps every dot, above 0 on {above} (means over all ranges {interval(a, 'own')} and "
        f"{interval(b, 'own')}).{of_recovered(stored)}"
    )


def of_many(rows):
    """The ranges of n_S where uniform dots are the better ones, as a clause; nothing where there are none."""
    worse = rows[(rows["range"] > 0) & (rows["own_high"] < 0)]
    if worse.empty:
        return ""
    *some, last = (f"{percent:.0f}" for percent in worse["n_S_percent"])
    at = f"{', '.join(some)} and {last}" if some else last
    d = between(worse, "own") if some else signed(worse["own"].iloc[0])
    return f" (below 0, {d}, at n_S = {at} %)"


def of_recovered(stored):
    """d where the kept dots alone are made a surface again, as a sentence; nothing where it was not measured."""
    if "recovered" not in stored:
        return ""
    rows = stored["recovered"]
    whole, few, more = rows.iloc[0], rows.iloc[1], rows.iloc[2:]
    some = "" if whole["n"] == stored["d"]["n"].max() else f"{whole['n']:.0f} small proteins, "
    return (
        f" With the surface made again from the kept dots alone (`recovered`; {some}a quarter of the "
        f"grid), d = {interval(few, 'own')} on average at the fewest dots (n_S = {few['n_S_percent']:.1f} %) and "
        f"{between(more, 'own')} beyond (mean {interval(whole, 'own')})."
    )


def but_the_last(rows):
    """The ranges of n_S without the last, which keeps every dot."""
    return rows[(rows["range"] > 0) & (rows["range"] < rows["range"].max())]


def below_half(rows):
    """The ranges whose n_S lies below half of the dots."""
    return rows[(rows["range"] > 0) & (rows["n_S_percent"] < 50)]


def between(rows, name):
    """The smallest and the largest mean of some ranges, as text."""
    return f"{signed(rows[name].min())} to {signed(rows[name].max())}"


def of_parameters(stored):
    """Whether mean roughness, or the protein at all, has to be known."""
    d, power = stored["d"], stored["power"]
    some = d[(d["range"] == 0) & (d["islands"] == PUBLISHED)].iloc[0]
    known, found, certain, supported = counted(stored["relation"])
    most = d[d["range"] > 0].sort_values("near").iloc[-1]
    said = predicts(stored["relation"])
    return (
        f"**{said[0].upper()}{said[1:]}.** Of {known} ranges and readings whose winners vary, p < {SIGNIFICANT:g} in {found} "
        f"(chance gives {SIGNIFICANT * known:.0f}; {certain} once corrected for so many tests, and in {supported} of these a "
        f"choice by it pays), though a rank correlation of {power['rho'].min():.2f} is found in 80 % of studies of "
        f"{power['n'].max()} proteins. One combination per range, chosen on all other proteins, gives {signed(-some['lost'])} "
        f"({signed(-some['lost_high'])} to {signed(-some['lost_low'])}) more d under `kept` than a protein's own best, held "
        f"out, and a choice on those nearest in roughness instead gains at most {interval(most, 'near')} of d in any range: "
        "neither the protein nor its roughness need be known."
    )


def predicts(relation):
    """What mean roughness says of the best parameters, as a clause; `MOST_BY_CHANCE` separates a trace from nothing."""
    known, found, _, supported = counted(relation)
    if supported:
        return f"mean roughness predicts the best parameters in {supported} of {known} ranges and readings"
    if found > binom.ppf(MOST_BY_CHANCE, known, SIGNIFICANT):
        return "mean roughness tells too little of the best parameters to choose by it"
    return "mean roughness does not predict the best parameters"


def counted(relation):
    """How many ranges and readings have winners that vary, in how many of these p is small, in how many also after
    Bonferroni's correction for them all, and in how many of those near surfaces choose better than far ones and than all."""
    known = relation[relation["p"].notna()]
    certain = known[known["p"] * len(known) < SIGNIFICANT]
    return (
        len(known),
        int((known["p"] < SIGNIFICANT).sum()),
        len(certain),
        int(((certain["gain_low"] > 0) & (certain["over_all_low"] > 0)).sum()),
    )


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
        f"{fair['highest']:.1f} % over the proteins), as the molecule turned and its dots laid anew from "
        f"{turned['median']:.1f} % on ({turned['lowest']:.1f} "
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
    factor = f"{times['factor']:.1f} ({times['factor_low']:.1f} to {times['factor_high']:.1f})"
    return (
        f"**On every protein.** Over {n} proteins of {residues.min()} to {residues.max()} residues "
        f"([docs/proteins.md](docs/proteins.md)), {fair['median']:.1f} % of the dots, farthest-point ones, recovered, "
        "err as little as "
        f"atoms that moved by 0.3 Å (within a tenth; at most {fair['highest']:.1f} % on any protein), and the Z of "
        f"{TARGET:g} % uniform "
        f"dots as they are takes {factor} times fewer. Sampling by roughness beats a uniform draw under one reading "
        "of the paper "
        f"(d, mean over ten ranges of n_S: {interval(kept, 'own')}) and loses under the other "
        f"({interval(surface, 'own')}), whatever the protein. Its "
        f"{predicts(stored['relation'])}: one combination per n_S does for all."
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
