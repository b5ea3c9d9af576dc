"""The calls of services, as the interpreter of `reference_histories` plays them: how many there are where.

A call is sent, kept by the server until an instance takes it, served, answered, and over. A server keeps a
number of requests, whoever they are of; what comes to a server that keeps as many is lost. A client that has
given up is ready at once, and what it asked continues without it: nobody's request is served all the same,
and its answer goes nowhere; a server that is full may forget it for one that comes.

A client that does not wait is always ready. What it asks is with the server at once or lost, and it forgets
that, unless it gives it up one day. It keeps as many answers as the server keeps requests, and loses more.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.metamodel import pn, sym
from tests.support.references.waiting import UNLIMITED

if TYPE_CHECKING:
    from tests.support.references.histories import Interpreter, State


def node_of(element: pn.PageObject) -> sym.NodeNet | None:
    """Return the node net that an element stands in."""
    holder: object = element
    while holder is not None and not isinstance(holder, sym.NodeNet):
        holder = holder.eContainer()  # type: ignore[attr-defined]
    return holder


def sends_once(client: sym.ClientPort) -> bool:
    """Tell whether a client is rclpy's, which sends a request once; our engine's sends it again."""
    node = node_of(client.request)
    return node is not None and str(node.execution) == "callbacks"


def is_deserted(service: sym.ServiceChannel) -> bool:
    """Tell whether a service may have no server while a client of rclpy asks it."""
    node = node_of(service.server.page)
    return node is not None and node.lifecycle is not None and any(map(sends_once, service.clients))


def leaves(service: sym.ServiceChannel) -> bool:
    """Tell whether such a server may go away while it has requests."""
    node = node_of(service.server.page)
    life = None if node is None else node.lifecycle
    return life is not None and (life.cleansUp or life.shutsDown) and is_deserted(service)


class ServicePlayer:
    """Adds to an interpreter what can happen to the calls of one service.

    Parameters
    ----------
    play : Interpreter
        Whose events these are.
    service : sym.ServiceChannel
        The service.
    """

    def __init__(self, play: Interpreter, service: sym.ServiceChannel) -> None:
        self.play, self.service = play, service
        numbers = range(1, play._instances(service) + 1)
        self.busy = {number: play._slot((service, number)) for number in numbers}
        self.calls = [(client, copy) for client in service.clients for copy in play._copies(client.request)]
        gives_up = any(client.timeout is not None for client, _ in self.calls)
        asked = [play.outstanding[client] for client, _ in self.calls]
        too_many = UNLIMITED in asked or sum(asked) > service.depth
        self.can_lose = gives_up or too_many or is_deserted(service)
        self.kept: list[int] = []
        self.nobodys: int | None = None
        self.nobodys_at: dict[int, int] = {}
        if gives_up or leaves(service):
            self._served_for_nobody()
        if gives_up:
            self._nobody()
        for client, copy in self.calls:
            self._client(client, copy)

    def is_full(self, state: State) -> bool:
        """Tell whether the server keeps as many requests as it can."""
        return sum(state[slot] for slot in self.kept) == self.service.depth

    def is_live(self, state: State) -> bool:
        """Tell whether a request that it keeps is of a client that waits: the oldest may be one of these."""
        return self.nobodys is None or state[self.nobodys] < self.service.depth

    def _nobody(self) -> None:
        """Play the calls whose clients have given up: they are served, and nobody gets the answer."""
        self.nobodys = self.play._slot((self.service, "late"))
        self.kept.append(self.nobodys)
        for number in self.busy:
            self._take(f"{self.service.id}.late", number, self.nobodys, self.nobodys_at[number])

    def _served_for_nobody(self) -> None:
        for number in self.busy:
            self.nobodys_at[number] = self.play._slot((self.service, "late", number))
            self._answer(f"{self.service.id}.late", number, self.nobodys_at[number], None)

    def _client(self, client: sym.ClientPort, copy: int) -> None:
        play, service = self.play, self.service
        page = client.request.page
        assert page is not None
        caller = play._home.get(page)
        name = client.client if caller is None else f"{caller.id}[{copy}].{client.client}"
        prefix = f"{service.id}.client.{name}"
        number_of_calls = play.outstanding[client]
        is_free = number_of_calls == UNLIMITED
        ready = None if is_free else play._slot((service, name, "ready"), number_of_calls)
        kept, answered = (play._slot((service, name, word)) for word in ("kept", "answered"))
        self.kept.append(kept)
        served = {number: play._slot((service, name, number)) for number in self.busy}
        request, response = play._place(client.request, copy), play._place(client.response, copy)
        play._requests.add(request)
        waiting = {"requests": kept, "responses": answered}
        sent = kept
        if self.can_lose:
            sent = play._slot((service, name, "sent"))
            forgets = is_free and client.timeout is None
            gone = {sent: -1}
            if not forgets:
                waiting["lost"] = play._slot((service, name, "lost"))
                gone[waiting["lost"]] = 1
            play._happens(f"{prefix}.in", lambda s: s[sent] > 0 and not self.is_full(s), {sent: -1, kept: 1})
            play._happens(
                f"{prefix}.drop", lambda s: s[sent] > 0 and self.is_full(s) and self.is_live(s), gone
            )
            if self.nobodys is not None:
                late = self.nobodys
                play._happens(
                    f"{prefix}.instead",
                    lambda s: s[sent] > 0 and s[late] > 0 and self.is_full(s),
                    {sent: -1, kept: 1, late: -1},
                )
        uses = {} if ready is None else {ready: -1}
        readies = {} if ready is None else {ready: 1}
        play._happens(
            f"{prefix}.req",
            lambda s: s[request] > 0 and (ready is None or s[ready] > 0),
            {request: -1, sent: 1, **uses},
        )
        taken = answered
        if is_free:
            play.bounds[sent] = play.bounds[answered] = 1
            taken = waiting["kept"] = self._mail(prefix, name, answered)
        for number in self.busy:
            self._take(prefix, number, kept, served[number])
            self._answer(prefix, number, served[number], answered)
        play._happens(f"{prefix}.res", lambda s: s[taken] > 0, {taken: -1, response: 1, **readies})
        play.under_way[client, copy] = [sent, kept, answered, taken, *served.values()]
        if client.timeout is None:
            return
        told = {} if client.timedOut is None else {play._place(client.timedOut, copy): 1}
        assert self.nobodys is not None
        goes_on = {"requests": {self.nobodys: 1}}
        for number, slot in served.items():
            waiting[f"inUse[{number}]"] = slot
            goes_on[f"inUse[{number}]"] = {self.nobodys_at[number]: 1}
        if is_deserted(service) and not sends_once(client):
            waiting["sent"] = sent
        for word, slot in waiting.items():
            play._happens(
                f"{prefix}.giveUp.{word}",
                lambda s, slot=slot: s[slot] > 0,  # type: ignore[misc]
                {slot: -1, **readies, **told, **goes_on.get(word, {})},
            )

    def _mail(self, prefix: str, name: str, answered: int) -> int:
        """Keep responses until the client takes them, and return where; more than the depth are lost."""
        play, depth = self.play, self.service.depth
        mail = play._slot((self.service, name, "mail"))
        for word, is_full, effect in (
            ("in", False, {answered: -1, mail: 1}),
            ("drop", True, {answered: -1}),
        ):
            play._happens(
                f"{prefix}.responses.{word}",
                lambda s, is_full=is_full: s[answered] > 0 and (s[mail] == depth) is is_full,  # type: ignore[misc]
                effect,
            )
        return mail

    def _take(self, prefix: str, number: int, kept: int, served: int) -> None:
        """Let an instance take a request."""
        busy, entry = self.busy[number], self.play._place(self.service.server.entry, number)
        self.play._happens(
            f"{prefix}.call[{number}]",
            lambda s: s[kept] > 0 and s[busy] == 0,
            {kept: -1, busy: 1, served: 1, entry: 1},
        )

    def _answer(self, prefix: str, number: int, served: int, answered: int | None) -> None:
        """Let an instance answer a request."""
        play, busy = self.play, self.busy[number]
        exit_ = play._place(self.service.server.exit, number)
        play._happens(
            f"{prefix}.return[{number}]",
            lambda s: s[exit_] > 0 and s[served] > 0,
            {exit_: -1, busy: -1, served: -1, **({} if answered is None else {answered: 1})},
        )
