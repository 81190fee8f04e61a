"""The list of mistakes to plant, and whether each still has its place."""

import tomllib
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
SCRIPTS = Path("scripts")


def mistakes():
    """(file below scripts/, old text, new text, arguments for pytest) of every mistake."""
    listed = tomllib.loads(Path(__file__).with_name("mistakes.toml").read_text("utf-8"))
    return [(file, *each) for file, several in listed.items() for each in several]


def without_place():
    """Sentences on mistakes whose old text does not stand exactly once in its file, or that change nothing."""
    for file, old, new, _ in mistakes():
        path = ROOT / SCRIPTS / file
        count = path.read_text("utf-8").count(old) if path.is_file() else 0
        if count != 1 or old == new:
            yield f"{file}: {old!r} stands there {count} times"
