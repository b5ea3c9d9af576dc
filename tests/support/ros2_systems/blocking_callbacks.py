"""Whether callbacks can wait forever, by the interpreter of system models and a plain search."""

from __future__ import annotations

from dineros.metamodel import sym
from tests.support.references.executors import ExecutorInterpreter
from tests.support.references.histories import TooManyStatesError


def some_waits_for_ever(model: sym.SystemModel, most: int = 100_000) -> bool:
    """Tell whether from some state on no way leads to the end of a callback.

    Raises `TooManyStatesError` where there are more states than `most`.
    """
    interpreter = ExecutorInterpreter(model)
    before: dict[tuple[int, ...], list[tuple[int, ...]]] = {interpreter.start: []}
    states = [interpreter.start]
    for state in states:
        if len(states) > most:
            raise TooManyStatesError
        for _, after in interpreter.successors(state):
            if after not in before:
                before[after] = []
                states.append(after)
            before[after].append(state)
    for callback in interpreter._callbacks.values():
        slots = [slot for slot in (callback.running, callback.awaiting) if slot is not None]
        todo = [state for state in states if not any(state[slot] for slot in slots)]
        ending = set(todo)
        for state in todo:  # backwards from where the callback has ended
            for earlier in before[state]:
                if earlier not in ending:
                    ending.add(earlier)
                    todo.append(earlier)
        if len(ending) < len(states):
            return True
    return False
