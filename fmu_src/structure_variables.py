"""The table of variables of a structure in space (variables.py has what it shares with that of a column).

Blocks, joints, ties and ports have their numbers in the structure, from 1, and their descriptions contain their names.
The outputs begin with one output row as the kernels write it (solver/kernels/structure/layout.py), then peaks in the
same order.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from solver.ground.loads import COMPONENTS
from solver.ground.motion import STANDARD_GRAVITY
from solver.kernels.structure.layout import DRIVEN, DRIVEN_TURN
from solver.models.outputs import BEARING, BLOCK, BOND, CONTACT, JOINT, PORT, TIE
from solver.models.structure.model import Structure
from solver.models.structure.outputs import OUTPUTS

from .drive import USUAL, Drive
from .references import OF_STRUCTURE, OF_TURNING_STRUCTURE
from .rules import DAMPING_SCALE_LIMITS
from .variables import (
    OVERTURNED_BLOCK,
    SLOPE,
    Variable,
    driven_outputs,
    input_of,
    inputs_of,
    name_behind,
    numbered,
    of_record,
    outcome,
    parameter_of,
    seen,
    tolerance_of,
)

DAMPING_SCALE = "joints.damping_scale"
WITHOUT = "solver.without"
INPUTS = (
    input_of("base.ax", "Base acceleration along x", "m/s2", 1.0),
    input_of("base.ay", "Base acceleration along y", "m/s2", 1.0),
    input_of("base.az", "Base acceleration, vertical, positive up", "m/s2", 1.0),
    input_of("base.jx", SLOPE.format("x"), "m/s3", 10.0),
    input_of("base.jy", SLOPE.format("y"), "m/s3", 10.0),
    input_of("base.jz", SLOPE.format("z"), "m/s3", 10.0),
)
ROTATION = tuple(
    input_of(f"base.{name}_{axis}", text.format(axis), unit, nominal)
    for name, text, unit, nominal in (
        ("theta", "Rotation of the base about {}", "rad", 1e-3),
        ("omega", "Rate of base.theta_{}", "rad/s", 1e-2),
        ("alpha", "Acceleration of base.theta_{}, held within a communication step", "rad/s2", 0.1),
    )
    for axis in "xy"
)


def inputs_of_ports(structure: Structure) -> list[Variable]:
    """Return the loads on the ports, then their slopes, in the order of the kernels (INPUT_LOADS)."""
    return inputs_of(structure.ports, COMPONENTS, _sizes(structure))


def inputs_of_structure(structure: Structure, drive: Drive) -> list[Variable]:
    """Return the inputs in the order of the kernels (kernels/structure/coupled.py).

    They are acceleration, loads on ports, rotation, and the inputs from bodies.
    """
    turns, said = (ROTATION, OF_TURNING_STRUCTURE) if drive.turns else ((), OF_STRUCTURE)
    return [*INPUTS, *inputs_of_ports(structure), *turns, *drive.inputs(said)]


def _direct(structure: Structure, name: str, drive: Drive) -> tuple[str, ...]:
    """Return the inputs that an output depends on without delay.

    Accelerations of ports depend on the loads on their block and on the acceleration of the base.
    """
    owner, _, quantity = name.partition("].")
    if not owner.startswith("port[") or quantity not in ("ax", "ay", "az"):
        return ()
    own, ports = int(owner.removeprefix("port[")), list(enumerate(structure.ports, start=1))
    beside = [p for p, port in ports if port.body == structure.ports[own - 1].body]
    base = () if drive.drive == "body" else (f"base.{quantity}",)
    return (*base, *(f"port[{p}].{component}" for component in COMPONENTS for p in beside))


def structure_variables(
    structure: Structure, record: str = "", reads_files: bool = True, drive: Drive = USUAL
) -> list[Variable]:
    """Return the table, as `variables` for a column. Raises InputError for a structure with too many joints or ties."""
    # names of the owners in descriptions
    names = {BLOCK: numbered(BLOCK, structure.names), JOINT: numbered(JOINT, structure.joint_names)}
    names |= {BEARING: numbered(BEARING, structure.bearing_names), BOND: numbered(BOND, structure.bond_names)}
    names |= {CONTACT: numbered(CONTACT, structure.contact_names)}
    names[PORT] = numbered(PORT, [port.name for port in structure.ports])
    names[TIE] = [f"tie {e}" for e in range(1, len(structure.ties) + 1)]
    # outputs, with the inputs that they depend on
    sizes = _sizes(structure)
    holding = any(joint.bearing and joint.bearing.holds for joint in structure.bearings)
    pulled = ("N", "sigma_max") if holding else ("N",) if structure.bonds else ()
    row, peaks = seen(OUTPUTS, names, lambda unit, i: sizes[unit], pulled)
    direct = {output.name: _direct(structure, output.name, drive) for output in row}
    still = None if drive.turns else ()  # before the first step the structure turns with its base
    row = [
        replace(output, depends_on=direct[output.name], initially=None if direct[output.name] else still)
        for output in row
    ]
    # before the first step extremes are those of the outputs
    peaks = [replace(peak, initially=None if direct.get(name_behind(peak.name)) else still) for peak in peaks]
    parameters = [
        parameter_of(DAMPING_SCALE, "", "Factor on the damping of all joints and ties", 1.0, DAMPING_SCALE_LIMITS[0]),
        tolerance_of(structure.tolerance),
        parameter_of(WITHOUT, "", "What is not to be done: peaks, of forces and moments", ", ".join(structure.without)),
        *drive.parameters,
        *of_record(record, reads_files),
    ]
    fields = (*DRIVEN.fields, *(DRIVEN_TURN.fields if drive.turns else ())) if drive.is_chosen else ()
    moved = [replace(output, initially=still) for output in driven_outputs(fields, {})]
    outcomes = outcome(OVERTURNED_BLOCK, structure.after_fall)
    return [*inputs_of_structure(structure, drive), *row, *moved, *peaks, *outcomes, *parameters]


def _sizes(structure: Structure) -> dict[str, float]:
    """Return the typical size of each output by unit, by which solvers of a system scale."""
    corners = np.concatenate([block.corners for block in structure.blocks])
    extent = float(np.max(np.ptp(corners, axis=0)))
    weight = (structure.g or STANDARD_GRAVITY) * sum(block.mass for block in structure.blocks)
    area = min((joint.face.moments[0] for joint in structure.joints), default=1.0)
    return {
        "m": 1e-3 * extent,
        "m/s": 1e-2,
        "m/s2": 1.0,
        "rad": 1e-3,
        "N": weight,
        "N m": weight * extent / 6.0,
        "": 1.0,
        "Pa": weight / area,
        "J": 1e-3 * extent * weight,
    }
