"""Joints that touch in a rim along their edges: the bed of the outline less that of the inside."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from space.test_beds import SCALE, exact_bed
from space.test_overlap import BOX, DRUM, SHAPES, bed, by_quadrature, check_forces, check_lanes, drawn, moved, two
from support.structures import law_on_edge, with_law

from multiblock import Column, Motion, SpatialState, Structure, simulate
from solver.common.errors import InputError
from solver.models.structure.blocks.faces import FloatArray, clipped, polygon_moments
from solver.models.structure.numbers import structure_with

RIM = 0.06  # m


def with_rim(upper: dict[str, Any], lower: dict[str, Any], rim: float) -> Structure:
    """Return two blocks on each other, whose faces touch in a rim."""
    return two({**upper, "joint": {"rim": rim}}, {**lower, "joint": {"rim": rim}})


def narrowed(shape: dict[str, Any], rim: float) -> dict[str, Any]:
    """Return the block whose faces are the insides of those of another one."""
    found = {**shape}
    for key in ("width", "depth", "diameter"):
        if key in found:
            found[key] = found[key] - 2.0 * rim
    if found.get("bore"):
        found["bore"] = found["bore"] + 2.0 * rim
    return found


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("seed", range(30))
def test_polygons_against_rational_numbers(seed: int) -> None:
    rng = np.random.default_rng(seed)
    rim = float(rng.uniform(0.01, 0.3))
    sizes = [{"width": w, "depth": d} for w, d in (rng.uniform(0.8, 1.6, 2), rng.uniform(0.8, 1.6, 2))]
    if seed % 3 == 0:
        sizes[1] = sizes[0]  # edges that coincide
    structure = with_rim({**BOX, **sizes[0]}, {**BOX, **sizes[1]}, rim)
    slips = rng.uniform(-0.4, 0.4, 3) * ((1.0, 1.0, 1.0), (0.0, 0.0, 0.0), (1.0, 1.0, 0.0))[seed % 3]
    p, q = drawn(rng, seed)
    total, scale = np.zeros(5), 1e-30
    for inset, sign in ((0.0, 1.0), (rim, -1.0)):
        halves = [0.5 * np.array(list(s.values())) - inset for s in sizes]
        corners = [half * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) for half in halves]
        outline = clipped(moved(corners[0], slips, 0.5), moved(corners[1], slips, -0.5))
        if len(outline):
            part, force = exact_bed(outline, p, q)
            total[:4] += sign * part[:4]
            total[4], scale = (part[4], scale + force) if inset == 0.0 else (total[4], scale)
    size = np.array([scale, scale, scale, 2.5, SCALE])
    assert np.max(np.abs(bed(structure, slips, p, q) - total) / size) <= 1e-12  # measured 2e-14


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("name", SHAPES)
def test_round_faces_against_quadrature(name: str, seed: int) -> None:
    rng = np.random.default_rng(seed)
    upper, lower = SHAPES[name]
    slips = np.array([*rng.uniform(-0.3, 0.3, 2), 0.0])
    p, q = (plane / SCALE for plane in drawn(rng, seed))
    expected = by_quadrature(upper, lower, slips, p, q)
    expected -= by_quadrature(narrowed(upper, RIM), narrowed(lower, RIM), slips, p, q)
    found = bed(with_rim(upper, lower, RIM), slips, p, q)[:4]
    assert np.max(np.abs(found - expected)) <= 1e-12  # measured 2e-14; the scale of the numbers is 1


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("name", SHAPES)
def test_beds_in_lanes_are_those_of_each_to_the_last_bit(name: str) -> None:
    check_lanes(with_rim(*SHAPES[name], RIM))


@pytest.mark.parametrize("name", SHAPES)
def test_forces_are_the_slopes_of_the_energy_after_a_slip(name: str) -> None:
    check_forces(with_rim(*SHAPES[name], RIM))


@pytest.mark.parametrize("name", SHAPES)
def test_a_rim_of_half_a_face_is_the_whole_face_to_the_last_bit(name: str) -> None:
    rng = np.random.default_rng(5)
    rim, whole = with_rim(*SHAPES[name], 0.65), two(*SHAPES[name])
    for k in range(8):
        slips, (p, q) = rng.uniform(-0.3, 0.3, 3) * (k % 2), drawn(rng, k)
        assert np.array_equal(bed(rim, slips, p, q), bed(whole, slips, p, q))


@pytest.mark.parametrize("shape", [{"width": 0.8, "depth": 0.8}, {"width": 0.8, "depth": 1.3}, {"diameter": 0.8}])
def test_what_rounding_leaves_of_a_rim_of_half_the_width_is_nothing(shape: dict[str, Any]) -> None:
    """Check places at which a part 1e-17 m wide was left, and rims less than half by up to 1e-11 of it."""
    for x in (0.0, 0.1, 0.7, 0.9, 1.3, 100.3):
        for less in (0.0, *10.0 ** -np.arange(11.0, 17.0)):
            block = {"name": "b", "on": "base", "at": [x, 0.3 * x], "height": 0.8, "density": 2000.0, **shape}
            block |= {"shape": "drum"} if "diameter" in shape else {}
            law = {"stiffness": 1e9, "damping": 1e-3, "rim": 0.4 * (1.0 - less)}
            (joint,) = Structure.from_dict({"name": "b", "joints": law, "block": [block]}).joints
            assert joint.inside is None
            assert joint.moments[0] == pytest.approx(math.pi * 0.16 if "diameter" in shape else joint.face.moments[0])


def hull(rng: np.random.Generator, count: int) -> FloatArray:
    """Return a convex polygon about the origin, anticlockwise."""
    angles = np.sort(rng.uniform(0.0, 2.0 * math.pi, 3 * count))[::3]
    return np.column_stack([np.cos(angles), 0.8 * np.sin(angles)])


@pytest.mark.parametrize("seed", range(6))
def test_the_centre_is_the_centroid_of_what_bears(seed: int) -> None:
    """Check an irregular face: the rim's centroid is not that of the face. Area and moments by a fine grid."""
    rng = np.random.default_rng(seed)
    points = hull(rng, 5)
    law = {"stiffness": 1e9, "damping": 0.0, "rim": RIM}
    block = {"shape": "hull", "points": [[x, y, z] for x, y in points for z in (0.0, 1.0)]}
    structure = Structure.from_dict(
        {"name": "hull", "joints": law, "block": [{"name": "b", "on": "base", "density": 2000.0, **block}]}
    )
    joint = structure.joints[0]
    assert joint.inside is not None
    a, b = joint.face.outline, joint.inside.outline
    (outer, first, second), (inner, less, lost) = polygon_moments(a), polygon_moments(b)
    assert np.max(np.abs(first - less)) <= 1e-14
    assert joint.moments == pytest.approx(
        (outer - inner, second[0, 0] - lost[0, 0], second[1, 1] - lost[1, 1], second[0, 1] - lost[0, 1]), rel=1e-12
    )
    # every point of the inside is RIM or more from each edge, its corners from two of them exactly
    sides = np.roll(a, -1, axis=0) - a
    normals = np.column_stack([-sides[:, 1], sides[:, 0]]) / np.hypot(*sides.T)[:, None]
    depths = np.sort(np.array([np.sum((corner - a) * normals, axis=1) for corner in b]), axis=1)
    assert depths[:, :2] == pytest.approx(RIM, abs=1e-12)
    # at rest the pressure is uniform over what bears
    pressed = bed(structure_with_friction(structure), np.zeros(3), *(2 * [np.array([SCALE, 0.0, 0.0])]))
    assert pressed[:4] == pytest.approx([SCALE * (outer - inner), 0.0, 0.0, outer - inner], abs=1e-15)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("before", [None, RIM, 2.0])
