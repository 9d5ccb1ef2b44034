"""A column that cannot stand, or that is probably not meant, is not passed over; nor is a start that makes no sense."""

import re
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.probe import phocas, settled

from solver import (
    Block,
    Column,
    InitialState,
    InputError,
    InputWarning,
    Joint,
    Motion,
    SolverError,
    simulate,
)
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.modes import natural_frequencies, natural_modes
from solver.models.column.rest import first_damping_ratio, is_stable, warnings_of
from solver.models.column.stepper import Stepper
from solver.runs.many import simulate_many
from solver.statics.capacity import capacity_curve, rest_of

SHAKE = Motion.harmonic(0.01 * STANDARD_GRAVITY, 2.0, 0.1)


def stack(stiffness: float, mass: float = 9000.0, height: float = 4.0, n: int = 3) -> Column:
    return Column("stack", (Block(height, 1.0, 0.8, mass, Joint(stiffness, 1e-3)),) * n)


def softened(column: Column, factor: float) -> Column:
    blocks = (replace(b, joint=replace(b.joint, stiffness=factor * b.joint.stiffness)) for b in column.blocks)
    return replace(column, blocks=tuple(blocks))


def stands(column: Column) -> bool:
    """Return True if it stands, by the frequencies of the differenced accelerations."""
    try:
        natural_frequencies(column)
    except SolverError:
        return False
    return True


def edge(column: Column, judge: Any) -> float:
    """Return the factor on all moduli from which on `judge` says that the column stands."""
    low, high = 1e-4, 10.0
    for _ in range(40):
        middle = np.sqrt(low * high)
        low, high = (low, middle) if judge(softened(column, middle)) else (middle, high)
    return float(high)


@pytest.mark.parametrize("n", [1, 3])
@pytest.mark.parametrize("centroid", [None, 1.2])
def test_the_edge_of_stability_is_that_of_the_equations_of_motion(n: int, centroid: float | None) -> None:
    blocks = tuple(
        Block(4.0 - 0.3 * i, 1.0 + 0.2 * i, 0.8, 9000.0, Joint(2e7 * (1.0 + i), 0.0, 0.9), centroid) for i in range(n)
    )
    column = Column("uneven", blocks)
    assert edge(column, is_stable) == pytest.approx(edge(column, stands), rel=1e-5)


def test_one_block_stands_by_the_formula() -> None:
    # k t b3 / 12 against m g h / 2, and a quarter of the weight times the settlement on the side of the joint
    column = stack(1e6, n=1)
    stiffness = 1e6 * edge(column, is_stable)
    weight = 9000.0 * column.g
    assert stiffness * 0.8 / 12.0 + 0.25 * weight**2 / (stiffness * 0.8) == pytest.approx(0.5 * weight * 4.0, rel=1e-9)


def test_a_rest_that_is_not_stable_is_refused() -> None:
    with pytest.raises(InputError, match=r"^phocas cannot stand: .*= 100000 settles by 3\.2.* m\)"):
        simulate(softened(phocas(), 1e5 / phocas().blocks[0].joint.stiffness), SHAKE)
    # a start from elsewhere is taken as intended
    with pytest.warns(InputWarning, match="settles"):
        simulate(softened(phocas(), 1e5 / 5226944450.0), SHAKE, 0.01, initial=InitialState())


def test_a_thousand_blocks_are_judged() -> None:
    assert is_stable(stack(1e12, 100.0, 0.1, 1000))
    assert not is_stable(stack(1e7, 100.0, 0.1, 1000))


def test_weightless_columns_rest() -> None:
    column = replace(stack(1e3), g=0.0)
    assert is_stable(column)
    assert warnings_of(column) == []


def test_sound_columns_raise_no_warning() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(phocas(), SHAKE)
    assert warnings_of(phocas()) == []


def test_settlement_and_pressure_are_warned_of() -> None:
    flat = Column("flat", (Block(0.2, 2.0, 2.0, 1e5, Joint(5e6, 1e-3)),))
    _, said = warnings_of(flat)
    assert said.startswith("block[1].joint.stiffness = 5e+06: block 1 settles by 0.049 m at rest, 0.25 of its height")
    with pytest.warns(InputWarning, match="0.25 of its height"):
        simulate(flat, SHAKE)
    _, said = warnings_of(Column("heavy", (Block(4.0, 1.0, 1.0, 6e7, Joint(1e13, 1e-4)),)))
    assert said == (
        "joint 1: carries 5.88e+08 N on 1 m2 at rest, 588 MPa, which no stone bears; mass is in kg, density in kg/m3, "
        "width and depth in m"
    )


def changed(joint: dict[str, Any] | None = None, **block: Any) -> Column:
    """Return the Column of Phocas, damped, with another block in the middle."""
    top, middle, base = phocas(1e-3).blocks
    return Column(
        "changed", (top, replace(middle, joint=replace(middle.joint, **(joint or {})), **block), base), g=9.81
    )


