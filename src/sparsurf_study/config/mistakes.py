"""One sentence for each mistake that pydantic finds in a config."""

import datetime
import re
from collections.abc import Iterable, Iterator
from typing import Any, get_args

from pydantic import BaseModel

from sparsurf.arguments import did_you_mean
from sparsurf.errors import InputError
from sparsurf.files import shorten
from sparsurf.settings import OR_INSTALLED
from sparsurf_study.config.models import FORMS, Config

WRONG_TYPES = {
    "int_type": "a whole number without quotes, such as 3",
    "float_type": "a number without quotes, such as 0.5",
    "finite_number": "a number, such as 0.5",
    "string_type": "a string; put it in quotes",
    "bool_type": "true or false",
    "list_type": "a list in square brackets, such as [a, b]",
    "dict_type": "a mapping of names to values, such as {{name: value}}",
    "model_type": "a mapping of keys to values, such as {{{first}: ...}}",
    "literal_error": "{names}",
}
ALLOWED = WRONG_TYPES | {
    "greater_than": "more than {gt}",
    "greater_than_equal": "{ge} or more",
    "less_than": "less than {lt}",
    "less_than_equal": "{le} or less",
    "string_too_short": "a string that is not empty",
    "string_too_long": "a string of at most {max_length} characters",
    "string_pattern_mismatch": "of the form {form}",
    "too_short": "a list of {min_length} or more values",
    "too_long": "a list of {max_length} or fewer values",
}
# Such a part of a location of pydantic is a kind of value and no key.
KIND = re.compile(r"\[|^(bool|str)$")
NAME_RULE = "cannot name a folder; use at most 100 letters, digits, '_', '-' and '.', and begin with a letter or a digit."
REMOVED_KEYS = {  # and what to write in their place
    (
        "ensemble",
        "jobs",
    ): "how a study runs is no part of its config: delete the key, and pass `--set-scatter frames={value}` to "
    "Snakemake, or write `set-scatter: [frames={value}]` into its profile."
}
NAMES_OF_STRUCTURE = ("pdbfile", "pdb_file", "file", "path", "topology", "top", "cif", "mmcif")  # elsewhere


def sentences(errors: Iterable[Any]) -> Iterator[str]:
    """Yield one sentence for each of pydantic's mistakes: the key, what is wrong, what is allowed."""
    by_key: dict[tuple, list[dict]] = {}
    for error in errors:  # where a key may hold several kinds of values, one for each kind
        key = tuple(part for part in error["loc"] if part == "[key]" or not KIND.search(str(part)))
        by_key.setdefault(key, []).append(error)
    for key, of_key in by_key.items():
        tried = [error for error in of_key if error["type"] in WRONG_TYPES and key[-1] != "[key]"]
        meant = [error for error in of_key if error not in tried]
        yield from (_sentence(key, error) for error in meant)
        if tried and not meant and not any(key == other[: len(key)] for other in by_key if other != key):
            yield _but_must_be(key, tried)


def _sentence(key: tuple, error: dict) -> str:
    kind, value = error["type"], error["input"]
    if kind == "extra_forbidden":
        removed = REMOVED_KEYS.get(key)
        return f"{_name(key)}: {removed.format(value=_short(value))}" if removed else _unknown_key(key)
    if kind == "missing":
        return f"{_name(key[:-1])} lacks the key {key[-1]!r}."
    if kind == "value_error":
        reason = error["ctx"]["error"]
        return str(reason) if isinstance(reason, InputError) else f"{_name(key)} {reason}"
    if kind == "invalid_key" or (key[-1] == "[key]" and kind == "string_type"):
        return f"the key {value!r} in {_name(key[:1])} is not read as a string; put it in quotes."
    if key[-1] == "[key]" or key == ("run",):
        return f"{_short(value)} in {key[0]} {NAME_RULE}"
    return _but_must_be(key, [error])


def _but_must_be(key: tuple, errors: list[dict]) -> str:
    """Return a sentence with the allowed values and the meaning of a key."""
    value, allowed = errors[0]["input"], []
    section, meaning = _known(key)
    first = next(iter(section.model_fields))  # an example of a key
    for error in errors:
        context = error.get("ctx", {}).items()
        limits: dict[str, Any] = {
            name: int(limit) if isinstance(limit, float) else limit for name, limit in context
        }
        expected, form = limits.get("expected", ""), FORMS.get(limits.get("pattern", ""))
        end = f" {OR_INSTALLED}" if expected.endswith(OR_INSTALLED) else ""
        names = one_of(str(value), re.findall("'(.*?)'", expected), end)
        template = ALLOWED.get(error["type"], "another value")
        allowed.append(template.format(**limits, form=form, first=first, names=names))
    return f"{_name(key)} is {_short(value)}, but must be {' or '.join(allowed)} ({meaning})."


def one_of(value: str, names: list[str], end: str = "") -> str:
    """Return 'one of a, b, c', the `end` of the list, and the name that the user may have meant."""
    listed = f"one of {', '.join(names)}" if len(names) > 1 else "".join(names)
    return listed + end + did_you_mean(value, names)


def _unknown_key(key: tuple) -> str:
    unknown, fields = key[-1], _known(key[:-1])[0].model_fields
    below = {name: _section(field.annotation) for name, field in fields.items()}
    owners = [name for name, model in below.items() if model and unknown in model.model_fields]
    if owners:
        hint = f"; it belongs to {' or '.join(owners)}."
    elif unknown.lower() in NAMES_OF_STRUCTURE and "structure" in fields:
        hint = "; did you mean 'structure'?"
    else:
        hint = did_you_mean(unknown, fields) or f"; the keys here are {', '.join(fields)}."
    return f"unknown key {unknown!r} in {_name(key[:-1])}{hint}"


def _known(key: tuple) -> tuple[type[BaseModel], str]:
    """Return the section that a key leads to, and the first sentence on what the key means."""
    section: type[BaseModel] = Config
    meaning = ""
    for part in key:
        if field := section.model_fields.get(part):
            section = _section(field.annotation) or section
            meaning = field.description or section.__doc__ or ""
        elif key[:2] == (key[0], part) and section is not Config:  # the name of an entry
            meaning = section.__doc__ or ""
    return section, meaning.partition(". ")[0].rstrip(".")


def _section(annotation: Any) -> type[BaseModel] | None:
    """Return the section, or the section of the entries, that a key holds; None for other keys."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_section, get_args(annotation))), None)


def _name(key: tuple) -> str:
    return ".".join(map(str, key)) or "the config"


def _short(value: Any) -> str:
    """Return a value as the file has it, cut where it is long."""
    return shorten(value if isinstance(value, datetime.date) else repr(value))
