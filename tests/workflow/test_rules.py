"""Every rule, as Snakemake plans it: what it reads, what it goes by, what its script asks for, what is made in the end.

Nothing runs; that results follow from both is in test_every_rule.py. What no script asks for by name (contents,
checksums, figures) is compared here.
"""

import json
import os
import re
import subprocess
import sys
from pathlib import Path

import everything
import pytest
import yaml

from conftest import ROOT, WORKFLOW
from sparsurf.simulation.protocol import STAGES
from sparsurf.workflow import code_digests
from sparsurf.workflow.config import check

F0, PAIR = "moving/f0", "pairs/both"
SURFACE, KERNELS = {"surface.npz"}, {".kernels_of_surfaces", ".kernels_of_patches"}
ROUGH = SURFACE | {"roughness.csv"} | KERNELS
FRAMES = {"frames.csv", "silhouette.csv", "projection.csv", "explained.csv"}
PARTNERS = [{f"{place}/{file}" for place in (F0, "got/f0")} for file in ("surface.npz", "structure.pdb")]
SITE, PLACES = "sites/turn", {"moving/f1/places.sites", "got/f0/places.sites"}
TURN = {"query": "moving/f1", "residues": "2-4", "targets": ["got"]}
ENOUGH = {"enough.csv", "curves.csv", "floors.csv"}
OVER_TIME = {"ensemble.csv", "residues.csv", "residues_over_time.csv"}
DEFECTS = ("sampling.moved_centre", "sampling.every_patch")
OF_GRID = ("patches", "sampling", "evaluation", "seed")
FIGURES = re.findall(r'^    "(\w+)":', re.search(r"^FIGURES = \{\n(.*?)^\}", WORKFLOW, re.M | re.S)[1], re.M)
RESIDUES = {"molecule_options": {"residues": "1-6"}}
OF_MOVING = RESIDUES | {"contents": ["CONTENT moving.pdb"]}
# Of an output of each rule: the names of its inputs, the settings, and its other params
RULES = {
    "compile_kernels": (".kernels_of_patches", set(), (), {"part": "patches", "descriptor": "published"}),
    "fetch_structure": ("got/download/got.pdb", set(), (), {"url": "URL", "sha256": "SHA256"}),
    "choose_frames": (
        "moving/frames.csv",
        {"moving.pdb"},
        ("frames", "seed"),
        OF_MOVING,
    ),
    "draw_frames": ("moving/figures/frames.svg", FRAMES, (), {}),
    "make_surface": (f"{F0}/surface.dms", {"structures"} | KERNELS, ("surface", "patches.D_link"), {}),
    "take_surface": ("A1/c1/surface.npz", {"a1.npz"}, (), {"contents": ["CONTENT a1.npz"]}),
    "measure_roughness": (f"{F0}/roughness.csv", SURFACE | KERNELS, ("patches",), {}),
    "measure_floors": (
        f"{F0}/floors.csv",
        ROUGH | {"structure.pdb"},
        ("surface", "patches", *DEFECTS, "evaluation.test_dots", "seed"),
        RESIDUES,
    ),
    "evaluate_grid": (f"{F0}/grid.csv", ROUGH, OF_GRID, {}),
    "tabulate_best": (f"{F0}/ranges.csv", {"grid.csv", "distances.npz", "floors.csv"}, ("tables",), {}),
    "draw_figures": (
        f"{F0}/figures/subsets.svg",
        ROUGH | {"best.json", "grid.csv", "minimal.csv"} | ENOUGH,
        ("patches", *DEFECTS, "evaluation.test_dots", "minimal", "seed"),
        {},
    ),
    "take_minimal": (
        f"{F0}/minimal.csv",
        ROUGH | {"floors.csv", "ranges.csv", "structure.pdb", "scores.csv"},
        ("patches", *DEFECTS, "evaluation.test_dots", "minimal", "fields", "seed"),
        {"contents": "CONTENT scores.csv"},
    ),
    "draw_view": (
        f"{F0}/view.html",
        ROUGH | {"best.json", "grid.csv", "minimal.csv", "structure.pdb", "fields.npz", "fields.csv"},
        ("patches", *DEFECTS, "seed"),
        {},
    ),
    "tabulate_residues": (
        f"{F0}/residues.csv",
        ROUGH | {"minimal.csv", "structure.pdb", "fields.npz", "fields.csv"},
        (),
        {},
    ),
    "compare_samplers": (
        f"{F0}/compare.csv",
        ROUGH | {"grid.csv", "ranges.csv", "floors.csv", "structure.pdb"},
        ("surface", *OF_GRID[:3], "compare", "seed"),
        {},
    ),
    "summarise_comparison": ("compare.csv", {"compare.csv"}, (), {}),
    "follow_frames": (
        "moving/ensemble/1of2.csv",
        {"moving.pdb"} | KERNELS,
        ("surface", "patches", *DEFECTS, "evaluation.readings", "ensemble", "seed"),
        OF_MOVING | {"protein": "moving", "part": (1, 2)},
    ),
    "follow_ensemble": (
        "moving/ensemble.csv",
        {"moving.pdb", "1of2.csv", "2of2.csv"},
        (),
        OF_MOVING,
    ),
    "draw_ensemble": (
        "moving/figures/ensemble.svg",
        {"ensemble.csv", "residues.csv", "residues_over_time.csv"},
        ("ensemble",),
        {},
    ),
    "summarise_run": (
        "surfaces.csv",
        {"best.json", "ranges.csv", "grid.csv", "roughness.csv", "minimal.csv", "surface.npz"} | ENOUGH,
        ("patches", "minimal", "seed"),
        {},
    ),
    "make_partners": (
        "pairs/two/surface_1.npz",
        {"one.pdb", "two.pdb"} | KERNELS,
        ("surface", "patches.D_link"),
        {"contents": ["CONTENT one.pdb", "CONTENT two.pdb"], "pair": {"files": ["one.pdb", "two.pdb"]}},
    ),
    "match_partners": (
        f"{PAIR}/agreement.csv",
        PARTNERS[0] | PARTNERS[1] | KERNELS,
        ("patches", "complementarity", "seed"),
        {"pair": {"proteins": ["moving", "got"]}},
    ),
    "thin_pair": (
        f"{PAIR}/thinning.csv",
        PARTNERS[0] | PARTNERS[1] | KERNELS,
        ("patches", *DEFECTS, "complementarity", "seed"),
        {},
    ),
    "draw_pair": (
        f"{PAIR}/book.svg",
        {*PARTNERS[0], *PARTNERS[1], "propensity.csv"} | KERNELS,
        ("patches", *DEFECTS, "seed"),
        {},
    ),
    "tabulate_pair_residues": (f"{PAIR}/residues.csv", {*PARTNERS[1], "propensity.csv"}, (), {}),
    "summarise_pairs": ("pairs/pairs.csv", {"agreement.csv"}, (), {}),
    "describe_places": (f"{F0}/places.sites", SURFACE | {"structure.pdb"} | KERNELS, (), {}),
    "find_site": (f"{SITE}/hits.csv", {*PLACES, "moving/f1/structure.pdb"}, (), {"site": TURN}),
    "draw_site": (
        f"{SITE}/site.svg",
        {*PLACES, "hits.csv", "poses.csv", "matches.csv"}
        | {
            f"{place}/{file}"
            for place in ("moving/f1", "got/f0")
            for file in ("surface.npz", "structure.pdb")
        }
        | KERNELS,
        ("patches", *DEFECTS, "seed"),
        {"site": TURN},
    ),
    "summarise_sites": ("sites/matrix.csv", {f"{SITE}/hits.csv", "sites/back/hits.csv"}, (), {}),
    "compare_forms": (
        "sites/bend/changes.csv",
        PARTNERS[0] | PARTNERS[1] | KERNELS,
        ("surface", "patches.D_link", "seed"),
        {"site": {"changes": ["moving", "got"]}},
    ),
    "draw_changes": (
        "sites/bend/changes.svg",
        {*PARTNERS[0], *PARTNERS[1], "changes.csv"},
        ("patches", *DEFECTS, "seed"),
        {"site": {"changes": ["moving", "got"]}},
    ),
    "reproduce_paper": (
        "paper_rows.csv",
        ROUGH | {"grid.csv", "ranges.csv", "best.json", "rough_and_flat.csv"} | ENOUGH,
        ("surface", *OF_GRID),
        {"path_to_surface": "a1.npz", "name": "A1/c1"},
    ),
    "collect_warnings": (
        "warnings.csv",
        None,
        (),
        {
            "places": ["A1", "got", "moving", "pairs/both", "pairs/two", "sites/back", "sites/bend", SITE],
            "jobs": "JOBS",
        },
    ),
    "write_front_page": ("index.html", None, (), {"without": {}, "floor": "fresh dots"}),
    "prepare_system": (
        "water/simulation/system",
        {"one.pdb"},
        ("seed",),
        {"contents": ["CONTENT one.pdb"], "chosen": {}, "simulate": {"ns": 1}},
    ),
    "simulate_stage": (
        "water/simulation/nvt",
        {"system", "minimise"},
        ("seed",),
        {"simulate": {"ns": 1}, "stage": "nvt", "work": "results/all/water/simulation/.running/nvt"},
    ),
    "judge_simulation": ("water/simulation/quality.csv", {"system", *STAGES}, (), {"simulate": {"ns": 1}}),
    "take_all_steps": (
        "moves/f0/surface.npz",
        {"structures", "scores.csv", "one.pdb", "moves.xtc", "frames.csv"} | KERNELS,
        ("surface", "patches", "minimal", "fields", "seed", *DEFECTS, "evaluation.test_dots"),
        RESIDUES | {"contents": "CONTENT scores.csv"},
    ),
}
SOMETIMES = {  # inputs that no job of these studies has
    "measure_floors": {"frames", "structure", "trajectory"},
    "make_partners": {"complex"},
}
ENDS = {  # of outputs that are not named after their file
    "table": ".csv", "rows": ".csv", "page": ".html", "picture": ".png", "svgs": ".svg", "markdown": ".md",
    "structure": ".pdb", "record": ".pdb.json", "contents": "/system.json", "part": "/.front_page.html",
    "bins": "/rough_and_flat.csv", "dots": "/propensity.csv", "given_back": "/fields.csv", "whole": "/surface.ply",
    "runs": "/paper_as_published.csv", "mark": "", "folder": "",
}  # fmt: skip
OF_OUTPUTS = {"folder": "results/all", "path_to_part": "results/all/moving/ensemble/1of2.csv.part"}  # params
ONLY_READ = {"all", "fetch_structure", "follow_frames"}  # rules of which nothing is asked for in the end


