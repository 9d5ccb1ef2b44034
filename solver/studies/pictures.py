"""Pictures of studies, each with a caption about its runs. Imported late, for matplotlib."""

from __future__ import annotations

import math
import os
import textwrap
from collections.abc import Callable, Mapping, Sequence
from itertools import cycle
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.colors import BoundaryNorm
from matplotlib.ticker import ScalarFormatter
from numpy.typing import NDArray

from ..common.errors import InputError
from ..common.notebook import counted
from ..models.protocol import FloatArray
from ..models.structure.blocks.parts import OF_COLUMN
from ..models.structure.numbers import unit_in_space
from ..models.uncertainty import PERCENTILES
from ..plotting.style import (
    BLUE,
    FEW_COLOURS,
    GREEN,
    RED,
    Figure,
    block_colours,
    header,
    plain,
    save,
    show_blocks,
    tidy,
)
from .contents import FAILED
from .motions import Measure
from .results import Results
from .risk import Risk
from .statistics import (
    LEAST_GAP,
    Fragility,
    Limit,
    bounds_of,
    check_made,
    failed_of,
    failure_text,
    failures_of,
    fit_fragility,
    ida_curves,
    influences,
    intensity_name,
    made,
    measure_in,
    other_varied_name,
    percentiles,
    undecided_text,
)
from .subjects import subject_from

WIDTH = 138  # characters of a line of the caption
LONG = 45  # most characters of names in a title
MOST_CURVES = 300  # largest number of single curves that are drawn
MOST_INFLUENCES = 12
MOST_NAMED = 8  # curves that have names
_OF_LAWS = ("joint", "bearing")  # beginnings of names of numbers of the laws of joints
_LIMIT_COLOURS = (BLUE, GREEN, RED, *FEW_COLOURS[3:])


def draw(results: Results, path: str | os.PathLike[str] | None = None) -> Figure:
    """Draw the picture for the kind of the study, and save it to `path` if given.

    Raises InputError as `check_made` does, or if the grid lacks a name that the picture needs, or if the picture would
    mix columns or values of another name.
    """
    check_made(results)
    kind, grid = results.study["kind"], results.study["grid"]
    picture = f"the picture of kind = {kind}"
    if kind in _NEEDS:
        for name in _NEEDS[kind]:
            if name not in grid:
                raise InputError(f"grid.{name}: missing, {picture} needs it")
        for name in grid:
            if name not in (*_NEEDS[kind], "intensity"):
                raise InputError(f"grid.{name}: must be left out, {picture} would mix its values")
        if len(results.study["columns"]) > 1:
            raise InputError(f"columns: must be one, {picture} would mix them")
    figure = _DRAW[kind](results)
    return save(figure, path)


