"""Table I on other surfaces, the numbers of the paper's figures, and the cost of few dots."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from measures import fragments, thinned_costs
from sparsurf.pairs.partners import partner_of
from sparsurf.sampling.combination import PUBLISHED_ROWS, TABLE_1
from sparsurf.study.grid import evaluate_grid
from sparsurf.study.prepared_surface import PreparedSurface
from sparsurf.surfaces.surface import Surface
from tabulate_figures import ranges_of
from tabulate_fragments import inside_of, surfaces_of, table1_of


@pytest.fixture(scope="module")
def prepared(blob):
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    return PreparedSurface(surface, d_link=0.8, seed=1, name="blob")


@pytest.fixture(scope="module")
def ten(prepared):
    return evaluate_grid(prepared, PUBLISHED_ROWS, 40, 3)


def test_published_values_stand_next_to_ours(ten):
    rows = fragments.rows_table(ten)
    coded = rows[rows["reading"] == "as_coded"]
    assert coded["d_published"].tolist() == list(TABLE_1["d"]) and coded["row"].tolist() == list(range(1, 11))
    assert np.allclose(coded["d"], (ten.z_tr[0].astype(float) - ten.z_ts[0]).mean(axis=(1, 2)))
    assert (coded["d_inside"] == coded["d_published"].between(coded["d_low"], coded["d_high"])).all()
    table = table1_of(rows.assign(surface="blob"))
    assert (
        np.allclose(table["Z_blob"], coded["Z"]) and table["d_blob_low"].tolist() == coded["d_low"].tolist()
    )
    inside = inside_of(rows.assign(surface="blob")).set_index("reading").loc["as_coded"]
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


def test_a_surface_is_summed_up_over_its_rows():
    rows = pd.DataFrame({"surface": ["A", "A"], "reading": "as_coded", "dots": 7, "centres": 3})
    rows = rows.assign(mean_roughness=0.6, lowest_roughness=0.1, highest_roughness=0.9)
    choices = pd.DataFrame({"row": [4, 5], "range": [4, 6], "gain": [0.1, 0.3], "gain_low": [-0.1, 0.2]})
    choices = choices.assign(surface="A", reading="as_coded", gain_high=0.5, d=[1.0, 2.0], may_be_best=[1, 0])
    found = surfaces_of(rows, choices.assign(n_S_lowest_percent=2.0, n_S_highest_percent=99.0)).iloc[0]
    assert (found["n_may_be_best"], found["n_worse"], found["n_same_range"], found["dots"]) == (1, 1, 1, 7)
    assert found["gain"] == pytest.approx(0.2) and (found["largest_gain"], found["d_best"]) == (0.3, 2.0)


def test_ranges_name_the_published_combination():
    ours = pd.DataFrame({"reading": 10 * ["as_coded"], "n_S_low_percent": 1.0, "n_S_high_percent": 2.0})
    ours = ours.assign(alpha=1.0, beta=0.0, gamma=6.0, delta=4.0, d_cv=1.0, d_cv_low=0.5)
    best_set = ["(1, 0, 6, 4)", *9 * ["(1, 0, 6, 0); (1, 0, 6, 4)"]]
    found = ranges_of(ours.assign(d_cv_high=1.5, n_best_set=1, best_set=best_set))
    assert found["published"][0] == "(0.4, 0.2, 10, 10)" and (found["best"] == "(1, 0, 6, 4)").all()
    assert found["row"][found["published_may_be_best"] == "yes"].tolist() == [4, 5]


def test_few_dots_cost_less_and_err_more(blob):
    surface = Surface(0.6 * blob[0], blob[1])  # dots near enough for the published D_link
    pair = [partner_of(surface, name=name) for name in "ab"]
    table = thinned_costs.measure(surface, pair, [10, 50, 100], ["farthest"], 1).set_index("percent")
    assert table["sampler"].tolist() == ["farthest", "farthest", "all dots"]
    assert table["n_S_percent"].tolist() == [10, 50, 100]
    whole = table.loc[100]
    assert (whole["roughness_error"], whole["Z"]) == (0, 0) and whole["map_correlation"] == pytest.approx(1)
    assert table.loc[10, "Z"] > table.loc[50, "Z"] > 0
    assert table.loc[10, "roughness_error"] > table.loc[50, "roughness_error"] > 0
    assert table["map_times_less"].to_numpy() == pytest.approx(
        whole["map_seconds"] / table["map_seconds"].to_numpy()
    )


def test_the_cost_of_a_call_is_its_time_and_the_memory_that_it_adds():
    result, cost = thinned_costs.cost(lambda: len(np.ones(25_000_000)), 2)
    assert result == 25_000_000 and cost.seconds > 0
    assert np.isnan(cost.megabytes) or cost.megabytes == pytest.approx(191, abs=20)  # 200 million bytes


def test_memory_is_not_reported_where_the_system_ignores_the_reset_of_its_peak(monkeypatch, tmp_path):
    monkeypatch.setattr(thinned_costs, "CLEAR_REFS", tmp_path / "ignored")
    in_use = int(thinned_costs.STATM.read_text().split()[1]) * thinned_costs.resource.getpagesize()
    monkeypatch.setattr(thinned_costs, "peak_memory", lambda: in_use + 30 * 2**20)
    assert np.isnan(thinned_costs.cost(lambda: None, 1)[1].megabytes)
