"""Random callbacks that give and compare whole numbers: what Python does is what their flows allow."""

from __future__ import annotations

import itertools
import types
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from dineros.observation.importing.coded import Coded, coded
from dineros.observation.importing.flows.labels import Answers, Deciding, Has, Label, Step
from dineros.observation.importing.flows.values import ANOTHER
from dineros.sources.reading import read_source
from tests.observation.importing.flows.test_answered import HEAD, TAIL
from tests.observation.importing.flows.test_random_answers import MOST_COINS, TOPICS, Client, Server, Trace
from tests.support.flow_runs import accepts

DEFINED = "---\nuint8 STATE_IDLE=0\nuint8 STATE_BUSY=1\nuint8 STATE_LOST=2\nuint8 state\n"
CONSTANTS = {"STATE_IDLE": 0, "STATE_BUSY": 1, "STATE_LOST": 2}
VALUES = (0, 1, 2, 5, 9)
"""Of the field, in runs."""
WRITTEN = [*(f"Ask.Response.{each}" for each in CONSTANTS), "5"]
NODE = """
from mode_msgs.srv import Ask

class Made(Node):
    def __init__(self):
        super().__init__("{name}")
        self.b = self.create_publisher(Empty, "{b}", 1)
        self.a = self.create_publisher(Empty, "{a}", 1)
        {port}
        {timer}

    def tick(self{parameters}):
{body}
"""
SERVES = NODE.replace("{port}", 'self.create_service(Ask, "ask", self.tick)').replace("{timer}", "")
CALLS = NODE.replace(
    "{port}", 'self.dock = self.create_client(Ask, "ask", callback_group=ReentrantCallbackGroup())'
).replace("{timer}", "self.create_timer(1.0, self.tick)")
STARTED = CALLS.replace("self.tick)", "self.start)").replace(
    "    def tick(self{parameters}):\n",
    "    def start(self):\n        self.dock.call_async(Ask.Request()).add_done_callback(self.tick)\n\n"
    "    def tick(self, future):\n        response = future.result()\n",
)
SERVER = "        response.state = Ask.Response.STATE_BUSY\n        return response"
CLIENT = "        if response.state == Ask.Response.STATE_BUSY:\n            self.a.publish(Empty())"


class Giver(Server):
    """Writes the callback of a service: it changes its response, or returns another one."""

    def statement(self, space: str, indent: int, depth: int) -> list[str]:
        found = super().statement(space, indent, depth)
        if found[0].strip().startswith("response.success"):
            value = self._random.choice([*WRITTEN, "self.unknown()"])
            if self._random.random() < 0.2:
                return [f"{space}return Ask.Response({self._random.choice(['', f'state={value}'])})"]
            return [f"{space}response.state = {value}"]
        return found


class Asker(Client):
    """Writes the callback of a client that compares a field with constants."""

    has_matches = True

    def test(self, depth: int = 2) -> str:
        found = super().test(depth)
        while ".success" in found:
            before, _, after = found.partition(".success")
            one, two = self._random.choice(WRITTEN), self._random.choice(WRITTEN)
            asked = [f"== {one}", f"!= {one}", f"in ({one}, {two})", f"not in [{one}]"]
            found = f"{before}.state {self._random.choice(asked)}{after}"
        return found

    def statement(self, space: str, indent: int, depth: int) -> list[str]:
        names = ["response"] if not self._calls else self._names
        if self.has_matches and depth and names and self._random.random() < 0.2:
            lines = [f"{space}match {self._random.choice(names)}.state:"]
            for _ in range(self._random.randint(1, 2)):
                one, two = self._random.choice(WRITTEN), self._random.choice(WRITTEN)
                lines.append(f"{space}    case {self._random.choice([one, f'{one} | {two}'])}:")
                lines += self.block(indent + 8, depth - 1)
            if self._random.random() < 0.5:
                lines += [f"{space}    case _:", *self.block(indent + 8, depth - 1)]
            return lines
        return [each.replace("Trigger", "Ask") for each in super().statement(space, indent, depth)]


def read(folder: Path, server: str = SERVER, client: str = CLIENT, kind: str = STARTED) -> Coded:
    """Return what a server and a client say."""
    (folder / "mode_msgs" / "srv").mkdir(parents=True)
    (folder / "mode_msgs" / "package.xml").write_text("<package><name>mode_msgs</name></package>")
    (folder / "mode_msgs" / "srv" / "Ask.srv").write_text(DEFINED)
    serves = SERVES.format(name="server", a="asked", b="served", body=server, parameters=", _, response")
    asks = kind.format(name="client", a="docked", b="alarm", body=client, parameters="")
    for name, text in (("server", serves), ("client", asks)):
        (folder / f"{name}.py").write_text(HEAD + text + TAIL)
    return coded([("", read_source(folder))], "code")


