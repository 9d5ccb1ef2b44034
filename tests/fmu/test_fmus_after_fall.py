"""FMUs of structures that go on after a fall, against `simulate`, and their states amid it."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from support.child import call
from support.fmus import LINUX, ROOT, Fmus, built_once
from support.followed import native_of, outputs
from support.inside import structures as inside

from solver import Motion, simulate
from solver.models.structure.model import Structure

pytestmark = pytest.mark.long  # builds an FMU of its own; test_fmus_that_hit.py has one that is tried every time

SHOWCASE = (ROOT / "examples" / "structures" / "showcase.toml").read_text(encoding="utf-8")
GOES_ON = SHOWCASE.replace("[neighbours]", "[neighbours]\nafter_fall = 1.5")
POST = """
name = "post"
[joints]
stiffness = 2e9
damping = 3e-3
friction = 0.7
[[block]]
name = "post"
on = "base"
width = 0.4
depth = 0.4
height = 2.0
density = 2500.0
[[port]]
name = "top"
block = "post"
at = [0.0, 0.0, 2.0]
[solver]
tolerance = 1e-8
"""
H, DURATION = 0.02, 4.0  # s
STATUE = 1
SAMPLES = np.zeros((round(DURATION / H) + 1, 3))  # m/s2, a push of 0.6 s along x
SAMPLES[: round(0.6 / H), 0] = 4.0


@pytest.fixture(scope="module")
def showcase(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return the FMU of a statue that may fall on a showcase."""
    file = tmp_path_factory.mktemp("showcase") / "showcase.toml"
    file.write_text(GOES_ON, encoding="utf-8")
    return built_once(tmp_path_factory, "showcase.fmu", lambda path: Fmus.build(file, path))


def test_an_fmu_follows_a_run_after_the_fall(showcase: Path, tmp_path: Path) -> None:
    seen = outputs(showcase, SAMPLES, H, tmp_path, {"solver.tolerance": 1e-6})
    (tmp_path / "showcase.toml").write_text(GOES_ON, encoding="utf-8")
    structure = Structure.from_toml(tmp_path / "showcase.toml")
    response = simulate(
        structure, Motion.from_samples(H, SAMPLES[:, 0]), DURATION, tolerance=1e-6, output_step=H, settle=0.0
    )
    moved = seen[:, 2 * structure.n + STATUE]  # behind ux and uy of all blocks
    away = np.abs(moved - response.uz[1:, STATUE])
    assert response.overturn_time < 1.0
    # through the hit of the showcase, then as it comes to lie on the ground
    assert np.max(away[response.time[1:] < 1.9]) <= 1e-4  # m: measured 1.4e-5, at a tolerance of 1e-6
    assert np.max(away) <= 1e-3  # measured 4.3e-5
    assert -1.5 < moved[-1] < -1.4


def test_a_fallen_structure_is_held_as_in_a_run(tmp_path: Path) -> None:
    """Let the base, and a load, go on after the fall: nothing of the structure follows, nor do its peaks."""
    file, record = tmp_path / "post.toml", tmp_path / "record.csv"
    file.write_text(POST, encoding="utf-8")
    time = 0.01 * np.arange(401)
    motion = Motion.from_samples(
        0.01, 4.0 * np.sin(np.pi * time) * (time < 2.0) + 12.0 * np.sin(2.0 * np.pi * time) * (time >= 3.0)
    )
    motion.to_csv(record)
    response = simulate(Structure.from_toml(file), motion, output_step=0.01)
    assert response.overturn_time < 2.0
    pytest.importorskip("ziglang", reason="needs the extra native")
    fmu = Fmus.build(file, tmp_path / "post.fmu", *LINUX, "--record", record)
    found = call(inside.held, fmu, 400)
    assert found["peak"] == pytest.approx(response.peaks["port_ax"][0], rel=1e-7)  # measured 8e-11; 1.8 times before
    for shown in found["shown"]:
        assert shown == pytest.approx(response.port_ax[-1, 0], abs=1e-5)  # m/s2: measured 9e-7
    assert found["derivatives"] == [0.0, 0.0]


def test_states_amid_a_fall(showcase: Path) -> None:
    found = call(inside.life_of_a_fall, showcase)
    assert all(found.values()), found


def test_the_native_fmu_has_the_same_bits_after_the_fall(showcase: Path, tmp_path: Path) -> None:
    native = native_of(GOES_ON, tmp_path)
    assert np.array_equal(outputs(showcase, SAMPLES, H, tmp_path), outputs(native, SAMPLES, H, tmp_path))
    assert all(call(inside.life_of_a_fall, native).values())
