"""Meshes as they are exported: noise, several shells, wrong winding, files that they name, hollows."""

from __future__ import annotations

import json
import os
import sys
import warnings
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from multiblock import InputError, InputWarning, Motion, Structure, simulate
from multiblock.__main__ import main
from solver.models.structure.blocks.hulls import checked, convex_surface, hull_of
from solver.models.structure.stepper import SpatialStepper

trimesh = pytest.importorskip("trimesh")
pytest.importorskip("manifold3d")

DENSITY = 2000.0
TETRAHEDRON = "v 0 0 0\nv 3 0 0\nv 0 3 0\nv 0 0 3\n"
OUTWARDS = "f 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n"


def box(*bounds: tuple[float, float, float]) -> Any:
    return trimesh.creation.box(bounds=bounds)


def inverted(mesh: Any) -> Any:
    made = mesh.copy()
    made.invert()
    return made


def read(file: Path, **more: Any) -> Any:
    """Return the block of a mesh."""
    table = {"name": "a", "on": "base", "shape": "mesh", "file": str(file), "density": DENSITY, **more}
    law = {"stiffness": 1e9, "damping": 1e-3}
    return Structure.from_dict({"name": "m", "joints": law, "block": [table]}).blocks[0]


def written(folder: Path, *meshes: Any, kind: str = "obj") -> Path:
    file = folder / f"stone.{kind}"
    trimesh.util.concatenate(meshes).export(file)
    return file


@pytest.mark.parametrize("noise", [1e-6, 5e-6, 2e-5, 1e-3])
@pytest.mark.parametrize("seed", range(8))
def test_flat_sides_with_noise_are_the_hull_of_a_closed_solid(noise: float, seed: int) -> None:
    """Check a slab of 1.5 x 0.5 x 0.3 m, each side of 32 triangles: volume within twice the noise times its surface."""
    mesh = box((0, 0, 0), (1.5, 0.5, 0.3)).subdivide().subdivide()
    rng = np.random.default_rng(seed)
    hull = hull_of(convex_surface(mesh.vertices + rng.uniform(-noise, noise, mesh.vertices.shape)))
    assert checked(hull.points, hull.faces).faces == hull.faces
    a, b, c = np.moveaxis(hull.triangles, 1, 0)
    volume = float(np.einsum("ij,ij->", a, np.cross(b, c))) / 6.0
    assert abs(volume - 0.225) < 2.0 * noise * 2.7 + 1e-4 * 1.5 * 2.7
    if noise < 1e-5:
        assert len(hull.faces) == 6


def test_a_mesh_with_noise_is_read(tmp_path: Path) -> None:
    mesh = box((0, 0, 0), (0.5, 0.7, 2.0)).subdivide().subdivide().subdivide()
    for seed in range(6):
        mesh.vertices = mesh.vertices + np.random.default_rng(seed).normal(0.0, 6e-6, mesh.vertices.shape)
        block = read(written(tmp_path, mesh))
        assert block.mass == pytest.approx(0.7 * DENSITY, rel=1e-4)
        assert np.ptp(block.corners, axis=0) == pytest.approx([0.5, 0.7, 2.0], abs=2e-4)


ROOM = ((0.2, 0.2, 0.2), (0.8, 0.8, 1.8))
OUTER = ((0, 0, 0), (1, 1, 2))
SHELLS: dict[str, tuple[list[Any], float | str]] = {  # with the volume, or what is said
    "a repeated box": ([box(*OUTER), box(*OUTER)], "would count 2 times"),
    "three times": ([box(*OUTER)] * 3, "would count 3 times"),
    "an arm that sticks into a body": ([box(*OUTER), box((0.5, 0.2, 0.5), (1.6, 0.8, 1.0))], "would count 2 times"),
    "an inner shell that looks outwards": ([box(*OUTER), box(*ROOM)], "would count 2 times"),
    "a void": ([box(*OUTER), inverted(box(*ROOM))], 2.0 - 0.36 * 1.6),
    "a kernel in a void": ([box(*OUTER), inverted(box(*ROOM)), box((0.4, 0.4, 0.4), (0.6, 0.6, 0.6))], 1.432),
    "a void beside the solid": ([box(*OUTER), inverted(box((2, 0, 0), (2.5, 1, 1)))], "lies in no solid"),
    "a box on a larger one": ([box(*OUTER), box((0.2, 0.3, 2), (0.7, 0.8, 3))], 2.25),
    "a box on an equal one": ([box(*OUTER), box((0, 0, 2), (1, 1, 4))], 4.0),
    "a cross of bars": ([box((0, 1, 0), (3, 2, 1)), box((1, 0, 1), (2, 3, 2))], 6.0),
    "an overlap by rounding": ([box(*OUTER), box((0.2, 0.3, 1.99999), (0.7, 0.8, 3))], 2.25),
}


