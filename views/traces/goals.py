"""The bars of goals of actions, with the times of sending, acceptance, cancellation, end and feedback.

A bar is on a lane of its client. If a client has several goals under way, each has a row of its own,
which is reused when it is over. A mark holds the number of the goal on its lane, and then of
``s`` the slot and of ``a`` how it ended, as an index of `ENDS`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from dineros.views.traces.facts import Facts
from dineros.views.traces.lanes import Lane, Lanes

ENDS = ("succeeded", "aborted", "canceled", "rejected")
"""Ends of a goal, for its client."""

_WORDS = {end: "has succeeded" if end == "succeeded" else f"is {end}" for end in ENDS}


@dataclass(eq=False)
class _Bar:
    """A goal: its lane, and its number there."""

    lane: Lane
    client: str
    number: int


class GoalBars:
    """Finds the bar of each record of a goal."""

    def __init__(self, lanes: Lanes, facts: Facts) -> None:
        self._lanes, self._facts = lanes, facts
        self._bars: dict[tuple[str, str], _Bar] = {}  # by channel and goal
        self._in_slot: dict[tuple[str, int | None], _Bar] = {}
        self._under_way: dict[tuple[str, str], list[_Bar]] = {}
        self._counts: dict[int, int] = {}

    def lane(self, channel: str, client: str, node: str | None, row: int = 0) -> Lane:
        """Return a lane of a client."""
        note = f"C {client}" + (f" ({row + 1})" if row else "")
        return self._lanes.make(
            "goals", channel, client, str(row), group="actions", kind="client",
            id=client if not row else f"{client} ({row + 1})",
            label=self._facts.channel_name(channel), note=note, node=node, channel=channel,
        )  # fmt: skip

    def mark(self, record: Any, node: str | None) -> tuple[Lane, list[Any] | None, str]:
        """Return the lane of a record, its mark, and its description; no mark: nothing is drawn."""
        bar, change = self._bar(record, node), record.declared.goal
        number, name = bar.number, self._facts.channel_name(record.channel)
        client, slot = f"client {bar.client}", f"slot {getattr(record, 'instance', None) or '?'}"
        if not change:
            return (
                bar.lane,
                ["o", number],
                f"{client} of action {name} gets no response in time: sends its goal again",
            )
        own, none = f"its goal of action {name}", f"a goal of action {name}, and has none"
        end = getattr(record, "outcome", "rejected")
        happens = record.declared.happens.format(
            client=client, slot=slot, goal=f"the goal of {client} of action {name}", own=own, action=name,
            asked=own if record.message or getattr(record, "text", None) else none, ends=_WORDS[end],
        )  # fmt: skip
        mark = [record.declared.mark, number]
        if change == "is accepted":
            mark.append(record.instance)
        elif change in ("is known to be rejected", "is known to have ended"):
            self._over(record.channel, bar)
            mark.append(ENDS.index(end))
        return bar.lane, mark if record.declared.mark else None, happens

    def _bar(self, record: Any, node: str | None) -> _Bar:
        channel, goal = record.channel, record.message
        is_accepted = record.declared.goal == "is accepted"
        slot = (channel, getattr(record, "instance", None))
        bar = self._bars.get((channel, goal)) if goal else None
        if (
            record.declared.goal == "is sent"
        ):  # while a run continues, its server's trace may have been read first
            return bar or self._new(channel, goal, record.client or "?", node)
        if bar is None and not is_accepted:
            bar = self._in_slot.get(slot) if slot[1] is not None else None
        if bar is None:
            bar = self._of_client(record)
        client = record.client or self._facts.only_client(channel) or "?"
        bar = bar or self._new(channel, goal, client, None if slot[1] else node)
        if is_accepted:
            self._in_slot[slot] = bar
        return bar

    def _of_client(self, record: Any) -> _Bar | None:
        """Return a goal without an id by its client: the oldest one that is under way, or the last."""
        wanted: Callable[[str], bool] = lambda client: record.client in (None, client)  # noqa: E731
        for (channel, client), bars in self._under_way.items():
            if channel == record.channel and wanted(client) and not record.message:
                taken = [
                    bar for bar in bars if record.declared.goal == "is accepted" and self._is_in_slot(bar)
                ]
                left = [bar for bar in bars if bar not in taken]
                if left:
                    return left[0]
        lanes = (lane for lane in self._lanes.all if lane.group == "actions" and not record.message)
        mine = next((lane for lane in lanes if lane.channel == record.channel and wanted(lane.id)), None)
        return None if mine is None else _Bar(mine, mine.id, self._counts.get(mine.index, 0))

    def _is_in_slot(self, bar: _Bar) -> bool:
        return any(other is bar for other in self._in_slot.values())

    def _new(self, channel: str, goal: str | None, client: str, node: str | None) -> _Bar:
        under_way = self._under_way.setdefault((channel, client), [])
        taken = {bar.lane.index for bar in under_way}
        rows = (self.lane(channel, client, node, row) for row in range(len(under_way) + 1))
        lane = next(lane for lane in rows if lane.index not in taken)
        number = self._counts[lane.index] = self._counts.get(lane.index, 0) + 1
        bar = _Bar(lane, client, number)
        under_way.append(bar)
        if goal:
            self._bars[channel, goal] = bar
        return bar

    def _over(self, channel: str, bar: _Bar) -> None:
        under_way = self._under_way.get((channel, bar.client), [])
        if bar in under_way:
            under_way.remove(bar)
        self._in_slot = {slot: other for slot, other in self._in_slot.items() if other is not bar}
