"""Lock-free access of threads to shared arrays: compare and swap, fetch and add, prefetch.

Numba has no atomic operations for CPUs, but LLVM has: these intrinsics provide them.
"""

# Code generators of Numba have no types.
# mypy: disable-error-code="no-untyped-call,no-untyped-def,import-untyped"

from __future__ import annotations

from typing import Any

from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic


def _for_kernels(define: Any) -> Any:
    """An intrinsic; kernels call it without the context that its definition gets."""
    return intrinsic(define)


def _pointer(context, builder, array_type, array, indices):
    from numba.np.arrayobj import make_array  # only compilations need it, and it takes long to import

    view = make_array(array_type)(context, builder, array)
    return cgutils.get_item_pointer(context, builder, array_type, view, indices, wraparound=False)


@_for_kernels
def load(_, array, at):
    """Read an element that other threads write; what they wrote before it is seen, too."""

    def code(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], arguments[0], [arguments[1]])
        return builder.load_atomic(pointer, "acquire", 8)

    return types.int64(array, types.intp), code


@_for_kernels
def compare_and_swap(_, array, at, old, new):
    """Replace `old` by `new` if it is there; return whether it was."""

    def code(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], arguments[0], [arguments[1]])
        result = builder.cmpxchg(pointer, arguments[2], arguments[3], "acq_rel", "acquire")
        return builder.extract_value(result, 1)

    return types.boolean(array, types.intp, types.int64, types.int64), code


@_for_kernels
def fetch_and_add(_, array, at, amount):
    """Add to an element; what it was before."""

    def code(context, builder, signature, arguments):
        pointer = _pointer(context, builder, signature.args[0], arguments[0], [arguments[1]])
        return builder.atomic_rmw("add", pointer, arguments[2], "acq_rel")

    return types.int64(array, types.intp, types.int64), code


@_for_kernels
def prefetch(_, array, at):
    """Ask for an element, or the first one of a row, so that it is in the cache when it is needed."""

    def code(context, builder, signature, arguments):
        array_type = signature.args[0]
        zero = context.get_constant(types.intp, 0)
        indices = [arguments[1], *[zero] * (array_type.ndim - 1)]
        pointer = _pointer(context, builder, array_type, arguments[0], indices)
        byte = ir.IntType(8).as_pointer()
        number = ir.IntType(32)
        function = builder.module.declare_intrinsic(
            "llvm.prefetch", [byte], ir.FunctionType(ir.VoidType(), [byte, number, number, number])
        )
        # To read, keep it in all caches, data.
        builder.call(function, [builder.bitcast(pointer, byte), number(0), number(3), number(1)])
        return context.get_dummy_value()

    return types.void(array, types.intp), code
