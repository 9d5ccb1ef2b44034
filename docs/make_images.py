"""Draw the pictures of the README and the docs: `python docs/make_images.py`."""

import math
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from matplotlib.ticker import NullFormatter
from PIL import Image

from multiblock import (
    Block,
    Column,
    Joint,
    Motion,
    Structure,
    capacity_curve,
    housner_restitution,
    natural_modes,
    push_over,
    simulate,
    wavelets,
)
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.linearization import StillColumn
from solver.plotting.drawings import DisplacementHistories, corners_of, draw_column, measure_column
from solver.plotting.plots import draw_ground
from solver.plotting.record_plots import plot_records
from solver.plotting.style import BLUE, INK, RED, STONE, VERDICT_COLOURS, header, tidy
from solver.plotting.words import setting_of, verdict_of
from solver.statics.calibrate import with_joints
from solver.statics.rocking import column_damping_on_edge, pulled_equilibrium, restitution_from

HERE = Path(__file__).resolve().parent
EXAGGERATION = 50.0
COLOURS = 96  # of a picture in a file
ARROW = {"arrowstyle": "-|>", "color": RED, "linewidth": 1.6, "mutation_scale": 12}


def arrow(axes: Axes, tail: tuple[float, float], tip: tuple[float, float], bend: float = 0.0) -> None:
    axes.annotate("", tip, tail, arrowprops=ARROW | {"connectionstyle": f"arc3,rad={bend}"})


def shrink(name: str) -> None:
    """Keep a picture's size small: few colours, which line drawings have anyway."""
    path = HERE / "images" / name
    Image.open(path).convert("RGB").quantize(COLOURS, dither=Image.Dither.NONE).save(path, optimize=True)


def block(axes: Axes, foot: tuple[float, float], lean: float, height: float = 1.4) -> None:
    """A block on the lower right corner `foot`, 1.2 wide, turned clockwise by `lean` rad."""
    up, along = np.array([np.sin(lean), np.cos(lean)]), np.array([np.cos(lean), -np.sin(lean)])
    corner = np.array(foot)
    outline = np.array([corner, corner + height * up, corner + height * up - 1.2 * along, corner - 1.2 * along])
    axes.add_patch(Polygon(outline, facecolor=STONE, edgecolor=INK, linewidth=1.2))


def signs() -> None:
    """signs.png: numbers of blocks and joints on the left, on the right the resultants of one joint."""
    figure = Figure(figsize=(9.0, 4.9), layout="constrained")
    column, cut = figure.subplots(1, 2, width_ratios=(1.0, 1.0))
    lean = (0.14, 0.09, 0.04)  # of the blocks from the top down
    foot = np.array([0.6, 0.0])
    for i in (3, 2, 1):
        turn = lean[i - 1]
        block(column, (foot[0], foot[1]), turn)
        up, along = np.array([np.sin(turn), np.cos(turn)]), np.array([np.cos(turn), -np.sin(turn)])
        middle = foot + 0.7 * up - 0.6 * along
        column.text(*middle, f"block {i}", ha="center", va="center", color=INK)
        column.text(foot[0] - 1.45, foot[1] + 0.09, f"joint {i}", ha="right", va="center", color=INK)
        foot = foot + 1.4 * up
    top = foot - 0.6 * along
    column.plot([0.0, 0.0], [0.0, 4.75], color=INK, linewidth=0.8, linestyle=":")
    column.plot([-2.6, 2.6], [-0.03, -0.03], color=INK, linewidth=3.0)
    column.plot([top[0], top[0]], [top[1], 4.75], color=INK, linewidth=0.8, linestyle=":")
    arrow(column, (0.0, 4.6), (top[0], 4.6))
    column.text(top[0] + 0.1, 4.6, "ux", color=RED, va="center")
    arrow(column, (1.45, 4.2), (1.75, 3.3), -0.35)
    column.text(1.85, 3.75, "theta,\nclockwise", color=RED, va="center")
    arrow(column, (-0.5, -0.45), (0.5, -0.45))
    column.text(0.6, -0.45, "base.ax", color=RED, va="center")
    for tip, name, place in (((-1.9, 0.45), "x", (-1.82, 0.45)), ((-2.45, 1.0), "z", (-2.45, 1.12))):
        arrow(column, (-2.45, 0.45), tip)
        column.text(*place, name, color=RED, ha="left" if name == "x" else "center", va="center")
    block(cut, (0.6, 0.0), 0.0)
    block(cut, (0.75, 2.25), 0.1)
    cut.text(0.0, 0.7, "block i+1", ha="center", va="center", color=INK)
    cut.text(0.22, 3.0, "block i", ha="center", va="center", color=INK)
    arrow(cut, (0.35, 2.1), (0.35, 1.45))
    cut.text(0.7, 1.75, "N, compression", color=RED, va="center")
    arrow(cut, (-1.3, 1.4), (-0.65, 1.4))
    cut.text(-1.4, 1.4, "S, horizontal,\non the part below", color=RED, ha="right", va="center")
    arrow(cut, (1.5, 2.5), (1.2, 3.4), 0.45)
    cut.text(1.62, 3.0, "M rights the\npart above", color=RED, va="center")
    cut.plot([-0.6, 0.6], [1.42, 1.42], color=BLUE, linewidth=2.5)
    cut.plot([-2.6, 2.6], [-0.03, -0.03], color=INK, linewidth=3.0)
    for axes, title in ((column, "blocks and joints count from the top"), (cut, "joint i, cut: its resultants")):
        axes.text(0.0, 5.2, title, ha="center", va="center", color=INK)
        axes.set(xlim=(-2.8, 2.8), ylim=(-0.7, 5.4), aspect="equal")
        axes.set_axis_off()
    figure.savefig(HERE / "images" / "signs.png", dpi=110)


