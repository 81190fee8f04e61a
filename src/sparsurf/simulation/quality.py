"""Whether a simulation did what it was asked: temperature, pressure, density, energy, and how far the protein moved."""

import re
import tempfile
from pathlib import Path

import numpy as np
import pandas as pd
from scipy.stats import t as student

from sparsurf.molecules.conformations import superpose
from sparsurf.simulation import gromacs
from sparsurf.simulation.protocol import STAGES

QUANTITIES = {  # GROMACS's names: column
    "Potential": "potential_kJ_mol",
    "Total-Energy": "total_energy_kJ_mol",
    "Temperature": "temperature_K",
    "Pressure": "pressure_bar",
    "Density": "density_kg_m3",
}
# What the mean of the production must be near to: beyond its own 95 % interval and this much, a warning follows.
# The paper finds 1006 +- 5 kg / m^3; a protein of another share of the box moves that by up to 3 %.
TOLERANCE = {"temperature_K": 1.0, "pressure_bar": 10.0, "density_kg_m3": 30.0}
DENSITY = 1006.0  # kg / m^3, paper, Materials and Methods
BLOCKS = 10  # of which the error of a mean is made; within a block values depend on each other
FEWEST = 50  # values; fewer tell nothing


def energies(folders):
    """Energies over time of all stages.

    Parameters
    ----------
    folders : dict, stage -> folder that `stages.run_stage` filled

    Returns
    -------
    DataFrame: stage, time_ps (steps in the minimisation), then the columns of QUANTITIES; NaN where a stage has none
    """
    tables = []
    with tempfile.TemporaryDirectory() as scratch:
        for stage in STAGES:
            folder, out = Path(folders[stage]).absolute(), Path(scratch, f"{stage}.xvg")
            gromacs.run("energy", "-f", "energies.edr", "-o", out, folder=folder,
                        given="\n".join(_stored(folder)) + "\n\n")  # fmt: skip
            tables.append(read_xvg(out).assign(stage=stage))
    return pd.concat(tables, ignore_index=True).reindex(columns=["stage", "time_ps", *QUANTITIES.values()])


def _stored(folder):
    """Those of QUANTITIES that a stage has: without a barostat there is no density, without motion no temperature."""
    moving = (folder / "state.cpt").is_file()
    text = (folder / "stage.mdp").read_text(encoding="ascii")
    return [
        name
        for name in QUANTITIES
        if name == "Potential" or (moving and (name != "Density" or "pcoupl = " in text))
    ]


def read_xvg(path):
    """A table that GROMACS wrote, columns named by its legend (as in QUANTITIES where known)."""
    lines = Path(path).read_text(encoding="latin-1").splitlines()
    names = re.findall(r'^@ s\d+ legend "(.*)"', "\n".join(lines), re.M)
    rows = [[float(word) for word in line.split()] for line in lines if line and line[0] not in "#@&"]
    names = [QUANTITIES.get(name.replace(" ", "-"), name) for name in names]
    return pd.DataFrame(rows, columns=["time_ps", *names])


def motion(molecule):
    """How the protein moves.

    Parameters
    ----------
    molecule : molecules.molecule.Molecule, all frames

    Returns
    -------
    DataFrame: time_ps, rmsd (Å, of the C-alpha atoms to the first frame after superposition), radius_of_gyration
    (Å, heavy atoms with equal weights)
    """
    backbone = molecule.name == "CA"
    heavy = ~np.isin(molecule.element, ["H", "D"])
    on_first = superpose(molecule.xyz, backbone)[:, backbone]
    rmsd = np.sqrt(((on_first - on_first[0]) ** 2).sum(axis=2).mean(axis=1))
    at = molecule.xyz[:, heavy]
    gyration = np.sqrt(((at - at.mean(axis=1, keepdims=True)) ** 2).sum(axis=2).mean(axis=1))
    return pd.DataFrame({"time_ps": molecule.time_ps, "rmsd": rmsd, "radius_of_gyration": gyration})


def judge(table, settings):
    """Means of the production against their targets.

    Parameters
    ----------
    table : DataFrame of `energies`
    settings : dict with temperature (K) and pressure (bar)

    Returns
    -------
    DataFrame: quantity, mean, half_width (of the 95 % interval, from block means), target, near (bool; NaN where the
    run is too short to tell)
    """
    targets = {
        "temperature_K": settings["temperature"],
        "pressure_bar": settings["pressure"],
        "density_kg_m3": DENSITY,
    }
    rows = []
    for name, target in targets.items():
        values = table.loc[table["stage"] == "production", name].dropna().to_numpy()
        mean, half = mean_of_blocks(values)
        enough = len(values) >= FEWEST
        near = bool(abs(mean - target) <= half + TOLERANCE[name]) if enough else np.nan
        rows.append((name, mean, half, target, near))
    return pd.DataFrame(rows, columns=["quantity", "mean", "half_width", "target", "near"])


def mean_of_blocks(values):
    """Mean of a series whose neighbours depend on each other, and half its 95 % interval from BLOCKS block means."""
    if len(values) == 0:
        return float("nan"), float("nan")
    if len(values) < 2 * BLOCKS:
        return float(np.mean(values)), float("nan")
    blocks = np.array([block.mean() for block in np.array_split(values, BLOCKS)])
    half = student.ppf(0.975, BLOCKS - 1) * blocks.std(ddof=1) / np.sqrt(BLOCKS)
    return float(np.mean(values)), float(half)


def warnings(judged):
    """One sentence for each mean that is off its target."""
    return [
        f"the mean {row.quantity} of the production is {row.mean:.4g} +- {row.half_width:.2g}, off its target {row.target:g}: "
        "look at the figure of the simulation before you use its frames"
        for row in judged.itertuples()
        if row.near is False
    ]
