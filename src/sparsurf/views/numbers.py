"""Format numbers for people: on pages, in figures and on the command line."""

import math


def number(x: float | None, digits: int = 2) -> str:
    """Format a number with a true minus sign; empty if it is unknown, never -0."""
    if x is None or math.isnan(x):
        return ""
    return f"{x:z.{digits}f}".replace("-", "−").replace("inf", "∞")


def decimals(x: float, least: int) -> int:
    """Return with how many decimals a positive number shows two digits that are not leading zeros, at least `least`."""
    return max(least, 1 - math.floor(math.log10(x))) if x > 0 else least


def signed(x: float, digits: int) -> str:
    """Format a number with its sign; a rounded 0 has none."""
    text = number(x, digits)
    return text if math.isnan(x) or x <= 0 or not text.strip("0.") else f"+{text}"


def share(percent: float) -> str:
    """Format a share in %: without decimals between 10 and 99.5, else with one decimal if it is not 0."""
    return f"{percent:.0f}" if 9.95 <= percent < 99.5 else f"{percent:.1f}".removesuffix(".0")


def interval(value: float, low: float, high: float, digits: int = 2) -> str:
    """Format a value with its limits in brackets if it has any."""
    limits = f" ({number(low, digits)} to {number(high, digits)})" if not math.isnan(low) else ""
    return number(value, digits) + limits
