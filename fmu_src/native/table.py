"""The headers with which the C core is compiled, generated from the tables of Python.

contract.h  of the model: the kernels with their arguments by name, sizes and codes, limits, messages
table.h     of one FMU: variables, start values, checks of the parameters, the record
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from solver.common.ranges import NUMBERS
from solver.ground.motion import LARGEST, Motion
from solver.kernels.column.api import driven_entries as of_columns
from solver.kernels.column.model.description import DETAILS
from solver.kernels.layout.spaces import DRIVES, TOO_MUCH_WORK
from solver.kernels.machine.entry import ENTRIES, Entry
from solver.kernels.machine.kinds import Int, Ints, Real, Reals, SizedReals
from solver.kernels.machine.packaging import PREFIX
from solver.models.outputs import Output, places_of

from .. import alternation, rules, state_ranges
from ..drive import MOTION, Idle, idle
from ..record import Record
from ..references import FAMILY, array_of
from ..state_ranges import RangeBlock, Ranges
from ..variables import ACCELERATIONS, DRIVE, STEP_SIZE, VERDICT, Variable

TEXT = 256  # bytes of a String, its end included
STATE_FORMAT = "multiblock-fmu native state 5"
CALLED = ("assemble", "follow", "look", "rates", "feedthrough")  # entries of a group that the core calls
READ_ONLY = ("given", "inputs", "times", "ax", "ay", "az", "seeds")  # arrays that the kernels do not modify
C_TYPES = {Real: "double ", Int: "int64_t ", Reals: "double *", Ints: "int64_t *", SizedReals: "double *"}
STORED = {"Real": "REAL", "Integer": "INTEGER", "Enumeration": "INTEGER", "Boolean": "BOOLEAN", "String": "STRING"}
# names that the core uses: sizes that depend on the model; places and codes that only some bodies have
SIZES = ("N", "MODEL", "STATE", "COUNTS", "BASE", "WORK", "ROW", "SPLIT", "ROOM")
REFUSALS = ("MISFIT", "NO_REST", "NOT_LINEAR", "TOO_LARGE", "UNKNOWN_SECTION")  # codes of `assemble`
CODES = ("COUNT_OVERTURNED", *REFUSALS, "STATE_OVERTURN_TIME", "COUNT_RESTING")
PLACES = (
    *("PEAKS", "OVERTURN_TIME", "FALLEN", "OVERTURNED", "VERDICT"),
    *("RECORD", "RECORD_PGA", "RECORD_SCALE", "TOLERANCE"),
)
FIRST_PEAK = "block[1].ux_peak"
OF_BLOCKS = {  # places that every body of blocks has
    **{"PEAKS": FIRST_PEAK, "VERDICT": "verdict", "OVERTURN_TIME": "overturn_time", "OVERTURNED": "overturned"},
    **{"RECORD": "base.record", "RECORD_PGA": "base.record_pga", "RECORD_SCALE": "base.record_scale"},
    "TOLERANCE": "solver.tolerance",
}


@dataclass(frozen=True)
class ChoiceParameter:
    """A parameter that selects one (ONE_WORD) or several (ANY_WORDS) of its items, as text."""

    name: str
    way: str
    items: list[tuple[int, str]]  # the kernels' code, the word


class Peak(NamedTuple):
    """An extreme: its index in the state, and whether it is a minimum, of which the largest 1 - value is stored."""

    place: int
    by_least: bool


@dataclass(frozen=True)
class NativeSubject:
    """The simulated body, as the core has to know it."""

    falls: bool  # whether it has a verdict, and peaks in the order of the variables; a partner of a column has neither
    sizes: dict[str, int]  # by name in SIZES
    codes: dict[str, int]  # by name in CODES
    places: dict[str, str]  # of PLACES -> variable
    inputs: list[str]  # in the order of the kernels
    slopes: dict[str, str]  # input -> the input that is its slope
    split: str  # first variable after those of the output row
    given: list[str | float]  # arguments of `assemble` in its order: parameters, and constants
    choices: list[ChoiceParameter]
    checks: list[RangeCheck]
    reasons: dict[int, str]
    peaks: list[Peak] = field(default_factory=list)
    misfits: list[tuple[str, str]] = field(default_factory=list)  # name and relation, by the kind from 1
    ranges: Ranges | None = None  # of the numbers of its state; None: all are finite
    base: tuple[str, ...] = ()  # fields of `base`; accelerations by the names of their inputs
    group: str = of_columns.follow.group  # of its kernels (solver/kernels/machine/groups.py)

    @property
    def lines(self) -> dict[str, str]:
        """The inputs that a host may follow within a step because they are linear in it, and their slopes.

        There are none if bodies may drive the base: they exchange with it once per step.
        """
        if any(choice.name == DRIVE for choice in self.choices):
            return {}
        ends = {name: slope for name, slope in self.slopes.items() if slope not in self.slopes}
        return {name: slope for name, slope in ends.items() if name not in self.slopes.values()}


@dataclass(frozen=True)
class RangeCheck:
    """The limits of a Real parameter, and another variable that bounds it."""

    name: str
    limits: tuple[float, float]
    meaning: str  # valid values, for the message
    optional: bool = False  # 0 stands for "not given"
    bound: str = ""
    strict: bool = False
    relation: str = ""
    fixed: float | None = None  # a constant of that name, no parameter, which is checked against the bound alone
    otherwise: str = ""  # the variable that bounds where the value of `bound` is 0
    needs: str = ""  # a variable that may not be 0


@dataclass(frozen=True)
class Contents:
    """The content of one FMU."""

    subject: NativeSubject
    table: list[Variable]
    guid: str
    record_name: str
    record: Motion | None
    scalars: bool = False  # of FMI 3.0 without arrays for the quantities of blocks and joints


def peaks_of(
    outputs: Sequence[Output], sizes: Mapping[str, int], last: int, beside: Mapping[str, int] | None = None
) -> list[Peak]:
    """Return the peaks of a body of blocks, of which `sizes` has the numbers of blocks, joints and so on, by owner.

    They end at the index `last` of the state, except those of the owners in `beside`, which begin at its indices.
    """
    beside = beside or {}
    own = [output for output in outputs if output.owner not in beside]
    found, begins = places_of(own, sizes), {}
    begins = {output.field: last - found[own[-1].field].stop + found[output.field].start for output in own}
    for owner, place in beside.items():
        for output in (output for output in outputs if output.owner == owner):
            begins[output.field], place = place, place + sizes[owner]
    lengths = {field: place.stop - place.start for field, place in places_of(outputs, sizes).items()}
    every = ((begins[output.field], lengths[output.field], output.by_least) for output in outputs)
    return [Peak(first + k, by_least) for first, length, by_least in every for k in range(length)]


def headers(contents: Contents) -> dict[str, str]:
    """Return the generated header files, name -> text."""
    note = "/* Made by build_fmu.py; not to be edited. */\n"
    return {"contract.h": note + contract(contents.subject), "table.h": note + declarations(contents)}


# --- contract.h


def contract(subject: NativeSubject) -> str:
    """Return the text of contract.h: the kernels, with their sizes, codes and messages."""
    sizes = {name: subject.sizes[name] for name in SIZES}
    sizes |= {"BASE_INPUTS": len(subject.inputs), "GIVEN": len(subject.given), "DETAILS": DETAILS}
    codes = {"FALLS": int(subject.falls), "TOO_MUCH_WORK": TOO_MUCH_WORK}
    for name, key in (("SEGMENT", "segment"), ("COUPLED", "coupled"), ("ALLOWED", "allowed_step")):
        codes[f"BASE_{name}"] = subject.base.index(key) if key in subject.base else -1
    codes |= {f"IDLE_{when.name}": when.value for when in Idle}
    codes |= {f"VERDICT_{word.upper()}": number for word, number in VERDICT.items.items()}
    codes |= {name: subject.codes.get(name, 0) for name in CODES}
    # sizes, codes, tolerances and messages
    lines = ["#include <stdint.h>", *_enum(sizes), *_enum(codes)]
    lines.append('_Static_assert(sizeof(double) == 8 && sizeof(void *) == 8, "slots of kernels");')
    lines += [f"#define {name} {getattr(rules, name)!r}" for name in ("TIME_SLACK", "STEP_SLACK", "STILL")]
    lines += [f"#define ALTERNATES_{name} {getattr(alternation, name)!r}" for name in ("MANY", "BACK", "GROWTH")]
    lines.append(f"#define MUST_INERTIA {_quoted('must be ' + NUMBERS['inertia'][1])}")
    messages = {name: text for name, text in vars(rules).items() if name.isupper() and isinstance(text, str)}
    lines += [f"#define SAY_{name} {_quoted(text)}" for name, text in messages.items()]
    for name in CALLED:
        lines += _kernel(ENTRIES[subject.group, name])
    return "\n".join(lines) + "\n"


def _enum(values: dict[str, int]) -> list[str]:
    return ["enum {", *(f"    {name} = {value}," for name, value in values.items()), "};"]


def arguments(entry: Entry) -> dict[str, str]:
    """Return the declarations of all slots of an entry's buffer, in their order, by name."""
    found = {}
    for name, kind in entry.kinds.items():
        found[name] = f"{'const ' * (name in READ_ONLY)}{C_TYPES[kind]}{name}"
        if kind is SizedReals:
            found[f"{name}_size"] = f"int64_t {name}_size"
    return found


