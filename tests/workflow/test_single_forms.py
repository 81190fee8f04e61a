"""Which proteins have a single form for certain, before any frame is read."""

import gzip

import gemmi
import pytest

from peptides import peptide
from sparsurf.molecules.read_molecule import read_molecule
from sparsurf.workflow.config import Protein
from sparsurf.workflow.conformations import file_has_one_model, has_one_model

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


@pytest.mark.parametrize("packed", [False, True])
@pytest.mark.parametrize(("n_models", "single"), [(1, True), (2, False)])
def test_models_of_an_mmcif_file_are_counted_by_their_column(tmp_path, n_models, single, packed):
    structure = gemmi.read_pdb_string("".join(MODEL.format(k + 1) for k in range(n_models)) + "END\n")
    structure.setup_entities()
    content = structure.make_mmcif_document().as_string().encode()
    path = tmp_path / ("m.cif.gz" if packed else "m.cif")
    path.write_bytes(gzip.compress(content) if packed else content)
    assert file_has_one_model(str(path)) == single
    assert (read_molecule(path).n_frames == 1) == single


@pytest.mark.parametrize(
    ("entry", "single"),
    [
        ({}, True),
        ({"trajectory": "frames.xtc"}, False),
        ({"model": 1}, False),
        ({"simulate": {"ns": 1}}, False),
    ],
)
def test_a_protein_that_moves_has_no_single_form_for_certain(tmp_path, entry, single):
    (tmp_path / "a.pdb").write_text(peptide() + "END\n")
    assert has_one_model(Protein(structure=str(tmp_path / "a.pdb"), **entry)) == single
