"""The catalogue of outputs is that of the rules, and what it says of a file is true of the files of the small study."""

import re
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from PIL import Image

from conftest import ROOT
from small_study import planned_jobs, write_study
from sparsurf_study import catalogue, columns

RULE = re.compile(r"^ *(?:rule|checkpoint) (\w+):.*?(?=^ *(?:use rule|rule|checkpoint) \w+|\Z)", re.M | re.S)
OUTPUT = re.compile(r"^( *)output:\n(.*?)(?=^\1\w)", re.M | re.S)
TRIANGLES = re.compile(rb"element face (\d+)")
QUANTITY = re.compile(r"(\w+) \((Å[²³]?|°)\)")  # a word with its unit
CATEGORIES = {"", "All surfaces", "Samplers compared", "Pairs", "Changes", "The paper"}


def outputs_of_rules():
    """Yield each rule of the workflow with the path of each of its outputs, but for those that are deleted again."""
    for path in (ROOT / "Snakefile", *sorted((ROOT / "rules").glob("*.smk"))):
        for rule in RULE.finditer(path.read_text(encoding="utf-8")):
            for section in OUTPUT.finditer(rule[0]):
                lines = re.sub(r"(?:temp|touch)\([^)]*\)", "", section[2])
                for output in re.findall(r'"results/\{run\}/([^"]+)"', lines):
                    yield rule[1], output


def files(run):
    """Yield the files of a run with their outputs of the catalogue."""
    for path in sorted(run.rglob("[!.]*")):
        name = path.relative_to(run).as_posix()
        if name.split("/")[0] != "logs" and (output := catalogue.output_of(name)):
            yield path, output


def test_the_rules_write_what_the_catalogue_lists_and_nothing_else():
    listed = {(rule, it.wildcards) for it in catalogue.outputs().values() for rule in it.rules}
    written = {*outputs_of_rules()}
    assert len(written) > 100
    assert listed - written == set() and written - listed == set()


def test_conditions_sections_and_categories_are_those_that_are_explained():
    outputs = catalogue.outputs().values()
    assert {name for it in outputs for name in it.when} == {*catalogue.CONDITIONS}
    assert {name for it in outputs for name in it.sections} == {*catalogue.SECTIONS}
    assert {it.category for it in outputs} == CATEGORIES
    for it in outputs:
        assert not it.title or it.folder.startswith("<protein>") or it.category, it.path


def test_a_study_asks_for_all_that_its_rules_write(tmp_path):
    """Each output of a planned job is an input of the end of the run, or its result, or only other rules need it."""
    config = write_study(tmp_path)
    del config["proteins"]["moving"]  # whose conformations are only planned once its frames are chosen
    config["proteins"]["loaded"] = {"structure": "loaded.pdb", "sampling": False}
    config |= {"changes": {}, "pairs": {name: config["pairs"][name] for name in ("half", "files", "chains")}}
    jobs = planned_jobs(tmp_path, config, all_jobs=True)
    (closing,) = [job for job in jobs if job["rule"] == "close_run"]
    asked = {path.removeprefix("results/small/") for path in (*closing["input"], *closing["output"])}
    for job in jobs:
        for path in (path.removeprefix("results/small/") for path in job["output"]):
            output = catalogue.output_of(path)
            if output:
                assert (path in asked) != output.intermediate, path
    assert {catalogue.output_of(path).path for path in asked} >= {
        "<protein>/<conformation>/figures/number_of_dots.svg", "<protein>/<conformation>/fields.npz",
        "<protein>/<conformation>/compare.csv", "pairs/<pair>/residues.csv", "verdict.html", "<protein>/ensemble.csv",
    }  # fmt: skip


def test_every_file_of_a_run_is_in_the_catalogue(study):
    run = study / "results" / "small"
    found = {output.path for _, output in files(run)}
    for path in run.rglob("[!.]*"):
        name = path.relative_to(run).as_posix()
        inside_a_folder = name.startswith("logs/") or "structures" in name or "/ensemble/" in name
        assert path.is_dir() or inside_a_folder or catalogue.output_of(name), name
    lacking = [it.path for it in catalogue.outputs().values() if it.path not in found]
    assert all({"simulated", "batches"} & catalogue.outputs()[path].when for path in lacking), lacking


