"""Every figure, drawn from invented tables: of usual data, and of awkward data."""

from dataclasses import replace
from itertools import product

import numpy as np
import pandas as pd
from scipy.spatial.transform import Rotation

import conftest
import sparsurf
from conftest import ROOT
from measures import protein_figures
from sparsurf.patches.readings import words_of
from sparsurf.sampling.combination import TABLE_1
from sparsurf.surfaces.surface import Surface
from sparsurf.views import layout
from sparsurf_study.report.figures import (
    d_over_grid,
    distributions,
    frames,
    number_of_dots,
    over_time,
    pair_figures,
    required_dots,
    rough_and_flat,
    roughness,
    subsets,
)
from sparsurf_study.report.figures.changes import changes_figure
from sparsurf_study.report.figures.comparison_figure import comparison_figure
from sparsurf_study.report.figures.simulation import simulation_figure
from sparsurf_study.report.figures.table1 import table1_figure

BOTH = ("kept", "full")
EVIDENCE = ROOT / "evidence" / "tables"
FINE = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10]


def sphere(n=400, radius=8.0):
    """Return points and normals of an evenly covered ellipsoid."""
    points, normals = conftest.ball(n, radius)
    return points * [1.4, 1.0, 0.8], normals


def grid(**lists):
    """Return a grid.csv of smooth numbers for 1000 dots."""
    usual = {"alpha": [0.2, 1], "beta": [0, 0.4, 1], "gamma": [0, 2, 10], "delta": [0, 4, 10]}
    lists = usual | lists
    table = pd.DataFrame(product(*lists.values()), columns=list(lists), dtype=float)
    table["n_S_expected"] = (
        1000 * table.alpha / (1 + table.beta) / (1 + 0.1 * table.delta + 0.2 * table.gamma)
    )
    table["n_S"] = table.n_S_expected + 3.0
    table["n_S_percent"] = table.n_S / 10
    table["d_kept"] = np.sin(table.gamma + table.beta) + 0.3 * np.cos(table.delta)
    table["d_full"] = -0.2 - 0.01 * table.gamma - 0.01 * table.delta * table.beta
    ends = {
        f"d_{end}_{reading}": table[f"d_{reading}"] + sign * half
        for reading, half in (("kept", 0.2), ("full", 0.04))
        for end, sign in (("low", -1), ("high", 1))
    }
    return table.assign(**ends)


def projection(f=300, k=3, chosen=None):
    """Draw frames in k clusters, of which some are chosen."""
    rng = np.random.default_rng(k)
    labels = np.arange(f) % k
    plane = 20 * rng.normal(size=(k, 2))[labels] + rng.normal(size=(f, 2))
    chosen = list(range(k)) if chosen is None else chosen
    names = [f"c{i + 1}" for i in range(len(chosen))]
    silhouettes = {n: 0.5 - 0.01 * n for n in range(2, 12)}
    return frames.frames_projection(plane, labels, chosen, names, np.array([0.5, 0.2, 0.1]), silhouettes, "p")


def distances(n=500):
    """Return roughness and four columns of Z of n test dots."""
    rng = np.random.default_rng(1)
    return rng.uniform(0.1, 0.9, n), rng.uniform(0, 9, (4, n))


def rough_and_flat_patches(n=500, readings=BOTH, roughness=None):
    """Draw Z of rough and flat patches."""
    r, z = distances(n)
    r = r if roughness is None else roughness
    panels = [
        (f"around kept dots, {words_of(name)}", r, z[2 * (k % 2)], z[2 * (k % 2) + 1])
        for k, name in enumerate(readings)
    ]
    references = {"Z_empty": 8.6, "Z_mean_descriptor": 1.5, "floors": {"fresh dots": 0.5}}
    return rough_and_flat.figure(panels, references)


