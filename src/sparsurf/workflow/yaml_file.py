"""The YAML file of a config, read so that every mistake of writing becomes a sentence with its line."""

import math
import re
from pathlib import Path

import yaml

from sparsurf import InputError

MERGE = "tag:yaml.org,2002:merge"
MOST_VALUES, MOST_BYTES = 40_000, 2**21  # of a config, values with its aliases written out; read in about 2 s
OTHER_BASE = re.compile(r"[+-]?(\d[\d_]*(:\d[\d_]*)+(\.\d*)?|0[0-7_]+)")  # 1:30 is 90 to YAML, 010 is 8


class _Strict(yaml.SafeLoader):
    """YAML that refuses a key given twice, instead of forgetting the first, and keys that are not strings."""

    def get_single_node(self):
        node = super().get_single_node()
        if node is not None and _values(node, {}) > MOST_VALUES:
            raise InputError(f"its aliases stand for more than {MOST_VALUES} values; write them out.")
        return node

    def construct_object(self, node, deep=False):
        try:
            value = super().construct_object(node, deep)
        except (KeyError, AttributeError, TypeError):  # PyYAML's, of a value that its tag does not allow
            tag, line = node.tag.rpartition(":")[2], node.start_mark.line + 1
            raise InputError(f"the value in line {line} is no {tag}; correct it or remove !!{tag}.") from None
        if type(value) in (int, float) and OTHER_BASE.fullmatch(node.value):
            raise InputError(
                f"{node.value} in line {node.start_mark.line + 1} is the number {value} to YAML; "
                "write that number, or put it in quotes."
            )
        return value

    def construct_mapping(self, node, deep=False):
        seen = set()
        for key, _ in node.value:
            name = MERGE if key.tag == MERGE else self.construct_object(key, deep=True)
            line = key.start_mark.line + 1
            if not isinstance(name, str):
                raise InputError(
                    f"the key {key_text(key)} in line {line} is not read as a string; put it in quotes."
                )
            if name in seen:
                name = "<<" if name == MERGE else name
                raise InputError(
                    f"the key {name!r} stands twice, the second time in line {line}; remove or rename one."
                )
            seen.add(name)
        return super().construct_mapping(node, deep)


def _values(node, known):
    """How many values a node stands for, each alias written out; `known` has them by node."""
    if id(node) not in known:
        known[id(node)] = math.inf  # until it is known: a node that holds itself has no end
        parts = [part for item in node.value for part in (item if isinstance(item, tuple) else (item,))]
        inside = parts if not isinstance(node, yaml.ScalarNode) else ()
        known[id(node)] = 1 + sum(_values(part, known) for part in inside)
    return known[id(node)]


def key_text(node):
    """A key as it stands in the file, if it is one word."""
    return node.value if isinstance(node.value, str) else "of several parts"


def read_config(path):
    """The config in a YAML file.

    Parameters
    ----------
    path : str

    Returns
    -------
    dict

    Raises
    ------
    InputError : one sentence, with the line where there is one
    """
    name = Path(path).name
    try:
        content = Path(path).read_bytes()
        if len(content) > MOST_BYTES or content.count(b",") + content.count(b"\n") > MOST_VALUES:
            raise InputError(
                f"it has more than {MOST_VALUES} values or {MOST_BYTES} bytes; list proteins or pairs in a CSV file."
            )
        config = yaml.load(content.decode("utf-8-sig"), _Strict)
    except OSError as error:
        raise InputError(f"config: {path} cannot be read: {error.strerror}.") from None
    except UnicodeDecodeError as error:
        line = content[: error.start].count(b"\n") + 1
        raise InputError(f"config: {name} is not UTF-8, see line {line}; store it in UTF-8.") from None
    except yaml.YAMLError as error:
        raise InputError(f"config: {name} is not valid YAML{_where(error, content)}.") from None
    except InputError as error:
        raise InputError(f"config: {name}: {error}") from None
    except (
        RecursionError,
        ValueError,
    ) as error:  # nested or holding itself without end; a date that is none, an int of too many digits
        reason = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise InputError(f"config: {name} is not valid YAML: {reason}.") from None
    if not isinstance(config, dict):
        kind = (
            "is empty" if config is None else f"holds {'a list' if isinstance(config, list) else 'no keys'}"
        )
        raise InputError(f"config: {name} {kind}; it must hold keys with values, at least `proteins`.")
    return config


def _where(error, content):
    """Line and reason of a YAML error, where it tells them."""
    reason = getattr(error, "problem", None) or getattr(error, "reason", None) or str(error).splitlines()[0]
    mark = getattr(error, "problem_mark", None)
    line = (
        mark.line + 1
        if mark
        else content.decode("utf-8-sig")[: getattr(error, "position", 0)].count("\n") + 1
    )
    return f" in line {line}: {reason}"
