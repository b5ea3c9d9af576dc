"""Kernel of the refinement of strong classes into atomic ones.

An edge leads from a class, by a transition, into a class. It is stable if each state of the first class has a
successor in the second; else the first class is cut into those that have one and those that have none. A
class that comes to hold the same states as another one is the same class. For most nets, the classes that are
left do not depend on the order of the cuts; for large ones they can differ by a few.
"""

from __future__ import annotations

import numpy as np

from dineros.analysis.nets.kernel_cache import kernel
from dineros.analysis.timed.kernels.edges import (
    CELLS,
    CLASSES,
    EDGES,
    INITIAL,
    NONE,
    OPEN,
    QUEUED,
    STABLE,
    add_edge,
    drop_edge,
    has_edge,
    open_edge,
    take_class,
)
from dineros.analysis.timed.kernels.partitions import (
    add_class,
    change,
    holds_zero,
    let_go,
    load,
    same_class,
)
from dineros.analysis.timed.kernels.preimages import (
    allows_all,
    are_apart,
    copy,
    lead_into,
    needed_bounds,
    tighten,
)
from dineros.analysis.timed.kernels.records import decode

(REFINED, GOES_ON, WANTS_ROOM, WANTS_TABLE) = range(4)


@kernel(nogil=True)
def refine(net, known, atoms, work, most):  # type: ignore[no-untyped-def]
    """Check the edges to a limited number of classes; return why the check ended."""
    control = atoms.control
    for _ in range(most):
        if control[QUEUED] == 0:
            return REFINED
        if control[CLASSES] > atoms.table.size:
            return WANTS_TABLE
        target = take_class(atoms)
        count = edges_to(atoms, target, work.edges, True)
        if count > work.edges.size:
            return WANTS_ROOM
        if count and not check(net, known, atoms, work, target, count):
            return WANTS_ROOM
    return GOES_ON


@kernel()
def edges_to(atoms, target, found, only_open):  # type: ignore[no-untyped-def]
    """Write the edges to a class, those of a transition together; how many.

    These are either those that may not be stable, or those from other classes. If they do not fit, only
    the number is right.
    """
    count = 0
    edge = atoms.first_in[target]
    while edge != NONE:
        if atoms.state[edge] == OPEN if only_open else atoms.source[edge] != target:
            if count < found.size:
                found[count] = np.int64(atoms.at[edge]) << 32 | edge
            count += 1
        edge = atoms.next_in[edge]
    if count <= found.size:
        found[:count].sort()
    return count


@kernel()
def check(net, known, atoms, work, target, count):  # type: ignore[no-untyped-def]
    """Look which edges to a class are stable, and cut the sources of others; whether there was room.

    The predecessors of the class are computed once for each transition. Once the class itself is cut, the
    rest waits until its turn comes again.
    """
    matrix, before, room = work.matrix, work.before, work.room
    last, leads = NONE, False
    for k in range(count):
        edge = work.edges[k] & 0xFFFFFFFF
        at = work.edges[k] >> 32
        if atoms.state[edge] != OPEN or atoms.target[edge] != target or atoms.at[edge] != at:
            continue  # it went with a class that was cut before
        source = atoms.source[edge]
        row = atoms.marking[source]
        clocks = known.clocks[row]
        if at != last:
            load(atoms, target, known.clocks[atoms.marking[target]], room)
            leads, last = lead_into(net, known, row, at, room, before), at
        if not leads:
            drop_edge(atoms, edge)
            continue
        load(atoms, source, clocks, matrix)
        if allows_all(before, clocks, matrix):
            atoms.state[edge] = STABLE
            continue
        cuts = needed_bounds(matrix, clocks, before, work.facets, room)
        if cuts < 0:
            drop_edge(atoms, edge)
            continue
        if not has_room_to_split(atoms, work, source, clocks, cuts):
            return False
        atoms.state[edge] = STABLE
        split(net, known, atoms, work, edge, cuts)
        if source == target:
            break
    return True


@kernel()
def has_room_to_split(atoms, work, number, clocks, pieces):  # type: ignore[no-untyped-def]
    """Whether there is room to cut a class into this number of further pieces."""
    control = atoms.control
    degree = 0
    edge = atoms.first_out[number]
    while edge != NONE:
        degree += pieces + 1
        edge = atoms.next_out[edge]
    edge = atoms.first_in[number]
    while edge != NONE:
        degree += 1
        edge = atoms.next_in[edge]
    return (
        degree < work.incoming.size
        and control[CLASSES] + pieces < atoms.marking.size
        and control[CELLS] + pieces * (clocks + 1) * (clocks + 1) < atoms.bounds.size
        and control[EDGES] + (pieces + 1) * degree < atoms.source.size
    )


