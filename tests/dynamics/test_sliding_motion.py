"""Columns whose joints slide, in motion: closed forms, energy, another integrator, Shenton's map of modes."""

from __future__ import annotations

import warnings
from dataclasses import replace
from math import cos, sin
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from support.columns import MU, flat_block
from support.lagrange import Array
from support.probe import G, phocas, put_back
from support.shenton import mode_found, mode_of, needed_to_rock
from support.sliding import SlidingReference, follow

from solver import Block, Column, InitialState, InputError, InputWarning, Joint, Motion, Response, Settings, simulate
from solver.ground import wavelets
from solver.ground.loads import Load
from solver.models.column.run import phase_of
from solver.models.column.stepper import Stepper
from solver.models.column.sticking import always_sticks
from solver.runs.many import simulate_many


def two_blocks(eta: float, tolerance: float) -> Column:
    """Return two blocks that rock and slide."""
    top = Block(1.2, 0.8, 0.8, 1800.0, Joint(4e8, eta, friction=0.25))
    low = Block(1.5, 1.0, 1.0, 3500.0, Joint(6e8, eta, friction=0.3))
    return Column("two", (top, low), Settings(tolerance=tolerance))


def pulse(acceleration: float, duration: float, total: float) -> Motion:
    """Return a rectangular pulse of the base towards -x."""
    time = 0.01 * np.arange(round(total / 0.01))
    return Motion.from_samples(0.01, np.where(time < duration - 1e-9, -acceleration, 0.0), hold=True)


@pytest.mark.parametrize("ratio", [1.2, 2.0, 5.0])
@pytest.mark.parametrize("dowel", [None, 1500.0])
def test_newmarks_sliding_block_under_a_rectangular_pulse(ratio: float, dowel: float | None) -> None:
    mu = MU + (dowel or 0.0) / (2000.0 * G)  # the weight is constant: a dowel acts as more friction
    a, duration = ratio * mu * G, 0.2
    speed = a * duration
    expected = speed**2 / (2.0 * mu * G) * (1.0 - mu * G / a)
    stop = speed / (mu * G)
    response = simulate(flat_block(dowel=dowel), pulse(a, duration, stop + 0.3), settle=0.0)
    assert response.slip[-1, 0] == pytest.approx(expected, rel=2e-4)  # measured 1e-6 to 7e-5, of the elastic bed
    assert response.slip[-1, 0] == pytest.approx(response.ux[-1, 0], rel=1e-4)
    assert np.all(response.slip[response.time > stop + 0.01] == response.slip[-1])


def test_below_its_friction_a_block_does_not_slide() -> None:
    response = simulate(flat_block(), pulse(0.9 * MU * G, 0.3, 0.5), settle=0.0)
    assert np.all(response.slip == 0.0)


@pytest.mark.parametrize("tangent", [0.8 * MU, 1.02 * MU, 2.0 * MU])
def test_on_a_tilted_plane(tangent: float) -> None:
    tilt = float(np.arctan(tangent))
    stepper = Stepper(flat_block())
    stepper.drive(0.0, theta=tilt)
    stepper.stand_on_base()
    stepper.advance(0.0, 1.0)
    slip = float(stepper.state.phase.slip[0])
    if tangent < MU:
        assert slip == 0.0
    else:
        # measured 1.1e-5 at 1.02 MU: the weight is applied at once
        assert slip == pytest.approx(0.5 * G * (sin(tilt) - MU * cos(tilt)), abs=1e-3 * 0.5 * G * MU)


@pytest.mark.parametrize("largest", [0.01, 0.06])
def test_energy_falls_by_the_work_of_friction(largest: float) -> None:
    column = two_blocks(0.0, 1e-11)
    reference = SlidingReference.of(column)
    stepper = Stepper(column, InitialState(rotation=[largest, 0.8 * largest], slip_rate=[0.8, -0.3]))

    def energy() -> float:
        phase = stepper.state.phase
        q = np.concatenate([phase.theta, phase.opening, phase.slip])
        rate = np.concatenate([phase.theta_rate, phase.opening_rate, phase.slip_rate])
        potential = reference.g * reference.mass @ reference.centroids(q)[1] + reference.elastic(q)
        return float(0.5 * rate @ reference.mass_matrix(q) @ rate + potential)

    before = energy()
    for k in range(80):
        stepper.advance(0.005 * k, 0.005)
        spent = float(np.sum(stepper.state.phase.friction_work))
        assert energy() + spent == pytest.approx(before, abs=1e-9 * spent)  # measured 4e-12
    assert spent > 500.0
    assert stepper.counts.events >= 5


