"""Kernels for difference bounds and for how state classes are stored.

A bound of a difference is twice a number, plus 1 if the number itself is allowed; so a smaller bound is a
stricter one. A class of n clocks is stored as a record: n upper bounds, n lower bounds (of ``0 - x``), one
bit for each ordered pair of clocks, and the bounds of the pairs whose bit is set. A pair is left out when
its bound follows from those of its two clocks, so equal classes have equal records.
"""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.markings import (
    CLASSES,
    CODES,
    INDEX_BITS,
    INDEX_MASK,
    TAG_SHIFT,
    UNKNOWN,
    finished,
    mixed,
)

UNBOUNDED = 1 << 60
NO_SUM = 1 << 59
"""No sum of bounds that are there is as large."""
ZERO = 1


@kernel(inline="always")
def plus(one, other):  # type: ignore[no-untyped-def]
    """Add two bounds; a sum with one that is missing stays far above all others."""
    total = one + other - ((one | other) & 1)
    return total if total < NO_SUM else UNBOUNDED


@kernel()
def encode(matrix, clocks, code, base, bits, top):  # type: ignore[no-untyped-def]
    """Write the record of a matrix in normal form, from a position on; return its length.

    Row and column 0 of the matrix are those of 0. `bits` go into one element; `top` stands for no bound.
    """
    for i in range(1, clocks + 1):
        code[base + i - 1] = min(matrix[i, 0], top)
        code[base + clocks + i - 1] = matrix[0, i]
    at = base + 2 * clocks
    values = at + (clocks * (clocks - 1) + bits - 1) // bits
    bit, word = 0, 0
    for i in range(1, clocks + 1):
        upper = matrix[i, 0]
        for j in range(1, clocks + 1):
            if i == j:
                continue
            if matrix[i, j] < plus(upper, matrix[0, j]):
                word |= 1 << bit
                code[values] = matrix[i, j]
                values += 1
            bit += 1
            if bit == bits:
                code[at] = word
                at += 1
                bit, word = 0, 0
    if bit:
        code[at] = word
    return values - base


@kernel()
def encode_after(kept, start, clocks, before, ends, code, base, bits, top):  # type: ignore[no-untyped-def]
    """Write the record of what `matrix_after` would write, from a position on; return its length."""
    for a in range(clocks):
        code[base + a] = min(ends[0, a], top)
        code[base + clocks + a] = ends[1, a]
    at = base + 2 * clocks
    values = at + (clocks * (clocks - 1) + bits - 1) // bits
    bit, word = 0, 0
    for a in range(clocks):
        i = kept[start + a]
        if i == 0:  # its bounds are the only ones, so no bit is set
            bit += clocks - 1
            while bit >= bits:
                code[at] = word
                at += 1
                bit -= bits
                word = 0
            continue
        upper = ends[0, a]
        for b in range(clocks):
            if a == b:
                continue
            j = kept[start + b]
            if j and before[i, j] < plus(upper, ends[1, b]):
                word |= 1 << bit
                code[values] = before[i, j]
                values += 1
            bit += 1
            if bit == bits:
                code[at] = word
                at += 1
                bit, word = 0, 0
    if bit:
        code[at] = word
    return values - base


@kernel()
def decode(codes, first, clocks, matrix, bits, top):  # type: ignore[no-untyped-def]
    """Write the matrix of the class whose record starts at a position."""
    matrix[0, 0] = ZERO
    for i in range(1, clocks + 1):
        upper = codes[first + i - 1]
        matrix[i, 0] = UNBOUNDED if upper == top else upper
        matrix[0, i] = codes[first + clocks + i - 1]
    at = first + 2 * clocks
    values = at + (clocks * (clocks - 1) + bits - 1) // bits
    bit = 0
    for i in range(1, clocks + 1):
        for j in range(1, clocks + 1):
            if i == j:
                matrix[i, j] = ZERO
                continue
            if codes[at] >> bit & 1:
                matrix[i, j] = codes[values]
                values += 1
            else:
                matrix[i, j] = plus(matrix[i, 0], matrix[0, j])
            bit += 1
            if bit == bits:
                at += 1
                bit = 0


@kernel(inline="always")
def hash_record(marking, codes, first, length):  # type: ignore[no-untyped-def]
    """Hash of a record of a marking."""
    code = mixed(0, marking)
    for at in range(first, first + length):
        code = mixed(code, codes[at])
    return finished(code)


@kernel()
def find_record(table, markings, starts, codes, marking, code, base, length, value):  # type: ignore[no-untyped-def]
    """Return the class of a record with a hash, and its slot; if there is none, -1 and a free slot."""
    mask = table.size - 1
    slot, tag = value & mask, value >> TAG_SHIFT
    while table[slot] != 0:
        entry = table[slot]
        if entry >> INDEX_BITS == tag:
            number = (entry & INDEX_MASK) - 1
            if markings[number] == marking:
                first = starts[number]
                at = 0
                while at < length and codes[first + at] == code[base + at]:
                    at += 1
                if at == length:
                    return number, slot
        slot = (slot + 1) & mask
    return UNKNOWN, slot


@kernel()
def append(control, markings, starts, codes, marking, code, base, length):  # type: ignore[no-untyped-def]
    """Store a record that is new."""
    number, first = control[CLASSES], control[CODES]
    for at in range(length):
        codes[first + at] = code[base + at]
    markings[number] = marking
    starts[number + 1] = first + length
    control[CLASSES] = number + 1
    control[CODES] = first + length
    return number


@kernel()
def find_classes_again(known):  # type: ignore[no-untyped-def]
    """Put all classes into a fresh table."""
    mask = known.class_table.size - 1
    for number in range(known.control[CLASSES]):
        first = known.record_start[number]
        value = hash_record(
            known.class_marking[number], known.codes, first, known.record_start[number + 1] - first
        )
        slot = value & mask
        while known.class_table[slot] != 0:
            slot = (slot + 1) & mask
        known.class_table[slot] = (value >> TAG_SHIFT) << INDEX_BITS | (number + 1)


@kernel()
def is_within(known, number, clocks, matrix, bits, top):  # type: ignore[no-untyped-def]
    """Whether a matrix in normal form allows only what a class allows: it keeps each bound of the record."""
    codes, first = known.codes, known.record_start[number]
    for i in range(1, clocks + 1):
        upper = codes[first + i - 1]
        if (upper != top and matrix[i, 0] > upper) or matrix[0, i] > codes[first + clocks + i - 1]:
            return False
    at = first + 2 * clocks
    values = at + (clocks * (clocks - 1) + bits - 1) // bits
    bit = 0
    for i in range(1, clocks + 1):
        for j in range(1, clocks + 1):
            if i == j:
                continue
            if codes[at] >> bit & 1:
                if matrix[i, j] > codes[values]:
                    return False
                values += 1
            bit += 1
            if bit == bits:
                at += 1
                bit = 0
    return True


@kernel()
def covers(known, number, clocks, matrix, other, bits, top):  # type: ignore[no-untyped-def]
    """Whether a matrix allows all that a class allows; `other` is room for the matrix of the class."""
    codes, first = known.codes, known.record_start[number]
    for i in range(1, clocks + 1):
        upper = codes[first + i - 1]
        if (upper == top and matrix[i, 0] < UNBOUNDED) or (upper != top and upper > matrix[i, 0]):
            return False
        if codes[first + clocks + i - 1] > matrix[0, i]:
            return False
    decode(codes, first, clocks, other, bits, top)
    for i in range(1, clocks + 1):
        for j in range(1, clocks + 1):
            if other[i, j] > matrix[i, j]:
                return False
    return True
