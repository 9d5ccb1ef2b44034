"""Structures: files, messages, builders, faces, rest, modes, responses, the command."""

from __future__ import annotations

import copy
import math
import multiprocessing
import re
import tomllib
from concurrent.futures import ProcessPoolExecutor
from contextlib import nullcontext
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image
from scipy.spatial import ConvexHull
from support.fmus import ROOT
from support.probe import G, random_column
from support.structures import MODULUS, run, stack, with_law

from multiblock import (
    Column,
    InputError,
    Motion,
    SpatialState,
    Spread,
    Structure,
    arch,
    colonnade,
    modes_in_space,
    simulate,
    simulate_many,
    wall,
)
from solver.commands.command_line import main
from solver.models.outputs import places_of
from solver.models.structure.blocks import contacts, faces
from solver.models.structure.blocks.faces import clipped, polygon_moments
from solver.models.structure.blocks.outlines import corners_around
from solver.models.structure.blocks.shapes import rotation_matrix
from solver.models.structure.outputs import OUTPUTS
from solver.models.structure.rest import rest_of
from solver.models.structure.stepper import SpatialStepper
from solver.models.uncertainty import vary

LAW = {"stiffness": 2e9, "damping": 1e-3, "friction": 0.7}
EXAMPLES = sorted((ROOT / "examples" / "structures").glob("*.toml"))
TRILITH: dict[str, Any] = {
    "name": "trilith",
    "joints": LAW,
    "block": [
        {"name": "left", "on": "base", "width": 0.9, "depth": 0.9, "height": 4.0, "density": 2500.0},
        {"name": "right", "on": "base", "at": [3.0, 0.0], "width": 0.9, "depth": 0.9, "height": 4.0, "density": 2500.0},
        {
            "name": "beam",
            "on": ["left", "right"],
            "at": [1.5, 0.0],
            "width": 3.9,
            "depth": 0.9,
            "height": 0.7,
            "mass": 6e3,
        },
    ],
}
PATCH: dict[str, Any] = {"between": ["left", "base"], "at": [0.0, 0.0, 0.0], "width": 0.5, "depth": 0.5}
DRUM: dict[str, Any] = {
    "name": "left",
    "on": "base",
    "shape": "drum",
    "diameter": 0.9,
    "height": 4.0,
    "density": 2500.0,
}
PRISM: dict[str, Any] = {"name": "left", "on": "base", "shape": "prism", "depth": 0.9, "density": 2500.0}
STAR = [[math.cos(0.8 * math.pi * k), math.sin(0.8 * math.pi * k)] for k in range(5)]  # turns around twice


def test_a_rest_is_found_in_one_step_where_four_get_stuck() -> None:
    """Check a colonnade with moduli that vary by 20 %, as checks draw them: all joints together bear the weight."""
    colonnade = Structure.from_toml(ROOT / "examples" / "structures" / "colonnade.toml")
    rng, pulse = np.random.default_rng([0, 0]), Motion.harmonic(1.0, 1.0, 1.0)
    _, (varied, _) = (vary(colonnade, pulse, Spread(0.2, 0.5, 0.01), rng) for _ in range(2))
    rest = rest_of(varied)
    assert rest.row[-4] == pytest.approx(-varied.weight, rel=1e-9)
    n = varied.n
    moved, usual = rest.row[: 3 * n], rest_of(colonnade).row[: 3 * n]
    assert np.max(np.abs(moved - usual)) < 0.2 * np.max(np.abs(usual))  # measured: 0.08


@pytest.mark.parametrize("friction", [0.6, None])
@pytest.mark.parametrize("section", ["rectangle", "circle"])
@pytest.mark.parametrize(
    "moduli", [[2e9, 3e15, 2e9], [2e9, 2e19, 2e9], [1e18, 2e9, 2e9], [2e9, 1e16, 3e9, 1e17, 2e9], [1e8, 1e20, 1e8]]
)
def test_a_stiff_joint_between_others_rests(moduli: list[float], section: str, friction: float | None) -> None:
    """Check springs on each other, each under the weight of what is above it."""
    pile = stack(len(moduli), section)
    beds = [replace(joint.bed, stiffness=k, friction=friction) for joint, k in zip(pile.joints, moduli, strict=True)]
    pile = replace(pile, joints=tuple(replace(j, bed=bed) for j, bed in zip(pile.joints, beds, strict=True)))
    borne = G * 27000.0 * np.arange(len(moduli), 0, -1)
    settled = -np.cumsum(borne / (np.array(moduli) * pile.joints[0].face.moments[0]))
    rest = rest_of(pile)
    stepper = SpatialStepper(pile)
    stepper.phase[:] = rest.phase
    stepper.observe()
    # by rounding of places, of those with a joint of 1e20 N/m3 beside 1e8; measured 1.3e-5 and 3e-4
    assert stepper.see.uz == pytest.approx(settled, rel=5e-5)
    assert stepper.row[places_of(OUTPUTS, pile.sizes)["N"]] == pytest.approx(borne, rel=1e-3)


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("name", ["arch", "trilith"])
def test_a_rest_hardly_changes_once_a_joint_is_stiff(name: str) -> None:
    """Check that it changes by its modulus to the power -1: each joint alone of a structure that is statically
    indeterminate.
    """
    structure = Structure.from_toml(ROOT / "examples" / "structures" / f"{name}.toml")
    for one in range(len(structure.joints)):
        rests = []
        for modulus in (1e13, 1e14, 1e16):
            beds = [replace(j.bed, stiffness=modulus) if i == one else j.bed for i, j in enumerate(structure.joints)]
            made = replace(
                structure, joints=tuple(replace(j, bed=bed) for j, bed in zip(structure.joints, beds, strict=True))
            )
            rests.append(rest_of(made).row[: 3 * made.n])
        size, changed = np.max(np.abs(rests[-1])), [float(np.max(np.abs(rest - rests[-1]))) for rest in rests]
        assert changed[1] < 2e-4 * size  # measured 1e-4
        assert changed[1] == pytest.approx(0.1 * changed[0], rel=0.1)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_examples_stand(path: Path) -> None:
    structure = Structure.from_toml(path)
    rest = rest_of(structure)
    assert rest.row[-4] == pytest.approx(-structure.weight, rel=1e-9)  # Fz on the base