def given_to(name: str) -> dict[str, str]:
    """Return the arguments that the core gives to the kernel of a name: those of columns, and ay of a record."""
    known = arguments(ENTRIES[of_columns.follow.group, name])
    return known | ({"ay": "const double *ay"} if "ax" in known else {})


def _kernel(entry: Entry) -> list[str]:
    """Return the declaration of a kernel, and a function around it with named arguments.

    The arguments lie as in the buffer of the kernel, unused ones behind.
    """
    name, own, known = entry.__name__, arguments(entry), given_to(entry.__name__)
    if not own.keys() <= known.keys():
        raise ValueError(f"{entry.group}, {name}: core.c does not give {', '.join(own.keys() - known.keys())}")
    fields = "; ".join((own | {more: text for more, text in known.items() if more not in own}).values())
    return [
        f"int64_t {PREFIX}{name}(const void *);",
        f"typedef struct {{ {fields}; }} {name.title()};",  # look -> Look
        f"static inline int64_t {name}({name.title()} of) {{ return {PREFIX}{name}(&of); }}",
    ]


# --- table.h


def declarations(contents: Contents) -> str:
    """Return the text of table.h."""
    subject, table = contents.subject, contents.table
    if [item.name for item in table if item.causality == "input"] != subject.inputs:
        raise ValueError("the inputs of the FMU are not in the order of the kernels")
    index = {variable.name: k for k, variable in enumerate(table)}
    places = storage(table)
    reals = [variable for variable in table if STORED[variable.kind] == "REAL"]
    wholes = [variable for variable in table if STORED[variable.kind] in ("INTEGER", "BOOLEAN")]
    strings = [variable for variable in table if STORED[variable.kind] == "STRING"]
    # lengths and places
    numbers = {
        "REALS": len(reals),
        "WHOLES": max(len(wholes), 1),
        "TEXTS": max(len(strings), 1),
        "TEXT": TEXT,
        "FAMILY": FAMILY,
        "AT_ROW": len(subject.inputs),
        "AT_SPLIT": places[subject.split],
        "LINES": len(subject.lines),
        "CHOICES": len(subject.choices),
        "CHECKS": len(subject.checks),
        "PEAKS": len(subject.peaks),
        "HAS_RECORD": int("RECORD" in subject.places),
        "HAS_TOLERANCE": int("TOLERANCE" in subject.places),
    }
    chosen = [choice.name for choice in subject.choices]
    numbers["DRIVE_CHOICE"] = chosen.index(DRIVE) if DRIVE in chosen else -1
    motions = [subject.base.index(name) for name in MOTION if name in subject.base]
    loads = [k for k, name in enumerate(subject.inputs) if name.startswith("port[")]
    numbers |= {"MOTIONS": len(motions), "AT_LOADS": min(loads, default=0), "LOADS": len(loads)}
    numbers |= {f"AT_{name}": places[subject.places[name]] if name in subject.places else 0 for name in PLACES}
    lines = _enum(numbers)
    texts = {"RECORD_KEY": subject.places.get("RECORD", ""), "IDENTITY": contents.guid, "STATE_FORMAT": STATE_FORMAT}
    lines += [f"#define {name} {_quoted(text)}" for name, text in texts.items()]
    lines += [f"#define {name} {getattr(state_ranges, name)!r}" for name in ("MOST", "MOST_TRIED", "MOST_TIME")]
    # variables and start values
    lines += _array("Variable", "variables", [_variable(variable, places[variable.name]) for variable in table])
    lines += _array("double", "real_starts", [_number(_start(variable)) for variable in reals])
    lines += _array("int", "whole_starts", [str(int(_start(variable))) for variable in wholes])
    lines += _array("char *const", "text_starts", [_quoted(str(variable.start)) for variable in strings])
    lines += _families(table, contents.scalars)
    # inputs: indices in `base`, effect, slopes
    units = {variable.name: variable.unit for variable in table}
    watched = [name.removeprefix("base.") if units[name] in ACCELERATIONS else "" for name in subject.inputs]
    places_in_base = [subject.base.index(name) if name in subject.base and name else -1 for name in watched]
    lines += _array("int", "place_in_base", list(map(str, places_in_base)))
    lines += _array("int", "motion_in_base", list(map(str, motions)))
    lines += _array("int", "idle", [str(_idle(name) if DRIVE in chosen else 0) for name in subject.inputs])
    lines += _array("int", "slope_of", [str(places.get(subject.slopes.get(name, ""), -1)) for name in subject.inputs])
    references = {variable.name: variable.reference for variable in table}
    listed = [f"{{{references[name]}, {references[slope]}}}" for name, slope in subject.lines.items()]
    lines += _array("Line", "lines", listed or ["{0, 0}"])
    # arguments of `assemble`
    fixed = [isinstance(name, float) or name in chosen for name in subject.given]  # choices are given as a code
    found = ["-1" if own else str(places[str(name)]) for name, own in zip(subject.given, fixed, strict=True)]
    lines += _array("int", "given", found)
    constants = [name if isinstance(name, float) else 0.0 for name in subject.given]
    lines += _array("double", "given_fixed", [_number(value) for value in constants])
    # checks of parameters and of the state
    lines += _choices(subject, index)
    lines += _array("Check", "checks", [_check(check, index) for check in subject.checks])
    lines += _array("Reason", "reasons", [f"{{{code}, {_quoted(text)}}}" for code, text in subject.reasons.items()])
    peaks = [f"{{{place}, {int(by_least)}}}" for place, by_least in subject.peaks]
    lines += _array("Peak", "peaks", peaks or ["{0, 0}"])
    misfits = [f"{{{_quoted(name)}, {_quoted(relation)}}}" for name, relation in subject.misfits]
    lines += _array("Misfit", "misfits", misfits or ["{0, 0}"])
    sizes = subject.sizes["STATE"], subject.sizes["COUNTS"], subject.sizes["BASE"]
    for name, runs in (subject.ranges or state_ranges.finite(*sizes))._asdict().items():
        lines += _array("Range", f"{name}_ranges", list(map(_range, runs)))
    lines += _record(contents)
    return "\n".join(lines) + "\n"


