"""Measure speed and memory: `python evidence/bench.py [--quick] [--base COMMIT] [--reference module:function] [--out FILE]`.

Figures are medians over several runs: CPU seconds on one core with BLAS at one thread, and wall time. They are measured on
A1 of the paper (20045 dots; without its file, on the embedded structure) and on A1 repeated on a lattice. Peak memory,
start-up, a ribosome and the default study are measured in processes of their own. `at most` is what the project
promises on a machine of 2 cores. With a base, a commit or the folder of another checkout, its bench measures the same figures
in the same hour, this one runs its commands and its default study, and each figure is printed as a ratio to it. Other programs
are measured where they are installed.
"""

import argparse
import importlib
import json
import math
import os
import shutil
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

import numpy as np
import yaml
from threadpoolctl import threadpool_limits

from measures.points import msms_program
from measures.timing import Table, machine, peak_memory, timed
from sparsurf.api.points import points
from sparsurf.api.surfaces import mesh
from sparsurf.api.surfaces import surface as placed_surface
from sparsurf.errors import InputError
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches import descriptors
from sparsurf.patches.index import R_ZERNIKE, build_index
from sparsurf.patches.islands import patch
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
from sparsurf_study.pairs.nearest import nearest
from sparsurf_study.settings import StudySettings
from sparsurf_study.workflow.config import check_config

ROOT = Path(__file__).resolve().parents[1]
SHARED = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared"))
A1_DOTS = SHARED / "data" / "tdp43" / "A1.dms.gz"
RIBOSOME = SHARED / "data" / "structures" / "6zu5_ribosome.cif.gz"
EMBEDDED = ROOT / "data" / "tdp43" / "topology.pdb"
TRAJECTORY = EMBEDDED.with_name("trajectory.xtc")
HIGH_DENSITY, N_POINTS = 25, 1024
MAX_SECONDS_PER_FRAME = 0.25  # s, one frame of an ensemble of 953 atoms
COPIES = (1, 10, 50)  # of A1: 20 thousand, 200 thousand and a million dots
DESCRIPTOR_LIMITS = {0.05: 8, 0.2: 15, 0.5: 15, 1.0: 15}  # kept dots: µs that a descriptor may take
MAX_MICROSECONDS_ROBUST = 60  # µs that a rotation-robust descriptor may take
SMALL_GRID = ([0.4, 0.8, 1.0], [0.0, 0.4], [0, 4, 8], [0, 6])  # a grid of 36 combinations
FULL_GRID = ([0.1, 0.2, 0.4, 0.6, 0.8, 1.0], [0.0, 0.2, 0.4, 0.6, 0.8, 1.0], range(0, 11, 2), range(0, 11, 2))
BEST_COMBINATION = np.array([[1.0, 0.0, 6.0, 0.0]])  # the paper's best combination
GRID_LIMITS = {100: 4, 1000: 25}  # test dots of the full grid: CPU seconds that it may take
QUICK_RESIDUES = "209-214"  # residues of the quick surface
GAP = 10.0  # Å between the copies on the lattice, so that no patch contains dots of two
REFERENCE_PATCHES = 5
COMMANDS = (
    "surface {} -o dots.npz",
    "points {} -n 512 -o points.npz",
    "roughness {} -o roughness.npz",
    "minimal {} --percent 10 -o minimal.npz",
    "show {} --no-open -o page.html",
)
# Copies of the embedded structure of 953 atoms whose cost an atom is compared: 4,000, 60,000 and 320,000 atoms
GROWTH, MAX_GROWTH = (4, 63, 336), 1.1
MAX_POINTS_PER_SURFACE = 1.8  # time of `points` over that of its surface
SIZES_OF_DENSITY = (("209-247", 1), (None, 4), (None, 16))  # residues and copies: 600, 4,000 and 15,000 atoms
MAX_DEFAULT_DENSITY = 1.2  # time of dots of the default density over that of the same density by hand
FARTHEST = ((1, 1024), (10, 1024), (32, 512), (10, 22_335))  # copies of A1, number of farthest dots
# By the number of dots of each partner, the CPU seconds that comparing them may take
PAIR_LIMITS = {720: None, 14_400: 8, 50_000: 120}


