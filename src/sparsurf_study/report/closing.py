"""Close a run: its warnings, its failures, its first page, and a description of all files for archives."""

from __future__ import annotations

import json
import mimetypes
from collections.abc import Callable, Iterator, Mapping, Sequence
from datetime import date
from pathlib import Path
from typing import Any
from urllib.parse import quote

import pandas as pd

from sparsurf.files import checksum_of_file
from sparsurf.version import __version__
from sparsurf_study import catalogue, manifest
from sparsurf_study.batches.assignment import BATCH_FOLDERS
from sparsurf_study.batches.summary import grouped_reasons, measures, most_unusual
from sparsurf_study.batches.tables import read_parquet
from sparsurf_study.report.first_page.surfaces import DEFAULT_MINIMAL
from sparsurf_study.report.front import MAX_ROWS, write_front
from sparsurf_study.report.invariants import broken_batches, broken_invariants, numbers_missing_on_page
from sparsurf_study.report.page import DEFAULT_LENGTHS
from sparsurf_study.report.provenance import UNKNOWN_ORIGIN, RunOrigin
from sparsurf_study.rounding import write_rounded

Warnings = list[tuple[str, str, str, str]]
WARNING_COLUMNS = ["protein", "conformation", "job", "sentence"]  # The columns of warnings.csv.
CRATE, PROFILE = "ro-crate-metadata.json", "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{PROFILE}/context", {"sha256": "https://schema.org/sha256"}]
LICENCE_OF_PROGRAM = "https://spdx.org/licenses/MIT"
# RO-Crate 1.1 requires a license, which may be a text; that of the results is not the program's to choose
NO_LICENCE = "No licence has been chosen yet: whoever publishes these results states theirs here."
FAILURE_COLUMNS = ["place", "reason"]  # The columns of failures.csv.
CHECK_COLUMNS = ["file", "sentence"]  # The columns of checks.csv.
JOB = "analyse_batch"


def close_run(
    folder: Path,
    results: Sequence[str],
    warnings: Warnings,
    exclude: Mapping[str, str],
    outputs: Mapping[str, str],
    lengths: Mapping[str, float] = DEFAULT_LENGTHS,
    origin: RunOrigin = UNKNOWN_ORIGIN,
    minimal: Mapping[str, Any] = DEFAULT_MINIMAL,
) -> None:
    """Check the run of a folder with the files and folders `results`, and write its pages and tables.

    `exclude` has reasons by place.
    """
    files = [Path(path).relative_to(folder).as_posix() for path in results]

    def write_page() -> tuple[list[str], list[tuple[str, str]]]:
        broken, page = broken_invariants(folder, files), outputs["page"]
        answers = write_front(page, files, dict(exclude), None, lengths, broken, origin, minimal, folder)
        # whether the page has its numbers is known once it is written, and it also lists what is wrong: it is written again
        if missing := numbers_missing_on_page(folder, files, page):
            broken += missing
            write_front(page, files, dict(exclude), None, lengths, broken, origin, minimal, folder)
        return answers, broken

    failures = pd.DataFrame(exclude.items(), columns=FAILURE_COLUMNS)
    _write_pages(
        folder, results, outputs, failures, pd.DataFrame(warnings, columns=WARNING_COLUMNS), write_page
    )


def close_batches(
    run: Path,
    tables: Sequence[str],
    studied: Sequence[str],
    warnings: Warnings,
    exclude: Mapping[str, str],
    outputs: Mapping[str, str],
    lengths: Mapping[str, float] = DEFAULT_LENGTHS,
    origin: RunOrigin = UNKNOWN_ORIGIN,
    minimal: Mapping[str, Any] = DEFAULT_MINIMAL,
) -> None:
    """Check the run of a folder in batches, and write its outputs page, failures, warnings, checks, crate and png.

    `tables` are the Parquet files of all batches; others in their folders are left from an earlier study and are removed.
    `studied` are the files of the structures that have pages of their own.
    """
    from sparsurf.views import layout  # here: matplotlib takes a third of a second to load
    from sparsurf_study.report.figures import distributions

    stored = {path for name in BATCH_FOLDERS for path in (run / name).glob("*.parquet")}
    # Readers open all tables of a folder together, so one that is left over would add proteins to the run
    for path in stored - {*map(Path, tables)}:
        path.unlink()
    surfaces = read_parquet(run, "surfaces").sort_values("protein", ignore_index=True)
    failed = read_parquet(run, "failures").sort_values("protein", ignore_index=True)
    excluded = pd.DataFrame(exclude.items(), columns=["protein", "reason"])
    failures = pd.concat([excluded, failed]).set_axis(FAILURE_COLUMNS, axis=1)
    listed = read_parquet(run, "warnings").sort_values("protein", kind="stable")
    listed = listed.assign(conformation="", job=JOB)[WARNING_COLUMNS]
    listed = pd.concat([listed, pd.DataFrame(warnings, columns=WARNING_COLUMNS)])
    listed = listed.drop_duplicates(["protein", "sentence"])
    layout.save(distributions.figure(measures(surfaces)), outputs["png"])
    batches = {
        "surfaces": surfaces,
        "unusual": most_unusual(surfaces, MAX_ROWS),
        "failures": grouped_reasons(failed),
        "n_batches": len({Path(path).name for path in tables}),
    }
    files = [Path(path).relative_to(run).as_posix() for path in studied]

    def write_page() -> tuple[list[str], list[tuple[str, str]]]:
        broken = [*broken_batches(run), *broken_invariants(run, files)]
        page, shown = outputs["page"], [Path(outputs["png"]).name, *files]
        return write_front(page, shown, dict(exclude), batches, lengths, broken, origin, minimal, run), broken

    _write_pages(run, [*tables, outputs["png"], *studied], outputs, failures, listed, write_page)


