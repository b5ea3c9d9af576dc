"""Determines the executor and the number of threads that run the callbacks of a node."""

from __future__ import annotations

import ast

from dineros.sources.facts import (
    MAY_TAKE_AWAY,
    SPINS_OTHERS,
    TAKES_AWAY,
    CallbackFact,
    Effect,
    NodeFact,
    is_open,
)
from dineros.sources.language.machine import EVENT
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
    text_of,
)
from dineros.sources.libraries.doing import Doer, Keys, passed, seconds, within
from dineros.sources.libraries.making import CONSTRUCTORS
from dineros.sources.places import Place


class Executors:
    """Follows executors and threads.

    Parameters
    ----------
    doer : Doer
        Records effects.
    """

    def __init__(self, doer: Doer) -> None:
        self.doer = doer
        self.machine = doer.machine
        self._global = Made("rclpy.executors.SingleThreadedExecutor", [], {}, _NOWHERE)
        self._began: dict[int, tuple[Made, CallbackFact]] = {}
        """By id the threads that were started, and what started them."""
        self._read_later: dict[int, list[tuple[object, ...]]] = {}
        """By id the keys of the callbacks that these threads run."""
        self._submitted: dict[int, list[Made]] = {}
        """By id of a pool what it was given."""
        self._coroutines: dict[int, tuple[Made, list[Effect]]] = {}
        self._pools: dict[int, int] = {}
        self._of: dict[int, Made] = {}
        self._started: set[int] = set()
        self._kept: list[Made] = []
        self._spun: list[NodeFact] = []
        self._members: dict[int, Made] = {}
        """By id of a node what has its place as an attribute: an executor, or a spin that took it away."""
        self._background: set[int] = set()
        """Ids of the executors that run in threads of their own."""
        self._of_threads: list[tuple[list[Made], Effect]] = []
        self._orders: dict[int, int] = {}
        """By id of a node or of a thread where it is added, or begins, in the start of the program."""
        self._is_target = False
        """Whether what is called is the function of a thread itself."""

    def of(self, fact: NodeFact | None) -> Value | None:
        """Return the executor of a node."""
        found = self._of.get(id(fact))
        return found if found is not None else Open("executor")

    def _facts(self, value: Value | None) -> list[NodeFact]:
        found = []
        for each in options(value):
            fact = self.doer.maker.fact_of(each)
            if fact is not None and fact not in found:
                found.append(fact)
        return found

    # ------------------------------------------------------------------------------------------- by functions

    def spin_by_function(self, name: str, made: Made, node: ast.AST, frame: Frame) -> Value:
        """Call ``rclpy.spin``, ``spin_once`` or ``spin_until_future_complete``."""
        facts = self._facts(made.argument(0, "node"))
        given = made.argument({"spin": 1, "spin_once": -1}.get(name, 2), "executor")
        executor = self._global
        for each in options(given):
            found = _executor(each)
            executor = found if found is not None else executor
        call = Made(name, made.args, made.keys, made.at)
        if name == "spin_until_future_complete":
            call = Made(name, [NONE, *made.args[1:2], *made.args[3:4]], made.keys, made.at)
        elif name == "spin_once":
            call = Made(name, [], {k: v for k, v in made.keys.items() if k == "timeout_sec"}, made.at)
        else:
            call = Made(name, [], {}, made.at)
        call.nodes = facts
        if self._is_outer():
            for fact in facts:
                self._run(fact, executor, f"rclpy.{name}", made)
                self._take(fact, executor, name, call, node, frame)
        elif executor is self._global:
            own = self.machine.activity.node
            for fact in facts if self.machine.activity.fact.kind == "constructor" else ():
                self._take(fact, executor, name, call, node, frame)
            how = "rclpy, its own node" if own is not None and own in facts else "rclpy"
            return self.doer.spin(name, facts, call, node, frame, how)
        return self.doer.spin(name, facts, call, node, frame, "rclpy")

    def _is_outer(self) -> bool:
        """Return whether no executor calls the spinning code."""
        return self.machine.activity.fact.kind in ("main", "thread", "module", EVENT)

    # ------------------------------------------------------------------------------ where a node is, in rclpy

    def _put(self, fact: NodeFact, where: Value) -> None:
        member = self._members.setdefault(id(fact), Made("", [], {}, _NOWHERE))
        self.machine.write_slot(member, "where", where)
        self._orders[id(fact)] = self.machine.next_order()

    def _where(self, fact: NodeFact) -> list[Value]:
        slot = self._members[id(fact)].slots.get("where") if id(fact) in self._members else None
        return options(slot.current) if slot is not None else []

    def _take(
        self, fact: NodeFact, executor: Made, name: str, call: Made, node: ast.AST, frame: Frame
    ) -> None:
        """Let a function of rclpy take a node out of its executor: it does not put it back.

        With an executor that has the node, ``spin_once`` and ``spin_until_future_complete`` leave it there,
        in rclpy since July 2024. A thread whose function is ``rclpy.spin`` runs the node as long as it lives.
        """
        activity = self.machine.activity
        is_thread = activity.fact.kind == "thread" or self._is_target
        places = self._where(fact)
        before = [each for each in places if isinstance(each, Made) and each.path != TAKEN]
        if not before or (name == "spin" and is_thread) or (name != "spin" and before == [executor]):
            return
        effect = self.doer.record_spin(name, call, node, frame, "rclpy")
        taken = Made(TAKEN, [join(before)], {}, call.at)
        taken.effect = effect
        taken.level = int(bool(activity.loops) and activity.loops == activity.conditional)
        if name != "spin":
            around = self._started if is_thread else self._background
            is_after = not is_thread or self._orders[id(fact)] <= self._orders.get(id(activity.fact), 0)
            is_lost = any(id(each) in around for each in before)
            self._lose(effect, is_lost, is_certain=len(places) == 1 and is_after)
        if is_thread:  # it is read repeatedly, after the main function
            self._of_threads.append((before, effect))
        else:
            self._put(fact, taken)

    def _lose(self, effect: Effect | None, is_lost: bool, *, is_certain: bool) -> None:
        """Record that a spin takes a node away from an executor that runs, or runs later."""
        if is_lost and effect is not None:
            words = TAKES_AWAY if is_certain else MAY_TAKE_AWAY
            effect.how = effect.how.replace("rclpy,", f"rclpy, {words},", 1) if "," in effect.how else words

    def _miss(self, executor: Made) -> None:
        """Record which nodes an executor that begins to spin has no longer."""
        for fact in executor.nodes:
            places = self._where(fact)
            for each in places:
                if isinstance(each, Made) and each.path == TAKEN and executor in options(each.args[0]):
                    self._lose(each.effect, True, is_certain=len(places) == 1 or bool(each.level))
        for before, effect in self._of_threads:
            self._lose(effect, executor in before, is_certain=len(before) == 1)

    def _run(self, fact: NodeFact, executor: Made, how: str, made: Made) -> None:
        threads = threads_of(executor)
        kind = executor.path.rpartition(".")[2]
        if fact.threads == "not spun" or how == "rclpy.spin" or executor is not self._global:
            fact.threads = threads
            words = how if executor is self._global else f"{kind}, {how}"
            fact.executor = f"{words} ({made.at})"
        order = self.machine.next_order()
        if fact not in self._spun or not order:  # a thread may spin earlier than the main function
            self._spun.append(fact)
            fact.spun = order
        fact.pool = self._pool(executor)
        self._of[id(fact)] = executor

    def _pool(self, executor: Made) -> int:
        if id(executor) not in self._pools:
            self.machine.pools += 1
            self._kept.append(executor)
            self._pools[id(executor)] = self.machine.pools
        return self._pools[id(executor)]

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
        if last == "ThreadPoolExecutor" and name == "submit" and args:
            submitted = Made(SUBMITTED, args, {}, made.at)
            self._begin(submitted, args[0], args[1:], node, frame)
            self._submitted.setdefault(id(made), []).append(submitted)
            return submitted
        if last == "ThreadPoolExecutor" and name == "map" and args:
            turns, _ = self.machine.turns(args[1]) if len(args) > 1 else ([], False)
            self.machine.call(args[0], turns[:1] or [Open("element")], {}, node, frame)
            return Open(name)
        if last == "ThreadPoolExecutor" and name == "shutdown":
            if constant(Made(name, args, keys, made.at).argument(0, "wait")) is not False:
                self.leave(made, node, frame)
            return NONE
        if (last, name) in (("Thread", "join"), ("submit", "result")):
            self._wait_for(value, made, args, keys, node, frame)
            return Open(name)
        if last in ("ThreadPoolExecutor", "Thread"):
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
            for fact in self._facts(call.argument(0, "node")):
                if fact not in made.nodes:
                    made.nodes.append(fact)
                self._put(fact, made)
                self._of[id(fact)] = made
                if id(made) in self._started:
                    self._run(fact, made, "add_node", Made("", [], {}, self.machine.place(node, frame)))
            return Const(True, "variable")
        if name in ("spin", "spin_once", "spin_until_future_complete", "spin_some"):
            at = Made("", [], {}, self.machine.place(node, frame))
            outer = self._is_outer() or self.machine.activity.fact.kind == "constructor"
            if outer:
                self._started.add(id(made))
                self._miss(made)
                if self._is_target or self.machine.activity.fact.kind == "thread":
                    self._background.add(id(made))
                for fact in made.nodes:
                    self._run(fact, made, name, at)
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
            if made.nodes and not (outer or own or self._is_of(made, self.machine.activity.node)):
                how = SPINS_OTHERS
            return self.doer.spin(name, made.nodes, call, node, frame, how)
        if name == "create_task" and args:
            for each in options(args[0]):
                self.machine.later(each, TASK, self.machine.activity.node, args[1:], made.at)
            return Future("task")
        if name == "remove_node" and args:
            for fact in self._facts(args[0]):
                self._put(fact, NONE)
        if name in ("shutdown", "remove_node", "wake", "get_nodes"):
            return Open(name)
        return None

    def _is_of(self, executor: Made, fact: NodeFact | None) -> bool:
        """Return whether a node is, or may be, one of those that an executor runs."""
        return fact is None or fact in executor.nodes or self._of.get(id(fact)) is executor

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
        elif (target := made.argument(1, "target")) is not None:
            given = getattr(made.argument(-1, "args"), "items", [])
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
            if is_rclpy or (isinstance(each, OutsideMethod) and _executor(each.instance) is not None):
                self._is_target = True
                self.machine.call(each, args, keys, node, frame)
                self._is_target = False
                continue
            if is_none(each):
                continue
            line = at.line if at is not None else getattr(node, "lineno", 0)
            fact = self.machine.later(each, "thread", self.machine.activity.node, args, line)
            self._orders.setdefault(id(fact), self.machine.next_order())
            if self.doer.is_callback():
                place = (
                    ast.Pass(lineno=line, col_offset=0)
                    if at is not None and at.file == frame.module.path
                    else node
                )
                self.machine.effect("thread", fact.name, place, frame).then = fact
        return NONE


