"""Whole runs of an FMU in FMPy."""

from __future__ import annotations

import numpy as np
from fmpy import simulate_fmu


def simulate(
    fmu: str,
    duration: float,
    h: float,
    amplitude: float,
    frequency: float,
    output: str,
    start_values: dict[str, float | str],
) -> None:
    """Simulate for `duration` s at communication steps of h s under `amplitude` g at `frequency` Hz; save it."""
    time = h * np.arange(round(duration / h) + 1)
    motion = np.zeros(time.size, dtype=[("time", float), ("base.ax", float), ("base.az", float)])
    motion["time"] = time
    motion["base.ax"] = amplitude * 9.80665 * np.sin(2 * np.pi * frequency * time)
    result = simulate_fmu(fmu, stop_time=duration, output_interval=h, input=motion, start_values=start_values)
    np.save(output, np.asarray(result))
