"""Independent random streams: one per purpose, named by conformation, combination and draw."""

from __future__ import annotations

import zlib

import numpy as np

DEFAULT_SEED = 20261120  # of studies, functions and commands alike


def stream(seed: int, *keys: int | str) -> np.random.Generator:
    """Return the independent random stream of one purpose.

    Parameters
    ----------
    seed : int
        The config's seed.
    *keys : int or str
        The purpose: conformation, combination, draw. Strings are hashed, so that a stream does not depend on what
        else is in the study.
    """
    spawn_key = tuple(zlib.crc32(key.encode()) if isinstance(key, str) else int(key) for key in keys)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=spawn_key)))
