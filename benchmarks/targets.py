"""Targets beside the measured values; only arithmetic on the results."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

from . import executors

IN_CONTACT_SPEED_UP = 10.0  # over the best general compiled integrator at equal error
ROCKING_SPEED_UP = 3.0
TIMED_ERROR = 1e-3  # of the peak
TIMED_SECONDS = 1.5e-3
OPENSEES_SPEED_UP = 200.0
EVALUATION_RATIO = 1.5  # to the same arithmetic in C
ROUND_RATIO = 3.0
RECURSION_RATIO = 0.75  # to the earlier recursion
LANES_RATIO = {"AVX-512": 6.0, "AVX2": 5.0, "SSE2": 2.5}  # of one evaluation alone to one in lanes, by instructions
GROWTH = 1.3  # of the cost per block from 10 to 200 blocks
RATIO_RANGE = (0.01, 10.0)  # observed error over requested tolerance
FAR_OFF = 100.0
ENERGY_DRIFT = 1e-6  # relative, over ENERGY_PERIODS of undamped elastic motion
ENERGY_PERIODS = 1_000_000
MANY_SPEED_UP = 10.0  # of many rocking runs over runs made alone, a core
MANY_OPENSEES_SPEED_UP = 100.0
SLIDING_SPEED_UP = 3.0  # of many sliding runs over runs made alone, a core
CORES_SPEED_UP = 1.9  # by two
BOUND_PART = 0.95
IDA_SPEED_UP = 12.0  # over runs made alone, a core
FIGURE_SECONDS = 5.0
PAPER_SPEED_UP = 3.0
MEGABYTES = 300.0
PROCESSES_PART = 0.9  # of the throughput of threads
REFERENCE_MARGIN = 10.0  # a tolerance is judged only if it is this many times the difference of the references


@dataclass(frozen=True)
class Target:
    """One line of the table; `passed` is None where nothing was measured."""

    number: str
    aim: str
    measured: str
    passed: bool | None


Results = dict[str, Any]


def targets(results: Results) -> list[Target]:
    """Return all targets, in order."""
    rows = speed(results) + forced_run(results) + evaluation(results) + scaling(results)
    return rows + tolerance_met(results) + verdict(results) + energy(results) + studies(results)


def _unmeasured(number: str, aim: str, reason: str = "not measured") -> Target:
    return Target(number, aim, reason, None)


def speed(results: Results) -> list[Target]:
    """Return target 1: speed at equal error."""
    contact: list[Any] = []
    rocking: list[Any] = []
    for scene in results.get("work-precision", {}).get("scenes", []):
        if "failure" in scene:
            continue
        group = contact if scene["regimes"]["full_contact"] >= 1.0 else rocking
        for row in scene["equal_error"]:
            if row["best"] is None:
                continue  # no competitor reaches it
            group.append((row["speed_up"] or 0.0, f"{scene['title']} at {row['error']:.0e}"))
    rows = []
    for number, aim, group, least in (
        ("1a", f"all joints in contact: at least {IN_CONTACT_SPEED_UP:g}x", contact, IN_CONTACT_SPEED_UP),
        (
            "1b",
            f"rocking: at least {ROCKING_SPEED_UP:g}x the best general compiled integrator",
            rocking,
            ROCKING_SPEED_UP,
        ),
        ("1c", "never slower in any scene", contact + rocking, 1.0),
    ):
        if not group:
            rows.append(_unmeasured(number, aim))
            continue
        lowest, where = min(group)
        reached = sum(value >= least for value, _ in group)
        text = f"{reached} of {len(group)} (scene, error) reach {least:g}x; least {lowest:.2f}x: {where}"
        rows.append(Target(number, aim, text, lowest >= least))
    return rows


def fastest_auto(results: Results) -> dict[str, Any] | None:
    """Return the fastest run of `auto` on damped Phocas at 0.05 g 2 Hz whose error is at most TIMED_ERROR."""
    for scene in results.get("work-precision", {}).get("scenes", []):
        if scene["title"] == "Phocas, 0.05 g 2 Hz" and "failure" not in scene:
            good = [p for p in scene["points"]["auto"] if p.get("error", math.inf) <= TIMED_ERROR]
            return min(good, key=lambda point: point["seconds"], default=None)
    return None


def forced_run(results: Results) -> list[Target]:
    """Return target 2: one run of 20 s."""
    aim = f"damped Phocas, 0.05 g 2 Hz, 20 s at an error of {TIMED_ERROR:g}: at most {1e3 * TIMED_SECONDS:g} ms"
    other = f"the same: {OPENSEES_SPEED_UP:g}x tuned OpenSees"
    best = fastest_auto(results)
    if best is None:
        return [_unmeasured("2a", aim), _unmeasured("2b", other)]
    text = f"{1e3 * best['seconds']:.3g} ms, error {best['error']:.1e}, {best['evaluations']} evaluations"
    rows = [Target("2a", aim, text, best["seconds"] <= TIMED_SECONDS)]
    opensees = results.get("opensees", {})
    tuned = [row for row in opensees.get("rows", []) if row["tuned"] and row["error"] is not None]
    if not tuned:
        return [*rows, _unmeasured("2b", other, opensees.get("absent", "not measured"))]
    as_good = [row for row in tuned if row["error"] <= TIMED_ERROR]
    if not as_good:
        least = min(row["error"] for row in tuned)
        return [*rows, _unmeasured("2b", other, f"no tuned scheme has this error: at least {least:.1e}")]
    rival = min(as_good, key=lambda row: row["seconds"])
    ratio = rival["seconds"] / best["seconds"]
    text = f"{ratio:.0f}x: {rival['scheme']} at {rival['step']:g} s needs {1e3 * rival['seconds']:.0f} ms"
    return [*rows, Target("2b", other, f"{text} for an error of {rival['error']:.1e}", ratio >= OPENSEES_SPEED_UP)]


def evaluation(results: Results) -> list[Target]:
    """Return target 3: one evaluation against C, against the earlier recursion, in lanes, and with circular joints."""
    part = results.get("evaluation", {})
    rows = part.get("rows", [])
    aim = f"one evaluation: at most {EVALUATION_RATIO:g}x the same arithmetic in C -O3"
    found = [_unmeasured("3a", aim, part.get("absent", "not measured"))]
    compared = [row for row in rows if "ratio" in row]
    if compared:
        text = "; ".join(f"{row['ratio']:.2f}x for {row['n']} blocks" for row in compared)
        found = [Target("3a", aim, text, max(row["ratio"] for row in compared) <= EVALUATION_RATIO)]
    aim = f"one evaluation, 3 blocks: at most {RECURSION_RATIO:g}x the earlier recursion"
    three = next((row for row in rows if row["n"] == 3 and "articulated_seconds" in row), None)
    if three is None:
        found.append(_unmeasured("3b", aim))
    else:
        ratio = three["seconds"] / three["articulated_seconds"]
        found.append(Target("3b", aim, f"{ratio:.2f}x", ratio <= RECURSION_RATIO))
    found += lanes(results)
    aim = f"one evaluation, 3 blocks on circles: at most {ROUND_RATIO:g}x that on rectangles"
    if "round_ratio" not in part:
        return [*found, _unmeasured("3f", aim)]
    ratio = part["round_ratio"]
    return [*found, Target("3f", aim, f"{ratio:.2f}x", ratio <= ROUND_RATIO)]


def lanes(results: Results) -> list[Target]:
    """Return targets 3c to 3e: an evaluation in lanes, per column, against one alone compiled for the same
    instructions.
    """
    alone = results.get("evaluation", {})
    measured = {alone.get("instructions", ""): alone.get("rows", [])} | results.get("lanes", {})
    found = []
    for number, (name, part_of) in zip("cde", LANES_RATIO.items(), strict=True):
        aim = f"one evaluation in lanes with {name}, 3 blocks: at most 1/{part_of:g} of one alone"
        row = next((row for row in measured.get(name, []) if row["n"] == 3 and "lanes_seconds" in row), None)
        if row is None:
            found.append(_unmeasured(f"3{number}", aim))
            continue
        ratio = row["seconds"] / row["lanes_seconds"]
        text = f"1/{ratio:.2f}: {1e9 * row['lanes_seconds']:.1f} ns a column"
        found.append(Target(f"3{number}", aim, text, ratio >= part_of))
    return found


def scaling(results: Results) -> list[Target]:
    """Return target 4: cost per block."""
    rows = {row["n"]: row for row in results.get("scaling", {}).get("rows", [])}
    found = []
    for number, key, what in (("4a", "evaluation", "one evaluation"), ("4b", "simulated", "a second of motion")):
        aim = f"cost per block of {what} from 10 to 200 blocks: grows by at most {GROWTH:g}x"
        if 10 not in rows or 200 not in rows:
            found.append(_unmeasured(number, aim))
            continue
        growth = rows[200][key] / rows[10][key]
        found.append(Target(number, aim, f"{growth:.2f}x", growth <= GROWTH))
    aim = "1000 blocks run"
    if 1000 not in rows:
        return [*found, _unmeasured("4c", aim)]
    row = rows[1000]
    text = (
        f"{1e6 * 1000 * row['evaluation']:.1f} us an evaluation, {row['short_run']:g} s in {row['short_seconds']:.2g} s"
    )
    if row["refused"]:
        text += f", but `Column` refuses: {row['refused']}"
    return [*found, Target("4c", aim, text, not row["refused"])]


def ratios(results: Results) -> list[tuple[str, float, float]]:
    """Return (scene, tolerance, observed error over tolerance) of `auto` where the references are close enough."""
    found = []
    for scene in results.get("work-precision", {}).get("scenes", []):
        for point in scene.get("points", {}).get("auto", []):
            value = point["value"]
            if 1e-9 * 0.99 <= value <= 1e-2 * 1.01 and value >= REFERENCE_MARGIN * scene["disagreement"]:
                found.append((scene["title"], value, point.get("error", math.inf) / value))
    return found


def tolerance_met(results: Results) -> list[Target]:
    """Return target 5: observed error against requested tolerance."""
    low, high = RATIO_RANGE
    aims = (f"observed error between {low:g} and {high:g} times the tolerance", f"nowhere {FAR_OFF:g} times off")
    found = ratios(results)
    if not found:
        return [_unmeasured("5a", aims[0]), _unmeasured("5b", aims[1])]
    inside = sum(low <= ratio <= high for _, _, ratio in found)
    most, least = max(found, key=lambda row: row[2]), min(found, key=lambda row: row[2])
    text = f"{inside} of {len(found)}; from {least[2]:.2g} ({least[0]} at {least[1]:.0e})"
    text += f" to {most[2]:.2g} ({most[0]} at {most[1]:.0e})"
    worst = f"largest {most[2]:.3g} ({most[0]} at {most[1]:.0e})"
    return [
        Target("5a", aims[0], text, inside == len(found)),
        Target("5b", aims[1], worst, most[2] < FAR_OFF),
    ]


def verdict(results: Results) -> list[Target]:
    """Return target 6: no false collapse, no false survival."""
    aim = "damped scenes: the verdict is right at every tolerance from 1e-3 on"
    judged = [row for row in results.get("verdicts", []) if "failure" not in row]
    if not judged:
        return [_unmeasured("6", aim)]
    wrong = [f"{row['scene']} at {', '.join(row['wrong'])}" for row in judged if row["wrong"]]
    fall = sum(row["overturns"] for row in judged)
    text = f"{len(judged)} scenes, {fall} of them overturning: " + ("; ".join(wrong) if wrong else "none wrong")
    return [Target("6", aim, text, not wrong)]


def energy(results: Results) -> list[Target]:
    """Return target 7: undamped elastic motion keeps its energy."""
    aim = f"undamped elastic motion keeps its energy to {ENERGY_DRIFT:g} over {ENERGY_PERIODS:.0e} periods"
    rows = results.get("energy", [])
    if not rows:
        return [_unmeasured("7", aim)]
    worst = max(rows, key=lambda row: abs(row["drift"]))
    text = f"at most {abs(worst['drift']):.1e} over {worst['periods']:.0e} periods ({worst['n']} blocks)"
    long_enough = all(row["periods"] >= ENERGY_PERIODS for row in rows)
    return [Target("7", aim, text, abs(worst["drift"]) <= ENERGY_DRIFT if long_enough else None)]


def studies(results: Results) -> list[Target]:
    """Return target 8: many runs."""
    part = results.get("studies", {})
    found: dict[str, float] = {}
    for row in part.get("throughput", []):
        scene = row["scene"]
        found["8j" if "sliding" in scene else "8a" if "rocking" in scene else "8d"] = row["ratio"]
    if "ratio" in part.get("opensees", {}):
        found["8b"] = part["opensees"]["ratio"]
    if "cores" in part:
        gains = {name: of["clock"] for name, of in part["cores"].items()}
        found["8c"] = gains["Phocas"]
        found["8l"] = min(gains["Phocas"], gains["fragility"]) / gains["arithmetic"]
    if "ida" in part:
        found["8e"] = part["ida"]["simulate_loose"] / part["ida"]["many_loose"]
    if "figure" in part:
        found["8f"] = part["figure"]["seconds"]
        found["8g"] = part["figure"]["paper"] / part["figure"]["paper_many"]
    if "memory" in part:
        found["8h"] = part["memory"]["megabytes"]
    apart = results.get("executors", {})
    if apart and "absent" not in apart:
        for number, way in (("8i", "processes"), ("8k", "dask")):
            found[number] = min(executors.parts(scene, way)["clock"] for scene in apart.values())
    absent = {"8b": part.get("opensees", {}), "8i": apart, "8k": apart}
    aims = {
        "8a": (
            f"damped Phocas rocking, many runs at an error of 1e-3: {MANY_SPEED_UP:g}x runs alone",
            MANY_SPEED_UP,
        ),
        "8b": (f"the same: {MANY_OPENSEES_SPEED_UP:g}x tuned OpenSees", MANY_OPENSEES_SPEED_UP),
        "8c": (f"the same by two threads: {CORES_SPEED_UP:g}x one", CORES_SPEED_UP),
        "8l": (f"Phocas and a study of fragility: {BOUND_PART:g} of what arithmetic gains by two threads", BOUND_PART),
        "8d": ("all joints in contact: no slower than runs made alone", 1.0),
        "8e": (
            f"six drums, five records, 20 intensities at a tolerance of 1e-3: {IDA_SPEED_UP:g}x those made alone",
            IDA_SPEED_UP,
        ),
        "8f": (f"Figure 3, 2 x 160 frequencies, exact model: at most {FIGURE_SECONDS:g} s", FIGURE_SECONDS),
        "8g": (f"the paper's scheme: a run {PAPER_SPEED_UP:g}x as fast", PAPER_SPEED_UP),
        "8h": (f"10^6 runs: at most {MEGABYTES:g} MB", MEGABYTES),
        "8i": (f"processes: {PROCESSES_PART:g} of the throughput of threads", PROCESSES_PART),
        "8k": (f"Dask: {PROCESSES_PART:g} of the throughput of threads", PROCESSES_PART),
        "8j": (f"rocking and sliding, at an error of 1e-3: {SLIDING_SPEED_UP:g}x those made alone", SLIDING_SPEED_UP),
    }
    rows = []
    for number, (aim, limit) in aims.items():
        if number not in found:
            rows.append(_unmeasured(number, aim, absent.get(number, {}).get("absent", "not measured")))
            continue
        value = found[number]
        at_most = number in ("8f", "8h")
        rows.append(Target(number, aim, f"{value:.3g}", value <= limit if at_most else value >= limit))
    return rows
