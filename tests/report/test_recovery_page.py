"""The page on recovered surfaces is what its tables say."""

from contextlib import contextmanager
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import measure_recovery
from conftest import ROOT
from peptides import peptide, write
from sparsurf.molecules.reading import read_molecule
from sparsurf.recovery.recovering import recover
from sparsurf.report import recovery_page
from sparsurf.study import opponents, recovery
from sparsurf.surfaces.making import molecular_surface
from sparsurf.surfaces.radii import radii


def test_the_stored_page_follows_from_the_stored_tables():
    tables = recovery_page.read(ROOT / "docs" / "tables")
    assert recovery_page.page(*tables) == (ROOT / "docs" / "recover.md").read_text(encoding="utf-8")
    rows = tables[2].set_index(["sampler", "percent", "measure"])["mean"]
    assert f"comes back {rows['farthest', 10.0, 'distance']:.3f} Å" in recovery_page.answer(tables[2])
    assert rows["farthest", 10.0, "Z"] < rows["farthest", 10.0, "Z_kept"]


@pytest.fixture
def measuring(monkeypatch):
    """The measurement without its work: what was asked of each protein, and the pairs that were compared."""
    sizes = {"small": 3000, "large": 3001, "most": 20_000, "huge": 20_001}
    given = [(name, np.zeros((n, 3)), np.ones(n)) for name, n in sizes.items()]
    asked, compared, one = {}, [], pd.DataFrame({"value": [1.0]})

    def subsets(name, *_, names, threads):
        asked.setdefault(name, []).append(names)
        return (pd.DataFrame({"protein": [name]}),) * 2

    def others(name, xyz, radii, simplify, *_, threads):
        asked.setdefault(name, []).append(simplify)
        samplers = [opponents.KEPT, opponents.ATOMS, *([opponents.MESH] if simplify else [])]
        return pd.DataFrame({"protein": name, "sampler": samplers})

    def paired(table, first, second):
        compared.append((table["protein"].unique().tolist(), first, second))
        return one

    monkeypatch.setattr(measure_recovery, "molecules", lambda _: given)
    monkeypatch.setattr(measure_recovery, "simplifier", lambda: "simplify")
    monkeypatch.setattr(measure_recovery.recovery, "measure", subsets)
    monkeypatch.setattr(opponents, "measure", others)
    monkeypatch.setattr(
        measure_recovery.recovery,
        "means",
        lambda table, measures=("all",): pd.DataFrame(
            {"value": [1.23456], "of": len(table), "measures": " ".join(measures)}
        ),
    )
    monkeypatch.setattr(measure_recovery.recovery, "paired", paired)
    monkeypatch.setattr(measure_recovery.recovery_page, "read", lambda _: ())
    monkeypatch.setattr(measure_recovery.recovery_page, "page", lambda: "")
    monkeypatch.setattr(measure_recovery, "_draw", lambda *_: None)
    return asked, compared


def test_large_molecules_have_fewer_samplers_and_no_mesh(measuring, tmp_path):
    asked, compared = measuring
    names = measure_recovery.recovery.NAMES
    for _ in range(2):  # what is in the tables is not measured again
        measure_recovery.main("folder", tmp_path / "tables", 1, None)
        assert asked == {
            "small": [names, "simplify"],
            "large": [names, None],
            "most": [names, None],
            "huge": [("farthest",), None],
        }
    means, beside = (
        pd.read_csv(tmp_path / "tables" / f"recover{key}.csv").to_numpy().tolist()
        for key in ("_means", "_opponents_means")
    )
    assert means == [[1.235, 4, "all"]]
    assert beside == [[1.235, 2, "bytes Z distance angle"]]  # those with a mesh, without the atoms
    # the ways at equal bytes are compared where there was a mesh
    every = ["small", "large", "most", "huge"]
    assert compared[:6] == [
        (every, "adaptive", "farthest"),
        (every, "roughness", "uniform"),
        (["small"], opponents.SETTLED, opponents.KEPT),
        (["small"], opponents.SPARSE, opponents.KEPT),
        (["small"], opponents.MESH, opponents.KEPT),
        (["small"], opponents.CORNERS, opponents.KEPT),
    ]