@pytest.mark.long  # takes seconds
def test_two_blocks_that_rock_and_slide_against_another_integrator() -> None:
    """Compare with DOP853 of scipy on Lagrange's equations, stopped where a joint sticks or slides."""
    column = two_blocks(1e-3, 1e-10)
    stepper = Stepper(column, InitialState(rotation=[0.02, 0.012], slip_rate=[0.5, -0.2]))
    phase = stepper.state.phase
    q = np.concatenate([phase.theta, phase.opening, phase.slip])
    rate = np.concatenate([phase.theta_rate, phase.opening_rate, phase.slip_rate])
    stepper.drive(0.0, ax=2.0)
    stepper.advance(0.0, 0.2)
    found = np.concatenate([phase.theta, phase.opening, phase.slip])
    expected, changes = follow(SlidingReference.of(column), q, rate, 2.0, 0.2, 1e-10)
    assert changes >= 3
    assert found == pytest.approx(expected[:6], abs=1e-8 * np.max(np.abs(expected)))


@pytest.mark.long  # test_benchmarks.py has other scenes of it
def test_friction_that_is_regularized_less_and_less_comes_to_it() -> None:
    column = flat_block(tolerance=1e-10)
    reference = SlidingReference.of(column)
    stepper = Stepper(column, InitialState(slip_rate=[1.0]))
    phase = stepper.state.phase
    start = np.concatenate(
        [phase.theta, phase.opening, phase.slip, phase.theta_rate, phase.opening_rate, phase.slip_rate]
    )
    stepper.drive(0.0)
    stepper.advance(0.0, 0.5)
    errors = []
    for width in (1e-2, 1e-3, 1e-4):  # m/s, over which friction rises

        def slope(t: float, y: Array, width: float = width) -> Array:
            return np.concatenate([y[3:], reference.solve(y[:3], y[3:], np.tanh(y[5:] / width) + 1e-300)[0]])

        run = solve_ivp(slope, (0.0, 0.5), start, method="LSODA", rtol=1e-9, atol=1e-12)
        errors.append(abs(run.y[2, -1] - float(phase.slip[0])))
    assert errors[0] > 5.0 * errors[1] > 25.0 * errors[2]
    assert errors[2] < 1e-5


@pytest.mark.parametrize("eta", [0.0, 1e-3])
def test_the_tolerance_is_kept(eta: float) -> None:
    motion = Motion.harmonic(4.5, 2.0, 1.0)
    closest = simulate(two_blocks(eta, 1e-11), motion, settle=0.0)
    assert np.max(np.abs(closest.slip)) > 1e-3
    for tolerance in (1e-4, 1e-5, 1e-6, 1e-8):
        response = simulate(two_blocks(eta, tolerance), motion, settle=0.0)
        for name in ("ux", "slip"):
            wanted = getattr(closest, name)
            error = np.max(np.abs(getattr(response, name) - wanted)) / np.max(np.abs(wanted))
            assert error < 10.0 * tolerance, name  # measured 0.03


def test_a_column_that_bears_all_moves_as_one_that_cannot_slide() -> None:
    """Compare for equal bits, if equal short cuts are taken."""
    rigid = phocas(1e-3, without=("elastic", "implicit", "rest"))
    blocks = tuple(replace(block, joint=replace(block.joint, friction=100.0, dowel=1e12)) for block in rigid.blocks)
    motion = Motion.harmonic(0.05 * G, 2.0, 2.0)
    one, other = (simulate(column, motion, settle=0.0) for column in (rigid, replace(rigid, blocks=blocks)))
    for name in ("ux", "ry", "N", "Tx", "base_Fx"):
        assert np.array_equal(getattr(one, name), getattr(other, name)), name
    assert np.array_equal(one.peak_top_ux, other.peak_top_ux)


def test_a_state_put_back_goes_on_with_the_same_bits() -> None:
    column = two_blocks(1e-3, 1e-6)
    kept, other = Stepper(column, InitialState(slip_rate=[0.5, -0.2])), Stepper(column)
    for k in range(10):
        kept.drive(0.01 * k, ax=4.0 * (-1) ** k)
        kept.advance(0.01 * k, 0.01)
    put_back(kept, other)
    for stepper in (kept, other):
        stepper.drive(0.1, ax=5.0)
        stepper.advance(0.1, 0.05)
    assert np.array_equal(kept.arrays.state, other.arrays.state)
    assert np.array_equal(kept.observe(0.15), other.observe(0.15))


