"""Sixteen numbers at a time, for loops that compilers don't turn into vector instructions well enough by themselves.

``Lanes`` are values that kernels compute with as with numbers; they become whatever vector instructions the processor
has: one each with AVX-512, two with AVX2, four with SSE or NEON. Nothing is checked: arrays lie in one piece, indices
count their numbers row after row, and whole vectors must lie inside.
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic, lower_builtin, models, register_model, type_callable

WIDTH = 16


class Lanes(types.Type):
    """Sixteen float32 or int32."""

    def __init__(self, dtype: types.Type) -> None:
        self.dtype = dtype
        super().__init__(name=f"Lanes({dtype})")


@register_model(Lanes)
class _Model(models.PrimitiveModel):
    def __init__(self, manager: Any, lanes: Lanes) -> None:
        super().__init__(manager, lanes, ir.VectorType(manager.lookup(lanes.dtype).get_value_type(), WIDTH))


FLOATS, INTS = Lanes(types.float32), Lanes(types.int32)


def instruction(function: Callable[..., Any]) -> Any:
    """A function that kernels call: from the types of its arguments, its signature and how it becomes instructions."""
    return intrinsic(function)


def _constant(indices: list[int]) -> ir.Constant:
    return ir.Constant(ir.VectorType(ir.IntType(32), len(indices)), indices)


def _pointer(context: Any, builder: Any, signature: Any, args: Any) -> Any:
    """Where sixteen numbers of the array args[0] lie, from index args[1] on."""
    data = context.make_array(signature.args[0])(context, builder, args[0]).data
    lanes = context.get_value_type(Lanes(signature.args[0].dtype))
    return builder.bitcast(builder.gep(data, [args[1]]), lanes.as_pointer())


def _lane_by_lane(operation: Callable[..., Any], instruction: str) -> None:
    """Have an operator on two ``Lanes`` of float32 mean what it means on numbers."""

    @type_callable(operation)
    def typed(context: Any) -> Any:
        return lambda one, other: FLOATS if one == other == FLOATS else None

    @lower_builtin(operation, FLOATS, FLOATS)
    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return getattr(builder, instruction)(*args)


_lane_by_lane(operator.add, "fadd")
_lane_by_lane(operator.sub, "fsub")
_lane_by_lane(operator.mul, "fmul")


@instruction
def load(typing: Any, array: Any, start: Any) -> Any:
    """The sixteen numbers of an array from an index on."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.load(_pointer(context, builder, signature, args), align=4)

    return Lanes(array.dtype)(array, types.intp), lowered


@instruction
def store(typing: Any, array: Any, start: Any, lanes: Any) -> Any:
    """Write to sixteen places of an array from an index on."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        builder.store(args[2], _pointer(context, builder, signature, args), align=4)
        return context.get_dummy_value()

    return types.void(array, types.intp, lanes), lowered


@instruction
def spread(typing: Any, number: Any) -> Any:
    """One number in all lanes."""
    lanes = Lanes(number)

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        undefined = ir.Constant(context.get_value_type(lanes), ir.Undefined)
        one = builder.insert_element(undefined, args[0], ir.Constant(ir.IntType(32), 0))
        return builder.shuffle_vector(one, undefined, _constant([0] * WIDTH))

    return lanes(number), lowered


@instruction
def bits(typing: Any, lanes: Any) -> Any:
    """Bits of float32 as int32."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.bitcast(args[0], context.get_value_type(INTS))

    return INTS(FLOATS), lowered


@instruction
def minimum(typing: Any, one: Any, other: Any) -> Any:
    """The lesser of two int32 in each lane."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.icmp_signed("<", *args), *args)

    return INTS(INTS, INTS), lowered


@instruction
def where_less(typing: Any, one: Any, other: Any, then: Any, otherwise: Any) -> Any:
    """Lanes of ``then`` where those of ``one`` are less than those of ``other``, all int32."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.select(builder.icmp_signed("<", *args[:2]), *args[2:])

    return INTS(INTS, INTS, INTS, INTS), lowered


@instruction
def least_lane(typing: Any, lanes: Any) -> Any:
    """The least of sixteen int32."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        kind = ir.FunctionType(ir.IntType(32), [args[0].type])
        return builder.call(
            cgutils.get_or_insert_function(builder.module, kind, "llvm.vector.reduce.smin.v16i32"), args
        )

    return types.int32(INTS), lowered


def _equal(builder: Any, args: Any) -> Any:
    """Sixteen bits: the lanes in which two vectors are equal."""
    return builder.bitcast(builder.icmp_signed("==", *args), ir.IntType(WIDTH))


@instruction
def any_equal(typing: Any, one: Any, other: Any) -> Any:
    """Whether one of sixteen int32 is equal to that in the same lane."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        return builder.icmp_unsigned("!=", _equal(builder, args), ir.Constant(ir.IntType(WIDTH), 0))

    return types.boolean(INTS, INTS), lowered


@instruction
def first_equal(typing: Any, one: Any, other: Any) -> Any:
    """Number of the first of sixteen int32 that is equal to that in the same lane, 0 if none is."""

    def lowered(context: Any, builder: Any, signature: Any, args: Any) -> Any:
        equal = _equal(builder, args)
        first = builder.zext(builder.cttz(equal, ir.Constant(ir.IntType(1), 0)), ir.IntType(64))
        return builder.and_(first, ir.Constant(ir.IntType(64), WIDTH - 1))

    return types.intp(INTS, INTS), lowered
