"""What is never used: dead transitions read as unused topics, services and node nets (Alg. 2 and 3)."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator
from typing import TYPE_CHECKING

from dineros.analysis.checks.question import Checked, Question
from dineros.analysis.model.subject import Subject
from dineros.analysis.witnesses.findings import Fault, Finding
from dineros.metamodel import pn, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.elements import is_unseen, node_net_of, node_nets, transitions
from dineros.metamodel.records import Accept, Cancel, Finish, Reply, Request, Response
from dineros.metamodel.records.schema import Step

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link
    from dineros.transformations.language.meaning import Meaning

TRANSITION = Fault(
    "dead-transition",
    "warning",
    "A transition can never fire.",
    "transition {transition}{where} can never fire",
)
NOT_ASKED = Fault(
    "dead-transition",
    "note",
    TRANSITION.meaning,
    "transition {transition}{where} can never fire: no client asks to cancel a goal of action {action}",
)
"""A server that supports cancel requests is correct even if no client sends one."""
LATE = Fault(
    "dead-transition",
    "warning",
    TRANSITION.meaning,
    "no response of service {service} comes in time: client {client} always gives up after {seconds} s",
)
"""Of the transition that takes a response, if its client has a time-out."""
NODE_NET = Fault(
    "dead-node-net",
    "error",
    "A node net does nothing: all its transitions are dead.",
    "node net {node} does nothing: all its transitions are dead",
)
TOPIC = Fault(
    "unused-topic", "warning", "A topic never carries a message.", "topic {topic} never carries a message"
)
NOT_CALLED = Fault(
    "service-never-called", "warning", "A service is never called.", "service {service} is never called"
)
NO_RETURN = Fault(
    "service-never-returns",
    "error",
    "A service is called, but never returns.",
    "service {service} never returns{why}",
)
NO_GOAL = Fault(
    "action-never-used", "warning", "An action never gets a goal.", "action {action} never accepts a goal"
)
NO_END = Fault(
    "goals-never-end",
    "error",
    "An action accepts goals, but no goal ever ends.",
    "no goal of action {action} ever ends",
)
FAULTS = (TOPIC, NOT_CALLED, NO_RETURN, NO_GOAL, NO_END, NODE_NET, TRANSITION)


def unused_parts(subject: Subject, dead: Collection[int]) -> list[Finding]:
    """Read the dead transitions of a net as parts of the model that are never used.

    Parameters
    ----------
    subject : Subject
        The net without signals, and without transitions whose clause can never be true.
    dead : collection of int
        Its transitions that no reachable marking enables.
    """
    model = subject.model
    if not isinstance(model, sym.SystemModel):
        return [
            TRANSITION.found(
                subject.net.transitions[index], transition=subject.transition_text(index), where=""
            )
            for index in sorted(dead)
        ]
    alive = _Alive(subject, dead)
    return [
        *_channels(model, alive),
        *_node_nets(model, alive),
        *_transitions(model, alive),
    ]


class _Alive:
    """Which of the transitions that were made from an element can fire."""

    def __init__(self, subject: Subject, dead: Collection[int]) -> None:
        self._by_source: dict[EObject, list[Link]] = {}
        self._alive: set[str] = set()
        for link in subject.links():
            if isinstance(link.target, pn.Transition):
                for source in link.sources:
                    self._by_source.setdefault(source, []).append(link)
                if subject.transition_index[link.target.id] not in dead:
                    self._alive.add(link.target.id)

    def any(self, source: EObject, wanted: Callable[[Meaning], bool] | None = None) -> bool:
        """Return whether a transition of an element with the wanted meaning can fire."""
        return any(
            link.target.id in self._alive
            for link in self._by_source.get(source, ())
            if wanted is None or (link.meaning is not None and wanted(link.meaning))
        )

    def never_answered(self, client: sym.ClientPort) -> bool:
        """Return whether a client sends requests and never gets a response."""
        return self.any(client, _is(Request)) and not self.any(client, _is(Response))


def _is(step: type[Step]) -> Callable[[Meaning], bool]:
    return lambda meaning: meaning.step is step


_USES: tuple[tuple[type[sym.Channel], str, tuple[tuple[Fault, Callable[[Meaning], bool]], ...]], ...] = (
    (sym.TopicChannel, "topic", ((TOPIC, lambda meaning: meaning.part == "transport"),)),
    (sym.ServiceChannel, "service", ((NOT_CALLED, _is(Request)), (NO_RETURN, _is(Reply)))),
    (sym.ActionChannel, "action", ((NO_GOAL, _is(Accept)), (NO_END, _is(Finish)))),
)
"""Of each kind of channel: what it is called; and in their order the faults, each with what never happens."""


def _channels(model: sym.SystemModel, alive: _Alive) -> Iterator[Finding]:
    for kind, name, uses in _USES:
        for channel in model.channels:
            if not isinstance(channel, kind):
                continue
            fault = next((fault for fault, wanted in uses if not alive.any(channel, wanted)), None)
            if fault is not None:
                words = {name: getattr(channel, name)}
                if fault is NO_RETURN:
                    words["why"] = _why_it_never_returns(channel)
                yield fault.found(channel.id, **words)


def _why_it_never_returns(channel: sym.Channel) -> str:
    assert isinstance(channel, sym.ServiceChannel)
    is_served = not is_unseen(node_net_of(channel.server.entry))
    return "" if is_served else ": no node was seen that serves it"


def _node_nets(model: sym.SystemModel, alive: _Alive) -> Iterator[Finding]:
    ports = _ports(model)
    for node in node_nets(model):
        own = [transition for transition in transitions(model) if node_net_of(transition) is node]
        parts: list[EObject] = [*own, *ports.get(node, ())]
        if parts and not any(map(alive.any, parts)):
            yield NODE_NET.found(node.id, node=node.id)


def _ports(model: sym.SystemModel) -> dict[sym.NodeNet, list[EObject]]:
    """Return the ports of each node net; a service's server is represented by its channel."""
    found: dict[sym.NodeNet, list[EObject]] = {}
    for channel in model.channels:
        pairs: list[tuple[EObject, pn.Place]] = []
        if isinstance(channel, sym.TopicChannel):
            pairs = [(port, port.place) for port in (*channel.publishers, *channel.subscribers)]
        elif isinstance(channel, sym.ServiceChannel):
            pairs = [(client, client.request) for client in channel.clients]
            pairs.append((channel, channel.server.entry))
        elif isinstance(channel, sym.ActionChannel):
            pairs = [(client, client.goal) for client in channel.clients]
            pairs.append((channel, channel.server.entry))
        for part, place in pairs:
            node = node_net_of(place)
            if node is not None:
                found.setdefault(node, []).append(part)
    return found


