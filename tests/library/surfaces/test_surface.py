"""Surfaces as objects and files."""

import gzip
import os
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from conftest import ball, make_blob
from peptides import peptide, write
from sparsurf import registry
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces import plausibility
from sparsurf.surfaces.formats.csv import write_csv
from sparsurf.surfaces.formats.dms import write_dms
from sparsurf.surfaces.formats.npz import read_npz, with_fields_of_file, write_npz
from sparsurf.surfaces.formats.ply import write_ply
from sparsurf.surfaces.molecular_surface import molecular_surface
from sparsurf.surfaces.read_surface import read_points, read_surface
from sparsurf.surfaces.spacing import area_of
from sparsurf.surfaces.surface import Surface

FIELDS = ("points", "normals", "area", "kind", "atom")
# Three atoms of two residues; columns as in DMS's own files, without and with chain letters.
DMS = {
    "no chain": """\
GLU  209    N  58.200   40.310   13.010 A
GLU  209    N  59.267   39.612   12.138 SS0  0.284  0.839 -0.481 -0.254
GLU  209   H1  59.050   40.870   13.200 A
GLU  209   H1  58.546   42.303   13.449 SR0  0.185  0.548  0.726  0.415
GLU  209   H1  59.460   40.870   14.328 SC0  0.190  0.342  0.000  0.940
""",
    "chain": """\
GLU  26A    N   43.775    3.105   46.312 A
GLU  26A    N   42.908    2.449   44.993 SS0  0.185 -0.690  0.307 -0.655
GLU  26A   CD   42.775    3.105   46.312 A
GLU  26A   CD   42.458    2.892   47.016 SR0  0.185 -0.910 -0.000  0.415
GLU  26A   CD -142.569-1002.178 -945.519 SC0  0.185 -0.894  0.167 -0.415
""",
}


@pytest.fixture(scope="module")
def small():
    return molecular_surface([[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2]], [1.9, 1.5, 1.2])


def written(tmp_path, text, name="surface.dms"):
    path = tmp_path / name
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    return path


# ---- the object


def test_surface_fills_in_what_is_unknown_and_copies_what_is_given():
    surface = Surface(np.zeros((2, 3)), [[0, 0, 1], [1, 0, 0]])
    assert len(surface) == 2 and np.isnan(surface.area).all()
    assert surface.kind.tolist() == surface.atom.tolist() == [-1, -1]
    assert [getattr(surface, name).dtype.str for name in FIELDS] == ["<f8", "<f8", "<f8", "|i1", "<i4"]
    given = {"points": np.zeros((2, 3)), "normals": np.eye(3)[:2], "area": np.ones(2)}
    given |= {"kind": np.ones(2, np.int8), "atom": np.ones(2, np.int32)}
    surface = Surface(**given)
    for array in given.values():
        array += 5
    assert surface.points.tolist() == [[0, 0, 0], [0, 0, 0]]
    assert surface.normals.tolist() == [[1, 0, 0], [0, 1, 0]]
    assert [getattr(surface, name).tolist() for name in FIELDS[2:]] == [[1, 1], [1, 1], [1, 1]]
    turned = Surface(np.zeros((3, 2)).T, np.eye(3)[:, :2].T)
    assert turned.points.flags.c_contiguous and turned.normals.flags.c_contiguous


def test_some_dots_keep_all_that_is_known_of_them():
    known = {"area": [1.0, 2, 3], "kind": [0, 1, 2], "atom": [5, 6, 7], "fields": {"charge": [0.1, 0.2, 0.3]}}
    whole = Surface(np.eye(3) * 4, np.eye(3), **known)
    for dots in ([2, 0], np.array([True, False, True])):
        few = whole.take(dots)
        for name in FIELDS:
            assert np.array_equal(getattr(few, name), getattr(whole, name)[dots])
        assert few.fields["charge"].tolist() == np.array(known["fields"]["charge"])[dots].tolist()


def test_dots_become_a_table_and_an_array():
    known = {
        "area": [1.0, 2],
        "kind": [2, 0],
        "atom": [5, 6],
        "fields": {"charge": [0.1, 0.2], "late": [7, 8]},
    }
    dots = Surface([[1, 2, 3], [4, 5, 6]], [[0, 0, 1], [1, 0, 0]], **known)
    table = dots.to_frame(late=np.array([9, 9]))
    assert [*table] == ["x", "y", "z", "nx", "ny", "nz", "area", "kind", "late", "charge"]
    assert table.to_numpy().tolist() == [[1, 2, 3, 0, 0, 1, 1, 2, 9, 0.1], [4, 5, 6, 1, 0, 0, 2, 0, 9, 0.2]]
    assert repr(dots) == "Surface of 2 dots" and dots[1].points.tolist() == dots[1:].points.tolist() == [
        [4, 5, 6]
    ]
    assert repr(dots[0]) == "Surface of 1 dot"
    with pytest.raises(InputError, match="there are no dots"):
        dots[[]]
    assert dots[[False, True]].points.tolist() == dots[[-1]].points.tolist() == [[4, 5, 6]]
    single = np.asarray(dots, np.float32)
    assert single.dtype == np.float32 and single.tolist() == dots.points.tolist()
    assert np.shares_memory(np.asarray(dots), dots.points)
    assert not np.shares_memory(np.array(dots, copy=True), dots.points)
    with pytest.raises(ValueError, match="float32 without"):
        np.asarray(dots, np.float32, copy=False)