def runs_of(body: list[str], answers: tuple[int, ...], *, is_server: bool) -> set[Trace]:
    """Return what a callback does in each of its runs, when Python runs it."""
    found = set()
    for coins in itertools.product((0.0, 1.0), repeat=MOST_COINS):
        left, ready, done = list(coins), list(answers), list[object]()

        def port(name: str, done: list[object] = done) -> Any:
            return types.SimpleNamespace(publish=lambda _: done.append(name))

        def call(_: object, done: list[object] = done, ready: list[int] = ready) -> Any:
            done.append(ready[0])
            return types.SimpleNamespace(state=ready.pop(0))

        def flip(left: list[float] = left) -> float:
            return left.pop(0)

        class Response:
            STATE_IDLE, STATE_BUSY, STATE_LOST = CONSTANTS.values()

            def __init__(self, state: int = 0) -> None:
                self.state = state

        ask = types.SimpleNamespace(Request=lambda: None, Response=Response)
        names: dict[str, Any] = {"Empty": lambda: None, "Ask": ask}
        names["random"] = types.SimpleNamespace(random=flip)
        exec("\n".join(["def tick(self, response):", *body]), names)
        dock = types.SimpleNamespace(call=call)
        me = types.SimpleNamespace(a=port("a"), b=port("b"), dock=dock, unknown=lambda: 9)
        try:
            result = names["tick"](me, Response(answers[0]))
        except (IndexError, UnboundLocalError):
            continue  # it asked or called too often, or ended by an error
        found.add((*done, result.state) if is_server and result is not None else tuple(done))
    return found


def fitting(field: Deciding) -> Callable[[Label, object], bool]:
    """Return whether an edge leaves an entry: a text is of a topic, a number of a response."""

    def is_one(text: str | None, entry: int) -> bool:
        named = dict(zip(field.numbers, field.texts, strict=True))
        known = {number: each for number, each in named.items() if each != ANOTHER}
        return text is None or text == known.get(entry, ANOTHER)

    def fits(label: Label, entry: object) -> bool:
        if isinstance(label, Step) and label.verb == "publish":
            return label.name in TOPICS.get(str(entry), ())
        if not isinstance(entry, int):
            return False
        if isinstance(label, (Has, Answers)):
            return is_one(label.value, entry)
        return not isinstance(label, Step) or label.answer is None or is_one(label.answer[1], entry)

    return fits


def other(run: Trace) -> Trace:
    """Return a run with other numbers."""
    return tuple({0: 1, 1: 2, 2: 5, 5: 0}.get(each, each) if isinstance(each, int) else each for each in run)


def test_random_servers_do_what_their_branches_allow(tmp_path: Path) -> None:
    decided = refused = 0
    for seed in range(100):
        body = [*Giver(seed).block(8, 3), "        return response"]
        folder = tmp_path / str(seed)
        folder.mkdir()
        code = read(folder, "\n".join(body))
        flow = code.given.nodes["/server"].callbacks["/ask"].flow
        if flow is None:
            continue
        decided += 1
        fits = fitting(code.given.deciding["service /ask"])
        for value in (0, 9):  # what the response has before is open
            for each in runs_of(body, (value,), is_server=True):
                assert accepts(flow, each, fits), (seed, each, "\n".join(body))
                refused += not accepts(flow, other(each), fits)
    assert decided > 25
    assert refused > 25


@pytest.mark.parametrize("is_call", [True, False])
def test_random_clients_do_what_their_branches_allow(tmp_path: Path, is_call: bool) -> None:
    decided = refused = 0
    for seed in range(120):
        body = Asker(seed, calls=is_call).block(8, 3)
        if is_call and any("finally" in each for each in body):
            continue  # it may swallow that a response is missing, which no reader follows
        folder = tmp_path / str(seed)
        folder.mkdir()
        code = read(folder, client="\n".join(body), kind=CALLS if is_call else STARTED)
        flow = code.given.nodes["/client"].callbacks["tick" if is_call else "/ask"].flow
        if flow is None:
            continue
        decided += 1
        fits = fitting(code.given.deciding["service /ask"])
        for answers in itertools.product(VALUES, repeat=2 if is_call else 1):
            for each in runs_of(body, answers, is_server=False):
                run = each if is_call else (answers[0], *each)
                assert accepts(flow, run, fits), (seed, run, "\n".join(body))
                refused += not accepts(flow, other(run), fits)
    assert decided > 12
    assert refused > 25
