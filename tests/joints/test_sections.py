"""Sections: moments of parts against quadrature, the law of joints that are no rectangles, what it rests on."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from support.barriers import barrier
from support.probe import Array

from solver import Block, Column, InitialState, Joint, Motion, natural_frequencies, simulate
from solver.kernels.column.joint.law import held_forces, joint_forces, joint_potential, law_of
from solver.kernels.column.joint.regimes import OPEN, contact_regime
from solver.kernels.column.sections.section import (
    contact_of,
    full_stiffness,
    full_turning_stiffness,
    part_stiffness,
    strip_stiffness,
)
from solver.kernels.engine.circle import SMALL, circle_part
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.models.column.kinematics import Chain
from solver.models.column.packing import pack_model
from solver.models.column.stepper import Stepper

examples = settings(deadline=None, max_examples=100, derandomize=True)

K = 1e9  # N/m3
WIDTH = 1.6  # m
JOINTS = {
    "rectangle": Joint(K, 0.0, WIDTH, 1.2),
    "circle": Joint(K, 0.0, WIDTH, section="circle"),
    "annulus": Joint(K, 0.0, WIDTH, section="annulus", bore=0.7),
    "strips": Joint(K, 0.0, WIDTH, section="strips", strips=(0.4, 1.0, 0.0, 1.3, 1.3, 0.0, 1.0, 0.4)),
    "chipped": Joint(K, 0.0, WIDTH, section="strips", strips=(0.0, 0.8, 1.2, 0.8, 0.0)),
    "frame": Joint(K, 0.0, WIDTH, 1.2, rim=0.07),
    "rim of a disc": Joint(K, 0.0, WIDTH, section="circle", rim=0.31),
    "rims of a ring": Joint(K, 0.0, WIDTH, section="annulus", bore=0.7, rim=0.1),
}
ENDS = dict.fromkeys(JOINTS, 0.5 * WIDTH) | {"chipped": 0.3 * WIDTH}
NAMES = list(JOINTS)
GAUSS = np.polynomial.legendre.leggauss(30)

_model = at.MODEL.over


_circle_part = from_python(circle_part)


@from_python
def _ask(model: Array, opening: float, slope: float, opening_rate: float, slope_rate: float, out: Array) -> None:
    """Return N, M, length; the same held in the regime; energy; stiffness of the part from lo to hi; of all; of a
    strip.
    """
    blocks = _model(row_of(model), 1).blocks
    contact, law = contact_of(blocks, 0), law_of(blocks, 0)
    k, eta = law.stiffness, law.damping
    out[0], out[1], out[2] = joint_forces(contact, law, opening, slope, opening_rate, slope_rate)
    regime = contact_regime(contact.left, contact.right, eta, opening, slope, opening_rate, slope_rate)
    out[3] = regime
    out[4], out[5], out[6], _ = held_forces(regime, contact, law, opening, slope, opening_rate, slope_rate)
    out[7] = joint_potential(contact, law, opening, slope)
    out[8], out[9], out[10] = part_stiffness(contact, k, opening, slope)
    out[11], out[12] = full_stiffness(blocks, 0), full_turning_stiffness(blocks, 0)
    out[13], _, _ = strip_stiffness(contact, k, opening, 1.0)


@lru_cache(maxsize=100)
def model_of(name: str, damping: float) -> Array:
    """Return the numbers of a column of one block on a joint of this name, which kernels only read."""
    return pack_model(Column("one", (Block(2.0, WIDTH, WIDTH, 1e4, replace(JOINTS[name], damping=damping)),)))


def ask(name: str, *state: float, damping: float = 0.0) -> Array:
    """Return the numbers of `_ask` for a joint of this name; opening, slope and their rates, or lo and hi in the first
    two.
    """
    out = np.zeros(14)
    _ask(model_of(name, damping), *(*state, 0.0, 0.0, 0.0, 0.0)[:4], out)
    return out


# --- independent truth: Gauss's rule between all kinks


@dataclass(frozen=True)
class Nodes:
    """Abscissas m, distances of each from lo and hi of their part, and areas m2 that go with them."""

    s: Array
    weight: Array


def chord(radius: float, s: Array) -> Array:
    return 2.0 * np.sqrt(np.maximum(0.0, (radius - s) * (radius + s)))


def nodes(name: str, lo: float, hi: float) -> Nodes:
    """Return Gauss-Legendre nodes over the part of a section; what a rim leaves open has negative areas."""
    found, rim = inset_nodes(name, lo, hi, 0.0), JOINTS[name].rim
    if rim is None:
        return found
    end = 0.5 * WIDTH - rim
    open_ = inset_nodes(name, max(lo, -end), min(hi, end), rim)
    return Nodes(np.concatenate([found.s, open_.s]), np.concatenate([found.weight, -open_.weight]))


def inset_nodes(name: str, lo: float, hi: float, rim: float) -> Nodes:
    """Return `nodes` of a section inset by a rim; round ones by the angle, which leaves nothing singular."""
    x, w = GAUSS
    kinks = {lo, hi, *(edge for edge in edges(name) if lo < edge < hi)} if lo < hi else {lo}
    places, areas = [], []
    for begin, end in np.lib.stride_tricks.sliding_window_view(sorted(kinks), 2) if lo < hi else ():
        if JOINTS[name].section in ("circle", "annulus"):
            circles = ((0.5 * WIDTH - rim, 1.0), (0.35 + rim, -1.0))
            for radius, sign in circles[: 2 if JOINTS[name].section == "annulus" else 1]:
                low, high = max(begin, -radius), min(end, radius)
                if low < high:
                    first, last = math.asin(low / radius), math.asin(high / radius)
                    angle = 0.5 * (first + last) + 0.5 * (last - first) * x
                    places.append(radius * np.sin(angle))
                    areas.append(sign * (last - first) * w * (radius * np.cos(angle)) ** 2)
        else:
            places.append(0.5 * (begin + end) + 0.5 * (end - begin) * x)
            areas.append(0.5 * (end - begin) * w * (depth(name, 0.5 * (begin + end)) - 2.0 * rim))
    return Nodes(np.concatenate(places), np.concatenate(areas)) if places else Nodes(np.zeros(0), np.zeros(0))


def edges(name: str) -> Array:
    strips = JOINTS[name].strips or ()
    if strips:
        return np.linspace(-0.5 * WIDTH, 0.5 * WIDTH, len(strips) + 1)
    rim, bore = JOINTS[name].rim or 0.0, 0.5 * (JOINTS[name].bore or 0.0)
    half = {bore, bore + rim} if bore else {0.0}
    half |= {0.5 * WIDTH - rim} if rim else set()
    return np.array(sorted(sign * place for place in half if place for sign in (-1.0, 1.0)))


def depth(name: str, place: float) -> float:
    strips = JOINTS[name].strips or ()
    return strips[min(int((place / WIDTH + 0.5) * len(strips)), len(strips) - 1)] if strips else 1.2


def resultants(
    name: str, eta: float, opening: float, slope: float, opening_rate: float, slope_rate: float
) -> tuple[float, float]:
    """Return N and M of the pressure max(0, k pen + eta k pen') where pen > 0."""
    end = ENDS[name]
    kinks = {-end, end}
    for value, gradient in ((opening, slope), (opening + eta * opening_rate, slope + eta * slope_rate)):
        if gradient != 0.0 and abs(value / gradient) < end:
            kinks.add(value / gradient)
    force = moment = 0.0
    for begin, end in np.lib.stride_tricks.sliding_window_view(sorted(kinks), 2):
        found = nodes(name, begin, end)
        pen = slope * found.s - opening
        pressure = K * (pen + eta * (slope_rate * found.s - opening_rate))
        middle = 0.5 * (begin + end)
        both = min(slope * middle - opening, slope * middle - opening + eta * (slope_rate * middle - opening_rate))
        if both > 0.0:
            force += float(np.sum(found.weight * pressure))
            moment += float(np.sum(found.weight * pressure * found.s))
    return force, moment


# --- moments


@pytest.mark.parametrize("name", NAMES)
@given(data=st.data())
@examples
def test_moments_of_a_part_are_those_of_quadrature(name: str, data: st.DataObject) -> None:
    end = ENDS[name]
    lo, hi = sorted(data.draw(st.lists(st.floats(-end, end), min_size=2, max_size=2)))
    assume(hi - lo > 1e-9)
    found = ask(name, lo, hi)[8:11] / K
    part = nodes(name, lo, hi)
    area, _, second = ask(name, -end, end)[8:11] / K
    for power, scale in zip(range(3), (area, area * end, second), strict=True):
        expected = float(np.sum(part.weight * part.s**power))
        assert found[power] == pytest.approx(expected, abs=1e-13 * scale), power  # measured 1.5e-14, of the rule


@pytest.mark.parametrize("depth_of_segment", [10.0**-k for k in range(13)])
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_slivers_at_the_rim_of_a_circle_keep_their_digits(depth_of_segment: float, side: float) -> None:
    """Compare with a sum of positive terms in the depth: chord 2 sqrt(2 x) sqrt(1 - x / 2), binomially expanded."""
    h = 1.0 - (1.0 - depth_of_segment)  # as it is after rounding
    lo, hi = sorted((side * (1.0 - depth_of_segment), side))
    middle, area, first, second = _circle_part(1.0, lo, hi)
    x, w = np.polynomial.legendre.leggauss(80)
    y = 0.5 * (x + 1.0)  # depth = h y^2: the integrand is smooth in y
    places, weight = h * y * y, w * h * y * 2.0 * np.sqrt((h * y * y) * (2.0 - h * y * y))
    offset = 0.5 * h - places  # from the middle, towards the rim
    assert middle == pytest.approx(side * (1.0 - 0.5 * h), rel=1e-15)
    assert area == pytest.approx(float(np.sum(weight)), rel=1e-13)  # measured 4e-15
    assert side * first == pytest.approx(float(np.sum(weight * offset)), rel=1e-12)  # measured 1e-13
    assert second == pytest.approx(float(np.sum(weight * offset**2)), rel=1e-11)  # measured 1e-12


def test_series_and_closed_form_meet() -> None:
    for c in (math.sqrt(1.0 - SMALL**2), 0.7):  # cosine of half the angle under which the part is seen
        s = math.sqrt(1.0 - c * c)
        found = [_circle_part(1.0, -s * (1.0 + near), s * (1.0 + near)) for near in (-1e-13, 1e-13)]
        assert found[1] == pytest.approx(found[0], rel=1e-11)


def test_full_contact_is_that_of_the_textbook() -> None:
    area, second = math.pi / 4.0 * WIDTH**2, math.pi / 64.0 * WIDTH**4
    hole, hole_second = math.pi / 4.0 * 0.7**2, math.pi / 64.0 * 0.7**4
    for name, expected in (("circle", (area, second)), ("annulus", (area - hole, second - hole_second))):
        assert ask(name)[11:13] / K == pytest.approx(expected, rel=1e-15)
    pitch = WIDTH / 5.0
    middle = sum(t * pitch * (pitch**2 / 12.0 + (k * pitch) ** 2) for k, t in ((-1, 0.8), (0, 1.2), (1, 0.8)))
    assert ask("chipped")[11:13] / K == pytest.approx((2.8 * pitch, middle), rel=1e-14)


@pytest.mark.parametrize("name", NAMES)
@given(place=st.floats(-0.79, 0.79))
@examples
def test_a_narrow_strip_has_the_depth_of_the_section(name: str, place: float) -> None:
    assume(all(abs(place - edge) > 1e-3 for edge in (*edges(name), ENDS[name], -ENDS[name])))
    near = 1e-4
    mean = ask(name, place - near, place + near)[8] / (2.0 * near)
    assert ask(name, place)[13] == pytest.approx(mean, rel=1e-4, abs=1e-9 * K)


# --- the law


@st.composite
def states(draw: st.DrawFn) -> tuple[float, tuple[float, float, float, float]]:
    """Return the damping, and opening, slope and their rates, in every regime."""
    lifted = 10.0 ** draw(st.floats(-7.0, -1.0))
    slope = draw(st.sampled_from([-1.0, 1.0])) * 2.0 * lifted / WIDTH
    opening = draw(st.floats(-1.5, 1.1)) * lifted
    if draw(st.booleans()):
        return 0.0, (opening, slope, 0.0, 0.0)
    damping = 10.0 ** draw(st.floats(-5.0, 0.0))
    speed = 10.0 ** draw(st.floats(-2.0, 2.0)) * lifted / damping
    turning = draw(st.floats(-1.0, 1.0)) * 2.0 * speed / WIDTH
    return damping, (opening, slope, draw(st.floats(-1.0, 1.0)) * speed, turning)


def force_of(eta: float, state: tuple[float, ...]) -> float:
    """Return N of the largest penetration and speed over the whole joint: that of full contact."""
    opening, slope, opening_rate, slope_rate = (abs(value) for value in state)
    return K * WIDTH**2 * (opening + 0.5 * WIDTH * slope + eta * (opening_rate + 0.5 * WIDTH * slope_rate))


@pytest.mark.parametrize("name", NAMES)
@given(case=states())
@examples
def test_forces_are_the_integral_of_the_pressure(name: str, case: tuple[float, tuple[float, ...]]) -> None:
    eta, state = case
    expected = resultants(name, eta, *state)
    scale = force_of(eta, state)
    found = ask(name, *state, damping=eta)
    assert found[0] == pytest.approx(expected[0], abs=1e-13 * scale)  # measured 3e-15
    assert found[1] == pytest.approx(expected[1], abs=1e-13 * scale * WIDTH)  # measured 1e-15
    assert found[0] >= 0.0


@pytest.mark.parametrize("name", NAMES)
@given(case=states())
@examples
def test_law_held_in_its_own_regime_is_the_law(name: str, case: tuple[float, tuple[float, ...]]) -> None:
    found = ask(name, *case[1], damping=case[0])
    assume(found[3] != OPEN)
    assert found[4:7] == pytest.approx(found[0:3], rel=1e-12, abs=0.0)


@pytest.mark.parametrize("name", NAMES)
@given(case=states())
@examples
def test_mirrored_state_gives_the_mirrored_forces_to_the_last_bit(
    name: str, case: tuple[float, tuple[float, ...]]
) -> None:
    eta, (opening, slope, opening_rate, slope_rate) = case
    force, moment, length = ask(name, opening, slope, opening_rate, slope_rate, damping=eta)[:3]
    mirrored = ask(name, opening, -slope, opening_rate, -slope_rate, damping=eta)[:3]
    assert tuple(mirrored) == (force, -moment, length)


@pytest.mark.parametrize("name", NAMES)
@given(case=states())
@examples
def test_forces_are_minus_the_gradient_of_the_energy(name: str, case: tuple[float, tuple[float, ...]]) -> None:
    opening, slope = case[1][:2]
    lifted = 0.5 * WIDTH * abs(slope) + abs(opening)
    change = 1e-5 * lifted
    turn = 2.0 * change / WIDTH
    by_opening = (ask(name, opening + change, slope)[7] - ask(name, opening - change, slope)[7]) / (2.0 * change)
    by_slope = (ask(name, opening, slope + turn)[7] - ask(name, opening, slope - turn)[7]) / (2.0 * turn)
    scale = K * WIDTH**2 * lifted
    found = ask(name, opening, slope)
    assert found[0] == pytest.approx(-by_opening, abs=2e-9 * scale)
    assert found[1] == pytest.approx(by_slope, abs=2e-9 * scale * WIDTH)


@pytest.mark.parametrize("name", [name for name in NAMES if name != "rectangle"])
@pytest.mark.parametrize("sign", [1.0, -1.0])
@pytest.mark.parametrize("boundary", [-1.0, 1.0])
def test_law_and_its_tangent_are_continuous_where_regimes_meet(name: str, sign: float, boundary: float) -> None:
    """Pass from full to partial contact, and from a sliver to none: the tangent jumps by nothing but curvature."""
    slope = 2e-4
    lifted = ENDS[name] * slope
    scale = K * WIDTH**2 * lifted * np.array([1.0, WIDTH])

    def near(distance: float) -> Array:
        return ask(name, boundary * lifted + distance, sign * slope)[:2]

    assert np.all(np.abs(near(1e-9 * lifted) - near(-1e-9 * lifted)) < 4e-9 * scale)
    for step in (1e-3 * lifted, 1e-5 * lifted):
        below, above = (near(0.0) - near(-step)) / step, (near(step) - near(0.0)) / step
        assert np.all(np.abs(above - below) < 3.0 * step / lifted * scale / lifted)


def test_uplift_of_a_circle_begins_at_the_kern() -> None:
    """Check that M = N R / 4 (theory.md section 10)."""
    radius = 0.5 * WIDTH
    slope = 1e-4
    force, moment, length = ask("circle", -slope * radius * (1.0 + 1e-14), slope)[:3]
    assert length == pytest.approx(WIDTH, rel=1e-12)
    assert moment / force == pytest.approx(radius / 4.0, rel=1e-13)
    assert ask("circle", -0.999 * slope * radius, slope)[2] < WIDTH


# --- columns


def drums(damping: float = 0.0, stiffness: float = 4e9, **joint: Any) -> Column:
    joints = Joint(stiffness, damping, **joint)
    return Column("drums", tuple(Block(4.5, 1.4, 1.4, 18000.0, joints, section="circle") for _ in range(3)))


SHAPES: list[dict[str, Any]] = [
    {},
    {"section": "annulus", "bore": 0.5},
    {"section": "strips", "strips": (0.7, 1.2, 0.7)},
    {"rim": 0.02},
    {"section": "rectangle", "width": 0.9, "depth": 0.9, "rim": 0.02},
]


@pytest.mark.parametrize("joint", SHAPES)
def test_an_undamped_column_that_rocks_keeps_its_energy(joint: dict[str, Any]) -> None:
    """Check that forces and kinetics agree with the energies of kinematics.py over dozens of openings."""
    column = drums(**joint)
    start = InitialState(rotation_rate=[0.05] * 3)
    stepper = Stepper(column.with_settings(tolerance=1e-8), start)
    chain = Chain(column)
    phase = stepper.arrays.state[at.CONTROL.beside :][:12]
    before = chain.energy(phase)
    stepper.advance(0.0, 1.0)
    assert stepper.counts.events > 10
    assert before > 0.0
    assert chain.energy(phase) == pytest.approx(before, rel=1e-6)


@pytest.mark.parametrize("joint", SHAPES)
def test_least_energy_of_a_joint_is_the_least_over_its_openings(joint: dict[str, Any]) -> None:
    column = drums(**joint)
    chain = Chain(column)
    for turn in (0.0, 1e-5, 1e-4, 1e-3, 1e-2, 0.1):
        weight = 36000.0 * column.g * math.cos(0.5 * turn)
        slope = 2.0 * math.sin(0.5 * turn)

        def energy(opening: float, weight: float = weight, slope: float = slope) -> float:
            return float(chain.elastic(np.full(3, opening), np.full(3, slope))[1]) + weight * opening

        settled = 36000.0 * column.g / column.springs[1]
        found = minimize_scalar(
            energy, bounds=(-3.0 * settled - slope, slope), method="bounded", options={"xatol": 1e-12}
        )
        expected = float(found.fun) + 0.5 * 36000.0 * column.g * settled
        scale = 36000.0 * column.g * (settled + slope)
        assert float(chain.joint_energy(1, np.array([[turn]]), np.zeros(1))[0, 0]) == pytest.approx(
            expected, abs=1e-9 * scale
        )


def test_barrier_of_a_stiff_round_block_is_the_rise_of_its_centroid_to_above_its_rim() -> None:
    block = Block(14.0, 1.5, 1.5, 6e4, Joint(1e13, 0.0), section="circle")
    rise = math.hypot(7.0, 0.75) - 7.0
    energy = barrier(Column("one", (block,))).energy / (6e4 * 9.80665 * rise)
    assert 0.99 < energy <= 1.0


def test_modes_of_a_round_block_are_those_of_its_springs() -> None:
    block = Block(6.0, 1.5, 1.5, 2e4, Joint(2e9, 0.0), section="circle")
    column = Column("one", (block,))
    up = 2e9 * math.pi * 0.75**2
    assert natural_frequencies(column)[1] == pytest.approx(math.sqrt(up / 2e4) / (2.0 * math.pi), rel=1e-6)
    turning = 2e9 * math.pi * 0.75**4 / 4.0
    about = block.resolved_inertia + 2e4 * (3.0 - 0.5 * 2e4 * column.g / up) ** 2
    spread = 2e4 * column.g * (3.0 - 0.25 * 2e4 * column.g / up)
    expected = math.sqrt((turning - spread) / about) / (2.0 * math.pi)
    assert natural_frequencies(column)[0] == pytest.approx(expected, rel=1e-6)


def test_implicit_and_explicit_steps_of_a_round_column_lead_to_the_same_motion() -> None:
    column = Column("d", tuple(Block(0.5, 1.5, 1.5, 2300.0, Joint(4e9, 0.02), section="circle") for _ in range(12)))
    motion = Motion.harmonic(1.0, 1.5, 1.0)
    implicit = simulate(column, motion, tolerance=1e-4)
    explicit = simulate(column, motion, tolerance=1e-7, without=("implicit",))
    assert implicit.stats["implicit_steps"] > 0.2 * implicit.stats["steps"]
    assert np.max(np.abs(implicit.ux - explicit.ux)) < 1e-4 * explicit.peak_top_ux[0]
