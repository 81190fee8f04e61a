"""Sites on unrelated proteins: how groups are taken, constants that are found again, and p on proteins that were held out."""

import numpy as np
import pandas as pd
import pytest

import sparsurf
from conftest import ROOT
from measures import unrelated
from sparsurf.sites.finding import chance, null


@pytest.fixture(scope="module")
def sites():
    return sparsurf.describe_sites(ROOT / "data" / "tdp43" / "topology.pdb", name="a")


def test_constants_of_unrelated_scores_are_found_again():
    rng = np.random.default_rng(3)
    places, level, constants = (
        rng.choice([8, 25, 100, 400], 8000),
        rng.random(8000),
        np.array([-2.4, -0.35, 0.5]),
    )
    width = np.exp(constants[0]) * (places / 40) ** constants[1] * (4 + 4 * level) ** constants[2]
    table = pd.DataFrame({"places": places, "mirrored": 4 * (1 + level)})
    table["score"] = table["mirrored"] + width * rng.logistic(size=8000)
    np.testing.assert_allclose(unrelated.fit(table), constants, atol=0.06)
    halves = table.assign(half=1 + np.arange(8000) % 2, same=False, kind=unrelated.COMPACT)
    halves.loc[0, "score"] = 0.0  # found nothing: counts nowhere
    tested, fitted = unrelated.held_out(halves)
    assert len(tested) == 7999 and abs((tested["p"] < 0.1).mean() - 0.1) < 0.01
    row = tested.loc[4]
    assert row["p"] == pytest.approx(
        chance(np.array([row["score"]]), np.array([row["mirrored"]]), row["places"], fitted[2])[0]
    )
    shown = unrelated.shares(tested).set_index("query")
    assert shown.loc["all of 40 to 399 places", "searches"] == (tested["places"] == 100).sum()


def test_groups_lie_together_and_pockets_lie_deep(sites):
    taken = [
        (kind, site)
        for seed in range(4)
        for kind, site in unrelated.groups(sites, np.random.default_rng(seed))
    ]
    assert {len(site) for kind, site in taken if kind == unrelated.COMPACT} == {8, 12, 25, 50, 100, 200, 400}
    assert [len(site) for kind, site in taken if kind == unrelated.WHOLE] == 4 * [len(sites)]
    widths = {
        kind: np.mean(
            [np.ptp(site.points, axis=0).mean() for own, site in taken if own == kind and len(site) == 25]
        )
        for kind in (unrelated.COMPACT, unrelated.LOOSE)
    }
    assert widths[unrelated.LOOSE] > 1.3 * widths[unrelated.COMPACT]
    deep = unrelated._bottom(sites, np.random.default_rng(0))
    near = np.sum(np.linalg.norm(sites.points - deep, axis=1) < unrelated.REACH)
    above = sites.points + unrelated.ABOVE * sites.normals
    every = [np.sum(np.linalg.norm(sites.points - point, axis=1) < unrelated.REACH) for point in above]
    assert near > np.quantile(every, 0.9)


def test_a_part_of_an_interface_is_found_on_itself(sites):
    part = sites.take(unrelated._nearest(sites, sites.points[9], 30))
    table = unrelated.search(unrelated.parts(part, np.random.default_rng(0)), [sites])
    assert table["places"].to_list() == [30, 8, 12, 25]
    assert (table["score"][1:] == 0).any() or (table["score"] > table["mirrored"]).all()
    assert table.loc[0, "score"] > 2 * table.loc[0, "mirrored"]


def test_p_is_right_within_a_factor_of_two_on_proteins_that_were_held_out():
    table = pd.read_csv(ROOT / "evidence" / "tables" / "sites_chance.csv").query("target == 'unrelated'")
    every = table.set_index("query").loc["all"]
    assert every["searches"] > 800
    for percent in (1, 5, 10, 50):
        assert percent / 200 < every[f"below_{percent}"] < percent / 50
    groups = table[table["searches"] >= 100]
    assert len(groups) >= 6
    for percent in (10, 50):
        assert groups[f"below_{percent}"].between(percent / 200, percent / 50).all()
    searches = pd.read_csv(ROOT / "evidence" / "tables" / "sites_searches.csv")
    np.testing.assert_allclose(unrelated.fit(searches[~searches["same"]]), null(), atol=0.01)
