"""The functions for users and what commands share, on dots whose answers are known."""

import gzip
import inspect
import os
import re
from dataclasses import replace
from operator import attrgetter

import numpy as np
import pandas as pd
import pytest
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

import sparsurf
from conftest import ROOT
from sparsurf.api import inputs, writing
from sparsurf.arguments import PLACEMENT
from sparsurf.cli import command
from sparsurf.errors import InputError
from sparsurf.evaluation.subset_search import warn_if_number_differs
from sparsurf.patches import descriptors as engine
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness_of_patches
from sparsurf.recovery.errors import distance_to_recovered
from sparsurf.sampling import published
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.surface import Surface

D_LINK = 0.8  # Å, for the few dots of the blob
PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
BALL = (np.array([[1.0, 2.0, 3.0]]), np.array([2.0]))


@pytest.fixture(scope="module")
def ready(blob):
    return sparsurf.prepare(blob, d_link=D_LINK, seed=4)


def test_what_is_prepared_is_what_was_requested(blob, ready):
    own = attrgetter("patches.r_patch", "patches.r_zernike", "patches.d_link")
    assert (*own(ready), ready.stream.seed) == (4.0, 6.0, D_LINK, 4)
    assert sparsurf.prepare(ready) is ready
    other = sparsurf.prepare(blob, r_patch=3.0, r_zernike=5.0, d_link=0.9)
    assert (*own(other), other.stream.seed) == (3.0, 5.0, 0.9, DEFAULT_SEED)
    with pytest.raises(InputError, match=r"surface: d_link = 0.1 Å is below"):
        sparsurf.prepare(blob, d_link=0.1)


