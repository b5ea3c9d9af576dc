"""Small programs whose timer callback calls a service by an idiom of Python."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from textwrap import indent

from tests.sources.support import HEAD, facts_of, indented, one

_IMPORTS = """
import asyncio, collections, collections.abc, contextlib, dataclasses, enum, operator, threading, typing
from dataclasses import dataclass, field
from enum import Enum
from functools import partial
from typing import Callable
"""


@dataclass(frozen=True)
class Idiom:
    """The parts of a program: `does` is the body of the callback, and ``self.ask()`` calls the service."""

    does: str
    init: str = ""
    methods: str = ""
    before: str = ""
    after: str = ""
    decorator: str = ""
    helper: str = ""

    @property
    def text(self) -> str:
        """The program, without the imports of ROS."""
        return f"""{_IMPORTS}
{self.before}
{self.decorator}
class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.cli = self.create_client(Trigger, "ask")
{_body(self.init)}
        self.create_timer(1.0, self.tick)
    def ask(self):
        return self.cli.call(Trigger.Request())
{indented(self.methods)}
    def tick(self):
{_body(self.does)}
{self.after}
if __name__ == "__main__":
    rclpy.init()
    rclpy.spin(Robot())
"""


def _body(text: str) -> str:
    return indent(text.strip("\n"), " " * 8)


def does_of(folder: Path, idiom: Idiom) -> list[str]:
    """Return what the timer callback of a program does."""
    files = {"helper": idiom.helper} if idiom.helper else {}
    compile(HEAD + idiom.text, "program.py", "exec")
    node = one(facts_of(folder, idiom.text, **files))
    (timer,) = [each for each in node.callbacks if each.kind == "timer"]
    return [effect.do for effect in timer.effects]
