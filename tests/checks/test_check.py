"""Checks from motions to sentences: against runs made apart, and properties of margin, table and report."""

import math
import re
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from multiblock import (
    Block,
    Check,
    Column,
    InputError,
    Joint,
    Limits,
    Motion,
    Plan,
    check,
    simulate,
    simulate_many,
    spectra,
    spectrum,
    wavelets,
)
from solver.checks.action import ARTIFICIAL, Action, Level, action_on
from solver.checks.answer import margin_sentence, verdict_sentence
from solver.checks.check import checked, write_checks
from solver.checks.limits import TOLERANCE
from solver.checks.margin import MOST, NARROW, STEP, Margin, margin_of
from solver.checks.runs import is_turned, span_of, varied
from solver.checks.scaling import ScaledMotion, applied
from solver.checks.subject import subject_of
from solver.checks.table import Row, overturning
from solver.checks.verdicts import Verdicts
from solver.commands.check_report import check_lines
from solver.gallery.survey import common_action
from solver.models.protocol import SETTLE

G = 9.80665
BLOCK = Column("block", (Block(2.0, 0.5, 0.5, 1200.0, Joint(2e9, 2e-3, strength=2e6)),))
PULSES = {f"{frequency} Hz": wavelets.one_sine(G, frequency) for frequency in (0.8, 1.2, 2.0)}
SHORT = Plan(ensemble=4, joints=False)


@pytest.fixture(scope="module")
def found() -> Check:
    """Return a block under three sines of 0.15 g, which it survives."""
    return check(BLOCK, PULSES, pga=0.15 * G, plan=SHORT)


def row(made: Check, name: str) -> Row:
    return next(one for one in made.rows if one.name == name)


def test_rows_have_the_largest_of_runs_made_apart(found: Check) -> None:
    runs = [simulate(BLOCK, motion.scaled_to(0.15 * G)) for motion in PULSES.values()]
    assert [run.verdict for run in runs] == ["standing"] * 3
    top = row(found, "displacement of the top")
    assert top.values == tuple(run.peak_top_ux[0] for run in runs)
    assert top.demand == max(top.values)
    stands = found.runs["peak_top_ux"][found.runs["verdict"] == "standing", 0]
    assert top.band == tuple(np.percentile(stands, [16, 50, 84]))
    assert f"16, 50, 84 % points {1e3 * top.band[0]:.3g}, " in top.remark
    assert top.capacity == pytest.approx(0.4 * 0.5, rel=0.06)  # on its edge: about its width, measured 0.486 m
    pressure = row(found, "pressure at the edge")
    assert pressure.demand == max(run.peaks["sigma_max"][0] for run in runs)
    assert pressure.capacity == 2e6
    asked = row(found, "friction asked for")
    assert asked.passes is None
    # exceeded for as long as it says, within a row of 5 ms at each crossing; measured: 0.0452 s
    exceeded = [run.time_exceeded(asked.demand)[0] for run in runs]
    assert max(exceeded) == pytest.approx(0.05, abs=0.01)
    assert found.action.statistic == "largest of 3 motions"


def test_margin_has_falls_beyond_it_and_none_within(found: Check) -> None:
    """Compare with runs of the same varied columns by `simulate_many`."""
    assert found.margin is not None
    margin = found.margin
    assert 1.0 <= margin.stands < margin.falls <= NARROW * margin.stands
    worst = found.action.motions[margin.place]
    run = found.responses[margin.place]
    ensemble = [(found.subject.to_vary(run), run.motion), *varied(found.subject, run, worst, SHORT, margin.place)]
    for factor, falls in ((margin.stands, False), (margin.falls, True)):
        shaken = [motion.scaled(factor) for _, motion in ensemble]
        table = simulate_many([column for column, _ in ensemble], shaken, tolerance=TOLERANCE)
        assert bool(np.any(table["verdict"] != "standing")) is falls
    assert row(found, "overturning, margin").ratio == 1.0 / margin.stands


