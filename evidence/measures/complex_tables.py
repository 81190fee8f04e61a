"""Tables of the study of many complexes, from the measurements of each."""

import numpy as np
import pandas as pd

from sparsurf.pairs.complex_scores import KEYS
from sparsurf.pairs.complexes import chosen_on_few, means_over_complexes

FEW = 10  # complexes, the first by name, on which variants are chosen, with 1a1u
TUTORIAL = "1a1u"
REFERENCES = ("flatness", "planarity", "protrusion", "hydropathy", "centroid")


def named(areas: pd.DataFrame) -> pd.DataFrame:
    """Add the column `group` to the areas.

    Groups: 'tutorial' (1a1u), 'bound' (complexes known bound only), 'bound six' and 'unbound six' (those with both).
    """
    both = set(areas.loc[areas["form"] == "unbound", "complex"])
    in_both = areas["complex"].isin(both)
    group = np.where(areas["complex"] == TUTORIAL, "tutorial", "bound")
    return areas.assign(group=np.where(in_both, areas["form"] + " six", group))


def surfaces(areas: pd.DataFrame) -> pd.DataFrame:
    """Return a row per surface and main score, with its interval: the maps as published and the references."""
    main = areas[areas["low"].notna() & ~areas["score"].str.contains("+", regex=False)]
    columns = [
        "complex",
        "form",
        "side",
        "descriptor",
        "score",
        "map",
        "auc",
        "low",
        "high",
        "patches",
        "interface",
    ]
    return main[columns].drop_duplicates(columns[:6]).reset_index(drop=True)


def means(areas: pd.DataFrame) -> pd.DataFrame:
    """Return the mean AUC over the complexes of each group for the maps at their first radius and the references."""
    first = areas.groupby(areas["descriptor"].str.split(",").str[0])["descriptor"].transform("first")
    plain = (areas["k"] == 1) & (areas["kind"] == "plain") & (areas["descriptor"] == first)
    wanted = areas[plain | areas["score"].isin(REFERENCES)]
    wanted = wanted.drop_duplicates(["complex", "form", "side", *KEYS])
    return means_over_complexes(wanted, ["group", "descriptor", "score", "map"])


def variants(areas: pd.DataFrame, few: int = FEW) -> pd.DataFrame:
    """Return variants chosen on 1a1u and the first `few` complexes by name, reported on the other bound ones."""
    bound = areas[areas["group"].isin(["tutorial", "bound"])].drop_duplicates(["complex", "side", *KEYS])
    names = sorted(set(bound["complex"]) - {TUTORIAL})
    return chosen_on_few(bound, KEYS, {TUTORIAL, *names[:few]})


def touching(contacts: pd.DataFrame, group: pd.Series) -> pd.DataFrame:
    """Return the mean chance that a native pair of patches is nearer than a random one, over complexes.

    Parameters
    ----------
    contacts : DataFrame of complex, descriptor, against, auc
    group : Series, complex -> group
    """
    return means_over_complexes(
        contacts.assign(group=contacts["complex"].map(group)), ["descriptor", "group", "against"]
    )


def control(controls: pd.DataFrame) -> pd.DataFrame:
    """Return the correlation of the smoothed map with that against another complex's partner, over bound complexes."""
    bound = controls[(controls["form"] == "bound") & controls["correlation_1"].notna()]
    long = bound.melt(["complex", "descriptor"], ["correlation_1", "correlation_2"], value_name="correlation")
    return means_over_complexes(long, ["descriptor"], "correlation")


def tables_of(
    areas: pd.DataFrame, contacts: pd.DataFrame, controls: pd.DataFrame, few: int = FEW
) -> dict[str, pd.DataFrame]:
    """Return all tables: dict, name -> DataFrame.

    Parameters
    ----------
    areas, contacts, controls : DataFrames of evidence/measure_complex.py, of one descriptor after the other
    few : int, see `variants`
    """
    areas = named(areas)
    group = areas.drop_duplicates("complex").set_index("complex")["group"]
    return {
        "complexes": surfaces(areas),
        "complexes_means": means(areas),
        "complexes_variants": variants(areas, few),
        "complexes_contacts": touching(contacts, group),
        "complexes_control": control(controls),
    }
