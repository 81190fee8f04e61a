"""Which numbers the functions and commands take: those of the config's schema."""

import argparse
import math
from numbers import Real
from typing import NamedTuple

from sparsurf import InputError
from sparsurf.surfaces.making import MOST_DENSITY


class Limits(NamedTuple):
    """Finite numbers above `low` (or from it on), at most `high`."""

    low: float
    high: float = math.inf
    whole: bool = False
    open_low: bool = True

    def hold(self, value):
        """Whether they allow a number; NaN and infinity never."""
        above = self.low < value or (value == self.low and not self.open_low)
        return above and value <= self.high and value < math.inf and (not self.whole or value % 1 == 0)

    @property
    def words(self):
        """What they allow."""
        number = f"a {'whole ' * self.whole}number"
        if self.high < math.inf:
            least = f"more than {self.low:g} and at most" if self.open_low else f"{self.low:g} to"
            return f"{number}, {least} {self.high if self.whole else f'{self.high:g}'}"
        return f"{number}, more than {self.low:g}" if self.open_low else f"{number}, {self.low:g} or more"

    def check(self, value, name, word=None):
        """The number that is given as `name`, a float or, of whole ones, an int; `word` is allowed as well.

        Raises
        ------
        InputError : no number, or one beyond the limits
        """
        if word is not None and isinstance(value, str) and value == word:
            return value
        if isinstance(value, bool) or not isinstance(value, Real) or not self.hold(value):
            either = "" if word is None else f"{word!r} or "
            raise InputError(f"{name} is {value!r}; it must be {either}{self.words}.")
        return int(value) if self.whole else float(value)

    def parse(self, text):
        """The number that an option of a command is given as text; argparse tells what it should be."""
        try:
            value = int(text) if self.whole else float(text)
        except ValueError:
            value = math.nan
        if not self.hold(value):
            raise argparse.ArgumentTypeError(f"{text!r} must be {self.words}")
        return value


LENGTH = Limits(0, 100)  # Å: R_patch, R_zernike, D_link
PROBE = Limits(0, 10)  # Å
DENSITY = Limits(0, MOST_DENSITY)  # dots per Å^2
PERCENT = Limits(0, 100)
ALPHA = Limits(0, 1)
EXPONENT = Limits(0, 1000, open_low=False)  # beta, gamma, delta
SEED = Limits(0, 2**64 - 1, whole=True, open_low=False)
TEST_DOTS = Limits(2, 1_000_000, whole=True, open_low=False)
