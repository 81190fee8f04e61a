"""Which structure belongs to which batch; planning a study imports this, so it needs no numpy."""

import os
import zlib
from collections.abc import Mapping
from typing import Any

TABLES = ("surfaces", "residues", "dots", "failures", "warnings")  # folders of a run, a file for each batch
BATCH_BYTES = 8_000_000  # of uncompressed PDB files, a minute or two of CPU time
GZIP_FACTOR = 4  # a PDB file is about this much larger than its .gz
CIF_FACTOR = 0.7  # a PDB file is about this much of an mmCIF file with the same atoms


def batches_of(config: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the batches of a checked config, see `assign_batches`; none where it does not ask for any."""
    if "batch" not in config:
        return {}
    structures = {name: entry["structure"] for name, entry in config["proteins"].items()}
    sizes = {name: size_as_pdb(path) for name, path in structures.items() if name not in config["exclude"]}
    return assign_batches(sizes, config["batch"])


def size_as_pdb(path: str | os.PathLike[str]) -> float:
    """Estimate the size of a structure as an uncompressed PDB file, bytes; 0 for a file that is missing."""
    name = os.fspath(path).lower()
    try:
        size = float(os.path.getsize(path))
    except OSError:
        return 0.0
    if name.endswith(".gz"):
        name, size = name[:-3], GZIP_FACTOR * size
    return size * CIF_FACTOR if name.endswith("cif") else size


def assign_batches(sizes: Mapping[str, float], batch: str | int = "auto") -> dict[str, list[str]]:
    """Assign structures to batches by a hash of their names: sorted names by the name of the batch, '0001', ...

    A structure that is added, removed or replaced changes its own batch only, unless the number of batches changes. For `auto`
    that is a power of two, so it rarely does.

    `sizes` are in bytes; `batch` is the mean number of structures in a batch, or 'auto' for about `BATCH_BYTES` of structures.
    """
    if batch == "auto":
        needed = sum(sizes.values()) / BATCH_BYTES
        n_batches = 1
        while n_batches < needed:
            n_batches *= 2
    else:
        n_batches = -(-len(sizes) // int(batch))
    batches: dict[str, list[str]] = {}
    for name in sorted(sizes):
        number = zlib.crc32(name.encode()) % n_batches + 1
        batches.setdefault(f"{number:04d}", []).append(name)
    return dict(sorted(batches.items()))