@pytest.mark.parametrize("kind", ["obj", "stl"])
@pytest.mark.parametrize("case", SHELLS)
def test_shells_count_once(tmp_path: Path, case: str, kind: str) -> None:
    meshes, truth = SHELLS[case]
    file = written(tmp_path, *meshes, kind=kind)
    for more in ({}, {"parts": 8}):
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", InputWarning)
            if isinstance(truth, str):
                with pytest.raises(InputError, match=rf"^block\[1\].file: .*stone.{kind}: .*{truth}"):
                    read(file, **more)
            else:
                assert read(file, **more).mass == pytest.approx(truth * DENSITY, rel=1e-5)


@pytest.mark.parametrize(
    ("meshes", "count"),
    [
        ([box(*OUTER), box((3, 0, 0), (4, 1, 2))], 2),
        ([box(*OUTER), box((3, 0, 0), (4, 1, 2)), box((0, 0, 2), (1, 1, 3))], 2),
        ([box((0, 1, 0), (3, 2, 1)), box((1, 0, 1), (2, 3, 2))], 1),  # a cross: no corner on the other bar
        ([box(*OUTER), inverted(box(*ROOM))], 1),
    ],
)
def test_solids_that_do_not_touch_are_said(tmp_path: Path, meshes: list[Any], count: int) -> None:
    file = written(tmp_path, *meshes)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        read(file)
    said = [f"{file}: {count} solids that do not touch, taken as one rigid block"] if count > 1 else []
    assert [str(one.message) for one in caught if ".foot: " not in str(one.message)] == said


def test_a_foot_that_is_hollow_is_said(tmp_path: Path) -> None:
    """Check that the foot of a ring is the disc around it; feet that are given, or a full foot, are not warned of."""
    ring = written(tmp_path, trimesh.creation.annulus(0.3, 0.5, 0.6))
    with pytest.warns(InputWarning, match=r"block\[1\].foot: .*outline of 0.78 m2, the mesh has 0.499 m2 there"):
        read(ring)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        read(ring, foot=[[0.2, 0.0], [0.0, 0.2], [-0.2, 0.0], [0.0, -0.2]])
        read(written(tmp_path, box(*OUTER)))


def test_a_mesh_in_mm_is_said_in_python(tmp_path: Path) -> None:
    file = written(tmp_path, box((0, 0, 0), (500, 400, 1800)))
    with pytest.warns(InputWarning, match=r"stone.obj: 1800 m high: a mesh in mm needs unit = 1e-3"):
        read(file)
    assert read(file, unit=1e-3).mass == pytest.approx(0.36 * DENSITY)


def test_a_mesh_in_mm_that_is_scaled_is_not_said(tmp_path: Path) -> None:
    file = written(tmp_path, box((0, 0, 0), (500, 400, 1800)))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert read(file, scale=1e-3).mass == pytest.approx(0.36 * DENSITY)
    with pytest.warns(InputWarning, match=r"stone.obj: 180 m high"):
        read(file, scale=0.1)


def test_a_mesh_far_from_the_origin_is_refused_by_its_file(tmp_path: Path) -> None:
    file = written(tmp_path, box((5e5, 4649776.0, 312.0), (500001.0, 4649777.0, 314.0)))
    said = r"^block\[1\].file: .*stone.obj: coordinates reach 4.65e\+06 m, must be at most 1e\+06 m: shift them near"
    with pytest.raises(InputError, match=said):
        read(file)


