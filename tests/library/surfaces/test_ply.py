"""PLY files: what they hold, whether their triangles close, whether PyMOL opens them."""

import struct

import numpy as np
import pytest

from sparsurf.errors import InputError
from sparsurf.surfaces.formats.colours import KIND_COLOURS, ROUGHNESS_LIMITS, VERTEX_GREY, scale_of
from sparsurf.surfaces.formats.ply import AXES, write_ply
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.surfaces.surface import Surface


@pytest.fixture(scope="module")
def small():
    return molecular_surface([[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2]], [1.9, 1.5, 1.2])


def read_ply(path):
    """Vertices as a dict of columns, and triangles, None for a point cloud, by the header alone."""
    lines = path.read_text("ascii").splitlines()
    end = lines.index("end_header")
    assert lines[:2] == ["ply", "format ascii 1.0"]
    n, *m = (int(line.split()[2]) for line in lines if line.startswith("element"))
    keys = [line.split()[2] for line in lines[:end] if line.startswith("property") and "list" not in line]
    vertices = np.array([line.split() for line in lines[end + 1 : end + 1 + n]], float)
    faces = np.array([line.split() for line in lines[end + 1 + n :]], int).reshape(-1, 4)
    assert vertices.shape == (n, len(keys)) and [len(faces)] == (m or [0]) and (faces[:, 0] == 3).all()
    return dict(zip(keys, vertices.T, strict=True)), faces[:, 1:] if m else None


# ---- the file


def test_what_is_written_is_read_and_whole_numbers_in_full(tmp_path, small):
    write_ply(
        tmp_path / "a.ply", small, scale_of("weight", range(len(small))), {"spacing": np.ones(len(small))}
    )
    found = read_surface(tmp_path / "a.ply")
    np.testing.assert_allclose(found.points, small.points, rtol=0, atol=5.1e-5)
    np.testing.assert_allclose(found.normals, small.normals, rtol=0, atol=2e-4)  # of unit length again
    assert (found.kind == -1).all()
    surface, number = Surface(np.eye(3), np.eye(3)), np.array([0, 999_999, 12_345_678])
    columns = {"dot": number, "weight": number / 2, "near": number > 0}
    write_ply(tmp_path / "a.ply", surface, columns={"count": number} | columns)
    text = (tmp_path / "a.ply").read_text()
    assert "property int count\nproperty int dot\nproperty float weight\nproperty float near\n" in text
    vertices, _ = read_ply(tmp_path / "a.ply")
    assert vertices["dot"].tolist() == vertices["count"].tolist() == [0, 999_999, 12_345_678]
    assert vertices["weight"].tolist() == [0, 500_000, 6_172_840] and vertices["near"].tolist() == [0, 1, 1]
    assert read_surface(tmp_path / "a.ply").points.tolist() == np.eye(3).tolist()


# Two vertices as other programs write them: their properties in another order, and others between them
POINTS, NORMALS = [[1.5, -2.0, 3.25], [4.0, 5.0, 6.5]], [[0.0, 0.0, 1.0], [0.6, 0.0, -0.8]]
VERTEX = [("nx", "float", "f4"), ("z", "double", "f8"), ("ny", "float32", "f4"), ("red", "uchar", "u1")]
VERTEX += [("x", "double", "f8"), ("charge", "int16", "i2"), ("nz", "float", "f4"), ("y", "float64", "f8")]
HEAD = "ply\nformat {} 1.0\ncomment made by hand\nelement vertex 2\n"
HEAD += "".join(f"property {word} {name}\n" for name, word, _ in VERTEX)
HEAD += "element face 1\nproperty list uchar int vertex_indices\nend_header\n"


def made(order):
    """The file in one order of bytes, or as text ("")."""
    values = dict(zip(("x", "y", "z"), np.array(POINTS).T, strict=True))
    values |= dict(zip(("nx", "ny", "nz"), np.array(NORMALS).T, strict=True)) | {
        "red": [9, 10],
        "charge": [-1, 2],
    }
    if not order:
        rows = zip(*(values[name] for name, _, _ in VERTEX), strict=True)
        return (
            HEAD.format("ascii") + "\n".join(" ".join(map(str, row)) for row in rows) + "\n3 0 1 0\n"
        ).encode()
    table = np.zeros(2, [(name, order + kind) for name, _, kind in VERTEX])
    for name, column in values.items():
        table[name] = column
    word = {"<": "binary_little_endian", ">": "binary_big_endian"}[order]
    return HEAD.format(word).encode() + table.tobytes() + b"\x03" + bytes(12)


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_vertices_of_other_programs_are_read(tmp_path, order):
    for content in (made(order), made(order).replace(b"\n", b"\r\n", HEAD.count("\n"))):
        (tmp_path / "a.ply").write_bytes(content)
        found = read_surface(tmp_path / "a.ply")
        np.testing.assert_array_equal(found.points, POINTS)
        np.testing.assert_allclose(found.normals, NORMALS, rtol=0, atol=1e-7)
        assert {name: values.tolist() for name, values in found.fields.items()} == {"charge": [-1, 2]}


