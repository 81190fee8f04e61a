"""What the evidence is planned by: its structures, from a folder or the network, and the digests that date its tables."""

import csv
import gzip
import hashlib
import os
from collections import defaultdict
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from sparsurf import InputError
from sparsurf.workflow.code_digests import digest
from sparsurf.workflow.yaml_file import read_config

HOME = Path(__file__).resolve().parents[1]
WRITTEN = ("weights", "unrelated")  # keys of the config for files of the library that chains write
# What reads and writes files: its results count, see read_structures.py, not its code
READING = tuple(
    f"/molecules/{name}.py"
    for name in (
        "atom_table",
        "formats",
        "mdtraj_process",
        "mmcif",
        "pdb",
        "read_molecule",
        "trajectory",
        "unwrapping",
    )
) + tuple(f"/surfaces/formats/{name}.py" for name in ("compact", "csv", "dms", "ply", "vtp"))
SHOWING = "/report/"  # pages and figures: they count for chains that have figures
READ = HOME / "evidence" / "tables" / "structures_read.csv"


@dataclass(frozen=True)
class Structure:
    """A row of structures.csv.

    Attributes
    ----------
    name : str
    file : str, from the folder of structures, or from here
    url : str, where it is fetched from; empty where it is published nowhere by itself
    sha256 : str, of what the URL holds: of the content where only `file` is compressed
    sets : tuple of str, the chains that it takes part in
    """

    name: str
    file: str
    url: str
    sha256: str
    sets: tuple

    def local(self, folder):
        """The file in `folder` or here, or None.

        Raises
        ------
        InputError : it is not what was measured
        """
        path = next((p for p in (HOME / self.file, Path(folder or HOME) / self.file) if p.is_file()), None)
        if path is not None and self.sha256 not in _checksums(path):
            raise InputError(f"{path} differs from the structure in evidence/structures.csv: replace it.")
        return path


def _checksums(path):
    content = path.read_bytes()
    packed = path.suffix == ".gz"
    return {
        hashlib.sha256(each).hexdigest()
        for each in (content, *([gzip.decompress(content)] if packed else []))
    }


def structures(path):
    """The structures of a table by name."""
    with open(HOME / path, encoding="utf-8", newline="") as stream:
        rows = [row | {"sets": tuple(row["sets"].split())} for row in csv.DictReader(stream)]
    return {row["name"]: Structure(**row) for row in rows}


class Source:
    """Where structures come from: a folder, else the network.

    Parameters
    ----------
    table : str, path of their table from here
    folder : str or None, $EVIDENCE_DATA
    fetched : str, folder for those from the network
    """

    def __init__(self, table, folder, fetched):
        self.folder, self.fetched, self.known = folder, fetched, structures(table)

    @property
    def downloads(self):
        """The structures that the network has, by the name of their file."""
        return {os.path.basename(each.url): each for each in self.known.values() if each.url}

    @property
    def sets(self):
        """Names of the structures of each set, in the order of the table; a set that is not there is empty."""
        found = defaultdict(list)
        for each in self.known.values():
            for name in each.sets:
                found[name].append(each.name)
        return found

    def path(self, name):
        """The file of a structure, which a rule fetches where it is not there."""
        own = self.known[name]
        return str(own.local(self.folder) or f"{self.fetched}/{os.path.basename(own.url) or own.file}")

    def protein(self, name, **more):
        """The entry of a structure in the config of a study."""
        local, own = self.known[name].local(self.folder), self.known[name]
        return ({"structure": str(local)} if local else {"url": own.url, "sha256": own.sha256}) | more


def study_file(path, name, prefix, source):
    """Config of a study in a file, its results in a folder of the evidence; its proteins from the structures by name."""
    config = read_config(HOME / path) | {"run": f"{prefix}_{name}"}
    known = {
        key: source.protein(key) if key in source.known else own for key, own in config["proteins"].items()
    }
    return config | {"proteins": known}


