"""Numbers as people read them: on pages, in figures, on the command line."""

import math

from sparsurf.sampling.combination import Combination


def number(x, digits=2):
    """A number with a true minus sign; empty where it is unknown, never -0."""
    if x is None or math.isnan(x):
        return ""
    return f"{x:z.{digits}f}".replace("-", "−").replace("inf", "∞")


def share(percent):
    """A share in %: whole between 10 and 99.5, else with one decimal where it has one."""
    return f"{percent:.0f}" if 9.95 <= percent < 99.5 else f"{percent:.1f}".removesuffix(".0")


def span(values, form=number):
    """One text for several values: the value, or the smallest to the largest."""
    low, high = form(min(values)), form(max(values))
    return low if low == high else f"{low} to {high}"


def interval(value, low, high, digits=2):
    """A value with its limits in brackets, where it has any."""
    limits = f" ({number(low, digits)} to {number(high, digits)})" if not math.isnan(low) else ""
    return number(value, digits) + limits


def combination(row):
    """α, β, γ, δ of a row; empty where it has none."""
    return "" if math.isnan(row["alpha"]) else str(Combination.from_row(row))


def against_zero(low, high):
    """Where a 95 % interval lies: above, below or around 0; unknown without one."""
    if math.isnan(low):
        return "unknown"
    return "above" if low > 0 else "below" if high < 0 else "around"
