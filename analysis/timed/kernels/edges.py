"""Kernels for the edges of a class graph that changes: each is in a list of its source and of its target."""

from __future__ import annotations

from dineros.analysis.nets.kernel_cache import kernel

(CLASSES, ALIVE, CELLS, INITIAL, EDGES, LIVING_EDGES, FREE, FIRST, QUEUED) = range(9)
CONTROL_SIZE = 9
(UNUSED, STABLE, OPEN) = range(3)
"""What an edge is: its place is free, it is stable, or it may not be stable."""
NONE = -1


@kernel()
def add_edge(atoms, source, at, target, is_stable):  # type: ignore[no-untyped-def]
    """Add an edge; one that may not be stable is queued."""
    control = atoms.control
    edge = control[FREE]
    if edge == NONE:
        edge = control[EDGES]
        control[EDGES] += 1
    else:
        control[FREE] = atoms.next_out[edge]
    control[LIVING_EDGES] += 1
    atoms.source[edge] = source
    atoms.at[edge] = at
    atoms.target[edge] = target
    head = atoms.first_out[source]
    atoms.next_out[edge] = head
    atoms.last_out[edge] = NONE
    if head != NONE:
        atoms.last_out[head] = edge
    atoms.first_out[source] = edge
    head = atoms.first_in[target]
    atoms.next_in[edge] = head
    atoms.last_in[edge] = NONE
    if head != NONE:
        atoms.last_in[head] = edge
    atoms.first_in[target] = edge
    atoms.state[edge] = STABLE
    if not is_stable:
        open_edge(atoms, edge)


@kernel()
def open_edge(atoms, edge):  # type: ignore[no-untyped-def]
    """Note that an edge may not be stable any more; the class that it leads to is queued."""
    atoms.state[edge] = OPEN
    target = atoms.target[edge]
    if atoms.is_queued[target]:
        return
    control = atoms.control
    slot = control[FIRST] + control[QUEUED]
    if slot >= atoms.queue.size:
        slot -= atoms.queue.size
    atoms.queue[slot] = target
    atoms.is_queued[target] = 1
    control[QUEUED] += 1


@kernel()
def take_class(atoms):  # type: ignore[no-untyped-def]
    """Take the next class out of the queue."""
    control = atoms.control
    control[QUEUED] -= 1
    number = atoms.queue[control[FIRST]]
    atoms.is_queued[number] = 0
    control[FIRST] += 1
    if control[FIRST] == atoms.queue.size:
        control[FIRST] = 0
    return number


@kernel()
def drop_edge(atoms, edge):  # type: ignore[no-untyped-def]
    """Remove an edge."""
    control = atoms.control
    control[LIVING_EDGES] -= 1
    before, after = atoms.last_out[edge], atoms.next_out[edge]
    if before == NONE:
        atoms.first_out[atoms.source[edge]] = after
    else:
        atoms.next_out[before] = after
    if after != NONE:
        atoms.last_out[after] = before
    before, after = atoms.last_in[edge], atoms.next_in[edge]
    if before == NONE:
        atoms.first_in[atoms.target[edge]] = after
    else:
        atoms.next_in[before] = after
    if after != NONE:
        atoms.last_in[after] = before
    atoms.state[edge] = UNUSED
    atoms.next_out[edge] = control[FREE]
    control[FREE] = edge


@kernel()
def has_edge(atoms, source, at, target):  # type: ignore[no-untyped-def]
    """Whether there is such an edge."""
    edge = atoms.first_out[source]
    while edge != NONE:
        if atoms.target[edge] == target and atoms.at[edge] == at:
            return True
        edge = atoms.next_out[edge]
    return False