def test_without_the_program_that_simplifies_large_molecules_are_settled_all_the_same(
    measuring, tmp_path, monkeypatch
):
    monkeypatch.setattr(measure_recovery, "simplifier", lambda: None)
    measure_recovery.main("folder", tmp_path / "tables", 1, None)
    assert {name: len(calls) for name, calls in measuring[0].items()} == {
        "small": 1, "large": 2, "most": 2, "huge": 2,
    }  # fmt: skip


def test_structures_of_a_folder_come_by_their_size(tmp_path):
    write(tmp_path / "a.pdb", peptide(8 * ("ALA",)))
    write(tmp_path / "b.ent", peptide())
    write(tmp_path / "c.pdb", "nothing")
    write(tmp_path / "d.txt", peptide())
    found = [(name, xyz.shape) for name, xyz, _ in measure_recovery.molecules(tmp_path)]
    assert found == [("b", (20, 3)), ("a", (40, 3))]


def test_a1_has_a_row_for_each_way_with_what_a_million_dots_cost(tmp_path, monkeypatch):
    @contextmanager
    def pool(*_, **__):
        yield SimpleNamespace(submit=lambda call, *given: SimpleNamespace(result=lambda: call(*given)))

    rows = [
        {"sampler": name, "n_S": n, "bytes": 9} for n, name in enumerate((opponents.KEPT, opponents.SETTLED))
    ]
    monkeypatch.setattr(measure_recovery, "read_molecule", lambda _: SimpleNamespace(xyz=["places"]))
    monkeypatch.setattr(measure_recovery, "radii", lambda molecule, table: table)
    monkeypatch.setattr(measure_recovery, "ProcessPoolExecutor", pool)
    monkeypatch.setattr(measure_recovery, "copies_of_a_tenth", lambda *given: given)
    monkeypatch.setattr(measure_recovery, "cost", lambda *given: {"of": " and ".join(given)})
    monkeypatch.setattr(
        measure_recovery.recovery,
        "measure",
        lambda *_, names, **__: (None, pd.DataFrame({"sampler": names, "n_S": 7})),
    )
    monkeypatch.setattr(opponents, "measure", lambda *_, **__: pd.DataFrame(rows))
    measure_recovery.measure_a1("a1.pdb", tmp_path, 1)
    # settled dots beside the farthest ones, which stand there already
    assert pd.read_csv(tmp_path / "recover_a1.csv").to_dict("list") == {
        "sampler": ["farthest", "adaptive", "settled dots"],
        "n_S": [7, 7, 1],
        "of": 3 * ["places and dms"],
    }


def test_copies_have_the_wished_dots_in_all_and_lie_apart():
    one = molecular_surface(np.zeros((1, 3)), np.array([4.0]))
    tenth = len(one) // 10
    points, normals = measure_recovery.copies_of_a_tenth(np.zeros((1, 3)), np.array([4.0]), 2 * len(one) + 1)
    assert len(points) == len(normals) == 3 * tenth
    first, second, third = points.reshape(3, tenth, 3)
    assert second[:, 0].min() - first[:, 0].max() == pytest.approx(10)
    assert third - second == pytest.approx(second - first)
    assert normals.reshape(3, tenth, 3) == pytest.approx(np.array(3 * [first / 4]), abs=1e-6)


