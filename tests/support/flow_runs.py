"""Whether the flow of a callback has a run: a plain walk through its edges."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TypeVar

from dineros.observation.importing.flows.labels import Flow, Label

Entry = TypeVar("Entry")


def accepts(flow: Flow, run: Sequence[Entry], fits: Callable[[Label, Entry], bool]) -> bool:
    """Return whether a flow has a run.

    Parameters
    ----------
    flow : Flow
        The flow; edges without a label leave no entry.
    run : sequence
        What was seen, in order.
    fits : callable
        Tells whether a label of an edge can leave an entry.
    """
    states = {(flow.start, 0)}
    todo = list(states)
    while todo:
        state, done = todo.pop()
        if state == flow.end and done == len(run):
            return True
        for edge in flow.edges:
            if edge.source != state:
                continue
            if edge.label is None:
                after = edge.target, done
            elif done < len(run) and fits(edge.label, run[done]):
                after = edge.target, done + 1
            else:
                continue
            if after not in states:
                states.add(after)
                todo.append(after)
    return False
