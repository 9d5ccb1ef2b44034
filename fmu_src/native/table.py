"""From the one table of variables to the C declarations that fmu.c is compiled with."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from solver.column import NUMBERS, SKIPS, Column
from solver.kernels import layout as at
from solver.kernels import pointers
from solver.motion import Motion
from solver.packing import FORMULATION_CODES, INTEGRATOR_CODES, SKIP_CODES
from solver.stepper import REASONS

from ..record import Record
from ..variables import (
    CHOICES,
    FAMILY,
    OVERTURN_JOINT,
    OVERTURN_TIME,
    OVERTURNED,
    RECORD,
    RECORD_PGA,
    RECORD_SCALE,
    Variable,
)

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
    index = {variable.name: k for k, variable in enumerate(table)}
    places = storage(table)
    reals = [variable for variable in table if STORED[variable.kind] == "REAL"]
    wholes = [variable for variable in table if STORED[variable.kind] in ("INTEGER", "BOOLEAN")]
    texts = [variable for variable in table if STORED[variable.kind] == "STRING"]
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
        "WHOLES": len(wholes),
        "TEXTS": len(texts),
        "TEXT": TEXT,
        "FAMILY": FAMILY,
        "GIVEN": len(pointers.GIVEN_SETTINGS) + pointers.GIVEN_FIELDS * n,
        "AT_OVERTURN_TIME": places[OVERTURN_TIME.name],
        "AT_OVERTURN_JOINT": places[OVERTURN_JOINT.name],
        "AT_OVERTURNED": places[OVERTURNED.name],
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
    lines += _array("int", "whole_starts", [str(int(_start(variable))) for variable in wholes])
    lines += _array("char *const", "text_starts", [_quoted(str(variable.start)) for variable in texts])
    lines += _families(table)
    slopes = [places.get(SLOPES.get(variable.name, ""), -1) for variable in inputs]
    lines += _array("int", "slope_of", [str(slope) for slope in slopes])
    lines += _array("int", "given", [str(places[name]) for name in _given_names(n)])
    codes = {"solver.formulation": FORMULATION_CODES, "solver.integrator": INTEGRATOR_CODES}
    for name, choice in CHOICES.items():
        items = [f"{{{number}, {codes[name][word]}, {_quoted(word)}}}" for word, number in choice.items.items()]
        lines += _array("Item", f"{choice.name.lower()}_items", items)
    words = [f"{{0, {SKIP_CODES[word]}, {_quoted(word)}}}" for word in SKIPS]
    lines += _array("Item", "without_items", words)
    choices = [
        f"{{{index[name]}, {len(choice.items)}, {choice.name.lower()}_items}}" for name, choice in CHOICES.items()
    ]
    choices.append(f"{{{index['solver.without']}, {len(SKIPS)}, without_items}}")
    lines += _array("Choice", "choices", choices)
    lines += _array("Check", "checks", _checks(n, index))
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


STORED = {"Real": "REAL", "Integer": "INTEGER", "Enumeration": "INTEGER", "Boolean": "BOOLEAN", "String": "STRING"}


def storage(table: list[Variable]) -> dict[str, int]:
    """Place of every variable in the array that it is kept in: one of numbers, one of whole ones, one of texts."""
    arrays = {"REAL": "reals", "INTEGER": "wholes", "BOOLEAN": "wholes", "STRING": "texts"}
    filled = dict.fromkeys(arrays.values(), 0)
    places: dict[str, int] = {}
    for variable in table:
        array = arrays[STORED[variable.kind]]
        places[variable.name] = filled[array]
        filled[array] += 1
    return places


def _families(table: list[Variable]) -> list[str]:
    """For each family of value references the rows of `variables` that its numbers, from 1, stand for; -1: none."""
    families: dict[int, dict[int, int]] = {}
    for row, variable in enumerate(table):
        family, number = divmod(variable.reference - 1, FAMILY)
        families.setdefault(family, {})[number] = row
    lines, listed = [], []
    for family in range(max(families) + 1):
        rows = families.get(family, {})
        count = max(rows) + 1 if rows else 0
        if count:
            lines += _array("int", f"family_{family}", [str(rows.get(number, -1)) for number in range(count)])
        listed.append(f"{{{count}, {f'family_{family}' if count else 'NULL'}}}")
    return [*lines, *_array("Family", "families", listed), f"#define FAMILIES {len(listed)}"]


def _variable(variable: Variable, place: int) -> str:
    roles = {"input": "INPUT", "output": "OUTPUT", "parameter": "PARAMETER"}
    tunable = int(variable.variability == "tunable")
    words = (STORED[variable.kind], roles[variable.causality], tunable, place)
    return f"{{{_quoted(variable.name)}, {_quoted(variable.unit)}, {', '.join(map(str, words))}}}"


def _given_names(n: int) -> list[str]:
    """The variables that `assemble` is given, in its order."""
    names = [name if name == "g" else f"solver.{name}" for name in pointers.GIVEN_SETTINGS]
    for i in range(1, n + 1):
        names += [f"block[{i}].{name}" for name in pointers.GIVEN_BLOCK]
        names += [f"joint[{i}].{name}" for name in pointers.GIVEN_JOINT]
    return names


def _checks(n: int, index: dict[str, int]) -> list[str]:
    """The limits of every Real parameter in the order in which Column finds fault with them."""

    def check(name: str, optional: bool = False, bound: str = "", relation: str = "", strict: bool = False) -> str:
        (low, high), meaning = NUMBERS[name.rpartition(".")[2]]
        parts = [
            str(index[name]),
            _number(low),
            _number(high),
            str(int(optional)),
            _quoted(f"must be {meaning}"),
            str(index[bound]) if bound else "-1",
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
