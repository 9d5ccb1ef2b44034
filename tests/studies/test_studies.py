"""A study: its plan, the same numbers whoever makes them, nothing lost and nothing twice when it is killed."""

from __future__ import annotations

import copy
import math
import random
import re
import time
import tomllib
from collections.abc import Iterator
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import replace
from datetime import date
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy import stats
from support.fmus import ROOT
from support.study import TEXT, same, start

from multiblock import Building, Load, Structure, floor_motion
from solver import Column, InputError, Motion, simulate
from solver.commands.command_line import main
from solver.commands.study import summary
from solver.common import effort
from solver.ground.motion import STANDARD_GRAVITY
from solver.models.column.numbers import column_with
from solver.studies import (
    Distribution,
    Measure,
    Random,
    Results,
    Shaking,
    Study,
    StudyError,
    chunks,
    ida_curves,
    influences,
    run_study,
)
from solver.studies.definition import _digest, axis
from solver.studies.journal import read_journal
from solver.studies.motions import tilted
from solver.studies.results import results_of

DAMPED = ROOT / "examples" / "columns" / "phocas-damped.toml"


@pytest.fixture
def study(folder: Path) -> Study:
    return Study.from_toml(folder / "study.toml")


# the plan


def test_runs_are_what_simulate_makes(study: Study) -> None:
    results = run_study(study)
    assert (len(results), results.complete, study.shape) == (24, True, (1, 1, 2, 12))
    for number in (0, 13, 23):
        (column, motion, duration), values, measures = study.run(number)
        assert isinstance(column, Column)
        frequency = values["motion.frequency"]
        assert motion.pga == pytest.approx(STANDARD_GRAVITY * (0.2, 0.6)[number // 12], rel=1e-12)
        assert duration == pytest.approx(4.0 / frequency)
        assert column.blocks[0].joint.stiffness == 1e9 * values["joint.stiffness"]
        assert measures["pga"] == pytest.approx(values["intensity"], rel=1e-12)
        # a Ricker wavelet's largest velocity is A exp(-1/2) / (pi f sqrt(2)); 400 lines to a cycle
        closed = motion.pga * math.exp(-0.5) / (math.pi * frequency * math.sqrt(2.0))
        assert measures["pgv"] == pytest.approx(closed, rel=1e-4)
        alone = simulate(column, motion, duration)
        assert results["peak_ux"][number] == pytest.approx(alone.peak_top_ux, rel=3e-3)  # 3 tolerances
        assert results["verdict"][number] == alone.verdict
        assert results["joint.stiffness"][number] == values["joint.stiffness"]


def test_the_same_samples_at_every_point_of_the_grid(study: Study) -> None:
    for number in range(12):
        first, second = study.values(number), study.values(number + 12)
        assert first.pop("intensity") == 0.2
        assert second.pop("intensity") == 0.6
        assert first == second


@pytest.mark.parametrize("sampling", ["latin-hypercube", "sobol", "random"])
def test_samples_are_distributed_as_they_should(study: Study, sampling: str) -> None:
    many = Study(
        **{**vars(study), "samples": 512, "sampling": sampling},
    )
    drawn = np.array([[many.values(k)[name] for name in many.varied[3:]] for k in range(512)])
    for k, wanted in enumerate((stats.lognorm(0.3), stats.uniform(0.5, 1.5))):
        # of plain random numbers 1 in 1000 differs by more than 0.086; the others are far more even
        most = 0.086 if sampling == "random" else 0.01
        assert stats.kstest(drawn[:, k], wanted.cdf).statistic < most


@pytest.mark.parametrize(
    ("table", "wanted"),
    [
        ({"distribution": "uniform", "low": -1.0, "high": 3.0}, stats.uniform(-1.0, 4.0)),
        ({"distribution": "loguniform", "low": 0.1, "high": 3.0}, stats.loguniform(0.1, 3.0)),
        ({"distribution": "triangular", "low": 1.0, "mode": 1.5, "high": 3.0}, stats.triang(0.25, 1.0, 2.0)),
        ({"distribution": "normal", "mean": 2.0, "deviation": 0.5}, stats.norm(2.0, 0.5)),
        ({"distribution": "lognormal", "median": 2.0, "deviation": 0.5}, stats.lognorm(0.5, scale=2.0)),
        (
            {"distribution": "normal", "mean": 2.0, "deviation": 0.5, "low": 1.5, "high": 4.0},
            stats.truncnorm(-1.0, 4.0, 2.0, 0.5),
        ),
        # one tail alone
        *(
            (
                {"distribution": "normal", "mean": 1.0, "deviation": 0.02, **ends},
                stats.truncnorm(*((end - 1.0) / 0.02 for end in wanted), 1.0, 0.02),
            )
            for ends, wanted in (
                ({"low": 1.2}, (1.2, np.inf)),
                ({"low": 1.16, "high": 1.3}, (1.16, 1.3)),
                ({"low": 1.001, "high": 1.01}, (1.001, 1.01)),
                ({"high": 0.8}, (-np.inf, 0.8)),
                ({"low": 0.1, "high": 0.2}, (0.1, 0.2)),
            )
        ),
        (
            {"distribution": "normal", "mean": 2.0, "deviation": 0.5, "low": 10.0, "high": 11.0},
            stats.truncnorm(16.0, 18.0, 2.0, 0.5),
        ),
    ],
)
def test_distributions(table: dict[str, Any], wanted: Any) -> None:
    found = Distribution.from_table("key", table)
    quantiles = np.linspace(0.001, 0.999, 97)
    np.testing.assert_allclose(found.at(quantiles), wanted.ppf(quantiles), rtol=1e-9)
    assert Distribution.from_table("key", found.to_table()) == found


def test_distributions_of_few_values() -> None:
    quantiles = (np.arange(12) + 0.5) / 12
    whole = Distribution.from_table("key", {"distribution": "integers", "low": 3, "high": 5})
    assert whole.at(quantiles).tolist() == [3.0] * 4 + [4.0] * 4 + [5.0] * 4
    few = Distribution.from_table("key", {"distribution": "choice", "values": [7.0, 1.0]})
    assert few.at(quantiles).tolist() == [7.0] * 6 + [1.0] * 6


def test_numbers_of_a_column_by_name() -> None:
    column = Column.from_toml(DAMPED)
    changed = column_with(
        column,
        {
            "joint.damping": (2.0, True),
            "joint[3].width": (1.2, False),
            "block[1].height": (5.0, False),
            "g": (9.0, False),
        },
    )
    assert [block.joint.damping for block in changed.blocks] == [2e-3] * 3
    assert [block.joint_width for block in changed.blocks] == [1.56, 1.56, 1.2]
    assert [block.height for block in changed.blocks] == [5.0, 4.69, 4.69]
    assert changed.g == 9.0
    twice = column_with(column, {"column.size": (2.0, False)})
    assert [(block.height, block.width, block.depth, block.mass) for block in twice.blocks] == [
        (9.38, 3.12, 3.12, 8 * 27000.0)
    ] * 3
    slender = column_with(column, {"column.slenderness": (18.0, False), "column.size": (2.0, False)})
    assert sum(block.height for block in slender.blocks) / slender.blocks[-1].width == pytest.approx(18.0)
    ratio = slender.blocks[0].width * slender.blocks[0].depth * slender.blocks[0].height / slender.blocks[0].mass
    assert ratio == pytest.approx(1.56**2 * 4.69 / 27000.0)


STONE = {"height": 2.0, "width": 0.6, "depth": 0.5, "density": 2400.0, "joint": {"stiffness": 1e9, "damping": 1e-3}}


@pytest.mark.parametrize(
    ("values", "mass"),
    [
        ({"block.height": (4.0, False), "block[1].width": (1.2, False)}, 2400.0 * 4.0 * 1.2 * 0.5),
        ({"block.depth": (3.0, True)}, 2400.0 * 2.0 * 0.6 * 1.5),
        ({"block.density": (1.5, True), "block.height": (3.0, False)}, 3600.0 * 3.0 * 0.6 * 0.5),
        ({"block.mass": (1.5, True)}, 3600.0 * 2.0 * 0.6 * 0.5),
        ({"block.mass": (800.0, False), "block.height": (3.0, False)}, 800.0),
        ({"column.size": (2.0, False)}, 8 * 2400.0 * 2.0 * 0.6 * 0.5),
        ({"column.slenderness": (5.0, False)}, 2400.0 * 2.0 * 0.4 * 0.5 * 0.4 / 0.6),
    ],
)
def test_the_mass_follows_a_given_density(values: dict[str, tuple[float, bool]], mass: float) -> None:
    column = Column.from_dict({"name": "c", "block": [STONE]})
    assert column_with(column, values).blocks[0].mass == pytest.approx(mass, rel=1e-14)
    stack = column.in_space()
    assert stack.kind.with_numbers(stack, values).blocks[0].mass == pytest.approx(mass, rel=1e-14)


def test_the_mass_of_a_tapered_block_follows_its_height() -> None:
    """Check a frustum, whose volume is height / 3 (a**2 + a b + b**2) with the sides a and b."""
    sides = {"width": 0.6, "depth": 0.6, "top_width": 0.3, "top_depth": 0.3}
    column = Column.from_dict({"name": "c", "block": [STONE | sides]})
    taller = column_with(column, {"block.height": (3.0, False)})
    assert taller.blocks[0].mass == pytest.approx(2400.0 * (0.36 + 0.18 + 0.09), rel=1e-12)
    assert taller.across().blocks[0].mass == pytest.approx(taller.blocks[0].mass, rel=1e-12)


def test_a_diameter_is_varied() -> None:
    """Check a drum, tapered from 1 to 0.8 m over 2 m: volume pi h / 12 (D**2 + D d + d**2)."""
    drum = {"height": 2.0, "section": "circle", "diameter": 1.0, "top_diameter": 0.8, "density": 2000.0}
    joint = {"stiffness": 1e9, "damping": 1e-3, "diameter": 0.6}
    column = Column.from_dict({"name": "c", "block": [{**drum, "joint": joint}]})
    values = {"block.diameter": (1.2, False), "block[1].top_diameter": (0.5, True), "joint.diameter": (0.7, False)}
    block = column_with(column, values).blocks[0]
    assert (block.width, block.depth, block.top_width, block.top_depth, block.joint.width) == (1.2, 1.2, 0.4, 0.4, 0.7)
    assert block.mass == pytest.approx(2000.0 * math.pi * 2.0 / 12.0 * (1.44 + 0.48 + 0.16), rel=1e-12)
    square = Column.from_dict({"name": "c", "block": [STONE]})
    for name in ("block.diameter", "joint.diameter"):
        with pytest.raises(InputError, match="diameter: must be left out"):
            column_with(square, {name: (0.5, False)})


def test_a_given_mass_stays() -> None:
    """Check also that columns of equal numbers, one with a density and one with a mass, are told apart."""
    column = Column.from_dict({"name": "c", "block": [STONE]})
    of_mass = {key: value for key, value in STONE.items() if key != "density"} | {"mass": column.blocks[0].mass}
    same = Column.from_dict({"name": "c", "block": [of_mass]})
    assert same == column
    masses = [column_with(one, {"block.height": (4.0, False)}).blocks[0].mass for one in (column, same)]
    assert masses == pytest.approx([2880.0, 1440.0], rel=1e-14)


def test_a_block_that_was_changed_keeps_its_mass() -> None:
    column = Column.from_dict({"name": "c", "block": [STONE]})
    heavy = replace(column, blocks=(replace(column.blocks[0], mass=5000.0),))
    assert Column.from_dict(heavy.to_dict()).blocks[0].mass == 5000.0
    assert column_with(heavy, {"block.height": (4.0, False)}).blocks[0].mass == 5000.0


def test_a_load_stays_on_a_varied_block() -> None:
    """Check a cube of 1 m and 1000 kg that becomes 2 m high under a load of 500 kg, 0.5 m above its top face."""
    size = {"height": 1.0, "width": 1.0, "depth": 1.0}
    cube = STONE | size | {"density": 1000.0, "load": {"mass": 500.0, "above": 0.5}}
    column = Column.from_dict({"name": "c", "block": [cube]})
    assert Column.from_dict(column.to_dict()) == column
    block = column_with(column, {"block.height": (2.0, False)}).blocks[0]
    assert (block.mass, block.centroid) == pytest.approx((2500.0, 1.3))  # 2000 kg at 1 m, 500 kg at 2.5 m
    assert block.inertia == pytest.approx(2000.0 * (1.0 + 4.0) / 12.0 + 2000.0 * 0.3**2 + 500.0 * 1.2**2)
    heavy = column_with(column, {"block.density": (2000.0, False)}).blocks[0]
    assert (heavy.mass, heavy.centroid) == pytest.approx((2500.0, 0.7))  # 2000 kg at 0.5 m, 500 kg at 1.5 m
    once, twice = column.blocks[0], column_with(column, {"column.size": (2.0, False)}).blocks[0]
    assert (twice.mass, twice.resolved_centroid) == pytest.approx((8.0 * 1500.0, 2.0 * once.resolved_centroid))
    assert twice.resolved_inertia == pytest.approx(32.0 * once.resolved_inertia)


@pytest.mark.parametrize("extra", [{"load": {"mass": 300.0, "above": 0.2}}, {"inertia": 50.0}])
def test_slenderness_is_refused_at_once_where_an_inertia_would_not_follow(extra: dict[str, Any]) -> None:
    blocks = [{"height": 1.2, "width": 0.5, "depth": 0.5, "mass": 700.0, **block} for block in (extra, {})]
    column = Column.from_dict({"name": "c", "joint": {"stiffness": 1e9, "damping": 1e-3}, "block": blocks})
    pulse = Shaking("", "ricker", {"frequency": 1.0, "amplitude": 1.0})
    with pytest.raises(InputError, match=r"column.slenderness: block\[1\] must have no inertia or load"):
        Study("slender", "sweep", (column,), (pulse,), grid={"column.slenderness": (4.0,)})


def test_a_tilted_base_is_gravity_turned() -> None:
    """Check that at rest on a base that leans by psi the lowest joint carries N = m g cos(psi) and S = m g sin(psi)."""
    angle = 0.02
    column = Column.from_toml(DAMPED).with_settings(tolerance=1e-9)
    flat = Motion.from_samples(0.01, np.zeros(1501))
    leaning = tilted(flat, angle)
    response = simulate(column, leaning, settle=0.0)
    weight = 81000.0 * column.g
    # the ramp of 5 s is slow against the 0.3 s of the first mode: what is left of it, measured 1e-5
    assert response.N[-1, -1] == pytest.approx(weight * math.cos(angle), rel=1e-4)
    assert response.S[-1, -1] == pytest.approx(weight * math.sin(angle), rel=1e-3)
    assert response.ux[-1, 0] > 0.0  # clockwise


def test_a_tilted_base_turns_the_gravity_of_the_model(folder: Path) -> None:
    """Check the force along the joint, m g sin(psi) on the moon, given and varied."""
    (folder / "block.toml").write_text("g = 1.62\n" + STEPS, encoding="utf-8")
    (folder / "still.csv").write_text("0.0, 0.0\n1.0, 0.0\n", encoding="utf-8")
    table = {"motion": [{"record": "still.csv", "units": "g", "tilt": 0.02}]}
    for grid, g in (({}, 1.62), ({"g": [3.7]}, 3.7)):
        column, motion, duration = vary(folder, {**table, "grid": grid}).run(0).run
        response = simulate(column, motion, duration, settle=0.0)
        assert response.S[-1, -1] == pytest.approx(7500.0 * g * math.sin(0.02), rel=2e-3)
        assert response.N[-1, -1] == pytest.approx(7500.0 * g * math.cos(0.02), rel=1e-4)


def vary(folder: Path, changes: dict[str, Any], model: str = "column = 'block.toml'") -> Study:
    """Return a study of one run under a pulse of 3 m/s2 with other tables."""
    text = f'name = "one"\nkind = "sweep"\n{model}\n'
    pulse = {"formula": "ricker", "frequency": 1.0, "amplitude": 3.0}
    return Study.from_dict({**tomllib.loads(text), "motion": [pulse], **changes}, folder)


def drawn(median: float, relative: bool = False, each: bool = False) -> dict[str, Any]:
    """Return the table of a random number that hardly varies."""
    table = {"distribution": "lognormal", "median": median, "deviation": 1e-12}
    return {**table, "relative": relative, "each": each}


STEPS = "name = 'steps'\n[joint]\nstiffness = 1e9\ndamping = 1e-3\n" + 3 * (
    "[[block]]\nheight = 1.0\nwidth = 1.0\ndepth = 1.0\nmass = 2500.0\n"
)


@pytest.mark.parametrize("order", [1, -1])
def test_factors_multiply_what_the_grid_and_other_parameters_set(folder: Path, order: int) -> None:
    (folder / "block.toml").write_text(STEPS, encoding="utf-8")
    random = {"joint.damping": drawn(2.0, True), "joint[1].damping": drawn(7e-3), "joint.stiffness": drawn(3.0, True)}
    random["joint[1].stiffness"] = drawn(5.0, True)
    grid = {"joint[3].damping": [5e-3], "block[2].height": [1.5]}
    table = {"grid": grid, "random": dict([*random.items()][::order]) | {"block.height": drawn(2.0, True)}}
    blocks = vary(folder, table).run(0).run.model.blocks
    for found, wanted in (
        ([block.joint.damping for block in blocks], [14e-3, 2e-3, 10e-3]),
        ([block.joint.stiffness for block in blocks], [15e9, 3e9, 3e9]),
        ([block.height for block in blocks], [2.0, 3.0, 2.0]),
    ):
        assert found == pytest.approx(wanted, rel=1e-10)


@pytest.mark.parametrize(
    ("grid", "random", "message"),
    [
        (("joint[3].stiffness",), ("joint.stiffness",), "sets joint[3].stiffness as grid.joint[3].stiffness does"),
        ((), ("joint[2].width", "joint.width"), "sets joint[2].width as random.joint[2].width does"),
        ((), ("block.mass", "block[1].density"), "sets block[1].density as random.block.mass does"),
        (("column.slenderness", "block.width"), (), "sets block[1].width as grid.column.slenderness does"),
        (("motion.amplitude", "intensity"), (), "motion.amplitude: must be left out where intensity is varied"),
        (("intensity",), ("motion.amplitude",), "motion.amplitude: must be left out where intensity is varied"),
    ],
)
def test_two_names_of_one_number_are_refused(
    folder: Path, grid: tuple[str, ...], random: tuple[str, ...], message: str
) -> None:
    (folder / "block.toml").write_text(STEPS, encoding="utf-8")
    table = {"grid": {name: [1.0] for name in grid}, "random": {name: drawn(1.0) for name in random}}
    with pytest.raises(InputError, match=re.escape(message)):
        vary(folder, {**table, "intensity": {"measure": "pga"}})
    for name in (*grid, *random):  # one of them alone is valid
        one = {"grid": {name: [1.0]}} if name in grid else {"random": {name: drawn(1.0)}}
        vary(folder, {**one, "intensity": {"measure": "pga"}})


@pytest.mark.parametrize("place", ["motion", "grid", "random"])
def test_an_intensity_is_that_of_the_motion_as_run(folder: Path, place: str) -> None:
    """Check that the sign of a motion may vary beside its intensity; a factor would change the intensity."""

    def scaled(*values: float) -> Study:
        choice = {"distribution": "choice", "values": list(values)}
        pulse = {"formula": "ricker", "frequency": 1.0, "scale": values[0] if place == "motion" else 1.0}
        grid = {"intensity": [0.1, 0.3]} | ({"motion.scale": list(values)} if place == "grid" else {})
        random = {"motion.scale": choice} if place == "random" else {}
        table = {"motion": [pulse], "grid": grid, "random": random, "intensity": {"measure": "pga"}}
        return vary(folder, {**table, "kind": "ida"})

    study = scaled(-1.0, 1.0)
    for number in range(study.runs):
        planned = study.run(number)
        assert planned.run.motion.pga == pytest.approx(STANDARD_GRAVITY * planned.values["intensity"], rel=1e-12)
    key = r"motion\[1\].scale" if place == "motion" else f"{place}.motion.scale"
    with pytest.raises(InputError, match=f"{key}: must be 1, or -1 to reverse the motion, where intensity is varied"):
        scaled(2.0, 1.0)


def test_a_diameter_is_width_and_depth(folder: Path) -> None:
    round_one = STEPS.replace("width = 1.0\ndepth = 1.0\n", 'section = "circle"\ndiameter = 1.0\n')
    (folder / "block.toml").write_text(round_one, encoding="utf-8")
    vary(folder, {"grid": {"block.diameter": [1.0], "joint.diameter": [0.9]}})
    with pytest.raises(InputError, match=r"sets block\[1\].depth as grid.block.diameter does"):
        vary(folder, {"grid": {"block.diameter": [1.0], "block[1].depth": [0.9]}})


def test_an_intensity_has_no_factor(folder: Path) -> None:
    table = {"random": {"intensity": drawn(1.0, True)}, "intensity": {"measure": "pga"}}
    with pytest.raises(InputError, match=r"random.intensity.relative: must be left out"):
        vary(folder, table)


def test_axis() -> None:
    assert axis("grid.g", [1, 2.5]) == (1.0, 2.5)
    assert axis("grid.g", {"from": 0.25, "to": 1.0, "count": 4}) == (0.25, 0.5, 0.75, 1.0)
    assert axis("grid.g", {"from": 1, "to": 100, "count": 3, "spacing": "log"}) == (1.0, 10.0, 100.0)


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ('name = "small"', 'name = "../data"', "name = '../data': must be a file name"),
        ('name = "small"', 'name = "/tmp/data"', "name = '/tmp/data': must be a file name"),
        ('kind = "fragility"', 'kind = "ida"\nlimits = [0.5]', 'limits: must be left out, only kind = "fragility"'),
        ('kind = "fragility"', 'kind = "guess"', "kind = 'guess': must be one of sweep, ida"),
        ("samples = 12", "samples = 0", "samples = 0: must be a whole number, at least 1"),
        ("seed = 3", "sed = 3", "sed: unknown key"),
        ('formula = "ricker"', 'formula = "rick"', r"motion\[1\].formula = 'rick': must be one of harmonic"),
        ('formula = "ricker"', 'record = "none.AT2"', "none.AT2: No such file"),
        ('measure = "pga"', 'measure = "sa"', "intensity.period = None: must be a positive time"),
        ('[random."motion.frequency"]', '[random."motion.freq"]', "motion.freq: unknown name, the motions have"),
        ('[random."joint.stiffness"]', '[random."joints.stiffness"]', "joints.stiffness: unknown name"),
        ("median = 1.0", "mean = 1.0", "random.joint.stiffness.mean: unknown key of lognormal"),
        ("low = 0.5", "low = 2.5", "random.motion.frequency.high = 2.0: must be more than low = 2.5"),
        ("relative = true", 'relative = "yes"', "random.joint.stiffness.relative = 'yes': must be true or false"),
        ("intensity = [0.2, 0.6]", "intensity = []", "grid.intensity: is empty"),
        ("intensity = [0.2, 0.6]", "intensity = [0.2, -0.6]", "grid.intensity = -0.6: must be zero or positive"),
        ('column = "block.toml"', 'column = "none.toml"', "none.toml: No such file"),
        ("tolerance = 1e-3", "tolerance = 1", "tolerance = 1"),
        ('"verdict", "overturn_time"', '"verdict", "overturned"', "keep = 'overturned': must be one of peak_ux"),
        ('"verdict", "overturn_time"', '"overturn_time"', "keep: must have verdict"),
        ('"verdict", "overturn_time"', '"verdict", "verdict"', "keep: verdict must be there once"),
        ("intensity = [0.2, 0.6]", "intensity = [0.6, 0.2, 0.6]", "grid.intensity: has a value twice"),
        ("joint.stiffness", "joint.stifness", r"joint.stifness: block\[1\].joint.stifness: unknown key, must be one"),
        ("joint.stiffness", "joint[2].stiffness", r"joint\[2\].stiffness: there are 1 blocks"),
    ],
)
def test_a_wrong_study_is_refused_in_one_line(folder: Path, old: str, new: str, message: str) -> None:
    path = folder / "study.toml"
    text = path.read_text(encoding="utf-8")
    assert old in text
    path.write_text(text.replace(old, new), encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        Study.from_toml(path)
    assert "\n" not in str(caught.value)
    assert str(caught.value).startswith(str(path))


WRONG: tuple[Any, ...] = (
    [],
    {},
    ["x"],
    {"a": 1},
    "",
    7,
    True,
    math.nan,
    -1,
    10**400,
    10**5000,
    date(2020, 1, 1),
    None,
    [[1]],
    b"x",
)


def places(value: Any, place: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Yield the paths of keys and indices of every table, list and value inside."""
    if place:
        yield place
    keys = value if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ()
    for key in keys:
        yield from places(value[key], (*place, key))


def test_values_of_a_wrong_type_are_refused_in_one_line_wherever_they_are(folder: Path) -> None:
    """Replace each value of a study by each of `WRONG`: an InputError of one line of at most 440 letters, or none."""
    spec = tomllib.loads((folder / "study.toml").read_text(encoding="utf-8"))
    spec["random"]["block.width"] = {"distribution": "choice", "values": [1.0, 1.1]}
    spec["motion"][0] |= {"name": "pulse", "scale": 1.0}
    (folder / "plain.csv").write_text("0,0\n0.01,1\n0.02,0\n", encoding="utf-8")
    record = {"record": "plain.csv", "units": "g", "vertical": "plain.csv", "channel": 1}
    refused = 0
    for motion in (spec["motion"][0], record):
        whole = spec | {"motion": [motion]}
        for place in places(whole):
            for wrong in WRONG:
                changed = copy.deepcopy(whole)
                inner: Any = changed
                for key in place[:-1]:
                    inner = inner[key]
                inner[place[-1]] = wrong
                said = ""
                try:
                    Study.from_dict(changed, folder)
                except InputError as error:
                    said = str(error)
                except OSError:  # of a folder in place of a file
                    pass
                refused += bool(said)
                assert "\n" not in said
                assert len(said) < 440, (place, said[:200])
    assert refused > 500


def test_a_silent_record_cannot_be_scaled_to_an_intensity(study: Study) -> None:
    silent = Shaking("calm", record=Motion.from_samples(0.01, np.zeros(100)))
    odd = Study(**{**vars(study), "motions": (silent,), "random": {}, "samples": 1})
    with pytest.raises(InputError, match=r"motion\[1\]: calm has a PGA of zero, it cannot be scaled to an intensity"):
        odd.run(0)
    assert set(run_study(odd)["verdict"]) == {"failed"}


def test_a_draw_that_does_not_suit_is_noted_and_the_others_go_on(study: Study) -> None:
    """Draw a stiffness so small that the block cannot stand."""
    soft = Distribution.from_table("key", {"distribution": "choice", "values": [1.0, 1e-4]})
    odd = Study(
        **{
            **vars(study),
            "random": {"joint.stiffness": Random(soft, relative=True)},
            "grid": {"intensity": (0.2,)},
            "motions": (Shaking("ricker", "ricker", {"frequency": 1.0}),),
        }
    )
    results = run_study(odd)
    failed = results["joint.stiffness"] == 1e-4
    assert np.sum(failed) == 6
    assert set(results["verdict"][failed]) == {"failed"}
    assert np.all(np.isnan(results["peak_ux"][failed]))
    assert all("cannot stand" in text for text in results["failure"][failed])
    assert set(results["failure"][~failed]) == {""}


def test_a_negative_intensity_that_is_drawn_is_noted(study: Study) -> None:
    drawn = Distribution.from_table("key", {"distribution": "choice", "values": [0.2, -0.2]})
    pulse = (Shaking("ricker", "ricker", {"frequency": 1.0}),)
    random = {"intensity": Random(drawn, relative=False)}
    results = run_study(Study(**{**vars(study), "random": random, "grid": {}, "motions": pulse}))
    below = results["intensity"] < 0.0
    assert 0 < np.sum(below) < len(below)
    assert set(results["failure"][below]) == {"intensity = -0.2: is drawn, must be zero or positive"}
    assert set(results["failure"][~below]) == {""}


def test_what_the_results_depend_on_is_in_the_fingerprint(study: Study) -> None:
    others: list[dict[str, Any]] = [
        {"seed": 4},
        {"samples": 13},
        {"tolerance": 1e-4},
        {"columns": (Column.from_toml(DAMPED),)},
        {"measure": Measure("pgv")},
        {"motions": (Shaking("ricker", record=Motion.from_samples(0.1, [1.0, 2.0])),)},
        {"motions": (Shaking("ricker", record=Motion.from_samples(0.1, [1.0, 2.5])),)},
        {"grid": {"intensity": (0.2, 0.7)}},
        {"keep": ("peak_ux", "verdict")},
    ]
    prints = {study.fingerprint}
    for other in others:
        random_part = {"random": {}, "samples": 1} if "motions" in other else {}
        prints.add(Study(**{**vars(study), **random_part, **other}).fingerprint)
    assert len(prints) == len(others) + 1
    assert Study(**vars(study)).fingerprint == study.fingerprint


# ways to make the runs


class Shuffled:
    """An executor that works its chunks off in any order, late, some of them only at the second try."""

    def __init__(self, seed: int) -> None:
        self._random = random.Random(seed)
        self._pool = ThreadPoolExecutor(3)
        self._max_workers = 8
        self._waiting: list[tuple[Future[Any], Any]] = []

    def submit(self, function: Any, *arguments: Any) -> Future[Any]:
        future: Future[Any] = Future()
        self._waiting.append((future, (function, arguments)))
        self._pool.submit(self._work)
        return future

    def _work(self) -> None:
        time.sleep(0.01 * self._random.random())
        future, (function, arguments) = self._waiting.pop(self._random.randrange(len(self._waiting)))
        if self._random.random() < 0.2:
            future.set_exception(OSError("the worker died"))
        else:
            future.set_result(function(*arguments))


def test_the_same_bits_whoever_makes_the_runs(study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    whole = run_study(study, threads=1)
    for workers in (3, 8):
        assert same(run_study(study, threads=workers), whole)
    monkeypatch.setattr("solver.runs.pace.WIDTH", 1)
    monkeypatch.setattr("solver.studies.execution.TRIES", 9)
    for seed in range(3):
        other = tmp_path / str(seed)
        other.mkdir()
        assert same(run_study(study, other, executor=Shuffled(seed), chunk_seconds=1e-4), whole)
        _, rows = read_journal(other / "small.journal")
        assert sorted(row[0] for row in rows) == list(range(24))
        lines = (other / "small.journal").read_bytes().count(b"\n")
        assert lines == 25  # a head and each run once


def test_a_table_is_put_together_in_parts_of_any_size(
    study: Study, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    whole = run_study(Study(**{**vars(study), "keep": ("peak_ux", "verdict", "steps", "path")}), tmp_path)
    head, rows = read_journal(tmp_path / "small.journal")
    made = list(rows)
    made[5][3], made[5][4] = None, "could not be made"  # integers become numbers, and NaN here
    text = (tmp_path / "small.csv").read_text(encoding="utf-8")
    other = Results(head, made)
    assert [whole["steps"].dtype.kind, other["steps"].dtype.kind] == ["i", "f"]
    for size in (1, 7, 24):
        monkeypatch.setattr("solver.studies.results.ROWS_AT_ONCE", size)
        assert same(Results.from_journal(tmp_path / "small.journal"), whole)
        assert same(Results(head, [*reversed(made)]), other)
        assert same(Results(head, [*made, *reversed(made)]), other)
        whole.to_csv(tmp_path / "again.csv")
        assert (tmp_path / "again.csv").read_text(encoding="utf-8") == text


def test_csv_and_netcdf_hold_the_same(study: Study, folder: Path) -> None:
    import xarray

    results = run_study(study, folder)
    text = np.genfromtxt(folder / "small.csv", delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="")
    np.testing.assert_array_equal(text["peak_ux[1]"], results["peak_ux"][:, 0])
    np.testing.assert_array_equal(text["joint.stiffness"], results["joint.stiffness"])
    assert text["verdict"].tolist() == results["verdict"].tolist()
    with xarray.open_dataset(folder / "small.nc") as data:
        assert dict(data.sizes) == {"run": 24, "block": 1}
        np.testing.assert_array_equal(data["peak_ux"], results["peak_ux"])
        np.testing.assert_array_equal(data["overturn_time"], results["overturn_time"])
        assert data["verdict"].values.tolist() == results["verdict"].tolist()
        assert data.attrs["fingerprint"] == study.fingerprint
        assert data["peak_ux"].attrs["units"] == "m"


def test_a_study_keeps_any_peak(study: Study, folder: Path) -> None:
    import xarray

    keep = ("peak_ux", "verdict", "peak_N", "least_contact", "peak_Fx")
    asked = Study(**{**vars(study), "samples": 2, "keep": keep})
    results = run_study(asked, folder)
    for number in range(4):
        single = simulate(*asked.run(number).run)
        assert results["peak_N"][number] == single.peaks["N"]
        assert results["least_contact"][number] == single.peaks["contact"]
        assert results["peak_Fx"][number] == single.peaks["base_Fx"][0]
    with xarray.open_dataset(folder / "small.nc") as data:
        assert [data[name].attrs.get("units") for name in ("peak_N", "least_contact", "peak_Fx")] == ["N", None, "N"]
        assert data["peak_Fx"].dims == ("run",)
        np.testing.assert_array_equal(data["peak_N"], results["peak_N"])


class Dies:
    """An executor of which the third chunk, and all after it, never come back."""

    def __init__(self) -> None:
        self.sent = 0
        self._max_workers = 1

    def submit(self, function: Any, *arguments: Any) -> Future[Any]:
        self.sent += 1
        future: Future[Any] = Future()
        if self.sent < 3:
            future.set_result(function(*arguments))
        return future

    def lost(self) -> str:
        return "it has gone" if self.sent >= 3 else ""


def test_an_executor_that_goes_away_leaves_what_was_finished(
    study: Study, folder: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("solver.runs.pace.WIDTH", 4)
    with pytest.raises(StudyError, match="it has gone; finished runs are kept, run the study again to go on"):
        run_study(study, folder, executor=Dies(), chunk_seconds=1e-4)
    kept = len(Results.from_journal(folder / "small.journal"))
    assert 0 < kept < 24
    made: list[int] = []
    make = chunks.make

    def counted(of: Study, numbers: list[int]) -> chunks.Made:
        made.extend(numbers)
        return make(of, numbers)

    monkeypatch.setattr("solver.studies.chunks.make", counted)
    results = run_study(study, folder)
    assert len(made) == len(set(made)) == 24 - kept
    assert same(results, run_study(study))


def test_a_mistake_in_a_chunk_ends_the_study(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    """Put all runs into one chunk."""

    def wrong(*_: object) -> None:
        raise ZeroDivisionError("division by zero")

    monkeypatch.setattr("solver.studies.chunks.make", wrong)
    with pytest.raises(StudyError, match="runs 0 to 23: ZeroDivisionError: division by zero"):
        run_study(study, threads=1)


def test_another_study_is_refused(study: Study, folder: Path) -> None:
    run_study(study, folder)
    with pytest.raises(InputError, match="holds another study, small"):
        run_study(study.with_runs(13), folder)


def test_a_table_without_its_journal_is_not_overwritten(study: Study, tmp_path: Path) -> None:
    table = tmp_path / f"{study.name}.csv"
    table.write_text("a record of the same name")
    with pytest.raises(InputError, match=r"is there already, without .*journal: must be moved"):
        run_study(study, tmp_path)
    assert table.read_text() == "a record of the same name"


@pytest.mark.parametrize("name", ["", " ", ".", "..", "a/b", "a\\b", "a.", " a", "a ", "a\n", "a\0", "a:b", "\udcff"])
def test_a_name_is_a_file_name(study: Study, name: str) -> None:
    with pytest.raises(InputError, match=r"name = .*: must be a file name of letters, digits, "):
        Study(**{**vars(study), "name": name})


@pytest.mark.long  # takes seconds
def test_a_name_with_dots_is_written_and_printed_in_full(study: Study, folder: Path) -> None:
    (folder / "study.toml").write_text(TEXT.format(samples=1).replace('"small"', '"v1.2 b"'), encoding="utf-8")
    process = start(folder, "run", "study.toml")
    out, errors = process.communicate()
    assert (process.returncode, errors) == (0, "")
    listed = out.splitlines()[-3:]
    assert listed == [str(folder / f"v1.2 b{end}") for end in (".journal", ".csv", ".nc")]
    assert all(Path(path).is_file() for path in listed)


def test_motions_are_named(study: Study, folder: Path) -> None:
    motions = tuple(Shaking(name, "ricker", {"frequency": 1.0}) for name in ("one", "other"))
    results = run_study(Study(**{**vars(study), "motions": motions, "random": {}, "samples": 1}), folder)
    assert results["motion_name"].tolist() == ["one", "one", "other", "other"]
    text = np.genfromtxt(folder / "small.csv", delimiter=",", names=True, dtype=None, encoding="utf-8", deletechars="")
    assert text["motion_name"].tolist() == results["motion_name"].tolist()


def test_a_quick_study_is_one_of_its_own(study: Study) -> None:
    long = Study(**{**vars(study), "grid": {"intensity": tuple(0.1 * k for k in range(1, 21))}, "samples": 1000})
    quick = long.quick()
    assert (quick.name, quick.runs, quick.shape) == ("small-quick", 200, (1, 1, 5, 40))
    assert [quick.grid["intensity"][k] for k in (0, -1)] == [0.1, 2.0]
    assert study.quick().runs == study.runs  # is quick as it is


# the command


@pytest.mark.long
def test_the_command(folder: Path) -> None:
    def ended(*words: object) -> tuple[int, str, str]:
        process = start(folder, *words)
        out, errors = process.communicate()
        return process.returncode, out, errors

    code, out, errors = ended("show", "study.toml")
    assert (code, out) == (2, "")
    assert "small.journal: No such file: the study has not been run here" in errors
    code, out, errors = ended("run", "study.toml", "--processes", 2)
    assert code == 0
    assert all(" of 24 runs, " in line for line in errors.splitlines())  # on a slow machine
    assert out.splitlines()[-3:] == [str(folder / f"small.{end}") for end in ("journal", "csv", "nc")]
    code, out, errors = ended("show", "study.toml", "--rows", 3)
    assert (code, errors) == (0, "")
    assert "24 of 24 runs, seed 3" in out
    assert out.splitlines()[-5] == "the first 3 of 24 runs:"
    header, row = (re.split(" {2,}", out.splitlines()[k].strip()) for k in (-4, -1))
    shown = dict(zip(header, row, strict=True))
    assert shown["motion_name"] == "ricker"
    first = results_of(folder / "small.journal")
    assert float(shown["largest (mm)"]) == pytest.approx(1e3 * first.largest[2], rel=1e-5)
    assert float(shown["pgv (m/s)"]) == pytest.approx(first["pgv"][2], rel=1e-5)
    code, out, errors = ended("plot", folder / "small.journal")
    assert (code, errors, out.strip()) == (0, "", str(folder / "small.png"))
    code, out, errors = ended("run", "study.toml", "--samples", 13)
    assert code == 2
    assert "holds another study" in errors


@pytest.mark.parametrize(
    "words",
    [["study", "show"], ["study", "plot"], ["risk", "--slope", "2", "--point", "0.2", "475", "--measure", "pga"]],
)
def test_results_of_another_study_are_refused(
    words: list[str],
    folder: Path,
    study: Study,
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(folder)
    run_study(study.with_runs(3), folder)
    assert main([*words, "study.toml"]) in (0, 2)  # of another number of samples
    assert "holds another study" not in capsys.readouterr().err
    block = (folder / "block.toml").read_text(encoding="utf-8")
    (folder / "block.toml").write_text(block.replace("name = ", "g = 9.0\nname = "), encoding="utf-8")
    assert main([*words, "study.toml"]) == 2
    assert "small.journal: holds another study, small (" in capsys.readouterr().err


def test_a_study_none_of_whose_runs_can_be_made_says_why(
    folder: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder)
    text = (folder / "study.toml").read_text(encoding="utf-8")
    text += '[random."joint.friction"]\ndistribution = "uniform"\nlow = 0.8\nhigh = 1.3\nrelative = true\n'
    (folder / "study.toml").write_text(text, encoding="utf-8")
    why = "joint.friction: the file has none that could be multiplied"
    for action in ("run", "show"):
        assert main(["study", action, "study.toml"]) == 0
        out = capsys.readouterr().out
        assert "0 overturned, 0 undecided, 24 that could not be made" in out
        assert f"run 0: {why}" in out
    for words in (["study", "plot"], ["risk", "--slope", "2", "--point", "0.2", "475", "--measure", "pga"]):
        assert main([*words, "study.toml"]) == 2
        assert f"small: none of 24 runs could be made, run 0: {why}" in capsys.readouterr().err
    results = results_of(folder / "small.journal")
    assert influences(results) == []
    with pytest.raises(InputError, match="none of 24 runs could be made"):
        ida_curves(results)


# on a floor

HALL = "[building]\nstoreys = 3\nperiod = 0.4\nalpha = 2.0\n"
ON_FLOOR = 'formula = "ricker"\nbuilding = "hall.toml"\nfloor = 2\n'


def test_motions_of_a_study_on_a_floor(folder: Path, study: Study) -> None:
    (folder / "hall.toml").write_text(HALL, encoding="utf-8")
    text = (folder / "study.toml").read_text(encoding="utf-8")
    (folder / "study.toml").write_text(text.replace('formula = "ricker"\n', ON_FLOOR), encoding="utf-8")
    upstairs = Study.from_toml(folder / "study.toml")
    assert upstairs.fingerprint != study.fingerprint
    hall = Building.from_toml(folder / "hall.toml")
    for number in (0, 13):
        (_, ground, length), _, measures = study.run(number)
        (_, motion, duration), _, same_measures = upstairs.run(number)
        wanted = floor_motion(ground, hall, 2)
        np.testing.assert_allclose(motion.time, wanted.time, rtol=1e-14, atol=0.0)
        np.testing.assert_allclose(motion.ax, wanted.ax, rtol=0.0, atol=1e-12)
        assert measures == same_measures  # of the ground
        assert duration == motion.duration > length


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ('building = "hall.toml"\n', r"motion\[1\]\.floor: missing, building and floor must"),
        ("floor = 2\n", r"motion\[1\]\.building: missing, building and floor must"),
        ('building = "hall.toml"\nfloor = 4\n', r"motion\[1\]\.floor = 4: must be a whole number from 0, the g"),
        ('building = "none.toml"\nfloor = 2\n', r"none\.toml: No such file"),
        ("building = 3\nfloor = 2\n", r"motion\[1\]\.building = 3: must be the path of a file"),
    ],
)
def test_mistakes_about_a_floor(folder: Path, words: str, message: str) -> None:
    (folder / "hall.toml").write_text(HALL, encoding="utf-8")
    text = (folder / "study.toml").read_text(encoding="utf-8")
    (folder / "study.toml").write_text(text.replace('formula = "ricker"\n', f'formula = "ricker"\n{words}'), "utf-8")
    with pytest.raises(InputError, match=message):
        Study.from_toml(folder / "study.toml")


# what a fingerprint, a duration and a failure say


def test_a_fingerprint_is_of_all_that_moves_the_base(study: Study) -> None:
    """Check held samples, harmonics, and that plain records keep the hashes of old journals."""
    column = study.columns[0]
    assert isinstance(column, Column)
    in_space = Structure.stack(column)

    def fingerprint(motion: Motion) -> str:
        shaking = Shaking("motion", record=motion)
        return replace(study, columns=(in_space,), motions=(shaking,), random={}, samples=1, keep=()).fingerprint

    still = np.zeros(2)
    harmonics = [
        Motion.harmonic(1.0, 2.0, 10.0),
        Motion.harmonic(1.0, 3.0, 10.0),
        Motion.harmonic(2.0, 3.0, 10.0),
        Motion.harmonic(1.0, 2.0, 10.0, direction=0.3),
        Motion(np.array([0.0, 10.0]), still, still, 10.0),
        Motion(np.array([0.0, 10.0]), still, still, 11.0, hold=True),
        Motion(np.array([0.0, 10.0]), still, still, 12.0, hold=True),
    ]
    assert len({fingerprint(motion) for motion in harmonics}) == len(harmonics)
    samples = [0.0, 1.0, 0.0, -0.5]
    assert _digest(Motion.from_samples(0.01, samples)) == "ad79c0460889a3d4"
    assert _digest(Motion.from_samples(0.01, samples, ay=[0.0, 1.0, 2.0, 3.0])) == "50fd40807fe8b248"
    # loads were in it before
    load = Load.of([0.0, 1.0], Fx=[1.0, 1.0])
    loaded = Motion.from_samples(0.01, samples).with_loads({"roof": load})
    assert fingerprint(loaded) != fingerprint(Motion.from_samples(0.01, samples))


def test_constant_loads_last_as_long_as_the_run(study: Study) -> None:
    port = {"name": "top", "block": "block1", "at": [0.0, 0.0, 0.0]}
    data = Structure.stack(study.columns[0]).to_dict() | {"port": [port]}  # type: ignore[arg-type]
    record = Motion.from_samples(0.01, [0.0, 1.0, 0.0])
    pushed = Shaking("pushed", record=record, loads={"top": {"Fx": 10.0}})
    given: dict[str, Any] = {"columns": (Structure.from_dict(data),), "motions": (pushed,), "random": {}, "samples": 1}
    made = Study(**{**vars(study), **given, "duration": 3.0, "keep": ()}).run(0).run
    assert made.duration == 3.0
    assert made.motion.loads["top"].time[[0, -1]].tolist() == [0.0, 3.0]  # ended at 0.02 s


def test_a_harmonic_along_y_is_not_tilted() -> None:
    across = Motion.harmonic(1.0, 2.0, 5.0).turned(0.5 * math.pi)
    assert across.amplitude == 0.0
    with pytest.raises(InputError, match=r"motion\.tilt: is for motions of samples, neither held nor harmonic"):
        tilted(across, 0.01)


def test_an_infinite_draw_fails_its_run_and_the_journal_can_be_read(study: Study, tmp_path: Path) -> None:
    wide = Random.from_table("key", {"distribution": "lognormal", "median": 1.0, "deviation": 2000.0, "relative": True})
    odd = replace(study, random={"joint.stiffness": wide}, grid={"intensity": (0.2,)}, samples=4, keep=())
    odd = replace(odd, motions=(Shaking("ricker", "ricker", {"frequency": 1.0}),))
    results = run_study(odd, tmp_path)
    assert np.isinf(results["joint.stiffness"]).any()
    assert set(results["verdict"][np.isinf(results["joint.stiffness"])]) == {"failed"}
    assert same(Results.from_journal(tmp_path / "small.journal"), results)


def test_a_run_that_the_solver_cannot_finish_has_failed(study: Study, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check its verdict, which was undecided, and that it is in no share."""
    monkeypatch.setattr(effort, "MOST", 10.0)
    monkeypatch.setattr(effort, "MOST_FIRST_STEPS", 1.0)
    results = run_study(replace(study, samples=1))
    assert set(results["verdict"]) == {"failed"}
    assert not results.undecided.any()
    assert all("evaluations" in failure for failure in results["failure"])
    assert "0 overturned, 0 undecided, 2 that could not be made" in summary(results)


def test_a_run_that_ends_in_lanes_and_alone_has_failed(study: Study) -> None:
    """Check motions in seconds since 1970, in which no step can be short enough: they counted as overturned."""
    time = 1.7e9 + np.arange(0.0, 2.0, 0.01)
    motion = Motion(time, 6.0 * np.sin(2.0 * math.pi * (time - time[0])), 0.0 * time, float(np.ptp(time)))
    shaking = Shaking("late", record=motion)
    damped, grid = Column.from_toml(DAMPED), {"motion.scale": (1.0, 2.0)}
    late = Study("late", "sweep", (damped,), (shaking,), grid=grid, keep=study.keep, tolerance=1e-6)
    results = run_study(late)
    assert set(results["verdict"]) == {"failed"}
    assert not results.overturned.any()
    assert "0 overturned, 0 undecided, 2 that could not be made" in summary(results)


def test_a_fall_without_a_time_is_summarized(study: Study, tmp_path: Path) -> None:
    run_study(replace(study, samples=1), tmp_path)
    head, lines = read_journal(tmp_path / "small.journal")
    rows = list(lines)
    for row in rows:
        row[3] |= {"verdict": "overturned", "overturn_time": math.nan}
    assert "2 overturned, 0 undecided" in summary(Results(head, rows))


@pytest.mark.parametrize("count", [10.7, 1, True, "3", math.inf])
def test_a_count_is_a_whole_number(count: Any) -> None:
    with pytest.raises(InputError, match=re.escape(f"grid.g.count = {count}".replace("= 3", "= '3'"))):
        axis("grid.g", {"from": 0.0, "to": 1.0, "count": count})
    assert len(axis("grid.g", {"from": 0.0, "to": 1.0, "count": 10.0})) == 10


def test_a_seed_is_a_whole_number(tmp_path: Path) -> None:
    """Check the table, where 3.7 was 3, and a number that a study varies."""
    table = {"formula": "noise", "amplitude": 1.0, "frequency": 2.0, "duration": 4.0}
    with pytest.raises(InputError, match=r"motion\[1\].seed = 3.7: must be a whole number from 0 to 4294967295"):
        Shaking.from_table("motion[1]", {**table, "seed": 3.7}, tmp_path)
    noise = Shaking.from_table("motion[1]", {**table, "seed": 3.0}, tmp_path)
    np.testing.assert_array_equal(noise.base({}, False).ax, noise.base({"seed": 3.0}, False).ax)
    for seed in (3.7, -1, math.inf):
        with pytest.raises(InputError, match=f"motion.seed = {seed}: must be a whole number"):
            noise.base({"seed": seed}, False)