@pytest.mark.parametrize(
    ("points", "normals", "word"),
    [
        (np.empty((0, 3)), np.empty((0, 3)), "no dots"), ([[0, 0, np.nan]], [[0, 0, 1]], "NaN"),
        ([[0, 0, 0]], [[0, 0, np.inf]], "NaN"), ([[0, 0, 0]], [[0, 0, 1.003]], "unit"),
        ([[0, 0, 0], [0, 0, 1]], [[0, 0, 1], [0, 0, 0.9]], "unit"),
        ([[0, 0]], [[0, 0, 1]], r"points has the shape \(1, 2\), not \(N, 3\), a row for each dot"),
        ([[0, 0, 0]], [[0, 0, 1], [0, 0, 1]], r"normals has the shape \(2, 3\), not \(1, 3\)"),
    ],
)  # fmt: skip
def test_surface_refuses(points, normals, word):
    with pytest.raises(InputError, match=word):
        Surface(np.array(points, float), np.array(normals, float))


def test_few_dots_may_stand_for_areas_of_any_size():
    assert Surface(np.eye(3), np.eye(3), [0.1, 0.1, 900.0]).area.sum() == pytest.approx(900.2)


def test_labels_of_a_molecule_are_given_to_dots_of_any_of_its_frames(tmp_path):
    one = read_molecule(write(tmp_path / "a.pdb", peptide()))
    two = replace(one, xyz=np.concatenate([one.xyz, one.xyz + 60]))
    dots = molecular_surface(two.xyz[1], np.full(20, 1.7), density=1.0)
    table = dots.to_frame(two)
    assert table["atom_name"].tolist() == two.name[dots.atom].tolist()
    with pytest.raises(InputError, match="other atoms"):
        dots.to_frame(one)


def test_half_precision_is_reported_by_the_largest_coordinate(caplog):
    Surface(np.float16([[1, 0, 0], [0, -300, 0]]), np.eye(3)[:2])
    step = 0.25  # of float16 from 256 to 512; the nearest of them is half of it away along each axis
    assert f"rounds them by up to {step / 2 * 3**0.5:.1g} Å" in caplog.text


def test_a_field_may_be_unknown_but_not_infinite(blob):
    points, normals = np.zeros((1, 3)), np.array([[0, 0, 1.0]])
    assert np.isnan(Surface(points, normals, fields={"q": [np.nan]}).fields["q"]).all()
    with pytest.raises(InputError, match="field q"):
        Surface(points, normals, fields={"q": [np.inf]})
    table = pd.DataFrame({"height": blob[0][:, 2]})  # of pandas, too
    assert np.array_equal(Surface(*blob, fields=table).fields["height"], blob[0][:, 2])


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"xyz": [[0, 0]]}, "centres"), ({"xyz": np.empty((0, 3)), "radii": []}, "centres"), ({"radii": [1.0, 1.0]}, "radii"),
        ({"xyz": [[0, 0, np.nan]]}, "coordinates"), ({"xyz": [[0, 0, 1.2e6]]}, "coordinates"), ({"radii": [0.0]}, "radii"),
        ({"radii": [np.nan]}, "radii"), ({"radii": [100.5]}, "radii"), ({"probe": 0}, "probe_radius"),
        ({"probe": np.nan}, "probe_radius"), ({"density": 0}, "density"), ({"density": np.inf}, "density"),
        ({"reentrant": "msms"}, "reentrant"),
    ],
)  # fmt: skip
def test_molecular_surface_refuses(change, word):
    with pytest.raises(InputError, match=word):
        molecular_surface(**{"xyz": [[0, 0, 0]], "radii": [1.9], **change})


def test_lowest_density_leaves_a_dot():
    """One dot per sphere, at its north pole: the highest of all poles is always free."""
    assert len(molecular_surface([[0, 0, 0], [0, 0, 0.5]], [1.9, 1.4], density=1e-6)) == 1


# ---- DMS files


@pytest.mark.parametrize("layout", DMS)
@pytest.mark.parametrize("packed", [False, True])
def test_read_dms(tmp_path, layout, packed):
    text = DMS[layout].encode()
    path = written(tmp_path, gzip.compress(text) if packed else text, "a.dms.gz" if packed else "a.dms")
    surface = read_surface(path)
    assert surface.kind.tolist() == [1, 2, 0]
    assert surface.atom.tolist() == [0, 1, 1]
    last = {"no chain": [59.460, 40.870, 14.328], "chain": [-142.569, -1002.178, -945.519]}[layout]
    np.testing.assert_array_equal(surface.points[2], last)
    # kept as written: three decimals are within sqrt(3) * 0.0005 of unit length
    np.testing.assert_allclose(np.linalg.norm(surface.normals, axis=1), 1, rtol=0, atol=9e-4)
    assert surface.area[1] == 0.185