def test_the_figure_shows_a_tenth_of_the_dots_and_how_far_what_they_give_is_off(tmp_path, monkeypatch):
    monkeypatch.setattr(
        measure_recovery, "EXAMPLE", write(tmp_path / "a.pdb", peptide(6 * ("ALA",)) + "END\n")
    )
    drawn = []
    monkeypatch.setattr(
        measure_recovery.recovered,
        "figure",
        lambda *given: drawn.append(given) or SimpleNamespace(savefig=lambda *_, **__: None),
    )
    measure_recovery._draw(tmp_path / "a.png", 1)
    ((whole, kept, dense, gap, words),) = drawn
    molecule = read_molecule(tmp_path / "a.pdb")
    xyz, sizes = molecule.xyz[0], radii(molecule, "dms")
    assert np.array_equal(whole[0], molecular_surface(xyz, sizes).points)
    assert len(kept[0]) == len(kept[1]) == len(whole[0]) // 10
    assert np.array_equal(dense[0], recover(*kept)[0])
    assert np.array_equal(gap, recovery.distances(dense[0], recovery.truth(xyz, sizes)))
    assert words == [
        f"The surface: {len(whole[0])} dots",
        f"A tenth of them, with normals:\n{len(kept[0])} dots",
        f"The surface recovered from these alone\n(mean distance {gap.mean():.3f} Å)",
    ]


def test_a_million_recovered_dots_are_paid_for(monkeypatch):
    # 500 dots in two seconds, for which 1000 bytes are needed
    monkeypatch.setattr(measure_recovery, "recover", lambda points, normals: (np.zeros((500, 3)), None))
    monkeypatch.setattr(measure_recovery, "peak_memory", iter([4000, 5000]).__next__)
    clock = SimpleNamespace(process_time=iter([1.0, 3.0]).__next__)
    monkeypatch.setattr(measure_recovery, "time", clock)
    points = np.zeros((50, 3))
    assert measure_recovery.cost(points, points) == {"a_million_s": 4000, "bytes_per_dot": 2}


def test_a_change_counts_where_its_interval_leaves_zero():
    row = {"first": "a", "second": "b", "measure": "Z", "n": 5}
    pairs = pd.DataFrame(
        [
            row | {"percent": 5.0, "mean": -4.0, "low": -6.0, "high": -1.0},
            row | {"percent": 10.0, "mean": 2.0, "low": -1.0, "high": 5.0},
            row | {"percent": 20.0, "mean": 3.0, "low": 1.0, "high": 5.0},
        ]
    )
    assert "a instead of b: lower Z at 5 % and higher Z at 20 %." in recovery_page.paying(pairs)


def test_a_row_of_each_table():
    ends = {"low": 0.1, "high": 0.3, "n": 7, "sampler": "farthest"}
    means = pd.DataFrame(
        [
            ends | {"percent": p, "measure": measure, "mean": mean}
            for p in (2.5, 5.0, 10.0)
            for measure, mean in (("Z_over_floor", 1.1), ("Z", 0.5), ("Z_kept", 2.0), ("distance", 0.15))
        ]
    )
    assert recovery_page.answer(means).splitlines()[0] == (
        "- From 10 % of the dots the surface comes back 0.150 Å from the true one. Its Z is 0.50, 1.10 (0.10 to 0.30) times "
        "that of other dots of the same surface; the kept dots as they are have Z = 2.00."
    )
    matrix = recovery_page._matrix(means)
    assert "| Z, the dots as they are | 2.00 (0.10 to 0.30) |" in matrix
    assert "| distance to the true surface, Å | 0.150 (0.100 to 0.300) |" in matrix
    table = pd.DataFrame(
        [("b", "farthest", 5.0, 900, 0.7), ("a", "farthest", 5.0, 800, 0.6), ("a", "uniform", 5.0, 800, 9.9)],
        columns=["protein", "sampler", "percent", "N", "Z"],
    )
    floors = pd.DataFrame(
        [("a", "fresh dots", 0.25), ("b", "fresh dots", 0.5), ("a", "turned", 9.9)],
        columns=["protein", "floor", "Z"],
    )
    over = pd.DataFrame({"settled dots": {"a": 1.051, "b": float("nan")}})
    assert recovery_page._each(table, floors, over).splitlines() == [
        "| structure | N | fresh dots | Z at 5 % | settled dots, 10 %, over fresh |",
        "| --- | --- | --- | --- | --- |",
        "| b | 900 | 0.50 | 0.70 |  |",
        "| a | 800 | 0.25 | 0.60 | 1.05 |",
    ]


