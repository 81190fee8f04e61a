"""Results follow inputs, parameters and code: what runs again in the finished small study after a change."""

import copy
import os
import shutil

import pytest
import yaml

from small_study import copy_of, planned_rules

COMPUTE = {"compute_surface", "measure_roughness", "measure_floors", "evaluate_grid", "select_minimal_subset"}
# Key and new value: rules that run again (and all that need them), rules that do not
KEYS = {
    "frames.selection": ([0], {"choose_frames"}, {"read_surface", "compute_partner_surfaces"}),
    "surface.probe_radius": (
        1.5,
        COMPUTE | {"compare_forms", "compute_partner_surfaces", "follow_frames"},
        {"choose_frames", "read_surface"},
    ),
    "patches.R_patch": (
        4.5,
        (COMPUTE - {"compute_surface"}) | {"match_partners", "follow_frames"},
        {"compare_forms"},
    ),
    "patches.D_link": (0.6, COMPUTE | {"compare_forms"}, {"choose_frames", "read_surface"}),
    "sampling.alpha": ([1.0], {"evaluate_grid", "tabulate_best"}, COMPUTE - {"evaluate_grid"}),
    "sampling.chance_in_every_patch": (
        False,
        {"measure_floors", "evaluate_grid", "follow_frames", "compare_samplers"},
        {"measure_roughness", "match_partners"},
    ),
    "evaluation.draws": (3, {"evaluate_grid", "compare_samplers"}, COMPUTE - {"evaluate_grid"}),
    "evaluation.test_dots": (21, {"evaluate_grid", "measure_floors"}, {"measure_roughness", "follow_frames"}),
    "evaluation.readings": (["kept"], {"evaluate_grid", "follow_frames"}, {"measure_floors"}),
    "tables.ranges": (2, {"tabulate_best", "summarise_best", "compare_samplers"}, COMPUTE),
    "minimal.sampler": (
        "poisson",
        {"select_minimal_subset", "draw_view", "summarise_surfaces"},
        COMPUTE - {"select_minimal_subset"} | {"tabulate_best", "compare_samplers"},
    ),
    "fields": (
        ["potential", "score"],
        {"select_minimal_subset", "tabulate_residues", "draw_view"},
        COMPUTE - {"select_minimal_subset"},
    ),
    "ensemble.combination": ([0.5, 0, 6, 0], {"follow_frames", "follow_ensemble", "draw_ensemble"}, COMPUTE),
    "ensemble.test_dots": (10, {"follow_frames"}, COMPUTE),
    "ensemble.stride": (400, {"follow_frames"}, COMPUTE),
    "compare.percents": ([30], {"compare_samplers", "summarise_comparison"}, COMPUTE | {"tabulate_best"}),
    "compare.samplers": (["uniform", "farthest"], {"compare_samplers", "summarise_comparison"}, COMPUTE),
    "complementarity.smoothing": (5.0, {"match_partners"}, {"compute_partner_surfaces"} | COMPUTE),
    "complementarity.centres": ({"sampler": "farthest", "n_S": 50}, {"match_partners"}, COMPUTE),
    "changes.bend": (["moving/f700", "moving/f0"], {"compare_forms", "draw_changes"}, COMPUTE),
    "proteins.moving.residues": ("209-215", {"choose_frames"}, {"choose_single_frame", "read_surface"}),
    "proteins.loaded.sha256": ("0" * 64, {"fetch_structure"}, {"choose_single_frame", "read_surface"}),
    "pairs.files.files": (["two.pdb", "one.pdb"], {"compute_partner_surfaces"}, COMPUTE),
    "pairs.both.proteins": (["still", "moving"], {"match_partners", "draw_pair"}, COMPUTE),
    "exclude": (
        {"ready/c1": "too small"},
        {"summarise_surfaces", "summarise_best", "close_run"},
        COMPUTE | {"match_partners"},
    ),
}


@pytest.fixture(scope="module")
def config(study):
    return yaml.safe_load((study / "config.yaml").read_text())


@pytest.fixture
def own(study, tmp_path):
    """A copy of the study whose files may be deleted and replaced."""
    return copy_of(study, tmp_path / "own")


def changed(config, key, value):
    """Return a copy of a config with another value of a key such as patches.R_patch."""
    config = section = copy.deepcopy(config)
    if key in ("tables.ranges", "evaluation.readings"):
        del config["paper"]  # which needs these as they are
    *sections, last = key.split(".")
    for name in sections:
        section = section.setdefault(name, {})
    assert section.get(last) != value
    section[last] = value
    return config


def test_a_finished_study_has_nothing_to_do(study, config):
    assert planned_rules(study, config) == set()


@pytest.mark.parametrize("key", KEYS)
def test_a_key_of_the_config_runs_again_what_follows_from_it(study, config, key):
    value, again, untouched = KEYS[key]
    planned = planned_rules(study, changed(config, key, value))
    assert again <= planned and not untouched & planned


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
        ("moving/explained.csv", "choose_frames"),
        ("moving/structures", "choose_frames"),
        ("still/structures", "choose_single_frame"),
        ("still/f0/components.csv", "compute_surface"),
        ("moving/f0700/floors.csv", "measure_floors"),
        ("moving/f0700/distances.npz", "evaluate_grid"),
        ("moving/f0000/ranges.html", "tabulate_best"),
        ("moving/f0700/figures/roughness.svg", "draw_figures"),
        ("ready/c1/minimal.ply", "select_minimal_subset"),
        ("moving/residues.csv", "follow_ensemble"),
        ("pairs/files/book.png", "draw_pair"),
        ("changes/bend/changed_2.pdb", "compare_forms"),
        ("summary.csv", "summarise_best"),
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
