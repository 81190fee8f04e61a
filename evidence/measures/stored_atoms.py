"""What becomes of a surface if its atoms are changed, and ways to store a surface in few bytes at equal errors.

Source: Draco, a compressor of meshes by Google (package DracoPy); decimation as in `rebuilding`.
"""

from collections.abc import Iterator, Mapping, Sequence
from importlib.util import find_spec

import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures import rebuilding
from measures.opponents import TRIANGLE, VERTEX, dots_on
from measures.surface_atoms import Spheres, largest_distance
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.mesh import MeshSize
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.radii import radii as radii_of
from sparsurf.surfaces.triangulation import molecular_mesh

TEST_DENSITY = 1.0  # dots per Å^2 from which errors are measured
BITS = 10  # of a coordinate along the longest side
DRACO_BITS = 12
FLOAT = 4  # bytes
NUMBERS_OF_A_DOT, NUMBERS_OF_AN_ATOM = 6, 4
REQUESTED = 0.02  # Å, mean error at which ways to store a surface are compared
FEWEST, MOST = 0.5, 8.0  # vertices per Å^2 between which a mesh of this error is sought; it has about 1.7
HALVINGS = 8  # until the number of vertices is known within 1 %


def rounded(spheres: Spheres) -> tuple[Spheres, float]:
    """Round the positions of atoms to `BITS` bits of the longest side; return the step, Å."""
    xyz, radii = spheres
    step = float(np.ptp(xyz, axis=0).max() / (2**BITS - 1))
    low = xyz.min(axis=0)
    return (low + np.rint((xyz - low) / step) * step, radii), step


def errors(some: Spheres, whole: Spheres) -> dict[str, float]:
    """Return the mean and the largest distance between two surfaces, of both ways the larger, Å."""
    ways = []
    for a, b in ((some, whole), (whole, some)):
        dots = sparsurf.surface(a, density=TEST_DENSITY)
        ways.append(np.abs(exact_distance(dots.points, roll_spheres(*b, PROBE_RADIUS))))
    return {"mean": max(way.mean() for way in ways), "largest": max(way.max() for way in ways)}


def changed(
    few: sparsurf.SurfaceAtoms, spheres: Spheres, shares: Sequence[float], probes: Sequence[float]
) -> Iterator[dict]:
    """Yield what becomes of the surface: larger probes, no plugs, and all atoms but those that the probe touches least."""
    chosen = few.centres, few.radii
    for probe in probes:
        ways = [largest_distance(a, b, probe) for a, b in ((chosen, spheres), (spheres, chosen))]
        areas = [float(sparsurf.surface(each, probe_radius=probe).area.sum()) for each in (chosen, spheres)]
        yield {
            "change": f"probe of {probe:g} Å",
            "kept": len(few),
            "largest": max(ways),
            "area_ratio": areas[0] / areas[1],
        }
    dots = sparsurf.surface(few)
    area = np.bincount(dots.atom, dots.area, len(spheres[1]))[few.atom]
    least = few.atom[np.argsort(np.where(few.touched, area, np.inf), kind="stable")]
    for share in shares:
        left = np.delete(np.arange(len(spheres[1])), least[: round(share / 100 * few.touched.sum())])
        found = errors((spheres[0][left], spheres[1][left]), spheres)
        yield {"change": f"{share:g} % of the touched atoms left out", "kept": len(left)} | found
    touched = few[few.touched]
    yield {"change": "no plugs", "kept": len(touched)} | errors((touched.centres, touched.radii), spheres)


def with_other_radii(molecule: sparsurf.Molecule, few: sparsurf.SurfaceAtoms) -> dict[str, float]:
    """Return what becomes of the surface if the atoms get the radii of Bondi."""
    radii = radii_of(molecule, "bondi")
    areas = [
        float(sparsurf.surface((xyz, r)).area.sum())
        for xyz, r in ((few.centres, radii[few.atom]), (molecule.xyz[0].round(3), radii))
    ]
    return {"change": "radii of Bondi", "kept": len(few), "area_ratio": areas[0] / areas[1]}


