"""Mirror images of columns under mirrored motions move mirrored, to the last bit, by every kind of step."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.off_axis import chipped, crooked, leaning
from support.probe import PHOCAS_STIFFNESS, G, phocas, random_column

from solver import Block, Column, Joint, Motion, Settings, simulate, simulate_many
from solver.models.column.outputs import OUTPUTS
from stress.cases import MIRRORED


def of(block: Block, n: int, **settings: Any) -> Any:
    """Return a column of n such blocks, which is its own mirror image."""
    return lambda sign: Column("symmetric", (block,) * n, Settings(**settings))


DRUM = Block(14.07 / 12, 1.56, 1.56, 81000.0 / 12, Joint(PHOCAS_STIFFNESS * 4.0, 1e-3))
ROUND = Block(4.5, 1.4, 1.4, 18000.0, Joint(4e9, 1e-3), section="circle")
FLAT = Block(1.2, 0.9, 0.9, 2000.0, Joint(5e8, 1e-3, friction=0.25))
# column by sign, amplitude (g), frequency (Hz), duration (s), what its statistics must show
CASES: dict[str, tuple[Any, float, float, float, str]] = {
    "modes": (lambda sign: phocas(1e-3), 0.005, 2.0, 2.0, "elastic_steps"),
    "modes off the axis": (lambda sign: leaning(sign=sign), 0.003, 2.0, 2.0, "elastic_steps"),
    "modes of a chipped column": (lambda sign: chipped(sign=sign), 0.003, 2.0, 2.0, "elastic_steps"),
    "off the axis": (lambda sign: crooked(sign=sign), 0.05, 2.0, 2.0, "rocking"),
    "implicit": (of(DRUM, 12), 0.1, 2.0, 0.5, "implicit_steps"),
    "round": (of(ROUND, 3), 0.2, 1.0, 2.0, "rocking"),
    "sliding": (of(FLAT, 2, tolerance=1e-6), 0.46, 2.0, 1.0, "events"),
}


def assert_mirrored(columns: tuple[Column, Column], motion: Motion, shows: str) -> None:
    run, mirrored = simulate(columns[0], motion, settle=0.0), simulate(columns[1], motion.mirrored(), settle=0.0)
    assert run.stats[shows] == mirrored.stats[shows] > 0
    assert np.array_equal(run.peak_top_ux, mirrored.peak_top_ux)
    for name, key in ((output.field, output.key) for output in OUTPUTS if not output.only_peak):
        sign = -1.0 if key in MIRRORED else 1.0
        wrong = f"{key} is not mirrored: MIRRORED in stress/cases.py, or its kernel"
        assert np.array_equal(sign * getattr(run, name), getattr(mirrored, name)), wrong


@pytest.mark.parametrize("case", CASES)
def test_by_every_kind_of_step(case: str) -> None:
    make, amplitude, frequency, duration, shows = CASES[case]
    assert_mirrored((make(1.0), make(-1.0)), Motion.harmonic(amplitude * G, frequency, duration), shows)


@pytest.mark.parametrize("n", [1, 4])
@pytest.mark.parametrize("formulation", ["exact", "paper"])
def test_in_either_formulation(formulation: str, n: int) -> None:
    """Check vertical motion too."""
    rng = np.random.default_rng(n)
    column = replace(random_column(rng, n, softest=1e9), settings=Settings(formulation, step=5e-5))
    samples = Motion.from_samples(0.01, rng.normal(size=60) * 3.0, rng.normal(size=60))
    for motion in (samples, Motion.harmonic(2.5 * G, 1.5, 0.6)):
        assert_mirrored((column, column), motion, "rocking")


def test_in_lanes() -> None:
    """Take a wave that opens joints: its mirror image began with modes, and its peak was 3e-7 m off."""
    column, motion = phocas(1e-3, tolerance=1e-3), Motion.harmonic(0.2 * G, 1.0, 2.0)
    table = simulate_many(column, [motion, motion.mirrored()], keep=("peak_top_ux", "path"))
    assert list(table["path"]) == ["lanes", "lanes"]
    assert np.array_equal(*table["peak_top_ux"])
