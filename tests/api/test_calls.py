"""The functions for users and what commands share, on dots whose answers are known."""

import argparse
import gzip
import os
import re
from dataclasses import replace
from functools import partial
from operator import attrgetter
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest
from scipy.spatial.distance import pdist

import sparsurf
from conftest import ROOT
from sparsurf.api import inputs, writing
from sparsurf.api.surfaces import surface_settings
from sparsurf.cli import command, descriptors, options
from sparsurf.errors import InputError
from sparsurf.patches import descriptors as engine
from sparsurf.patches.index import build_index
from sparsurf.patches.roughness import roughness
from sparsurf.sampling import published
from sparsurf.sampling.samplers import SAMPLERS
from sparsurf.streams import DEFAULT_SEED, Streams
from sparsurf.study.floors import floors_table, measure_floors
from sparsurf.study.subset_search import warn_if_number_differs
from sparsurf.surfaces.mesh import grid_step_for_density
from sparsurf.surfaces.molecular_surface import surface_generator
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.surface import Surface
from sparsurf.workflow.models import Config

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


@pytest.mark.parametrize(
    ("limits", "key"),
    [
        (inputs.LENGTH, "Patches.r_patch"),
        (inputs.LENGTH, "Patches.r_zernike"),
        (inputs.LENGTH, "Patches.d_link"),
        (inputs.PROBE, "Surface.probe_radius"),
        (inputs.DENSITY, "Surface.density.anyOf.1"),
        (inputs.SEED, "Config.seed"),
        (inputs.TEST_DOTS, "Evaluation.test_dots.anyOf.1"),
        (inputs.PERCENT, "Minimal.n_S_percent"),
        (inputs.ALPHA, "Sampling.alpha.items"),
        (inputs.EXPONENT, "Minimal.combination.items"),
    ],
)
def test_numbers_have_the_limits_of_the_config(limits, key):
    schema = Config.model_json_schema()
    rule = schema["$defs"] | {"Config": schema}
    for word in key.split("."):
        rule = rule[int(word)] if isinstance(rule, list) else rule.get("properties", rule)[word]
    low = rule.get("exclusiveMinimum", rule.get("minimum"))
    assert limits == (low, rule["maximum"], rule["type"] == "integer", "exclusiveMinimum" in rule)


MISTAKES = [  # what is called with the dots of the blob, or with them prepared, and what its sentence holds
    *(
        (
            lambda dots, r=r: sparsurf.roughness(dots, r_patch=r),
            f"r_patch is {r!r}; it must be a number, more than 0",
        )
        for r in (0, -1, float("nan"), float("inf"), 101, "4", True)
    ),
    (lambda dots: sparsurf.roughness(dots, d_link=float("nan")), "d_link is nan"),
    (
        lambda dots: sparsurf.roughness((dots[0].astype(complex), dots[1])),
        "points holds something else than real",
    ),
    (
        lambda dots: sparsurf.roughness((dots[0].astype(bytes), dots[1])),
        "points holds something else than real",
    ),
    (lambda dots: sparsurf.roughness((dots[0].T, dots[1].T)), "points has the shape (3, 3000), not (N, 3)"),
    (lambda dots: sparsurf.roughness((dots[0], dots[1].T)), "normals has the shape (3, 3000), not (3000, 3)"),
    (lambda dots: sparsurf.roughness((dots[0], 2 * dots[1])), "normals are not of unit length"),
    (lambda dots: sparsurf.roughness((np.ma.masked_less(dots[0], 0), dots[1])), "points has masked values"),
    (lambda dots: sparsurf.roughness((["a"], ["b"])), "points holds something else than real numbers"),
    (lambda dots: sparsurf.roughness((None, None)), "points has the shape (0,)"),
    (lambda dots: sparsurf.descriptors(dots, [0], r_zernike=-1), "r_zernike is -1"),
    (lambda dots: sparsurf.descriptors(dots, [[0, 0, np.nan]], d_link=D_LINK), "at: some points have NaN"),
    (
        lambda dots: sparsurf.descriptors(dots, [0], up="x", d_link=D_LINK),
        "up is 'x'; it must be True or False",
    ),
    (lambda dots: sparsurf.descriptors(dots, [[1, 2], [3]], d_link=D_LINK), "at: give one array"),
    (lambda dots: sparsurf.prepare(dots, r_patch=0), "r_patch is 0"),
    (lambda dots: sparsurf.prepare(dots, r_zernike=0), "r_zernike is 0"),
    (lambda dots: sparsurf.prepare(dots, d_link=0), "d_link is 0"),
    (lambda dots: sparsurf.prepare(dots, seed=-1), "seed is -1; it must be a whole number"),
    *(
        (lambda dots, d=d: sparsurf.recover(dots, density=d), f"density is {d!r}")
        for d in (float("nan"), 0, 1e9)
    ),
    (lambda dots: sparsurf.surface(BALL, density="high"), "density is 'high'; it must be 'auto' or a number"),
    (lambda dots: sparsurf.surface(BALL, d_link=0), "d_link is 0"),
    (lambda dots: sparsurf.surface(BALL, probe_radius=11), "probe_radius is 11"),
    (lambda dots: sparsurf.surface(([[0, 0, 0]], [101])), "atomic radii must be positive"),
    (lambda dots: sparsurf.surface(([[1, 2, 3], [4, 5]], [1, 1])), "rows of unequal length"),
    (lambda dots: radii(SimpleNamespace(element=["C"]), "x"), "radii is 'x'; it must be "),
    *(
        (lambda dots, read=read: read(b"dots.csv"), "a path is a string or a Path, not bytes")
        for read in (sparsurf.read_surface, sparsurf.read_molecule)
    ),
]
OF_PREPARED = [
    (lambda ready: sparsurf.sample(ready, n_dots=9, seed=-1), "seed is -1"),
    *(
        (lambda ready, given=given: sparsurf.sample(ready, combination=given), words)
        for given, words in (
            ((2, -1, 6, 0), "combination: alpha is 2"),
            ((1, -1, 6, 0), "combination: beta is -1"),
            ((1, 0, np.nan, 0), "combination: gamma is nan"),
            ((1, 0, 6, "x"), "combination: delta is 'x'"),
            ((1, 0, 6), "it must be the four numbers"),
            (1, "it must be the four numbers"),
        )
    ),
    *((lambda ready, n=n: sparsurf.compare(ready, [0], test_dots=n), f"test_dots is {n!r}") for n in (-1, 2.5, "many")),
    (lambda ready: sparsurf.sample(ready, n_dots=9, combination=(1, 0, 6, 0)), "leave out n_dots or the combination"),
    (lambda ready: sparsurf.sample(ready, combination=(1, 0, 6, 0), sampler="uniform"), "not 'uniform'; leave out"),
    (lambda ready: sparsurf.sample(ready, n_dots=9, sampler=["x"]), "there is no sampler ['x']; the samplers are"),
    (lambda ready: sparsurf.compare(ready, [[1, 2], [3]]), "subset: give one array"),
    (lambda ready: sparsurf.compare(ready, {}), "subsets: there are none"),
    (lambda ready: sparsurf.compare(ready, [0], reading="x"), "reading is 'x'; it must be "),
    (lambda ready: sparsurf.prepare(ready, r_zernike=5), "prepared already"),
    *(
        (lambda ready, call=call: call(ready), "give the dots that it was prepared from")
        for call in (sparsurf.roughness, sparsurf.descriptors, sparsurf.recover)
    ),
]  # fmt: skip


