"""The first page of a run, alone and as the first page of the report, and what the run holds for archives (RO-Crate 1.1)."""

import json
import mimetypes
from datetime import date
from pathlib import Path
from urllib.parse import quote

import pandas as pd

from sparsurf import __version__
from sparsurf.report.first_page import FRESH, TAKEN, TEMPLATE, first_page
from sparsurf.report.page import embedded, linked_in_report, render, write
from sparsurf.workflow.jobs import run

CRATE, PROFILE = "ro-crate-metadata.json", "https://w3id.org/ro/crate/1.1"


def main(inputs, outputs, folder, without, floor=FRESH):
    """Write index.html, the part of the report, failures.csv and the crate; see `first_page` for `without` and `floor`.

    They link to `pages`, which the report holds, and to what is `beside` it.
    """
    held, beside = (
        [str(Path(path).relative_to(folder)) for path in _listed(inputs.get(key, []))]
        for key in ("pages", "beside")
    )
    known = first_page(folder, held, beside, list(without.items()), floor)
    write(outputs["html"], TEMPLATE, **known)
    table = pd.DataFrame(without.items(), columns=["place", "reason"])
    table.to_csv(outputs["failures"], index=False)
    if "crate" in outputs:
        listed = [Path(folder, path) for path in ("index.html", "failures.csv", *held, *beside)]
        inside = [sorted(path.rglob("*")) if path.is_dir() else [path] for path in listed]
        files = [str(path.relative_to(folder)) for paths in inside for path in paths if path.is_file()]
        text = json.dumps(crate(Path(folder), files), indent=1)
        Path(outputs["crate"]).write_text(text + "\n", encoding="utf-8")
    if "part" in outputs:
        figure = known["main_figure"]
        known["main_figure"] = figure and figure | {"src": embedded(Path(folder, figure["path"]))}
        page = linked_in_report(render(TEMPLATE, **known, in_report=True), folder, held)
        Path(outputs["part"]).write_text(page, encoding="utf-8")


def crate(folder, files):
    """The files of a run as RO-Crate 1.1 (w3id.org/ro/crate/1.1); licence and authors are for whoever publishes it."""
    made_by = {"@id": "#sparsurf", "@type": "SoftwareApplication", "name": "sparsurf", "version": __version__}
    about = {"@id": CRATE, "@type": "CreativeWork", "about": {"@id": "./"}, "conformsTo": {"@id": PROFILE}}
    run_of = {
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
        "hasPart": [{"@id": quote(path)} for path in files],
        "mentions": {"@id": "#run"},
    }
    parts = [_part(folder, path) for path in files]
    return {"@context": f"{PROFILE}/context", "@graph": [about, root, run_of, made_by, *parts]}


def _part(folder, path):
    """One file of the crate, described where the first page has words for it."""
    kind = mimetypes.guess_type(path)[0] or "application/octet-stream"
    size, words = str((folder / path).stat().st_size), TAKEN.get(Path(path).name)
    part = {"@id": quote(path), "@type": "File", "contentSize": size, "encodingFormat": kind}
    return part | ({"description": words} if words else {})


def _listed(paths):
    return [paths] if isinstance(paths, str) else paths


if __name__ == "__main__":
    run(main, snakemake)
