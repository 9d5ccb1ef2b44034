"""`python -m benchmarks.galleries`: the time that a gallery of 40 objects on 5 mounts takes.

The objects are random boxes of 0.3 to 2 m on pedestals. Under 7 artificial motions of EN 1998-1 (0.2 g, soil B) each of
the 200 pairs makes 8 runs a motion, 11,200 in all. With `--margin` the margins are searched too; `--objects N` makes
less.
"""

from __future__ import annotations

import argparse
import tempfile
import time as clock
import warnings
from pathlib import Path

import numpy as np

from solver.checks import spectra
from solver.checks.action import Level
from solver.checks.limits import Plan
from solver.checks.subject import subject_of
from solver.commands.progress import PlainLine
from solver.common.errors import InputWarning
from solver.gallery.mounts import mounted, read_mounts
from solver.gallery.objects import Exhibit
from solver.gallery.survey import common_action, survey

from .scenes import ROOT

MOUNTS = ("free", "wax", "wider base", "rubber", "pendulums")
LEVEL = Level(spectra.eurocode8(0.2 * 9.80665, "B"), None, None, None, None, 0.9, 7, False, 0)


def objects(count: int) -> tuple[Exhibit, ...]:
    """Return random boxes, four fifths of them on free pedestals and the others on fixed ones."""
    rng, found = np.random.default_rng(1), []
    for number in range(count):
        height = float(rng.uniform(0.3, 2.0))
        width, depth = (float(height * rng.uniform(0.2, 0.4)) for _ in range(2))
        box = {"width": width, "depth": depth, "height": height, "mass": 0.4 * 2700.0 * width * depth * height}
        wide = {"width": 1.4 * width, "depth": 1.4 * depth, "height": float(rng.uniform(0.4, 1.2))}
        pedestal = wide | {"mass": 0.6 * 2700.0 * np.prod(list(wide.values())).item()}
        box["centroid"] = height * float(rng.uniform(0.4, 0.55))
        found.append(Exhibit(f"object {number + 1}", "marble", box, "", pedestal, number % 5 == 4, 0))
    return tuple(found)


def main() -> None:
    """Run the gallery and print its time."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--objects", type=int, default=40)
    parser.add_argument("--margin", action="store_true")
    options = parser.parse_args()
    warnings.simplefilter("ignore", InputWarning)
    mounts = [one for one in read_mounts(ROOT / "examples" / "gallery" / "mounts.toml") if one.name in MOUNTS]
    exhibits = objects(options.objects)
    begin, worked = clock.perf_counter(), clock.process_time()
    subjects = [subject_of(mounted(exhibit, mount)) for exhibit in exhibits for mount in mounts]
    action = common_action(subjects, (), LEVEL, None)
    ready = clock.perf_counter()
    plan = Plan(ensemble=7, margin=options.margin, joints=False)
    with tempfile.TemporaryDirectory() as folder, PlainLine() as line:
        found = survey(exhibits, mounts, subjects, {0: action}, plan, Path(folder) / "objects.journal", line)
    took, processor = clock.perf_counter() - begin, clock.process_time() - worked
    runs = sum(one.runs for row in found.outcomes for one in row)
    holding = sum(one.holds for row in found.outcomes for one in row)
    print(f"{len(exhibits)} objects, {len(mounts)} mounts: {runs} runs{' and margins' if options.margin else ''}")
    print(f"{holding} of {len(subjects)} pairs hold; models and motions {ready - begin:.0f} s, all {took:.0f} s,")
    print(f"{processor:.0f} s of processor time")


if __name__ == "__main__":
    main()