@pytest.mark.parametrize(("call", "words"), MISTAKES)
def test_a_senseless_number_is_one_sentence(blob, call, words):
    with pytest.raises(InputError, match=re.escape(words)) as told:
        call(blob)
    assert "\n" not in str(told.value)


@pytest.mark.parametrize(("call", "words"), OF_PREPARED)
def test_what_a_prepared_surface_cannot_do_is_one_sentence(ready, call, words):
    test_a_senseless_number_is_one_sentence(ready, call, words)


def test_masked_values_are_no_places(blob):
    points, normals = np.ma.array(blob[0]), blob[1]
    assert len(sparsurf.prepare((points, normals), d_link=0.8).points) == 3000  # of a mask that hides nothing
    points[3] = np.ma.masked
    with pytest.raises(InputError, match="points has masked values"):
        sparsurf.prepare((points, normals), d_link=0.8)


def test_the_help_names_every_sampler():
    named = sparsurf.sample.__doc__.split("sampler : str\n")[1].split("\n")[0]
    assert {name.strip() for name in named.split(",")} == set(SAMPLERS)


def test_a_sample_has_the_requested_number(ready):
    assert len(sparsurf.sample(ready, percent=10)) == 300
    assert len(sparsurf.sample(ready, n_dots=1)) == 1
    assert sorted(sparsurf.sample(ready, n_dots=3000, sampler="uniform")) == list(range(3000))
    for n in (0, -1, 2.5, 3001, np.nan, np.inf, "10", True):
        with pytest.raises(InputError, match=r"n_dots is .* it must be a whole number, 1 to 3000"):
            sparsurf.sample(ready, n_dots=n)
    with pytest.raises(InputError, match="percent is 0; it must be a number, more than 0 and at most 100"):
        sparsurf.sample(ready, percent=0)
    for given in ({}, {"n_dots": 5, "percent": 5}):
        with pytest.raises(InputError, match="either percent or n_dots"):
            sparsurf.sample(ready, **given)
    first, again, other = (
        sparsurf.sample(ready, n_dots=50, sampler="uniform", seed=s).tolist() for s in (0, 0, 1)
    )
    assert first == again and len(set(first) & set(other)) < 10
    kept = sparsurf.sample(ready, combination=(1, 0, 6, 0), seed=7)
    reseeded = ready.changed(stream=Streams(7))
    assert np.array_equal(kept, reseeded.pair((1, 0, 6, 0), 0)[0])
    assert np.array_equal(kept, sparsurf.sample(ready, combination=(1, 0, 6, 0), sampler="paper", seed=7))
    other = sparsurf.sample(ready, combination=(1, 0, 6, 0), sampler="paper_corrected", seed=7)
    corrected = reseeded.changed(cover=ready.corrected_cover)
    assert np.array_equal(other, corrected.pair((1, 0, 6, 0), 0)[0]) and len(other) != len(kept)
    assert np.array_equal(
        sparsurf.sample(ready, n_dots=9), sparsurf.sample(ready, n_dots=9, sampler="farthest")
    )


def test_a_number_of_dots_that_was_not_requested_is_reported(ready, dots, tmp_path, caplog, capsys):
    n = len(sparsurf.sample(ready, n_dots=1, sampler="paper"))
    assert n > 1 and caplog.messages == [
        f"paper keeps {n} dots instead of 1: its number of dots is random, and limited by its combinations"
    ]
    for requested in (n, 1.07 * n, 0.95 * n):
        warn_if_number_differs("paper", requested, n)
    assert len(caplog.messages) == 1
    warn_if_number_differs("paper", 0.9 * n, n)
    warn_if_number_differs("paper", 1.2 * n, n)
    assert len(caplog.messages) == 3
    ran("minimal", dots, "--n-dots", 1, "--sampler", "paper", "-o", tmp_path / "m.csv")
    n = len(pd.read_csv(tmp_path / "m.csv"))
    assert capsys.readouterr().err.startswith(f"sparsurf: warning: paper keeps {n} dots instead of 1: ")


