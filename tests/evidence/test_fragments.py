"""Table I on other surfaces, and the best combination of each range."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from measures import fragments
from measures.figures import ranges_of
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.combination import PUBLISHED_ROWS, TABLE_1
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf_study.analysis.grid import evaluate_grid


@pytest.fixture(scope="module")
def prepared(blob):
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    return PreparedSurface(surface, Settings(patches={"d_link": 0.8}), streams=Streams(1, "blob"))


@pytest.fixture(scope="module")
def ten(prepared):
    return evaluate_grid(prepared, PUBLISHED_ROWS, 40, 3)


def test_published_values_stand_next_to_ours(ten):
    rows = fragments.rows_table(ten)
    coded = rows[rows["reading"] == "kept"]
    assert coded["d_published"].tolist() == list(TABLE_1["d"]) and coded["row"].tolist() == list(range(1, 11))
    assert np.allclose(coded["d"], (ten.z_tr[0].astype(float) - ten.z_ts[0]).mean(axis=(1, 2)))
    assert (coded["d_inside"] == coded["d_published"].between(coded["d_low"], coded["d_high"])).all()
    table = fragments.table1_of(rows.assign(surface="blob"))
    assert (
        np.allclose(table["Z_blob"], coded["Z"]) and table["d_blob_low"].tolist() == coded["d_low"].tolist()
    )
    inside = fragments.inside_of(rows.assign(surface="blob")).set_index("reading").loc["kept"]
    assert inside["d_inside"] == coded["d_inside"].sum() and inside["rows"] == 10
    assert inside["d_above_0"] == (coded["d_low"] > 0).sum()


def test_the_published_choice_is_compared_with_its_range(ten):
    """A range of one combination has nothing to gain; where another is far better, choosing again gains its lead."""
    percent = 100 * ten.n_s.mean(axis=1) / ten.n_dots
    better = replace(ten, z_ts=ten.z_ts.copy())
    better.z_ts[0, 9] -= 100  # the last row, alone in its range, or the best of it
    choices = fragments.choices_table(better)
    assert len(choices) == 20 and choices["n_S_percent"].to_numpy()[:10] == pytest.approx(percent)
    alone = choices[choices["n_combinations"] == 1]
    assert len(alone) and (alone["gain"] == 0).all() and (alone["may_be_best"] == 1).all()
    last = choices.iloc[9]
    others = choices.iloc[:9][lambda of: of["range"] == last["range"]]
    assert last["rank"] == 1 and last["gain"] == 0 and (others["gain"] > 90).all()
    few = replace(ten, combinations=ten.combinations + 1)
    assert fragments.choices_table(few).empty


def test_ranges_name_the_published_combination():
    ours = pd.DataFrame({"reading": 10 * ["kept"], "n_S_low_percent": 1.0, "n_S_high_percent": 2.0})
    ours = ours.assign(alpha=1.0, beta=0.0, gamma=6.0, delta=4.0, d_cv=1.0, d_cv_low=0.5)
    best_set = ["(1, 0, 6, 4)", *9 * ["(1, 0, 6, 0); (1, 0, 6, 4)"]]
    scaled = {f"d{end}_kept_scaled": -0.5 for end in ("", "_low", "_high")}
    found = ranges_of(ours.assign(d_cv_high=1.5, n_best_set=1, best_set=best_set, **scaled))
    assert found["published"][0] == "(0.4, 0.2, 10, 10)" and (found["best"] == "(1, 0, 6, 4)").all()
    assert found["row"][found["published_may_be_best"] == "yes"].tolist() == [4, 5]


def test_only_rows_that_stay_in_their_range_are_compared():
    """By hand: row 1 falls into range 2 on one surface, where other combinations gain .9 over it, and does not count there."""
    columns = ["surface", "row", "range", "gain", "gain_low", "may_be_best"]
    lines = [
        ["a", 1, 2, 0.9, 0.5, 0],
        ["a", 5, 5, 0.1, -0.1, 1],
        ["b", 1, 1, 0.3, 0.2, 0],
        ["b", 5, 5, 0.0, 0.0, 1],
    ]
    choices = pd.DataFrame(lines, columns=columns).assign(reading="kept", d=1.0, gain_high=1.0)
    choices = choices.assign(n_S_lowest_percent=3.0, n_S_highest_percent=99.0)
    rows = pd.DataFrame({"surface": ["a", "b"]} | {name: 1.0 for name in fragments.OF_SURFACE})
    found = fragments.surfaces_of(rows, choices).set_index("surface")
    counts = found[["n_same_range", "n_may_be_best", "n_worse"]].to_numpy().tolist()
    assert counts == [[1, 1, 0], [2, 1, 1], [3, 2, 1]] and found.index.tolist() == ["a", "b", "all"]
    assert found["gain"].tolist() == pytest.approx([0.1, 0.15, 0.4 / 3])
