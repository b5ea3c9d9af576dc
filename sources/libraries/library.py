"""Interprets calls of rclpy and other libraries, by dotted names and by the table of idioms."""

from __future__ import annotations

import ast
import sys
from collections.abc import Callable
from collections.abc import Mapping as AnyMapping
from contextlib import nullcontext

from dineros.sources.facts import TRANSFORM, NodeFact
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import (
    NONE,
    QUEUE,
    Const,
    Either,
    Frame,
    Function,
    Future,
    Generator,
    Goal,
    Items,
    LateItems,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Port,
    RunningNode,
    Text,
    Value,
    join,
    options,
    text_of,
)
from dineros.sources.libraries.applying import Idioms
from dineros.sources.libraries.built_ins import BuiltIns
from dineros.sources.libraries.command_line import PARSER, call_parser
from dineros.sources.libraries.containers import of_container
from dineros.sources.libraries.doing import Doer, Keys, seconds, within
from dineros.sources.libraries.executing.executors import Executors
from dineros.sources.libraries.idioms import Idiom
from dineros.sources.libraries.making import CREATES, Maker
from dineros.sources.libraries.standard.collected import Collected
from dineros.sources.libraries.standard.contexts import Contexts
from dineros.sources.libraries.standard.functional import Functional, calls_at_once
from dineros.sources.libraries.standard.functions import Standard
from dineros.sources.libraries.transforms import BUFFERS, timeout_of

_NODES = ("Node", "LifecycleNode", "ManagedNode")
_ONLY_LOOK = frozenset(
    (
        *("abs", "bool", "callable", "chr", "float", "hasattr", "hash", "id", "int", "isinstance"),
        *("issubclass", "len", "ord", "print", "range", "repr", "round", "str", "type"),
    )
)
"""Built-in functions that neither keep nor call their arguments."""
_CALLS_ITS_ARGUMENT = frozenset(("filter", "map", "max", "min", "sorted"))
_THREADS = frozenset(("threading.Thread", "threading.Timer", "multiprocessing.Process"))
"""Their functions run when they are started."""
_LOGS = frozenset(("critical", "debug", "error", "exception", "fatal", "info", "log", "warn", "warning"))
_WAITED_FOR = frozenset(("Barrier", "BoundedSemaphore", "Condition", "Event", "Semaphore"))
"""What one callback waits for, and another one sets."""

_NO_STRANGERS = frozenset((*sys.stdlib_module_names, "rclpy"))
"""Packages whose functions make no ports of a node that they get, or are known."""
_ONLY_ASK = ("ros2topic.api.", "ros2service.api.", "ros2node.api.")
"""Modules whose functions ask a node for names in the graph, and do nothing else with it."""


