"""Run a study and write its report: `python scripts/study.py [config.yaml] [snakemake options]`.

One study at a time per checkout: the lock is the operating system's, so that a killed run leaves
nothing to unlock and the next one continues where it was.
"""

import fcntl
import subprocess
import sys
import time
from pathlib import Path

import yaml

ROOT = Path(__file__).resolve().parents[1]


def main(path_to_config="config.yaml", *options):
    """Run Snakemake, then its report where anything is newer than it; returns the exit code."""
    if not Path(path_to_config).is_file():
        print(
            f"There is no config file {path_to_config!r}; give one with CONFIG=my_config.yaml.",
            file=sys.stderr,
        )
        return 2
    lock = ROOT / ".snakemake" / "study.lock"
    lock.parent.mkdir(exist_ok=True)
    with open(lock, "w", encoding="utf-8") as held:
        try:
            fcntl.flock(held, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            print("Another study runs in this folder; wait for it to end.", file=sys.stderr)
            return 2
        begin = time.time()
        code = snakemake(path_to_config, "--nolock", *options)
        results = ROOT / "results" / run_name(path_to_config)
        report = results / "report.html"
        if not results.is_dir() or {"--dry-run", "-n"} & set(options):
            return code
        if code and any(results.glob("*/*/ranges.csv")):  # what there is, without the proteins that failed
            subprocess.call([sys.executable, str(ROOT / "scripts" / "summarise_run.py"), str(results)])
        if code == 0 and is_older(report, results):  # Snakemake makes no report of an unfinished study
            code = snakemake(path_to_config, "--nolock", "--quiet", "all", "--report", str(report))
        print_results(results, code, begin)
        return code


def snakemake(path_to_config, *options):
    """Run Snakemake in the project's folder; returns its exit code."""
    command = [sys.executable, "-m", "snakemake", "--snakefile", ROOT / "Snakefile", "--directory", ROOT]
    return subprocess.call(
        [*map(str, command), "--configfile", str(Path(path_to_config).resolve()), *options]
    )


def run_name(path_to_config):
    """The config's `run`."""
    return str((yaml.safe_load(Path(path_to_config).read_text(encoding="utf-8")) or {}).get("run", "default"))


def is_older(report, results):
    """Whether a result is newer than the report."""
    if not report.is_file():
        return True
    logs = results / "logs"
    files = (
        path for path in results.rglob("*") if path.is_file() and logs not in path.parents and path != report
    )
    return any(path.stat().st_mtime > report.stat().st_mtime for path in files)


def print_results(results, code, begin):
    """Say where to look, and what failed since `begin` with its sentence."""
    where = results.relative_to(ROOT)
    if code:
        print(
            f"\nNot everything could be made. What was made is in {where}/. What went wrong:", file=sys.stderr
        )
        for log in sorted((results / "logs").rglob("*.log")):
            if log.stat().st_mtime >= begin:
                sentences = [
                    line[6:]
                    for line in log.read_text(encoding="utf-8").splitlines()
                    if line.startswith("ERROR ")
                ]
                for sentence in sentences:
                    print(
                        f"- {log.relative_to(results / 'logs').with_suffix('')}: {sentence}", file=sys.stderr
                    )
        return
    first = sorted(results.glob("*/*/ranges.md"))[:1]
    print(f"\nResults: {where}/ (what every file is: results/README.md)")
    print(f"Report:  {where}/report.html")
    for path in [results / "verdict.md", *first]:
        if path.is_file():
            print(f"Read first: {path.relative_to(ROOT)}")


if __name__ == "__main__":
    sys.exit(main(*sys.argv[1:]))
