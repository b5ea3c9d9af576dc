"""Determines the effects of callbacks on ports, goals, futures, executors and locks."""

from __future__ import annotations

import ast
from typing import TypeVar

from dineros.sources.facts import AWAITED, BARRIER, HELD, Effect, Entity, NodeFact
from dineros.sources.language.fields.messages import sent
from dineros.sources.language.machine import EVENT
from dineros.sources.language.values import (
    NONE,
    Const,
    Frame,
    Future,
    Goal,
    Items,
    Made,
    Open,
    Outside,
    OutsideMethod,
    Port,
    Response,
    Value,
    constant,
    is_none,
    options,
)
from dineros.sources.libraries.making import CONSTRUCTORS, Maker
from dineros.sources.libraries.transforms import of_duration
from dineros.sources.places import Place
from dineros.sources.variables import Known

Keys = dict[str, Value]
Made_ = TypeVar("Made_", Made, Items)


def seconds(value: Value | None) -> float | None:
    """Return a number of seconds; None: not a number."""
    number = constant(value)
    return float(number) if isinstance(number, (int, float)) and not isinstance(number, bool) else None


def passed(value: Value | None) -> Value | None:
    """Return a time-out, of which a negative one has passed already, as in calls and waits for servers."""
    number = seconds(value)
    return Const(0) if number is not None and number < 0 else value


def within(value: Value | None) -> str:
    """Return a time-out in words; a negative number is none, as in spinning."""
    number = seconds(value)
    if number is not None and number >= 0:
        return f"time-out {number:g} s"
    return "without time-out" if is_none(value) or number is not None else "time-out open"


