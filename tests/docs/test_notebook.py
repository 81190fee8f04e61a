"""The notebook of the first steps: its cells run in their order, and what they compute is right."""

import json

import numpy as np
import pytest

from conftest import ROOT

pytest.importorskip("matplotlib")
pytestmark = pytest.mark.slow


def test_the_cells_run_and_show_what_the_text_says(monkeypatch, capsys):
    """Without Jupyter, which is not a dependency: the code of the cells, one after another."""
    monkeypatch.chdir(ROOT / "docs")
    monkeypatch.setenv("MPLBACKEND", "agg")
    notebook = json.loads((ROOT / "docs" / "first_steps.ipynb").read_text(encoding="utf-8"))
    found = {}
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == [] and cell["execution_count"] is None
            exec("".join(cell["source"]), found)
    dots, few = found["dots"], found["few"]
    assert len(few) < 0.1 * len(dots) and 0 < np.median(found["error"]) < 0.02
    roughest = found["residues"].query("area >= 20").nsmallest(5, "mean_roughness")["residue"]
    printed = capsys.readouterr().out
    assert all(number in printed for number in roughest)
    assert found["over_time"].shape == (found["frames"].n_frames, len(found["residues"]))
    assert found["ax"].get_title().startswith("roughness R")
