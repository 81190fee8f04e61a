"""Choice of conformations: superposition, principal components, k-means, silhouette."""

from dataclasses import replace

import mdtraj
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.spatial.transform import Rotation

from peptides import peptide, write
from sparsurf.errors import InputError
from sparsurf.molecules import conformations
from sparsurf.molecules.conformations import (
    choose_clusters,
    choose_frames,
    kmeans,
    principal_components,
    silhouettes,
    superpose,
)
from sparsurf.molecules.read_molecule import read_molecule


@pytest.fixture(scope="session")
def example(shared):
    return read_molecule(shared / "example" / "topology.pdb", shared / "example" / "trajectory.xtc")


@pytest.fixture
def moving(tmp_path):
    """A peptide of four residues in 12 frames: three groups of 6, 4 and 2 that differ by a bend."""
    one = read_molecule(write(tmp_path / "a.pdb", peptide()))
    bend = np.repeat([0.0, 3.0, 9.0], [6, 4, 2]) + np.tile([-0.1, 0.1], 6)
    xyz = np.repeat(one.xyz, 12, axis=0)
    xyz[:, 15:, 2] += bend[:, None]
    times = 2.0 * np.arange(12)
    return replace(one, xyz=xyz, time_ps=times, frame_number=10 * np.arange(12))


# --- superposition -------------------------------------------------------------------------------------


def test_superposed_copies_coincide():
    """Rotated and moved copies return to the first frame, a mirror image does not."""
    rng = np.random.default_rng(1)
    first = rng.normal(size=(30, 3)) * 10
    turns = Rotation.random(5, random_state=2).as_matrix()
    copies = np.array([first, *(first @ turn + rng.normal(size=3) * 50 for turn in turns)])
    assert np.abs(superpose(copies, slice(None)) - first).max() < 1e-11  # sums of 100 Å in float64
    assert np.abs(superpose(copies[1:], slice(5), first[:5]) - first).max() < 1e-10  # on what is given
    copies[2:4, :, :2] = 0.0  # on a line
    with pytest.raises(InputError, match="frame 2"):
        superpose(copies, slice(None))
    mirrored = np.array([first, first * (1, 1, -1)])
    assert np.abs(superpose(mirrored, slice(None))[1] - first).max() > 1
    distances = np.linalg.norm(np.diff(superpose(mirrored, slice(None)), axis=1), axis=2)
    assert np.allclose(distances[0], distances[1])


def test_superposition_on_some_atoms_agrees_with_scipy_and_mdtraj(example):
    """Two outside oracles; mdtraj works in float32, 1e-4 Å at 50 Å."""
    atoms = np.flatnonzero(example.name == "CA")
    moved = superpose(example.xyz[::200], atoms)
    first = example.xyz[0, atoms]
    for frame, result in zip(example.xyz[::200], moved, strict=True):
        centre = frame[atoms].mean(axis=0)
        turn, _ = Rotation.align_vectors(first - first.mean(axis=0), frame[atoms] - centre)
        assert np.allclose(result, turn.apply(frame - centre) + first.mean(axis=0), atol=1e-9)
    theirs = mdtraj.Trajectory(example.xyz[::200] / 10, example.topology).superpose(
        mdtraj.Trajectory(example.xyz[:1] / 10, example.topology), atom_indices=atoms
    )
    assert np.abs(theirs.xyz.astype(float) * 10 - moved).max() < 2e-4


# --- principal components ------------------------------------------------------------------------------


def test_components_of_a_known_motion():
    """Two atoms moving along known directions: variances 9:1, loadings positive."""
    t = np.linspace(-1, 1, 41)
    xyz = np.zeros((41, 2, 3))
    xyz[:, 0, 1] = -3 * t
    xyz[:, 1, 2] = np.where(np.arange(41) % 2, 1, -1) * np.abs(t)
    projection, explained = principal_components(xyz)
    variance = np.array([np.sum(9 * t**2), np.sum((xyz[:, 1, 2] - xyz[:, 1, 2].mean()) ** 2)])
    assert np.allclose(explained[:2], variance / variance.sum()) and np.allclose(explained[2:], 0)
    assert np.allclose(projection[:, 0], xyz[:, 0, 1])  # the largest loading is positive


