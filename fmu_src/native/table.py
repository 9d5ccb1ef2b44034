"""What the C core is compiled with, written from the tables of Python: nothing of it is kept by hand.

contract.h  of a number of blocks: the kernels with their arguments by name, sizes and codes, limits, messages
table.h     what differs from one FMU to another: variables, start values, checks of the parameters, the record
"""

from __future__ import annotations

import inspect
from dataclasses import dataclass
from typing import Any

import numpy as np

from solver.column import BLOCK_RULES, NUMBERS, SKIPS, Column
from solver.kernels import engine, pointers
from solver.kernels import layout as at
from solver.motion import Motion
from solver.packing import FORMULATION_CODES, INTEGRATOR_CODES, SKIP_CODES
from solver.stepper import REASONS

from .. import rules
from ..record import Record
from ..variables import (
    CHOICES,
    FAMILY,
    FORMULATION,
    INPUTS,
    INTEGRATOR,
    OVERTURN_JOINT,
    OVERTURN_TIME,
    OVERTURNED,
    RECORD,
    RECORD_PGA,
    RECORD_SCALE,
    VERDICT,
    VERDICT_NOW,
    Variable,
)
from .machine_code import PREFIX

TEXT = 256  # bytes of a String, its end included
STATE_FORMAT = "multiblock-fmu native state 4"
# input -> the input that is its slope
SLOPES = {"base.ax": "base.jx", "base.az": "base.jz", "base.theta": "base.omega", "base.omega": "base.alpha"}
# the base's inputs where the kernels look for them
BASE_INPUTS = {f"base.{name}": place for place, name in enumerate(engine.BASE_INPUTS.fields)}
READ_ONLY = ("given", "inputs", "times", "ax", "az", "seeds")  # arguments behind which kernels write nothing
C_TYPES = {"float64": "double ", "int64": "int64_t ", "float64*": "double *", "int64*": "int64_t *"}
STORED = {"Real": "REAL", "Integer": "INTEGER", "Enumeration": "INTEGER", "Boolean": "BOOLEAN", "String": "STRING"}


@dataclass(frozen=True)
class Contents:
    """What one FMU is made for."""

    column: Column
    table: list[Variable]
    guid: str
    record_name: str
    record: Motion | None


def headers(contents: Contents) -> dict[str, str]:
    """The generated header files: name -> text."""
    note = "/* Made by build_fmu.py; not to be edited. */\n"
    return {"contract.h": note + contract(contents.column.n), "table.h": note + declarations(contents)}


# --- contract.h


def contract(n: int) -> str:
    """The kernels and what goes by their tables, for n blocks."""
    sizes = {
        "N": n,
        "MODEL": pointers.model_room(n),
        "STATE": at.STATE.size(n),
        "COUNTS": at.COUNTS.beside,
        "BASE": at.BASE.beside,
        "WORK": at.WORK.size(n),
        "ROW": at.ROW.size(n),
        "SPLIT": at.SPLIT.beside,
        "PEAKS": at.PEAKS.size(n),
        "ROOM": pointers.scratch_room(n, False),
        "FIXED_STEP_ROOM": pointers.scratch_room(n, True),
        "BASE_INPUTS": len(BASE_INPUTS),
        "GIVEN": len(pointers.GIVEN_SETTINGS) + pointers.GIVEN_FIELDS * n,
    }
    codes = {f"GIVEN_{name.upper()}": place for place, name in enumerate(pointers.GIVEN_SETTINGS)}
    codes |= {
        "STATE_OVERTURN_TIME": at.CONTROL.fields.index("overturn_time"),
        "STATE_TIME_FULL": at.CONTROL.fields.index("time_full"),
        "STATE_TIME_ROCKING": at.CONTROL.fields.index("time_rocking"),
        "STATE_TIME_FLIGHT": at.CONTROL.fields.index("time_flight"),
        "STATE_PEAKS": at.STATE.size(n) - at.PEAKS.size(n),
        "PEAK_CONTACT": n * at.OUTPUTS.fields.index("contact"),
        "COUNT_RESTING": at.COUNTS.fields.index("resting"),
        "COUNT_OVERTURNED": at.COUNTS.fields.index("overturned"),
        "CENTRAL_DIFFERENCE": at.CENTRAL_DIFFERENCE,
        "NOT_STABLE": pointers.NOT_STABLE,
        "TOO_LARGE": pointers.TOO_LARGE,
    }
    lines = ["#include <stdint.h>", *_enum(sizes), *_enum(codes)]
    lines.append(f"#define TIME_SLACK {rules.TIME_SLACK!r}")
    lines.append(f"#define STEP_SLACK {rules.STEP_SLACK!r}")
    lines.append(f"#define MUST_INERTIA {_quoted('must be ' + NUMBERS['inertia'][1])}")
    messages = {name: text for name, text in vars(rules).items() if name.isupper() and isinstance(text, str)}
    lines += [f"#define SAY_{name} {_quoted(text)}" for name, text in messages.items()]
    for function, kinds in pointers.ENTRIES.items():
        lines += _kernel(function, kinds)
    return "\n".join(lines) + "\n"