def phocas() -> None:
    """phocas.png: what the first line of the README computes, the damped Column of Phocas at 0.05 g and 2 Hz."""
    column = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-damped.toml")
    response = simulate(column, Motion.harmonic(0.05 * STANDARD_GRAVITY, 2.0, 20.0), output_step=0.002)
    figure = Figure(figsize=(9.0, 5.4), layout="constrained")
    grid = figure.add_gridspec(3, 2, width_ratios=(1.0, 1.9), height_ratios=(0.6, 1.0, 1.0))
    drawing = figure.add_subplot(grid[:, 0])
    k = int(np.argmax(np.abs(response.ux[:, 0])))
    draw_column(drawing, response, k, EXAGGERATION)
    measure_column(drawing, response, k, EXAGGERATION)
    ground, top, contact = (figure.add_subplot(grid[row, 1]) for row in range(3))
    draw_ground(ground, response.motion)
    top.plot(response.time, 1e3 * response.ux[:, 0], color=BLUE, linewidth=0.9)
    top.plot(response.time[k], 1e3 * response.ux[k, 0], "o", color=RED, markersize=4)
    top.set(title="the top moves by", ylabel="$u_x$ (mm)")
    contact.fill_between(response.time, response.contact[:, -1], color=BLUE, alpha=0.35, linewidth=0.0)
    contact.set(title="width of the base joint in contact", ylabel="part", xlabel="time (s)", ylim=(0.0, 1.05))
    for panel in (ground, top, contact):
        tidy(panel)
        panel.set_xlim(0.0, response.time[-1])
        panel.tick_params(labelbottom=panel is contact)
    figure.align_ylabels()
    word, sentence = verdict_of(response)
    header(figure, setting_of(column, response.motion), sentence, VERDICT_COLOURS[word])
    figure.savefig(HERE / "images" / "phocas.png", dpi=130)
    shrink("phocas.png")


def fallen() -> None:
    """fallen.png: the Doric column under a pulse that overturns it, as `simulate --plot` draws it."""
    column = Column.from_toml(HERE.parent / "examples" / "columns" / "doric.toml")
    response = simulate(column, wavelets.ricker(0.6 * STANDARD_GRAVITY, 0.5), 20.0)
    response.plot(HERE / "images" / "fallen.png")
    shrink("fallen.png")


def records() -> None:
    """Three motions by formula, each of 0.3 g, as `record --plot` draws records."""
    pga = 0.3 * 9.80665
    motions = {
        "Ricker, 1 Hz": wavelets.ricker(pga, 1.0),
        "Mavroeidis-Papageorgiou, 0.5 Hz, 2 cycles, 90 degrees": wavelets.mavroeidis_papageorgiou(
            1.0, 0.5, 2.0, 0.5 * np.pi
        ).scaled_to(pga),
        "noise, 2.5 Hz, 20 s, seed 7": wavelets.filtered_noise(pga, 2.5, 20.0, 7),
    }
    plot_records(motions, HERE / "images" / "records.png")
    shrink("records.png")


