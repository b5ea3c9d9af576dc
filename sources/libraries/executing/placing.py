"""Determines which executor has a node, and with how many threads."""

from __future__ import annotations

import ast

from dineros.sources.facts import (
    MAY_TAKE_AWAY,
    TAKES_AWAY,
    Effect,
    NodeFact,
    is_open,
)
from dineros.sources.language.machine import EVENT
from dineros.sources.language.values import (
    Frame,
    Made,
    Object,
    Open,
    Value,
    constant,
    is_none,
    join,
    options,
    text_of,
)
from dineros.sources.libraries.doing import Doer
from dineros.sources.libraries.executing.late import Late
from dineros.sources.places import Place


class Places:
    """Knows which executor has a node, and which spins take it away.

    `doer`: records effects.
    """

    def __init__(self, doer: Doer) -> None:
        self.doer = doer
        self.machine = doer.machine
        self.shared = Made("rclpy.executors.SingleThreadedExecutor", [], {}, _NOWHERE)
        """The executor of rclpy's functions."""
        self.started: set[int] = set()
        """Ids of the executors that spin."""
        self.background: set[int] = set()
        """Ids of those that spin in threads of their own."""
        self.orders: dict[int, int] = {}
        """By id of a node or of a thread where it is added, or begins, in the start of the program."""
        self.is_target = False
        """Whether what is called is the function of a thread itself."""
        self.late = Late(self.machine)
        self._of: dict[int, Made] = {}
        self._pools: dict[int, int] = {}
        self._kept: list[Made] = []
        self._spun: list[NodeFact] = []
        self._members: dict[int, Made] = {}
        """By id of a node what has its place as an attribute: an executor, or a spin that took it away."""
        self._of_threads: list[tuple[list[Made], Effect]] = []

    def of(self, fact: NodeFact | None) -> Value | None:
        """Return the executor of a node."""
        found = self._of.get(id(fact))
        return found if found is not None else Open("executor")

    def facts_of(self, value: Value | None) -> list[NodeFact]:
        """Return the nodes that a value may be."""
        found = []
        for each in options(value):
            fact = self.doer.maker.used_as_node(each)
            if fact is not None and fact not in found:
                found.append(fact)
        return found

    def is_outer(self) -> bool:
        """Return whether no executor calls the spinning code."""
        return self.machine.activity.fact.kind in ("main", "thread", "module", EVENT)

    def is_of(self, executor: Made, fact: NodeFact | None) -> bool:
        """Return whether a node is, or may be, one of those that an executor runs."""
        return fact is None or fact in executor.nodes or self._of.get(id(fact)) is executor

    def put(self, fact: NodeFact, where: Value) -> None:
        """Record that an executor has a node from now on; None: it has left its executor."""
        if isinstance(where, Made) and where.path != TAKEN:
            self._of[id(fact)] = where
        member = self._members.setdefault(id(fact), Made("", [], {}, _NOWHERE))
        self.machine.write_slot(member, "where", where)
        self.orders[id(fact)] = self.machine.next_order()

    def _where(self, fact: NodeFact) -> list[Value]:
        slot = self._members[id(fact)].slots.get("where") if id(fact) in self._members else None
        return options(slot.current) if slot is not None else []

    def take(
        self, fact: NodeFact, executor: Made, name: str, call: Made, node: ast.AST, frame: Frame
    ) -> None:
        """Let a function of rclpy take a node out of its executor: it does not put it back.

        With an executor that has the node, ``spin_once`` and ``spin_until_future_complete`` leave it there,
        in rclpy since July 2024. A thread whose function is ``rclpy.spin`` runs the node as long as it lives.
        """
        activity = self.machine.activity
        is_thread = activity.fact.kind == "thread" or self.is_target
        places = self._where(fact)
        before = [each for each in places if isinstance(each, Made) and each.path != TAKEN]
        if not before or (name == "spin" and is_thread) or (name != "spin" and before == [executor]):
            return
        effect = self.doer.record_spin(name, call, node, frame, "rclpy")
        taken = Made(TAKEN, [join(before)], {}, call.at)
        taken.effect = effect
        taken.level = int(bool(activity.loops) and activity.loops == activity.conditional)
        if name != "spin":
            around = self.started if is_thread else self.background
            is_after = not is_thread or self.orders[id(fact)] <= self.orders.get(id(activity.fact), 0)
            is_lost = any(id(each) in around for each in before)
            self._lose(effect, is_lost, is_certain=len(places) == 1 and is_after)
        if is_thread:  # it is read repeatedly, after the main function
            self._of_threads.append((before, effect))
        else:
            self.put(fact, taken)

    def _lose(self, effect: Effect | None, is_lost: bool, *, is_certain: bool) -> None:
        """Record that a spin takes a node away from an executor that runs, or runs later."""
        if is_lost and effect is not None:
            words = TAKES_AWAY if is_certain else MAY_TAKE_AWAY
            effect.how = effect.how.replace("rclpy,", f"rclpy, {words},", 1) if "," in effect.how else words

    def miss(self, executor: Made) -> None:
        """Record which nodes an executor that begins to spin has no longer."""
        for fact in executor.nodes:
            places = self._where(fact)
            for each in places:
                if isinstance(each, Made) and each.path == TAKEN and executor in options(each.args[0]):
                    self._lose(each.effect, True, is_certain=len(places) == 1 or bool(each.level))
        for before, effect in self._of_threads:
            self._lose(effect, executor in before, is_certain=len(before) == 1)

    def run(self, fact: NodeFact, executor: Made, how: str, made: Made, *, is_late: bool = False) -> None:
        """Record that an executor runs the callbacks of a node, from a place in the code.

        If it is late, it does so after another spin, which may have no end.
        """
        if is_late and fact.threads == "not spun":
            self.late.add(fact)
        elif not is_late:
            self.late.remove(fact)
        threads = threads_of(executor)
        kind = executor.path.rpartition(".")[2]
        if fact.threads == "not spun" or how == "rclpy.spin" or executor is not self.shared:
            fact.threads = threads
            words = how if executor is self.shared else f"{kind}, {how}"
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


def executor_of(value: Value | None) -> Made | None:
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
TAKEN = "taken"
"""Path of a value that stands for a spin that took a node out of an executor."""
