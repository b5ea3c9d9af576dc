"""Determines whether responses that arrive while a callback runs can change its decisions.

`rclpy` runs done callbacks of futures as tasks that hold no callback group
(``Future._schedule_or_invoke_done_callbacks``): on several threads, or while another callback awaits, they
run in between. In a model they hold the group of their client. Both behave equally for a variable if each
response sets it only once, and a callback that uses it twice in a run knows that it has the value set by
responses: then the response can also come before the callback begins.
"""

from __future__ import annotations

from collections.abc import Iterable

from dineros.observation.importing.flows.labels import Ask, Edge, Flow, Set


def races(answers: Iterable[Flow], others: Iterable[Flow]) -> bool:
    """Return whether a response may change variables while a callback uses them.

    Parameters
    ----------
    answers : iterable of Flow
        Flows started by responses.
    others : iterable of Flow
        Flows of the other callbacks.
    """
    given: dict[str, set[str]] = {}
    for flow in answers:
        labels = [edge.label for edge in flow.edges if isinstance(edge.label, (Set, Ask))]
        if any(isinstance(label, Ask) for label in labels) or _uses_two(flow):
            return True
        for label in labels:
            if isinstance(label, Set):
                given.setdefault(label.variable, set()).add(label.value)
    flows = list(others)
    return any(_is_changed(flow, name, values) for name, values in given.items() for flow in flows)


def _leaving(flow: Flow) -> dict[int, list[Edge]]:
    found: dict[int, list[Edge]] = {}
    for edge in flow.edges:
        found.setdefault(edge.source, []).append(edge)
    return found


def _uses_two(flow: Flow) -> bool:
    """Return whether a run of a flow may set two variables, or one twice."""
    leaving, todo, seen = _leaving(flow), [(flow.start, False)], {(flow.start, False)}
    while todo:
        state, has_used = todo.pop()
        for edge in leaving.get(state, ()):
            uses = isinstance(edge.label, (Set, Ask))
            if uses and has_used:
                return True
            following = (edge.target, has_used or uses)
            if following not in seen:
                seen.add(following)
                todo.append(following)
    return False


def _is_changed(flow: Flow, name: str, given: set[str]) -> bool:
    """Return whether a flow uses a variable again when it may not have the value set by responses."""
    leaving = _leaving(flow)
    todo: list[tuple[int, frozenset[str] | None]] = [(flow.start, None)]
    seen = set(todo)
    while todo:
        state, known = todo.pop()
        for edge in leaving.get(state, ()):
            label, after = edge.label, known
            if isinstance(label, (Set, Ask)) and label.variable == name:
                if known is not None and not (known == given and len(given) == 1):
                    return True
                after = frozenset((label.value,)) if isinstance(label, Set) else label.values
            if (edge.target, after) not in seen:
                seen.add((edge.target, after))
                todo.append((edge.target, after))
    return False
