"""The state of the interpreter of a program: position, results, and values of variables."""

from __future__ import annotations

import ast
from collections.abc import Hashable, Iterator
from contextlib import contextmanager
from typing import Protocol

from dineros.sources.branches import Do
from dineros.sources.facts import STARTING, CallbackFact, Effect, Entity, Item, NodeFact
from dineros.sources.language.activities import Activity, Block, Perhaps
from dineros.sources.language.attributes import Attributes, Slots, Written, lend
from dineros.sources.language.inner import callback_key, widen
from dineros.sources.language.modules import Module, Modules
from dineros.sources.language.values import (
    Bound,
    Callback,
    Class,
    Const,
    Frame,
    Function,
    Future,
    Items,
    Made,
    Mapping,
    Object,
    Open,
    Outside,
    OutsideMethod,
    Partial,
    Port,
    RunningNode,
    Text,
    Value,
    options,
)
from dineros.sources.places import Place
from dineros.sources.variables import Known

MOST_STEPS = 400_000
"""Limit of the expressions and statements of one program."""
MOST_STEPS_OF_EVENTS = 100_000
"""Limit of those of events of one program."""
MOST_CALLS = 30
"""Limit of the depth of calls."""
MOST_SIMILAR = 4
"""Limit of the depth of calls of inner functions that are made at one line, such as those of a decorator."""
MOST_AGAIN = 2
"""Limit of how often a callback makes itself again with other constants."""
MOST_CALLBACKS = 600
"""Limit of the callbacks of one program."""


EVENT = "event"
"""Kind of a callback that code outside of the folder calls: of a driver, a window, a server."""
FALLS, RETURNS, RAISES, BREAKS, CONTINUES = "falls", "returns", "raises", "breaks", "continues"
"""The possible ends of statements: the first continues with the next statement."""


class TooLong(Exception):  # noqa: N818
    """The program is too large to be followed."""


