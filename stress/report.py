"""The report of a campaign, from the findings of all parts: tables in Markdown."""

from __future__ import annotations

import json
import math
import re
from collections import Counter, defaultdict
from pathlib import Path
from typing import Any

from benchmarks import machine

from .stability import LIMITS

PARTS = ("stability", "damped", "scheme", "fuzz", "states", "faults", "determinism", "bounds")
NAME = "report.md"
Findings = list[dict[str, Any]]


def write(folder: Path) -> Path:
    """Write the report beside the findings. Raises FileNotFoundError if there are none."""
    found = {part: _read(folder / f"{part}.jsonl") for part in PARTS}
    if not any(found.values()):
        raise FileNotFoundError(f"{folder}: no findings of `python -m stress` in it")
    parts = ["# Stability: findings", _origin(found), _stability(found["stability"])]
    parts += [_plain("Damped columns", found["damped"]), _scheme(found["scheme"]), _fuzz(found["fuzz"])]
    parts.append(_plain("Changed states of FMUs", found["states"]))
    parts += [_plain("Faults", found["faults"]), _plain("Repeatability", found["determinism"])]
    parts.append(_plain("Bounds of rows", found["bounds"]))
    report = folder / NAME
    report.write_text("\n\n".join(part for part in parts if part) + "\n", encoding="utf-8")
    return report


def _read(path: Path) -> Findings:
    return [json.loads(line) for line in path.read_text(encoding="utf-8").splitlines()] if path.is_file() else []