def test_places_without_a_patch_are_reported(blob, caplog):
    places = np.array([blob[0][5], [0, 0, 99], [0, 99, 0]])
    z = sparsurf.descriptors(blob, places, d_link=D_LINK)
    assert z[0].any() and not z[1:].any()
    assert caplog.messages == [
        "at: 2 of 3 points have no patch, as no dot lies within 6 Å; their descriptors are zeros"
    ]
    assert sparsurf.descriptors(blob, [], d_link=D_LINK).shape == (0, 121)
    assert sparsurf.descriptors(blob, [5], d_link=D_LINK).any() and len(caplog.messages) == 1


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
    kept = sparsurf.compare(ready, half, reading="kept", test_dots=50)
    assert kept.loc["subset", "Z"] == pytest.approx(ready.distances([half], tests, z_tot, "kept")[0].mean())


@pytest.mark.parametrize("subset", [[0, 0], [-1], [3000], [], [0.5], [[1, 2]], np.ones(5, bool)])
def test_what_is_no_subset_is_refused(ready, subset):
    with pytest.raises(
        InputError, match="wrong: a subset is numbers from 0 to 2999, each once, at least one"
    ):
        sparsurf.compare(ready, {"wrong": subset})


def test_patches_are_cut_as_requested(blob):
    index = build_index(*blob, D_LINK)
    assert np.array_equal(sparsurf.roughness(blob, r_patch=3, d_link=D_LINK), roughness(index, 3.0, 1))
    z = sparsurf.descriptors(blob, [5, 2999], r_zernike=4, d_link=D_LINK)
    assert np.array_equal(z, engine.describe(index, blob[0][[5, 2999]], 4.0, True)[0])
    assert np.array_equal(sparsurf.descriptors(blob, blob[0][[5, 2999]], r_zernike=4, d_link=D_LINK), z)
    these = np.isin(np.arange(len(blob[0])), [5, 2999])
    assert np.array_equal(sparsurf.descriptors(blob, these, r_zernike=4, d_link=D_LINK), z)
    other = sparsurf.descriptors(blob, [5], r_zernike=4, d_link=D_LINK, descriptor="rotation_robust")
    assert np.array_equal(
        other, engine.describe(index, blob[0][[5]], 4.0, True, descriptor="rotation_robust")[0]
    )
    down = sparsurf.descriptors(blob, [5], r_zernike=4, up=False, d_link=D_LINK)
    assert np.array_equal(down, engine.describe(index, blob[0][[5]], 4.0, False)[0])
    assert np.abs(down - z[:1]).max() > 1e-3
    few = tuple(x[:200] for x in blob)
    every = sparsurf.descriptors(few, r_zernike=1, d_link=5.0)
    assert every.shape == (200, 121)
    two = sparsurf.descriptors(few, [7, 9], r_zernike=1, d_link=5.0)
    assert np.allclose(
        every[[7, 9]], two, rtol=0, atol=1e-12
    )  # BLAS adds in the order of the number of patches
    for at, words in (([3000], "there is no dot 3000; the surface has 0 to 2999"), ([-1], "no dot -1"),
                      ([0.5], "give"), ([[1, 2]], "give")):  # fmt: skip
        with pytest.raises(InputError, match=words):
            sparsurf.descriptors(blob, at, d_link=D_LINK)


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


@pytest.mark.parametrize(("radii", "carbon"), [("dms", 1.9), ("bondi", 1.7)])
def test_radii_are_those_of_the_table_that_is_named(tmp_path, radii, carbon):
    line = "ATOM      1  CA  GLY A   1       1.000   2.000   3.000  1.00  0.00           C  \n"
    (tmp_path / "one.pdb").write_text(line)
    molecule = sparsurf.read_molecule(tmp_path / "one.pdb", selection="all")
    dots = sparsurf.surface(molecule, radii=radii)
    assert np.linalg.norm(dots.points - [1, 2, 3], axis=1) == pytest.approx(carbon, abs=1e-6)


def test_a_frame_is_taken_by_its_place():
    frame = SimpleNamespace(n_frames=2)
    with pytest.raises(InputError, match="a SimpleNamespace is not a molecule"):
        sparsurf.surface(frame)
    inputs.check_frame(frame, 1, "it")
    for number in (2, -1, 0.0, "x"):
        with pytest.raises(InputError, match=f"^it has the frames 0 to 1: there is no frame {number}\\.$"):
            inputs.check_frame(frame, number, "it")
    assert len(sparsurf.surface(([[0, 0, 0]], [1.5]), frame=5)) > 0  # spheres have no frames
    with pytest.raises(InputError, match=r"^the molecule has one frame, 0: there is no frame 5\.$"):
        sparsurf.surface(ROOT / "data" / "tdp43" / "topology.pdb", frame=5)


def test_dots_come_back_first_and_as_dense_as_requested(blob):
    few = tuple(x[::6] for x in blob)
    sparse, dense = (sparsurf.recover(few, density=d) for d in (3.0, 6.0))
    assert np.array_equal(dense.points[:500], few[0]) and np.allclose(dense.normals[:500], few[1])
    assert 1.6 < (len(dense) - 500) / (len(sparse) - 500) < 3