WRONG = [
    (("block", 0, "width"), -1.0, "block[1].width = -1.0"),
    (("block", 0, "on"), "nothing", "block[1].on = 'nothing': must be one of base"),
    (("block", 1, "name"), "left", "block[2].name = 'left'"),
    (("block", 2, "at"), [1.5, 9.0], "block[3].on: beam and left share no face"),
    (("block", 0, "hight"), 1.0, "block[1].hight: unknown key"),
    (("block", 0, "density"), None, "block[1].density: must be given"),
    (("joints", "stiffness"), None, "block[1].joint.stiffness: missing"),
    (("joints", "shear_ratio"), 0.0, "joints.shear_ratio = 0.0"),
    (("block", 0, "shape"), "ball", "block[1].shape = 'ball'"),
    (("block", 0, "mass"), 1.0, "block[1].density: must be given"),
    (("tie",), [{"between": ["left", "left"], "from": [0, 0, 0], "to": [0, 0, 0], "stiffness": 1.0}], "two different"),
    (("tie",), [{"between": ["left", "base"], "from": [0, 0, 0], "stiffness": 1.0}], "tie[1].to: missing"),
    (
        ("tie",),
        [{"between": ["left", "base"], "from": [0, 0, -2], "to": [0, 0, 0], "stiffness": 1.0}],
        "tie[1].to: is the",
    ),
    (("joint",), [{"between": ["left", "right"]}], "joint[1]: left and right share no face"),
    (("solver",), {"tolerance": 2.0}, "solver.tolerance = 2.0"),
    (("solver",), {"without": 5}, "solver.without = 5: must be a list"),
    (("block", 0, "on"), 5, "block[1].on = 5: must be base"),
    (("block", 0, "on"), ["base", "base"], "block[1].on: names base twice"),
    (("joint",), [{"between": ["beam", "left"]}], "joint[1]: the contact of left and beam counts twice"),
    (("joint",), [{"between": ["left", "base"], "width": 1.0}], "joint[1].width: must be left out, or at given"),
    (("joint",), [{**PATCH, "section": "circle", "diameter": 0.5}], "joint[1].width: must be left out, a circle has"),
    (("joint",), [{**PATCH, "at": [0.0, 0.0, -5.0]}], "joint[1].at: is 5 m away from left"),
    (("joint",), [{"between": ["left", "base"], "at": [0.0, 0.0, 0.1]}], "joint[1]: left and base share no face"),
    (("block", 1, "at"), [0.0, 0.0], "block[2]: right fills the same place as left"),
    (("block", 1, "at"), [1e308, 0.0], "block[2].at[0] = 1e+308: must be a length"),
    (("block", 0, "rotation"), [0.0, 0.0, 90.0], "block[1].rotation[2] = 90.0: must be an angle in rad"),
    (("block", 0), {**DRUM, "bore": ""}, "block[1].bore = ''"),
    (("block", 0), {**DRUM, "bore": False}, "block[1].bore = False"),
    (("block", 0), {**DRUM, "repeat": 999}, "block: 1001 blocks"),
    (("block", 0), {**PRISM, "outline": [[0, 0], [1, 0], [2, 0]]}, "block[1].outline: has no area"),
    (("block", 0), {**PRISM, "outline": STAR}, "block[1].outline: is not convex"),
    (("block", 0), {**PRISM, "outline": [[0, 0], [1, 0], [0, 0]]}, "block[1].outline: 2 corners"),
    (("block", 0), {**PRISM, "outline": [[0, 0]] * 5000}, "block[1].outline: 5000 corners"),
    (("block", 0), {**PRISM, "outline": [[1e5, 0], [1e5 + 1, 0], [1e5, 1]]}, "block[1].outline: lies farther"),
]


@pytest.mark.parametrize(("count", "friction", "taken"), [(100, 0.3, True), (101, 0.3, False), (101, None, True)])
def test_sections_of_joints_that_may_slide_have_100_corners(count: int, friction: float | None, taken: bool) -> None:
    """Refuse more: after a twist two outlines share up to twice as many, for which the kernels have room."""
    turns = 2.0 * np.pi * np.arange(count) / count
    outline = 0.4 * np.column_stack([np.cos(turns), np.sin(turns)])
    joint = {"between": ["b", "base"], "at": [0.0] * 3, "section": "polygon", "outline": outline.tolist()}
    block = {"name": "b", "position": [0.0] * 3, "width": 1.0, "depth": 1.0, "height": 1.0, "mass": 1e3}
    law = {"stiffness": 1e9, "damping": 1e-3, **({} if friction is None else {"friction": friction})}
    with nullcontext() if taken else pytest.raises(InputError, match="101 corners, must be 100 at most"):
        Structure.from_dict({"name": "a", "joints": law, "block": [block], "joint": [joint]})


