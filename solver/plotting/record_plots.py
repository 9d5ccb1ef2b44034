"""Figures of records: base histories, Arias intensity, response spectrum (imported lazily, for matplotlib)."""

from __future__ import annotations

import os
from collections.abc import Mapping
from typing import Any

import numpy as np

from ..common.digits import percent
from ..common.errors import InputError
from ..ground.intensity import DAMPING, NAMES, components, histories, lines_of, spectrum
from ..ground.motion import STANDARD_GRAVITY, Motion
from .style import Figure, block_colours, header, plain, save, tidy

LONG_NAME = 40  # letters: two names in a line of the legend, not three
_STYLES: dict[str, str] = {"ax": "-", "ay": "-.", "az": "--"}


def plot_records(motions: Mapping[str, Motion], path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw motions under their names, and save the figure if `path` is given; a vertical component is dashed.

    Raises InputError if there is no motion, or one is zero; InputError, OSError as `save` does.
    """
    if not motions:
        raise InputError("no record to draw")
    figure = Figure(figsize=(10.0, 7.0), layout="constrained")
    halves: Any = figure.subfigures(1, 2, width_ratios=(1.3, 1.0))
    left, right = halves
    acceleration, velocity, displacement = left.subplots(3, 1, sharex=True)
    spectra, arias = right.subplots(2, 1)
    for (name, motion), colour in zip(motions.items(), block_colours(len(motions)), strict=True):
        # every component of a motion has its colour and its own line style
        there = components(motion)
        for component in there:
            base, lines = histories(motion, component), lines_of(motion, component)
            found = spectrum(motion, component=component)
            style = {"color": colour, "linewidth": 0.8, "linestyle": _STYLES[component]}
            label = plain(name if len(there) == 1 else f"{name}, {NAMES[component]}")
            ends = np.column_stack([lines.time[:-1], lines.time[1:]]).ravel()
            both = np.column_stack([lines.before, lines.after]).ravel()
            label += f", PGA {np.max(np.abs(both)) / STANDARD_GRAVITY:.3g} g"
            acceleration.plot(ends, both / STANDARD_GRAVITY, **style)
            velocity.plot(base.time, base.velocity, **style)
            displacement.plot(base.time, base.displacement, **style)
            arias.plot(base.time, base.husid, **style)
            spectra.plot(found.period, found.psa / STANDARD_GRAVITY, **(style | {"linewidth": 1.2}), label=label)
    # headings, units and ranges
    acceleration.set(title="(a) base acceleration", ylabel="g")
    velocity.set(title="(b) velocity, integrated from rest", ylabel="m/s")
    displacement.set(title="(c) displacement, no baseline taken away", ylabel="m", xlabel="time (s)")
    spectra.set(
        title=f"(d) pseudo-acceleration, {percent(DAMPING)} damping", ylabel="g", xlabel="period (s)", xscale="log"
    )
    spectra.set(xticks=(0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0), ylim=(0.0, None))
    spectra.set_xticklabels(["0.1", "0.2", "0.5", "1", "2", "5", "10"])
    spectra.minorticks_off()
    arias.set(title="(e) Arias intensity up to each instant", ylabel="m/s", xlabel="time (s)", ylim=(0.0, None))
    for axes in (acceleration, velocity, displacement, spectra, arias):
        tidy(axes)
    # legend and title
    left.align_ylabels()
    handles, labels = spectra.get_legend_handles_labels()
    columns = 3 if max(map(len, labels)) < LONG_NAME else 2
    figure.legend(handles, labels, loc="outside lower center", ncols=min(columns, len(labels)), frameon=False)
    header(figure, f"{len(motions)} base motions" if len(motions) > 1 else f"Base motion {next(iter(motions))}")
    return save(figure, path)
