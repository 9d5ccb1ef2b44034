"""A scan as a rock in space: mass properties in closed form, the foot, and which motions overturn it."""

from __future__ import annotations

import itertools
import sys
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pytest
from scipy.spatial import ConvexHull
from support.fmus import ROOT

sys.path.insert(0, str(ROOT))  # the cases are not installed

from multiblock import InputError, Motion
from validation.cases import rocks_in_space
from validation.footprint import rock_from, scan
from validation.rigid_block import FloatArray

SIZES = np.array([0.4, 0.6, 1.2])  # m
G = 9.80665
NEEDS = pytest.mark.skipif(not find_spec("trimesh"), reason="needs trimesh, of the extra mesh")


def write_box(path: Path, with_faces: bool, unit: float) -> None:
    """Return a box above the origin, off the axes, its sides as triangles; unit: of a metre in the file."""
    corners = unit * (np.array([*itertools.product((0.0, 1.0), repeat=3)]) * SIZES + [3.0, -2.0, 0.5])
    lines = [f"v {x} {y} {z}" for x, y, z in corners]
    hull = ConvexHull(corners)
    for simplex, equation in zip(hull.simplices, hull.equations, strict=True):
        a, b, c = corners[simplex]
        order = simplex if np.dot(np.cross(b - a, c - a), equation[:3]) > 0.0 else simplex[::-1]
        lines += ["f " + " ".join(f"{k + 1}//{k + 1}" for k in order)] if with_faces else []
    path.write_text("# a box\n" + "\n".join(lines) + "\n", encoding="utf-8")


@NEEDS
@pytest.mark.parametrize(("with_faces", "unit"), [(True, 1.0), (True, 1e3), (False, 1.0)])
def test_a_box(tmp_path: Path, with_faces: bool, unit: float) -> None:
    write_box(tmp_path / "box.obj", with_faces, unit)
    rock = rock_from(tmp_path / "box.obj", 500.0, 1e-3)
    np.testing.assert_allclose(np.ptp(rock.foot, axis=0), SIZES[:2], rtol=1e-9)
    structure = rock.structure(0.5, 1e9, 3e-3, 0.7)
    block = structure.blocks[0]
    assert block.volume == pytest.approx(np.prod(SIZES), rel=1e-9)
    assert block.centroid[2] == pytest.approx(0.6, rel=1e-9)
    inertia = 500.0 / 12.0 * (np.sum(SIZES**2) - SIZES**2)
    np.testing.assert_allclose(block.inertia, np.diag(inertia), atol=1e-7)
    assert structure.joints[0].face.moments[0] == pytest.approx(0.25 * 0.4 * 0.6, rel=1e-9)
    assert structure.blocks[0].drop > 0.1  # m: it counts as fallen when it has, not before


@NEEDS
def test_a_box_on_a_rim_is_as_stiff_in_all(tmp_path: Path) -> None:
    write_box(tmp_path / "box.obj", True, 1.0)
    rock = rock_from(tmp_path / "box.obj", 500.0, 1e-3)
    structure = rock.structure(1.0, 1e9, 3e-3, 0.7, 0.1)
    rim = 0.1 * 4.0 * 0.4 * 0.6 / 2.0  # m: of the square of its area over its perimeter
    joint = structure.joints[0]
    bears = 0.4 * 0.6 - (0.4 - 2.0 * rim) * (0.6 - 2.0 * rim)
    assert joint.bed.rim == pytest.approx(rim, rel=1e-9)
    assert joint.moments[0] == pytest.approx(bears, rel=1e-9)
    assert joint.bed.stiffness * bears == pytest.approx(1e9 * 0.4 * 0.6, rel=1e-9)


def test_no_scan(tmp_path: Path) -> None:
    (tmp_path / "empty.obj").write_text("v 0 0 0\n", encoding="utf-8")
    with pytest.raises(InputError, match="at least four lines"):
        scan(tmp_path / "empty.obj")
    with pytest.raises(InputError, match="no such file"):
        scan(tmp_path / "none.obj")


@NEEDS
# middle, g: on a rim smaller feet are tried
@pytest.mark.parametrize(("rim", "middle"), [pytest.param(None, 0.6, marks=pytest.mark.long), (0.1, 0.45)])
def test_a_larger_foot_falls_later(tmp_path: Path, rim: float | None, middle: float) -> None:
    """Push it along x, the narrow way, by pulses of 2 Hz that grow; West's limit is b / h g times a factor."""
    write_box(tmp_path / "box.obj", True, 1.0)
    rock = rock_from(tmp_path / "box.obj", 500.0, 1e-3)
    time = rocks_in_space.SAMPLE * np.arange(800)

    def pulse(amplitude: float) -> Motion:
        ax: FloatArray = amplitude * G * np.sin(4.0 * np.pi * time) * (time < 0.5)
        return rocks_in_space.shortened(Motion.from_samples(rocks_in_space.SAMPLE, ax))

    motions = [pulse(amplitude) for amplitude in (0.1, middle, 3.0)]
    assert motions[0].time[1] == pytest.approx(5e-3)
    found = rocks_in_space.verdicts(rock, motions, 0.0, rim)
    assert found.shape == (len(rocks_in_space.SCALES), 3)
    assert np.all(np.diff(found, axis=0) <= 0.0)  # a larger foot does not fall where a smaller one stands
    assert np.array_equal(found[:, 0], np.zeros(len(found)))  # below g b / h even of the least foot
    assert np.array_equal(found[:, 2], np.ones(len(found)))
    assert 0.0 < np.mean(found[:, 1]) < 1.0
