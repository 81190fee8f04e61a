"""The outputs of a run, from catalogue.yaml; planning a study imports this, so it needs no numpy."""

from __future__ import annotations

import hashlib
import re
from collections.abc import Collection, Iterable, Mapping
from dataclasses import dataclass
from functools import cache, cached_property
from pathlib import Path
from typing import Any

import yaml

CATALOGUE_FILE = Path(__file__).with_name("catalogue.yaml")
CONDITIONS = {  # what `when` of an output may name
    "surfaces": "the run has surfaces with folders of their own",
    "molecule": "the protein has atoms",
    "sampled": "the grid is evaluated, on this surface or on any of the run",
    "compare": "samplers are compared",
    "fields": "the config names fields",
    "paper": "the run is compared with the paper",
    "fetched": "the structure is downloaded",
    "simulated": "the protein is simulated",
    "ensemble": "one combination is followed over all frames",
    "several_frames": "the trajectory has more than one frame",
    "pairs": "the config has pairs",
    "files_of_pair": "the partners are files instead of proteins of the run",
    "residues": "both partners have atoms",
    "batches": "the structures are analysed in batches",
    "closing": "all other results are there: the first page, and the tables and the crate beside it",
}
SECTIONS = {  # parts of the first page that an output may name
    "files": "the list of the files of the first surface",
    "row": "the files in the row of a surface, in the table of all surfaces",
    "surfaces": "the list of tables below the table of all surfaces",
    "strip": "the pictures of a surface below the answers",
    "gallery": "the figures of a protein or surface",
    "frames": "the tables of a trajectory",
    "frame_figures": "the figures of a trajectory",
    "simulations": "the tables of a simulation",
    "pairs": "the files in the row of a pair",
    "changes": "the files of two forms that are compared",
    "batches": "the folders of the tables of a run in batches",
}
PLACEHOLDER = re.compile(r"<(\w+)>")


@dataclass(frozen=True)
class Output:
    """An output of a run: one entry of the catalogue."""

    path: str  # below results/<run>/; a part such as <protein> stands for a name
    rules: tuple[str, ...]  # of which one writes it
    when: frozenset[str]  # of `CONDITIONS`; a study has it where all hold
    content: str
    title: str  # in Snakemake's report; empty for an output that the report leaves out
    category: str  # there; empty for that of its protein
    caption: str  # a sentence; `content` where the catalogue has none
    sections: tuple[str, ...]  # of `SECTIONS`
    intermediate: bool  # only other rules need it
    row: str  # what a row of a table is; empty for an output that is no table

    @cached_property
    def folder(self) -> str:
        """Folder of the part of a run that it belongs to, such as <protein>/<conformation>; empty for the run."""
        *folders, _ = self.path.split("/")
        named = [k for k, part in enumerate(folders, 1) if part.startswith("<")]
        return "/".join(folders[: named[-1]]) if named else ""

    @cached_property
    def name(self) -> str:
        """Path below `folder`."""
        return self.path[len(self.folder) :].lstrip("/")

    @cached_property
    def wildcards(self) -> str:
        """Path with the wildcards of a rule, such as {protein}/frames.csv."""
        return with_wildcards(self.path)


def with_wildcards(text: str) -> str:
    """Return a text of the catalogue with the wildcards of Snakemake: {protein} for <protein>."""
    return PLACEHOLDER.sub(r"{\1}", text)


@cache
def content() -> dict[str, Any]:
    """Return what catalogue.yaml says."""
    # the compiled loader is ten times faster, and every job of a study reads this
    return yaml.load(
        CATALOGUE_FILE.read_text(encoding="utf-8"), getattr(yaml, "CSafeLoader", yaml.SafeLoader)
    )


@cache
def checksum() -> str:
    """Return a short hash of the catalogue: the rules that list its words have it among their parameters."""
    return hashlib.sha256(CATALOGUE_FILE.read_bytes()).hexdigest()[:16]


