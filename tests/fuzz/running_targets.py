"""What a running node takes from strangers: journals, messages, payloads, requests, a page's queries."""

from __future__ import annotations

import asyncio
import contextlib
import json
import logging
import shutil
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from urllib.parse import unquote

from tests.fuzz import seeds
from tests.fuzz.judging import Outcome, refused_or, run_command

Attempt = Callable[[bytes], Outcome]


def journal(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Resume a run from a damaged journal."""
    run = seeds.traces(folder)
    files = sorted(run.glob("*.jsonl"))
    work = folder / "work"

    def attempt(content: bytes) -> Outcome:
        shutil.rmtree(work, ignore_errors=True)
        shutil.copytree(run, work)
        node = next((path for path in files if path.stem.encode() in content[:300]), files[0])
        (work / node.name).write_bytes(content)
        return run_command(
            *("run", folder / "kitchen.sym.xmi", "--simulate", "--resume", "--seed", "1"),
            *("--trace", work, "--timeout", "2"),
        )

    return [path.read_bytes() for path in files], attempt


class _Lines(logging.Handler):
    """Counts what a log gets, and keeps stack traces."""

    def __init__(self) -> None:
        super().__init__()
        self.faults: list[str] = []

    def emit(self, record: logging.LogRecord) -> None:
        text = record.getMessage()
        if record.exc_info or "\n" in text or len(text) > 20_000 or "Traceback" in text:
            self.faults.append(f"{text[:500]} {record.exc_info}")


@contextlib.contextmanager
def _judged_log() -> Iterator[None]:
    """Let nothing into the log but short lines without a stack trace."""
    lines = _Lines()
    log = logging.getLogger("dineros")
    former = log.propagate
    log.propagate = False
    log.addHandler(lines)
    try:
        yield
    finally:
        log.removeHandler(lines)
        log.propagate = former
    assert lines.faults == []


def message(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Let a message arrive at a subscriber, a server and a client, which then must take a good one."""
    from dineros.metamodel.json_text import decode_json
    from dineros.runtime import Net, Node
    from dineros.runtime.channels.local import LocalNetwork
    from dineros.runtime.nets.ports import Message
    from dineros.transformations.flattening.split import split
    from tests.generators.models import kitchen

    parts = {str(part.node.id): part for part in split(kitchen())}
    net, server_net = Net(parts["board"]), Net(parts["cook"])
    board, cook = (Node(each, LocalNetwork().transport()) for each in (net, server_net))
    for node in (board, cook):
        node.open()
        ending.callback(node.close)
    count = 0

    def attempt(content: bytes) -> Outcome:
        nonlocal count

        def work() -> None:
            nonlocal count
            found = decode_json(content)
            found = found if isinstance(found, dict) else {"id": "", "data": found}
            id, data, lost = str(found.get("id", "")), found.get("data"), found.get("lost")
            whole = data if isinstance(data, dict) else {}
            arrived = Message(id, whole)
            board.receiver.message_arrived(
                net.structure.ports.subscribers[0], arrived, lost % 1000 if isinstance(lost, int) else 0
            )
            cook.receiver.request_arrived(server_net.structure.ports.servers[0], arrived, lambda answer: None)
            count += 1
            good = Message(f"tester/Served/{count}", {"dish": "soup"})
            before = net.count("Kept")
            board.run_until_idle()
            cook.run_until_idle()
            between = net.count("Kept")
            assert between <= before + 1
            board.receiver.message_arrived(net.structure.ports.subscribers[0], good, 0)
            board.run_until_idle()
            assert net.count("Kept") == between + 1, "a good message is not taken"

        with _judged_log():
            return refused_or(work)

    return seeds.MESSAGES, attempt


def announcement(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Read what is announced of a message of an existing ROS type."""
    from dineros.runtime.ros.channels.companions import read_announcement

    def attempt(content: bytes) -> Outcome:
        return refused_or(lambda: read_announcement(content.decode("utf-8", "replace")))

    return seeds.ANNOUNCEMENTS, attempt


def payload(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Read a payload of a bridge, and hand it to the one for MQTT as its client does."""
    from dineros.runtime.bridges.mqtt import MqttSignals
    from dineros.runtime.bridges.values import read_signals, read_truth

    net = _net(ending)
    bridge = MqttSignals(net)
    bridge._source = net.new_source("mqtt")

    def attempt(content: bytes) -> Outcome:
        for topic in ("talker/signals/Button", "talker/signals"):
            bridge._heard(None, None, SimpleNamespace(topic=topic, payload=content))
        assert bridge._source is not None
        assert bridge._source.state.failures == 0
        outcomes = [refused_or(lambda read=read: read(content)) for read in (read_truth, read_signals)]  # type: ignore[misc]
        return min(outcomes, key=lambda outcome: outcome.status)

    return seeds.PAYLOADS, attempt


def mqtt(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Publish a payload through a real broker; a good one after it must still set the signal."""
    from dineros.runtime.bridges.mqtt import MqttSignals
    from tests.runtime.bridges.broker import PATIENCE, Broker

    net = _net(ending)
    broker = Broker(folder)
    ending.callback(broker.stop)
    bridge = ending.enter_context(MqttSignals(net, port=broker.port))
    assert bridge.wait(PATIENCE)

    def attempt(content: bytes) -> Outcome:
        (before,) = net.inspect().sources
        broker.publish("talker/signals/Button", content)
        for value in (True, False):
            broker.publish("talker/signals/Button", str(value))
            net.wait_for(lambda state, value=value: state.signals["Button"] == value, PATIENCE)
        (state,) = net.inspect().sources
        assert state.failures == 0
        return Outcome(0 if state.refused == before.refused else 2, str(state.last_error))

    return seeds.PAYLOADS, attempt


def rest_request(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask the web server for signals, as uvicorn hands requests over."""
    from dineros.runtime.bridges.rest_server import signals_app

    app: Any = signals_app(_net(ending), token="t")

    def attempt(content: bytes) -> Outcome:
        head, _, body = content.partition(b"\n\n")
        first, *lines = head.split(b"\n")
        method, path, *_ = [*first.split(b" "), b"/", b"/"]
        headers = [
            (name.strip().lower(), value.strip())
            for name, _, value in (line.partition(b":") for line in lines)
        ]
        if not any(name == b"authorization" for name, _ in headers):
            headers.append((b"authorization", b"Bearer t"))
        scope = _scope("http", path, headers) | {"method": method.decode("latin-1")}
        status = asyncio.run(_asked(app, scope, body))
        assert status < 500, status
        return Outcome(0 if status < 400 else 2, f"{status}\n")

    return seeds.REQUESTS, attempt


def live_page(folder: Path, ending: ExitStack) -> tuple[Sequence[bytes], Attempt]:
    """Ask the live page's server for the page and for changes."""
    from dineros.views.live.following import LiveTrace, source_of
    from dineros.views.live.serving import LivePages, application
    from dineros.views.serving.entrance import Entrance

    pages = LivePages(LiveTrace(source_of(seeds.witness(folder)), None, "run"), None)
    app = application(pages, Entrance("TOKEN", 80))
    headers = [(b"host", b"127.0.0.1:80"), (b"origin", b"http://127.0.0.1:80")]

    def attempt(content: bytes) -> Outcome:
        path = b"/changes" if b"number" in content or b"epoch" in content else b"/"
        with _judged_log():
            for type in ("http", "websocket"):
                scope = _scope(type, path + b"?" + content, headers)
                status = asyncio.run(_asked(app, scope | {"method": "GET", "subprotocols": []}, b""))
        return Outcome(0 if status < 400 else 2, f"{status}\n")

    return seeds.QUERIES, attempt


def _net(ending: ExitStack) -> Any:
    from dineros.runtime import Net
    from dineros.transformations.flattening.split import split
    from tests.support.systems.talker import talker

    (part,) = (part for part in split(talker()) if part.node.id == "talker")
    return ending.enter_context(Net(part))


def _scope(type: str, target: bytes, headers: list[tuple[bytes, bytes]]) -> dict[str, Any]:
    path, _, query = target.partition(b"?")
    return {
        "type": type,
        "asgi": {"version": "3.0"},
        "http_version": "1.1",
        "scheme": "http" if type == "http" else "ws",
        "path": unquote(path.decode("latin-1")),
        "raw_path": path,
        "root_path": "",
        "query_string": query,
        "headers": headers,
        "client": ("127.0.0.1", 50000),
        "server": ("127.0.0.1", 80),
    }


async def _asked(app: Any, scope: dict[str, Any], body: bytes) -> int:
    """Return the status of the answer, 101 where a stream began; whoever asked then goes away."""
    is_http = scope["type"] == "http"
    first = {"type": "http.request", "body": body} if is_http else {"type": "websocket.connect"}
    waiting: list[dict[str, Any]] = [first]
    status = 0
    gone = asyncio.Event()

    async def receive() -> dict[str, Any]:
        if waiting:
            return waiting.pop()
        await gone.wait()
        return {"type": "http.disconnect" if is_http else "websocket.disconnect", "code": 1006}

    async def send(said: dict[str, Any]) -> None:
        nonlocal status
        match said["type"]:
            case "http.response.start" | "websocket.http.response.start":
                status = said["status"]
            case "websocket.accept":
                status = 101
            case "websocket.send":
                json.loads(said["text"])
                gone.set()
            case "websocket.close":
                status = said["code"]
                gone.set()

    await asyncio.wait_for(app(scope, receive, send), 30)
    return status
