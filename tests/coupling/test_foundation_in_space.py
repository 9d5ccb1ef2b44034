"""A structure in space on a foundation that rocks in two directions, exchanged once a step, against both as one."""

from __future__ import annotations

import math
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.spatial.transform import Rotation
from support.fmus import ROOT, run
from support.probe import G
from support.shaft import ROCKING

from build_fmu import build_fmu, build_native_fmu
from fmu_src.body import StructureBody, read_body
from fmu_src.drive import Drive
from multiblock import Motion, Structure, simulate
from solver.common.errors import InputError, SolverError
from solver.kernels.layout.spaces import ACCELERATION, BODY, DRIVES, HORIZONTAL, SLOPE_LINE, SLOPE_PARABOLA, SLOPES
from solver.kernels.structure.layout import BASE, DRIVEN, DRIVEN_TURN
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.outputs import OUTPUTS

Array = NDArray[np.float64]
SIDE, DEEP, DENSITY, BED, ALONG = 2.0, 0.6, 2400.0, 1e8, 0.5  # m, m, kg/m3, N/m3, shear_ratio of the foundation
MASS = SIDE * SIDE * DEEP * DENSITY
SHAFT = {"name": "shaft", "width": 0.9, "depth": 0.7, "height": 2.5, "density": 2400.0}
JOINT = {"stiffness": 1e9, "damping": 2e-3}
MASSES = {"M": 6e3, "Mxry": -2e3, "Myrx": 1.5e3, "Jxx": 3e3, "Jyy": 4e3, "Jxy": 100.0}
AMPLITUDE, FREQUENCY, DURATION, ACROSS = 0.04 * G, 2.0, 0.6, 0.7  # m/s2, Hz, s, part of it along y
OMEGA = 2.0 * np.pi * FREQUENCY


def of_blocks(*blocks: dict[str, Any], **more: Any) -> Structure:
    return Structure.from_dict({"name": "rocking", "joints": JOINT, "block": list(blocks), **more})


def as_one() -> Array:
    """Return the displacement of the shaft along x and y, m, with the foundation as a block on its bed."""
    slab = {"name": "slab", "on": "base", "width": SIDE, "depth": SIDE, "height": DEEP, "density": DENSITY}
    slab["joint"] = {"stiffness": BED, "damping": 0.0, "shear_ratio": ALONG, "shear_damping": 0.0}
    whole = of_blocks(slab, {**SHAFT, "on": "slab"}, solver={"tolerance": 1e-10})
    time = 1e-4 * np.arange(round(DURATION / 1e-4) + 1)
    ax = AMPLITUDE * np.sin(0.5 * OMEGA * time) ** 2
    motion = Motion.from_samples(1e-4, ax, ay=ACROSS * ax)
    found = simulate(whole, motion, DURATION, output_step=0.02, settle=0.0)
    return np.column_stack([found.ux[:, 1] - found.ux[0, 1], found.uy[:, 1] - found.uy[0, 1]])


class Foundation:
    """A rigid slab on an elastic bed in full contact: its forces follow from its potential, by differences.

    place: of the middle of its top, m, relative to the ground; turn: rad, about x and y.
    """

    def __init__(self, weight: float) -> None:
        self.place, self.rate = np.array([0.0, 0.0, -weight / (BED * SIDE**2), 0.0, 0.0]), np.zeros(5)
        self.before: list[Array] = []
        about = MASS * (SIDE**2 + DEEP**2) / 12.0 + MASS * (0.5 * DEEP) ** 2
        arm = MASS * 0.5 * DEEP
        self.said_mass = MASS, -arm, arm, about, about, 0.0  # M, Mxry, Myrx, Jxx, Jyy, Jxy

    def potential(self, place: Array) -> float:
        whole = Rotation.from_rotvec([*place[3:], 0.0])
        foot = place[:3] + whole.apply([0.0, 0.0, -DEEP]) + [0.0, 0.0, DEEP]
        half = Rotation.from_rotvec([*(0.5 * place[3:]), 0.0])
        angle = np.hypot(*place[3:])
        kappa = place[3:] * (np.sin(0.5 * angle) / (0.5 * angle) if angle else 1.0)
        s1, s2, opening = half.inv().apply(foot)
        area, second = SIDE**2, SIDE**4 / 12.0
        bed = 0.5 * BED * (area * opening**2 + second * (kappa @ kappa))
        centre = place[2] + whole.apply([0.0, 0.0, -0.5 * DEEP])[2]
        return float(bed + 0.5 * ALONG * BED * area * (s1**2 + s2**2) + MASS * G * centre)

    def force(self) -> Array:
        steps = 1e-5 * np.eye(5)
        ahead = np.array([self.potential(self.place + step) - self.potential(self.place - step) for step in steps])
        return -ahead / 2e-5

    def move(self, h: float, line: bool, acceleration: Array) -> None:
        """Move it by the slope that the structure takes too; acceleration: relative to the ground."""
        slope = np.zeros(5)
        if self.before:
            slope = (acceleration - self.before[-1]) / h
        if len(self.before) > 1 and not line:
            slope = (11.0 * slope - 5.0 * (self.before[-1] - self.before[-2]) / h) / 6.0
        self.before.append(acceleration)
        self.place = self.place + h * self.rate + 0.5 * h * h * acceleration + h**3 / 6.0 * slope
        self.rate = self.rate + h * acceleration + 0.5 * h * h * slope


