"""Rim and damping that are found for a restitution, against closed forms of rigid blocks."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from solver import Block, Column, InitialState, InputError, InputWarning, Joint, Motion, Settings, simulate
from solver.commands.command_line import main
from solver.statics.calibrate import rim_from_restitution, with_joints, with_rim
from solver.statics.rocking import (
    area_on_edge,
    column_damping_on_edge,
    damping_on_edge,
    housner_restitution,
    pulled_equilibrium,
    restitution,
)

WIDTH, HEIGHT = 0.5, 1.9  # m
ALPHA = math.atan2(WIDTH, HEIGHT)


def block(stiffness: float, depth: float = 20.0, **joint: Any) -> Column:
    """Return a block that is long across the motion unless said otherwise."""
    law = Joint(stiffness, 1e-3, **joint)
    made = Block(HEIGHT, WIDTH, depth, 2500.0 * WIDTH * HEIGHT * depth, law)
    return Column("block", (made,), Settings(tolerance=1e-6))


def rigid(place: float) -> float:
    """Return the rotation rate after over before the impulse, which acts at this part of the half width from the
    middle.

    About that point nothing turns the block: (I - m b x) before, (I + m b x) after, I = m (b^2 + 4 h^2) / 3 about the
    middle of the base. At the edge it is Housner's.
    """
    half, rise = 0.5 * WIDTH, 0.5 * HEIGHT
    inertia, moved = (half**2 + 4.0 * rise**2) / 3.0, half**2 * place
    return (inertia - moved) / (inertia + moved)


def test_the_closed_form_at_the_edge_is_housners() -> None:
    assert rigid(1.0) == pytest.approx(1.0 - 1.5 * math.sin(ALPHA) ** 2, rel=1e-14)
    assert rigid(1.0) == pytest.approx(housner_restitution(block(1e10)), rel=1e-14)
    assert rigid(1.0 / 3.0) == pytest.approx(0.9665, abs=5e-5)


# --- critical on the edge


def test_damping_on_the_edge_is_critical_for_the_mass_that_lands() -> None:
    """Check that a homogeneous block lands with m / (1 + 3 sin^2 alpha)."""
    column = block(1e12, 0.7, rim=2e-3)
    mass = column.blocks[0].mass / (1.0 + 3.0 * math.sin(ALPHA) ** 2)
    assert column_damping_on_edge(column) == pytest.approx(2.0 * math.sqrt(mass / (1e12 * 2e-3 * 0.7)), rel=1e-13)
    whole = column_damping_on_edge(block(1e12, 0.7))
    assert whole == pytest.approx(2.0 * math.sqrt(mass / (1e12 * 0.25 * 0.7)), rel=1e-13)
    only = column.blocks[0]
    assert damping_on_edge(1e12, 1.4e-3, only.mass, only.resolved_inertia, 0.25) == column_damping_on_edge(column)
    with pytest.raises(InputError, match=r"area = 0\.0: must be a positive area in m2"):
        damping_on_edge(1e12, 0.0, 1.0, 1.0, 1.0)


def test_the_statue_on_a_pedestal_lands_with_its_own_mass() -> None:
    """Check that damping is that of the part that rocks, here the upper block on its own joint."""
    statue, plinth = Block(1.8, 0.5, 0.5, 700.0, Joint(3e9, 0.0, rim=0.01)), Block(1.0, 0.9, 0.9, 2000.0, Joint(1e9, 0))
    alone = Column("statue", (statue,))
    assert column_damping_on_edge(Column("both", (statue, plinth))) == pytest.approx(column_damping_on_edge(alone))


@pytest.mark.parametrize(
    ("section", "below"),
    [
        ({}, {}),
        ({"section": "circle"}, {}),
        ({"section": "circle"}, {"section": "circle"}),
        ({"section": "annulus", "bore": 0.3}, {}),
        ({}, {"section": "circle"}),
    ],
)
@pytest.mark.parametrize("rim", [0.05, 0.12])
def test_area_of_the_band_along_an_edge(section: dict[str, Any], below: dict[str, Any], rim: float) -> None:
    """Measure all places of the face as near to its edge along the motion as the rim is wide."""
    size = 0.8 if section else 0.5  # a square upper face lies within the round one below
    top = Block(1.0, size, size, 1000.0, Joint(1e10, 1e-3, rim=rim), **section)
    low = Block(1.0, 1.0, 1.0, 1000.0, Joint(1e10, 1e-3), **below)
    column = Column("two", (top, low))
    x, y = np.meshgrid(*[(np.arange(2000) + 0.5) / 1000.0 - 1.0] * 2)
    reach = np.hypot(x, y)
    is_round = bool(section)
    within = reach < 0.5 * size if is_round else np.maximum(np.abs(x), np.abs(y)) < 0.5 * size
    within &= reach > 0.5 * section.get("bore", 0.0)
    expected = float(np.count_nonzero(within & (x > 0.5 * size - rim))) * 1e-6
    assert area_on_edge(top, column.contacts[0]) == pytest.approx(expected, rel=5e-3)  # of the grid


# --- restitution


# each marked one takes a second or more
@pytest.mark.parametrize("stiffness", [*(pytest.param(k, marks=pytest.mark.long) for k in (1e9, 1e11)), 1e13])
def test_critically_damped_faces_lie_between_the_third_and_the_edge(stiffness: float) -> None:
    """Check that the wider the rim, the nearer to the middle an impact acts; a flat face loses less than an impulse at
    2 thirds.

    Measured: whole faces 0.944 to 0.953; edges 0.904 of 1e13.
    """
    rims = [None, 0.125, 0.03, 0.01]
    found = []
    for rim in rims:
        column = with_rim(block(stiffness), rim)
        found.append(restitution(with_joints(column, damping=column_damping_on_edge(column))))
    assert found == sorted(found, reverse=True)
    assert rigid(2.0 / 3.0) < found[0] < rigid(1.0 / 3.0)
    if stiffness == 1e13:
        thin = with_rim(block(stiffness), 1e-3)
        edge = restitution(with_joints(thin, damping=column_damping_on_edge(thin)))
        assert edge == pytest.approx(rigid(1.0), rel=2e-3)  # measured 1.1e-3
        assert rigid(1.0) < edge < found[-1]


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("wanted", [None, 0.93])
@pytest.mark.parametrize("stiffness", [1e9, 1e11])
def test_a_block_rocks_with_the_restitution_that_was_asked_for(wanted: float | None, stiffness: float) -> None:
    """Compare the rotations on both sides of the impact, and the energy of a rigid block there."""
    fit = rim_from_restitution(block(stiffness), wanted)
    asked = rigid(1.0) if wanted is None else wanted
    assert fit.rim is not None
    assert fit.restitution == pytest.approx(asked, abs=2e-5)
    column = with_joints(with_rim(block(stiffness), fit.rim), damping=fit.damping)
    assert fit.damping == pytest.approx(column_damping_on_edge(column), rel=1e-12)
    assert turned_back(column) == pytest.approx(asked, rel=3e-3)  # measured 1.6e-3 at 1e9, 1.5e-4 at 1e11


def turned_back(column: Column) -> float:
    start: InitialState = pulled_equilibrium(column)[0]
    run = simulate(column, Motion.from_samples(3.0, [0.0, 0.0]), initial=start, output_step=1e-3, settle=0.0)
    theta = run.ry[:, 0]
    side = math.copysign(1.0, theta[0])
    beyond = int(np.argmax(side * theta < 0.0))
    later = np.flatnonzero(side * theta[beyond:] > 0.0)
    turned = float(np.max(-side * theta[beyond : beyond + int(later[0]) if later.size else None]))
    lifted = [math.cos(ALPHA - turn) - math.cos(ALPHA) for turn in (turned, abs(float(theta[0])))]
    return math.sqrt(lifted[0] / lifted[1])


def test_whole_faces_that_lose_enough_keep_touching_all_over() -> None:
    fit = rim_from_restitution(block(1e9), 0.97)
    assert fit.rim is None
    assert fit.restitution == pytest.approx(0.97, abs=1e-6)
    assert fit.damping < column_damping_on_edge(block(1e9))


@pytest.mark.long  # takes seconds
def test_a_restitution_near_to_the_least_is_taken_with_a_warning() -> None:
    """Check that Housner's is the limit of a narrow and stiff rim."""
    with pytest.warns(InputWarning, match=r"no rim down to 0\.00024 m reaches it; the nearest is 0\.903"):
        fit = rim_from_restitution(block(1e13))
    assert fit.restitution == pytest.approx(rigid(1.0), rel=2e-3)  # measured 8e-4


