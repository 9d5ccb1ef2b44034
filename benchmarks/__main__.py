"""`python -m benchmarks`."""

import os

# set before numba and the BLAS are loaded: everything is compared on one thread
for variable in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[variable] = "1"

os.environ["MULTIBLOCK_COMPILES"] = "1"  # kernels by numba, which competitors call, in this process alone

if __name__ == "__main__":
    from .command_line import main

    main()
