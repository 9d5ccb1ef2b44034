"""The switch of bounds checks of kernels: MULTIBLOCK_BOUNDS=1 in the environment, on Linux and macOS.

Processes that make machine code and those that run it must agree: checked code has an identifier of its own
(sources.py).
"""

import os

BOUNDS = os.environ.get("MULTIBLOCK_BOUNDS", "") == "1"
