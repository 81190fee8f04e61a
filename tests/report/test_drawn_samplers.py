"""The figures over samplers and proteins show the numbers of their tables: lines, bars, labels and colours."""

import numpy as np
import pandas as pd
import pytest

from conftest import ROOT
from drawn import bars_of, check_texts, colour_of, legend_of, words_of
from measures import protein_figures
from sparsurf.pairs.ranking import means_over_pairs
from sparsurf.recovery.readings import READINGS
from sparsurf.report.figures import comparison_figure, layout
from sparsurf.report.figures.pair_figures import over_pairs

TABLES = ROOT / "evidence" / "tables"
BLUE, BLACK, VERMILLION, INDIGO = "#0072B2", "#000000", "#D55E00", "#332288"
FACTORS = {"farthest": 1.0, "uniform": 1.25, "paper": 1.6, "mine": 2.0}
COLOURS = {"farthest": BLUE, "uniform": BLACK, "paper": VERMILLION, "mine": INDIGO}
PERCENTS = (5.0, 10.0, 20.0, 40.0)
MEASURES = ["Z full", "Z kept_scaled", "Z kept", "Z recovered", "Z centres", "position", "normal"]


def comparison(factors=FACTORS):
    """Z falls with the square root of n_S; each measure and sampler by a factor of its own."""
    rows = [
        (name, p, p, measure, (1 + k / 10) * factor * 10 / np.sqrt(p))
        for k, measure in enumerate(MEASURES)
        for name, factor in factors.items()
        for p in PERCENTS
    ]
    table = pd.DataFrame(rows, columns=["sampler", "percent", "n_S_percent", "measure", "value"])
    table = table.assign(low=table["value"] - 0.1, high=table["value"] + 0.2, use="surface")
    return table.assign(Z_mean_descriptor=3.5, Z_empty=9.0, Z_resampled=0.4)


def test_samplers_are_drawn_as_measured():
    table = comparison(FACTORS | {"poisson": 1.2})
    figure = comparison_figure.comparison_figure(table, "q/c1", "95 % of something")
    (ax,) = figure.axes
    own = table[table["measure"] == "Z full"]
    names = [*FACTORS, "poisson"]
    for line, name in zip(ax.lines, names, strict=False):
        wanted = own.loc[own["sampler"] == name, ["n_S_percent", "value"]]
        np.testing.assert_allclose(line.get_xydata(), wanted)
        assert colour_of(line) == COLOURS.get(name, colour_of(line))
    bands = [collection.get_paths()[0].vertices for collection in ax.collections]
    for name, band in zip(("farthest", "uniform", "paper"), bands, strict=True):  # of the bold lines only
        first = own[own["sampler"] == name].iloc[0]
        at = band[np.isclose(band[:, 0], first["n_S_percent"])][:, 1]
        assert (at.min(), at.max()) == pytest.approx((first["low"], first["high"]))
    assert [line.get_ydata()[0] for line in ax.lines[len(names) :]] == pytest.approx([3.5, 0.4])
    assert ax.get_ylim()[0] == 0 and ax.get_ylim()[1] >= own["high"].max() and ax.get_xscale() == "log"
    assert [t.get_text() for t in ax.get_xticklabels()] == ["5", "10", "20", "40"]
    assert (ax.get_xlabel(), ax.get_ylabel()) == (
        "dots kept (% of the surface)",
        "error Z of the descriptors (0: none)",
    )
    assert words_of(figure)[0] == "q/c1: farthest point errs least"
    assert figure.legends[0].get_title().get_text() == "Shaded, of the bold lines: 95 % of something."
    entries = legend_of(figure)
    assert entries[:4] == [
        ("farthest point", BLUE), ("uniform subset", BLACK), ("paper's sampling", VERMILLION), ("mine", INDIGO),
    ]  # fmt: skip
    assert [words for words, _ in entries[5:]] == [
        "mean descriptor for every patch: 3.50", "fresh dots of the surface: 0.40",
    ]  # fmt: skip


def test_the_title_names_the_lowest_mean_not_the_lowest_value():
    whole = comparison()
    uniform = (whole["sampler"] == "uniform").to_numpy()
    once = whole.assign(value=np.where(uniform, np.where(whole["percent"] == 40, 0.01, 50.0), whole["value"]))
    words = words_of(comparison_figure.comparison_figure(once, "q/c1"))
    assert words[0] == "q/c1: farthest point errs least"


def test_an_arrow_says_how_many_times_fewer_dots():
    ax = comparison_figure.comparison_figure(comparison(), "q").axes[0]
    (said,) = [t for t in ax.texts if t.get_text().startswith("same Z")]
    z = 1.6 * 10 / np.sqrt(20)
    assert said.get_text() == "same Z:\n2.6 times\nfewer dots"
    assert said.xy == pytest.approx((20, z))
    (arrow,) = [t for t in ax.texts if t.get_text() == "" and t.xy[1] == pytest.approx(z) and t.xy[0] != 40]
    assert arrow.xy == pytest.approx((20 / 2.56, z)) and arrow.get_position() == pytest.approx((20, z))
    last = comparison().query("percent in (5, 20)")  # not at the right end
    texts = comparison_figure.comparison_figure(last, "q").axes[0].texts
    assert not [t for t in texts if t.get_text().startswith("same Z")]
    worse = {"farthest": 1.1, "uniform": 1.25, "paper": 1.0}
    # its fewest dots are better already: only a bound is known
    bound = {"farthest": 0.2, "uniform": 1.0, "paper": 1.6}
    for factors in (worse, bound):
        texts = comparison_figure.comparison_figure(comparison(factors), "q").axes[0].texts
        assert not [t for t in texts if t.get_text().startswith("same Z")]