@kernel()
def split(net, known, atoms, work, edge, cuts):  # type: ignore[no-untyped-def]
    """Cut the source of an edge into the states that lead into its target, and pieces of the others."""
    control, pieces = atoms.control, work.pieces
    source = atoms.source[edge]
    row = atoms.marking[source]
    clocks = known.clocks[row]
    matrix, before, room = work.matrix, work.before, work.room
    is_initial = control[INITIAL] == source
    first_new = control[CLASSES]
    for cut in range(cuts):
        i, j = work.facets[cut, 0], work.facets[cut, 1]
        copy(matrix, clocks, room)
        tighten(room, clocks, j, i, 1 - before[i, j])
        tighten(matrix, clocks, i, j, before[i, j])
        piece = same_class(atoms, row, clocks, room)
        if piece == NONE:
            piece = add_class(atoms, row, clocks, room)
        pieces[cut] = piece
        if is_initial and holds_zero(room, clocks):
            control[INITIAL] = piece
    other = same_class(atoms, row, clocks, matrix)
    change(atoms, source, clocks, matrix)
    incoming = edges_to(atoms, source, work.incoming, False)
    for cut in range(cuts):
        link_to_piece(net, known, atoms, work, incoming, pieces[cut], pieces[cut] < first_new)
    keep_links(net, known, atoms, work, incoming, source)
    link_from_pieces(atoms, edge, pieces, cuts, first_new)
    if other != NONE:
        merge(atoms, source, other)


@kernel()
def link_to_piece(net, known, atoms, work, incoming, piece, is_known):  # type: ignore[no-untyped-def]
    """Let what leads to a class that is cut lead to a piece of it, if some state leads there."""
    other, lead = work.other, work.lead
    last, leads = NONE, False
    for k in range(incoming):
        edge = work.incoming[k] & 0xFFFFFFFF
        at = work.incoming[k] >> 32
        start = atoms.source[edge]
        row = atoms.marking[start]
        if at != last:
            load(atoms, piece, known.clocks[atoms.marking[piece]], other)
            leads, last = lead_into(net, known, row, at, other, lead), at
        if not leads:
            continue
        load(atoms, start, known.clocks[row], other)
        if not are_apart(other, known.clocks[row], lead) and not (
            is_known and has_edge(atoms, start, at, piece)
        ):
            add_edge(atoms, start, at, piece, allows_all(lead, known.clocks[row], other))


@kernel()
def keep_links(net, known, atoms, work, incoming, number):  # type: ignore[no-untyped-def]
    """Look again which edges lead to a class that has become smaller."""
    other, lead = work.other, work.lead
    last, leads = NONE, False
    for k in range(incoming):
        edge = work.incoming[k] & 0xFFFFFFFF
        at = work.incoming[k] >> 32
        start = atoms.source[edge]
        row = atoms.marking[start]
        if at != last:
            load(atoms, number, known.clocks[atoms.marking[number]], other)
            leads, last = lead_into(net, known, row, at, other, lead), at
        load(atoms, start, known.clocks[row], other)
        if not leads or are_apart(other, known.clocks[row], lead):
            drop_edge(atoms, edge)
        elif allows_all(lead, known.clocks[row], other):
            atoms.state[edge] = STABLE
        else:
            open_edge(atoms, edge)


@kernel()
def link_from_pieces(atoms, edge, pieces, count, first_new):  # type: ignore[no-untyped-def]
    """Let pieces of a class lead to where it leads; those from `first_new` on have no edges from them yet.

    An edge from a piece is as stable as it was, unless it leads to the class itself. The edge that was the
    reason for the cut leads from no piece.
    """
    source = atoms.source[edge]
    number = atoms.first_out[source]
    while number != NONE:
        after = atoms.next_out[number]
        at, target = atoms.at[number], atoms.target[number]
        if target == source:
            open_edge(atoms, number)
            for k in range(count):
                if not has_edge(atoms, source, at, pieces[k]):
                    add_edge(atoms, source, at, pieces[k], False)
        if number != edge:
            for k in range(count):
                if pieces[k] < first_new:
                    continue
                if not has_edge(atoms, pieces[k], at, target):
                    add_edge(atoms, pieces[k], at, target, target != source and atoms.state[number] == STABLE)
                if target == source:
                    for other in range(count):
                        if not has_edge(atoms, pieces[k], at, pieces[other]):
                            add_edge(atoms, pieces[k], at, pieces[other], False)
        number = after


@kernel()
def merge(atoms, number, other):  # type: ignore[no-untyped-def]
    """Remove a class with the same states as another one: edges to it lead to that one."""
    if atoms.control[INITIAL] == number:
        atoms.control[INITIAL] = other
    edge = atoms.first_in[number]
    while edge != NONE:
        after = atoms.next_in[edge]
        start, at = atoms.source[edge], atoms.at[edge]
        if start != number and not has_edge(atoms, start, at, other):
            add_edge(atoms, start, at, other, atoms.state[edge] == STABLE)
        drop_edge(atoms, edge)
        edge = after
    while atoms.first_out[number] != NONE:
        drop_edge(atoms, atoms.first_out[number])
    let_go(atoms, number)


@kernel()
def begin(known, atoms, work, final, bits, top):  # type: ignore[no-untyped-def]
    """Copy strong classes and their edges; `final` maps a class to the class that contains it."""
    numbers = work.numbers
    for old in range(final.size):
        if final[old] == old:
            marking = known.class_marking[old]
            decode(known.codes, known.record_start[old], known.clocks[marking], work.matrix, bits, top)
            numbers[old] = add_class(atoms, marking, known.clocks[marking], work.matrix)
    atoms.control[INITIAL] = numbers[final[0]]
    for old in range(final.size):
        if final[old] != old:
            continue
        row, source = known.class_marking[old], numbers[old]
        for edge in range(known.edge_first[old], known.edge_last[old]):
            at = known.enabled_start[row]
            while known.enabled[at] != known.edge_label[edge]:
                at += 1
            target = numbers[final[known.edge_target[edge]]]
            if not has_edge(atoms, source, at, target):
                add_edge(atoms, source, at, target, False)
