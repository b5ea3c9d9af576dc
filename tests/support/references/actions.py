"""The goals of actions, as the interpreter of `reference_histories` plays them: who has which slot.

A goal is sent, accepted into a slot that is free or refused, worked on, and over; its client hears of it and
may send another one. A request to cancel names its goal: it leaves the client only while a slot works on a
goal of that client, and either the server hears it, or the goal is over first and the request is gone; so it
is where the goal is over, and the client has not heard of that. What asks for nothing that could be canceled
is gone at once. A client of one goal takes no answer and sends no goal while it has such a request; of two,
one is gone. A client of several goals may have one request for each of them: one more is gone, before the
client sends a goal, and those of a goal that is over before it takes the answer. A client that does not wait
hands each request over at once. A goal that is to be canceled may end in any way, others are not canceled;
whether the work has taken note of the request or not, none of it is left over for the next goal of the slot.
Feedback of a goal is told before the goal is over.

A client that does not wait sends whatever is to be sent. Then each goal comes to a history of the action that
keeps ten, whoever sent it, and is lost where that is full; so are results and answers for that client, where
ten of them wait for it, or one of another kind that waits is lost in the place of the one that comes. What
it asks to cancel may be a goal that is over.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from dineros.metamodel import pn, sym

if TYPE_CHECKING:
    from tests.support.references.histories import Guard, Interpreter, State

UNLIMITED = -1
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
        self.is_piled = any(play.goals[client] == UNLIMITED for client in action.clients)
        self.comes: dict[tuple[int, str], int] = {}
        """Where the results of a client are at first, by the number of the client and the outcome."""
        self.ready: dict[sym.ActionClientPort, int] = {}
        """How many goals a client may send besides those under way, where their number is limited."""
        self.kept: list[int] = []
        """Slots of the goals that wait, where a client does not wait."""
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
            if play.goals[client] == UNLIMITED and client.goal.capacity is None:
                slot = play._place(client.goal, 0)
                puts = (use.gives.get(slot, 0) for use in play._uses.values())
                play._bound(slot, max(1, client.goal.tokens, *puts))
            if client.cancel is not None:
                self._bound_regrets(client, client.cancel)
            if client.feedback is None or server.feedback is None or client.feedback.capacity is not None:
                continue
            slot = play._place(client.feedback, 0)
            if slot in play._requests or any(use.effect().get(slot, 0) < 0 for use in play._uses.values()):
                needs = (use.needs.get(slot, 0) for use in play._uses.values())
                play._bound(slot, max(1, client.feedback.tokens, *needs))

    def _bound_regrets(self, client: sym.ActionClientPort, cancel: pn.Place) -> None:
        """Let few requests to cancel wait: those of one firing, and of several goals one for each."""
        play, goals = self.play, self.play.goals[client]
        slot = play._place(cancel, 0)
        most = max(1, cancel.tokens, *(use.gives.get(slot, 0) for use in play._uses.values()))
        if goals <= 1:
            play._bound(slot, most + (goals == 1))
            return
        ready = self.ready[client]
        play.moving_bounds[slot] = lambda s: most + goals - s[ready]

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
        at_once = play.goals[client]
        is_free = at_once == UNLIMITED
        ready = None if is_free else play._slot((action, count, "ready"), at_once)
        if ready is not None:
            self.ready[client] = ready
        takes, readies = ({}, {}) if ready is None else ({ready: -1}, {ready: 1})
        sent, refused = (play._slot((action, count, word)) for word in ("sent", "refused"))
        goal = play._place(client.goal, 0)
        play._requests.add(goal)
        regrets = None
        if client.cancel is not None and not is_free:
            regrets = play._place(client.cancel, 0)
        come = self._arrive(prefix, count, sent, not is_free) if self.is_piled else sent

        def at_rest(state: State, over: int = 1) -> bool:
            """Tell whether each request to cancel has a goal under way, without those that are over."""
            if regrets is None or ready is None:
                return True
            return state[regrets] <= at_once - state[ready] - over

        play._happens(
            f"{prefix}.send",
            lambda s: s[goal] > 0 and (ready is None or s[ready] > 0) and at_rest(s, over=0),
            {goal: -1, come: 1, **takes},
        )
        answers: list[int] = []
        news: dict[int, int] = {}
        if client.accepted is not None:
            learned, at = play._slot((action, count, "accepted")), play._place(client.accepted, 0)
            told = self._answer(f"{prefix}.answers.accepted", answers, learned) if is_free else learned
            news = {told: 1}
            play._happens(f"{prefix}.learn", lambda s: s[learned] > 0, {learned: -1, at: 1})
            if at_once == 1:
                play.bounds[learned] = 1

        def knows(state: State) -> bool:
            return at_once != 1 or all(state[slot] == 0 for slot in news)

        for number, phase in self.phase.items():
            entry = play._place(action.server.entry, number)
            play._happens(
                f"{prefix}.accept[{number}]",
                lambda s, phase=phase: s[sent] > 0 and s[phase] == IDLE,  # type: ignore[misc]
                {sent: -1, phase: WORKING, self.owner[number]: count, entry: 1, **news},
            )
        if action.server.mayReject:
            to = self._answer(f"{prefix}.answers.rejected", answers, refused) if is_free else refused
            if is_free and client.accepted is not None:
                (told,) = news
                self._replace(f"{prefix}.answers.accepted.instead", told, answers, learned, refused)
                self._replace(f"{prefix}.answers.rejected.instead", to, answers, refused, learned)
            play._happens(f"{prefix}.reject", lambda s: s[sent] > 0, {sent: -1, to: 1})
            noted = {} if client.rejected is None else {play._place(client.rejected, 0): 1}
            play._happens(
                f"{prefix}.refused",
                lambda s: s[refused] > 0 and at_rest(s),
                {refused: -1, **readies, **noted},
            )
            if regrets is not None:
                wish = regrets
                play._happens(
                    f"{prefix}.tooLate.rejected", lambda s: s[wish] > 0 and s[refused] > 0, {wish: -1}
                )
        results: list[int] = []
        for outcome, place in self.ends:
            over = play._slot((action, count, outcome))
            comes = self._answer(f"{prefix}.results.{place.id}", results, over) if is_free else over
            fetched: pn.Place | None = getattr(client, outcome)
            got = {} if fetched is None else {play._place(fetched, 0): 1}
            play._happens(
                f"{prefix}.result.{place.id}",
                lambda s, over=over: s[over] > 0 and at_rest(s) and knows(s),  # type: ignore[misc]
                {over: -1, **readies, **got},
            )
            for number in self.phase:
                self._end(prefix, client, count, number, outcome, place, comes)
            self.comes[count, outcome] = comes
        for (outcome, place), kept in zip(self.ends, results, strict=False):
            for (_, other), lost in zip(self.ends, results, strict=False):
                if kept != lost:
                    name = f"{prefix}.results.{place.id}.instead.{other.id}"
                    self._replace(name, self.comes[count, outcome], results, kept, lost)
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

    def _arrive(self, prefix: str, count: int, kept: int, is_counted: bool) -> int:
        """Let goals of a client come to the history of the action; return where they come."""
        play, all_kept = self.play, self.kept
        all_kept.append(kept)
        gone = {play._slot((self.action, count, "lost")): 1} if is_counted else {}
        return self._enter(f"{prefix}.goals", (self.action, count, "come"), all_kept, kept, gone)

    def _answer(self, name: str, all_kept: list[int], kept: int) -> int:
        """Let answers of one kind come to a history of a client; return where they come."""
        all_kept.append(kept)
        return self._enter(name, ("come", name), all_kept, kept, {})

    def _replace(self, name: str, come: int, all_kept: list[int], kept: int, lost: int) -> None:
        """Let one that comes take the place of one of another kind in a full history."""
        self.play._happens(
            name,
            lambda s: s[come] > 0 and s[lost] > 0 and sum(s[each] for each in all_kept) == 10,
            {come: -1, lost: -1, kept: 1},
        )

    def _enter(self, name: str, key: object, all_kept: list[int], kept: int, gone: dict[int, int]) -> int:
        play = self.play
        come = play._slot(key)
        play.bounds[come] = 1
        play._happens(
            f"{name}.in",
            lambda s: s[come] > 0 and sum(s[each] for each in all_kept) < 10,
            {come: -1, kept: 1},
        )
        play._happens(
            f"{name}.drop",
            lambda s: s[come] > 0 and sum(s[each] for each in all_kept) == 10,
            {come: -1, **gone},
        )
        return come

    def _ask(
        self, prefix: str, client: sym.ActionClientPort, count: int, ready: int | None, knows: Guard
    ) -> None:
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
            over = self.comes[count, outcome]
            play._happens(
                f"{prefix}.tooLate.{place.id}",
                lambda s, over=over: s[wish] > 0 and s[over] > 0,  # type: ignore[misc]
                {wish: -1},
            )
        all_ready = play.goals[client]
        if all_ready == 1:
            play._happens(f"{prefix}.twice", lambda s: s[wish] > 1, {wish: -1})
        elif ready is not None:
            play._happens(f"{prefix}.more", lambda s: s[wish] > all_ready - s[ready], {wish: -1})
        play._happens(
            f"{prefix}.nothing",
            lambda s: s[wish] > 0 and (ready is None or s[ready] == all_ready),
            {wish: -1},
        )

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