# each marked one takes a second or more
@pytest.mark.parametrize("pga", [0.01, *(pytest.param(pga, marks=pytest.mark.long) for pga in (0.15, 0.6)), 30.0])
def test_sets_of_runs_are_numbered_up_to_a_bound(pga: float) -> None:
    phases: list[str] = []

    def callback(done: int, total: int | None) -> None:
        assert total is None or done <= total

    callback.begin = phases.append  # type: ignore[attr-defined]
    subject = subject_of(BLOCK)
    motion = PULSES["2.0 Hz"].scaled_to(pga * G)
    checked(subject, Action((ScaledMotion("sine", motion, 1.0, 1.0),), "as given"), Plan(ensemble=1), callback)
    counts = [re.match(r"set (\d+) of at most (\d+), ", phase) for phase in phases]
    assert [int(one[1]) for one in counts if one] == list(range(1, len(phases) + 1))
    assert len(phases) <= 1 + 13 + 4  # as given, margin, other joints
    assert {int(one[2]) for one in counts if one} == {1 + 13 + 4}


def test_margin_of_a_stronger_motion_is_smaller(found: Check) -> None:
    """Check that twice the motion has half the margin, within both bisections, where the first falls are the same."""
    assert found.margin is not None
    strong = [applied(scaled.name, scaled.motion, 2.0 * found.margin.falls) for scaled in found.action.motions]
    ensembles = [varied(found.subject, found.responses[k], scaled, SHORT, k) for k, scaled in enumerate(strong)]
    margin = margin_of(found.subject, ensembles, np.array([True] * 3))
    assert margin.falls < 1.0
    assert margin.stands <= margin.falls <= NARROW * margin.stands
    weak = [[(column, motion.scaled(1e-3)) for column, motion in ensemble] for ensemble in ensembles]
    still = margin_of(found.subject, weak, np.array([False] * 3))
    assert still.is_open
    assert still.stands > MOST / STEP


def test_sentences_say_what_was_found(found: Check) -> None:
    assert found.fallen == (0, 0, 12)
    assert found.verdict == (
        "As given the column stands under all 3 motions. None of 12 varied columns fell, under 3 motions: with 95 % "
        "confidence at most 70.8 % of such columns would fall in such shaking."
    )  # 1 - 0.025^(1/3) = 0.7076
    assert found.margin is not None
    assert f"about {found.margin.stands:.3g} times" in found.margin_sentence


def test_runs_under_one_motion_are_one_trial() -> None:
    stands, falls, may = "standing", "overturned", "undecided"

    def bounds_of(varied: NDArray[np.str_], motions: int) -> tuple[float, float]:
        return Verdicts([str(k) for k in range(motions)], np.array([stands] * motions), varied).bounds

    one = np.array([stands] * 12)
    assert bounds_of(one, 1) == pytest.approx((0.0, 1.0 - 0.025 ** (1.0 / 12.0)), abs=1e-12)
    assert bounds_of(one, 3) == pytest.approx((0.0, 1.0 - 0.025 ** (1.0 / 3.0)), abs=1e-12)
    some = np.array([falls, falls, stands, stands, stands, may])  # of two motions 2/3 and 0, or 2/3 and 1/3
    low, high = bounds_of(some, 2)
    one_of_two = 1.0 - 0.975**0.5, 0.975**0.5
    assert low == pytest.approx(2.0 / 3.0 * one_of_two[0])  # between none and one of two
    assert high == pytest.approx(one_of_two[1])  # one of two


def test_the_other_direction_is_named_unless_it_is_the_same(found: Check) -> None:
    def said(both: bool = False, **sizes: Any) -> tuple[str, ...]:
        blocks = tuple(replace(block, **sizes) for block in BLOCK.blocks)
        subject = subject_of(replace(BLOCK, blocks=blocks))
        components, *others = replace(found, subject=subject, both=both).remarks
        assert components.startswith("One horizontal component acts; codes ask for two together")
        return tuple(others)

    width = BLOCK.blocks[0].width
    assert "check the other direction too (--both)" in said(depth=2.0 * width)[0]
    assert said(both=True, depth=2.0 * width) == said(depth=width) == ()
    assert "in space they roll on their rims" in said(depth=width, section="circle")[0]


