"""The table of regions at known sites is what the code of today measures."""

import pandas as pd
import pytest
import yaml

from conftest import ROOT
from measures.regions import regions_at_site
from structures import local_file, read_structures

SETTINGS = yaml.safe_load((ROOT / "evidence" / "config.yaml").read_text(encoding="utf-8"))["regions"]


@pytest.mark.parametrize(("protein", "name", "ligand"), SETTINGS["sites"])
def test_a_known_site_has_the_rows_of_the_table(shared, protein, name, ligand):
    structure = read_structures("evidence/structures.csv")[name]
    path = local_file(structure, str(shared / "data"))
    table = pd.read_csv(ROOT / "evidence" / "tables" / "regions.csv").query("protein == @protein")
    found = regions_at_site(path, ligand, SETTINGS["above"])
    whole_numbers = ["rank", "regions", "of_site", "site_residues", "residues"]
    assert found[whole_numbers].to_numpy().tolist() == table[whole_numbers].to_numpy().tolist()
    assert found["area"].to_numpy() == pytest.approx(table["area"].to_numpy(), rel=0.01)
    assert found["covered"].to_numpy() == pytest.approx(table["covered"].to_numpy(), abs=1e-4)
