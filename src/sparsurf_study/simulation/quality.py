"""Check a simulation: temperature, pressure, density, energy, and the motion of the protein."""

from __future__ import annotations

import os
import re
import tempfile
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import pandas as pd
from scipy.stats import t as student

from sparsurf.molecules.conformations import superpose
from sparsurf_study.simulation import gromacs
from sparsurf_study.simulation.protocol import STAGES

if TYPE_CHECKING:
    from sparsurf.molecules.molecule import Molecule

QUANTITIES = {  # names in GROMACS: columns
    "Potential": "potential_kJ_mol",
    "Total-Energy": "total_energy_kJ_mol",
    "Temperature": "temperature_K",
    "Pressure": "pressure_bar",
    "Density": "density_kg_m3",
}
# A warning is given if the production's mean deviates from its target by more than this and its 95 % interval. The paper
# reports 1006 +- 5 kg / m^3; the density changes by up to 3 % with the share of the box that the protein fills.
TOLERANCE = {"temperature_K": 1.0, "pressure_bar": 10.0, "density_kg_m3": 30.0}
WATER_DENSITY = 1006.0  # kg / m^3, paper, Materials and Methods
N_BLOCKS = 10  # from which the error of a mean is estimated, as successive values are correlated
MIN_SAMPLES_OF_MEAN = 50  # from which a mean is compared with its target


def energies(folders: Mapping[str, str | os.PathLike[str]]) -> pd.DataFrame:
    """Read the energies over time from the folders of the stages: the rows of energies.csv, NaN where a stage has none."""
    tables = []
    with tempfile.TemporaryDirectory() as scratch:
        for stage in STAGES:
            folder, out = Path(folders[stage]).absolute(), Path(scratch, f"{stage}.xvg")
            gromacs.run_gromacs("energy", "-f", "energies.edr", "-o", out, folder=folder,
                        stdin="\n".join(_stored_quantities(folder)) + "\n\n")  # fmt: skip
            tables.append(read_xvg(out).assign(stage=stage))
    return pd.concat(tables, ignore_index=True).reindex(columns=["stage", "time_ps", *QUANTITIES.values()])


def _stored_quantities(folder: Path) -> list[str]:
    """Return the QUANTITIES of a stage: the minimisation has no temperature, and only a barostat gives a density."""
    is_minimisation = not (folder / "state.cpt").is_file()
    if is_minimisation:
        return ["Potential"]
    has_barostat = "pcoupl = " in (folder / "stage.mdp").read_text(encoding="ascii")
    return [name for name in QUANTITIES if name != "Density" or has_barostat]


def read_xvg(path: str | os.PathLike[str]) -> pd.DataFrame:
    """Read a table of GROMACS, with columns named by its legend (as in QUANTITIES where known)."""
    lines = Path(path).read_text(encoding="latin-1").splitlines()
    names = re.findall(r'^@ s\d+ legend "(.*)"', "\n".join(lines), re.M)
    rows = [[float(word) for word in line.split()] for line in lines if line and line[0] not in "#@&"]
    names = [QUANTITIES.get(name.replace(" ", "-"), name) for name in names]
    return pd.DataFrame(rows, columns=["time_ps", *names])


def motion(molecule: Molecule) -> pd.DataFrame:
    """Tabulate motion.csv, Å: RMSD of C-alpha atoms from the first frame, superposed, and radius of gyration of heavy atoms."""
    backbone = molecule.name == "CA"
    heavy = molecule.heavy
    # Several rotations fit atoms on a line equally well; their deviations are the same.
    superposed = superpose(molecule.xyz, backbone, any_rotation=True)[:, backbone]
    rmsd = np.sqrt(((superposed - superposed[0]) ** 2).sum(axis=2).mean(axis=1))
    xyz = molecule.xyz[:, heavy]
    gyration = np.sqrt(((xyz - xyz.mean(axis=1, keepdims=True)) ** 2).sum(axis=2).mean(axis=1))
    return pd.DataFrame({"time_ps": molecule.time_ps, "rmsd": rmsd, "radius_of_gyration": gyration})


def judge(table: pd.DataFrame, settings: dict[str, Any]) -> pd.DataFrame:
    """Compare means of the production with temperature (K) and pressure (bar): quality.csv, with 95 % intervals by blocks."""
    targets = {
        "temperature_K": settings["temperature"],
        "pressure_bar": settings["pressure"],
        "density_kg_m3": WATER_DENSITY,
    }
    rows = []
    for name, target in targets.items():
        values = table.loc[table["stage"] == "production", name].dropna().to_numpy()
        mean, half = mean_of_blocks(values)
        measurable = len(values) >= MIN_SAMPLES_OF_MEAN
        near = bool(abs(mean - target) <= half + TOLERANCE[name]) if measurable else np.nan
        rows.append((name, mean, half, target, near))
    return pd.DataFrame(rows, columns=["quantity", "mean", "half_width", "target", "near"])


def mean_of_blocks(values: np.ndarray) -> tuple[float, float]:
    """Return the mean of an autocorrelated series, and half its 95 % interval from N_BLOCKS block means."""
    if len(values) == 0:
        return float("nan"), float("nan")
    if len(values) < 2 * N_BLOCKS:
        return float(np.mean(values)), float("nan")
    blocks = np.array([block.mean() for block in np.array_split(values, N_BLOCKS)])
    half = student.ppf(0.975, N_BLOCKS - 1) * blocks.std(ddof=1) / np.sqrt(N_BLOCKS)
    return float(np.mean(values)), float(half)


def warnings(judged: pd.DataFrame) -> list[str]:
    """Return one sentence for each mean that misses its target."""
    return [
        f"the mean {row.quantity} of the production is {row.mean:.4g} +- {row.half_width:.2g}, but its target is "
        f"{row.target:g}: look at the figure of the simulation before you use its frames"
        for row in judged.itertuples()
        if row.near is False
    ]
