"""The question of `new` where faces touch: all over, in a rim along their edges, or on two feet."""

from __future__ import annotations

from typing import NamedTuple

from ..kernels.layout.spaces import MOST_STRIPS
from .questions import Limits, Question, choice, number

WHOLE, RIM, FEET = "whole", "rim", "feet"
PART = 1.0 / 6.0  # of the width: the rim that fits the tests of granite blocks (docs/materials.md)
LEAST_RIM = 1e-4  # m
NEAR = 0.01  # of its width: a foot of another width is said in the file
# parts of its width that a foot may have, with the number of strips of each: at least one strip lies between two feet
FEET_OF = {
    feet / strips: (feet, strips) for strips in range(MOST_STRIPS, 2, -1) for feet in range(1, (strips + 1) // 2)
}
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


def asked_contact(width: float, mortared: bool, standing: float = 0.0) -> Touching:
    """Ask where faces touch, and for the width of the rim or of a foot.

    `width` is that of the smallest face (m), `standing` that of the top block if it may stand on feet, else 0. If
    mortar fills the joints, whole faces are proposed, else a rim.
    """
    meanings = {key: text for key, text in MEANINGS.items() if key != FEET or standing}
    chosen = choice("where faces touch", meanings, WHOLE if mortared else RIM)
    if chosen == WHOLE:
        return EVERYWHERE
    if chosen == RIM:
        what, face = "the rim", "smallest face"
        limits: Limits = (LEAST_RIM, 0.5 * width), f"a width in m, up to half of the smallest face, {0.5 * width:.4g}"
    else:
        what, face, width = "each foot, across the motion", "face", standing
        least, most = (part * width for part in (min(FEET_OF), max(FEET_OF)))
        limits = (least, most), f"a width in m, from {least:.4g} to {most:.4g}: at most {MOST_STRIPS} strips"
    proposed = float(f"{PART * width:.2g}")
    words = f"width of {what} (m); proposed: a sixth of the {face}, as tests of granite"
    asked = number(Question(words, proposed, limits))
    return Touching(rim=asked) if chosen == RIM else Touching(foot=asked)


def strips_of(touching: Touching, block: dict[str, float]) -> list[str]:
    """Return the lines of a block that stands on two feet of the nearest possible width; none without feet."""
    if not touching.foot:
        return []
    part = touching.foot / block["width"]
    nearest = min(FEET_OF, key=lambda possible: abs(possible - part))
    feet, count = FEET_OF[nearest]
    depth, made = f"{block['depth']:.10g}", f"{nearest * block['width']:.4g} m wide"
    if abs(nearest - part) > NEAR * part:
        made += f", nearest to {touching.foot:.4g} m"
    strips = ", ".join([depth] * feet + ["0.0"] * (count - 2 * feet) + [depth] * feet)
    return [
        f'joint.section = "strips"     # of equal width across the motion; it stands on two feet {made}',
        f"joint.strips = [{strips}]  # m, depths",
    ]
