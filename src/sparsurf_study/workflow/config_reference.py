"""Write config/schema.json and docs/config.md from the models of the config."""

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from sparsurf import kinds
from sparsurf_study.workflow.models import Config

HOME = Path(__file__).resolve().parents[3]
SCHEMA_FILE, REFERENCE_PAGE = HOME / "config" / "schema.json", HOME / "docs" / "config.md"
INTRODUCTION = """\
# Keys of a config

This page lists every key of a config, the YAML file that describes a study. [Start](start.md#your-own-protein) shows how to run
your own study, and `config.yaml` is the default study. A config needs only `proteins` or `pairs`, and each key that is left out
takes its default. A config without both changes single keys of the default study. Paths start at the repository. `<name>` is a
name that you choose.

- [The method](method.md) explains the terms patch, island, roughness, combination, descriptor, Z, d, test dot and reading.
  n_S is the number of kept dots.
- A *sampler* chooses dots:
{samplers}
- A *conformation* is one frame of a protein. Conformations are called `c1`, `c2` and so on if they are chosen by clusters, and
  `f` with the number of the frame otherwise.
- *Batches* are jobs that process many structures each, without a page for each structure ([Thousands of structures](many.md)).

"""
HEAD = "| key | type, range | default | meaning |\n|---|---|---|---|\n"


def json_schema() -> dict:
    """Return the JSON Schema of a config, for editors."""
    return {"$schema": "https://json-schema.org/draft/2020-12/schema"} | _without_titles(
        Config.model_json_schema()
    )


def _without_titles(rule: Any) -> Any:
    """Remove titles and empty defaults, which say nothing."""
    if isinstance(rule, list):
        return [_without_titles(part) for part in rule]
    if not isinstance(rule, dict):
        return rule
    empty: dict[str, type] = {"title": str, "default": type(None)}
    return {
        key: _without_titles(value)
        for key, value in rule.items()
        if not (key in empty and isinstance(value, empty[key]))
    }


def reference_page() -> str:
    """Return the page with a table of keys for each section."""
    schema = json_schema()
    definitions = schema["$defs"]
    alone, sections = [], []
    for key, rule in schema["properties"].items():
        rows = [_row(name, below) for name, below in _keys_below(rule, "", definitions)]
        if rows:
            sections.append(f"\n## {key}\n\n{_meaning(rule, definitions)}\n\n{HEAD}{''.join(rows)}")
        else:
            alone.append(_row(key, rule))
    samplers = "\n".join(f"  - `{name}`: {choice.meaning}" for name, choice in kinds.TABLE["sampler"].items())
    return INTRODUCTION.format(samplers=samplers) + HEAD + "".join([*alone, *sections])


def _alternatives(rule: dict, definitions: dict) -> Iterator[dict]:
    """Return the forms that a value may have, without references."""
    if "$ref" in rule:
        yield from _alternatives(definitions[rule["$ref"].rsplit("/", 1)[-1]], definitions)
    elif "anyOf" in rule:
        for alternative in rule["anyOf"]:
            yield from _alternatives(alternative, definitions)
    else:
        yield rule


def _meaning(rule: dict, definitions: dict) -> str:
    return rule.get("description") or next(_alternatives(rule, definitions)).get("description", "")


def _keys_below(rule: dict, prefix: str, definitions: dict) -> Iterator[tuple[str, dict]]:
    """Return the dotted names of the keys inside a section, with their rules."""
    for form in _alternatives(rule, definitions):
        if "folder" in form.get("properties", {}):
            continue
        for key, below in form.get("properties", {}).items():
            forms = [*_alternatives(below, definitions)]
            resolved = below | {"forms": forms, "description": _meaning(below, definitions)}
            yield f"{prefix}{key}", resolved
            if any("properties" in form for form in forms):
                yield from _keys_below(below, f"{prefix}{key}.", definitions)
        for below in form.get("patternProperties", {}).values():
            yield from _keys_below(below, f"{prefix}<name>.", definitions)


def _row(name: str, rule: dict) -> str:
    forms = dict.fromkeys(_type(form) for form in rule.get("forms", [rule]))
    value = rule.get("default", {})
    written = value if isinstance(value, str) else json.dumps(value, ensure_ascii=False)
    default = "" if isinstance(value, dict) else f"`{written}`"
    meaning = rule["description"].replace("|", "\\|").replace("<", "&lt;")
    return f"| `{name}` | {' or '.join(forms)} | {default} | {meaning} |\n"


def _type(rule: dict) -> str:
    """Return the type and range of a value in a few words."""
    if "anyOf" in rule:
        return " or ".join(dict.fromkeys(map(_type, rule["anyOf"])))
    if rule.get("enum") == [*kinds.TABLE["sampler"]]:
        return "sampler"
    if "enum" in rule or "const" in rule:
        return ", ".join(f"`{value}`" for value in rule.get("enum", [rule.get("const")]))
    kind = rule.get("type")
    if kind == "array":
        number = f"{rule['maxItems']} " if rule.get("maxItems", 0) == rule.get("minItems") else ""
        return f"list of {number}" + re.sub(r"^(\w+)\b(?!`)", r"\1s", _type(rule["items"]))
    if kind in ("integer", "number"):
        return _range(kind, rule)
    return {"boolean": "`true`, `false`", "object": "mapping", "string": "string"}.get(kind or "", "mapping")


def _range(word: str, rule: dict) -> str:
    for key, sign in (("minimum", "≥"), ("exclusiveMinimum", ">")):
        if key in rule:
            word += f" {sign} {rule[key]:,g}"
    for key, sign in (("maximum", "≤"), ("exclusiveMaximum", "&lt;")):
        if key in rule and rule[key] < 10**6:
            word += f", {sign} {rule[key]:,g}"
    return word


def main() -> None:
    """Write both files."""
    SCHEMA_FILE.write_text(json.dumps(json_schema(), indent=2, ensure_ascii=False) + "\n", encoding="utf-8")
    REFERENCE_PAGE.write_text(reference_page(), encoding="utf-8")
