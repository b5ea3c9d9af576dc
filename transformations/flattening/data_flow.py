"""Data flow through the rules: from which place to which place token data passes through channels.

A transition made by a rule passes the data of the one message that it takes to all tokens that it puts. Rules
declare which of their places carry data; all other tokens that they make may have any value.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from typing import NamedTuple

from dineros.metamodel import pn, sym
from dineros.metamodel.calls import actions
from dineros.metamodel.guards.reading import Fields
from dineros.metamodel.token_data import FieldType
from dineros.transformations.flattening.traces import Link
from dineros.transformations.language.creation import New
from dineros.transformations.rules.phases import StandardRule


class Arcs(NamedTuple):
    """The arcs between a transition of the net and places of the net."""

    takes: Counter[pn.Place]
    reads: Counter[pn.Place]
    puts: Counter[pn.Place]


class Flow(NamedTuple):
    """One way in which a transition of a rule handles messages."""

    takes: Counter[pn.Place]
    puts: Counter[pn.Place]
    """`takes`, `puts`: number of messages that it takes from and puts on each place of the net."""
    copies: Mapping[pn.Place, pn.Place]
    """For each place that gets a message, the place from which its data comes; others get arbitrary data."""
    lost: pn.Place | None = None
    """The place whose message is lost to a new one."""


def _places_of(channel: sym.Channel) -> set[pn.Place]:
    """Return the places of the ports of a channel."""
    parts = [channel, *channel.eAllContents()]
    values = [getattr(part, each.name) for part in parts for each in part.eClass.eAllReferences()]
    return {value for value in values if isinstance(value, pn.Place)}


class DataFlow:
    """The data flow through the transitions that rules made.

    Parameters
    ----------
    links : mapping of model object to Link
        For each element of its net, how it was made.
    originals : mapping of pn.Node to pn.Place
        For each place of the net, its place in the model.
    arcs : mapping of pn.Transition to Arcs
        The arcs of the net.
    fields : callable
        Returns the fields of a place of the model.
    """

    def __init__(
        self,
        model: sym.SystemModel,
        links: Mapping[pn.Element, Link],
        originals: Mapping[pn.Node, pn.Place],
        arcs: Mapping[pn.Transition, Arcs],
        fields: Fields,
    ) -> None:
        self._links, self._originals, self._declared, self._arcs = links, originals, fields, arcs
        # Their tokens are not messages, or get their data from the engine.
        self._apart = {client.timedOut for client in _service_clients(model)}
        for action in actions(model):
            self._apart |= {action.server.cancel, *(client.cancel for client in action.clients)}
        # Messages of an existing type may lack a field, or come from programs outside of the model.
        for channel in model.channels:
            if channel.type:
                self._apart |= _places_of(channel)
        self._entries: dict[pn.Place, Counter[pn.Place]] = {}
        for transition, own in arcs.items():
            if self._role(transition) == "enter":
                taken, put = self._messages(own)
                self._entries.update(dict.fromkeys(taken, put))
        self.flows = {
            transition: self._ways(transition, own)
            for transition, own in arcs.items()
            if links[transition].maker is not None and not self._repeats(transition)
        }
        """The flows of each transition that a rule made."""
        self._fields: dict[pn.Place, Mapping[str, FieldType]] = {}
        self._find_fields()

    def key(self, place: pn.Place) -> pn.Place:
        """Return the place of the model for a place of the net, or the place itself if there is none."""
        return self._originals.get(place, place)

    def fields(self, place: pn.Place) -> Mapping[str, FieldType]:
        """Return the fields of the tokens of a place; for a place made by a rule, those of its successors."""
        return self._fields[place] if place in self._fields else self._declared(place)

    def limits(self) -> dict[pn.Place, int]:
        """Return the queues whose messages leave in order, with the capacity of each."""
        ends: dict[pn.Place, set[str]] = {}
        limits: dict[pn.Place, int] = {}
        for transition, own in self._arcs.items():
            for side, name in zip(self._messages(own), ("takes", "puts"), strict=True):
                for place in side:
                    ends.setdefault(place, set()).add(f"{name}.{self._role(transition)}")
            if self._role(transition) == "enter":
                room = sum(place.tokens for place in own.takes if self._role(place) == "capacity")
                limits.update(dict.fromkeys(self._messages(own)[1], room))
        return {
            place: limit
            for place, limit in limits.items()
            if self._is_made(place) and ends[place] == {"puts.enter", "takes.leave"} and not place.tokens
        }

    def copied(self) -> list[tuple[pn.Place, pn.Place]]:
        """Return pairs of places, by `key`: tokens of the second get the data of tokens of the first."""
        pairs = (
            (self.key(source), self.key(target))
            for ways in self.flows.values()
            for way in ways
            for target, source in way.copies.items()
        )
        return list(dict.fromkeys(pairs))

    def _find_fields(self) -> None:
        todo = self.copied()
        changed = True
        while changed:
            changed = False
            for source, target in todo:
                if source not in self._fields and self._is_made(source):
                    if self._is_made(target) and target not in self._fields:
                        continue
                    self._fields[source] = self.fields(target)
                    changed = True
        for place, link in self._links.items():
            if isinstance(place, pn.Place) and link.maker is not None:
                self._fields.setdefault(place, {})

    def _is_made(self, place: pn.Place) -> bool:
        return place in self._links and place not in self._originals

    def _role(self, element: pn.Element) -> str:
        """Return the part of a queue that an element is, such as ``enter`` or ``load``; other words: none."""
        return self._links[element].role.rpartition(".")[2]

    def _repeats(self, transition: pn.Transition) -> bool:
        made = self._made(transition)
        return made is not None and made.repeats

    def _made(self, element: pn.Element) -> New | None:
        """Return the declaration in a rule of an element that it made."""
        link = self._links[element]
        made = None if link.maker is None else link.maker.created.get(link.role)
        return made if isinstance(made, New) else None

    def _messages(self, own: Arcs) -> tuple[Counter[pn.Place], Counter[pn.Place]]:
        """Return the messages that a transition consumes, and those that it adds."""
        takes, puts = own.takes - own.puts, own.puts - own.takes
        return self._carried(takes), self._carried(puts)

    def _carried(self, counts: Counter[pn.Place]) -> Counter[pn.Place]:
        return Counter({place: n for place, n in counts.items() if self._carries(place)})

    def _carries(self, place: pn.Place) -> bool:
        if place in self._originals:
            return True
        made = self._made(place)
        return made is not None and made.carries

    def _ways(self, transition: pn.Transition, own: Arcs) -> list[Flow]:
        takes, puts = self._messages(own)
        sources = [place for place in takes if self.key(place) not in self._apart]
        if len(sources) > 1:  # a new request displaces one whose client has given up
            sources = [place for place in sources if self._links[place].rule != "R6"]
        if self._role(transition) == "instead":  # the new message is kept, and a waiting one is lost
            sources = [place for place in sources if place in self._entries]
        copies: dict[pn.Place, pn.Place] = {}
        maker = self._links[transition].maker
        is_standard = maker is not None and issubclass(maker, StandardRule)  # other rules may do anything
        if is_standard and len(sources) == 1 and takes[sources[0]] == 1:
            copies = {place: sources[0] for place in puts if self.key(place) not in self._apart}
        plain = Flow(takes, puts, copies)
        if self._role(transition) != "drop" or len(sources) != 1:
            return [plain]
        # A full history keeps the new message and loses its oldest one (DDS 1.4, Sect. 2.2.3.18), while the
        # net
        # without data drops the new one. Here, any of the waiting messages may be the oldest.
        (new,) = sources
        kept = [place for place in self._entries.get(new, ()) if place not in puts]
        ways = [
            Flow(takes + Counter([place]), puts + Counter([place]), {**copies, place: new}, place)
            for place in kept
        ]
        # Requests of other clients count in the history of a service, too.
        is_own = any(self._role(place) == "load" for place in kept)
        return ways if is_own else [plain, *ways]


def _service_clients(model: sym.SystemModel) -> list[sym.ClientPort]:
    services = (each for each in model.channels if isinstance(each, sym.ServiceChannel))
    return [client for service in services for client in service.clients]
