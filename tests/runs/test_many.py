"""Many runs in one table: the same numbers as one by one, whatever makes them and in which order."""

from __future__ import annotations

import csv
import math
import threading
from concurrent.futures import Future, ProcessPoolExecutor, ThreadPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support.probe import PHOCAS_STIFFNESS, G, monolith, phocas

from multiblock import Structure
from solver import Block, Column, InputError, InputWarning, Joint, Motion, SolverError, Table, simulate, simulate_many
from solver.common.turns import lock_held, lock_released
from solver.models.column.outputs import KEPT, OUTPUTS, WATCHED
from solver.runs.many import ExecutorError, Summary, collected, parts_of_many
from solver.runs.pace import MOST_RUNS, Pace

WATCHED_BY_NAME = [output.extreme for output in OUTPUTS if output.kept in WATCHED]
KEEP = ("peak_top_ux", "residual_top_ux", "residual_ry", "energy", "verdict", "overturn_time", "fallen", "steps")


def mixture() -> tuple[list[Column], list[Motion], list[float]]:
    """Return columns of one and of three blocks, the paper's formulation, weak and strong motions, one that falls."""
    columns = [phocas(1e-3), monolith(eta=1e-3), phocas(5e-3, formulation="paper"), phocas(2e-2)] * 5
    motions = [Motion.harmonic(0.01 * G * (k + 1), 2.0, 1.0) for k in range(19)] + [Motion.harmonic(0.6 * G, 0.4, 3.0)]
    return columns, motions, [0.5 + 0.05 * k for k in range(19)] + [3.0]


def phocas_on(stiffness: float) -> Column:
    column = phocas(1e-3)
    return replace(column, blocks=tuple(replace(b, joint=replace(b.joint, stiffness=stiffness)) for b in column.blocks))


def assert_same(one: Table, other: Table) -> None:
    assert list(one) == list(other)
    for name in one:
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name


def test_runs_are_those_of_simulate() -> None:
    columns, motions, durations = mixture()
    table = simulate_many(columns, motions, duration=durations, keep=KEEP, responses=[4])
    assert len(table) == 20
    assert table["peak_top_ux"].shape == (20, 3)
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        single = simulate(column, motion, duration, tolerance=1e-8, output_step=duration)
        n = column.n
        assert table["verdict"][k] == single.verdict
        assert table["fallen"][k] == single.fallen
        assert np.all(np.isnan(table["peak_top_ux"][k, n:]))
        assert table["peak_top_ux"][k, :n] == pytest.approx(single.peak_top_ux, rel=1e-3)
        if single.overturned:
            assert table["overturn_time"][k] == pytest.approx(single.overturn_time, abs=1e-3)
            assert np.all(np.isnan(table["residual_top_ux"][k]))
        else:
            assert math.isnan(table["overturn_time"][k])
            largest = float(np.max(single.peak_top_ux))
            assert table["residual_top_ux"][k, :n] == pytest.approx(single.ux[-1], abs=1e-3 * largest)
            assert table["residual_ry"][k, :n] == pytest.approx(single.ry[-1], abs=1e-3 * largest)
    assert list(table.responses) == [4]
    assert np.array_equal(table.responses[4].ux, simulate(columns[4], motions[4], durations[4]).ux)
    assert table.stats["lanes"] + table.stats["scalar"] == table.stats["runs"] == 20


def sliding(friction: float = 0.1) -> Column:
    """Return Phocas in drums as squat as they are high, whose joints slide before they open."""
    block = Block(1.0, 1.56, 1.56, 5500.0, Joint(PHOCAS_STIFFNESS, 2e-3, friction=friction))
    return Column("drums", (block,) * 2)


