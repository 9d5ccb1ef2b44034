"""The spaces of columns with brittle joints: those of other columns, with the bonds behind every phase.

By the types of these spaces the compiler takes the versions of memory.py.
"""

from ..layout import spaces as at
from ..numba_ext.views import Numbers, Space, Table

# the bond of each joint: its ends, m from the middle of the block, and the broken share
BONDS = Table("left", "right", "lost")
GIVEN_OF_BOND = ("tensile_strength", "cohesion")  # Pa, of each joint, behind the blocks in `given` of `assemble`

PHASE = Table(*at.PHASE.fields, *(f"bond_{name}" for name in BONDS.fields))
PHASE.places |= at.PHASE.places
PHASE.reach = at.PHASE.reach | {"slips": PHASE.per_n - at.RIGID_FIELDS}  # copied with the bonds behind
MODEL = Space(**at.MODEL.parts, bonds=Table("reach", "cohesion"))  # m, Pa; such a column has no modal data
STATE = Space(**{**at.STATE.parts, "phase": PHASE})
JOINTS = Table(
    *at.JOINTS.fields,
    "bond_left",  # m from the middle of the block: the bond at the start of the step, an input of an evaluation
    "bond_right",
    "bonded_left",  # m: the part of it that is left in the evaluation
    "bonded_right",
)
_PHASES = dict.fromkeys(("start", "end", "between"), PHASE)
_STAGES = Numbers(per_n=PHASE.per_n * (at.STAGES - 1))
_RESULTANTS = dict.fromkeys(("joints", "joints_halfway"), JOINTS)
WORK = Space(**{**at.WORK.parts, **_PHASES, **_RESULTANTS, "stages": _STAGES}, bonds=Numbers())


def snapshot_size(n: int) -> int:
    """Return the number of values of a snapshot of n blocks."""
    return at.SNAPSHOT.beside + PHASE.per_n * n
