"""How many dots are enough: the smallest subset whose Z comes down to a noise floor, as it is and recovered."""

import logging

import numpy as np
import pandas as pd

from sparsurf import InputError
from sparsurf.patches.readings import TEXT
from sparsurf.recovery.readings import RECOVERED, recovered
from sparsurf.recovery.settling import settle
from sparsurf.sampling.published import OF_PAPER
from sparsurf.sampling.samplers import named
from sparsurf.study.enough import CLOSE

log = logging.getLogger("sparsurf")

PERCENTS = (1, 1.5, 2, 2.5, 3, 4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30, 40, 50, 60, 70, 80, 90)  # of the dots
FEWEST = 12  # dots; fewer hold no surface that could be recovered
HALVINGS = 3  # of the step between two percents, for the subset that is handed out


def enough_dots(
    evaluator, sampler, floors, n_tests, choices=OF_PAPER, readings=(TEXT, RECOVERED), settled=False
):
    """The smallest n_S of a sampler whose Z is at most `enough.CLOSE` times each floor.

    Parameters
    ----------
    evaluator : Evaluator
    sampler : str
    floors : DataFrame
        See `floors.floors`.
    n_tests : int
    choices : published.Choices
    readings : sequence of str, `surface`, `recovered` or both
    settled : bool
        The surface is recovered from the dots at better places, see `settling.settle`.

    Returns
    -------
    DataFrame: sampler, floor, Z_floor, islands (`surface`: the kept dots as they are, patches cut on the full surface;
    `recovered`), n_S, n_S_percent and Z there; all dots where no fewer of `PERCENTS` do.
    """
    draw, z_of = _tools(evaluator, sampler, n_tests, choices, settled)
    n_dots, rows = len(evaluator.points), []
    sizes = np.unique([min(n_dots, max(FEWEST, round(p / 100 * n_dots))) for p in PERCENTS])
    drawn = [draw(n) for n in sizes]
    for reading in readings:
        found = [z_of(dots, reading) for dots in drawn]
        for floor in floors.itertuples():
            reached = [k for k, z in enumerate(found) if z <= CLOSE * floor.Z]
            n, value = (len(drawn[reached[0]]), found[reached[0]]) if reached else (n_dots, 0.0)
            row = {"sampler": sampler, "floor": floor.floor, "Z_floor": floor.Z, "islands": reading}
            rows.append(row | {"n_S": int(n), "n_S_percent": 100 * n / n_dots, "Z": value})
    return pd.DataFrame(rows)


def smallest(evaluator, sampler, floors, floor, enough, n_tests, choices=OF_PAPER, settled=False):
    """The smallest subset whose recovered Z comes near a floor, sought between the step of `enough` and the one before.

    Parameters
    ----------
    floor : str, a row of `floors`
    enough : DataFrame, of `enough_dots`

    Returns
    -------
    (n,) int64 dots, in the order of choice.

    Raises
    ------
    InputError : a floor that this surface has not
    """
    if floor not in set(floors["floor"]):
        raise InputError(
            f"minimal.floor is {floor!r}, but {evaluator.name} has {', '.join(floors['floor'])} only; name one of them."
        )
    limit = floors.set_index("floor").loc[floor, "Z"]
    draw, z_of = _tools(evaluator, sampler, n_tests, choices, settled)
    own = enough[(enough["floor"] == floor) & (enough["islands"] == RECOVERED)].iloc[0]
    high, share = int(own["n_S"]), own["n_S_percent"]
    below = [p for p in PERCENTS if p < 0.999 * share]
    low = max(FEWEST, round((below[-1] if below else 0) / 100 * len(evaluator.points)))
    best = draw(high)
    for _ in range(HALVINGS):
        middle = (low + high) // 2
        if not low < middle < high:
            break
        some = draw(middle)
        if z_of(some, RECOVERED) <= CLOSE * limit:
            high, best = middle, some
        else:
            low = middle
    log.info(
        "%s: recovered from %d of %d dots of %s, Z is that of %s, %.3f, within a tenth",
        evaluator.name, len(best), len(evaluator.points), sampler, floor, limit,
    )  # fmt: skip
    return best


def _tools(evaluator, sampler, n_tests, choices, settled):
    """Functions n -> dots, and (dots, reading) -> Z on the test dots of the study, which are those of the floors."""
    function = named([sampler], "minimal.sampler", choices)[sampler]
    tests = evaluator.draw_tests(n_tests)
    z_tot, _ = evaluator.describe(tests)

    def draw(n):
        return function(evaluator, n, evaluator.stream("minimal", sampler))

    def z_of(dots, reading):
        if not (settled and reading == RECOVERED):
            return evaluator.distances([dots], tests, z_tot, reading)[0].mean()
        kept = settle(
            evaluator.points[dots],
            evaluator.normals[dots],
            evaluator.points,
            evaluator.normals,
            threads=evaluator.threads,
        )
        index = recovered(*kept, evaluator.d_link, evaluator.area)
        return evaluator.distances_of(index, tests, z_tot)[0].mean()

    longest = draw(len(evaluator.points)) if function.nested else None
    return (lambda n: longest[:n]) if longest is not None else draw, z_of
