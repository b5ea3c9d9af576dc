"""Reads the callbacks of a program, when the program itself has run: what they do, and for which node."""

from __future__ import annotations

import ast

from dineros.sources.branches import fields_of_effects, variables_set
from dineros.sources.folders import SourceFolder
from dineros.sources.language.activities import Activity
from dineros.sources.language.calls import Interpreter
from dineros.sources.language.fields.messages import answered
from dineros.sources.language.fields.responses import leave_open
from dineros.sources.language.machine import EVENT, MOST_STEPS_OF_EVENTS, TooLong
from dineros.sources.language.running.polling import add_setters
from dineros.sources.language.values import (
    Bound,
    Callback,
    Const,
    Function,
    Generator,
    Object,
    OutsideMethod,
    Value,
    options,
)
from dineros.sources.libraries.certain import find_variables, only_followed
from dineros.sources.places import Place


def read_callbacks(machine: Interpreter, folder: SourceFolder) -> None:
    """Read all callbacks twice: the first pass finds the values that they assign to attributes.

    Events are read once, before the second pass: they are many in programs with windows.
    """
    for is_final in (False, True):
        machine.is_final = is_final
        done: set[int] = set()
        while True:
            if is_final:
                _events(machine, done, folder)
            todo = [
                each for each in machine.callbacks.values() if id(each) not in done and not _is_event(each)
            ]
            if not todo:
                break
            for callback in todo:
                done.add(id(callback))
                _read(machine, callback)


def _events(machine: Interpreter, done: set[int], folder: SourceFolder) -> None:
    """Read the functions that unknown code receives, as long as the steps for them suffice."""
    before, most = machine.steps, machine.most_steps
    machine.most_steps = before + MOST_STEPS_OF_EVENTS
    try:
        while todo := [
            each for each in machine.callbacks.values() if _is_event(each) and id(each) not in done
        ]:
            for callback in todo:
                done.add(id(callback))
                _read(machine, callback)
    except (TooLong, RecursionError):
        done |= {id(each) for each in machine.callbacks.values() if _is_event(each)}
        folder.unread.append(
            f"{machine.home}: the functions that libraries receive are too large to be read completely"
        )
    machine.most_steps = most + machine.steps - before


def _is_event(callback: Callback) -> bool:
    return callback.fact.kind == EVENT


def _read(machine: Interpreter, callback: Callback) -> None:
    machine.run += 1
    machine.reading = callback
    fact = callback.fact
    fact.effects = []
    target = _target(callback.function)
    if isinstance(target, Object):
        target = machine.look_up(target.cls, "__call__") or target
    node: ast.AST = getattr(target, "node", None) or ast.Pass(lineno=fact.at.line, col_offset=0)
    activity = Activity(fact, callback.node)
    machine.trail = [("callback", id(callback.first().fact))]
    machine.calls = []
    frame = getattr(target, "frame", None)
    if isinstance(target, OutsideMethod) and target.is_followed and target.at is not None:
        frame = machine.frames.get(target.at.file)
        node = _call_of(target, target.at)
    if frame is None:
        fact.is_open = True
        return
    with machine.doing(activity):
        found = machine.call(callback.function, list(callback.args), {}, node, frame)
        if isinstance(found, Generator):
            machine.effect("forgets", fact.name, node, frame, "generator")
    if fact.kind in ("service", "execute", "goal", "cancel"):
        fact.lacks = _lacks(callback, found)
    fact.body = activity.block
    if not activity.is_lost:
        for effect, fields in fields_of_effects(activity.block).items():
            effect.given = fields
    fact.answers = _answers(callback)
    if fact.kind == "service":
        leave_open(node, fact.body or [])
    if activity.is_lost:
        fact.body = None
        machine.attributes.names |= {each.name for each in variables_set(activity.block)}


def _call_of(method: OutsideMethod, at: Place) -> ast.AST:
    """Return a call of a method that is the callback itself, such as ``self.items.append``."""
    try:
        node = ast.parse(f"{method.text}()", mode="eval").body
    except SyntaxError:  # the text is shortened
        node = ast.Constant(None)
    for each in ast.walk(node):
        if isinstance(each, ast.expr):
            each.lineno, each.col_offset = at.line, 0
    return node


def _lacks(callback: Callback, found: Value) -> str:
    """Return whether a callback returns None or a constant, always or in some case, as its code says."""
    function = _target(callback.function)
    decorators = function.decorators if isinstance(function, Function) else ("unknown",)
    values = options(found)
    wrong = [each for each in values if isinstance(each, Const) and not each.origin]
    if decorators or not wrong:
        return ""
    return "always" if len(wrong) == len(values) else "conditional"


def _answers(callback: Callback) -> dict[str, bool]:
    """Return the fields of a service's response that are certain, if one function makes each response."""
    function, count = callback.function, 2
    if isinstance(function, Bound):
        function, count = function.function, 3
    if callback.fact.kind != "service" or not isinstance(function, Function):
        return {}
    wanted = function.node.args
    has_more = wanted.posonlyargs or wanted.vararg or wanted.kwonlyargs or wanted.kwarg
    return {} if has_more or len(wanted.args) != count else answered(function.node)


def _target(function: object) -> object:
    while hasattr(function, "function"):
        function = function.function
    if hasattr(function, "options"):
        return next((_target(each) for each in function.options if hasattr(_target(each), "node")), function)
    return function


def assign_callbacks(machine: Interpreter, activity: Activity) -> None:
    """Assign callbacks without a node to the nodes whose ports they use, or to the first node."""
    find_variables(machine, activity.block)
    add_setters(machine, only_followed(machine))
    for key, callback in list(machine.callbacks.items()):
        if callback.fact.kind == EVENT and not callback.fact.effects:
            del machine.callbacks[key]
            if callback.node is not None:
                callback.node.callbacks.remove(callback.fact)
    main = activity.fact
    loose = [callback.fact for callback in machine.callbacks.values() if callback.node is None]
    if machine.nodes:
        for fact in ([main] if main.effects else []) + loose:
            used = [
                node for node in machine.nodes if any(each.entity in node.entities for each in fact.effects)
            ]
            for node in used or machine.nodes[:1]:
                if fact not in node.callbacks:
                    node.callbacks.append(fact)
    for node in machine.nodes:
        for entity in node.entities:
            for role, fact in entity.callbacks.items():
                if fact.is_open and not fact.effects and role == "callback":
                    entity.details.setdefault("open", "the callback is not in the folder")