# --- when it is over


def test_a_column_that_has_come_to_rest_stands() -> None:
    motion = pulse(2.0 * MU * G, 0.2, 0.8)
    response = simulate(flat_block(tolerance=1e-6), motion)
    assert response.verdict == "standing"
    # while it slides it has too little energy to turn over, and to slide to where less suffices
    assert simulate(flat_block(tolerance=1e-6), motion, duration=0.3, settle=0.0).verdict == "standing"


def test_what_is_said_to_stick_for_good_does() -> None:
    """Push as hard as the bound allows, in every direction of a random state: no joint slides."""
    column = two_blocks(0.0, 1e-8)
    n, rng, said = column.n, np.random.default_rng(3), 0
    for _ in range(20):
        spin, speed = rng.normal(size=n), rng.normal(size=n) * 0.1
        size = 1.0
        while True:
            initial = InitialState(rotation_rate=size * spin, opening_rate=size * speed)
            stepper = Stepper(column, initial)
            if always_sticks(column, phase_of(stepper)):
                break
            size *= 0.8
        said += size > 1e-6
        stepper.rest_until(0.0, 0.5)
        assert np.all(stepper.state.phase.slip == 0.0)
        assert stepper.counts.events == 0
    assert said == 20


@pytest.mark.parametrize("offset", [None, 0.06])
@pytest.mark.parametrize("seed", range(4))
def test_from_when_it_is_said_to_stick_for_good_nothing_opens_or_slides(seed: int, offset: float | None) -> None:
    """Check the rest of the motion of damped columns that have rocked and slid, on their axis as built or not."""
    rng = np.random.default_rng(seed)
    blocks = []
    for _ in range(3):
        joint = Joint(rng.uniform(3e8, 2e9), 2e-3, friction=rng.uniform(0.15, 0.5), offset=offset)
        blocks.append(Block(rng.uniform(0.8, 1.4), 0.9, 0.9, rng.uniform(2000.0, 3000.0), joint))
    column = Column("any", tuple(blocks), Settings(tolerance=1e-7))
    stepper = Stepper(column, InitialState(rotation_rate=rng.normal(size=3) * 0.05, slip_rate=[0.3, -0.2, 0.1]))
    t = 0.0
    while not always_sticks(column, phase_of(stepper)):
        stepper.rest_until(t, t + 0.05)
        t += 0.05
        assert t < 20.0  # measured 0.35 to 1.8
    slip, events = stepper.state.phase.slip.copy(), stepper.counts.events
    assert np.max(np.abs(slip - (offset or 0.0))) > 1e-3
    stepper.rest_until(t, t + 5.0)
    assert np.array_equal(stepper.state.phase.slip, slip)
    assert stepper.counts.events == events


# --- Shenton's map


@pytest.mark.parametrize("slenderness", [1.25, 2.0, 4.0])
def test_shentons_map_of_modes(slenderness: float) -> None:
    edge = 1.0 / slenderness
    points = {(0.85 * edge, 2.0 * edge), (0.4 * edge, 0.5 * edge), (0.85 * edge, 0.5 * edge), (1.5 * edge, 0.7 * edge)}
    for push in (1.3 * edge, 2.0 * edge):
        needed = needed_to_rock(push, 1.0, slenderness)
        points |= {(push, 1.15 * needed), (push, 0.5 * (edge + needed))}
    expected = {point: mode_of(*point, slenderness) for point in points}
    assert set(expected.values()) == {"rest", "slide", "rock", "slide-rock"}
    assert {point: mode_found(*point, slenderness) for point in points} == expected


# --- combinations that are refused


def test_a_formulation_without_sliding_is_refused() -> None:
    message = r'block\[1\].joint.friction = 0.3: solver.formulation must be "exact"'
    with pytest.raises(InputError, match=message):
        flat_block().with_settings(formulation="paper")


def test_wrong_values_are_refused() -> None:
    with pytest.raises(InputError, match=r"block\[1\].joint.dowel = 5.0: needs friction"):
        Column("one", (Block(1.0, 1.0, 1.0, 2000.0, Joint(1e9, 0.0, dowel=5.0)),))
    with pytest.raises(InputError, match=r"block\[1\].joint.friction = 0.0: must be a positive coefficient"):
        flat_block(mu=0.0)
    with pytest.raises(InputError, match=r"initial.slip\[0\] = 0.1: must be zero where the joint has no friction"):
        simulate(phocas(1e-3), Motion.harmonic(1.0, 2.0, 0.1), initial=InitialState(slip=[0.1, 0.0, 0.0]))


