"""The comparison with the paper: agreement, bias and sentences from made-up numbers, and a run on a small surface."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from sparsurf import paper, tables
from sparsurf.evaluation import PUBLISHED_ROWS, Evaluator
from sparsurf.verdict import as_html, rough_and_flat, verdict


def replicated(shift=0.0, sd=0.1, n=40):
    """Replicates around the published values, shifted."""
    rng = np.random.default_rng(0)
    table = paper.published_table()
    middle = (table["n_S_low_percent"] + table["n_S_high_percent"]) / 2
    return {
        "n_S_percent": np.tile(middle, (n, 1)),
        "d": table["d"].to_numpy() + shift + sd * rng.normal(size=(n, 10)),
        "Z_tS": table["Z_tS"].to_numpy() - shift + sd * rng.normal(size=(n, 10)),
    }


def rows(shift=0.0, bias=0.0):
    biases = pd.DataFrame({"d_bias": np.full(10, bias), "Z_tS_bias": np.full(10, -bias)})
    truth = {f"{name}_{r}": np.zeros(10) for name in ("d", "Z_tS") for r in ("kept", "surface")}
    return paper.rows_table(replicated(shift), biases, truth)


def test_equal_values_agree():
    table = rows()
    assert table["n_S_agrees"].all() and table["d_agrees"].all() and table["Z_tS_agrees"].all()


def test_values_five_deviations_away_do_not():
    table = rows(shift=-0.5)
    assert not table["d_agrees"].any() and not table["Z_tS_agrees"].any()


def test_selection_bias_makes_the_interval_longer_on_its_side_only():
    # the published d is the best of many noisy ones: ours may lie lower by the bias, not higher
    assert rows(shift=-0.5, bias=0.5)["d_agrees"].all()
    assert not rows(shift=0.5, bias=0.5)["d_agrees"].any()


def test_bias_is_the_winner_minus_its_true_value():
    winners = pd.DataFrame(PUBLISHED_ROWS, columns=tables.PARAMETERS).assign(d=2.0, Z_tS=3.0)
    truth = pd.DataFrame(PUBLISHED_ROWS, columns=tables.PARAMETERS).assign(d_kept=1.5, Z_tS_kept=3.25)
    bias = paper.selection_bias([winners, winners], truth)
    assert np.allclose(bias["d_bias"], 0.5) and np.allclose(bias["Z_tS_bias"], -0.25)


def test_rough_and_flat_bins():
    r = np.array([0.0, 0.05, 0.95, 1.0])
    bins = rough_and_flat(r, {"kept": (np.zeros(4), np.array([1.0, 3.0, 5.0, 7.0]))}, bins=2)
    assert bins["n"].tolist() == [2, 2]
    assert bins["d_kept"].tolist() == [2.0, 6.0]


@pytest.fixture(scope="module")
def page(blob):
    """Data of a verdict on a small surface, everything but the published values computed."""
    surface = SimpleNamespace(points=blob[0], normals=blob[1])
    own = {"d_link": 0.8, "seed": 1, "name": "blob"}
    evaluator = Evaluator(surface, **own)
    grid = evaluator.grid(PUBLISHED_ROWS, 40, 2)
    table = tables.grid_table(grid)
    selected = paper.as_published(evaluator, PUBLISHED_ROWS, 2)
    best = tables.best(table, grid, 20)
    return {
        "grid": table,
        "ranges": tables.ranges_table(table, grid),
        "best": best,
        "rows": paper.rows_table(
            paper.replicate_rows(evaluator, 3),
            paper.selection_bias(selected, table),
            paper.rows_with_shared_tests(evaluator, 20, 2),
        ),
        "links": paper.sweep_links(surface, (0.8, 1.2), 20, 1, **own),
        "defects": paper.compare_defects(surface, 20, 1, **own),
        "selected": selected,
        "bins": rough_and_flat(*paper.by_roughness(evaluator, best, 600)),
        "uniform": {"median": 3.0},
        "surface": paper.surface_sentence(evaluator, "a blob"),
    }


FILES = {
    key: f"{key}.csv" for key in ("grid", "ranges", "best", "rows", "links", "defects", "selected", "bins")
}


def test_every_claim_has_numbers_and_a_file(page):
    text = verdict(page, FILES)
    for heading in text.split("\n## ")[1:]:
        assert any(c.isdigit() for c in heading)
        assert ".csv`" in heading, heading.splitlines()[0]
    assert "a blob; N = 3000 dots" in text
    assert as_html(text).count("<h2>") == text.count("\n## ")


def test_sentences_change_when_numbers_do(page):
    text = verdict(page, FILES)
    turned = page["grid"].assign(d_kept=-page["grid"]["d_kept"])
    other = verdict(page | {"grid": turned}, FILES)
    assert text != other
    flipped = page["bins"].assign(d_kept=-page["bins"]["d_kept"])
    assert verdict(page | {"bins": flipped}, FILES) != text


def test_links_keep_the_samplings_and_change_the_islands(page):
    links = page["links"].set_index(["D_link", "row"])
    assert np.allclose(links.loc[0.8]["n_S_percent"], links.loc[1.2]["n_S_percent"])
    assert (links.loc[1.2]["fragment"] >= links.loc[0.8]["fragment"]).all()


def test_one_draw_per_dot_keeps_fewer(page):
    percent = page["defects"].pivot(index="row", columns="sampling", values="n_S_percent")
    assert (percent["one draw per dot"] <= percent["as published"] + 1e-9).all()