def _transitions(model: sym.SystemModel, alive: _Alive) -> Iterator[Finding]:
    cancels = {
        arc.target: action
        for action in model.channels
        if isinstance(action, sym.ActionChannel) and action.server.cancel is not None
        for arc in action.server.cancel.outgoing
    }
    clients = {
        arc.target: client
        for service in model.channels
        if isinstance(service, sym.ServiceChannel)
        for client in service.clients
        if client.timeout is not None
        for arc in client.response.outgoing
    }
    read = {_line(transition) for transition in transitions(model) if alive.any(transition)}
    for transition in transitions(model):
        if not alive.any(transition) and (transition.sourceLine is None or _line(transition) not in read):
            node = node_net_of(transition)
            where = f" of node net {node.id}" if node is not None else ""
            action = cancels.get(transition)
            if action is not None and not alive.any(action, _is(Cancel)):
                yield NOT_ASKED.found(
                    transition.id, transition=transition.id, where=where, action=action.action
                )
                continue
            client = clients.get(transition)
            if client is not None and client.channel is not None and alive.never_answered(client):
                service, seconds = client.channel.service, f"{client.timeout:g}"
                yield LATE.found(transition.id, service=service, client=client.client, seconds=seconds)
                continue
            yield TRANSITION.found(transition.id, transition=transition.id, where=where)


def _line(transition: pn.Transition) -> tuple[object, ...]:
    """Return what alternatives of one line of code share: the line, and where a callback is before it.

    A line that tests or sets a variable has a transition for each value.
    """
    before = {arc.source for arc in transition.incoming if not isinstance(arc.source, pn.ReferencePlace)}
    return transition.page, transition.sourceLine, frozenset(before)


class Use(Question):
    """Whether everything is used."""

    faults = FAULTS
    asks = "which elements are never used"
    reads_firings = True

    def ask(self, checked: Checked) -> None:
        """Look for transitions that no marking enables."""
        names, known = checked.subject.net.transitions, checked.firings
        if known is None:
            dead = {index for index, name in enumerate(names) if checked.space.enabled(name) == 0}
            is_open: list[str] = []
        else:
            dead = known.dead
            is_open = [checked.subject.transition_text(t) for t in range(len(names)) if known.is_open(t)]
        checked.report.dead = [names[index] for index in sorted(dead)]
        found = unused_parts(checked.subject, dead)
        checked.report.findings += found
        if known is not None and is_open:
            checked.leave_open(f"whether these can ever be used: {', '.join(is_open)}", known.why_open)
        elif not found:
            checked.report.proved.append("every transition can fire, every channel is used")
