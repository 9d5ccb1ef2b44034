"""Properties of a column as soon as the law of a joint is not the linear one, whichever law that is.

There is no other law; the damping stands for the parameter of one here.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from fmu_src import variables as table
from fmu_src.body import ColumnBody
from fmu_src.native.column_subject import column_subject
from solver import Block, Column, InputError, Joint, Motion, simulate
from solver.kernels.column.model.description import GIVEN, GIVEN_SETTINGS
from solver.models.column.kinematics import Chain
from solver.models.column.lane_policy import reason_against_lanes
from solver.models.protocol import RunPlan

ETA = 1e-2
BLOCK = Block(2.0, 1.0, 1.2, 5e3, Joint(1e9, ETA))


@pytest.fixture
def other(monkeypatch: pytest.MonkeyPatch) -> None:
    """Let joints with damping have another law."""
    monkeypatch.setattr("solver.models.column.block.OTHER_LAW", ("damping",))
    monkeypatch.setattr("solver.models.column.block._LAWS", {"damping": {"sections": ("rectangle", "strips")}})
    monkeypatch.setattr("solver.kernels.layout.spaces.OTHER_LAW", ("damping",))


def column(block: Block = BLOCK, eta: float = ETA) -> Column:
    return Column("two", (replace(block, joint=replace(block.joint, damping=eta)), block))


@pytest.mark.usefixtures("other")
def test_runs_are_not_made_in_lanes() -> None:
    assert reason_against_lanes(column()) == "joint.damping"
    assert not reason_against_lanes(Column("one", column(eta=0.0).blocks[:1]))
    motion = Motion.harmonic(0.05, 1.0, 0.1)  # m/s2, Hz, s
    response = simulate(column(), motion, settle=0)
    assert not response.model.kind.in_lanes(response, RunPlan(motion, 0.1, response.time))


@pytest.mark.usefixtures("other")
@pytest.mark.parametrize("change", [{"friction": 0.5}, {"offset": 0.01}, {"inclination": 0.01}])
def test_joints_that_slide_or_are_off_the_axis_are_refused(change: dict[str, Any]) -> None:
    (key,) = change
    with pytest.raises(InputError, match=rf"^block\[1\].joint.{key} = .*: must be left out beside joint.damping$"):
        column(replace(BLOCK, joint=replace(BLOCK.joint, **change)))


@pytest.mark.usefixtures("other")
def test_sections_that_the_law_is_not_written_for_are_refused() -> None:
    wanted = r'^block\[1\].joint.damping = 0.01: must be left out, or the contact\'s section "rectangle" or "strips"$'
    drum = replace(BLOCK, joint=replace(BLOCK.joint, section="circle"))
    with pytest.raises(InputError, match=wanted):
        column(drum)
    none = replace(drum, joint=replace(drum.joint, damping=0.0))
    assert [damping_limits(column(block, eta=0.0)) for block in (none, BLOCK)] == [[(0.0, 0.0)] * 2, [(0.0, 1e6)] * 2]


def damping_limits(of: Column) -> list[tuple[float, float]]:
    """Return the limits within which a host can set the dampings of the native FMU."""
    return [check.limits for check in column_subject(ColumnBody(of)).checks if check.name.endswith(".damping")]


def test_energies_are_those_of_the_kernels_law_above_its_rest(monkeypatch: pytest.MonkeyPatch) -> None:
    linear = Chain(column())
    monkeypatch.setattr("solver.models.column.block.OTHER_LAW", ("damping",))
    monkeypatch.setattr("solver.models.column.block._LAWS", {"damping": {"sections": ("rectangle",)}})
    some = np.random.default_rng(3).normal(scale=1e-4, size=(50, 8))
    found, expected = Chain(column()).energies(some), linear.energies(some)
    assert not Chain(column()).rectangles.any()
    np.testing.assert_allclose(found, expected, rtol=1e-9, atol=1e-9 * expected.max())


@pytest.mark.usefixtures("other")
def test_nothing_stands_because_of_its_energy() -> None:
    gentle = Motion.harmonic(0.05, 1.0, 1.0)
    run = simulate(column(), gentle, settle=0)
    assert run.verdict == "undecided"
    assert run.reason == "0 s after the end it has not fallen, and with joint.damping no energy tells whether it can"
    run = simulate(column(), gentle, settle=10.0)
    assert (run.verdict, run.reason) == ("standing", "it has come to rest")


def test_what_is_no_parameter_of_an_fmu_stays_as_built(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delitem(table.JOINT_PARAMETERS, "damping")
    built = column(eta=0.3)
    values = {item.name: item.start for item in table.variables(built)}
    assert "joint[1].damping" not in values
    values |= {f"solver.{name}": values[f"solver.{name}"] or "" for name in ("without",)}
    assert table.column_from(built, lambda name: values[name]).blocks == built.blocks  # type: ignore[arg-type, return-value]
    subject = column_subject(ColumnBody(built))
    places = [GIVEN_SETTINGS.beside + GIVEN.beside * i + GIVEN.fields.index("joint_damping") for i in range(2)]
    assert [subject.given[place] for place in places] == [0.3, ETA]
    assert not [check.name for check in subject.checks if check.name.endswith(".damping")]
