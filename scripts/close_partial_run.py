"""Close a run in which jobs failed: what goes over all proteins and pairs, from those that are finished."""

import os
from collections.abc import Iterator
from pathlib import Path

import close_run
import summarise_batches
import summarise_best
import summarise_comparison
import summarise_pairs
import summarise_surfaces
from sparsurf.batches.assignment import TABLES, batched_structures, batches_of
from sparsurf.workflow.config import CONFORMATION, needed_conformations, sampled_proteins
from sparsurf.workflow.conformations import first_column, without_zeros
from sparsurf.workflow.job_logs import failure, place_of_log
from sparsurf.workflow.names import FIGURES

# Jobs that lead to the conformations of a protein: without one of them there are none
BEFORE_CONFORMATIONS = (
    "choose_frames",
    "fetch_",
    "prepare_system",
    "simulate_",
    "judge_",
)
ALL_RULES = [""]  # with which every name of a log begins
OF_PAPER = ("verdict.html", "table1.*", "paper_*.csv")
LAST_FILE = "view.html"  # of a conformation


def main(config: dict, run: Path, failures: dict[str, str]) -> bool:
    """Write the summaries and the first page of what is finished; return whether anything is.

    They count as older than what they show, so that the next run writes them again.

    Parameters
    ----------
    config : dict, checked
    run : folder of the results
    failures : see `failed_places`
    """
    folders = finished_conformations(config, run, failures)
    pairs = [run / "pairs" / name for name in config["pairs"] if f"pairs/{name}" not in failures]
    pairs = [pair for pair in pairs if (pair / "agreement.csv").is_file()]
    tables = [f"{run}/{name}/{batch}.parquet" for batch in batches_of(config) for name in TABLES]
    if not (folders or pairs or tables):
        return False
    summaries = write_summaries(config, run, folders, pairs)
    finished = [*finished_results(config, run, failures, folders), *pairs, *summaries]
    results = [str(path) for result in finished for path in in_order_of_page(result)]
    names = {"page": "index.html", "failures": "failures.csv", "warnings": "warnings.csv"}
    pages = {key: str(run / name) for key, name in (names | {"crate": close_run.CRATE}).items()}
    common = {"exclude": failures, "logs": str(run / "logs")}
    if tables:
        png = f"{run}/distributions.png"
        summarise_batches.main(tables, results, **pages, png=png, **common, jobs=ALL_RULES)
    else:
        close_run.main(results, **pages, **common, jobs=ALL_RULES)
    oldest = min(Path(path).stat().st_mtime for path in (*results, *tables)) - 1
    for path in [*map(str, summaries), *pages.values()]:
        os.utime(path, (oldest, oldest))
    return True


def write_summaries(config: dict, run: Path, folders: list[Path], pairs: list[Path]) -> list[Path]:
    """Write the tables, figures and pages over all surfaces and pairs; return their paths."""
    sampled = sampled_proteins(config)
    of_grid = [folder for folder in folders if folder.parent.name in sampled]
    written: list[Path] = []

    def paths(*names: str) -> list[str]:
        written.extend(run / name for name in names)
        return [str(run / name) for name in names]

    if folders:
        outputs = paths("surfaces.csv", "required_dots.png")
        surfaces = [f"{folder}/surface.npz" for folder in folders]
        summarise_surfaces.main(surfaces, *outputs, config["patches"], config["minimal"], sampled)
    if of_grid:
        best = paths("summary.csv", "relation.csv")
        summarise_best.main([f"{folder}/surface.npz" for folder in of_grid], *best, config["seed"])
    if of_grid and config["compare"]["run"]:
        outputs = paths("compare.csv", "compare.png")
        summarise_comparison.main([f"{folder}/compare.csv" for folder in of_grid], *outputs)
    if pairs:
        outputs = paths("pairs/pairs.csv", "pairs/pairs.png")
        summarise_pairs.main([f"{pair}/agreement.csv" for pair in pairs], *outputs, run.name)
    return written


def finished_results(
    config: dict, run: Path, failures: dict[str, str], folders: list[Path]
) -> Iterator[Path]:
    """Yield the files and folders of the proteins and changes that are finished, and the comparison with the paper."""
    for protein in proteins_with_folders(config):
        if not {protein, f"{protein}/*"} & failures.keys():
            paths = sorted(run.glob(f"{protein}/[!.]*"))
            yield from (path for path in paths if not CONFORMATION.fullmatch(path.name))
        yield from (folder for folder in folders if folder.parent.name == protein)
    yield from (run / "changes" / name for name in config["changes"] if f"changes/{name}" not in failures)
    if run / config.get("paper", "") / "c1" in folders:
        yield from (path for name in OF_PAPER for path in sorted(run.glob(name)))


def in_order_of_page(result: Path) -> list[Path]:
    """Return a file, or the files of a folder."""
    files = [result] if result.is_file() else [path for path in result.rglob("[!.]*") if path.is_file()]
    return sorted(files, key=lambda path: ((*FIGURES, path.stem).index(path.stem), path))


def failed_places(config: dict, run: Path, failed: list[str]) -> dict[str, str]:
    """Return what the config excludes, the places of failed jobs, and the pairs and changes that need them, with their reasons.

    Parameters
    ----------
    config : dict, checked
    run : folder of the results
    failed : logs of the jobs that failed
    """
    places = dict(config["exclude"])
    whole = (
        "/*" if batched_structures(config) else ""
    )  # the page of a structure failed, and its batch keeps it
    for log in failed:
        protein, conformation, job = place_of_log(log, run / "logs")
        over_frames = protein in config["proteins"] and not job.startswith(BEFORE_CONFORMATIONS)
        place = "/".join(filter(None, (protein, conformation or ("*" if over_frames else ""))))
        place += whole if place and place == protein else ""
        if place:  # a job over all proteins has no place
            places[place] = f"{job}: {failure(log)}"
    for place, needed in needed_conformations(config).items():
        for name in needed:
            protein, _, conformation = name.partition("/")
            first = next(iter(chosen_conformations(config, run, protein)), "c1")
            if is_in(places, protein, conformation or first):
                places.setdefault(place, f"{name} could not be finished.")
    return places


def finished_conformations(config: dict, run: Path, failures: dict[str, str]) -> list[Path]:
    """Return the folders of the conformations that are finished."""
    folders = [
        run / protein / conformation
        for protein in proteins_with_folders(config)
        for conformation in chosen_conformations(config, run, protein)
        if not is_in(failures, protein, conformation)
    ]
    return [folder for folder in folders if (folder / LAST_FILE).is_file()]


def proteins_with_folders(config: dict) -> list[str]:
    """Return the names of the proteins whose files lie in folders of their own."""
    return config.get("pages", []) if batched_structures(config) else [*config["proteins"]]


def chosen_conformations(config: dict, run: Path, protein: str) -> list[str]:
    """Return the conformations of a protein, none where its frames are not chosen yet."""
    if "surface" in config["proteins"][protein]:
        return ["c1"]
    frames = run / protein / "frames.csv"
    return first_column(frames) if frames.is_file() else []


def is_in(places: dict[str, str], protein: str, conformation: str) -> bool:
    """Return whether a conformation, by any way to write its name, or its protein is among some places."""
    return not {protein, without_zeros(f"{protein}/{conformation}")}.isdisjoint(map(without_zeros, places))
