"""Interprets calls of executors in C++: what they get, and what spins where."""

from __future__ import annotations

from dineros.sources.cpp.calling.ports import Ports
from dineros.sources.cpp.following.calls import Call
from dineros.sources.cpp.following.statements import Statements
from dineros.sources.cpp.interpreting.groups import ADDED, LATE, join, runs_in_turn, take_group
from dineros.sources.cpp.parsing import on_text, text_of
from dineros.sources.cpp.values import Const, Items, Made, Obj, Port, Value, constant, options
from dineros.sources.facts import CallbackFact


class Spinning(Ports):
    """Interprets calls of executors.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Statements) -> None:
        super().__init__(machine)
        self._pools = 0
        self._first_spin: tuple[CallbackFact, int] | None = None
        """The main function, and where it certainly spins first."""

    def executor(self, call: Call, on: Made) -> Value | None:
        """Call a method of an executor; None: it is not one of those that are followed."""
        last = call.last
        if last in ("add_node", "add_callback_group"):
            self._names_vendor(call)
            nodes = [each for each in call.args if isinstance(each, Obj)]
            if last == "add_callback_group":
                group = call.args[0] if call.args else None
                take_group(group, self.machine.nodes, on_text(call.node))
            held = on.fields.setdefault("nodes", Items())
            if isinstance(held, Items) and last == "add_node":
                held.values += nodes
                join(nodes, on_text(call.node))
            elif isinstance(held, Items):
                held.values += [each for each in options(call.args[0]) if isinstance(each, Port)]
            return Const(None)
        if last in ("spin", "spin_some", "spin_once", "spin_all"):
            kept = on.fields.get("nodes")
            nodes = [each for each in kept.values if isinstance(each, Obj)] if isinstance(kept, Items) else []
            name, threads = on.path.rpartition("::")[2], self._threads(on)
            if isinstance(kept, Items) and self.machine.role in ("main", "thread"):
                said = on_text(call.node) or text_of(next(iter(call.nodes), None))
                self._spin_groups(said, kept, threads)
            elif isinstance(kept, Items):
                runs_in_turn(kept)
                if kept.values and not nodes:  # it has only groups, which no other executor runs
                    return Const(None)
            return self.spin(call, nodes, name, threads)
        if last == "spin_until_future_complete":
            kept = on.fields.get("nodes")
            if isinstance(kept, Items):
                runs_in_turn(kept)
            if self.machine.role == "main":
                self.executor(Call(call.node, call.frame, "spin", [], on), on)
            return self._await(call, call.args[0] if call.args else None, call.args[1:], "spin-until")
        return None

    def spin(self, call: Call, nodes: list[Obj], executor: str, threads: int | str) -> Value:
        """Spin nodes: in the main function or a thread, they have this executor from now on."""
        if self.machine.role not in ("main", "thread"):
            self.machine.does("spin", "the node", call.node, call.frame, how="without end")
            return Const(None)
        self._pools += 1
        order = self.machine.next_order()
        is_late = self._is_late(call)
        for each in nodes:
            if each.node is not None:
                is_first = not each.node.executor or each.node.executor.startswith(ADDED)
                each.node.spun = order if is_first or not order else each.node.spun
                each.node.executor = LATE + executor if is_late and is_first else executor
                each.node.threads = threads
                each.node.pool = self._pools if len(nodes) > 1 else 0
        return Const(None)

    def _is_late(self, call: Call) -> bool:
        """Return whether a spin of the main function comes after another one, which has no end."""
        machine = self.machine
        if machine.role != "main" or call.last != "spin":
            return False
        if self._first_spin is not None and self._first_spin[0] is machine.fact:
            return self._first_spin[1] != call.node.start_byte
        if not (machine.cond or machine.loops or machine.off):
            self._first_spin = machine.fact, call.node.start_byte
        return False

    def spin_in_thread(self, call: Call) -> Value:
        """Spin a node or an executor in a thread of its own, as ``NodeThread`` of `nav2_util` does."""
        on, role = call.args[0], self.machine.role
        self.machine.role = "thread"
        if isinstance(on, Made) and "xecutor" in on.path:
            self.executor(Call(call.node, call.frame, "spin", [], on), on)
        else:
            nodes = [each for each in options(on) if isinstance(each, Obj)]
            self.spin(call, nodes, "SingleThreadedExecutor", 1)
        self.machine.role = role
        return Made(call.path, call.args, node=call.node)

    def _spin_groups(self, executor: str, kept: Items, threads: int | str) -> None:
        """Give callback groups the executor that runs only them, and not their node."""
        for each in kept.values:
            if isinstance(each, Port) and each.owner.node is not None and each.owner not in kept.values:
                each.entity.details["executor"] = executor
                each.owner.node.apart[executor] = threads if isinstance(threads, int) else 1

    def _names_vendor(self, call: Call) -> None:
        """Note a node whose class, or the base of it, is not in the folder."""
        text = text_of(call.nodes[0]) if call.nodes else ""
        is_item = "[" in text or ".at(" in text  # of a container of nodes, which were created elsewhere
        is_asked = bool(call.args) and call.last != "add_callback_group" and not is_item
        for each in options(call.args[0] if is_asked else None):
            name = each.path if isinstance(each, Made) and each.effect is None else ""
            if isinstance(each, Obj) and each.node is None and each.cls is not None:
                name = each.cls.full
            if name and not name.startswith(("std::", "rclcpp::")):
                self.machine.unread.append(
                    f"{self.machine.place(call.node, call.frame)}: {name} is spun as a node, but its code or "
                    "that of its base class is not in the folder, so its ports are unknown"
                )

    def _threads(self, on: Made) -> int | str:
        if "Multi" not in on.path:
            return 1 if "Single" in on.path or "Events" in on.path else "open"
        count = constant(on.args[1]) if len(on.args) > 1 else 0
        if isinstance(count, int):
            return count or "processors"
        return "open"
