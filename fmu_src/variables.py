"""The table of the FMU's variables, from which slave, native layer and model description follow.

That of a structure in space is in structure_variables.py, with the same rows and numbers.

The table lists inputs, then outputs, then parameters. Inputs are in the order of the kernels, and the outputs begin
with one output row and the split reaction as the kernels write them (solver/kernels/layout/spaces.py).

A variable's value reference is its own number, never its index in the table (references.py).
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import accumulate
from typing import TYPE_CHECKING, Any

from solver.common.errors import InputError, check_number
from solver.common.ranges import NUMBERS
from solver.ground.loads import IN_PLANE
from solver.ground.motion import STANDARD_GRAVITY
from solver.ground.records import NAMES
from solver.kernels.layout.spaces import DRIVEN
from solver.models.column.block import Joint
from solver.models.column.model import Column
from solver.models.column.outputs import OUTPUTS
from solver.models.column.settings import SKIPS
from solver.models.outputs import BASE, BLOCK, BOND, JOINT, PORT, Output
from solver.models.ports import Port

if TYPE_CHECKING:
    from .drive import Drive

from .references import FAMILY, array_of, reference_of

ACCELERATIONS = ("m/s2", "rad/s2")  # units
ROLES = ("input", "output", "parameter")  # in the order of the table

START_TIME = 0.0  # s
STOP_TIME = 20.0  # s
STEP_SIZE = 1e-3  # s
LEAST_BOND = 1.0  # Pa, least strength of a brittle joint


@dataclass(frozen=True)
class Choice:
    """An enumeration: the values of an Integer. The numbers are permanent; the words are the solver's."""

    name: str
    items: dict[str, int]  # word -> number
    meanings: dict[str, str]


VERDICT = Choice(
    "Verdict",
    {"overturned": 1, "standing": 2, "undecided": 3},
    {
        "overturned": "It has fallen, and is held",
        "standing": "At the end of the last step it rests on a base that is still and level",
        "undecided": "It moves, or its base does or is tilted",
    },
)


@dataclass(frozen=True)
class Variable:
    """One row of the table. The unit of a pure number is "".

    `depends_on` has the inputs that act without delay, `initially` those that act in initialization (None: any may).
    """

    name: str
    reference: int
    kind: str  # Real, Integer, Boolean, String or Enumeration
    causality: str  # input, output or parameter
    variability: str
    description: str
    unit: str = ""
    start: float | int | bool | str | None = None
    minimum: float | None = None
    maximum: float | None = None
    nominal: float | None = None
    depends_on: tuple[str, ...] = ()
    initially: tuple[str, ...] | None = None
    choice: Choice | None = None  # of an Enumeration


def input_of(name: str, text: str, unit: str, nominal: float) -> Variable:
    """Return the row of an input."""
    return Variable(name, reference_of(name), "Real", "input", "continuous", text, unit, 0.0, nominal=nominal)


def output_of(name: str, unit: str, text: str, variability: str = "continuous", **rest: Any) -> Variable:
    """Return the row of an output."""
    return Variable(name, reference_of(name), "Real", "output", variability, text, unit, **rest)


def event_of(name: str, kind: str, text: str, unit: str = "") -> Variable:
    """Return the row of an output that is discrete, and depends on no input in initialization."""
    return Variable(name, reference_of(name), kind, "output", "discrete", text, unit, initially=())


SLOPE = "Slope of base.a{} within a communication step, counted from its start; 0: held"
INPUTS = (
    input_of("base.ax", "Base acceleration, horizontal, positive to +x", "m/s2", 1.0),
    input_of("base.az", "Base acceleration, vertical, positive up", "m/s2", 1.0),
    input_of("base.jx", SLOPE.format("x"), "m/s3", 10.0),
    input_of("base.jz", SLOPE.format("z"), "m/s3", 10.0),
    input_of("base.theta", "Rotation of the base, clockwise", "rad", 1e-3),
    input_of("base.omega", "Rate of base.theta", "rad/s", 1e-2),
    input_of("base.alpha", "Acceleration of base.theta, held within a communication step: its mean", "rad/s2", 0.1),
)
TURNED = ("base.theta",)
TURNING = ("base.theta", "base.omega")
MOVING = ("base.ax", "base.az", *TURNING, "base.alpha")

LOAD_SLOPE = "Slope of port[{}].{} within a communication step, counted from its start; 0: held"


