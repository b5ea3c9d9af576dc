"""Interprets loops in C++; each iteration over known items is followed separately."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING

from dineros.sources.branches import Anything, Branch, Loop, Turns
from dineros.sources.cpp.declarators import name_of
from dineros.sources.cpp.following.endings.counting import assigned_in, counted, leaves, of_bound
from dineros.sources.cpp.following.endings.polling import CANCELED, POLLED, polled_members
from dineros.sources.cpp.following.endings.progress import NO_EXIT, why_open
from dineros.sources.cpp.following.expressions import named
from dineros.sources.cpp.following.fields import Fields
from dineros.sources.cpp.parsing import path_of, text_of
from dineros.sources.cpp.values import NO_VALUE, Const, Frame, Items, Obj, Open, Value, members_of, options
from dineros.sources.facts import STARTING, CallbackFact, Effect

if TYPE_CHECKING:
    from tree_sitter import Node

_ASKS = re.compile(r"\bok\s*\(|wait_for|wait_until|future_status|FutureReturnCode")
_GETTER = re.compile(r"(!?)\s*(?:this->)?(\w+)\(\)")
_NUMBERED = re.compile(r'<<\s*"([A-Za-z]\w*)"\s*<<\s*\w+\+\+\s*;')
"""The name of a numbered parameter."""
_NEVER = ("(0)", "(false)")
"""Conditions of ``do`` loops that only make one statement of several, as in macros."""
_KNOWN = ("wait", "spin", "get_result", "input", "join")
_BLOCKS = ("blocks", "spin", "waits", "polled", "await")
"""Effects in a loop that the model, or a finding, has already: what they wait for ends the loop, too."""
_LONGEST = 60
"""Limit of the characters of a loop's head."""
_MOST_TURNS = 100
"""Items of a list that are followed one by one."""


