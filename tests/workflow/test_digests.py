"""What a change of the code runs again: the definitions that a rule's script reaches."""

import os
import re
import shutil
from functools import cache
from pathlib import Path

import pytest

from conftest import ROOT, WORKFLOW
from sparsurf.workflow import code_digests, definitions

FILES = {
    "scripts/run.py": (
        "from sparsurf.one.first import work\nfrom sparsurf.two import table\n\n\ndef main():\n    work(table.of('x'))\n"
    ),
    "src/sparsurf/__init__.py": "CALLS = {}\n",
    "src/sparsurf/one/first.py": (
        '"""One."""\n\nfrom sparsurf.two.second import kept, LIMIT\n\nTABLE = "table.csv"\nUNUSED = 5\n\n\n'
        "def work(x):\n    '''Do.'''\n    return kept(x), other(LIMIT), TABLE\n\n\n"
        "def other(x):\n    return x  # as it is\n\n\ndef idle():\n    return UNUSED\n"
    ),
    "src/sparsurf/one/table.csv": "a,b\n",
    "src/sparsurf/one/other.csv": "a,b\n",
    "src/sparsurf/two/second.py": "LIMIT = 1\nSPARE = 2\n\n\ndef kept(x):\n    return page('first.md.j2')\n",
    "src/sparsurf/two/table.py": (
        "TABLE = {}\n\n\ndef registered(f):\n    TABLE[f.__name__] = f\n    return f\n\n\n"
        "def of(name):\n    return TABLE[name]\n\n\n"
        "def idle():\n    return 2\n\n\n@registered\ndef x():\n    return 1\n\n\nTABLE.update(y=2)\n"
    ),
    "src/sparsurf/two/more.py": (
        "from sparsurf.two.table import registered\n\n\n@registered\ndef z():\n    return 3\n\n\ndef w():\n    return 4\n"
    ),
    "src/sparsurf/workflow/jobs.py": "X = 1\n",
    "src/sparsurf/report/templates/first.md.j2": '{% extends "base.md.j2" %}\n',
    "src/sparsurf/report/templates/base.md.j2": "Words.\n",
    "src/sparsurf/report/templates/third.md.j2": "Other words.\n",
}


def at_home(folder, monkeypatch):
    """Let `code_digests` look into a copy of the checkout; returns a function of the scripts that gives their digest."""
    library = folder / "src" / "sparsurf"
    monkeypatch.setattr(code_digests, "HOME", folder)
    monkeypatch.setattr(definitions, "LIBRARY", library)
    monkeypatch.setattr(definitions, "TEMPLATES", library / "report" / "templates")
    left_out = {library / path.relative_to(ROOT / "src" / "sparsurf") for path in definitions.LEFT_OUT}
    monkeypatch.setattr(definitions, "LEFT_OUT", left_out)

    def fresh(*scripts):
        for each in (definitions.parsed, definitions._followed, definitions._module):
            each.cache_clear()
        return code_digests.digest.__wrapped__(*scripts)

    return fresh


