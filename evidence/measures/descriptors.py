"""How much a descriptor changes when only the position or the dots change, not the surface."""

from collections.abc import Iterator

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from scipy.spatial.transform import Rotation

from sparsurf_study.workflow.jobs import Job
from measures.molecules import atoms_of
from measures.tables import read_tables, write_tables
from sparsurf import registry
from sparsurf.patches.descriptors import describe_patches
from sparsurf.patches.index import D_LINK, build_index
from sparsurf.streams import stream
from sparsurf.surfaces.molecular_surface import DENSITY, molecular_surface
from sparsurf.views import layout
from sparsurf.views.layout import COLUMN, PALETTE, axes, legend, sheet, styled
from sparsurf_study.analysis.relation import with_interval

CHANGES = ("turned", "fresh dots", "turned, fresh dots")
TURNS = 5
COLOURS = {"published": PALETTE[1], "rotation_robust": PALETTE[0]}


def poses(
    xyz: np.ndarray,
    radii: np.ndarray,
    tests: np.ndarray,
    density: float,
    rng: np.random.Generator,
    turns: int = TURNS,
) -> Iterator[tuple[str, np.ndarray, np.ndarray, np.ndarray]]:
    """Yield (change, points, normals, places of the tests) of one surface: as it is first, then changed.

    Fresh dots are those that the surface of the turned molecule gets, turned back.

    Parameters
    ----------
    xyz, radii : (A, 3) and (A,), Å
    tests : (T, 3), Å
    density : dots per Å^2
    rng : numpy.random.Generator
    """
    surface = molecular_surface(xyz, radii, density=density)
    yield "", surface.points, surface.normals, tests
    for turn in Rotation.random(turns, rng).as_matrix():
        other = molecular_surface(xyz @ turn.T, radii, density=density)
        yield CHANGES[0], surface.points @ turn.T, surface.normals @ turn.T, tests @ turn.T
        yield CHANGES[1], other.points @ turn, other.normals @ turn, tests
        yield CHANGES[2], other.points, other.normals, tests @ turn.T


def steadiness(
    xyz: np.ndarray,
    radii: np.ndarray,
    tests: np.ndarray,
    rng: np.random.Generator,
    density: float = DENSITY,
    threads: int = 1,
) -> pd.DataFrame:
    """Measure the change of each descriptor relative to the difference of two patches.

    Returns
    -------
    DataFrame with density, descriptor, change, Z, sd of Z over the turns, Z_two_patches and ratio
    """
    descriptors = {}
    for change, points, normals, places in poses(xyz, radii, tests, density, rng):
        index = build_index(points, normals, D_LINK)
        for name in registry.TABLE["descriptor"]:
            z, _ = describe_patches(index, places, threads=threads, descriptor=name)
            descriptors.setdefault((name, change), []).append(z)
    rows = []
    for name in registry.TABLE["descriptor"]:
        z = descriptors[name, ""][0]
        apart = np.linalg.norm(z - np.roll(z, 1, axis=0), axis=1).mean()  # tests stand in random order
        for change in CHANGES:
            moved = [np.linalg.norm(z - w, axis=1).mean() for w in descriptors[name, change]]
            rows.append(
                (density, name, change, np.mean(moved), np.std(moved, ddof=1), apart, np.mean(moved) / apart)
            )
    columns = ["density", "descriptor", "change", "Z", "sd", "Z_two_patches", "ratio"]
    return pd.DataFrame(rows, columns=columns)


def means(table: pd.DataFrame, keys: list[str]) -> pd.DataFrame:
    """Return the ratio over the structures, with its 95 % interval: keys, structures, lowest and highest."""
    rows = []
    for group, part in table.groupby(keys, sort=False):
        row = (
            dict(zip(keys, group, strict=True))
            | {"structures": len(part)}
            | with_interval("ratio", part["ratio"])
        )
        rows.append(row | {"lowest": part["ratio"].min(), "highest": part["ratio"].max()})
    return pd.DataFrame(rows)


@styled
def draw(means: pd.DataFrame) -> Figure:
    """Draw the change of each descriptor relative to the difference of two patches, with 95 % intervals over structures."""
    figure = sheet(COLUMN, 66)
    ax = axes(figure, 14, 3, 70, 46)
    changes = list(means["change"].unique())
    for d, (name, colour) in enumerate(COLOURS.items()):
        rows = means[means["descriptor"] == name].set_index("change").loc[changes]
        error = [rows["ratio"] - rows["ratio_low"], rows["ratio_high"] - rows["ratio"]]
        x = [k + 0.36 * (d - 0.5) for k in range(len(changes))]
        ax.bar(
            x,
            rows["ratio"],
            0.32,
            yerr=error,
            color=colour,
            capsize=2,
            label=registry.label("descriptor", name),
        )
    ax.set_xticks(range(len(changes)), [change.replace(", ", ",\n") for change in changes])
    ax.set_ylabel("change / difference of two patches")
    legend(figure, 14, 61, ax.get_legend_handles_labels()[0], ncols=2)
    return figure


def measure_descriptors(job: Job) -> None:
    """Measure how far a rotation and fresh dots change each descriptor on one structure."""
    protein, seed = job.wildcards.protein, job.params.seed
    xyz, radii = atoms_of(job.input.structure)
    points = molecular_surface(xyz, radii).points
    tests = points[stream(seed, protein, "tests").permutation(len(points))[: job.params.test_dots]]
    tables = [
        steadiness(xyz, radii, tests, stream(seed, protein, "turns"), density, job.threads)
        for density in job.params.densities
    ]
    pd.concat(tables).assign(surface=protein).to_csv(job.output.changes, index=False)


def tabulate_descriptors(job: Job) -> None:
    """Tabulate and draw how far position and dots change both descriptors, over several structures."""
    changes = read_tables(job.input.changes)
    over_structures = means(changes, ["density", "descriptor", "change"])
    write_tables({job.output.changes: changes, job.output.changes_means: over_structures})
    at_lowest = over_structures[over_structures["density"] == over_structures["density"].min()]
    layout.save(draw(at_lowest), job.output.figure)
