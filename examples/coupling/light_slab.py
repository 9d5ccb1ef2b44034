"""A light slab under a structure in space: a block of it, whose port a partner pushes as isolators do.

    python examples/coupling/light_slab.py

A trilith stands on a slab of 0.09 of its mass. Joints are elastic along themselves: they are far stiffer than the
isolators, so that an exchange at them diverges. The slab is a block of the structure instead, with a port, and the
partner gives a force with a slope. From place, velocity and acceleration of the port it predicts the motion over its
step, so that nothing is read after an input was set: all are read, all are set, all step.
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from multiblock import Motion, Structure, simulate
from solver.kernels.structure.layout import INPUT_LOADS
from solver.models.outputs import places_of
from solver.models.structure.driven import Chosen, DrivenStructure, packed
from solver.models.structure.outputs import OUTPUTS

Array = NDArray[np.float64]
TRILITH = Path(__file__).resolve().parent.parent / "structures" / "trilith.toml"
MASS = 2000.0  # kg, of the slab
STIFFNESS, DAMPING = 5e5, 4e4  # N/m, N s/m, of the isolators in either direction
FAR = 1e5  # m, to the other end of ties that stand for them: so their direction stays
EVERY, STEP = 0.02, 0.01  # s, between rows; between samples of the base
TOLERANCE = 1e-8
SEEN = ("x", "y", "vx", "vy", "ax", "ay")  # of the port


def on_slab(springs: bool = False) -> Structure:
    """Return the trilith on its slab, which slides freely on the base; springs: with isolators inside, as ties."""
    data: dict[str, Any] = tomllib.loads(TRILITH.read_text(encoding="utf-8"))
    slab = {"name": "slab", "on": "base", "at": [1.5, 0.0], "width": 4.5, "depth": 1.5, "height": 0.3, "mass": MASS}
    slab["joint"] = {"friction": 1e3, "shear_ratio": 1e-6, "damping": 1e-3}
    left, right, beam = data["block"]
    data["block"] = [slab, {**left, "on": "slab"}, {**right, "on": "slab"}, beam]
    data["port"] = [{"name": "slab", "block": "slab"}]
    law = {"between": ["slab", "base"], "stiffness": STIFFNESS, "damping": DAMPING, "tension_only": False}
    middle = np.array([1.5, 0.0, 0.15])
    ends = middle + FAR * np.eye(3)[:2]
    if springs:
        data["tie"] = [{**law, "from": [0.0, 0.0, 0.0], "to": end.tolist()} for end in ends]
    return Structure.from_dict(data)


def ground(duration: float) -> Motion:
    """Return a base motion in two directions, which lines join between samples."""
    t = STEP * np.arange(round(duration / STEP) + 1)
    grows = np.minimum(1.0, t)
    return Motion.from_samples(STEP, 3.0 * grows * np.sin(9.0 * t), ay=1.5 * grows * np.sin(7.0 * t))


def isolators(x: Array, v: Array) -> Array:
    """Return the force on the slab at places m and velocities m/s, N."""
    return -STIFFNESS * x - DAMPING * v


def couple(h: float, duration: float, law: Callable[[Array, Array], Array] = isolators) -> tuple[Array, Array]:
    """Return the places of slab and beam every 0.02 s under an exchange once in h s, m (rows, 2).

    Raises SolverError.
    """
    structure, motion = on_slab(), ground(duration)
    body = DrivenStructure(structure, packed(structure), Chosen(TOLERANCE))
    places = places_of(OUTPUTS, structure.sizes)
    port = np.concatenate([np.arange(*places[f"port_{name}"].indices(10**6)) for name in SEEN])
    beam = [places[name].stop - 1 for name in ("ux", "uy")]
    loads = np.zeros(INPUT_LOADS.size(1))
    slab, top = [], []
    for k in range(round(duration / h) + 1):
        t = k * h
        row = body.observe(t)  # before anything is set
        x, v, a = row[port].reshape(3, 2)
        if k % round(EVERY / h) == 0:
            slab.append(x.copy())
            top.append(row[beam].copy())
        now, then = law(x, v), law(x + h * v + 0.5 * h * h * a, v + h * a)
        loads[0:2], loads[6:8] = now, (then - now) / h
        first, last = (
            np.array([np.interp(s, motion.time, part) for part in (motion.ax, motion.ay)]) for s in (t, t + h)
        )
        slope = (last - first) / h
        body.drive(t, *first, 0.0, *slope, 0.0, *loads)
        body.advance(t, h)
    return np.array(slab), np.array(top)


def as_one(duration: float) -> tuple[Array, Array]:
    """Return the same of the structure with ties in place of the partner."""
    found = simulate(on_slab(True), ground(duration), duration, tolerance=TOLERANCE, output_step=EVERY, settle=0.0)
    top = np.column_stack([found.ux[:, -1], found.uy[:, -1]])
    return np.column_stack([found.port_x[:, 0], found.port_y[:, 0]]), top


def main() -> None:
    """Print the errors, in parts of the peaks, against the communication step."""
    duration = 4.0
    one = as_one(duration)
    print("step (ms)   slab      beam       of the largest displacement")
    for h in (10e-3, 5e-3, 2e-3, 1e-3):
        found = couple(h, duration)
        errors = [float(np.max(np.abs(a - b)) / np.max(np.abs(b))) for a, b in zip(found, one, strict=True)]
        print(f"{1e3 * h:8.3g}   {errors[0]:.1e}   {errors[1]:.1e}")


if __name__ == "__main__":
    main()
