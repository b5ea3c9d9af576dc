"""What the rules of channels do with messages that carry data, for the interpreter of models with guards.

It goes by the ids of places and transitions, as the documentation of the rules has them.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from itertools import combinations, product

Data = tuple[bool, int]
"""What a token carries: `ok`, true or false, and `level`, 0 to 2."""

ALL = list(product((False, True), range(3)))

State = tuple[tuple[str, tuple[Data, ...]], ...]

_MESSAGES = re.compile(
    r"\.(In|sent|requests|responses|requested|over\.\w+)$|(reader|writer|feedback|client)\..*\.Load$"
)


def is_message(id: str) -> bool:
    """Whether the tokens of a place that a rule makes are messages, requests or answers."""
    return _MESSAGES.search(id) is not None


def is_queue(id: str) -> bool:
    """Whether a place is the load of a queue of a topic, which is in order."""
    return (
        is_message(id)
        and id.endswith(".Load")
        and any(part in id for part in (".reader.", ".writer.", ".feedback."))
    )


def frozen(state: Mapping[str, tuple[Data, ...]]) -> State:
    """Return a state to compare: the tokens of queues are in order, those of other places are in none."""
    return tuple(sorted((p, each if is_queue(p) else tuple(sorted(each))) for p, each in state.items()))


def handed(
    id: str,
    state: Mapping[str, tuple[Data, ...]],
    takes: Counter[str],
    reads: Counter[str],
    puts: Counter[str],
    carries: set[str],
) -> Iterator[State]:
    """Yield the states after a transition of a rule, which hands a message on or loses one."""
    if any(len(state[p]) < n for p, n in (takes + reads).items()):
        return
    taken, put = takes - puts, puts - takes
    sources = [p for p in taken if p in carries]
    if id.endswith(".drop"):
        yield from _lost(id, state, taken, put, carries)
        return
    choices = [
        set(combinations(state[p], n)) if not is_queue(p) else [state[p][:n]] for p, n in taken.items()
    ]
    for tokens in product(*choices):
        gone = dict(zip(taken, tokens, strict=True))
        source = next((p for p in sources if not p.endswith("late.requests")), next(iter(sources), None))
        made = []
        for p, n in put.items():
            if p not in carries:
                values = [(False, 0)]
            elif source is None or (is_own(p) and ".giveUp." in id):
                values = ALL
            else:
                values = [gone[source][0]]
            made.append([(p, each) for each in product(values, repeat=n)])
        for new in product(*made):
            yield _after(state, gone, new)


def _lost(
    id: str,
    state: Mapping[str, tuple[Data, ...]],
    taken: Counter[str],
    put: Counter[str],
    carries: set[str],
) -> Iterator[State]:
    """Yield the states after a full history has lost a message: its oldest one, and it keeps the new one.

    A history of requests is shared by clients: the one that is lost may be the new one, or another request
    of the same client.
    """
    (arrives,) = (p for p in taken if p in carries)
    others = [(p, ((False, 0),) * n) for p, n in put.items()]
    for new in set(state[arrives]):
        gone = {p: ((False, 0),) * n for p, n in taken.items()} | {arrives: (new,)}
        queue = arrives.removesuffix(".In") + ".Load"
        if arrives.endswith(".In"):
            yield _after(state, gone | {queue: state[queue][:1]}, [*others, (queue, (new,))])
            continue
        if arrives.endswith(".responses"):
            queue = arrives + ".Load"
        else:
            queue = arrives.removesuffix(".sent") + ".requests"
            yield _after(state, gone, others)
        for old in set(state[queue]):
            yield _after(state, gone | {queue: (old,)}, [*others, (queue, (new,))])


def _after(
    state: Mapping[str, tuple[Data, ...]],
    gone: Mapping[str, tuple[Data, ...]],
    new: Iterable[tuple[str, tuple[Data, ...]]],
) -> State:
    after = {p: list(each) for p, each in state.items()}
    for p, each in gone.items():
        for data in each:
            after[p].remove(data)
    for p, each in new:
        after[p].extend(each)
    return frozen({p: tuple(each) for p, each in after.items()})


def is_own(id: str) -> bool:
    """Whether a place is one of the model: rules make ids with dots."""
    return "." not in id
