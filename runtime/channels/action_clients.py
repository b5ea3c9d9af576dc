"""The action clients of a node: they send goals, ask to cancel them, and receive feedback and results.

A goal is sent again with the same id until the server answers. After a restart, the client asks for the
results of its accepted goals again.

A cancel request is for the oldest accepted goal that the client has not asked to cancel yet. If all goals are
being canceled, or no goal is under way, the request is dropped. While a goal waits for the answer of the
server, the cancel request waits too. If more requests wait than goals are under way, one of them is dropped:
before the client takes the outcome of a goal, which has none then, and before it sends the next goal (rule
A8).
"""

from __future__ import annotations

import logging
from collections import deque
from dataclasses import dataclass

from dineros.runtime.channels.clients import resend_delay
from dineros.runtime.channels.goals import (
    CancelAnswered,
    ClientEvent,
    FeedbackArrived,
    GoalAnswered,
    GoalEnded,
    GoalFailed,
    GoalUnknown,
    goal_id,
)
from dineros.runtime.channels.traffic import SendError, Traffic
from dineros.runtime.nets.ports import OUTCOMES, ActionClientPort, Data, Message, OutcomeKind
from dineros.runtime.nets.tokens import Token
from dineros.runtime.scheduling.timers import IDLE, Timer

LOG = logging.getLogger("dineros.runtime")


@dataclass(eq=False)
class GoalUnderWay:
    """A goal that has not ended yet.

    Attributes
    ----------
    message : Message
            Id and data of the goal.
    is_accepted : bool
        Whether the server has accepted it.
    is_canceled : bool
            Whether the client has asked the server to cancel it.
    is_canceling : bool
            Whether the server has agreed to cancel it.
    heard : int
            Number of the last feedback received.
    attempts : int
            How many times it was sent.
    timer : Timer
            Timer that sends it again.
    ended : tuple or None
            Its outcome and result while they wait for room on their place.
    is_refused : bool
            Whether the server has refused it while the token for the refusal waits for room.
    is_answered : bool
            Whether the server has accepted it; the token for the acceptance may still wait for room.
    """

    message: Message
    is_accepted: bool = False
    is_canceled: bool = False
    heard: int = 0
    attempts: int = 1
    is_canceling: bool = False
    timer: Timer = IDLE
    ended: tuple[OutcomeKind, Data] | None = None
    is_refused: bool = False
    is_answered: bool = False


