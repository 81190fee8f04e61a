"""Run one stage of the simulation, or continue it from its last checkpoint."""

from __future__ import annotations

import hashlib
import json
import os
import re
import shutil
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any

import numpy as np

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf_study.simulation import gromacs
from sparsurf_study.simulation.protocol import n_time_steps, parameters

CHECKPOINT_MINUTES = 1  # between two checkpoints; an interruption loses no more than this
LOG_TAIL = 8192  # bytes at the end of a log that contain its last report


def run_stage(
    stage: str,
    system: str | os.PathLike[str],
    before: str | os.PathLike[str] | None,
    settings: dict[str, Any],
    seed: int,
    folder: str | os.PathLike[str],
    threads: int,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Path:
    """Run one of `protocol.STAGES` in `folder`, or continue it if a run with the same inputs was interrupted; return the folder.

    `system` is from `system.prepare_system`, `before` that of the previous stage. The folder is kept between runs until the stage
    is complete, with final.gro, topol.tpr, energies.edr, md.log, and for dynamics state.cpt and trajectory.xtc.
    """
    folder = Path(folder).absolute()
    system, before = Path(system).absolute(), Path(before).absolute() if before else None
    text = parameters(stage, settings, seed)
    start = [before / "final.gro" if before else system / "system.gro"]
    start += [before / "state.cpt"] if before and (before / "state.cpt").is_file() else []
    digest = fingerprint(text, [*sorted(system.glob("*.top")), *sorted(system.glob("*.itp")), *start])
    # A checkpoint continues the run that it was written by: with other inputs it would mix two simulations
    if not (folder / "topol.tpr").is_file() or _stored_fingerprint(folder) != digest:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "stage.mdp").write_text(text, encoding="ascii")
        state = ["-t", start[1]] if len(start) > 1 else []
        gromacs.run_gromacs("grompp", "-f", "stage.mdp", "-c", start[0], "-r", start[0], *state, "-p", system / "topol.top",
                    "-o", "topol.tpr", "-maxwarn", 0, folder=folder)  # fmt: skip
        (folder / "stage.json").write_text(json.dumps({"inputs": digest}) + "\n", encoding="ascii")
    # mdrun writes this file at its end
    if not (folder / "final.gro").is_file():
        _simulate(stage, settings, folder, threads, progress)
    return folder


def _simulate(
    stage: str, settings: dict[str, Any], folder: Path, threads: int, progress: Callable[[int, int], None]
) -> None:
    """Run `gmx mdrun` in a prepared folder."""
    total = n_time_steps(stage, settings) if stage != "minimise" else 0
    thread_option = ["-nt", threads] if Path(gromacs.program()).name == "gmx" else ["-ntomp", threads]
    files: list[object] = ["-s", "topol.tpr", "-c", "final.gro", "-g", "md.log", "-e", "energies.edr"]
    files += ["-o", "full.trr"]
    if stage != "minimise":
        files += ["-x", "trajectory.xtc", "-cpo", "state.cpt", "-cpt", CHECKPOINT_MINUTES]
        files += ["-cpi", "state.cpt"] if (folder / "state.cpt").is_file() else []

    def wait() -> None:
        """Report the progress."""
        if total:
            progress(current_step(folder / "md.log"), total)

    gromacs.run_gromacs("mdrun", *files, *thread_option, folder=folder, wait=wait)
    (folder / "full.trr").unlink(missing_ok=True)
    for backup in folder.glob("state_prev.cpt"):
        backup.unlink()


def current_step(path_to_log: str | os.PathLike[str]) -> int:
    """Return the last time step in the log of a running simulation; 0 if there is none."""
    if not Path(path_to_log).is_file():
        return 0
    with open(path_to_log, "rb") as stream:
        stream.seek(max(0, stream.seek(0, 2) - LOG_TAIL))
        steps = re.findall(r"Step +Time\n +(\d+) ", stream.read().decode("latin-1"))
    return int(steps[-1]) if steps else 0


def fingerprint(text: str, paths: Iterable[Path]) -> str:
    """Hash a stage's parameters and input files."""
    digest = hashlib.sha256(text.encode())
    for path in paths:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def _stored_fingerprint(folder: Path) -> str | None:
    """Return the hash of the inputs from which a stage was prepared."""
    path = folder / "stage.json"
    return json.loads(path.read_text(encoding="ascii"))["inputs"] if path.is_file() else None


def extract_protein(
    system: str | os.PathLike[str],
    production: str | os.PathLike[str],
    path_to_topology: str | os.PathLike[str],
    path_to_trajectory: str | os.PathLike[str],
) -> np.ndarray:
    """Write the protein without water, its molecules whole and named as prepared, as PDB and XTC; return the first frame, Å."""
    production, trajectory = Path(production).absolute(), Path(path_to_trajectory).absolute()
    gromacs.run_gromacs("trjconv", "-s", "topol.tpr", "-f", "trajectory.xtc", "-o", trajectory, "-pbc", "whole",
                folder=production, stdin="Protein\n")  # fmt: skip
    prepared = Path(system, "hydrogens.pdb")
    molecule = read_molecule(prepared, trajectory, whole=False).frame(0)
    molecule.write_pdb(path_to_topology)
    return np.asarray(molecule.xyz[0])
