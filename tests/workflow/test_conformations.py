"""Conformations that a config names."""

import gzip

import pytest

from peptides import peptide
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.workflow.conformations import file_has_one_model

MODEL = "MODEL     {}\n" + peptide() + "ENDMDL\n"


@pytest.mark.parametrize(
    ("content", "single"),
    [
        (peptide() + "END\n", True),
        (MODEL.format(1) + "END\n", True),
        (MODEL.format(1) + MODEL.format(2) + "END\n", False),
        (peptide() + "END\n" + peptide() + "END\n", False),
    ],
)
def test_models_of_a_file_are_counted_packed_or_not(tmp_path, content, single):
    (tmp_path / "plain.pdb").write_text(content)
    (tmp_path / "packed.pdb.gz").write_bytes(gzip.compress(content.encode()))
    for name in ("plain.pdb", "packed.pdb.gz"):
        assert file_has_one_model(str(tmp_path / name)) == single
        assert (read_molecule(tmp_path / name).n_frames == 1) == single


def test_a_packed_file_that_is_torn_is_looked_at_by_the_rule_that_reads_it(tmp_path):
    (path := tmp_path / "torn.pdb.gz").write_bytes(gzip.compress(peptide().encode())[:-20])
    assert not file_has_one_model(str(path))
