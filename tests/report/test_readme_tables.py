"""The README's tables: filled between their comments, and equal to the stored tables."""

import json
import re

import mdtraj
import pandas as pd
import pytest

import store_tables
from conftest import ROOT
from sparsurf.report.readme_tables import (
    FRAME,
    claims_table,
    filled,
    plan_table,
    ranges_table,
    readme_tables,
)
from store_tables import bytes_per_frame

TABLES = ROOT / "docs" / "tables"


def test_tables_stand_between_their_comments():
    text = "a\n<!-- table: one -->\nold\n<!-- end of table -->\nb\n<!-- table: two -->\nstays\n<!-- end of table -->\n"
    new = filled(text, {"one": "| new |\n"})
    assert (
        "old" not in new and "| new |" in new and "stays" in new and new.startswith("a\n") and "\nb\n" in new
    )
    assert filled(new, {"one": "| new |\n"}) == new


def test_a_row_of_the_ranges():
    row = {
        "n_S_low_percent": 3.0,
        "n_S_high_percent": 12.5,
        "alpha": 0.6,
        "beta": 1.0,
        "gamma": 10.0,
        "delta": 8.0,
    }
    row |= {
        "d_held_out": 1.18,
        "d_held_out_low": 1.0,
        "d_held_out_high": 1.36,
        "d": 1.25,
        "Z_tS": 7.75,
        "n_best_set": 6.0,
    }
    table = ranges_table(pd.DataFrame([row | {"islands": name} for name in ("kept", "surface")]))
    assert "| 3.00 – 12.50 | (0.6, 1, 10, 8) | 1.18 (1.00 .. 1.36) | 1.25 | 7.75 | 6 |" in table
    none = row | {"n_best_set": float("nan")}  # a range without combinations
    table = ranges_table(pd.DataFrame([none | {"islands": name} for name in ("kept", "surface")]))
    assert "| 1.25 | 7.75 | 0 |" in table


def test_the_claims_beside_the_paper():
    values = {
        "n_runs": "40",
        "d_statistic_half-open": "12.34",
        "d_n_rows_half-open": "9",
        "d_p_half-open": "0.2",
    }
    values |= {
        "d_outside_half-open": "none",
        "rows_d_lowest_surface": "-1.111",
        "rows_d_highest_surface": "2.222",
    }
    values |= {"n_combinations": "100", "uniform_0.2_percent": "49.96"}
    for k, name in enumerate(("kept", "surface")):
        values |= {f"best_{name}": f"(1, 0, {k}, 0)", f"best_d_held_out_{name}": f"{k}.5"}
        values |= {f"best_d_held_out_low_{name}": f"{k}.25", f"best_d_held_out_high_{name}": f"{k}.75"}
        values |= {f"best_n_best_set_{name}": f"{k + 3}", f"n_positive_{name}": f"{k + 50}"}
        values |= {f"n_above_null_{name}": f"{k + 60}", f"n_rows_above_null_{name}": f"{k + 7}"}
        for j, half in enumerate(("rougher", "flatter")):
            values |= {f"d_{half}_any_dots_{name}": f"{k}.{j}1", f"d_{half}_kept_dots_{name}": f"-{k}.{j}1"}
    lines = claims_table(values).splitlines()[2:]
    assert (
        "runs made as published, half-open ranges | d: sum of squares 12.3 for 9 rows, p = 0.2; rows outside of"
        in lines[0]
    )
    assert lines[0].endswith("all runs: none | d of the ten rows from -1.11 to 2.22 |")
    assert lines[1].endswith(
        "| (1, 0, 0, 0), d held out = 0.50 (0.25 .. 0.75); 3 may be the best "
        "| (1, 0, 1, 0), d held out = 1.50 (1.25 .. 1.75); 4 may be the best |"
    )
    assert lines[2] == "| d > 0 | in 50 of 100 combinations | in 51 of 100 combinations |"
    assert "null model in 60 of 100 combinations and 7 of the 10 published rows | Z_tS above" in lines[3]
    assert lines[4].endswith(
        "| d 0.0 against 0.1; around kept dots -0.0 against -0.1 | d 1.0 against 1.1; around kept dots -1.0 against -1.1 |"
    )
    assert "α = 0.2 keeps 50.0 %" in lines[5]


