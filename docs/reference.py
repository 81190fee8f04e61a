"""The tables of the reference, from parsers and the list of columns."""

import re
import textwrap

import sparsurf_study.columns
from sparsurf.cli import command

PLACE = re.compile(r"(?P<mark><!-- generated: (?P<name>\w+) -->\n)(?P<old>.*?)(?P<end><!-- end -->)", re.S)


def commands():
    """A section for each command: what it does, its options and examples, from its parser."""
    yield command.EPILOG.partition("examples:\n")[0] + "\n"
    first = {}  # command that shows a group of options first
    for name in command.COMMANDS:
        parser = command.build_parser(name)[1]
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


def columns():
    """A section for each table of a run or command: what a row is, and its columns."""
    for key, table in sparsurf_study.columns.tables().items():
        yield f"### `{key}`\n\nA row is {table.row}.\n\n| column | type | unit | meaning |\n|---|---|---|---|\n"
        for column in table.columns:
            name, meaning = f"`{column.name}`{'*' * column.optional}", column.meaning.replace("|", "\\|")
            yield f"| {name} | {column.type} | {column.unit} | {meaning} |\n"
        yield "\n"


def filled(text):
    """A page with its generated parts."""
    return PLACE.sub(lambda found: found["mark"] + "".join(globals()[found["name"]]()) + found["end"], text)


def fill(app, name, source):
    """The same, as Sphinx calls it."""
    source[0] = filled(source[0])