@pytest.fixture
def digest(tmp_path, monkeypatch):
    """Digest of run.py in a library of a few modules."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    fresh = at_home(tmp_path, monkeypatch)
    return lambda: fresh("run.py")


@pytest.mark.parametrize(
    ("file", "old", "new", "counts"),
    [
        ("scripts/run.py", "'x'", "'y'", True),
        ("one/first.py", "One.", "Something else.", False),
        ("one/first.py", "Do.", "Do it.", False),
        ("one/first.py", "  # as it is", "", False),
        ("one/first.py", "other(LIMIT)", "other(\n        LIMIT\n    )", False),
        ("one/first.py", "return x", "return -x", True),
        ("one/first.py", "UNUSED = 5", "UNUSED = 6", False),
        ("one/first.py", "def idle", "def more():\n    return 1\n\n\ndef idle", False),
        ("one/table.csv", "a", "c", True),
        ("one/other.csv", "a", "c", False),
        ("two/second.py", "LIMIT = 1", "LIMIT = 2", True),
        ("two/second.py", "SPARE = 2", "SPARE = 3", False),
        ("two/table.py", "TABLE[name]", "TABLE.get(name)", True),
        ("two/table.py", "return 2", "return 3", False),
        ("two/table.py", "return 1", "return 2", True),  # it is registered
        ("two/table.py", "y=2", "y=3", True),  # so is what an expression enters
        ("two/more.py", "return 3", "return 4", True),  # from a module beside
        ("two/more.py", "return 4", "return 5", False),
        ("two/table.py", "return f", "return print", True),
        ("report/templates/first.md.j2", "%}", "%}More.", True),
        ("report/templates/base.md.j2", "Words", "Others", True),
        ("report/templates/third.md.j2", "words", "letters", False),
        ("__init__.py", "{}", "dict()", False),
    ],
)
def test_an_edit_counts_where_it_is_used(digest, tmp_path, file, old, new, counts):
    path, before = tmp_path / (file if file in FILES else f"src/sparsurf/{file}"), digest()
    text = path.read_text()
    assert text.count(old) == 1 or file.endswith("csv")
    path.write_text(text.replace(old, new))
    assert (digest() != before) == counts


@pytest.mark.parametrize(
    "use",
    [
        "from sparsurf.two import second\n\n\ndef main(x=second):\n    return x.SPARE\n",  # which of it, nobody knows
        "def main():\n    from sparsurf.two.second import SPARE\n\n    return SPARE\n",
        "import sparsurf.two.second\n\nX = sparsurf.two.second.SPARE\n",
        "COMMAND = ['python', '-m', 'sparsurf.two.second']\n",
    ],
)
def test_every_way_to_use_a_module_counts(digest, tmp_path, use):
    (tmp_path / "scripts/run.py").write_text(use)
    before, path = digest(), tmp_path / "src/sparsurf/two/second.py"
    path.write_text(path.read_text().replace("SPARE = 2", "SPARE = 3"))
    assert digest() != before


def test_what_was_parsed_is_kept_and_found_again(digest, tmp_path, monkeypatch):
    monkeypatch.setattr(definitions, "KEPT", tmp_path / "new" / "kept.json")
    definitions._kept.cache_clear()
    before = digest()
    definitions._kept.cache_clear()
    monkeypatch.setattr(definitions, "parse", None)
    assert digest() == before
    definitions._kept.cache_clear()


# The checkout itself


@cache
def scripts():
    """Names of the rules' scripts, each with what comes behind it in `made_by`."""
    return set(re.findall(r'made_by\(\s*"(\w+\.py)"', WORKFLOW))


@pytest.fixture
def again(tmp_path, monkeypatch):
    """Function that edits files of the library and says which scripts' rules that runs again."""
    for folder in ("scripts", "src"):
        shutil.copytree(ROOT / folder, tmp_path / folder, ignore=shutil.ignore_patterns("__pycache__"))
    fresh = at_home(tmp_path, monkeypatch)

    def edit(*edits):
        before = {name: fresh(name) for name in scripts()}
        for file, old, new in edits:
            path = tmp_path / "src" / "sparsurf" / file
            text = path.read_text()
            assert len(re.findall(old, text, re.M)) == 1, f"{old} stands in {file} not once"
            path.write_text(re.sub(old, new, text, flags=re.M))
        return {name for name in scripts() if fresh(name) != before[name]}

    return edit


def test_a_constant_of_the_patches_runs_what_follows_from_it(again):
    after = again(("patches/index.py", "^R_ZERNIKE = 6.0", "R_ZERNIKE = 6.5"))
    assert {"evaluate_grid.py", "measure_floors.py", "match_partners.py", "draw_figures.py"} <= after
    assert not after & {"measure_roughness.py", "make_surface.py", "choose_frames.py", "draw_frames.py"}
    after = again(("sampling/samplers.py", "^SURPLUS = 0.005", "SURPLUS = 0.004"))
    assert "compare_samplers.py" in after and not after & {"evaluate_grid.py", "measure_floors.py"}
    after = again(("patches/roughness.py", "^PUBLISHED = ", "PUBLISHED = '' + "))
    assert {"measure_roughness.py", "evaluate_grid.py"} <= after and "choose_frames.py" not in after


