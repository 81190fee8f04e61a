"""Structures from the network: fetched once, verified, with their checksum on record."""

import hashlib
import json
import re
import signal
import urllib.error
import urllib.request
from collections.abc import Iterator
from contextlib import contextmanager
from http.client import HTTPException
from typing import Any
from urllib.parse import ParseResult, urlparse

from sparsurf.errors import InputError
from sparsurf.files import shorten

MOST = 200 * 2**20  # bytes; the largest entries of the PDB have 100 MB
TIMEOUT = 30  # s without a byte
MAX_SECONDS = 600  # A whole download may take so long.
MAX_NAME_LENGTH = 120  # characters of a file's name; file systems take 255 bytes, and jobs add to it
ONLY = "only complete https:// URLs without a password are fetched, or http:// if a sha256 is given"


def allowed(url: str, sha256: str | None) -> bool:
    """Return whether a URL may be fetched: over http only if the checksum is known, and without a password, as it is recorded."""
    parts = _parsed(url)
    safe = parts.scheme == "https" or (parts.scheme == "http" and bool(sha256))
    return bool(parts.hostname) and "@" not in parts.netloc and safe


def shown(url: str) -> str:
    """Return a URL with *** in place of a user and a password."""
    return re.sub(r"(?<=//)[^/?#]*@", "***@", url)


def _parsed(url: str) -> ParseResult:
    """Return the parts of a URL; those of an empty one if it is invalid."""
    try:
        parts = urlparse(url)
        return parts if parts.port != 0 else urlparse("")
    except ValueError:
        return urlparse("")


class _Redirects(urllib.request.HTTPRedirectHandler):
    """Follow a redirect only to a URL that may be fetched."""

    def __init__(self, sha256: str | None) -> None:
        self.sha256 = sha256

    def redirect_request(
        self, request: Any, stream: Any, code: int, message: str, headers: Any, url: str
    ) -> Any:
        if not allowed(url, self.sha256):
            raise InputError(f"it leads to {shorten(shown(url))}, but {ONLY}")
        return super().redirect_request(request, stream, code, message, headers, url)


def file_name(url: str) -> str:
    """Return the last part of the path of a URL, at most MAX_NAME_LENGTH characters, with underscores for special ones."""
    name = _parsed(url).path.rsplit("/", 1)[-1]
    name = re.sub(r"[^A-Za-z0-9._-]", "_", name).lstrip(".")
    return name[-MAX_NAME_LENGTH:].lstrip(".") or "structure.pdb"  # the end has the suffix


@contextmanager
def _at_most(seconds: float) -> Iterator[None]:
    """Raise TimeoutError in what takes longer, also while a server sends a byte now and then."""

    def stop(*_: object) -> None:
        raise TimeoutError(f"it took more than {seconds:g} s")

    before = signal.signal(signal.SIGALRM, stop)
    signal.setitimer(signal.ITIMER_REAL, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_REAL, 0)
        signal.signal(signal.SIGALRM, before)


def fetch(url: str, sha256: str | None, path: str, path_to_record: str, name: str) -> None:
    """Fetch `url` (https, or http with a checksum) of a protein to `path`; record its origin, its size and its checksum."""
    if not allowed(url, sha256):
        raise InputError(f"proteins.{name}.url is {shorten(repr(shown(url)))}, but {ONLY}.")
    try:
        with (
            _at_most(MAX_SECONDS),
            urllib.request.build_opener(_Redirects(sha256)).open(url, timeout=TIMEOUT) as answer,
        ):
            content, promised = answer.read(MOST + 1), int(answer.headers.get("Content-Length", 0))
        # urllib returns what arrived before a connection broke as if it were the whole file
        if len(content) < min(promised, MOST):
            raise OSError(f"{len(content)} of {promised} bytes came")
    except (urllib.error.URLError, HTTPException, OSError, ValueError) as error:
        reason = getattr(error, "reason", error)
        raise InputError(
            f"{name} cannot be fetched from {shorten(url)} ({reason}); get the file by hand and give its path as "
            f"proteins.{name}.structure or in the environment variable {variable(name)}."
        ) from None
    if len(content) > MOST:
        raise InputError(f"{name}: the file at {shorten(url)} is larger than {MOST // 2**20} MB.")
    checksum = hashlib.sha256(content).hexdigest()
    if sha256 and checksum != sha256.lower():
        raise InputError(
            f"{name}: the file at {shorten(url)} has the sha256 {checksum}, not {sha256}; it is not the file of the study."
        )
    with open(path, "wb") as stream:
        stream.write(content)
    with open(path_to_record, "w", encoding="utf-8") as stream:
        json.dump({"url": url, "bytes": len(content), "sha256": checksum}, stream, indent=2)
        stream.write("\n")


def variable(name: str) -> str:
    """Return the environment variable that may name a local file instead: SPARSURF_<NAME>."""
    return "SPARSURF_" + "".join(c if c.isalnum() else "_" for c in name).upper()