def test_a_column_that_has_no_space_is_not_told_to_go_there(found: Check) -> None:
    leaning = subject_of(replace(BLOCK, blocks=tuple(replace(block, tilt=1e-3) for block in BLOCK.blocks)))
    assert "without --plane" in found.remarks[0]
    assert "cannot be solved in space" in replace(found, subject=leaning).remarks[0]


def test_a_column_that_falls_fails() -> None:
    strong = check(BLOCK, PULSES, pga=1.5 * G, plan=replace(SHORT, margin=False))
    assert not strong.passes
    assert row(strong, "overturning").passes is False
    assert row(strong, "displacement of the top").demand == math.inf
    assert row(strong, "displacement of the top").texts[2] == "falls"
    assert row(strong, "overturning, as given").passes is False
    assert strong.answer == "FAILS by: overturning, as given; overturning."
    assert row(strong, "pressure at the edge").outcome == row(strong, "displacement of the top").brief == "falls"
    assert re.match(r"As given the column falls under .*\. \d+ of 12 varied columns fell", strong.verdict)
    fell = [run for run in strong.responses if run.overturned]
    assert strong.falls_sentence.startswith("The column as given falls at ")
    assert strong.falls_sentence.count("(block 1 over joint 1)") == min(len(fell), 3)
    assert f"at {fell[0].overturn_time:.4g} s under " in strong.falls_sentence
    assert strong.falls_sentence in check_lines(strong)


def test_a_fall_is_no_slip_and_no_pressure() -> None:
    """Check that demands of a motion under which a column falls are not known: nothing is compared with them
    in words.
    """
    rough = Column("rough", tuple(replace(block, joint=replace(block.joint, friction=0.9)) for block in BLOCK.blocks))
    strong = check(rough, {"pulse": PULSES["0.8 Hz"]}, pga=1.5 * G, plan=replace(SHORT, margin=False))
    assert math.isinf(row(strong, "slip").demand)
    assert "slip" not in strong.answer
    (line,) = (line for line in strong.agreement if line.startswith("sliding"))
    assert line.endswith("time histories: runs fall; sliding is not compared")
    assert "inf" not in " ".join((*strong.agreement, strong.answer, strong.verdict))


def test_shares_and_factors_have_the_same_digits_in_table_and_sentences() -> None:
    names = [f"motion {k}" for k in range(7)]
    verdicts = Verdicts(names, np.array(["standing"] * 7), np.array(["standing"] * 56))
    margin = Margin(1.2345, 1.2678, 3)
    *_, share, factor = overturning(verdicts, Limits(), margin, {})
    high = verdicts.bounds[1]
    assert f"0 % to {100.0 * high:.3g} % at 95 % confidence" in share.note
    assert f"at most {100.0 * high:.3g} % of" in verdict_sentence("column", verdicts)
    assert "between 1.23 and 1.27 times motion 3" in factor.note
    assert "can grow to about 1.23 times" in margin_sentence(margin, False)


def test_only_joints_without_friction_are_said_never_to_slide(found: Check) -> None:
    from solver.checks.report.html import never_slide

    assert never_slide(found.subject.joints)[0].startswith("No joint has friction: ")
    some = replace(found.subject.joints, names=("1", "2"), friction=np.array([0.5, math.nan]))
    assert never_slide(some)[0].startswith("1 of 2 joints has no friction: ")
    assert never_slide(replace(some, friction=np.array([0.5, 0.4]))) == ()


def test_limits_decide(found: Check) -> None:
    limits = Limits(friction=0.05, opening=0.01, strength_factor=100.0)
    strict = checked(found.subject, found.action, replace(SHORT, limits=limits, margin=False, joints=False))
    names = [one.name for one in strict.rows if one.passes is False]
    assert names == ["pressure at the edge", "friction asked for", "opening"]
    with pytest.raises(InputError, match=r"limits.share = 2: must be share of the runs that may fall"):
        Limits(share=2)


