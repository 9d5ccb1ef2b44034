"""Eight columns at once: lanes hold what each column has on its own."""

from __future__ import annotations

import contextlib
import math
from collections.abc import Callable
from dataclasses import astuple, replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from support.columns import in_strips, off_axis_column, random_drums, rough, sliding_column
from support.joint_states import State, examples, states
from support.joints import joint_forces
from support.lanes import accelerate, accelerating, in_lanes
from support.probe import Array, random_column, random_state, sliding_state

from solver import Column, InputError
from solver.kernels.column.batch.runs import (
    RIMMED_SPACE,
    ROUND_SLIPPING_SPACE,
    ROUND_SPACE,
    SLIPPING_SPACE,
    SPACE,
    STRIPPED_SPACE,
)
from solver.kernels.column.joint.law import joint_forces_in_lanes, resultants
from solver.kernels.column.sections.strips import strips_part, strips_part_in_lanes
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.lanes import (
    WIDTH,
    any_of,
    bits,
    greater,
    lane,
    lesser,
    magnitude,
    nearest,
    square_root,
    where,
)
from solver.kernels.numba_ext.numbers import angle_of, half_sine_cosine, sine, sine_cosine
from solver.kernels.numba_ext.views import Space, lanes_of, row_of
from solver.models.column.packing import pack_model

_model, _work, _round = at.MODEL.over, at.WORK.over, ROUND_SPACE.over


# --- the joint


@from_python
def law_in_lanes(given: Array, found: Array) -> None:
    """Return `joint_forces_in_lanes` of eight joints, (8 arguments, 8 lanes), to (3, 8); both flat."""
    g, f = lanes_of(given), lanes_of(found)
    half = 0.5 * g[1]
    f[0], f[1], f[2] = joint_forces_in_lanes(-half, half, g[0] * g[2], g[3], g[4], g[5], g[6], g[7])


def assert_lanes_say_what_branches_say(eight: list[State]) -> None:
    given = np.array([astuple(state) for state in eight])
    found = np.zeros((3, WIDTH))
    law_in_lanes(np.ascontiguousarray(given.T).reshape(-1), found.reshape(-1))
    expected = np.array([joint_forces(*arguments) for arguments in given.tolist()]).T
    assert np.array_equal(found, expected)


@given(eight=st.lists(states(), min_size=WIDTH, max_size=WIDTH))
@examples
def test_law_in_lanes_is_the_law_to_the_last_bit(eight: list[State]) -> None:
    assert_lanes_say_what_branches_say(eight)


def test_law_in_lanes_is_the_law_on_the_boundaries_of_its_regimes() -> None:
    """Compare parallel faces, faces that touch, edges at a corner, dampers that just pull, none at all."""
    width, values = 1.5, (-0.75e-3, 0.0, 0.75e-3)
    eight = [
        State(5e9, width, 1.2, damping, opening, slope, opening_rate, slope_rate)
        for damping in (0.0, 1e-2)
        for opening in values
        for slope in (-1e-3, 0.0, 1e-3)
        for opening_rate in (-0.075, 0.0, 0.075)
        for slope_rate in (-0.1, 0.0, 0.1)
    ]
    eight += eight[: -len(eight) % WIDTH]
    for k in range(0, len(eight), WIDTH):
        assert_lanes_say_what_branches_say(eight[k : k + WIDTH])


# --- sections


@from_python
def forces(n: int, model: Array, work: Array, given: Array, found: Array) -> None:
    """Return `resultants` of the joints of one column; given: opening, slope and their rates of each, (n, 4), flat."""
    blocks, hold = _model(row_of(model), n).blocks, _work(row_of(work), n).hold
    for i in range(n):
        g = 4 * i
        normal, moment, length = resultants(blocks, hold, i, given[g], given[g + 1], given[g + 2], given[g + 3])
        found[3 * i], found[3 * i + 1], found[3 * i + 2] = normal, moment, length


@from_python
def forces_in_lanes(n: int, buffer: Array, given: Array, found: Array) -> None:
    """Return the same of eight columns."""
    space, rows, results = _round(lanes_of(buffer), n), lanes_of(given), lanes_of(found)
    blocks, hold = space.model.blocks, space.work.hold
    for i in range(n):
        g = 4 * i
        normal, moment, length = resultants(blocks, hold, i, rows[g], rows[g + 1], rows[g + 2], rows[g + 3])
        results[3 * i], results[3 * i + 1], results[3 * i + 2] = normal, moment, length


