"""What a type checker says of a user's script, and that the types of choices are those that the functions take."""

import subprocess
import sys
from typing import get_args

import pytest

from sparsurf import arguments
from sparsurf.recovery import law
from sparsurf.surfaces.radii import RADII

RIGHT = """
import numpy as np
from numpy.typing import NDArray

import sparsurf

molecule = sparsurf.read_molecule("protein.pdb", hydrogens="remove")
dots = sparsurf.surface(molecule, density="auto", radii="bondi", cavities="remove", reentrant="dms", boundary="accessible")
points: NDArray[np.float64] = dots.points
kept: NDArray[np.int64] = sparsurf.sample(dots, percent=10)
few = sparsurf.minimal(dots, reconstruction="spheres", sampler="farthest")
mesh = sparsurf.mesh(few, density=1.0)
corners: NDArray[np.int64] = mesh.triangles
residues = sparsurf.frames("protein.pdb", "run.xtc", rank_by="range").residues
area: float = sparsurf.areas(molecule).accessible.sum()
density = sparsurf.density_for(0.02, sampler="cover")
"""
WRONG = [
    'sparsurf.read_molecule("protein.pdb", hydrogens="add")',
    'sparsurf.surface(molecule, density="fine")',
    "sparsurf.surface(molecule, radii=1.5)",
    'sparsurf.surface(molecule, cavities="rm")',
    'sparsurf.surface(molecule, reentrant="exactly")',
    'sparsurf.surface(molecule, boundary="included")',
    'sparsurf.minimal(dots, reconstruction="sphere")',
    'sparsurf.density_for(0.02, sampler="uniform")',
    'sparsurf.frames("protein.pdb", rank_by="mean")',
    'sparsurf.frames("protein.pdb", path="frames.csv").residues',
    "indices: NDArray[np.int64] = dots.points",
]


@pytest.mark.slow
def test_a_users_script_passes_strict_checks_and_a_wrong_choice_fails_them(tmp_path):
    script = tmp_path / "script.py"
    script.write_text(RIGHT + "\n".join(WRONG) + "\n", encoding="utf-8")
    options = ["--strict", "--no-error-summary", "--cache-dir", str(tmp_path / "cache")]
    run = subprocess.run(
        [sys.executable, "-m", "mypy", *options, script.name], cwd=tmp_path, capture_output=True, text=True
    )
    refused = {int(line.split(":")[1]) for line in run.stdout.splitlines() if ": error: " in line}
    first = RIGHT.count("\n") + 1
    assert refused == {*range(first, first + len(WRONG))}, run.stdout + run.stderr


def test_the_types_of_choices_are_those_of_the_tables():
    assert [*get_args(arguments.RadiiTable)] == [*RADII]
    assert {*get_args(law.MeasuredSampler)} == {sampler for sampler, *_ in law.MEASURED}
