"""Draw the pictures of structures as their scenes show them: `python docs/make_scene_images.py`, with a Chromium.

images/first.png: a colonnade that falls; style/scene.html: the page that plays it; images/structures.png: those of
examples/structures where they move most, each with the orbit of its highest block in plan.
"""

import io
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from PIL import Image

from multiblock import Motion, Structure, simulate, wavelets
from solver.ground.motion import STANDARD_GRAVITY
from solver.plotting.scene.page import small_page
from solver.plotting.style import GREY, INK, RED, tidy

HERE = Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "tests"))

from support.browser import Browser  # noqa: E402

EXAMPLES = HERE.parent / "examples" / "structures"
NAMES = ("trilith", "colonnade", "doric-in-space", "podium", "arch", "casks")
SHAKING = Motion.harmonic(0.25 * STANDARD_GRAVITY, 1.2, 4.0, direction=0.4)
PULSE = wavelets.ricker(0.7 * STANDARD_GRAVITY, 0.8).turned(np.radians(30.0))
NEARER = {"colonnade": 0.85, "arch": 0.8, "casks": 1.1}  # how far the viewer stands, of where a page begins
SIZE = 560, 460  # px of a still, at twice as many pixels
NEXT = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"


def main() -> None:
    """Write all of them."""
    with tempfile.TemporaryDirectory() as folder, Browser(*SIZE) as browser:
        browser.resize(*SIZE, ratio=2.0)
        draw_first(browser, Path(folder))
        draw_structures(browser, Path(folder))
    if browser.errors:
        raise SystemExit("\n".join(browser.errors))


def stills(browser: Browser, folder: Path, response: Any, scale: float | None, instants: Any, shown: str = "") -> Any:
    """Pictures of a response at instants, s, and the length of the squares of its ground and the factor, in words."""
    response.view(folder / "scene.html", scale)
    browser.open(folder / "scene.html")
    larger = "" if scale else "state.factor = SCENE.visible; "
    browser.evaluate(f"document.body.classList.add('still'); {larger}{shown}")
    found = []
    for t in instants:
        browser.evaluate(f"seek({float(t)!r})")
        browser.evaluate(NEXT)
        browser.picture(folder / "still.png")
        found.append(Image.open(io.BytesIO((folder / "still.png").read_bytes())).convert("RGB"))
    return found, float(browser.evaluate("state.factor"))


def draw_first(browser: Browser, folder: Path) -> None:
    """The colonnade before, at the largest opening, as it falls; the acceleration of its base, and its beams' way."""
    response = simulate(Structure.from_toml(EXAMPLES / "colonnade.toml"), PULSE, settle=3.0)
    opened = float(response.time[int(np.argmin(np.mean(response.contact, axis=1)))])
    fall = response.overturn_time
    instants = (0.0, min(opened, fall - 1.2), fall - 0.45, fall)
    figure = Figure(figsize=(13.0, 5.4))
    grid = figure.add_gridspec(1, 4, left=0.005, right=0.995, top=0.86, bottom=0.36, wspace=0.02)
    below = figure.add_gridspec(1, 2, left=0.04, right=0.985, top=0.27, bottom=0.09, wspace=0.08)
    hidden = "$('legend').hidden = $('axes').hidden = true; state.far = 0.75;"
    pictures, _ = stills(browser, folder, response, 1.0, instants, hidden)
    names, last = response.model.names, response.fallen - 1
    name = names[last]
    words = ("it stands", "joints open (orange)", "columns tip", f"{name} falls")
    for k, (picture, t, word) in enumerate(zip(pictures, instants, words, strict=True)):
        axes = figure.add_subplot(grid[k])
        axes.imshow(picture)
        axes.set_axis_off()
        axes.set_title(f"{t:.1f} s: {word}", fontsize=11, loc="left", color=RED if k == 3 else INK)
    time = np.linspace(0.0, response.time[-1], 1000)
    base, moved = figure.add_subplot(below[0]), figure.add_subplot(below[1])
    base.plot(time, PULSE.acceleration(time)[0] / STANDARD_GRAVITY, color=INK)
    base.set_title("you give: blocks, joints, and the motion of the base, along x (g)", fontsize=10, loc="left")
    top = [i for i, block in enumerate(response.model.blocks) if not block.faces[0].radius][:1] or [0]
    for i in (*top, last):
        moved.plot(response.time, np.hypot(response.ux[:, i], response.uy[:, i]), label=names[i])
    moved.set_title("you get: how far each block moves (m), the forces, what falls and when", fontsize=10, loc="left")
    moved.legend(frameon=False, fontsize=9)
    for axes in (base, moved):
        tidy(axes)
        axes.set_xlim(0.0, response.time[-1])
        axes.set_xlabel("time (s)", fontsize=9)
        for t in instants:
            axes.axvline(t, color=GREY, linewidth=0.8, linestyle=":")
    title = "Blocks under an earthquake: four columns, three beams, a pulse of 0.7 g from 30 degrees"
    figure.text(0.01, 0.95, title, fontsize=14, color=INK, weight="bold")
    figure.savefig(HERE / "images" / "first.png", dpi=110)
    (HERE / "style" / "scene.html").write_text(small_page(response, 1.0), encoding="utf-8")
    print(f"first.png: {name} falls at {fall:.2f} s; {response.verdict}")


def draw_structures(browser: Browser, folder: Path) -> None:
    """Each structure where it moves most, and the orbit of its highest block beside it."""
    figure = Figure(figsize=(13.0, 6.6))
    grid = figure.add_gridspec(2, 3, left=0.01, right=0.99, top=0.9, bottom=0.01, wspace=0.04, hspace=0.12)
    figure.text(0.01, 0.96, "Joints in contact are blue, open ones orange.", fontsize=11, color=INK)
    for k, name in enumerate(NAMES):
        response = simulate(Structure.from_toml(EXAMPLES / f"{name}.toml"), SHAKING, settle=0.0)
        at = response.time[int(np.argmax(np.max(np.hypot(response.ux, response.uy), axis=1)))]
        shown = f"$('legend').hidden = true; state.far = {NEARER.get(name, 1.0)};"
        (picture,), factor = stills(browser, folder, response, None, [at], shown)
        cell = grid[k].subgridspec(1, 2, width_ratios=(3.4, 1.0), wspace=0.03)
        axes, plan = figure.add_subplot(cell[0]), figure.add_subplot(cell[1])
        axes.imshow(picture)
        axes.set_axis_off()
        text = f"{name}, {at:.2f} s, drawn {factor:g} times larger, squares of {browser.evaluate('CELL'):g} m"
        axes.set_title(text, fontsize=10, loc="left", color=INK)
        top = int(np.argmax([block.centroid[2] for block in response.structure.blocks]))
        way = 1e3 * np.column_stack([response.ux[:, top], response.uy[:, top]])
        plan.plot(*way.T, color=INK, linewidth=0.7)
        half, middle = 0.55 * float(np.ptp(way, axis=0).max()), 0.5 * (way.min(axis=0) + way.max(axis=0))
        plan.set(xlim=middle[0] + np.array([-half, half]), ylim=middle[1] + np.array([-half, half]), aspect="equal")
        plan.set(xticks=[], yticks=[], anchor="C")
        plan.set_title(f"{response.structure.names[top]} in plan,\n{np.ptp(way, axis=0).max():.3g} mm", fontsize=8)
        print(f"{name}: {1e3 * response.peaks['u'].max():.0f} mm, {response.verdict}")
    figure.savefig(HERE / "images" / "structures.png", dpi=100)


if __name__ == "__main__":
    main()