def test_toml_has_friction_and_dowel() -> None:
    column = flat_block(dowel=100.0)
    assert Column.from_dict(column.to_dict()) == column
    assert "friction" not in phocas(1e-3).to_dict()["block"][0]["joint"]


@pytest.mark.parametrize("number", [7, 42, 59])
def test_a_joint_at_the_edge_of_sliding_does_not_begin_and_stop_without_end(number: int, records: Path) -> None:
    rng = np.random.default_rng([7, number])
    side = rng.uniform(0.8, 1.6)
    blocks = []
    for _ in range(3):
        height = rng.uniform(0.4, 1.5)
        width, depth = side * rng.uniform(0.85, 1.15, 2)
        joint = Joint(10 ** rng.uniform(8.5, 9.8), 10 ** rng.uniform(-3, -2), friction=rng.uniform(0.1, 0.5))
        blocks.append(Block(height, width, depth, 2500.0 * height * width * depth, joint))
    files = sorted(records.glob("*.AT2"))
    motion = Motion.from_at2(files[number % len(files)])
    motion = motion.scaled(rng.uniform(0.3, 0.9) * G / np.max(np.abs(motion.ax)))
    response = simulate(Column("edge", tuple(blocks)), motion, 12.0, tolerance=1e-3, settle=0.0)
    assert response.stats["events"] < 3000  # measured 684, 365 and 1229; 27,000 to 30,000 without `LATE`


PILLAR: dict[str, Any] = {
    "name": "pillar",
    "block": [
        {"height": 1.8, "width": 0.8, "depth": 0.8, "density": 2500.0},
        {"height": 0.6, "width": 2.0, "depth": 2.0, "top_width": 0.8, "top_depth": 0.8, "density": 2500.0},
    ],
    "joint": {"stiffness": 2e9, "damping": 2e-3, "friction": 0.43},
}


@pytest.mark.parametrize("round_", [False, True])
def test_edges_that_coincide_push_before_a_joint_slides(round_: bool) -> None:
    """Let a rocking block slide over the edge of a face as wide: a slip as of a rounding changes nothing."""
    blocks = [
        {"section": "circle", "diameter": block["width"], "height": block["height"], "density": block["density"]}
        | ({"top_diameter": block["top_width"]} if "top_width" in block else {})
        for block in PILLAR["block"]
    ]
    column = Column.from_dict(PILLAR | ({"block": blocks} if round_ else {}))
    motion = wavelets.ricker(0.8421 * G, 0.7584)
    runs = [
        simulate(column, motion, initial=InitialState(slip=[slip, 0.0]), settle=0.0, tolerance=1e-6)
        for slip in (0.0, 1e-14, -1e-14)
    ]
    for run in runs[1:]:
        assert run.slip[-1] == pytest.approx(runs[0].slip[-1], abs=1e-7)  # measured 1e-8 m
        assert run.peaks["ry"] == pytest.approx(runs[0].peaks["ry"], rel=1e-5)
    # the upper block has slid outwards, as in space: measured 1.6 % more there, by the shear of its joints
    in_space = simulate(column.in_space(), motion, settle=0.0, tolerance=1e-6)
    assert abs(runs[0].slip[-1, 0]) > 0.01
    assert abs(runs[0].slip[-1, 0]) == pytest.approx(abs(in_space.slip[-1, 0]), rel=0.03)


def test_a_tilted_joint_begins_to_slide_outwards_on_the_edge_below() -> None:
    """Push a block that leans on its edge: it slides at the friction less the sine of half of the tilt."""
    data = PILLAR | {"port": [{"name": "p", "block": "block1", "at": [0.0, 0.3]}]}
    column = Column.from_dict(data | {"joint": {"stiffness": 2e9, "damping": 2e-3, "friction": 0.4}})
    weight = 0.8 * 0.8 * 1.8 * 2500.0 * G
    load = Load.of(np.array([0.0, 0.5, 1.5]), Fx=weight * np.array([0.0, 0.36, 0.45]))
    still = Motion.from_samples(1.0, np.zeros(3))
    run = simulate(column, still, loads={"p": load}, duration=1.4, settle=0.0, tolerance=1e-8, output_step=1e-4)
    first = int(np.argmax(run.slip[:, 0] > 1e-9))
    tilt = 0.5 * (run.ry[first, 0] - run.ry[first, 1])
    assert tilt > 0.005
    # measured 5e-4 less, as N is damped and the push of the edge is not
    assert run.Tx[first, 0] / run.N[first, 0] == pytest.approx(0.4 - sin(tilt), abs=1e-3)


