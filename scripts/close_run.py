"""Close a run: its warnings, its failures, its first page, and a description of all files for archives.

The description is an RO-Crate 1.1, w3id.org/ro/crate/1.1.
"""

import csv
import json
import mimetypes
from datetime import date
from pathlib import Path
from urllib.parse import quote

import pandas as pd

from sparsurf import __version__
from sparsurf.files import checksum
from sparsurf.report.front import DOWNLOADS, write_front
from sparsurf.rounding import write_table
from sparsurf.workflow.job_logs import collected_warnings
from sparsurf.workflow.jobs import job

COLUMNS = ("protein", "conformation", "job", "sentence")
CRATE, PROFILE = "ro-crate-metadata.json", "https://w3id.org/ro/crate/1.1"
CONTEXT = [f"{PROFILE}/context", {"sha256": "https://schema.org/sha256"}]


def main(
    results: list[str],
    page: str,
    failures: str,
    warnings: str,
    crate: str,
    exclude: dict[str, str],
    logs: str,
    jobs: list[str],
) -> None:
    """Write index.html, failures.csv, warnings.csv and the crate.

    Parameters
    ----------
    results : files and folders of the run, which the page leads to
    exclude : reason for each excluded part of the study
    logs : folder of the logs
    jobs : names of the rules of the study
    """
    folder = Path(page).parent
    write_warnings(results, warnings, logs, jobs)
    files = [Path(path).relative_to(folder).as_posix() for path in results]
    answers = write_front(page, files, exclude)
    write_table(failures, pd.DataFrame(exclude.items(), columns=["place", "reason"]))
    write_crate([*results, page, failures, warnings], crate, answers)


def write_warnings(results: list[str], table: str, logs: str, jobs: list[str]) -> None:
    """Write what the jobs of a run warned about."""
    with open(table, "w", newline="", encoding="utf-8") as stream:
        csv.writer(stream, lineterminator="\n").writerows([COLUMNS, *collected_warnings(results, logs, jobs)])


def write_crate(results: list[str], crate: str, answers: list[str]) -> None:
    """Write the crate of the files and folders of a run."""
    folder = Path(crate).parent
    paths = [path for result in map(Path, results) for path in sorted(result.rglob("*")) or [result]]
    files = [
        path for path in paths if path.is_file() and not path.name.startswith(".")
    ]  # none of Snakemake's
    text = json.dumps(describe_files(folder, files, answers), indent=1)
    Path(crate).write_text(text + "\n", encoding="utf-8")


def describe_files(folder: Path, paths: list[Path], answers: list[str]) -> dict:
    """Return the files of a run as RO-Crate 1.1; licence and authors are for whoever publishes it."""
    files = [path.relative_to(folder).as_posix() for path in paths]
    metadata = {"@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"}, "conformsTo": {"@id": PROFILE}}
    program = {"@id": "#sparsurf", "@type": "SoftwareApplication", "name": "sparsurf", "version": __version__}
    action = {
        "@id": "#run",
        "@type": "CreateAction",
        "instrument": {"@id": "#sparsurf"},
        "result": {"@id": "./"},
    }
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Minimal molecular surfaces: {folder.name}",
        "description": "Results of a sparsurf study; index.html shows them.",
        "abstract": answers,
        "datePublished": date.today().isoformat(),
        "hasPart": [{"@id": quote(file)} for file in files],
        "mentions": {"@id": "#run"},
    }
    parts = [_describe_file(folder, file) for file in files]
    return {"@context": CONTEXT, "@graph": [metadata, root, action, program, *parts]}


def _describe_file(folder: Path, file: str) -> dict:
    """Describe one file, with words where the first page has some for it."""
    media_type = mimetypes.guess_type(file)[0] or "application/octet-stream"
    size, description = str((folder / file).stat().st_size), DOWNLOADS.get(Path(file).name)
    part = {"@id": quote(file), "@type": "File", "contentSize": size, "encodingFormat": media_type}
    part["sha256"] = checksum(folder / file)
    return part | ({"description": description} if description else {})


if __name__ == "__main__":
    with job(snakemake):
        main(
            results=snakemake.input.results,
            page=snakemake.output.page,
            failures=snakemake.output.failures,
            warnings=snakemake.output.warnings,
            crate=snakemake.output.crate,
            exclude=snakemake.params.exclude,
            logs=snakemake.params.logs,
            jobs=snakemake.params.jobs,
        )
