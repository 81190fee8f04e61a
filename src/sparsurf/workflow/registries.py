"""Names that the library's registries hold, read from their source: to plan a study takes no numpy."""

import ast
from functools import cache
from pathlib import Path

LIBRARY = Path(__file__).parents[1]
FORMATS = LIBRARY / "surfaces" / "formats"
# Module, its table, and the decorator that enters a function in it, also from modules beside
REGISTRIES = {
    "samplers": ("sampling/samplers.py", "SAMPLERS", "sampler"),
    "roughnesses": ("patches/roughness.py", "ROUGHNESS", "registered"),
    "fields": ("dot_fields/registry.py", "FIELDS", "field"),
    "descriptors": ("patches/descriptors.py", "DESCRIPTORS", None),
}


@cache
def names(registry, having=None):
    """Names in a registry, in its order; with `having` those that are registered with that keyword.

    Parameters
    ----------
    registry : key of `REGISTRIES`
    having : str, optional

    Returns
    -------
    tuple of str
    """
    path, table, decorator = REGISTRIES[registry]
    statements = _statements(LIBRARY / path)
    values = {each.targets[0].id: each.value for each in statements if _is_named(each)}
    found = [_text(key, values) for key in getattr(values[table], "keys", ())] if not having else []
    for beside in sorted((LIBRARY / path).parent.glob("*.py"), key=lambda each: each != LIBRARY / path):
        for each in _statements(beside):
            calls = [call for call in getattr(each, "decorator_list", ()) if _called(call) == decorator]
            found += [each.name for call in calls if not having or having in _keywords(call)]
    return tuple(found)


@cache
def surface_suffixes():
    """Endings of the files that hold a ready surface, each also with .gz."""
    found = []
    for path in sorted(FORMATS.glob("*.py")):
        for each in _statements(path):
            if _is_named(each) and each.targets[0].id == "FORMAT":
                _, suffixes, _, *read = each.value.args
                found += ast.literal_eval(suffixes) if read or "read" in _keywords(each.value) else ()
    return tuple(found)


def _statements(path):
    return ast.parse(path.read_text(encoding="utf-8")).body


def _called(decorator):
    return getattr(getattr(decorator, "func", decorator), "id", "")


def _is_named(statement):
    return isinstance(statement, ast.Assign) and isinstance(statement.targets[0], ast.Name)


def _keywords(call):
    return [each.arg for each in getattr(call, "keywords", ())]


def _text(key, values):
    """A key of a table, which may be a constant of its module."""
    return ast.literal_eval(values[key.id] if isinstance(key, ast.Name) else key)
