"""What a master does wrong: one logged sentence, a status that says so, and an instance that lives on."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest
from fmus import LIVES as PRELUDE
from fmus import REFUSED, Fmus, environment, finish, run

# how the instance was made, the call, the status, what is said
WRONG_CALLS = [
    ("fresh()", "'get', 'block[1].ux'", REFUSED, "outputs can be read from initialization on"),
    ("fresh()", "'step', 0.0, 0.1", REFUSED, "the slave is not initialized"),
    ("fresh()", "'setupExperiment', None, nan", REFUSED, "start time = nan: must be a finite time"),
    ("fresh()", "'getReal', [4294967295]", REFUSED, "is not that of a Real variable"),
    ("fresh()", "'getReal', [column.variables['base.record'].valueReference]", REFUSED, "not that of a Real"),
    ("fresh()", "'setReal', [100000], [1.0]", REFUSED, "value reference 100000: is not an input or a parameter"),
    ("fresh()", "'set', {'block[1].ux': 1.0}", REFUSED, "is not an input or a parameter"),
    ("started()", "'exitInitializationMode'", REFUSED, "the slave is in the state stepping"),
    ("started()", "'setupExperiment'", REFUSED, "the slave is in the state stepping"),
    ("started()", "'set', {'block[1].mass': 1.0}", REFUSED, "block[1].mass: can be set before the end"),
    ("started()", "'step', 0.1, 0.0", REFUSED, "the step must be a positive time"),
    ("started()", "'step', 0.1, -0.1", REFUSED, "the step must be a positive time"),
    ("started()", "'step', 0.1, inf", REFUSED, "the step must be a positive time"),
    ("started()", "'step', 0.05, 0.1", REFUSED, "the last step ended at t = 0.1 s"),
    ("started()", "'step', nan, 0.1", REFUSED, "the last step ended at t = 0.1 s"),
    ("ended()", "'step', 0.1, 0.1", REFUSED, "the run is terminated"),
    ("ended()", "'set', {'base.ax': 1.0}", REFUSED, "nothing can be set, the run is terminated"),
    ("ended()", "'exitInitializationMode'", REFUSED, "the slave is in the state terminated"),
]

SCALE_WITHOUT_A_RECORD = """
column = fresh()
column.set({"base.record_scale": nan})
print(sys.argv[2] in column.attempt("initialize"), usual(column) == usual(column))
column.close()
"""

WRONG = """
for made, call in json.loads(sys.argv[2]):
    column = eval(made)
    heard = column.attempt(*eval(f"({call},)"))
    lives = usual(column) == usual(column)
    column.close()
    print(f"== {heard} {lives}", flush=True)
    print("==", file=sys.stderr, flush=True)
