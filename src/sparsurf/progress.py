"""A bar for what takes long: of tqdm where that is installed, else a line on a terminal."""

import sys
import time
import warnings

QUIET = 2.0  # s; what ends before needs no bar
EVERY = 0.2  # s between two changes of the line
shown = (
    False  # only the command line and the functions of Python turn it on: jobs of a study share a terminal
)


def each(items, words, total=None):
    """Iterate over items, telling a person how far it is.

    Parameters
    ----------
    items : iterable
    words : str, what is done
    total : int, number of items where they cannot be counted
    """
    total = len(items) if total is None else total
    if not shown or total < 2:
        return items
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of a notebook without widgets, which gets a plain bar
            from tqdm.auto import tqdm
    except ImportError:
        return _line(items, words, total) if sys.stderr.isatty() else items
    return tqdm(
        items,
        words,
        total,
        leave=False,
        delay=QUIET,
        disable=None if "ipykernel" not in sys.modules else False,
    )


def _line(items, words, total):
    """The items; a line on standard error says which part of them is done, and goes when all are."""
    begin = last = time.monotonic()
    for k, item in enumerate(items):
        now = time.monotonic()
        if now - begin > QUIET and now - last > EVERY:
            print(f"\r{words}: {100 * k // total} %", end="", file=sys.stderr, flush=True)
            last = now
        yield item
    if last != begin:
        print("\r" + " " * (len(words) + 7) + "\r", end="", file=sys.stderr, flush=True)