@pytest.fixture(scope="module")
def plans(tmp_path_factory):
    """Folder of a study of everything, its config as checked, and the jobs of it and of another, by rule.

    The other has a simulation and does without the sampling. Of the first, frames are chosen: of files made up here.
    """
    folder = tmp_path_factory.mktemp("planned")
    given = everything.given(folder, "http://127.0.0.1:9") | {"minimal": {"sampler": "paper"}}
    (folder / "moves.xtc").touch()
    for name, frames in (("got", 1), ("moving", 2), ("moves", 1)):
        place = folder / "results" / "all" / name
        for part in ("download", "structures"):
            (place / part).mkdir(parents=True)
        for file in ("got.pdb", "got.pdb.json"):
            (place / "download" / file).touch()
        for table in FRAMES:
            (place / table).write_text("conformation\n" + "".join(f"f{k}\n" for k in range(frames)))
    once = {"structure": "one.pdb", "residues": "1-6", "table": "scores.csv"}
    water = {"structure": "one.pdb", "simulate": {"ns": 1}}
    proteins = {"one": once, "moves": once | {"trajectory": "moves.xtc"}, "water": water}
    steps = {"run": "all", "proteins": proteins, "sampling": False, "fields": ["score"]}
    before = Path.cwd()
    os.chdir(folder)
    try:
        yield folder, [(check(config), planned(folder, config)) for config in (given, steps)]
    finally:
        os.chdir(before)


