"""Write the first page of a run, the table of failures, and the description of its files for archives (RO-Crate 1.1)."""

import json
import mimetypes
from datetime import date
from pathlib import Path
from urllib.parse import quote

import pandas as pd

from sparsurf import __version__
from sparsurf.report.first_page import FRESH, TAKEN, TEMPLATE, first_page
from sparsurf.report.page import write
from sparsurf.workflow.jobs import job

CRATE, PROFILE = "ro-crate-metadata.json", "https://w3id.org/ro/crate/1.1"


def main(
    results: list[str],
    page: str,
    failures: str,
    crate: str,
    exclude: dict[str, str],
    floor: str | None = FRESH,
) -> None:
    """Write index.html, failures.csv and the crate.

    Parameters
    ----------
    results : files and folders of the run, which the page leads to
    exclude : reasons by place, of what the run has without results
    floor : the noise floor that the minimal subset goes by; None where the config asks for something else
    """
    folder = Path(page).parent
    files = [Path(path).relative_to(folder).as_posix() for path in results]
    write(page, TEMPLATE, **first_page(folder, files, [], list(exclude.items()), floor))
    pd.DataFrame(exclude.items(), columns=["place", "reason"]).to_csv(failures, index=False)
    paths = [path for file in files for path in sorted((folder / file).rglob("*")) or [folder / file]]
    inside = [Path(page), Path(failures), *(path for path in paths if path.is_file())]
    text = json.dumps(describe_files(folder, inside), indent=1)
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
    size, description = str((folder / file).stat().st_size), TAKEN.get(Path(file).name)
    part = {"@id": quote(file), "@type": "File", "contentSize": size, "encodingFormat": media_type}
    return part | ({"description": description} if description else {})


if __name__ == "__main__":
    with job(snakemake):
        main(
            results=snakemake.input.results,
            page=snakemake.output.page,
            failures=snakemake.output.failures,
            crate=snakemake.output.crate,
            exclude=snakemake.params.exclude,
            floor=snakemake.params.floor,
        )
