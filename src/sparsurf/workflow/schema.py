"""The schema of a config: what its keys may hold, their defaults, and what an entry of `proteins` says by them.

Beside the words of JSON Schema, config.schema.yaml has some of its own: `enum: samplers` takes the names of a registry;
`was` gives names of earlier releases; `file`, `chosen` and `type` of a protein's key say what it is for.
"""

from dataclasses import make_dataclass
from pathlib import Path

import yaml

from sparsurf.simulation.protocol import BEFORE
from sparsurf.workflow.download import PDB_URL, file_name
from sparsurf.workflow.registries import names


def _filled(rule):
    """Copy of a schema in which names of registries stand for the registries."""
    if isinstance(rule, list):
        return [_filled(each) for each in rule]
    if not isinstance(rule, dict):
        return rule
    filled = {key: _filled(each) for key, each in rule.items()}
    return filled | {"enum": [*names(rule["enum"])]} if isinstance(rule.get("enum"), str) else filled


QUICK = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # an eighth of the time, where libyaml is there
SCHEMA = _filled(yaml.load(Path(__file__).with_name("config.schema.yaml").read_text(encoding="utf-8"), QUICK))
OF_PROTEIN = SCHEMA["$defs"]["protein"]["properties"]


def keys_of_protein(word, value=True):
    """Keys of a protein whose rule in the schema says so, like ('file',) or ('type', 'array')."""
    return tuple(key for key, rule in OF_PROTEIN.items() if rule.get(word) == value)


def with_defaults(value, schema=SCHEMA):
    """Copy of a mapping in which missing keys of the schema take their defaults.

    Its keys stand in the order of the schema: one moved or written out asks for nothing to be made again. Of a section with
    the key `run`, true and false stand for that key alone.
    """
    if isinstance(value, bool) and "run" in schema.get("properties", {}):
        value = {"run": value}
    if not isinstance(value, dict):
        return value
    known = {
        key: with_defaults(value[key] if key in value else rule["default"], rule)
        for key, rule in schema.get("properties", {}).items()
        if key in value or "default" in rule
    }
    return known | {key: each for key, each in value.items() if key not in known}


def whole(value, rule=SCHEMA):
    """Copy of a value in which a number like 3.0 is 3 where the schema wants a whole number, and 4 the default 4.0."""
    if "$ref" in rule:
        rule = SCHEMA["$defs"][rule["$ref"].rsplit("/", 1)[-1]]
    for alternative in rule.get("anyOf", ()):
        value = whole(value, alternative)
    if rule.get("type") == "integer" and isinstance(value, float) and value.is_integer():
        return int(value)
    if rule.get("type") == "number" and type(value) is int and value == rule.get("default"):
        return rule["default"]
    if isinstance(value, list) and isinstance(rule.get("items"), dict):
        return [whole(each, rule["items"]) for each in value]
    if isinstance(value, dict):
        others = rule.get("additionalProperties") or {}
        return {key: whole(each, rule.get("properties", {}).get(key, others)) for key, each in value.items()}
    return value


Entry = make_dataclass("Entry", [(key, object, None) for key in OF_PROTEIN], frozen=True)


class Protein(Entry):
    """An entry of the config's `proteins`: its keys as attributes (see the schema), None where it does not give one."""

    @property
    def source(self):
        """URL that the structure is fetched from; None for local files."""
        return self.url or (PDB_URL.format(self.pdb.upper()) if self.pdb else None)

    @property
    def download(self):
        """Name of the fetched file; None for local files."""
        return file_name(self.source) if self.source else None

    @property
    def files(self):
        """Local files of a structure, by key."""
        return self._given(key for key in keys_of_protein("file") if key not in ("surface", "table"))

    @property
    def chosen(self):
        """What of the file takes part, as keyword arguments of `read_molecule`."""
        return self._given(keys_of_protein("chosen"))

    @property
    def molecule_options(self):
        """The same for the molecule that enters the study: a simulated one is cut to its part already."""
        before = BEFORE if self.simulate is not None else ()
        return {key: value for key, value in self.chosen.items() if key not in before}

    @property
    def without_meaning(self):
        """Keys that say nothing about a ready surface, where the protein is one."""
        of_atoms = (*keys_of_protein("chosen"), "simulate", "trajectory", "table")
        return [*self._given(of_atoms)] if self.surface else []

    def _given(self, keys):
        return {key: getattr(self, key) for key in keys if getattr(self, key) is not None}


def proteins(config):
    """The proteins of a checked config, by name."""
    return {name: Protein(**entry) for name, entry in config["proteins"].items()}
