"""Checks of the arguments that users give to functions and commands, and their defaults: one sentence for each that is wrong.

The same limits and defaults hold for the keys of a config (`settings`). Nothing heavy is imported, so that a mistake is
reported at once.
"""

from __future__ import annotations

import difflib
import math
import os
import warnings
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import wraps
from inspect import Parameter, signature
from numbers import Real
from types import MappingProxyType
from typing import TYPE_CHECKING, Any, Final, Literal, NamedTuple, TypeAlias, TypeVar, cast, get_args

from sparsurf.errors import InputError, argument

if TYPE_CHECKING:
    import numpy as np

F = TypeVar("F", bound=Callable[..., Any])


class Limits(NamedTuple):
    """Finite numbers above `low` (from it on, unless `open_low`), at most `high`, and infinity if it stands for no limit."""

    low: float
    high: float = math.inf
    whole: bool = False
    open_low: bool = True
    or_infinite: bool = False

    def allow(self, value: float) -> bool:
        """Return whether a real number lies within the limits; NaN never does."""
        if value == math.inf:
            return self.or_infinite
        above = self.low < value or (value == self.low and not self.open_low)
        return above and value <= self.high and (not self.whole or value % 1 == 0)

    @property
    def words(self) -> str:
        """Allowed numbers in words."""
        number = f"a {'whole ' * self.whole}number"
        if self.high < math.inf:
            least = f"more than {self.low:g} and at most" if self.open_low else f"{self.low:g} to"
            bounds = f"{least} {self.high if self.whole else f'{self.high:g}'}"
            return f"{number}, {bounds}{', or inf for no limit' * self.or_infinite}"
        return f"{number}, more than {self.low:g}" if self.open_low else f"{number}, {self.low:g} or more"

    def check(self, value: Any, name: str, word: str | None = None) -> Any:
        """Return the number that the user gave as `name`, a float or an int, or an allowed word; raise InputError for others."""
        if word is not None and isinstance(value, str) and value == word:
            return value
        is_number = isinstance(value, Real) and not isinstance(value, bool)
        if not is_number or not self.allow(value):
            either = "" if word is None else f"{word!r} or "
            raise InputError(f"{argument(name)} is {value!r}; it must be {either}{self.words}.")
        return int(value) if self.whole else float(value)


LENGTH = Limits(0, 100)  # Å
DISTANCE = Limits(0, 10)  # Å
DISTANCE_OR_INFINITE = Limits(0, 10, or_infinite=True)  # Å
# Numbers near 0 overflow where they are divided by
PROBE = Limits(1e-6, 10)  # Å
DENSITY_LIMITS = Limits(1e-6, 100)  # dots per Å^2
PERCENT_LIMITS = Limits(0, 100)
ALPHA = Limits(0, 1)
EXPONENT = Limits(0, 1000, open_low=False)
SEED = Limits(0, 2**64 - 1, whole=True, open_low=False)
TEST_DOTS = Limits(2, 10**6, whole=True, open_low=False)
NUMBER_OF_DOTS = Limits(0, whole=True)
STEP_LIMITS = Limits(0, 10)  # Å, of the grid of a mesh
ERROR_LIMITS = Limits(0, open_low=False)  # Z
FRAME = Limits(0, whole=True, open_low=False)
JOBS = Limits(1, 1024, whole=True, open_low=False)
DEFAULT_TEST_DOTS = 200  # The default of studies and functions.
DEFAULT_SEED = 20261120  # The default of studies, functions and commands alike.
PROBE_RADIUS = 1.4  # Å
# What is chosen by one of a few words: the type of each choice, by which a type checker refuses another word, and its words
Auto = Literal["auto"]
Hydrogens = Literal["keep", "remove"]
Cavities = Literal["keep", "remove"]
Reentrant = Literal["exact", "dms"]
# of the space that the probe cannot enter, or that its centre cannot
Boundary = Literal["excluded", "accessible"]
Model = Literal["auto", "interpolant", "spheres"]  # by which a surface is reconstructed
RadiiTable = Literal["dms", "bondi"]
ColourLimits: TypeAlias = "tuple[float, float] | None"  # values at the ends of colours, or those of the field
# A table, radii (Å) by element, or the path of a CSV
RadiiLike: TypeAlias = "RadiiTable | str | os.PathLike[str] | Mapping[str, float]"
Ranking = Literal["sd", "range"]  # over frames: standard deviation, or the highest minus the lowest value
CAVITIES, REENTRANT, BOUNDARIES, MODELS, RADII_TABLES, RANKINGS = map(
    get_args, (Cavities, Reentrant, Boundary, Model, RadiiTable, Ranking)
)
AUTO: Final = "auto"
INTERPOLANT: Final = "interpolant"
SPHERES: Final = "spheres"
R_PATCH = 4.0  # Å, of roughness and sampling; authors' scripts
R_ZERNIKE = 6.0  # Å, of the descriptors; paper, Materials and Methods
D_LINK = 0.5  # Å, below which dots are linked; authors' scripts
STRIDE = Limits(0, whole=True)


