"""Drums, hollow drums, blocks that taper: mass, centroid and inertia; how a column file describes them."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import quad
from support.fmus import ROOT

from solver import Column, InputError
from solver.kernels.column.model.solids import solid_between
from solver.kernels.column.sections.faces import ANNULUS, CIRCLE, RECTANGLE
from solver.models.column.block import with_load
from solver.models.column.stepper import Stepper

EXAMPLES = sorted((ROOT / "examples" / "columns").glob("*.toml"))


def test_a_frustum_of_a_cone_has_the_volume_and_centroid_of_the_textbook() -> None:
    low, high, height = 0.9, 0.6, 2.5
    sum_of_squares = low * low + low * high + high * high
    solid = solid_between(CIRCLE, height, 2.0 * low, 2.0 * low, 2.0 * high, 2.0 * high)
    assert solid.volume == pytest.approx(math.pi * height / 3.0 * sum_of_squares, rel=1e-14)
    expected = height / 4.0 * (low * low + 2.0 * low * high + 3.0 * high * high) / sum_of_squares
    assert solid.centroid == pytest.approx(expected, rel=1e-14)


def test_a_cylinder_a_tube_and_a_cuboid_have_the_inertia_of_the_textbook() -> None:
    height, outer, inner = 2.5, 0.8, 0.3
    full = solid_between(CIRCLE, height, 1.6, 1.6)
    assert full.inertia == pytest.approx(full.volume * (3.0 * outer**2 + height**2) / 12.0, rel=1e-14)
    tube = solid_between(ANNULUS, height, 1.6, 1.6, bore=0.6)
    assert tube.inertia == pytest.approx(tube.volume * (3.0 * (outer**2 + inner**2) + height**2) / 12.0, rel=1e-14)
    cuboid = solid_between(RECTANGLE, height, 1.6, 1.2)
    assert cuboid == pytest.approx((4.8, 1.25, 4.8 * (height**2 + 1.6**2) / 12.0), rel=1e-14)


@pytest.mark.parametrize("section", [RECTANGLE, CIRCLE, ANNULUS])
def test_what_tapers_is_the_integral_over_its_slices(section: int) -> None:
    height, bore = 3.0, 0.4
    bottom, top = ((1.6, 1.2), (2.0, 0.7)) if section == RECTANGLE else ((1.6, 1.6), (1.1, 1.1))

    def slice_at(z: float) -> tuple[float, float]:
        width, depth = (a + (b - a) * z / height for a, b in zip(bottom, top, strict=True))
        if section == RECTANGLE:
            return width * depth, width**3 * depth / 12.0
        hole = bore if section == ANNULUS else 0.0
        return math.pi / 4.0 * (width**2 - hole**2), math.pi / 64.0 * (width**4 - hole**4)

    volume = quad(lambda z: slice_at(z)[0], 0.0, height)[0]
    centroid = quad(lambda z: slice_at(z)[0] * z, 0.0, height)[0] / volume
    inertia = quad(lambda z: slice_at(z)[1] + slice_at(z)[0] * (z - centroid) ** 2, 0.0, height)[0]
    found = solid_between(section, height, *bottom, *top, bore)
    assert found == pytest.approx((volume, centroid, inertia), rel=1e-13)


def test_the_kernels_work_out_what_python_does() -> None:
    some = column(DRUM | {"top_diameter": 1.2}, {**DRUM, "section": "annulus", "bore": 0.4, "top_diameter": 1.1}, BRICK)
    packed = Stepper(some).model.blocks
    assert list(packed.centroid) == [block.resolved_centroid for block in some.blocks]
    assert list(packed.inertia) == [block.resolved_inertia for block in some.blocks]


def test_a_load_is_a_mass_of_no_size() -> None:
    mass, centroid, inertia = with_load(1000.0, 1.0, 400.0, 500.0, 2.5)
    assert (mass, centroid) == (1500.0, 1.5)
    assert inertia == pytest.approx(400.0 + 1000.0 * 0.25 + 500.0 * 1.0)


# --- the column file

JOINT = {"stiffness": 5e9, "damping": 1e-3}
DRUM: dict[str, Any] = {"section": "circle", "height": 2.0, "diameter": 1.5, "density": 2600.0}


BRICK: dict[str, Any] = {"height": 1.2, "width": 1.9, "depth": 0.8, "top_depth": 0.7, "density": 2600.0}


def column(*blocks: dict[str, Any], **rest: Any) -> Column:
    return Column.from_dict({"name": "some", "joint": JOINT, "block": list(blocks), **rest})


def test_a_drum_is_heavier_below() -> None:
    block = column(DRUM | {"top_diameter": 1.2}).blocks[0]
    assert block.mass == pytest.approx(2600.0 * math.pi * 2.0 / 12.0 * (1.5**2 + 1.5 * 1.2 + 1.2**2))
    assert block.resolved_centroid < 0.95
    (contact,) = column(DRUM | {"top_diameter": 1.2}).contacts
    assert contact.area == pytest.approx(math.pi * 0.75**2)
    assert column(DRUM).springs == (5e9 * contact.area,)


def test_repeated_drums_follow_the_profile_from_the_base_up() -> None:
    drum = {"section": "circle", "height": 2.0, "density": 2600.0}
    blocks = column(drum | {"repeat": 3}, profile=[[0.0, 2.0], [2.0, 1.8], [6.0, 1.0]]).blocks
    assert [(block.width, block.top_width) for block in blocks] == [(1.4, 1.0), (1.8, 1.4), (2.0, 1.8)]


def test_a_load_has_no_inertia_of_its_own_across() -> None:
    """Check a box of 1000 kg, 2 m high, 1 m wide, 3 m deep, under 500 kg at its top: across it is 3 m wide."""
    box = {"height": 2.0, "width": 1.0, "depth": 3.0, "mass": 1000.0, "load": {"mass": 500.0}}
    block = column(box).across().blocks[0]
    middle = (1000.0 * 1.0 + 500.0 * 2.0) / 1500.0
    own = 1000.0 * (4.0 + 9.0) / 12.0
    assert block.resolved_centroid == pytest.approx(middle)
    beyond = 1000.0 * (middle - 1.0) ** 2 + 500.0 * (2.0 - middle) ** 2
    assert block.resolved_inertia == pytest.approx(own + beyond)
    # in space the load adds nothing about the vertical axis
    plane = 1000.0 * (4.0 + 1.0) / 12.0
    axes = np.array([own + beyond, plane + beyond, 1000.0 * (1.0 + 9.0) / 12.0])
    assert np.diag(column(box).in_space().blocks[0].inertia) == pytest.approx(axes)


def test_a_load_moves_the_centroid_up() -> None:
    block = column(DRUM | {"load": {"mass": 1000.0, "above": 0.5}}).blocks[0]
    alone = column(DRUM).blocks[0]
    assert block.mass == alone.mass + 1000.0
    assert block.resolved_centroid == pytest.approx((alone.mass * 1.0 + 1000.0 * 2.5) / block.mass)
    # a heavy load may raise it above the block
    box = {"height": 0.8, "width": 2.0, "depth": 2.0, "mass": 7000.0, "load": {"mass": 12e3, "above": 0.4}}
    height = (7000.0 * 0.4 + 12e3 * 1.2) / 19e3
    assert column(box).blocks[0].resolved_centroid == pytest.approx(height)
    assert column(box).in_space().blocks[0].centroid[2] == pytest.approx(height)


@pytest.mark.parametrize("path", EXAMPLES, ids=lambda path: path.stem)
def test_a_column_comes_back_from_what_it_is_written_as(path: Path) -> None:
    own = Column.from_toml(path)
    assert Column.from_dict(json.loads(json.dumps(own.to_dict()))) == own


def test_the_aurelian_shaft_is_of_stones_of_forty_tonnes() -> None:
    masses = [block.mass for block in Column.from_toml(ROOT / "examples/columns/aurelian.toml").blocks]
    assert masses == pytest.approx(np.full(17, 40e3), rel=0.01)


WRONG = [
    ({"section": "round"}, "block[1].section = 'round': must be one of rectangle, circle, annulus"),
    ({"section": "strips"}, "block[1].section = 'strips': must be one of"),
    ({"section": "annulus"}, "block[1].bore: missing, must be a positive length"),
    ({"section": "annulus", "bore": 1.5}, "block[1].bore = 1.5: must be less than the outer diameter = 1.5 m"),
    ({"bore": 0.4}, 'block[1].bore = 0.4: must be left out, or section = "annulus"'),
    ({"depth": 1.5}, "block[1].depth: must be left out, give diameter: a round block has no depth"),
    ({"section": "rectangle", "width": 1.5, "depth": 1.5}, "block[1].diameter: must be left out"),
    ({"repeat": 0}, "block[1].repeat = 0: must be a whole number from 1 to 1000"),
    ({"load": 3.0}, "block[1].load = 3.0: must be a table with the keys mass, above"),
    ({"load": {"mass": -1e5, "above": 9.0}}, "block[1].load.mass = -100000.0: must be a positive mass in kg"),
    ({"load": {"mass": 1e5}, "centroid": 2.5}, "block[1].centroid = 2.5: must lie below the top face"),
    ({"joint": {"diameter": 1.6}}, "block[1].joint.width = 1.6: must not exceed the block's width = 1.5 m"),
    ({"joint": {"depth": 1.0}}, "block[1].joint.depth: must be left out, a round contact has a diameter"),
    ({"joint": {"strips": [1.0]}}, 'block[1].joint.strips = (1.0,): must be left out, or section = "strips"'),
    ({"joint": {"section": "strips"}}, "block[1].joint.strips = None: must be a list of 1 to 32 depths in m"),
    (
        {"joint": {"section": "strips", "strips": [1.0, 2.0]}},
        "block[1].joint.strips[1] = 2.0: must not exceed the block's depth = 1.5 m",
    ),
    ({"joint": {"section": "strips", "strips": [0.0, 0.0]}}, "block[1].joint.strips: all zero"),
    ({"joint": {"section": "annulus"}}, "block[1].joint.bore: must be an inner diameter in m, less than 1.5 m"),
]


@pytest.mark.parametrize(("change", "said"), WRONG)
def test_what_cannot_be_is_refused_by_name(change: dict[str, Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        column(DRUM | change)
    assert str(caught.value).startswith(said)


@pytest.mark.parametrize(
    ("profile", "said"),
    [
        ([[0.0, 1.0]], "profile = [[0.0, 1.0]]: must be a list of at least two pairs"),
        ([[0.0, 1.0], 2.0], "profile[1] = 2.0: must be a list"),
        ([[0.0, 1.0], [0.0, 1.0]], "profile[1][0] = 0.0: must be above 0.0 m"),
        ([[0.0, 1.0], [2.0, -1.0]], "profile[1][1] = -1.0: must be a positive length"),
    ],
)
def test_a_profile_that_cannot_be_is_refused(profile: list[Any], said: str) -> None:
    with pytest.raises(InputError) as caught:
        column(DRUM, profile=profile)
    assert str(caught.value).startswith(said)