def test_peaks_of_every_output_are_those_of_simulate() -> None:
    """Compare bit for bit, as these runs are made one by one: of one, two and three blocks, either formulation, that
    slide.
    """
    columns = [phocas(1e-3), monolith(eta=1e-3), phocas(5e-3, formulation="paper"), sliding(), phocas(1e-3)]
    motions = [Motion.harmonic(a * G, f, 1.0) for a, f in ((0.1, 2.0), (0.2, 1.5), (0.01, 2.0), (0.3, 1.0), (0.6, 0.4))]
    durations = [1.0, 1.0, 0.2, 1.0, 3.0]
    keep = ("peak_top_ux", *WATCHED_BY_NAME, "residual_slip", "verdict")
    table = simulate_many(columns, motions, duration=durations, keep=keep)
    for k, (column, motion, duration) in enumerate(zip(columns, motions, durations, strict=True)):
        single = simulate(column, motion, duration)
        assert list(single.peaks) == [output.field for output in OUTPUTS]
        for output in OUTPUTS:
            name, peak = output.extreme.replace("peak_ux", "peak_top_ux"), single.peaks[output.field]
            if output.owner == "base":
                assert table[name].shape == (5,)
                assert table[name][k] == peak[0]
            else:
                assert np.array_equal(table[name][k, : column.n], peak), name
                assert np.isnan(table[name][k, column.n :]).all()
        slip = np.full(column.n, math.nan) if single.overturn_time <= duration else single.slip[-1]
        assert table["residual_slip"][k, : column.n] == pytest.approx(slip, nan_ok=True, abs=1e-9)
    assert np.all(np.abs(table["residual_slip"][3, :2]) > 5e-4)  # m: 0.8 and 100 mm
    assert table["verdict"][4] == "overturned"
    assert table.stats["scalar"] == 5
    assert table.stats["why_scalar"]["peaks of more than ux"] == 5
    with pytest.raises(InputError, match=r'columns\[0\]: solver.without has "peaks", must not where peak_N is kept'):
        simulate_many(phocas(1e-3, without=("peaks",)), motions[0], keep=("peak_N", "verdict"))


def test_what_is_kept_has_a_unit_and_is_what_a_response_has() -> None:
    assert {"peak_ux", *WATCHED} == {output.kept for output in OUTPUTS}
    without_unit = {
        "least_contact",
        "least_bond",
        "peak_friction",
        "verdict",
        "overturned_joint",
        "steps",
        "evaluations",
        "path",
    }
    assert {name for name, kept in KEPT.items() if not kept.unit} == without_unit


def test_motions_that_end_before_the_run_does() -> None:
    """Check that the base falls silent at once, from a sample or a harmonic that is not zero, while the column rocks in
    a lane.
    """
    time = 0.01 * np.arange(101)
    record = Motion.from_samples(0.01, 1.2 * np.sin(11.0 * time) + 0.8 * np.cos(5.0 * time), 0.3 * np.sin(7.0 * time))
    motions = [record, Motion.harmonic(0.1 * G, 1.7, 0.8), record.mirrored(), record.scaled(0.5)]
    columns = [phocas(1e-3), phocas(2e-3), monolith(eta=1e-3), phocas(1e-3)]
    table = simulate_many(columns, motions, duration=1.5, tolerance=1e-5, keep=(*KEEP, "path"))
    assert list(table["path"]) == ["lanes"] * 4
    for k, (column, motion) in enumerate(zip(columns, motions, strict=True)):
        single = simulate(column, motion, 1.5, tolerance=1e-9, output_step=1.5)
        largest = float(np.max(single.peak_top_ux))
        assert single.stats["full_contact"] < 0.5
        # measured 4e-5
        assert table["peak_top_ux"][k, : column.n] == pytest.approx(single.peak_top_ux, abs=2e-4 * largest)
        assert table["residual_top_ux"][k, : column.n] == pytest.approx(single.ux[-1], abs=2e-4 * largest)


@pytest.mark.long  # takes seconds
def test_single_ones_stand_for_all_and_what_is_iterated_is_taken_as_needed() -> None:
    one, motion = phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 0.5)
    assert len(simulate_many(one, motion)) == 1
    taken = []

    def endless() -> Any:
        for k in range(10**9):
            taken.append(k)
            yield motion.scaled(1.0 + 1e-4 * k)

    parts = parts_of_many(one, endless(), threads=2)
    first = next(parts)
    parts.close()  # type: ignore[attr-defined]
    assert len(taken) < 6 * MOST_RUNS
    motions = [motion.scaled(1.0 + 1e-4 * k) for k in range(first.first, first.first + len(first))]
    assert_same(first, simulate_many([one] * len(motions), motions))


