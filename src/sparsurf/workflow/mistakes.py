"""One sentence for each mistake that pydantic finds in a config."""

import datetime
import difflib
import re
from collections.abc import Iterable, Iterator
from typing import Any

from pydantic import BaseModel

from sparsurf import InputError
from sparsurf.suggestions import did_you_mean

TYPES = {
    "int_type": "a whole number, as 3",
    "float_type": "a number, as 0.5",
    "finite_number": "a number, as 0.5",
    "string_type": "a string",
    "bool_type": "true or false",
    "list_type": "a list, as [1, 2]",
    "dict_type": "a mapping, as {key: value}",
    "model_type": "a mapping, as {key: value}",
}
LIMITS = {
    "greater_than": "more than {gt}",
    "greater_than_equal": "{ge} or more",
    "less_than": "less than {lt}",
    "less_than_equal": "{le} or less",
}
# A number in quotes, or like 1e3, which YAML reads as a string.
NUMBER = re.compile(r"[+-]?\d*\.?\d+(e[+-]?\d+)?", re.I)
# Names that other programs have for keys
SYNONYMS = dict.fromkeys(
    ("pdbfile", "pdb_file", "file", "path", "topology", "top", "cif", "mmcif"), ("structure",)
)
NAME_RULE = "cannot name a folder; use at most 100 letters, digits, '_', '-' and '.', not '.' first."


def sentences(errors: Iterable[Any], config: dict, model: type[BaseModel]) -> Iterator[str]:
    """Yield one sentence for each mistake of pydantic's `ValidationError.errors`: the key, what is wrong, what is allowed."""
    schema = model.model_json_schema()
    alternatives: dict[
        tuple, dict[str, list]
    ] = {}  # errors of a union's alternatives, by the key of the union
    for error in errors:
        path, alternative = _split_location(error, config)
        if alternative is None:
            yield _sentence(error, path, schema)
        else:
            key = path[: alternative[0]]
            alternatives.setdefault(key, {}).setdefault(alternative[1], []).append((error, path))
    for key, by_alternative in alternatives.items():
        yield from _union_sentences(key, by_alternative, schema)


def _split_location(error: dict, config: dict) -> tuple[tuple, tuple[int, str] | None]:
    """Split pydantic's location into the path of a key, and the place and name of a union's alternative."""
    path: list = []
    alternative, value = None, config
    for depth, part in enumerate(error["loc"], 1):
        is_missing = error["type"] == "missing" and depth == len(error["loc"])
        if (isinstance(value, dict) and part in value) or (isinstance(value, list) and isinstance(part, int)):
            value = value[part]
        elif part != "[key]" and not is_missing:
            alternative = alternative or (len(path), part)
            continue
        path.append(part)
    return tuple(path), alternative


def _union_sentences(key: tuple, by_alternative: dict[str, list], schema: dict) -> Iterator[str]:
    """Yield the mistakes of the alternative that the user meant: the one whose type fits."""
    wrong_type = {*TYPES, "literal_error"}
    for errors in by_alternative.values():
        if not any(path == key and error["type"] in wrong_type for error, path in errors):
            yield from (_sentence(error, path, schema) for error, path in errors)
            return
    first = [errors[0][0] for errors in by_alternative.values()]
    allowed = " or ".join(_allowed(error, {}) for error in first)
    yield _but_must_be(key, first[0]["input"], allowed, schema)


def _sentence(error: dict, path: tuple, schema: dict) -> str:
    kind, value, key = error["type"], error["input"], ".".join(map(str, path)) or "the config"
    parent = ".".join(map(str, path[:-1])) or "the config"
    rule = _rule_at(path, schema)
    if kind == "value_error":
        reason = error["ctx"]["error"]
        return str(reason) if isinstance(reason, InputError) else f"{key} {reason}"
    if kind == "extra_forbidden":
        return _unknown_key(parent, path[-1], _rule_at(path[:-1], schema))
    if kind == "missing":
        return f"{parent} lacks the key {path[-1]!r}."
    if kind == "invalid_key" or (path[-1:] == ("[key]",) and kind == "string_type"):
        where = parent if kind == "invalid_key" else ".".join(map(str, path[:-2]))
        return f"the key {value!r} in {where} is not read as a string; put it in quotes."
    if path[-1:] == ("[key]",) or (
        path == ("run",) and kind in ("string_pattern_mismatch", "string_too_long")
    ):
        where = ".".join(map(str, path[:-2])) or key
        return f"{_short(value)} in {where} {NAME_RULE}"
    if kind in ("too_short", "too_long"):
        word, limit = ("at least", "min_length") if kind == "too_short" else ("at most", "max_length")
        number = error["ctx"][limit]
        shown = value if len(value) < 10 else f"{len(value)} values long"
        return f"{key} is {shown}, but needs {word} {number} value{'s' if number > 1 else ''}."
    return _but_must_be(path, value, _allowed(error, rule), schema)


