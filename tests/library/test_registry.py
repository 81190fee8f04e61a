"""Names of `registry`, functions that a user gives or registers, and those of installed packages."""

import inspect
import subprocess
import sys

import numpy as np
import pytest

import sparsurf
from peptides import peptide, write
from sparsurf import registry
from sparsurf.cli.command import main
from sparsurf.errors import InputError

PLUGIN = """
import numpy as np
import sparsurf


def topmost(prepared, n, rng):
    return np.argsort(-prepared.points[:, 2], kind="stable")[:n]


def elevation(molecule, points):
    return points[:, 2] - molecule.xyz[0, :, 2].min()


def faulty(molecule, points):
    return 1 / 0


sparsurf.register("field", "elevation", elevation, label="height over the lowest atom", unit="Å")
"""
POINTS = """
[sparsurf]
sampler.topmost = my_plugin:topmost
field.elevation = my_plugin:elevation
field.faulty = my_plugin:faulty
field.gone = my_missing_plugin:gone
sampler.farthest = my_plugin:topmost
nonsense = my_plugin:topmost
"""


def topmost(prepared, n, rng):
    return np.argsort(-prepared.points[:, 2], kind="stable")[:n]


def height(molecule, points):
    return points[:, 2] - molecule.xyz[0, :, 2].min()


def slope(index, radius, threads):
    """Half the cosine to z: other numbers than the published roughness."""
    return (1 + index.normals[np.argsort(index.dot)][:, 2]) / 2


def numbers(patches):
    """The number of dots of each patch, and 3."""
    return np.stack([np.diff(patches.start), np.full(len(patches.centres), 3)], axis=1)


@pytest.fixture(scope="module")
def dots(tmp_path_factory):
    path = tmp_path_factory.mktemp("registry") / "protein.pdb"
    write(path, peptide(["ALA", "LYS", "GLY", "SER"]) + "END\n")
    return sparsurf.surface(path)


@pytest.fixture
def empty(monkeypatch):
    """No registered choices, before and after."""
    monkeypatch.setattr(registry, "_registered", {kind: {} for kind in registry.TABLE})


@pytest.fixture
def plugin(tmp_path, monkeypatch, empty):
    """A small installed package, of which nothing was imported."""
    install(tmp_path)
    monkeypatch.syspath_prepend(tmp_path)
    registry.plugins.cache_clear()
    monkeypatch.setattr(registry, "_told", set())
    monkeypatch.setattr(registry, "_plugins_in_use", {})
    yield tmp_path
    registry.plugins.cache_clear()
    sys.modules.pop("my_plugin", None)


def install(folder, points=POINTS):
    (folder / "my_plugin.py").write_text(PLUGIN, encoding="utf-8")
    info = folder / "my_plugin-1.2.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: my-plugin\nVersion: 1.2\n")
    (info / "entry_points.txt").write_text(points)


def test_every_entry_of_the_table_leads_to_what_it_names():
    for kind, entries in registry.TABLE.items():
        for name in (name for name, entry in entries.items() if entry.source):
            choice, found = registry.load(kind, name, kind)
            assert choice.name == name and choice.label and choice.meaning.endswith(".")
            if inspect.isfunction(found):
                arguments = ("dots",) if choice.takes_dots else registry.KINDS[kind].arguments
                assert kind == "format" or inspect.signature(found).bind(*arguments)


def test_a_function_takes_the_place_of_a_name(dots, empty):
    n = len(dots) // 10
    wanted = np.argsort(-dots.points[:, 2], kind="stable")[:n]
    assert np.array_equal(sparsurf.sample(dots, n_dots=n, sampler=topmost), wanted)
    assert np.array_equal(sparsurf.minimal(dots, n_dots=n, sampler=topmost).dots, wanted)
    table = sparsurf.fields(dots, ["hydropathy", height])
    assert list(table) == ["hydropathy", "height"]
    assert np.allclose(table["height"], dots.points[:, 2] - dots.molecule.xyz[0, :, 2].min())
    few = sparsurf.points(dots.molecule, n_dots=20, fields=[height])
    assert np.allclose(few.fields["height"], few.points[:, 2] - dots.molecule.xyz[0, :, 2].min())
    half = (1 + dots.normals[:, 2]) / 2
    assert np.allclose(sparsurf.roughness(dots, roughness=slope), half)
    z = sparsurf.descriptors(dots, [0, 5], descriptor=numbers)
    within = np.linalg.norm(dots.points - dots.points[[[0], [5]]], axis=2) < 6
    assert z.shape == (2, 2) and (z[:, 1] == 3).all() and (z[:, 0] > 1).all()
    assert (z[:, 0] <= within.sum(axis=1)).all()


