"""Which residues are ranked, and how much each changes over the frames of a trajectory."""

from collections.abc import Callable, Iterable, Iterator

import numpy as np
import pandas as pd

MIN_AREA = 20.0  # Å^2: the mean over a smaller surface rests on few dots
MIN_SHARE_OF_FRAMES = 0.5
NONE_RANKED = (
    f"no residue has at least {MIN_AREA:g} Å^2 of surface and a value in at least half of the frames"
)


def is_ranked(
    area: np.ndarray | pd.Series, n_values: np.ndarray | int = 1, n_frames: int = 1
) -> np.ndarray | pd.Series:
    """Return which residues are ranked, (R,) bool: those with enough surface, Å^2 in the mean, and a value in enough frames."""
    return (area >= MIN_AREA) & (np.asarray(n_values) >= MIN_SHARE_OF_FRAMES * n_frames)


def rank_residues(
    residues: pd.DataFrame,
    quantity: str,
    statistic: str,
    values: Callable[[], Iterable[tuple[np.ndarray, np.ndarray]]],
) -> pd.DataFrame:
    """Tabulate how a quantity of residues changes over frames: the ranked residues by their change, then the others.

    `values` yields the numbers of consecutive frames, (n, R) float64 with NaN where a residue has none, and the areas of the
    residues, (n, R) in Å^2. It is called twice, so that not all frames need be in memory. A mean over dots counts in the frames
    in which the residue has MIN_AREA. `statistic` is the column that orders: 'sd', the standard deviation, or 'range'. Residues
    that do not change, or that `is_ranked` leaves out, have no `rank` and follow in the order of `residues`; the index is the
    position of each residue there.
    """
    n, n_frames, is_mean = len(residues), 0, quantity.startswith("mean_")

    def counted() -> Iterator[tuple[np.ndarray, np.ndarray]]:
        """Yield the numbers that count, and the areas."""
        for block, areas in values():
            yield np.where(areas >= MIN_AREA, block, np.nan) if is_mean else block, areas

    count, total, squares, area = np.zeros((4, n))
    lowest, highest = np.full((2, n), np.nan)
    for block, areas in counted():
        n_frames += len(block)
        count += np.isfinite(block).sum(axis=0)
        total += np.nansum(block, axis=0)
        area += areas.sum(axis=0)
        lowest = np.fmin(lowest, np.fmin.reduce(block))
        highest = np.fmax(highest, np.fmax.reduce(block))
    with np.errstate(invalid="ignore", divide="ignore"):
        mean = total / count
        for block, _ in counted():
            squares += np.nansum((block - mean) ** 2, axis=0)
        sd = np.sqrt(np.where(count > 1, squares / (count - 1), np.nan))
    mean_area = area / max(n_frames, 1)
    table = residues.assign(
        quantity=quantity,
        frames=count.astype(int),
        mean=mean,
        sd=sd,
        lowest=lowest,
        highest=highest,
        range=highest - lowest,
        mean_area=mean_area,
    )
    changing = is_ranked(np.where(is_mean, MIN_AREA, mean_area), count, n_frames) & (highest > lowest)
    order = np.argsort(-table[statistic].where(changing).to_numpy(), kind="stable")  # NaN comes last
    ranks = pd.Series(range(1, n + 1), dtype="Int64").where(changing[order])
    return table.iloc[order].assign(rank=ranks.to_numpy())


def why_none_is_ranked(ranking: pd.DataFrame, n_frames: int) -> str:
    """Say why no residue of a table of `rank_residues` is ranked; empty if one is."""
    if ranking["rank"].notna().any():
        return ""
    if n_frames == 1:
        return "one frame shows no change; give a trajectory, or a file with several models"
    is_constant = ranking["range"].max() == 0
    return "no residue changes from frame to frame" if is_constant else NONE_RANKED
