"""Modes, rest, uplift and capacity of columns that are not shaken, against closed forms, balance and slow motion."""

from __future__ import annotations

import csv
import math
import re
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.optimize import brentq, minimize_scalar
from support.probe import PHOCAS_STIFFNESS, G, monolith, phocas, random_column, settled

from solver import (
    Block,
    Column,
    InitialState,
    InputError,
    Joint,
    Motion,
    Response,
    SolverError,
    natural_frequencies,
    simulate,
)
from solver.commands.command_line import main
from solver.commands.reports import statics_report
from solver.commands.static_reports import _friction_used, rest_in_space_report
from solver.models.column.modes import natural_modes
from solver.models.column.rest import is_stable
from solver.models.column.stepper import Stepper
from solver.models.structure.model import Structure
from solver.models.structure.push import push_over
from solver.statics.capacity import CapacityCurve, capacity_curve, rest_of, uplift_accelerations
from solver.statics.static_plots import plot_capacity

COLUMNS = Path(__file__).resolve().parents[2] / "examples" / "columns"
ALPHA = math.atan2(1.56, 14.07)  # rad, of the diagonal of the monolith
NIGH = Motion.harmonic(1e-12, 1.0, 2.0)  # a base that is as good as still


def stacks() -> list[Column]:
    """Return random columns that stand, softer and stiffer."""
    rng = np.random.default_rng(6)
    found = (random_column(rng, n, softest=3e7) for n in (1, 2, 3, 5, 8) * 4)
    return [column for column in found if is_stable(column)]


def push_of(turn: float) -> float:
    """Push in g under which the monolith balances, turned by `turn` rad: theory.md sections 2 and 8 at rest."""
    width, height, half, weight = 1.56, 7.035, 0.5 * turn, 81000.0 * G

    def moment(push: float) -> float:
        """Return the moment on the block about its centroid."""
        normal = weight * (math.cos(half) - push * math.sin(half))
        along = -weight * (push * math.cos(half) + math.sin(half))
        slope = 2.0 * math.sin(half)
        length = math.sqrt(2.0 * normal / (PHOCAS_STIFFNESS * width * slope))
        opening = slope * (0.5 * width - length)
        restoring = normal * (0.5 * width - length / 3.0)
        lever = height * math.cos(half) + 0.5 * opening
        return height * normal * math.sin(half) - restoring * math.cos(half) - lever * along

    return float(brentq(moment, -0.05, 0.15, xtol=1e-15))


def test_one_block_balances_what_its_closed_form_does() -> None:
    curve = capacity_curve(monolith())
    found = minimize_scalar(lambda turn: -push_of(turn), bounds=(1e-3, 1e-2), method="bounded", options={"xatol": 1e-9})
    assert curve.largest_acceleration / G == pytest.approx(-found.fun, rel=1e-9)  # measured rounding
    assert curve.ry[curve.strongest, 0] == pytest.approx(found.x, rel=1e-5)  # of a flat top; measured 1e-8
    assert curve.largest_acceleration / G == pytest.approx(0.09653, rel=1e-3)  # theory.md, section 5
    assert curve.ry[curve.strongest, 0] == pytest.approx(4.782e-3, rel=1e-2)
    partly = np.flatnonzero(curve.contact[:, 0] < 0.95)
    pushes = [push_of(curve.ry[k, 0]) for k in partly]
    assert curve.acceleration[partly] / G == pytest.approx(np.array(pushes), abs=1e-11)  # measured 3e-12


def test_stiffer_block_tends_to_the_rigid_one() -> None:
    curves = [capacity_curve(monolith(times * PHOCAS_STIFFNESS)) for times in (1, 10, 100, 1000)]
    pushes = np.array([1.0 - curve.largest_acceleration / (G * math.tan(ALPHA)) for curve in curves])
    edge = 14.07 * math.sin(ALPHA) + 0.78 * (1.0 - math.cos(ALPHA))  # m, of the top as the block stands on its corner
    edges = np.array([1.0 - curve.overturning_displacement / edge for curve in curves])
    for missing in (pushes, edges):
        assert np.all(missing > 0.0)
        assert np.all(np.diff(missing) < 0.0)
    assert pushes[-1] < 0.015  # measured 0.0130
    assert edges[-1] < 1e-3  # measured 5.6e-4