@pytest.mark.parametrize("largest", [0.0, 1e-5, 1e-3, 0.3])
def test_law_of_round_joints_in_lanes_is_the_law_to_the_last_bit(largest: float) -> None:
    """Compare full contact, parts, slivers and none, with and without dampers, sections mixed in any way."""
    n = 40
    buffer = np.zeros((ROUND_SPACE.size(n), WIDTH))
    given, found, expected = np.zeros((WIDTH, 4 * n)), np.zeros((3 * n, WIDTH)), np.zeros((WIDTH, 3 * n))
    for k in range(WIDTH):
        rng = np.random.default_rng(k)
        column = random_drums(rng, n)
        model = pack_model(column)[: at.MODEL.size(n)]
        half = np.array([0.5 * block.joint_width for block in column.blocks])
        slope = rng.uniform(-largest, largest, n) * rng.choice([0.0, 1.0, 1.0], n)
        edge = half * rng.choice([-1.0, -0.999999, 0.0, 1.0, rng.uniform(-2.0, 2.0)], n)  # where the faces part
        opening = np.where(slope == 0.0, rng.choice([-1e-4, 0.0, 1e-4], n), edge * slope)
        rates = rng.normal(size=(n, 2)) * rng.choice([0.0, 0.01, 1.0], (n, 2))
        given[k] = np.column_stack([opening, slope, rates]).ravel()
        buffer[: at.MODEL.size(n), k] = model
        forces(n, model.copy(), np.zeros(at.WORK.size(n)), given[k], expected[k])
    forces_in_lanes(n, buffer.reshape(-1), in_lanes(given), found.reshape(-1))
    assert np.array_equal(found, expected.T)
    lengths = expected[:, 2::3]
    assert np.any(lengths == 0.0)
    assert np.any(lengths > 0.0)


@from_python
def parts(strips: Array, ends: Array, found: Array) -> None:
    """Return `strips_part` of one section: middle, area and moments of the part between two ends."""
    found[0], found[1], found[2], found[3] = strips_part(row_of(strips), ends[0], ends[1])


@from_python
def parts_in_lanes(strips: Array, ends: Array, found: Array) -> None:
    """Return `strips_part_in_lanes` for eight sections."""
    rows, results = lanes_of(ends), lanes_of(found)
    results[0], results[1], results[2], results[3] = strips_part_in_lanes(lanes_of(strips), rows[0], rows[1])


