"""Interprets locks, condition variables and semaphores of C++: holding, waiting and notifying."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import nullcontext
from typing import TYPE_CHECKING

from dineros.sources.cpp.following.calls import TASK, Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.following.statics import MUTEXES, SIGNALS
from dineros.sources.cpp.parsing import on_text, text_of
from dineros.sources.cpp.values import Const, Items, Lambda, Made, Method, Open, Value, constant, part
from dineros.sources.facts import BARRIER, HELD, CallbackFact

if TYPE_CHECKING:
    from tree_sitter import Node

_GUARDS = {"lock_guard", "unique_lock", "scoped_lock", "shared_lock"}
_HELD_ONCE = ("std::mutex", "std::timed_mutex", "mutex")
_NOT_NOW = ("defer_lock", "try_to_lock", "adopt_lock")
"""Arguments of a guard that do not wait for the lock; with the first, it does not hold it either."""
_WAITS = ("wait", "wait_for", "wait_until", "acquire", "try_acquire_for", "arrive_and_wait")
_NOTIFIES = ("notify_one", "notify_all", "release", "count_down", "set_value", "set_exception")
_LEAVES = ("break_statement", "return_statement", "throw_statement", "goto_statement")
_OK, _ENDS_WITH_OK = re.compile(r"\bok\(\)"), re.compile(r"\bok\(\)$")
_EXITS = ("exit(", "std::exit(", "abort(", "std::abort(")
BEGAN = "began"
"""Member of a thread: the id of the callback that has started it; 0: it has waited for its end."""
THREAD = "thread"
"""Member of a task: the thread that runs it."""
_RAN = "ran"
"""Member of a task: the id of the callback that has run it."""
ASKED = "asked"
"""Member of the future of a thread: whether it has ended was tested, so a branch may know that."""
SPUN = "spun"
"""Member of a promise: something has waited for it, so that it is set when it is waited for again."""
_LONGEST = 60
"""Limit of the characters of an expression that names a lock."""


class Waiting:
    """Interprets methods of locks and of signals between threads.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Statements) -> None:
        self.machine = machine
        self._labels: dict[int, tuple[Value, str]] = {}
        self._unknown: dict[str, list[int]] = {}
        self.threads: dict[int, tuple[Made, CallbackFact]] = {}
        """Threads that callbacks have started, with what they do, by id."""

    def forget(self) -> None:
        """Forget the names of locks and signals: code that is read again creates them again."""
        self._labels.clear()
        self._unknown.clear()

    def is_guard(self, call: Call) -> bool:
        """Return whether a call creates an object that holds locks during its lifetime."""
        return call.last in _GUARDS

    def guard(self, call: Call) -> Value:
        """Take the locks that are given to a guard."""
        made = Made("std::unique_lock", call.args)
        given = list(zip(call.args, _texts(call.node), strict=False)) or [(value, "") for value in call.args]
        how = next((each for each in _NOT_NOW for _, text in given if text.endswith(each)), "")
        names = [
            (self._label(value, text, call), value) for value, text in given if not text.endswith(_NOT_NOW)
        ]
        made.fields["locks"] = Items([value for _, value in names])
        if not how:
            self._lock(names, call)
        elif how != "defer_lock":
            self.machine.holding += [name for name, _ in names if name not in self.machine.holding]
        return made

    def lock_together(self, call: Call) -> Value:
        """Take the locks that ``std::lock`` gets; those of guards that wait for it, too."""
        names: list[tuple[str, Value]] = []
        for value, text in zip(call.args, _texts(call.node), strict=False):
            held = value.fields.get("locks") if isinstance(value, Made) else None
            inner = held.values if isinstance(held, Items) else [value]
            names += [(self._label(each, text, call), each) for each in inner]
        self._lock(names, call)
        return Const(None)

    def method(self, call: Call, on: Made) -> Value | None:
        """Return the result of a method of a lock or a signal; None: another method."""
        kind = on.path.rpartition("::")[2]
        if kind == "unique_lock" and call.last in ("lock", "unlock"):
            held = on.fields.get("locks")
            for each in held.values if isinstance(held, Items) else ():
                self._take(self._label(each, "", call), call, each)
            return Const(None)
        if kind.endswith(MUTEXES) and call.last.startswith(("lock", "unlock")):
            self._take(self._label(on, on_text(call.node), call), call, on)
            return Const(None)
        if kind == "barrier" or (kind == "latch" and call.last == "arrive_and_wait"):
            return self._meet(call, on, kind)
        if kind.endswith(SIGNALS):
            return self._signal(call, on, kind)
        if on.path == TASK:
            return self._task(call, on)
        if kind == "thread" and call.last in ("join", "get", "wait"):
            is_over = ASKED in on.fields and self.machine.when != "always"
            return Open("a result") if is_over else self.join(call, on)
        if kind == "thread" and call.last in ("wait_for", "wait_until"):
            on.fields[ASKED] = Const(True)
            is_repeated = bool(self.machine.ways_out) and not self.machine.ways_out[-1]
            is_own = on.fields.get(BEGAN) == Const(id(self.machine.fact))
            return self.join(call, on) if is_repeated and is_own else Open("a status")
        return None

    def _task(self, call: Call, on: Made) -> Value | None:
        """Run a task, or wait for its end; None: another method."""
        machine, thread = self.machine, on.fields.get(THREAD)
        name = self._label(on, on_text(call.node), call)
        if call.last == "operator()":
            on.fields[_RAN] = Const(id(machine.fact))
            result = machine.invoke(on.args[0], call.args, call.node, call.frame)
            if machine.role not in ("main", "constructor"):
                machine.does("notify", name, call.node, call.frame)
            return result
        if call.last not in ("get", "wait", "wait_for", "wait_until"):
            return None
        if on.fields.get(_RAN) == Const(id(machine.fact)):
            return Open("a result")
        if isinstance(thread, Made):
            return self.join(call, thread)
        return self._signal(call, on, "promise")

    def _meet(self, call: Call, on: Made, kind: str) -> Value | None:
        """Arrive at a barrier or a latch, and wait for the others; None: another method.

        The last one that arrives at a barrier runs its function.
        """
        machine, name = self.machine, self._label(on, on_text(call.node), call)
        is_whole = call.last == "arrive_and_wait" or (call.last == "wait" and not call.args)
        if not is_whole and call.last not in ("arrive", "arrive_and_drop", "wait"):
            return None
        count = constant(on.args[0]) if on.args else None
        if is_whole or call.last != "wait":
            if len(on.args) > 1:
                with nullcontext() if count == 1 else machine.perhaps():
                    machine.invoke(on.args[1], [], call.node, call.frame)
            if count != 1 and machine.role not in ("main", "constructor"):
                machine.does("notify", name, call.node, call.frame, BARRIER)
        if count != 1 and (is_whole or call.last == "wait"):
            machine.does("wait", name, call.node, call.frame, f"{kind}, without time-out")
        return Open("a token")

    def _signal(self, call: Call, on: Made, kind: str) -> Value | None:
        name = self._label(on, on_text(call.node), call)
        if call.last in _NOTIFIES:
            if self.machine.role not in ("main", "constructor"):
                self.machine.does("notify", name, call.node, call.frame)
            return Const(None)
        if call.last not in _WAITS and (kind, call.last) != ("promise", "get"):
            return None
        is_variable = kind.startswith("condition")
        rest = call.args[1:] if is_variable else call.args
        seconds = constant(rest[0]) if rest and call.last.endswith("_for") else None
        bound = "without time-out"
        if call.last.endswith(("_for", "_until")):
            bound = f"time-out {seconds} s" if seconds is not None else "time-out that is open"
        if seconds == 0:
            return Open("a wait")
        if SPUN in on.fields:
            return Open("a result")
        if kind == "promise" and bound != "without time-out":
            on.fields[SPUN] = Const(True)
        words = "condition variable" if is_variable else kind
        held = list(self.machine.holding)
        if is_variable and held:
            self.machine.holding.pop()  # the given lock is free while it waits
        self.machine.does("wait", name, call.node, call.frame, f"{words}, {bound}", timeout=seconds)
        self.machine.holding[:] = held
        return Open("a wait")

    def join(self, call: Call, thread: Made) -> Value:
        """Wait for the end of a thread: a callback that has started it does what the thread does.

        A thread that has begun before usually ends by itself, when a callback requests it.
        """
        machine, began = self.machine, thread.fields.get(BEGAN)
        if machine.role in ("main", "constructor") or began == Const(0):
            return Open("a result")
        if began == Const(id(machine.fact)) and isinstance(thread.args[0], (Lambda, Method)):
            thread.fields[BEGAN] = Const(0)
            _, fact = self.threads.get(id(thread), (thread, None))
            machine.todo = [each for each in machine.todo if each.fact is not fact]
            for node in machine.nodes:  # what the thread does is done here, and at no other time
                node.callbacks = [each for each in node.callbacks if each is not fact]
            return machine.invoke(thread.args[0], [], call.node, call.frame)
        what = f"the thread {on_text(call.node)}"
        machine.does("wait", what, call.node, call.frame, "blocks, without time-out")
        return Open("a result")

    def _take(self, name: str, call: Call, lock: Value) -> None:
        if call.last.startswith("lock"):
            self._lock([(name, lock)], call)
        elif name in self.machine.holding:
            self.machine.holding.remove(name)

    def _lock(self, locks: list[tuple[str, Value]], call: Call) -> None:
        """Wait for locks, and hold them: several at once are taken in an order that cannot deadlock."""
        for name, lock in locks:
            is_held = name in self.machine.holding and isinstance(lock, Made) and lock.path in _HELD_ONCE
            self.machine.does("lock", name, call.node, call.frame, HELD if is_held else "")
        self.machine.holding += [name for name, _ in locks]

    def _label(self, value: Value, text: str, call: Call) -> str:
        """Return the name of a lock or signal: one for each object, by the expression that first names it."""
        if id(value) in self._labels:
            return self._labels[id(value)][1]
        name = text.removeprefix("this->").lstrip("*&")
        this = call.frame.this
        if not name or len(name) > _LONGEST:
            name = part(value)[:_LONGEST] if isinstance(value, Open) else "a mutex"
        elif this is not None and this.node is None and this.cls is not None and name in this.cls.fields:
            name = f"{this.cls.name}::{name}"
        if isinstance(value, Made):
            taken = sum(each == name or each.startswith(f"{name} (") for _, each in self._labels.values())
            name = f"{name} ({taken + 1})" if taken else name
        else:  # members of two nodes are two locks
            owners = self._unknown.setdefault(name, [])
            owner = id(this) if this is not None and this.node is not None else 0
            if owner not in owners:
                owners.append(owner)
            number = owners.index(owner) + 1
            name = f"{name} ({number})" if number > 1 else name
        self._labels[id(value)] = value, name
        return name


