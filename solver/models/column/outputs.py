"""The outputs of a column, in the order of kernels/layout/spaces.py (PEAKS): one in each row here; what runs can store.

Those of ports, then of bonds follow an output row; as peaks they precede those of `friction`.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...common.aliases import Alias
from ...kernels.layout import spaces as at
from ..outputs import BASE, BLOCK, BOND, JOINT, PORT, FloatArray, Histories, Output, units_of
from ..protocol import OF_RUN, Kept, kept_peaks


class ColumnHistories(Histories):
    """The outputs of blocks and joints, block and joint 1 (the top) first, and of the base."""

    ux = Output(BLOCK, "m", "Top face of block {i} relative to the base, positive to +x")
    uz = Output(BLOCK, "m", "Centroid of block {i} from the unloaded geometry, positive up")
    ry = Output(BLOCK, "rad", "Rotation of block {i}, clockwise", name="theta", key="theta")
    N = Output(JOINT, "N", "Normal force in the joint under block {i}, compression", 0.0)
    My = Output(JOINT, "N m", "Moment of the pressure about the centre of joint {i}, restoring", name="M", key="M")
    S = Output(JOINT, "N", "Horizontal shear force on what is under joint {i}, positive to +x")
    contact = Output(JOINT, "", "Part of the width of joint {i} in contact", 0.0, 1.0, by_least=True)
    sigma_max = Output(JOINT, "Pa", "Largest pressure on joint {i}", 0.0)
    Tx = Output(JOINT, "N", "Force along joint {i} on what is under it, positive to +x", name="T", key="T")
    slip = Output(JOINT, "m", "Slip of block {i} over what is under it, positive to +x")
    base_Fx = Output(BASE, "N", "Force of the column on the base, horizontal, positive to +x", name="Fx", key="Fx")
    base_Fz = Output(BASE, "N", "Force of the column on the base, vertical, positive up", name="Fz", key="Fz")
    base_My = Output(
        *(BASE, "N m", "Moment of the column on the base about the centre of its joint, clockwise"), name="My", key="My"
    )
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

    theta, M, T = Alias("ry"), Alias("My"), Alias("Tx")
    Fx, Fz = Alias("base_Fx"), Alias("base_Fz")

    @property
    def base(self) -> FloatArray:
        """The forces (N) and moments (N m) on the base along and about x, y, z, (rows, 6).

        The moment is about the centre of the lowest joint. The components of a column out of its plane are 0.
        """
        zero = np.zeros_like(self.base_Fx)
        return np.stack([self.base_Fx, zero, self.base_Fz, zero, self.base_My, zero], axis=-1)

    @property
    def labels(self) -> dict[str, Sequence[object]]:
        """The labels: numbers of blocks and joints, names of ports."""
        return {**super().labels, PORT: [port.name for port in self.model.ports]}


OUTPUTS = ColumnHistories.outputs
UNITS = units_of(OUTPUTS)
_PORTS = [f"port_{name}" for name in at.SPOTS.fields]
_KEYS = [*at.OUTPUTS.fields, *at.REACTION.fields, *_PORTS, "bond", "friction"]
_ORDER = "solver/models/column/outputs.py: the keys must be, in this order, those of solver/kernels/layout/spaces.py"
assert [output.key for output in OUTPUTS] == _KEYS, f"{_ORDER}: {', '.join(_KEYS)}"


# --- the results of each of many runs that can be stored, by name

WATCHED = {output.kept for output in OUTPUTS if output.field != "ux"}  # peaks that lanes do not watch
# peaks: of the absolute values within the duration; docs/studies.md defines each
KEPT: dict[str, Kept] = {
    # the entries of a joint are listed by its block
    **{
        name: kept if kept.of in (PORT, BOND) else kept._replace(of=BLOCK) for name, kept in kept_peaks(OUTPUTS).items()
    },
    "peak_centroid_ux": Kept("m"),
    "residual_ux": Kept("m"),
    "residual_theta": Kept("rad"),
    "residual_slip": Kept("m"),
    "energy": Kept("J", np.float64),
    **OF_RUN,
    "overturned_joint": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
}
KEYS = {output.extreme: output.kept for output in OUTPUTS if output.extreme != output.kept} | {
    "peak_top_ux": "peak_ux",
    "residual_top_ux": "residual_ux",
    "residual_ry": "residual_theta",
    "fallen": "overturned_joint",
}
