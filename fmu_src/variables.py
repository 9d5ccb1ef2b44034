"""The one table of the FMU's variables; the slave and the model description both follow from it.

Value references count the table's rows. Real variables come first, in the order of the slave's list of numbers: inputs,
then one output row as the kernels write it (solver/kernels/layout.py), then what else is visible, then the parameters.
What came later stands behind all that, so that references stay: rotation of the base, its reaction split.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from itertools import accumulate
from typing import Any

from solver.column import SKIPS, Block, Column, Joint, Settings
from solver.motion import STANDARD_GRAVITY
from solver.response import BASE_HISTORIES, BLOCK_HISTORIES

# places of the inputs in the slave's list of values
AX = 0
AZ = 1
JX = 2
JZ = 3

START_TIME = 0.0  # s
STOP_TIME = 20.0  # s
STEP_SIZE = 1e-3  # s


@dataclass(frozen=True)
class Variable:
    """One row of the table. A unit of "" is a pure number; `depends_on` names inputs that act without delay."""

    name: str
    kind: str  # Real, Integer, Boolean or String
    causality: str  # input, output or parameter
    variability: str
    description: str
    unit: str = ""
    start: float | int | bool | str | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    depends_on: tuple[str, ...] = ()


def _input(name: str, text: str, unit: str, nominal: float) -> Variable:
    return Variable(name, "Real", "input", "continuous", text, unit, 0.0, nominal=nominal)


_SLOPE = "Slope of base.a{} within a communication step, counted from its start; 0: held"
INPUTS = (
    _input("base.ax", "Base acceleration, horizontal, positive to +x", "m/s2", 1.0),
    _input("base.az", "Base acceleration, vertical, positive up", "m/s2", 1.0),
    _input("base.jx", _SLOPE.format("x"), "m/s3", 10.0),
    _input("base.jz", _SLOPE.format("z"), "m/s3", 10.0),
)
ROTATION_INPUTS = (
    _input("base.theta", "Rotation of the base, clockwise", "rad", 1e-3),
    _input("base.omega", "Rate of base.theta", "rad/s", 1e-2),
    _input("base.alpha", "Acceleration of base.theta, held within a communication step", "rad/s2", 0.1),
)
_TURNED = ("base.theta",)
_TURNING = ("base.theta", "base.omega")
_ALL = ("base.ax", "base.az", *_TURNING, "base.alpha")

# history -> unit, description, least and largest value, inputs it depends on without delay (of the base joint, if it is
# a joint's own)
_BLOCK_OUTPUTS: dict[str, tuple[str, str, float | None, float | None, tuple[str, ...]]] = {
    "ux": ("m", "Top face of block {i} relative to the base, positive to +x", None, None, _TURNED),
    "uz": ("m", "Centroid of block {i} from the unloaded geometry, positive up", None, None, _TURNED),
    "theta": ("rad", "Rotation of block {i}, clockwise", None, None, ()),
    "N": ("N", "Normal force in the joint under block {i}, compression", 0.0, None, _TURNING),
    "M": ("N.m", "Moment of the pressure about the centre of joint {i}, restoring", None, None, _TURNING),
    "S": ("N", "Horizontal shear force on what is under joint {i}, positive to +x", None, None, _ALL),
    "contact": ("", "Part of the width of joint {i} in contact", 0.0, 1.0, _TURNING),
    "sigma_max": ("Pa", "Largest pressure on joint {i}", 0.0, None, _TURNING),
}
_BASE_OUTPUTS = {
    "Fx": ("N", "Force of the column on the base, horizontal, positive to +x"),
    "Fz": ("N", "Force of the column on the base, vertical, positive up"),
    "My": ("N.m", "Moment of the column on the base about the centre of its joint, clockwise"),
}
_SPLIT = "of the base reaction (Fx, Fz, My) = R0 - m (ax, az, alpha)"
_MASS = "Effective mass met by the base, {} " + _SPLIT
# the split of the reaction in the order of the kernels (layout.py, SPLIT): unit, description, inputs it depends on
_SPLIT_OUTPUTS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "base.R0x": ("N", f"Horizontal part R0 {_SPLIT}", _TURNING),
    "base.R0z": ("N", f"Vertical part R0 {_SPLIT}", _TURNING),
    "base.R0m": ("N.m", f"Moment R0 {_SPLIT}", _TURNING),
    "base.mxx": ("kg", _MASS.format("xx"), _TURNED),
    "base.mxz": ("kg", _MASS.format("xz"), _TURNED),
    "base.mxt": ("kg.m", _MASS.format("x alpha"), _TURNED),
    "base.mzz": ("kg", _MASS.format("zz"), _TURNED),
    "base.mzt": ("kg.m", _MASS.format("z alpha"), _TURNED),
    "base.mtt": ("kg.m2", _MASS.format("alpha alpha"), _TURNED),
}
OVERTURN_TIME = Variable(
    "overturn_time", "Real", "output", "discrete", "Time of overturning, -1 while the column stands", "s"
)
RECORD_PGA = Variable(
    "base.record_pga", "Real", "output", "discrete", "Largest |ax| of the record inside the FMU, 0 without one", "m/s2"
)
OVERTURN_JOINT = Variable(
    "overturn_joint", "Integer", "output", "discrete", "Joint over which the column has fallen, 0 while it stands"
)
OVERTURNED = Variable(
    "overturned", "Boolean", "output", "discrete", "Whether the column has overturned; then it is held"
)

# field of Block or Joint -> unit, description, whether 0 stands for "not given"
_BLOCK_PARAMETERS = {
    "height": ("m", "Height of block {i}", False),
    "width": ("m", "Width of block {i}, along the motion", False),
    "depth": ("m", "Depth of block {i}, across the motion", False),
    "mass": ("kg", "Mass of block {i}", False),
    "centroid": ("m", "Centroid of block {i} above its bottom face; 0: half the height", True),
    "inertia": ("kg.m2", "Moment of inertia of block {i} about its centroid; 0: homogeneous block", True),
}
_JOINT_PARAMETERS = {
    "stiffness": ("N/m3", "Winkler modulus of the joint under block {i}", False),
    "damping": ("s", "Damping eta of the joint under block {i}", False),
    "width": ("m", "Contact width of the joint under block {i}; 0: that of the block", True),
    "depth": ("m", "Contact depth of the joint under block {i}; 0: that of the block", True),
}
# what may change during a run: no length, no mass, nothing of the solver's
TUNABLE = ("g", "joint.damping")
RECORD = "base.record"
RECORD_SCALE = "base.record_scale"
# least and largest value of the parameters whose least is not 0 alone
LIMITS: dict[str, tuple[float | None, float | None]] = {
    RECORD_SCALE: (None, None),
    "solver.tolerance": (1e-13, 0.1),
}

_SETTINGS_PARAMETERS = {
    "step": ("s", "Step of an integrator with a fixed step"),
    "tolerance": ("", "Error, relative to the peak, of an integrator that chooses its steps"),
    "formulation": ("", "exact or paper"),
    "integrator": ("", "auto or central-difference"),
    "without": ("", f"Short cuts not to be taken, with commas between: {', '.join(SKIPS)}"),
}


def variables(column: Column, record: str = "") -> list[Variable]:
    """The table for a column, whose values are the parameters' start values, in the order told above.

    record: name of the record inside the FMU, empty without one.
    """
    table = [*INPUTS, *_outputs(column), OVERTURN_TIME, RECORD_PGA, *_parameters(column, record)]
    reals = [variable for variable in table if variable.kind == "Real"]
    others = [variable for variable in table if variable.kind != "Real"]
    return [*reals, OVERTURN_JOINT, OVERTURNED, *others, *ROTATION_INPUTS, *_split_outputs(column)]


def _outputs(column: Column) -> list[Variable]:
    sizes = _sizes(column)
    rows = []
    for name, _, output in sorted(BLOCK_HISTORIES, key=lambda history: history[1]):
        unit, description, minimum, maximum, inputs = _BLOCK_OUTPUTS[name]
        for i in range(1, column.n + 1):
            text = description.format(i=i)
            limits = {"minimum": minimum, "maximum": maximum, "nominal": sizes[name][i - 1]}
            direct = () if inputs == _TURNING and i < column.n else inputs
            rows.append(
                Variable(output.format(i=i), "Real", "output", "continuous", text, unit, **limits, depends_on=direct)
            )
    for name, _, output in sorted(BASE_HISTORIES, key=lambda history: history[1]):
        unit, text = _BASE_OUTPUTS[name]
        size = sizes["M" if name == "My" else "N"][-1]
        rows.append(Variable(output, "Real", "output", "continuous", text, unit, nominal=size, depends_on=_ALL))
    return rows


def _split_outputs(column: Column) -> list[Variable]:
    sizes = _sizes(column)
    mass = sum(block.mass for block in column.blocks)
    width = column.blocks[-1].joint_width
    nominal = {"N": sizes["N"][-1], "N.m": sizes["M"][-1], "kg": mass, "kg.m": mass * width, "kg.m2": mass * width**2}
    return [
        Variable(name, "Real", "output", "continuous", text, unit, nominal=nominal[unit], depends_on=inputs)
        for name, (unit, text, inputs) in _SPLIT_OUTPUTS.items()
    ]


def _sizes(column: Column) -> dict[str, list[float]]:
    """How large each output of a block or joint typically is, from the top down: what solvers of a system scale by."""
    blocks = column.blocks
    height = sum(block.height for block in blocks)
    weights = list(accumulate((column.g or STANDARD_GRAVITY) * block.mass for block in blocks))
    return {
        "ux": [1e-3 * height] * column.n,
        "uz": [1e-3 * height] * column.n,
        "theta": [1e-3] * column.n,
        "N": weights,
        "M": [weight * block.joint_width / 6.0 for weight, block in zip(weights, blocks, strict=True)],
        "S": weights,
        "contact": [1.0] * column.n,
        "sigma_max": [
            weight / (block.joint_width * block.joint_depth) for weight, block in zip(weights, blocks, strict=True)
        ],
    }


def _parameters(column: Column, record: str) -> list[Variable]:
    def parameter(name: str, unit: str, text: str, start: float | str, tunable: bool = False) -> Variable:
        variability = "tunable" if tunable else "fixed"
        if isinstance(start, str):
            return Variable(name, "String", "parameter", variability, text, unit, start)
        minimum, maximum = LIMITS.get(name, (0.0, None))
        return Variable(name, "Real", "parameter", variability, text, unit, start, minimum, maximum)

    rows = [parameter("g", "m/s2", "Acceleration of gravity", column.g, "g" in TUNABLE)]
    for i, block in enumerate(column.blocks, start=1):
        for key, (unit, text, _) in _BLOCK_PARAMETERS.items():
            rows.append(parameter(f"block[{i}].{key}", unit, text.format(i=i), getattr(block, key) or 0.0))
    for i, block in enumerate(column.blocks, start=1):
        for key, (unit, text, _) in _JOINT_PARAMETERS.items():
            start = getattr(block.joint, key) or 0.0
            rows.append(parameter(f"joint[{i}].{key}", unit, text.format(i=i), start, f"joint.{key}" in TUNABLE))
    for key, (unit, text) in _SETTINGS_PARAMETERS.items():
        start = getattr(column.settings, key)
        rows.append(parameter(f"solver.{key}", unit, text, ", ".join(start) if key == "without" else start))
    rows.append(parameter(RECORD_SCALE, "", "Factor on the record's accelerations", 1.0))
    text = "Record added to the inputs: name of the one inside the FMU, or path of one (AT2, ESM, K-NET, COSMOS, CSV)"
    rows.append(parameter(RECORD, "", text, record))
    return rows


def parameter_names(message: str) -> str:
    """A message about a column, with the FMU's names for the keys of its joints."""
    return re.sub(r"block\[(\d+)\]\.joint\.", r"joint[\1].", message)


def column_from(name: str, n: int, value: Callable[[str], float | str]) -> Column:
    """The column that the parameters describe; `value` looks one up by its name. Raises InputError."""

    def given(kind: str, i: int, key: str, optional: bool) -> float | None:
        number = value(f"{kind}[{i}].{key}")
        return None if optional and number == 0.0 else number  # type: ignore[return-value]

    blocks = []
    for i in range(1, n + 1):
        joint = {key: given("joint", i, key, optional) for key, (_, _, optional) in _JOINT_PARAMETERS.items()}
        block = {key: given("block", i, key, optional) for key, (_, _, optional) in _BLOCK_PARAMETERS.items()}
        blocks.append(Block(joint=Joint(**joint), **block))  # type: ignore[arg-type]
    settings: dict[str, Any] = {key: value(f"solver.{key}") for key in _SETTINGS_PARAMETERS}
    settings["without"] = tuple(word.strip() for word in settings["without"].split(",") if word.strip())
    return Column(name, tuple(blocks), Settings(**settings), value("g"))  # type: ignore[arg-type]
