"""Files from which the readers are fuzzed, and what fuzzing found: read, or refused by one sentence."""

import shutil

import pytest

from fuzz_readers import CORPUS, is_read, readers

READERS = readers()


@pytest.mark.parametrize("kind", READERS)
def test_every_file_is_read_or_refused(tmp_path, kind):
    read, suffix = READERS[kind]
    outcomes = {}
    for path in sorted((CORPUS / kind).iterdir()):
        copied = shutil.copy(path, tmp_path / f"{path.stem}{suffix}")
        outcomes[path.name] = is_read(read, copied)
    seeds = [name for name in outcomes if "." in name]
    assert seeds and all(outcomes[name] for name in seeds) and len(outcomes) > len(seeds)