def leaning(
    offset: float, below: float = 1.2, width: float = 1.0, friction: float = 0.3, height: float = 0.5, **law: Any
) -> Column:
    """Return a block off the middle of a block `below` m wide; a port is in the middle of its foot."""
    law = {"stiffness": 1e8, "damping": 1e-2, "friction": friction, "offset": offset} | law
    upper = {"height": height, "width": width, "depth": 1.0, "density": 2500.0, "joint": law}
    rest = {"stiffness": 1e9, "damping": 5e-3}
    lower = {"height": 1.0, "width": below, "depth": 1.0, "density": 2500.0, "joint": rest}
    port = {"name": "p", "block": "block1", "at": [0.0, -0.5 * height]}
    return Column.from_dict({"name": "leaning", "block": [upper, lower], "port": [port]})


def loaded(column: Column, time: list[float], push: list[float], couple: list[float], **options: Any) -> Response:
    """Load the upper block by a push (of its weight) at its foot and a couple (m of it), on a base at rest."""
    weight = column.blocks[0].mass * G
    load = Load.of(np.array(time), Fx=weight * np.array(push), My=weight * np.array(couple))
    still = Motion.from_samples(1.0, np.zeros(int(time[-1]) + 1))
    with warnings.catch_warnings():  # of the damping, by which the block leans without swinging
        warnings.simplefilter("ignore", InputWarning)
        return simulate(column, still, loads={"p": load}, settle=0.0, **options)


def pushed(column: Column, way: float = 1.0, lean: float = 0.45, slip: float = 0.0) -> Response:
    """Tilt the upper block on its edge by a couple, then push its foot the same way until it slides."""
    push, couple = [0.0, 0.0, way * 1.2 * 0.3], [0.0, way * lean, way * lean]
    start = InitialState(slip=[slip, 0.0])
    options = {"initial": start, "tolerance": 1e-7, "output_step": 1e-3, "duration": 3.6}
    return loaded(column, [0.0, 1.0, 4.0], push, couple, **options)


def begins(run: Response) -> int:
    """Return the row in which the upper block has begun to slide."""
    return int(np.argmax(np.abs(run.slip[:, 0] - run.slip[0, 0]) > 1e-7))


def needed_push(run: Response) -> float:
    """Return the push over friction times weight at which `pushed` lets the upper block slide."""
    return 1.2 * (float(run.time[begins(run)]) - 1.0) / 3.0


# widths below and above (m), law of the joint between them, couple over weight (m); the needed push where the upper
# block stands out by 1 nm, and where it stands back by 1 nm
FLUSH: dict[str, tuple[float, float, dict[str, Any], float, float, float]] = {
    "wide below": (1.2, 1.0, {}, 0.45, 0.9232, 0.9772),
    "narrow below": (1.0, 1.2, {}, 0.55, 0.8680, 0.9824),
    "strips": (1.2, 1.0, {"section": "strips", "strips": [0.8, 0.7, 1.0, 0.7, 0.8]}, 0.45, 1.0276, 1.0384),
    "rim": (1.2, 1.0, {"rim": 0.1}, 0.45, 0.9504, 0.9864),
    "inclined": (1.2, 1.0, {"inclination": 0.02}, 0.45, 0.8140, 0.9220),
}


@pytest.mark.parametrize("case", FLUSH)
def test_an_edge_that_coincides_with_that_below_pushes_as_where_it_stands_out(case: str) -> None:
    """Place a block flush with one edge of another one, also but for rounding: the edge below pushes it outwards."""
    below, width, law, lean, out, back = FLUSH[case]
    offsets = [0.5 * (below - width) + more for more in (0.0, 1e-14, -1e-14, 1e-9, -1e-9)]
    needed = [needed_push(pushed(leaning(offset, below, width, **law), lean=lean)) for offset in offsets]
    # without the push of the edge the first and the third were `back`, to 8e-4
    assert needed == pytest.approx([out, out, out, out, back], abs=5e-4)  # an output step is 4e-4


