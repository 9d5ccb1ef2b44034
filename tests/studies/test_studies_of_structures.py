"""Studies of structures in space: any number of their file varies, and the runs are those of `simulate`."""

from __future__ import annotations

import math
import re
import tomllib
from collections.abc import Iterator
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT
from support.record_files import DT, at2, cosmos_v2, plain
from support.study import same

from multiblock import Column, InputError, Motion, Structure, simulate, wavelets
from solver.commands.schema import structure_schema
from solver.commands.study import summary
from solver.models.structure.numbers import structure_with
from solver.studies import Measure, Results, Shaking, Study, fit_fragility, fragility, run_study
from solver.studies.pictures import draw
from solver.studies.statistics import failures_of

EXAMPLES = ROOT / "examples"
COLONNADE = Structure.from_toml(EXAMPLES / "structures" / "colonnade.toml")
STUDY: dict[str, Any] = {
    "name": "pair",
    "kind": "fragility",
    "structure": "trilith.toml",
    "tolerance": 1e-4,
    "samples": 3,
    "keep": ["peak_u", "verdict", "peak_slip", "peak_tie", "peak_base", "overturn_time"],
    "motion": [{"formula": "ricker", "frequency": 1.0, "name": "a pulse"}],
    "intensity": {"measure": "pga"},
    "grid": {"intensity": [0.1, 0.3], "tie[1].yield": [3e3, 5e4]},
    "random": {
        "motion.direction": {"distribution": "uniform", "low": 0.0, "high": math.pi},
        "joint.friction": {"distribution": "uniform", "low": 0.4, "high": 0.8, "each": True},
        "block[beam].density": {"distribution": "lognormal", "median": 1.0, "deviation": 0.1, "relative": True},
    },
}
TIE = """
[[tie]]
between = ["beam", "base"]
from = [0.0, 0.0, 0.0]
to = [1.5, 2.0, 0.0]
stiffness = 1e6
yield = 1e4
"""


@pytest.fixture
def study(tmp_path: Path) -> Study:
    text = (EXAMPLES / "structures" / "trilith.toml").read_text(encoding="utf-8")
    (tmp_path / "trilith.toml").write_text(text + TIE, encoding="utf-8")
    return Study.from_dict(STUDY, tmp_path)


def test_runs_are_those_of_structures_changed_by_hand(study: Study) -> None:
    results = run_study(study)
    assert (len(results), study.shape) == (12, (1, 1, 2, 2, 3))
    for number in (0, 11):
        values = study.values(number)
        beam = values["block[beam].density"]
        given: Any = study.columns[0]
        made = replace_all(given, values)
        assert made.blocks[2].mass == pytest.approx(beam * given.blocks[2].mass, rel=1e-12)
        motion = Shaking("", "ricker", {"frequency": 1.0}).base({}, True).scaled_to(9.80665 * values["intensity"])
        angle = values["motion.direction"]
        turned = replace(motion, ax=math.cos(angle) * motion.ax, ay=math.sin(angle) * motion.ax)
        alone = simulate(made, turned, tolerance=1e-4, output_step=0.005)
        np.testing.assert_allclose(results["peak_u"][number], alone.peaks["u"], rtol=1e-9)  # 1e-13 at most
        np.testing.assert_allclose(results["peak_tie"][number], alone.peaks["tie"], rtol=1e-9)
        assert results["verdict"][number] == alone.verdict
        assert results.largest[number] == np.max(results["peak_u"][number])
    assert results["peak_slip"].shape == (12, 4)
    assert results["peak_base"].shape == (12, 6)
    weak, strong = (results["peak_tie"][results["tie[1].yield"] == value].max() for value in (3e3, 5e4))
    assert weak <= 3e3 < strong


