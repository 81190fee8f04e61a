"""Calls and options of version 5 that have another form since version 6: they do the same, and say what to write."""

import re
from pathlib import Path

import numpy as np
import pytest

import sparsurf
from sparsurf.cli import command
from sparsurf.settings import Minimal

ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    path = tmp_path_factory.mktemp("old") / "peptide.pdb"
    sparsurf.write(sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", residues="209-218"), path)
    return path


@pytest.fixture(scope="module")
def dots(path):
    return sparsurf.surface(path)


OLD_CALLS = {
    "minimal(..., model)": (
        lambda d: sparsurf.minimal(d, error=0.05, model="interpolant").dots,
        lambda d: sparsurf.minimal(d, error=0.05, reconstruction="interpolant").dots,
        "minimal: write reconstruction='interpolant' in place of model='interpolant'",
    ),
    "recover(..., model)": (
        lambda d: sparsurf.recover(d[::20], model="interpolant"),
        lambda d: sparsurf.recover(d[::20], reconstruction="interpolant"),
        "recover: write reconstruction='interpolant'",
    ),
    "density_for(..., model)": (
        lambda d: sparsurf.density_for(0.02, model="spheres"),
        lambda d: sparsurf.density_for(0.02, reconstruction="spheres"),
        "density_for: write reconstruction='spheres'",
    ),
    "error_at(..., model)": (
        lambda d: sparsurf.error_at(0.6, model="spheres"),
        lambda d: sparsurf.error_at(0.6, reconstruction="spheres"),
        "error_at: write reconstruction='spheres'",
    ),
    "Subset.model": (
        lambda d: sparsurf.minimal(d, percent=10).model == "interpolant",
        lambda d: True,
        "write .reconstruction",
    ),
    "residues(dots, molecule)": (
        lambda d: sparsurf.residues(d, d.molecule)[["area", "mean_roughness"]],
        lambda d: sparsurf.residues(d.molecule, d)[["area", "mean_roughness"]],
        "residues(molecule, dots)",
    ),
    "residues(dots, molecule=...)": (
        lambda d: sparsurf.residues(d, molecule=d.molecule)[["area", "mean_roughness"]],
        lambda d: sparsurf.residues(d)[["area", "mean_roughness"]],
        "residues(molecule, dots)",
    ),
}


@pytest.mark.parametrize("old, new, sentence", OLD_CALLS.values(), ids=OLD_CALLS)
def test_old_calls_do_the_same_and_say_what_to_write(old, new, sentence, dots):
    with pytest.warns(DeprecationWarning, match=re.escape(sentence)) as told:
        before = old(dots)
    assert [warning.filename for warning in told] == [__file__]  # whose line is to be changed
    np.testing.assert_array_equal(np.asarray(before), np.asarray(new(dots)))


def test_names_of_keywords_never_warn(dots, recwarn):
    assert sparsurf.residues(dots=dots, molecule=dots.molecule).equals(sparsurf.residues(dots))
    assert not recwarn.list


def test_two_molecules_and_two_sets_of_dots_are_refused_in_a_sentence(path, dots):
    for wrong, sentence in (
        ((path, path), "give the dots that surface() places on them"),
        ((dots, dots), "is not a molecule"),
        ((), "residues needs a molecule"),
    ):
        with pytest.raises(sparsurf.InputError, match=re.escape(sentence)):
            sparsurf.residues(*wrong)


@pytest.mark.parametrize(
    "words",
    ["minimal peptide.pdb --error 0.2 --sampler cover", "recover dots.csv", "recover dots.csv --mesh"],
)
def test_the_old_option_does_the_same_and_says_what_to_write(words, path, dots, capsys):
    sparsurf.write(sparsurf.minimal(dots, percent=20), path.parent / "dots.csv")
    name, file, *rest = words.split()
    results = []
    for option in ("--reconstruction", "--model"):
        out = path.parent / f"out{option}.ply"
        words = [name, str(path.parent / file), *rest, option, "interpolant", "-o", str(out), "-q"]
        assert command.main(words) == 0
        results.append(out.read_bytes())
    assert results[0] == results[1]
    assert (
        capsys.readouterr().err.count("write --reconstruction interpolant in place of --model interpolant")
        == 1
    )


def test_the_old_key_of_a_config_does_the_same(caplog):
    assert Minimal(model="interpolant") == Minimal(reconstruction="interpolant")
    assert "write reconstruction: interpolant" in caplog.text


def test_files_of_version_5_say_how_their_surface_is_reconstructed(dots, tmp_path):
    few = sparsurf.minimal(dots, percent=20, reconstruction="interpolant")
    for suffix in ("csv", "npz", "ply"):
        path = tmp_path / f"few.{suffix}"
        sparsurf.write(few, path)
        assert sparsurf.read_surface(path).reconstruction.model == "interpolant"
        if suffix == "npz":
            arrays = dict(np.load(path))
            np.savez(path, model=arrays.pop("reconstruction"), **arrays)
        else:
            path.write_bytes(path.read_bytes().replace(b"reconstruction", b"model"))
        assert sparsurf.read_surface(path).reconstruction == few.surface.reconstruction
