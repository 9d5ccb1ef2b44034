"""A number for each of eight columns: `Lanes`, the vector type that kernels are compiled for besides float64.

A kernel called with lanes instead of floats does the same arithmetic for eight columns at once. The value of a lane is
independent of the others, so that a column has the same bits in any of them. Branches on numbers become
`where(mask, a, b)`; `any_of(mask)` and `lane(x, k)` return single numbers again.

Arithmetic must be neither reordered nor contracted, as everywhere (jit.py).
"""

import math
import operator
from collections.abc import Callable
from functools import wraps
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic, models, register_model

from .compiling import by_width
from .numba_parts import AbstractTemplate, Conversion, cgutils, infer_global, ir, lower_builtin, lower_cast, signature

WIDTH = 8

_DOUBLE = ir.DoubleType()
_VECTOR = ir.VectorType(_DOUBLE, WIDTH)
_BITS = ir.VectorType(ir.IntType(1), WIDTH)
_INT = ir.IntType(32)
_intrinsic: Callable[..., Any] = intrinsic  # called with one argument less than it is written with


class LanesType(types.Type):
    """The type of eight float64."""

    def __init__(self) -> None:
        super().__init__(name=f"Lanes{WIDTH}")

    def can_convert_from(self, typingctx: Any, other: Any) -> Any:
        """Allow a scalar to be broadcast to all lanes."""
        return Conversion.promote if isinstance(other, (types.Float, types.Integer)) else None

    def unify(self, typingctx: Any, other: Any) -> Any:
        """Return lanes as the type of a variable that is a scalar in one branch and lanes in another."""
        return self if isinstance(other, (types.Float, types.Integer)) else None


class MaskType(types.Type):
    """The type of eight truth values."""

    def __init__(self) -> None:
        super().__init__(name=f"Mask{WIDTH}")


LANES = LanesType()
MASK = MaskType()


def _model(kind: ir.Type) -> type:
    class _ValueModel(models.PrimitiveModel):  # type: ignore[misc]
        def __init__(self, manager: Any, fe_type: Any) -> None:
            super().__init__(manager, fe_type, kind)

    return _ValueModel


register_model(LanesType)(_model(_VECTOR))
register_model(MaskType)(_model(_BITS))


def _splat(builder: Any, value: Any) -> Any:
    # element 0, repeated by a shuffle
    vector = builder.insert_element(ir.Constant(_VECTOR, ir.Undefined), value, _INT(0))
    return builder.shuffle_vector(
        vector, ir.Constant(_VECTOR, ir.Undefined), ir.Constant(ir.VectorType(_INT, WIDTH), [0] * WIDTH)
    )


@lower_cast(types.Float, LanesType)
@lower_cast(types.Integer, LanesType)
def _number_to_lanes(context: Any, builder: Any, fromty: Any, toty: Any, value: Any) -> Any:
    return _splat(builder, context.cast(builder, value, fromty, types.float64))


_ARITHMETIC = {
    operator.add: "fadd",
    operator.sub: "fsub",
    operator.mul: "fmul",
    operator.truediv: "fdiv",
    operator.iadd: "fadd",
    operator.isub: "fsub",
    operator.imul: "fmul",
    operator.itruediv: "fdiv",
}
_COMPARISONS = {operator.lt: "<", operator.le: "<=", operator.gt: ">", operator.ge: ">=", operator.eq: "=="}


def _is_number(kind: Any) -> bool:
    return isinstance(kind, (LanesType, types.Float, types.Integer))


def _register(function: Any, kinds: tuple[Any, ...], result: Any, emit: Callable[..., Any]) -> None:
    """Register an operator of lanes or masks; scalars beside lanes are broadcast."""

    # typing
    @infer_global(function)
    class _Operator(AbstractTemplate):  # type: ignore[misc]
        def generic(self, args: Any, kws: Any) -> Any:
            numbers = LANES in args and all(_is_number(kind) for kind in args)
            same = len(args) == len(kinds) and (numbers if LANES in kinds else args == kinds)
            return signature(result, *kinds) if same else None

    # code
    @lower_builtin(function, *kinds)
    def _lower(context: Any, builder: Any, sig: Any, args: Any) -> Any:
        return emit(builder, *args)


for _function, _name in _ARITHMETIC.items():
    _register(_function, (LANES, LANES), LANES, lambda builder, a, b, name=_name: getattr(builder, name)(a, b))
for _function, _sign in _COMPARISONS.items():
    _register(_function, (LANES, LANES), MASK, lambda builder, a, b, sign=_sign: builder.fcmp_ordered(sign, a, b))
_register(operator.ne, (LANES, LANES), MASK, lambda builder, a, b: builder.fcmp_unordered("!=", a, b))
_register(operator.neg, (LANES,), LANES, lambda builder, x: builder.fneg(x))
_register(operator.and_, (MASK, MASK), MASK, lambda builder, a, b: builder.and_(a, b))
_register(operator.or_, (MASK, MASK), MASK, lambda builder, a, b: builder.or_(a, b))
_register(operator.xor, (MASK, MASK), MASK, lambda builder, a, b: builder.xor(a, b))
_register(operator.invert, (MASK,), MASK, lambda builder, x: builder.not_(x))


