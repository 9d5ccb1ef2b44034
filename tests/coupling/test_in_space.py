"""A structure in space on a slab with isolators in two directions."""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest
from support.fmus import ROOT

sys.path.insert(0, str(ROOT / "examples" / "coupling"))

import in_space

from solver.models.structure.driven import packed
from solver.models.structure.model import Structure


def test_the_line_is_of_the_second_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Errors fall by four with half the step, and under a slab of a tenth of the mass 4 ms are too long."""
    monkeypatch.setattr(in_space, "DURATION", 1.0)
    structure = Structure.from_toml(in_space.TRILITH)
    model, mass = packed(structure), sum(block.mass for block in structure.blocks)
    found = {h: in_space.couple(structure, model, mass, in_space.LINEAR, h, 2)[0] for h in (2e-3, 1e-3, 5e-4, 2.5e-4)}
    steps = [np.max(np.abs(found[2 * h] - found[h])) for h in (1e-3, 5e-4, 2.5e-4)]
    assert np.max(np.abs(found[2.5e-4])) > 1e-2  # m
    assert steps[0] / steps[1] == pytest.approx(4.0, rel=0.3)
    assert steps[1] / steps[2] == pytest.approx(4.0, rel=0.3)
    with pytest.warns(RuntimeWarning, match="base.a[xy] changes its sign at every step and grows"):
        too_long = in_space.couple(structure, model, 0.1 * mass, in_space.LINEAR, 4e-3, 2)[1]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        fine = in_space.couple(structure, model, 0.1 * mass, in_space.LINEAR, 5e-4, 2)[1]
    assert np.max(np.abs(too_long - fine)) > np.max(np.abs(fine))
