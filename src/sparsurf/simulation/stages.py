"""One stage of the simulation, continued from its last checkpoint where it was interrupted."""

import hashlib
import json
import re
import shutil
from pathlib import Path

import numpy as np

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.simulation import gromacs
from sparsurf.simulation.protocol import parameters, steps

CHECKPOINT = 1  # minutes between two checkpoints: what a kill can cost
TAIL = 8192  # bytes of a log that hold its last report


def run_stage(stage, system, before, settings, seed, folder, threads, progress=lambda done, of: None):
    """Run a stage in `folder`, or go on with it where a run of the same inputs was interrupted.

    Parameters
    ----------
    stage : one of protocol.STAGES
    system : folder that `system.prepare` filled
    before : folder of the stage before, None for the minimisation
    settings, seed : see `protocol.parameters`
    folder : Path, the stage's own; kept between runs until the stage is complete
    threads : int
    progress : callable, told how many of how many time steps are done

    Returns
    -------
    folder, holding final.gro, topol.tpr, energies.edr, md.log, and of dynamics state.cpt and trajectory.xtc

    Raises
    ------
    InputError : GROMACS is missing or fails
    """
    folder = Path(folder).absolute()
    system, before = Path(system).absolute(), Path(before).absolute() if before else None
    text = parameters(stage, settings, seed)
    begin = [before / "final.gro" if before else system / "system.gro"]
    begin += [before / "state.cpt"] if before and (before / "state.cpt").is_file() else []
    mark = fingerprint(text, [*sorted(system.glob("*.top")), *sorted(system.glob("*.itp")), *begin])
    if not (folder / "topol.tpr").is_file() or _mark_of(folder) != mark:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        (folder / "stage.mdp").write_text(text, encoding="ascii")
        state = ["-t", begin[1]] if len(begin) > 1 else []
        gromacs.run("grompp", "-f", "stage.mdp", "-c", begin[0], "-r", begin[0], *state, "-p", system / "topol.top",
                    "-o", "topol.tpr", "-maxwarn", 0, folder=folder)  # fmt: skip
        (folder / "stage.json").write_text(json.dumps({"inputs": mark}) + "\n", encoding="ascii")
    if not (folder / "final.gro").is_file():
        _simulate(stage, settings, folder, threads, progress)
    return folder


def _simulate(stage, settings, folder, threads, progress):
    total = steps(stage, settings) if stage != "minimise" else 0
    own = ["-nt", threads] if Path(gromacs.program()).name == "gmx" else ["-ntomp", threads]
    files = ["-s", "topol.tpr", "-c", "final.gro", "-g", "md.log", "-e", "energies.edr", "-o", "full.trr"]
    if stage != "minimise":
        files += ["-x", "trajectory.xtc", "-cpo", "state.cpt", "-cpt", CHECKPOINT]
        files += ["-cpi", "state.cpt"] if (folder / "state.cpt").is_file() else []

    def wait():
        if total:
            progress(reached(folder / "md.log"), total)

    gromacs.run("mdrun", *files, *own, folder=folder, wait=wait)
    (folder / "full.trr").unlink(missing_ok=True)
    for backup in folder.glob("state_prev.cpt"):
        backup.unlink()


def reached(path_to_log):
    """Time step that a running simulation last noted in its log."""
    if not Path(path_to_log).is_file():
        return 0
    with open(path_to_log, "rb") as stream:
        stream.seek(max(0, stream.seek(0, 2) - TAIL))
        noted = re.findall(r"Step +Time\n +(\d+) ", stream.read().decode("latin-1"))
    return int(noted[-1]) if noted else 0


def fingerprint(text, paths):
    """Digest of a stage's parameters and input files."""
    digest = hashlib.sha256(text.encode())
    for path in paths:
        digest.update(Path(path).read_bytes())
    return digest.hexdigest()


def _mark_of(folder):
    path = folder / "stage.json"
    return json.loads(path.read_text(encoding="ascii"))["inputs"] if path.is_file() else None


def take_trajectory(system, production, path_to_topology, path_to_trajectory):
    """The protein alone, molecules whole across the periodic box: its first frame as PDB, all as XTC.

    Chains and residues keep the names of the prepared structure, which GROMACS's run files do not hold.
    """
    production, trajectory = Path(production).absolute(), Path(path_to_trajectory).absolute()
    gromacs.run("trjconv", "-s", "topol.tpr", "-f", "trajectory.xtc", "-o", trajectory, "-pbc", "whole",
                folder=production, given="Protein\n")  # fmt: skip
    prepared = Path(system, "hydrogens.pdb")
    molecule = read_molecule(prepared, trajectory, whole=False).frame(0)
    molecule.write_pdb(path_to_topology)
    return np.asarray(molecule.xyz[0])