WORDS = {
    "char int8": "b", "uchar uint8": "B", "short int16": "h", "ushort uint16": "H", "int int32": "i",
    "uint uint32": "I", "float float32": "f", "double float64": "d",
}  # fmt: skip


def test_numbers_of_every_type_are_read(tmp_path):
    for word, code in ((word, code) for words, code in WORDS.items() for word in words.split()):
        bits = 8 * struct.calcsize(code)
        value = {"f": -1.5, "d": -1e300}.get(code, -(2 ** (bits - 1)) if code.islower() else 2**bits - 1)
        head = HEAD.split("property")[0].format("binary_big_endian").replace("vertex 2", "vertex 1")
        head += (
            f"property {word} number\n"
            + "".join(f"property float {axis}\n" for axis in AXES)
            + "end_header\n"
        )
        (tmp_path / "a.ply").write_bytes(head.encode() + struct.pack(f">{code}6f", value, 1, 2, 3, 0, 0, 1))
        assert read_surface(tmp_path / "a.ply").fields["number"].tolist() == [value], word


TEXT = made("").decode()


BEFORE = "element face 2\nproperty list uchar int vertex_indices\nelement camera 1\nproperty float a\nproperty float b\n"


@pytest.mark.parametrize("order", ["", "<", ">"])
def test_elements_before_the_vertices_are_skipped(tmp_path, order):
    head, end, body = made(order).partition(b"end_header\n")
    head = head.replace(b"element vertex", BEFORE.encode() + b"element vertex")
    rows = (
        struct.pack(f"{order}B3iB2i2f", 3, 0, 1, 1, 2, 0, 1, 0.5, 1) if order else b"3 0 1 1\n2 0 1\n0.5 1\n"
    )
    (tmp_path / "a.ply").write_bytes(head + end + rows + body)
    assert read_surface(tmp_path / "a.ply").points.tolist() == POINTS
    (tmp_path / "a.ply").write_bytes(head + end + rows[:-1] + b"\n" * (not order))
    with pytest.raises(InputError, match="2 vertices cannot"):
        read_surface(tmp_path / "a.ply")


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (TEXT.replace(" nx\n", " u\n"), "every vertex"),
        (TEXT.replace(" charge\n", " x\n"), "every vertex"),
        (TEXT.replace("format ascii", "format utf8"), "PLY file"),
        (TEXT.replace("element vertex 2", "element vertex two"), "PLY file"),
        (TEXT.replace("element vertex 2", "element vertex " + 5000 * "9"), "PLY file"),
        (TEXT.replace("property uchar red", "property list uchar int red"), "vertex properties"),
        (TEXT.replace("element vertex 2", "element vertex 3"), "3 vertices cannot"),
        (TEXT.replace("element vertex 2", "element vertex 999999999999"), "cut short"),
        (TEXT.replace("element vertex 2", "element vertex 0"), "holds no dots"),
        (TEXT.replace("3.25", "x.25"), "cut short"),
        (TEXT.replace("3.25", "nan"), "NaN"),
        (TEXT.split("end_header")[0], "cut short"),
        (made("<")[:-20], "2 vertices cannot"),
        (made(">").split(b"end_header")[0] + b"end_header", "cut short"),
        (b"ply", "PLY file"),
    ],
)  # fmt: skip
def test_a_ply_file_that_cannot_be_read_is_a_sentence(tmp_path, content, words):
    path = tmp_path / "a.ply"
    path.write_bytes(content.encode() if isinstance(content, str) else content)
    with pytest.raises(InputError, match=words) as caught:
        read_surface(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)


def test_the_colours_are_those_of_matplotlib():
    from matplotlib import colormaps

    values = np.linspace(-3, 7, 2049)
    assert np.array_equal(
        scale_of("", values).colours, colormaps["viridis"]((values + 3) / 10, bytes=True)[:, :3]
    )
    unknown = scale_of("", [np.inf, *values, np.nan, -np.inf]).colours
    assert (
        np.array_equal(unknown[1:-2], scale_of("", values).colours)
        and (unknown[[0, -2, -1]] == VERTEX_GREY).all()
    )


