"""Numbers as texts show them: three digits, and percent with a space before the sign."""

from __future__ import annotations


def three_digits(value: float) -> str:
    """Return a number of three digits, without an exponent where it is large."""
    return f"{value:.0f}" if 1e3 <= abs(value) < 1e7 else f"{value:.3g}"


def percent(share: float, digits: str = "") -> str:
    """Return a share in percent; digits: a format such as .3f, three digits without."""
    value = 100.0 * share
    return f"{value:{digits}} %" if digits else f"{three_digits(value)} %"