def statics() -> None:
    """modes.png, statics.png, push-over.png: as `multiblock modes` and `multiblock statics` draw them."""
    column = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-damped.toml")
    natural_modes(column).plot(HERE / "images" / "modes.png")
    capacity_curve(column).plot(HERE / "images" / "statics.png")
    colonnade = Structure.from_toml(HERE.parent / "examples" / "structures" / "colonnade.toml")
    push_over(colonnade, 0.5 * math.pi).plot(HERE / "images" / "push-over.png")
    for name in ("modes.png", "statics.png"):
        shrink(name)


def restitutions() -> None:
    """restitution.png: the Column of Phocas as one block, let go at a half of the way to the edge and elsewhere."""
    block = Block(14.07, 1.56, 1.56, 81000.0, Joint(533 * 9.80665e6, 0.0))
    column = Column("phocas", (block,))
    etas = np.geomspace(1e-4, 10.0, 26)
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2, sharey=True)
    lines = [(left, times, 0.5, f"{times:g} times 5.23e9 N/m3") for times in (0.1, 1.0, 10.0)]
    lines += [(right, 1.0, release, f"let go at {release:g} of the way") for release in (0.2, 0.5, 0.8)]
    for axes, times, release, label in lines:
        softer = with_joints(column, times * block.joint.stiffness)
        start, top = pulled_equilibrium(softer, release)
        found = [restitution_from(with_joints(softer, damping=eta), start, top) for eta in etas]
        axes.plot(etas, found, label=label)
    for axes, title in ((left, "(a) by the modulus, let go at 0.5 of the way"), (right, "(b) by the release")):
        axes.axhline(housner_restitution(column), color=INK, linestyle="--", linewidth=0.9, label="Housner")
        axes.set(xscale="log", xlabel="eta (s)", ylim=(0.9, 1.0))
        axes.set_title(title, loc="left", fontsize=10)
        axes.grid(color="0.9", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8, loc="lower left")
    left.set_ylabel("restitution")
    figure.savefig(HERE / "images" / "restitution.png", dpi=110)


def rims() -> None:
    """restitution-rims.png: a tested block of granite, 0.25 x 1.0 m; rims, moduli and dampings around critical."""
    width, height, measured = 0.25, 1.0, 0.936  # m; restitution by Pena and others 2007
    parts = np.geomspace(1.0, 0.004, 25)  # of half of the width
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    left, right = figure.subplots(1, 2)

    def kept(stiffness: float, part: float, ratios: tuple[float, ...]) -> list[float]:
        """Restitutions at these ratios of the damping that is critical on the edge."""
        law = Joint(stiffness, 1e-3, rim=0.5 * part * width)
        block = Column("granite", (Block(height, width, 0.754, 503.0, law),))
        start, top = pulled_equilibrium(block)
        eta = column_damping_on_edge(block)
        return [restitution_from(with_joints(block, damping=ratio * eta), start, top) for ratio in ratios]

    shades = ("#9ecae1", "#4292c6", "#08519c", "0.25")
    for name, shade in zip(("1e9", "5e9", "5e10", "1e13"), shades, strict=True):
        found = [kept(float(name), part, (1.0,))[0] for part in parts]
        left.plot(0.5 * parts, found, color=shade, label=f"{name} N/m3")
    square, moved = (width**2 + 4.0 * height**2) / 12.0, 0.25 * width**2
    for place, name in ((1.0 / 3.0, "impulse at a third"), (1.0, "at the edge: Housner")):
        value = (square - place * moved) / (square + place * moved)
        left.axhline(value, color=INK, linestyle="--", linewidth=0.9)
        left.text(0.002, value - 0.001, name, fontsize=8, ha="left", va="top", color=INK)
    left.axhline(measured, color=RED, linewidth=1.2)
    left.text(0.002, measured + 0.001, "measured", fontsize=8, ha="left", va="bottom", color=RED)
    left.axvline(1.0 / 6.0, color="0.6", linewidth=0.9, linestyle=":")
    left.set(xscale="log", xlabel="rim over width (0.5: whole face)", ylabel="restitution", ylim=(0.86, 0.98))
    left.set_title("(a) damping critical on the edge", loc="left", fontsize=10)
    left.legend(frameon=False, fontsize=8, loc="lower right")
    ratios = tuple(float(value) for value in np.geomspace(0.02, 10.0, 20))
    map_parts = np.geomspace(1.0, 0.02, 16)
    found_map = np.array([kept(5e9, part, ratios) for part in map_parts])
    levels = np.arange(0.84, 1.0, 0.02)
    filled = right.contourf(0.5 * map_parts, ratios, found_map.T, levels=np.arange(0.82, 1.001, 0.01), cmap="Blues_r")
    right.contour(0.5 * map_parts, ratios, found_map.T, levels=levels, colors="0.4", linewidths=0.5)
    right.contour(0.5 * map_parts, ratios, found_map.T, levels=[measured], colors=[RED], linewidths=1.6)
    rigid = housner_restitution(Column("granite", (Block(height, width, 0.754, 503.0, Joint(5e9, 0.0)),)))
    right.contour(0.5 * map_parts, ratios, found_map.T, levels=[rigid], colors=[INK], linestyles="--", linewidths=1.2)
    right.axhline(1.0, color="0.3", linewidth=0.9, linestyle=":")
    right.set(xscale="log", yscale="log", xlabel="rim over width", ylabel="damping over critical on the edge")
    right.xaxis.set_minor_formatter(NullFormatter())
    right.set_title("(b) 5e9 N/m3; red: measured, dashed: Housner", loc="left", fontsize=10)
    figure.colorbar(filled, ax=right, label="restitution")
    for axes in (left, right):
        axes.spines[["top", "right"]].set_visible(False)
    left.grid(color="0.9", linewidth=0.6)
    figure.savefig(HERE / "images" / "restitution-rims.png", dpi=110)
    shrink("restitution-rims.png")


