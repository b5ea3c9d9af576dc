"""What an engine does with the tick or message that an observer follows.

An engine takes a message some time after it has arrived. Markers would disturb the clock of this taking. So
the observer looks after the taking which message it was. In the node, a marker is at the place of the
followed token. This needs places with one token at most.
"""

from __future__ import annotations

from collections.abc import Mapping

from dineros.analysis.latencies.editing import Case, EditedNet, Firing
from dineros.analysis.latencies.markers import GO, NOW, WATCHING
from dineros.analysis.latencies.parts import Parts
from dineros.analysis.latencies.sampling import NotFollowedError
from dineros.analysis.timed.exploring import Explored
from dineros.metamodel import sym
from dineros.metamodel.callbacks.bodies import Body
from dineros.metamodel.elements import label, node_net_of
from dineros.metamodel.times.runs import ports_at


class FollowedEngine:
    """Follows data through a callback of a node of the execution `net`.

    Parameters
    ----------
    target : str
        The place of what it publishes; empty if the instance ends with the callback.
    arrives : mapping of str to (mapping of str to int)
        What the last transition takes and puts, if `target` is empty.
    """

    def __init__(
        self,
        net: EditedNet,
        parts: Parts,
        explored: Explored,
        number: int,
        page: sym.CallbackPage,
        target: str,
        arrives: Mapping[str, Mapping[str, int]],
    ) -> None:
        self._net, self._explored = net, explored
        self._number, self._target, self._arrives, self._due = number, target, arrives, ""
        node = node_net_of(page)
        self._inside = {
            name
            for place, names in parts.places.items()
            if node_net_of(place) is node and not ports_at(place)
            for name in names
        }
        self._page = page
        self._moves = {name for run in parts.runs_of(page) for name in run.moves}
        self._ends = {each.id for each in Body(page).ends()}
        if not target:
            self._inside &= {name for run in parts.runs_of(page) for name in run.own}
            self._inside = {name for name in self._inside if net.consumers(name)}
        self._leading = {target} if target else set(self._inside)
        while target:
            more = {place for place in self._inside - self._leading if self._passes_on(place)}
            if not more:
                break
            self._leading |= more

    def start(self, due: str, marker: str) -> None:
        """Follow a tick from the place where it is due; the marker says that it is the followed one."""
        self._due = due  # the next strike tests it
        self._pass_on(due, marker)

    def take(self, leave: str, sink: str, waits: str, ahead: str, entrances: tuple[str, str]) -> None:
        """Follow a message out of its history.

        Parameters
        ----------
        leave
            The transition that takes it.
        sink
            Where it puts it.
        waits, ahead
            Markers: the followed message waits, and one for each message before it.
        entrances
            The transitions by which messages enter the history, or displace others.
        """
        net, taken = self._net, self._net.place(f"observer {self._number} taken")
        self._require_one(sink)
        net.redirect(leave, sink, taken)
        for name in entrances:
            net.split(name, [Case(inhibit={taken: 1})])
        looks, marker = f"observer {self._number} looks", self._marker(sink)
        net.add(Firing(looks, {taken: 1}, {sink: 1}, {}, {}, NOW))
        net.split(
            looks,
            [
                Case(inhibit={waits: 1}),
                Case(read={waits: 1}, take={ahead: 1}),
                Case(take={waits: 1}, put={marker: 1}, inhibit={ahead: 1}),
            ],
        )
        self._pass_on(sink, marker)

    def _marker(self, place: str) -> str:
        name = f"observer {self._number} in {place}"
        return name if name in self._net.places else self._net.place(name)

    def _require_one(self, place: str) -> None:
        at = self._explored.net.untimed.places.index(place)
        if int(self._explored.markings[:, at].max()) > 1:
            raise NotFollowedError(f"place {place} holds several tokens, which cannot be distinguished")

    def _pass_on(self, place: str, marker: str) -> None:
        """Split the transitions that take a token of a place by whether it is the followed one."""
        net = self._net
        for name, (firing, *_) in net.cases.items():
            if name.startswith("observer "):
                continue
            is_read = place in firing.read and place != self._due
            if is_read or (place in firing.take and place in firing.put):
                raise NotFollowedError(f"transitions read the data at place {place} without taking it")
        further = []
        for name in [each for each in net.consumers(place) if not each.startswith("observer ")]:
            firing = net.original(name)
            onward = self._onward(name)
            if len(onward) > 1 or any(firing.put[each] > 1 or each in firing.take for each in onward):
                raise NotFollowedError(f"transition {name} passes data on in several ways")
            plain = Case(inhibit={marker: 1})
            if not onward and not self._target:
                take, put = self._arrives["take"], self._arrives["put"]
                follows = Case(take={marker: 1, **take}, put=dict(put))
            elif not onward:
                follows = Case(take={marker: 1, WATCHING: 1, GO: 1})
            elif onward[0] == self._target:
                sends = f"observer {self._number} sends {self._target}"
                if sends not in net.places:
                    net.place(sends)
                follows = Case(take={marker: 1}, instead={self._target: sends})
            else:
                self._require_one(onward[0])
                inner = f"observer {self._number} in {onward[0]}"
                if inner not in net.places:
                    further.append(onward[0])
                follows = Case(take={marker: 1}, put={self._marker(onward[0]): 1})
            net.split(name, [plain, follows])
        for each in further:
            self._pass_on(each, self._marker(each))

    def _onward(self, name: str) -> list[str]:
        """Return the places where a transition puts the data that it takes, if they lead on."""
        onward = [each for each in self._net.original(name).put if each in self._leading]
        if self._target or name not in self._moves:
            return onward
        if name in self._ends:
            return []
        if not onward:
            raise NotFollowedError(f"callback {label(self._page)} waits for a response")
        return onward

    def _passes_on(self, place: str) -> bool:
        """Return whether a transition takes a token of a place and puts one where it leads to the target."""
        following = [self._net.original(name) for name in self._net.consumers(place)]
        return any(each in self._leading for firing in following for each in firing.put)


def require_plain(page: sym.CallbackPage) -> None:
    """Refuse a callback of an engine that is not followed.

    Raises
    ------
    NotFollowedError
        It is of another kind, or its node is managed.
    """
    node = node_net_of(page)
    if page.kind not in (sym.CallbackKind.timer, sym.CallbackKind.subscriber):
        raise NotFollowedError(f"callback {label(page)} is not called by a timer or messages")
    if node is None or node.lifecycle is not None:
        raise NotFollowedError(
            f"the node of callback {label(page)} is managed: it can be stopped and started"
        )
