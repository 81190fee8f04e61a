"""Dots that touch every exposed atom, and the smallest subset of them with a requested error."""

import math

import numpy as np
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.evaluation.minimal_subset import represent
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.evaluation.trials import MeasuredError, Trials
from sparsurf.recovery.errors import distance_to_surface
from sparsurf.settings import Minimal, Settings
from sparsurf.streams import Streams
from sparsurf.surfaces.molecular_surface import rolled_atoms
from sparsurf.surfaces.surface import CONTACT, SADDLE, Reconstruction


@pytest.fixture(scope="module")
def dots():
    path = ROOT / "data/tdp43/topology.pdb"
    molecule = sparsurf.read_molecule(path, residues="209-239", selection="not element H")
    return sparsurf.surface(molecule)


@pytest.fixture(scope="module")
def fresh(dots):
    return sparsurf.surface(dots.molecule, density=8.0)


@pytest.fixture(scope="module")
def few(dots):
    return sparsurf.minimal(dots)


def errors(fresh, dense):
    """Mean error, and the larger 99 % error of both directions."""
    there = distance_to_surface(fresh.points, dense.points, dense.normals)
    back = distance_to_surface(dense.points, fresh.points, fresh.normals)
    return there.mean(), max(np.quantile(there, 0.99), np.quantile(back, 0.99))


def test_every_exposed_atom_is_determined(dots):
    """By a contact dot and another probe, or by three probes of which one gives a saddle dot with a known atom, or by five.

    The touches are those that a plain count of distances finds.
    """
    cover = Trials(PreparedSurface(dots), "cover", 2, atoms=dots.origin).cover
    chosen, atoms = cover.dots(), dots.origin
    assert len(np.unique(chosen)) == len(chosen)
    probes = dots.points + 1.4 * dots.normals
    touches = np.abs(np.linalg.norm(probes[:, None] - atoms.xyz, axis=2) - atoms.radii - 1.4) < 1e-5
    contact = dots.kind[chosen] == CONTACT
    known = np.bincount(dots.atom[chosen[contact]], minlength=len(atoms.xyz))
    assert (
        np.array_equal(np.flatnonzero(known), np.unique(dots.atom[dots.kind == CONTACT])) and known.max() == 1
    )
    by_others = touches[chosen[~contact]].sum(axis=0)
    possible = touches[dots.kind != CONTACT].any(axis=0)
    assert (by_others[possible] >= 1).all() and possible.sum() > 100
    saddles = touches[chosen[dots.kind[chosen] == SADDLE]]
    pairs = saddles[saddles.sum(axis=1) == 2]
    beside_known = pairs[(pairs & (known > 0)).sum(axis=1) == 1].any(axis=0) & (known == 0)
    assert beside_known.sum() > 10 and np.median(by_others[beside_known]) == 3
    assert set(cover.component) == set(cover.component[chosen])


def test_atoms_that_are_given_up_are_those_that_touch_least(dots):
    cover = Trials(PreparedSurface(dots), "cover", 2, atoms=dots.origin).cover
    probes = dots.points + 1.4 * dots.normals
    touches = (
        np.abs(np.linalg.norm(probes[:, None] - dots.origin.xyz, axis=2) - dots.origin.radii - 1.4) < 1e-5
    )
    area = touches.T @ dots.area
    assert cover.touched_area == pytest.approx(area)
    all_dots, fewer = cover.dots(), cover.dots(0.2)
    assert len(fewer) < 0.85 * len(all_dots)
    exposed = np.flatnonzero(area)
    given_up = exposed[np.argsort(area[exposed], kind="stable")][: int(0.2 * len(exposed))]
    contact = fewer[dots.kind[fewer] == CONTACT]
    with_contact = np.unique(dots.atom[dots.kind == CONTACT])
    assert set(dots.atom[contact]) == set(with_contact) - set(given_up)


def test_predicted_errors_are_those_of_the_reconstructed_surface(dots):
    """A seventh of the atoms is given up, so that a hundredth of the surface lies more than 0.1 Å off."""
    cover = Trials(PreparedSurface(dots), "cover", 2, atoms=dots.origin).cover
    some = cover.dots(0.15)
    dense = sparsurf.recover(dots[some], density=30)
    measured = distance_to_surface(dots.points, dense.points, dense.normals, 1, rolled_atoms(dots.origin))
    predicted = cover.predicted_errors(some)
    assert (predicted > 0.1).mean() > 0.005
    assert predicted.mean() == pytest.approx(measured.mean(), rel=0.4)
    assert np.quantile(predicted, 0.99) == pytest.approx(np.quantile(measured, 0.99), rel=0.3)
    assert np.corrcoef(predicted, measured)[0, 1] > 0.6


def test_the_default_keeps_few_dots_and_bounds_both_errors(dots, fresh, few):
    assert (few.sampler, few.reconstruction) == ("cover", "spheres")
    assert few.surface.reconstruction == Reconstruction(1.4, "dms", "spheres")
    assert len(few) < 0.23 * dots.area.sum()
    mean, high_99 = errors(fresh, sparsurf.recover(few, density=30))
    assert mean < 0.02 and high_99 < 0.105
    again = sparsurf.minimal(dots)
    assert np.array_equal(few.dots, again.dots)