def columns() -> None:
    """columns.png: the columns of examples/columns, to one scale; the small ones once more, larger."""
    names = ("phocas", "phocas-round", "doric", "pronaos", "aurelian", "statue", "storage")
    figure = Figure(figsize=(9.0, 4.6), layout="constrained")
    left, right = figure.subplots(1, 2, width_ratios=(3.0, 1.0))
    for axes, shown, gap in ((left, names, 4.0), (right, names[-2:], 0.6)):
        place = 0.0
        for name in shown:
            blocks = Column.from_toml(HERE.parent / "examples" / "columns" / f"{name}.toml").blocks
            half = 0.5 * max(max(block.width, block.top_width or 0.0) for block in blocks)
            place += half
            foot = 0.0
            for block in reversed(blocks):
                low, high = 0.5 * block.width, 0.5 * (block.top_width or block.width)
                corners = [(-low, 0.0), (low, 0.0), (high, block.height), (-high, block.height)]
                outline = np.array(corners) + np.array([place, foot])
                axes.add_patch(Polygon(outline, facecolor=STONE, edgecolor=INK, linewidth=0.8))
                foot += block.height
            axes.text(place, -0.03 * axes_height(axes is left), name, ha="center", va="top", fontsize=8, color=INK)
            place += half + gap
        axes.plot([-gap, place], [0.0, 0.0], color=INK, linewidth=2.0)
        axes.set(xlim=(-gap, place), ylim=(-0.12 * axes_height(axes is left), axes_height(axes is left)))
        axes.set(aspect="equal", ylabel="m")
        axes.spines[["top", "right", "bottom"]].set_visible(False)
        axes.set_xticks([])
    figure.savefig(HERE / "images" / "columns.png", dpi=110)