def test_a_prepared_surface_follows_the_functions_it_was_given(dots, empty):
    ready = sparsurf.prepare(dots, roughness=slope, descriptor=numbers)
    assert np.allclose(ready.roughness, (1 + dots.normals[:, 2]) / 2)
    plain = sparsurf.sample(sparsurf.prepare(dots), combination=(1, 1, 0, 0))
    assert not np.array_equal(sparsurf.sample(ready, combination=(1, 1, 0, 0)), plain)
    kept = sparsurf.sample(ready, percent=20)
    z = sparsurf.compare(ready, kept)["Z"].item()
    assert z == pytest.approx(round(z * 200) / 200)  # a mean of 200 differences of numbers of dots


def test_a_registered_name_has_its_label_and_is_replaced_by_its_next_version(dots, empty):
    sparsurf.register("sampler", "high", topmost, label="highest dots", nested=True)
    assert registry.label("sampler", "high") == "highest dots"
    first = sparsurf.sample(dots, n_dots=9, sampler="high")

    def other(prepared, n, rng):
        return np.arange(n)

    with pytest.raises(InputError, match="sampler 'high' already"):
        sparsurf.register("sampler", "high", other)
    assert np.array_equal(sparsurf.sample(dots, n_dots=9, sampler="high"), first)
    again = type(topmost)(other.__code__, globals(), "topmost")
    again.__module__, again.__qualname__ = __name__, "topmost"
    sparsurf.register("sampler", "high", again)
    assert np.array_equal(sparsurf.sample(dots, n_dots=9, sampler="high"), np.arange(9))


@pytest.mark.parametrize(
    ("kind", "name", "function", "words"),
    [
        ("colour", "x", topmost, "kind 'colour'"),
        ("sampler", "a b", topmost, "cannot name"),
        ("sampler", "x", 3, "give the function"),
        ("sampler", "farthest", topmost, "built in"),
        ("sampler", "x", height, r"take \(prepared, n,"),
        ("format", "x", lambda content, path: None, "needs sniff"),
    ],
)
def test_a_wrong_registration_is_refused(empty, kind, name, function, words):
    with pytest.raises(InputError, match=words):
        sparsurf.register(kind, name, function)


def named(name, function):
    """The function under a name."""
    function.__name__ = function.__qualname__ = name
    return function


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda d: sparsurf.sample(d, n_dots=5, sampler="farhtest"), "you mean 'farthest'"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=lambda p, n, r: [1]), "has no name"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("a", lambda p, n: [1])), r"'a' takes \(p,"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("a", lambda p, n, r: [0.5])), "'a' returns an array"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("a", lambda p, n, r: None)), "'a' returns a NoneType"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("a", lambda p, n, r: [1, 1])), "2 dots, of which 1 repeat"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("a", lambda p, n, r: [-1])), "-1 to -1"),
        (lambda d: sparsurf.sample(d, n_dots=5, sampler=named("farthest", lambda p, n, r: [1])), "rename your"),
        (lambda d: sparsurf.fields(d, named("a", lambda d: [1])), r"must take .* or the dots alone .*takes_dots=True"),
        (lambda d: sparsurf.fields(d, named("a", lambda m, p: [1, 2])), "'a' returns an array of shape"),
        (lambda d: sparsurf.fields(d, named("a", lambda m, p: ["x"] * len(p))), "'a' returns an array of <U1"),
        (lambda d: sparsurf.fields(d, named("a", lambda m, p: np.full(len(p), np.nan))), "any dot"),
        (lambda d: sparsurf.fields(d, named("a", lambda m, p: np.full(len(p), np.inf))), "infinity; .* NaN"),
        (lambda d: sparsurf.roughness(d, roughness=named("a", lambda i, r, t: np.full(len(d), np.nan))), "NaN"),
        (lambda d: sparsurf.roughness(d, roughness=named("a", lambda i, r, t: np.full(len(d), 2))), "between 0 .rough. and 1"),
        (lambda d: sparsurf.roughness(d, roughness="publisched"), "you mean 'published'"),
        (lambda d: sparsurf.descriptors(d, [0], descriptor=named("a", lambda p: [1.0])), r"shape \(1, any"),
        (lambda d: sparsurf.descriptors(d, [0], descriptor=named("a", lambda p: [[np.inf]])), "infinity"),
        (lambda d: sparsurf.descriptors(d, [0], descriptor="extnt"), "there is no descriptor"),
    ],
)  # fmt: skip
def test_a_wrong_function_is_told_in_one_sentence(dots, empty, call, words):
    with pytest.raises(InputError, match=words) as error:
        call(dots)
    assert "\n" not in str(error.value)