def _idle(name: str) -> int:
    """Return two bits for each code of DRIVES that say when an input has no effect."""
    when = {int(code): idle(word, name) for word, code in DRIVES.items()}
    return sum(found.value << 2 * code for code, found in when.items() if found)


def _quoted(text: str) -> str:
    """Return a C string literal of UTF-8 bytes."""
    parts = []
    for byte in text.encode():
        parts.append(chr(byte) if 32 <= byte < 127 and chr(byte) not in '"\\?' else f"\\{byte:03o}")
    return '"' + "".join(parts) + '"'


def _number(value: float) -> str:
    return float(value).hex() if math.isfinite(value) else "INFINITY" if value > 0.0 else "-INFINITY"


def _range(run: RangeBlock) -> str:
    flags = int(run.range.whole), int(run.range.may_lack), int(run.range.of_inputs)
    return f"{{{run.length}, {_number(run.range.low)}, {_number(run.range.high)}, {', '.join(map(str, flags))}}}"


def _start(variable: Variable) -> float:
    return float(variable.start) if isinstance(variable.start, (int, float)) else 0.0


def _array(kind: str, name: str, items: list[str]) -> list[str]:
    """Return a constant array; C has no empty one, so one zero stands for it."""
    return [f"static const {kind} {name}[] = {{", *(f"    {item}," for item in items or ["0"]), "};"]


