"""Meshes that are not convex, as convex parts: their volume and surface, what meets them and what passes by."""

from __future__ import annotations

import json
import sys
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from space.test_contact import STILL, follow
from support.fmus import ROOT

from multiblock import InputError, Structure, simulate
from solver.models.structure.blocks.faces import FloatArray
from solver.models.structure.blocks.hulls import bulk_of, convex_surface, hull_of
from solver.models.structure.hull_tables import solid_from_hull, with_hulls
from solver.models.structure.neighbours import restitution_of
from solver.models.structure.overlap import deepest_overlap
from solver.models.structure.run import SpatialState, begun

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("manifold3d")

FOOT, SHAFT = ((0.0, 0.0, 0.0), (1.0, 0.6, 0.3)), ((0.0, 0.0, 0.3), (0.4, 0.6, 1.7))  # m, two corners of each
ARM = ((0.7, 0.0, 0.3), (1.0, 0.6, 1.2))
ELL, CUP = (FOOT, SHAFT), (FOOT, SHAFT, ARM)
DENSITY = 2000.0
STONE: dict[str, Any] = {"name": "stone", "shape": "mesh", "density": DENSITY, "on": "base", "at": [0.5, 0.3]}
BOX: dict[str, Any] = {"width": 0.4, "depth": 0.5, "height": 0.4, "density": DENSITY}
DRUM: dict[str, Any] = {"shape": "drum", "diameter": 0.4, "height": 0.4, "density": DENSITY}


def solid(*boxes: Any, turn: FloatArray | None = None) -> Any:
    """Return one closed mesh of boxes that touch."""
    made = trimesh.boolean.union([trimesh.creation.box(bounds=box) for box in boxes])
    if turn is not None:
        made.apply_transform(turn)
    return made


def file_of(folder: Path, *boxes: Any, **more: Any) -> str:
    solid(*boxes, **more).export(folder / "stone.ply")
    return str(folder / "stone.ply")


def beside(stone: dict[str, Any], other: dict[str, Any], at: Any, *plinths: dict[str, Any], **law: Any) -> Structure:
    """Return both blocks on plinths or the base, without gravity, which they leave at once; at: middle of the other's
    foot.
    """
    plinth = {"name": "plinth", "on": "base", "at": list(at[:2]), "width": 0.3, "depth": 0.3, "height": at[2]}
    blocks = [stone, {**other, "name": "other", "on": "plinth", "at": list(at[:2])}]
    rest = [*plinths, {**plinth, "density": DENSITY}]
    joints = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}  # what is open bears nothing
    data = {"name": "a", "g": 0.0, "joints": joints, "block": [*rest, *blocks], "solver": {"tolerance": 1e-6}}
    if law:
        data["neighbours"] = {"reach": 2.0, "line_stiffness": 1e8, "stiffness": 1e8, "friction": 0.0, **law}
    return Structure.from_dict(data)


def thrown(made: Structure, velocity: Any, stop: float) -> Any:
    """Return the last two blocks high above their plinths, the last one thrown, m/s."""
    none = np.zeros((made.n, 3))
    up, speed = none.copy(), none.copy()
    up[-2:, 2], speed[-1] = 3.0, velocity
    stepper = begun(made, STILL, SpatialState(up, none, speed, none))[0]
    follow(stepper, stop)
    return stepper


def hits(stepper: Any) -> float:
    """Return the largest force of any pair, N."""
    return float(np.max(stepper.state.peaks[-6 - len(stepper.structure.neighbours) : -6]))


@pytest.mark.parametrize("boxes", [ELL, CUP], ids=["ell", "cup"])
@pytest.mark.parametrize("turned", [False, True])
def test_parts_are_the_mesh_and_their_faces_its_surface(tmp_path: Path, boxes: Any, turned: bool) -> None:
    turn = trimesh.transformations.rotation_matrix(0.7, [1.0, 2.0, 3.0])
    mesh = solid(*boxes, turn=turn if turned else None)
    mesh.export(tmp_path / "stone.ply")
    given = {**STONE, "file": str(tmp_path / "stone.ply")}
    tables = with_hulls({"block": [{**given, "parts": 8}, given]})[0]["block"]
    block, whole = (solid_from_hull("block", "stone", table, DENSITY, None, stands=False) for table in tables)
    assert len(block.parts) == len(boxes)
    corners = [np.concatenate([face.points() for face in part]) for part in block.parts]
    volume = sum(bulk_of(convex_surface(points)).volume for points in corners)
    assert volume == pytest.approx(float(mesh.volume), rel=1e-6)  # measured: 5e-8, single precision of the file
    assert sum(face.moments[0] for face in block.faces) == pytest.approx(float(mesh.area), rel=1e-6)  # measured: 4e-8
    assert (block.mass, block.volume) == (whole.mass, whole.volume)
    assert np.array_equal(block.inertia, whole.inertia)
    assert not whole.parts


