"""Measure speed, memory and growth: `python evidence/bench.py [--quick] [--base COMMIT] [--out FILE]`.

Figures are medians over several runs: CPU seconds on one core with BLAS at one thread, and wall time. They are measured on
A1 of the paper (20045 dots; without its file, on the embedded structure) and on A1 repeated on a lattice. Peak memory, large
molecules, commands and the default study are measured in processes of their own. `at_most` is what the project promises on a
machine of 2 cores. With a base, a commit or the folder of another checkout, its bench measures the same figures in the same
hour, this one runs its commands and its default study, and each figure is printed as a ratio to it. Other programs are
measured where they are installed. Beside FILE, for the bench of another checkout, it writes bench.csv and growth.csv: how
time, memory and files grow with the atoms of a molecule, the structures of a study and the frames of a trajectory.
"""

import argparse
import importlib
import json
import os
import resource
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from functools import partial
from pathlib import Path
from types import ModuleType
from typing import Any

import mdtraj
import numpy as np
import pandas as pd
import yaml
from threadpoolctl import threadpool_limits

from measures.memory import peak_memory
from measures.points import msms_program
from sparsurf.api.frames import frames as areas_of_frames
from sparsurf.api.points import points
from sparsurf.api.show import show
from sparsurf.api.surfaces import mesh
from sparsurf.api.surfaces import surface as placed_surface
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches import descriptors
from sparsurf.patches.index import build_index
from sparsurf.patches.readings import GRID_READINGS
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.patches.zernike import published
from sparsurf.patches.zernike.polynomials import DISC, N_MAX, PIXELS
from sparsurf.sampling import published as published_sampling
from sparsurf.sampling.farthest_point import farthest_point_sampling
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import density_for_d_link, molecular_surface
from sparsurf.surfaces.radii import PROBE_RADIUS, radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import DENSITY, Surface
from sparsurf.threads import available_cores
from sparsurf_study.analysis import grid
from sparsurf_study.analysis.ensemble import frame_row
from sparsurf_study.config.check import check_config
from sparsurf_study.pairs.nearest import nearest
from sparsurf_study.settings import StudySettings

ROOT = Path(__file__).resolve().parents[1]
SHARED = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared"))
A1_DOTS = SHARED / "data" / "tdp43" / "A1.dms.gz"
RIBOSOME = SHARED / "data" / "structures" / "6zu5_ribosome.cif.gz"
EMBEDDED = ROOT / "data" / "tdp43" / "topology.pdb"  # 953 atoms
TRAJECTORY = EMBEDDED.with_name("trajectory.xtc")
GAP = 10.0  # Å between the copies on the lattice, so that no patch contains dots of two
COPIES = (1, 10, 50)  # of A1: 20 thousand, 200 thousand and a million dots
FARTHEST = ((1, 1024), (10, 1024), (32, 512), (10, 22_335))  # copies of A1, number of farthest dots
QUICK_RESIDUES = "209-214"  # residues of the quick surface
N_POINTS = 1024
SMALL_GRID, LAST_STEP = ([0.4, 0.8, 1.0], [0.0, 0.4], [0, 4, 8], [0, 6]), "grid of 36, 400 test dots"
FULL_GRID = ([0.1, 0.2, 0.4, 0.6, 0.8, 1.0], [0.0, 0.2, 0.4, 0.6, 0.8, 1.0], range(0, 11, 2), range(0, 11, 2))
BEST_COMBINATION = np.array([[1.0, 0.0, 6.0, 0.0]])  # the paper's best combination
COMMANDS = (
    "surface {} -o dots.npz",
    "areas {} -o areas.csv",
    "residues {} -o residues.csv",
    "atoms {} -o atoms.xyzr",
    "points {} -n 512 -o points.npz",
    "regions {} --field hydropathy --above 1 -o regions.csv",
    "roughness {} -o roughness.npz",
    "minimal {} --percent 10 -o minimal.npz",
    "show {} -o page.html --no-open",
)
TIMED_COPIES = (1, 4, 63, 336)  # of the embedded structure: 953, 4,000, 60,000 and 320,000 atoms
# 500 to 11,400 atoms
SIZES_OF_MESH, DENSITY_OF_MESH = (("209-240", 1), (None, 1), (None, 2), (None, 4), (None, 12)), 3.0
SIZES_OF_DENSITY = (("209-247", 1), (None, 4), (None, 16))  # residues and copies: 600, 4,000 and 15,000 atoms
# What grows: molecules by residues and copies, structures of a study, frames of a trajectory
MOLECULES = (("209-240", 1), (None, 1), (None, 4), (None, 16), (None, 64))  # 500 to 61,000 atoms
SHELL_ATOMS, SHELL_RADIUS = 58_440, 130.0  # Å, of a hollow ball, whose mesh takes the most memory
# Of a checkout, on the spheres of a file: prints CPU seconds of `surface` and `minimal`, or of `mesh`, and the peak memory
ANSWERS = """
import sys, time
import numpy as np
import sparsurf
from measures.memory import peak_memory
spheres, repeats = tuple(np.load(sys.argv[1]).values()), int(sys.argv[2])
def seconds(run, repeats):
    spent = []
    for _ in range(repeats):
        begin = time.process_time()
        run()
        spent.append(time.process_time() - begin)
    return sorted(spent)[len(spent) // 2]
few = tuple(part[:300] for part in spheres)  # in vain: compiles or loads the kernels
if sys.argv[3] == "mesh":
    sparsurf.mesh(few, density=0.5)
    spent = seconds(lambda: sparsurf.mesh(spheres, density=0.5), 1), np.nan
else:
    sparsurf.minimal(sparsurf.surface(few), error=0.02)
    dots = sparsurf.surface(spheres)
    spent = [seconds(run, repeats) for run in (
        lambda: sparsurf.surface(spheres), lambda: sparsurf.minimal(dots, error=0.02))]
print(*spent, peak_memory())
"""
STRUCTURES, FRAMES = (1, 10, 100, 1000, 5000), (100, 1000, 10_000)
MAX_PAGES = 100  # structures at most that are planned with pages of their own