REFUSED = {  # what is called with: the dots of the blob, them prepared, or the dots of a peptide
    "blob": [
        (lambda d: sparsurf.roughness(d, radius=4), "'radius'; its keywords are surface, r_patch, d_link, roughness."),
        (lambda d: sparsurf.minimal(d, dots=9), "no keyword 'dots'; did you mean 'n_dots'?"),
        (lambda d: sparsurf.prepare(d, R_patch=4), "no keyword 'R_patch'; did you mean 'r_patch'?"),
        (lambda d: sparsurf.sample(d, dots=9), "no keyword 'dots'; did you mean 'n_dots'?"),
        (lambda d: sparsurf.roughness((d[0].T, d[1].T)), "points has the shape (3, 3000), not (N, 3)"),
        (lambda d: sparsurf.roughness((d[0], 2 * d[1])), "normals are not of unit length"),
        (lambda d: sparsurf.descriptors(d, [[0, 0, np.nan]], d_link=D_LINK), "at: some points have NaN"),
        (lambda d: sparsurf.descriptors(d, [0], up="x", d_link=D_LINK), "up is 'x'; it must be True or False"),
        (lambda d: sparsurf.descriptors(d, [[1, 2], [3]], d_link=D_LINK), "at: give one array"),
        (lambda d: sparsurf.descriptors(d, [3000], d_link=D_LINK), "there is no dot 3000; the dots are numbered 0 to 2999"),
        (lambda d: sparsurf.descriptors(d, [5, -1], d_link=D_LINK), "no dot -1;"),
        (lambda d: sparsurf.surface(([[0, 0, 0]], [101])), "atomic radii must be positive"),
        (lambda d: sparsurf.surface(([[1, 2, 3], [4, 5]], [1, 1])), "rows of equal length"),
        (lambda d: sparsurf.read_surface(b"dots.csv"), "a path is a string or a Path, not bytes"),
        *((lambda d, f=f: sparsurf.recover(f(d)), "is not a surface: give the path")
          for f in (list, lambda d: d[:1], lambda d: 3)),
        (lambda d: sparsurf.recover(PEPTIDE), "topology.pdb holds atoms: give the dots that surface() places"),
        (lambda d: sparsurf.surface(3), "an int is not a molecule"),
        (lambda d: sparsurf.surface(PEPTIDE, frame=5), "the molecule has one frame, 0: there is no frame 5."),
        (lambda d: sparsurf.components(PEPTIDE, d), "components: the dots are not those of the molecule"),
        (lambda d: sparsurf.components(Surface(*d)), "components: these dots carry no molecule, as those of a file"),
        *((lambda d, f=f: f(Surface(*d)), f"{f.__name__}: these dots carry no molecule; give it before them")
          for f in (sparsurf.fields, sparsurf.residues)),
        *((lambda d, f=f, wish=wish: f(PEPTIDE, **{wish: 2.0}),
           f"{f.__name__}: {wish} belongs to the placing of the dots: call "
           f"sparsurf.{f.__name__}(sparsurf.surface(molecule, {wish}=2.0), ...).")
          for f in (sparsurf.minimal, sparsurf.floors, sparsurf.mesh, sparsurf.components, sparsurf.roughness, sparsurf.sample)
          for wish in ("frame", "probe_radius", "radii", "cavities", "reentrant") if f.__name__ != "mesh" or wish == "reentrant"),
        (lambda d: sparsurf.mesh(Surface(*d), radii="bondi"), "mesh: radii has no meaning for dots, which are placed"),
        (lambda d: sparsurf.mesh(PEPTIDE, reach=2), "mesh: reach has no meaning for a molecule"),
        (lambda d: sparsurf.mesh(PEPTIDE, smooth=2), "mesh: table, smooth and charges are about fields"),
        (lambda d: sparsurf.mesh(PEPTIDE, cavities=2.0), "cavities is 2.0; it must be keep or remove."),
    ],
    "ready": [
        (lambda d: sparsurf.sample(d, n_dots=9, combination=(1, 0, 6, 0)), "leave out n_dots or the combination"),
        (lambda d: sparsurf.sample(d, combination=(1, 0, 6, 0), sampler="uniform"), "not 'uniform'; leave out"),
        (lambda d: sparsurf.sample(d, n_dots=9, sampler=["x"]), "there is no sampler ['x']; the samplers are"),
        (lambda d: sparsurf.sample(d, n_dots="10"), "it must be a whole number, more than 0"),
        (lambda d: sparsurf.sample(d, n_dots=3001), "it must be a whole number, 1 to 3000"),
        (lambda d: sparsurf.sample(d), "either percent or n_dots"),
        (lambda d: sparsurf.sample(d, n_dots=5, percent=5), "either percent or n_dots"),
        *((lambda d, subset=subset: sparsurf.compare(d, {"wrong": subset}), "wrong: expected unique dot indices between 0 and 29")
          for subset in ([0, 0], [-1], [3000], [], [0.5], [[1, 2]], np.ones(5, bool))),
        (lambda d: sparsurf.compare(d, [[1, 2], [3]]), "subset: give one array"),
        (lambda d: sparsurf.compare(d, {}), "subsets: there are none"),
        (lambda d: sparsurf.prepare(d, r_zernike=5), "prepared already"),
        *((lambda d, f=f: f(d), "give the dots that it was prepared from")
          for f in (sparsurf.roughness, sparsurf.descriptors, sparsurf.recover)),
    ],
    "peptide": [
        (lambda d: sparsurf.roughness(d, r_patch=0.4), "r_patch = 0.4 Å is below 2 times the median distance"),
        (lambda d: sparsurf.descriptors(d, [0], r_zernike=0.6), "r_zernike = 0.6 Å is below 2 times"),
        (lambda d: sparsurf.prepare(d, r_patch=0.6), "r_patch = 0.6 Å is below 2 times"),
        (lambda d: sparsurf.minimal(d, n_dots=100_000), "minimal: n_dots is 100000, more than the "),
        (lambda d: sparsurf.minimal(d, percent=10, n_dots=5), "only one of percent, n_dots, density, error and max_z"),
        (lambda d: sparsurf.components(d, d), "give the molecule first"),
        (lambda d: sparsurf.components(d[::2]), "components: this Surface is a subset; pass the complete surface"),
        (lambda d: sparsurf.components(d.origin.molecule, sparsurf.minimal(d, percent=10)), "this Surface is a subset"),
        (lambda d: sparsurf.fields(d, d.origin.molecule), "molecule first"),
        (lambda d: sparsurf.fields(PEPTIDE, names="bfactor"), "fields: dots are missing; call sparsurf.fields("),
        (lambda d: sparsurf.fields(d, names=[]), "names: there are no fields"),
        (lambda d: sparsurf.fields(d, names=["potential"], charges=3), "charges is int"),
        (lambda d: sparsurf.residues(replace(d, atom=np.full(len(d), -1))), "which atom"),
        (lambda d: sparsurf.residues(d, roughness_values=["a"] * len(d)), "roughness_values must hold real numbers"),
        (lambda d: sparsurf.residues(d, roughness_values=np.full(len(d), np.nan)), "give the roughness of every dot"),
        (lambda d: sparsurf.read_molecule(PEPTIDE, selection=" or ".join(["resid 1"] * 1200)), "more than 10,000: name ranges"),
        (lambda d: sparsurf.residues(d, roughness_values=[0.1, 0.2]), "roughness_values has the shape (2,)"),
        (lambda d: sparsurf.residues(d, kept=[10**6]), "kept: expected unique dot indices between 0 and"),
        (lambda d: sparsurf.residues(d, kept=np.ones(5, bool)), "kept: expected unique dot indices between 0 and"),
        (lambda d: sparsurf.residues(d, kept=[1, 2], weight=[1]), "weight has the shape (1,); the kept dots are 2"),
        (lambda d: sparsurf.write(3, "x.csv"), "not the type int"),
        (lambda d: replace(d, fields={"score": np.ones(5)}), "field score has the shape (5,)"),
        (lambda d: d.to_frame(3), "must come from read_molecule"),
    ],
}  # fmt: skip


@pytest.fixture(scope="module")
def peptide():
    """Dots that a small probe placed."""
    return sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-214"), probe_radius=0.8)


@pytest.mark.parametrize(
    ("given", "call", "words"), [(given, *row) for given, rows in REFUSED.items() for row in rows]
)
def test_what_cannot_be_done_is_one_sentence(request, tmp_path, monkeypatch, given, call, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(words)) as told:
        call(request.getfixturevalue(given))
    assert "\n" not in str(told.value)