def test_dots_know_their_molecule():
    """So that all that follows from the atoms needs only the dots, and is the same as from the file."""
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-214")
    how = {"probe_radius": 1.5, "radii": "bondi"}
    dots = sparsurf.surface(molecule, **how)
    few, own = sparsurf.minimal(dots), sparsurf.minimal(molecule, **how)
    assert np.array_equal(few.dots, own.dots) and few.table.equals(own.table)
    assert sparsurf.residues(dots).equals(sparsurf.residues(dots, molecule))
    names = ["hydropathy"]
    assert sparsurf.fields(dots, names).equals(sparsurf.fields(molecule, dots, names))
    assert sparsurf.fields(dots, names=names).equals(sparsurf.fields(molecule, dots, names))
    component, table = sparsurf.components(dots)
    again = sparsurf.components(molecule, dots, **how)
    assert np.array_equal(component, again[0]) and table.equals(again[1])
    assert table.equals(sparsurf.components(molecule, **how)[1])
    assert sparsurf.mesh(dots).volume == sparsurf.mesh(molecule, **how).volume
    frame = dots.to_frame()
    assert (
        list(frame)[7:10] == ["kind", "component", "chain"]
        and frame["component"].tolist() == component.tolist()
    )
    assert frame["residue"].tolist() == molecule.residue[dots.atom].tolist()
    whole = sparsurf.surface(ROOT / "data" / "tdp43" / "topology.pdb")  # with one cavity
    assert whole.to_frame()["component"].value_counts().tolist() == [24376, 224]


def test_dots_of_other_atoms_are_refused(tmp_path):
    """Not only those of another frame; a molecule with more atoms around them is no other for fields."""
    whole = sparsurf.read_molecule(PEPTIDE, residues="209-214")
    bare = sparsurf.read_molecule(PEPTIDE, residues="209-214", hydrogens="remove")
    more = sparsurf.read_molecule(PEPTIDE, residues="209-218")
    moved = replace(bare, xyz=bare.xyz + 1.0)
    dots = sparsurf.surface(bare)
    assert sparsurf.residues(
        dots, sparsurf.read_molecule(PEPTIDE, residues="209-214", hydrogens="remove")
    ).equals(sparsurf.residues(dots))
    sparsurf.residues(dots, moved)  # which asks for names only
    for name, call in {
        "residues": lambda own: sparsurf.residues(dots, own),
        "components": lambda own: sparsurf.components(own, dots),
        "write": lambda own: sparsurf.write(dots, tmp_path / "x.dms", molecule=own),
        "fields": lambda own: sparsurf.fields(own, dots, ["hydropathy"]),
    }.items():
        others = {"residues": [whole, more], "fields": [moved]}.get(name, [whole, more, moved])
        for own in others:
            with pytest.raises(InputError, match=f"^{name}: the dots were placed on other atoms"):
                call(own)
    for own in (whole, more, bare):
        assert len(sparsurf.fields(own, dots, ["hydropathy"])) == len(dots)
    assert not (tmp_path / "x.dms").exists()


def test_a_path_names_the_molecule_wherever_one_is_requested(tmp_path):
    dots = sparsurf.surface(PEPTIDE)
    sparsurf.write(dots, tmp_path / "a.dms", PEPTIDE)
    sparsurf.write(dots, tmp_path / "b.dms")
    assert (tmp_path / "a.dms").read_bytes() == (tmp_path / "b.dms").read_bytes()
    with pytest.raises(InputError, match="components: the dots are not those of the molecule"):
        sparsurf.components(PEPTIDE, (dots.points, dots.normals))


def test_areas_of_a_part_of_the_dots_are_refused(blob):
    dots = sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-214"))
    few = sparsurf.minimal(dots, percent=10)
    for part in (dots.take(slice(None, None, 2)), few.surface):
        with pytest.raises(InputError, match=r"^components: these are not all dots of their surface"):
            sparsurf.components(part)
    with pytest.raises(InputError, match=r"^components: these are not all dots of their surface"):
        sparsurf.components(dots.origin.molecule, few)


def test_what_is_wrong_with_numbers_is_reported_in_the_words_of_the_call(blob):
    dots = sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-210"))
    with pytest.raises(InputError, match=rf"^minimal: n_dots is 100000, more than the {len(dots)} dots"):
        sparsurf.minimal(dots, n_dots=100_000)
    with pytest.raises(InputError, match=r"^roughness_values: the arrays hold something else than numbers"):
        sparsurf.residues(dots, roughness_values=["a"] * len(dots))


def test_dots_and_atoms_are_of_one_frame():
    one = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-212")
    both = replace(
        one,
        xyz=np.stack([one.xyz[0], one.xyz[0] * [1, 1, -1] + 3.0]),
        time_ps=np.zeros(2),
        frame_number=np.arange(2),
    )
    dots = sparsurf.surface(both, frame=1)
    field = sparsurf.fields(dots, ["hydropathy"])
    assert field.equals(sparsurf.fields(both, dots, ["hydropathy"], frame=1))
    assert field.equals(sparsurf.fields(both.frame(1), dots, ["hydropathy"]))
    for call in (sparsurf.fields, sparsurf.components):
        with pytest.raises(InputError, match=f"{call.__name__}: the dots are those of frame 1; give frame=1"):
            call(both, dots)
    with pytest.raises(InputError, match="fields: the dots were placed with frame=0"):
        sparsurf.fields(sparsurf.surface(both), frame=1)


def test_kept_dots_of_residues_may_be_a_mask():
    dots = sparsurf.surface(
        sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-212")
    )
    few = np.arange(0, len(dots), 7)
    mask = np.isin(np.arange(len(dots)), few)
    table = sparsurf.residues(dots, kept=few)
    assert table["kept"].sum() == len(few) and table.equals(sparsurf.residues(dots, kept=mask))


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"kept": [10**6]}, "kept: a subset is numbers from 0 to"),
        ({"kept": [-1]}, "kept: a subset is numbers from 0 to"),
        ({"kept": [1.7, 2.2]}, "kept: a subset is numbers from 0 to"),
        ({"kept": np.ones(5, bool)}, "kept: a subset is numbers from 0 to"),
        ({"kept": [1, 2], "weight": [1]}, r"weight has the shape \(1,\); the kept dots are 2"),
        ({"roughness_values": [0.1, 0.2]}, r"roughness_values has the shape \(2,\)"),
    ],
)
def test_residues_of_what_is_no_subset_are_refused(wrong, said):
    dots = sparsurf.surface(
        sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-210")
    )
    with pytest.raises(InputError, match=said):
        sparsurf.residues(dots, **{"roughness_values": np.zeros(len(dots))} | wrong)
    assert sparsurf.residues(dots, kept=np.zeros(len(dots), bool))["kept"].sum() == 0


