"""What each rule is given: params with the values of the config, and the files that its settings need."""

import ast
import re
from pathlib import Path

import pytest

from conftest import ROOT
from small_study import planned_jobs, write_study
from sparsurf.workflow.config import check_config

SECTION_OF = {  # params that are a key of a section of the config
    "d_link": "patches",
    "distance_from_moved_centre": "sampling",
    "chance_in_every_patch": "sampling",
    "ranges": "tables",
    "percents": "compare",
    "samplers": "compare",
    "centres": "complementarity",
    "smoothing": "complementarity",
    "interface": "complementarity",
    "readings": "evaluation",
    "combination": "ensemble",
    "stride": "ensemble",
}
KEY_OF = {"d_link": "D_link"}  # where its name differs
RENAMED = {  # arguments of scripts that are called otherwise than the param or file
    ("surface_settings", "surface"),
    ("minimal_settings", "minimal"),
    ("settings", "surface"),
    ("settings", "frames"),
    ("field_names", "fields"),
    ("field_table", "table"),
    ("path", "surface"),
    ("chains", "pair"),
    ("n_ranges", "ranges"),
}
TRIGGERS = {"code", "pair"}  # where a script does not need them, another value still runs its rule again
# Conformations, and how they are called on their pages: a single form goes by the name of its protein
TITLES = {"moving/c1": "moving/c1", "moving/c2": "moving/c2"} | {
    f"{p}/c1": p for p in ("still", "loaded", "ready")
}
MOLECULE_OPTIONS = {"moving": {"residues": "209-216"}, "loaded": {"plddt": 40}}


@pytest.fixture(scope="module")
def planned(tmp_path_factory):
    """A config of which few values are the default, and the jobs that follow once the frames of `moving` are chosen."""
    folder = tmp_path_factory.mktemp("planned") / "study"
    config = write_study(folder)
    moving = folder / "results/small/moving"
    (moving / "structures").mkdir(parents=True)
    (moving / "frames.csv").write_text("conformation,frame,time_ps\nc1,0,0\nc2,700,7\n")
    for name in (
        "silhouette.csv",
        "projection.csv",
        "explained.csv",
        "structures/c1.pdb",
        "structures/c2.pdb",
    ):
        (moving / name).write_text("x\n")
    config["proteins"]["loaded"] = {
        "structure": "loaded.pdb",
        "sampling": False,
        "plddt": 40,
        "table": "scores.csv",
    }
    config |= {
        "seed": 7,
        "frames": {"selection": "clusters", "clusters": 2, "stride": 3},
        "surface": {"probe_radius": 1.5, "radii": "bondi", "cavities": "remove", "density": 12.0},
        "patches": {"R_patch": 4.1, "R_zernike": 5.9, "D_link": 0.6, "descriptor": "rotation_robust"},
        "sampling": config["sampling"] | {"distance_from_moved_centre": False},
        "evaluation": {"test_dots": 21, "draws": 3},
        "tables": {"ranges": 10},
        "minimal": {"sampler": "paper_corrected", "n_S_percent": 12},
        "ensemble": {
            "run": True,
            "jobs": 2,
            "test_dots": 19,
            "stride": 500,
            "combination": [1, 0, 2, 1],
        },
        "changes": {"bend": ["moving/c1", "moving/c2"]},
    }
    config["complementarity"] |= {"centres": {"sampler": "farthest", "n_S": 50}}
    config["complementarity"] |= {"interface": 2.5, "smoothing": 4.5}
    with pytest.MonkeyPatch.context() as patch:
        patch.chdir(folder)
        checked = check_config(config)
    return checked, planned_jobs(folder, config, METHOD="method", REPORT="report")


def of_config(config, job, name):
    """Return the value that the config has for a param of a job."""
    wildcards = job["wildcards"]
    protein = wildcards.get("protein")
    place = f"{protein}/{wildcards.get('conformation')}"
    own = {
        "molecule_options": MOLECULE_OPTIONS.get(protein, {}),
        "title": TITLES.get(place),
        "pair": config["pairs"].get(wildcards.get("pair")),
        "forms": ["moving/c1", "moving/c2"],
        "sampled": ["moving", "still", "ready"],
        "a1": "ready/c1",
        "path_to_surface": "ready.npz",
        "floor": None,
        "whole_curve": protein != "loaded",
        "logs": "results/small/logs",
        "test_dots": config["ensemble" if job["rule"] == "follow_frames" else "evaluation"]["test_dots"],
    }
    if name in own:
        return own[name]
    return config[name] if name in config else config[SECTION_OF[name]][KEY_OF.get(name, name)]


def test_every_param_has_the_value_of_the_config(planned):
    config, jobs = planned
    known = 0
    for job in jobs:
        for name, value in job["params"].items():
            if name not in ("code", "jobs"):
                assert value == of_config(config, job, name), (job["rule"], job["wildcards"], name)
                known += 1
    assert known > 250 and len({job["rule"] for job in jobs}) > 25


def test_a_param_has_the_name_of_its_key():
    """So that no rule takes another key of the config than its script says."""
    found = {}
    for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk")):
        for name, keys in re.findall(
            r'^\s+(\w+)=config((?:\["\w+"\])+(?:\.get\("\w+"\))?)', path.read_text(), re.M
        ):
            found.setdefault((name.lower(), re.findall(r'"(\w+)"', keys)[-1].lower()), path.name)
    assert len(found) > 20
    assert [pair for pair in found if pair[0] != pair[1]] == [("frames", "jobs")]


