"""Faces that touch in a rim along their edges: the bed of the outline less that of the inside, and what follows of it.

test_contacts.py and test_sections.py have the law, energy and edges of given pairs of faces.
"""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from joints.test_contacts import Pair, Shape, ask
from support.probe import G

from solver import Block, Column, InitialState, InputError, Joint, Motion, Settings, natural_frequencies, simulate
from solver.models.column.kinematics import Chain
from solver.models.column.linearization import StillColumn
from solver.models.column.numbers import column_with
from solver.models.column.run import phase_of
from solver.models.column.stepper import Stepper
from solver.models.structure.stack import column_of
from solver.statics.capacity import capacity_curve

examples = settings(deadline=None, max_examples=75, derandomize=True)


def block(rim: float | None, stiffness: float = 1e13, depth: float = 20.0, eta: float = 0.0, **joint: Any) -> Column:
    """Return a block of 0.5 x 1.9 m, long across the motion unless said otherwise."""
    own = Joint(stiffness, eta, rim=rim, **joint)
    return Column("block", (Block(1.9, 0.5, depth, 2500.0 * 0.5 * 1.9 * depth, own),), Settings(tolerance=1e-6))


def critical(column: Column, rim: float) -> float:
    """Return the critical eta, s, of the block on the band along its edge: 2 over its frequency there."""
    only = column.blocks[0]
    eases = 1.0 / only.mass + (0.5 * only.width) ** 2 / only.resolved_inertia  # 1/kg, at the edge
    return 2.0 / math.sqrt(only.joint.stiffness * rim * only.depth * eases)


# --- the difference form


@st.composite
def pairs(draw: st.DrawFn) -> Pair:
    """Return a rectangle, disc or ring on another one, of random sizes."""

    def shape() -> Shape:
        width, kind = draw(st.floats(0.7, 1.5)), draw(st.integers(0, 2))
        return Shape(width, *((draw(st.floats(0.5, 1.5)),), (), (0.0, draw(st.floats(0.1, 0.5))))[kind])

    return Pair(shape(), shape(), draw(st.floats(1e-3, 0.2)))


@given(pair=pairs(), slip=st.one_of(st.just(0.0), st.floats(-0.6, 0.6)), state=st.tuples(*[st.floats(-1.0, 1.0)] * 2))
@examples
def test_random_faces_and_slips_are_those_of_quadrature(pair: Pair, slip: float, state: tuple[float, float]) -> None:
    assume(slip == 0.0 or abs(slip) > 1e-3)
    assume(state[0] == 0.0 or abs(state[0]) > 1e-6)
    for shape in (pair.own, pair.below):  # else all of a face is rim
        inside = shape.inset(pair.rim)
        assume(inside.width > inside.bore and (inside.depth > 0.0 or not shape.depth))
    try:
        column = pair.column()
    except InputError:  # nothing touches
        assume(False)
    slope, opening = 1e-3 * state[0], 5e-4 * state[1]
    scale = 2e9 * (abs(opening) + abs(slope)) + 1.0
    sizes = scale * np.array([abs(opening) + abs(slope) + 1e-6, 1.0, 1.0])
    found, expected = ask(column, opening, slope, slip), pair.integrals(slip, opening, slope)
    assert np.max(np.abs(found[:3] - expected) / sizes) < 1e-12  # measured 3e-15


@given(pair=pairs(), slip=st.floats(-0.6, 0.6))
@examples
def test_a_rim_of_half_the_width_is_the_whole_face_to_the_last_bit(pair: Pair, slip: float) -> None:
    try:
        whole, rim = replace(pair, rim=0.0).column(), replace(pair, rim=0.8).column()
    except InputError:
        assume(False)
    assert np.array_equal(ask(whole, -1e-4, 3e-4, slip), ask(rim, -1e-4, 3e-4, slip))
    nearly = min((shape.width - shape.bore) / (4.0 if shape.bore else 2.0) for shape in (pair.own, pair.below))
    nearly = min([nearly, *(0.5 * shape.depth for shape in (pair.own, pair.below) if shape.depth)])
    near = replace(pair, rim=nearly * (1.0 - 1e-14)).column()
    assert ask(near, -1e-4, 3e-4, slip)[:3] == pytest.approx(ask(whole, -1e-4, 3e-4, slip)[:3], rel=1e-12, abs=1e-9)