def test_components_and_residues_of_the_dots_of_a_peptide(peptide):
    """By the rules that placed the dots; what is kept may be a mask."""
    for found in (sparsurf.components(peptide), sparsurf.components(peptide.origin.molecule, peptide)):
        assert found[1]["dots"].tolist() == [len(peptide)]
    few, mask = np.arange(0, len(peptide), 7), np.arange(len(peptide)) % 7 == 0
    table = sparsurf.residues(peptide, kept=few)
    assert table["kept"].sum() == len(few) and table.equals(sparsurf.residues(peptide, kept=mask))
    assert sparsurf.residues(peptide, kept=np.zeros(len(peptide), bool))["kept"].sum() == 0
    table = sparsurf.residues(peptide, kept=few[::-1], weight=np.arange(len(few)))  # in an order of its own
    owner = peptide.origin.molecule.residue_index[peptide.atom[few[::-1]]]
    assert table["weight"].tolist() == np.bincount(owner, np.arange(len(few)), len(table)).tolist()


def test_a_sample_has_the_requested_number(ready):
    assert len(sparsurf.sample(ready, percent=10)) == 300
    assert len(sparsurf.sample(ready, n_dots=1)) == 1
    assert sorted(sparsurf.sample(ready, n_dots=3000, sampler="uniform")) == list(range(3000))
    first, again, other = (
        sparsurf.sample(ready, n_dots=50, sampler="uniform", seed=s).tolist() for s in (0, 0, 1)
    )
    assert first == again and len(set(first) & set(other)) < 10
    own, prepared_for = (
        sparsurf.sample(ready, n_dots=50, sampler="uniform", **seed) for seed in ({}, {"seed": 4})
    )
    assert np.array_equal(own, prepared_for)
    kept = sparsurf.sample(ready, combination=(1, 0, 6, 0), seed=7)
    reseeded = ready.with_streams(Streams(7))
    assert np.array_equal(kept, reseeded.pair((1, 0, 6, 0), 0)[0])
    assert np.array_equal(kept, sparsurf.sample(ready, combination=(1, 0, 6, 0), sampler="paper", seed=7))
    other = sparsurf.sample(ready, combination=(1, 0, 6, 0), sampler="paper_corrected", seed=7)
    corrected = reseeded.with_cover(ready.corrected_cover)
    assert np.array_equal(other, corrected.pair((1, 0, 6, 0), 0)[0]) and len(other) != len(kept)
    assert np.array_equal(
        sparsurf.sample(ready, n_dots=9), sparsurf.sample(ready, n_dots=9, sampler="farthest")
    )


def test_a_number_of_dots_that_was_not_requested_is_reported(ready, caplog):
    n = len(sparsurf.sample(ready, n_dots=1, sampler="paper"))
    words = "its number of dots is random, and limited by its combinations"
    assert n > 1 and caplog.messages == [f"paper keeps {n} dots instead of 1: {words}"]
    for requested, told in ((n, 1), (1.07 * n, 1), (0.95 * n, 1), (0.9 * n, 2), (1.2 * n, 3)):
        warn_if_number_differs("paper", requested, n)
        assert len(caplog.messages) == told
    warn_if_number_differs("mine", 10, 5)
    assert caplog.messages[-1] == "mine keeps 5 dots instead of 10"


def test_too_few_dots_are_reported_with_the_distance_of_the_worst(blob, ready, caplog):
    kept = sparsurf.sample(ready, n_dots=12)
    off = distance_to_recovered(blob[0], blob[0][kept], blob[1][kept], 1)
    far = np.quantile(np.delete(off, kept), 0.99)
    words = f"sample: 12 dots are too few to reconstruct the surface: 1 % of it deviates by {far:.1f} Å or more; keep more"
    assert caplog.messages == [words] and f"{far:.1f}" != f"{np.quantile(off, 0.95):.1f}"
    sparsurf.sample(ready, n_dots=600)
    assert len(caplog.messages) == 1
    told, wide = [], []
    for n in (14, 17, 20, 25, 60):
        caplog.clear()
        kept = sparsurf.sample(ready, n_dots=n)
        off = distance_to_recovered(blob[0], blob[0][kept], blob[1][kept], 1)
        told.append(len(caplog.messages))
        wide.append(int(np.quantile(np.delete(off, kept), 0.99) > 1.4))  # Å, the radius of a water
    assert told == wide and 0 < sum(wide) < 5


def test_places_without_a_patch_are_reported(blob, caplog):
    places = np.array([blob[0][5], [0, 0, 99], [0, 99, 0]])
    z = sparsurf.descriptors(blob, places, d_link=D_LINK)
    assert z[0].any() and not z[1:].any()
    assert caplog.messages == [
        "at: 2 of 3 points have no patch, as no dot lies within 6 Å; their descriptors are zeros"
    ]
    assert sparsurf.descriptors(blob, [], d_link=D_LINK).shape == (0, 121)
    assert sparsurf.descriptors(blob, [5], d_link=D_LINK).any() and len(caplog.messages) == 1


@pytest.mark.parametrize(
    ("size", "words"),
    [
        ({"error": 1e-9}, ["minimal: no smaller subset meets the limit, and all {} dots are kept"]),
        ({"percent": 100}, []),
    ],
)
def test_a_limit_that_only_all_dots_meet_is_reported(blob, caplog, size, words):
    few = sparsurf.minimal(blob, sampler="uniform", d_link=D_LINK, **size)
    assert len(few) == len(blob[0]) and caplog.messages == [line.format(len(few)) for line in words]


