"""Blocks of points and of meshes: mass properties, faces, feet, files, and that everything takes them."""

from __future__ import annotations

import importlib.util
import itertools
import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from fmu_src.body import body_of, read_body
from multiblock import InputError, Motion, Structure, simulate, simulate_many
from solver.models.column.model import Column
from solver.models.structure.blocks.hulls import bulk_of, checked, convex_surface, hull_of
from solver.models.structure.hull_tables import with_hulls
from solver.models.structure.overlap import deepest_overlap
from solver.models.structure.stack import column_of
from solver.plotting.structures import structure_picture

EXAMPLES = ROOT / "examples" / "structures"
STATUE = EXAMPLES / "statue.obj"
LAW = {"stiffness": 2e9, "damping": 1e-3, "friction": 0.7}
BOX = [[x, y, z] for x in (0.0, 1.0) for y in (0.0, 0.6) for z in (0.0, 2.0)]
HULL: dict[str, Any] = {"name": "stone", "on": "base", "shape": "hull", "points": BOX, "density": 2500.0}
MESH: dict[str, Any] = {"name": "stone", "on": "base", "shape": "mesh", "file": str(STATUE), "density": 2700.0}
SHAKING = Motion.harmonic(6.0, 1.5, 2.0, direction=0.4)


def needs_trimesh(test: Any) -> Any:
    there = importlib.util.find_spec("trimesh")
    return pytest.mark.skipif(not there, reason="needs trimesh, of the extra mesh")(test)


def structure_of(*blocks: dict[str, Any]) -> Structure:
    return Structure.from_dict({"name": "stones", "joints": LAW, "block": list(blocks)})


def sphere(count: int) -> np.ndarray:
    """Return the points all over a sphere of radius 1, (count, 3)."""
    k = np.arange(count) + 0.5
    z, angle = 1.0 - 2.0 * k / count, np.pi * (1.0 + np.sqrt(5.0)) * k
    return np.column_stack([np.sqrt(1.0 - z * z) * np.cos(angle), np.sqrt(1.0 - z * z) * np.sin(angle), z])


def about(inertia: np.ndarray, volume: float, arm: np.ndarray) -> np.ndarray:
    """Return the inertia about a point that is `arm` away from the centroid."""
    return inertia + volume * (arm @ arm * np.eye(3) - np.outer(arm, arm))


# mass properties


def test_bulk_of_a_box_anywhere() -> None:
    turn, _ = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))
    points = np.array(BOX) @ turn.T + [30.0, -20.0, 7.0]
    hull = hull_of(convex_surface(points))
    bulk = bulk_of(hull.triangles)
    assert len(hull.faces) == 6
    assert {len(face) for face in hull.faces} == {4}
    assert bulk.volume == pytest.approx(1.2, rel=1e-13)
    assert bulk.centroid == pytest.approx(np.mean(points, axis=0), rel=1e-13)
    square = np.array([1.0, 0.36, 4.0]) / 12.0 * 1.2
    expected = turn @ np.diag(np.sum(square) - square) @ turn.T
    assert np.max(np.abs(bulk.inertia - expected)) < 1e-13


def test_bulk_of_a_tetrahedron() -> None:
    """Compare with corners 0, a ex, b ey, c ez: volume a b c / 6, second moments V a^2 / 10 and V a b / 20 about the
    first.
    """
    sides = np.array([1.0, 2.0, 3.0])
    hull = hull_of(convex_surface(np.concatenate([np.zeros((1, 3)), np.diag(sides)])))
    bulk = bulk_of(hull.triangles)
    assert bulk.volume == pytest.approx(1.0, rel=1e-14)
    assert bulk.centroid == pytest.approx(sides / 4.0, rel=1e-14)
    second = (np.outer(sides, sides) + np.diag(sides**2)) / 20.0
    found = about(bulk.inertia, bulk.volume, bulk.centroid)
    assert np.max(np.abs(found - (np.trace(second) * np.eye(3) - second))) < 1e-13