def kept(n=400, shown=3):
    """Draw a surface, subsets of it, and what is recovered, which errs on one side."""
    points, normals = sphere(n)
    whole, slices = (
        Surface(points, normals),
        [slice(0, None, 2), slice(1, None, 2), slice(0, None, 9)][:shown],
    )
    titles = ["the paper's best, (1, 0, 6, 0)", "random subset of the same size", "a title " * 8]
    cells = [
        (title, Surface(points[own], normals[own]), layout.PALETTE[k])
        for k, (title, own) in enumerate(zip(titles, slices, strict=False))
    ]
    distance = np.where(points[:, 0] < 0, 0.01, 0.3) + np.arange(n) / 1e5
    return subsets.figure(whole, cells, ("recovered", whole, distance, np.arange(n)), "p/c1")


def rough(n=400, values=None):
    """Draw a surface that is rough on one side."""
    points, normals = sphere(n)
    return roughness.figure(
        points, normals, 0.9 - 0.0015 * (points[:, 0] - 11) ** 2 if values is None else values, "p/c1"
    )


def enough(n=1, density=0.7):
    """Draw how many dots are enough on n surfaces, each of whose errors and densities is another."""
    rows = [
        {
            "density": density * (1 + k / 10),
            "n_S_percent": 13.0 + k * (k - 1) / 2,  # whose median is not their mean
            "mean": 0.02 - k / 1000,
            "high_99": 0.1 + k / 100,
            "reconstruction": "interpolant" if k == 3 else "spheres",
        }
        for k in range(n)
    ]
    return required_dots.figure(rows, "p/c1" if n == 1 else "")


def trajectory(n=100):
    """Return ensemble.csv of n frames."""
    k = np.arange(n)
    table = pd.DataFrame({"frame": 3 * k, "time_ps": 200.0 * k, "n_S_percent": 40 + np.sin(k)})
    table["mean_roughness"] = 0.6 + 0.01 * np.cos(k)
    for j, reading in enumerate(BOTH):
        table[f"d_{reading}"] = 1 - 2 * j + 0.2 * np.sin(k / (9 + j))
        table[f"d_se_{reading}"] = 0.1 + k % 3 / 50
    return table


def residues_over_time():
    """Draw two chains over four frames; one residue is buried once."""
    values = 0.4 + np.arange(48).reshape(4, 12) / 100
    values[2, 3] = np.nan
    rows = pd.DataFrame(values, columns=[f"r{k}" for k in range(12)])
    rows.insert(0, "time_ps", 100.0 * np.arange(4))
    rows.insert(0, "frame", range(4))
    residues = pd.DataFrame(
        {"chain": ["A"] * 7 + ["B"] * 5, "residue": [str(20 + k) for k in range(12)]}
        | {"mean_roughness": np.nanmean(values, axis=0), "sd_roughness": [0.01 + 0.01 * k for k in range(12)]}
    )
    return over_time.residues_figure(rows, residues)


def simulation():
    """Draw three stages after a minimisation, each with numbers of its own, and what was aimed at."""
    rows = []
    for s, (stage, n) in enumerate({"minimise": 5, "nvt": 30, "npt": 50, "production": 80}.items()):
        k = np.arange(n)
        table = pd.DataFrame({"stage": stage, "time_ps": 200.0 * k, "temperature_K": 300 + s + np.sin(k)})
        table = table.assign(pressure_bar=1.0 + 10 * s + np.cos(k), density_kg_m3=990.0 + s)
        rows.append(table.assign(potential_kJ_mol=-5000.0 - k))
    judged = pd.DataFrame({"quantity": ["temperature_K", "pressure_bar"], "target": [300.0, 1.0]})
    t = np.arange(90)
    motion = pd.DataFrame({"time_ps": 100.0 * t, "rmsd": np.sqrt(t), "radius_of_gyration": 11 + t / 100})
    return simulation_figure(pd.concat(rows, ignore_index=True), motion, judged)


def distributions_of_many():
    """Draw what the surfaces of a run in batches measure."""
    rng = np.random.default_rng(0)
    measures = {"atoms": 100 * 2 ** rng.normal(3, 1, 80), "mean_roughness": rng.normal(0.6, 0.05, 80)}
    measures |= {"area_per_atom": rng.normal(7, 1, 80), "cavity_percent": rng.exponential(2, 80)}
    return distributions.figure(pd.DataFrame(measures))


