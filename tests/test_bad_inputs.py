"""Inputs that an earlier release took without a word or answered with a traceback: each ends in one short sentence."""

import gzip
import logging
import os
import re
import signal

import numpy as np
import pytest

from conftest import ROOT, make_blob
from peptides import STEP, peptide
from sparsurf.dot_fields.charges import pqr_charges
from sparsurf.dot_fields.columns import column_of_atoms
from sparsurf.errors import InputError
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.surfaces.read_surface import read_surface
from sparsurf.workflow.config import check_config, read_config

# Words of the sentence: what is wrong and what to do. The name of the file or of the key is checked for all.
REFUSED = {
    "001_path_5000.yaml": ["proteins.tdp43.structure", "no file", "(5002 characters)"],
    "011_swap_norm.csv": ["normals of length 55", "exchange", "x,y,z and nx,ny,nz"],
    "014_url_broken_ipv6.yaml": ["proteins.tdp43.url", "complete https://"],
    "022_huge_point.csv": ["line 7", "1e+30", "repair"],
    "028_huge.pdb": ["GLU 209", "frame 0", "atom N"],
    "028_random_normals.csv": ["neighbouring dots", "outward normals"],
    "030_far_one.pdb": ["GLU 209", "frame 0", "atom N"],
    "030_nm.csv": ["0.036 Å apart", "nm", "give Å"],
    "034_tenfold.pdb": ["GLU 209", "Å"],
    "049_cut_in_number.csv": ["cut short", "line"],
    "116_badcrc.pdb.gz": ["damaged inside its gzip", "copy it again"],
    "121_trailgarbage.pdb.gz": ["damaged inside its gzip", "copy it again"],
    "122_nan_area.npz": ["area", "NaN"],
    "133_area_neg.npz": ["area", "negative"],
    "134_laugh10.yaml": ["aliases", "write them out"],
    "135_kind_9.npz": ["kind", "0, 1 or 2"],
    "135_laughmap.yaml": ["aliases", "write them out"],
    "141_cut.dms": ["cut short", "line", "copy it again"],
    "143_tagbool.yaml": ["line 9", "bool", "remove"],
    "144_tagtime.yaml": ["line 9", "timestamp", "remove"],
    "172_nobox.gro": ["box", "line 122"],
    "176_angstrom.gro": ["Å", "nm"],
    "240_comp_centres.yaml": ["complementarity.centres", "'some'", "sampler: farthest"],
    "258_pairs_name_pairs.yaml": ["pairs", "'pairs.md'", "choose another name"],
    "259_pairs_twins.yaml": ["pairs", "'x' and 'X'", "rename"],
    "260_pairs_long.yaml": ["pairs.x", "no file", "(302 characters)"],
    "302_tab_longname.yaml": ["proteins", "no such table", "(5006 characters)"],
    "303_folder_long.yaml": ["proteins.folder", "no such folder", "(5002 characters)"],
    "perm.xtc": ["GLU 209", "frame 0", "in the order of", "top.pdb"],
}
WARNED = {"048_cut.csv": ["do not close", "cut short"], "twice.dcd": ["12 frames", "twice"]}
OWN_TRAJECTORY = ("perm.xtc", "twice.dcd")
SECONDS = 20  # an answer that takes longer is none


@pytest.fixture
def bad(shared, monkeypatch):
    monkeypatch.chdir(ROOT)
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail(f"no answer in {SECONDS} s"))
    signal.alarm(SECONDS)
    yield shared / "data" / "bad" / "second"
    signal.alarm(0)


def read(path):
    """What a study does first with a file of this kind."""
    if path.suffix == ".yaml":
        return check_config(read_config(path), [path])
    if path.name in OWN_TRAJECTORY:
        return read_molecule(path.with_name("top.pdb"), path)
    return read_molecule(path) if {".pdb", ".gro"} & set(path.suffixes) else read_surface(path)


@pytest.mark.parametrize("name", REFUSED)
def test_a_bad_file_is_refused_in_one_short_sentence(bad, name):
    with pytest.raises(InputError) as caught:
        read(bad / name)
    message = str(caught.value)
    for word in [*REFUSED[name], *([] if name.endswith(".yaml") else [name])]:
        assert word in message
    for sentence in message.replace(os.fspath(bad), "").splitlines():
        assert len(sentence.split()) <= 40 and sentence.endswith(".")


