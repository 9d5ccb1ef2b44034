"""The coupled systems in the hosts of this machine, as a table: `python tests/masters/coupled_hosts.py`.

    --folder FOLDER   where build.py --native wrote the FMUs (default: it builds them in a temporary one)
    --host NAME       the rows of one host alone; may be repeated
    --stop SECONDS    of the waves of build.py (default: 1.5)

The systems are those of examples/coupling, native. A row is a host, what the column stands on, and how both exchange:
by state, or by acceleration, the old way. Its numbers are the largest error of the top, in parts of its peak, against
the system solved as one; the order from 1 to 0.5 ms; and the longest of 10, 5, 2 ... ms up to which it is stable,
with an error below 5 %. Where a host is not there, the row says why.
"""

from __future__ import annotations

import argparse
import math
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from support.inside import systems
from support.processes import (
    EXAMPLE,
    AbsentError,
    ComplaintError,
    called,
    found,
    needs,
    needs_ecos,
    run,
    versioned,
    with_example,
)

STEPS = (10e-3, 5e-3, 2e-3, 1e-3, 0.5e-3)  # s, from the longest; the samples of the ground are at some of each
SHOWN = STEPS[2:]
STABLE = 0.05  # error below which a run is no diverging one
PARTNERS = {"isolator": "linear isolators", "soil": "soil, 250 m/s"}
STATE, ACCELERATION = "state", "acceleration"


class Host(NamedTuple):
    """One way to run a system: rows (top, partner's x) after each of `steps` steps of `step` s."""

    name: str
    exchange: str
    rows: Callable[[Path, str, int, float], Any]
    package: str | None = None


def inside(way: Callable[..., Any], needed: str = "", **more: Any) -> Callable[[Path, str, int, float], Any]:
    """Return a way of support/inside/systems.py, in a process of its own."""

    def rows(folder: Path, partner: str, steps: int, step: float) -> Any:
        if needed == "ecospy":
            needs_ecos()
        elif needed:
            needs(needed)
        return called(way, folder, partner, steps, step=step, **more)

    return rows


def in_c(folder: Path, partner: str, steps: int, step: float) -> Any:
    """Run examples/coupling/master.c, compiled here."""
    host = folder / "master"
    if not host.exists():
        run(found("cc"), "-O1", "-o", host, EXAMPLE / "master.c", "-ldl")
    text = run(host, folder / "in_c" / f"{systems.NAMES[partner]}.txt", step, steps * step)
    rows = [line for line in text.splitlines() if line[:1].isdigit()]  # what FMUs log stands between
    return [[float(word) for word in line.split(",")[1:]] for line in rows[1:]]


HOSTS = (
    Host("master.py, FMPy", STATE, inside(systems.strict_master), "fmpy"),
    Host("steps in parallel, FMPy", STATE, inside(systems.parallel), "fmpy"),
    Host("all set after each step, FMPy", STATE, inside(systems.one_pass), "fmpy"),
    Host("FMPy, simulate_ssp", STATE, inside(systems.fmpy, seen=systems.SEEN), "fmpy"),
    Host("libcosim", STATE, inside(systems.libcosim, "libcosimpy"), "libcosimpy"),
    Host("ecos", STATE, inside(systems.ecos, "ecospy"), "ecospy"),
    Host("master.c", STATE, in_c),
    Host("master.py, in order of dependencies", ACCELERATION, inside(systems.sorted_master), "fmpy"),
    Host("all exchanged once a step, FMPy", ACCELERATION, inside(systems.by_acceleration), "fmpy"),
)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; returns the exit code."""
    parser = argparse.ArgumentParser(description="Run the coupled systems in the hosts of this machine.")
    parser.add_argument("--folder", type=Path, help="where build.py --native wrote the FMUs")
    parser.add_argument("--host", action="append", choices=[host.name for host in HOSTS], help="may be repeated")
    parser.add_argument("--stop", type=float, default=1.5, help="s (default: %(default)s)")
    options = parser.parse_args(arguments)
    with tempfile.TemporaryDirectory() as temporary:
        built = (options.folder or Path(temporary) / "built").resolve()
        if not built.exists():
            words = ("--native", "--platforms", "linux64", "-o", built)
            run(sys.executable, EXAMPLE / "build.py", *words, environment=with_example())
        folders = {step: Path(temporary) / f"{step:g}" for step in STEPS}
        for step, folder in folders.items():
            called(systems.at_step, built, folder, step)
        head = "".join(f" {1e3 * step:g} ms |" for step in SHOWN)
        print(f"| host | on | by |{head} order | up to |\n|{'---|' * (5 + len(SHOWN))}")
        for partner, on in PARTNERS.items():
            truth = np.array(called(systems.as_one, built, partner, round(options.stop / systems.STEP)))[:, 0]
            for host in HOSTS:
                if options.host and host.name not in options.host:
                    continue
                try:
                    errors = {step: error(host, folders[step], partner, step, truth) for step in STEPS}
                    cells = said(errors)
                except AbsentError as reason:
                    cells = [*(" " for _ in SHOWN), f"not run: {reason}", " "]
                print(f"| {' | '.join([versioned(host.name, host.package), on, host.exchange, *cells])} |", flush=True)
    return 0


def error(host: Host, folder: Path, partner: str, step: float, truth: Any) -> float:
    """Return the error of the top, in parts of its peak; infinite where a host gives the run up.

    truth: every systems.STEP s.
    """
    steps = round(len(truth) * systems.STEP / step)
    try:
        top = np.array(host.rows(folder, partner, steps, step))[:, 0]
    except ComplaintError:
        return math.inf
    finer, coarser = max(1, round(systems.STEP / step)), max(1, round(step / systems.STEP))
    apart = np.abs(top[finer - 1 :: finer] - truth[coarser - 1 :: coarser])
    return float(np.max(apart) / np.max(np.abs(truth)))


def said(errors: dict[float, float]) -> list[str]:
    """Return cells: the errors, the order, the longest step."""
    stable = [step for step in STEPS if all(errors[other] < STABLE for other in STEPS if other <= step)]
    shown = [f"{errors[step]:.1e}" if errors[step] < STABLE else "diverges" for step in SHOWN]
    *_, before, last = SHOWN
    order = f"{math.log2(errors[before] / errors[last]) / math.log2(before / last):.1f}" if before in stable else ""
    return [*shown, order, f"{1e3 * stable[0]:g} ms" if stable else "none"]


if __name__ == "__main__":
    raise SystemExit(main())
