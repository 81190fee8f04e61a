"""Compact files: 12 bytes a dot, and how little is lost."""

import zlib

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from sparsurf import InputError
from sparsurf.surfaces.formats.compact import HEADER_BYTES, MAGIC, STEP, read_compact, write_compact
from sparsurf.surfaces.surface import Surface

NUMBERS = st.floats(-1, 1, allow_subnormal=False)


@settings(deadline=None, max_examples=60)
@given(arrays(float, (9, 6), elements=NUMBERS), st.floats(1, 1500))
def test_places_and_normals_come_back_within_a_step(tmp_path_factory, values, width):
    path = tmp_path_factory.mktemp("compact") / "dots.minimal"
    values[:, 0] += 3 * np.arange(9)  # no two dots nearer than a quarter of an Å
    length = np.linalg.norm(values[:, 3:], axis=1, keepdims=True)
    normals = np.where(length > 1e-3, values[:, 3:] / np.maximum(length, 1e-3), [0.0, 0.0, -1.0])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    given = Surface(values[:, :3] * width / 4 + 17.3, normals)
    assume(np.ptp(given.points, axis=0).max() / STEP < 2**21 - 1)
    write_compact(path, given)
    again = read_compact(path.read_bytes(), path)
    assert path.stat().st_size == HEADER_BYTES + 24 + 12 * 9
    assert np.abs(again.points - given.points).max() <= STEP / 2 + 1e-9
    # a step of 1/32767 on the square turns a normal by at most about twice that
    assert np.linalg.norm(again.normals - given.normals, axis=1).max() < 1e-4


def test_the_six_axes_are_kept_exactly(tmp_path):
    axes = np.vstack([np.eye(3), -np.eye(3)])
    write_compact(tmp_path / "a.minimal", Surface(np.cumsum(np.ones((6, 3)), axis=0), axes))
    assert np.array_equal(read_compact((tmp_path / "a.minimal").read_bytes(), "a").normals, axes)


def test_what_does_not_fit_is_refused(tmp_path):
    with pytest.raises(InputError, match="npz"):
        write_compact(tmp_path / "a.minimal", Surface([[0, 0, 0], [0, 0, 2**21 * STEP]], np.eye(3)[:2]))
    write_compact(tmp_path / "a.minimal", Surface(np.eye(3), np.eye(3)))
    content = (tmp_path / "a.minimal").read_bytes()
    damaged = content[:-1] + bytes([content[-1] ^ 1])
    for part in (content[:-5], content[:-12], content[:HEADER_BYTES], content[:20], damaged):
        with pytest.raises(InputError, match=r"a\.minimal .* copy it again"):
            read_compact(part, "a.minimal")


@pytest.mark.parametrize(
    ("length", "words"),
    [(0, "copy it again"), (12, "copy it again"), (24, "holds no dots"), (25, "copy it again")],
)
def test_what_holds_no_whole_dot_is_refused_though_its_checksum_is_right(length, words):
    rest = bytes(length)
    with pytest.raises(InputError, match=words):
        read_compact(MAGIC + zlib.crc32(rest).to_bytes(4, "little") + rest, "a.minimal")
