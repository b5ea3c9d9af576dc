"""A plain program that explores goals which are canceled, in whole units of time. It knows no Petri nets.

Each of some engines sends one goal to an action and asks to cancel it some time later, once it has learned
that the goal is accepted. A slot of the action works on a goal. The work ends by itself, or some time after
the slot has heard of the request. A thread of the server is free for goals and requests at any time. A client
asks for the result once it has learned of the acceptance, and the server sends it once both have happened.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from random import Random
from typing import NamedTuple

from dineros.metamodel import sym
from dineros.metamodel.build import callback, node_net, place, seconds, step
from dineros.metamodel.constraints import validate
from tests.support.reachability import explored

Span = tuple[int, int]


@dataclass(frozen=True)
class GoalCancels:
    """A system. All times are in units."""

    clients: int
    reaction: int
    """The most time in which a client sends its goal."""
    patience: Span
    """From sending a goal to asking to cancel it."""
    work: Span
    """Work of a goal that is not canceled."""
    stop: Span
    """From hearing of the request to the end of the goal."""
    slots: int
    latency: Span = (0, 0)
    """Of goals, of requests to cancel and of results."""

    @classmethod
    def drawn(cls, random: Random) -> GoalCancels:
        """Return a random system."""

        def span(most: int, wider: int) -> Span:
            least = random.randint(0, most)
            return least, least + random.randint(0, wider)

        patience = random.randint(1, 4)
        times = (patience, patience + random.randint(0, 1)), span(4, 2), span(1, 1)
        latency = random.choice([(0, 0), (0, 0), (0, 1), (1, 1)])
        return cls(random.randint(1, 2), random.randint(0, 1), *times, random.randint(1, 2), latency)

    def model(self) -> sym.SystemModel:
        """Return the model."""
        model = sym.SystemModel(id="m", middleware="ros2")
        driver = node_net(model, "driver", execution="callbacks")
        driver.executor, driver.threads = sym.Executor.multi, self.slots + 2
        page = callback(driver, "Drive", "goal")
        goal, there, back, asked = (place(page, each) for each in ("Goal", "There", "Back", "Asked"))
        step(page, "Work", [goal], [there]).interval = seconds(*self.work)
        step(page, "Stop", [goal, asked], [back]).interval = seconds(*self.stop)
        action = sym.ActionChannel(
            id="Act",
            action="/act",
            instances=self.slots,
            latency=seconds(*self.latency),
            server=sym.ActionServerPort(page=page, entry=goal, succeeded=there, canceled=back, cancel=asked),
            model=model,
        )
        for number in range(self.clients):
            sender = node_net(model, f"sender{number}")
            sender.reaction = seconds(0, 0)
            sent, waits, recall, done, failed = (
                place(sender, f"{each}{number}") for each in ("Send", "Waits", "Recall", "Done", "Failed")
            )
            go = step(sender, f"Go{number}", [place(sender, f"Wish{number}", 1)], [sent, waits])
            go.interval = seconds(0, self.reaction)
            step(sender, f"Ask{number}", [waits], [recall]).interval = seconds(*self.patience)
            action.clients.append(
                sym.ActionClientPort(
                    client=str(sender.id), goal=sent, succeeded=done, canceled=failed, cancel=recall
                )
            )
        assert [str(each) for each in validate(model) if each.severity == "error"] == []
        return model


class _Client(NamedTuple):
    goal: str
    """`wish`, `way`, `queue`, `work`, or the outcome."""
    spent: int
    """Time in that phase, or since the result was sent; -1: the result has come."""
    since: int
    """Since the goal was sent."""
    ask: str
    """`wait` until it asks, `wish` until the request can leave, `way`, `heard` or `gone`."""
    asked: int
    """Time in that phase."""
    learning: int = -1
    """Since the server accepted the goal; -1 before that, and once the client has learned of it."""
    fetching: int = -1
    """Since the client asked for the result; -1 before that, and once the server knows."""

    @property
    def is_fetched(self) -> bool:
        """Whether the server has been asked for the result."""
        return self.learning < 0 and self.fetching < 0


class Explorer:
    """Explores a system.

    Attributes
    ----------
    times : dict of str to (int, int)
        Least and greatest time from sending a goal to its result, by outcome.
    """

    def __init__(self, system: GoalCancels, most_states: int) -> None:
        self._system = system
        self.times: dict[str, tuple[int, int]] = {}
        start = (_Client("wish", 0, 0, "", 0),) * system.clients
        explored([start], self._successors, most_states)

    def _successors(self, state: tuple[_Client, ...]) -> Iterator[tuple[_Client, ...]]:
        """Yield what may happen now; time passes unless something must."""
        must = False
        is_free = sum(each.goal == "work" for each in state) < self._system.slots
        for at, client in enumerate(state):
            for after, is_due in self._moves(client, is_free):
                must |= is_due
                yield tuple(sorted((*state[:at], after, *state[at + 1 :])))
        if not must and any(each.spent >= 0 for each in state):
            yield tuple(sorted(map(_older, state)))

    def _moves(self, client: _Client, is_free: bool) -> Iterator[tuple[_Client, bool]]:
        """Yield what a client may do next, and its goal, and whether it can wait no longer."""
        system = self._system
        if client.goal == "wish":
            sent = _Client("way", 0, 0, "wait", 0)
            yield sent, client.spent == system.reaction
        if client.goal == "way" and client.spent >= system.latency[0]:
            yield client._replace(goal="queue", spent=0), client.spent == system.latency[1]
        if client.goal == "queue" and is_free:
            yield client._replace(goal="work", spent=0, learning=0), True
        if client.learning >= system.latency[0]:
            yield client._replace(learning=-1, fetching=0), client.learning == system.latency[1]
        if client.fetching >= system.latency[0]:
            yield client._replace(fetching=-1), client.fetching == system.latency[1]
        if client.goal == "work":
            if client.spent >= system.work[0]:
                yield _over(client, "succeeded"), client.spent == system.work[1]
            if client.ask == "heard" and client.asked >= system.stop[0]:
                yield _over(client, "canceled"), client.asked == system.stop[1]
        is_over = client.goal in ("succeeded", "canceled")
        if is_over and client.is_fetched and client.spent >= system.latency[0]:
            least, most = self.times.get(client.goal, (client.since, client.since))
            self.times[client.goal] = min(least, client.since), max(most, client.since)
            yield client._replace(spent=-1, since=0), client.spent == system.latency[1]
        if client.ask == "wait" and client.asked >= system.patience[0]:
            wishes = client._replace(ask="gone" if is_over else "wish", asked=0)
            yield wishes, client.asked == system.patience[1]
        if client.ask == "wish" and client.goal == "work" and client.learning < 0:
            yield client._replace(ask="way", asked=0), True
        if client.ask == "way" and client.asked >= system.latency[0]:
            yield client._replace(ask="heard", asked=0), client.asked == system.latency[1]


def _over(client: _Client, outcome: str) -> _Client:
    """Return a client whose goal is over; a request that is under way is gone."""
    ask, asked = (client.ask, client.asked) if client.ask == "wait" else ("gone", 0)
    return client._replace(goal=outcome, spent=0, ask=ask, asked=asked)


def _older(client: _Client) -> _Client:
    is_over = client.goal in ("succeeded", "canceled") and client.is_fetched
    goes_on = (client.goal in ("wish", "way", "work") or is_over) and client.spent >= 0
    return client._replace(
        spent=client.spent + goes_on,
        since=client.since + (client.goal != "wish" and client.spent >= 0),
        asked=client.asked + (client.ask in ("wait", "way", "heard")),
        learning=client.learning + (client.learning >= 0),
        fetching=client.fetching + (client.fetching >= 0),
    )
