"""Calls in a net: requests of services and goals of actions, who serves them, and how answers are taken."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, TypeAlias

from dineros.analysis.callbacks.circles import Waiter
from dineros.analysis.model.subject import Subject
from dineros.analysis.model.wording import client_words, source_of
from dineros.metamodel import pn, sym
from dineros.metamodel.calls import answers
from dineros.metamodel.records import Accept, Outcome, Reject, Reply, Response, Serve

if TYPE_CHECKING:
    from dineros.transformations.flattening.traces import Link

Client: TypeAlias = sym.ClientPort | sym.ActionClientPort


_BESIDE = ("feedback", "goal", "result", "answer")
"""Queues of an action, which say nothing about what a client waits for."""


@dataclass(frozen=True)
class Call:
    """A client, or a server instance's copy of it; places and transitions of its calls."""

    waiter: Waiter
    """The answer, as one that waits."""
    client: Client
    index: int | None
    """Number of the server instance or slot whose page it is on."""
    request: pn.Place
    """Where the model puts what is asked."""
    answers: frozenset[pn.Place]
    """Where the model takes the answers."""
    takes: tuple[int, ...]
    """Transitions that take an answer."""
    serves: dict[int, int]
    """By server instance or slot, the transition that begins to serve it."""
    works: dict[int, int]
    """By server instance or slot, the place that says that it works for the client."""
    under_way: tuple[int, ...]
    """Places of which one is marked until the answer has been taken."""

    @property
    def server(self) -> pn.Page | None:
        """The page that serves it."""
        channel = self.client.channel
        return None if channel is None else channel.server.page

    @property
    def may_give_up(self) -> bool:
        """Whether the client stops waiting after a time."""
        return isinstance(self.client, sym.ClientPort) and self.client.timeout is not None


def calls_in(subject: Subject) -> list[Call]:
    """Return the calls of all clients."""
    links: dict[tuple[Client, int | None], list[Link]] = defaultdict(list)
    for link in subject.links():
        client = next((s for s in link.sources if isinstance(s, sym.ClientPort | sym.ActionClientPort)), None)
        if client is not None and link.meaning is not None and link.meaning.queue not in _BESIDE:
            links[client, link.client_index].append(link)
    return [
        _service_call(subject, client, index, each)
        if isinstance(client, sym.ClientPort)
        else _goal_call(subject, client, each)
        for (client, index), each in links.items()
    ]


def _service_call(subject: Subject, client: sym.ClientPort, index: int | None, links: list[Link]) -> Call:
    places, moves = _parts(subject, links)
    works = {
        instance: next(
            place
            for place, _ in subject.net.pre.row(transition)
            if (link := places.get(place)) and link.meaning is not None and not link.meaning.rests
        )
        for step, instance, transition in moves
        if step is Reply
    }
    service = source_of(links[0], sym.ServiceChannel)
    text = f"the response of service {service.service} to {client_words(links[0])}"
    return Call(
        Waiter("response", text, str(service.id), client, f"service {service.service}"),
        client,
        index,
        client.request,
        frozenset({client.response}),
        tuple(transition for step, _, transition in moves if step is Response),
        {instance: transition for step, instance, transition in moves if step is Serve},
        works,
        tuple(place for place, link in places.items() if link.meaning is not None and not link.meaning.rests),
    )


def _goal_call(subject: Subject, client: sym.ActionClientPort, links: list[Link]) -> Call:
    places, moves = _parts(subject, links)
    action = source_of(links[0], sym.ActionChannel)
    text = f"the result of action {action.action} for {client_words(links[0])}"
    return Call(
        Waiter("result", text, str(action.id), client, f"action {action.action}"),
        client,
        None,
        client.goal,
        frozenset(answers(client)),
        tuple(transition for step, _, transition in moves if step in (Outcome, Reject)),
        {instance: transition for step, instance, transition in moves if step is Accept},
        {
            link.index: place
            for place, link in places.items()
            if link.meaning is not None and link.meaning.part == "works" and link.index is not None
        },
        tuple(place for place, link in places.items() if link.meaning is not None and not link.meaning.rests),
    )


def _parts(subject: Subject, links: list[Link]) -> tuple[dict[int, Link], list[tuple[type | None, int, int]]]:
    """Return the places of a client; and its transitions, with their steps and server instances."""
    places = {
        subject.place_index[link.target.id]: link for link in links if isinstance(link.target, pn.Place)
    }
    return places, list(_moves(subject, links))


def _moves(subject: Subject, links: list[Link]) -> Iterator[tuple[type | None, int, int]]:
    for link in links:
        if link.meaning is not None and isinstance(link.target, pn.Transition):
            yield link.meaning.step, link.index or 0, subject.transition_index[link.target.id]