def test_a_script_hands_on_every_param_and_file_by_its_name(planned):
    """`main(seed=snakemake.params.seed)`: of another key, a number would be taken for another without an error."""
    scripts = {job["script"]: {*job["params"]} - TRIGGERS for job in planned[1] if job["script"]}
    assert len(scripts) > 25
    for path, params in scripts.items():
        tree = ast.parse((ROOT / "scripts" / Path(path).name).read_text(encoding="utf-8"))
        calls = [
            node
            for node in ast.walk(tree)
            if isinstance(node, ast.Call) and getattr(node.func, "id", "") == "main"
        ]
        handed_on = set()
        for keyword in [keyword for call in calls for keyword in call.keywords]:
            text = ast.unparse(keyword.value)
            for section, name in re.findall(
                r"snakemake\.(params|input|output)(?:\.get\('|\.)(?!(?:get|items)\b)(\w+)", text
            ):
                if section == "params" or text[0] not in "[{":  # no list or dict of files
                    assert name == keyword.arg or (keyword.arg, name) in RENAMED, (path, keyword.arg, text)
                handed_on |= {name} if section == "params" else set()
        assert params == handed_on - TRIGGERS, path


def test_every_job_of_a_surface_is_of_that_surface(planned):
    """Inputs of a job of one conformation lie in its folder, or are the files of its protein or over the run."""
    for job in planned[1]:
        if "conformation" in job["wildcards"]:
            own = f"{job['wildcards']['protein']}/{job['wildcards']['conformation']}/"
            others = [f"results/small/{place}/" for place in TITLES if f"{place}/" != own]
            assert not [path for path in job["input"] if path.startswith(tuple(others))], job


def test_the_table_of_a_protein_is_an_input_of_its_minimal_subset(planned):
    for job in planned[1]:
        if job["rule"] == "select_minimal_subset":
            assert ("scores.csv" in job["input"]) == (job["wildcards"]["protein"] != "ready"), job


def test_the_papers_sampler_takes_the_best_of_its_surface(planned):
    subsets = [job for job in planned[1] if job["rule"] == "select_minimal_subset"]
    assert len(subsets) == 5
    for job in [job for job in subsets if job["wildcards"]["protein"] != "loaded"]:
        place = "{protein}/{conformation}".format_map(job["wildcards"])
        assert f"results/small/{place}/ranges.csv" in job["input"]


def test_other_samplers_wait_for_no_grid_and_the_page_knows_the_floor(tmp_path):
    config = write_study(tmp_path / "study")
    config = {key: config[key] for key in ("run", "sampling", "evaluation")}
    config |= {"proteins": {"still": {"structure": "still.pdb"}}, "minimal": {"floor": "turned"}}
    jobs = {job["rule"]: job for job in planned_jobs(tmp_path / "study", config)}
    assert not [path for path in jobs["select_minimal_subset"]["input"] if path.endswith("ranges.csv")]
    assert jobs["close_run"]["params"]["floor"] == "turned"
    assert jobs["draw_view"]["params"]["title"] == "still"


def test_a_simulation_is_of_what_its_protein_selects(tmp_path):
    write_study(tmp_path / "study")
    water = {"structure": "two.pdb", "residues": "2-4", "simulate": {"ns": 0.01}}
    config = {"run": "small", "sampling": False, "seed": 7, "proteins": {"water": water}}
    jobs = planned_jobs(tmp_path / "study", config)
    (prepared,) = [job for job in jobs if job["rule"] == "prepare_system"]
    assert prepared["input"] == ["two.pdb"] and prepared["params"]["seed"] == 7
    assert prepared["params"]["structure_options"] == {"residues": "2-4"}
    simulated, before = (
        "results/small/water/simulation",
        {"nvt": "minimise", "npt": "nvt", "production": "npt"},
    )
    for job in jobs:
        if job["rule"] == "simulate_stage":
            earlier = before.get(job["wildcards"]["stage"])
            assert job["input"] == [*([f"{simulated}/{earlier}"] if earlier else []), f"{simulated}/system"]
    stages = [job["params"] for job in jobs if job["rule"] == "simulate_stage"]
    assert sorted(stage["stage"] for stage in stages) == ["minimise", "npt", "nvt", "production"]
    assert {stage["simulate"]["ns"] for stage in stages} == {0.01} and {
        stage["seed"] for stage in stages
    } == {7}


def test_structures_of_a_batch_come_with_their_own_keys(tmp_path):
    write_study(tmp_path / "study")
    proteins = {
        "still": {"structure": "still.pdb", "table": "scores.csv"},
        "one": {"structure": "one.pdb", "plddt": 50},
    }
    config = {"run": "small", "sampling": False, "batch": 2, "proteins": proteins, "fields": ["score"]}
    (job,) = [job for job in planned_jobs(tmp_path / "study", config) if job["rule"] == "analyse_batch"]
    assert job["params"]["structures"] == {
        "still": {"path": "still.pdb", "table": "scores.csv", "options": {}},
        "one": {"path": "one.pdb", "table": None, "options": {"plddt": 50}},
    }
    assert {"still.pdb", "one.pdb", "scores.csv"} <= {*job["input"]}