class Doer:
    """Records effects.

    `maker`: knows the nodes.
    """

    def __init__(self, maker: Maker) -> None:
        self.maker = maker
        self.machine = maker.machine
        self._named: dict[str, dict[Value, int]] = {}  # values compare by identity
        self.waits: list[tuple[Effect, Place]] = []  # for events and conditions, with where these were made
        self._once: dict[tuple[Place, tuple[object, ...]], Value] = {}

    def is_callback(self) -> bool:
        """Return whether the executor calls the code that is being read."""
        return self.machine.activity.fact.kind not in CONSTRUCTORS

    # -------------------------------------------------------------------------------------------------- ports

    def port(
        self, port: Port, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of a port; None: it has no relevant effect."""
        entity, kind = port.entity, port.entity.kind
        effect = self.machine.effect
        call = Made(name, args, keys, self.machine.place(node, frame))
        if kind == "publishers" and name == "publish":
            effect("publish", entity.port, node, frame, entity=entity, sends=self._sent(entity, node, frame))
            return NONE
        if kind == "clients":
            if name == "call_async":
                return Future("call", effect("call", entity.port, node, frame, "async", entity), entity)
            if name == "call":
                given = passed(call.argument(1, "timeout_sec"))
                how = f"blocks, {within(given)}"
                return Response(
                    "response", effect("call", entity.port, node, frame, how, entity, seconds(given))
                )
            if name == "wait_for_service":
                given = passed(call.argument(0, "timeout_sec"))
                effect("wait_for_service", entity.port, node, frame, within(given), entity, seconds(given))
                return Open("is ready")
        if kind == "action_clients":
            return self._action_client(entity, port, call, node, frame)
        if kind == "timers" and name in ("cancel", "reset", "destroy"):
            effect(
                f"{name}_timer" if name != "destroy" else "destroy", entity.port, node, frame, entity=entity
            )
            return NONE
        if kind == "guard_conditions" and name == "trigger":
            effect("trigger", entity.port, node, frame, entity=entity)
            return NONE
        if name == "destroy" and self.is_callback():
            effect("destroy", entity.port, node, frame, entity=entity)
        return None

    def _sent(self, entity: Entity, node: ast.AST, frame: Frame) -> dict[str, Known]:
        """Return the fields of a published message that are certain, if the code makes it of its class."""
        if not isinstance(node, ast.Call) or not isinstance(node.func, ast.Attribute):
            return {}
        if node.func.attr != "publish":
            return {}
        fields, maker = sent(None if frame.function is None else frame.function.node, node)
        root = maker
        while isinstance(root, ast.Attribute):
            root = root.value
        if maker is None or not fields or not isinstance(root, ast.Name):
            return {}
        if not isinstance(self.machine.evaluate(root, frame), Outside):
            return {}  # what else has attributes may compute them
        made = self.machine.evaluate(maker, frame)
        if not isinstance(made, Outside) or made.is_star:
            return {}
        if made.path != entity.type.replace("/", "."):
            return {}
        values = {name: self.machine.fixed(value, frame) for name, value in fields.items()}
        return {name: value for name, value in values.items() if value is not None}

    def _action_client(
        self, entity: Entity, port: Port, call: Made, node: ast.AST, frame: Frame
    ) -> Value | None:
        effect, name = self.machine.effect, call.path
        if name == "wait_for_server":
            given = passed(call.argument(0, "timeout_sec"))
            effect("wait_for_server", entity.port, node, frame, within(given), entity, seconds(given))
            return Open("is ready")
        if name in ("send_goal_async", "send_goal"):
            found = effect("send_goal", entity.port, node, frame, "async", entity)
            feedback = call.argument(1, "feedback_callback")
            if not is_none(feedback) and feedback is not None:
                fact = self.machine.later(feedback, "feedback", port.node, [Open("feedback")], str(found.at))
                found.meanwhile += [fact] if fact not in found.meanwhile else []
            if name == "send_goal_async":
                return Future("goal", found, entity)
            effect("get_result", "goal", node, frame, "blocks, without time-out", entity)
            return Open("result")
        return None

    # -------------------------------------------------------------------------------------- goals and futures

    def goal(
        self, goal: Goal, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of a goal, in a client or a server."""
        effect = self.machine.effect
        if goal.side == "server":
            if name in ("succeed", "abort", "canceled"):
                effect(name, "goal", node, frame, entity=goal.entity)
                return NONE
            if name == "publish_feedback":
                effect(name, "feedback", node, frame, entity=goal.entity)
                return NONE
            if name == "execute":
                effect("execute_goal", "goal", node, frame, entity=goal.entity)
                return NONE
            return None
        if name in ("get_result_async", "get_result"):
            is_async = name == "get_result_async"
            how = "async" if is_async else "blocks, without time-out"
            found = effect("get_result", "goal", node, frame, how, goal.entity)
            return Future("result", found, goal.entity) if is_async else Open("result")
        if name in ("cancel_goal_async", "cancel_goal"):
            is_async = name == "cancel_goal_async"
            found = effect(
                "cancel_goal",
                "goal",
                node,
                frame,
                "async" if is_async else "blocks, without time-out",
                goal.entity,
            )
            return Future("cancel", found, goal.entity) if is_async else Open("response")
        return None

    def future(self, future: Future, name: str, args: list[Value], keys: Keys) -> Value | None:
        """Call a method of a future."""
        if name == "result":
            return self.machine.result_of(future)
        if name == "add_done_callback":
            function = args[0] if args else keys.get("callback")
            found = None
            for each in options(function):
                if is_none(each):
                    continue
                at = future.effect.at if future.effect is not None else self.machine.activity.fact.at
                key = (str(at), id(future.entity), future.of)
                found = self.machine.later(each, "done callback", self.machine.activity.node, [future], key)
                if isinstance(each, OutsideMethod) and isinstance(each.instance, Made):
                    found.is_open = False
            if future.effect is not None and found is not None:
                future.effect.how = f"async with {found.name}"
                future.effect.then = found
            return NONE
        if name in ("done", "cancelled", "exception", "cancel"):
            return Open(f"{name}()")
        return None

    def once(self, made: Made_, at: Place) -> Made_:
        """Return what a callback makes at a line and what others set: the same whenever it is read."""
        if not self.is_callback():
            return made
        calls = tuple(each for each in self.machine.trail if isinstance(each, tuple))
        known: Made_ = self._once.setdefault((at, calls), made)  # type: ignore[assignment]
        return known

    # ---------------------------------------------------------------------------------------------- executors

    def spin(
        self, name: str, facts: list[NodeFact], call: Made, node: ast.AST, frame: Frame, how: str
    ) -> Value:
        """Record a spin: ``spin``, ``spin_once``, ``spin_until_future_complete``."""
        fact = self.machine.activity.fact
        self.machine.attributes.has_begun = True
        future = call.argument(1, "future")
        timeout = call.argument(2, "timeout_sec")
        do = _SPINS.get(name, "spin")
        for each in options(future) if do == "spin_until" else ():
            if isinstance(each, Future) and each.effect is not None:
                each.effect.how = "spin-until"
        what = "future" if do == "spin_until" else facts[0].name if facts else OPEN_NODE
        waits = any(effect.do in ("call", "send_goal") for effect in fact.effects)
        if (
            (self.is_callback() and fact.kind != EVENT)
            or fact.kind == "constructor"
            or do == "spin_until"
            or (do == "spin_once" and waits)
        ):
            self._record_spin(do, what, timeout, node, frame, how)
        return Open("spun")

    def record_spin(self, name: str, call: Made, node: ast.AST, frame: Frame, how: str) -> Effect:
        """Record a spin, and return its effect."""
        do = _SPINS.get(name, "spin")
        what = "future" if do == "spin_until" else call.nodes[0].name if call.nodes else OPEN_NODE
        return self._record_spin(do, what, call.argument(2, "timeout_sec"), node, frame, how)

    def _record_spin(
        self, do: str, what: str, timeout: Value | None, node: ast.AST, frame: Frame, how: str
    ) -> Effect:
        words = f"{how}, {within(timeout)}"
        found = self.machine.effect(do, what, node, frame, words, timeout=seconds(timeout))
        found.holding = found.holding or self.machine.activity.locks()
        return found

    # --------------------------------------------------------------------------------------- locks and queues

    def lock(
        self, made: Made, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of a lock, an event, a condition, a queue or a thread."""
        effect, activity = self.machine.effect, self.machine.activity
        kind = made.path.split(".")[-1]
        if kind == "Future":
            return self._of_future(made, name, args, keys, node, frame)
        label = self._label(made, made.name or made.path)
        call = Made(name, args, keys, self.machine.place(node, frame))
        if kind in ("Semaphore", "BoundedSemaphore") and constant(made.argument(0, "value")) == 0:
            kind, name = "Event", {"acquire": "wait", "release": "set"}.get(name, name)
            call = Made(name, args[1:], keys, call.at)  # the first argument is `blocking`
            if args[:1] and constant(args[0]) is not True:
                return Open("is held")
        if kind in ("Lock", "RLock", "Semaphore", "BoundedSemaphore", "Condition") and name in (
            "acquire",
            "release",
        ):
            if name == "acquire":
                self.acquire(made, label, node, frame, may_give_up=bool(args or keys))
            else:
                activity.release(made)
            return Open("is held")
        if kind in ("Event", "Condition", "Barrier") and name in ("wait", "wait_for"):
            given = passed(call.argument(0 if name == "wait" else 1, "timeout"))
            found = effect("wait", label, node, frame, within(given), timeout=seconds(given))
            if found.how == within(None) and (kind, name) != ("Condition", "wait_for") and kind != "Barrier":
                self.waits.append((found, made.at))
            if kind == "Condition":  # it releases its lock while it waits
                lock = made.argument(0, "lock")
                own = {label, self._label(lock, lock.name or lock.path) if isinstance(lock, Made) else label}
                found.holding = tuple(each for each in found.holding if each not in own)
            if kind == "Barrier" and constant(made.argument(0, "parties")) != 1:
                effect("notify", label, node, frame, BARRIER)
            return Open("is set")
        if kind in ("Event", "Condition") and name in ("set", "notify", "notify_all", "clear"):
            if name != "clear":
                self._notify(made, label, node, frame)
            return NONE
        return None

    def _of_future(
        self, made: Made, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method of a future that the program makes itself, or await it."""
        label = self._label(made, made.name or made.path)
        if name == "__await__":
            self.machine.effect("wait", label, node, frame, AWAITED)
            return Open("result")
        if name in ("set_result", "set_exception", "cancel"):
            self._notify(made, label, node, frame)
            return NONE
        return self.future(Future("task"), name, args, keys)

    def _notify(self, made: Made, label: str, node: ast.AST, frame: Frame) -> None:
        """Record that the code ends a wait; loops may ask for it, too."""
        self.machine.effect("notify", label, node, frame)
        self.machine.attributes.changed.append((made.name or made.path, self.machine.activity.fact))

    def _label(self, value: Value, name: str) -> str:
        """Return a name for a lock, an event or a queue that no other one of the program has."""
        same = self._named.setdefault(name, {})
        index = same.setdefault(value, len(same) + 1)
        return name if index == 1 else f"{name} (number {index})"

    def acquire(
        self,
        lock: Made,
        label: str,
        node: ast.AST,
        frame: Frame,
        *,
        is_scope: bool = False,
        may_give_up: bool = False,
    ) -> None:
        """Acquire a lock; one that only one thread can hold, and that this one has already, never comes."""
        activity, label = self.machine.activity, self._label(lock, lock.name or label)
        is_single = lock.path == "threading.Lock" and lock.level == 0 and not may_give_up
        is_held = any(held is lock and is_certain for _, held, is_certain in activity.holding)
        self.machine.effect("lock", label, node, frame, HELD if is_single and is_held else "")
        activity.holding.append((label, lock, is_scope))
        activity.acquired.append(activity.holding[-1])

    def queue(
        self, queue: Items, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame
    ) -> None:
        """Record that a callback waits for an item or for room in a queue without time-out, or gives them.

        A callback that gets items under a condition usually knows that there are some.
        """
        activity, label = self.machine.activity, self._label(queue, queue.name or "a queue")
        call = Made(name, args, keys, self.machine.place(node, frame))
        index = int(name == "put")
        block, timeout = call.argument(index, "block"), call.argument(index + 1, "timeout")
        is_endless = is_none(timeout) and (block is None or constant(block) is True)
        waits = is_endless and not activity.conditional and activity.fact.kind not in ("thread", EVENT)
        waits = waits and self.is_callback()
        if name in ("put", "put_nowait"):
            if name == "put" and waits and queue.is_bounded:
                self.machine.effect("wait", f"room in {label}", node, frame, within(None))
            self.machine.effect("notify", label, node, frame)
        elif name in ("get", "get_nowait"):
            if name == "get" and waits:
                self.machine.effect("wait", label, node, frame, within(None))
            if queue.is_bounded:
                self.machine.effect("notify", f"room in {label}", node, frame)
        elif name == "task_done":
            self.machine.effect("notify", f"the end of all tasks in {label}", node, frame)
        elif name == "join" and self.is_callback() and activity.fact.kind not in ("thread", EVENT):
            self.machine.effect("wait", f"the end of all tasks in {label}", node, frame, within(None))

    def unknown(
        self, value: Value, name: str, args: list[Value], keys: Keys, node: ast.AST, frame: Frame, text: str
    ) -> Value | None:
        """Call a method of an unknown object: by names that only rclpy has."""
        effect = self.machine.effect
        what = f"open: {text}"
        call = Made(name, args, keys, self.machine.place(node, frame))
        if name == "call_async":
            return Future("call", effect("call", what, node, frame, "async"))
        if name == "send_goal_async":
            found = effect("send_goal", what, node, frame, "async")
            feedback = call.argument(1, "feedback_callback")
            if feedback is not None and not is_none(feedback):
                self.machine.later(
                    feedback, "feedback", self.machine.activity.node, [Open("feedback")], str(found.at)
                )
            return Future("goal", found)
        if name in ("get_result_async", "cancel_goal_async"):
            return self.goal(Goal("client"), name, args, keys, node, frame)
        if name in ("wait_for_service", "wait_for_server"):
            given = passed(call.argument(0, "timeout_sec"))
            effect(name, what, node, frame, within(given), timeout=seconds(given))
            return Open("is ready")
        if name == "sleep_for" and (duration := call.argument(0, "rel_time")) is not None:
            number = of_duration(duration)
            words = "open" if number is None else f"{number:g}"
            effect("sleep", words, node, frame, "Clock.sleep_for", timeout=number)
            return Open("slept")
        if name == "publish_feedback":
            return self.goal(Goal("server"), name, args, keys, node, frame)
        if name == "publish" and not isinstance(value, Made):
            effect("publish", what, node, frame)
            return NONE
        if name == "add_done_callback":
            return self.future(Future("task"), name, args, keys)
        if name == "spin_until_future_complete":
            return self.spin(name, [], Made(name, [NONE, *args], keys, call.at), node, frame, text)
        return None


_SPINS = {"spin_until_future_complete": "spin_until", "spin_once": "spin_once"}
"""Effects of functions that spin; others are ``spin``."""
QUEUES = {f"queue.{each}" for each in ("Queue", "LifoQueue", "PriorityQueue", "SimpleQueue")}
"""Queues between threads: a thread that gets an item waits for one."""
OPEN_NODE = "open"
