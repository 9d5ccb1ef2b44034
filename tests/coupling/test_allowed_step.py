"""Bodies that drive the base: the longest stable step, and the motion of the base that FMUs show."""

from __future__ import annotations

import importlib.util
import math
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm
from support.child import ended
from support.fmus import DAMPED, ROOT
from support.inside import light_bodies as inside

from build_fmu import build_fmu, build_native_fmu
from fmu_src.drive import drive_of
from multiblock import Column
from solver.kernels.engine.allowed_step import longest_step
from solver.kernels.layout.spaces import SLOPES
from solver.kernels.numba_ext.jit import from_python
from solver.models.column.stepper import Stepper

G = 9.80665
TRILITH = ROOT / "examples" / "structures" / "trilith.toml"


@from_python
def longest(way: float, h: float, dashpot: float, spring: float, moved: float, mass: float) -> float:
    return longest_step(way, h, dashpot, spring, moved, mass)


@pytest.mark.parametrize(
    ("slope", "rate", "heaviest"), [("held", 2.0, 1.0), ("line", 1.0, 3.0), ("parabola", 6.0 / 11.0, 19.0 / 3.0)]
)
def test_of_dashpots_in_closed_form(slope: str, rate: float, heaviest: float) -> None:
    """Check light bases: h = rate M / c. Beyond `heaviest` times the mass on the dashpots any step is stable.

    The recurrence changes its sign at every step where it begins to grow. Steps are tried 5 % apart.
    """
    way = SLOPES[slope]
    exact = rate * 1e3 / 1e6
    assert exact / 1.06 < longest(way, 0.05, 1e6, 1.0, 1e9, 1e3) < 1.01 * exact
    assert exact / 1.06 < longest(way, 0.05, 1e6, 0.0, 1e9, 1e3) < 1.01 * exact  # bearings without a spring
    assert longest(way, 0.05, 1e6, 1.0, 100.0, 1.05 * heaviest * 100.0) == math.inf
    assert longest(way, 0.05, 1e6, 1.0, 100.0, 0.95 * heaviest * 100.0) < 0.05


def largest_root(slope: str, h: float, dashpot: float, spring: float, moved: float, mass: float) -> float:
    """Return the spectral radius of the recurrence, from the matrix exponential: d, v, this and the last force."""
    drive, now, last = np.zeros((4, 4)), np.array([spring, dashpot, 0.0, 0.0]) / mass, np.eye(4)[2]
    drive[0, 1], drive[2, 3], drive[1] = 1.0, 1.0, (-spring / moved, -dashpot / moved, -1.0, 0.0)
    rates = {"held": 0.0 * now, "line": now - last, "parabola": (11.0 * now - 16.0 * last + 5.0 * np.eye(4)[3]) / 6.0}
    start = np.vstack([np.eye(4)[:2], now, rates[slope] / h])
    step = np.vstack([(expm(drive * h) @ start)[:2], now, last])
    return float(np.abs(np.linalg.eigvals(step)).max())


@pytest.mark.parametrize("slope", list(SLOPES))
def test_against_the_spectral_radius(slope: str) -> None:
    """Check 300 random systems, within the 5 % by which steps are tried.

    A hundred steps were compared with the hundred before them, so that a slow vibration that rose towards its first
    peak passed for an instability: steps came out up to 250 times too short.
    """
    rng, way, unstable = np.random.default_rng(1), SLOPES[slope], 0
    for _ in range(300):
        moved, ratio, omega = 10.0 ** rng.uniform((1.0, -2.0, 0.0), (5.0, 2.5, 3.0))
        damping = rng.integers(0, 2) * 10.0 ** rng.uniform(-3.0, 1.5)
        system = 2.0 * damping * omega * moved, moved * omega**2, moved, moved * ratio
        h = 10.0 ** rng.uniform(-4.0, -1.0)
        found = longest(way, h, *system)
        assert (found == math.inf) == (largest_root(slope, h, *system) <= 1.005)
        if found < math.inf:
            unstable += 1
            assert largest_root(slope, found, *system) < 1.00501
            assert largest_root(slope, min(1.051 * found, h), *system) > 1.00499
    assert 30 < unstable < 270


