"""Command line: measure, and write results.json, report.md and the pictures."""

from __future__ import annotations

import argparse
import json
import math
import os
import sys
from collections.abc import Callable, Iterable, Iterator
from dataclasses import asdict
from pathlib import Path
from typing import Any

from . import (
    ablation,
    boundary,
    boundary_of_structures,
    damped_columns,
    energy,
    engines,
    evaluation,
    executors,
    falls,
    in_space,
    machine,
    neighbours,
    opensees,
    peers,
    plots,
    report,
    scaling,
    sliding,
    studies,
    trust,
    verdicts,
    work_precision,
)
from .competitors import MeasurementError, competitors
from .references import reference
from .scenes import Scene, burst, falling, forced, harmonic, scenes

Results = dict[str, Any]
Scenes = tuple[Scene, ...]
FOLDER = Path(__file__).parent / "results"
BUDGET, QUICK_BUDGET = 0.6, 0.2  # s of repeats of one point


def say(text: str) -> None:
    """Print the progress of the measurement."""
    print(text, flush=True)


def measure_work_precision(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure error against time in every scene."""
    rivals, missing = competitors(quick)
    results["absent"] |= missing
    rows: list[dict[str, Any]] = []
    results["work-precision"] = {"scenes": rows, "kinds": {rival.name: rival.kind for rival in rivals}}
    for scene in wanted:
        row: dict[str, Any] = {"title": scene.title, "duration": scene.duration}
        try:
            known = reference(scene)
        except MeasurementError as failure:
            rows.append(row | {"failure": str(failure)})
            say(f"{scene.title}: {failure}")
            continue
        row |= {
            "window": known.window,
            "peak": known.peak,
            "references": known.names,
            "disagreement": known.disagreement,
            "whole_disagreement": known.whole_disagreement,
            "regimes": known.regimes,
        }
        regimes = ", ".join(f"{name} {share:.1%}" for name, share in known.regimes.items())
        say(f"{scene.title}: {known.window:g} s, references differ by {known.disagreement:.1e} of the peak; {regimes}")
        row |= work_precision.measure(known, rivals, QUICK_BUDGET if quick else BUDGET)
        rows.append(row)
        for entry in row["equal_error"]:
            say("  " + described(entry))
        yield


def described(entry: dict[str, Any]) -> str:
    """Return one comparison at equal error in one line."""
    if entry["speed_up"] is None:
        return f"error {entry['error']:.0e}: not reached by {'any other' if entry['best'] is None else 'auto'}"
    auto, other = (
        f"{1e3 * entry[f'{subject}_seconds']:.3g} ms, {entry[f'{subject}_evaluations']:.0f} evaluations"
        for subject in ("auto", "best")
    )
    return f"error {entry['error']:.0e}: auto {auto}; {entry['best']} {other}: {entry['speed_up']:.2f}x"


def measure_opensees(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure OpenSees on Phocas under 0.05 g at 2 Hz."""
    runs = {"damped": forced(0.05, 2.0), "undamped": forced(0.05, 2.0, damping=0.0)}
    results["opensees"] = opensees.measure(runs)
    if "absent" in results["opensees"]:
        results["absent"]["OpenSees"] = results["opensees"]["absent"]
    yield


def measure_evaluation(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure one evaluation, alone and in lanes, against C and the earlier recursion."""
    results["evaluation"] = evaluation.measure(evaluation.SIZES[:2] if quick else evaluation.SIZES)
    if "absent" in results["evaluation"]:
        results["absent"]["evaluation in C"] = results["evaluation"]["absent"]
    yield


def measure_lanes(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure one evaluation in lanes by instruction set."""
    results["lanes"] = evaluation.measure_lanes(evaluation.SIZES[:1] if quick else evaluation.SIZES[:2])
    yield


def measure_scaling(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure the cost per block."""
    results["scaling"] = scaling.measure(quick)
    yield


def measure_verdicts(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Compare standing or falling at every tolerance, in the damped scenes; undecided and wrong near the boundary."""
    results["verdicts"] = []
    results.setdefault("boundary", [])
    for scene in (*wanted, falling()):
        if all(block.joint.damping > 0.0 for block in scene.column.blocks):
            results["verdicts"].append(verdicts.measure(scene))
            yield
    for row in boundary.measure(quick):
        results["boundary"].append(row)
        say(boundary.line_of(row))
        yield


def measure_verdicts_in_space(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure structures in space near the boundary: undecided and wrong verdicts."""
    for row in boundary_of_structures.measure(quick):
        results.setdefault("boundary", []).append(row)
        say(boundary.line_of(row))
        yield


def measure_damped_columns(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure the error of well-damped columns (tolerances), and how much the motion amplifies a small change."""
    results["damped-columns"] = []
    count = damped_columns.QUICK_CASES if quick else damped_columns.CASES
    random = (damped_columns.drawn(damped_columns.SEED, number) for number in range(count))
    for scene in (*damped_columns.fixed(), *random):
        tolerances = damped_columns.QUICK_TOLERANCES if quick else damped_columns.TOLERANCES
        found = damped_columns.measure(scene, tolerances)
        results["damped-columns"].append(found)
        say(damped_columns.summary(found))
        yield


def measure_sliding(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure error against evaluations where joints slide, compared with ever less regularized friction."""
    results["sliding"] = []
    for row in sliding.measured(quick):
        results["sliding"].append(row)
        say(sliding.summary(row))
        yield


def measure_ablation(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Time and error without each short cut."""
    results["ablation"] = []
    for scene in (*wanted, burst()):
        try:
            known = reference(scene)
        except MeasurementError as failure:
            say(f"{scene.title}: {failure}")
            continue
        results["ablation"] += ablation.measure(known, QUICK_BUDGET if quick else BUDGET)
        yield


def measure_energy(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure the energy of undamped elastic motion over 10^6 periods."""
    results["energy"] = []
    for row in energy.measure(quick):
        results["energy"].append(row)
        yield


def measure_studies(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure many runs: throughput, cores, a study, Figure 3, memory."""
    for found in studies.measure(quick):
        results["studies"] = found
        yield


def measure_executors(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure equal runs by threads, by processes and on Dask."""
    results["executors"] = executors.measure(quick)
    if "absent" in results["executors"]:
        results["absent"]["executors"] = results["executors"]["absent"]
    yield


def measure_trust(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Compare peaks with rows, pulses after their end, shares that fall near the edge."""
    for found in trust.measure(quick):
        results["trust"] = found
        yield


def _measured(part: str, tables: Iterable[in_space.Table], results: Results) -> Iterator[None]:
    """Keep the tables of a part as they come, and print them."""
    results[part] = []
    for found in tables:
        results[part].append(asdict(found))
        say(f"{found.title}\n" + report.table(found.head, found.rows))
        yield


def measure_space(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure structures in space: accuracy, cost, compilation."""
    return _measured("space", in_space.measure(quick), results)


def measure_neighbours(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure blocks that meet across a gap."""
    return _measured("neighbours", neighbours.measure(quick), results)


def measure_falls(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Measure convex bodies that are thrown at each other, and a colonnade that falls."""
    return _measured("falls", falls.measure(quick), results)


def measure_engines(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Compare structures in space with physics engines."""
    return _measured("engines", [engines.against_engines(quick)], results)


def measure_peers(wanted: Scenes, quick: bool, results: Results) -> Iterator[None]:
    """Compare rigid blocks by this solver, MuJoCo and LMGC90."""
    panels: dict[str, peers.Points] = {}
    for _ in _measured("peers", peers.measure(quick, panels), results):
        results["peers-points"] = dict(panels)
        yield


# each yields whenever there is something new to be written
PARTS: dict[str, Callable[[Scenes, bool, Results], Iterator[None]]] = {
    "work-precision": measure_work_precision,
    "opensees": measure_opensees,
    "evaluation": measure_evaluation,
    "lanes": measure_lanes,
    "scaling": measure_scaling,
    "verdicts": measure_verdicts,
    "verdicts-in-space": measure_verdicts_in_space,
    "damped-columns": measure_damped_columns,
    "sliding": measure_sliding,
    "ablation": measure_ablation,
    "energy": measure_energy,
    "studies": measure_studies,
    "executors": measure_executors,
    "trust": measure_trust,
    "space": measure_space,
    "engines": measure_engines,
    "neighbours": measure_neighbours,
    "falls": measure_falls,
    "peers": measure_peers,
}


def plain(value: Any) -> Any:
    """Return the value with None for NaN and infinity, which JSON cannot hold."""
    if isinstance(value, dict):
        return {key: plain(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value


def write(results: Results, folder: Path) -> None:
    """Write everything measured so far, as JSON and Markdown."""
    (folder / "results.json").write_text(json.dumps(plain(results), indent=1, allow_nan=False) + "\n")
    (folder / "report.md").write_text(report.report(results))


def draw(results: Results, folder: Path) -> None:
    """Draw the pictures."""
    drawn = [scene for scene in results.get("work-precision", {}).get("scenes", []) if "points" in scene]
    if drawn:
        plots.work_precision(drawn, folder / "work-precision.png")
        plots.work_precision(drawn, folder / "work-precision-evaluations.png", "evaluations")
        shown = [scene for scene in drawn if scene["title"] in plots.README_SCENES]
        if shown:
            plots.work_precision(shown, folder / "work-precision-two.png")
    if results.get("sliding"):
        plots.work_precision(results["sliding"], folder / "work-precision-sliding.png", "evaluations")
    if results.get("peers-points"):
        plots.peers(results["peers-points"], folder / "peers.png")
    if "scaling" in results:
        plots.scaling(results["scaling"]["rows"], folder / "scaling.png")


def silence_libraries() -> None:
    """Discard the output of compiled libraries (Fortran, OpenSees); Python's own output is kept."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for name in ("stdout", "stderr"):
        stream = getattr(sys, name)
        stream.flush()
        setattr(sys, name, os.fdopen(os.dup(stream.fileno()), "w"))
        os.dup2(nowhere, stream.fileno())


def main() -> None:
    """Run the requested measurements."""
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="few scenes and repeats: indicative only")
    parser.add_argument("--only", action="append", choices=PARTS, help="a part; may be given several times")
    parser.add_argument("--scene", action="append", help="scenes whose title holds this; may be given several times")
    parser.add_argument("--output-folder", type=Path, default=FOLDER, help="default: %(default)s")
    options = parser.parse_args()
    every, absent = scenes()
    wanted = harmonic() if options.quick else every
    if options.scene:
        wanted = tuple(scene for scene in every if any(part in scene.title for part in options.scene))
        if not wanted:
            parser.error(f"--scene: must be part of one of: {'; '.join(scene.title for scene in every)}")
    options.output_folder.mkdir(parents=True, exist_ok=True)
    silence_libraries()
    results: Results = {"machine": machine.describe(), "quick": options.quick, "absent": dict(absent)}
    for name in options.only or PARTS:
        say(f"--- {name}")
        for _ in PARTS[name](wanted, options.quick, results):
            write(results, options.output_folder)
    draw(results, options.output_folder)
    say(report.target_table(report.targets(results)))
    say(f"written: {options.output_folder}")
