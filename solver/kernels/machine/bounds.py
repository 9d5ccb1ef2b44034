"""Whether kernels check the bounds of every row: where MULTIBLOCK_BOUNDS=1 is in the environment, on Linux and macOS.

What makes machine code and what runs it must agree: checked code is kept under an identifier of its own (sources.py).
"""

import os

BOUNDS = os.environ.get("MULTIBLOCK_BOUNDS", "") == "1"