def table(head: list[str], rows: list[list[str]]) -> str:
    """Return a table in Markdown."""
    lines = [head, ["---"] * len(head), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _origin(found: dict[str, Findings]) -> str:
    everything = [item for items in found.values() for item in items]
    dates = sorted({item["date"] for item in everything})
    commands = sorted({re.sub(r" --output-folder \S+", "", item["command"]) for item in everything})
    about = machine.describe()
    versions = ", ".join(f"{name} {about['versions'][name]}" for name in ("Python", "numpy", "numba"))
    lines = [f"Run {' to '.join(dict.fromkeys([dates[0], dates[-1]]))} on {about['cpu']}, {versions}:", "", "```sh"]
    return "\n".join([*lines, *commands, "```"])


def _stability(items: Findings) -> str:
    if not items:
        return ""
    kinds = Counter(item["kind"] for item in items)
    rows = []
    for kind, count in kinds.most_common():
        of = [item for item in items if item["kind"] == kind]
        rows.append(
            [
                kind,
                str(count),
                f"{min(i['n'] for i in of)} to {max(i['n'] for i in of)}",
                str(sum(bool(i.get("overturned")) for i in of)),
                str(sum(i.get("stats", {}).get("implicit", 0) > 0 for i in of)),
                str(sum(bool(i.get("slow")) for i in of)),
                str(sum(bool(i["failures"]) for i in of)),
            ]
        )
    head = ["base motion", "cases", "blocks", "overturned", "with implicit steps", "not finished", "failures"]
    figures: dict[str, list[tuple[float, str]]] = defaultdict(list)
    for item in items:
        for name, value in item["figures"].items():
            figures[name].append((value, f"{item['seed']}-{item['number']}"))
    worst = []
    for name, values in figures.items():
        if name in LIMITS:
            values.sort()
            above = sum(value > 1.0 for value, _ in values)
            worst.append(
                [
                    name,
                    str(len(values)),
                    f"{values[len(values) // 2][0]:.1g}",
                    str(above),
                    f"{values[-1][0]:.2g}",
                    values[-1][1],
                ]
            )
    moment = max(value for value, _ in figures["moment over N b/2"])
    windows = [value for value, _ in figures["window"]]
    whole = sum(value >= 1.0 for value in windows)
    differ = len(figures.get("verdicts differ", ()))
    failed = [f"- {i['seed']}-{i['number']} ({i['case']}): {'; '.join(i['failures'])}" for i in items if i["failures"]]
    slow = [f"- {i['seed']}-{i['number']} ({i['case']})" for i in items if i.get("slow")]
    text = [
        "## Columns and motions",
        f"{len(items)} cases (`draw(seed, number)` of `stress/cases.py` makes one again, `draw(seed, number, 10)` one "
        "of `--short`); pieces may have been ended before all the cases that were asked for.",
        table(head, rows),
        "In tolerances: of the largest energy so far, or of the peak so far times how much a change of stiffness and "
        "motion by one tolerance is amplified; differences as long as that is less than thirty times.",
        table(["figure", "cases", "median", "above 1", "worst", "case"], worst),
        f"Largest |M| / (N b/2): {moment:.15g}. Mirrored motions: mirrored to the last bit unless listed. Predictable "
        f"to the end: {whole} of {len(windows)}. Verdicts that differ between tolerances or communication steps, "
        f"beyond what can be predicted: {differ}.",
        "Failures:\n\n" + ("\n".join(failed) or "none"),
        "Not finished in the processor time allowed:\n\n" + ("\n".join(slow) or "none"),
    ]
    return "\n\n".join(text)


def _scheme(items: Findings) -> str:
    if not items:
        return ""
    latest = items[-1]
    text = ["## The paper's scheme"]
    blocks = sorted({row["n"] for row in latest["map"]})
    for damping in sorted({row["damping"] for row in latest["map"]}):
        rows = []
        for stiffness in sorted({row["stiffness"] for row in latest["map"]}):
            of = {r["n"]: r for r in latest["map"] if r["stiffness"] == stiffness and r["damping"] == damping}
            rows.append([f"{stiffness:.0e}", *(_step(of.get(n)) for n in blocks)])
        text.append(
            f"eta = {damping:g} s: limit in s by the highest mode; where a disturbance of 1e-7 of the settlement grows "
            "by 1000 in 200 steps, in parts of it; sweeps an evaluation at half of it."
        )
        text.append(table(["k, N/m3; blocks:", *map(str, blocks)], rows))
    refused = [bool(row["refused"]) for row in latest["map"] if "refused" in row]
    text.append(
        f"A step 0.1 % beyond the limit is refused with the limit in the message: {sum(refused)} of {len(refused)}."
    )
    if "sweeps" in latest:
        rows = [
            [
                f"{r['amplitude']:g} g {r['frequency']:g} Hz, {r['duration']:g} s",
                "one sweep" if math.isinf(r["tolerance"]) else f"{r['tolerance']:.0e}",
                f"{r['sweeps']:.2f}",
                f"{r['error']:.1e}",
            ]
            for r in latest["sweeps"]
        ]
        text.append("What stopping the sweeps earlier costs, undamped Phocas at 1e-4 s, of the peak of the top block:")
        text.append(table(["scene", "sweeps until the change is", "sweeps an evaluation", "error"], rows))
    return "\n\n".join(text)


def _step(row: dict[str, Any] | None) -> str:
    if row is None:
        return "-"
    if "failure" in row:
        return row["failure"] if "refused" in row["failure"] else "no rest"
    if row["found"] == 0.0:
        return f"{row['limit']:.2g}; rest unstable"
    found = "no growth" if math.isinf(row["found"]) else f"{row['found']:.3f}"
    return f"{row['limit']:.2g}; {found}; {row['sweeps']:.1f}"


def _fuzz(items: Findings) -> str:
    if not items:
        return ""
    rows = []
    for name in dict.fromkeys((item["name"], item.get("fmu", "")) for item in items):
        of = [item for item in items if (item["name"], item.get("fmu", "")) == name]
        inputs = sum(found["calls"] if "calls" in found else found.get("files", 0) for found in of)
        what = (
            f"{sum(i.get('sequences', 0) for i in of)} sequences of FMI calls, {name[1]}"
            if name[0] == "fmu"
            else name[0]
        )
        refused = str(sum(item["refused"] for item in of)) if all("refused" in item for item in of) else "-"
        rows.append([what, str(inputs), refused, str(len(of)), str(sum(len(item["failures"]) for item in of))])
    failed = [f"- {item['name']} (seed {item['seed']}): {failure}" for item in items for failure in item["failures"]]
    total = sum(int(row[1]) for row in rows)
    return "\n\n".join(
        [
            "## Hostile input",
            f"{total} inputs: files, and calls to the FMU.",
            table(["what", "inputs", "refused", "seeded searches", "failures"], rows),
            "Failures:\n\n" + ("\n".join(failed) or "none"),
        ]
    )


def _plain(title: str, items: Findings) -> str:
    if not items:
        return ""
    rows = []
    for name in dict.fromkeys(item["name"] for item in items):
        of = [item for item in items if item["name"] == name]
        largest = [item["largest difference"] for item in of if "largest difference" in item]
        found = "; ".join(dict.fromkeys(failure for item in of for failure in item["failures"])) or "none"
        if largest:
            found += f" (largest difference {max(largest):.1e} of the peak)" if max(largest) else " (the same bits)"
        rows.append([name, str(sum(item["tried"] for item in of)), found])
    return f"## {title}\n\n" + table(["what", "tried", "failures"], rows)