def _write_pages(
    folder: Path,
    results: Sequence[str],
    outputs: Mapping[str, str],
    failures: pd.DataFrame,
    warnings: pd.DataFrame,
    write_page: Callable[[], tuple[list[str], list[tuple[str, str]]]],
) -> None:
    """Write failures, warnings, the first page, checks, the crate and the checksums of the run of a folder.

    `write_page` writes the page, which quotes the warnings, and returns its answers and what contradicts itself in the results.
    """
    write_rounded(outputs["failures"], failures)
    write_rounded(outputs["warnings"], warnings)
    answers, broken = write_page()
    write_rounded(outputs["checks"], pd.DataFrame(broken, columns=CHECK_COLUMNS))
    pages = [outputs[name] for name in ("page", "failures", "warnings", "checks")]
    write_crate([*results, *pages], outputs["crate"], answers, folder)
    run = Path(outputs["sums"]).parent
    files = {*files_of([*results, *pages, outputs["crate"]]), *intermediate_files(run)}
    manifest.write_sums(run, manifest.sums_of(run, files))


def intermediate_files(run: Path) -> Iterator[Path]:
    """Yield the files of a run that only its jobs read, downloads among them, but not simulations, which may have many GB."""
    for path in run.rglob("[!.]*"):
        output = catalogue.output_of(path.relative_to(run).as_posix())
        if output and output.intermediate and path.is_file() and "simulation" not in path.parts:
            yield path


def write_crate(
    results: Sequence[str], crate: str, answers: Sequence[str], folder: Path | None = None
) -> None:
    """Write the crate of the files and folders of a run: a description for archives, RO-Crate 1.1.

    `folder` is that of the run, by default that of the crate; what lies beside the crate is described as if it lay there.
    """
    folder_of_crate = Path(crate).parent
    folder = folder or folder_of_crate
    files = {}
    for path in files_of(results):
        home = folder_of_crate if path.is_relative_to(folder_of_crate) else folder
        files[path.relative_to(home).as_posix()] = path
    text = json.dumps(describe_files(folder.name, files, answers), indent=1)
    Path(crate).write_text(text + "\n", encoding="utf-8")


def files_of(results: Sequence[str]) -> list[Path]:
    """Return the files among results, and those of the folders among them."""
    paths: list[Path] = []
    for result in map(Path, results):
        paths += sorted(result.rglob("*")) or [result]
    return [path for path in paths if path.is_file() and not path.name.startswith(".")]  # not Snakemake's


def describe_files(run: str, files: Mapping[str, Path], answers: Sequence[str]) -> dict:
    """Return the files of a run, by path in its folder, as RO-Crate 1.1; authors and licence are for whoever publishes it."""
    metadata = {"@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"}, "conformsTo": {"@id": PROFILE}}
    program = {
        "@id": "#sparsurf",
        "@type": "SoftwareApplication",
        "name": "sparsurf",
        "version": __version__,
        "license": {"@id": LICENCE_OF_PROGRAM},
    }
    action = {
        "@id": "#run",
        "@type": "CreateAction",
        "instrument": {"@id": "#sparsurf"},
        "result": {"@id": "./"},
    }
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Minimal molecular surfaces: {run}",
        "description": "Results of a sparsurf study; index.html shows them.",
        "abstract": answers,
        "datePublished": date.today().isoformat(),
        "license": NO_LICENCE,
        "hasPart": [{"@id": quote(file)} for file in files],
        "mentions": {"@id": "#run"},
    }
    parts = [_describe_file(*file) for file in files.items()]
    return {"@context": CONTEXT, "@graph": [metadata, root, action, program, *parts]}


def _describe_file(file: str, path: Path) -> dict:
    """Describe one file, with the words that the catalogue has for it."""
    media_type = mimetypes.guess_type(file)[0] or "application/octet-stream"
    size, output = str(path.stat().st_size), catalogue.output_of(file)
    part = {"@id": quote(file), "@type": "File", "contentSize": size, "encodingFormat": media_type}
    part["sha256"] = checksum_of_file(path)
    return part | ({"description": output.content} if output else {})
