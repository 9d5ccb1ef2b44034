"""Run a script whose PythonFMUs carry libraries for this processor: python this_processor.py SCRIPT ARGUMENT ...

Machine code for other systems and levels takes seconds a group, and no quick test needs it.
"""

from __future__ import annotations

import runpy
import sys

from solver.kernels.machine import packaging
from solver.kernels.machine.level import levels


def carry_for_this_processor() -> None:
    """Leave of the platforms of packages, in this process, Linux with the highest level of this processor."""
    own = levels()[0]
    packaging.PLATFORMS = {
        name: (suffix, {level: target for level, target in targets.items() if "linux" in name and level == own})
        for name, (suffix, targets) in packaging.PLATFORMS.items()
    }


if __name__ == "__main__":
    carry_for_this_processor()
    sys.argv = sys.argv[1:]
    runpy.run_path(sys.argv[0], run_name="__main__")
