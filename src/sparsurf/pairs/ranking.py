"""How well a value at every dot tells the interface from the rest: area under the ROC curve, with its interval."""

import numpy as np

BLOCK = 10.0  # Å between the middles of the blocks that are drawn together
DRAWS = 500  # of the bootstrap


def auc(score, positive, weight=None):
    """Area under the ROC curve: the chance that a dot of the interface scores higher than one outside it.

    Parameters
    ----------
    score : (n,) float64
    positive : (n,) bool
    weight : (n,) or (B, n) float64, optional
        How often each dot counts; with B rows, B areas.

    Returns
    -------
    float or (B,) float64; ties count half; NaN where one of the two classes is empty.
    """
    weight = np.ones(len(score)) if weight is None else np.asarray(weight, np.float64)
    order = np.argsort(score, kind="stable")
    value, w = np.asarray(score)[order], np.atleast_2d(weight)[:, order]
    begin = np.flatnonzero(np.diff(value, prepend=np.nan) != 0)  # of each run of equal values
    inside = np.add.reduceat(w * positive[order], begin, axis=1)
    outside = np.add.reduceat(w * ~positive[order], begin, axis=1)
    below = np.cumsum(outside, axis=1) - outside / 2
    with np.errstate(invalid="ignore"):
        area = (inside * below).sum(axis=1) / (inside.sum(axis=1) * outside.sum(axis=1))
    return area if weight.ndim == 2 else float(area[0])


def blocks_of_residues(points, residue, length=BLOCK):
    """Blocks of neighbouring residues, the units that a bootstrap draws.

    A map smoothed over 6 Å is alike over about twice that, so single dots or residues would count one piece of
    evidence many times. Middles of residues are taken, each the farthest from those before, until all lie within
    `length` of one; every residue joins the nearest.

    Parameters
    ----------
    points : (n, 3) float64, Å
    residue : (n,) int, the residue of each dot
    length : float, Å

    Returns
    -------
    (n,) int64, number of the block of each dot, from 0
    """
    _, place, count = np.unique(residue, return_inverse=True, return_counts=True)
    middle = np.stack([np.bincount(place, points[:, c]) for c in range(3)], axis=1) / count[:, None]
    gap, block, n_blocks = np.full(len(middle), np.inf), np.zeros(len(middle), np.int64), 0
    while gap.max() > length:
        new = np.linalg.norm(middle - middle[np.argmax(gap)], axis=1)
        block[new < gap] = n_blocks
        gap, n_blocks = np.minimum(gap, new), n_blocks + 1
    return block[place]


def bootstrap_auc(scores, positive, block, rng, draws=DRAWS):
    """Areas of several scores with an interval from drawing whole blocks with replacement.

    Parameters
    ----------
    scores : dict, name -> (n,) float64
        The draws are the same for all scores, so that their differences can be judged too.
    positive : (n,) bool
    block : (n,) int, from 0
    rng : numpy.random.Generator
    draws : int

    Returns
    -------
    dict, name -> (area, low, high): the 2.5 and 97.5 percentiles over the draws that have both classes; NaN of a single block.
    """
    n_blocks = int(block.max()) + 1
    times = rng.multinomial(n_blocks, np.full(n_blocks, 1 / n_blocks), size=draws)
    out = {}
    for name, score in scores.items():
        known = ~np.isnan(score)
        drawn = auc(score[known], positive[known], times[:, block[known]].astype(np.float64))
        drawn = drawn[~np.isnan(drawn)]
        scatters = n_blocks > 1 and len(drawn)  # draws of one block are all the same: they tell of no scatter
        low, high = np.percentile(drawn, [2.5, 97.5]) if scatters else (np.nan, np.nan)
        out[name] = (auc(score[known], positive[known]), float(low), float(high))
    return out
