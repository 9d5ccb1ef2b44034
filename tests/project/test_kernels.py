"""Properties that the kernels promise as compiled code."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

import numpy as np
import pytest
from support.groups import OF_LONG_TESTS

from solver.kernels.layout import spaces as at
from solver.kernels.machine.entry import entries_of
from solver.kernels.machine.groups import GROUPS
from solver.kernels.machine.making import kept_code, made
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import FieldTable, row_of

_phase = at.PHASE.over
OWN = [group for group, of in GROUPS.items() if not of.beside]  # examples that are imported add theirs


@pytest.mark.parametrize(
    "group", [pytest.param(group, marks=[pytest.mark.long] * (group in OF_LONG_TESTS)) for group in OWN]
)
def test_machine_code_calls_nothing_of_numbas_runtime(group: str) -> None:
    import_module(f"solver.kernels.{GROUPS[group].module}")
    names = [entry.__name__.encode() for entry in entries_of(group)]
    code = kept_code(group) or made([group])[0]
    assert names
    assert all(name in code for name in names)  # so that others would be found
    assert not re.search(rb"NRT_|numba_|Py[A-Z]\w*_", code)


@from_python
def write_together(n: int, array: Any) -> None:
    """Write rows of a phase that cover several fields."""
    phase = _phase(row_of(array), n)
    for i in range(2 * n):
        phase.coordinates[i] = 100.0 + i
        phase.rates[i] = 200.0 + i
        phase.accelerations[i] = 300.0 + i
    for i in range(6 * n):
        phase.slips[i] = 400.0 + i


def test_fields_together_are_the_same_numbers_in_kernels_and_in_python() -> None:
    n = 3
    array = np.zeros(at.PHASE.size(n))
    write_together(n, array)
    phase = at.PHASE.see(array, n)
    for first, name, fields in (
        (100.0, "coordinates", ("theta", "opening")),
        (200.0, "rates", ("theta_rate", "opening_rate")),
        (300.0, "accelerations", ("theta_acceleration", "opening_acceleration")),
        (400.0, "slips", at.PHASE.fields[at.RIGID_FIELDS : at.PHASE_FIELDS]),
    ):
        expected = first + np.arange(len(fields) * n)
        assert np.array_equal(getattr(phase, name), expected)
        assert np.array_equal(np.concatenate([getattr(phase, field) for field in fields]), expected)


def test_only_neighbours_can_be_together() -> None:
    with pytest.raises(AssertionError, match="not neighbours"):
        FieldTable("a", "b", "c", together={"ends": ("a", "c")})