@pytest.mark.long
def test_sliding_is_compared_where_there_is_friction() -> None:
    slippery = Column("slippery", (Block(1.0, 1.0, 1.0, 2000.0, Joint(2e9, 2e-3, friction=0.2)),))
    made = check(slippery, {"pulse": PULSES["1.2 Hz"]}, pga=0.35 * G, plan=replace(SHORT, margin=False))
    pulse = PULSES["1.2 Hz"].scaled_to(0.35 * G)
    run = simulate(slippery, pulse, duration=span_of(pulse))
    assert row(made, "slip").demand == np.max(np.abs(run.slip))
    assert row(made, "slip").capacity == pytest.approx(0.05)
    assert row(made, "slip that is left").demand == pytest.approx(abs(run.slip[-1, 0]))
    assert row(made, "slip that is left").demand > 1e-3
    assert "codes ask for at least 3" in made.action.statistic


def test_zeros_at_the_end_of_a_record_change_nothing() -> None:
    """Check a block that still rises, and one that still slides, when a pulse ends."""
    rocking = Column("tall", (Block(3.2, 0.8, 0.8, 4900.0, Joint(1e10, 1e-3, friction=0.7)),))
    sliding = Column("low", (Block(0.5, 2.0, 2.0, 4800.0, Joint(1e9, 1e-3, friction=0.15)),))
    time = np.arange(0.0, 8.0, 0.005)
    for column, peak, name in ((rocking, 0.49, "displacement of the top"), (sliding, 0.3, "slip that is left")):
        ax = np.where(time < 0.5, peak * G * np.sin(2.0 * np.pi * time), 0.0)
        padded, short = Motion.from_samples(0.005, ax), Motion.from_samples(0.005, ax[:101])
        made = check(column, {"short": short, "padded": padded}, plan=replace(SHORT, margin=False))
        values = row(made, name).values
        assert values[0] == pytest.approx(values[1], rel=1e-6)
        assert span_of(short) == pytest.approx(span_of(padded), abs=1e-9)
        # measured: 0.59 and 0.76 of it when the pulse ends
        ended = simulate(column, short)
        assert max(ended.peak_top_ux[0], np.max(np.abs(ended.slip))) < 0.8 * values[0]
    # strong motion before, of another component or of the same, does not end the run before the pulse has acted
    time = np.arange(0.0, 12.0, 0.01)
    pulse = np.where(time > 11.0, 3.0 * np.sin(np.pi * (time - 11.0)), 0.0)
    early = np.where(time < 8.0, 6.0 * np.sin(2.0 * np.pi * 8.0 * time), 0.0)
    for ax, az in ((pulse, early), (early + pulse, None)):
        assert span_of(Motion.from_samples(0.01, ax, az)) > 21.5
    harmonic, still = Motion.harmonic(1.0, 2.0, 3.0), Motion.from_samples(0.1, np.zeros(5))
    assert [span_of(motion) for motion in (harmonic, still)] == [harmonic.duration, still.duration]


def test_a_leaning_column_is_shaken_both_ways() -> None:
    leaning = replace(BLOCK, blocks=(replace(BLOCK.blocks[0], tilt=0.03),))
    motion = PULSES["1.2 Hz"].scaled_to(0.15 * G)
    plan = replace(SHORT, margin=False)
    tops = [row(check(leaning, [way], plan=plan), "displacement of the top") for way in (motion, motion.mirrored())]
    ways = [simulate(leaning, way).peak_top_ux[0] for way in (motion, motion.mirrored())]
    assert tops[0].demand == tops[1].demand == max(ways)
    assert ways[0] != pytest.approx(ways[1], rel=0.01)  # measured: 2.8 % apart
    columns = varied(subject_of(leaning), simulate(leaning, motion), ScaledMotion("", motion), SHORT, 0)
    assert [np.sign(shaken.ax @ motion.ax) for _, shaken in columns] == [1.0, -1.0, 1.0, -1.0]