def mesh_of_error(spheres: Spheres, area: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Return the coarsest decimated mesh with the requested mean error, and its error, Å."""
    fine = molecular_mesh(*spheres, size=MeshSize(step=0.3), cavities="keep")
    rolled, rng = roll_spheres(*spheres, PROBE_RADIUS), np.random.default_rng(1)

    def attempt(density: float) -> tuple[np.ndarray, np.ndarray, float]:
        corners, triangles = rebuilding.simplify(
            fine.vertices.points, fine.triangles, round(2 * density * area)
        )
        return corners, triangles, mesh_error(corners, triangles, rolled, rng)

    low, high = np.log(FEWEST), np.log(MOST)
    best = attempt(MOST)
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        made = attempt(float(np.exp(middle)))
        if made[2] <= REQUESTED:
            high, best = middle, made
        else:
            low = middle
    return best


def mesh_error(
    corners: np.ndarray, triangles: np.ndarray, rolled: RolledFrame, rng: np.random.Generator
) -> float:
    """Return the mean distance of dots on triangles from the true surface, Å."""
    points, _ = dots_on(corners, triangles, rng, TEST_DENSITY)
    return float(np.abs(exact_distance(points, rolled)).mean())


def stored(molecule: sparsurf.Molecule, spheres: Spheres) -> Iterator[dict]:
    """Yield ways to store a surface: floats and bytes for each Å^2, and the errors of what is read again, Å."""
    few, area = sparsurf.surface_atoms(spheres), float(sparsurf.surface(spheres).area.sum())
    n_bits = 3 * BITS + int(np.ceil(np.log2(len(np.unique(spheres[1])))))

    def row(way: str, n: int, numbers: int, n_bytes: float, found: Mapping[str, float]) -> dict:
        return {"way": way, "n": n, "floats": numbers * n / area, "bytes": n_bytes / area} | found

    for way, n in (("surface atoms", len(few)), ("all atoms", len(spheres[1]))):
        yield row(way, n, NUMBERS_OF_AN_ATOM, FLOAT * NUMBERS_OF_AN_ATOM * n, {"mean": 0.0, "largest": 0.0})
    coarse, step = rounded(spheres)
    again = sparsurf.surface_atoms(coarse)
    for way, atoms in (
        ("surface atoms, rounded", (again.centres, again.radii)),
        ("all atoms, rounded", coarse),
    ):
        n = len(atoms[1])
        found = errors(atoms, spheres) | {"step": step, "more_plugs": n - len(few) if n == len(again) else 0}
        yield row(way, n, NUMBERS_OF_AN_ATOM, n_bits * n / 8, found)
    dots = sparsurf.minimal(molecule, error=REQUESTED)
    found = dots.measure_errors().iloc[0]
    found = {"mean": found["mean"], "largest": found["largest"]}
    yield row("dots of minimal", len(dots), NUMBERS_OF_A_DOT, FLOAT * NUMBERS_OF_A_DOT * len(dots), found)
    if not rebuilding.installed():
        return
    corners, triangles, error = mesh_of_error(spheres, area)
    size = VERTEX * len(corners) + TRIANGLE * len(triangles)
    yield row("decimated mesh", len(corners), 3, size, {"mean": error})
    if find_spec("DracoPy"):
        import DracoPy

        code = DracoPy.encode(corners, triangles, quantization_bits=DRACO_BITS, compression_level=10)
        read = DracoPy.decode(code)
        rolled, rng = roll_spheres(*spheres, PROBE_RADIUS), np.random.default_rng(1)
        error = mesh_error(np.asarray(read.points, float), np.asarray(read.faces, int), rolled, rng)
        yield row("the same by Draco", len(corners), 3, len(code), {"mean": error})


def measure_stored_atoms(job: Job) -> None:
    """Measure what becomes of the surface of few atoms where something changes, and ways to store a surface."""
    changes, ways, params = [], [], job.params
    progress = reporter("Stored atoms", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = sparsurf.read_molecule(path)
        spheres = molecule.xyz[0].round(3), radii_of(molecule)
        few = sparsurf.surface_atoms(molecule)
        found = [*changed(few, spheres, params.left_out, params.larger), with_other_radii(molecule, few)]
        changes += [{"structure": name} | row for row in found]
        ways += [{"structure": name} | row for row in stored(molecule, spheres)]
        progress(k, len(params.structures))
    for rows, by, output, means in (
        (changes, "change", job.output.changes, job.output.changes_means),
        (ways, "way", job.output.ways, job.output.ways_means),
    ):
        table = pd.DataFrame(rows)
        table.to_csv(output, index=False, float_format="%.8g")
        numbers = table.drop(columns="structure").groupby(by, sort=False)
        summary = (
            numbers.mean().join(numbers.max(), rsuffix="_highest").join(numbers.min(), rsuffix="_lowest")
        )
        summary.insert(0, "structures", numbers.size())
        summary.reset_index().to_csv(means, index=False, float_format="%.8g")
