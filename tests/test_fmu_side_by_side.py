"""Several FMUs in one process, taking turns and in threads: each gives exactly what it gives alone."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from fmus import ROOT, Fmus, run
from pythonfmu import FmuBuilder

PRELUDE = """
import json, sys, threading, time
from math import sin
from instance import Instance

def steps(column, first=0, last=200):
    for k in range(first, last):
        column.set({"base.ax": 1.2 * sin(0.12 * k)})
        column.step(0.01 * k, 0.01)
    return column.get()

def in_threads(*calls):
    results = [None] * len(calls)
    def work(k):
        results[k] = calls[k]()
    threads = [threading.Thread(target=work, args=(k,)) for k in range(len(calls))]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return results
"""

FOREIGN = """
from pythonfmu import Fmi2Causality, Fmi2Slave, Real
import solver

class Foreign(Fmi2Slave):
    def __init__(self, **kwargs):
        super().__init__(**kwargs)
        self.y = solver.answer()
        self.register_variable(Real("y", causality=Fmi2Causality.output))

    def do_step(self, current_time, step_size):
        self.y = solver.answer() + current_time
        return True
"""


@pytest.fixture
def foreign(tmp_path: Path) -> Path:
    """An FMU of somebody else's, with a module called solver."""
    (tmp_path / "foreign.py").write_text(FOREIGN)
    (tmp_path / "solver.py").write_text("def answer():\n    return 42.0\n")
    script = (
        "import sys\nfrom pythonfmu import FmuBuilder\n"
        "folder = sys.argv[1]\nsys.path.insert(0, folder)\n"
        "FmuBuilder.build_FMU(folder + '/foreign.py', dest=folder, project_files=[folder + '/solver.py'])"
    )
    assert FmuBuilder.has_binary()
    run(sys.executable, "-c", script, tmp_path)
    return tmp_path / "Foreign.fmu"


def test_taking_turns_and_in_threads(fmus: Fmus, tmp_path: Path) -> None:
    text = (ROOT / "examples/columns/phocas-damped.toml").read_text()
    (tmp_path / "other.toml").write_text(text.replace("27000.0", "20000.0"))  # the same name, another column
    other = fmus.build(tmp_path / "other.toml", tmp_path / "other.fmu")
    script = PRELUDE + (
        "fmus = sys.argv[1:]\n"
        "alone = [steps(Instance(fmu)) for fmu in fmus]\n"
        "columns = [Instance(fmu) for fmu in fmus]\n"
        "for k in range(199):\n"
        "    for column in columns:\n"
        "        steps(column, k, k + 1)\n"
        "print([steps(column, 199, 200) for column in columns] == alone)\n"
        "for _ in range(5):\n"
        "    columns = [Instance(fmu) for fmu in fmus]\n"
        "    print(in_threads(*[lambda column=column: steps(column) for column in columns]) == alone)\n"
        "print(alone[0] == alone[3], alone[0] != alone[1])\n"
    )
    printed = run(sys.executable, "-c", script, fmus.damped, other, fmus.phocas, fmus.damped)
    assert printed.split() == ["True"] * 8


@pytest.mark.parametrize("first", ["ours", "theirs"])
def test_beside_a_foreign_fmu_with_a_module_called_solver(fmus: Fmus, foreign: Path, first: str) -> None:
    script = PRELUDE + (
        "make = {'ours': lambda: Instance(sys.argv[1]), 'theirs': lambda: Instance(sys.argv[2])}\n"
        "order = ['ours', 'theirs'] if sys.argv[3] == 'ours' else ['theirs', 'ours']\n"
        "made = {name: make[name]() for name in order}\n"
        "column = steps(made['ours'])\n"
        "made['theirs'].step(0.0, 1.0)\n"
        "made['theirs'].step(1.0, 1.0)\n"
        "print(json.dumps([column, made['theirs'].get('y')]))"
    )
    column, y = json.loads(run(sys.executable, "-c", script, fmus.damped, foreign, first))
    alone = PRELUDE + "print(json.dumps(steps(Instance(sys.argv[1]))))"
    assert column == json.loads(run(sys.executable, "-c", alone, fmus.damped))
    assert y == [43.0]


def test_a_long_step_leaves_the_interpreter_to_others(fmus: Fmus) -> None:
    script = PRELUDE + (
        "slow = Instance(sys.argv[1], {'base.ax': 0.5, 'base.jx': -1e-3, 'solver.tolerance': 1e-12})\n"
        "quick = Instance(sys.argv[1], {'base.ax': 0.5})\n"
        "done = threading.Event()\n"
        "thread = threading.Thread(target=lambda: (slow.step(0.0, 300.0), done.set()))\n"
        "thread.start()\n"
        "made = 0\n"
        "while not done.is_set():\n"
        "    quick.step(0.01 * made, 0.01)\n"
        "    made += 1\n"
        "thread.join()\n"
        "print(made)"
    )
    # with the interpreter lock held there would be one or two; measured 1e5
    assert int(run(sys.executable, "-c", script, fmus.damped)) > 100


def test_instances_leave_little_behind(fmus: Fmus) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("no /proc to read the size of a process from")
    script = (
        "from fmpy import extract\nimport gc, sys\nfrom instance import Instance\n"
        "folder = extract(sys.argv[1])\n"
        "def resident():\n"
        "    gc.collect()\n"
        "    return int(open('/proc/self/statm').read().split()[1]) * 4096\n"
        "def live():\n"
        "    column = Instance(sys.argv[1], {'base.ax': 0.5}, folder=folder)\n"
        "    column.step(0.0, 0.1)\n"
        "    column.get()\n"
        "    column.close()\n"
        "for _ in range(20): live()\n"
        "before, entries = resident(), len(sys.path)\n"
        "for _ in range(300): live()\n"
        "print(resident() - before, len(sys.path) - entries)"
    )
    grown, entries = (int(word) for word in run(sys.executable, "-c", script, fmus.damped).split())
    assert grown < 6e6  # 20 kB an instance; measured 8 kB, nearly all of it the wrapper's own
    assert entries == 0