def test_feet_bear_as_without_parts(tmp_path: Path) -> None:
    table = {"name": "stone", "shape": "mesh", "file": file_of(tmp_path, *CUP), "density": DENSITY, "on": "base"}
    data = {"name": "a", "joints": {"stiffness": 1e9, "damping": 1e-3}}
    parts, whole = (Structure.from_dict({**data, "block": [{**table, **more}]}) for more in ({"parts": 4}, {}))
    assert np.array_equal(parts.model.numbers, whole.model.numbers)
    assert len(parts.blocks[0].faces) == 16  # the foot, 3 to the sides of each part but one that is cut, tops


@pytest.mark.parametrize("shape", [BOX, DRUM], ids=["box", "drum"])
def test_what_flies_through_the_hollow_meets_the_hull_alone(tmp_path: Path, shape: dict[str, Any]) -> None:
    """Throw it along y, over the foot and beside the shaft: the hull is there, the stone is not."""
    file, at = file_of(tmp_path, *ELL), (0.65, 1.3, 0.4)
    for more, meets in (({}, True), ({"parts": 8}, False)):
        made = beside({**STONE, "file": file, **more}, shape, at, damping=0.0)
        stepper = thrown(made, (0.0, -2.0, 0.0), 1.0)
        assert (hits(stepper) > 1e4) == meets
        if not meets:
            assert stepper.see.vy[-2:].tolist() == [0.0, -2.0]
            assert stepper.see.uy[-1] == pytest.approx(-2.0, rel=1e-12)


@pytest.mark.parametrize("wanted", [0.9, 0.5])
def test_what_hits_the_shaft_in_line_with_the_centroid_parts_by_the_restitution(tmp_path: Path, wanted: float) -> None:
    stone = {**STONE, "file": file_of(tmp_path, *ELL), "parts": 8}
    x, y, z = beside(stone, BOX, (4, 0, 1)).blocks[-2].centroid
    assert (x, z) == pytest.approx((0.262 / 0.86, 0.605 / 0.86), rel=1e-6)  # of 0.3 m2 and 0.56 m2
    made = beside(stone, BOX, (1.3, y, z - 0.2), restitution=wanted)
    stepper = thrown(made, (-2.0, 0.0, 0.0), 0.8)
    after = stepper.see.vx[-2:]
    # two parts bear a little less than their common face as a whole: measured 6e-4 and 3.8e-3
    assert after[0] - after[1] == pytest.approx(-2.0 * wanted, rel=5e-3)
    one, other = (block.mass for block in made.blocks[-2:])
    assert one * after[0] + other * after[1] == pytest.approx(-2.0 * other, rel=1e-12)
    assert hits(stepper) > 1e4


def test_a_declared_gap_is_that_of_the_nearest_part(tmp_path: Path) -> None:
    """Declare 0.01 m between a drum and a mesh 0.1 m beside it, whose other part is 1.5 m away: that was hit then too.

    The distances of all parts change by the same length, as if the radius of the drum were another.
    """
    boxes = (((0.0, 0.0, 0.0), (0.4, 1.0, 2.0)), ((0.4, 0.0, 0.0), (1.4, 1.0, 0.2)), ((1.4, 0.0, 0.0), (1.8, 1.0, 2.0)))
    stone = {**STONE, "file": file_of(tmp_path, *boxes), "parts": 8, "at": [1.5, 0.0]}
    drum = {**DRUM, "name": "drum", "on": "base", "at": [0.0, 0.0], "diameter": 1.0, "height": 2.0}
    pair = {"between": ["drum", "stone"], "line_stiffness": 1e8, "stiffness": 1e8, "damping": 1e-3, "friction": 0.0}
    joints = {"stiffness": 1e9, "damping": 1e-3}
    data = {"name": "a", "joints": joints, "block": [drum, stone]}
    for gap, by in ((0.01, -0.09), (0.1, 0.0), (0.3, 0.2)):
        pairs = Structure.from_dict({**data, "neighbours": {"pair": [{**pair, "gap": gap}]}}).neighbours
        assert min(found.gap for found in pairs) == gap
        assert [found.farther for found in pairs] == pytest.approx([by] * len(pairs), abs=1e-6)  # float32 in the file
        assert max(found.gap for found in pairs) == pytest.approx(1.5 + by, abs=1e-6)


