"""Columns that fall in lanes: their runs end where they overturn, as those of `simulate` do."""

from __future__ import annotations

import itertools
from dataclasses import replace

import pytest
from support.probe import G, phocas

from solver import Column, Motion, simulate
from solver.runs.batch import follow_in_lanes, kind_of


def with_joints(column: Column, **changes: object) -> Column:
    blocks = (replace(block, joint=replace(block.joint, **changes)) for block in column.blocks)  # type: ignore[arg-type]
    return replace(column, blocks=tuple(blocks))


def of_kind(kind: str) -> Column:
    column = phocas(2e-3)
    if kind == "swept":
        return column.with_settings(formulation="paper", integrator="central-difference", step=2e-4)
    if kind.startswith("round"):
        column = replace(column, blocks=tuple(replace(block, section="circle") for block in column.blocks))
    if kind.startswith("strips"):
        column = with_joints(column, section="strips", strips=(1.0, 0.5, 1.0))
    return with_joints(column, friction=0.5) if kind.endswith("slipping") else column


@pytest.mark.parametrize(
    "kind",
    [
        "plain",
        *(
            pytest.param(kind, marks=pytest.mark.long)  # each compiles its lanes
            for kind in ("slipping", "round", "round, slipping", "strips, slipping", "swept")
        ),
    ],
)
def test_peaks_time_and_joint_are_those_of_simulate(kind: str) -> None:
    """Of 12 columns thrown down at several speeds: the step in which one falls ends with it (measured 2e-6)."""
    column = of_kind(kind)
    assert kind_of(column) == kind
    pairs = itertools.product((0.3, 0.4, 0.5, 0.7), (0.3, 0.4, 0.5, 0.6))
    motions = [Motion.harmonic(amplitude * G, frequency, 4.0) for amplitude, frequency in pairs]
    swept = kind == "swept"  # at the fixed step of the column
    lanes, closer = (column if swept else column.with_settings(tolerance=tolerance) for tolerance in (1e-4, 1e-8))
    result = follow_in_lanes([lanes] * len(motions), motions, [4.0] * len(motions))
    fell = [k for k, joint in enumerate(result.overturned_joint) if joint]
    assert len(fell) >= 8
    for k in fell:
        single = simulate(closer, motions[k], 4.0, output_step=1.0, settle=0.0)
        assert result.peak_ux[k] == pytest.approx(single.peak_ux, rel=1e-5)
        assert result.overturned_joint[k] == single.overturned_joint
        assert result.overturn_time[k] == pytest.approx(single.overturn_time, abs=1e-5)
