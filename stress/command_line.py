"""The command line: `python -m stress stability|damped|scheme|fuzz|states|faults|determinism|bounds|report`.

    python -m stress stability --seed 1 --cases 500
    python -m stress fuzz --seed 1 --cases 2000 --fmu column.fmu
    python -m stress states --seed 1 --cases 30000
    python -m stress bounds --seed 1 --cases 300
    python -m stress report

Every part adds its findings to a file of lines (JSON) in --output-folder; `report` writes report.md from all that
is there. So a long campaign is run in pieces, with --first or another --seed. Exit code 1 if anything failed.
"""

from __future__ import annotations

import argparse
import json
import shlex
import sys
import tempfile
from collections.abc import Iterator, Sequence
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from benchmarks import damped_columns

from . import bounds, changed_states, determinism, faults, fuzz_files, fuzz_fmu, report, scenes, scheme, stability

PARTS = ("stability", "damped", "scheme", "fuzz", "states", "faults", "determinism", "bounds")
SHORT = {"stability": 25, "damped": 2, "fuzz": 300, "states": 1000, "faults": 2, "determinism": 10, "bounds": 5}
USUAL = {"stability": 200, "damped": 50, "fuzz": 2000, "states": 30000, "faults": 20, "determinism": 100, "bounds": 300}
SHORT_BLOCKS = 10
PER_ROUND = 250  # examples of one seeded search


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; returns the exit code."""
    options = _parser().parse_args(arguments)
    folder: Path = options.output_folder
    if options.part == "report":
        try:
            print(report.write(folder))
        except FileNotFoundError as error:
            print(f"python -m stress: {error}", file=sys.stderr)
            return 2
        return 0
    folder.mkdir(parents=True, exist_ok=True)
    said = shlex.join(["python", "-m", "stress", *(sys.argv[1:] if arguments is None else arguments)])
    failures = 0
    with open(folder / f"{options.part}.jsonl", "a", encoding="utf-8") as file:
        for found in _findings(options):
            found |= {"command": said, "date": datetime.now(UTC).strftime("%Y-%m-%d")}
            print(json.dumps(found), file=file, flush=True)
            failures += len(found.get("failures", ()))
            for failure in found.get("failures", ()):
                print(f"{options.part} {found.get('number', found.get('name', ''))}: {failure}", flush=True)
    print(f"{options.part}: {failures} failures")
    return 1 if failures else 0


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m stress", description="Stability campaign of solver and FMU.")
    parser.add_argument("part", choices=[*PARTS, "report"])
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--cases", type=int, help=f"how many (default: {USUAL}; --short: {SHORT})")
    parser.add_argument(
        "--first", type=int, default=0, help="number of the first case of stability, damped, states and bounds"
    )
    parser.add_argument("--short", action="store_true", help="as continuous integration runs it")
    parser.add_argument("--patience", type=int, default=20, metavar="S", help="processor time of one case")
    parser.add_argument("--fmu", type=Path, metavar="FILE", help="another FMU for fuzz and states")
    parser.add_argument("--only", choices=[*fuzz_files.KINDS, "fmu", *changed_states.SOURCES, *scenes.KINDS])
    parser.add_argument("--output-folder", type=Path, default=Path("results") / "stress")
    return parser


def _findings(options: argparse.Namespace) -> Iterator[dict[str, Any]]:
    part, number = options.part, options.seed
    count = options.cases or (SHORT if options.short else USUAL).get(part, 0)
    if part == "stability":
        blocks = SHORT_BLOCKS if options.short else stability.MOST_BLOCKS
        yield from stability.campaign(number, options.first, count, blocks, options.patience)
    elif part == "damped":
        yield from _damped(number, range(options.first, options.first + count), options.short)
    elif part == "scheme":
        yield scheme.run(options.short)
    elif part == "fuzz":
        yield from _fuzz(options, count)
    elif part == "states":
        yield from _states(options, count)
    elif part == "faults":
        yield from faults.run(number, count)
    elif part == "bounds":
        yield from bounds.run(number, options.first, count, options.only)
    else:
        results = determinism.run(number, count, not options.short)
        yield from ({"name": name} | found for name, found in results.items())


def _damped(seed: int, numbers: range, short: bool) -> Iterator[dict[str, Any]]:
    tolerances = damped_columns.QUICK_TOLERANCES if short else damped_columns.TOLERANCES
    for number in numbers:
        found = damped_columns.measure(damped_columns.drawn(seed, number), tolerances)
        judged = {"tried": len(tolerances), "failures": damped_columns.failures(found)}
        yield {"name": "random columns under records", "seed": seed, "number": number} | judged | {"found": found}


def _states(options: argparse.Namespace, count: int) -> Iterator[dict[str, Any]]:
    if options.fmu is None:
        yield from changed_states.campaign(options.seed, options.first, count, options.only)
        return
    found = changed_states.judged(options.fmu.resolve(), options.seed, options.first, count)
    yield {"name": options.fmu.name, "seed": options.seed} | found


def _fuzz(options: argparse.Namespace, count: int) -> Iterator[dict[str, Any]]:
    rounds = [(k, min(PER_ROUND, count - k)) for k in range(0, count, PER_ROUND)]
    for kind in fuzz_files.KINDS:
        if options.fmu is None and options.only in (None, kind):
            for begin, size in rounds:
                yield {"name": kind, "seed": options.seed + begin} | fuzz_files.fuzz(kind, options.seed + begin, size)
    if options.only not in (None, "fmu"):
        return
    with tempfile.TemporaryDirectory(prefix="stress_") as folder:
        fmu = options.fmu
        if fmu is None:
            fmu = Path(folder) / "column.fmu"
            code, _, err = faults.finish("build_fmu.py", faults.COLUMN, "-o", fmu)
            if code:
                yield {"name": "fmu", "failures": [err]}
                return
        for begin, size in rounds:
            found = fuzz_fmu.fuzz(fmu.resolve(), options.seed + begin, size)
            yield {"name": "fmu", "seed": options.seed + begin, "fmu": fmu.name} | found