@pytest.mark.parametrize(
    ("column", "said"),
    [
        (changed(mass=5000.0), "block[2].mass = 5000: is 438 kg/m3 in 11.41 m3, should be 500 to 12000; mass is in kg"),
        (changed(mass=2e5), "block[2].mass = 200000: is 1.75e+04 kg/m3"),
        (changed(height=31.0, mass=2e5), "block[2].height = 31: should be 30 at most; height is in m"),
        (changed({"friction": 35.0}), "block[2].joint.friction = 35: should be 1.5 at most"),
        (replace(changed(), g=981.0), "g = 981: should be 9.7 to 9.9 on Earth"),
        (changed({"damping": 0.3}), "block[2].joint.damping = 0.3: the first mode has 0.6"),
    ],
)
def test_what_is_probably_not_meant_is_warned_of_everywhere(column: Column, said: str) -> None:
    assert any(line.startswith(said) for line in warnings_of(column))
    with pytest.warns(InputWarning, match=re.escape(said)):
        simulate(column, SHAKE, 0.01, settle=0.0)
    for ask in (natural_modes, rest_of, capacity_curve):
        with pytest.warns(InputWarning, match=re.escape(said)):
            ask(column)
    with pytest.warns(InputWarning, match=re.escape(said)):
        simulate_many([column], [SHAKE], duration=0.01)


def test_what_carries_a_load_may_be_heavy_for_its_size() -> None:
    assert warnings_of(changed(mass=2e5, centroid=4.0, inertia=1e6)) == []


@pytest.mark.parametrize("stiffness", [3e8, 5e9, 1e12])
@pytest.mark.parametrize("n", [1, 2, 5])
def test_the_first_damping_ratio_is_that_of_the_modes(stiffness: float, n: int) -> None:
    column = stack(stiffness, n=n, height=2.0)
    modes = natural_modes(column)
    exact = float(modes.damping_ratio[int(np.argmax(modes.sways))])
    assert first_damping_ratio(column) == pytest.approx(exact, rel=1e-3)  # 2e-5 at most was seen
    assert any("critical damping" in line for line in warnings_of(column)) == (exact > 0.2)


@pytest.mark.parametrize(
    ("given", "said"),
    [
        ({"rotation": np.ma.masked_equal([0.0, 1.0, 0.0], 1.0)}, "initial.rotation = "),
        ({"rotation": [True, False, False]}, "initial.rotation = [True, False, False]: must be 3 finite numbers"),
        ({"rotation": ["a", "b", "c"]}, "initial.rotation = ['a', 'b', 'c']: must be 3 finite"),
        ({"rotation": [[0.0], [0.0, 1.0], 0.0]}, "initial.rotation = "),
        ({"rotation_rate": [0.0, np.nan, 0.0]}, "initial.rotation_rate = "),
        ({"rotation": [0.0, 2.0, 0.0]}, "initial.rotation[1] = 2: must be a quarter turn either way at most"),
        ({"opening": [0.0, 0.0, -5.0]}, "initial.opening[2] = -5: must be no deeper than the block is high"),
    ],
)
def test_initial_states_that_make_no_sense(given: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        Stepper(phocas(), InitialState(**given))
    assert str(caught.value).startswith(said)


def test_what_is_no_initial_state() -> None:
    with pytest.raises(InputError, match=r"^initial = \[0\.0\]: must be an InitialState$"):
        simulate(phocas(), SHAKE, initial=[0.0])


@pytest.mark.parametrize("hold", ["no", 1, None])
def test_what_is_held_is_said_by_a_truth_value(hold: Any) -> None:
    with pytest.raises(InputError, match=r"^hold = .*: must be True or False$"):
        Motion.from_samples(0.1, [0.0, 1.0], hold=hold)


def test_initial_states_of_any_number() -> None:
    wanted = Stepper(phocas(), InitialState(rotation=[0.0, 0.0, 1e-3])).arrays.state
    for rotation in (np.array([0.0, 0.0, 1e-3], dtype=np.float64), (0, 0, np.float64(1e-3)), np.ma.array([0, 0, 1e-3])):
        np.testing.assert_array_equal(Stepper(phocas(), InitialState(rotation=rotation)).arrays.state, wanted)
    assert np.all(settled(phocas()) > 0.0)


def test_times_of_a_run_are_numbers() -> None:
    assert len(simulate(phocas(), SHAKE, np.float32(0.0625), output_step=np.int64(1)).time) == 1
    values: tuple[Any, ...] = (True, "1", np.bool_(True), np.nan, np.array([1.0]))
    for key in ("duration", "output_step"):
        for value in values:
            with pytest.raises(InputError, match=f"^{key} = .*: must be a positive time in s$"):
                simulate(phocas(), SHAKE, **{key: value})