def test_the_largest_z_of_a_subset_is_that_of_its_link(blob):
    few = sparsurf.minimal(blob, max_z=1.0, d_link=D_LINK)
    z = sparsurf.compare(sparsurf.prepare(blob, d_link=D_LINK), few.dots)["Z"].iloc[0]
    assert z == pytest.approx(1.0, abs=0.1)


def test_a_subset_is_set_beside_a_uniform_one_of_its_size(ready):
    half = np.arange(0, 3000, 2)
    table = sparsurf.compare(ready, {"half": half, "all": np.ones(3000, bool)}, test_dots=50)
    assert table.index.tolist() == ["half", "all"]
    assert table["n_S"].tolist() == [1500, 3000] and table["n_S_percent"].tolist() == [50, 100]
    assert table.loc["all", ["Z", "Z_uniform", "d"]].tolist() == pytest.approx([0, 0, 0], abs=1e-9)
    tests = ready.draw_tests(50)
    z_tot, _ = ready.describe(tests)
    uniform = published.uniform_subset(3000, 1500, ready.stream("compare", 1500))
    own, other = ready.distances([half, uniform], tests, z_tot, "full")[0]
    row = table.loc["half"]
    assert (row["Z"], row["Z_uniform"]) == pytest.approx((own.mean(), other.mean()))
    assert row["d"] == pytest.approx(other.mean() - own.mean())
    assert row["d_se"] == pytest.approx((other - own).std(ddof=1) / np.sqrt(50))
    assert row["Z_empty"] == pytest.approx(np.linalg.norm(z_tot, axis=1).mean())
    assert row["Z_mean_descriptor"] == pytest.approx(
        np.linalg.norm(z_tot - z_tot.mean(axis=0), axis=1).mean()
    )
    published_tests = sparsurf.compare(ready, half, test_dots="published")  # one of 200 dots
    pd.testing.assert_frame_equal(published_tests, sparsurf.compare(ready, half, test_dots=15))
    kept = sparsurf.compare(ready, half, reading="kept", test_dots=50)
    assert kept.loc["subset", "Z"] == pytest.approx(ready.distances([half], tests, z_tot, "kept")[0].mean())


def test_patches_are_cut_as_requested(blob):
    index = build_index(*blob, D_LINK)
    assert np.array_equal(
        sparsurf.roughness(blob, r_patch=3, d_link=D_LINK), roughness_of_patches(index, 3.0, 1)
    )
    z = sparsurf.descriptors(blob, [5, 2999], r_zernike=4, d_link=D_LINK)
    assert np.array_equal(z, engine.describe_patches(index, blob[0][[5, 2999]], 4.0, True)[0])
    assert np.array_equal(sparsurf.descriptors(blob, blob[0][[5, 2999]], r_zernike=4, d_link=D_LINK), z)
    these = np.isin(np.arange(len(blob[0])), [5, 2999])
    assert np.array_equal(sparsurf.descriptors(blob, these, r_zernike=4, d_link=D_LINK), z)
    other = sparsurf.descriptors(blob, [5], r_zernike=4, d_link=D_LINK, descriptor="rotation_robust")
    assert np.array_equal(
        other, engine.describe_patches(index, blob[0][[5]], 4.0, True, descriptor="rotation_robust")[0]
    )
    down = sparsurf.descriptors(blob, [5], r_zernike=4, up=False, d_link=D_LINK)
    assert np.array_equal(down, engine.describe_patches(index, blob[0][[5]], 4.0, False)[0])
    assert np.abs(down - z[:1]).max() > 1e-3
    few = tuple(x[:200] for x in blob)
    every = sparsurf.descriptors(few, r_zernike=3, d_link=5.0)
    assert every.shape == (200, 121)
    two = sparsurf.descriptors(few, [7, 9], r_zernike=3, d_link=5.0)
    assert np.allclose(
        every[[7, 9]], two, rtol=0, atol=1e-12
    )  # BLAS adds in the order of the number of patches


def test_a_ball_has_the_dots_that_are_requested():
    for density, probe in ((5.0, 1.4), (20.0, 1.0)):
        dots = sparsurf.surface(BALL, density=density, probe_radius=probe, d_link=1.0)
        assert len(dots) == pytest.approx(16 * np.pi * density, rel=0.1)
        assert np.linalg.norm(dots.points - BALL[0], axis=1) == pytest.approx(2.0, abs=1e-6)
        assert dots.area.sum() == pytest.approx(16 * np.pi, rel=1e-6)
    auto, denser = (len(sparsurf.surface(BALL, d_link=link)) for link in (0.6, 0.25))
    assert auto == pytest.approx(16 * np.pi * 5.35, rel=0.1) and denser > 2 * auto
    pair = (np.array([[0, 0, 0], [4.4, 0, 0]]), np.array([1.0, 1.0]))  # 2.4 Å of room between them
    assert (sparsurf.surface(pair, probe_radius=1.3, d_link=2.0).kind > 0).any()
    assert (sparsurf.surface(pair, probe_radius=1.1, d_link=2.0).kind == 0).all()


def test_a_frame_is_taken_by_its_place(two_frames):
    wanted: dict = dict.fromkeys((2,), "the molecule has the frames 0 to 1: there is no frame ")
    wanted |= dict.fromkeys((-1, 0.5, True, "x"), "frame is .*; it must be a whole number")
    for number, sentence in wanted.items():
        with pytest.raises(InputError, match=sentence):
            sparsurf.surface(two_frames, frame=number)
    assert len(sparsurf.surface(([[0, 0, 0]], [1.5]), frame=5)) > 0  # spheres have no frames


