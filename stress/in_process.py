"""Functions that the campaign runs in a process of its own: `python -m stress.in_process FUNCTION ARGUMENTS`.

Arguments and result are JSON. `--jumping-clock` and `--largest-file BYTES` before the function hinder the process.
The tests' Instance must be in reach.
"""

from __future__ import annotations

import hashlib
import json
import random
import sys
import time
from typing import Any


def start(fmu: str, largest_file: int = 0) -> list[Any]:
    """Return outputs after a first step; no file may grow beyond `largest_file` bytes once the FMU is extracted."""
    from support.instance import Instance, unpacked

    folder = unpacked(fmu)
    if largest_file:
        limit_files(largest_file)
    column = Instance(fmu, {"base.ax": 0.5}, folder=folder)
    column.step(0.0, 0.1)
    outputs = column.get()
    column.close()
    return outputs


def simulate(column: str) -> str:
    """Hash of the displacements of a run."""
    from solver import Column, Motion, simulate

    response = simulate(Column.from_toml(column), Motion.harmonic(1.0, 2.0, 3.0))
    return hashlib.sha256(response.ux.tobytes()).hexdigest()


def command(program: str, arguments: list[str]) -> None:
    """Run a command of the project, `solver` or `build_fmu`; exits as it does."""
    import build_fmu
    from solver.commands import command_line

    sys.exit({"solver": command_line.main, "build_fmu": build_fmu.main}[program](arguments))


def digests(seed: int, count: int) -> list[str]:
    """Run `digests` of determinism.py."""
    from .determinism import digest

    return [digest(seed, k) for k in range(count)]


def scene_rows() -> list[Any]:
    """Run `scene_rows` of determinism.py."""
    from .determinism import scene_rows

    return list(scene_rows())


def sweep() -> list[dict[str, Any]]:
    """Run `sweep` of scheme.py."""
    from .scheme import sweep

    return sweep()


def serve_scenes() -> None:
    """Print for each line of arguments of `scenes.digest` a line with its result."""
    from .scenes import digest

    for line in sys.stdin:
        print(json.dumps(digest(*json.loads(line))), flush=True)


def limit_files(size: int) -> None:
    """Limit the files of this process to a number of bytes, as on a full disk."""
    import os
    import resource

    # bytecode cut short would stay in the checkout (importlib does not notice)
    sys.dont_write_bytecode = True
    os.environ["PYTHONDONTWRITEBYTECODE"] = "1"

    resource.setrlimit(resource.RLIMIT_FSIZE, (size, size))


def let_clocks_jump() -> None:
    """Make every clock wrong by days, in either direction."""
    chance = random.Random(1)
    for name in ("time", "perf_counter", "monotonic"):
        real = getattr(time, name)
        setattr(time, name, lambda real=real: real() + chance.uniform(-1e6, 1e6))


def main(words: list[str]) -> None:
    """Run the command line."""
    if words[0] == "--jumping-clock":
        let_clocks_jump()
        words = words[1:]
    if words[0] == "--largest-file":
        limit_files(int(words[1]))
        words = words[2:]
    name, given = words
    print(json.dumps(globals()[name](*json.loads(given))))


if __name__ == "__main__":
    main(sys.argv[1:])
