"""Rotation of the base and the split of its reaction through the FMU."""

from __future__ import annotations

import numpy as np
import pytest
from support.child import call
from support.fmus import Fmus
from support.inside import base

pytestmark = pytest.mark.long  # test_fmu.py and test_structure_fmus.py have what is tried every time


def test_the_split_belongs_to_the_inputs_just_set(fmus: Fmus) -> None:
    accelerations = [(0.0, 0.0, 0.0), (3.0, -1.0, 20.0), (-2.0, 4.0, 0.0)]
    rows = np.array(call(base.reactions, fmus.damped, accelerations, 2e-3))
    weight = 81000.0 * 9.80665
    for row, a in zip(rows, accelerations, strict=False):
        xx, xz, xt, zz, zt, tt = row[6:]
        mass = np.array([[xx, xz, xt], [xz, zz, zt], [xt, zt, tt]])
        assert row[3:6] - mass @ a == pytest.approx(row[:3], abs=1e-13 * weight)
        assert row[3:] == pytest.approx(rows[0, 3:], rel=1e-12, abs=1e-12 * weight)
    assert abs(rows[1, 0] - rows[0, 0]) > 2e4  # 3 m/s2 on more than 8 t
    assert rows[3, 5] - rows[2, 5] < -1e5  # the base has been turned under the column


def test_the_state_keeps_the_rotation_of_the_base(fmus: Fmus) -> None:
    found = call(base.restored, fmus.damped)
    theta, moment = found["start"]
    assert theta == pytest.approx(4e-4)
    assert abs(moment) < 1e-6
    assert found["same"]
    assert found["moved"]
    assert "discard" in found["no number"].lower()
    assert found["end"] == "ok"


def test_the_paper_formulation_refuses_a_base_that_rotates(fmus: Fmus) -> None:
    refused, accepted = call(base.paper_that_rotates, fmus.phocas)
    assert "discard" in refused.lower()
    assert accepted == "ok"
