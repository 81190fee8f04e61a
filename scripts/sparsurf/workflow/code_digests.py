"""Digests of the code behind a rule: the library modules that its script imports, and the data files these read; and of
the files that a config names."""

import ast
import hashlib
import os
from functools import cache
from pathlib import Path

SCRIPTS = Path(__file__).parents[2]
WHOLE, ENDS = 2**26, 2**20  # bytes


def made_by(config, script, *sections, figures=()):
    """Params of a rule: what its results follow from beside its inputs.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    script : str
    sections : keys of the config that the script works by; 'patches.D_link': of `patches` that key alone
    figures : names of the figures that the script draws

    Returns
    -------
    dict: `settings`, if it goes by any, without `run`, which only says whether there is such a job; `code`, see `digest`
    """
    settings, drawn = {}, [f"sparsurf/report/figures/{name}.py" for name in figures]
    for section in sections:
        place, value, (*above, key) = settings, config, section.split(".")
        for each in above:
            place, value = place.setdefault(each, {}), value[each]
        place[key] = _without_run(value[key])
    return ({"settings": settings} if sections else {}) | {"code": digest(script, *drawn)}


def _without_run(value):
    """Settings without `run`, at any depth."""
    if not isinstance(value, dict):
        return value
    return {key: _without_run(each) for key, each in value.items() if key != "run"}


@cache
def digest(script, *more):
    """Digest of a script, of every library module that it imports, directly or not, and of their data files.

    `more` are files below scripts/ that the script imports by a name it is given.

    Passed to the rules as a parameter, so that editing a module reruns exactly the steps that use it.
    """
    content = b"\0".join(
        str(path.relative_to(SCRIPTS)).encode() + path.read_bytes() for path in files(script, *more)
    )
    return hashlib.sha256(content).hexdigest()[:16]


@cache
def content(path):
    """Digest of a file that a config names, empty where there is none; of a large one, of its size and ends.

    Passed to the rules as a parameter: a file that another takes the place of need not be newer (`cp -p`, `mv`, `rsync -a`).
    """
    path = Path(path)
    if not path.is_file():
        return ""
    size = path.stat().st_size
    with path.open("rb") as stream:
        parts = [stream.read(WHOLE if size <= WHOLE else ENDS)]
        if size > WHOLE:
            stream.seek(-ENDS, os.SEEK_END)
            parts.append(stream.read())
    return hashlib.sha256(b"".join([b"%d " % size, *parts])).hexdigest()[:16]


def files(*scripts):
    """Files that the work of scripts depends on, sorted; a data file is one that a module beside it names."""
    found, waiting = set(), [SCRIPTS / script for script in scripts]
    while waiting:
        path = waiting.pop()
        if path not in found:
            found.add(path)
            waiting += _needed(path) if path.suffix == ".py" else []
    return sorted(found)


def _needed(path):
    """Library modules that a Python file imports, with the packages that hold them, and its data files."""
    return [each for each in _named(path, path.read_text(encoding="utf-8"), SCRIPTS) if each.is_file()]


@cache
def _named(path, text, scripts):
    """Files that a module of this text may mean; kept, since most rules share most modules."""
    candidates = []
    for node in ast.walk(ast.parse(text)):
        if isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] == "sparsurf":
            module = scripts.joinpath(*node.module.split("."))
            packages = [module, *module.parents]
            candidates += [each / "__init__.py" for each in packages[: packages.index(scripts)]]
            candidates.append(module.with_suffix(".py"))
            candidates += [module / f"{alias.name}.py" for alias in node.names]
            candidates += [module / alias.name / "__init__.py" for alias in node.names]
        elif isinstance(node, ast.Constant) and isinstance(node.value, str) and "." in node.value[1:]:
            candidates += (
                [path.with_name(node.value)] if len(node.value) < 100 and "/" not in node.value else []
            )
    return candidates
