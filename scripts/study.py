"""Run a study and write its report: `python scripts/study.py [config.yaml] [--cluster slurm] [compare] [snakemake options]`.

One study at a time per checkout: the lock is the operating system's, so that a killed run leaves
nothing to unlock and the next one continues where it was; it lasts as long as Snakemake does.
"""

import fcntl
import math
import os
import re
import signal
import subprocess
import sys
import tempfile
import time
from contextlib import contextmanager
from pathlib import Path

from sparsurf import InputError
from sparsurf.workflow.config import check, completed
from sparsurf.workflow.jobs import COMPLETE, conformations_of
from sparsurf.workflow.needs import limit, memory_of_grid
from sparsurf.workflow.yaml_file import read_config

ROOT = Path(__file__).resolve().parents[1]
COMPARE = ROOT / "studies" / "compare.yaml"
PART = {"--until", "-U", "--omit-from", "-O"}  # Snakemake's options that leave something out
HELP = {"-h", "--help"}
OF_CONFIG = {"--config", "-C", "--configfile", "--configfiles"}
NOT_FINISHED = "not finished"
ODD = re.compile(r"""[\s()'"&;$`\\|<>*?{}]""")  # means something to a shell
LED_TO_RANGES = ("surface.npz", "roughness.csv", "grid.csv")
SUMS = ("surfaces.csv", "summary.csv", "relation.csv", "summary.md", "summary.png", "summary.svg")
FIRST_PAGE = ("index.html", "index.md", ".front_page.html")
TELL = 2**30  # bytes of memory from which on a grid's need is told


def main(path_to_config="config.yaml", *options):
    """Run Snakemake, then its report where anything is newer than it; returns the exit code."""
    if path_to_config in HELP:
        print(f"{__doc__.strip()}\n\nWithout a config, that is the default study, config.yaml, on all cores.")
        return 0
    path, begin, options = Path(path_to_config).resolve(), time.time(), list(options)
    here = not {"--cluster", "--executor"} & set(options)
    options[:0] = limit() if here else []
    dry = bool({"--dry-run", "-n", *HELP} & set(options))
    os.chdir(ROOT)
    try:
        if "--cluster" in options:
            at = options.index("--cluster")
            options[at : at + 2] = cluster("".join(options[at + 1 : at + 2]))
        if given := [option for option in options if option.partition("=")[0] in OF_CONFIG]:
            raise InputError(
                f"{given[0]}: a study has one config file; write into {path_to_config} what is to change."
            )
        if odd := ODD.search(sys.executable):
            raise InputError(
                f"{sys.executable}: Snakemake starts no job by a path with {odd[0]!r}; move the checkout, or call it otherwise."
            )
        config = checked_config(path, path_to_config, here)
        results, files = ROOT / "results" / config["run"], [path]
        if "compare" in options or (results / "compare.md").is_file():  # once compared, a run stays so
            files.append(COMPARE)
        options = [option for option in options if option != "compare"]
        with locked():
            if not dry:
                make_writable(results)
            code = snakemake(files, "--nolock", *options)
            if dry or (code == 0 and is_part(options, config, results, begin)):
                return code
            return finish(files, config, results, code, begin)
    except InputError as error:
        print(error, file=sys.stderr)
        return 2
    except KeyboardInterrupt as stop:
        print("\nStopped; what was made stays, and the same command continues where it was.", file=sys.stderr)
        return 128 + (stop.args[0] if stop.args else signal.SIGINT)


def checked_config(path, given, here=True):
    """The config in a file, checked before anything starts; says what memory a large grid will need."""
    if not path.is_file():
        raise InputError(f"There is no config file {given!r}; give one with CONFIG=my_config.yaml.")
    config = check(completed(read_config(path), ROOT), home=ROOT, here=here)
    needed = memory_of_grid(config)
    if needed > TELL:
        print(f"The grid of one surface will need about {needed / 2**30:.1f} GB of memory.")
    return config


@contextmanager
def locked():
    """Hold the lock of this checkout."""
    lock = ROOT / ".snakemake" / "study.lock"
    try:
        lock.parent.mkdir(exist_ok=True)
        held = lock.open("w", encoding="utf-8")
    except OSError as error:
        raise InputError(
            f"{lock.parent} cannot be written ({error.strerror}): a study needs its folder."
        ) from None
    with held:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError("Another study runs in this folder; wait for it to end.") from None
        os.set_inheritable(held.fileno(), True)  # what is called holds it, too, and may outlive this process
        yield


