"""The numbers of the comparison with the paper that the README quotes, each under a name."""

import json
from pathlib import Path

import pandas as pd

from sparsurf.patches.readings import OF_GRID
from sparsurf.sampling.combination import PARAMETERS, Combination
from sparsurf.study import two_readings
from sparsurf.study.published_runs import BINNINGS, MEASURES, all_rows_at_once
from sparsurf.study.replication import sign_changes

UNIFORM = {
    "alpha": 0.2,
    "beta": 0.0,
    "gamma": 0.0,
    "delta": 0.0,
}  # the paper's 'uniform draw of a share alpha'


def paper_facts(folder, protein="A1"):
    """Names and values from the tables of a run of the paper's study.

    Parameters
    ----------
    folder : path
        results/<run>, with `verdict.md` and its tables.
    protein : str
        The one that is the paper's.

    Returns
    -------
    DataFrame: name, value (numbers as text, to 4 digits)
    """
    folder = Path(folder)
    own = folder / protein / "c1"
    grid, bins = pd.read_csv(own / "grid.csv"), pd.read_csv(own / "rough_and_flat.csv")
    best = json.loads((own / "best.json").read_text(encoding="utf-8"))
    places, rows, links, family = (
        pd.read_csv(folder / f"paper_{name}.csv") for name in ("places", "rows", "links", "family")
    )
    facts = {"n_combinations": len(grid), "null_model": best["yardsticks"]["null_model"]}
    facts |= _table_1(places)
    for reading in OF_GRID:
        row = best[reading]["unrestricted"]
        facts |= {f"best_{reading}": str(Combination.of(row))}
        for key in ("n_S_percent", "d_held_out", "d_held_out_low", "d_held_out_high", "d", "n_best_set"):
            facts[f"best_{key}_{reading}"] = row[key]
        facts[f"n_positive_{reading}"] = int((grid[f"d_{reading}"] > 0).sum())
        facts[f"n_above_null_{reading}"] = int((grid[f"Z_tS_{reading}"] > facts["null_model"]).sum())
        facts[f"n_rows_above_null_{reading}"] = int((rows[f"Z_tS_{reading}"] > facts["null_model"]).sum())
        facts |= {
            f"rows_d_lowest_{reading}": rows[f"d_{reading}"].min(),
            f"rows_d_highest_{reading}": rows[f"d_{reading}"].max(),
        }
        for around, short in (("kept dots", "kept_dots"), ("any dots", "any_dots")):
            for half in ("rougher half", "flatter half"):
                values = bins[(bins["around"] == around) & (bins["bin"] == half)]
                facts[f"d_{half.split()[0]}_{short}_{reading}"] = values[f"d_{reading}"].iloc[0]
    tenths = two_readings.correlation_by_tenths(grid)
    facts |= {"correlation": two_readings.correlation(grid), "correlation_lowest": tenths.min()}
    facts |= {"correlation_highest": tenths.max(), "family_n_better": int((family["d_low"] > 0).sum())}
    facts |= {"family_members": len(family)}
    uniform = grid[(grid[PARAMETERS] == pd.Series(UNIFORM)).all(axis=1)]
    facts["uniform_0.2_percent"] = uniform["n_S_percent"].iloc[0] if len(uniform) else float("nan")
    for row in sign_changes(links).itertuples():
        facts |= {
            f"link_best_row_{row.row}": row.D_link_best,
            f"link_negative_row_{row.row}": row.negative_from,
        }
    return pd.DataFrame({"name": list(facts), "value": [_text(value) for value in facts.values()]})


def _table_1(places):
    """The test of all published rows, by binning and measure, and what becomes of the last row."""
    facts = {"n_runs": int(places["n_runs"].max())}
    for binning in BINNINGS:
        own = places[places["binning"] == binning]
        for name in MEASURES:
            found = all_rows_at_once(own, name)
            facts |= {f"{name}_{key}_{binning}": found[key] for key in ("n_rows", "statistic", "p")}
            outside = (own[f"{name}_published"] > own[f"{name}_highest"]) | (
                own[f"{name}_published"] < own[f"{name}_lowest"]
            )
            facts[f"{name}_outside_{binning}"] = " ".join(str(k) for k in own.loc[outside, "range"]) or "none"
        facts[f"won_last_{binning}"] = int(own["n_won"].iloc[-1])
    return facts


def _text(value):
    return value if isinstance(value, str) else f"{value:.4g}"
