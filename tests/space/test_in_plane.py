"""A structure that is a column is solved as one where the user allows it."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import G, phocas
from support.structures import stack

from solver import Column, InputError, Response, simulate
from solver.ground.motion import Motion
from solver.models.structure.model import Structure
from solver.models.structure.response import SpatialResponse
from solver.models.structure.stack import column_of

MOTION = Motion.harmonic(0.05 * G, 2.0, 1.0)


@pytest.mark.parametrize("name", ["phocas-damped", "doric", "phocas-round"])
def test_the_column_of_a_stack_is_the_column(name: str) -> None:
    column = Column.from_toml(ROOT / "examples" / "columns" / f"{name}.toml")
    found = column_of(Structure.stack(column))
    assert found is not None
    assert found.n == column.n
    for one, other in zip(found.blocks, column.blocks, strict=True):
        assert one.mass == pytest.approx(other.mass, rel=1e-12)
        assert one.resolved_inertia == pytest.approx(other.resolved_inertia, rel=1e-12)
        assert one.resolved_centroid == pytest.approx(other.resolved_centroid, rel=1e-12)
        assert one.joint.stiffness == other.joint.stiffness
        assert one.joint.friction == other.joint.friction
        assert one.contact_face.section == other.contact_face.section


def test_the_response_is_that_of_the_column() -> None:
    """Compare a file's structure, the lowest block first: the same as in the plane, and near the same as in space."""
    structure = replace(stack(ratio=40.0), tolerance=1e-7)
    planar = simulate(structure, MOTION, settle=0, plane="auto")
    assert isinstance(planar, Response)
    column = simulate(phocas(eta=1e-3), MOTION, settle=0, tolerance=1e-7)
    assert np.max(np.abs(planar.ux - column.ux)) <= 1e-9 * column.peak_top_ux[0]
    spatial = simulate(structure, MOTION, settle=0)
    top = spatial.displacement("b2", (0.0, 0.0, 0.5 * 4.69))[:, 0]
    # the shear of the joints moves the top by 1e-4 of the peak: measured 1.1e-4
    assert np.max(np.abs(top - planar.ux[:, 0])) <= 3e-4 * planar.peak_top_ux[0]


@pytest.mark.parametrize("at", [[7.3, -4.1], [-2.0, 0.0], [0.0, 1e3]])
def test_a_stack_away_from_the_origin_is_the_same_column(at: list[float]) -> None:
    """Compare with the stack at the origin, to the bit; its joint may be listed, in either order."""
    low = {"name": "a", "on": "base", "width": 0.9, "depth": 0.6, "height": 1.0, "density": 2000.0}
    drum = {"name": "b", "shape": "drum", "diameter": 0.5, "top_diameter": 0.4, "height": 1.2, "density": 2500.0}
    data = {"name": "two", "joints": {"stiffness": 1e9, "damping": 1e-3, "friction": 0.6}}
    central = column_of(Structure.from_dict({**data, "block": [low, drum | {"on": "a"}]}))
    assert central is not None
    placed, above = low | {"at": at}, drum | {"position": [*at, 1.0]}
    own = {"at": [*at, 1.0], "normal": [0.0, 0.0, -1.0], "section": "circle", "diameter": 0.5}
    cases: list[tuple[list[Any], list[Any]]] = [
        ([placed, drum | {"on": "a"}], []),
        ([placed, above], [{"between": ["b", "a"]}]),
        ([placed, above], [{"between": ["a", "b"]}]),
        ([above, placed], [{"between": ["a", "b"], **own}]),
    ]
    for blocks, joint in cases:
        found = column_of(Structure.from_dict({**data, "block": blocks, "joint": joint}))
        assert found is not None
        assert found.to_dict() == central.to_dict()
    aside = [placed, drum | {"on": "a", "at": [at[0] + 0.1, at[1]]}]
    assert column_of(Structure.from_dict({**data, "block": aside})) is None


def test_what_is_no_column_is_solved_in_space() -> None:
    blocks = [{"name": "a", "on": "base", "width": 2.0, "depth": 2.0, "height": 1.0, "density": 2000.0}]
    blocks += [blocks[0] | {"name": "b", "on": "a"}]
    data = {"name": "two", "joints": {"stiffness": 1e9, "damping": 1e-3}, "block": blocks}
    assert column_of(Structure.from_dict(data)) is not None
    turned = [blocks[0], blocks[1] | {"at": [0.3, 0.0]}]
    tie = {"between": ["a", "b"], "from": [0.0, 0.0, 0.0], "to": [0.0, 0.0, 0.0], "stiffness": 1e6}
    for other in (data | {"block": turned}, data | {"tie": [tie]}):
        structure = Structure.from_dict(other)
        assert column_of(structure) is None
        assert isinstance(simulate(structure, MOTION, settle=0, duration=0.1, plane="auto"), SpatialResponse)
    across = Motion.from_samples(0.01, np.zeros(11), ay=np.ones(11))
    structure = Structure.from_dict(data)
    assert isinstance(simulate(structure, across, settle=0, plane="auto"), SpatialResponse)
    assert isinstance(simulate(structure, MOTION, settle=0, duration=0.1), SpatialResponse)


def test_a_column_in_space_leaves_out_what_it_did() -> None:
    """Leave out modes: the stack of the column took them (30 steps), as the file in the plane does not."""
    column = Column.from_toml(ROOT / "examples" / "columns" / "phocas-damped.toml")
    left_out = column.with_settings(without=("elastic", "peaks", "rest")).in_space()
    assert left_out.without == ("elastic", "peaks")
    found = [
        simulate(one, MOTION, settle=0, duration=0.1).stats["elastic_steps"] for one in (column.in_space(), left_out)
    ]
    assert found[0] > 0 == found[1]


def test_another_word_is_refused() -> None:
    with pytest.raises(InputError, match="plane"):
        simulate(stack(), MOTION, plane="xz")
