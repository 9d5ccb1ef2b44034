"""The outputs of a column, in the order of kernels/layout/spaces.py (PEAKS): one in each row here.

Those of ports, then of bonds follow an output row; as peaks they precede those of `friction`.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...kernels.layout import spaces as at
from ..outputs import BASE, BLOCK, BOND, JOINT, PORT, Histories, Output, units_of


class ColumnHistories(Histories):
    """The outputs of blocks and joints, block and joint 1 (the top) first, and of the base."""

    ux = Output(BLOCK, "m", "Top face of block {i} relative to the base, positive to +x")
    uz = Output(BLOCK, "m", "Centroid of block {i} from the unloaded geometry, positive up")
    theta = Output(BLOCK, "rad", "Rotation of block {i}, clockwise")
    N = Output(JOINT, "N", "Normal force in the joint under block {i}, compression", 0.0)
    M = Output(JOINT, "N m", "Moment of the pressure about the centre of joint {i}, restoring")
    S = Output(JOINT, "N", "Horizontal shear force on what is under joint {i}, positive to +x")
    contact = Output(JOINT, "", "Part of the width of joint {i} in contact", 0.0, 1.0, by_least=True)
    sigma_max = Output(JOINT, "Pa", "Largest pressure on joint {i}", 0.0)
    T = Output(JOINT, "N", "Force along joint {i} on what is under it, positive to +x")
    slip = Output(JOINT, "m", "Slip of block {i} over what is under it, positive to +x")
    Fx = Output(BASE, "N", "Force of the column on the base, horizontal, positive to +x")
    Fz = Output(BASE, "N", "Force of the column on the base, vertical, positive up")
    My = Output(BASE, "N m", "Moment of the column on the base about the centre of its joint, clockwise")
    port_x = Output(
        PORT, "m", "{it} along x, relative to the base, from the column as built and without weight", name="x"
    )
    port_z = Output(PORT, "m", "{it} upwards", name="z")
    port_vx = Output(PORT, "m/s", "Velocity of {it} along x, relative to the base", name="vx")
    port_vz = Output(PORT, "m/s", "Velocity of {it} upwards", name="vz")
    port_ax = Output(PORT, "m/s2", "Acceleration of {it} along x, relative to the base", name="ax")
    port_az = Output(PORT, "m/s2", "Acceleration of {it} upwards", name="az")
    bond = Output(
        BOND, "", "Part of the mortar of joint {i} that has not broken", 0.0, 1.0, by_least=True, name="share"
    )
    friction = Output(
        JOINT, "", "|T| / N of joint {i}, where N is above 0.05 of the weight carried at rest", only_peak=True
    )

    @property
    def labels(self) -> dict[str, Sequence[object]]:
        """The labels: numbers of blocks and joints, names of ports."""
        return {**super().labels, PORT: [port.name for port in self.model.ports]}


OUTPUTS = ColumnHistories.outputs
UNITS = units_of(OUTPUTS)
_PORTS = [f"port_{name}" for name in at.SPOTS.fields]
_FIELDS = [*at.OUTPUTS.fields, *at.REACTION.fields, *_PORTS, "bond", "friction"]
_ORDER = "solver/models/column/outputs.py: the rows must be, in this order, those of solver/kernels/layout/spaces.py"
assert [output.field for output in OUTPUTS] == _FIELDS, f"{_ORDER}: {', '.join(_FIELDS)}"
