"""The results as a Markdown report."""

from __future__ import annotations

import math
from typing import Any

from . import boundary, executors, sliding
from .targets import Target, ratios, targets

Results = dict[str, Any]
Rows = list[list[str]]
WAYS = ("simulate", "many")


def report(results: Results) -> str:
    """Return the whole report."""
    parts = [
        machine(results),
        target_table(targets(results)),
        scene_table(results),
        equal_error_table(results),
        opensees_table(results),
        evaluation_table(results),
        lanes_table(results),
        scaling_table(results),
        tolerance_table(results),
        verdict_table(results),
        boundary_list(results),
        damped_table(results),
        sliding_table(results),
        ablation_table(results),
        energy_table(results),
        studies_table(results),
        executors_table(results),
        trust_tables(results),
        space_tables(results),
        failures(results),
    ]
    return "\n\n".join(part for part in parts if part) + "\n"


def table(head: list[str], rows: Rows) -> str:
    """Return a Markdown table."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def milliseconds(seconds: float | None) -> str:
    """Time with three digits; a dash for None."""
    return "-" if seconds is None else f"{1e3 * seconds:.3g}"


def machine(results: Results) -> str:
    """Return machine, date and software."""
    info = results["machine"]
    versions = ", ".join(f"{name} {version}" for name, version in info["versions"].items())
    return (
        "# Benchmarks\n\n"
        f"{info['date']}, commit {info['commit']}, {info['cpu']} ({info['cores']} cores, one thread used), "
        f"{info['system']}. {versions}.\n\n"
        f"{'A quick run: indicative only. ' if results['quick'] else ''}"
        "Times are the shortest of warm runs, compilation apart. Errors are the largest over the whole predictable "
        "window and all blocks, in parts of the peak."
    )


def target_table(rows: list[Target]) -> str:
    """Tabulate the targets and measured values."""
    words = {True: "pass", False: "**fail**", None: "-"}
    return "## Targets\n\n" + table(
        ["", "aim", "measured", ""], [[row.number, row.aim, row.measured, words[row.passed]] for row in rows]
    )


def _scenes(results: Results) -> list[dict[str, Any]]:
    return [scene for scene in results.get("work-precision", {}).get("scenes", []) if "failure" not in scene]


def scene_table(results: Results) -> str:
    """Tabulate the windows, references and regimes."""
    scenes = _scenes(results)
    if not scenes:
        return ""
    rows = [
        [
            scene["title"],
            f"{scene['window']:.4g} of {scene['duration']:.4g}",
            f"{1e3 * scene['peak']:.5g}",
            f"{scene['disagreement']:.1e}",
            f"{scene['whole_disagreement']:.1e}",
            *(f"{scene['regimes'][key]:.1%}" for key in ("full_contact", "rocking", "flight")),
        ]
        for scene in scenes
    ]
    names = " and ".join(scenes[0]["references"])
    head = ["scene", "window, s", "peak, mm", "disagreement", "over the whole", "full contact", "rocking", "flight"]
    return (
        f"## Scenes\n\nReferences: {names}. The window ends where they differ by more than 1e-8 of the peak so far; "
        "the whole is the duration wanted, or until the column falls.\n\n" + table(head, rows)
    )


def equal_error_table(results: Results) -> str:
    """Tabulate the speed at equal error."""

    def times(factor: float | None) -> str:
        return "-" if factor is None else f"{factor:.2f}x"

    rows = [
        [
            scene["title"],
            f"{row['error']:.0e}",
            milliseconds(row["auto_seconds"]),
            milliseconds(row["ux_only_seconds"]),
            str(row["best"] or "none reaches it"),
            milliseconds(row["best_seconds"]),
            times(row["speed_up"]),
            times(row["ux_only_speed_up"]),
            *("-" if row[key] is None else f"{row[key]:.0f}" for key in ("auto_evaluations", "best_evaluations")),
        ]
        for scene in _scenes(results)
        for row in scene["equal_error"]
    ]
    if not rows:
        return ""
    head = ["scene", "error", "auto, ms", "with peaks of ux only, ms", "best other", "its time, ms"]
    head += ["auto is faster by", "with peaks of ux only by", "evaluations", "its"]
    return (
        "## Speed at equal error\n\n`auto` through `simulate` against the fastest general integrator that is given the "
        "same compiled equations. `auto` finds the peaks of all outputs, which no other does, or those of ux only "
        '(`without = ["peaks"]`). Between the measured points log time is linear in log error, along the lower '
        "envelope. Evaluations separate the method from the program.\n\n" + table(head, rows)
    )


def opensees_table(results: Results) -> str:
    """Tabulate OpenSees on the same column."""
    part = results.get("opensees", {})
    if "rows" not in part:
        return ""
    rows = [
        [
            row["column"],
            row["scheme"],
            f"{row['step']:g}",
            f"{1e3 * row['seconds']:.0f}",
            "-" if row["peak_3s"] is None else f"{1e3 * row['peak_3s']:.2f}",
            f"{1e3 * row['peak']:.2f}",
            f"{row['reached']:.4g} s",
            "-" if row["error"] is None else f"{row['error']:.1e}",
        ]
        for row in part["rows"]
    ]
    own = ", ".join(f"{name} {1e3 * peak:.2f} mm" for name, peak in part["own_peaks_3s"].items())
    head = ["column", "scheme", "step, s", "time, ms", "peak in 3 s, mm", "peak, mm", "converged until", "error"]
    return (
        "## OpenSees\n\nPhocas under 0.05 g at 2 Hz for 20 s: rigid elements, zero-length sections of "
        f"{part['fibres']} no-tension fibres. Peak in the first 3 s by `auto` at 1e-9: {own}. A peak of metres is a "
        "false collapse. The error includes that the dampers differ in law (`opensees.py`).\n\n" + table(head, rows)
    )


def evaluation_table(results: Results) -> str:
    """Tabulate one evaluation: the kernel alone and in lanes, the earlier recursion, C."""
    part = results.get("evaluation", {})
    if "rows" not in part:
        return ""

    def nanoseconds(row: Results, key: str) -> str:
        return f"{1e9 * row[key]:.{1 if row[key] < 1e-7 else 0}f}" if key in row else "-"

    def times(name: str, row: Results) -> list[str]:
        keys = ("seconds", "lanes_seconds", "articulated_seconds", "c_seconds")
        return [
            name,
            str(row["n"]),
            *(nanoseconds(row, key) for key in keys),
            f"{row['ratio']:.2f}" if "ratio" in row else "-",
            f"{row['difference']:.1e}" if "difference" in row else "-",
        ]

    rows = [times(part["instructions"], row) for row in part["rows"]]
    head = ["instructions", "blocks", "kernel, ns", "in lanes, ns a column", "earlier recursion, ns", "C, ns"]
    head += ["kernel to C", "largest difference of kernel and C"]
    return f"## One evaluation\n\n`evaluation.c`, compiled with `cc {part['flags']}`.\n\n" + table(head, rows)


def lanes_table(results: Results) -> str:
    """Tabulate one evaluation alone and in lanes, by instruction set."""
    if "lanes" not in results:
        return ""
    rows = [
        [name, str(row["n"]), f"{1e9 * row['seconds']:.1f}", f"{1e9 * row['lanes_seconds']:.1f}",
         f"{row['seconds'] / row['lanes_seconds']:.2f}"]
        for name, found in results["lanes"].items()
        for row in found
    ]  # fmt: skip
    head = ["instructions", "blocks", "alone, ns", "in lanes, ns a column", "alone to lanes"]
    return "## One evaluation in lanes\n\n" + table(head, rows)


def scaling_table(results: Results) -> str:
    """Tabulate the cost per block."""
    part = results.get("scaling", {})
    if not part:
        return ""
    rows = [
        [
            str(row["n"]),
            f"{1e9 * row['evaluation']:.1f}",
            f"{1e3 * row['simulated']:.3g}" if "simulated" in row else "-",
            f"{row['steps']:.0f}" if "steps" in row else "-",
            f"{row['evaluations']:.0f}" if "evaluations" in row else "-",
        ]
        for row in part["rows"]
    ]
    head = [
        "blocks",
        "an evaluation, ns per block",
        "a second of motion, ms per block",
        "steps per s",
        "evaluations per s",
    ]
    return "## Cost per block\n\n" + table(head, rows)


def tolerance_table(results: Results) -> str:
    """Tabulate the observed error over requested tolerance."""
    found = ratios(results)
    if not found:
        return ""
    values = sorted({value for _, value, _ in found}, reverse=True)
    values = [value for value in values if abs(math.log10(value) - round(math.log10(value))) < 1e-6]
    known = {(title, value): ratio for title, value, ratio in found}
    rows = [
        [title, *(f"{known[title, value]:.2g}" if (title, value) in known else "-" for value in values)]
        for title in dict.fromkeys(title for title, _, _ in found)
    ]
    return (
        "## Observed error over requested tolerance\n\nA dash where the references do not agree to a tenth of the "
        "tolerance. The targets count the tolerances between these as well.\n\n"
        + table(["scene", *(f"{value:.0e}" for value in values)], rows)
    )


def verdict_table(results: Results) -> str:
    """Tabulate the standing or falling."""

    def shown(value: Any) -> str:
        if isinstance(value, str):
            return value
        return "stands" if value is None or math.isnan(value) else f"{value:.3f} s"

    judged = [row for row in results.get("verdicts", []) if "failure" not in row]
    if not judged:
        return ""
    rows = [
        [row["scene"], f"{row['duration']:g}", *map(shown, row["reference_times"]), *map(shown, row["times"].values())]
        for row in judged
    ]
    head = ["scene", "duration, s", "first reference", "second", *judged[0]["times"]]
    return "## Overturning, by tolerance\n\n" + table(head, rows)


def boundary_list(results: Results) -> str:
    """Tabulate the verdicts near the boundary of overturning."""
    found = results.get("boundary", [])
    if not found:
        return ""
    return "## Verdicts near the boundary of overturning\n\n" + "\n".join(f"- {boundary.line_of(row)}" for row in found)


def damped_table(results: Results) -> str:
    """Tabulate the errors of well-damped columns."""
    found = results.get("damped-columns", [])
    if not found:
        return ""

    def shown(row: dict[str, Any], overturned: bool) -> str:
        if "failure" in row:
            return "gave up"
        return f"{row['error']:.2g}" + ("" if row["overturned"] == overturned else " wrong verdict")

    rows = [
        [
            item["scene"],
            "falls" if item["overturned"] else "stands",
            "-" if item["amplification"] is None else f"{item['amplification']:.3g}",
            *(shown(row, item["overturned"]) for row in item["rows"]),
        ]
        for item in found
    ]
    head = ["scene", "verdict", "amplification", *(f"{row['tolerance']:.0e}" for row in found[0]["rows"])]
    return (
        "## Well-damped columns\n\nError over tolerance, against a run at 1e-9 without implicit steps; beside it by "
        "how much the motion amplifies a small change of its data.\n\n" + table(head, rows)
    )


def sliding_table(results: Results) -> str:
    """Tabulate the errors where joints slide."""
    found = results.get("sliding", [])
    if not found:
        return ""
    rows: Rows = []
    for scene in found:
        points = sliding.of_table(scene)
        cells = [
            "gave up" if "failure" in point else f"{point['error'] / point['value']:.2g} ({point['evaluations']})"
            for point in points
        ]
        rows.append([scene["title"], str(scene["events"]), f"{scene['disagreement']:.1e}", *cells])
    values = [f"{point['value']:.0e}" for point in sliding.of_table(found[0])]
    head = ["scene", "events", "references differ by", *values]
    return (
        "## Joints that slide\n\nError over tolerance of `auto`, and evaluations, against friction that is regularized "
        "less and less; beside it by how much that and `auto` at 1e-11 differ.\n\n" + table(head, rows)
    )


def trust_tables(results: Results) -> str:
    """Tabulate the peaks, pulses and shares that fall."""
    found = results.get("trust")
    if not found:
        return ""
    parts = ["## Peaks, pulses, shares that fall"]
    head = ["scene", "one run", "evaluations of its check, times its own", "time of that", "time of an ensemble of 8"]
    kinds = ("evaluations", "check", "ensemble")
    rows = [
        [row["scene"], milliseconds(row["seconds"]), *(f"{row[kind]:.2f}" for kind in kinds)] for row in found["costs"]
    ]
    parts.append(table(head, rows))
    head = ["scene", "peaks at rows of 0.1 and 5 ms", "rows of 5 ms see of N, S, T", "evaluations more"]
    rows = [
        [
            row["scene"],
            "same" if row["same"] else "differ",
            ", ".join(f"{part:.2f}" for part in row["seen"].values()),
            f"{row['looks']:.1%}",
        ]
        for row in found["peaks"]
    ]
    parts.append(table(head, rows))
    rows = [
        [row["scene"], ", ".join(f"{count} {word}" for word, count in sorted(row["counts"].items()))]
        for row in found["pulses"]
    ]
    if rows:
        parts.append(table(["pulses", "outcomes"], rows))
    if found["shares"]:
        sizes = [row["size"] for row in found["shares"][0]["rows"]]
        rows = [[row["scene"], *map(_share, row["rows"])] for row in found["shares"]]
        parts.append(table(["motion x scale", *(f"{size} runs" for size in sizes)], rows))
    return "\n\n".join(parts)


def space_tables(results: Results) -> str:
    """Tabulate structures in space."""
    tables = [table for part in ("space", "engines", "neighbours", "falls", "peers") for table in results.get(part, [])]
    return "\n\n".join(f"## {of['title']}\n\n{table(of['head'], of['rows'])}" for of in tables)


def _share(row: dict[str, Any]) -> str:
    low, high = row["bounds"]
    return f"{row['share']:.3f} ({low:.2f} to {high:.2f}{'' if row['contains'] else ', does not contain it'})"


def ablation_table(results: Results) -> str:
    """Time and error without each short cut."""
    rows = [
        [
            row["scene"],
            row["without"],
            *(
                [row["failure"], "", ""]
                if "failure" in row
                else [milliseconds(row["seconds"]), f"{row['error']:.1e}", str(row["evaluations"])]
            ),
        ]
        for row in results.get("ablation", [])
    ]
    return "## Without\n\n" + table(["scene", "without", "time, ms", "error", "evaluations"], rows) if rows else ""


def energy_table(results: Results) -> str:
    """Tabulate the long-term energy."""
    rows = [
        [
            str(row["n"]),
            f"{row['part']:g}",
            f"{row['periods']:g}",
            f"{row['drift']:.1e}",
            f"{row['resolution']:.0e}",
            f"{row['elastic_steps']} of {row['steps']}",
        ]
        for row in results.get("energy", [])
    ]
    head = ["blocks", "part of the opening rotation", "periods", "relative drift", "rounding", "modal steps"]
    return "## Energy of undamped elastic motion\n\n" + table(head, rows) if rows else ""


def studies_table(results: Results) -> str:
    """Tabulate many runs."""
    part = results.get("studies", {})
    if "throughput" not in part:
        return ""
    rows = [
        [
            row["scene"],
            str(row["runs"]),
            *(f"{row[way]['throughput']:.0f} at {row[way]['tolerance']:g} ({row[way]['error']:.1e})" for way in WAYS),
            f"{row['ratio']:.1f}",
        ]
        for row in part["throughput"]
    ]
    head = ["scene", "runs", "`simulate`", "`simulate_many`", "ratio"]
    lines = [
        "## Many runs",
        "Seconds of motion of a column in a second of one core, at the loosest tolerance whose largest error of a peak "
        "(in brackets) is within 1e-3.",
        table(head, rows),
    ]
    if "cores" in part:
        cores = part["cores"]
        gains = ", ".join(f"{of['clock']:.2f} ({of['processor']:.2f}) of {name}" for name, of in cores.items())
        lines.append(
            f"Two threads do more than one by these factors: {gains}; in brackets the seconds of the processor that "
            "one thread spends, over those that two spend. Plain arithmetic shows what the machine can give."
        )
    if "run" in part:
        run = part["run"]
        lines.append(
            f"A run of the fragility study, {run['runs']} in one thread: {run['kernels']:.2f} ms of the processor in "
            f"kernels, {run['python']:.2f} ms in Python."
        )
    if "ida" in part:
        ida = part["ida"]
        lines.append(
            f"Six drums, five records, {ida['runs']} runs, seconds of one core: {ida['simulate']:.3g} by `simulate`, "
            f"{ida['many']:.3g} by `simulate_many`; at a tolerance of 1e-3 {ida['simulate_loose']:.3g} and "
            f"{ida['many_loose']:.3g}."
        )
    if "figure" in part:
        figure = part["figure"]
        lines.append(
            f"Figure 3, {figure['runs']} runs of the exact model: {figure['seconds']:.3g} s. By the paper's scheme a "
            f"run takes {1e3 * figure['paper'] / figure['paper_runs']:.0f} ms by `simulate`, "
            f"{1e3 * figure['paper_many'] / figure['paper_runs']:.0f} ms by `simulate_many`."
        )
    if "memory" in part:
        memory = part["memory"]
        compiling = f"; {memory['compiling']:.0f} MB where a few compile the kernels" if "compiling" in memory else ""
        lines.append(f"{memory['runs']} runs: {memory['megabytes']:.0f} MB with kernels compiled before{compiling}.")
    return "\n\n".join(lines)


def executors_table(results: Results) -> str:
    """Tabulate threads, processes and Dask."""
    part = results.get("executors", {})
    if not part or "absent" in part:
        return ""
    rows = []
    for scene, found in part.items():
        for way, of in found.items():
            shares = executors.parts(found, way)
            rows.append(
                [
                    scene,
                    way,
                    f"{of['throughput']:.0f}",
                    f"{of['steady']:.0f}",
                    f"{of['own']:.3f} + {of['workers']:.3f}",
                    *(f"{share:.2f}" for share in shares.values()),
                ]
            )
    head = ["scene", "by", "runs a second", "in the middle", "s of the processor for 1000 runs: this process + workers"]
    head += ["part of the threads' throughput", "in the middle", "by the processor"]
    return (
        f"## Threads, processes, Dask\n\nTwo of each, in turn, {executors.ROUNDS} rounds of each. In the middle: from "
        "20 to 80 % of the runs, between which all workers have whole chunks. This process sends the runs out, and has "
        "the scheduler of Dask.\n\n" + table(head, rows)
    )


def failures(results: Results) -> str:
    """Return competitors not available, and failures."""
    lines = [f"- {name}: {reason}" for name, reason in results.get("absent", {}).items()]
    for scene in results.get("work-precision", {}).get("scenes", []):
        if "failure" in scene:
            lines.append(f"- {scene['title']}: {scene['failure']}")
        for name, points in scene.get("points", {}).items():
            reasons: dict[str, list[str]] = {}
            for point in points:
                if "failure" in point:
                    reasons.setdefault(point["failure"], []).append(f"{point['value']:.1e}")
            lines += [f"- {scene['title']}, {name} at {', '.join(at)}: {why}" for why, at in reasons.items()]
    lines += [f"- {row['scene']}, verdict: {row['failure']}" for row in results.get("verdicts", []) if "failure" in row]
    return "## Not available, and failing\n\n" + "\n".join(lines) if lines else ""
