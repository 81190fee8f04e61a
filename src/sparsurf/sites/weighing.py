"""Which differences between the numbers of two places count: weights learned from one protein in two forms.

weights.npz holds, over matching places of two forms of many proteins, the covariance of the differences (`within`) and
that of all places (`total`). Numbers are turned to where the second is largest compared with the first (Fisher's linear
discriminant), in units of the differences: distances are then small between two forms of one site.
"""

from functools import cache
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

from sparsurf import InputError
from sparsurf.sites.describing import SHAPE

WIDTH = 64  # numbers of a place that are compared
SHRINK = 0.5  # of the differences' covariance to its diagonal


@cache
def weights():
    """Arrays of weights.npz: channels, mean (C, K), within and total (C K, C K)."""
    with np.load(Path(__file__).with_name("weights.npz")) as file:
        return {key: file[key] for key in file.files}


def weighed(numbers, fields, learned=None):
    """Numbers of places in a space where distances tell places apart.

    Parameters
    ----------
    numbers : (P, C, K) float16, of the shape and of `fields`
    fields : tuple of str
    learned : dict, optional
        As `weights` gives them, and these by default.

    Returns
    -------
    (P, WIDTH) float32

    Raises
    ------
    InputError : a field without weights
    """
    mean, turn = (
        _discriminant((SHAPE, *fields)) if learned is None else discriminant((SHAPE, *fields), learned)
    )
    flat = numbers.reshape(len(numbers), -1).astype(np.float32)
    return (flat - mean.astype(np.float32)) @ turn.astype(np.float32)


@cache
def _discriminant(channels):
    return discriminant(channels, weights())


def discriminant(channels, learned):
    """Mean (C K,) and the matrix (C K, WIDTH) of the discriminant of some channels."""
    known = [str(each) for each in learned["channels"]]
    for channel in channels:
        if channel not in known:
            raise InputError(
                f"sites: {channel} has no weights; describe the sites by {', '.join(known[1:])}."
            )
    n = learned["mean"].shape[1]
    rows = np.concatenate([np.arange(n) + n * known.index(channel) for channel in channels])
    within, total = (learned[key].astype(float)[np.ix_(rows, rows)] for key in ("within", "total"))
    scale = np.sqrt(np.diag(total))
    within, total = within / np.outer(scale, scale), total / np.outer(scale, scale)
    within = (within + SHRINK * np.diag(np.diag(within))) / (1 + SHRINK)
    ratio, turn = eigh(total, within)
    ratio, turn = ratio[::-1][:WIDTH], turn[:, ::-1][:, :WIDTH]
    gain = np.sqrt(np.maximum(1 - 1 / ratio, 0))
    return learned["mean"].ravel()[rows], turn * gain / scale[:, None]


def learn(pairs, others, channels):
    """Weights from matching places.

    Parameters
    ----------
    pairs : (a, b), each (P, C, K): numbers of places and of the same places on another form
    others : (N, C, K), numbers of all places
    channels : sequence of C str

    Returns
    -------
    dict, see `weights`
    """
    a, b, every = (each.reshape(len(each), -1).astype(float) for each in (*pairs, others))
    within = (a - b).T @ (a - b) / (2 * len(a))
    return {
        "channels": np.array(channels), "mean": every.mean(axis=0).reshape(others.shape[1:]),
        "within": within, "total": np.cov(every.T),
    }  # fmt: skip