@pytest.mark.parametrize("alike", [True, False])
def test_parts_in_lanes_are_those_of_each_to_the_last_bit_and_mirror_images_mirrored(alike: bool) -> None:
    """Compare whole sections, parts, slivers and none; as many strips in each lane or not, and none in one of them."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        counts = (
            np.full(WIDTH, rng.integers(1, at.MOST_STRIPS + 1)) if alike else rng.integers(1, at.MOST_STRIPS + 1, WIDTH)
        )
        counts[3] = 0
        strips, expected, found = np.zeros((WIDTH, at.STRIP_NUMBERS)), np.zeros((WIDTH, 4)), np.zeros((4, WIDTH))
        ends = np.sort(rng.uniform(-0.9, 0.9, (WIDTH, 2)), axis=1)
        ends[0], ends[1, 1], ends[2] = (-2.0, 2.0), ends[1, 0] + 1e-9, ends[2, ::-1]
        for k, count in enumerate(counts):
            strips[k, :2] = count, 1.6 / max(count, 1)
            strips[k, 2 : 2 + count] = rng.uniform(0.0, 2.0, count)
            parts(strips[k].copy(), ends[k].copy(), expected[k])
        parts_in_lanes(in_lanes(strips), in_lanes(ends), found.reshape(-1))
        assert np.array_equal(found, expected.T)
        assert expected[0, 1] == pytest.approx(1.6 / counts[0] * np.sum(strips[0, 2:]), rel=1e-14)
        mirrored = strips.copy()
        for k, count in enumerate(counts):
            mirrored[k, 2 : 2 + count] = strips[k, 2 : 2 + count][::-1]
        image = np.zeros((4, WIDTH))
        parts_in_lanes(in_lanes(mirrored), in_lanes(-ends[:, ::-1]), image.reshape(-1))
        assert np.array_equal(image, found * np.array([[-1.0], [1.0], [-1.0], [1.0]]))


# --- accelerations


def in_strips_where_it_stands(rng: np.random.Generator, n: int) -> Column:
    """Return strips, lenses, straight cuts and whole faces side by side."""
    while True:
        column = in_strips(rough(random_drums(rng, n), rng), rng)
        with contextlib.suppress(InputError):  # with an edge gone it may not stand
            pack_model(column)
            return column


def in_rims_where_it_stands(rng: np.random.Generator, n: int) -> Column:
    """Return rims of drums, rings and rectangles, beside strips and whole faces."""
    while True:
        drawn = sliding_column(rng, n)
        if rng.random() < 0.7:
            drawn = in_strips(rough(random_drums(rng, n), rng), rng, 0.2)
        blocks = []
        for block in drawn.blocks:
            plain = block.joint.section == "strips" or rng.random() < 0.2
            rim = None if plain else float(rng.uniform(0.01, 0.2)) * block.joint_width
            blocks.append(replace(block, joint=replace(block.joint, rim=rim)))
        with contextlib.suppress(InputError):
            column = replace(drawn, blocks=tuple(blocks))
            pack_model(column)
            return column


Draw = Callable[[np.random.Generator, int], Column]
# of each kind of lanes, and columns that they are drawn from
KINDS: dict[str, tuple[Space, Draw]] = {
    "plain": (SPACE, lambda rng, n: random_column(rng, n, damped=bool(rng.random() < 0.5))),
    "round": (ROUND_SPACE, random_drums),
    "slipping": (SLIPPING_SPACE, sliding_column),
    "off axis": (SLIPPING_SPACE, off_axis_column),
    "round, slipping": (ROUND_SLIPPING_SPACE, lambda rng, n: rough(random_drums(rng, n), rng)),
    "strips, slipping": (STRIPPED_SPACE, in_strips_where_it_stands),
    "rims, slipping": (RIMMED_SPACE, in_rims_where_it_stands),
}
EVERY_DAY = ("plain",)  # the others compile as much again, or twice as much
each_kind = pytest.mark.parametrize(
    "kind", [pytest.param(kind, marks=() if kind in EVERY_DAY else pytest.mark.long) for kind in KINDS]
)
accelerations_of = {space: accelerating(space) for space, _ in KINDS.values()}


def eight_columns(kind: str, n: int) -> tuple[Array, Array, Array]:
    """Return (models, phases, motions of the base) of eight columns that move, (8, length) each."""
    _, draw = KINDS[kind]
    models, phases, motions = [], [], []
    for seed in range(WIDTH):
        rng = np.random.default_rng([seed, n])
        column, largest, zeros = draw(rng, n), 10.0 ** rng.uniform(-4.0, -0.3), np.zeros(n)
        models.append(pack_model(column)[: at.MODEL.size(n)])
        if column.has_slips:
            q, rate, direction = sliding_state(rng, column, largest)
        else:
            (q, rate), direction = random_state(rng, column, largest), zeros
            q, rate = np.append(q, zeros), np.append(rate, zeros)
        phase = [q[: 2 * n], rate[: 2 * n], zeros, zeros, q[2 * n :], zeros, rate[2 * n :], zeros, zeros, direction]
        phase += [zeros] * 3  # no bonds
        phases.append(np.concatenate(phase))
        motions.append(rng.uniform(-1.0, 1.0, 5) * [column.g, column.g, 1.0, 2.0, 10.0])
    return np.array(models), np.array(phases), np.array(motions)


def named(phase: Any, joints: Any, slips: bool) -> dict[str, Array]:
    """Return the accelerations, and the resultants of the joints."""
    found = {name: getattr(phase, f"{name}_acceleration") for name in ("theta", "opening", *(("slip",) * slips))}
    names = ("normal", "moment", "tangential", *(("pressure_shear", "overcome", "shear_capacity") * slips))
    return found | {name: getattr(joints, name) for name in names}


def found_in_lanes(kind: str, n: int, models: Array, phases: Array, motions: Array) -> dict[str, Array]:
    """Return the same quantities from lanes, (n, 8) each."""
    space, _ = KINDS[kind]
    buffer = np.zeros((space.size(n), WIDTH))
    seen, place = space.see(buffer, n), space.size(n) - at.WORK.size(n)  # where `start` is, the first of the work
    buffer[: at.MODEL.size(n)], buffer[place : place + at.PHASE.size(n)] = models.T, phases.T
    seen.work.joints.sliding[:] = at.PHASE.see(phases.T, n).sliding
    accelerations_of[space](n, buffer.reshape(-1), in_lanes(motions))
    return named(seen.work.start, seen.work.joints, space not in (SPACE, ROUND_SPACE))


@pytest.mark.long  # takes seconds
@each_kind
@pytest.mark.parametrize("n", [1, 3, 5])
def test_accelerations_in_lanes_are_those_of_each_column(kind: str, n: int) -> None:
    """Compare with those of one column, which other tests compare with Lagrange's equations."""
    models, phases, motions = eight_columns(kind, n)
    found = found_in_lanes(kind, n, models, phases, motions)
    slips = "slip" in found
    for k in range(WIDTH):
        phase, work = phases[k].copy(), np.zeros(at.WORK.size(n))
        alone = at.WORK.see(work, n).joints
        alone.sliding[:] = at.PHASE.see(phase, n).sliding
        accelerate(n, models[k].copy(), phase, work, motions[k].copy())
        expected = named(at.PHASE.see(phase, n), alone, slips)
        accelerations = [name for name in expected if name in ("theta", "opening", "slip")]
        largest = max(float(np.max(np.abs(expected[name]))) for name in accelerations)
        for name, wanted in expected.items():
            size = largest if name in accelerations else max(1.0, float(np.max(np.abs(wanted))))
            # without slips measured 2.3e-16 of accelerations, 1.3e-15 of forces: sine and cosine of the base's rotation
            within = 1e-13 if slips else 1e-15 if name in accelerations else 4e-15
            assert found[name][:, k] == pytest.approx(wanted, abs=within * size), name