def test_parts_that_meet_at_once_have_one_restitution(tmp_path: Path) -> None:
    """Check a flat side of two parts: each was damped for the whole mass, and 0.35 came where 0.5 was asked for."""
    stone = {**STONE, "file": file_of(tmp_path, *ELL), "parts": 8}
    made = beside(stone, {**BOX, "height": 1.5}, (-0.5, 0.3, 0.1), restitution=0.5)
    pairs = [pair for pair, name in zip(made.neighbours, made.contact_names, strict=True) if "stone-other" in name]
    assert len(pairs) == 2
    mass = 1.0 / sum(1.0 / block.mass for block in made.blocks[-2:])
    stiffness = 1e8 * sum(pair.size for pair in pairs)
    for pair in pairs:
        assert restitution_of(pair.damping, mass, stiffness) == pytest.approx(0.5, rel=1e-9)
        assert restitution_of(pair.damping, mass, 1e8 * pair.size) > 0.51


def test_each_part_that_meets_has_columns_of_its_own(tmp_path: Path) -> None:
    """Check that the names differ and stand over their columns, and that the impact is that of both bodies."""
    stone = {**STONE, "file": file_of(tmp_path, *ELL), "parts": 8}
    made = beside(stone, BOX, (1.3, 0.3, 0.4), restitution=0.5)
    assert [name for name in made.contact_names if "other" in name and "stone" in name] == [
        "stone-other.1",
        "stone-other.2",
    ]
    assert len(set(made.contact_names)) == len(made.neighbours)
    none, speed = np.zeros((3, 3)), np.zeros((3, 3))
    speed[2, 0] = -2.0
    found = simulate(made, STILL, initial=SpatialState(none, none, speed, none), settle=0.0)
    found.to_csv(tmp_path / "run.csv")
    with open(tmp_path / "run.csv", encoding="utf-8") as file:
        head = file.readline().strip().split(",")
        rows = np.loadtxt(file, delimiter=",")
    assert len(set(head)) == len(head)
    for k, name in enumerate(made.contact_names):
        assert rows[:, head.index(f"contact[{name}].gap")] == pytest.approx(found.gap[:, k], rel=1e-6)
    (hit,) = (one for one in found.impacts if one.between == "stone-other")
    assert hit.force == np.max(found.peaks["hit"]) > 1e4


def test_the_shaft_is_hit_as_if_it_were_alone(tmp_path: Path) -> None:
    """Hit it off its centroid, as a convex block of the shaft alone with the bulk of all."""
    stone = {**STONE, "file": file_of(tmp_path, *ELL), "parts": 8}
    table = beside(stone, BOX, (4, 0, 1)).to_dict()["block"][-2]
    points = [[x, y, z] for x in (0.0, 0.4) for y in (0.0, 0.6) for z in (0.3, 1.7)]
    bulk = {key: table[key] for key in ("volume", "centroid", "inertia")}
    alone = {**bulk, "name": "stone", "shape": "hull", "points": points, "density": DENSITY}
    alone |= {"on": "low", "at": [0.2, 0.3]}
    low = {"name": "low", "on": "base", "at": [0.2, 0.3], "width": 0.4, "depth": 0.6, "height": 0.3, "density": DENSITY}
    ends = []
    for one, *plinths in ((stone,), (alone, low)):
        made = beside(one, BOX, (1.3, 0.2, 0.8), *plinths, damping=0.01)
        stepper = thrown(made, (-2.0, 0.3, 0.2), 0.6)
        assert hits(stepper) > 1e4
        see = stepper.see
        ends.append(np.array([see.vx, see.vy, see.vz, see.wx, see.wy, see.wz])[:, -2:])
    assert np.max(np.abs(ends[0] - ends[1])) < 1e-5  # m/s and rad/s; measured: 2e-7


