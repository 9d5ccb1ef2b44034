"""Overlap of blocks that no joint connects: against places known in closed form, linear programs, and a run."""

import itertools
import math
import warnings
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.optimize import linprog
from support.throws import HIGH, pair_of

from multiblock import (
    InputError,
    InputWarning,
    Limits,
    Motion,
    Plan,
    SpatialState,
    Structure,
    check,
    simulate,
    wavelets,
)
from solver.models.structure.blocks.parts import Solid
from solver.models.structure.blocks.shapes import box, drum, placed, prism, rotation_matrix, turned
from solver.models.structure.convex import TOUCH, ConvexPart, along_axes, distance
from solver.models.structure.overlap import Overlap, deepest_overlap

G = 9.80665
UPRIGHT = np.eye(3)
WEDGE = np.array([[-0.3, 0.0], [0.3, 0.0], [0.2, 0.7], [-0.2, 0.7]])


def overlap_of(solids: list[Solid], u: Any, rotation: Any, joined: tuple[tuple[int, int], ...] = ()) -> Overlap:
    """Return the overlap of blocks displaced and turned, (rows, blocks, 3); joined: pairs that a joint connects."""
    u, rotation = np.asarray(u, dtype=np.float64), np.asarray(rotation, dtype=np.float64)
    joints = tuple(SimpleNamespace(upper=i, lower=j, bearing=True) for i, j in joined)
    names = tuple(solid.name for solid in solids)
    parts = {"blocks": tuple(solids), "joints": joints, "neighbours": ()}
    structure: Any = SimpleNamespace(n=len(solids), names=names, **parts)
    rows: Any = SimpleNamespace(ux=u[..., 0], uy=u[..., 1], uz=u[..., 2], rotation=rotation)
    return deepest_overlap(structure, np.arange(len(u), dtype=np.float64), rows)


def cube(name: str, x: float, side: float = 1.0) -> Solid:
    return placed(box(name, (side, side), (side, side), side, 1.0), np.array([x, 0.0, 0.0]), UPRIGHT)


def cylinder(name: str, x: float, radius: float = 0.5) -> Solid:
    return placed(drum(name, 2.0 * radius, 2.0 * radius, 0.0, 1.0, 1.0), np.array([x, 0.0, 0.0]), UPRIGHT)


def test_places_known_in_closed_form() -> None:
    still, u = np.zeros((3, 2, 3)), np.zeros((3, 2, 3))
    u[1, 1, 0], u[2, 1, 0] = -0.15, -0.05
    for pair in ([cube("a", 0.0), cube("b", 1.1)], [cylinder("a", 0.0), cylinder("b", 1.1)]):
        found = overlap_of(pair, u, still)
        assert found.depth == pytest.approx(0.05, abs=1e-12)
        assert (found.between, found.time) == (("a", "b"), 1.0)
        assert "a and b pass into each other by 50 mm at 1 s" in found.sentence
        assert overlap_of(pair, u, still, ((0, 1),)) == Overlap()  # a joint connects them
    turn = still.copy()
    turn[1, 1, 2] = 0.25 * math.pi  # its corner reaches half a diagonal
    found = overlap_of([cube("a", 0.0), cube("b", 1.1)], 0.0 * u, turn)
    assert found.depth == pytest.approx(0.5 * math.sqrt(2.0) - 0.6, abs=1e-12)
    corner = overlap_of([cylinder("a", 0.0), cube("b", 1.1)], 0.0 * u, turn)
    assert corner.depth == pytest.approx(0.5 * math.sqrt(2.0) - 0.6, abs=1e-12)
    leaning = still.copy()
    leaning[:, 0, 1], leaning[:, 1, 1] = 0.2, -0.2  # towards each other, about their centroids: the upper rims meet
    met = overlap_of([cylinder("a", 0.0), cylinder("b", 1.1)], 0.0 * u, leaning)
    assert met.depth == pytest.approx(2.0 * (0.5 * math.cos(0.2) + 0.5 * math.sin(0.2)) - 1.1, rel=0.05)


