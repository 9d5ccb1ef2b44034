"""`python -m validation`."""

import os

os.environ["MULTIBLOCK_COMPILES"] = "1"  # of this process: benchmarks, which cases use, have kernels of their own

if __name__ == "__main__":
    import sys

    from .command_line import main

    sys.exit(main())
