"""A column that cannot stand, or that is probably not meant, is not passed over; nor is a start that makes no sense."""

import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from probe import phocas, settled

from solver import Block, Column, InitialState, InputError, InputWarning, Joint, Motion, SolverError, simulate
from solver.modes import natural_frequencies
from solver.motion import STANDARD_GRAVITY
from solver.rest import doubts, is_stable
from solver.stepper import Stepper

SHAKE = Motion.harmonic(0.01 * STANDARD_GRAVITY, 2.0, 0.1)


def stack(stiffness: float, mass: float = 9000.0, height: float = 4.0, n: int = 3) -> Column:
    return Column("stack", (Block(height, 1.0, 0.8, mass, Joint(stiffness, 1e-3)),) * n)


def softened(column: Column, factor: float) -> Column:
    blocks = (replace(b, joint=replace(b.joint, stiffness=factor * b.joint.stiffness)) for b in column.blocks)
    return replace(column, blocks=tuple(blocks))


def stands(column: Column) -> bool:
    """By the frequencies of the differenced accelerations."""
    try:
        natural_frequencies(column)
    except SolverError:
        return False
    return True


def edge(column: Column, judge: Any) -> float:
    """The factor on all moduli from which on `judge` says that the column stands."""
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
    # started from elsewhere it is somebody's intention
    with pytest.warns(InputWarning, match="settles"):
        simulate(softened(phocas(), 1e5 / 5226944450.0), SHAKE, 0.01, initial=InitialState())


def test_a_thousand_blocks_are_judged() -> None:
    assert is_stable(stack(1e12, 100.0, 0.1, 1000))
    assert not is_stable(stack(1e7, 100.0, 0.1, 1000))


def test_weightless_columns_rest() -> None:
    column = replace(stack(1e3), g=0.0)
    assert is_stable(column)
    assert doubts(column) == []


def test_sound_columns_raise_no_doubt() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        simulate(phocas(), SHAKE)
    assert doubts(phocas()) == []


def test_settlement_and_pressure_are_doubted() -> None:
    flat = Column("flat", (Block(0.2, 2.0, 2.0, 1e5, Joint(5e6, 1e-3)),))
    (said,) = doubts(flat)
    assert said.startswith("block[1].joint.stiffness = 5e+06: block 1 settles by 0.049 m at rest, 0.25 of its height")
    with pytest.warns(InputWarning, match="0.25 of its height"):
        simulate(flat, SHAKE)
    (said,) = doubts(Column("heavy", (Block(4.0, 1.0, 1.0, 6e7, Joint(1e13, 1e-3)),)))
    assert said == (
        "joint 1: carries 5.88e+08 N on 1 m2 at rest, 588 MPa, which no stone does; mass is in kg, density in kg/m3, "
        "width and depth in m"
    )


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
        simulate(phocas(), SHAKE, initial=[0.0])  # type: ignore[arg-type]


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
    assert len(simulate(phocas(), SHAKE, np.float32(0.0625), output_step=np.int64(1)).time) == 1  # type: ignore[arg-type]
    values: tuple[Any, ...] = (True, "1", np.bool_(True), np.nan, np.array([1.0]))
    for key in ("duration", "output_step"):
        for value in values:
            with pytest.raises(InputError, match=f"^{key} = .*: must be a positive time in s$"):
                simulate(phocas(), SHAKE, **{key: value})
