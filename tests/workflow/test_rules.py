"""Every rule, run for real once: what it reads, what it goes by, and that its result follows from both.

Simulations are planned only, in test_workflow.py. A section of the settings that a script lacks stops its job. What no
script asks for by name (contents, checksums, figures) is compared here.
"""

import base64
import json
import os
import re
from pathlib import Path

import everything
import pandas as pd
import pytest

from conftest import WORKFLOW
from small_study import output, snakemake
from sparsurf.workflow import code_digests
from sparsurf.workflow.config import check

pytestmark = pytest.mark.skipif(
    "SPARSURF_EVERY_RULE" not in os.environ, reason="takes 6 CPU minutes: set SPARSURF_EVERY_RULE=1"
)
F0, PAIR = "moving/f0", "pairs/both"
SURFACE, KERNELS = {"surface.npz"}, {".kernels_of_surfaces", ".kernels_of_patches"}
ROUGH = SURFACE | {"roughness.csv"} | KERNELS
FRAMES = {"frames.csv", "silhouette.csv", "projection.csv", "explained.csv"}
PARTNERS = [{f"{place}/{file}" for place in (F0, "got/f0")} for file in ("surface.npz", "structure.pdb")]
ENOUGH = {"enough.csv", "curves.csv", "floors.csv"}
OVER_TIME = {"ensemble.csv", "residues.csv", "residues_over_time.csv"}
DEFECTS = ("sampling.moved_centre", "sampling.every_patch")
OF_GRID = ("patches", "sampling", "evaluation", "seed")
FIGURES = re.findall(r'^    "(\w+)":', re.search(r"^FIGURES = \{\n(.*?)^\}", WORKFLOW, re.M | re.S)[1], re.M)
# Of an output of each rule: the names of its inputs, the settings, and the values of its other params
RULES = {
    "compile_kernels": (".kernels_of_patches", set(), (), ["patches", "published"]),
    "fetch_structure": ("got/download/got.pdb", set(), (), ["URL", "SHA256"]),
    "choose_frames": (
        "moving/frames.csv",
        {"moving.pdb"},
        ("frames", "seed"),
        [["CONTENT moving.pdb"], {"residues": "1-6"}],
    ),
    "draw_frames": ("moving/figures/frames.svg", FRAMES, (), []),
    "make_surface": (f"{F0}/surface.dms", {"structures"} | KERNELS, ("surface", "patches.D_link"), []),
    "take_surface": ("A1/c1/surface.npz", {"a1.npz"}, (), [["CONTENT a1.npz"]]),
    "measure_roughness": (f"{F0}/roughness.csv", SURFACE | KERNELS, ("patches",), []),
    "measure_floors": (
        f"{F0}/floors.csv",
        ROUGH | {"structure.pdb"},
        ("surface", "patches", *DEFECTS, "evaluation.test_dots", "seed"),
        [{"residues": "1-6"}],
    ),
    "evaluate_grid": (f"{F0}/grid.csv", ROUGH, OF_GRID, []),
    "tabulate_best": (f"{F0}/ranges.csv", {"grid.csv", "distances.npz", "floors.csv"}, ("tables",), []),
    "draw_figures": (
        f"{F0}/figures/subsets.svg",
        ROUGH | {"best.json", "grid.csv", "minimal.csv"} | ENOUGH,
        ("patches", *DEFECTS, "evaluation.test_dots", "seed"),
        ["fresh dots"],
    ),
    "take_minimal": (
        f"{F0}/minimal.csv",
        ROUGH | {"floors.csv", "structure.pdb"},
        ("patches", *DEFECTS, "evaluation.test_dots", "minimal", "fields", "seed"),
        [],
    ),
    "draw_view": (
        f"{F0}/view.html",
        ROUGH | {"best.json", "grid.csv", "minimal.csv", "structure.pdb", "fields.npz", "fields.csv"},
        ("patches", *DEFECTS, "seed"),
        [],
    ),
    "tabulate_residues": (
        f"{F0}/residues.csv",
        ROUGH | {"minimal.csv", "structure.pdb", "fields.npz", "fields.csv"},
        (),
        [],
    ),
    "compare_samplers": (
        f"{F0}/compare.csv",
        ROUGH | {"grid.csv", "ranges.csv", "floors.csv", "structure.pdb"},
        ("surface", *OF_GRID[:3], "compare", "seed"),
        [],
    ),
    "summarise_comparison": ("compare.csv", {"compare.csv"}, (), []),
    "follow_ensemble": ("moving/ensemble.csv", {"moving.pdb", "1of2.csv", "2of2.csv"}, (), None),
    "draw_ensemble": (
        "moving/figures/ensemble.svg",
        {"ensemble.csv", "residues.csv", "residues_over_time.csv"},
        ("ensemble",),
        [],
    ),
    "summarise_run": (
        "surfaces.csv",
        {"best.json", "ranges.csv", "grid.csv", "roughness.csv", "minimal.csv", "surface.npz"} | ENOUGH,
        ("patches", "minimal", "seed"),
        [],
    ),
    "make_partners": (
        "pairs/two/surface_1.npz",
        {"one.pdb", "two.pdb"} | KERNELS,
        ("surface", "patches.D_link"),
        [["CONTENT one.pdb", "CONTENT two.pdb"], {"files": ["one.pdb", "two.pdb"]}],
    ),
    "match_partners": (
        f"{PAIR}/agreement.csv",
        PARTNERS[0] | PARTNERS[1] | KERNELS,
        ("patches", "complementarity", "seed"),
        [{"proteins": ["moving", "got"]}],
    ),
    "thin_pair": (
        f"{PAIR}/thinning.csv",
        PARTNERS[0] | PARTNERS[1] | KERNELS,
        ("patches", "complementarity", "seed"),
        [],
    ),
    "draw_pair": (f"{PAIR}/book.svg", {*PARTNERS[0], "propensity.csv"} | KERNELS, (), []),
    "draw_pair_views": (
        f"{PAIR}/view_1.html",
        {*PARTNERS[0], *PARTNERS[1], "propensity.csv"} | KERNELS,
        ("patches", *DEFECTS, "seed"),
        [],
    ),
    "tabulate_pair_residues": (f"{PAIR}/residues.csv", {*PARTNERS[1], "propensity.csv"}, (), []),
    "summarise_pairs": ("pairs/pairs.csv", {"agreement.csv"}, (), []),
    "reproduce_paper": (
        "paper_rows.csv",
        ROUGH | {"grid.csv", "ranges.csv", "best.json", "rough_and_flat.csv"} | ENOUGH,
        ("surface", *OF_GRID),
        ["a1.npz", "A1/c1"],
    ),
    "collect_warnings": ("warnings.csv", None, (), None),
    "write_front_page": ("index.html", None, (), [{}, "fresh dots"]),
}


