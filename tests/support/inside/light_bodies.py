"""FMUs whose base bodies drive: the motion of the base that they show, and a step that is too long."""

from __future__ import annotations

import numpy as np

from support.instance import Instance


def said(body: Instance, mass: float, push: float, lift: float) -> dict[str, float]:
    """Return what a body of that mass says under forces along x and z, N."""
    if "body.M" in body.variables:
        return {"body.M": mass, "body.F0x": push, "body.F0z": lift}
    return {"body.Mxx": mass, "body.Mzz": mass, "body.Mtt": mass, "body.F0x": push, "body.F0z": lift}


def moved(fmu: str, output: str) -> None:
    """Save t, x, vx, ax and z of the base under a body so heavy that nothing else moves it, 0.1 and 0.2 m/s2."""
    body, mass, h, rows = Instance(fmu), 1e13, 4e-3, []
    for k in range(100):
        body.set(said(body, mass, 0.1 * mass, 0.2 * mass))
        body.step(h * k, h)
        rows.append([h * (k + 1), *body.get("driven.x", "driven.vx", "driven.ax", "driven.z")])
    np.save(output, np.array(rows))


def too_long(fmu: str, mass: float, steps: int) -> None:
    """Make steps of 4 ms with a body of that mass under what bears the weight."""
    body, h = Instance(fmu), 4e-3
    for k in range(steps):
        body.set(said(body, mass, 1.0, -body.get("base.Fz")[0] if k == 0 else 8e5))
        body.step(h * k, h)
