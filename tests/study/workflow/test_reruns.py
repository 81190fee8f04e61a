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
        ("moving/f0700/figures/roughness.svg", "draw_roughness"),
        ("moving/f0700/figures/subsets.svg", "draw_figures"),
        ("pairs/files/book.png", "draw_pair"),
        ("changes/bend/changed_2.pdb", "compare_forms"),
        ("failures.csv", "close_run"),
    ],
)
def test_a_deleted_result_is_made_again(own, config, file, rule):
    path = own / "results" / "small" / file
    shutil.rmtree(path) if path.is_dir() else path.unlink()
    assert rule in planned_rules(own, config)


def without_frames(config):
    """Return the config of the molecules that have one frame: all of their jobs are known before any runs."""
    kept = {key: value for key, value in config.items() if key != "changes"}
    kept["proteins"] = {name: config["proteins"][name] for name in ("still", "ready")}
    return kept | {"pairs": {"files": config["pairs"]["files"]}}


SURFACES = COMPUTE | {"compute_partner_surfaces", "follow_frames", "match_partners", "compare_forms"}
PAGES = {
    "draw_view",
    "draw_roughness",
    "draw_figures",
    "draw_pair",
    "draw_changes",
    "summarise_best",
    "close_run",
}
EDITS = {  # file with a line more: rules that run again, and rules that do not
    "sparsurf/molecules/pdb.py": (SURFACES | {"choose_single_frame", "tabulate_residues"}, set()),
    "sparsurf/surfaces/rolling_probe.py": (SURFACES, {"choose_single_frame", "read_surface"}),
    "sparsurf/dot_fields/smoothing.py": (
        {"select_minimal_subset", "draw_view"},
        {"compute_surface", "evaluate_grid"},
    ),
    "sparsurf/patches/zernike/images.py": (
        SURFACES - {"compute_surface", "compute_partner_surfaces", "measure_roughness"},
        {"measure_roughness"},
    ),
    "sparsurf/recovery/errors.py": (
        {"select_minimal_subset"},
        {"compute_surface", "evaluate_grid", "measure_roughness"},
    ),
    "sparsurf/sampling/farthest_point.py": (
        {"select_minimal_subset", "draw_view"},
        {"evaluate_grid", "tabulate_best"},
    ),
    "sparsurf/evaluation/minimal_subset.py": (
        {"select_minimal_subset", "tabulate_residues"},
        {"evaluate_grid", "match_partners"},
    ),
    "sparsurf/views/layout.py": (PAGES - {"draw_view"}, SURFACES | {"draw_view"}),
    "sparsurf/views/viewer/page.js": (
        {"draw_view", "draw_roughness", "draw_pair", "draw_changes"},
        SURFACES | {"draw_figures"},
    ),
    "sparsurf/api/minimal.py": (set(), SURFACES | PAGES),
    "sparsurf/cli/minimal.py": (set(), SURFACES | PAGES),
    "sparsurf_study/analysis/grid.py": (
        {"evaluate_grid", "tabulate_best", "reproduce_paper"},
        {"compute_surface", "match_partners"},
    ),
    "sparsurf_study/analysis/best_set.py": (
        {"tabulate_best"},
        {"compute_surface", "measure_roughness", "match_partners"},
    ),
    "sparsurf_study/paper/published_runs.py": ({"reproduce_paper"}, SURFACES | {"draw_view", "draw_pair"}),
    "sparsurf_study/pairs/nearest.py": (
        {"match_partners", "draw_pair"},
        COMPUTE | {"draw_view", "follow_frames"},
    ),
    "sparsurf_study/pairs/changes.py": (
        {"compare_forms", "draw_changes"},
        COMPUTE | {"draw_view", "follow_frames"},
    ),
    "sparsurf_study/report/front.py": ({"close_run"}, SURFACES | {"tabulate_residues", "draw_frames"}),
    "sparsurf_study/report/templates/front.html.j2": ({"close_run"}, SURFACES | {"draw_view", "draw_pair"}),
    "sparsurf_study/simulation/gromacs.py": (set(), SURFACES | PAGES),
    "sparsurf_study/workflow/jobs.py": (set(), SURFACES | PAGES),
    "sparsurf_study/catalogue.yaml": ({"close_run"}, SURFACES | PAGES - {"close_run"}),
}


@pytest.mark.parametrize("file", EDITS)
def test_an_edit_runs_again_what_follows_from_the_file_and_no_more(study, config, file):
    """In jobs that are known before any frame is chosen; a pair of files is among them."""
    again, untouched = EDITS[file]
    planned = planned_rules(study, config, [file])
    assert again <= planned, again - planned
    assert not untouched & planned, untouched & planned


def test_the_seed_runs_again_what_draws_random_numbers(study, config):
    planned = planned_rules(study, without_frames(config) | {"seed": 7})
    assert {"choose_single_frame", "evaluate_grid", "match_partners", "follow_frames"} <= planned
    assert not planned & {"read_surface", "compute_partner_surfaces"}


def test_partners_in_another_order_are_matched_again(study, config):
    """Snakemake sees the same input files."""
    both = {"pairs.both.proteins": ["still", "moving"], "pairs.files.files": ["two.pdb", "one.pdb"]}
    for key, partners in both.items():
        assert "match_partners" in planned_rules(study, changed(config, key, partners))


def test_a_dry_run_writes_nothing(own, config):
    before = {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    planned_rules(own, changed(config, "seed", 5))
    assert before == {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}
    assert not os.path.lexists(own / "results" / "other")
