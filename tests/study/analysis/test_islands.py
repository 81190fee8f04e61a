"""How much of a patch is left in its island, against single patches."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

import naive
from sparsurf.evaluation.prepared_surface import PreparedSurface
from sparsurf.sampling.combination import PARAMETERS
from sparsurf.settings import Settings
from sparsurf.streams import Streams
from sparsurf_study.analysis import islands

FEW, MANY = (0.4, 0.2, 10.0, 10.0), (1.0, 0.0, 0.0, 2.0)
LINK, AREA = 0.8, 900.0


@pytest.fixture(scope="module")
def prepared(blob):
    points, normals = blob
    surface = SimpleNamespace(points=points, normals=normals, area=np.full(len(points), AREA / len(points)))
    patches = {"d_link": LINK, "r_patch": 4.0, "r_zernike": 6.0}
    return PreparedSurface(surface, Settings(patches=patches), streams=Streams(1, "blob"))


def by_hand(prepared, combination, tests, draws):
    """The two numbers of a combination, patch by patch."""
    points, shares, sizes = prepared.points, [], []
    for draw in range(draws):
        kept = prepared.pair(combination, draw)[0]
        sizes.append(len(kept))
        for i in tests:
            whole = np.intersect1d(naive.patch(points, i, 6.0, LINK), kept)
            near = kept[np.linalg.norm(points[kept] - points[i], axis=1) <= 6.0]
            shares.append(len(naive.island(points, near, LINK)) / len(whole))
    return LINK / np.sqrt(AREA / np.mean(sizes)), np.median(shares)


def test_the_share_in_the_island_is_that_of_single_patches(prepared):
    found = islands.measure_islands(prepared, [FEW, MANY], 12, 2).to_numpy()
    wanted = [by_hand(prepared, combination, prepared.draw_tests(12), 2) for combination in (FEW, MANY)]
    assert found == pytest.approx(np.array(wanted))
    assert found[0, 1] < 0.5 < found[1, 1]


def test_a_patch_without_kept_dots_has_no_share(prepared):
    far = np.argsort(np.linalg.norm(prepared.points - prepared.points[0], axis=1))[-5:]
    _, size, share = islands.compare_islands(prepared, [far], np.array([0, far[0]]), None)
    assert size[0, 0] == 0 and np.isnan(share[0, 0]) and share[0, 1] > 0
    patches = prepared.patches.model_copy(update={"r_zernike": 1.2})  # few of them hold a kept dot
    narrow = PreparedSurface(prepared.surface, Settings(patches=patches), streams=prepared.stream)
    tests = prepared.draw_tests(40)
    subsets = [narrow.pair(FEW, draw)[0] for draw in range(2)]
    _, _, share = islands.compare_islands(narrow, subsets, tests, None)
    found = islands.measure_islands(narrow, [FEW], 40, 2)["share_in_island"][0]
    assert np.isnan(share).any() and found == np.median(share[np.isfinite(share)])


def test_each_winner_has_its_own_numbers(prepared):
    """A range without combinations has none, and best.json has those of its own winners, also of one beyond all ranges."""
    rows = [dict(zip(PARAMETERS, row, strict=True)) for row in (MANY, FEW, [np.nan] * 4)]
    ranges = pd.DataFrame(rows).assign(n_combinations=[3, 2, 0], median_patch_size=9, n_best_set=1)
    best = {"draws": 2, "references": {"Z_empty": 1.0}}
    best["kept"] = {"unrestricted": dict(rows[1]), "under_max_n_S": {"answer": "None."}}
    whole = (1.0, 0.0, 0.0, 0.0)
    best["full"] = {"unrestricted": dict(zip(PARAMETERS, whole, strict=True)), "under_max_n_S": dict(rows[0])}
    table = islands.add_islands(ranges, best, prepared, 12, 1)
    names = ["link_over_spacing", "share_in_island"]
    wanted = islands.measure_islands(prepared, [MANY, FEW, whole], 12, 1)
    assert np.allclose(table.loc[:1, names], wanted[:2]) and table.loc[2, names].isna().all()
    assert list(table)[-4:] == ["median_patch_size", *names, "n_best_set"]
    for reading, key, k in (
        ("kept", "unrestricted", 1),
        ("full", "unrestricted", 2),
        ("full", "under_max_n_S", 0),
    ):
        assert [best[reading][key][name] for name in names] == pytest.approx(wanted.iloc[k].tolist())
    assert best["kept"]["under_max_n_S"] == {"answer": "None."}
