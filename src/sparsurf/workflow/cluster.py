"""Slurm: what Snakemake needs to know of a cluster, and jobs of it that will never begin."""

import os
import subprocess
import threading

import yaml

from sparsurf import InputError

# Reasons of a pending job that no waiting mends
NEVER = (
    "PartitionConfig",
    "BadConstraints",
    "InvalidAccount",
    "InvalidQOS",
    "AccountNotAllowed",
    "QOSNotAllowed",
    "PartitionNodeLimit",
    "PartitionTimeLimit",
)
NAME = f"sparsurf-{os.getpid()}"  # begins the names of this study's jobs
OF_ONE_WORD = ("--cluster=", "--executor=", "--max-threads=")  # options that may come with their value
BESIDE = 1  # core of the floors, which are measured beside the grid in one job
WIDTH = 4  # cores that the job of a conformation takes for the last of its work
LEFT_OUT = ("tabulate_residues", "compare_samplers")  # of that job, where no node has so many
EVERY = 60  # seconds between two questions


def parted(options):
    """Options as a list, those that matter here apart from their values."""
    return [
        word for each in options for word in (each.split("=", 1) if each.startswith(OF_ONE_WORD) else [each])
    ]


def replaced(options, profiles):
    """Options of `study.py` in which `--cluster NAME` has become Snakemake's for profiles/NAME and this cluster."""
    if "--cluster" not in options:
        return list(options)
    at = options.index("--cluster")
    name = "".join(options[at + 1 : at + 2])
    if not (profiles / name / "config.yaml").is_file() or not name:
        raise InputError(
            f"--cluster needs the name of a folder in profiles/, as slurm, but has {name or 'none'}."
        )
    given = [*options[:at], *options[at + 2 :]]
    return [
        *given,
        "--workflow-profile",
        str(profiles / name),
        *(_of_slurm(profiles / name, given) if name == "slurm" else []),
    ]


def _of_slurm(profile, given):
    """Options for a Slurm without accounting, and the most cores that its nodes have."""
    found = ["--slurm-jobname-prefix", NAME]
    found += [] if _answer("sacct", "--noheader", "--allocations", "--starttime", "now") is not None else [
        "--slurm-status-command", "squeue", "--slurm-no-account",
    ]  # fmt: skip
    settings = yaml.safe_load((profile / "config.yaml").read_text(encoding="utf-8"))
    partition = settings.get("default-resources", {}).get("slurm_partition")
    named = [word.partition("=")[2] for word in given if word.startswith("slurm_partition=")]
    if (cores := largest_node(*named or [partition])) and not {"--max-threads"} & set(given):
        print(f"The largest node of the cluster has {cores} cores; no job asks for more.")
        found += ["--max-threads", str(max(1, cores - BESIDE))]
        found += ["--groups", *_narrow(settings["groups"], cores)] if cores < WIDTH else []
    return found


def _narrow(groups, cores):
    """The profile's groups where the largest node has few cores: with fewer rules side by side, or one rule a job."""
    chosen = [rule for rule in groups if rule not in LEFT_OUT] if cores > 1 else LEFT_OUT[-1:]
    return [f"{rule}={groups[rule]}" for rule in chosen]


def largest_node(partition=None):
    """Cores of the largest node of a partition, the default one without; None where `sinfo` does not tell."""
    lines = (
        _answer("sinfo", "--noheader", "--format", "%P %c", *(["-p", partition] if partition else [])) or ""
    ).split("\n")
    rows = [line.split() for line in lines if len(line.split()) == 2]
    own = [row for row in rows if partition or row[0].endswith("*")] or rows
    cores = [int(row[1].rstrip("+")) for row in own if row[1].rstrip("+").isdigit()]
    return max(cores, default=None)


def watch(process):
    """End a process of Snakemake once a job of this study waits for what will never come; says so."""

    def ask():
        while process.poll() is None:
            for job, reason in never_begins():
                print(
                    f"Slurm will never start job {job} ({reason}). Ask for less, or name another partition.",
                    flush=True,
                )
                process.terminate()
                return
            done.wait(EVERY)

    done = threading.Event()
    threading.Thread(target=ask, daemon=True).start()


def never_begins():
    """(id, reason) of pending jobs of this study that no waiting brings to run."""
    lines = (
        _answer("squeue", "--me", "--noheader", "--states=PENDING", "--format", "%i %j %r") or ""
    ).splitlines()
    rows = [line.replace("(", "").replace(")", "").split(None, 2) for line in lines]
    own = [row for row in rows if len(row) == 3 and row[1].startswith(NAME)]
    return [(job, reason) for job, _, reason in own if reason.startswith(NEVER)]


def _answer(*command):
    """What a program prints; None where it is not there, fails or does not answer."""
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=30, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return None
    return done.stdout if done.returncode == 0 else None