def make_writable(folder):
    """Create a folder, or say why nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()
    except OSError as error:
        raise InputError(
            f"{folder.relative_to(ROOT)}/ cannot be written ({error.strerror}): mend that first."
        ) from None


def is_part(options, config, results, begin):
    """Whether only a part of the study was asked for; says so."""
    part = any(option.partition("=")[0] in PART for option in options) or unfinished(config, results, begin)
    if part:
        where = results.relative_to(ROOT)
        print(f"\nWhat was asked for is in {where}/; the rest of the study was not made, nor its report.")
        proteins = config["proteins"].items()
        molecules = [name for name, protein in proteins if "surface" not in protein]
        if unknown := [name for name in molecules if not (results / name / "frames.csv").is_file()]:
            print(
                f"Of {', '.join(unknown)} the frames are not chosen yet (--until choose_frames): nothing that follows from "
                "them was made."
            )
    return bool(part)


def finish(files, config, results, code, begin):
    """Sum up what there is and write the report; returns the exit code."""
    report = results / "report.html"
    failed = unfinished(config, results, begin) if code else {}
    places = list(places_of(config["proteins"], results, failed))
    options = [word for each in failed.items() for word in ("--without", *each)]
    pairs = [name for name in config["pairs"] if f"pairs/{name}" not in failed]
    if failed and pairs:  # what there is, without what failed
        by_hand("summarise_pairs.py", results, *pairs, *([] if config["proteins"] else options))
    if failed and config["proteins"]:
        patches = config["patches"]
        wish = ["--R-patch", patches["R_patch"], "--D-link", patches["D_link"], "--seed", config["seed"]]
        finished = any((results / place / "minimal.csv").is_file() for place in places)
        summed = bool(places) and by_hand("summarise_run.py", results, *places, *wish) == 0
        shown = summed and finished and by_hand("write_front_page.py", results, *options) == 0
        for file in (*([] if summed else SUMS), *([] if shown else FIRST_PAGE)):  # of an earlier run
            (results / file).unlink(missing_ok=True)
    if code == 0 and is_older(report, results):  # Snakemake makes no report of an unfinished study
        code = snakemake(files, "--nolock", "--quiet", "all", "--report", str(report))
    print_results(results, code, begin, failed)
    return code


def by_hand(script, *arguments):
    """Run one of the study's scripts outside of Snakemake; returns its exit code."""
    return called(sys.executable, ROOT / "scripts" / script, *arguments)


def places_of(proteins, results, failed):
    """<protein>/<conformation> of the config's proteins, in their order, that have their best combinations: of those that
    `failed` only where nothing that led to these is missing or newer."""
    for name, protein in proteins.items():
        frames = results / name / "frames.csv"
        chosen = conformations_of(frames) if frames.is_file() else []
        for conformation in ["c1"] if "surface" in protein else chosen:
            folder = results / name / conformation
            if (folder / "ranges.csv").is_file() and not (name in failed and is_stale(folder)):
                yield f"{name}/{conformation}"


def is_stale(folder):
    """Whether the best combinations of a conformation are those of what lies beside them no more."""
    before = [folder / name for name in LED_TO_RANGES]
    made = (folder / "ranges.csv").stat().st_mtime
    return not all(path.is_file() and path.stat().st_mtime <= made for path in before)


def unfinished(config, results, begin):
    """Proteins and pairs (`pairs/<name>`) that have no end, or failed since `begin`, with what their logs say."""
    wanted = [*config["proteins"], *(f"pairs/{name}" for name in config["pairs"])]
    failed = {name: NOT_FINISHED for name in wanted if not (results / name / COMPLETE).is_file()}
    for job, said in errors(results, begin):
        for name in wanted:
            if Path(name) in job.parents:
                failed[name] = f"{job.relative_to(name)}: {said}"
    for name, pair in config["pairs"].items():
        mark = results / "pairs" / name / COMPLETE
        since = mark.stat().st_mtime if mark.is_file() else 0
        lacking = [
            partner
            for partner in pair.get("proteins", [])
            if partner in failed and surface_made(results / partner) > since
        ]
        if lacking and failed.get(f"pairs/{name}", NOT_FINISHED) == NOT_FINISHED:
            failed[f"pairs/{name}"] = f"{NOT_FINISHED}, as {' and '.join(lacking)} is not"
    return failed