@pytest.mark.parametrize("name", WARNED)
def test_a_doubtful_file_is_read_with_a_warning(bad, name, caplog):
    with caplog.at_level(logging.WARNING, "sparsurf"):
        read(bad / name)
    assert all(word in caplog.text for word in [name, *WARNED[name]])


def test_every_bad_file_has_its_answer(bad):
    of_results = {"cc.yaml", "grid_full.csv"}  # test_half_of_a_real_grid_is_refused
    assert {path.name for path in bad.iterdir()} == {*REFUSED, *WARNED, *of_results, "top.pdb"}


# ---- made for the test: files of odd encodings, ends of lines, numbers and versions

GOOD = peptide() + "END\n"
ZIPPED = gzip.compress(GOOD.encode())
NEGATIVE = peptide(["ALA"] * 7, first=-5) + "END\n"
INSERTED = peptide(["ALA"]) + "".join(
    peptide(["ALA"], origin=STEP * (1 + k)).replace("A   1 ", f"A   1{code}") for k, code in enumerate("ABC")
)
EITHER = peptide(["SER"], altloc="A", occupancy=0.4) + peptide(["THR"], altloc="B", occupancy=0.6)
MODELS = "".join(f"MODEL {k}\n{peptide(origin=(0, 0, 0.1 * k))}ENDMDL\n" for k in (1, 2))
LABELS = ["group_PDB", "id", "type_symbol", "label_atom_id", "label_comp_id", "label_asym_id", "label_seq_id"]
LABELS += ["Cartn_x", "Cartn_y", "Cartn_z"]


def mmcif(order=1, quote="", end="\n", between=" "):
    """The peptide as mmCIF: columns in one order or the other, names in quotes or not."""
    rows = [line.split() for line in peptide().splitlines()]
    rows = [
        ["ATOM", str(k), row[-1], f"{quote}{row[2]}{quote}", row[3], "A", row[5], *row[6:9]]
        for k, row in enumerate(rows)
    ]
    lines = ["data_x", "loop_", *(f"_atom_site.{label}" for label in LABELS[::order])]
    return end.join([*lines, *(between.join(row[::order]) for row in rows), "#", ""])


MOLECULES = {  # content, how it is read, and its residues or words of the sentence
    "bom.pdb": ("\ufeff" + GOOD, {}, "1 2 3 4"),
    "mixed.pdb": (b"REMARK \xe9\nREMARK \xc3\xa9\n" + GOOD.encode(), {}, "1 2 3 4"),
    "crcrlf.pdb": (GOOD.replace("\n", "\r\r\n"), {}, "1 2 3 4"),
    "utf16.pdb": (GOOD.encode("utf-16"), {}, ["stored as UTF-16"]),
    "minus.pdb": (NEGATIVE.replace("  -0.800", "  \u22120.800"), {}, ["Line 5", "readable coordinates"]),
    "comma.pdb": (GOOD.replace(".", ","), {}, ["Line 1", "readable coordinates"]),
    "tab.pdb": (GOOD.replace("ATOM  ", "ATOM\t", 1), {}, ["Line 1", "holds an atom"]),
    "hybrid36.pdb": (GOOD.replace("A   2 ", "AA000 "), {"residues": "A:10000"}, "10000"),
    "negative.pdb": (NEGATIVE, {"residues": "A:-5--3,1"}, "-5 -4 -3 1"),
    "one.pdb": (NEGATIVE, {"residues": "-5"}, "-5"),
    "backwards.pdb": (NEGATIVE, {"residues": "A:-1--5"}, ["'A:-1--5' ends before it begins"]),
    "dashes.pdb": (NEGATIVE, {"residues": "-5\u2013-1"}, ["chain:first-last"]),
    "open.pdb": (NEGATIVE, {"residues": "A:-5-"}, ["chain:first-last"]),
    "codes.pdb": (INSERTED, {"residues": "1A-1B"}, "1A 1B"),
    "code.pdb": (INSERTED, {"residues": "1C-1A"}, ["ends before it begins"]),
    "first.pdb": (EITHER, {"altloc": "first"}, "1"),
    "blank.pdb": (EITHER, {"altloc": " "}, ["neither first, highest nor one letter"]),
    "models.pdb": (MODELS, {"model": True}, ["True is not a whole number"]),
    "odd.pdb": (MODELS.replace(peptide(origin=(0, 0, 0.2)), peptide(["ALA"])), {}, ["models of different atoms"]),
    "reversed.cif": (mmcif(-1), {}, "1 2 3 4"),
    "quoted.cif": (mmcif(quote='"'), {}, "1 2 3 4"),
    "mac.cif": (mmcif(end="\r"), {}, "1 2 3 4"),
    "tabs.cif": (mmcif(between="\t"), {}, "1 2 3 4"),
    "bom.cif": ("\ufeff" + mmcif(), {}, "1 2 3 4"),
    "twice.pdb.gz": (gzip.compress(ZIPPED), {}, ["is compressed twice"]),
    "members.pdb.gz": (gzip.compress(GOOD[:162].encode()) + gzip.compress(GOOD[162:].encode()), {}, "1 2 3 4"),
    "twice.pdb.gz.gz": (ZIPPED, {}, ["not a structure by its extension"]),
    "packed.pdb.bz2": (b"BZh", {}, ["not a structure by its extension"]),
}  # fmt: skip


