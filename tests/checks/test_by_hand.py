"""The methods by hand against closed forms of a rigid block, and against each other."""

import math
from dataclasses import replace

import numpy as np
import pytest

from multiblock import Block, Column, InputError, Joint, Plan, housner_restitution, spectra
from solver.checks.of_column import InPlane
from solver.checks.rigid_body import RigidBody, sliding_distance
from solver.checks.spectra import CornerSpectrum
from solver.statics.rocking import parts_above, rocking_part

STIFF = 1e13  # N/m3, so that the curve of pushes is nearly that of a rigid block
G = 9.80665


def column(count: int, width: float = 0.5, height: float = 1.0, stiffness: float = STIFF) -> Column:
    block = Block(height, width, 1.0, 2000.0 * height * width, Joint(stiffness, 1e-4))
    return Column("test", (block,) * count)


def test_kinematics_of_one_rigid_block() -> None:
    """Check that alpha0 = b / h, e* = 1; the top, the point of control, moves twice as far as the centroid to begin
    with.
    """
    found = InPlane(column(1), 1.0).mechanism
    assert found.joint == 0
    assert found.mass_part == pytest.approx(1.0, rel=1e-12)
    assert found.alpha0 == pytest.approx(0.5, rel=5e-3)  # measured: 3.9e-3 less
    edge = math.atan(0.5)
    angles = np.linspace(0.0, edge, 10_001)
    top = np.sin(angles) + 0.25 * (1.0 - np.cos(angles))  # of the middle of the top face, about the edge
    assert found.d0 == pytest.approx(0.5 * top[-1], rel=2e-3)  # measured: 8e-5
    turned = float(np.interp(0.4 * top[-1], top, angles))
    expected = 1.68 * math.pi * math.sqrt(0.4 * 0.5 * top[-1] / (G * math.tan(edge - turned)))
    assert found.period == pytest.approx(expected, rel=5e-3)


def test_part_of_the_mass_of_two_blocks() -> None:
    """Check that both turn about the base: centroids at 1/2 and 3/2 heights, e* = 2^2 / (2 * 2.5)."""
    found = InPlane(column(2), 1.35).mechanism
    assert found.joint == 1
    assert found.mass_part == pytest.approx(0.8, rel=1e-12)
    assert found.a0 == pytest.approx(found.alpha0 * G / (0.8 * 1.35), rel=1e-12)


def test_a_pedestal_that_stands_still_is_no_part_of_the_mechanism() -> None:
    """Check that the statue alone turns: its e* is 1 on the ground and on a pedestal that is wider and heavier."""
    statue = column(1)
    pedestal = Block(0.8, 2.0, 2.0, 8000.0, Joint(STIFF, 1e-4))
    both = InPlane(Column("test", (*statue.blocks, pedestal)), 1.35).mechanism
    alone = InPlane(statue, 1.35).mechanism
    assert both.joint == 0
    assert both.mass_part == pytest.approx(1.0, rel=1e-12)
    assert both.a0 == pytest.approx(alone.a0, rel=1e-3)
    assert both.d0 == pytest.approx(alone.d0, rel=1e-3)


def test_demand_is_that_of_the_displacement_spectrum() -> None:
    found = InPlane(column(1), 1.35).mechanism
    action = spectra.eurocode8(2.0, "B")
    period = found.period
    expected = float(action.psa(period, 0.08)) * (period / (2.0 * math.pi)) ** 2
    assert found.demand(action, 0.05, smooth=True) == pytest.approx(expected, rel=1e-12)
    assert found.demand(action, 0.05, smooth=False) >= expected * (1.0 - 1e-12)


def test_parts_of_a_stack_are_the_bodies_of_one_block() -> None:
    one = RigidBody(*parts_above(column(1, height=3.0))[0])
    parts = [RigidBody(*part) for part in parts_above(column(3))]
    assert [body.joint for body in parts] == [1, 2, 3]
    for name in ("mass", "half_width", "centroid", "inertia"):
        assert getattr(parts[2], name) == pytest.approx(getattr(one, name), rel=1e-12)
    assert rocking_part(column(3)).joint == 3
    a = one.slenderness
    assert one.inertia / (one.mass * one.centroid**2) == pytest.approx(4.0 / 3.0 * (1.0 + a * a), rel=1e-12)
    assert one.restitution == pytest.approx(housner_restitution(column(1, height=3.0)), rel=1e-9)


