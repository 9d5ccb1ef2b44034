"""Rotation of the base and the split of its reaction through the FMU."""

from __future__ import annotations

import json
import sys

import numpy as np
import pytest
from fmus import Fmus, run

SPLIT = [f"base.{name}" for name in ("R0x", "R0z", "R0m", "mxx", "mxz", "mxt", "mzz", "mzt", "mtt")]
REACTION = ["base.Fx", "base.Fz", "base.My"]

START = f"""
import json, math, sys
from instance import Instance
SPLIT, REACTION = {SPLIT!r}, {REACTION!r}

def follow(column, first, last, h=5e-3):
    for k in range(first, last):
        t = k * h
        column.set({{"base.ax": math.sin(12.0 * t), "base.theta": 1e-3 * math.sin(9.0 * t),
                    "base.omega": 9e-3 * math.cos(9.0 * t), "base.alpha": -81e-3 * math.sin(9.0 * t)}})
        column.step(t, h)
"""


def test_the_split_belongs_to_the_inputs_just_set(fmus: Fmus) -> None:
    script = START + (
        "column = Instance(sys.argv[1])\n"
        "follow(column, 0, 60)\n"
        "seen = []\n"
        "for ax, az, alpha in ((0.0, 0.0, 0.0), (3.0, -1.0, 20.0), (-2.0, 4.0, 0.0)):\n"
        "    column.set({'base.ax': ax, 'base.az': az, 'base.alpha': alpha})\n"
        "    seen.append(column.get(*REACTION, *SPLIT))\n"
        "column.set({'base.theta': 2e-3})\n"
        "seen.append(column.get(*REACTION, *SPLIT))\n"
        "print(json.dumps(seen))"
    )
    rows = np.array(json.loads(run(sys.executable, "-c", script, fmus.damped)))
    weight = 81000.0 * 9.80665
    for row, a in zip(rows, ([0.0] * 3, [3.0, -1.0, 20.0], [-2.0, 4.0, 0.0]), strict=False):
        xx, xz, xt, zz, zt, tt = row[6:]
        mass = np.array([[xx, xz, xt], [xz, zz, zt], [xt, zt, tt]])
        assert row[3:6] - mass @ a == pytest.approx(row[:3], abs=1e-13 * weight)
        assert row[3:] == pytest.approx(rows[0, 3:], rel=1e-12, abs=1e-12 * weight)
    assert abs(rows[1, 0] - rows[0, 0]) > 2e4  # 3 m/s2 on more than 8 t
    assert rows[3, 5] - rows[2, 5] < -1e5  # the base has been turned under the column


def test_the_state_keeps_the_rotation_of_the_base(fmus: Fmus) -> None:
    script = START + (
        "column = Instance(sys.argv[1], {'base.theta': 4e-4})\n"
        "print(column.get('block[1].theta')[0], column.get('joint[3].M')[0])\n"
        "column.set({'base.theta': 0.0})\n"
        "follow(column, 0, 40)\n"
        "saved = column.fmi.getFMUState()\n"
        "follow(column, 40, 80)\n"
        "first = column.get()\n"
        "column.fmi.setFMUState(column.fmi.deSerializeFMUstate(column.fmi.serializeFMUstate(saved)))\n"
        "follow(column, 40, 80)\n"
        "print(first == column.get(), abs(first[0]) > 1e-4)\n"
        "column.set({'base.omega': math.nan})\n"
        "print('discard' in column.attempt('step', 0.4, 0.01).lower(), column.attempt('close'))"
    )
    start, same, discarded = run(sys.executable, "-c", script, fmus.damped).splitlines()
    theta, moment = map(float, start.split())
    assert theta == pytest.approx(4e-4)
    assert abs(moment) < 1e-6
    assert same == "True True"
    assert discarded == "True ok"


def test_the_paper_formulation_refuses_a_base_that_rotates(fmus: Fmus) -> None:
    script = START + (
        "column = Instance(sys.argv[1], {'solver.formulation': 'paper'})\n"
        "column.set({'base.omega': 1e-3})\n"
        "print(column.attempt('step', 0.0, 0.01))\n"
        "column.set({'base.omega': 0.0})\n"
        "column.step(0.0, 0.01)\n"
    )
    assert "discard" in run(sys.executable, "-c", script, fmus.damped).lower()