# What is promised, in the unit of the figure
MAX_ROUGHNESS, MAX_SAMPLING = 0.15, 0.3
MAX_EVERY_DOT = {"`kept`": 1.0, "both readings": 2.0}
MAX_DESCRIPTOR, MAX_ROBUST = {0.05: 8, 0.2: 15, 0.5: 15, 1.0: 15}, 60  # by the share of kept dots
MAX_GRID = {100: 4, 1000: 25}  # by the test dots of the full grid
MAX_PAIR = {720: None, 14_400: 8, 50_000: 120}  # by the dots of each partner
MAX_FRAME = 0.25  # one frame of an ensemble of 953 atoms
MAX_PAGE_OF_FRAMES = 20  # of 91 frames of 953 atoms
MAX_MESH = 1.5  # over the process of MSMS, which also reads and writes files
MAX_READ_POINTS, MAX_POINTS = 1.5, 1.8  # points over their surface, with and without reading
MAX_GROWTH = 1.1  # cost of an atom over that in a molecule of 4,000 atoms
MAX_MINIMAL = 12  # `minimal` over the surface of the molecule: it infers the atoms, places their dots, and measures both ways
MAX_DEFAULT_DENSITY = 1.2  # dots of the default density over those of the same density by hand
MAX_MEMORY, MAX_NOTHING = 400, 5


class Table:
    """Figures, printed as they are measured.

    Attributes
    ----------
    rows : list of dict: what, dots, value (CPU seconds or what `unit` says), wall (the same of the wall clock), unit, at_most
        (what the project promises); None where there is none
    """

    def __init__(self, repeats: int) -> None:
        self.rows: list[dict[str, Any]] = []
        self.repeats = repeats

    def add(
        self, what: str, dots: int | None, value: float, unit: str,
        wall: float | None = None, most: float | None = None,
    ) -> float:  # fmt: skip
        """Add a row to the table, print it, and return its value."""
        row = {"what": what, "dots": dots, "value": value, "wall": wall, "unit": unit, "at_most": most}
        self.rows.append(row)
        print(f"{value:9.3g} {unit:5} {what}" + (f", {dots} dots" if dots else ""), flush=True)
        return value

    def time(
        self, what: str, dots: int | None, run: Callable, unit: str = "s", per: float = 1.0, most: float | None = None,
        once: bool = False,
    ) -> float:  # fmt: skip
        """Return the median time of `run()` after one call for warm-up, in `unit`, of which `per` are a second."""
        cpu, wall = timed(run, 1 if once else self.repeats)
        return self.add(what, dots, cpu * per, unit, wall * per, most)


def timed(run: Callable, repeats: int = 1, warm: bool = True) -> tuple[float, float]:
    """Return median CPU and wall seconds of `run()`, with the processes that it starts, after a call in vain if `warm`."""
    times = []
    for _ in range(repeats + warm):
        cpu, wall = cpu_time(), time.perf_counter()
        run()
        times.append((cpu_time() - cpu, time.perf_counter() - wall))
    cpu, wall = (statistics.median(column) for column in zip(*times[warm:], strict=True))
    return cpu, wall


def cpu_time() -> float:
    """Return the CPU seconds of this process and of those that it has waited for."""
    children = resource.getrusage(resource.RUSAGE_CHILDREN)
    return time.process_time() + children.ru_utime + children.ru_stime


def process(*command: str | Path, **keys: Any) -> Callable[[], subprocess.CompletedProcess]:
    """Return a call that runs a command, as a study and a terminal do."""
    return partial(subprocess.run, [*map(str, command)], check=True, capture_output=True, text=True, **keys)


