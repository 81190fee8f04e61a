"""Predicted models: residues of low pLDDT are left out, and only where the file says that it is a model."""

import numpy as np
import pytest
from gemmi import cif as cif_format

from peptides import atom_line, peptide
from sparsurf import read_molecule
from sparsurf.errors import InputError
from sparsurf.molecules.plddt import (
    EXPERIMENT,
    MODEL,
    PREDICTED,
    doubtful_residues,
    origin_of_mmcif,
    origin_of_pdb,
)
from sparsurf_study.config.check import check_config, proteins

TITLE = "TITLE     ALPHAFOLD MONOMER V2.0 PREDICTION FOR HEMOGLOBIN SUBUNIT ALPHA\nTITLE    2 (P69905)\n"
METRIC = "loop_\n_ma_qa_metric.id\n_ma_qa_metric.name\n_ma_qa_metric.type\n1 {0} {0}\n#\n"
ITEMS = "group_PDB type_symbol label_atom_id label_comp_id label_asym_id label_seq_id Cartn_x Cartn_y Cartn_z B_iso_or_equiv"
SCORES = {1: 35.0, 2: 69.99, 3: 70.0, 4: 95.5}


def pdb(path, head="", scores=SCORES):
    """Write a peptide with the scores of its residues as B factors; return its path."""
    lines = peptide(("ALA", "SER", "VAL", "ALA")).splitlines()
    lines = [f"{line[:60]}{scores[int(line[22:26])]:6.2f}{line[66:]}" for line in lines if line[:4] == "ATOM"]
    path.write_text(head + "\n".join(lines) + "\nEND\n")
    return path


def cif(path, head):
    """Write the same as mmCIF."""
    molecule = read_molecule(pdb(path.with_suffix(".pdb")))
    rows = [
        f"ATOM {element} {name} {residue_name} A {residue} {x:.3f} {y:.3f} {z:.3f} {b}"
        for element, name, residue_name, residue, (x, y, z), b in zip(
            molecule.element, molecule.name, molecule.residue_name, molecule.residue, molecule.xyz[0],
            molecule.b_factor, strict=True,
        )
    ]  # fmt: skip
    items = "".join(f"_atom_site.{item}\n" for item in ITEMS.split())
    path.write_text(f"data_x\n{head}loop_\n{items}" + "\n".join(rows) + "\n#\n")
    return path


@pytest.mark.parametrize("kind", ["pdb", "cif"])
def test_residues_below_the_bound_are_left_out_of_a_model(tmp_path, kind, caplog):
    path = tmp_path / f"a.{kind}"
    pdb(path, TITLE) if kind == "pdb" else cif(path, METRIC.format("pLDDT"))
    whole = read_molecule(path)
    assert whole.masked_residues is None and whole.n_residues == 4
    caplog.clear()
    kept = read_molecule(path, plddt=70)
    assert kept.residue.tolist() == whole.residue[whole.b_factor >= 70].tolist()
    assert set(kept.residue) == {"3", "4"} and kept.masked_residues == 2
    assert caplog.messages[-1:] == [f"{path}: left out 2 of 4 residues, whose pLDDT is below 70"]
    assert read_molecule(path, plddt=0).masked_residues == 0
    with pytest.raises(InputError, match=r"plddt is 0\.7, which looks like a share; .* so give 70"):
        read_molecule(path, plddt=0.7)


@pytest.mark.parametrize(
    "head",
    ["", "MODEL     1\n", "PARENT N/A\n", "REMARK   1 PREDICTED BY BOLTZ-2\n", "EXPDTA    THEORETICAL MODEL, ESMFOLD\n",
     "CRYST1    1.000    1.000    1.000  90.00  90.00  90.00\n"],
)  # fmt: skip
def test_models_of_other_predictors_are_known_by_a_word_or_by_their_b_factors(tmp_path, caplog, head):
    assert set(read_molecule(pdb(tmp_path / "a.pdb", head), plddt=75).residue) == {"4"}
    assert ("they are read as pLDDT" in caplog.text) == (head[:5] in ("", "MODEL", "CRYST"))


