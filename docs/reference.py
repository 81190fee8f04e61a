"""The parts of the reference that are written from the code.

`<!-- generated: odd_files refused -->` and `<!-- end -->` enclose such a part of a stored page. Commands, formats and columns
stand only in the book.
"""

import re
import subprocess
import sys
import tempfile
import textwrap
from argparse import Action
from collections.abc import Iterator
from pathlib import Path

import yaml

import sparsurf_study.columns
from sparsurf import registry
from sparsurf.cli import command
from sparsurf_study import catalogue

PLACE = re.compile(
    r"(?P<mark><!-- generated: (?P<name>\w+)(?P<words>(?: \w+)*) -->\n).*?(?P<end><!-- end -->)", re.S
)


def commands() -> Iterator[str]:
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


def _option(action: Action) -> str:
    """A row for one option; many choices stand in its meaning, where they can wrap."""
    few = len(action.choices or ()) in (1, 2)
    value = f"{{{','.join(action.choices)}}}" if few else action.metavar or action.dest.upper()
    names = [f"{name}{f' {value}' * (action.nargs != 0)}" for name in action.option_strings] or [value]
    listed = "%(choices)s" in (action.help or "")
    meaning = (action.help or "").replace("%(choices)s", ", ".join(action.choices or ()))
    meaning = meaning.replace("%%", "%").replace("|", "\\|").replace("<", "&lt;")
    meaning += "" if few or listed or not action.choices else f": {', '.join(action.choices)}"
    return f"| {', '.join(f'`{name}`' for name in names)} | {meaning} |\n"


HEADINGS = {  # of results/README.md, by the folder of the outputs
    "": "The run",
    "<protein>": "A protein: `<protein>/`",
    "<protein>/<conformation>": "A conformation: `<protein>/<conformation>/`",
    "pairs/<pair>": "A pair: `pairs/<pair>/`",
    "changes/<comparison>": "Two forms: `changes/<comparison>/`",
}


def outputs() -> Iterator[str]:
    """A section for each part of a run with its outputs, and the conditions under which a study has them."""
    for folder, heading in HEADINGS.items():
        yield f"## {heading}\n\n| rule | file | when | content |\n|---|---|---|---|\n"
        before: tuple[str, ...] = ()
        for output in catalogue.outputs().values():
            if output.folder == folder:
                rule = ", ".join(output.rules) if output.rules != before else ""
                when = ", ".join(name for name in catalogue.CONDITIONS if name in output.when)
                yield f"| {rule} | `{output.name}` | {when} | {output.content} |\n"
                before = output.rules
        yield "\n"
    yield "## The conditions\n\n"
    for name, meaning in catalogue.CONDITIONS.items():
        yield f"- {name}: {meaning}\n"
    yield "\n"


def columns() -> Iterator[str]:
    """A section for each table of a run or command: what a row is, and its columns."""
    for key, table in sparsurf_study.columns.tables().items():
        yield f"### `{key}`\n\nA row is {table.row}.\n\n| column | type | unit | meaning |\n|---|---|---|---|\n"
        for column in table.columns:
            name, meaning = f"`{column.name}`{'*' * column.optional}", column.meaning.replace("|", "\\|")
            yield f"| {name} | {column.type} | {column.unit} | {meaning} |\n"
        yield "\n"


ROOT = Path(__file__).parent.parent
ODD_FILES = ROOT / "tests" / "library" / "odd_files.yaml"
# Of one structure: all of its rules are known before any of them runs
DRAWN_STUDY = "proteins: {p: {structure: data/tdp43/topology.pdb}}"


def odd_files(outcome: str) -> Iterator[str]:
    """A row for each odd file with this outcome, from the list that the tests of the corpus check."""
    said = "what the error states" if outcome == "refused" else "what sparsurf does"
    yield f"| file | {said} | test case |\n|---|---|---|\n"
    for cells in yaml.safe_load(ODD_FILES.read_text(encoding="utf-8"))[outcome]:
        file, does, case = (cell.replace("|", "\\|") for cell in cells)
        yield f"| {file} | {does} | `{case}` |\n"


def rules() -> Iterator[str]:
    """Draw the rules of a study of one structure, as Snakemake has them; edges that follow from others are left out."""
    options = "--snakefile Snakefile --workflow-profile none --cores 1 --rulegraph mermaid-js --configfile"
    with tempfile.NamedTemporaryFile("w", suffix=".yaml") as config:
        print(DRAWN_STUDY, file=config, flush=True)
        command = [sys.executable, "-m", "snakemake", *options.split(), config.name]
        done = subprocess.run(command, cwd=ROOT, check=True, capture_output=True, text=True)
    names = dict(re.findall(r"(id\d+)\[(\w+)\]", done.stdout))
    after: dict[str, set[str]] = {name: set() for name in sorted(names.values())}
    for before, rule in re.findall(r"(id\d+) --> (id\d+)", done.stdout):
        after[names[before]].add(names[rule])

    def below(name: str) -> set[str]:
        return {name}.union(*map(below, after[name]))

    yield "```mermaid\nflowchart TB\n"
    for name, followers in after.items():
        through = set[str]().union(*(below(other) - {other} for other in followers))
        yield from (f"    {name} --> {other}\n" for other in sorted(followers - through))
    yield "```\n"


def formats() -> Iterator[str]:
    """A row for each format of files that hold dots, meshes, spheres or tables: its suffix, content, and what it carries."""
    yield "| suffix | format | carries | read | written |\n|---|---|---|---|---|\n"
    for name, choice in registry.TABLE["format"].items():
        cells = [f"`.{name}`", f"{choice.label}: {choice.meaning}", ", ".join(choice.carries)]
        cells += ["yes" if holds else "" for holds in (choice.is_read, choice.is_written)]
        yield f"| {' | '.join(cells)} |\n"


def renewed(text: str) -> str:
    """Return a page with its generated parts as the code has them now."""
    return PLACE.sub(
        lambda part: part["mark"] + "".join(PARTS[part["name"]](*part["words"].split())) + part["end"], text
    )


PARTS = {"outputs": outputs, "odd_files": odd_files, "rules": rules}


def commands_and_formats() -> str:
    """Return the page of the commands and of the formats that they read and write."""
    return f"# Commands\n\n{''.join(commands())}## Formats of files\n\n{''.join(formats())}"
