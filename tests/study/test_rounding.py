"""Digits of the numbers in tables."""

import io
import math

import numpy as np
import pandas as pd
import pytest

from sparsurf_study.rounding import round_by_error, write_rounded


def test_a_number_has_two_digits_of_its_error():
    table = pd.DataFrame(
        {
            "d_kept": [1.23456789, -0.0000123456, np.nan, 3.3333333],
            "d_se_kept": [0.0345678, 0.00234567, 0.1, 0.0],
            "d_low_kept": [1.1669, -0.0047, np.nan, 3.3333333],
            "d_high_kept": [1.3023, 0.0045, np.nan, 3.3333333],
            "d_recovered": [1.23456789] * 4,
            "d_se_recovered": [0.0345678] * 4,
            "auc": [0.54321, 12.3456, math.inf, 0.5],
            "low": [0.5, -100.0, 0.1, np.nan],
            "high": [0.6, 100.0, math.inf, np.nan],
            "area": [731.1057607586985, 1.0, 0.1 + 0.2, 1e-9],
            "n": [1, 2, 3, 4],
            "name": ["a", "b", "c", "d"],
        }
    )
    rows = round_by_error(table)
    # never -0, and all digits without an error
    assert rows["d_kept"].tolist() == ["1.235", "0.0000", "", "3.33333"]
    assert rows["d_se_kept"].tolist() == ["0.035", "0.0023", "0.10", "0"]
    assert rows["d_high_kept"].tolist() == ["1.302", "0.0045", "", "3.33333"]
    assert set(rows["d_recovered"]) == {"1.235"}
    assert rows["auc"].tolist() == ["0.543", "12", "inf", "0.5"]  # errors of 0.025, 50, infinity and none
    assert rows["low"].tolist() == ["0.500", "-100", "0.1", ""]
    assert rows["area"].tolist() == ["731.106", "1", "0.3", "1e-09"]
    assert rows["n"].tolist() == [1, 2, 3, 4] and rows["name"].tolist() == list("abcd")


def test_a_table_can_be_read_again(tmp_path):
    table = pd.DataFrame({"Z": [1.23456], "Z_low": [1.0], "Z_high": [1.4], "empty": [np.nan]})
    write_rounded(tmp_path / "table.csv", table)
    assert (tmp_path / "table.csv").read_text() == "Z,Z_low,Z_high,empty\n1.23,1.00,1.40,\n"
    again = pd.read_csv(io.StringIO((tmp_path / "table.csv").read_text()))
    assert again["Z"][0] == pytest.approx(1.23456, abs=0.1 / 20)  # a twentieth of the error
