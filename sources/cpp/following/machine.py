"""The state of the interpreter of C++: frames, certainty, callbacks that remain to be read."""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

from dineros.sources.branches import Do
from dineros.sources.cpp.entries import ClassInfo
from dineros.sources.cpp.following.answers import FunctionText
from dineros.sources.cpp.following.endings.polling import Polled, value_in_words
from dineros.sources.cpp.following.ways import Ways
from dineros.sources.cpp.index import Index
from dineros.sources.cpp.parsing import arguments_of, line_of, path_of, text_of
from dineros.sources.cpp.reaching.reach import Reach
from dineros.sources.cpp.reaching.reached import Reached
from dineros.sources.cpp.tables.boost import standard
from dineros.sources.cpp.values import Const, Either, Frame, Made, Obj, Todo, Value, joined, one_of
from dineros.sources.facts import CallbackFact, Effect, Entity, NodeFact
from dineros.sources.libraries.idioms import Idiom
from dineros.sources.places import Place

if TYPE_CHECKING:
    from tree_sitter import Node

MOST_STEPS = 400_000
"""Limit of the expressions and statements that are followed for one program."""
_LONG = 20_000
"""Steps after which code that costs much and has done nothing so far is not followed again."""
_MUCH = 100
"""Steps of code that costs much."""
_TRIES = 3
"""How often such code is followed before it is known to do nothing."""
MOST_CALLS = 40
"""Limit of the depth of calls that are followed."""
_COUNTED = ("publish", "call", "send_goal")
"""Effects that fill a queue: a callback may have one several times, through calls of one routine."""
_Led = tuple[str, tuple[tuple[int, ...], ...], tuple[int, ...], tuple[tuple[int, int], ...]]
"""How code led to an effect: when, and by which calls, iterations and branches."""
_MOST_TIMES = 4
"""Limit of how often one line counts; beyond, it is any number of times."""

MANAGER = "rclcpp_components::ComponentManager"
"""The node of containers of components; its first argument is an executor."""
NODES = {
    *("rclcpp::Node", "rclcpp_lifecycle::LifecycleNode", "nav2_util::LifecycleNode"),
    *("nav2::LifecycleNode", "rclcpp::node::Node", "LifecycleNode", MANAGER),
}
"""Classes of libraries that are nodes."""
CONTROLLERS = {
    f"controller_interface::{name}"
    for name in ("ControllerInterface", "ChainableControllerInterface", "ControllerInterfaceBase")
}
"""Base classes of controllers of ros2_control, which have a managed node: ``get_node()``."""
_WHOLE = re.compile(r"^(?:std::)?(?:unsigned|signed|int|long|short|u?int\d+_t|size_t|char)\b")
_FLOAT = re.compile(r"^(?:double|float|long double)$")


class TooLong(Exception):  # noqa: N818 - not an error
    """A program is too large to be followed completely."""


