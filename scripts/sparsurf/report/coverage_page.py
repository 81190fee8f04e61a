"""The page on how often intervals hold the truth and confidence sets the best."""

from sparsurf.report.pages import markdown
from sparsurf.study.coverage import CONTENDERS, DESIGNS, POOL

SHOWN = {
    "fixed_t": "fixed combination, t",
    "fixed_normal": "the same with 1.96",
    "winner": "winner as selected",
    "held_out": "held out",
    "held_out_winner": "held out, of the winner shown",
    "best_in_set": "best in the confidence set",
}


def coverage_markdown(table):
    """The page.

    Parameters
    ----------
    table : DataFrame
        `coverage.replicates` of all surfaces, readings and designs, with the columns surface, islands, draws, test_dots
        and replicates.
    """
    draws, tests = DESIGNS[1]
    default = table[(table["draws"] == draws) & (table["test_dots"] == tests)]
    of = default.groupby(["surface", "islands"])
    shares = of[list(SHOWN)].mean()
    parts = [
        "# How often the intervals hold the truth\n",
        f"With the default of {draws} draws and {tests} test dots, over {int(table['replicates'].iloc[0])} replicates on each of "
        f"{table['surface'].nunique()} surfaces, under both readings:\n",
        f"- the 95 % interval of a fixed combination holds its mean d in {_span(shares['fixed_t'])} of the cases (with 1.96 "
        f"standard errors in {_span(shares['fixed_normal'])});",
        f"- the interval of d held out holds the mean d of the combinations it measured in {_span(shares['held_out'])}, and that "
        f"of the winner shown in {_span(shares['held_out_winner'])};",
        f"- d of the winner as selected is too high by {of['selected_bias'].mean().max():.3f} at most (mean over the ranges), "
        f"held out it is off by {of['held_out_bias'].mean().abs().max():.3f};",
        f"- the confidence set of the best holds the truly best combination in {_span(shares['best_in_set'])} and has "
        f"{of['set_size'].mean().min():.0f} to {of['set_size'].mean().max():.0f} members on average.\n",
        "## By surface and reading, means over the ranges of n_S\n",
    ]
    short = shares.rename(columns=SHOWN).reset_index()
    parts += [markdown(short, 3), "## By design, at equal cost\n", markdown(_designs(table), 3)]
    parts += [
        "half width: of the interval of d held out. The confidence set was made for the default design only.\n",
        "## By range, default design\n",
        markdown(_by_range(default), 3),
        "## How it was done\n",
        f"`python scripts/measure_coverage.py FOLDERS` takes, on each surface, the {CONTENDERS} combinations with the highest d "
        f"of every range and reading, and evaluates {POOL[0]} draws of each at {POOL[1]} test dots: that pool is the population, "
        "its means are the truth. A replicate draws test dots, shared by all combinations, and draws of each combination from "
        "it, with replacement, and goes through the functions of the study. The other combinations of a range, whose d lies "
        "lower, take no part. All numbers: tables/coverage.csv.\n",
    ]
    return "\n".join(parts)


def _span(values):
    low, high = f"{values.min():.3f}", f"{values.max():.3f}"
    return low if low == high else f"{low} to {high}"


def _designs(table):
    columns = [name for name in SHOWN if name != "best_in_set"] + ["half_width"]
    found = table.groupby(["islands", "draws", "test_dots"])[columns].mean().reset_index()
    return found.rename(columns=SHOWN | {"test_dots": "test dots", "half_width": "half width"})


def _by_range(default):
    keys = ["surface", "islands", "range", "n_combinations"]
    names = ["fixed_t", "held_out", "held_out_winner", "selected_bias", "best_in_set", "set_size"]
    found = default[keys + names].copy()
    return found.rename(
        columns=SHOWN
        | {"n_combinations": "contenders", "selected_bias": "bias as selected", "set_size": "size"}
    )