def test_bulk_of_an_octahedron() -> None:
    """Compare with half diagonals of 1: volume 4 / 3, inertia V / 5."""
    bulk = bulk_of(convex_surface(np.concatenate([np.eye(3), -np.eye(3)])))
    assert bulk.volume == pytest.approx(4.0 / 3.0, rel=1e-14)
    assert np.max(np.abs(bulk.inertia - 4.0 / 15.0 * np.eye(3))) < 1e-14


def test_bulk_of_an_ellipsoid_converges_by_the_size_of_its_triangles() -> None:
    axes = np.array([1.0, 2.0, 3.0])
    errors = []
    for count in (1000, 4000):
        bulk = bulk_of(convex_surface(sphere(count) * axes))
        volume = 4.0 / 3.0 * np.pi * np.prod(axes)
        inertia = volume / 5.0 * np.diag(np.sum(axes**2) - axes**2)
        errors.append((1.0 - bulk.volume / volume, 1.0 - np.diag(bulk.inertia)[0] / inertia[0, 0]))
        assert np.max(np.abs(bulk.centroid)) < 1e-3
    assert errors[1][0] < 2e-3  # measured: 1.5e-3
    assert np.array(errors[0]) / errors[1] == pytest.approx(4.0, rel=0.05)


def test_a_hull_that_is_simplified_keeps_its_corners() -> None:
    """Check that a box whose edges are rounded by 600 points has the same flat sides within a thousandth."""
    rounded = np.array([[0.5, 0.3, 1.0]]) * np.sign(sphere(600)) + 0.02 * sphere(600)
    small = hull_of(convex_surface(rounded))
    assert len(small.points) < 310
    assert np.max(small.points, axis=0) == pytest.approx(np.max(rounded, axis=0), rel=1e-12)


@pytest.mark.parametrize("seed", range(8))
def test_flat_sides_that_are_rounded_in_a_file_are_one_face(seed: int) -> None:
    """Read a box of many triangles in single precision, as STL has it, far from the origin in double precision."""
    rng = np.random.default_rng(seed)
    grid = np.linspace(0.0, 1.0, 9)
    cube = np.array([p for p in itertools.product(grid, repeat=3) if {0.0, 1.0} & set(p)])
    turn, _ = np.linalg.qr(rng.normal(size=(3, 3)))
    points = (cube * rng.uniform(0.3, 2.0, 3)) @ turn
    for found in (points.astype(np.float32).astype(np.float64), points + 300.0 * rng.normal(size=3)):
        hull = hull_of(convex_surface(found))
        assert len(hull.faces) == 6
        assert checked(hull.points, hull.faces) == hull


# the block


def test_a_hull_of_a_box_is_the_box() -> None:
    """Compare with faces in another order and at places that differ by rounding, as the answer does."""
    box = {"name": "stone", "on": "base", "width": 1.0, "depth": 0.6, "height": 2.0, "density": 2500.0}
    one, other = structure_of(HULL), structure_of(box)
    assert one.is_plane
    expected, found = simulate(other, SHAKING), simulate(one, SHAKING)
    assert found.verdict == expected.verdict
    assert found.peaks["u"] == pytest.approx(expected.peaks["u"], rel=1e-6)
    assert isinstance(column_of(one), Column)


def test_hulls_touch_by_foot_top_and_sides() -> None:
    left = {**HULL, "name": "left"}
    right = {**HULL, "name": "right", "at": [1.0, 0.0]}
    beam = {**HULL, "name": "beam", "on": ["left", "right"], "at": [0.5, 0.1]}
    data = {"name": "a", "joints": LAW, "block": [left, right, beam], "joint": [{"between": ["left", "right"]}]}
    structure = Structure.from_dict(data)
    areas = [joint.face.moments[0] for joint in structure.joints]
    assert areas == pytest.approx([0.6, 0.6, 0.25, 0.25, 1.2], rel=1e-12)