def test_the_readme_holds_the_stored_tables():
    stored = [TABLES / name for name in ("default_ranges.csv", "paper_facts.csv")]
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    if not all(path.is_file() for path in stored) or "<!-- table: " not in text:
        pytest.skip("no tables are stored, or the README has no place for them")
    tables = readme_tables(pd.read_csv(stored[0]), pd.read_csv(stored[1], dtype=str))
    assert filled(text, tables) == text


def test_the_plan_counts_hours_from_the_cost_of_a_frame():
    bench = pd.DataFrame({"what": ["other", "a frame of an ensemble, 953 atoms"], "value": [9.0, 0.36]})
    table = plan_table(bench, 4000).splitlines()
    assert table[3] == "| 100 ps | 100,000 | 10.0 | 2 | 0.40 GB |"  # 36,000 s
    assert table[4] == "| 10 ps | 1,000,000 | 100.0 | 13 | 4.00 GB |"


def test_stored_numbers_have_four_decimals(tmp_path, monkeypatch):
    for conformation, d in (("c1", 1.23456), ("c2", 2.0)):  # the first is quoted
        (tmp_path / "p" / conformation).mkdir(parents=True)
        ranges = pd.DataFrame({"d": [d], "best_set": ["x"]})
        ranges.to_csv(tmp_path / "p" / conformation / "ranges.csv", index=False)
    (tmp_path / "README.md").write_text("")
    facts = pd.DataFrame({"name": ["n"], "value": ["1"]})
    monkeypatch.setattr(store_tables, "paper_facts", lambda _: facts)
    monkeypatch.setattr(store_tables, "readme_tables", lambda *_: {})
    store_tables.main(tmp_path, "paper", docs=tmp_path, readme=tmp_path / "README.md")
    assert (tmp_path / "default_ranges.csv").read_text() == "d\n1.2346\n"


def test_figures_of_the_benchmark_have_three_digits_and_make_the_plan(tmp_path, monkeypatch):
    docs = tmp_path / "docs" / "tables"
    for folder in (docs, tmp_path / "bench", tmp_path / "p" / "c1"):
        folder.mkdir(parents=True)
    pd.DataFrame({"d": [1.0], "best_set": ["x"]}).to_csv(tmp_path / "p" / "c1" / "ranges.csv", index=False)
    rows = [{"what": FRAME, "dots": None, "value": 0.12345}, {"what": "index", "dots": 20045, "value": 9.0}]
    (tmp_path / "bench" / "bench.json").write_text(json.dumps({"figures": rows}))
    (tmp_path / "README.md").write_text("")
    (tmp_path / "docs" / "cluster.md").write_text("<!-- table: plan -->\n<!-- end of table -->")
    monkeypatch.setattr(store_tables, "paper_facts", lambda _: pd.DataFrame({"name": ["n"], "value": ["1"]}))
    monkeypatch.setattr(store_tables, "readme_tables", lambda *_: {})
    readme = tmp_path / "README.md"
    store_tables.main(tmp_path, "paper", tmp_path / "bench", docs=docs, readme=readme)
    assert (docs / "bench.csv").read_text() == f'what,dots,value\n"{FRAME}",,0.123\nindex,20045,9\n'
    plan = plan_table(pd.DataFrame({"what": [FRAME], "value": [0.123]}), bytes_per_frame())
    assert (tmp_path / "docs" / "cluster.md").read_text() == (
        f"<!-- table: plan -->\n\n{plan}\n<!-- end of table -->"
    )


def test_the_embedded_trajectory_has_as_many_frames_as_it_is_divided_by():
    with mdtraj.open(str(ROOT / "data" / "tdp43" / "trajectory.xtc")) as file:
        assert len(file) == store_tables.FRAMES


def test_the_page_on_clusters_holds_the_stored_plan():
    stored = TABLES / "bench.csv"
    if not stored.is_file():
        pytest.skip("no figures of make bench are stored")
    text = (ROOT / "docs" / "cluster.md").read_text(encoding="utf-8")
    assert filled(text, {"plan": plan_table(pd.read_csv(stored), bytes_per_frame())}) == text


def test_the_readme_quotes_the_page_of_recovered_surfaces():
    page = (ROOT / "docs" / "recover.md").read_text(encoding="utf-8").splitlines()
    quoted = [line for line in page if line.startswith(("- From 10 %", "- From 5 %"))]
    readme = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(quoted) == 2 and all(f"{line}\n" in readme for line in quoted)
    number = re.search(r"## farthest dots, mean of (\d+) structures", " ".join(page))[1]
    assert f"Mean over {number} structures" in readme
