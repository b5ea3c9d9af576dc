"""Interprets calls that create nodes, ports, timers, groups and parameters, in rclcpp and idioms."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.machine import CONTROLLERS, MANAGER
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.interpreting.groups import read_group
from dineros.sources.cpp.interpreting.naming import (
    is_callable,
    name_on,
    period_of,
    place_of,
    ros_type,
)
from dineros.sources.cpp.parsing import end_of, line_of, path_of, text_of
from dineros.sources.cpp.quality import profile
from dineros.sources.cpp.values import (
    Const,
    Either,
    Frame,
    Made,
    Method,
    Obj,
    Open,
    Port,
    Value,
    alternatives,
    constant,
    node_in,
    options,
    part,
    shown,
)
from dineros.sources.facts import CallbackFact, Entity, NodeFact, is_open
from dineros.sources.libraries.idioms import publish_at_each_tick
from dineros.sources.libraries.quality import USUAL

if TYPE_CHECKING:
    from tree_sitter import Node

MAKES = {
    "create_publisher": "publishers",
    "create_generic_publisher": "publishers",
    "create_subscription": "subscriptions",
    "create_generic_subscription": "subscriptions",
    "create_wall_timer": "timers",
    "create_timer": "timers",
    "create_service": "services",
    "create_client": "clients",
    "create_generic_client": "clients",
    "create_callback_group": "groups",
    "create_server": "action_servers",
}
"""Functions that create entities: the kind of entity by name."""
_ADAPTED = {
    "init_cli": "clients",
    "init_srv": "services",
    "init_pub": "publishers",
    "init_sub": "subscriptions",
}
"""Methods of ``component_interface_utils::NodeAdaptor`` of Autoware; the first argument gets the port."""
TRANSITIONS = ("on_configure", "on_activate", "on_deactivate", "on_cleanup", "on_shutdown", "on_error")
"""Methods of a node with a lifecycle that its transitions call."""
_OF_CONTROLLERS = {
    **dict.fromkeys(("on_init", "on_set_chained_mode"), "transition"),
    **dict.fromkeys(("update", "update_and_write_commands", "update_reference_from_subscribers"), "thread"),
}
"""Methods of a controller that its manager calls, the latter in a loop on a thread of its own."""


class Maker:
    """Creates nodes and entities.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Statements) -> None:
        self.machine = machine

    def make_node(self, this: Obj, kind: str, args: list[Value], node: Node, frame: Frame) -> None:
        """Make an object a node."""
        place = self.machine.place(node, frame)
        if this.cls is not None and this.cls.path == place.file:
            place = self.machine.place(this.cls.node, frame)
        cls = this.cls.name if this.cls is not None else "rclcpp::Node"
        is_controller = kind in CONTROLLERS
        args = [Open("the controller manager gives the name")] if is_controller else args
        if kind == MANAGER:
            args = args[1:] or [Const("ComponentManager")]
        name, space = args[0] if args else Open("a name"), args[1] if len(args) > 1 else None
        fact = NodeFact(cls, place, shown(name), program=self.machine.program)
        fact.namespace = str(space.value).strip("/") if isinstance(space, Const) and space.value else ""
        if space is not None and not all(map(_is_space_known, options(space))):
            self.machine.unread.append(f"{place}: the namespace of this node is not known; none is assumed")
        fact.base = kind.rpartition("::")[2]
        fact.managed = fact.base.endswith("LifecycleNode") or is_controller
        fact.home = place.file
        this.node = fact
        self.machine.happens()
        self.machine.nodes.append(fact)
        if this.cls is not None:
            self.machine.reached.classes.add(id(this.cls))
        if this.cls is None or not fact.managed:
            return
        for step in (*_OF_CONTROLLERS, *TRANSITIONS) if is_controller else TRANSITIONS:
            found = Method(self.machine.methods(this.cls, step), step, this)
            at = place_of(found, place)[1]
            if at is not None:
                self.machine.callback(step, _OF_CONTROLLERS.get(step, "transition"), at, found, this)

    def entity(self, call: Call) -> Value | None:
        """Return the entity that a call creates; None: it creates none."""
        if call.last in _ADAPTED:
            return self._adapted(call)
        kind = MAKES.get(call.last)
        if kind is not None and call.named is not None:
            name = end_of(call.named)
            self.machine.reached.calls.add((call.frame.path, line_of(name)))
        if kind is None or (call.on is None and call.path in self.machine.idioms):
            return None
        owner, args = self._owner(call)
        if "rclcpp_action" in call.path:
            kind = "action_clients" if call.last == "create_client" else kind
        elif kind == "action_servers":
            return None
        if owner is None:
            place = self.machine.place(call.node, call.frame)
            self.machine.unread.append(f"{place}: {call.last} on a node that could not be determined")
            return Open(call.last)
        names = alternatives(args[0]) if args and kind not in ("timers", "groups") else []
        if not names:
            return self._entity(kind, call, args, owner)
        found = []
        for turn, chosen in enumerate(names):  # a run makes one of them
            self.machine.turns.append(turn)
            with self.machine.perhaps():
                port = self._entity(kind, call, [chosen, *args[1:]], owner)
            self.machine.turns.pop()
            port.entity.details["conditional"] = "one of several names"
            found.append(port)
        return Either(tuple(found))

    def _entity(self, kind: str, call: Call, args: list[Value], owner: Obj) -> Port:
        call_at, frame_at = self._site(call)
        entity = self.machine.entity_of(kind, self._port(call_at), call_at, frame_at, owner)
        self._held(entity, frame_at)
        port = Port(entity, owner)
        if self.machine.role not in ("main", "constructor", "thread"):
            do = "create_timer" if kind == "timers" else "create"
            self.machine.does(do, entity.port, call.node, call.frame, entity=entity)
        if kind == "groups":
            read_group(entity, args)
        elif kind == "timers":
            self._timer(call, entity, args, owner)
        else:
            entity.name = name_on(owner, args[0] if args else None)
            entity.type = self.type_of(call, args)
            is_typed = "generic" in call.last  # the second argument is the type
            self._others(kind, entity, args[2:] if is_typed else args[1:], owner)
        return port

    def _held(self, entity: Entity, frame: Frame) -> None:
        """Record the object that makes an entity, and whether its member has the only pointer to it."""
        this = frame.this
        if this is None:
            return
        bases = self.machine.bases(this.cls) if this.cls is not None else []
        kinds = [kind for cls in bases if (kind := cls.fields.get(entity.port, (None, None))[0]) is not None]
        is_pointer = any(path_of(kind).endswith(("Ptr", "shared_ptr")) for kind in kinds)
        self.machine.holders[id(entity)] = (this.made_by or id(this), is_pointer)

    def _adapted(self, call: Call) -> Value | None:
        """Return the entity of an adaptor: an interface class in another package gives its name and type."""
        owner = node_in(call.on) if isinstance(call.on, Made) else None
        if owner is None or not call.nodes:
            return None
        kind, port = _ADAPTED[call.last], text_of(call.nodes[0])
        entity = self.machine.entity_of(kind, port, call.node, call.frame, owner)
        entity.name = entity.type = f"open: the interface of {port}"
        entity.details["via"] = call.on.path if isinstance(call.on, Made) else ""
        rest = call.args[1:]
        if kind in ("services", "subscriptions") and rest:
            word = "service" if kind == "services" else "subscription"
            target = next(filter(is_callable, rest), Open("none"))
            if isinstance(target, Method) and target.this is None:  # given as the object and its method
                target = Method(target.routines, target.name, owner)
            self.callback(entity, "callback", word, target, owner)
        if kind in ("publishers", "subscriptions"):
            entity.details |= profile(Open(f"the interface of {port}"))
        if kind != "publishers":
            self.group(entity, rest)
        self.machine.assign(call.nodes[0], Port(entity, owner), call.frame)
        return Const(None)

    def _owner(self, call: Call) -> tuple[Obj | None, list[Value]]:
        """Return the node on which a call creates an entity, and the other arguments."""
        found = [each for each in call.args if isinstance(each, Obj) and each.node is not None]
        rest = [each for each in call.args if each not in found]
        if isinstance(call.on, Obj) and call.on.node is not None:
            return call.on, rest
        if isinstance(call.on, Made):  # a library helper that received the node
            for each in call.on.args:
                if isinstance(each, Obj) and each.node is not None:
                    return each, rest
        if call.on is not None:
            return None, rest
        if found:
            return found[0], rest
        this = call.frame.this
        if "::" in call.path and call.path.rpartition("::")[0] in ("rclcpp", "rclcpp_action"):
            return None, rest[1:]
        return (this if this is not None and this.node is not None else None), rest

    def _site(self, call: Call) -> tuple[Node, Frame]:
        """Return the location that creates an entity: the caller, if a method wraps one of the same name."""
        if self.machine.sites:
            name, node, caller, frame = self.machine.sites[-1]
            if name == call.last and frame is call.frame and caller is not None:
                return node, caller
        return call.node, call.frame

    def _port(self, made: Node) -> str:
        node: Any = made.parent
        for _ in range(4):
            if node is None:
                break
            if node.type == "assignment_expression":
                return text_of(node.child_by_field_name("left")).removeprefix("this->")
            if node.type == "init_declarator":
                return text_of(node.child_by_field_name("declarator")).strip("*& ")
            if node.type == "field_initializer":
                return path_of(node.named_children[0])
            node = node.parent
        return "(no variable)"

    def type_of(self, call: Call, args: list[Value]) -> str:
        """Return the type of messages that a call gives as a template's argument."""
        given = self.machine.templated(call.named, call.frame)
        if not given:
            first = args[1] if "generic" in call.last and len(args) > 1 else None
            return shown(first) if isinstance(first, Const) else "open: no type is given"
        text = self.machine.type_text(given[0], call.frame)
        if text.endswith(("::TypeAdapter", "adapt_type::as")):  # its last argument is the message
            inner = self.machine.templated(given[0], call.frame)
            text = self.machine.type_text(inner[-1], call.frame) if inner else text
        known = ros_type(text)
        if known.startswith("open") and text.count("::") < 2:
            return self.machine.index.find_interface(text, call.frame.path) or known
        return known

    def _timer(self, call: Call, entity: Entity, args: list[Value], owner: Obj) -> None:
        callback = next((n for n, each in enumerate(args) if is_callable(each)), None)
        if callback is None:
            callback = min(1, len(args) - 1)
        period = args[callback - 1] if callback > 0 else Open("a period")
        entity.details["period"] = period_of(period)
        self.group(entity, args[callback + 1 :])
        if 0 <= callback < len(args):
            self.callback(entity, "callback", "timer", args[callback], owner)

    def _others(self, kind: str, entity: Entity, args: list[Value], owner: Obj) -> None:
        if kind == "subscriptions" and args and is_callable(args[0]):  # of nav2
            args = [args[1] if len(args) > 1 else Made("rclcpp::QoS", [Const(10)]), args[0], *args[2:]]
        if kind in ("publishers", "subscriptions"):
            entity.details |= profile(args[0] if args else None)
        if kind == "publishers":
            return
        if kind == "subscriptions":
            self.callback(
                entity, "callback", "subscription", args[1] if len(args) > 1 else Open("none"), owner
            )
            self.group(entity, args[2:])
        elif kind == "services":
            self.callback(entity, "callback", "service", args[0] if args else Open("none"), owner)
            self.group(entity, args[1:])
        elif kind == "action_servers":
            for role, each in zip(("goal", "cancel", "accepted"), args, strict=False):
                self.callback(entity, role, role, each, owner)
            entity.details.setdefault("execute", "open: no thread was seen")
            self.group(entity, args[3:])
        else:
            self.group(entity, args)

    def group(self, entity: Entity, args: list[Value]) -> None:
        """Set the callback group of an entity from the arguments or options."""
        entity.details.setdefault("group", "default")
        for each in args:
            value = each.fields.get("callback_group", each) if isinstance(each, Made) else each
            found = [one for one in options(value) if isinstance(one, Port) and one.entity.kind == "groups"]
            if len(found) == 1 and len(options(value)) == 1:
                entity.group = found[0].entity
                entity.details["group"] = found[0].entity.port
            elif found:
                entity.details["group"] = "open: " + " or ".join(one.entity.port for one in found)
            elif isinstance(value, Open) and ("group" in value.text or "option" in value.text):
                entity.details["group"] = f"open: {value.text}"

    def callback(self, entity: Entity, role: str, kind: str, target: Value, owner: Obj) -> CallbackFact:
        """Give an entity a callback."""
        target = self.machine.functor(target)
        name, place = place_of(target, entity.at)
        if place is None:
            fact = CallbackFact(shown(target), kind, entity.at, is_open=True)
            if owner.node is not None:
                owner.node.callbacks.append(fact)
        else:
            fact = self.machine.callback(name, kind, place, target, owner, entity)
        entity.callbacks[role] = fact
        entity.details[role] = fact.name
        return fact

    # ----------------------------------------------------------------------------------------------- tables

    def idiom(self, call: Call) -> Value | None:
        """Return the entity that a class or function of an idiom table creates; None: it is in no table."""
        known = self.machine.idioms.get(call.path)
        if known is None or not known.makes:
            return None
        begin, end = line_of(call.node), call.node.end_point[0] + 1
        self.machine.reached.calls |= {(call.frame.path, line) for line in range(begin, end + 1)}
        if len(call.args) == 1 and isinstance(call.args[0], Port):  # a copy
            return call.args[0]
        owner = next((each for each in map(node_in, call.args) if each is not None), None)
        if owner is None and known.arguments[:1] == ("node",) and call.args:
            this = call.frame.this
            owner = this if this is not None and this.node is not None else None
        if owner is None:
            if known.others and self.machine.nodes:
                line = self.machine.place(call.node, call.frame), f"{call.path} {known.others}"
                node = call.frame.this.node if call.frame.this is not None else None
                found = (node or self.machine.nodes[-1]).others
                found += [line] if line not in found else []
            return None
        others = [each for at, each in enumerate(call.args) if node_in(each) is None or not at]
        if known.arguments[:1] == ("node",) and node_in(others[0]) is None:
            others.insert(0, owner)
        args = dict(zip(known.arguments, others, strict=False))
        if "remote" in known.arguments and owner.node is not None:
            args.setdefault("remote", Const(owner.node.name))
        spins = args.get("spin_thread", Const(True))
        is_apart = "spin_thread" in known.arguments and constant(spins) is not False
        topic = shown(args["topic"]) if "topic" in args else ""
        if topic and not is_open(topic):  # image_transport: a camera has two topics of one namespace
            args["info"] = Const(f"{topic.rpartition('/')[0]}/camera_info" if "/" in topic else "camera_info")
        made: list[Entity] = []
        for entry in known.makes:
            port = f"{self._port(call.node)}{'' if not made else f'#{len(made)}'}"
            entity = self.machine.entity_of(entry["kind"], port, call.node, call.frame, owner)
            made.append(entity)
            entity.port = self._port(call.node)
            entity.name = self._filled(str(entry.get("name", "")), args)
            entity.type = str(entry.get("type", ""))
            if entity.type == "{0}":
                entity.type = self.type_of(call, [])
            entity.details["via"] = entry.get("via", call.path)
            if entry["kind"] in ("publishers", "subscriptions"):
                usual = dict(USUAL) if entry.get("usual") else profile(Open("of the library"))
                entity.details |= profile(args["qos"]) if "qos" in args else usual
                given = {key: entry[key] for key in ("depth", "reliability", "durability") if key in entry}
                if given:
                    entity.details |= {"reliability": "reliable", "durability": "volatile"} | given
            if "period" in entry:
                entity.details["period"] = _period(entry, args)
            if "publishes" in entry:
                publish_at_each_tick(entity, made[entry["publishes"]])
            if is_apart:
                entity.details["thread"] = "its own"
            if entry["kind"] != "publishers":
                entity.details.setdefault("group", "default")
            if entry["kind"] == "action_servers" and "callback" in args:  # it works on a thread of its own
                self.callback(entity, "execute", "execute", args["callback"], owner).is_apart = True
            elif "callback" in entry and "callback" in args:
                self.callback(entity, "callback", "subscription", args["callback"], owner)
            elif entry["kind"] == "subscriptions":
                entity.details.setdefault("open", "the library runs its callback")
        return Port(made[0], owner, made, dict(known.methods))

    def _filled(self, name: str, args: dict[str, Value]) -> str:
        for key, value in args.items():
            name = name.replace(f"{{{key}}}", part(value))
        return name


def _period(entry: Mapping[str, Any], args: dict[str, Value]) -> float | str:
    """Return the seconds of a timer of a library: a number, or ``{argument}`` with the usual one."""
    if not isinstance(entry["period"], str):
        return float(entry["period"])
    value = args.get(entry["period"].strip("{}"), Const(entry.get("usual")))
    seconds = constant(value)
    return float(seconds) if type(seconds) in (int, float) else period_of(value)


def _is_space_known(value: Value) -> bool:
    """Return whether the second argument of a node is a known namespace, or not a namespace but options."""
    return isinstance(value, (Const, Made)) or (isinstance(value, Open) and "ptions" in value.text)
