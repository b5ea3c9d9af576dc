"""Random programs with flags: what Python does when it runs them is what their flows do."""

from __future__ import annotations

import random
import types
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from dineros.observation.importing.coded import coded
from dineros.observation.importing.flows.labels import Ask, Flow, Set, Step
from dineros.observation.importing.flows.narrowing import narrowed
from dineros.sources.reading import read_source

HEAD = """
import random
import rclpy
from rclpy.node import Node
from std_msgs.msg import String


class Robot(Node):
    def __init__(self):
        super().__init__("robot")
        self.outputs = 0
        self.pub = [0]
        self.a = self.create_publisher(String, "a", 10)
        self.b = self.create_publisher(String, "b", 10)
"""
TAIL = """

def main():
    rclpy.init()
    rclpy.spin(Robot())


if __name__ == "__main__":
    main()
"""
MOST_COINS = 6
"""Tests of one run that may come out in two ways; further ones do not hold."""
MOST_RUNS = 100
"""Different runs of a callback from one state that are looked at."""
VALUES = {"busy": ["False", "True"], "mode": ["None", "1", "2", "'stop'"], "goal": ["None", "String()"]}
State = tuple[str, ...]
Run = tuple[tuple[str, ...], State]


class Writer:
    """Writes a random program."""

    def __init__(self, seed: int, *, has_handlers: bool, has_matches: bool = False) -> None:
        self._has_matches = has_matches
        self._random = random.Random(seed)
        self._has_handlers = has_handlers
        self.flags = self._random.sample(sorted(VALUES), self._random.randint(1, 3))
        self.timers = self._random.randint(1, 3)

    def program(self) -> str:
        lines = [f"        self.{flag} = {self._value(flag)}" for flag in self.flags]
        lines += [
            f"        self.create_timer({index + 1}.0, self.on_{index})" for index in range(self.timers)
        ]
        for name in ("helper", *(f"on_{index}" for index in range(self.timers))):
            self._helps = name != "helper"
            lines += ["", f"    def {name}(self):", *self._block(2, 2)]
        lines.append("        self.helper()")
        return HEAD + "\n".join(lines) + TAIL

    def _value(self, flag: str) -> str:
        return self._random.choice(VALUES[flag])

    def _test(self, depth: int = 2) -> str:
        pick = self._random.random()
        if depth and pick < 0.2:
            return f"not ({self._test(depth - 1)})"
        if depth and pick < 0.45:
            return f"({self._test(depth - 1)} {self._random.choice(['and', 'or'])} {self._test(depth - 1)})"
        if pick < 0.5:
            return "random.random() < 0.5"
        flag = self._random.choice(self.flags)
        if flag == "goal" or pick < 0.65:
            return self._random.choice([f"self.{flag}", f"self.{flag} is None", f"self.{flag} is not None"])
        other = self._value(flag)
        return self._random.choice(
            [
                f"self.{flag}",
                f"self.{flag} == {other}",
                f"{other} != self.{flag}",
                f"self.{flag} in ({other},)",
            ]
        )

    def _block(self, indent: int, depth: int) -> list[str]:
        return [line for _ in range(self._random.randint(1, 3)) for line in self._statement(indent, depth)]

    def _statement(self, indent: int, depth: int) -> list[str]:
        pad, pick = " " * 4 * indent, self._random.random()
        flag = self._random.choice(self.flags)
        if depth and self._has_matches and self._random.random() < 0.4:
            return self._match(indent, depth)
        if depth and pick < 0.35:
            lines = [f"{pad}if {self._test()}:", *self._block(indent + 1, depth - 1)]
            if self._random.random() < 0.5:
                lines += [f"{pad}else:", *self._block(indent + 1, depth - 1)]
            return lines
        if depth and pick < 0.42:
            ends = [
                f"{pad}    if {self._test()}:",
                f"{pad}        {self._random.choice(['break', 'continue'])}",
            ]
            return [
                f"{pad}for _ in range({self._random.choice([1, 2, 5])}):",
                *ends,
                *self._block(indent + 1, 0),
            ]
        if depth and pick < 0.5 and self._has_handlers:
            lines = [f"{pad}try:", *self._block(indent + 1, depth - 1)]
            lines += [f"{pad}    if {self._test()}:", f"{pad}        raise ValueError"]
            if self._random.random() < 0.7:
                lines += [f"{pad}except ValueError:", *self._block(indent + 1, depth - 1)]
                last = self._random.random() < 0.3
            else:
                lines[-1] = f"{pad}        return"
                last = True
            return [*lines, *([f"{pad}finally:", *self._block(indent + 1, 0)] if last else [])]
        if pick < 0.6:
            return [f"{pad}self.{self._random.choice('ab')}.publish(String())"]
        if pick < 0.66 and self._helps:
            return [f"{pad}if {self._test()}:", f"{pad}    return"]
        if pick < 0.72 and self._helps:
            return [f"{pad}self.helper()"]
        if pick < 0.78 and flag == "busy":
            return [f"{pad}self.busy = not self.{self._random.choice(self.flags)}"]
        if pick < 0.82 and flag == "mode":
            return [f"{pad}self.mode = {self._value('mode')} if {self._test(1)} else {self._value('mode')}"]
        return [f"{pad}self.{flag} = {self._value(flag)}"]

    def _match(self, indent: int, depth: int) -> list[str]:
        """Return a ``match`` of a flag."""
        pad, flag = " " * 4 * indent, self._random.choice(self.flags)
        lines = [f"{pad}match self.{flag}:"]
        for _ in range(self._random.randint(1, 3)):
            one, two = self._value(flag), self._value(flag)
            pattern = self._random.choice([one, one, f"{one} | {two}", f"({one}) as found", "found"])
            is_last = pattern == "found"
            test = f" if {self._test()}" if is_last or self._random.random() < 0.3 else ""
            if self._random.random() < 0.2 and self._helps:
                test = f" if self.helper() is {self._random.choice(['', 'not '])}None"
            lines += [f"{pad}    case {pattern}{test}:", *self._block(indent + 2, depth - 1)]
        if self._random.random() < 0.4:
            lines += [f"{pad}    case _:", *self._block(indent + 2, depth - 1)]
        return lines


