"""The binding propensity of 1a1u, chains A and C, as the authors' package zepyros gives it for every tenth dot."""

import numpy as np
import pandas as pd
import pytest
from scipy.spatial import cKDTree

from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.patches.descriptors import describe_patches
from sparsurf.patches.index import build_index
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.radii import radii
from sparsurf.surfaces.read_surface import read_surface
from sparsurf_study.pairs.nearest import nearest
from sparsurf_study.pairs.neighbourhoods import smooth
from sparsurf_study.pairs.partners import interface
from sparsurf_study.pairs.ranking import auc


@pytest.fixture(scope="module")
def published(shared):
    return [pd.read_csv(shared / "data" / "1a1u" / f"1a1u_{chain}_bp.csv") for chain in "AC"]


@pytest.fixture(scope="module")
def places(published):
    return [table[["x", "y", "z"]].to_numpy() for table in published]


@pytest.fixture(scope="module")
def surfaces(shared, tmp_path_factory):
    """A as DMS wrote it; of C only the atoms are there: its dots as DMS lays them, rounded as DMS writes them."""
    folder = shared / "data" / "1a1u"
    molecule = read_molecule(folder / "1a1u_C.pdb")
    made = molecular_surface(molecule.xyz[0], radii(molecule, "dms"), reentrant="dms")
    path = tmp_path_factory.mktemp("1a1u") / "C.dms"
    write_dms(path, made, molecule.residue_name, molecule.residue, molecule.name, molecule.xyz[0])
    return read_surface(folder / "1a1u_A.dms.gz"), read_surface(path)


@pytest.fixture(scope="module")
def ours(surfaces, places):
    """Nearest patches of every tenth dot of both, A up and C down, with the published options."""
    z = [
        describe_patches(build_index(surface.points, surface.normals), place, up=up)[0]
        for surface, place, up in zip(surfaces, places, (True, False), strict=True)
    ]
    return nearest(*z)


def test_the_dots_are_those_of_the_tutorial(surfaces, places):
    assert np.array_equal(surfaces[0].points[::10], places[0])
    assert cKDTree(surfaces[1].points).query(places[1])[0].max() < 1e-9


@pytest.mark.parametrize("side", [0, 1])
def test_the_propensity_is_the_published_one(ours, published, side):
    apart = np.abs(ours[side].distance[:, 0] - published[side]["bp"].to_numpy())
    # graded: a normal rounded the other way moves a dot to the next pixel in a few patches
    assert np.percentile(apart, 90) < 1e-5
    assert apart.max() < 0.01
    assert np.median(apart) < 1e-6


@pytest.mark.parametrize(("side", "raw", "smoothed"), [(0, 0.628, 0.693), (1, 0.626, 0.687)])
def test_the_interface_and_its_areas_are_the_published_ones(ours, published, places, side, raw, smoothed):
    truth = published[side]["bs"].to_numpy() == 1
    assert np.array_equal(interface(places[side], places[1 - side]), truth)
    values = ours[side].distance[:, 0]
    assert auc(-values, truth) == pytest.approx(raw, abs=0.0006)
    mean = smooth(places[side], np.arange(len(values)), values)
    assert auc(-mean, truth) == pytest.approx(smoothed, abs=0.0006)