def replace_all(structure: Any, values: dict[str, float]) -> Structure:
    """Return the numbers of the study, set in the dict and in the joints themselves."""
    data = structure.to_dict()
    data["tie"][0]["yield"] = values["tie[1].yield"]
    data["block"][2]["density"] *= values["block[beam].density"]
    made = Structure.from_dict(data)
    frictions = [values[f"joint[{j}].friction"] for j in range(1, 5)]
    beds = [replace(joint.bed, friction=friction) for joint, friction in zip(made.joints, frictions, strict=True)]
    joints = tuple(replace(joint, bed=bed) for joint, bed in zip(made.joints, beds, strict=True))
    return replace(made, joints=joints)


@pytest.mark.long  # takes seconds
def test_a_journal_goes_on_and_processes_make_the_same_bits(study: Study, tmp_path: Path) -> None:
    whole = run_study(study)
    run_study(study, tmp_path, threads=1)
    lines = (tmp_path / "pair.journal").read_text(encoding="utf-8").splitlines(keepends=True)
    (tmp_path / "pair.journal").write_text("".join(lines[:6]), encoding="utf-8")
    assert len(Results.from_journal(tmp_path / "pair.journal")) == 5
    with ProcessPoolExecutor(1, get_context("spawn")) as pool:
        assert same(run_study(study, tmp_path, executor=pool), whole)
    assert same(Results.from_journal(tmp_path / "pair.journal"), whole)


def test_any_number_of_the_file() -> None:
    values = {
        "block[architrave2].height": (1.2, False),
        "block[1].at[1]": (0.01, False),
        "tie.yield": (0.5, True),
        "joint[column1.1-base].stiffness": (2e9, False),
        "g": (1.6, False),
        "solver.tolerance": (1e-4, False),
    }
    found = structure_with(COLONNADE, values)
    second = COLONNADE.number("architrave2")
    beam, was = found.blocks[second], COLONNADE.blocks[second]
    assert np.ptp(beam.corners[:, 2]) == pytest.approx(1.2, rel=1e-12)
    assert beam.mass == pytest.approx(1.2 / np.ptp(was.corners[:, 2]) * was.mass, rel=1e-12)
    assert found.blocks[0].centroid[0] == 0.01
    assert [tie.yield_ for tie in found.ties] == [0.5 * (tie.yield_ or 0.0) for tie in COLONNADE.ties]
    assert found.joints[0].bed.stiffness == 2e9
    assert found.joints[1].bed == COLONNADE.joints[1].bed
    assert (found.g, found.tolerance) == (1.6, 1e-4)


