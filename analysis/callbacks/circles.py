"""Circles of those that wait for each other, and how they are described in the words of ROS."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import Literal

from dineros.metamodel.base import EObject
from dineros.metamodel.elements import node_net_of

Kind = Literal["callback", "response", "result", "group", "thread", "place"]

HELD = ("group", "thread", "place")
"""Kinds of resources that callbacks hold or provide."""

MOST_NAMED = 4
"""Further reasons that a text names; JSON has all of them."""


@dataclass(frozen=True)
class Waiter:
    """One that waits, or that is waited for."""

    kind: Kind
    """What it is: a callback, the response of a service, the result of a goal, a callback group, a thread of
    an executor, or a place of the model whose token is missing.
    """
    text: str
    """The same in the words of the model."""
    element: str
    """Id of the callback page, service, action, callback group, node net or place."""
    model: EObject = field(compare=False, repr=False)
    """The callback page, client, callback group or place; of a thread and a default group the node net."""
    short: str = field(default="", compare=False, repr=False)
    """The name alone, if the kind and the node are known already."""


@dataclass(frozen=True)
class Reason:
    """Why one of them waits."""

    waiter: Waiter
    needs: tuple[Waiter, ...]
    """What it waits for, which waits in turn. A thread and a group wait for the callbacks that hold them."""
    is_choice: bool = False
    """Whether one of these would be enough."""
    is_held: bool = True
    """Of a place: whether those callbacks hold its token; otherwise they would give one."""


@dataclass(frozen=True)
class Circle:
    """Some that wait for each other: each for the next, the last for the first, which is a callback."""

    waiters: tuple[Waiter, ...]
    reasons: tuple[Reason, ...] = field(compare=False)
    """Why each of them waits; then why those wait that they need besides, or that could serve instead."""

    def __str__(self) -> str:
        words = _Words(self)
        parts = [words.clause(waiter) for waiter in self.waiters if waiter.kind not in HELD]
        beside = [
            reason.waiter
            for reason in self.reasons[len(self.waiters) :]
            if reason.waiter.kind == "callback" and reason.waiter not in self.waiters
        ]
        parts += [words.clause(waiter) for waiter in beside[:MOST_NAMED]]
        if len(beside) > MOST_NAMED:
            parts.append(f"{len(beside) - MOST_NAMED} more callbacks wait so")
        parts += self._assumed_groups()
        return f"deadlock in {words.nodes}: {'; '.join(parts)}"

    def _assumed_groups(self) -> Iterator[str]:
        """Yield that the groups of callbacks and clients are assumed, if it is a circle because of them."""
        of_groups = [reason for reason in self.reasons if reason.waiter.kind == "group"]
        concerned = {need for reason in of_groups for need in reason.needs}
        groups = {reason.waiter for reason in of_groups}
        concerned |= {each.waiter for each in self.reasons if not groups.isdisjoint(each.needs)}
        for waiter in dict.fromkeys(each.waiter for each in self.reasons):
            words = getattr(waiter.model, "assumed", None) or ""
            if waiter in concerned and "group" in words.split():
                is_callback = waiter.kind == "callback"
                client = f"client {getattr(waiter.model, 'client', '')} of {waiter.short}"
                yield f"that {waiter.text if is_callback else client} is in this callback group is assumed"

    @property
    def shape(self) -> tuple[tuple[str, str], ...]:
        """Kinds and elements of those in it, wherever it begins: server instances are alike."""
        around = [(waiter.kind, waiter.element) for waiter in self.waiters]
        return min(tuple(around[number:] + around[:number]) for number in range(len(around)))

    @property
    def elements(self) -> tuple[str, ...]:
        """Ids of the elements of the model concerned, each once."""
        return tuple(dict.fromkeys(waiter.element for waiter in self.waiters))


class _Words:
    """The texts for the members of a circle: in full at the first mention, by name after that."""

    def __init__(self, circle: Circle) -> None:
        self._reasons = {reason.waiter: reason for reason in circle.reasons}
        self._callbacks = [waiter for waiter in circle.waiters if waiter.kind == "callback"]
        self._known: set[Waiter] = set()
        *others, last = dict.fromkeys(self._nodes())
        self._is_one = not others
        self.nodes = f"nodes {', '.join(others)} and {last}" if others else f"node {last}"

    def _nodes(self) -> Iterator[str]:
        for waiter in self._reasons:
            node = node_net_of(waiter.model)
            if waiter.kind in ("callback", "group", "thread") and node is not None:
                yield str(node.name or node.id)

    def clause(self, waiter: Waiter) -> str:
        """Return why a callback or an answer waits, with those that hold what it needs."""
        needs = self._reasons[waiter].needs
        if waiter.kind in ("response", "result"):
            return f"the {waiter.kind} {self._of_answer(waiter)}"
        name, kinds = self._of(waiter), {need.kind for need in needs}
        self._known.update(needs if kinds <= {"response", "result"} else ())
        if kinds == {"response"}:
            return f"{name} blocks in a call of {_listed([need.short for need in needs], 'and')}"
        if kinds == {"result"}:
            return f"{name} blocks for the result of {_listed([need.short for need in needs], 'and')}"
        if kinds == {"place"}:
            return f"{name} waits for {self._held(waiter)}"
        return f"{name} needs {self._held(waiter)}"

    def _of_answer(self, waiter: Waiter) -> str:
        needs = self._reasons[waiter].needs
        serving = [self._of(need) for need in needs if need.kind not in HELD]
        parts = [f"has to come from {_listed(serving, 'or')}"] if serving else []
        if len(serving) < len(needs):
            parts.append(f"needs {self._held(waiter)}")
        return ", or ".join(parts)

    def _held(self, waiter: Waiter) -> str:
        """Return the resources that it needs, each with the callbacks that hold or would provide it."""
        by_holders: dict[tuple[Waiter, ...], list[Waiter]] = {}
        reason = self._reasons[waiter]
        for need in (each for each in reason.needs if each.kind in HELD):
            by_holders.setdefault(self._reasons[need].needs, []).append(need)
        word = "or" if reason.is_choice else "and"
        parts = []
        for holders, held in by_holders.items():
            what = _listed([self._thing(each) for each in held], word)
            which = "all of which" if what.startswith("one of ") else "which"
            parts.append(f"{what}, {which} {self._hold(holders, self._reasons[held[0]].is_held)}")
        return _listed(parts, word)

    def _thing(self, waiter: Waiter) -> str:
        is_short = self._is_one or waiter.kind == "place"
        return waiter.short if is_short and waiter.short else waiter.text

    def _hold(self, holders: Sequence[Waiter], is_held: bool) -> str:
        is_alone = list(holders) == self._callbacks
        listed = _listed([self._of(holder) for holder in holders], "and" if is_held else "or")
        if not is_held:
            return f"{listed} would give"
        return f"{listed} {'itself ' if is_alone else ''}{'holds' if len(holders) == 1 else 'hold'}"

    def _of(self, waiter: Waiter) -> str:
        is_known = waiter in self._known
        self._known.add(waiter)
        return waiter.short if is_known and waiter.short else waiter.text


def _listed(names: Sequence[str], word: str) -> str:
    return names[0] if len(names) == 1 else f"{', '.join(names[:-1])} {word} {names[-1]}"
