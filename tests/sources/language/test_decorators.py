"""Decorators of the program, callable objects and generators: what they do belongs to the callback."""

from __future__ import annotations

from pathlib import Path

import pytest

from dineros.observation.findings.code import code_findings
from dineros.sources.reading import read_source
from tests.sources.support import effects, node_of

DECORATORS = """
import functools, threading, time, types
from functools import partialmethod

def locked(method):
    @functools.wraps(method)
    def inner(self, *args):
        with self.lock:
            return method(self, *args)
    return inner

def slow(seconds):
    def wrap(method):
        def inner(*args):
            time.sleep(seconds)
            return method(*args)
        return inner
    return wrap

def forgetful(method):
    def inner(self, *args):
        method(self, *args)
    return inner

def quiet(method):
    @functools.wraps(method)
    def inner(self, *args):
        try:
            return method(self, *args)
        except Exception:
            print("failed")
    return inner

class Timed:
    def __init__(self, method):
        self.method = method
    def __call__(self, *args):
        time.sleep(0.5)
        return self.method(*args)
    def __get__(self, instance, owner=None):
        return types.MethodType(self, instance)

class Pauses:
    def __call__(self):
        time.sleep(0.5)
"""
INIT = """
def __init__(self):
    super().__init__("robot")
    self.lock = threading.Lock()
    self.pub = self.create_publisher(String, "out", 10)
    self.cli = self.create_client(Trigger, "ask")
"""
TIMER = "    self.create_timer(1.0, self.tick)\n"
PUBLISH = "    self.pub.publish(String())\n"


def findings(folder: Path, body: str) -> list[str]:
    node_of(folder, INIT + body, before=DECORATORS)
    return sorted({each.rule for each in code_findings([("src", read_source(folder))])})


@pytest.mark.parametrize(
    ("decorators", "does"),
    [
        ("@locked", [("lock", "self.lock", "always")]),
        ("@slow(0.5)", [("sleep", "0.5", "always")]),
        ("@Timed", [("sleep", "0.5", "always")]),
        ("@locked\n@slow(0.5)", [("lock", "self.lock", "always"), ("sleep", "0.5", "always")]),
        ("@functools.lru_cache", []),
    ],
)
def test_what_a_decorator_does_is_done(
    tmp_path: Path, decorators: str, does: list[tuple[str, str, str]]
) -> None:
    body = f"{INIT}{TIMER}{decorators}\ndef tick(self):\n{PUBLISH}"
    node = node_of(tmp_path, body, before=DECORATORS)
    name = "__call__" if "Timed" in decorators else "tick"
    assert effects(node, name) == [*does, ("publish", "self.pub", "always")]


def test_methods_of_one_decorator_are_different_callbacks(tmp_path: Path) -> None:
    body = f"{INIT}{TIMER}    self.create_timer(1.0, self.tock)\n@locked\ndef tick(self):\n{PUBLISH}"
    node = node_of(tmp_path, f"{body}@locked\ndef tock(self):\n    pass", before=DECORATORS)
    assert [len(effects(node, name)) for name in ("tick", "tock")] == [2, 1]


def test_a_lock_of_a_decorator_is_taken_twice(tmp_path: Path) -> None:
    """This was proved to be free of deadlocks."""
    body = f"{TIMER}@locked\ndef tick(self):\n    self.tell()\n@locked\ndef tell(self):\n{PUBLISH}"
    assert findings(tmp_path, body) == ["code-waits-for-itself"]


def test_a_decorator_that_returns_no_response(tmp_path: Path) -> None:
    init = '    self.create_service(Trigger, "go", self.go)\n'
    method = "\ndef go(self, request, response):\n    return response"
    assert findings(tmp_path / "a", f"{init}@forgetful{method}") == ["code-gives-none"]
    assert findings(tmp_path / "b", f"{init}@locked{method}") == []


@pytest.mark.parametrize(("decorator", "forgets"), [("@quiet", True), ("", False)])
def test_a_plain_wrapper_of_a_coroutine(tmp_path: Path, decorator: str, forgets: bool) -> None:
    """`rclpy` calls the wrapper, and does not await what it returns."""
    body = f"{TIMER}{decorator}\nasync def tick(self):\n    await self.cli.call_async(Trigger.Request())"
    assert findings(tmp_path, body) == ["code-never-awaits"] * forgets


def test_partialmethod(tmp_path: Path) -> None:
    body = f"{INIT}{TIMER}def say(self, loud):\n    if loud:\n    {PUBLISH}tick = partialmethod(say, True)"
    node = node_of(tmp_path, body, before=DECORATORS)
    assert effects(node, "say") == [("publish", "self.pub", "always")]


def test_an_object_is_a_callback(tmp_path: Path) -> None:
    """Its ``__call__`` was not read, in silence."""
    node = node_of(tmp_path, f"{INIT}    self.create_timer(1.0, Pauses())", before=DECORATORS)
    assert effects(node, "__call__") == [("sleep", "0.5", "always")]


STEPS = f"def steps(self):\n    while True:\n    {PUBLISH}        yield\n"


@pytest.mark.parametrize(
    ("init", "tick", "does"),
    [
        ("    self.plan = self.steps()\n", "next(self.plan)", ["loop", "publish"]),
        ("    self.plan = self.steps()\n", "self.plan.send(1)", ["loop", "publish"]),
        ("", "for each in self.steps(): pass", ["loop", "publish"]),
        ("", "[*self.steps()]", ["loop", "publish"]),
        ("", "list(self.steps())", ["loop", "publish"]),
        ("", "[each for each in self.steps()]", ["loop", "publish"]),
        ("", "self.steps()", []),
    ],
)
def test_a_generator_runs_when_it_is_asked(tmp_path: Path, init: str, tick: str, does: list[str]) -> None:
    body = f"{INIT}{TIMER}{init}{STEPS}def tick(self):\n    {tick}"
    node = node_of(tmp_path, body, before=DECORATORS)
    assert [each for each, _, _ in effects(node, "tick")] == does
    assert [each["name"] for each in node["callbacks"]] == ["tick"]


def test_a_generator_is_no_callback(tmp_path: Path) -> None:
    assert findings(tmp_path, f"{TIMER}def tick(self):\n{PUBLISH}    yield") == ["code-never-awaits"]