def test_the_errors_that_are_told_are_within_their_limits(dots, few):
    row = few.measure_errors().iloc[0]
    assert row["mean"] <= 0.02 and row["high_99"] <= 0.1 and row["back_99"] <= 0.1
    nearest = {
        "mean": row["mean"] / 0.02,
        "99 % forth": row["high_99"] / 0.1,
        "99 % back": row["back_99"] / 0.1,
    }
    whole = sparsurf.recover(few, density=20)
    back = np.quantile(distance_to_surface(whole.points, dots.points, dots.normals), [0.5, 0.99])
    assert 2 * back[0] < back[1] == pytest.approx(row["back_99"], rel=0.3)
    assert few.decided_by == max(nearest, key=nearest.get) == row["decided_by"]
    looser = sparsurf.minimal(dots, error=0.05)
    row = looser.measure_errors().iloc[0]
    assert len(looser) < len(few) and max(row["high_99"], row["back_99"]) <= 0.25


def test_an_infinite_99_percent_error_bounds_the_mean_alone(dots, few, tmp_path):
    fewer = sparsurf.minimal(dots, error=0.02, error_99=math.inf)
    assert len(fewer) < 0.95 * len(few) and fewer.decided_by == "mean"
    row = fewer.measure_errors().iloc[0]
    assert row["mean"] < 0.03 and row["high_99"] > 0.1
    path = tmp_path / "few.csv"
    words = ["--selection", "resid < 31 and not element H", "--error-99", "inf", "--quiet"]
    assert command.main(["minimal", str(ROOT / "data/tdp43/topology.pdb"), "-o", str(path), *words]) == 0
    assert len(sparsurf.read_surface(path)) == len(fewer)
    assert Minimal(error=0.02, error_99=math.inf).error_99 == math.inf
    for value in (11, 0, math.nan):
        with pytest.raises(InputError, match=r"error_99 is .* and at most 10, or inf"):
            sparsurf.minimal(dots, error=0.02, error_99=value)
        with pytest.raises(ValueError, match="error_99"):
            Minimal(error=0.02, error_99=value)


def test_any_number_of_threads_chooses_the_same_dots(dots, few):
    for threads in (1, 3):
        found = represent(dots, Settings(minimal={"error": 0.02}), Streams(1), dots.molecule, threads=threads)
        assert np.array_equal(found.subset.dots, few.dots)


def test_a_smaller_99_percent_error_takes_more_dots(dots, fresh, few):
    more = sparsurf.minimal(dots, error=0.02, error_99=0.04)
    assert len(few) < len(more) < 1.5 * len(few)
    assert errors(fresh, sparsurf.recover(more, density=30))[1] < 0.042
    evenly = sparsurf.minimal(dots, error=0.05, sampler="farthest")
    bounded = sparsurf.minimal(dots, error=0.05, error_99=0.15, sampler="farthest")
    assert len(evenly) < len(bounded)


def test_what_decides_the_number_of_dots_is_what_changes_it(dots, few, tmp_path):
    """Of a limit that does not decide, a larger value keeps the same dots; the page says which one decides."""
    assert few.decided_by in ("99 % forth", "99 % back")
    sparsurf.write(few, tmp_path / "few.html")
    assert few.decision[0] in (tmp_path / "few.html").read_text() and few.decision[0] in few.show().html
    looser = sparsurf.minimal(dots, error=0.05, error_99=0.1)
    assert np.array_equal(looser.dots, few.dots)
    by_mean = sparsurf.minimal(dots, error=0.003, error_99=5.0)
    assert by_mean.decided_by == "mean" and len(by_mean) > len(few)
    assert np.array_equal(sparsurf.minimal(dots, error=0.003, error_99=9.0).dots, by_mean.dots)
    assert sparsurf.minimal(dots, percent=5).decided_by == ""


@pytest.mark.parametrize(
    ("measured", "decided_by"),
    [
        ((0.04, 0, 0.1, 0.1), "mean"),
        ((0.01, 0, 0.2, 0.15), "99 % forth"),
        ((0.01, 0, 0.15, 0.2), "99 % back"),
    ],
)
def test_the_error_that_is_nearest_to_its_limit_decides(measured, decided_by):
    assert MeasuredError(*measured).decided_by(0.02, 0.1) == decided_by
    assert MeasuredError(*measured).over(0.02, 0.1) == 2
    assert MeasuredError(*measured).decided_by(0.02, None) == "mean"


def test_dots_that_are_too_few_for_atoms_say_that_they_are_interpolated(dots, fresh):
    """The atoms of fewer than 100 dots are not inferred, whatever sampler chose them."""
    few = sparsurf.minimal(dots, error=5)
    assert len(few) < 100 and (few.reconstruction, few.decided_by) == ("interpolant", "fewest")
    assert few.measure_errors()["reconstruction"].eq("interpolant").all()
    dense = sparsurf.recover(few, density=20, reconstruction="interpolant")
    assert few.error == pytest.approx(
        distance_to_surface(fresh.points, dense.points, dense.normals).mean(), rel=0.05
    )
    touching = sparsurf.minimal(dots, n_dots=99, sampler="cover")
    assert touching.reconstruction == "interpolant" and touching.surface.reconstruction.model == "auto"
    assert sparsurf.minimal(dots, n_dots=100, sampler="cover").surface.reconstruction.model == "spheres"


