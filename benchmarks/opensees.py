"""The Column of Phocas in OpenSees: rigid elements, no-tension fibre joints, the scheme tuned by hand.

Blocks are stiff elastic elements with P-Delta, joints zero-length sections of 100 no-tension fibres, tied horizontally.
Damping is proportional to the stiffness of the joint at the end of the last step; with the current stiffness, which
jumps as fibres open, Newton's iterations do not converge. That law of damping differs from the solver's: damped
histories differ for steps of any length. Undamped, the two programs solve the same equations.
"""

from __future__ import annotations

import ctypes
import importlib.util
import math
import time as clock
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from solver import Column, simulate

from .right_hand_side import Array
from .scenes import Scene

FIBRES = 100
RIGIDITY = 1e3  # of the blocks, in parts of the stiffness of the joints
CONVERGED = 1e-6  # norm of the last increment (m and rad)
MOST_ITERATIONS = 20
RUNS = 3
TOLERANCE = 1e-9  # of the solver, for comparison
EARLY = 3.0  # s, in which damping and schemes hardly matter

# label, integrator, algorithm, step in s; those marked tuned compete
SCHEMES: tuple[tuple[str, tuple[Any, ...], str, float, bool], ...] = (
    ("HHT 0.9, modified Newton", ("HHT", 0.9), "ModifiedNewton", 5e-3, True),
    ("HHT 0.9, Newton", ("HHT", 0.9), "Newton", 5e-3, True),
    ("HHT 0.9, Newton", ("HHT", 0.9), "Newton", 1e-3, False),
    ("Newmark 1/2-1/4, Newton", ("Newmark", 0.5, 0.25), "Newton", 0.01, False),
    ("Newmark 1/2-1/4, Newton", ("Newmark", 0.5, 0.25), "Newton", 0.005, False),
    ("Newmark 1/2-1/4, Newton", ("Newmark", 0.5, 0.25), "Newton", 0.002, False),
)


def load() -> Any:
    """Return the module of OpenSees commands. Raises ImportError, OSError or RuntimeError."""
    found = importlib.util.find_spec("openseespylinux")
    if found is not None and found.origin is not None:
        # the wheel brings what its BLAS needs, but not where the loader looks for it
        for name in ("libgfortran.so.4", "libblas.so.3"):
            path = Path(found.origin).parent / "lib" / name
            if path.is_file():
                ctypes.CDLL(str(path), mode=ctypes.RTLD_GLOBAL)
    import openseespy.opensees as commands

    commands.logFile("/dev/null", "-noEcho")  # a message for every step that does not converge
    return commands


def build(ops: Any, column: Column, amplitude: float, frequency: float) -> int:
    """Build the column at rest under gravity, its base to be shaken (m/s2, Hz). Returns the node of the top face."""
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    ops.geomTransf("PDelta", 1)
    ops.node(0, 0.0, 0.0)
    ops.fix(0, 1, 1, 1)
    below, level = 0, 0.0
    joints = []
    for i, block in enumerate(reversed(column.blocks), start=1):
        bottom, centre, top = 10 * i, 10 * i + 1, 10 * i + 2
        b, d = block.joint_width, block.joint_depth
        ops.uniaxialMaterial("ENT", i, block.joint.stiffness)
        ops.section("Fiber", i)
        ops.patch("rect", i, FIBRES, 1, -0.5 * b, -0.5 * d, 0.5 * b, 0.5 * d)
        ops.node(bottom, 0.0, level)
        ops.node(centre, 0.0, level + block.resolved_centroid)
        ops.node(top, 0.0, level + block.height)
        ops.mass(centre, block.mass, block.mass, block.resolved_inertia)
        ops.equalDOF(below, bottom, 1)  # rigid in shear
        joint = 1000 + i
        ops.element("zeroLengthSection", joint, below, bottom, i, "-orient", 0, 1, 0, -1, 0, 0, "-doRayleigh", 1)
        joints.append(joint)
        modulus = RIGIDITY * block.joint.stiffness * b
        for element, ends in ((2000 + i, (bottom, centre)), (3000 + i, (centre, top))):
            ops.element("elasticBeamColumn", element, *ends, b * d, modulus, b**3 * d / 12.0, 1)
        below, level = top, level + block.height

    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    for i, block in enumerate(reversed(column.blocks), start=1):
        ops.load(10 * i + 1, 0.0, -block.mass * column.g, 0.0)
    _solve_by(ops, "Newton")
    ops.integrator("LoadControl", 0.1)
    ops.analysis("Static")
    ops.analyze(10)
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()

    damping = column.blocks[0].joint.damping
    if damping:
        ops.region(1, "-ele", *joints, "-rayleigh", 0.0, 0.0, 0.0, damping)
    ops.timeSeries("Trig", 2, 0.0, 1e3, 1.0 / frequency, "-factor", amplitude)
    ops.pattern("UniformExcitation", 2, 1, "-accel", 2)
    return below