class ActionClient:
    """Sends the tokens of one place as goals and puts answers, feedback and results onto other places.

    Attributes
    ----------
    goals : dict of str to GoalUnderWay
        By id, the oldest first.
    """

    def __init__(self, traffic: Traffic, port: ActionClientPort) -> None:
        places = traffic.places
        self._traffic = traffic
        self.port = port
        self.goal = places[port.goal]
        self._outcomes = {outcome: places[place] for outcome, place in port.outcomes.items()}
        self._rejected = None if port.rejected is None else places[port.rejected]
        self._accepted_at = None if port.accepted is None else places[port.accepted]
        self._cancel = None if port.cancel is None else places[port.cancel]
        self._feedback = None if port.feedback is None else places[port.feedback]
        self._departure = traffic.add_departure(self.goal, self.send, port)
        if self._cancel is not None:
            self._cancel_departure = traffic.add_departure(self._cancel, self.send_cancel)
        self._surplus = None
        if self._cancel is not None:
            self._surplus = traffic.engine.add_departure(self._cancel, least=2)
            traffic.senders[self._surplus] = self.lose_cancel
        self._capacity = None if self._cancel is None else traffic.engine.structure.capacities[self._cancel]
        self._limit = self._capacity
        """The most cancel requests that may wait now."""
        self._is_cancel_held = True  # the engine initially holds all departures
        self._waiting: deque[FeedbackArrived] = deque()
        self._last: deque[GoalUnderWay] = deque(maxlen=max(1, port.outstanding))
        self.goals: dict[str, GoalUnderWay] = {}

    # Sending.

    def begin(self) -> None:
        """Release departures; goals from before a restart are sent again, or their results are requested."""
        engine = self._traffic.engine
        if len(self.goals) < self.port.outstanding:
            engine.unhold(self._departure)
        for goal in list(self.goals.values()):
            self._send(goal)
            if goal.is_canceled:
                self._traffic.joined.cancel_goal(self.port, goal.message.id)
        if self._surplus is not None:
            engine.unhold(self._surplus)
        self._make_room()
        self._look_at_cancels()

    def send(self) -> None:
        """Send the oldest token as a goal."""
        traffic, port, place = self._traffic, self.port, self.goal
        self._cancel_first(len(self.goals))
        token = traffic.engine.oldest(place)
        goal = GoalUnderWay(Message(goal_id(traffic.next_id(port.goal)), token.data))
        try:
            traffic.joined.send_goal(port, goal.message)
        except Exception as error:
            raise SendError(f"cannot send a goal of {port.action}: {error}") from error
        traffic.engine.take(place)
        traffic.count_sent(port.goal)
        self.goals[goal.message.id] = goal
        if len(self.goals) == port.outstanding:
            traffic.engine.hold(self._departure)
        self._emit("goal", goal.message.id, place=port.goal, token=token.id, change={port.goal: -1})
        self._make_room()
        self._look_at_cancels()

    def send_cancel(self) -> None:
        """Use the oldest cancel token for the oldest goal that can be canceled; none: drop the token."""
        traffic, port = self._traffic, self.port
        assert self._cancel is not None
        goal = self._cancelable()
        if goal is None:
            over = (g for g in self.goals.values() if g.is_canceling or g.ended is not None)
            goal = next(over, None)
        else:
            try:
                traffic.joined.cancel_goal(port, goal.message.id)
            except Exception as error:
                raise SendError(f"cannot cancel a goal of {port.action}: {error}") from error
            goal.is_canceled = True
        self._cancel_leaves(None if goal is None else goal.message.id)
        self._look_at_cancels()

    def lose_cancel(self) -> None:
        """Drop a cancel request: more of them wait than goals are under way."""
        self._cancel_leaves(None)

    def _cancel_leaves(self, goal: str | None) -> None:
        assert self._cancel is not None
        place, token = self.port.cancel, self._traffic.engine.take(self._cancel)
        self._emit("cancel", goal, place=place, token=token.id, change={place: -1})

    def _cancel_first(self, goals: int) -> None:
        """Spend cancel requests until no more than a number of goals are left."""
        if self._cancel is not None:
            while self._traffic.engine.count(self._cancel) > goals:
                self.send_cancel()

    def _make_room(self) -> None:
        """Let as many cancel requests wait as goals are under way, and those of one firing (rule A8)."""
        if self._cancel is None or self._surplus is None:
            return
        goals, engine = len(self.goals), self._traffic.engine
        engine.set_least(self._surplus, self._cancel, max(2, goals + 1))
        if self.port.outstanding > 1 and self._capacity is not None and self._limit is not None:
            limit = min(self._capacity, goals + engine.structure.most_put_at_once(self._cancel))
            engine.change_room(self._cancel, limit - self._limit)
            self._limit = limit

    def _cancelable(self) -> GoalUnderWay | None:
        goals = (g for g in self.goals.values() if g.is_accepted and g.ended is None)
        return next((goal for goal in goals if not goal.is_canceled), None)

    def _look_at_cancels(self) -> None:
        """Hold cancel requests while goals wait for an answer and none can be canceled; else release them."""
        if self._cancel is None:
            return
        goals = self.goals.values()
        is_held = bool(goals) and self._cancelable() is None and not any(each.is_canceling for each in goals)
        if is_held is not self._is_cancel_held:
            self._is_cancel_held = is_held
            engine = self._traffic.engine
            (engine.hold if is_held else engine.unhold)(self._cancel_departure)

    # Receiving.

    def take(self, event: ClientEvent) -> None:
        """Handle an event about a goal; ignored if the goal is not under way, except for late feedback."""
        if isinstance(event, FeedbackArrived):
            self._hear(event)
            return
        goal = self.goals.get(event.goal)
        if goal is None or goal.ended is not None or goal.is_refused:
            return
        match event:
            case GoalAnswered(is_accepted=True):
                self._accepted(goal)
            case GoalAnswered():
                goal.is_refused = True
                self._refused(goal)
            case GoalFailed(reason=reason):
                self._failed(goal, reason)
            case GoalUnknown():
                self._unknown(goal)
            case CancelAnswered(is_accepted=is_accepted):
                goal.is_canceled = goal.is_canceling = is_accepted
                if not is_accepted:
                    self._emit("tooLate", event.goal)
                self._look_at_cancels()
            case GoalEnded(outcome=outcome, data=data):
                self._accepted(goal)
                goal.ended = (outcome, data)
                self._ended(goal)

    def _accepted(self, goal: GoalUnderWay) -> None:
        goal.timer.cancel()
        place = self._accepted_at
        if goal.is_accepted:
            return
        goal.is_answered = True
        if place is not None and not self._traffic.engine.has_room(place):
            return
        goal.is_accepted = True
        token = None if place is None else self._token(place, goal.message.data, self.goal)
        self._put("accepted", goal.message.id, place, token)
        self._look_at_cancels()

    def _failed(self, goal: GoalUnderWay, reason: str) -> None:
        """Record that the server did not answer a goal, and schedule sending it again."""
        goal.timer.cancel()
        LOG.warning("goal %s of %s: %s", goal.message.id, self.port.action, reason)
        self._emit("timeout", goal.message.id, attempt=goal.attempts)
        delay = resend_delay(goal.attempts)
        goal.attempts += 1
        goal.timer = self._traffic.loop.timers.call_later(delay, lambda: self._send_again(goal))

    def _send_again(self, goal: GoalUnderWay) -> None:
        if goal.message.id in self.goals:
            self._send(goal)

    def _send(self, goal: GoalUnderWay) -> None:
        transport = self._traffic.joined
        send = transport.follow_goal if goal.is_accepted else transport.send_goal
        try:
            send(self.port, goal.message)
        except Exception as error:
            self._failed(goal, f"cannot be sent: {error}")

    def _unknown(self, goal: GoalUnderWay) -> None:
        """End an accepted goal that the server no longer knows; send a goal again that was not accepted."""
        if not goal.is_accepted:
            self._failed(goal, "the server does not know it")
            return
        text = f"the server of {self.port.action} has lost the goal {goal.message.id}: it counts as aborted"
        self._traffic.log_error(text)
        goal.ended = ("aborted", {})
        self._ended(goal)

    def _refused(self, goal: GoalUnderWay) -> None:
        goal.timer.cancel()
        self._cancel_first(len(self.goals) - 1)
        place = self._rejected
        if place is not None and not self._traffic.engine.has_room(place):
            return
        token = None if place is None else self._token(place, goal.message.data, self.goal)
        self._settle(goal)
        self._put("reject", goal.message.id, place, token)

    def _ended(self, goal: GoalUnderWay) -> None:
        assert goal.ended is not None
        if not goal.is_accepted:
            return  # the token for the acceptance waits for room
        self._cancel_first(len(self.goals) - 1)
        outcome, data = goal.ended
        place = self._outcomes.get(outcome)
        if place is not None and not self._traffic.engine.has_room(place):
            return
        token = None if place is None else self._token(place, data)
        self._settle(goal)
        self._put("outcome", goal.message.id, place, token, outcome=outcome)

    def _token(self, place: int, data: Data, like: int | None = None) -> Token:
        """Return a token for a place; if `like` has another token type, the token gets default data."""
        engine = self._traffic.engine
        if like is not None and engine.structure.types[like] is not engine.structure.types[place]:
            data = {}
        made = self._traffic.arriving(self.port.action, place, data)
        return made or engine.new_token(engine.passing.checkers[place].default)

    def _put(self, event: str, goal: str, place: int | None, token: Token | None, **more: object) -> None:
        if place is None or token is None:
            self._emit(event, goal, place=None, token=None, data={}, change={}, **more)
            return
        self._traffic.engine.put(place, token)
        id = self._traffic.engine.structure.places[place]
        fields = {"place": id, "token": token.id, "data": token.data, "change": {id: 1}}
        self._emit(event, goal, **fields, **more)

    def _settle(self, goal: GoalUnderWay) -> None:
        """Remove a goal that has ended; the next one may be sent."""
        if len(self.goals) == self.port.outstanding:
            self._traffic.engine.unhold(self._departure)
        del self.goals[goal.message.id]
        self._last.append(goal)
        self._make_room()
        self._look_at_cancels()

    def _hear(self, event: FeedbackArrived) -> None:
        late = next((goal for goal in self._last if goal.message.id == event.goal), None)
        goal = self.goals.get(event.goal, late)
        if goal is None or self._feedback is None or 0 < event.number <= goal.heard:
            return
        if event.number:
            self._lose(event.number - goal.heard - 1)
            goal.heard = event.number
        self._waiting.append(event)
        if not self._traffic.engine.has_room(self._feedback) and len(self._waiting) > self.port.depth:
            self._waiting.popleft()
            self._lose(1)
        self._let_feedback_in()

    def _lose(self, count: int) -> None:
        if count > 0:
            self._traffic.lost(self.port, "feedback", count, self.port.feedback)

    def _let_feedback_in(self) -> None:
        place, engine = self._feedback, self._traffic.engine
        assert place is not None
        while self._waiting and engine.has_room(place):
            event = self._waiting.popleft()
            token = self._traffic.arriving(self.port.action, place, event.data)
            if token is not None:
                self._put("hear", event.goal, place, token, number=event.number)

    def let_in(self) -> None:
        """Put the tokens that wait for room, as far as their places have room now."""
        for goal in list(self.goals.values()):
            if goal.is_answered and not goal.is_accepted:
                self._accepted(goal)
            if goal.is_refused:
                self._refused(goal)
            elif goal.ended is not None:
                self._ended(goal)
        if self._feedback is not None:
            self._let_feedback_in()

    def _emit(self, event: str, goal: str | None, **fields: object) -> None:
        observer, port = self._traffic.observer, self.port
        if observer.is_observing:
            observer.emit(event, channel=port.channel, client=port.client, message=goal, **fields)

    @property
    def places(self) -> frozenset[int]:
        """The places onto which tokens for received messages are put."""
        found = [
            self._rejected,
            self._accepted_at,
            self._feedback,
            *(self._outcomes.get(outcome) for outcome in OUTCOMES),
        ]
        return frozenset(place for place in found if place is not None)