class RosLibrary:
    """The functions that are not in the folder.

    Parameters
    ----------
    machine : Machine
        The interpreter that calls them.
    idioms : mapping of str to Idiom
        The table of library idioms, by dotted names.
    """

    def __init__(self, machine: Machine, idioms: AnyMapping[str, Idiom]) -> None:
        self.machine = machine
        self.maker = Maker(machine)
        self.doer = Doer(self.maker)
        self.executors = Executors(self.doer)
        self.idioms = Idioms(self.doer, idioms)
        self.built_ins = BuiltIns(machine)
        self.standard = Standard(self.executors)
        self.functional = Functional(machine)
        self.collected = Collected(machine)
        self.contexts = Contexts(machine)
        self.substitute: Callable[[Value], Value] = lambda value: Open(text_of(value))

    # ---------------------------------------------------------------------------------------------- functions

    def call(self, path: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame) -> Value:
        """Call a function or class by its dotted name."""
        args = self._drawn(args, node, frame, is_one=path == "builtins.next")
        if path in _ITERATE:
            args = [
                self.machine.drawn(each, node, frame) if isinstance(each, Object) else each for each in args
            ]
        owner, _, last = path.rpartition(".")
        if args and isinstance(args[0], Object) and owner in args[0].cls.outside():
            if last == "__init__":
                self.construct(args[0], owner, args[1:], keys, node, frame)
                return NONE
            return self.call_method(OutsideMethod(args[0], last, path), args[1:], keys, node, frame)
        made = Made(path, args, keys, self.machine.place(node, frame))
        made.level = self.machine.activity.conditional
        idiom = self.idioms.table.get(path)
        if idiom is not None:
            self._escape(args, keys)
            return self.idioms.apply(idiom, made, node, frame, None)
        if path.startswith("rclpy"):
            found = self._rclpy(path, last, made, node, frame)
            if found is not None:
                return found
        if path == "builtins.print":
            for each in args:
                self.machine.shown(each, node, frame)
        of_containers = self.collected.call(path, made, node, frame)
        if of_containers is None:
            of_containers = self.functional.call(path, made, node, frame)
        if of_containers is not None:
            return of_containers
        if path.startswith("builtins."):
            if last not in _ONLY_LOOK:
                self._escape(args, keys, is_read=last in _CALLS_ITS_ARGUMENT)
            return self.built_ins.call(last, args, keys, node, frame)
        found = self.standard.call(path, last, made, node, frame)
        if found is None:
            self._escape(args, keys, is_read=path not in _THREADS and not calls_at_once(path))
            self._lend(made)
            return self.doer.once(made, made.at) if last in _WAITED_FOR else made
        return found

    def _drawn(self, args: list[Value], node: ast.AST, frame: Frame, *, is_one: bool = False) -> list[Value]:
        """Run the generators among arguments; as far as the next value, if `is_one`."""
        for value in args:
            if isinstance(value, (Generator, LateItems)) or (
                isinstance(value, Either) and _has_generator(value)
            ):
                break
        else:
            return args
        with self.machine.perhaps() if is_one else nullcontext():
            return [self.machine.drawn(each, node, frame) for each in args]

    def _escape(self, args: list[Value], keys: Keys, *, is_read: bool = True) -> None:
        for each in (*args, *keys.values()):
            self.machine.escape(each, is_read=is_read)

    def _lend(self, made: Made) -> None:
        """Record which nodes an unknown function gets; those of rclpy and of Python itself do not count."""
        if made.path.partition(".")[0] in _NO_STRANGERS or made.path.startswith(_ONLY_ASK):
            return
        for value in (*made.args, *made.keys.values()):
            fact = self.maker.fact_of(value)
            if fact is not None and (made.at, made.path) not in fact.lent_to:
                fact.lent_to.append((made.at, made.path))

    def _rclpy(self, path: str, last: str, made: Made, node: ast.AST, frame: Frame) -> Value | None:
        args, keys = made.args, made.keys
        if last == "create_node" or last in _NODES:
            fact = self.maker.node(made.argument(0, "node_name"), keys, node, frame, path, None)
            return RunningNode(fact)
        if last == "ActionServer":
            return self.maker.action_server(args, keys, node, frame)
        if last == "ActionClient":
            return self.maker.action_client(args, keys, node, frame)
        if last in ("spin", "spin_once", "spin_until_future_complete"):
            return self.executors.spin_by_function(last, made, node, frame)
        if last in ("shutdown", "try_shutdown"):
            if self.doer.is_callback() or self.machine.activity.fact.kind == "constructor":
                self.machine.effect("shutdown", "rclpy", node, frame)
            return NONE
        if last == "Parameter" and len(args) > 0:
            return made
        if last in ("ok", "init"):
            return Open(f"rclpy.{last}()")
        if last == "Future":
            return self.doer.once(made, made.at)
        if last == "wait_for_message" and self.doer.is_callback():
            given = made.argument(-1, "time_to_wait")
            what = f"a message of {text_of(made.argument(2, 'topic'))}"
            words = "without time-out" if given is None else within(given)
            self.machine.effect("wait_for_message", what, node, frame, words, timeout=seconds(given))
            return Open("message")
        return None

    def _of_launch(self, value: Made, name: str, args: list[Value]) -> Value | None:
        """Call a method of an action or a substitution of a launch file."""
        if name in ("add_action", "add_entity") and args:
            action = args[0]
            activity = self.machine.activity
            if activity.disabled or activity.conditional:
                word = "launch.never" if activity.disabled else "launch.perhaps"
                action = Made(word, [action], {}, value.at)
            slot = value.slots.get("added actions")
            if slot is None:
                self.machine.write_slot(value, "added actions", Items([action]))
            elif isinstance(slot.current, Items):
                slot.current.items.append(action)
            return NONE
        if name == "perform":
            return self.substitute(value)
        if name == "perform_substitution" and args:
            return self.substitute(args[0])
        if name == "find" and args:
            return Const(f"$(find {text_of(args[0])})")
        return None

    # ------------------------------------------------------------------------------------------------ methods

    def call_method(
        self, method: OutsideMethod, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value:
        """Call a method that no class of the program has."""
        value, name = method.instance, method.name
        if isinstance(value, (Generator, LateItems)):
            return self._drawn([value], node, frame, is_one=True)[0]
        if not isinstance(value, (Items, Mapping)) or name in ("extend", "update", "extendleft"):
            args = self._drawn(args, node, frame)
        if isinstance(value, Items) and name == "sort" and "key" in keys:
            self.functional.call_each([keys["key"]], {}, node, frame)
        if isinstance(value, Function) and name == "register" and args:
            value.registered.append(args[-1])
            return args[-1]
        found = self.idioms.method(value, name, args, node, frame)
        if found is None:
            found = self.collected.method(value, name, args, keys)
        if found is None and name == "run_in_executor" and len(args) > 1:
            return self.executors.run_apart(args[1], args[2:], node, frame)
        if found is None and isinstance(value, Port):
            found = self.doer.port(value, name, args, keys, node, frame)
        elif isinstance(value, Goal):
            found = self.doer.goal(value, name, args, keys, node, frame)
        elif isinstance(value, Future):
            found = self.doer.future(value, name, args, keys)
        elif isinstance(value, (Items, Mapping)):
            if args and (isinstance(value, Mapping) or value.kind == "set"):
                self.machine.hashed(args[0], node, frame)
            if isinstance(value, Items) and value.kind == QUEUE:
                self.doer.queue(value, name, args, keys, node, frame)
            found = of_container(self.machine, value, name, args, keys)
        elif found is None and isinstance(value, (Object, RunningNode)):
            found = self._method_of_node(value, name, args, keys, node, frame)
        elif isinstance(value, Const) and name in ("get_parameter_value", "to_msg", "to_parameter_msg"):
            found = value
        if found is None and isinstance(value, (Made, Object)):
            found = self.executors.method(value, name, args, keys, node, frame)
        if found is None and isinstance(value, Made):
            found = self._method_of_made(value, name, args, keys, node, frame)
        if found is None and not isinstance(value, (Port, Items, Mapping, Const, Text)):
            found = self.doer.unknown(value, name, args, keys, node, frame, method.text)
        if found is None or (name == "create_task" and not isinstance(found, Future)):
            self._escape(args, keys, is_read=name not in _LOGS)
            if not isinstance(value, (Port, Items, Mapping, Const, Text)):
                self.machine.attributes.may_call(method)
        if found is not None:
            return found
        for each in [*args, *keys.values()]:
            if isinstance(each, Items) and each.kind != "tuple":
                each.is_open = True
        return Open(f"{method.text}()")

    def _method_of_node(
        self,
        value: Object | RunningNode,
        name: str,
        args: list[Value],
        keys: Keys,
        node: ast.AST,
        frame: Frame,
    ) -> Value | None:
        fact = self.maker.fact_of(value)
        if fact is None and isinstance(value, Object) and self.maker.behaves_like_node(value, name):
            if not value.cls.outside():
                return None
            fact = self.maker.implicit(value)
        if fact is None:
            return None
        call = Made(name, args, keys, self.machine.place(node, frame))
        if name in CREATES:
            return self.maker.create(call, fact, node, frame)
        if name == "create_rate":
            return Made("rclpy.timer.Rate", args, keys, call.at)
        if name == "declare_parameter":
            return self.maker.declare(fact, call.argument(0, "name"), call.argument(1, "value"), call.at)
        if name == "declare_parameters":
            return self._declare_all(fact, call)
        if name in ("get_parameter", "get_parameter_or"):
            other = call.argument(1, "alternative_value") if name.endswith("_or") else None
            return self.maker.parameter(fact, call.argument(0, "name"), other)
        if name == "has_parameter":
            return Open("has_parameter()")
        if name in ("set_parameters", "set_parameters_atomically"):
            self.machine.effect("set_parameters", "parameters", node, frame)
            return NONE
        if name in (
            "add_on_set_parameters_callback",
            "add_post_set_parameters_callback",
            "set_parameters_callback",
        ):
            for each in options(call.argument(0, "callback")):
                self.machine.later(each, "parameters", fact, [Open("parameters")], id(fact))
            return NONE
        if name in ("get_name", "get_namespace", "get_fully_qualified_name"):
            return self.maker.own_name(fact, name)
        if name.startswith("destroy_") and name != "destroy_node":
            kind = name.removeprefix("destroy_")
            if self.doer.is_callback() or kind == "service":
                for each in options(args[0] if args else None) or [NONE]:
                    entity = each.entity if isinstance(each, Port) else None
                    self.machine.effect("destroy", kind, node, frame, entity=entity)
            return NONE
        return None

    def _declare_all(self, fact: NodeFact, call: Made) -> Value:
        prefix = text_of(call.argument(0, "namespace"))
        for each in self.machine.turns(call.argument(1, "parameters") or NONE)[0]:
            if isinstance(each, Items) and each.items:
                name = text_of(each.items[0])
                full = Const(f"{prefix}.{name}" if prefix else name)
                self.maker.declare(fact, full, each.items[1] if len(each.items) > 1 else None, call.at)
        return NONE

    def _method_of_made(
        self, value: Made, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        found = self.doer.lock(value, name, args, keys, node, frame)
        if found is not None:
            return found
        if (
            name == "enter_context"
            and args
            and self._acquire(args[0], getattr(args[0], "name", ""), node, frame)
        ):
            self.machine.activity.acquired.append(self.machine.activity.holding[-1])
        found = self.contexts.method(value, name, args, keys, node, frame)
        if found is not None:
            return found
        if calls_at_once(value.path):
            self.functional.call_each(args, keys, node, frame)
        if value.path == PARSER:
            return call_parser(self.machine, value, name, args, keys, self.maker.arguments)
        if value.path.startswith("launch"):
            return self._of_launch(value, name, args)
        if value.path in BUFFERS:
            timeout = timeout_of(name, Made(name, args, keys, value.at))
            if timeout is not None:
                limit = timeout if isinstance(timeout, float) else None
                words = "time-out open" if limit is None else f"time-out {limit:g} s"
                self.machine.effect("wait", TRANSFORM, node, frame, words, timeout=limit)
            return None
        if value.path == "rclpy.timer.Rate" and name == "sleep":
            rate = seconds(value.argument(0, "frequency"))
            what = f"{1 / rate:g}" if rate else "open"
            effect = self.machine.effect("sleep", what, node, frame, "rate")
            effect.timeout = 1 / rate if rate else None
            return NONE
        return None

    # ----------------------------------------------------------------------------------------------- the rest

    def attribute(self, value: Value, name: str) -> Value | None:
        """Return an attribute that the program has not set."""
        if isinstance(value, Outside):
            if value.path in ("typing.TYPE_CHECKING", "typing") and name == "TYPE_CHECKING":
                return Const(False)
            if value.path == "math" and name == "pi":
                return Const(3.141592653589793)
            if value.path.endswith("Ellipsis"):
                return Open("...")
            return None
        if isinstance(value, (Const, Items, Text, Mapping)):
            return (
                value
                if name == "value" or (name.endswith("_value") and name.count("_") <= 3 and "get" not in name)
                else None
            )
        if isinstance(value, Port) and name == "srv_name":
            return Const(value.entity.name, "variable")
        if isinstance(value, (Object, RunningNode)) and self.maker.fact_of(value) is not None:
            if name == "default_callback_group":
                return Made("default CallbackGroup", [], {}, self.maker.fact_of(value).at)  # type: ignore[union-attr]
            if name == "executor":
                return self.executors.of(self.maker.fact_of(value))
        if isinstance(value, Open) and name in ("executor",):
            return None
        return None

    def construct(
        self, instance: Object, path: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> None:
        """Begin the part of an object that a class outside of the folder has."""
        made = Made(path, args, keys, self.machine.place(node, frame))
        made.level = self.machine.activity.conditional
        idiom = self.idioms.table.get(path)
        if idiom is not None:
            self.idioms.apply(idiom, made, node, frame, instance)
            return
        last = path.rpartition(".")[2]
        if path.startswith("rclpy") and last in _NODES:
            if instance.node is None:
                name = made.argument(0, "node_name")
                instance.node = self.maker.node(name, keys, node, frame, path, instance)
                self._transitions(instance, path)
            return
        if last.endswith("CallbackGroup") or path.startswith(
            ("rclpy.executors", "threading", "rclpy.action")
        ):
            instance.made = made

    def _transitions(self, instance: Object, path: str) -> None:
        if "ifecycle" not in path:
            return
        for name in ("on_configure", "on_activate", "on_deactivate", "on_cleanup", "on_shutdown", "on_error"):
            method = self.machine.look_up(instance.cls, name)
            if method is not None:
                bound = self.machine.attribute(instance, name, name, instance.cls.node, instance.cls.frame)
                self.machine.later(bound, "transition", instance.node, [Open("state")], id(instance))

    def call_made(self, made: Made, args: list[Value], node: ast.AST, frame: Frame) -> Value | None:
        """Call what a library has made."""
        found = self.functional.call_made(made, args, node, frame)
        if found is None:
            found = self.collected.call_made(made, node, frame)
        if found is None:  # what a decorator of a library has made of a function
            self.functional.call_each(made.args, made.keys, node, frame)
        return found

    def leave(self, value: Value, node: ast.AST, frame: Frame) -> None:
        """Leave a ``with``: a pool of threads waits for its threads."""
        for each in options(value):
            with self.machine.perhaps() if isinstance(value, Either) else nullcontext():
                self.contexts.leave(each, node, frame)
            self.executors.leave(each, node, frame)

    def enter(self, value: Value, text: str, node: ast.AST, frame: Frame) -> Value:
        """Enter a ``with``; return what it assigns."""
        self._acquire(value, text, node, frame)
        found = []
        for each in options(value):
            with self.machine.perhaps() if isinstance(value, Either) else nullcontext():
                found.append(self.contexts.enter(each, node, frame))
        return join(found)

    def _acquire(self, value: Value, text: str, node: ast.AST, frame: Frame) -> bool:
        """Acquire a lock at the begin of a ``with``; return whether it is one."""
        for each in options(value):
            if isinstance(each, Made) and each.path.startswith(
                ("threading.", "multiprocessing.", "asyncio.")
            ):
                self.doer.acquire(each, text, node, frame, is_scope=len(options(value)) == 1)
                return True
        return False


_ITERATE = frozenset(
    f"builtins.{name}"
    for name in (
        *("list", "tuple", "set", "frozenset", "sorted", "reversed", "sum", "any", "all", "min", "max"),
        *("enumerate", "zip", "map", "filter", "iter", "dict"),
    )
)
"""Functions that go through their arguments."""


def _has_generator(value: Either) -> bool:
    return any(isinstance(each, (Generator, LateItems)) for each in value.options)
