"""A study of a few seconds for tests, and Snakemake as a user runs it."""

import subprocess
import sys

import yaml

from conftest import ROOT

SMALL = {
    "run": "small",
    "proteins": {
        "tdp43": {
            "structure": str(ROOT / "data" / "tdp43" / "topology.pdb"),
            "trajectory": str(ROOT / "data" / "tdp43" / "trajectory.xtc"),
            "residues": "209-222",
        }
    },
    "frames": {"use": [0, 700]},
    "sampling": {"alpha": [0.5, 1.0], "beta": [0.0, 0.4], "gamma": [0, 6], "delta": [0, 6]},
    "evaluation": {"test_dots": 40, "draws": 2},
    "tables": {"ranges": 3},
    "fields": ["hydropathy"],
}
ONE = SMALL | {"frames": {"use": [0]}}  # its first conformation only


def snakemake(folder, config, *options, root=ROOT):
    """Run the workflow in a folder of its own; returns the finished process."""
    return subprocess.run(
        command(folder, config, *options, root=root), capture_output=True, text=True, check=False
    )


def command(folder, config, *options, root=ROOT):
    folder.mkdir(exist_ok=True)
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    where = ["--snakefile", root / "Snakefile", "--directory", folder, "--configfile", folder / "config.yaml"]
    return [sys.executable, "-m", "snakemake", *map(str, where), "--cores", "2", *options]


def output(process):
    return process.stdout + process.stderr