def test_only_what_is_deeper_than_as_built_counts() -> None:
    """Check that blocks that touch as built, and slide along each other or apart, do not overlap; nor does
    what is far.
    """
    still, u = np.zeros((2, 3, 3)), np.zeros((2, 3, 3))
    row = [cube("a", 0.0), cube("b", 1.0), cube("c", 2.0)]
    u[1] = [[-0.1, 0.0, 0.0], [0.0, 0.3, 0.0], [0.5 * TOUCH, 0.0, 0.0]]
    assert overlap_of(row, u, still) == Overlap()
    u[1, 2, 0] = -0.002
    found = overlap_of(row, u, still)
    assert found.depth == pytest.approx(0.002, rel=1e-9)
    assert found.between == ("b", "c")
    into = [cube("a", 0.0), cube("b", 0.9)]  # by 0.1 m as built
    assert overlap_of(into, 0.0 * u[:, :2], still[:, :2]) == Overlap()
    u[1, 1] = [-0.03, 0.0, 0.0]
    assert overlap_of(into, u[:, :2] * [[[0.0], [1.0]]], still[:, :2]).depth == pytest.approx(0.03, rel=1e-9)


def share_a_point(one: np.ndarray, other: np.ndarray) -> bool:
    """Return True if the hulls of corners share a point, by a linear program over the weights of both."""
    m, k = len(one), len(other)
    equal = np.zeros((5, m + k))
    equal[:3, :m], equal[:3, m:] = one.T, -other.T
    equal[3, :m], equal[4, m:] = 1.0, 1.0
    return bool(linprog(np.zeros(m + k), A_eq=equal, b_eq=[0.0, 0.0, 0.0, 1.0, 1.0]).status == 0)


def test_random_boxes_and_prisms_overlap_where_a_linear_program_says_so() -> None:
    rng = np.random.default_rng(3)
    met = 0
    for _ in range(60):
        solids = []
        for name in ("a", "b"):
            width, depth, height, top = rng.uniform(0.3, 1.0, 4)
            turn = rotation_matrix(rng.normal(0.0, 1.0, 3))
            shapes = (
                placed(box(name, (width, depth), (width, depth), height, 1.0), np.zeros(3), turn),
                placed(box(name, (width, depth), (top * width, depth), height, 1.0), np.zeros(3), turn),
                placed(prism(name, WEDGE, depth, 1.0), np.zeros(3), turn),
            )
            solids.append(shapes[int(rng.integers(3))])
        hulls = [ConvexPart(solid) for solid in solids]
        r1, r2 = rng.normal(0.0, 0.5, (2, 1, 3))
        between = rng.normal(0.0, 0.5, (1, 3))
        gap = float(along_axes(hulls[0], hulls[1], r1, r2, between)[0])
        corners = [hull.corners + turned(r, hull.corners) for hull, r in zip(hulls, (r1, r2), strict=True)]
        assert share_a_point(corners[0], corners[1] + between) is (gap < 0.0)
        if gap < 0.0:  # pushed apart by that along some axis they no longer meet: none of a few ways does it with less
            met += 1
            ways = rng.normal(0.0, 1.0, (8, 3))
            less = -0.99 * gap * ways / np.linalg.norm(ways, axis=1, keepdims=True)
            assert all(along_axes(hulls[0], hulls[1], r1, r2, between + step)[0] < 0.0 for step in less)
    assert 10 < met < 50


def beside(gap: float) -> Structure:
    """Return two stones side by side, one slender and one stout, that no joint connects."""
    sizes = {"depth": 0.4, "density": 2500.0, "on": "base"}
    slender = {"name": "slender", "width": 0.3, "height": 2.0, "at": [0.0, 0.0], **sizes}
    stout = {"name": "stout", "width": 1.0, "height": 1.0, "at": [0.65 + gap, 0.0], **sizes}
    law = {"stiffness": 2e9, "damping": 2e-3}
    return Structure.from_dict({"name": "pair", "joints": law, "block": [slender, stout]})


@pytest.mark.long  # takes seconds
def test_stones_that_pass_through_each_other_are_named_and_fail_a_check() -> None:
    motion = wavelets.one_sine(0.2 * G, 1.5)
    with pytest.warns(InputWarning, match=r"slender and stout pass into each other by [\d.]+ mm at"):
        met = simulate(beside(0.005), motion, settle=0.0)
    towards = met.displacement("slender", (0.15, 0.0, 0.0))[:, 0] - met.displacement("stout", (-0.5, 0.0, 0.5))[:, 0]
    assert met.overlap.depth > 2.0 * TOUCH
    assert met.overlap.depth < np.max(np.abs(towards)) + 0.2
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        simulate(beside(1.0), motion, settle=0.0)
        plan = Plan(ensemble=1, margin=False)
        found = check(beside(0.005), {"pulse": motion}, plan=plan)
    (row,) = (row for row in found.rows if row.name == "overlap of blocks")
    assert (row.passes, row.where, row.capacity) == (False, "slender, stout", TOUCH)
    assert "overlap of blocks" in found.answer
    deep = check(beside(0.005), {"pulse": motion}, plan=Plan(Limits(overlap=0.9), 1, margin=False))
    assert next(row for row in deep.rows if row.name == "overlap of blocks").passes