def _enum(values: dict[str, int]) -> list[str]:
    return ["enum {", *(f"    {name} = {value}," for name, value in values.items()), "};"]


def _kernel(function: Any, kinds: tuple[Any, ...]) -> list[str]:
    """A kernel as numba compiles it, and around it a function whose arguments are named.

    A kernel leaves its result behind the first pointer; the second is for exceptions, which kernels do not have.
    """
    names = list(inspect.signature(function).parameters)
    kept = dict(zip(names, map(str, kinds), strict=True))
    fields = [f"{'const ' * (name in READ_ONLY)}{C_TYPES[kind]}{name}" for name, kind in kept.items()]
    name = function.__name__
    own = name.title()  # look -> Look
    return [
        f"int {PREFIX}{name}(int64_t *, void **, {', '.join(fields)});",
        f"typedef struct {{ {'; '.join(fields)}; }} {own};",
        f"static inline int64_t {name}({own} of) {{",
        "    int64_t result;",
        "    void *exception;",
        f"    {PREFIX}{name}(&result, &exception, {', '.join(f'of.{name}' for name in names)});",
        "    return result;",
        "}",
    ]


# --- table.h


def declarations(contents: Contents) -> str:
    """The text of table.h."""
    column, table = contents.column, contents.table
    if [item.name for item in INPUTS] != sorted(BASE_INPUTS, key=BASE_INPUTS.__getitem__):
        raise ValueError("the inputs of the FMU are not in the order of the kernels")
    index = {variable.name: k for k, variable in enumerate(table)}
    places = storage(table)
    reals = [variable for variable in table if STORED[variable.kind] == "REAL"]
    wholes = [variable for variable in table if STORED[variable.kind] in ("INTEGER", "BOOLEAN")]
    texts = [variable for variable in table if STORED[variable.kind] == "STRING"]
    numbers = {
        "REALS": len(reals),
        "WHOLES": len(wholes),
        "TEXTS": len(texts),
        "TEXT": TEXT,
        "FAMILY": FAMILY,
        "AT_ROW": len(INPUTS),
        "AT_SPLIT": places["base.R0x"],
        "AT_PEAKS": places["block[1].ux_peak"],
        "AT_VERDICT": places[VERDICT_NOW.name],
        "VERDICT_OVERTURNED": VERDICT.items["overturned"],
        "VERDICT_STANDING": VERDICT.items["standing"],
        "VERDICT_UNDECIDED": VERDICT.items["undecided"],
        "AT_OVERTURN_TIME": places[OVERTURN_TIME.name],
        "AT_OVERTURN_JOINT": places[OVERTURN_JOINT.name],
        "AT_OVERTURNED": places[OVERTURNED.name],
        "AT_RECORD": places[RECORD],
        "AT_RECORD_PGA": places[RECORD_PGA.name],
        "AT_RECORD_SCALE": places[RECORD_SCALE],
    }
    lines = _enum(numbers)
    lines.append(f"#define IDENTITY {_quoted(contents.guid)}")
    lines.append(f"#define STATE_FORMAT {_quoted(STATE_FORMAT)}")
    lines += _array("Variable", "variables", [_variable(variable, places[variable.name]) for variable in table])
    lines += _array("double", "real_starts", [_number(_start(variable)) for variable in reals])
    lines += _array("int", "whole_starts", [str(int(_start(variable))) for variable in wholes])
    lines += _array("char *const", "text_starts", [_quoted(str(variable.start)) for variable in texts])
    lines += _families(table)
    lines += _array("int", "slope_of", [str(places.get(SLOPES.get(item.name, ""), -1)) for item in INPUTS])
    lines += _array("int", "given", [str(_place_given(name, places)) for name in _given_names(column.n)])
    codes = {FORMULATION.name: FORMULATION_CODES, INTEGRATOR.name: INTEGRATOR_CODES}
    for name, choice in CHOICES.items():
        items = [(number, codes[choice.name][word], word) for word, number in choice.items.items()]
        lines += _choice(choice.name.lower(), index[name], items)
    lines += _choice("without", index["solver.without"], [(0, SKIP_CODES[word], word) for word in SKIPS])
    lines += _array("Check", "checks", _checks(column.n, index))
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
    return [*lines, *_array("Family", "family_index", listed)]


