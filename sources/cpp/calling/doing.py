"""Interprets calls of functions and objects of rclcpp and the standard library."""

from __future__ import annotations

import re
from typing import TYPE_CHECKING

from dineros.sources.cpp.binding import bound
from dineros.sources.cpp.calling.ports import SELF
from dineros.sources.cpp.calling.spinning import Spinning
from dineros.sources.cpp.declarators import is_lost
from dineros.sources.cpp.durations import duration
from dineros.sources.cpp.following.calls import SLOTS, TASK, Call
from dineros.sources.cpp.following.machine import coerced, is_node
from dineros.sources.cpp.following.operators import AT_END
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.interpreting.formatting import formatted, of_text
from dineros.sources.cpp.interpreting.generated import generated
from dineros.sources.cpp.interpreting.holders import held, visited
from dineros.sources.cpp.interpreting.lists import items
from dineros.sources.cpp.interpreting.loading import loaded
from dineros.sources.cpp.interpreting.naming import SUB_SPACE, is_callable
from dineros.sources.cpp.interpreting.parameters import parameter
from dineros.sources.cpp.interpreting.transforms import BUFFER, look_up
from dineros.sources.cpp.parsing import arguments_of, arguments_of_scope, on_text, text_of
from dineros.sources.cpp.quality import CHAINED, PRESETS, changed
from dineros.sources.cpp.values import (
    Const,
    Either,
    Frame,
    Items,
    Made,
    Method,
    Obj,
    Open,
    Port,
    Seconds,
    Value,
    constant,
    members_of,
    one_of,
    options,
    part,
    shown,
)
from dineros.sources.cpp.waiting import BEGAN, THREAD, Waiting

if TYPE_CHECKING:
    from tree_sitter import Node

_SAME = {
    *("move", "forward", "ref", "cref", "dynamic_pointer_cast", "static_pointer_cast"),
    *("const_pointer_cast", "shared_ptr", "unique_ptr", "as_const", "string", "string_view"),
}
_RESOLVE = {"resolve_topic_name", "resolve_service_name", "resolve_topic_or_service_name"}
_OF_THIS = {"shared_from_this", "weak_from_this", "get_node"}
"""Methods of a node that return it; so do those for its interfaces."""
_OF_PARAMETERS = {
    *("add_on_set_parameters_callback", "add_pre_set_parameters_callback"),
    *("add_post_set_parameters_callback", "set_on_parameters_set_callback"),
}
"""Methods of nodes that get a callback of parameters."""
_ENUMERATOR = re.compile(r"(?:[A-Za-z_]\w*::)*[A-Za-z_]\w*")
_GOALS = {"succeed", "abort", "canceled", "publish_feedback"}


_AT_END = (
    *("make_scope_exit", "scope_exit", "ScopeExit", "ScopeGuard", "make_scope_guard", "makeGuard"),
    *("MakeCleanup", "Cleanup", "finally", "on_scope_exit"),
)
"""Functions and classes of libraries that call their argument at the end of a block."""
_ONCE = ("call_once", "invoke", "apply")
"""Functions of the standard library that call a function once."""
_OFTEN = (
    *("for_each", "for_each_n", "any_of", "all_of", "none_of", "find_if", "find_if_not", "count_if"),
    *("transform", "generate", "generate_n", "remove_if", "copy_if", "accumulate"),
)
"""Functions of the standard library that call a function any number of times."""
_AROUND = ("MessageFilter", "RealtimePublisher")
"""Classes whose objects pass on what their first argument receives or publishes, on other threads."""


