"""What jobs ask a cluster for: more than was measured, more with size, more after a failure."""

import re
import tracemalloc
from types import SimpleNamespace

import numpy as np
import pytest
import yaml

import measure_needs
from conftest import ROOT, WORKFLOW
from sparsurf import InputError
from sparsurf.study import tables
from sparsurf.study.grid import Grid
from sparsurf.study.prepared_surface import DOTS_PER_PUBLISHED_TEST
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow import needs
from sparsurf.workflow.needs import BYTES_PER_ATOM, BYTES_PER_DOT, DOTS_PER_ATOM

HERE = SimpleNamespace(protein="p", conformation="c1")


@pytest.fixture
def table(tmp_path, monkeypatch):
    (tmp_path / "needs.csv").write_text(
        "rule,unit,mb,mb_per_unit,seconds,seconds_per_unit\nwork,thousand dots,600,20,60,9\n"
    )
    monkeypatch.setattr(needs, "TABLE", tmp_path / "needs.csv")


@pytest.mark.parametrize(
    ("size", "attempt", "megabytes", "minutes"),
    [(0, 1, 1000, 10), (20, 1, 1500, 16), (20, 2, 3000, 32), (20, 3, 6000, 48), (1000, 1, 30900, 604)],
)
def test_jobs_ask_for_more_with_size_and_after_a_failure(table, size, attempt, megabytes, minutes):
    asked = needs.needs("work", lambda wildcards: size)
    assert (asked["mem_mb"](HERE, attempt), asked["runtime"](HERE, attempt)) == (megabytes, minutes)


def test_a_share_of_the_work_takes_less_time_but_the_memory_of_all(table):
    asked = needs.needs("work", lambda wildcards: 1000, 0.1)
    assert asked["mem_mb"](HERE, 1) == 30900 and asked["runtime"](HERE, 1) == 64


def test_what_does_not_follow_from_the_size_is_asked_for_besides(table):
    asked = needs.needs("work", lambda wildcards: 20, besides=lambda wildcards: 1000)
    assert (asked["mem_mb"](HERE, 1), asked["mem_mb"](HERE, 2)) == (3000, 6000)  # 1.5 (600 + 20 x 20 + 1000)
    assert asked["runtime"](HERE, 1) == 16


def grid(**evaluation):
    """A config of twelve combinations."""
    sampling = {"alpha": [0.5, 1.0], "beta": [0.0], "gamma": [0, 3, 6], "delta": [0, 6]}
    requests = {"test_dots": 400, "draws": 3, "readings": ["as_coded", "as_written"]}
    return {"sampling": sampling, "evaluation": requests | evaluation}


def test_the_distances_of_a_grid_grow_with_all_that_it_takes():
    one = 12 * 3 * 400 * 2 * 4  # combinations, draws, test dots, two distances of 4 bytes
    assert needs.memory_of_grid(grid()) == 6 * one  # two readings, and one four times in its mean
    assert needs.memory_of_grid(grid(readings=["as_coded"])) == 5 * one
    assert needs.memory_of_grid(grid(draws=300)) == 600 * one
    assert needs.memory_of_grid(grid(test_dots="published")) == 6 * one / 4  # N / 200 of 20,000 dots
    assert needs.memory_of_grid(grid(test_dots="published"), thousand_dots=160) == 12 * one
    assert needs.memory_of_grid(grid(), thousand_dots=160) == 6 * one


def test_memory_is_that_of_the_table_of_a_grid():
    """Counted by hand what becomes a table, the worst moment of the jobs that hold all distances."""
    shape = (2, 12, 20, 4000)  # readings, combinations, draws, test dots
    distances = [np.random.default_rng(seed).random(shape, np.float32) for seed in (0, 1)]
    own = Grid(
        combinations=np.ones((12, 4)),
        n_dots=10,
        n_s=np.ones((12, 20), int),
        n_s_expected=np.ones(12),
        tests=np.arange(4000),
        z_tot=np.ones((4000, 121)),
        z_ts=distances[0],
        z_tr=distances[1],
        fragment=np.ones((2, 2, 12)),
        readings=("as_coded", "as_written"),
    )
    tables.grid_table(own)  # whatever is loaded by the first call
    tracemalloc.start()
    tables.grid_table(own)
    used = tracemalloc.get_traced_memory()[1] + sum(each.nbytes for each in distances)
    tracemalloc.stop()
    assert used == pytest.approx(needs.memory_of_grid(grid(draws=20, test_dots=4000)), rel=0.1)


