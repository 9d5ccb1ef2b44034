"""From the one table of variables to the C declarations that fmu.c is compiled with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.column import FORMULATIONS, INTEGRATORS, NUMBERS, SKIPS, Column
from solver.kernels import layout as at
from solver.kernels import pointers
from solver.motion import Motion
from solver.packing import FORMULATION_CODES, INTEGRATOR_CODES, SKIP_CODES
from solver.stepper import REASONS

from ..record import Record
from ..variables import OVERTURN_TIME, RECORD, RECORD_PGA, RECORD_SCALE, Variable

TEXT = 256  # bytes of a String, its end included
# input -> the input that is its slope
SLOPES = {"base.ax": "base.jx", "base.az": "base.jz", "base.theta": "base.omega", "base.omega": "base.alpha"}


@dataclass(frozen=True)
class Contents:
    """What one FMU is made for."""

    column: Column
    table: list[Variable]
    guid: str
    record_name: str
    record: Motion | None


def declarations(contents: Contents) -> str:
    """The text of table.h: sizes, variables, start values, checks of the parameters, the record."""
    column, table = contents.column, contents.table
    n = column.n
    reference = {variable.name: k for k, variable in enumerate(table)}
    places = storage(table)
    reals = sorted((variable for variable in table if variable.kind == "Real"), key=lambda item: places[item.name])
    texts = sorted((variable for variable in table if variable.kind == "String"), key=lambda item: places[item.name])
    inputs = [variable for variable in reals if variable.causality == "input"]
    lines = ["/* Made by build_fmu.py; not to be edited. */"]
    numbers = {
        "N": n,
        "MODEL": pointers.model_room(n),
        "STATE": at.state_size(n),
        "COUNTERS": at.COUNTERS,
        "SOLVER_INPUTS": at.INPUTS,
        "WORK": at.work_size(n),
        "ROW": at.row_size(n),
        "ROOM": pointers.scratch_room(n, False),
        "FIXED_STEP_ROOM": pointers.scratch_room(n, True),
        "BASE_INPUTS": len(inputs),
        "REALS": len(reals),
        "TEXTS": len(texts),
        "TEXT": TEXT,
        "VARIABLES": len(table),
        "GIVEN": len(pointers.GIVEN_SETTINGS) + pointers.GIVEN_FIELDS * n,
        "AT_OVERTURN_TIME": places[OVERTURN_TIME.name],
        "AT_RECORD": places[RECORD],
        "AT_SPLIT": places["base.R0x"],
        "SPLIT": at.SPLIT,
        "AT_RECORD_PGA": places[RECORD_PGA.name],
        "AT_RECORD_SCALE": places[RECORD_SCALE],
        "STATE_OVERTURN_TIME": at.OVERTURN_TIME,
        "STATE_TIME_FULL": at.TIME_FULL,
        "STATE_TIME_ROCKING": at.TIME_ROCKING,
        "STATE_TIME_FLIGHT": at.TIME_FLIGHT,
        "COUNTER_OVERTURNED": at.OVERTURNED,
        "CENTRAL_DIFFERENCE": at.CENTRAL_DIFFERENCE,
        "NOT_STABLE": pointers.NOT_STABLE,
        "TOO_LARGE": pointers.TOO_LARGE,
    }
    lines += [f"#define {name} {value}" for name, value in numbers.items()]
    lines.append(f"static const char *const GUID = {_quoted(contents.guid)};")
    lines.append(f"static const char *const STATE_FORMAT = {_quoted('multiblock-fmu native state 1')};")
    lines += _array("Variable", "variables", [_variable(variable, places[variable.name]) for variable in table])
    lines += _array("double", "real_starts", [_number(_start(variable)) for variable in reals])
    lines += _array("char *const", "text_starts", [_quoted(str(variable.start)) for variable in texts])
    slopes = [places.get(SLOPES.get(variable.name, ""), -1) for variable in inputs]
    lines += _array("int", "slope_of", [str(slope) for slope in slopes])
    lines += _array("int", "input_references", [str(reference[variable.name]) for variable in inputs])
    lines += _array("int", "given", [str(places[name]) for name in _given_names(n)])
    choices = [
        _choice("solver.formulation", FORMULATIONS, FORMULATION_CODES, reference),
        _choice("solver.integrator", INTEGRATORS, INTEGRATOR_CODES, reference),
        _choice("solver.without", SKIPS, SKIP_CODES, reference),
    ]
    most = max(len(FORMULATIONS), len(INTEGRATORS), len(SKIPS))
    lines.append(f'_Static_assert({most} <= MOST_WORDS, "a choice has more words than there is room for");')
    lines += _array("Choice", "choices", choices)
    lines += _array("Check", "checks", _checks(n, reference))
    lines += _array("Reason", "reasons", [f"{{{code}, {_quoted(text)}}}" for code, text in REASONS.items()])
    lines += _record(contents)
    return "\n".join(lines) + "\n"


def _quoted(text: str) -> str:
    """A C string of UTF-8 bytes."""
    parts = []
    for byte in text.encode():
        parts.append(chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}")
    return '"' + "".join(parts) + '"'


def _number(value: float) -> str:
    return float(value).hex()


def _start(variable: Variable) -> float:
    return float(variable.start) if isinstance(variable.start, (int, float)) else 0.0


def _array(kind: str, name: str, items: list[str]) -> list[str]:
    """A constant array; C has none without an element, so that one of zeros stands for it."""
    return [f"static const {kind} {name}[] = {{", *(f"    {item}," for item in items or ["0"]), "};"]


def storage(table: list[Variable]) -> dict[str, int]:
    """Place of every variable among those of its kind: inputs first, then outputs, then parameters."""
    roles = ("input", "output", "parameter")
    places: dict[str, int] = {}
    for kind in ("Real", "Integer", "Boolean", "String"):
        alike = sorted((item for item in table if item.kind == kind), key=lambda item: roles.index(item.causality))
        places |= {item.name: place for place, item in enumerate(alike)}
    return places


def _variable(variable: Variable, place: int) -> str:
    kinds = {"Real": "REAL", "Integer": "INTEGER", "Boolean": "BOOLEAN", "String": "STRING"}
    roles = {"input": "INPUT", "output": "OUTPUT", "parameter": "PARAMETER"}
    tunable = int(variable.variability == "tunable")
    words = (kinds[variable.kind], roles[variable.causality], tunable, place)
    return f"{{{_quoted(variable.name)}, {_quoted(variable.unit)}, {', '.join(map(str, words))}}}"


def _given_names(n: int) -> list[str]:
    """The variables that `assemble` is given, in its order."""
    names = [name if name == "g" else f"solver.{name}" for name in pointers.GIVEN_SETTINGS]
    for i in range(1, n + 1):
        names += [f"block[{i}].{name}" for name in pointers.GIVEN_BLOCK]
        names += [f"joint[{i}].{name}" for name in pointers.GIVEN_JOINT]
    return names


def _choice(name: str, words: tuple[str, ...], codes: dict[str, int], reference: dict[str, int]) -> str:
    listed = ", ".join(_quoted(word) for word in words)
    return f"{{{reference[name]}, {len(words)}, {{{listed}}}, {{{', '.join(str(codes[word]) for word in words)}}}}}"


def _checks(n: int, reference: dict[str, int]) -> list[str]:
    """The limits of every Real parameter in the order in which Column finds fault with them."""

    def check(name: str, optional: bool = False, bound: str = "", relation: str = "", strict: bool = False) -> str:
        (low, high), meaning = NUMBERS[name.rpartition(".")[2]]
        parts = [
            str(reference[name]),
            _number(low),
            _number(high),
            str(int(optional)),
            _quoted(f"must be {meaning}"),
            str(reference[bound]) if bound else "-1",
            str(int(strict)),
            _quoted(relation),
        ]
        return f"{{{', '.join(parts)}}}"

    rows = [check("g")]
    for i in range(1, n + 1):
        block, joint = f"block[{i}]", f"joint[{i}]"
        rows += [check(f"{block}.{name}") for name in ("height", "width", "depth", "mass")]
        rows.append(
            check(f"{block}.centroid", True, f"{block}.height", "must lie below the top face, height", strict=True)
        )
        rows.append(check(f"{block}.inertia", True))
        rows += [check(f"{joint}.{name}") for name in ("stiffness", "damping")]
        for name in ("width", "depth"):
            rows.append(check(f"{joint}.{name}", True, f"{block}.{name}", f"must not exceed the block's {name}"))
    return [*rows, check("solver.step"), check("solver.tolerance")]


def _record(contents: Contents) -> list[str]:
    """The samples as they are; the slopes in between are the kernels' business."""
    motion = contents.record
    count = 0 if motion is None else len(motion.time)
    dt = 0.0 if motion is None else Record(motion).dt
    pga = 0.0 if motion is None else motion.pga
    lines = [f"#define SAMPLES {count}"]
    lines += [f"static const double record_dt = {_number(dt)};", f"static const double record_pga = {_number(pga)};"]
    lines.append(f"static const char *const RECORD_NAME = {_quoted(contents.record_name)};")
    for name in ("time", "ax", "az"):
        samples = np.zeros(0) if motion is None else getattr(motion, name)
        lines += _array("double", f"record_{name}", [_number(value) for value in samples])
    return lines