def inputs_of(ports: Sequence[Port], components: Sequence[str], size: Mapping[str, float]) -> list[Variable]:
    """Return the rows of the loads on ports, then of their slopes; `size` has the typical sizes by unit."""
    found = []
    for prefix in ("", "d"):
        for name in components:
            what, unit = ("Force", "N") if name[0] == "F" else ("Couple", "N.m")
            nominal = (10.0 if prefix else 1.0) * size[unit.replace(".", " ")]
            for p, port in enumerate(ports, start=1):
                text = LOAD_SLOPE.format(p, name) if prefix else f"{what} along {name[1]} on port {p} ({port.name})"
                found.append(input_of(f"port[{p}].{prefix}{name}", text, unit + "/s" * bool(prefix), nominal))
    return found


def numbered(owner: str, names: Iterable[str]) -> list[str]:
    """Return the names of ports, blocks and so on in descriptions, with their numbers."""
    return [f"{owner} {i} ({name})" for i, name in enumerate(names, start=1)]


# inputs that an output of the row depends on without delay, by default all; TURNING for the base joint alone
_DIRECT = {"ux": TURNED, "uz": TURNED, "theta": (), "slip": ()}
_DIRECT |= dict.fromkeys(("N", "M", "contact", "sigma_max", "share"), TURNING)
_DIRECT_OF_PORT = {"x": TURNED, "z": TURNED, "vx": TURNING, "vz": TURNING}
LARGEST = "Largest absolute value of the motion so far"
LEAST = "Least value of the motion so far"
EXTREMES = ("peak", "least")  # ends of their names
OF_FORCES = "joint[1].T"  # depends on all that forces do
_SPLIT = "of the base reaction (Fx, Fz, My) = R0 - m (ax, az, alpha)"
_MASS = "Effective mass met by the base, {} " + _SPLIT
# the split of the reaction in the order of the kernels (layout/spaces.py, SPLIT): unit, description, the inputs that it
# depends on
_SPLIT_OUTPUTS: dict[str, tuple[str, str, tuple[str, ...]]] = {
    "base.R0x": ("N", f"Horizontal part R0 {_SPLIT}", TURNING),
    "base.R0z": ("N", f"Vertical part R0 {_SPLIT}", TURNING),
    "base.R0m": ("N.m", f"Moment R0 {_SPLIT}", TURNING),
    "base.mxx": ("kg", _MASS.format("xx"), TURNED),
    "base.mxz": ("kg", _MASS.format("xz"), TURNED),
    "base.mxt": ("kg.m", _MASS.format("x alpha"), TURNED),
    "base.mzz": ("kg", _MASS.format("zz"), TURNED),
    "base.mzt": ("kg.m", _MASS.format("z alpha"), TURNED),
    "base.mtt": ("kg.m2", _MASS.format("alpha alpha"), TURNED),
}
_REST_OF_SPLIT = ("base.R0x", "base.R0z", "base.R0m")  # depend on loads, as do outputs that depend on accelerations
_TURNS_OF_BASE = {
    "theta": ("Rotation of the base{} as bodies drive it", "rad", 1e-3),
    "omega": ("Rate of rotation of the base{} as bodies drive it", "rad/s", 1e-2),
    "alpha": ("Rotational acceleration of the base{} as bodies drive it", "rad/s2", 0.1),
}
_MOVES_OF_BASE = {
    "": ("Displacement of the base along {} as bodies drive it", "m", 1e-2),
    "v": ("Velocity of the base along {} as bodies drive it", "m/s", 0.1),
    "a": ("Acceleration of the base along {} as bodies drive it", "m/s2", 1.0),
}
_DIRECT_OF_BASE = {"theta": TURNED, "omega": ("base.omega",), "ax": MOVING, "az": MOVING, "alpha": MOVING}
USUAL_RATES = {"m/s": 1e-2, "m/s2": 1.0}  # typical velocities and accelerations
OVERTURN_TIME = event_of("overturn_time", "Real", "Time of overturning, -1 while it stands", "s")
OVERTURN_JOINT = event_of("overturn_joint", "Integer", "Joint over which the column has fallen, 0 while it stands")
OVERTURNED_BLOCK = event_of("overturned_block", "Integer", "Number of the block that has fallen, 0 while none has")
OVERTURNED = event_of("overturned", "Boolean", "Whether it has overturned; then it is held")
VERDICT_NOW = replace(
    event_of("verdict", "Enumeration", "Whether it has fallen, rests on a still base, or may go either way"),
    choice=VERDICT,
)
RECORD_PGA = replace(
    event_of("base.record_pga", "Real", "Largest |ax| of the record inside the FMU, 0 without one", "m/s2"),
    initially=("base.record", "base.record_scale"),
)