def test_an_outline_may_end_where_it_begins() -> None:
    corners = [[-1.0, 0.0], [1.0, 0.0], [1.0, 2.0]]
    data = {"name": "prism", "joints": LAW, "block": [{**PRISM, "outline": corners}]}
    closed = {**data, "block": [{**PRISM, "outline": [*corners, corners[0]]}]}
    assert Structure.from_dict(closed).weight == Structure.from_dict(data).weight


@pytest.mark.parametrize("word", ["joints", "tie"])
def test_a_table_of_structures_in_the_file_of_a_column_is_named(word: str) -> None:
    data: dict[str, Any] = {"name": "pillar", "block": [{"width": 1.0, "depth": 1.0, "height": 2.0, "density": 2e3}]}
    with pytest.raises(InputError, match=f"^{word}: is of a structure, whose blocks have on or position"):
        Structure.from_dict(data | {word: {"joints": LAW, "tie": []}[word]})


def test_two_joints_of_a_pair_at_different_places_are_two() -> None:
    pads = [{**PATCH, "between": ["beam", "left"], "at": [x, 0.0, 4.0], "width": 0.2} for x in (-0.2, 0.2)]
    data = copy.deepcopy(TRILITH) | {"joint": pads}
    data["block"][2] |= {"on": ["right"], "position": [1.5, 0.0, 4.0]}
    del data["block"][2]["at"]
    assert len(Structure.from_dict(data).joints) == 5
    pads[1]["at"] = [-0.1, 0.0, 4.0]
    with pytest.raises(InputError, match="counts twice"):
        Structure.from_dict(data)


@pytest.mark.parametrize(
    ("make", "line"),
    [
        (lambda: colonnade(10**7, 3, 3.0, 1.0, 4.0, LAW), "columns = 10000000"),
        (lambda: colonnade(500, 500, 3.0, 1.0, 4.0, LAW), "block: 250499 blocks"),
        (lambda: colonnade(3, 3, "3", 1.0, 4.0, LAW), "spacing = '3'"),  # type: ignore[arg-type]
        (lambda: colonnade(3, 3, 3.0, 1.0, 4.0, 5), "joint = 5"),  # type: ignore[arg-type]
        (lambda: colonnade(3, 3, 3.0, 1.0, 4.0, LAW, architrave=5), "architrave = 5"),  # type: ignore[arg-type]
        (lambda: arch(9, None, 1.0, 1.0, LAW), "radius = None"),  # type: ignore[arg-type]
        (lambda: arch(1, 5.0, 1.0, 1.0, LAW), "voussoirs = 1"),
        (lambda: wall(4, 4, (0.6, 0.3), LAW), "block = (0.6, 0.3)"),  # type: ignore[arg-type]
        (lambda: wall(1000, 1000, (0.6, 0.3, 0.3), LAW), "block: 1000500 blocks"),
    ],
)
def test_builders_name_a_wrong_value(make: Any, line: str) -> None:
    with pytest.raises(InputError) as error:
        make()
    assert str(error.value).startswith(line)