def test_the_sign_that_moves_less_may_govern_slip_and_margin() -> None:
    """Check a column whose upper block stands aside, under a pulse after which it is left further the other way."""
    law = Joint(stiffness=2e8, damping=5e-3, friction=0.25)
    upper = Block(0.8, 0.5, 0.6, 600.0, replace(law, offset=0.12))
    column, pulse = Column("aside", (upper, Block(0.8, 0.6, 0.7, 840.0, law))), wavelets.one_sine(0.3 * G, 1.2)
    made = check(column, {"pulse": pulse}, plan=replace(SHORT, ensemble=1))
    runs = [simulate(column, way, duration=span_of(way), settle=SETTLE) for way in (pulse, pulse.mirrored())]
    tops, left = (
        [float(np.max(value(run))) for run in runs] for value in (lambda r: r.peak_top_ux, lambda r: abs(r.slip[-1]))
    )
    assert tops[0] < 0.6 * tops[1]  # measured: 14.5 and 29.1 mm
    assert left[0] > 2.5 * left[1]  # measured: 9.0 and 3.0 mm
    assert made.responses[0].peak_top_ux[0] == row(made, "displacement of the top").demand == tops[1]
    assert row(made, "slip that is left").demand == left[0]
    assert made.margin is not None
    assert {trial.verdicts.shape[1] for trial in made.margin.trials} == {3}  # both signs as given, and one varied


def test_strength_does_not_move_the_column() -> None:
    bare = replace(BLOCK, blocks=(replace(BLOCK.blocks[0], joint=replace(BLOCK.blocks[0].joint, strength=None)),))
    motion = PULSES["1.2 Hz"].scaled(0.2)
    assert simulate(BLOCK, motion).ux.tobytes() == simulate(bare, motion).ux.tobytes()
    assert Column.from_dict(BLOCK.to_dict()) == BLOCK
    with pytest.raises(InputError, match=r"block\[1\].joint.strength = -1: must be a positive pressure in Pa"):
        Column("x", (Block(1.0, 1.0, 1.0, 1e3, Joint(1e9, 0.0, strength=-1)),))


def test_fingerprint_is_of_the_inputs(found: Check) -> None:
    same = Check(**{name: getattr(found, name) for name in found.__dataclass_fields__})
    assert same.fingerprint == found.fingerprint
    other = replace(found, plan=replace(SHORT, ensemble=5))
    assert other.fingerprint != found.fingerprint
    scaled = tuple(ScaledMotion(one.name, one.motion.scaled(1.0 + 1e-15), 1.0) for one in found.action.motions)
    assert replace(found, action=Action(scaled, "")).fingerprint != found.fingerprint
    prints = set()
    for amplitude in (1.0, 2.0):  # a harmonic has no samples of its own
        harmonic = ScaledMotion("", Motion.harmonic(amplitude, 1.0, 2.0))
        prints.add(replace(found, action=Action((harmonic,), "")).fingerprint)
    assert len(prints) == 2