def test_edges_that_coincide_push_on_either_side_and_after_a_slip() -> None:
    run, mirrored = pushed(leaning(0.1)), pushed(leaning(-0.1), way=-1.0)
    assert np.array_equal(run.slip, -mirrored.slip)
    # measured 0.9220 in space, of the shear of its joints; 0.9768 without the push of the edge
    assert needed_push(run) == pytest.approx(0.9232, abs=5e-4)
    # the block has slid until it is flush
    assert needed_push(pushed(leaning(0.07), slip=0.03)) == pytest.approx(0.9232, abs=5e-4)
    # away from that edge it slides as if it stood back
    back = needed_push(pushed(leaning(0.09), way=-1.0))
    assert needed_push(pushed(leaning(0.1), way=-1.0)) == pytest.approx(back, abs=5e-4)  # measured 0.9784


@pytest.mark.parametrize(("offset", "below"), [(0.0, 1.0), (0.1, 1.2)])
def test_edges_that_coincide_push_outwards_against_a_pull_inwards(offset: float, below: float) -> None:
    """Tilt a block on its edge until it slides outwards, at a tilt of the friction plus the pull over the weight."""
    time, pull, couple = [0.0, 2.0, 12.0, 14.0], [0.0, -0.002, -0.002, -0.002], [0.0, 0.42, 0.47, 0.47]
    column = leaning(offset, below, friction=0.01)
    run = loaded(column, time, pull, couple, tolerance=1e-6, output_step=0.01, duration=10.0)
    first = begins(run)
    assert run.slip[-1, 0] > offset + 0.01
    # measured 0.0121; where the direction did not regard the edge, it stuck up to a tilt of 0.09 and slid inwards
    assert run.ry[first, 0] - run.ry[first, 1] == pytest.approx(0.012, abs=2e-4)


def test_edges_that_coincide_leave_the_error_within_the_tolerance() -> None:
    """Push a block on an edge forth and back: its slips and tops."""
    time, push = [0.0, 0.1, 0.4, 0.5, 0.6, 0.9, 1.0], 1.3 * 0.3 * np.array([0.0, 0.0, 1.0, 0.0, 0.0, -1.0, 0.0])
    couple, column = [0.0, 0.4, 0.4, 0.0, 0.0, -0.4, 0.0], leaning(0.1)
    truth, run = (
        loaded(column, time, list(push), couple, tolerance=tolerance, output_step=0.01) for tolerance in (1e-11, 1e-7)
    )
    error = max(np.max(np.abs(run.slip - truth.slip)), np.max(np.abs(run.ux - truth.ux)))
    # measured 6e-5 of the tolerance; 190 times it without the push of the edge
    assert error < 1e-7 * np.max(np.abs(truth.ux))


@pytest.mark.long  # compiles lanes whose columns slide
@pytest.mark.parametrize("side", [1.0, -1.0])
def test_edges_that_coincide_push_in_lanes_as_in_single_runs(side: float) -> None:
    """Shake blocks that are flush with an edge, or stand out by 1 nm: they slide by 6 to 90 mm."""
    time = np.arange(0.0, 3.0, 0.02)
    ends = []
    for out in (0.0, 1e-9):
        columns, motions = [], []
        for seed in range(8):
            rng = np.random.default_rng(seed)
            height, friction, stiffness = rng.uniform(1.8, 2.2), rng.uniform(0.27, 0.33), 10.0 ** rng.uniform(8.0, 9.0)
            columns.append(
                leaning(side * (0.1 + out), height=height, friction=friction, stiffness=stiffness, damping=3e-3)
            )
            amplitude = side * rng.uniform(0.33, 0.48) * G * rng.choice([-1.0, 1.0])
            sine = amplitude * np.sin(2.0 * np.pi * rng.uniform(0.7, 2.0) * time)
            motions.append(Motion.from_samples(0.02, np.where(time < 1.2, sine, 0.0)))
        table = simulate_many(columns, motions, tolerance=1e-6, settle=0.0, keep=["residual_slip", "path"])
        assert set(table["path"]) == {"lanes"}
        alone = [simulate(*run, tolerance=1e-6, settle=0.0).slip[-1, 0] for run in zip(columns, motions, strict=True)]
        ends.append(table["residual_slip"][:, 0])
        assert ends[-1] == pytest.approx(alone, abs=5e-7)  # measured 6e-8 m
    assert ends[0] == pytest.approx(ends[1], abs=5e-7)  # measured 5e-8 m; 1.2e-4 m without the push of the edge