def test_wrong_winding_is_repaired(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check a box of 192 triangles, of which some look inwards; of a hollow box the inner shell looks outwards."""
    whole = box(*OUTER).subdivide().subdivide()
    faces = np.array(whole.faces)
    wrong = np.random.default_rng(3).random(len(faces)) < 0.2
    faces[wrong] = faces[wrong][:, ::-1]
    trimesh.Trimesh(whole.vertices, faces, process=False).export(tmp_path / "box.off")
    with pytest.raises(InputError, match=r"look inwards beside others .*: repair = true \(--repair\) turns triangles$"):
        read(tmp_path / "box.off")
    with pytest.warns(InputWarning, match=rf"box.off: {np.sum(wrong)} of 192 triangles turned"):
        assert read(tmp_path / "box.off", repair=True).mass == pytest.approx(2.0 * DENSITY)
    file = written(tmp_path, box(*OUTER), box(*ROOM))
    path = tmp_path / "hollow.toml"
    assert main(["new", "--mesh", str(file), "-o", str(path)]) == 2
    assert "--repair" in capsys.readouterr().err
    assert main(["new", "--mesh", str(file), "--repair", "-o", str(path)]) == 0
    assert capsys.readouterr().err.count("12 of 24 triangles turned") == 1
    with pytest.warns(InputWarning, match="12 of 24 triangles turned"):
        assert Structure.from_toml(path).blocks[0].volume == pytest.approx(1.424)
    with pytest.raises(InputError, match=r"block\[1\].repair = 1: must be true or false"):
        read(file, repair=1)


def gltf(folder: Path, uri: str) -> Path:
    """Return a tetrahedron whose numbers lie in a file of another name."""
    points = np.array([[0, 0, 0], [3, 0, 0], [0, 3, 0], [0, 0, 3]], dtype="<f4").tobytes()
    corners = np.array([0, 2, 1, 0, 1, 3, 1, 2, 3, 2, 0, 3], dtype=np.uint8).tobytes()
    views = [{"buffer": 0, "byteLength": 48}, {"buffer": 0, "byteOffset": 48, "byteLength": 12}]
    primitive = {"attributes": {"POSITION": 0}, "indices": 1}
    (folder / "stone.gltf").write_text(
        json.dumps(
            {
                "asset": {"version": "2.0"},
                "scene": 0,
                "scenes": [{"nodes": [0]}],
                "nodes": [{"mesh": 0}],
                "meshes": [{"primitives": [primitive]}],
                "buffers": [{"uri": uri, "byteLength": 60}],
                "bufferViews": views,
                "accessors": [
                    {"bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3"},
                    {"bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR"},
                ],
            }
        )
    )
    (folder / "data").mkdir(exist_ok=True)
    (folder / "data" / "a b.bin").write_bytes(points + corners)
    return folder / "stone.gltf"


@pytest.mark.parametrize("uri", ["data/a b.bin", "data/a%20b.bin"])
def test_buffers_beside_a_mesh_are_read(tmp_path: Path, uri: str) -> None:
    assert read(gltf(tmp_path, uri), position=[0, 0, 0]).mass == pytest.approx(4.5 * DENSITY)


@pytest.mark.parametrize(
    ("uri", "said"),
    [
        ("nothing.bin", "needs nothing.bin beside it, which is not there"),
        ("../outside.bin", "needs ../outside.bin, must be a file in its own folder, or in one below it"),
        ("link.bin", "needs link.bin, must be a file in its own folder, or in one below it"),
        ("/dev/zero", "needs /dev/zero, must be a file in its own folder, or in one below it"),
        ("pipe", "pipe: is a pipe or a device, must be an ordinary file"),
        ("large.bin", "large.bin: has 300 MB, must have at most 200 MB"),
    ],
)
@pytest.mark.skipif(os.name == "nt", reason="has no pipes with names")
def test_files_that_a_mesh_names_are_ordinary_ones_in_its_folder(tmp_path: Path, uri: str, said: str) -> None:
    folder = tmp_path / "stones"
    folder.mkdir()
    file = gltf(folder, uri)
    (tmp_path / "outside.bin").write_bytes((folder / "data" / "a b.bin").read_bytes())
    (folder / "link.bin").symlink_to(tmp_path / "outside.bin")
    os.mkfifo(folder / "pipe")
    with open(folder / "large.bin", "wb") as large:
        large.truncate(300 * 10**6)
    with pytest.raises(InputError) as caught:
        read(file)
    assert str(caught.value) == f"block[1].file: {file}: {said}"


@pytest.mark.skipif(os.name == "nt", reason="has no pipes with names")
@pytest.mark.parametrize("kind", ["obj", "ply", "gltf"])
def test_materials_are_not_read(tmp_path: Path, capfd: pytest.CaptureFixture[str], kind: str) -> None:
    """Check that a file of colours may be missing, or a pipe: nothing is said of it."""
    os.mkfifo(tmp_path / "pipe")
    file = tmp_path / f"stone.{kind}"
    for name in ("pipe", "nothing.jpg"):
        if kind == "obj":
            file.write_text(f"mtllib {name}\nusemtl a\n{TETRAHEDRON}{OUTWARDS}")
        elif kind == "ply":
            trimesh.creation.box((1, 1, 9)).export(file, encoding="ascii")
            file.write_text(file.read_text().replace("element", f"comment TextureFile {name}\nelement", 1))
        else:
            table = json.loads(gltf(tmp_path, "data/a b.bin").read_text())
            texture = {"pbrMetallicRoughness": {"baseColorTexture": {"index": 0}}}
            table |= {"images": [{"uri": name}], "textures": [{"source": 0}], "materials": [texture]}
            table["meshes"][0]["primitives"][0]["material"] = 0
            file.write_text(json.dumps(table))
        assert read(file).mass == pytest.approx((9.0 if kind == "ply" else 4.5) * DENSITY)
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize("hole", ["round", "square"])
def test_a_ring_has_parts_around_its_hole(tmp_path: Path, hole: str) -> None:
    """Check that its hull holds the hole; 16 convex parts of it hold less than 5 % of that beside the ring."""
    if hole == "round":
        ring = trimesh.creation.annulus(0.4, 0.6, 0.5)
    else:
        ring = trimesh.boolean.difference([box((-1, -1, 0), (1, 1, 1)), box((-0.5, -0.5, -1), (0.5, 0.5, 2))])
    block = read(written(tmp_path, ring), parts=16)
    assert len(block.parts) > 1
    volume = 0.0
    for part in block.parts:
        volume += trimesh.convex.convex_hull(np.concatenate([face.points() for face in part])).volume
    assert volume - ring.volume < 0.05 * (ring.convex_hull.volume - ring.volume)


def test_parts_that_do_not_help_are_said(tmp_path: Path) -> None:
    ring = written(tmp_path, trimesh.creation.annulus(0.4, 0.6, 0.5))
    with pytest.warns(InputWarning, match=r"block\[1\].parts = 2: .*: no parts hold less than its hull.*: 1.8 t"):
        read(ring, parts=2)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert not read(written(tmp_path, box(*OUTER)), parts=4).parts


@pytest.mark.parametrize("depth", [0.1, 1e-6])
def test_faces_that_are_no_convex_polygons_are_refused(depth: float) -> None:
    """Refuse a slab whose sides across y have a bottom edge like a saw; its other faces are those of the hull."""
    side = [[0.0, 0.0], *[[k / 10, depth * (k % 2)] for k in range(1, 10)], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]]
    count = len(side)
    points = [[x, y, z] for y in (0.0, 1.0) for x, z in side]
    last = count - 3
    faces = [
        list(range(count)),
        list(range(2 * count - 1, count - 1, -1)),
        [0, count, count + last, last],
        [last, count + last, count + last + 1, last + 1],
        [last + 1, count + last + 1, count + last + 2, last + 2],
        [last + 2, 2 * count - 1, count, 0],
    ]
    table = {"name": "a", "shape": "hull", "points": points, "faces": faces, "position": [0, 0, 0], "density": 1.0}
    law = {"stiffness": 1e9, "damping": 1e-3}
    data = {"name": "m", "joints": law, "block": [{**table, "foot": [[0, 0], [1, 0], [1, 1]]}]}
    with pytest.raises(InputError, match=r"^block\[1\].faces\[0\]: must be a convex polygon, its corners"):
        Structure.from_dict(data)


def test_a_prism_has_no_corners_on_straight_sides() -> None:
    """Check that a bottom of 90 corners that zigzags by 8e-12 m is the straight side that its ends have; by 1 um it is
    refused.
    """

    def outline(depth: float) -> list[list[float]]:
        return [[k / 90, depth * (k % 2)] for k in range(91)] + [[1.0, 1.0], [0.0, 1.0]]

    table = {"name": "a", "shape": "prism", "depth": 1.0, "density": DENSITY, "on": "base"}
    data: dict[str, Any] = {"name": "m", "joints": {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}}
    made = Structure.from_dict({**data, "block": [{**table, "outline": outline(8e-12)}]})
    assert len(made.blocks[0].faces) == 6
    assert made.blocks[0].mass == pytest.approx(DENSITY, rel=1e-9)
    with pytest.raises(InputError, match="outline: is not convex"):
        Structure.from_dict({**data, "block": [{**table, "outline": outline(1e-6)}]})


def test_meshes_need_no_trimesh_once_they_are_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = written(tmp_path, box(*OUTER))
    table = {"name": "a", "on": "base", "shape": "mesh", "file": str(file), "density": DENSITY, "repair": True}
    law = {"stiffness": 1e9, "damping": 1e-3}
    made = Structure.from_dict({"name": "m", "joints": law, "block": [table]}).to_dict()
    assert "repair" not in made["block"][0]
    monkeypatch.setitem(sys.modules, "trimesh", None)
    assert Structure.from_dict(made).to_dict() == made


def test_contacts_without_room_are_said(monkeypatch: pytest.MonkeyPatch) -> None:
    law = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.5}
    block = {"name": "a", "on": "base", "width": 1.0, "depth": 1.0, "height": 1.0, "mass": 1e3}
    structure = Structure.from_dict({"name": "m", "joints": law, "block": [block]})
    shaking = Motion.harmonic(6.0, 1.0, 0.2)
    assert simulate(structure, shaking, 0.2).stats["without_room"] == 0
    monkeypatch.setattr(SpatialStepper, "without_room", 3)
    with pytest.warns(InputWarning, match=r"^m: 3 times a contact had no room for all its corners and bore nothing"):
        assert simulate(structure, shaking, 0.2).stats["without_room"] == 3
