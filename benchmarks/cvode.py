"""CVODE of SUNDIALS with the compiled right-hand side, in the shared library that scikit-sundae brings.

scikit-sundae itself takes a Python function, whose call costs twenty times the evaluation that it makes. Here the same
library is called directly, with no interpreter between integrator and equations.
"""

from __future__ import annotations

import ctypes as c
import importlib.util
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
from numba import njit, types

from solver.kernels.numba_ext.jit import native
from solver.kernels.numba_ext.views import row_at

from .right_hand_side import Array, Problem, evaluate

METHODS = {"Adams": 1, "BDF": 2}  # as CVODE numbers them
NORMAL = 1  # CV_NORMAL: step past the output time and interpolate

_handle, _int, _long, _real = c.c_void_p, c.c_int, c.c_long, c.c_double
_SIGNATURES: dict[str, tuple[Any, tuple[Any, ...]]] = {
    "N_VMake_Serial": (_handle, (c.c_int64, _handle, _handle)),
    "N_VDestroy": (None, (_handle,)),
    "CVodeCreate": (_handle, (_int, _handle)),
    "CVodeInit": (_int, (_handle, _handle, _real, _handle)),
    "CVodeSStolerances": (_int, (_handle, _real, _real)),
    "CVodeSetUserData": (_int, (_handle, _handle)),
    "CVodeSetMaxNumSteps": (_int, (_handle, _long)),
    "CVodeSetLinearSolver": (_int, (_handle, _handle, _handle)),
    "CVodeSetNonlinearSolver": (_int, (_handle, _handle)),
    "CVodeFree": (None, (_handle,)),
    "SUNDenseMatrix": (_handle, (c.c_int64, c.c_int64, _handle)),
    "SUNLinSol_Dense": (_handle, (_handle, _handle, _handle)),
    "SUNNonlinSol_FixedPoint": (_handle, (_handle, _int, _handle)),
    "SUNMatDestroy": (None, (_handle,)),
    "SUNLinSolFree": (_int, (_handle,)),
    "SUNNonlinSolFree": (_int, (_handle,)),
}


def _library() -> c.CDLL:
    """Return the library that scikit-sundae brings. Raises ImportError or OSError."""
    found = importlib.util.find_spec("sksundae")
    if found is None or found.origin is None:
        raise ImportError("No module named 'sksundae'")
    import sksundae  # loads what the library depends on

    folder = Path(found.origin).parent.parent / "scikit_sundae.libs"
    for name in ("libsundials_core", "libsundials_cvode"):
        paths = sorted(folder.glob(f"{name}-*"))
        if not paths:
            raise ImportError(f"scikit-sundae {sksundae.__version__} brings no {name}")
        library = c.CDLL(str(paths[0]), mode=c.RTLD_GLOBAL)
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


class Cvode:
    """One method of CVODE: BDF with Newton and a dense difference Jacobian, Adams with functional iteration."""

    def __init__(self, method: str) -> None:
        self.method = method
        self.library = _library()
        create = self.library.SUNContext_Create
        create.restype, create.argtypes = _int, (_int, c.POINTER(_handle))
        context = _handle()
        create(0, c.byref(context))  # 0: no MPI communicator
        self.context = context.value
        self.library.SUNContext_ClearErrHandlers(context)  # failures come back as codes
        self.rates = _rates_of_vectors(self.library)
        self.follow = _follower(self.library)

    def prepare(self, problem: Problem, tolerance: float, most_steps: int) -> Callable[[], tuple[Array, int]]:
        """Return () -> (unknowns (nt, 4n), code of CVODE: negative for a failure), to be timed."""
        size = problem.start.size

        def integrate() -> tuple[Array, int]:
            lib, context = self.library, self.context
            y = problem.start.copy()
            vector = lib.N_VMake_Serial(size, y.ctypes.data, context)
            memory = lib.CVodeCreate(METHODS[self.method], context)
            lib.CVodeInit(memory, self.rates.address, problem.times[0], vector)
            lib.CVodeSStolerances(memory, tolerance, tolerance)
            lib.CVodeSetUserData(memory, problem.data.ctypes.data)
            lib.CVodeSetMaxNumSteps(memory, most_steps)
            matrix = linear = iteration = None
            if self.method == "BDF":
                matrix = lib.SUNDenseMatrix(size, size, context)
                linear = lib.SUNLinSol_Dense(vector, matrix, context)
                lib.CVodeSetLinearSolver(memory, linear, matrix)
            else:
                iteration = lib.SUNNonlinSol_FixedPoint(vector, 0, context)
                lib.CVodeSetNonlinearSolver(memory, iteration)
            states = np.empty((problem.times.size, size))
            code = self.follow(memory, vector, y, problem.times, states, np.zeros(1))
            lib.CVodeFree(c.byref(_handle(memory)))
            if linear is not None:
                lib.SUNLinSolFree(linear)
                lib.SUNMatDestroy(matrix)
            if iteration is not None:
                lib.SUNNonlinSolFree(iteration)
            lib.N_VDestroy(vector)
            return states, code

        return integrate


def _rates_of_vectors(library: c.CDLL) -> Any:
    """Return the right-hand side as CVODE calls it: int f(double t, N_Vector y, N_Vector dydt, void *data)."""
    entries = library.N_VGetArrayPointer
    entries.restype, entries.argtypes = c.POINTER(c.c_double), (_handle,)

    @native(types.int32(types.double, types.voidptr, types.voidptr, types.CPointer(types.double)))
    def rates_of_vectors(t, y, dydt, data):
        evaluate(t, row_at(entries(y)), row_at(entries(dydt)), row_at(data))
        return 0

    return rates_of_vectors


def _follower(library: c.CDLL) -> Any:
    """Return the loop over the output times, compiled."""
    advance = library.CVode
    advance.restype, advance.argtypes = _int, (_handle, _real, _handle, _handle, _int)

    @njit  # with numba's runtime, which the addresses of arrays need; it is not part of an evaluation
    def follow(memory, vector, y, times, states, reached):
        states[0] = y
        for k in range(1, times.size):
            code = advance(memory, times[k], vector, reached.ctypes.data, NORMAL)
            if code < 0:
                return code
            states[k] = y
        return 0

    return follow
