"""The ledger of a run: a record for each job, of what it read, wrote and computed with, in results/<run>/.ledger/.

`job()` writes the record of a job when its outputs appear. Before Snakemake starts, `disagreements` compares all records with the
disk; `changed_results` hands what disagrees to the rules, which make it again.
"""

import importlib.metadata
import json
import os
import tempfile
import time
from base64 import urlsafe_b64encode
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping, Sequence, Set
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field
from graphlib import TopologicalSorter
from pathlib import Path
from typing import Any

from sparsurf.errors import InputError
from sparsurf.files import pluralise
from sparsurf_study.catalogue import output_of
from sparsurf_study.workflow.checksums import Checksums, Stamp, stamp, stamps, write_json

RECORD_FORMAT = 1  # of a record; a higher number is of a newer version of this program
FOLDER, LOGS = ".ledger", "logs"  # of a run; a record lies in the one as the log of its job in the other
CHECKSUMS = ".checksums.json"  # in the ledger: see `Checksums`
CONFIG = ".config.json"  # in the ledger: the config file of the last run
FOLDERS = ".folders"  # in the ledger: the same of each folder that jobs read
LIBRARIES = ("numpy", "scipy", "mdtraj", "gemmi", "numba")  # that compute
MOST_FILES, MOST_BYTES = 10_000, 10 * 2**30  # of a run whose files are all read before it continues
MOST_BYTES_OF_PATH, MOST_BYTES_OF_NAME = 4096, 255  # on Linux and macOS at most
MOST_LINES = 20  # about results that disagree in the same way; of more, their number is said
TO_MAKE_AGAIN = "_SPARSURF_TO_MAKE_AGAIN"  # environment variable: a file of results that disagree, with a sentence for each
MOST_CHARACTERS = 254  # of a part of the name of a file of Snakemake's metadata
KEPT_FOLDERS = (("download",), ("simulation",))  # of a protein
PARAMETERS_APART = ("code", "inputs")  # parameters with a place of their own in a record


@dataclass
class Record:
    """What a job read and wrote, by path with the SHA-256; its code, parameters and libraries."""

    rule: str
    outputs: dict[str, str]
    inputs: dict[str, str] = field(default_factory=dict)
    code: str = ""
    config: dict[str, Any] = field(default_factory=dict)
    versions: dict[str, str] = field(default_factory=dict)
    origin: str = "job"  # or "adopted": of a version without records; "partial": written without a job where others failed
    time: float = field(default_factory=time.time)  # of two records of one output, the newer counts
    format: int = RECORD_FORMAT

    def is_sound(self, run: Path) -> bool:
        """Return whether every part is of its type and every output of the run, as in a record that nobody has edited."""
        for part in (self.outputs, self.inputs, self.versions):
            if not (isinstance(part, dict) and all(isinstance(text, str) for text in part.values())):
                return False
        if not (isinstance(self.config, dict) and isinstance(self.time, int | float)):
            return False
        of_run = all(
            path.startswith(f"results/{run.name}/") and ".." not in path.split("/") for path in self.outputs
        )
        return of_run and all(map(is_path, (*self.outputs, *self.inputs)))

    def write(self, path: Path) -> None:
        """Write the record, whole or not at all."""
        write_json(path, asdict(self))


class Entry:
    """The record of a job that runs: begun before it reads its inputs, published when its outputs have appeared."""

    def __init__(self, snakemake: Any) -> None:
        self.rule, self.path = str(snakemake.rule), path_of_record(snakemake.log[0])
        self.paths = [*dict.fromkeys(map(str, snakemake.input))]
        self.params = dict(snakemake.params.items())
        self.before: dict[Path, Stamp] = {}
        self.inputs: dict[str, str] = {}

    def begin(self) -> None:
        """Note the inputs as they are before the job reads them; an earlier record no longer counts."""
        if self.path is None:
            return
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.path.unlink(missing_ok=True)
        self.before = stamps(path for path in self.paths if os.path.exists(path))
        for path in self.paths:
            checksums = self._checksums(path)
            self.inputs |= checksums.of_all([path])
            checksums.save()
        # The checksum at the time of planning decided which jobs run; another content now would leave some of them out of date
        for path, planned in (self.params.get("inputs") or {}).items():
            if self.inputs.get(path) != planned:
                raise InputError(f"{path} was changed after the study had started; run again.")

    def _checksums(self, path: str) -> Checksums:
        """Return checksums that are kept for a folder, which the jobs of all of its conformations read."""
        if self.path is None or not os.path.isdir(path):
            return Checksums()
        folder = next(folder for folder in self.path.parents if folder.name == FOLDER)
        return Checksums(folder / FOLDERS / f"{path.replace('/', '_')}.json")

    def finish(self, written: Mapping[str, Path]) -> None:
        """Write the record of the job and its outputs beside its place; raise InputError if an input was changed meanwhile."""
        if self.path is None:
            return
        for path, seen in self.before.items():
            if not path.exists() or (stamp(path) != seen and not self._is_as_before(path)):
                raise InputError(
                    f"{path} was changed while {self.rule} read it; run again when the file is complete."
                )
        config = {key: value for key, value in self.params.items() if key not in PARAMETERS_APART}
        record = Record(
            rule=self.rule,
            outputs={path: Checksums().of(place) for path, place in written.items()},
            inputs=self.inputs,
            code=str(self.params.get("code", "")),
            config=json.loads(json.dumps(config, default=str)),
            versions=versions(),
        )
        record.write(self._beside(self.path))

    def publish(self) -> None:
        """Give the record its name."""
        if self.path is not None:
            os.replace(self._beside(self.path), self.path)

    def _beside(self, path: Path) -> Path:
        return path.with_name(f".{path.name}.finished")

    def _is_as_before(self, path: Path) -> bool:
        """Return whether an input has its former content, although its times have changed."""
        whole = next(name for name in self.inputs if path == Path(name) or Path(name) in path.parents)
        return Checksums().of_all([whole]).get(whole) == self.inputs[whole]


