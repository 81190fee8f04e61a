"""How much of a patch is left where all but its largest island of kept dots are removed (the reading `kept`).

Dots are linked within `d_link`, a distance chosen for the full surface. Whether the patches of a subset hold together depends on
the link in spacings of the kept dots, one over the root of their number per Å^2.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd
from numpy.typing import ArrayLike

from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.patches.readings import FULL_READING, KEPT_READING
from sparsurf.sampling.combination import PARAMETERS, Combination


def compare_islands(
    prepared: PreparedSurface, subsets: Sequence[np.ndarray], tests: np.ndarray, z_tot: np.ndarray | None
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Compare B subsets under `kept`: distances, dots in patches, and their share of the kept dots of each patch, (B, T) each.

    The kept dots of a patch are those of its island on the full surface. A patch without kept dots has no share (NaN).
    """
    _, z, (island, patch) = prepared.compare(subsets, tests, (KEPT_READING, FULL_READING), z_tot)
    return z[0], island, _share(island, patch)


def _share(island: np.ndarray, patch: np.ndarray) -> np.ndarray:
    """Divide the dots of islands by those of their patches; NaN where a patch has none."""
    return np.divide(island, patch, out=np.full(patch.shape, np.nan), where=patch > 0)


def link_over_spacing(link: float, n_kept: np.ndarray | float, area: float) -> np.ndarray | float:
    """Divide a link (Å) by the spacing of `n_kept` dots on a surface of `area` Å^2."""
    return link * np.sqrt(n_kept / area)


def measure_islands(
    prepared: PreparedSurface, combinations: ArrayLike, n_tests: int, draws: int
) -> pd.DataFrame:
    """Measure `link_over_spacing` and `share_in_island` of combinations, (K, 4), on the test dots and draws of the grid.

    The share is the median over draws and test dots.
    """
    combinations, tests = np.asarray(combinations, float), prepared.draw_tests(n_tests)
    drawn = [prepared.sampled_together(combinations, draw) for draw in range(draws)]
    subsets = [of_draw.subset(k) for k in range(len(combinations)) for of_draw in drawn]
    share = _share(*prepared.patch_sizes(subsets, tests, (KEPT_READING, FULL_READING)))
    n_kept = np.reshape([len(subset) for subset in subsets], (-1, draws)).mean(axis=1)
    return pd.DataFrame(
        {
            "link_over_spacing": link_over_spacing(prepared.patches.d_link, n_kept, prepared.area),
            "share_in_island": np.nanmedian(share.reshape(len(combinations), -1), axis=1),
        }
    )


def add_islands(
    ranges: pd.DataFrame, best: dict[str, Any], prepared: PreparedSurface, n_tests: int, draws: int
) -> pd.DataFrame:
    """Return ranges.csv with the columns of `measure_islands` of each winner, and write them into the winners of best.json."""
    winners = []
    for section in best.values():  # best.json also holds single numbers
        if isinstance(section, dict):
            winners += [row for row in section.values() if _has_combination(row)]
    chosen = pd.concat([ranges, pd.DataFrame(winners)])[PARAMETERS].dropna().drop_duplicates()
    measured = measure_islands(prepared, chosen, n_tests, draws)
    values = dict(zip(map(Combination._make, chosen.to_numpy()), measured.to_dict("records"), strict=True))
    for row in winners:
        row |= values[Combination.from_row(row)]
    found = [values.get(Combination.from_row(row), {}) for row in ranges.to_dict("records")]
    place = list(ranges).index("median_patch_size") + 1
    columns = pd.DataFrame(found, ranges.index, measured.columns)
    return pd.concat([ranges.iloc[:, :place], columns, ranges.iloc[:, place:]], axis=1)


def _has_combination(row: Any) -> bool:
    """Say whether a value of best.json is the row of a combination."""
    return isinstance(row, dict) and PARAMETERS[0] in row