def surface_made(folder):
    """When the surface of a protein's first conformation, which its pairs take, was made; inf where there is none."""
    frames = folder / "frames.csv"
    first = conformations_of(frames)[:1] if frames.is_file() else ["c1"]
    surface = folder.joinpath(*first, "surface.npz")
    return surface.stat().st_mtime if surface.is_file() else math.inf


def errors(results, begin):
    """What went wrong since `begin`: (path of the job's log without its ending, sentence)."""
    logs = results / "logs"
    for log in sorted(logs.rglob("*.log")):
        if log.stat().st_mtime >= begin:
            for line in log.read_text(encoding="utf-8").splitlines():
                if line.startswith("ERROR "):
                    yield log.relative_to(logs).with_suffix(""), line[6:]


def snakemake(files, *options):
    """Run Snakemake in the project's folder with some files of config, a later one before an earlier; returns its exit code."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--directory", ROOT]
    return called(*command, "--configfile", *files, *options)


def called(*command):
    """Run a command to its end; returns its exit code.

    Ctrl-C reaches the command by itself, SIGTERM is passed on; how long it takes to cancel or end its jobs is waited for.
    """
    asked = []

    def stop(number, _):
        asked.append(number)
        if number == signal.SIGTERM:
            process.terminate()

    process = subprocess.Popen([*map(str, command)], close_fds=False)  # with the lock
    before = {number: signal.signal(number, stop) for number in (signal.SIGINT, signal.SIGTERM)}
    code = process.wait()
    for number, handler in before.items():
        signal.signal(number, handler)
    if asked and code:
        raise KeyboardInterrupt(asked[0])
    return code


def cluster(name):
    """Snakemake's options for profiles/<name>, and what a Slurm without accounting needs besides."""
    profile = ROOT / "profiles" / name
    if not (profile / "config.yaml").is_file():
        raise InputError(
            f"--cluster needs the name of a folder in profiles/, as slurm, but has {name or 'none'}."
        )
    options = ["--workflow-profile", str(profile)]
    if name == "slurm" and not accounting():
        options += ["--slurm-status-command", "squeue", "--slurm-no-account"]
    return options


def accounting():
    """Whether Slurm keeps accounts that can be asked; where it says so and does not, Snakemake would wait for ever."""
    command = ["sacct", "--noheader", "--allocations", "--starttime", "now"]
    try:
        return subprocess.run(command, capture_output=True, timeout=30, check=False).returncode == 0
    except (OSError, subprocess.TimeoutExpired):
        return False


def is_older(report, results):
    """Whether a result is newer than the report."""
    if not report.is_file():
        return True
    logs = results / "logs"
    files = (
        path for path in results.rglob("*") if path.is_file() and logs not in path.parents and path != report
    )
    return any(path.stat().st_mtime > report.stat().st_mtime for path in files)


def print_results(results, code, begin, failed):
    """Say where to look, and what failed since `begin` with its sentence."""
    where = results.relative_to(ROOT)
    if code:
        said = [f"- {job}: {sentence}" for job, sentence in errors(results, begin)]
        if said:
            said += [f"- {name}: {why}" for name, why in failed.items() if why.startswith(NOT_FINISHED)]
        wrong = "What went wrong:" if said else "What went wrong stands above."
        print(
            f"\nNot everything could be made. What was made is in {where}/. {wrong}",
            *said,
            sep="\n",
            file=sys.stderr,
        )
        page = results / "index.html"
        if page.is_file() and page.stat().st_mtime >= begin:
            print(f"Of the rest, read first: {page.relative_to(ROOT)}", file=sys.stderr)
        return
    print(f"\nResults: {where}/ (what every file is: results/README.md)")
    print(f"Report:  {where}/report.html")
    for path in [results / "index.html", results / "verdict.md"]:
        if path.is_file():
            print(f"Read first: {path.relative_to(ROOT)}")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
