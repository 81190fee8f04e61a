"""The command line: every example of its help runs, every mistake is a sentence, what comes out can be read again."""

import importlib.util
import logging
import os
import shutil
import subprocess
import sys
from dataclasses import replace
from importlib import import_module

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import measure_floors
import select_minimal_subset
import sparsurf
from conftest import ROOT
from peptides import peptide
from sparsurf.api.surfaces import surface_settings
from sparsurf.batches.analysis import Structure, analyse_batch
from sparsurf.batches.tables import write_parquet
from sparsurf.cli import command, surface
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.errors import distance_to_recovered
from sparsurf.settings import Settings
from sparsurf.streams import DEFAULT_SEED
from sparsurf.surfaces.formats.npz import write_npz
from sparsurf.surfaces.molecular_surface import surface_for_d_link
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.spacing import area_of
from sparsurf.workflow.config import check_config

FILES = (
    "surface",
    "roughness",
    "floors",
    "distances",
    "required_dots",
    "curves",
    "recovered",
    "table",
    "ply",
    "whole",
    "fields",
    "fields_recovered",
)
HABITS = (  # of a machine: environment, and what stands behind the command
    ("LC_ALL=C", ""),
    ("NUMBA_NUM_THREADS=0", ">&-"),
    ("PYTHONWARNINGS=error::ResourceWarning", "2>&-"),
    ("PYTHONUNBUFFERED=1", "<&- >&- 2>&-"),
)
EXAMPLES = sorted(
    {
        line.strip()
        for name in command.COMMANDS
        for line in [*command.EPILOG.splitlines(), *command.build_parser(name)[1].epilog.splitlines()]
        if line.startswith("  sparsurf ")
    }
)


def write_run_in_batches(place):
    """Write the tables of a study in batches of protein.pdb into results/many, if pyarrow is there."""
    if importlib.util.find_spec("pyarrow") is None:
        return
    entry = {"structure": str(place / "protein.pdb")}
    config = check_config({"sampling": False, "pages": [], "proteins": {"protein": entry}})
    for name, rows in analyse_batch(
        [Structure("protein", entry["structure"])], Settings.of(config), config["seed"]
    ).items():
        (place / "results/many" / name).mkdir(parents=True)
        write_parquet(place / "results/many" / name / "0001.parquet", name, rows)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A folder with the files that the examples name, small ones."""
    place = tmp_path_factory.mktemp("commands")
    data = ROOT / "data" / "tdp43"
    read_molecule(data / "topology.pdb", residues="209-216").write_pdb(place / "protein.pdb")
    shutil.copy(place / "protein.pdb", place / "run.pdb")
    write_run_in_batches(place)
    (place / "models.pdb").write_text(models(place / "protein.pdb", 3))
    dots = sparsurf.surface(place / "protein.pdb")
    table = np.hstack([dots.points, dots.normals])
    table = pd.DataFrame(table, columns=["x", "y", "z", "nx", "ny", "nz"])
    table.to_csv(place / "dots.csv", index=False)
    table.head(1).to_csv(place / "one.csv", index=False)
    table.iloc[sparsurf.sample(dots, percent=10)].to_csv(place / "minimal.csv", index=False)
    pd.concat([table, table]).assign(frame=np.arange(2).repeat(len(table))).to_csv(place / "frames.csv")
    (place / "structures").mkdir()
    for name in ("bound", "unbound", "structures/a", "structures/b"):
        (place / f"{name}.pdb").write_text(
            numbered(place / "protein.pdb", (10, 11, 25, 57, 102, 195, 196, 197))
        )
    return place


def numbered(path, numbers):
    """Text of a PDB file with a chain A whose residues have the numbers given."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("ATOM")]
    new = dict(zip(dict.fromkeys(line[22:26] for line in lines), numbers, strict=True))
    return "".join(f"{line[:21]}A{new[line[22:26]]:4d}{line[26:]}\n" for line in lines)


