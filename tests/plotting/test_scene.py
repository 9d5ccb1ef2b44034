"""The scene of a response: the same places in files as in the response."""

import json
import math
import runpy
import zipfile
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import meshio
import numpy as np
import pytest
from fmpy.util import write_csv
from support.fmus import ROOT

from multiblock import Structure
from solver import Column, InputError, Motion, simulate
from solver.ground import wavelets
from solver.models.structure.blocks.shapes import turned
from solver.plotting.scene.bodies import normal_of, parts_of, scene_of, walls_of
from solver.plotting.scene.gltf import animated, still
from solver.plotting.scene.page import _coarse, _path_of_base, write_view

INSTANTS = (0.1, 0.4, 0.7)
SHAKING = Motion.harmonic(3.0, 2.0, 0.8)


@pytest.fixture(scope="module")
def in_space() -> Any:
    structure = Structure.from_toml(ROOT / "examples" / "structures" / "podium.toml")
    return simulate(structure, SHAKING, check=False, settle=0.0)


@pytest.fixture(scope="module")
def in_plane() -> Any:
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas-round.toml")
    return simulate(column, SHAKING, check=False, settle=0.0)


def contents(path: Path) -> tuple[Any, bytes]:
    """Return JSON and buffer of a .glb."""
    data = path.read_bytes()
    assert data[:4] == b"glTF"
    assert int.from_bytes(data[8:12], "little") == len(data)
    size = int.from_bytes(data[12:16], "little")
    return json.loads(data[20 : 20 + size]), data[28 + size :]


