"""Mistakes in a config that its schema finds, as sentences for the person who wrote it."""

import datetime
import difflib
import re

TYPES = {
    "integer": "a whole number, as 3",
    "number": "a number, as 0.5",
    "string": "a string",
    "boolean": "true or false",
    "array": "a list, as [1, 2]",
    "object": "a mapping, as {key: value}",
}
NUMBER = re.compile(
    r"[+-]?\d*\.?\d+(e[+-]?\d+)?", re.I
)  # quoted, or one of 1e3, which YAML reads as a string


def sentence(error):
    """What a schema error means: the key, what was given, what is allowed."""
    if error.validator == "anyOf":  # one of the forms may be meant, and only a part of it be wrong
        other = {
            each.schema_path[0]
            for each in error.context
            if not each.path and each.validator in ("type", "const")
        }
        meant = [each for each in error.context if each.schema_path[0] not in other]
        if meant:
            return sentence(meant[0])
    key = ".".join(map(str, error.absolute_path)) or "the config"
    if error.validator == "additionalProperties":
        return _unknown(key, sorted(set(error.instance) - set(error.schema["properties"]))[0], error.schema)
    if error.validator == "required":
        return f"{key} lacks the key {error.message.split()[0]}."
    listed = key.partition(".")[0]
    if error.validator in ("oneOf", "dependentRequired") and listed == "pairs":
        return f"{key} needs exactly one of 'proteins', 'files' and 'complex' (with 'chains')."
    if error.validator in ("oneOf", "dependentRequired") and listed == "sites":
        return f"{key} needs either 'query' and 'residues' (with or without 'targets') or 'changes'."
    if error.validator == "oneOf" and listed == "proteins":
        return f"{key} needs exactly one of 'structure' (with or without 'trajectory'), 'pdb', 'url' and 'surface'."
    if error.validator == "minProperties":
        return f"{key} is empty; name at least one protein."
    if error.validator in ("minItems", "maxItems"):
        least, word = error.validator_value, "at least" if error.validator == "minItems" else "at most"
        given = error.instance if len(error.instance) < 10 else f"{len(error.instance)} values long"
        return f"{key} is {given}, but needs {word} {least} value{'s' if least > 1 else ''}."
    if error.validator == "uniqueItems":
        return f"{key} holds a value twice: {_short(error.instance)}."
    named = "propertyNames" in error.absolute_schema_path or key == "run"
    if named and error.validator in ("pattern", "maxLength"):
        return (
            f"{_short(error.instance)} in {key} cannot name a folder; use at most 100 letters, digits, '_', '-' and "
            "'.', not '.' first."
        )
    rule = error.schema if "description" in error.schema or not error.parent else error.parent.schema
    meaning = rule.get("description", "").rstrip(".")
    words = _allowed(error)
    end = f" ({meaning})." if meaning else "" if words.endswith("?") else "."
    return f"{key} is {_short(error.instance)}, but must be {words}{end}"


def _unknown(key, unknown, schema):
    known = list(schema["properties"])
    if now := [name for name in known if unknown in schema["properties"][name].get("was", ())]:
        return f"{key}.{unknown} is now called {key}.{now[0]}."
    near = difflib.get_close_matches(unknown, known, 1, 0.5)
    hint = f"did you mean {near[0]!r}?" if near else f"the keys here are {', '.join(known)}."
    below = [name for name, rule in schema["properties"].items() if unknown in rule.get("properties", ())]
    if below:  # said before a key that only looks like it
        hint = f"it stands below {' or '.join(below)}."
    return f"unknown key {unknown!r} in {key}; {hint}"


def _short(value):
    """A value as it is written in Python (a date as in the file), cut where it is long."""
    text = str(value) if isinstance(value, datetime.date) else repr(value)
    return text if len(text) <= 100 else f"{text[:80]}... ({len(text)} characters)"


def _allowed(error):
    """What a schema keyword allows, in words."""
    rule = error.validator_value
    if error.validator == "enum":
        if now := error.schema.get("was", {}).get(str(error.instance)):
            return f"{now}, its new name"
        near = difflib.get_close_matches(str(error.instance), list(map(str, rule)), 1, 0.5)
        hint = f"; did you mean {near[0]!r}?" if near else ""
        return f"one of {', '.join(map(str, rule))}{hint}"
    words = {
        "type": _type(rule, error.instance) if error.validator == "type" else "",
        "const": f"{rule!r}",
        "minimum": f"{rule} or more",
        "maximum": f"{rule} or less",
        "exclusiveMinimum": f"more than {rule}",
        "exclusiveMaximum": f"less than {rule}",
        "minLength": "a string that is not empty",
        "maxLength": f"a string of at most {rule} characters",
        "pattern": f"of the form {error.schema.get('examples', [rule])[0]}",
    }
    return words.get(error.validator, "one of the forms that config.yaml describes")


def _type(requested, given):
    """What a type is called, and what to do where YAML reads another one than meant."""
    if requested == "string" and isinstance(given, (int, float, datetime.date)):
        return f"{TYPES[requested]}; put it in quotes"
    if requested in ("integer", "number") and isinstance(given, str) and NUMBER.fullmatch(given):
        return f"{TYPES[requested]}; write it without quotes and without e"
    if requested == "array" and isinstance(given, str):
        return f"a list, as [{given}]"
    return TYPES[requested]
