"""The description of a column of blocks for the C core."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from solver.common.ranges import LENGTH, NUMBERS
from solver.kernels.column.api import driven_entries, engine
from solver.kernels.column.model import description
from solver.kernels.layout import spaces as at
from solver.models.column.block import (
    BLOCK_RULES,
    BORE_RELATION,
    DOWEL_RELATION,
    MISFITS,
    STRIP_RELATION,
    knows_section,
    no_rim,
)
from solver.models.column.model import Column
from solver.models.column.outputs import OUTPUTS
from solver.models.column.packing import ports_of, shape_of
from solver.models.column.settings import SKIP_CODES
from solver.models.column.stepper import REASONS
from solver.models.outputs import BOND, PORT

from .. import rules
from ..body import ColumnBody, StructureBody
from ..drive import Drive
from ..variables import (
    BOND_PARAMETERS,
    DRIVE,
    RECORD_SCALE,
    SLOPE_OF_BASE,
    TOLERANCE,
    Variable,
    bond_limits,
    inputs_of_ports,
    joint_parameters,
)
from .table import OF_BLOCKS, REFUSALS, ChoiceParameter, NativeSubject, RangeCheck, peaks_of

# input -> the input that is its slope
SLOPES = {"base.ax": "base.jx", "base.az": "base.jz", "base.theta": "base.omega", "base.omega": "base.alpha"}


def column_subject(body: ColumnBody) -> NativeSubject:
    """Return the description of a column; only its number of blocks, sections, ports and brittleness matter."""
    column, drive = body.model, body.drive
    n, of_ports, ports = column.n, inputs_of_ports(column), ports_of(column).tolist()
    # ends of the peaks in the state
    last = at.STATE.size(n)
    lost = at.CONTROL.beside + at.PHASE.places["bond_lost"][0] * n
    return subject_of(
        body,
        SKIP_CODES,
        sizes={
            "MODEL": at.model_room(n) + len(ports),
            "STATE": last + at.SPOTS.size(len(column.ports)),
            "COUNTS": at.COUNTS.beside,
            "BASE": at.BASE.beside + len(of_ports),
            "WORK": at.work_size(n, len(column.ports)),
            "ROOM": engine.scratch_room(n),
        },
        codes={
            "STATE_OVERTURN_TIME": at.CONTROL.fields.index("overturn_time"),
            "COUNT_RESTING": at.COUNTS.fields.index("resting"),
            "COUNT_OVERTURNED": at.COUNTS.fields.index("overturned"),
            **{name: getattr(description, name) for name in REFUSALS},
        },
        inputs=[
            *(f"base.{name}" for name in engine.BASE_INPUTS.fields),
            *(item.name for item in (*of_ports, *drive.inputs())),
        ],
        slopes=SLOPES | slopes_of(of_ports),
        split="base.R0x",
        given=[*_given(column, drive), *ports],
        checks=_checks(column),
        reasons=REASONS,
        peaks=peaks_of(OUTPUTS, column.sizes, last, {PORT: last, BOND: lost}),
        misfits=[MISFITS[kind] for kind in sorted(MISFITS)],
        group=driven_entries.follow.group,
    )


def subject_of(
    body: ColumnBody | StructureBody, skips: Mapping[str, int], sizes: Mapping[str, int], **others: Any
) -> NativeSubject:
    """Return the description of a body of blocks; `skips` has the codes of the words of `solver.without`."""
    drive, choices = body.drive, []
    if drive.is_chosen:
        ways = [(int(at.DRIVES[word]), word) for word in drive.words]
        slopes = [(int(code), word) for word, code in at.SLOPES.items()]
        choices = [ChoiceParameter(DRIVE, "ONE_WORD", ways), ChoiceParameter(SLOPE_OF_BASE, "ONE_WORD", slopes)]
    choices.append(ChoiceParameter("solver.without", "ANY_WORDS", [(code, word) for word, code in skips.items()]))
    return NativeSubject(
        falls=True,
        sizes={"N": body.model.n, "ROW": body.sizes[0], "SPLIT": body.sizes[1], **sizes},
        places={**OF_BLOCKS, "FALLEN": body.fallen.name},
        choices=choices,
        ranges=body.state_ranges(),
        base=body.base,
        **others,
    )


def slopes_of(loads: Sequence[Variable]) -> dict[str, str]:
    """Map the loads at ports to the inputs that are their slopes; `loads` holds the variables of both."""
    half, names = len(loads) // 2, [item.name for item in loads]
    return dict(zip(names[:half], names[half:], strict=True))


def given_of(drive: Drive) -> dict[str, str | float]:
    """Return how the base moves, as arguments of `assemble`: names of parameters, or constants."""
    if not drive.is_chosen:
        return {"drive": at.ACCELERATION, "slope": at.SLOPE_PARABOLA, "bodies": 0.0}
    return {"drive": DRIVE, "slope": SLOPE_OF_BASE, "bodies": float(drive.bodies)}


def _given(column: Column, drive: Drive) -> list[str | float]:
    settings: dict[str, str | float] = {"g": "g", "step": 0.0}  # no step is fixed
    settings |= given_of(drive) | {"ports": float(len(column.ports)), "bonded": float(column.is_brittle)}
    names = [settings.get(name, f"solver.{name}") for name in description.GIVEN_SETTINGS.fields]
    for i, block in enumerate(column.blocks, start=1):
        names += [f"block[{i}].{name}" for name in description.GIVEN_BLOCK]
        for name in description.GIVEN_JOINT:
            fixed = float(getattr(block.joint, name) or 0.0)
            names.append(f"joint[{i}].{name}" if name in joint_parameters(column) else fixed)
        names += shape_of(block)
    return names


def _checks(column: Column) -> list[RangeCheck]:
    """Return the limits of every Real parameter, in the order in which the Python slave checks them.

    The dimensions of a section that are no parameters are checked against those that are.
    """
    rows = [RangeCheck("g", *NUMBERS["g"])]
    for i, block in enumerate(column.blocks, start=1):
        for rule in BLOCK_RULES:
            if rule.of_joint and rule.key not in joint_parameters(column):  # kept as built
                continue
            name = f"joint[{i}].{rule.key}" if rule.of_joint else f"block[{i}].{rule.key}"
            free = rule.key == "centroid" and block.is_loaded  # that of body and load
            bound = f"block[{i}].{rule.bound}" if rule.bound and not free else ""
            limits, meaning = NUMBERS[rule.key]
            if rule.key in at.OTHER_LAW and not knows_section(rule.key, block):
                limits, meaning = (0.0, 0.0), "left out: it is for other sections of the contact"
            rows.append(RangeCheck(name, limits, meaning, rule.optional, bound, rule.strict, rule.relation))
            if rule.key == "mass" and block.bore is not None:
                rows.append(_bore(f"block[{i}].bore", block.bore, f"block[{i}].width"))
        # sections of the contact
        if block.joint_bore:
            rows.append(_bore(f"joint[{i}].bore", block.joint_bore, f"joint[{i}].width", f"block[{i}].width"))
        for k, depth in enumerate(block.joint.strips or ()):
            name = f"joint[{i}].strips[{k}]"
            rows.append(RangeCheck(name, *FIXED_LENGTH, False, f"block[{i}].depth", False, STRIP_RELATION, depth))
        # position, rim, friction and dowel of the joint
        rows += [RangeCheck(f"joint[{i}].{key}", *NUMBERS[key], True) for key in ("offset", "inclination")]
        if "rim" in joint_parameters(column):
            why = no_rim(block)
            rows.append(RangeCheck(f"joint[{i}].rim", *(((0.0, 0.0), why) if why else NUMBERS["rim"]), True))
        others = (f"block[{i}].tilt", f"joint[{i}].friction")
        rows += [RangeCheck(name, *NUMBERS[name.rpartition(".")[2]], True) for name in others]
        needs = f"joint[{i}].friction"
        rows.append(RangeCheck(f"joint[{i}].dowel", *NUMBERS["dowel"], True, relation=DOWEL_RELATION, needs=needs))
        # bonds
        if column.is_brittle:
            of_bond = {key: bond_limits(block.joint, key) for key in BOND_PARAMETERS}
            rows.append(RangeCheck(f"joint[{i}].tensile_strength", *of_bond["tensile_strength"]))
            own = of_bond["cohesion"]
            rows.append(RangeCheck(f"joint[{i}].cohesion", *own, not own[0][0], relation=DOWEL_RELATION, needs=needs))
    return [*rows, RangeCheck(TOLERANCE, *NUMBERS["tolerance"]), RangeCheck(RECORD_SCALE, *rules.SCALE_LIMITS)]


FIXED_LENGTH = ((0.0, LENGTH[0][1]), LENGTH[1])


def _bore(name: str, bore: float, bound: str, otherwise: str = "") -> RangeCheck:
    """Return the check that an inner diameter is less than the outer one."""
    return RangeCheck(name, *FIXED_LENGTH, False, bound, True, BORE_RELATION, bore, otherwise)