class Library(Protocol):
    """Interprets functions that are not in the folder."""

    def call(
        self, path: str, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Call a function or class by its dotted name."""

    def call_method(
        self, method: OutsideMethod, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Call a method that no class of the program has."""

    def attribute(self, value: Value, name: str) -> Value | None:
        """Return an attribute that the program has not set; None: a method, or unknown."""

    def construct(
        self,
        instance: Object,
        path: str,
        args: list[Value],
        keys: dict[str, Value],
        node: ast.AST,
        frame: Frame,
    ) -> None:
        """Begin the part of an object that a class outside of the folder has."""

    def call_made(self, made: Made, args: list[Value], node: ast.AST, frame: Frame) -> Value | None:
        """Call what a library has made, such as ``operator.methodcaller("run")``; None: unknown."""

    def enter(self, value: Value, text: str, node: ast.AST, frame: Frame) -> Value:
        """Enter a ``with``; return what it assigns."""

    def leave(self, value: Value, node: ast.AST, frame: Frame) -> None:
        """Leave a ``with``."""


class Machine(Slots):
    """The position of the interpreter, and its results.

    Parameters
    ----------
    modules : Modules
        The folder's modules.
    program : str
        The program that is run, in words.
    """

    def __init__(self, modules: Modules, program: str) -> None:
        self.modules = modules
        self.program = program
        self.script: str | None = None
        self.frames: dict[str, Frame] = {}
        self.presets: dict[str, Made] = {}
        self.nodes: list[NodeFact] = []
        self.callbacks: dict[tuple[object, ...], Callback] = {}
        self.entities: dict[tuple[object, ...], Entity] = {}
        self.activity: Activity
        self.trail: list[object] = []
        self.calls: list[Function] = []
        self.reading: Callback | None = None
        self.run = 0
        self.is_final = False
        self.steps = 0
        self.most_steps = MOST_STEPS
        self.pools = 0
        self.turns_again = 0
        self.raised: list[Value] = []
        self._order = 0
        self._index: dict[int, tuple[list[Effect], dict[Hashable, Effect], int]] = {}
        self.home = ""
        self.stars: dict[str, list[str]] = {}  # of modules outside of the folder, by the file
        self.attributes = Attributes()
        self.awaited: ast.AST | None = None
        self.unused: ast.AST | None = None
        self.operands: dict[int, list[list[Item]]] = {}
        self._lent: dict[tuple[Object, int], tuple[int, int]] = {}  # changes when unknown code got an object
        self.new_classes: list[Class] = []
        self.begun: set[Object] = set()  # objects of an own ``__new__`` whose constructor has run
        self.library: Library

    # -------------------------------------------------------------------------------------------- where it is

    def place(self, node: ast.AST, frame: Frame) -> Place:
        """Return the location of a part of the code."""
        file = frame.module.path
        known: Place | None = getattr(node, "place", None)  # loops and calls ask for it again
        if known is None or known.file != file:
            known = node.place = Place(file, getattr(node, "lineno", 1))  # type: ignore[attr-defined]
        return known

    def step(self) -> None:
        """Count a step.

        Raises
        ------
        TooLong
            There were too many.
        """
        self.steps += 1
        if self.steps > self.most_steps:
            raise TooLong

    @contextmanager
    def doing(self, activity: Activity) -> Iterator[None]:
        """Assign the effects to another activity."""
        before = getattr(self, "activity", activity)
        self.activity = activity
        try:
            yield
        finally:
            self.activity = before

    def perhaps(
        self,
        *,
        is_loop: bool = False,
        is_disabled: bool = False,
        is_kept: bool = False,
        ways: list[Written] | None = None,
    ) -> Perhaps:
        """Run code that may be executed any number of times; yield its block, which the caller may keep.

        Attributes that it sets may also have their values from before, afterwards. With `ways`, they have
        these values again, and `ways` has the new ones.
        """
        return Perhaps(
            self, self.activity, is_loop=is_loop, is_disabled=is_disabled, is_kept=is_kept, ways=ways
        )

    def block(self) -> Block:
        """Collect the effects in a block of its own."""
        return Block(self.activity)

    @contextmanager
    def each(self, index: object, *, is_loop: bool = True) -> Iterator[None]:
        """Run one iteration of a loop whose iterations are known."""
        self.trail.append(index)
        self.activity.loops += is_loop
        try:
            yield
        finally:
            self.activity.loops -= is_loop
            self.trail.pop()

    # ---------------------------------------------------------------------------------------------- variables

    def escape(self, value: Value | None, depth: int = 3, *, is_read: bool = True) -> None:
        """Record that unknown code receives a value: it may call the functions in the value at any time.

        These are read as callbacks of events, unless `is_read` is false.
        """
        if isinstance(value, (Const, Open, Text, Outside)):
            return  # it has no functions
        for each in options(value):
            if isinstance(each, (Function, Bound, Partial)):
                self.attributes.may_call(each)
                is_new = len(self.callbacks) < MOST_CALLBACKS // 2  # the rest is for other callbacks
                if is_read and is_new and self.described(each)[1] is not None:
                    self.later(each, EVENT, self.activity.node, [], EVENT)
            elif isinstance(each, Port):
                each.entity.is_lent = True
            elif isinstance(each, RunningNode):
                each.fact.is_lent = True
            elif isinstance(each, Object):
                now = self.changes, len(self.nodes)
                if self._lent.get((each, depth)) != now:
                    self._lent[each, depth] = now
                    lend(each, depth)
            elif isinstance(each, OutsideMethod) and isinstance(each.instance, Port):
                each.instance.entity.is_lent = True
            elif isinstance(each, Items) and depth:
                for item in each.items:
                    self.escape(item, depth - 1, is_read=is_read)
            elif isinstance(each, Mapping) and depth:
                for item in (*each.items.values(), *each.rest):
                    self.escape(item, depth - 1, is_read=is_read)

    # -------------------------------------------------------------------------------------- what it has found

    def effect(
        self,
        do: str,
        what: str,
        node: ast.AST,
        frame: Frame,
        how: str = "",
        entity: Entity | None = None,
        timeout: float | None = None,
        sends: dict[str, Known] | None = None,
    ) -> Effect:
        """Record an effect of the activity; equal effects at one location are recorded once."""
        activity = self.activity
        when = "in a loop" if activity.loops else "conditional" if activity.conditional else "always"
        at = self.place(node, frame)
        path = tuple(
            each for each in self.trail if isinstance(each, tuple)
        )  # of calls, without turns of loops
        known = self._recorded(activity.fact).get((do, at, what, path, id(entity)))
        if known is not None:
            known.sends = {key: each for key, each in known.sends.items() if (sends or {}).get(key) == each}
            activity.block.append(Do(known))
            return known
        found = Effect(do, what, at, when, how, entity, None, timeout, activity.locks(), path)
        found.sends = dict(sends or {})
        found.order = self.next_order()
        activity.fact.effects.append(found)
        activity.block.append(Do(found))
        return found

    def _recorded(self, fact: CallbackFact) -> dict[Hashable, Effect]:
        """Return the effects of a callback by what distinguishes them; the first ones, if they are equal."""
        effects, found, count = self._index.get(id(fact), (None, {}, 0))
        if effects is not fact.effects or count > len(effects):
            found, count = {}, 0
        for each in fact.effects[count:]:
            found.setdefault((each.do, each.at, each.what, each.path, id(each.entity)), each)
        self._index[id(fact)] = fact.effects, found, len(fact.effects)
        return found

    def next_order(self) -> int:
        """Return the next position in the start of the program; 0 outside of it."""
        if self.activity.fact.kind not in STARTING:
            return 0
        self._order += 1
        return self._order

    def later(
        self, function: Value, kind: str, node: NodeFact | None, args: list[Value], key: object
    ) -> CallbackFact:
        """Schedule a callback for reading; return its fact."""
        name, at, is_async = self.described(function)
        fact = CallbackFact(name, kind, at or Place("", 0), is_async=is_async)
        callback = Callback(function, fact, node, args)
        callback.parent = self.reading
        widen(callback, MOST_AGAIN)
        known = self.callbacks.setdefault((kind, key, *callback_key(callback.function)), callback)
        if known is callback and len(self.callbacks) > MOST_CALLBACKS:
            raise TooLong
        if node is not None and known.fact not in node.callbacks:
            node.callbacks.append(known.fact)
        if at is None:
            known.fact.is_open = True
            self.attributes.may_call(function)
        return known.fact

    def described(self, function: Value) -> tuple[str, Place | None, bool]:
        """Return the name of a callback, where it begins, and whether it is asynchronous."""
        raise NotImplementedError

    # --------------------------------------------------------------------------- what the other halves can do

    def evaluate(self, node: ast.expr, frame: Frame) -> Value:
        """Return the value of an expression."""
        raise NotImplementedError

    def fixed(self, expr: ast.expr, frame: Frame) -> Known | None:
        """Return the truth value, whole number or constant of an interface that an expression names."""
        raise NotImplementedError

    def execute(self, body: list[ast.stmt], frame: Frame) -> set[str]:
        """Run statements; return how they may end."""
        raise NotImplementedError

    def call(
        self, function: Value, args: list[Value], keys: dict[str, Value], node: ast.AST, frame: Frame
    ) -> Value:
        """Call a value."""
        raise NotImplementedError

    def result_of(self, future: Future) -> Value:
        """Return the result of a future."""
        raise NotImplementedError

    def turns(self, value: Value) -> tuple[list[Value], bool]:
        """Return what a loop over a value goes through, and whether that is exactly known."""
        raise NotImplementedError

    def drawn(self, value: Value, node: ast.AST, frame: Frame) -> Value:
        """Return what a value gives one after the other: a generator runs now."""
        raise NotImplementedError

    def special(
        self, value: Value, name: str, args: list[Value], node: ast.AST, frame: Frame
    ) -> Value | None:
        """Call a method that Python calls without a name; None: no class of the program has it."""
        raise NotImplementedError

    def hashed(self, key: Value, node: ast.AST, frame: Frame) -> None:
        """Call the method that gives the hash of an object, which a set or a dictionary asks for."""
        raise NotImplementedError

    def module_frame(self, module: Module, *, is_script: bool = False) -> Frame:
        """Return the variables of a module, which runs on first use."""
        raise NotImplementedError

    def attribute(self, value: Value, name: str, text: str, node: ast.AST, frame: Frame) -> Value:
        """Return an attribute of a value."""
        raise NotImplementedError

    def plain_attribute(self, value: Object, name: str, text: str, node: ast.AST, frame: Frame) -> Value:
        """Return an attribute of an object, without its own ``__getattribute__``."""
        raise NotImplementedError

    def set_attribute(self, holder: Value, name: str, value: Value, node: ast.AST, frame: Frame) -> None:
        """Set an attribute, as ``setattr`` does."""
        raise NotImplementedError

    def element(self, value: Value, key: Value, text: str) -> Value:
        """Return an element of a collection."""
        raise NotImplementedError

    def shown(self, value: Value, node: ast.AST, frame: Frame, *first: str) -> Value:
        """Return the text of an object whose class makes it, or else the value."""
        raise NotImplementedError

    def imported(self, name: str, frame: Frame) -> Value | None:
        """Return a module of the folder by its dotted name; None: it is not in the folder."""
        raise NotImplementedError

    def new_class(self, args: list[Value], node: ast.AST, frame: Frame) -> Value:
        """Return the class of a call ``type(name, bases, names)``."""
        raise NotImplementedError

    def look_up(self, cls: Class, name: str, after: Class | None = None) -> Value | None:
        """Look up a name in a class and its bases; after a given class, if there is one."""
        order = cls.inside
        if after is not None and after in order:
            order = order[order.index(after) + 1 :]
        for each in order:
            if name in each.names:
                return each.names[name]
        return None
