"""Decide whether a study is analysed in batches, and which structure is in which; planning imports this, so it needs no numpy."""

import os
import zlib
from collections.abc import Mapping
from typing import Any

# Folders of a run, with a file for each batch
BATCH_FOLDERS = ("surfaces", "residues", "dots", "failures", "warnings")
MAX_STUDIED = 10  # structures without a grid; a study of more is analysed in batches
# Share of the dots, where structures are analysed in batches and `minimal` requests nothing: an error,
# which a study requests by default, would be measured on every structure
BATCH_PERCENT = 10
# A protein with one of these is no structure alone.
OTHER_SOURCES = {"surface", "trajectory", "simulate", "url", "pdb"}
BATCH_BYTES = 8_000_000  # A batch has so much of uncompressed PDB files, a minute or two of CPU time.
GZIP_FACTOR = 4  # a PDB file is about this much larger than its .gz
CIF_FACTOR = 0.7  # a PDB file is about this much of an mmCIF file with the same atoms


def batched_structures(config: Mapping[str, Any]) -> list[str]:
    """Return the structures of a checked config in batches: all if `pages` leaves any out, or more than `MAX_STUDIED` without."""
    names = [name for name in config["proteins"] if name not in config["exclude"]]
    if config["sampling"]["run"] or not takes_batches(config):
        return []
    pages = config.get("pages", names if len(names) <= MAX_STUDIED else [])
    return names if {*names} - {*pages} else []


def takes_batches(config: Mapping[str, Any]) -> bool:
    """Return whether each protein of a checked config is a structure that is analysed alone."""
    together = config["pairs"] or config["changes"] or config["ensemble"]["run"] or config["compare"]["run"]
    alone = all(OTHER_SOURCES.isdisjoint(entry) for entry in config["proteins"].values())
    sampled = any(entry.get("sampling") for entry in config["proteins"].values())
    return alone and not (together or sampled or "paper" in config)


def batches_of(config: Mapping[str, Any]) -> dict[str, list[str]]:
    """Return the batches of a checked config, see `assign_batches`; none where it does not ask for any."""
    structures = {name: config["proteins"][name]["structure"] for name in batched_structures(config)}
    return assign_batches({name: size_as_pdb(path) for name, path in structures.items()})


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


def assign_batches(sizes: Mapping[str, float]) -> dict[str, list[str]]:
    """Assign structures to batches by a hash of their names: sorted names by the name of the batch, '0001', ...

    The number of batches is a power of two, by the `sizes` in bytes. A structure that is added, removed or replaced changes its
    own batch only, unless that number changes.
    """
    needed, n_batches = sum(sizes.values()) / BATCH_BYTES, 1
    while n_batches < needed:
        n_batches *= 2
    batches: dict[str, list[str]] = {}
    for name in sorted(sizes):
        # Not `hash`, which differs between two runs of Python
        number = zlib.crc32(name.encode()) % n_batches + 1
        batches.setdefault(f"{number:04d}", []).append(name)
    return dict(sorted(batches.items()))
