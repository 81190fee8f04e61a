"""Files of users: any line ending, compressed or not, and a sentence for what is not text."""

import gzip
import logging

import pytest

from sparsurf.errors import InputError
from sparsurf.files import decode_text, no_warnings, read_bytes, read_text, shorten


@pytest.mark.parametrize(
    ("content", "text"), [(b"a\r\nb\rc\n\nd\xe5", "a\nb\nc\n\ndå"), ("\ufeffx,y".encode(), "x,y")]
)
def test_every_line_ends_once_and_a_byte_order_mark_is_no_text(content, text):
    assert decode_text(content, "x") == text


def test_compressed_text_is_uncompressed_and_null_bytes_are_refused(tmp_path):
    (tmp_path / "a.GZ").write_bytes(gzip.compress(b"a\r\n"))
    assert read_text(tmp_path / "a.GZ") == "a\n"
    with pytest.raises(InputError, match="null bytes"):
        decode_text(b"a\0", "x")
    with pytest.raises(InputError, match=r"cannot be read: .*null"):
        read_text("a\0.pdb")


def test_a_long_text_is_cut_in_the_middle():
    assert shorten("a" * 200) == "a" * 200
    assert shorten("a" * 100 + "b" * 41 + "c" * 60) == "a" * 100 + "..." + "c" * 60 + " (201 characters)"


@pytest.mark.parametrize("name", ["a.txt", "a.gz"])
def test_a_file_is_read_up_to_the_limit_and_refused_beyond_it(tmp_path, monkeypatch, name):
    monkeypatch.setattr("sparsurf.files.MAX_BYTES", 10)
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


def test_what_was_said_before_is_not_said_again(caplog):
    log = logging.getLogger("sparsurf")
    with pytest.raises(KeyError), no_warnings():
        log.warning("once")
        raise KeyError
    log.warning("again")
    assert caplog.messages == ["again"]