@pytest.mark.parametrize("wish", [{"frame": 5}, {"probe_radius": 3.0}, {"radii": "bondi"}])
def test_rules_of_placing_dots_are_refused_for_dots(blob, wish):
    for call in (partial(sparsurf.minimal, percent=10), sparsurf.floors, sparsurf.mesh):
        with pytest.raises(InputError, match=f"{next(iter(wish))}=.* is about placing dots; leave it out"):
            call(blob if call is not sparsurf.mesh else Surface(*blob), **wish)


def test_components_go_by_the_rules_that_placed_the_dots():
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-214")
    dots = sparsurf.surface(molecule, probe_radius=0.8)
    for found in (sparsurf.components(dots), sparsurf.components(molecule, dots)):
        assert found[1]["dots"].tolist() == [len(dots)]
    with pytest.raises(InputError, match=r"components: the dots were placed with probe_radius=0\.8"):
        sparsurf.components(molecule, dots, probe_radius=3.0)


def test_a_named_index_is_written_and_dots_of_another_frame_are_not(ready, tmp_path):
    table = pd.DataFrame({"Z": [1.5]}, index=pd.Index(["mine"], name="subset"))
    sparsurf.write(table, tmp_path / "t.csv")
    assert (tmp_path / "t.csv").read_text() == "subset,Z\nmine,1.5\n"
    sparsurf.write(table, tmp_path / "t.npz")
    with np.load(tmp_path / "t.npz") as held:
        assert held["subset"].tolist() == ["mine"]
    data = ROOT / "data" / "tdp43"
    molecule = sparsurf.read_molecule(
        data / "topology.pdb", data / "trajectory.xtc", residues="209-210", stride=500
    )
    dots = sparsurf.surface(molecule, frame=1)
    with pytest.raises(InputError, match="write: the dots are those of frame 1"):
        sparsurf.write(dots, tmp_path / "x.dms", molecule=molecule)
    sparsurf.write(dots, tmp_path / "x.dms", molecule=molecule, frame=1)


def test_a_part_of_the_dots_is_no_whole_surface():
    molecule = sparsurf.read_molecule(ROOT / "data" / "tdp43" / "topology.pdb", residues="209-214")
    dots = sparsurf.surface(molecule)
    part = dots.take(dots.points[:, 0] > dots.points[:, 0].mean())
    assert "component" not in part.to_frame()
    assert part.to_frame()["atom_name"].tolist() == molecule.name[part.atom].tolist()
    alone = replace(part, origin=None)  # as of a file
    assert np.array_equal(sparsurf.minimal(part).dots, sparsurf.minimal(alone).dots)


def test_what_minimal_gave_is_taken_for_its_dots(blob):
    few = sparsurf.minimal(blob, percent=20, d_link=D_LINK)
    dense = sparsurf.recover(few)
    assert np.array_equal(dense.points, sparsurf.recover(few.surface).points) and len(dense) > 2 * len(
        few.dots
    )
    assert sparsurf.mesh(few).volume == pytest.approx(sparsurf.mesh(Surface(*blob)).volume, rel=0.01)


def test_dots_of_a_file_know_no_molecule(blob):
    for name in ("fields", "residues", "components"):
        with pytest.raises(InputError, match=f"^{name}: these dots know no molecule; give it, too"):
            getattr(sparsurf, name)(Surface(*blob))


def test_what_is_taken_for_a_surface_and_a_structure(blob, tmp_path):
    made = inputs.as_dots(tuple(map(np.ndarray.tolist, blob)))
    assert np.array_equal(made.points, blob[0]) and inputs.as_dots(made) is made
    for wrong in (list(blob), (blob[0],), 3):
        with pytest.raises(InputError, match="is not a surface: give the path"):
            inputs.as_dots(wrong)
    for atoms in ("a.pdb", tmp_path / "a.cif.gz"):
        with pytest.raises(
            InputError, match=r"a\.(pdb|cif\.gz) holds atoms: give the dots that surface\(\) places"
        ):
            inputs.as_dots(atoms)
    with pytest.raises(InputError, match=r"^an int is not a molecule"):
        inputs.as_molecule(3)
    with pytest.raises(InputError, match=r"^a list is not a surface"):
        inputs.as_dots([])
    names = {"a.pdb": True, "a.PDB.gz": True, "a.cif": True, "a.gro": True, "a.prmtop": True, "a.csv": False}
    names |= {"a.dms.gz": False, "a.npz": False, "a.xtc": False}
    assert {name: inputs.is_structure(tmp_path / name) for name in names} == names


def test_the_suffix_decides(tmp_path, capfdbinary):
    written = {end: lambda path, end=end: path.write_text(f"{end} in {path.name}") for end in writing.DOTS}
    for name, words in (
        ("a.csv", ".csv in part.csv"),
        ("a.PLY", ".ply in part.ply"),
        ("a.dms.gz", ".dms in part.dms"),
        ("a.csv.GZ", ".csv in part.csv"),
    ):
        writing.write_file(tmp_path / name, writing.DOTS, written)
        packed = name.lower().endswith(".gz")
        content = gzip.compress(words.encode(), mtime=0) if packed else words.encode()  # the same at any time
        assert (tmp_path / name).read_bytes() == content
    writing.write_file("-", writing.DOTS, written)
    assert capfdbinary.readouterr().out == b".csv in part.csv"
    with pytest.raises(InputError, match=r"cannot be written as '.ply'; name a file in .csv, .npz."):
        writing.write_file(tmp_path / "a.ply", writing.TABLES, written)
    with pytest.raises(
        InputError, match=r"/a\.gz: the name has no suffix; name a file in \.dms, \.csv, \.npz, "
    ):
        writing.write_file(tmp_path / "a.gz", writing.DOTS, written)

    def broken(path):
        path.write_text("half")
        raise OSError("full")

    with pytest.raises(OSError):
        writing.write_file(tmp_path / "b.csv", writing.DOTS, {".csv": broken})
    names = ["a.PLY", "a.csv", "a.csv.GZ", "a.dms.gz"]
    assert sorted(path.name for path in tmp_path.iterdir()) == names