def path_of_record(log: str | Path) -> Path | None:
    """Return the path of the record of a job with a log results/<run>/logs/...; None for a log elsewhere."""
    parts = Path(log).parts
    for k in range(len(parts) - 1, 1, -1):
        if parts[k] == LOGS and parts[k - 2] == "results":
            return Path(*parts[:k], FOLDER, *parts[k + 1 :]).with_suffix(".json")
    return None


def is_path(text: str) -> bool:
    """Return whether a disk may hold a file of this name."""
    try:
        name = os.fsencode(text)
    except UnicodeEncodeError:
        return False
    parts = name.split(b"/")
    return b"\0" not in name and len(name) < MOST_BYTES_OF_PATH and max(map(len, parts)) <= MOST_BYTES_OF_NAME


def versions() -> dict[str, str]:
    """Return the versions of the libraries that compute."""
    found = {}
    for name in LIBRARIES:
        with suppress(importlib.metadata.PackageNotFoundError):
            found[name] = importlib.metadata.version(name)
    return found


def read_records(run: Path) -> dict[Path, Record]:
    """Return the records of a run by their paths, the newest last, without damaged ones; InputError for a newer version's."""
    records = {}
    for path in (run / FOLDER).rglob("[!.]*.json"):
        if FOLDERS in path.parts:
            continue
        content: Any = None
        with suppress(OSError, ValueError):
            content = json.loads(path.read_text(encoding="utf-8"))
        if (
            isinstance(content, dict)
            and isinstance(number := content.get("format"), int)
            and number > RECORD_FORMAT
        ):
            raise InputError(
                f"{run}/ was written by a newer version of sparsurf, whose records this version cannot read. Use that "
                "version, or write another `run` into the config."
            )
        with suppress(TypeError):
            record = Record(**content)
            if record.is_sound(run):
                records[path] = record
    # by path among equal times, as disks list files in different orders and a later record takes the outputs of an earlier one
    return dict(sorted(records.items(), key=lambda item: (item[1].time, item[0])))


@dataclass
class Disagreements:
    """Results that do not agree with the records of a run, with a sentence where it helps, and lines about the whole run."""

    results: dict[str, str] = field(default_factory=dict)
    lines: list[str] = field(default_factory=list)