class Loops(Fields):
    """Runs loops."""

    @contextmanager
    def loop(self, node: Node, frame: Frame, count: int = 1) -> Iterator[None]:
        """Run code that is repeated any number of times, or `count` times."""
        if node.id not in self.assigned:
            self.assigned[node.id] = (assigned_in(node), _may_give_up(node))
        names, may_give_up = self.assigned[node.id]
        for name in names:
            if _is_plain(frame.values.get(name)):
                frame.values[name] = Open(name)
        self.loops += 1
        self.cond -= 1  # `perhaps` counts branches
        self.ways_out.append(may_give_up)
        try:
            with self.perhaps():
                yield
        finally:
            last = self.block.pop()
            assert isinstance(last, Branch)
            self.block.append(Loop(Anything(), last.then, count=count))
            self.loops -= 1
            self.cond += 1
            self.ways_out.pop()

    def _do_for_statement(self, node: Node, frame: Frame) -> None:
        self.run_block(node.child_by_field_name("initializer"), frame)
        name, numbers = self._counted(node, frame)
        if numbers:
            turns: list[Value] = [Const(each) for each in numbers]
            self._turns(turns, name, node.child_by_field_name("body"), frame)
            return
        count = counted(node, frame.values, self.value_of_bound(node, frame))
        with self._ending(node, frame), self.loop(node, frame, count):
            for name in ("condition", "body", "update"):
                each = node.child_by_field_name(name)
                if each is not None:
                    self.run_block(each, frame)

    def value_of_bound(self, loop: Node, frame: Frame) -> Value | None:
        """Return the value with which a loop compares its number; None: code computes it."""
        bound = of_bound(loop)
        return None if bound is None else self.value(bound, frame)

    def _counted(self, node: Node, frame: Frame) -> tuple[str, list[int]]:
        """Return the variable and its values in ``for (i = 0; i < list.size(); ++i)``; no values: not known.

        Numbers that are constants count, too, if the loop makes ports; other loops repeat what they do.
        """
        asked, update = node.child_by_field_name("condition"), node.child_by_field_name("update")
        left = asked.child_by_field_name("left") if asked is not None else None
        right = asked.child_by_field_name("right") if asked is not None else None
        name, body = text_of(left), node.child_by_field_name("body")
        first = frame.values.get(name)
        if (
            asked is None
            or update is None
            or right is None
            or body is None
            or text_of(asked.child_by_field_name("operator")) not in ("<", "<=", "!=")
            or text_of(update) not in (f"++{name}", f"{name}++", f"{name} += 1")
            or not isinstance(first, Const)
            or type(first.value) is not int
            or name in assigned_in(body)
            or leaves(body)
        ):
            return name, []
        is_size = right.type == "call_expression" and path_of(right.child_by_field_name("function")).endswith(
            "size"
        )
        if not is_size and not self.reach.may_make_ports(body):
            return name, []
        most = self.value(right, frame)
        if not isinstance(most, Const) or type(most.value) is not int:
            return name, []
        end = most.value + (text_of(asked.child_by_field_name("operator")) == "<=")
        return name, list(range(first.value, end)) if end - first.value <= _MOST_TURNS else []

    def _do_while_statement(self, node: Node, frame: Frame) -> None:
        with self._ending(node, frame), self.loop(node, frame):
            for each in named(node.child_by_field_name("condition")):
                if each.type == "declaration":
                    self.run_block(each, frame)  # ``while (auto job = next())``
                else:
                    self.value(each, frame)
            self.run_block(node.child_by_field_name("body"), frame)

    @contextmanager
    def _ending(self, loop: Node, frame: Frame) -> Iterator[None]:
        """Record after a loop what it waits for, or that nothing is known that ends it."""
        fact = self.fact
        self._polls(loop, frame)
        before = {id(each): each.how for each in fact.effects}
        yield
        if fact.kind in ("thread", "event", *STARTING) or self.off:
            return
        done = [each for each in fact.effects if before.get(id(each)) != each.how]
        at, last = self.place(loop, frame), loop.end_point[0] - loop.start_point[0]
        inside = [  # those of an earlier reading, too
            each for each in fact.effects if each.at.file == at.file and 0 <= each.at.line - at.line <= last
        ]
        is_known = any(
            each.do.startswith(_KNOWN) or each.how.startswith(_BLOCKS) for each in [*done, *inside]
        )
        sleeps = {id(each): each for each in done if each.do == "sleep"}
        why = "" if is_known else why_open(loop, sleeps=bool(sleeps.keys() - self.slept.keys()))
        self.slept |= sleeps  # they are those of this loop, and not of one around it
        if why:
            do = "loop" if why == NO_EXIT else "wait"
            self.does(
                do, f"the end of the loop {_said(loop)}" if do == "wait" else _said(loop), loop, frame, why
            )

    def _polls(self, loop: Node, frame: Frame) -> None:
        """Record that a loop waits until a member changes."""
        kind = partial(self._kind_of, frame)
        polled = polled_members(loop, partial(self._meaning, frame), partial(self._bodies, frame), kind)
        is_thread = self.fact.kind in ("thread", "event", *STARTING)
        if polled and not is_thread:
            words = " or ".join(sorted({each.name for each in polled}))
            self.does("wait", words, loop, frame, POLLED)
            self.polled.setdefault(words, set()).update(polled)

    def _kind_of(self, frame: Frame, name: str) -> str:
        """Return ``local`` for a variable of the function, ``member`` for one of the object, or empty."""
        around: Frame | None = frame
        while around is not None:
            if name in around.values:
                return "local"
            around = around.outer
        return "member" if self._is_member(name, frame) else ""

    def _meaning(self, frame: Frame, test: str) -> str:
        """Return a test with what a method of this object returns, if it does nothing else."""
        found, this = _GETTER.fullmatch(test), frame.this
        if found is None or this is None or this.cls is None:
            return test
        for each in self.methods(this.cls, found[2]):
            inner = named(each.body)
            is_plain = all(one.type == "declaration" and "lock" in text_of(one) for one in inner[:-1])
            if inner and inner[-1].type == "return_statement" and is_plain:
                return found[1] + text_of(inner[-1]).removeprefix("return").strip(" ;")
        return test

    def _bodies(self, frame: Frame, name: str) -> list[Node]:
        """Return the bodies of the methods of this object with a name."""
        this = frame.this
        found = self.methods(this.cls, name) if this is not None and this.cls is not None else []
        return [each.body for each in found if each.body is not None]

    def add_setters(self) -> None:
        """Give each callback that may end the wait of another one's loop an effect that says so.

        If code was not followed again, it is not known who else changes members, so nothing is added.
        """
        waited = {
            effect.what
            for todo in self.todo
            for effect in todo.fact.effects
            if (effect.do, effect.how) == ("wait", POLLED)
        }
        for words in waited:
            setters: dict[int, CallbackFact] = {}
            for polled in self.polled.get(words, ()):
                for fact, values in self.changed.get(polled.name, {}).values() if not self.skipped else ():
                    if any(polled.may_end_at(value) for value in values):
                        setters[id(fact)] = fact
                if polled.name == CANCELED:
                    setters |= {id(each.fact): each.fact for each in self.todo if each.fact.kind == "cancel"}
            for fact in setters.values():
                fact.effects.append(Effect("notify", words, fact.at, "conditional"))

    def _is_member(self, name: str, frame: Frame) -> bool:
        """Return whether a name is a member of this object or a global variable, and not a local one."""
        kinds = self.bases(frame.this.cls) if frame.this is not None and frame.this.cls is not None else []
        is_member = any(name in each.fields for each in kinds) or self.find_global(name, frame) is not None
        return name not in frame.values and is_member

    def _do_do_statement(self, node: Node, frame: Frame) -> None:
        condition = text_of(node.child_by_field_name("condition"))
        count = 1 if condition in _NEVER else self._numbered(node)
        if count is not None:
            self._turns([Const(turn) for turn in range(count)], "", node.child_by_field_name("body"), frame)
            return
        with self._ending(node, frame), self.loop(node, frame):
            self.run_block(node.child_by_field_name("body"), frame)
            self.value(node.child_by_field_name("condition"), frame)

    def _numbered(self, node: Node) -> int | None:
        """Return the iterations of a loop over the parameters ``odom0``, ``odom1``, ...; None: not known.

        The loop ends at the first one without a value. A launch file gives all values.
        """
        text = text_of(node.child_by_field_name("body"))
        asked = _NUMBERED.search(text)
        if asked is None or "get_parameter" not in text or leaves(node.child_by_field_name("body")):
            return None
        count = next(number for number in range(_MOST_TURNS + 1) if f"{asked[1]}{number}" not in self.given)
        return count if count or self.is_launched else None

    def _do_for_range_loop(self, node: Node, frame: Frame) -> None:
        name = name_of(node.child_by_field_name("declarator"))
        body = node.child_by_field_name("body")
        over = _one_list(self.value(node.child_by_field_name("right"), frame))
        found = over.values if isinstance(over, Items) else []
        if isinstance(over, Items) and not over.is_open and 0 < len(found) <= _MOST_TURNS:
            self._turns(found, name, body, frame, is_map=over.is_map)  # each item once, for certain
            return
        with self.loop(node, frame):
            rest = Open(f"each of {text_of(node.child_by_field_name('right'))}")
            is_map = isinstance(over, Items) and over.is_map
            self._turns([*found[:_MOST_TURNS], rest], name, body, frame, is_map=is_map)

    def _turns(
        self, items: list[Value], name: str, body: Node | None, frame: Frame, *, is_map: bool = False
    ) -> None:
        """Run the body of a loop for each item: each iteration creates ports of its own."""
        outer, turns = self.block, []
        for turn, each in enumerate(items):
            if name:
                frame.values |= _bound(name, each, is_map=is_map)
            self.turns.append(turn)
            self.block = []
            turns.append(self.block)
            self.run_block(body, frame)
            self.turns.pop()
        self.block = outer
        self.block.append(Turns(turns))


