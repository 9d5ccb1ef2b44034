"""Build wheels with machine code for every platform, on one machine: `python build_wheels.py [-o DIST] [PLATFORM ...]`.

Needs numba and ziglang: pip install -e ".[native]". Machine code is made once for all platforms and kept.
"""

from __future__ import annotations

import argparse
import os
import subprocess
import sys
from collections.abc import Sequence
from pathlib import Path

from solver.kernels.machine.packaging import PLATFORMS, libraries
from solver.kernels.machine.zig import has_linker

ROOT = Path(__file__).resolve().parent


def main(arguments: Sequence[str] | None = None) -> int:
    """Build the wheels; return 2 without the tools."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("platforms", nargs="*", metavar="PLATFORM", help=f"of {', '.join(PLATFORMS)}; default: all")
    parser.add_argument("-o", "--output-folder", type=Path, default=Path("dist"))
    options = parser.parse_args(arguments)
    unknown = [name for name in options.platforms if name not in PLATFORMS]
    if unknown or not has_linker():
        missing = 'ziglang is not installed: pip install -e ".[native]"'
        problem = f"{unknown[0]}: must be of {', '.join(PLATFORMS)}" if unknown else missing
        print(f"build_wheels.py: {problem}", file=sys.stderr)
        return 2
    platforms = options.platforms or list(PLATFORMS)
    libraries(platforms=platforms)  # of all platforms at once: typed and optimized once
    for platform in platforms:
        pip = [sys.executable, "-m", "pip", "wheel", "-q", "--no-deps", "--no-build-isolation"]
        environment = os.environ | {"MULTIBLOCK_WHEEL": platform}
        subprocess.run([*pip, "-w", options.output_folder, ROOT], check=True, env=environment)
        print(f"{platform}: built", flush=True)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