def disagreements(run: Path, metadata: Path | None = None) -> Disagreements:
    """Compare the records of a run with the disk.

    With the folder of Snakemake's metadata, results whose metadata it has lost count as well. Without, as plain Snakemake asks,
    downloads and simulations without a record do not, since `adoption` keeps them.
    """
    sizes, records = sizes_of_results(run), read_records(run)
    found = Disagreements()
    if not sizes:
        return found
    stored = Checksums(run / FOLDER / CHECKSUMS)
    is_large = len(sizes) > MOST_FILES or sum(sizes.values()) > MOST_BYTES
    disk = stored if is_large else Checksums()
    if is_large:
        found.lines.append(
            f"{run}/ has more than {MOST_FILES:,} files or {MOST_BYTES // 2**30} GB: their sizes and times tell which of "
            "them were changed. `make check` reads them all."
        )
    owners = {output: record for record in records.values() for output in record.outputs}  # the newest
    by_kind: dict[str, dict[str, str]] = {kind: {} for kind in DISAGREEMENTS}
    for record in records.values():
        outputs = [path for path in record.outputs if owners[path] is record and os.path.exists(path)]
        if outputs and record.origin == "partial":  # their dates make Snakemake write them again
            found.results |= dict.fromkeys(outputs, "")
        elif outputs:
            for kind, path, other in _problems(record, outputs, owners, disk, stored, metadata):
                by_kind[kind][path] = other
                found.results |= dict.fromkeys(outputs, "")
    whole = {path for path in owners if os.path.isdir(path)}
    for path in sizes:
        if path in owners or not whole.isdisjoint(map(str, Path(path).parents)):
            continue
        of_run = Path(path).relative_to(run)
        is_kept = metadata is None and of_run.parts[1:2] in KEPT_FOLDERS
        if _is_of_a_rule(of_run) and not is_kept:
            by_kind["unrecorded"][path] = ""
    found.results |= dict.fromkeys(by_kind["unrecorded"], "")
    stored.save()
    if by_kind["unrecorded"] and not any(record.origin == "job" for record in records.values()):
        found.lines.append(
            f"{run}/ has no records of its jobs, as version 3.0.0 and earlier ones left it: its results are computed again."
        )
        by_kind["unrecorded"] = {}
    for kind, paths in by_kind.items():
        singular, plural = DISAGREEMENTS[kind]
        if len(paths) > MOST_LINES:
            found.lines.append(plural.format(n=len(paths), run=run))
        else:
            found.results |= {
                path: singular.format(result=in_words(path, run), other=other)
                for path, other in paths.items()
            }
    found.lines += other_versions(run, records.values())
    return found


def _is_of_a_rule(path: Path) -> bool:
    """Return whether a rule writes a file of a run, or a folder that holds it; any other file is one of the user."""
    is_part_of_frames = path.match(
        "*/ensemble/*.csv"
    )  # which Snakemake deletes, so that the catalogue has none
    return is_part_of_frames or any(output_of(part.as_posix()) for part in (path, *path.parents[:-1]))


# What is said of one result, and of many
DISAGREEMENTS = {
    "changed": (
        "{result} was changed after its job: it is computed again.",
        "{n} results in {run}/ were changed after their jobs: they are computed again.",
    ),
    "inputs": (
        "{result} was made from another {other}: it is computed again.",
        "{n} results in {run}/ were made from other inputs: they are computed again.",
    ),
    "metadata": (
        "{result} has lost its metadata in .snakemake/: it is computed again.",
        "{n} jobs of {run}/ have lost their metadata in .snakemake/: their results are computed again.",
    ),
    "unrecorded": (
        "{result} has no record of its job: it is computed again.",
        "{n} files in {run}/ have no record of a job: those that this study writes are computed again.",
    ),
}


def _problems(
    record: Record,
    outputs: Sequence[str],
    owners: Mapping[str, Record],
    disk: Checksums,
    stored: Checksums,
    metadata: Path | None,
) -> Iterator[tuple[str, str, str]]:
    """Yield the kind of each disagreement of a record, the result that it is about, and the input or an empty string."""
    for path in outputs:
        if disk.of(path) != record.outputs[path]:
            yield "changed", path, ""
    for path, digest in record.inputs.items():
        now = owners[path].outputs[path] if path in owners else stored.of_all([path]).get(path, digest)
        if now != digest:
            yield "inputs", outputs[0], path
    if metadata is not None and not path_of_metadata(metadata, outputs[0]).is_file():
        yield "metadata", outputs[0], ""


def path_of_metadata(folder: Path, output: str) -> Path:
    """Return the file of Snakemake's metadata of an output, which is named by the output, in base64."""
    name = urlsafe_b64encode(output.encode()).decode()
    parts = [name[k : k + MOST_CHARACTERS] for k in range(0, len(name), MOST_CHARACTERS)]
    return folder.joinpath(*(f"@{part}" for part in parts[:-1]), parts[-1])


