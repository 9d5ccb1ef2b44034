"""A slab of 0.09 of the mass of what stands on it, pushed at its port by a partner once a step, all in parallel."""

from __future__ import annotations

import sys
import warnings

import numpy as np
import pytest
from support.fmus import ROOT

from solver.common.errors import InputWarning

sys.path.insert(0, str(ROOT / "examples" / "coupling"))

import light_slab


def test_it_is_stable_at_10_ms_and_of_the_second_order() -> None:
    """Compare in two directions with the isolators as ties inside: parts of the largest displacement of slab
    and beam.
    """
    errors = {}
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # its rollers are an unusual joint
        one = light_slab.as_one(2.0)
        for h in (10e-3, 5e-3, 2e-3, 1e-3):
            pairs = zip(light_slab.couple(h, 2.0), one, strict=True)
            errors[h] = np.array([np.max(np.abs(a - b)) / np.max(np.abs(b)) for a, b in pairs])
    assert np.max(np.abs(one[1])) > 0.05  # m
    assert np.all(errors[10e-3] < 5e-3)  # measured 1.5e-3 over 4 s
    assert np.all(errors[2e-3] < 1e-4)  # measured 5e-5
    assert errors[10e-3] / errors[5e-3] == pytest.approx(4.0, rel=0.35)
    assert errors[2e-3] / errors[1e-3] == pytest.approx(4.0, rel=0.35)