def test_other_requests_keep_farthest_points(dots):
    percent = sparsurf.minimal(dots, percent=5)
    assert np.array_equal(percent.dots, sparsurf.sample(dots, percent=5))
    assert (percent.sampler, percent.reconstruction) == ("farthest", "interpolant")
    assert percent.surface.reconstruction == Reconstruction(1.4, "dms", "auto")
    with pytest.raises(InputError, match="error_99 belongs"):
        sparsurf.minimal(dots, percent=5, error_99=0.1)


def test_cover_keeps_any_number_of_dots(dots, fresh):
    area, previous = dots.area.sum(), np.inf
    for density in (0.1, 0.2):
        few = sparsurf.minimal(dots, density=density, sampler="cover")
        assert len(few) == len(np.unique(few.dots)) == round(density * area)
        mean = errors(fresh, sparsurf.recover(few, density=30))[0]
        assert mean < previous
        previous = mean
    assert previous < 0.004


def test_dots_that_would_mislead_are_not_added():
    """Without the choice of the best round, the largest error of these is 0.32 Å: the dots agree on an atom that is not there."""
    dots = sparsurf.surface(sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb"))
    few = sparsurf.minimal(dots, n_dots=1353, sampler="cover")
    dense = sparsurf.recover(few, density=30)
    assert distance_to_surface(dots.points, dense.points, dense.normals).max() < 0.25


def test_dots_without_atoms_are_refused(dots):
    with pytest.raises(InputError, match="`surface` placed"):
        sparsurf.minimal((dots.points, dots.normals), percent=3, sampler="cover")


@pytest.mark.parametrize("suffix", ["csv", "npz", "ply"])
def test_files_say_how_their_surface_is_reconstructed(few, suffix, tmp_path, caplog):
    path = tmp_path / f"few.{suffix}"
    sparsurf.write(few, path)
    read = sparsurf.read_surface(path)
    assert read.reconstruction == few.surface.reconstruction and not caplog.records
    assert not {"probe_radius", "radii", "reconstruction"} & {*read.fields}
    kept = sparsurf.minimal(few.molecule, percent=2, reconstruction="interpolant")
    sparsurf.write(kept, path)
    read = sparsurf.read_surface(path)
    obeyed, told = sparsurf.recover(read), sparsurf.recover(read, reconstruction="interpolant")
    assert obeyed.points.tobytes() == told.points.tobytes()


def test_commands_take_the_reconstruction(few, dots, tmp_path):
    sparsurf.write(few, tmp_path / "few.csv")
    results = []
    for options in ([], ["--reconstruction", "interpolant"], ["--reconstruction", "spheres"]):
        path = tmp_path / "dense.csv"
        assert command.main(["recover", str(tmp_path / "few.csv"), "-o", str(path), "--quiet", *options]) == 0
        results.append(path.read_bytes())
    assert results[0] == results[2] != results[1]
    structure = str(ROOT / "data/tdp43/topology.pdb")
    path = tmp_path / "two.csv"
    words = ["--reconstruction", "interpolant", "--model", "1", "--percent", "2"]
    assert command.main(["minimal", structure, "-o", str(path), "--quiet", *words]) == 0
    assert sparsurf.read_surface(path).reconstruction == Reconstruction(1.4, "dms", "interpolant")
    with pytest.raises(SystemExit):
        command.main(["minimal", structure, "-o", str(path), "--reconstruction", "atoms"])


@pytest.mark.parametrize("suffix", ["csv", "npz"])
def test_columns_of_these_names_that_say_something_else_are_told(dots, suffix, tmp_path, caplog):
    path = tmp_path / f"own.{suffix}"
    few = dots[:200]
    if suffix == "csv":
        few.to_frame()[["x", "y", "z", "nx", "ny", "nz"]].assign(model=3.5, probe_radius=2.0).to_csv(
            path, index=False
        )
    else:
        np.savez(
            path,
            points=few.points,
            normals=few.normals,
            model=np.full(200, 3.5),
            probe_radius=np.full(200, 2.0),
        )
    read = sparsurf.read_surface(path)
    assert not read.fields and read.reconstruction is None
    assert f"{path}: the columns probe_radius, model are left out" in caplog.text


def test_a_sampler_that_is_named_is_not_replaced_in_silence(caplog):
    """The dots that touch the atoms of four residues do not determine their spheres: others are taken, and 'cover' says so."""
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-212")
    dots = sparsurf.surface(molecule)
    assert sparsurf.minimal(dots).sampler == "farthest"
    assert not caplog.messages
    assert sparsurf.minimal(dots, sampler="cover").sampler == "farthest"
    assert "evenly spread dots" in caplog.text
    assert sparsurf.minimal(dots, sampler="cover", n_dots=3).sampler == "cover"
    assert "3 dots" in caplog.text
