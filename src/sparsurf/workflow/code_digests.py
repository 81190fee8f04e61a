"""Digests of the code behind a rule and of the files that a config names: what a rule's results follow from."""

import hashlib
import os
from functools import cache
from pathlib import Path

from sparsurf.workflow import definitions

HOME = Path(__file__).resolve().parents[3]  # of scripts/ and src/
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
    settings, drawn = {}, [f"../src/sparsurf/report/figures/{name}.py" for name in figures]
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
def digest(*scripts, but=()):
    """Digest of the definitions that scripts reach, see `definitions.reached`; of their paths from scripts/.

    Files with one of `but` in their path do not count, nor what they alone use.

    Passed to the rules as a parameter, so that an edit reruns exactly the steps that use what was edited.
    """
    found = [definitions.reached((HOME / "scripts" / script).resolve(), but) for script in scripts]
    definitions.keep()
    named = sorted((str(path.relative_to(HOME)), each) for one in found for path, each in one.items())
    return hashlib.sha256(repr(named).encode()).hexdigest()[:16]


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
