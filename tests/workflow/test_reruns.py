"""Results follow inputs, parameters and code: what runs again in the finished small study after a change."""

import os
import shutil

import pytest
import yaml

from small_study import changed, copy_of, planned_rules

COMPUTE = {"compute_surface", "measure_roughness", "measure_floors", "evaluate_grid", "select_minimal_subset"}


@pytest.fixture(scope="module")
def config(study):
    return yaml.safe_load((study / "config.yaml").read_text())


@pytest.fixture
def own(study, tmp_path):
    """A copy of the study whose files may be deleted and replaced."""
    return copy_of(study, tmp_path / "own")


def test_a_finished_study_has_nothing_to_do(study, config):
    assert planned_rules(study, config) == set()


@pytest.mark.parametrize(
    ("file", "again", "untouched"),
    [
        ("topology.pdb", "choose_frames", {"choose_single_frame", "read_surface"}),
        ("trajectory.xtc", "choose_frames", {"choose_single_frame", "read_surface"}),
        ("still.pdb", "choose_single_frame", {"choose_frames", "read_surface"}),
        ("ready.npz", "read_surface", {"choose_frames", "compute_surface"}),
        ("scores.csv", "select_minimal_subset", {"compute_surface", "measure_floors"}),
        ("one.pdb", "compute_partner_surfaces", {"choose_frames", "compute_surface"}),
    ],
)
def test_an_input_file_runs_again_what_follows_from_it(own, config, file, again, untouched):
    content = (own / file).read_bytes()
    (own / file).unlink()
    (own / file).write_bytes(content + b"\n")
    planned = planned_rules(own, config)
    assert again in planned and not untouched & planned


@pytest.mark.parametrize(
    ("file", "rule"),
    [
        ("moving/frames.csv", "choose_frames"),
        ("still/structures", "choose_single_frame"),
        ("still/f0/components.csv", "compute_surface"),
        ("moving/f0700/distances.npz", "evaluate_grid"),
        ("moving/f0700/figures/roughness.svg", "draw_figures"),
        ("pairs/files/book.png", "draw_pair"),
        ("changes/bend/changed_2.pdb", "compare_forms"),
        ("failures.csv", "close_run"),
    ],
)
def test_a_deleted_result_is_made_again(own, config, file, rule):
    path = own / "results" / "small" / file
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    assert rule in planned_rules(own, config)


def test_code_that_draws_runs_again_figures_and_pages_alone(study, config):
    planned = planned_rules(study, config, REPORT="another")
    drawn = {"draw_frames", "draw_figures", "draw_view", "draw_ensemble", "draw_pair", "draw_changes"}
    assert drawn | {"close_run"} <= planned
    assert not planned & (COMPUTE | {"choose_frames", "follow_frames", "tabulate_residues"})


def without_frames(config):
    """Return the config of the molecules that have one frame: all of their jobs are known before any runs."""
    kept = {key: value for key, value in config.items() if key != "changes"}
    kept["proteins"] = {name: config["proteins"][name] for name in ("still", "ready")}
    return kept | {"pairs": {"files": config["pairs"]["files"]}}


def test_code_that_computes_runs_again_what_computes(study, config):
    again = {"choose_single_frame", "read_surface", "compute_partner_surfaces", "follow_frames"}
    few = without_frames(config)
    assert not planned_rules(study, few) & (COMPUTE | again)
    assert again | COMPUTE <= planned_rules(study, few, METHOD="another")
    assert {"choose_frames", "choose_single_frame"} <= planned_rules(study, config, METHOD="another")


def test_the_seed_runs_again_what_draws_random_numbers(study, config):
    planned = planned_rules(study, without_frames(config) | {"seed": 7})
    assert {"choose_single_frame", "evaluate_grid", "match_partners", "follow_frames"} <= planned
    assert not planned & {"read_surface", "compute_partner_surfaces"}


def test_a_dry_run_writes_nothing(own, config):
    before = {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    planned_rules(own, changed(config, "seed", 5))
    assert before == {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    assert not os.path.lexists(own / "results" / "other")