def test_ply_holds_dots_values_and_colours(tmp_path, small):
    values = np.linspace(0.2, 0.8, len(small))
    values[5] = np.nan
    write_ply(tmp_path / "a.ply", small, scale_of("height", values), {"weight": small.area})
    vertices, faces = read_ply(tmp_path / "a.ply")
    assert list(vertices) == ["x", "y", "z", "nx", "ny", "nz", "red", "green", "blue", "height", "weight"]
    np.testing.assert_allclose(np.stack([vertices[k] for k in "xyz"], 1), small.points, rtol=0, atol=5.1e-5)
    normals = np.stack([vertices[k] for k in ("nx", "ny", "nz")], 1)
    np.testing.assert_allclose(normals, small.normals, rtol=0, atol=5.1e-5)
    np.testing.assert_allclose(vertices["height"], values, rtol=1e-5)
    np.testing.assert_allclose(vertices["weight"], small.area, rtol=1e-5)
    assert faces is None and "element face" not in (tmp_path / "a.ply").read_text()  # a point cloud
    # The ends of viridis, its middle, and grey.
    colours = np.column_stack([vertices[channel] for channel in ("red", "green", "blue")])
    assert colours[[0, -1, 5]].tolist() == [[68, 1, 84], [253, 231, 36], [160, 160, 160]]
    assert np.abs(colours[len(small) // 2] - [33, 145, 140]).max() <= 3


def test_roughness_has_the_same_colours_on_every_surface(tmp_path):
    """Whatever else a surface has: dark at the lower limit and below, bright at the upper one and above."""
    middle = sum(ROUGHNESS_LIMITS) / 2
    for others in ([0.3, 0.4], [0.0, 1.0]):
        values = np.array([*ROUGHNESS_LIMITS, middle, *others])
        surface = Surface(np.eye(5, 3) + np.arange(5)[:, None], np.eye(3)[[0, 1, 2, 0, 1]])
        write_ply(tmp_path / "a.ply", surface, scale_of("roughness", values))
        vertices, _ = read_ply(tmp_path / "a.ply")
        colours = np.column_stack([vertices[channel] for channel in ("red", "green", "blue")])
        assert colours[:3].tolist() == [[68, 1, 84], [253, 231, 36], [32, 144, 140]]
    assert colours[3:].tolist() == colours[:2].tolist()


def test_without_values_the_colours_tell_the_kinds_of_dots(tmp_path, small):
    kind = small.kind.copy()
    kind[7] = -1
    write_ply(tmp_path / "a.ply", Surface(small.points, small.normals, kind=kind))
    vertices, _ = read_ply(tmp_path / "a.ply")
    assert len(vertices) == 9
    colours = np.column_stack([vertices[channel] for channel in ("red", "green", "blue")])
    for number, colour in enumerate([(86, 180, 233), (230, 159, 0), (0, 158, 115)]):
        assert (colours[kind == number] == colour).all()
    assert colours[7].tolist() == VERTEX_GREY.tolist() == KIND_COLOURS[-1].tolist()


def test_ply_of_a_few_dots_and_of_constant_values(tmp_path):
    surface = Surface(np.eye(3), np.eye(3))
    write_ply(tmp_path / "a.ply", surface, scale_of("height", np.ones(3)))
    vertices, faces = read_ply(tmp_path / "a.ply")
    assert len(vertices["x"]) == 3 and faces is None
    assert [vertices[channel][0] for channel in ("red", "green", "blue")] == [
        32,
        144,
        140,
    ]  # the middle of viridis
    with pytest.raises(InputError, match="2 values of roughness for 3 dots"):
        write_ply(tmp_path / "a.ply", surface, scale_of("roughness", np.ones(2)))


def test_triangles_are_written_where_they_are_known(tmp_path, small):
    triangles = np.array([[0, 1, 2], [2, 1, 3]])
    write_ply(tmp_path / "a.ply", small, faces=triangles)
    assert np.array_equal(read_ply(tmp_path / "a.ply")[1], triangles)
    numbers = np.arange(len(small)) + 12_345_678
    write_ply(tmp_path / "a.ply", small, columns={"atom": numbers}, faces=triangles, coloured=False)
    vertices, faces = read_ply(tmp_path / "a.ply")
    assert [*vertices] == [*AXES, "atom"] and np.array_equal(faces, triangles)
    assert np.array_equal(vertices["atom"], numbers)
    assert (tmp_path / "a.ply").read_text().count("property float ") == 7


# ---- the triangles
