"""Interprets methods of ports: publish, call, send goals, wait; also library classes with callbacks."""

from __future__ import annotations

from dineros.sources.cpp.binding import bound
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.making import Maker
from dineros.sources.cpp.parsing import on_text, text_of
from dineros.sources.cpp.quality import PRESETS
from dineros.sources.cpp.values import Const, Made, Obj, Open, Port, Value, constant, options
from dineros.sources.cpp.waiting import SPUN, is_repeated_until_true
from dineros.sources.facts import FOREVER, CallbackFact, Effect, is_open

SELF = {
    *(
        "get",
        "c_str",
        "str",
        "data",
        "value",
        "lock",
        "shared_from_this",
        "weak_from_this",
        "share",
        "get_future",
        "count",
    ),
    *("as_string", "as_double", "as_int", "as_bool", "get_value", "get_parameter_value", "as_string_array"),
    *("get_node_base_interface", "get_node_timers_interface", "get_node_topics_interface"),
    *("get_node_services_interface", "get_node_clock_interface", "get_node_logging_interface"),
    *("get_node_waitables_interface", "get_node_parameters_interface", "get_node_graph_interface"),
    *("to_chrono", "at", "front", "period", "get_rmw_qos_profile"),
}
"""Methods that, for this reader, return the object on which they are called."""
_PUBLISH = ("publish", "try_publish", "tryPublish", "unlockAndPublish")
"""Methods that publish; the others are those of ``realtime_tools::RealtimePublisher``."""
_NAMES = ("get_topic_name", "get_service_name", "getTopic")
"""Methods of ports that give their names."""
_IMAGES = {
    "advertise": "image_transport::Publisher",
    "advertiseCamera": "image_transport::CameraPublisher",
    "subscribe": "image_transport::Subscriber",
    "subscribeCamera": "image_transport::CameraSubscriber",
}
"""Methods of ``image_transport::ImageTransport``, with the entities that they create."""