def test_a_file_of_dots_of_a_run_is_a_point_cloud_and_one_of_triangles_a_mesh(study):
    paths = [(path, output) for path, output in files(study / "results" / "small") if path.suffix == ".ply"]
    assert {output.name for _, output in paths} == {
        "minimal.ply", "surface.ply", "partner_1.ply", "partner_2.ply",
    }  # fmt: skip
    for path, output in paths:
        faces = TRIANGLES.search(path.read_bytes()[:2000])
        kind = "mesh" if faces and int(faces[1]) else "point cloud"
        assert kind in output.content, f"{output.path} is a {kind}, but called {output.content}"


def test_a_folder_of_a_run_is_called_one(study):
    for path, output in files(study / "results" / "small"):
        assert path.is_dir() == output.content.startswith("a folder"), output.path


def test_pictures_vector_graphics_and_pages_of_a_run_are_called_so(study):
    for path, output in files(study / "results" / "small"):
        assert ("vector graphics" in output.content) == (path.suffix == ".svg"), output.path
        if "interactive page" in output.content:
            assert path.read_bytes()[:15].lower() == b"<!doctype html>", output.path
        if path.suffix == ".png":
            with Image.open(path) as picture:
                assert picture.format == "PNG", output.path


def test_a_structure_of_a_run_has_b_factors_where_the_catalogue_says_so(study):
    for path, output in files(study / "results" / "small"):
        if path.suffix == ".pdb":
            lines = path.read_text().splitlines()
            b_factors = {line[60:66] for line in lines if line.startswith("ATOM")}
            assert (len(b_factors) > 1) == ("B factor" in output.content), output.path


def columns_of(path):
    """The columns of a table, or the arrays of an archive; none of another file."""
    if path.suffix == ".csv":
        return list(pd.read_csv(path, nrows=0))
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return list(arrays)
    return []


def test_quantities_that_a_description_names_are_columns_of_a_run_with_these_units(study):
    """Such as area (Å²): a column of that name, of that unit; each part of a list is a column by its name or meaning."""
    found = {}  # a ready surface lacks some columns
    for path, output in files(study / "results" / "small"):
        for name in columns_of(path):
            found.setdefault(output, {})[name] = None
    assert len(found) > 30
    for output, names in found.items():
        table = columns.tables().get(output.path)
        known = {name: table.column(name) for name in names} if table else {}
        for word, unit in QUANTITY.findall(output.content):
            fitting = [name for name in names if word in name]
            fitting += [name for name, column in known.items() if word in column.meaning]
            assert fitting, f"{output.path} has no {word}"
            assert not known or unit in {known[name].unit for name in fitting}, (
                f"{output.path}: {word} ({unit})"
            )
        told = " ".join([*names, *(column.meaning for column in known.values())]).lower()
        listed = re.sub(r"\([^)]*\)", "", output.content.partition(": ")[2])
        for part in listed.split(", "):
            words = [word.lower().rstrip("s") for word in re.findall(r"[\w_]{4,}", part)]
            assert not words or any(word in told for word in words), f"{output.path}: {part}"


@pytest.mark.parametrize(
    ("path", "output"),
    [
        ("pairs/pairs.csv", "pairs/pairs.csv"),
        ("pairs/a/residues.csv", "pairs/<pair>/residues.csv"),
        ("p/residues.csv", "<protein>/residues.csv"),
        ("p/c1/residues.csv", "<protein>/<conformation>/residues.csv"),
        ("p/download/1ubi.cif.json", "<protein>/download/<file>.json"),
        ("p/simulation/system.json", "<protein>/simulation/system.json"),
        ("p/c1/other.csv", None),
        ("residues/0001.parquet", "residues/<batch>.parquet"),
    ],
)
def test_a_file_is_the_output_with_the_most_specific_path(path, output):
    found = catalogue.output_of(path)
    assert (found and found.path) == output


def test_the_captions_of_the_report_are_those_of_the_catalogue():
    import renew

    stored = {path: path.read_text(encoding="utf-8") for path in renew.CAPTIONS.glob("*.rst")}
    assert stored == renew.captions(), "run make schema"
    rules = "".join(path.read_text() for path in (ROOT / "Snakefile", *(ROOT / "rules").glob("*.smk")))
    reported = {
        Path(path).as_posix() for path in re.findall(r'in_report\(\s*"results/\{run\}/([^"]+)"', rules)
    }
    assert reported == {it.wildcards for it in catalogue.outputs().values() if it.title}
