"""What a change of the code runs again: each rule's script and the packages that its results may depend on."""

import re
from functools import cache

import pytest

from conftest import WORKFLOW
from sparsurf.workflow.code_digests import SCRIPTS, files

LIBRARY = SCRIPTS / "sparsurf"
ATOMS, DOTS = "molecules", "molecules surfaces"
SUBSETS = "surfaces patches recovery sampling study"
PAIRS = "molecules surfaces patches recovery sampling complementarity study"
# Beside the modules that belong to no package and `workflow.jobs`.
MAY = {
    "compile_kernels.py": f"{PAIRS} report",  # every kernel there is; only marks follow from it
    "fetch_structure.py": "",
    "prepare_system.py": f"{ATOMS} simulation",
    "simulate_stage.py": f"{ATOMS} simulation",
    "judge_simulation.py": f"{ATOMS} simulation report",
    "choose_frames.py": ATOMS,
    "draw_frames.py": "report",
    "make_surface.py": DOTS,
    "take_surface.py": "surfaces",
    "measure_roughness.py": "surfaces patches",
    "measure_floors.py": f"{ATOMS} {SUBSETS}",
    "evaluate_grid.py": SUBSETS,
    "tabulate_best.py": f"{SUBSETS} report",
    "draw_figures.py": f"{SUBSETS} report",
    "draw_view.py": f"{ATOMS} {SUBSETS} report",
    "tabulate_residues.py": f"{DOTS} study",
    "take_minimal.py": SUBSETS,
    "compare_samplers.py": f"{ATOMS} {SUBSETS} report",
    "summarise_comparison.py": f"{SUBSETS} report",
    "summarise_run.py": f"{SUBSETS} report",
    "write_front_page.py": f"{SUBSETS} report",
    "follow_frames.py": f"{ATOMS} {SUBSETS}",
    "follow_ensemble.py": f"{ATOMS} {SUBSETS}",
    "draw_ensemble.py": f"{SUBSETS} report",
    "make_partners.py": PAIRS,
    "match_partners.py": f"{PAIRS} report",
    "tabulate_pair_residues.py": PAIRS,
    "draw_pair.py": f"{PAIRS} report",
    "draw_pair_views.py": f"{PAIRS} report",
    "thin_pair.py": f"{PAIRS} report",
    "summarise_pairs.py": f"{PAIRS} report",
    "reproduce_paper.py": f"{SUBSETS} report",
}
OF_PAIRS = (
    "make_partners.py",
    "match_partners.py",
    "tabulate_pair_residues.py",
    "draw_pair.py",
    "draw_pair_views.py",
    "thin_pair.py",
)
OF_WORKFLOW = {"fetch_structure.py": {"download.py"}} | {script: {"partner_files.py"} for script in OF_PAIRS}


@cache
def of_library(script):
    """Files of the library behind a script, relative to it, without the papers on the doors."""
    found = [path.relative_to(LIBRARY) for path in files(script) if LIBRARY in path.parents]
    return {path for path in found if path.name != "__init__.py"}


def rules_behind(path):
    """Scripts whose results a change of a file of the library makes anew."""
    return {script for script in MAY if any(str(found) == path for found in of_library(script))}


def test_every_rule_has_its_row():
    assert set(MAY) == set(re.findall(r'made_by\(\s*"(\w+\.py)"', WORKFLOW))


@pytest.mark.parametrize("script", MAY)
def test_a_rule_depends_on_its_packages_only(script):
    found = of_library(script)
    packages = {path.parts[0] for path in found if len(path.parts) > 1} - {"workflow"}
    assert packages <= set(MAY[script].split())
    workflow = {path.name for path in found if path.parts[0] == "workflow"}
    assert workflow <= {"jobs.py"} | OF_WORKFLOW.get(script, set())


def test_prose_and_pictures_run_nothing_again_that_counts():
    written = [
        str(path.relative_to(LIBRARY)) for path in (LIBRARY / "report").rglob("*.*") if path.suffix != ".pyc"
    ]
    again = set().union(*(rules_behind(path) for path in written))
    assert {"report/pages.py", "report/figures/layout.py", "report/verdict.py"} <= set(written)
    assert again == {script for script, packages in MAY.items() if "report" in packages.split()}
    assert not again & {"evaluate_grid.py", "measure_roughness.py", "make_surface.py", "take_minimal.py"}


@pytest.mark.parametrize("parser", ["molecules/pdb.py", "molecules/mmcif.py", "surfaces/formats/csv.py"])
def test_a_parser_runs_no_descriptor_again(parser):
    again = rules_behind(parser)
    assert again and not again & {"evaluate_grid.py", "draw_figures.py", "take_minimal.py"}
    if parser.startswith(
        "surfaces"
    ):  # the surface dotted at low density, an opponent, is made from the structure
        assert "compare_samplers.py" not in again


def test_making_dots_runs_no_grid_again_by_itself():
    assert "make_surface.py" in rules_behind("surfaces/laying_dots.py")
    assert "evaluate_grid.py" not in rules_behind("surfaces/laying_dots.py")


def test_a_data_file_runs_what_reads_it():
    again = rules_behind("sampling/published_table1.csv")
    assert again == rules_behind("sampling/published.py")
    assert {"reproduce_paper.py", "compare_samplers.py"} <= again
    assert not again & {"choose_frames.py", "make_surface.py", "measure_roughness.py"}


def test_a_figure_counts_for_the_rule_that_draws_it():
    path = LIBRARY / "report" / "figures" / "subsets.py"
    assert path in files("draw_figures.py", "sparsurf/report/figures/subsets.py")
    assert path not in files("draw_figures.py")