def test_links_and_pipes_stay_what_they_are(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "folder" / "old.csv").write_text("old")
    for name in ("old.csv", "new.csv"):  # there, and not there yet
        (tmp_path / name).symlink_to(tmp_path / "folder" / name)
        writing.write_file(tmp_path / name, writing.TABLES, {".csv": lambda path: path.write_text("dots")})
        assert (tmp_path / name).is_symlink() and (tmp_path / "folder" / name).read_text() == "dots"
    os.mkfifo(tmp_path / "pipe.csv")
    reader = os.open(tmp_path / "pipe.csv", os.O_RDONLY | os.O_NONBLOCK)
    writing.write_file(tmp_path / "pipe.csv", writing.TABLES, {".csv": lambda path: path.write_text("dots")})
    assert os.read(reader, 99) == b"dots" and (tmp_path / "pipe.csv").is_fifo()
    os.close(reader)


@pytest.mark.parametrize(
    ("keys", "text", "value"),
    [
        ({"low": 0}, "0.5", 0.5),
        ({"low": 0}, "0", None),
        ({"low": 0, "open_low": False}, "0", 0),
        ({"low": 0, "open_low": False}, "-1", None),
        ({"low": 0, "high": 100}, "100", 100),
        ({"low": 0, "high": 100}, "100.1", None),
        ({"low": 0, "whole": True}, "2", 2),
        ({"low": 0, "whole": True}, "2.5", None),
        ({"low": 0}, "nan", None),
        ({"low": 0}, "inf", None),
        ({"low": 0}, "x", None),
    ],
)
def test_a_number_lies_within_its_limits(keys, text, value):
    parse = options.number(inputs.Limits(**keys))
    if value is not None:
        assert parse(text) == value
        return
    with pytest.raises(argparse.ArgumentTypeError, match="must be a"):
        parse(text)


def test_options_reach_the_reader(monkeypatch):
    asked = []
    monkeypatch.setattr(
        options,
        "read_molecule",
        lambda *args, **keys: asked.append((args, keys)) or SimpleNamespace(n_frames=3),
    )
    parser = argparse.ArgumentParser()
    parser.add_argument("file")
    parser.set_defaults(quiet=True)
    options.add_molecule(parser)
    line = "a.pdb --trajectory t.xtc --frame 2 --chains A,B --residues 1-9 --ligands HEM,ZN --selection all"
    options.read_atoms(parser.parse_args(line.split()))
    keys = {"chains": "A,B", "residues": "1-9", "ligands": ["HEM", "ZN"], "selection": "all"}
    assert asked == [(("a.pdb", "t.xtc"), keys | {"altloc": "first", "assembly": False})]
    options.read_atoms(parser.parse_args(["a.pdb"]))
    nothing = dict.fromkeys(("chains", "residues", "selection"))
    assert asked[1] == (("a.pdb", None), nothing | {"altloc": "first", "assembly": False, "ligands": False})
    for words, name in ((["a.pdb"], "a.pdb"), (["a.psf", "--trajectory", "t.dcd"], "t.dcd")):
        with pytest.raises(InputError, match=f"^{name} has the frames 0 to 2: there is no frame 3"):
            options.read_atoms(parser.parse_args([*words, "--frame", "3"]))


@pytest.fixture(scope="module")
def dots(blob, tmp_path_factory):
    path = tmp_path_factory.mktemp("dots") / "dots.csv"
    pd.DataFrame(np.hstack(blob), columns=["x", "y", "z", "nx", "ny", "nz"]).to_csv(path, index=False)
    return path


def ran(*words, d_link=D_LINK):
    assert command.main([*map(str, words), "--d-link", str(d_link)]) == 0


def test_minimal_keeps_the_share_that_is_requested(dots, ready, tmp_path):
    ran("minimal", dots, "--percent", 5, "-o", tmp_path / "m.csv")
    table = pd.read_csv(tmp_path / "m.csv")
    assert list(table) == ["dot", "x", "y", "z", "nx", "ny", "nz", "weight", "spacing", "reach"]
    assert len(table) == 150 and table["weight"].sum() == 3000
    assert np.allclose(table[["x", "y", "z"]], ready.points[table["dot"]], atol=6e-5)
    # 800 Å^2 for 150 dots
    assert table["spacing"].median() == pytest.approx(np.sqrt(800 / 150), rel=0.35)
    ran("minimal", dots, "--n-dots", 40, "--sampler", "uniform", "--seed", 3, "-o", tmp_path / "u.csv")
    ran("minimal", dots, "--n-dots", 40, "--sampler", "uniform", "--seed", 4, "-o", tmp_path / "v.csv")
    some, others = (pd.read_csv(tmp_path / name)["dot"].tolist() for name in ("u.csv", "v.csv"))
    assert len(some) == len(others) == 40 and len(set(some) & set(others)) < 10
    near, spread = (pdist(ready.points[kept]).min() for kept in (some, table["dot"][:40]))
    assert near < 0.5 * spread  # by chance two uniform dots lie together, farthest ones never
    z = 0.9 * sparsurf.compare(ready, table["dot"], test_dots=400)["Z"].iloc[0]
    ran("minimal", dots, "--max-z", z, "-o", tmp_path / "z.csv")
    assert len(pd.read_csv(tmp_path / "z.csv")) > 150


