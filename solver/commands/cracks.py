"""The report on joints that bear tension or cohesion until they break."""

from __future__ import annotations

from collections.abc import Sequence

from ..models.outputs import FloatArray

MOST = 10  # joints that are named


def cracks(names: Sequence[str], left: FloatArray) -> list[str]:
    """Return a line on the joints that have cracked; no line without such joints.

    Parameters
    ----------
    names : sequence of str
        Names of the joints.
    left : array (len(names),)
        Bonded share of each joint, 0 to 1.
    """
    if not names:
        return []
    hurt = [(name, part) for name, part in zip(names, left, strict=True) if part < 1.0]
    named = [f"{name} {part:.3g}" if part else f"{name} nothing" for name, part in hurt]
    if not named:
        return ["no joint has cracked"]
    beyond = f", and {len(named) - MOST} more" if len(named) > MOST else ""
    return [f"joints that have cracked, and what is bonded of them: {', '.join(named[:MOST])}{beyond}"]
