"""Value references: the numbers by which programs that run an FMU address its variables."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from solver.common.ranges import MAX_BLOCKS
from solver.ground.loads import COMPONENTS
from solver.kernels.structure.layout import OF_PORT

MOST_BODIES = 9  # bodies that drive a base
# inputs from a body for a column and for a structure, in the order of the kernels
OF_COLUMN = ("F0x", "F0z", "F0m", "Mxx", "Mxz", "Mxt", "Mzz", "Mzt", "Mtt")
OF_STRUCTURE = ("F0x", "F0y", "F0z", "M")
OF_TURNING_STRUCTURE = (*OF_STRUCTURE, "F0mx", "F0my", "Mxry", "Myrx", "Jxx", "Jyy", "Jxy")
SAID = (*OF_COLUMN, "F0y", "M", *OF_TURNING_STRUCTURE[len(OF_STRUCTURE) :])


def names_of_body(k: int, said: Sequence[str]) -> list[str]:
    """Return the names of the inputs of body k, from 0: body.F0x, body2.F0x and so on."""
    return [f"body{k + 1 if k else ''}.{name}" for name in said]


# motion of a base that bodies drive
MOVED = tuple(
    f"driven.{name}"
    for name in (
        *("x", "y", "z", "theta", "theta_x", "theta_y", "vx", "vy", "vz", "omega", "omega_x", "omega_y"),
        *("ax", "ay", "az", "alpha", "alpha_x", "alpha_y"),
    )
)
# Numbers are permanent: a new variable takes the next free one, a removed one leaves a gap.
REFERENCES = {
    # inputs: from 1
    "base.ax": 1,
    "base.az": 2,
    "base.jx": 3,
    "base.jz": 4,
    "base.theta": 5,
    "base.omega": 6,
    "base.alpha": 7,
    "base.ay": 8,
    "base.jy": 9,
    "base.theta_x": 10,
    "base.theta_y": 11,
    "base.omega_x": 12,
    "base.omega_y": 13,
    "base.alpha_x": 14,
    "base.alpha_y": 15,
    # of the bodies that drive the base: from 100, 200 and so on
    **{name: 100 * (k + 1) + i for k in range(MOST_BODIES) for i, name in enumerate(names_of_body(k, SAID))},
    # outputs of the column or structure as a whole: from 1001
    "base.Fx": 1001,
    "base.Fz": 1002,
    "base.My": 1003,
    "base.R0x": 1004,
    "base.R0z": 1005,
    "base.R0m": 1006,
    "base.mxx": 1007,
    "base.mxz": 1008,
    "base.mxt": 1009,
    "base.mzz": 1010,
    "base.mzt": 1011,
    "base.mtt": 1012,
    "overturn_time": 1013,
    "overturn_joint": 1014,
    "overturned": 1015,
    "verdict": 1016,
    "base.record_pga": 1017,
    "base.Fx_peak": 1018,
    "base.Fz_peak": 1019,
    "base.My_peak": 1020,
    "base.Fy": 1021,
    "base.Mx": 1022,
    "base.Mz": 1023,
    "base.Fy_peak": 1024,
    "base.Mx_peak": 1025,
    "base.Mz_peak": 1026,
    "overturned_block": 1027,
    # of a base that bodies drive
    **{name: 1028 + i for i, name in enumerate(MOVED)},
    # parameters of the column or structure as a whole: from 2001
    "g": 2001,
    "solver.step": 2004,
    "solver.tolerance": 2005,
    "solver.without": 2006,
    "base.record": 2007,
    "base.record_scale": 2008,
    "joints.damping_scale": 2009,
    "base.drive": 2010,
    "base.slope": 2011,
}
# Variables of every block, joint, tie, bearing, pair of neighbours or port: a family each, of 1000 numbers.
FAMILY = 1000
FAMILIES = {
    "block.ux": 10,
    "block.uz": 11,
    "block.theta": 12,
    "joint.N": 13,
    "joint.M": 14,
    "joint.S": 15,
    "joint.contact": 16,
    "joint.sigma_max": 17,
    "joint.T": 18,
    "joint.slip": 19,
    "block.ux_peak": 20,
    "block.uz_peak": 21,
    "block.theta_peak": 22,
    "joint.N_peak": 23,
    "joint.M_peak": 24,
    "joint.S_peak": 25,
    "joint.contact_least": 26,
    "joint.sigma_max_peak": 27,
    "joint.T_peak": 28,
    "joint.friction_peak": 29,
    "joint.slip_peak": 30,
    "block.uy": 31,
    "block.rx": 32,
    "block.ry": 33,
    "block.rz": 34,
    "joint.Mx": 35,
    "joint.My": 36,
    "joint.Mz": 37,
    "joint.Tx": 38,
    "joint.Ty": 39,
    "tie.F": 40,
    "block.uy_peak": 41,
    "block.rx_peak": 42,
    "block.ry_peak": 43,
    "block.rz_peak": 44,
    "joint.Mx_peak": 45,
    "joint.My_peak": 46,
    "joint.Mz_peak": 47,
    "joint.Tx_peak": 48,
    "joint.Ty_peak": 49,
    "block.height": 50,
    "block.width": 51,
    "block.depth": 52,
    "block.mass": 53,
    "block.centroid": 54,
    "block.inertia": 55,
    "joint.stiffness": 56,
    "joint.damping": 57,
    "joint.width": 58,
    "joint.depth": 59,
    "joint.friction": 60,
    "joint.dowel": 61,
    "joint.offset": 62,
    "joint.inclination": 63,
    "block.tilt": 64,
    "tie.F_peak": 65,
    "bearing.dx": 66,
    "bearing.dy": 67,
    "bearing.d": 68,
    "bearing.dx_peak": 69,
    "bearing.dy_peak": 70,
    "bearing.d_peak": 71,
    "contact.gap": 72,
    "contact.force": 73,
    "contact.gap_least": 74,
    "contact.force_peak": 75,
    "bond.share": 76,
    "bond.share_least": 77,
    **{f"port.{name}": 80 + i for i, name in enumerate(OF_PORT)},
    **{f"port.{name}_peak": 89 + i for i, name in enumerate(OF_PORT)},
    **{f"port.{name}": 98 + i for i, name in enumerate(COMPONENTS)},
    **{f"port.d{name}": 104 + i for i, name in enumerate(COMPONENTS)},
    "joint.tensile_strength": 110,
    "joint.cohesion": 111,
    "joint.rim": 112,
}
assert MAX_BLOCKS <= FAMILY


def reference_of(name: str) -> int:
    """Return the value reference of a variable: that of REFERENCES, or 1000 times its family plus its number.

    Raises LookupError for a name without one.
    """
    parts = re.fullmatch(r"(block|joint|tie|bearing|bond|contact|port)\[(\d+)\]\.(\w+)", name)
    if parts is None:
        return _number(REFERENCES, "REFERENCES", name)
    owner, number, quantity = parts.groups()
    return FAMILY * _number(FAMILIES, "FAMILIES", f"{owner}.{quantity}") + int(number)


def _number(table: Mapping[str, int], of: str, name: str) -> int:
    if name not in table:
        raise LookupError(f"{name}: has no number in {of} (fmu_src/references.py)")
    return table[name]


def array_of(name: str) -> str:
    """Return the array of a variable of a block, joint, tie or port: block.ux for block[3].ux; "" for others."""
    parts = re.fullmatch(r"(\w+)\[\d+\]\.(\w+)", name)
    return f"{parts[1]}.{parts[2]}" if parts else ""
