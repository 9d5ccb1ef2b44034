"""The documentation inside the FMU: a drawing of the model, and a page that explains every variable.

Needed by the builder only; the FMU carries the results.
"""

from __future__ import annotations

import io
from functools import singledispatch
from html import escape
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Rectangle
from matplotlib.transforms import Affine2D

from solver.models.column.model import Column
from solver.models.structure.model import Structure
from solver.plotting.drawings import DisplacementHistories, corners_of, draw_column
from solver.plotting.scene.bodies import has_parts, parts_of, walls_of
from solver.plotting.scene.gltf import still
from solver.plotting.structures import structure_picture
from solver.plotting.style import BLUE, INK, RED, STONE

from .body import Body
from .description_parts import DISPLAY_UNITS
from .exchange import exchange, html
from .variables import Variable

MOST_NUMBERED = 20  # blocks
ON_STONE = {"facecolor": STONE, "linewidth": 0.0, "pad": 1.0}  # hides the axis of the column behind a number
ARROW = {"arrowstyle": "-|>", "color": RED, "linewidth": 1.6, "mutation_scale": 12}

PAGE = """\
<!DOCTYPE html>
<html lang="en">
<head><meta charset="utf-8"><title>{name}</title>
<style>body {{ font-family: sans-serif; max-width: 70em; margin: 2em auto; padding: 0 1em; color: #222 }}
table {{ border-collapse: collapse }} th, td {{ border-bottom: 1px solid #ddd; padding: 0.2em 0.8em; text-align: left }}
code {{ white-space: nowrap }}</style></head>
<body>
<h1>{name}</h1>
<p>{about}: for co-simulation. {numbers}
{needs}</p>
<p><img src="model.png" alt="{name}" height="360"></p>
<h2>Signs</h2>
{signs}
<h2>Inputs within a communication step</h2>
<p>The preferred communication step is {step} s, that of the default experiment; take the sampling interval of the
motion if that is shorter. {within}</p>
{exchange}<h2>Variables</h2>
{tables}
</body>
</html>
"""
OF_COLUMN = {
    "numbers": "Block 1 is the top block; joint i lies under block i; the last joint rests on the base.",
    "signs": """\
<p><img src="signs.png" alt="Sign conventions: x to the right, z up, rotations clockwise"></p>
<p>ux and uz are relative to the base, and like theta count from the column as built, without load. N is positive in
compression and M rights a block that leans to +x. S is what the part above does to the part below, horizontally; T is
the same along the joint: a joint without friction never slides, and T is to be compared with the friction that it has
times N. base.Fx, base.Fz and base.My are what the column does to the base, at the centre of its joint.</p>""",
    "turning": """The base rotates by
base.theta + base.omega (t - t0) + base.alpha (t - t0)<sup>2</sup> / 2 about the centre of its joint, to which base.ax
and base.az belong. At the end of initialization the column stands upright on the base, whatever base.theta is then;
a base.theta set later turns the base under blocks that stay where they are.""",
}
OF_STRUCTURE = {
    "numbers": "Blocks, joints and ties have the numbers of the file, from 1; their names are among the variables.",
    "signs": """\
<p>x and y are horizontal, z is up. ux, uy, uz and the rotations rx, ry, rz (axis times angle) are relative to the base
and count from the structure as built and without weight. Forces and moments of a joint are along its own axes: N is
positive in compression, Tx and Ty act on its second block, Mx, My and Mz right the first one. base.Fx to base.Mz are
what the structure does to the base, at the origin. Joints are elastic along themselves: no output follows an input of
the same instant.</p>""",
    "turning": """\
The base does not rotate, unless the FMU has base.theta_x: then it does about x and y, by
base.theta_x + base.omega_x (t - t0) + base.alpha_x (t - t0)<sup>2</sup> / 2 and so on, about the origin. Displacements,
rotations, ports and the force on the base stay along fixed axes. Before the first step blocks turn with it, later a new
base.theta_x turns it beneath them. The run begins at the rest that was found when the FMU was built.""",
}

OF_ANY = {
    "numbers": "Blocks, joints and ties count from 1.",
    "signs": "<p>x is horizontal, z is up, rotations are clockwise; displacements are relative to the base.</p>",
    "turning": "The base does not rotate.",
}

