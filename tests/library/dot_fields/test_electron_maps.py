"""Maps at dots: linear functions, which interpolation between grid points keeps exactly, from files that are written by hand."""

import gzip
import struct
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from sparsurf.cli import command
from sparsurf.errors import InputError

PEPTIDE = ROOT / "data" / "tdp43" / "topology.pdb"
SLOPE, STEP = np.array([0.02, -0.03, 0.05]), 0.9
TILTED = np.array([[0.9, 0, 0], [0.2, 0.85, 0], [-0.1, 0.3, 0.8]])  # three steps of a grid, Å


def linear(points):
    return 1.5 + points @ SLOPE


@pytest.fixture(scope="module")
def dots():
    return sparsurf.surface(PEPTIDE)


def grid_around(points, steps):
    """Origin, shape and positions (I, J, K, 3) of a grid around points."""
    place = points @ np.linalg.inv(steps)
    origin = (np.floor(place.min(axis=0)) - 2) @ steps
    shape = np.ceil(np.ptp(place, axis=0)).astype(int) + 5
    index = np.stack(np.meshgrid(*map(np.arange, shape), indexing="ij"), axis=-1)
    return origin, shape, origin + index @ steps


def dx_of(origin, shape, steps, values, items=None):
    """Text of OpenDX, as APBS writes it."""
    lines = ["# data", f"object 1 class gridpositions counts {' '.join(map(str, shape))}"]
    lines += [
        f"{word} {x:.9f} {y:.9f} {z:.9f}"
        for word, (x, y, z) in [("origin", origin), *(("delta", s) for s in steps)]
    ]
    lines += [f"object 2 class gridconnections counts {' '.join(map(str, shape))}"]
    lines += [f"object 3 class array type double rank 0 items {items or values.size} data follows"]
    flat = [f"{value:.12e}" for value in values.ravel()]
    lines += [" ".join(flat[k : k + 3]) for k in range(0, len(flat), 3)]
    return "\n".join([*lines, 'attribute "dep" string "positions"', 'object "map" class field', ""])


def mrc_of(values, cell, start=(0, 0, 0), origin=(0, 0, 0), axes=(1, 2, 3)):
    """Bytes of an MRC file of values along x, y and z, whose columns, rows and sections lie along `axes`."""
    order = [axis - 1 for axis in axes]
    stored = values.transpose(order)
    words = np.zeros(256, "<i4")
    words[0:3], words[3], words[4:7], words[7:10] = stored.shape, 2, [start[k] for k in order], values.shape
    words[10:16] = np.array(cell, "<f4").view("<i4")
    words[16:19], words[22] = axes, 1
    words[49:52] = np.array(origin, "<f4").view("<i4")
    words[52] = struct.unpack("<i", b"MAP ")[0]
    words[53] = 0x00004144
    return words.tobytes() + stored.transpose(2, 1, 0).astype("<f4").tobytes()


def written(path, points, kind):
    """A map of the linear function around points, in one of several forms."""
    if kind in ("dx", "tilted", "packed"):
        origin, shape, places = grid_around(points, TILTED if kind == "tilted" else STEP * np.eye(3))
        text = dx_of(origin, shape, TILTED if kind == "tilted" else STEP * np.eye(3), linear(places))
        path = path.with_suffix(".dx.gz" if kind == "packed" else ".dx")
        path.write_bytes(gzip.compress(text.encode()) if kind == "packed" else text.encode())
        return path
    origin, shape, places = grid_around(points, STEP * np.eye(3))
    cell, first = (*STEP * shape, 90, 90, 90), np.round(origin / STEP).astype(int)
    if kind == "start":
        content = mrc_of(linear(places), cell, start=first)
    elif kind == "axes":
        content = mrc_of(linear(places), cell, start=first, axes=(3, 1, 2))
    else:  # gemmi reads such a map as one that begins at 0
        content = mrc_of(linear(places), cell, origin=origin, axes=(2, 1, 3))
    path = path.with_suffix({"start": ".ccp4", "axes": ".map", "origin": ".mrc"}[kind])
    path.write_bytes(content)
    return path


@pytest.mark.parametrize("kind", ["dx", "tilted", "packed", "start", "axes", "origin"])
def test_a_linear_function_is_the_same_between_the_grid_points(dots, tmp_path, kind):
    path = written(tmp_path / "linear", dots.points, kind)
    values = sparsurf.fields(dots, path)
    assert list(values) == [path.name.replace(".", "_")]
    tolerance = 1e-6 if path.suffix in (".dx", ".gz") else 1e-6 * np.abs(linear(dots.points)).max()
    np.testing.assert_allclose(values.iloc[:, 0], linear(dots.points), atol=tolerance)