# ------------------------------------------------------------------------------------------------- by Python


class Coins:
    """Gives numbers by a list of choices, which grows as it is asked for more."""

    def __init__(self, choices: list[bool]) -> None:
        self.choices, self.asked = choices, 0

    def random(self) -> float:
        if self.asked == MOST_COINS:
            return 1.0
        if self.asked == len(self.choices):
            self.choices.append(True)
        self.asked += 1
        return 0.0 if self.choices[self.asked - 1] else 1.0


class Real:
    """The program, run by Python on a node that only notes what is published."""

    def __init__(self, text: str, flags: list[str]) -> None:
        published: list[str] = []

        class Node:
            def __init__(self, _name: str) -> None:
                self.timers: list[Any] = []

            def create_publisher(self, _type: object, topic: str, _depth: int) -> object:
                return types.SimpleNamespace(publish=lambda _message: published.append(topic))

            def create_timer(self, _period: float, callback: object) -> None:
                self.timers.append(callback)

        body = text.split("from std_msgs.msg import String\n", 1)[1].rsplit("if __name__", 1)[0]
        self._names: dict[str, Any] = {"Node": Node, "String": type("String", (), {}), "random": None}
        exec(body, self._names)
        self._published, self._flags = published, flags
        self._robot = self._names["Robot"]()

    def state(self) -> State:
        values = (getattr(self._robot, flag) for flag in self._flags)
        return tuple("something" if type(each).__name__ == "String" else repr(each) for each in values)

    def runs(self, index: int, state: State) -> set[Run]:
        """Return what a callback may publish from a state, and the state after it."""
        found: set[Run] = set()
        choices: list[bool] = []
        while True:
            for flag, value in zip(self._flags, state, strict=True):
                known = self._names["String"]() if value == "something" else eval(value)
                setattr(self._robot, flag, known)
            self._published.clear()
            self._names["random"] = coins = Coins(choices)
            self._robot.timers[index]()
            found.add((tuple(self._published), self.state()))
            del choices[coins.asked :]
            while choices and not choices[-1]:
                choices.pop()
            if not choices or len(found) > MOST_RUNS:
                return found
            choices[-1] = False


# --------------------------------------------------------------------------------------------------- by flows