WITHIN = """\
From the start t0 of a step to its end the base acceleration is base.ax + base.jx (t - t0), and likewise along the
other axes: with base.jx = 0 it is held, with the slope of the signal it is linear. To this is added the record that
base.record names, sampled by the FMU itself whatever the communication step. {turning}"""
DRIVEN = "Bodies at the base move it; the section on the exchange says how, and which inputs then do nothing."
HEADINGS = {"input": "Inputs", "output": "Outputs", "parameter": "Parameters"}


def pages(body: Body, table: list[Variable], needs: str, step: float) -> dict[str, bytes]:
    """Return the files of the documentation by path.

    `needs` is a line on the needs of the machine that runs the FMU, `step` the preferred communication step (s).
    """
    picture, words = _shown(body.model)
    others = {"documentation/signs.png": sign_conventions()} if "signs.png" in words["signs"] else {}
    page = _page(body, table, {**words, "needs": escape(needs), "step": f"{step:g}"})
    pictures = dict.fromkeys(("documentation/model.png", "documentation/diagram.png"), picture)  # the latter for FMI 3
    return {"documentation/index.html": page.encode()} | pictures | others | _scene(body.model)


def _scene(model: Any) -> dict[str, bytes]:
    """Return the blocks as binary glTF, for examples/animate_fmu.py; of a structure from a mesh its hull."""
    if not has_parts(model):
        return {}
    return {"resources/scene.glb": still(model.name, parts_of(model)[0], not model.kind.across, walls_of(model))}


@singledispatch
def _shown(model: Any) -> tuple[bytes, dict[str, str]]:
    """Return a picture of the model and the texts of the page; of an unknown model its name."""
    figure = Figure(figsize=(3.0, 3.0))
    figure.text(0.5, 0.5, model.name, ha="center", color=INK, bbox={"facecolor": STONE, "edgecolor": INK})
    return _png(figure), OF_ANY


@_shown.register
def _(column: Column) -> tuple[bytes, dict[str, str]]:
    return drawing(column), OF_COLUMN


@_shown.register
def _(structure: Structure) -> tuple[bytes, dict[str, str]]:
    return _png(structure_picture(structure, 3.0)), OF_STRUCTURE


def _page(body: Body, table: list[Variable], words: dict[str, str]) -> str:
    """Return documentation/index.html: signs, inputs, and every variable with its unit, limits and start value."""
    parts = []
    for causality, heading in HEADINGS.items():
        rows = [_row(variable) for variable in table if variable.causality == causality]
        head = "<tr><th>name</th><th>unit (shown as)</th><th>start</th><th>range</th><th>meaning</th></tr>"
        parts.append(f"<h3>{heading}</h3>\n<table>\n{head}\n" + "\n".join(rows) + "\n</table>")
    about, drive = escape(body.about), body.drive
    words = {**words, "within": WITHIN.format(turning=words["turning"]), "exchange": ""}
    if drive.is_chosen:
        words["within"] = DRIVEN if len(drive.words) == 1 else f"{DRIVEN} Else: {words['within']}"
        words["exchange"] = f"<h2>The exchange with the bodies at the base</h2>\n{html(exchange(table, drive))}\n"
    return PAGE.format(name=escape(body.name), about=about, tables="\n".join(parts), **words)


def _row(variable: Variable) -> str:
    unit = variable.unit
    if unit in DISPLAY_UNITS:
        unit += f" ({DISPLAY_UNITS[unit][0]})"
    least, most = ("" if limit is None else f"{limit:g}" for limit in (variable.minimum, variable.maximum))
    limits = f"{least} to {most}" if most else f"from {least}" if least else ""
    if variable.choice:
        limits = ", ".join(f"{number} {word}" for word, number in variable.choice.items.items())
    start = "" if variable.start is None else str(variable.start)
    meaning = variable.description + (", tunable" if variable.variability == "tunable" else "")
    cells = [f"<td>{escape(text)}</td>" for text in (unit, start, limits, meaning)]
    return f"<tr><td><code>{escape(variable.name)}</code></td>{''.join(cells)}</tr>"