def test_what_no_rim_has_is_refused_with_the_nearest() -> None:
    """Check that of a square base the bands beside the motion act as a flat face does."""
    with pytest.raises(InputError, match=r"no rim down to .* reaches it; the nearest is 0\.918") as refused:
        rim_from_restitution(block(1e13, 0.5))
    assert "bases long across the motion, or strips at their edges" in str(refused.value)
    assert "\n" not in str(refused.value)
    strips = block(1e13, 0.5, section="strips", strips=(0.5, *[0.0] * 30, 0.5))
    assert restitution(with_joints(strips, damping=column_damping_on_edge(strips))) < 0.912  # measured 0.9087
    with pytest.raises(InputError, match="rim"):
        with_rim(strips, 0.01)
    with pytest.raises(InputError, match="between 0 and 1"):
        rim_from_restitution(block(1e10), 1.5)


# --- the command


def written(folder: Path, stiffness: str, joint: str = "damping = 1e-3") -> str:
    path = folder / "rigid.toml"
    path.write_text(
        f'name = "rigid"\n[joint]\nstiffness = {stiffness}\n{joint}\n'
        "[[block]]\nwidth = 0.5\ndepth = 20.0\nheight = 1.9\ndensity = 2500.0\n",
        encoding="utf-8",
    )
    return str(path)