@pytest.fixture(scope="module")
def study(tmp_path_factory):
    """Folder, config as checked, and the finished study."""
    folder = tmp_path_factory.mktemp("everything") / "study"
    config, process = everything.run(folder)
    assert process.returncode == 0, output(process)
    before = Path.cwd()
    os.chdir(folder)
    try:
        return folder, config, check(config)
    finally:
        os.chdir(before)


@pytest.fixture(scope="module")
def records(study):
    """What Snakemake noted of each output, by its path in the run's folder."""
    found = {}
    for path in (study[0] / ".snakemake" / "metadata").iterdir():
        name = base64.b64decode(path.name).decode().removeprefix("results/all/")
        found[name] = json.loads(path.read_text())
    return found


def test_every_rule_ran_and_has_its_row(records):
    ran = {record["rule"] for record in records.values()}
    assert ran - {"complete_protein", "complete_pair", "follow_frames"} == {*RULES}
    for rule in RULES:
        assert f"rule {rule}:" in WORKFLOW or f"checkpoint {rule}:" in WORKFLOW


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_reads_and_goes_by_what_it_should(study, records, rule):
    folder, given, config = study
    path, inputs, sections, others = RULES[rule]
    record = records[path]
    assert record["rule"] == rule
    if inputs is not None:
        found = {name.removeprefix("results/all/") for name in record["input"]}
        assert {name if name in inputs else Path(name).name for name in found} == inputs
    figures = FIGURES if rule == "draw_figures" else ()
    expected = code_digests.made_by(config, f"{rule}.py", *sections, figures=figures)
    params = record["params"]
    assert repr(expected["code"]) in params
    if sections:
        assert repr(expected["settings"]) in params
    if others is not None:
        rest = sorted(repr(filled(each, folder, given)) for each in others)
        assert sorted({*params} - {repr(value) for value in expected.values()}) == rest


def filled(value, folder, config):
    """A value of the table above with what only the study knows."""
    if isinstance(value, list):
        return [filled(each, folder, config) for each in value]
    if isinstance(value, str) and value.startswith("CONTENT "):
        return code_digests.content.__wrapped__(folder / value.split()[1])
    got = config["proteins"]["got"]
    return {"URL": got["url"], "SHA256": got["sha256"]}.get(value, value) if isinstance(value, str) else value


def test_each_part_of_an_ensemble_follows_its_own_frames(study):
    table = pd.read_csv(study[0] / "results/all/moving/ensemble.csv")
    assert table["frame"].to_list() == [0, 1] and table["n_S"].nunique() > 1


def test_the_comparison_over_all_is_of_every_surface(study):
    run = study[0] / "results" / "all"
    own = [pd.read_csv(path) for path in sorted(run.glob("*/*/compare.csv"))]
    assert len(own) == 4
    assert len(pd.read_csv(run / "surfaces.csv")) == 4 and len(pd.read_csv(run / "summary.csv")) == 4 * 2 * 2


def test_warnings_of_all_jobs_are_in_one_table(study):
    table = pd.read_csv(study[0] / "results/all/warnings.csv")
    assert table.columns.to_list() == ["protein", "conformation", "job", "sentence"]
    told = table[table["job"] == "choose_frames"]
    assert {*told["protein"]} == {"moving", "got"} and told["sentence"].str.contains("lack heavy atoms").all()


def test_a_finished_study_has_nothing_to_do_until_a_file_is_replaced(study):
    """By one of another content and an older date, as `cp -p` does."""
    folder, config, _ = study
    again = snakemake(folder, config, "--dry-run")
    assert "Nothing to be done" in output(again), output(again)
    for name in ("moving.pdb", "one.pdb"):
        path, when = folder / name, (folder / name).stat().st_mtime
        path.write_text("REMARK another\n" + path.read_text())
        os.utime(path, (when, when))
    config["proteins"]["got"]["sha256"] = "0" * 64
    reasons = output(snakemake(folder, config, "--dry-run")).split(
        "params have changed since last execution:"
    )[1]
    assert {"choose_frames", "make_partners", "fetch_structure"} <= {
        *reasons.split("\n")[1].replace(",", " ").split()
    }