"""


@pytest.mark.parametrize("logging", [False, True])
def test_a_wrong_call_is_answered_and_the_instance_lives_on(fmus: Fmus, logging: bool) -> None:
    script = (PRELUDE + WRONG).replace("Instance(sys.argv[1], ", f"Instance(sys.argv[1], loggingOn={logging}, values=")
    script = script.replace("values=initialize", "initialize")
    calls = json.dumps([(made, call) for made, call, _, _ in WRONG_CALLS])
    done = finish(sys.executable, "-c", script, fmus.damped, calls)
    assert done.returncode == 0, done.stderr
    answers, lines = done.stdout.split("== ")[1:], done.stderr.split("==\n")[:-1]
    logged = done.stdout.split("== ")[:-1]
    for (_, call, status, said), answer, line, entry in zip(WRONG_CALLS, answers, lines, logged, strict=True):
        assert f"({status})" in answer.splitlines()[0], call
        assert answer.splitlines()[0].endswith("True"), call
        assert said in line
        assert line.count("\n") == 1
        if logging:
            assert said in entry


def test_a_scale_that_is_no_number_is_refused_without_a_record_too(fmus: Fmus) -> None:
    done = finish(sys.executable, "-c", PRELUDE + SCALE_WITHOUT_A_RECORD, fmus.damped, REFUSED)
    assert done.stdout.split() == ["True", "True"]
    assert "base.record_scale = nan: must be a finite number" in done.stderr


def test_what_cannot_be_stepped_over_leaves_the_column_as_it_was(fmus: Fmus) -> None:
    script = PRELUDE + (
        "column = started()\n"
        "before = column.fmi.serializeFMUstate(column.fmi.getFMUState())\n"
        "for name, bad, good in (('base.ax', nan, 0.5), ('base.jz', inf, 0.0), ('base.ax', 1e300, 0.5),\n"
        "                        ('joint[1].damping', -1.0, 1e-3), ('g', nan, 9.80665)):\n"
        "    column.set({name: bad})\n"
        "    print('discard' in column.attempt('step', 0.1, 0.1))\n"
        "    column.set({name: good})\n"
        "column.step(0.1, 0.1)\n"
        "after = column.get()\n"
        "plain = started()\nplain.step(0.1, 0.1)\n"
        "print(all(abs(a - b) <= 1e-12 * abs(b) for a, b in zip(after, plain.get())))\n"
    )
    assert run(sys.executable, "-c", script, fmus.damped).split() == ["True"] * 6


def test_outputs_under_an_input_that_is_no_number_are_told_apart(fmus: Fmus) -> None:
    script = PRELUDE + (
        "column = started()\n"
        "known = column.get('block[1].ux', 'joint[1].N')\n"
        "column.set({'base.ax': nan})\n"
        "print(column.get('block[1].ux', 'joint[1].N') == known, column.get('base.Fx')[0] != column.get('base.Fx')[0])"
    )
    assert run(sys.executable, "-c", script, fmus.damped).split() == ["True", "True"]


def test_outputs_of_initialization_follow_the_parameters(fmus: Fmus) -> None:
    script = PRELUDE + (
        "column = fresh()\ncolumn.fmi.setupExperiment()\ncolumn.fmi.enterInitializationMode()\n"
        "heard = [column.get('joint[3].N')[0]]\n"
        "column.set({'g': 5.0})\nheard += column.get('joint[3].N')\n"
        "column.set({'base.az': 1.0})\nheard += column.get('base.Fz')\n"
        "print(json.dumps(heard))"
    )
    mass = 3 * 27000.0
    weight, lighter, pushed = json.loads(run(sys.executable, "-c", script, fmus.damped))
    assert weight == pytest.approx(9.80665 * mass, rel=1e-12)
    assert lighter == pytest.approx(5.0 * mass, rel=1e-12)
    assert pushed == pytest.approx(-5.0 * mass, rel=1e-3)  # the joint is still compressed by the weight alone


def test_without_numba_the_fmu_says_what_it_needs(fmus: Fmus) -> None:
    script = "import sys\nfrom instance import Instance\nsys.modules['numba'] = None\nInstance(sys.argv[1])"
    done = subprocess.run(
        [sys.executable, "-c", script, str(fmus.damped)], capture_output=True, text=True, env=environment(), check=False
    )
    assert done.returncode == 1
    assert done.stderr.startswith("phocas_damped: needs Python 3.11 or newer with numpy and numba: import of numba")
    assert "Failed to instantiate" in done.stderr


def test_tunable_parameters_act_from_the_next_step_on(fmus: Fmus, tmp_path: Path) -> None:
    """A joint damped ten times as much dissipates more; the very change is that of an instance built with it."""
    script = PRELUDE + (
        "def ring(damping, later):\n"
        "    column = Instance(sys.argv[1], {f'joint[{i}].damping': damping for i in (1, 2, 3)})\n"
        "    column.set({'base.ax': 0.5})\n    column.step(0.0, 0.3)\n    column.set({'base.ax': 0.0})\n"
        "    column.set({f'joint[{i}].damping': later for i in (1, 2, 3)})\n"
        "    seen = []\n"
        "    for k in range(200):\n"
        "        column.step(0.3 + 0.01 * k, 0.01)\n"
        "        seen += column.get('block[1].ux')\n"
        "    return max(map(abs, seen[-50:]))\n"
        "print(json.dumps([ring(1e-3, 1e-3), ring(1e-3, 1e-2), ring(1e-2, 1e-3)]))"
    )
    little, then_much, then_little = json.loads(run(sys.executable, "-c", script, fmus.damped))
    assert then_much < 0.5 * little
    assert then_little > 2.0 * then_much
