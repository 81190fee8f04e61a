"""Names that a user may have meant, of values and of keywords."""

import difflib
from collections.abc import Callable, Iterable
from functools import wraps
from inspect import Parameter, signature
from typing import Any, TypeVar, cast

from sparsurf.errors import InputError

F = TypeVar("F", bound=Callable[..., Any])


def did_you_mean(value: str, names: Iterable[str]) -> str:
    """Return "; did you mean 'name'?" with the nearest of some names, or nothing if none is near."""
    words = {name.lstrip("-"): name for name in names}  # dashes would make all options alike
    near = difflib.get_close_matches(value.lstrip("-"), words, 1, 0.55)
    return f"; did you mean {words[near[0]]!r}?" if near else ""


def public(*others: str) -> Callable[[F], F]:
    """Let a function for users name the right keyword in place of a wrong one; `others` are those that it hands on."""

    def decorate(function: F) -> F:
        given = signature(function).parameters.values()
        names = [each.name for each in given if each.kind is not Parameter.VAR_KEYWORD] + [*others]

        @wraps(function)
        def checked(*values: Any, **keywords: Any) -> Any:
            for key in keywords:
                if key not in names:
                    hint = did_you_mean(key, names) or f"; its keywords are {', '.join(names)}."
                    raise InputError(f"{function.__name__} has no keyword {key!r}{hint}")
            return function(*values, **keywords)

        return cast(F, checked)

    return decorate
