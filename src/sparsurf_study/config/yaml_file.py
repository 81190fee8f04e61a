"""Strict YAML: a mistake of writing becomes one sentence with its line."""

import re
from pathlib import Path
from typing import Any

import yaml

from sparsurf.errors import InputError

MERGE = "tag:yaml.org,2002:merge"
MAX_VALUES, MAX_CONFIG_BYTES = 40_000, 2**21  # A config of this size is read in about 2 s.
OTHER_BASE = re.compile(r"[+-]?(\d[\d_]*(:\d[\d_]*)+(\.\d*)?|0[0-7_]+)")  # 1:30 is 90 in YAML, 010 is 8

DEFAULT_RUN = "default"
MOST_OF_RUN = 100  # characters of the name of a run


class _StrictLoader(yaml.SafeLoader):
    """YAML without repeated keys, keys that are not strings and numbers in other bases."""

    def construct_object(self, node: yaml.Node, deep: bool = False) -> Any:
        line = node.start_mark.line + 1
        try:
            value = super().construct_object(node, deep)
        except (KeyError, AttributeError, TypeError):  # the tag does not allow the value
            tag = node.tag.rpartition(":")[2]
            raise InputError(
                f"the value in line {line} is not of the type {tag}; correct it or remove !!{tag}."
            ) from None
        if type(value) in (int, float) and OTHER_BASE.fullmatch(node.value):
            raise InputError(
                f"{node.value} in line {line} is the number {value} in YAML; write that number, or put it in quotes."
            )
        return value

    def construct_mapping(self, node: yaml.MappingNode, deep: bool = False) -> dict:
        seen = set()
        for key, _ in node.value:
            name = MERGE if key.tag == MERGE else self.construct_object(key, deep=True)
            line = key.start_mark.line + 1
            if not isinstance(name, str):
                text = key.value if isinstance(key.value, str) else "of several parts"
                raise InputError(f"the key {text} in line {line} is not read as a string; put it in quotes.")
            if name in seen:
                name = "<<" if name == MERGE else name
                raise InputError(
                    f"the key {name!r} occurs twice, again in line {line}; remove or rename one."
                )
            seen.add(name)
        return super().construct_mapping(node, deep)


def read_config(path: str | Path) -> dict:
    """Read the config in a YAML file; an error names the line where there is one."""
    name = Path(path).name
    try:
        content = Path(path).read_bytes()
        if len(content) > MAX_CONFIG_BYTES or content.count(b",") + content.count(b"\n") > MAX_VALUES:
            raise InputError(
                f"it has more than {MAX_VALUES} values or {MAX_CONFIG_BYTES} bytes; list proteins or pairs in a CSV file."
            )
        config = yaml.load(content.decode("utf-8-sig"), _StrictLoader)
    except OSError as error:
        raise InputError(f"config: {path} cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"config: {name} is not UTF-8, see line {line}; store it in UTF-8.") from None
    except yaml.YAMLError as error:
        raise InputError(f"config: {name} is not valid YAML{_reason(error, content)}.") from None
    except InputError as error:
        raise InputError(f"config: {name}: {error}") from None
    except (RecursionError, ValueError) as error:  # also an impossible date, or an int of too many digits
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(f"config: {name} is not valid YAML: {reason}.") from None
    if not isinstance(config, dict):
        kind = "a list" if isinstance(config, list) else "no keys"
        problem = "is empty" if config is None else f"contains {kind}"
        raise InputError(f"config: {name} {problem}; it must contain keys with values, such as `proteins`.")
    return config


def run_of_config(path: str | Path) -> str:
    """Return the name of a run whose config gives none: that of the config file, with underscores for special characters.

    Raise InputError where nothing of it is left, since such configs would share a folder of results.
    """
    name = re.sub(r"[^A-Za-z0-9_.-]", "_", Path(path).stem).lstrip("._-")
    if not name:
        raise InputError(
            f"config: {Path(path).name} has no letter from A to Z and no digit in its name, which is to name the folder of its "
            "results; write a `run` into it."
        )
    return name[:MOST_OF_RUN]


def _reason(error: yaml.YAMLError, content: bytes) -> str:
    """Return the line and reason of a YAML error."""
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error).splitlines()[0]
    if mark := getattr(error, "problem_mark", None):
        return f" in line {mark.line + 1}: {reason}"
    before = content.decode("utf-8-sig")[: getattr(error, "position", 0)]
    return f" in line {before.count(chr(10)) + 1}: {reason}"