@each_kind
def test_a_lane_has_the_same_bits_whatever_is_in_the_others(kind: str) -> None:
    rows = eight_columns(kind, 3)
    found = found_in_lanes(kind, 3, *rows)
    turned = np.roll(np.arange(WIDTH), 3)
    for order in (turned, np.zeros(WIDTH, dtype=int)):  # in other lanes; the first column in all of them
        for name, other in found_in_lanes(kind, 3, *(part[order] for part in rows)).items():
            assert np.array_equal(other, found[name][:, order]), name


# --- functions


@from_python
def sines_in_lanes(count: int, x: Array, sines: Array, cosines: Array, only: Array) -> None:
    """Return `sine_cosine` and `sine` of `count` lanes."""
    xs, s, c, o = lanes_of(x), lanes_of(sines), lanes_of(cosines), lanes_of(only)
    for k in range(count):
        s[k], c[k] = sine_cosine(xs[k])
        o[k] = sine(xs[k])


def units(found: Array, function: Callable[[float], float], x: Array) -> float:
    """Return the largest difference from a function of math, in its units in the last place."""
    expected = np.array([function(value) for value in x])
    return float(np.max(np.abs(found - expected) / np.spacing(np.abs(expected))))


@pytest.mark.parametrize("largest", [0.03, 0.8, 100.0])
def test_sine_and_cosine_in_lanes_are_those_of_math(largest: float) -> None:
    x = np.random.default_rng(1).uniform(-largest, largest, 80000)
    sines, cosines, only = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, x, sines, cosines, only)
    assert units(sines, math.sin, x) <= 1.0  # measured 1
    assert units(cosines, math.cos, x) <= 1.0  # measured 1
    assert np.array_equal(only, sines)
    mirrored, even = np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, -x, mirrored, even, only)
    assert np.array_equal(mirrored, -sines)
    assert np.array_equal(even, cosines)