def test_dots_know_their_molecule():
    """So that all that follows from the atoms needs only the dots, and is the same as from the file."""
    molecule = sparsurf.read_molecule(PEPTIDE, residues="209-214")
    how = {"probe_radius": 1.5, "radii": "bondi"}
    dots = sparsurf.surface(molecule, **how)
    assert len(sparsurf.surface(molecule, d_link=0.3)) > 1.5 * len(dots)
    few, default = sparsurf.minimal(dots, percent=10), sparsurf.minimal(molecule, percent=10)
    assert few.surface.origin is dots.origin and len(default) != len(few) == round(len(dots) / 10)
    assert sparsurf.residues(dots).equals(sparsurf.residues(molecule, dots))
    names = ["hydropathy"]
    assert sparsurf.fields(dots, names).equals(sparsurf.fields(molecule, dots, names))
    assert sparsurf.fields(dots, names=names).equals(sparsurf.fields(molecule, dots, names))
    component, table = sparsurf.components(dots)
    again = sparsurf.components(molecule, dots)
    assert np.array_equal(component, again[0]) and table.equals(again[1])
    assert not table.equals(sparsurf.components(molecule)[1])
    wide = sparsurf.mesh(dots).volume
    assert wide != sparsurf.mesh(molecule).volume
    assert wide == pytest.approx(table["volume"][0], rel=0.02)  # the parts of the dots, computed another way
    frame = dots.to_frame()
    assert (
        list(frame)[7:10] == ["kind", "component", "chain"]
        and frame["component"].tolist() == component.tolist()
    )
    assert frame["residue"].tolist() == molecule.residue[dots.atom].tolist()


def test_dots_of_other_atoms_are_refused(tmp_path):
    """Not only those of another frame; a molecule with more atoms around them is no other for fields."""
    whole, more = (sparsurf.read_molecule(PEPTIDE, residues=each) for each in ("209-214", "209-218"))
    bare = whole.select(hydrogens="remove")
    moved, dots = replace(bare, xyz=bare.xyz + 1.0), sparsurf.surface(bare)
    for others, name, call in (
        ([whole, more], "residues", lambda own: sparsurf.residues(own, dots)),
        ([whole, more, moved], "components", lambda own: sparsurf.components(own, dots)),
        ([whole, more, moved], "write", lambda own: sparsurf.write(dots, tmp_path / "x.dms", molecule=own)),
        ([moved], "fields", lambda own: sparsurf.fields(own, dots, ["hydropathy"])),
    ):
        for own in others:
            with pytest.raises(InputError, match=f"^{name}: the dots were placed on other atoms"):
                call(own)
    assert sparsurf.residues(moved, dots).equals(sparsurf.residues(dots))  # which asks for names only
    for own in (whole, more, bare):
        assert len(sparsurf.fields(own, dots, ["hydropathy"])) == len(dots)
    assert not (tmp_path / "x.dms").exists()


def test_dots_and_atoms_are_of_one_frame(two_frames, tmp_path):
    dots = sparsurf.surface(two_frames, frame=1)
    field = sparsurf.fields(dots, ["hydropathy"])
    assert field.equals(sparsurf.fields(two_frames, dots, ["hydropathy"], frame=1))
    assert field.equals(sparsurf.fields(two_frames.frame(1), dots, ["hydropathy"]))
    with pytest.raises(InputError, match="1; give frame=1"):
        sparsurf.fields(two_frames, dots)
    with pytest.raises(InputError, match="0; leave frame=1"):
        sparsurf.fields(sparsurf.surface(two_frames), frame=1)
    own = sparsurf.components(dots)[1]
    for molecule in (two_frames, two_frames.frame(1)):
        pd.testing.assert_frame_equal(sparsurf.components(molecule, dots)[1], own)
    with pytest.raises(InputError, match="other atoms"):
        sparsurf.components(two_frames.frame(0), dots)
    with pytest.raises(InputError, match="frame 1"):
        sparsurf.write(dots, tmp_path / "x.dms", molecule=two_frames)
    sparsurf.write(dots, tmp_path / "x.dms", molecule=two_frames, frame=1)
    sparsurf.write(dots, tmp_path / "own.dms")  # on the frame that they carry
    assert (tmp_path / "own.dms").read_bytes() == (tmp_path / "x.dms").read_bytes()
    lines = (tmp_path / "own.dms").read_text().splitlines()
    atoms = [[*map(float, line.split()[3:6])] for line in lines if line.split()[6] == "A"]
    assert np.abs(np.array(atoms) - two_frames.xyz[1]).max() < 0.001