def test_only_faces_that_look_at_each_other_are_compared(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check that two prisms of 100 corners have 10404 pairs of faces, of which 204 may touch."""
    turns = np.linspace(0.0, 2.0 * math.pi, 100, endpoint=False) - 0.5 * math.pi - math.pi / 100
    outline = np.column_stack([np.cos(turns), np.sin(turns) - np.min(np.sin(turns))])
    block = {**PRISM, "outline": outline.tolist()}
    data = {"name": "rollers", "joints": LAW, "block": [{**block, "name": "a"}, {**block, "name": "b", "on": "a"}]}
    compared = []
    shared = faces.shared
    monkeypatch.setattr(contacts, "shared", lambda *of: compared.append(of) or shared(*of))  # type: ignore[func-returns-value]
    assert len(Structure.from_dict(data).joints) == 2
    assert len(compared) < 1000  # measured: 608, those that differ by 8 degrees included


@pytest.mark.parametrize(("place", "value", "line"), WRONG)
def test_wrong_values_are_named_in_one_line(place: tuple[Any, ...], value: Any, line: str) -> None:
    data = copy.deepcopy(TRILITH)
    table: Any = data
    for key in place[:-1]:
        table = table[key]
    if value is None:
        del table[place[-1]]
    else:
        table[place[-1]] = value
    with pytest.raises(InputError) as error:
        Structure.from_dict(data)
    assert line in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("word", "value"),
    [("stiffness", "soft"), ("damping", -5), ("friction", [1]), ("rim", 0.0), ("tensile_strength", "1e5")],
)
@pytest.mark.parametrize("key", ["joints", "joint", "block[1].joint"])
def test_a_law_that_no_joint_uses_is_checked(key: str, word: str, value: Any) -> None:
    """Check the defaults where every joint has keys of its own, and the law of a block that stands on nothing."""
    block = {"name": "a", "width": 0.5, "depth": 0.5, "height": 2.0, "density": 2000.0}
    own = {**LAW, "friction": 0.5, word: value if key == "block[1].joint" else 0.1}
    data: dict[str, Any] = {"name": "t", "block": [block | {"on": "base", "joint": {**LAW, "friction": 0.5}}]}
    if key == "block[1].joint":
        joint = {"between": ["a", "base"], **LAW}
        data |= {"block": [block | {"position": [0.0, 0.0, 0.0], "joint": own}], "joint": [joint]}
    else:
        data[key] = {word: value}
    with pytest.raises(InputError) as error:
        Structure.from_dict(data)
    assert str(error.value).startswith(f"{key}.{word} = {value!r}: must be ")


def test_defaults_of_joints_are_checked_beside_bearings_alone() -> None:
    path = next((ROOT / "examples" / "bearings").glob("pendulum*.toml"))
    data = tomllib.loads(path.read_text(encoding="utf-8"))
    assert "joint" not in data
    with pytest.raises(InputError, match=r"^joints\.damping = -5: must be "):
        Structure.from_dict({**data, "joints": {"damping": -5}})


BOX = {"name": "a", "width": 0.5, "depth": 0.4, "height": 2.0, "density": 2000.0, "position": [0.0, 0.0, 0.0]}
TURNED = {**BOX, "rotation": [0.0, 0.0, 0.25 * math.pi]}
UPRIGHT = {"name": "a", "shape": "drum", "diameter": 0.5, "height": 1.0, "density": 2000.0, "position": [0.0, 0.0, 0.0]}
WEDGE = {"name": "a", "shape": "prism", "depth": 1.0, "density": 2000.0, "position": [0.0, 0.0, 0.0]}
WEDGE["outline"] = [[0.0, 0.0], [1.0, 0.5], [0.8, 1.5], [-0.2, 1.0]]
RECTANGLE, CIRCLE = {"section": "rectangle", "depth": 0.4}, {"section": "circle"}
DIAGONAL = 0.9 * math.sqrt(0.5)  # m, the extent of the turned box along x: (0.5 + 0.4) / sqrt(2)


@pytest.mark.parametrize(
    ("block", "section", "beyond", "wide"),
    [
        (BOX, {**RECTANGLE, "width": 0.5}, 0.0, 0.0),
        (BOX, {**RECTANGLE, "width": 0.3, "at": [0.1, 0.0, 0.0]}, 0.0, 0.0),
        (BOX, {**RECTANGLE, "width": 0.5, "at": [0.0, 0.0, 1.0]}, 0.0, 0.0),
        (BOX, {**RECTANGLE, "width": 5.0}, 2.25, 0.5),
        (BOX, {**RECTANGLE, "width": 0.501}, 0.0005, 0.5),
        (BOX, {**RECTANGLE, "width": 0.5, "at": [0.2, 0.0, 0.0]}, 0.2, 0.5),
        (BOX, {**RECTANGLE, "width": 0.5, "depth": 0.6}, 0.1, 0.4),
        (BOX, {**CIRCLE, "diameter": 0.4}, 0.0, 0.0),
        (BOX, {**CIRCLE, "diameter": 0.5}, 0.05, 0.4),
        (BOX, {"section": "ring", "diameter": 0.6, "bore": 0.2}, 0.1, 0.4),
        (BOX, {"section": "polygon", "outline": [[0.0, -0.2], [0.25, 0.2], [-0.25, 0.2]]}, 0.0, 0.0),
        (BOX, {"section": "polygon", "outline": [[0.0, -0.2], [0.35, 0.2], [-0.25, 0.2]]}, 0.1, 0.5),
        (TURNED, {**RECTANGLE, "width": DIAGONAL, "depth": 0.01}, 0.025 + 0.005 * math.sqrt(0.5), 0.4),
        (TURNED, {**RECTANGLE, "width": 0.2, "depth": 0.2}, 0.0, 0.0),
        (UPRIGHT, {**CIRCLE, "diameter": 0.5}, 0.0, 0.0),
        (UPRIGHT, {**CIRCLE, "diameter": 0.5, "at": [0.05, 0.0, 0.0]}, 0.05, 0.5),
        (UPRIGHT, {**RECTANGLE, "width": 0.3, "depth": 0.4}, 0.0, 0.0),
        (UPRIGHT, {**RECTANGLE, "width": 0.5, "depth": 0.5}, 0.25 * (math.sqrt(2.0) - 1.0), 0.5),
        # the top of a tapered box, and its outline below
        ({**BOX, "top_width": 0.2}, {**RECTANGLE, "width": 0.4, "at": [0.0, 0.0, 2.0]}, 0.1, 0.2),
        ({**BOX, "top_width": 0.2}, {**RECTANGLE, "width": 0.4, "at": [0.0, 0.0, 0.5]}, 0.0, 0.0),
        # the lower side of a wedge, from (0, 0) to (1, 0.5), of length 1.118 m
        (WEDGE, {**RECTANGLE, "width": 1.118, "at": [0.5, 0.0, 0.25], "normal": [-0.5, 0.0, 1.0]}, 0.0, 0.0),
        (WEDGE, {**RECTANGLE, "width": 1.5, "at": [0.5, 0.0, 0.25], "normal": [-0.5, 0.0, 1.0]}, 0.191, 1.118),
    ],
)
def test_a_section_lies_on_its_block(
    block: dict[str, Any], section: dict[str, Any], beyond: float, wide: float
) -> None:
    """Compare with lengths by hand: by how much it reaches beyond the block, and the block's width there."""
    joint = {"between": ["a", "base"], "at": [0.0, 0.0, 0.0], **section}
    data = {"name": "t", "joints": LAW, "block": [block], "joint": [joint]}
    if not beyond:
        assert len(Structure.from_dict(data).joints) == 1
        return
    said = r"joint\[1\]\.section: is \S+ m wide and reaches (\S+) m beyond a, which is (\S+) m wide there, .* lie on it"
    with pytest.raises(InputError, match=f"^{said}$") as caught:
        Structure.from_dict(data)
    found = re.fullmatch(said, str(caught.value))
    assert found is not None
    assert [float(found[1]), float(found[2])] == pytest.approx([beyond, wide], rel=1e-3)


def test_a_section_lies_on_both_blocks() -> None:
    lower = {**BOX, "name": "low", "width": 0.3, "height": 1.0, "on": "base"}
    del lower["position"]
    joint = {"between": ["a", "low"], "at": [0.0, 0.0, 1.0], **RECTANGLE, "width": 0.3}
    data = {"name": "t", "joints": LAW, "block": [lower, {**BOX, "position": [0.0, 0.0, 1.0]}], "joint": [joint]}
    assert len(Structure.from_dict(data).joints) == 2
    joint["width"] = 0.5
    with pytest.raises(InputError, match=r"^joint\[1\]\.section: is 0\.5 m wide and reaches 0\.1 m beyond low, which"):
        Structure.from_dict(data)


@pytest.mark.parametrize("turn", [0.0, 0.3, 1.0])
def test_the_hull_of_points_in_a_plane_is_that_of_qhull(turn: float) -> None:
    """Compare areas; corners that coincide but for rounding, as those of the faces of a block, are one."""
    grid = np.array([[x, y] for x in (-0.5, 0.0, 0.5) for y in (-0.2, 0.0, 0.2)] * 3)
    cloud = np.random.default_rng(1).standard_normal((200, 2))
    axes = np.array([[math.cos(turn), -math.sin(turn)], [math.sin(turn), math.cos(turn)]])
    for points in (grid @ axes + 1e-17, cloud @ axes):
        found = points[corners_around(points)]
        assert polygon_moments(found)[0] == pytest.approx(ConvexHull(points).volume, rel=1e-12)


def test_a_block_that_nothing_holds_is_refused() -> None:
    data = copy.deepcopy(TRILITH)
    data["block"].append({**data["block"][0], "name": "far", "position": [9.0, 0.0, 9.0]})
    del data["block"][-1]["on"]
    with pytest.raises(InputError, match="'far': must be joined to the base"):
        Structure.from_dict(data)


def test_a_rest_that_is_not_stable_is_refused() -> None:
    tall = {"name": "t", "on": "base", "width": 0.1, "depth": 0.1, "height": 50.0, "density": 2500.0}
    soft = Structure.from_dict({"name": "tall", "joints": {"stiffness": 1e7, "damping": 0.0}, "block": [tall]})
    with pytest.raises(InputError, match=r"^tall: (its rest is not stable|no rest)"):
        rest_of(soft)


def test_polygons_share_what_monte_carlo_says() -> None:
    rng = np.random.default_rng(3)
    square = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    for _ in range(5):
        angle = rng.uniform(0.0, 1.5)
        turn = np.array([[math.cos(angle), -math.sin(angle)], [math.sin(angle), math.cos(angle)]])
        other = 0.9 * square @ turn.T + rng.uniform(-0.7, 0.7, 2)
        points = rng.uniform(-1.0, 1.0, (40000, 2))
        local = (points - other.mean(axis=0)) @ turn / 0.9
        inside = np.all(np.abs(local) <= 1.0, axis=1)
        # 40000 points: one standard deviation is 0.005 of the square's 4 m2
        assert polygon_moments(clipped(other, square))[0] == pytest.approx(4.0 * inside.mean(), abs=0.08)


def test_turned_structure_answers_turned() -> None:
    """Check that the same blocks and motion turned about the vertical axis move the same, turned."""
    angle = 0.7
    turn = rotation_matrix(np.array([0.0, 0.0, angle]))
    found = []
    for rotated in (False, True):
        data = copy.deepcopy(TRILITH)
        for block in data["block"]:
            x, y = block.get("at", [0.0, 0.0])
            z = 4.0 if block["name"] == "beam" else 0.0
            place = np.array([x, y, z])
            block["position"] = (turn @ place if rotated else place).tolist()
            block["rotation"] = [0.0, 0.0, angle if rotated else 0.0]
            block.pop("at", None)
        structure = Structure.from_dict(data).with_settings(tolerance=1e-8)
        motion = Motion.harmonic(0.22 * G, 1.4, 1.0, direction=0.3 + (angle if rotated else 0.0))
        response = run(structure, motion)
        moved = response.displacement("beam", (1.95, 0.45, 0.35))
        found.append(moved @ turn if rotated else moved)
    # measured 4e-8 of the peak
    assert np.max(np.abs(found[0] - found[1])) <= 1e-6 * np.max(np.abs(found[0]))


def test_colonnade_arch_and_wall_stand() -> None:
    structures = (
        colonnade(3, 4, 3.0, 1.0, 4.0, LAW, top_diameter=0.8, tie={"stiffness": 1e7}),
        arch(9, 5.0, 1.0, 1.0, {"stiffness": 1e10, "damping": 1e-3}),
        wall(4, 4, (0.6, 0.3, 0.3), LAW),
    )
    for structure in structures:
        assert structure.is_plane
        assert rest_of(structure).row[-4] == pytest.approx(-structure.weight, rel=1e-9)
    assert len(structures[0].ties) == 1
    assert len(structures[2].joints) == 4 + 2 * (8 + 0) + 8 + 3 + 4 + 3 + 4


@pytest.mark.parametrize("rim", [{}, {"rim": 0.1}], ids=["faces", "rims"])
@pytest.mark.parametrize("angle", [math.pi, 2.6])
def test_an_arch_that_has_slid_bears_as_at_its_place(angle: float, rim: dict[str, float]) -> None:
    """Move it by a quarter of its depth: the base goes on beyond the springers, so nothing else changes."""
    made = arch(7, 2.0, 0.6, 0.8, {**LAW, "damping": 2e-3, "friction": 0.6, **rim}, angle)
    none, still = np.zeros((7, 3)), Motion.from_samples(0.5, np.zeros(3))
    states = [SpatialState(none + np.array([0.0, y, 0.0]), none, none, none) for y in (0.0, 0.2)]
    runs = (simulate(made, still, initial=state, settle=0.0, tolerance=1e-6) for state in states)
    here, there = runs
    assert there.slip[-1, [0, 7]] == pytest.approx(0.2, rel=1e-6)
    assert there.uy[-1] == pytest.approx(0.2, rel=1e-6)
    assert there.contact[-1] == pytest.approx(here.contact[-1], abs=1e-6)
    assert there.N[-1] == pytest.approx(here.N[-1], rel=1e-6)
    assert made.joint_names[0] == "voussoir1-base"
    assert Structure.from_dict(made.to_dict()).joints[7].moments == made.joints[7].moments


def test_a_rod_stretches_as_hookes_law_has_it_and_yields() -> None:
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 1.0, "mass": 1000.0, "on": "base"}
    tie = {"between": ["b", "base"], "from": [-2.0, 0.0, 0.0], "to": [-3.0, 0.0, 0.5], "stiffness": 1e5}
    law = {"stiffness": 1e9, "damping": 1e-3, "friction": 0.01}
    data: dict[str, Any] = {"name": "rod", "joints": law, "block": [block], "tie": [tie]}
    push = Motion.from_samples(1.0, [-5.0, -5.0, -5.0], hold=True)
    held = run(Structure.from_dict(data), push)
    stretch = held.displacement(0, (-2.0, 0.0, 0.0))
    length = np.hypot(1.0 + stretch[:, 0], stretch[:, 2])
    assert held.tie[:, 0] == pytest.approx(1e5 * np.maximum(0.0, length - 1.0), abs=1e-6 * 1e5 * 0.1)
    assert np.max(held.tie) > 6e3
    tie["yield"] = 4e3
    yields = run(Structure.from_dict(data), push)
    assert np.max(yields.tie) == pytest.approx(4e3, rel=1e-9)
    assert np.max(yields.ux) > 1.5 * np.max(held.ux)