def polygons(solid: Solid, sides: int = 48) -> np.ndarray:
    """Return the corners of a drum whose rims are polygons about them, from its centroid."""
    angles = np.linspace(0.0, 2.0 * math.pi, sides, endpoint=False)
    circle = np.stack([np.cos(angles), np.sin(angles)], axis=1) / math.cos(math.pi / sides)
    ends = [face.centre + face.radius * circle @ face.axes[:, :2].T for face in solid.faces]
    return np.concatenate(ends) - solid.centroid


@pytest.mark.long  # takes 10 s and more
def test_random_drums_overlap_where_a_linear_program_says_so() -> None:
    """Check that the program has polygons about their rims, which lie up to 0.2 % of the radius outside."""
    rng, apart, still = np.random.default_rng(8), 0, np.zeros((1, 3))
    for _ in range(120):
        drums = []
        for name in ("a", "b"):
            shape, turn = drum(name, 0.6, 0.6, 0.0, rng.uniform(0.1, 1.5), 1.0), rotation_matrix(rng.normal(size=3))
            drums.append(placed(shape, np.zeros(3), turn))
        between = rng.normal(size=3) * 0.45
        found = float(distance(ConvexPart(drums[0]), ConvexPart(drums[1]), still, still, between[None])[0])
        corners = polygons(drums[0]), polygons(drums[1]) + between
        if not share_a_point(*corners):
            apart += 1
            assert found > -1e-9
        elif found > 2e-3:
            raise AssertionError("apart where polygons about them share a point by more than they lie outside")
    assert 30 < apart < 100


MEET: dict[str, Any] = {"reach": 0.6, "line_stiffness": 1e8, "stiffness": 1e8, "restitution": 0.5, "friction": 0.3}


def two(apart: float, turn: float = 0.0, meet: dict[str, Any] | None = None) -> Structure:
    """Return two boxes of 0.6 m beside each other."""
    size = {"on": "base", "width": 0.6, "depth": 0.6, "height": 1.0, "density": 2400.0}
    blocks = [
        {"name": "a", "at": [0.0, 0.0], **size},
        {"name": "b", "at": [apart, 0.0], "rotation": [0, 0, turn], **size},
    ]
    data = {"name": "two", "joints": {"stiffness": 1e9, "damping": 1e-3, "friction": 0.02}, "block": blocks}
    return Structure.from_dict(data if meet is None else {**data, "neighbours": meet})


def test_overlaps_as_built_are_refused_or_said() -> None:
    with pytest.raises(InputError, match="a and b overlap by 20 mm as built"):
        two(0.58, meet=MEET)
    with pytest.raises(InputError, match=r"a and b overlap by 23\.5 mm as built"):
        two(0.605, 0.1, meet=MEET)
    rounded = two(0.59999, meet=MEET)
    assert rounded.contact_names == ("a-b",)
    assert rounded.neighbours[0].gap == 0.0
    with_gap = two(0.58, meet={**MEET, "pair": [{"between": ["a", "b"], "gap": 0.01}]})
    assert [pair.gap for pair in with_gap.neighbours] == [0.01]
    with pytest.warns(InputWarning, match=r"block\[a\] and block\[b\] overlap by 20 mm as built"):
        two(0.58)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        two(0.59999)
        two(0.6)