def test_a_hull_with_a_position_keeps_its_points() -> None:
    block = structure_of({**HULL, "position": [3.0, 1.0, 0.0]}).blocks[0]
    assert block.centroid == pytest.approx([3.5, 1.3, 1.0])
    standing = structure_of(HULL).blocks[0]
    assert standing.centroid == pytest.approx([0.0, 0.0, 1.0])


def test_a_foot_may_be_given_and_found_within_a_level() -> None:
    small = [[x, y, 0.0] for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    rocker = [*small, *([x - 0.5, y - 0.3, z + 0.01] for x, y, z in BOX)]
    areas = []
    for more in ({}, {"level": 0.02}, {"foot": [[-0.2, -0.2], [0.2, -0.2], [0.2, 0.2], [-0.2, 0.2]]}):
        structure = structure_of({**HULL, "points": rocker, **more})
        areas.append(structure.joints[0].face.moments[0])
        assert structure.blocks[0].mass == pytest.approx(
            3000.0 + 2500.0 * 0.01 / 3.0 * (0.6 + 0.04 + (0.6 * 0.04) ** 0.5), rel=2e-3
        )
    assert areas == pytest.approx([0.04, 0.6, 0.16])


LEG, ALONG, ACROSS, HIGH, SLAB = 0.1, 0.55, 0.35, 0.75, 0.05  # m: width of a leg, places of the legs, top, its depth
LEGS = [
    [[x + sx * LEG / 2, y + sy * LEG / 2] for sx, sy in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    for x in (-ALONG, ALONG)
    for y in (-ACROSS, ACROSS)
]
PARTS = [
    ((0.0, 0.0, HIGH - SLAB / 2), (2 * ALONG + LEG, 2 * ACROSS + LEG, SLAB)),
    *(((x, y, (HIGH - SLAB) / 2), (LEG, LEG, HIGH - SLAB)) for x in (-ALONG, ALONG) for y in (-ACROSS, ACROSS)),
]


def bulk_of_boxes() -> tuple[float, np.ndarray, np.ndarray]:
    """Return the volume, centroid and inertia of density 1 of the table: those of its boxes by the theorem of
    Steiner.
    """
    middles, sizes = (np.array([part[k] for part in PARTS]) for k in (0, 1))
    volumes = np.prod(sizes, axis=1)
    centroid = volumes @ middles / np.sum(volumes)
    inertia = np.zeros((3, 3))
    for volume, middle, size in zip(volumes, middles, sizes, strict=True):
        own = volume / 12.0 * np.diag(np.sum(size**2) - size**2)
        inertia += about(own, volume, middle - centroid)
    return float(np.sum(volumes)), centroid, inertia


def table(**more: Any) -> dict[str, Any]:
    """Return a table of stone on four legs by its numbers, its middle at the origin."""
    volume, centroid, inertia = bulk_of_boxes()
    points = [[x, y, z] for x in (-0.6, 0.6) for y in (-0.4, 0.4) for z in (0.0, HIGH)]
    six = inertia[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist()
    bulk = {"volume": volume, "centroid": centroid.tolist(), "inertia": six}
    return {"name": "table", "on": "base", "shape": "hull", "points": points, "density": 2700.0, **bulk, **more}


@pytest.mark.parametrize("lifted", [False, True])
def test_what_stands_on_several_feet_bears_on_them_alone(lifted: bool) -> None:
    """Compare at rest under a couple about y with the closed form: all legs, or those of one side while the others have
    lifted.

    All legs: couple + W h r = k r (sum of LEG^4 / 12 + LEG^2 ALONG^2) with the rotation r, weight W and height h of the
    centroid. Two: couple + W h r = W (ALONG + e), r = 6 W e / (k LEG^4).
    """
    stiffness = 1e9
    law = {"stiffness": stiffness, "damping": 1e-3}
    data = {"name": "a", "joints": law, "block": [table(foot=LEGS)], "port": [{"name": "top", "block": "table"}]}
    structure = Structure.from_dict(data)
    assert [joint.face.moments[0] for joint in structure.joints] == pytest.approx([LEG**2] * 4, rel=1e-12)
    weight, high = structure.weight, float(structure.blocks[0].centroid[2])
    if lifted:
        couple, slope = weight * (ALONG + 0.1 * LEG), 6.0 * weight / (stiffness * LEG**4)
        off = (couple / weight - ALONG) / (1.0 - high * slope)
        rotation, loads = slope * off, [0.0, 0.0, 0.5 * weight, 0.5 * weight]
    else:
        couple = 0.3 * weight * ALONG
        rotation = couple / (stiffness * 4.0 * (LEG**4 / 12.0 + LEG**2 * ALONG**2) - weight * high)
        more = stiffness * LEG**2 * ALONG * rotation
        loads = [0.25 * weight + sign * more for sign in (-1.0, -1.0, 1.0, 1.0)]
    still = Motion.from_samples(0.1, [0.0, 0.0])
    response = simulate(structure, still, release={"top": {"My": couple}}, settle=0.0)
    assert response.ry[0, 0] == pytest.approx(rotation, rel=2e-4)  # measured: 3e-9, 5e-5
    assert response.N[0] == pytest.approx(np.array(loads), abs=1e-6 * weight)  # measured: 3e-10, 1e-7
    one = Structure.from_dict({**data, "block": [table()]})  # all of its outline would bear
    assert len(one.joints) == 1
    assert simulate(one, still, release={"top": {"My": couple}}, settle=0.0).ry[0, 0] < 0.3 * rotation


@needs_trimesh
def test_the_feet_of_a_mesh_are_found(tmp_path: Path) -> None:
    """Check a table of five boxes: its bulk as of these, in closed form, far from its hull; four feet, or one around
    them.
    """
    trimesh = pytest.importorskip("trimesh")
    boxes = []
    for middle, size in PARTS:
        boxes.append(trimesh.creation.box(size))
        boxes[-1].apply_translation(np.add(middle, (3.0, -2.0, 0.0)))
    trimesh.util.concatenate(boxes).export(tmp_path / "table.stl")
    given = {"name": "table", "on": "base", "shape": "mesh", "file": str(tmp_path / "table.stl"), "density": 2700.0}
    structure = structure_of({**given, "feet": 4})
    block = structure.blocks[0]
    volume, centroid, inertia = bulk_of_boxes()
    assert block.volume == pytest.approx(volume, rel=1e-6)  # single precision of STL
    assert block.centroid == pytest.approx(centroid, abs=1e-6)
    assert block.inertia == pytest.approx(2700.0 * inertia, rel=1e-5, abs=1e-4)
    assert [joint.face.moments[0] for joint in structure.joints] == pytest.approx([LEG**2] * 4, rel=1e-5)
    middles = sorted(joint.face.centre[:2].round(4).tolist() for joint in structure.joints)
    assert middles == [[x, y] for x in (-ALONG, ALONG) for y in (-ACROSS, ACROSS)]
    again = Structure.from_dict(json.loads(json.dumps(structure.to_dict())))
    assert np.array_equal(again.model.numbers, structure.model.numbers)
    two, one = structure_of({**given, "feet": 2}), structure_of(given)
    assert [joint.face.moments[0] for joint in two.joints] == pytest.approx([LEG * 0.8] * 2, rel=1e-5)
    assert [joint.face.moments[0] for joint in one.joints] == pytest.approx([1.2 * 0.8], rel=1e-5)


@pytest.mark.parametrize(
    ("change", "line"),
    [
        ({"points": BOX[:3]}, "block[1].points: 3 points, must be"),
        ({"points": [[x, y, 0.0] for x, y, _ in BOX]}, "block[1].points: has no volume"),
        ({"points": [[0.0, 0.0]] * 4}, "block[1].points[0] = [0.0, 0.0]: must be a list of 3 numbers"),
        ({"points": np.concatenate([np.eye(3), -np.eye(3)]).tolist()}, "block[1].foot: stands on a point or an edge"),
        ({"foot": [[0.0, 0.0], [1.0, 1.0]]}, "block[1].foot: 2 points"),
        ({"foot": [*LEGS, [[0.0, 0.0], [1.0, 1.0]]]}, "block[1].foot[4]: 2 points"),
        ({"foot": [LEGS[0], LEGS[0]]}, "block[1].on: the contact of stone and base counts twice"),
        ({"foot": LEGS, "feet": 4}, "block[1].feet: must be left out beside foot"),
        ({"feet": 0}, "block[1].feet = 0: must be a whole number"),
        ({"feet": 2}, "block[1].feet = 2: the points within level of the lowest are not as many polygons"),
        ({"level": 2.0}, "block[1].level = 2.0: must be a share"),
        ({"scale": 0.0}, "block[1].scale = 0.0: must be a positive factor"),
        ({"volume": 1.0}, "block[1].volume: must be beside volume, centroid and inertia"),
        ({"faces": [[0, 1, 2]] * 4}, "block[1].faces: do not close"),
        ({"faces": [[0, 1, 7]] * 4}, "block[1].faces[0]: must be plane"),
        ({"faces": [[0, 9, 2]] * 4}, "block[1].faces: must be lists"),
        ({"file": "a.obj"}, "block[1].file: unknown key"),
        ({"shape": "mesh"}, "block[1].file = None: must be the name of a mesh"),
        ({"shape": "mesh", "file": "a.obj"}, "block[1].points: unknown key of a mesh"),
    ],
)
def test_wrong_hulls_are_refused_in_one_line(change: dict[str, Any], line: str) -> None:
    with pytest.raises(InputError) as caught:
        structure_of({**HULL, **change})
    assert str(caught.value).startswith(line)
    assert "\n" not in str(caught.value)


def test_what_is_written_needs_no_scipy(monkeypatch: pytest.MonkeyPatch) -> None:
    data = structure_of(HULL).to_dict()
    monkeypatch.setitem(sys.modules, "scipy.spatial", None)
    again = Structure.from_dict(json.loads(json.dumps(data)))
    assert again.to_dict() == data
    with pytest.raises(InputError, match="scipy is not installed: pip install"):
        structure_of(HULL)


def test_studies_vary_mass_and_scale() -> None:
    structure = structure_of(HULL)
    kind = structure.kind
    twice = kind.with_numbers(structure, {"block[stone].scale": (2.0, True)})
    assert twice.blocks[0].mass == pytest.approx(8.0 * structure.blocks[0].mass)
    assert twice.blocks[0].centroid == pytest.approx(2.0 * structure.blocks[0].centroid)
    assert twice.blocks[0].inertia == pytest.approx(32.0 * structure.blocks[0].inertia)
    sized = kind.with_numbers(structure, {"structure.size": (2.0, False)})
    assert sized.blocks[0].mass == twice.blocks[0].mass
    heavy = kind.with_numbers(structure, {"block[stone].mass": (5e3, False)})
    assert heavy.blocks[0].mass == 5e3
    for name in ("block[stone].points", "block[stone].foot[1]", "block[stone].level", "block[stone].volume"):
        with pytest.raises(InputError, match="no study varies it, must be mass"):
            kind.with_numbers(structure, {name: (1.0, False)})


@pytest.mark.long  # takes 10 s and more
def test_two_stones_of_many_corners_are_compared_in_little_time() -> None:
    """Compare two round stones that no joint connects, one moved into the other."""
    points = (sphere(2000) * [0.5, 0.4, 0.6]).tolist()
    foot = [[-0.1, -0.1], [0.1, -0.1], [0.1, 0.1], [-0.1, 0.1]]
    stones = [{**HULL, "name": f"stone{k}", "points": points, "foot": foot, "at": [1.1 * k, 0.0]} for k in range(2)]
    structure = structure_of(*stones)
    assert len(structure.blocks[0].faces) < 800
    response = simulate(structure, Motion.harmonic(0.5, 1.5, 0.5), settle=0.0)
    response.rows[:, 0] += np.where(np.arange(len(response.rows)) == 7, 0.3, 0.0)
    found = deepest_overlap(structure, response.time, response)
    assert found.between == ("stone0", "stone1")
    assert found.depth == pytest.approx(0.2, abs=0.01)


# meshes


def stacked(*boxes: tuple[float, float, float, float]) -> Any:
    """Return a mesh of boxes one on the other, each (width, depth, from, to), not joined: as many closed parts."""
    trimesh = pytest.importorskip("trimesh")
    parts = []
    for width, depth, low, high in boxes:
        part = trimesh.creation.box((width, depth, high - low))
        part.apply_translation([0.2, 0.0, 0.5 * (low + high)])
        parts.append(part)
    return trimesh.util.concatenate(parts)


@needs_trimesh
@pytest.mark.parametrize("kind", ["obj", "stl", "glb", "ply"])
def test_files_of_all_kinds_are_one_block(tmp_path: Path, kind: str) -> None:
    """Read a slab of 1 x 0.6 x 0.2 under a shaft of 0.4 x 0.4 x 1.6, in mm: its own mass, contacts of its hull."""
    mesh = stacked((1.0, 0.6, 0.0, 0.2), (0.4, 0.4, 0.2, 1.8))
    mesh.apply_scale(1e3)
    mesh.export(tmp_path / f"stone.{kind}")
    (tmp_path / "stone.toml").write_text(
        'name = "a"\njoints = {stiffness = 1e9, damping = 1e-3}\n[[block]]\nshape = "mesh"\nunit = 1e-3\nup = "z"\n'
        f'file = "stone.{kind}"\non = "base"\ndensity = 1000.0\n',
        encoding="utf-8",
    )
    structure = Structure.from_toml(tmp_path / "stone.toml")
    block = structure.blocks[0]
    assert block.mass == pytest.approx(120.0 + 256.0, rel=1e-6)
    assert block.centroid == pytest.approx([0.0, 0.0, (12.0 + 256.0) / 376.0], abs=1e-6)
    assert structure.joints[0].face.moments[0] == pytest.approx(0.6, rel=1e-6)
    assert len(block.faces) == 10  # foot, top, four sides of the slab, four that lean
    assert len(block.surface) == 24


@needs_trimesh
def test_y_is_up_in_gltf(tmp_path: Path) -> None:
    """Check that y becomes z and x stays, as in the glTF files that responses are written to."""
    trimesh = pytest.importorskip("trimesh")
    trimesh.creation.box((1.0, 2.0, 0.6)).export(tmp_path / "stone.glb")
    block = structure_of({**MESH, "file": str(tmp_path / "stone.glb")}).blocks[0]
    assert np.ptp(block.corners, axis=0) == pytest.approx([1.0, 0.6, 2.0], rel=1e-6)


@needs_trimesh
def test_a_block_written_as_gltf_is_read_as_it_was(tmp_path: Path) -> None:
    foot = [[0.0, 0.0], [2.0, 0.0], [0.0, 0.7]]  # no symmetry: a turn or a mirror image would show
    prism = {"shape": "hull", "points": [[x, y, z] for x, y in foot for z in (0.0, 1.5)]}
    written = structure_of({**prism, "on": "base", "density": 2000.0})
    simulate(written, Motion.from_samples(0.01, np.zeros(3)), settle=0.0).to_gltf(tmp_path / "stone.glb")
    read = structure_of({**MESH, "file": str(tmp_path / "stone.glb")})
    found, given = (one.blocks[0].corners - one.blocks[0].centroid for one in (read, written))
    assert len(np.unique(np.round(found, 4), axis=0)) == 6
    assert np.max(np.min(np.linalg.norm(found[:, None] - given, axis=2), axis=1)) < 1e-6  # m, single precision


@needs_trimesh
@pytest.mark.parametrize(
    ("text", "line"),
    [
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n", "is not closed: 3 edges"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\nf 1 3 2\n", "has no volume"),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 2 3\nf 1 2 4\nf 1 4 3\nf 2 3 4\n", "has triangles that look inwards"),
        ("v 0 0 0\nv 1 0 0\n", "has no triangles"),
        ("", ""),
        (f"v 0 0 0.{'1' * 5000}x\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "cannot be read as a mesh: "),
    ],
)
def test_wrong_meshes_are_refused_in_one_line(tmp_path: Path, text: str, line: str) -> None:
    file = tmp_path / "stone.obj"
    file.write_text(text, encoding="utf-8")
    with pytest.raises(InputError) as caught:
        structure_of({**MESH, "file": str(file)})
    assert str(caught.value).startswith(f"block[1].file: {file}: {line}")
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 400


def test_a_mesh_that_is_not_there_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(InputError, match=r"^block\[1\].file: .*nothing.obj: No such file"):
        structure_of({**MESH, "file": str(tmp_path / "nothing.obj")})
    with pytest.raises(InputError, match=r"must end with one of .obj"):
        structure_of({**MESH, "file": "stone.dwg"})
    monkeypatch.setitem(sys.modules, "trimesh", None)
    with pytest.raises(InputError, match=r"trimesh is not installed: pip install .*\[mesh\]"):
        structure_of(MESH)


@needs_trimesh
def test_a_statue_alone_in_lanes_and_as_it_is_written() -> None:
    structure = Structure.from_toml(EXAMPLES / "statue-mesh.toml")
    statue = structure.blocks[1]
    assert statue.mass == pytest.approx(431.35, rel=1e-4)
    assert len(structure.joints[1].face.outline) == 4
    again = Structure.from_dict(json.loads(json.dumps(structure.to_dict())))
    assert np.array_equal(again.model.numbers, structure.model.numbers)
    strong = Motion.harmonic(4.5, 1.2, 2.0, direction=0.4)
    alone = simulate(structure, strong)
    table = simulate_many([structure, again], strong, keep=("verdict", "path"))
    assert list(table["path"]) == ["lanes", "lanes"]
    assert [*table["verdict"]] == [alone.verdict] * 2
    structure_picture(structure)
    structure_picture(again)


@needs_trimesh
def test_an_fmu_carries_numbers_and_no_file() -> None:
    body = read_body(EXAMPLES / "statue-mesh.toml")
    assert "statue.obj" not in body.text
    assert len(body.text) < 100_000
    again = body_of(body.text)
    assert again.text == body.text
    assert again.table() == body.table()


def test_the_mesh_of_the_example_is_that_of_its_script(tmp_path: Path) -> None:
    specification = importlib.util.spec_from_file_location("statue_mesh", EXAMPLES / "statue_mesh.py")
    assert specification is not None
    assert specification.loader is not None
    script = importlib.util.module_from_spec(specification)
    specification.loader.exec_module(script)
    script.write(tmp_path / "statue.obj")
    assert (tmp_path / "statue.obj").read_text(encoding="utf-8") == STATUE.read_text(encoding="utf-8")
    assert STATUE.stat().st_size < 100_000


def test_hulls_with_their_faces_are_left_as_they_are() -> None:
    data = {"name": "a", "joints": LAW, "block": [HULL]}
    known, surfaces = with_hulls(data)
    assert with_hulls(known)[0] == known
    assert not surfaces