def test_modes_of_a_stack_are_those_of_the_plane_twice_and_torsion() -> None:
    structure = with_law(stack(), shear_ratio=1e5)
    modes = modes_in_space(structure)
    # the exact model, theory.md section 5; the shear of the joints takes 1e-5
    assert modes.frequency[:2] == pytest.approx([3.05805407, 3.05805407], rel=3e-5)
    assert np.sum(modes.mass[:, 0]) == pytest.approx(3 * 27000.0, rel=1e-9)
    assert np.sum(modes.mass[:, 5]) == pytest.approx(3 * 27000.0 * 1.56**2 / 6.0, rel=1e-9)
    drum = modes_in_space(stack(1, "circle", ratio=0.4))
    twist = int(np.argmax(drum.twists))
    polar = 0.5 * math.pi * 0.78**4
    exact = math.sqrt(0.4 * MODULUS * polar / (0.5 * 27000.0 * 0.78**2)) / (2.0 * math.pi)
    assert drum.frequency[twist] == pytest.approx(exact, rel=1e-6)


def test_a_stack_has_the_masses_and_inertias_of_its_column() -> None:
    column = random_column(np.random.default_rng(5), 4)
    structure = column.in_space()
    assert [block.mass for block in structure.blocks] == [block.mass for block in column.blocks]
    for solid, block in zip(structure.blocks, column.blocks, strict=True):
        assert solid.inertia[1, 1] == pytest.approx(block.resolved_inertia, rel=1e-12)
    aurelian = Column.from_toml(ROOT / "examples" / "columns" / "aurelian.toml").in_space()
    assert modes_in_space(aurelian).frequency[0] == pytest.approx(1.26, abs=0.01)


