"""Random callbacks that give responses and ask them: what Python does is what their flows allow."""

from __future__ import annotations

import itertools
import types
from pathlib import Path
from typing import Any

import pytest

from dineros.observation.importing.flows.labels import Answers, Has, Label, Step
from tests.observation.importing.flows.test_answered import DONE, read
from tests.observation.importing.flows.test_received import Writer
from tests.support.flow_runs import accepts

MOST_COINS = 6
Trace = tuple[object, ...]


class Server(Writer):
    """Writes the callback of a service at random."""

    def test(self, depth: int = 2) -> str:
        return "random.random() < 0.5"

    def statement(self, space: str, indent: int, depth: int) -> list[str]:
        pick = self._random.random()
        if pick < 0.35:
            value = self._random.choice(["True", "False", "random.random() < 0.5"])
            return [f"{space}response.success = {value}"]
        found = super().statement(space, indent, depth)
        return [f"{each} response" if each.endswith("return") else each for each in found]


class Client(Writer):
    """Writes a callback of a client at random: `response` is its own, or that of its calls."""

    def __init__(self, seed: int, *, calls: bool) -> None:
        super().__init__(seed)
        self._calls = calls
        self._names: list[str] = [] if calls else ["response"]

    def test(self, depth: int = 2) -> str:
        found = super().test(depth)
        known = [f"{each}.success" for each in self._names] or ["random.random() < 0.5"]
        return found.replace("msg.data", self._random.choice(known))

    def statement(self, space: str, indent: int, depth: int) -> list[str]:
        if self._calls and self._random.random() < 0.3 and len(self._names) < 3:
            self._names.append(f"r{len(self._names)}")
            return [f"{space}{self._names[-1]} = self.dock.call(Trigger.Request())"]
        return super().statement(space, indent, depth)


def runs_of(body: list[str], answers: tuple[bool, ...], *, name: str) -> set[Trace]:
    """Return what a callback does in each of its runs, when Python runs it."""
    found = set()
    for coins in itertools.product((0.0, 1.0), repeat=MOST_COINS):
        left, ready, done = list(coins), list(answers), list[object]()

        def port(name: str, done: list[object] = done) -> Any:
            return types.SimpleNamespace(publish=lambda _: done.append(name))

        def call(_: object, done: list[object] = done, ready: list[bool] = ready) -> Any:
            done.append(ready[0])
            return types.SimpleNamespace(success=ready.pop(0))

        def flip(left: list[float] = left) -> float:
            return left.pop(0)

        trigger = types.SimpleNamespace(Request=lambda: None)
        names: dict[str, Any] = {"Empty": lambda: None, "Trigger": trigger}
        names["random"] = types.SimpleNamespace(random=flip)
        exec("\n".join([f"def tick(self, {name}):", *body]), names)
        me = types.SimpleNamespace(a=port("a"), b=port("b"), dock=types.SimpleNamespace(call=call))
        own = types.SimpleNamespace(success=answers[0])
        try:
            result = names["tick"](me, own)
        except (IndexError, UnboundLocalError):
            continue  # it asked or called too often, or ended by an error
        found.add((*done, result.success) if name == "response" and result is not None else tuple(done))
    return found


TOPICS = {"a": ("/asked", "/docked"), "b": ("/served", "/alarm")}
"""Topics for each letter of a run; a program has one of the two."""


def fits(label: Label, entry: object) -> bool:
    """Return whether an edge leaves an entry: a text is of a topic, a truth value of an answer."""
    if isinstance(label, Step) and label.verb == "publish":
        return label.name in TOPICS.get(str(entry), ())
    if not isinstance(entry, bool):
        return False
    text = str(entry).lower()
    if isinstance(label, (Has, Answers)):
        return label.value in (None, text)
    return not isinstance(label, Step) or label.answer in (None, ("success", text))


def flipped(run: Trace) -> Trace:
    return tuple(not each if isinstance(each, bool) else each for each in run)


def test_random_servers_do_what_their_branches_allow(tmp_path: Path) -> None:
    decided = refused = 0
    for seed in range(150):
        body = [*Server(seed).block(8, 3), "        return response"]
        folder = tmp_path / str(seed)
        folder.mkdir()
        flow = read(folder, "\n".join(body)).given.nodes["/server"].callbacks["/dock"].flow
        if flow is None:
            continue
        decided += 1
        for value in (True, False):  # what the response has before is open
            for each in runs_of(body, (value,), name="response"):
                assert accepts(flow, each, fits), (seed, each, "\n".join(body))
                refused += not accepts(flow, flipped(each), fits)
    assert decided > 40
    assert refused > 40


@pytest.mark.parametrize("is_call", [True, False])
def test_random_clients_do_what_their_branches_allow(tmp_path: Path, is_call: bool) -> None:
    decided = refused = 0
    for seed in range(120):
        body = Client(seed, calls=is_call).block(8, 3)
        if is_call and any("finally" in each for each in body):
            continue  # it may swallow that a response is missing, which no reader follows
        folder = tmp_path / str(seed)
        folder.mkdir()
        text = "\n    def tick(self):\n" + "\n".join(body)
        if not is_call:
            text = DONE[: DONE.index("        if")] + "\n".join(body)
        callbacks = read(folder, client=f"{text}\n").given.nodes["/client"].callbacks
        flow = callbacks["tick" if is_call else "/dock"].flow
        if flow is None:
            continue
        decided += 1
        for answers in itertools.product((True, False), repeat=3 if is_call else 1):
            for each in runs_of(body, answers, name="_" if is_call else "response"):
                run = each if is_call else (answers[0], *each)
                assert accepts(flow, run, fits), (seed, run, "\n".join(body))
                refused += not accepts(flow, flipped(run), fits)
    assert decided > 25
    assert refused > 25
