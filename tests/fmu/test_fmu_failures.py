"""Mistakes of a master: one logged sentence, a status that says so, and an instance that lives on."""

from __future__ import annotations

import math
import re
import shutil

import pytest
from support.child import call, command, ended, returned
from support.fmus import REFUSED, Fmus, finish
from support.inside import failures

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time


@pytest.mark.parametrize("logging", [True, False])
def test_a_wrong_call_is_answered_and_the_instance_lives_on(fmus: Fmus, logging: bool) -> None:
    done = ended(failures.python_answers, fmus.damped, logging)
    assert done.returncode == 0, done.stderr
    answers = returned(done.stdout)
    printed, lines = done.stdout.split("==\n")[:-1], done.stderr.split("==\n")[:-1]
    for (_, _, reason), (heard, lives), entry, line in zip(failures.PYTHON, answers, printed, lines, strict=True):
        assert f"({REFUSED})" in heard, reason
        assert lives, reason
        assert reason in line
        assert line.count("\n") == 1
        if logging or REFUSED == "error":  # without its guard PythonFMU's library is silent
            assert reason in entry
        if REFUSED == "error":
            assert len(re.findall(r"\[(?:ERROR|FATAL)\]|Fatal", entry)) == 1, entry


def test_what_cannot_be_stepped_over_leaves_the_column_as_it_was(fmus: Fmus) -> None:
    heard, after, plain = call(failures.bad_inputs_and_parameters, fmus.damped)
    assert len(heard) == 7
    assert all("discard" in answer for answer in heard)
    assert after == pytest.approx(plain, rel=1e-12, abs=0.0)


def test_outputs_under_an_input_that_is_no_number_are_distinguished(fmus: Fmus) -> None:
    before, now, reaction = call(failures.outputs_without_an_input, fmus.damped)
    assert now == before
    assert math.isnan(reaction)


def test_outputs_of_initialization_follow_the_parameters(fmus: Fmus) -> None:
    mass = 3 * 27000.0
    weight, lighter, pushed = call(failures.outputs_of_initialization, fmus.damped)
    assert weight == pytest.approx(9.80665 * mass, rel=1e-12)
    assert lighter == pytest.approx(5.0 * mass, rel=1e-12)
    assert pushed == pytest.approx(-5.0 * mass, rel=1e-3)  # the joint is still compressed by the weight alone


def test_on_a_system_that_it_has_no_code_for_the_fmu_says_so(fmus: Fmus) -> None:
    pytest.importorskip("ziglang", reason="without it the FMU carries object code")
    done = ended(failures.on_another_system, fmus.damped)
    assert done.returncode == 1
    first = done.stderr.splitlines()[0]
    needs = r"phocas_damped: needs Python 3\.11 or newer with numpy: there is no machine code of \w+ for \w+ on \w+$"
    assert re.match(needs, first), first
    assert "Failed to instantiate" in done.stderr


@pytest.mark.skipif(not shutil.which("valgrind"), reason="valgrind is not installed")
def test_a_process_without_an_instance_frees_the_wrapper_once(fmus: Fmus) -> None:
    """Check that a second time would write into memory of others: the process mostly ends well, and now and then by a
    signal.
    """
    watched = command(failures.on_another_system, fmus.damped)
    done = finish("valgrind", "--error-limit=no", *watched, PYTHONMALLOC="malloc")
    assert done.returncode == 1
    assert "Failed to instantiate" in done.stderr
    assert "ERROR SUMMARY" in done.stderr
    assert "finalizePythonInterpreter" not in done.stderr


def test_tunable_parameters_act_from_the_next_step_on(fmus: Fmus) -> None:
    """Check that a joint damped ten times as much dissipates more; the very change is that of an instance built with
    it.
    """
    dampings = [(1e-3, 1e-3), (1e-3, 1e-2), (1e-2, 1e-3)]
    little, then_much, then_little = call(failures.rings, fmus.damped, dampings)
    assert then_much < 0.5 * little
    assert then_little > 2.0 * then_much
