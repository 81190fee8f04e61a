"""Texts of users: any line ends, packed or not, nothing that is no text."""

import gzip

import pytest

from sparsurf import InputError
from sparsurf.texts import read_text, text_of


def test_every_line_ends_once():
    assert text_of(b"a\r\nb\rc\n\nd\xe5", "x") == "a\nb\nc\n\ndå"


def test_a_byte_order_mark_is_no_text():
    assert text_of("\ufeffx,y".encode(), "x") == "x,y"


def test_packed_texts_are_unpacked_and_bytes_of_zero_are_refused(tmp_path):
    (tmp_path / "a.GZ").write_bytes(gzip.compress(b"a\r\n"))
    assert read_text(tmp_path / "a.GZ") == "a\n"
    with pytest.raises(InputError, match="bytes of zero"):
        text_of(b"a\0", "x")


def test_a_name_with_a_byte_of_zero_is_a_sentence():
    with pytest.raises(InputError, match=r"cannot be read: .*null"):
        read_text("a\0.pdb")
