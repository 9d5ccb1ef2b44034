"""What the kernels promise of themselves as compiled code."""

from __future__ import annotations

import re

import numpy as np
import pytest
from probe import phocas

from solver.kernels import layout as at
from solver.kernels.advance import advance
from solver.stepper import Stepper


@pytest.mark.parametrize("formulation", ["exact", "paper"])
def test_nothing_of_numbas_runtime_is_called(formulation: str) -> None:
    stepper = Stepper(phocas(formulation=formulation))
    work = np.zeros(at.work_size(3))
    arrays = (stepper.model, stepper.state, stepper.counters, stepper.inputs, work)
    # called itself, not through its cached entry, it is compiled here
    assert advance(*arrays, 0.0, 1e-3, np.zeros(1), np.zeros((1, at.row_size(3)))) == at.OK
    (signature,) = advance.signatures
    native = re.search(r"define [^\n]*@_ZN(.*?)\n}", advance.inspect_llvm(signature), re.DOTALL)
    assert native is not None
    assert "advance" in native.group(1)[:200]
    assert "NRT_" not in native.group(1)