@cache
def outputs() -> dict[str, Output]:
    """Return all outputs in the order of the catalogue, by path."""
    return {path: _output(path, entry) for path, entry in content()["outputs"].items()}


def _output(path: str, entry: Mapping[str, Any]) -> Output:
    """Return an output as its entry of the catalogue says it."""
    rule = entry["rule"]
    return Output(
        path,
        rules=(rule,) if isinstance(rule, str) else tuple(rule),
        when=frozenset(entry.get("when", ())),
        content=entry["content"],
        title=entry.get("title", ""),
        category=entry.get("category", ""),
        caption=entry.get("caption") or sentence(entry["content"]),
        sections=tuple(entry.get("sections", ())),
        intermediate=entry.get("intermediate", False),
        row=entry.get("row", ""),
    )


def sentence(text: str) -> str:
    """Return words as a sentence: with a capital letter and a full stop."""
    return f"{text[:1].upper()}{text[1:]}."


@cache
def outputs_in(folder: str) -> tuple[Output, ...]:
    """Return the outputs of a part of a run that its end asks for, such as those of <protein>/<conformation>."""
    return tuple(
        output for output in outputs().values() if output.folder == folder and not output.intermediate
    )


def requested(folder: str, conditions: Collection[str]) -> list[Output]:
    """Return the outputs of a part of a run that a study asks for under these conditions."""
    return [output for output in outputs_in(folder) if output.when.issubset(conditions)]


def conditions_of_protein(config: Mapping[str, Any], protein: str) -> set[str]:
    """Return the conditions that a checked config sets for a protein and its surfaces, but not those of its frames."""
    entry = config["proteins"][protein]
    holds = {
        "molecule": "surface" not in entry,
        "sampled": entry.get("sampling", config["sampling"]["run"]),
        "compare": config["compare"]["run"],
        "fields": config["fields"],
        "paper": "paper" in config,
    }
    return {name for name, value in holds.items() if value}


def conditions_of_pair(config: Mapping[str, Any], pair: str) -> set[str]:
    """Return the conditions that a checked config sets for a pair."""
    partners = config["pairs"][pair].get("proteins", ())
    have_atoms = not any("surface" in config["proteins"][name] for name in partners)
    return {"residues"} if have_atoms else set()


def caption_file(output: Output) -> str:
    """Return the name of the file in report/captions/ that has the caption of an output for Snakemake's report."""
    return re.sub(r"\W+", "_", output.path).strip("_") + ".rst"


def first_of_each_rule(listed: Iterable[Output]) -> list[Output]:
    """Return one output of each rule: whoever asks for it also gets the others."""
    first: dict[tuple[str, ...], Output] = {}
    for output in listed:
        first.setdefault(output.rules, output)
    return [*first.values()]


@cache
def in_section(name: str) -> tuple[Output, ...]:
    """Return the outputs of a section of the first page."""
    return tuple(output for output in outputs().values() if name in output.sections)


def output_of(path: str) -> Output | None:
    """Return the output that a file of a run is, by its path below results/<run>/; None where the catalogue has none."""
    parts = path.split("/")
    fitting = [output for output in _by_depth().get(len(parts), ()) if _fits(output.path.split("/"), parts)]
    # the most specific: pairs/pairs.csv is of no protein, and <file>.json is no <file>
    return min(fitting, key=lambda output: (output.path.count("<"), -len(output.path)), default=None)


@cache
def _by_depth() -> dict[int, list[Output]]:
    """Return the outputs by the number of parts of their paths."""
    found: dict[int, list[Output]] = {}
    for output in outputs().values():
        found.setdefault(output.path.count("/") + 1, []).append(output)
    return found


def _fits(pattern: Iterable[str], parts: Iterable[str]) -> bool:
    """Return whether the parts of a path are those of an output, whose placeholders stand for any names."""
    for expected, part in zip(pattern, parts, strict=True):
        if expected.startswith("<"):
            if not part.endswith(expected.rpartition(">")[2]):
                return False
        elif expected != part:
            return False
    return True