def test_response_and_its_files(tmp_path: Path) -> None:
    structure = Structure.from_dict(TRILITH)
    motion = Motion.harmonic(0.22 * G, 1.4, 0.5, direction=0.4)
    response = simulate(structure, motion, check=True, settle=0.0, ensemble=2)
    assert response.estimated_error is not None
    assert response.estimated_error.ux <= 1e-3
    assert response.ensemble is not None
    assert response.ensemble.size == 2
    assert response.displacement("beam")[-1] == pytest.approx(
        [response.ux[-1, 2], response.uy[-1, 2], response.uz[-1, 2]]
    )
    for name in ("ux", "uy", "uz", "N", "sigma_max"):
        assert np.all(np.max(np.abs(getattr(response, name)), axis=0) <= response.peaks[name] * (1.0 + 1e-12))
    assert np.all(np.min(response.contact, axis=0) >= response.peaks["contact"] - 1e-12)
    response.to_csv(tmp_path / "out.csv")
    header, *rows = (tmp_path / "out.csv").read_text(encoding="utf-8").splitlines()
    assert len(rows) == len(response.time)
    assert header.split(",")[:2] == ["time", "block[left].ux"]
    assert "joint[beam-left].sigma_max" in header
    table = np.loadtxt(tmp_path / "out.csv", delimiter=",", skiprows=1)
    assert table[:, 1:] == pytest.approx(response.rows, rel=1e-8, abs=1e-12)
    response.plot_model(tmp_path / "structure.png")
    response.plot_plan(tmp_path / "plan.png")
    assert [line.get_label() for line in response.plot_plan(blocks=("left", 2)).axes[0].lines] == ["left", "beam"]
    again = simulate(structure, motion, settle=0.0)
    assert np.array_equal(again.rows, response.rows)  # the same bits


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"at": 99.0}, "at = 99.0: must be a time of the response, 0 to 0.1 s"),
        ({"at": math.nan}, "at = nan: must be a time"),
        ({"scale": -1.0}, "scale = -1.0: must be a positive factor"),
        ({"scale": 0}, "scale = 0: must be a positive factor"),
    ],
)
def test_pictures_are_of_the_run(wrong: dict[str, Any], message: str, tmp_path: Path) -> None:
    """Check what pictures of columns refuse too: a time outside the run was its nearest row."""
    response = simulate(Structure.from_dict(TRILITH), Motion.harmonic(0.1 * G, 1.4, 0.1), settle=0.0)
    with pytest.raises(InputError, match=re.escape(message)):
        response.plot_model(**wrong)
    if "scale" in wrong:
        with pytest.raises(InputError, match=re.escape(message)):
            response.film(tmp_path / "film.gif", **wrong)
    with pytest.raises(InputError, match=re.escape("fps = 12.5: must be a whole number of pictures a second")):
        response.film(tmp_path / "film.gif", fps=12.5)  # type: ignore[arg-type]
    with pytest.raises(InputError, match=re.escape("block = 0.5: must be a number from 0 to 2, or a name")):
        response.plot_plan(blocks=(0.5,))  # type: ignore[arg-type]


