"""The spaces of columns with brittle joints: those of other columns, with what is bonded behind every phase.

By the types of these the compiler takes the versions of memory.py.
"""

from ..layout import spaces as at
from ..numba_ext.views import Numbers, Space, Table

# of what is bonded of each joint: its ends, m from the middle of the block, and the part that has broken
BONDS = Table("left", "right", "lost")
GIVEN_OF_BOND = ("tensile_strength", "cohesion")  # of each joint, Pa, behind the blocks that `assemble` is given

PHASE = Table(*at.PHASE.fields, *(f"bond_{name}" for name in BONDS.fields))
PHASE.places |= at.PHASE.places
PHASE.reach = at.PHASE.reach | {"slips": PHASE.per_n - at.RIGID_FIELDS}  # copied with what is behind
MODEL = Space(**at.MODEL.parts, bonds=Table("reach", "cohesion"))  # m, Pa; such a column has no modal data
STATE = Space(**{**at.STATE.parts, "phase": PHASE})
JOINTS = Table(
    *at.JOINTS.fields,
    "bond_left",  # m from the middle of the block: what is bonded at the start of the step, an input of an evaluation,
    "bond_right",
    "bonded_left",  # and what is left of it then
    "bonded_right",
)
_PHASES = dict.fromkeys(("start", "end", "between"), PHASE)
_STAGES = Numbers(per_n=PHASE.per_n * (at.STAGES - 1))
_RESULTANTS = dict.fromkeys(("joints", "joints_halfway"), JOINTS)
WORK = Space(**{**at.WORK.parts, **_PHASES, **_RESULTANTS, "stages": _STAGES}, bonds=Numbers())


def snapshot_size(n: int) -> int:
    """Numbers of a snapshot of n blocks."""
    return at.SNAPSHOT.beside + PHASE.per_n * n