def numbers(gltf: Any, data: bytes, accessor: int) -> Any:
    """Return the numbers of an accessor."""
    found = gltf["accessors"][accessor]
    view, size = gltf["bufferViews"][found["bufferView"]], {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[found["type"]]
    kind = {5126: "<f4", 5125: "<u4"}[found["componentType"]]
    values = np.frombuffer(data, kind, found["count"] * size, view["byteOffset"])
    return values.reshape(-1, size).astype(float)


def rotated(q: Any, points: Any) -> Any:
    """Return the points turned by a quaternion, the real part last."""
    across = np.cross(q[:3], points)
    return points + 2.0 * (q[3] * across + np.cross(q[:3], across))


def vertices_of(path: Path, t: float) -> dict[str, tuple[Any, Any]]:
    """Return by name of the body its vertices about its centroid as built, and in the scene at t, in m, z up."""
    gltf, data = contents(path)
    found = {}
    (animation,) = gltf["animations"]
    holders = {node["children"][0]: node for node in gltf["nodes"][1:] if "children" in node}
    for number, node in enumerate(gltf["nodes"]):
        if "mesh" not in node:
            continue
        pose = {}
        for channel in animation["channels"]:
            if channel["target"]["node"] == number:
                sampler = animation["samplers"][channel["sampler"]]
                k = np.argmin(np.abs(numbers(gltf, data, sampler["input"])[:, 0] - t))
                pose[channel["target"]["path"]] = numbers(gltf, data, sampler["output"])[k]
        primitive = gltf["meshes"][node["mesh"]]["primitives"][0]
        points = numbers(gltf, data, primitive["attributes"]["POSITION"])
        placed = rotated(pose["rotation"], points) + pose["translation"] + holders[number]["translation"]
        found[node["name"]] = points, placed
    return found


def test_gltf_has_the_places_of_a_structure(in_space: Any, tmp_path: Path) -> None:
    in_space.to_gltf(tmp_path / "scene.glb")
    sampled = scene_of(in_space, 30.0).time
    for instant in INSTANTS:
        t = sampled[np.argmin(np.abs(sampled - instant))]
        row = int(np.argmin(np.abs(in_space.time - t)))
        for name, (points, placed) in vertices_of(tmp_path / "scene.glb", t).items():
            block = in_space.model.blocks[in_space.model.number(name)]
            for point, place in zip(points[::7], placed[::7], strict=True):
                moved = in_space.displacement(name, block.axes.T @ point)[row]
                assert place == pytest.approx(block.centroid + point + moved, abs=1e-6)


def test_gltf_has_the_places_of_a_column(in_plane: Any, tmp_path: Path) -> None:
    in_plane.to_gltf(tmp_path / "scene.glb")
    sampled = scene_of(in_plane, 30.0).time
    for instant in INSTANTS:
        t = sampled[np.argmin(np.abs(sampled - instant))]
        row = int(np.argmin(np.abs(in_plane.time - t)))
        for i, block in enumerate(in_plane.model.blocks):
            points, placed = vertices_of(tmp_path / "scene.glb", t)[f"block {i + 1}"]
            top = np.isclose(points[:, 2], np.max(points[:, 2]))
            assert np.mean(np.unique(placed[top].round(9), axis=0)[:, 0]) == pytest.approx(
                in_plane.ux[row, i], abs=1e-6
            )
            theta = in_plane.ry[row, i]
            height = sum(other.height for other in in_plane.model.blocks[i + 1 :]) + block.resolved_centroid
            arm = points[0]
            place = height + in_plane.uz[row, i] - math.sin(theta) * arm[0] + math.cos(theta) * arm[2]
            assert placed[0, 2] == pytest.approx(place, abs=1e-6)


@pytest.mark.parametrize("name", ["structures/arch", "structures/colonnade", "structures/casks", "columns/leaning"])
def test_surfaces_are_closed_and_look_outwards(name: str) -> None:
    path = ROOT / "examples" / f"{name}.toml"
    model: Any = (Structure if name.startswith("structures") else Column).from_toml(path)
    response = simulate(model, Motion.harmonic(0.1, 2.0, 0.02), check=False, settle=0.0)
    for body in scene_of(response, 30.0).bodies:
        areas = 0.0
        volume = 0.0
        for surface in body.surfaces:
            arms = surface.points - surface.points[0]
            area = 0.5 * np.sum(np.cross(arms[1:-1], arms[2:]), axis=0)
            areas = areas + area
            volume += float(area @ surface.points[0]) / 3.0
            assert normal_of(surface.points) @ area > 0.0
        assert np.max(np.abs(areas)) < 1e-9
        assert volume > 0.0


def test_rows_of_a_column_turn_as_in_space() -> None:
    assert turned(np.array([0.0, 0.1, 0.0]), np.array([0.0, 0.0, 1.0]))[0] > 0.0  # clockwise, as x points to the right


@pytest.mark.parametrize("which", ["in_space", "in_plane"])
def test_results_of_an_fmu_move_the_blocks_inside_it(
    which: str, request: pytest.FixtureRequest, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Move them by the numbers of the blocks, as an FMU has them, or by plain names; the same places as from the
    response.
    """
    response = request.getfixturevalue(which)
    model, labels = response.model, {1: "block[{}].{}", 0: "block{}.{}"}[which == "in_plane"]
    bodies, _ = parts_of(model)
    with zipfile.ZipFile(tmp_path / "some.fmu", "w") as archive:
        archive.writestr("resources/scene.glb", still(model.name, bodies, not model.kind.across))
    outputs = [output for output in response.outputs if output.owner == "block"]
    named = {
        labels.format(i + 1, one.name): getattr(response, one.field)[:, i] for i in range(model.n) for one in outputs
    }
    table = np.column_stack([response.time, *named.values()])
    head = ",".join(f'"{name}"' for name in ("time", *named))
    np.savetxt(tmp_path / "results.csv", table, delimiter=",", header=head, comments="", fmt="%.17g")
    monkeypatch.setattr("sys.argv", ["", *(str(tmp_path / name) for name in ("some.fmu", "results.csv", "moving.glb"))])
    runpy.run_path(str(ROOT / "examples" / "animate_fmu.py"))
    response.to_gltf(tmp_path / "scene.glb")
    t = float(scene_of(response, 30.0).time[12])
    expected = vertices_of(tmp_path / "scene.glb", t)
    for name, (_, placed) in vertices_of(tmp_path / "moving.glb", t).items():
        assert placed == pytest.approx(expected[name][1], abs=1e-9)
    # the same from FMI 3.0, as FMPy writes arrays: one column for each
    shape = [("time", float), *((f"block.{one.name}", float, (model.n,)) for one in outputs), ("overturned", bool)]
    results = np.zeros(len(response.time), shape)
    results["time"] = response.time
    for one in outputs:
        results[f"block.{one.name}"] = getattr(response, one.field).reshape(-1, model.n)
    write_csv(tmp_path / "results.csv", results)
    runpy.run_path(str(ROOT / "examples" / "animate_fmu.py"))
    for name, (_, placed) in vertices_of(tmp_path / "moving.glb", t).items():
        assert placed == pytest.approx(expected[name][1], abs=1e-9)
    with pytest.raises(InputError, match=r"block\[1\].ux: is missing"):
        animated(still(model.name, bodies, which == "in_plane"), response.time, {})


def test_a_page_of_many_blocks_for_20_s_has_3_mb_at_most(in_space: Any, tmp_path: Path) -> None:
    """Check that the rows are fewer where there are many blocks. 2.5 MB was measured."""
    n, rows = 200, 2001
    drum = {"shape": "drum", "diameter": 1.0, "height": 1.0, "mass": 2000.0}
    blocks = [{"name": f"b{i}", "on": f"b{i - 1}" if i else "base", **drum} for i in range(n)]
    structure = Structure.from_dict({"name": "tower", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": blocks})
    long = {name: np.zeros((rows, n)) for name in ("ux", "uy", "uz", "rx", "ry", "rz", "contact", "sigma_max")}
    found = SimpleNamespace(model=structure, time=np.linspace(0.0, 20.0, rows), verdict="standing", **long)
    found.peaks, found.overturn_time, found.motion = {"u": np.zeros(n)}, math.nan, in_space.motion
    write_view(found, tmp_path / "scene.html", None)
    assert (tmp_path / "scene.html").stat().st_size < 3_000_000


def test_the_base_moves_by_its_displacement_without_drift() -> None:
    """Check that a harmonic of acceleration drifts; what is left has its amplitude, a over omega squared, to 3 %."""
    path = _path_of_base(Motion.harmonic(2.0, 2.0, 20.0), np.linspace(0.0, 20.0, 4001))
    assert np.max(np.abs(path[200:-200, 0])) == pytest.approx(2.0 / (4.0 * np.pi) ** 2, rel=0.1)
    assert np.max(np.abs(path[:, 1:])) == 0.0


def test_a_base_that_comes_to_rest_where_it_began_keeps_its_motion() -> None:
    """Compare with a Ricker pulse of acceleration integrated twice: -A exp(-s^2) / (2 pi^2 f^2), s = pi f t."""
    motion, frequency = wavelets.ricker(4.9, 1.5), 1.5
    path = _path_of_base(motion, motion.time)[:, 0]
    about = motion.time - motion.time[np.argmax(motion.ax)]
    exact = -4.9 / (2.0 * (np.pi * frequency) ** 2) * np.exp(-((np.pi * frequency * about) ** 2))
    assert np.max(np.abs(path - exact)) < 1e-3 * np.max(np.abs(exact))


def test_a_base_that_comes_to_rest_elsewhere_keeps_its_motion() -> None:
    """Compare with one sine of acceleration integrated twice: A / w (t - sin(w t) / w), 0.312 m at its end."""
    motion, w = wavelets.one_sine(0.2 * 9.80665, 1.0), 2.0 * np.pi
    path = _path_of_base(motion, motion.time)[:, 0]
    exact = 0.2 * 9.80665 / w * (motion.time - np.sin(w * motion.time) / w)
    assert np.sign(motion.ax[1]) * path == pytest.approx(exact, abs=1e-4)
    assert abs(path[-1]) == pytest.approx(0.312, abs=1e-3)


def test_a_mesh_keeps_its_shape_in_few_triangles() -> None:
    structure = Structure.from_toml(ROOT / "examples" / "structures" / "statue-mesh.toml")
    (body,) = (body for body in parts_of(structure)[0] if body.meshed)
    whole, few = _coarse(body, 10**6), _coarse(body, 300)
    assert len(whole) == len(body.surfaces) > 300 >= len(few) > 50
    ends = [np.concatenate(triangles.reshape(-1, 3)[None].min(axis=1)) for triangles in (whole, few)]
    assert ends[1] == pytest.approx(ends[0], abs=0.1 * np.ptp(whole[:, :, 2]))


def test_another_suffix_is_refused(in_plane: Any, tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"must end in \.glb"):
        in_plane.to_gltf(tmp_path / "scene.gltf")


LINKS = "http:", "https:", "src=", "fetch(", "import "


def test_a_page_fetches_nothing_and_is_small(in_space: Any, tmp_path: Path) -> None:
    in_space.view(tmp_path / "scene.html")
    text = (tmp_path / "scene.html").read_text(encoding="utf-8")
    assert len(text) < 3_000_000
    assert not any(word in text for word in LINKS)
    of_site = (ROOT / "docs" / "style" / "scene.html").read_text(encoding="utf-8")
    assert len(of_site) < 500_000
    assert not any(word in of_site for word in LINKS)
    assert not any(mark in text for mark in ("@TITLE@", "@NAME@", "@LINE@", "@SCENE@", "@VIEWER@"))
    with pytest.raises(InputError, match=r"must end in \.html"):
        in_space.view(tmp_path / "scene.png")


def test_walls_are_drawn_where_they_stand(tmp_path: Path) -> None:
    """Draw them as far as they are near the blocks, in a page, a .glb and files for ParaView; seen from the blocks."""
    structure = Structure.from_toml(ROOT / "examples" / "structures" / "facade.toml")
    (wall,) = walls_of(structure)
    points = wall.centroid + wall.surfaces[0].points
    beyond = 0.3 * 2.6  # m, of its height
    assert points.min(axis=0) == pytest.approx([-0.155, -0.6 - beyond, 0.0], abs=1e-12)
    assert points.max(axis=0) == pytest.approx([-0.155, 0.6 + beyond, 3.0], abs=1e-12)
    assert normal_of(points) == pytest.approx([1.0, 0.0, 0.0], abs=1e-12)
    response = simulate(structure, SHAKING, settle=0.0)
    response.to_gltf(tmp_path / "facade.glb")
    gltf, data = contents(tmp_path / "facade.glb")
    (node,) = (node for node in gltf["nodes"] if node.get("name") == "wall 1")
    assert gltf["nodes"].index(node) in gltf["nodes"][0]["children"]
    held = numbers(gltf, data, gltf["meshes"][node["mesh"]]["primitives"][0]["attributes"]["POSITION"])
    assert held + node["translation"] == pytest.approx(points, abs=1e-6)
    response.view(tmp_path / "facade.html")
    assert f'"walls":[{json.dumps(points.round(6).tolist(), separators=(",", ":"))}]' in (
        tmp_path / "facade.html"
    ).read_text(encoding="utf-8")
    response.to_vtk(tmp_path / "vtk", fps=2.0)
    mesh = meshio.read(tmp_path / "vtk" / "walls.vtu")
    assert mesh.points == pytest.approx(points, abs=1e-12)
    assert mesh.cell_data["wall"][0].tolist() == [1]
    assert scene_of(response, 2.0).corners.max(axis=0)[2] == 3.0


def test_a_block_may_have_the_name_of_a_mark_of_the_page(tmp_path: Path) -> None:
    block = {"name": "@VIEWER@", "on": "base", "width": 1.0, "depth": 1.0, "height": 1.0, "density": 2000.0}
    structure = Structure.from_dict({"name": "marks", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]})
    page = tmp_path / "page.html"
    simulate(structure, SHAKING, check=False, settle=0.0).view(page)
    text = page.read_text(encoding="utf-8")
    assert '"name":"@VIEWER@"' in text