@pytest.mark.parametrize("listed", [False, True])
def test_a_varied_rim_is_that_of_the_file(seed: int, before: float | None, listed: bool) -> None:
    """Vary the rim of an irregular face that has none, another one, or one wider than itself (measured: 4e-16 m)."""
    points = hull(np.random.default_rng(seed), 5)
    small = points.mean(axis=0) + 0.6 * (points - points.mean(axis=0))
    block = {"name": "b", "on": "base", "density": 2000.0, "shape": "hull"}
    patch = {"between": ["b", "base"], "at": [0.0, 0.0, 0.0], "section": "polygon", "outline": small.tolist()}

    def made(rim: float | None) -> Structure:
        law = {"stiffness": 1e9, "damping": 0.0, "friction": 0.5, **({} if rim is None else {"rim": rim})}
        body = {**block, "points": [[x, y, z] for x, y in points for z in (0.0, 1.0)]}
        listing = {"joint": [patch]} if listed else {}
        if listed:
            body |= {"on": [], "position": [0.0, 0.0, 0.0]}
        return Structure.from_dict({"name": "h", "joints": law, "block": [body], **listing})

    for after in (RIM, 0.5 * RIM, 2.0):
        varied, fresh = structure_with(made(before), {"joint.rim": (after, False)}).joints[0], made(after).joints[0]
        assert (varied.inside is None) == (fresh.inside is None) == (after == 2.0)
        assert varied.moments == pytest.approx(fresh.moments, rel=1e-12, abs=1e-15)
        assert varied.face.centre == pytest.approx(fresh.face.centre, abs=1e-14)
        assert varied.face.outline == pytest.approx(fresh.face.outline, abs=1e-14)


def structure_with_friction(structure: Structure) -> Structure:
    return with_law(structure, friction=0.5)


@pytest.mark.parametrize(
    ("law", "words"),
    [
        ({"rim": 0.0}, "rim = 0.0: must be a positive width in m"),
        ({"rim": "wide"}, "rim"),
        (
            {"rim": 0.1, "tensile_strength": 1e5},
            "rim = 0.1: must be left out of a joint that bears tension or cohesion",
        ),
    ],
)
def test_a_rim_that_cannot_be_is_refused(law: dict[str, Any], words: str) -> None:
    block = {"name": "b", "on": "base", "mass": 1.0, "width": 1.0, "depth": 1.0, "height": 1.0}
    with pytest.raises(InputError, match=words):
        Structure.from_dict({"name": "x", "joints": {"stiffness": 1e9, "damping": 0.0, **law}, "block": [block]})


