"""Combinations: text, numbers and fields of tables; the paper's own choice."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.sampling.combination import (
    PARAMETERS,
    PUBLISHED_CHOICES,
    PUBLISHED_ROWS,
    Combination,
    combination_labels,
    join_combinations,
    split_combinations,
)


def test_text_and_back():
    one = Combination(0.4, 0.2, 10.0, 0.0)
    assert str(one) == "(0.4, 0.2, 10, 0)" and Combination.parse(str(one)) == one
    assert one.keys() == [400000, 200000, 10000000, 0]
    for text in ("(1, 2, 3)", "(1, 2, 3, 4, 5)"):
        with pytest.raises(ValueError, match="is not a combination"):
            Combination.parse(text)


def test_fields_of_tables():
    table = pd.DataFrame(PUBLISHED_ROWS[:2], columns=PARAMETERS).assign(d=1.0)
    assert combination_labels(table) == ["(0.4, 0.2, 10, 10)", "(1, 0.4, 10, 6)"]
    assert split_combinations(join_combinations(combination_labels(table))) == combination_labels(table)
    assert split_combinations(np.nan) == split_combinations("") == []


def test_the_papers_choice_for_a_number_of_dots():
    # Table I: 5 % lies in the first range, 45 % in the fifth; below the first limit the first, above the last the last
    assert len(PUBLISHED_CHOICES.from_n_s(5.0)) == 10 and len(PUBLISHED_CHOICES.from_n_s(1.0)) == 10
    assert PUBLISHED_CHOICES.from_n_s(45.0)[0].tolist() == [1.0, 0.0, 6.0, 0.0]
    assert PUBLISHED_CHOICES.from_n_s(100.0).tolist() == [[1.0, 0.2, 0.0, 0.0]]
