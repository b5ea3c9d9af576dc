"""Kernels for classes that are cut: the matrix of each, and a table that finds equal ones."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.edges import ALIVE, CELLS, CLASSES, NONE
from dineros.analysis.timed.kernels.markings import finished, mixed
from dineros.analysis.timed.kernels.records import UNBOUNDED, ZERO


@kernel()
def load(atoms, number, clocks, matrix):  # type: ignore[no-untyped-def]
    """Write the matrix of a class."""
    at, top = atoms.cell[number], atoms.top[0]
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            bound = atoms.bounds[at]
            matrix[i, j] = UNBOUNDED if bound == top else bound
            at += 1


@kernel()
def store(atoms, number, clocks, matrix):  # type: ignore[no-untyped-def]
    """Keep a matrix as that of a class, and put the class into the table."""
    at, top = atoms.cell[number], atoms.top[0]
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            atoms.bounds[at] = min(matrix[i, j], top)
            at += 1
    code = hash_of(atoms.marking[number], clocks, matrix)
    slot = code & (atoms.table.size - 1)
    atoms.code[number] = code
    atoms.next_class[number] = atoms.table[slot]
    atoms.table[slot] = number


@kernel()
def hash_of(marking, clocks, matrix):  # type: ignore[no-untyped-def]
    """Hash of a marking and a matrix."""
    code = mixed(0, marking)
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            code = mixed(code, matrix[i, j])
    return finished(code)


@kernel()
def add_class(atoms, marking, clocks, matrix):  # type: ignore[no-untyped-def]
    """Return the number of a class that is new; there must be room."""
    control = atoms.control
    number = control[CLASSES]
    control[CLASSES] += 1
    control[ALIVE] += 1
    atoms.marking[number] = marking
    atoms.is_alive[number] = 1
    atoms.cell[number] = control[CELLS]
    control[CELLS] += (clocks + 1) * (clocks + 1)
    store(atoms, number, clocks, matrix)
    atoms.first_out[number] = NONE
    atoms.first_in[number] = NONE
    return number


@kernel()
def forget(atoms, number):  # type: ignore[no-untyped-def]
    """Take a class out of the table."""
    slot = atoms.code[number] & (atoms.table.size - 1)
    other = atoms.table[slot]
    if other == number:
        atoms.table[slot] = atoms.next_class[number]
        return
    while atoms.next_class[other] != number:
        other = atoms.next_class[other]
    atoms.next_class[other] = atoms.next_class[number]


@kernel()
def change(atoms, number, clocks, matrix):  # type: ignore[no-untyped-def]
    """Give a class another matrix."""
    forget(atoms, number)
    store(atoms, number, clocks, matrix)


@kernel()
def let_go(atoms, number):  # type: ignore[no-untyped-def]
    """Let a class go that has no edges any more."""
    forget(atoms, number)
    atoms.is_alive[number] = 0
    atoms.control[ALIVE] -= 1


@kernel()
def same_class(atoms, marking, clocks, matrix):  # type: ignore[no-untyped-def]
    """Return the class of a matrix; -1 if there is none."""
    code, top = hash_of(marking, clocks, matrix), atoms.top[0]
    number = atoms.table[code & (atoms.table.size - 1)]
    while number != NONE:
        if atoms.code[number] == code and atoms.marking[number] == marking:
            at, is_same = atoms.cell[number], True
            for i in range(clocks + 1):
                for j in range(clocks + 1):
                    is_same &= atoms.bounds[at] == min(matrix[i, j], top)
                    at += 1
            if is_same:
                return number
        number = atoms.next_class[number]
    return NONE


@kernel()
def find_again(atoms):  # type: ignore[no-untyped-def]
    """Put all classes into a fresh table, which holds -1 everywhere."""
    for number in range(atoms.control[CLASSES]):
        if atoms.is_alive[number]:
            slot = atoms.code[number] & (atoms.table.size - 1)
            atoms.next_class[number] = atoms.table[slot]
            atoms.table[slot] = number


@kernel()
def holds_zero(matrix, clocks):  # type: ignore[no-untyped-def]
    """Whether a matrix allows that all clocks are 0."""
    for i in range(clocks + 1):
        for j in range(clocks + 1):
            if matrix[i, j] < ZERO:
                return False
    return True
