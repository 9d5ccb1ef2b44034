"""Compilation of kernels to machine code: typed one by one, optimized once, in the entry that Python calls.

Numba alone optimizes a function with all its callees and makes machine code of it, then does so again in its caller,
and once more in the next: with entries of hundreds of kernels, ten levels deep, that was most of a first run. Here a
kernel waits unoptimized; the entry links each one that it needs with internal linkage, so that the optimizer knows
every caller, and optimizes the whole a single time.

All private parts of numba that this uses are listed in numba_parts.py, which refuses a numba that lacks one.
"""

import gc
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from functools import lru_cache
from typing import Any

from llvmlite import binding as llvm
from numba.core.base import BaseContext
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler, DefaultPassBuilder
from numba.core.compiler_machinery import LoweringPass, register_pass
from numba.core.typed_passes import NativeLowering
from numba.core.types import ArrayCompatible
from numba.core.typing.npydecl import NumpyRulesArrayOperator

# What numba looks for and kernels do not have: closures, `with`, `raise` of what is only known as it runs,
# `literally`, `literal_unroll`, functions that it inlines as Python, expressions of arrays, loops in parallel, objects
# to release (IRLegalization marks where). Each of these passes goes through the whole function, most more than once.
_NEEDLESS = {
    "DumpParforDiagnostics",
    "FindLiterallyCalls",
    "IRProcessing",
    "InlineClosureLikes",
    "IRLegalization",
    "InlineInlinables",
    "InlineOverloads",
    "LiteralPropagationSubPipelinePass",
    "LiteralUnroll",
    "MakeFunctionToJitFunction",
    "NoPythonSupportedFeatureValidation",
    "NopythonRewrites",
    "RewriteDynamicRaises",
    "WithLifting",
}

# It also searches numpy's functions of arrays for every operator, and asks LLVM for the size of every variable, in a
# fifth of the time.
_of_arrays = NumpyRulesArrayOperator.generic


def _if_arrays(rules: Any, arguments: Any, named: Any) -> Any:
    """Return the signature of an operator for arrays; None without an array, as numba does after the search."""
    found = any(isinstance(argument, ArrayCompatible) for argument in arguments)
    return _of_arrays(rules, arguments, named) if found else None


NumpyRulesArrayOperator.generic = _if_arrays  # type: ignore[method-assign]
BaseContext.get_abi_sizeof = lru_cache(maxsize=None)(BaseContext.get_abi_sizeof)  # type: ignore[method-assign]

_PORTION = 24  # of kernels that are linked at once
_EXTERNAL, _SHARED, _OWN = llvm.Linkage.external, llvm.Linkage.linkonce_odr, llvm.Linkage.internal


def _defined(module: llvm.ModuleRef) -> Iterable[Any]:
    return (function for function in module.functions if not function.is_declaration)


def _below(libraries: Iterable[Any], found: dict[Any, None]) -> dict[Any, None]:
    """Return the libraries and those of all their callees, each once, in a fixed order."""
    for library in libraries:
        if library not in found:
            # depth first; the order fixes that of the code
            found[library] = None
            if isinstance(library, WaitingLibrary):
                _below(library._linking_libraries, found)
    return found


class WaitingLibrary(JITCodeLibrary):  # type: ignore[misc]
    """A kernel as written, and its callees: neither optimized nor compiled to machine code."""

    def _optimize_functions(self, module: llvm.ModuleRef) -> None:
        module.data_layout = self._codegen._data_layout

    def finalize(self) -> None:
        self._raise_if_finalized()
        self._finalized = True

    def alone(self) -> llvm.ModuleRef:
        """Return a copy to link with, without its callees."""
        module = self._final_module.clone()
        # callers may each contain it: one copy is kept
        for function in _defined(module):
            if function.linkage == _EXTERNAL:
                function.linkage = _SHARED
        return module

    def with_called(self) -> llvm.ModuleRef:
        """Return a copy to link with, including its callees."""
        whole = self.alone()
        for library in list(_below([self], {}))[1:]:
            whole.link_in(_module_of(library), preserve=True)
        return whole

    def _get_module_for_linking(self) -> llvm.ModuleRef:
        """Return the linked module, for functions that numba compiles in its own way."""
        if self._shared_module is None:
            self._shared_module = self.with_called()
        return self._shared_module