def coupled(h: float, line: bool = False) -> Array:
    """Return the same, exchanged once a step: all say their states, then all step."""
    structure = of_blocks({**SHAFT, "on": "base"})
    chosen = Chosen(1e-10, drive=BODY, slope=SLOPE_LINE if line else SLOPE_PARABOLA, turns=1.0)
    body, places = DrivenStructure(structure, packed(structure), chosen), places_of(OUTPUTS, structure.sizes)
    shaft_weight = sum(block.mass for block in structure.blocks) * G
    slab, rows = Foundation(MASS * G + shaft_weight), []
    mass, by_y, by_x, about, _, _ = slab.said_mass
    matrix = np.diag([mass, mass, mass, about, about])
    matrix[0, 4] = matrix[4, 0] = by_y
    matrix[1, 3] = matrix[3, 1] = by_x
    for k in range(round(DURATION / h) + 1):
        t = k * h
        row = body.observe(t)
        reaction = row[places["base"]][:5].copy()
        if k % round(0.02 / h) == 0:
            rows.append([row[places["ux"]][0] + slab.place[0], row[places["uy"]][0] + slab.place[1]])
        ground = AMPLITUDE * np.sin(0.5 * OMEGA * t) ** 2 * np.array([1.0, ACROSS, 0.0, 0.0, 0.0])
        force = slab.force()
        said = (*force[:3], mass, *force[3:], by_y, by_x, about, about, 0.0)
        body.drive(t, *[0.0] * 6, *[0.0] * 6, *said)
        body.advance(t, h)
        slab.move(h, line, np.linalg.solve(matrix, force + reaction) - ground)
    return np.array(rows) - rows[0]


@pytest.mark.long  # takes seconds
def test_errors_fall_as_the_rule_of_the_slope_says() -> None:
    """Check ground that begins smoothly: the line is of order 2, the parabola of order 3."""
    whole = as_one()
    size = float(np.max(np.abs(whole)))
    parabola = [float(np.max(np.abs(coupled(h) - whole))) / size for h in (2e-3, 1e-3, 5e-4)]
    line = [float(np.max(np.abs(coupled(h, line=True) - whole))) / size for h in (2e-3, 1e-3)]
    assert parabola[0] < 3e-5  # measured 1.5e-5, 1.9e-6, 3.0e-7
    assert parabola[1] < 4e-6
    assert parabola[0] / parabola[1] == pytest.approx(8.0, rel=0.25)
    assert parabola[1] / parabola[2] == pytest.approx(8.0, rel=0.4)
    assert line[0] < 4e-4  # measured 1.8e-4, 4.5e-5
    assert line[0] / line[1] == pytest.approx(4.0, rel=0.1)


