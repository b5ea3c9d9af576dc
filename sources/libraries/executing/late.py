"""Finds nodes that spin only after another spin of the main function, which nothing ends."""

from __future__ import annotations

import ast
from collections.abc import Collection, Iterable
from dataclasses import dataclass

from dineros.sources.facts import UNSPUN, CallbackFact, NodeFact
from dineros.sources.language.machine import Machine
from dineros.sources.language.values import Function

_INTERRUPTS = ("KeyboardInterrupt", "ExternalShutdownException")
"""After these the context is shut down: a later spin returns at once."""
_STOPS = ("shutdown", "try_shutdown")
_SIGNALS = ("signal", "sigaction", "add_signal_handler", "interrupt_main", "kill", "raise_signal")
_ASSIGNS = (ast.Assign, ast.AnnAssign, ast.AugAssign, ast.NamedExpr, ast.For, ast.AsyncFor)
"""Statements and expressions that give a variable a value."""
_FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef, ast.Lambda)


@dataclass(frozen=True)
class _Spin:
    """A spin of the main function: its callback, its call, and the functions around the call."""

    fact: CallbackFact
    call: ast.AST
    inside: tuple[Function, ...]


class Late:
    """Knows which nodes spin only after another spin.

    `machine`: the interpreter.
    """

    def __init__(self, machine: Machine) -> None:
        self._machine = machine
        self._first: _Spin | None = None
        self._spins: list[_Spin] = []
        self._nodes: dict[NodeFact, None] = {}

    def is_late(self, name: str, call: ast.AST) -> bool:
        """Return whether a call that spins comes after another one that has no end."""
        machine, activity = self._machine, self._machine.activity
        if name != "spin" or activity.fact.kind != "main":
            return False
        spin = _Spin(activity.fact, call, tuple(machine.calls))
        if self._first is None:
            if not (activity.conditional or activity.loops or activity.disabled):
                self._first = spin
            return False
        if self._first.fact is not spin.fact or self._first.call is call:
            return False
        self._spins.append(spin)
        return True

    def add(self, fact: NodeFact) -> None:
        """Note a node that no earlier call spins."""
        self._nodes[fact] = None

    def remove(self, fact: NodeFact) -> None:
        """Note that other code spins a node."""
        self._nodes.pop(fact, None)

    def finish(self) -> None:
        """Take the nodes that never spin out of their executors, at the end of the program."""
        if self._first is None or not self._nodes or self._may_end(self._first):
            return
        for fact in self._nodes:
            fact.executor, fact.threads, fact.spun, fact.pool = UNSPUN, "not spun", 0, 0

    def _may_end(self, first: _Spin) -> bool:
        """Return whether code may end the first spin and continue."""
        machine = self._machine
        modules = [module for path in machine.frames if (module := machine.modules.module(path)) is not None]
        others = _other_objects(module.tree for module in modules)
        around = {function.node for spin in (first, *self._spins) for function in spin.inside}
        has_init = False
        for module in modules:
            for each in _calls(module.tree.body, around):
                if _name(each) in _SIGNALS or (_name(each) in _STOPS and _holder(each) not in others):
                    return True
        for node in around:
            inits = [each for each in ast.walk(node) if isinstance(each, ast.Call) and _name(each) == "init"]
            has_init |= len(inits) > 1
            if any(isinstance(each, ast.Call) and _name(each) in _SIGNALS for each in ast.walk(node)):
                return True
        later = {id(spin.call) for spin in self._spins}
        inner = first.inside[-1].node if first.inside else None
        for node in around:
            for part in ast.walk(node):
                body = _caught(part, has_init)
                held = {id(each) for statement in body for each in ast.walk(statement)}
                if held and (node is not inner or (id(first.call) in held and not held & later)):
                    return True
        return False


def _other_objects(trees: Iterable[ast.Module]) -> set[str]:
    """Return the variables and attributes that hold objects of other classes than executors and contexts."""
    values: dict[str, list[ast.expr | None]] = {}
    classes: set[str] = set()
    for part in (each for tree in trees for each in ast.walk(tree)):
        if isinstance(part, ast.ClassDef) and not any("Executor" in ast.unparse(each) for each in part.bases):
            classes.add(part.name)
        if not isinstance(part, _ASSIGNS):
            continue
        for target in part.targets if isinstance(part, ast.Assign) else [part.target]:
            names = (each for each in ast.walk(target) if isinstance(each, (ast.Name, ast.Attribute)))
            for name in names:
                values.setdefault(_last(name), []).append(getattr(part, "value", None))
    return {
        name
        for name, given in values.items()
        if given and all(isinstance(each, ast.Call) and _name(each) in classes for each in given)
    }


def _holder(call: ast.Call) -> str:
    """Return the variable or attribute whose method a call calls; empty: none, or something else."""
    return _last(call.func.value) if isinstance(call.func, ast.Attribute) else ""


def _last(node: ast.expr) -> str:
    return node.attr if isinstance(node, ast.Attribute) else getattr(node, "id", "")


def _calls(body: Iterable[ast.AST], around: Collection[ast.AST]) -> Iterable[ast.Call]:
    """Yield the calls in functions and classes of a module, without the functions around the spins."""
    for each in body:
        if isinstance(each, (ast.FunctionDef, ast.AsyncFunctionDef, ast.ClassDef)) and each not in around:
            yield from (part for part in ast.walk(each) if isinstance(part, ast.Call))
        elif each in around:
            inner = (part for part in ast.walk(each) if part is not each and isinstance(part, _FUNCTIONS))
            yield from (part for one in inner for part in ast.walk(one) if isinstance(part, ast.Call))


def _caught(part: ast.AST, has_init: bool) -> list[ast.stmt]:
    """Return the statements whose exceptions do not leave a ``try`` or a ``with suppress(...)``."""
    if isinstance(part, ast.With) and any("suppress" in ast.unparse(each) for each in part.items):
        return part.body
    if not isinstance(part, (ast.Try, ast.TryStar)):
        return []
    return part.body if any(has_init or not _interrupts(each) for each in part.handlers) else []


def _interrupts(handler: ast.ExceptHandler) -> bool:
    """Return whether a handler only catches what ends the whole program."""
    kinds = handler.type.elts if isinstance(handler.type, ast.Tuple) else [handler.type]
    return all(each is not None and ast.unparse(each).rpartition(".")[2] in _INTERRUPTS for each in kinds)


def _name(call: ast.Call) -> str:
    function = call.func
    return function.attr if isinstance(function, ast.Attribute) else getattr(function, "id", "")