def followed(flow: Flow, flags: list[str], state: State) -> set[Run]:
    """Return what a flow may publish from a state, and the state after it."""
    found: set[Run] = set()
    todo: list[tuple[int, tuple[str, ...], State]] = [(flow.start, (), state)]
    seen = set(todo)
    while todo:
        at, published, values = todo.pop()
        if at == flow.end:
            found.add((published, values))
        for edge in flow.edges:
            if edge.source != at:
                continue
            done, after = published, values
            if isinstance(edge.label, Step):
                done = (*published, edge.label.name.strip("/"))
            elif isinstance(edge.label, Ask):
                if values[flags.index(edge.label.variable)] not in edge.label.values:
                    continue
            elif isinstance(edge.label, Set):
                index = flags.index(edge.label.variable)
                if edge.label.before is not None and values[index] not in edge.label.before:
                    continue
                after = (*values[:index], edge.label.value, *values[index + 1 :])
            if len(done) < 8 and (edge.target, done, after) not in seen:
                seen.add((edge.target, done, after))
                todo.append((edge.target, done, after))
    return found


def all_states(real: Real, timers: int) -> set[State]:
    """Return the states of the flags between callbacks."""
    first = real.state()
    found, todo = {first}, [first]
    while todo:
        state = todo.pop()
        for index in range(timers):
            for _, after in real.runs(index, state):
                if after not in found:
                    found.add(after)
                    todo.append(after)
    return found


def written(
    seed: int, folder: Path, *, has_handlers: bool = False, has_matches: bool = False
) -> tuple[Writer, Real, Any]:
    """Write a program; return what it is by Python, and what the reader says of its node."""
    writer = Writer(seed, has_handlers=has_handlers, has_matches=has_matches)
    text = writer.program()
    (folder / "robot.py").write_text(text)
    read = coded([("", read_source(folder))], "src")
    return writer, Real(text, writer.flags), read


def flows_of(node: Any, writer: Writer) -> Iterator[tuple[int, Flow]]:
    for index in range(writer.timers):
        flow = node.callbacks[f"on_{index}"].flow
        if flow is not None:
            yield index, flow


@pytest.mark.parametrize(
    ("start", "has_matches"), [(0, False), (20, False), (40, False), (200, True), (220, True)]
)
def test_flows_do_what_python_does(tmp_path: Path, start: int, has_matches: bool) -> None:
    compared = 0
    for seed in range(start, start + 20):
        writer, real, read = written(seed, tmp_path, has_matches=has_matches)
        node = read.given.nodes["/robot"]
        known = node.variables
        values = {name: variable.values for name, variable in known.items()}
        flags = writer.flags
        for state in all_states(real, writer.timers):
            mine = [flag for flag in flags if flag in known]
            left = tuple(value for flag, value in zip(flags, state, strict=True) if flag in known)
            for index, flow in flows_of(node, writer):
                expected = {
                    (published, tuple(v for f, v in zip(flags, after, strict=True) if f in known))
                    for published, after in real.runs(index, state)
                }
                alone = narrowed(flow, values, list(known), keeps_waiting=True)
                for each in (flow, alone):
                    found = followed(each, mine, left)
                    assert {run for run in expected if len(run[0]) < 8} <= found, (seed, index, state)
                    compared += found == expected
    assert compared > 20


@pytest.mark.parametrize("start", range(100, 140, 20))
def test_exceptions_are_among_what_flows_do(tmp_path: Path, start: int) -> None:
    for seed in range(start, start + 20):
        writer, real, read = written(seed, tmp_path, has_handlers=True)
        node = read.given.nodes["/robot"]
        mine = [flag for flag in writer.flags if flag in node.variables]
        for state in all_states(real, writer.timers):
            left = tuple(v for f, v in zip(writer.flags, state, strict=True) if f in mine)
            for index, flow in flows_of(node, writer):
                found = followed(flow, mine, left)
                for published, after in real.runs(index, state):
                    end = tuple(v for f, v in zip(writer.flags, after, strict=True) if f in mine)
                    assert len(published) >= 8 or (published, end) in found, (seed, index, state)


def test_a_case_compares_the_value_before_the_guards_of_other_cases(tmp_path: Path) -> None:
    text = f"""{HEAD}        self.mode = 1
        self.create_timer(1.0, self.on_0)

    def helper(self):
        self.mode = 2
        return False

    def on_0(self):
        match self.mode:
            case 1 if self.helper():
                self.a.publish(String())
            case 2:
                self.b.publish(String())
        if self.mode == 2:
            self.mode = 1
{TAIL}"""
    (tmp_path / "robot.py").write_text(text)
    node = coded([("", read_source(tmp_path))], "src").given.nodes["/robot"]
    flow = node.callbacks["on_0"].flow
    assert flow is not None
    assert Real(text, ["mode"]).runs(0, ("1",)) == {((), ("1",))}
    assert ((), ("1",)) in followed(flow, ["mode"], ("1",))
