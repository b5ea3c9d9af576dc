"""Fairness that people can type, and to what a run is unfair."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from dineros.analysis.logic.language.errors import FormulaError
from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject
from dineros.metamodel.errors import near_matches
from dineros.metamodel.records import Signal

ALL, SIGNALS, NODE, ALL_BUT = "all", "signals", "node:", "all-but:"
"""Words for groups of transitions; a transition of such a name comes before them."""


def fair_transitions(subject: Subject, wanted: Iterable[str]) -> tuple[str, ...]:
    """Return the names of the transitions that are to be treated fairly.

    Parameters
    ----------
    subject : Subject
        What is analysed.
    wanted : iterable of str
        Names of transitions; or ``all`` of them, but those that change an input signal, which are
        ``signals``; ``node:ID``, where a node net takes part; ``all-but:NAME,NAME``, all except for these.

    Raises
    ------
    FormulaError
        There is no such transition or node net, or the transition has variants because of guards.
        Fairness to each of its variants would assume that every value comes again and again.
    """
    groups = _Groups(subject)
    names = tuple(dict.fromkeys(name for word in wanted for name in groups.named(word)))
    for name in names:
        if any(_has_values(subject, number) for number in subject.names.transitions(name)):
            raise FormulaError(
                f"fairness to {name!r} is not supported: guards distinguish its tokens",
                hint="name transitions that do not take or put tokens used by guards",
            )
    return names


def _has_values(subject: Subject, transition: int) -> bool:
    link = subject.link_of(subject.net.transitions[transition])
    return link is not None and bool(link.values)


class _Groups:
    def __init__(self, subject: Subject) -> None:
        self._names = subject.names
        self._net = subject.net
        self._roles: dict[str, StepRole] = step_roles(subject.links())

    def named(self, word: str) -> Sequence[str]:
        """Return the names of the transitions that a word selects."""
        try:
            self._names.transitions(word)
        except FormulaError:
            if word == SIGNALS:
                return [name for name in self._net.transitions if self.is_signal(name)]
            if word == ALL:
                return self._all()
            if word.startswith(ALL_BUT):
                left_out = {
                    self._net.transitions[number]
                    for name in word.removeprefix(ALL_BUT).split(",")
                    for number in self._names.transitions(name)
                }
                return [name for name in self._all() if name not in left_out]
            if word.startswith(NODE):
                return self._of_node(word.removeprefix(NODE))
            raise
        return [word]

    def is_signal(self, name: str) -> bool:
        """Whether a transition of the net changes an input signal."""
        role = self._roles.get(name)
        return role is not None and role.kind is Signal

    def _all(self) -> list[str]:
        return [name for name in self._net.transitions if not self.is_signal(name)]

    def _of_node(self, node: str) -> list[str]:
        nodes = {role.node for role in self._roles.values() if role.node is not None}
        if node not in nodes:
            raise FormulaError(f"no node net is named {node!r}", hint=near_matches(node, nodes))
        return [name for name in self._all() if self._roles[name].node == node]


@dataclass(frozen=True)
class Unfairness:
    """To what a run that repeats is unfair: indices of transitions that it does not fire as it repeats."""

    weakly: tuple[int, ...]
    """Enabled all the time."""
    strongly: tuple[int, ...]
    """Enabled again and again, but not all the time."""

    def to_dict(self, names: Sequence[str]) -> dict[str, list[str]]:
        """Return it as JSON, by the names of the net's transitions."""
        return {
            "weakly": [names[transition] for transition in self.weakly],
            "strongly": [names[transition] for transition in self.strongly],
        }


def unfairness(subject: Subject, stem: Sequence[int], loop: Sequence[int]) -> Unfairness:
    """Return the transitions to which a run is unfair. The run fires a stem, then a loop forever.

    A run without a loop ends in a deadlock, where nothing is enabled. Changes of signals are left out, as a
    signal need not change. Variants of a transition with a guard are left out, as no value need occur.
    """
    net = subject.net
    marking = net.initial.tolist()
    for transition in stem:
        marking = net.fire(transition, marking)
    groups = _Groups(subject)
    others = {
        t
        for t, name in enumerate(net.transitions)
        if not groups.is_signal(name) and not _has_values(subject, t)
    } - set(loop)
    always, sometimes = others if loop else set(), set()
    for transition in loop:
        enabled = {other for other in others if net.is_enabled(other, marking)}
        always = always & enabled
        sometimes |= enabled
        marking = net.fire(transition, marking)
    return Unfairness(tuple(sorted(always)), tuple(sorted(sometimes - always)))