def _one_list(value: Value) -> Value:
    """Return one of several lists as a list with the items of all; other values as they are."""
    found = [each for each in options(value) if isinstance(each, Items)]
    if len(found) < 2:
        return found[0] if found and len(found) == len(options(value)) else value
    inner = list(dict.fromkeys(item for each in found for item in each.values))
    return replace(found[0], values=inner, is_open=True)


def _said(loop: Node) -> str:
    """Return the head of a loop in words."""
    asked = text_of(loop.child_by_field_name("condition")).strip("() ;")
    text = f"while ({' '.join(asked.split()) or 'true'})"
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."


def _is_plain(value: Value | None) -> bool:
    """Return whether a value is a number or a text, known or not: a loop may change it in each iteration."""
    found = options(value)
    return bool(found) and value is not NO_VALUE and all(isinstance(each, (Const, Open)) for each in found)


def _bound(name: str, item: Value, *, is_map: bool) -> dict[str, Value]:
    """Return the variables of a loop for an item: one, or several as in ``for (auto & [key, value] : map)``.

    Of a map, lists of this reader have the values only.
    """
    names = [each.strip() for each in name.strip("&[] ").split(",")]
    if len(names) == 1:
        return {name: item}
    is_value = is_map and isinstance(item, Obj)
    parts = [] if is_value else members_of(item)
    if len(parts) == len(names):
        return dict(zip(names, parts, strict=True))
    return {each: item if at == 1 and len(names) == 2 else Open(each) for at, each in enumerate(names)}


def _may_give_up(loop: Node) -> bool:
    """Return whether a loop may end while its future is not ready and the program continues."""
    asked = text_of(loop.child_by_field_name("condition"))
    if loop.type == "for_range_loop" or any(not _waits(part) for part in asked.split("&&")):
        return True
    todo = [loop.child_by_field_name("body")]
    while todo:
        each = todo.pop()
        if each is None:
            continue
        if each.type in ("break_statement", "return_statement", "throw_statement", "goto_statement"):
            return True
        if each.type == "lambda_expression":
            continue
        if each.type == "if_statement" and _waits(text_of(each.child_by_field_name("condition"))):
            todo.append(each.child_by_field_name("alternative"))
        else:
            todo += each.named_children
    return False


def _waits(condition: str) -> bool:
    """Return whether a condition only tests a future, or whether the program shall end."""
    return condition.strip(" ()") in ("true", "1", "") or bool(_ASKS.search(condition))