class Machine(Ways):
    """The state of a program that is being followed.

    Parameters
    ----------
    index : Index
        What the folder defines.
    program : str
        Name of what is started.
    idioms : mapping of str to Idiom
        The table of libraries.
    reach : Reach, optional
        Of the index; programs of one folder share it.
    reached : Reached, optional
        Their common record of what they have reached so far.
    """

    def __init__(
        self,
        index: Index,
        program: str,
        idioms: Mapping[str, Idiom],
        reach: Reach | None = None,
        reached: Reached | None = None,
    ) -> None:
        super().__init__()
        self.index = index
        self.program = program
        self.idioms = idioms
        self.given: Mapping[str, Any] = {}
        self.is_launched = False
        self.nodes: list[NodeFact] = []
        self.todo: list[Todo] = []
        self.made: dict[tuple[object, ...], Obj] = {}
        self.globals: dict[str, Value] = {}
        """The values of global variables and static members that code has set, by full name."""
        self.statics: dict[object, Value] = {}
        """Locks, signals and objects that the whole program shares: of global variables and static members by
        full name, of static variables of routines by declaration."""
        self.fact = CallbackFact("main", "main", Place("", 1))
        self.role = "main"
        self.loops = 0
        self.calls: list[tuple[int, ...]] = []
        self.turns: list[int] = []
        self.sites: list[tuple[str, Node, Frame | None, Frame]] = []
        """Of routines that run: name, the call, the frame of the caller, the own frame."""
        self.holders: dict[int, tuple[int, bool]] = {}
        """The object whose code made an entity, and whether a pointer of it holds only that, by id."""
        self.holding: list[str] = []
        self.scoped: list[Value] = []
        """The objects that end with the current block."""
        self.ways_out: list[bool] = []
        """For each enclosing loop: whether it may end although its condition is not met."""
        self.assigned: dict[int, tuple[frozenset[str], bool]] = {}
        """Of loops, by id: the variables that they assign, and whether they may end early."""
        self.asked: set[str] = set()
        """Futures that were tested for readiness."""
        self.owner: Obj | None = None
        self.entity: Entity | None = None
        self.unread: list[str] = []
        self._texts: dict[int, FunctionText] = {}
        self.steps = 0
        self.most_steps = MOST_STEPS
        self._led: dict[
            int, tuple[str, tuple[object, ...], tuple[int, ...], tuple[tuple[int, int], ...], int]
        ] = {}
        """Of effects, by id: when, the calls, iterations and branches that led to it first, and its start."""
        self.happened = 0
        self._order = 0
        self._stored: list[str] = []
        self.changed: dict[str, dict[int, tuple[CallbackFact, set[str]]]] = {}
        """The callbacks that change a member, with the values that they give it, by its name."""
        self.polled: dict[str, set[Polled]] = {}
        self.slept: dict[int, Effect] = {}
        """What loops wait for, by the name of the member."""
        self.writes: dict[int, set[str]] = {}
        """The members that code has set, by id of its node."""
        self.skipped: dict[int, bool] = {}
        """Of code that was not followed again, by id of its node: whether it may make ports."""
        self.followed: set[int] = set()
        """Routines that ran, by id of their nodes."""
        self.extending: list[Obj] = []
        """Objects whose class extends a class that is not in the folder."""
        self._idle: dict[int, int] = {}
        """Of code that has done nothing so far, by id of its node: how often it was followed."""
        self.reach = reach if reach is not None else Reach(index, idioms)
        self.reached = reached if reached is not None else Reached()
        self._places: dict[tuple[int, str, str], Entity] = {}
        self._facts: dict[tuple[int, str, int, str], CallbackFact] = {}

    def count(self) -> None:
        """Count a step.

        Raises
        ------
        TooLong
            There were too many.
        """
        self.steps += 1
        if self.steps > self.most_steps:
            raise TooLong

    def happens(self) -> None:
        """Record that the current code does something that a model represents."""
        self.happened += 1

    @contextmanager
    def observed(self, code: Node) -> Iterator[None]:
        """Follow a routine or a constructor, and record whether it does something."""
        steps, before, first = self.steps, self.happened, len(self._stored)
        yield
        self.writes.setdefault(code.id, set()).update(self._stored[first:])
        if self.happened != before:
            self._idle[code.id] = -MOST_STEPS
        elif self.steps - steps >= _MUCH:
            self._idle[code.id] = self._idle.get(code.id, 0) + 1

    def is_idle(self, code: Node) -> bool:
        """Return whether a long program need not follow code again, as it cost much and did nothing."""
        is_idle = self.steps >= _LONG and self._idle.get(code.id, 0) >= _TRIES
        if is_idle and code.id not in self.skipped:
            self.skipped[code.id] = self.reach.may_make_ports(code)
        return is_idle

    @property
    def when(self) -> str:
        """Certainty that the current code is executed."""
        if self.loops:
            return "in a loop"
        return "conditional" if self.cond or any(each.has_left for each in self.frames) else "always"

    def place(self, node: Node, frame: Frame) -> Place:
        """Return the line of a node."""
        return Place(frame.path, line_of(node))

    # ---------------------------------------------------------------------------------------------- effects

    def does(
        self,
        do: str,
        what: str,
        node: Node,
        frame: Frame,
        how: str = "",
        entity: Entity | None = None,
        timeout: float | None = None,
    ) -> Effect:
        """Add an effect to the current callback."""
        effect = Effect(do, what, self.place(node, frame), self.when, how, entity, timeout=timeout)
        effect.holding = tuple(self.holding)
        same = [each for each in self.fact.effects if self._is_same(each, effect)]
        for each in same:
            if do not in _COUNTED or not self._is_again(each, node):
                self.block.append(Do(each))
                return each
        if len(same) >= _MOST_TIMES:
            same[-1].when = "in a loop"
            self.block.append(Do(same[-1]))
            return same[-1]
        effect.order = self.next_order()
        led = (effect.when, tuple(self.calls), tuple(self.turns), tuple(self.branching), node.start_byte)
        self._led[id(effect)] = led
        self.happens()
        self.fact.effects.append(effect)
        self.block.append(Do(effect))
        return effect

    def _is_same(self, one: Effect, other: Effect) -> bool:
        """Return whether two effects are one, unless code does it again; one line may have two locks."""
        if (one.do, one.at, one.entity) != (other.do, other.at, other.entity):
            return False
        if one.do == "lock" and one.how != other.how:
            return False
        when = self._led[id(one)][0] if id(one) in self._led else one.when
        return when == other.when and (other.entity is not None or one.what == other.what)

    def _is_again(self, effect: Effect, node: Node) -> bool:
        """Return whether code does an effect again: another call, or part of a line, but no other branch."""
        _, calls, turns, branching, start = self._led.get(id(effect), ("", (), (), (), node.start_byte))
        others = dict(branching)
        if any(others.get(at, side) != side for at, side in self.branching):
            return False
        return (calls, turns, start) != (tuple(self.calls), tuple(self.turns), node.start_byte)

    def next_order(self) -> int:
        """Return the next position in the start of the program; 0 outside of it."""
        if self.role not in ("main", "constructor"):
            return 0
        self._order += 1
        return self._order

    def entity_of(self, kind: str, port: str, node: Node, frame: Frame, owner: Obj) -> Entity:
        """Return the entity that an expression creates; the same one if it is read twice."""
        place = self.place(node, frame)
        key = (
            id(owner.node),
            kind,
            f"{place}:{node.start_point[1]}:{port}:{len(self.calls)}:{self.calls!r}:{self.turns!r}",
        )
        found = self._places.get(key)
        if found is None:
            self.happens()
            found = self._places[key] = Entity(kind, port, place, is_enabled=not self.off)
            if self.loops:
                found.details["instances"] = "open: made in a loop"
            elif self.cond:
                found.details["conditional"] = "made under a condition"
            if owner.node is not None:
                found.order = self.next_order()
                owner.node.entities.append(found)
        return found

    def callback(
        self, name: str, kind: str, place: Place, target: Value, owner: Obj, entity: Entity | None = None
    ) -> CallbackFact:
        """Return the fact of a callback, whose code is read later."""
        key = (id(owner.node), str(place), id(entity) if kind != "done callback" else 0, kind)
        found = self._facts.get(key)
        if found is None:
            self.happens()
            found = self._facts[key] = CallbackFact(name, kind, place)
            self.todo.append(Todo(found, target, owner, entity))
            if owner.node is not None:
                owner.node.callbacks.append(found)
        else:  # read again, it has the variables of this time
            for each in self.todo:
                each.target = target if each.fact is found else each.target
        return found

    # ------------------------------------------------------------------------------------------------ types

    def type_text(self, node: Node | None, frame: Frame, depth: int = 0) -> str:
        """Return a type with its aliases and parameters of templates followed: ``std_msgs::msg::String``."""
        return self.type_text_of(path_of(node), frame, depth)

    def type_text_of(self, path: str, frame: Frame, depth: int = 0) -> str:
        """Return a type by its name, with its aliases and parameters of templates followed."""
        first, _, rest = path.partition("::")
        around: Frame | None = frame
        while around is not None:
            known = around.types.get(first)
            if known is None and around.this is not None:
                known = around.this.types.get(first)
            if known:
                path = f"{known}::{rest}" if rest else known
                break
            around = around.outer
        path = self.index.unaliased(path, frame.path)
        first, _, rest = path.partition("::")
        if depth < 8:
            space = frame.cls.full if frame.cls else frame.space
            alias = self.index.find_alias(path, frame.path, space)
            if alias is not None and path_of(alias) != path:
                return self.type_text(alias, frame, depth + 1)
            if rest:  # an alias of a class: using Service = ...; Service::Request
                alias = self.index.find_alias(first, frame.path, space)
                if alias is not None and path_of(alias) != first:
                    return f"{self.type_text(alias, frame, depth + 1)}::{rest}"
        return standard(path)

    def templated(self, node: Node | None, frame: Frame) -> list[Node]:
        """Return the arguments of a template in a name, or in the type that it is an alias of."""
        for _ in range(8):
            found = arguments_of(node)
            if found or node is None:
                return found
            space = frame.cls.full if frame.cls else frame.space
            node = self.index.find_alias(path_of(node), frame.path, space)
        return []

    def template_text(self, node: Node | None, frame: Frame) -> str:
        """Return the text of a type, including the element type of a pointer or a list."""
        inner = [self.template_text(each, frame) for each in arguments_of(node)]
        return self.type_text(node, frame) + (f"<{', '.join(inner)}>" if inner else "")

    def class_of(self, name: str, frame: Frame) -> ClassInfo | None:
        """Return the class of the folder that a name means."""
        return self.index.find_class(name, frame.path, frame.cls.full if frame.cls else frame.space)

    def node_kind(self, cls: ClassInfo, depth: int = 0) -> str | None:
        """Return the class of a library by which a class is a node; None: it is not a node."""
        frame = Frame(cls.path, cls.space, cls=cls)
        for base in cls.bases:
            name = self.type_text(base, frame)
            if is_node(name):
                return name
            inner = self.class_of(name, frame)
            if inner is not None and inner is not cls and depth < 20:
                found = self.node_kind(inner, depth + 1)
                if found:
                    return found
        return None

    def bases(self, cls: ClassInfo) -> list[ClassInfo]:
        """Return a class and those of the folder that it extends, nearest first."""
        found: list[ClassInfo] = []
        todo = [cls]
        while todo and len(found) < 50:
            each = todo.pop(0)
            if each in found:
                continue
            found.append(each)
            frame = Frame(each.path, each.space, cls=each)
            inner = [self.class_of(self.type_text(base, frame), frame) for base in each.bases]
            todo += [base for base in inner if base is not None]
        return found

    # -------------------------------------------------------------------------------------------- variables

    def lookup(self, name: str, frame: Frame) -> Value | None:
        """Return the variable, member or constant of a name."""
        around: Frame | None = frame
        while around is not None:
            if name in around.values:
                return around.values[name]
            around = around.outer
        if frame.this is not None and name in frame.this.fields:
            return frame.this.fields[name]
        return self.globals.get(self.find_global(name, frame) or "") if self.globals else None

    def find_global(self, name: str, frame: Frame) -> str | None:
        """Return the full name of the global variable that a name means, if no member has this name."""
        this = frame.this
        kinds = self.bases(this.cls) if this is not None and this.cls is not None else []
        if (this is not None and name in this.fields) or any(name in each.fields for each in kinds):
            return None
        return self.index.find_variable(name, frame.path, frame.cls.full if frame.cls else frame.space)

    def store(self, name: str, value: Value, frame: Frame) -> None:
        """Set a variable or member, certainly or possibly."""
        around: Frame | None = frame
        while around is not None:
            if name in around.values:
                self.set_in(around.values, name, value, is_local=around is frame)
                return
            around = around.outer
        full = self.find_global(name, frame)
        if full is not None:
            self.note_change(name, value_in_words(value))
            if self.role in ("main", "constructor"):
                self.set_in(self.globals, full, value)
            else:
                self.globals[full] = joined(self.globals.get(full), value)
        elif frame.this is not None:
            self.store_field(frame.this, name, value)

    def store_field(self, this: Obj, name: str, value: Value) -> None:
        """Give a member of an object a value."""
        self._stored.append(name)
        self.note_change(name, value_in_words(value))
        for cls in self.bases(this.cls) if this.cls is not None else ():
            if name in cls.fields:
                kind = cls.fields[name][0]
                value = coerced(text_of(kind), value)
        is_certain = self.role in ("main", "constructor") and len(self.calls) < MOST_CALLS
        old = this.fields.get(name)
        if is_certain:
            self.set_in(this.fields, name, value)
        else:
            this.fields[name] = joined(old, value)

    def note_change(self, name: str, value: str) -> None:
        """Record that a callback or the main function changes a member; constructors do not count."""
        is_in_constructor = any(cls and not at for cls, at, *_ in self.calls)
        if self.role != "constructor" and not (self.role == "main" and is_in_constructor):
            self.changed.setdefault(name, {}).setdefault(id(self.fact), (self.fact, set()))[1].add(value)

    def set_member(self, on: Made, name: str, value: Value) -> None:
        """Set a member of an object of a library."""
        self.set_in(on.fields, name, value)


def is_node(name: str) -> bool:
    """Return whether a class of a library is a node."""
    return name in NODES or name in CONTROLLERS or name.endswith(("LifecycleNode", "rclcpp::Node"))


def coerced(kind: str, value: Value) -> Value:
    """Return a value converted to a type: integers and floating-point numbers differ in ``1 / rate``."""
    if isinstance(value, Either):
        return one_of([coerced(kind, each) for each in value.options])
    if isinstance(value, Const) and isinstance(value.value, (int, float)):
        if isinstance(value.value, bool):
            return value
        if _FLOAT.match(kind.strip()):
            return Const(float(value.value))
        if _WHOLE.match(kind.strip()) and abs(value.value) < 1e18:
            return Const(int(value.value))
    return value