def test_a_structure_twice_the_size_has_eight_times_the_mass() -> None:
    found = structure_with(COLONNADE, {"structure.size": (2.0, False)})
    for large, small in zip(found.blocks, COLONNADE.blocks, strict=True):
        np.testing.assert_allclose(large.centroid, 2.0 * small.centroid, rtol=1e-12, atol=1e-12)
        np.testing.assert_allclose(large.inertia, 32.0 * small.inertia, rtol=1e-11, atol=1e-9)
        assert large.mass == pytest.approx(8.0 * small.mass, rel=1e-12)
    areas = [joint.face.moments[0] for structure in (found, COLONNADE) for joint in structure.joints]
    np.testing.assert_allclose(areas[: len(areas) // 2], 4.0 * np.array(areas[len(areas) // 2 :]), rtol=1e-9)


# every key of a structure file that is a length; m marks lengths, kg masses
SIZED = """
name = "sized"
joints = { stiffness = 1e9, damping = 2e-3, rim = 0.05m }
tie = [{ between = ["a", "c"], from = [0.2m, 0.0m, 0.3m], to = [-0.2m, 0.0m, 0.1m], slack = 0.005m, stiffness = 1e5 }]
port = [{ name = "p", block = "a", at = [0.1m, 0.05m, 0.3m] }, { name = "q", block = "b" }]
neighbours.reach = 2.0m
neighbours.stiffness = 1e8
neighbours.damping = 1e-3
neighbours.friction = 0.4
neighbours.pair = [{ between = ["a", "b"], gap = 0.3m }]
neighbours.wall = [{ at = [-0.4m, 0.0m, 0.0m], normal = [1.0, 0.0], width = 2.0m, height = 3.0m }]
[[block]]
name = "a"
on = "base"
at = [0.0m, 0.1m]
width = 0.5m
depth = 0.6m
height = 1.6m
top_width = 0.4m
top_depth = 0.5m
mass = 900.0kg
joint = { rim = 0.04m }
[[block]]
name = "b"
on = "base"
at = [1.0m, 0.1m]
shape = "drum"
diameter = 0.6m
top_diameter = 0.5m
bore = 0.1m
height = 1.0m
density = 2500.0
[[block]]
name = "c"
on = "base"
position = [2.0m, 0.0m, 0.0m]
shape = "prism"
outline = [[0.0m, 0.0m], [0.5m, 0.0m], [0.4m, 0.8m], [0.1m, 0.8m]]
depth = 0.5m
density = 2500.0
[[block]]
name = "slab"
position = [9.0m, 0.0m, 0.5m]
width = 2.0m
depth = 2.0m
height = 0.3m
density = 2500.0
[[block]]
name = "stone"
shape = "hull"
position = [9.0m, 0.0m, 0.8m]
points = [[0.0, 0.0, 0.0], [0.6, 0.0, 0.0], [0.0, 0.5, 0.0], [0.1, 0.1, 0.9]]
scale = 1.0m
density = 2500.0
[[joint]]
between = ["stone", "slab"]
at = [9.1m, 0.1m, 0.8m]
section = "ring"
diameter = 0.15m
bore = 0.05m
[[joint]]
between = ["stone", "slab"]
at = [9.3m, 0.1m, 0.8m]
width = 0.1m
depth = 0.15m
rim = 0.02m
[[joint]]
between = ["stone", "slab"]
at = [9.05m, 0.25m, 0.8m]
section = "polygon"
outline = [[0.0m, 0.0m], [0.15m, 0.0m], [0.0m, 0.15m]]
[[bearing]]
kind = "pendulum"
between = ["slab", "base"]
at = [[8.5m, -0.5m, 0.5m], [9.5m, 0.5m, 0.5m]]
diameter = 0.4m
capacity = 0.3m
radius = 2.0m
friction = 0.05
initial_stiffness = 1e7
vertical_stiffness = 1e9
vertical_damping = 1e-3
rim = 0.2m
rim_stiffness = 1e6
rim_damping = 1e-3
[[bearing]]
kind = "double_concave"
between = ["slab", "base"]
at = [9.5m, -0.5m, 0.5m]
diameter = 0.4m
capacity = 0.3m
radius = [1.0m, 1.2m]
height = 0.1m
friction = 0.05
initial_stiffness = 1e7
vertical_stiffness = 1e9
vertical_damping = 1e-3
"""
# vectors of the schema that are no lengths, or follow the scale of a hull
NO_LENGTHS = ("rotation", "normal", "points", "foot", "faces", "centroid", "inertia")


def sized(size: float) -> Structure:
    """Return the structure of the file above with all lengths multiplied by `size`, and masses by its cube."""
    text = re.sub(r"(-?[0-9.]+)m\b", lambda found: repr(size * float(found[1])), SIZED)
    text = re.sub(r"([0-9.]+)kg", lambda found: repr(size**3 * float(found[1])), text)
    return Structure.from_dict(tomllib.loads(text))


def leaves(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the values of nested tables and lists with their keys, such as block.joint.rim."""
    if isinstance(value, dict):
        for key, part in value.items():
            yield from leaves(part, f"{place}.{key}".lstrip("."))
    elif isinstance(value, list):
        for part in value:
            yield from leaves(part, place)
    else:
        yield place, value


def lengths_of(schema: dict[str, Any], place: str = "") -> Iterator[str]:
    """Yield the keys of a schema that are lengths."""
    for key, part in schema.get("properties", {}).items():
        at, items = f"{place}.{key}".lstrip("."), part.get("items", {})
        yield from lengths_of(part, at)
        yield from lengths_of(items, at)
        numbers = part.get("type") == "array" and items.get("type", "array") in ("number", "array")
        if key not in NO_LENGTHS and (numbers or re.search(r" in m\b(?!/)", part.get("description", ""))):
            yield at


def test_the_size_scales_every_length_of_a_file() -> None:
    """Compare with the file whose lengths are scaled by hand; it has all those of the schema."""
    found, expected = structure_with(sized(1.0), {"structure.size": (1.5, False)}), sized(1.5)
    assert dict(leaves(found.to_dict())).keys() >= {*lengths_of(structure_schema())}
    for (place, value), (other, wanted) in zip(leaves(found.to_dict()), leaves(expected.to_dict()), strict=True):
        assert place == other
        assert value == (pytest.approx(wanted, rel=1e-12) if isinstance(wanted, float) else wanted), place
    pulse = wavelets.ricker(3.0, 1.2)
    peaks, wanted_peaks = (
        simulate(made, pulse, duration=0.5, loads={"p": {"Fx": 200.0}}).peaks["ux"] for made in (found, expected)
    )
    np.testing.assert_allclose(peaks, wanted_peaks, rtol=1e-6)


def test_ports_of_a_stack_follow_its_size_and_slenderness() -> None:
    blocks = [{"height": 1.5, "width": 0.6, "depth": 0.6, "mass": 1500.0}] * 2
    column = {"name": "shaft", "joint": {"stiffness": 1e9, "damping": 1e-3}, "block": blocks}
    stack = Structure.from_dict({"column": column, "port": [{"name": "p", "block": "block1", "at": [0.3, 0.75]}]})
    larger = stack.kind.with_numbers(stack, {"column.size": (2.0, False)})
    assert larger.ports[0].at == pytest.approx((0.6, 0.0, 1.5))
    slender = stack.kind.with_numbers(stack, {"column.slenderness": (10.0, False)})
    assert slender.ports[0].at == pytest.approx((0.15, 0.0, 0.75))


@pytest.mark.parametrize(
    ("name", "relative", "message"),
    [
        ("block[nowhere].height", False, "no such block, must be one of column1.1"),
        ("joint[99].friction", False, "no such joint"),
        ("joint.hardness", False, "must be of the law of a joint"),
        ("block[1].at[3]", False, "must be a coordinate that the file has"),
        ("block[1].mass", True, "none that could be multiplied"),
        ("block[1].hight", False, "unknown key"),
        ("joint.stiffness", False, "joint.stiffness = -1.0"),
    ],
)
def test_wrong_names(name: str, relative: bool, message: str) -> None:
    with pytest.raises(InputError, match=r".*") as error:
        structure_with(COLONNADE, {name: (-1.0, relative)})
    assert message in str(error.value)


def single(name: str, each: bool, relative: bool = False, **changes: Any) -> Study:
    """Return a study of one run that varies one number, lognormal with median 2."""
    random = {"distribution": "lognormal", "median": 2.0, "deviation": 1e-12, "relative": relative, "each": each}
    path = str(EXAMPLES / "structures" / changes.pop("of", "trilith.toml"))
    without = {"samples": 1, "keep": ["peak_u", "verdict"], "grid": {}, "structure": path}
    without["motion"] = [{"formula": "ricker", "frequency": 1.0, "amplitude": 1.0}]
    return Study.from_dict({**STUDY, **without, "random": {name: random}, **changes})


@pytest.mark.parametrize("each", [False, True])
def test_a_factor_on_the_gaps_of_pairs(each: bool) -> None:
    found: Any = single("neighbours.pair.gap", each, True, of="cask-row.toml").run(0).run.model
    pairs = found.to_dict()["neighbours"]["pair"]
    assert [pair["gap"] for pair in pairs] == pytest.approx([0.4, 0.4, 0.4], rel=1e-10)  # the file has 0.2 m
    with pytest.raises(InputError, match="friction: the file has none that could be multiplied"):
        single("neighbours.pair.friction", each, True, of="cask-row.toml").run(0)


@pytest.mark.parametrize(
    ("name", "message"),
    [
        ("neighbours.pair.gop", r"neighbours.pair.gop: neighbours.pair\[1\].gop: unknown key"),
        ("neighbours.pair[4].gap", r"neighbours.pair\[4\].gap: no such table"),
        ("neighbours.frction", "neighbours.frction: unknown key"),
        ("block[none].height", r"block\[none\].height: no such block, must be one of"),
        ("block.heigt", r"block.heigt: block\[.*\].heigt: unknown key"),
    ],
)
def test_names_of_no_number_are_refused_before_any_run(name: str, message: str) -> None:
    with pytest.raises(InputError, match=message):
        single(name, False, of="cask-row.toml")


def test_each_coordinate_and_none_of_no_ties() -> None:
    found: Any = single("block.at[2]", True).run(0).run.model
    assert [block["at"] for block in found.to_dict()["block"]] == [[x, pytest.approx(2.0)] for x in (0.0, 3.0, 1.5)]
    for name in ("tie.yield", "bearing.friction", "neighbours.pair.gap"):
        for each in (False, True):
            with pytest.raises(InputError, match=f"{name}: must be left out, a model has none"):
                single(name, each)


@pytest.mark.parametrize(
    ("one", "other", "place"),
    [
        ("joint[beam-left].friction", "joint[3].friction", "joint[3].friction"),
        ("block[left].mass", "block.density", "block[1].density"),
        ("block[left].at[1]", "block[1].at[1]", "block[1].at[1]"),
        ("neighbours.pair.restitution", "neighbours.pair[2].damping", "neighbours.pair[2].damping"),
    ],
)
def test_two_names_of_one_number_in_space(one: str, other: str, place: str) -> None:
    of = "cask-row.toml" if one.startswith("neighbours") else "trilith.toml"
    with pytest.raises(InputError, match=re.escape(f"random.{other}: sets {place} as grid.{one} does")):
        single(other, False, of=of, grid={one: [0.5]})
    single(other, False, True, of=of, grid={one: [0.5]})


def test_what_goes_together(study: Study, tmp_path: Path) -> None:
    column = Column.from_toml(EXAMPLES / "columns" / "doric.toml")
    with pytest.raises(InputError, match="must all be columns, or all structures"):
        replace(study, columns=(study.columns[0], column))
    with pytest.raises(InputError, match="must be from a structure file"):
        replace(study, columns=(replace(column.in_space(), described=None),), random={}, grid={}, samples=1).to_dict()
    with pytest.raises(InputError, match=r"motion\[1\].direction: must be left out"):
        Study("plane", "sweep", (column,), (Shaking("", "ricker", {"frequency": 1.0, "direction": 0.1}),))
    across = Motion.from_samples(0.01, np.ones(5), ay=np.ones(5))
    with pytest.raises(InputError, match=r"motion\[1\]: ay: a column moves in its plane"):
        Study("plane", "sweep", (column,), (Shaking("record", record=across),))
    with pytest.raises(InputError, match="keep: must have peak_u"):
        replace(study, keep=("verdict",))
    short = tuple(column.with_settings(without=("peaks",)) for column in study.columns)
    with pytest.raises(InputError, match=r'solver.without has "peaks", must not where peak_\w+ is kept'):
        replace(study, columns=short, keep=(*study.keep, "peak_N"))
    with pytest.raises(InputError, match="must be the path of a column file"):
        Study.from_dict({**STUDY, "column": "trilith.toml"}, tmp_path)


@pytest.mark.long  # takes seconds
def test_casks_hit_where_casks_far_apart_come_nearer_than_their_distance(tmp_path: Path) -> None:
    """Check that until a pair meets, no motion depends on the distance: casks that never meet tell who hits at any
    distance.
    """
    study = replace(
        Study.from_toml(EXAMPLES / "studies" / "casks.toml"),
        grid={"intensity": (0.4, 0.7), "neighbours.pair.gap": (0.1, 0.3, 50.0)},
        samples=4,
    )
    results = run_study(study)
    gap, hit = results["neighbours.pair.gap"], np.any(results["least_gap"] < 0.0, axis=1)
    far = gap == 50.0
    assert not np.any(hit[far])
    closing = 50.0 - np.min(results["least_gap"][far], axis=1)
    for distance in (0.1, 0.3):
        np.testing.assert_array_equal(hit[gap == distance], closing > distance)
    assert 0 < np.sum(hit) < 16
    names = {failure.name: failure for failure in failures_of(results)}
    assert list(names) == ["overturned", "hit, gap 0.1 m", "hit, gap 0.3 m", "hit, gap 50 m"]
    near = names["hit, gap 0.1 m"]
    found = fit_fragility(results, limit=near.limit, chosen=near.chosen, resampled=5)
    assert (found.runs, found.failed, found.how) == (8, np.sum(hit[gap == 0.1]), "neighbours that hit")
    shares: Any = draw(results, tmp_path / "casks.png").axes[1]
    assert shares.get_xlabel() == "neighbours.pair.gap (m)"
    for line, level in zip(shares.containers, (0.4, 0.7), strict=True):
        wanted = [np.mean(hit[(gap == value) & (results["intensity"] == level)]) for value in (0.1, 0.3, 50.0)]
        np.testing.assert_allclose(line.lines[0].get_ydata(), wanted, atol=1e-15)


def test_a_component_of_a_record_is_another_channel(tmp_path: Path) -> None:
    (tmp_path / "station.v2").write_text(cosmos_v2(3))
    table = {"record": "station.v2", "across": "station.v2", "channel": 1}
    with pytest.raises(InputError, match=r"across: is channel 1 of .*, as motion\[1\].record, .*\[1\].across_channel"):
        Shaking.from_table("motion[1]", table, tmp_path)
    motion = Shaking.from_table("motion[1]", {**table, "across_channel": 2}, tmp_path).record
    assert motion is not None
    np.testing.assert_array_equal(motion.ay, -motion.ax)


def test_units_and_channels_are_those_of_the_files_that_need_them(tmp_path: Path) -> None:
    """Check the rule of the command line: dt and units went to an AT2 file, a channel to one without channels."""
    (tmp_path / "station.v2").write_text(cosmos_v2(3))
    (tmp_path / "record.AT2").write_text(at2(), encoding="utf-8")
    (tmp_path / "plain.txt").write_text(plain())
    plain_one = {"dt": DT, "units": "g"}
    files = {"record": "station.v2", "across": "plain.txt", "vertical": "record.AT2"}
    motion = Shaking.from_table("motion[1]", {**files, **plain_one, "channel": 2}, tmp_path).record
    assert motion is not None
    np.testing.assert_array_equal(motion.ax, Motion.from_file(tmp_path / "station.v2", channel=2).ax)
    np.testing.assert_array_equal(motion.ay, Motion.from_file(tmp_path / "plain.txt", **plain_one).ax)  # type: ignore[arg-type]
    np.testing.assert_array_equal(motion.az, Motion.from_file(tmp_path / "record.AT2").ax)
    with pytest.raises(InputError, match=r"dt = .*: must be left out, the file is PEER AT2 and says all itself"):
        Shaking.from_table("motion[1]", {"record": "record.AT2", "dt": DT}, tmp_path)
    with pytest.raises(InputError, match=r"motion\[1\].across = 3: must be the path of a file"):
        Shaking.from_table("motion[1]", {**files, "across": 3}, tmp_path)


def test_noise_of_two_components(study: Study) -> None:
    """Check that the second one is another noise of the size that is asked for; columns have no use for it."""
    numbers = {"frequency": 2.0, "duration": 4.0, "seed": 7.0, "amplitude": 3.0}
    motion = Shaking("noise", "noise", {**numbers, "across": 0.5}).base({}, False)
    alone = Shaking("noise", "noise", numbers).base({}, False)
    np.testing.assert_array_equal(motion.ax, alone.ax)
    assert np.max(np.abs(motion.ay)) == pytest.approx(1.5, rel=1e-12)
    assert abs(np.corrcoef(motion.ax, motion.ay)[0, 1]) < 0.2
    with pytest.raises(InputError, match=r"motion.across = -1.0: must be a part of the first component"):
        Shaking("noise", "noise", {**numbers, "across": -1.0}).base({}, False)
    column = Column.from_toml(EXAMPLES / "columns" / "doric.toml")
    with pytest.raises(InputError, match=r"motion\[1\].across: must be left out"):
        Study("plane", "sweep", (column,), (Shaking("noise", "noise", {**numbers, "across": 0.5}),))


def test_a_motion_turned_in_plan() -> None:
    motion = Motion.from_samples(0.01, [0.0, 1.0, -2.0], ay=[0.5, 0.0, 1.0])
    once = motion.turned(0.3).turned(-0.3)
    np.testing.assert_allclose(once.ax, motion.ax, atol=1e-15)
    np.testing.assert_allclose(once.ay, motion.ay, atol=1e-15)
    quarter = motion.turned(math.pi / 2)
    np.testing.assert_allclose(quarter.ay, motion.ax, atol=1e-15)
    wave = Motion.harmonic(1.0, 2.0, 3.0).turned(0.4)
    other = Motion.harmonic(1.0, 2.0, 3.0, direction=0.4)
    assert (wave.amplitude, wave.amplitude_y) == (other.amplitude, other.amplitude_y)


def test_a_motion_along_y_alone_is_scaled_by_the_measures_of_both_components() -> None:
    samples = 0.01 * np.arange(300)
    across = Motion.from_samples(0.01, np.zeros(300), ay=np.sin(7.0 * samples) * np.exp(-samples))
    one: dict[str, Any] = {
        "name": "across",
        "kind": "ida",
        "columns": (COLONNADE,),
        "motions": (Shaking("across", record=across),),
    }
    scaled = Study(**one, grid={"intensity": (0.2,)}, measure=Measure("rotd100", 0.5))
    assert Measure("sa", 0.5).of(scaled.run(0).run.motion, "ay") == pytest.approx(0.2)
    with pytest.raises(InputError, match=r"motion\[1\]: across has a PGA of zero, it cannot be scaled"):
        replace(scaled, measure=Measure("pga")).run(0)


def test_a_structure_without_a_rest_has_overturned() -> None:
    """Check that it counts in the fragility: half of the blocks fall under their weight, at any intensity."""
    tall = {"name": "tall", "on": "base", "width": 0.2, "depth": 0.2, "height": 4.0, "density": 2000.0}
    least = 2000.0 * 0.04 * 9.80665 * 4.0 * 2.0 * 12.0 / 0.2**4  # N/m3 at which it stands
    law = {"stiffness": least, "damping": 2e-3}
    structure = Structure.from_dict({"name": "tall", "joints": law, "block": [tall]})
    weak = {"distribution": "choice", "values": [0.9, 2.0], "relative": True}
    pulse = Shaking("ricker", "ricker", {"frequency": 1.0})
    results = fragility(structure, pulse, {"joint.stiffness": weak}, 4, levels=[1e-4, 0.3], duration=0.1)
    soft = results["joint.stiffness"] == 0.9
    assert 0 < np.sum(soft) < len(soft)
    assert set(results["verdict"][soft]) == {"overturned"}  # was failed, and left out
    assert all("tall: " in failure for failure in results["failure"][soft])
    assert np.all(np.isinf(results.largest[soft]))
    assert f"{int(np.sum(results.overturned))} overturned" in summary(results)
    assert "0 that could not be made" in summary(results)