def unbalance(curve: CapacityCurve) -> float:
    """Return the largest error of base shear and moment against the weights and pushes of the blocks, in parts of
    weight * width.

    Moments are taken about the middle of the lowest joint's opening, where the kernels reckon the base's moment.
    """
    blocks = curve.model.blocks
    mass = np.array([block.mass for block in blocks])
    rise = np.array([block.resolved_centroid for block in blocks])
    height = np.array([block.height for block in blocks])
    x = curve.ux - (height - rise) * np.sin(curve.ry)
    z = np.cumsum(height[::-1])[::-1] - height + rise + curve.uz
    pushed = curve.acceleration[:, None] * mass * curve.direction
    moment = np.sum(pushed * z + mass * curve.model.g * x, axis=1) * curve.direction
    weight = float(np.sum(mass)) * curve.model.g
    shear = curve.acceleration * np.sum(mass)
    wrong = np.max(np.abs(curve.base_moment - moment)) / (weight * blocks[-1].joint_width)
    return float(max(wrong, np.max(np.abs(curve.base_shear - shear)) / weight))


@pytest.mark.parametrize("column", [phocas(), *stacks()], ids=lambda column: f"{column.n} blocks")
def test_curve_is_of_balance_from_rest_over_the_largest_push_to_none(column: Column) -> None:
    curve = capacity_curve(column)
    assert unbalance(curve) < 1e-10  # measured 2e-14
    assert curve.acceleration[0] == pytest.approx(0.0, abs=1e-12)
    assert curve.acceleration[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.all(np.diff(curve.acceleration[: curve.strongest + 1]) > 0.0)
    assert np.all(np.diff(curve.acceleration[curve.strongest :]) < 0.0)
    for i, push in enumerate(curve.uplift):  # joints open where N times the kern is the moment
        if math.isnan(push):
            assert np.all(curve.contact[: curve.strongest + 1, i] == 1.0)
            continue
        k = int(np.argmin(np.abs(curve.acceleration - push)))
        kern = curve.N[k, i] * column.blocks[i].joint_width / 6.0
        assert curve.My[k, i] == pytest.approx(kern, rel=1e-8)  # measured 5e-11


def test_a_joint_that_opens_as_the_column_topples_has_no_uplift() -> None:
    """Check forty blocks as high as Phocas, softer: upper joints open on the falling branch only, one beyond
    its end.
    """
    n = 40
    block = Block(14.07 / n, 1.56, 1.56, 81000.0 / n, Joint(0.4 * PHOCAS_STIFFNESS, 1e-3))
    column = Column("slices", (block,) * n)
    curve = capacity_curve(column)
    ever = np.any(curve.contact < 1.0, axis=0)
    before = np.any(curve.contact[: curve.strongest + 1] < 1.0, axis=0)
    assert np.any(ever & ~before)
    assert np.array_equal(np.isfinite(curve.uplift), before)
    assert np.all(np.diff(curve.uplift[before]) < 0.0)  # the lower a joint, the sooner
    assert curve.acceleration[-1] == pytest.approx(0.0, abs=1e-9)
    assert np.all(curve.acceleration[:-1] >= 0.0)
    report = statics_report(rest_of(column), curve)
    assert report.count("as it topples") == int(np.sum(ever & ~before))
    assert report.count("never") == int(np.sum(~ever))


def test_round_drums_open_where_the_push_leaves_their_kern() -> None:
    drum = {"height": 2.0, "section": "circle", "diameter": 1.4, "density": 2700.0}
    joint = {"stiffness": 5e9, "damping": 1e-3}
    curve = capacity_curve(Column.from_dict({"name": "round", "joint": joint, "block": [drum] * 3}))
    assert unbalance(curve) < 1e-8
    for i in (1, 2):
        k = int(np.argmin(np.abs(curve.acceleration - curve.uplift[i])))
        assert curve.My[k, i] == pytest.approx(curve.N[k, i] * 1.4 / 8.0, rel=1e-6)  # R / 4
    assert curve.largest_acceleration < G * 0.7 / 3.0  # of a rigid column


def test_joints_that_may_slide_are_taken_as_stuck() -> None:
    column = phocas(eta=1e-3)
    slippery = tuple(replace(block, joint=replace(block.joint, friction=0.05)) for block in column.blocks)
    curve = capacity_curve(replace(column, blocks=slippery))
    assert curve.acceleration == pytest.approx(capacity_curve(column).acceleration, abs=1e-12)
    assert curve.friction > 0.05
    modes = natural_modes(replace(column, blocks=slippery))
    assert modes.damping_ratio == pytest.approx(natural_modes(column).damping_ratio, rel=1e-9)


@pytest.mark.parametrize("direction", [0, 2, -1.5, True, "x"])
def test_a_push_has_one_of_two_directions(direction: Any) -> None:  # others scaled the curve
    with pytest.raises(InputError, match=r"direction = .*: must be 1 or -1"):
        capacity_curve(phocas(), direction)


def test_curve_of_the_other_direction_is_the_mirror_image() -> None:
    right, left = capacity_curve(phocas()), capacity_curve(phocas(), direction=-1)
    assert left.ux == pytest.approx(-right.ux, abs=1e-12)
    assert left.acceleration == pytest.approx(right.acceleration, abs=1e-12)
    assert left.base_moment == pytest.approx(right.base_moment, rel=1e-9)
    assert left.overturning_displacement == pytest.approx(right.overturning_displacement, rel=1e-9)


def test_displacement_that_turns_back_does_not_end_the_curve() -> None:
    curve = capacity_curve(random_column(np.random.default_rng(24), 3, softest=3e7))
    assert np.min(np.diff(curve.ux[:, 0])) < -1e-3  # m; measured -9e-3
    assert curve.acceleration[-1] == pytest.approx(0.0, abs=1e-9)
    assert unbalance(curve) < 1e-8


def test_joints_open_a_little_before_the_kern_of_an_undeformed_column() -> None:
    found = uplift_accelerations(phocas()) / G
    rigid = np.array([1.56 / 6.0 / height for height in (2.345, 4.69, 7.035)])
    assert math.isnan(found[0])  # 0.1109 g is more than it balances
    assert np.all(found[1:] < rigid[1:])
    assert found[1:] == pytest.approx(rigid[1:], rel=0.005)  # measured 0.0036: the weight moves along


def pushed_slowly(column: Column, most: float) -> Response:
    """Return a push towards +x that grows to `most` m/s2 within 80 s and stays for another 40 s."""
    growth = 0.5 * (1.0 - np.cos(np.pi * np.minimum(1.0, np.linspace(0.0, 1.5, 1201))))
    return simulate(column, Motion.from_samples(0.1, -most * growth), settle=0.0)


def test_column_that_is_pushed_slowly_falls_beyond_its_capacity_only() -> None:
    column = phocas(eta=1e-2)
    curve = capacity_curve(column)
    k = curve.strongest - 6
    assert curve.acceleration[k] > 0.97 * curve.largest_acceleration
    run = pushed_slowly(column, float(curve.acceleration[k]))
    assert run.ux[-1] == pytest.approx(curve.ux[k], rel=5e-3)  # measured 1.7e-3: it still sways
    assert pushed_slowly(column, 1.005 * curve.largest_acceleration).overturned


def test_rest_is_what_carries_the_weight() -> None:
    column = phocas()
    rest = rest_of(column)
    assert rest.settlement == pytest.approx(settled(column), rel=1e-12)
    assert pytest.approx(27000.0 * G * np.array([1.0, 2.0, 3.0]), rel=1e-12) == rest.N
    assert rest.stress == pytest.approx(rest.N / 1.56**2, rel=1e-9)
    assert np.all(rest.contact == 1.0)


def test_what_cannot_stand_is_refused() -> None:
    column = phocas()
    with pytest.raises(InputError, match=r"^g = 0\.0"):
        capacity_curve(replace(column, g=0.0))
    soft = tuple(replace(block, joint=replace(block.joint, stiffness=1e6)) for block in column.blocks)
    with pytest.raises(SolverError, match="not stable"):
        capacity_curve(replace(column, blocks=soft))


# --- modes


@pytest.mark.parametrize("formulation", ["exact", "paper"])
def test_modes_have_the_natural_frequencies_and_all_of_the_mass(formulation: str) -> None:
    column = phocas(eta=1e-3)
    modes = natural_modes(column, formulation)
    assert modes.frequency == pytest.approx(natural_frequencies(column, formulation), rel=1e-12)
    stepper = Stepper(column.with_settings(formulation=formulation))
    stepper.observe(0.0)
    follows = stepper.split[3]  # effective mass: what follows the base at once
    assert np.sum(modes.mass_x) + follows == pytest.approx(81000.0, rel=1e-12)  # measured 1e-14
    assert np.sum(modes.mass_z) == pytest.approx(81000.0, rel=1e-12)
    assert list(modes.sways) == [True, True, False, True, False, False]


def test_modes_of_a_column_that_leans_have_all_of_the_mass() -> None:
    joint = Joint(5e9, 1e-3, offset=0.03, inclination=0.02)
    column = replace(phocas(), blocks=tuple(replace(block, tilt=0.01, joint=joint) for block in phocas().blocks))
    modes, stepper = natural_modes(column), Stepper(column)
    stepper.observe(0.0)
    for masses, follows in ((modes.mass_x, stepper.split[3]), (modes.mass_z, stepper.split[6])):
        assert np.sum(masses) + follows == pytest.approx(81000.0, rel=1e-9)


def test_shape_of_a_mode_goes_on_in_the_same_shape() -> None:
    column = phocas(tolerance=1e-10)
    modes = natural_modes(column)
    for k in np.flatnonzero(modes.sways):
        run = simulate(column, NIGH, 0.5, initial=InitialState(rotation=1e-8 * modes.ry[k]))
        swung = 1e-8 * modes.ux[k] * np.cos(2.0 * np.pi * modes.frequency[k] * run.time)[:, None]
        assert run.ux == pytest.approx(swung, abs=1e-13)  # measured 6e-15


def test_damping_ratio_is_that_of_the_decay() -> None:
    column = phocas(eta=1e-3, tolerance=1e-9)
    modes = natural_modes(column)
    ratio, omega = modes.damping_ratio[0], 2.0 * np.pi * modes.frequency[0]
    run = simulate(column, NIGH, initial=InitialState(rotation=1e-8 * modes.ry[0]), output_step=1e-3)
    envelope = np.exp(-ratio * omega * run.time)
    swung = envelope * np.cos(omega * math.sqrt(1.0 - ratio * ratio) * run.time)
    # measured 9.5e-3: a start without velocity, and a little of the other modes
    assert run.ux[:, 0] == pytest.approx(1e-8 * swung, abs=2e-2 * 1e-8)
    assert ratio == pytest.approx(np.pi * modes.frequency[0] * 1e-3, rel=5e-3)  # gravity leaves it 0.3 % higher


# --- the commands


def test_commands_write_what_the_functions_find(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    column = COLUMNS / "phocas-damped.toml"
    outputs = {name: tmp_path / f"{name}.csv" for name in ("statics", "modes")}
    for name, path in outputs.items():
        assert main([name, str(column), "-o", str(path), "--plot", str(path.with_suffix(".png"))]) == 0
        assert path.with_suffix(".png").read_bytes().startswith(b"\x89PNG")
    text = capsys.readouterr().out
    assert "balances a steady 0.096416 g at most" in text
    assert "   1         3.05805" in text
    rows = list(csv.DictReader(outputs["statics"].open(encoding="utf-8")))
    curve = capacity_curve(Column.from_toml(column))
    assert [float(row["acceleration"]) for row in rows] == list(curve.acceleration)
    assert [float(row["block[1].ux"]) for row in rows] == list(curve.ux[:, 0])
    modes = list(csv.DictReader(outputs["modes"].open(encoding="utf-8")))
    assert float(modes[0]["frequency"]) == pytest.approx(3.05805407, abs=1e-8)


def test_commands_say_what_is_wrong(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    column = COLUMNS / "phocas-damped.toml"
    assert main(["statics", str(column), "-o", str(tmp_path / "curve.txt")]) == 2
    assert capsys.readouterr().err.endswith("curve.txt: must end in .csv\n")
    assert main(["modes", str(tmp_path / "missing.toml")]) == 2
    assert "missing.toml: No such file" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("shift", "strength", "dowel"),
    [pytest.param(0.0, 1e5, 0.0, marks=pytest.mark.long), (0.6, 0.0, 0.0), (0.6, 5e3, 2e4)],  # takes seconds
)
def test_the_friction_used_counts_the_cohesion_of_what_is_bonded(shift: float, strength: float, dowel: float) -> None:
    """Check a block on a slope of 1 in 2, bonded; one that is sheared by `shift` (m) has cracked under its weight.

    Over the bonded length L the pressure is linear, down to the tension at which it cracks: with the resultant N at a
    distance a from the toe, tension L^2 / 6 - N L / 3 + N a = 0 per depth.
    """
    slope, friction, cohesion = math.hypot(1.0, 0.5), 0.3, 1e5
    law = {"stiffness": 1e11, "damping": 1e-4, "friction": friction, "tensile_strength": strength}
    block = {"name": "a", "shape": "prism", "position": [0.0, 0.0, 0.0], "depth": 1.0, "density": 2500.0}
    block["outline"] = [[0.0, 0.0], [1.0, 0.5], [1.0 + shift, 1.5], [shift, 1.5]]
    joint = {"between": ["a", "base"], "at": [0.5, 0.0, 0.25], "normal": [-0.5, 0.0, 1.0], "section": "rectangle"}
    joint |= {"width": slope, "depth": 1.0, "dowel": dowel}
    data = {"name": "m", "joints": law | {"cohesion": cohesion}, "block": [block], "joint": [joint]}
    found = push_over(Structure.from_dict(data))
    normal, along = (part * found.model.weight / slope for part in (1.0, 0.5))
    length, from_toe = slope, slope * (1.0 - float(found.model.blocks[0].centroid[0]))
    if shift:
        root = math.sqrt((normal / 3.0) ** 2 - 2.0 / 3.0 * strength * normal * from_toe)
        length = 3.0 * (normal / 3.0 - root) / strength if strength else 3.0 * from_toe
        assert length < 0.8 * slope
    limit = friction * normal + dowel + cohesion * length
    assert _friction_used(found)[0] == pytest.approx(
        along / limit, rel=1e-5
    )  # measured 1.2e-6: the joint gives a little
    assert rest_in_space_report(found).splitlines()[2].endswith(f"{along / limit:.3f}")


@pytest.mark.parametrize(
    ("force", "factor", "limit", "reason"),
    [
        (1e4, 2.157463, "at most", "no balance is found beyond 2.1575 times the pattern"),
        (-1e5, None, "at least", "it was not followed further than 50 points, up to "),
    ],
)
def test_loads_that_lift_or_press_a_column_have_a_curve(
    force: float,
    factor: float | None,
    limit: str,
    reason: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """Check that pushes are factors, in its plane and in space, where loads lift the top block or press it down."""
    monkeypatch.setattr("solver.models.column.push.MOST_POINTS", 50)
    file, picture = tmp_path / "pat.toml", tmp_path / "curve.png"
    file.write_text(
        'name = "pat"\n[joint]\nstiffness = 1e10\ndamping = 1e-3\n[[block]]\nrepeat = 3\nheight = 1.0\nwidth = 0.8\n'
        'depth = 1.1\ndensity = 2500.0\n[[port]]\nname = "p"\nblock = "block1"\nat = [0.0, 0.5]\n',
        encoding="utf-8",
    )
    assert main(["statics", str(file), "--pattern", f"p.Fz={force:g}", "--plot", str(picture)]) == 0
    text = capsys.readouterr().out
    assert f"times the pattern {limit}: base shear" in text
    assert f"the curve ends before the push is zero again: {reason}" in text
    assert "stiffness is in" not in text
    column = Column.from_toml(file)
    curve, path = capacity_curve(column, pattern={"p.Fz": force}), push_over(column.in_space(), pattern={"p.Fz": force})
    assert math.isnan(curve.overturning_displacement)
    assert curve.friction == 0.0
    assert path.limit == limit
    if factor is None:
        # 10 g as a factor: of the weight of three blocks
        assert path.ends == "it was not pushed further than 6.4724 times the pattern"
    else:
        # the weight of the block: measured 3e-6, in space 2e-16
        assert curve.largest_acceleration == pytest.approx(factor, rel=1e-5)
        assert path.largest_acceleration == pytest.approx(factor, rel=1e-9)


def test_a_column_off_its_axis_is_pushed_to_its_weaker_side(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Check a block 0.1 m over an edge: rigid, it balances b / h = 0.3 and 0.4 g; its mirror image prints the same."""
    found = []
    for sign, weaker, stronger in ((1.0, "+x", "-x"), (-1.0, "-x", "+x")):
        file, table, picture = (tmp_path / f"aside.{kind}" for kind in ("toml", "csv", "svg"))
        file.write_text(
            'name = "aside"\njoint = {stiffness = 1e13, damping = 1e-4}\n'
            f"[[block]]\nheight = 2.0\nwidth = 0.8\ndepth = 0.8\nmass = 3000.0\njoint = {{offset = {0.1 * sign}}}\n"
            "[[block]]\nheight = 0.5\nwidth = 3.0\ndepth = 3.0\ntop_width = 0.8\ntop_depth = 0.8\nmass = 5000.0\n",
            encoding="utf-8",
        )
        assert main(["statics", str(file), "-o", str(table), "--plot", str(picture), "--force"]) == 0
        said = capsys.readouterr().out
        sides = re.escape(f"towards {weaker}, the weaker side; towards {stronger} it balances ")
        other = re.search(f"{sides}(.*) g at most", said)
        push = re.search(r"balances a steady (.*) g at most: base shear", said)
        assert push is not None
        assert other is not None
        assert float(push[1]) == pytest.approx(0.3, rel=1e-2)  # measured: 6e-3 less
        assert float(other[1]) == pytest.approx(0.4, rel=1e-2)
        with table.open(encoding="utf-8", newline="") as rows:
            written = max(float(row["acceleration"]) for row in csv.DictReader(rows))
        assert written / G == pytest.approx(float(push[1]), rel=1e-4)
        assert f"towards {weaker}" in picture.read_text(encoding="utf-8")
        found.append(said.replace(weaker, "weaker").replace(stronger, "stronger"))
    assert found[0] == found[1]
    # on its axis it is the same either way
    assert main(["statics", str(COLUMNS / "phocas-damped.toml")]) == 0
    assert "towards" not in capsys.readouterr().out


def test_a_picture_of_loads_has_no_acceleration() -> None:
    """Check the axes on the right of both shears: a push by loads is a factor, not an acceleration of the mass."""
    block = {"repeat": 2, "height": 1.0, "width": 0.8, "depth": 1.1, "density": 2500.0}
    port = {"name": "p", "block": "block1", "at": [0.0, 0.5]}
    law = {"stiffness": 1e10, "damping": 1e-3}
    column = Column.from_dict({"name": "pat", "joint": law, "block": [block], "port": [port]})
    for pattern, labels in ((None, ["acceleration (g)"] * 2), ({"p.Fx": 1e4}, [])):
        figure = plot_capacity(capacity_curve(column, pattern=pattern))
        beside: list[Any] = [one for axes in figure.axes for one in axes.child_axes]
        assert [one.get_ylabel() for one in beside] == labels