def off_axis() -> None:
    """off-axis.png: ways in which a column can be off its axis, as built and at rest."""
    upright = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-damped.toml")

    def changed(tilt: tuple[float, ...] = (0.0,) * 3, **joint: tuple[Any, ...]) -> Column:
        parts = [{name: values[i] for name, values in joint.items()} for i in range(3)]
        blocks = zip(upright.blocks, parts, tilt, strict=True)
        made = (replace(own, joint=replace(own.joint, **part), tilt=lean) for own, part, lean in blocks)
        return replace(upright, blocks=tuple(made))

    shown = {
        "a block that is offset\noffset = 0.4": changed(offset=(0.4, None, None)),
        "a leaning column\ninclination = 0.04": changed(inclination=(0.04,) * 3),
        "one block that leans\ninclination = 0.04": changed(inclination=(None, 0.04, None)),
        "an oblique joint\ninclination = 0.15\ntilt = -0.15": changed(
            (0.0, -0.15, 0.0), inclination=(None, 0.15, None)
        ),
        "an edge that is gone\nstrips = [1.5, 1.5, 0]": changed(
            section=(None, "strips", None), strips=(None, (1.5, 1.5, 0.0), None)
        ),
    }
    figure = Figure(figsize=(9.0, 5.2), layout="constrained")
    for axes, (title, column) in zip(figure.subplots(1, len(shown)), shown.items(), strict=True):
        still = StillColumn(column)
        joints = still.row(still.rest).joints
        rest = [values[None] for values in (joints.ux, joints.uz, joints.theta)]
        built = [0.0 * values for values in rest]
        for outlines, scale, style in (
            (corners_of(DisplacementHistories(column, *rest), 0, 200.0), 200.0, {"facecolor": STONE}),
            (corners_of(DisplacementHistories(column, *built), 0, 1.0), 1.0, {"fill": False, "linestyle": ":"}),
        ):
            for outline in outlines:
                axes.add_patch(Polygon(outline, edgecolor=INK if scale > 1.0 else BLUE, linewidth=0.9, **style))
        axes.axhline(0.0, color=INK, linewidth=2.0)
        axes.set(xlim=(-2.2, 2.6), ylim=(-0.5, 14.8), aspect="equal")
        axes.set_title(title, fontsize=8)
        axes.set_axis_off()
    figure.savefig(HERE / "images" / "off-axis.png", dpi=110)


def axes_height(all_of_them: bool) -> float:
    """Of the two drawings of `columns`, m."""
    return 27.5 if all_of_them else 2.7


def el_centro(picture: str) -> Motion | None:
    """The record that a picture is made under; None, and said, where it is not there."""
    record = HERE.parent.parent / "shared" / "records" / "elcentro-1940-ns.AT2"
    if record.is_file():
        return Motion.from_at2(record)
    print(f"{picture} is left as it is: {record} is not there")
    return None