def metadata_of(folder: Path, output: str) -> dict | None:
    """Return Snakemake's metadata of an output; None where it has lost them."""
    try:
        return json.loads(path_of_metadata(folder, output).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return None


def sizes_of_results(run: Path) -> dict[str, int]:
    """Return the sizes of all results of a run in bytes, by path; logs, records and hidden files are none."""
    sizes = {}
    for folder, folders, names in os.walk(run):
        folders[:] = [
            name for name in folders if not name.startswith(".") and (folder, name) != (str(run), LOGS)
        ]
        for name in names:
            if not name.startswith("."):
                path = os.path.join(folder, name)
                with suppress(OSError):
                    sizes[path] = os.stat(path).st_size
    return sizes


def note_config(run: Path, config: Path) -> str:
    """Note the config file of a run; return a sentence if the last run was that of another one.

    An edited or moved config is the same one, and a copy of it differs in nothing: only a file that is still there and has
    another content is another config, whose results this run replaces. Paths in the working folder are noted from there.
    """
    note, here = run / FOLDER / CONFIG, Path.cwd()
    former = config
    with suppress(OSError, ValueError, LookupError, TypeError):
        former = Path(json.loads(note.read_text(encoding="utf-8"))["path"])
    path = config.relative_to(here) if config.is_relative_to(here) else config
    write_json(note, {"path": str(path)})
    with suppress(OSError):
        if former.read_bytes() != config.read_bytes() and sizes_of_results(run):
            return (
                f"{run}/ contains the results of {former}, and this run of {path} replaces them. To keep both, write another "
                "`run` into one of these configs."
            )
    return ""


def in_words(path: str, run: Path) -> str:
    """Return a result as a sentence names it: residues.csv of tdp43/c1."""
    place = Path(path).relative_to(run)
    return place.name if place.parent == Path() else f"{place.name} of {place.parent.as_posix()}"


def other_versions(run: Path, records: Iterable[Record]) -> list[str]:
    """Return a line for each other version of a library with which jobs have computed."""
    now, counts = versions(), Counter[tuple[str, str]]()
    for record in records:
        counts.update(
            (name, version) for name, version in record.versions.items() if now.get(name, version) != version
        )
    return [
        f"{pluralise(n, 'job')} of {run}/ computed with {name} {version}, and {now[name]} is installed now: their "
        f"results are kept. To compute them again, delete {run}/."
        for (name, version), n in sorted(counts.items())
    ]


def libraries_of(run: Path, results: Iterable[str]) -> list[str]:
    """Return the libraries with which the jobs of some results have computed, each with its versions: numpy 2.4.6."""
    wanted, found = {*map(str, results)}, dict[str, set[str]]()
    for record in read_records(run).values():
        if not wanted.isdisjoint(record.outputs):
            for name, version in record.versions.items():
                found.setdefault(name, set()).add(version)
    return [f"{name} {' and '.join(sorted(found[name]))}" for name in LIBRARIES if name in found]


@contextmanager
def handed_to_rules(found: Disagreements) -> Iterator[None]:
    """Hand disagreements to the Snakemake processes that are started meanwhile, see `changed_results`."""
    with tempfile.NamedTemporaryFile("w", suffix=".json", encoding="utf-8") as file:
        json.dump(found.results, file)
        file.flush()
        os.environ[TO_MAKE_AGAIN] = file.name
        try:
            yield
        finally:
            del os.environ[TO_MAKE_AGAIN]


def changed_results(run: Path) -> dict[str, str]:
    """Return the results of a run that disagree with their records, with a sentence; plain Snakemake compares them itself."""
    if path := os.environ.get(TO_MAKE_AGAIN):
        return json.loads(Path(path).read_text(encoding="utf-8"))
    return disagreements(run).results


def broken_links(run: Path, codes: Set[str]) -> Iterator[str]:
    """Replay the records of a run from its inputs to its page; yield a sentence for each link that differs.

    `codes` are the versions of the code of all scripts as they are now.
    """
    records = read_records(run)
    owners = {output: path for path, record in records.items() for output in record.outputs}
    needed = {}
    for path, record in records.items():
        makers = {owners.get(name, path) for name in record.inputs}
        needed[path] = makers - {path}
    for path in TopologicalSorter(needed).static_order():
        record = records[path]
        outputs = [output for output in record.outputs if owners[output] == path and os.path.exists(output)]
        if not outputs or record.origin == "partial":
            continue
        result = in_words(outputs[0], run)
        for name, digest in record.inputs.items():
            now = (
                records[owners[name]].outputs[name]
                if name in owners
                else Checksums().of_all([name]).get(name)
            )
            if now is None:
                yield f"{name} is missing, from which {record.rule} made {result}."
            elif now != digest:
                yield f"{name} is not the file from which {record.rule} made {result}."
        if record.code and record.code not in codes:
            yield f"{record.rule} had other code when it made {result}."
        for output in outputs:
            if Checksums().of(output) != record.outputs[output]:
                yield f"{in_words(output, run)} was changed after {record.rule} had made it."


def replace_records(run: Path, outputs: Sequence[str]) -> None:
    """Record results that were written without a job, where others failed: the next run makes them again."""
    for path, record in read_records(run).items():
        if not record.outputs.keys().isdisjoint(outputs):
            path.unlink(missing_ok=True)
    digests = Checksums().of_all(outputs)
    Record("close_run", digests, origin="partial").write(run / FOLDER / "partial.json")