def test_the_rim_of_a_rectangle_is_that_of_strips() -> None:
    """Compare a rim as wide as a strip: the same forces, and the same motion."""
    width, depth, rim = 1.6, 1.0, 0.1
    strips = (depth, *(14 * (2.0 * rim,)), depth)
    two = [Joint(1e9, 1e-3, rim=rim), Joint(1e9, 1e-3, section="strips", strips=strips)]
    columns = [Column("two", tuple(Block(3.0, width, depth, 12000.0, joint) for _ in range(2))) for joint in two]
    for opening, slope in ((-1e-4, 0.0), (-1e-4, 1e-4), (-2e-5, 3e-4), (1e-4, -9e-4)):
        one, other = (Chain(column).elastic(np.full(2, opening), np.full(2, slope)) for column in columns)
        assert one == pytest.approx(other, rel=1e-13)
    runs = [simulate(column, Motion.harmonic(0.4 * G, 1.2, 2.0), tolerance=1e-7) for column in columns]
    assert not runs[0].overturned
    assert np.max(np.abs(runs[0].ux - runs[1].ux)) < 2e-5 * np.max(np.abs(runs[0].ux))


# --- a column


def test_the_stiffness_at_rest_is_the_slope_of_the_forces_and_that_of_the_textbook() -> None:
    column = block(0.05, 1e9, 0.4)
    area, second = 0.5 * 0.4 - 0.4 * 0.3, (0.5**3 * 0.4 - 0.4**3 * 0.3) / 12.0
    contact = column.contacts[0]
    assert contact.moments == pytest.approx((area, 0.0, second), rel=1e-14)
    settled = column.blocks[0].mass * G / (1e9 * area)
    assert Stepper(column).state.phase.opening[0] == pytest.approx(-settled, rel=1e-13)
    lifts = 1e9 * area / column.blocks[0].mass
    assert natural_frequencies(column)[1] == pytest.approx(math.sqrt(lifts) / (2.0 * math.pi), rel=1e-6)
    still = StillColumn(column)
    matrix = still.stiffness(still.rest, 1e-3)
    only = column.blocks[0]
    arm = 0.95 - 0.5 * settled
    about = only.resolved_inertia + only.mass * arm**2
    turning = 1e9 * second - only.mass * G * (0.95 - 0.25 * settled)
    assert matrix[0, 0] == pytest.approx(turning / about, rel=1e-5)


def test_a_rim_stands_as_far_as_the_outline_reaches() -> None:
    """Check that the push that overturns a stiff block is that about its edge, less what gives way."""
    push = float(np.max(capacity_curve(block(1e-3)).acceleration))
    assert push == pytest.approx(G * 0.25 / 0.95, rel=3e-3)


@pytest.mark.parametrize("section", [{}, {"section": "circle"}, {"section": "annulus", "bore": 0.3}])
def test_faces_that_share_area_touch_in_a_rim_after_any_slip(section: dict[str, Any]) -> None:
    """Check that two equal blocks whose insides no longer meet still bear on each other, to the last of the overlap."""
    low = Block(0.4, 1.0, 1.0, 1e5, Joint(1e12, 1e-3), **section)
    top = Block(0.2, 1.0, 1.0, 500.0, Joint(1e11, 1e-3, rim=0.06, offset=0.45), **section)
    column = Column("slipped", (top, low))
    simulate(column, Motion.harmonic(0.01 * G, 2.0, 0.5))
    assert Chain(column).elastic(np.full(2, -1e-6), np.zeros(2), np.array([0.97, 0.0]))[0] > 0.0