@pytest.mark.parametrize(
    ("total", "workers", "each", "expected"),
    [
        (56, 1, 0.1, [56]),  # all in common lanes
        (56, 2, 0.1, [32, 24]),
        (200, 2, 0.1, [56, 40, 32, 24, 16, 16, 16]),  # shorter ones at the end, for every worker
        (None, 2, 0.1, [64, 64, 64]),
        (None, 2, 0.5, [24, 24, 24]),  # 5 times 2 s
        (None, 2, 100.0, [8, 8, 8]),
        (None, 2, 0.01, [200, 200, 200]),  # 2 s
    ],
)
def test_a_chunk_has_as_many_runs_as_fill_lanes_or_takes_some_seconds(
    total: int | None, workers: int, each: float, expected: list[int]
) -> None:
    pace = Pace(total, workers, each)
    made: list[int] = []
    if total != 56:  # a run has been measured
        pace.update_cost(MOST_RUNS, MOST_RUNS, MOST_RUNS * each)
    while sum(made) < (total or sum(expected)):
        rest = None if total is None else total - sum(made)
        count = next(k for k in range(1, MOST_RUNS) if k == rest or pace.enough(k, float(k)))
        pace.sent(count)
        made.append(count)
    assert made == expected


@pytest.mark.parametrize("threads", [1, 3, 8])
def test_the_same_bits_in_any_order_and_number_of_threads(threads: int) -> None:
    columns, motions, durations = mixture()
    order = np.random.default_rng(threads).permutation(len(columns))
    table = simulate_many(columns, motions, duration=durations, keep=KEEP, threads=2)
    other = simulate_many(
        [columns[k] for k in order],
        [motions[k] for k in order],
        duration=[durations[k] for k in order],
        keep=KEEP,
        threads=threads,
    )
    for name in KEEP:
        assert np.array_equal(table[name][order], other[name], equal_nan=table[name].dtype.kind == "f"), name


def test_a_column_under_many_motions_is_as_many_equal_columns() -> None:
    """Check that it is assembled once, and its barriers are found once (settling.py)."""
    motions = [Motion.harmonic(0.4 * G, 0.5 + 0.05 * k, 2.0) for k in range(16)]
    column = phocas(1e-3)
    one = simulate_many(column, motions, tolerance=1e-3, keep=KEEP)
    assert {"standing", "overturned"} <= set(one["verdict"])
    copies = [Column.from_dict(column.to_dict()) for _ in motions]
    assert_same(one, simulate_many(copies, motions, tolerance=1e-3, keep=KEEP))


def test_the_same_bits_from_processes() -> None:
    columns, motions, durations = mixture()
    with ProcessPoolExecutor(2, mp_context=get_context("spawn")) as pool:
        there = simulate_many(columns, motions, duration=durations, keep=KEEP, executor=pool)
    assert_same(there, simulate_many(columns, motions, duration=durations, keep=KEEP))


class Unreliable:
    """An executor whose workers die now and then, or from some moment on for good."""

    def __init__(self, pool: ThreadPoolExecutor, lasts: int) -> None:
        self.pool, self.lasts, self.sent = pool, lasts, 0

    def submit(self, function: Any, *arguments: Any) -> Future[Any]:
        self.sent += 1
        if self.sent > self.lasts:
            raise RuntimeError("closed")
        return self.pool.submit(self._die if self.sent % 2 else function, *arguments)

    def _die(self, *_: Any) -> None:
        raise OSError("lost")


def test_what_a_dead_worker_had_is_done_again() -> None:
    columns, motions, durations = mixture()
    with ThreadPoolExecutor(2) as pool:
        table = simulate_many(columns, motions, duration=durations, keep=KEEP, executor=Unreliable(pool, 1000))
        assert_same(table, simulate_many(columns, motions, duration=durations, keep=KEEP))
        with pytest.raises(ExecutorError, match="takes no more runs: RuntimeError: closed") as lost:
            simulate_many([phocas(1e-3)] * 100, motions[0], duration=0.1, executor=Unreliable(pool, 2))
    assert all(len(part) for part in lost.value.finished)