def embedded(residues: str | None = None, copies: int = 1) -> tuple[np.ndarray, np.ndarray]:
    """Return centres and radii of the atoms of the embedded structure, repeated on a lattice, Å."""
    molecule = read_molecule(EMBEDDED, residues=residues)
    return lattice(molecule.xyz[0], copies), np.tile(radii(molecule), copies)


def lattice(xyz: np.ndarray, copies: int) -> np.ndarray:
    """Return `xyz` (n, 3) repeated on a cubic lattice, (copies * n, 3)."""
    side = np.arange(int(np.ceil(copies ** (1 / 3))))
    cells = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 1, 3)[:copies]
    return (cells * (np.ptp(xyz, axis=0) + GAP) + xyz).reshape(-1, 3)


def a1(quick: bool) -> Surface:
    """Return the dots of A1 or, without its file, of the embedded structure; if quick, of a piece of that."""
    if quick:
        return molecular_surface(*embedded(QUICK_RESIDUES))
    return read_surface(A1_DOTS) if A1_DOTS.is_file() else molecular_surface(*embedded())


def repeated(surface: Surface, copies: int) -> Surface:
    """Return a surface repeated on a lattice."""
    return Surface(lattice(surface.points, copies), np.tile(surface.normals, (copies, 1)))


def measure_dots(table: Table, surface: Surface, promised: bool, n_tests: int) -> None:
    """Measure what scales with the dots: index, roughness, cover, sampling, descriptors of 64 subsets."""
    n, rng = len(surface), np.random.default_rng(0)
    index = build_index(surface.points, surface.normals)
    table.time("index", n, partial(build_index, surface.points, surface.normals))
    rough = roughness_of_patches(index)
    most = MAX_ROUGHNESS if promised else None
    table.time("roughness of all dots", n, partial(roughness_of_patches, index), most=most)
    table.time("cover", n, partial(published_sampling.build_cover, index, rough))
    prepared = PreparedSurface(surface, roughness=rough, streams=Streams(name="bench"))
    combinations = published_sampling.parameter_grid(*(FULL_GRID if promised else SMALL_GRID))

    def sample() -> None:
        for combination in combinations:
            published_sampling.sample_cover(prepared.cover, combination, rng)

    def pair() -> None:
        for combination in combinations:
            prepared.pair(combination, 0)

    per = 1e3 / len(combinations)
    table.time("one sampling", n, sample, "ms", per, MAX_SAMPLING if promised else None)
    table.time("one sampling and a uniform subset", n, pair, "ms", per)
    tests = rng.choice(n, min(n, n_tests), replace=False)
    kinds = (
        ("a descriptor", "published", tests, None),
        ("a rotation-robust descriptor", "rotation_robust", tests[: max(1, n_tests // 8)], MAX_ROBUST),
    )
    for share, limit in MAX_DESCRIPTOR.items():
        words = np.zeros(n, np.uint64)
        for bit in range(descriptors.MAX_SUBSETS):
            subset = published_sampling.uniform_subset(n, round(share * n), rng)
            descriptors.add_subset(words, index, subset, bit)
        for reading in GRID_READINGS:
            for name, descriptor, at, most in kinds:
                z_tot = prepared.with_descriptor(descriptor).describe(at)[0]
                run = partial(
                    descriptors.compare_descriptors, index, prepared.points[at], words, descriptors.MAX_SUBSETS,
                    (reading,), z_tot, descriptor=descriptor,
                )  # fmt: skip
                per = 1e6 / len(at) / descriptors.MAX_SUBSETS
                table.time(f"{name}, {share:.0%} kept, `{reading}`", n, run, "µs", per, most or limit)


def measure_grids(table: Table, surface: Surface, quick: bool) -> None:
    """Measure whole grids with one draw, one combination at every dot, and the nearest patches of two surfaces."""
    prepared, n = PreparedSurface(surface, streams=Streams(name="bench")), len(surface)
    combinations = published_sampling.parameter_grid(*FULL_GRID)[: 2 if quick else None]
    for n_tests, most in ({16: None} if quick else MAX_GRID).items():
        run = partial(grid.evaluate_grid, prepared, combinations, n_tests, 1, ("kept",))
        table.time(f"grid of {len(combinations)}, {n_tests} test dots", n, run, most=most)
    for readings, names in ((("kept",), "`kept`"), (GRID_READINGS, "both readings")):
        run = partial(grid.evaluate_grid, prepared, BEST_COMBINATION, n, 1, readings)
        table.time(f"a combination at every dot, {names}", n, run, most=MAX_EVERY_DOT[names])
    for n, most in ({500: None} if quick else MAX_PAIR).items():
        run = partial(nearest, *np.random.default_rng(0).random((2, n, 121)))
        table.time("nearest patches of two surfaces, both ways", n, run, most=most, once=n > 20_000)


def measure_frames(table: Table, quick: bool) -> None:
    """Measure one combination on frames of the embedded trajectory, as an ensemble evaluates each."""
    study = yaml.safe_load((ROOT / "config.yaml").read_text(encoding="utf-8"))
    settings = StudySettings.of(check_config(study, home=ROOT))
    residues = QUICK_RESIDUES if quick else None
    molecule = read_molecule(EMBEDDED, TRAJECTORY, residues=residues, stride=500 if quick else 100)
    atom_radii = radii(molecule)
    density = density_for_d_link(
        molecule.xyz[0], atom_radii, settings.surface, settings.patches.d_link, "bench"
    )
    surface = settings.surface.model_copy(update={"density": density})
    settings = settings.model_copy(update={"surface": surface})

    def frames() -> None:
        for k in range(molecule.n_frames):
            frame_row(molecule, k, atom_radii, settings, Streams(name="bench"))

    what, per = f"a frame of an ensemble, {molecule.n_atoms} atoms", 1 / molecule.n_frames
    table.time(what, None, frames, "s", per, None if quick else MAX_FRAME, once=True)
    stride = 500 if quick else 10
    read = partial(read_molecule, EMBEDDED, TRAJECTORY, stride=stride)
    loaded = mdtraj.load(str(TRAJECTORY), top=str(EMBEDDED))[::stride]
    what = f"of {len(loaded)} frames, {molecule.n_atoms} atoms"
    table.time(f"exact areas {what}", None, lambda: areas_of_frames(read(), only_areas=True), once=True)
    peer = partial(mdtraj.shrake_rupley, loaded, n_sphere_points=960, mode="residue")
    table.time(f"areas by mdtraj's 960 points an atom {what}", None, peer, once=True)
    if not quick:
        page = partial(show, EMBEDDED, trajectory=TRAJECTORY, open_browser=False)
        table.time("the page of a trajectory, of 91 frames", None, page, most=MAX_PAGE_OF_FRAMES, once=True)


def measure_surfaces(table: Table, quick: bool) -> None:
    """Measure surfaces of larger and larger molecules, and of the default density, and points and meshes beside them."""
    residues = QUICK_RESIDUES if quick else None
    read = partial(read_molecule, EMBEDDED, residues=residues)
    what = "reading a structure and placing its dots"
    placing = table.time(what, None, lambda: molecular_surface(*embedded(residues)))
    choosing = table.time(f"{N_POINTS} points of a structure", None, lambda: points(read(), N_POINTS))
    most = None if quick else MAX_READ_POINTS
    table.add("ratio, points to reading and placing", None, choosing / placing, "times", most=most)
    table.time(f"a mesh of {N_POINTS} vertices", None, partial(mesh, molecule := read(), N_POINTS))
    costs = []  # µs an atom
    for copies in TIMED_COPIES[: 2 if quick else None]:
        spheres, n = embedded(residues, copies), copies * molecule.n_atoms
        what, run = f"surface per atom, {n} atoms", partial(molecular_surface, *spheres)
        costs.append(table.time(what, len(run()), run, "µs", 1e6 / n, once=copies == TIMED_COPIES[-1]))
        if len(costs) == 2:
            spent = table.time(f"{N_POINTS} points, {n} atoms", None, partial(points, spheres, N_POINTS))
            most = None if quick else MAX_POINTS
            table.add("ratio, points to their surface", None, 1e6 * spent / n / costs[1], "times", most=most)
        elif len(costs) > 2:
            what = f"ratio, {n} atoms to {TIMED_COPIES[1] * molecule.n_atoms}"
            table.add(what, None, costs[-1] / costs[1], "times", most=MAX_GROWTH)
    for part, copies in SIZES_OF_DENSITY:
        spheres = embedded(part, copies)
        density = len(spread := placed_surface(spheres)) / spread.area.sum()
        default = timed(partial(placed_surface, spheres), table.repeats)[0]
        by_hand = timed(partial(placed_surface, spheres, density=density), table.repeats)[0]
        what = f"ratio, default density to the same by hand, {len(spheres[1])} atoms"
        table.add(what, None, default / by_hand, "times", most=MAX_DEFAULT_DENSITY)


def measure_commands(table: Table, tree: Path = ROOT, kernels: str | None = None) -> None:
    """Measure commands of a checkout on the embedded structure as whole processes, warm: CPU seconds and peak memory."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tree / "src"), str(ROOT / "evidence")])}
    environment |= {"NUMBA_CACHE_DIR": kernels} if kernels else {}
    code = "import runpy\nfrom measures.memory import peak_memory\ntry:\n    runpy.run_module('sparsurf', None, '__main__')\n"
    code += "except SystemExit:\n    print(peak_memory())"
    with tempfile.TemporaryDirectory() as folder:
        for command in COMMANDS:
            arguments = [*command.format(EMBEDDED).split(), "-q"]
            place = {"cwd": folder, "env": environment}
            cpu, wall = timed(process(sys.executable, "-m", "sparsurf", *arguments, **place), table.repeats)
            name = f"`sparsurf {command.format('FILE').partition(' -o')[0]}`"
            table.add(f"{name}, a warm process", None, cpu, "s", wall)
            memory = process(sys.executable, "-c", code, *arguments, **place)().stdout.split()[-1]
            table.add(f"{name}, peak memory", None, float(memory) / 1e6, "MB")


def measure_answers(table: Table, quick: bool, tree: Path = ROOT, kernels: str | None = None) -> None:
    """Measure in a checkout what `minimal` costs over `surface` as molecules grow, a mesh of a shell, and the start of a shim."""
    environment = os.environ | {"PYTHONPATH": os.pathsep.join([str(tree / "src"), str(ROOT / "evidence")])}
    environment |= {"NUMBA_CACHE_DIR": kernels} if kernels else {}
    with tempfile.TemporaryDirectory() as folder:

        def answer(xyz: np.ndarray, sizes: np.ndarray, repeats: int, kind: str) -> list[float]:
            np.savez(Path(folder, "spheres.npz"), xyz, sizes)
            command = [sys.executable, "-c", ANSWERS, "spheres.npz", str(repeats), kind]
            return [*map(float, process(*command, cwd=folder, env=environment)().stdout.split()[-3:])]

        for residues, copies in MOLECULES[: 2 if quick else None]:
            spheres = embedded(residues, copies)
            n, repeats = len(spheres[1]), 1 if copies == MOLECULES[-1][1] else table.repeats
            placing, choosing, memory = answer(*spheres, repeats, "minimal")
            table.add(f"surface, {n} atoms", None, placing, "s")
            table.add(f"minimal, {n} atoms", None, choosing, "s")
            most = None if quick else MAX_MINIMAL
            table.add(f"ratio, minimal to surface, {n} atoms", None, choosing / placing, "times", most=most)
            table.add(f"minimal, peak memory, {n} atoms", None, memory / 1e6, "MB")
        n = 600 if quick else SHELL_ATOMS
        height, turn = 1 - (2 * np.arange(n) + 1) / n, np.pi * (1 + 5**0.5) * np.arange(n)
        across = np.sqrt(1 - height**2)
        unit = np.stack([across * np.cos(turn), across * np.sin(turn), height], axis=1)
        spent, _, memory = answer(SHELL_RADIUS * (n / SHELL_ATOMS) ** 0.5 * unit, np.full(n, 1.7), 1, "mesh")
        table.add(f"mesh of a shell, {n} atoms", None, spent, "s")
        table.add(f"mesh of a shell, {n} atoms, peak memory", None, memory / 1e6, "MB")
        xyz, sizes = embedded()
        np.savetxt(Path(folder, "p.xyzr"), np.column_stack([xyz, sizes]), "%.3f")
        shim = "import sys; from sparsurf.cli.msms import main; sys.exit(main(sys.argv[1:]))"
        arguments = ["-c", shim, "-if", "p.xyzr", "-of", "p"]
        cpu, wall = timed(process(sys.executable, *arguments, cwd=folder, env=environment), table.repeats)
        table.add("`sparsurf-msms`, a warm process", None, cpu, "s", wall)


def measure_study(table: Table, tree: Path = ROOT) -> None:
    """Measure the default study of a checkout from the start, and again with nothing to do.

    Its kernels are compiled before: in this checkout by `make setup`, in another one by a run in vain.
    """
    with tempfile.TemporaryDirectory() as folder:
        for run in ("study",) if tree == ROOT else ("in vain", "study"):
            place = Path(folder, run)
            place.mkdir()
            (place / "data").symlink_to(tree / "data")
            study = snakemake(tree / "config.yaml", place, "--cores", "all", "--quiet", "all", tree=tree)
            cpu, wall = timed(study, warm=False)
        table.add("default study", None, cpu, "s", wall)
        cpu, wall = timed(study, warm=False)
        table.add("default study, nothing to do", None, cpu, "s", wall, MAX_NOTHING)


def snakemake(config: Path, folder: Path, *options: str, tree: Path = ROOT) -> Callable:
    """Return a call that runs Snakemake with a config in a folder."""
    files = ["--snakefile", tree / "Snakefile", "--configfile", config, "--directory", folder]
    return process(sys.executable, "-m", "snakemake", *files, *options)


def measure_peers(table: Table, surface: Surface) -> list[str]:
    """Measure other programs on the same work, ours, and the ratio of theirs to ours; return those that are missing."""
    xyz, r = embedded()
    missing, placing = [], partial(molecular_surface, xyz, r)

    def installed(name: str) -> ModuleType | None:
        try:
            return importlib.import_module(name)
        except ImportError:
            missing.append(name.partition(".")[0])
            return None

    def compare(name: str, theirs: float, what: str, ours: Callable, dots: int | None = None, **unit: Any) -> None:  # fmt: skip
        table.add(f"ratio, {name} to this", dots, theirs / table.time(what, dots, ours, **unit), "times")

    with tempfile.TemporaryDirectory() as folder:
        spheres, out = Path(folder, "spheres.xyzr"), Path(folder, "out")
        np.savetxt(spheres, np.column_stack([xyz, r]), "%.3f")
        programs = {
            "EDTSurf": (shutil.which("EDTSurf"), "-i", EMBEDDED, "-o", out),
            "MSMS": (msms_program(), "-if", spheres, "-of", out, "-density", DENSITY),
        }
        for name, (program, *options) in programs.items():
            if program is None:
                missing.append(name)
                continue
            what = f"peer: surface of the embedded structure by {name}, a process"
            theirs = table.time(what, None, process(program, *options))
            compare(name, theirs, "the same surface here", placing)
    areas: dict[str, Callable] = {}
    if freesasa := installed("freesasa"):
        areas["freesasa"] = partial(freesasa.calcCoord, xyz.ravel(), r)
    if structure := installed("biotite.structure"):
        atoms = structure.AtomArray(len(xyz))
        atoms.coord = xyz
        areas["biotite"] = partial(structure.sasa, atoms, vdw_radii=r)
    for name, area in areas.items():
        theirs = table.time(f"peer: accessible area of the embedded structure by {name}", None, area)
        compare(name, theirs, "its molecular surface here", placing)
    if fpsample := installed("fpsample"):
        samplers = [partial(fpsample.bucket_fps_kdline_sampling, h=h) for h in (5, 7, 9)]
        for copies, n_s in FARTHEST:
            dots = repeated(surface, copies)
            n, index = len(dots), build_index(dots.points, dots.normals)
            runs = [partial(f, dots.points, n_s) for f in (fpsample.bucket_fps_kdtree_sampling, *samplers)]
            theirs = min(timed(run, table.repeats)[0] for run in runs)
            table.add(f"peer: {n_s} farthest dots by fpsample's best sampler", n, theirs, "s")
            ours = partial(farthest_point_sampling, index, n_s, np.random.default_rng(0))
            compare("fpsample", theirs, f"{n_s} farthest dots here", ours, n)
    image = np.random.default_rng(0).random((PIXELS, PIXELS))
    images = np.random.default_rng(0).random((512, published.N_EVEN + published.N_ODD))
    moments: dict[str, Callable] = {}
    if mahotas := installed("mahotas.features"):
        moments["mahotas"] = partial(mahotas.zernike_moments, image, DISC, N_MAX)
    if zepyros := installed("zepyros.zernike"):
        orders = [(order, m) for order in range(N_MAX + 1) for m in range(order % 2, order + 1, 2)]
        basis = zepyros.Zernike2D(image)
        moments["zepyros"] = lambda: [basis.compute_coeff_nm(image, *each) for each in orders]
    for name, run in moments.items():
        theirs = table.time(f"peer: moments of one image by {name}", None, run, "µs", 1e6)
        ours = partial(published.moments, images)
        compare(name, theirs, "the same here, 512 images", ours, unit="µs", per=1e6 / 512)
    return missing


def measure_meshes(table: Table, quick: bool) -> None:
    """Measure meshes with the walls of cavities on larger and larger molecules, and MSMS at the same density, as a process."""
    program = msms_program()
    with tempfile.TemporaryDirectory() as folder:
        path, out = Path(folder, "spheres.xyzr"), Path(folder, "out")
        for residues, copies in SIZES_OF_MESH[: 1 if quick else None]:
            spheres = embedded(residues, copies)
            what = f"{len(spheres[1])} atoms, {DENSITY_OF_MESH:g} vertices per Å^2"
            ours = table.time(
                f"mesh of {what}", None, partial(mesh, spheres, density=DENSITY_OF_MESH, cavities="keep")
            )
            if program is None:
                continue
            np.savetxt(path, np.column_stack(spheres), "%.3f")
            options = "-if", path, "-of", out, "-probe_radius", PROBE_RADIUS, "-all_components"
            densities = "-density", DENSITY_OF_MESH, "-hdensity", DENSITY_OF_MESH
            theirs = table.time(
                f"peer: mesh of {what}, by MSMS", None, process(program, *options, *densities)
            )
            most = None if quick else MAX_MESH
            table.add(f"ratio, mesh to that of MSMS, {what}", None, ours / theirs, "times", most=most)


def print_steps(source: str, residues: str | None = None, copies: int = 1) -> None:
    """Print, in a process of its own, what each step of a surface takes: CPU, wall and peak bytes above the imports.

    The source is A1, quick (a piece of it), the ribosome or the embedded structure, of which no grid is evaluated.
    """
    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    grid.evaluate_grid(PreparedSurface(dots), np.array([[0.5, 0.5, 1.0, 1.0]]), 4)  # loads every kernel
    one = a1(source == "quick") if source in ("A1", "quick") else None
    before, steps, cores = peak_memory(), {}, 1 if source == "embedded" else available_cores()

    def step(name: str, run: Callable) -> Any:
        cpu, wall = cpu_time(), time.perf_counter()
        result = run()
        steps[name] = (cpu_time() - cpu, time.perf_counter() - wall, peak_memory() - before)
        return result

    def read() -> tuple[np.ndarray, np.ndarray]:
        molecule = read_molecule(RIBOSOME, selection="all", whole=False)
        return molecule.xyz[0], radii(molecule)

    if one:
        surface = repeated(one, copies)
    else:
        spheres = step("reading", read) if source == "ribosome" else embedded(residues, copies)
        surface = step("surface", lambda: molecular_surface(*spheres))
    index = step("index", lambda: build_index(surface.points, surface.normals))
    rough = step("roughness", lambda: roughness_of_patches(index, threads=cores))
    if source != "embedded":
        prepared = PreparedSurface(surface, roughness=rough, threads=cores)
        step("cover", lambda: prepared.cover)
        combinations = published_sampling.parameter_grid(*SMALL_GRID)
        step(LAST_STEP, lambda: grid.evaluate_grid(prepared, combinations, 400))
    print(json.dumps({"atoms": 0 if one else len(spheres[0]), "dots": len(surface), "steps": steps}))


def steps_of(*source: Any) -> dict[str, Any]:
    """Return what `print_steps` prints in a fresh process."""
    call = process(sys.executable, "-c", f"import bench; bench.print_steps(*{source})", cwd=ROOT / "evidence")
    return json.loads(call().stdout)


def measure_growth(table: Table, quick: bool) -> list[dict[str, Any]]:
    """Return rows of what grows with the atoms of a molecule, the structures of a study and the frames of a trajectory."""
    rows: list[dict[str, Any]] = []
    sources = [("embedded", *size) for size in MOLECULES[: 2 if quick else None]]
    for source in sources + ([("ribosome",)] if RIBOSOME.is_file() and not quick else []):
        atoms, dots, steps = steps_of(*source).values()
        spent = {"surface": steps["surface"][0], "roughness": steps["index"][0] + steps["roughness"][0]}
        row = {"grows": "atoms of a molecule", "n": atoms, "dots": dots}
        row |= {f"{step}_us_a_dot": 1e6 * seconds / dots for step, seconds in spent.items()}
        rows.append(row | {"bytes_a_dot": steps["roughness"][2] / dots})
        if source == ("ribosome",):
            for name, (cpu, wall, _) in steps.items():
                table.add(f"ribosome of {atoms} atoms: {name}", dots, cpu, "s", wall)
            table.add("ribosome: peak memory", dots, steps[LAST_STEP][2] / dots, "bytes per dot")
    planned({"proteins": {"p": {"structure": str(EMBEDDED)}}})  # in vain: the first start compiles modules
    for n in STRUCTURES[: 2 if quick else None]:
        study = {"proteins": {f"p{k:05d}": {"structure": str(EMBEDDED)} for k in range(n)}}
        rows.append({"grows": "structures in batches", "n": n} | planned(study | {"pages": []}))
        if n <= MAX_PAGES:
            row = {"grows": "structures with pages of their own", "n": n}
            rows.append(row | planned(study | {"pages": [*study["proteins"]]}))
    protein = {"structure": str(EMBEDDED), "trajectory": str(TRAJECTORY)}
    plan = planned({"ensemble": {"run": True}, "proteins": {"p": protein}})
    one = mdtraj.load(str(TRAJECTORY), top=str(EMBEDDED))
    for n in FRAMES[: 1 if quick else None]:
        with tempfile.TemporaryDirectory() as folder:
            long = Path(folder, "long.xtc")
            with mdtraj.formats.XTCTrajectoryFile(str(long), "w") as file:
                for begin in range(0, n, len(one)):
                    file.write(one.xyz[: n - begin], step=np.arange(begin, min(begin + len(one), n)))
            seconds = timed(partial(read_molecule, EMBEDDED, long), warm=False)[0]
        row = {"grows": "frames of a trajectory", "n": n, "reading_s": seconds}
        rows.append(row | {"kB_a_frame": read_molecule(EMBEDDED, TRAJECTORY).xyz[0].nbytes / 1000} | plan)
    return rows


def planned(config: dict[str, Any]) -> dict[str, float]:
    """Return CPU seconds and files of planning a study, of which nothing is run."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder, "config.yaml")
        path.write_text(yaml.safe_dump({"run": "growth", "sampling": False} | config), encoding="utf-8")
        before = cpu_time()
        plan = snakemake(path, Path(folder), "--cores", "1", "--nolock", "--summary")()
        return {"planning_s": cpu_time() - before, "files": len(plan.stdout.splitlines()) - 1}


def main(out: str | Path, quick: bool = False, base: str | None = None) -> None:
    """Measure, print and write the tables, and the JSON file that the bench of another checkout reads."""
    if base and not Path(base).is_dir():
        git("cat-file", "-e", f"{base}^{{commit}}")
    table, surface, copies = Table(1 if quick else 3), a1(quick), (1,) if quick else COPIES
    with threadpool_limits(1, "blas"):
        for c in copies:
            measure_dots(table, repeated(surface, c), c == 1 and not quick, 16 if quick else 512)
        measure_grids(table, surface, quick)
        measure_frames(table, quick)
        measure_surfaces(table, quick)
        measure_meshes(table, quick)
        measure_commands(table)
        measure_answers(table, quick)
        missing = measure_peers(table, surface)
    _, dots, steps = steps_of("quick" if quick else "A1", None, copies[-1]).values()
    memory = steps[LAST_STEP][2] / dots
    most = None if quick else MAX_MEMORY
    table.add("peak memory above the imports", dots, memory, "bytes per dot", most=most)
    growth = measure_growth(table, quick)
    if not quick:
        measure_study(table)
    ratios = ratios_to(figures_of(base, quick), table.rows) if base else {}
    if base:
        print(f"\nTimes here divided by those of {base}, measured after them on this machine")
        print("\n".join(f"{ratio:6.2f}  {what}" for what, ratio in ratios.items()))
    print("\nNot installed, so not compared: " + (", ".join(missing) or "none"))
    missed = [row["what"] for row in table.rows if row["at_most"] and row["value"] > row["at_most"]]
    print("\nAbove what is promised: " + ("; ".join(missed) or "nothing"))
    path = Path(out)
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(
        json.dumps({"figures": table.rows, "base": base, "ratios": ratios}, indent=2), encoding="utf-8"
    )
    for name, rows, form in (("bench", table.rows, "%.3g"), ("growth", growth, "%.4g")):
        frame = pd.DataFrame(rows)
        frame.astype({"dots": "Int64"}).to_csv(path.with_name(f"{name}.csv"), index=False, float_format=form)


def git(*arguments: str | Path) -> None:
    """Run git in this checkout."""
    done = subprocess.run(["git", *map(str, arguments)], cwd=ROOT, capture_output=True, text=True)
    if done.returncode:
        raise InputError(
            f"git {' '.join(map(str, arguments))} failed ({done.stderr.strip()}): fetch the whole history "
            "(git fetch --unshallow), or compare with no commit (make bench BASE=)."
        )


@contextmanager
def tree_of(base: str) -> Iterator[Path]:
    """Yield the folder of another checkout, or a working tree of a commit, which is removed afterwards."""
    if Path(base).is_dir():
        yield Path(base).resolve()
        return
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder, "tree")
        git("worktree", "add", "--detach", tree, base)
        try:
            yield tree
        finally:
            git("worktree", "remove", "--force", tree)


def figures_of(base: str, quick: bool) -> list[dict[str, Any]]:
    """Return the figures of a base on this machine: its commands and study measured from here, and those of its own bench."""
    with tree_of(base) as tree, tempfile.TemporaryDirectory() as folder:
        kernels, out = str(Path(folder, "kernels")), Path(folder, "bench.json")
        table = Table(1 if quick else 3)
        measure_commands(table, tree, kernels)
        measure_answers(table, quick, tree, kernels)
        if not quick:
            measure_study(table, tree)
        places = {"PYTHONPATH": tree / "src", "NUMBA_CACHE_DIR": kernels, "SPARSURF_SHARED": SHARED}
        environment = os.environ | {name: str(place) for name, place in places.items()}
        options = [*(["--quick"] if quick else []), "--out", out]
        bench = [sys.executable, tree / "evidence" / "bench.py", *options]
        done = subprocess.run(bench, cwd=tree, env=environment, capture_output=True, text=True)
        if done.returncode:
            raise InputError(f"the bench of {base} failed: {done.stderr.strip().splitlines()[-1]}")
        return table.rows + json.loads(out.read_text(encoding="utf-8"))["figures"]


def ratios_to(base: Sequence[dict[str, Any]], rows: Sequence[dict[str, Any]]) -> dict[str, float]:
    """Divide figures by those of the base with the same name and number of dots."""
    before = {(row["what"], row["dots"]): row["value"] for row in reversed(base)}
    ratios: dict[str, float] = {}
    for row in rows:
        if row["value"] and (other := before.get((row["what"], row["dots"]))):
            dots = "" if row["dots"] is None else f", {row['dots']} dots"
            ratios.setdefault(row["what"] + dots, row["value"] / other)
    return ratios


def command(arguments: Sequence[str] | None = None) -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--quick", action="store_true", help="a small surface, once: to see that all runs")
    parser.add_argument(
        "--base", help="commit whose figures are measured, too, and by which these are divided"
    )
    parser.add_argument("--out", default=ROOT / "results" / "bench" / "bench.json", help="JSON file to write")
    args = parser.parse_args(arguments)
    try:
        main(args.out, args.quick, args.base)
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    command()