@given(arrays(float, (12, 3, 3), elements=st.integers(-50, 50).map(float)))
@settings(max_examples=30)
def test_components_agree_with_the_covariance_matrix(xyz):
    projection, explained = principal_components(xyz)
    deviation = (xyz - xyz.mean(axis=0)).reshape(12, -1)
    values = np.linalg.eigvalsh(deviation.T @ deviation)[::-1]
    assert np.allclose((projection**2).sum(axis=0)[:9], values, atol=1e-8 * max(values.max(), 1))
    assert np.allclose(explained.sum(), float(values.max() > 1e-9))


# --- clusters ------------------------------------------------------------------------------------------


def blobs(rng, sizes, spread=0.2):
    centres = 10 * np.array([(np.cos(a), np.sin(a)) for a in 2 * np.pi * np.arange(len(sizes)) / len(sizes)])
    return np.concatenate([c + spread * rng.normal(size=(n, 2)) for c, n in zip(centres, sizes, strict=True)])


def test_kmeans_finds_separate_groups_and_ends_where_centroids_are_means():
    points = blobs(np.random.default_rng(3), [30, 20, 10])
    label, centroid, inertia = kmeans(points, 3, np.random.default_rng(4))
    groups = [set(label[:30]), set(label[30:50]), set(label[50:])]
    assert [len(each) for each in groups] == [1, 1, 1] and len(set.union(*groups)) == 3
    assert np.allclose(centroid[label[0]], points[:30].mean(axis=0))
    assert np.isclose(inertia, sum(np.sum((points[label == k] - centroid[k]) ** 2) for k in range(3)))
    points = np.random.default_rng(0).uniform(size=(400, 2))
    label, centroid, inertia = kmeans(points, 11, np.random.default_rng(4), restarts=1)
    assert np.allclose(centroid, [points[label == k].mean(axis=0) for k in range(11)])
    assert kmeans(points, 11, np.random.default_rng(4), restarts=1)[2] == inertia


def naive_silhouette(points, label):
    values = []
    for i in range(len(points)):
        distance = np.linalg.norm(points - points[i], axis=1)
        own = (label == label[i]) & (np.arange(len(points)) != i)
        if not own.any():
            values.append(0.0)
            continue
        a = distance[own].mean()
        b = min(distance[label == k].mean() for k in set(label) if k != label[i])
        values.append((b - a) / max(a, b) if max(a, b) > 0 else 0.0)
    return np.array(values)


@given(st.integers(0, 10_000), st.integers(2, 5), st.integers(6, 40))
@settings(max_examples=40)
def test_silhouettes_agree_with_the_definition(seed, n_clusters, n_points):
    rng = np.random.default_rng(seed)
    points = rng.integers(0, 6, size=(n_points, 2)).astype(float)  # with coinciding points
    labels = [np.append(np.arange(k), rng.integers(0, k, n_points - k)) for k in range(2, n_clusters + 1)]
    for found, label in zip(silhouettes(points, labels), labels, strict=True):
        assert np.allclose(found, naive_silhouette(points, label), atol=1e-12)


def test_silhouettes_do_not_depend_on_the_chunks(monkeypatch):
    points = np.random.default_rng(5).normal(size=(500, 2))
    label = np.random.default_rng(6).integers(0, 4, 500)
    whole = silhouettes(points, [label])
    monkeypatch.setattr("sparsurf.molecules.conformations.ROWS_AT_ONCE", 7)
    assert np.allclose(silhouettes(points, [label]), whole, atol=1e-13)


def test_result_for_one_k_does_not_depend_on_the_others():
    points = np.random.default_rng(7).normal(size=(80, 2))
    several, found = choose_clusters(points, [2, 3, 4, 5], np.random.default_rng(8))
    single, alone = choose_clusters(points, [4], np.random.default_rng(8))
    assert several.inertia[2] == single.inertia[0] and np.array_equal(found[4][0], alone[4][0])
    table, _ = choose_clusters(points, [1, 2, 3], np.random.default_rng(8))
    assert table.silhouette.isna().tolist() == [True, False, False]


# --- the choice ----------------------------------------------------------------------------------------


def test_example_gives_the_numbers_of_its_description(example):
    """The description of the embedded example: 55 and 22 %, mean silhouettes of K = 2..8 to two digits."""
    choice = choose_frames(example, rng=np.random.default_rng(1))
    assert np.round(choice.explained[:2], 2).tolist() == [0.55, 0.22]
    expected = [0.58, 0.56, 0.57, 0.55, 0.52, 0.53, 0.52]
    assert np.allclose(choice.silhouettes.silhouette[:7], expected, atol=0.0051)
    assert choice.silhouettes.K.tolist() == list(range(2, 12))
    table = choice.table
    assert table.conformation.tolist() == ["c1", "c2"] and table.population.sum() == 1001
    assert table.population.is_monotonic_decreasing
    assert table.time_ps.tolist() == table.frame.tolist()


