"""What the two readings of the removal of islands say of the same combinations."""

import numpy as np

from sparsurf.patches.readings import PUBLISHED, TEXT

SHATTERED = 0.3  # share of a patch's kept dots below which Z measures how the subset breaks up


def correlation(table):
    """Correlation over the grid of d under both readings."""
    return float(np.corrcoef(table[f"d_{PUBLISHED}"], table[f"d_{TEXT}"])[0, 1])


def correlation_by_tenths(table, tenths=10):
    """The same within tenths of the combinations by n_S: (tenths,) float64; n_S is no cause of it there."""
    order = np.argsort(table["n_S_percent"].to_numpy(), kind="stable")
    parts = np.array_split(order, min(tenths, max(len(table) // 3, 1)))
    return np.array([correlation(table.iloc[part]) for part in parts])


def follows_fragments(table):
    """Correlation of d under the published reading with the logarithm of how much larger the patches stay."""
    larger = np.log(table[f"fragment_{PUBLISHED}"] / table[f"fragment_uniform_{PUBLISHED}"])
    return float(np.corrcoef(table[f"d_{PUBLISHED}"], larger)[0, 1])


def shattered(table):
    """Share of the combinations whose median patch holds little of its kept dots under the published reading."""
    return float((table[f"fragment_{PUBLISHED}"] < SHATTERED * table[f"fragment_{TEXT}"]).mean())
