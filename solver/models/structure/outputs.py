"""The outputs of a structure, one entry for each, in the order of kernels/structure/layout.py; what runs can store."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from ...common.aliases import Alias
from ...common.errors import InputError, shown
from ...kernels.structure import layout as at
from ..outputs import BASE, BEARING, BLOCK, BOND, CONTACT, JOINT, PORT, TIE, Histories, Output, component, units_of
from ..protocol import OF_RUN, Kept, kept_peaks
from .blocks.faces import FloatArray
from .blocks.shapes import turned

if TYPE_CHECKING:
    from .model import Structure


class StructureHistories(Histories):
    """Output rows (rows, numbers) of a structure: of its parts and of its base."""

    ux = Output(
        BLOCK, "m", "Centroid of {it} along x, relative to the base, from the structure as built and without weight"
    )
    uy = Output(BLOCK, "m", "Centroid of {it} along y")
    uz = Output(BLOCK, "m", "Centroid of {it} upwards")
    rx = Output(BLOCK, "rad", "Rotation of {it}, axis times angle, about x")
    ry = Output(BLOCK, "rad", "Rotation of {it}, axis times angle, about y")
    rz = Output(BLOCK, "rad", "Rotation of {it}, axis times angle, about z")
    N = Output(JOINT, "N", "Normal force in {it}, compression", 0.0)
    Mx = Output(JOINT, "N m", "Moment of the pressure about the first axis of {it}, restoring")
    My = Output(JOINT, "N m", "Moment of the pressure about the second axis of {it}, restoring")
    Tx = Output(JOINT, "N", "Force along the first axis of {it} on its second block")
    Ty = Output(JOINT, "N", "Force along the second axis of {it} on its second block")
    Mz = Output(JOINT, "N m", "Twisting moment in {it}, restoring")
    contact = Output(JOINT, "", "Part of the area of {it} in contact", 0.0, 1.0, by_least=True)
    sigma_max = Output(JOINT, "Pa", "Largest pressure on {it}", 0.0)
    slip = Output(JOINT, "m", "Size of the slip of {it}, by which friction has given way", 0.0)
    tie = Output(TIE, "N", "Force in {it}, tension", name="F")
    dx = Output(BEARING, "m", "Displacement of the first block of {it} over the second, along its first axis")
    dy = Output(BEARING, "m", "Displacement of the first block of {it} over the second, along its second axis")
    d = Output(BEARING, "m", "Displacement of {it}, whichever way", 0.0)
    bond = Output(
        *(BOND, "", "Part of the area of {it} that has not broken", 0.0, 1.0),
        by_least=True,
        name="share",
    )
    gap = Output(
        CONTACT,
        "m",
        "Distance of {it}, below 0 while they press on each other, 1e6 while they cannot meet",
        by_least=True,
    )
    hit = Output(CONTACT, "N", "Force across of {it}, compression", 0.0, name="force")
    port_x = Output(
        PORT, "m", "{it} along x, relative to the base, from the structure as built and without weight", name="x"
    )
    port_y = Output(PORT, "m", "{it} along y", name="y")
    port_z = Output(PORT, "m", "{it} upwards", name="z")
    port_vx = Output(PORT, "m/s", "Velocity of {it} along x, relative to the base", name="vx")
    port_vy = Output(PORT, "m/s", "Velocity of {it} along y", name="vy")
    port_vz = Output(PORT, "m/s", "Velocity of {it} upwards", name="vz")
    port_ax = Output(PORT, "m/s2", "Acceleration of {it} along x, relative to the base", name="ax")
    port_ay = Output(PORT, "m/s2", "Acceleration of {it} along y", name="ay")
    port_az = Output(PORT, "m/s2", "Acceleration of {it} upwards", name="az")
    base = Output(
        *(BASE, ""),
        parts=(
            Output(BASE, "N", "Force of the structure on the base along x", name="Fx"),
            Output(BASE, "N", "Force of the structure on the base along y", name="Fy"),
            Output(BASE, "N", "Force of the structure on the base, upwards", name="Fz"),
            Output(BASE, "N m", "Moment of the structure on the base about x through the origin", name="Mx"),
            Output(BASE, "N m", "Moment of the structure on the base about y through the origin", name="My"),
            Output(BASE, "N m", "Moment of the structure on the base about z through the origin", name="Mz"),
        ),
    )

    model: Structure
    line_end = "\n"
    structure = Alias("model")
    base_Fx, base_Fy, base_Fz, base_Mx, base_My, base_Mz = (component("base", k) for k in range(6))

    @property
    def labels(self) -> dict[str, Sequence[object]]:
        """The names of blocks, joints, neighbours and ports, the numbers of ties, the components of the base."""
        structure = self.model
        ties = [str(e) for e in range(1, len(structure.ties) + 1)]
        base = [part.name_of("") for part in StructureHistories.base.parts]
        joints = {BLOCK: structure.names, JOINT: structure.joint_names, BEARING: structure.bearing_names}
        joints[CONTACT] = structure.contact_names
        joints[BOND] = structure.bond_names
        return {**joints, TIE: ties, PORT: [port.name for port in structure.ports], BASE: base}

    @property
    def rotation(self) -> FloatArray:
        """The rotation vector of each block, axis times angle, rad (rows, n, 3)."""
        return np.stack([self.rx, self.ry, self.rz], axis=-1)

    @property
    def opening(self) -> FloatArray:
        """The largest gap of each joint, m (rows, joints), between the upper face and the plane of the lower one.

        It is 0 where the whole joint is in contact. The faces are those as built.
        """
        structure, turns = self.model, self.rotation
        moves = np.stack([self.ux, self.uy, self.uz], axis=-1)
        still = np.zeros((len(moves), 3))
        found = np.empty((len(moves), len(structure.joints)))
        for j, joint in enumerate(structure.joints):
            face, sides = joint.face, []
            for i in (joint.upper, joint.lower):
                block = structure.blocks[i] if i < structure.n else None
                turn = still if block is None else turns[:, i]
                centre = still if block is None else moves[:, i] + turned(turn, face.centre - block.centroid)
                sides.append((centre, *(turned(turn, axis) for axis in face.axes.T)))
            upper, lower = sides
            normal = face.normal + lower[3]
            apart, x, y = (
                np.sum((one - other) * normal, axis=1) for one, other in zip(upper[:3], lower[:3], strict=True)
            )
            if joint.bearing is not None:  # at its point, above the surface of the pendulum
                moved = np.sum((upper[0] - lower[0]) ** 2, axis=1) - apart**2
                found[:, j] = apart - 0.5 * joint.bearing.pendulum * moved
            elif face.radius:
                found[:, j] = apart + face.radius * np.hypot(x, y)
            else:
                found[:, j] = apart + np.max(np.outer(face.outline[:, 0], x) + np.outer(face.outline[:, 1], y), axis=0)
        return np.where(self.contact < 1.0, np.maximum(found, 0.0), 0.0)  # pendulum bearings rise, and do not open

    def displacement(self, block: str | int, point: Sequence[float] = (0.0, 0.0, 0.0)) -> FloatArray:
        """Return the displacement of a point of a block, by its name or index, m (rows, 3).

        The point is from the centroid along the axes of the block, m. Raises InputError if there is no such block, or
        the point is not three lengths.
        """
        i = self.model.number(block)
        place = np.asarray(point)
        if place.shape != (3,) or place.dtype.kind not in "iuf" or not np.all(np.isfinite(place)):
            raise InputError(f"point = {shown(point)}: must be three lengths in m")
        arm = self.model.blocks[i].axes @ place
        moved = np.column_stack([self.ux[:, i], self.uy[:, i], self.uz[:, i]])
        return moved + turned(self.rotation[:, i], arm)


OUTPUTS = StructureHistories.outputs
UNITS = units_of(OUTPUTS)
_PORTS = [f"port_{name}" for name in at.OF_PORT]
_NAMES = [*at.OF_BLOCK, *at.OF_JOINT, "tie", *at.OF_BEARING, *at.OF_BOND, *at.OF_PAIR, *_PORTS, *at.OF_BASE]
_ORDER = "solver/models/structure/outputs.py: the rows must be, in this order, those of"
_ORDER = f"{_ORDER} solver/kernels/structure/layout.py: {', '.join(_NAMES)}"
assert [one.name if one.owner == BASE else one.field for output in OUTPUTS for one in output.each] == _NAMES, _ORDER


# --- the results of each of many runs that can be stored, by name

ALWAYS_KEPT = {
    **OF_RUN,
    "fallen": Kept(kind=np.int64),
    "evaluations": Kept(kind=np.int64),
    "settled_for": Kept("s", np.float64),
}
KEPT: dict[str, Kept] = {**ALWAYS_KEPT, "peak_u": Kept("m"), **kept_peaks(OUTPUTS)}
KEPT |= {f"peak_base_{one.name}": Kept(one.unit, np.float64, BASE) for one in StructureHistories.base.parts}
KEPT["least_contact"] = KEPT.pop("least_contact")  # the last one
DISPLACEMENTS = "ux", "uy", "uz"  # the peaks of a run without peaks, beside that of u
FROM_LANES = {*ALWAYS_KEPT, "peak_u", *(f"peak_{name}" for name in DISPLACEMENTS), "peak_d", "least_gap", "least_bond"}
KEYS = {"peak_centroid_ux": "peak_ux"}