def planned(folder, config):
    """Jobs of a study, see planned.py."""
    (folder / "config.yaml").write_text(yaml.safe_dump(config))
    command = [Path(__file__).with_name("planned.py"), ROOT / "Snakefile", folder, folder / "config.yaml"]
    process = subprocess.run([sys.executable, *command], capture_output=True, text=True)
    assert process.returncode == 0, process.stdout + process.stderr
    return json.loads(process.stdout)


@pytest.fixture(scope="module")
def jobs(plans):
    """Jobs of both plans."""
    return [job for _, jobs in plans[1] for job in jobs]


def test_every_rule_is_planned_and_has_its_row(jobs):
    found = {job["rule"] for job in jobs}
    assert found - {"choose_only_frame"} == {*re.findall(r"^ *(?:rule|checkpoint) (\w+):", WORKFLOW, re.M)}
    marks = {"complete_protein", "complete_place"}
    assert found - marks - {"choose_only_frame", "all"} == {*RULES}


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_has_what_its_script_asks_for_by_name(jobs, rule):
    script = (ROOT / "scripts" / f"{rule}.py").read_text(encoding="utf-8")
    own = [job["names"] for job in jobs if job["rule"] == rule]
    names = {part: {name for each in own for name in each[part]} for part in own[0]}
    names["input"] |= SOMETIMES.get(rule, set())
    for part in ("input", "output"):
        asked = re.findall(rf'\b{part}s\[f?"(.+?)"\]', script)
        assert {re.sub(r"{\w+}", "1", name) for name in asked} <= names[part]
    asked = re.search(r"^def main\((.*?)\):", script, re.M | re.S)[1].replace(" ", "").split(",")
    needed = {name for name in asked if "=" not in name} - {"inputs", "outputs", "name", "threads"}
    assert needed <= names["params"]


