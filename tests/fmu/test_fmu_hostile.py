"""Calls that no master should make to an FMU: the answer is an Error with a reason, and the instance lives on."""

from __future__ import annotations

import zipfile
from pathlib import Path
from xml.etree import ElementTree

import pytest
from support.child import call
from support.fmus import LINUX, REFUSED, Fmus
from support.inside import hostile

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

AS_BUILT = 1e-5  # solver.tolerance


def all_refused(heard: dict[str, tuple[int, list[str]]]) -> None:
    assert len(heard) > 30
    for name, (status, said) in heard.items():
        assert status == 3, name
        assert len(said) == 1, name
        assert "NULL" in said[0] or "not one of this FMU" in said[0], name


def test_pointers_to_nothing_are_an_error(native: Path, native3: Path) -> None:
    heard, same = call(hostile.nulls, native)
    all_refused(heard)
    assert same
    assert not call(hostile.made_without_callbacks, native)
    heard, same = call(hostile.nulls3, native3)
    all_refused(heard)
    assert same


@pytest.mark.skipif(REFUSED == "fatal", reason="needs the guard, which ziglang compiles on Linux")
def test_the_guard_refuses_pointers_to_nothing(fmus: Fmus) -> None:
    heard, same = call(hostile.nulls, fmus.damped)
    all_refused(heard)
    assert same


def test_bytes_that_are_no_state_are_refused(fmus: Fmus) -> None:
    heard, same = call(hostile.impossible_states, fmus.damped)
    assert [answer for answer in heard if REFUSED not in answer] == []
    assert same


@pytest.mark.skipif(REFUSED == "fatal", reason="needs the guard, which ziglang compiles on Linux")
def test_a_state_from_damaged_bytes_has_no_bytes(fmus: Fmus) -> None:
    heard, same = call(hostile.damaged_states, fmus.damped)
    assert len(heard) == 7
    assert [answer for answer in heard if "error" not in answer] == []
    assert same


def test_native_states_with_changed_numbers_end_no_process(native: Path) -> None:
    refused, taken, same = call(hostile.unlikely_states, native, 400)
    assert refused > 100  # what no instance can be in; the rest is another state
    assert taken > 10
    assert same


def stops(heard: list[object]) -> None:
    """Check steps to the stop time, within rounding, and not beyond; anywhere after a reset; no stop before
    the start.
    """
    wrong, begun, rounded, late, moved, free, *backwards = heard
    assert begun == rounded == free == "ok"
    assert moved is True
    for answer in (wrong, late, *backwards):
        assert REFUSED in str(answer) or "error" in str(answer)


def test_steps_beyond_the_stop_time_are_an_error(fmus: Fmus) -> None:
    stops(call(hostile.beyond, fmus.damped))


def test_native_steps_beyond_the_stop_time_are_an_error(native: Path, native3: Path) -> None:
    stops(call(hostile.beyond, native))
    plain, followed = (call(hostile.beyond3, native3)[k : k + 4] for k in (0, 4))
    for heard in (plain, followed):
        assert "rror" in heard[0]
        assert "rror" in heard[3]
        assert heard[1] == 0  # the importer was asked for nothing
        assert heard[2] == "ok"


def honoured(fmu: Path) -> None:
    """Check that the master's tolerance counts unless the parameter is set, before or after, and in a state."""
    assert call(hostile.tolerances, fmu) == [AS_BUILT, 1e-8, 1e-7, AS_BUILT, 1e-6]
    pairs = [(None, None), (None, 1e-9), (1e-9, None), (1e-3, 1e-9)]  # of the experiment and of the parameter
    usual, fine, *others = call(hostile.with_tolerances, fmu, pairs)
    assert fine != usual
    assert others == [fine, fine]
    with zipfile.ZipFile(fmu) as archive:
        root = ElementTree.fromstring(archive.read("modelDescription.xml"))
    (experiment,) = root.iter("DefaultExperiment")
    assert {key: float(text) for key, text in experiment.items()} == {
        "startTime": 0.0,
        "stopTime": 20.0,
        "tolerance": AS_BUILT,
        "stepSize": 1e-3,
    }


def test_the_tolerance_of_the_master_is_honoured(fmus: Fmus) -> None:
    honoured(fmus.damped)


def test_the_native_fmu_honours_the_tolerance_of_the_master(native: Path) -> None:
    honoured(native)


def test_a_column_of_a_thousand_blocks_needs_little_stack(tmp_path: Path) -> None:
    """Check 256 kB, as docs/native.md says, of which the thread of Python takes a part."""
    column = tmp_path / "stack.toml"
    block = "[[block]]\nheight = 0.1\nwidth = 2.0\ndepth = 2.0\ndensity = 2000.0\n"
    column.write_text('name = "stack"\n' + block * 1000 + "[joint]\nstiffness = 1e11\ndamping = 1e-3\n")
    fmu = Fmus.build(column, tmp_path / "stack.fmu", *LINUX)
    ux, force = call(hostile.in_a_thread, fmu, 256 * 1024)
    assert ux != 0.0
    assert force != 0.0