def test_choice_does_not_depend_on_where_the_molecule_is(moving):
    """Every frame turned and moved: equal distances between frames, so equal clusters and representatives."""
    turns = Rotation.random(12, random_state=3).as_matrix()
    turned = replace(moving, xyz=moving.xyz @ turns + np.random.default_rng(2).normal(size=(12, 1, 3)) * 20)
    first, second = (choose_frames(each, rng=np.random.default_rng(1)) for each in (moving, turned))
    assert first.index.tolist() == second.index.tolist() and np.array_equal(first.label, second.label)


@pytest.mark.parametrize("other", [("CA", "CA", "CA", "other"), ("H1", "ALA", "H", "protein")])
def test_frames_are_compared_by_c_alphas_or_by_heavy_atoms(moving, other):
    """An ion that is called CA and a hydrogen move at random: the one beside all residues, the other beside two."""
    few = moving if other[3] == "other" else moving.take(moving.residue_index >= 2)
    labels = dict(zip(("name", "residue_name", "element", "kind"), other, strict=True))
    labels |= {"chain": "A", "residue": "9", "residue_index": few.n_residues, "b_factor": 0.0}
    added = {key: np.append(getattr(few, key), value) for key, value in labels.items()}
    place = np.random.default_rng(4).normal(0, 20, (12, 1, 3))
    more = replace(few, xyz=np.concatenate([few.xyz, place], axis=1), **added)
    one, two = (choose_frames(each, rng=np.random.default_rng(1)).projection for each in (few, more))
    assert np.array_equal(one, two)


def test_frames_of_a_file_are_those_in_memory(moving, tmp_path, monkeypatch):
    monkeypatch.setattr(conformations, "FRAMES_AT_ONCE", 5)
    stored = np.memmap(tmp_path / "frames", float, "w+", shape=moving.xyz.shape)
    stored[:] = moving.xyz
    one, two = (
        choose_frames(each, rng=np.random.default_rng(1)) for each in (moving, replace(moving, xyz=stored))
    )
    assert np.array_equal(one.projection, two.projection) and np.array_equal(one.label, two.label)


def test_conformations_are_ranked_by_population(moving):
    choice = choose_frames(moving, clusters=3, rng=np.random.default_rng(1))
    assert choice.table.conformation.tolist() == ["c1", "c2", "c3"]
    assert choice.table.cluster.tolist() == [1, 2, 3] and choice.table.population.tolist() == [6, 4, 2]
    assert choice.label.tolist() == [1] * 6 + [2] * 4 + [3] * 2
    assert choice.table.frame.tolist() == (10 * choice.index).tolist()
    assert choice.table.time_ps.tolist() == (2.0 * choice.index).tolist()
    assert np.array_equal(choice.table[["pc1", "pc2"]].to_numpy(), choice.projection[choice.index])
    assert choice.projection.mean(axis=0) == pytest.approx([0, 0], abs=1e-5)
    assert not np.signbit(choice.projection[choice.projection == 0]).any()  # no -0.0 in a table
    assert choice.index[2] == 10  # both frames of the pair are as near to their mean: the earlier


def test_auto_takes_the_best_silhouette_and_all_frames_may_be_one_cluster(moving):
    choice = choose_frames(moving, rng=np.random.default_rng(1))
    best = choice.silhouettes.K[choice.silhouettes.silhouette.argmax()]
    assert len(choice.table) == best
    assert choice.silhouettes.K.max() <= 11
    choice = choose_frames(moving, clusters=1, rng=np.random.default_rng(1))
    assert choice.table.population.tolist() == [12]


def test_up_to_eleven_clusters_are_tried_also_where_they_lie_near():
    rng = np.random.default_rng(1)
    apart = np.array([[100.0 * k, y] for k in range(11) for y in (0, 1, 2)])
    table, (label, chosen, _) = conformations._cluster(apart, "auto", rng)
    assert table.K.tolist() == list(range(2, 12)) and len(chosen) == 11
    assert np.bincount(label)[1:].tolist() == 11 * [3] and chosen.tolist() == list(range(1, 33, 3))
    for seed in range(6):  # whatever the order in which k-means numbers them
        sizes = np.random.default_rng(seed).permutation(4) + 2
        apart = np.array([[100.0 * k, y] for k, size in enumerate(sizes) for y in range(size)])
        _, (label, chosen, _) = conformations._cluster(apart, 4, np.random.default_rng(seed))
        assert np.bincount(label)[1:].tolist() == [5, 4, 3, 2] and label[chosen].tolist() == [1, 2, 3, 4]
    near = np.array([[x, y] for x in (0.0, 0.4) for y in (0.0, 0.01)])  # Å
    assert len(conformations._cluster(near, "auto", rng)[1][1]) == 2


