"""What the kernels promise of themselves as compiled code."""

from __future__ import annotations

import re
from typing import Any

import numpy as np
import pytest
from probe import phocas

from solver.kernels import entries
from solver.kernels import layout as at
from solver.kernels.jit import from_python
from solver.stepper import SILENCE, Stepper


@pytest.mark.parametrize("formulation", ["exact", "paper"])
def test_nothing_of_numbas_runtime_is_called(formulation: str) -> None:
    stepper = Stepper(phocas(formulation=formulation))
    run: Any = entries.run
    compiled = from_python(run.py_func)  # made here: the cached one keeps no listing
    assert compiled(3, *stepper.arrays, *SILENCE.arguments, 0.0, 1e-3, np.zeros(0), np.zeros(0), True) == at.OK
    (signature,) = compiled.signatures
    listing = compiled.inspect_llvm(signature)
    bodies = dict(re.findall(r"define [^\n]*@(_ZN[^(]*)\((.*?)\n}", listing, re.DOTALL))
    native = {name: body for name, body in bodies.items() if "cpython" not in name and "cfunc" not in name}
    assert any("run" in name for name in native)
    for name, body in native.items():
        assert "NRT_" not in body, name