def test_read_published_dms(shared):
    surface = read_surface(shared / "data" / "tdp43" / "A1.dms.gz")
    assert np.bincount(surface.kind).tolist() == [6111, 7992, 5942]
    assert surface.atom[-1] == 952
    # The program's own sums, 1170.4 and 2572.2 Å^2; areas are rounded to 0.001 Å^2 in the file.
    assert surface.area[surface.kind == 0].sum() == pytest.approx(1170.4, abs=0.0005 * 6111)
    assert surface.area[surface.kind > 0].sum() == pytest.approx(2572.2, abs=0.0005 * 13934)


LINE = "GLU  209    N  59.267   39.612   12.138 SS0  0.284  0.839 -0.481 -0.254\n"


REFUSED = {
    "dots.dms": [
        ("", "no dots"), ("GLU  209    N  58.200   40.310   13.010 A\n", "no dots"), ("<html>\n", "no dots"),
        (LINE[:51] + "\n", "-n"), (LINE.replace("59.267", "   nan"), "NaN"), (LINE.replace("0.839", "  inf"), "NaN"),
        (LINE.replace("59.267", "5x.267"), "line 1"), (LINE + LINE[:-8] + "\n", "line 2"),
        (LINE[:50] + "  0.000  0.000  0.000\n", "length"),
        (LINE + LINE.replace("SS0", "XX0"), "line 2 is a dot of no type SC, SS or SR"),
        (LINE + LINE[:40], "is cut short: line 2 is not a complete dot or atom"),
    ],
    "dots.csv": [
        ("x,y,z\n1,2,3\n", "column nx"), ("x,y,z,nx,ny,nz,NZ\n1,2,3,0,0,1,1\n", "several columns nz"),
        ("x,y,z,nx,ny,nz,q,q\n1,2,3,0,0,1,4,5\n", "has the column 'q' twice; remove or rename one"),
        ("x,y,z,nx,ny,nz,frame,frame,a,a\n1,2,3,0,0,1,1,1,4,5\n", "has the column 'a' twice"),
        (f"x,y,z,nx,ny,nz,{'a' * 200_000}\n1,2,3,0,0,1,0\n", "it is damaged"), ("x,y,z,nx,ny,nz\n", "no dots"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,4,0,0,0\n", "line 3 has a normal of length 0: remove it"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,3,0,,1\n", "line 3 has NaN"),
        ("x,y,z,nx,ny,nz,q\n1,2,3,0,0,1,\n1,2,4,0,0,1,-inf\n", "line 3 has an infinite q: put NaN"),
        ("x,y,z,nx,ny,nz,q\n1,2,3,0,0,1,5\n1,2,3,0,0,1,5\n1,2,4,0,0,1,inf\n", "line 4 has an infinite q"),
        ("x,y,z,nx,ny,nz,area\n1,2,3,0,0,1,.2\n1,2,4,0,0,1,-.2\n", "line 3 has a negative or infinite area: repair"),
        ("Weight,x,y,z,nx,ny,nz\n3,1,2,3,0,0,1\n\ninf,1,2,4,0,0,1\n", "line 4 has a negative or infinite weight"),
        ("x,y,z,nx,ny,nz,area\n1,2,3,0,0,1,?\n1,2,4,0,0,1,-1\n", "line 3 has a negative or infinite area"),
        ("x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,3,0,0,1,5,6\n", "line 3 has 8 values, not 6; repair it"),
        ("x,y,z,nx,ny,nz\n9,1,2,3,0,0,1\n", "more values than its header has names"),
        ('x,y,z,nx,ny,nz,q\n1,2,3,0,0,1,"a\nb"\n1,2,,0,0,1,c\n', "has NaN"),
        ("x;y;z;nx;ny;nz\n1;2;3;0;0;1\n", "no commas in its header: separate the columns with commas"),
    ],
    "places.csv": [
        ("", "holds no dots; give a DMS file, a CSV"), ("x,y,z\n", "holds no points."),
        ("x,y\n1,2\n", "has no column z; its first line must name "), ("x\ty\tz\n1\t2\t3\n", "no commas in its header"),
        ("x,y,z\n9,1,2,3\n", "its rows have more values than its header has names"),
        ("x,y,z\n1,2,3\n1,,3\n", "line 3 does not have the three numbers x, y and z: repair it"),
        ("x,y,z\n1,2,here\n", "line 2 does not have the three numbers x, y and z: repair it"),
        ("x,y,z\n1,2,inf\n", "line 2 does not have the three numbers x, y and z: repair it"),
    ],
}  # fmt: skip