def test_an_output_has_the_name_of_its_file(jobs):
    of_each = [job["names"]["output"].items() for job in jobs if job["rule"] != "take_all_steps"]
    named = {(name, file) for each in of_each for name, file in each}
    wrong = [
        (name, file)
        for name, file in named
        if not all(word in re.split(r"\W|_", file.rpartition("/")[2]) for word in name.split("_"))
        and not file.endswith(ENDS.get(name, "nothing"))
    ]
    assert len(named) > 100 and not wrong


def test_every_figure_is_drawn(jobs):
    names = [{*job["names"]["output"]} for job in jobs if job["rule"] == "draw_figures"]
    assert len(FIGURES) == 7 and all(each == {*FIGURES, "bins", "svgs"} for each in names)


def test_a_figure_is_two_files_of_its_rule(jobs):
    for job in jobs:
        ends = [{file[:-4] for file in job["output"] if file.endswith(end)} for end in (".png", ".svg")]
        assert {path for path in ends[0] if not path.endswith("/view")} == ends[1], job["rule"]


def test_a_job_has_a_log_of_its_own_beside_those_of_its_place(plans):
    names = {"choose_only_frame": "choose_frames", "fetch_structure": "fetch", "simulate_stage": "simulate"}
    for _, jobs in plans[1]:
        logs = [(job, *job["log"]) for job in jobs if job["rule"] in {*RULES, "choose_only_frame"}]
        assert len({log for _, log in logs}) == len(logs)
        for job, log in logs:
            folder, _, name = log.removeprefix("results/all/logs/").rpartition("/")
            assert name.startswith(names.get(job["rule"], job["rule"]))
            assert all(path.startswith(f"results/all/{folder}") for path in job["output"])


def test_a_run_asks_for_all_that_its_rules_make(plans):
    (_, jobs), _ = plans[1]
    inputs = {(job["rule"], *job["output"][:1]): {*job["input"]} for job in jobs}
    made = {file for job in jobs if job["rule"] not in ONLY_READ for file in job["output"]}
    marks = {file for file in made if file.endswith(".complete")}
    asked = inputs["all",]
    assert asked == made and len(marks) == 8
    first = {
        f"results/all/{name}"
        for name in ("index.html", "failures.csv", "ro-crate-metadata.json", ".front_page.html")
    }
    kernels = {f"results/all/{name}" for name in KERNELS}
    results = asked - marks - kernels - first
    assert inputs["write_front_page", "results/all/index.html"] == results
    assert inputs["collect_warnings", "results/all/warnings.csv"] == results - {"results/all/warnings.csv"}
    for mark in marks:
        of_it = {file for file in results if file.startswith(mark.removesuffix(".complete"))}
        rule = "complete_place" if mark.split("/")[2] in ("pairs", "sites") else "complete_protein"
        assert inputs[rule, mark] == of_it and len(of_it) > 4, mark


@pytest.mark.parametrize("rule", RULES)
def test_a_rule_reads_and_goes_by_what_it_should(plans, rule):
    path, inputs, sections, others = RULES[rule]
    folder, both = plans
    job, config = next(
        (job, config)
        for config, jobs in both
        for job in jobs
        if job["rule"] == rule and f"results/all/{path}" in job["output"]
    )
    if inputs is not None:
        read = {name.removeprefix("results/all/") for name in job["input"]}
        assert {name if name in inputs else Path(name).name for name in read} == inputs
    figures = FIGURES if rule == "draw_figures" else ()
    expected = code_digests.made_by(config, f"{rule}.py", *sections, figures=figures)
    expected |= {name: filled(each, folder, config) for name, each in others.items()}
    assert job["goes by"] == sorted(map(repr, expected.values()))
    params = {name: value for name, value in job["names"]["params"].items() if name not in OF_OUTPUTS}
    assert params == {name: str(each) for name, each in expected.items()}
    assert all(job["names"]["params"].get(name, path) == path for name, path in OF_OUTPUTS.items())


def filled(value, folder, config):
    """A value of the table above with what only the study knows."""
    if isinstance(value, list):
        return [filled(each, folder, config) for each in value]
    if isinstance(value, str) and value.startswith("CONTENT "):
        return code_digests.content.__wrapped__(folder / value.split()[1])
    if value == "JOBS":  # of the rules of this study, with its grid and without simulations
        rules = [
            ROOT / "Snakefile",
            *(path for path in (ROOT / "rules").glob("*.smk") if path.stem not in ("minimal", "simulate")),
        ]
        logs = (log for path in rules for log in re.findall(r"/([\w{}]+)\.log\"", path.read_text()))
        return sorted({re.sub(r"\{\{\w+\}\}", "*", log).replace("{JOBS}", "2") for log in logs})
    if value in ("URL", "SHA256"):
        return config["proteins"]["got"][value.lower()]
    return value