def test_what_is_wrong_is_said_in_one_line() -> None:
    one, motion = phocas(1e-3), Motion.harmonic(0.05 * G, 2.0, 0.5)
    soft = phocas_on(1e5)
    for arguments, options, message in (
        (([one] * 3, [motion] * 2), {}, "3 columns, 2 motions"),
        ((iter([one] * 3), [motion] * 2), {}, "motions: ends after 2, columns does not"),
        (([one] * 2, iter([motion] * 3)), {}, "columns: ends after 2, motions does not"),
        ((one, motion), {"keep": ("peak_uy",)}, "keep: 'peak_uy'"),
        ((one, motion), {"duration": [1.0, -1.0]}, r"duration\[1\] = -1.0"),
        ((one, motion), {"tolerance": [1e-3, 1.0]}, r"tolerance\[1\]: solver.tolerance = 1.0"),
        ((one, motion), {"threads": 0}, "threads = 0"),
        ((one, motion), {"executor": 4}, "executor = 4"),
        (([one, None], motion), {}, r"columns\[1\] = None"),
        ((one, [motion, 3]), {}, r"motions\[1\] = 3"),
        (([one, soft], motion), {}, r"columns\[1\]: phocas cannot stand"),
    ):
        with pytest.raises(InputError, match=message):
            simulate_many(*arguments, **options)


def test_a_run_that_fails_is_undecided_and_reported() -> None:
    """Check that the first-order formulation does not know a base that throws the blocks about."""
    wild = Motion.harmonic(1e6, 50.0, 1.0)
    table = simulate_many(phocas(1e-3, formulation="paper"), [wild, Motion.harmonic(0.01 * G, 2.0, 0.2)], keep=KEEP)
    assert table["verdict"][0] in ("undecided", "overturned")
    assert table.stats["failed"] == len(table.stats["failures"])
    assert np.isnan(table["peak_top_ux"][0]).all() == (0 in table.stats["failures"])
    assert table["verdict"][1] == "standing"