def frames_between(start: int, stop: int | None, stride: int) -> slice:
    """Return every stride-th position of a frame from `start` up to, and without, `stop`; to the end without one."""
    return slice(start, None if stop is None else Limits(start, whole=True).check(stop, "stop"), stride)


TOUCHED_AREA: Final = 1.0  # Å^2, that a partner buries of a residue that it touches
EACH_RESIDUE: Final = "residues"  # as groups: each is a partner
RANK: Final = "roughness"  # What the residues of a trajectory are ranked by without a request.
RANK_BY: Final = "sd"
PLDDT = Limits(0, 100, open_low=False)


class Argument(NamedTuple):
    """What a name stands for wherever a user gives it: as an argument of a function, an option, or a key of a config.

    Attributes
    ----------
    meaning : what it is, as the beginning of a sentence, with its unit
    allowed : limits of a number, words to choose from, or bool
    default : that of commands and configs, and of most functions; None where there is none
    word : what may stand in place of a number
    """

    meaning: str
    allowed: Limits | tuple[str, ...] | type[bool]
    default: Any = None
    word: str | None = None

    def check(self, value: Any, name: str) -> Any:
        """Return a value that the user gave as `name`; raise InputError unless it is allowed."""
        if isinstance(self.allowed, Limits):
            return self.allowed.check(value, name, self.word)
        if not isinstance(self.allowed, type):
            return check_choice(value, self.allowed, name)
        check_flag(value, name)
        return bool(value)

    @property
    def words(self) -> str:
        """What it is, and its default, as the help of an option."""
        default = f"{self.default:g}" if isinstance(self.default, float) else self.default
        return self.meaning.replace("%", "%%") + (f" (default {default})" if self.default is not None else "")


# Each name has one meaning, one set of limits and one default, wherever it is given: `public` checks arguments by it, and
# `cli.options.add` makes an option of it.
ARGUMENTS = {
    "frame": Argument("position of the frame or model, from 0", FRAME, 0),
    "stride": Argument("every n-th frame is used", STRIDE, 1),
    "start": Argument("position of the first frame to use, from 0", FRAME, 0),
    "stop": Argument("position of the frame before which to stop (default: after the last frame)", FRAME),
    "only_areas": Argument("measure the exact areas and contacts alone, without dots, in a fraction of the time", bool, False),
    "jobs": Argument("number of processes", JOBS, 1),
    "seed": Argument("seed of the random numbers", SEED, DEFAULT_SEED),
    "probe_radius": Argument("radius of the solvent probe, Å", PROBE, PROBE_RADIUS),
    "cavities": Argument("whether to keep or remove the walls of closed cavities inside the molecule", CAVITIES, "keep"),
    "reentrant": Argument(
        "concave dots where the surface intersects itself: exact removes them, dms keeps them as the program DMS does",
        REENTRANT, "exact"),
    "boundary": Argument(
        "place dots where the probe touches (excluded) or where its centre can be (accessible)",
        BOUNDARIES, "excluded"),
    "density": Argument("number of dots per Å^2", DENSITY_LIMITS),
    "d_link": Argument("distance below which two dots are linked, Å; linked dots form islands", LENGTH, D_LINK),
    "r_patch": Argument("radius of the patches for roughness and sampling, Å", LENGTH, R_PATCH),
    "r_zernike": Argument("radius of the patches for the descriptors, Å", LENGTH, R_ZERNIKE),
    "up": Argument("whether the mean normal of a patch is turned to +z", bool, True),
    "test_dots": Argument("number of test dots", TEST_DOTS, DEFAULT_TEST_DOTS, "published"),
    "percent": Argument("share of the dots to keep, %", PERCENT_LIMITS),
    "n_dots": Argument("number of dots to keep (approximate for the paper's samplers)", NUMBER_OF_DOTS),
    "error": Argument("mean error of the surface reconstructed from as many dots as are needed, Å (default 0.02)", DISTANCE),
    "error_99": Argument(
        "distance within which 99 % of each surface lies from the other, Å; inf: only the mean error is bounded "
        "(default with cover: 5 times the error)",
        DISTANCE_OR_INFINITE),
    "max_z": Argument("largest Z of as many dots as are needed, without reconstruction", ERROR_LIMITS),
    "reconstruction": Argument("how the surface is reconstructed", MODELS, AUTO),
    "reach": Argument(
        "how far an interpolated surface extends around a dot, in local spacings; 2 closes holes between uneven dots, and larger "
        "values add dots where there is no surface",
        Limits(0, 10), 1.0),
    "steps": Argument("largest number of Newton steps", Limits(0, 1000, whole=True)),
    "n_vertices": Argument("number of vertices of a mesh, in place of their density", NUMBER_OF_DOTS),
    "step": Argument(
        "of a mesh without a number of vertices: about 4.5 / step^2 of them per Å^2 (default 0.5 Å, 18 per Å^2; at least 0.1); "
        "between dots without atoms, step of the grid, Å, at most 0.7",
        STEP_LIMITS),
    "smooth": Argument(
        "width of the Gaussian over which B factors and columns of a table are averaged, Å (default: not averaged)",
        LENGTH),
    "above": Argument("list the regions whose dots have higher values", Limits(-1e9, 1e9)),
    "below": Argument("list the regions whose dots have lower values", Limits(-1e9, 1e9)),
    "min_area": Argument("area of the smallest region that is listed, Å^2", ERROR_LIMITS, 20),
    "rank_by": Argument(
        "rank by the standard deviation over the frames, or by the highest minus the lowest value",
        RANKINGS, RANK_BY),
    "plugs": Argument("whether inner atoms are kept that keep the probe out", bool, True),
    "whole": Argument("whether molecules that cross the box are made whole", bool, True),
    "colours": Argument("whether a mesh is coloured", bool),
    "open_browser": Argument("whether the page is opened", bool, True),
}  # fmt: skip


