"""Units of acceleration by name."""

from __future__ import annotations

from ...common.errors import InputError, shown

STANDARD_GRAVITY = 9.80665  # m/s2, the g of the records

FACTORS = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01, "gal": 0.01}  # to m/s2
KNOWN = "g, m/s2 or cm/s2"


def factor_of(name: object, line: int = 0, hint: str = "") -> float:
    """Return the factor from a unit to m/s2.

    The usual spellings are known: cm/s^2, cm/sec/sec, CM/SEC**2, gal.

    Parameters
    ----------
    name : object
        The name of the unit.
    line : int
        The line of the file for the message, 0 without one.
    hint : str
        The end of the message.

    Raises
    ------
    InputError
        If the unit is unknown.
    """
    if not isinstance(name, str):
        raise InputError(f"units = {shown(name)}: must be {KNOWN}{hint}")
    plain = name.lower().replace(" ", "").replace("sec", "s").replace("**", "").replace("^", "").replace("/s/s", "/s2")
    if plain not in FACTORS:
        raise InputError(f"{f'line {line}: ' if line else ''}units = {shown(name)}: must be {KNOWN}{hint}")
    return FACTORS[plain]
