"""Number formats: three significant digits, and percentages with a space before the sign."""

from __future__ import annotations


def three_digits(value: float) -> str:
    """Format a number with three significant digits, or as an integer from 1e3 up to 1e7."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"


def four_digits(value: float) -> str:
    """Format a number with four significant digits, or as an integer from 1e4 up to 1e7."""
    return f"{value:.0f}" if 1e4 <= abs(value) < 1e7 else f"{value:.4g}"


def percent(share: float, digits: str = "") -> str:
    """Format a share in percent, with the format spec `digits` such as ".3f"; "" means three significant digits."""
    value = 100.0 * share
    return f"{value:{digits}} %" if digits else f"{three_digits(value)} %"