def check_plddt(value: Any) -> float:
    """Return a bound of pLDDT; raise InputError for what is none, and for a share of 1, which would leave out nothing."""
    bound = PLDDT.check(value, "plddt")
    if reason := share_of_plddt(bound):
        raise InputError(f"{argument('plddt')} {reason}")
    return bound


def share_of_plddt(bound: float) -> str:
    """Return the words that refuse a bound between 0 and 1; an empty string for another."""
    if not 0 < bound <= 1:
        return ""
    return f"is {bound:g}, which looks like a share; pLDDT runs from 0 to 100, so give {100 * bound:g}."


def check_choice(value: Any, choices: Sequence[str], name: str) -> str:
    """Return a value of the user that is one of the choices; raise InputError for another."""
    if not isinstance(value, str) or value not in choices:  # an array compares with each of them
        allowed = " or ".join(choices) if len(choices) == 2 else f"one of {', '.join(choices)}"
        raise InputError(f"{argument(name)} is {value!r}; it must be {allowed}.")
    return value


def check_flag(value: Any, name: str) -> None:
    """Raise InputError if a value that the user gave as `name` is not True or False."""
    import numpy as np

    if not isinstance(value, bool | np.bool_):
        raise InputError(f"{argument(name)} is {value!r}; it must be True or False.")


def checked_result(
    values: Any, name: str, shape: tuple[int | None, ...], allow_nan: bool = False
) -> np.ndarray:
    """Return the numbers, float64, that a function of the user returned; raise InputError for others.

    `name` is that of the function, and `shape` what the numbers must have; None stands for any length of 1 or more.
    """
    import numpy as np

    try:
        array = np.asarray(values)
    except ValueError:
        array = np.asarray(None)  # rows of unequal lengths
    lengths = ["any width" if length is None else f"{length:,}" for length in shape]
    expected = f"{lengths[0]} numbers" if len(shape) == 1 else f"numbers of shape ({', '.join(lengths)})"
    is_number = array.dtype.kind in "biuf"
    if not is_number or array.ndim != len(shape):
        described = (
            f"an array of {array.dtype} and shape {array.shape}"
            if array.ndim
            else f"a {type(values).__name__}"
        )
        raise InputError(f"{name} returns {described}; it must return {expected}.")
    if any(
        n != wanted if wanted is not None else n < 1 for n, wanted in zip(array.shape, shape, strict=True)
    ):
        raise InputError(f"{name} returns an array of shape {array.shape}; it must return {expected}.")
    array = array.astype(np.float64)
    if np.isinf(array).any() or (np.isnan(array).any() and not allow_nan):
        if allow_nan:
            raise InputError(f"{name} returns infinity; it must return NaN where there is no value.")
        raise InputError(f"{name} returns NaN or infinity; it must return finite numbers.")
    return array


def split_names(text: str, name: str, example: str) -> list[str]:
    """Return the names in a list with commas, without blanks around them; raise InputError if there are none."""
    names = [part.strip() for part in text.split(",") if part.strip()]
    if not names:
        raise InputError(f"{argument(name)} contains no name; give names such as {example}, or leave it out.")
    return names