def test_a_model_without_plddt_or_without_a_confident_residue_is_refused(tmp_path):
    for scores in ((0, 0, 0, 0), (80, 80, 80, 80), (20, 30, 120, 10)):
        path = pdb(tmp_path / "a.pdb", TITLE, dict(enumerate(scores, 1)))
        assert read_molecule(path).n_residues == 4
        with pytest.raises(InputError, match=r"a.pdb is a predicted model without pLDDT in its B factors"):
            read_molecule(path, plddt=70)
    with pytest.raises(InputError, match="without pLDDT"):
        read_molecule(cif(tmp_path / "a.cif", METRIC.format("QMEANDisCo")), plddt=70)
    with pytest.raises(InputError, match="pLDDT of 96"):
        read_molecule(pdb(tmp_path / "a.pdb", TITLE), plddt=96)


def test_the_mean_of_a_residue_counts():
    b_factor, residue_index = np.array([60.0, 81.0, 60.0, 79.0, 90.0]), np.array([0, 0, 1, 1, 2])
    masked = doubtful_residues(b_factor, residue_index, PREDICTED, 70.0)
    assert masked.tolist() == [False, False, True, True, False]


def asked(*residues, origin="", bound=70.0):
    """Residues that the bound leaves out, of tuples of B factors; None where it is not applied."""
    index = np.repeat(np.arange(len(residues)), [len(each) for each in residues])
    found = doubtful_residues(np.concatenate(residues), index, origin, bound)
    return None if found is None else np.unique(index[found]).tolist()


def test_values_tell_plddt_where_nothing_else_does(caplog):
    """At least three residues, nine of ten with one value for all atoms, which differ, and the largest above 20."""
    low, high, mixed = (60.0, 60.0), (80.0, 80.0), (40.0, 41.0)
    assert asked(low, high, high) == [0] and "all atoms of a residue have the same" in caplog.text
    assert asked(low, high) is asked(low, high, (90.0,)) is asked(high, high, high) is None
    assert asked(low, *8 * [high], mixed) == [0, 9] and asked(low, *7 * [high], mixed) is None
    for largest, found in ((20.0, None), (21.0, [0, 1, 2])):
        assert asked((5.0, 5.0), (6.0, 6.0), (largest, largest)) == found
    assert asked(low, high, (100.5, 100.5)) is asked((-1.0, -1.0), high, high) is None
    caplog.clear()
    assert asked((0.6, 0.7), (0.8, 1.0), (0.65, 0.7)) == [0, 2] and "above 1" in caplog.text
    assert "is on a scale of 0 to 1, and is multiplied by 100" in caplog.text
    assert asked((0.0, 0.0), (1.0, 1.0), (1.0, 1.0)) is None  # flags
    assert asked((0.0, 0.0), high, high) == [0]
    assert asked((1.0, 1.0), (1.5, 1.5), (99.0, 99.0), origin=PREDICTED) == [0, 1]
    assert asked(low, (70.0, 70.0), origin=PREDICTED) == [0]
    assert asked(low, high, high, origin="experiment") is None
    for origin in (PREDICTED, "model"):
        with pytest.raises(InputError, match="without pLDDT"):
            asked(low, high, (101.0, 101.0), origin=origin)
    with pytest.raises(InputError, match="without pLDDT"):
        asked(low, high, high, origin="model")


def test_ligands_do_not_tell_whether_values_are_plddt(tmp_path):
    path = pdb(tmp_path / "a.pdb")
    ligand = [
        f"{atom_line(name, 'LIG', 'A', '9', (20, 0, z), record='HETATM')[:60]}{b:6.2f}\n"
        for name, z, b in (("C1", 0, 75.0), ("O2", 1.4, 80.0))
    ]
    path.write_text(path.read_text().replace("END\n", "".join(ligand) + "END\n"))
    assert set(read_molecule(path, plddt=70, ligands=True).residue) == {"3", "4", "9"}
    assert set(read_molecule(path, plddt=78, ligands=True).residue) == {"4"}


