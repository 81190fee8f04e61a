"""What counts as the code of a rule, and which conformations a table names."""

import os
import re

import pytest

from sparsurf.workflow import code_digests
from sparsurf.workflow.jobs import conformations_of, one_of


@pytest.fixture
def scripts(tmp_path, monkeypatch):
    """A library of three modules: a script imports one, which imports the next."""
    files = {
        "run.py": "from sparsurf.one.first import work\n",
        "sparsurf/__init__.py": '"""Top."""\n',
        "sparsurf/one/__init__.py": '"""One."""\n',
        "sparsurf/one/first.py": "from sparsurf.two import second\nTABLE = 'table.csv'\n",
        "sparsurf/one/table.csv": "a,b\n",
        "sparsurf/two/__init__.py": '"""Two."""\n',
        "sparsurf/two/second.py": "X = 1\n",
        "sparsurf/two/third.py": "Y = 1\n",
    }
    for name, text in files.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(code_digests, "SCRIPTS", tmp_path)
    return tmp_path


@pytest.mark.parametrize(
    ("name", "counts"),
    [
        ("run.py", True),
        ("sparsurf/__init__.py", True),
        ("sparsurf/one/__init__.py", True),
        ("sparsurf/one/first.py", True),
        ("sparsurf/one/table.csv", True),
        ("sparsurf/two/__init__.py", True),
        ("sparsurf/two/second.py", True),
        ("sparsurf/two/third.py", False),
    ],
)
def test_a_change_of_what_a_script_imports_changes_its_digest(scripts, name, counts):
    before = code_digests.digest.__wrapped__("run.py")
    with (scripts / name).open("a") as stream:
        stream.write("# more\n")
    assert (code_digests.digest.__wrapped__("run.py") != before) == counts


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
        found.append(content(path))
    assert len(set(found[:6])) == 6  # read as a whole
    assert len(set(found[6:])) == 5 and found[6] == found[10]  # but not the middle of a large one


def test_conformations_are_the_first_column_without_its_header(tmp_path):
    (tmp_path / "frames.csv").write_text("conformation,frame\nc1,5\nc2,9\n")
    assert conformations_of(tmp_path / "frames.csv") == ["c1", "c2"]


def test_a_wildcard_is_one_of_the_names_and_nothing_else():
    assert re.fullmatch(one_of(["a.b", "c"]), "a.b") and not re.fullmatch(one_of(["a.b"]), "axb")
    assert not re.match(one_of([]), "")


def test_a_package_that_a_script_imports_counts_as_its_code(scripts):
    (scripts / "run.py").write_text("from sparsurf import two\n")
    names = ["run.py", "sparsurf/__init__.py", "sparsurf/two/__init__.py"]
    assert code_digests.files("run.py") == [scripts / name for name in names]


def test_a_rule_is_made_by_its_code_and_by_the_sections_it_names(scripts):
    config = {"seed": 3, "patches": {"R": 6, "D_link": 0.5}, "compare": {"run": True, "draws": 2}}
    (scripts / "sparsurf/report/figures").mkdir(parents=True)
    (scripts / "sparsurf/report/figures/one.py").write_text("Z = 1\n")
    code_digests.digest.cache_clear()
    found = code_digests.made_by(config, "run.py", "seed", "patches", "compare")
    assert found["settings"] == {"seed": 3, "patches": {"R": 6, "D_link": 0.5}, "compare": {"draws": 2}}
    inner = {"pairs": {"nearest": 3, "thinning": {"run": True, "draws": 2}}}
    assert code_digests.made_by(inner, "run.py", "pairs")["settings"] == {
        "pairs": {"nearest": 3, "thinning": {"draws": 2}}
    }
    some = code_digests.made_by(config, "run.py", "patches.D_link", "compare.draws", "patches.R")["settings"]
    assert some == {"patches": {"D_link": 0.5, "R": 6}, "compare": {"draws": 2}}
    alone = code_digests.made_by(config, "run.py")
    assert alone == {"code": found["code"]} and found["code"] == code_digests.digest("run.py")
    drawn = code_digests.made_by(config, "run.py", figures=["one"])
    assert drawn["code"] == code_digests.digest("run.py", "sparsurf/report/figures/one.py") != alone["code"]
    code_digests.digest.cache_clear()
