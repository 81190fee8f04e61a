"""Memory and time that jobs need, from the size of what they work on; they ask for more.

needs.csv holds a line per rule, as `evidence/measure_needs.py` writes it from the logs of runs (where `jobs` is 0: set
by hand, generously). The distances of a grid are counted from the config: they come on top where a job holds them all.
"""

import csv
import math
import os
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
BYTES_PER_TEST = 8  # of a sampling at a test dot: its distance and a uniform subset's, in single precision
WHILE_AVERAGED = 4  # copies of the distances of one reading beside all, while a mean gets its interval
DOTS_PER_TEST = 200  # where as many test dots are requested for as published
PAPERS = 20  # thousand dots of a surface like the paper's


def measured():
    """Rows of needs.csv by rule, the numbers as floats."""
    with open(TABLE, encoding="utf-8", newline="") as stream:
        rows = {row.pop("rule"): row for row in csv.DictReader(stream)}
    return {
        rule: {key: value if key == "unit" else float(value) for key, value in row.items()}
        for rule, row in rows.items()
    }


def needs(rule, size, share=1, besides=None):
    """Resources of a rule, `mem_mb` and `runtime` (minutes), as functions that Snakemake calls.

    Parameters
    ----------
    rule : str
    size : function of the wildcards that gives the size of the input in the unit of needs.csv
    share : part of the work that falls to one job; its memory is that of the whole input
    besides : function of the wildcards that gives memory, in MB, which does not follow from that size

    Returns
    -------
    dict
        Each attempt after a failure asks for twice the memory of the one before, and for as much more time.
    """
    row = measured()[rule]

    def mem_mb(wildcards, attempt):
        found = row["mb"] + row["mb_per_unit"] * size(wildcards) + (besides(wildcards) if besides else 0)
        return max(LEAST_MB, math.ceil(MARGIN * found / 100) * 100) * 2 ** (attempt - 1)

    def runtime(wildcards, attempt):
        seconds = row["seconds"] + row["seconds_per_unit"] * size(wildcards) * share
        return max(LEAST_MINUTES, math.ceil(SLOWER * seconds / 60)) * attempt

    return {"mem_mb": mem_mb, "runtime": runtime}


def is_small(rule, size):
    """Whether a job of a rule is done before a cluster would have begun it; `size` is a number in the unit of needs.csv."""
    row = measured()[rule]
    return row["seconds"] + row["seconds_per_unit"] * size <= FEW_SECONDS


def memory_of_grid(config, thousand_dots=PAPERS):
    """Bytes that the distances of one surface fill at the worst moment, when the grid becomes a table.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    thousand_dots : float, size of the surface; counts only where `test_dots` is 'published'
    """
    sampling, evaluation = config["sampling"], config["evaluation"]
    if not sampling.get("run", True):
        return 0
    tests = evaluation["test_dots"]
    tests = 1000 * thousand_dots / DOTS_PER_TEST if tests == "published" else tests
    combinations = math.prod(len(sampling[parameter]) for parameter in ("alpha", "beta", "gamma", "delta"))
    of_one_reading = BYTES_PER_TEST * combinations * evaluation["draws"] * tests
    return of_one_reading * (len(evaluation["readings"]) + WHILE_AVERAGED)


def too_large(config):
    """Sentences, none or one, on a grid that asks for more memory than this machine has."""
    needed, there = memory_of_grid(config), memory_of_machine()
    if needed > there:
        yield (
            f"sampling and evaluation ask for {needed / 2**30:.1f} GB of memory (combinations x draws x test_dots x "
            f"islands), but this machine has {there / 2**30:.1f} GB; lower one of them."
        )


def limit():
    """Option of Snakemake, none or one: jobs run side by side as far as the memory of this machine reaches.

    One that asks for more than there is runs alone; a user's own `--resources`, behind it, takes its place.
    """
    there = memory_of_machine()
    return [f"--resources=mem_mb={there / 1e6:.0f}"] if there < math.inf else []


def memory_of_machine():
    """Bytes of memory of this machine; infinite where the system does not tell."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, ValueError, OSError):
        return math.inf


def megabytes(paths):
    """Size of files in MB, unpacked; 0 for those that are not there yet."""
    found = [Path(path) for path in paths if Path(path).is_file()]
    return sum(path.stat().st_size * (PACKED if path.suffix == ".gz" else 1) for path in found) / 1e6


def held(files, stride):
    """Size in MB of the files of a molecule of which jobs hold every `stride`-th frame; all models of a structure are read."""
    return sum(megabytes([path]) / (stride if key == "trajectory" else 1) for key, path in files.items())


def thousand_dots(paths, of_dots):
    """Dots in thousands of a file of dots, or of the surface of a structure file, from their sizes."""
    dots = (
        megabytes(paths) * 1e6 / BYTES_PER_DOT
        if of_dots
        else megabytes(paths) * 1e6 / BYTES_PER_ATOM * DOTS_PER_ATOM
    )
    return dots / 1000
