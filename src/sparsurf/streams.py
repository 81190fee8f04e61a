"""Independent random streams: one per purpose, named by conformation, combination and draw."""

import zlib

import numpy as np


def stream(seed, *keys):
    """Independent random stream for one purpose.

    Parameters
    ----------
    seed : int
        The config's seed.
    keys : int or str
        What the stream is for: conformation, combination, draw. Texts are hashed, so a stream
        does not depend on what else is in the study.

    Returns
    -------
    numpy.random.Generator
    """

    spawn = tuple(zlib.crc32(k.encode()) if isinstance(k, str) else int(k) for k in keys)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=spawn)))
