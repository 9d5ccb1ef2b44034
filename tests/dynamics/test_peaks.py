"""Peaks of all outputs are those of the motion, whichever rows are requested."""

from __future__ import annotations

import numpy as np
import pytest
from support.probe import G, monolith, phocas

from solver import Block, Column, InitialState, Joint, Motion, Response, simulate
from solver.kernels.layout import spaces as at
from solver.models.column.outputs import OUTPUTS
from solver.models.column.packing import carried_weights
from solver.models.column.response import friction_history
from solver.models.column.stepper import Stepper

DENSE = 2e-5  # s
SCENES = {
    "rocking": (phocas(1e-3), Motion.harmonic(0.15 * G, 1.0, 3.0)),
    "undamped": (phocas(), Motion.harmonic(0.1 * G, 1.0, 2.0)),
    "elastic": (phocas(), Motion.harmonic(0.02 * G, 2.0, 2.0)),
    "one block": (monolith(eta=1e-3), Motion.harmonic(0.15 * G, 1.0, 3.0)),
    "first order": (phocas(1e-3, formulation="paper"), Motion.harmonic(0.05 * G, 1.0, 1.0)),
    "mortar": (phocas(2e-2), Motion.harmonic(0.2 * G, 1.0, 2.0)),
    "sliding": (
        Column("two", (Block(2.0, 1.0, 1.0, 4000.0, Joint(3e9, 1e-3, friction=0.4)),) * 2),
        Motion.harmonic(0.8 * G, 1.5, 2.0),
    ),
    "held": (phocas(1e-3), Motion.from_samples(0.01, 0.5 * np.sin(0.07 * np.arange(200)), hold=True)),
}


HISTORIES = [output.field for output in OUTPUTS if not output.only_peak]


def of_rows(run: Response) -> dict[str, np.ndarray]:
    """Return the peaks as the rows show them."""
    found = {name: np.atleast_1d(np.max(np.abs(getattr(run, name)), axis=0)) for name in HISTORIES}
    found["contact"] = np.min(run.contact, axis=0)
    found["friction"] = np.max(friction_history(run.Tx, run.N, carried_weights(run.model)), axis=0)
    return found


@pytest.mark.parametrize("scene", SCENES)
def test_peaks_are_those_of_dense_rows(scene: str) -> None:
    column, motion = SCENES[scene]
    run = simulate(column, motion, settle=0.0, output_step=DENSE)
    assert set(run.peaks) == {*HISTORIES, "friction"}
    for name, seen in of_rows(run).items():
        peak = run.peaks[name]
        if name == "contact":
            assert np.all(peak <= seen + 1e-6)
            assert peak == pytest.approx(seen, abs=2e-4)
            continue
        # no row exceeds the peak by more than the tolerance; rows miss more if dashpots meet an impact
        assert np.all(seen <= peak * (1.0 + 1e-5)), name
        missed = 1e-4 if scene in ("undamped", "elastic") else 0.01
        missed = 0.1 if scene == "mortar" or name == "friction" else missed  # measured 0.04 at rows of 1e-5 s
        missed = 0.05 if scene == "sliding" else missed  # measured 0.021; 0.001 at rows of 5e-6 s
        assert peak == pytest.approx(seen, rel=missed), name


@pytest.mark.parametrize("scene", ["rocking", "undamped"])
def test_peaks_do_not_depend_on_the_rows(scene: str) -> None:
    column, motion = SCENES[scene]
    fine, coarse = (simulate(column, motion, settle=0.0, output_step=step) for step in (1e-4, 5e-3))
    for name, peak in fine.peaks.items():
        assert np.array_equal(peak, coarse.peaks[name])
    seen = of_rows(coarse)
    assert seen["N"][0] < 0.95 * coarse.peaks["N"][0]  # which the rows of 5 ms miss


