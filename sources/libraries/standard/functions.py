"""Interprets other functions of the standard library: sleeps, coroutines, settings, files."""

from __future__ import annotations

import ast
from collections.abc import Callable

from dineros.sources.facts import is_open
from dineros.sources.language.computing.constants import call_built_in
from dineros.sources.language.computing.gathering import OF_ROS2
from dineros.sources.language.values import (
    NONE,
    QUEUE,
    Const,
    Frame,
    Items,
    Made,
    Open,
    Outside,
    Partial,
    Text,
    Value,
    constant,
    join,
    text_of,
)
from dineros.sources.libraries.doing import QUEUES, seconds
from dineros.sources.libraries.executing.executors import Executors

_ALWAYS_SET = frozenset(("ROS_DISTRO", "HOME", "USER", "PATH", "PWD", "HOSTNAME", "SHELL"))
_WAITS = frozenset(("run", "call", "check_call", "check_output"))


class Standard:
    """Functions of the standard library.

    `executors`: follows threads and coroutines.
    """

    def __init__(self, executors: Executors) -> None:
        self.executors = executors
        self.load: Callable[[str], Value | None] = lambda path: None
        """Returns the contents of a file of settings; None: unknown."""
        self.doer, self.machine = executors.doer, executors.machine

    def call(self, path: str, last: str, made: Made, node: ast.AST, frame: Frame) -> Value | None:
        """Call a function by its dotted name and the last part of it; None: another one."""
        args, keys, effect = made.args, made.keys, self.machine.effect
        if path == "time.sleep":
            number = seconds(args[0] if args else None)
            what = f"{constant(args[0])}" if number is not None else text_of(args[0] if args else None)
            effect("sleep", what, node, frame, "time.sleep", timeout=number)
            return NONE
        if path == "select.select" and len(args) > 3 and (most := seconds(args[3])):
            effect("sleep", f"{most:g}", node, frame, path, timeout=most)
            return Open(path)
        if path in ("functools.partial", "partial") and args:
            return Partial(args[0], args[1:], keys)
        if path == "functools.partialmethod":
            return made
        if path in ("importlib.import_module", "builtins.__import__") and args:
            return self.machine.imported(text_of(args[0]), frame) or made
        if path == "types.MethodType" and len(args) == 2:
            return Partial(args[0], args[1:], {})
        if path in QUEUES:
            most = constant(made.argument(0, "maxsize"))
            is_bounded = isinstance(most, int) and most > 0
            return self.doer.once(Items([], kind=QUEUE, is_bounded=is_bounded), made.at)
        if path in ("copy.copy", "copy.deepcopy") and args:
            return Made(path, args, {}, made.at) if isinstance(args[0], (Made, Outside)) else args[0]
        if path in ("os.environ.get", "os.getenv"):
            return self._environment(args)
        if last in ("get_package_share_directory", "get_package_share_path") and args:
            return Const(f"$(find {text_of(args[0])})")
        if path in ("pathlib.Path", "os.fspath") and args and isinstance(args[0], (Const, Text)):
            return args[0]
        if path in ("yaml.safe_load", "yaml.load", "yaml.full_load") and args and isinstance(args[0], Made):
            opened = text_of(args[0].argument(0, "file"))
            return self.load(opened) or Open(f"{path}({opened})")
        if path.startswith("subprocess.") and last in _WAITS:
            given = keys.get("timeout")
            effect("work", path, node, frame, timeout=seconds(given))
            return Open(path)
        if path == "asyncio.to_thread" and args:
            return self.executors.run_apart(args[0], args[1:], node, frame)
        if path in ("asyncio.run", "asyncio.run_coroutine_threadsafe"):
            slept = args[0] if args else None
            if isinstance(slept, Made) and slept.path == "asyncio.sleep" and path == "asyncio.run":
                return self.call("time.sleep", "sleep", slept, node, frame)
            blocked = "blocks, without time-out" if path == "asyncio.run" else "async"
            self.executors.run_coroutine(made, node, frame, blocked)
            return join(args) if path == "asyncio.run" and len(args) == 1 else made
        if path in ("concurrent.futures.wait", "concurrent.futures.as_completed"):
            self.executors.wait_for_all(made.argument(0, "fs"), made.argument(1, "timeout"), node, frame)
            return args[0] if args and last == "as_completed" else Open(path)
        if path in (
            "asyncio.gather",
            "asyncio.wait",
            "asyncio.create_task",
            "asyncio.ensure_future",
        ):
            return join(args) if len(args) == 1 else Open(path)
        return call_built_in(path, args, path)

    def _environment(self, args: list[Value]) -> Value:
        name = text_of(args[0] if args else None)
        if name in OF_ROS2:
            return Const(OF_ROS2[name])
        default = args[1] if len(args) > 1 else NONE
        if name in _ALWAYS_SET or is_open(name):
            return Open(f"environment {name}")
        return Const(default.value, f"environment {name}") if isinstance(default, Const) else default