# field of Block or Joint -> unit, description, True if 0 stands for "not given"
# Fields not listed are no parameters: they keep the values of the column from which the FMU is built.
_BLOCK_PARAMETERS = {
    "height": ("m", "Height of block {i}", False),
    "width": ("m", "Width of block {i}, along the motion", False),
    "depth": ("m", "Depth of block {i}, across the motion", False),
    "mass": ("kg", "Mass of block {i}", False),
    "centroid": ("m", "Centroid of block {i} above its bottom face; 0: half the height", True),
    "inertia": ("kg.m2", "Moment of inertia of block {i} about its centroid; 0: homogeneous block", True),
    "tilt": ("rad", "Angle of block {i} to the normal of the joint under it, as built, clockwise", True),
}
JOINT_PARAMETERS = {
    "stiffness": ("N/m3", "Winkler modulus of the joint under block {i}", False),
    "damping": ("s", "Damping eta of the joint under block {i}", False),
    "width": ("m", "Width of the contact face of block {i}; 0: that of the block", True),
    "depth": ("m", "Depth of the contact face of block {i}; 0: that of the block", True),
    "friction": ("", "Coefficient of friction of the joint under block {i}; 0: it never slides", True),
    "dowel": ("N", "Shear that the joint under block {i} bears beside friction", True),
    "offset": ("m", "Offset of block {i} over what is under it, as built, positive to +x", True),
    "inclination": ("rad", "Angle of the joint under block {i} to the base, as built, clockwise", True),
    "rim": ("m", "Width of the band along the edges in which the faces under block {i} touch; 0: all over", True),
}
# of a column with brittle joints, whose rims are as built
BOND_PARAMETERS = {
    "tensile_strength": ("Pa", "Tension that the mortar of the joint under block {i} bears until it breaks", False),
    "cohesion": ("Pa", "Shear that the mortar of the joint under block {i} bears beside friction", False),
}
# parameters that may change during a run: no length, no mass, no setting of the solver
TUNABLE = ("g", "joint.damping", "joints.damping_scale")
RECORD = "base.record"
DRIVE, SLOPE_OF_BASE = "base.drive", "base.slope"
RECORD_SCALE = "base.record_scale"
TOLERANCE = "solver.tolerance"
LISTED_BLOCKS = 10  # most blocks for which outputs list their dependencies in initialization, a list that grows with n2

_SETTINGS_PARAMETERS = {
    "step": ("s", "Fixed step of the paper's central differences"),
    "tolerance": ("", "Error, relative to the peak"),
    "without": (
        "",
        f"What is not to be done, with commas between: {', '.join(SKIPS)}; peaks: none is recorded but ux_peak",
    ),
}