def storage(table: list[Variable]) -> dict[str, int]:
    """Return the index of every variable in the array that stores it: of reals, of integers or of texts."""
    arrays = {"REAL": "reals", "INTEGER": "wholes", "BOOLEAN": "wholes", "STRING": "texts"}
    filled = dict.fromkeys(arrays.values(), 0)
    places: dict[str, int] = {}
    for variable in table:
        array = arrays[STORED[variable.kind]]
        places[variable.name] = filled[array]
        filled[array] += 1
    return places


def _families(table: list[Variable], scalars: bool) -> list[str]:
    """Return for each family of value references the rows of `variables` by number from 1; -1: none."""
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
        is_array = int(not scalars and any(array_of(table[row].name) for row in rows.values()))
        listed.append(f"{{{count}, {f'family_{family}' if count else 'NULL'}, {is_array}}}")
    return [*lines, *_array("Family", "family_index", listed)]


def _variable(variable: Variable, place: int) -> str:
    tunable = int(variable.variability == "tunable")
    words = (STORED[variable.kind], variable.causality.upper(), tunable, place)
    return f"{{{_quoted(variable.name)}, {_quoted(variable.unit)}, {', '.join(map(str, words))}}}"


def _choices(subject: NativeSubject, index: dict[str, int]) -> list[str]:
    lines, rows = [], []
    for k, choice in enumerate(subject.choices):
        items = [f"{{{code}, {_quoted(word)}}}" for code, word in choice.items]
        lines += _array("Item", f"items_{k}", items)
        place = subject.given.index(choice.name)
        rows.append(f"{{{index[choice.name]}, {place}, {choice.way}, {len(items)}, items_{k}}}")
    return [*lines, *_array("Choice", "choices", rows)]