def test_recovered_dots_tell_which_were_kept(dots, tmp_path):
    few = tmp_path / "few.csv"
    pd.read_csv(dots).iloc[::6].to_csv(few, index=False)
    for density, name in ((3, "a.npz"), (6, "b.csv")):
        assert command.main(["recover", str(few), "--density", str(density), "-o", str(tmp_path / name)]) == 0
    sparse, dense = sparsurf.read_surface(tmp_path / "a.npz"), pd.read_csv(tmp_path / "b.csv")
    assert np.isnan(sparse.area).all()  # that of a place between dots is not known
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


def test_descriptors_and_roughness_at_the_dots_that_are_named(dots, blob, tmp_path, capsys):
    ran("descriptors", dots, "--every", 1000, "--r-zernike", 4, "-o", tmp_path / "z.npz")
    with np.load(tmp_path / "z.npz") as found:
        assert found["dot"].tolist() == [0, 1000, 2000]
        assert np.allclose(found["points"], blob[0][[0, 1000, 2000]])
        wanted = sparsurf.descriptors(blob, [0, 1000, 2000], r_zernike=4, d_link=D_LINK)
        assert np.allclose(found["z"], wanted, rtol=1e-6)
    ran("descriptors", dots, "--at", "2999,0", "--down", "-o", tmp_path / "z.csv")
    table = pd.read_csv(tmp_path / "z.csv")
    down = sparsurf.descriptors(blob, [2999, 0], up=False, d_link=D_LINK)
    assert table["dot"].tolist() == [2999, 0]
    assert np.allclose(table.filter(like="z_"), down, rtol=1e-6)
    assert command.main(["descriptors", str(dots), "--at", "3000", "--d-link", "0.8", "-o", "x.csv"]) == 1
    assert "at: there is no dot 3000; the surface has 0 to 2999." in capsys.readouterr().err
    assert descriptors._numbers(" 3, 0") == [3, 0]
    for text in ("1,-2", "1,,2", "1.5"):
        with pytest.raises(argparse.ArgumentTypeError):
            descriptors._numbers(text)
    ran("roughness", dots, "--r-patch", 3, "-o", tmp_path / "r.csv")
    rough = pd.read_csv(tmp_path / "r.csv")["roughness"]
    assert np.allclose(rough, sparsurf.roughness(blob, r_patch=3, d_link=D_LINK), atol=6e-5)


def test_a_closed_mesh_of_a_structure_is_as_fine_as_requested(tmp_path):
    line = "ATOM      1  N   GLY A   1       0.000   0.000   0.000  1.00  0.00           N  \n"
    (tmp_path / "one.pdb").write_text(line + line.replace("1  N ", "2  CA").replace("0.000   0.000   0.0", "1.450   0.000   0.0")
                                      .replace("           N", "           C"))  # fmt: skip
    counts = []
    for density in (5, 20):
        out = tmp_path / "m.ply"
        words = [
            "surface",
            tmp_path / "one.pdb",
            "--mesh",
            "--density",
            density,
            "--selection",
            "all",
            "-o",
            out,
        ]
        assert command.main(list(map(str, words))) == 0
        head = out.read_bytes()[:2000].decode("latin-1")
        counts.append(int(head.split("element face ")[1].split()[0]))
    assert 3 < counts[1] / counts[0] < 5.5  # four times as many


def test_the_columns_of_dots(tmp_path):
    surface = Surface(
        np.array([[1.0, 2, 3]]), np.array([[0.0, 0, 1]]), np.array([0.2]), np.array([1]), np.array([0])
    )
    own = writing.Dots(surface, pd.DataFrame({"own": [7], "word": ["GLY"], "dot": [4]}))
    written = {end: tmp_path / f"a.{end}" for end in ("csv", "csv.gz", "npz", "ply", "dms")}
    for path in (written[end] for end in ("csv", "csv.gz", "npz", "ply")):
        writing.write_dots(path, own)
    assert pd.read_csv(written["csv"]).to_dict("records") == [
        {"dot": 4, "x": 1, "y": 2, "z": 3, "nx": 0, "ny": 0, "nz": 1, "own": 7, "word": "GLY"}
    ]
    assert gzip.decompress(written["csv.gz"].read_bytes()) == written["csv"].read_bytes()
    assert sparsurf.read_surface(written["csv.gz"]).points.tolist() == [[1, 2, 3]]
    with np.load(written["npz"]) as found:
        assert set(found) == {"points", "normals", "area", "kind", "atom", "own", "word", "dot"}
        assert found["kind"] == [1] and found["word"] == ["GLY"]
    text = written["ply"].read_text()
    assert "property int dot\nproperty int own\n" in text and " 4 7\n" in text and "word" not in text
    with pytest.raises(InputError, match=r"cannot be written as '.dms'"):
        writing.write_dots(written["dms"], own)
    molecule = SimpleNamespace(
        residue_name=["GLY"], residue=["1"], name=["CA"], xyz=np.array([[[9.0, 9, 9]], [[1.5, 2, 3]]])
    )
    writing.write_dots(written["dms"], writing.Dots(surface, own.table, None, molecule, 1))
    assert "1.500" in written["dms"].read_text() and "9.000" not in written["dms"].read_text()


def test_dots_that_know_their_molecule_refuse_rules_that_they_were_not_placed_by():
    dots = sparsurf.surface(PEPTIDE, probe_radius=1.5)
    assert sparsurf.mesh(dots).volume == sparsurf.mesh(PEPTIDE, probe_radius=1.5).volume
    asked = [
        lambda: sparsurf.mesh(dots, probe_radius=3.0),
        lambda: sparsurf.mesh(dots, cavities="remove"),
        lambda: sparsurf.components(dots, probe_radius=2.0),
        lambda: sparsurf.minimal(dots, radii="bondi", percent=10),
    ]
    for ask, key in zip(
        asked, ("probe_radius=1.5", "cavities='keep'", "probe_radius=1.5", "radii='dms'"), strict=True
    ):
        with pytest.raises(InputError, match=f"placed with {key}; give their molecule"):
            ask()


