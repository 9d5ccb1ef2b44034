"""Files of columns, structures, studies, journals, records, motions: read as an independent reader does, or refused."""

from __future__ import annotations

import contextlib
import json
import math
import re
import tempfile
import time as clock
import tomllib
from collections.abc import Callable
from decimal import Decimal
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from hypothesis import HealthCheck, Phase, given, seed, settings
from hypothesis import strategies as st

from solver import Column, InputError, Motion
from solver.commands.reports import motion_report
from solver.commands.study import summary
from solver.common.errors import reading
from solver.common.text_tables import MOST_ROUNDED
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.stepper import Stepper
from solver.studies import Study
from solver.studies.execution import head_of
from solver.studies.journal import Journal, line_of
from solver.studies.results import results_of

from . import fuzz_structures
from .fuzz_structures import REFUSED

TOML = """name = "two"
g = 9.81
[[block]]
height = 2.0
width = 1.0
depth = 0.5
mass = 3000.0
centroid = 0.9
inertia = 1500.0
[block.joint]
stiffness = 1e9
damping = 2e-3
[[block]]
height = 3.0
width = 1.0
depth = 0.5
density = 2000.0
[joint]
stiffness = 5e8
damping = 1e-3
[solver]
formulation = "exact"
tolerance = 1e-6
"""
AT2 = """PEER STRONG MOTION DATABASE RECORD
A TEST, 000
ACCELERATION TIME HISTORY IN UNITS OF G. FILTER POINTS: NONE
NPTS=  5, DT= .02000 SEC
  .1E-01  -.2000000E+00   .3
  0.4 -0.05
"""
CSV = "time,base.ax,base.az\n0.0,0.1,-0.2\n0.02,0.3,0.1\n0.05,-1e-1,0\n"

STUDY = """name = "small"
kind = "fragility"
column = "column.toml"
samples = 6
sampling = "sobol"
seed = 3
tolerance = 1e-3
keep = ["peak_ux", "verdict", "overturn_time"]
limits = [0.25, 0.5]
[[motion]]
formula = "near-fault"
name = "near"
magnitude = 6.5
distance = 5.0
[intensity]
measure = "pga"
[grid]
intensity = [0.2, 0.6]
[random."motion.seed"]
distribution = "integers"
low = 0
high = 1000
[random."joint.stiffness"]
distribution = "lognormal"
median = 1.0
deviation = 0.3
relative = true
each = true
"""

MOST_ACCELERATION = 1e6  # m/s2
NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([dDeE][+-]?\d+)?")
NUMBERS = ["nan", "-inf", "inf", "1e999", "-1", "0", "1e-320", "1e300", "1_0", "0x10", "1e5", "\u0663"]
WORDS = ["true", "e", "[[block]]", "height", "mass", "NPTS", "\u00e9"]
SIGNS = ['"', "'", "[", "]", "=", "\n", ",", ".", "-", "\x00", "\ufeff", "  ", "\t", "#"]
SNIPPETS = [*NUMBERS, *WORDS, *SIGNS]


def mutated(text: str) -> st.SearchStrategy[bytes]:
    """Return the text with a few numbers changed, pieces cut, doubled or put in, or bytes overwritten."""
    places = [match.span() for match in NUMBER.finditer(text)]
    spot = st.integers(0, len(text))

    def number(start: str, place: tuple[int, int], instead: str) -> str:
        return start[: place[0]] + instead + start[place[1] :]

    one_number = st.builds(
        number, st.just(text), st.sampled_from(places), st.one_of(st.sampled_from(SNIPPETS), st.floats().map(repr))
    )
    insert = st.builds(lambda k, s: text[:k] + s + text[k:], spot, st.sampled_from(SNIPPETS))
    cut = st.builds(lambda a, b: text[: min(a, b)] + text[max(a, b) :], spot, spot)
    double = st.builds(lambda a, b: text[: max(a, b)] + text[min(a, b) :], spot, spot)
    lines = st.permutations(text.splitlines(keepends=True)).map("".join)
    data = st.one_of(one_number, one_number, insert, cut, double, lines, st.just(text)).map(lambda t: t.encode())
    byte = st.builds(
        lambda k, b: text.encode()[:k] + b + text.encode()[k + 1 :], spot, st.binary(min_size=1, max_size=3)
    )
    return st.one_of(data, data, data, byte)


def column_problem(path: Path) -> str | None:
    """Return the mistake in how a column file was read; REFUSED or None if there is none."""
    try:
        column = Column.from_toml(path)
    except InputError as error:
        return _message_problem(path, error)
    for block in column.blocks:
        values = [block.height, block.width, block.depth, block.mass, block.resolved_inertia, block.joint.stiffness]
        if not all(math.isfinite(value) and value > 0.0 for value in values):
            return f"accepted: {block}"
    if Column.from_dict(column.to_dict()) != column:
        return "its mapping gives another column"
    try:
        row = Stepper(column).observe(0.0)
    except InputError as error:  # for a column without a stable rest, as with g = 1e-320
        return None if "cannot stand" in str(error) else f"said: {str(error)!r}"
    if not np.all(np.isfinite(row)):
        return f"outputs at rest are not finite: {column}"
    return None