def variables(column: Column, record: str = "", reads_files: bool = True, drive: Drive | None = None) -> list[Variable]:
    """Return the table for a column, whose values are the start values of the parameters; arguments as in `Body.table`.

    Without `drive` the base moves by its inputs.
    """
    parameters = [*_parameters(column), *(drive.parameters if drive else ()), *of_record(record, reads_files)]
    numbers, sizes = [""] * column.n, _sizes(column)  # blocks have no names; the base has the sizes of the lowest joint
    names = {BLOCK: numbers, JOINT: numbers, PORT: numbered(PORT, [port.name for port in column.ports])}
    names[BOND] = numbers if column.is_brittle else []
    # outputs, with the inputs that they depend on without delay
    pulled = ("N",) if column.is_brittle else ()
    row, peaks = seen(OUTPUTS, names, lambda unit, i: _size(sizes, unit, i), pulled)
    row = [replace(output, depends_on=_direct(output.name, column.n)) for output in row]
    moved = driven_outputs(DRIVEN.fields, _DIRECT_OF_BASE) if drive and drive.is_chosen else []
    outputs = [*row, *_split_outputs(column), *moved, *peaks]
    # outputs that depend on accelerations depend on loads too
    of_ports = inputs_of_ports(column)
    loads = tuple(given.name for given in of_ports[: len(of_ports) // 2])
    follow = [loads if output.depends_on == MOVING or output.name in _REST_OF_SPLIT else () for output in outputs]
    if drive:
        outputs = [replace(output, depends_on=drive.direct(output.depends_on)) for output in outputs]
    outputs = [
        replace(output, depends_on=(*output.depends_on, *more)) for output, more in zip(outputs, follow, strict=True)
    ]
    outputs += outcome(OVERTURN_JOINT)
    # dependencies in initialization
    numerical = ("solver.step", "solver.tolerance", "solver.without", SLOPE_OF_BASE)
    described = tuple(item.name for item in parameters if item.name not in (*numerical, RECORD, RECORD_SCALE))
    inputs = [*INPUTS, *of_ports, *(drive.inputs() if drive else ())]
    outputs = [_with_initial(output, column.n, described) for output in outputs]
    return [*inputs, *_with_initial_extremes(outputs), *parameters]


def with_real_outputs(table: list[Variable]) -> list[Variable]:
    """Return the table without outputs that are no reals, for hosts that read every output as one."""
    return [item for item in table if item.causality != "output" or item.kind == "Real"]


def _size(sizes: Mapping[str, list[float]], unit: str, i: int) -> float:
    """Return the typical size of an output of block, joint or port i; there may be more ports than blocks."""
    return sizes[unit][min(i, len(sizes[unit])) - 1] if unit in sizes else USUAL_RATES[unit]


def inputs_of_ports(column: Column) -> list[Variable]:
    """Return the loads on the ports of a column, in the order of `Stepper.drive`."""
    return inputs_of(column.ports, IN_PLANE, {unit: values[-1] for unit, values in _sizes(column).items()})


def _direct(name: str, n: int) -> tuple[str, ...]:
    """Return the inputs that an output of n blocks depends on without delay."""
    place, _, quantity = name.partition(".")
    if place.startswith("port["):
        return _DIRECT_OF_PORT.get(quantity, MOVING)
    inputs = _DIRECT.get(quantity or name, MOVING)
    return () if inputs == TURNING and place != f"joint[{n}]" else inputs


def name_behind(extreme: str) -> str:
    """Return the name of the output of an extreme, as block[2].ux of block[2].ux_peak; "" if it is none."""
    name, _, end = extreme.rpartition("_")
    return name if end in EXTREMES else ""


def _with_initial_extremes(outputs: Sequence[Variable]) -> Iterator[Variable]:
    """Return the outputs; before the first step an extreme depends on what its output does, one without on forces."""
    by_name = {output.name: output for output in outputs}
    for output in outputs:
        if name := name_behind(output.name):
            initially = by_name.get(name, by_name[OF_FORCES]).initially
            output = replace(output, initially=None if initially is None else (*initially, "solver.without"))
        yield output


def _with_initial(output: Variable, n: int, described: tuple[str, ...]) -> Variable:
    """Return the output with its dependencies in initialization; `described`: parameters of the column at rest."""
    if output.initially is not None or ("[" in output.name and n > LISTED_BLOCKS):
        return output
    if output.name.endswith("].theta"):
        return replace(output, initially=(*TURNED, *described))
    record = (RECORD, RECORD_SCALE) if "base.ax" in output.depends_on else ()
    return replace(output, initially=(*output.depends_on, *described, *record))


def seen(
    outputs: Iterable[Output],
    names: Mapping[str, Sequence[str]],
    nominal: Callable[[str, int], float],
    pulled: Collection[str] = (),
) -> tuple[list[Variable], list[Variable]]:
    """Return the outputs of a row, and their extremes since the last reset, in the order of the kernels.

    `names` are those in descriptions, by owner (blocks, joints, ties ...). `nominal` returns the typical size, by which
    solvers of a system scale, from the unit and the number of the block or joint, 0 for the base. Outputs whose name is
    `pulled` have no minimum, as joints of the model bear tension. Raises InputError if there are too many of an owner.
    """
    for owner, of in names.items():
        if len(of) > FAMILY:
            raise InputError(f"{owner}: {len(of)} of them, must be at most {FAMILY} in an FMU")
    row, peaks = [], []
    peak: dict[str, Any] = {"variability": "discrete", "initially": ()}
    for output in outputs:
        for one in output.each:
            for i, it in enumerate(names.get(one.owner, ("",)), start=int(one.owner != BASE)):
                unit, text = one.unit.replace(" ", "."), one.text.format(i=i, it=it)
                extreme = f"{LEAST if one.by_least else LARGEST}: {text}"
                limits: dict[str, Any] = {"maximum": one.most, "nominal": _usual_size(nominal, one, i)}
                if not output.only_peak:
                    least = None if one.name in pulled else one.least
                    row.append(output_of(one.name_of(i), unit, text, minimum=least, **limits))
                least = one.least if one.by_least else 0.0
                peaks.append(output_of(one.peak_of(i), unit, extreme, minimum=least, **peak, **limits))
    return row, peaks


def _usual_size(nominal: Callable[[str, int], float], output: Output, i: int) -> float:
    try:
        return nominal(output.unit, i)
    except KeyError:
        files = "fmu_src/variables.py, fmu_src/structure_variables.py"
        raise LookupError(f"{output.name}: _sizes has no size of the unit {output.unit} ({files})") from None


def _split_outputs(column: Column) -> list[Variable]:
    sizes = _sizes(column)
    mass = sum(block.mass for block in column.blocks)
    width = column.contacts[-1].width
    nominal = {"N": sizes["N"][-1], "N.m": sizes["N m"][-1], "kg": mass, "kg.m": mass * width, "kg.m2": mass * width**2}
    return [
        output_of(name, unit, text, nominal=nominal[unit], depends_on=inputs)
        for name, (unit, text, inputs) in _SPLIT_OUTPUTS.items()
    ]


def driven_outputs(fields: Sequence[str], direct: Mapping[str, tuple[str, ...]]) -> list[Variable]:
    """Return the rows of the motion of a base that bodies drive; `direct`: dependencies by the kernels' names."""
    found = []
    for field in fields:
        name, _, axis = field.partition("_")
        kind, at_axis = (name, axis) if name in _TURNS_OF_BASE else (name[:-1], name[-1])
        text, unit, nominal = (_TURNS_OF_BASE | _MOVES_OF_BASE)[kind]
        text = text.format(f" about {at_axis}" if kind in _TURNS_OF_BASE and at_axis else at_axis)
        found.append(output_of(f"driven.{field}", unit, text, nominal=nominal, depends_on=direct.get(field, ())))
    return found


def _sizes(column: Column) -> dict[str, list[float]]:
    """Return the typical size of the outputs of each block or joint by unit, from the top down."""
    blocks, contacts = column.blocks, column.contacts
    height = sum(block.height for block in blocks)
    weights = list(accumulate((column.g or STANDARD_GRAVITY) * block.mass for block in blocks))
    return {
        "m": [1e-3 * height] * column.n,
        "rad": [1e-3] * column.n,
        "": [1.0] * column.n,
        "N": weights,
        "N m": [weight * contact.width / 6.0 for weight, contact in zip(weights, contacts, strict=True)],
        "Pa": [weight / contact.area for weight, contact in zip(weights, contacts, strict=True)],
        "J": [1e-3 * height * weight for weight in weights],
    }


RECORD_TEXT = f"Record added to the inputs: name of the one inside the FMU, or path of one ({', '.join(NAMES)})"
RECORD_TEXT_NATIVE = "Record added to the inputs: name of the one inside the FMU, or empty for none; no file is read"


def parameter_of(
    name: str,
    unit: str,
    text: str,
    start: float | str | None,
    limits: tuple[float, float] | None = None,
    optional: bool = False,
) -> Variable:
    """Return the row of a parameter; if it is `optional`, 0 stands for "not given".

    The default limits are those of the last part of its name in ranges.py.
    """
    common = ("parameter", "tunable" if (array_of(name) or name) in TUNABLE else "fixed", text, unit)
    reference = reference_of(name)
    if isinstance(start, str):
        return Variable(name, reference, "String", *common, start)
    if name == RECORD_SCALE:
        return Variable(name, reference, "Real", *common, start)
    least, most = limits or NUMBERS[name.rpartition(".")[2]][0]
    return Variable(name, reference, "Real", *common, start or 0.0, 0.0 if optional and least > 0.0 else least, most)


def outcome(fallen: Variable, after_fall: float = 0.0) -> list[Variable]:
    """Return the outputs after those of the model: verdict and record; `fallen` is that of the fallen joint or block.

    The model goes on for the time `after_fall` after a fall (s).
    """
    overturned, verdict = OVERTURNED, VERDICT_NOW
    if after_fall:
        overturned = replace(OVERTURNED, description=f"Whether it has overturned; {after_fall:g} s later it is held")
        fell = {"overturned": f"It has fallen, and is held {after_fall:g} s later"}
        verdict = replace(VERDICT_NOW, choice=replace(VERDICT, meanings=VERDICT.meanings | fell))
    return [OVERTURN_TIME, fallen, overturned, verdict, RECORD_PGA]


def of_record(record: str, reads_files: bool) -> list[Variable]:
    """Return the last parameters: the record, whose name is `record`, and its factor."""
    text = RECORD_TEXT if reads_files else RECORD_TEXT_NATIVE
    factor = parameter_of(RECORD_SCALE, "", "Factor on the record's accelerations", 1.0)
    return [parameter_of(RECORD, "", text, record), factor]


def tolerance_of(value: float) -> Variable:
    """Return the parameter of the error control."""
    return parameter_of(TOLERANCE, "", "Error relative to the largest motion", value)


def _parameters(column: Column) -> list[Variable]:
    rows = [parameter_of("g", "m/s2", "Acceleration of gravity", column.g)]
    of_joints = joint_parameters(column)
    for owner, parts, table in (("block", column.blocks, _BLOCK_PARAMETERS), ("joint", column.laws, of_joints)):
        for i, part in enumerate(parts, start=1):
            for key, (unit, text, optional) in table.items():
                start = getattr(part, key)
                limits = bond_limits(column.laws[i - 1], key)[0] if key in BOND_PARAMETERS else None
                name, about = f"{owner}[{i}].{key}", text.format(i=i)
                rows.append(parameter_of(name, unit, about, start, limits, optional))
    for key in _settings_of(column):
        (unit, text), start = _SETTINGS_PARAMETERS[key], getattr(column.settings, key)
        rows.append(parameter_of(f"solver.{key}", unit, text, ", ".join(start) if key == "without" else start))
    return rows


def joint_parameters(column: Column) -> dict[str, tuple[str, str, bool]]:
    """Return the parameters of every joint."""
    if not column.is_brittle:
        return JOINT_PARAMETERS
    return {key: row for key, row in JOINT_PARAMETERS.items() if key != "rim"} | BOND_PARAMETERS


def bond_limits(built: Joint, key: str) -> tuple[tuple[float, float], str]:
    """Return the limits of a parameter of a bond and their meaning: a joint that is brittle as built stays so."""
    limits, meaning = NUMBERS[key]
    if built.rim is not None:
        return (0.0, 0.0), "left out of a joint that touches in a rim"
    if built.is_brittle and key == built.brittle_key:
        return (LEAST_BOND, limits[1]), "at least 1 Pa and at most 1e12 Pa: the FMU was built with it"
    return limits, meaning


def _settings_of(column: Column) -> list[str]:
    """Return the names of the settings that are parameters; the step is one only where it is fixed."""
    return [key for key in _SETTINGS_PARAMETERS if key != "step" or column.kind.fixed]


def column_from(built: Column, value: Callable[[str], float | int | str]) -> Column:
    """Return the column that the parameters describe; `value` returns that of a parameter by name. Raises InputError.

    Name, sections and formulation are no parameters: they are those of `built`, from which the FMU was built.
    """

    def given(kind: str, i: int, key: str, optional: bool) -> float | None:
        number = value(f"{kind}[{i}].{key}")
        return None if optional and number == 0.0 else number  # type: ignore[return-value]

    blocks = []
    for i, own in enumerate(built.blocks, start=1):
        joint = {key: given("joint", i, key, optional) for key, (_, _, optional) in joint_parameters(built).items()}
        for key in BOND_PARAMETERS if built.is_brittle else ():
            check_number(f"joint[{i}].{key}", joint[key], *bond_limits(own.joint, key))
        block = {key: given("block", i, key, optional) for key, (_, _, optional) in _BLOCK_PARAMETERS.items()}
        blocks.append(replace(own, joint=replace(own.joint, **joint), **block))  # type: ignore[arg-type]
    settings: dict[str, Any] = {key: value(f"solver.{key}") for key in _settings_of(built)}
    settings["without"] = tuple(word.strip() for word in settings["without"].split(",") if word.strip())
    settings_now = replace(built.settings, **settings)
    return Column(built.name, tuple(blocks), settings_now, value("g"), built.ports)  # type: ignore[arg-type]
