"""Command line: run the cases, print what they say, write numbers and pictures."""

from __future__ import annotations

import argparse
import json
import math
import sys
import time as clock
import warnings
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from multiblock import InputError, InputWarning

from .case import AbsentError, Case, Outcome
from .cases import CASES
from .pictures import save
from .rims import WHOLE

FOLDER = Path(__file__).parent / "results"


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the requested cases; 0, or 2 if data cannot be read."""
    options = _parser().parse_args(arguments)
    if options.list:
        for case in CASES:
            print(f"{case.name:14s} {case.title}\n{'':14s} fitted: {case.fitted}\n{'':14s} predicted: {case.predicted}")
        return 0
    if options.data is not None and not options.data.is_dir():
        print(f"--data {options.data}: must be a folder", file=sys.stderr)
        return 2
    options.output_folder.mkdir(parents=True, exist_ok=True)
    wanted = [case for case in CASES if not options.only or case.name in options.only]
    for case in wanted:
        try:
            if options.rim and not case.takes_rims:
                print(f"--- {case.name}: skipped: has no faces that could touch in a rim", flush=True)
                continue
            run(case, options.data, options.output_folder, options.rim)
        except AbsentError as absent:
            print(f"--- {case.name}: skipped: {absent}", flush=True)
        except InputError as wrong:
            print(f"{case.name}: {wrong}", file=sys.stderr)
            return 2
    return 0


def run(case: Case, data: Path | None, folder: Path, rims: Sequence[float] = ()) -> None:
    """Run one case: its lines printed, its numbers and its picture written to the folder."""
    print(f"--- {case.name}: {case.title}", flush=True)
    begin, begin_cpu = clock.perf_counter(), clock.process_time()
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", InputWarning)  # models of tests have odd masses and dampings on purpose
        outcome = case.answer(data, rims)
    seconds, cpu = clock.perf_counter() - begin, clock.process_time() - begin_cpu
    lines = [*outcome.lines, f"fitted: {case.fitted}", f"{seconds:.0f} s of the clock, {cpu:.0f} s of the processor"]
    print("\n".join(lines), flush=True)
    written = record(case, outcome, seconds, cpu)
    (folder / f"{case.name}.json").write_text(json.dumps(written, indent=1, allow_nan=False) + "\n", encoding="utf-8")
    if outcome.figure is not None:
        save(outcome.figure, folder / f"validation-{case.name}.png", f"Fitted: {case.fitted}")


def record(case: Case, outcome: Outcome, seconds: float, cpu: float) -> dict[str, Any]:
    """Return the results of a case for JSON: NaN becomes None."""
    return {
        "case": case.name,
        "title": case.title,
        "source": case.source,
        "model": case.model,
        "fitted": case.fitted,
        "predicted": case.predicted,
        "seconds": round(seconds, 1),
        "processor_seconds": round(cpu, 1),
        "lines": list(outcome.lines),
        "numbers": plain(outcome.numbers),
    }


def plain(value: Any) -> Any:
    """Return the value in the types of JSON, None for what is not finite."""
    if isinstance(value, dict):
        return {str(key): plain(item) for key, item in value.items()}
    if isinstance(value, np.ndarray | np.generic):
        return plain(value.tolist())
    if isinstance(value, list | tuple):
        return [plain(item) for item in value]
    return None if isinstance(value, float) and not np.isfinite(value) else value


def _share(text: str) -> float:
    try:
        share = float(text)
    except ValueError:
        share = math.nan
    if not 1e-3 <= share <= WHOLE:
        raise argparse.ArgumentTypeError(f"{text!r}: must be a part of the width, 0.001 to {WHOLE}")
    return share


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="python -m validation", description=__doc__)
    parser.add_argument("--list", action="store_true", help="name the cases")
    parser.add_argument(
        "--only", action="append", choices=[case.name for case in CASES], help="a case; may be repeated"
    )
    parser.add_argument("--data", type=Path, help="folder of data that you have fetched; without it cases are skipped")
    parser.add_argument(
        "--rim",
        action="append",
        type=_share,
        default=[],
        metavar="SHARE",
        help="also faces that touch in a rim of this part of their width, 0.001 to 0.5 (all of it), damped critically "
        "at the edge; may be repeated; of " + ", ".join(case.name for case in CASES if case.takes_rims),
    )
    parser.add_argument("--output-folder", type=Path, default=FOLDER, help="default: %(default)s")
    return parser
