"""Eight structures at once: runs in lanes against runs alone, and what lanes hold on their own."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support.fmus import ROOT
from support.probe import G
from support.structures import stack, with_law

from solver import simulate
from solver.common.errors import InputError
from solver.ground.motion import Motion
from solver.models.protocol import NoRestError, Run
from solver.models.structure import kind, run
from solver.models.structure.builders import arch, colonnade
from solver.models.structure.lanes import follow_in_lanes, share_of
from solver.models.structure.model import Structure
from solver.models.structure.outputs import FROM_LANES
from solver.models.structure.rest import fastest_decay, rest_of
from solver.models.uncertainty import Spread
from solver.runs.many import simulate_many

TRILITH = ROOT / "examples" / "structures" / "trilith.toml"
LAW: dict[str, Any] = {"stiffness": 2e9, "damping": 1e-3}
KEEP = ("peak_u", "peak_centroid_ux", "peak_uy", "peak_uz", "verdict", "overturn_time", "steps", "evaluations")


def trilith(friction: float | None = None) -> Structure:
    """Return two columns of two boxes under an architrave."""
    law = LAW if friction is None else {**LAW, "friction": friction}
    return colonnade(2, 2, 3.0, 0.9, 4.0, law, architrave=(0.7, 0.9))


def held() -> Structure:
    """Return a slab that slides, held by a rod that yields, and by a rope that is slack."""
    block = {"name": "b", "width": 4.0, "depth": 4.0, "height": 0.2, "mass": 1000.0, "on": "base"}
    rod = {"between": ["b", "base"], "from": [0.0, 0.0, 0.0], "to": [6.0, 0.0, 0.1], "stiffness": 1e5, "yield": 2e3}
    rope = {"between": ["b", "base"], "from": [0.0, 0.0, 0.0], "to": [0.0, 6.0, 0.1], "stiffness": 1e5, "slack": 0.05}
    law = {"stiffness": 1e8, "damping": 1e-3, "friction": 0.1}
    return Structure.from_dict({"name": "held", "joints": law, "block": [block], "tie": [rod, rope]})


def recorded(seed: int, hold: bool = False) -> Motion:
    """Return a motion of three components, sampled at 50 Hz for 2 s."""
    rng = np.random.default_rng(seed)
    ax, ay, az = (np.convolve(rng.normal(size=101), np.ones(10), "same") for _ in range(3))
    return Motion.from_samples(0.02, 0.8 * ax, ay=0.6 * ay, az=0.3 * az, hold=hold)


def waves(count: int = 11, size: float = 0.12, direction: float = 0.4) -> list[Motion]:
    """Return harmonic motions of 2 s."""
    return [
        Motion.harmonic(size * (1.0 + 0.05 * k) * G, 1.0 + 0.05 * k, 2.0, direction=direction) for k in range(count)
    ]


def in_lanes(structure: Structure, motions: list[Motion], settle: float = 0.0, **more: Any) -> list[dict[str, Any]]:
    runs = [Run(structure, motion, more.get("duration", motion.duration)) for motion in motions]
    assert not structure.kind.lanes(structure, FROM_LANES).why_not
    return follow_in_lanes(runs, [rest_of(run.model) for run in runs], settle)


def beside(restitution: float = 0.5) -> Structure:
    """Return a slender drum between a stouter one and a box, and a wall behind the box: all kinds of contact."""
    drum, box = {"shape": "drum", "diameter": 0.8, "density": 2500.0}, {"width": 0.6, "depth": 1.2, "density": 2500.0}
    blocks = [
        {"name": "stout", "on": "base", "at": [0.0, 0.0], **drum, "diameter": 1.2, "height": 2.4},
        {"name": "slender", "on": "base", "at": [1.02, 0.05], **drum, "height": 3.2},
        {"name": "box", "on": "base", "at": [1.74, 0.0], **box, "height": 2.0},
        {"name": "panel", "on": "base", "at": [2.37, 0.1], **box, "height": 2.6},
    ]
    wall = {"at": [2.7, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 3.0}
    law = {"reach": 0.1, "line_stiffness": 1e8, "stiffness": 1e9, "restitution": restitution, "friction": 0.4}
    joints = {"stiffness": 1e9, "damping": 2e-3, "friction": 0.5}
    return Structure.from_dict(
        {"name": "row", "joints": joints, "block": blocks, "neighbours": {**law, "wall": [wall]}}
    )


RING = {"name": "r", "shape": "drum", "diameter": 1.0, "bore": 0.6, "height": 4.0, "mass": 5e3, "on": "base"}
SCENES = {
    "boxes": (stack(3, damping=3e-3), waves()),
    "drums": (stack(3, "circle", damping=3e-3), waves(size=0.08)),
    "a ring": (Structure.from_dict({"name": "ring", "joints": LAW, "block": [RING]}), waves()),
    "trilith": (trilith(), waves()),
    "trilith that slides": (trilith(0.2), waves(size=0.25)),
    "drums that slide": (with_law(stack(3, "circle", damping=3e-3), friction=0.1), waves(size=0.25)),
    "arch": (arch(7, 5.0, 1.0, 1.0, LAW, angle=2.5), waves(size=0.25)),
    "ties": (held(), waves(size=0.4, direction=0.7)),
    "three components": (trilith(0.5), [recorded(seed) for seed in range(9)]),
    "held samples": (trilith(0.5), [recorded(seed, hold=True) for seed in range(9)]),
    "in a plane": (stack(2, damping=3e-3), waves(direction=0.0)),
}


TAKE_SECONDS = ("trilith that slides", "held samples")  # others slide, and follow samples


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=pytest.mark.long if name in TAKE_SECONDS else ()) for name in SCENES]
)
def test_peaks_are_those_of_close_runs(name: str) -> None:
    structure, motions = SCENES[name]
    tolerance = 1e-4
    found = in_lanes(structure.with_settings(tolerance=tolerance), motions)
    for motion, one in list(zip(motions, found, strict=True))[::4]:
        closest = simulate(structure, motion, settle=0.0, tolerance=1e-8)
        size = float(np.max(closest.peaks["u"]))
        for axis in ("ux", "uy", "uz"):
            # measured 2e-6 to 0.6 tolerances of the largest displacement; 3 with ties
            assert one[f"peak_{axis}"] == pytest.approx(closest.peaks[axis], abs=10.0 * tolerance * size)
        # rows are 1 / 200 of the shortest period apart: the peak lies up to 1e-4 above them
        assert one["peak_u"] == pytest.approx(closest.peaks["u"], rel=3e-4, abs=10.0 * tolerance * size)
        assert one["verdict"] == closest.verdict
    if name == "in a plane":
        assert not any(np.any(one["peak_uy"]) for one in found)


def test_runs_do_not_depend_on_their_neighbours() -> None:
    """Compare runs one by one, in other lanes, after others: equal bits."""
    structure, motions = trilith(0.3).with_settings(tolerance=1e-3), waves(size=0.2)
    together = in_lanes(structure, motions, settle=0.5)
    alone = [in_lanes(structure, [motion], settle=0.5)[0] for motion in motions[:3]]
    turned = in_lanes(structure, motions[::-1], settle=0.5)[::-1]
    for one, other in [*zip(together[:3], alone, strict=True), *zip(together, turned, strict=True)]:
        assert {name: np.asarray(value).tobytes() for name, value in one.items()} == {
            name: np.asarray(value).tobytes() for name, value in other.items()
        }


def hits(count: int = 11) -> list[Motion]:
    """Return motions under which all pairs of `beside` meet."""
    return [Motion.harmonic((0.35 + 0.03 * k) * G, 1.5 + 0.05 * k, 0.8, direction=0.1 * k) for k in range(count)]


def test_neighbours_meet_in_lanes_as_alone() -> None:
    structure, motions, tolerance = beside(), hits(), 1e-4
    found = in_lanes(structure.with_settings(tolerance=tolerance), motions)
    for motion, one in list(zip(motions, found, strict=True))[::4]:
        closest = simulate(structure, motion, settle=0.0, tolerance=1e-9)
        assert np.all(closest.peaks["gap"] < -2e-3)  # m
        for axis in ("ux", "uy", "uz"):  # of all eleven: measured 59 tolerances at most, alone 24; most below 5
            size = float(np.max(closest.peaks["u"]))
            assert one[f"peak_{axis}"] == pytest.approx(closest.peaks[axis], abs=100.0 * tolerance * size)
        assert one["least_gap"] == pytest.approx(closest.peaks["gap"], abs=1e-5)  # measured 1.6e-6 m, alone 6e-6


def test_a_hit_in_one_lane_changes_no_bit_of_the_others() -> None:
    """Compare runs that hit at other times, and one that does not, one by one and in other lanes."""
    motions = [Motion.harmonic(0.02 * G, 1.0, 0.8), *hits(10)]
    structure = beside().with_settings(tolerance=1e-3)
    together = in_lanes(structure, motions)
    turned = in_lanes(structure, motions[::-1])[::-1]
    alone = [in_lanes(structure, [motion])[0] for motion in motions[:3]]
    assert np.all(together[0]["least_gap"] > 0.0)
    for one, other in [*zip(together[:3], alone, strict=True), *zip(together, turned, strict=True)]:
        for name in ("peak_u", "least_gap", "steps", "verdict"):
            assert np.asarray(one[name]).tobytes() == np.asarray(other[name]).tobytes()


def test_a_fall_in_one_lane_changes_no_bit_of_the_others() -> None:
    """Compare runs that hit the wall while others fall with the same runs one by one."""
    structure = beside().with_settings(tolerance=1e-3)
    sizes = np.linspace(0.4, 1.5, 16)  # g; the run at 1.353 differed
    motions = [Motion.harmonic(size * G, 0.9, 1.6, direction=0.1 * k) for k, size in enumerate(sizes)]
    together = in_lanes(structure, motions)
    alone = [in_lanes(structure, [motion])[0] for motion in motions]
    assert {one["verdict"] for one in together} >= {"overturned"}
    for one, other in zip(together, alone, strict=True):
        for name in ("peak_u", "least_gap", "steps", "verdict", "overturn_time"):
            assert np.asarray(one[name]).tobytes() == np.asarray(other[name]).tobytes(), name


def test_rims_on_other_joints_are_in_other_lanes() -> None:
    """Follow drums with a rim under the lower or the upper one alone, together and one by one: it was up to 8 % off."""
    runs = []
    for k in (0, 1):
        data = stack(2, "circle", damping=3e-3).to_dict()
        for i, block in enumerate(data["block"]):
            block["position"] = [0.0, 0.0, 4.69 * i]
        data["joint"] = [{"between": [block["name"], block.pop("on")]} for block in data["block"]]
        data["joint"][k]["rim"] = 0.1
        runs.append(Structure.from_dict(data).with_settings(tolerance=1e-4))
    motion = Motion.harmonic(0.1 * G, 1.0, 1.0)
    table = simulate_many(runs * 4, motion, keep=("peak_u", "path"))
    for k, structure in enumerate(runs):
        one = simulate_many(structure, motion, keep=("peak_u", "path"))
        assert table["peak_u"][k].tobytes() == one["peak_u"][0].tobytes()
        assert table["path"][k] == one["path"][0] == "lanes"


def test_what_a_structure_leaves_out_stays_left_out_where_peaks_are_not_kept() -> None:
    structure = with_law(trilith(0.5), stiffness=1e11, damping=0.02).with_settings(tolerance=1e-3)
    motion, keep, evaluations = Motion.harmonic(0.2 * G, 2.0, 0.5), ("peak_u", "evaluations"), []
    for without in ((), ("stabilized",)):
        run = Run(structure.with_settings(without=without), motion, 0.5)
        evaluations.append(structure.kind.alone(run, keep, 0.0, lambda *_: None)["evaluations"])
    alone = simulate(structure, motion, without=["stabilized", "peaks"], settle=0.0)
    assert evaluations[1] == alone.stats["evaluations"] > evaluations[0]


def test_peaks_that_are_not_computed_are_not_given() -> None:
    """Leave out peaks: those of displacements remain, between the ends of the steps, and no others."""
    structure, motion = trilith(0.3).with_settings(tolerance=1e-5), waves(1, 0.25)[0]
    whole = simulate(structure, motion, settle=0.0, tolerance=1e-7)
    short = simulate(structure, motion, settle=0.0, without=["peaks"])
    assert sorted(short.peaks) == ["u", "ux", "uy", "uz"]
    for name in short.peaks:  # measured 1e-5; at ends of steps alone 2e-3
        assert short.peaks[name] == pytest.approx(whole.peaks[name], rel=1e-4), name
    refused = r'solver.without has "peaks", must not where peak_N is kept'
    assert simulate_many(structure.with_settings(without=("peaks",)), motion)["peak_centroid_ux"].shape == (1, 5)
    with pytest.raises(InputError, match=refused):
        simulate_many(structure.with_settings(without=("peaks",)), motion, keep=("peak_N", "verdict"))


def test_a_post_that_leans_stands_in_lanes_too() -> None:
    post = {"name": "post", "on": "base", "width": 0.4, "depth": 0.4, "height": 2.4, "density": 2500.0}
    wall = {"at": [0.8, 0.0, 0.0], "normal": [-1.0, 0.0], "width": 4.0, "height": 3.0}
    law = {"reach": 1.0, "stiffness": 1e8, "restitution": 0.05, "friction": 0.5, "wall": [wall]}
    joints = {"stiffness": 1e8, "damping": 5e-3, "friction": 0.8}
    data = {"name": "post", "joints": joints, "block": [post], "neighbours": law}
    structure = Structure.from_dict(data).with_settings(tolerance=1e-4)
    motions = [Motion.harmonic(size * G, 0.5, 0.8) for size in (-0.8, -1.0, 0.5)]
    found, reasons = in_lanes(structure, motions, settle=20.0), []
    for motion, one in zip(motions, found, strict=True):
        alone = simulate(structure, motion, settle=20.0)
        reasons.append(alone.reason)
        assert one["verdict"] == alone.verdict
    assert reasons[1] == "it has come to rest: post rests against wall 1"
    assert [one["verdict"] for one in found] == ["standing", "standing", "overturned"]


def test_runs_are_followed_to_their_verdict() -> None:
    """Check that columns that fall, fall later, rock on or come to rest, as alone; the fall is at the same time."""
    structure = stack(2, damping=3e-3).with_settings(tolerance=1e-5)
    motions = [Motion.harmonic(0.05 * k * G, 0.7, 2.0, direction=0.3) for k in range(12)]
    found = in_lanes(structure, motions, settle=5.0)
    words = []
    for motion, one in list(zip(motions, found, strict=True))[2::3]:
        alone = simulate(structure, motion, settle=5.0)
        words.append(one["verdict"])
        assert one["verdict"] == alone.verdict
        if alone.overturned:
            assert one["overturn_time"] == pytest.approx(alone.overturn_time, rel=1e-6)  # measured: 3.3e-8
        else:
            assert math.isnan(one["overturn_time"])
            assert one["settled_for"] == pytest.approx(alone.stats["settled_for"])
    assert {"standing", "overturned"} <= set(words)


def test_a_structure_that_does_not_move_is_not_stepped_on() -> None:
    """Follow it after a record without motion, as alone."""
    structure, motion = stack(1, damping=1e-2).with_settings(tolerance=1e-3), Motion.from_samples(0.1, np.zeros(3))
    alone = simulate(structure, motion, duration=60.0, settle=0.0, without=("elastic",))
    (found,) = in_lanes(structure, [motion], duration=60.0)
    assert (found["verdict"], found["settled_for"]) == (alone.verdict, 0.0) == ("standing", 0.0)
    # alone it is looked at after each step, in lanes every 0.25 s
    assert found["steps"] < 2 * alone.stats["steps"]


def test_many_runs_go_through_lanes_and_the_others_alone() -> None:
    """Run structures of two kinds, one of them too lightly damped for lanes; each gives the same bits in any
    company.
    """
    plain, light = trilith().with_settings(tolerance=1e-4), with_law(trilith(), damping=1e-8)
    structures = [replace(light, tolerance=1e-4) if k == 3 else plain for k in range(10)]
    structures[5] = stack(2).with_settings(tolerance=1e-4)
    motions = waves(10)
    tables = [simulate_many(structures, motions, keep=(*KEEP, "path"), settle=0.0, threads=count) for count in (1, 2)]
    assert (tables[0].stats["lanes"], tables[0].stats["scalar"]) == (9, 1)
    assert tables[0].stats["why_scalar"] == {"steps of order 8": 1}
    assert list(tables[0]["path"]).index("scalar") == 3
    for name in KEEP:
        np.testing.assert_array_equal(tables[0][name], tables[1][name])
    for k in (0, 3, 5):
        single = simulate_many(structures[k], motions[k], keep=KEEP, settle=0.0)
        for name in KEEP:
            here, there = np.ravel(single[name][0]), np.ravel(tables[0][name][k])
            np.testing.assert_array_equal(here, there[: here.size])
    alone = simulate_many(structures, motions, keep=(*KEEP, "least_contact"), settle=0.0)
    assert (alone.stats["lanes"], alone.stats["scalar"]) == (0, 10)
    np.testing.assert_allclose(tables[0]["peak_u"], alone["peak_u"], rtol=2e-3)
    assert set(structures[0].kind.keys_of(KEEP)) <= FROM_LANES


def test_an_arch_without_a_rest_has_fallen_and_is_named() -> None:
    thin = arch(9, 5.0, 0.3, 1.0, LAW, angle=math.pi)
    found = simulate_many([thin, thin], waves(2), keep=("peak_u", "verdict"), settle=0.0)
    assert found["verdict"].tolist() == ["overturned"] * 2
    assert "rest" in found.stats["failures"][0]
    assert np.all(np.isnan(found["peak_u"]))


def test_the_trilith_of_the_examples() -> None:
    """Run the trilith of the examples under one record's worth of samples, in lanes and alone, to the same digits."""
    structure = Structure.from_toml(TRILITH)
    motion = recorded(1)
    (found,) = in_lanes(structure, [motion])
    alone = simulate(structure, motion, settle=0.0)
    for axis in ("ux", "uy", "uz"):
        np.testing.assert_allclose(found[f"peak_{axis}"], alone.peaks[axis], rtol=1e-4, atol=1e-7)