@pytest.mark.parametrize("faster", [1e-3, 1.0, 1e3, 1e5])
def test_a_step_scales_with_the_times_of_the_system(faster: float) -> None:
    """Check models of all sizes: it was 1e-5 s at least, though unstable, and 0.1 s at most."""
    for slope in SLOPES:
        way, step = SLOPES[slope], longest(SLOPES[slope], 0.05, 1e4, 1e6, 1e3, 100.0)
        found = longest(way, 0.05 / faster, faster * 1e4, faster**2 * 1e6, 1e3, 100.0)
        assert found == pytest.approx(step / faster, rel=0.06)  # steps are tried 5 % apart
        assert longest(way, 1.1 * found, faster * 1e4, faster**2 * 1e6, 1e3, 100.0) == pytest.approx(found, rel=0.06)
        assert longest(way, 0.999 * found, faster * 1e4, faster**2 * 1e6, 1e3, 100.0) == math.inf


def on_free_body(h: float, slope: str, mass: float, steps: int) -> tuple[float, float]:
    """Return the largest acceleration of a free body under a column after `steps`, and the step it is warned of."""
    column = Column.from_toml(DAMPED)
    weight = G * sum(block.mass for block in column.blocks)
    stepper = Stepper(column.with_settings(tolerance=1e-8))
    stepper.driven_by("body", slope, 1)
    largest = 0.0
    for k in range(steps):
        pull = weight + (1e3 if k < 2 else 0.0)
        stepper.drive(k * h, *[0.0] * 7, 0.0, pull, 0.0, mass, 0.0, 0.0, mass, 0.0, 2.0 * mass)
        stepper.advance(k * h, h)
        largest = max(largest, abs(float(stepper.base.az))) if k > steps // 2 else largest
    return largest, float(stepper.base.allowed_step)


@pytest.mark.parametrize("slope", list(SLOPES))
def test_columns_on_a_light_body(slope: str) -> None:
    """Check a free body of 30 t: below the step that is named the motion fades, above it grows.

    That of `held` is named from the lowest block alone, and is 1.5 times too short here: upper joints damp it too.
    """
    mass = 30e3
    _, named = on_free_body(4e-3, slope, mass, 3)
    assert 0.5e-3 < named < 4e-3
    fading, none = on_free_body(0.85 * named, slope, mass, 200)
    growing, again = on_free_body((2.0 if slope == "held" else 1.3) * named, slope, mass, 60)
    assert none == 0.0
    assert again == pytest.approx(named, rel=0.06)
    assert fading < 1e-3
    assert growing > 1.0


@pytest.mark.long  # builds FMUs
@pytest.mark.parametrize("model", [DAMPED, TRILITH], ids=["column", "structure"])
@pytest.mark.parametrize("kind", ["python", pytest.param("native", marks=pytest.mark.long)])
def test_fmus_show_the_motion_of_the_base_and_say_which_step_is_too_long(
    model: Path, kind: str, tmp_path: Path
) -> None:
    """Check that a heavy body under a constant force moves as in closed form; with a light one a step is too long: said
    once.
    """
    fmu, drive = tmp_path / "driven.fmu", drive_of("body", "line", 1)
    if kind == "python":
        build_fmu(model, fmu, drive=drive)
    else:
        if not importlib.util.find_spec("ziglang") or not sys.platform.startswith("linux"):
            pytest.skip("needs the extra native, and Linux")
        build_native_fmu(model, fmu, platforms=["linux64"], drive=drive)
    assert "stable up to" not in said(fmu, inside.moved, tmp_path / "rows.npy")
    t, x, vx, ax, z = np.load(tmp_path / "rows.npy").T
    assert x == pytest.approx(0.5 * 0.1 * t * t, rel=1e-6)
    assert vx == pytest.approx(0.1 * t, rel=1e-6)
    assert ax == pytest.approx(0.1, rel=1e-6)
    assert z == pytest.approx(0.5 * 0.2 * t * t, rel=1e-5)
    warned = said(fmu, inside.too_long, 2e3, 4)
    assert warned.count("the coupling is stable up to steps of about") == 1
    assert "communication step = 0.004 s: with the masses" in warned


def said(fmu: Path, function: Callable[..., object], *arguments: object) -> str:
    """Return what is said while a function is called with an FMU: by its logger, which a PythonFMU repeats."""
    done = ended(function, fmu, *arguments)
    assert done.returncode == 0, done.stderr
    return done.stderr if "stable up to" in done.stderr else done.stdout
