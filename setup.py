"""Wheels with machine code: MULTIBLOCK_WHEEL names their platform (solver/kernels/machine/packaging.py, PLATFORMS).

Without it the wheel is for any platform, compiles at first need, and depends on numba. `build_wheels.py` makes all.
"""

import os
import shutil
import sys
from pathlib import Path

from setuptools import setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_py import build_py

PLATFORM = os.environ.get("MULTIBLOCK_WHEEL", "")
RUNS = ["numpy>=1.26,<3", "tqdm>=4.66,<5"]  # arrays; lines of progress
COMPILES = ["numba>=0.61,<1"]  # solver/kernels/numba_ext/numba_parts.py


class BuildWithMachineCode(build_py):
    """Adds the libraries of the platform to the package."""

    def run(self) -> None:
        """Build as usual, without files that an earlier build has left, then add them."""
        made = Path(self.build_lib)
        if PLATFORM and not self.editable_mode:
            sys.path.insert(0, str(Path(__file__).parent))
            from solver.kernels.machine.packaging import PLATFORMS, libraries
            from solver.kernels.machine.zig import has_linker

            if PLATFORM not in PLATFORMS:
                raise SystemExit(f"MULTIBLOCK_WHEEL = {PLATFORM}: must be of {', '.join(PLATFORMS)}")
            if not has_linker():
                raise SystemExit("MULTIBLOCK_WHEEL: ziglang is not installed: pip install ziglang")
        for package in {name.partition(".")[0] for name in self.packages if not self.editable_mode}:
            if (made / package).is_dir():
                shutil.rmtree(made / package)
        super().run()
        if not PLATFORM or self.editable_mode:
            return
        folder = made / "solver" / "kernels" / "machine" / "code"
        folder.mkdir(parents=True, exist_ok=True)
        for name, content in libraries(platforms=[PLATFORM]).items():
            (folder / name).write_bytes(content)


class PlatformWheel(bdist_wheel):
    """A wheel for any Python 3 on one platform."""

    def finalize_options(self) -> None:
        """Say that it is not for all platforms."""
        super().finalize_options()
        self.root_is_pure = not PLATFORM

    def get_tag(self) -> tuple[str, str, str]:
        """Return the tag of the wheel."""
        return ("py3", "none", PLATFORM) if PLATFORM else super().get_tag()


setup(
    cmdclass={"build_py": BuildWithMachineCode, "bdist_wheel": PlatformWheel},
    install_requires=RUNS if PLATFORM else RUNS + COMPILES,
)
