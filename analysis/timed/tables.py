"""Tables of the state class engines: a net, and all that was found, as flat arrays."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from dineros.analysis.nets.compiled import ArcTable, Int64Array
from dineros.analysis.timed.kernels.successors import BATCH_CONTROL
from dineros.analysis.timed.nets import TimedNet


class NetTables(NamedTuple):
    """A time Petri net as kernels read it; rows of CSR tables by transition."""

    take_start: Any
    take_place: Any
    take_weight: Any
    put_start: Any
    put_place: Any
    put_weight: Any
    test_start: Any
    test_place: Any
    test_weight: Any
    inhibitor_start: Any
    inhibitor_place: Any
    inhibitor_weight: Any
    lower: Any
    upper: Any
    has_clock: Any
    above_start: Any
    above: Any


class Known(NamedTuple):
    """All that was found."""

    control: Any
    markings: Any  #: marking x place
    marking_table: Any
    enabled_start: Any  #: by marking: rows of `enabled` and `next_marking`
    clocks: Any  #: by marking: how many of its enabled transitions have a clock; these stand first
    enabled: Any
    next_marking: Any  #: by enabled transition: the marking after it, or -1
    kept_start: Any  #: by enabled transition: where in `kept` the clocks of the next marking start
    kept: Any  #: by clock of the next marking: the clock that continues, from 1, or 0
    class_marking: Any
    record_start: Any
    codes: Any
    class_table: Any
    parent: Any
    via: Any
    edge_target: Any
    edge_label: Any
    edge_first: Any
    edge_last: Any
    first_class: Any  #: by marking, where classes are compared by inclusion
    next_class: Any
    replaced_by: Any
    todo: Any


class Work(NamedTuple):
    """Room for matrices and for one marking."""

    tokens: Any
    matrix: Any
    elapsed: Any
    low: Any
    ends: Any  #: upper and lower bounds of each clock after a firing
    pieces: Any
    split: Any


class Batch(NamedTuple):
    """The successors of some classes, until they are stored."""

    control: Any
    first_item: Any  #: by class of the batch: where the items of what follows it start
    last_item: Any  #: where they end
    is_put_off: Any  #: whether a transition fires there for the first time in a marking
    pending: Any  #: by such a firing: the position of the transition in its marking
    pending_class: Any  #: the class of the batch
    fired: Any  #: by item
    marking: Any
    value: Any  #: hash of the record
    start: Any  #: where the record begins
    length: Any
    target: Any  #: the class, or -1: it was not known when the batch was looked up
    origin: Any  #: by item that was not known: the first one of a round with the same record
    record: Any


class Atoms(NamedTuple):
    """Classes that are cut until they are atomic, and the edges between them."""

    control: Any
    top: Any  #: one element: the stored bound that stands for none
    marking: Any  #: by class
    is_alive: Any
    is_queued: Any
    cell: Any  #: by class: where in `bounds` its matrix starts
    code: Any
    next_class: Any  #: by class: the next one in its slot of `table`
    first_out: Any
    first_in: Any
    table: Any
    bounds: Any
    source: Any  #: by edge
    at: Any  #: by edge: its transition's place among those that are enabled in a marking
    target: Any
    next_out: Any
    last_out: Any
    next_in: Any
    last_in: Any
    state: Any
    queue: Any  #: classes to which edges lead that may not be stable


class CuttingRoom(NamedTuple):
    """Room to look at one class, and to cut those that lead to it."""

    matrix: Any
    before: Any
    room: Any
    other: Any
    lead: Any
    facets: Any
    pieces: Any
    numbers: Any
    edges: Any
    incoming: Any


def work_for(initial: Int64Array, clocks: int, depth: int) -> Work:
    """Return room for matrices of so many clocks, and for so many pieces below one another."""
    size = clocks + 1
    return Work(
        initial.copy(),
        np.zeros((size, size), dtype=np.int64),
        np.zeros((size, size), dtype=np.int64),
        np.zeros(size, dtype=np.int64),
        np.zeros((2, size), dtype=np.int64),
        np.zeros((depth + 2, size, size), dtype=np.int64),
        np.zeros(depth + 2, dtype=np.int64),
    )


def batch_for(classes: int, items: int, words: int, *batches: int) -> Batch:
    """Return room for what follows so many classes: records, and elements of these; for so many batches."""

    def numbers(size: int) -> Int64Array:
        return np.zeros((*batches, size), dtype=np.int64)

    return Batch(
        control=numbers(BATCH_CONTROL),
        first_item=numbers(classes),
        last_item=numbers(classes),
        is_put_off=numbers(classes),
        pending=numbers(items),
        pending_class=numbers(items),
        fired=numbers(items),
        marking=numbers(items),
        value=numbers(items),
        start=numbers(items),
        length=numbers(items),
        target=numbers(items),
        origin=numbers(items),
        record=numbers(words),
    )


def net_tables(net: TimedNet) -> NetTables:
    """Return a net as kernels read it.

    Raises
    ------
    DinerosError
        A bound is too large; see `TimedNet.scaled`.
    """
    lower, upper = net.scaled()
    above = ArcTable.from_rows([dict.fromkeys(row, 1) for row in net.above])
    take, put, test, inhibitor = net.take, net.put, net.untimed.pre, net.untimed.inhibitor
    return NetTables(
        *(take.pointer, take.place, take.weight),
        *(put.pointer, put.place, put.weight),
        *(test.pointer, test.place, test.weight),
        *(inhibitor.pointer, inhibitor.place, inhibitor.weight),
        lower,
        upper,
        np.array([not interval.is_free for interval in net.intervals], dtype=np.bool_),
        above.pointer,
        above.place,
    )
