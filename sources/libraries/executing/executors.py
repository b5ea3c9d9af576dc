"""Follows calls of executors and threads: what they spin, run, submit and wait for."""

from __future__ import annotations

import ast

from dineros.sources.facts import (
    SPINS_OTHERS,
    CallbackFact,
    Effect,
)
from dineros.sources.language.values import (
    NONE,
    Const,
    Frame,
    Future,
    Made,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Value,
    constant,
    is_none,
    join,
    options,
)
from dineros.sources.libraries.doing import Doer, Keys, passed, seconds, within
from dineros.sources.libraries.executing.placing import Places, executor_of
from dineros.sources.libraries.making import CONSTRUCTORS
from dineros.sources.places import Place


class Executors(Places):
    """Follows calls of executors and threads.

    `doer`: records effects.
    """

    def __init__(self, doer: Doer) -> None:
        super().__init__(doer)
        self._began: dict[int, tuple[Made, CallbackFact]] = {}
        """By id the threads that were started, and what started them."""
        self._read_later: dict[int, list[tuple[object, ...]]] = {}
        """By id the keys of the callbacks that these threads run."""
        self._submitted: dict[int, list[Made]] = {}
        """By id of a pool what it was given."""
        self._coroutines: dict[int, tuple[Made, list[Effect]]] = {}

    # ------------------------------------------------------------------------------------------- by functions

    def spin_by_function(self, name: str, made: Made, node: ast.AST, frame: Frame) -> Value:
        """Call ``rclpy.spin``, ``spin_once`` or ``spin_until_future_complete``."""
        facts = self.facts_of(made.argument(0, "node"))
        given = made.argument({"spin": 1, "spin_once": -1}.get(name, 2), "executor")
        executor = self.shared
        for each in options(given):
            found = executor_of(each)
            executor = found if found is not None else executor
        call = Made(name, made.args, made.keys, made.at)
        if name == "spin_until_future_complete":
            call = Made(name, [NONE, *made.args[1:2], *made.args[3:4]], made.keys, made.at)
        elif name == "spin_once":
            call = Made(name, [], {k: v for k, v in made.keys.items() if k == "timeout_sec"}, made.at)
        else:
            call = Made(name, [], {}, made.at)
        call.nodes = facts
        if self.is_outer():
            is_late = not self.is_target and self.late.is_late(name, node)
            for fact in facts:
                self.run(fact, executor, f"rclpy.{name}", made, is_late=is_late)
                self.take(fact, executor, name, call, node, frame)
        elif executor is self.shared:
            own = self.machine.activity.node
            for fact in facts if self.machine.activity.fact.kind == "constructor" else ():
                self.take(fact, executor, name, call, node, frame)
            how = "rclpy, its own node" if own is not None and own in facts else "rclpy"
            return self.doer.spin(name, facts, call, node, frame, how)
        return self.doer.spin(name, facts, call, node, frame, "rclpy")

    # --------------------------------------------------------------------------------------------- by methods

    def method(
        self, value: Made | Object, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of an executor or of a thread; None: another object."""
        made = value if isinstance(value, Made) else value.made
        if made is None:
            return None
        last = made.path.rpartition(".")[2]
        if last in ("Thread", "Timer", "Process") and name == "start":
            return self._start(value, made, node, frame)
        if (last == "ThreadPoolExecutor" and name == "submit" and args) or (
            last in _POOLS and name == "apply_async" and args
        ):
            if last in _POOLS:
                args = [args[0], *getattr(args[1] if len(args) > 1 else None, "items", [])]
            submitted = Made(SUBMITTED, args, {}, made.at)
            self._begin(submitted, args[0], args[1:], node, frame)
            self._submitted.setdefault(id(made), []).append(submitted)
            return submitted
        if last in _POOLS and name in ("apply", "map", "starmap", "imap", "imap_unordered") and args:
            given, _ = self.machine.turns(args[1]) if len(args) > 1 else ([], False)
            first = given[:1] if name.endswith(("map", "map_unordered")) else given
            self.machine.call(args[0], first or [Open("element")], {}, node, frame)
            return Open(name)
        if last == "ThreadPoolExecutor" and name == "map" and args:
            turns, _ = self.machine.turns(args[1]) if len(args) > 1 else ([], False)
            self.machine.call(args[0], turns[:1] or [Open("element")], {}, node, frame)
            return Open(name)
        if last == "ThreadPoolExecutor" and name == "shutdown":
            if constant(Made(name, args, keys, made.at).argument(0, "wait")) is not False:
                self.leave(made, node, frame)
            return NONE
        if (last, name) in (("Thread", "join"), ("Timer", "join"), ("submit", "result"), ("submit", "get")):
            self._wait_for(value, made, args, keys, node, frame)
            return Open(name)
        if last in ("ThreadPoolExecutor", "Thread", "Timer"):
            return None
        if name == "run_until_complete":
            self.run_coroutine(made, node, frame, "blocks, without time-out")
            return join(args) if args else Open(name)
        if (last, name) == ("run_coroutine_threadsafe", "result"):
            timeout = passed(Made("", args, keys, made.at).argument(0, "timeout"))
            for effect in self._coroutines.get(id(made), (made, []))[1]:
                effect.how, effect.timeout = f"blocks, {within(timeout)}", seconds(timeout)
            return Open(name)
        if not last.endswith("Executor"):
            return None
        if name == "add_node":
            call = Made(name, args, keys, made.at)
            for fact in self.facts_of(call.argument(0, "node")):
                if fact not in made.nodes:
                    made.nodes.append(fact)
                self.put(fact, made)
                if id(made) in self.started:
                    self.run(fact, made, "add_node", Made("", [], {}, self.machine.place(node, frame)))
            return Const(True, "variable")
        if name in ("spin", "spin_once", "spin_until_future_complete", "spin_some"):
            at = Made("", [], {}, self.machine.place(node, frame))
            outer = self.is_outer() or self.machine.activity.fact.kind == "constructor"
            if outer:
                self.started.add(id(made))
                self.miss(made)
                if self.is_target or self.machine.activity.fact.kind == "thread":
                    self.background.add(id(made))
                is_late = not self.is_target and self.late.is_late(name, node)
                for fact in made.nodes:
                    self.run(fact, made, name, at, is_late=is_late)
            own = isinstance(value, Object)
            if own:
                for fact in made.nodes:
                    fact.threads = f"open: own executor {value.cls.node.name}"  # type: ignore[union-attr]
            if name == "spin_until_future_complete":
                call = Made(name, [NONE, *args], keys, made.at)
            elif name == "spin_once":
                call = Made(name, [NONE, NONE, *args], keys, made.at)
            else:
                call = Made(name, [], {}, made.at)
            how = made.name or "executor"
            if made.nodes and not (outer or own or self.is_of(made, self.machine.activity.node)):
                how = SPINS_OTHERS
            return self.doer.spin(name, made.nodes, call, node, frame, how)
        if name == "create_task" and args:
            for each in options(args[0]):
                self.machine.later(each, TASK, self.machine.activity.node, args[1:], made.at)
            return Future("task")
        if name == "remove_node" and args:
            for fact in self.facts_of(args[0]):
                self.put(fact, NONE)
        if name in ("shutdown", "remove_node", "wake", "get_nodes"):
            return Open(name)
        return None

    def run_apart(self, function: Value, args: list[Value], node: ast.AST, frame: Frame) -> Value:
        """Run a function in a thread of a pool: the coroutine waits for its end, if it awaits it."""
        if self.machine.awaited is node:
            return self.machine.call(function, args, {}, node, frame)
        self._thread(function, args, {}, node, frame)
        return Open("future")

    def run_coroutine(self, made: Made, node: ast.AST, frame: Frame, how: str) -> None:
        """Change how a coroutine waits that a call of asyncio gets: ``asyncio.run(self.work())``."""
        args = node.args if isinstance(node, ast.Call) else []
        calls = [each for each in args if isinstance(each, ast.Call)]
        begun = {(frame.module.path, each.lineno, each.col_offset) for each in calls}
        found = [
            each
            for each in self.machine.activity.fact.effects
            if each.how in ("await", "async") and begun.intersection(each.path)
        ]
        for effect in found:
            effect.how = how
        self._coroutines[id(made)] = made, found

    def leave(self, value: Value, node: ast.AST, frame: Frame) -> None:
        """Wait for all that a pool of threads was given, as the end of a ``with`` does."""
        for each in self._submitted.pop(id(value), []):
            self._wait_for(each, each, [], {}, node, frame)

    def wait_for_all(self, values: Value | None, timeout: Value | None, node: ast.AST, frame: Frame) -> None:
        """Wait for futures of a pool of threads: ``concurrent.futures.wait``, ``as_completed``."""
        for each in getattr(values, "items", []) if is_none(timeout) else []:
            if isinstance(each, Made) and each.path == SUBMITTED:
                self._wait_for(each, each, [], {}, node, frame)

    def _begin(
        self, thread: Made, target: Value | None, args: list[Value], node: ast.AST, frame: Frame
    ) -> None:
        before = len(self.machine.callbacks)
        self._thread(target, args, {}, node, frame)
        self._began[id(thread)] = thread, self.machine.activity.fact
        self._read_later[id(thread)] = list(self.machine.callbacks)[before:]

    def _wait_for(
        self, value: Made | Object, made: Made, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> None:
        """Let a callback that starts a thread and waits for its end do what the thread does.

        A thread that has begun before usually ends by itself, because a callback makes it end.
        """
        timeout = Made("", args, keys, made.at).argument(0, "timeout")
        _, began_in = self._began.get(id(made), (made, None))
        fact = self.machine.activity.fact
        if not is_none(timeout) or began_in is not fact or fact.kind in (*CONSTRUCTORS, "thread"):
            return
        later_keys = self._read_later.pop(id(made), None)
        if later_keys is None:
            return  # it has waited for that before
        for key in later_keys:  # the callback does it
            later = self.machine.callbacks.pop(key, None)
            if later is not None and later.node is not None and later.fact in later.node.callbacks:
                later.node.callbacks.remove(later.fact)
        if made.path == SUBMITTED:
            self.machine.call(made.args[0], made.args[1:], {}, node, frame)
        elif isinstance(value, Object):
            bound = self.machine.attribute(value, "run", "run", node, frame)
            self.machine.call(bound, [], {}, node, frame)
        elif (target := made.argument(1, "target", "function")) is not None:
            given = getattr(made.argument(2 if made.path.endswith("Timer") else -1, "args"), "items", [])
            self.machine.call(target, list(given), {}, node, frame)

    def _start(self, value: Made | Object, made: Made, node: ast.AST, frame: Frame) -> Value:
        """Start a thread: its code is read later; a thread that spins belongs to an executor."""
        self._began[id(made)] = made, self.machine.activity.fact
        before = len(self.machine.callbacks)
        found = self._start_thread(value, made, node, frame)
        self._read_later[id(made)] = list(self.machine.callbacks)[before:]
        return found

    def _start_thread(self, value: Made | Object, made: Made, node: ast.AST, frame: Frame) -> Value:
        if isinstance(value, Object):
            run = self.machine.look_up(value.cls, "run")
            if run is not None:
                bound = self.machine.attribute(value, "run", "run", node, frame)
                return self._thread(bound, [], {}, node, frame)
        is_timer = made.path.endswith("Timer")
        target = made.argument(1, "target" if not is_timer else "function")
        args = made.argument(-1 if not is_timer else 2, "args")
        given = getattr(args, "items", []) if args is not None else []
        return self._thread(target, list(given), {}, node, frame, made.at)

    def _thread(
        self,
        target: Value | None,
        args: list[Value],
        keys: Keys,
        node: ast.AST,
        frame: Frame,
        at: Place | None = None,
    ) -> Value:
        self.machine.attributes.has_begun = True
        for each in options(target):
            path = each.path if isinstance(each, Outside) else ""
            is_rclpy = path.startswith("rclpy.")
            if is_rclpy and path.endswith("shutdown"):
                self.machine.effect("shutdown", path, node, frame, "in a thread")
                continue
            if is_rclpy or (isinstance(each, OutsideMethod) and executor_of(each.instance) is not None):
                self.is_target = True
                self.machine.call(each, args, keys, node, frame)
                self.is_target = False
                continue
            if is_none(each):
                continue
            line = at.line if at is not None else getattr(node, "lineno", 0)
            fact = self.machine.later(each, "thread", self.machine.activity.node, args, line)
            activity = self.machine.activity
            fact.is_many |= id(fact) in self.orders or bool(activity.loops) or self.doer.is_callback()
            self.orders.setdefault(id(fact), self.machine.next_order())
            if self.doer.is_callback():
                place = (
                    ast.Pass(lineno=line, col_offset=0)
                    if at is not None and at.file == frame.module.path
                    else node
                )
                self.machine.effect("thread", fact.name, place, frame).then = fact
        return NONE


TASK = "task"
"""Kind of the functions that an executor runs once, in no callback group."""
_POOLS = ("ThreadPool", "Pool")
"""Classes of ``multiprocessing``."""
SUBMITTED = "concurrent.futures.submit"
"""Path of the future of a function that a thread of a pool runs."""