def test_a_table_without_rows_holds_no_dots_and_no_wrong_columns(tmp_path, caplog):
    (tmp_path / "head.csv").write_text("x,y,z,nx,ny,nz,weight,probe_radius,radii,model\n")
    with pytest.raises(InputError, match=r"head\.csv holds"):
        read_surface(tmp_path / "head.csv")
    assert caplog.text == ""


@pytest.mark.parametrize(
    ("name", "text", "word"), [(name, *row) for name, rows in REFUSED.items() for row in rows]
)
def test_a_bad_file_is_one_sentence(tmp_path, name, text, word):
    path = written(tmp_path, text, name)
    with pytest.raises(InputError, match=word) as error:
        (read_points if name == "places.csv" else read_surface)(path)
    assert str(path) in str(error.value) and "\n" not in str(error.value)


def test_numbers_that_touch_each_other_are_read_by_columns(tmp_path):
    for start, x in (("GLU  209    N-142.569", -142.569), ("GLU  26A    N-1142.569", -1142.569)):
        text = f"{start}-1002.178 -945.519 SC0  0.284  0.839 -0.481 -0.254\n"
        assert read_surface(written(tmp_path, text)).points.tolist() == [[x, -1002.178, -945.519]]


def test_words_between_single_blanks_are_read_and_remarks_passed_over(tmp_path):
    """A file need not end its last line."""
    lines = DMS["no chain"].splitlines()
    dots = "\n".join(" ".join(line.split()) for line in lines)
    remarks = "\n".join(["# by hand 1 2 3 4", "", *lines[:2], "# a remark", *lines[2:]])
    for text in (dots, f"{dots}\nGLU 209 H1 1 2 3 A", remarks):
        found = read_surface(written(tmp_path, text))
        assert found.points[:, 0].tolist() == [59.267, 58.546, 59.460] and found.atom.tolist() == [0, 1, 1]


def test_doubled_dots_are_removed_with_a_warning(tmp_path, caplog):
    other = LINE.replace("59.267", "58.267").replace("SS0", "SC0").replace("0.284", "0.250")
    surface = read_surface(written(tmp_path, LINE + other + LINE + other.replace("SC0", "SR0")))
    assert surface.kind.tolist() == [1, 0] and surface.area.tolist() == [0.284, 0.25]
    assert (
        "dots that occur twice are removed (2); numbers of dots count those that remain, from 0\n"
        in caplog.text
    )
    assert surface.points[:, 0].tolist() == [59.267, 58.267]  # the order of the file


# ---- CSV


@pytest.mark.parametrize(
    "text",
    [
        "Res,x,y,z,Nx,Ny,Nz\nN_209_GLU,1.5,2,3,0,0,1\nN,-1e1,2,3,0.6,0,0.8\n",
        "x,y,z,nx,ny,nz\n1.5,2,3,0,0,1\n-1e1,2,3,0.6,0,0.8", " X, Y, Z, NX, NY, NZ\n1.5,2,3,0,0,1\n-1e1,2,3,0.6,0,0.8\n",
        '\r\n \t\r\nx, "y", z, nx, ny, nz, q\n1.5, "2", 3, 0, 0, "1", "-4"\n-10,2,3,.6,0,.8,5\n',
        "# made by hand, twice\n\nx,y,z,nx,ny,nz\n1.5,2,3,0,0,1\n-1e1,2,3,0.6,0,0.8\n",
        "\ufeff\n#\nx,y,z,nx,ny,nz\n1.5,2,3,0,0,1\n-1e1,2,3,0.6,0,0.8\n",
        "# by hand\n#id,x,y, Z ,nx,ny,nz\n7,1.5,2,3,0,0,1\n8,-1e1,2,3,0.6,0,0.8\n",
        "# x,y,z,nx,ny,nz\n1.5e+00,2,3,0,0,1\n-1e1,2,3,0.6,0,0.8\n",  # by numpy
    ],
)  # fmt: skip
def test_read_csv(tmp_path, text):
    surface = read_surface(written(tmp_path, text, "a.csv"))
    np.testing.assert_array_equal(surface.points, [[1.5, 2, 3], [-10, 2, 3]])
    np.testing.assert_allclose(surface.normals, [[0, 0, 1], [0.6, 0, 0.8]], atol=1e-15)
    assert (surface.atom == -1).all() and np.array_equal(read_points(tmp_path / "a.csv"), surface.points)


@pytest.mark.parametrize(
    "last", [["0.12", "0.1234"], ["0.12"], ["0.123", "0.12"], ["0.1234", "0.12345"], ["0.1234", "0.12"]]
)
def test_a_last_number_of_fewer_decimals_than_all_others_is_cut_short(tmp_path, last):
    text = "x,y,z,nx,ny,nz,q\n" + "\n".join(
        f"{k},2,3,0,0,1,{q}" for k, q in enumerate([*8 * ["0.1234"], *last])
    )
    assert len(read_surface(written(tmp_path, text + "\n", "a.csv"))) == 8 + len(last)
    if last != ["0.1234", "0.12"]:  # nine numbers do not tell, nor does a longer one
        assert len(read_surface(written(tmp_path, text, "a.csv"))) == 8 + len(last)
        return
    with pytest.raises(InputError, match="short: line 11"):
        read_surface(written(tmp_path, text, "a.csv"))