@pytest.mark.parametrize("name", MOLECULES)
def test_an_odd_structure_is_read_or_refused_in_a_sentence(tmp_path, name):
    content, keys, expected = MOLECULES[name]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    if isinstance(expected, str):
        found = read_molecule(tmp_path / name, **keys)
        assert " ".join(dict.fromkeys(found.residue)) == expected and set(found.element) == {"C", "N", "O"}
        return
    with pytest.raises(InputError) as caught:
        read_molecule(tmp_path / name, **keys)
    assert all(word in str(caught.value) for word in expected) and "\n" not in str(caught.value)


def test_an_empty_path_or_a_circle_of_links_is_a_sentence(tmp_path):
    (tmp_path / "a.pdb").symlink_to("b.pdb")
    (tmp_path / "b.pdb").symlink_to("a.pdb")
    for path, words in ((tmp_path / "a.pdb", "cannot be read: Too many"), ("", "a path is empty")):
        for reader in (read_molecule, read_surface):
            with pytest.raises(InputError, match=words):
                reader(path)


EXAMPLE = ROOT / "data" / "tdp43" / "topology.pdb"
READERS = {  # of every kind of file that a command takes
    **dict.fromkeys(["pdb", "cif", "gro", "h5"], read_molecule),
    **dict.fromkeys(["psf", "prmtop"], lambda path: read_molecule(path, path.with_suffix(".xtc"))),
    **dict.fromkeys(["xtc", "dcd", "nc", "mdcrd", "rst7"], lambda path: read_molecule(EXAMPLE, path)),
    **dict.fromkeys(["csv", "npz", "dms", "minimal"], read_surface),
    "pqr": pqr_charges,
    "table": lambda path: column_of_atoms(path, "value", read_molecule(EXAMPLE)),
}


@pytest.mark.parametrize("kind", READERS)
def test_a_pipe_a_device_a_folder_or_nothing_is_a_sentence_at_once(tmp_path, kind):
    path = tmp_path / f"a.{kind}"
    signal.signal(signal.SIGALRM, lambda *_: pytest.fail("it is read without end"))
    signal.alarm(SECONDS)
    try:
        for begin, end, words in (
            (lambda: None, lambda: None, f"{path} does not exist"),
            (
                lambda: os.mkfifo(path),
                path.unlink,
                f"{path} is a pipe or a device: store its content in a file",
            ),
            (lambda: path.symlink_to(os.devnull), path.unlink, f"{path} is a pipe or a device"),
            (path.mkdir, path.rmdir, f"{path} is a folder: give one file"),
        ):
            begin()
            with pytest.raises(InputError, match=re.escape(words)):
                READERS[kind](path)
            end()
        path.touch()
        with pytest.raises(InputError, match="leads into a file: unpack an archive first"):
            READERS[kind](path / path.name)
    finally:
        signal.alarm(0)