def test_many_structures_in_one_table() -> None:
    structure = Structure.from_dict(TRILITH)
    motions = [Motion.harmonic(level * G, 1.4, 0.4, direction=0.4) for level in (0.1, 0.2, 0.3)]
    table = simulate_many(
        structure, motions, keep=("peak_centroid_ux", "least_contact", "verdict", "steps"), settle=0.0
    )
    alone = simulate(structure, motions[1], settle=0.0)
    assert table["peak_centroid_ux"].shape == (3, 3)
    assert np.array_equal(table["peak_centroid_ux"][1], alone.peaks["ux"])
    assert np.array_equal(table["least_contact"][1], alone.peaks["contact"])
    assert table["verdict"][1] == alone.verdict
    assert table["steps"][1] == alone.stats["steps"]
    with pytest.raises(InputError, match="keep: 'energy'"):
        simulate_many(structure, motions, keep=("energy",))
    with pytest.raises(InputError, match="ay: a column moves in its plane"):
        simulate_many(random_column(np.random.default_rng(1), 2), motions)


def test_many_structures_take_a_value_for_each_run() -> None:
    structure, motion = stack(1), Motion.harmonic(1.0, 2.0, 0.2)
    options: dict[str, Any] = {"keep": ("steps", "peak_centroid_ux"), "settle": 0.0}
    alone = [simulate_many(structure, motion, duration=d, **options)["steps"][0] for d in (0.1, 0.2)]
    both = simulate_many([structure] * 2, [motion] * 2, duration=[0.1, None], **options)
    assert both["steps"].tolist() == alone
    given = simulate_many((structure for _ in range(2)), motion, tolerance=iter([None, 1e-8]), **options)
    assert given["steps"][0] == alone[1] < given["steps"][1]


def test_many_structures_in_processes_and_with_whole_responses() -> None:
    structure = Structure.from_dict(TRILITH)
    motions = [Motion.harmonic(level * G, 1.4, 0.4, direction=0.4) for level in (0.1, 0.2, 0.3)]
    options: dict[str, Any] = {"keep": ("peak_N", "verdict"), "settle": 0.0}
    here = simulate_many(structure, motions, responses=[1], **options)
    with ProcessPoolExecutor(1, multiprocessing.get_context("spawn")) as pool:
        there = simulate_many(structure, motions, executor=pool, **options)
    assert np.array_equal(here["peak_N"], there["peak_N"])
    assert here["verdict"].tolist() == there["verdict"].tolist()
    assert list(here.responses) == [1]
    assert np.array_equal(here.responses[1].rows, simulate(structure, motions[1], settle=0.0).rows)


@pytest.mark.parametrize(
    ("changes", "line"),
    [
        ({"duration": [0.1, -1.0]}, "duration[1] = -1.0"),
        ({"tolerance": [1e-3, 1e-3, 1e-3]}, "2 columns, 3 tolerance"),
        ({"settle": -1.0}, "settle = -1.0: must be a time in s, zero or positive"),
        ({"threads": 0}, "threads = 0"),
        ({"executor": 5}, "executor = 5: must have submit"),
        ({"responses": 5}, "responses = 5: must be"),
        ({"columns": [stack(1), 5]}, "columns[1] = 5: must be a structure, as the first one"),
    ],
)
def test_many_structures_name_a_wrong_value(changes: dict[str, Any], line: str) -> None:
    given = {"columns": [stack(1)] * 2, "motions": Motion.harmonic(1.0, 2.0, 0.2), **changes}
    with pytest.raises(InputError) as error:
        simulate_many(**given)
    assert str(error.value).startswith(line)


