"""The page on the best combinations: what it counts, and when it says that every dot is kept."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.report.ranges_page import best_of, counts, ranges_page


def test_ranges_are_counted_by_their_intervals_and_against_the_null_model():
    """Above, below and around 0; a range without an interval does not count."""
    rows = pd.DataFrame(
        {
            "d_cv_low": [0.1, -0.3, -0.1, np.nan],
            "d_cv_high": [0.3, -0.1, 0.2, np.nan],
            "Z_tS": [1.0, 3.0, 2.0, 9.0],
        }
    )
    assert counts(rows, 1.5) == {"n": 3, "above": 1, "below": 1, "above_null": 2}


def test_every_reference_has_its_own_words():
    errors = {"Z_empty": 9.0, "Z_two_patches": 4.0, "Z_mean_descriptor": 2.0, "Z_resampled": 0.5}
    best = {"max_n_S_percent": 20.0, "draws": 3, "references": errors}
    ranges = pd.DataFrame(columns=["reading"])
    page = ranges_page("p/c1", ranges, best, errors)
    assert page["references"][:3] == [
        ("an empty patch", "9.00"), ("two different patches", "4.00"), ("the mean patch in place of every patch", "2.00")
    ]  # fmt: skip


@pytest.mark.parametrize(("percent", "every"), [(99.99, False), (99.996, True), (100.0, True)])
def test_every_dot_is_kept_where_all_decimals_say_so(percent, every):
    row = {"alpha": 1.0, "beta": 0.0, "gamma": 6.0, "delta": 0.0, "n_S_percent": percent, "n_best_set": 3.0}
    known = best_of(row | {"d_cv": 0.2, "d_cv_low": 0.1, "d_cv_high": 0.3})
    assert known["every_dot"] is every and known["set"] == 3
    assert (known["d"], known["place"]) == ("0.20 (0.10 to 0.30)", "above")
