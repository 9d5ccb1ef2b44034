"""The page of a scene in a real browser, and binary glTF as other programs read it."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.browser import FOUND, Browser
from support.fmus import ROOT

from multiblock import Structure
from solver import Column, Motion, simulate
from solver.plotting.scene.bodies import scene_of

SIZE = (900, 700)  # px
WITHIN = 2.0  # px: 1.0 was measured, a pixel of the edge
NEXT = "new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)))"  # it is drawn
SHAKING = Motion.harmonic(3.0, 2.0, 0.8)
# the bounding box of the pixels of a body, from the picture that clicks are found by; y downwards
BOX = """(() => { now(); draw(true); const w = canvas.width, h = canvas.height, p = new Uint8Array(4 * w * h);
  gl.readPixels(0, 0, w, h, gl.RGBA, gl.UNSIGNED_BYTE, p); draw(); let box = [w, h, 0, 0];
  for (let y = 0; y < h; y++) for (let x = 0; x < w; x++) { const k = 4 * (w * y + x), v = h - 1 - y;
    if (p[k] === %d && p[k + 1] === 0)
      box = [Math.min(box[0], x), Math.min(box[1], v), Math.max(box[2], x + 1), Math.max(box[3], v + 1)]; }
  return box; })()"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Browser]:
    if FOUND is None:
        pytest.skip("no Chromium here")
    with Browser(*SIZE) as one:
        yield one


