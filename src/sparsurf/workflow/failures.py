"""What a run that failed goes on without: proteins, conformations and pairs, each with the reason."""

from pathlib import Path

import yaml

from sparsurf.workflow.job_logs import failure, place
from sparsurf.workflow.jobs import conformations_of
from sparsurf.workflow.outputs import ALL_FRAMES

# Jobs of a protein that lead to its frames: without one of them there is none of it
BEFORE_FRAMES = ("choose_frames", "fetch_", "prepare_system", "simulate_", "judge_simulation")


def left_out(config, results, logs_of_failed):
    """The config's `without` for a second try, with the failed places and the pairs that need them.

    Parameters
    ----------
    config : dict, as `config.check` gives it
    results : path of the run's folder
    logs_of_failed : paths of logs
    """
    without = dict(config["without"])
    for path in logs_of_failed:
        protein, conformation, job = place(path, results / "logs")
        known = not job.startswith(BEFORE_FRAMES)
        names = (protein, conformation or (ALL_FRAMES if known and protein in config["proteins"] else ""))
        without["/".join(filter(None, names)) or job] = f"{job}: {failure(path)}"
    for name, pair in config["pairs"].items():
        for partner in pair.get("proteins", ()):
            if partner in without or f"{partner}/{first(results / partner)}" in without:
                without.setdefault(f"pairs/{name}", f"{partner} could not be finished.")
    return without


def first(folder):
    """The first conformation of a protein."""
    frames = folder / "frames.csv"
    return [*(conformations_of(frames) if frames.is_file() else ["c1"]), ""][0]


def something_is_left(config, results, without):
    """Whether any conformation or pair of a config is not left out."""
    for name, protein in config["proteins"].items():
        frames = results / name / "frames.csv"
        chosen = ["c1"] if "surface" in protein else conformations_of(frames) if frames.is_file() else []
        if name not in without and any(f"{name}/{each}" not in without for each in chosen):
            return True
    return any(f"pairs/{name}" not in without for name in config["pairs"])


def write(without, path):
    """A config file that leaves these out."""
    Path(path).write_text(yaml.safe_dump({"without": without}, allow_unicode=True), encoding="utf-8")
    return path