def test_what_overlaps_a_hull_may_be_beside_the_stone(tmp_path: Path) -> None:
    file, still = file_of(tmp_path, *ELL), np.zeros((2, 3, 3))
    made = beside({**STONE, "file": file, "parts": 8}, BOX, (1.5, 0.3, 0.35))
    hull = beside({**STONE, "file": file}, BOX, (1.5, 0.3, 0.35))

    def depth(structure: Structure, moved: float) -> float:
        rows: Any = type("Rows", (), {"ux": np.array([[0, 0, 0], [0, 0, moved]]), "rotation": still})
        rows.uy = rows.uz = np.zeros((2, 3))
        return deepest_overlap(structure, np.arange(2.0), rows).depth

    assert depth(made, -0.85) == 0.0
    assert depth(hull, -0.85) > 0.1
    assert depth(made, -0.95) == pytest.approx(0.05, abs=1e-6)  # it stands 0.9 m from the shaft


@pytest.mark.parametrize("scale", [1.0, 1e-1, 1e-3])
def test_an_overlap_of_small_blocks_is_reported(scale: float) -> None:
    """Check boxes of 0.5 m and of 0.5 mm, 0.02 of it apart, that pass into each other by 0.05 of their width."""
    box = {"on": "base", "width": 0.5 * scale, "depth": 0.5 * scale, "height": 0.5 * scale, "density": 2500.0}
    places = {"a": [0.0, 0.0], "b": [0.52 * scale, 0.0]}
    blocks = [{**box, "name": name, "at": at} for name, at in places.items()]
    structure = Structure.from_dict(
        {"name": "two", "joints": {"stiffness": 1e9 / scale, "damping": 0.0}, "block": blocks}
    )
    rows: Any = type("Rows", (), {"ux": np.array([[0.0, 0.0], [0.045 * scale, 0.0]]), "rotation": np.zeros((2, 2, 3))})
    rows.uy = rows.uz = np.zeros((2, 2))
    found = deepest_overlap(structure, np.arange(2.0), rows)
    assert found.depth == pytest.approx(0.025 * scale, rel=1e-6)
    assert found.between == ("a", "b")


@pytest.mark.long  # takes 10 s and more
def test_a_statue_lies_within_its_parts_and_is_the_same_again(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check 8 parts: 1.069 of its volume, where its hull has 1.91."""
    statue = str(ROOT / "examples" / "structures" / "statue.obj")
    table = {**STONE, "file": statue, "parts": 8}
    made = beside(table, BOX, (4, 0, 1))
    block = made.blocks[-2]
    assert len(block.parts) == 8
    corners = [np.concatenate([face.points() for face in part]) for part in block.parts]
    volume = sum(bulk_of(hull_of(convex_surface(points)).triangles).volume for points in corners)
    assert volume == pytest.approx(1.069 * block.volume, rel=2e-3)
    points = block.surface.reshape(-1, 3)
    outside = [np.max([(points - face.centre) @ face.normal for face in part], axis=0) for part in block.parts]
    assert np.max(np.min(outside, axis=0)) < 0.02  # m, of 1.9; measured: 0.011, of a part of more than 100 corners
    assert np.array_equal(beside(table, BOX, (4, 0, 1)).model.numbers, made.model.numbers)
    data = json.loads(json.dumps(made.to_dict()))
    monkeypatch.setitem(sys.modules, "manifold3d", None)
    again = Structure.from_dict(data)
    assert again.to_dict() == data
    assert np.array_equal(again.model.numbers, made.model.numbers)
    assert [len(part) for part in again.blocks[-2].parts] == [len(part) for part in block.parts]
    with pytest.raises(InputError, match=r"manifold3d is not installed: pip install .*\[mesh\]"):
        beside(table, BOX, (4, 0, 1))


def test_wrong_parts_are_refused_in_one_line(tmp_path: Path) -> None:
    file = file_of(tmp_path, *ELL)
    for value in (0, 65, True, "8"):
        with pytest.raises(InputError, match=r"block\[2\].parts = .*: must be a whole number, 1 to 64"):
            beside({**STONE, "file": file, "parts": value}, BOX, (4, 0, 1))
    trimesh.util.concatenate([trimesh.creation.box(bounds=box) for box in CUP]).export(tmp_path / "three.stl")
    with pytest.raises(InputError, match=r"block\[2\].parts = 2: .*three.stl: is 3 solids that do not touch, must be"):
        beside({**STONE, "file": str(tmp_path / "three.stl"), "parts": 2}, BOX, (4, 0, 1))
    made = beside({**STONE, "file": file, "parts": 8}, BOX, (4, 0, 1)).to_dict()
    made["block"][-2]["parts"] = [6, 5]
    with pytest.raises(InputError, match=r"block\[2\].parts = \[6, 5\]: must be how many of the faces each part has"):
        Structure.from_dict(made)
