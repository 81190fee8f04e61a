"""The page on samplers over several proteins, and pages for a browser, from a few numbers."""

import pandas as pd

from sparsurf.report import comparison_over_proteins_page as over
from sparsurf.report.html import as_html, in_report


def test_a_spread_is_lowest_to_highest_and_tells_bounds():
    rows = pd.DataFrame(
        {"sampler": ["b", "a", "a"], "percent": [5.0, 5.0, 10.0], "factor": [2.0, 3.0, 4.0], "lowest": [1.0, 2.5, 3.5],
         "highest": [4.0, 3.5, 4.5], "bound": ["more than ", "less than ", "about "]}
    )  # fmt: skip
    matrix = over._spread(rows, "", "factor")
    assert matrix.index.tolist() == ["b", "a"] and matrix.columns.tolist() == [5.0, 10.0]
    assert matrix.loc["b", 5.0] == "> 2.00 (1.00 .. 4.00)"
    assert matrix.loc["a"].tolist() == ["< 3.00 (2.50 .. 3.50)", "~ 4.00 (3.50 .. 4.50)"]
    assert over._spread(rows.assign(lowest=2.0, highest=2.0), "", "factor").loc["b", 5.0] == "> 2.00"
    one = over._spread(rows.assign(lowest=2.0, highest=2.0, bound=""), "", "factor")
    assert one.loc["b", 5.0] == "2.00 (2.00 .. 2.00)"
    plain = rows.drop(columns="bound").rename(columns={"lowest": "ratio_lowest", "highest": "ratio_highest"})
    assert over._spread(plain, "ratio_", "factor").loc["b", 5.0] == "2.00 (1.00 .. 4.00)"


def test_rankings_name_where_they_do_not_hold():
    holds = {"p": pd.Series({5.0: True, 10.0: True}), "q": pd.Series({5.0: False, 10.0: True})}
    lines = over._rankings_markdown(pd.DataFrame(holds)).splitlines()
    assert lines[2:] == ["- at 5 %: 1 of 2, not q", "- at 10 %: 2 of 2"]


def test_what_was_not_compared_has_no_heading():
    table = pd.DataFrame(
        {"sampler": ["b"], "percent": [5.0], "measure": ["Z surface"], "use": ["surface"], "ratio": [0.5]}
    )
    table[["value", "lowest", "highest", "ratio_lowest", "ratio_highest"]] = 0.5
    table["n_S_percent"], table["null_model"] = 5.0, 2.0
    fewer = pd.DataFrame(
        {"use": ["surface"], "than": ["paper"], "sampler": ["b"], "percent": [5.0], "measure": "Z surface"}
    )
    fewer[["factor", "lowest", "highest", "Z"]], fewer["bound"] = 2.0, ""
    holds = {"p": pd.Series({5.0: True})}
    for rows, rankings, headings in (
        (fewer, holds, 2),
        (fewer[:0], holds, 1),
        (fewer, {"p": pd.Series(dtype=bool)}, 1),
    ):
        page = over.summary_markdown(table, rows, rankings, "proteins", 1)
        assert ("## Ranking" in page) + ("## Dots needed" in page) == headings


def test_a_page_for_a_browser_is_safe_and_has_tables():
    page = as_html("| a |\n| --- |\n| 1 |\n\n[x](p/q.html)\n", "A < B")
    assert "<title>A &lt; B</title>" in page and "<td>1</td>" in page and 'href="p/q.html"' in page
    part = in_report(
        "[x](p/a b.html) [y](https://x.org)\n".replace("a b", "a%20b"), "results/r", ["p/a b.html"]
    )
    assert "app.showResultInfo('results/r/p/" in part and 'href="https://x.org"' in part