@pytest.mark.parametrize(
    ("end", "is_cut"),
    [("", False), ("3.5,2,3,0,0,1,", True), ("3.5,2,3,0,0", True), ("3.5,2,3,0,0,1,AL", False)],
)
def test_a_last_row_of_fewer_cells_than_all_others_is_cut_short(tmp_path, end, is_cut):
    text = "x,y,z,nx,ny,nz,residue_name\n" + "".join(f"{k},2,3,0,0,1,ALA\n" for k in range(9)) + end
    path = written(tmp_path, text, "a.csv")
    if is_cut:
        with pytest.raises(InputError, match="short: line 11"):
            read_surface(path)
    else:
        assert len(read_surface(path)) == 9 + bool(end)


def test_a_line_of_a_dms_file_that_is_no_dot_is_refused_where_it_stands(tmp_path):
    lines = DMS["no chain"].splitlines(keepends=True)
    with pytest.raises(InputError, match="line 3 is neither an atom nor a dot: 'SS0 by hand'; repair it"):
        read_surface(written(tmp_path, "".join([*lines[:2], "SS0 by hand\n", *lines[2:]])))


def test_a_vert_file_has_as_many_vertices_as_it_announces(tmp_path):
    vertex = "    {}.000     0.000     0.000     1.000     0.000     0.000       1       1  1 C\n"
    head = "# MSMS solvent excluded surface vertices for x\n#vertex #sphere density probe_r\n   {}   1  1.00  1.50\n"
    vertices = "".join(vertex.format(k) for k in range(1, 5))
    assert len(read_surface(written(tmp_path, head.format(4) + vertices, "a.vert"))) == 4
    assert len(read_surface(written(tmp_path, vertices, "a.vert"))) == 4  # of -no_header
    with pytest.raises(InputError, match="has 4 vertices and announces 5"):
        read_surface(written(tmp_path, head.format(5) + vertices, "a.vert"))


def test_dots_of_frames_and_places_of_tables(tmp_path):
    path = written(tmp_path, "x,y,z,nx,ny,nz,frame\n1,2,3,0,0,1,5\n1,2,4,0,0,1,5\n", "a.csv")
    assert len(read_surface(path)) == 2
    path.write_text(path.read_text().replace("4,0,0,1,5", "4,0,0,1,6"))
    with pytest.raises(InputError, match="2 frames"):
        read_surface(path)
    assert read_points(path).tolist() == [[1, 2, 3], [1, 2, 4]]
    rows = "Z,name,x,y\n3,a,1,2\n9,b,7,8\n3,c,1,2\n"
    assert read_points(written(tmp_path, rows, "a.csv")).tolist() == [[1, 2, 3], [7, 8, 9], [1, 2, 3]]
    dots = written(tmp_path, LINE, "a.dms")
    assert np.array_equal(read_points(dots), read_surface(dots).points)


@pytest.mark.parametrize("row", ['"two\nlines",1', "\n  \nplain,1", '"three\n\nlines",1'])
def test_a_line_is_named_behind_quoted_cells_that_hold_some(tmp_path, row):
    before = f"# remark\nname,x,y,z,nx,ny,nz\n{row},2,3,0,0,1\n"
    path = written(tmp_path, before + '"a",1,2,3,0,0,1\nb,1,what,3,0,0,1\n', "a.csv")
    with pytest.raises(InputError, match=f"line {before.count(chr(10)) + 2}"):
        read_surface(path)


def test_columns_that_mean_nothing_else_are_fields(tmp_path):
    """Whatever the case of their names; whole numbers, too, and not words or what a file of dots says otherwise."""
    others = "Area,KIND,Residue,atom,Index,ID,Weight,kept,red"
    text = f"x,y,z,nx,ny,nz,Charge,count,word,word,{others}\n1,2,3,0,0,1,-0.5,7,CA,CB{9 * ',1'}\n"
    found = read_surface(written(tmp_path, text, "a.csv"))
    assert {name: values.tolist() for name, values in found.fields.items()} == {
        "Charge": [-0.5],
        "count": [7],
    }


def test_columns_of_numbers_that_are_left_out_are_reported(tmp_path, caplog):
    """By their name, or by a cell that is no number; not those of words, and not what pandas writes of its rows."""
    potential = ["0", "", "2", "n.d.", *"45678"]
    rows = [f"{k},{k},2,3,0,0,1,{k / 2},{potential[k]},{k},{k},CA,{k}\n" for k in range(9)]
    header = ",x,y,z,nx,ny,nz,good,potential,pot (kT/e),points,word,area\n"
    found = read_surface(written(tmp_path, header + "".join(rows), "a.csv"))
    assert [*found.fields] == ["good"]
    path = tmp_path / "a.csv"
    assert [message.removeprefix(f"{path}: the column ") for message in caplog.messages] == [
        "potential is left out: it holds 'n.d.', which is not a number",
        "'pot (kT/e)' is left out: the name of a field may contain only letters, digits and _; rename it",
        "'points' is left out: the name of a field may contain only letters, digits and _; rename it",
    ]
    assert (found.points[:, 0] == np.arange(9)).all()


