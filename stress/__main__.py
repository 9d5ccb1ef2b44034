"""`python -m stress`."""

import os

# before numba and the BLAS are loaded: one thread
for variable in ("NUMBA_NUM_THREADS", "OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ.setdefault(variable, "1")

if __name__ == "__main__":
    from .command_line import main

    raise SystemExit(main())
