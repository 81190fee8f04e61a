"""docs/descriptors.md is what its tables say."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from drawn import drawn_texts
from sparsurf.report.descriptors_page import TABLES, descriptors_markdown, enough
from sparsurf.report.figures import descriptors_figures

STORED = {key: pd.read_csv(ROOT / "docs" / "tables" / f"descriptors_{key}.csv") for key in TABLES}


def test_the_page_is_rendered_from_the_stored_tables():
    assert descriptors_markdown(STORED) == (ROOT / "docs" / "descriptors.md").read_text(encoding="utf-8")


def test_enough_is_where_the_error_last_crosses_the_floor():
    rows = pd.DataFrame({"n_S_percent": [5.0, 10, 20, 40], "Z": [2.0, 0.5, 2.0, 0.5]})
    assert enough(rows, 1.0) == pytest.approx(20 * np.sqrt(2))
    assert enough(rows, 0.4) is None
    assert enough(rows, 3.0) == 5


@pytest.mark.parametrize("draw", [descriptors_figures.steadiness, descriptors_figures.samplers])
def test_no_texts_of_a_figure_overlap(draw, monkeypatch):
    boxes = drawn_texts(draw(STORED), monkeypatch)
    for k, (words, box) in enumerate(boxes):
        for other, second in boxes[:k]:
            assert not box.overlaps(second), (words, other)
