"""The product of a net and an automaton as tables for the kernels, rebuilt when a cell is widened."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.explicit.goals import goal_tables
from dineros.analysis.explicit.kernels.markings import rebuild, repack
from dineros.analysis.explicit.layout import Layout, layout, signed
from dineros.analysis.explicit.tables import NetTables, ints
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.graphs.tables import edge_tables, step_tables
from dineros.analysis.logic.kernels.product import (
    BITS,
    OVERFLOW_STATE,
    STATES,
    Conditions,
    Edges,
    Scratch,
    Store,
)
from dineros.analysis.logic.language.atoms import (
    Combined,
    Condition,
    Linear,
    NoneEnabled,
    SomeEnabled,
    SomeFired,
)
from dineros.analysis.nets.compiled import CompiledNet

OPERATOR_CODES = {"<=": 0, ">=": 1, "==": 2, "!=": 3, "<": 4, ">": 5}


class Product:
    """A net, an automaton that reads its runs, and fair transitions, with the states found so far.

    Parameters
    ----------
    conditions : sequence of Condition or Combined
        The conditions of the automaton's atoms, in order.
    weak, strong : sequence of int
        Weakly and strongly fair transitions.
    cells : Layout, optional
        The layout of the net's markings, if it is known.
    stored : Product, optional
        A product of the same net and automaton, whose states are taken over; it is not used any more.

    Raises
    ------
    BudgetExceededError
        A place may have more tokens than fit into a word.
    """

    def __init__(
        self,
        net: CompiledNet,
        automaton: Automaton,
        conditions: Sequence[Condition | Combined],
        weak: Sequence[int],
        strong: Sequence[int],
        budget: Budget,
        cells: Layout | None = None,
        stored: Product | None = None,
    ) -> None:
        self.net, self.automaton, self.budget = net, automaton, budget
        self.atom_conditions = conditions
        self.weak, self.strong = tuple(weak), tuple(strong)
        try:
            #: Of the net alone.
            self.cells: Layout = stored.cells if stored else cells or net.once(layout)
        except OverflowError as error:
            raise BudgetExceededError(f"tokens: {error}") from None
        self._build_tables()
        transitions, words = len(net.transitions), self.layout.words
        degree = max(1, *map(len, automaton.edges))
        #: Maximum number of successors of one state.
        self.room = (transitions + 1) * degree
        self.scratch = Scratch(
            np.zeros(transitions + 1, dtype=np.int64),
            np.zeros_like(self.tables.fired),
            np.zeros(degree, dtype=np.int64),
            np.zeros(self.conditions.fired_atoms.size, dtype=np.int64),
            np.zeros(max(1, self.conditions.combined_code.size), dtype=np.int64),
            np.zeros(self.conditions.required.size, dtype=np.int64),
            np.zeros(self.conditions.required.size, dtype=np.int64),
            np.zeros((self.room, words), dtype=np.int64),
            np.zeros(self.room, dtype=np.int64),
        )
        if stored is not None:
            self.store: Store = stored.store
            return
        capacity = max(1 << 12, 2 * self.room)
        self.store = Store(
            np.empty((capacity, words), dtype=np.int64),
            np.zeros(_table_size(capacity), dtype=np.int64),
            np.zeros(3, dtype=np.int64),
        )
        self.store.words[0] = self.layout.pack(net.initial.tolist())
        # The state may be in the highest bits of its word.
        self.store.words[0, self.edges.state_word] += signed([automaton.initial << self.edges.state_shift])[0]
        self.store.counters[STATES] = 1
        self._fill_table()

    @property
    def parts(self) -> tuple[NetTables, Conditions, Edges, Store, Scratch]:
        """The arguments of kernels, in order."""
        return self.tables, self.conditions, self.edges, self.store, self.scratch

    @property
    def states(self) -> int:
        """Number of states stored."""
        return int(self.store.counters[STATES])

    @property
    def memory_bytes(self) -> int:
        """Bytes of the table of states."""
        return self.store.words.nbytes + self.store.table.nbytes

    def progress(self, memory_bytes: int) -> Progress:
        """Return the progress of a search whose tables have this size."""
        return Progress("states", self.states, memory_bytes, self.states / max(self.budget.spent, 1e-9))

    def marking(self, state: int) -> tuple[int, ...]:
        """Return the marking of a state."""
        return tuple(self.layout.unpack(self.store.words[state]))

    def marks_of(self, labels: NDArray[np.int32]) -> NDArray[np.int64]:
        """Return the marks of edges with these labels."""
        steps, edges = np.divmod(labels, self.edges.target.size)
        conditions = self.conditions
        marks: NDArray[np.int64] = (conditions.weak_marks | conditions.strong_marks)[steps]
        marks |= self.edges.marks[edges]
        return marks

    def grow(self, others: int = 0) -> None:
        """Allocate memory for more states.

        Parameters
        ----------
        others : int
            Size of other tables in bytes, which count against the memory budget, too.

        Raises
        ------
        BudgetExceededError
            The memory is not sufficient.
        """
        capacity = len(self.store.words)
        larger = capacity * 2 if capacity < 1 << 20 else capacity * 3 // 2
        limit = self.budget.states
        if limit is not None:
            # Slightly more than the limit, so that exceeding it is noticed.
            larger = min(larger, max(capacity + self.room, limit + 2 * self.room))
        if larger >= 2**31:
            raise BudgetExceededError("states: more than 2147483647")
        table_size = _table_size(larger)
        new_bytes = larger * self.layout.words * 8 + (
            0 if table_size == self.store.table.size else table_size * 8
        )
        self.budget.check_memory(self.memory_bytes + new_bytes + others)
        words = np.empty((larger, self.layout.words), dtype=np.int64)
        words[: self.states] = self.store.words[: self.states]
        table = self.store.table
        self.store = Store(words, table, self.store.counters)
        if table.size != table_size:
            del table
            self.store = Store(words, np.zeros(table_size, dtype=np.int64), self.store.counters)
            self._fill_table()

    def widen(self, others: int = 0) -> None:
        """Widen the cells that are too small for a successor of the state recorded by the last expansion.

        Raises
        ------
        BudgetExceededError
            The memory is not sufficient, or tokens exceed any cell.
        """
        old, before, counters = self.layout, self.tables, self.store.counters
        marking = self.marking(int(counters[OVERFLOW_STATE]))
        try:
            self.cells = self.cells.widened(old.overflowing(self.net, marking))
        except OverflowError as error:
            raise BudgetExceededError(f"tokens: {error}") from None
        self._build_tables()
        capacity, after = len(self.store.words), self.tables
        self.budget.check_memory(self.memory_bytes + capacity * self.layout.words * 8 + others)
        words = np.empty((capacity, self.layout.words), dtype=np.int64)
        repack(
            self.store.words,
            words,
            self.states,
            before.word,
            before.shift,
            before.mask,
            after.word,
            after.shift,
        )
        self.store.table[:] = 0
        self.store = Store(words, self.store.table, counters)
        self.scratch = self.scratch._replace(box=np.zeros((self.room, self.layout.words), dtype=np.int64))
        self._fill_table()

    def _fill_table(self) -> None:
        """Enter all states into an empty table."""
        rebuild(self.tables.guards, self.store.words, self.store.table, 0, self.states)

    def _build_tables(self) -> None:
        self.layout = self.cells.with_number(len(self.automaton.edges))
        self.tables = step_tables(self.net, self.layout)
        self.conditions = self._conditions()
        letter_words, mark_words = self.conditions.fired_atoms.size, self.conditions.required.size
        self.edges = edge_tables(self.automaton, self.layout, letter_words, mark_words)

    def _conditions(self) -> Conditions:
        transitions = len(self.net.transitions)
        bits, programs = _bits_of(self.atom_conditions)
        linear = [(i, c) for i, c in enumerate(bits) if isinstance(c, Linear)]
        terms = goal_tables(self.layout, [[(tuple(c.factors.items()), c.bound) for _, c in linear]])
        words = max(1, -(-len(bits) // BITS))
        enabled_bits = np.zeros((transitions + 1, words), dtype=np.int64)
        fired_bits = np.zeros((transitions + 1, words), dtype=np.int64)
        deadlock_bits = np.zeros(words, dtype=np.int64)
        fired_atoms = np.zeros(words, dtype=np.int64)
        for i, condition in enumerate(bits):
            word, bit = i // BITS, 1 << (i % BITS)
            match condition:
                case SomeEnabled(chosen):
                    enabled_bits[list(chosen), word] |= bit
                case SomeFired(chosen):
                    fired_bits[list(chosen), word] |= bit
                    fired_atoms[word] |= bit
                case NoneEnabled():
                    deadlock_bits[word] |= bit
        marks = self.automaton.marks
        total = marks + len(self.weak) + len(self.strong)
        weak_marks = _mark_rows(self.weak, marks, total, transitions)
        strong_marks = _mark_rows(self.strong, marks + len(self.weak), total, transitions)
        all_weak = np.bitwise_or.reduce(weak_marks, axis=0)
        required = all_weak.copy()
        for mark in range(marks):
            required[mark // BITS] |= 1 << (mark % BITS)
        return Conditions(
            terms.term_start,
            terms.term_cell,
            terms.term_offset,
            terms.term_factor,
            terms.table,
            ints(OPERATOR_CODES[c.operator] for _, c in linear),
            ints(c.bound for _, c in linear),
            ints(i for i, _ in linear),
            int(enabled_bits.any()),
            enabled_bits,
            fired_bits,
            deadlock_bits,
            fired_atoms,
            ints(np.cumsum([0, *map(len, programs.values())])),
            ints(code for program in programs.values() for code in program),
            ints(programs),
            weak_marks,
            strong_marks,
            all_weak,
            required,
        )


def _bits_of(
    conditions: Sequence[Condition | Combined],
) -> tuple[list[Condition | Combined], dict[int, list[int]]]:
    """Return the condition of each bit of a letter, and the program of each combination, by its bit.

    The automaton's atoms come first, then the parts of combinations, which are not combinations themselves.
    """
    bits = list(conditions)
    programs: dict[int, list[int]] = {}
    for bit, condition in enumerate(conditions):
        if isinstance(condition, Combined):
            first = len(bits)
            bits += condition.parts
            programs[bit] = [code if code < 0 else first + code for code in condition.program]
    return bits, programs


def _mark_rows(
    fair: Sequence[int], first: int, total: int, transitions: int
) -> np.ndarray[tuple[int, int], np.dtype[np.int64]]:
    rows = np.zeros((transitions + 1, max(1, -(-total // BITS))), dtype=np.int64)
    for i, t in enumerate(fair):
        mark = first + i
        rows[t, mark // BITS] |= 1 << (mark % BITS)
    return rows


def _table_size(capacity: int) -> int:
    """Return the power of two that keeps the table at most half full."""
    return 1 << (2 * capacity - 1).bit_length()
