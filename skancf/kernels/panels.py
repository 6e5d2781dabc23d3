"""Products of small matrices in compiled functions, in the vector registers of the machine.

A library's matrix multiply has to look at its arguments before it starts, and is built for sizes that a compiler does not
know. Here the compiler knows how many rows there are; they stay in registers.
"""

import numpy as np
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.core.errors import TypingError
from numba.extending import intrinsic

from skancf.compiled import INNER, compiled

WIDTH = 16
"""Columns of a panel."""
VECTOR = ir.VectorType(ir.DoubleType(), 8)
FUSED = ("contract",)


@compiled(**INNER)
def aligned(rows, columns):
    """An array that starts at a cache line, so that no vector of it lies on two."""
    memory = np.empty(rows * columns + 8)
    first = (64 - memory.ctypes.data % 64) // 8 % 8
    return memory[first : first + rows * columns].reshape(rows, columns)


def _panel(add, typing, rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row):
    """Signature and code of :func:`add_panel` and :func:`set_panel`."""
    for array in (A, B, C):
        if array.layout != "C" or array.dtype != types.float64:
            raise TypingError(f"{array} in a panel, which takes contiguous arrays of float64: copy it")
    if not isinstance(rows, types.IntegerLiteral):
        raise TypingError(f"rows of type {rows} in a panel: give a number, which the compiler has to know, no variable")
    signature = types.void(rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row)

    def generate(context, builder, signature, arguments):
        integer = ir.IntType(64)

        def constant(value):
            return ir.Constant(integer, value)

        def number(at):
            return context.cast(builder, arguments[at], signature.args[at], types.int64)

        def start(at):
            array = context.make_array(signature.args[at])(context, builder, arguments[at])
            return builder.gep(array.data, [number(at + 1)])

        def vector(pointer, at):
            return builder.bitcast(builder.gep(pointer, [at]), VECTOR.as_pointer())

        length, a_next, a_row, b_next, c_row = (number(at) for at in (1, 4, 5, 8, 11))
        A, B, C = start(2), start(6), start(9)
        at_row = [builder.mul(a_row, constant(i)) for i in range(rows.literal_value)]
        places = [
            vector(C, builder.add(builder.mul(c_row, constant(i)), constant(j)))
            for i in range(rows.literal_value) for j in range(0, WIDTH, 8)
        ]  # fmt: skip
        before = [builder.load(place, align=8) if add else ir.Constant(VECTOR, [0.0] * 8) for place in places]
        entry, loop, end = builder.block, builder.append_basic_block(), builder.append_basic_block()
        builder.branch(loop)
        builder.position_at_end(loop)
        k = builder.phi(integer)
        sums = [builder.phi(VECTOR) for _ in places]
        own = builder.mul(k, b_next)
        columns = [builder.load(vector(B, builder.add(own, constant(j))), align=8) for j in range(0, WIDTH, 8)]
        own = builder.mul(k, a_next)
        after = []
        undefined = ir.Constant(VECTOR, ir.Undefined)
        for i, at in enumerate(at_row):
            value = builder.load(builder.gep(A, [builder.add(own, at)]))
            first = builder.insert_element(undefined, value, ir.Constant(ir.IntType(32), 0))
            factor = builder.shuffle_vector(first, undefined, ir.Constant(ir.VectorType(ir.IntType(32), 8), [0] * 8))
            for j, column in enumerate(columns):
                after.append(builder.fadd(sums[2 * i + j], builder.fmul(factor, column, flags=FUSED), flags=FUSED))
        following = builder.add(k, constant(1))
        for phi, first, later in zip([k, *sums], [constant(0), *before], [following, *after], strict=True):
            phi.add_incoming(first, entry)
            phi.add_incoming(later, loop)
        builder.cbranch(builder.icmp_signed("<", following, length), loop, end)
        builder.position_at_end(end)
        for place, value in zip(places, after, strict=True):
            builder.store(value, place, align=8)
        return context.get_dummy_value()

    return signature, generate


@intrinsic(prefer_literal=True)
def add_panel(typing, rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row):
    """Adds the sum over k < n of A[a + k a_next + i a_row] B[b + k b_next + j] to C[c + i c_row + j].

    For i < ``rows``, a number known to the compiler, and j < 16; n > 0. Arrays are contiguous, their indices flat. Sums of 4
    to 12 rows fill the pipelines of processors with vectors of eight; on those with shorter ones, whose registers hold fewer
    sums, some of them go through memory.
    """
    return _panel(True, typing, rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row)


@intrinsic(prefer_literal=True)
def set_panel(typing, rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row):
    """As :func:`add_panel`, but what was in C is forgotten."""
    return _panel(False, typing, rows, n, A, a, a_next, a_row, B, b, b_next, C, c, c_row)


@intrinsic
def prefetch(typing, array, at):
    """Asks the cache for what is at a flat index of a contiguous array, which is written soon."""
    if array.layout != "C":
        raise TypingError(f"{array} is not contiguous, so that it has no flat index: copy it")
    signature = types.void(array, at)

    def generate(context, builder, signature, arguments):
        data = context.make_array(signature.args[0])(context, builder, arguments[0]).data
        place = builder.gep(data, [context.cast(builder, arguments[1], signature.args[1], types.int64)])
        byte = builder.bitcast(place, ir.IntType(8).as_pointer())
        flag = ir.IntType(32)
        kind = ir.FunctionType(ir.VoidType(), [byte.type, flag, flag, flag])
        function = cgutils.get_or_insert_function(builder.module, kind, "llvm.prefetch.p0i8")
        builder.call(function, [byte, *(ir.Constant(flag, value) for value in (1, 3, 1))])
        return context.get_dummy_value()

    return signature, generate
