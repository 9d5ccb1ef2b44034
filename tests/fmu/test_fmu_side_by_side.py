"""Several FMUs in one process, taking turns and in threads: each gives exactly what it gives alone."""

from __future__ import annotations

from pathlib import Path

import pytest
from pythonfmu import FmuBuilder
from support.child import call
from support.fmus import ROOT, Fmus
from support.inside import neighbours

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time

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
    """Return an FMU of another tool, with a module called solver."""
    (tmp_path / "foreign.py").write_text(FOREIGN)
    (tmp_path / "solver.py").write_text("def answer():\n    return 42.0\n")
    assert FmuBuilder.has_binary()
    call(neighbours.build_foreign, tmp_path)
    return tmp_path / "Foreign.fmu"


def test_taking_turns_and_in_threads(fmus: Fmus, tmp_path: Path) -> None:
    text = (ROOT / "examples/columns/phocas-damped.toml").read_text()
    (tmp_path / "other.toml").write_text(text.replace("27000.0", "20000.0"))  # the same name, another column
    other = fmus.build(tmp_path / "other.toml", tmp_path / "other.fmu")
    found = call(neighbours.together, [fmus.damped, other, fmus.phocas, fmus.damped])
    alone = found["alone"]
    assert alone[0] == alone[3]
    assert alone[0] != alone[1]
    assert found["in turns"]
    assert found["in threads"] == [True] * 5


@pytest.mark.parametrize("first", ["ours", "theirs"])
def test_beside_a_foreign_fmu_with_a_module_called_solver(fmus: Fmus, foreign: Path, first: str) -> None:
    column, y = call(neighbours.beside, fmus.damped, foreign, first == "ours")
    assert column == call(neighbours.alone, fmus.damped)
    assert y == [43.0]


def test_a_long_step_leaves_the_interpreter_to_others(fmus: Fmus) -> None:
    # with the interpreter lock held there would be one or two; measured 1e5
    assert call(neighbours.steps_during_a_long_one, fmus.damped) > 100


def test_instances_leave_little_behind(fmus: Fmus) -> None:
    if not Path("/proc/self/statm").exists():
        pytest.skip("no /proc to read the size of a process from")
    grown, entries = call(neighbours.left_behind, fmus.damped)
    assert grown < 6e6  # 20 kB an instance; measured 8 kB, nearly all of it the wrapper's own
    assert entries == 0
