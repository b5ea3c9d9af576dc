"""Whether answers that arrive while a callback runs change what it decides.

`rclpy` runs done callbacks of futures as tasks that hold no callback group
(``Future._schedule_or_invoke_done_callbacks``): on several threads, or while another callback awaits, they
run in between. A model lets them hold the group of their client. Both agree about a variable if each answer
only sets it once, and a callback that uses it twice in a run knows that it has the value that answers give:
then the answer can as well come before the callback begins.
"""

from __future__ import annotations

from collections.abc import Iterable

from dineros.observation.importing.flows.labels import Ask, Edge, Flow, Set


def races(answers: Iterable[Flow], others: Iterable[Flow]) -> bool:
    """Tell whether an answer may change variables while a callback uses them.

    Parameters
    ----------
    answers : iterable of Flow
        What answers begin.
    others : iterable of Flow
        What the other callbacks do.
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
    """Tell whether a run of a flow may set two variables, or one twice."""
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
    """Tell whether a flow uses a variable once more when it need not have the value that answers give."""
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
