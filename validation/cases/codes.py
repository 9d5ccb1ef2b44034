"""A column of seven drums in several programs: one question, and what each says."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from benchmarks import opensees
from multiblock import Block, Column, Joint, Motion, simulate

from ..case import Case, Outcome
from ..pictures import BLUE, GREEN, GREY, INK, RED, label, panels
from ..rigid_block import FloatArray
from ..rims import label_of, on_rims

G = 9.80665  # m/s2
DRUMS, HEIGHT, CAPITAL = 7, 5.95, 0.21  # m: of the whole, of the slab on top
BOTTOM, TOP, DENSITY = 1.11, 0.90, 2620.0  # m, m, kg/m3; depth 1 m
PULSE, LEVEL, LENGTH = 0.8, 0.2, 5.0  # s; g for PULSE, then minus half of it for twice as long; s
STIFFNESSES = (4e9, 5e10)  # N/m3, of two versions of that example
DAMPINGS = (0.0, 1e-3)  # s
STEP = 5e-4  # s, of the other programs
FRICTION = 0.7
UNFELT = 1e-9  # m/s2, of the sine that the benchmark's model has; with 0, OpenSees has no finite acceleration
ROW = 0.005  # s, of the histories
DEPTH, STRIPS = 1.0, 16  # m; of equal width, of a joint that bears at its edges
LONG = 40.0  # times the depth: the other programs are planar, and touch at edges or corners alone

History = tuple[FloatArray, FloatArray]  # s, m


def column(stiffness: float, damping: float) -> Column:
    """Return tapered drums, 1 m deep, and the slab on top of them; the top one first."""
    drum = (HEIGHT - CAPITAL) / DRUMS

    def width(level: float) -> float:
        return BOTTOM - (BOTTOM - TOP) * level / HEIGHT

    blocks = []
    for low, height in [(k * drum, drum) for k in range(DRUMS)] + [(HEIGHT - CAPITAL, CAPITAL)]:
        below, above = width(low), width(low + height)
        mass = DENSITY * 0.5 * (below + above) * height
        blocks.append(Block(height, below, 1.0, mass, Joint(stiffness, damping), top_width=above))
    return Column("seven-drums", tuple(reversed(blocks)), g=G)


def on_its_edges(whole: Column) -> Column:
    """Return the column with joints that bear at both edges alone, equally stiff in all, as HybriDFEM has them."""
    edges = (DEPTH, *[0.0] * (STRIPS - 2), DEPTH)
    blocks = [
        replace(
            block,
            joint=replace(block.joint, section="strips", strips=edges, stiffness=0.5 * STRIPS * block.joint.stiffness),
        )
        for block in whole.blocks
    ]
    return replace(whole, blocks=tuple(blocks))


def on_planar_rims(whole: Column, share: float) -> Column:
    """Return the same on rims of this part of the width; LONG across the motion, so that no band along it bears."""
    blocks = [replace(block, depth=LONG * block.depth, mass=LONG * block.mass) for block in whole.blocks]
    return on_rims(replace(whole, blocks=tuple(blocks)), share)


def pulse(level: float = LEVEL, length: float = PULSE) -> Motion:
    """Return the base acceleration, held: level (g) for length (s), then half of it the other way for twice as long."""
    return Motion.from_samples(length, [level * G, -0.5 * level * G, -0.5 * level * G], hold=True)


def acceleration(t: float) -> float:
    """Return the acceleration at an instant, m/s2."""
    return LEVEL * G if t < PULSE else (-0.5 * LEVEL * G if t < 3.0 * PULSE else 0.0)


def here(drums: Column) -> History:
    """Return the top displacement by this solver."""
    found = simulate(drums, pulse(), LENGTH, tolerance=1e-7, output_step=ROW, settle=0.0)
    return found.time, found.ux[:, 0]


def by_opensees(stiffness: float, damping: float) -> History:
    """Solve by rigid elements and joints of no-tension fibres, HHT 0.9, as in the benchmarks.

    Raises if it is absent.
    """
    ops = opensees.load()
    top = opensees.build(ops, column(stiffness, damping), UNFELT, 1.0)
    time = STEP * np.arange(round(LENGTH / STEP) + 2)
    values = [acceleration(t - 0.5 * STEP) for t in time]
    ops.timeSeries("Path", 3, "-dt", STEP, "-values", *values)
    ops.pattern("UniformExcitation", 3, 1, "-accel", 3)
    ux, _ = opensees.follow(ops, top, ("HHT", 0.9), "Newton", STEP, LENGTH)
    ops.wipe()
    return STEP * np.arange(len(ux), dtype=np.float64), ux


def by_mujoco(time_constant: float) -> History:
    """Solve by rigid boxes with soft contacts of this time constant (s), 0.02 by default, friction FRICTION.

    Gravity carries the motion: the base is at rest in its own frame. A body of MuJoCo cannot taper: boxes of the mean
    width, their mass and height kept.
    """
    import mujoco

    level, bodies = 0.0, []
    for k, block in enumerate(reversed(column(STIFFNESSES[0], 0.0).blocks)):
        half = 0.25 * (block.width + (block.top_width or block.width))
        bodies.append(
            f'<body name="b{k}" pos="0 0 {level + 0.5 * block.height}"><joint type="slide" axis="1 0 0"/>'
            f'<joint type="slide" axis="0 0 1"/><joint type="hinge" axis="0 1 0"/>'
            f'<geom type="box" size="{half} 0.5 {0.5 * block.height}" mass="{block.mass}"/></body>'
        )
        level += block.height
    model = mujoco.MjModel.from_xml_string(
        f'<mujoco><option timestep="{STEP}" cone="elliptic" integrator="implicitfast"/><default>'
        f'<geom friction="{FRICTION} 0 0" condim="3" solref="{time_constant} 1"/></default>'
        f'<worldbody><geom type="plane" size="50 50 1"/>{"".join(bodies)}</worldbody></mujoco>'
    )
    state = mujoco.MjData(model)
    for _ in range(round(0.5 / STEP)):  # it settles first
        mujoco.mj_step(model, state)
    last, rows = len(bodies) - 1, []
    half = 0.5 * CAPITAL
    for k in range(round(LENGTH / STEP)):
        model.opt.gravity[0] = -acceleration(k * STEP)
        mujoco.mj_step(model, state)
        x, _, angle = state.qpos[3 * last : 3 * last + 3]
        rows.append(x + half * math.sin(angle))
    return STEP * np.arange(1, len(rows) + 1, dtype=np.float64), np.array(rows)


def compute(data: Path | None, rims: Sequence[float] = ()) -> Outcome:
    """Run all programs that are installed."""
    found: dict[str, History] = {}
    absent = []
    for k in STIFFNESSES:
        for eta in DAMPINGS:
            found[f"here, k = {k:.0e}, eta = {eta:g}"] = here(column(k, eta))
    for k in STIFFNESSES:
        try:
            found[f"OpenSees, k = {k:.0e}, eta = 0"] = by_opensees(k, 0.0)
        except (ImportError, OSError, RuntimeError) as missing:
            absent.append(f"OpenSees: {missing}")
            break
    for constant in (0.02, 0.002):
        try:
            found[f"MuJoCo, solref {constant:g} s"] = by_mujoco(constant)
        except ImportError as missing:
            absent.append(f"MuJoCo: {missing}")
            break
    drawn = dict(found)
    for k in STIFFNESSES:
        for eta in DAMPINGS:
            found[f"here, edges alone, k = {k:.0e}, eta = {eta:g}"] = here(on_its_edges(column(k, eta)))
        for share in rims:
            found[f"here, {label_of(share)}, k = {k:.0e}, critical"] = here(on_planar_rims(column(k, 0.0), share))
    early = 3.0 * PULSE
    lines = ["largest displacement of the top, m, within the pulse (2.4 s) and within 5 s; at the end of the pulse:"]
    numbers: dict[str, Any] = {}
    for name, (time, ux) in found.items():
        row = [np.max(np.abs(ux[time <= early])), np.max(np.abs(ux)), np.interp(early, time, ux), time[-1]]
        numbers[name] = row
        lines.append(f"  {name:42s} {row[0]:8.4f} {row[1]:8.4f} {row[2]:9.4f}")
    lines += [f"  absent: {text}" for text in absent]
    return Outcome(lines, numbers, draw(drawn))


def draw(found: dict[str, History]) -> Figure:
    """Draw the histories of the top."""
    figure, axes = panels(1, width=8.4)
    axis = axes[0, 0]
    colours = iter((BLUE, GREEN, INK, GREY, RED, "#e39b7b", "#8e44ad", "#c39bd3"))
    for name, (time, ux) in found.items():
        line = "-" if name.startswith("here") else "--"
        axis.plot(time, ux, line, color=next(colours), linewidth=1.1, label=name)
    axis.set_ylim(-1.2, 1.2)
    axis.legend(fontsize=7, ncols=2)
    label(axis, "time, s", "displacement of the top, m", "seven drums and a slab, +0.2 g for 0.8 s, -0.1 g for 1.6 s")
    return figure


CASE = Case(
    name="codes",
    title="a column of seven drums in this solver, OpenSees and MuJoCo",
    source="sizes and pulse of an example of HybriDFEM (github.com/thlgrs/HybriDFEM)",
    model="seven tapered drums and a slab, rectangles 1 m deep, no sliding but in MuJoCo (friction 0.7)",
    fitted="nothing",
    predicted="displacement of the top",
    compute=compute,
    takes_rims=True,
)
