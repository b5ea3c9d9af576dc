"""Where on the model each place and transition of the net is seen: what people look at while it fires."""

from __future__ import annotations

from typing import Literal

from dineros.analysis.model.queues import queues
from dineros.analysis.model.step_roles import StepRole, step_roles
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import signal_setting, source_of
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.clauses import SignalSetting
from dineros.metamodel.elements import elements
from dineros.metamodel.records import Drop, Fire, Signal
from dineros.transformations.flattening.traces import Link

Kind = Literal["fire", "signal", "loss", "channel"]
"""What a firing is: of the model's own, a change of a signal, a message lost, or a step of a channel."""


class Origins:
    """Where the elements of a net are on the model.

    `subject`: the net, and how it was made from the model.

    Attributes
    ----------
    places : dict of str to EObject
        By the id of a place of the net, the place of the model; copies of server instances have the same one.
    values : dict of str to (InputSignal, bool or str)
        By the id of a place of the net that is marked while a signal has a value.
    channels : dict of str to Channel
        By the id of a place of the net inside of a channel that is not a queue's.
    transitions : dict of str to tuple of EObject
        By the id of a transition of the net, where it is seen: what it was made for, the place of its port.
    """

    def __init__(self, subject: Subject) -> None:
        self.queues = queues(subject)
        self.places: dict[str, EObject] = {}
        self.values: dict[str, tuple[sym.InputSignal, SignalSetting]] = {}
        self.channels: dict[str, sym.Channel] = {}
        self.transitions: dict[str, tuple[EObject, ...]] = {}
        self._roles: dict[str, StepRole] = step_roles(subject.links())
        if subject.flattened is None:
            own = {each.id: each for each in elements(subject.model)}
            self.places = {name: own[name] for name in subject.net.places if name in own}
            self.transitions = {name: (own[name],) for name in subject.net.transitions if name in own}
        else:
            self._read(subject.links())

    def kind(self, transition: str) -> Kind:
        """Return what firing a transition is, by its id in the net."""
        role = self._roles.get(transition)
        if role is None or role.kind is Fire:
            return "fire"
        return "signal" if role.kind is Signal else "loss" if role.kind is Drop else "channel"

    def setting(self, transition: str) -> SignalSetting | None:
        """Return the value that a signal gets by a transition, by the id in the net; None: none changes."""
        role = self._roles.get(transition)
        return None if role is None else role.value

    def _read(self, links: list[Link]) -> None:
        self.places = {link.target.id: link.sources[0] for link in links if _is_own(link)}
        queued = {name for queue in self.queues for name in (queue.load, queue.capacity)}
        for link in links:
            name = link.target.id
            if isinstance(link.target, pn.Transition):
                self.transitions[name] = self._where(link)
            elif not isinstance(link.target, pn.Place) or name in self.places or name in queued:
                continue
            elif (value := signal_setting(link)) is not None:
                self.values[name] = source_of(link, sym.InputSignal), value
            elif channel := next((each for each in link.sources if isinstance(each, sym.Channel)), None):
                self.channels[name] = channel

    def _where(self, link: Link) -> tuple[EObject, ...]:
        role = self._roles[link.target.id]
        if role.kind is Signal:
            return tuple(each for each in link.sources if isinstance(each, sym.InputSignal))
        drawn = [each for each in link.sources if isinstance(each, (pn.Node, sym.Channel))]
        others = [each for each in link.sources if isinstance(each, pn.Element)]
        ends = [self.places[role.place]] if role.place in self.places else []
        return tuple(dict.fromkeys([*(drawn or others)[:1], *ends]))


def _is_own(link: Link) -> bool:
    """Whether an element of the net is a place of the model, or a copy of one."""
    is_place = isinstance(link.target, pn.Place) and link.role == "place" and link.meaning is None
    return is_place and isinstance(link.sources[0], pn.Place)