def embedded(residues: str | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Return centres and radii of the atoms of the embedded structure, Å."""
    molecule = read_molecule(EMBEDDED, residues=residues)
    return molecule.xyz[0], radii(molecule)


def a1(quick: bool) -> Surface:
    """Return the dots of A1 or, without its file, of the embedded structure; if quick, of a piece of that."""
    if quick:
        return molecular_surface(*embedded(QUICK_RESIDUES))
    return read_surface(A1_DOTS) if A1_DOTS.is_file() else molecular_surface(*embedded())


def lattice(xyz: np.ndarray, copies: int) -> np.ndarray:
    """Return `xyz` (n, 3) repeated on a cubic lattice, (copies * n, 3)."""
    side = np.arange(int(np.ceil(copies ** (1 / 3))))
    cells = np.stack(np.meshgrid(side, side, side, indexing="ij"), axis=-1).reshape(-1, 1, 3)[:copies]
    return (cells * (np.ptp(xyz, axis=0) + GAP) + xyz).reshape(-1, 3)


def repeated(surface: Surface, copies: int) -> Surface:
    """Return a surface repeated on a lattice."""
    return Surface(lattice(surface.points, copies), np.tile(surface.normals, (copies, 1)))


def measure_dots(
    table: Table, surface: Surface, promised: bool, repeats: int, n_tests: int, combinations: np.ndarray
) -> None:
    """Measure what scales with the dots: index, roughness, cover, sampling, descriptors of 64 subsets."""
    n = len(surface)
    index = build_index(surface.points, surface.normals)
    table.time("index", n, lambda: build_index(surface.points, surface.normals), repeats)
    rough = roughness_of_patches(index)
    most = 0.15 if promised else None
    seconds = table.time("roughness of all dots", n, lambda: roughness_of_patches(index), repeats, most=most)
    table.add("roughness per dot", n, 1e6 * seconds / n, "µs")
    table.time("cover", n, lambda: published_sampling.build_cover(index, rough), repeats)
    prepared = PreparedSurface(surface, roughness=rough, streams=Streams(name="bench"))
    rng = np.random.default_rng(0)

    def sample() -> None:
        for combination in combinations:
            published_sampling.sample_cover(prepared.cover, combination, rng)

    def pair() -> None:
        for combination in combinations:
            prepared.pair(combination, 0)

    per, most = 1e3 / len(combinations), 0.3 if promised else None
    milliseconds = table.time("one sampling", n, sample, repeats, "ms", per, most)
    table.add("one sampling per dot", n, 1e6 * milliseconds / n, "ns")
    table.time("one sampling and a uniform subset", n, pair, repeats, "ms", per)
    measure_descriptors(table, prepared, rng, repeats, n_tests)


def measure_descriptors(
    table: Table, prepared: PreparedSurface, rng: np.random.Generator, repeats: int, n_tests: int
) -> None:
    """Measure descriptors of 64 subsets at shared test dots, as the grid evaluates them."""
    index, n = prepared.index, len(prepared.points)
    tests = rng.choice(n, min(n, n_tests), replace=False)
    subset = tests[: max(1, n_tests // 8)]
    z_tot, robust = (
        prepared.describe(tests)[0],
        prepared.with_descriptor("rotation_robust").describe(subset)[0],
    )
    for share, most in DESCRIPTOR_LIMITS.items():
        words = np.zeros(n, np.uint64)
        for bit in range(descriptors.MAX_SUBSETS):
            descriptors.add_subset(
                words, index, published_sampling.uniform_subset(n, round(share * n), rng), bit
            )
        for reading in GRID_READINGS:
            asked = words, descriptors.MAX_SUBSETS, (reading,)
            run = partial(descriptors.compare_descriptors, index, prepared.points[tests], *asked, z_tot)
            what, per = (
                f"a descriptor, {share:.0%} kept, `{reading}`",
                1e6 / len(tests) / descriptors.MAX_SUBSETS,
            )
            table.time(what, n, run, repeats, "µs", per, most)
            run = partial(
                descriptors.compare_descriptors,
                index,
                prepared.points[subset],
                *asked,
                robust,
                descriptor="rotation_robust",
            )
            what, per = (
                what.replace("a descriptor", "a rotation-robust descriptor"),
                1e6 / len(subset) / descriptors.MAX_SUBSETS,
            )
            table.time(what, n, run, repeats, "µs", per, MAX_MICROSECONDS_ROBUST)


def measure_pairs(table: Table, sizes: dict[int, float | None], repeats: int) -> None:
    """Measure the search for the nearest patch of every dot of two surfaces, in both directions, on random descriptors."""
    rng = np.random.default_rng(0)
    for n, most in sizes.items():
        both = rng.random((2, n, 121))
        times = repeats if n < 20_000 else 1
        table.time("nearest patches of two surfaces, both ways", n, partial(nearest, *both), times, most=most)


def measure_grids(
    table: Table, surface: Surface, combinations: np.ndarray, limits: dict[int, float | None], repeats: int
) -> None:
    """Measure whole grids with one draw, reading `kept`, and one combination at every dot."""
    prepared, n = PreparedSurface(surface, streams=Streams(name="bench")), len(surface)
    for n_tests, most in limits.items():
        what = f"grid of {len(combinations)}, {n_tests} test dots"
        run = partial(grid.evaluate_grid, prepared, combinations, n_tests, 1, ("kept",))
        table.time(what, n, run, repeats, most=most)
    for readings, names in ((("kept",), "`kept`"), (GRID_READINGS, "both readings")):
        run = partial(grid.evaluate_grid, prepared, BEST_COMBINATION, n, 1, readings)
        table.time(f"a combination at every dot, {names}", n, run, repeats, most=1)


def measure_surface(table: Table, copies: Sequence[int], repeats: int, residues: str | None = None) -> None:
    """Measure the surface of the embedded structure, repeated."""
    xyz, r = embedded(residues)
    for c in copies:
        run = partial(molecular_surface, lattice(xyz, c), np.tile(r, c))
        what, per = f"surface per atom, {c * len(r)} atoms", 1e6 / (c * len(r))
        table.time(what, len(run()), run, repeats, "µs", per)


def measure_frames(table: Table, quick: bool) -> None:
    """Measure one combination on frames of the embedded trajectory, as an ensemble evaluates each."""
    study = yaml.safe_load((ROOT / "config.yaml").read_text(encoding="utf-8"))
    settings = StudySettings.of(check_config(study, home=ROOT))
    residues = QUICK_RESIDUES if quick else None
    molecule = read_molecule(EMBEDDED, TRAJECTORY, residues=residues, stride=500 if quick else 100)
    atom_radii = radii(molecule)
    density = density_for_d_link(molecule, 0, atom_radii, settings.surface, settings.patches.d_link, "bench")
    surface = settings.surface.model_copy(update={"density": density})
    settings = settings.model_copy(update={"surface": surface})

    def frames() -> None:
        for k in range(molecule.n_frames):
            frame_row(molecule, k, atom_radii, settings, Streams(name="bench"))

    what, most = f"a frame of an ensemble, {molecule.n_atoms} atoms", None if quick else MAX_SECONDS_PER_FRAME
    table.time(what, None, frames, 1, "s", 1 / molecule.n_frames, most)


def measure_points(table: Table, repeats: int, residues: str | None = None) -> None:
    """Measure points of the embedded structure as multiples of reading it and placing its dots once, and their peers.

    The roughness of its dots at a high density, a coarse mesh and a start of the command follow.
    """

    def place() -> Surface:
        return molecular_surface(*embedded(residues))

    molecule = read_molecule(EMBEDDED, residues=residues)
    dense = molecular_surface(molecule.xyz[0], radii(molecule), density=HIGH_DENSITY)
    placing = table.time("reading a structure and placing its dots", len(place()), place, repeats)

    def choose() -> None:
        points(read_molecule(EMBEDDED, residues=residues), N_POINTS)

    ratio = table.time(f"{N_POINTS} points of a structure", None, choose, repeats) / placing
    table.add("ratio, points to reading and placing", None, ratio, "times", most=None if residues else 1.5)
    index, n = build_index(dense.points, dense.normals), len(dense)
    what = f"roughness per dot, {HIGH_DENSITY} dots per Å^2"
    table.time(what, n, partial(roughness_of_patches, index), repeats, "µs", 1e6 / n)
    table.time(f"a mesh of {N_POINTS} vertices", None, partial(mesh, molecule, N_POINTS), repeats)


def measure_processes(table: Table, repeats: int, tree: Path = ROOT, kernels: str | None = None) -> None:
    """Measure commands of a checkout on the embedded structure as whole processes, warm: CPU seconds and peak memory."""
    environment = os.environ | {"PYTHONPATH": str(tree / "src")}
    environment |= {"NUMBA_CACHE_DIR": kernels} if kernels else {}
    with tempfile.TemporaryDirectory() as folder:
        for command in COMMANDS:
            call = [sys.executable, "-m", "sparsurf", *command.format(EMBEDDED).split(), "-q"]
            subprocess.run(call, check=True, capture_output=True, cwd=folder, env=environment)  # may compile
            cpu, wall = cpu_of_process(call, repeats, cwd=folder, env=environment)
            name = f"`sparsurf {command.format('FILE').partition(' -o')[0]}`"
            table.add(f"{name}, a warm process", None, cpu, "s", wall)
            code = "import runpy, sys\nfrom measures.timing import peak_memory\ntry:\n    runpy.run_module('sparsurf', "
            code += "run_name='__main__')\nexcept SystemExit:\n    sys.exit(str(peak_memory()))"
            places = os.pathsep.join([environment["PYTHONPATH"], str(ROOT / "evidence")])
            memory = subprocess.run(
                [sys.executable, "-c", code, *call[3:]],
                cwd=folder, env=environment | {"PYTHONPATH": places}, capture_output=True, text=True, check=False,
            )  # fmt: skip
            table.add(f"{name}, peak memory", None, float(memory.stderr.split()[-1]) / 1e6, "MB")


def measure_growth(table: Table, repeats: int) -> None:
    """Measure the cost an atom of dots of one density on larger and larger molecules, and of points over their surface."""
    xyz, r = embedded()
    first = None
    for copies in GROWTH:
        spheres, n = (lattice(xyz, copies), np.tile(r, copies)), copies * len(r)
        here = repeats if copies < GROWTH[-1] else 1
        run = partial(molecular_surface, *spheres)
        spent = table.time(f"surface per atom, {n} atoms, of growth", None, run, here, "µs", 1e6 / n)
        first = first or spent
        table.add(f"ratio, {n} atoms to {GROWTH[0] * len(r)}", None, spent / first, "times", most=MAX_GROWTH)
        if copies == GROWTH[0]:
            spent = table.time(
                f"{N_POINTS} points, {n} atoms", None, partial(points, spheres, N_POINTS), here
            )
            ratio = spent / (first * n / 1e6)
            table.add("ratio, points to their surface", None, ratio, "times", most=MAX_POINTS_PER_SURFACE)


def measure_density(table: Table, repeats: int) -> None:
    """Measure dots of the default density as multiples of the same density given by hand."""
    for residues, copies in SIZES_OF_DENSITY:
        xyz, r = embedded(residues)
        spheres = lattice(xyz, copies), np.tile(r, copies)
        density = len(spread := placed_surface(spheres)) / spread.area.sum()
        default = timed(partial(placed_surface, spheres), repeats)[0]
        by_hand = timed(partial(placed_surface, spheres, density=density), repeats)[0]
        what = f"ratio, default density to the same by hand, {len(spheres[1])} atoms"
        table.add(what, None, default / by_hand, "times", most=MAX_DEFAULT_DENSITY)


def measure_commands(table: Table, repeats: int, quick: bool) -> None:
    """Measure whole processes on the embedded structure: its surface, warm and cold, beside MSMS, and its page.

    MSMS reads the centres and radii of the atoms, which are written to its file beforehand. A cold process has an empty cache
    of kernels and compiles those that it needs.
    """
    with tempfile.TemporaryDirectory() as folder:
        program = [sys.executable, "-m", "sparsurf"]
        surface = [*program, "surface", EMBEDDED, "-q", "-o", Path(folder, "dots.npz")]
        cpu, wall = cpu_of_process(surface, repeats)
        warm = table.add("sparsurf surface, a process", None, cpu, "s", wall)
        if not quick:
            empty = os.environ | {"NUMBA_CACHE_DIR": str(Path(folder, "kernels"))}
            cpu, wall = cpu_of_process(surface, env=empty)
            table.add("sparsurf surface, a process that compiles", None, cpu, "s", wall)
        if msms := msms_program():
            spheres, out = Path(folder, "spheres.xyzr"), Path(folder, "out")
            np.savetxt(spheres, np.column_stack(embedded()), "%.3f")
            options = ["-probe_radius", f"{PROBE_RADIUS}", "-density", f"{DENSITY}"]
            theirs, wall = cpu_of_process([msms, "-if", spheres, "-of", out, *options], repeats)
            table.add("peer: the same by MSMS, a process", None, theirs, "s", wall)
            table.add("ratio, MSMS to `sparsurf surface`", None, theirs / warm, "times")
        page = [*program, "show", EMBEDDED, "--no-open", "-o", Path(folder, "page.html")]
        cpu, wall = cpu_of_process(page, repeats)
        table.add("the first page of a protein, a process", None, cpu, "s", wall)


def cpu_of_process(command: Sequence[str | Path], repeats: int = 1, **keys: Any) -> tuple[float, float]:
    """Return median CPU and wall seconds of a process over `repeats` runs."""
    rows = []
    for _ in range(repeats):
        wall, before = time.perf_counter(), os.times()
        subprocess.run(command, check=True, capture_output=True, **keys)
        after = os.times()
        cpu = after.children_user + after.children_system - before.children_user - before.children_system
        rows.append((cpu, time.perf_counter() - wall))
    return tuple(np.median(rows, axis=0).tolist())


def measure_peers(table: Table, surface: Surface, repeats: int) -> list[str]:
    """Measure other programs on the same work, ours, and the ratio of theirs to ours; return the programs that are missing."""
    xyz, r = embedded()
    missing = []
    with tempfile.TemporaryDirectory() as folder:
        spheres = Path(folder, "spheres.xyzr")
        np.savetxt(spheres, np.column_stack([xyz, r]), "%.3f")
        programs: dict[str, tuple[str | None, list[str | Path]]] = {
            "EDTSurf": (shutil.which("EDTSurf"), ["-i", EMBEDDED, "-o", Path(folder, "out")]),
            "MSMS": (msms_program(), ["-if", spheres, "-of", Path(folder, "out"), "-density", f"{DENSITY}"]),
        }
        for name, (program, options) in programs.items():
            if program is None:
                missing.append(name)
                continue
            theirs, wall = cpu_of_process([program, *options], repeats)
            what = f"peer: surface of the embedded structure by {name}, a process"
            table.add(what, None, theirs, "s", wall)
            compare_with(
                table, name, theirs, "the same surface here", partial(molecular_surface, xyz, r), repeats
            )
    area = partial(molecular_surface, xyz, r)
    if freesasa := installed("freesasa", missing):
        run = partial(freesasa.calcCoord, xyz.ravel(), r)
        theirs = table.time("peer: accessible area of the embedded structure by freesasa", None, run, repeats)
        compare_with(table, "freesasa", theirs, "its molecular surface here", area, repeats)
    if structure := installed("biotite.structure", missing):
        atoms = structure.AtomArray(len(xyz))
        atoms.coord = xyz
        run = partial(structure.sasa, atoms, vdw_radii=r)
        theirs = table.time("peer: accessible area of the embedded structure by biotite", None, run, repeats)
        compare_with(table, "biotite", theirs, "its molecular surface here", area, repeats)
    if fpsample := installed("fpsample", missing):
        compare_with_fpsample(table, fpsample, surface, repeats)
    image = np.random.default_rng(0).random((PIXELS, PIXELS))
    images = np.random.default_rng(0).random((512, published.N_EVEN + published.N_ODD))
    others: dict[str, Callable[[], Any]] = {}
    if mahotas := installed("mahotas.features", missing):
        others["mahotas"] = partial(mahotas.zernike_moments, image, DISC, N_MAX)
    if zepyros := installed("zepyros.zernike", missing):
        orders = [(order, m) for order in range(N_MAX + 1) for m in range(order % 2, order + 1, 2)]
        basis = zepyros.Zernike2D(image)
        others["zepyros"] = lambda: [basis.compute_coeff_nm(image, *each) for each in orders]
    for name, moments in others.items():
        theirs = table.time(f"peer: moments of one image by {name}", None, moments, repeats, "µs", 1e6)
        here, ours = "the same here, 512 images", partial(published.moments, images)
        compare_with(table, name, theirs, here, ours, repeats, None, "µs", 1e6 / 512)
    return missing


def compare_with_fpsample(table: Table, fpsample: ModuleType, surface: Surface, repeats: int) -> None:
    """Measure farthest dots of small and large surfaces here and by the fastest of fpsample's samplers."""
    for copies, n_s in FARTHEST:
        dots = repeated(surface, copies)
        n = len(dots)
        kdline = fpsample.bucket_fps_kdline_sampling
        samplers = [fpsample.bucket_fps_kdtree_sampling, *(partial(kdline, h=h) for h in (5, 7, 9))]
        times = [timed(partial(sampler, dots.points, n_s), repeats)[0] for sampler in samplers]
        theirs = table.add(f"peer: {n_s} farthest dots by fpsample's best sampler", n, min(times), "s")
        index = build_index(dots.points, dots.normals)
        ours = partial(farthest_point_sampling, index, n_s, np.random.default_rng(0))
        compare_with(table, "fpsample", theirs, f"{n_s} farthest dots here", ours, repeats, n)


def compare_with(
    table: Table, name: str, theirs: float, what: str, ours: Callable, repeats: int,
    dots: int | None = None, unit: str = "s", per: float = 1.0,
) -> None:  # fmt: skip
    """Measure the same work here, and add the ratio of the time of another program to ours."""
    table.add(
        f"ratio, {name} to this", dots, theirs / table.time(what, dots, ours, repeats, unit, per), "times"
    )


def installed(name: str, missing: list[str]) -> ModuleType | None:
    """Return a module if it can be imported; else add its package to those that are missing."""
    try:
        return importlib.import_module(name)
    except ImportError:
        missing.append(name.partition(".")[0])
        return None


def measure_reference(table: Table, surface: Surface, name: str) -> None:
    """Measure another program's descriptor function on the same patches, (n, 6) arrays of dots and normals."""
    module, _, function = name.partition(":")
    sys.path.append(os.getcwd())
    try:
        other = getattr(importlib.import_module(module), function)
    except (ImportError, AttributeError, ValueError) as error:
        raise InputError(f"--reference {name}: {error}; give module:function.") from None
    index, n = build_index(surface.points, surface.normals), len(surface)
    tests = np.random.default_rng(0).choice(n, REFERENCE_PATCHES, replace=False)
    ids = [patch(index, t, R_ZERNIKE) for t in tests]
    patches = [np.hstack([surface.points[i], surface.normals[i]]) for i in ids]
    reference_time, _ = timed(lambda: [other(p) for p in patches], 3)
    reference_time = table.add(f"a patch by {name}", n, 1e6 * reference_time / len(tests), "µs")
    many = np.tile(surface.points[tests], (200, 1))
    ours = table.time(
        "the same patches here",
        n,
        lambda: descriptors.describe_patches(index, many),
        3,
        "µs",
        1e6 / len(many),
    )
    table.add("ratio", n, reference_time / ours, "times")
    in_one_pass = [row["value"] for row in table.rows if row["what"] == "a descriptor, 100% kept, `full`"]
    table.add("ratio, 64 subsets in one pass", n, reference_time / in_one_pass[0], "times")


def warm_up() -> None:
    """Load every kernel, so that what follows measures the dots."""
    dots = molecular_surface(np.array([[0.0, 0, 0], [2.5, 0, 0], [0.0, 2.5, 0]]), np.full(3, 1.7))
    grid.evaluate_grid(PreparedSurface(dots), np.array([[0.5, 0.5, 1.0, 1.0]]), 4)


def print_memory(copies: int, quick: bool) -> None:
    """Print, in a process of its own, the bytes above the imports for all steps of one surface."""
    warm_up()
    one = a1(quick)
    before = peak_memory()
    surface = repeated(one, copies)
    grid.evaluate_grid(
        PreparedSurface(surface, threads=available_cores()),
        published_sampling.parameter_grid(*SMALL_GRID),
        100,
    )
    print(json.dumps({"dots": len(surface), "bytes": peak_memory() - before}))


def print_ribosome() -> None:
    """Print, in a process of its own, the seconds of every step on a large assembly and the peak memory."""
    warm_up()
    before, seconds, cores = peak_memory(), {}, available_cores()

    def step(name: str, run: Callable) -> Any:
        wall, cpu = time.perf_counter(), time.process_time()
        result = run()
        seconds[name] = (time.process_time() - cpu, time.perf_counter() - wall)
        return result

    molecule = step("reading", lambda: read_molecule(RIBOSOME, selection="all", whole=False))
    surface = step("surface", lambda: molecular_surface(molecule.xyz[0], radii(molecule)))
    index = step("index", lambda: build_index(surface.points, surface.normals))
    rough = step("roughness", lambda: roughness_of_patches(index, threads=cores))
    prepared = step("cover", lambda: PreparedSurface(surface, roughness=rough, threads=cores))
    step(
        "grid of 36, 400 test dots",
        lambda: grid.evaluate_grid(prepared, published_sampling.parameter_grid(*SMALL_GRID), 400),
    )
    figures = {
        "atoms": molecule.n_atoms,
        "dots": len(surface),
        "bytes": peak_memory() - before,
        "seconds": seconds,
    }
    print(json.dumps(figures))


def measure_ribosome(table: Table) -> None:
    """Measure all steps on a large assembly, on all cores."""
    figures = in_child("print_ribosome()")
    for what, (cpu, wall) in figures["seconds"].items():
        table.add(f"ribosome of {figures['atoms']} atoms: {what}", figures["dots"], cpu, "s", wall)
    table.add("ribosome: peak memory", figures["dots"], figures["bytes"] / figures["dots"], "bytes per dot")


def in_child(call: str) -> dict:
    """Return the result of a `print_...` of this file in a fresh process."""
    command = [sys.executable, "-c", f"import bench; bench.{call}"]
    return json.loads(subprocess.run(command, cwd=ROOT / "evidence", capture_output=True, check=True).stdout)


def measure_start(table: Table, quick: bool) -> None:
    """Measure import and compilation with an empty cache of kernels and with a full one; wall seconds of a process."""
    with tempfile.TemporaryDirectory() as cache:
        for what in ("warm",) if quick else ("cold", "warm"):
            place = {} if quick else {"NUMBA_CACHE_DIR": cache}
            command = [sys.executable, "-c", "import bench; bench.warm_up()"]
            cpu, wall = cpu_of_process(command, cwd=ROOT / "evidence", env=os.environ | place)
            table.add(f"{what} start: imports and kernels", None, cpu, "s", wall)


def measure_study(table: Table, tree: Path = ROOT) -> None:
    """Measure the default study of a checkout from the start, split by rule, and again with nothing to do; CPU and wall seconds.

    Its kernels are compiled before: in this checkout by `make setup`, in another one by a run in vain.
    """
    with tempfile.TemporaryDirectory() as folder:
        for run in ("study",) if tree == ROOT else ("in vain", "study"):
            place = Path(folder, run)
            place.mkdir()
            (place / "data").symlink_to(tree / "data")
            files = ["--snakefile", tree / "Snakefile", "--configfile", tree / "config.yaml"]
            options = ["--directory", place, "--cores", "all", "--quiet", "all"]
            command = [sys.executable, "-m", "snakemake", *map(str, files + options)]
            cpu, wall = cpu_of_process(command)
        table.add("default study", None, cpu, "s", wall)
        measure_rules(table, place / ".snakemake" / "metadata", wall)
        cpu, wall = cpu_of_process(command)
        table.add("default study, nothing to do", None, cpu, "s", wall, 5)


def measure_rules(table: Table, metadata: Path, wall: float) -> None:
    """Add wall seconds of the jobs of every rule, and their share of the study."""
    jobs = {}
    for path in metadata.rglob("*"):
        if path.is_file():
            record = json.loads(path.read_text())
            log = (record["rule"], *record["log"])  # one job has as many records as outputs
            begin, end = jobs.get(log, (math.inf, 0.0))
            jobs[log] = (min(begin, record["starttime"]), max(end, record["endtime"]))
    for rule in dict.fromkeys(rule for rule, *_ in sorted(jobs, key=jobs.get)):
        spent = [end - begin for (name, *_), (begin, end) in jobs.items() if name == rule]
        table.add(
            f"rule {rule}, {len(spent)} {'job' if len(spent) == 1 else 'jobs'}", None, None, "s", sum(spent)
        )
    busy = until = 0.0
    for begin, end in sorted(jobs.values()):
        busy, until = busy + max(0.0, end - max(begin, until)), max(until, end)
    table.add("share of the study in which jobs run", None, None, "%", 100 * busy / wall)


def main(
    path_to_output: str | Path, quick: bool = False, reference: str | None = None, base: str | None = None
) -> None:
    """Measure, print and write the JSON file, and the same table as Markdown."""
    if base and not Path(base).is_dir():
        git("cat-file", "-e", f"{base}^{{commit}}")
    table, surface = Table(), a1(quick)
    copies, repeats, n_tests = ((1,), 1, 16) if quick else (COPIES, 3, 512)
    with threadpool_limits(1, "blas"):
        for c in copies:
            promised = c == 1 and not quick
            combinations = published_sampling.parameter_grid(*(FULL_GRID if promised else SMALL_GRID))
            measure_dots(table, repeated(surface, c), promised, repeats, n_tests, combinations)
        combinations = (
            published_sampling.parameter_grid(*SMALL_GRID)[:2]
            if quick
            else published_sampling.parameter_grid(*FULL_GRID)
        )
        measure_grids(table, surface, combinations, {n_tests: None} if quick else GRID_LIMITS, repeats)
        measure_pairs(table, {500: None} if quick else PAIR_LIMITS, repeats)
        measure_surface(table, copies, repeats, QUICK_RESIDUES if quick else None)
        measure_frames(table, quick)
        measure_points(table, repeats, QUICK_RESIDUES if quick else None)
        measure_density(table, repeats)
        if not quick:
            measure_growth(table, repeats)
        measure_commands(table, repeats, quick)
        measure_processes(table, repeats)
        missing = measure_peers(table, surface, repeats)
        if reference:
            measure_reference(table, surface, reference)
    measure_start(table, quick)
    for c in copies:
        memory = in_child(f"print_memory({c}, {quick})")
        most = 400 if c == COPIES[-1] else None
        per_dot = memory["bytes"] / memory["dots"]
        table.add("peak memory above the imports", memory["dots"], per_dot, "bytes per dot", most=most)
    if not quick and RIBOSOME.is_file():
        measure_ribosome(table)
    if not quick:
        measure_study(table)
    ratios = ratios_to(figures_of(base, quick, repeats), table.rows) if base else {}
    if base:
        print(f"\nTimes here divided by those of {base}, measured after them on this machine")
        print("\n".join(f"{ratio:6.2f}  {what}" for what, ratio in ratios.items()))
    print("\nNot installed, so not compared: " + (", ".join(missing) or "none"))
    print("\nAbove what is promised: " + ("; ".join(table.missed()) or "nothing"))
    path = Path(path_to_output)
    path.parent.mkdir(parents=True, exist_ok=True)
    content = {"machine": machine(), "quick": quick, "figures": table.rows, "base": base, "ratios": ratios}
    path.write_text(json.dumps(content, indent=2) + "\n", encoding="utf-8")
    path.with_suffix(".md").write_text(table.markdown(), encoding="utf-8")


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


def figures_of(base: str, quick: bool, repeats: int) -> list[dict[str, Any]]:
    """Return the figures of a base on this machine: its commands and study measured from here, and those of its own bench."""
    with tree_of(base) as tree, tempfile.TemporaryDirectory() as folder:
        kernels, out, table = str(Path(folder, "kernels")), Path(folder, "bench.json"), Table()
        measure_processes(table, repeats, tree, kernels)
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
    """Divide figures by those of the base with the same name and number of dots; wall time where no CPU is known."""
    before = {(row["what"], row["dots"]): row for row in reversed(base)}
    ratios: dict[str, float] = {}
    for row in rows:
        other = before.get((row["what"], row["dots"]), {})
        for kind in ("value", "wall"):
            if row[kind] and other.get(kind):
                dots = "" if row["dots"] is None else f", {row['dots']} dots"
                ratios.setdefault(row["what"] + dots, float(row[kind] / other[kind]))
    return ratios


def command(arguments: Sequence[str] | None = None) -> None:
    """Measure what the command line asks for."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0], allow_abbrev=False)
    parser.add_argument("--quick", action="store_true", help="a small surface, once: to see that all runs")
    parser.add_argument(
        "--base", help="commit whose figures are measured, too, and by which these are divided"
    )
    parser.add_argument("--reference", help="module:function of another program, timed on the same patches")
    parser.add_argument("--out", default=ROOT / "results" / "bench" / "bench.json", help="JSON file to write")
    args = parser.parse_args(arguments)
    try:
        main(args.out, args.quick, args.reference, args.base)
    except InputError as error:
        parser.error(str(error))


if __name__ == "__main__":
    command()
