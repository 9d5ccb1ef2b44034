"""Every number that the state of an FMU holds has a range; numbers out of it are refused before a kernel runs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from fmu_src import state_ranges
from fmu_src.body import ColumnBody, StructureBody, read_body
from fmu_src.native import table
from fmu_src.native.column_subject import column_subject
from fmu_src.native.structure_subject import structure_subject
from fmu_src.slave import ARRAYS
from fmu_src.state import Snapshot
from solver.kernels.layout import spaces as plane
from solver.kernels.numba_ext.views import FieldTable, LayoutPart, Numbers, Record, Space
from solver.kernels.structure import layout as space

COLUMNS = [(n, ports) for n in (1, 3) for ports in (0, 2)]
SIZES = space.sizes_of(4, 3, 2, 1, 40, ports=2, pairs=2, bonds=2)


def names(part: LayoutPart) -> list[str]:
    """Return the names of the numbers of a layout, as deep as there are names, in their order."""
    if isinstance(part, Numbers):
        return [""]
    if isinstance(part, (Record, FieldTable)):
        return list(part.fields)
    assert isinstance(part, Space)
    return [f"{name}.{inner}".rstrip(".") for name, own in part.parts.items() for inner in names(own)]


LAYOUTS = [
    (plane.STATE, state_ranges.COLUMN_STATE),
    (plane.COUNTS, state_ranges.COLUMN_COUNTS),
    (plane.BASE, state_ranges.COLUMN_BASE),
    (space.STATE, state_ranges.STRUCTURE_STATE),
    (space.COUNTS, state_ranges.STRUCTURE_COUNTS),
    (space.INPUT_MOTION, state_ranges.STRUCTURE_BASE),
    (space.BONDED, state_ranges.POLYGON),
]


@pytest.mark.parametrize(("layout", "described"), LAYOUTS)
def test_every_field_of_a_state_is_described(layout: LayoutPart, described: dict[str, Any]) -> None:
    together = {
        f"phase.{name}": [f"phase.{field}" for field in plane.PHASE.fields[2 * k : 2 * k + 2]]
        for k, name in enumerate(("coordinates", "rates", "accelerations"))
    }
    found = [field for name in described for field in together.get(name, [name])]
    assert sorted(found) == sorted(names(layout))


def test_a_new_field_that_is_not_described_is_an_error(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ("COUNTS", "BASE"):
        with monkeypatch.context() as patched:
            patched.setattr(plane, name, Record(*getattr(plane, name).fields, "new"))
            with pytest.raises(ValueError, match="has no range"):
                state_ranges.of_column(2, 0, 0)
    more = Space(**{**plane.STATE.parts, "more": Numbers(per_n=1)})
    monkeypatch.setattr(plane, "STATE", more)
    with pytest.raises(ValueError, match="has no range"):
        state_ranges.of_column(2, 0, 0)
    sizes = space.Sizes._fields
    monkeypatch.setattr(
        space,
        "INPUT_MOTION",
        Space(*sizes, motion=Record(*space.BASE.fields, "new"), loads=(space.INPUT_LOADS, "ports")),
    )
    with pytest.raises(ValueError, match="has no range"):
        state_ranges.of_structure(SIZES)


def test_a_snapshot_has_no_other_arrays_and_fields() -> None:
    """Check the fields: a new one is to be checked in state.py, check_contents, as those of a moment in is_possible of
    core.c.
    """
    assert state_ranges.Ranges._fields == ARRAYS
    assert Snapshot._fields == (
        *("stamp", "mode", "time", "input_time", "shaken", "retune", "inputs_stand", "tolerance_set"),
        *("values", "built_from", "record", "arrays"),
    )


def lengths(ranges: state_ranges.Ranges) -> list[int]:
    return [sum(run.length for run in runs) for runs in ranges]


@pytest.mark.parametrize(("n", "ports"), COLUMNS)
def test_ranges_of_a_column_are_as_long_as_its_arrays(n: int, ports: int) -> None:
    loads, spots = 2 * len(plane.LOAD) * ports, plane.SPOTS.size(ports)
    found = lengths(state_ranges.of_column(n, spots, loads))
    state = plane.STATE.size(n) + spots
    assert found == [state, plane.COUNTS.beside, plane.BASE.beside + loads]


@pytest.mark.parametrize("sizes", [SIZES, space.sizes_of(1, 1, 0, 0, 4)])
def test_ranges_of_a_structure_are_as_long_as_its_arrays(sizes: space.Sizes) -> None:
    found = lengths(state_ranges.of_structure(sizes))
    assert found == [space.STATE.size(sizes), space.COUNTS.beside, space.INPUT_MOTION.size(sizes)]


def structure_state() -> tuple[np.ndarray, Any]:
    """Return a state of zeros with polygons of four corners, and its names."""
    numbers = np.zeros(space.STATE.size(SIZES))
    seen = space.STATE.see(numbers, SIZES)
    seen.phase.q0[:] = 1.0
    seen.bonded[:: len(seen.bonded) // SIZES.bonds] = 4.0
    return numbers, seen


WRONG = [-1.0, 2.5, space.MOST_BONDED + 1.0, 5000.0, 1e6, np.nan, np.inf, -np.inf]


@pytest.mark.parametrize("wrong", WRONG)
def test_a_bond_with_another_number_of_corners_is_refused(wrong: float) -> None:
    ranges = state_ranges.of_structure(SIZES)
    numbers, seen = structure_state()
    ranges.check("state", numbers, True)
    each = len(seen.bonded) // SIZES.bonds
    for bond in range(SIZES.bonds):
        seen.bonded[bond * each] = wrong
        with pytest.raises(ValueError, match="out of its range"):
            ranges.check("state", numbers, True)
        seen.bonded[bond * each] = space.MOST_BONDED
        ranges.check("state", numbers, True)


def test_no_number_of_a_state_may_be_infinite_but_those_that_say_so() -> None:
    ranges = state_ranges.of_structure(SIZES)
    numbers, _ = structure_state()
    for k in range(len(numbers)):
        for wrong in (np.nan, np.inf):
            with pytest.raises(ValueError, match=rf"state\[{k}\] = {wrong}"):
                ranges.check("state", np.where(np.arange(len(numbers)) == k, wrong, numbers), True)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("fallen", 5), ("started", 2), ("steps", -1), ("resting", 2), ("elastic_wait", -(2**62)), ("looks", 2**62)],
)
def test_counts_are_held_to_what_they_count(name: str, wrong: int) -> None:
    ranges = state_ranges.of_structure(SIZES)
    counts = np.zeros(space.COUNTS.beside, dtype=np.int64)
    space.COUNTS.see(counts).fallen = 4
    ranges.check("counts", counts, True)
    setattr(space.COUNTS.see(counts), name, wrong)
    with pytest.raises(ValueError, match="out of its range"):
        ranges.check("counts", counts, True)


@pytest.mark.parametrize(
    ("name", "wrong"),
    [("theta_x", 7.0), ("theta_y", np.nan), ("t0", np.inf), ("steps", 3.0), ("steps", 1.5), ("amplitude_x", 1.0)],
)
def test_the_turning_base_is_held_to_its_ranges(name: str, wrong: float) -> None:
    ranges = state_ranges.of_structure(SIZES)
    base = np.zeros(space.INPUT_MOTION.size(SIZES))
    ranges.check("base", base, False)
    setattr(space.BASE.see(base), name, wrong)
    with pytest.raises(ValueError, match="out of its range"):
        ranges.check("base", base, False)


def test_inputs_may_be_wrong_until_a_step_is_made_with_them() -> None:
    ranges = state_ranges.of_column(2, 0, 0)
    base = np.zeros(plane.BASE.beside)
    plane.BASE.see(base).ax = np.nan
    ranges.check("base", base, False)
    with pytest.raises(ValueError, match=r"base\[1\] = nan"):
        ranges.check("base", base, True)


def test_the_acceleration_of_a_base_that_bodies_drive_is_never_wrong() -> None:
    ranges = state_ranges.of_column(2, 0, 0, bodies_drive=True)
    base = np.zeros(plane.BASE.beside)
    ranges.check("base", base, False)
    plane.BASE.see(base).az = np.inf
    with pytest.raises(ValueError, match="= inf"):
        ranges.check("base", base, False)


def test_what_is_said_by_nan_and_infinity_is_no_fault() -> None:
    """Check a column at rest whose parameters have just been changed."""
    ranges = state_ranges.of_column(2, 0, 0)
    base, state = np.zeros(plane.BASE.beside), np.zeros(plane.STATE.size(2))
    names, control = plane.BASE.see(base), plane.STATE.see(state, 2).control
    names.anchor, names.piece_end, names.segment, control.base_ax = -np.inf, np.inf, -1.0, np.nan
    ranges.check("base", base, True)
    ranges.check("state", state, True)


def headers(body: ColumnBody | StructureBody) -> str:
    subject = structure_subject(body) if isinstance(body, StructureBody) else column_subject(body)
    return table.declarations(table.Contents(subject, body.table(reads_files=False), "0", "", None))


def test_a_native_fmu_has_the_same_ranges() -> None:
    body = read_body(ROOT / "examples" / "columns" / "phocas-damped.toml")
    assert isinstance(body, ColumnBody)
    text = headers(body)
    for name, runs in body.state_ranges()._asdict().items():
        (rows,) = (part.partition("};")[0] for part in text.split(f"Range {name}_ranges[] = {{\n")[1:])
        found = [row.strip().strip("{},").split(", ") for row in rows.splitlines()]
        assert [int(row[0]) for row in found] == [run.length for run in runs]
        for row, (_, own) in zip(found, runs, strict=True):
            low, high = (float.fromhex(word) if "x" in word else float(word.lower()) for word in row[1:3])
            assert (low, high, *map(bool, map(int, row[3:]))) == tuple(own)
