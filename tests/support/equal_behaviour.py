"""Whether a net behaves as an interpreter says: their graphs are isomorphic, step by step and by name."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

from tests.support.reachability import Marking, ReachabilityGraph
from tests.support.references.flattening import PlainNet
from tests.support.references.histories import Interpreter, State


@dataclass(frozen=True)
class Comparison:
    """What a comparison found.

    Attributes
    ----------
    states, steps : int
        How many were compared.
    complete : bool
        Whether these were all; otherwise as many as asked for.
    difference : str
        Empty where there is none.
    """

    states: int
    steps: int
    complete: bool
    difference: str = ""


def compare(net: PlainNet, interpreter: Interpreter, limit: int) -> Comparison:
    """Walk a net and an interpreter together, breadth first, up to a number of states.

    Each marking goes with one state and each state with one marking, and in both the same can happen.
    """
    graph = ReachabilityGraph(net)
    beside: dict[Marking, State] = {graph.start: interpreter.start}
    taken: dict[State, Marking] = {interpreter.start: graph.start}
    queue = deque(beside.items())
    steps = 0
    while queue:
        marking, state = queue.popleft()
        in_net = dict(graph.successors(marking))
        in_model = dict(interpreter.successors(state))
        if in_net.keys() != in_model.keys():
            only = sorted(map(str, in_net.keys() ^ in_model.keys()))
            return Comparison(len(beside), steps, False, f"only one of both can do {only}")
        for name, after in in_net.items():
            steps += 1
            then = in_model[str(name)]
            if after not in beside and then not in taken:
                if len(beside) == limit:
                    return Comparison(limit, steps, False)
                beside[after], taken[then] = then, after
                queue.append((after, then))
            elif beside.get(after) != then or taken.get(then) != after:
                return Comparison(len(beside), steps, False, f"{name} leads to different states")
    return Comparison(len(beside), steps, True)