def comparison(factors=None, percents=(5.0, 10.0, 20.0, 40.0), mean_patch=3.5):
    """Draw Z that falls with the square root of n_S, by a factor for each sampler; other measures are smaller."""
    factors = factors or {"farthest": 1.0, "uniform": 1.25, "paper": 1.6, "poisson": 1.2, "mine": 2.0}
    rows = [
        (name, p, p + 1, measure, of_measure * factor * 10 / np.sqrt(p + 1))
        for measure, of_measure in (("Z kept", 0.5), ("Z full", 1), ("Z recovered", 0.7))
        for name, factor in factors.items()
        for p in percents
    ]
    table = pd.DataFrame(rows, columns=["sampler", "percent", "n_S_percent", "measure", "value"])
    table = table.assign(low=table["value"] - 0.1, high=table["value"] + 0.2, Z_mean_descriptor=mean_patch)
    return comparison_figure(table.assign(Z_resampled=0.4, Z_empty=9.0), "q/c1", "95 % of something")


def pairs():
    """Draw the AUC of both scores over three pairs."""
    aucs = {"propensity_smoothed": (0.3, 0.5), "protrusion": (0.55, 0.75)}
    rows = [
        (f"pair {k}", side, score, auc + k / 10)
        for k in range(3)
        for score, sides in aucs.items()
        for side, auc in enumerate(sides, 1)
    ]
    return pair_figures.over_pairs("run", pd.DataFrame(rows, columns=["complex", "partner", "score", "auc"]))


def book(distance=2.0, limits=((0.5, 0.9), (0.1, 0.4))):
    """Draw two plates of 20 by 10 Å that face each other; they touch where y is small, if at all."""
    x, y = (axis.ravel() for axis in np.meshgrid(np.arange(0.0, 10, 0.5), np.arange(0.0, 20, 0.5)))
    up = np.tile([0.0, 0, 1], (len(x), 1))
    plates = [Surface(np.column_stack([x, y, 0 * x + z]), up * sign) for z, sign in ((0, 1), (distance, -1))]
    tables = [
        pd.DataFrame({"propensity_smoothed": y + 20 * k, "similarity_smoothed": 100 - y}).assign(
            interface=((y < 5) & bool(limits)).astype(int)
        )
        for k in (0, 1)
    ]
    rows = [(side, sum(ends) / 2, *ends, 9) for side, ends in enumerate(limits, 1)]
    agreement = pd.DataFrame(rows, columns=["partner", "auc", "low", "high", "blocks"])
    scores = [agreement.assign(score=score) for score in ("propensity_smoothed", "flatness")]
    return pair_figures.book_figure("x", plates, tables, pd.concat(scores))


def forms(change=(0.5, 0.2, 4.0, 0.9, np.nan, 0.3, 2.0, 0.4)):
    """Draw a peptide and its copy turned and moved, by the change over its floor of each residue."""
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-216")
    turn, shift = Rotation.from_euler("xyz", [40, 100, 250], degrees=True).as_matrix(), [5.0, -20, 30]
    moved, dots = replace(molecule, xyz=molecule.xyz @ turn + shift), sparsurf.surface(molecule)
    other = sparsurf.Surface(dots.points @ turn + shift, dots.normals @ turn, atom=dots.atom)
    over = np.array(change)
    table = molecule.residues.assign(total=0.11 * np.arange(1, 9), total_floor=0.3, total_moved=0.2)
    table = table.assign(over_floor=over)
    table.loc[5:, "total_moved"] = 0.45
    of_dots = over[molecule.residue_index[dots.atom]]
    pair = [("first", dots, molecule, of_dots), ("second", other, moved, of_dots)]
    return changes_figure("opening", pair, table)


def table1():
    """Draw Table I among runs; d of the first row lies below all of them, Z of the second above."""
    rows = pd.DataFrame(TABLE_1)
    places = pd.DataFrame({f"{name}_published": rows[name] for name in ("d", "Z_tS")})
    for name, row, shift in (("d", 0, 0.5), ("Z_tS", 1, -0.9)):
        places[f"{name}_inside"] = places.index != row
        places[f"{name}_lowest"] = rows[name] - 0.2 + shift * (places.index == row)
        places[f"{name}_highest"] = rows[name] + 0.6 + shift * (places.index == row)
    return table1_figure(places.assign(n_runs=40), rows.assign(d_full=-0.1, Z_tS_full=0.9 + 0.1 * rows.index))


