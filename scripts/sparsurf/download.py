"""Structures from the network: fetched once, verified, with their checksum on record."""

import hashlib
import json
import urllib.error
import urllib.request
from urllib.parse import urlparse

from sparsurf import InputError

PDB_URL = "https://files.rcsb.org/download/{}.cif.gz"
MOST = 200 * 2**20  # bytes; the largest entries of the PDB have 100 MB
TIMEOUT = 30  # s


def source(protein):
    """URL of a protein of the config: its `url`, or that of its `pdb` id; None for local files."""
    return protein.get("url") or (PDB_URL.format(protein["pdb"].upper()) if "pdb" in protein else None)


def file_name(url):
    """Last part of the path of a URL, with the blanks and brackets of an encoded one as underscores."""
    name = urlparse(url).path.rsplit("/", 1)[-1]
    return "".join(c if c.isalnum() or c in "._-" else "_" for c in name).lstrip(".") or "structure.pdb"


def fetch(url, sha256, path, path_to_record, name):
    """Fetch `url` to `path`; record where it came from, its size and its checksum.

    Parameters
    ----------
    url : str, http or https
    sha256 : str or None, what the file must have
    path, path_to_record : str
    name : str, of the protein, for the sentence

    Raises
    ------
    InputError : no network, no such file, too large, or another checksum
    """
    if urlparse(url).scheme not in ("http", "https"):
        raise InputError(f"proteins.{name}.url is {url!r}, but must start with https:// or http://.")
    try:
        with urllib.request.urlopen(url, timeout=TIMEOUT) as answer:
            content = answer.read(MOST + 1)
    except (urllib.error.URLError, OSError, ValueError) as error:
        reason = getattr(error, "reason", error)
        raise InputError(
            f"{name} cannot be fetched from {url} ({reason}); get the file by hand and give its path as "
            f"proteins.{name}.structure or in the environment variable {variable(name)}."
        ) from None
    if len(content) > MOST:
        raise InputError(f"{name}: the file at {url} is larger than {MOST // 2**20} MB.")
    found = hashlib.sha256(content).hexdigest()
    if sha256 and found != sha256.lower():
        raise InputError(
            f"{name}: the file at {url} has the sha256 {found}, not {sha256}; it is not what the study is about."
        )
    with open(path, "wb") as stream:
        stream.write(content)
    with open(path_to_record, "w", encoding="utf-8") as stream:
        json.dump({"url": url, "bytes": len(content), "sha256": found}, stream, indent=2)
        stream.write("\n")


def variable(name):
    """Environment variable that gives a local file instead: SPARSURF_<NAME>."""
    return "SPARSURF_" + "".join(c if c.isalnum() else "_" for c in name).upper()
