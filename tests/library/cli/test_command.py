"""The command line: every example of its help runs, every mistake is a sentence, what comes out can be read again."""

import importlib.util
import logging
import os
import re
import shlex
import shutil
import subprocess
import sys

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from peptides import atom_line, peptide
from sparsurf import registry
from sparsurf.cli import command, minimal, surface
from sparsurf.molecules.formats import MOLECULE_FORMATS
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.recovery.errors import distance_to_recovered
from sparsurf.recovery.reconstructing import reconstruct
from sparsurf.settings import Settings
from sparsurf.surfaces.components import summarize_components, volume_in_words
from sparsurf.views.numbers import number
from sparsurf_study.batches.analysis import Structure, analyse_batch
from sparsurf_study.batches.tables import write_parquet
from sparsurf_study.config.check import check_config

TDP43 = ROOT / "data" / "tdp43" / "topology.pdb"
HABITS = (  # of a machine: environment, and what stands behind the command
    ("LC_ALL=C PYTHONUNBUFFERED=1", "<&- >&- 2>&-"),
    ("NUMBA_NUM_THREADS=0 PYTHONWARNINGS=error::ResourceWarning", ">&-"),
)
EXAMPLES = sorted(
    {line.strip() for name in command.COMMANDS for line in [*command.EPILOG.splitlines(),
     *command.build_parser(name)[1].epilog.splitlines()] if line.startswith("  sparsurf ")}
)  # fmt: skip


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
    part = read_molecule(TDP43, residues="209-216")
    part.write_pdb(place / "protein.pdb", b_factor=np.arange(part.n_atoms) % 90.0)
    (place / "apbs.dx").write_text(
        "object 1 class gridpositions counts 2 2 2\norigin 0 0 0\ndelta 99 0 0\ndelta 0 99 0\ndelta 0 0 99\n"
        "object 3 class array type double rank 0 items 8 data follows\n0 1 2 3 4 5 6 7\n"
    )
    (place / "own.csv").write_text("residue,score\n209,0.5\n210,0.7\n")
    shutil.copy(place / "protein.pdb", place / "run.pdb")
    write_run_in_batches(place)
    (place / "models.pdb").write_text(models(place / "protein.pdb", 3))
    for name, chains in (("complex", "ABCD"), ("fab_antigen", "HLG"), ("myoglobin", "A")):
        parts = [peptide(["ALA"] * 2, chain, origin=(0, 5 * k, 0)) for k, chain in enumerate(chains)]
        if name == "myoglobin":
            parts.append(atom_line("FE", "HEM", "A", "154", (2, 5, 0), record="HETATM", element="FE"))
        (place / f"{name}.pdb").write_text("TER\n".join(parts) + "END\n")
    sparsurf.surface_atoms(place / "protein.pdb").write(place / "few.xyzr")
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


