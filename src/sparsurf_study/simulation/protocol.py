"""The paper's molecular dynamics as GROMACS parameters, stage by stage.

Source: paper, 'Protein structures and computation of the molecular surfaces'. Parameters that it does not state
(time constant of the thermostat, position restraints during the equilibration) have the usual GROMACS values. Lengths are in Å.
"""

from __future__ import annotations

from typing import Any

STAGES = ("minimise", "nvt", "npt", "production")
GROMACS_DEFAULTS = {
    "ns": 1.0,  # length of the production; the paper's is 10,000
    "nvt_ns": 0.1,
    "npt_ns": 0.1,
    "save_ps": 1.0,  # time between saved frames
    "time_step_fs": 2.0,
    "temperature": 300.0,  # K
    "pressure": 1.0,  # bar
    "cutoff": 12.0,  # Å, of the short-range interactions
    "margin": 11.0,  # Å, from each atom of the protein to the edge of the box
    "force_field": "charmm27",
    "water": "tip3p",
}
# Keys of a protein that select its atoms
SELECTION_KEYS = ("selection", "chains", "residues", "model", "assembly", "altloc")
KEYS_OF_SIMULATION = ("simulate", *SELECTION_KEYS)  # keys of a protein that only its simulation uses
MIN_ENERGIES = 500  # stored values of temperature, pressure, ... per stage

MINIMISE = """\
integrator = steep
emstep = 0.01
emtol = 1000
nsteps = 50000
nstenergy = 1
"""
DYNAMICS = """\
integrator = md
dt = {dt:g}
nsteps = {steps}
nstxout-compressed = {save}
compressed-x-grps = Protein
compressed-x-precision = 1000
nstenergy = {energies}
nstlog = {energies}
constraints = h-bonds
constraint-algorithm = lincs
tcoupl = V-rescale
tc-grps = Protein Non-Protein
tau-t = 0.1 0.1
ref-t = {temperature:g} {temperature:g}
"""
ALL_STAGES = """\
cutoff-scheme = Verlet
coulombtype = PME
rcoulomb = {cutoff:g}
rvdw = {cutoff:g}
pbc = xyz
"""
BAROSTAT = """\
pcoupl = Parrinello-Rahman
pcoupltype = isotropic
tau-p = 2
ref-p = {pressure:g}
compressibility = 4.5e-5
"""
START = {  # each stage continues the previous one; the protein is restrained while the water equilibrates
    "nvt": "define = -DPOSRES\ncontinuation = no\ngen-vel = yes\ngen-temp = {temperature:g}\ngen-seed = {seed}\n",
    "npt": "define = -DPOSRES\nrefcoord-scaling = com\ncontinuation = yes\ngen-vel = no\n" + BAROSTAT,
    "production": "continuation = yes\ngen-vel = no\n" + BAROSTAT,
}


def length_ns(stage: str, settings: dict[str, Any]) -> float:
    """Return the simulated time of a stage in ns; 0 for the minimisation."""
    if stage == "minimise":
        return 0.0
    return settings["ns" if stage == "production" else f"{stage}_ns"]


def with_defaults(settings: dict[str, Any]) -> dict[str, Any]:
    """Return the config's `simulate` of a protein with every default filled in."""
    return GROMACS_DEFAULTS | settings


def velocity_seed(seed: int) -> int:
    """Return the seed in the form that GROMACS needs: positive, of 31 bits."""
    return max(1, seed % (2**31 - 1))


def n_time_steps(stage: str, settings: dict[str, Any]) -> int:
    """Return the number of time steps of a stage of dynamics, at least 1."""
    return max(1, round(length_ns(stage, settings) * 1e6 / settings["time_step_fs"]))


def parameters(stage: str, settings: dict[str, Any], seed: int) -> str:
    """Return the GROMACS parameter file (mdp) of one of `STAGES`; settings as `GROMACS_DEFAULTS`, Å, ns, ps, fs, K and bar."""
    common = ALL_STAGES.format(cutoff=settings["cutoff"] / 10)  # nm
    if stage == "minimise":
        return MINIMISE + common
    n_steps = n_time_steps(stage, settings)
    values = settings | {
        "dt": settings["time_step_fs"] / 1000,
        "steps": n_steps,
        "save": max(1, round(1000 * settings["save_ps"] / settings["time_step_fs"])),
        "energies": max(1, n_steps // MIN_ENERGIES),
        "seed": velocity_seed(seed),
    }
    return (DYNAMICS + START[stage]).format(**values) + common