@pytest.mark.parametrize(
    ("lines", "has_box", "origin"),
    [
        ("EXPDTA    SOLUTION NMR", False, EXPERIMENT), ("EXPDTA    NULL", False, ""), ("EXPDTA    THEORETICAL MODEL", False, ""),
        ("EXPDTA    X-RAY DIFFRACTION\nTITLE     ALPHAFOLD", False, EXPERIMENT),
        ("EXPDTA    X-RAY DIFFRACTION\nEXPDTA   2 THEORETICAL MODEL", False, EXPERIMENT),
        ("REMARK   2 RESOLUTION.    1.80 ANGSTROMS.", False, EXPERIMENT), ("REMARK   2", False, ""),
        ("REMARK   3   PROGRAM     : REFMAC", False, EXPERIMENT), ("REMARK 200 EXPERIMENTAL DETAILS", False, EXPERIMENT),
        ("REMARK 215 NMR STUDY", False, EXPERIMENT), ("REMARK 465 MISSING RESIDUES", False, ""),
        ("EXPDTA    THEORETICAL MODEL\nREMARK   3 ALPHAFOLD", False, PREDICTED), ("REMARK 1 PLDDT IN B", True, PREDICTED),
        ("TITLE     MODEL BY SWISS-MODEL", True, MODEL), ("TITLE     I-TASSER", False, MODEL),
        ("TITLE     UBIQUITIN", True, EXPERIMENT),
        ("TITLE     ESMFOLD", True, PREDICTED), ("HEADER    CHAI-1", False, PREDICTED), ("TITLE     CHAI TEA", False, ""),
        ("AUTHOR    ALPHAFOLD", False, ""), ("PARENT 1ABC_A", False, PREDICTED),
    ],
)  # fmt: skip
def test_the_origin_of_a_pdb_file(lines, has_box, origin):
    assert origin_of_pdb(lines.split("\n"), has_box) == origin


@pytest.mark.parametrize(
    ("items", "has_box", "origin"),
    [
        ("_exptl.method 'X-RAY DIFFRACTION'", False, EXPERIMENT), ("_exptl.method 'THEORETICAL MODEL'", False, ""),
        ("_refine.ls_d_res_high 1.8", False, EXPERIMENT),
        ("_exptl.method 'IN SILICO MODEL'\n_refine.ls_d_res_high 1.8", False, ""),
        ("_struct.title 'Boltz-2 model'", False, PREDICTED), ("_software.name MODELLER", True, MODEL),
        ("_entry.id alphafold_1", False, PREDICTED), ("_struct.pdbx_model_details ColabFold", False, PREDICTED),
        ("_ma_qa_metric.name pLDDT", True, PREDICTED), ("_ma_qa_metric.type PLDDT\n_exptl.method NMR", False, PREDICTED),
        ("loop_\n_ma_qa_metric.name\nPAE\npLDDT\nQMEAN", False, PREDICTED),
        ("_ma_qa_metric.name QMEAN", False, MODEL), ("_ma_model_list.model_id 1", False, MODEL),
        ("_entry.id 1ABC", True, EXPERIMENT),
    ],
)  # fmt: skip
def test_the_origin_of_an_mmcif_file(items, has_box, origin):
    assert origin_of_mmcif(cif_format.read_string(f"data_x\n{items}\n").sole_block(), has_box) == origin


def test_the_bound_of_a_study_holds_for_structures_without_one_of_their_own(tmp_path):
    pdb(tmp_path / "a.pdb")
    entry = {"structure": str(tmp_path / "a.pdb")}
    config = check_config({"plddt": 70, "proteins": {"a": entry, "b": entry | {"plddt": 50}}})
    options = {name: protein.molecule_options["plddt"] for name, protein in proteins(config).items()}
    assert options == {"a": 70, "b": 50}
    moving = entry | {"trajectory": str(tmp_path / "a.pdb")}
    assert "plddt" not in check_config({"plddt": 70, "proteins": {"a": moving}})["proteins"]["a"]
    with pytest.raises(InputError, match=r"proteins.a.plddt cannot"):
        check_config({"proteins": {"a": moving | {"plddt": 70}}})
    with pytest.raises(InputError, match="plddt is 101,"):
        check_config({"plddt": 101, "proteins": {"a": entry}})
