"""The goals of actions, as the interpreter of `reference_histories` plays them: who has which slot.

A goal is sent, accepted into a slot that is free or refused, worked on, and over; its client hears of it and
may send another one. A request to cancel names its goal: it leaves the client only while a slot works on a
goal of that client, and either the server hears it, or the goal is over first and the request is gone; so it
is where the goal is over, and the client has not heard of that. What asks for nothing that could be canceled
is gone at once. A client of one goal takes no answer and sends no goal while it has such a request; of two,
one is gone. A goal that is to be canceled may end in any way, others are not canceled; whether the work has
taken note of the request or not, none of it is left over for the next goal of the slot. Feedback of a goal is
told before the goal is over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.metamodel import pn, sym

if TYPE_CHECKING:
    from tests.support.references.histories import Guard, Interpreter, State

IDLE, WORKING, ASKED, CANCELING = range(4)


class ActionPlayer:
    """Adds to an interpreter what can happen to the goals of one action.

    Parameters
    ----------
    play : Interpreter
        Whose events these are.
    action : sym.ActionChannel
        The action.
    """

    def __init__(self, play: Interpreter, action: sym.ActionChannel) -> None:
        self.play, self.action = play, action
        numbers = range(1, play._instances(action) + 1)
        self.phase = {number: play._slot((action, number, "phase")) for number in numbers}
        self.owner = {number: play._slot((action, number, "owner")) for number in numbers}
        """0 for nobody, or the number of the client whose goal it is."""
        server = action.server
        self.ends: list[tuple[str, pn.Place]] = [
            (outcome, place)
            for outcome in ("succeeded", "aborted", "canceled")
            if (place := getattr(server, outcome)) is not None
        ]
        for number in numbers:
            if server.cancel is not None:
                play.bounds[play._place(server.cancel, number)] = 1
        if any(client.cancel is not None for client in action.clients):
            for number in numbers:
                self._hear(number)
        for count, client in enumerate(action.clients, 1):
            self._client(client, count)

    def finish(self) -> None:
        """Bound what waits to be told, once all that fires is known."""
        play, server = self.play, self.action.server
        if server.feedback is not None and server.feedback.capacity is None:
            for number in self.phase:
                slot = play._place(server.feedback, number)
                play._bound(slot, max(1, *(use.gives.get(slot, 0) for use in play._uses.values())))
        for client in self.action.clients:
            if client.cancel is not None and client.outstanding == 1:
                slot = play._place(client.cancel, 0)
                puts = (use.gives.get(slot, 0) for use in play._uses.values())
                play._bound(slot, 1 + max(1, client.cancel.tokens, *puts))
            if client.feedback is None or server.feedback is None or client.feedback.capacity is not None:
                continue
            slot = play._place(client.feedback, 0)
            if slot in play._requests or any(use.effect().get(slot, 0) < 0 for use in play._uses.values()):
                needs = (use.needs.get(slot, 0) for use in play._uses.values())
                play._bound(slot, max(1, client.feedback.tokens, *needs))

    def _hear(self, number: int) -> None:
        """Let the server learn that a goal is to be canceled; one that cancels nothing says no."""
        play, phase, cancel = self.play, self.phase[number], self.action.server.cancel
        name = f"{self.action.id}[{number}]"
        if cancel is None:
            play._happens(f"{name}.refuse", lambda s: s[phase] == ASKED, {phase: WORKING - ASKED})
            return
        asked = play._place(cancel, number)
        effect = {phase: CANCELING - ASKED, asked: 1}
        play._happens(f"{name}.cancel", lambda s: s[phase] == ASKED, effect)

    def _client(self, client: sym.ActionClientPort, count: int) -> None:
        play, action = self.play, self.action
        prefix = f"{action.id}.client.{client.client}"
        ready = play._slot((action, count, "ready"), client.outstanding)
        sent, refused = (play._slot((action, count, word)) for word in ("sent", "refused"))
        goal = play._place(client.goal, 0)
        play._requests.add(goal)
        regrets = None
        if client.cancel is not None and client.outstanding == 1:
            regrets = play._place(client.cancel, 0)

        def at_rest(state: State) -> bool:
            return regrets is None or state[regrets] == 0

        play._happens(
            f"{prefix}.send",
            lambda s: s[goal] > 0 and s[ready] > 0 and at_rest(s),
            {goal: -1, ready: -1, sent: 1},
        )
        news: dict[int, int] = {}
        if client.accepted is not None:
            learned, at = play._slot((action, count, "accepted")), play._place(client.accepted, 0)
            news = {learned: 1}
            play._happens(f"{prefix}.learn", lambda s: s[learned] > 0, {learned: -1, at: 1})
            if client.outstanding == 1:
                play.bounds[learned] = 1

        def knows(state: State) -> bool:
            return client.outstanding > 1 or all(state[slot] == 0 for slot in news)

        for number, phase in self.phase.items():
            entry = play._place(action.server.entry, number)
            play._happens(
                f"{prefix}.accept[{number}]",
                lambda s, phase=phase: s[sent] > 0 and s[phase] == IDLE,  # type: ignore[misc]
                {sent: -1, phase: WORKING, self.owner[number]: count, entry: 1, **news},
            )
        if action.server.mayReject:
            play._happens(f"{prefix}.reject", lambda s: s[sent] > 0, {sent: -1, refused: 1})
            told = {} if client.rejected is None else {play._place(client.rejected, 0): 1}
            play._happens(
                f"{prefix}.refused",
                lambda s: s[refused] > 0 and at_rest(s),
                {refused: -1, ready: 1, **told},
            )
            if regrets is not None:
                wish = regrets
                play._happens(
                    f"{prefix}.tooLate.rejected", lambda s: s[wish] > 0 and s[refused] > 0, {wish: -1}
                )
        for outcome, place in self.ends:
            over = play._slot((action, count, outcome))
            fetched: pn.Place | None = getattr(client, outcome)
            got = {} if fetched is None else {play._place(fetched, 0): 1}
            play._happens(
                f"{prefix}.result.{place.id}",
                lambda s, over=over: s[over] > 0 and at_rest(s) and knows(s),  # type: ignore[misc]
                {over: -1, ready: 1, **got},
            )
            for number in self.phase:
                self._end(prefix, client, count, number, outcome, place, over)
        if client.cancel is not None:
            self._ask(prefix, client, count, ready, knows)
        if action.server.feedback is not None:
            self._feedback(prefix, client, count)

    def _is(self, number: int, count: int, phase: int) -> Guard:
        """Tell when a slot works on a goal of a client and has got so far with it."""
        slot, owner = self.phase[number], self.owner[number]
        return lambda s: s[slot] == phase and s[owner] == count

    def _end(
        self,
        prefix: str,
        client: sym.ActionClientPort,
        count: int,
        number: int,
        outcome: str,
        place: pn.Place,
        over: int,
    ) -> None:
        """Let a goal end in one way: as it is, while a request to cancel is under way, or to be canceled."""
        play, server = self.play, self.action.server
        result = play._place(place, number)
        untold = None if server.feedback is None else play._place(server.feedback, number)
        noted = None if server.cancel is None else play._place(server.cancel, number)

        def end(word: str, phase: int, guard: Guard, more: dict[int, int]) -> None:
            at = self._is(number, count, phase)
            effect = {result: -1, self.phase[number]: -phase, self.owner[number]: -count, over: 1, **more}
            play._happens(
                f"{prefix}.{word}.{place.id}[{number}]",
                lambda s: s[result] > 0 and at(s) and (untold is None or s[untold] == 0) and guard(s),
                effect,
            )

        if outcome != "canceled":
            end("finish", WORKING, lambda s: True, {})
            if client.cancel is not None:
                end("late", ASKED, lambda s: True, {})
        if client.cancel is not None and noted is not None:
            end("heeded", CANCELING, lambda s: s[noted] == 0, {})
            end("unheeded", CANCELING, lambda s: s[noted] > 0, {noted: -1})

    def _ask(self, prefix: str, client: sym.ActionClientPort, count: int, ready: int, knows: Guard) -> None:
        play = self.play
        assert client.cancel is not None
        wish = play._place(client.cancel, 0)
        play._requests.add(wish)
        for number, phase in self.phase.items():
            for word, at, effect in (
                ("cancel", WORKING, {wish: -1, phase: ASKED - WORKING}),
                ("again", CANCELING, {wish: -1}),
            ):
                if word == "again" and self.action.server.cancel is None:
                    continue
                here = self._is(number, count, at)
                play._happens(
                    f"{prefix}.{word}[{number}]",
                    lambda s, here=here, word=word: (  # type: ignore[misc]
                        s[wish] > 0 and here(s) and (word == "again" or knows(s))
                    ),
                    effect,
                )
        for outcome, place in self.ends:
            over = play._slots[self.action, count, outcome]
            play._happens(
                f"{prefix}.tooLate.{place.id}",
                lambda s, over=over: s[wish] > 0 and s[over] > 0,  # type: ignore[misc]
                {wish: -1},
            )
        all_ready = client.outstanding
        if all_ready == 1:
            play._happens(f"{prefix}.twice", lambda s: s[wish] > 1, {wish: -1})
        play._happens(f"{prefix}.nothing", lambda s: s[wish] > 0 and s[ready] == all_ready, {wish: -1})

    def _feedback(self, prefix: str, client: sym.ActionClientPort, count: int) -> None:
        """Let a slot tell the client whose goal it has; who does not listen hears nothing."""
        play, source = self.play, self.action.server.feedback
        assert source is not None
        come: dict[int, int] = {}
        if client.feedback is not None:
            arrived = play._history(f"{prefix}.feedback", self.action.depth, play._place(client.feedback, 0))
            play.bounds[arrived] = 1
            come = {arrived: 1}
        for number, owner in self.owner.items():
            told = play._place(source, number)
            play._happens(
                f"{prefix}.feedback[{number}]",
                lambda s, told=told, owner=owner: s[told] > 0 and s[owner] == count,  # type: ignore[misc]
                {told: -1, **come},
            )