def test_frames_by_name(moving):
    rng = np.random.default_rng(1)
    every = choose_frames(moving, frames="all", rng=rng)
    assert every.table.conformation.tolist()[:2] == ["f000", "f010"] and len(every.table) == 12
    listed = choose_frames(moving, frames=[110, 30, 110], rng=rng)
    assert listed.table.frame.tolist() == [110, 30] and listed.index.tolist() == [11, 3]
    assert (listed.label == 0).all() and listed.silhouettes.empty
    assert choose_frames(moving, frames=[30], rng=rng).table.conformation.tolist() == ["f030"]
    assert listed.table[["cluster", "population"]].to_numpy().tolist() == [[0, 1], [0, 1]]
    assert list(listed.silhouettes.columns) == ["K", "silhouette", "inertia"]
    clustered = choose_frames(moving, rng=rng)
    assert list(every.table.columns) == list(clustered.table.columns)
    tables = clustered.tables(moving.frame_number)
    assert tables["frames"] is clustered.table and tables["silhouette"] is clustered.silhouettes
    columns = np.column_stack([moving.frame_number, clustered.projection, clustered.label])
    assert [*tables["projection"]] == ["frame", "pc1", "pc2", "cluster"]
    assert tables["projection"].to_numpy().tolist() == columns.tolist()
    assert tables["explained"]["explained"].tolist() == clustered.explained.tolist()


@pytest.mark.parametrize(
    ("keys", "words"),
    [({"frames": [5]}, r"frames.selection: \[5\] are not among the frames read, 0 to 110 in steps of 10 \("),
     ({"frames": []}, "not among"), ({"clusters": 12}, "frames.clusters: 12 is neither auto nor 1 to"), ({"clusters": 0},
     "neither auto nor")],
)  # fmt: skip
def test_impossible_wishes_are_sentences(moving, keys, words):
    with pytest.raises(InputError, match=words):
        choose_frames(moving, rng=np.random.default_rng(1), **keys)


def test_few_frames(moving, caplog):
    """One or two frames are one conformation; three allow two clusters at most."""
    for count, most in ((1, 1), (2, 1), (3, 2)):
        few = replace(
            moving, xyz=moving.xyz[5 : 5 + count], time_ps=moving.time_ps[:count], frame_number=np.arange(count),
        )  # fmt: skip
        choice = choose_frames(few, rng=np.random.default_rng(1))
        assert len(choice.table) == most and (np.ptp(choice.projection) > 0) == (count > 1)
        with pytest.raises(InputError, match=f"1 to {most}"):
            choose_frames(few, clusters=most + 1, rng=np.random.default_rng(1))
    still = replace(few, xyz=few.xyz[[0, 0]], time_ps=few.time_ps[:2], frame_number=np.arange(2))
    with caplog.at_level("INFO", "sparsurf"):
        one = choose_frames(few.frame(0), rng=np.random.default_rng(1))
        choose_frames(still, rng=np.random.default_rng(1))
    assert one.projection.tolist() == [[0, 0]] and one.explained.tolist() == [0]
    pair = moving.take(np.array([4, 16]))  # two atoms, whose distance alone tells frames apart
    assert len(choose_frames(pair, rng=np.random.default_rng(1)).table) > 1
    assert caplog.messages == ["all 2 frames are the same: they are one conformation"]


def test_molecules_with_few_c_alphas(shared, tmp_path):
    choice = choose_frames(
        read_molecule(shared / "data" / "trajectories" / "ala2.h5"), rng=np.random.default_rng(1)
    )
    assert len(choice.table) >= 2 and choice.explained.sum() == pytest.approx(1)
    three = read_molecule(write(tmp_path / "a.pdb", peptide(3 * ["ALA"])))
    xyz = np.repeat(three.xyz, 4, axis=0)
    xyz[2:, three.name == "CB"] += 3.0
    moved = replace(three, xyz=xyz, time_ps=np.arange(4.0), frame_number=np.arange(4))
    assert len(choose_frames(moved, rng=np.random.default_rng(1)).table) == 1