def revisions(path):
    """How often what is read from structures has changed: the sum of a column of the table `READ`."""
    if not Path(path).is_file():
        return 0
    with open(path, encoding="utf-8", newline="") as stream:
        return sum(int(row["revision"]) for row in csv.DictReader(stream))


def _beside(script):
    """Path of a script of this folder from scripts/."""
    return f"../evidence/{script}"


def pairs(known):
    """The complexes and their two structures: 1a1u, those known bound, then those of which both forms are known.

    An unbound form is called NAME_u.
    """
    bound, both = (
        [name.split("_")[0] for name, each in known.items() if name.endswith("_r") and kind in each.sets]
        for kind in ("bound", "unbound")
    )
    found = {name: (f"{name}_r", f"{name}_l") for name in bound}
    for name in both:
        found |= {name: (f"{name}_r", f"{name}_l"), f"{name}_u": (f"{name}_r_u", f"{name}_l_u")}
    return ({"1a1u": ("1a1u_A", "1a1u_C")} if "1a1u_A" in known else {}) | found


class Chain(NamedTuple):
    """One chain: its mark, an empty file whose name tells code and settings, the digest of its code, its files by name."""

    mark: str
    code: str
    tables: dict
    figures: dict

    @property
    def files(self):
        """All of them."""
        return [self.mark, *self.tables.values(), *self.figures.values()]


class Chains:
    """The chains of a Snakefile.

    A table that was made by other code or other settings lacks the mark of today's: it counts as missing. Code that reads
    structures has a chain of its own; the others count as older only once it has read something else, as the table `READ` tells.

    Parameters
    ----------
    config : dict, with the folders `tables` and `figures`
    read : path of the table
    """

    def __init__(self, config, read=READ):
        self.config, self.known, self.revisions = config, {}, revisions(read)
        self.written = tuple(os.path.basename(config[key]) for key in WRITTEN if key in config)

    def add(self, name, settings, scripts, tables=(), figures=(), of=(), reads=False):
        """A chain, which is asked for.

        Parameters
        ----------
        settings : dict, what it goes by
        scripts : sequence of str, in this folder; "../scripts/x.py" for one of a study
        tables, figures : names of the files it makes
        of : chains that it draws
        reads : whether it makes the table `READ`, and goes by the code that reads structures
        """
        code = (
            digest(*map(_beside, scripts))
            if reads
            else self.code(*scripts, but=() if figures else (SHOWING,))
        )
        text = f"{code} {sorted(settings.items())} {[chain.mark for chain in of]}"
        mark = f"{self.config['tables']}/made/{name}-{hashlib.sha256(text.encode()).hexdigest()[:16]}"
        self.known[name] = Chain(
            mark,
            code,
            {each: f"{self.config['tables']}/{each}.csv" for each in tables},
            {each: f"{self.config['figures']}/{each}.png" for each in figures},
        )
        return self.known[name]

    def code(self, *scripts, but=()):
        """Digest of the code behind scripts of this folder, with how often structures were read as something else."""
        return f"{digest(*map(_beside, scripts), but=(*self.written, *READING, *but))}-{self.revisions}"

    def made_by(self, script, settings=None):
        """Params of a rule: `settings`, where it goes by any, and the digest of its code."""
        return ({"settings": settings} if settings is not None else {}) | {"code": self.code(script)}

    def files(self):
        """Every file of every chain."""
        return [file for chain in self.known.values() for file in chain.files]

    def old(self):
        """Names of the chains whose files are missing or were made by other code or settings."""
        return [name for name, chain in self.known.items() if not all(map(os.path.exists, chain.files))]

    def forget_old(self):
        """Remove the marks that nothing has any more."""
        marks = {Path(chain.mark) for chain in self.known.values()}
        for path in Path(self.config["tables"], "made").glob("*"):
            if path not in marks:
                path.unlink()