def test_a_part_off_its_axis_turns_about_the_nearer_edge_of_what_bears() -> None:
    """Check a block 0.3 m over the edge: b = 0.1 m at h = 1 m, 0.4 m on the other side, and an impact between them."""
    upper = Block(2.0, 0.8, 0.8, 3000.0, Joint(STIFF, 1e-4, offset=0.3))
    pedestal = Block(0.5, 0.8, 0.8, 750.0, Joint(STIFF, 1e-4))
    for sign in (1.0, -1.0):
        aside = replace(upper, joint=replace(upper.joint, offset=0.3 * sign))
        both = Column("aside", (aside, pedestal))
        body = RigidBody(*rocking_part(both))
        assert body.joint == 1
        assert body.centroid == pytest.approx(1.0, rel=1e-12)
        assert body.slenderness == pytest.approx(0.1, rel=1e-12)
        about = 3000.0 * (2.0**2 + 0.8**2) / 12.0 + 3000.0 * np.array([0.1**2 + 1.0, 0.4**2 + 1.0, 1.0 - 0.04])
        kept = about[2] / math.sqrt(about[0] * about[1])
        assert housner_restitution(both) == pytest.approx(kept, rel=1e-12)
        # both together: centroid (2 * 0.3) / 2.5 = 0.24 m aside, at (2 * 1.5 + 0.5 * 0.25) / 2.5 = 1.25 m
        assert parts_above(both)[1].slenderness == pytest.approx((0.4 - 0.24) / 1.25, rel=1e-12)
        assert body.rotation(spectra.eurocode8(0.099 * G, "A"), G) == 0.0
        assert body.rotation(spectra.eurocode8(0.6 * G, "C"), G) == math.inf


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_parts_that_lean_begin_to_rock_under_the_least_push_of_the_curve(sign: float) -> None:
    joint = Joint(STIFF, 1e-4)
    turned = Block(2.0, 0.8, 0.8, 3000.0, replace(joint, inclination=0.05 * sign, offset=0.02 * sign), tilt=0.03 * sign)
    strips = (0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.8, 0.0)[:: int(sign)]
    chipped = Block(2.0, 0.8, 0.8, 3000.0, replace(joint, section="strips", strips=strips))
    sloping = Block(0.5, 0.8, 0.8, 750.0, replace(joint, inclination=-0.02 * sign))
    for blocks in ((turned, sloping), (turned,), (chipped, sloping), (chipped,)):
        leaning = Column("leaning", blocks)
        assert rocking_part(leaning).slenderness == pytest.approx(InPlane(leaning).mechanism.alpha0, rel=8e-3)
    # hand value: a strip of 0.1 m is missing, so b = 0.3 m at h = 1 m
    assert rocking_part(Column("chipped", (chipped,))).slenderness == pytest.approx(0.3, rel=1e-12)


def test_capacity_and_frequency_have_the_energy_of_the_turned_block() -> None:
    """Compare with twice the work of the restoring moment, by quadrature, over the square of the rotation."""
    body = RigidBody(*parts_above(column(1, height=3.0))[0])
    radius, alpha, theta = math.hypot(0.25, 1.5), body.edge_angle, 0.1
    angles = np.linspace(0.0, theta, 20_001)
    moment = body.mass * G * radius * np.sin(alpha - angles)
    work = float(np.sum(0.5 * (moment[1:] + moment[:-1])) * theta / 20_000)
    stiffness = 2.0 * work / theta**2
    assert body.capacity(theta, G) == pytest.approx(stiffness * theta / (body.mass * body.centroid), rel=1e-7)
    assert 2.0 * math.pi * body.frequency(theta, G) == pytest.approx(math.sqrt(stiffness / body.inertia), rel=1e-7)


def test_rotation_balances_demand_and_capacity() -> None:
    body = RigidBody(*parts_above(column(1, width=0.8, height=4.0))[0])
    action = spectra.eurocode8(0.3 * G, "C")
    theta = body.rotation(action, G)
    assert 0.0 < theta < body.edge_angle
    demand = float(action.psa(1.0 / body.frequency(theta, G), body.damping))
    assert body.capacity(theta, G) == pytest.approx(demand, rel=1e-4)  # measured: 6e-6
    # it begins to rock where the ground reaches b / h = 0.2 g
    assert body.rotation(spectra.eurocode8(0.199 * G, "A"), G) == 0.0
    assert body.rotation(spectra.eurocode8(0.201 * G, "A"), G) > 0.0
    assert body.rotation(spectra.eurocode8(5.0 * G, "C"), G) == math.inf


def test_sliding_distance_on_a_falling_branch() -> None:
    """Check that Sa = P TC / T there, so that c_s is reached at f = c_s / (P TC)."""
    action = CornerSpectrum(20.0, 2.5, 0.1, 0.5, 50.0)
    plateau = 50.0 * math.sqrt(10.0 / 15.0)
    strength = 2.0 * 0.3 * (1.0 - 0.4 * 0.2) * G
    frequency = strength / (plateau * 0.5)
    expected = strength / (2.0 * math.pi * frequency) ** 2
    found = sliding_distance(0.3, 0.2 * G, action, G)
    assert found == pytest.approx(expected, rel=1e-9)  # a straight line in logarithms there
    assert sliding_distance(3.0, 0.0, spectra.eurocode8(0.2 * G, "A"), G) == 0.0
    assert sliding_distance(0.5, 3.0 * G, action, G) == math.inf


def test_confidence_factor_has_a_range() -> None:
    with pytest.raises(InputError, match=r"confidence_factor = 0.5: must be a confidence factor from 1 to 3"):
        Plan(confidence_factor=0.5)