@pytest.mark.long  # takes seconds
@pytest.mark.parametrize("friction", [None, 0.4])
def test_an_ensemble_in_lanes_is_that_of_runs_alone(friction: float | None, monkeypatch: pytest.MonkeyPatch) -> None:
    """Check that displacements over time within a tenth of the tolerance (measured: 0.01); some of the eight fall."""
    structure, motion, spread = trilith(friction), waves(1, 0.5)[0], Spread(0.05, 0.05, 0.2)
    ensembles = []
    for lanes in (True, False):
        if not lanes:
            monkeypatch.setattr(type(structure.kind), "in_lanes", lambda *_: False)
        ensemble = simulate(structure, motion, ensemble=8, spread=spread, output_step=0.01).ensemble
        assert ensemble is not None
        assert ensemble.in_lanes is lanes
        ensembles.append(ensemble)
    ours, alone = ensembles
    assert ours.verdicts == alone.verdicts
    assert ours.overturned == 5
    assert ours.overturn_time == pytest.approx(alone.overturn_time, abs=1e-5, nan_ok=True)  # measured: 2.1e-6 s
    assert ours.ux == pytest.approx(alone.ux, abs=1e-4 * float(np.nanmax(alone.ux)), nan_ok=True)
    stands = np.array([verdict != "overturned" for verdict in alone.verdicts])
    assert ours.displacements[stands] == pytest.approx(alone.displacements[stands], rel=1e-3)