def drawing(column: Column) -> bytes:
    """Return model.png of a column: the numbered blocks to scale, on the contacts of their joints."""
    figure = Figure(figsize=(3.0, 3.0), layout="constrained")
    axes = figure.subplots()
    zero = np.zeros((1, column.n))
    places = DisplacementHistories(column, zero, zero, zero)
    draw_column(axes, places, 0, 1.0)
    for number, (corners, contact) in enumerate(zip(corners_of(places, 0, 1.0), column.contacts, strict=True), start=1):
        if column.n <= MOST_NUMBERED:
            x, z = corners.mean(axis=0)
            axes.text(x, z, str(number), ha="center", va="center", color=INK, fontsize=8, bbox=ON_STONE)
        # the ends of the contact, on the bottom face from the first corner to the second
        along = (corners[1] - corners[0]) / np.linalg.norm(corners[1] - corners[0])
        ends = corners[:2].mean(axis=0) + np.outer((contact.left, contact.right), along)
        axes.plot(*ends.T, color=BLUE, linewidth=2.0, solid_capstyle="butt", zorder=2.5)
    axes.set_ylim(bottom=1.5 * axes.get_ylim()[0])
    return _png(figure)


def sign_conventions() -> bytes:
    """Return documentation/signs.png: a block that leans to +x on the one below it, and the positive directions."""
    figure = Figure(figsize=(6.4, 4.4), layout="constrained")
    axes = figure.subplots()
    # two blocks, the upper one leaning to +x
    foot = (0.5, 1.0)  # corner about which it rocks
    axes.add_patch(Rectangle((-0.5, 0.0), 1.0, 0.97, facecolor=STONE, edgecolor=INK))
    lean = Affine2D().rotate_deg_around(*foot, -7.0) + axes.transData
    axes.add_patch(Rectangle((-0.5, 1.0), 1.0, 1.1, facecolor=STONE, edgecolor=INK, transform=lean))
    axes.plot([-2.4, 2.4], [-0.03, -0.03], color=INK, linewidth=3.0)
    axes.plot([0.0, 0.0], [0.0, 2.35], color=INK, linewidth=0.8, linestyle=":")
    axes.text(0.0, 0.5, "block i+1", ha="center", color=INK)
    axes.text(0.1, 1.5, "block i", ha="center", color=INK)
    axes.text(-0.62, 1.0, "joint i", ha="right", va="center", color=INK)
    # axes, displacements and forces
    straight = [  # name, tail and tip of the arrow, position of the name
        ("x", (-2.3, 0.25), (-1.8, 0.25), (-1.74, 0.22)),
        ("z", (-2.3, 0.25), (-2.3, 0.75), (-2.34, 0.8)),
        ("ux", (0.0, 2.3), (0.27, 2.3), (0.33, 2.27)),
        ("N", (0.3, 1.45), (0.3, 1.02), (0.36, 1.08)),
        ("S", (0.55, 0.9), (1.05, 0.9), (1.11, 0.87)),
        ("base.ax", (-2.3, -0.35), (-1.7, -0.35), (-2.3, -0.26)),
        ("base.az", (-1.4, -0.7), (-1.4, -0.15), (-1.34, -0.66)),
        ("base.Fx", (0.6, -0.35), (1.2, -0.35), (0.65, -0.26)),
        ("base.Fz", (0.0, -0.7), (0.0, -0.15), (0.06, -0.66)),
    ]
    for name, tail, tip, place in straight:
        axes.annotate("", tip, tail, arrowprops=ARROW)
        axes.text(*place, name, color=RED)
    # rotation and moments
    turning = [
        ("theta, clockwise", (0.75, 2.1), (1.0, 1.65), -0.3, (1.05, 1.9)),
        ("M, rights the block", (1.0, 1.05), (0.72, 1.4), 0.6, (1.05, 1.3)),
        ("base.My", (-0.75, -0.5), (-0.25, -0.45), -0.9, (-0.75, -0.66)),
    ]
    for name, tail, tip, bend, place in turning:
        axes.annotate("", tip, tail, arrowprops=ARROW | {"connectionstyle": f"arc3,rad={bend}"})
        axes.text(*place, name, color=RED)
    axes.set(xlim=(-2.5, 2.6), ylim=(-0.8, 2.5), aspect="equal")
    axes.set_axis_off()
    return _png(figure)


def _png(figure: Figure) -> bytes:
    """Return a figure as PNG, whose bytes depend on the figure only."""
    png = io.BytesIO()
    figure.savefig(png, format="png", dpi=100, metadata={"Software": None})
    return png.getvalue()
