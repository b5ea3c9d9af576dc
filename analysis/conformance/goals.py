"""Replays the goals of actions (rules A1 to A7): each step has the id of its goal.

A goal is sent before it is accepted, and ends before its client is informed. A cancel request that the client
sends meanwhile is under way until the goal ends, or arrives too late.
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from dineros.analysis.conformance.player import Player
from dineros.analysis.conformance.refusals import Fault, Refusal, Waiting
from dineros.analysis.conformance.topics.parts import Queue
from dineros.metamodel import pn, sym
from dineros.metamodel.elements import node_net_of
from dineros.metamodel.records import Drop
from dineros.metamodel.records.declarations import GoalChange

_Key = tuple[GoalChange, str, str | None, int | None, str | None]
"""The effect of a step on a goal (empty for a silent step), channel, client, slot and outcome."""


@dataclass(eq=False)
class _SentGoal:
    """A goal that was sent."""

    id: str
    channel: str
    client: str
    slot: int | None = None
    outcome: str | None = None
    is_told: bool = False
    """Whether its client knows the outcome or the refusal."""


class GoalFlow:
    """The goals of all actions."""

    def __init__(self, player: Player) -> None:
        self._player = player
        self._marking = player.marking
        self._net = net = player.net
        self._goals: dict[tuple[str, str], _SentGoal] = {}
        self._untold: Counter[tuple[str, str]] = Counter()
        self._channels = {
            channel.id: channel for channel in net.model.channels if isinstance(channel, sym.ActionChannel)
        }
        self._steps: defaultdict[_Key, list[int]] = defaultdict(list)
        for link in net.subject.links() if self._channels else ():
            role = net.roles.get(link.target.id or "") if isinstance(link.target, pn.Transition) else None
            if role is None or role.channel not in self._channels or role.queue is not None:
                continue
            client = next((each for each in link.sources if isinstance(each, sym.ActionClientPort)), None)
            name = None if client is None else client.client
            key = (role.kind.declared.goal, role.channel, name, link.index, role.outcome)
            self._steps[key].append(net.subject.transition_index[str(link.target.id)])
        self._queues: dict[tuple[str, str], Queue] = net.feedback_queues

    # The records.

    def step(self, record: Any, forced: bool) -> Refusal | None:
        """Replay a step of a goal. If `forced`, feedback without room is lost."""
        channel = self._channels.get(record.channel)
        if channel is None:
            return Fault(f"the model has no action channel {record.channel!r}")
        goal = self._goals.get((record.channel, record.message or ""))
        change: GoalChange = record.declared.goal
        if change == "is sent":
            return self._sent(record, goal)
        if change == "is asked to cancel" and not record.message:
            return self._canceled_nothing(record)
        if goal is None:
            return self._unknown(record)
        if change == "gives feedback":
            return self._feedback(record, forced, goal)
        return _REPLAYS[change](self, record, goal)

    def _unknown(self, record: Any) -> Refusal:
        """Refuse a step of a goal that was not sent, or not yet."""
        reason = f"goal {record.message} was not sent before"
        if record.declared.end == "server":
            action = self._net.names_in_ros[record.channel]
            outside = f"a program outside of the model also sends goals of {action}"
            return Waiting(reason, self._clients(record.channel), outside)
        return Fault(reason)

    def _sent(self, record: Any, goal: _SentGoal | None) -> Refusal | None:
        if goal is not None:
            return Fault(f"goal {record.message} was sent before")
        client = record.client or ""
        fault = self._fire_one(record, ("is sent", record.channel, client, None, None))
        if fault is None:
            id = record.message or ""
            self._goals[record.channel, id] = _SentGoal(id, record.channel, client)
        return fault

    def _accepted(self, record: Any, goal: _SentGoal) -> Refusal | None:
        if goal.slot is not None or goal.is_told:
            return Fault(f"goal {goal.id} was answered before")
        fault = self._fire_one(record, ("is accepted", goal.channel, goal.client, record.instance, None))
        if fault is None:
            goal.slot = record.instance
        return fault

    def _learned(self, record: Any, goal: _SentGoal) -> Refusal | None:
        key: _Key = ("is known to be accepted", goal.channel, goal.client, None, None)
        if not self._steps.get(key):
            return None  # the client has no place for it
        if goal.slot is None:
            return Waiting(f"goal {goal.id} was not accepted before", (self._server(goal.channel),))
        return self._fire_one(record, key, goal)

    def _rejected(self, record: Any, goal: _SentGoal) -> Refusal | None:
        if goal.slot is not None or goal.is_told:
            return Fault(f"goal {goal.id} was answered before")
        rejecting = self._steps.get(("", goal.channel, goal.client, None, None))
        if not rejecting:
            return Fault("the server rejects no goals")
        told = self._steps["is known to be rejected", goal.channel, goal.client, None, None]
        if not any(map(self._player.is_enabled, told)):
            self._player.fire(rejecting[0])
        fault = self._player.fire_at(record, told[0])
        if fault is None:
            goal.is_told = True
        return fault

    def _canceled_nothing(self, record: Any) -> Refusal | None:
        """Drop a cancel request without a goal: there is none, or a later record shows that it is refused."""
        key: _Key = ("is asked to cancel", record.channel, record.client, None, None)
        if not any(map(self._player.is_enabled, self._steps[key])):
            for rejecting in self._steps["", record.channel, record.client, None, None]:
                if self._player.is_enabled(rejecting):
                    self._player.fire(rejecting)
        return self._fire_one(record, key)

    def _canceled(self, record: Any, goal: _SentGoal) -> Refusal | None:
        if goal.slot is None:
            return Waiting(f"goal {goal.id} was not accepted before", (self._server(goal.channel),))
        if goal.is_told:
            return Fault(f"{goal.client} knows that goal {goal.id} has ended")
        slot = goal.slot if goal.outcome is None else None
        return self._fire_one(record, ("is asked to cancel", goal.channel, goal.client, slot, goal.outcome))

    def _heard_cancel(self, record: Any, goal: _SentGoal) -> Refusal | None:
        key: _Key = ("is to be canceled", goal.channel, None, goal.slot, None)
        if goal.slot != record.instance or goal.outcome is not None:
            return Fault(f"slot {record.instance} does not work on goal {goal.id}")
        if not any(map(self._player.is_enabled, self._steps.get(key, ()))):
            action = self._net.names_in_ros[goal.channel]
            outside = f"a program outside of the model also cancels goals of {action}"
            reason = f"no client has asked to cancel goal {goal.id}"
            return Waiting(reason, self._clients(goal.channel), outside)
        return self._fire_one(record, key)

    def _refused_cancel(self, _: Any, goal: _SentGoal) -> Refusal | None:
        """Replay a refusal by a server without places for cancel requests; other refusals came too late."""
        for transition in self._steps.get(("", goal.channel, None, goal.slot, None), ()):
            if goal.outcome is None and self._player.is_enabled(transition):
                self._player.fire(transition)
        return None

    def _finished(self, record: Any, goal: _SentGoal) -> Refusal | None:
        if goal.slot != record.instance or goal.outcome is not None:
            return Fault(f"slot {record.instance} does not work on goal {goal.id}")
        fault = self._fire_one(record, ("ends", goal.channel, goal.client, goal.slot, record.outcome), goal)
        if fault is None:
            goal.outcome = record.outcome
        return fault

    def _told(self, record: Any, goal: _SentGoal) -> Refusal | None:
        if goal.is_told:
            return Fault(f"{goal.client} knows that goal {goal.id} has ended")
        if goal.outcome is None:
            return Waiting(f"goal {goal.id} has not ended before", (self._server(goal.channel),))
        fault = self._fire_one(
            record, ("is known to have ended", goal.channel, goal.client, None, record.outcome)
        )
        if fault is None:
            goal.is_told = True
        return fault

    # Feedback.

    def _feedback(self, record: Any, forced: bool, goal: _SentGoal) -> Refusal | None:
        if goal.slot != record.instance or goal.outcome is not None:
            return Fault(f"slot {record.instance} does not work on goal {goal.id}")
        queue = self._queues.get((goal.channel, goal.client))
        if queue is not None and self._marking[queue.source] >= 1:
            if self._marking[queue.capacity] > 0:
                self._player.fire(queue.enter)
            elif forced:
                self._player.fire(queue.drop)
                self._untold[goal.channel, goal.client] += 1
            else:
                reason = f"the {queue.text} is full, and no loss was recorded"
                return Waiting(reason, (self._client(goal),), is_forcible=True)
        return self._fire_one(record, ("gives feedback", goal.channel, goal.client, goal.slot, None))

    def _heard(self, record: Any, goal: _SentGoal) -> Refusal | None:
        queue = self._queues.get((goal.channel, goal.client))
        if queue is None:
            return Fault(f"{goal.client} does not receive feedback")
        if self._marking[queue.load] < 1:
            if self._marking[queue.source] < 1:
                return Waiting("no feedback is on its way to it", (self._server(goal.channel),))
            self._player.fire(queue.enter)
        return self._player.fire_at(record, queue.leave)

    def drop(self, record: Drop) -> Refusal | None:
        """Lose the feedback that a client's trace reports as lost, except losses replayed already."""
        of_channel = [key for key in self._queues if key[0] == record.channel]
        key = next((key for key in of_channel if self._place_of(self._queues[key]) == record.place), None)
        if key is None:
            return Fault(f"{record.place!r} does not receive feedback of action channel {record.channel!r}")
        queue = self._queues[key]
        rest = max(0, record.count - self._untold[key])
        overflows = self._marking[queue.source] >= 1 and self._marking[queue.capacity] < 1
        if rest > int(overflows):
            reason = f"the {queue.text} has lost {record.count}, at most {int(overflows)} can be lost"
            return Waiting(reason, (self._server(record.channel),))
        self._untold[key] -= record.count - rest
        if rest:
            self._player.fire(queue.drop)
        return None

    def _place_of(self, queue: Queue) -> str | None:
        return self._net.roles[self._net.net.transitions[queue.leave]].place

    # The net.

    def _fire_one(self, record: Any, key: _Key, goal: _SentGoal | None = None) -> Fault | None:
        """Fire the transition for a record: the enabled one of several candidates."""
        found = self._steps.get(key)
        if not found:
            return Fault(f"action channel {getattr(record, 'channel', '')!r} has no such port")
        enabled = [transition for transition in found if self._player.is_enabled(transition)]
        if goal is not None and not enabled and key[0] == "ends" and key[-1] == "canceled":
            return Fault(f"goal {goal.id} is not to be canceled")
        return self._player.fire_at(record, (enabled or found)[0])

    def _clients(self, channel: str) -> tuple[str, ...]:
        nodes = (node_net_of(client.goal) for client in self._channels[channel].clients)
        return tuple(dict.fromkeys(node.id for node in nodes if node is not None))

    def _client(self, goal: _SentGoal) -> str:
        ports = self._channels[goal.channel].clients
        node = next(node_net_of(port.goal) for port in ports if port.client == goal.client)
        return "" if node is None else node.id

    def _server(self, channel: str) -> str:
        node = node_net_of(self._channels[channel].server.entry)
        return "" if node is None else node.id


_REPLAYS: Mapping[GoalChange, Callable[[GoalFlow, Any, _SentGoal], Refusal | None]] = {
    "is accepted": GoalFlow._accepted,
    "is known to be accepted": GoalFlow._learned,
    "is known to be rejected": GoalFlow._rejected,
    "is asked to cancel": GoalFlow._canceled,
    "is to be canceled": GoalFlow._heard_cancel,
    "is not canceled": GoalFlow._refused_cancel,
    "has its feedback heard": GoalFlow._heard,
    "ends": GoalFlow._finished,
    "is known to have ended": GoalFlow._told,
}
