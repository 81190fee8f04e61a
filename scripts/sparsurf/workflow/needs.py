"""Memory and time that jobs ask a cluster for, from the size of what they work on.

needs.csv holds a line per rule, as `scripts/measure_needs.py` writes it from the logs of runs (without a column `jobs`: set
by hand, generously). A job asks for more, and after a failure for more again.
"""

import csv
import math
from pathlib import Path

TABLE = Path(__file__).with_name("needs.csv")
MARGIN = 1.5  # of memory, over what was measured
SLOWER = 4  # of time: other machines, a busy file system
FEW_SECONDS = 20  # of a job that is not worth a place in a queue
LEAST_MB, LEAST_MINUTES = 1000, 10  # of every job; Snakemake itself has its part in it
PACKED = 4  # a gzip unpacks to this many times its size, about
BYTES_PER_ATOM = 81  # of a PDB or mmCIF file, about
DOTS_PER_ATOM = 30  # with hydrogens; without them a few more
BYTES_PER_DOT = 60  # of a file of dots


def measured():
    """Rows of needs.csv by rule, the numbers as floats."""
    with open(TABLE, encoding="utf-8", newline="") as stream:
        rows = {row.pop("rule"): row for row in csv.DictReader(stream)}
    return {
        rule: {key: value if key == "unit" else float(value) for key, value in row.items()}
        for rule, row in rows.items()
    }


def needs(rule, size, share=1):
    """Resources of a rule, `mem_mb` and `runtime` (minutes), as functions that Snakemake calls.

    Parameters
    ----------
    rule : str
    size : function of the wildcards that gives the size of the input in the unit of needs.csv
    share : part of the work that falls to one job; its memory is that of the whole input

    Returns
    -------
    dict
        Each attempt after a failure asks for twice the memory of the one before, and for as much more time.
    """
    row = measured()[rule]

    def mem_mb(wildcards, attempt):
        found = row["mb"] + row["mb_per_unit"] * size(wildcards)
        return max(LEAST_MB, math.ceil(MARGIN * found / 100) * 100) * 2 ** (attempt - 1)

    def runtime(wildcards, attempt):
        seconds = row["seconds"] + row["seconds_per_unit"] * size(wildcards) * share
        return max(LEAST_MINUTES, math.ceil(SLOWER * seconds / 60)) * attempt

    return {"mem_mb": mem_mb, "runtime": runtime}


def is_small(rule, size):
    """Whether a job of a rule is done before a cluster would have begun it; `size` is a number in the unit of needs.csv."""
    row = measured()[rule]
    return row["seconds"] + row["seconds_per_unit"] * size <= FEW_SECONDS


def megabytes(paths):
    """Size of files in MB, unpacked; 0 for those that are not there yet."""
    found = [Path(path) for path in paths if Path(path).is_file()]
    return sum(path.stat().st_size * (PACKED if path.suffix == ".gz" else 1) for path in found) / 1e6


def thousand_dots(paths, of_dots):
    """Dots in thousands of a file of dots, or of the surface of a structure file, from their sizes."""
    dots = (
        megabytes(paths) * 1e6 / BYTES_PER_DOT
        if of_dots
        else megabytes(paths) * 1e6 / BYTES_PER_ATOM * DOTS_PER_ATOM
    )
    return dots / 1000
