"""Names that a user may have meant, of values and of keywords."""

import difflib
import warnings
from collections.abc import Callable, Iterable, Mapping
from functools import wraps
from inspect import Parameter, signature
from types import MappingProxyType
from typing import Any, TypeVar, cast

from sparsurf.arguments import ARGUMENTS
from sparsurf.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])


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
