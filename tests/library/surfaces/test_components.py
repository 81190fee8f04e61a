"""Components of a surface: cavities of hollow shells, molecules apart, patches with two borders, a real protein."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.csgraph import connected_components
from scipy.spatial.transform import Rotation

import sparsurf
from conftest import ROOT, sphere
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.components import (
    _covering_caps,
    _loops,
    _n_covered_parts,
    _patches_of_atom,
    components_of,
    joined_arcs,
    summarize_components,
    table_of_components,
    without_cavities,
)
from sparsurf.surfaces.dot_placement import relative_positions, roll_checked
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.rolling_probe import arcs_of_atoms, roll


def shell(n=200, radius=9.0):
    """Centres spread over a sphere so densely that no probe passes between them."""
    return radius * sphere(n)[0]


def parts(xyz, sizes):
    surface = molecular_surface(xyz, sizes)
    component = components_of(surface, xyz, sizes)
    return surface, component, table_of_components(surface, roll_checked(xyz, sizes, 1.4))


def test_a_hollow_shell_has_one_cavity_of_the_volume_that_is_left():
    surface, component, table = parts(shell(), np.full(200, 1.9))
    assert table["cavity"].tolist() == [False, True]
    inside = np.linalg.norm(surface.points, axis=1) < 9
    assert (component == inside).all()
    # Between spheres that the dents between the atoms leave: 9 Å -+ the atoms' radius
    low, high = (4 / 3 * np.pi * r**3 for r in (9 - 1.9, 9 - 1.4))
    assert low < table["volume"][1] < high and table["volume"][0] > 4 / 3 * np.pi * 10.4**3
    assert table["area"].sum() == pytest.approx(surface.area.sum(), rel=1e-4)
    inner = int(inside.sum())
    volume = table["volume"][0] - table["volume"][1]
    summary = summarize_components(table)
    assert [summary[key] for key in ("volume", "components", "cavities", "cavity_dots", "handles")] == [
        volume,
        2,
        1,
        inner,
        0,
    ]
    outside = without_cavities(surface, component)
    assert np.array_equal(outside.points, surface.points[~inside])


@pytest.mark.parametrize("density", [6.0, 3.0])
def test_cavities_are_removed_where_asked(density):
    given = shell(), np.full(200, 1.9)
    kept = sparsurf.surface(given, density=density)
    outside = sparsurf.surface(given, density=density, cavities="remove")
    component, table = sparsurf.components(given, kept)
    assert table["dots"].tolist() == [len(outside), len(kept) - len(outside)]
    assert np.array_equal(outside.points, kept.points[component == 0])
    assert sparsurf.components(given, outside)[1]["cavity"].tolist() == [False]


def test_a_mesh_without_its_cavity_is_closed_and_encloses_it():
    given = shell(), np.full(200, 1.9)
    whole, outside = (
        sparsurf.mesh(sparsurf.surface(given, cavities=each), step=0.6) for each in ("keep", "remove")
    )
    sides = np.sort(np.stack([outside.triangles, np.roll(outside.triangles, 1, axis=1)], axis=2), axis=2)
    assert (np.unique(sides.reshape(-1, 2), axis=0, return_counts=True)[1] == 2).all()
    assert (
        np.linalg.norm(outside.vertices.points, axis=1).min() > 9
        and outside.triangles.max() == len(outside.vertices) - 1
    )
    _, table = sparsurf.components(given, sparsurf.surface(given))
    assert outside.volume - whole.volume == pytest.approx(table["volume"][1], rel=0.02)


def test_no_mesh_keeps_a_hole_where_two_fixed_probes_nearly_coincide():
    """In a cube of a lattice four atoms touch each probe, so that fixed probes lie in pairs, 1e-8 Å apart."""
    steps = 3.0 * np.arange(-2, 3)
    lattice = np.array(np.meshgrid(steps, steps, steps)).reshape(3, -1).T
    walls = lattice[np.abs(lattice).max(axis=1) > 3], np.full(98, 1.7)
    rolling = roll(np.add(*relative_positions(walls[0])), walls[1] + 1.4)
    _, meeting = joined_arcs(rolling)
    assert np.bincount(meeting.ravel(), minlength=len(rolling.probes)).tolist() == [3] * len(rolling.probes)
    outside = sparsurf.mesh(walls, step=0.5)
    dots = sparsurf.surface(walls, cavities="remove")
    assert outside.area == pytest.approx(dots.area.sum(), rel=0.01)
    assert np.linalg.norm(outside.vertices.points, axis=1).min() > 6


def test_what_cannot_be_is_refused():
    given = shell(), np.full(200, 1.9)
    with pytest.raises(InputError, match="cavities is 'drop';"):
        sparsurf.surface(given, cavities="drop")
    dots = sparsurf.surface(given)
    for some in (dots[::-1], dots[:-1]):
        assert some.origin is dots.origin
        with pytest.raises(InputError, match="complete surface"):
            some.known_components("x")
    with pytest.raises(InputError, match="the dots are not those of the molecule"):
        sparsurf.components((shell()[:100], np.full(100, 1.9)), replace(dots, origin=None))


def test_a_molecule_in_a_cavity_is_none_and_a_hole_opens_it():
    xyz = np.vstack([shell(), [[0.3, 0, 0]]])
    _, _, table = parts(xyz, np.full(201, 1.9))
    assert table["cavity"].tolist() == [False, True, False]
    assert table["area"][2] == pytest.approx(4 * np.pi * 1.9**2, rel=1e-6)
    assert table["volume"][2] == pytest.approx(4 / 3 * np.pi * 1.9**3, rel=0.01)
    xyz = shell()
    xyz = xyz[np.linalg.norm(xyz - [0, 0, 9], axis=1) > 4]
    _, _, table = parts(xyz, np.full(len(xyz), 1.9))
    assert table["cavity"].tolist() == [False]


def test_what_bounds_one_patch_of_an_atom_belongs_together():
    """A ball plugs a hole of the shell; an atom on its outer side has a border there that no arc joins to the others."""
    xyz = shell()
    xyz = xyz[np.linalg.norm(xyz - [0, 0, 9], axis=1) > 4]
    sizes = np.append(np.full(len(xyz), 1.9), [4.0, 1.5])
    _, _, table = parts(np.vstack([xyz, [[0, 0, 9], [0, 0, 14]]]), sizes)
    assert table["cavity"].tolist() == [False, True]


def test_covered_parts_of_spheres_are_those_of_a_graph(protein):
    molecule, sizes = protein
    atoms = roll(np.add(*relative_positions(molecule.xyz[0])), sizes + 1.4).atoms
    for k in range(0, molecule.n_atoms, 5):
        near = atoms.near[atoms.start[k] : atoms.start[k + 1]]
        axis = atoms.centre[near] - atoms.centre[k]
        d = np.linalg.norm(axis, axis=1)
        cosine = (d**2 + atoms.reach[k] ** 2 - atoms.reach[near] ** 2) / (2 * d * atoms.reach[k])
        cuts = np.abs(cosine) < 1
        half, unit = np.arccos(cosine[cuts]), axis[cuts] / d[cuts, None]
        linked = np.arccos(np.clip(unit @ unit.T, -1, 1)) < half[:, None] + half
        expected = connected_components(linked)[0]
        assert _n_covered_parts(*_covering_caps(atoms, k)) == expected


@pytest.mark.parametrize(("neck", "chambers"), [(1.39, 2), (1.41, 1)])
def test_two_chambers_are_one_cavity_where_the_probe_passes_their_neck(neck, chambers):
    """A wall with a round hole halves a hollow ball; probes on both sides of the narrow hole overlap, and none passes."""
    rings = [(neck + 1.9 + 1.0 * k) for k in range(6)]
    wall = [
        [radius * np.cos(turn), radius * np.sin(turn), 0.0]
        for radius in rings
        for turn in np.linspace(0, 2 * np.pi, 36, endpoint=False)
        if radius < 9
    ]
    xyz = np.vstack([shell(), wall])
    _, _, table = parts(xyz, np.full(len(xyz), 1.9))
    assert table["cavity"].tolist() == [False] + [True] * chambers


def test_borders_around_one_free_part_of_an_atom_belong_together():
    """On a sphere, borders + 1 - covered parts is the number of free parts, which is that of the joined sets of borders."""
    cases = 0
    for seed in range(400):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(3, 16))
        directions = rng.normal(size=(n, 3))
        around = directions / np.linalg.norm(directions, axis=1)[:, None] * rng.uniform(3.0, 6.2, (n, 1))
        sizes = np.append(1.9, rng.uniform(0.5, 2.0, n))
        rolling = roll(np.vstack([[[0.0, 0, 0]], around]), sizes + 1.4)
        _, meeting = joined_arcs(rolling)
        order, first = arcs_of_atoms(rolling.pair, n + 1)
        arcs = order[first[0] : first[1]]
        covered = _n_covered_parts(*_covering_caps(rolling.atoms, 0))
        if len(arcs):
            borders = len(set(_loops(arcs, meeting).tolist()))
            patches = _patches_of_atom(arcs, meeting, rolling, 0)
            assert len(set(patches.tolist())) == borders + 1 - covered
            cases += borders > 1 and 1 < covered < borders
    assert cases > 10


def test_molecules_apart_and_a_ring_are_components_of_their_own():
    """A patch of the ball in the middle has two borders, one for each neighbour: it is one."""
    row = np.array([[-3.2, 0, 0], [0, 0, 0], [3.2, 0, 0]])
    _, _, table = parts(np.vstack([row, np.add(row, [0, 20, 0]), [[0, 0, 40]]]), np.full(7, 1.9))
    assert table["cavity"].tolist() == [False] * 3 and table["area"][0] == pytest.approx(
        table["area"][1], rel=0.01
    )
    turn = 2 * np.pi * np.arange(12) / 12
    ring = 6 * np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=1)
    assert len(parts(ring, np.full(12, 1.9))[2]) == 1


@pytest.fixture(scope="module")
def protein():
    molecule = read_molecule(ROOT / "data" / "tdp43" / "topology.pdb")
    return molecule, radii(molecule)


def test_components_of_a_protein_are_closed_and_turn_with_it(protein):
    """MSMS finds the three larger cavities with `-all_components`; it does not look at the atoms of the smallest again."""
    molecule, sizes = protein
    surface, component, table = parts(molecule.xyz[0], sizes)
    assert table["cavity"].tolist() == [False] + [True] * 4
    np.testing.assert_allclose(table["area"], [4481.6, 40.5, 19.0, 15.8, 2.6], rtol=0.03)
    for each in range(2):  # the others meet the outside at cusps, so that their dots alone enclose nothing
        own = component == each
        assert np.linalg.norm(surface.area[own] @ surface.normals[own]) < 0.03 * table["area"][each]
    turned = molecule.xyz[0] @ Rotation.random(rng=np.random.default_rng(4)).as_matrix() + [5, 6, 70]
    again = parts(turned, sizes)[2]
    assert len(again) == len(table)  # the smallest has 14 dots, whose places decide its area
    np.testing.assert_allclose(again[["area", "volume"]][:4], table[["area", "volume"]][:4], rtol=0.05)


def test_recovered_dots_are_of_no_known_component():
    dots = sparsurf.surface((shell(), np.full(200, 1.9)), density=1.0)
    dots = replace(dots, fields={"component": np.arange(len(dots)), "b": np.ones(len(dots))})
    assert list(sparsurf.recover(dots, density=1.0).fields) == ["b"]


def test_components_are_numbered_by_their_dots():
    """Four spheres far apart, the largest of them third in the file."""
    centres, sizes = 40.0 * np.arange(4)[:, None] * [1.0, 0, 0], np.array([2.2, 1.5, 3.0, 1.2])
    component, table = sparsurf.components((centres, sizes))
    assert table["dots"].is_monotonic_decreasing and len(table) == 4
    dots = sparsurf.surface((centres, sizes))
    owner = np.abs(dots.points[:, 0][:, None] - centres[:, 0]).argmin(axis=1)
    assert [np.unique(component[owner == k]).tolist() for k in range(4)] == [[1], [2], [0], [3]]


@pytest.mark.parametrize("width", [1, 2])
def test_components_with_as_many_dots_are_numbered_in_the_order_of_their_atoms(width):
    """Equal spheres, or pairs of them, whose places are not in the order of the atoms; one atom is there twice."""
    starts = np.array([[80.0, 0, 0], [0, 0, 0], [40, 0, 0]])
    centres = (starts[:, None] + 2.0 * np.arange(width)[:, None] * [0, 0, 1.0]).reshape(-1, 3)
    given = np.vstack([centres[:1], centres]), np.append(1.0, np.full(len(centres), 1.7))
    surface, component, table = parts(*given)
    owner = np.abs(surface.points[:, :1] - starts[:, 0]).argmin(axis=1)
    assert np.ptp(table["dots"]) == 0 and np.array_equal(component, owner)
    assert surface.atom.min() == 1 and np.array_equal((surface.atom - 1) // width, owner)
