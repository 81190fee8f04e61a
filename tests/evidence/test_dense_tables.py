"""Tables of dense surfaces, by hand."""

import pandas as pd
import pytest

from measures.recovery import dense_means


def test_dense_surfaces_are_summarised_by_kind_with_the_factor_of_one_density():
    columns = ["hydrogens", "requested_density", "density", "N", "n_S", "n_S_at_5.35"]
    rows = [
        ("keep", "auto", 5.4, 1000, 50, 50),
        ("keep", "20", 20.0, 4000, 100, 200),
        ("keep", "20", 20.0, 2000, 100, 800),
    ]
    found = dense_means(pd.DataFrame(rows, columns=columns)).set_index("requested_density").loc["20"]
    assert found[["n", "N", "n_S", "n_S_percent"]].to_list() == [2, 3000, 100, 3.75]
    assert found[["times", "fewest", "most"]].to_list() == pytest.approx([4, 2, 8])