class Ros(Spinning):
    """Interprets calls of rclcpp and the standard library.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Statements) -> None:
        super().__init__(machine)
        self.waiting = Waiting(machine)

    def make_node(self, this: Obj, kind: str, args: list[Value], node: Node, frame: Frame) -> None:
        """Make an object a node."""
        self.maker.make_node(this, kind, args, node, frame)

    def call(self, call: Call) -> Value | None:
        """Return the result of a call of a library; None: an unknown call."""
        if any(isinstance(each, (Open, Made)) for each in call.args):
            call.args = [self._number(each, call) for each in call.args]
        found = self.maker.entity(call)
        if found is None:
            found = held(self.machine, call)
        if found is None:
            found = self._of_library(call)
        if found is not None:
            return found
        on = call.on
        if call.last in _OF_PARAMETERS and call.args:
            self.read_callback(call.args[0], "parameters", call.node, call.frame)
            return Made(call.path, node=call.node)
        if on is None:
            return self._function(call)
        if isinstance(on, Port):
            return self._port(call, on)
        if isinstance(on, Made):
            found = self._made(call, on)
            if found is not None:
                return found
        elif isinstance(on, Items):
            return items(self.machine, call, on)
        if isinstance(on, Const) and isinstance(on.value, str):
            found = of_text(on.value, call)
            if found is not None:
                return found
        if call.last in _RESOLVE and call.args:
            return call.args[0]
        if call.last == "create_sub_node" and call.args and isinstance(on, Obj) and on.node is not None:
            return Obj(None, {SUB_SPACE: call.args[0]}, on.node, parameters=on.parameters, unset=on.unset)
        if (
            isinstance(on, Open)
            and on.text.startswith("parameter ")
            and (call.last.startswith("as_") or call.last == "get_value")
        ):
            return on
        if call.last in SELF and not isinstance(on, Open):
            self.machine.forget(call)
            return on
        if call.last in CHAINED and isinstance(on, (Made, Open, Either)):
            value = changed(on, call.last, call.args)
            self.machine.change(call.node, value, call.frame)
            return value
        return self._unknown(call, on)

    def _number(self, value: Value, call: Call) -> Value:
        """Return the number of an enumerator; other values as they are."""
        name = ""
        if isinstance(value, Open) and not value.parts:
            name = value.text
        elif isinstance(value, Made) and not value.args and not value.fields:
            name = value.path
        if not _ENUMERATOR.fullmatch(name) or self.machine.lookup(name, call.frame) is not None:
            return value
        space = call.frame.cls.full if call.frame.cls else call.frame.space
        found = self.machine.index.find_enumerator(name, call.frame.path, space)
        return value if found is None else Const(found)

    def _of_library(self, call: Call) -> Value | None:
        """Return the result of a call of parameters or loaders of plugins; None: another call."""
        found = parameter(self.machine, call)
        found = generated(self.machine, call) if found is None else found
        found = formatted(self.machine, call) if found is None else found
        return loaded(self.machine, call) if found is None else found

    # -------------------------------------------------------------------------------------------- functions

    def _function(self, call: Call) -> Value | None:
        path, last, args = call.path, call.last, call.args
        given = arguments_of(call.named)
        this = call.frame.this
        if this is not None and this.node is not None and (last in _OF_THIS or last.startswith("get_node_")):
            return this
        if last in ("make_shared", "make_unique"):
            if path.startswith(("std::", "make_")) and given:
                return self.machine.make(given[0], args, call.node, call.frame)
            scope = path.rpartition("::")[0]
            cls = self.machine.class_of(scope, call.frame)
            if cls is not None:
                types = [
                    self.machine.template_text(each, call.frame) for each in arguments_of_scope(call.named)
                ]
                return self.machine.construct(cls, args, types, call.node, call.frame)
            return self._library_object(scope, args, call)
        if last in ("static_cast", "dynamic_cast", "reinterpret_cast", "const_cast") and given and args:
            kind = self.machine.type_text(given[0], call.frame)
            return duration(kind, "", args) or coerced(kind, args[0])
        if last == "getCameraInfoTopic" and args and isinstance(topic := constant(args[0]), str):
            return Const("".join(topic.rpartition("/")[:2]) + "camera_info")
        if last in ("bind", "bind_front", "mem_fn", "not_fn") and args:
            return bound(args)
        if path in ("std::make_tuple", "std::tie", "std::forward_as_tuple"):
            return Made("std::tuple", args)
        if path == "std::get" and args and (item := _item_of(args[0], given)) is not None:
            return item
        if path == "std::make_optional" and len(args) == 1:
            return args[0]
        if last in _AT_END and len(args) == 1 and is_callable(args[0]):
            return Made(AT_END, args, node=call.node)
        if path == TASK and args:
            return Made(TASK, [bound(args)], node=call.node)
        if path.endswith(_AROUND) and args and isinstance(args[0], (Port, Made)):
            return args[0]
        if last in _SAME and args and (path.startswith("std::") or "::" not in path):
            return args[0]
        if path in ("std::string", "string") and not args:
            return Const("")
        if last == "to_string" and args:
            return Const(shown(args[0])) if isinstance(args[0], Const) else Open("a text", part(args[0]))
        templates = " ".join(text_of(each) for each in given)
        found = duration(path, templates, args)
        if found is not None:
            return found
        if path in ("rclcpp::sleep_for", "std::this_thread::sleep_for", "this_thread::sleep_for"):
            return self._sleep(call, args[0] if args else None)
        if path in ("std::this_thread::sleep_until", "this_thread::sleep_until"):
            return self._sleep(call, Open("until a time"))
        if path in ("sleep", "usleep") and args:
            seconds = constant(args[0])
            unit = 1.0 if path == "sleep" else 1e-6
            return self._sleep(
                call, Seconds(seconds * unit) if isinstance(seconds, (int, float)) else args[0]
            )
        if path in ("rclcpp::spin", "rclcpp::spin_some", "rclcpp::spin_all"):
            self._names_vendor(call)
            return self.spin(
                call, [each for each in args if isinstance(each, Obj)], "SingleThreadedExecutor", 1
            )
        if path.endswith("spin_until_future_complete"):
            return self._await(
                call, args[1] if len(args) > 1 else None, args[2:], "spin-until-future-complete"
            )
        if last == "on_parameter_event" and len(args) > 1 and isinstance(args[0], Obj):
            return self.hear_parameters(call, args[0], "(no variable)", args[1:])
        if path == "rclcpp::shutdown" and (self.machine.role != "main" or call.frame.this is not None):
            self.machine.does("shutdown", "rclcpp", call.node, call.frame)
            return Const(None)
        if last in ("thread", "jthread", "async") and args:
            return self._started(call)
        if last == "wait_for_message" and len(args) > 2:
            return self._wait_for_message(call)
        if last == "NodeThread" and args:
            return self.spin_in_thread(call)
        if self.waiting.is_guard(call) and args:
            return self.waiting.guard(call)
        if path == "std::lock" and args:
            return self.waiting.lock_together(call)
        if path in ("std::visit", "boost::apply_visitor") and len(args) > 1:
            return visited(self.machine, call)
        if path.startswith("std::") and last in (*_ONCE, *_OFTEN) and any(map(is_callable, args)):
            return self._applied(call)
        if last in PRESETS or path in ("rclcpp::QoS", "rclcpp::KeepLast", "rclcpp::KeepAll"):
            return Made(path, args)
        if is_node(path):
            return self._library_object(path, args, call)
        if last == "ImageTransport":
            return Made(path, args, node=call.node)
        found = self.maker.idiom(call)
        if found is None and path.startswith(("rclcpp::", "std::", "rclcpp_", "rcl_", "RCLCPP_", "builtin")):
            if path.startswith("std::function") and args:
                return args[0]
            self.machine.forget(call)
            return Made(path, args, node=call.node)
        return found

    def _applied(self, call: Call) -> Value:
        """Call the function that a function of the standard library receives, once or for each item."""
        at = next(at for at, each in enumerate(call.args) if is_callable(each))
        if call.last in _ONCE:
            rest = members_of(call.args[-1]) if call.last == "apply" else call.args[at + 1 :]
            return self.machine.invoke(call.args[at], rest, call.node, call.frame)
        with self.machine.loop(call.node, call.frame):
            first = call.args[0]
            given = [one_of(first.values)] if isinstance(first, Items) and first.values else call.args[:1]
            self.machine.invoke(call.args[at], given, call.node, call.frame)
        return Open(text_of(call.node)[:60])

    def _library_object(self, path: str, args: list[Value], call: Call) -> Value:
        if is_node(path):
            this = Obj(None)
            self.make_node(this, path, args, call.node, call.frame)
            return this
        return Made(path, args, node=call.node)

    def _sleep(self, call: Call, value: Value | None, how: str = "") -> Value:
        seconds = constant(value) if isinstance(value, Seconds) else None
        what = str(seconds) if seconds is not None else shown(value)
        self.machine.does("sleep", what, call.node, call.frame, how, timeout=seconds)
        return Const(None)

    def _wait_for_message(self, call: Call) -> Value:
        """Wait for the next message of a topic, which a subscription of its own receives."""
        seconds = constant(call.args[3]) if len(call.args) > 3 else None
        how = "without time-out" if len(call.args) < 4 else "time-out that is open"
        how = how if seconds is None else f"time-out {seconds} s"
        if self.machine.role not in ("main", "constructor"):
            what = f"a message of {shown(call.args[2])}"
            self.machine.does("wait_for_message", what, call.node, call.frame, how, timeout=seconds)
        self.machine.forget(call)
        return Open("whether there was a message")

    def _wait_for_set(self, call: Call) -> Value:
        """Wait until an entity of a wait set is ready."""
        seconds = constant(call.args[0]) if call.args else None
        limit = seconds if isinstance(seconds, (int, float)) and seconds >= 0 else None
        is_endless = not call.args or (seconds is not None and limit is None)
        how = "without time-out" if is_endless else "time-out that is open"
        how = how if limit is None else f"time-out {limit} s"
        if self.machine.role not in ("main", "constructor", "thread"):
            self.machine.does("wait", on_text(call.node), call.node, call.frame, how, timeout=limit)
        return Made("rclcpp::WaitResult", node=call.node)

    def _started(self, call: Call) -> Value:
        """Start a thread; the end of its block waits for it, if that destroys its object."""
        ways = [each.path for each in call.args if isinstance(each, Made) and "launch::" in each.path]
        args = [each for each in call.args if getattr(each, "path", "") not in ways]
        is_deferred = any(each.endswith("deferred") for each in ways)
        target = bound(args)
        task = target if isinstance(target, Made) and target.path == TASK else None
        target = target if task is None else task.args[0]
        thread = Made("std::thread", [target]) if is_deferred else self._thread(call, target)
        thread.fields[BEGAN] = Const(id(self.machine.fact))
        if task is not None:
            task.fields[THREAD] = thread
        if call.last != "thread" and not is_deferred and is_callable(target) and is_lost(call.node):
            self.waiting.join(call, thread)
        return thread

    def _thread(self, call: Call, target: Value) -> Made:
        machine = self.machine
        owner = machine.owner or next(
            (each.this for each in options(target) if isinstance(each, Method) and each.this), None
        )
        if owner is None and call.frame.this is not None:
            owner = call.frame.this
        owner = owner or Obj(None)
        if machine.role not in ("main", "constructor"):
            machine.does("thread", getattr(target, "name", "a thread"), call.node, call.frame)
        if machine.entity is not None and machine.role == "accepted":
            self.maker.callback(machine.entity, "execute", "execute", target, owner).is_apart = True
        elif machine.role != "execute":
            holder = machine.entity_of("threads", "thread", call.node, call.frame, Obj(None))
            fact = self.maker.callback(holder, "callback", "thread", target, owner)
            thread = Made("std::thread", [target])
            self.waiting.threads[id(thread)] = thread, fact
            return thread
        return Made("std::thread", [target])

    def read_callback(self, target: Value, kind: str, node: Node, frame: Frame) -> None:
        """Read a callback without a port: of parameters, or of events such as matched ports."""
        owner = frame.this or self.machine.owner or Obj(None)
        holder = self.machine.entity_of("threads", kind, node, frame, Obj(None))
        self.maker.callback(holder, "callback", kind, target, owner)

    # --------------------------------------------------------------------------------- objects of libraries

    def _made(self, call: Call, on: Made) -> Value | None:
        last, path = call.last, on.path
        if on.effect is not None or path == "future":
            if last in ("get", "wait", "wait_for", "wait_until") and not self._is_there(on):
                return self._await(call, on, call.args if last != "get" else [], "blocks")
            return on
        found = self.waiting.method(call, on)
        if found is not None:
            return found
        if path == BUFFER:
            return look_up(self.machine, call, on)
        if path.endswith("Rate") and last == "sleep":
            rate = constant(on.args[0]) if on.args else None
            if isinstance(on.args[0] if on.args else None, Seconds):
                return self._sleep(call, on.args[0], "rate")
            period = Seconds(1.0 / rate) if isinstance(rate, (int, float)) and rate > 0 else None
            return self._sleep(call, period, "rate")
        if path.endswith("ImageTransport"):
            return self.images(call, on)
        if path.endswith("stringstream") and last == "str":
            if call.args:
                self.machine.set_member(on, "text", call.args[0])
                return Const(None)
            return on.fields.get("text", on.args[0] if on.args else Const(""))
        if path.endswith("signals2::signal") and last.startswith("connect") and call.args:
            slots = on.fields.setdefault(SLOTS, Items())
            if isinstance(slots, Items) and not any(each is call.args[-1] for each in slots.values):
                slots.values.append(call.args[-1])
            return Made("boost::signals2::connection")
        if "xecutor" in path:
            return self.executor(call, on)
        if path.startswith("rclcpp::") and path.endswith("WaitSet") and last == "wait":
            return self._wait_for_set(call)
        if path in self.machine.idioms and last in ("subscribe", "registerCallback") and call.args:
            return self._subscribes(call, on)
        if "ynchronizer" in path:
            return self._synchronizes(call, on)
        if path.endswith("Node") and last == "make_shared":
            return self._library_object(path, call.args, call)
        return None

    def _is_there(self, future: Made) -> bool:
        """Return whether a response is available: a callback received its future, or belongs to it."""
        machine = self.machine
        is_own = future.effect is None or future.effect.then is machine.fact
        return machine.role == "done callback" and is_own

    def _subscribes(self, call: Call, on: Made) -> Value | None:
        """Follow a filter of ``message_filters`` that is constructed first and subscribes later."""
        if call.last == "registerCallback":
            on.fields["heard"] = bound(call.args)
            return Open(call.last)
        found = self.maker.idiom(Call(call.node, call.frame, on.path, call.args, name=on.node))
        if isinstance(found, Port) and found.entity.kind == "subscriptions":
            on.fields["port"] = found
            if "heard" in on.fields:
                self.maker.callback(found.entity, "callback", "subscription", on.fields["heard"], found.owner)
            function = call.node.child_by_field_name("function")
            left = None if function is None else function.child_by_field_name("argument")
            self.machine.assign(left, found, call.frame)
        return found

    def _synchronizes(self, call: Call, on: Made) -> Value | None:
        """Follow a synchronizer of ``message_filters``: one callback takes the messages of its inputs."""
        held = on.fields.setdefault("inputs", Items(self._inputs(on.args)))
        if not isinstance(held, Items):
            return None
        if call.last == "connectInput":
            added = self._inputs(call.args)
            held.values += added
            if "heard" in on.fields:
                self._give_callback(added, on.fields["heard"])
            return Const(None)
        if call.last == "registerCallback" and call.args:
            on.fields["heard"] = bound(call.args)
            self._give_callback(held.values, on.fields["heard"])
            return Open(call.last)
        return None

    def _inputs(self, args: list[Value]) -> list[Value]:
        """Return the filters among arguments; those that do not subscribe yet may do so later."""
        found = [one for each in args for one in options(each)]
        idioms = self.machine.idioms
        return [each for each in found if isinstance(each, Port) or getattr(each, "path", None) in idioms]

    def _give_callback(self, inputs: list[Value], target: Value) -> None:
        """Give the inputs of a synchronizer its callback."""
        for each in inputs:
            if isinstance(each, Port):
                self.maker.callback(each.entity, "callback", "subscription", target, each.owner)
            elif isinstance(each, Made):
                each.fields["heard"] = target
                if "port" in each.fields:  # it has subscribed since the synchronizer got it
                    self._give_callback([each.fields["port"]], target)

    def _unknown(self, call: Call, on: Value) -> Value | None:
        """Record the possible effects of a method of an unknown object."""
        machine, last, what = self.machine, call.last, text_of(call.node.child_by_field_name("function"))[:60]
        if last in ("sleep_for", "sleep_until") and call.args:  # of a clock
            return self._sleep(call, call.args[0] if last == "sleep_for" else Open("until a time"))
        if last in _GOALS and machine.role in ("execute", "accepted", "thread"):
            machine.does(last, what, call.node, call.frame)
        elif last == "publish" and len(call.args) == 1 and isinstance(on, Open):
            machine.does("publish", what, call.node, call.frame)
        elif last in ("async_send_request", "async_send_goal") and isinstance(on, Open):
            do = "call" if last == "async_send_request" else "send_goal"
            return Made("future", effect=machine.does(do, what, call.node, call.frame, "async"))
        elif last in ("wait", "wait_for") and "future" in what.lower() and machine.role != "done callback":
            return self._await(call, None, call.args, "blocks")
        return None


def _item_of(value: Value, given: list[Node]) -> Value | None:
    """Return the item of a tuple or a pair with a number; None: not known."""
    number = text_of(given[0]) if given else ""
    parts = value.values if isinstance(value, Items) else value.args if isinstance(value, Made) else []
    return parts[int(number)] if number.isdigit() and int(number) < len(parts) else None