def _texts(node: Node) -> Iterator[str]:
    """Yield the arguments in the code, including those of a variable that looks like a function."""
    inner = node.child_by_field_name("value") or node.child_by_field_name("arguments")
    if inner is None:
        inner = node.child_by_field_name("parameters")
    if inner is not None and inner.type == "call_expression":
        inner = inner.child_by_field_name("arguments")
    for each in inner.named_children if inner is not None else ():
        if each.type != "comment":
            yield text_of(each)


def is_repeated_until_true(call: Node) -> bool:
    """Return whether a loop repeats a call until it returns true, or until shutdown.

    It is the condition of the loop, ``while (!call)``, or that of its way out, ``if (call) { break; }``.
    """
    asked = call
    test = call.parent
    is_negated = test is not None and text_of(test).startswith("!")
    if test is not None and is_negated:
        asked, test = test, test.parent
    while test is not None and test.type in ("binary_expression", "parenthesized_expression"):
        sides = [test.child_by_field_name(each) for each in ("left", "right")]
        others = [each for each in sides if each is not None and each != asked]
        if any(text_of(test.child_by_field_name("operator")) != "&&" for _ in others):
            return False
        if not all(_ENDS_WITH_OK.search(text_of(each)) for each in others):  # until shutdown, too
            return False
        asked, test = test, test.parent
    loop = test.parent if test is not None and test.type == "condition_clause" else test
    way_out: Node | None = None
    if not is_negated:
        way_out = loop
        loop = loop.parent if loop is not None and _leaves(loop) else None
        loop = loop.parent if loop is not None and loop.type == "compound_statement" else None
        condition = loop.child_by_field_name("condition") if loop is not None else None
        if condition is not None and not text_of(condition).strip("()").endswith(("true", "1", "ok")):
            return False
    if loop is None or loop.type not in ("while_statement", "do_statement", "for_statement"):
        return False
    if loop.type == "for_statement" and loop.child_by_field_name("update") is not None:
        return False
    body = loop.child_by_field_name("body")
    return body is not None and not _may_leave(body, way_out)


def _leaves(choice: Node) -> bool:
    """Return whether a statement is an ``if`` that ends a loop."""
    part = choice.child_by_field_name("consequence") if choice.type == "if_statement" else None
    if part is not None and part.type == "compound_statement":
        part = part.named_children[-1] if part.named_children else None
    return part is not None and part.type in ("break_statement", "return_statement")


def _may_leave(body: Node, way_out: Node | None) -> bool:
    """Return whether the body of a loop may end it by another way than one, or at shutdown."""
    todo = [body]
    while todo:
        part = todo.pop()
        if part.type == "if_statement" and (
            part == way_out or _OK.search(text_of(part.child_by_field_name("condition")))
        ):
            rest = part.child_by_field_name("alternative")
            todo += [rest] if rest is not None else []
        elif part.type in _LEAVES or (part.type == "call_expression" and text_of(part).startswith(_EXITS)):
            return True
        else:
            todo += part.named_children
    return False
