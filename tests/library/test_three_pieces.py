"""Chains, parts and patches of a molecule of three chains far apart: with two, the second would also be the last."""

import numpy as np
import pytest
from scipy.spatial import cKDTree

import sparsurf
from peptides import peptide, write

CHAINS = {"A": ("ALA", "SER", "LYS", "VAL"), "B": ("ALA", "SER"), "C": ("SER", "ALA", "CYS")}
PLACES = {"A": (0, 0, 0), "B": (0, 25, 0), "C": (0, 0, 30)}
FIRST = {"A": 1, "B": 5, "C": 2}


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    parts = [peptide(names, chain, FIRST[chain], PLACES[chain]) for chain, names in CHAINS.items()]
    return write(tmp_path_factory.mktemp("three") / "three.pdb", "TER\n".join(parts) + "END\n")


@pytest.fixture(scope="module")
def dots(path):
    return sparsurf.surface(path, density=12)


def chain_of(points):
    """The chain next to each point."""
    places = {chain: np.add(place, (4, 1, 0)) for chain, place in PLACES.items()}
    distance = [np.linalg.norm(points - place, axis=1) for place in places.values()]
    return np.array([*places])[np.argmin(distance, axis=0)]


def test_chains_and_residues_are_chosen_by_their_names(path):
    whole = sparsurf.read_molecule(path)
    rows = [(c, str(FIRST[c] + k), name) for c, names in CHAINS.items() for k, name in enumerate(names)]
    table = whole.residues[["chain", "residue", "residue_name"]]
    assert [*map(tuple, table.to_numpy().tolist())] == rows
    for chosen in ("A", "B", "C", "A,C"):
        own = sparsurf.read_molecule(path, chains=chosen)
        assert own.xyz[0].tolist() == whole.xyz[0][np.isin(whole.chain, chosen.split(","))].tolist()
    some = sparsurf.read_molecule(path, residues="A:2,B:6,C:2-3").residues
    assert [*zip(some["chain"], some["residue"], strict=True)] == [
        ("A", "2"),
        ("B", "6"),
        ("C", "2"),
        ("C", "3"),
    ]


def test_each_piece_has_the_surface_that_it_has_alone(path, dots):
    component, table = sparsurf.components(dots)
    assert len(table) == 3 and not table["cavity"].any() and table["area"].is_monotonic_decreasing
    chain = dots.to_frame()["chain"].to_numpy()
    assert np.array_equal(chain, chain_of(dots.points))
    for name in CHAINS:
        alone = sparsurf.surface(sparsurf.read_molecule(path, chains=name), density=12)
        (number,) = set(component[chain == name])
        assert alone.area.sum() == pytest.approx(dots.area[chain == name].sum(), rel=1e-3)
        assert table["area"][number] == pytest.approx(alone.area.sum(), rel=1e-3)
        assert table["volume"][number] == pytest.approx(sparsurf.components(alone)[1]["volume"][0], rel=1e-2)


def test_residues_of_each_chain_have_their_own_dots(dots):
    frame = dots.to_frame().assign(roughness=sparsurf.roughness(dots))
    found = sparsurf.residues(dots)
    exact = sparsurf.areas(dots.molecule).residues["excluded"]
    for row, area in zip(found.itertuples(), exact, strict=True):
        own = frame[(frame["chain"] == row.chain) & (frame["residue"] == row.residue)]
        assert (row.dots, row.area, row.mean_roughness) == pytest.approx(
            (len(own), area, own["roughness"].mean())
        )
        assert row.area == pytest.approx(own["area"].sum(), rel=0.1)
    assert found["dots"].sum() == len(dots)


def test_kept_dots_stand_for_their_own_piece_and_all_pieces_are_reconstructed(dots):
    few = sparsurf.minimal(dots, percent=15)
    of_few, of_all = chain_of(few.surface.points), chain_of(dots.points)
    dense = sparsurf.recover(few)
    distance = cKDTree(dense.points).query(dots.points)[0]
    for name in CHAINS:
        assert few.table["weight"].to_numpy()[of_few == name].sum() == (of_all == name).sum()
        assert distance[of_all == name].mean() < 0.4
    kept = sparsurf.points(dots.molecule, 90)
    share = [(chain_of(kept.points) == name).mean() for name in CHAINS]
    assert share == pytest.approx(
        [dots.area[of_all == name].sum() / dots.area.sum() for name in CHAINS], abs=0.05
    )


def test_a_mesh_has_three_closed_pieces(dots):
    mesh = sparsurf.mesh(dots, density=3)
    edges = np.sort(mesh.triangles[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2), axis=1)
    sides, count = np.unique(edges, axis=0, return_counts=True)
    assert (count == 2).all() and len(mesh.vertices) - len(sides) + len(mesh.triangles) == 2 * 3