def motion_problem(path: Path) -> str | None:
    """Return the mistake in how a motion was read or refused, against an independent reader; REFUSED or None if there
    is none.
    """
    read = Motion.from_csv if path.suffix == ".csv" else Motion.from_at2
    raw = path.read_bytes()
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError:
        text = raw.decode("latin-1")
    plain = _plain_csv(text) if path.suffix == ".csv" else _plain_at2(text)
    try:
        motion = read(path)
    except InputError as error:
        if plain is not None and "\0" not in text and np.max(np.abs(plain[1:])) <= MOST_ACCELERATION:
            return f"refused: {text!r}: {error}"
        return _message_problem(path, error)
    if plain is None:
        return f"accepted: {text!r}"
    time, ax, az = plain
    same = np.array_equal(motion.time, time) and np.array_equal(motion.ax, ax) and np.array_equal(motion.az, az)
    return None if same else f"read as {motion}"


def _message_problem(path: Path, error: InputError) -> str | None:
    message = str(error)
    return REFUSED if message.startswith(f"{path}: ") and "\n" not in message else f"said: {message!r}"


def _numbers(fields: list[str]) -> list[float] | None:
    if not all(map(_is_number, fields)):
        return None
    values = [float(re.sub("[dD]", "e", field)) for field in fields]
    return values if all(map(math.isfinite, values)) else None


def _is_number(field: str) -> bool:
    return field.isascii() and NUMBER.fullmatch(field.strip()) is not None


def _plain_csv(text: str) -> tuple[list[float], list[float], list[float]] | None:
    lines = re.split(r"\r\n|\r|\n", text)
    while lines and lines[-1].strip() == "":
        lines.pop()
    mark = next((mark for mark in ";\t" if lines and mark in lines[0]), ",")
    unquoted = [re.sub(rf'(^|(?<={mark}))"([^"{mark}]*)"(?={mark}|$)', r"\2", line) for line in lines]
    header = [name.strip().lower() for name in unquoted[0].split(mark)] if unquoted else []
    if sorted(header[1:]) not in (["base.ax"], ["base.az"], ["base.ax", "base.az"]) or header[0] != "time":
        return None
    rows = [_numbers(line.split(mark)) for line in unquoted[1:]]
    if len(rows) < 2 or any(row is None or len(row) != len(header) for row in rows):
        return None
    columns: dict[str, Any] = dict(zip(header, zip(*rows, strict=True), strict=True))
    time = columns["time"]
    if any(later <= earlier for earlier, later in pairwise(time)):
        return None
    zeros = [0.0] * len(time)
    if np.spacing(max(map(abs, time))) > MOST_ROUNDED * np.min(np.diff(time)):  # as of seconds since 1970
        texts = [line.split(mark)[header.index("time")] for line in unquoted[1:]]
        exact = [Decimal(re.sub("[dD]", "e", text.strip())) for text in texts]
        time = [float(value - exact[0]) for value in exact]
        if any(later <= earlier for earlier, later in pairwise(time)):
            return None
    return list(time), list(columns.get("base.ax", zeros)), list(columns.get("base.az", zeros))


def _plain_at2(text: str) -> tuple[Any, Any, Any] | None:
    lines = re.split(r"\r\n|\r|\n", text)
    if len(lines) < 5 or not re.search(r"\bunits\s+of\s+g\b", lines[2], re.IGNORECASE):
        return None
    size = re.match(r"\s*NPTS\s*=\s*(\d+)\s*,\s*DT\s*=\s*([^\sS,]+),?\s*(SEC|$)", lines[3], re.ASCII)
    if size is None or not _is_number(size[2]):
        return None
    parted = re.sub(r"(?<=\d)(?=[+-](\d+\.|\.\d))", " ", " ".join(lines[4:]))  # touching columns
    values = _numbers(parted.split())
    dt = float(size[2])
    if values is None or len(values) != int(size[1]) or len(values) < 2 or not 0.0 < dt < math.inf:
        return None
    return dt * np.arange(len(values)), STANDARD_GRAVITY * np.array(values), np.zeros(len(values))


def record_problem(path: Path) -> str | None:
    """Return the mistake in how a record of any format was read, or in its measures; or None."""
    try:
        motion = Motion.from_file(path)
        with reading(path):
            text = motion_report(motion)
    except InputError as error:
        return _message_problem(path, error)
    return None if text and "\n\n" not in text else f"said: {text!r}"


