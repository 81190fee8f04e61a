"""One choice of the four parameters of the paper's sampling, and its text and numbers."""

from typing import NamedTuple

SEPARATOR = "; "  # between combinations in one field of a table


class Combination(NamedTuple):
    """alpha, beta, gamma and delta of the paper's eq. 2; as text, (1, 0, 6, 0)."""

    alpha: float
    beta: float
    gamma: float
    delta: float

    def __str__(self):
        return "(" + ", ".join(f"{p:g}" for p in self) + ")"

    @classmethod
    def of(cls, row):
        """From anything with the keys alpha, beta, gamma and delta: a row of a table, a dict."""
        return cls(*(float(row[name]) for name in cls._fields))

    @classmethod
    def parse(cls, text):
        """From its text.

        Raises
        ------
        ValueError : not four numbers in brackets
        """
        values = [float(part) for part in text.strip().removeprefix("(").removesuffix(")").split(",")]
        if len(values) != len(cls._fields):
            raise ValueError(f"{text!r} is no combination of alpha, beta, gamma and delta")
        return cls(*values)

    def keys(self):
        """The parameters in millionths, as keys of a random stream: it does not depend on the order of a grid."""
        return [round(1e6 * p) for p in self]


PARAMETERS = list(Combination._fields)


def texts_of(table):
    """The combination of every row of a table as text, a list."""
    return [str(Combination.of(row)) for _, row in table.iterrows()]


def joined(combinations):
    """Several combinations as one field of a table."""
    return SEPARATOR.join(map(str, combinations))


def split(field):
    """The texts of the combinations in one field of a table; none where it is empty."""
    return str(field).split(SEPARATOR) if isinstance(field, str) and field else []
