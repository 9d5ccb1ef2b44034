"""The private parts of numba and llvmlite that the solver uses. Except for linking.py, no other module imports one.

lane_types.py and rows.py define types of their own; they need the names imported here, unchanged since numba 0.61.
linking.py needs the parts listed in `_LINKING`. tests/project/test_numba_parts.py lists those that a new numba lacks.
"""

import re
from importlib import import_module
from typing import Any

import numba

OLDEST = (0, 61)
NEEDED = "numba 0.61 or newer: pip install 'numba>=0.61,<1'"

if tuple(int(part) for part in re.findall(r"\d+", numba.__version__)[:2]) < OLDEST:
    raise ImportError(f"numba {numba.__version__} is too old, needs {NEEDED}")

try:
    from llvmlite import ir
    from numba.core import cgutils
    from numba.core.errors import TypingError
    from numba.core.imputils import lower_builtin, lower_cast, lower_getattr_generic, lower_setattr_generic
    from numba.core.typeconv.castgraph import Conversion
    from numba.core.typing.templates import (
        AbstractTemplate,
        AttributeTemplate,
        infer_getattr,
        infer_global,
        signature,
    )
except ImportError as error:
    raise ImportError(f"numba {numba.__version__} lacks what the kernels need ({error}), needs {NEEDED}") from None

__all__ = [
    "AbstractTemplate",
    "AttributeTemplate",
    "Conversion",
    "TypingError",
    "cgutils",
    "infer_getattr",
    "infer_global",
    "ir",
    "lower_builtin",
    "lower_cast",
    "lower_getattr_generic",
    "lower_setattr_generic",
    "signature",
]

# module, name in it, attributes that are used of the class or of its instances
_LINKING: tuple[tuple[str, str, str], ...] = (
    (
        "numba.core.codegen",
        "JITCodeLibrary",
        "finalize _optimize_functions _optimize_final_module _finalize_final_module "
        "_get_module_for_linking _raise_if_finalized _finalized _final_module _shared_module _linking_libraries "
        "_codegen",
    ),
    ("numba.core.base", "BaseContext", "get_abi_sizeof"),
    ("numba.core.codegen", "CPUCodegen", "_data_layout"),
    ("numba.core.compiler", "Compiler", "compile_extra define_pipelines state"),
    ("numba.core.compiler", "DefaultPassBuilder", "define_nopython_pipeline"),
    ("numba.core.compiler_machinery", "LoweringPass", ""),
    ("numba.core.compiler_machinery", "PassManager", "add_pass_after finalize passes"),
    ("numba.core.compiler_machinery", "register_pass", ""),
    ("numba.core.cpu", "CPUContext", "codegen insert_user_function"),
    ("numba.core.typed_passes", "NativeLowering", ""),
    ("numba.core.types", "ArrayCompatible", ""),
    ("numba.core.typing.npydecl", "NumpyRulesArrayOperator", "generic"),
    ("llvmlite.binding", "Linkage", "external internal linkonce_odr"),
    ("llvmlite.binding", "ModuleRef", "clone functions global_variables link_in verify"),
)


def missing_for_linking() -> list[str]:
    """Return the parts that `linking.py` uses and this numba lacks, as "module.name" or "module.name.attribute"."""
    missing = []
    for place, name, attributes in _LINKING:
        try:
            found = getattr(import_module(place), name)
        except (ImportError, AttributeError):
            missing.append(f"{place}.{name}")
            continue
        # attributes that are used
        known = _names(found)
        missing += [f"{place}.{name}.{attribute}" for attribute in attributes.split() if attribute not in known]
    return missing


def _names(found: Any) -> set[str]:
    """Return the attributes of a class and all names that its methods use, which include those of its instances."""
    known = set(dir(found))
    # attributes of the class, and names in the code of its methods
    for kind in getattr(found, "__mro__", ()):
        for method in vars(kind).values():
            code = getattr(method, "__code__", None)
            known.update(code.co_names if code else ())
    return known


if missing := missing_for_linking():
    raise ImportError(f"numba {numba.__version__} lacks {', '.join(missing)}, needs {NEEDED}")
