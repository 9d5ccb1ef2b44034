"""Directional derivatives of every kind of FMU: all outputs by all inputs, against differences of what it shows."""

from __future__ import annotations

import importlib.util
import sys
from pathlib import Path

import numpy as np
import pytest
from support.child import call
from support.inside import derivatives as inside
from support.shaft import PORTS, SHAFT

from build_fmu import build_native_fmu
from fmu_src.drive import USUAL, Drive, drive_of

BLOCK = """
name = "post with a port"
[joints]
stiffness = 1e9
damping = 1e-3
[[block]]
name = "post"
width = 0.8
depth = 0.7
height = 2.0
density = 2000.0
on = "base"
[[port]]
name = "top"
block = "post"
at = [0.1, 0.2, 0.9]
"""
# masses of bodies at the base, light beside what stands on it, and a force that bears the weight of that
LIGHT = {"body.Mxx": 5e3, "body.Mzz": 4e3, "body.Mtt": 1e5}
PLANE = LIGHT | {"body.F0z": 2.12e5, "body.Mxz": 100.0, "body.Mxt": 300.0, "body.Mzt": -200.0}
SPACE = {"body.F0z": 2.2e4, "body.M": 1e6}
TURNING = SPACE | {"body.Jxx": 1e6, "body.Jyy": 2e6, "body.Jxy": 100.0, "body.Mxry": 300.0, "body.Myrx": -200.0}
MORTAR = "tensile_strength = 2e5\ncohesion = 3e5\nfriction = 0.6"
KINDS = {
    "column, horizontal": (SHAFT.format(joint=""), "horizontal", False, PLANE),
    "column with friction": (SHAFT.format(joint="friction = 0.05"), "acceleration", False, {}),
    "column with friction, body": (SHAFT.format(joint="friction = 0.05"), "body", False, PLANE),
    "column with friction, horizontal": (SHAFT.format(joint="friction = 0.05"), "horizontal", False, PLANE),
    "column with mortar": (SHAFT.format(joint=MORTAR), "acceleration", False, {}),
    "column with mortar, horizontal": (
        SHAFT.format(joint=MORTAR),
        "horizontal",
        False,
        PLANE,
    ),
    "column with ports": (SHAFT.format(joint="") + PORTS, "acceleration", False, {}),
    "column with ports and friction": (SHAFT.format(joint="friction = 0.05") + PORTS, "acceleration", False, {}),
    "column with ports, body": (SHAFT.format(joint="") + PORTS, "body", False, PLANE),
    "column with ports, horizontal": (SHAFT.format(joint="") + PORTS, "horizontal", False, PLANE),
    "structure": (BLOCK, "acceleration", False, {}),
    "structure, body": (BLOCK, "body", False, SPACE),
    "structure that turns": (BLOCK, "acceleration", True, {}),
    "structure that turns, body": (BLOCK, "body", True, TURNING),
    "structure that turns, horizontal": (BLOCK, "horizontal", True, TURNING),
}


CRACKING = "stiffness = 2e9\ndamping = 1e-3\nfriction = 0.6\ntensile_strength = 5e4\ncohesion = 1e6"
PIER = "width = 0.8\ndepth = 0.7\nheight = 2.0\ndensity = 2500.0"
MORTARS = {
    "column": (f'name = "pier"\n[[block]]\n{PIER}\n[joint]\n{CRACKING}\n', "joint[1].M"),
    "structure": (f'name = "pier"\n[joints]\n{CRACKING}\n[[block]]\nname = "a"\non = "base"\n{PIER}\n', "joint[1].My"),
}
# after a fall within 300 steps: what holds its state, and what goes on
FALLING = {
    "column, body": (SHAFT.format(joint="") + PORTS, "body", PLANE | {"body.F0x": 3e5}, 0.0),
    "structure": (BLOCK, "acceleration", {"base.ax": 8.0}, 0.0),
    "structure that goes on": (BLOCK, "acceleration", {"base.ax": 8.0}, 60.0),
}


def check(fmu: Path, mass: dict[str, float], moved: float, steps: int = 60, falls: bool = False) -> None:
    """Compare them, each beside the largest of its kind; moved: the least that the largest of them is."""
    found, overturned = call(inside.compare, fmu, {}, mass, steps)
    assert overturned == falls
    by_kind: dict[tuple[str, str], float] = {}
    for output, name, _, difference, _ in found:
        kind = output.split(".")[-1], name.split(".")[-1]
        by_kind[kind] = max(by_kind.get(kind, 0.0), abs(difference))
    assert max(by_kind.values()) > moved
    wrong = []
    for output, name, derivative, difference, rounding in found:
        largest = by_kind[output.split(".")[-1], name.split(".")[-1]]
        if abs(derivative - difference) > 1e-4 * abs(difference) + 2e-5 * largest + rounding:
            wrong.append((output, name, derivative, difference))
    assert not wrong, wrong[:20]


def test_of_a_column(native: Path) -> None:
    check(native, {}, 1.0)


def built(text: str, drive: Drive, folder: Path) -> Path:
    """Return the native FMU of a file with this text; skips the test where none is built."""
    if not importlib.util.find_spec("ziglang") or not sys.platform.startswith("linux"):
        pytest.skip("needs the extra native, and Linux")
    file, fmu = folder / "model.toml", folder / "model.fmu"
    file.write_text(text, encoding="utf-8")
    build_native_fmu(file, fmu, platforms=["linux64"], drive=drive)
    return fmu


@pytest.mark.long  # builds native FMUs
@pytest.mark.parametrize("kind", list(KINDS))
def test_of_every_kind(kind: str, tmp_path: Path) -> None:
    text, word, turns, mass = KINDS[kind]
    drive = USUAL._replace(turns=turns) if word == "acceleration" else drive_of(word, "parabola", 1, turns)
    check(built(text, drive, tmp_path), mass, 1e-6)


@pytest.mark.long  # builds native FMUs
@pytest.mark.parametrize("kind", list(MORTARS))
def test_rates_while_mortar_cracks(kind: str, tmp_path: Path) -> None:
    """Compare with differences of outputs: central ones, of a past with today's crack, halve the rate of the bond."""
    text, moment = MORTARS[kind]
    fmu = built(text, USUAL, tmp_path)
    outputs = ["bond[1].share", "joint[1].contact", "joint[1].N", moment]
    for found, differences in np.array(call(inside.rates_while_cracking, fmu, outputs)):
        assert differences[0] < -1.0  # 1/s: it cracks
        assert found == pytest.approx(differences, rel=2e-2)  # measured 1.1e-4; of N 5e-3


@pytest.mark.long  # builds native FMUs
@pytest.mark.parametrize("kind", list(FALLING))
def test_after_a_fall(kind: str, tmp_path: Path) -> None:
    """Compare rates with differences of outputs, too: they are zero of a state that is held."""
    text, word, mass, goes_on = FALLING[kind]
    after = (
        f"[neighbours]\nline_stiffness = 1e9\nrestitution = 0.2\nfriction = 0.3\nafter_fall = {goes_on}\n"
        if goes_on
        else ""
    )
    text = text.replace("[[block]]", f"{after}[[block]]", 1)
    fmu = built(text, drive_of(word, "parabola", 1, False), tmp_path)
    check(fmu, mass, -1.0 if kind == "structure" else 1e-6, 300, falls=True)  # nothing of it moves that is held
    for found, differences in np.array(call(inside.rates_after_a_fall, fmu, mass, 300)):
        assert (np.max(np.abs(differences)) > 0.1) == (goes_on > 0.0)
        assert found == pytest.approx(differences, rel=1e-5, abs=1e-6)  # measured 2.8e-8
