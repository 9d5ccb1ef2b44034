"""The question of `new` where faces touch: all over, in a rim along their edges, or on two feet."""

from __future__ import annotations

from typing import NamedTuple

from .questions import Limits, Question, choice, number

WHOLE, RIM, FEET = "whole", "rim", "feet"
PART = 1.0 / 6.0  # of the width: the rim that fits the tests of granite blocks (docs/materials.md)
LEAST_RIM = 1e-4  # m
MOST_STRIPS = 32
MEANINGS = {
    WHOLE: "all over, as in mortar; a dry block then loses less at an impact than tested granite",
    RIM: "in a band along their edges, as dressed drums (anathyrosis); nearest to tests of granite blocks",
    FEET: "on two feet at the edges, across the motion; nearest to Housner's rigid block",
}


class Touching(NamedTuple):
    """The part of the faces that touches: all of it, or a rim or feet of this width."""

    rim: float = 0.0  # m
    foot: float = 0.0  # m, of the top block

    @property
    def everywhere(self) -> bool:
        """True if whole faces touch."""
        return not (self.rim or self.foot)


EVERYWHERE = Touching()


def asked_contact(width: float, mortared: bool, stands_alone: bool) -> Touching:
    """Ask where faces touch, and for the width of the rim or of a foot.

    Parameters
    ----------
    width : float
        Width of the smallest face (m).
    mortared : bool
        True if mortar fills the joints: whole faces are proposed, else a rim.
    stands_alone : bool
        True if the top block may stand on feet.
    """
    meanings = {key: text for key, text in MEANINGS.items() if key != FEET or stands_alone}
    chosen = choice("where faces touch", meanings, WHOLE if mortared else RIM)
    if chosen == WHOLE:
        return EVERYWHERE
    proposed = float(f"{PART * width:.2g}")
    what = "the rim" if chosen == RIM else "each foot, across the motion"
    limits: Limits = (
        (LEAST_RIM if chosen == RIM else width / MOST_STRIPS, 0.5 * width),
        f"a width in m, up to half of the smallest face, {0.5 * width:.4g}",
    )
    asked = number(
        Question(f"width of {what} (m); proposed: a sixth of the smallest face, as tests of granite", proposed, limits)
    )
    return Touching(rim=asked) if chosen == RIM else Touching(foot=asked)


def strips_of(touching: Touching, block: dict[str, float]) -> list[str]:
    """Return the lines of a block that stands on two feet; none without feet."""
    if not touching.foot:
        return []
    count = min(MOST_STRIPS, max(3, round(block["width"] / touching.foot)))
    depth = f"{block['depth']:.10g}"
    strips = ", ".join([depth, *["0.0"] * (count - 2), depth])
    return [
        'joint.section = "strips"     # of equal width across the motion; it stands on the first and the last',
        f"joint.strips = [{strips}]  # m, depths",
    ]