def linked(libraries: Iterable[Any]) -> llvm.ModuleRef:
    """Return the module of kernels and all their callees, each linked once."""
    whole, below = llvm.parse_assembly(""), list(_below(libraries, {}))
    waiting = [library._final_module for library in below if isinstance(library, WaitingLibrary)]
    # in portions: the linker scans the module that it adds to at every call
    for first in range(0, len(waiting), _PORTION):
        portion = llvm.parse_assembly("")
        for module in waiting[first : first + _PORTION]:
            portion.link_in(module, preserve=True)
        whole.link_in(portion)
    # of numba's own functions, which callers share, the linker takes those that are called by now
    for library in below:
        if not isinstance(library, WaitingLibrary):
            whole.link_in(library._get_module_for_linking(), preserve=True)
    return whole


def _module_of(library: Any) -> llvm.ModuleRef:
    return library.alone() if isinstance(library, WaitingLibrary) else library._get_module_for_linking()


class WholeLibrary(JITCodeLibrary):  # type: ignore[misc]
    """A function with all its callees, optimized once."""

    def finalize(self) -> None:
        self._raise_if_finalized()
        module = self._final_module
        # link all callees
        seen_from_outside = {item.name for item in (*_defined(module), *module.global_variables)}
        for library in _below(self._linking_libraries, {}):
            if hasattr(library, "_reload_init"):  # since numba 0.65
                self._reload_init.update(library._reload_init)
            module.link_in(_module_of(library), preserve=True)
        # hide them, so that the optimizer knows every caller
        for item in (*_defined(module), *module.global_variables):
            if not item.is_declaration and item.name not in seen_from_outside:
                item.linkage = _OWN
        self._optimize_final_module()
        self._final_module.verify()
        self._finalize_final_module()


@register_pass(mutates_CFG=False, analysis_only=True)
class _StandIn(LoweringPass):  # type: ignore[misc]
    """The pass that registers an object by which numba identifies a kernel that Python cannot call."""

    _name = "stand_in"

    def __init__(self) -> None:
        LoweringPass.__init__(self)

    def run_pass(self, state: Any) -> bool:
        stand_in = object().__format__  # numba requires a builtin; this one differs from any other, and refuses numbers
        state.cr = state.cr._replace(cfunc=stand_in)
        state.targetctx.insert_user_function(stand_in, state.cr.fndesc, [state.library])
        return True


def _passes(state: Any, own: Any = None) -> list[Any]:
    """Return numba's pipeline without the passes that find nothing in kernels; own: a pass after the lowering."""
    passes = DefaultPassBuilder.define_nopython_pipeline(state)
    passes.passes = [each for each in passes.passes if each[0].__name__ not in _NEEDLESS]
    if own is not None:
        passes.add_pass_after(own, NativeLowering)
    passes.finalize()
    return [passes]


class KernelCompiler(Compiler):  # type: ignore[misc]
    """A compiler of kernels as far as they are typed; only other kernels can call them."""

    def define_pipelines(self) -> list[Any]:
        """Return numba's pipelines, without machine code at the end."""
        flags = self.state.flags
        flags.no_compile = flags.no_cpython_wrapper = flags.no_cfunc_wrapper = True
        self.state.library = WaitingLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return _passes(self.state, _StandIn)


@contextmanager
def collecting_seldom() -> Iterator[None]:
    """Let Python collect garbage less often: its scans of the compiler's objects take a sixth of the time."""
    usual = gc.get_threshold()
    gc.set_threshold(100_000, 20, 100)
    try:
        yield
    finally:
        gc.set_threshold(*usual)


class WholeCompiler(Compiler):  # type: ignore[misc]
    """A compiler of functions that Python, or another program, calls, with all kernels below them."""

    def compile_extra(self, func: Any) -> Any:
        """Compile as numba does."""
        with collecting_seldom():
            return super().compile_extra(func)

    def define_pipelines(self) -> list[Any]:
        """Return numba's pipelines."""
        flags = self.state.flags
        flags.no_cfunc_wrapper = not flags.no_cpython_wrapper  # either Python calls it or another program
        self.state.library = WholeLibrary(self.state.targetctx.codegen(), self.state.func_id.func_qualname)
        return _passes(self.state)