def _variable(variable: Variable, place: int) -> str:
    tunable = int(variable.variability == "tunable")
    words = (STORED[variable.kind], variable.causality.upper(), tunable, place)
    return f"{{{_quoted(variable.name)}, {_quoted(variable.unit)}, {', '.join(map(str, words))}}}"


def _given_names(n: int) -> list[str]:
    """The variables that `assemble` is given, in its order."""
    names = [name if name == "g" else f"solver.{name}" for name in pointers.GIVEN_SETTINGS]
    for i in range(1, n + 1):
        names += [f"block[{i}].{name}" for name in pointers.GIVEN_BLOCK]
        names += [f"joint[{i}].{name}" for name in pointers.GIVEN_JOINT]
    return names


def _place_given(name: str, places: dict[str, int]) -> int:
    """Among the numbers; -1 for what is given as a code."""
    return -1 if name in CHOICES or name == "solver.without" else places[name]


def _choice(name: str, row: int, items: list[tuple[int, int, str]]) -> list[str]:
    listed = [f"{{{number}, {code}, {_quoted(word)}}}" for number, code, word in items]
    lines = _array("Item", f"{name}_items", listed)
    return [*lines, f"static const Choice choice_{name} = {{{row}, {len(items)}, {name}_items}};"]


def _checks(n: int, index: dict[str, int]) -> list[str]:
    """The limits of every Real parameter in the order in which the Python slave finds fault with them."""

    def check(
        name: str,
        limits: tuple[tuple[float, float], str] | None = None,
        optional: bool = False,
        bound: str = "",
        strict: bool = False,
        relation: str = "",
    ) -> str:
        (low, high), meaning = limits or NUMBERS[name.rpartition(".")[2]]
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
        for rule in BLOCK_RULES:
            owner = f"joint[{i}]" if rule.of_joint else f"block[{i}]"
            bound = f"block[{i}].{rule.bound}" if rule.bound else ""
            rows.append(check(f"{owner}.{rule.key}", None, rule.optional, bound, rule.strict, rule.relation))
    return [*rows, check("solver.step"), check("solver.tolerance"), check(RECORD_SCALE, rules.SCALE_LIMITS)]


def _record(contents: Contents) -> list[str]:
    """The samples as they are; the slopes in between are the kernels' business."""
    motion = contents.record
    count = 0 if motion is None else len(motion.time)
    dt = 0.0 if motion is None else Record(motion).dt
    pga = 0.0 if motion is None else motion.pga
    lines = _enum({"SAMPLES": count})
    lines += [f"#define RECORD_DT {_number(dt)}", f"#define RECORD_LARGEST {_number(pga)}"]
    lines.append(f"#define RECORD_NAME {_quoted(contents.record_name)}")
    for name in ("time", "ax", "az"):
        samples = np.zeros(0) if motion is None else getattr(motion, name)
        lines += _array("double", f"record_{name}", [_number(value) for value in samples])
    return lines