def test_two_grids_of_the_default_study_fit_into_a_small_machine():
    config = yaml.safe_load((ROOT / "config.yaml").read_text())
    distances = needs.memory_of_grid(config) / 1e6
    for rule in needs.measured():
        if rule != "simulate_stage":
            asked = needs.needs(rule, lambda wildcards: 28, besides=lambda wildcards: distances)
            assert 2 * asked["mem_mb"](HERE, 1) <= 4000, rule


def test_every_job_that_holds_all_distances_asks_for_them():
    rules = dict(re.findall(r"^ *rule (\w+):(.*?)(?=^\S|\Z)", WORKFLOW, re.M | re.S))
    holding = {name for name, rule in rules.items() if re.search(r"\bDISTANCES\b", rule)}
    assert holding == {"evaluate_grid", "tabulate_best"}
    for name in holding:
        assert f'needs("{name}", files.dots, besides=files.distances)' in rules[name]


def test_jobs_that_share_the_frames_ask_for_the_time_of_their_share():
    assert 'needs("follow_frames", files.megabytes(config["ensemble"]["stride"]), 1 / JOBS)' in WORKFLOW


def test_what_takes_seconds_is_not_worth_a_queue(tmp_path, monkeypatch):
    (tmp_path / "needs.csv").write_text(
        "rule,unit,mb,mb_per_unit,seconds,seconds_per_unit\nwork,MB of input,600,20,5,0.1\n"
    )
    monkeypatch.setattr(needs, "TABLE", tmp_path / "needs.csv")
    assert needs.is_small("work", 149) and not needs.is_small("work", 151)


def test_dots_are_guessed_from_the_size_of_the_files(tmp_path):
    (tmp_path / "a.pdb").write_bytes(bytes(BYTES_PER_ATOM * 1000))
    (tmp_path / "a.dms").write_bytes(bytes(BYTES_PER_DOT * 5000))
    (tmp_path / "a.dms.gz").write_bytes(bytes(BYTES_PER_DOT * 5000))
    assert needs.thousand_dots([tmp_path / "a.pdb"], False) == pytest.approx(DOTS_PER_ATOM)
    assert needs.thousand_dots([tmp_path / "a.dms"], True) == pytest.approx(5)
    assert needs.thousand_dots([tmp_path / "a.dms.gz"], True) == pytest.approx(20)
    assert needs.megabytes([tmp_path / "not yet there.pdb"]) == 0


def test_a_line_lies_above_all_that_was_measured():
    x, y = np.array([1.0, 2.0, 9.0, 10.0]), np.array([10.0, 14.0, 30.0, 28.0])
    base, slope = measure_needs.line_above(x, y, 7.0)
    assert (base + slope * x - y).min() == pytest.approx(0) and slope == pytest.approx(np.polyfit(x, y, 1)[0])
    assert measure_needs.line_above(np.array([1.0, 2.0]), np.array([5.0, 3.0]), 7.0) == (5.0, 0.0)


def test_jobs_of_one_size_tell_no_slope():
    assert measure_needs.line_above(np.array([2.0, 3.9]), np.array([4.0, 5.0]), 0.5) == (3.05, 0.5)
    assert measure_needs.line_above(np.array([2.0]), np.array([1.0]), 0.7) == (0.0, 0.7)


def test_needs_are_read_from_the_logs_of_runs(tmp_path):
    for name, n, used in (
        ("small", 1000, "USED 300 MB 5.0 s for 2.00 MB"),
        ("large", 3000, "USED 500 MB 7.0 s for 4.00 MB"),
    ):
        run = tmp_path / name
        for folder in (run / "logs" / "p" / "c1", run / "p" / "c1"):
            folder.mkdir(parents=True)
        failed = "USED 9000 MB 900.0 s for 2.00 MB"  # before it was tried again
        (run / "logs" / "p" / "c1" / "take_minimal.log").write_text(f"INFO said\n{failed}\n{used}\n")
        (run / "logs" / "p" / "c1" / "draw_view.log").write_text("killed before it could tell\n")
        (run / "logs" / "p" / "follow_frames_2of10.log").write_text(f"{used}\n")
        points = np.random.default_rng(0).normal(size=(n, 3))
        write_npz(run / "p" / "c1" / "surface.npz", Surface(points, np.tile([0.0, 0, 1], (n, 1))))
    pair = tmp_path / "large" / "logs" / "pairs" / "p"  # has no surface of its own, and no line in the table
    pair.mkdir(parents=True)
    (pair / "match_partners.log").write_text("USED 300 MB 5.0 s for 2.00 MB\n")
    (tmp_path / "needs.csv").write_text(
        "rule,unit,mb,mb_per_unit,seconds,seconds_per_unit\nfollow_frames,MB of input,1,1,1,1\n"
        "take_minimal,thousand dots,1,1,1,1\nsimulate_stage,ns,1000,0,600,9000\n"
    )
    measure_needs.main([tmp_path / "small", tmp_path / "large"], tmp_path / "needs.csv")
    assert (tmp_path / "needs.csv").read_text().splitlines() == [
        "rule,unit,jobs,mb,mb_per_unit,seconds,seconds_per_unit",
        "follow_frames,MB of input,2,100,100,30,10",
        "take_minimal,thousand dots,2,200,100,4,1",
        "simulate_stage,ns,0,1000,0,600,9000",  # in none of the runs
    ]