def test_a_drum_has_a_ring() -> None:
    """Check that a disc with a rim is a ring, to rounding."""
    law = {"stiffness": 1e9, "damping": 1e-3}
    block = {"name": "d", "on": "base", "mass": 1000.0, **{k: v for k, v in DRUM.items() if k != "mass"}}
    disc = Structure.from_dict({"name": "d", "joints": {**law, "rim": 0.1}, "block": [{**block, "diameter": 1.0}]})
    at = {"between": ["d", "base"], "at": [0.0, 0.0, 0.0], "section": "ring", "diameter": 1.0, "bore": 0.8}
    placed = {**block, "diameter": 1.0, "on": [], "position": [0.0, 0.0, 0.0]}
    ring = Structure.from_dict({"name": "d", "joints": law, "joint": [at], "block": [placed]})
    assert disc.joints[0].moments == pytest.approx(ring.joints[0].moments, rel=1e-14)
    assert disc.joints[0].arm == pytest.approx(ring.joints[0].arm, rel=1e-14)


# --- whole runs


def tall(depth: float, rim: float | None, stiffness: float = 1e12) -> Structure:
    """Return a block of 0.4 x 1.6 m in a plane, critically damped as it stands on its edge."""
    width, height, density = 0.4, 1.6, 2500.0
    law = law_on_edge(stiffness, (width, depth, height), density, rim)
    size = {"width": width, "depth": depth, "height": height, "density": density}
    return Structure.from_dict({"name": "tall", "joints": law, "block": [{"name": "b", "on": "base", **size}]})


def restitution(structure: Structure) -> float:
    """Return the rotation rate after over before the first impact, by the energies of the turning points; let go at
    0.08 rad.
    """
    turn, half, rise = 0.08, 0.2, 0.8
    lift = half * math.sin(turn) + rise * (math.cos(turn) - 1.0)
    across = rise * math.sin(turn) + half * (1.0 - math.cos(turn))
    u, still = np.array([[across, 0.0, lift]]), np.zeros((1, 3))
    initial = SpatialState(u, np.array([[0.0, turn, 0.0]]), still, still)
    response = simulate(structure, Motion.from_samples(0.01, np.zeros(121)), initial=initial, settle=0.0)
    angle = response.rotation[:, 0, 1]
    peak = float(np.max(-angle))
    lifts = [half * math.sin(a) + rise * (math.cos(a) - 1.0) for a in (peak, turn)]
    return math.sqrt(lifts[0] / lifts[1])


def test_a_block_on_a_rim_loses_what_housners_block_loses() -> None:
    """Check that e = 1 - 1.5 sin^2(alpha) = 0.9118 where the impulse acts at the edge; a flat face loses less.

    A square base has as much of its rim along the motion as across it, and lies between.
    """
    found = [restitution(tall(8.0, 1e-3)), restitution(tall(0.4, 1e-3)), restitution(tall(8.0, None, 1e10))]
    print("RESTITUTION", found)
    assert found[0] == pytest.approx(0.9118, rel=5e-3)
    assert found[0] < found[1] < found[2]


@pytest.mark.parametrize("beside", [False, True], ids=["alone", "with a box"])
def test_a_drum_without_friction_tilts_on_its_rim_as_in_the_plane(beside: bool) -> None:
    """Check that the rim is there whether or not corners of other faces come before its own."""
    law = {"stiffness": 2e9, "damping": 5e-3, "rim": 0.3, "shear_ratio": 400.0}
    drum = {"name": "drum", "on": "base", "shape": "drum", "diameter": 1.0, "height": 3.0, "density": 2500.0}
    box = {"name": "box", "on": "base", "at": [5.0, 0.0], "width": 1.0, "depth": 1.0, "height": 1.0, "density": 2500.0}
    port = [{"name": "push", "block": "drum"}]
    structure = Structure.from_dict(
        {"name": "drum", "joints": law, "block": [*([box] if beside else []), drum], "port": port}
    )
    still = Motion.from_samples(0.01, np.zeros(20))
    push = {"push": {"Fx": 7000.0}}  # N, on the centroid: opens the foot
    turned = simulate(structure, still, release=push, settle=0.0, tolerance=1e-8).rotation[0, -1, 1]
    block = {"height": 3.0, "section": "circle", "diameter": 1.0, "density": 2500.0}
    joint = {key: law[key] for key in ("stiffness", "damping", "rim")}
    column = Column.from_dict(
        {"name": "drum", "block": [{**block, "joint": joint}], "port": [{"name": "push", "block": "block1"}]}
    )
    theta = simulate(column, still, release=push, settle=0.0, tolerance=1e-8).ry[0, 0]
    assert turned == pytest.approx(theta, rel=1e-6)  # measured 7e-8; without the rim 3e-2
