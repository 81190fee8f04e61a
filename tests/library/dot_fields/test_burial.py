"""Depth below the surface of all groups, and below that of a larger probe, against formulas, areas and trees of centres."""

from dataclasses import replace

import numpy as np
import pytest

import sparsurf
from peptides import peptide, write
from sparsurf.dot_fields.burial import LARGE_PROBE, enclosure
from sparsurf.errors import InputError
from sparsurf.surfaces.radii import radii as radii_of

BURIED = 1e-6  # Å


@pytest.fixture(scope="module")
def path(tmp_path_factory):
    chains = [peptide(("ALA",) * 5, chain=c, origin=(0, 0, 5 * k)) for k, c in enumerate("AB")]
    return write(tmp_path_factory.mktemp("burial") / "two.pdb", "".join(chains) + "END\n")


def test_a_dot_is_buried_where_a_ball_of_the_partner_covers_its_probe(path):
    """The depth is at most that of the nearest dot of the joint surface, and 0 exactly where the probe still fits."""
    molecule = sparsurf.read_molecule(path)
    dots = sparsurf.surface(path, groups="B+A", cavities="remove")
    assert set(dots.molecule.chain.tolist()) == {"B"}
    burial = sparsurf.fields(dots, "burial")["burial"].to_numpy()
    partner, centres = molecule.chain == "A", dots.points + 1.4 * dots.normals
    reach = radii_of(molecule)[partner] + 1.4
    covered = (np.linalg.norm(centres[:, None] - molecule.xyz[0, partner], axis=2) < reach).any(axis=1)
    assert ((burial > BURIED) == covered).mean() > 0.9999 and 0.02 < covered.mean() < 0.6
    assert (burial[~covered] == 0).all()
    joint = sparsurf.surface(molecule, density=20).points
    deep = np.flatnonzero(burial > 0.3)[::7]
    nearest = np.linalg.norm(dots.points[deep, None] - joint, axis=2).min(axis=1)
    assert (nearest >= burial[deep] - 1e-6).all() and (nearest - burial[deep]).max() < 0.2


def test_buried_contact_dots_sum_to_the_exact_buried_area(path):
    areas = sparsurf.areas(path, groups="A+B")
    dots = sparsurf.surface(path, groups="A+B", density=20)
    buried = sparsurf.fields(dots, "burial")["burial"].to_numpy() > BURIED
    radius, contact = radii_of(dots.molecule)[dots.atom], dots.kind == 0
    of_dots = (dots.area * ((radius + 1.4) / radius) ** 2)[contact & buried].sum()
    assert of_dots == pytest.approx(areas.groups["buried"][0], rel=0.02)
    own = areas.buried[: dots.molecule.n_atoms]
    assert (own[dots.atom[contact & buried]] > 0).all()


def test_points_of_the_first_group_have_the_field(path):
    few = sparsurf.points(path, 200, groups=["A", "B"], fields=["burial", "enclosure"])
    assert set(few.to_frame()["chain"]) == {"A"}
    dense = sparsurf.surface(path, groups="A+B", cavities="remove", density=20)
    depth = sparsurf.fields(dense, ["burial", "enclosure"])
    near = np.linalg.norm(few.points[:, None].astype(float) - dense.points, axis=2).argmin(axis=1)
    for name in depth:
        assert few.fields[name] == pytest.approx(depth[name].to_numpy()[near], abs=0.3)
        assert few.fields[name].max() > 0.4


def test_enclosure_between_two_balls_is_that_of_a_formula():
    """At the waist of two balls of 1.7 Å, 4 Å apart, both probes touch both balls in the plane between them."""
    dots = sparsurf.surface(([[0, 0, 0], [4, 0, 0]], [1.7, 1.7]), density=60)
    height = {probe: np.sqrt((1.7 + probe) ** 2 - 4) - probe for probe in (1.4, LARGE_PROBE)}
    found = enclosure(dots)
    assert found.max() == pytest.approx(height[LARGE_PROBE] - height[1.4], abs=3e-3)
    outer = (dots.points[:, 0] < -0.5) | (dots.points[:, 0] > 4.5)
    assert (found[outer] < BURIED).all()


def test_what_lacks_groups_or_atoms_is_refused(path):
    dots = sparsurf.surface(path)
    with pytest.raises(InputError, match="burial needs groups"):
        sparsurf.fields(dots, "burial")
    with pytest.raises(InputError, match="follows from the atoms"):
        enclosure(replace(dots, origin=None))
    with pytest.raises(InputError, match="accessible surface"):
        sparsurf.surface(path, groups="A+B", boundary="accessible")


def test_the_label_of_a_complex(shared):
    """Of 1AY7: the exact buried area is 635.1, that of labelled contact dots lies within .7 %."""
    path = shared / "data/complexes/1AY7/1AY7_target.pdb"
    dots = sparsurf.surface(path, groups="A+B", density=5, cavities="remove")
    buried = sparsurf.fields(dots, "burial")["burial"].to_numpy() > BURIED
    radius = radii_of(dots.molecule)[dots.atom]
    of_dots = (dots.area * ((radius + 1.4) / radius) ** 2)[(dots.kind == 0) & buried].sum()
    exact = sparsurf.areas(path, groups="A+B").groups["buried"][0]
    assert exact == pytest.approx(635.1, abs=0.1) and of_dots == pytest.approx(exact, rel=0.007)
