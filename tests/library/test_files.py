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
    existing_file,
    import_pyarrow,
    read_archive,
    read_bytes,
    read_text,
    shorten,
)


def test_a_long_text_is_cut_in_the_middle():
    assert shorten("a" * 200) == "a" * 200
    assert shorten("a" * 100 + "b" * 41 + "c" * 60) == "a" * 100 + "..." + "c" * 60 + " (201 characters)"


def test_parquet_without_pyarrow_is_a_sentence(monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow.parquet", None)
    with pytest.raises(InputError, match="pip install pyarrow"):
        import_pyarrow()


@pytest.mark.parametrize("name", ["a.txt", "a.gz"])
def test_a_file_is_read_up_to_the_limit_and_refused_beyond_it(tmp_path, monkeypatch, name):
    monkeypatch.setattr("sparsurf.files.MAX_UNPACKED_BYTES", 10)
    pack = gzip.compress if name == "a.gz" else bytes
    (tmp_path / name).write_bytes(pack(b"x" * 10))
    assert read_bytes(tmp_path / name) == b"x" * 10
    (tmp_path / name).write_bytes(pack(b"x" * 11))
    with pytest.raises(InputError, match="holds more than"):
        read_bytes(tmp_path / name)


def test_a_path_is_a_string_or_a_path_and_its_checksum_that_of_its_bytes(tmp_path):
    (tmp_path / "a").write_bytes(b"abc")
    assert as_path("a/b") == Path("a/b") and existing_file(str(tmp_path / "a")) == tmp_path / "a"
    assert checksum_of_file(tmp_path / "a") == hashlib.sha256(b"abc").hexdigest()
    for wrong, words in ((3, "not int: name the file"), ("", "a path is empty"), (b"", "not bytes")):
        with pytest.raises(InputError, match=words):
            as_path(wrong)


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
    with naming_file("a.npz"), pytest.raises(InputError, match="0 MB"):
        read_archive(stream.getvalue(), "is odd")


@pytest.mark.parametrize("order", ["le", "be"])
def test_text_in_utf16_is_named(tmp_path, order):
    (tmp_path / "a.csv").write_bytes("\ufeffx,y".encode(f"utf-16-{order}"))
    with pytest.raises(InputError, match=rf"^{tmp_path}/a.csv is stored as UTF-16"):
        read_text(tmp_path / "a.csv")
