"""Results follow inputs, parameters and code: what runs again in the finished small study after a change."""

import base64
import os
import re
import shutil

import pytest
import yaml

from small_study import changed, copy_of, output, planned_rules, snakemake

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
    """Also where it is older than what followed from the former one, as `cp -p`, `rsync -a` and archives leave it."""
    content = (own / file).read_bytes()
    (own / file).unlink()
    (own / file).write_bytes(content + b"\n")
    os.utime(own / file, (10**9, 10**9))
    planned = planned_rules(own, config)
    assert again in planned and not untouched & planned


def replace(path, content):
    """Replace a file of a copy, and keep its date."""
    times = path.stat().st_atime_ns, path.stat().st_mtime_ns
    path.unlink()
    path.write_bytes(content)
    os.utime(path, ns=times)


def edited(content):
    """Content with another digit."""
    digit = max(content.rfind(b"%d" % k) for k in range(1, 9))
    return content[:digit] + bytes([content[digit] + 1]) + content[digit + 1 :]


@pytest.mark.parametrize("change", [edited, lambda content: content[: len(content) // 3]])
@pytest.mark.parametrize(
    ("file", "rule", "untouched"),
    [
        ("still/structures/f0.pdb", "choose_single_frame", "choose_frames"),
        ("moving/f0000/roughness.csv", "measure_roughness", "compute_surface"),
        ("moving/f0700/residues.csv", "tabulate_residues", "select_minimal_subset"),
        ("changes/bend/changes.csv", "compare_forms", "measure_roughness"),
        ("loaded/download/loaded.pdb", "fetch_structure", "read_surface"),
        ("surfaces.csv", "summarise_surfaces", "summarise_best"),
    ],
)
def test_a_result_that_was_edited_or_cut_is_made_again(own, config, file, rule, untouched, change):
    """Its date is kept, and it may lie behind the choice of the frames."""
    path = own / "results" / "small" / file
    replace(path, change(path.read_bytes()))
    planned = planned_rules(own, config)
    assert rule in planned and untouched not in planned


@pytest.mark.parametrize("start", [0, 100])
def test_what_a_killed_job_left_under_its_final_names_is_made_again(own, config, start):
    """Half of it, or one of its files, with its marker: Snakemake looks for markers only before the frames are chosen."""
    run = own / "results" / "small"
    path = run / "moving/f0000/residues.csv"
    replace(path, path.read_bytes()[start:])
    name = base64.urlsafe_b64encode(b"results/small/moving/f0000/residues.csv").decode()
    (own / ".snakemake/incomplete" / name).write_text("")
    assert "tabulate_residues" in planned_rules(own, config)


def test_only_what_a_rule_of_the_study_makes_is_made_again(own, config):
    """Not notes of the user, nor what a job left that the config no longer asks for."""
    run = own / "results" / "small"
    (run / "moving" / "notes.txt").write_text("mine\n")
    assert planned_rules(own, config) == set()
    for file in ("compare.csv", "moving/f0000/compare.csv"):
        replace(run / file, b"")
    assert {"compare_samplers", "summarise_comparison"} <= planned_rules(own, config)
    config = {key: value for key, value in config.items() if key != "compare"}
    assert not {"compare_samplers", "summarise_comparison"} & planned_rules(own, config)


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


PAGES = {
    "draw_view",
    "draw_roughness",
    "draw_figures",
    "draw_pair",
    "draw_changes",
    "close_run",
}
NUMBERS = COMPUTE | {
    "choose_single_frame",
    "compute_partner_surfaces",
    "match_partners",
    "compare_forms",
    "follow_frames",
}
EDITS = {  # file with a line more: rules that run again, and rules that do not
    "sparsurf/recovery/errors.py": (NUMBERS | PAGES, {"fetch_structure"}),
    "sparsurf_study/analysis/grid.py": (NUMBERS | PAGES, {"fetch_structure"}),
    "sparsurf/views/viewer/molecule.js": (PAGES, NUMBERS),
    "sparsurf_study/report/templates/front.html.j2": (PAGES, NUMBERS),
    "sparsurf/cli/minimal.py": (set(), NUMBERS | PAGES),
    "sparsurf_study/workflow/jobs.py": (set(), NUMBERS | PAGES),
    "sparsurf_study/config/mistakes.py": (set(), NUMBERS | PAGES),
    "sparsurf_study/catalogue.yaml": ({"close_run"}, NUMBERS | PAGES - {"close_run"}),
}


@pytest.mark.parametrize("file", EDITS)
def test_an_edit_runs_again_what_follows_from_the_file_and_no_more(study, config, file):
    """In jobs that are known before any frame is chosen; a pair of files is among them."""
    again, untouched = EDITS[file]
    planned = planned_rules(study, config, [file])
    assert again <= planned, again - planned
    assert not untouched & planned, untouched & planned


def test_results_of_an_earlier_version_are_made_again_but_for_files_that_are_touched(own, config):
    """They have the parameters of other code and are older than the scripts; CHANGELOG says what to touch."""
    for path in [path for path in (own / ".snakemake/metadata").rglob("*") if path.is_file()]:
        text = re.sub(r"'[0-9a-f]{16}'", "'0123456789abcdef'", path.read_text())
        path.unlink()
        path.write_text(text)
    run = own / "results/small"
    (run / "SHA256SUMS").unlink()
    (run / ".ledger").mkdir()
    downloads = [*(run / "loaded/download").iterdir()]
    for path in downloads:
        replace(path, path.read_bytes())  # a date is that of all links
        os.utime(path, (10**9, 10**9))
    everything = planned_rules(own, config)
    assert everything >= NUMBERS | {"fetch_structure", "draw_roughness", "close_run"}
    process = snakemake(own, config, "--touch", *(str(path.relative_to(own)) for path in downloads))
    assert process.returncode == 0, output(process)
    assert planned_rules(own, config) == everything - {"fetch_structure"}
    assert not (run / ".ledger").exists() and not (run / "SHA256SUMS").exists()


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
    def times():
        return {path: path.stat().st_mtime_ns for path in (own / "results").rglob("*")}

    before = times()
    planned_rules(own, changed(config, "seed", 5))
    assert before == times()
    assert not os.path.lexists(own / "results" / "other")
