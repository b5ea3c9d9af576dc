"""Evaluates the actions of a launch file with the values of its arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from typing import Any

from dineros.sources.language.values import (
    Const,
    Items,
    Made,
    Value,
    hole,
    is_none,
    options,
    text_of,
)
from dineros.sources.language.values import Mapping as Table
from dineros.sources.launch.started import Started, full
from dineros.sources.launch.substitutions import (
    Scope,
    Substitutions,
    known_or_open,
    truth_of,
    typed,
    words_of,
)

DEEPEST = 12
"""Limit of nested includes."""


class Walker(Substitutions):
    """Walks through the actions of launch files.

    Parameters
    ----------
    given : mapping of str to str
        Values of arguments.
    include : callable
        Reads a launch file: its path, a scope and itself; returns its actions, or None.
    call : callable
        Calls a function of an ``OpaqueFunction``.
    """

    def __init__(
        self,
        given: Mapping[str, str],
        include: Callable[[str, Scope], list[Value] | None],
        call: Callable[[Value, list[Value], dict[str, Value], Scope], Value],
    ) -> None:
        super().__init__(given)
        self.arguments: dict[str, str] = {}
        self.found: list[Started] = []
        self.follows = True
        self._include = include
        self._call = call
        self._depth = 0
        self.including: list[str] = []
        self._containers: dict[int, tuple[Made, Started]] = {}

    def walk(self, value: Value | None, scope: Scope) -> None:
        """Walk through an action, or a list of them."""
        for each in options(value):
            if isinstance(each, Items):
                for inner in each.items:
                    self.walk(inner, scope)
            elif isinstance(each, Made):
                self._action(each, scope)

    def _action(self, made: Made, scope: Scope) -> None:
        last = made.path.rpartition(".")[2]
        if last in ("perhaps", "never"):
            inner = scope.copy()
            inner.when = (*inner.when, "in a branch" + (" (by default: no)" if last == "never" else ""))
            inner.is_enabled &= last == "perhaps"
            self.walk(made.args[0], inner)
            return
        inner, holds = self._under(made, scope)
        self._act(made, last, inner)
        if holds is None:
            scope.may_become(inner)

    def _act(self, made: Made, last: str, scope: Scope) -> None:
        method = getattr(self, f"_{_ACTIONS.get(last, '')}", None)
        if method is not None:
            method(made, scope)
        elif last == "GroupAction":
            self._group(made, scope)
        elif last in ("LaunchDescription", "TimerAction", "OpaqueCoroutine"):
            own = scope if last == "LaunchDescription" else scope.copy()
            if last == "TimerAction":
                own.when = (*own.when, f"after {self.text(made.argument(-1, 'period'), scope)} s")
            self.walk(made.argument(0 if last != "TimerAction" else -1, "actions", "initial_entities"), own)
            added = made.slots.get("added actions")
            self.walk(added.current if added else None, own)
        elif last == "RegisterEventHandler":
            own = scope.copy()
            own.when = (*own.when, "after an event")
            handler = made.argument(0, "event_handler")
            for each in options(handler):
                if isinstance(each, Made):
                    for key in ("on_exit", "on_start", "on_completion", "entities", "on_shutdown"):
                        self.walk(each.keys.get(key), own)

    def _group(self, made: Made, scope: Scope) -> None:
        """Walk through a group; what it sets stays in it, unless it has no scope of its own."""
        is_scoped = truth_of(self.text(made.argument(-1, "scoped"), scope) or "true") is not False
        own = scope.copy() if is_scoped else scope
        if is_scoped and truth_of(self.text(made.argument(-1, "forwarding"), scope) or "true") is False:
            own.values, own.remappings, own.parameters = {}, {}, {}
        given = made.argument(-1, "launch_configurations")
        for key, value in given.items.items() if isinstance(given, Table) else ():
            own.values[key] = known_or_open(self.text(value, scope))
        self.walk(made.argument(0, "actions"), own)

    def _under(self, made: Made, scope: Scope) -> tuple[Scope, bool | None]:
        """Return the scope of an action with its condition, and whether that holds; None: unknown.

        Only an action whose condition certainly holds changes the scope of the actions after it.
        """
        condition = made.keys.get("condition")
        found = scope
        holds: bool | None = True
        for each in options(condition):
            if not isinstance(each, Made):
                continue
            last = each.path.rpartition(".")[2]
            wanted = last not in ("UnlessCondition", "LaunchConfigurationNotEquals")
            if last.startswith("LaunchConfiguration"):
                name, value = text_of(each.argument(0)), self.text(each.argument(1, "expected_value"), scope)
                current = hole(scope.values.get(name, Const("")))
                held: bool | None = None if "{" in current + value else current == value
                words = f"{name} is {value}"
            else:
                text = self.text(each.argument(0, "predicate_expression"), scope)
                held = truth_of(text)
                words = words_of(each.argument(0, "predicate_expression"))
            words = words if wanted else f"not ({words})"
            is_on = held is wanted or held is None
            default = "open" if held is None else "yes" if is_on else "no"
            found = replace(found, when=(*found.when, f"{words} (by default: {default})"))
            found.is_enabled &= is_on
            holds = holds and (None if held is None else is_on)
        return found if holds else found.copy(), holds

    # ------------------------------------------------------------------------------------------------ actions

    def _argument(self, made: Made, scope: Scope) -> None:
        name = self.text(made.argument(0, "name"), scope)
        default = made.argument(-1, "default_value", "default")
        known = scope.values.get(name)
        if known is None:
            value: Value | None = Const(self.given[name]) if name in self.given else None
            if value is None and default is not None:
                text = self.text(default, scope)
                value = known_or_open(text)
            if value is not None:
                scope.values[name] = value
        if scope.file == (self.including or [scope.file])[0]:
            self.arguments[name] = hole(scope.values.get(name)) if name in scope.values else "open"

    def _set(self, made: Made, scope: Scope) -> None:
        text = self.text(made.argument(1, "value"), scope)
        scope.values[self.text(made.argument(0, "name"), scope)] = known_or_open(text)

    def _push(self, made: Made, scope: Scope) -> None:
        namespace = self.text(made.argument(0, "namespace"), scope)
        if namespace:
            scope.namespace = full(namespace, scope.namespace)

    def _remap(self, made: Made, scope: Scope) -> None:
        source = self.text(made.argument(0, "src"), scope)
        scope.remappings.setdefault(source, self.text(made.argument(1, "dst"), scope))  # the first holds

    def _parameter(self, made: Made, scope: Scope) -> None:
        scope.parameters[self.text(made.argument(0, "name"), scope)] = self.scalar(
            made.argument(1, "value"), scope
        )

    def _opaque(self, made: Made, scope: Scope) -> None:
        args = made.argument(-1, "args")
        keys = made.argument(-1, "kwargs")
        given = list(getattr(args, "items", [])) if isinstance(args, Items) else []
        named = dict(keys.items) if isinstance(keys, Table) else {}
        function = made.argument(0, "function")
        if function is not None:
            context = Made("launch.LaunchContext", [], {}, made.at)
            self.walk(self._call(function, [context, *given], named, scope), scope)

    def _included(self, made: Made, scope: Scope) -> None:
        source = made.argument(0, "launch_description_source")
        path = source
        for each in options(source):
            if isinstance(each, Made) and each.path.endswith("Source"):
                path = each.argument(0, "launch_file_path", "location", "launch_description")
        text = self.text(path, scope)
        arguments = made.argument(-1, "launch_arguments")
        pairs = arguments.items if isinstance(arguments, Items) else []
        if isinstance(arguments, Table):
            pairs = [Items([Const(key), value]) for key, value in arguments.items.items()]
        for pair in pairs:
            if isinstance(pair, Items) and len(pair.items) == 2:
                value = self.text(pair.items[1], scope)
                scope.values[self.text(pair.items[0], scope)] = known_or_open(value)
        shown = text.rpartition("/")[2] if "{" not in text else f"open: {text}"
        self._add(Started(made.at, kind="include", included=shown), scope)
        if self.follows and self._depth < DEEPEST and "{" not in text:
            inner = replace(scope)  # an included file sets arguments and namespaces for what follows, too
            self._depth += 1
            actions = self._include(text, inner)
            if actions is not None:
                self.including.append(inner.file)
                for action in actions:
                    self.walk(action, inner)
                self.including.pop()
            self._depth -= 1

    def _node(self, made: Made, scope: Scope, kind: str = "node") -> None:
        last = made.path.rpartition(".")[2]
        kind = {"LifecycleNode": "lifecycle", "ComposableNodeContainer": "container"}.get(last, kind)
        found = self._started(made, scope, kind)
        self._add(found, scope)
        self._containers[id(made)] = made, found
        self._components(made.argument(-1, "composable_node_descriptions"), found.name, scope, found)

    def _load(self, made: Made, scope: Scope) -> None:
        target = made.argument(-1, "target_container")
        name = (
            self.text(target.argument(-1, "name"), scope)
            if isinstance(target, Made)
            else self.text(target, scope)
        )
        _, within = self._containers.get(id(target), (None, None))
        self._components(made.argument(-1, "composable_node_descriptions"), name, scope, within)

    def _components(self, values: Value | None, container: str, scope: Scope, within: Started | None) -> None:
        for each in values.items if isinstance(values, Items) else ():
            for made in options(each):
                if isinstance(made, Made):
                    under, _ = self._under(made, scope)
                    found = self._started(made, under, "component")
                    found.container, found.within = container, within
                    self._add(found, under)

    def _started(self, made: Made, scope: Scope, kind: str) -> Started:
        namespace = scope.namespace
        own = self.text(made.keys.get("namespace"), scope) if "namespace" in made.keys else ""
        if own:
            namespace = full(own, scope.namespace)
        name = made.keys.get("name")
        found = Started(
            made.at,
            self.text(made.keys.get("package"), scope) if "package" in made.keys else "",
            self.text(made.keys.get("executable"), scope) if "executable" in made.keys else "",
            self.text(made.argument(-1, "plugin"), scope) if "plugin" in made.keys else "",
            "" if is_none(name) else self.text(name, scope),
            "" if namespace == "/" else namespace,
            dict(scope.remappings),
            kind=kind,
        )
        if scope.parameters:
            found.parameters.append(dict(scope.parameters))
        found.parameters += self._values(made.keys.get("parameters"), scope)
        for pair in self._pairs(made.keys.get("remappings")):
            found.remappings.setdefault(self.text(pair[0], scope), self.text(pair[1], scope))
        self._command_line(self._texts(made.keys.get("arguments"), scope), found)
        self._command_line(["--ros-args", *self._texts(made.keys.get("ros_arguments"), scope)], found)
        return found

    @staticmethod
    def _command_line(arguments: Sequence[str], found: Started) -> None:
        """Read arguments of a program: those of ROS are names, remappings and parameters."""
        before = ""
        for argument in arguments:
            source, is_rule, target = argument.partition(":=")
            found.has_threads |= argument == "--use_multi_threaded_executor"
            if is_rule and before in ("-p", "--param"):
                found.parameters.append({source: typed(target)})
            elif before == "--params-file":
                found.parameters.append(argument)
            elif is_rule and source == "__node":
                found.name = target
            elif is_rule and source == "__ns":
                found.namespace = target
            elif is_rule and not source.startswith("_"):
                found.remappings.setdefault(source, target)
            elif argument not in _OF_ROS:
                found.arguments.append(argument)
            before = argument

    def _add(self, found: Started, scope: Scope) -> None:
        found.when, found.is_enabled, found.file = "; ".join(scope.when), scope.is_enabled, scope.file
        self.found.append(found)

    def _pairs(self, value: Value | None) -> list[Sequence[Value]]:
        items = value.items if isinstance(value, Items) else []
        return [each.items for each in items if isinstance(each, Items) and len(each.items) == 2]

    def _texts(self, value: Value | None, scope: Scope) -> list[str]:
        return [self.text(each, scope) for each in (value.items if isinstance(value, Items) else [])]

    def _values(self, value: Value | None, scope: Scope) -> list[Any]:
        found: list[Any] = []
        for each in value.items if isinstance(value, Items) else []:
            for option in options(each):
                if isinstance(option, Table):
                    found.append(self._flat(option, scope, ""))
                elif isinstance(option, Made) and option.path.endswith("ParameterFile"):
                    found.append(self.text(option.argument(0, "param_file"), scope))
                elif isinstance(option, Items):
                    found += self._values(option, scope)
                else:
                    found.append(self.text(option, scope))
        return found

    def _flat(self, table: Table, scope: Scope, prefix: str) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for key, value in table.items.items():
            if isinstance(value, Table):
                found |= self._flat(value, scope, f"{prefix}{key}.")
            else:
                found[f"{prefix}{key}"] = self.scalar(value, scope)
        return found


_OF_ROS = ("--ros-args", "-r", "--remap", "-p", "--param", "--params-file", "--")
"""Arguments of the command line that say what the next one is."""
_ACTIONS = {
    "DeclareLaunchArgument": "argument",
    "SetLaunchConfiguration": "set",
    "PushRosNamespace": "push",
    "PushROSNamespace": "push",
    "SetRemap": "remap",
    "SetParameter": "parameter",
    "OpaqueFunction": "opaque",
    "IncludeLaunchDescription": "included",
    "Node": "node",
    "LifecycleNode": "node",
    "ComposableNodeContainer": "node",
    "LoadComposableNodes": "load",
}
