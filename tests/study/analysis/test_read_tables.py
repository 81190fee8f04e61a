"""Tables of a run, read again: what is cut short or changed is refused in one sentence."""

import numpy as np
import pandas as pd
import pytest

from sparsurf.errors import InputError
from sparsurf.sampling.combination import PARAMETERS
from sparsurf_study.analysis.tables import read_minimal, read_roughness, read_table


def written(path, **columns):
    pd.DataFrame(columns).to_csv(path, index=False)
    return path


def test_a_table_is_whole_or_refused(tmp_path):
    path = written(tmp_path / "t.csv", a=[1, 2, 3], b=[0.5, 0.25, 0.125])
    assert read_table(path, 3)["b"].tolist() == [0.5, 0.25, 0.125]
    whole = path.read_text()
    damages = {
        whole[:-1]: "cut short",
        "".join(whole.splitlines(True)[:-1]): "2 rows for 3 dots",
        whole.replace("0.25", "0.25,7"): "cannot be read",
        "": "cannot be read",
    }
    for text, words in damages.items():
        path.write_text(text)
        with pytest.raises(InputError, match=rf"t\.csv .*{words}.* run the study again"):
            read_table(path, 3, "dots")
    path.write_bytes(b"a,b\n\xff\xfe,1\n")
    with pytest.raises(InputError, match="cannot be read"):
        read_table(path)
    with pytest.raises(InputError, match="does not exist"):
        read_table(tmp_path / "none.csv")


@pytest.mark.parametrize("values", [[0.1, 0.2], [0.1, 0.2, 1.5], [0.1, np.nan, 0.2], [0.1, "x", 0.2]])
def test_roughness_is_that_of_every_dot(tmp_path, values):
    with pytest.raises(InputError, match=r"r\.csv"):
        read_roughness(written(tmp_path / "r.csv", roughness=values), np.zeros(3))
    with pytest.raises(InputError, match=r"r\.csv"):
        read_roughness(written(tmp_path / "r.csv", rough=[0.1] * 3), np.zeros(3))
    assert read_roughness(written(tmp_path / "r.csv", roughness=[0, 0.5, 1]), np.zeros(3)).tolist() == [
        0,
        0.5,
        1,
    ]


def test_the_minimal_subset_stands_for_all_dots(tmp_path):
    path = written(tmp_path / "m.csv", dot=[0, 4], weight=[3, 4])
    assert len(read_minimal(path, range(7))) == 2
    for columns in ({"dot": [0], "weight": [3]}, {"dot": [0]}):
        other = written(tmp_path / "m.csv", **columns)
        with pytest.raises(InputError, match="7 dots"):
            read_minimal(other, range(7))


def test_a_grid_has_each_of_its_combinations_once(tmp_path):
    """Half a grid is a whole one of fewer combinations: ranges.csv and best.json know how many there were."""
    rows = [(0.5, 0, g, 0) for g in (0, 6)] + [(1, 0, g, 0) for g in (0, 6)]
    grid = dict(zip(PARAMETERS, np.array(rows).T, strict=True))
    assert len(read_table(written(tmp_path / "g.csv", **grid), 4)) == 4
    path = written(tmp_path / "g.csv", **{key: each[:2] for key, each in grid.items()})
    with pytest.raises(InputError, match=r"g\.csv has 2 rows for 4 combinations"):
        read_table(path, 4, "combinations")