def values(text: str) -> dict[str, float]:
    lines = [line.split("#")[0].split("=") for line in text.splitlines() if " = " in line and "#" in line]
    return {key.strip(): float(value) for key, value in lines}


@pytest.mark.long  # takes seconds
def test_command_finds_a_rim_where_damping_alone_does_not_do(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Check that what it prints, put into the file, has the restitution."""
    assert main(["calibrate", written(tmp_path, "1e10"), "--restitution", "housner"]) == 0
    first = capsys.readouterr().out
    assert first.startswith("damping alone does not have it: no damping reaches it up to the critical one")
    found = values(first)
    assert set(found) == {"stiffness", "damping", "rim"}
    law = f"damping = {found['damping']}\nrim = {found['rim']}"
    assert main(["calibrate", written(tmp_path, "1e10", law)]) == 0
    assert "restitution 0.90285" in capsys.readouterr().out
    assert main(["calibrate", written(tmp_path, "1e10", law), "--restitution", "housner", "--json"]) == 0
    again = json.loads(capsys.readouterr().out)  # of the file's rim, by its damping alone
    assert again["joints"][0]["rim"] == found["rim"]
    assert again["restitution"] == pytest.approx(again["housner_restitution"], abs=1e-6)


@pytest.mark.long  # takes seconds
def test_command_looks_for_a_rim_only_where_damping_fails_or_it_is_asked_to(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = written(tmp_path, "1e10")
    assert main(["calibrate", file, "--restitution", "0.96"]) == 0
    assert "rim" not in values(capsys.readouterr().out)
    assert main(["calibrate", file, "--restitution", "0.95", "--rim", "auto"]) == 0
    out = capsys.readouterr().out
    assert out.startswith("[joint]")
    assert values(out)["rim"] > 0.1
    assert main(["calibrate", file, "--critical", "--rim", "5e-3"]) == 0
    found = values(capsys.readouterr().out)
    assert found["rim"] == 5e-3
    assert found["damping"] == pytest.approx(column_damping_on_edge(block(1e10, rim=5e-3)), rel=1e-5)
    assert main(["calibrate", file, "--restitution", "0.5"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "no rim down to 0.00098 m reaches it; the nearest is 0.8" in line
