"""Sentences on both halves of the claim behind Figure 4: rough patches gain, plane ones are equally well reconstructed."""

from sparsurf.patches.readings import OF_GRID
from sparsurf.study.rough_and_flat import FEWEST

HALVES = ("rougher half", "flatter half")


def claims(bins):
    """Both halves of the claim, for patches around kept dots (as the paper has them) and around any dots.

    Parameters
    ----------
    bins : DataFrame
        `rough_and_flat.bins_table` of both, one below the other, with the column `around`.
    """
    out = []
    for around, own in bins.groupby("around", sort=False):
        for reading in OF_GRID:
            rough, flat = (own[own["bin"] == name].iloc[0] for name in HALVES)
            single = own[~own["bin"].isin(HALVES) & (own["n"] >= FEWEST)]
            flattest = single.iloc[-1]
            out.append(
                f"Patches around {around}, `{reading}`: d is {_value(rough, reading)} in the rougher half of the bins and "
                f"{_value(flat, reading)} in the flatter half: {_more(rough, flat, reading)}; in the flattest bin (R_i from "
                f"{flattest['roughness_low']:.2f} on) {_value(flattest, reading)}: {_equal(flattest, reading)}."
            )
    return out


def _value(row, reading):
    return f"{row[f'd_{reading}']:.2f} ({row[f'd_low_{reading}']:.2f} .. {row[f'd_high_{reading}']:.2f})"


def _more(rough, flat, reading):
    """Rough against flat, certain where the intervals are apart."""
    d, other = rough[f"d_{reading}"], flat[f"d_{reading}"]
    apart = (
        rough[f"d_low_{reading}"] > flat[f"d_high_{reading}"]
        or rough[f"d_high_{reading}"] < flat[f"d_low_{reading}"]
    )
    if not apart:
        return "no difference for certain"
    if max(d, other) < 0:
        return f"both lose, rough patches {'less' if d > other else 'more'}"
    return f"rough patches gain {'more' if d > other else 'less'}"


def _equal(row, reading):
    if row[f"d_low_{reading}"] <= 0 <= row[f"d_high_{reading}"]:
        return "sampled and uniform dots cannot be told apart there"
    share = abs(row[f"d_{reading}"]) / row[f"Z_tR_{reading}"]
    return f"not equal, {100 * share:.0f} % of Z_tR"
