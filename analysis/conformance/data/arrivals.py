"""Whether messages arrive with the values with which they were sent.

A record says what arrives. The data of a message that leaves is known from its token: records of its node
give the token's data. Messages of topics, requests and responses are compared, by their ids, in fields of
which both ends must have the same value: booleans, integers and texts of one token type. Numbers are left
out, as ROS may carry them in fewer digits, and so are channels with a `type`, whose messages may lack fields.
"""

from __future__ import annotations

from collections import OrderedDict
from collections.abc import Mapping

from dineros.analysis.conformance.refusals import Fault
from dineros.metamodel import sym
from dineros.metamodel.calls import copy_id, instance_counts, server_pages
from dineros.metamodel.errors import DinerosError
from dineros.metamodel.guards.deciding import value_text
from dineros.metamodel.records import Checkpoint, Data, Fire, Record, Start
from dineros.metamodel.token_data import FieldType
from dineros.metamodel.token_types.declared import token_type_of, type_of_place

MOST_KEPT = 4096
"""Messages of a channel whose data is kept; an older one is not compared."""

_EXACT = ("boolean", "integer", "text")
_Sent = tuple[str, Data]
"""The place that a message left from, and what it carried."""


class Arrivals:
    """The data of messages in transit, from the records."""

    def __init__(self, model: sym.SystemModel) -> None:
        self._types: dict[str, sym.TokenType | None] = {}
        self._fields: dict[sym.TokenType | None, dict[str, FieldType]] = {}
        self._channels = {channel.id for channel in model.channels if not channel.type}
        self._tokens: dict[str, dict[int, Data]] = {}
        self._sent: dict[tuple[str, str], OrderedDict[str, _Sent]] = {}
        self._add_places(model)

    def _add_places(self, model: sym.SystemModel) -> None:
        ports = [port for channel in model.channels for port in (channel, *channel.eAllContents())]
        ends = {
            end
            for port in ports
            for reference in port.eClass.eAllReferences()
            if isinstance(end := getattr(port, reference.name), sym.Place)
        }
        for place in ends:
            self._types[place.id] = type_of_place(place, model)
        counts = instance_counts(model)
        for page, served in server_pages(model).items():
            inside = [each for each in page.eAllContents() if isinstance(each, sym.Place) and each in ends]
            for number in range(1, counts[served] + 1):
                for place in inside:
                    self._types[copy_id(served.id, number, place.id)] = type_of_place(place, model)
        self._tokens = {place: {} for place in self._types}

    def fault(self, record: Record) -> Fault | None:
        """Return how the data of a message that arrives differs from what was sent; None: it does not."""
        sender = record.declared.receives
        message, place = getattr(record, "message", None), getattr(record, "place", None)
        if not sender or message is None or place not in self._types:
            return None
        sent = self._sent.get((getattr(record, "channel", ""), sender), {}).get(message)
        if sent is None or self._types[sent[0]] is not self._types[place]:
            return None
        data: Mapping[str, object] = getattr(record, "data", None) or {}
        for name, field in self._exact(self._types[place]).items():
            if name not in data or name not in sent[1]:
                continue
            if (type(data[name]), data[name]) != (type(sent[1][name]), sent[1][name]):
                got, was = value_text(data[name], field), value_text(sent[1][name], field)
                return Fault(f"{place}.{name} is {got}, but {sent[0]} sent {was}")
        return None

    def happen(self, record: Record) -> None:
        """Let a step happen that is allowed."""
        if isinstance(record, Start):
            if not record.resumed and not isinstance(record, Checkpoint):
                self._forget(record.node or "")
            for place, tokens in record.marking.items():
                if place in self._tokens:
                    self._tokens[place] = {token.id: token.data for token in tokens}
            return
        if isinstance(record, Fire):
            for place, ids in record.taken.items():
                for id in ids if place in self._tokens else ():
                    self._tokens[place].pop(id, None)
            for place, made in record.made.items():
                if place in self._tokens:
                    self._tokens[place].update({token.id: token.data for token in made})
            return
        end, token = getattr(record, "place", None), getattr(record, "token", None)
        if end not in self._tokens or token is None:
            return
        if record.declared.token == "leaves":
            self._leave(record, end, self._tokens[end].pop(token, None))
        elif record.declared.token in ("arrives", "may arrive"):
            self._tokens[end][token] = getattr(record, "data", None) or {}

    def _forget(self, node: str) -> None:
        """Forget the messages of a node that restarts without its state: it uses their numbers again."""
        for kept in self._sent.values():
            for message in [each for each in kept if each.startswith(f"{node}/")]:
                del kept[message]

    def _leave(self, record: Record, place: str, data: Data | None) -> None:
        channel, message = getattr(record, "channel", ""), getattr(record, "message", None)
        if data is None or message is None or channel not in self._channels or record.declared.goal:
            return
        kept = self._sent.setdefault((channel, record.event), OrderedDict())
        kept[message] = place, data
        if len(kept) > MOST_KEPT:
            kept.popitem(last=False)

    def _exact(self, declared: sym.TokenType | None) -> dict[str, FieldType]:
        if declared not in self._fields:
            try:
                fields = token_type_of(declared).fields
            except DinerosError:  # a message that is not installed here
                fields = ()
            self._fields[declared] = {field.name: field for field in fields if field.kind in _EXACT}
        return self._fields[declared]
