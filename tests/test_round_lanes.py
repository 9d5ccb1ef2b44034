"""Columns with round joints, eight at once: the law, `simulate`, the same bits whoever passes beside."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from probe import Array, G, phocas, random_column, random_state
from test_lanes import accelerate, in_lanes
from test_sliding import sliding_state
from test_slipping_lanes import shaken
from test_verdict import models_of

from solver import Block, Column, Joint, Motion, Settings, simulate, simulate_many
from solver.batch import BatchResult, fall_angles, run_batch
from solver.chain import Chain
from solver.kernels import layout as at
from solver.kernels.batch.runs import ROUND_SLIPPING_SPACE, ROUND_SPACE
from solver.kernels.formulations.exact import Motion as BaseMotion
from solver.kernels.formulations.exact import exact_accelerations
from solver.kernels.jit import from_python
from solver.kernels.joint.law import resultants
from solver.kernels.lanes import WIDTH
from solver.kernels.numbers import angle_of
from solver.kernels.views import lanes_of, row_of
from solver.packing import pack_model
from solver.rest import is_stable
from solver.single_run import single_run
from solver.verdict import GRAZED, SHARES, Barriers, barrier, is_held, least_energies

RECORDS = ("elcentro-1940-ns.AT2", "northridge-1994-arleta-360.AT2", "kobe-1995-nishi-akashi-090.AT2")
SECTIONS = ("circle", "annulus", "rectangle")
_model, _work, _space, _slipping_space = at.MODEL.over, at.WORK.over, ROUND_SPACE.over, ROUND_SLIPPING_SPACE.over


def random_drums(rng: np.random.Generator, n: int, softest: float = 1e6) -> Column:
    """A random column of which every joint is a circle, an annulus or a rectangle."""
    blocks = []
    for block in random_column(rng, n, softest=softest).blocks:
        section = str(rng.choice(SECTIONS))
        bore = rng.uniform(0.1, 0.9) * block.joint_width if section == "annulus" else None
        blocks.append(replace(block, joint=replace(block.joint, section=section, bore=bore)))
    return Column("drums", tuple(blocks), g=rng.uniform(1.0, 15.0))


def rough(column: Column, rng: np.random.Generator) -> Column:
    """The same with friction in every joint, its blocks as round as their joints or not."""
    blocks = []
    for block in column.blocks:
        joint = replace(block.joint, friction=float(rng.uniform(0.1, 0.6)))
        section = "circle" if rng.random() < 0.5 else str(joint.section)
        bore = joint.bore if section == "annulus" else None
        blocks.append(replace(block, joint=joint, section=section, bore=bore))
    return replace(column, blocks=tuple(blocks))


# --- the law


@from_python
def angles(sine: Array, cosine: Array, alone: Array, together: Array) -> None:
    """`angle_of` of numbers one by one and in lanes."""
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


@from_python
def forces(n: int, model: Array, work: Array, given: Array, found: Array) -> None:
    """`resultants` of the joints of one column; given: opening, slope and their rates of each, (n, 4), flat."""
    blocks, hold = _model(row_of(model), n).blocks, _work(row_of(work), n).hold
    for i in range(n):
        g = 4 * i
        normal, moment, length = resultants(blocks, hold, i, given[g], given[g + 1], given[g + 2], given[g + 3])
        found[3 * i], found[3 * i + 1], found[3 * i + 2] = normal, moment, length


@from_python
def forces_in_lanes(n: int, buffer: Array, given: Array, found: Array) -> None:
    """The same of eight columns."""
    space, rows, results = _space(lanes_of(buffer), n), lanes_of(given), lanes_of(found)
    blocks, hold = space.model.blocks, space.work.hold
    for i in range(n):
        g = 4 * i
        normal, moment, length = resultants(blocks, hold, i, rows[g], rows[g + 1], rows[g + 2], rows[g + 3])
        results[3 * i], results[3 * i + 1], results[3 * i + 2] = normal, moment, length


@pytest.mark.parametrize("largest", [0.0, 1e-5, 1e-3, 0.3])
def test_law_in_lanes_is_the_law_to_the_last_bit(largest: float) -> None:
    """All contact, parts, slivers and none, with and without dampers, sections mixed in any way."""
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
def accelerate_lanes(n: int, buffer: Array, base: Array) -> None:
    """`exact_accelerations` of work.start of eight columns; base: ax, az, theta, omega, alpha."""
    b, space = lanes_of(base), _space(lanes_of(buffer), n)
    motion, work = BaseMotion(b[0], b[1], b[2], b[3], b[4]), space.work
    exact_accelerations(space.model, work.start, motion, work.joints, work.hold, work.room)


@pytest.mark.parametrize("n", [1, 3, 10])
def test_accelerations_are_those_of_each_column(n: int) -> None:
    buffer = np.zeros((ROUND_SPACE.size(n), WIDTH))
    models, phases, motions = [], [], []
    for k in range(WIDTH):
        rng = np.random.default_rng([k, n])
        column = random_drums(rng, n)
        q, rate = random_state(rng, column, 10.0 ** rng.uniform(-4.0, -0.5))
        models.append(pack_model(column)[: at.MODEL.size(n)])
        phases.append(np.concatenate([q, rate, np.zeros(2 * n)]))
        motions.append(rng.uniform(-1.0, 1.0, 5) * [column.g, column.g, 1.0, 2.0, 10.0])
    buffer[: at.MODEL.size(n)] = np.array(models).T
    place = buffer.shape[0] - at.WORK.size(n)  # where `start` is, the first of the work
    buffer[place : place + 6 * n] = np.array(phases).T
    accelerate_lanes(n, buffer.reshape(-1), in_lanes(np.array(motions)))
    for k in range(WIDTH):
        phase = phases[k].copy()
        accelerate(n, models[k].copy(), phase, np.zeros(at.WORK.size(n)), motions[k].copy())
        expected = phase[4 * n :]
        # measured 2.3e-16, of the sine and cosine of the base's rotation
        found = buffer[place + 4 * n : place + 6 * n, k]
        assert found == pytest.approx(expected, abs=1e-15 * np.max(np.abs(expected)))


# --- beside single runs


def shaft(eta: float, drums: int = 3, **settings: float) -> Column:
    """A round shaft 9 m high."""
    block = Block(9.0 / drums, 1.2, 1.2, 27000.0 / drums, Joint(3e9, eta), section="circle")
    return Column("shaft", (block,) * drums, Settings(**settings))  # type: ignore[arg-type]


def parts_of(result: BatchResult, k: int) -> list[Array]:
    return [result.peak_ux[k], result.steps[k], result.ends[k], result.phases[k]]


@from_python
def accelerate_slipping(n: int, buffer: Array, base: Array) -> None:
    """As `accelerate_lanes`, of columns with slips."""
    b, space = lanes_of(base), _slipping_space(lanes_of(buffer), n)
    motion, work = BaseMotion(b[0], b[1], b[2], b[3], b[4]), space.work
    exact_accelerations(space.model, work.start, motion, work.joints, work.hold, work.room)


@pytest.mark.parametrize("n", [1, 2, 5])
def test_accelerations_of_columns_that_slide_are_those_of_each(n: int) -> None:
    """Lenses, straight cuts and whole faces side by side."""
    buffer = np.zeros((ROUND_SLIPPING_SPACE.size(n), WIDTH))
    space = ROUND_SLIPPING_SPACE.see(buffer, n)  # names over rows of lanes
    models, phases, motions = [], [], []
    for k in range(WIDTH):
        rng = np.random.default_rng([k, n])
        column = rough(random_drums(rng, n), rng)
        q, rate, direction = sliding_state(rng, column, 10.0 ** rng.uniform(-4.0, -0.5))
        zeros = np.zeros(n)
        parts = [q[: 2 * n], rate[: 2 * n], zeros, zeros, q[2 * n :], zeros, rate[2 * n :], zeros, zeros, direction]
        models.append(pack_model(column)[: at.MODEL.size(n)])
        phases.append(np.concatenate(parts))
        motions.append(rng.uniform(-1.0, 1.0, 5) * [column.g, column.g, 1.0, 2.0, 10.0])
        space.work.joints.sliding[:, k] = direction
    buffer[: at.MODEL.size(n)] = np.array(models).T
    place = buffer.shape[0] - at.WORK.size(n)
    buffer[place : place + at.PHASE.size(n)] = np.array(phases).T
    accelerate_slipping(n, buffer.reshape(-1), in_lanes(np.array(motions)))
    for k in range(WIDTH):
        phase, work = phases[k].copy(), np.zeros(at.WORK.size(n))
        alone = at.WORK.see(work, n)
        alone.joints.sliding[:] = at.PHASE.see(phase, n).sliding
        accelerate(n, models[k].copy(), phase, work, motions[k].copy())
        expected, found = at.PHASE.see(phase, n), space.work.start
        names = ("theta_acceleration", "opening_acceleration", "slip_acceleration")
        largest = max(np.max(np.abs(getattr(expected, name))) for name in names)
        for name in names:  # as far as those of rectangles
            assert getattr(found, name)[:, k] == pytest.approx(getattr(expected, name), abs=1e-13 * largest), name
        for name in ("normal", "moment", "tangential", "drift", "bearable"):
            wanted = getattr(alone.joints, name)
            scale = 1e-13 * max(1.0, float(np.max(np.abs(wanted))))
            assert getattr(space.work.joints, name)[:, k] == pytest.approx(wanted, abs=scale), name


@pytest.mark.long  # compiles the lanes, as all below
def test_what_comes_of_a_run_depends_on_no_other_nor_on_order_and_threads() -> None:
    columns, motions = [], []
    for seed in range(11):
        rng = np.random.default_rng(seed)
        block = Block(3.0, 1.2, 1.2, 9000.0, Joint(3e9, 2e-3), section=SECTIONS[seed % 3])
        columns.append(Column("three", (replace(block, bore=0.5) if seed % 3 == 1 else block,) * 3))
        motions.append(Motion.harmonic(rng.uniform(0.05, 0.15) * G, rng.uniform(1.0, 3.0), 1.0 + 0.1 * seed))
    times = np.array([0.0, 0.5, 0.7])
    together = run_batch(columns, motions, times=times)
    order = np.random.default_rng(1).permutation(len(columns))
    shuffled = run_batch([columns[k] for k in order], [motions[k] for k in order], times=times, threads=2)
    for place, k in enumerate(order):
        alone = run_batch([columns[k]], [motions[k]], times=times)  # a rectangle: in lanes of rectangles
        for one, other, third in zip(parts_of(together, k), parts_of(shuffled, place), parts_of(alone, 0), strict=True):
            assert np.array_equal(one, other)
            assert np.array_equal(one, third)


@pytest.mark.long
@pytest.mark.parametrize("n", [1, 3])
def test_the_tolerance_is_kept_within_ten_times(n: int, records: Path) -> None:
    """Tops, of runs that amplify a change of the motion by less than 100."""
    duration, times = 8.0, np.linspace(0.0, 7.95, 160)
    files = [Motion.from_at2(records / name) for name in RECORDS]
    columns: list[Column] = []
    motions: list[Motion] = []
    for k in range(9):
        rng = np.random.default_rng([k, n])
        width, slender = rng.uniform(0.8, 1.6), rng.uniform(4.0, 8.0)
        section = SECTIONS[k % 2]
        joint = Joint(10.0 ** rng.uniform(8.5, 9.5), 10.0 ** rng.uniform(-3.0, -2.3))
        height = slender * width / n
        block = Block(height, width, width, 2400.0 * height * width**2, joint, section=section)
        columns.append(Column("random", (replace(block, bore=0.4 * width) if section == "annulus" else block,) * n))
        motions.append(files[k % 3].scaled_to(rng.uniform(1.0, 2.5) / slender * G))

    def alone(k: int, factor: float) -> Array:
        column = columns[k].with_settings(tolerance=1e-9, without=("peaks",))
        _, phases = single_run(column, motions[k].scaled(factor), duration, motions[k].start + times, None, 0.0)
        return Chain(column).top_displacements(phases)

    truth = [alone(k, 1.0) for k in range(len(columns))]
    sizes = [np.max(np.abs(ux)) for ux in truth]
    tame = [np.max(np.abs(alone(k, 1.0 + 1e-7) - truth[k])) < 1e-5 * sizes[k] for k in range(len(columns))]
    assert sum(tame) >= 6
    for tolerance in (1e-3, 1e-5):
        result = run_batch(columns, motions, [duration] * len(columns), tolerance=tolerance, times=times)
        assert np.all(result.finished)
        for k in np.flatnonzero(tame).tolist():
            error = np.max(np.abs(Chain(columns[k]).top_displacements(result.phases[k]) - truth[k]))
            assert error <= 10.0 * tolerance * sizes[k]


def slid(seed: int, n: int, count: int, off_axis: bool, records: Path) -> tuple[list[Column], list[Motion]]:
    """Round columns that slide, or are off their axis, under records that make them rock or slide."""
    columns, motions = shaken(seed, n, count, off_axis, records)
    drums = []
    for k, column in enumerate(columns):
        bore = 0.3 * column.blocks[0].width if k % 2 else None
        section = "annulus" if k % 2 else "circle"
        blocks = (replace(block, section=section, bore=bore, mass=0.75 * block.mass) for block in column.blocks)
        drums.append(replace(column, blocks=tuple(blocks)))
    stand = [k for k, column in enumerate(drums) if is_stable(column)]
    return [drums[k] for k in stand], [motions[k] for k in stand]


@pytest.mark.long
@pytest.mark.parametrize("off_axis", [False, True])
@pytest.mark.parametrize("n", [1, 3])
def test_the_tolerance_is_kept_by_round_columns_that_slide(n: int, off_axis: bool, records: Path) -> None:
    """Tops and slips, as in test_slipping_lanes.py."""
    duration, times = 8.0, np.linspace(0.0, 7.95, 160)
    columns, motions = slid(2, n, 10, off_axis, records)
    chains = [Chain(column) for column in columns]

    def alone(k: int, factor: float) -> tuple[Array, Array]:
        motion = motions[k].scaled(factor)
        column = columns[k].with_settings(tolerance=1e-9, without=("peaks",))
        _, phases = single_run(column, motion, duration, motion.start + times, None, 0.0)
        return chains[k].top_displacements(phases), phases[:, 4 * n : 5 * n]

    truth = [alone(k, 1.0) for k in range(len(columns))]
    sizes = [np.max(np.abs(ux)) for ux, _ in truth]
    tame = [np.max(np.abs(alone(k, 1.0 + 1e-7)[0] - truth[k][0])) < 1e-5 * sizes[k] for k in range(len(columns))]
    assert sum(tame) >= 5
    assert sum(float(np.ptp(slip)) > 1e-3 for _, slip in truth) >= 3
    for tolerance in (1e-3, 1e-5):
        result = run_batch(columns, motions, [duration] * len(columns), tolerance=tolerance, times=times)
        for k in np.flatnonzero(tame).tolist():
            if result.overturned_joint[k]:
                continue
            ux, slip = truth[k]
            phases = result.phases[k]
            error = np.max(np.abs(chains[k].top_displacements(phases) - ux))
            error = max(error, np.max(np.abs(phases[:, 4 * n : 5 * n] - slip)))
            assert error <= 10.0 * tolerance * sizes[k]
        assert np.all(result.finished)
        assert np.count_nonzero(result.overturned_joint) <= 1


@pytest.mark.long
def test_a_round_column_whose_friction_is_never_reached_has_the_bits_of_one_that_cannot_slide() -> None:
    column = shaft(1e-3)
    blocks = tuple(replace(block, joint=replace(block.joint, friction=9.0)) for block in column.blocks)
    motions = [Motion.harmonic(0.06 * G, f, 2.0) for f in (1.3, 2.0, 2.4)]
    plain, slipping = (
        run_batch([made] * 3, motions, tolerance=1e-4) for made in (column, replace(column, blocks=blocks))
    )
    assert np.array_equal(plain.steps, slipping.steps)
    assert np.array_equal(plain.peak_ux, slipping.peak_ux)


@pytest.mark.long
def test_many_runs_are_made_in_lanes_with_the_verdicts_of_simulate() -> None:
    motions = [Motion.harmonic(a * G, f, 2.0) for a, f in ((0.05, 2.0), (0.1, 1.0), (0.3, 0.5), (0.15, 2.5))]
    columns = [shaft(2e-3), shaft(5e-3), phocas(2e-3), shaft(1e-2, 6)]
    keep = ("peak_ux", "residual_ux", "energy", "verdict", "path")
    table = simulate_many(columns, motions, tolerance=1e-5, keep=keep)
    assert list(table["path"]) == ["lanes"] * 4
    for k, (column, motion) in enumerate(zip(columns, motions, strict=True)):
        single = simulate(column, motion, tolerance=1e-8)
        assert table["verdict"][k] == single.verdict
        assert table["peak_ux"][k, : column.n] == pytest.approx(single.peak_ux, abs=1e-3 * np.max(single.peak_ux))
    assert set(table["verdict"]) == {"standing", "overturned"}


@pytest.mark.long
@pytest.mark.parametrize("n", [1, 3])
def test_what_is_held_of_many_columns_is_what_is_held_of_each(n: int) -> None:
    """And the quick bound is never above the barrier, whatever the sections."""
    rng = np.random.default_rng(n)
    columns = [column for column in (random_drums(rng, n, softest=1e7) for _ in range(40)) if is_stable(column)]
    models = models_of(columns)
    chain = Chain.of_many(models, n)
    energy = np.array([barrier(column).energy for column in columns])
    bounds = [least_energies(chain, part, grazed)[0] for part in SHARES for grazed in GRAZED]
    assert np.any(np.max(bounds, axis=0) > 0.0)
    assert np.all(np.max(bounds, axis=0) < energy)
    energy *= rng.uniform(0.0, 4.0, len(columns)) ** 2
    turned = rng.uniform(0.0, 0.1, (len(columns), n))
    wanted = [is_held(column, e, t) for column, e, t in zip(columns, energy.tolist(), turned, strict=True)]
    barriers = Barriers(chain, fall_angles(models, n))
    some = rng.permutation(len(columns))
    for part in (some[:5], some):
        assert barriers.hold(part, energy[part], turned[part]).tolist() == [wanted[k] for k in part]
    assert 0 < sum(wanted) < len(wanted)
    states = [np.concatenate(random_state(rng, column, 1e-3)) for column in columns]
    energies = chain.energies(np.array(states))
    assert energies == pytest.approx([Chain(c).energy(x) for c, x in zip(columns, states, strict=True)], rel=1e-9)