def _check(check: RangeCheck, index: dict[str, int]) -> str:
    parts = [
        "-1" if check.fixed is not None else str(index[check.name]),
        _quoted(check.name),
        _number(check.fixed or 0.0),
        *map(_number, check.limits),
        str(int(check.optional)),
        _quoted(f"must be {check.meaning}"),
        *(str(index[bound]) if bound else "-1" for bound in (check.bound, check.otherwise, check.needs)),
        str(int(check.strict)),
        _quoted(check.relation),
    ]
    return f"{{{', '.join(parts)}}}"


def _record(contents: Contents) -> list[str]:
    """Return the arrays of the samples; the kernels compute the slopes between them."""
    motion, record = contents.record, None if contents.record is None else Record(contents.record)
    largest = 0.0 if motion is None else max(np.abs(part).max() for part in (motion.ax, motion.ay, motion.az))
    numbers = {
        "USUAL_STEP": record.dt if record else STEP_SIZE,
        "RECORD_DT": record.dt if record else 0.0,
        "RECORD_LARGEST": record.pga if record else 0.0,
        "RECORD_BEGINS": record.begins if record else math.inf,
        "RECORD_ENDS": record.ends if record else -math.inf,
        "MOST_RECORD_SCALE": LARGEST / largest if largest > 0.0 else LARGEST,
    }
    lines = _enum({"SAMPLES": 0 if motion is None else len(motion.time)})
    lines += [f"#define {name} {_number(number)}" for name, number in numbers.items()]
    lines.append(f"#define RECORD_NAME {_quoted(contents.record_name)}")
    for name in ("time", "ax", "ay", "az"):
        samples = np.zeros(0) if motion is None else getattr(motion, name)
        lines += _array("double", f"record_{name}", [_number(value) for value in samples])
    return lines