def test_an_ensemble_of_structures_without_a_rest_falls_at_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """Take the rest from all varied structures, not from the one as given."""
    structure, motion = trilith(), waves(1)[0]

    def rest(model: Structure) -> Any:
        if model is not structure:
            raise NoRestError("no rest")
        return rest_of(model)

    for module in (kind, run):
        monkeypatch.setattr(module, "rest_of", rest)
    ensemble = simulate(structure, motion, ensemble=8, settle=0.0, output_step=0.01).ensemble
    assert ensemble is not None
    assert ensemble.overturned == 8
    assert np.all(ensemble.overturn_time == motion.start)


def test_the_longest_step_of_a_structure_is_found_once(monkeypatch: pytest.MonkeyPatch) -> None:
    asked: list[Structure] = []

    def counted(structure: Structure) -> float:
        asked.append(structure)
        return fastest_decay(structure)

    monkeypatch.setattr("solver.models.structure.lanes.fastest_decay", counted)
    simulate_many(trilith().with_settings(tolerance=1e-4), waves(3), keep=KEEP, settle=0.0)
    assert len(asked) == 1


def test_a_drum_on_the_base_shares_no_lanes_with_one_on_a_circle() -> None:
    """Slide both by 0.1 m and more: in the same lanes the drum on the base was one on a circle of its size."""
    law = {"stiffness": 1e8, "damping": 1e-3, "friction": 0.1}
    drum = {"name": "d", "shape": "drum", "diameter": 1.0, "height": 0.3, "density": 2000.0}
    joint = {"between": ["d", "base"], "at": [0.0, 0.0, 0.0], "section": "circle", "diameter": 1.0}
    ground = Structure.from_dict({"name": "ground", "joints": law, "block": [{**drum, "on": "base"}]})
    plate = {**drum, "position": [0.0, 0.0, 0.0]}
    circle = Structure.from_dict({"name": "circle", "joints": law, "block": [plate], "joint": [joint]})
    assert share_of(ground) != share_of(circle)
    motions = waves(8, size=0.3)
    both = simulate_many([ground, circle] * 4, motions, keep=("peak_u", "path"), settle=0.0)
    for k in range(2):
        alone = simulate_many([(ground, circle)[k]] * 4, motions[k::2], keep=("peak_u",), settle=0.0)
        assert np.min(both["peak_u"][k::2]) > 0.1
        assert np.array_equal(both["peak_u"][k::2], alone["peak_u"])