def draw_sweep(results: Results) -> Figure:
    """Draw the peak displacement of every block over the frequency, a panel for each intensity.

    With several motions or samples a band shows their percentiles. A lower panel shows the share that overturns over
    frequency and intensity.
    """
    levels, frequencies = np.unique(results["intensity"]), np.unique(results["motion.frequency"])
    shown = levels if len(levels) <= 3 else levels[[0, len(levels) // 2, -1]]
    boundary = len(levels) > 2
    figure = Figure(figsize=(10.0, 9.5 if boundary else 6.6), layout="constrained")
    grid = figure.add_gridspec(2 if boundary else 1, len(shown))
    panels: list[Axes] = []
    blocks = results.head["blocks"]
    colours = block_colours(blocks)
    runs = len(results.study["motions"]) * results.study["samples"]  # at each point
    for k, level in enumerate(shown):
        axes = figure.add_subplot(grid[0, k], sharey=panels[0] if panels else None)
        panels.append(axes)
        chosen = results["intensity"] == level
        # median and band of each block
        points, fell = _by_frequency(results, frequencies, chosen)
        for i, colour in enumerate(colours):
            axes.plot(frequencies, 1e3 * points[1, :, i], "o-", color=colour, linewidth=1.0, markersize=2.5)
            if runs > 1:
                low, high = 1e3 * points[0, :, i], 1e3 * points[2, :, i]
                axes.fill_between(frequencies, low, high, color=colour, alpha=0.25, linewidth=0.0)
        # marks at the top where all or some columns overturn
        top = axes.get_xaxis_transform()  # Hz horizontally, fraction of the panel vertically
        some = (fell > 0.0) & (fell < 1.0)
        for marker, name, there in (("^", "all overturned", fell >= 1.0), ("2", "some overturned", some)):
            if np.any(there):
                x = frequencies[there]
                axes.plot(x, np.full_like(x, 0.97), marker, color="black", transform=top, label=name)
        if axes.get_legend_handles_labels()[0]:
            axes.legend(loc="upper right", bbox_to_anchor=(1.0, 0.95), frameon=False)
        axes.set_yscale("log")
        axes.set(title=_level(results, level), xlabel="frequency (Hz)")
        tidy(axes)
    of = "centroid" if "sizes" in results.head else "top face"
    panels[0].set_ylabel(f"peak displacement of the {of} (mm)")
    if boundary:
        _draw_boundary(figure.add_subplot(grid[1, :]), figure, results, levels, frequencies)
    show_blocks(figure, panels, colours, "outside right upper")
    text = f"Curves: the median of those that stand, of {runs} runs at each point; bands: 16 to 84 %."
    return _captioned(figure, results, text if runs > 1 else "")


def _by_frequency(
    results: Results, frequencies: FloatArray, chosen: NDArray[np.bool_]
) -> tuple[FloatArray, FloatArray]:
    """Return percentiles of the peaks of the runs that stand, and the share that fell, by frequency.

    Parameters
    ----------
    results : Results
        The results.
    frequencies : (frequencies,) float
        Frequencies (Hz).
    chosen : (runs,) bool
        The runs used.

    Returns
    -------
    points : (3, frequencies, blocks) float
        Percentiles (m); NaN where no run stands.
    fell : (frequencies,) float
        Share of the finished runs that fell; NaN without one.
    """
    points = np.full((len(PERCENTILES), len(frequencies), results.head["blocks"]), math.nan)
    fell = np.zeros(len(frequencies))
    for k, frequency in enumerate(frequencies):
        here = chosen & (results["motion.frequency"] == frequency)
        here &= made(results)
        stands = here & ~results.overturned
        if np.any(stands):
            points[:, k] = percentiles(results.displacements[stands])
        fell[k] = np.mean(results.overturned[here]) if np.any(here) else math.nan
    return points, fell


def _draw_boundary(axes: Axes, figure: Figure, results: Results, levels: FloatArray, frequencies: FloatArray) -> None:
    """Draw the share that overturns over frequency and intensity, and the contour of one half."""
    share = np.full((len(levels), len(frequencies)), math.nan)
    cell = np.searchsorted(levels, results["intensity"]), np.searchsorted(frequencies, results["motion.frequency"])
    runs, fell = np.zeros_like(share), np.zeros_like(share)
    np.add.at(runs, cell, made(results))
    np.add.at(fell, cell, results.overturned)
    share = np.divide(fell, runs, out=share, where=runs > 0.0)
    mesh = axes.pcolormesh(frequencies, levels, share, cmap="Reds", vmin=0.0, vmax=1.0, shading="nearest")
    figure.colorbar(mesh, ax=axes, label="share that overturns")
    if np.nanmax(share) > 0.0 and np.nanmin(share) < 1.0:
        axes.contour(frequencies, levels, np.ma.masked_invalid(share), [0.5], colors="black", linewidths=1.2)
    axes.set(title="overturning: half of the runs along the line", xlabel="frequency (Hz)")
    axes.set_ylabel(_label(results, intensity_name(results)))
    tidy(axes, grid=False)


def draw_ida(results: Results) -> Figure:
    """Draw the intensity over the largest displacement: each curve, and its 16, 50 and 84 % points.

    Where the columns fall the curves have a gap.
    """
    curves = ida_curves(results)
    figure = Figure(figsize=(10.0, 6.6), layout="constrained")
    axes, fallen = figure.subplots(1, 2, sharey=True, width_ratios=(2.4, 1.0))
    # single curves, then percentiles with an arrow where they fall
    step = max(1, len(curves.each) // MOST_CURVES)
    for curve in curves.each[::step]:
        _draw_broken(axes, curve, curves.levels, color="0.6", linewidth=0.4, alpha=0.5, zorder=1)
    motions = results.study["motions"]
    if len(curves.each) == len(motions) <= MOST_NAMED:  # a curve of each motion
        for motion, curve in zip(motions, curves.each, strict=True):
            _name_end(axes, curve, curves.levels, str(motion["name"]))
    for percent, points, colour, style in zip(
        PERCENTILES, curves.percentiles, (BLUE, "black", RED), ("--", "-", "--"), strict=True
    ):
        look: dict[str, Any] = {"linestyle": style, "color": colour, "linewidth": 2.0}
        _draw_broken(axes, points, curves.levels, label=f"{percent} % of the runs move less", **look)
        last = last_before_falls(points)
        axes.plot(1e3 * points[last], curves.levels[last], ">", color=colour, markersize=8.0)
    axes.set_xscale("log")
    axes.set(title="grey: one column under one motion; thick: of all runs", ylabel=_label(results, curves.name))
    axes.set_xlabel("largest displacement of any block (mm)")
    axes.legend(frameon=False, title="an arrow: beyond it they overturn", loc="upper left")
    # shares that overturned or are undecided
    fallen.plot(curves.overturned, curves.levels, "o-", color="black", markersize=3.0, label="overturned")
    either = curves.overturned + curves.undecided
    fallen.fill_betweenx(curves.levels, curves.overturned, either, color="0.7", linewidth=0.0, label="undecided")
    fallen.legend(frameon=False, loc="lower right")
    fallen.set(title="how they ended", xlabel="share of the runs", xlim=(-0.02, 1.02))
    for panel in (axes, fallen):
        tidy(panel)
    return _captioned(figure, results, _pooled(results, "The thick curves"))


def _name_end(axes: Axes, moved: FloatArray, levels: FloatArray, name: str) -> None:
    """Write a name beside the last finite displacement (m) of a curve."""
    (finite,) = np.nonzero(np.isfinite(moved))
    if finite.size:
        end = 1e3 * moved[finite[-1]], levels[finite[-1]]
        axes.annotate(plain(name), end, (-4.0, 5.0), textcoords="offset points", fontsize=8, color="0.35", ha="right")


def _draw_broken(axes: Axes, moved: FloatArray, levels: FloatArray, **look: Any) -> None:
    """Draw a curve of displacements (m), with a gap where it falls and a dot between two falls."""
    known = ~np.isnan(moved)
    x, y = 1e3 * np.where(np.isfinite(moved), moved, math.nan)[known], levels[known]
    alone = np.isfinite(x) & np.isnan(np.append(math.nan, x[:-1])) & np.isnan(np.append(x[1:], math.nan))
    axes.plot(x, y, marker=".", markevery=np.flatnonzero(alone).tolist(), **look)


def last_before_falls(moved: FloatArray) -> NDArray[np.int64]:
    """Return the indices of finite displacements whose next level that was run has an infinite one."""
    (known,) = np.nonzero(~np.isnan(moved))
    falls = np.isinf(moved[known])
    return known[:-1][~falls[:-1] & falls[1:]]


def draw_fragility(results: Results) -> Figure:
    """Draw fitted curves with their bands and data, for every limit, for overturning and for hits.

    With motions by magnitude and distance it also draws the shares by magnitude and distance, and curves over PGA and
    PGV. With neighbours it also draws the share that hits over the number that the grid varies, such as their distance.
    """
    scenarios = {"motion.magnitude", "motion.distance"} <= set(results.study["grid"])
    names = ["pga", "pgv"] if scenarios else [intensity_name(results)]
    apart = other_varied_name(results) if LEAST_GAP in results and "intensity" in results.study["grid"] else None
    size = (10.0, 9.5) if scenarios else (8.5, 6.6) if apart is None else (11.0, 6.2)
    figure = Figure(figsize=size, layout="constrained")
    across = len(names) if apart is None else 2
    panels: list[Axes] = list(figure.subplots(2 if scenarios else 1, across, squeeze=False).flat)
    texts: list[str] = []
    # fitted curves; then shares by scenario, and shares of hits
    for axes, name in zip(panels, names, strict=False):
        _draw_fits(axes, results, name, texts)
    drawn = {label: line for axes in panels for line, label in zip(*axes.get_legend_handles_labels(), strict=True)}
    if drawn and scenarios:  # small panels, which it would cover
        figure.legend(drawn.values(), drawn, loc="outside upper right", ncols=2, frameon=False)
    elif drawn:
        panels[0].legend(frameon=False, loc="best")
    if scenarios:
        limits = results.study["limits"]
        for axes, limit in zip(panels[2:], (limits[len(limits) // 2] if limits else None, None), strict=True):
            _draw_shares(axes, results, limit, ("motion.magnitude", "magnitude"), ("motion.distance", "km"))
    if apart is not None:
        unit = Measure.from_table(results.study["intensity"]).unit
        label = f"{apart} ({unit_in_space(apart)})" if unit_in_space(apart) else apart
        _draw_shares(panels[1], results, "hit", (apart, label), ("intensity", unit))
        panels[1].legend(frameon=False, loc="upper left", bbox_to_anchor=(1.0, 1.0))
    texts.append(_pooled(results, "The fitted curves" if apart is None else "The fitted curves, but those of hits,"))
    return _captioned(figure, results, "\n".join(texts))


def _draw_fits(axes: Axes, results: Results, name: str, texts: list[str]) -> None:
    """Draw the curves over one intensity, and add a line to `texts` about them, or why there is none."""
    said = []
    for (what, limit, chosen), colour in zip(failures_of(results), cycle(_LIMIT_COLOURS), strict=False):
        try:
            found = fit_fragility(results, name, limit, chosen=chosen)
        except InputError as error:
            said.append(f"{what}: {error}")
            continue
        draw_curve(axes, found, colour, what)
        bounds = f"{found.median_bounds[0]:.3g} to {found.median_bounds[1]:.3g}"
        said.append(f"{what} {found.median:.3g} ({bounds}), {found.deviation:.2g}")
    texts.append(f"{_label(results, name)}, median with its bounds, deviation of the logarithm: {'; '.join(said)}.")
    axes.set(xlabel=_label(results, name), ylabel="probability of failure", ylim=(-0.02, 1.02))
    axes.set_title("lognormal with its 95 % band", loc="left", fontsize=10)
    tidy(axes)


def _draw_shares(axes: Axes, results: Results, limit: Limit, along: tuple[str, str], lines: tuple[str, str]) -> None:
    """Draw the share of failures over one name of the grid, a line for each value of another, with binomial bounds.

    `along` is the name and the label of the axis, `lines` the name and the unit of the lines.
    """
    places, values = (np.unique(results[name]) for name, _ in (along, lines))
    apart = 0.04 * float(np.min(np.diff(places), initial=math.inf)) if len(places) > 1 else 0.0
    failed, valid = failed_of(results, limit), made(results, limit)
    for k, (value, colour) in enumerate(zip(values, block_colours(len(values)), strict=True)):
        cells = [valid & (results[along[0]] == place) & (results[lines[0]] == value) for place in places]
        runs, hits = np.array([np.sum(cell) for cell in cells]), np.array([np.sum(failed[cell]) for cell in cells])
        there = runs > 0
        low, high = bounds_of(hits[there], runs[there])
        share = hits[there] / runs[there]
        beside = apart * (k - 0.5 * (len(values) - 1))  # offset, so that bounds do not overlap
        bounds = np.abs(np.array([low, high]) - share)
        place, name = places[there] + beside, f"{value:g} {lines[1]}"
        axes.errorbar(place, share, bounds, fmt="o-", color=colour, markersize=4.0, capsize=2.5, label=name)
    axes.set(xlabel=along[1], ylabel="share of the runs", ylim=(-0.02, None))
    axes.set_title(f"{failure_text(limit)}; bounds: 95 % binomial", loc="left", fontsize=10)
    axes.legend(frameon=False, loc="best")
    tidy(axes)


def draw_curve(axes: Axes, found: Fragility, colour: str, name: str) -> None:
    """Draw one fragility into axes: curve, band, and bins with their bounds. `name` is its label in the legend."""
    bins = found.bins
    _draw_band(axes, np.linspace(0.0, float(bins.edges[-1]), 400)[1:], found, colour, name)
    # bins, and where they would lie if the undecided runs fell too
    errors = np.abs(np.array([bins.low, bins.high]) - bins.share)
    axes.errorbar(bins.middle, bins.share, errors, fmt="o", color=colour, markersize=4.0, capsize=2.5)
    some = bins.undecided > 0
    with_undecided = (bins.failed + bins.undecided) / bins.runs
    style: dict[str, Any] = {"color": colour, "markerfacecolor": "none", "markersize": 4.0}
    said = "if the undecided fell too"
    label = said if np.any(some) and said not in axes.get_legend_handles_labels()[1] else ""
    axes.plot(bins.middle[some], with_undecided[some], "o", label=label, **style)


def _draw_band(axes: Axes, x: FloatArray, found: Fragility, colour: str, name: str) -> None:
    """Draw the curve of a fragility at the intensities x, and its band."""
    axes.fill_between(x, *found.band(x), color=colour, alpha=0.25, linewidth=0.0)
    axes.plot(x, found.probability(x), color=colour, linewidth=2.0, label=name)


def draw_risks(
    found: Risk | Mapping[str, Risk], path: str | os.PathLike[str] | None = None, title: str = "Risk"
) -> Figure:
    """Draw the hazard, the fragilities, and the intensities that the rates of failure come from, over one axis.

    `found` is one risk, or several of one hazard by the name of the failure.
    """
    risks = {found.fragility.how: found} if isinstance(found, Risk) else found
    figure = Figure(figsize=(8.5, 9.5), layout="constrained")
    panels: list[Axes] = list(figure.subplots(3, 1, sharex=True))
    hazard = next(iter(risks.values())).hazard
    inner = np.concatenate([hazard.intensity, *(one.edges[1:-1] for one in risks.values())])
    x = np.geomspace(0.7 * np.min(inner), 1.4 * np.max(inner), 500)
    # hazard
    panels[0].plot(x, hazard.exceeded(x), color="black", linewidth=1.5)
    panels[0].plot(hazard.intensity, hazard.rate, "o", color="black", markersize=4.0)
    panels[0].set(xscale="log", yscale="log", ylabel="rate of exceedance (1/year)")
    panels[0].set_title("hazard; dots: its points", loc="left")
    # fragilities, and the density of the rates
    for (name, one), colour in zip(risks.items(), cycle(_LIMIT_COLOURS), strict=False):
        _draw_band(panels[1], x, one.fragility, colour, name)
        panels[2].fill_between(x, one.density(x), color=colour, alpha=0.25, linewidth=0.0)
        panels[2].plot(x, one.density(x), color=colour, linewidth=2.0, label=name)
    measure = hazard.measure
    panels[1].set(ylabel="probability of failure", ylim=(-0.02, 1.02))
    panels[1].set_title("fragility with its 95 % band", loc="left")
    panels[2].legend(frameon=False, loc="best")  # steep curves leave no room beside the fragilities
    panels[2].set(xlabel=f"{measure.label} ({measure.unit})", ylabel=f"1/year per unit of ln {measure.label}")
    panels[2].set_title("the rate of failure by intensity; the area is the rate", loc="left")
    panels[2].set_ylim(bottom=0.0)
    panels[2].xaxis.set_major_formatter(ScalarFormatter())
    for axes in panels:
        tidy(axes)
    # caption
    said = [f"{name}: {one}." for name, one in risks.items()]
    said.append(f"Hazard: {hazard}. Bounds: 95 % confidence of the fragility; the hazard is taken as given.")
    _write_below(figure, said)
    header(figure, title)
    return save(figure, path)


def draw_spectrum(results: Results) -> Figure:
    """Draw the largest displacement over the width of the base, by size and slenderness.

    Each motion has a panel for each intensity.
    """
    study = results.study
    sizes, slender = (np.unique(study["grid"][name]) for name in ("column.size", "column.slenderness"))
    shown = [(str(motion["name"]), results["motion"] == k) for k, motion in enumerate(study["motions"])]
    if "intensity" in study["grid"]:
        levels = np.unique(study["grid"]["intensity"])
        shown = [
            (f"{name}, {_level(results, level)}", of & (results["intensity"] == level))
            for name, of in shown
            for level in levels
        ]
    across = min(3, len(shown))
    down = -(-len(shown) // across)
    figure = Figure(figsize=(1.6 + 4.2 * max(across, 2), 2.0 + 4.0 * down), layout="constrained")
    panels = figure.subplots(down, across, squeeze=False, sharex=True, sharey=True)
    # largest displacement of each run over the width of its column
    block = _columns(results)[0]["block"]
    height, width = sum(part["height"] for part in block), block[-1]["width"]
    base = results["column.size"] * height / results["column.slenderness"]
    part = results.largest / base
    bounds = [0.003, 0.01, 0.03, 0.1, 0.2, 0.3, 0.5, 1.0]
    norm = BoundaryNorm(bounds, 256, extend="both")
    for k, axes in enumerate(panels.flat):
        if k >= len(shown):
            axes.set_visible(False)
            continue
        title, here = shown[k]
        # median of each cell, infinite where the columns fall
        table = np.full((len(slender), len(sizes)), math.nan)
        for i, slenderness in enumerate(slender):
            for j, size in enumerate(sizes):
                cell = here & (results["column.size"] == size) & (results["column.slenderness"] == slenderness)
                if np.any(cell):
                    table[i, j] = percentiles(part[cell])[1]
        fell = np.isinf(table)
        stands, grey = np.where(fell, math.nan, table), np.where(fell, 1.0, math.nan)
        mesh = axes.pcolormesh(sizes * height, slender, stands, norm=norm, cmap="viridis", shading="nearest")
        axes.pcolormesh(sizes * height, slender, grey, cmap="gray", vmin=0.0, vmax=3.0, shading="nearest")
        axes.set_title(title, loc="left", fontsize=10)
        axes.set_xscale("log")
        axes.xaxis.set_major_formatter(ScalarFormatter())
        axes.xaxis.set_minor_formatter("")
        heights, ticks = sizes * height, (0.5, 1, 2, 5, 10, 20, 50)
        axes.set_xticks([tick for tick in ticks if heights[0] <= tick <= heights[-1]] or heights)
        tidy(axes, grid=False)
    for axes in panels[-1]:
        axes.set_xlabel("height of the column (m)")
    for axes in panels[:, 0]:
        axes.set_ylabel("slenderness, height over width")
    figure.colorbar(mesh, ax=panels, label="largest displacement over the width; dark grey: overturned")
    text = f"The column is {height:g} m high and {width:g} m wide at size 1."
    text += f"\nEach cell: the median of {study['samples']} runs." if study["samples"] > 1 else ""
    return _captioned(figure, results, text)


def draw_tornado(results: Results) -> Figure:
    """Draw the effect of each random parameter on displacement and overturning, the strongest on top."""
    found = influences(results)[:MOST_INFLUENCES]
    if not found:
        raise InputError(f"{results.study['name']}: nothing is random, or all runs end alike: no influence to draw")
    figure = Figure(figsize=(10.0, 2.6 + 0.45 * len(found)), layout="constrained")
    left, right, rank = figure.subplots(1, 3, sharey=True, width_ratios=(1.5, 1.0, 0.8))
    finite = np.isfinite(results.largest)
    middle = float(np.median(results.largest[~np.isnan(results.largest)]))
    share = float(np.mean(results.overturned[made(results)]))
    place = np.arange(len(found))[::-1]
    # bars from the value of all runs to those of the lowest and highest values
    for axes, whole, pairs, factor in (
        (left, middle, [item.displacement for item in found], 1e3),
        (right, share, [item.overturned for item in found], 1.0),
    ):
        top = factor * float(np.max(results.largest[finite], initial=1e-3)) if factor > 1.0 else 1.0
        for y, pair in zip(place, pairs, strict=True):
            for value, colour in zip(pair, (BLUE, RED), strict=True):
                end = min(factor * value, top)
                begin = min(factor * whole, top)
                axes.barh(y, end - begin, left=begin, height=0.6, color=colour, alpha=0.8)
                if math.isinf(value):
                    axes.plot(end, y, ">", color=colour)
        axes.axvline(min(factor * whole, top), color="black", linewidth=1.0)
    rank.barh(place, [item.rank for item in found], height=0.6, color="0.4")
    rank.axvline(0.0, color="black", linewidth=1.0)
    left.set_yticks(place, [item.name for item in found])
    left.set(title="median of the largest displacement", xlabel="mm")
    right.set(title="overturned", xlabel="share of the runs")
    rank.set(title="rank correlation", xlabel="with the displacement")
    for axes in (left, right, rank):
        tidy(axes)
    text = "Of the runs with the lowest (blue) and the highest (red) 16 % of each parameter; the line: of all runs."
    return _captioned(figure, results, text)


def _pooled(results: Results, curves: str) -> str:
    """Return the sentence on what curves pool beside motions and samples; "" if nothing."""
    names = ["the models"] * (len(results.study["columns"]) > 1)
    grid = results.study["grid"].items()
    names += [f"the values of {name}" for name, values in grid if name != "intensity" and len(values) > 1]
    return f"{curves} pool {' and '.join(names)}." if names else ""


def _label(results: Results, name: str) -> str:
    measure = measure_in(results, name)
    return name if measure is None else f"{measure.label} ({measure.unit})"


def _level(results: Results, value: float) -> str:
    """Return an intensity as text, such as PGV 0.3 m/s."""
    measure = Measure.from_table(results.study["intensity"])
    return f"{measure.label} {value:g} {measure.unit}"


def caption(results: Results) -> list[str]:
    """Return the lines of a caption: columns, motions, runs, seed, grid, random parameters, limits of the model."""
    study = results.study
    columns = ", ".join(f"{column['name']} ({len(column['block'])} blocks)" for column in _columns(results))
    random = ", ".join(
        f"{name} ({table['distribution']}{', each' if table.get('each') else ''})"
        for name, table in study["random"].items()
    )
    failed = int(np.sum(results["verdict"] == FAILED))
    undecided = int(np.sum(results["verdict"] == "undecided"))
    runs = f"{len(results)} of {results.head['runs']} runs, seed {study['seed']}"
    runs += f", {int(np.sum(results.overturned))} overturned"
    runs += f"; {undecided_text(undecided)}" if undecided else ""
    runs += f", {failed} could not be made" if failed else ""
    said = [f"{study['name']}: {columns}; base motion: {_some(study['motions'], 6)}; {runs}."]
    floors = [f"{one['floor']} of {one['building']['name']}" for one in study["motions"] if one.get("building")]
    if floors:
        said.append(f"On floor {', '.join(dict.fromkeys(floors))}; intensities are those of the ground.")
    if study["grid"]:
        values = (f"{name} ({counted(len(values), 'value')})" for name, values in study["grid"].items())
        said.append(f"Grid: {', '.join(values)}.")
    if random:
        said.append(f"Random: {random}; {study['samples']} samples, {study['sampling']}.")
    return [*said, limits_of_model(results)]


def _columns(results: Results) -> list[Mapping[str, Any]]:
    """Return the columns or structures as in their files."""
    return [table.get(OF_COLUMN, table) for table in results.study["columns"]]


def _some(tables: Sequence[Mapping[str, Any]], most: int) -> str:
    """Return the names of columns or motions as text, only the first ones of many."""
    names = [str(table["name"]) for table in tables]
    return ", ".join(names[:most]) + (f" and {len(names) - most} more" if len(names) > most else "")


def limits_of_model(results: Results) -> str:
    """Return the sentence on the effects that the model leaves out: in its files, and by the names that vary."""
    study = results.study
    subjects = [subject_from(column) for column in study["columns"]]
    laws = [law for subject in subjects for law in subject.laws]
    varied = {name.rpartition(".")[2] for name in (*study["grid"], *study["random"]) if name.startswith(_OF_LAWS)}
    slides = "friction" in varied or any(law.friction is not None for law in laws)
    keys = {"tensile_strength": "tension", "cohesion": "cohesion"}
    bears = " and ".join(keys[key] for key in keys if key in varied or any(getattr(law, key) for law in laws))
    mortar = f"with mortar that bears {bears} until it breaks" if bears else "without tension"
    limits = "do not crush" if slides else "neither slide nor crush"
    held = any(table.get("tension") for column in study["columns"] for table in column.get("bearing", ()))
    motion = "Motion in space" if subjects[0].kind.across else "Plane motion"
    beside = "; bearings bear tension" if held else ""
    return f"{motion} of rigid blocks on elastic joints that {limits}, {mortar}{beside}."


def _write_below(figure: Figure, paragraphs: Sequence[str]) -> None:
    """Write paragraphs below a figure, as wide as it is."""
    letters = int(WIDTH * figure.get_figwidth() / 10.0)
    lines = [line for paragraph in paragraphs for line in textwrap.wrap(paragraph, width=letters)]
    figure.supxlabel("\n".join(lines), x=0.02, ha="left", fontsize=9, linespacing=1.4)


def _captioned(figure: Figure, results: Results, text: str = "") -> Figure:
    _write_below(figure, [*caption(results)[:-1], *text.splitlines(), limits_of_model(results)])
    columns, motions = _columns(results), _some(results.study["motions"], 3)
    if len(motions) > LONG:
        motions = f"{len(results.study['motions'])} motions"  # the caption names them
    header(figure, f"{_some(columns, 3)} under {motions}")
    return figure


_NEEDS = {"sweep": ("intensity", "motion.frequency"), "spectrum": ("column.size", "column.slenderness")}
_DRAW: dict[str, Callable[[Results], Figure]] = {
    "sweep": draw_sweep,
    "ida": draw_ida,
    "fragility": draw_fragility,
    "spectrum": draw_spectrum,
    "montecarlo": draw_tornado,
}