def test_peak_of_a_spring_in_closed_form() -> None:
    """Check that a block that is pushed down oscillates about its weight by v sqrt(k m)."""
    stiffness, mass, speed = 1e9, 2000.0, 3e-3
    column = Column("block", (Block(1.0, 1.0, 1.0, mass, Joint(stiffness, 0.0)),))
    run = simulate(column, Motion.harmonic(0.0, 1.0, 0.5), output_step=0.1, initial=InitialState(opening_rate=[-speed]))
    swing = speed * np.sqrt(stiffness * mass)
    assert swing < mass * G
    assert run.peaks["N"] == pytest.approx(mass * G + swing, rel=1e-5)
    assert run.peaks["base_Fz"] == pytest.approx(mass * G + swing, rel=1e-5)
    assert run.peaks["sigma_max"] == pytest.approx(mass * G + swing, rel=1e-5)  # over 1 m2
    assert run.peaks["uz"] == pytest.approx((mass * G + swing) / stiffness, rel=1e-5)
    assert run.peaks["contact"] == pytest.approx(1.0, abs=1e-12)
    assert run.peaks["Tx"] == run.peaks["My"] == run.peaks["ry"] == 0.0


def test_without_peaks_those_of_ux_are_kept_and_the_steps_are_the_same() -> None:
    column, motion = SCENES["rocking"]
    with_them, without = simulate(column, motion), simulate(column, motion, without=("peaks",))
    assert set(without.peaks) == {"ux"}
    assert np.array_equal(with_them.peak_top_ux, without.peak_top_ux)
    assert np.array_equal(with_them.ux, without.ux)
    for name in ("steps", "evaluations"):
        assert with_them.stats[name] == without.stats[name]
    assert without.stats["looks"] < with_them.stats["looks"] < 0.2 * with_them.stats["evaluations"]


def test_peaks_of_a_run_in_short_calls_cover_what_is_seen_between_them() -> None:
    """Set new accelerations as a master does: they act at once, and so do the forces along the joints."""
    stepper, h = Stepper(phocas(1e-3)), 1e-3
    names = ("Tx", "N", "My", "S", "base_Fx", "base_Fz", "base_My")
    seen = {name: np.zeros(1 if name.startswith("base") else 3) for name in names}
    for k in range(1500):
        t = k * h
        stepper.drive(t, ax=0.2 * G * np.sin(6.0 * t), jx=0.2 * G * (np.sin(6.0 * (t + h)) - np.sin(6.0 * t)) / h)
        stepper.advance(t, h)
        row = stepper.observe(t + h)
        parts = at.ROW.see(row, 3)
        shown = vars(parts.joints) | {name: getattr(parts.base, name) for name in at.REACTION.fields}
        for output in OUTPUTS:
            if output.field in seen:
                seen[output.field] = np.maximum(seen[output.field], np.abs(shown[output.key]))
    peaks = stepper.peaks
    assert peaks["ry"][0] > 1e-3
    for name, most in seen.items():
        assert np.all(most <= peaks[name] * (1.0 + 1e-5)), name
        assert np.all(peaks[name] < 3.0 * most), name


def test_an_error_is_estimated_for_every_peak() -> None:
    column, motion = SCENES["rocking"]
    run = simulate(column, motion, duration=1.0, check=True, tolerance=3e-3)
    exact = simulate(column, motion, duration=1.0, tolerance=1e-10)
    assert run.estimated_error is not None
    assert set(run.estimated_error.peaks) == set(run.peaks)
    for name in ("ux", "ry", "N", "My", "sigma_max"):
        error = np.abs(run.peaks[name] - exact.peaks[name]) / exact.peaks[name]
        estimate = run.estimated_error.peaks[name]
        assert np.max(error) > 2e-6, name  # what is estimated is not rounding
        assert np.all(estimate >= 0.5 * error - 5e-7), name  # measured 0.60 to 1.22 of the error
        assert np.all(estimate <= 2.0 * error + 5e-7), name