def test_a_table_as_csv(tmp_path: Path) -> None:
    columns, motions, durations = mixture()
    table = simulate_many(columns[:3], motions[:3], duration=durations[:3])
    table.to_csv(tmp_path / "runs.csv")
    with open(tmp_path / "runs.csv", newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    assert [row["run"] for row in rows] == ["0", "1", "2"]
    assert [row["verdict"] for row in rows] == ["standing"] * 3
    found = np.array([[float(row[f"peak_ux[{i}]"]) for i in (1, 2, 3)] for row in rows])
    assert np.array_equal(found, table["peak_top_ux"], equal_nan=True)
    with pytest.raises(KeyError, match="energy: not kept, only peak_top_ux, verdict"):
        table["energy"]


def test_threads_have_their_turns_one_after_the_other_and_lose_none_by_a_mistake() -> None:
    within, most = [0], [0]
    rest = threading.Event()

    def work(k: int) -> None:
        with lock_held(), lock_held():
            within[0] += 1
            most[0] = max(most[0], within[0])
            rest.wait(1e-3)
            within[0] -= 1
            with lock_released(), lock_released():
                rest.wait(1e-3)
            if k == 3:
                raise ZeroDivisionError

    with ThreadPoolExecutor(4) as pool:
        ended = [pool.submit(work, k) for k in range(20)]
    assert [k for k, future in enumerate(ended) if future.exception() is not None] == [3]
    assert most == [1]


def test_a_response_of_no_run_is_refused() -> None:
    with pytest.raises(InputError, match=r"responses: 5: must be numbers of runs, of which there are 1, from 0"):
        simulate_many(phocas(), mixture()[1][0], responses=[5])


def test_all_failures_have_their_reasons_in_the_order_of_the_runs() -> None:
    """Check more than the hundred that were listed, in several chunks."""
    tall = {"name": "tall", "on": "base", "width": 0.2, "depth": 0.2, "height": 4.0, "density": 2000.0}
    law = {"stiffness": 1e7, "damping": 2e-3}  # it stands from 4.7e7 on
    structure = Structure.from_dict({"name": "tall", "joints": law, "block": [tall]})
    table = simulate_many(structure, [Motion.harmonic(0.1, 2.0, 0.1)] * 250, threads=2)
    assert set(table["verdict"]) == {"overturned"}
    assert list(table.stats["failures"]) == list(range(250))
    assert table.stats["failed"] == 250


def test_a_response_that_cannot_be_made_ends_no_other_run(monkeypatch: pytest.MonkeyPatch) -> None:
    def ends(*_: object) -> None:
        raise SolverError("too many steps")

    monkeypatch.setattr(phocas(1e-3).kind, "single_run", ends, raising=False)
    motions = [Motion.harmonic(0.01 * G, 2.0, 0.2)] * 3
    table = simulate_many(phocas(1e-3), motions, responses=[1])
    assert table["verdict"].tolist() == ["standing"] * 3
    assert (table.responses, table.stats["failures"]) == ({}, {})
    assert table.stats["no_response"] == {1: "too many steps"}


def test_a_column_without_a_rest_falls_at_once_where_it_is_not_refused() -> None:
    one, motion = phocas(1e-3), Motion.harmonic(0.01 * G, 2.0, 0.2)
    summary = Summary()
    parts = parts_of_many(
        [one, phocas_on(1e5)], motion, keep=("verdict", "overturn_time"), summary=summary, refuses=False
    )
    table = collected(parts, summary)
    assert table["verdict"].tolist() == ["standing", "overturned"]
    assert table["overturn_time"][1] == motion.start
    assert table.stats["failures"][1].startswith("phocas cannot stand: ")


def test_a_run_as_long_as_its_wave_does_not_depend_on_longer_ones() -> None:
    """Compare runs under one harmonic, some beyond its end: equal bits; they began in another way beside those."""
    column, motion = phocas(5e-3, tolerance=1e-4), Motion.harmonic(0.3 * G, 1.5, 2.0)
    keep = ("peak_top_ux", "steps")
    together = simulate_many([column] * 2, motion, duration=[2.0, 4.0], keep=keep)
    alone = simulate_many(column, motion, duration=2.0, keep=keep)
    for name in keep:
        assert together[name][0].tobytes() == alone[name][0].tobytes(), name


def late(motion: Motion) -> Motion:
    """Return a motion in seconds since 1970, whose instants are 2e-7 s apart at least: no step can be short enough."""
    return replace(motion, time=1.7e9 + motion.time, duration=float(np.ptp(1.7e9 + motion.time)))


def test_a_run_that_ends_in_lanes_and_alone_keeps_no_numbers() -> None:
    """Check columns and structures beside a run that is finished: they were overturned, or had the peaks of lanes."""
    time = np.arange(0.0, 2.0, 0.01)
    motion = Motion(time, 6.0 * np.sin(2.0 * math.pi * time), 0.0 * time, float(time[-1]))
    beds = phocas(1e-3)
    for model, peak in ((beds, "peak_top_ux"), (beds.in_space(), "peak_u")):
        keep = (peak, "verdict", "overturn_time", "fallen", "steps", "path")
        table = simulate_many(model, [motion.scaled(0.2), late(motion)], keep=keep, settle=1.0)
        assert (table.stats["lanes"], list(table.stats["failures"])) == (1, [1])
        assert np.isfinite(table[peak][0]).all()
        assert np.isnan(table[peak][1]).all()
        assert math.isnan(table["overturn_time"][1])
        assert [table[name][1] for name in ("verdict", "fallen", "steps", "path")] == ["undecided", 0, 0, "scalar"]


def test_doubtful_runs_are_counted_alike_by_any_number_of_threads(monkeypatch: pytest.MonkeyPatch) -> None:
    """Check chunks of one run and of all: a model counted once for each chunk, and its rest in the first alone."""
    slab = {"name": "slab", "on": "base", "at": [0.0, 0.0], "width": 1.0, "depth": 1.0, "height": 0.5}
    law = {"stiffness": 2e7, "damping": 0.05}  # s; 2.5 of critical, which follows from the rest
    doubtful = Structure.from_dict({"name": "slab", "joints": law, "block": [{**slab, "density": 2500.0}]})
    other = Structure.from_dict({**doubtful.to_dict(), "joints": {**law, "damping": 1e-3}})
    found = []
    for most in (1, 1000):
        monkeypatch.setattr(Pace, "enough", lambda self, runs, weight, most=most: runs >= most)
        with pytest.warns(InputWarning, match="of critical damping"):
            table = simulate_many([other, doubtful, doubtful, other], Motion.harmonic(0.1, 2.0, 0.1), threads=2)
        found.append(table.stats["doubtful_columns"])
    assert found == [2, 2]


def test_numbers_of_numpy_are_numbers() -> None:
    motion = Motion.harmonic(0.01 * G, 2.0, 2.0)
    durations: tuple[Any, ...] = (np.int64(1), np.float32(1.0))
    for duration in durations:
        assert simulate_many(phocas(1e-3), motion, duration=duration)["verdict"].tolist() == ["standing"]
