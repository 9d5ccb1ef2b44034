"""Files for ParaView: meshio reads blocks where the response has them, and pressures that are its own."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.etree import ElementTree

import meshio
import numpy as np
import pytest
from support.fmus import ROOT

from multiblock import Structure, wavelets
from solver import Column, InputError, Motion, simulate
from solver.commands.command_line import main

SHAKING = Motion.harmonic(2.0, 2.0, 0.8)
FPS = 10.0


def series(folder: Path, name: str) -> Iterator[tuple[float, Any]]:
    for data in ElementTree.parse(folder / f"{name}.pvd").iter("DataSet"):
        yield float(data.attrib["timestep"]), meshio.read(folder / data.attrib["file"])


def largest(mesh: Any, count: int) -> Any:
    """Return the largest pressure of each joint, Pa."""
    found = np.zeros(count)
    for cells, joints in zip(mesh.cells, mesh.cell_data["joint"], strict=True):
        np.maximum.at(found, joints - 1, mesh.point_data["pressure"][cells.data].max(axis=1))
    return found


def test_blocks_of_a_structure_are_where_they_move_to(tmp_path: Path) -> None:
    structure = Structure.from_toml(ROOT / "examples" / "structures" / "podium.toml")
    response = simulate(structure, SHAKING, check=False, settle=0.0)
    response.to_vtk(tmp_path / "out", fps=FPS)
    seen = list(series(tmp_path / "out", "blocks"))
    assert len(seen) == 9
    for t, mesh in seen[::4]:
        k = int(np.argmin(np.abs(response.time - t)))
        assert response.time[k] == pytest.approx(t, abs=1e-9)
        owners = mesh.cell_data["block"][0]
        for i, block in enumerate(structure.blocks):
            points = mesh.points[np.unique(mesh.cells[0].data[owners == i + 1])]
            assert mesh.cell_data["ux"][0][owners == i + 1] == pytest.approx(response.ux[k, i])
            for corner in block.corners:
                place = corner + response.displacement(i, block.axes.T @ (corner - block.centroid))[k]
                assert np.min(np.linalg.norm(points - place, axis=1)) < 1e-9


def test_pressures_are_those_of_the_response(tmp_path: Path) -> None:
    """Compare undamped, else the response has the part of damping too: 1.5e-12 of the largest was measured."""
    block = {"height": 4.69, "width": 1.56, "depth": 1.56, "mass": 27000.0, "repeat": 3}
    column = Column.from_dict({"name": "undamped", "joint": {"stiffness": 5.2e9, "damping": 0.0}, "block": [block]})
    response = simulate(column, SHAKING, check=False, settle=0.0)
    response.to_vtk(tmp_path, fps=FPS)
    opened = 0
    for t, mesh in series(tmp_path, "joints"):
        k = int(np.argmin(np.abs(response.time - t)))
        opened += np.min(response.contact[k]) < 0.5
        assert largest(mesh, 3) == pytest.approx(response.sigma_max[k], abs=1e-9 * response.peaks["sigma_max"].max())
    assert opened > 1


def test_a_ring_at_rest_bears_its_weight(tmp_path: Path) -> None:
    block = {"name": "ring", "shape": "drum", "diameter": 1.0, "bore": 0.4, "height": 1.0, "mass": 2000.0, "on": "base"}
    law = {"stiffness": 1e9, "damping": 1e-3}
    structure = Structure.from_dict({"name": "ring", "joints": law, "block": [block]})
    response = simulate(structure, Motion.harmonic(0.0, 1.0, 0.1), check=False, settle=0.0)
    response.to_vtk(tmp_path)
    _, mesh = next(series(tmp_path, "joints"))
    area = 0.25 * np.pi * (1.0 - 0.4**2)
    assert mesh.point_data["pressure"] == pytest.approx(2000.0 * structure.g / area, rel=1e-6)
    assert len(mesh.cells[0].data) > 8  # the hole stays open


SLIDING = {"stiffness": 2e9, "damping": 1e-3, "friction": 0.15}


def forces(mesh: Any, count: int) -> Any:
    """Integrate the pressure over the polygons of each joint by triangles: N."""
    found = np.zeros(count)
    for cells, joints in zip(mesh.cells, mesh.cell_data["joint"], strict=True):
        for corners, joint in zip(cells.data, joints, strict=True):
            first, second, third = corners[0], corners[1:-1], corners[2:]
            sides = mesh.points[second] - mesh.points[first], mesh.points[third] - mesh.points[first]
            areas = 0.5 * np.linalg.norm(np.cross(*sides), axis=1)
            pressure = mesh.point_data["pressure"]
            found[joint - 1] += areas @ (pressure[first] + pressure[second] + pressure[third]) / 3.0
    return found


def check_forces(response: Any, folder: Path, error: float) -> None:
    """Check the pressure of the last row, at rest: each joint bears the weight above it."""
    response.to_vtk(folder, fps=1.0)
    *_, (_, mesh) = series(folder, "joints")
    count = response.N.shape[1]
    assert forces(mesh, count) == pytest.approx(response.N[-1], rel=error)


@pytest.mark.parametrize("space", [False, True])
@pytest.mark.parametrize("friction", [0.15, 0.3])
def test_joints_that_have_slid_bear_their_weight(space: bool, friction: float, tmp_path: Path) -> None:
    """Integrate at rest after slips of 0.02 and 0.77 m of blocks 1 m wide: 1e-6 was measured, 5 % without the slips."""
    block = {"height": 1.2, "width": 1.0, "depth": 0.6, "density": 2500.0, "repeat": 2}
    column = Column.from_dict({"name": "slides", "joint": {**SLIDING, "friction": friction}, "block": [block]})
    shaking = wavelets.ricker(0.9 * 9.80665, 0.8)
    response = simulate(column.in_space() if space else column, shaking, check=False)
    assert response.verdict == "standing"
    assert np.max(np.abs(response.slip[-1])) > 0.1
    weight = 2500.0 * 0.72 * column.g
    assert response.N[-1] == pytest.approx([weight, 2.0 * weight], rel=1e-5)
    check_forces(response, tmp_path, 2e-6)


def test_a_slab_that_has_slid_and_twisted_bears_its_weight(tmp_path: Path) -> None:
    """Check a slab that slides both ways and turns over the edges of a smaller block."""
    blocks = [
        {"name": "pad", "on": "base", "at": [0, 0], "width": 1.0, "depth": 0.8, "height": 0.3, "density": 2500.0},
        {"name": "slab", "on": "pad", "at": [0.1, 0.0], "width": 1.4, "depth": 0.5, "height": 0.2, "density": 2500.0},
    ]
    port = {"name": "end", "block": "slab", "at": [0.8, 0.0, 0.4]}
    structure = Structure.from_dict({"name": "slab", "joints": SLIDING, "block": blocks, "port": [port]})
    pulse = wavelets.ricker(0.5 * 9.80665, 1.0)
    response = simulate(
        structure, replace(pulse, ay=0.7 * np.roll(pulse.ax, 40)), loads={"end": {"Fy": 250.0}}, check=False
    )
    assert response.verdict == "standing"
    assert abs(response.rz[-1, 1] - response.rz[-1, 0]) > 1.0
    check_forces(response, tmp_path, 2e-6)  # 4e-7 was measured


def test_drums_that_have_slid_bear_their_weight_on_what_their_faces_share(tmp_path: Path) -> None:
    """Compare a lens and a cut ring: polygons of 32 corners have 0.6 % less area than their discs, so 2 %."""
    drum = {"height": 0.5, "section": "circle", "diameter": 1.0, "density": 2500.0, "repeat": 2}
    for bore in (0.0, 0.4):
        table = {**drum, **({"bore": bore, "section": "annulus"} if bore else {})}
        column = Column.from_dict({"name": "drums", "joint": SLIDING, "block": [table]})
        response = simulate(column, wavelets.ricker(0.5 * 9.80665, 0.8), check=False)
        assert response.verdict == "standing"
        check_forces(response, tmp_path / f"bore{10 * bore:g}", 0.02)


def test_a_joint_that_has_ended_in_a_fall_bears_nothing(tmp_path: Path) -> None:
    block = {"name": "post", "on": "base", "width": 0.5, "depth": 0.5, "height": 2.0, "density": 2500.0}
    meet = {"stiffness": 1e9, "restitution": 0.3, "friction": 0.4, "after_fall": 1.0}
    joints = {**SLIDING, "friction": 0.4}
    post = Structure.from_dict({"name": "post", "joints": joints, "neighbours": meet, "block": [block]})
    response = simulate(post, wavelets.one_sine(0.6 * 9.80665, 0.8), check=False)
    ended = response.time[response.contact[:, 0] == 0.0]
    assert response.overturn_time < ended[0] < response.time[-1]
    response.to_vtk(tmp_path, fps=1000.0)
    files = [(tmp_path / f"joints_{k:05d}.vtu").read_text("ascii") for k in range(len(response.time))]
    empty = ['NumberOfCells="0"' in text for text in files]
    assert response.time[empty] == pytest.approx(ended)


def test_a_slider_bears_where_it_has_risen_to(tmp_path: Path) -> None:
    """Move an undamped slab on four pendulums by 0.16 m, where they are 13 mm higher: they are pressed in by 0.05 mm.

    Polygons of 32 corners have 0.6 % less area than discs.
    """
    slab = {"name": "slab", "position": [0.0, 0.0, 0.2], "width": 2.0, "depth": 1.0, "height": 0.4, "density": 2500.0}
    places = [[x, y, 0.2] for x in (-0.7, 0.7) for y in (-0.3, 0.3)]
    dish: dict[str, Any] = {"kind": "pendulum", "between": ["slab", "base"], "at": places}
    dish |= {"diameter": 0.2, "vertical_stiffness": 1e8, "vertical_damping": 0.0, "capacity": 0.5}
    dish |= {"radius": 1.0, "friction": 0.0}
    law = {"stiffness": 1e9, "damping": 0.0}
    structure = Structure.from_dict({"name": "slab", "joints": law, "block": [slab], "bearing": [dish]})
    response = simulate(structure, wavelets.one_sine(1.0, 0.5), 1.0, check=False, settle=0.0)
    assert np.max(np.abs(response.dx[-1])) > 0.15
    check_forces(response, tmp_path, 0.007)


@pytest.mark.parametrize("section", ["rectangle", "circle", "annulus"])
def test_joints_with_a_rim_bear_in_it_only(section: str, tmp_path: Path) -> None:
    """Check a column and its stack at rest, as built and after a slip; without the rims 2.1 times the weight."""
    size = {"width": 1.0, "depth": 0.6} if section == "rectangle" else {"section": section, "diameter": 1.0}
    block = {"height": 0.6, "density": 2500.0, "repeat": 2, **size, **({"bore": 0.3} if section == "annulus" else {})}
    column = Column.from_dict({"name": "rims", "joint": {**SLIDING, "rim": 0.08}, "block": [block]})
    for name, model, pga in (("still", column, 0.0), ("slid", column, 0.5), ("in space", column.in_space(), 0.5)):
        response = simulate(model, wavelets.ricker(pga * 9.80665 + 1e-9, 0.8), check=False)
        assert response.verdict == "standing"
        assert (np.max(np.abs(response.slip[-1])) > 0.05) == (pga > 0.0)
        check_forces(response, tmp_path / name, 1e-6 if section == "rectangle" else 4e-3)  # 3e-9, 3e-3


@pytest.mark.parametrize("pga", [0.0, 0.3])
def test_strips_bear_and_the_gaps_between_them_do_not(pga: float, tmp_path: Path) -> None:
    """Check blocks at rest, as built and after a slip: N of the pressure, and one polygon for each strip of a depth."""
    block = {"height": 0.6, "width": 1.0, "depth": 0.6, "density": 2500.0, "repeat": 2}
    strips = {"section": "strips", "strips": [0.6, 0.0, 0.0, 0.3, 0.6]}
    column = Column.from_dict({"name": "strips", "joint": {**SLIDING, **strips}, "block": [block]})
    response = simulate(column, wavelets.ricker(pga * 9.80665 + 1e-9, 0.8), check=False)
    assert response.verdict == "standing"
    assert (np.max(np.abs(response.slip[-1])) > 0.02) == (pga > 0.0)
    check_forces(response, tmp_path, 1e-6)
    *_, (_, mesh) = series(tmp_path, "joints")
    assert sum(len(cells.data) for cells in mesh.cells) == 6
    if not pga:
        assert not np.any((mesh.points[:, 0] > -0.299) & (mesh.points[:, 0] < 0.099))


def test_a_contact_ends_where_the_lower_block_does(tmp_path: Path) -> None:
    """Check a block that overhangs a narrower one as built."""
    blocks = [{"height": 0.4, "width": width, "depth": 0.6, "density": 2500.0} for width in (1.5, 1.0)]
    column = Column.from_dict({"name": "T", "joint": {"stiffness": 2e9, "damping": 1e-3}, "block": blocks})
    response = simulate(column, Motion.harmonic(0.0, 1.0, 0.1), check=False, settle=0.0)
    check_forces(response, tmp_path, 1e-7)


def test_the_command_writes_each_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = str(ROOT / "examples" / "columns" / "phocas-damped.toml")
    shaking = ["--wavelet", "ricker", "--pga", "0.05", "--frequency", "2", "--duration", "0.5"]
    for name in ("scene.glb", "scene.html", "table.csv", "folder"):
        assert main(["export", file, str(tmp_path / name), *shaking]) == 0, capsys.readouterr().err
        assert (tmp_path / name).exists()
    assert (tmp_path / "folder" / "joints.pvd").is_file()
    assert main(["export", file, str(tmp_path / "folder"), *shaking]) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["export", file, str(tmp_path / "scene.obj"), *shaking]) == 2
    assert "must end in .glb" in capsys.readouterr().err


def test_a_shorter_run_leaves_no_file_of_an_older_one(tmp_path: Path) -> None:
    """Write 0.8 s, then 0.2 s: 12 files of the older run stayed. Files of other names do."""
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas.toml")
    for duration in (0.8, 0.2):
        simulate(column, Motion.harmonic(2.0, 2.0, duration), settle=0.0).to_vtk(tmp_path, fps=FPS)
        for name in ("walls.vtu", "own.vtu", "blocks_3.vtu"):
            (tmp_path / name).touch()
    simulate(column, Motion.harmonic(2.0, 2.0, 0.2), settle=0.0).to_vtk(tmp_path, fps=FPS)
    numbered = [f"{name}_{k:05d}.vtu" for name in ("blocks", "joints") for k in range(3)]
    kept = ["blocks.pvd", "blocks_3.vtu", "joints.pvd", "own.vtu"]
    assert sorted(path.name for path in tmp_path.iterdir()) == sorted([*numbered, *kept])


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas.toml")
    response = simulate(column, replace(SHAKING, duration=0.1, time=np.array([0.0, 0.1])), check=False, settle=0.0)
    with pytest.raises(InputError, match="must be a folder"):
        response.to_vtk(tmp_path / "out.vtu")


def test_an_interrupt_leaves_no_list_and_no_part_of_a_file(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Interrupt a run in the folder of another one, as it writes its third file: the lists led to files of both."""
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas.toml")
    simulate(column, Motion.harmonic(2.0, 2.0, 0.2), settle=0.0).to_vtk(tmp_path, fps=FPS)
    before, write, written = (tmp_path / "blocks_00001.vtu").read_bytes(), Path.write_text, []

    def interrupted(path: Path, text: str, **how: Any) -> int:
        written.append(path)
        if len(written) < 3:
            return write(path, text, **how)
        write(path, text[: len(text) // 2], **how)
        raise KeyboardInterrupt

    monkeypatch.setattr(Path, "write_text", interrupted)
    with pytest.raises(KeyboardInterrupt):
        simulate(column, Motion.harmonic(3.0, 2.0, 0.2), settle=0.0).to_vtk(tmp_path, fps=FPS)
    assert (tmp_path / "blocks_00001.vtu").read_bytes() == before
    assert not [path for path in tmp_path.iterdir() if path.suffix != ".vtu" or path.name.startswith(".")]


def test_a_folder_with_a_dot_is_written_to(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check a folder that exists: it was refused as the name of a file, by the command too."""
    column, folder = ROOT / "examples" / "columns" / "phocas-damped.toml", tmp_path / "run.2"
    folder.mkdir()
    simulate(Column.from_toml(column), Motion.harmonic(2.0, 2.0, 0.1), settle=0.0).to_vtk(folder, fps=FPS)
    assert (folder / "joints.pvd").is_file()
    shaking = ["--wavelet", "ricker", "--pga", "0.05", "--frequency", "2", "--duration", "0.1"]
    assert main(["export", str(column), str(folder), *shaking]) == 2
    assert "--force" in capsys.readouterr().err
    assert main(["export", str(column), str(folder), *shaking, "--force"]) == 0