def test_no_text_lies_on_another_where_the_arrow_is_as_high_as_the_reference(monkeypatch):
    percents = comparison()["percent"].replace({5.0: 2.5, 40.0: 60.0})  # little room right of the arrow
    table = comparison().assign(percent=percents, n_S_percent=percents, Z_empty=90.0)
    check_texts(comparison_figure.comparison_figure(table, "q"), monkeypatch)


@pytest.fixture(scope="module")
def stored():
    paths = [*TABLES.glob("proteins_*.csv"), *TABLES.glob("proteins_*.csv.gz")]
    return {path.name.split(".")[0].removeprefix("proteins_"): pd.read_csv(path) for path in paths}


def of_reading(table, reading):
    return table[table["reading"] == reading]


def test_d_over_proteins_is_that_of_the_table(stored):
    figure = protein_figures.d(stored)
    words = [READINGS["kept"].words, READINGS["full"].words, "recovered, a quarter of the grid"]
    assert [w for w in words_of(figure) if len(w) > 1] == words
    assert [ax.get_ylabel() for ax in figure.axes] == ["cross-validated d", "", ""]
    colours = dict(kept=VERMILLION, full=BLUE, recovered=layout.PALETTE[2])
    for ax, (reading, colour) in zip(figure.axes, colours.items(), strict=True):
        rows = stored["recovered"] if reading == "recovered" else of_reading(stored["d"], reading)
        rows = rows[rows["range"] > 0]
        bars = bars_of(ax.containers[0])
        np.testing.assert_allclose(bars, rows[["n_S_percent", "own", "own_low", "own_high"]])
        assert colour_of(ax.containers[0][0]) == colour
        each = of_reading(stored["summary"], reading).dropna(subset="d_cv")
        assert each.empty == (reading == "recovered")
        if len(each):
            np.testing.assert_array_equal(ax.lines[0].get_xydata(), each[["n_S_percent", "d_cv"]])
        choice = [line for line in ax.lines if line.get_marker() == "_" and colour_of(line) == BLACK]
        wanted = rows[["n_S_percent", "from_all"]]
        assert any(np.array_equal(line.get_xydata(), wanted) for line in choice)
    labels = [text for text, _ in legend_of(figure)]
    assert set(labels) == {"one protein", "own best, mean (95 %)", "choice of all others, mean"}


def test_z_over_proteins_is_that_of_the_table(stored):
    figure, table = protein_figures.needed(stored), stored["by_n_s"]
    floors = {"fresh dots": "Z_resampled", "turned": "Z_turned", "atoms moved 0.3 Å": "Z_atoms_moved_0.3_Å"}
    floors = {words: stored["surfaces"][column].mean() for words, column in floors.items()}
    for ax, islands in zip(figure.axes, ("full", "recovered"), strict=True):
        own = of_reading(table, islands)
        names = list(own["sampler"].unique())
        for line, band, name in zip(ax.lines, ax.collections, names, strict=False):
            rows = own[own["sampler"] == name]
            np.testing.assert_array_equal(line.get_xydata(), rows[["percent", "Z"]])
            assert colour_of(line) == COLOURS.get(name, colour_of(line))
            last = band.get_paths()[0].vertices
            last = last[last[:, 0] == rows["percent"].max()][:, 1]
            assert (last.min(), last.max()) == pytest.approx(tuple(rows.iloc[-1][["Z_low", "Z_high"]]))
        assert [line.get_ydata()[0] for line in ax.lines[len(names) :]] == list(floors.values())
    assert {t.get_text(): t.xy[1] for t in figure.axes[0].texts} == floors
    assert words_of(figure) == ["A", "the dots as they are", "B", "the surface recovered from the dots"]


def test_every_pair_has_its_dot_beside_the_mean_of_all():
    """The two partners of a pair count as one; the best score is on top, under its words; the title has both intervals."""
    scores = (
        ("propensity_smoothed", 0.3),
        ("propensity_smoothed", 0.4),
        ("protrusion", 0.6),
        ("protrusion", 0.8),
    )
    rows = [(name, score, auc + side) for side in (0, 0.1)
            for name, (score, auc) in zip("abab", scores, strict=True)]  # fmt: skip
    table = pd.DataFrame(rows, columns=["complex", "score", "auc"])
    figure = over_pairs("run", table)
    means = means_over_pairs(table).set_index("score")
    main, baseline = (means.loc[score] for score in ("propensity_smoothed", "protrusion"))
    ax = figure.axes[0]
    labels = [label.get_text() for label in ax.get_yticklabels()]
    assert labels == ["complementarity, smoothed", "protrusion: few heavy atoms within 10 Å"]
    drawn = [line.get_xydata() for line in ax.lines[:6]]
    assert np.allclose(drawn[0], [[0.35, 0], [0.45, 0]]) and np.allclose(drawn[2], [[0.4, 0]])
    assert np.allclose(drawn[1], [[main["low"], 0], [main["high"], 0]])
    assert np.allclose(drawn[3], [[0.65, 1], [0.85, 1]]) and np.allclose(drawn[5], [[0.75, 1]])
    ends = [f"({row['low']:.2f} to {row['high']:.2f})" for row in (main, baseline)]
    assert words_of(figure)[0] == f"AUC of complementarity 0.40 {ends[0]}, of protrusion 0.75 {ends[1]}"
    assert words_of(over_pairs("run", table[table["complex"] == "a"]))[0] == "run"