def test_normals_far_from_unit_length_are_scaled_and_reported(tmp_path, caplog):
    kept = written(tmp_path, "x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,4,0,1.001,0\n", "a.csv")
    assert read_surface(kept).normals.tolist() == [[0, 0, 1], [0, 1.001, 0]]  # what three decimals leave
    said = "normals of length {} are scaled to 1".format
    for long, told in ((1.003, []), (1.04, []), (1.06, [said("1 to 1.06")]), (0.6, [said("0.6 to 1")])):
        path = written(tmp_path, f"x,y,z,nx,ny,nz\n1,2,3,0,0,1\n1,2,4,0,{long},0\n", "a.csv")
        assert read_surface(path).normals.tolist() == [[0, 0, 1], [0, 1, 0]]
        assert caplog.messages == [f"{path}: {each}" for each in told]
        caplog.clear()
    text = "x,y,z,nx,ny,nz\n1,2,3,0,0,1.5\n1,2,4,0,1.001,0\n1,2,5,.5,0,0\n"
    mixed = read_surface(written(tmp_path, text, "a.csv")).normals
    assert mixed.tolist() == [[0, 0, 1], [0, 1.001, 0], [1, 0, 0]]  # each that is off
    near = written(
        tmp_path, "x,y,z,nx,ny,nz\n0,0,1,0,0,1\n1,2,4,0,2,0\n", "a.csv"
    )  # one dot 1 Å from the origin
    assert read_surface(near).normals.tolist() == [[0, 0, 1], [0, 1, 0]]
    unit = written(tmp_path, "x,y,z,nx,ny,nz\n0,0,1,0,0,3\n0,1,0,0,2.5,0\n", "a.csv")
    with pytest.raises(
        InputError, match=r"of length 2\.5 to 3 and positions of length 1: exchange the columns"
    ):
        read_surface(unit)


# ---- npz


def test_npz_returns_the_same_surface(tmp_path, small):
    write_npz(tmp_path / "a.npz", small)
    again = read_surface(tmp_path / "a.npz")
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(again, name), getattr(small, name))
    arrays = {name: getattr(small, name)[:2] for name in FIELDS}
    numbers = {"charge": np.array([0.5, -1]), "count": np.array([3, 4]), "small": np.array([5, 6], np.uint8)}
    np.savez(tmp_path / "b.npz", **arrays, **numbers, word=np.array(["a", "b"]), kept=np.ones(2))
    mesh = {"vertices": arrays["points"][::-1], "normals": arrays["normals"], "faces": np.array([[0, 1, 0]])}
    np.savez(tmp_path / "mesh.npz", **mesh)
    assert np.array_equal(read_surface(tmp_path / "mesh.npz").points, mesh["vertices"])
    fields = read_surface(tmp_path / "b.npz").fields
    assert {name: values.tolist() for name, values in fields.items()} == {
        name: values.tolist() for name, values in numbers.items()
    }


def test_a_file_of_a_user_is_judged_and_a_result_of_a_study_is_read_as_it_is(tmp_path):
    dots = molecular_surface(np.zeros((1, 3)), np.array([1.8]))
    surface = Surface(
        dots.points / 10, dots.normals, np.full(len(dots), 9.0), fields={"charge": np.arange(len(dots))}
    )
    write_npz(tmp_path / "nm.npz", surface)
    with pytest.raises(InputError, match="them to Å"):
        read_surface(tmp_path / "nm.npz")
    again = read_npz(tmp_path / "nm.npz")
    np.testing.assert_array_equal(again.points, surface.points)
    assert (again.area == 9).all() and again.fields["charge"][-1] == len(dots) - 1


def test_npz_has_the_same_bytes_at_any_time_and_fields_of_a_file_are_added(tmp_path, small, monkeypatch):
    write_npz(tmp_path / "a.npz", small)
    monkeypatch.setattr("time.time", lambda: 2e9)
    write_npz(tmp_path / "b.npz", small)
    assert (tmp_path / "a.npz").read_bytes() == (tmp_path / "b.npz").read_bytes()
    dots = Surface(np.eye(3), np.eye(3), fields={"own": [1, 2, 3]})
    np.savez(tmp_path / "a.npz", charge=np.array([0.1, 0.2, 0.3]))
    assert with_fields_of_file(dots, None) is dots
    fields = with_fields_of_file(dots, tmp_path / "a.npz").fields
    assert {name: each.tolist() for name, each in fields.items()} == {
        "own": [1, 2, 3],
        "charge": [0.1, 0.2, 0.3],
    }


