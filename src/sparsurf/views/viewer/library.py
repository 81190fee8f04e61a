"""3Dmol.js (Rego and Koes, Bioinformatics 31:1322, 2015), the library that draws molecules, as a page carries it."""

from __future__ import annotations

import base64
import zlib
from functools import cache
from pathlib import Path

# 3Dmol-min.js is build/3Dmol-min.js of the npm package `3dmol` in this version
VERSION = "2.5.5"
SHA256_OF_3DMOL = "f7cc78921ae72e7623e89cdd111434f58c2efddd2ffda1cd212644b406fb8016"


@cache
def packed_library() -> str:
    """Return the library, compressed, in base64."""
    text = Path(__file__).with_name("3Dmol-min.js").read_bytes()
    return base64.b64encode(zlib.compress(text, 9)).decode("ascii")


@cache
def notice() -> str:
    """Return the notice of the library's licence, which each copy of it carries."""
    return Path(__file__).with_name("3Dmol.LICENSE").read_text(encoding="utf-8").split("* GLmol")[0].strip()
