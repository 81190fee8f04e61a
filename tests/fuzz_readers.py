"""Coverage-guided fuzzing of the readers: the content of a file is read, or refused by one sentence (`InputError`).

    pip install atheris
    python tests/fuzz_readers.py pdb -max_total_time=600       and mmcif, gro, dms, csv, ply, npz

Further options are libFuzzer's. It starts from tests/corpus/<kind> and keeps what it finds in .cache/fuzz/<kind>. It stops at
another exception, at a file that takes more than a second, and at more than 1 GB of memory; the file is then crash-<digest>.
"""

import logging
import sys
import warnings
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
CORPUS = ROOT / "tests" / "corpus"
LIMITS = ("-timeout=1", "-rss_limit_mb=1024", "-max_len=20000")


def readers():
    """Return the reader and the suffix of each kind of file."""
    from sparsurf.molecules.read_molecule import read_molecule
    from sparsurf.surfaces.read_surface import read_surface

    molecules = {"pdb": ".pdb", "mmcif": ".cif", "gro": ".gro"}
    dots = {kind: f".{kind}" for kind in ("dms", "csv", "ply", "npz")}
    return {kind: (read_molecule, suffix) for kind, suffix in molecules.items()} | {
        kind: (read_surface, suffix) for kind, suffix in dots.items()
    }


def is_read(read, path):
    """Read a file; return whether it is not refused. The sentence of a refusal is one line that a terminal can show."""
    from sparsurf.errors import InputError

    try:
        read(path)
    except InputError as error:
        assert str(error).isprintable()
        return False
    return True


def main(kind, *options):
    """Fuzz the reader of one kind of file."""
    import atheris

    with atheris.instrument_imports(include=["sparsurf"]):
        read, suffix = readers()[kind]
    kept = ROOT / ".cache" / "fuzz" / kind
    kept.mkdir(parents=True, exist_ok=True)
    path = kept.parent / f"{kind}{suffix}"
    logging.disable()
    warnings.simplefilter("ignore")

    def read_content(content):
        path.write_bytes(content)
        is_read(read, path)

    atheris.Setup([sys.argv[0], *LIMITS, *options, str(kept), str(CORPUS / kind)], read_content)
    atheris.Fuzz()


if __name__ == "__main__":
    main(*sys.argv[1:])
