"""The action servers of a node: slots that execute goals, cancel requests, feedback and results.

A server accepts the oldest goal when one of its slots is free. If no slot is free, the goal and the answer to
its client wait; a server that may reject goals refuses such a goal at once. It also refuses goals that the
developers' code rejects. A goal that arrives twice is executed once, and its acceptance is sent twice. The
server keeps results for clients that ask for them later.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from types import MappingProxyType

from dineros.metamodel.errors import FeatureValueError
from dineros.runtime.channels.goals import (
    CancelArrived,
    GoalArrived,
    KnownGoal,
    ServerEvent,
)
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.firing.cancels import CancelRequest
from dineros.runtime.journal.goals import KEPT_RESULTS
from dineros.runtime.nets.ports import ActionServerPort, Data, Message, OutcomeKind

LONGEST_QUEUE = 1000
"""Maximum number of goals that wait for a slot; further goals are refused."""


class Slot:
    """Executes one goal at a time.

    Attributes
    ----------
    entry : int
            The place onto which a new goal is put.
    exits : dict of str to int
        Outcome -> the place of results.
    cancel, feedback : int or None
            The place for cancel requests, and the place from which feedback is sent.
    departures : dict of str to int
        Numbers of the departures, by outcome and ``feedback``.
    goal : Message or None
        The goal's id and data; None: the slot is idle.
    is_canceling : bool
        Whether the goal is to be canceled.
    sent : int
            Number of feedback messages sent for the goal.
    history : deque of (int, Data)
        The last feedback, with its numbers.
    request : CancelRequest
            The cancel request as the goal's handlers see it; a new object for each goal.
    """

    def __init__(self, traffic: Traffic, server: ActionServer, number: int) -> None:
        port, places = server.port, traffic.places
        self.server = server
        self.number = number
        self.entry = places[port.entries[number]]
        self.cancel = places[port.cancels[number]] if port.cancels else None
        self.feedback = places[port.feedbacks[number]] if port.feedbacks else None
        self.exits = {outcome: places[exits[number]] for outcome, exits in port.outcomes.items()}
        self.departures: dict[str, int] = {
            outcome: traffic.add_departure(place, partial(server.finish, self, outcome), port, "result")
            for outcome, place in self.exits.items()
        }
        if self.feedback is not None:
            send = partial(server.send_feedback, self)
            self.departures["feedback"] = traffic.add_departure(self.feedback, send, port, "feedback")
        self.goal: Message | None = None
        self.is_canceling = False
        self.sent = 0
        self.history: deque[tuple[int, Data]] = deque(maxlen=max(1, server.port.depth))
        self.request = CancelRequest()


class ActionServer:
    """The server of one action of the node.

    Parameters
    ----------
    traffic : Traffic
            Shared by all ports of the node.
    port : ActionServerPort
        Its port.
    accepts : callable
            Decides from the data of a received goal whether it is accepted.

    Attributes
    ----------
    slots : list of Slot
        Its slots.
    waiting : deque
            Goals that wait for a slot, the oldest first, each with the functions that answer its clients.
    results : dict of str to (str, Data)
            Outcome and result of the last goals that ended, by id.
    """

    def __init__(
        self, traffic: Traffic, port: ActionServerPort, accepts: Callable[[Data], bool] = lambda goal: True
    ) -> None:
        self._traffic = traffic
        self._accepts = accepts
        self.port = port
        self.slots = [Slot(traffic, self, number) for number in range(port.slots)]
        self.waiting: deque[tuple[Message, list[Callable[[bool], None]]]] = deque()
        self.results: dict[str, tuple[OutcomeKind, Data]] = {}
        self._cancels: list[CancelArrived] = []  # cancel requests that wait for room

    def begin(self) -> None:
        """Let slots continue with their goals from before a restart."""
        known = [
            KnownGoal(Message(goal, data), outcome=outcome) for goal, (outcome, data) in self.results.items()
        ]
        known += [KnownGoal(slot.goal, slot.is_canceling) for slot in self.slots if slot.goal is not None]
        transport = self._traffic.joined
        transport.restore_goals(self.port, known)
        for slot in self.slots:
            self._repeat_feedback(slot)

    def restore(
        self, slot: Slot, goal: Message, is_canceling: bool, sent: int, history: Sequence[tuple[int, Data]]
    ) -> None:
        """Assign a goal from before a restart to a slot."""
        self._open(slot, goal)
        slot.sent = sent
        slot.history.extend(history)
        if is_canceling:
            self._let_cancel(slot)

    def take(self, event: ServerEvent) -> None:
        """Handle a goal or a cancel request that arrived."""
        if isinstance(event, GoalArrived):
            self._asked(event.message, event.answer)
        elif not self._try_cancel(event):
            self._cancels.append(event)

    # Goals.

    def _asked(self, goal: Message, answer: Callable[[bool], None]) -> None:
        slot = self._slot_of(goal.id)
        if slot is not None or goal.id in self.results:
            answer(True)
            if slot is not None:
                self._repeat_feedback(slot)
            return
        for waiting, answers in self.waiting:
            if waiting.id == goal.id:
                answers.append(answer)
                return
        if not self._is_wanted(goal):
            answer(False)
            return
        self.waiting.append((goal, [answer]))
        self.serve()
        if self.waiting and (self.port.may_reject or len(self.waiting) > LONGEST_QUEUE):
            for refuse in self.waiting.pop()[1]:
                refuse(False)

    def _is_wanted(self, goal: Message) -> bool:
        try:
            data = self._traffic.engine.passing.checkers[self.slots[0].entry].complete(goal.data)
        except FeatureValueError:
            return True  # it is refused and recorded later, when its token would be made
        return self._accepts(data)

    def _slot_of(self, goal: str) -> Slot | None:
        return next((slot for slot in self.slots if slot.goal is not None and slot.goal.id == goal), None)

    def serve(self) -> None:
        """Give waiting goals, the oldest first, to idle slots whose place has room."""
        traffic, port = self._traffic, self.port
        for slot in self.slots:
            while slot.goal is None and self.waiting and traffic.engine.has_room(slot.entry):
                goal, answers = self.waiting.popleft()
                token = traffic.arriving(port.action, slot.entry, goal.data)
                if token is not None:
                    self._open(slot, Message(goal.id, token.data))
                    traffic.engine.put(slot.entry, token)
                    place = port.entries[slot.number]
                    self._emit("accept", slot, place, token.id, 1, data=token.data)
                for answer in answers:  # after the record: an answer promises that the goal is accepted
                    answer(token is not None)

    def _open(self, slot: Slot, goal: Message) -> None:
        slot.goal, slot.is_canceling, slot.sent = goal, False, 0
        slot.history.clear()
        slot.request = CancelRequest()
        for name, departure in slot.departures.items():
            if name != "canceled":
                self._traffic.engine.unhold(departure)

    # Requests to cancel.

    def _try_cancel(self, event: CancelArrived) -> bool:
        """Cancel the goals that can be canceled; False: a place has no room for a cancel request."""
        slots = [self._slot_of(goal) for goal in event.goals]
        free = [slot for slot in slots if slot is not None and not slot.is_canceling]
        has_room = self._traffic.engine.has_room
        if any(slot.cancel is not None and not has_room(slot.cancel) for slot in free):
            return False
        canceling = []
        for goal, slot in zip(event.goals, slots, strict=True):
            if slot is not None and not slot.is_canceling and slot.cancel is not None:
                self._put_request(slot, slot.cancel)
            if slot is not None and slot.is_canceling:
                canceling.append(goal)
        event.answer(canceling)
        return True

    def _put_request(self, slot: Slot, place: int) -> None:
        engine = self._traffic.engine
        assert slot.goal is not None
        types = engine.structure.types
        is_alike = types[place] is types[slot.entry]
        token = engine.new_token(slot.goal.data if is_alike else engine.passing.checkers[place].default)
        engine.put(place, token)
        self._let_cancel(slot)
        self._emit("canceling", slot, engine.structure.places[place], token.id, 1, data=token.data)

    def _let_cancel(self, slot: Slot) -> None:
        slot.is_canceling = True
        slot.request.set()
        departure = slot.departures.get("canceled")
        if departure is not None:
            self._traffic.engine.unhold(departure)

    def let_in(self) -> None:
        """Handle what waits for room, as far as there is room now."""
        self._cancels = [event for event in self._cancels if not self._try_cancel(event)]
        self.serve()

    # Feedback and results.

    def send_feedback(self, slot: Slot) -> None:
        """Send the oldest feedback token of a slot.

        Feedback of an existing action type has no number by which the client could recognise a copy. So it is
        recorded before it is sent: it arrives once or, if the node is killed in between, not at all.
        """
        traffic, place = self._traffic, slot.feedback
        assert slot.goal is not None and place is not None
        data, number = traffic.engine.oldest(place).data, slot.sent + 1
        has_number = self.port.type is None
        try:
            traffic.check(place, data)
            if has_number:
                traffic.joined.give_feedback(self.port, slot.goal.id, number, data)
        except Exception as error:
            raise SendError(f"cannot send feedback of {self.port.action}: {error}") from error
        token = traffic.engine.take(place)
        slot.sent = number
        slot.history.append((number, data))
        self._emit("feedback", slot, self.port.feedbacks[slot.number], token.id, -1, number=number)
        if not has_number:
            try:
                traffic.joined.give_feedback(self.port, slot.goal.id, number, data)
            except Exception as error:
                traffic.log_error(f"feedback of {self.port.action} is lost: {error}", cause=error)

    def _repeat_feedback(self, slot: Slot) -> None:
        """Send feedback again that a restarted client may have missed; the client ignores known feedback."""
        if slot.goal is None or self.port.type is not None:  # an existing type has no number
            return
        for number, data in slot.history:
            self._traffic.joined.give_feedback(self.port, slot.goal.id, number, data)

    def finish(self, slot: Slot, outcome: OutcomeKind) -> None:
        """Send the oldest token of an exit as the result, after all feedback; the slot is idle then."""
        traffic, port, place = self._traffic, self.port, slot.exits[outcome]
        assert slot.goal is not None
        engine, goal = traffic.engine, slot.goal
        told = slot.departures.get("feedback")
        while told is not None and told in engine.due:
            self.send_feedback(slot)
        noted = self._unheeded(slot)
        data = engine.oldest(place).data
        try:
            traffic.check(place, data)
            traffic.joined.finish_goal(port, goal.id, outcome, data)
        except Exception as error:
            raise SendError(f"cannot send a result of {port.action}: {error}") from error
        token = engine.take(place)
        self.keep(goal.id, outcome, data)
        at, change = port.outcomes[outcome][slot.number], {}
        if noted is not None and slot.cancel is not None:
            engine.take(slot.cancel)
            change = {port.cancels[slot.number]: -1}
        self._emit("finish", slot, at, token.id, -1, change, outcome=outcome, unheeded=noted)
        for name, departure in slot.departures.items():
            if name != "canceled" or slot.is_canceling:
                engine.hold(departure)
        slot.goal, slot.is_canceling = None, False
        self.serve()

    def _unheeded(self, slot: Slot) -> int | None:
        """Return the id of a cancel request that the goal left unused; the next goal must not take it."""
        engine, place = self._traffic.engine, slot.cancel
        if place is None or not engine.count(place):
            return None
        free = self._traffic.engine.free_tokens(place)
        if not free:
            raise SendError(f"a goal of {self.port.action} cannot end while a handler works on its cancel")
        return free[0].id

    def keep(self, goal: str, outcome: OutcomeKind, data: Data) -> None:
        """Keep a result for a client that asks for it later."""
        self.results[goal] = (outcome, data)
        if len(self.results) > KEPT_RESULTS:
            del self.results[next(iter(self.results))]

    def _emit(
        self,
        event: str,
        slot: Slot,
        place: str,
        token: int,
        gained: int,
        more: Mapping[str, int] = MappingProxyType({}),
        **fields: object,
    ) -> None:
        observer = self._traffic.observer
        if observer.is_observing:
            assert slot.goal is not None
            observer.emit(
                event,
                channel=self.port.channel,
                instance=slot.number + 1,
                place=place,
                token=token,
                message=slot.goal.id,
                change={place: gained, **more},
                **fields,
            )