def test_a_named_index_is_written(tmp_path):
    table = pd.DataFrame({"Z": [1.5]}, index=pd.Index(["mine"], name="subset"))
    sparsurf.write(table, tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "subset,Z\nmine,1.5\n"
    sparsurf.write(table, tmp_path / "t.npz")
    with np.load(tmp_path / "t.npz") as held:
        assert held["subset"].tolist() == ["mine"]


def test_a_part_of_the_dots_and_moved_ones_are_no_whole_surface(peptide):
    part = peptide.take(peptide.points[:, 0] > peptide.points[:, 0].mean())
    assert "component" not in part.to_frame()
    assert part.to_frame()["atom_name"].tolist() == peptide.origin.molecule.name[part.atom].tolist()
    alone = replace(part, origin=None)  # as of a file
    assert np.array_equal(sparsurf.minimal(part).dots, sparsurf.minimal(alone).dots)
    moved = replace(peptide, points=peptide.points + 100)
    assert peptide.placed is peptide.origin and moved.placed is None and peptide.take(slice(9)).placed is None
    assert sparsurf.mesh(moved).vertices.points.min() > 50


def test_what_minimal_gave_is_taken_for_its_dots(blob):
    few = sparsurf.minimal(blob, percent=20, d_link=D_LINK)
    own = {"own": np.linspace(0, 1, len(few.points)), "component": np.arange(len(few.points)) % 2}
    fields = sparsurf.recover(replace(few.surface, fields=own)).fields
    assert [*fields] == ["own"]  # nothing lies between two components
    dense = sparsurf.recover(few)
    assert np.array_equal(dense.points, sparsurf.recover(few.surface).points) and len(dense) > 2 * len(
        few.dots
    )
    assert sparsurf.mesh(few).volume == pytest.approx(sparsurf.mesh(Surface(*blob)).volume, rel=0.01)


def test_fields_of_recovered_dots_are_those_of_their_places(blob):
    points, normals = (part[::3] for part in blob)
    dense = sparsurf.recover(Surface(points, normals, fields={"across": points[:, 0], "up": points[:, 2]}))
    for name, column in (("across", 0), ("up", 2)):
        off = dense.fields[name] - dense.points[:, column]
        assert (off[: len(points)] == 0).all() and np.abs(off).mean() < 0.1 and len(off) > 2 * len(points)


def test_what_is_taken_for_a_surface_and_a_structure(blob, tmp_path):
    made = inputs.as_dots(tuple(map(np.ndarray.tolist, blob)))
    assert np.array_equal(made.points, blob[0]) and inputs.as_dots(made) is made
    pdb = PEPTIDE.read_bytes()
    dots = b"x,y,z,nx,ny,nz\n0,0,0,0,0,1\n"
    for name, content, holds_atoms in (
        ("a.pdb", pdb, True), ("a.PDB.gz", gzip.compress(pdb), True), ("a.csv", dots, False), ("a.pdb", dots, True),
        ("a.csv", pdb, True), ("a.csv.gz", gzip.compress(dots), False), ("a", b"data_x\n", True), ("a.npz", b"PK", False),
        ("a.nc", b"CDF\x02", True), ("a.dms", b"ply\n", False),
    ):  # fmt: skip
        (tmp_path / name).write_bytes(content)
        assert inputs.has_atoms(tmp_path / name) == holds_atoms, name


def test_the_suffix_decides(tmp_path, capfdbinary):
    written = {
        end: lambda path, end=end: path.write_text(f"{end} in {path.name}")
        for end in writing.SUFFIXES_OF_DOTS
    }
    for name, words in (
        ("a.csv", ".csv in part.csv"),
        ("a.PLY", ".ply in part.ply"),
        ("a.dms.gz", ".dms in part.dms"),
        ("a.csv.GZ", ".csv in part.csv"),
    ):
        writing.write_file(tmp_path / name, written, writing.SUFFIXES_OF_DOTS)
        packed = name.lower().endswith(".gz")
        content = gzip.compress(words.encode(), mtime=0) if packed else words.encode()  # the same at any time
        assert (tmp_path / name).read_bytes() == content
    writing.write_file("-", written, writing.SUFFIXES_OF_DOTS)
    assert capfdbinary.readouterr().out == b".csv in part.csv"
    with pytest.raises(InputError, match=r"'.ply'; name"):
        writing.write_file(tmp_path / "a.ply", written, writing.TABLE_FORMATS)
    with pytest.raises(InputError, match=r"/a\.gz: the name"):
        writing.write_file(tmp_path / "a.gz", written, writing.SUFFIXES_OF_DOTS)

    def broken(path):
        path.write_text("half")
        raise OSError("full")

    with pytest.raises(OSError):
        writing.write_file(tmp_path / "b.csv", {".csv": broken})
    names = ["a.PLY", "a.csv", "a.csv.GZ", "a.dms.gz"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names


def test_links_and_pipes_stay_what_they_are(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "old.csv").write_text("old")
    for name in ("old.csv", "new.csv"):  # there, and not there yet
        (tmp_path / name).symlink_to(tmp_path / "folder" / name)
        writing.write_file(tmp_path / name, {".csv": lambda path: path.write_text("dots")})
        assert (tmp_path / name).is_symlink() and (tmp_path / "folder" / name).read_text() == "dots"
    os.mkfifo(tmp_path / "pipe.csv")
    reader = os.open(tmp_path / "pipe.csv", os.O_RDONLY | os.O_NONBLOCK)
    writing.write_file(tmp_path / "pipe.csv", {".csv": lambda path: path.write_text("dots")})
    assert os.read(reader, 99) == b"dots" and (tmp_path / "pipe.csv").is_fifo()
    os.close(reader)


@pytest.fixture(scope="module")
def dots(blob, tmp_path_factory):
    path = tmp_path_factory.mktemp("dots") / "dots.csv"
    pd.DataFrame(np.hstack(blob), columns=["x", "y", "z", "nx", "ny", "nz"]).to_csv(path, index=False)
    return path


def ran(*words, d_link=D_LINK):
    assert command.main([*map(str, words), "--d-link", str(d_link)]) == 0


def test_recovered_dots_tell_which_were_kept(dots, tmp_path):
    few = tmp_path / "few.csv"
    pd.read_csv(dots).iloc[::6].to_csv(few, index=False)
    for density, name in ((3, "a.npz"), (6, "b.csv")):
        assert command.main(["recover", str(few), "--density", str(density), "-o", str(tmp_path / name)]) == 0
    sparse, dense = sparsurf.read_surface(tmp_path / "a.npz"), pd.read_csv(tmp_path / "b.csv")
    # The integral over r(polar, azimuth) of the blob and its satellite; the noise of the normals makes the surface bumpy
    assert (sparse.area > 0).all() and sparse.area.sum() == pytest.approx(838 + 8, rel=0.15)
    assert dense["kept"].tolist() == [1] * 500 + [0] * (len(dense) - 500)
    assert 1.6 < (len(dense) - 500) / (len(sparse) - 500) < 3
    places = tmp_path / "places.csv"
    pd.DataFrame({"name": ["a"], "z": [8.0], "x": [0.0], "y": [0.5]}).to_csv(places, index=False)
    assert command.main(["recover", str(few), "--at", str(places), "-o", str(tmp_path / "z.csv")]) == 0
    z = pd.read_csv(tmp_path / "z.csv")
    assert z[["x", "y", "z"]].to_numpy().tolist() == [[0.0, 0.5, 8.0]]
    whole = sparsurf.recover(few)
    expected = sparsurf.descriptors(whole, np.array([[0.0, 0.5, 8.0]]))
    assert z.filter(like="z_").to_numpy() == pytest.approx(expected, rel=1e-5)
    for name in ("m.csv", "m.npz", "m.ply"):  # places of every kind of file that dots come in
        ran("minimal", few, "--n-dots", 9, "-o", tmp_path / name, d_link=3)
        words = [str(few), "--at", str(tmp_path / name), "-o", str(tmp_path / "z.csv")]
        assert command.main(["recover", *words]) == 0
        z, places = pd.read_csv(tmp_path / "z.csv"), sparsurf.read_surface(tmp_path / name).points
        assert z[["x", "y", "z"]].to_numpy() == pytest.approx(places) and len(z) == 9


def test_the_columns_of_dots(tmp_path):
    surface = Surface([[1.0, 2, 3]], [[0.0, 0, 1]], np.array([0.2]), np.array([1]), np.array([0]))
    own = writing.DotsToWrite(surface, pd.DataFrame({"own": [7], "word": ["GLY"], "dot": [4]}))
    for end in ("csv", "npz", "ply"):
        writing.write_dots(tmp_path / f"a.{end}", own)
    row = {"dot": 4, "x": 1, "y": 2, "z": 3, "nx": 0, "ny": 0, "nz": 1, "own": 7, "word": "GLY"}
    assert pd.read_csv(tmp_path / "a.csv").to_dict("records") == [row]
    with np.load(tmp_path / "a.npz") as found:
        assert set(found) == {"points", "normals", "area", "kind", "atom", "own", "word", "dot"}
    text = (tmp_path / "a.ply").read_text()
    assert "property int dot\nproperty int own\n" in text and " 4 7\n" in text and "word" not in text
    with pytest.raises(InputError, match=r"written as '.dms'"):
        writing.write_dots(tmp_path / "a.dms", own)


def test_the_noise_floor_is_that_of_the_rules_that_are_given():
    peptide = sparsurf.read_molecule(PEPTIDE, residues="209-212")
    rules = {"density": 4.0, "probe_radius": 1.6, "radii": "bondi"}

    def floors(d_link=1.4, seed=3, **others):
        dots = sparsurf.surface(peptide, **rules | others)
        return sparsurf.floors(dots, d_link=d_link, seed=seed).set_index("floor")

    table = floors()
    assert [*table.index] == ["fresh dots"]
    pd.testing.assert_frame_equal(floors(), table)
    for other in ({"seed": 4}, {"density": 5.0}, {"probe_radius": 1.4}, {"radii": "dms"}, {"d_link": 1.6}):
        assert (floors(**other)["Z"] != table["Z"]).any()


@pytest.fixture(scope="module")
def two_frames():
    """A peptide in two shapes."""
    data = ROOT / "data" / "tdp43"
    moving = sparsurf.read_molecule(
        data / "topology.pdb", data / "trajectory.xtc", residues="209-214", stride=700
    )
    return replace(moving, xyz=moving.xyz[:2])


def test_components_and_noise_floors_are_those_of_the_frame(two_frames):
    dots = [sparsurf.surface(two_frames, frame=frame) for frame in (0, 1)]
    alone = [replace(two_frames, xyz=two_frames.xyz[[frame]]) for frame in (0, 1)]
    first, second = (sparsurf.floors(each, seed=3) for each in dots)
    pd.testing.assert_frame_equal(sparsurf.floors(alone[1], seed=3), second)
    assert (first["Z"] != second["Z"]).all()
    own = [sparsurf.components(molecule)[1] for molecule in alone]
    for frame in (0, 1):
        pd.testing.assert_frame_equal(sparsurf.components(dots[frame])[1], own[frame])
    assert own[0]["volume"][0] != own[1]["volume"][0]


def test_points_of_a_frame_are_those_of_its_atoms(two_frames):
    how = {"n_dots": 60, "fields": ["potential", "roughness"], "probe_radius": 1.6}
    moved, alone = (sparsurf.points(two_frames, frame=1, **how), sparsurf.points(two_frames.frame(1), **how))
    pd.testing.assert_frame_equal(moved.to_frame(), alone.to_frame())


def test_the_roughness_of_a_vertex_is_that_of_the_nearest_dot():
    """Placed by the same rules; of a mesh of few dots, that of the surface reconstructed from them."""
    dots = sparsurf.surface(
        sparsurf.read_molecule(PEPTIDE, residues="209-214"), probe_radius=2.0, radii="bondi"
    )
    few = sparsurf.minimal(dots, n_dots=150)
    for source, dense in ((dots, dots), (few, sparsurf.recover((few.points, few.normals)))):
        vertices = sparsurf.mesh(source, 200, fields="roughness").vertices
        nearest = cKDTree(dense.points).query(vertices.points)[1]
        wanted = sparsurf.roughness((dense.points, dense.normals))[nearest]
        assert vertices.fields["roughness"] == pytest.approx(wanted, abs=1e-6)
    nearest = cKDTree(few.points).query(vertices.points)[1]
    assert (vertices.atom == few.surface.atom[nearest]).mean() > 0.99  # two dots may be as near


@pytest.mark.parametrize(("cavities", "parts"), [("keep", 2), ("remove", 1)])
def test_a_mesh_has_the_cavities_that_its_dots_have(cavities, parts):
    made = sparsurf.mesh(sparsurf.surface(PEPTIDE, cavities=cavities), density=1)
    assert len(made.vertices) == pytest.approx(made.vertices.area.sum(), rel=0.05)  # 1 per Å^2
    n, ends = len(made.vertices), made.triangles[:, [0, 1, 2]].T
    links = coo_array((np.ones(2 * len(ends[0])), (np.r_[ends[0], ends[1]], np.r_[ends[1], ends[2]])), (n, n))
    assert connected_components(links, directed=False)[0] == parts


def test_concave_dots_inside_other_probes_are_kept_where_asked():
    xyz, radii = np.array([[0.0, 0, 0], [4.7, 0, 0], [2.35, 4.07, 0]]), np.full(3, 1.5)
    exact, dms = (sparsurf.surface((xyz, radii), density=8, reentrant=each) for each in ("exact", "dms"))
    own = molecular_surface(xyz, radii, density=8, reentrant="dms")
    assert len(exact) < len(dms) and np.array_equal(dms.points, own.points)


def test_the_keywords_of_placing_dots_are_those_of_surface():
    taken = inspect.signature(sparsurf.surface).parameters.values()
    assert {each.name for each in taken if each.kind is each.KEYWORD_ONLY} == {*PLACEMENT}


@pytest.mark.parametrize("path", [None, 3, b"a.csv", ["a.csv"], ""])
def test_what_is_no_path_is_named_where_a_result_is_written(path):
    for result in (Surface(5 * np.eye(3), np.eye(3)), pd.DataFrame({"a": [1]})):
        with pytest.raises(InputError, match="a path is"):
            sparsurf.write(result, path)


def test_dots_that_were_placed_for_a_larger_link_are_sampled_and_compared_with_it():
    """`sample` and `compare` have no argument for the link, so that they follow the dots."""
    dots = sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-214"), density=2, d_link=1.0)
    ready = sparsurf.prepare(dots, d_link=1.0)
    assert np.array_equal(sparsurf.sample(dots, percent=30), sparsurf.sample(ready, percent=30))
    kept = sparsurf.sample(dots, combination=(1, 0, 6, 0), seed=3)
    assert np.array_equal(kept, sparsurf.sample(ready, combination=(1, 0, 6, 0), seed=3))
    assert sparsurf.compare(dots, kept, test_dots=9).equals(sparsurf.compare(ready, kept, test_dots=9))
    with pytest.raises(InputError, match=r"d_link = 0\.5"):
        sparsurf.sample(sparsurf.Surface(dots.points, dots.normals), percent=30)


@pytest.mark.parametrize(
    ("text", "are_spheres"),
    [
        ("0 0 0 1.7\n3.0 0 -1e0 1.7\n", True),
        ("0 0 0 1.7 C\n3 0 0 1.7 C\n", False),
        ("x y z r\n0 0 0 1\n", False),
    ],
)
def test_spheres_under_another_name_are_told_the_name_that_is_read(tmp_path, text, are_spheres):
    (tmp_path / "s.dat").write_text(text)
    with pytest.raises(InputError) as told:
        sparsurf.surface(tmp_path / "s.dat")
    assert ("ends in .xyzr" in str(told.value)) == are_spheres
    if are_spheres:
        (tmp_path / "s.dat").rename(tmp_path / "s.xyzr")
        assert len(sparsurf.surface(tmp_path / "s.xyzr").origin.radii) == 2