def test_points_meshes_spheres_and_commands_have_maps(dots, tmp_path):
    path = written(tmp_path / "linear", dots.points, "dx")
    for result in (
        sparsurf.points(PEPTIDE, 64, fields=["hydropathy", path, "roughness"]).surface,
        sparsurf.mesh(PEPTIDE, 300, fields=["hydropathy", path, "roughness"]).vertices,
    ):
        assert list(result.fields) == ["hydropathy", "linear_dx", "roughness"]
        np.testing.assert_allclose(result.fields["linear_dx"], linear(result.points), atol=1e-6)
    sphere = sparsurf.points((dots.points.mean(axis=0)[None], [2.0]), 50, fields=path)
    np.testing.assert_allclose(sphere.fields["linear_dx"], linear(sphere.points), atol=1e-6)
    words = ["surface", str(PEPTIDE), "--fields", f"{path},hydropathy", "-o", str(tmp_path / "d.csv")]
    assert command.main(words) == 0
    table = pd.read_csv(tmp_path / "d.csv")
    np.testing.assert_allclose(table["linear_dx"], linear(table[["x", "y", "z"]].to_numpy()), atol=1e-5)


def test_a_map_of_a_part_has_no_values_beyond_and_says_how_many_dots_lie_there(dots, tmp_path, caplog):
    low, high = dots.points.min(axis=0), dots.points.max(axis=0)
    half = np.array([low, [(low[0] + high[0]) / 2, *high[1:]]])
    path = written(tmp_path / "half", half, "origin")
    origin, shape, _ = grid_around(half, STEP * np.eye(3))
    inside = ((dots.points >= origin) & (dots.points <= origin + STEP * (shape - 1))).all(axis=1)
    values = sparsurf.fields(dots, path)["half_mrc"]
    assert 0.3 < inside.mean() < 0.7 and np.array_equal(np.isfinite(values), inside)
    assert f"half.mrc: {100 - 100 * inside.mean():.3g} % of the dots lie outside of the map" in caplog.text
    with pytest.raises(InputError, match=r"map .*half\.mrc"):
        molecule = sparsurf.read_molecule(PEPTIDE)
        sparsurf.fields(sparsurf.surface(replace(molecule, xyz=molecule.xyz + 500)), path)


BODY = dx_of(np.zeros(3), (2, 2, 2), np.eye(3), np.arange(8.0))
CUBE = mrc_of(np.zeros((2, 2, 2)), (2, 2, 2, 90, 90, 90))


@pytest.mark.parametrize(
    ("name", "content", "words"),
    [
        ("none.dx", None, "none.dx does"),
        ("a.dx", "a picture", "text of OpenDX"),
        ("a.dx", BODY.replace("delta 0.0", "epsilon 0.0"), "text of OpenDX"),
        ("a.dx", BODY[: BODY.index("7.0000")], "holds 7 values of 8"),
        ("a.dx", BODY.replace("3.000000000000e+00", "three"), "word among"),
        ("a.dx", BODY.replace("delta 1.0", "delta 0.0"), "three axes"),
        ("a.mrc", CUBE[:-8], "CCP4 or MRC"),
        ("a.map", b"GRID_PARAMETER_FILE a.gpf\n" + 2000 * b"0.1\n", "CCP4 or MRC"),
        ("a.ccp4", CUBE[:28] + bytes(12) + CUBE[40:], "states no cell"),
        ("a.ccp4", CUBE[:40] + bytes(24) + CUBE[64:], "states no cell"),
    ],
)  # fmt: skip
def test_what_is_no_map_is_a_sentence(dots, tmp_path, name, content, words):
    if content is not None:
        (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    with pytest.raises(InputError, match=words):
        sparsurf.fields(dots, str(tmp_path / name))


def test_maps_of_several_structures_or_of_one_name_are_refused(dots, tmp_path):
    path = written(tmp_path / "linear", dots.points[:9], "dx")
    for call in (sparsurf.points_of, sparsurf.frames):
        with pytest.raises(InputError, match="map, which belongs"):
            call(str(ROOT / "data" / "tdp43") if call is sparsurf.points_of else PEPTIDE, fields=str(path))
    with pytest.raises(InputError, match="called linear_dx"):
        sparsurf.fields(dots, [path, path])