def test_what_drives_a_turning_base_has_inertia() -> None:
    structure = of_blocks({**SHAFT, "on": "base"})
    body = DrivenStructure(structure, packed(structure), Chosen(1e-6, drive=BODY, turns=1.0))
    body.drive(0.0, *[0.0] * 12, 1.0, 0.0, 0.0, 1e4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    with pytest.raises(SolverError, match=r"body.M must be positive"):
        body.advance(0.0, 1e-3)
    body = DrivenStructure(structure, packed(structure), Chosen(1e-6, drive=HORIZONTAL, turns=1.0))
    body.drive(0.0, *[0.0] * 12, 1.0, 0.0, 0.0, 1e4, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    body.advance(0.0, 1e-3)  # turned by its inputs


def test_a_base_driven_horizontally_keeps_its_other_accelerations_before_a_body_sends_anything() -> None:
    structure = of_blocks({**SHAFT, "on": "base"})
    body = DrivenStructure(structure, packed(structure), Chosen(1e-6, drive=HORIZONTAL, turns=1.0))
    body.drive(0.0, 0.4, 0.5, 0.3, 0.0, 0.0, 0.7, 0.0, 0.0, 0.0, 0.0, 0.05, 0.02, *[0.0] * 11)
    body.advance(0.0, 1e-3)
    found = {name: float(body.arrays.base[BASE.fields.index(name)]) for name in ("ax", "ay", "az", "jz", "alpha_x")}
    assert found == {"ax": 0.0, "ay": 0.0, "az": 0.3, "jz": 0.7, "alpha_x": 0.05}


@pytest.mark.parametrize("drive", [ACCELERATION, BODY])
def test_outputs_before_the_first_step_are_those_of_the_base_as_it_begins(drive: float) -> None:
    """Check that the angle set last is in them, and that the run has the bits of one in which nothing was read."""
    structure, rows, sent = of_blocks({**SHAFT, "on": "base"}), [], [0.0, 0.0, 4e4, *MASSES.values()]
    bodies = [*sent[:4], 0.0, 0.0, *sent[4:]] if drive == BODY else [0.0] * 11
    places = places_of(OUTPUTS, structure.sizes)
    for before in ((), (2e-3, -5e-4), (math.nan, 2e-3)):
        body = DrivenStructure(structure, packed(structure), Chosen(1e-6, drive=drive, turns=1.0))
        for x in (*before, 1e-3):
            given = [0.0] * 6 + [x, 2.0 * x, 0.1 * x, -x, 0.0, 0.0]
            body.drive(5.0, *given, *bodies)
            if math.isnan(x):  # not known yet
                body.observe(5.0)
            elif before:
                seen = body.observe(5.0).copy()
                middle = 1.25  # m, of the shaft above the origin
                moved = [seen[places[name]][0] for name in ("ux", "uy", "rx", "ry")]
                assert moved == pytest.approx([2.0 * x * middle, -x * middle, x, 2.0 * x], rel=1e-4)
                if drive == BODY:
                    shown = body.seen[len(seen) + DRIVEN.beside :]
                    assert shown[: DRIVEN_TURN.fields.index("alpha_x")] == pytest.approx([x, 2.0 * x, 0.1 * x, -x])
        body.advance(5.0, 1e-3)
        rows.append(body.observe(5.001).tobytes() + body.arrays.state.tobytes())
    assert rows[0] == rows[1] == rows[2]


@pytest.mark.long
@pytest.mark.parametrize("drive", [Drive("body", "line", 1, True), Drive(turns=True)], ids=["by bodies", "by inputs"])
def test_fmus_of_both_kinds_turn_alike(drive: Drive, tmp_path: Path) -> None:
    """Compare with the bits of the solver: inputs in their order, and the same code without Python."""
    file, h, count = tmp_path / "rocking.toml", 2e-3, 100
    file.write_text(ROCKING, encoding="utf-8")
    read = read_body(file, drive=drive)
    assert isinstance(read, StructureBody)
    time: Array = h * np.arange(count + 1, dtype=np.float64)
    given: dict[str, Array] = {item.name: np.zeros(count + 1) for item in read.inputs}
    if drive.is_chosen:
        given |= {"body.F0x": 3e3 * np.sin(15.0 * time), "body.F0z": np.full(count + 1, 4e4)}
        given |= {"body.F0my": 1e3 * np.sin(11.0 * time), "body.F0mx": 2e3 * np.sin(9.0 * time)}
        given |= {f"body.{name}": np.full(count + 1, value) for name, value in MASSES.items()}
    else:
        given |= {"base.theta_x": 2e-3 * time**2, "base.omega_x": 4e-3 * time, "base.alpha_x": 4e-3 + 0.0 * time}
        given |= {"base.theta_y": 1e-3 * np.sin(5.0 * time), "base.omega_y": 5e-3 * np.cos(5.0 * time)}
    codes = DRIVES[drive.drive], SLOPES[drive.slope], 1.0, 1.0
    body = DrivenStructure(read.model, read.packed, Chosen(read.tolerance, 0.0, 1.0, *codes))
    rows = []
    for k in range(count):
        body.drive(time[k], *(given[name][k] for name in given))
        body.advance(time[k], h)
        rows.append(body.observe(time[k + 1]).copy())
    outputs = [item.name for item in read.table() if item.causality == "output"][: len(rows[0])]
    np.save(tmp_path / "given.npy", np.array(list(given.values())))
    fmus = [build_fmu(file, tmp_path / "python.fmu", drive=drive)]
    fmus.append(build_native_fmu(file, tmp_path / "native.fmu", platforms=["linux64"], drive=drive))
    found = []
    for fmu in fmus:
        run(sys.executable, "-c", FOLLOW, fmu, tmp_path / "given.npy", tmp_path / "rows.npy", h, *given, *outputs)
        found.append(np.load(tmp_path / "rows.npy"))
    size = np.max(np.abs(rows), axis=0)
    assert np.all(np.abs(found[0] - np.array(rows)) <= 1e-9 * size)
    assert np.array_equal(*found)
    assert np.max(size[:6]) > 1e-5


FOLLOW = """
import sys
import numpy as np
from support.instance import Instance
fmu, given, path, h, *names = sys.argv[1:]
model, given, h, rows = Instance(fmu), np.load(given), float(h), []
inputs, outputs = names[: len(given)], names[len(given) :]
for k in range(given.shape[1] - 1):
    model.set(dict(zip(inputs, given[:, k].tolist(), strict=True)))
    if k == 50:  # a step that is made again from its state is the same
        state = model.fmi.getFMUstate()
        model.step(h * k, h)
        model.fmi.setFMUstate(state)
    model.step(h * k, h)
    rows.append(model.get(*outputs))
np.save(path, rows)
model.close()
"""


def test_a_column_needs_no_option_to_turn() -> None:
    with pytest.raises(InputError, match=r"--turns: must be left out of a column in its plane"):
        read_body(ROOT / "examples" / "columns" / "phocas.toml", drive=Drive(turns=True))