def test_a_damped_block_on_a_rim_loses_energy_all_the_time() -> None:
    """Let it rock and slide on a still base, over a heavy plinth no wider than the block."""
    top = Block(1.2, 0.5, 0.5, 750.0, Joint(1e10, 1e-4, friction=0.25, rim=0.02))
    column = Column("two", (top, Block(0.3, 0.5, 0.5, 1e5, Joint(1e12, 1e-4, rim=0.05))), Settings(tolerance=1e-8))
    stepper = Stepper(column, InitialState(rotation=[0.12, 0.0], slip_rate=[0.5, 0.0]))
    chain, energy = Chain(column), []
    for k in range(150):
        energy.append(chain.energy(phase_of(stepper)))
        stepper.rest_until(0.01 * k, 0.01 * (k + 1))
    assert abs(stepper.state.phase.slip[0]) > 0.01
    assert np.max(np.diff(energy)) < 1e-7 * energy[0]
    assert energy[-1] < 0.95 * energy[0]


@pytest.mark.parametrize("stiffness", [2e10, pytest.param(1e13, marks=pytest.mark.long)])
def test_a_block_on_a_rim_rebounds_as_housners(stiffness: float) -> None:
    """Let go at 0.08 rad: 0.909 to 0.914 on its two edges, where Housner has 0.903; 0.966 on the whole face."""
    rim = 0.5 / 32.0 if stiffness < 1e12 else 1e-3
    column = block(rim, stiffness)
    eta = critical(column, rim)
    assert 0.900 < restitution(block(rim, stiffness, eta=eta)) < 0.920
    assert 0.94 < restitution(block(None, stiffness, eta=eta)) < 0.99


def restitution(column: Column) -> float:
    """Return the rotation rate after the first impact over that before it, from the rotations on either side."""
    on_edge = InitialState(rotation=[0.08], opening=[0.5 * math.sin(0.04)])
    run = simulate(column, Motion.from_samples(1.5, [0.0, 0.0]), initial=on_edge, output_step=1e-4)
    theta = run.ry[:, 0]
    mass, reach = column.blocks[0].mass, math.hypot(0.25, 0.95)
    turned = float(np.max(-theta))  # the farthest on the other side
    angle = math.atan2(0.25, 0.95)

    def lifted(rotation: float) -> float:
        return mass * G * reach * (math.cos(angle - rotation) - math.cos(angle))

    return math.sqrt(lifted(turned) / lifted(0.08))


def test_a_stack_in_space_has_the_rims_of_its_column_and_back() -> None:
    low = Block(0.3, 0.5, 0.6, 200.0, Joint(1e10, 1e-4, rim=0.05))
    column = Column("two", (Block(1.2, 0.5, 0.5, 750.0, Joint(1e10, 1e-4, rim=0.02)), low))
    stack = column.in_space()
    assert [joint.moments[0] for joint in stack.joints] == pytest.approx([part.area for part in column.contacts])
    again = column_of(stack)
    assert again is not None
    assert [block.joint.rim for block in again.blocks] == [0.02, 0.05]


def test_studies_vary_rims_by_name_and_with_the_size() -> None:
    column = Column("two", block(0.02).blocks * 2)
    varied = column_with(
        column, {"joint[1].rim": (0.5, True), "joint[2].rim": (0.03, False), "column.size": (2.0, True)}
    )
    assert [one.joint.rim for one in varied.blocks] == [0.02, 0.03]
    assert varied.blocks[0].width == 1.0


# --- refusals


@pytest.mark.parametrize(
    ("joint", "message"),
    [
        ({"rim": 0.0}, "block[1].joint.rim = 0.0: must be a positive length in m, from 1e-6 to 1e6: the band along"),
        ({"rim": 0.1, "section": "strips", "strips": (0.5,)}, "block[1].joint.rim = 0.1: must be left out beside"),
        ({"rim": 0.1, "tensile_strength": 1e5}, "block[1].joint.rim = 0.1: must be left out of a joint that bears"),
        ({"rim": 0.1, "cohesion": 1e5, "friction": 0.5}, "block[1].joint.rim = 0.1: must be left out of a joint that"),
    ],
)
def test_what_says_already_where_faces_touch_has_no_rim(joint: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as raised:
        Column("refused", (Block(1.0, 0.5, 0.5, 500.0, Joint(1e9, 1e-3, **joint)),))
    assert str(raised.value).startswith(message)