def study_problem(path: Path) -> str | None:
    """Return the mistake in how a study, whose column stands beside it, was read; or None."""
    (path.parent / "column.toml").write_text(TOML)
    try:
        study = Study.from_toml(path)
    except InputError as error:
        return _message_problem(path, error)
    if Path(study.name).name != study.name:
        return f"accepted: name {study.name!r}"
    for number in {0, study.runs // 2, study.runs - 1}:
        with contextlib.suppress(InputError):
            study.run(number)
    return None


def journal_problem(path: Path) -> str | None:
    """Return the mistake in how a journal was read, shown and continued; or None."""
    try:
        text = summary(results_of(path))
    except InputError as error:
        problem = _message_problem(path, error)
        return REFUSED if str(error).startswith("grid.") else problem
    head = json.loads(JOURNAL.splitlines()[0][9:])
    with contextlib.suppress(InputError), Journal(path, head):
        pass
    return None if text else "said nothing"


def journals(text: bytes) -> st.SearchStrategy[bytes]:
    """Return the journal with some of its values changed, under right checksums: types, lengths, names, numbers,
    repeats.
    """
    lines = [json.loads(line[9:]) for line in text.splitlines()]
    odd = st.one_of(
        st.sampled_from(
            [None, True, -1, 0, 1.5, 1e308, 10**30, math.nan, math.inf, "", "x", "../x", "ida", [], [1], {}, {"a": 1}]
        ),
        st.text(max_size=5),
        st.floats(),
    )

    def changed(data: Any, which: Callable[[int], int], value: Any, how: str) -> Any:
        """Return the data with one place in it, anywhere, replaced, taken away or doubled."""
        if isinstance(data, (dict, list)) and data and which(3):
            keys = list(data) if isinstance(data, dict) else list(range(len(data)))
            key = keys[which(len(keys))]
            made = data.copy()
            if how != "put" and which(2):
                if how == "cut":
                    del made[key]
                elif isinstance(made, list):
                    made.insert(key, made[key])
                return made
            made[key] = changed(data[key], which, value, how)
            return made
        return value

    def build(numbers: list[int], line: int, value: Any, how: str, repeat: bool) -> bytes:
        left = list(numbers)
        which = lambda count: (left.pop() if left else 0) % count  # noqa: E731
        made = list(lines)
        made[line] = changed(made[line], which, value, how)
        return b"".join(map(line_of, made + made[1:] * repeat))

    numbers = st.lists(st.integers(1, 10**6), min_size=4, max_size=14)
    ways = st.sampled_from(["put", "cut", "double"])
    return st.builds(build, numbers, st.integers(0, len(lines) - 1), odd, ways, st.booleans())


def _journal() -> bytes:
    """Return a journal of twelve runs, made as a study makes it."""
    with tempfile.TemporaryDirectory(prefix="stress_") as folder:
        (Path(folder) / "column.toml").write_text(TOML)
        study = Study.from_dict(tomllib.loads(STUDY), folder)
        kept = {"peak_ux": [0.1, 0.2], "verdict": "standing", "overturn_time": math.nan}
        head: dict[str, Any] = {"format": 1, **head_of(study)}
        rows = [
            [k, [*study.values(k).values()], [0.2, 0.3], kept if k % 4 else None, "" if k % 4 else "not made"]
            for k in range(study.runs)
        ]
        return b"".join(map(line_of, [head, *rows]))


JOURNAL = _journal()
KINDS: dict[str, tuple[str, Callable[[Path], str | None]]] = {
    "column.toml": (TOML, column_problem),
    "record.AT2": (AT2, motion_problem),
    "motion.csv": (CSV, motion_problem),
    "any.txt": (AT2, record_problem),
    "study.toml": (STUDY, study_problem),
    "small.journal": (JOURNAL.decode(), journal_problem),
    "structure.toml": (fuzz_structures.TOML, fuzz_structures.structure_problem),
    "builders": ("", fuzz_structures.builder_problem),
}
PATIENCE = 10.0  # s of the processor, for one file


# every search: repeatable from its seed alone
SEARCH: dict[str, Any] = {
    "deadline": None,
    "database": None,
    "phases": [Phase.generate, Phase.shrink],
    "suppress_health_check": list(HealthCheck),
}


def _files_of(kind: str, text: str) -> st.SearchStrategy[bytes]:
    """Return the files of a kind."""
    if kind == "builders":
        return fuzz_structures.calls()
    return journals(JOURNAL) if kind.endswith(".journal") else mutated(text)


def fuzz(kind: str, number: int, examples: int) -> dict[str, Any]:
    """Read `count` files of one kind: {"files", "refused", "failures": the smallest that fails}."""
    text, problem_of = KINDS[kind]
    counts = {"files": 0, "refused": 0}
    smallest: dict[str, str] = {}
    with tempfile.TemporaryDirectory(prefix="stress_") as folder:
        path = Path(folder) / kind
        if text:  # what it needs is compiled before any is timed
            path.write_text(text, encoding="utf-8")
            problem_of(path)

        @seed(number)
        @settings(max_examples=examples, **SEARCH)
        @given(_files_of(kind, text))
        def hold(content: bytes) -> None:
            counts["files"] += 1
            path.write_bytes(content)
            begin = clock.process_time()
            try:
                problem = problem_of(path)
            except Exception as error:
                problem = f"{type(error).__name__}: {error}"
            if clock.process_time() - begin > PATIENCE and (text or counts["files"] > 1):  # the first one may compile
                problem = f"took {clock.process_time() - begin:.3g} s"
            counts["refused"] += problem == REFUSED
            if problem:
                smallest.update(problem=problem, content=repr(content))
            assert not problem

        with contextlib.suppress(AssertionError):
            hold()
    return counts | {"failures": [dict(smallest)] if smallest else []}
