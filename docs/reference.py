"""The tables of the reference, from parsers, schema and glossary. `.venv/bin/python docs/reference.py` fills config/README.md."""

import re
import textwrap
from pathlib import Path

import sparsurf
from sparsurf.cli import command
from sparsurf.workflow.schema import SCHEMA

ROOT = Path(__file__).resolve().parents[1]
PLACE = re.compile(r"(?P<mark><!-- generated: (?P<name>\w+) -->\n)(?P<old>.*?)(?P<end><!-- end -->)", re.S)
CONFIG = ROOT / "config" / "README.md"


def commands():
    """A section for each command: what it does, its options and examples, from its parser."""
    yield command.EPILOG.partition("examples:\n")[0] + "\n"
    first = {}  # command that shows a group of options first
    for name in command.COMMANDS:
        parser = command.build_parser(name)[0]._subparsers._group_actions[0].choices[name]
        words, _, examples = parser.epilog.partition("examples:\n")
        yield f"## {name}\n\n{parser.description}\n\n```bash\n{textwrap.dedent(examples)}```\n\n{words}\n\n"
        for group in parser._action_groups:
            rows = "".join(_option(action) for action in group._group_actions if action.dest != "help")
            if rows.count("\n") > 1 and (shown := first.setdefault(rows, name)) != name:
                yield f"*{group.title}*: as of [{shown}](#{shown})\n\n"
            elif rows:
                yield f"| {group.title.replace('positional arguments', 'files')} | |\n|---|---|\n{rows}\n"


def _option(action):
    """A row for one option; many choices stand in its meaning, where they can wrap."""
    few = len(action.choices or ()) in (1, 2)
    value = f"{{{','.join(action.choices)}}}" if few else action.metavar or action.dest.upper()
    names = [f"{name}{f' {value}' * (action.nargs != 0)}" for name in action.option_strings] or [value]
    meaning = (action.help or "").replace("%%", "%").replace("|", "\\|").replace("<", "&lt;")
    meaning += "" if few or not action.choices else f": {', '.join(action.choices)}"
    return f"| {', '.join(f'`{name}`' for name in names)} | {meaning} |\n"


def glossary():
    """The words of the library's one glossary, as a definition list."""
    text = sparsurf.__doc__.partition("Glossary")[2].partition("\n\n")[2]
    yield "```{glossary}\n"
    for word, meaning in re.findall(r"^(\S.*?)  +(.*(?:\n +.*)*)", text, re.M):
        yield f"{word}\n  {' '.join(meaning.split())}\n\n"
    yield "```\n"


def keys():
    """Tables of all keys of a config: what each means, takes, and is without; one for each key that holds others."""
    head = "| key | meaning | takes | default |\n|---|---|---|---|\n"
    alone, groups = [], []
    for key, rule in SCHEMA["properties"].items():
        rows = "".join(_key(name, own) for name, own in _rules({"properties": {key: rule}}, ""))
        if rows.count("\n") == 1:
            alone.append(rows)
        else:
            rows = "".join(_key(name, own) for name, own in _rules(rule, ""))
            groups.append(f"\n## {key}\n\n{rule['description']}\n\n{head}{rows}")
    yield from ["\n", head, *alone, *groups, "\n"]


def _key(name, rule):
    """A row for one key."""
    meaning = rule.get("description", "").rstrip(".").replace("|", "\\|").replace("<", "&lt;")
    known = rule.get("default", rule.get("otherwise"))  # otherwise: what the code takes where nothing is said
    default = f"`{_shown(known)}`" if known not in (None, {}) else ""
    return f"| `{name}` | {meaning} | {_takes(rule)} | {default} |\n"


def _rules(rule, name):
    """Dotted names of the keys below a rule, and their rules."""
    rule = _resolved(rule)
    each_own = rule.get("additionalProperties")
    below = rule.get("properties", {}) | ({"<name>": each_own} if isinstance(each_own, dict) else {})
    for key, each in below.items():
        own, own_name = _resolved(each), f"{name}{key}"
        if key != "<name>" or "properties" not in own:
            yield own_name, own
        yield from _rules(own, f"{own_name}.")


def _resolved(rule):
    """A rule with what it refers to."""
    if "$ref" not in rule:
        return rule
    return SCHEMA["$defs"][rule["$ref"].rsplit("/", 1)[-1]] | {k: v for k, v in rule.items() if k != "$ref"}


def _takes(rule):
    """What a value may be, in a few words."""
    rule = _resolved(rule)
    if "anyOf" in rule:
        return " or ".join(_takes(each) for each in rule["anyOf"])
    if "const" in rule:
        return f"`{_shown(rule['const'])}`"
    if "enum" in rule:
        return ", ".join(f"`{_shown(each)}`" for each in rule["enum"])
    kind = rule.get("type")
    if kind == "array":
        return f"list of {_takes(rule.get('items', {'type': 'string'}))}"
    if kind in ("integer", "number"):
        low = rule.get("minimum", rule.get("exclusiveMinimum"))
        above = "above" if "exclusiveMinimum" in rule else "from"
        high = rule.get("maximum", rule.get("exclusiveMaximum"))
        words = ["whole number" if kind == "integer" else "number"]
        words += [f"{above} {low:,g}"] if low is not None else []
        words += [f"to {high:,g}"] if high is not None and high < 1e6 else []
        return " ".join(words)
    return {"boolean": "`true`, `false`", "object": "keys", "string": "text"}.get(kind, "")


def _shown(value):
    """A value as YAML shows it on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, dict):
        return "{" + ", ".join(f"{key}: {_shown(each)}" for key, each in value.items()) + "}"
    return f"[{', '.join(map(_shown, value))}]" if isinstance(value, list) else str(value)


def filled(text):
    """A page with its generated parts."""
    return PLACE.sub(lambda found: found["mark"] + "".join(globals()[found["name"]]()) + found["end"], text)


def fill(app, name, source):
    """The same, as Sphinx calls it."""
    source[0] = filled(source[0])


if __name__ == "__main__":
    CONFIG.write_text(filled(CONFIG.read_text(encoding="utf-8")), encoding="utf-8")