def test_a_goal_is_met_where_every_value_of_it_is():
    a1 = recovery_page.read(ROOT / "docs" / "tables")[-1]
    own = a1["sampler"] == "farthest"
    a1.loc[own, "Z"] = a1.loc[own, "percent"].map({2.5: 0.75, 5.0: 0.59, 10.0: 0.52})
    a1.loc[own & (a1["percent"] == 5.0), "distance"] = 0.0804
    ends = {
        0: "Z: 0.750 at 2.5 % (goal 0.75), 0.590 at 5 % (goal 0.6), 0.520 at 10 % (goal 0.53): met.",
        1: "distance Å: 0.080 at 5 % (goal 0.08): not met.",
        -1: "(goal 2), the kernels being compiled: met.",
    }
    lines = said_of(a1.assign(bytes_per_dot=399.0, a_million_s=2.0))
    assert all(lines[k].endswith(words) for k, words in ends.items())
    assert "399 bytes for a recovered dot (goal 400): met;" in lines[-1] and "2.0 CPU seconds" in lines[-1]
    a1.loc[own & (a1["percent"] == 5.0), "Z"] = 0.61
    lines = said_of(a1.assign(bytes_per_dot=400.0, a_million_s=2.1))
    assert lines[0].endswith("(goal 0.53): not met.") and lines[-1].endswith("compiled: not met.")
    assert "400 bytes for a recovered dot (goal 400): not met;" in lines[-1]


def said_of(a1):
    return [line for line in recovery_page.goals(a1).splitlines() if line.startswith("- ")]


def test_a_structure_is_held_to_its_own_floor():
    columns = ["protein", "sampler", "percent", "Z"]
    table = [("a", "farthest", 10.0, 0.525), ("b", "farthest", 10.0, 0.55), ("a", "farthest", 5.0, 9.0)]
    table += [("a", "adaptive", 10.0, 0.54), ("b", "adaptive", 10.0, 0.4)]
    settled = pd.DataFrame([("a", "settled dots", 10.0, 0.6)], columns=columns)
    floors = [
        ("a", "fresh dots", 0.5, 0.4, 0.6),
        ("b", "fresh dots", 0.5, 0.44, 0.55),
        ("b", "turned", 0.1, 0.1, 0.1),
    ]
    floors = pd.DataFrame(floors, columns=["protein", "floor", "Z", "low", "high"]).assign(draws=3)
    over = recovery_page.over_floor(pd.DataFrame(table, columns=columns), floors, settled)
    assert over.loc["b"].round(3).tolist()[:2] == [1.1, 0.8] and over.loc["a", "settled dots"] == 1.2
    said = "Z at 10 % is at most 1.08 times the fresh-dots floor on"
    assert recovery_page.everywhere(over, floors).splitlines() == [
        f"- farthest: {said} 1 of 2 structures; the most is 1.100 (b; 1.00 to 1.25 by the error of its floor, of 3 draws): not "
        "met.",
        f"- adaptive: {said} 2 of 2 structures; the most is 1.080 (a; 0.90 to 1.35 by the error of its floor, of 3 draws): met.",
        f"- settled dots: {said} 0 of 1 structures; the most is 1.200 (a; 1.00 to 1.50 by the error of its floor, of 3 draws): "
        "not met.",
    ]


def test_what_distances_and_angles_hold_beside_the_error_is_told():
    table = pd.DataFrame(
        [
            ("farthest", 5.0, 40, 1000),
            ("farthest", 5.0, 60, 1000),
            ("farthest", 10.0, 90, 1000),
            ("uniform", 5.0, 900, 1000),
        ],
        columns=["sampler", "percent", "n_S", "dots"],
    )
    opponents = pd.DataFrame(
        [("atoms", 2.0), ("atoms", 3.0), ("settled dots", 9.0)], columns=["sampler", "angle"]
    )
    said = recovery_page.errors(table, opponents)
    assert "surface: 5, 9 % at 5, 10 % of the dots;" in said
    assert "gives 2.5° (2.0 to 3.0):" in said