class Ports:
    """Interprets methods of ports.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Statements) -> None:
        self.machine = machine
        self.maker = Maker(machine)

    def _port(self, call: Call, on: Port) -> Value | None:
        entity, last, machine = on.entity, call.last, self.machine
        known = on.methods.get(last)
        if known is not None:
            return self._known(call, on, known)
        if last == "reset" and not _is_arrow(call):
            if machine.role not in ("main", "constructor"):
                machine.does("destroy", entity.port, call.node, call.frame, entity=entity)
            return Const(None)
        if entity.kind == "timers" and last in ("cancel", "reset"):
            if machine.role not in ("main", "constructor") or last == "cancel":
                machine.does(f"{last}_timer", entity.port, call.node, call.frame, entity=entity)
            return Const(None)
        if last in ("on_parameter_event", "registerCallback", "add_parameter_event_callback"):
            return self._listens(call, on)
        if last in SELF:
            return on
        if last in _NAMES:  # a remapping changes it, and what is made of it
            is_known = not is_open(entity.name) and "{" not in entity.name and not machine.is_launched
            return Const(entity.name) if is_known else Open("a name", f"{{{entity.port}.{last}}}")
        if entity.kind == "publishers" and last in _PUBLISH:
            count = len(machine.fact.effects)
            effect = machine.does("publish", entity.port, call.node, call.frame, entity=entity)
            machine.sends(effect, call.node, call.frame, is_new=len(machine.fact.effects) > count)
        elif entity.kind == "services" and last == "send_response":
            machine.does("respond", entity.port, call.node, call.frame, entity=entity)
        elif entity.kind == "clients" and last in ("async_send_request", "call_async", "prune_requests"):
            return self._request(call, on) if last != "prune_requests" else Const(None)
        elif entity.kind == "clients" and last == "call":  # rclcpp has none: helpers of libraries wait
            how = "blocks, with a time-out that is open"
            machine.does("call", entity.port, call.node, call.frame, how, entity)
        elif entity.kind in ("clients", "action_clients") and last in (
            "wait_for_service",
            "wait_for_action_server",
        ):
            return self._wait_for(call, on)
        elif entity.kind == "action_clients" and last == "async_send_goal":
            return self._goal(call, on)
        elif entity.kind == "action_clients" and last.startswith("async_cancel"):
            machine.does("cancel_goal", entity.port, call.node, call.frame, entity=entity)
        elif entity.kind == "action_clients" and last == "async_get_result":
            effect = machine.does("get_result", entity.port, call.node, call.frame, "async", entity)
            return self._future(effect)
        return Open(f"{entity.port}.{last}")

    def images(self, call: Call, on: Made) -> Value | None:
        """Return the port that a method of ``image_transport::ImageTransport`` creates; None: none."""
        path = _IMAGES.get(call.last)
        if path is None or not on.args or not call.args:
            return None
        topic, rest = call.args[0], call.args[1:]
        depth = rest[0] if rest else Open("a depth")
        heard = [bound(rest[1:]), Open("the transport")] if path.endswith("Subscriber") and rest[1:] else []
        return self.maker.idiom(Call(call.node, call.frame, path, [on.args[0], topic, *heard, depth]))

    def _listens(self, call: Call, on: Port) -> Value:
        """Set the callback of a class of a library: a filter of messages, or events of parameters."""
        if call.last == "on_parameter_event":
            return self.hear_parameters(call, on.owner, on.entity.port, call.args)
        if call.args and on.entity.kind == "subscriptions":
            self.maker.callback(on.entity, "callback", "subscription", bound(call.args), on.owner)
        return Open(call.last)

    def hear_parameters(self, call: Call, owner: Obj, port: str, callback: list[Value]) -> Port:
        """Return the subscription of events of parameters that a node gets, with a callback."""
        entity = self.machine.entity_of("subscriptions", port, call.node, call.frame, owner)
        entity.name, entity.type = "/parameter_events", "rcl_interfaces/msg/ParameterEvent"
        entity.details |= {**PRESETS["ParameterEventsQoS"], "group": "default", "via": "parameter client"}
        if callback:
            self.maker.callback(entity, "callback", "subscription", bound(callback), owner)
        return Port(entity, owner)

    def _known(self, call: Call, on: Port, known: dict[str, object]) -> Value:
        number = known.get("entity", 0)
        entity = on.extra[number] if isinstance(number, int) and number < len(on.extra) else on.entity
        if known.get("do") == "wait_for_service":
            return self._wait_for(call, on)
        how = str(known.get("how", "async" if known.get("do") == "call" else ""))
        if how == "spin-until" and self.machine.role not in ("main", "constructor"):
            self.machine.does("spin_until", "the node", call.node, call.frame, "to get the response")
        effect = self.machine.does(str(known.get("do", "")), entity.port, call.node, call.frame, how, entity)
        second = known.get("and")
        if isinstance(second, int) and second < len(on.extra):
            other = on.extra[second]
            self.machine.does(str(known.get("do", "")), other.port, call.node, call.frame, how, other)
        return Made("future", effect=effect)

    def _wait_for(self, call: Call, on: Port) -> Value:
        limit = _limit(call.args, is_negative_endless=True)
        seconds = constant(limit[0]) if limit else None
        how = f"time-out {seconds} s" if seconds is not None else "without time-out"
        how = "time-out that is open" if limit and seconds is None else how
        do = "wait_for_server" if on.entity.kind == "action_clients" else "wait_for_service"
        effect = self.machine.does(do, on.entity.port, call.node, call.frame, how, on.entity, seconds)
        effect.is_repeated = is_repeated_until_true(call.node)
        return Open(do)

    def _request(self, call: Call, on: Port) -> Value:
        effect = self.machine.does("call", on.entity.port, call.node, call.frame, "async", on.entity)
        if len(call.args) > 1:
            effect.then = self._done(call.args[1], on, call)
        return self._future(effect)

    def _future(self, effect: Effect) -> Made:
        future = Made("future", effect=effect)
        future.fields |= {"future": future, "loops": Const(self.machine.loops)}
        return future

    def _done(self, target: Value, on: Port, call: Call) -> CallbackFact:
        holder = self.machine.entity_of("done", "answer", call.node, call.frame, Obj(None))
        return self.maker.callback(holder, "callback", "done callback", target, on.owner)

    def _goal(self, call: Call, on: Port) -> Value:
        machine = self.machine
        effect = machine.does("send_goal", on.entity.port, call.node, call.frame, "async", on.entity)
        given = next((each for each in call.args[1:] if isinstance(each, Made)), None)
        for name, target in (given.fields if given is not None else {}).items():
            if name.endswith("_callback"):
                kind = "feedback" if name == "feedback_callback" else "done callback"
                holder = machine.entity_of("done", name, call.node, call.frame, Obj(None))
                fact = self.maker.callback(holder, "callback", kind, target, on.owner)
                if name == "result_callback":
                    effect.then = fact
                elif fact not in effect.meanwhile:
                    effect.meanwhile.append(fact)
        if effect.then is None:
            accepted = [each for each in effect.meanwhile if each.kind == "done callback"]
            effect.then = next(iter(accepted), None)
        effect.meanwhile = [each for each in effect.meanwhile if each is not effect.then]
        return self._future(effect)

    def _await(self, call: Call, future: Value | None, rest: list[Value], how: str) -> Value:
        rest = _limit(rest)
        seconds = constant(rest[0]) if rest else None
        name = next(
            (text_of(node) for node, arg in zip(call.nodes, call.args, strict=False) if arg is future), ""
        )
        name = name or on_text(call.node)
        is_ready = not rest and name in self.machine.asked and self.machine.when != "always"
        self.machine.asked |= {name} if rest else set()
        polled = seconds == 0 and self._is_polled(future)
        if is_ready or (seconds == 0 and not polled):  # it was tested before, or is only tested now
            return Open("a result")
        bound = f"time-out {seconds} s" if seconds is not None else "without time-out"
        bound = "time-out that is open" if rest and seconds is None else bound
        futures = [each for each in options(future) if isinstance(each, Made)]
        for each in futures:
            each.fields[SPUN] = Const(True)
        found = [each.effect for each in futures if each.effect is not None]
        loops = max((constant(each.fields.get("loops")) or 0 for each in futures), default=0)
        if seconds is not None and found and self.machine.loops > loops:  # it waits repeatedly
            ends = any(self.machine.ways_out[loops:])
            bound, seconds = "time-out that is open" if ends else "without time-out", None
        for effect in found:
            if effect in self.machine.fact.effects:
                effect.how, effect.timeout = f"{how}, {bound}", seconds
        if not any(effect in self.machine.fact.effects for effect in found):
            what = text_of(call.node)[:40]
            self.machine.does("wait", what, call.node, call.frame, f"{how}, {bound}", timeout=seconds)
        return Open("a result")

    def _is_polled(self, future: Value | None) -> bool:
        """Return whether a loop tests a future again and again that this callback got before the loop."""
        futures = [each for each in options(future) if isinstance(each, Made) and each.effect is not None]
        loops = max((constant(each.fields.get("loops")) or 0 for each in futures), default=0)
        is_own = any(each.effect in self.machine.fact.effects for each in futures)
        return is_own and self.machine.loops > loops and not any(self.machine.ways_out[loops:])


def _limit(args: list[Value], *, is_negative_endless: bool = False) -> list[Value]:
    """Return the arguments without a time-out that is longer than any program runs.

    For ``rclcpp``, a negative time-out is none; for futures of the standard library, it has passed.
    """
    seconds = constant(args[0]) if args else None
    if not isinstance(seconds, (int, float)):
        return args
    return [] if seconds >= FOREVER or (is_negative_endless and seconds < 0) else args


def _is_arrow(call: Call) -> bool:
    """Return whether a method is called through a pointer; with a point, it is one of the pointer itself."""
    function = call.node.child_by_field_name("function")
    return function is not None and text_of(function.child_by_field_name("operator")) == "->"
