"""The benchmark runs, and what is done for speed changes nothing. How fast it is is not asserted."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

import bench
import sparsurf
from sparsurf.sampling import published
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf.study import grid
from sparsurf.study.prepared_surface import PreparedSurface


def test_quick_run_writes_every_kind_of_figure(tmp_path, monkeypatch):
    (tmp_path / "others.py").write_text("def norms(patch):\n    return (patch[:, 3:6] ** 2).sum(axis=1)\n")
    monkeypatch.chdir(tmp_path)
    bench.main(tmp_path / "new" / "bench.json", quick=True, reference="others:norms")
    content = json.loads((tmp_path / "new" / "bench.json").read_text())
    assert content["machine"]["cores"] >= 1
    table = (tmp_path / "new" / "bench.md").read_text()
    for words in (
        "roughness",
        "one sampling",
        "5% kept, `full`",
        "grid of",
        "every dot",
        "nearest patches",
        "per atom",
        "warm start",
        "a frame of an ensemble",
    ):
        rows = [row for row in content["figures"] if words in row["what"]]
        assert rows and all(row["value"] > 0 for row in rows), words
        assert words in table
    assert any(row["what"] == "ratio" for row in content["figures"])
    value = {row["what"]: row["value"] for row in content["figures"]}
    n = next(row["dots"] for row in content["figures"] if row["what"] == "roughness per dot")
    assert value["roughness per dot"] == pytest.approx(1e6 * value["roughness of all dots"] / n)
    assert value["one sampling per dot"] == pytest.approx(1e6 * value["one sampling"] / n)
    theirs, in_one_pass = value["a patch by others:norms"], value["a descriptor, 100% kept, `full`"]
    assert value["ratio"] == pytest.approx(theirs / value["the same patches here"])
    assert value["ratio, 64 subsets in one pass"] == pytest.approx(theirs / in_one_pass)
    # the promise is one for the dots of A1, not for a piece, and on memory one for a million of them
    promised = {row["what"]: row["at_most"] for row in content["figures"]}
    names = ("roughness of all dots", "one sampling", "peak memory above the imports")
    assert [promised[name] for name in names] == [None, None, None]


def test_time_is_counted_per_piece_of_work(monkeypatch):
    monkeypatch.setattr("measures.timing.timed", lambda run, repeats: (1.0, 1.0))
    table = bench.Table()
    surface = bench.a1(True)
    bench.measure_dots(table, surface, False, 1, 16, published.parameter_grid(*bench.SMALL_GRID)[:2])
    bench.measure_surface(table, (2,), 1, bench.QUICK_RESIDUES)
    bench.measure_frames(table, True)
    value, atoms = (
        {row["what"]: row["value"] for row in table.rows},
        len(bench.embedded(bench.QUICK_RESIDUES)[1]),
    )
    assert value["one sampling"] == value["one sampling and a uniform subset"] == 1e3 / 2
    assert value["one sampling per dot"] == pytest.approx(1e9 / 2 / len(surface))
    assert value["a descriptor, 20% kept, `kept`"] == pytest.approx(1e6 / 16 / 64)
    assert value["a rotation-robust descriptor, 20% kept, `kept`"] == pytest.approx(1e6 / 2 / 64)
    assert value[f"surface per atom, {2 * atoms} atoms"] == pytest.approx(1e6 / (2 * atoms))
    assert value[f"a frame of an ensemble, {atoms} atoms"] == pytest.approx(1 / 3)


def test_another_program_is_timed_patch_by_patch(tmp_path, monkeypatch):
    (tmp_path / "norms.py").write_text("def first(patch):\n    return patch[0]\n")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("measures.timing.timed", lambda run, repeats: (2.0, 2.0))
    monkeypatch.setattr(bench, "timed", lambda run, repeats: (3.0, 3.0))
    table = bench.Table()
    table.add("a descriptor, 100% kept, `full`", 1, 0.5, "µs")
    bench.measure_reference(table, bench.a1(True), "norms:first")
    assert {row["what"]: row["value"] for row in table.rows[1:]} == {
        "a patch by norms:first": 3e6 / 5,
        "the same patches here": 2e6 / 1000,  # each of the five 200 times
        "ratio": 300,
        "ratio, 64 subsets in one pass": 1.2e6,
    }


def test_figures_are_divided_by_those_of_the_last_release(tmp_path, monkeypatch):
    (tmp_path / "bench.csv").write_text("what,dots,value,wall\nindex,10,2,4\nstudy,,,8\nother,,1,1\n")
    monkeypatch.setattr(bench, "RELEASED", tmp_path / "bench.csv")
    names, cells = ("what", "dots", "value", "wall"), [("index", 10, 3.0, 4.0), ("index", 20, 3.0, 4.0)]
    rows = [dict(zip(names, row, strict=True)) for row in [*cells, ("study", None, None, 4.0)]]
    assert bench.ratios_to_release(rows) == {"index, 10 dots": 1.5, "study": 0.5}


def test_memory_of_a_ribosome_is_that_of_its_dots(monkeypatch):
    found = {"atoms": 10, "dots": 200, "bytes": 5000, "seconds": {"index": (1.0, 2.0)}}
    monkeypatch.setattr(bench, "in_child", lambda call: found)
    table = bench.Table()
    bench.measure_ribosome(table)
    assert [list(row.values()) for row in table.rows] == [
        ["ribosome of 10 atoms: index", 200, 1.0, 2.0, "s", None],
        ["ribosome: peak memory", 200, 25, None, "bytes per dot", None],
    ]


def test_memory_is_counted_from_the_imports_on(monkeypatch, capsys):
    monkeypatch.setattr(bench, "warm_up", lambda: None)
    monkeypatch.setattr(bench, "peak_memory", iter([1000, 5000]).__next__)
    monkeypatch.setattr(bench.grid, "evaluate_grid", lambda *_: None)
    bench.print_memory(2, True)
    assert json.loads(capsys.readouterr().out) == {"dots": 2 * len(bench.a1(True)), "bytes": 4000}


def test_jobs_side_by_side_fill_their_time_once(tmp_path):
    # 10 s of one job, 5 s of which another one runs too, which goes on for 5 s; then 5 s of nothing
    for output, (rule, begin, end) in enumerate([("one", 4, 10), ("one", 0, 6), ("two", 5, 15)]):
        record = {"rule": rule, "log": [f"{rule}.log"], "starttime": begin, "endtime": end}
        (tmp_path / str(output)).write_text(json.dumps(record))
    table = bench.Table()
    metadata = SimpleNamespace(rglob=lambda names: sorted(tmp_path.rglob(names)))
    bench.measure_rules(table, metadata, 20.0)
    assert {row["what"]: row["wall"] for row in table.rows} == {
        "rule one, 1 job": 10,
        "rule two, 1 job": 10,
        "share of the study in which jobs run": 75,
    }


def test_every_job_of_a_script_loads_its_libraries(tmp_path, monkeypatch):
    monkeypatch.setattr(bench, "timed", lambda run, repeats: (None, 3.0))
    for k in (1, 2):
        record = {"rule": "compute_surface", "log": [f"{k}.log"], "starttime": k, "endtime": k + 5}
        (tmp_path / str(k)).write_text(json.dumps(record))
    table = bench.Table()
    bench.measure_rules(table, tmp_path, 10.0)
    assert [(row["what"], row["wall"]) for row in table.rows] == [
        ("rule compute_surface, 2 jobs", 10),
        ("rule compute_surface, its libraries", 6),
        ("share of the study in which jobs run", 60),
    ]


def test_a_reference_that_is_not_there_is_one_sentence():
    with pytest.raises(sparsurf.InputError, match="give module:function"):
        bench.measure_reference(bench.Table(), bench.a1(True), "no_such_module:f")


def test_lattice_keeps_the_copies_apart():
    xyz = np.random.default_rng(0).normal(size=(50, 3))
    copies = bench.lattice(xyz, 5).reshape(5, 50, 3)
    assert np.allclose(copies - copies[:, :1], xyz - xyz[0])
    assert np.allclose(copies[1] - xyz, [0, 0, np.ptp(xyz[:, 2]) + bench.GAP])
    lows, highs = copies.min(axis=1), copies.max(axis=1)
    for a in range(5):
        for b in range(a):
            assert np.maximum(lows[a] - highs[b], lows[b] - highs[a]).max() >= bench.GAP - 1e-9


def test_blocks_of_random_numbers_change_no_draw(blob, monkeypatch):
    surface = PreparedSurface(
        SimpleNamespace(points=blob[0], normals=blob[1]), Settings(patches={"d_link": 0.8})
    )
    combination = (0.7, 0.2, 2.0, 2.0)
    whole = published.sample(surface.cover, combination, np.random.default_rng(5))
    for block in (1, 100, 3333):
        monkeypatch.setattr(published, "PAIRS_PER_BLOCK", block)
        assert np.array_equal(published.sample(surface.cover, combination, np.random.default_rng(5)), whole)


def test_more_draws_than_fit_in_a_pass_are_each_evaluated(blob):
    # 70 draws are two passes; every distance is that of its own pair
    surface = PreparedSurface(
        SimpleNamespace(points=blob[0], normals=blob[1]),
        Settings(patches={"d_link": 0.8}),
        streams=Streams(3, "blob"),
    )
    combinations = np.array([[0.3, 0.0, 2.0, 0.0], [0.9, 0.2, 0.0, 2.0]])
    result = grid.evaluate_grid(surface, combinations, 5, 70)
    for k, draw in ((0, 0), (0, 69), (1, 7), (1, 63)):
        pair = surface.pair(combinations[k], draw)
        assert result.n_s[k, draw] == len(pair[0])
        for r, reading in enumerate(result.readings):
            z, sizes = surface.distances(pair, result.tests, result.z_tot, reading)
            assert np.allclose(z, [result.z_ts[r, k, draw], result.z_tr[r, k, draw]], rtol=1e-6)
            if draw == 69:
                assert sizes.shape == (2, 5)


def test_expected_numbers_do_not_depend_on_company_or_order(blob):
    surface = PreparedSurface(
        SimpleNamespace(points=blob[0], normals=blob[1]), Settings(patches={"d_link": 0.8})
    )
    grid = published.parameter_grid([0.2, 1.0], [0.0, 0.7], [0, 3], [0, 5])
    together = published.expected_n_s(surface.cover, grid)
    assert np.array_equal(published.expected_n_s(surface.cover, grid[::-1])[::-1], together)
    assert [published.expected_n_s(surface.cover, [row])[0] for row in grid] == together.tolist()
