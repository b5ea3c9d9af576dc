"""Whether callbacks can wait for ever, by the interpreter of system models and a plain search."""

from __future__ import annotations

import networkx as nx

from dineros.metamodel import sym
from tests.support.references.executors import ExecutorInterpreter
from tests.support.references.histories import TooManyStatesError


def some_waits_for_ever(model: sym.SystemModel, most: int = 100_000) -> bool:
    """Tell whether from some state on no way leads to the end of a callback.

    Raises `TooManyStatesError` where there are more states than `most`.
    """
    interpreter = ExecutorInterpreter(model)
    graph: nx.DiGraph[tuple[int, ...]] = nx.DiGraph()
    states = [interpreter.start]
    for state in states:
        if len(states) > most:
            raise TooManyStatesError
        graph.add_node(state)
        for _, after in interpreter.successors(state):
            if after not in graph:
                states.append(after)
            graph.add_edge(state, after)
    for callback in interpreter._callbacks.values():
        slots = [slot for slot in (callback.running, callback.awaiting) if slot is not None]
        ended = {state for state in graph if not any(state[slot] for slot in slots)}
        if len(ended.union(*(nx.ancestors(graph, state) for state in ended))) < len(graph):
            return True
    return False
