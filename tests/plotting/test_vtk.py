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

from multiblock import Structure
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


def test_a_file_is_no_folder(tmp_path: Path) -> None:
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas.toml")
    response = simulate(column, replace(SHAKING, duration=0.1, time=np.array([0.0, 0.1])), check=False, settle=0.0)
    with pytest.raises(InputError, match="must be a folder"):
        response.to_vtk(tmp_path / "out.vtu")
