"""The metric that compares the descriptors of two places, learned from proteins in two forms.

weights.npz contains two covariances for many proteins in two forms: that of the differences between matching places
(`within`) and that of all places (`total`). Fisher's linear discriminant projects the descriptors onto the directions with the
largest ratio of the second to the first, in units of the differences. Distances between two forms of one site are then small.
"""

from __future__ import annotations

import zlib
from collections.abc import Sequence
from functools import cache
from pathlib import Path

import numpy as np
from scipy.linalg import eigh

from sparsurf import InputError
from sparsurf.sites.describing import SHAPE

N_COMPONENTS = 64  # discriminant components that are compared
STEPS_PER_UNIT = (
    8  # of quantised components: rounding moves a place by about 0.3, and unrelated places are 10 apart
)
ROWS_AT_ONCE = 16384  # places that are transformed at a time, in 28 MB
SHRINKAGE = 0.5  # of the covariance of the differences towards its diagonal


@cache
def weights() -> dict[str, np.ndarray]:
    """Read weights.npz.

    Returns
    -------
    dict : channels (C,) str, mean (C, K), within and total (C K, C K) float
    """
    with np.load(Path(__file__).with_name("weights.npz")) as file:
        return {key: file[key] for key in file.files}


def to_metric_space(
    numbers: np.ndarray, fields: Sequence[str], learned: dict[str, np.ndarray] | None = None
) -> np.ndarray:
    """Transform descriptors into the space in which Euclidean distances distinguish sites.

    Parameters
    ----------
    numbers : (P, C, K) float16, descriptors of the shape and of `fields`
    fields : sequence of str
    learned : dict, optional
        Learned weights; those of `weights` by default.

    Returns
    -------
    (P, N_COMPONENTS) float64

    Raises
    ------
    InputError : a field has no weights
    """
    channels = (SHAPE, *fields)
    mean, rotation = _shipped_discriminant(channels) if learned is None else discriminant(channels, learned)
    out = np.empty((len(numbers), rotation.shape[1]))
    for begin in range(0, len(numbers), ROWS_AT_ONCE):
        block = slice(begin, begin + ROWS_AT_ONCE)
        out[block] = (numbers[block].reshape(len(out[block]), -1).astype(float) - mean) @ rotation
    return out


@cache
def _shipped_discriminant(channels: tuple[str, ...]) -> tuple[np.ndarray, np.ndarray]:
    """Compute the discriminant of the shipped weights once per choice of channels."""
    return discriminant(channels, weights())


def discriminant(channels: Sequence[str], learned: dict[str, np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Compute Fisher's linear discriminant of some channels.

    Parameters
    ----------
    channels : sequence of C str
    learned : dict, see `weights`

    Returns
    -------
    mean : (C K,) float
    rotation : (C K, N_COMPONENTS) float64

    Raises
    ------
    InputError : a channel has no weights
    """
    known = [str(channel) for channel in learned["channels"]]
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
    within = (within + SHRINKAGE * np.diag(np.diag(within))) / (1 + SHRINKAGE)
    ratio, rotation = eigh(total, within)
    ratio, rotation = ratio[::-1][:N_COMPONENTS], rotation[:, ::-1][:, :N_COMPONENTS]
    largest = np.abs(rotation).argmax(axis=0)  # an eigenvector has no sign of its own: libraries differ in it
    rotation = rotation * np.sign(rotation[largest, np.arange(rotation.shape[1])])
    gain = np.sqrt(np.maximum(1 - 1 / ratio, 0))
    return learned["mean"].ravel()[rows], rotation * gain / scale[:, None]


def quantise(components: np.ndarray) -> np.ndarray:
    """Round components of the metric space to steps of 1 / STEPS_PER_UNIT, a byte each.

    Parameters
    ----------
    components : (P, M) float

    Returns
    -------
    (P, M) int8, -127 to 127; components beyond become these, 1 of 2,000
    """
    return np.clip(np.rint(components * STEPS_PER_UNIT), -127, 127).astype(np.int8)


def fingerprint() -> int:
    """Return a checksum of weights.npz: quantised components of other weights cannot be compared."""
    return zlib.crc32(Path(__file__).with_name("weights.npz").read_bytes())


def learn_weights(
    pairs: tuple[np.ndarray, np.ndarray], others: np.ndarray, channels: Sequence[str]
) -> dict[str, np.ndarray]:
    """Learn weights from matching places.

    Parameters
    ----------
    pairs : (a, b), each (P, C, K)
        Descriptors of places, and of the same places on another form.
    others : (N, C, K), descriptors of all places
    channels : sequence of C str

    Returns
    -------
    dict, see `weights`
    """
    a, b, pooled = (numbers.reshape(len(numbers), -1).astype(float) for numbers in (*pairs, others))
    within = (a - b).T @ (a - b) / (2 * len(a))
    return {
        "channels": np.array(channels), "mean": pooled.mean(axis=0).reshape(others.shape[1:]),
        "within": within, "total": np.cov(pooled.T),
    }  # fmt: skip