@pytest.mark.parametrize(
    "arrays",
    [
        {"points": np.zeros((2, 3))}, {name: np.zeros(2) for name in FIELDS},
        {"points": np.array([["a"] * 3]), "normals": np.ones((1, 3))},
        {"points": np.zeros((3, 3)), "normals": np.zeros((2, 3))},
    ],
)  # fmt: skip
def test_foreign_npz_is_refused(tmp_path, arrays):
    np.savez(tmp_path / "a.npz", **arrays)
    with pytest.raises(InputError, match="not a surface"):
        read_surface(tmp_path / "a.npz")


@pytest.mark.parametrize(
    "read", [read_surface, lambda path: with_fields_of_file(Surface(np.eye(3), np.eye(3)), path)]
)
def test_no_program_within_an_npz_is_run(tmp_path, read):
    class Harmful:
        def __reduce__(self):
            return os.mkdir, (str(tmp_path / "made"),)

    np.savez(tmp_path / "a.npz", **dict.fromkeys(FIELDS, np.array([Harmful()], dtype=object)))
    with pytest.raises(ValueError, match=r"allow_pickle|or damaged"):
        read(tmp_path / "a.npz")
    assert not (tmp_path / "made").exists()


# ---- for other programs


@pytest.mark.parametrize("labels", [["209", "209", "210"], ["26A", "26A", "-27A"]])
@pytest.mark.parametrize("shift", [0.0, -1200.0, -99.0])  # at the last, dots alone have longer numbers
def test_dms_returns_the_same_surface(tmp_path, small, labels, shift):
    xyz = np.array([[0, 0, 0], [1.5, 0, 0], [2.2, 1.3, 0.2]]) + shift
    surface = Surface(small.points + shift, *(getattr(small, field) for field in FIELDS[1:]))
    write_dms(tmp_path / "a.dms", surface, ["GLU", "GLU", "HIS"], labels, ["N", "2HH1", "C"], xyz)
    again = read_surface(tmp_path / "a.dms")
    words = {len(line.split()) for line in (tmp_path / "a.dms").read_text().splitlines()}
    assert words == {7, 11} or shift < -999  # no columns touch
    np.testing.assert_allclose(again.points, surface.points, rtol=0, atol=0.00051)
    np.testing.assert_allclose(again.normals, surface.normals, rtol=0, atol=0.001)
    np.testing.assert_allclose(again.area, surface.area, rtol=0, atol=0.00051)
    np.testing.assert_array_equal(again.kind, surface.kind)
    np.testing.assert_array_equal(again.atom, surface.atom)


def test_dms_columns_are_those_of_the_program(shared, tmp_path):
    """Reading and writing DMS's own files gives the same text, but for the last digit of the normals."""
    for stem in ("tdp43/A1", "1a1u/1a1u_A"):
        text = gzip.decompress((shared / "data" / f"{stem}.dms.gz").read_bytes()).decode()
        atoms = [line for line in text.split("\n") if line.endswith(" A")]
        labels = [
            [line[:3] for line in atoms],
            [line[3:8].strip() for line in atoms],
            [line[8:13].strip() for line in atoms],
        ]
        xyz = np.array([line.split()[-4:-1] for line in atoms], float)
        write_dms(tmp_path / "a.dms", read_surface(shared / "data" / f"{stem}.dms.gz"), *labels, xyz)
        ours = (tmp_path / "a.dms").read_text()
        assert [line[:-22] for line in ours.split("\n")] == [line[:-22] for line in text.split("\n")]


def test_dms_needs_atoms_and_kinds_and_areas_do_not_touch_the_types(tmp_path):
    with pytest.raises(InputError, match="atom"):
        write_dms(tmp_path / "a.dms", Surface(np.eye(3), np.eye(3)), ["GLU"], ["1"], ["N"], np.zeros((1, 3)))
    for kind, atom in (([0, 0, 0], [0, 0, 1]), ([0, -1, 0], [0, 0, 0]), ([0, 0, 0], [0, -1, 0])):
        one = Surface(np.eye(3), np.eye(3), kind=kind, atom=atom)
        with pytest.raises(InputError, match="every dot"):
            write_dms(tmp_path / "a.dms", one, ["GLU"], ["1"], ["N"], np.zeros((1, 3)))
    for area in (np.full(3, np.nan), np.array([99.999, 100.0, 12345.678])):
        dots = Surface(np.eye(3), np.eye(3), area, kind=[0, 1, 2], atom=[0, 0, 0])
        write_dms(tmp_path / "a.dms", dots, ["GLU"], ["1"], ["N"], np.zeros((1, 3)))
        again = read_surface(tmp_path / "a.dms")
        assert np.array_equal(again.area, area, equal_nan=True) and again.kind.tolist() == [0, 1, 2]
    x, atom = 0.1 * np.arange(400), np.arange(400) % 2
    points = np.column_stack([x, np.zeros((400, 2))])
    kind = np.arange(400) // 2 % 3
    dots = Surface(points, np.tile([0, 0, 1.0], (400, 1)), kind=kind, atom=atom)
    write_dms(tmp_path / "a.dms", dots, ["GLU"] * 2, ["1"] * 2, ["N", "C"], np.zeros((2, 3)))
    found = read_surface(tmp_path / "a.dms")
    assert found.points[:, 0] == pytest.approx([*x[::2], *x[1::2]]) and found.atom.tolist() == sorted(atom)
    assert found.kind.tolist() == [*kind[::2], *kind[1::2]]


