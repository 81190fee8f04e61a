"""Downloads and simulations that are kept although nothing records how they were made: they took days, or a network.

Two cases need this: results of version 3.0.0 and earlier, which have no records, and results whose metadata in .snakemake/ are
lost, as where a folder of results was copied into another checkout. Without it, both are fetched and simulated again.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from sparsurf.files import pluralise
from sparsurf_study.simulation.protocol import STAGES
from sparsurf_study.workflow.checksums import Checksums
from sparsurf_study.workflow.config import proteins
from sparsurf_study.workflow.ledger import FOLDER, Record, metadata_of, read_records


class Kept(NamedTuple):
    """Outputs of a job that is not run again for want of a record, and the parameters that it must have had."""

    log: str  # below logs/, without its ending
    rule: str
    outputs: list[str]
    config: dict[str, Any]


def adopt(config: dict, run: Path, metadata: Path) -> list[Kept]:
    """Record the downloads and simulations of a run that lack a record, or whose metadata Snakemake has lost; return these.

    Those that were made with other parameters, as far as anything tells, are not kept.
    """
    records, adopted = read_records(run), []
    for kept in _jobs(config, run):
        path = run / FOLDER / f"{kept.log}.json"
        record, metadata_of_job = records.get(path), metadata_of(metadata, kept.outputs[0])
        if record is not None and metadata_of_job is not None:
            continue
        if all(Path(output).exists() for output in kept.outputs) and _is_of(kept, record, metadata_of_job):
            digests = record.outputs if record else Checksums().of_all(kept.outputs)
            Record(kept.rule, digests, config=kept.config, origin="adopted").write(path)
            adopted.append(kept)
    return adopted


def forget(adopted: list[Kept], run: Path) -> None:
    """Remove the records of jobs that could not be kept."""
    for kept in adopted:
        (run / FOLDER / f"{kept.log}.json").unlink(missing_ok=True)


def adopted_in_words(adopted: list[Kept], run: Path) -> str:
    """Return the sentence that says what is kept."""
    downloads = sum(kept.rule == "fetch_structure" for kept in adopted)
    counts = [(downloads, "download"), (len(adopted) - downloads, "stage")]
    counted = " and ".join(pluralise(n, noun) for n, noun in counts if n)
    kind = " of simulations" if downloads < len(adopted) else ""
    return f"Kept as they are in {run}/, without a complete record: {counted}{kind}."


def _jobs(config: dict, run: Path) -> Iterator[Kept]:
    """Yield the downloads and simulations of a checked config."""
    for name, protein in proteins(config).items():
        if protein.source:
            file = f"{run}/{name}/download/{protein.download}"
            request: dict[str, Any] = {"url": protein.source, "sha256": protein.sha256}
            yield Kept(f"{name}/fetch_{protein.download}", "fetch_structure", [file, f"{file}.json"], request)
        if protein.simulate is not None:
            folder, request = (
                f"{run}/{name}/simulation",
                {"simulate": protein.simulate, "seed": config["seed"]},
            )
            yield Kept(
                f"{name}/prepare_system",
                "prepare_system",
                [f"{folder}/system", f"{folder}/system.json"],
                request,
            )
            for stage in STAGES:
                yield Kept(f"{name}/simulate_{stage}", "simulate_stage", [f"{folder}/{stage}"], request)


def _is_of(kept: Kept, record: Record | None, metadata: dict | None) -> bool:
    """Return whether nothing tells that a job had other parameters, or that a download is another file."""
    if record is not None and any(record.config.get(key) != value for key, value in kept.config.items()):
        return False
    if record is None and metadata is not None:
        recorded = metadata.get("params") or ()
        if any(repr(value) not in recorded for value in kept.config.values()):
            return False
    if kept.rule == "fetch_structure":
        file, path_to_origin = kept.outputs
        try:
            origin = json.loads(Path(path_to_origin).read_text(encoding="utf-8"))
            return origin["url"] == kept.config["url"] and origin["sha256"] == Checksums().of(file)
        except (OSError, ValueError, LookupError, TypeError):
            return False
    return True
