"""The modal method, which `auto` uses while every joint is in full contact: against closed forms and other methods."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from scipy.linalg import expm
from support.lagrange import Reference
from support.off_axis import changed, chipped, leaning, reference_rest
from support.probe import Array, G, coordinates, forced, monolith, phocas, put_back, random_column, walk, with_gravity

from solver import (
    Block,
    Column,
    InitialState,
    InputError,
    Joint,
    Motion,
    Settings,
    natural_frequencies,
    simulate,
)
from solver.kernels.column.api.engine import scratch_room
from solver.kernels.column.api.entries import assemble
from solver.kernels.engine.modal_responses import HALF, respond
from solver.kernels.layout import spaces as at
from solver.kernels.numba_ext.jit import from_python
from solver.kernels.numba_ext.views import row_of
from solver.models.column.packing import described, pack_model, settlements
from solver.models.column.stepper import Stepper

GENERAL = ("elastic",)  # without the modal method


def cut(n: int, eta: float, **settings: Any) -> Column:
    """Return the Column of Phocas in n equal blocks, joints damped by eta s."""
    block = Block(14.07 / n, 1.56, 1.56, 81000.0 / n, Joint(533 * 9.80665e6, eta))
    return Column("cut", (block,) * n, Settings(**settings))


def shifted(eta: float, section: str) -> Column:
    """Return Phocas with round joints, whose drums are off the axis and touch in lenses."""
    blocks = (
        replace(block, section=section, bore=0.4 * (section == "annulus") or None) for block in cut(3, eta).blocks
    )
    return changed(changed(Column(section, tuple(blocks)), 1, offset=0.05), 3, offset=-0.03)


class Modes:
    """The modal data at the end of a packed model, by name."""

    def __init__(self, column: Column) -> None:
        n = column.n
        data = pack_model(column)[at.MODEL.size(n) :]
        matrices = at.MODAL_LIMITS.beside + 2 * n * at.MODE.beside
        rows = data[at.MODAL_LIMITS.beside : matrices].reshape(2 * n, at.MODE.beside)
        self.square, self.damping, self.push, self.lift, _, self.size = rows.T
        parts = int(data[at.MODAL_LIMITS.fields.index("parts")])
        m = 2 * n // parts
        both = data[matrices : matrices + 8 * n * n].reshape(2, 4 * n * n)[:, : parts * m * m]
        self.shapes, self.inverses = both.reshape(2, parts, m, m)


# --- responses of one mode

_half = HALF.over


@from_python
def responses(square: float, beta: float, h: float, omega: float, out: Array) -> None:
    """Return the results of `respond` as an array."""
    respond(square, beta, h, omega, _half(row_of(out), 0))


@pytest.mark.parametrize("zeta", [0.0, 0.05, 0.999, 1.0, 1.001, 6.0])
@pytest.mark.parametrize("turn", [1e-3, 0.3, 1.9, 2.1, 40.0])
def test_responses_of_a_mode_are_those_of_the_matrix_exponential(zeta: float, turn: float) -> None:
    omega, base = 30.0, 12.0
    h = min(turn / omega, 1.0 / base)
    omega = turn / h
    square, beta = omega**2, 2.0 * zeta * omega
    # p, p', and the forces 1, t, t^2 / 2, cos, sin, each derived from those after it
    system = np.zeros((7, 7))
    found = np.zeros(HALF.beside)
    responses(square, beta, h, base, found)
    system[0, 1] = 1.0
    system[1, :2] = -square, -beta
    system[2:4, 3:5] = np.eye(2)
    system[5, 6], system[6, 5] = -base, base

    def driven(by: int) -> float:
        forced = system.copy()
        forced[1, by] = 1.0
        start = np.zeros(7)
        start[4 if by < 5 else 5] = 1.0
        return float((expm(forced * h) @ start)[0])

    free = expm(system * h)
    expected = {"rest": free[0, 0], "impulse": free[0, 1], "impulse_rate": free[1, 1]}
    expected |= {"steady": driven(4), "ramp": driven(3), "parabola": driven(2), "cosine": driven(5), "sine": driven(6)}
    sizes = {"rest": 1.0, "impulse": h, "impulse_rate": 1.0, "steady": h**2, "ramp": h**3, "parabola": h**4}
    sizes |= {"cosine": h**2, "sine": base * h**3}
    assert set(expected) == set(HALF.fields)
    for field, value in expected.items():
        # of the response of a free mass: a slow, strongly damped mode loses digits of it
        tolerance = 2e-10 if field == "parabola" else 2e-12  # measured 6e-11 and 4e-13
        assert getattr(HALF.see(found), field) == pytest.approx(value, abs=tolerance * sizes[field]), field


# --- the modes of a column


def uneven(n: int) -> Column:
    """Return an undamped column whose blocks differ, with so little weight that it is stable."""
    return with_gravity(random_column(np.random.default_rng(n), n, damped=False, softest=1e9), 0.1)


@pytest.mark.parametrize("n", [1, 3, 10])
def test_frequencies_are_those_of_the_differenced_accelerations(n: int) -> None:
    found = np.sort(np.sqrt(Modes(uneven(n)).square)) / (2.0 * math.pi)
    assert found == pytest.approx(natural_frequencies(uneven(n)), rel=1e-6)  # of the differences


@pytest.mark.parametrize("n", [1, 3, 10])
def test_modes_are_those_of_lagranges_mass_matrix(n: int) -> None:
    column = uneven(n)
    modes = Modes(column)
    mass = Reference.of(column).mass_matrix(np.concatenate([np.zeros(n), -settlements(column)]))
    for shape, inverse, part in zip(modes.shapes, modes.inverses, (mass[:n, :n], mass[n:, n:]), strict=True):
        assert shape.T @ part @ shape == pytest.approx(np.eye(n), abs=1e-11)
        assert inverse @ shape == pytest.approx(np.eye(n), abs=1e-11)


@pytest.mark.parametrize(
    "column",
    [
        phocas(formulation="paper"),
        replace(phocas(), g=0.0),
        cut(at.MODAL_MOST + 1, 0.0),
        Column("soft", (Block(4.69, 1.56, 1.56, 27000.0, Joint(1e5, 0.0)),) * 3),  # falls over under its own weight
        Column("mixed", (Block(4.0, 1.0, 1.0, 9e3, Joint(1e9, 1e-3)), Block(4.0, 1.0, 1.0, 9e3, Joint(1e9, 0.0)))),
        changed(phocas(), 1, offset=0.6),  # which leaves the kern
    ],
    ids=["paper", "no gravity", "many blocks", "unstable", "coupled by damping", "open at rest"],
)
def test_there_are_no_modal_data_where_they_would_not_serve(column: Column) -> None:
    assert Stepper(column).model.settings.has_modes == 0.0


def test_modes_off_the_axis_are_those_of_lagranges_equations() -> None:
    """Compare M, and the derivatives of the accelerations by coordinates, by rates and by those of the base."""
    column = leaning(1e-3)
    modes, (reference, q) = Modes(column), reference_rest(column)
    shapes, inverses = modes.shapes[0], modes.inverses[0]
    assert shapes.shape == (6, 6)
    mass = reference.mass_matrix(q)[:6, :6]
    assert shapes.T @ mass @ shapes == pytest.approx(np.eye(6), abs=1e-11)
    assert inverses @ shapes == pytest.approx(np.eye(6), abs=1e-11)

    def accelerations(place: Array, rate: Array, ax: float = 0.0, az: float = 0.0) -> Array:
        found: Array = reference.solve(place, rate, np.zeros(3), ax, az)[0][:6]
        return found

    still = np.zeros(9)
    for name, size in (("square", 1e-7), ("damping", 1e-5)):
        steps = size * np.eye(9)[:6]
        moved = [(q + step, still) if name == "square" else (q, step) for step in (*steps, *-steps)]
        found = np.array([accelerations(*each) for each in moved]).reshape(2, 6, 6)
        matrix = inverses @ ((found[1] - found[0]) / (2.0 * size)).T @ shapes
        largest = np.max(np.abs(getattr(modes, name)))
        assert np.diag(matrix) == pytest.approx(getattr(modes, name), rel=1e-5, abs=1e-8 * largest)
        coupled = np.max(np.abs(matrix - np.diag(np.diag(matrix))))
        assert coupled < (1e-8 if name == "square" else 1e-4) * largest  # gravity is not damped
    for name, ax, az in (("push", 1.0, 0.0), ("lift", 0.0, 1.0)):
        expected = inverses @ (accelerations(q, still, ax, az) - accelerations(q, still))
        assert getattr(modes, name) == pytest.approx(expected, abs=1e-9 * np.max(np.abs(expected)))


@pytest.mark.parametrize("column", [leaning(0.0), chipped(0.0), shifted(0.0, "circle"), shifted(0.0, "annulus")])
def test_frequencies_off_the_axis_are_those_of_the_differenced_accelerations(column: Column) -> None:
    found = np.sqrt(Modes(column).square) / (2.0 * math.pi)
    assert found == pytest.approx(natural_frequencies(column), rel=1e-8)  # measured 3e-13


def test_a_column_that_becomes_another_one_on_its_way_has_the_modes_of_that() -> None:
    upright, other = cut(3, 1e-3), leaning(1e-3)
    stepper = Stepper(upright)
    stepper.advance(0.0, 0.1)
    before = coordinates(stepper).copy()
    assert assemble(3, *stepper.arrays, described(other), 0, np.zeros(scratch_room(3)), np.zeros(1)) == 0
    assert np.array_equal(stepper.arrays.model, pack_model(other))
    assert np.array_equal(coordinates(stepper), before)


def test_modal_data_are_made_once_for_a_column() -> None:
    assert Stepper(phocas()).model.settings.has_modes == 1.0
    assert pack_model(phocas()) is pack_model(phocas())
    assert pack_model(phocas(tolerance=1e-7)) is not pack_model(phocas())


# --- against the other methods at a tight tolerance


def samples(hold: bool) -> Motion:
    times = np.arange(0.0, 2.0 + 1e-9, 0.01)
    return Motion(times, 0.03 * np.sin(13.0 * times), 2.0 * np.sin(21.0 * times), 2.0 + 0.01 * hold, hold)


CASES: dict[str, tuple[Column, Motion]] = {
    "1 block": (cut(1, 1e-3), Motion.harmonic(0.005 * G, 2.0, 3.0)),
    "3 blocks": (cut(3, 1e-3), Motion.harmonic(0.005 * G, 2.0, 3.0)),
    "10 blocks": (cut(10, 1e-3), Motion.harmonic(0.002 * G, 2.0, 3.0)),
    "undamped": (cut(3, 0.0), Motion.harmonic(0.005 * G, 2.0, 3.0)),
    "overdamped": (cut(3, 1e-2), Motion.harmonic(0.005 * G, 2.0, 3.0)),
    "at resonance": (cut(3, 0.0), Motion.harmonic(0.0005 * G, 3.05805407, 3.0)),
    "faster than the column": (cut(3, 1e-3), Motion.harmonic(0.01 * G, 30.0, 1.0)),
    "linear samples, vertical too": (cut(3, 1e-3), samples(False)),
    "held samples, vertical too": (cut(3, 1e-3), samples(True)),
    "off its axis": (leaning(1e-3), Motion.harmonic(0.003 * G, 2.0, 3.0)),
    "off its axis, undamped": (leaning(0.0), Motion.harmonic(0.003 * G, 2.0, 3.0)),
    "off its axis, vertical too": (leaning(1e-3), samples(False)),
    "off its axis, rough": (leaning(1e-3, friction=0.7), Motion.harmonic(0.003 * G, 2.0, 3.0)),
    "strips": (chipped(1e-3), Motion.harmonic(0.003 * G, 2.0, 3.0)),
    "lenses": (shifted(1e-3, "circle"), Motion.harmonic(0.002 * G, 2.0, 3.0)),
}


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("name", CASES)
def test_errors_are_within_the_tolerance(name: str) -> None:
    column, motion = CASES[name]
    expected = simulate(column, motion, tolerance=1e-12, without=GENERAL)
    assert expected.stats["full_contact"] == 1.0
    peak = np.max(np.abs(expected.ux - expected.ux[0]))
    for tolerance in (1e-3, 1e-5, 1e-7):
        response = simulate(column, motion, tolerance=tolerance)
        assert response.stats["elastic_steps"] == response.stats["steps"]
        # measured at most 0.5 tolerances
        assert response.ux == pytest.approx(expected.ux, abs=2.0 * tolerance * peak)
        assert response.peak_top_ux == pytest.approx(expected.peak_top_ux, abs=2.0 * tolerance * peak)
        for found, wanted in ((response.My, expected.My), (response.S, expected.S)):
            largest = np.max(np.abs(wanted - wanted[0]))
            assert found == pytest.approx(wanted, abs=10.0 * tolerance * largest)  # measured at most 2.5 tolerances


@pytest.mark.parametrize("name", ["3 blocks", "off its axis"])
def test_general_steps_are_saved(name: str) -> None:
    column, motion = CASES[name]
    with_it = simulate(column, motion, tolerance=1e-5)
    without = simulate(column, motion, tolerance=1e-5, without=GENERAL)
    assert without.stats["elastic_steps"] == 0
    # measured 221 and 7,245, off the axis 201 and 7,465
    assert with_it.stats["evaluations"] < 0.1 * without.stats["evaluations"]


@pytest.mark.parametrize("amplitude", [0.02, 0.05])
def test_column_that_opens_and_closes_keeps_its_accuracy(amplitude: float) -> None:
    column, motion = cut(3, 1e-3), Motion.harmonic(amplitude * G, 2.0, 4.0)
    expected = simulate(column, motion, tolerance=1e-11, without=GENERAL)
    assert 0.05 < expected.stats["full_contact"] < 0.95
    peak = np.max(np.abs(expected.ux))
    for tolerance in (1e-3, 1e-5, 1e-7):
        response = simulate(column, motion, tolerance=tolerance)
        assert 0 < response.stats["elastic_steps"] < response.stats["steps"]
        assert response.ux == pytest.approx(expected.ux, abs=10.0 * tolerance * peak)  # measured at most 1.5
        assert response.stats["full_contact"] == pytest.approx(expected.stats["full_contact"], abs=0.02)


def test_joint_that_opens_within_a_step_is_not_overlooked() -> None:
    # pushed so that a corner opens for a short time only, around the turning point
    column = cut(1, 0.0, tolerance=1e-2)
    opens = float(2.0 * settlements(column)[0] / 1.56)
    omega = 2.0 * math.pi * natural_frequencies(column)[0]
    for part, opened in ((0.99, False), (1.005, True)):
        stepper = Stepper(column, InitialState(rotation_rate=[part * opens * omega]))
        stepper.advance(0.0, 1.0)
        assert (stepper.state.control.time_rocking > 0.0) == opened
        assert stepper.counts.elastic_steps > 0


# --- closed forms


def test_free_vibration_of_a_block_is_that_of_an_oscillator() -> None:
    column = cut(1, 1e-3, tolerance=1e-8)
    modes = Modes(column)
    square, beta = modes.square[0], modes.damping[0]
    start, end = 1e-9, 2.0  # small enough to make all nonlinear terms negligible
    stepper = Stepper(column, InitialState(rotation=[start]))
    control, floors = stepper.state.control, stepper.model.settings
    control.rotation_scale, control.rate_scale = start, start * math.sqrt(square)
    floors.rotation_floor = floors.rate_floor = 0.0
    stepper.advance(0.0, end)
    expected = expm(np.array([[0.0, 1.0], [-square, -beta]]) * end) @ [start, 0.0]
    found = coordinates(stepper)[[0, 2]]
    assert found[0] == pytest.approx(expected[0], abs=1e-11 * start)  # measured 1e-13
    assert found[1] == pytest.approx(expected[1], abs=1e-11 * start * math.sqrt(square))


def test_steady_motion_of_a_block_is_that_of_an_oscillator() -> None:
    column = cut(1, 2e-2, tolerance=1e-8)
    modes = Modes(column)
    square, beta, push = modes.square[0], modes.damping[0], modes.push[0]
    omega, amplitude = 2.0 * math.pi * 2.0, 1e-7
    stepper = Stepper(column)
    stepper.base.wave_amplitude, stepper.base.wave_omega = amplitude, omega
    end = 20.0  # the free motion is gone: zeta = 0.2
    stepper.advance(0.0, end)
    answer = push * amplitude / (square - omega**2 + 1j * beta * omega) * np.exp(1j * omega * end)
    assert coordinates(stepper)[0] == pytest.approx(modes.shapes[0, 0, 0] * answer.imag, abs=1e-10 * abs(answer))


# --- bits, communication steps


def shaken(column: Column) -> Stepper:
    return forced(Stepper(column), 0.005 * G, 2.0)


@pytest.mark.parametrize("h", [1e-4, 1e-3, 0.01, 0.1])
def test_communication_step_does_not_matter(h: float) -> None:
    column = cut(3, 1e-3, tolerance=1e-7)
    exact = shaken(replace(column, settings=Settings(tolerance=1e-12, without=GENERAL)))
    expected = walk(exact, np.array([0.0, 1.0]))[:3]
    stepper = shaken(column)
    found = walk(stepper, h * np.arange(round(1.0 / h) + 1, dtype=np.float64))[:3]
    assert stepper.counts.elastic_steps == stepper.counts.steps
    # two evaluations for each step; measured 56 to 69 rejected steps and steps cut short
    assert stepper.counts.evaluations <= 2 * round(1.0 / h) + 300
    peak = exact.state.control.rotation_scale
    assert found == pytest.approx(expected, abs=1e-7 * peak)  # measured 1e-11 (h = 1e-4) to 7e-9


def test_restored_state_goes_on_to_the_last_bit() -> None:
    times = np.concatenate([np.linspace(0.0, 0.4, 41), np.linspace(0.4, 2.0, 9)[1:]])
    first, second, restored = (shaken(cut(3, 1e-3)) for _ in range(3))
    walk(first, times)
    walk(second, times[:30])
    walk(restored, np.linspace(0.0, 0.1, 7))  # its stored responses belong to other steps
    put_back(second, restored)
    walk(second, times[29:])
    walk(restored, times[29:])
    for other in (second, restored):
        assert np.array_equal(first.arrays.state, other.arrays.state)
        assert np.array_equal(first.arrays.counts, other.arrays.counts)


# --- long runs


@pytest.mark.parametrize("part", [0.5, pytest.param(1e-3, marks=pytest.mark.long)])
def test_undamped_elastic_motion_keeps_its_energy(part: float) -> None:
    column = cut(3, 0.0)  # default tolerance
    modes = Modes(column)
    period = 2.0 * math.pi / math.sqrt(modes.square[0])
    opens = float(np.min(2.0 * settlements(column) / 1.56))
    shape = modes.shapes[0, :, 0]
    tilt = shape / np.max(np.abs(shape - np.append(shape[1:], 0.0)))
    stepper = Stepper(column, InitialState(rotation=part * opens * tilt))
    rest = np.concatenate([np.zeros(3), -settlements(column)])
    truth = Reference.of(column)

    def energy() -> float:
        return float(truth.energy(coordinates(stepper)[:6], coordinates(stepper)[6:]) - truth.energy(rest, np.zeros(6)))

    begin = energy()
    for k in range(30):  # a single call may not take as many evaluations
        stepper.advance(k * 1e3 * period, 1e3 * period)
    assert stepper.counts.elastic_steps == stepper.counts.steps
    assert energy() == pytest.approx(begin, rel=2e-8)  # measured 3e-9, the digits of the sum


# --- the setting


@pytest.mark.parametrize("without", ["elastic", ("elastik",), (1,), None, {"elastic": True}])
def test_wrong_names_of_short_cuts_are_refused(without: Any) -> None:
    with pytest.raises(InputError, match=r"solver\.without"):
        phocas(without=without)


def test_short_cuts_left_out_come_from_toml_and_go_back() -> None:
    data = monolith().to_dict()
    assert data["solver"]["without"] == []
    data["solver"]["without"] = ["elastic"]
    column = Column.from_dict(data)
    assert column.settings.without == ("elastic",)
    assert Column.from_dict(column.to_dict()) == column
    assert column.with_settings(without=()).settings.without == ()
    assert simulate(column, Motion.harmonic(0.1, 2.0, 0.1)).stats["elastic_steps"] == 0


# --- columns that may slide


def rough(friction: float, section: str = "rectangle", **settings: Any) -> Column:
    """Return Phocas, whose joints may slide, rectangles or circles."""
    column = phocas(1e-3, **settings)
    joints = [replace(block.joint, friction=friction) for block in column.blocks]
    blocks = (replace(block, joint=joint, section=section) for block, joint in zip(column.blocks, joints, strict=True))
    return replace(column, blocks=tuple(blocks))


@pytest.mark.parametrize("section", ["rectangle", "circle"])
def test_a_column_whose_friction_is_not_reached_takes_the_steps_of_one_that_cannot_slide(section: str) -> None:
    motion = Motion.harmonic(0.02 * G, 2.0, 10.0)
    column = rough(0.7, section)
    bound = replace(column, blocks=tuple(replace(b, joint=replace(b.joint, friction=None)) for b in column.blocks))
    one, other = simulate(column, motion), simulate(bound, motion)
    assert one.stats["elastic_steps"] > 50
    assert one.stats["why_no_modes"] == ""
    assert one.stats["elastic_steps"] == other.stats["elastic_steps"]
    assert one.stats["evaluations"] == other.stats["evaluations"]
    assert np.max(np.abs(one.ux - other.ux)) <= 1e-12 * one.peak_top_ux[0]  # the same equations


@pytest.mark.parametrize("amplitude", [0.02, 0.05, 0.3])
@pytest.mark.parametrize("friction", [0.015, 0.045, 0.25])
def test_a_column_that_slides_moves_the_same_with_modes_and_without(amplitude: float, friction: float) -> None:
    """Compare sticking by modes, sliding, and sticking again off its axis; amplified by no more than a few times."""
    pulse = np.sin(np.linspace(0.0, 6.0 * math.pi, 151)) * amplitude * G
    motion = Motion.from_samples(0.01, np.concatenate([pulse, np.zeros(50)]))
    truth = simulate(rough(friction, tolerance=1e-9, without=("elastic", "rest")), motion, settle=0.0)
    for tolerance in (1e-3, 1e-5):
        found = simulate(rough(friction, tolerance=tolerance), motion, settle=0.0)
        error = max(np.max(np.abs(found.ux - truth.ux)), np.max(np.abs(found.slip - truth.slip)))
        assert error < 10.0 * tolerance * np.max(truth.peak_top_ux)
        if amplitude < 0.03:
            assert found.stats["elastic_steps"] > 0


def test_stats_say_why_there_are_no_modes() -> None:
    motion = Motion.harmonic(0.01 * G, 2.0, 0.1)
    column = phocas(1e-3)
    tilted = changed(column, 1, offset=0.6)
    assert "no stable rest in full contact" in simulate(tilted, motion).stats["why_no_modes"]
    assert simulate(changed(column, 1, offset=0.05), motion).stats["why_no_modes"] == ""
    assert simulate(phocas(1e-3, without=("elastic",)), motion).stats["why_no_modes"] == "left out"
    paper = phocas(1e-3, formulation="paper")
    assert simulate(paper, motion).stats["why_no_modes"] == "formulation paper"
