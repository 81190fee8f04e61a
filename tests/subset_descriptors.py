"""The descriptors of subsets, of which the library gives distances only, in the order of the kernel."""

import numpy as np

from sparsurf.patches import descriptors


def evaluate(
    index,
    tests,
    words,
    n_subsets,
    reading,
    weights=None,
    radius=6.0,
    up=True,
    threads=1,
    descriptor="published",
):
    """Descriptors (T, B, width) and numbers of dots (T, B) of the patches of B subsets at `tests`."""
    kind = descriptors.descriptor_of(descriptor)
    out = np.empty((len(tests), n_subsets, kind.width))

    def store(a, b, z):
        out[a:b] = z.reshape(b - a, n_subsets, -1)

    sizes = descriptors._describe_slices(
        kind, index, tests, words, n_subsets, (reading,), False, radius, up, threads, weights, store
    )
    return out, sizes
