"""Independent random streams: one per purpose, named by conformation, combination and draw."""

from __future__ import annotations

import zlib
from dataclasses import dataclass

import numpy as np

from sparsurf.arguments import DEFAULT_SEED


def stream(seed: int, *keys: int | str) -> np.random.Generator:
    """Return the independent random stream of one purpose: the config's seed, then conformation, combination, draw."""
    spawn_key = tuple(zlib.crc32(key.encode()) if isinstance(key, str) else int(key) for key in keys)
    return np.random.Generator(np.random.SFC64(np.random.SeedSequence(seed, spawn_key=spawn_key)))


@dataclass(frozen=True)
class Streams:
    """Random streams of one surface; `shared` ones do not depend on its name, which messages keep."""

    seed: int = DEFAULT_SEED
    name: str = ""
    shared: bool = False

    def __call__(self, *keys: int | str) -> np.random.Generator:
        """Return the random stream of one purpose."""
        return stream(self.seed, "" if self.shared else self.name, *keys)