def test_dots_that_were_moved_are_no_longer_those_of_the_molecule():
    dots = sparsurf.surface(PEPTIDE)
    moved = replace(dots, points=dots.points + 100)
    assert dots.placed is dots.origin and moved.placed is None and dots.take(slice(9)).placed is None
    assert sparsurf.mesh(moved).vertices.points.min() > 50


def test_noise_floors_are_those_of_the_rules_that_are_given():
    peptide = sparsurf.read_molecule(PEPTIDE, residues="209-214")
    rules = {"density": 4.0, "probe_radius": 1.6, "radii": "bondi", "d_link": 1.4, "seed": 3}
    table = sparsurf.floors(peptide, **rules).set_index("floor")
    dots = sparsurf.surface(peptide, density=4.0, probe_radius=1.6, radii="bondi", d_link=1.4)
    prepared = sparsurf.prepare(dots, d_link=1.4, seed=3)
    settings = surface_settings(1.6, 4.0, "bondi", "keep")
    generator = surface_generator(peptide, 0, radii(peptide, "bondi"), settings, 1.4, "own")
    own = floors_table(measure_floors(prepared, 200, *generator)).set_index("floor")
    assert len(own) == 4 and own.index[-1].startswith("atoms moved")
    pd.testing.assert_frame_equal(table, own)
    other = sparsurf.floors(peptide, **rules | {"seed": 4}).set_index("floor")
    assert (other["Z"] != table["Z"]).all()


def test_the_density_of_a_recovered_mesh_is_that_of_the_dots_it_is_cut_from(blob, monkeypatch):
    given = []
    monkeypatch.setattr(
        "sparsurf.recovery.mesh.recovered_mesh",
        lambda points, normals, step, **options: given.append((len(points), step, options["density"])),
    )
    sparsurf.mesh(Surface(*blob).take(slice(500)), density=3.0)
    assert given == [(500, grid_step_for_density(3.0), 3.0)]


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda dots: sparsurf.minimal(dots, percent=10, n_dots=5), "only one of percent, n_dots, error and max_z"),
        (lambda dots: sparsurf.components(dots, dots), "give the molecule first"),
        (lambda dots: sparsurf.fields(sparsurf.surface(PEPTIDE), sparsurf.read_molecule(PEPTIDE)), "molecule first"),
        (lambda dots: sparsurf.fields(dots, names=[]), "names: there are no fields"),
        (lambda dots: sparsurf.fields(dots, names=["potential"], charges=3), "charges is int"),
        (lambda dots: sparsurf.residues(replace(dots, atom=np.full(len(dots), -1))), "which atom"),
        (
            lambda dots: sparsurf.residues(dots, roughness_values=np.ma.masked_less(np.arange(len(dots)), 5)),
            "roughness_values: the arrays have masked values",
        ),
        (lambda dots: sparsurf.write(3, "x.csv"), "not the type int"),
        (lambda dots: Surface(dots.points, dots.normals, fields={"score": np.ones(5)}), "field score has the shape (5,)"),
        (lambda dots: dots.to_frame(3), "must come from read_molecule"),
    ],
)  # fmt: skip
def test_what_cannot_be_done_is_one_sentence(tmp_path, monkeypatch, call, words):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError, match=re.escape(words)):
        call(sparsurf.surface(sparsurf.read_molecule(PEPTIDE, residues="209-216")))


def test_the_steps_of_recover_and_the_frame_of_write_count(tmp_path, monkeypatch):
    given = []
    monkeypatch.setattr(
        "sparsurf.api.minimal.recovered_dots",
        lambda points, normals, *rest: given.extend(rest) or (points, normals),
    )
    sparsurf.recover((np.eye(3), np.eye(3)), density=3, reach=1.7, steps=2)
    assert given[:3] == [3, 1.7, 2]
    molecule = sparsurf.read_molecule(ROOT / "data/tdp43/topology.pdb", residues="209-210")
    two = replace(molecule, xyz=np.concatenate([molecule.xyz, molecule.xyz + 1]))
    sparsurf.write(two, tmp_path / "second.pdb", frame=1)
    written = sparsurf.read_molecule(tmp_path / "second.pdb")
    assert np.allclose(written.xyz[0], molecule.xyz[0] + 1, atol=1e-3)


@pytest.fixture(scope="module")
def two_frames():
    """A peptide in two shapes."""
    data = ROOT / "data" / "tdp43"
    moving = sparsurf.read_molecule(
        data / "topology.pdb", data / "trajectory.xtc", residues="209-214", stride=700
    )
    return replace(moving, xyz=moving.xyz[:2])


def test_noise_floors_of_dots_are_those_of_the_frame_they_were_placed_on(two_frames):
    first, second = (sparsurf.floors(two_frames, frame=frame, seed=3) for frame in (0, 1))
    dots = sparsurf.surface(two_frames, frame=1)
    pd.testing.assert_frame_equal(sparsurf.floors(dots, seed=3), second)
    assert (first["Z"] != second["Z"]).all()


def test_components_are_those_of_the_frame(two_frames):
    alone = [replace(two_frames, xyz=two_frames.xyz[[frame]]) for frame in (0, 1)]
    own = [sparsurf.components(molecule)[1] for molecule in alone]
    for frame in (0, 1):
        pd.testing.assert_frame_equal(sparsurf.components(two_frames, frame=frame)[1], own[frame])
    assert own[0]["volume"][0] != own[1]["volume"][0]
