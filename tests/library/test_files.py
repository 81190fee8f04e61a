"""Files of users: any line ending, compressed or not, and a sentence for what is not text."""

import gzip
import hashlib
import io
import sys
from pathlib import Path

import numpy as np
import pytest

from sparsurf.errors import InputError, naming_file
from sparsurf.files import (
    as_path,
    checksum_of_file,
    decode_text,
    existing_file,
    import_pyarrow,
    pluralise,
    read_archive,
    read_bytes,
    read_text,
    shorten,
)


@pytest.mark.parametrize(
    ("content", "text"), [(b"a\r\nb\rc\n\nd\xe5", "a\nb\nc\n\ndå"), ("\ufeffx,y".encode(), "x,y")]
)
def test_every_line_ends_once_and_a_byte_order_mark_is_no_text(content, text):
    assert decode_text(content) == text


def test_compressed_text_is_uncompressed_and_null_bytes_are_refused(tmp_path):
    (tmp_path / "a.GZ").write_bytes(gzip.compress(b"a\r\n"))
    assert read_text(tmp_path / "a.GZ") == "a\n"
    with pytest.raises(InputError, match="null bytes"):
        decode_text(b"a\0")
    with pytest.raises(InputError, match=r"cannot be read: .*null"):
        read_text("a\0.pdb")


def test_parquet_without_pyarrow_is_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match="run pip install pyarrow"):
        import_pyarrow()


def test_a_long_text_is_cut_in_the_middle():
    assert shorten("a" * 200) == "a" * 200
    assert shorten("a" * 100 + "b" * 41 + "c" * 60) == "a" * 100 + "..." + "c" * 60 + " (201 characters)"


@pytest.mark.parametrize("name", ["a.txt", "a.gz"])
def test_a_file_is_read_up_to_the_limit_and_refused_beyond_it(tmp_path, monkeypatch, name):
    monkeypatch.setattr("sparsurf.files.MAX_UNPACKED_BYTES", 10)
    pack = gzip.compress if name == "a.gz" else bytes
    (tmp_path / name).write_bytes(pack(b"x" * 10))
    assert read_bytes(tmp_path / name) == b"x" * 10
    (tmp_path / name).write_bytes(pack(b"x" * 11))
    with pytest.raises(InputError, match="holds more than"):
        read_bytes(tmp_path / name)


@pytest.mark.parametrize(
    ("content", "words"),
    [
        (b"text", r"is named \.gz but is not gzip"),
        (
            gzip.compress(b"text", mtime=0) + b"text",  # the same at any time: tests are told apart by it
            "is damaged inside its gzip",
        ),
        (gzip.compress(b"text" * 99, mtime=0)[:-9], "is cut short or damaged inside its gzip"),
    ],
)
def test_what_is_no_whole_gzip_is_reported(tmp_path, content, words):
    (tmp_path / "a.gz").write_bytes(content)
    with pytest.raises(InputError, match=words):
        read_bytes(tmp_path / "a.gz")


def test_a_number_agrees_with_its_noun_and_verb():
    for number, words in ((0, "0 atoms lack"), (1, "1 atom lacks"), (2, "2 atoms lack")):
        assert pluralise(number, "atom", "lacks") == words
    assert [pluralise(n, "gap", "is") for n in (1, 2)] == ["1 gap is", "2 gaps are"]
    assert [pluralise(n, "gap", "has") for n in (1, 2)] == ["1 gap has", "2 gaps have"]
    assert [pluralise(n, "gap") for n in (1, 2)] == ["1 gap", "2 gaps"]


def test_a_path_is_a_string_or_a_path_and_its_checksum_that_of_its_bytes(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert as_path("a/b") == Path("a/b") and existing_file(str(tmp_path / "a")) == tmp_path / "a"
    assert checksum_of_file(tmp_path / "a") == hashlib.sha256(b"abc").hexdigest()
    for wrong, words in ((3, "not int: name the file"), ("", "a path is empty"), (b"", "not bytes")):
        with pytest.raises(InputError, match=words):
            as_path(wrong)


@pytest.mark.parametrize(
    ("content", "name", "words"),
    [
        (gzip.compress(b"a", mtime=0), "a.pdb", r"is compressed with gzip: add \.gz"),
        (gzip.compress(b"a", mtime=0), "a.PDB.GZ", "is compressed twice"),
        ("a".encode("utf-16-le"), "a.pdb", "null bytes"),
        (b"\xff\xfea\0", "a.pdb", "is stored as UTF-16"),
        (b"\xfe\xff\0a", "a.pdb", "is stored as UTF-16"),
    ],
)
def test_what_is_no_text_is_named(tmp_path, content, name, words):
    (tmp_path / name).write_bytes(gzip.compress(content) if name.endswith(".GZ") else content)
    with pytest.raises(InputError, match=rf"^{tmp_path}/{name} .*{words}"):
        read_text(tmp_path / name)


def test_a_byte_order_mark_before_latin_1_is_no_text():
    assert decode_text(b"\xef\xbb\xbfd\xe5") == "då"


def test_an_archive_is_read_by_name_and_refused_beyond_the_limit(monkeypatch):
    stream = io.BytesIO()
    np.savez(stream, a=np.arange(40), b=np.array([1.5]))
    arrays = read_archive(stream.getvalue(), "is odd")
    assert arrays["a"].tolist() == list(range(40)) and arrays["b"].tolist() == [1.5]
    with pytest.raises(InputError, match=r"^a.npz is odd\.$"), naming_file("a.npz"):
        read_archive(b"PK", "is odd")
    one = io.BytesIO()
    np.save(one, np.arange(3))
    with (
        pytest.raises(InputError, match=r"^a.npz is odd\.$"),
        naming_file("a.npz"),
    ):  # a single array has no name
        read_archive(one.getvalue(), "is odd")
    monkeypatch.setattr("sparsurf.files.MAX_UNPACKED_BYTES", 500)
    with naming_file("a.npz"), pytest.raises(InputError, match=r"a\.npz unpacks to more than 0 MB"):
        read_archive(stream.getvalue(), "is odd")