def test_motions_may_be_files(tmp_path: Path) -> None:
    PULSES["2.0 Hz"].to_csv(tmp_path / "pulse.csv")
    made = check(BLOCK, [tmp_path / "pulse.csv", PULSES["2.0 Hz"]], sa=0.2 * G, plan=replace(SHORT, margin=False))
    assert [scaled.name for scaled in made.action.motions] == ["pulse", "motion 2"]
    assert made.action.motions[0].factor == pytest.approx(made.action.motions[1].factor, rel=1e-9)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({}, "motions: none given"),
        ({"pga": 1.0, "sa": 1.0}, "target, pga, sa: must be one of them"),
        ({"vertical_pga": 1.0}, "vertical_pga: must be left out without pga"),
        ({"periods": (0.1, 1.0)}, "periods: must be left out without a target spectrum"),
    ],
)
def test_contradictions_are_refused(words: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        check(BLOCK, (), **words)


@pytest.mark.parametrize(
    ("words", "message"),
    [
        ({"pga": 1.0, "vertical_pga": 0.5}, "vertical_pga: must be left out, 2.0 Hz has no vertical component"),
        ({"pga": 1.0, "vertical_pga": -0.5}, "vertical_pga = -0.5: must be a positive acceleration in m/s2"),
        ({"pga": 1.0, "vertical": True}, "vertical: of artificial motions, must be left out where records are given"),
        ({"pga": 1.0, "artificial": 3, "seed": 2}, "artificial, seed: of artificial motions, must be left out where"),
        ({"pga": 1.0, "least": 0.8}, "least: must be left out without records that are scaled to a target spectrum"),
    ],
)
def test_vertical_components_that_are_missing_are_refused(words: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        check(BLOCK, {"2.0 Hz": PULSES["2.0 Hz"]}, **words)


def test_the_range_of_a_fit_begins_at_four_samples_for_records_too() -> None:
    """Check a stiff block, 0.2 T1 of which is 5 ms; a range that is given stays as it is."""
    stiff = Column("stiff", (Block(0.5, 0.5, 0.5, 300.0, Joint(5e9, 2e-3)),))
    level = Level(spectra.eurocode8(0.05 * G, "A"), None, None, None, None, 0.9, ARTIFICIAL, False, 0)
    subject = subject_of(stiff)
    assert 0.2 * subject.period < 0.01
    for made in (action_on(subject, PULSES, level), common_action([subject], PULSES, level, None)):
        assert made.periods is not None
        assert made.periods[0] == 0.04
    made = action_on(subject, PULSES, replace(level, periods=(0.01, 1.0)))
    assert made.periods == (0.01, 1.0)


@pytest.mark.long  # takes seconds
def test_artificial_motions_where_none_are_given() -> None:
    made = check(
        BLOCK, target=spectra.eurocode8(0.05 * G, "A"), artificial=3, plan=Plan(ensemble=1, margin=False, joints=False)
    )
    assert [scaled.name for scaled in made.action.motions] == ["artificial 0", "artificial 1", "artificial 2"]
    assert made.action.periods is not None
    assert made.action.periods[0] == max(0.04, 0.2 * made.period)  # shorter ones artificial motions do not follow
    assert made.action.fit is not None
    assert 0.9 - 1e-12 <= made.action.fit[0] <= made.action.fit[1] < 1.2
    assert made.passes


@pytest.mark.long  # takes seconds
def test_artificial_motions_have_vertical_components_where_wanted() -> None:
    target = spectra.eurocode8(0.05 * G, "A")
    assert target.vertical is not None
    plan = Plan(ensemble=1, margin=False, joints=False)
    motion = check(BLOCK, target=target, artificial=1, vertical=True, plan=plan).action.motions[0].motion
    periods = np.geomspace(0.05, 2.0, 20)
    ratio = spectrum(motion, periods, component="az").psa / target.vertical.psa(periods)
    assert 0.8 < ratio.min() < ratio.max() < 1.2  # measured: 0.90 to 1.13
    assert abs(np.corrcoef(motion.ax, motion.az)[0, 1]) < 0.1
    with pytest.raises(InputError, match="vertical: flat has no vertical spectrum, must be left out"):
        check(BLOCK, target=replace(target, name="flat", vertical=None), vertical=True, plan=plan)


def test_table_is_written_with_each_motion(found: Check, tmp_path: Path) -> None:
    found.to_csv(tmp_path / "table.csv")
    lines = (tmp_path / "table.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == "check,where,demand,capacity,ratio,passes,note,p16,p50,p84,0.8 Hz,1.2 Hz,2.0 Hz"
    assert len(lines) == 1 + len(found.all_rows)


def test_tables_of_several_checks_have_the_names_of_their_models(found: Check, tmp_path: Path) -> None:
    other = replace(found, subject=replace(found.subject, model=replace(found.subject.model, name="other")))
    found.to_csv(tmp_path / "one.csv")
    write_checks(tmp_path / "both.csv", (found, other))
    head, *one = (tmp_path / "one.csv").read_text(encoding="utf-8").splitlines()
    names = [name for name in (found.name, "other") for _ in one]
    wanted = [f"model,{head}", *(f"{name},{line}" for name, line in zip(names, [*one, *one], strict=True))]
    assert (tmp_path / "both.csv").read_text(encoding="utf-8").splitlines() == wanted


@pytest.mark.long  # takes seconds
def test_report_has_everything_inside(found: Check, tmp_path: Path) -> None:
    from solver.checks.report.html import write_report

    path = tmp_path / "report.html"
    write_report([found, found], path, "multiblock check <block>")
    text = path.read_text(encoding="utf-8")
    addresses = re.findall(r"(?:src|href|url)\s*[=(]\s*(?:[\"']|&quot;)?([^\"')\s>]{1,30})", text)
    assert sum(address.startswith("data:image/png;base64,") for address in addresses) == 5  # of the variant its model
    assert all(address.startswith("data:") for address in addresses)
    assert text.count("<iframe") == 1  # the scene of the governing run
    assert "http" not in text
    for said in (found.verdict, found.fingerprint, "multiblock check &lt;block&gt;", "Variants under the same motions"):
        assert said in text
    for one in found.all_rows:
        assert one.name in text


def test_motion_as_given_is_not_scaled() -> None:
    motion = Motion.from_samples(0.01, 0.3 * np.sin(np.arange(200) * 0.1))
    made = check(BLOCK, [motion], plan=Plan(ensemble=1, margin=False, joints=False))
    assert made.action.motions[0].motion is motion
    assert made.action.motions[0].factor == 1.0


def test_a_share_that_may_fall_needs_no_margin() -> None:
    """Check that an allowed share of falls is not compared a second time, and that nothing is hidden by it."""
    cases: list[tuple[int, str, float, bool | None]] = [
        (1, "standing", 0.2, None),
        (1, "standing", 0.1, None),
        (1, "standing", 0.05, False),
        (1, "standing", 0.0, False),
        (1, "overturned", 0.2, False),
        (0, "standing", 0.2, True),
    ]
    for fallen, own, share, passes in cases:
        words = np.array(["overturned"] * fallen + ["standing"] * (10 - fallen))
        stands = 0.8 if fallen else 1.3
        verdicts, margin = Verdicts(["sine"], np.array([own]), words), Margin(stands, 1.02 * stands, 0)
        rows = {one.name: one for one in overturning(verdicts, Limits(share=share), margin, {})}
        assert rows["overturning"].passes is (0.1 * fallen <= share)
        found = rows["overturning, margin"]
        assert found.passes is passes
        assert found.brief == f"bears {stands:g} x"
        assert f"between {stands:g} and" in found.note


def test_a_varied_column_too_soft_to_stand_has_fallen() -> None:
    """Check a block whose modulus is just above that at which it does not stand: every other one has less."""
    weight, inertia = 2000.0 * 0.16 * G, 0.2**4 / 12.0
    block = Block(4.0, 0.2, 0.2, 320.0, Joint(1.05 * weight * 2.0 / inertia, 2e-3))
    slow = Motion.from_samples(0.5, [0.0, 1e-6, 0.0])
    found = check(Column("tall", (block,)), {"slow": slow}, plan=Plan(ensemble=8, margin=False, joints=False))
    fallen, undecided, size = found.fallen
    assert (size, undecided) == (8, 0)
    assert 0 < fallen < 8  # was an error: tall cannot stand
    assert f"{fallen} of them under their weight alone (tall cannot stand: " in row(found, "overturning").note


def test_a_harmonic_that_is_turned_is_said_to_be() -> None:
    for direction in (0.0, 0.5 * math.pi, 0.3):
        motion = Motion.harmonic(1.0, 2.0, 0.1, direction)
        turned, same = (SimpleNamespace(motion=one) for one in (motion.mirrored(), motion))
        assert is_turned(turned, motion)
        assert not is_turned(same, motion)