@pytest.fixture(scope="module")
def podium(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    model = Structure.from_toml(ROOT / "examples" / "structures" / "podium.toml")
    return made(model, tmp_path_factory.mktemp("podium"))


@pytest.fixture(scope="module")
def column(tmp_path_factory: pytest.TempPathFactory) -> tuple[Any, Path]:
    model = Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml")
    return made(model, tmp_path_factory.mktemp("column"))


def made(model: Any, folder: Path) -> tuple[Any, Path]:
    response = simulate(model, SHAKING, check=False, settle=0.0)
    response.view(folder / "scene.html", scale=1.0)
    response.to_gltf(folder / "scene.glb")
    return response, folder


def opened(browser: Browser, folder: Path) -> Browser:
    browser.errors.clear()
    browser.open(folder / "scene.html")
    return browser


def in_pixels(browser: Browser, points: Any) -> Any:
    """Return the places of points, m (k, 3), in the camera of the page: px (k, 2)."""
    eye = np.array(browser.evaluate("camera()")).reshape(4, 4).T
    seen = np.column_stack([points, np.ones(len(points))]) @ eye.T
    width, height = browser.evaluate("[canvas.width, canvas.height]")
    flat = seen[:, :2] / seen[:, 3:]
    return np.column_stack([0.5 * (1.0 + flat[:, 0]) * width, 0.5 * (1.0 - flat[:, 1]) * height])


def seen_at(browser: Browser, t: float, body: int) -> Any:
    """Move the slider to t, s, as a hand would, and find the box of a body, px."""
    browser.evaluate(f"$('time').value = {t!r}; $('time').dispatchEvent(new Event('input'))")
    browser.evaluate(NEXT)
    assert browser.evaluate("state.t") == pytest.approx(t, abs=1e-9)
    return np.array(browser.evaluate(BOX % (body + 1)))


def box_of(pixels: Any) -> Any:
    return np.concatenate([pixels.min(axis=0), pixels.max(axis=0)])


def places(response: Any, k: int, i: int) -> Any:
    """Return the places of the corners of a structure's block at a row, by `response.displacement`, m (corners, 3)."""
    block = response.model.blocks[i]
    own = (block.corners - block.centroid) @ block.axes
    return np.array([block.centroid + block.axes @ one + response.displacement(i, one)[k] for one in own])


def places_of_top(response: Any, k: int) -> Any:
    """Return the places of the corners of the top block of an upright column at a row, by its outputs, m (8, 3)."""
    block, tall = response.model.blocks[0], sum(block.height for block in response.model.blocks)
    rise, theta = block.height - block.resolved_centroid, response.ry[k, 0]
    cos, sin = np.cos(theta), np.sin(theta)
    middle = [response.ux[k, 0] - rise * sin, 0.0, tall - rise + response.uz[k, 0]]
    box = np.stack(np.meshgrid([-0.5, 0.5], [-0.5, 0.5], [0.0, 1.0]), axis=-1).reshape(-1, 3)
    x, y, z = (box * [block.width, block.depth, block.height] - [0.0, 0.0, block.height - rise]).T
    return middle + np.column_stack([cos * x + sin * z, y, cos * z - sin * x])


@pytest.mark.long
def test_the_slider_moves_the_blocks_of_a_structure(browser: Browser, podium: tuple[Any, Path]) -> None:
    response, folder = podium
    opened(browser, folder)
    boxes, slab = [], response.model.n - 1
    browser.evaluate("state.far = 0.6; now()")
    for instant in (0.1, 0.4, 0.7):
        k = int(np.argmin(np.abs(response.time - instant)))
        boxes.append(seen_at(browser, float(response.time[k]), slab))
        corners = places(response, k, slab)
        assert boxes[-1] == pytest.approx(box_of(in_pixels(browser, corners)), abs=WITHIN)
    assert np.ptp(boxes, axis=0).max() > 4.0 * WITHIN  # it has moved
    assert browser.errors == []


@pytest.mark.long
def test_the_slider_moves_the_blocks_of_a_column(browser: Browser, column: tuple[Any, Path]) -> None:
    response, folder = column
    opened(browser, folder)
    for instant in (0.1, 0.4, 0.7):
        k = int(np.argmin(np.abs(response.time - instant)))
        found = seen_at(browser, float(response.time[k]), 0)
        assert found == pytest.approx(box_of(in_pixels(browser, places_of_top(response, k))), abs=WITHIN)
    assert browser.errors == []


@pytest.mark.long
def test_a_page_can_be_used(browser: Browser, podium: tuple[Any, Path]) -> None:
    response, folder = podium
    opened(browser, folder)
    colours = browser.evaluate(
        "(() => { const p = new Uint8Array(4 * canvas.width * canvas.height); now();"
        "gl.readPixels(0, 0, canvas.width, canvas.height, gl.RGBA, gl.UNSIGNED_BYTE, p);"
        "return new Set(new Uint32Array(p.buffer)).size; })()"
    )
    assert colours > 20  # the canvas is not empty
    browser.evaluate("state.yaw = -0.6; state.factor = 1; seek(0)")
    place = in_pixels(browser, response.model.blocks[0].centroid[None])[0]
    left, top = browser.evaluate("(({left, top}) => [left, top])(canvas.getBoundingClientRect())")
    browser.click(left + place[0], top + place[1])
    browser.evaluate(NEXT)
    assert browser.evaluate("[state.chosen, $('history').hidden]") == [0, False]
    joint = browser.evaluate("state.chosen = n; now(); [$('chosen').textContent, $('names').textContent]")
    assert joint[0] == response.model.joint_names[0]
    assert joint[1].startswith("contact pressure, of ")
    browser.evaluate("$('play').click()")
    browser.evaluate("new Promise((done) => { const f = () => state.t > 0.1 ? done() : setTimeout(f, 20); f(); })")
    browser.evaluate("play(false); seek(0.4); $('moving').click(); now()")
    shaken, built = browser.evaluate("[matrix(0, row(0.4)), (state.moving = false, matrix(0, row(0.4)))]")
    assert shaken[12] != built[12]
    browser.resize(390, 760, 2.0, touch=True)
    assert browser.evaluate("document.documentElement.scrollWidth") <= 390  # nothing sticks out at the width of a phone
    browser.resize(*SIZE)
    assert browser.errors == []


def test_the_validator_of_khronos_has_nothing_to_say(podium: tuple[Any, Path], column: tuple[Any, Path]) -> None:
    node = shutil.which("node")
    text = "const v = require('gltf-validator'), f = require('fs');"
    if node is None or subprocess.run([node, "-e", text], capture_output=True).returncode:
        pytest.skip("no gltf-validator here: npm install gltf-validator, and NODE_PATH")
    text += "v.validateBytes(new Uint8Array(f.readFileSync(process.argv[1])))"
    text += ".then((found) => console.log(JSON.stringify(found.issues)))"
    for _, folder in (podium, column):
        done = subprocess.run([node, "-e", text, folder / "scene.glb"], capture_output=True, text=True, env=os.environ)
        issues = json.loads(done.stdout)
        assert (issues["numErrors"], issues["numWarnings"]) == (0, 0), issues["messages"]


def test_three_js_moves_the_blocks_as_the_response_says(podium: tuple[Any, Path]) -> None:
    """Compare at rows, between which it blends: 3e-8 m was measured."""
    response, folder = podium
    if not (Path(os.environ.get("NODE_PATH", "")) / "three" / "package.json").is_file():
        pytest.skip("no three here: npm install three, and NODE_PATH")
    scene = scene_of(response, 30.0)
    rows = (3, 12, 20)
    times = json.dumps([float(scene.time[k]) for k in rows])
    script = ROOT / "tests" / "support" / "vertices.mjs"
    done = subprocess.run(["node", script, folder / "scene.glb", times], capture_output=True, text=True, check=True)
    for k, found in zip(rows, json.loads(done.stdout), strict=True):
        for i, block in enumerate(response.model.blocks):
            vertices = np.array(found[block.name])
            for place in places(response, int(scene.rows[k]), i):
                assert np.min(np.linalg.norm(vertices - place, axis=1)) < 1e-6


def test_another_reader_finds_the_blocks_as_built(podium: tuple[Any, Path]) -> None:
    trimesh = pytest.importorskip("trimesh")
    response, folder = podium
    scene = trimesh.load(folder / "scene.glb")
    up = np.array([[1.0, 0.0, 0.0], [0.0, 0.0, -1.0], [0.0, 1.0, 0.0]])  # from y up
    for block in response.model.blocks:
        place, geometry = scene.graph[block.name]
        mesh = scene.geometry[geometry]
        vertices = (mesh.vertices @ place[:3, :3].T + place[:3, 3]) @ up.T
        for corner in block.corners:
            assert np.min(np.linalg.norm(vertices - corner, axis=1)) < 1e-6
        assert mesh.volume == pytest.approx(block.volume, rel=1e-6)
