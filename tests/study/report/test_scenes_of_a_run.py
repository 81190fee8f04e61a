"""Structures and dots that a run writes for PyMOL and ChimeraX, from dots in another order, turned, and of unknown residues."""

from dataclasses import replace

import gemmi
import numpy as np
import pandas as pd
import pytest
from scipy.spatial.transform import Rotation

import sparsurf
from peptides import peptide, write
from small_study import run_script
from sparsurf.settings import SurfaceSettings
from sparsurf.surfaces.formats.npz import write_npz

TURN, SHIFT = Rotation.from_euler("xyz", [30, 110, 200], degrees=True), np.array([30.0, -20, 10])
CHAINS = {"A": (("ALA", "SER", "LYS", "VAL"), (0, 0, 0)), "B": (("ALA", "SER", "CYS"), (0, 25, 0))}
CHAINS |= {"C": (("SER", "ALA", "CYS"), (0, 0, 30))}
UNKNOWN = ("B", "2")  # a residue without dots
BURIED = -1.0


@pytest.fixture(scope="module")
def dots(tmp_path_factory):
    """Dots on a molecule of three chains, with numbers that tell them apart, and none of them on one residue."""
    parts = [peptide(names, chain, origin=origin) for chain, (names, origin) in CHAINS.items()]
    path = write(tmp_path_factory.mktemp("three") / "three.pdb", "TER\n".join(parts) + "END\n")
    surface = sparsurf.surface(path, density=3)
    molecule = surface.molecule
    labels = np.array([molecule.chain, molecule.residue])[:, surface.atom]
    surface = surface[~(labels == np.array(UNKNOWN)[:, None]).all(axis=0)]
    table = surface.to_frame()[["chain", "residue", "residue_name"]]
    return surface, table.assign(value=0.2 + 0.6 * np.linspace(0, 1, len(table)) ** 2)


def rearranged(dots, order, is_turned):
    """The dots, their molecule and their table in another order or turned."""
    surface, table = dots
    rows, molecule = order(len(surface)), surface.molecule
    if is_turned:
        molecule = replace(molecule, xyz=TURN.apply(molecule.xyz[0])[None] + SHIFT)
        points, normals = TURN.apply(surface.points) + SHIFT, TURN.apply(surface.normals)
        surface = replace(surface, points=points, normals=normals)
    return surface[rows], molecule, table.iloc[rows]


CHANGES = pytest.mark.parametrize(
    ("order", "is_turned"),
    [(np.arange, False), (lambda n: np.random.default_rng(n).permutation(n), False), (np.arange, True)],
    ids=["as they are", "in another order", "turned"],
)


def assert_shown(path, molecule, mean):
    """Each atom is at its place, with the mean of its residue as B factor."""
    chains = gemmi.read_structure(str(path))[0]
    found = {
        (chain.name, str(residue.seqid.num), atom.name): (atom.b_iso, atom.pos.tolist())
        for chain in chains
        for residue in chain
        for atom in residue
    }
    rows = zip(molecule.chain, molecule.residue, molecule.name, molecule.xyz[0], strict=True)
    for chain, residue, name, place in rows:
        b_factor, position = found.pop((chain, residue, name))
        assert b_factor == pytest.approx(mean.get((chain, residue), BURIED), abs=0.0051)
        assert position == pytest.approx(place, abs=0.001)
    assert not found and UNKNOWN not in mean


@CHANGES
def test_the_structure_has_the_roughness_of_its_residues_and_the_kept_dots_their_places(
    dots, order, is_turned, tmp_path
):
    surface, molecule, table = rearranged(dots, order, is_turned)
    inputs = {name: str(tmp_path / name) for name in ("surface", "roughness", "minimal")}
    inputs["structure"] = str(tmp_path / "given.pdb")
    write_npz(inputs["surface"], surface)
    molecule.write_pdb(inputs["structure"])
    table[["value"]].rename(columns={"value": "roughness"}).to_csv(inputs["roughness"], index=False)
    kept = np.random.default_rng(1).permutation(len(surface))[:20]
    few = pd.DataFrame(surface.points[kept], columns=[*"xyz"]).assign(dot=kept, weight=1)
    few.loc[3, "weight"] += len(surface) - 20
    few.to_csv(inputs["minimal"], index=False)
    outputs = {name: tmp_path / f"open.{name}" for name in ("table", "pdb", "pml", "cxc", "bild")}
    rules = {"surface": SurfaceSettings().model_dump()}
    run_script("tabulate_residues", tmp_path, inputs | {"fields": []}, outputs, rules)
    assert_shown(outputs["pdb"], molecule, table.groupby(["chain", "residue"])["value"].mean().to_dict())
    spheres = [line.split()[1:4] for line in outputs["bild"].read_text().splitlines() if ".sphere" in line]
    assert np.abs(np.array(spheres, float) - surface.points[kept]).max() < 0.001


@CHANGES
def test_the_structures_of_a_pair_have_the_propensity_of_their_residues(dots, order, is_turned, tmp_path):
    """The second partner has the same names of chains and residues, and other numbers."""
    sides, inputs = [], {"dots": tmp_path / "dots.csv"}
    for side in (1, 2):
        _, molecule, table = rearranged(dots, order, is_turned)
        molecule.write_pdb(tmp_path / f"structure_{side}.pdb")
        inputs[f"structure_{side}"] = tmp_path / f"structure_{side}.pdb"
        table = table.assign(partner=side, value=table["value"] * 10**side)
        names = ("propensity_smoothed", "propensity_k_smoothed", "similarity_smoothed")
        sides.append(table.assign(interface=0, **{name: table["value"] + k for k, name in enumerate(names)}))
    rows = pd.concat(sides)
    rows.iloc[order(len(rows))].to_csv(inputs["dots"], index=False)
    outputs = {"residues": "r.csv", "pdb_1": "1.pdb", "pdb_2": "2.pdb", "pml": "o.pml", "cxc": "o.cxc"}
    outputs = {key: tmp_path / name for key, name in outputs.items()}
    run_script("tabulate_pair_residues", tmp_path, inputs, outputs)
    means = [table.groupby(["chain", "residue"])["value"].mean() for table in sides]
    for side, mean in enumerate(means, 1):
        assert_shown(outputs[f"pdb_{side}"], molecule, mean.to_dict())
    low, high = (f"{end:.3f}" for end in np.quantile(pd.concat(means), [0.05, 0.95]))
    assert f", {low}, {high}\n" in outputs["pml"].read_text()
    assert f"range {low},{high}\n" in outputs["cxc"].read_text()