def test_film(tmp_path: Path) -> None:
    response = simulate(Structure.from_dict(TRILITH), Motion.harmonic(0.3 * G, 1.4, 0.4, direction=0.4), settle=0.0)
    response.film(tmp_path / "film.gif", fps=10)
    with Image.open(tmp_path / "film.gif") as picture:
        assert getattr(picture, "n_frames", 1) == 5


def test_what_planes_and_structures_have_not_is_refused() -> None:
    across = Motion.harmonic(1.0, 1.0, 1.0, direction=0.5)
    with pytest.raises(InputError, match="ay: a column moves in its plane"):
        simulate(random_column(np.random.default_rng(1), 2), across)
    with pytest.raises(InputError, match="integrator = 'auto': must be left out"):
        simulate(Structure.from_dict(TRILITH), across, integrator="auto")


def test_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    lines = ["time,base.ax,base.ay,base.az", "0,0,0,0", "0.2,1.5,0.7,0", "0.4,0,0,0"]
    (tmp_path / "motion.csv").write_text("\n".join(lines) + "\n", encoding="utf-8")
    trilith = str(ROOT / "examples" / "structures" / "trilith.toml")
    output = str(tmp_path / "out.csv")
    assert main(["simulate", trilith, str(tmp_path / "motion.csv"), "--settle", "0", "-o", output]) == 0
    printed = capsys.readouterr().out
    assert "base: 0.4 s, PGA 0.153 g along x, 0.07138 g along y\n" in printed
    assert "beam-left" in printed
    assert main(["simulate", trilith, str(tmp_path / "motion.csv"), "--formulation", "paper"]) == 2
    assert "--formulation: must be left out" in capsys.readouterr().err


def test_numbers_too_far_apart_for_a_rest_are_refused() -> None:
    """Refuse a gravity at the end of float64: the tangent at rest would be no number, and its modes would not
    converge.
    """
    block = {"name": "a", "on": "base", "width": 1.0, "depth": 1.0, "height": 1.0, "mass": 1e15}
    odd = Structure.from_dict({"name": "odd", "g": 5e-324, "joints": LAW, "block": [block]})
    with pytest.raises(InputError, match=r"^odd: its numbers lie too far apart for its rest to be found"):
        modes_in_space(odd)


def test_a_tie_that_also_pushes_has_no_slack() -> None:
    """Check that with slack it would push as built: 168 kN at rest of one of 1e7 N/m."""
    tie = {"between": ["b", "base"], "from": [0.0, 0.0, 0.0], "to": [3.0, 0.0, 0.0], "stiffness": 1e7, "slack": 0.02}
    block = {"name": "b", "width": 1.0, "depth": 1.0, "height": 1.0, "mass": 2000.0, "on": "base"}
    data = {"name": "a", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": [block]}
    with pytest.raises(InputError, match=r"slack = 0.02: must be 0 beside tension_only = false"):
        Structure.from_dict({**data, "tie": [{**tie, "tension_only": False}]})
    assert Structure.from_dict({**data, "tie": [tie]}).ties[0].slack == 0.02


def test_the_least_dimension_of_a_block_turns_with_it() -> None:
    """Turn a plate about the vertical axis, as a box and as the hull of its corners."""
    law, joint = {"stiffness": 1e9, "damping": 1e-3}, {"between": ["a", "base"]}
    plate = {"name": "a", "density": 2500.0}
    box = {**plate, "width": 0.6, "depth": 0.2, "height": 0.4, "position": [0.0, 0.0, 0.0]}
    for turn in (0.0, 0.3, 0.25 * math.pi):
        c, s = math.cos(turn), math.sin(turn)
        corners = [[c * x - s * y, s * x + c * y, z] for x in (-0.3, 0.3) for y in (-0.1, 0.1) for z in (0.0, 0.4)]
        for parts in (
            {"block": [{**box, "rotation": [0.0, 0.0, turn]}], "joint": [joint]},
            {"block": [{**plate, "shape": "hull", "points": corners, "on": "base"}]},
        ):
            made = Structure.from_dict({"name": "plate", "joints": law, **parts})
            assert made.blocks[0].drop == pytest.approx(0.1, rel=1e-12)


@pytest.mark.parametrize("at", [1e-3, 0.2])
def test_a_hollow_face_that_another_one_covers_in_part_is_refused_with_the_reason(at: float) -> None:
    ring = {"name": "ring", "on": "base", "shape": "drum", "diameter": 1.2, "bore": 0.4, "height": 1.0}
    drum = {"name": "drum", "on": "ring", "at": [at, 0.0], "shape": "drum", "diameter": 1.0, "height": 1.0}
    law = {"stiffness": 1e9, "damping": 1e-3}
    blocks = [{**block, "density": 2000.0} for block in (ring, drum)]
    with pytest.raises(InputError, match=r"block\[2\].on: a hollow face must share its axis with a round one"):
        Structure.from_dict({"name": "hollow", "joints": law, "block": blocks})


@pytest.mark.parametrize("bore", [0.0, 0.1])
def test_a_face_within_the_bore_of_another_one_does_not_touch_it(bore: float) -> None:
    ring = {"name": "ring", "on": "base", "shape": "drum", "diameter": 1.2, "bore": 0.8, "height": 1.0}
    drum = {"name": "drum", "on": "ring", "at": [0.1, 0.0], "shape": "drum", "diameter": 0.3, "height": 1.0}
    blocks = [{**block, "density": 2000.0} for block in (ring, {**drum, **({"bore": bore} if bore else {})})]
    with pytest.raises(InputError, match=r"block\[2\].on: drum and ring share no face"):
        Structure.from_dict({"name": "nested", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": blocks})