def test_sine_and_cosine_in_lanes_about_the_multiples_of_a_quarter_turn() -> None:
    """Check that the reduction loses most there: the sine or the cosine is next to nothing."""
    x = np.repeat(np.arange(-64.0, 64.0), 8) * 0.5 * math.pi
    x += np.tile([0.0, 1e-15, 1e-9, 1e-3, -1e-9, -1e-3, 0.785, -0.785], 128)
    sines, cosines, only = np.zeros_like(x), np.zeros_like(x), np.zeros_like(x)
    sines_in_lanes(x.size // WIDTH, x, sines, cosines, only)
    assert sines == pytest.approx(np.sin(x), abs=2e-16)  # measured 1.1e-16
    assert cosines == pytest.approx(np.cos(x), abs=2e-16)


@from_python
def halves(count: int, x: Array, found: Array) -> None:
    """Return the sine and cosine of half of each of `count` times eight numbers, in lanes and one by one, each in two
    ways.
    """
    xs, f, numbers, one_by_one = lanes_of(x), lanes_of(found), row_of(x), row_of(found)
    for k in range(count):
        f[k], f[count + k] = half_sine_cosine(xs[k])
        f[2 * count + k], f[3 * count + k] = sine_cosine(0.5 * xs[k])
    size = 8 * count
    for k in range(size):
        one_by_one[4 * size + k], one_by_one[5 * size + k] = half_sine_cosine(numbers[k])
        one_by_one[6 * size + k], one_by_one[7 * size + k] = sine_cosine(0.5 * numbers[k])


@pytest.mark.parametrize("largest", [0.1, 10.0])
def test_sine_and_cosine_of_a_half_are_those_to_the_last_bit(largest: float) -> None:
    x = np.linspace(-largest, largest, 1024)
    found = np.zeros((8, x.size))
    halves(x.size // WIDTH, x, found.reshape(-1))
    assert np.array_equal(found[[0, 1, 4, 5]], found[[2, 3, 6, 7]])


@from_python
def functions_in_lanes(x: Array, y: Array, found: Array) -> int:
    """Return all functions of lanes.py, of eight numbers each."""
    a, b, f = lanes_of(x)[0], lanes_of(y)[0], lanes_of(found)
    f[0], f[1], f[2], f[3], f[4] = magnitude(a), square_root(magnitude(a)), lesser(a, b), greater(a, b), nearest(a)
    f[5] = where((a > b) & ~(b == 0.0) | (a <= -1.0), a, 2)
    for k in range(8):
        f[6] = f[6] + lane(a, k) if any_of(a > b) else f[6]
    return bits(a < b)


def test_functions_of_lanes_are_those_of_numpy() -> None:
    x = np.array([-2.5, -1.0, -0.0, 0.4, 1.5, 2.5, 3.5, 1e9])
    y = np.array([1.0, -1.0, 0.0, 0.3, 7.0, 0.0, -3.5, 2e9])
    found = np.zeros((7, WIDTH))
    said = functions_in_lanes(x, y, found.reshape(-1))
    assert said == sum(1 << k for k in range(WIDTH) if x[k] < y[k])
    expected = [np.abs(x), np.sqrt(np.abs(x)), np.minimum(x, y), np.maximum(x, y), np.rint(x)]
    expected += [np.where(((x > y) & (y != 0.0)) | (x <= -1.0), x, 2.0), np.full(WIDTH, np.cumsum(x)[-1])]
    assert np.array_equal(found, np.array(expected))


@from_python
def angles(sine: Array, cosine: Array, alone: Array, together: Array) -> None:
    """Return `angle_of` of numbers one by one and in lanes."""
    s, c, found = lanes_of(sine), lanes_of(cosine), lanes_of(together)
    for k in range(sine.size):
        alone[k] = angle_of(sine[k], cosine[k])
    for k in range(sine.size // WIDTH):
        found[k] = angle_of(s[k], c[k])


def test_angles_are_those_of_math() -> None:
    wanted = np.concatenate([np.linspace(0.0, 0.5 * math.pi, 8000), np.geomspace(1e-12, 1.0, 8000)])
    sine, cosine = np.sin(wanted), np.cos(wanted)
    alone, together = np.zeros_like(wanted), np.zeros_like(wanted)
    angles(sine, cosine, alone, together)
    expected = np.arctan2(sine, cosine)
    assert np.max(np.abs(alone - expected) / np.spacing(expected + 1e-300)) <= 2.0  # measured 2
    assert np.array_equal(alone, together)