def test_lines_that_no_run_tells_anew_keep_their_jobs_and_slopes(tmp_path):
    (tmp_path / "logs" / "p").mkdir(parents=True)
    (tmp_path / "logs" / "p" / "choose_frames.log").write_text("USED 300 MB 50.0 s for 2.00 MB\n")
    table = tmp_path / "needs.csv"
    table.write_text(
        "rule,unit,jobs,mb,mb_per_unit,seconds,seconds_per_unit\nchoose_frames,MB of input,5,1,10,1,20\n"
        "simulate_stage,ns,4,1000,0,600,9000\n"
    )
    measure_needs.main([tmp_path], table)
    assert table.read_text().splitlines()[1:] == [
        "choose_frames,MB of input,1,280,10,10,20",
        "simulate_stage,ns,4,1000,0,600,9000",
    ]


@pytest.mark.parametrize(
    ("folders", "said"), [([], "(no folder given)"), (["mistyped"], "mistyped"), (["."], ".")]
)
def test_runs_that_tell_nothing_are_a_sentence(tmp_path, monkeypatch, folders, said):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "logs" / "p").mkdir(parents=True)
    (tmp_path / "logs" / "p" / "choose_frames.log").write_text("killed before it could tell\n")
    with pytest.raises(InputError, match=f"is in {re.escape(said)}: give results/"):
        measure_needs.main(folders, tmp_path / "needs.csv")
    assert not (tmp_path / "needs.csv").exists()


def test_every_rule_that_asks_is_measured_and_grouped():
    """The rules of the chain of a conformation are one job of the profile, and no name in it is misspelt."""
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "config.yaml").read_text())
    rows = needs.measured()
    assert all(f'needs("{rule}"' in WORKFLOW for rule in rows)
    grouped = {rule for rule, row in rows.items() if row["unit"] == "thousand dots"}
    assert set(profile["groups"]) == grouped


def test_a_job_of_a_cluster_has_its_needs_or_is_named_as_one_without():
    page = (ROOT / "docs" / "cluster.md").read_text()
    named = set(
        re.findall(
            r"`(\w+)`",
            page[page.index("Rules without a line") : page.index("ask for the `default-resources`")],
        )
    )
    rules = dict(re.findall(r"^ *rule (\w+):(.*?)(?=^ *rule |\Z)", WORKFLOW, re.M | re.S))
    sent = {name for name, rule in rules.items() if "script:" in rule and "localrule: True" not in rule}
    assert {name for name in sent if "**needs(" not in rules[name]} == named


def test_the_page_on_clusters_tells_what_the_profile_does():
    page = (ROOT / "docs" / "cluster.md").read_text()
    profile = yaml.safe_load((ROOT / "profiles" / "slurm" / "config.yaml").read_text())
    assert f"less than {needs.FEW_SECONDS} seconds" in page
    assert f"on up to {profile['local-cores']} cores" in page
    assert f"after {profile['slurm-init-seconds-before-status-checks']} seconds" in page
    lock = (ROOT / "envs" / "requirements-slurm.txt").read_text()
    plugin = re.search(r"^snakemake-executor-plugin-slurm==(\S+)", lock, re.M)[1]
    assert f"the Slurm plugin of the lock ({plugin})" in page


def test_as_many_test_dots_as_published_are_as_many_in_a_study():
    assert needs.DOTS_PER_TEST == DOTS_PER_PUBLISHED_TEST