def test_words_and_the_frame_of_a_job_run_nothing_again(again):
    edits = [
        ("__init__.py", "^N  ", "M  "),  # the glossary
        ("patches/index.py", r'\A"""', '"""Again: '),
        ("study/evaluator.py", "^class Evaluator", "# a comment\nclass Evaluator"),
        ("report/captions/ranges.rst", r"\A", "More. "),
        ("kernel_cache.py", "^LIBRARY = ", "HERE = LIBRARY = "),
        ("workflow/jobs.py", "^NAMED = ", "NAMES = NAMED = "),
    ]
    assert again(*edits) == set()


def test_pictures_run_nothing_again_that_counts(again):
    after = again(("report/figures/layout.py", r"^def save\(", "def save(*more, "))
    assert "draw_figures.py" in after
    assert not after & {"evaluate_grid.py", "measure_roughness.py", "make_surface.py", "take_minimal.py"}


@pytest.mark.parametrize("parser", ["pdb", "mmcif"])
def test_a_parser_runs_no_descriptor_again(parser):
    def by(script):
        return {path.name for path in definitions.reached(ROOT / "scripts" / script)}

    assert f"{parser}.py" in by("choose_frames.py")
    assert not {f"{parser}.py", "rolling_probe.py"} & by("evaluate_grid.py")


def test_a_data_file_runs_what_reads_it(again):
    after = again(("sampling/published_table1.csv", r"\Z", "\n"))
    assert {"reproduce_paper.py", "compare_samplers.py"} <= after
    assert not after & {"choose_frames.py", "make_surface.py", "measure_roughness.py"}


# Params of a rule


def test_a_figure_that_is_named_counts():
    one = code_digests.made_by({}, "draw_figures.py", figures=["subsets"])
    other = code_digests.made_by({}, "draw_figures.py", figures=["roughness"])
    bare = code_digests.made_by({}, "draw_figures.py")
    assert len({each["code"] for each in (one, other, bare)}) == 3
    assert bare == {"code": code_digests.digest("draw_figures.py")}


@pytest.mark.parametrize(
    ("sections", "settings"),
    [
        (("seed", "patches"), {"seed": 3, "patches": {"R": 6, "D_link": 0.5}}),
        (("compare", "pairs"), {"compare": {"draws": 2}, "pairs": {"nearest": 3, "thinning": {"draws": 2}}}),
        (("patches.D_link", "compare.draws"), {"patches": {"D_link": 0.5}, "compare": {"draws": 2}}),
    ],
)
def test_a_rule_goes_by_the_settings_it_names_without_whether_it_runs(sections, settings):
    config = {"seed": 3, "patches": {"R": 6, "D_link": 0.5}, "compare": {"run": True, "draws": 2}}
    config["pairs"] = {"nearest": 3, "thinning": {"run": True, "draws": 2}}
    assert code_digests.made_by(config, "draw_frames.py", *sections)["settings"] == settings


def test_another_file_of_the_same_name_is_noticed_whatever_its_date(tmp_path, monkeypatch):
    content, path = code_digests.content.__wrapped__, tmp_path / "a.pdb"
    assert content(path) == ""
    found = []
    for whole in (2**26, 100):  # of what is larger the ends count
        monkeypatch.setattr(code_digests, "WHOLE", whole)
        monkeypatch.setattr(code_digests, "ENDS", 50)
        for change in ({}, {0: 1}, {120: 1}, {149: 1}, {75: 1}):
            text = bytearray(150)
            for place, value in change.items():
                text[place] = value
            path.write_bytes(text)
            os.utime(path, (1e9, 1e9))
            found.append(content(str(path)))
        path.write_bytes(bytes(151))
        found.append(content(Path(path)))
    assert len(set(found[:6])) == 6  # read as a whole
    assert len(set(found[6:])) == 5 and found[6] == found[10]  # but not the middle of a large one
