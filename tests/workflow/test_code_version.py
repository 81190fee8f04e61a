"""The version of the library's code: bytes of the packages that compute or draw, and of nothing else."""

import pytest

from sparsurf.workflow import code_version


@pytest.fixture
def library(tmp_path, monkeypatch):
    """A library of three packages."""
    for file in ("patches/index.py", "patches/deep/table.csv", "report/page.py", "workflow/jobs.py"):
        (tmp_path / file).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / file).write_text(f"{file}\n")
    for package in ("patches", "report", "workflow", "cli"):
        (tmp_path / package).mkdir(exist_ok=True)
        (tmp_path / package / "__init__.py").write_text("")
    for file in ("__init__.py", "streams.py"):
        (tmp_path / file).write_text("")
    (tmp_path / "__pycache__").mkdir()
    monkeypatch.setattr(code_version, "LIBRARY", tmp_path)
    return tmp_path


def test_parts_that_compute_are_all_but_those_of_pages_commands_and_the_workflow(library):
    assert code_version.computing_parts() == ["patches", "streams"]


@pytest.mark.parametrize(
    ("file", "changes"),
    [
        ("patches/index.py", "method"),
        ("streams.py", "method"),
        ("report/page.py", "report"),
        ("cli/__init__.py", ""),
        ("__init__.py", ""),
    ],
)
def test_an_edit_changes_the_version_of_its_packages(library, file, changes):
    def versions():
        packages = {"method": code_version.computing_parts(), "report": code_version.DRAWING}
        return {name: code_version.code_version(*folders) for name, folders in packages.items()}

    before = versions()
    with open(library / file, "a") as stream:
        stream.write("# an edit\n")
    assert {name for name in before if versions()[name] != before[name]} == {changes} - {""}


def test_a_renamed_file_changes_the_version_and_bytecode_does_not(library):
    before = code_version.code_version("patches")
    (library / "patches" / "__pycache__").mkdir()
    (library / "patches" / "__pycache__" / "index.pyc").write_bytes(b"x")
    assert code_version.code_version("patches") == before
    (library / "patches" / "index.py").rename(library / "patches" / "other.py")
    assert code_version.code_version("patches") != before
