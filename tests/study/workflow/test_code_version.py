"""The version of the code of a script: bytes of the modules that it imports and of their data, and of nothing else."""

import ast
import sys

import pytest

from sparsurf import kinds
from sparsurf.settings import Minimal
from sparsurf_study.workflow import code_version

FILES = {
    "scripts/measure.py": "from sparsurf.patches.index import build\nfrom sparsurf_study.analysis import (\n    grid,\n)\n",
    "src/sparsurf/__init__.py": "",
    "src/sparsurf/streams.py": "",
    "src/sparsurf/settings.py": "",
    "src/sparsurf/patches/__init__.py": "",
    "src/sparsurf/patches/index.py": "import numpy\nimport sparsurf.streams\nTABLE, ICONS = 'table.csv', \"icons\"",
    "src/sparsurf/patches/table.csv": "1",
    "src/sparsurf/patches/other.csv": "1",
    "src/sparsurf/patches/other.py": "",
    "src/sparsurf/patches/icons/dot.svg": "",
    "src/sparsurf/patches/icons/small/dot.svg": "",
    "src/sparsurf/views/__init__.py": "",
    "src/sparsurf/views/nested.py": (
        "class A:\n    def f(self):\n        if self:\n            pass\n"
        "        else:\n            import os, sparsurf.views.second\n"
    ),
    "src/sparsurf/views/second.py": "try:\n    from . import relative\nexcept ImportError:\n    from .. import bits\n",
    "src/sparsurf/views/relative.py": "if True: from .deep.inner import name\n",
    "src/sparsurf/views/deep/__init__.py": "",
    "src/sparsurf/views/deep/inner.py": (
        "import importlib\nfrom importlib import import_module\n\ndef lazy(name):\n"
        "    return import_module(f'sparsurf.tables.{name}'), importlib.import_module('sparsurf.named')\n"
    ),
    "src/sparsurf/tables/one.py": "",
    "src/sparsurf/named.py": "import sparsurf.whole\n",
    "src/sparsurf/whole/__init__.py": "",
    "src/sparsurf/bits.py": "",
    "src/sparsurf/quoted.py": "",
    "src/sparsurf_study/__init__.py": "",
    "src/sparsurf_study/analysis/__init__.py": "",
    "src/sparsurf_study/analysis/grid.py": (
        "def f():\n    from sparsurf_study.workflow.jobs import job\n    from sparsurf.views import nested\n"
        "    from sparsurf_study.report import page\n    from sparsurf_study import columns\n\n"
        'TEXT = """\nimport sparsurf.quoted\n"""\n'
    ),
    "src/sparsurf_study/columns.py": "",
    "src/sparsurf_study/report/__init__.py": "",
    "src/sparsurf_study/report/page.py": "",
    "src/sparsurf_study/workflow/__init__.py": "",
    "src/sparsurf_study/workflow/jobs.py": "from sparsurf import settings",
}
FILES["src/sparsurf/patches/index.py"] = FILES["src/sparsurf/patches/index.py"].replace("'", '"')


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A checkout with one script."""
    for name, text in FILES.items():
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(text)
    monkeypatch.setattr(code_version, "ROOT", tmp_path)
    monkeypatch.setattr(code_version, "SOURCES", tmp_path / "src")
    yield tmp_path
    forget()  # later tests of this process plan studies of the real checkout


def forget():
    """Forget what was read of the files."""
    for cached in vars(code_version).values():
        if hasattr(cached, "cache_clear"):
            cached.cache_clear()


def version():
    """The version of the script, read anew."""
    forget()
    return code_version.code_of("measure")


@pytest.mark.parametrize(
    ("file", "counts"),
    [
        ("src/sparsurf/patches/index.py", True),
        ("src/sparsurf/patches/__init__.py", True),
        ("src/sparsurf/patches/table.csv", True),
        ("src/sparsurf/patches/icons/dot.svg", True),
        ("src/sparsurf/patches/icons/small/dot.svg", True),
        ("src/sparsurf/streams.py", True),
        ("src/sparsurf/settings.py", True),  # through an import of the workflow, which does not count itself
        ("src/sparsurf_study/analysis/grid.py", True),
        ("src/sparsurf_study/report/page.py", True),
        ("src/sparsurf_study/columns.py", False),
        ("src/sparsurf/views/second.py", True),  # in a branch of a method of a class
        ("src/sparsurf/views/relative.py", True),
        ("src/sparsurf/bits.py", True),
        ("src/sparsurf/views/deep/inner.py", True),
        ("src/sparsurf/tables/one.py", True),
        ("src/sparsurf/named.py", True),
        ("src/sparsurf/whole/__init__.py", True),
        ("src/sparsurf/quoted.py", False),  # the text of a string
        ("src/sparsurf/patches/other.py", False),
        ("src/sparsurf/patches/other.csv", False),
        ("src/sparsurf/__init__.py", False),
        ("src/sparsurf_study/workflow/jobs.py", False),
    ],
)
def test_an_edit_counts_where_the_script_needs_the_file(checkout, file, counts):
    before = version()
    with open(checkout / file, "a") as stream:
        stream.write("\n# an edit\n")
    assert (version() != before) == counts


def test_a_renamed_module_counts(checkout):
    before = version()
    (checkout / "src/sparsurf/streams.py").rename(checkout / "src/sparsurf/flows.py")
    index = checkout / "src/sparsurf/patches/index.py"
    index.write_text(index.read_text().replace("streams", "flows"))
    assert version() != before


@pytest.fixture
def package(tmp_path, monkeypatch):
    """An installed package with a sampler and a field."""
    folder = tmp_path / "site"
    info = folder / "my_plugin-1.0.dist-info"
    info.mkdir(parents=True)
    (folder / "my_plugin" / "deep").mkdir(parents=True)
    (folder / "my_plugin" / "__init__.py").write_text("from my_plugin.deep.own import topmost")
    (folder / "my_plugin" / "deep" / "own.py").write_text("def topmost(prepared, n, rng): ...")
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-plugin\nVersion: 1.0\n")
    (info / "entry_points.txt").write_text(
        "[sparsurf]\nsampler.topmost = my_plugin:topmost\nfield.x = my_plugin:x\n"
    )
    monkeypatch.syspath_prepend(folder)
    monkeypatch.setattr(kinds, "_plugins_in_use", {})
    kinds.plugins.cache_clear()
    yield folder
    kinds.plugins.cache_clear()


def test_the_functions_of_a_kind_that_is_loaded_count(checkout):
    samplers = checkout / "src/sparsurf/sampling/samplers.py"
    samplers.parent.mkdir()
    samplers.write_text("")
    with open(checkout / "src/sparsurf/streams.py", "a") as stream:
        stream.write('choice, function = kinds.load("sampler", name, key)')
    before = version()
    samplers.write_text("# an edit")
    assert version() != before


@pytest.mark.parametrize("kind", ["sampler", "field"])
def test_a_package_counts_where_the_config_names_it_and_the_script_loads_its_kind(
    checkout, package, kind, monkeypatch
):
    with open(checkout / "src/sparsurf/streams.py", "a") as stream:
        stream.write(f'choice, function = kinds.load("{kind}", name, key)')
    unused = version()
    Minimal(sampler="topmost", percent=10)  # as the config is checked when a study is planned
    used = version()
    assert (used != unused) == (kind == "sampler")
    (package / "my_plugin" / "deep" / "own.py").write_text("def topmost(prepared, n, rng): n+n")  # as long
    edited = version()
    assert (edited != used) == (kind == "sampler")
    with (
        monkeypatch.context() as patch
    ):  # a file that is too large to be read, such as weights, counts by its size
        patch.setattr(code_version, "LARGEST_FILE_READ", 9)
        large = []
        for text in ("n" * 50, "m" * 50, "n" * 51):
            (package / "my_plugin" / "deep" / "own.py").write_text(text)
            large.append(version())
    assert large[0] == large[1] and (large[2] != large[0]) == (kind == "sampler")
    edited = version()
    info = package / "my_plugin-1.0.dist-info" / "METADATA"
    info.write_text(info.read_text().replace("1.0", "1.1"))
    kinds.plugins.cache_clear()
    Minimal(sampler="topmost", percent=10)
    assert (version() != edited) == (kind == "sampler")
    assert "my_plugin" not in sys.modules


def test_a_config_refuses_a_name_that_no_package_has(package):
    with pytest.raises(ValueError, match="'topmost'"):
        Minimal(sampler="lowest", percent=10)


def test_the_imports_of_every_module_are_those_of_its_whole_tree():
    for path in [*code_version.SOURCES.rglob("*.py"), *(code_version.ROOT / "scripts").glob("*.py")]:
        text = path.read_text()
        found, expected = (
            {name for node in nodes for name in code_version.imported_names(node, path)}
            for nodes in (
                code_version.statements(code_version.tree_of_imports(text, path)),
                ast.walk(ast.parse(text)),
            )
        )
        assert found == expected, path
