"""The product of a net and an automaton as tables for the kernels, rebuilt when a field is widened."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from dineros.analysis.answers.budget import Budget, BudgetExceededError, Progress
from dineros.analysis.logic.automata.automaton import Automaton
from dineros.analysis.logic.graphs.packing import Layout
from dineros.analysis.logic.graphs.tables import edge_tables, ints, net_tables
from dineros.analysis.logic.kernels.product import (
    BITS,
    OVERFLOW_STATE,
    OVERFLOW_TRANSITION,
    STATES,
    Conditions,
    Scratch,
    Store,
    fill_table,
)
from dineros.analysis.logic.language.atoms import (
    Combined,
    Condition,
    Linear,
    NoneEnabled,
    SomeEnabled,
    SomeFired,
)
from dineros.analysis.nets.bounds import place_bounds
from dineros.analysis.nets.compiled import CompiledNet

MANY_STATES = 10_000
"""States from which on widening a field is worth some thought."""

OPERATOR_CODES = {"<=": 0, ">=": 1, "==": 2, "!=": 3, "<": 4, ">": 5}


class Product:
    """A net, an automaton that reads its runs, and fair transitions, with the states found so far.

    Parameters
    ----------
    net : CompiledNet
    automaton : Automaton
    conditions : sequence of Condition or Combined
        What the automaton's atoms ask, in their order.
    weak, strong : sequence of int
        Weakly and strongly fair transitions.
    budget : Budget
        Watches the memory.
    """

    def __init__(
        self,
        net: CompiledNet,
        automaton: Automaton,
        conditions: Sequence[Condition | Combined],
        weak: Sequence[int],
        strong: Sequence[int],
        budget: Budget,
    ) -> None:
        self.net, self.automaton, self.budget = net, automaton, budget
        self.atom_conditions = conditions
        self.weak, self.strong = tuple(weak), tuple(strong)
        self.layout = Layout.smallest(net, max(1, (len(automaton.edges) - 1).bit_length()))
        self._build_tables()
        transitions, words = len(net.transitions), self.layout.words
        degree = max(1, *map(len, automaton.edges))
        #: Most successors of one state.
        self.room = (transitions + 1) * degree
        self.scratch = Scratch(
            np.zeros(transitions + 1, dtype=np.int64),
            np.zeros(degree, dtype=np.int64),
            np.zeros(self.conditions.fired_atoms.size, dtype=np.int64),
            np.zeros(max(1, self.conditions.combined_code.size), dtype=np.int64),
            np.zeros(self.conditions.required.size, dtype=np.int64),
            np.zeros(self.conditions.required.size, dtype=np.int64),
            np.zeros(words, dtype=np.uint64),
            *(np.zeros(self.room, dtype=np.uint64) for _ in range(3)),
        )
        capacity = max(1 << 12, 2 * self.room)
        self.store = Store(
            np.empty((capacity, words), dtype=np.uint64),
            np.zeros(_table_size(capacity), dtype=np.uint64),
            np.zeros(4, dtype=np.int64),
        )
        self.store.words[0] = self.layout.pack(net.initial.tolist(), automaton.initial)
        self.store.counters[STATES] = 1
        fill_table(self.store, self.tables.multipliers)

    @property
    def states(self) -> int:
        """Number of states stored."""
        return int(self.store.counters[STATES])

    @property
    def memory_bytes(self) -> int:
        """Bytes of the table of states."""
        return self.store.words.nbytes + self.store.table.nbytes

    def progress(self, memory_bytes: int) -> Progress:
        """Return how far a search is whose tables take so many bytes."""
        return Progress("states", self.states, memory_bytes, self.states / max(self.budget.spent, 1e-9))

    def marking(self, state: int) -> tuple[int, ...]:
        """Return the marking of a state."""
        return self.layout.unpack(self.store.words[state])

    def grow(self, others: int = 0) -> None:
        """Make room for more states.

        Parameters
        ----------
        others : int
            Bytes of tables elsewhere, counted against the memory budget too.

        Raises
        ------
        BudgetExceededError
            When there is no memory left for it.
        """
        capacity = len(self.store.words)
        larger = capacity * 2 if capacity < 1 << 20 else capacity * 3 // 2
        limit = self.budget.states
        if limit is not None:
            # A little more than the limit, so that hitting it is seen as such.
            larger = min(larger, max(capacity + self.room, limit + 2 * self.room))
        if larger >= 2**31:
            raise BudgetExceededError("states: more than 2147483647")
        table_size = _table_size(larger)
        new_bytes = larger * self.layout.words * 8 + (
            0 if table_size == self.store.table.size else table_size * 8
        )
        self.budget.check_memory(self.memory_bytes + new_bytes + others)
        words = np.empty((larger, self.layout.words), dtype=np.uint64)
        words[: self.states] = self.store.words[: self.states]
        table = self.store.table
        self.store = Store(words, table, self.store.counters)
        if table.size != table_size:
            del table
            self.store = Store(words, np.zeros(table_size, dtype=np.uint64), self.store.counters)
            fill_table(self.store, self.tables.multipliers)

    def widen(self, others: int = 0) -> None:
        """Widen the fields that the successor noted by the last expansion did not fit into.

        Raises
        ------
        BudgetExceededError
            When there is no memory left for it, or tokens grow beyond any field.
        """
        counters = self.store.counters
        marking = list(self.marking(int(counters[OVERFLOW_STATE])))
        for place, tokens in self.net.delta[int(counters[OVERFLOW_TRANSITION])].items():
            marking[place] += tokens
        if self.states > MANY_STATES:
            self._anticipate(marking)
        try:
            layout = self.layout.widened(marking)
        except OverflowError as error:
            raise BudgetExceededError(f"tokens: {error}") from None
        count, capacity = self.states, len(self.store.words)
        if layout.words == self.layout.words:
            chunk = 1 << 16
            for first in range(0, count, chunk):
                part = self.store.words[first : min(first + chunk, count)]
                part[:] = self.layout.convert(part, layout)
            words = self.store.words
        else:
            self.budget.check_memory(self.memory_bytes + capacity * layout.words * 8 + others)
            words = np.empty((capacity, layout.words), dtype=np.uint64)
            words[:count] = self.layout.convert(self.store.words[:count], layout)
            self.scratch = self.scratch._replace(successor=np.zeros(layout.words, dtype=np.uint64))
        self.store.table[:] = 0
        self.store = Store(words, self.store.table, counters)
        self.layout = layout
        self._build_tables()
        fill_table(self.store, self.tables.multipliers)

    def _anticipate(self, marking: list[int]) -> None:
        """Raise tokens that are likely to outgrow their fields soon, so that the states are converted once.

        Those are the places with fields as wide as the one too small now, unless they are proved to hold at
        most one token.
        """
        bits = self.layout.bits
        narrow = {have for have, tokens in zip(bits, marking, strict=True) if tokens.bit_length() > have}
        safe = {p for p, bound in enumerate(place_bounds(self.net)) if bound is not None and bound.value <= 1}
        for place, have in enumerate(bits):
            if have in narrow and place not in safe:
                marking[place] = max(marking[place], 1 << have)

    def _build_tables(self) -> None:
        self.tables = net_tables(self.net, self.layout)
        self.conditions = self._conditions()
        letter_words, mark_words = self.conditions.fired_atoms.size, self.conditions.required.size
        self.edges = edge_tables(self.automaton, self.layout, letter_words, mark_words)

    def _conditions(self) -> Conditions:
        transitions = len(self.net.transitions)
        bits, programs = _bits_of(self.atom_conditions)
        linear = [(i, c) for i, c in enumerate(bits) if isinstance(c, Linear)]
        pointer = np.cumsum([0, *(len(c.factors) for _, c in linear)])
        places = [p for _, c in linear for p in c.factors]
        fields = [self.layout.fields[p] for p in places]
        masks = [(1 << self.layout.bits[p]) - 1 for p in places]
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
            ints(pointer),
            ints(word for word, _ in fields),
            np.array([shift for _, shift in fields], dtype=np.uint64),
            np.array(masks, dtype=np.uint64),
            ints(k for _, c in linear for k in c.factors.values()),
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
    """Return what each bit of a letter means, and programs over bits by the bit of each combination.

    The automaton's atoms come first, then what combinations are made of, in which there are no others.
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