def _but_must_be(path: tuple, value: Any, allowed: str, schema: dict) -> str:
    key = ".".join(map(str, path)) or "the config"
    meaning = next(
        (
            rule["description"]
            for rule in (_rule_at(path, schema), _rule_at(path[:-1], schema))
            if "description" in rule
        ),
        "",
    ).rstrip(".")
    end = f" ({meaning})." if meaning else "" if allowed.endswith("?") else "."
    return f"{key} is {_short(value)}, but must be {allowed}{end}"


def _allowed(error: dict, rule: dict) -> str:
    """Return the allowed values in words."""
    kind, value, limits = error["type"], error["input"], error.get("ctx", {})
    if kind in LIMITS:
        return LIMITS[kind].format(**{key: int(limit) for key, limit in limits.items()})
    if kind == "literal_error":
        names = re.findall("'(.*?)'", limits["expected"])
        return one_of(str(value), names)
    if kind == "string_too_short":
        return "a string that is not empty"
    if kind == "string_too_long":
        return f"a string of at most {limits['max_length']} characters"
    if kind == "string_pattern_mismatch":
        return f"of the form {rule.get('examples', [limits['pattern']])[0]}"
    allowed = TYPES.get(kind, error["msg"])
    if kind == "string_type" and isinstance(value, int | float | datetime.date):
        return f"{allowed}; put it in quotes"
    if kind in ("int_type", "float_type") and isinstance(value, str) and NUMBER.fullmatch(value):
        return f"{allowed}; write it without quotes and without e"
    if kind == "list_type" and isinstance(value, str):
        return f"a list, as [{value}]"
    return allowed


def one_of(value: str, names: list[str]) -> str:
    """Return 'one of a, b, c', with the name that the user may have meant."""
    listed = f"one of {', '.join(names)}" if len(names) > 1 else names[0]
    return listed + did_you_mean(value, names)


def _unknown_key(parent: str, unknown: str, rule: dict) -> str:
    known = rule["properties"]
    sections = [key for key in known if unknown in _resolved(known[key], rule["$defs"]).get("properties", {})]
    near = difflib.get_close_matches(unknown, known, 1, 0.5)
    if sections:
        hint = f"it belongs to {' or '.join(sections)}."
    elif meant := [key for key in SYNONYMS.get(unknown.lower(), ()) if key in known]:
        hint = f"did you mean {meant[0]!r}?"
    elif near:
        hint = f"did you mean {near[0]!r}?"
    else:
        hint = f"the keys here are {', '.join(known)}."
    return f"unknown key {unknown!r} in {parent}; {hint}"


def _rule_at(path: tuple, schema: dict) -> dict:
    """Return the JSON Schema of the key at a path, with the definitions that it refers to."""
    rule = schema
    for part in path:
        rule = _resolved(rule, schema["$defs"])
        if isinstance(part, int):
            rule = rule.get("items", {})
        else:
            names = [*rule.get("patternProperties", {}).values(), rule.get("additionalProperties")]
            rule = rule.get("properties", {}).get(part) or next(filter(None, names), {})
    return _resolved(rule, schema["$defs"]) | {"$defs": schema["$defs"]}


def _resolved(rule: dict, definitions: dict) -> dict:
    """Return a rule with its references resolved and the keys of all its alternatives."""
    rule = rule if isinstance(rule, dict) else {}
    if "$ref" in rule:
        rule = definitions[rule["$ref"].rsplit("/", 1)[-1]] | {k: v for k, v in rule.items() if k != "$ref"}
    for alternative in rule.get("anyOf", ()):
        rule = _resolved(alternative, definitions) | rule
    return rule


def _short(value: Any) -> str:
    """Return a value as Python writes it (a date as in the file), cut where it is long."""
    text = str(value) if isinstance(value, datetime.date) else repr(value)
    return text if len(text) <= 100 else f"{text[:80]}... ({len(text)} characters)"
