"""The table `neighbours` of a structure: which sides face each other, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT

from solver import Column, Motion, simulate
from solver.checks.of_structure import InSpace
from solver.common.errors import InputError
from solver.models.structure.blocks.parts import Side
from solver.models.structure.blocks.polyhedra import polyhedron_of
from solver.models.structure.blocks.shapes import prism
from solver.models.structure.file import in_space
from solver.models.structure.model import Structure
from solver.models.structure.modes import modes_in_space
from solver.models.structure.push import push_over
from solver.models.structure.run import SpatialState

DRUM = {"shape": "drum", "diameter": 1.0, "height": 2.0, "density": 2000.0}
BOX = {"width": 1.0, "depth": 1.5, "height": 2.0, "density": 2000.0}
LAW = {"reach": 0.5, "line_stiffness": 1e8, "stiffness": 1e9, "damping": 1e-3, "friction": 0.4}
WALL = {"at": [-0.7, 0.0, 0.0], "normal": [1.0, 0.0], "width": 2.0, "height": 3.0}


def described(*blocks: dict[str, Any], **neighbours: Any) -> dict[str, Any]:
    """Return a structure of blocks 1.2 m apart along x."""
    tables = [{"name": f"b{k}", "on": "base", "at": [1.2 * k, 0.0], **block} for k, block in enumerate(blocks)]
    table = {key: value for key, value in {**LAW, **neighbours}.items() if value is not None}
    return {"name": "row", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": tables, "neighbours": table}


def test_sides_that_face_each_other_are_found() -> None:
    made = Structure.from_dict(described(DRUM, DRUM, BOX, BOX, {**DRUM, "at": [1.2, 3.0]}))
    assert made.contact_names == ("b0-b1", "b1-b2", "b2-b3")
    assert [pair.gap for pair in made.neighbours] == pytest.approx([0.2, 0.2, 0.2], abs=1e-12)
    assert [pair.size for pair in made.neighbours] == pytest.approx([2.0, 2.0, 3.0], rel=1e-12)
    assert [isinstance(pair.side, Side) for pair in made.neighbours] == [True, True, False]
    assert Structure.from_dict(made.to_dict()).contact_names == made.contact_names
    assert Structure.from_dict(described(DRUM, DRUM, reach=0.1)).neighbours == ()


def test_drums_on_different_levels_face_each_other_where_both_are() -> None:
    plinth = {"width": 0.2, "depth": 0.2, "height": 1.5, "density": 2000.0}
    made = Structure.from_dict(described(DRUM, plinth, {**DRUM, "on": "b1", "at": [1.2, 0.0]}))
    (pair,) = made.neighbours
    assert pair.size == pytest.approx(0.5, rel=1e-12)


def test_gaps_and_laws_of_a_pair_replace_those_of_all() -> None:
    own = {"between": ["b1", "b0"], "gap": 0.05, "restitution": 0.5, "friction": 0.1}
    made = Structure.from_dict(described(DRUM, DRUM, DRUM, pair=[own]))
    first, second = made.neighbours
    assert (first.gap, first.friction) == (0.05, 0.1)
    assert first.farther == pytest.approx(-0.15, abs=1e-12)
    assert first.damping != second.damping == 1e-3
    far = {"between": ["b0", "b2"], "gap": 2.0}
    assert Structure.from_dict(described(DRUM, DRUM, DRUM, pair=[far])).contact_names == ("b0-b1", "b0-b2", "b1-b2")


def test_walls() -> None:
    made = Structure.from_dict(described(DRUM, BOX, wall=[WALL]))
    assert made.contact_names == ("b0-b1", "b0-wall 1")
    assert made.neighbours[1].gap == pytest.approx(0.2, abs=1e-12)
    assert made.is_plane
    turned = {**WALL, "normal": [1.0, 1.0], "at": [-0.7, -0.7, 0.0]}
    (_, pair) = Structure.from_dict(described(DRUM, BOX, wall=[turned])).neighbours
    assert pair.gap == pytest.approx(math.sqrt(0.98) - 0.5, rel=1e-12)


def test_a_rounded_survey_decides_neither_the_area_at_a_wall_nor_which_side_a_sheet_is_on() -> None:
    """Check a slab of 4 m, which may overlap a wall by 0.2 mm as built, and a sheet of 0.05 mm before one."""
    slab, law = {"width": 4.0, "depth": 0.3, "height": 0.25, "density": 2500.0}, {"restitution": 0.4, "damping": None}
    wall, pairs = {**WALL, "at": [0.0, 0.0, 0.0], "height": 6.0}, []
    for into in (0.0, 0.9e-4, 1.1e-4, 1.9e-4):
        made = Structure.from_dict(described({**slab, "at": [2.0 - into, 0.0]}, reach=None, wall=[wall], **law))
        pairs.append(made.neighbours[0])
    assert [pair.size for pair in pairs] == pytest.approx([0.075] * 4, rel=1e-9)
    assert [pair.damping for pair in pairs] == pytest.approx([pairs[0].damping] * 4, rel=1e-9)
    for thick in (1e-2, 1e-4, 5e-5):
        sheet = {"width": thick, "depth": 1.0, "height": 0.5, "density": 2500.0, "at": [0.002 + 0.5 * thick, 0.0]}
        (pair,) = Structure.from_dict(described(sheet, wall=[wall])).neighbours
        assert pair.gap == pytest.approx(0.002, rel=1e-9)
    behind = {"width": 5e-5, "depth": 1.0, "height": 0.5, "density": 2500.0, "at": [-0.001, 0.0]}
    assert Structure.from_dict(described(behind, wall=[wall])).neighbours == ()


def test_blocks_that_reach_into_a_wall_are_refused_and_those_behind_or_beside_it_are_not() -> None:
    """Compare with intervals along the normal and the width; of a turned box with its diagonal."""
    half, wide = 0.5 * BOX["width"], 1.0  # m
    diagonal = 0.5 * math.hypot(BOX["width"], BOX["depth"])
    for shape, reach in ((BOX, half), (DRUM, half), ({**BOX, "rotation": [0.0, 0.0, 0.5]}, None)):
        angle = math.atan2(BOX["depth"], BOX["width"])
        before = diagonal * math.cos(angle - 0.5) if reach is None else reach
        for into in (0.002, 0.3, 2.0 * before - 0.002):
            wall = {**WALL, "at": [into - before, 0.0, 0.0]}
            names, deep = "neighbours: b0 and wall 1 overlap by", f"{1e3 * into:.3g} mm as built, must stand apart$"
            # of the deepest an edge of the wall is nearer
            with pytest.raises(InputError, match=f"{names} {deep if into == 0.002 else ''}"):
                Structure.from_dict(described(shape, wall=[wall]))
        for place, count in ((-before, 1), (5e-5 - before, 1), (before, 0), (before + 0.1, 0)):
            wall = {**WALL, "at": [place, 0.0, 0.0]}
            made = Structure.from_dict(described(shape, reach=None, wall=[wall]))
            assert len(made.neighbours) == count
    for y, fits in ((wide + 0.751, True), (wide + 0.745, False), (-wide - 0.751, True)):
        wall = {**WALL, "at": [0.1, y, 0.0]}
        if fits:
            assert Structure.from_dict(described(BOX, wall=[wall])).neighbours == ()
            continue
        with pytest.raises(InputError, match="b0 and wall 1 overlap by 5 mm"):
            Structure.from_dict(described(BOX, wall=[wall]))
    above = {**WALL, "at": [0.1, 0.0, BOX["height"]]}
    assert Structure.from_dict(described(BOX, wall=[above])).neighbours == ()


@pytest.mark.parametrize(
    ("changed", "message"),
    [
        ({"reach": -1.0}, r"neighbours.reach = -1.0: must be a length in m"),
        ({"line_stiffness": None}, r"neighbours.line_stiffness: missing, must be .* N/m2.*: b0 and b1 may meet"),
        ({"stiffness": None}, r"neighbours.stiffness: missing, must be .* N/m3.*: b2 and b3 may meet"),
        ({"friction": None}, r"neighbours.friction: missing, must be a coefficient of friction"),
        ({"damping": None}, r"neighbours.damping: missing, must be .*, or a restitution"),
        ({"restitution": 0.5}, r"neighbours.restitution: must be left out beside damping"),
        ({"speed": 1.0}, r"neighbours.speed: unknown"),
        ({"pair": [{"between": ["b0", "b9"]}]}, r"neighbours.pair\[1\].between: 'b9' must be the name of a block"),
        (
            {"pair": [{"between": ["b0", "b1"], "gap": 0.1}, {"between": ["b1", "b0"], "gap": 0.2}]},
            r"neighbours.pair\[2\].between: is the pair of neighbours.pair\[1\], must be given once",
        ),
        ({"pair": [{"between": ["b0"]}]}, r"neighbours.pair\[1\].between = \['b0'\]: must be two names of blocks"),
        ({"pair": [{"between": ["b0", "b1"], "gap": -1}]}, r"neighbours.pair\[1\].gap = -1: must be a length in m"),
        ({"pair": {}}, r"neighbours.pair: must be one table \[\[neighbours.pair\]\] for each"),
        ({"wall": [{"at": [0.0, 0.0, 0.0]}]}, r"neighbours.wall\[1\].normal: missing, must be the direction"),
        ({"wall": [{**WALL, "normal": [0.0, 0.0]}]}, r"neighbours.wall\[1\].normal = .*: must have a length"),
        ({"wall": [{**WALL, "at": [0.0]}]}, r"neighbours.wall\[1\].at = \[0.0\]: must be the middle"),
    ],
)
def test_what_is_wrong_is_refused_in_one_line(changed: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        Structure.from_dict(described(DRUM, DRUM, BOX, BOX, **changed))


def test_pairs_with_a_joint_and_overlaps_are_refused() -> None:
    joined = described(DRUM, {**DRUM, "on": "b0", "at": [0.0, 0.0]}, pair=[{"between": ["b0", "b1"]}])
    with pytest.raises(InputError, match=r"neighbours.pair\[1\].between: must be two blocks without a joint"):
        Structure.from_dict(joined)
    with pytest.raises(InputError, match=r"neighbours: b0 and b1 overlap by 100 mm as built"):
        Structure.from_dict(described(DRUM, {**DRUM, "at": [0.9, 0.0]}))
    angle = 2.0 * math.pi * np.arange(100) / 100
    outline = np.column_stack([0.5 * np.cos(angle), 0.5 + 0.5 * np.sin(angle)]).tolist()
    coin = {"shape": "prism", "outline": outline, "depth": 0.1, "density": 2000.0}
    held = {"stiffness": 1e6, "tension_only": False, "from": [0.0, 0.0, 0.0], "to": [0.0, 0.0, -1.0]}
    data = described(coin, coin)
    data["block"] = [{"name": f"b{k}", **coin, "position": [0.0, 0.3 * k, 0.0]} for k in range(2)]
    data["tie"] = [{**held, "between": [f"b{k}", "base"]} for k in range(2)]
    assert Structure.from_dict(data).contact_names == ("b0-b1",)
    with pytest.raises(InputError, match=r"neighbours = 3: must be a table"):
        Structure.from_dict({**described(DRUM, DRUM), "neighbours": 3})


def test_one_stiffness_is_enough_where_no_sides_face_each_other() -> None:
    """Check a drum on a plinth beside a drum lower than it: the line over the radius, and the inverse."""
    plinth = {"width": 0.2, "depth": 0.2, "height": 2.2, "density": 2000.0}
    high = {**DRUM, "on": "b1", "at": [1.2, 0.0]}
    made = Structure.from_dict(described(DRUM, plinth, high, stiffness=None))
    pairs = dict(zip(made.contact_names, made.neighbours, strict=True))
    assert pairs["b0-b2"].body_stiffness == pytest.approx(1e8 / 0.5)
    assert pairs["b0-b2"].stiffness == 1e8
    boxes = Structure.from_dict(described(BOX, plinth, {**BOX, "on": "b1", "at": [1.2, 0.0]}, line_stiffness=None))
    assert {pair.stiffness for pair in boxes.neighbours} == {1e9}


def test_a_block_of_too_many_faces_is_refused() -> None:
    angle = 2.0 * math.pi * np.arange(127) / 127
    solid = prism("fine", np.column_stack([np.cos(angle), np.sin(angle)]), 1.0, 2000.0)
    with pytest.raises(InputError, match=r"block\[fine\]: 129 faces, must be 128 at most beside neighbours"):
        polyhedron_of(solid.faces, solid.centroid, "block[fine]")


def test_faces_of_100_corners_share_200() -> None:
    """Check two coins that come together turned by half a side bear there, where room was for 132.

    They part at half the speed, by the restitution, as do two of 16 sides.
    """
    speeds = {}
    for count in (16, 100):
        angle = 2.0 * math.pi * np.arange(count) / count
        outline = np.column_stack([0.5 * np.cos(angle), 0.5 + 0.5 * np.sin(angle)]).tolist()
        data = described(BOX, BOX, restitution=0.5, damping=None, friction=0.0)
        coin = {"shape": "prism", "outline": outline, "depth": 0.1}
        data["block"] = [
            {"name": "b0", **coin, "density": 12000.0, "position": [0.0, 0.0, 0.0]},
            {"name": "b1", **coin, "density": 500.0, "position": [0.0, 0.11, 0.0]},
        ]
        held = {"kind": "elastomeric", "diameter": 0.01, "vertical_damping": 0.0, "tension": True}
        held |= {"stiffness": 1.0, "damping": 0.0, "capacity": 1.0}
        at = [[-0.3, 0.05, 0.0], [0.3, 0.05, 0.0], [0.0, 0.0, 0.0], [0.0, 0.1, 0.0]]
        data["bearing"] = [
            {**held, "between": ["b0", "base"], "at": at, "vertical_stiffness": 1e7},
            {**held, "between": ["b1", "base"], "at": at, "vertical_stiffness": 1e5},
        ]
        begin = SpatialState(*np.zeros((4, 2, 3)))
        begin.rotation[1, 1], begin.velocity[1, 1] = math.pi / count, -1.0
        still = Motion.from_samples(1e-3, np.zeros(21))
        response = simulate(Structure.from_dict(data), still, 0.02, initial=begin)
        assert response.stats["without_room"] == 0
        speeds[count] = np.diff(response.uy[-2:, 1])[0] / np.diff(response.time[-2:])[0]
    # momentum of both masses, 24 and 1
    assert speeds[100] == pytest.approx((0.5 * 24.0 - 1.0) / 25.0, rel=0.01)
    assert speeds[16] == pytest.approx(speeds[100], rel=0.01)


def test_declared_gaps_move_the_contact() -> None:
    """Check that a drum taken to be nearer than it is meets as one that stands there."""
    for gap in (0.05, 0.4):
        made = Structure.from_dict(described(DRUM, DRUM, pair=[{"between": ["b0", "b1"], "gap": gap}]))
        pairs = made.model.names.pairs
        assert np.isclose(pairs.radius_a[0] + pairs.radius_b[0], 1.2 - gap, rtol=1e-12)


def test_studies_vary_numbers_of_neighbours() -> None:
    own = {"between": ["b0", "b1"], "gap": 0.05, "restitution": 0.5}
    made = Structure.from_dict(described(DRUM, DRUM, DRUM, pair=[own], wall=[WALL]))
    values = {"neighbours.pair[1].gap": (0.02, False), "neighbours.friction": (0.5, True)}
    assert all(made.kind.has_number(made, name) for name in values)
    changed = made.kind.with_numbers(made, values)
    assert [pair.gap for pair in changed.neighbours] == pytest.approx([0.02, 0.2, 0.2], abs=1e-12)
    assert {pair.friction for pair in changed.neighbours} == {0.2}
    every = made.kind.with_numbers(made, {"neighbours.pair.gap": (0.03, False)})
    assert [pair.gap for pair in every.neighbours] == pytest.approx([0.03, 0.2, 0.2], abs=1e-12)
    assert made.kind.numbers_of(made, "neighbours.pair.gap") == ["neighbours.pair[1].gap"]
    assert made.kind.numbers_of(made, "neighbours.friction") == ["neighbours.friction"]
    damped = made.kind.with_numbers(made, {"neighbours.pair[1].damping": (2e-3, False)})
    assert damped.neighbours[0].damping == 2e-3
    larger = made.kind.with_numbers(made, {"structure.size": (2.0, False)})
    assert [pair.gap for pair in larger.neighbours] == pytest.approx([0.1, 0.4, 0.4], abs=1e-12)
    with pytest.raises(InputError, match=r"neighbours.pair\[2\].gap: no such table"):
        made.kind.with_numbers(made, {"neighbours.pair[2].gap": (0.02, False)})
    apart = Structure.from_dict(described(DRUM, DRUM))
    with pytest.raises(InputError, match=r"neighbours.pair.gap: no such table"):
        apart.kind.with_numbers(apart, {"neighbours.pair.gap": (0.02, False)})
    with pytest.raises(InputError, match=r"neighbours.speed: unknown"):
        made.kind.with_numbers(made, {"neighbours.speed": (0.02, False)})


COLUMN = {
    "name": "shaft",
    "joint": {"stiffness": 1e9, "damping": 1e-3},
    "block": [{"height": 1.5, "width": 0.6, "depth": 0.6, "mass": 1500.0}] * 2,
    "neighbours": {**LAW, "wall": [{**WALL, "at": [-0.35, 0.0, 0.0], "height": 4.0}]},
}


def test_a_column_in_its_plane_meets_none_and_its_stack_does() -> None:
    with pytest.raises(InputError, match=r"neighbours: needs space, a column in its plane meets none: --space"):
        Column.from_dict(COLUMN)
    made = Structure.from_dict(in_space(COLUMN))
    assert made.contact_names == ("block1-wall 1", "block2-wall 1")
    assert [pair.gap for pair in made.neighbours] == pytest.approx([0.05, 0.05], abs=1e-12)
    assert Structure.from_dict(made.to_dict()).contact_names == made.contact_names
    values = {"neighbours.friction": (0.1, False), "column.size": (2.0, False), "joint.friction": (0.7, False)}
    assert all(made.kind.has_number(made, name) for name in values)
    changed = made.kind.with_numbers(made, values)
    assert [pair.gap for pair in changed.neighbours] == pytest.approx([0.1, 0.1], abs=1e-12)
    assert {pair.friction for pair in changed.neighbours} == {0.1}
    assert {joint.bed.friction for joint in changed.joints} == {0.7}


def test_a_stack_before_a_wall_is_not_run_as_a_column() -> None:
    """Shake it in its plane, where a stack without neighbours is left to its column, which would pass the wall."""
    made = Structure.from_toml(ROOT / "examples" / "structures" / "facade.toml")
    motion = Motion.harmonic(3.0, 1.5, 1.0)
    assert made.kind.equivalent_model(made, motion) is made
    response = simulate(made, motion, settle=0.0)
    assert response.peaks["hit"][1] > 1e3  # N, of the panel
    assert response.peaks["gap"][1] > -0.005  # m: it stays before the wall


def test_modes_are_those_of_blocks_that_stand_apart() -> None:
    """Compare to the last bit where gaps are open at rest; where two blocks touch there are none, and both are
    named.
    """
    data = described(DRUM, BOX)
    apart = Structure.from_dict(data)
    alone = Structure.from_dict({key: value for key, value in data.items() if key != "neighbours"})
    assert np.array_equal(modes_in_space(apart).frequency, modes_in_space(alone).frequency)
    touching = Structure.from_dict(described(DRUM, {**BOX, "at": [1.0, 0.0]}))
    with pytest.raises(InputError, match="row: b0 and b1 touch at rest, modes need a gap between them"):
        modes_in_space(touching)
    by_wall = Structure.from_dict(described(BOX, wall=[{**WALL, "at": [-0.5, 0.0, 0.0]}]))
    with pytest.raises(InputError, match="row: b0 and wall 1 touch at rest"):
        modes_in_space(by_wall)


def test_a_prop_below_a_beam_bears_its_part_of_the_weight_from_the_start() -> None:
    """Compare with springs in series: a prop that is 0.01 mm too short meets the beam as both settle."""
    size = {"width": 0.9, "depth": 0.9, "height": 4.0, "density": 2500.0, "on": "base"}
    beam = {"width": 3.9, "depth": 0.9, "height": 0.7, "density": 2500.0, "on": ["left", "right"], "at": [1.5, 0.0]}
    prop = {**size, "width": 0.5, "depth": 0.5, "height": 4.0 - 1e-5, "at": [1.5, 0.0]}
    blocks = [("left", {**size, "at": [0.0, 0.0]}), ("right", {**size, "at": [3.0, 0.0]}), ("beam", beam)]
    k = 2e9
    table = {
        "joints": {"stiffness": k, "damping": 1e-3, "friction": 0.7},
        "neighbours": {"stiffness": k, "restitution": 0.3, "friction": 0.5},
        "block": [{"name": name, **one} for name, one in [*blocks, ("prop", prop)]],
    }
    propped = Structure.from_dict({"name": "propped", **table})
    g = propped.g
    # settlements apart, less the gap, over the compliances of prop, contact and beam on its columns
    settled = 2500.0 * g * (3.9 * 0.9 * 0.7 / (0.81 * k) + 4.0 / k - (4.0 - 1e-5) / k) - 1e-5
    force = settled / (2.0 / (0.25 * k) + 1.0 / (0.81 * k))
    still = Motion.from_samples(0.1, [0.0] * 11)
    found = simulate(propped, still, settle=0.0)
    bears = found.N[:, list(found.model.joint_names).index("prop-base")]
    expected = 2500.0 * 0.25 * (4.0 - 1e-5) * g + force
    assert bears[0] == pytest.approx(expected, rel=1e-5)  # measured 2e-6: the law of cells counts the overlap
    np.testing.assert_allclose(bears, bears[0], rtol=1e-10)  # measured 3e-12: it stays at rest
    assert push_over(propped).N[0].tolist() == pytest.approx(found.N[0].tolist(), rel=1e-9)


def squeezed(shape: dict[str, Any], *, wall: bool = False) -> Structure:
    """Return three blocks in a row whose outer ones ties pull together, or one that a tie pulls against a wall."""
    size = {"height": 2.0, "density": 2500.0, "on": "base", **shape}
    law: dict[str, Any] = {"stiffness": 1e9, "restitution": 0.5, "friction": 0.4}
    table: dict[str, Any] = {"joints": {"stiffness": 1e9, "damping": 2e-3, "friction": 0.5}, "neighbours": law}
    names = ["a"] if wall else ["a", "b", "c"]
    table["block"] = [{"name": name, "at": [float(k), 0.0], **size} for k, name in enumerate(names)]
    if wall:
        law["wall"] = [{"at": [0.25, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 3.0}]
        tie = {"between": ["a", "base"], "from": [0.25, 0.0, 0.9], "to": [1.5, 0.0, 1.9], "stiffness": 1e6}
        table["tie"] = [{**tie, "pretension": 1e4}]
    else:
        law |= {"line_stiffness": 1e8, "reach": 0.3} if "shape" in shape else {}
        tie = {"between": ["a", "c"], "stiffness": 1e7, "pretension": 2e4}
        table["tie"] = [{**tie, "from": [0.5, y, 0.9], "to": [-0.5, y, 0.9]} for y in (0.3, -0.3)]
    return Structure.from_dict({"name": "squeezed", **table})


@pytest.mark.parametrize(
    ("shape", "wall"),
    [
        ({"shape": "drum", "diameter": 1.0}, False),
        ({"width": 1.0, "depth": 1.0}, False),  # aligned faces: each sideways motion makes less area press
        ({"width": 0.5, "depth": 1.0}, True),  # it tips over without the wall
    ],
)
def test_blocks_that_ties_press_together_rest(shape: dict[str, Any], wall: bool) -> None:
    """Check the balance of the first block, and that a run on a still base stays there."""
    structure = squeezed(shape, wall=wall)
    found = simulate(structure, Motion.from_samples(0.1, [0.0] * 6), settle=0.0)
    pair = list(structure.contact_names).index("a-wall 1" if wall else "a-b")
    pulled, pressed = np.sum(found.tie[0]), found.hit[0, pair]
    assert pressed > 0.9 * pulled > 1e4 * (0.8 if wall else 2.0)
    assert pressed == pytest.approx(pulled + abs(found.Tx[0, 0]), rel=1e-3)
    np.testing.assert_allclose(found.hit, np.broadcast_to(found.hit[0], found.hit.shape), rtol=1e-6, atol=1e-3)


def test_the_first_period_of_a_check_is_that_in_contact() -> None:
    """Check what stands by its wall alone, and three blocks against the run after a small pulse across their row."""
    assert 0.0 < InSpace(squeezed({"width": 0.5, "depth": 1.0}, wall=True)).period < 0.1
    structure = squeezed({"width": 1.0, "depth": 1.0})
    time, none = np.arange(0.0, 1.0, 0.002), np.zeros(500)
    pulse = Motion(time, none, none, float(time[-1]), ay=np.where((time > 0.01) & (time < 0.03), 0.02, 0.0))
    run = simulate(structure, pulse, settle=0.0, output_step=0.002, tolerance=1e-7)
    moved = np.diff(run.uy[30:430, 0])
    spectrum = np.abs(np.fft.rfft(moved * np.hanning(len(moved)), 2**16))
    found = np.fft.rfftfreq(2**16, 0.002)[np.argmax(spectrum)]
    assert 1.0 / InSpace(structure).period == pytest.approx(found, rel=0.02)  # apart it is 5.8 Hz, not 16.3


def test_a_drum_that_is_pushed_against_a_wall_leans_as_in_a_slow_motion() -> None:
    wall = [{"at": [0.5001, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 3.0}]
    law = {"reach": 0.3, "line_stiffness": 1e8, "stiffness": 1e9, "restitution": 0.5, "friction": 0.0}
    drum = {"name": "a", "on": "base", "shape": "drum", "diameter": 1.0, "height": 2.0, "density": 2000.0}
    joints = {"stiffness": 1e9, "damping": 2e-3}
    near = Structure.from_dict({"name": "near", "joints": joints, "neighbours": {**law, "wall": wall}, "block": [drum]})
    found = push_over(near)
    ramp = Motion.from_samples(1.0, [0.0, -5.0, -5.0])
    run = simulate(near, ramp, settle=0.0)
    pushed = np.interp(5.0, found.acceleration, found.hit[:, 0])
    assert pushed == pytest.approx(run.hit[-1, 0], rel=1e-2)  # measured 1e-3


def test_the_estimated_error_of_a_gap_is_a_length() -> None:
    """Check it against the difference of both runs; relative to a gap below 0 it would be negative, and large."""
    block = {"on": "base", "width": 0.6, "depth": 0.6, "height": 2.4, "density": 2500.0}
    blocks = [{**block, "name": "a", "at": [0.0, 0.0]}, {**block, "name": "b", "at": [0.62, 0.0], "height": 1.2}]
    rub = {"stiffness": 1e8, "restitution": 0.3, "friction": 0.4}
    law = {"stiffness": 1e9, "damping": 2e-3, "friction": 0.6}
    structure = Structure.from_dict({"name": "row", "joints": law, "neighbours": rub, "block": blocks})
    motion = Motion.harmonic(0.4 * 9.80665, 1.5, 0.8)
    found = simulate(structure, motion, settle=0.0, check=True, tolerance=1e-4)
    closer = simulate(structure, motion, settle=0.0, tolerance=1e-5)
    assert found.peaks["gap"][0] < -1e-4  # m: they press on each other
    assert found.estimated_error is not None
    assert found.estimated_error.peaks["gap"] == pytest.approx(np.abs(found.peaks["gap"] - closer.peaks["gap"]))
    assert 0.0 <= found.estimated_error.peaks["gap"][0] < 1e-5