def models(path, n, stretch=0.01, shift=0.0):
    """Text of a PDB file with n models, each stretched and shifted (Å) a little more along x."""
    lines = [line for line in path.read_text().splitlines() if line.startswith("ATOM")]
    moved = [
        [f"{line[:30]}{float(line[30:38]) * (1 + stretch * k) + shift * k:8.3f}{line[38:]}" for line in lines]
        for k in range(n)
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
        pytest.skip("test_options.py has the files for it")
    if "results/many" in line:
        pytest.importorskip("pyarrow")
    folder = shutil.copytree(folder, tmp_path / "own")  # an example overwrites what others read
    monkeypatch.chdir(folder)
    for display in ("DISPLAY", "WAYLAND_DISPLAY"):  # so that no browser opens
        monkeypatch.setenv(display, "")
    words = shlex.split(line.split("|")[0].split(">")[0])[1:]
    assert ended(*words) == 0
    shown = capfd.readouterr()
    told = [each for each in shown.err.splitlines() if not each.startswith("Compiling")]
    if "-o" in words:
        out = words[words.index("-o") + 1]
        begins = ("wrote ", "coloured by ", "The ", "Its Z is", "sparsurf: warning: protein.pdb: ")
        assert all(each.startswith(begins) for each in told) and (out == "-") == (told == [])
        assert shown.out.count("\n") > 1 if out == "-" else (folder / out).stat().st_size > 100


def test_every_sentence_about_formats_names_each_that_is_read(folder, capsys):
    """By the last word of its label, such as the CARD of CHARMM."""
    (folder / "notes.txt").write_text("Of the protein\n")
    ended("surface", folder / "notes.txt", "-o", "-")
    refusal, texts = capsys.readouterr().err, []
    for path in ("docs/trajectory.md", "docs/reference/config.md"):
        texts.append((ROOT / path).read_text(encoding="utf-8"))
    texts.append(
        "".join(command.build_parser(name)[-1].format_help() for name in command.COMMANDS) + command.EPILOG
    )
    texts.append(sparsurf.read_molecule.__doc__)
    for entry in (entry for entry in MOLECULE_FORMATS.values() if entry.atoms or entry.places):
        word = re.compile(rf"\b{entry.label.split()[-1]}\b")
        assert all(word.search(text) for text in texts), entry.label
        assert word.search(refusal) or not entry.atoms, entry.label
    for suffix in registry.suffixes("dots", is_read=True):
        assert suffix in command.EPILOG and suffix in texts[1]


@pytest.mark.parametrize("name", [None, *command.COMMANDS])
def test_the_help_fits_a_terminal_and_explains_every_option(name, capsys):
    parsers = [parser for parser in command.build_parser(name) if parser]
    assert ended(*([name] if name else []), "--help") == 0
    assert "examples:" in capsys.readouterr().out
    assert max(map(len, parsers[-1].epilog.splitlines())) <= 80 and "  sparsurf " in parsers[-1].epilog
    assert all(action.help for action in parsers[-1]._actions if action.dest != "command")


def test_the_help_lists_the_formats_of_structures_and_of_trajectories(capsys):
    formats = [each for each in MOLECULE_FORMATS.values() if each.atoms or each.places]
    for words, listed in (
        (["--help"], [each for each in formats if each.atoms]),
        (["frames", "--help"], [each for each in formats if not each.atoms]),
    ):
        assert ended(*words) == 0
        told = " ".join(capsys.readouterr().out.split())
        assert not [each.label for each in listed if each.label.removeprefix("CHARMM ") not in told]


def test_the_version_and_an_automatic_density_without_a_warning(folder, tmp_path, capfd):
    assert ended("surface", folder / "protein.pdb", "-q", "-o", tmp_path / "all.csv") == 0
    assert capfd.readouterr() == ("", "")
    assert ended("--version") == 0
    assert capfd.readouterr().out == f"sparsurf {sparsurf.__version__}\n"
    assert ended("--help") == 0
    shown = capfd.readouterr().out
    assert all(name in shown for name in command.COMMANDS) and ended() == 2


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
    place = TDP43
    for asked, words in (
        ("keep", "5 components, of which 4 cavities with 426 dots"),
        ("remove", "1 component\n"),
    ):
        assert ended("surface", place, "--cavities", asked, "-o", tmp_path / "d.csv") == 0
        assert words in capsys.readouterr().err
        table = pd.read_csv(tmp_path / "d.csv")
        assert len(table) - (table["component"] == 0).sum() == (426 if asked == "keep" else 0)
    assert ended("minimal", tmp_path / "d.csv", "--n-dots", 50, "-o", tmp_path / "m.csv") == 0
    assert pd.read_csv(tmp_path / "m.csv")["weight"].sum() == 24600 - 426


def test_roughness_is_that_of_the_call_and_not_of_the_file_in_every_format(folder, tmp_path):
    ends = ("csv", "npz")
    for radius, name in ((6, "first.csv"), *((3, f"second.{end}") for end in ends)):
        own = folder / "protein.pdb" if radius == 6 else tmp_path / "first.csv"
        assert ended("roughness", own, "--r-patch", radius, "-o", tmp_path / name) == 0
    assert ended("roughness", tmp_path / "first.csv", "--r-patch", 3, "-o", tmp_path / "second.html") == 0
    assert "within 3&nbsp;Å" in (tmp_path / "second.html").read_text(encoding="utf-8")
    first, second = (pd.read_csv(tmp_path / f"{name}.csv")["roughness"] for name in ("first", "second"))
    assert abs(first - second).mean() > 0.01
    with np.load(tmp_path / "second.npz") as held:
        assert np.allclose(held["roughness"], second, atol=1e-4)


def test_several_ligands_are_taken_with_the_protein(tmp_path):
    atoms = [("C1", "LIG", 7.0), ("C1", "OTH", 14.0), ("C1", "NOT", 21.0)]
    text = peptide() + "".join(
        atom_line(name, residue, "L", str(k), (0, y, 0), record="HETATM", element="C")
        for k, (name, residue, y) in enumerate(atoms, 1)
    )
    (tmp_path / "holo.pdb").write_text(text + "END\n")
    assert ended("surface", tmp_path / "holo.pdb", "--ligands", "LIG, OTH,", "-o", tmp_path / "x.csv") == 0
    assert {*pd.read_csv(tmp_path / "x.csv")["residue_name"]} == {"ALA", "LIG", "OTH"}


def test_a_frame_of_several_is_the_first_with_a_word(folder, tmp_path, capsys):
    import mdtraj

    mdtraj.load(str(folder / "models.pdb")).save_gro(str(tmp_path / "m.gro"))
    call = ["-o", tmp_path / "x.csv"]
    for name, what in ((tmp_path / "m.gro", "frames"), (folder / "models.pdb", "models")):
        assert ended("surface", name, *call) == 0
        assert (
            f"has 3 {what}; the first one is used, and --frame chooses another one."
            in capsys.readouterr().err
        )
        for options in (["--frame", 0], ["--quiet"]):  # chosen, or nothing is to be said
            assert ended("surface", name, *options, *call) == 0
            assert "the first one" not in capsys.readouterr().err


@pytest.mark.parametrize("protein", ["loaded", "still"])
def test_a_study_and_the_command_hand_out_the_same_subset(study, tmp_path, protein):
    """Whatever the study calls the protein; what sets the size, and the seed, are the same by default."""
    (folder,) = (path.parent for path in (study / "results" / "small" / protein).glob("*/minimal.csv"))
    assert (
        ended("minimal", study / f"{protein}.pdb", "--fields", "hydropathy", "-o", tmp_path / "own.csv") == 0
    )
    few = pd.read_csv(tmp_path / "own.csv")
    pd.testing.assert_frame_equal(few, pd.read_csv(folder / "minimal.csv")[[*few]])
    fresh = sparsurf.surface(study / f"{protein}.pdb", density=15)
    points, normals = (few[names].to_numpy() for names in (["x", "y", "z"], ["nx", "ny", "nz"]))
    errors = distance_to_recovered(fresh.points, points, normals, 1, density=20.0)
    known = pd.read_csv(folder / "recovered.csv")
    assert known["mean"][0] == pytest.approx(errors.mean(), rel=0.03)  # of other dots


def test_without_a_size_the_surface_comes_back_within_two_hundredths_of_an_angstrom(folder, tmp_path, capsys):
    true = sparsurf.surface(folder / "protein.pdb", density=15).points

    def told_and_measured(*size):
        assert ended("minimal", folder / "protein.pdb", *size, "-o", tmp_path / "few.csv") == 0
        told = re.search(r"deviates by ([\d.]+) Å on average \(99 %: ([\d.]+) Å", capsys.readouterr().err)
        dense = sparsurf.recover(sparsurf.read_surface(tmp_path / "few.csv"), density=30)
        dots = cKDTree(dense.points).query(true, 4)[1]  # beside a crease, the nearest dot may lie behind it
        distances = np.abs(((true[:, None] - dense.points[dots]) * dense.normals[dots]).sum(axis=2)).min(
            axis=1
        )
        return (*map(float, told.groups()), distances.mean(), np.quantile(distances, 0.99))

    mean, tail, measured_mean, measured_tail = told_and_measured()
    assert max(mean, measured_mean) < 0.02 and max(tail, measured_tail) < 0.1
    mean, _, measured_mean, _ = told_and_measured("--percent", 2)
    assert min(mean, measured_mean) > 0.02


def test_normals_that_point_inward_are_reported_of(folder, tmp_path, capfd):
    table = pd.read_csv(folder / "minimal.csv")
    assert ended("recover", folder / "minimal.csv", "--mesh", "-o", tmp_path / "mesh.ply") == 0
    assert "point inward" not in capfd.readouterr().err
    table[["nx", "ny", "nz"]] *= -1
    table.to_csv(tmp_path / "inside.csv", index=False)
    assert ended("recover", tmp_path / "inside.csv", "--mesh", "-o", tmp_path / "mesh.ply") == 0
    assert "normals point inward" in capfd.readouterr().err


def test_residues_with_negative_numbers_are_no_option(folder, tmp_path, capfd):
    for words in (["--residues", "-3-2"], ["--residues=-3-2"]):
        assert ended("surface", folder / "protein.pdb", *words, "-o", tmp_path / "o.csv") == 1
        assert "expected one argument" not in capfd.readouterr().err
    assert ended("surface", folder / "protein.pdb", "--residues", "-3-212", "-o", tmp_path / "o.csv") == 0
    assert set(pd.read_csv(tmp_path / "o.csv")["residue"]) == {*range(209, 213)}


def test_residues_are_reported_as_they_lie_in_the_whole_molecule(folder, tmp_path):
    """Their dots, roughness, descriptors and area are those of the surface of all atoms; a selection cuts it."""
    path, own = folder / "protein.pdb", ["--residues", "211-212"]
    dots = sparsurf.surface(path)
    frame = dots.to_frame()
    inside = np.flatnonzero(frame["residue"].isin(["211", "212"]))
    for name in ("surface", "roughness", "descriptors", "residues"):
        options = ["--every", 50] if name == "descriptors" else []
        assert ended(name, path, *own, *options, "-o", tmp_path / f"{name}.csv") == 0
    of = {name: pd.read_csv(tmp_path / f"{name}.csv") for name in ("surface", "roughness", "descriptors")}
    assert np.allclose(of["surface"][["x", "y", "z"]], dots.points[inside], atol=1e-3)
    assert np.allclose(of["roughness"]["roughness"], sparsurf.roughness(dots)[inside], atol=1e-4)
    assert of["descriptors"]["dot"].tolist() == inside[::50].tolist()
    assert np.allclose(of["descriptors"][["x", "y", "z"]], dots.points[inside[::50]], atol=1e-3)
    for name in ("surface", "roughness"):  # each dot with its own labels
        assert of[name]["residue"].astype(str).tolist() == frame["residue"][inside].tolist()
        assert of[name]["atom_name"].tolist() == frame["atom_name"][inside].tolist()
    assert np.allclose(of["surface"]["area"], dots.area[inside], atol=1e-4)
    assert of["surface"]["kind"].tolist() == dots.kind[inside].tolist()
    table = pd.read_csv(tmp_path / "residues.csv")
    assert table["residue"].tolist() == [211, 212] and table["dots"].sum() == len(inside)
    exact = sparsurf.areas(path).residues.set_index("residue").loc[table["residue"].astype(str), "excluded"]
    assert table["area"].to_numpy() == pytest.approx(exact.to_numpy(), abs=1e-4)
    assert ended("surface", path, "--selection", "residue 211 to 212", "-o", tmp_path / "cut.csv") == 0
    assert len(pd.read_csv(tmp_path / "cut.csv")) > 1.2 * len(inside)


def test_minimal_prints_its_error_and_warns_of_gaps(folder, tmp_path, capsys):
    call = [
        "minimal",
        folder / "protein.pdb",
        "--percent",
        20,
        "--model",
        "interpolant",
        "-o",
        tmp_path / "m.csv",
    ]
    assert ended(*call) == 0
    shown = capsys.readouterr().err
    few, fresh = (
        sparsurf.read_surface(tmp_path / "m.csv"),
        sparsurf.surface(folder / "protein.pdb", density=15),
    )
    errors = distance_to_recovered(fresh.points, few.points, few.normals, 1, 20.0)
    told = re.search(r"deviates by ([\d.]+) Å on average \(99 %: ([\d.]+) Å, largest: ([\d.]+) Å", shown)
    mean, of_most, largest = map(float, told.groups())
    assert mean == pytest.approx(errors.mean(), abs=0.0015)  # of other dots, with three decimals
    assert of_most == pytest.approx(np.quantile(errors, 0.99), rel=0.15) and of_most < largest
    assert re.search(r"Its Z is 0\.\d+: an identical surface has a Z of 0", shown) and "too few" not in shown
    assert ended("minimal", folder / "protein.pdb", "--n-dots", 9, "-o", tmp_path / "m.csv") == 0
    assert "warning: minimal: 9" in capsys.readouterr().err


def test_each_command_reports_what_it_wrote(folder, tmp_path, monkeypatch, capfd):
    """In numbers of the function that does the same."""
    monkeypatch.chdir(folder)
    dots, few = sparsurf.surface("protein.pdb"), sparsurf.read_surface("minimal.csv")
    part = dots[np.isin(dots.to_frame()["residue"], ["211", "212"])]
    of_part = (
        sparsurf.areas(dots.molecule).residues.set_index("residue").loc[["211", "212"], "excluded"].sum()
    )
    mesh, recovered = sparsurf.mesh("protein.pdb"), sparsurf.mesh("minimal.csv")
    smallest, interpolated = (
        sparsurf.minimal(dots),
        sparsurf.minimal(dots, error=0.2, reconstruction="interpolant"),
    )
    low, high = (number(100 * end / len(dots), 1) for end in interpolated.interval)
    volume = volume_in_words(summarize_components(sparsurf.components(dots)[1]))
    dense, share = sparsurf.recover(few), reconstruct(few).share
    assert 0.5 < share < 0.99

    def per_area(n):
        density = n / dots.area.sum()
        return (
            f"{density:.2f}" if density >= 0.1 else f"{density:.3f}"
        )  # two digits that are not leading zeros

    words = {
        "surface protein.pdb": f"{len(dots):,} dots, {dots.total_area:,.0f} Å^2, {volume}; 1 component",
        "surface protein.pdb --residues 211-212": f"{len(part):,} of {len(dots):,} dots, {of_part:,.0f} Å^2 of "
        f"{dots.total_area:,.0f} Å^2",
        "surface protein.pdb --mesh": f"{len(mesh.triangles):,} triangles, {mesh.volume:,.0f} Å^3",
        "roughness protein.pdb": f"{len(dots):,} dots, mean roughness {sparsurf.roughness(dots).mean():.3f}",
        "residues protein.pdb": f"8 residues, {dots.total_area:,.0f} Å^2",
        "residues protein.pdb --residues 211-212": f"2 residues, {of_part:,.0f} Å^2",
        "descriptors protein.pdb --every 500": f"{-(-len(dots) // 500)} patches",
        "recover minimal.csv": f"{len(dense):,} dots from {len(few):,}; {100 * share:.0f} % of these lie on spheres of "
        "inferred atoms",
        "recover minimal.csv --at one.csv": "1 patches",
        "recover minimal.csv --mesh": f"{len(recovered.triangles):,} triangles, {recovered.volume:,.0f} Å^3 from {len(few):,} "
        "dots",
        "points protein.pdb -n 60": "60 points on the surface",
        "minimal protein.pdb --percent 5": f"{round(len(dots) / 20)} of {len(dots):,} dots (5 %; "
        f"{per_area(round(len(dots) / 20))} per Å^2), chosen by farthest point",
        "minimal protein.pdb": f"{len(smallest)} of {len(dots):,} dots ({number(100 * len(smallest) / len(dots), 1)} %; "
        f"{per_area(len(smallest))} per Å^2), determining the atoms",
        "minimal protein.pdb --reconstruction interpolant --error 0.2": f"{len(interpolated)} of {len(dots):,} dots "
        f"({number(100 * len(interpolated) / len(dots), 1)} %; 95 % interval {low} to {high} %; "
        f"{per_area(len(interpolated))} per Å^2), chosen by farthest point",
        "minimal protein.pdb --error 1e-9": f"{len(dots):,} of {len(dots):,} dots (100 %; {per_area(len(dots))} per Å^2), "
        "chosen by farthest point",
    }  # fmt: skip
    for call, told in words.items():
        out = tmp_path / ("x.ply" if "--mesh" in call or "points" in call else "x.csv")
        assert ended(*call.split(), "-o", out) == 0
        assert f"wrote {out}: {told}\n" in capfd.readouterr().err, call


def test_a_terminal_shows_what_is_being_done(folder, tmp_path, monkeypatch, capsys):
    """With the numbers of atoms and of dots; logs and pipes do not."""
    n_atoms, n_dots = (
        read_molecule(folder / "protein.pdb").n_atoms,
        len(sparsurf.surface(folder / "protein.pdb")),
    )
    for on_terminal in (True, False):
        monkeypatch.setattr(sys.stderr, "isatty", lambda on_terminal=on_terminal: on_terminal, raising=False)
        for name, done in (
            ("surface", f"surface of {n_atoms:,} atoms ..."),
            ("roughness", f"surface of {n_atoms:,} atoms ..."),
            ("minimal --percent 5", f"choosing among {n_dots:,} dots ..."),
        ):
            command_name, *options = name.split()
            assert ended(command_name, folder / "protein.pdb", *options, "-o", tmp_path / "x.csv") == 0
            assert (f"{done}\n" in capsys.readouterr().err) == on_terminal


@pytest.mark.parametrize("widest", [1.0, 100.0])
def test_a_wide_interval_of_the_number_of_dots_is_reported(folder, tmp_path, monkeypatch, capsys, widest):
    """As a ratio of its ends, which differ."""
    monkeypatch.setattr(minimal, "WIDE", widest)
    call = ["minimal", folder / "protein.pdb", "--sampler", "farthest", "-o", tmp_path / "m.csv"]
    assert ended(*call) == 0
    told = capsys.readouterr().err
    assert ("The interval is wide: --percent keeps a fixed share" in told) == (widest == 1.0)
    low, high = map(float, re.search(r"95 % interval ([\d.]+) to ([\d.]+) %", told).groups())
    assert low < high


def test_the_z_of_a_subset_and_of_the_mean_patch_are_those_of_a_comparison(folder, tmp_path, capsys):
    dots = sparsurf.surface(folder / "protein.pdb")
    few = sparsurf.minimal(dots, percent=20)
    row = sparsurf.compare(dots, few, reading="recovered").iloc[0]
    assert ended("minimal", folder / "protein.pdb", "--percent", 20, "-o", tmp_path / "m.csv") == 0
    told = re.findall(r"a? Z (?:of|is) (\d\.\d\d)\b", capsys.readouterr().err)
    assert told == [f"{row['Z']:.2f}", f"{row['Z_mean_descriptor']:.2f}"] and told[0] != told[1]


MISTAKES = [  # one of each kind: the command, its exit code, and what its sentence holds
    ("surface no.pdb -o x.csv", 1, "no.pdb does not exist"),
    ("surface . -o x.csv", 1, ". is a folder; give one structure"),
    ("surface dots.csv -o x.csv", 1, "dots.csv holds dots, and dots hold no atoms"),
    ("surface protein.pdb", 2, "-o/--output"),
    ("surface protein.pdb --frame 1 -o x.csv", 1, "no frame 1"),
    ("surface protein.pdb --chains Q -o x.csv", 1, "chain"),
    ("surface protein.pdb --mesh --residues 209 -o x.ply", 1, "--residues selects dots"),
    ("surface protein.pdb --mesh -o x.dms", 1, "cannot be written as '.dms'; name a file that ends in .ply"),
    ("show protein.pdb -o x.csv", 1, "cannot be written as '.csv'; name a file that ends in .html"),
    ("show protein.pdb -o x.png", 1, "or draw a picture by `sparsurf roughness FILE -o NAME.png`"),
    ("show dots.csv --frame 1 -o x.html", 1, "--frame has no meaning for dots.csv"),
    ("show frames.csv -o x.html", 1, "frames.csv holds the dots of 2 frames"),
    ("residues dots.csv -o x.csv", 1, "dots.csv holds dots, which have no residues"),
    ("surface protein.pdb --fields , -o x.csv", 1, "--fields contains no name"),
    ("surface protein.pdb --ligands= -o x.csv", 1, "--ligands contains no name"),
    ("minimal protein.pdb --model=--3 -o x.csv", 2, "'--3' is not the number of a model of the file"),
    ("minimal protein.pdb --model=\N{SUPERSCRIPT TWO} -o x.csv", 2, "is not the number of a model"),
    ("minimal protein.pdb --model 7 --model 5 -o x.csv", 2, "--model is given twice; give it once"),
    ("surface protein.pdb b.pdb -o x.csv", 2, "a study takes a folder). See sparsurf surface --help."),
    ("surface protein.pdb --fields potential -o x.dms", 1, "--fields: .dms"),
    ("surface protein.pdb --mesh --fields hydropath -o x.ply", 1, "no field 'hydropath'; did you mean 'hydropathy'"),
    ("frames protein.pdb --fields rougness -o x.csv", 1, "always has the column mean_roughness; leave 'rougness' out"),
    ("residues protein.pdb --fields hydropathy,roughness -o x.csv", 1, "mean_roughness; leave 'roughness' out"),
    ("frames protein.pdb --fields hydropaty -o x.csv", 1, "no field 'hydropaty'; did you mean 'hydropathy'?"),
    ("roughness dots.csv --d-link 0.1 -o x.csv", 1, "--d-link = 0.1"),
    ("roughness dots.csv more.csv -o -", 2, "one file at a time, the rest are options such as --trajectory"),
    ("frames protein.pdb --frame 3 -o -", 2, "residues --frame measures one"),
    ("roughness . -o -", 1, "folder"),
    ("descriptors protein.pdb --at 9999999 -o x.csv", 1, "no dot 9999999"),
    ("descriptors protein.pdb --at 1,-2 -o x.csv", 2, "--at: '1,-2'"),
    ("minimal protein.pdb --n-dots 9 --error-99 1 -o x.csv", 1, "an error; leave out --n-dots or --error-99"),
    ("minimal protein.pdb --n-dots 1000000 -o x.csv", 1, "--n-dots is 1000000"),
    ("minimal protein.pdb --n-dots 5 --percent 1 -o x.csv", 2, "not allowed with"),
    ("minimal one.csv -o x.csv", 1, "a single dot"),
    ("minimal one.csv --n-dots 1 -o x.csv", 1, "a single dot"),
    ("recover frames.csv -o x.csv", 1, "frames.csv holds the dots of 2 frames"),
    ("recover minimal.csv --at '' -o x.csv", 1, "a path is empty"),
    ("recover minimal.csv --at protein.pdb -o x.csv", 1, "protein.pdb holds no dots"),
    ("recover minimal.csv --at minimal.csv --density 2 -o x.csv", 1, "denser surface"),
    ("recover minimal.csv --at minimal.csv --mesh -o x.ply", 1, "--at writes descriptors, and --mesh writes triangles"),
    ("recover minimal.csv --mesh --step 0.5 --density 3 -o x.ply", 1, "either --density or --step"),
    ("surface protein.pdb --step 0.5 -o x.ply", 1, "add --mesh, or leave the option out"),
    ("roughness dots.csv --chains A -o x.csv", 1, "--chains has no meaning for dots.csv"),
    ("roughness dots.csv --trajectory run.pdb -o x.csv", 1, "--trajectory has no meaning for dots.csv"),
    ("roughness dots.csv -o x.csv --output y.csv", 2, "--output is given twice; give it once"),
    ("surface protein.pdb --probe-radius 1.4 --probe-radius 2 -o x.csv", 2, "--probe-radius is given twice"),
    ("descriptors dots.csv --every 0 -o x.csv", 2, "--every: '0' is invalid"),
]  # fmt: skip


@pytest.mark.parametrize(("line", "code", "words"), MISTAKES)
def test_a_mistake_is_one_sentence(folder, monkeypatch, capsys, line, code, words):
    monkeypatch.chdir(folder)
    assert ended(*shlex.split(line)) == code
    shown = capsys.readouterr()
    assert shown.out == "" and words in shown.err.splitlines()[-1] and "Traceback" not in shown.err
    assert not list(folder.glob("x.*")) and not list(folder.glob(".sparsurf-*"))


@pytest.mark.parametrize("words", ["show", "surface", "surface --mesh", "roughness", "descriptors", "minimal", "recover",
                                   "recover --mesh", "recover --at few.csv"])  # fmt: skip
def test_where_nothing_can_be_written_is_reported_before_anything_is_read(
    tmp_path, monkeypatch, capsys, words
):
    """The file that is read is not there, which would be told otherwise."""
    monkeypatch.chdir(tmp_path)
    name, *options = words.split()
    end = "csv" if name == "descriptors" or "--at" in options else "html" if name == "show" else "ply"
    (tmp_path / f"own.{end}").mkdir()
    for out, told in (("x.foo", "'.foo'; name a file that ends in "), (f"a b/ü.{end}", "there is no folder"),
                      (f"own.{end}", "is a folder"), ("x", "no suffix"), (f"{'é' * 126}.{end}", "cannot name a file"),
                      (f"a\0.{end}", "cannot name a file")):  # fmt: skip
        assert ended(name, "no.pdb", *options, "-o", out) == 1
        shown = capsys.readouterr().err
        assert told in shown and "no.pdb" not in shown
    monkeypatch.setattr(os, "access", lambda path, _: str(path) != str(tmp_path))  # root may write anywhere
    assert ended(name, "no.pdb", *options, "-o", f"x.{end}") == 1
    assert "write into" in capsys.readouterr().err


@pytest.mark.parametrize(
    "words",
    ["roughness over.csv -o over.csv", "roughness over.csv -o link.csv", "surface a.pdb -o ./a.pdb",
     "surface a.pdb --trajectory over.csv -o over.csv", "recover dots.csv --at over.csv -o over.csv",
     "frames run_frames.csv -o run.csv", "surface x.face --mesh -o x.vert", "recover x.face --mesh -o x.vert"],
)  # fmt: skip
def test_nothing_is_written_over_what_is_read(tmp_path, monkeypatch, capsys, words):
    monkeypatch.chdir(tmp_path)
    for name in ("over.csv", "a.pdb", "dots.csv", "run_frames.csv", "x.face"):
        (tmp_path / name).write_text("old")
    (tmp_path / "link.csv").symlink_to("over.csv")
    assert ended(*words.split()) == 1
    assert "file; name another" in capsys.readouterr().err
    assert {path.read_text() for path in tmp_path.iterdir()} == {"old"}


@pytest.mark.parametrize(
    ("error", "code", "told"),
    [(KeyboardInterrupt(), 130, "interrupted"), (MemoryError(), 1, "there is not enough memory"), (OSError(2,
     "No such file", "a.pdb"), 1, "a.pdb: No such file"),
     (OSError(28, "No space left"), 1, "the output: No space left. Free space")],
)  # fmt: skip
def test_an_end_before_the_end_has_its_code_and_its_sentence(monkeypatch, capsys, error, code, told):
    def work(_):
        logging.getLogger("sparsurf").info("a note")
        raise error

    log = logging.getLogger("sparsurf")
    before = list(log.handlers), log.propagate, log.level
    monkeypatch.setattr(surface, "run", work)
    assert ended("surface", "a.pdb", "-o", "x.csv") == code
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith(f"sparsurf surface: {told}")
    assert (
        log.handlers,
        log.propagate,
        log.level,
    ) == before  # who calls it from Python has a log of their own


def test_as_a_module_and_into_a_closed_pipe(folder, tmp_path):
    """A reader that leaves early, as `head` does, is no error; a small command loads nothing of the study."""
    call = [sys.executable, "-X", "importtime", "-m", "sparsurf", "surface", "protein.pdb", "-o", "-"]
    environment = os.environ | {"PYTHONPATH": str(ROOT / "src")}
    # a process that compiles kernels loads what compiles them; after an installation they are stored
    subprocess.run(
        [*call[:-1], tmp_path / "first.csv"], cwd=folder, env=environment, capture_output=True, check=True
    )
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
    ours = {"sparsurf.sampling", "sparsurf.recovery", "sparsurf.views"}
    theirs = {"snakemake", "mdtraj", "matplotlib", "scipy.spatial", "scipy.sparse", "tqdm"}
    assert not loaded & (ours | theirs) and not any(name.startswith("sparsurf_study") for name in loaded)


@pytest.mark.parametrize(
    ("words", "hint"),
    [
        ("surfce a.pdb", "you mean 'surface'?"),
        ("sasa a.pdb", "write `sparsurf areas`"),
        ("Contact a.pdb", "write `sparsurf areas --of contacts`"),
        ("minimal a.pdb --sampler farhest", "did you mean 'farthest'? See sparsurf minimal --help."),
        ("surface a.pdb -o a.csv --frme=3", "you mean '--frame'?"),
        (
            "surface a.pdb --densty 3",
            "unrecognized arguments: --densty; did you mean '--density'?",
        ),  # -o is missing
        ("surface a.pdb --densty 3 --radius 2", "unrecognized arguments: --densty"),
        ("surface a.pdb --dens 3", "required: -o/--output"),
        ("compare a.pdb", "invalid choice: 'compare'"),
        ("--qiet", "See sparsurf --help."),
    ],
)
def test_a_misspelt_name_is_answered_with_the_nearest(words, hint, capsys):
    assert ended(*words.split()) == 2
    assert hint in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize(("variable", "streams"), HABITS)
def test_habits_of_a_machine_change_nothing(tmp_path, variable, streams):
    (tmp_path / "é {x}").mkdir()
    (tmp_path / "é {x}" / "s <x>.pdb").write_text(peptide(["GLY", "ALA"]) + "END\n")
    order = f'{variable} "{sys.executable}" -m sparsurf surface "é {{x}}/s <x>.pdb" -o é.npz {streams}'
    environment = {"env": os.environ | {"PYTHONPATH": str(ROOT / "src")}, "cwd": tmp_path}
    done = subprocess.run(order, shell=True, **environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "Traceback" not in done.stderr, done.stderr
    assert len(sparsurf.read_surface(tmp_path / "é.npz")) > 100
