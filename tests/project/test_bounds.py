"""The build of the kernels that checks the bounds of every row (numba_ext/bounds.py)."""

from __future__ import annotations

import signal
import sys

import pytest
from numba import types
from numba.core.datamodel import default_manager
from support.child import command, returned
from support.fmus import DAMPED, ROOT, finish
from support.inside import planted

sys.path.insert(0, str(ROOT))  # the campaign is not installed

from solver.kernels.numba_ext.lane_types import LANES
from solver.kernels.numba_ext.rows import RowType
from stress import bounds, scenes
from stress.determinism import elsewhere

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="the line is printed by a function of POSIX")

COMPILING = {"MULTIBLOCK_COMPILES": "1", "MULTIBLOCK_BOUNDS": "1"}
WITHIN = [
    ("read", 3, 0), ("read", 3, 2), ("write", 3, 6), ("read_from", 32, 7), ("read_between", 32, 7),
    ("read_lanes", 4, 7), ("write_lanes", 4, 0), ("add_packs", 3, 0), ("copy_some", 30, 10), ("copy_some", 30, -1),
    ("clear_some", 3, 12), ("crack_front", 0, 0), ("crack_front", 20, 0),
]  # fmt: skip
# call, and what the line says behind the kernel's name
BEYOND = [
    (("read", 3, 3), "element 3 of 3"),  # the first number of the next part
    (("read", 3, -1), "element -1 of 3"),  # one of the part before
    (("read", 10, 0), "names over 43 of 40"),
    (("write", 3, 7), "element 7 of 7"),
    (("read_from", 40, 0), "element 0 of 0"),
    (("read_from", 41, 0), "beginning of a part 41 of 40"),
    (("read_from", -1, 1), "beginning of a part -1 of 40"),
    (("read_between", 8, 8), "element 8 of 8"),
    (("read_between", 33, 0), "end of a part 41 of 40"),
    (("read_lanes", 5, 0), "element 5 of 5"),
    (("read_lanes", 0, 8), "lane 8 of 8"),
    (("write_lanes", 5, 0), "element 5 of 5"),
    (("write_lanes", -1, 0), "element -1 of 5"),
    (("add_packs", 3, 1), "element 1 of 1"),
    (("copy_some", 30, 11), "copy to 11 of 10"),
    (("clear_some", 3, 13), "copy to 13 of 12"),
]


def in_checked_process(function: object, *arguments: object) -> object:
    done = finish(*command(function, *arguments), **COMPILING)  # type: ignore[arg-type]
    assert done.returncode == 0, done.stderr
    return returned(done.stdout)


@pytest.mark.long  # takes seconds
def test_every_access_beyond_a_row_is_said_and_ends_the_process() -> None:
    ends = in_checked_process(planted.ends, [*(call for call, _ in BEYOND), *WITHIN], WITHIN)
    assert isinstance(ends, list)
    for (call, said), (sign, printed) in zip(BEYOND, ends, strict=False):
        kernel = "_element" if call[0] == "read" and call[1] == 3 else call[0]
        start, _, rest = printed.partition(", line ")
        assert (sign, start) == (signal.SIGABRT, f"out of bounds: support.inside.planted.{kernel}"), (call, printed)
        assert rest.endswith(f": {said}\n"), (call, printed)
    assert ends[len(BEYOND) :] == [[0, ""]] * len(WITHIN)


@pytest.mark.long  # takes seconds
def test_checked_code_gives_the_same_bits() -> None:
    assert in_checked_process(planted.results, WITHIN) == planted.results(WITHIN)


def test_without_checks_a_row_is_an_address() -> None:
    for kind in (types.float64, types.int64, LANES):
        assert default_manager.lookup(RowType(kind)).get_value_type().is_pointer


@pytest.mark.long  # compiles kernels
def test_an_array_that_is_too_short_for_an_entry_is_said() -> None:
    done = finish(*command(planted.short_array), **COMPILING)
    assert done.returncode == -signal.SIGABRT
    first, last = done.stderr.strip().splitlines()
    assert first == "as long"
    assert last.startswith("out of bounds: solver.kernels.column.api.entries.rings_beyond, line ")
    assert last.endswith(": element 3 of 3")


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("kind", scenes.KINDS)
def test_the_scenes_of_the_campaign_give_the_same_bits_twice(kind: str) -> None:
    for number in range(5):
        assert scenes.digest(kind, 7, number) == scenes.digest(kind, 7, number)


@pytest.mark.campaign  # compiles kernels twice
def test_a_run_has_the_same_bits_with_checks() -> None:
    assert elsewhere("simulate", str(DAMPED), **bounds.CHECKED) == elsewhere("simulate", str(DAMPED))


@pytest.mark.campaign  # compiles all kernels
@pytest.mark.parametrize("kind", scenes.KINDS)
def test_short_campaign(kind: str) -> None:
    assert bounds.campaign(kind, 7, 0, 5)["failures"] == []
