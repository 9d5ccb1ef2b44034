"""What the kernels promise of themselves as compiled code."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba import typeof
from probe import phocas

from solver.kernels import entries
from solver.kernels.jit import as_written
from solver.stepper import SILENCE, Stepper

NOTHING = np.zeros(0)


@pytest.mark.parametrize(
    ("entry", "further"),
    [
        (entries.observe_state, (*SILENCE.arguments, 0.0, NOTHING, NOTHING)),
        pytest.param(entries.run, (*SILENCE.arguments, 0.0, 1e-3, NOTHING, NOTHING, True), marks=pytest.mark.long),
    ],
)
def test_nothing_of_numbas_runtime_is_called(entry: Any, further: tuple[Any, ...]) -> None:
    arguments = (3, *Stepper(phocas()).arrays, *further)
    module, name = as_written(entry.py_func, tuple(map(typeof, arguments)))
    assert not module.get_function(name).is_declaration
    assert "NRT_" not in str(module)
