"""One protein of the study over many: its grid, its floors, and Z of samplers by n_S, as it is and recovered.

The grid is that of the default study, with its draws and test dots. `recovered` is measured for a quarter of it, with all of
it on a few (that makes 5,184 surfaces of each protein), and with fewer test dots: the protein is the unit of every interval,
and its own error is small beside how proteins differ.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import pandas as pd

from sparsurf.patches.descriptors import PUBLISHED
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED
from sparsurf.sampling.samplers import named
from sparsurf.study import grid, tables
from sparsurf.study.evaluator import Evaluator
from sparsurf.study.floors import FEW_DRAWS, floors
from sparsurf.study.summary import Result
from sparsurf.surfaces.making import fitting_surface, surface_of
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import spacing
from sparsurf.threads import over_slices

SEED = 20261120
READINGS = ("kept", "surface")  # of the grid
MAX_N_S_PERCENT = 20  # of the best combination that is restricted, as in config.yaml
PERCENTS = (1.0, 1.5, 2.5, 4.0, 6.0, 10.0, 15.0, 25.0, 40.0, 60.0)  # n_S of the samplers, % of the dots
ONE_DRAW = 38_000  # dots; of a larger surface samplers get one draw by n_S: recovering takes most of its time
SAMPLERS = ("uniform", "farthest", "poisson", "paper")  # the last: Table I, alpha set for each n_S
WHOLE = "recovered_whole"  # folder of the proteins all of whose grid was recovered, and name of their table
THINNED = ("alpha", "beta")  # every second value of these makes a quarter of the grid


class Counts(NamedTuple):
    """How often is measured: draws and test dots of the grid, test dots of the floors; draws, test dots and samplers by n_S."""

    draws: int = 6
    tests: int = 200
    of_floors: int = 200
    draws_by_n_s: int = 2
    tests_by_n_s: int = 200  # the same dots each time
    samplers: tuple = SAMPLERS


FEW_TESTS = 48
OF_RECOVERED = Counts(draws=2, tests=FEW_TESTS, samplers=())  # one draw would be chosen by its own luck


@dataclass(frozen=True)
class Rules:
    """How a surface is made and described; Å. `density` is that of the config, a number or 'auto'."""

    R_patch: float = 4.0
    R_zernike: float = 6.0
    D_link: float = 0.5
    descriptor: str = PUBLISHED
    probe_radius: float = 1.4
    density: float | str = "auto"
    reentrant: str = "exact"

    def of_surface(self):
        """The config's `surface`."""
        keys = ("probe_radius", "density", "reentrant")
        return {"method": "analytic"} | {key: getattr(self, key) for key in keys}


def ready(molecule, name, rules, threads):
    """A molecule's surface ready for evaluation, and how dots are laid on its atoms elsewhere.

    Returns
    -------
    Evaluator, and a function of (A, 3) places, Å, that returns their Surface
    """
    sizes, settings = radii(molecule, "dms"), rules.of_surface()
    surface, settings["density"] = fitting_surface(molecule, 0, sizes, settings, rules.D_link, name)

    def lay(xyz):
        return surface_of(replace(molecule, xyz=xyz[None]), 0, sizes, settings)

    evaluator = Evaluator(
        surface, rules.R_patch, rules.R_zernike, rules.D_link, seed=SEED, name=name,
        threads=threads, descriptor=rules.descriptor,
    )  # fmt: skip
    return evaluator, lay


def thin_grid(sampling):
    """The config's `sampling` with every second alpha and beta: a quarter of the combinations, at all gammas and deltas."""
    return {key: values[::2] if key in THINNED else values for key, values in sampling.items()}


def measure(molecule, name, combinations, rules=None, threads=1, counts=None, readings=READINGS):
    """All that the study asks of one protein.

    Parameters
    ----------
    molecule : Molecule, of which the first frame counts
    name : str
    combinations : (K, 4) float64
    rules : Rules, optional
    threads : int
    counts : Counts, optional
    readings : sequence of str
        Of the grid.

    Returns
    -------
    summary.Result, DataFrame of `floors.floors`, DataFrame of `by_n_s`
    """
    rules, counts = rules or Rules(), counts or Counts()
    evaluator, lay = ready(molecule, name, rules, threads)
    if len(evaluator.points) > ONE_DRAW:
        counts = counts._replace(draws_by_n_s=1)
    floor = floors(evaluator, counts.of_floors, lay, molecule.xyz[0], draws=FEW_DRAWS)
    sticks = tables.as_yardsticks(floor)
    found = grid.run(evaluator, combinations, counts.tests, counts.draws, readings)
    table = tables.grid_table(found)
    result = Result(
        name,
        "c1",
        len(evaluator.points),
        float(evaluator.area),
        spacing(evaluator.points),
        float(evaluator.roughness.mean()),
        table,
        tables.ranges_table(table, found, floors=sticks),
        tables.best(table, found, MAX_N_S_PERCENT, sticks),
    )
    return result, floor, by_n_s(evaluator, counts)


def by_n_s(evaluator, counts, percents=PERCENTS):
    """Z of samplers by n_S, of the dots as they are and of the surface recovered from them.

    Returns
    -------
    DataFrame: sampler, percent (wished), n_S, n_S_percent (means of the draws), islands (`surface`: the dots as they are,
    patches cut on the full surface; `recovered`), Z
    """
    functions = named(counts.samplers, "samplers")
    tests = evaluator.draw_tests(counts.tests_by_n_s)
    z_tot, _ = evaluator.describe(tests)
    n_dots = len(evaluator.points)
    jobs = [(name, p, k) for name in counts.samplers for p in percents for k in range(counts.draws_by_n_s)]
    alone, rows = evaluator.changed(threads=1), [None] * len(jobs)

    def one(i, _):
        name, percent, k = jobs[i]
        n = max(4, round(percent / 100 * n_dots))
        kept = np.sort(functions[name](alone, n, evaluator.stream("proteins", name, n, k)))
        z = [alone.distances([kept], tests, z_tot, reading)[0].mean() for reading in (TEXT, RECOVERED)]
        rows[i] = [
            (name, percent, len(kept), reading, value)
            for reading, value in zip((TEXT, RECOVERED), z, strict=True)
        ]

    over_slices(one, len(jobs), evaluator.threads, 1)
    columns = ["sampler", "percent", "n_S", "islands", "Z"]
    table = pd.DataFrame([row for part in rows for row in part], columns=columns)
    table = table.groupby(["sampler", "percent", "islands"], sort=False).mean().reset_index()
    table.insert(3, "n_S_percent", 100 * table["n_S"] / n_dots)
    return table