def index_array(values: Any, n_dots: int, name: str) -> np.ndarray:
    """Return the user's values as one array: of whole numbers if empty, of dots if they are a mask of all `n_dots`.

    Raise InputError for rows of unequal lengths, or masked values.
    """
    import numpy as np

    if np.ma.is_masked(values):
        raise InputError(f"{argument(name)}: the array has masked values; leave these dots out.")
    try:
        array = np.asarray(values)
    except ValueError:
        raise InputError(f"{argument(name)}: give one array, not several of unequal length.") from None
    if array.shape == (0,):  # an empty list has no type of its own
        return array.astype(np.int64)
    return np.flatnonzero(array) if array.dtype == bool and array.shape == (n_dots,) else array


def did_you_mean(value: str, names: Iterable[str]) -> str:
    """Return "; did you mean 'name'?" with the nearest of some names, or nothing if none is near."""
    full_names = {name.lstrip("-"): name for name in names}  # dashes would make all options alike
    near = difflib.get_close_matches(value.lstrip("-"), full_names, 1, 0.55)
    return f"; did you mean {full_names[near[0]]!r}?" if near else ""


def _has_a_text(value: Any) -> bool:
    """Return whether a value can be quoted in a sentence: its class may define this wrongly."""
    try:
        return bool(repr(value))
    except Exception:
        return False


# The keywords of `surface`
PLACEMENT = (
    "frame",
    "probe_radius",
    "density",
    "radii",
    "cavities",
    "reentrant",
    "d_link",
    "boundary",
    "groups",
)


def public(
    of_dots: bool = False,
    renamed: Mapping[str, str] = MappingProxyType({}),
    words: Mapping[str, str] = MappingProxyType({}),
) -> Callable[[F], F]:
    """Check the arguments of a function for users by `ARGUMENTS`, and name the right keyword in place of a wrong one.

    Defaults need no check, and `words` may stand in place of some numbers. It is `of_dots` if it takes what `surface` returns.
    Keywords that are `renamed`, from their old names, are taken with a DeprecationWarning.
    """

    def decorate(function: F) -> F:
        parameters = signature(function).parameters
        names = list(parameters)
        n_by_position = sum(parameter.kind is not Parameter.KEYWORD_ONLY for parameter in parameters.values())
        defaults = {name: parameter.default for name, parameter in parameters.items()}
        checks = {
            name: ARGUMENTS[name]._replace(word=words.get(name, ARGUMENTS[name].word)).check
            for name in names
            if name in ARGUMENTS
        }
        required = [name for name, parameter in parameters.items() if parameter.default is Parameter.empty]

        @wraps(function)
        def checked(*values: Any, **keywords: Any) -> Any:
            for old, new in renamed.items():
                if old in keywords and new not in keywords:
                    keywords[new] = value = keywords.pop(old)
                    warnings.warn(
                        f"{function.__name__}: write {new}={value!r} in place of {old}={value!r}, which version 8 will refuse.",
                        DeprecationWarning,
                        stacklevel=2,
                    )
            for key, value in keywords.items():
                if key in names:
                    continue
                if of_dots and key in PLACEMENT:
                    call = f"sparsurf.{function.__name__}(sparsurf.surface(molecule, {key}={value!r}), ...)"
                    raise InputError(
                        f"{function.__name__}: {key} belongs to the placing of the dots: call {call}."
                    )
                hint = did_you_mean(key, names) or f"; its keywords are {', '.join(names)}."
                raise InputError(f"{function.__name__} has no keyword {key!r}{hint}")
            if len(values) > n_by_position:
                raise InputError(
                    f"{function.__name__} takes only {', '.join(names[:n_by_position])} without a name, and here "
                    f"{len(values)} values have none; name the others, as in {names[min(n_by_position, len(names) - 1)]}=..."
                )
            if twice := [name for name in names[: len(values)] if name in keywords]:
                raise InputError(f"{function.__name__}: {twice[0]} is given twice; give it once.")
            if missing := [name for name in required if name not in (*names[: len(values)], *keywords)]:
                raise InputError(
                    f"{function.__name__} needs {missing[0]}; its arguments are {', '.join(names)}."
                )
            given = dict(zip(names, values, strict=False)) | keywords
            try:
                for name, check in checks.items():
                    default = defaults[name]
                    value = given.get(name, default)
                    if value is not default and not (isinstance(value, str) and value == default):
                        given[name] = check(value, name)
                return function(**given)
            except InputError:
                raise
            except Exception as error:  # of a message, say, that quotes an argument
                for name, value in given.items():
                    if not _has_a_text(value):
                        raise InputError(
                            f"{function.__name__}: {name} is a {type(value).__name__} that cannot be shown as text; "
                            "give a value of another type."
                        ) from error
                raise

        return cast(F, checked)

    return decorate