def models(path, n):
    """Text of a PDB file with n models, each a little farther along x."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("ATOM")]
    moved = [
        [f"{line[:30]}{float(line[30:38]) + 0.3 * k:8.3f}{line[38:]}" for line in lines] for k in range(n)
    ]
    return "".join(f"MODEL     {k + 1:4d}\n" + "\n".join(rows) + "\nENDMDL\n" for k, rows in enumerate(moved))


def ended(*arguments):
    """Exit code of a command."""
    try:
        return command.main(list(map(str, arguments)))
    except SystemExit as end:
        return end.code


@pytest.mark.parametrize("line", EXAMPLES)
def test_every_example_of_the_help_runs(folder, line, tmp_path, monkeypatch, capfd):
    if "--trajectory" in line:
        pytest.skip("test_a_frame_of_a_trajectory has the files for it")
    if "results/many" in line:
        pytest.importorskip("pyarrow")
    folder = shutil.copytree(folder, tmp_path / "own")  # an example overwrites what others read
    monkeypatch.chdir(folder)
    words = line.split("|")[0].split(">")[0].split()[1:]
    assert ended(*words) == 0
    shown = capfd.readouterr()
    told = [each for each in shown.err.splitlines() if not each.startswith("Compiling")]
    if "-o" in words:
        out = words[words.index("-o") + 1]
        assert all(each.startswith("wrote ") for each in told) and (out == "-") == (told == [])
        assert (len(shown.out) > 100) if out == "-" else (folder / out).stat().st_size > 100


def test_the_end_of_the_help_fits_a_terminal():
    parsers = [command.build_parser(name) for name in (None, *command.COMMANDS)]
    texts = [parsers[0][0].epilog, *(options.epilog for _, options in parsers[1:])]
    for text in texts:
        assert max(map(len, text.splitlines())) <= 80 and text.count("  sparsurf ") >= 1
    assert command.wrapped("a b\nc\n\nd:\n  e\n  f") == "a b c\n\nd:\n  e\n  f\n"


@pytest.mark.parametrize("name", command.COMMANDS)
def test_every_option_is_explained(name, capsys):
    assert ended(name, "--help") == 0
    assert all(action.help for action in command.build_parser(name)[1]._actions)
    assert "examples:" in capsys.readouterr().out


def test_version_and_the_list_of_commands(capsys):
    assert ended("--version") == 0
    assert capsys.readouterr().out == f"sparsurf {sparsurf.__version__}\n"
    assert ended("--help") == 0
    assert all(name in capsys.readouterr().out for name in ["surface"])
    assert ended() == 2


def test_a_script_for_pymol_holds_the_kept_dots_or_colours_by_roughness(folder, tmp_path):
    assert ended("minimal", folder / "protein.pdb", "--dots", 40, "-o", tmp_path / "few.pml") == 0
    few = (tmp_path / "few.pml").read_text()
    assert few.count("(0.840, 0.370, 0.000, ") == 40 and "ATOM      1" in few
    assert ended("roughness", folder / "protein.pdb", "-o", tmp_path / "rough.bild") == 0
    lines = (tmp_path / "rough.bild").read_text().splitlines()
    dots = sparsurf.surface(folder / "protein.pdb")
    assert sum(line.startswith(".sphere") for line in lines) == len(dots)
    at = "{:.3f} {:.3f} {:.3f}".format(*dots.points[np.argmax(sparsurf.roughness(dots))])
    flattest = lines.index(f".sphere {at} 0.3")
    colours = [line for line in lines[:flattest] if line.startswith(".color")]
    assert colours[-1] == ".color 0.99 0.91 0.14"  # the bright end of viridis


def test_recovered_dots_are_scenes_without_a_molecule(folder, tmp_path):
    assert ended("minimal", folder / "protein.pdb", "--percent", 10, "-o", tmp_path / "few.csv") == 0
    for suffix, mark in (("pml", "cgo.SPHERE"), ("pdb", "HETATM"), ("bild", ".sphere")):
        assert ended("recover", tmp_path / "few.csv", "-o", tmp_path / f"dense.{suffix}") == 0
        text = (tmp_path / f"dense.{suffix}").read_text()
        assert mark in text and "read_pdbstr" not in text


@pytest.mark.parametrize(("interval", "hint"), [((20, 50), False), ((20, 51), True)])
def test_a_wide_interval_is_reported_what_keeps_a_fixed_number(
    folder, tmp_path, monkeypatch, capsys, interval, hint
):
    few = replace(sparsurf.minimal(folder / "protein.pdb", n_dots=40), interval=interval)
    monkeypatch.setattr("sparsurf.cli.minimal.minimal", lambda *_, **__: few)
    assert ended("minimal", folder / "protein.pdb", "-o", tmp_path / "few.csv") == 0
    n = few.weight.sum()
    ends = " to ".join(f"{100 * end / n:.1f}" for end in interval)
    told = capsys.readouterr().err
    assert f"95 % interval {ends} %)" in told and ("--percent keeps a fixed share" in told) == hint


def test_formats_hold_the_same_dots(folder, tmp_path):
    files = {end: tmp_path / f"dots.{end}" for end in ("csv", "npz", "ply", "dms", "dms.gz")}
    for path in files.values():
        assert ended("surface", folder / "protein.pdb", "-o", path) == 0
    dots = sparsurf.surface(folder / "protein.pdb")
    for end, digits in {"csv": 6e-5, "npz": 0, "dms": 6e-4, "dms.gz": 6e-4}.items():
        again = sparsurf.read_surface(files[end])
        assert np.abs(again.points - dots.points).max() <= digits, end
        assert np.abs(again.normals - dots.normals).max() <= digits, end
    table = pd.read_csv(files["csv"])
    assert list(table) == ["x", "y", "z", "nx", "ny", "nz", "area", "kind", "component", "chain", "residue",
                           "residue_name", "atom_name", "atom"]  # fmt: skip
    assert np.allclose(table["area"], dots.area, atol=6e-5) and np.array_equal(table["atom"], dots.atom)
    assert files["ply"].read_bytes().startswith(b"ply\n")
    assert f"element vertex {len(dots)}\n".encode() in files["ply"].read_bytes()


def test_cavities_are_reported_and_removed(tmp_path, capsys):
    place = ROOT / "data" / "tdp43" / "topology.pdb"
    for asked, words in (
        ("keep", "2 components, of which 1 cavity with 224 dots"),
        ("remove", "1 component\n"),
    ):
        assert ended("surface", place, "--cavities", asked, "-o", tmp_path / "d.csv") == 0
        assert words in capsys.readouterr().err
        table = pd.read_csv(tmp_path / "d.csv")
        assert len(table) - (table["component"] == 0).sum() == (224 if asked == "keep" else 0)
    assert ended("minimal", tmp_path / "d.csv", "--dots", 50, "-o", tmp_path / "m.csv") == 0
    assert pd.read_csv(tmp_path / "m.csv")["weight"].sum() == 24600 - 224


def test_commands_give_what_the_functions_give(folder, tmp_path):
    dots = sparsurf.surface(folder / "protein.pdb")
    for source in ("protein.pdb", "dots.csv"):
        assert ended("roughness", folder / source, "--r-patch", 5, "-o", tmp_path / "r.csv") == 0
        assert np.allclose(
            pd.read_csv(tmp_path / "r.csv")["roughness"], sparsurf.roughness(dots, radius=5), atol=1e-4
        )
    assert (
        ended("descriptors", folder / "protein.pdb", "--at", "3,40", "--down", "-o", tmp_path / "z.npz") == 0
    )
    with np.load(tmp_path / "z.npz") as found:
        assert np.array_equal(found["z"], sparsurf.descriptors(dots, [3, 40], up=False))
        assert np.array_equal(found["points"], dots.points[[3, 40]]) and found["dot"].tolist() == [3, 40]
    assert ended("descriptors", folder / "protein.pdb", "--every", 500, "-o", tmp_path / "z.csv") == 0
    table = pd.read_csv(tmp_path / "z.csv")
    assert list(table)[:5] == ["dot", "x", "y", "z", "z_0_0"] and list(table)[-1] == "z_20_20"
    assert np.allclose(table.filter(like="z_").iloc[1], sparsurf.descriptors(dots, [500])[0], rtol=1e-8)


def test_what_python_writes_is_what_the_command_writes(folder, tmp_path):
    dots = sparsurf.surface(folder / "protein.pdb")
    for name in ("dots.csv", "dots.dms"):
        assert ended("surface", folder / "protein.pdb", "-o", tmp_path / name) == 0
        sparsurf.write(dots, tmp_path / f"own_{name}")
        assert (tmp_path / f"own_{name}").read_bytes() == (tmp_path / name).read_bytes()
    assert ended("recover", folder / "minimal.csv", "--mesh", "-o", tmp_path / "mesh.ply") == 0
    sparsurf.write(sparsurf.mesh(folder / "minimal.csv"), tmp_path / "own.ply")
    assert (tmp_path / "own.ply").read_bytes() == (tmp_path / "mesh.ply").read_bytes()


def test_options_of_dots_are_refused_for_a_mesh(folder, tmp_path, capsys):
    call = ["surface", folder / "protein.pdb", "--mesh", "-o", tmp_path / "mesh.ply"]
    for option in (
        ["--fields", "hydropathy"],
        ["--table", "x.csv"],
        ["--charges", "pdb2pqr"],
    ):
        assert ended(*call, *option) == 1
        assert f"{option[0]}: it is about dots, and --mesh writes triangles" in capsys.readouterr().err
    assert ended(*call) == 0


def test_roughness_is_that_of_the_call_and_not_of_the_file_in_every_format(folder, tmp_path):
    ends = ("csv", "npz")
    for radius, name in ((6, "first.csv"), *((3, f"second.{end}") for end in ends)):
        own = folder / "protein.pdb" if radius == 6 else tmp_path / "first.csv"
        assert ended("roughness", own, "--r-patch", radius, "-o", tmp_path / name) == 0
    first, second = (pd.read_csv(tmp_path / f"{name}.csv")["roughness"] for name in ("first", "second"))
    assert abs(first - second).mean() > 0.01
    with np.load(tmp_path / "second.npz") as held:
        assert np.allclose(held["roughness"], second, atol=1e-4)


def test_small_numbers_of_a_field_are_written(folder, tmp_path):
    (tmp_path / "small.csv").write_text("residue,share\n" + "".join(f"{k},{k}e-9\n" for k in range(209, 217)))
    call = ["--fields", "share", "--table", tmp_path / "small.csv", "-o"]
    assert ended("surface", folder / "protein.pdb", *call, tmp_path / "dots.csv") == 0
    table = pd.read_csv(tmp_path / "dots.csv")
    assert np.allclose(table["share"], table["residue"] * 1e-9, rtol=1e-6)
    assert ended("minimal", tmp_path / "dots.csv", "--percent", 10, "-o", tmp_path / "few.csv") == 0
    few = pd.read_csv(tmp_path / "few.csv")
    assert np.array_equal(few["share"], table["share"][few["dot"]])


def test_fields_of_a_frame_follow_from_its_own_atoms(folder, tmp_path):
    """The models are one molecule, moved along x by 0, 0.3 and 0.6 Å."""
    for k in (0, 2):
        call = ["--frame", k, "--fields", "potential", "-o", tmp_path / f"dots_{k}.csv"]
        assert ended("surface", folder / "models.pdb", *call) == 0
    first, last = (pd.read_csv(tmp_path / f"dots_{k}.csv") for k in (0, 2))
    assert np.allclose(last["x"], first["x"].to_numpy() + 0.6, atol=2e-4)
    assert np.allclose(last["potential"], first["potential"], rtol=2e-3, atol=1e-3)
    assert first["potential"].std() > 1


def test_a_frame_of_several_is_the_first_with_a_word(folder, tmp_path, capsys):
    import mdtraj

    mdtraj.load(str(folder / "models.pdb")).save_gro(str(tmp_path / "m.gro"))
    call = ["-o", tmp_path / "x.csv"]
    for name, what in ((tmp_path / "m.gro", "frames"), (folder / "models.pdb", "models")):
        assert ended("surface", name, *call) == 0
        assert f"has 3 {what}: the first is taken. --frame takes another." in capsys.readouterr().err


def test_the_kept_dots_stand_for_all(folder, tmp_path):
    dots = sparsurf.surface(folder / "protein.pdb")
    for asked, n in (
        (["--dots", 77], 77),
        (["--percent", 5], round(0.05 * len(dots))),
    ):
        assert ended("minimal", folder / "protein.pdb", *asked, "-o", tmp_path / "m.csv") == 0
        table = pd.read_csv(tmp_path / "m.csv")
        assert len(table) == n == table["dot"].nunique() and table["weight"].sum() == len(dots)
        assert np.allclose(table[["x", "y", "z"]], dots.points[table["dot"]])


@pytest.mark.parametrize(
    ("wishes", "fields"),
    [
        ({"error": 0.02}, []),
        ({"n_S_percent": 7, "sampler": "poisson"}, []),
        ({"n_S_percent": 7}, ["hydropathy"]),
    ],
)
def test_a_study_and_the_command_hand_out_the_same_subset(folder, tmp_path, wishes, fields):
    """Whatever the study calls the protein; the seed is the same by default."""
    molecule, place = read_molecule(folder / "protein.pdb"), {key: str(tmp_path / key) for key in FILES}
    rules = surface_settings(1.4, "auto", "dms", "keep")
    surface = surface_for_d_link(molecule, 0, radii(molecule, "dms"), rules, 0.5, "x")[0]
    write_npz(place["surface"], surface)
    pd.DataFrame({"roughness": sparsurf.roughness(surface)}).to_csv(place["roughness"])
    own = str(folder / "protein.pdb")
    settings = {
        "surface": place["surface"], "roughness": place["roughness"], "floors": place["floors"],
        "seed": DEFAULT_SEED, "name": "a/f3",
    }  # fmt: skip
    measure_floors.main(
        **settings,
        distances=place["distances"],
        conformation=own,
        settings=Settings(),
        molecule_options={},
    )
    names = ("table", "ply", "whole", "recovered", "required_dots", "curves", "fields", "fields_recovered")
    select_minimal_subset.main(
        **settings | {"floors": place["distances"]},
        **{name: place[name] for name in names},
        ranges=None,
        structure=own,
        field_table=None,
        settings=Settings(minimal=wishes, fields=fields),
        whole_curve=False,
    )
    options = {"n_S_percent": "--percent", "sampler": "--sampler"}
    words = [each for key, value in wishes.items() if key in options for each in (options[key], value)]
    words += [each for name in fields for each in ("--fields", name)]
    assert ended("minimal", own, *words, "-o", tmp_path / "own.csv") == 0
    assert (tmp_path / "own.csv").read_bytes() == (tmp_path / "table").read_bytes()
    few = pd.read_csv(tmp_path / "own.csv")
    points, normals = (few[names].to_numpy() for names in (["x", "y", "z"], ["nx", "ny", "nz"]))
    errors = distance_to_recovered(surface.points, points, normals, 1, density=20.0)
    known = pd.read_csv(place["recovered"])
    assert known["mean"][0] == pytest.approx(
        np.delete(errors, few["dot"]).mean(), abs=2e-4
    )  # of positions with four decimals


def test_without_a_size_the_surface_comes_back_within_two_hundredths_of_an_angstrom(folder, tmp_path, capsys):
    assert ended("minimal", folder / "protein.pdb", "-o", tmp_path / "few.csv") == 0
    assert "95 % interval" in capsys.readouterr().err
    kept = pd.read_csv(tmp_path / "few.csv")["dot"].to_numpy()
    dots = sparsurf.surface(folder / "protein.pdb")

    def error(kept):
        few = dots.take(kept)
        return np.delete(distance_to_recovered(dots.points, few.points, few.normals, 1, 20.0), kept).mean()

    assert error(kept) == pytest.approx(0.02, rel=0.1) and error(kept[: len(kept) // 2]) > 0.03


def test_an_automatic_density_is_no_warning(folder, tmp_path, capfd):
    assert ended("surface", folder / "protein.pdb", "-q", "-o", tmp_path / "all.csv") == 0
    assert capfd.readouterr() == ("", "")


def test_the_floor_is_that_of_dots_as_dense_on_as_many_tests_as_in_a_study(folder, tmp_path, monkeypatch):
    seen = []

    def floors(ready, n_tests, lay, atoms, moved):
        seen.append((n_tests, len(lay(atoms)), len(ready.points)))
        raise InputError("enough")

    monkeypatch.setattr("sparsurf.study.minimal_subset.measure_floors", floors)
    assert ended("minimal", folder / "protein.pdb", "--d-link", 1, "-o", tmp_path / "x.csv") == 1
    assert seen[0][0] == 200 and seen[0][1] == seen[0][2]


def test_the_surface_comes_back_from_the_kept_dots_alone(folder, tmp_path):
    alone = tmp_path / "alone"
    alone.mkdir()
    shutil.copy(folder / "protein.pdb", alone)
    assert ended("minimal", alone / "protein.pdb", "--percent", 10, "-o", alone / "few.csv") == 0
    for path in alone.iterdir():
        if path.name != "few.csv":
            path.unlink()
    shutil.move(alone / "few.csv", tmp_path)
    assert ended("recover", tmp_path / "few.csv", "-o", tmp_path / "dense.npz") == 0
    dots, dense = sparsurf.surface(folder / "protein.pdb"), sparsurf.read_surface(tmp_path / "dense.npz")
    few = sparsurf.read_surface(tmp_path / "few.csv")
    assert np.isnan(dense.area).all() and set(dense.atom) == {-1} == set(dense.kind)  # nobody knows
    assert ended("recover", tmp_path / "few.csv", "-o", tmp_path / "dense.dms") == 0
    area = area_of(dense)[0]
    assert sparsurf.read_surface(tmp_path / "dense.dms").area == pytest.approx(area / len(dense), abs=0.0005)
    assert np.allclose(dense.points[: len(few)], few.points) and len(dense) > 0.8 * len(dots)
    gap = cKDTree(dots.points).query(dense.points)[0]
    assert gap.mean() < 0.25  # half the distance between neighbouring dots, about
    assert ended("minimal", folder / "protein.pdb", "--percent", 10, "-o", tmp_path / "few.ply") == 0
    assert ended("recover", tmp_path / "few.ply", "-o", tmp_path / "of_mesh.npz") == 0
    of_mesh = sparsurf.read_surface(tmp_path / "of_mesh.npz")  # its dots are rounded otherwise
    assert np.allclose(of_mesh.points[: len(few)], few.points, atol=1e-3)
    assert abs(len(of_mesh) - len(dense)) < 0.01 * len(dense)


def test_a_mesh_is_made_where_it_is_requested(folder, tmp_path):
    known = sparsurf.mesh(folder / "protein.pdb")
    for options in ([], ["--mesh"]):
        assert ended("surface", folder / "protein.pdb", *options, "-o", tmp_path / "x.ply") == 0
        head = (tmp_path / "x.ply").read_bytes()[:600]
        n = (
            len(known.triangles)
            if options == ["--mesh"]
            else 2 * len(sparsurf.surface(folder / "protein.pdb"))
        )
        found = int(head.split(b"element face ")[1].split()[0])
        # of a closed surface without handles 2 V - 4, of which a few dots may be left out
        assert found == pytest.approx(n, abs=8)


def test_normals_that_point_inward_are_reported_of(folder, tmp_path, capfd):
    table = pd.read_csv(folder / "minimal.csv")
    assert ended("recover", folder / "minimal.csv", "--mesh", "-o", tmp_path / "mesh.ply") == 0
    assert "point inward" not in capfd.readouterr().err
    table[["nx", "ny", "nz"]] *= -1
    table.to_csv(tmp_path / "inside.csv", index=False)
    assert ended("recover", tmp_path / "inside.csv", "--mesh", "-o", tmp_path / "mesh.ply") == 0
    assert (
        "the normals point inward, so that the mesh encloses the outside: reverse them"
        in capfd.readouterr().err
    )


def test_residues_with_negative_numbers_are_no_option(folder, tmp_path, capfd):
    for words in (["--residues", "-3-2"], ["--residues=-3-2"]):
        assert ended("surface", folder / "protein.pdb", *words, "-o", tmp_path / "o.csv") == 1
        assert "expected one argument" not in capfd.readouterr().err
    assert ended("surface", folder / "protein.pdb", "--residues", "-3-212", "-o", tmp_path / "o.csv") == 0
    own = read_molecule(folder / "protein.pdb", residues="209-212")
    assert len(pd.read_csv(tmp_path / "o.csv")) == len(sparsurf.surface(own))


def test_places_off_the_surface_are_reported(folder, tmp_path, capfd):
    table = pd.read_csv(folder / "minimal.csv").head(3)
    table[["x", "y", "z"]] /= 10  # nm
    table.to_csv(tmp_path / "nm.csv", index=False)
    assert (
        ended("recover", folder / "minimal.csv", "--at", tmp_path / "nm.csv", "-o", tmp_path / "z.csv") == 0
    )
    assert capfd.readouterr().err.startswith(
        "sparsurf: warning: --at: 3 of 3 points have no patch, as no dot lies within 6 Å; their descriptors are zeros\n"
    )
    assert not pd.read_csv(tmp_path / "z.csv").filter(like="z_").to_numpy().any()


@pytest.mark.parametrize("size", [[], ["--dots", "1"]])
def test_one_dot_is_no_surface(tmp_path, capfd, size):
    (tmp_path / "one.csv").write_text("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n")
    assert ended("minimal", tmp_path / "one.csv", *size, "-o", "-") == 1
    assert "one dot alone makes no patch" in capfd.readouterr().err


def test_a_locale_without_the_letter_shows_another(folder, tmp_path):
    command_line = [sys.executable, "-m", "sparsurf", "surface", "--help"]
    own = {
        "PYTHONPATH": str(ROOT / "src"),
        "PYTHONIOENCODING": "ascii",
    }  # not a package that is installed
    process = subprocess.run(command_line, env=os.environ | own, capture_output=True, check=True)
    assert b"dots per ?^2" in process.stdout


def test_a_frame_of_a_trajectory(folder, tmp_path):
    data = ROOT / "data" / "tdp43"
    arguments = ["surface", data / "topology.pdb", "--trajectory", data / "trajectory.xtc"]
    arguments += ["--residues", "209-212", "-o", tmp_path / "dots.npz"]
    places = []
    for frame in (0, 20):
        assert ended(*arguments, "--frame", frame) == 0
        places.append(sparsurf.read_surface(tmp_path / "dots.npz").points)
    molecule = sparsurf.read_molecule(data / "topology.pdb", data / "trajectory.xtc", residues="209-212")
    for frame, points in zip((0, 20), places, strict=True):
        assert np.array_equal(points, sparsurf.surface(molecule, frame=frame).points)
    assert len(places[0]) != len(places[1]) or np.abs(places[0] - places[1]).max() > 0.1


@pytest.mark.parametrize(
    ("arguments", "code", "words"),
    [
        (["surface", "no.pdb", "-o", "x.csv"], 1, "no.pdb does not exist: check the path."),
        (["surface", "dots.csv", "-o", "x.csv"], 1, "dots.csv is not a structure, by its suffix"),
        (["surface", "protein.pdb", "-o", "x.doc"], 1, "cannot be written as '.doc'"),
        (["surface", "protein.pdb", "-o", "no/such/x.csv"], 1, "there is no folder"),
        (["surface", "protein.pdb", "--frame", "1", "-o", "x.csv"], 1, "there is no frame 1"),
        (
            ["surface", "protein.pdb", "--table", "t.csv", "-o", "x.csv"],
            1,
            "--fields names no column of t.csv",
        ),
        (
            ["surface", "protein.pdb", "--fields", "hydropathy", "--table", "t.csv", "-o", "x.csv"],
            1,
            "--table: --fields names no column of t.csv; name one, or leave out --table.",
        ),
        (
            ["surface", "protein.pdb", "--charges", "q.pqr", "-o", "x.csv"],
            1,
            "add --fields potential, or leave",
        ),
        (
            ["surface", "protein.pdb", "--fields", ",", "-o", "x.csv"],
            1,
            "--fields names none; give names such as",
        ),
        (["recover", "minimal.csv", "--at", "", "-o", "x.csv"], 1, "a path is empty: name the file"),
        (
            ["recover", "frames.csv", "-o", "x.csv"],
            1,
            "frames.csv holds the dots of 2 frames: give those of one",
        ),
        (["surface", "protein.pdb", "-o", f"{'é' * 126}.csv"], 1, "cannot name a file"),
        (["surface", "protein.pdb", "-o", "a\0.csv"], 1, "cannot name a file"),
        (["surface", "protein.pdb", "--chains", "Q", "-o", "x.csv"], 1, "has one chain, without a name"),
        (["surface", "protein.pdb", "--probe", "-1", "-o", "x.csv"], 2, "'-1' must be a number, more than 0"),
        (["surface", "protein.pdb"], 2, "-o/--output"),
        (["surfaces", "protein.pdb"], 2, "surfaces"),
        (["roughness", "protein.pdb", "-o", "x.dms"], 1, "cannot be written as '.dms'"),
        (
            ["surface", "protein.pdb", "--fields", "potential", "-o", "x.dms"],
            1,
            "--fields: .dms has no room for them",
        ),
        (
            ["minimal", "protein.pdb", "--dots", "1000000", "-o", "x.csv"],
            1,
            "n_dots is 1000000, more than the",
        ),
        (["minimal", "protein.pdb", "--dots", "2.5", "-o", "x.csv"], 2, "must be a whole number"),
        (["minimal", "protein.pdb", "--dots", "5", "--max-z", "1", "-o", "x.csv"], 2, "not allowed with"),
        (["descriptors", "protein.pdb", "--at", "9999999", "-o", "x.csv"], 1, "there is no dot 9999999"),
        (["descriptors", "protein.pdb", "--at", "1,-2", "-o", "x.csv"], 2, "must be whole numbers"),
        (
            ["minimal", "protein.pdb", "--percent", "10", "--seed", "-1", "-o", "x.csv"],
            2,
            "argument --seed: '-1' must be a whole number, 0 to 18446744073709551615",
        ),
        (["surface", "protein.pdb", "--probe", "11", "-o", "x.csv"], 2, "more than 0 and at most 10"),
        (["surface", "protein.pdb", "--density", "1e9", "-o", "x.csv"], 2, "more than 0 and at most 100"),
        (["roughness", "dots.csv", "--d-link", "inf", "-o", "x.csv"], 2, "more than 0 and at most 100"),
        (["roughness", "dots.csv", "--d-link", "0.1", "-o", "x.csv"], 1, "D_link = 0.1 Å is below 1.3 times"),
        (["roughness", "dots.csv", "--r-patch", "101", "-o", "x.csv"], 2, "more than 0 and at most 100"),
        (["descriptors", "dots.csv", "--radius", "101", "-o", "x.csv"], 2, "more than 0 and at most 100"),
        (["recover", "minimal.csv", "--density", "1e9", "-o", "x.csv"], 2, "more than 0 and at most 100"),
        (["recover", "minimal.csv", "--reach", "10.1", "-o", "x.csv"], 2, "more than 0 and at most 10"),
        (
            ["recover", "minimal.csv", "--at", "minimal.csv", "--density", "2", "-o", "x.csv"],
            1,
            "recover: --density 2: D_link = 0.5 Å is below 1.3 times the median distance",
        ),
        (
            ["recover", "minimal.csv", "--at", "minimal.csv", "--density", "2", "-o", "x.csv"],
            1,
            " Å), so every patch would fall apart; give a larger --density.",
        ),
        (
            ["recover", "minimal.csv", "--at", "minimal.csv", "--mesh", "-o", "x.ply"],
            1,
            "recover: --at writes descriptors, --mesh triangles; leave out one of the two.",
        ),
        (
            ["recover", "minimal.csv", "--at", "protein.pdb", "-o", "x.csv"],
            1,
            "protein.pdb holds no dots",
        ),
        (
            ["recover", "minimal.csv", "--mesh", "--density", "0.01", "-o", "x.ply"],
            1,
            "recover: the mesh is too coarse for the surface; increase the density.",
        ),
        (["recover", "no.csv", "--at", "minimal.csv", "-o", "x.ply"], 1, "cannot be written as '.ply'"),
        (
            ["surface", "protein.pdb", "--mesh", "-o", "x.csv"],
            1,
            "surface: x.csv: this cannot be written as '.csv'; name a file in .ply.",
        ),
        (
            ["surface", "protein.pdb", "--mesh", "-o", "-"],
            1,
            "surface: -: this cannot be written as '.csv'; name a file in .ply.",
        ),
        (
            ["minimal", "protein.pdb", "-o", "x"],
            1,
            "minimal: x: the name has no suffix; name a file in .csv, .npz, .ply, .pml, .pdb, .bild.",
        ),
        *(
            (
                [command, "dots.csv", *option.split(), "-o", "x.csv"],
                1,
                f"{command}: {option.split()[0]} has no meaning for dots.csv, which holds dots; leave it out.",
            )
            for command, option in (
                ("minimal", "--frame 7"),
                ("roughness", "--chains A"),
                ("roughness", "--trajectory run.pdb"),
                ("roughness", "--ligands ZN"),
                ("roughness", "--residues 1-9"),
                ("roughness", "--selection all"),
            )
        ),
        (["roughness", "dots.csv", "more.csv", "-o", "-"], 2, "unrecognized arguments: more.csv (one file"),
        (["roughness", ".", "-o", "-"], 1, ". is a folder: give one file"),
    ],
)
def test_a_mistake_is_one_sentence(folder, monkeypatch, capsys, arguments, code, words):
    monkeypatch.chdir(folder)
    assert ended(*arguments) == code
    shown = capsys.readouterr()
    assert shown.out == "" and words in shown.err.splitlines()[-1] and "Traceback" not in shown.err
    assert not list(folder.glob("x.*")) and not list(folder.glob(".sparsurf-*"))


@pytest.mark.parametrize("words", ["surface", "surface --mesh", "roughness", "descriptors", "minimal", "recover",
                                   "recover --mesh", "recover --at few.csv"])  # fmt: skip
@pytest.mark.parametrize(
    ("out", "told"),
    [
        ("x.foo", "x.foo: this cannot be written as '.foo'; name a file in "),
        ("a b/ü.ply", "a b/ü.ply: there is no folder "),
        ("own.ply", "own.ply is a folder; name a file."),
        (".", ". is a folder; name a file."),
    ],
)
def test_where_nothing_can_be_written_is_reported_before_anything_is_read(
    tmp_path, monkeypatch, capsys, words, out, told
):
    """The file that is read is not there, which would be told otherwise."""
    monkeypatch.chdir(tmp_path)
    name, *options = words.split()
    table = name == "descriptors" or "--at" in options
    out, told = (each.replace(".ply", ".csv") if table else each for each in (out, told))
    (tmp_path / "own.ply").mkdir()
    (tmp_path / "own.csv").mkdir()
    assert ended(name, "no.pdb", *options, "-o", out) == 1
    assert capsys.readouterr().err.startswith(f"sparsurf {name}: {told}")


@pytest.mark.parametrize(
    "words",
    [
        "roughness over.csv -o over.csv",
        "roughness over.csv -o link.csv",
        "surface a.pdb -o ./a.pdb",
        "surface a.pdb --trajectory over.csv -o over.csv",
        "recover dots.csv --at over.csv -o over.csv",
        "surface a.pdb --fields v --table over.csv -o over.csv",
    ],
)
def test_nothing_is_written_over_what_is_read(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    for name in ("over.csv", "a.pdb", "dots.csv"):
        (tmp_path / name).write_text("kept")
    (tmp_path / "link.csv").symlink_to("over.csv")
    assert ended(*words.split()) == 1
    command, out = words.split()[0], words.split("-o ")[1].split()[0]
    told = f"sparsurf {command}: {out} is a file that is read; name another one to write.\n"
    assert capsys.readouterr().err == told
    assert {path.read_text() for path in tmp_path.iterdir()} == {"kept"}


def test_a_folder_that_may_not_be_written_is_reported(tmp_path, monkeypatch, capsys):
    # not by its mode: root may write anywhere
    monkeypatch.setattr(
        os, "access", lambda path, mode: (str(path), mode) != (str(tmp_path), os.W_OK | os.X_OK)
    )
    assert ended("surface", "no.pdb", "-o", tmp_path / "x.ply") == 1
    told = f"{tmp_path / 'x.ply'}: nothing may be written into {tmp_path}; name another folder."
    assert capsys.readouterr().err == f"sparsurf surface: {told}\n"


def test_too_little_memory_is_one_sentence(folder, monkeypatch, capsys):
    monkeypatch.setattr(surface, "run", lambda asked: np.empty(2**55))
    assert ended("surface", folder / "protein.pdb", "-o", "x.csv") == 1
    assert capsys.readouterr().err == "sparsurf surface: there is not enough memory; ask for fewer dots.\n"


@pytest.mark.parametrize(
    ("error", "code", "told"),
    [
        (KeyboardInterrupt(), 130, "sparsurf surface: interrupted\n"),
        (OSError(2, "No such file", "a.pdb"), 1, "sparsurf surface: a.pdb: No such file.\n"),
        (OSError(28, "No space left"), 1, "sparsurf surface: the output: No space left.\n"),
    ],
)
def test_an_end_before_the_end_has_its_code_and_its_sentence(monkeypatch, capsys, error, code, told):
    def work(asked):
        logging.getLogger("sparsurf").info("a note")
        raise error

    log = logging.getLogger("sparsurf")
    before = list(log.handlers), log.propagate, log.level
    monkeypatch.setattr(surface, "run", work)
    assert ended("surface", "a.pdb", "-o", "x.csv") == code
    assert capsys.readouterr().err == told
    assert (
        log.handlers,
        log.propagate,
        log.level,
    ) == before  # who calls it from Python has a log of their own


def test_as_a_module_and_into_a_closed_pipe(folder, tmp_path):
    """A reader that leaves early, as `head` does, is no error; a small command loads nothing of the study."""
    call = [sys.executable, "-X", "importtime", "-m", "sparsurf", "surface", "protein.pdb", "-o", "-"]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    with open(tmp_path / "loaded", "w", encoding="utf-8") as errors:
        process = subprocess.Popen(call, cwd=folder, env=environment, stdout=subprocess.PIPE, stderr=errors)
        assert (
            process.stdout.readline()
            == b"x,y,z,nx,ny,nz,area,kind,component,chain,residue,residue_name,atom_name,atom\n"
        )
        process.stdout.close()
        assert process.wait(60) == 0
    told = (tmp_path / "loaded").read_text()
    assert "Traceback" not in told
    loaded = {line.rpartition("|")[2].strip() for line in told.splitlines()}
    assert "sparsurf.surfaces.molecular_surface" in loaded
    ours = {"sparsurf.study", "sparsurf.sampling", "sparsurf.report", "sparsurf.workflow"}
    theirs = {"snakemake", "mdtraj", "matplotlib", "scipy.spatial", "scipy.sparse", "tqdm"}
    assert not loaded & (ours | theirs)


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        (["surfce", "a.pdb"], "did you mean 'surface'? See sparsurf --help."),
        (
            ["minimal", "a.pdb", "--sampler", "farhest"],
            "did you mean 'farthest'? See sparsurf minimal --help.",
        ),
        (["compare", "a.pdb"], "). See sparsurf --help."),
        (
            ["surface", "a.pdb", "-o", "a.csv", "--chain", "A"],
            "did you mean '--chains'? See sparsurf surface --help.",
        ),
        (
            ["surface", "a.pdb", "-o", "a.csv", "--frme=3"],
            "did you mean '--frame'? See sparsurf surface --help.",
        ),
        (["--qiet"], "See sparsurf --help."),
        (  # -o is missing, too
            ["surface", "a.pdb", "--densty", "3", "--radii", "dms"],
            "unrecognized arguments: --densty; did you mean '--density'? See sparsurf surface --help.",
        ),
        (["surface", "a.pdb", "--dens", "3"], "the following arguments are required: -o/--output."),
    ],
)
def test_a_misspelt_name_is_answered_with_the_nearest(words, hint, capsys):
    with pytest.raises(SystemExit):
        command.main(words)
    assert hint in " ".join(capsys.readouterr().err.split())


def test_a_mesh_is_recovered_with_the_options(tmp_path, monkeypatch):
    """Other values than the default reach the function."""
    called = []

    def record(points, normals, step, *settings):
        called.append((len(points), *settings[:3]))
        raise InputError("that is enough")

    monkeypatch.setattr("sparsurf.recovery.mesh.recovered_mesh", record)
    k = np.arange(400) + 0.5
    polar, azimuth = np.arccos(1 - k / 200), np.pi * (1 + 5**0.5) * k
    unit = np.stack([np.sin(polar) * np.cos(azimuth), np.sin(polar) * np.sin(azimuth), np.cos(polar)], axis=1)
    table = pd.DataFrame(np.hstack([5 * unit, unit]), columns=["x", "y", "z", "nx", "ny", "nz"])
    table.to_csv(tmp_path / "few.csv", index=False)
    call = ["recover", str(tmp_path / "few.csv"), "--mesh", "-o", str(tmp_path / "m.ply")]
    assert command.main([*call, "--density", "7", "--reach", "1.7"]) != 0
    assert called == [(400, 7.0, 1.7, 4)]


def test_dots_are_recovered_with_the_options(tmp_path, monkeypatch):
    """Other values than the default reach the function."""
    called = []

    def record(few, **settings):
        called.append((len(few), settings))
        raise InputError("that is enough")

    monkeypatch.setattr("sparsurf.cli.recover.recover", record)
    few = sparsurf.surface(
        sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-212")
    )
    sparsurf.write(few[::10], tmp_path / "few.csv")
    call = ["recover", str(tmp_path / "few.csv"), "-o", str(tmp_path / "dots.csv")]
    assert command.main([*call, "--density", "7", "--reach", "1.7"]) != 0
    assert called == [(len(few[::10]), {"density": 7.0, "reach": 1.7})]


@pytest.mark.parametrize(
    ("function", "words", "wanted"),
    [
        ("roughness", "--r-patch 5 --d-link 0.7", {"radius": 5.0, "d_link": 0.7}),
        ("minimal", "--percent 8 --seed 5 --d-link 0.7", {"percent": 8.0, "seed": 5, "d_link": 0.7}),
        ("minimal", "--dots 90 --sampler poisson", {"n_dots": 90, "sampler": "poisson"}),
        ("descriptors", "--radius 5 --down --d-link 0.7", {"radius": 5.0, "up": False, "d_link": 0.7}),
        ("mesh", "--cavities remove --probe 1.5 --radii bondi", {"cavities": "remove", "probe_radius": 1.5, "radii": "bondi"}),
    ],
)  # fmt: skip
def test_options_reach_the_functions(function, words, wanted, tmp_path, monkeypatch):
    """With other values than the defaults."""
    called = []

    def record(*_, **settings):
        called.append(settings)
        raise InputError("that is enough")

    name = "surface" if function == "mesh" else function
    monkeypatch.setattr(import_module(f"sparsurf.cli.{name}"), function, record)
    call = [name, str(ROOT / "data" / "tdp43" / "topology.pdb"), "--residues", "209-212", *words.split()]
    call += (
        ["--mesh", "-o", str(tmp_path / "x.ply")] if function == "mesh" else ["-o", str(tmp_path / "x.csv")]
    )
    assert command.main(call) != 0
    assert {key: called[0][key] for key in wanted} == wanted


@pytest.mark.parametrize("kind", ["published", "rotation_robust"])
def test_descriptors_are_of_the_kind_that_is_requested(tmp_path, kind):
    call = [
        "descriptors",
        str(ROOT / "data" / "tdp43" / "topology.pdb"),
        "--residues",
        "209-212",
        "--every",
        "300",
    ]
    assert command.main([*call, "--radius", "5", "--descriptor", kind, "-o", str(tmp_path / "d.csv")]) == 0
    table = pd.read_csv(tmp_path / "d.csv")
    dots = sparsurf.surface(sparsurf.read_molecule(call[1], residues="209-212"))
    z = sparsurf.descriptors(dots, table["dot"].to_numpy(), radius=5.0, descriptor=kind)
    np.testing.assert_allclose(table.filter(regex="^z_"), z, rtol=1e-3, atol=1e-3)


@pytest.mark.parametrize(
    ("given", "settings"),
    [
        ([], {"density": "auto", "probe_radius": 1.4, "radii": "dms", "cavities": "keep"}),
        (
            ["--density", "7", "--probe", "1.5", "--radii", "bondi", "--cavities", "remove"],
            {"density": 7.0, "probe_radius": 1.5, "radii": "bondi", "cavities": "remove"},
        ),
    ],
)
def test_rules_of_dots_reach_the_function(tmp_path, monkeypatch, given, settings):
    called = []

    def record(molecule, **keys):
        called.append(keys)
        raise InputError("that is enough")

    monkeypatch.setattr("sparsurf.cli.surface.surface", record)
    path = str(ROOT / "data" / "tdp43" / "topology.pdb")
    assert command.main(["surface", path, "-o", str(tmp_path / "dots.csv"), *given]) != 0
    assert called == [settings | {"frame": 0}]


def test_every_dot_is_described_the_last_one_too(folder, tmp_path):
    call = ["descriptors", folder / "minimal.csv", "--d-link", 3, "--every", 1]
    assert ended(*call, "-o", tmp_path / "z.csv") == 0
    n = len(pd.read_csv(folder / "minimal.csv"))
    assert pd.read_csv(tmp_path / "z.csv")["dot"].tolist() == list(range(n))


@pytest.mark.parametrize(("variable", "streams"), HABITS)
def test_habits_of_a_machine_change_nothing(tmp_path, variable, streams):
    (tmp_path / "é {x}").mkdir()
    (tmp_path / "é {x}" / "s <x>.pdb").write_text(peptide(["GLY", "ALA"]) + "END\n")
    order = f'{variable} "{sys.executable}" -m sparsurf surface "é {{x}}/s <x>.pdb" -o é.npz {streams}'
    environment = {"env": os.environ | {"PYTHONPATH": str(ROOT / "src")}, "cwd": tmp_path}
    done = subprocess.run(order, shell=True, **environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert len(sparsurf.read_surface(tmp_path / "é.npz")) > 100
