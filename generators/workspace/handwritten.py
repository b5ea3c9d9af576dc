"""Effects of a changed model on handwritten handlers: stubs to add, and references to changed elements."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Sequence
from pathlib import Path

from dineros.generators.application.application import Transition
from dineros.generators.templates.filters import Name
from dineros.generators.workspace import developers
from dineros.generators.workspace.developers import Module, read_module
from dineros.generators.workspace.manifest import DeveloperEntry, Manifest
from dineros.generators.workspace.notices import Notice
from dineros.generators.workspace.plan import DeveloperFile, Plan
from dineros.metamodel.errors import near_matches, with_article
from dineros.metamodel.files.confined import ConfinedFolder

FIRINGS = "firings"
"""The generated module that a module of handlers imports."""


def with_stubs(
    path: Path, file: DeveloperFile, new: Sequence[Transition], present: bytes
) -> tuple[bytes, list[str]]:
    """Return a module of handlers with stubs for new transitions appended, and the ids of these.

    A transition that has a handler already gets no stub.
    """
    if file.write_stub is None or not new:
        return present, []
    module = read_module(path, present)
    handled = {handler.model_transition for handler in developers.handlers(module)}
    missing = [transition for transition in new if transition.id not in handled]
    if not missing:
        return present, []
    parts = []
    firings = developers.module_name(module, file.package, FIRINGS)
    if firings is None:
        firings = FIRINGS
        parts.append(f"from . import {FIRINGS}  # noqa: E402\n")
    taken = developers.names(module)
    for transition in missing:
        function = transition.function
        while function in taken:
            function = Name(f"{function}_")
        taken.add(function)
        parts.append(file.write_stub(transition, function, Name(firings)))
    return developers.append(module, parts), [transition.id for transition in missing]


def handler_notices(
    path: Path, shown: str, file: DeveloperFile, known: DeveloperEntry | None, plan: Plan, present: bytes
) -> list[Notice]:
    """Return notices about handlers of removed transitions, and about transitions with changed arcs."""
    if file.write_stub is None or file.node is None:
        return []
    notices = []
    instances = plan.instances[file.node]
    transitions = {transition.id: transition for transition in file.transitions}
    for handler in developers.handlers(read_module(path, present)):
        problem = _problem(handler, instances, file.node)
        if problem:
            new = [name for name in instances if name not in (known.stubs if known else {})]
            hint = near_matches(handler.model_transition, new) or "move its code or remove it"
            notices.append(Notice("obsolete-handler", shown, problem, hint, handler.line, stays=True))
            continue
        stub = known.stubs.get(handler.model_transition) if known else None
        transition = transitions.get(handler.model_transition)
        if stub and transition:
            now = (tuple(map(str, transition.inputs)), tuple(map(str, transition.outputs)))
            if now != (stub.inputs, stub.outputs):
                was = " -> ".join(" + ".join(side) or "nothing" for side in (stub.inputs, stub.outputs))
                message = f"handles {handler.transition}, which was {was} and is now {transition.flow}"
                notices.append(Notice("arcs-changed", shown, message, "", handler.line))
    return notices


def _problem(handler: developers.Handler, instances: dict[str, int], node: str) -> str | None:
    name = handler.transition
    if name in instances:
        return None
    found = developers.instance_of(name)
    if found is None or found.transition not in instances:
        return f"handles {name}, which is no longer a transition of {node}"
    count = instances[found.transition]
    if not 1 <= found.number <= count:
        return f"handles {name}, but the service has {count} instance{'s' if count > 1 else ''}"
    return None


def left_over(shown: str, entry: DeveloperEntry, plan: Plan) -> Notice:
    """Return a notice that a developer's file belongs to a removed node net, with its likely successor."""
    hint = "move the parts that you need, then remove it"
    likely = _successor(entry, plan)
    if likely is not None:
        move = shlex.join(["git", "mv", "-f", shown, likely])
        hint = f"if {entry.node} is {plan.developer[likely].node} now, move it: {move}"
    message = f"belongs to {entry.node}, which the model no longer has; file kept"
    if entry.node in plan.instances:
        message = "is no longer used; file kept"
    return Notice("left-over", shown, message, hint, stays=True)


def _successor(entry: DeveloperEntry, plan: Plan) -> str | None:
    """Return the module of the node net that has most of the transitions."""
    best, score = None, len(entry.stubs) / 2
    for path, file in plan.developer.items():
        common = sum(transition.id in entry.stubs for transition in file.transitions)
        if common > score:
            best, score = path, common
    return best


def token_notices(workspace: Path, before: Manifest, after: Manifest) -> list[Notice]:
    """Return notices about changed token fields, with the places where handlers name them."""
    if not before.model:
        return []
    changed = {}
    for name, kind in before.token.items():
        now = after.token.get(name)
        if now is None:
            near = near_matches(name, [new for new in after.token if new not in before.token])
            changed[name] = (f"the token field {name!r} ({kind}) no longer exists", near or "")
        elif now != kind:
            was, is_now = with_article(kind), with_article(now)
            changed[name] = (f"the token field {name!r} was {was} and is now {is_now}", "")
    if not changed:
        return []
    notices = []
    for path in after.developer:
        content = ConfinedFolder(workspace).read(path) if path.endswith(".py") else None
        if content is None:
            continue
        module = read_module(workspace / path, content)
        for name, line in developers.texts(module, changed):
            message, hint = changed[name]
            notices.append(Notice("token-changed", path, f"{_function(module, line)}: {message}", hint, line))
    named = {notice.message.partition(": ")[2] for notice in notices}
    for message, hint in changed.values():
        if message not in named:
            notices.append(Notice("token-changed", after.source, f"{message}; no handler names it", hint))
    return notices


def _function(module: Module, line: int) -> str:
    handlers: Iterable[developers.Handler] = developers.handlers(module)
    for handler in handlers:
        if handler.line <= line <= handler.end:
            return f"{handler.function or 'the handler'} handles {handler.transition}"
    return "this module names it"