def test_a_format_of_the_user_is_read(tmp_path, empty):
    def read(content, path):
        rows = np.array([line.split()[1:] for line in content.decode().splitlines()], float)
        return sparsurf.Surface(rows[:, :3], rows[:, 3:])

    sparsurf.register("format", "mine", read, sniff=lambda head: head.startswith(b"mine "))
    normals = np.eye(3)
    lines = [f"mine {' '.join(map(str, row))}" for row in np.hstack([5 * normals, normals])]
    (tmp_path / "a.mine").write_text("\n".join(lines))
    assert np.array_equal(sparsurf.read_surface(tmp_path / "a.mine").points, 5 * normals)


def test_an_installed_package_adds_names(dots, plugin, caplog):
    assert [name for name in registry.names("sampler") if name not in registry.TABLE["sampler"]] == [
        "topmost"
    ]
    assert "my_plugin" not in sys.modules  # nothing is imported before it is used
    assert "nonsense" in caplog.text and "'farthest' is left" in caplog.text
    kept = sparsurf.sample(dots, n_dots=9, sampler="topmost")
    assert np.array_equal(kept, np.argsort(-dots.points[:, 2], kind="stable")[:9])
    table = sparsurf.fields(dots, "elevation")
    assert np.allclose(table["elevation"], dots.points[:, 2] - dots.molecule.xyz[0, :, 2].min())
    assert (registry.choice_of("field", "elevation").label, registry.choice_of("field", "elevation").unit) == (
        "height over the lowest atom", "Å"
    )  # fmt: skip


def test_a_package_that_cannot_be_imported_stops_only_what_uses_it(dots, plugin, caplog):
    assert list(sparsurf.fields(dots, ["hydropathy"])) == ["hydropathy"]
    with pytest.raises(InputError, match=r"'gone' of my-plugin 1.2 cannot be imported: ModuleNotFoundError"):
        sparsurf.fields(dots, "gone")
    caplog.clear()
    assert [registry.label("field", "gone") for _ in range(2)] == ["gone", "gone"]
    assert caplog.text.count("cannot be imported") == 1


def command(folder, words):
    """Run a command of the library, to which the small package is installed."""
    install(folder)
    write(folder / "protein.pdb", peptide(["ALA", "LYS"]) + "END\n")
    code = f"import sys; sys.path.insert(0, {str(folder)!r}); from sparsurf.cli.command import main; sys.exit(main())"
    return subprocess.run(
        [sys.executable, "-c", code, *words.split()], cwd=folder, capture_output=True, text=True, check=False
    )


def broken(*_):
    raise KeyError("no such atom")


@pytest.mark.parametrize(
    ("kind", "call"),
    [
        ("sampler", lambda dots: sparsurf.sample(dots, n_dots=9, sampler=broken)),
        ("descriptor", lambda dots: sparsurf.descriptors(dots, [0], descriptor=broken)),
        ("roughness", lambda dots: sparsurf.roughness(dots, roughness=broken)),
        ("field", lambda dots: sparsurf.fields(dots, broken)),
        ("reading", lambda dots: sparsurf.compare(dots, [0, 1, 2], reading=broken)),
    ],
)
def test_an_error_in_a_function_of_the_user_names_the_function(dots, empty, kind, call):
    with pytest.raises(InputError, match=f"the {kind} 'broken'.* fails: KeyError: 'no such atom'") as told:
        call(dots)
    assert isinstance(told.value.__cause__, KeyError)  # whose traceback Python prints as well


def test_a_command_tells_the_error_of_an_installed_package_in_one_sentence(tmp_path):
    done = command(tmp_path, "surface protein.pdb --fields faulty -o dots.csv")
    assert done.returncode == 1
    assert "Traceback" not in done.stderr
    assert done.stderr.splitlines()[-1] == (
        "sparsurf surface: the field 'faulty' of my-plugin 1.2, which is called with (molecule, points), fails: "
        "ZeroDivisionError: division by zero."
    )


@pytest.mark.parametrize("name", ["residues", "points", "minimal"])
def test_the_help_lists_the_fields_of_an_installed_package(plugin, capsys, name):
    with pytest.raises(SystemExit):
        main([name, "--help"])
    told = capsys.readouterr().out
    assert "hydropathy" in told and "elevation" in told


def test_a_command_takes_the_names_of_an_installed_package(tmp_path):
    done = command(tmp_path, "minimal protein.pdb --n-dots 20 --sampler topmost --fields elevation -o -")
    assert done.returncode == 0, done.stderr
    header, *rows = done.stdout.splitlines()
    z, elevation = (header.split(",").index(name) for name in ("z", "elevation"))
    values = np.array([[row.split(",")[k] for k in (z, elevation)] for row in rows], float)
    assert len(values) == 20 and np.allclose(np.diff(values[:, 0]), np.diff(values[:, 1]), atol=1e-3)
    assert (np.diff(values[:, 0]) <= 0).all()
