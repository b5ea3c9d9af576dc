"""One walk over a model, and what constraints look up in it afterwards instead of searching again."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Callable, Hashable
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any, TypeVar, get_args

from dineros.metamodel import pn, rtm, sym
from dineros.metamodel.base import EObject
from dineros.metamodel.calls import CLIENT_PLACES, SERVER_PLACES, goal_parts, runtime_goal_parts
from dineros.metamodel.files.schema import parts_of
from dineros.metamodel.token_data import FieldType, field_type
from dineros.metamodel.token_types.declared import type_of_place
from dineros.metamodel.token_types.installed import UnknownInterfaceError, installed_fields

T = TypeVar("T", bound=EObject)
V = TypeVar("V")


@dataclass(frozen=True)
class PortUse:
    """A port that puts tokens on a place or takes them from it.

    Attributes
    ----------
    port : EObject
        The port, of a system model or a run-time model.
    sends : bool
        It takes tokens from the place; otherwise it puts some there.
    channel : tuple[str, str]
        ``topic``, ``service`` or ``action``, and the name.
    """

    port: EObject
    sends: bool
    channel: tuple[str, str]


class Index:
    """All elements of a net in model order, and their relations.

    Relations leave out elements that lack something required: `incomplete` ones.
    """

    def __init__(self, net: pn.Net) -> None:
        self.net = net
        self.elements: list[EObject] = []
        self.members: set[EObject] = set()
        self.incomplete: set[EObject] = set()
        self._node_nets: dict[pn.Page, sym.NodeNet | None] = {}
        self._by_class: dict[type, list[EObject]] = defaultdict(list)
        self._made: dict[Hashable, Any] = {}
        stack: list[EObject] = [net]
        while stack:
            element = stack.pop()
            if element in self.members:
                continue
            self.elements.append(element)
            self.members.add(element)
            self._by_class[type(element)].append(element)
            if isinstance(element, pn.Page):
                outer = element.page
                inherited = self._node_nets.get(outer) if outer is not None else None
                self._node_nets[element] = element if isinstance(element, sym.NodeNet) else inherited
            stack.extend(reversed(parts_of(element)))

    def all(self, kind: type[T]) -> list[T]:
        """Return the complete elements of a class, in model order."""
        classes = [cls for cls in self._by_class if issubclass(cls, kind)]
        candidates = (
            self.elements if len(classes) > 1 else [each for cls in classes for each in self._by_class[cls]]
        )
        return [each for each in candidates if isinstance(each, kind) and each not in self.incomplete]

    @cached_property
    def is_distributed(self) -> bool:
        """Whether the net is made of node nets: a system model or a run-time model."""
        return isinstance(self.net, (sym.SystemModel, rtm.RuntimeModel))

    @cached_property
    def first_token_type(self) -> sym.TokenType | None:
        """What tokens carry in places that name no token type."""
        return self.net.tokenType if isinstance(self.net, (sym.SystemModel, rtm.RuntimeModel)) else None

    def token_type_of(self, place: pn.Node) -> sym.TokenType | None:
        """Return what the tokens of a place carry; None: the model declares nothing."""
        return type_of_place(place, self.net)

    def fields_of(self, token_type: sym.TokenType | None) -> dict[str, FieldType] | None:
        """Return the fields of a token type, by name; None: it is a ROS message that is not installed."""
        return self.once(("token fields", token_type), lambda: self._fields(token_type))

    def _fields(self, token_type: sym.TokenType | None) -> dict[str, FieldType] | None:
        if token_type is not None and token_type.ros:
            try:
                return {field.name: field for field in installed_fields(token_type.ros)}
            except UnknownInterfaceError:
                return None
        declared = token_type.fields if token_type is not None else ()
        return {field.name: field_type(field) for field in declared if field not in self.incomplete}

    def once(self, key: Hashable, make: Callable[[], V]) -> V:
        """Return what was made for a key before, or make it."""
        if key not in self._made:
            self._made[key] = make()
        return self._made[key]  # type: ignore[no-any-return]

    def earliest(self, element: T, kind: type[T], key: Callable[[T], Hashable]) -> T:
        """Return the first element of a class with the key of this one; `key` is a named function."""
        return self.once((kind, key), lambda: self._repeated(kind, key)).get(element, element)

    def _repeated(self, kind: type[T], key: Callable[[T], Hashable]) -> dict[T, T]:
        """Return the first element with the same key, of each that is not the first."""
        firsts: dict[Hashable, T] = {}
        repeated = {}
        for element in self.all(kind):
            first = firsts.setdefault(key(element), element)
            if first is not element:
                repeated[element] = first
        return repeated

    # Pages

    def page_of(self, element: EObject) -> pn.Page | None:
        """Return the innermost page an element is on, a page itself included."""
        holder: EObject | None = element
        while holder is not None and not isinstance(holder, pn.Page):
            holder = holder.eContainer()
        return holder

    def node_net_of(self, element: EObject) -> sym.NodeNet | None:
        """Return the node net an element is in, itself included."""
        page = self.page_of(element)
        return self._node_nets.get(page) if page is not None else None

    @cached_property
    def server_pages(self) -> dict[pn.Page, list[EObject]]:
        """The ports of each server page."""
        pages: dict[pn.Page, list[EObject]] = defaultdict(list)
        for kind in get_args(_ServerPort):
            for port in self.all(kind):
                pages[port.page].append(port)
        return dict(pages)

    def server_page_of(self, element: EObject) -> pn.Page | None:
        """Return the innermost server page an element is on, itself included."""
        page = self.page_of(element)
        return self._server_page.get(page) if page is not None else None

    @cached_property
    def _server_page(self) -> dict[pn.Page, pn.Page | None]:
        return self._innermost(lambda page: page in self.server_pages)

    def callback_page_of(self, element: EObject) -> sym.CallbackPage | None:
        """Return the innermost callback page an element is on, itself included."""
        page = self.page_of(element)
        return self._callback_page.get(page) if page is not None else None  # type: ignore[return-value]

    @cached_property
    def _callback_page(self) -> dict[pn.Page, pn.Page | None]:
        return self._innermost(lambda page: isinstance(page, sym.CallbackPage))

    def _innermost(self, wanted: Callable[[pn.Page], bool]) -> dict[pn.Page, pn.Page | None]:
        found: dict[pn.Page, pn.Page | None] = {}
        for page in self._node_nets:  # outer pages first
            inherited = found.get(page.page) if page.page is not None else None
            found[page] = page if wanted(page) else inherited
        return found

    def place_of_part(self, holder: EObject, part: str) -> pn.Node | None:
        """Return a place whose tokens a part of a channel's interface carries; None: it has none yet.

        Parameters
        ----------
        holder : EObject
            A channel, or a port of a run-time model.
        part : {"message", "request", "response", "goal", "result", "feedback"}
            Part of the interface.
        """
        places: list[pn.Node | None] = []
        match holder:
            case sym.TopicChannel():
                places = [port.place for port in (*holder.publishers, *holder.subscribers)]
            case sym.ServiceChannel():
                ends = [(port.request, port.response) for port in holder.clients]
                if holder.server is not None:
                    ends.append((holder.server.entry, holder.server.exit))
                places = [request if part == "request" else response for request, response in ends]
            case sym.ActionChannel():
                places = list(goal_parts(holder).get(part, ()))
            case rtm.ActionClientPort() | rtm.ActionServerPort():
                places = list(runtime_goal_parts(holder).get(part, ()))
            case rtm.ClientPort() | rtm.ServerPort():
                other = holder.response if isinstance(holder, rtm.ClientPort) else holder.exit
                own = holder.eContainer()
                places = [own if part == "request" and isinstance(own, pn.Node) else other]
            case rtm.PlacePort():
                own = holder.eContainer()
                places = [own if isinstance(own, pn.Node) else None]
        return next((place for place in places if place is not None), None)

    # References

    def final(self, node: pn.Node) -> pn.Place | pn.Transition | None:
        """Follow references; None if they end nowhere or run in a circle."""
        passed: set[pn.Node] = set()
        while isinstance(node, (pn.ReferencePlace, pn.ReferenceTransition)):
            if node in passed or node in self.incomplete:
                return None
            passed.add(node)
            node = node.target
        return node if isinstance(node, (pn.Place, pn.Transition)) else None

    @cached_property
    def reached_from(self) -> dict[pn.Node, list[sym.NodeNet]]:
        """The node nets whose references end at a node, each once."""
        reached: dict[pn.Node, list[sym.NodeNet]] = defaultdict(list)
        for reference in [*self.all(pn.ReferencePlace), *self.all(pn.ReferenceTransition)]:
            node_net, target = self.node_net_of(reference), self.final(reference)
            if node_net is not None and target is not None and node_net not in reached[target]:
                reached[target].append(node_net)
        return dict(reached)

    # Ports

    @cached_property
    def port_uses(self) -> dict[EObject, list[PortUse]]:
        """What ports do with each place."""
        known = (cls for cls in _USES if not issubclass(cls, rtm.PlacePort))
        ports: list[Any] = [port for cls in known for port in self.all(cls)]
        ports += [port for place in self.all(rtm.Place) for port in place.ports]
        uses: dict[EObject, list[PortUse]] = defaultdict(list)
        for port in ports:
            if port in self.incomplete:
                continue
            kind, roles = _USES[type(port)]
            channel = port if isinstance(port, rtm.PlacePort) else port.channel
            use = partial(PortUse, port, channel=(kind, getattr(channel, kind) if channel else ""))
            met: set[pn.Place] = set()
            for role, sends in roles:
                place = getattr(port, role) if role else port.eContainer()
                if place is None or place in met:
                    continue
                if kind == "action" and role not in _OWN:  # one place may be for several ends of a goal
                    met.add(place)
                uses[place].append(use(sends))
        return dict(uses)


_ServerPort = sym.ServerPort | rtm.ServerPort | sym.ActionServerPort | rtm.ActionServerPort

_OWN = ("", "entry", "goal")
_OF_SERVER = tuple((role, role != "cancel") for role in SERVER_PLACES)
_OF_CLIENT = tuple((role, role == "cancel") for role in CLIENT_PLACES)
_USES: dict[type[EObject], tuple[str, tuple[tuple[str, bool], ...]]] = {
    sym.PublisherPort: ("topic", (("place", True),)),
    sym.SubscriberPort: ("topic", (("place", False), ("missed", False))),
    sym.ServerPort: ("service", (("entry", False), ("exit", True))),
    sym.ClientPort: ("service", (("request", True), ("response", False), ("timedOut", False))),
    sym.ActionServerPort: ("action", (("entry", False), *_OF_SERVER)),
    sym.ActionClientPort: ("action", (("goal", True), *_OF_CLIENT)),
    rtm.PublisherPort: ("topic", (("", True),)),
    rtm.SubscriberPort: ("topic", (("", False),)),
    rtm.ServerPort: ("service", (("", False), ("exit", True))),
    rtm.ClientPort: ("service", (("", True), ("response", False))),
    rtm.ActionServerPort: ("action", (("", False), *_OF_SERVER)),
    rtm.ActionClientPort: ("action", (("", True), *_OF_CLIENT)),
}
"""Kind of the channel of a port, and whether the port takes tokens from each of its places.

The place without a role is the one that holds a port of a run-time model.
"""