def square_and_round() -> None:
    """square-and-round.png: the paper's Phocas, the round one and squares that stand for it, under one record."""
    motion = el_centro("square-and-round.png")
    if motion is None:
        return
    as_built = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-round.toml")
    paper = Column.from_toml(HERE.parent / "examples" / "columns" / "phocas-damped.toml")
    radius = 0.5 * as_built.blocks[0].width
    widths = {
        "same area": np.sqrt(np.pi) * radius,
        "same second moment": (3.0 * np.pi) ** 0.25 * radius,
        "same kern": 1.5 * radius,
    }
    shown = {"paper, three square blocks": paper, "as it stands, round": as_built}
    for name, width in widths.items():
        block = as_built.blocks[0]
        block = Block(block.height, float(width), float(width), block.mass, block.joint)
        shown[f"square, {name}"] = Column("square", (block,) * as_built.n)
    figure = Figure(figsize=(9.0, 6.4), layout="constrained")
    ground, upper, lower = figure.subplots(3, 1, sharex=True, height_ratios=(0.7, 1.3, 1.3))
    draw_ground(ground, motion)
    for k, (name, column) in enumerate(shown.items()):
        response = simulate(column, motion, tolerance=1e-6)
        label = f"{name}: {1e3 * response.peak_top_ux[0]:.0f} mm"
        print(label, response.verdict)
        if k < 2:
            upper.plot(response.time, 1e3 * response.ux[:, 0], label=label, linewidth=1.0)
        if k > 0:
            lower.plot(response.time, 1e3 * response.ux[:, 0], label=label, linewidth=0.8)
    for axes in (upper, lower):
        axes.set_ylabel("top, mm")
        axes.grid(color="0.9", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.legend(frameon=False, fontsize=8, loc="lower left", bbox_to_anchor=(0.0, 1.0), ncols=2, borderpad=0.0)
    lower.set_xlabel("time (s)")
    figure.savefig(HERE / "images" / "square-and-round.png", dpi=110)


def stuck_and_sliding() -> None:
    """stuck-and-sliding.png: the square and the round Phocas under one record, joints that never slide and that do."""
    motion = el_centro("stuck-and-sliding.png")
    if motion is None:
        return
    figure = Figure(figsize=(10.0, 6.0), layout="constrained")
    panels = figure.subplots(2, 2, sharex=True, sharey="row", height_ratios=(1.5, 1.0))
    for k, (name, title) in enumerate(
        (("phocas-damped", "square, three blocks"), ("phocas-round", "round, six drums"))
    ):
        column = Column.from_toml(HERE.parent / "examples" / "columns" / f"{name}.toml")
        top, slips = panels[0, k], panels[1, k]
        for friction, colour in ((None, INK), (0.7, BLUE), (0.2, RED)):
            joints = tuple(replace(own, joint=replace(own.joint, friction=friction)) for own in column.blocks)
            response = simulate(replace(column, blocks=joints), motion, tolerance=1e-6, settle=0.0)
            peak, label = 1e3 * response.peak_top_ux[0], "stuck" if friction is None else f"friction {friction:g}"
            print(f"{name}, {label}: {peak:.0f} mm, slips left (mm)", np.round(1e3 * response.slip[-1], 2))
            top.plot(
                response.time, 1e3 * response.ux[:, 0], color=colour, label=f"{label}: {peak:.0f} mm", linewidth=0.8
            )
            if friction == 0.2:
                slips.plot(response.time, 1e3 * response.slip, linewidth=0.9)
                slips.legend([f"joint {i + 1}" for i in range(column.n)], frameon=False, fontsize=7, ncols=2)
        top.set_title(title, loc="left", fontsize=10)
        top.legend(frameon=False, fontsize=8, loc="upper right")
        slips.set_xlabel("time (s)")
    panels[0, 0].set_ylabel("top, mm")
    panels[1, 0].set_ylabel("slip, friction 0.2, mm")
    for axes in panels.flat:
        axes.grid(color="0.9", linewidth=0.6)
        axes.spines[["top", "right"]].set_visible(False)
        axes.set_xlim(0.0, motion.duration)
    figure.savefig(HERE / "images" / "stuck-and-sliding.png", dpi=90)


def shenton() -> None:
    """shenton.png: how a block begins to move, of Shenton's regions and of runs."""
    from matplotlib.colors import ListedColormap

    sys.path.insert(0, str(HERE.parent / "tests"))
    from support.shenton import mode_found, mode_of

    modes = {"rest": "#dddddd", "slide": "#9ecae1", "rock": "#fdae6b", "slide-rock": "#a1d99b"}
    names = list(modes)
    figure = Figure(figsize=(9.0, 4.2), layout="constrained")
    wrong = 0
    for axes, slenderness in zip(figure.subplots(1, 2), (2.0, 4.0), strict=True):
        edge = 1.0 / slenderness
        pushes, frictions = np.linspace(0.0, 3.0 * edge, 301), np.linspace(0.01, 2.5 * edge, 301)
        regions = [[names.index(mode_of(push, mu, slenderness)) for push in pushes] for mu in frictions]
        axes.pcolormesh(pushes, frictions, regions, cmap=ListedColormap(list(modes.values())), vmin=-0.5, vmax=3.5)
        for push in edge * np.array([0.4, 0.8, 1.25, 1.6, 2.0, 2.5, 2.9]):
            for mu in edge * np.array([0.3, 0.6, 0.85, 1.1, 1.35, 1.6, 2.0, 2.4]):
                found = mode_found(float(push), float(mu), slenderness)
                same = found == mode_of(float(push), float(mu), slenderness)
                wrong += not same
                axes.plot(push, mu, "o", color=modes[found], markeredgecolor=INK if same else RED, markersize=7)
        axes.set(xlabel="base acceleration, g", title=f"height {slenderness:g} times the width")
    print(f"shenton.png: {wrong} of 112 runs are in another region")
    handles = [Polygon([[0, 0]], facecolor=colour, edgecolor=INK) for colour in modes.values()]
    figure.axes[0].set_ylabel("friction")
    figure.legend(handles, names, loc="outside lower center", ncols=4, frameon=False)
    figure.savefig(HERE / "images" / "shenton.png", dpi=90)


if __name__ == "__main__":
    signs()
    phocas()
    fallen()
    records()
    statics()
    restitutions()
    rims()
    columns()
    off_axis()
    square_and_round()
    stuck_and_sliding()
    shenton()