def _solve_by(ops: Any, algorithm: str) -> None:
    ops.constraints("Plain")
    ops.numberer("RCM")
    ops.system("BandGeneral")
    ops.test("NormDispIncr", CONVERGED, MOST_ITERATIONS)
    ops.algorithm(algorithm)


def follow(
    ops: Any, top: int, scheme: tuple[Any, ...], algorithm: str, step: float, duration: float
) -> tuple[Array, float]:
    """Return the displacement of the top, m, at every step to the end or until it does not converge; seconds of the
    analysis.
    """
    _solve_by(ops, algorithm)
    ops.integrator(*scheme)
    ops.analysis("Transient")
    ux = [0.0]
    begin = clock.perf_counter()
    for _ in range(round(duration / step)):
        if ops.analyze(1, step):
            break
        ux.append(ops.nodeDisp(top, 1))
    return np.array(ux), clock.perf_counter() - begin


def measure(scenes: Mapping[str, Scene]) -> dict[str, Any]:
    """Measure every scheme in harmonic scenes, compared with `auto` where that is predictable: where joints
    are damped.
    """
    try:
        ops = load()
    except (ImportError, OSError, RuntimeError) as absent:
        return {"absent": f"not available ({absent}): needs the extra bench, Python 3.11 or less, libblas3, liblapack3"}
    rows = []
    own_peaks = {}
    for name, scene in scenes.items():
        amplitude, frequency, duration = scene.motion.amplitude, scene.motion.frequency, scene.duration
        known = simulate(scene.column, scene.motion, tolerance=TOLERANCE, settle=0.0)
        own_peaks[name] = float(np.max(np.abs(known.ux[known.time <= EARLY])))
        damped = scene.column.blocks[0].joint.damping > 0.0
        for label, scheme, algorithm, step, tuned in SCHEMES:
            seconds = math.inf
            for _ in range(RUNS if tuned else 1):
                top = build(ops, scene.column, amplitude, frequency)
                ux, lasted = follow(ops, top, scheme, algorithm, step, duration)
                seconds = min(seconds, lasted)
            time = step * np.arange(len(ux))
            ends = time[-1] >= duration - 0.5 * step
            deviation = np.interp(known.time, time, ux) - known.ux[:, 0]
            error = float(np.max(np.abs(deviation)) / np.max(np.abs(known.ux[:, 0])))
            rows.append(
                {
                    "column": name,
                    "scheme": label,
                    "step": step,
                    "tuned": tuned,
                    "seconds": seconds,
                    "reached": float(time[-1]),
                    "peak_3s": float(np.max(np.abs(ux[time <= EARLY + 0.5 * step]))),
                    "peak": float(np.max(np.abs(ux))),
                    "error": error if ends and damped else None,
                }
            )
    ops.wipe()
    return {"rows": rows, "fibres": FIBRES, "own_peaks_3s": own_peaks}
