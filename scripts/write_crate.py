"""Describe the files of a run for archives (RO-Crate 1.1, w3id.org/ro/crate/1.1)."""

import json
import mimetypes
from datetime import date
from pathlib import Path
from urllib.parse import quote

from sparsurf import __version__
from sparsurf.report.first_page import DOWNLOADS
from sparsurf.workflow.jobs import job

CRATE, PROFILE = "ro-crate-metadata.json", "https://w3id.org/ro/crate/1.1"


def main(results: list[str], crate: str) -> None:
    """Write the crate of the files and folders of a run."""
    folder = Path(crate).parent
    paths = [path for result in map(Path, results) for path in sorted(result.rglob("*")) or [result]]
    files = [
        path for path in paths if path.is_file() and not path.name.startswith(".")
    ]  # none of Snakemake's
    text = json.dumps(describe_files(folder, files), indent=1)
    Path(crate).write_text(text + "\n", encoding="utf-8")


def describe_files(folder: Path, paths: list[Path]) -> dict:
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
        "datePublished": date.today().isoformat(),
        "hasPart": [{"@id": quote(file)} for file in files],
        "mentions": {"@id": "#run"},
    }
    parts = [_describe_file(folder, file) for file in files]
    return {"@context": f"{PROFILE}/context", "@graph": [metadata, root, action, program, *parts]}


def _describe_file(folder: Path, file: str) -> dict:
    """Describe one file, with words where the first page has some for it."""
    media_type = mimetypes.guess_type(file)[0] or "application/octet-stream"
    size, description = str((folder / file).stat().st_size), DOWNLOADS.get(Path(file).name)
    part = {"@id": quote(file), "@type": "File", "contentSize": size, "encodingFormat": media_type}
    return part | ({"description": description} if description else {})


if __name__ == "__main__":
    with job(snakemake):
        main(results=[*snakemake.input.results, *snakemake.input.pages], crate=snakemake.output.crate)