N = 300
DOTS = make_blob(N + 60)  # points and normals
TABLE = np.column_stack(DOTS)
ROWS = [[f"{value:.4f}" for value in row] for row in TABLE]
CSV = "x,y,z,nx,ny,nz\n" + "".join(",".join(row) + "\n" for row in ROWS)
HEAD = "ply\nformat {} 1.0\nelement vertex {}\n" + "".join(
    f"property float {a}\n" for a in ["x", "y", "z", "nx", "ny", "nz"]
)
HEAD += "end_header\n"
WORDS = "".join(" ".join(row) + "\n" for row in ROWS)
DMS = "".join(
    f"ALA {k + 1:5d}   CA {x:8.3f} {y:8.3f} {z:8.3f} SC0 {0.3:6.3f}{u:7.3f}{v:7.3f}{w:7.3f}\n"
    for k, (x, y, z, u, v, w) in enumerate(TABLE)
)


def with_value(value):
    """The table, with another value for one x."""
    return CSV.replace(ROWS[9][0], value, 1)


SURFACES = {  # content and words of the sentence, none where all dots are read
    "crlf.csv": (CSV.replace("\n", "\r\n"), ()),
    "mac.csv": (CSV.replace("\n", "\r"), ()),
    "bom.csv": ("\ufeff" + CSV, ()),
    "quoted.csv": (CSV.replace(",", '","').replace("\n", '"\n"')[:-1].join(['"', ""]), ()),
    "utf16.csv": (CSV.encode("utf-16"), ("stored as UTF-16",)),
    "semicolons.csv": (CSV.replace(",", ";").replace(".", ","), ("no commas in its header",)),
    "header_twice.csv": (CSV + CSV, (f"line {N + 62} ",)),
    "wide.csv": (CSV + "1," * 2000 + "\n", ("more than 1000 values",)),
    "digits.csv": (CSV[:15] + "9" * 400 + ",2,3,0,0,1\n", ("above 1e308",)),
    **{
        f"value_{k}.csv": (with_value(value), ("line 11 ",))
        for k, value in enumerate(("NaN", "n/a", "None", "", "-inf", "1e400", "1.#IND", "0x10", "1_0", "\u22121", "1d0"))
    },
    "big.ply": (HEAD.format("binary_big_endian", N + 60).encode() + TABLE.astype(">f4").tobytes(), ()),
    "other_end.ply": (HEAD.format("binary_little_endian", N + 60).encode() + TABLE.astype(">f4").tobytes(), ("dot",)),
    "more.ply": (HEAD.format("ascii", N) + WORDS, (f"more than the {N} vertices",)),
    "more_bytes.ply": (HEAD.format("binary_little_endian", N).encode() + TABLE.astype("<f4").tobytes(), ("more than",)),
    "ends.ply": (HEAD.format("binary_little_endian", N + 60).encode() + TABLE.astype("<f4").tobytes() + b"\n", ()),
    "commas.ply": (HEAD.format("ascii", N) + WORDS.replace(" ", ","), ("cannot be read",)),
    "good.dms": (DMS, ()),
    "type.dms": (DMS.replace("SC0", "XX0", 1), ("line 1 is a dot of no type",)),
    "grid.dx": ("object 1 class gridpositions counts 3 3 3\norigin 0 0 0\n", ("holds no dots",)),
    "page.csv": ("<html><body>404, not found</body></html>", ("needs one column x",)),
}  # fmt: skip


@pytest.mark.parametrize("name", SURFACES)
def test_an_odd_file_of_dots_is_read_whole_or_refused_in_a_sentence(tmp_path, name, recwarn):
    content, words = SURFACES[name]
    (tmp_path / name).write_bytes(content if isinstance(content, bytes) else content.encode())
    if not words:
        np.testing.assert_allclose(read_surface(tmp_path / name).points, DOTS[0], atol=0.003)
        return
    with pytest.raises(InputError) as caught:
        read_surface(tmp_path / name)
    assert all(word in str(caught.value) for word in (*words, name)) and "\n" not in str(caught.value)
    assert not list(recwarn)