# ---- all formats


@pytest.mark.parametrize("name", ["a.npz", "a.csv", "a.dms", "a.ply"])
def test_formats_are_distinguished_by_content_packed_or_not(tmp_path, small, name):
    """Whatever a file is called, one format takes it, and gives the dots back."""
    as_csv = "\n".join(
        ["x,y,z,nx,ny,nz", *(",".join(map(str, row)) for row in np.hstack([small.points, small.normals]))]
    )
    write_npz(tmp_path / "a.npz", small)
    write_dms(tmp_path / "a.dms", small, ["GLU"] * 3, ["1"] * 3, ["N", "C", "O"], np.zeros((3, 3)))
    written(tmp_path, as_csv, "a.csv")
    write_ply(tmp_path / "a.ply", small)
    content = (tmp_path / name).read_bytes()
    assert [
        registry.load("format", name, "format")[1].sniff(content[:1000]) for name in registry.formats_read()
    ].count(True) == 1
    for path in (written(tmp_path, content, "wrong.xyz"), written(tmp_path, gzip.compress(content), "a.gz")):
        np.testing.assert_allclose(read_surface(path).points, small.points, rtol=0, atol=0.00051)


@pytest.mark.parametrize("name", ["a.npz", "a.dms.gz", "a.dms"])
def test_a_file_that_unpacks_beyond_the_limit_is_refused(tmp_path, monkeypatch, name):
    """A hundred bytes that unpack to a million: read no farther than the limit."""
    path = tmp_path / name
    if name == "a.npz":
        np.savez_compressed(path, **{field: np.zeros(10_000) for field in FIELDS})
    else:
        written(tmp_path, gzip.compress(bytes(10**6)) if name.endswith("gz") else bytes(10**6), name)
    monkeypatch.setattr("sparsurf.files.MAX_UNPACKED_BYTES", 2**17)
    with pytest.raises(InputError, match="0 MB"):
        read_surface(path)


def test_a_table_of_dots_is_written_as_pandas_writes_it(tmp_path):
    """With missing, quoted and long texts, numbers of every kind, and no rows."""
    table = pd.DataFrame(
        {
            "x": [1.5, np.nan, np.inf, -0.0, 1e30],
            "field": np.float32([1e-9, 2, 3, np.nan, 5.123456789]),
            "count": np.int64([1, 2, 3, 4, 123456789]),
            "chain": ["A", "a,b", None, 'q"q', "\u00e9\n"],
            "kept": [True, False, True, False, True],
        }
    )
    for rows in (table, table.iloc[:0]):
        write_csv(tmp_path / "ours.csv", rows, ["field", "count"])
        fields = {name: ["" if v != v else f"{v:.6g}" for v in rows[name]] for name in ("field", "count")}
        rows.assign(**fields).to_csv(tmp_path / "pandas.csv", index=False, float_format="%.4f")
        assert (tmp_path / "ours.csv").read_bytes() == (tmp_path / "pandas.csv").read_bytes()


def test_areas_of_dots_that_stand_for_several_are_not_compared_with_their_spacing(tmp_path):
    points, normals = make_blob(300)
    dots = Surface(points, normals, np.full(300, 100.0), np.zeros(300), np.zeros(300))
    write_dms(tmp_path / "a.dms", dots, ["GLU"], ["1"], ["N"], np.zeros((1, 3)))
    with pytest.raises(InputError, match="dots implies"):
        read_surface(tmp_path / "a.dms")
    np.savez(tmp_path / "few.npz", **{name: getattr(dots, name) for name in FIELDS}, weight=dots.area)
    assert read_surface(tmp_path / "few.npz").area.sum() == 30_000
    assert area_of(Surface(points, normals, np.zeros(300)))[1]  # a surface of no area has an estimate


def test_of_few_dots_each_counts_once_for_the_winding_number():
    points, normals = ball(400, 6.0)
    some = np.arange(0, 400, 29)
    distances, around = plausibility._surrounding(plausibility._tree(points), some)
    behind, before = plausibility._windings(points, normals, some, distances, around)
    reach = distances[:, plausibility.N_BESIDE - 1]
    area = np.median(np.pi * reach**2 / plausibility.N_BESIDE)
    for found, side in ((behind, -1), (before, 1)):
        rays = points - (points[some] + side * reach[:, None] * normals[some])[:, None]
        angle = (rays * normals).sum(axis=2) / np.linalg.norm(rays, axis=2) ** 3
        assert found == pytest.approx(angle.sum(axis=1) * area / (4 * np.pi))