def test_a_block_that_turns_by_a_quarter_before_it_hits_does_not_enter_its_neighbour() -> None:
    """Compare with blocks beyond the reach of neighbours, which pass into each other and are named."""
    structure = two(1.1, meet=MEET)
    state = SpatialState(*(np.zeros((2, 3)) for _ in range(4)))
    state.velocity[0, 0], state.spin[0, 2], state.displacement[:, 2] = 0.7, 2.2, -2.4e-5
    response = simulate(structure, Motion.from_samples(0.1, np.zeros(16)), initial=state, settle=0.0)
    assert response.overlap == Overlap()
    assert response.peaks["hit"][0] > 1e3
    assert -0.005 < response.peaks["gap"][0] < 0.0
    apart = two(1.1, meet={**MEET, "reach": 0.1})
    with pytest.warns(InputWarning, match="a and b pass into each other"):
        lost = simulate(apart, Motion.from_samples(0.1, np.zeros(16)), initial=state, settle=0.0)
    assert lost.overlap.cause == "unjoined"
    assert lost.overlap.depth > 0.05
    state.spin[:] = 0.0
    hits = simulate(structure, Motion.from_samples(0.1, np.zeros(16)), initial=state, settle=0.0)
    assert hits.peaks["hit"][0] > 1e3
    assert hits.overlap == Overlap()


def test_a_distance_that_jumps_ends_one_step_alone() -> None:
    """Let crossed drums pass the angle from which on they have sides, where their distance jumps by 21 mm."""
    drum = {"shape": "drum", "diameter": 2.4, "height": 5.0}
    made = pair_of(drum, drum, line_stiffness=1e9, damping=1e-3, friction=0.3)
    built = np.array([block.centroid for block in made.blocks])
    for beyond in (0.0, 2e-16, 5e-16):
        state = SpatialState(*(np.zeros((2, 3)) for _ in range(4)))
        state.displacement[:] = np.array([[0.0, 0.0, HIGH], [2.395, 0.0, HIGH]]) - built
        state.rotation[1, 0], state.spin[1, 0] = math.acos(0.6) + beyond, -0.5  # 0.6: the cosine of that angle
        response = simulate(made, Motion.from_samples(0.01, np.zeros(11)), initial=state, settle=0.0)
        assert response.stats["steps"] < 1000  # measured 390; steps of no length before, until the work was too much
        assert response.gap[[0, -1], 0] == pytest.approx([0.0155, -0.005], abs=1e-4)


def on_strips(friction: float, blocks: int = 1) -> Structure:
    """Return a stack of stones 0.5 m wide and 1 m high, each on two strips of 20 mm at its edges."""
    names = [*(f"stone{k}" for k in range(blocks, 0, -1)), "base"]
    stones, strips = [], []
    for k, (name, under) in enumerate(itertools.pairwise(names)):
        level = float(blocks - 1 - k)
        place = {"position": [0.0, 0.0, level], "density": 2500.0}
        stones.append({"name": name, "shape": "box", "width": 0.5, "depth": 0.5, "height": 1.0, **place})
        for x in (-0.24, 0.24):
            law = {"stiffness": 5e10, "damping": 1e-3, "friction": friction if under == "base" else 0.6}
            section = {"section": "rectangle", "width": 0.02, "depth": 0.5}
            strips.append(
                {"between": [name, under], "at": [x, 0.0, level], "normal": [0.0, 0.0, 1.0], **section, **law}
            )
    return Structure.from_dict({"name": "strips", "block": stones, "joint": strips})


@pytest.mark.parametrize("blocks", [1, 2])
def test_a_block_that_slides_off_its_strips_is_named_with_its_depth(blocks: int) -> None:
    motion = wavelets.one_sine(0.35 * G, 1.0)
    with pytest.warns(InputWarning, match=r"stone1 and base pass into each other by [\d.]+ mm at .* slid until"):
        lost = simulate(on_strips(0.05, blocks), motion, settle=0.0)
    i = lost.model.names.index("stone1")
    sunk = -float(np.nanmin(lost.uz[:, i]))
    assert sunk > 0.05  # the block is not held by anything
    assert lost.overlap.depth == pytest.approx(sunk, rel=0.5)
    assert lost.overlap.depth >= sunk * (1.0 - 1e-6)
    with warnings.catch_warnings():
        warnings.simplefilter("error", InputWarning)
        assert simulate(on_strips(0.6, blocks), wavelets.one_sine(0.2 * G, 1.0), settle=0.0).overlap == Overlap()


def test_a_block_that_slides_off_its_strips_fails_a_check() -> None:
    plan = Plan(ensemble=1, margin=False)
    found = check(on_strips(0.05), {"pulse": wavelets.one_sine(0.35 * G, 1.0)}, plan=plan)
    (row,) = (row for row in found.rows if row.name == "overlap of blocks")
    assert (row.passes, row.where) == (False, "stone1, base")
    assert "slid off its faces" in row.note