def of_proteins(name):
    """Draw a figure of the evidence from its stored tables."""
    paths = [*EVIDENCE.glob("proteins_*.csv"), *EVIDENCE.glob("proteins_*.csv.gz")]
    stored = {path.name.split(".")[0].removeprefix("proteins_"): pd.read_csv(path) for path in paths}
    return getattr(protein_figures, name)(stored)


NO_VALUES = grid().assign(d_kept=np.nan)
HOLES = grid().assign(d_kept=lambda t: t.d_kept.where((t.gamma != 2) | (t.delta != 4)))
ONE = {"beta": [0], "gamma": [6], "delta": [0]}
LONG = {"beta": [0, 1, 2, 3, 4, 5], "delta": [0.25, 1.25, 2.25, 3.25]}
PICTURES = {  # with a picture in baseline/
    "frames": projection,
    "roughness": rough,
    "number_of_dots": lambda: number_of_dots.figure(grid(), "p/c1"),
    "d_over_grid": lambda: d_over_grid.figure(grid(), "p/c1"),
    "d_over_grid_recovered": lambda: d_over_grid.figure(
        grid(alpha=[0.2, 0.4]).drop(columns="d_kept").assign(d_recovered=lambda t: 0.1 * t.gamma - 0.2)
    ),
    "rough_and_flat": rough_and_flat_patches,
    "rough_and_flat_few": lambda: rough_and_flat_patches(n=40, readings=["full"]),
    "subsets": kept,
    "required_dots": enough,
    "required_dots_of_many": lambda: enough(7),
    "ensemble": lambda: over_time.ensemble_figure(trajectory(), (1, 0, 6, 4), "p"),
    "residues_over_time": residues_over_time,
    "simulation": simulation,
    "distributions": distributions_of_many,
    "compare": comparison,
    "pairs": pairs,
    "book": book,
    "book_apart": lambda: book(60.0, ()),
    "changes": forms,
    "table1": table1,
    "proteins_d": lambda: of_proteins("d"),
    "proteins_needed": lambda: of_proteins("needed"),
}
AWKWARD = {  # little data, and much: texts find their place all the same
    "frames, 11 clusters": lambda: projection(k=11),
    "frames, 1 cluster": lambda: projection(k=1),
    "frames, every frame": lambda: projection(f=40, chosen=list(range(40))),
    "frames, nothing known": lambda: frames.frames_projection(np.eye(3), [0, 0, 1], [], [], [], {}),
    "roughness, 30 dots": lambda: rough(30),
    "number, fine": lambda: number_of_dots.figure(grid(gamma=FINE, delta=FINE)),
    "number, one combination": lambda: number_of_dots.figure(grid(alpha=[1], **ONE)),
    "d, fine": lambda: d_over_grid.figure(grid(beta=[0, 1, 2, 3, 4, 5, 6, 7], gamma=FINE, delta=FINE)),
    "d, long labels": lambda: d_over_grid.figure(grid(**LONG)),
    "d, one combination": lambda: d_over_grid.figure(grid(alpha=[1], **ONE)),
    "d, no values": lambda: d_over_grid.figure(NO_VALUES),
    "d, holes": lambda: d_over_grid.figure(HOLES),
    "rough and flat, three readings": lambda: rough_and_flat_patches(readings=[*BOTH, "recovered"]),
    "rough and flat, empty bins": lambda: rough_and_flat_patches(
        n=20, roughness=np.r_[0.1, np.full(19, 0.9)]
    ),
    "required_dots, most dots are kept": lambda: enough(density=5.2),
    "required_dots, few dots are kept": lambda: enough(density=0.02),
    "ensemble, 1 frame": lambda: over_time.ensemble_figure(trajectory(1), (1, 0, 6, 4)),
    "compare, arrow as high as the reference": lambda: comparison(None, (2.5, 10.0, 20.0, 60.0), 9.0),
    "changes, all over": lambda: forms([2.0] * 7 + [0.5]),
}