def _executor(value: Value | None) -> Made | None:
    """Return the executor of a value."""
    made = value.made if isinstance(value, Object) else value
    return (
        made
        if isinstance(made, Made) and made.path.endswith("Executor") and "concurrent" not in made.path
        else None
    )


def threads_of(executor: Made) -> int | str:
    """Return the number of threads of an executor; ``processors`` if it depends on the machine."""
    kind = executor.path.rpartition(".")[2]
    if kind in ("SingleThreadedExecutor", "EventsExecutor", "StaticSingleThreadedExecutor"):
        return 1
    if kind == "MultiThreadedExecutor":
        given = executor.argument(0, "num_threads")
        if is_none(given):
            return "processors"
        number = constant(given)
        if isinstance(number, int) and number > 0:
            return number
        if isinstance(given, (Made, Open)) and "cpu_count" in (
            given.path if isinstance(given, Made) else given.text
        ):
            return "processors"
        return text_of(given) if is_open(text_of(given)) else f"open: {text_of(given)}"
    return f"open: {executor.path}"


_NOWHERE = Place("", 0)
TASK = "task"
"""Kind of the functions that an executor runs once, in no callback group."""
TAKEN = "taken"
"""Path of a value that stands for a spin that took a node out of an executor."""
SUBMITTED = "concurrent.futures.submit"
"""Path of the future of a function that a thread of a pool runs."""
