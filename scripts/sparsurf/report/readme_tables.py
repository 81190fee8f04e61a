"""The tables of the README, made from the stored tables of the default and the paper's study, and the plan of docs/cluster.md.

They stand between the comments `<!-- table: NAME -->` and `<!-- end of table -->`; `filled` puts them there.
"""

import math
import re

import pandas as pd

from sparsurf.patches.readings import OF_GRID
from sparsurf.report.pages import interval, markdown
from sparsurf.report.table_1 import p_text
from sparsurf.sampling.combination import texts_of

MICROSECONDS = 10  # of the paper's trajectory
INTERVALS = (1000, 100, 10)  # ps between two frames
FRAME = "a frame of an ensemble, 953 atoms"  # of `make bench`
JOB_HOURS = 1  # of a job of 8 cores
PLACE = re.compile(r"(<!-- table: (\w+) -->\n).*?(<!-- end of table -->)", re.S)


def filled(text, tables):
    """`text` with what `tables` (name -> Markdown) holds between its comments; other places stay."""

    def fill(found):
        inside = tables.get(found[2])
        return found[0] if inside is None else f"{found[1]}\n{inside}\n{found[3]}"

    return PLACE.sub(fill, text)


def readme_tables(ranges, facts):
    """Both tables: `ranges`, the best combination per range of n_S, and `claims`, the paper beside ours.

    Parameters
    ----------
    ranges : DataFrame
        ranges.csv of one conformation.
    facts : DataFrame
        `paper_facts.paper_facts`, values as text.
    """
    return {
        "ranges": ranges_table(ranges),
        "claims": claims_table(dict(zip(facts["name"], facts["value"], strict=True))),
    }


def ranges_table(ranges):
    """Winner, d held out and size of the confidence set of the best per range, both readings side by side."""
    parts = {}
    for reading in OF_GRID:
        own = ranges[ranges["islands"] == reading].reset_index(drop=True)
        if "n_S / %" not in parts:
            limits = own[["n_S_low_percent", "n_S_high_percent"]].to_numpy()
            parts["n_S / %"] = [f"{a:.2f} – {b:.2f}" for a, b in limits]
        parts[f"best (α, β, γ, δ), `{reading}`"] = texts_of(own)
        parts[f"d held out (95 %), `{reading}`"] = [
            f"{row['d_held_out']:.2f} ({interval(row)})" for _, row in own.iterrows()
        ]
        parts[f"as selected, `{reading}`"] = own["d"]
        parts[f"Z_tS, `{reading}`"] = own["Z_tS"]
        parts[f"may be the best, `{reading}`"] = own["n_best_set"].fillna(0).astype(int)
    return markdown(pd.DataFrame(parts))


def plan_table(bench, bytes_per_frame):
    """What following one combination over the paper's trajectory takes, from the measured cost of a frame.

    Parameters
    ----------
    bench : DataFrame
        Stored figures of `make bench`: what, value.
    bytes_per_frame : float
        Of the embedded trajectory, protein only.
    """
    seconds = bench.set_index("what")["value"][FRAME]
    rows = []
    for interval_ps in INTERVALS:
        frames = round(MICROSECONDS * 1e6 / interval_ps)
        hours = frames * seconds / 3600
        rows.append(
            {
                "a frame every": f"{interval_ps} ps",
                "frames": f"{frames:,}",
                "CPU hours": f"{hours:.1f}",
                "`jobs`, of an hour on 8 cores": max(1, math.ceil(hours / 8 / JOB_HOURS)),
                "trajectory of the protein": f"{frames * bytes_per_frame / 1e9:.2f} GB",
            }
        )
    return markdown(pd.DataFrame(rows))


def claims_table(facts):
    """The paper's claims and what came out under each reading."""

    def number(name, decimals=2):
        return f"{float(facts[name]):.{decimals}f}"

    def best(reading):
        held = [number(f"best_d_held_out{end}_{reading}") for end in ("", "_low", "_high")]
        return (
            f"{facts[f'best_{reading}']}, d held out = {held[0]} ({held[1]} .. {held[2]}); "
            f"{facts[f'best_n_best_set_{reading}']} may be the best"
        )

    def halves(reading):
        any_dots = [number(f"d_{half}_any_dots_{reading}", 1) for half in ("rougher", "flatter")]
        kept = [number(f"d_{half}_kept_dots_{reading}", 1) for half in ("rougher", "flatter")]
        return f"{any_dots[0]} against {any_dots[1]}; around kept dots {kept[0]} against {kept[1]}"

    rows = [
        (
            f"Table I against the winners of {facts['n_runs']} runs made as published, half-open ranges",
            f"d: sum of squares {number('d_statistic_half-open', 1)} for {facts['d_n_rows_half-open']} rows, "
            f"{p_text(float(facts['d_p_half-open']))}; rows outside of all runs: {facts['d_outside_half-open']}",
            f"d of the ten rows from {number('rows_d_lowest_surface')} to {number('rows_d_highest_surface')}",
        ),
        ("best at α = 1: (1, 0, 6, 0), d = 2.69", best("kept"), best("surface")),
        (
            "d > 0",
            *(f"in {facts[f'n_positive_{r}']} of {facts['n_combinations']} combinations" for r in OF_GRID),
        ),
        (
            "the subsets describe the surface",
            *(
                f"Z_tS above the null model in {facts[f'n_above_null_{r}']} of {facts['n_combinations']} combinations and "
                f"{facts[f'n_rows_above_null_{r}']} of the 10 published rows"
                for r in OF_GRID
            ),
        ),
        ("rough patches gain, flat ones are equal", *(f"d {halves(reading)}" for reading in OF_GRID)),
        (
            "β = γ = δ = 0 is a uniform draw of a share α",
            f"no: a dot has a chance in each of its patches; α = 0.2 keeps {number('uniform_0.2_percent', 1)} %",
            "",
        ),
    ]
    return markdown(
        pd.DataFrame(
            rows, columns=["claim of the paper", "`kept` (authors' code)", "`surface` (paper's text)"]
        )
    )