def _emits(result: Any, *kinds: Any) -> Callable[..., Any]:
    """Return a decorator of emitters (builder, values of these types), which become functions of this result."""

    def decorate(emit: Callable[..., Any]) -> Any:
        @wraps(emit)  # numba takes the names behind the first argument from there
        def function(typing: Any, *_: Any) -> Any:
            return result(*kinds), lambda context, builder, signature, arguments: emit(builder, *arguments)

        return _intrinsic(function)

    return decorate


def _unary(name: str) -> Any:
    """Return an LLVM intrinsic of one vector as a function of lanes."""

    @_emits(LANES, LANES)
    def function(builder: Any, x: Any) -> Any:
        # declared once per module
        kind = ir.FunctionType(_VECTOR, [_VECTOR])
        return builder.call(cgutils.get_or_insert_function(builder.module, kind, f"llvm.{name}.v{WIDTH}f64"), [x])

    return function


_sqrt = _unary("sqrt")
_abs = _unary("fabs")
_rint = _unary("nearbyint")


@_emits(LANES, MASK, LANES, LANES)
def _select(builder, mask, a, b):
    return builder.select(mask, a, b)


@_emits(LANES, LANES, LANES)
def mirrored(builder, x, by):
    """Return lanes x, with the sign changed where `by` is negative or minus zero."""
    # exclusive or of the sign bits
    whole = ir.VectorType(ir.IntType(64), WIDTH)
    sign = ir.Constant(whole, [-(2**63)] * WIDTH)
    number, other = builder.bitcast(x, whole), builder.bitcast(by, whole)
    return builder.bitcast(builder.xor(number, builder.and_(other, sign)), _VECTOR)


@_emits(LANES, types.float64)
def splat(builder, x):
    """Broadcast a scalar to all lanes."""
    return _splat(builder, x)


@_emits(types.float64, LANES, types.intp)
def lane(builder, x, k):
    """Return element k of the lanes."""
    return builder.extract_element(x, builder.trunc(k, _INT))


@_emits(LANES, LANES, types.intp, types.float64)
def with_lane(builder, x, k, value):
    """Return the lanes with element k replaced."""
    return builder.insert_element(x, value, builder.trunc(k, _INT))


@_emits(types.int64, MASK)
def bits(builder, mask):
    """Return the mask as an integer: bit k for lane k."""
    return builder.zext(builder.bitcast(mask, ir.IntType(WIDTH)), ir.IntType(64))


@_emits(types.boolean, types.boolean)
def rarely(builder, condition):
    """Return the condition; the compiler assumes that it is nearly always false, and moves what depends on it aside."""
    bit = ir.IntType(1)
    expect = cgutils.get_or_insert_function(builder.module, ir.FunctionType(bit, [bit, bit]), "llvm.expect.i1")
    return builder.call(expect, [condition, bit(0)])


# --- functions of numbers or lanes


def _are_lanes(*kinds: Any) -> bool:
    return any(isinstance(kind, (LanesType, MaskType)) for kind in kinds)


@by_width
def where(condition, a, b):
    """Return a where the condition holds, else b; both are evaluated."""
    if _are_lanes(condition, a, b):
        return lambda condition, a, b: _select(condition, a, b)
    return lambda condition, a, b: a if condition else b


@by_width
def any_of(condition):
    """Return True if the condition holds in any lane."""
    return (lambda condition: bits(condition) != 0) if _are_lanes(condition) else lambda condition: condition


@by_width
def magnitude(x):
    """Return |x|."""
    return (lambda x: _abs(x)) if _are_lanes(x) else lambda x: abs(x)


@by_width
def square_root(x):
    """Return the square root of x."""
    return (lambda x: _sqrt(x)) if _are_lanes(x) else lambda x: np.sqrt(x)


@by_width
def lesser(a, b):
    """Return the lesser of two numbers; b if one is NaN."""
    return (lambda a, b: _select(a < b, a, b)) if _are_lanes(a, b) else lambda a, b: a if a < b else b


@by_width
def greater(a, b):
    """Return the greater of two numbers; b if one is NaN."""
    return (lambda a, b: _select(a > b, a, b)) if _are_lanes(a, b) else lambda a, b: a if a > b else b


@by_width
def with_sign(x, by):
    """Return x, which is not negative, with the sign of another number."""
    return (lambda x, by: mirrored(x, by)) if _are_lanes(x, by) else lambda x, by: math.copysign(x, by)


@by_width
def opposite(condition):
    """Return the negation of a condition or mask."""
    return (lambda condition: ~condition) if _are_lanes(condition) else lambda condition: not condition


@by_width
def zero_like(x):
    """Return zero, as a scalar or in all lanes."""
    return (lambda x: splat(0.0)) if _are_lanes(x) else lambda x: 0.0


@by_width
def index_of(x):
    """Convert to int; of lanes, the first, as all must agree."""
    return (lambda x: int(lane(x, 0))) if _are_lanes(x) else lambda x: int(x)


@by_width
def most_of(x):
    """Convert to int; of lanes, the largest."""
    return _most if _are_lanes(x) else lambda x: int(x)


def _most(x):
    found = lane(x, 0)
    # one lane at a time
    for k in range(1, WIDTH):
        found = max(found, lane(x, k))
    return int(found)


@by_width
def nearest(x):
    """Return the nearest integer, as a float."""
    return (lambda x: _rint(x)) if _are_lanes(x) else lambda x: np.rint(x)
